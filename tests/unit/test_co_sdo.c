/* SPDX-License-Identifier: MIT */
/*
 * SDO server: expedited and segmented transfers, aborts, timeouts, delayed answers. The frames are
 * written by hand from CiA 301; block transfers are in test_co_block.c.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "sdo_rig.h"

#define SAVE_NS DG_MS(14)

static struct sdo_rig rig;

static int set_up(void **state)
{
    (void)state;
    sdo_rig_init(&rig);
    return 0;
}

/* ---- expedited */

static void expedited_uploads(void **state)
{
    static const struct sdo_rig_step steps[] = {
        {"40 00 10 00 00 00 00 00", "43 00 10 00 96 01 02 00"},
        {"40 01 10 00 00 00 00 00", "4F 01 10 00 00 00 00 00"},
        {"40 0C 10 00 00 00 00 00", "4B 0C 10 00 00 00 00 00"},
        {"40 18 10 00 00 00 00 00", "4F 18 10 00 04 00 00 00"},
        {"40 18 10 01 00 00 00 00", "43 18 10 01 13 00 00 00"},
        {"40 18 10 02 00 00 00 00", "43 18 10 02 01 20 68 56"},
        {"40 18 10 04 00 00 00 00", "43 18 10 04 D2 02 96 49"}, /* 1234567890 */
        {"40 14 10 00 00 00 00 00", "43 14 10 00 BF 00 00 00"},
        {"40 07 20 00 00 00 00 00", "4F 07 20 00 01 00 00 00"},
        {"40 11 20 00 00 00 00 00", "43 11 20 00 31 2E 30 38"}, /* text of 4 */
        {"5F 00 10 00 FF FF FF FF", "43 00 10 00 96 01 02 00"}, /* reserved bits and bytes */
    };

    (void)state;
    sdo_rig_play(&rig, steps, DG_COUNT(steps));
}

static void expedited_downloads_of_every_type(void **state)
{
    static const struct {
        const char *write;
        const char *confirm;
        const char *read;
        const char *back;
        uint8_t slot;
        uint32_t value;
    } rows[] = {
        {"2F 01 20 00 9C 00 00 00", "60 01 20 00 00 00 00 00", "40 01 20 00 00 00 00 00",
         "4F 01 20 00 9C 00 00 00", SDO_RIG_I8, (uint32_t)-100},
        {"2F 01 20 00 64 FF FF FF", "60 01 20 00 00 00 00 00", "40 01 20 00 00 00 00 00",
         "4F 01 20 00 64 00 00 00", SDO_RIG_I8, 100},
        {"2B 02 20 00 18 FC 00 00", "60 02 20 00 00 00 00 00", "40 02 20 00 00 00 00 00",
         "4B 02 20 00 18 FC 00 00", SDO_RIG_I16, (uint32_t)-1000},
        {"23 03 20 00 60 79 FE FF", "60 03 20 00 00 00 00 00", "40 03 20 00 00 00 00 00",
         "43 03 20 00 60 79 FE FF", SDO_RIG_I32, (uint32_t)-100000},
        {"2F 04 20 00 FE 11 22 33", "60 04 20 00 00 00 00 00", "40 04 20 00 00 00 00 00",
         "4F 04 20 00 FE 00 00 00", SDO_RIG_U8, 0xFE},
        {"2B 05 20 00 34 F2 55 66", "60 05 20 00 00 00 00 00", "40 05 20 00 00 00 00 00",
         "4B 05 20 00 34 F2 00 00", SDO_RIG_U16, 0xF234},
        {"23 06 20 00 78 56 34 F2", "60 06 20 00 00 00 00 00", "40 06 20 00 00 00 00 00",
         "43 06 20 00 78 56 34 F2", SDO_RIG_U32, 0xF2345678},
        {"23 07 20 01 04 03 02 01", "60 07 20 01 00 00 00 00", "40 07 20 01 00 00 00 00",
         "43 07 20 01 04 03 02 01", SDO_RIG_ARRAY, 0x01020304},
        /* 22h does not say the size: the object's */
        {"22 01 20 00 FF 00 00 00", "60 01 20 00 00 00 00 00", "40 01 20 00 00 00 00 00",
         "4F 01 20 00 FF 00 00 00", SDO_RIG_I8, (uint32_t)-1},
        {"22 05 20 00 CD AB 00 00", "60 05 20 00 00 00 00 00", "40 05 20 00 00 00 00 00",
         "4B 05 20 00 CD AB 00 00", SDO_RIG_U16, 0xABCD},
        {"22 06 20 00 EF BE AD DE", "60 06 20 00 00 00 00 00", "40 06 20 00 00 00 00 00",
         "43 06 20 00 EF BE AD DE", SDO_RIG_U32, 0xDEADBEEF},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        sdo_rig_ask(&rig, rows[i].write, rows[i].confirm);
        assert_int_equal(rig.node.value[rows[i].slot], rows[i].value);
        sdo_rig_ask(&rig, rows[i].read, rows[i].back);
    }
    sdo_rig_ask(&rig, "23 08 20 00 01 00 00 00", "60 08 20 00 00 00 00 00");
    assert_int_equal(rig.node.value[SDO_RIG_WRITE_ONLY], 1);
}

