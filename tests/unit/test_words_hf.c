/* SPDX-License-Identifier: MIT */
/* The words of RS485. Frames are those of the manual's chapter 5.1.4. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/hiperface.h"
#include "words_rig.h"

#define BAUD 9600u
/* Severities, as in the tables below. */
#define OK DG_SEVERITY_OK
#define NOTICE DG_SEVERITY_NOTICE
#define WARN DG_SEVERITY_WARNING
#define ERROR DG_SEVERITY_ERROR

static struct dg_tap_event character(dg_ns at, bool ours, uint8_t byte)
{
    return (struct dg_tap_event){
        .at = at,
        .kind = DG_TAP_CHARACTER,
        .ours = ours,
        .character = {.baud = BAUD, .parity = 'E', .byte = byte},
    };
}

/* One character after the other, the first one's start bit at `start`. @return end of the last */
static dg_ns pass_bytes(struct words_rig *rig, dg_ns start, bool ours, const char *hex)
{
    uint8_t bytes[256];
    const size_t n = words_rig_hex(hex, bytes);
    for (size_t i = 0; i < n; i++) {
        start += dg_bit_times_ns(11, BAUD);
        const struct dg_tap_event event = character(start, ours, bytes[i]);
        dg_words_event(&rig->wire, &event);
    }
    return start;
}

/* clang-format off */
/* A warning bit is a warning, an error response (50h) an error: 5.1.1.2. A request that makes another encoder of this one
   is worth a notice. What does not fit its check sum is an error, what fits no command is one of the master's. */
static const struct {
    bool ours;
    enum dg_severity severity;
    const char *hex;
    const char *text;
} frames[] = {
    {false, OK,     "40 42 02",                      "40h 42h read position"},
    {true,  OK,     "40 42 00 00 30 39 0B",          "40h -> 42h position 12345"},
    {true,  WARN,   "40 C2 00 00 00 00 82",          "40h -> 42h position 0, warning"},
    {false, NOTICE, "40 43 00 00 00 00 55 56",       "40h 43h set position 0, code 55h"},
    {true,  OK,     "40 43 03",                      "40h -> 43h position set"},
    {false, OK,     "40 44 48 4C",                   "40h 44h read analog value 48h"},
    {true,  OK,     "40 44 48 00 25 69",             "40h -> 44h analog value 48h: 37"},
    {true,  OK,     "40 44 48 FF FB 48",             "40h -> 44h analog value 48h: -5"},
    {true,  OK,     "40 46 00 00 00 06",             "40h -> 46h counter 0"},
    {false, OK,     "40 47 07",                      "40h 47h increment counter"},
    {true,  OK,     "40 49 09",                      "40h -> 49h counter erased"},
    {false, OK,     "40 4A 00 00 10 55 4F",          "40h 4Ah read data field 00h offset 00h count 16, code 55h"},
    {true,  OK,     "40 4A 00 00 02 12 34 2E",       "40h -> 4Ah data field 00h offset 00h count 2: 12 34"},
    {false, OK,     "40 4B 00 00 08 55 FF 00 FF 00 FF 00 FF 00 56",
     "40h 4Bh save data field 00h offset 00h count 8, code 55h: FF 00 FF 00 FF 00 FF 00"},
    {true,  OK,     "40 4C 00 C8 C4",                "40h -> 4Ch data field 00h status C8h"},
    {false, NOTICE, "40 4D 00 C8 55 90",             "40h 4Dh create data field 00h status C8h, code 55h"},
    {true,  OK,     "40 4E 16 00 18",                "40h -> 4Eh memory blocks free 22, data fields 0"},
    {false, NOTICE, "40 4F 02 55 66 3E",             "40h 4Fh modify access key 2 from 55h to 66h"},
    {false, OK,     "40 50 10",                      "40h 50h read encoder status"},
    {true,  OK,     "40 50 00 10",                   "40h -> 50h no error"},
    {true,  ERROR,  "40 50 0D 1D",                   "40h -> 50h error 0Dh wrong argument"},
    {true,  ERROR,  "40 D0 0B 9B",                   "40h -> 50h error 0Bh unknown command code, warning"},
    {true,  ERROR,  "40 50 77 67",                   "40h -> 50h error 77h unknown"},
    {true,  OK,     "40 52 E4 22 16 00 C2",          "40h -> 52h type label: UART E4h, type 22h, memory blocks 22, option 00h"},
    {false, NOTICE, "40 53 13",                      "40h 53h reset encoder"},
    {false, NOTICE, "40 55 41 55 01",                "40h 55h assign address 41h, code 55h"},
    {true,  OK,     "41 55 14",                      "41h -> 55h address assigned"},
    {true,  OK,     "40 56 31 32 33 34 35 36 37 38 39 76 31 2E 30 2E 38 00 00 00 00 00 00 00 00 00 00 00 00 00 00 "
            "31 32 30 37 32 30 31 39 66",    "40h -> 56h serial number 123456789, version v1.0.8, date 12072019"},
    {false, NOTICE, "FF 57 E4 55 19",                "all 57h configure serial interface E4h, code 55h"},
    {true,  OK,     "40 6A 00 05 D2 C1 3C",          "40h -> 6Ah position 381633"},
    {false, ERROR,  "40 42 03",                      "40h 42h read position, check sum wrong"},
    {false, WARN,   "40 99 01 D8",                   "40h 99h unknown command: 01"},
    {false, WARN,   "40 43 00 00 03",                "40h 43h set position ?, code ?"},
    {false, WARN,   "40 42 01 03",                   "40h 42h read position, too many: 01"},
    {false, ERROR,  "40 42",                         "too short: 40 42"},
    {true,  ERROR,  "40",                            "-> too short: 40"},
};
/* clang-format on */

