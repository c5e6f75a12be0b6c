/* SPDX-License-Identifier: MIT */
/*
 * Control frames of the S36 with BiSS, bit for bit: register accesses, commands, what is not in
 * order, and several slaves on a line. The two complete frames are those of a third-party master.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "biss_rig.h"
#include "drehgeber/devices.h"

#define ZEROS "00000000000000 "

static struct biss_rig rig;

static int setup(void **state)
{
    (void)state;
    return biss_rig_init(&rig, dg_biss_model_of(dg_device_find("s3674-biss")), 1) != DG_OK ||
           biss_rig_power_on(&rig) != DG_OK;
}

static void send_cdm(const char *cdm, const char *expected)
{
    char wanted[512];
    char cds[512];
    size_t n = 0;

    for (; *expected != '\0'; expected++) {
        if (*expected != ' ') {
            wanted[n++] = *expected;
        }
    }
    wanted[n] = '\0';
    biss_rig_send(&rig, cdm, cds);
    assert_string_equal(cds, wanted);
}

static void test_read_frame(void **state)
{
    (void)state;
    biss_rig_zeros(&rig);
    /*    S CTS ID ADR     CRC  R W S  data     CRC  P  */
    send_cdm("1 1 000 1111000 0101 1 0 1 00000000 0000 0 0",
             "0 1 0000000 0 0000000 1 0 1 01001011 0110 0");
}

/* The example's frame reads 78h = 4Bh: a device whose first byte of the id is 4Bh. */
static int setup_4b(void **state)
{
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3674-biss"));

    (void)state;
    model.device_id[0] = 0x4B;
    return biss_rig_init(&rig, &model, 1) != DG_OK || biss_rig_power_on(&rig) != DG_OK;
}

static void test_write_frame(void **state)
{
    (void)state;
    biss_rig_zeros(&rig);
    send_cdm("1 1 000 0011011 1101 0 1 1 10100101 0100 0 0",
             "0 1 0000000 0 0000000 0 1 1 10100101 0100 0");
    assert_int_equal(rig.slave[0].config[0], 0xA5 & 0xC7);
}

/* 78h..7Fh in one control frame: 04 00 C0 15 00 00 4B 55, then the end of the address space. */
static void test_sequential_read(void **state)
{
    uint8_t bytes[9] = {0};

    (void)state;
    biss_rig_zeros(&rig);
    send_cdm("1 1 000 1111000 0101 1 0 1 00000000 0000 0 1 00000000 0000 0 1 00000000 0000 0 0",
             "0 1 0000000 0 0000000 1 0 1 00000100 0011 0 1 00000000 1111 0 1 11000000 0110 0");
    assert_int_equal(biss_rig_read(&rig, 0, 0x78, bytes, sizeof bytes), 8);
    assert_memory_equal(bytes, "\x04\x00\xC0\x15\x00\x00\x4B\x55", 8);
    assert_true(rig.p);
    assert_int_equal(biss_rig_read(&rig, 0, 0x78, bytes, 8), 8);
    assert_false(rig.p);
}

/* Across 3Fh, too, and not beyond a register that is not there: that one's P is 1. */
static void test_sequence_ends(void **state)
{
    uint8_t bytes[64] = {0};

    (void)state;
    assert_int_equal(biss_rig_put(&rig, 0x40, 3), 1);
    assert_int_equal(biss_rig_read(&rig, 0, 0x00, bytes, 64), 64);
    assert_false(rig.p);
    assert_int_equal(biss_rig_read(&rig, 0, 0x3E, bytes, 4), 2);
    assert_int_equal(biss_rig_read(&rig, 0, 0x6A, bytes, 4), 2);
    assert_true(rig.p);
    assert_int_equal(biss_rig_read(&rig, 0, 0x45, bytes, 2), 2);
    assert_false(rig.p);
    /* 6Bh of 37 degC, the byte behind it, and no S for a master that goes on after P = 1. */
    rig.world.temperature_mdegc = 37000;
    biss_rig_zeros(&rig);
    send_cdm("1 1 000 1101011 0101 1 0 1 00000000 0000 0 1 00000000 0000 0 1 00000000 0000 0 0",
             "0 1 0000000 0 0000000 1 0 1 00000001 1100 0 1 00000000 1111 1 0 00000000 0000 0");
    assert_int_equal(rig.slave[0].counters.refused, 3);
}