static void one_sample_for_each_read_of_the_device(void **state)
{
    (void)state;
    sdo_rig_ask(&rig, "40 00 10 00 00 00 00 00", "43 00 10 00 96 01 02 00");
    assert_int_equal(rig.samples, 0);
    sdo_rig_ask(&rig, "40 00 20 00 00 00 00 00", "4B 00 20 00 01 00 00 00");
    sdo_rig_ask(&rig, "40 00 20 00 00 00 00 00", "4B 00 20 00 02 00 00 00");
    sdo_rig_ask(&rig, "A4 00 20 00 7F 00 00 00", "C6 00 20 00 02 00 00 00");
    sdo_rig_ask(&rig, "A3 00 00 00 00 00 00 00", "81 03 00 00 00 00 00 00");
    assert_int_equal(rig.samples, 3);
    sdo_rig_ask(&rig, "40 07 20 00 00 00 00 00", "4F 07 20 00 01 00 00 00"); /* a constant */
    assert_int_equal(rig.samples, 3);
}

/* ---- access errors */

static const struct sdo_rig_step refused[] = {
    /* no such object, for every kind of transfer */
    {"40 00 30 00 00 00 00 00", "80 00 30 00 00 00 02 06"},
    {"40 FF 0F 00 00 00 00 00", "80 FF 0F 00 00 00 02 06"},
    {"40 FF FF FF 00 00 00 00", "80 FF FF FF 00 00 02 06"},
    {"23 00 30 00 00 00 00 00", "80 00 30 00 00 00 02 06"},
    {"21 00 30 00 04 00 00 00", "80 00 30 00 00 00 02 06"},
    {"A4 00 30 00 7F 00 00 00", "80 00 30 00 00 00 02 06"},
    {"C6 00 30 00 04 00 00 00", "80 00 30 00 00 00 02 06"},
    /* no such sub-index */
    {"40 18 10 05 00 00 00 00", "80 18 10 05 11 00 09 06"},
    {"40 00 10 01 00 00 00 00", "80 00 10 01 11 00 09 06"},
    {"40 00 18 04 00 00 00 00", "80 00 18 04 11 00 09 06"},
    {"23 07 20 02 00 00 00 00", "80 07 20 02 11 00 09 06"},
    {"C6 07 20 02 04 00 00 00", "80 07 20 02 11 00 09 06"},
    /* read of write-only, write of read-only */
    {"40 08 20 00 00 00 00 00", "80 08 20 00 01 00 01 06"},
    {"A4 08 20 00 7F 00 00 00", "80 08 20 00 01 00 01 06"},
    {"23 00 10 00 00 00 00 00", "80 00 10 00 02 00 01 06"},
    {"21 00 10 00 04 00 00 00", "80 00 10 00 02 00 01 06"},
    {"C6 00 10 00 04 00 00 00", "80 00 10 00 02 00 01 06"},
    {"2F 00 10 00 00 00 00 00", "80 00 10 00 02 00 01 06"}, /* before the length */
    {"22 08 10 00 41 42 43 44", "80 08 10 00 02 00 01 06"}, /* a text */
    /* length */
    {"2F 05 20 00 00 00 00 00", "80 05 20 00 13 00 07 06"},
    {"2B 06 20 00 00 00 00 00", "80 06 20 00 13 00 07 06"},
    {"27 06 20 00 00 00 00 00", "80 06 20 00 13 00 07 06"},
    {"2B 04 20 00 00 00 00 00", "80 04 20 00 12 00 07 06"},
    {"27 05 20 00 00 00 00 00", "80 05 20 00 12 00 07 06"},
    {"23 05 20 00 00 00 00 00", "80 05 20 00 12 00 07 06"},
    {"21 06 20 00 03 00 00 00", "80 06 20 00 13 00 07 06"},
    {"21 06 20 00 00 00 00 00", "80 06 20 00 13 00 07 06"},
    {"21 06 20 00 05 00 00 00", "80 06 20 00 12 00 07 06"},
    {"21 06 20 00 04 00 00 80", "80 06 20 00 12 00 07 06"},
    {"C6 06 20 00 03 00 00 00", "80 06 20 00 13 00 07 06"},
    {"C6 06 20 00 04 01 00 00", "80 06 20 00 12 00 07 06"},
    /* range */
    {"2F 01 20 00 9B 00 00 00", "80 01 20 00 30 00 09 06"},
    {"2F 01 20 00 65 00 00 00", "80 01 20 00 30 00 09 06"},
    {"2B 02 20 00 17 FC 00 00", "80 02 20 00 30 00 09 06"},
    {"23 03 20 00 5F 79 FE FF", "80 03 20 00 30 00 09 06"},
    /* the object's own */
    {"40 0B 20 00 00 00 00 00", "80 0B 20 00 24 00 00 08"},
    {"A4 0B 20 00 7F 00 00 00", "80 0B 20 00 24 00 00 08"},
    {"40 03 10 01 00 00 00 00", "80 03 10 01 24 00 00 08"},
    {"2F 03 10 00 01 00 00 00", "80 03 10 00 30 00 09 06"},
    {"23 10 10 01 77 72 6F 6E", "80 10 10 01 20 00 00 08"},
    {"23 0A 20 00 43 00 04 06", "80 0A 20 00 43 00 04 06"},
    {"23 0A 20 00 22 00 00 08", "80 0A 20 00 22 00 00 08"},
    {"23 0A 20 00 00 00 06 06", "80 0A 20 00 00 00 06 06"},
    /* unknown command: that of the request, as no transfer runs */
    {"E0 00 10 00 00 00 00 00", "80 00 10 00 01 00 04 05"},
    {"FF 18 10 01 00 00 00 00", "80 18 10 01 01 00 04 05"},
    {"81 00 10 00 00 00 00 00", "80 00 10 00 01 00 04 05"},
    /* continuations of nothing */
    {"00 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"},
    {"10 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"},
    {"60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"},
    {"70 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"},
    {"A1 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"},
    {"A2 01 7F 00 00 00 00 00", "80 01 7F 00 01 00 04 05"},
    {"A3 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"},
    {"C1 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"},
};