static void frames_in_the_manuals_words(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(frames); i++) {
        struct words_rig rig;
        words_rig_init(&rig, &dg_hf_words);
        const dg_ns end = pass_bytes(&rig, DG_MS(5), frames[i].ours, frames[i].hex);
        assert_int_equal(rig.count, 0);
        const dg_ns due = dg_words_step(&rig.wire, end);
        assert_true(due > end && due < end + DG_MS(6));
        assert_true(dg_words_step(&rig.wire, due) == DG_NEVER);
        assert_int_equal(rig.count, 1);
        assert_string_equal(rig.text, frames[i].text);
        assert_int_equal(rig.ours, frames[i].ours);
        assert_int_equal(rig.severity, frames[i].severity);
        assert_true(rig.at == DG_MS(5));
    }
}

/* clang-format off */
/* The others of 5.1.4, without their check sums. */
static const struct {
    bool ours;
    enum dg_severity severity;
    const char *hex;
    const char *text;
} more_frames[] = {
    {false, OK,     "40 46",                   "40h 46h read counter"},
    {true,  OK,     "40 46 01 02 03",          "40h -> 46h counter 66051"},
    {true,  OK,     "40 47",                   "40h -> 47h counter incremented"},
    {false, NOTICE, "40 49 55",                "40h 49h erase counter, code 55h"},
    {true,  OK,     "40 4B 01 02 03",          "40h -> 4Bh data field 01h offset 02h count 3 saved"},
    {false, OK,     "40 4C 01",                "40h 4Ch determine data field status 01h"},
    {true,  OK,     "40 4D 01 C8",             "40h -> 4Dh data field 01h created, status C8h"},
    {false, OK,     "40 4E",                   "40h 4Eh determine available memory area"},
    {true,  OK,     "40 4F 02",                "40h -> 4Fh access key 2 modified"},
    {false, OK,     "40 52",                   "40h 52h read type label"},
    {true,  OK,     "40 53",                   "40h -> 53h encoder reset"},
    {false, OK,     "40 56",                   "40h 56h read serial number and version"},
    {true,  OK,     "40 57 E4",                "40h -> 57h serial interface E4h"},
    {false, NOTICE, "40 6A 00 00 01 07 55",    "40h 6Ah set position with synchronization 263, code 55h"},
};