/* Early: P = 1 in front of a register that refuses, and no S behind it. */
static void test_early_stop_bit(void **state)
{
    uint8_t bytes[9] = {0};

    (void)state;
    rig.model.stop_bit_early = true;
    assert_int_equal(biss_rig_read(&rig, 0, 0x78, bytes, 8), 8);
    assert_true(rig.p);
    assert_int_equal(biss_rig_put(&rig, 0x40, 3), 1);
    assert_true(rig.p);
    assert_int_equal(biss_rig_read(&rig, 0, 0x3E, bytes, 4), 2);
    assert_int_equal(biss_rig_read(&rig, 0, 0x45, bytes, 2), 2);
    assert_false(rig.p);
    rig.world.temperature_mdegc = 37000;
    biss_rig_zeros(&rig);
    send_cdm("1 1 000 1101011 0101 1 0 1 00000000 0000 0 1 00000000 0000 0 0",
             "0 1 0000000 0 0000000 1 0 1 00000001 1100 1 0 00000000 0000 0");
    assert_int_equal(rig.slave[0].counters.refused, 0);
}

/* A master that stops at S, and one that stops behind P: a 1 before 14 zeros does not go on. */
static void test_stops_at_s(void **state)
{
    (void)state;
    biss_rig_zeros(&rig);
    send_cdm("1 1 000 0011100 0100 0 1 0 1 10100101 0100 0 0",
             "0 1 0000000 0 0000000 0 1 0 0 00000000 0000 0");
    biss_rig_zeros(&rig);
    send_cdm("1 1 000 0011100 0100 0 1 1 10100101 0100 0 0 0 1 10100101 0100 0 0",
             "0 1 0000000 0 0000000 0 1 1 10100101 0100 0 0 0 00000000 0000 00");
    assert_int_equal(rig.slave[0].config[1], 0xA5);
    assert_int_equal(rig.slave[0].config[2], 0);
    assert_int_equal(rig.slave[0].counters.writes, 1);
}

static void test_refused(void **state)
{
    (void)state;
    rig.world.temperature_mdegc = 0;
    /* 48h is not implemented: R = W = 1, W = R = 0. */
    assert_int_equal(biss_rig_address(&rig, 0, 0x48, false), 3);
    assert_int_equal(biss_rig_address(&rig, 0, 0x48, true), 0);
    assert_int_equal(biss_rig_address(&rig, 0, 0x78, true), 0);
    assert_int_equal(rig.slave[0].counters.refused, 3);
    /* No S follows, whatever the master sends. */
    biss_rig_zeros(&rig);
    send_cdm("1 1 000 1001000 1010 1 0 1 1 1 1 1 0000 0000 0 0 0",
             "0 1 0000000 0 0000000 1 1 0 0 0 0 0 0000 0000 0 0");
    assert_int_equal(rig.slave[0].counters.reads, 0);
}

/* R = W is nothing that can be done: the answer is R = W. */
static void test_r_equals_w(void **state)
{
    (void)state;
    biss_rig_zeros(&rig);
    send_cdm("1 1 000 1111000 0101 0 0 1 0000 0000", "0 1 0000000 0 0000000 0 0 0000 0000");
    biss_rig_zeros(&rig);
    send_cdm("1 1 000 1111000 0101 1 1 1 0000 0000", "0 1 0000000 0 0000000 1 1 0000 0000");
    assert_int_equal(rig.slave[0].counters.refused, 2);
}

static void test_not_addressed(void **state)
{
    (void)state;
    for (uint8_t id = 1; id < 8; id++) {
        assert_int_equal(biss_rig_address(&rig, id, 0x78, false), 0);
    }
    assert_int_equal(biss_rig_address(&rig, 0, 0x78, false), 2);
}

static void test_bad_address_crc(void **state)
{
    char frame[] = "1 1 000 1111000 0101 1 0 1 00000000 0000 0 0";

    (void)state;
    for (size_t i = 2; i < 20; i++) {
        if (frame[i] == ' ') {
            continue;
        }
        frame[i] ^= 1; /* one bit of CTS, ID, ADR or CRC */
        biss_rig_zeros(&rig);
        send_cdm(frame, "0 1 0000000 0 0000000 0 0 0 00000000 0000 0");
        frame[i] ^= 1;
    }
    assert_int_equal(rig.slave[0].counters.damaged, 15);
}

