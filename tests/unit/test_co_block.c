/* SPDX-License-Identifier: MIT */
/*
 * SDO block transfers. The frames are written by hand from CiA 301; the CRCs were computed with
 * Python's binascii.crc_hqx(data, 0), "123456789" giving the published check value 31C3h.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "sdo_rig.h"

/** The text of 2017h in segments, as numbered in a block that holds it whole. */
#define SEGMENT_1 "01 30 31 32 33 34 35 36"
#define SEGMENT_2 "02 37 38 39 41 42 43 44"
#define SEGMENT_3 "03 45 46 47 48 49 4A 4B"
#define SEGMENT_4 "04 4C 4D 4E 4F 50 51 52"
#define SEGMENT_5 "85 53 54 55 56 00 00 00"

static struct sdo_rig rig;

static int set_up(void **state)
{
    (void)state;
    sdo_rig_init(&rig);
    return 0;
}

/* ---- upload */

static const struct sdo_rig_step upload_32[] = {
    {"A4 17 20 00 7F 00 00 00", "C6 17 20 00 20 00 00 00"},
    {"A3 00 00 00 00 00 00 00",
     SEGMENT_1 " / " SEGMENT_2 " / " SEGMENT_3 " / " SEGMENT_4 " / " SEGMENT_5},
    {"A2 05 7F 00 00 00 00 00", "CD 21 1A 00 00 00 00 00"},
    {"A1 00 00 00 00 00 00 00", ""},
};
/* The client does not want a CRC. */
static const struct sdo_rig_step upload_9[] = {
    {"A0 15 20 00 02 00 00 00", "C6 15 20 00 09 00 00 00"},
    {"A3 00 00 00 00 00 00 00", "01 31 32 33 34 35 36 37 / 82 38 39 00 00 00 00 00"},
    {"A2 02 02 00 00 00 00 00", "D5 00 00 00 00 00 00 00"},
    {"A1 00 00 00 00 00 00 00", ""},
};
static const struct sdo_rig_step upload_9_crc[] = {
    {"A4 15 20 00 02 00 00 00", "C6 15 20 00 09 00 00 00"},
    {"A3 00 00 00 00 00 00 00", "01 31 32 33 34 35 36 37 / 82 38 39 00 00 00 00 00"},
    {"A2 02 02 00 00 00 00 00", "D5 C3 31 00 00 00 00 00"},
    {"A1 00 00 00 00 00 00 00", ""},
};
/* Whole segments: nothing is unused. */
static const struct sdo_rig_step upload_14[] = {
    {"A4 16 20 00 03 00 00 00", "C6 16 20 00 0E 00 00 00"},
    {"A3 00 00 00 00 00 00 00", "01 41 42 43 44 45 46 47 / 82 48 49 4A 4B 4C 4D 4E"},
    {"A2 02 03 00 00 00 00 00", "C1 D6 38 00 00 00 00 00"},
    {"A1 00 00 00 00 00 00 00", ""},
};
static const struct sdo_rig_step upload_number[] = {
    {"A4 00 10 00 01 00 00 00", "C6 00 10 00 04 00 00 00"},
    {"A3 00 00 00 00 00 00 00", "81 96 01 02 00 00 00 00"},
    {"A2 01 01 00 00 00 00 00", "CD 54 B0 00 00 00 00 00"},
    {"A1 00 00 00 00 00 00 00", ""},
};
/* No data is an empty segment. */
static const struct sdo_rig_step upload_empty[] = {
    {"A4 10 20 00 7F 00 00 00", "C6 10 20 00 00 00 00 00"},
    {"A3 00 00 00 00 00 00 00", "81 00 00 00 00 00 00 00"},
    {"A2 00 7F 00 00 00 00 00", "81 00 00 00 00 00 00 00"},
    {"A2 01 7F 00 00 00 00 00", "DD 00 00 00 00 00 00 00"},
    {"A1 00 00 00 00 00 00 00", ""},
};
/* Blocks of 2, then 1, then more than are left. */
static const struct sdo_rig_step upload_in_blocks[] = {
    {"A4 17 20 00 02 00 00 00", "C6 17 20 00 20 00 00 00"},
    {"A3 00 00 00 00 00 00 00", SEGMENT_1 " / " SEGMENT_2},
    {"A2 02 01 00 00 00 00 00", "01 45 46 47 48 49 4A 4B"},
    {"A2 01 03 00 00 00 00 00", "01 4C 4D 4E 4F 50 51 52 / 82 53 54 55 56 00 00 00"},
    {"A2 02 03 00 00 00 00 00", "CD 21 1A 00 00 00 00 00"},
    {"A1 00 00 00 00 00 00 00", ""},
};
/* The client has lost segments: the first, one in the middle, the last, all. */
static const struct sdo_rig_step upload_with_losses[] = {
    {"A4 17 20 00 03 00 00 00", "C6 17 20 00 20 00 00 00"},
    {"A3 00 00 00 00 00 00 00", SEGMENT_1 " / " SEGMENT_2 " / " SEGMENT_3},
    {"A2 00 03 00 00 00 00 00", SEGMENT_1 " / " SEGMENT_2 " / " SEGMENT_3},
    {"A2 01 04 00 00 00 00 00",
     "01 37 38 39 41 42 43 44 / 02 45 46 47 48 49 4A 4B / 03 4C 4D 4E 4F 50 51 52 / "
     "84 53 54 55 56 00 00 00"},
    {"A2 03 7F 00 00 00 00 00", "81 53 54 55 56 00 00 00"},
    {"A2 00 01 00 00 00 00 00", "81 53 54 55 56 00 00 00"},
    {"A2 01 01 00 00 00 00 00", "CD 21 1A 00 00 00 00 00"},
    {"A1 00 00 00 00 00 00 00", ""},
};