/* Status messages, 5.1.3. */
static const struct {
    uint8_t code;
    const char *text;
} messages[] = {
    {0x01, "faulty compensation data"},     {0x02, "faulty internal angular offset"},
    {0x03, "data field partitioning table destroyed"},
    {0x05, "internal I2C bus not operational"},
    {0x06, "internal check sum error"},     {0x08, "counter overflow"},
    {0x0A, "check sum error"},              {0x0B, "unknown command code"},
    {0x0C, "wrong command length"},         {0x0D, "wrong argument"},
    {0x0E, "data field may not be written"}, {0x0F, "wrong access code"},
    {0x10, "insufficient memory"},          {0x11, "address outside of the data field"},
    {0x12, "wrong data field number"},      {0x1D, "LED current"},
    {0x1E, "temperature"},                  {0x1F, "speed too high"},
    {0x20, "singleturn"},                   {0x21, "multiturn amplitude"},
    {0x22, "multiturn synchronization"},    {0x23, "multiturn vector length"},
};
/* clang-format on */

/* A frame that ends with its check sum: all bytes together are 0 (5.1.1). */
static void is_told(bool ours, const char *hex, const char *expected, enum dg_severity severity)
{
    struct words_rig rig;
    uint8_t bytes[32];
    char whole[128];
    uint8_t sum = 0;
    const size_t n = words_rig_hex(hex, bytes);
    for (size_t i = 0; i < n; i++) {
        sum ^= bytes[i];
    }
    (void)snprintf(whole, sizeof whole, "%s %02X", hex, sum);
    words_rig_init(&rig, &dg_hf_words);
    (void)dg_words_step(&rig.wire, pass_bytes(&rig, DG_MS(5), ours, whole) + DG_S(1));
    assert_string_equal(rig.text, expected);
    assert_int_equal(rig.severity, severity);
}

static void every_command_and_message_has_its_words(void **state)
{
    char hex[16];
    char expected[80];
    (void)state;
    for (size_t i = 0; i < DG_COUNT(more_frames); i++) {
        is_told(more_frames[i].ours, more_frames[i].hex, more_frames[i].text,
                more_frames[i].severity);
    }
    for (size_t i = 0; i < DG_COUNT(messages); i++) {
        (void)snprintf(hex, sizeof hex, "40 50 %02X", messages[i].code);
        (void)snprintf(expected, sizeof expected, "40h -> 50h error %02Xh %s", messages[i].code,
                       messages[i].text);
        is_told(true, hex, expected, ERROR);
    }
}

static void a_frame_ends_with_the_other_direction_or_silence(void **state)
{
    const dg_ns bit = dg_bit_times_ns(1, BAUD);
    struct words_rig rig;
    (void)state;
    words_rig_init(&rig, &dg_hf_words);
    assert_true(dg_words_step(&rig.wire, DG_S(1)) == DG_NEVER);
    dg_ns end = pass_bytes(&rig, 0, false, "40 42 02");
    end = pass_bytes(&rig, end + 12 * bit, true, "40 42 00");
    assert_int_equal(rig.count, 1);
    assert_string_equal(rig.text, "40h 42h read position");
    /* A pause of nearly 44 bits is inside a frame, also when the clock is looked at meanwhile. */
    (void)dg_words_step(&rig.wire, end + 43 * bit);
    end = pass_bytes(&rig, end + 43 * bit, true, "00 30 39 0B");
    assert_int_equal(rig.count, 1);
    (void)pass_bytes(&rig, end + 45 * bit, true, "40 43 03");
    assert_int_equal(rig.count, 2);
    assert_string_equal(rig.text, "40h -> 42h position 12345");
}

static void characters_in_a_bunch_are_a_frame(void **state)
{
    static const uint8_t bytes[] = {0x40, 0x42, 0x02};
    struct words_rig rig;
    (void)state;
    words_rig_init(&rig, &dg_hf_words);
    for (size_t i = 0; i < sizeof bytes; i++) {
        const struct dg_tap_event event = character(DG_MS(1), false, bytes[i]);
        dg_words_event(&rig.wire, &event);
    }
    (void)dg_words_step(&rig.wire, DG_S(1));
    assert_int_equal(rig.count, 1);
    assert_string_equal(rig.text, "40h 42h read position");
    assert_true(rig.at == 0); /* began before time did */
}

