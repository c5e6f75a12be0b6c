/* SPDX-License-Identifier: MIT */
/*
 * Cams and work areas of an encoder from its EDS file: 6300h to 6337h, 6400h to 6402h, by channels;
 * 3600 steps and 10 turns.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "eds_client.h"

#define STEPS 3600u
#define HALF_TURN (INT64_C(1) << 31)
#define TEXT_MAX 16384u

static struct eds_client rig;

static size_t add_object(char *to, size_t n, unsigned index, unsigned type, const char *access)
{
    for (unsigned channel = 1; channel <= 2; channel++) {
        n += (size_t)snprintf(to + n, TEXT_MAX - n, "[%Xsub%u]\nDataType=%u\nAccessType=%s\n",
                              index, channel, type, access);
    }
    return n;
}

static void start_encoder(void)
{
    char text[TEXT_MAX] = "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x00020196\n"
                          "[1010sub1]\nDataType=7\nAccessType=rw\nDefaultValue=1\n"
                          "[6004]\nDataType=7\nAccessType=ro\n"
                          "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=3600\n"
                          "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=10\n";
    size_t n = strlen(text);

    n = add_object(text, n, 0x6300, 5, "ro");
    n = add_object(text, n, 0x6301, 5, "rw");
    n = add_object(text, n, 0x6302, 5, "rw");
    for (unsigned cam = 0; cam < 8; cam++) {
        n = add_object(text, n, 0x6310 + cam, 7, "rw");
        n = add_object(text, n, 0x6320 + cam, 7, "rw");
        n = add_object(text, n, 0x6330 + cam, 6, "rw");
    }
    assert_int_equal(eds_client_read(&rig, text, n), DG_OK);
    assert_int_equal(rig.notes, 0);
    eds_client_make(&rig);
    eds_client_switch_on(&rig);
}

static void set_cam(uint8_t channel, uint16_t cam, uint32_t low, uint32_t high, uint16_t hysteresis)
{
    assert_int_equal(eds_client_download(&rig, (uint16_t)(0x6310 + cam), channel, low, 4), 0);
    assert_int_equal(eds_client_download(&rig, (uint16_t)(0x6320 + cam), channel, high, 4), 0);
    assert_int_equal(eds_client_download(&rig, (uint16_t)(0x6330 + cam), channel, hysteresis, 2),
                     0);
}

static void set_bits(uint16_t index, uint8_t channel, uint8_t bits)
{
    assert_int_equal(eds_client_download(&rig, index, channel, bits, 1), 0);
}

/* 6300h with the shaft in the middle of this step. */
static uint8_t cams_at(uint8_t channel, int64_t step)
{
    dg_host_shaft(rig.host, rig.now, (2 * step + 1) * HALF_TURN / (int64_t)STEPS, 0);
    assert_int_equal(eds_client_upload(&rig, 0x6004, 0), (step + 36000) % 36000);
    return (uint8_t)eds_client_upload(&rig, 0x6300, channel);
}

static void on_between_its_limits(void **state)
{
    (void)state;
    start_encoder();
    set_cam(1, 0, 100, 200, 0);
    set_cam(1, 7, 4000, 8000, 0);
    assert_int_equal(cams_at(1, 150), 0);
    set_bits(0x6301, 1, 0x81);
    assert_int_equal(cams_at(1, 99), 0);
    assert_int_equal(cams_at(1, 100), 1);
    assert_int_equal(cams_at(1, 200), 1);
    assert_int_equal(cams_at(1, 201), 0);
    assert_int_equal(cams_at(1, 4000), 0x80);
    assert_int_equal(cams_at(1, 8001), 0);
    assert_int_equal(cams_at(2, 150), 0);
}

static void turned_round(void **state)
{
    (void)state;
    start_encoder();
    set_cam(1, 1, 100, 200, 0);
    set_bits(0x6301, 1, 2);
    set_bits(0x6302, 1, 0x82);
    assert_int_equal(cams_at(1, 150), 0x80);
    assert_int_equal(cams_at(1, 300), 0x82);
}

static void over_zero(void **state)
{
    (void)state;
    start_encoder();
    set_cam(2, 3, 35990, 10, 0);
    set_bits(0x6301, 2, 8);
    assert_int_equal(cams_at(2, -11), 0);
    assert_int_equal(cams_at(2, -10), 8);
    assert_int_equal(cams_at(2, 0), 8);
    assert_int_equal(cams_at(2, 10), 8);
    assert_int_equal(cams_at(2, 11), 0);
}

