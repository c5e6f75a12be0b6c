/* SPDX-License-Identifier: MIT */
/*
 * The frame of the S36 with BiSS, edge for edge: single-cycle data, busy, timeouts, quirks of
 * masters, and the word-level path against the edges. Bits and CRCs are those of the protocol
 * description and of public masters, as the vectors below say.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "biss_rig.h"
#include "drehgeber/devices.h"

static struct biss_rig rig;

static int setup(void **state)
{
    (void)state;
    return biss_rig_init(&rig, dg_biss_model_of(dg_device_find("s3674-biss")), 1) != DG_OK ||
           biss_rig_power_on(&rig) != DG_OK;
}

/* Position bits, nE, nW and the CRC they must give. */
static void test_crc6_vectors(void **state)
{
    static const struct {
        uint8_t n;
        uint64_t position;
        uint8_t flags;
        uint8_t crc;
    } rows[] = {
        {22, 0x000000, 3, 0x3A},   {22, 0x3FFFFF, 3, 0x2F},
        {22, 0x123456, 3, 0x35},   {22, 0x2BCDEF, 3, 0x10},
        {22, 0x154321, 3, 0x36},   {22, 0x3EDCBA, 3, 0x18},
        {22, 0x02EFCA, 3, 0x1C}, /* from a real encoder */
        {22, 0x012345, 1, 0x0B},   {22, 0x012345, 2, 0x0E},
        {22, 0x067405, 3, 0x1E},                              /* VESC, real */
        {32, 0x000001CA, 3, 0x2E}, {32, 0xFFFFFF90, 3, 0x03}, /* PandABlocks, real */
        {19, 0x7FC22, 1, 0x10},    {19, 0x004D0, 1, 0x0A},
        {19, 0x7FFFE, 1, 0x0F},    {24, 0xA5AFA5, 3, 0x19}, /* hpm_sdk: MT 12, ST 12 */
        {24, 0xA5AFA6, 3, 0x0D},   {24, 0xA5AFA7, 3, 0x01},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const uint64_t bits = rows[i].position << 2 | rows[i].flags;
        assert_int_equal(dg_biss_crc6(bits, (uint8_t)(rows[i].n + 2u)), rows[i].crc);
        assert_int_equal(biss_rig_crc6(bits, rows[i].n + 2u), rows[i].crc);
    }
}

static void test_crc_any_length(void **state)
{
    uint64_t bits = 0x0123456789ABCDEF;

    (void)state;
    for (uint8_t n = 0; n <= 64; n++) {
        const uint64_t part = n == 0 ? 0 : bits >> (64u - n);
        assert_int_equal(dg_biss_crc6(bits, n), biss_rig_crc6(bits, n));
        assert_int_equal(dg_biss_crc6(part, n), biss_rig_crc6(part, n));
        bits = bits * 6364136223846793005u + 1442695040888963407u;
    }
    for (unsigned byte = 0; byte < 256; byte++) {
        assert_int_equal(dg_biss_crc4(byte, 8), biss_rig_crc4(byte, 8));
    }
    assert_int_equal(dg_biss_crc4(0x00, 8), 0x0F);
    assert_int_equal(dg_biss_crc4(0x06, 8), 0x05);
    assert_int_equal(dg_biss_crc4(0x4B, 8), 0x06);
    assert_int_equal(dg_biss_crc4(0xA5, 8), 0x04);
    assert_int_equal(dg_biss_crc4(0xFF, 8), 0x0B);
}

/* 32 bit = CTS ID ADR CRC R W S DATA CRC P pad, from TI motor-control-sdk. */
static void test_address_words(void **state)
{
    static const uint32_t words[] = {
        0x889B4000, 0x88BD4000, 0x88D74000, 0x88F14000, 0x8C174000, 0x8CE54000, 0x8D014000,
        0x8F0B4000, 0x8F2D4000, 0x8F474000, 0x8F614000, 0x8F934000, 0x8FB54000, 0x8C16C194,
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(words); i++) {
        assert_int_equal(dg_biss_crc4(words[i] >> 21, 11), words[i] >> 17 & 0x0Fu);
    }
    assert_int_equal(dg_biss_crc4(words[13] >> 6 & 0xFFu, 8), words[13] >> 2 & 0x0Fu);
}

