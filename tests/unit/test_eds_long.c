/* SPDX-License-Identifier: MIT */
/*
 * Values of an EDS file that 32 bits do not hold, as SDO clients have them: segments and blocks, up
 * and down. The frames are written by hand from the formats of CiA 301, the CRCs come from
 * Python's binascii.crc_hqx().
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
#include "eds_rig.h"

#define ASK 0x63F
#define ANSWER 0x5BF
#define TEXT "64 72 65 68 67 65 62" /* "drehgeb" */
#define ZEROS " 00 00 00 00"
#define LONG_MAX_BYTES 1024u
#define SHOWN 1000u
#define SEGMENT 7u

static const char file[] =
    "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
    "[1010]\nObjectType=8\n[1010sub1]\nDataType=7\nAccessType=rw\nDefaultValue=1\n"
    "[1011]\nObjectType=8\n[1011sub1]\nDataType=7\nAccessType=rw\nDefaultValue=1\n"
    "[2100]\nDataType=9\nAccessType=rw\nDefaultValue=hello\n"
    "[2101]\nDataType=0x0F\nAccessType=rw\n"
    "[2102]\nDataType=0x0A\nAccessType=ro\nDefaultValue=01 02 FF 00 A5\n"
    "[2104]\nDataType=0x1B\nAccessType=rw\nDefaultValue=0x0123456789ABCDEF\n"
    "HighLimit=0x7FFFFFFFFFFFFFFF\n"
    "[2105]\nDataType=0x15\nAccessType=rw\nDefaultValue=-2\nLowLimit=-10\nHighLimit=10\n"
    "[2106]\nDataType=0x0F\nAccessType=wo\n"
    "[2107]\nDataType=0x16\nAccessType=rw\nDefaultValue=0x123456\n"
    "[2108]\nDataType=0x11\nAccessType=ro\nDefaultValue=0x3FF8000000000000\n"
    "[2109]\nDataType=0x10\nAccessType=ro\nDefaultValue=-3\n"
    "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=4096\n"
    "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=4096\n";

static struct eds_rig rig;

static void start_node(void)
{
    eds_rig_start(&rig, file);
}

/* A request, and the one answer that it has at once; "": none. */
static void ask(const char *request, const char *answer)
{
    co_rig_forget(&rig.co);
    co_rig_rx(&rig.co, ASK, request);
    co_rig_expect_count(&rig.co, answer[0] != '\0' ? 1 : 0);
    if (answer[0] != '\0') {
        co_rig_expect(&rig.co, 0, ANSWER, answer);
    }
}

/* 2100h is "hello" still. */
static void expect_hello(void)
{
    ask("40 00 21 00", "41 00 21 00 05 00 00 00");
    ask("60", "05 68 65 6C 6C 6F 00 00");
}

/* ------------------------------------------------------------ segments */

static void a_text_is_read_in_segments(void **state)
{
    (void)state;
    start_node();
    assert_int_equal(rig.note_count, 0);
    expect_hello();
    ask("40 02 21 00", "41 02 21 00 05 00 00 00");
    ask("60", "05 01 02 FF 00 A5 00 00");
    ask("40 01 21 00", "41 01 21 00 00 00 00 00");
    ask("60", "0F 00 00 00 00 00 00 00");
    ask("60", "80 00 00 00 01 00 04 05"); /* it is over */
}

static void a_text_is_written_in_segments(void **state)
{
    (void)state;
    start_node();
    ask("21 00 21 00 09 00 00 00", "60 00 21 00" ZEROS);
    ask("00 " TEXT, "20 00 00 00" ZEROS);
    ask("1B 65 72 00" ZEROS, "30 00 00 00" ZEROS);
    ask("40 00 21 00", "41 00 21 00 09 00 00 00");
    ask("60", "00 " TEXT);
    ask("70", "1B 65 72 00" ZEROS);
    /* Without a size. */
    ask("20 00 21 00", "60 00 21 00" ZEROS);
    ask("0B 68 69 00" ZEROS, "20 00 00 00" ZEROS);
    ask("40 00 21 00", "4B 00 21 00 68 69 00 00");
    /* Nothing at all. */
    ask("21 00 21 00 00 00 00 00", "60 00 21 00" ZEROS);
    ask("0F 00 00 00" ZEROS, "20 00 00 00" ZEROS);
    ask("40 00 21 00", "41 00 21 00 00 00 00 00");
}