/* ---- upload with the protocol switched: the data are no longer than the threshold */

static const struct sdo_rig_step switched_to_segments[] = {
    {"A4 16 20 00 7F 0E 00 00", "41 16 20 00 0E 00 00 00"},
    {"60 00 00 00 00 00 00 00", "00 41 42 43 44 45 46 47"},
    {"70 00 00 00 00 00 00 00", "11 48 49 4A 4B 4C 4D 4E"},
};
static const struct sdo_rig_step switched_to_an_empty_segment[] = {
    {"A4 10 20 00 7F 01 00 00", "41 10 20 00 00 00 00 00"},
    {"60 00 00 00 00 00 00 00", "0F 00 00 00 00 00 00 00"},
};
static const struct sdo_rig_step not_switched[] = {
    {"A4 16 20 00 02 0D 00 00", "C6 16 20 00 0E 00 00 00"},
    {"A3 00 00 00 00 00 00 00", "01 41 42 43 44 45 46 47 / 82 48 49 4A 4B 4C 4D 4E"},
    {"A2 02 02 00 00 00 00 00", "C1 D6 38 00 00 00 00 00"},
    {"A1 00 00 00 00 00 00 00", ""},
};

/* ---- download */

static const struct sdo_rig_step download_u32[] = {
    {"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
    {"81 78 56 34 12 FF FF FF", "A2 01 05 00 00 00 00 00"},
    {"CD FA D0 00 00 00 00 00", "A1 00 00 00 00 00 00 00"},
};
/* Neither size nor CRC; what stands in its place does not count. */
static const struct sdo_rig_step download_plain[] = {
    {"C0 06 20 00 FF FF FF FF", "A4 06 20 00 05 00 00 00"},
    {"81 78 56 34 12 00 00 00", "A2 01 05 00 00 00 00 00"},
    {"CD 11 22 00 00 00 00 00", "A1 00 00 00 00 00 00 00"},
};
/* Segment 1 is lost; the block ends with the last segment or when it is full, and is repeated. */
static const struct sdo_rig_step download_with_losses[] = {
    {"C4 06 20 00 00 00 00 00", "A4 06 20 00 05 00 00 00"},
    {"82 00 00 00 00 00 00 00", "A2 00 05 00 00 00 00 00"},
    {"02 00 00 00 00 00 00 00", ""},
    {"04 00 00 00 00 00 00 00", ""},
    {"03 00 00 00 00 00 00 00", ""},
    {"05 00 00 00 00 00 00 00", "A2 00 05 00 00 00 00 00"},
    {"81 78 56 34 12 00 00 00", "A2 01 05 00 00 00 00 00"},
    {"CD FA D0 00 00 00 00 00", "A1 00 00 00 00 00 00 00"},
};

static const struct transfer {
    const struct sdo_rig_step *steps;
    size_t n;
} uploads[] = {
    {upload_32, DG_COUNT(upload_32)},
    {upload_9, DG_COUNT(upload_9)},
    {upload_9_crc, DG_COUNT(upload_9_crc)},
    {upload_14, DG_COUNT(upload_14)},
    {upload_number, DG_COUNT(upload_number)},
    {upload_empty, DG_COUNT(upload_empty)},
    {upload_in_blocks, DG_COUNT(upload_in_blocks)},
    {upload_with_losses, DG_COUNT(upload_with_losses)},
    {switched_to_segments, DG_COUNT(switched_to_segments)},
    {switched_to_an_empty_segment, DG_COUNT(switched_to_an_empty_segment)},
    {not_switched, DG_COUNT(not_switched)},
};
static const struct transfer downloads[] = {
    {download_u32, DG_COUNT(download_u32)},
    {download_plain, DG_COUNT(download_plain)},
    {download_with_losses, DG_COUNT(download_with_losses)},
};

static void block_uploads(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(uploads); i++) {
        sdo_rig_play(&rig, uploads[i].steps, uploads[i].n);
        assert_int_equal(rig.node.sdo.state, DG_CO_SDO_IDLE);
    }
}

