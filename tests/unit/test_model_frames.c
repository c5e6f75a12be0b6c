/* SPDX-License-Identifier: MIT */
/*
 * Frames and words of models that are texts, bit for bit. What is expected was worked out by hand
 * from the formats that makers publish: Gray code by the rule that a bit is turned round where the
 * one in front of it is 1, check sums by long division. A row is a section, where the shaft stands,
 * and what a master clocks in.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/hal.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/rig.h"
#include "frame_row.h"

#define QUARTER (INT64_C(1) << 30)
#define MEMORY_SIZE 32768u
#define TEXT_MAX 400u

struct bench {
    _Alignas(16) unsigned char plan_memory[MEMORY_SIZE];
    _Alignas(16) unsigned char memory[MEMORY_SIZE];
    struct dg_plan plan;
    struct dg_host *host;
    uint64_t now;
};

static struct bench bench;

/* An encoder of [model x] with these words, switched on and initialised. */
static void make_encoder(struct bench *self, const char *figures)
{
    char text[TEXT_MAX];
    struct dg_plan_error error = {.line = 0};
    const int n = snprintf(text, sizeof text, "[model x]\n%s\n", figures);
    const struct dg_plan_setup setup = {
        .size = sizeof setup,
        .file = "x.ini",
        .text = {text, (size_t)n},
        .memory = self->plan_memory,
        .memory_size = MEMORY_SIZE,
    };
    if (dg_plan_read(&self->plan, &setup, &error) != DG_OK) {
        fail_msg("%s: %s %s; %s", figures, error.key, error.what, error.right);
    }
    const struct dg_device *model = self->plan.models[0].device;
    self->host = dg_host_init(self->memory, MEMORY_SIZE, model, dg_host_wire_of(model));
    assert_non_null(self->host);
    assert_int_equal(dg_host_power(self->host, 0, true), DG_HOST_OK);
    self->now = DG_S(1);
    (void)dg_host_step(self->host, self->now);
}

static void assert_rows(const struct frame_row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        make_encoder(&bench, rows[i].figures);
        frame_row_check(bench.host, &bench.now, &rows[i]);
    }
}

/* Also the widths that a 64-bit word ends at. */
static void ssi_words(void **state)
{
    static const struct frame_row rows[] = {
        /* 1 bit: half a turn */
        {"base = ssi-13\nst = 1\ncode = binary", 2, "1", 0, 1, NULL, 0, false, false},
        /* 40 bits: 2.5 turns */
        {"base = ssi-25\nmt = 16\nst = 24\ncode = binary", 10,
         "0000000000000010 100000000000000000000000", 2, 0x800000, NULL, 0, false, false},
        /* 64 bits: 1.25 turns */
        {"base = ssi-25\nmt = 32\nst = 32\ncode = binary", 5,
         "00000000000000000000000000000001 01000000000000000000000000000000", 1, 0x40000000, NULL,
         0, false, false},
        /* the same in Gray code: ...1 01... becomes ...1 11... */
        {"base = ssi-25\nmt = 32\nst = 32", 5,
         "00000000000000000000000000000001 11100000000000000000000000000000", 1, 0x40000000, NULL,
         0, false, false},
        /* a quarter below 0: 62 bits, no error, even: 32 ones and a 0 */
        {"base = ssi-28\nmt = 30\nst = 32", -1,
         "111111111111111111111111111111 11000000000000000000000000000000 0 0", 0x3FFFFFFF,
         0xC0000000, NULL, 0, false, false},
    };
    (void)state;
    assert_rows(rows, DG_COUNT(rows));
}

/* The tree has room for 12 bits of turns and 13 of a turn, from the middle outwards: 00000101
 * 0100000000 in Gray code is 00000111 1110000000. */
static void ssi_tree(void **state)
{
    static const struct frame_row rows[] = {
        {"base = ssi-25\nmt = 8\nst = 10\nframe = 0000 P 000", 21, "0000 00000111 1110000000 000",
         5, 256, NULL, 0, false, false},
        /* ones around it, and nothing between */
        {"base = ssi-25\nmt = 0\nst = 8\ncode = binary\nframe = 1P01", 1, "1 01000000 0 1", 0, 64,
         NULL, 0, false, false},
    };
    (void)state;
    assert_rows(rows, DG_COUNT(rows));
}