/* Every edge of a frame at the angle 90 degrees: ST 21 = 080000h, second frame, so LC = 1. */
static void test_every_edge(void **state)
{
    char levels[64] = "";
    uint64_t data = (uint64_t)0x080000 << 8 | 3u << 6 | 1u;
    const uint64_t bits = data << 6 | biss_rig_crc6(data, 29);

    (void)state;
    rig.model.busy = 0;
    rig.angle = DG_TURN / 4;
    (void)biss_rig_frame(&rig, false);
    for (size_t i = 0; i < 45; i++) {
        const bool before = dg_biss_slo(&rig.slave[0], false);
        assert_int_equal(biss_rig_edge(&rig, false), before); /* SLO only moves on rising edges */
        levels[i] = biss_rig_edge(&rig, true) ? '1' : '0';
    }
    char expected[64] = "1010"; /* e1, Ack, start, CDS */
    for (unsigned i = 0; i < 35; i++) {
        expected[4 + i] = (bits >> (34u - i) & 1u) != 0 ? '1' : '0';
    }
    strcat(expected, "000000"); /* clocks beyond the CRC */
    assert_string_equal(levels, expected);
    rig.now += DG_BISS_TIMEOUT_NS - 1u;
    assert_int_equal(dg_biss_step(&rig.slave[0], rig.now), rig.now + 1u);
    assert_false(dg_biss_slo(&rig.slave[0], false));
    assert_true(dg_biss_step(&rig.slave[0], rig.now + 1u) == DG_NEVER);
    assert_true(dg_biss_slo(&rig.slave[0], false));
}

/* The shaft turns between e1 and the data. */
static void test_latched_at_e1(void **state)
{
    (void)state;
    rig.angle_per_us = DG_TURN >> 21; /* a count a microsecond */
    rig.half_ns = 5000;
    (void)biss_rig_frame(&rig, false);
    const uint64_t e1 = rig.now;
    (void)biss_rig_frame(&rig, false);
    assert_int_equal(rig.bits >> 14, (e1 + 10000u) / 1000u);
}

static void test_life_counter(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 200; i++) {
        (void)biss_rig_frame(&rig, false);
        assert_int_equal(rig.bits >> 6 & 0x3Fu, i == 0 ? 0 : 1u + (i - 1u) % 63u);
    }
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    (void)biss_rig_frame(&rig, false);
    assert_int_equal(rig.bits >> 6 & 0x3Fu, 0);
}

static void test_without_life_counter(void **state)
{
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3684-biss"));

    (void)state;
    model.life_counter = false;
    assert_int_equal(biss_rig_init(&rig, &model, 1), DG_OK);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    rig.angle = -DG_TURN / 2;
    (void)biss_rig_frame(&rig, false);
    /* Turn -1 and a half: MT = FFFh, ST = 100000h */
    const uint64_t data = (uint64_t)0xFFF << 23 | (uint64_t)0x100000 << 2 | 3u;
    assert_true(rig.bits == (data << 6 | biss_rig_crc6(data, 35)));
}

/* All widths there are, from both ends of their range. */
static void test_widths(void **state)
{
    (void)state;
    for (uint8_t mt = 0; mt <= 32; mt++) {
        for (uint8_t st = 8; st <= 32 && mt + st <= 49; st++) {
            struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3674-biss"));
            model.multiturn_bits = mt;
            model.singleturn_bits = st;
            assert_int_equal(biss_rig_init(&rig, &model, 1), DG_OK);
            assert_int_equal(biss_rig_power_on(&rig), DG_OK);
            rig.angle = -1; /* one below 0: all ones */
            (void)biss_rig_frame(&rig, false);
            const unsigned n = (unsigned)mt + st + 8u;
            const uint64_t data = (((uint64_t)1 << (n - 6u)) - 1u) << 6;
            assert_int_equal(rig.data_bits, n + 6u);
            assert_true(rig.bits == (data << 6 | biss_rig_crc6(data, n)));
        }
    }
}

