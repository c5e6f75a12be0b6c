/* SPDX-License-Identifier: MIT */
/* WORLd:...:PROFile: what an encoder senses over time, between commands, faults and *RST. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

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

static void refuse(const char *line, const char *error, const char *text)
{
    control_rig_refuse(&rig, line, error, text);
}

/* Time passes as it does for a host: from deadline to deadline. */
static void pass(dg_ns span)
{
    const dg_ns until = rig.now + span;
    dg_ns next = dg_rig_step(&rig.rig, rig.now);
    while (next <= until) {
        assert_true(next > rig.now);
        rig.now = next;
        next = dg_rig_step(&rig.rig, rig.now);
    }
    rig.now = until;
}

static void test_points(void **state)
{
    (void)state;
    expect("WORL:TEMP:PROF:POIN 1S,20,11000,85", "");
    assert_int_equal(rig.changes, 1);
    assert_ptr_equal(rig.changed, &rig.encoder[CONTROL_RIG_HF]);
    expect("WORL:TEMP:PROF:STAT?", "1");
    expect("WORL:TEMP?", "37.000");
    pass(DG_S(1));
    expect("WORL:TEMP?", "20.000");
    pass(DG_S(5));
    expect("WORL:TEMP?;TEMP:PROF:STAT?", "52.500;1");
    pass(DG_S(5) - 1u);
    expect("WORL:TEMP?", "84.994");
    pass(1);
    expect("WORL:TEMP?;TEMP:PROF:STAT?", "85.000;0");
    expect("WORL:TEMP:PROF?", "\"\"");
    assert_true(dg_rig_step(&rig.rig, rig.now) == DG_NEVER);
}

static void test_a_file(void **state)
{
    (void)state;
    expect("WORL:SUPP:PROF \"sag.csv\",LOOP,STEP", "");
    assert_string_equal(rig.call, "course");
    assert_string_equal(rig.text, "sag.csv");
    expect("WORL:SUPP:PROF?;PROF:STAT?", "\"sag.csv\";1");
    expect("WORL:SUPP?", "0");
    pass(DG_MS(999));
    expect("WORL:SUPP?", "0");
    pass(DG_S(1000));
    expect("WORL:SUPP?;SUPP:PROF:STAT?", "0;1");
    expect("INST:SEL can;:WORL:SUPP:PROF:STAT?", "0"); /* another encoder's */
}

static void test_states_hold(void **state)
{
    (void)state;
    expect("WORL:SING:PROF:POIN 0,ON,1S,OFF,2S,1", "");
    pass(DG_MS(900));
    expect("WORL:SING?", "1");
    pass(DG_MS(200));
    expect("WORL:SING?", "0");
    pass(DG_S(1));
    expect("WORL:SING?;SING:PROF:STAT?", "1;0");
    expect("WORL:MULT:SYNC:PROF 'x.csv',LIN", "");
    pass(DG_MS(900));
    expect("WORL:MULT:SYNC?", "0");
}

static void test_several_at_once(void **state)
{
    (void)state;
    expect("WORL:TEMP:PROF:POIN 0,0,1S,100", "");
    expect("WORL:SUPP:PROF:POIN 0,0,10S,1V", "");
    expect("WORL:BATT:PROF:POIN 0,0MV,4S,4000MV", "");
    expect("INST:SEL k3;:WORL:TEMP:PROF:POIN 0,10,2S,20", "");
    pass(DG_MS(500));
    expect("WORL:TEMP?;:INST:SEL hf;:WORL:TEMP?;SUPP?;BATT?", "12.500;50.000;50;500");
    expect("WORL:SUPP:PROF:STAT OFF;:WORL:TEMP:PROF:POIN 0,5,100,6", "");
    pass(DG_S(4));
    expect("WORL:TEMP?;SUPP?;BATT?", "6.000;50;4000");
    assert_null(rig.encoder[CONTROL_RIG_HF].courses);
}