static void short_ones_go_at_once(void **state)
{
    (void)state;
    start_node();
    ask("2B 00 21 00 61 62 00 00", "60 00 21 00" ZEROS);
    ask("40 00 21 00", "4B 00 21 00 61 62 00 00");
    ask("22 00 21 00 61 62 63 64", "60 00 21 00" ZEROS);
    ask("40 00 21 00", "43 00 21 00 61 62 63 64");
}

static void what_is_half_written_is_not_there(void **state)
{
    (void)state;
    start_node();
    ask("21 00 21 00 09 00 00 00", "60 00 21 00" ZEROS);
    ask("00 " TEXT, "20 00 00 00" ZEROS);
    expect_hello(); /* which ends the other one */
    ask("1B 65 72 00" ZEROS, "80 65 72 00 01 00 04 05");
    ask("21 00 21 00 09 00 00 00", "60 00 21 00" ZEROS);
    ask("10 " TEXT, "80 00 21 00 00 00 03 05"); /* toggle */
    ask("21 00 21 00 09 00 00 00", "60 00 21 00" ZEROS);
    ask("80 00 21 00 00 00 04 05", "");
    ask("00 " TEXT, "80 64 72 65 01 00 04 05");
    ask("21 00 21 00 09 00 00 00", "60 00 21 00" ZEROS);
    co_rig_forget(&rig.co);
    co_rig_run(&rig.co, DG_S(1));
    co_rig_expect(&rig.co, 0, ANSWER, "80 00 21 00 00 00 04 05");
    expect_hello();
}

static void lengths_are_looked_at(void **state)
{
    (void)state;
    start_node();
    ask("21 00 21 00 01 04 00 00", "80 00 21 00 12 00 07 06"); /* 1025 */
    ask("21 00 21 00 09 00 00 00", "60 00 21 00" ZEROS);
    ask("01 " TEXT, "80 00 21 00 10 00 07 06"); /* 7 of 9 */
    ask("21 00 21 00 05 00 00 00", "60 00 21 00" ZEROS);
    ask("00 " TEXT, "80 00 21 00 10 00 07 06");          /* 7 of 5 */
    ask("21 00 21 00 00 04 00 00", "60 00 21 00" ZEROS); /* 1024 fit */
    expect_hello();
}

static void access_is_looked_at(void **state)
{
    (void)state;
    start_node();
    ask("40 06 21 00", "80 06 21 00 01 00 01 06");
    ask("A0 06 21 00 7F 00 00 00", "80 06 21 00 01 00 01 06");
    ask("23 02 21 00 01 02 03 04", "80 02 21 00 02 00 01 06");
    ask("C2 02 21 00 05 00 00 00", "80 02 21 00 02 00 01 06");
    ask("40 00 21 01", "80 00 21 01 11 00 09 06");
    ask("23 06 21 00 01 02 03 04", "60 06 21 00" ZEROS);
    ask("A0 00 21 00 00 00 00 00", "80 00 21 00 02 00 04 05"); /* no block of 0 */
}

/* ------------------------------------------------------------ numbers */

static void numbers_of_64_bits_have_segments(void **state)
{
    (void)state;
    start_node();
    ask("40 04 21 00", "41 04 21 00 08 00 00 00");
    ask("60", "00 EF CD AB 89 67 45 23");
    ask("70", "1D 01 00 00" ZEROS);
    ask("40 08 21 00", "41 08 21 00 08 00 00 00");
    ask("60", "00 00 00 00 00 00 00 F8");
    ask("70", "1D 3F 00 00" ZEROS);
    ask("21 04 21 00 08 00 00 00", "60 04 21 00" ZEROS);
    ask("00 01 00 00 00 02 00 00", "20 00 00 00" ZEROS);
    ask("1D 7F 00 00" ZEROS, "30 00 00 00" ZEROS);
    ask("40 04 21 00", "41 04 21 00 08 00 00 00");
    ask("60", "00 01 00 00 00 02 00 00");
    ask("70", "1D 7F 00 00" ZEROS);
    ask("23 04 21 00 01 02 03 04", "80 04 21 00 13 00 07 06");
    ask("21 04 21 00 09 00 00 00", "80 04 21 00 12 00 07 06");
}