/* Bits of the frame by a table of the manual's, one field behind the other. */
static uint64_t frame_of(const struct dg_biss_model *model, const struct dg_biss_data *data)
{
    uint64_t bits = (uint64_t)data->multiturn << model->singleturn_bits | data->singleturn;
    unsigned n = (unsigned)(model->multiturn_bits + model->singleturn_bits + 2u);

    bits = bits << 2 | (data->n_err ? 2u : 0u) | (data->n_warn ? 1u : 0u);
    if (model->life_counter) {
        bits = bits << 6 | data->life;
        n += 6u;
    }
    return bits << 6 | biss_rig_crc6(bits, n);
}

/* What comes in front, CDS and whatever a master has shifted in before it, is not looked at. */
static void test_frames_are_taken_apart(void **state)
{
    static const struct {
        uint8_t mt;
        uint8_t st;
        bool lc;
        uint8_t bits;
    } rows[] = {{0, 12, false, 20}, {0, 21, true, 35},   {12, 21, true, 47},
                {24, 24, true, 62}, {24, 12, false, 44}, {1, 24, true, 39},
                {0, 8, false, 16},  {17, 32, true, 63},  {32, 17, true, 63}};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_biss_model model = {.multiturn_bits = rows[i].mt,
                                      .singleturn_bits = rows[i].st,
                                      .life_counter = rows[i].lc};
        const uint64_t front = UINT64_MAX << rows[i].bits;
        assert_int_equal(dg_biss_frame_bits(&model), rows[i].bits);
        for (uint32_t n = 0; n < 256; n++) {
            const struct dg_biss_data sent = {
                .multiturn = (uint32_t)(n * 0x9E3779B1u & ((UINT64_C(1) << rows[i].mt) - 1u)),
                .singleturn = (uint32_t)(n * 0x85EBCA77u & ((UINT64_C(1) << rows[i].st) - 1u)),
                .life = rows[i].lc ? n & 63u : 0,
                .n_err = (n & 1u) != 0,
                .n_warn = (n & 2u) != 0,
            };
            struct dg_biss_data got;
            const uint64_t bits = frame_of(&model, &sent);
            dg_biss_frame_decode(&model, bits | front, &got);
            assert_int_equal(got.multiturn, sent.multiturn);
            assert_int_equal(got.singleturn, sent.singleturn);
            assert_true(got.position == ((uint64_t)sent.multiturn << rows[i].st | sent.singleturn));
            assert_int_equal(got.life, sent.life);
            assert_int_equal(got.n_err, sent.n_err);
            assert_int_equal(got.n_warn, sent.n_warn);
            assert_true(got.crc_ok);
            dg_biss_frame_decode(&model, bits ^ (uint64_t)1 << n % rows[i].bits, &got);
            assert_false(got.crc_ok);
        }
    }
}

static void test_refused_figures(void **state)
{
    static const struct dg_biss_model good = {.multiturn_bits = 17,
                                              .singleturn_bits = 32,
                                              .life_counter = true,
                                              .busy = 40000,
                                              .eeprom_read = 20000000};
    struct dg_biss_model bad[] = {good, good, good, good, good, good, good, good, good, good};

    (void)state;
    assert_int_equal(biss_rig_init(&rig, &good, 1), DG_OK);
    bad[0].multiturn_bits = 18; /* 64 bits */
    bad[1].singleturn_bits = 33;
    bad[2].singleturn_bits = 7;
    bad[3].busy = 40001;
    bad[4].eeprom_write = 1;
    bad[5].eeprom_read = 20000001;
    bad[6].timeout = 1000000001;
    bad[7].busy_jitter = 1;
    bad[8].busy = 0;
    bad[8].busy_jitter = 40001;
    bad[9].multiturn_bits = 33;
    bad[9].singleturn_bits = 8;
    for (size_t i = 0; i < DG_COUNT(bad); i++) {
        assert_int_equal(biss_rig_init(&rig, &bad[i], 1), DG_ERR_ARGUMENT);
    }
}