/* Setting by hand, WORLd:DEFault and *RST end it. */
static void test_what_ends_one(void **state)
{
    static const char *const ends[] = {
        "WORL:TEMP 37",
        "WORL:DEF",
        "*RST",
        "WORL:TEMP:PROF:STAT OFF;:WORL:TEMP 37",
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(ends); i++) {
        expect("WORL:TEMP:PROF:POIN 0,20,1S,85,LOOP;:WORL:TEMP:PROF:STAT ON;STAT?", "1");
        pass(DG_MS(500));
        expect(ends[i], "");
        expect("WORL:TEMP:PROF:STAT?", "0");
        pass(DG_S(2));
        expect("WORL:TEMP?", "37.000");
    }
    expect("WORL:TEMP:PROF:POIN 0,20,1S,85;:WORL:SUPP 4V;:WORL:TEMP:PROF:STAT?", "1");
}

/* The host has to look at the encoder: what it follows has an end no more. */
static void test_off_is_a_change(void **state)
{
    (void)state;
    expect("WORL:TEMP:PROF:POIN 0,20,1S,85", "");
    const unsigned changes = rig.changes;
    rig.changed = NULL;
    expect("WORL:TEMP:PROF:STAT OFF", "");
    assert_int_equal(rig.changes, changes + 1);
    assert_ptr_equal(rig.changed, &rig.encoder[CONTROL_RIG_HF]);
}

/* A fault goes before a course, and gives way to what that has come to. */
static void test_a_fault_bends_it_meanwhile(void **state)
{
    (void)state;
    expect("WORL:TEMP:PROF:POIN 0,20,10S,30", "");
    pass(DG_S(1));
    expect("FAUL:SET temperature_high,DUR 5S", "");
    pass(DG_S(4));
    expect("WORL:TEMP?;TEMP:PROF:STAT?", "125.000;1");
    pass(DG_S(1));
    expect("WORL:TEMP?", "26.000");
    expect("FAUL:SET temperature_high", "");
    pass(DG_S(100));
    expect("WORL:TEMP?;TEMP:PROF:STAT?", "125.000;0");
    expect("FAUL:CLE;:WORL:TEMP?", "30.000");
}

/* Nobody waits for a course. */
static void test_nobody_waits(void **state)
{
    (void)state;
    expect("WORL:TEMP:PROF:POIN 0,20,10S,30;*OPC?", "1");
    expect("*WAI;:WORL:TEMP?", "20.000");
}

static void test_refusals(void **state)
{
    (void)state;
    refuse("WORL:TEMP:PROF:POIN", "-109", NULL);
    refuse("WORL:TEMP:PROF:POIN 1", "-109", NULL);
    refuse("WORL:TEMP:PROF:POIN 1,20,2", "-109", NULL);
    refuse("WORL:TEMP:PROF:POIN -1,20", "-222", NULL);
    refuse("WORL:TEMP:PROF:POIN 1,1001", "-222", "-273..1000 DEGC");
    refuse("WORL:TEMP:PROF:POIN 1RPM,20", "-131", NULL);
    refuse("WORL:TEMP:PROF:POIN 2,20,1,30", "-224", "times go on");
    refuse("WORL:TEMP:PROF:POIN 0,20,LOOP", "-224", "times go on");
    refuse("WORL:TEMP:PROF:POIN 0,20,SOMETIMES", "-224", "LINear");
    refuse("WORL:TEMP:PROF:POIN LOOP,0,20", "-104", NULL);
    refuse("WORL:SING:PROF:POIN 0,2", "-224", NULL);
    refuse("WORL:TEMP:PROF:STAT ON", "-221", "PROFile:POINts");
    refuse("WORL:TEMP:PROF x.csv,LOOP,STEP,ONCE", "-108", NULL);
    refuse("WORL:TEMP:PROF \"t.csv\",ONCE STEP", "-102", "STEP; a comma is missing");
    refuse("WORL:TEMP:PROF:POIN 0,20,1,30,ONCE STEP", "-102", "STEP; a comma is missing");
    refuse("WORL:TEMP:PROF", "-109", NULL);
    rig.result = DG_SCPI_FILE_NAME;
    refuse("WORL:TEMP:PROF x.csv", "-256", "as course says");
    rig.ops.course = NULL;
    refuse("WORL:TEMP:PROF x.csv", "-241", NULL);
    rig.rig.courses = NULL;
    refuse("WORL:TEMP:PROF x.csv", "-113", NULL);
    assert_null(rig.encoder[CONTROL_RIG_HF].courses);
}

