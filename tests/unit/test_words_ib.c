/* SPDX-License-Identifier: MIT */
/* The words of an INTERBUS ring. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/interbus.h"
#include "words_rig.h"

/* Severities, as in the tables below. */
#define OK DG_SEVERITY_OK
#define NOTICE DG_SEVERITY_NOTICE
#define WARN DG_SEVERITY_WARNING
#define ERROR DG_SEVERITY_ERROR

static void words_that_changed(void **state)
{
    uint16_t in[4] = {1, 2, 3, 4};
    uint16_t out[4] = {0};
    struct dg_tap_event event = {
        .at = 5, .kind = DG_TAP_WORDS, .words = {.in = in, .out = out, .count = 4, .valid = true}};
    struct words_rig rig;
    (void)state;
    words_rig_init(&rig, &dg_ib_words);
    dg_words_event(&rig.wire, &event);
    assert_string_equal(rig.text, "IN[0] 0001 0002 0003 0004 OUT[0] 0000 0000 0000 0000");
    dg_words_event(&rig.wire, &event);
    assert_int_equal(rig.count, 1);
    in[0] = 0xC200;
    in[2] = 0xFFFF;
    in[3] = 0;
    out[3] = 0x8000;
    dg_words_event(&rig.wire, &event);
    assert_string_equal(rig.text, "IN[0] C200 IN[2] FFFF 0000 OUT[3] 8000");
    event.words.valid = false;
    dg_words_event(&rig.wire, &event);
    assert_string_equal(rig.text, "cycle not completed");
    assert_int_equal(rig.severity, ERROR);
    in[0] = 1;
    event.words.valid = true;
    dg_words_event(&rig.wire, &event);
    assert_string_equal(rig.text, "IN[0] 0001, cycles are valid");
    assert_int_equal(rig.severity, NOTICE);
    dg_words_event(&rig.wire, &event);
    assert_int_equal(rig.count, 4);
    in[0] = 2;
    event.kind = DG_TAP_LEVELS;
    dg_words_event(&rig.wire, &event);
    assert_int_equal(rig.count, 4);
}

/* clang-format off */
/* The status of a K3, manual 5.2 and the tables of 9.3 and 9.4. */
static const struct {
    uint32_t in;
    enum dg_severity severity;
} statuses[] = {
    {0x00000000, OK},     {0x01FFFFFF, OK},     /* in operation */
    {0xC0000000, NOTICE}, {0xC8001234, NOTICE}, /* parameters are set, the answer to one */
    {0xE0000000, NOTICE},
    {0xA0000000, NOTICE}, {0xA1FFFFFF, NOTICE}, /* self-test, read-out of 25 bits */
    {0x80000000, ERROR},                        /* no valid position */
    {0x82000000, ERROR},                        /* wrong parameter */
    {0x84000000, ERROR},                        /* unknown parameter */
    {0x86000000, ERROR},                        /* parameters are lost */
    {0x980000FF, ERROR},                        /* of the manufacturer */
    {0xA4210000, ERROR},                        /* unknown item of the read-out */
};
/* clang-format on */

static struct dg_tap_event cycle_of(uint16_t *in, uint16_t *out, uint16_t count,
                                    const uint8_t *widths)
{
    return (struct dg_tap_event){
        .kind = DG_TAP_WORDS,
        .words = {.in = in, .out = out, .widths = widths, .count = count, .valid = true},
    };
}

static void a_status_says_how_bad_it_is(void **state)
{
    static const uint8_t widths[] = {2};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(statuses); i++) {
        uint16_t in[2] = {(uint16_t)(statuses[i].in >> 16), (uint16_t)statuses[i].in};
        uint16_t out[2] = {0};
        const struct dg_tap_event event = cycle_of(in, out, 2, widths);
        struct words_rig rig;

        words_rig_init(&rig, &dg_ib_words);
        dg_words_event(&rig.wire, &event);
        assert_int_equal(rig.severity, statuses[i].severity);
    }
}

/* A K1 between two others: 16 bits of position without a status. */
static void each_device_has_a_status_of_its_own(void **state)
{
    static const uint8_t widths[] = {2, 1, 2};
    uint16_t in[5] = {0};
    uint16_t out[5] = {0};
    struct dg_tap_event event = cycle_of(in, out, 5, widths);
    struct words_rig rig;

    (void)state;
    words_rig_init(&rig, &dg_ib_words);
    in[2] = 0x8000;
    dg_words_event(&rig.wire, &event);
    assert_int_equal(rig.severity, OK);
    in[3] = 0x8200;
    dg_words_event(&rig.wire, &event);
    assert_int_equal(rig.severity, ERROR);
    in[0] = 1;
    dg_words_event(&rig.wire, &event);
    assert_string_equal(rig.text, "IN[0] 0001");
    assert_int_equal(rig.severity, OK); /* the line is about another one */
    in[4] = 1;
    dg_words_event(&rig.wire, &event);
    assert_string_equal(rig.text, "IN[4] 0001");
    assert_int_equal(rig.severity, ERROR);
    /* Who is on the ring is not known, so nobody can say. */
    event.words.widths = NULL;
    in[3] = 0x8400;
    dg_words_event(&rig.wire, &event);
    assert_int_equal(rig.severity, OK);
}

/* Words beyond 512 are not told, also of a device of which one half would be. */
static void a_ring_that_is_too_long_is_cut(void **state)
{
    static uint8_t widths[514] = {1};
    static uint16_t in[600];
    static uint16_t out[600];
    struct words_rig rig;

    (void)state;
    for (size_t i = 0; i < sizeof widths; i++) {
        widths[i] = i == 511 ? 2 : 1;
    }
    words_rig_init(&rig, &dg_ib_words);
    const struct dg_tap_event event = cycle_of(in, out, 600, widths);
    dg_words_event(&rig.wire, &event);
    assert_int_equal(strlen(rig.text), DG_WORDS_MAX - 1);
    assert_string_equal(rig.text + DG_WORDS_MAX - 4, "...");
    in[513] = 0x8200;
    dg_words_event(&rig.wire, &event);
    in[511] = 0x8200; /* the high word of a device whose low one is not told */
    dg_words_event(&rig.wire, &event);
    assert_int_equal(rig.count, 2);
    assert_int_equal(rig.severity, OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words_that_changed),
        cmocka_unit_test(a_status_says_how_bad_it_is),
        cmocka_unit_test(each_device_has_a_status_of_its_own),
        cmocka_unit_test(a_ring_that_is_too_long_is_cut),
    };
    return cmocka_run_group_tests_name("words_ib", tests, NULL, NULL);
}
