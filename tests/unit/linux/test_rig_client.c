/* SPDX-License-Identifier: MIT */
/* What clients of the control plane ask of a rig, in virtual time: to the nanosecond. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "rig_parts.h"
#include "timer.h"
#include "virtual_rig.h"

#define SIM "[encoder e]\nmodel = s3684-biss\nwire = sim\n"

static char folder[] = "/tmp/test_rig_client.XXXXXX";

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) == NULL || chdir(folder) != 0 ? -1 : 0;
}

static int remove_folder(void **state)
{
    (void)state;
    (void)unlink("rig.ini");
    return chdir("/") != 0 || rmdir(folder) != 0 ? -1 : 0;
}

static void write_file(const char *name, const char *text)
{
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static struct virtual_rig *open_rig(const char *text)
{
    struct virtual_rig *rig = calloc(1, sizeof *rig);
    assert_non_null(rig);
    write_file("rig.ini", text);
    virtual_rig_open(rig, "rig.ini", NULL);
    return rig;
}

static void close_rig(struct virtual_rig *rig)
{
    virtual_rig_close(rig);
    free(rig);
}

static void answers(struct virtual_rig *rig, const char *question, const char *answer)
{
    virtual_rig_ask(rig, question);
    if (strcmp(rig->answer, answer) != 0) {
        fail_msg("%s: %s, not %s", question, rig->answer, answer);
    }
}

/* A command that is refused, and the words. */
static void refuses(struct virtual_rig *rig, const char *command, const char *words)
{
    virtual_rig_ask(rig, command);
    answers(rig, "SYST:ERR?", words);
}

/* 60RPM are 360 degrees a second of the rig. */
static void time_is_stopped_stepped_and_stretched(void **state)
{
    struct virtual_rig *rig = open_rig("[shaft s]\nmotion = 60RPM\n" SIM);
    (void)state;
    answers(rig, "TIME?;TIME:SCAL?", "0.000000000;1.000");
    virtual_rig_pass(rig, DG_MS(1500));
    answers(rig, "TIME?;:SHAF:POS?", "1.500000000;540.000000");
    refuses(rig, "TIME:STEP 1S",
            "-221,\"Settings conflict;time is not stopped; TIME:SCALe 0 first\"");
    virtual_rig_order(rig, "TIME:SCAL 0");
    virtual_rig_pass(rig, DG_S(7));
    answers(rig, "TIME?;TIME:SCAL?", "1.500000000;0.000");
    virtual_rig_order(rig, "TIME:STEP 250MS");
    answers(rig, "TIME?;:SHAF:POS?", "1.750000000;630.000000");
    virtual_rig_order(rig, "TIME:SCAL 2.5");
    virtual_rig_pass(rig, DG_MS(100));
    answers(rig, "TIME?;TIME:SCAL?", "2.000000000;2.500");
    close_rig(rig);
}

static void count_event(void *ctx, const struct dg_tap_event *event)
{
    (void)event;
    ++*(unsigned *)ctx;
}

/* A wire goes by the time of the rig, also when that goes on again. */
static void a_wire_stops_and_goes_on_with_time(void **state)
{
    struct virtual_rig *rig = calloc(1, sizeof *rig);
    unsigned count = 0;
    struct lx_tap_listener listener = {.event = count_event, .ctx = &count};
    (void)state;
    assert_non_null(rig);
    write_file("rig.ini", SIM);
    virtual_rig_open(rig, "rig.ini", &listener);
    virtual_rig_pass(rig, DG_S(1));
    const unsigned running = count;
    assert_true(running > 0);
    virtual_rig_order(rig, "TIME:SCAL 0");
    virtual_rig_pass(rig, DG_S(1));
    assert_int_equal(count, running);
    virtual_rig_order(rig, "TIME:SCAL 1");
    virtual_rig_pass(rig, DG_S(1));
    assert_in_range(count, 2 * running - running / 4, 2 * running + running / 4);
    close_rig(rig);
}

#define LEVELS_MAX 64u