static void every_refusal_has_its_code(void **state)
{
    uint32_t before[DG_CO_VALUES_MAX];

    (void)state;
    memcpy(before, rig.node.value, sizeof before);
    sdo_rig_play(&rig, refused, DG_COUNT(refused));
    sdo_rig_wait(&rig, DG_S(3));
    sdo_rig_expect(&rig, "");
    assert_memory_equal(before, rig.node.value, sizeof before);
    assert_int_equal(rig.node.counters.malformed, 0);
}

/* ---- segmented */

static const struct sdo_rig_step upload_empty[] = {
    {"40 10 20 00 00 00 00 00", "41 10 20 00 00 00 00 00"},
    {"60 00 00 00 00 00 00 00", "0F 00 00 00 00 00 00 00"},
};
static const struct sdo_rig_step upload_5[] = {
    {"40 12 20 00 00 00 00 00", "41 12 20 00 05 00 00 00"},
    {"60 00 00 00 00 00 00 00", "05 46 33 36 36 38 00 00"},
};
static const struct sdo_rig_step upload_7[] = {
    {"40 13 20 00 00 00 00 00", "41 13 20 00 07 00 00 00"},
    {"60 00 00 00 00 00 00 00", "01 31 32 33 34 35 36 37"},
};
static const struct sdo_rig_step upload_8[] = {
    {"40 14 20 00 00 00 00 00", "41 14 20 00 08 00 00 00"},
    {"60 00 00 00 00 00 00 00", "00 31 32 33 34 35 36 37"},
    {"70 00 00 00 00 00 00 00", "1D 38 00 00 00 00 00 00"},
};
static const struct sdo_rig_step upload_14[] = {
    {"40 16 20 00 00 00 00 00", "41 16 20 00 0E 00 00 00"},
    {"60 00 00 00 00 00 00 00", "00 41 42 43 44 45 46 47"},
    {"70 00 00 00 00 00 00 00", "11 48 49 4A 4B 4C 4D 4E"},
};
static const struct sdo_rig_step upload_32[] = {
    {"40 17 20 00 00 00 00 00", "41 17 20 00 20 00 00 00"},
    {"60 00 00 00 00 00 00 00", "00 30 31 32 33 34 35 36"},
    {"70 00 00 00 00 00 00 00", "10 37 38 39 41 42 43 44"},
    {"60 00 00 00 00 00 00 00", "00 45 46 47 48 49 4A 4B"},
    {"70 00 00 00 00 00 00 00", "10 4C 4D 4E 4F 50 51 52"},
    {"60 00 00 00 00 00 00 00", "07 53 54 55 56 00 00 00"},
};
/* Longer than a text may be: cut off. */
static const struct sdo_rig_step upload_46[] = {
    {"40 18 20 00 00 00 00 00", "41 18 20 00 20 00 00 00"},
    {"60 00 00 00 00 00 00 00", "00 30 31 32 33 34 35 36"},
    {"70 00 00 00 00 00 00 00", "10 37 38 39 41 42 43 44"},
    {"60 00 00 00 00 00 00 00", "00 45 46 47 48 49 4A 4B"},
    {"70 00 00 00 00 00 00 00", "10 4C 4D 4E 4F 50 51 52"},
    {"60 00 00 00 00 00 00 00", "07 53 54 55 56 00 00 00"},
};
static const struct sdo_rig_step download_4[] = {
    {"21 06 20 00 04 00 00 00", "60 06 20 00 00 00 00 00"},
    {"07 78 56 34 12 FF FF FF", "20 00 00 00 00 00 00 00"},
};
/* Without a size, a byte a segment, one segment empty. */
static const struct sdo_rig_step download_bytes[] = {
    {"20 06 20 00 00 00 00 00", "60 06 20 00 00 00 00 00"},
    {"0C 78 00 00 00 00 00 00", "20 00 00 00 00 00 00 00"},
    {"1C 56 00 00 00 00 00 00", "30 00 00 00 00 00 00 00"},
    {"0E 00 00 00 00 00 00 00", "20 00 00 00 00 00 00 00"},
    {"1C 34 00 00 00 00 00 00", "30 00 00 00 00 00 00 00"},
    {"0D 12 00 00 00 00 00 00", "20 00 00 00 00 00 00 00"},
};
static const struct sdo_rig_step download_negative[] = {
    {"21 01 20 00 01 00 00 00", "60 01 20 00 00 00 00 00"},
    {"0D FE 7F 7F 7F 7F 7F 7F", "20 00 00 00 00 00 00 00"},
};