static void short_data_are_expedited_when_the_client_allows(void **state)
{
    static const struct sdo_rig_step steps[] = {
        {"A4 00 10 00 7F 04 00 00", "43 00 10 00 96 01 02 00"},
        {"A0 18 10 00 01 FF 00 00", "4F 18 10 00 04 00 00 00"},
        {"A3 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"},
        {"A4 00 10 00 7F 03 00 00", "C6 00 10 00 04 00 00 00"},
    };

    (void)state;
    sdo_rig_play(&rig, steps, DG_COUNT(steps));
}

static void block_downloads_arrive_at_the_end(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(downloads); i++) {
        rig.node.value[SDO_RIG_U32] = 0;
        sdo_rig_play(&rig, downloads[i].steps, downloads[i].n - 1u);
        assert_int_equal(rig.node.value[SDO_RIG_U32], 0);
        sdo_rig_play(&rig, &downloads[i].steps[downloads[i].n - 1u], 1);
        assert_int_equal(rig.node.value[SDO_RIG_U32], 0x12345678);
        assert_int_equal(rig.node.sdo.state, DG_CO_SDO_IDLE);
    }
}

static void a_last_segment_received_twice_does_not_matter(void **state)
{
    static const struct sdo_rig_step steps[] = {
        {"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
        {"81 78 56 34 12 00 00 00", "A2 01 05 00 00 00 00 00"},
        {"81 78 56 34 12 00 00 00", ""},
        {"CD FA D0 00 00 00 00 00", "A1 00 00 00 00 00 00 00"},
    };

    (void)state;
    sdo_rig_play(&rig, steps, DG_COUNT(steps));
    assert_int_equal(rig.node.value[SDO_RIG_U32], 0x12345678);
}

static void block_downloads_of_every_type(void **state)
{
    static const struct {
        struct sdo_rig_step steps[3];
        uint8_t slot;
        uint32_t value;
    } rows[] = {
        {{{"C6 01 20 00 01 00 00 00", "A4 01 20 00 05 00 00 00"},
          {"81 FE 00 00 00 00 00 00", "A2 01 05 00 00 00 00 00"},
          {"D9 D1 0E 00 00 00 00 00", "A1 00 00 00 00 00 00 00"}},
         SDO_RIG_I8,
         (uint32_t)-2},
        {{{"C4 05 20 00 00 00 00 00", "A4 05 20 00 05 00 00 00"},
          {"81 34 12 00 00 00 00 00", "A2 01 05 00 00 00 00 00"},
          {"D5 22 FB 00 00 00 00 00", "A1 00 00 00 00 00 00 00"}},
         SDO_RIG_U16,
         0x1234},
        {{{"C2 08 20 00 04 00 00 00", "A4 08 20 00 05 00 00 00"},
          {"81 04 03 02 01 00 00 00", "A2 01 05 00 00 00 00 00"},
          {"CD 00 00 00 00 00 00 00", "A1 00 00 00 00 00 00 00"}},
         SDO_RIG_WRITE_ONLY,
         0x01020304},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        sdo_rig_play(&rig, rows[i].steps, DG_COUNT(rows[i].steps));
        assert_int_equal(rig.node.value[rows[i].slot], rows[i].value);
    }
}

static void disturbed_at_every_frame(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(uploads); i++) {
        sdo_rig_disturb(&rig, uploads[i].steps, uploads[i].n);
    }
    for (size_t i = 0; i < DG_COUNT(downloads); i++) {
        sdo_rig_disturb(&rig, downloads[i].steps, downloads[i].n);
    }
}