struct levels {
    dg_ns at[LEVELS_MAX];
    size_t count;
};

static void keep_moment(void *ctx, const struct dg_tap_event *event)
{
    struct levels *self = ctx;
    if (event->kind == DG_TAP_SINCOS) {
        assert_true(self->count < LEVELS_MAX);
        self->at[self->count++] = event->at;
    }
}

/* As they are when somebody begins to ask for them, then at whole multiples of their interval. */
static void sines_are_told_from_the_question_on(void **state)
{
    struct virtual_rig *rig = open_rig("[shaft s]\nmotion = 60RPM\n[encoder e]\n"
                                       "model = s3684-rs485\nwire = rs485:tcp:127.0.0.1:0\n");
    struct levels levels = {.count = 0};
    struct lx_tap_listener listener = {.event = keep_moment, .ctx = &levels, .sincos = true};
    (void)state;
    virtual_rig_pass_to(rig, lx_now() - lx_now() % DG_MS(1) + DG_S(1) + DG_US(300));
    const dg_ns begin = lx_now();
    rig->listener = &listener; /* which is taken away at the end */
    lx_tap_add(&rig->rig->wires[0].bus->tap, &listener);
    virtual_rig_order(rig, "WORL:TEMP 30"); /* the line looks who listens */
    virtual_rig_pass(rig, DG_MS(25));
    assert_true(levels.count > 10);
    assert_int_equal(levels.at[0], begin);
    for (size_t i = 1; i < levels.count; i++) {
        assert_int_equal(levels.at[i], begin - DG_US(300) + i * DG_MS(1));
    }
    close_rig(rig);
}

static void real_wires_have_real_time(void **state)
{
    struct virtual_rig *rig = open_rig("[encoder e]\nmodel = f3668\nwire = slcan\n");
    (void)state;
    refuses(
        rig, "TIME:SCAL 0",
        "-221,\"Settings conflict;a wire of this rig runs in real time; expected only sim wires\"");
    refuses(rig, "TIME:STEP 1S",
            "-221,\"Settings conflict;time is not stopped; TIME:SCALe 0 first\"");
    close_rig(rig);
}

/* Whether time passes or is stepped over it. */
static void a_fault_ends_at_its_moment(void **state)
{
    struct virtual_rig *rig = open_rig(SIM);
    (void)state;
    virtual_rig_order(rig, "FAUL:SET temperature_high,DURation 1S");
    virtual_rig_pass(rig, DG_MS(999));
    answers(rig, "FAUL:ACT?", "\"temperature_high\"");
    virtual_rig_pass(rig, DG_MS(1));
    answers(rig, "FAUL:ACT?", "\"\"");
    virtual_rig_order(rig, "TIME:SCAL 0");
    virtual_rig_order(rig, "FAUL:SET temperature_high,DURation 1S");
    virtual_rig_order(rig, "TIME:STEP 999MS");
    answers(rig, "FAUL:ACT?", "\"temperature_high\"");
    virtual_rig_order(rig, "TIME:STEP 1MS");
    answers(rig, "FAUL:ACT?", "\"\"");
    close_rig(rig);
}

static void what_a_shaft_does_has_a_name(void **state)
{
    struct virtual_rig *rig =
        open_rig("[shaft s]\nmotion = ramp:60RPM,1S\n[shaft t]\ndriver = s\nratio = 1:2\n"
                 "[bus b]\nwire = sim\n[encoder e]\nmodel = s3684-biss\nbus = b\nshaft = s\n"
                 "[encoder f]\nmodel = s3684-biss\nbus = b\nshaft = t\n");
    (void)state;
    answers(rig, "SHAF:PROF?", "\"ramp:60RPM,1S\"");
    virtual_rig_order(rig, "SHAF:VEL 30RPM");
    answers(rig, "SHAF:PROF?", "\"steered\"");
    virtual_rig_order(rig, "SHAF:STOP");
    answers(rig, "SHAF:PROF?", "\"rest\"");
    virtual_rig_order(rig, "SHAF:PROF \"2REV\"");
    answers(rig, "SHAF:PROF?;POS?", "\"2REV\";720.000000");
    virtual_rig_order(rig, "INST:SEL f");
    answers(rig, "SHAF:PROF?", "\"geared\"");
    refuses(rig, "SHAF:PROF \"2REV\"", "-221,\"Settings conflict;geared; its driver turns it\"");
    close_rig(rig);
}

