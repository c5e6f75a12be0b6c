/* SPDX-License-Identifier: MIT */
/* WORLd:...:PROFile:POINts as masters write it: blanks, letters, and what is no word. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "control_rig.h"

static struct control_rig rig;

static int setup(void **state)
{
    (void)state;
    control_rig_start(&rig);
    return 0;
}

static void expect(const char *line, const char *answer)
{
    control_rig_expect(&rig, line, answer);
}

static void words_are_words_in_any_letters_behind_blanks(void **state)
{
    static const char *const lines[] = {
        "WORL:TEMP:PROF:POIN 0,20,2S,30,LOOP", "WORL:TEMP:PROF:POIN 0,20,2S,30,loop",
        "WORL:TEMP:PROF:POIN 0,20,2S,30, loop", "WORL:TEMP:PROF:POIN 0,20,2S,30,\t Loop"};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(lines); i++) {
        expect(lines[i], "");
        expect("WORL:TEMP:PROF:STAT?", "1");
        rig.now += DG_S(100);
        (void)dg_rig_step(&rig.rig, rig.now);
        expect("WORL:TEMP:PROF:STAT?", "1"); /* a loop never ends */
    }
}

/* What is neither a time nor a word is refused where a time belongs, and nothing follows. */
static void what_is_no_word_is_no_point_either(void **state)
{
    static const char *const lines[] = {
        "WORL:TEMP:PROF:POIN 0,20,2S,30,@loop", "WORL:TEMP:PROF:POIN 0,20,2S,30,[loop",
        "WORL:TEMP:PROF:POIN 0,20,2S,30,_loop", "WORL:TEMP:PROF:POIN 0,20,2S,30,{loop",
        "WORL:TEMP:PROF:POIN 0,20,2S,30,zloop", "WORL:TEMP:PROF:POIN 0,20,2S,30,Zloop"};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(lines); i++) {
        assert_string_equal(control_rig_say(&rig, lines[i]), "");
        assert_int_equal(control_rig_say(&rig, "SYST:ERR?")[0], '-');
        expect("WORL:TEMP:PROF:STAT?", "0");
        expect("*CLS", "");
    }
}

static void a_state_is_on_or_off(void **state)
{
    (void)state;
    expect("WORL:TEMP:PROF:POIN 0,20,2S,30", "");
    assert_string_equal(control_rig_say(&rig, "WORL:TEMP:PROF:STAT MAYBE"), "");
    assert_int_equal(control_rig_say(&rig, "SYST:ERR?")[0], '-');
    expect("WORL:TEMP:PROF:STAT?", "1");
}

/* A host that has no texts of courses plays them nevertheless. */
static void a_host_need_not_tell_what_is_followed(void **state)
{
    (void)state;
    rig.ops.course_text = NULL;
    expect("WORL:SUPP:PROF \"sag.csv\";PROF:STAT?", "1");
    expect("WORL:SUPP:PROF?", "\"\"");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(words_are_words_in_any_letters_behind_blanks, setup),
        cmocka_unit_test_setup(what_is_no_word_is_no_point_either, setup),
        cmocka_unit_test_setup(a_state_is_on_or_off, setup),
        cmocka_unit_test_setup(a_host_need_not_tell_what_is_followed, setup),
    };
    return cmocka_run_group_tests_name("control_points", tests, NULL, NULL);
}