static void numbers_of_64_bits_have_limits(void **state)
{
    (void)state;
    start_node();
    ask("21 05 21 00 08 00 00 00", "60 05 21 00" ZEROS);
    ask("00 0B 00 00 00 00 00 00", "20 00 00 00" ZEROS);
    ask("1D 00 00 00" ZEROS, "80 05 21 00 30 00 09 06"); /* 11 */
    ask("40 05 21 00", "41 05 21 00 08 00 00 00");
    ask("60", "00 FE FF FF FF FF FF FF");
    ask("70", "1D FF 00 00" ZEROS);
    ask("21 05 21 00 08 00 00 00", "60 05 21 00" ZEROS);
    ask("00 F6 FF FF FF FF FF FF", "20 00 00 00" ZEROS);
    ask("1D FF 00 00" ZEROS, "30 00 00 00" ZEROS); /* -10 */
    ask("21 04 21 00 08 00 00 00", "60 04 21 00" ZEROS);
    ask("00 00 00 00 00 00 00 00", "20 00 00 00" ZEROS);
    ask("1D 80 00 00" ZEROS, "80 04 21 00 30 00 09 06");
}

static void numbers_of_24_bits_go_at_once(void **state)
{
    (void)state;
    start_node();
    ask("40 07 21 00", "47 07 21 00 56 34 12 00");
    ask("27 07 21 00 01 02 03 00", "60 07 21 00" ZEROS);
    ask("40 07 21 00", "47 07 21 00 01 02 03 00");
    ask("22 07 21 00 04 05 06 07", "60 07 21 00" ZEROS);
    ask("40 07 21 00", "47 07 21 00 04 05 06 00");
    ask("40 09 21 00", "47 09 21 00 FD FF FF 00");
    ask("2B 07 21 00 01 02 00 00", "80 07 21 00 13 00 07 06");
}

/* ------------------------------------------------------------ blocks */

static void a_text_is_written_in_a_block(void **state)
{
    (void)state;
    start_node();
    ask("C6 00 21 00 09 00 00 00", "A4 00 21 00 1F 00 00 00");
    ask("01 " TEXT, "");
    ask("82 65 72 00" ZEROS, "A2 02 1F 00" ZEROS);
    ask("82 65 72 00" ZEROS, ""); /* received twice */
    ask("D5 19 07 00" ZEROS, "A1 00 00 00" ZEROS);
    ask("40 00 21 00", "41 00 21 00 09 00 00 00");
    ask("60", "00 " TEXT);
    /* A wrong sum leaves it alone; without one it is not looked at. */
    ask("C6 00 21 00 02 00 00 00", "A4 00 21 00 1F 00 00 00");
    ask("81 68 69 00" ZEROS, "A2 01 1F 00" ZEROS);
    ask("D5 00 00 00" ZEROS, "80 00 21 00 04 00 04 05");
    ask("40 00 21 00", "41 00 21 00 09 00 00 00");
    ask("C2 00 21 00 02 00 00 00", "A4 00 21 00 1F 00 00 00");
    ask("81 68 69 00" ZEROS, "A2 01 1F 00" ZEROS);
    ask("D5 00 00 00" ZEROS, "A1 00 00 00" ZEROS);
    ask("40 00 21 00", "4B 00 21 00 68 69 00 00");
}

/* Byte `i` of what is written and read here. */
static uint8_t pattern(uint32_t i)
{
    return (uint8_t)((i * 7u + 3u) % 251u);
}

static void request_segment(uint8_t first, uint32_t at, uint32_t n)
{
    char text[32] = "";
    int used = snprintf(text, sizeof text, "%02X", first);

    for (uint32_t i = 0; i < SEGMENT; i++) {
        used += snprintf(text + used, sizeof text - (size_t)used, " %02X",
                         at + i < n ? pattern(at + i) : 0u);
    }
    co_rig_rx(&rig.co, ASK, text);
}