static void ssi_bits_around_the_position(void **state)
{
    static const struct frame_row rows[] = {
        /* a 0 in front is an error; odd over the word: 2 ones and a 1, over the position: 1 and 0
         */
        {"base = ssi-13\nst = 10\ncode = binary\nerror_bit = low\nparity = odd\nframe = E P Y", 1,
         "1 0100000000 1", 0, 256, NULL, 0, false, false},
        {"base = ssi-13\nst = 10\ncode = binary\nerror_bit = low\nparity = odd\nframe = E P Y", 1,
         "0 0100000000 0", 0, 256, "watchdog_fired", 1, true, false},
        {"base = ssi-13\nst = 10\ncode = binary\nerror_bit = low\nparity = odd\nframe = E P Y\n"
         "parity_over = position",
         1, "1 0100000000 0", 0, 256, NULL, 0, false, false},
        /* the position as it is sent: Gray 0110000000, 2 ones, odd: 1 */
        {"base = ssi-13\nst = 10\nparity = odd\nframe = P Y\nparity_over = position", 1,
         "0110000000 1", 0, 256, NULL, 0, false, false},
        /* the usual order, parity over the position alone: 2 ones, and the error bit is none of it
         */
        {"base = ssi-28\nmt = 0\nst = 10\ncode = gray\nparity = odd\nparity_over = position", 1,
         "0110000000 1 1", 0, 256, "watchdog_fired", 1, true, false},
        /* parity in front is about what is in front of it: nothing, or the position all the same */
        {"base = ssi-13\nst = 8\ncode = binary\nparity = even\nframe = Y P", 1, "0 01000000", 0, 64,
         NULL, 0, false, false},
        {"base = ssi-13\nst = 8\ncode = binary\nparity = even\nframe = Y P\n"
         "parity_over = position",
         1, "1 01000000", 0, 64, NULL, 0, false, false},
        /* an error inverts the parity, and nobody can tell it from a word that was damaged */
        {"base = ssi-13\nst = 8\ncode = binary\nparity = even\nframe = P Y\nerror_parity = 1", 1,
         "01000000 1", 0, 64, NULL, 0, false, false},
        {"base = ssi-13\nst = 8\ncode = binary\nparity = even\nframe = P Y\nerror_parity = 1", 1,
         "01000000 0", 0, 64, "watchdog_fired", 1, false, true},
        /* a supply that is too low */
        {"base = ssi-13\nst = 8\ncode = binary\nframe = P F", 1, "01000000 0", 0, 64, NULL, 0,
         false, false},
        {"base = ssi-13\nst = 8\ncode = binary\nframe = P F", 1, "01000000 1", 0, 64, "supply_mv",
         4000, false, false},
    };
    (void)state;
    assert_rows(rows, DG_COUNT(rows));
}

/* It changes with each position; a word that is clocked again has the same one. */
static void ssi_toggle_bit(void **state)
{
    static const struct frame_row rows[] = {
        {"P T", 1, "01000000 1", 0, 64, NULL, 0, false, false},
        {"P T", 1, "01000000 0", 0, 64, NULL, 0, false, false},
        {"P T", 1, "01000000 1", 0, 64, NULL, 0, false, false},
    };
    (void)state;
    make_encoder(&bench, "base = ssi-13\nst = 8\ncode = binary\nframe = P T");
    dg_host_shaft(bench.host, bench.now, QUARTER, 0);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_host_frame frame = {.at = 0};
        frame_row_read(bench.host, &bench.now, &frame);
        frame_row_compare(&frame, &rows[i]);
    }
}

