/* SPDX-License-Identifier: MIT */
/* What all words have in common. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
#include "words_rig.h"

static void notes_as_they_are(void **state)
{
    char note[400];
    struct dg_tap_event event = {.at = 9, .kind = DG_TAP_NOTE, .note = "power off"};
    struct words_rig rig;
    (void)state;
    words_rig_init(&rig, &dg_hf_words);
    dg_words_event(&rig.wire, &event);
    assert_string_equal(rig.text, "power off");
    assert_true(rig.at == 9 && !rig.ours && rig.severity == DG_SEVERITY_OK);
    event.kind = DG_TAP_LEVELS;
    dg_words_event(&rig.wire, &event);
    assert_int_equal(rig.count, 1);
    memset(note, 'x', sizeof note);
    note[sizeof note - 1] = '\0';
    event.kind = DG_TAP_NOTE;
    event.note = note;
    dg_words_event(&rig.wire, &event);
    assert_int_equal(strlen(rig.text), DG_WORDS_MAX - 1);
    assert_string_equal(rig.text + DG_WORDS_MAX - 5, "x...");
}

static void a_note_is_as_bad_as_its_teller_says(void **state)
{
    struct dg_tap_event event = {.kind = DG_TAP_NOTE, .ours = true, .note = "no answer"};
    struct words_rig rig;

    (void)state;
    words_rig_init(&rig, &dg_ib_words);
    for (unsigned i = 0; i < DG_SEVERITY_COUNT; i++) {
        event.severity = (enum dg_severity)i;
        dg_words_event(&rig.wire, &event);
        assert_int_equal(rig.severity, i);
        assert_true(rig.ours);
    }
}

/* Somebody's protocol without words: of its wire only notes are told, whatever travels. */
static void a_wire_without_words_tells_its_notes(void **state)
{
    struct dg_tap_event event = {.at = DG_MS(1), .kind = DG_TAP_NOTE, .note = "power off"};
    struct words_rig rig;

    (void)state;
    words_rig_init(&rig, NULL);
    dg_words_event(&rig.wire, &event);
    assert_string_equal(rig.text, "power off");
    for (unsigned i = 0; i < DG_TAP_KIND_COUNT; i++) {
        event = (struct dg_tap_event){.at = DG_MS(2), .kind = (enum dg_tap_kind)i};
        if (event.kind != DG_TAP_NOTE) {
            dg_words_event(&rig.wire, &event);
        }
    }
    assert_true(dg_words_step(&rig.wire, DG_S(9)) == DG_NEVER);
    assert_int_equal(rig.count, 1);
}

/* Characters are not HIPERFACE's, nor frames CANopen's, on another protocol's wire. */
static void words_leave_other_wires_alone(void **state)
{
    static uint16_t image[2] = {1, 2};
    const struct dg_tap_event events[DG_TAP_KIND_COUNT] = {
        [DG_TAP_CHARACTER] = {.kind = DG_TAP_CHARACTER, .character = {9600, 'E', 0x40, false}},
        [DG_TAP_FRAME] = {.kind = DG_TAP_FRAME, .frame = {.id = 0x705, .dlc = 1}},
        [DG_TAP_LEVELS] = {.kind = DG_TAP_LEVELS, .levels = {true, true}},
        [DG_TAP_WORDS] = {.kind = DG_TAP_WORDS,
                          .words = {.in = image, .out = image, .count = 2, .valid = true}},
        [DG_TAP_NOTE] = {.kind = DG_TAP_NOTE, .note = "note"},
        [DG_TAP_SINCOS] = {.kind = DG_TAP_SINCOS},
    };

    (void)state;
    for (size_t i = 0; i < dg_words_count; i++) {
        unsigned told = 0;
        for (unsigned kind = 0; kind < DG_TAP_KIND_COUNT; kind++) {
            struct words_rig rig;
            words_rig_init(&rig, dg_words_list[i]);
            dg_words_event(&rig.wire, &events[kind]);
            (void)dg_words_step(&rig.wire, DG_S(1));
            told += rig.count;
        }
        assert_int_equal(told, 2); /* its own, and the note */
    }
}

static void words_are_found_by_their_stack(void **state)
{
    (void)state;
    assert_ptr_equal(dg_words_of(&dg_hf_stack), &dg_hf_words);
    assert_ptr_equal(dg_words_of(&dg_cia406_stack), &dg_cia406_words);
    assert_ptr_equal(dg_words_of(&dg_ib_stack), &dg_ib_words);
    assert_null(dg_words_of(&dg_biss_stack)); /* its master's notes are words already */
    assert_null(dg_words_of(NULL));
    for (size_t i = 0; i < dg_words_count; i++) {
        assert_ptr_equal(dg_words_of(dg_words_list[i]->stack), dg_words_list[i]);
    }
}

static void what_does_not_fit_is_cut(void **state)
{
    static const struct {
        size_t length;
        const char *end;
    } rows[] = {{158, "nn"}, {159, "nnn"}, {160, "n..."}, {161, "n..."}, {399, "n..."}};
    char note[400];
    struct words_rig rig;

    (void)state;
    words_rig_init(&rig, NULL);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_tap_event event = {.kind = DG_TAP_NOTE, .note = note};
        const size_t kept = rows[i].length < DG_WORDS_MAX ? rows[i].length : DG_WORDS_MAX - 1u;

        memset(note, 'n', rows[i].length);
        note[rows[i].length] = '\0';
        dg_words_event(&rig.wire, &event);
        assert_int_equal(strlen(rig.text), kept);
        assert_string_equal(rig.text + kept - strlen(rows[i].end), rows[i].end);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(notes_as_they_are),
        cmocka_unit_test(a_note_is_as_bad_as_its_teller_says),
        cmocka_unit_test(a_wire_without_words_tells_its_notes),
        cmocka_unit_test(words_leave_other_wires_alone),
        cmocka_unit_test(words_are_found_by_their_stack),
        cmocka_unit_test(what_does_not_fit_is_cut),
    };
    return cmocka_run_group_tests_name("words", tests, NULL, NULL);
}