/* A host with a slow line chooses the timeout; 7Ch is kept and means nothing then. */
static void test_chosen_timeout(void **state)
{
    static const struct {
        dg_ns chosen;
        uint8_t register_7c;
        dg_ns silence;
    } rows[] = {
        {0, 0, 13000}, {0, 1, 1300}, {20000000, 0, 20000000}, {20000000, 1, 20000000}, {1, 0, 1},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3674-biss"));
        struct dg_biss *slave = &rig.slave[0];
        assert_int_equal(biss_rig_init(&rig, &model, 1), DG_OK);
        assert_int_equal(biss_rig_power_on(&rig), DG_OK);
        assert_int_equal(biss_rig_put(&rig, 0x7C, rows[i].register_7c), 1);
        rig.model.timeout = rows[i].chosen;
        const dg_ns edge = rig.now + DG_MS(1);
        (void)dg_biss_ma(slave, edge, false);
        assert_true(dg_biss_step(slave, edge) == edge + rows[i].silence);
    }
}

/* The start bit comes with the first rising edge that is not before the end of the busy time. */
static void test_busy(void **state)
{
    static const dg_ns halves[] = {50, 500, 3000, 10000};

    (void)state;
    for (dg_ns busy = 0; busy <= 40000; busy += 2500) {
        for (size_t i = 0; i < 4; i++) {
            struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3674-biss"));
            model.busy = busy;
            assert_int_equal(biss_rig_init(&rig, &model, 1), DG_OK);
            assert_int_equal(biss_rig_power_on(&rig), DG_OK);
            rig.half_ns = halves[i];
            (void)biss_rig_frame(&rig, false);
            const dg_ns clocks = (busy + 2u * halves[i] - 1u) / (2u * halves[i]);
            assert_int_equal(rig.clocks, clocks > 2 ? clocks : 2);
            const uint64_t data = 3u << 6;
            assert_true(rig.bits == (data << 6 | biss_rig_crc6(data, 29)));
        }
    }
}

/* Between busy and busy + jitter, both ends reached, half of it on the average; the same again from
   the same state. */
static void test_busy_jitter(void **state)
{
    struct dg_biss *slave = &rig.slave[0];
    dg_ns least = DG_NEVER;
    dg_ns most = 0;
    dg_ns sum = 0;

    (void)state;
    assert_int_equal(slave->noise, 123456789);
    rig.model.busy = 1000;
    rig.model.busy_jitter = 99;
    for (unsigned i = 0; i < 4000; i++) {
        const struct dg_biss before = *slave;
        uint64_t bits = 0;
        (void)dg_biss_frame(slave, rig.now, &bits);
        const dg_ns busy = slave->line.start - rig.now;
        least = busy < least ? busy : least;
        most = busy > most ? busy : most;
        sum += busy;
        *slave = before;
        (void)dg_biss_frame(slave, rig.now, &bits);
        assert_int_equal(slave->line.start - rig.now, busy);
    }
    assert_int_equal(least, 1000);
    assert_int_equal(most, 1099);
    assert_in_range(sum / 4000u, 1047, 1052);
    rig.model.busy_jitter = 40000 - 1000;
    slave->noise = 0x58E0F1E9; /* whose successor is FFFF1234h: the longest */
    (void)biss_rig_frame(&rig, false);
    assert_int_equal(slave->noise >> 16, 0xFFFF);
    assert_int_equal(rig.clocks, 40);
}

/* Low from power-on to e1, and from a soft reset to e1; high without power. */
static void test_low_at_start(void **state)
{
    struct dg_biss *slave = &rig.slave[0];
    uint64_t bits = 0;

    (void)state;
    assert_false(dg_biss_slo(slave, false));
    assert_false(dg_biss_slo(slave, true));
    (void)dg_biss_ma(slave, rig.now, false);
    assert_false(dg_biss_slo(slave, false));
    assert_true(dg_biss_ma(slave, rig.now += 500, true));
    assert_true(dg_biss_step(slave, rig.now += 14000) == DG_NEVER);
    assert_true(dg_biss_slo(slave, false));
    dg_biss_power_off(slave);
    assert_true(dg_biss_slo(slave, false));
    assert_int_equal(dg_biss_power_on(slave, rig.now), DG_OK);
    assert_false(dg_biss_slo(slave, false));
    /* Frames at once have an e1, too. */
    (void)dg_biss_frame(slave, rig.now, &bits);
    dg_biss_frame_end(slave, rig.now, false);
    assert_true(dg_biss_slo(slave, false));
    rig.model.sl_low_at_start = false;
    assert_int_equal(dg_biss_power_on(slave, rig.now), DG_OK);
    assert_true(dg_biss_slo(slave, false));
}

