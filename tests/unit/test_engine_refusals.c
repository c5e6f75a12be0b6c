/* SPDX-License-Identifier: MIT */
/* Settings and hosts that no rig can be made of, and what is said of them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "engine_rig.h"

static struct engine_rig rig;

#define LINE_OF "[bus rs]\nwire = pty\n[encoder a]\nbus = rs\nmodel = s3684-rs485\n"
#define NODE_OF "[bus vcan]\nwire = can\naddress = vcan0\n[encoder n]\nbus = vcan\nmodel = f3658\n"
#define CHAIN_OF "[bus c]\nwire = sim\n[encoder b]\nbus = c\nmodel = s3684-biss\n"
#define WORD_OF "[bus c]\nwire = sim\n[encoder b]\nbus = c\nmodel = ssi-25\n"

/* ------------------------------------------------------------ settings */

static const struct {
    const char *text;
    unsigned line;
    const char *key;
    const char *what;
    const char *right;
} refused[] = {
    {LINE_OF "date = 2020\n", 6, "date", "", "expected 8 characters"},
    {LINE_OF "version = 12345678901234567890\n", 6, "version", "", "expected 0 to 19 characters"},
    {LINE_OF "cycle = 1000\n", 6, "cycle", "only a modbus wire has it", "leave it out"},
    {LINE_OF "clock_hz = 1000\n", 6, "clock_hz", "only a sim wire has it", "leave it out"},
    {LINE_OF "supply_mv = 1x\n", 6, "supply_mv", NULL, NULL},
    {WORD_OF "code = grey\n", 6, "code", "", "expected gray or binary"},
    {WORD_OF "parity = yes\n", 6, "parity", "", "expected none, even or odd"},
    {WORD_OF "serial = 5\n", 6, "serial", "ssi-25 has none", "leave it out"},
    {NODE_OF "mt_bits = 12\n", 7, "mt_bits", "no such key", NULL},
    {NODE_OF "mt_bits = x.csv\n", 7, "mt_bits", "no such key", NULL},
    {NODE_OF "node = 3\nserial = -1\n", 8, "serial", "", "expected a number in 0..4294967295"},
    {"[bus loop]\nwire = modbus\nbreak_at = 1000\n[encoder k]\nbus = loop\nmodel = ocd-ib-k2\n", 3,
     "break_at", "", "expected a number in 0..511"},
    {"[bus c]\nwire = sim\nclock_hz = 1\n[encoder b]\nbus = c\nmodel = ssi-25\n", 3, "clock_hz", "",
     NULL},
    {NODE_OF "temperature = x.csv\n", 7, "temperature", "there are no files here",
     "expected a value"},
};

static void a_setting_is_refused_with_what_is_right(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(refused); i++) {
        engine_rig_read(&rig, refused[i].text);
        engine_rig_make(&rig);
        if (rig.engine != NULL || strcmp(rig.error.key, refused[i].key) != 0) {
            fail_msg("%s: %s: %s; %s", refused[i].text, rig.error.key, rig.error.what,
                     rig.error.right);
        }
        assert_int_equal(rig.error.line, refused[i].line);
        if (refused[i].what != NULL) {
            assert_string_equal(rig.error.what, refused[i].what);
        }
        if (refused[i].right != NULL) {
            assert_string_equal(rig.error.right, refused[i].right);
        }
    }
}

/* Of the encoder and of its wire, each with a blank in between. */
static void a_key_that_nobody_has_gets_those_of_the_wire(void **state)
{
    (void)state;
    engine_rig_read(&rig, CHAIN_OF "nonsense = 1\n");
    engine_rig_make(&rig);
    assert_null(rig.engine);
    assert_non_null(strstr(rig.error.right, "; of the wire: clock_hz line_delay_ns compensate"));
}

static void *give_row(void *ctx, size_t index, void *settings, struct dg_keys *rows)
{
    static uint32_t value;
    static const struct dg_key row[] = {{"busy_us", "us", 0, DG_KEY_U32, 0, 1, 0, 9, NULL, ""}};

    (void)ctx;
    (void)index;
    (void)settings;
    *rows = (struct dg_keys){row, DG_COUNT(row)};
    return &value;
}