static void biss_frames(void **state)
{
    static const struct frame_row rows[] = {
        /* 26 bits: 2^24, nERR, nWARN; its remainder by 43h is 001100, sent inverted */
        {"base = s3674-biss\nst = 26\nlc = 0", 1, "01000000000000000000000000 1 1 110011", 0,
         0x1000000, NULL, 0, false, false},
        /* 32 bits */
        {"base = s3674-biss\nst = 32\nlc = 0", 1, "01000000000000000000000000000000 1 1 100001", 0,
         0x40000000, NULL, 0, false, false},
        /* 8 bits; the first life counter is 0 */
        {"base = s3674-biss\nst = 8", 1, "01000000 1 1 000000 001100", 0, 64, NULL, 0, false,
         false},
        /* zeros in front, the warning first, a 1 is one; CRC5: 01000, inverted */
        {"base = s3684-biss\nmt = 8\nst = 12\nlc = 0\nwarning = high\ncrc_poly = 0x25\n"
         "frame = 000 P W E C",
         21, "000 00000101 010000000000 0 1 10111", 5, 1024, NULL, 0, false, false},
        /* zeros behind are in the CRC as well */
        {"base = s3674-biss\nst = 8\nlc = 0\nframe = P E W 0000 C", 1, "01000000 1 1 0000 100011",
         0, 64, NULL, 0, false, false},
        /* CRC16: 0001000000101110, inverted; as it is, beginning with 1 */
        {"base = s3674-biss\nst = 12\nlc = 0\ncrc_poly = 190D9h", 1,
         "010000000000 1 1 1110111111010001", 0, 1024, NULL, 0, false, false},
        {"base = s3674-biss\nst = 12\nlc = 0\ncrc_poly = 190D9h\ncrc_start = 1\ncrc = plain", 1,
         "010000000000 1 1 0101000000101110", 0, 1024, NULL, 0, false, false},
        /* CRC6 that begins with 2Ah; one as it is */
        {"base = s3674-biss\nst = 8\nlc = 0\ncrc_start = 0x2A", 1, "01000000 1 1 101111", 0, 64,
         NULL, 0, false, false},
        {"base = s3674-biss\nst = 8\nlc = 0\ncrc = plain", 1, "01000000 1 1 010001", 0, 64, NULL, 0,
         false, false},
        /* no check sum: nothing to be wrong; a 1 is an error */
        {"base = s3674-biss\nst = 8\nlc = 0\nframe = P E", 1, "01000000 1", 0, 64, NULL, 0, false,
         false},
        {"base = s3674-biss\nst = 8\nlc = 0\nframe = P E\nerror = high", 1, "01000000 1", 0, 64,
         "watchdog_fired", 1, true, false},
    };
    (void)state;
    assert_rows(rows, DG_COUNT(rows));
}

/* What other bits than those that were sent say. */
static void damaged_frames(void **state)
{
    static const char *const figures[] = {
        "base = s3674-biss\nst = 12\nlc = 0\ncrc_poly = 190D9h",
        "base = s3684-biss\nmt = 8\nst = 12\ncrc_poly = 0x25\nframe = 0 P W L E C",
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(figures); i++) {
        struct dg_host_frame frame = {.at = 0};
        struct dg_biss_data data;
        make_encoder(&bench, figures[i]);
        frame_row_read(bench.host, &bench.now, &frame);
        const struct dg_biss_model *model = dg_biss_model_of(bench.plan.models[0].device);
        assert_int_equal(dg_biss_frame_bits(model), frame.count);
        for (unsigned bit = 0; bit < frame.count; bit++) {
            dg_biss_frame_decode(model, frame.bits ^ UINT64_C(1) << bit, &data);
            assert_false(data.crc_ok);
        }
    }
}

/* Registers are no part of a frame: a model has them if its text says so. */
static void registers_that_are_inherited(void **state)
{
    uint8_t byte = 0;
    (void)state;
    make_encoder(&bench, "base = s3674-biss\nst = 26\ninherit = registers");
    assert_int_equal(dg_host_registers_read(bench.host, &bench.now, 0x7E, &byte, 1), 1);
    assert_int_equal(byte, 0x4B);
    make_encoder(&bench, "base = s3674-biss\nst = 26");
    assert_int_equal(dg_host_registers_read(bench.host, &bench.now, 0x7E, &byte, 1),
                     DG_HOST_ERR_REFUSED);
}

