/* SPDX-License-Identifier: MIT */
/* The SLCAN codec. Lines as the Lawicel CAN232 and CANUSB manuals print them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/slcan.h"

/* Feed a text; the replies, one after the other. The last frame is left in `frame`. */
static const char *talk(struct dg_slcan *slcan, const char *text, struct dg_can_frame *frame)
{
    static char replies[256];
    struct dg_slcan_event event;
    replies[0] = '\0';
    for (; *text != '\0'; text++) {
        if (!dg_slcan_feed(slcan, (uint8_t)*text, &event)) {
            continue;
        }
        (void)strncat(replies, event.reply, sizeof replies - strlen(replies) - 1);
        if (event.has_frame && frame != NULL) {
            *frame = event.frame;
        }
    }
    return replies;
}

/* One line each, for a channel in state `before`. */
static const struct {
    enum dg_slcan_state before;
    const char *line;
    const char *reply;
    enum dg_slcan_state after;
} lines[] = {
    {DG_SLCAN_CLOSED, "S6\r", "\r", DG_SLCAN_CLOSED},
    {DG_SLCAN_OPEN, "S6\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_CLOSED, "S9\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "S/\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "S\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "S66\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "s031C\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "M00000000\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "mFFFFFFFF\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "O\r", "\r", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "O\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_CLOSED, "O1\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "L\r", "\r", DG_SLCAN_LISTENING},
    {DG_SLCAN_OPEN, "L\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "C\r", "\r", DG_SLCAN_CLOSED},
    {DG_SLCAN_LISTENING, "C\r", "\r", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "C\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "F\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_OPEN, "F\r", "F00\r", DG_SLCAN_OPEN},
    {DG_SLCAN_LISTENING, "F\r", "F00\r", DG_SLCAN_LISTENING},
    {DG_SLCAN_CLOSED, "V\r", "V1010\r", DG_SLCAN_CLOSED},
    {DG_SLCAN_OPEN, "V\r", "V1010\r", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "V1\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_CLOSED, "N\r", "NDG01\r", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "Z0\r", "\r", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "Z1\r", "\r", DG_SLCAN_CLOSED},
    {DG_SLCAN_CLOSED, "Z2\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_OPEN, "Z1\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "t10021133\r", "z\r", DG_SLCAN_OPEN},
    {DG_SLCAN_CLOSED, "t10021133\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_LISTENING, "t10021133\r", "\a", DG_SLCAN_LISTENING},
    {DG_SLCAN_OPEN, "t1002113\r", "\a", DG_SLCAN_OPEN},   /* data too short */
    {DG_SLCAN_OPEN, "t100211333\r", "\a", DG_SLCAN_OPEN}, /* data too long */
    {DG_SLCAN_OPEN, "t8000\r", "\a", DG_SLCAN_OPEN},      /* CAN-ID beyond 7FFh */
    {DG_SLCAN_OPEN, "t1G00\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "t10\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "t1009112233445566778899\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "t100A\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "r1008\r", "z\r", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "r100211\r", "\a", DG_SLCAN_OPEN}, /* a remote frame has no data */
    {DG_SLCAN_OPEN, "T0000010021133\r", "Z\r", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "T1FFFFFFF0\r", "Z\r", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "T200000000\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "R000001003\r", "Z\r", DG_SLCAN_OPEN},
    {DG_SLCAN_CLOSED, "T000001000\r", "\a", DG_SLCAN_CLOSED},
    {DG_SLCAN_OPEN, "x\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, "\n\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_OPEN, " F\r", "\a", DG_SLCAN_OPEN},
    {DG_SLCAN_CLOSED, "\r", "\r", DG_SLCAN_CLOSED},
    {DG_SLCAN_OPEN, "\r\r\r", "\r\r\r", DG_SLCAN_OPEN},
};

static void every_line_has_its_answer(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(lines); i++) {
        struct dg_slcan slcan = {.state = lines[i].before};
        assert_string_equal(talk(&slcan, lines[i].line, NULL), lines[i].reply);
        assert_int_equal(slcan.state, lines[i].after);
    }
}

static void all_bit_rates(void **state)
{
    static const uint16_t kbaud[] = {10, 20, 50, 100, 125, 250, 500, 800, 1000};
    struct dg_slcan slcan = {.length = 0};
    (void)state;
    assert_int_equal(slcan.kbaud, 0);
    for (size_t i = 0; i < DG_COUNT(kbaud); i++) {
        const char line[] = {'S', (char)('0' + i), '\r', '\0'};
        assert_string_equal(talk(&slcan, line, NULL), "\r");
        assert_int_equal(slcan.kbaud, kbaud[i]);
    }
    assert_string_equal(talk(&slcan, "S9\r", NULL), "\a"); /* and the last one stays */
    assert_int_equal(slcan.kbaud, 1000);
}

static void frames_of_the_master(void **state)
{
    static const uint8_t data[8] = {0x11, 0x22, 0xAB, 0xCD, 0xEF, 0, 0x77, 0x88};
    struct dg_slcan slcan = {.state = DG_SLCAN_OPEN};
    struct dg_can_frame frame = {.id = 0};
    (void)state;
    assert_string_equal(talk(&slcan, "t7FF81122abCDef007788\r", &frame), "z\r");
    assert_int_equal(frame.id, 0x7FF);
    assert_false(frame.rtr);
    assert_int_equal(frame.dlc, 8);
    assert_memory_equal(frame.data, data, 8);
    assert_string_equal(talk(&slcan, "r1854\r", &frame), "z\r");
    assert_int_equal(frame.id, 0x185);
    assert_true(frame.rtr);
    assert_int_equal(frame.dlc, 4);
    assert_string_equal(talk(&slcan, "t0000\r", &frame), "z\r");
    assert_int_equal(frame.id, 0);
    assert_false(frame.rtr);
    assert_int_equal(frame.dlc, 0);
}

/* An extended frame is acknowledged, and nothing of it reaches the encoder; nor of a bad line. */
static void frames_that_do_not_reach_the_encoder(void **state)
{
    static const char *const without[] = {
        "T00000185411223344\r", "R000001854\r", "t1852112\r", "t185\r", "t8852 1122\r", "S6\r"};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(without); i++) {
        struct dg_slcan slcan = {.state = DG_SLCAN_OPEN};
        struct dg_can_frame frame = {.id = 0xFFFF};
        (void)talk(&slcan, without[i], &frame);
        assert_int_equal(frame.id, 0xFFFF);
    }
}

static void lines_split_and_merged(void **state)
{
    struct dg_slcan slcan = {.length = 0};
    struct dg_can_frame frame = {.id = 0};
    (void)state;
    assert_string_equal(talk(&slcan, "C\rS5\rO\rt00020105\rF\r", &frame), "\a\r\rz\rF00\r");
    assert_int_equal(frame.data[0], 1);
    assert_string_equal(talk(&slcan, "t0802", &frame), "");
    assert_string_equal(talk(&slcan, "aa", &frame), "");
    assert_string_equal(talk(&slcan, "BB\rC", &frame), "z\r");
    assert_int_equal(frame.id, 0x080);
    assert_int_equal(frame.data[1], 0xBB);
    assert_string_equal(talk(&slcan, "\r", &frame), "\r");
    assert_int_equal(slcan.state, DG_SLCAN_CLOSED);
}

/* 30 characters are a line; more are one mistake, whatever they begin with. */
static void overlong_lines(void **state)
{
    struct dg_slcan slcan = {.state = DG_SLCAN_OPEN};
    struct dg_can_frame frame = {.id = 0xFFFF};
    char text[DG_SLCAN_LINE_MAX + 3];
    (void)state;
    for (size_t n = DG_SLCAN_LINE_MAX; n <= DG_SLCAN_LINE_MAX + 1u; n++) {
        memset(text, '0', n);
        memcpy(text, "r1000", 5);
        memcpy(text + n, "\r", 2);
        assert_string_equal(talk(&slcan, text, &frame), "\a");
        assert_int_equal(frame.id, 0xFFFF);
        assert_string_equal(talk(&slcan, "F\r", NULL), "F00\r");
    }
    for (size_t i = 0; i < 1000; i++) {
        assert_string_equal(talk(&slcan, "t", NULL), "");
    }
    assert_string_equal(talk(&slcan, "\rV\r", NULL), "\aV1010\r");
}

static void a_new_master_starts_with_a_new_line(void **state)
{
    struct dg_slcan slcan = {.state = DG_SLCAN_OPEN};
    (void)state;
    (void)talk(&slcan, "t1002", NULL);
    dg_slcan_resync(&slcan);
    assert_string_equal(talk(&slcan, "C\r", NULL), "\r");
    (void)talk(&slcan, "0123456789012345678901234567890", NULL);
    dg_slcan_resync(&slcan);
    assert_string_equal(talk(&slcan, "O\r", NULL), "\r");
}

static void every_byte_is_survived(void **state)
{
    struct dg_slcan slcan = {.state = DG_SLCAN_OPEN};
    struct dg_slcan_event event;
    (void)state;
    for (unsigned first = 0; first < 256; first++) {
        for (unsigned second = 0; second < 256; second++) {
            if (first == '\r' || second == '\r' || first == 'C') {
                continue;
            }
            assert_false(dg_slcan_feed(&slcan, (uint8_t)first, &event));
            assert_false(dg_slcan_feed(&slcan, (uint8_t)second, &event));
            assert_true(dg_slcan_feed(&slcan, '\r', &event));
            assert_string_equal(event.reply, "\a"); /* no line of two characters is right here */
        }
    }
}

static void digits_are_hexadecimal_of_either_case(void **state)
{
    static const char digits[] = "0123456789ABCDEFabcdef";
    struct dg_slcan slcan = {.state = DG_SLCAN_OPEN};
    (void)state;
    for (unsigned c = 1; c < 256; c++) {
        const char line[] = {'t', '0', '0', (char)c, '0', '\r', '\0'};
        const bool valid = strchr(digits, (int)c) != NULL;
        if (c != '\r') {
            assert_string_equal(talk(&slcan, line, NULL), valid ? "z\r" : "\a");
        }
    }
}

static void frames_of_the_encoder(void **state)
{
    static const struct {
        struct dg_can_frame frame;
        const char *plain;
        const char *stamped; /* at 61234 ms */
    } rows[] = {
        {{0x705, false, 1, {0x00}}, "t705100\r", "t70510004D2\r"},
        {{0x000, false, 0, {0}}, "t0000\r", "t000004D2\r"},
        {{0x7FF, false, 8, {0xFE, 0xDC, 0xBA, 0x98, 0x76, 0x54, 0x32, 0x10}},
         "t7FF8FEDCBA9876543210\r",
         "t7FF8FEDCBA987654321004D2\r"},
        {{0x185, true, 4, {1, 2, 3, 4}}, "r1854\r", "r185404D2\r"},
    };
    struct dg_slcan slcan = {.state = DG_SLCAN_OPEN};
    char text[DG_SLCAN_TEXT_MAX + 1];
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        slcan.stamps = false;
        assert_int_equal(dg_slcan_print(&slcan, &rows[i].frame, 61234, text),
                         strlen(rows[i].plain));
        assert_string_equal(text, rows[i].plain);
        slcan.stamps = true;
        assert_int_equal(dg_slcan_print(&slcan, &rows[i].frame, 61234, text),
                         strlen(rows[i].stamped));
        assert_string_equal(text, rows[i].stamped);
    }
}

/* The stamp counts to a minute, and the longest line has room. */
static void stamps_wrap_after_a_minute(void **state)
{
    const struct dg_can_frame frame = {.id = 0x123, .dlc = 8};
    struct dg_slcan slcan = {.length = 0};
    char text[DG_SLCAN_TEXT_MAX + 1];
    (void)state;
    assert_string_equal(talk(&slcan, "Z1\rO\r", NULL), "\r\r");
    assert_int_equal(dg_slcan_print(&slcan, &frame, 59999, text), DG_SLCAN_TEXT_MAX);
    assert_string_equal(text + 21, "EA5F\r");
    assert_int_equal(dg_slcan_print(&slcan, &frame, 60000, text), DG_SLCAN_TEXT_MAX);
    assert_string_equal(text + 21, "0000\r");
    assert_string_equal(talk(&slcan, "C\rZ0\r", NULL), "\r\r");
    assert_int_equal(dg_slcan_print(&slcan, &frame, 60000, text), DG_SLCAN_TEXT_MAX - 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_line_has_its_answer),
        cmocka_unit_test(all_bit_rates),
        cmocka_unit_test(frames_of_the_master),
        cmocka_unit_test(frames_that_do_not_reach_the_encoder),
        cmocka_unit_test(lines_split_and_merged),
        cmocka_unit_test(overlong_lines),
        cmocka_unit_test(a_new_master_starts_with_a_new_line),
        cmocka_unit_test(every_byte_is_survived),
        cmocka_unit_test(digits_are_hexadecimal_of_either_case),
        cmocka_unit_test(frames_of_the_encoder),
        cmocka_unit_test(stamps_wrap_after_a_minute),
    };
    return cmocka_run_group_tests_name("slcan", tests, NULL, NULL);
}