/* A memory of another device: it stays off, SLO as without power. */
static void test_foreign_memory_at_start(void **state)
{
    (void)state;
    memset(rig.nvm[0].bytes, 0x5A, 64);
    assert_int_equal(dg_biss_power_on(&rig.slave[0], rig.now), DG_ERR_FOREIGN);
    assert_true(dg_biss_slo(&rig.slave[0], false));
}

/* 50 kHz to 10 MHz, every edge off by up to 25 % of half a period. */
static void test_clock_rates(void **state)
{
    (void)state;
    rig.angle = DG_TURN / 3;
    rig.jitter = 250;
    for (dg_ns half = 50; half <= 10000; half = half * 5u / 4u) {
        rig.half_ns = half;
        for (unsigned i = 0; i < 10; i++) {
            (void)biss_rig_frame(&rig, i % 2u != 0);
            assert_int_equal(rig.bits >> 14, 0x0AAAAA);
            assert_int_equal(rig.bits & 0x3Fu, biss_rig_crc6(rig.bits >> 6, 29));
        }
    }
}

/* After CDM = 1 the return of MA is no latch edge, however long MA stays low. */
static void test_return_edge(void **state)
{
    (void)state;
    for (dg_ns low = 0; low < 100000; low += 10000) {
        (void)biss_rig_begin(&rig);
        (void)biss_rig_edge(&rig, false);
        rig.now += 14000 + low;
        assert_true(dg_biss_ma(&rig.slave[0], rig.now, true));
        const uint32_t frames = rig.slave[0].counters.frames;
        (void)biss_rig_frame(&rig, false);
        assert_int_equal(rig.slave[0].counters.frames, frames + 1u);
        assert_int_equal(rig.bits & 0x3Fu, biss_rig_crc6(rig.bits >> 6, 29));
    }
}

/* Every prefix of a frame is forgotten after the timeout; the next frame is in order. */
static void test_cut_short(void **state)
{
    (void)state;
    (void)biss_rig_frame(&rig, false);
    for (uint32_t edges = 0; edges <= 90; edges++) {
        const uint8_t zeros = rig.slave[0].control.zeros;
        biss_rig_cut(&rig, edges);
        /* MA low counts as CDM = 1, but two clocks are the shortest frame. */
        const uint8_t expected = edges < 4        ? zeros
                                 : edges % 2 != 0 ? 0
                                 : zeros < 14     ? (uint8_t)(zeros + 1u)
                                                  : 14;
        assert_int_equal(rig.slave[0].control.zeros, expected);
        assert_true(dg_biss_slo(&rig.slave[0], false));
        (void)biss_rig_frame(&rig, false);
        assert_int_equal(rig.bits & 0x3Fu, biss_rig_crc6(rig.bits >> 6, 29));
    }
}

static void test_stuck_low(void **state)
{
    const bool low_idle = false;

    (void)state;
    (void)dg_biss_ma(&rig.slave[0], rig.now, low_idle);
    rig.now += DG_S(1);
    /* No latch edge after that, so that SLO stays as at the start. */
    assert_false(dg_biss_ma(&rig.slave[0], rig.now, true));
    assert_int_equal(rig.slave[0].counters.frames, 0);
    (void)biss_rig_frame(&rig, false);
    assert_int_equal(rig.slave[0].counters.frames, 1);
    assert_int_equal(rig.bits & 0x3Fu, biss_rig_crc6(rig.bits >> 6, 29));
}