static uint8_t read_register(uint8_t address)
{
    uint8_t byte = 0;
    assert_int_equal(dg_host_registers_read(bench.host, &bench.now, address, &byte, 1), 1);
    return byte;
}

/* 41h: EDS bank, 42h: profile; 78h to 7Fh: device, manufacturer. The encoder fills in its 12 bits
 * in 7Ah (0Ch), 26 bits in 7Bh (1Ah), and a timeout of 0 in 7Ch. */
static void identities(void **state)
{
    static const uint8_t expected[8] = {0xA1, 0xB2, 0xEC, 0xFA, 0xE0, 0xF6, 0x52, 0x4C};
    uint8_t none = 0;
    (void)state;
    make_encoder(&bench, "base = s3684-biss\nst = 26\nlc = 0\ninherit = registers\n"
                         "device_id = A1b2E0E0e0f6\nmanufacturer = 524Ch\nprofile_id = 43h");
    for (uint8_t i = 0; i < sizeof expected; i++) {
        assert_int_equal(read_register((uint8_t)(0x78 + i)), expected[i]);
    }
    assert_int_equal(read_register(0x41), 0);
    assert_int_equal(read_register(0x42), 0x43);
    none = 3;
    assert_int_equal(dg_host_registers_write(bench.host, &bench.now, 0x40, &none, 1), 1);
    assert_int_equal(dg_host_registers_read(bench.host, &bench.now, 0x00, &none, 1),
                     DG_HOST_ERR_REFUSED);
}

/* The check sum of a bank is the sum of its bytes. */
static void an_eds_that_is_inherited(void **state)
{
    uint8_t bank = 4;
    uint8_t sum = 0;
    (void)state;
    make_encoder(&bench, "base = s3684-biss\ninherit = registers,eds\nprofile_id = 43h");
    assert_int_equal(read_register(0x41), 3);
    assert_int_equal(dg_host_registers_write(bench.host, &bench.now, 0x40, &bank, 1), 1);
    assert_int_equal(read_register(0x02), 0x43);
    for (uint8_t i = 0; i < 0x3F; i++) {
        sum = (uint8_t)(sum + read_register(i));
    }
    assert_int_equal(read_register(0x3F), sum);
    assert_int_equal(read_register(0x7E), 0x4B);
    assert_int_equal(read_register(0x7F), 0x55);
}

/* A state has no pointers: the form is that of the handle it goes back into. */
static void states_of_other_forms(void **state)
{
    static const char *const figures[] = {
        "base = ssi-28\nframe = 0 E P Y",
        "base = s3674-biss\nst = 26\nlc = 0\nframe = 0 P W E C",
    };
    static unsigned char kept[MEMORY_SIZE];
    (void)state;
    for (size_t i = 0; i < DG_COUNT(figures); i++) {
        struct dg_host_frame first = {.at = 0};
        struct dg_host_frame again = {.at = 0};
        make_encoder(&bench, figures[i]);
        dg_host_shaft(bench.host, bench.now, QUARTER, 0);
        assert_int_equal(dg_host_save(bench.host, kept, sizeof kept), DG_HOST_OK);
        const uint64_t then = bench.now;
        frame_row_read(bench.host, &bench.now, &first);
        assert_int_equal(dg_host_restore(bench.host, kept, sizeof kept), DG_HOST_OK);
        bench.now = then;
        frame_row_read(bench.host, &bench.now, &again);
        assert_memory_equal(&first, &again, sizeof first);
        assert_int_not_equal(first.bits, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ssi_words),
        cmocka_unit_test(ssi_tree),
        cmocka_unit_test(ssi_bits_around_the_position),
        cmocka_unit_test(ssi_toggle_bit),
        cmocka_unit_test(biss_frames),
        cmocka_unit_test(damaged_frames),
        cmocka_unit_test(registers_that_are_inherited),
        cmocka_unit_test(identities),
        cmocka_unit_test(an_eds_that_is_inherited),
        cmocka_unit_test(states_of_other_forms),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