/* One block of up to 31 segments from byte `at` on; segment `lost` does not come. */
static void send_block(uint32_t at, uint32_t n, uint8_t lost)
{
    for (uint8_t seqno = 1; seqno <= 31u && at < n; seqno++) {
        const bool last = at + SEGMENT >= n;
        if (seqno != lost) {
            request_segment((uint8_t)(seqno | (last ? 0x80u : 0u)), at, n);
        }
        at += SEGMENT;
    }
}

/* 1024 bytes are 4 blocks of 217 and one of 156: 23 segments, 5 bytes of the last do not count. */
static void write_whole(uint16_t n, const char *announced, const char *end)
{
    char answer[32];

    ask(announced, "A4 01 21 00 1F 00 00 00");
    for (uint32_t at = 0; at < n; at += 31u * SEGMENT) {
        const uint32_t left = (n - at + SEGMENT - 1u) / SEGMENT;
        co_rig_forget(&rig.co);
        send_block(at, n, 0);
        co_rig_expect_count(&rig.co, 1);
        (void)snprintf(answer, sizeof answer, "A2 %02X 1F 00" ZEROS, left < 31u ? left : 31u);
        co_rig_expect(&rig.co, 0, ANSWER, answer);
    }
    ask(end, "A1 00 00 00" ZEROS);
}

/* The whole of 2101h by segments. */
static void expect_pattern(uint32_t n)
{
    ask("40 01 21 00", n == LONG_MAX_BYTES ? "41 01 21 00 00 04 00 00" : "41 01 21 00 E8 03 00 00");
    for (uint32_t at = 0; at < n; at += SEGMENT) {
        co_rig_forget(&rig.co);
        co_rig_rx(&rig.co, ASK, at / SEGMENT % 2u == 0 ? "60" : "70");
        const struct dg_can_frame *frame = &rig.co.frame[0];
        const uint32_t left = n - at;
        const uint32_t unused = left < SEGMENT ? SEGMENT - left : 0;
        co_rig_expect_count(&rig.co, 1);
        assert_int_equal(frame->data[0],
                         (at / SEGMENT % 2u) << 4 | unused << 1 | (left <= SEGMENT ? 1u : 0u));
        for (uint32_t i = 0; i < SEGMENT - unused; i++) {
            assert_int_equal(frame->data[1u + i], pattern(at + i));
        }
    }
}

static void a_domain_of_1_kb_is_written_in_blocks(void **state)
{
    (void)state;
    start_node();
    write_whole(LONG_MAX_BYTES, "C6 01 21 00 00 04 00 00", "D5 F2 FF 00" ZEROS);
    expect_pattern(LONG_MAX_BYTES);
    write_whole(SHOWN, "C4 01 21 00 00 00 00 00", "C5 00 53 00" ZEROS); /* no size; 142 * 7 + 6 */
    expect_pattern(SHOWN);
}

/* Segment 3 is lost: what stands behind it does not count, and comes again from 1 on. */
static void a_lost_segment_comes_again(void **state)
{
    (void)state;
    start_node();
    ask("C6 01 21 00 00 04 00 00", "A4 01 21 00 1F 00 00 00");
    co_rig_forget(&rig.co);
    send_block(0, LONG_MAX_BYTES, 3);
    co_rig_expect_count(&rig.co, 1);
    co_rig_expect(&rig.co, 0, ANSWER, "A2 02 1F 00" ZEROS);
    for (uint32_t at = 14; at < LONG_MAX_BYTES; at += 31u * SEGMENT) {
        send_block(at, LONG_MAX_BYTES, 0);
    }
    ask("D5 F2 FF 00" ZEROS, "A1 00 00 00" ZEROS);
    expect_pattern(LONG_MAX_BYTES);
}