static const struct {
    const struct sdo_rig_step *steps;
    size_t n;
} transfers[] = {
    {upload_empty, DG_COUNT(upload_empty)},
    {upload_5, DG_COUNT(upload_5)},
    {upload_7, DG_COUNT(upload_7)},
    {upload_8, DG_COUNT(upload_8)},
    {upload_14, DG_COUNT(upload_14)},
    {upload_32, DG_COUNT(upload_32)},
    {upload_46, DG_COUNT(upload_46)},
    {download_4, DG_COUNT(download_4)},
    {download_bytes, DG_COUNT(download_bytes)},
    {download_negative, DG_COUNT(download_negative)},
};

static void segmented_transfers(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(transfers); i++) {
        sdo_rig_play(&rig, transfers[i].steps, transfers[i].n);
        assert_int_equal(rig.node.sdo.state, DG_CO_SDO_IDLE);
    }
}

static void segmented_downloads_arrive_with_the_last_segment(void **state)
{
    (void)state;
    sdo_rig_play(&rig, download_4, DG_COUNT(download_4) - 1u);
    assert_int_equal(rig.node.value[SDO_RIG_U32], 0);
    sdo_rig_play(&rig, &download_4[1], 1);
    assert_int_equal(rig.node.value[SDO_RIG_U32], 0x12345678);
    rig.node.value[SDO_RIG_U32] = 0;
    sdo_rig_play(&rig, download_bytes, DG_COUNT(download_bytes) - 1u);
    assert_int_equal(rig.node.value[SDO_RIG_U32], 0);
    sdo_rig_play(&rig, &download_bytes[DG_COUNT(download_bytes) - 1u], 1);
    assert_int_equal(rig.node.value[SDO_RIG_U32], 0x12345678);
    sdo_rig_play(&rig, download_negative, DG_COUNT(download_negative));
    assert_int_equal(rig.node.value[SDO_RIG_I8], (uint32_t)-2);
}