/* What is on stays on a little longer, at both ends. */
static void hysteresis(void **state)
{
    (void)state;
    start_encoder();
    set_cam(1, 0, 100, 200, 20);
    set_cam(2, 0, 5, 35995, 65535);
    set_bits(0x6301, 1, 1);
    set_bits(0x6301, 2, 1);
    assert_int_equal(cams_at(1, 210), 0);
    assert_int_equal(cams_at(1, 200), 1);
    assert_int_equal(cams_at(1, 220), 1);
    assert_int_equal(cams_at(1, 221), 0);
    assert_int_equal(cams_at(1, 220), 0);
    assert_int_equal(cams_at(1, 100), 1);
    assert_int_equal(cams_at(1, 80), 1);
    assert_int_equal(cams_at(1, 79), 0);
    assert_int_equal(cams_at(2, 1000), 1);
    assert_int_equal(cams_at(2, 0), 1);
    eds_client_switch_on(&rig); /* it is forgotten with the power */
    set_cam(1, 0, 100, 200, 20);
    set_bits(0x6301, 1, 1);
    assert_int_equal(cams_at(1, 210), 0);
}

static void cams_are_saved(void **state)
{
    (void)state;
    start_encoder();
    set_cam(1, 2, 7, 9, 1);
    set_bits(0x6301, 1, 4);
    assert_int_equal(eds_client_download(&rig, 0x1010, 1, EDS_CLIENT_SAVE, 4), 0);
    eds_client_switch_on(&rig);
    assert_int_equal(cams_at(1, 8), 4);
    assert_int_equal(cams_at(1, 11), 0);
}

/* They act: they are not told among the values that only store. */
static void what_cams_are(void **state)
{
    const struct dg_co_dictionary *dictionary = &rig.file.file.device.dictionary;
    (void)state;
    start_encoder();
    assert_int_equal(rig.file.file.plain, 2); /* 6501h, 6502h */
    assert_int_equal(rig.file.file.bound,
                     3u + (3u + 8u * 3u) * 2u); /* 1000h, 1010h:1, 6004h, cams */
    for (uint16_t i = 0; i < dictionary->count; i++) {
        if (dictionary->rows[i].key >> 16 >= 0x6300 && dictionary->rows[i].key >> 16 < 0x6340) {
            assert_int_equal(dg_co_role_of(&rig.file.file, i), DG_CO_SIMULATED);
        }
    }
}

/* By channel; signed where the file says so. */
static void work_areas(void **state)
{
    static const char text[] = "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x00020196\n"
                               "[6004]\nDataType=7\nAccessType=ro\n"
                               "[6400sub1]\nDataType=5\nAccessType=ro\nPDOMapping=1\n"
                               "[6400sub2]\nDataType=5\nAccessType=ro\nPDOMapping=1\n"
                               "[6400sub3]\nDataType=5\nAccessType=ro\nPDOMapping=1\n"
                               "[6400sub4]\nDataType=5\nAccessType=ro\nPDOMapping=1\n"
                               "[6401sub1]\nDataType=7\nAccessType=rw\nDefaultValue=100\n"
                               "[6402sub1]\nDataType=7\nAccessType=rw\nDefaultValue=200\n"
                               "[6401sub2]\nDataType=4\nAccessType=rw\nDefaultValue=-5\n"
                               "[6402sub2]\nDataType=4\nAccessType=rw\nDefaultValue=150\n"
                               "[6401sub4]\nDataType=4\nAccessType=rw\n"
                               "[6402sub4]\nDataType=4\nAccessType=rw\n"
                               "[6402sub3]\nDataType=7\nAccessType=rw\nDefaultValue=120\n"
                               "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=3600\n"
                               "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=10\n";
    static const struct {
        int64_t step;
        uint8_t bits[3];
    } rows[] = {
        {0, {5, 0, 0}},   {99, {5, 0, 0}},  {100, {0, 0, 0}}, {120, {0, 0, 0}},
        {121, {0, 0, 3}}, {151, {0, 3, 3}}, {200, {0, 3, 3}}, {201, {3, 3, 3}},
    };
    (void)state;
    assert_int_equal(eds_client_read(&rig, text, strlen(text)), DG_OK);
    assert_int_equal(rig.notes, 0);
    eds_client_make(&rig);
    eds_client_switch_on(&rig);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        dg_host_shaft(rig.host, rig.now, (2 * rows[i].step + 1) * HALF_TURN / (int64_t)STEPS, 0);
        for (uint8_t channel = 1; channel <= 3; channel++) {
            assert_int_equal(eds_client_upload(&rig, 0x6400, channel) & 0xFFu,
                             rows[i].bits[channel - 1]);
        }
        assert_int_equal(eds_client_upload(&rig, 0x6400, 4) & 0xFFu, 0); /* as delivered */
    }
    assert_int_equal(eds_client_download(&rig, 0x6402, 1, 300, 4), 0);
    assert_int_equal(eds_client_upload(&rig, 0x6400, 1) & 0xFFu, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(on_between_its_limits),
        cmocka_unit_test(turned_round),
        cmocka_unit_test(over_zero),
        cmocka_unit_test(hysteresis),
        cmocka_unit_test(cams_are_saved),
        cmocka_unit_test(what_cams_are),
        cmocka_unit_test(work_areas),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