static void blocks_of_too_much_are_refused_at_their_end(void **state)
{
    (void)state;
    start_node();
    ask("C6 01 21 00 01 04 00 00", "80 01 21 00 12 00 07 06");
    ask("C4 01 21 00 00 00 00 00", "A4 01 21 00 1F 00 00 00");
    for (uint32_t at = 0; at < 4u * 217u; at += 217u) {
        send_block(at, 5u * 217u, 0);
    }
    co_rig_forget(&rig.co);
    send_block(4u * 217u, 5u * 217u, 0);
    co_rig_expect_count(&rig.co, 1);
    co_rig_expect(&rig.co, 0, ANSWER, "80 01 21 00 12 00 07 06");
    ask("C6 01 21 00 08 00 00 00", "A4 01 21 00 1F 00 00 00");
    send_block(0, 8, 0);
    ask("C1 00 00 00" ZEROS, "80 01 21 00 10 00 07 06"); /* 14 of 8 */
    ask("C6 01 21 00 08 00 00 00", "A4 01 21 00 1F 00 00 00");
    ask("20 " TEXT, "80 64 72 65 00 00 02 06"); /* a new request, and of no object */
    ask("40 01 21 00", "41 01 21 00 00 00 00 00");
}

/* What was sent in a block since the last look, from byte `at` on. */
static void expect_block(uint32_t at, uint32_t n, uint8_t segments)
{
    co_rig_expect_count(&rig.co, segments);
    for (uint8_t i = 0; i < segments; i++) {
        const struct dg_can_frame *frame = &rig.co.frame[i];
        const bool last = at + SEGMENT >= n;
        assert_int_equal(frame->data[0], (i + 1u) | (last ? 0x80u : 0u));
        for (uint32_t k = 0; k < SEGMENT; k++) {
            assert_int_equal(frame->data[1u + k], at + k < n ? pattern(at + k) : 0);
        }
        at += SEGMENT;
    }
}

static void run_block(const char *request)
{
    co_rig_forget(&rig.co);
    co_rig_rx(&rig.co, ASK, request);
    co_rig_run(&rig.co, DG_MS(100));
}

static void a_domain_of_1_kb_is_read_in_blocks(void **state)
{
    (void)state;
    start_node();
    write_whole(LONG_MAX_BYTES, "C6 01 21 00 00 04 00 00", "D5 F2 FF 00" ZEROS);
    ask("A4 01 21 00 7F 00 00 00", "C6 01 21 00 00 04 00 00");
    run_block("A3");
    expect_block(0, LONG_MAX_BYTES, 127);
    /* A frame of 8 bytes takes at most 135 bit times, at 250 kBd. */
    assert_int_equal(rig.co.at[1] - rig.co.at[0], DG_US(540));
    assert_int_equal(rig.co.at[126] - rig.co.at[0], 126u * DG_US(540));
    run_block("A2 7E 04"); /* the last one was lost; blocks of 4 */
    expect_block(882, LONG_MAX_BYTES, 4);
    run_block("A2 04 7F");
    expect_block(910, LONG_MAX_BYTES, 17);
    ask("A2 11 7F", "D5 F2 FF 00" ZEROS);
    ask("A1", "");
    ask("A1", "80 00 00 00 01 00 04 05");
}

static void a_block_that_was_begun_is_given_up(void **state)
{
    (void)state;
    start_node();
    write_whole(LONG_MAX_BYTES, "C6 01 21 00 00 04 00 00", "D5 F2 FF 00" ZEROS);
    ask("A4 01 21 00 7F 00 00 00", "C6 01 21 00 00 04 00 00");
    co_rig_rx(&rig.co, ASK, "A3");
    co_rig_run(&rig.co, DG_MS(2));
    ask("80 01 21 00 00 00 04 05", "");
    co_rig_run(&rig.co, DG_S(2));
    co_rig_expect_count(&rig.co, 0);
    ask("A4 01 21 00 7F 00 00 00", "C6 01 21 00 00 04 00 00");
    run_block("A3");
    ask("A2 80 7F", "80 01 21 00 03 00 04 05"); /* more than was sent */
    ask("A4 01 21 00 7F 00 00 00", "C6 01 21 00 00 04 00 00");
    run_block("A3");
    ask("A2 7F 00", "80 01 21 00 02 00 04 05");
    ask("A4 00 21 00 7F 05 00 00", "41 00 21 00 05 00 00 00"); /* 5 are not more than 5 */
    ask("A0 00 21 00 7F 04 00 00", "C6 00 21 00 05 00 00 00");
    run_block("A3");
    co_rig_expect(&rig.co, 0, ANSWER, "81 68 65 6C 6C 6F 00 00");
    ask("A2 01 7F", "C9 00 00 00" ZEROS);
}