/* Neither stored with a bad CRC nor without the stop bit; P says so. */
static void test_bad_write_data(void **state)
{
    char frame[] = "1 1 000 0011011 1101 0 1 1 10000001 0010 0 0";
    const size_t data = sizeof "1 1 000 0011011 1101 0 1 1";
    const uint8_t before = rig.slave[0].config[0];

    (void)state;
    for (size_t i = data; i < data + 15u; i++) {
        char expected[] = "0 1 0000000 0 0000000 0 1 1 00000000 0000 1";
        if (frame[i] == ' ') {
            continue;
        }
        frame[i] ^= 1;
        memcpy(&expected[sizeof "0 1 0000000 0 0000000 0 1 1"], &frame[data], 13);
        biss_rig_zeros(&rig);
        send_cdm(frame, expected);
        frame[i] ^= 1;
        assert_int_equal(rig.slave[0].config[0], before);
    }
    assert_int_equal(rig.slave[0].counters.damaged, 13);
    assert_int_equal(rig.slave[0].counters.writes, 0);
}

/* 13 zeros are too few; one more makes it. */
static void test_too_few_zeros(void **state)
{
    const char *frame = "1 1 000 1111000 0101 1 0 1 00000000 0000 0 0";

    (void)state;
    for (unsigned zeros = 0; zeros < 14; zeros++) {
        assert_int_equal(setup(state), 0);
        for (unsigned i = 0; i < zeros; i++) {
            (void)biss_rig_frame(&rig, false);
        }
        send_cdm(frame, "0 0 0000000 0 0000000 0 0 0 00000000 0000 0");
        assert_int_equal(rig.slave[0].counters.reads, 0);
    }
    biss_rig_zeros(&rig);
    send_cdm(frame, "0 1 0000000 0 0000000 1 0 1 00000100 0011 0");
}

/* 14 zeros in any place of a frame, and the next one is understood: a read, a write, an addressed
   command, and sequences whose second byte is refused, with both kinds of P. */
static void test_aborted_anywhere(void **state)
{
    const char *frames[] = {"11000111100001011010000000000000", "11000001101111010111010010101000",
                            "1010000000000010"
                            "1"
                            "0000000"
                            "1",
                            "1100011111111100101"
                            "0000000000000"
                            "1"
                            "0000000000000"
                            "1",
                            "1100010000000001011"
                            "0000000011110"
                            "1"
                            "1010010101000"
                            "1"};

    (void)state;
    for (size_t f = 0; f < 2u * DG_COUNT(frames); f++) {
        const char *frame = frames[f / 2u];
        for (size_t n = 0; n <= strlen(frame); n++) {
            char part[64] = "";
            char cds[64];
            assert_int_equal(setup(state), 0);
            rig.model.stop_bit_early = f % 2u != 0;
            biss_rig_zeros(&rig);
            memcpy(part, frame, n);
            biss_rig_send(&rig, part, cds);
            biss_rig_zeros(&rig);
            assert_int_equal(rig.slave[0].control.state, DG_BISS_CONTROL_READY);
            send_cdm("1 1 000 1111110 1111 1 0 1 00000000 0000 0 0",
                     "0 1 0000000 0 0000000 1 0 1 01001011 0110 0");
        }
    }
}

/* What a master sends in the data of a read means nothing: some repeat S once too often. */
static void test_stray_bits_in_read(void **state)
{
    (void)state;
    biss_rig_zeros(&rig);
    send_cdm("1 1 000 1111110 1111 1 0 1 10000000 0000 0 1 11111111 1111 1 0",
             "0 1 0000000 0 0000000 1 0 1 01001011 0110 0 1 01010101 0010 0");
}