/* 38 digits: with them the whole refusal has as many characters as fit. */
#define DIGITS "00000000000000000000000000000000000005"
#define WRONG DIGITS "' has no unit"
#define RIGHT "; expected an angle such as 90DEG or 2.5REV"
_Static_assert(sizeof "'" WRONG RIGHT - 1u == DG_SCPI_DETAIL_MAX, "all of it, and no more");

static void what_would_be_right_is_said_when_all_of_it_fits(void **state)
{
    struct virtual_rig *rig = open_rig("[shaft s]\n" SIM);
    (void)state;
    refuses(rig, "SHAF:PROF \"sine:" DIGITS ",2S\"",
            "-224,\"Illegal parameter value;'" WRONG RIGHT "\"");
    refuses(rig, "SHAF:PROF \"sine:0" DIGITS ",2S\"",
            "-224,\"Illegal parameter value;'0" WRONG "\"");
    close_rig(rig);
}

/* A line for each moment of the grid, whenever the loop comes round, and none behind the end. */
static void a_recording_has_its_moments(void **state)
{
    struct virtual_rig *rig = open_rig("[rig]\nfiles = .\n[shaft s]\nmotion = 60RPM\n" SIM);
    char text[256] = "";
    (void)state;
    virtual_rig_pass(rig, DG_S(1));
    refuses(rig, "SHAF:REC:STAR \"r.txt\"",
            "-257,\"File name error;r.txt: the name of a recording ends in .csv\"");
    virtual_rig_order(rig, "SHAF:REC:STAR \"r.csv\",125MS");
    refuses(rig, "SHAF:REC:STAR \"q.csv\"",
            "-221,\"Settings conflict;recorded already; SHAFt:RECord:STOP first\"");
    virtual_rig_pass(rig, DG_MS(250));
    virtual_rig_order(rig, "SHAF:VEL 120RPM");
    virtual_rig_pass(rig, DG_MS(149));
    virtual_rig_order(rig, "SHAF:REC:STOP");
    virtual_rig_pass(rig, DG_S(1));
    FILE *file = fopen("r.csv", "r");
    assert_non_null(file);
    assert_true(fread(text, 1, sizeof text - 1, file) > 0);
    (void)fclose(file);
    assert_int_equal(unlink("r.csv"), 0);
    assert_string_equal(text,
                        "time_s,angle_deg\n0.000000000,360.000000000\n0.125000000,405.000000000\n"
                        "0.250000000,450.000000000\n0.375000000,540.000000000\n");
    close_rig(rig);
}

/* The first question begins the listening. Whole frames only, the latest last. */
static void the_last_frames_are_told_in_words(void **state)
{
    struct virtual_rig *rig =
        open_rig("[encoder e]\nmodel = f3668\nwire = slcan:tcp:127.0.0.1:0\n");
    static const char frames[] = "C\rS8\rO\rt0002010a\rt0800\r";
    (void)state;
    virtual_rig_connect(rig);
    virtual_rig_pass(rig, DG_S(2));
    answers(rig, "TRAC:LAST?", "\"\"");
    virtual_rig_say(rig, (const uint8_t *)frames, sizeof frames - 1u);
    virtual_rig_pass(rig, DG_S(1));
    answers(rig, "TRAC:LAST? 2", "\"2.000000 < NMT start node 10\",\"2.000000 < SYNC\"");
    answers(rig, "TRAC:LAST?", "\"2.000000 < SYNC\"");
    close_rig(rig);
}