static void disturbed_at_every_frame(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(transfers); i++) {
        sdo_rig_disturb(&rig, transfers[i].steps, transfers[i].n);
    }
}

static void an_interrupted_download_writes_nothing(void **state)
{
    (void)state;
    sdo_rig_play(&rig, download_bytes, DG_COUNT(download_bytes) - 1u);
    sdo_rig_play(&rig, upload_5, DG_COUNT(upload_5));
    sdo_rig_ask(&rig, "0D 12 00 00 00 00 00 00", "80 12 00 00 01 00 04 05");
    assert_int_equal(rig.node.value[SDO_RIG_U32], 0);
}

/* After these, a transfer is over: a right continuation is one of nothing. */
static const struct {
    struct sdo_rig_step steps[3];
    size_t n;
} broken[] = {
    /* toggle */
    {{{"40 17 20 00 00 00 00 00", "41 17 20 00 20 00 00 00"},
      {"70 00 00 00 00 00 00 00", "80 17 20 00 00 00 03 05"}},
     2},
    {{{"40 17 20 00 00 00 00 00", "41 17 20 00 20 00 00 00"},
      {"60 00 00 00 00 00 00 00", "00 30 31 32 33 34 35 36"},
      {"60 00 00 00 00 00 00 00", "80 17 20 00 00 00 03 05"}},
     3},
    {{{"21 07 20 01 04 00 00 00", "60 07 20 01 00 00 00 00"},
      {"17 78 56 34 12 00 00 00", "80 07 20 01 00 00 03 05"}},
     2},
    {{{"21 07 20 01 04 00 00 00", "60 07 20 01 00 00 00 00"},
      {"0C 78 00 00 00 00 00 00", "20 00 00 00 00 00 00 00"},
      {"09 56 34 12 00 00 00 00", "80 07 20 01 00 00 03 05"}},
     3},
    /* not the announced size */
    {{{"21 07 20 01 04 00 00 00", "60 07 20 01 00 00 00 00"},
      {"09 78 56 34 00 00 00 00", "80 07 20 01 10 00 07 06"}},
     2},
    {{{"21 07 20 01 04 00 00 00", "60 07 20 01 00 00 00 00"},
      {"05 78 56 34 12 00 00 00", "80 07 20 01 10 00 07 06"}},
     2},
    {{{"21 07 20 01 04 00 00 00", "60 07 20 01 00 00 00 00"},
      {"06 78 56 34 12 00 00 00", "20 00 00 00 00 00 00 00"},
      {"1C 78 00 00 00 00 00 00", "80 07 20 01 10 00 07 06"}},
     3},
    /* not the object's size */
    {{{"20 07 20 01 00 00 00 00", "60 07 20 01 00 00 00 00"},
      {"09 78 56 34 00 00 00 00", "80 07 20 01 13 00 07 06"}},
     2},
    {{{"20 07 20 01 00 00 00 00", "60 07 20 01 00 00 00 00"},
      {"0F 00 00 00 00 00 00 00", "80 07 20 01 13 00 07 06"}},
     2},
    {{{"20 07 20 01 00 00 00 00", "60 07 20 01 00 00 00 00"},
      {"05 78 56 34 12 00 00 00", "80 07 20 01 12 00 07 06"}},
     2},
    {{{"20 07 20 01 00 00 00 00", "60 07 20 01 00 00 00 00"},
      {"00 78 56 34 12 00 00 00", "80 07 20 01 12 00 07 06"}},
     2},
    /* refused by the object at the end */
    {{{"21 01 20 00 01 00 00 00", "60 01 20 00 00 00 00 00"},
      {"0D 9B 00 00 00 00 00 00", "80 01 20 00 30 00 09 06"}},
     2},
    {{{"21 0A 20 00 04 00 00 00", "60 0A 20 00 00 00 00 00"},
      {"07 47 00 04 06 00 00 00", "80 0A 20 00 47 00 04 06"}},
     2},
    /* unknown, or of another kind of transfer */
    {{{"40 17 20 00 00 00 00 00", "41 17 20 00 20 00 00 00"},
      {"E0 00 10 00 00 00 00 00", "80 17 20 00 01 00 04 05"}},
     2},
    {{{"40 17 20 00 00 00 00 00", "41 17 20 00 20 00 00 00"},
      {"00 00 00 00 00 00 00 00", "80 17 20 00 01 00 04 05"}},
     2},
    {{{"40 17 20 00 00 00 00 00", "41 17 20 00 20 00 00 00"},
      {"A3 00 00 00 00 00 00 00", "80 17 20 00 01 00 04 05"}},
     2},
    {{{"21 07 20 01 04 00 00 00", "60 07 20 01 00 00 00 00"},
      {"60 00 00 00 00 00 00 00", "80 07 20 01 01 00 04 05"}},
     2},
    {{{"21 07 20 01 04 00 00 00", "60 07 20 01 00 00 00 00"},
      {"C1 00 00 00 00 00 00 00", "80 07 20 01 01 00 04 05"}},
     2},
};