/* A user bank is busy: S comes late, the master repeats its own. */
static void test_busy(void **state)
{
    uint8_t byte = 0;

    (void)state;
    rig.model.eeprom_read = DG_US(100);
    rig.model.eeprom_write = DG_MS(5);
    assert_int_equal(biss_rig_put(&rig, 0x40, 7), 1);
    for (unsigned frames = 1; frames < 6; frames++) {
        assert_int_equal(biss_rig_address(&rig, 0, 0x00, false), 2);
        const dg_ns begin = rig.now;
        unsigned busy = 0;
        while (!biss_rig_begin(&rig)) {
            biss_rig_end(&rig, true);
            busy++;
        }
        assert_in_range(rig.now - begin, DG_US(100), DG_US(200));
        assert_int_equal(busy, 2);
        biss_rig_end(&rig, false);
    }
    /* What a write needs afterwards is told by the next access, and in the status. */
    assert_int_equal(biss_rig_put(&rig, 0x05, 0x5A), 1);
    const dg_ns written = rig.now;
    assert_int_equal(biss_rig_get(&rig, 0x60) & DG_BISS_STATUS_BUSY, DG_BISS_STATUS_BUSY);
    assert_int_equal(biss_rig_read(&rig, 0, 0x05, &byte, 1), 1);
    assert_int_equal(byte, 0x5A);
    assert_in_range(rig.now - written, DG_MS(5), DG_MS(8));
    assert_int_equal(biss_rig_get(&rig, 0x60) & DG_BISS_STATUS_BUSY, 0);
}

/* A master that stops repeating S gives the access up. */
static void test_busy_given_up(void **state)
{
    (void)state;
    assert_int_equal(biss_rig_put(&rig, 0x40, 7), 1);
    assert_int_equal(biss_rig_address(&rig, 0, 0x00, false), 2);
    assert_false(biss_rig_frame(&rig, true));
    assert_false(biss_rig_frame(&rig, false));
    for (unsigned i = 0; i < 13; i++) {
        assert_false(biss_rig_frame(&rig, true));
    }
}

/* The bank is switched between two accesses of a sequence: 40h itself ends it (41h is read only).
 */
static void test_bank_switch_in_sequence(void **state)
{
    const uint8_t bytes[2] = {4, 9};

    (void)state;
    assert_int_equal(biss_rig_write(&rig, 0, 0x40, bytes, 2), 1);
    assert_true(rig.p);
    assert_int_equal(biss_rig_get(&rig, 0x40), 4);
    assert_int_equal(biss_rig_get(&rig, 0x02), 0x62);
}

/* Broadcast 00 takes the data out of the frame, addressed 00 puts it in again. */
static void test_data_channels(void **state)
{
    const uint8_t full = rig.data_bits;

    (void)state;
    assert_int_equal(biss_rig_command(&rig, 0, 0), 0);
    rig.data_bits = 10;
    (void)biss_rig_frame(&rig, false);
    assert_int_equal(rig.bits, 0);
    assert_int_equal(biss_rig_get(&rig, 0x7F), 0x55);
    assert_int_equal(biss_rig_command(&rig, 0x80, 0), 0x80);
    rig.data_bits = full;
    (void)biss_rig_frame(&rig, false);
    assert_int_equal(rig.bits & 0x3Fu, biss_rig_crc6(rig.bits >> 6, 29));
    assert_int_not_equal(rig.bits, 0);
    assert_int_equal(rig.slave[0].counters.commands, 2);
}

/* Addressed 01 takes the ID away, broadcast 01 gives it back. */
static void test_communication(void **state)
{
    (void)state;
    assert_int_equal(biss_rig_command(&rig, 0x80, 1), 0x80);
    assert_int_equal(biss_rig_get(&rig, 0x7F), BISS_RIG_SILENT);
    assert_int_equal(biss_rig_command(&rig, 0x80, 1), 0);
    assert_int_equal(biss_rig_command(&rig, 0, 1), 0);
    assert_int_equal(biss_rig_get(&rig, 0x7F), 0x55);
}

/* The rest of the commands does nothing, and neither does one for others. */
static void test_other_commands(void **state)
{
    (void)state;
    for (uint8_t command = 2; command < 4; command++) {
        assert_int_equal(biss_rig_command(&rig, 0, command), 0);
        assert_int_equal(biss_rig_command(&rig, 0xFF, command), 0x80);
    }
    assert_int_equal(biss_rig_command(&rig, 0x7F, 1), 0);
    assert_int_equal(biss_rig_command(&rig, 0x7F, 0), 0);
    assert_int_equal(rig.slave[0].counters.commands, 4);
    assert_false(rig.slave[0].channel_off);
    assert_int_equal(biss_rig_get(&rig, 0x7F), 0x55);
}