/* 40 us of silence inside Ack: the frame is over, SLO is high, the next one is in order. */
static void test_silence_in_ack(void **state)
{
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3674-biss"));

    (void)state;
    model.busy = 40000;
    assert_int_equal(biss_rig_init(&rig, &model, 1), DG_OK);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    for (unsigned i = 0; i < 4; i++) {
        (void)biss_rig_edge(&rig, i % 2u != 0);
    }
    assert_false(dg_biss_slo(&rig.slave[0], false));
    rig.now += 40000;
    (void)dg_biss_step(&rig.slave[0], rig.now);
    assert_true(dg_biss_slo(&rig.slave[0], false));
    (void)biss_rig_frame(&rig, false);
    assert_int_equal(rig.bits & 0x3Fu, biss_rig_crc6(rig.bits >> 6, 29));
}

/* The same level again is no edge and does not put the timeout off. */
static void test_no_edge(void **state)
{
    (void)state;
    (void)biss_rig_begin(&rig);
    const dg_ns end = rig.now + DG_BISS_TIMEOUT_NS;
    for (unsigned i = 0; i < 4; i++) {
        assert_false(dg_biss_ma(&rig.slave[0], rig.now + 3000u * i, true));
        assert_int_equal(rig.slave[0].line.deadline, end);
    }
    assert_true(dg_biss_ma(&rig.slave[0], end, true));
}

/* A host that never steps, one that is late and one that is on time see the same. */
static void test_late_step(void **state)
{
    struct dg_biss on_time;

    (void)state;
    (void)biss_rig_begin(&rig);
    const struct dg_biss open = rig.slave[0];
    (void)dg_biss_step(&rig.slave[0], rig.now + DG_BISS_TIMEOUT_NS);
    (void)dg_biss_ma(&rig.slave[0], rig.now + 50000, false);
    on_time = rig.slave[0];
    rig.slave[0] = open;
    (void)dg_biss_ma(&rig.slave[0], rig.now + 50000, false);
    assert_memory_equal(&rig.slave[0], &on_time, sizeof on_time);
    rig.slave[0] = open;
    (void)dg_biss_step(&rig.slave[0], rig.now + 45000);
    (void)dg_biss_ma(&rig.slave[0], rig.now + 50000, false);
    assert_memory_equal(&rig.slave[0], &on_time, sizeof on_time);
}

/* A clock that goes backwards stands still. */
static void test_time_backwards(void **state)
{
    (void)state;
    (void)biss_rig_begin(&rig);
    const dg_ns deadline = rig.slave[0].line.deadline;
    (void)dg_biss_ma(&rig.slave[0], rig.now - 5000, false);
    assert_int_equal(rig.slave[0].line.deadline, deadline);
}

/* Also behind the first edge of a frame. */
static void test_time_backwards_from_the_first_edge(void **state)
{
    (void)state;
    rig.now += DG_US(100);
    (void)dg_biss_ma(&rig.slave[0], rig.now, false);
    (void)dg_biss_ma(&rig.slave[0], rig.now, true);
    const dg_ns deadline = rig.slave[0].line.deadline;
    assert_true(deadline > rig.now && deadline != DG_NEVER);
    (void)dg_biss_ma(&rig.slave[0], rig.now - 5000, false);
    assert_int_equal(rig.slave[0].line.deadline, deadline);
}

static void test_without_power(void **state)
{
    uint64_t bits = 1;

    (void)state;
    dg_biss_power_off(&rig.slave[0]);
    for (unsigned i = 0; i < 20; i++) {
        assert_true(biss_rig_edge(&rig, i % 2u != 0));
    }
    assert_true(dg_biss_step(&rig.slave[0], rig.now + DG_S(1)) == DG_NEVER);
    assert_int_equal(dg_biss_frame(&rig.slave[0], rig.now, &bits), 0);
    assert_int_equal(bits, 0);
    dg_biss_frame_end(&rig.slave[0], rig.now, true);
    assert_int_equal(rig.slave[0].counters.frames, 0);
}

/* During the initialisation: position 0, error and warning; the life counter counts. */
static void test_initialisation(void **state)
{
    (void)state;
    rig.angle = DG_TURN / 2;
    assert_int_equal(dg_biss_power_on(&rig.slave[0], rig.now), DG_OK);
    (void)biss_rig_frame(&rig, false);
    assert_true(rig.bits == biss_rig_crc6(0, 29));
    rig.now += rig.model.init;
    (void)biss_rig_frame(&rig, false);
    assert_int_equal(rig.bits >> 14, 0x100000);
    assert_int_equal(rig.bits >> 6 & 0xFFu, 0xC1);
}