static void test_as_many_points_as_fit(void **state)
{
    char line[512] = "WORL:TEMP:PROF:POIN 0,20";
    (void)state;
    for (unsigned i = 1; i < CONTROL_RIG_POINTS; i++) {
        strcat(line, ",1,30");
    }
    expect(line, "");
    strcat(line, ",STEP");
    expect(line, "");
    line[strlen(line) - strlen("STEP")] = '\0';
    strcat(line, "1,30");
    refuse(line, "-222", "at most 32 points");
}

static struct {
    unsigned parts;
    bool gone;
} told;

static int read_a_part(struct dg_rig *self, struct dg_encoder *encoder, dg_ns now, bool gone,
                       char *detail)
{
    (void)self;
    (void)now;
    assert_ptr_equal(encoder, &rig.encoder[CONTROL_RIG_HF]);
    assert_string_equal(detail, "");
    told.gone = gone;
    return --told.parts > 0 ? DG_RIG_READS : rig.result;
}

static void read_in_parts(int result)
{
    rig.ops.course_more = read_a_part;
    rig.result = DG_RIG_READS;
    assert_string_equal(control_rig_say(&rig, "WORL:TEMP:PROF long.csv;:WORL:TEMP?"), "");
    told.parts = 2;
    rig.result = result;
    rig.changes = 0;
}

static void test_a_file_in_parts(void **state)
{
    (void)state;
    read_in_parts(DG_SCPI_NO_ERROR);
    assert_int_equal(dg_control_step(&rig.control, rig.now), rig.now);
    assert_string_equal(rig.answer, ""); /* what stands behind it waits */
    assert_int_equal(rig.changes, 0);
    assert_int_equal(dg_control_step(&rig.control, rig.now), DG_NEVER);
    assert_string_equal(rig.answer, "37.000\n");
    assert_int_equal(rig.changes, 1);

    read_in_parts(DG_SCPI_FILE_NAME);
    assert_int_equal(dg_control_step(&rig.control, rig.now), rig.now);
    assert_int_equal(dg_control_step(&rig.control, rig.now), DG_NEVER);
    assert_string_equal(control_rig_say(&rig, "SYST:ERR?"), "-256,\"File name not found\"");

    read_in_parts(DG_SCPI_NO_ERROR);
    dg_scpi_leave(&rig.control.session);
    assert_true(told.gone);
}

/* As a rig file has it: from the start on, which is before the device is made. */
static void test_before_there_is_a_device(void **state)
{
    static const struct dg_course_point points[] = {{0, 20000}, {DG_S(1), 30000}};
    struct dg_encoder *encoder = &rig.encoder[CONTROL_RIG_HF];
    void *device = encoder->device;
    struct dg_rig_course course = {.course = {.points = points},
                                   .quantity = DG_QUANTITY_TEMPERATURE};
    (void)state;
    assert_int_equal(dg_rig_follow(&rig.rig, encoder, &course, rig.now), DG_ERR_ARGUMENT);
    assert_null(encoder->courses);
    course.course.count = 2;
    encoder->device = NULL;
    assert_int_equal(dg_rig_follow(&rig.rig, encoder, &course, rig.now), DG_OK);
    encoder->device = device;
    expect("WORL:TEMP?", "20.000");
    pass(DG_S(1));
    expect("WORL:TEMP?;TEMP:PROF:STAT?", "30.000;0");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_points, setup),
        cmocka_unit_test_setup(test_a_file, setup),
        cmocka_unit_test_setup(test_states_hold, setup),
        cmocka_unit_test_setup(test_several_at_once, setup),
        cmocka_unit_test_setup(test_what_ends_one, setup),
        cmocka_unit_test_setup(test_off_is_a_change, setup),
        cmocka_unit_test_setup(test_a_fault_bends_it_meanwhile, setup),
        cmocka_unit_test_setup(test_nobody_waits, setup),
        cmocka_unit_test_setup(test_refusals, setup),
        cmocka_unit_test_setup(test_as_many_points_as_fit, setup),
        cmocka_unit_test_setup(test_a_file_in_parts, setup),
        cmocka_unit_test_setup(test_before_there_is_a_device, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