/* Command frames bit by bit: CRC of 00 01 10 11, EX = 0, a bit between S and EX, no S. */
static void test_command_frames(void **state)
{
    static const struct {
        const char *cdm;
        unsigned executed;
    } rows[] = {
        {"1 0 00000000 00 1111 1 1", 1},         {"1 0 00000000 01 1100 1 1", 1},
        {"1 0 00000000 10 1001 1 1", 1},         {"1 0 00000000 11 1010 1 1", 1},
        {"1 0 00000000 00 1111 1 0", 0},         {"1 0 00000000 00 1110 1 1", 0},
        {"1 0 00000000 00 1111 0 1", 0},         {"1 0 10000000 00 0010 1 0000000 1", 1},
        {"1 0 10000000 00 0010 1 0000000 0", 0}, {"1 0 10000000 00 0010 1 0010000 1", 0},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        char cds[64];
        const uint32_t before = rig.slave[0].counters.commands;
        rig.slave[0].channel_off = false;
        rig.data_bits = 41;
        biss_rig_zeros(&rig);
        biss_rig_send(&rig, rows[i].cdm, cds);
        assert_int_equal(rig.slave[0].counters.commands - before, rows[i].executed);
    }
    rig.data_bits = 35;
    biss_rig_zeros(&rig);
    send_cdm("1 0 10000000 01 0001 1 0000000 0 0", "0 1 0000000000 00000 1 0000000 0");
}

/* Two clocks and the CDM bit are enough for a broadcast. */
static void test_reduced_frames(void **state)
{
    const char *frame = "00000000000000"
                        "1"
                        "00000000000"
                        "1111"
                        "11";

    (void)state;
    for (; *frame != '\0'; frame++) {
        biss_rig_cut(&rig, *frame == '1' ? 5 : 4);
    }
    assert_true(rig.slave[0].channel_off);
}

static void init_chain(uint8_t count)
{
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3674-biss"));

    model.busy = 0;
    assert_int_equal(biss_rig_init(&rig, &model, count), DG_OK);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
}

/* Start bit one clock later for each slave; all data, the first slave's first; IDs from the end. */
static void test_chain(void **state)
{
    char idl[] = "00000000";

    (void)state;
    for (uint8_t count = 1; count <= DG_BISS_CHAIN_MAX; count++) {
        init_chain(count);
        rig.data_bits = 35;
        for (uint8_t i = 0; i < count; i++) {
            rig.slave[i].config[3] = (uint8_t)(0u - i); /* OFFS_ST: 2^13 counts apart */
        }
        /* The last slave takes IDL0 and so on. */
        idl[count - 1] = '1';
        biss_rig_zeros(&rig);
        assert_int_equal(rig.clocks, 1u + count);
        char expected[64];
        (void)snprintf(expected, sizeof expected, "0 %s 0000000 0", idl);
        send_cdm("1 1 111 1111000 0000 0", expected);
        for (uint8_t i = 0; i < count; i++) {
            uint8_t byte = 0;
            const uint8_t id = (uint8_t)(count - 1u - i);
            assert_int_equal(biss_rig_read(&rig, id, 0x1E, &byte, 1), 1);
            assert_int_equal(byte, (uint8_t)(0u - i));
        }
        if (count < DG_BISS_CHAIN_MAX) {
            assert_int_equal(biss_rig_address(&rig, count, 0x1E, false), 0);
        }
    }
}

static void test_chain_data(void **state)
{
    (void)state;
    for (uint8_t count = 1; count <= DG_BISS_CHAIN_MAX; count++) {
        init_chain(count);
        for (uint8_t i = 0; i < count; i++) {
            rig.slave[i].config[3] = (uint8_t)(0u - i);
        }
        for (unsigned edges = 0; edges < 2u * (2u + count); edges++) {
            (void)biss_rig_edge(&rig, edges % 2u != 0);
        }
        (void)biss_rig_edge(&rig, false);
        (void)biss_rig_edge(&rig, true); /* CDS */
        for (uint8_t i = 0; i < count; i++) {
            uint64_t bits = 0;
            for (unsigned bit = 0; bit < 35; bit++) {
                (void)biss_rig_edge(&rig, false);
                bits = bits << 1 | biss_rig_edge(&rig, true);
            }
            const uint64_t data = (uint64_t)i << 13 << 8 | 3u << 6;
            assert_true(bits == (data << 6 | biss_rig_crc6(data, 29)));
        }
        (void)biss_rig_edge(&rig, false);
        assert_false(biss_rig_edge(&rig, true));
        rig.now += 14000;
    }
}