/* Random control bits, shaft, errors and busy: frames at once and frames by edges are the same. */
static void test_words_equal_edges(void **state)
{
    static struct biss_rig edges;
    static struct biss_rig words;
    uint32_t noise = 7;

    (void)state;
    for (unsigned round = 0; round < 40; round++) {
        struct dg_biss_model model =
            *dg_biss_model_of(dg_device_find(round % 2u != 0 ? "s3674-biss" : "s3684-biss"));
        model.busy = round * 1000u;
        model.busy_jitter = (40u - round) * 1000u;
        model.life_counter = round % 3u != 0;
        assert_int_equal(biss_rig_init(&edges, &model, 1), DG_OK);
        assert_int_equal(biss_rig_init(&words, &model, 1), DG_OK);
        edges.angle_per_us = words.angle_per_us = (int64_t)round * 1000003;
        words.words = true;
        assert_int_equal(biss_rig_power_on(&edges), DG_OK);
        assert_int_equal(biss_rig_power_on(&words), DG_OK);
        for (unsigned i = 0; i < 400; i++) {
            noise = noise * 1664525u + 1013904223u;
            /* Mostly a control frame that reads 78h.., some bits flipped. */
            const char *frame = "00000000000000"
                                "1100011110000101101000000000000010000000000000";
            const bool cdm = (frame[i % 60u] == '1') != (noise >> 26 == 0);
            edges.world.watchdog_fired = words.world.watchdog_fired = (noise >> 20 & 3u) == 0;
            assert_int_equal(biss_rig_frame(&edges, cdm), biss_rig_frame(&words, cdm));
            assert_true(edges.bits == words.bits);
            assert_int_equal(edges.now, words.now);
            assert_memory_equal(&edges.slave[0].control, &words.slave[0].control,
                                sizeof edges.slave[0].control);
            assert_memory_equal(&edges.slave[0].counters, &words.slave[0].counters,
                                sizeof edges.slave[0].counters);
            assert_true(edges.slave[0].position == words.slave[0].position);
            assert_int_equal(edges.slave[0].life, words.slave[0].life);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_crc6_vectors, setup),
        cmocka_unit_test_setup(test_frames_are_taken_apart, setup),
        cmocka_unit_test_setup(test_crc_any_length, setup),
        cmocka_unit_test_setup(test_address_words, setup),
        cmocka_unit_test_setup(test_every_edge, setup),
        cmocka_unit_test_setup(test_latched_at_e1, setup),
        cmocka_unit_test_setup(test_life_counter, setup),
        cmocka_unit_test_setup(test_without_life_counter, setup),
        cmocka_unit_test_setup(test_widths, setup),
        cmocka_unit_test_setup(test_refused_figures, setup),
        cmocka_unit_test_setup(test_chosen_timeout, setup),
        cmocka_unit_test_setup(test_busy, setup),
        cmocka_unit_test_setup(test_busy_jitter, setup),
        cmocka_unit_test_setup(test_low_at_start, setup),
        cmocka_unit_test_setup(test_foreign_memory_at_start, setup),
        cmocka_unit_test_setup(test_clock_rates, setup),
        cmocka_unit_test_setup(test_return_edge, setup),
        cmocka_unit_test_setup(test_cut_short, setup),
        cmocka_unit_test_setup(test_stuck_low, setup),
        cmocka_unit_test_setup(test_silence_in_ack, setup),
        cmocka_unit_test_setup(test_no_edge, setup),
        cmocka_unit_test_setup(test_late_step, setup),
        cmocka_unit_test_setup(test_time_backwards, setup),
        cmocka_unit_test_setup(test_time_backwards_from_the_first_edge, setup),
        cmocka_unit_test_setup(test_without_power, setup),
        cmocka_unit_test_setup(test_initialisation, setup),
        cmocka_unit_test_setup(test_words_equal_edges, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