/* ------------------------------------------------------------ time, states */

static void a_reset_brings_the_default_back(void **state)
{
    (void)state;
    start_node();
    ask("2B 00 21 00 61 62 00 00", "60 00 21 00" ZEROS);
    co_rig_nmt(&rig.co, 0x82); /* communication only */
    ask("40 00 21 00", "4B 00 21 00 61 62 00 00");
    co_rig_nmt(&rig.co, 0x81);
    expect_hello();
    ask("2B 00 21 00 61 62 00 00", "60 00 21 00" ZEROS);
    eds_rig_power_cycle(&rig);
    expect_hello();
}

#define SAVE 0x65766173u
#define LOAD 0x64616F6Cu

static void save(void)
{
    co_rig_put(&rig.co, 0x1010, 1, SAVE, 4);
}

static void expect_hi(void)
{
    ask("40 00 21 00", "4B 00 21 00 68 69 00 00");
}

static void write_hi(void)
{
    ask("2B 00 21 00 68 69 00 00", "60 00 21 00" ZEROS);
}

static void what_was_saved_comes_back(void **state)
{
    (void)state;
    start_node();
    assert_int_equal(rig.file.file.longs_kept, 6);
    write_whole(LONG_MAX_BYTES, "C6 01 21 00 00 04 00 00", "D5 F2 FF 00" ZEROS);
    write_hi();
    save();
    ask("2B 00 21 00 78 78 00 00", "60 00 21 00" ZEROS);
    eds_rig_power_cycle(&rig);
    expect_hi();
    expect_pattern(LONG_MAX_BYTES);
    ask("27 07 21 00 01 02 03 00", "60 07 21 00" ZEROS);
    save();
    save();
    eds_rig_power_cycle(&rig);
    ask("40 07 21 00", "47 07 21 00 01 02 03 00");
    expect_hi();
    co_rig_put(&rig.co, 0x1011, 1, LOAD, 4);
    eds_rig_power_cycle(&rig);
    expect_hello();
    ask("40 01 21 00", "41 01 21 00 00 00 00 00");
}

static uint32_t place_of_texts(void)
{
    const struct dg_store_layout *layout = &rig.file.file.layout;
    const int region = dg_store_find(layout, "texts");

    assert_true(region == layout->region_count - 1);
    return dg_store_address(layout, (uint8_t)region);
}

/* Whichever copy is damaged, the other one is whole. */
static void a_damaged_copy_is_not_taken(void **state)
{
    uint8_t *copies;
    (void)state;
    start_node();
    copies = &rig.co.nvm.bytes[place_of_texts()];
    write_hi();
    save();
    copies[4] ^= 1u;
    eds_rig_power_cycle(&rig);
    expect_hello();
    copies[4] ^= 1u;
    eds_rig_power_cycle(&rig);
    expect_hi();
    ask("2B 00 21 00 78 78 00 00", "60 00 21 00" ZEROS);
    save(); /* the second copy */
    copies[4u + rig.file.file.long_kept + 4u] ^= 1u;
    eds_rig_power_cycle(&rig);
    expect_hi();
}

/* Each write of a "save" may be the last one: all of the older values are there, or of the newer.
 */
static void a_power_cut_leaves_one_or_the_other(void **state)
{
    bool was_older = false;
    bool was_newer = false;

    (void)state;
    for (uint32_t writes = 0; !was_newer; writes++) {
        start_node();
        write_hi();
        save();
        ask("2B 00 21 00 78 78 00 00", "60 00 21 00" ZEROS);
        ask("27 07 21 00 01 02 03 00", "60 07 21 00" ZEROS);
        ram_nvm_cut(&rig.co.nvm, writes, RAM_NVM_ORDERED, 3);
        (void)co_rig_write(&rig.co, 0x1010, 1, SAVE, 4);
        ram_nvm_restore(&rig.co.nvm);
        eds_rig_power_cycle(&rig);
        co_rig_forget(&rig.co);
        co_rig_rx(&rig.co, ASK, "40 00 21 00");
        was_newer = rig.co.frame[0].data[4] == 0x78;
        was_older = was_older || !was_newer;
        if (!was_newer) {
            expect_hi();
        }
        ask("40 07 21 00", was_newer ? "47 07 21 00 01 02 03 00" : "47 07 21 00 56 34 12 00");
        assert_true(writes < 400);
    }
    assert_true(was_older);
}