/* What a client may begin instead of the next frame of a block download. */
static void any_new_request_ends_a_block_download(void **state)
{
    static const struct sdo_rig_step next[] = {
        {"40 00 10 00 00 00 00 00", "43 00 10 00 96 01 02 00"},
        {"2F 04 20 00 01 00 00 00", "60 04 20 00 00 00 00 00"},
        {"21 06 20 00 04 00 00 00", "60 06 20 00 00 00 00 00"},
        {"A4 00 10 00 7F 00 00 00", "C6 00 10 00 04 00 00 00"},
        {"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(next); i++) {
        sdo_rig_play(&rig, download_plain, 1);
        sdo_rig_play(&rig, &next[i], 1);
    }
    assert_int_equal(rig.node.value[SDO_RIG_U32], 0);
}

/* ---- transfers that fail; a right continuation is one of nothing */

static const struct {
    struct sdo_rig_step steps[5];
    size_t n;
} broken[] = {
    /* block size of the client */
    {{{"A4 17 20 00 00 00 00 00", "80 17 20 00 02 00 04 05"}}, 1},
    {{{"A4 17 20 00 80 00 00 00", "80 17 20 00 02 00 04 05"}}, 1},
    {{{"A4 17 20 00 FF 00 00 00", "80 17 20 00 02 00 04 05"}}, 1},
    {{{"A4 17 20 00 01 00 00 00", "C6 17 20 00 20 00 00 00"},
      {"A3 00 00 00 00 00 00 00", SEGMENT_1},
      {"A2 01 00 00 00 00 00 00", "80 17 20 00 02 00 04 05"}},
     3},
    {{{"A4 17 20 00 01 00 00 00", "C6 17 20 00 20 00 00 00"},
      {"A3 00 00 00 00 00 00 00", SEGMENT_1},
      {"A2 01 80 00 00 00 00 00", "80 17 20 00 02 00 04 05"}},
     3},
    /* more is acknowledged than was sent */
    {{{"A4 17 20 00 01 00 00 00", "C6 17 20 00 20 00 00 00"},
      {"A3 00 00 00 00 00 00 00", SEGMENT_1},
      {"A2 02 01 00 00 00 00 00", "80 17 20 00 03 00 04 05"}},
     3},
    {{{"A4 00 10 00 7F 00 00 00", "C6 00 10 00 04 00 00 00"},
      {"A3 00 00 00 00 00 00 00", "81 96 01 02 00 00 00 00"},
      {"A2 7F 7F 00 00 00 00 00", "80 00 10 00 03 00 04 05"}},
     3},
    /* out of turn */
    {{{"A4 17 20 00 01 00 00 00", "C6 17 20 00 20 00 00 00"},
      {"A2 00 01 00 00 00 00 00", "80 17 20 00 01 00 04 05"}},
     2},
    {{{"A4 17 20 00 01 00 00 00", "C6 17 20 00 20 00 00 00"},
      {"A3 00 00 00 00 00 00 00", SEGMENT_1},
      {"A3 00 00 00 00 00 00 00", "80 17 20 00 01 00 04 05"}},
     3},
    {{{"A4 17 20 00 01 00 00 00", "C6 17 20 00 20 00 00 00"},
      {"A3 00 00 00 00 00 00 00", SEGMENT_1},
      {"A1 00 00 00 00 00 00 00", "80 17 20 00 01 00 04 05"}},
     3},
    {{{"A4 00 10 00 7F 00 00 00", "C6 00 10 00 04 00 00 00"},
      {"A3 00 00 00 00 00 00 00", "81 96 01 02 00 00 00 00"},
      {"A2 01 7F 00 00 00 00 00", "CD 54 B0 00 00 00 00 00"},
      {"A2 01 7F 00 00 00 00 00", "80 00 10 00 01 00 04 05"}},
     4},
    {{{"A4 17 20 00 01 00 00 00", "C6 17 20 00 20 00 00 00"},
      {"E0 00 00 00 00 00 00 00", "80 17 20 00 01 00 04 05"}},
     2},
    {{{"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"81 78 56 34 12 00 00 00", "A2 01 05 00 00 00 00 00"},
      {"E0 00 00 00 00 00 00 00", "80 06 20 00 01 00 04 05"}},
     3},
    /* sequence numbers beyond the block */
    {{{"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"00 78 56 34 12 00 00 00", "80 06 20 00 03 00 04 05"}},
     2},
    {{{"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"06 78 56 34 12 00 00 00", "80 06 20 00 03 00 04 05"}},
     2},
    {{{"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"86 78 56 34 12 00 00 00", "80 06 20 00 03 00 04 05"}},
     2},
    {{{"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"7F 78 56 34 12 00 00 00", "80 06 20 00 03 00 04 05"}},
     2},
    {{{"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"FF 78 56 34 12 00 00 00", "80 06 20 00 03 00 04 05"}},
     2},
    /* not the object's size, not the announced one */
    {{{"C0 06 20 00 00 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"01 78 56 34 12 00 00 00", ""},
      {"82 00 00 00 00 00 00 00", "A2 02 05 00 00 00 00 00"},
      {"D9 00 00 00 00 00 00 00", "80 06 20 00 12 00 07 06"}},
     4},
    /* a gap behind a whole segment: too long in any case, said at the end of the block */
    {{{"C0 06 20 00 00 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"01 78 56 34 12 00 00 00", ""},
      {"83 00 00 00 00 00 00 00", "80 06 20 00 12 00 07 06"}},
     3},
    {{{"C2 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"01 78 56 34 12 00 00 00", ""},
      {"05 00 00 00 00 00 00 00", "80 06 20 00 10 00 07 06"}},
     3},
    {{{"C2 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"01 78 56 34 12 00 00 00", ""},
      {"82 00 00 00 00 00 00 00", "A2 02 05 00 00 00 00 00"},
      {"D9 00 00 00 00 00 00 00", "80 06 20 00 10 00 07 06"}},
     4},
    {{{"C0 06 20 00 00 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"81 78 56 34 12 00 00 00", "A2 01 05 00 00 00 00 00"},
      {"C9 00 00 00 00 00 00 00", "80 06 20 00 12 00 07 06"}},
     3},
    {{{"C0 06 20 00 00 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"81 78 56 34 12 00 00 00", "A2 01 05 00 00 00 00 00"},
      {"D1 00 00 00 00 00 00 00", "80 06 20 00 13 00 07 06"}},
     3},
    {{{"C0 06 20 00 00 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"81 78 56 34 12 00 00 00", "A2 01 05 00 00 00 00 00"},
      {"DD 00 00 00 00 00 00 00", "80 06 20 00 13 00 07 06"}},
     3},
    {{{"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"81 78 56 34 12 00 00 00", "A2 01 05 00 00 00 00 00"},
      {"D1 FA D0 00 00 00 00 00", "80 06 20 00 10 00 07 06"}},
     3},
    /* CRC */
    {{{"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"81 78 56 34 12 00 00 00", "A2 01 05 00 00 00 00 00"},
      {"CD FB D0 00 00 00 00 00", "80 06 20 00 04 00 04 05"}},
     3},
    {{{"C6 06 20 00 04 00 00 00", "A4 06 20 00 05 00 00 00"},
      {"81 78 56 34 13 00 00 00", "A2 01 05 00 00 00 00 00"},
      {"CD FA D0 00 00 00 00 00", "80 06 20 00 04 00 04 05"}},
     3},
    /* refused by the object */
    {{{"C2 01 20 00 01 00 00 00", "A4 01 20 00 05 00 00 00"},
      {"81 9B 00 00 00 00 00 00", "A2 01 05 00 00 00 00 00"},
      {"D9 00 00 00 00 00 00 00", "80 01 20 00 30 00 09 06"}},
     3},
};

static void a_broken_transfer_is_over(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(broken); i++) {
        sdo_rig_play(&rig, broken[i].steps, broken[i].n);
        sdo_rig_ask(&rig, "A3 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
        sdo_rig_ask(&rig, "A1 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
        sdo_rig_ask(&rig, "CD FA D0 00 00 00 00 00", "80 FA D0 00 01 00 04 05");
        sdo_rig_wait(&rig, DG_S(3));
        sdo_rig_expect(&rig, "");
    }
    assert_int_equal(rig.node.value[SDO_RIG_U32], 0);
    assert_int_equal(rig.node.value[SDO_RIG_I8], 0);
}

/* A block that is full and does not end: 35 bytes for an object of 4, and no more than 35. */
static void a_full_block_without_an_end(void **state)
{
    static const struct sdo_rig_step steps[] = {
        {"C0 06 20 00 00 00 00 00", "A4 06 20 00 05 00 00 00"},
        {"01 11 11 11 11 11 11 11", ""},
        {"02 22 22 22 22 22 22 22", ""},
        {"02 22 22 22 22 22 22 22", ""}, /* twice */
        {"03 33 33 33 33 33 33 33", ""},
        {"04 44 44 44 44 44 44 44", ""},
        {"05 55 55 55 55 55 55 55", "80 06 20 00 12 00 07 06"},
    };

    (void)state;
    sdo_rig_play(&rig, steps, DG_COUNT(steps));
    assert_int_equal(rig.node.value[SDO_RIG_U32], 0);
    sdo_rig_disturb(&rig, steps, DG_COUNT(steps));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(block_uploads, set_up),
        cmocka_unit_test_setup(short_data_are_expedited_when_the_client_allows, set_up),
        cmocka_unit_test_setup(block_downloads_arrive_at_the_end, set_up),
        cmocka_unit_test_setup(a_last_segment_received_twice_does_not_matter, set_up),
        cmocka_unit_test_setup(block_downloads_of_every_type, set_up),
        cmocka_unit_test_setup(disturbed_at_every_frame, set_up),
        cmocka_unit_test_setup(any_new_request_ends_a_block_download, set_up),
        cmocka_unit_test_setup(a_broken_transfer_is_over, set_up),
        cmocka_unit_test_setup(a_full_block_without_an_end, set_up),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