/* SL stays low until all have seen the timeout. */
static void test_chain_timeout(void **state)
{
    struct dg_biss_chain chain = {.count = 2, .slave = {&rig.slave[0], &rig.slave[1]}};

    (void)state;
    init_chain(2);
    assert_int_equal(biss_rig_write(&rig, 0, 0x7C, (const uint8_t[]){1}, 1), 1);
    assert_int_equal(rig.slave[1].timeout, 1);
    (void)biss_rig_begin(&rig);
    for (unsigned i = 0; i < 40; i++) {
        (void)biss_rig_edge(&rig, false);
        (void)biss_rig_edge(&rig, true);
    }
    assert_int_equal(dg_biss_chain_step(&chain, rig.now + 1300), rig.now + 13000);
    assert_true(dg_biss_slo(&rig.slave[1], false));
    assert_false(dg_biss_chain_slo(&chain));
    assert_true(dg_biss_chain_step(&chain, rig.now + 13000) == DG_NEVER);
    assert_true(dg_biss_chain_slo(&chain));
}

/* A line between slaves that is cut, or counts what is asked of it. */
struct line {
    unsigned clocked[DG_BISS_CHAIN_MAX];
    unsigned looked;
    uint8_t last; /* slave of the latest rising edge: they come from the end */
    uint8_t cut;  /* reads high behind this slave */
};

static bool through(void *ctx, uint8_t index, bool slo, bool clocked)
{
    struct line *line = ctx;

    if (clocked) {
        assert_int_equal(index, line->last == 0 ? 2 : line->last - 1);
        line->last = index;
        line->clocked[index]++;
    } else {
        line->looked++;
    }
    return slo || index == line->cut;
}

/* A slave whose neighbour cannot be heard takes its high SLI for a neighbour, and for its
   start bit; the others do not notice. */
static void test_chain_link(void **state)
{
    struct line line = {.cut = DG_BISS_CHAIN_MAX};
    struct dg_biss_chain chain = {
        .count = 3,
        .slave = {&rig.slave[0], &rig.slave[1], &rig.slave[2]},
        .link = through,
        .ctx = &line,
    };

    (void)state;
    init_chain(3);
    for (unsigned clock = 1; clock <= 5; clock++) {
        (void)dg_biss_chain_ma(&chain, rig.now += 500, false);
        const bool sl = dg_biss_chain_ma(&chain, rig.now += 500, true);
        assert_int_equal(sl, clock == 1 || clock == 5);
        (void)dg_biss_chain_ma(&chain, rig.now += 100, true); /* no edge */
        for (uint8_t i = 0; i < 3; i++) {
            assert_int_equal(line.clocked[i], clock);
        }
    }
    assert_true(rig.slave[2].line.is_last && !rig.slave[1].line.is_last);
    (void)dg_biss_chain_step(&chain, rig.now += 14000);

    const unsigned looked = line.looked;
    assert_true(dg_biss_chain_slo(&chain));
    assert_int_equal(line.looked, looked + 3);
    line.cut = 2;
    for (unsigned clock = 1; clock <= 3; clock++) {
        (void)dg_biss_chain_ma(&chain, rig.now += 500, false);
        (void)dg_biss_chain_ma(&chain, rig.now += 500, true);
    }
    assert_true(dg_biss_slo(&rig.slave[2], false));
    assert_int_equal(rig.slave[1].line.state, DG_BISS_CDS);
    assert_int_equal(rig.slave[0].line.state, DG_BISS_WAIT);
    assert_false(dg_biss_chain_slo(&chain));
}

/* A slave that got its power while MA was low takes the first rising edge for none; its neighbours
   do not mind. */
static void test_chain_power_while_low(void **state)
{
    struct line line = {.cut = DG_BISS_CHAIN_MAX};
    struct dg_biss_chain chain = {
        .count = 3,
        .slave = {&rig.slave[0], &rig.slave[1], &rig.slave[2]},
        .link = through,
        .ctx = &line,
    };

    (void)state;
    init_chain(3);
    (void)dg_biss_chain_ma(&chain, rig.now += 500, false);
    assert_int_equal(dg_biss_power_on(&rig.slave[0], rig.now), DG_OK);
    (void)dg_biss_chain_ma(&chain, rig.now += 500, true);
    assert_int_equal(rig.slave[0].line.state, DG_BISS_IDLE);
    assert_int_equal(rig.slave[1].line.state, DG_BISS_ACK);
    assert_int_equal(line.clocked[1], 1);
}