/* A host's row in the place of an encoder's is in the list once. */
static void a_row_of_the_host_is_listed_once(void **state)
{
    (void)state;
    engine_rig_read(&rig, CHAIN_OF "nonsense = 1\n");
    rig.setup.rows = give_row;
    engine_rig_make(&rig);
    assert_null(rig.engine);
    const char *found = strstr(rig.error.right, " busy_us");
    assert_non_null(found);
    assert_null(strstr(found + 1, " busy_us"));
    engine_rig_read(&rig, CHAIN_OF "busy_us = 10\n");
    rig.setup.rows = give_row;
    engine_rig_make(&rig);
    assert_null(rig.engine);
    assert_string_equal(rig.error.right, "expected a number in 0..9 us");
}

#define ROWS 33u

static void *give_many_rows(void *ctx, size_t index, void *settings, struct dg_keys *rows)
{
    static uint32_t values[ROWS];
    static char names[ROWS][8];
    static struct dg_key list[ROWS];

    (void)ctx;
    (void)index;
    (void)settings;
    for (size_t i = 0; i < ROWS; i++) {
        (void)snprintf(names[i], sizeof names[i], "port%zu", i);
        list[i] = (struct dg_key){.name = names[i],
                                  .unit = "",
                                  .offset = i * sizeof values[0],
                                  .type = DG_KEY_U32,
                                  .factor = 1,
                                  .max = 9,
                                  .help = ""};
    }
    *rows = (struct dg_keys){list, ROWS};
    return values;
}

static void a_host_may_have_many_rows(void **state)
{
    (void)state;
    engine_rig_read(&rig, CHAIN_OF "port0 = 1\nport32 = 1\n");
    rig.setup.rows = give_many_rows;
    engine_rig_make(&rig);
    assert_non_null(rig.engine);
    engine_rig_read(&rig, CHAIN_OF "port33 = 1\n");
    rig.setup.rows = give_many_rows;
    engine_rig_make(&rig);
    assert_null(rig.engine);
    assert_non_null(strstr(rig.error.right, " port32"));
}

static void a_serial_number_of_the_file_counts(void **state)
{
    char text[32];
    (void)state;
    engine_rig_start(&rig, NODE_OF "serial = 77\n");
    assert_true(dg_host_get(dg_engine_encoder(rig.engine, 0), "serial", text, sizeof text) > 0);
    assert_string_equal(text, "77");
}

/* ------------------------------------------------------------ courses */

static struct dg_course_point points[2];

static struct dg_rig_course *find_course(void *ctx, size_t index,
                                         const struct dg_plan_setting *setting,
                                         struct dg_plan_error *error)
{
    static struct dg_rig_course course;

    (void)ctx;
    (void)index;
    (void)setting;
    (void)error;
    course = (struct dg_rig_course){.course = {.points = points, .count = 2}};
    return &course;
}

static void read_course(const char *setting, const struct dg_course_point *last)
{
    char text[256];

    (void)snprintf(text, sizeof text, "%s%s\n", NODE_OF, setting);
    engine_rig_read(&rig, text);
    points[0] = (struct dg_course_point){0, 1};
    points[1] = *last;
    rig.setup.course = find_course;
}

/* A loop through a single moment would never get on. */
static void a_loop_of_no_time_is_refused(void **state)
{
    const struct dg_course_point at_once = {0, 2};
    (void)state;
    read_course("temperature = x.csv,loop", &at_once);
    engine_rig_make(&rig);
    assert_null(rig.engine);
    assert_string_equal(rig.error.what, "a loop needs a time above 0");
    assert_string_equal(rig.error.key, "temperature");
    assert_int_equal(rig.error.line, 7);
}

/* Nothing is half true: a state jumps where the point is. */
static void a_course_of_a_state_jumps(void **state)
{
    const struct dg_course_point good_then = {DG_S(10), 0};
    int64_t value = 0;
    (void)state;
    read_course("singleturn_ok = x.csv", &good_then);
    engine_rig_power(&rig);
    struct dg_host *host = dg_engine_encoder(rig.engine, 0);
    (void)dg_engine_step(rig.engine, DG_S(10));
    assert_int_equal(dg_host_world_get(host, "singleturn_ok", &value), DG_HOST_OK);
    assert_int_equal(value, 1);
    (void)dg_engine_step(rig.engine, DG_S(11));
    assert_int_equal(dg_host_world_get(host, "singleturn_ok", &value), DG_HOST_OK);
    assert_int_equal(value, 0);
}

/* ------------------------------------------------------------ hosts */