static void a_broken_transfer_is_over(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(broken); i++) {
        sdo_rig_play(&rig, broken[i].steps, broken[i].n);
        sdo_rig_ask(&rig, "60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
        sdo_rig_ask(&rig, "07 78 56 34 12 00 00 00", "80 78 56 34 01 00 04 05");
        sdo_rig_wait(&rig, DG_S(3));
        sdo_rig_expect(&rig, "");
    }
    assert_int_equal(rig.node.value[SDO_RIG_ARRAY], 0);
    assert_int_equal(rig.node.value[SDO_RIG_I8], 0);
}

/* ---- frames that are none */

static void short_frames_are_counted(void **state)
{
    static const char *const frames[] = {
        "",
        "40",
        "40 00",
        "40 00 10",
        "40 00 10 00",
        "40 00 10 00 00",
        "40 00 10 00 00 00",
        "40 00 10 00 00 00 00",
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(frames); i++) {
        sdo_rig_ask(&rig, frames[i], "");
        assert_int_equal(rig.node.counters.malformed, i + 1u);
    }
}

static void an_abort_without_a_transfer_is_silent(void **state)
{
    (void)state;
    sdo_rig_ask(&rig, "80 00 10 00 00 00 04 05", "");
    sdo_rig_wait(&rig, DG_S(3));
    sdo_rig_expect(&rig, "");
}

