/* SPDX-License-Identifier: MIT */
/* Frames in one message: golden bytes, cut after each of them, and what does not fit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "silkit_pack.h"

/* Two frames at 01 02 03 04 05 06 07 08h ns and 258 ns later, a remote one at once. */
static const uint8_t golden[] = {
    0x08, 0x07, 0x06, 0x05, 0x04, 0x03, 0x02, 0x01, 0x03, 0x00, 0x00, 0x00, /* 3 frames */
    0x00, 0x00, 0x00, 0x00, 0x81, 0x02, 0x04, 0x00, 0xDE, 0xAD, 0xBE, 0xEF, /* 281h */
    0x02, 0x01, 0x00, 0x00, 0xFF, 0x07, 0x00, 0x00,                         /* 7FFh, empty */
    0x02, 0x01, 0x00, 0x00, 0x81, 0x81, 0x08, 0x00,                         /* 181h, remote */
};
static const uint64_t begin = UINT64_C(0x0102030405060708);
static const struct dg_can_frame frames[] = {
    {.id = 0x281, .dlc = 4, .data = {0xDE, 0xAD, 0xBE, 0xEF}},
    {.id = 0x7FF},
    {.id = 0x181, .rtr = true, .dlc = 8},
};

static void frames_are_these_bytes(void **state)
{
    struct lx_silkit_pack pack = {.bytes = NULL};
    (void)state;
    for (unsigned round = 0; round < 2; round++) {
        assert_true(lx_silkit_pack_add(&pack, begin, &frames[0]));
        assert_true(lx_silkit_pack_add(&pack, begin + 258u, &frames[1]));
        assert_true(lx_silkit_pack_add(&pack, begin + 258u, &frames[2]));
        assert_int_equal(pack.length, sizeof golden);
        assert_memory_equal(pack.bytes, golden, sizeof golden);
        lx_silkit_pack_clear(&pack);
        assert_int_equal(pack.length, 0);
    }
    lx_silkit_pack_free(&pack);
}

static void bytes_are_these_frames(void **state)
{
    struct dg_can_frame frame;
    size_t at = LX_SILKIT_PACK_HEAD;
    (void)state;
    assert_true(lx_silkit_pack_is_good(golden, sizeof golden));
    for (size_t i = 0; i < sizeof frames / sizeof frames[0]; i++) {
        assert_true(lx_silkit_pack_next(golden, sizeof golden, &at, &frame));
        assert_int_equal(frame.id, frames[i].id);
        assert_int_equal(frame.rtr, frames[i].rtr);
        assert_int_equal(frame.dlc, frames[i].dlc);
        assert_memory_equal(frame.data, frames[i].data, sizeof frame.data);
    }
    assert_false(lx_silkit_pack_next(golden, sizeof golden, &at, &frame));
}

/* In memory of its own, so that a byte too many is found. */
static bool is_good(const uint8_t *bytes, size_t n)
{
    uint8_t *copy = malloc(n + (n == 0));
    assert_non_null(copy);
    memcpy(copy, bytes, n);
    const bool good = lx_silkit_pack_is_good(copy, n);
    free(copy);
    return good;
}

static void a_part_of_a_message_is_none(void **state)
{
    uint8_t longer[sizeof golden + 1u] = {0};
    (void)state;
    for (size_t n = 0; n < sizeof golden; n++) {
        assert_false(is_good(golden, n));
    }
    memcpy(longer, golden, sizeof golden);
    assert_false(is_good(longer, sizeof longer));
}

static void what_no_frame_has_is_refused(void **state)
{
    static const struct {
        size_t at;
        uint8_t bits;
        bool good;
    } rows[] = {
        {0, 0xFF, true},                                         /* another moment */
        {8, 0x01, false},                                        /* another number of frames, */
        {8, 0x04, false},                                        /* ... more than there are, */
        {9, 0x01, false},                                        /* ... many more */
        {10, 0x01, false},                                       /* a flag */
        {11, 0x80, false}, {12, 0xFF, true},                     /* another offset */
        {17, 0x08, false},                                       /* an identifier of 12 bits */
        {17, 0x40, false}, {16, 0xFF, true},                     /* another identifier */
        {18, 0x01, false},                                       /* 5 bytes, 8, 12 */
        {18, 0x0C, false}, {18, 0x08, false}, {19, 0x01, false}, /* reserved */
        {38, 0x01, false},                                       /* a remote frame of 9 bytes, */
        {38, 0x08, true},                                        /* ... of none */
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t bytes[sizeof golden];
        memcpy(bytes, golden, sizeof bytes);
        bytes[rows[i].at] ^= rows[i].bits;
        assert_int_equal(is_good(bytes, sizeof bytes), rows[i].good);
    }
}

static void what_does_not_fit_begins_another_message(void **state)
{
    struct lx_silkit_pack pack = {.bytes = NULL};
    const struct dg_can_frame full = {.id = 1, .dlc = 8};
    (void)state;
    assert_true(lx_silkit_pack_add(&pack, 10, &full));
    assert_false(lx_silkit_pack_add(&pack, 9, &full));
    assert_false(lx_silkit_pack_add(&pack, 10u + UINT64_C(0x100000000), &full));
    assert_true(lx_silkit_pack_add(&pack, 10u + UINT64_C(0xFFFFFFFF), &full));
    assert_int_equal(pack.count, 2);
    while (pack.count < LX_SILKIT_PACK_FRAMES) {
        assert_true(lx_silkit_pack_add(&pack, 10, &full));
    }
    assert_false(lx_silkit_pack_add(&pack, 10, &full));
    assert_int_equal(pack.length, LX_SILKIT_PACK_MAX);
    assert_true(pack.length < 1u << 20u);
    assert_true(lx_silkit_pack_is_good(pack.bytes, pack.length));
    lx_silkit_pack_clear(&pack);
    assert_true(lx_silkit_pack_add(&pack, 9, &full));
    lx_silkit_pack_free(&pack);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_are_these_bytes),
        cmocka_unit_test(bytes_are_these_frames),
        cmocka_unit_test(a_part_of_a_message_is_none),
        cmocka_unit_test(what_no_frame_has_is_refused),
        cmocka_unit_test(what_does_not_fit_begins_another_message),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