/* Commands for some of several slaves; a slave without communication makes room for the others. */
static void test_chain_commands(void **state)
{
    uint8_t byte = 0;

    (void)state;
    init_chain(3);
    assert_int_equal(biss_rig_command(&rig, 0xFF, 3), 0xE0);
    assert_int_equal(biss_rig_command(&rig, 0x40, 1), 0x40);
    assert_true(rig.slave[1].communication_off);
    assert_int_equal(biss_rig_put(&rig, 0x40, 9), 1);
    assert_int_equal(rig.slave[2].bank, 9);
    assert_int_equal(biss_rig_read(&rig, 1, 0x40, &byte, 1), 1); /* ID 1 is slave 0 now */
    assert_int_equal(byte, 0);
    assert_int_equal(biss_rig_address(&rig, 2, 0x40, false), 0);
    assert_int_equal(biss_rig_command(&rig, 0, 1), 0);
    assert_int_equal(biss_rig_address(&rig, 2, 0x40, false), 2);
}

/* All IDs are taken in front of this slave: IDL8 says that there is one more, which has none. */
static void test_ninth_slave(void **state)
{
    struct dg_biss *slave = &rig.slave[0];
    const char *frame = "00000000000000"
                        "1100011110000101"
                        "1011";
    char cds[64] = "";

    (void)state;
    for (size_t k = 0; frame[k] != '\0'; k++) {
        const bool taken = k >= 15 && k <= 22;
        bool sli = true;
        (void)dg_biss_link(slave, rig.now += 500, false, sli);
        (void)dg_biss_link(slave, rig.now += 500, true, sli); /* e1 */
        for (unsigned clock = 2; clock <= 6; clock++) {
            /* It is no longer idle from e2 on; its start bit and CDS. */
            sli = clock == 2 || clock == 4 || (clock == 5 && taken);
            (void)dg_biss_link(slave, rig.now += 500, false, sli);
            const bool slo = dg_biss_link(slave, rig.now += 500, true, sli);
            assert_true(clock != 4 || slo);
            cds[k] = clock != 5 ? cds[k] : slo ? '1' : '0';
        }
        if (frame[k] == '1') {
            (void)dg_biss_link(slave, rig.now += 500, false, false);
        }
        (void)dg_biss_step(slave, rig.now += 14000);
        (void)dg_biss_link(slave, rig.now, true, true);
    }
    assert_string_equal(cds, "00000000000000"
                             "0111111111000000"
                             "0000");
    assert_int_equal(slave->control.id, DG_BISS_NO_ID);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_read_frame, setup_4b),
        cmocka_unit_test_setup(test_write_frame, setup),
        cmocka_unit_test_setup(test_sequential_read, setup),
        cmocka_unit_test_setup(test_sequence_ends, setup),
        cmocka_unit_test_setup(test_early_stop_bit, setup),
        cmocka_unit_test_setup(test_stops_at_s, setup),
        cmocka_unit_test_setup(test_refused, setup),
        cmocka_unit_test_setup(test_r_equals_w, setup),
        cmocka_unit_test_setup(test_not_addressed, setup),
        cmocka_unit_test_setup(test_bad_address_crc, setup),
        cmocka_unit_test_setup(test_bad_write_data, setup),
        cmocka_unit_test_setup(test_too_few_zeros, setup),
        cmocka_unit_test_setup(test_aborted_anywhere, setup),
        cmocka_unit_test_setup(test_stray_bits_in_read, setup),
        cmocka_unit_test_setup(test_busy, setup),
        cmocka_unit_test_setup(test_busy_given_up, setup),
        cmocka_unit_test_setup(test_bank_switch_in_sequence, setup),
        cmocka_unit_test_setup(test_data_channels, setup),
        cmocka_unit_test_setup(test_communication, setup),
        cmocka_unit_test_setup(test_other_commands, setup),
        cmocka_unit_test_setup(test_command_frames, setup),
        cmocka_unit_test_setup(test_reduced_frames, setup),
        cmocka_unit_test_setup(test_chain, setup),
        cmocka_unit_test_setup(test_chain_data, setup),
        cmocka_unit_test_setup(test_chain_timeout, setup),
        cmocka_unit_test_setup(test_chain_link, setup),
        cmocka_unit_test_setup(test_chain_power_while_low, setup),
        cmocka_unit_test_setup(test_chain_commands, setup),
        cmocka_unit_test_setup(test_ninth_slave, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