static void nothing_is_answered_in_stopped(void **state)
{
    (void)state;
    sdo_rig_play(&rig, upload_32, 2);
    sdo_rig_receive(&rig, 0, "02 3F");
    sdo_rig_ask(&rig, "70 00 00 00 00 00 00 00", "");
    sdo_rig_ask(&rig, "40 00 10 00 00 00 00 00", "");
    sdo_rig_wait(&rig, DG_S(3));
    sdo_rig_expect(&rig, ""); /* not even the timeout */
    sdo_rig_receive(&rig, 0, "80 3F");
    sdo_rig_ask(&rig, "70 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
    sdo_rig_play(&rig, upload_32, DG_COUNT(upload_32));
}

static void a_transfer_goes_on_into_operational(void **state)
{
    (void)state;
    sdo_rig_play(&rig, upload_32, 2);
    sdo_rig_receive(&rig, 0, "01 3F");
    sdo_rig_ask(&rig, "70 00 00 00 00 00 00 00", "10 37 38 39 41 42 43 44");
}

/* A host that steps late: the timeout comes before the frame that finds it due. */
static void a_late_continuation_finds_no_transfer(void **state)
{
    (void)state;
    sdo_rig_play(&rig, upload_32, 2);
    rig.now += DG_S(1) - 1u;
    sdo_rig_ask(&rig, "70 00 00 00 00 00 00 00", "10 37 38 39 41 42 43 44");
    rig.now += DG_S(1);
    sdo_rig_ask(&rig, "60 00 00 00 00 00 00 00",
                "80 17 20 00 00 00 04 05 / 80 00 00 00 01 00 04 05");
}

/* ---- delayed answers: "save" takes 14 ms */

/* The last request of each; the answer they must have comes later. */
static const struct {
    struct sdo_rig_step steps[3];
    size_t n;
    const char *last;
    const char *answer;
} saves[] = {
    {{{NULL, NULL}}, 0, "23 10 10 01 73 61 76 65", "60 10 10 01 00 00 00 00"},
    {{{"21 10 10 01 04 00 00 00", "60 10 10 01 00 00 00 00"}},
     1,
     "07 73 61 76 65 00 00 00",
     "20 00 00 00 00 00 00 00"},
    {{{"20 10 10 01 00 00 00 00", "60 10 10 01 00 00 00 00"},
      {"0A 73 61 00 00 00 00 00", "20 00 00 00 00 00 00 00"}},
     2,
     "1B 76 65 00 00 00 00 00",
     "30 00 00 00 00 00 00 00"},
    {{{"C6 10 10 01 04 00 00 00", "A4 10 10 01 05 00 00 00"},
      {"81 73 61 76 65 00 00 00", "A2 01 05 00 00 00 00 00"}},
     2,
     "CD 0E EB 00 00 00 00 00",
     "A1 00 00 00 00 00 00 00"},
};

static void save(size_t i)
{
    sdo_rig_play(&rig, saves[i].steps, saves[i].n);
    sdo_rig_ask(&rig, saves[i].last, "");
}

static void saving_is_answered_later(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(saves); i++) {
        save(i);
        sdo_rig_wait(&rig, SAVE_NS - 1u);
        sdo_rig_expect(&rig, "");
        sdo_rig_wait(&rig, 1);
        sdo_rig_expect(&rig, saves[i].answer);
        sdo_rig_wait(&rig, DG_S(3));
        sdo_rig_expect(&rig, "");
    }
}