/* 4 kB of them are kept: three texts. */
static void more_than_the_memory_takes_is_noted(void **state)
{
    (void)state;
    eds_rig_read_text(&rig,
                      "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
                      "[2100]\nDataType=9\nAccessType=rw\n[2101]\nDataType=9\nAccessType=rw\n"
                      "[2102]\nDataType=9\nAccessType=rw\n[2104]\nDataType=0x15\nAccessType=rw\n"
                      "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=8\n"
                      "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=8\n");
    assert_int_equal(rig.note_count, 0);
    eds_rig_read_text(&rig, "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
                            "[2100]\nDataType=9\nAccessType=rw\n[2101]\nDataType=9\nAccessType=rw\n"
                            "[2102]\nDataType=9\nAccessType=rw\n[2103]\nDataType=9\nAccessType=rw\n"
                            "[2104]\nDataType=0x15\nAccessType=rw\n"
                            "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=8\n"
                            "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=8\n");
    assert_int_equal(rig.note_count, 1);
    assert_true(eds_rig_is_noted(&rig, "", "more values than 1010h can keep"));
    assert_int_equal(rig.file.file.longs_kept, 4);
}

static struct eds_client first, second;

static void make_client(struct eds_client *self)
{
    assert_int_equal(eds_client_read(self, file, strlen(file)), DG_OK);
    eds_client_make(self);
    eds_client_switch_on(self);
}

static uint64_t bytes_of(const struct dg_host_event *answer)
{
    return dg_load_le32(answer->data) | (uint64_t)dg_load_le32(&answer->data[4]) << 32;
}

/* A state has the value, and the transfer that is under way. */
static void a_state_has_what_was_written(void **state)
{
    static uint8_t bytes[65536];
    struct dg_host_event answer;

    (void)state;
    make_client(&first);
    make_client(&second);
    assert_int_equal(eds_client_download(&first, 0x2100, 0, 0x64636261, 4), 0);
    (void)eds_client_ask(&first, 0x21, 0x2101, 0, 9);
    (void)eds_client_ask(&first, 0x00, 0x7264, 0x65, 0x62656768);
    const size_t size = dg_host_state_size(first.host);
    assert_true(size <= sizeof bytes);
    assert_int_equal(dg_host_save(first.host, bytes, size), DG_HOST_OK);
    assert_int_equal(dg_host_restore(second.host, bytes, size), DG_HOST_OK);
    second.now = first.now;
    answer = eds_client_ask(&second, 0x1B, 0x7265, 0, 0);
    assert_int_equal(bytes_of(&answer), 0x30);
    answer = eds_client_ask(&second, 0x40, 0x2101, 0, 0);
    assert_int_equal(bytes_of(&answer), UINT64_C(0x0000000900210141));
    answer = eds_client_ask(&second, 0x60, 0, 0, 0);
    assert_int_equal(bytes_of(&answer), UINT64_C(0x6265676865726400));
    assert_int_equal(eds_client_upload(&second, 0x2100, 0), 0x64636261);
}

/* Whatever stands in the state of a transfer, no frame of a client leads out of the memory. */
static void a_state_that_somebody_has_made_leads_nowhere(void **state)
{
    static const uint8_t requests[] = {0x60, 0x70, 0x00, 0x10, 0x01, 0x81, 0xA1, 0xA2, 0xA3, 0xC1};
    static uint8_t bytes[65536];

    (void)state;
    make_client(&first);
    make_client(&second);
    (void)eds_client_ask(&first, 0x21, 0x2101, 0, 9);
    const size_t size = dg_host_state_size(first.host);
    assert_true(size <= sizeof bytes);
    assert_int_equal(dg_host_save(first.host, bytes, size), DG_HOST_OK);
    const size_t at = size - dg_host_memory_size(first.host) - second.file.file.more;
    for (size_t i = 0; i < 64; i++) {
        const uint8_t kept = bytes[at + i];
        bytes[at + i] = 0xFF;
        for (size_t n = 0; n < sizeof requests; n++) {
            if (dg_host_restore(second.host, bytes, size) == DG_HOST_OK) {
                struct dg_host_event event = {.at = first.now,
                                              .id = 0x600u + EDS_CLIENT_NODE,
                                              .kind = DG_HOST_CAN,
                                              .length = 8,
                                              .data = {requests[n], 0x05, 0x05}};
                assert_int_equal(dg_host_send(second.host, &event), DG_HOST_OK);
                (void)dg_host_step(second.host, first.now + DG_MS(50));
            }
        }
        bytes[at + i] = kept;
    }
}