static void memory_that_is_none_is_refused(void **state)
{
    (void)state;
    engine_rig_read(&rig, LINE_OF);
    const size_t n = dg_engine_size(&rig.setup);
    assert_null(dg_engine_make(NULL, n, &rig.setup, &rig.error));
    assert_string_equal(rig.error.what, "no memory for a rig");
    assert_null(dg_engine_make(rig.memory + 1, n, &rig.setup, &rig.error));
    assert_string_equal(rig.error.what, "no memory for a rig");
}

static void a_setup_without_a_plan_or_encoders_is_refused(void **state)
{
    (void)state;
    engine_rig_read(&rig, LINE_OF);
    struct dg_plan_wire idle = rig.plan.wires[0];
    idle.stack = NULL;
    idle.encoder_count = 0;
    rig.plan.wires = &idle;
    assert_int_equal(dg_engine_size(&rig.setup), 0);
    rig.setup.plan = NULL;
    assert_int_equal(dg_engine_size(&rig.setup), 0);
    assert_null(dg_engine_make(rig.memory, sizeof rig.memory, &rig.setup, &rig.error));
    assert_string_equal(rig.error.what,
                        "no setup of this version, or a wire with no encoders or too many");
}

static int want_a_long_cable(void *ctx, size_t index, struct dg_engine_wire *to,
                             struct dg_plan_error *error)
{
    (void)ctx;
    (void)index;
    (void)error;
    to->edges.there_ns = UINT32_MAX;
    return 0;
}

static void a_bus_that_the_host_wants_otherwise_is_refused(void **state)
{
    (void)state;
    engine_rig_read(&rig, CHAIN_OF);
    rig.setup.wire = want_a_long_cable;
    engine_rig_make(&rig);
    assert_null(rig.engine);
    assert_string_equal(rig.error.what, "[bus c]: the host has no such bus");
    assert_int_equal(rig.error.line, 1);
}

/* What was right when the rig was made may be changed up to the power. */
static void figures_that_make_no_encoder_are_refused_at_the_power(void **state)
{
    (void)state;
    engine_rig_read(&rig, CHAIN_OF);
    engine_rig_make(&rig);
    struct dg_host *host = dg_engine_encoder(rig.engine, 0);
    assert_int_equal(dg_host_set(host, "busy_us", "40"), DG_HOST_OK);
    assert_int_equal(dg_host_set(host, "busy_jitter_us", "40"), DG_HOST_OK);
    assert_int_equal(dg_engine_power(rig.engine, ENGINE_RIG_ON, &rig.error), DG_ERR_ARGUMENT);
    assert_string_equal(rig.error.what, "these figures make no encoder");
    assert_int_equal(rig.error.line, 3);
}

/* One that answers at once makes the line one without times, whoever else is on it. */
static void a_line_is_paced_when_all_on_it_are(void **state)
{
    (void)state;
    engine_rig_start(&rig, "[bus rs]\nwire = pty\n"
                           "[encoder a]\nmodel = s3684-rs485\nbus = rs\npace = 0\n"
                           "[encoder b]\nmodel = s3684-rs485\nbus = rs\naddress = 0x41\n");
    assert_false(dg_engine_wire_of(rig.engine, 0)->characters.paced);
    engine_rig_start(&rig, LINE_OF);
    assert_true(dg_engine_wire_of(rig.engine, 0)->characters.paced);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_setting_is_refused_with_what_is_right),
        cmocka_unit_test(a_key_that_nobody_has_gets_those_of_the_wire),
        cmocka_unit_test(a_row_of_the_host_is_listed_once),
        cmocka_unit_test(a_host_may_have_many_rows),
        cmocka_unit_test(a_serial_number_of_the_file_counts),
        cmocka_unit_test(a_loop_of_no_time_is_refused),
        cmocka_unit_test(a_course_of_a_state_jumps),
        cmocka_unit_test(memory_that_is_none_is_refused),
        cmocka_unit_test(a_setup_without_a_plan_or_encoders_is_refused),
        cmocka_unit_test(a_bus_that_the_host_wants_otherwise_is_refused),
        cmocka_unit_test(figures_that_make_no_encoder_are_refused_at_the_power),
        cmocka_unit_test(a_line_is_paced_when_all_on_it_are),
    };
    return cmocka_run_group_tests_name("engine_refusals", tests, NULL, NULL);
}