static void a_request_meanwhile_has_the_delayed_answer_sent_first(void **state)
{
    static const struct sdo_rig_step next[] = {
        {"40 00 10 00 00 00 00 00", "43 00 10 00 96 01 02 00"},
        {"E0 00 10 00 00 00 00 00", "80 00 10 00 01 00 04 05"},
        {"60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(saves) * DG_COUNT(next); i++) {
        const struct sdo_rig_step *step = &next[i % DG_COUNT(next)];
        char both[64];

        save(i / DG_COUNT(next));
        sdo_rig_wait(&rig, SAVE_NS / 2u);
        memcpy(both, saves[i / DG_COUNT(next)].answer, 23);
        memcpy(&both[23], " / ", 3);
        memcpy(&both[26], step->answer, 24);
        sdo_rig_ask(&rig, step->request, both);
        sdo_rig_wait(&rig, DG_S(3));
        sdo_rig_expect(&rig, "");
    }
}

static void a_client_abort_drops_the_delayed_answer(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(saves); i++) {
        save(i);
        sdo_rig_ask(&rig, "80 10 10 01 00 00 00 08", "");
        sdo_rig_wait(&rig, DG_S(3));
        sdo_rig_expect(&rig, "");
    }
}

static void stopping_drops_the_delayed_answer(void **state)
{
    (void)state;
    save(0);
    sdo_rig_receive(&rig, 0, "02 3F");
    sdo_rig_wait(&rig, DG_S(3));
    sdo_rig_expect(&rig, "");
}

static void a_memory_that_fails_is_reported_at_once(void **state)
{
    (void)state;
    rig.world.eeprom_acknowledges = false;
    sdo_rig_ask(&rig, "23 10 10 01 73 61 76 65", "80 10 10 01 00 00 06 06");
    sdo_rig_wait(&rig, DG_S(3));
    sdo_rig_expect(&rig, "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(expedited_uploads, set_up),
        cmocka_unit_test_setup(expedited_downloads_of_every_type, set_up),
        cmocka_unit_test_setup(one_sample_for_each_read_of_the_device, set_up),
        cmocka_unit_test_setup(every_refusal_has_its_code, set_up),
        cmocka_unit_test_setup(segmented_transfers, set_up),
        cmocka_unit_test_setup(segmented_downloads_arrive_with_the_last_segment, set_up),
        cmocka_unit_test_setup(disturbed_at_every_frame, set_up),
        cmocka_unit_test_setup(an_interrupted_download_writes_nothing, set_up),
        cmocka_unit_test_setup(a_broken_transfer_is_over, set_up),
        cmocka_unit_test_setup(short_frames_are_counted, set_up),
        cmocka_unit_test_setup(an_abort_without_a_transfer_is_silent, set_up),
        cmocka_unit_test_setup(nothing_is_answered_in_stopped, set_up),
        cmocka_unit_test_setup(a_transfer_goes_on_into_operational, set_up),
        cmocka_unit_test_setup(a_late_continuation_finds_no_transfer, set_up),
        cmocka_unit_test_setup(saving_is_answered_later, set_up),
        cmocka_unit_test_setup(a_request_meanwhile_has_the_delayed_answer_sent_first, set_up),
        cmocka_unit_test_setup(a_client_abort_drops_the_delayed_answer, set_up),
        cmocka_unit_test_setup(stopping_drops_the_delayed_answer, set_up),
        cmocka_unit_test_setup(a_memory_that_fails_is_reported_at_once, set_up),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