/* ------------------------------------------------------------ files */

static void what_a_file_cannot_have_is_noted(void **state)
{
    static char text[65536];
    int n = snprintf(text, sizeof text,
                     "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
                     "[2000]\nDataType=0x1B\nAccessType=rw\nDefaultValue=No\n"
                     "[2001]\nDataType=0x1B\nAccessType=rw\nDefaultValue=9\n"
                     "HighLimit=8\n[2002]\nDataType=0x20\nAccessType=ro\n"
                     "[2003]\nDataType=9\nAccessType=ro\nDefaultValue=");

    (void)state;
    memset(text + n, 'x', LONG_MAX_BYTES + 1u);
    n += (int)LONG_MAX_BYTES + 1;
    n += snprintf(text + n, sizeof text - (size_t)n,
                  "\n[6501]\nDataType=7\nAccessType=ro\nDefaultValue=8\n"
                  "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=8\n");
    for (unsigned i = 0; i < 65; i++) {
        n += snprintf(text + n, sizeof text - (size_t)n, "[%04X]\nDataType=9\nAccessType=rw\n",
                      0x2100u + i);
    }
    eds_rig_read_text(&rig, text);
    assert_true(eds_rig_is_noted(&rig, "2000", "is no number of its type"));
    assert_true(eds_rig_is_noted(&rig, "2001", "outside of its limits"));
    assert_true(eds_rig_is_noted(&rig, "2002", "has no such type"));
    assert_true(eds_rig_is_noted(&rig, "2003", "cut off behind 1024"));
    assert_false(eds_rig_is_noted(&rig, "213F", "one text too many"));
    assert_true(eds_rig_is_noted(&rig, "2140", "one text too many"));
    assert_true(eds_rig_is_noted(&rig, "", "more values than 1010h can keep"));
    assert_int_equal(rig.note_count, 6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_text_is_read_in_segments),
        cmocka_unit_test(a_text_is_written_in_segments),
        cmocka_unit_test(short_ones_go_at_once),
        cmocka_unit_test(what_is_half_written_is_not_there),
        cmocka_unit_test(lengths_are_looked_at),
        cmocka_unit_test(access_is_looked_at),
        cmocka_unit_test(numbers_of_64_bits_have_segments),
        cmocka_unit_test(numbers_of_64_bits_have_limits),
        cmocka_unit_test(numbers_of_24_bits_go_at_once),
        cmocka_unit_test(a_text_is_written_in_a_block),
        cmocka_unit_test(a_domain_of_1_kb_is_written_in_blocks),
        cmocka_unit_test(a_lost_segment_comes_again),
        cmocka_unit_test(blocks_of_too_much_are_refused_at_their_end),
        cmocka_unit_test(a_domain_of_1_kb_is_read_in_blocks),
        cmocka_unit_test(a_block_that_was_begun_is_given_up),
        cmocka_unit_test(a_reset_brings_the_default_back),
        cmocka_unit_test(what_was_saved_comes_back),
        cmocka_unit_test(a_damaged_copy_is_not_taken),
        cmocka_unit_test(a_power_cut_leaves_one_or_the_other),
        cmocka_unit_test(more_than_the_memory_takes_is_noted),
        cmocka_unit_test(a_state_has_what_was_written),
        cmocka_unit_test(a_state_that_somebody_has_made_leads_nowhere),
        cmocka_unit_test(what_a_file_cannot_have_is_noted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