static void damage_and_length_are_told(void **state)
{
    struct words_rig rig;
    (void)state;
    words_rig_init(&rig, &dg_hf_words);
    struct dg_tap_event event = character(DG_MS(3), false, 0x40);
    event.character.damaged = true;
    dg_words_event(&rig.wire, &event);
    (void)pass_bytes(&rig, DG_MS(3), false, "42 02");
    (void)dg_words_step(&rig.wire, DG_S(1));
    assert_string_equal(rig.text, "40h 42h read position, damaged");
    assert_int_equal(rig.severity, ERROR);

    dg_ns at = DG_S(2);
    for (unsigned i = 0; i < 200; i++) {
        at = pass_bytes(&rig, at, false, "40");
    }
    (void)dg_words_step(&rig.wire, DG_S(9));
    assert_int_equal(rig.count, 2);
    assert_string_equal(rig.text, "40h 40h unknown command: 40 40 40 40 40 40 40 40 40 40 40 40 40 "
                                  "40 40 40 ..., 200 bytes are too many");
    assert_int_equal(rig.severity, ERROR);
}

static void other_events_are_left_alone(void **state)
{
    struct dg_tap_event event = {.at = DG_MS(1), .kind = DG_TAP_LEVELS, .levels = {true, true}};
    struct words_rig rig;

    (void)state;
    words_rig_init(&rig, &dg_hf_words);
    dg_words_event(&rig.wire, &event);
    event = (struct dg_tap_event){.at = DG_MS(1), .kind = DG_TAP_FRAME, .frame = {.id = 0x705}};
    dg_words_event(&rig.wire, &event);
    assert_true(dg_words_step(&rig.wire, DG_S(1)) == DG_NEVER);
    assert_int_equal(rig.count, 0);
}

/* Of commands, errors, and of frames that are none. */
static void lines_name_their_chapter(void **state)
{
    static const struct {
        bool ours;
        const char *hex;
        const char *clause;
    } rows[] = {
        {false, "40 42 02", "5.1.2.1"},
        {true, "40 42 00 00 30 39 0B", "5.1.2.1"},
        {true, "40 50 00 10", "5.1.2.13"},
        {true, "40 50 0D 1D", "5.1.3"},
        {false, "40 6A 00 00 00 00 55 7F", "5.1.2.19"},
        {false, "40 99 01 D8", "5.1.1.2"},
        {false, "40 42 03", "5.1.1.1"},
        {false, "40", "5.1.1.1"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct words_rig rig;
        words_rig_init(&rig, &dg_hf_words);
        const dg_ns end = pass_bytes(&rig, DG_MS(5), rows[i].ours, rows[i].hex);
        (void)dg_words_step(&rig.wire, end + DG_S(1));
        assert_non_null(rig.clause);
        assert_string_equal(rig.clause, rows[i].clause);
    }
}

static void frames_for_other_addresses_are_known(void **state)
{
    struct dg_tap_event event = character(0, false, 0x40);
    (void)state;
    assert_int_equal(dg_hf_words.side(&event, 0x40), DG_WORDS_AS_TOLD);
    assert_int_equal(dg_hf_words.side(&event, 0x41), DG_WORDS_OTHER);
    assert_int_equal(dg_hf_words.side(&event, 0), DG_WORDS_AS_TOLD);
    event.character.byte = 0xFF;
    assert_int_equal(dg_hf_words.side(&event, 0x41), DG_WORDS_AS_TOLD);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_in_the_manuals_words),
        cmocka_unit_test(every_command_and_message_has_its_words),
        cmocka_unit_test(a_frame_ends_with_the_other_direction_or_silence),
        cmocka_unit_test(characters_in_a_bunch_are_a_frame),
        cmocka_unit_test(damage_and_length_are_told),
        cmocka_unit_test(other_events_are_left_alone),
        cmocka_unit_test(lines_name_their_chapter),
        cmocka_unit_test(frames_for_other_addresses_are_known),
    };
    return cmocka_run_group_tests_name("words_hf", tests, NULL, NULL);
}