/* By the names of the quantities, in their order. */
static void courses_that_are_followed_are_named(void **state)
{
    struct virtual_rig *rig = open_rig(SIM);
    (void)state;
    virtual_rig_ask(rig, "STAT?");
    assert_non_null(strstr(rig->answer, ",courses=-"));
    virtual_rig_order(rig, "WORL:SUPP:PROF:POIN 0,5000,9S,6000");
    virtual_rig_order(rig, "WORL:TEMP:PROF:POIN 0,20,9S,30");
    virtual_rig_ask(rig, "STAT?");
    assert_non_null(strstr(rig->answer, ",courses=temperature/supply_mv"));
    answers(rig, "WORL:TEMP:PROF?", "\"points\"");
    virtual_rig_pass(rig, DG_MS(4500));
    answers(rig, "WORL:TEMP?;SUPP?", "25.000;5500");
    virtual_rig_pass(rig, DG_S(5));
    answers(rig, "WORL:TEMP:PROF?", "\"\"");
    close_rig(rig);
}

/* With what would be right, as long as there is room for it. */
static void what_is_refused_says_what_is_right(void **state)
{
    struct virtual_rig *rig =
        open_rig("[encoder e]\nmodel = s3684-biss\nwire = sim\nnvm = e.nvm\n");
    (void)state;
    refuses(rig, "WORL:TEMP:PROF \"a.csv,WRONG\"",
            "-224,\"Illegal parameter value;'WRONG' is none of the words; expected "
            "FILE.csv[,ONCE|LOOP][,LINEAR|STEP]\"");
    refuses(
        rig, "WORL:TEMP:PROF \"a.csv,WRONGWRONGWRONGWRONGWRONGWRONG\"",
        "-224,\"Illegal parameter value;'WRONGWRONGWRONGWRONGWRONGWRONG' is none of the words\"");
    virtual_rig_ask(rig, "STAT?");
    assert_non_null(strstr(rig->answer, ",nvm_waits=0,"));
    close_rig(rig);
    assert_int_equal(unlink("e.nvm"), 0);
}

/* Whatever folder the command was started in. */
static void files_that_a_rig_names_lie_beside_it(void **state)
{
    static const char *const files[] = {"sub/rig.ini", "sub/turn.csv", "sub/warm.csv", "sub/e.nvm",
                                        "sub/e.vcd"};
    (void)state;
    assert_int_equal(mkdir("sub", 0700), 0);
    write_file("sub/turn.csv", "0,0\n1,360\n");
    write_file("sub/warm.csv", "0,20\n1,30\n");
    write_file("sub/rig.ini", "[shaft s]\nmotion = turn.csv\n"
                              "[encoder e]\nmodel = s3684-biss\nwire = sim\nnvm = e.nvm\n"
                              "trace = e.vcd\ntemperature = warm.csv\n");
    struct virtual_rig *rig = calloc(1, sizeof *rig);
    assert_non_null(rig);
    virtual_rig_open(rig, "sub/rig.ini", NULL);
    virtual_rig_pass(rig, DG_MS(500));
    answers(rig, "SHAF:POS?;:WORL:TEMP?", "180.000000;25.000");
    close_rig(rig);
    for (size_t i = 0; i < DG_COUNT(files); i++) {
        assert_int_equal(unlink(files[i]), 0);
    }
    assert_int_equal(rmdir("sub"), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(time_is_stopped_stepped_and_stretched),
        cmocka_unit_test(a_wire_stops_and_goes_on_with_time),
        cmocka_unit_test(sines_are_told_from_the_question_on),
        cmocka_unit_test(real_wires_have_real_time),
        cmocka_unit_test(a_fault_ends_at_its_moment),
        cmocka_unit_test(what_a_shaft_does_has_a_name),
        cmocka_unit_test(what_would_be_right_is_said_when_all_of_it_fits),
        cmocka_unit_test(a_recording_has_its_moments),
        cmocka_unit_test(the_last_frames_are_told_in_words),
        cmocka_unit_test(courses_that_are_followed_are_named),
        cmocka_unit_test(what_is_refused_says_what_is_right),
        cmocka_unit_test(files_that_a_rig_names_lie_beside_it),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
