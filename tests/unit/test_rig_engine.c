/* SPDX-License-Identifier: MIT */
/* A rig at work, made of a text: what it is made of, what it refuses, and what its host and its
   control plane do with it. That it says what the command says is differential.wires.engine's. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/hal.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/instruments.h"
#include "drehgeber/rig_engine.h"

#define PLAN_SIZE 65536u
#define RIG_SIZE ((size_t)1u << 20u)
#define GUARD 64u
#define HEARD_MAX 64u

struct bench {
    _Alignas(16) unsigned char plan_memory[PLAN_SIZE];
    _Alignas(16) unsigned char memory[RIG_SIZE + GUARD];
    struct dg_plan plan;
    struct dg_engine_setup setup;
    struct dg_engine *engine;
    struct dg_plan_error error;
    struct dg_tap_event heard[HEARD_MAX];
    size_t heard_count;
    struct dg_control client;
    char answer[512];
    unsigned woken;
};
static struct bench bench;

static void keep_event(void *ctx, size_t place, const struct dg_tap_event *event)
{
    struct bench *self = ctx;

    (void)place;
    assert_true(self->heard_count < HEARD_MAX);
    self->heard[self->heard_count++] = *event;
}

static const struct dg_bus_ops door = {.tx = keep_event};

static int open_door(void *ctx, size_t index, struct dg_engine_wire *to,
                     struct dg_plan_error *error)
{
    (void)index;
    to->ops = &door;
    to->ctx = ctx;
    (void)error;
    return 0;
}

static void note_waking(void *ctx)
{
    struct bench *self = ctx;

    self->woken++;
}

/* Any file is an encoder of 3600 steps. */
static const char *fetch(void *ctx, const char *path, struct dg_plan_text *to)
{
    static const char text[] = "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x10196\n"
                               "[6004]\nDataType=7\nAccessType=ro\n"
                               "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=3600\n";

    (void)ctx;
    (void)path;
    *to = (struct dg_plan_text){text, sizeof text - 1u};
    return NULL;
}

static void read_plan(const char *text)
{
    const struct dg_plan_setup setup = {
        .size = sizeof setup,
        .file = "bench.ini",
        .text = {text, strlen(text)},
        .memory = bench.plan_memory,
        .memory_size = sizeof bench.plan_memory,
        .include = fetch,
    };

    if (dg_plan_read(&bench.plan, &setup, &bench.error) != DG_OK) {
        fail_msg("%u: %s: %s; %s", bench.error.line, bench.error.key, bench.error.what,
                 bench.error.right);
    }
    bench.heard_count = 0;
    bench.setup = (struct dg_engine_setup){
        .size = sizeof bench.setup,
        .plan = &bench.plan,
        .begin = DG_S(1),
        .instruments = dg_instruments,
        .instrument_count = dg_instrument_count,
        .wire = open_door,
        .woken = note_waking,
        .ctx = &bench,
    };
}

static void make_in(size_t size)
{
    memset(bench.memory, 0xA5, sizeof bench.memory);
    bench.engine = dg_engine_make(bench.memory, size, &bench.setup, &bench.error);
    for (size_t i = size; i < sizeof bench.memory; i++) {
        assert_int_equal(bench.memory[i], 0xA5);
    }
}

static void make(const char *text)
{
    read_plan(text);
    make_in(dg_engine_size(&bench.setup));
    if (bench.engine == NULL) {
        fail_msg("%u: %s: %s; %s", bench.error.line, bench.error.key, bench.error.what,
                 bench.error.right);
    }
}

static void switch_on(const char *text)
{
    make(text);
    if (dg_engine_power(bench.engine, DG_S(1), &bench.error) != DG_OK) {
        fail_msg("%u: %s: %s", bench.error.line, bench.error.key, bench.error.what);
    }
}

/* ------------------------------------------------------------ SCPI */

static void collect(void *ctx, const char *bytes, size_t n)
{
    struct bench *self = ctx;

    (void)strncat(self->answer, bytes, n);
}

static const char *ask(dg_ns now, const char *line)
{
    bench.answer[0] = '\0';
    (void)dg_control_rx(&bench.client, now, line, strlen(line));
    (void)dg_control_rx(&bench.client, now, "\n", 1);
    return bench.answer;
}

static void assert_refused(dg_ns now, const char *line, const char *code)
{
    assert_string_equal(ask(now, line), "");
    assert_int_equal(strncmp(ask(now, "SYST:ERR?"), code, strlen(code)), 0);
}

static void connect_client(void)
{
    dg_control_init(&bench.client, dg_engine_control(bench.engine), collect, &bench);
}

/* ------------------------------------------------------------ what it is made of */

static const char mixed[] = "[shaft motor]\nmotion = 60RPM\n"
                            "[shaft load]\ndriver = motor\nratio = 1:4\n"
                            "[bus rs]\nwire = pty\n"
                            "[bus vcan]\nwire = can\naddress = vcan0\n"
                            "[bus chain]\nwire = sim\nline_delay_ns = 100\n"
                            "[bus loop]\nwire = modbus\n"
                            "[encoder a]\nmodel = s3684-rs485\nbus = rs\naddress = 0x41\n"
                            "[encoder n]\nmodel = f3668\nbus = vcan\nnode = 1..3\nshaft = load\n"
                            "[encoder b]\nmodel = s3684-biss\nbus = chain\n"
                            "[encoder b2]\nmodel = s3684-biss\nbus = chain\ntemperature = 85\n"
                            "[encoder k]\nmodel = ocd-ib-k2\nbus = loop\n"
                            "[encoder k2]\nmodel = ocd-ib-k3\nbus = loop\n"
                            "[encoder a2]\nmodel = s3684-rs485\nbus = rs\npace = 0\n";

static void memory_is_as_much_as_it_says(void **state)
{
    (void)state;
    read_plan(mixed);
    const size_t n = dg_engine_size(&bench.setup);
    make_in(n - 1u);
    assert_null(bench.engine);
    assert_string_equal(bench.error.what, "no memory for a rig");
    make_in(n);
    assert_non_null(bench.engine);
    bench.setup.size--;
    assert_int_equal(dg_engine_size(&bench.setup), 0);
    make_in(n);
    assert_null(bench.engine);
}

static void parts_are_those_of_the_plan(void **state)
{
    static const size_t places[] = {0, 0, 1, 2, 0, 1, 0, 1, 1};
    (void)state;
    switch_on(mixed);
    for (size_t i = 0; i < bench.plan.encoder_count; i++) {
        struct dg_host *host = dg_engine_encoder(bench.engine, i);
        const size_t place = dg_engine_place(bench.engine, i);
        assert_int_equal(place, places[i]);
        assert_ptr_equal(
            dg_bus_encoder(dg_engine_bus(bench.engine, bench.plan.encoders[i].wire), place), host);
        assert_true(dg_host_powered(host));
        assert_string_equal(dg_host_model(host), bench.plan.encoders[i].model->name);
    }
    assert_int_equal(dg_engine_wire_of(bench.engine, 2)->edges.there_ns, 100);
    assert_false(dg_engine_wire_of(bench.engine, 0)->characters.paced);
    assert_int_equal(dg_engine_control(bench.engine)->encoder_count, bench.plan.encoder_count);
    assert_true(dg_engine_end_of(bench.engine, 0).pace);
    assert_false(dg_engine_end_of(bench.engine, 8).pace);
}

static void what_clients_see_has_the_order_of_the_plan(void **state)
{
    (void)state;
    make(mixed);
    const struct dg_rig *control = dg_engine_control(bench.engine);
    for (size_t i = 0; i < control->encoder_count; i++) {
        assert_int_equal(dg_engine_index(control, control->encoders[i]), i);
        assert_string_equal(control->encoders[i]->name, bench.plan.encoders[i].name);
    }
    for (size_t i = 0; i < control->shaft_count; i++) {
        assert_int_equal(dg_engine_shaft_index(control, control->shafts[i]), i);
    }
}

static void settings_addresses_and_numbers(void **state)
{
    char text[32];
    int64_t value = 0;
    (void)state;
    make(mixed);
    assert_true(dg_host_get(dg_engine_encoder(bench.engine, 0), "address", text, sizeof text) > 0);
    assert_string_equal(text, "65");
    assert_true(dg_host_get(dg_engine_encoder(bench.engine, 3), "node", text, sizeof text) > 0);
    assert_string_equal(text, "3");
    /* Serial numbers count up on a bus whose master asks for them. */
    char first[32];
    assert_true(dg_host_get(dg_engine_encoder(bench.engine, 1), "serial", first, sizeof first) > 0);
    assert_true(dg_host_get(dg_engine_encoder(bench.engine, 3), "serial", text, sizeof text) > 0);
    assert_int_equal(strtoul(text, NULL, 10), strtoul(first, NULL, 10) + 2u);
    assert_int_equal(dg_host_world_get(dg_engine_encoder(bench.engine, 5), "temperature", &value),
                     DG_HOST_OK);
    assert_int_equal(value, 85000);
}

/* Two seconds at 60 rpm are two turns, behind the gear half a one. */
static void shafts_turn_from_the_beginning(void **state)
{
    (void)state;
    switch_on(mixed);
    const dg_ns end = DG_S(3);
    assert_int_equal(dg_host_angle(dg_engine_encoder(bench.engine, 0), end), 2 * DG_TURN);
    assert_int_equal(dg_host_angle(dg_engine_encoder(bench.engine, 1), end), DG_TURN / 2);
    assert_int_equal(dg_host_angle(dg_engine_encoder(bench.engine, 0), 0), 0);
}

/* ------------------------------------------------------------ what it refuses */

#define LINE_OF "[bus rs]\nwire = pty\n[encoder a]\nbus = rs\nmodel = s3684-rs485\n"
#define BUS_OF "[bus vcan]\nwire = can\naddress = vcan0\n[encoder n]\nbus = vcan\nmodel = f3668\n"
#define CHAIN_OF "[bus c]\nwire = sim\n[encoder b]\nbus = c\nmodel = s3684-biss\n"

static const struct {
    const char *text;
    unsigned line;
    const char *key;
    const char *value; /* NULL: none is told */
    const char *what;
    const char *right;
} wrong[] = {
    {BUS_OF "nonsense = 1\n", 7, "nonsense", NULL, "no such key", NULL},
    {BUS_OF "mt_bits = 13\n", 7, "mt_bits", "13", "", "expected 12 or 16"},
    {BUS_OF "temperature = 2000\n", 7, "temperature", "2000", "",
     "expected a number in -273..1000 degC with at most 3 decimals"},
    {BUS_OF "singleturn_ok = 2\n", 7, "singleturn_ok", "2", "", "expected 0 or 1"},
    {BUS_OF "temperature = x.csv,AGAIN\n", 7, "temperature", "x.csv,AGAIN", NULL, NULL},
    {"[bus vcan]\nwire = can\naddress = vcan0\npace = 2\n[encoder n]\nbus = vcan\nmodel = f3668\n",
     4, "pace", "2", "", "expected 0 or 1"},
    {LINE_OF "pace = 2\n", 6, "pace", "2", "", "expected 0 or 1"},
    {LINE_OF "serial = 1234567890\n", 6, "serial", "1234567890", "", "expected 1 to 9 digits"},
    {CHAIN_OF "tear = 1\n", 6, "tear", "1", "only a modbus wire has it", "leave it out"},
    {CHAIN_OF "busy_us = 40\nbusy_jitter_us = 40\n", 3, "", NULL, "these figures make no encoder",
     ""},
    {"[bus c]\nwire = sim\n[encoder b]\nbus = c\nmodel = ssi-25\n[encoder d]\nbus = c\nmodel = ssi-25\n",
     6, "", NULL, "this wire is full: expected at most 1 encoders", ""},
    {"[bus c]\nwire = sim\n[encoder b]\nbus = c\nmodel = ssi-25\nnvm = x\n", 6, "nvm", NULL,
     "ssi-25 has no EEPROM", "leave it out"},
    {"[shaft s]\nmotion = x.csv\n" CHAIN_OF, 2, "motion", NULL, "x.csv: there are no files here",
     "expected a motion in words"},
};

static void what_is_wrong_is_told_with_its_place(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(wrong); i++) {
        read_plan(wrong[i].text);
        make_in(dg_engine_size(&bench.setup));
        const struct dg_plan_error *error = &bench.error;
        assert_null(bench.engine);
        assert_string_equal(error->key, wrong[i].key);
        assert_int_equal(error->line, wrong[i].line);
        assert_string_equal(error->file, "bench.ini");
        assert_int_equal(error->valued != DG_PLAN_UNVALUED, wrong[i].value != NULL);
        assert_string_equal(error->value, wrong[i].value != NULL ? wrong[i].value : "");
        if (wrong[i].what != NULL) {
            assert_string_equal(error->what, wrong[i].what);
        }
        if (wrong[i].right != NULL) {
            assert_string_equal(error->right, wrong[i].right);
        }
        assert_true(error->what[0] != '\0' || error->right[0] != '\0');
    }
}

static void a_name_that_nobody_has_gets_the_list(void **state)
{
    (void)state;
    read_plan(BUS_OF "nonsense = 1\n");
    make_in(dg_engine_size(&bench.setup));
    const char *right = bench.error.right;
    assert_non_null(strstr(right, "valid:"));
    assert_non_null(strstr(right, " temperature"));
    assert_non_null(strstr(right, "; of the wire: pace"));
    assert_null(strstr(right, " serial"));
    assert_null(strstr(right, " node"));
}

/* ------------------------------------------------------------ rows and checks of the host */

struct host_settings {
    uint32_t interval;
};
static struct host_settings of_host;

static void *give_rows(void *ctx, size_t index, void *settings, struct dg_keys *rows)
{
    static const struct dg_key row = {"sincos_us", "us", 0, DG_KEY_U32, 0, 1, 0, 9, NULL, ""};

    (void)ctx;
    (void)index;
    (void)settings;
    *rows = (struct dg_keys){&row, 1};
    return &of_host;
}

static int refuse_all(void *ctx, size_t index, const void *settings, struct dg_plan_error *error)
{
    (void)ctx;
    (void)index;
    (void)settings;
    (void)snprintf(error->what, sizeof error->what, "not here");
    error->line = 0;
    return -1;
}

static void the_host_has_rows_of_its_own(void **state)
{
    (void)state;
    read_plan(LINE_OF "sincos_us = 7\n");
    make_in(dg_engine_size(&bench.setup));
    assert_null(bench.engine);
    bench.setup.rows = give_rows;
    make_in(dg_engine_size(&bench.setup));
    assert_non_null(bench.engine);
    assert_int_equal(of_host.interval, 7);
    bench.setup.check = refuse_all;
    make_in(dg_engine_size(&bench.setup));
    assert_null(bench.engine);
    assert_string_equal(bench.error.what, "not here");
    assert_int_equal(bench.error.line, 3);
}

/* ------------------------------------------------------------ files of the host */

static struct dg_course_point course_points[] = {{0, 20000}, {DG_S(10), 30000}};
static const struct dg_motion_point motion_points[] = {{0, 0}, {DG_S(1), DG_TURN}};

static struct dg_rig_course *find_course(void *ctx, size_t index,
                                         const struct dg_plan_setting *setting,
                                         struct dg_plan_error *error)
{
    static struct dg_rig_course course;

    (void)ctx;
    assert_int_equal(index, 0);
    if (strcmp(setting->value, "none.csv") == 0) {
        memset(error, 0, sizeof *error);
        (void)snprintf(error->what, sizeof error->what, "cannot open");
        return NULL;
    }
    course = (struct dg_rig_course){.course = {.points = course_points, .count = 2}};
    return &course;
}

static int find_motion(void *ctx, size_t index, const char *path, struct dg_motion *to,
                       struct dg_plan_error *error)
{
    (void)ctx;
    (void)index;
    (void)error;
    assert_string_equal(path, "turn.csv");
    *to = (struct dg_motion){.kind = DG_MOTION_REPLAY, .points = motion_points, .point_count = 2};
    return 0;
}

static void files_are_the_hosts(void **state)
{
    int64_t value = 0;
    (void)state;
    read_plan("[shaft s]\nmotion = turn.csv\n" BUS_OF "temperature = warm.csv,STEP\n");
    bench.setup.motion = find_motion;
    make_in(dg_engine_size(&bench.setup));
    assert_null(bench.engine);
    assert_string_equal(bench.error.what, "there are no files here");
    assert_int_equal(bench.error.valued, DG_PLAN_SETTING);
    bench.setup.course = find_course;
    make_in(dg_engine_size(&bench.setup));
    assert_non_null(bench.engine);
    assert_int_equal(dg_engine_power(bench.engine, DG_S(1), &bench.error), DG_OK);
    struct dg_host *host = dg_engine_encoder(bench.engine, 0);
    assert_int_equal(dg_host_angle(host, DG_S(1) + DG_MS(500)), DG_TURN / 2);
    (void)dg_engine_step(bench.engine, DG_S(10));
    assert_int_equal(dg_host_world_get(host, "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 20000);
    (void)dg_engine_step(bench.engine, DG_S(11));
    assert_int_equal(dg_host_world_get(host, "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 30000);
}

static void what_is_wrong_with_a_file_is_told_with_its_place(void **state)
{
    (void)state;
    read_plan(BUS_OF "temperature = none.csv\n");
    bench.setup.course = find_course;
    make_in(dg_engine_size(&bench.setup));
    assert_null(bench.engine);
    assert_string_equal(bench.error.what, "cannot open");
    assert_string_equal(bench.error.value, "none.csv");
    assert_int_equal(bench.error.line, 7);
}

/* ------------------------------------------------------------ EEPROMs */

static void an_eeprom_may_be_there_before_the_power(void **state)
{
    static unsigned char image[16384];
    (void)state;
    switch_on(LINE_OF "address = 0x52\n");
    const size_t n = dg_host_memory_size(dg_engine_encoder(bench.engine, 0));
    assert_true(n > 0 && n <= sizeof image);
    assert_int_equal(dg_host_memory_copy(dg_engine_encoder(bench.engine, 0), image, n), DG_HOST_OK);
    make(LINE_OF);
    struct dg_host *host = dg_engine_encoder(bench.engine, 0);
    assert_int_equal(dg_host_memory_load(host, image, n), DG_HOST_OK);
    assert_int_equal(dg_engine_power(bench.engine, DG_S(1), &bench.error), DG_OK);
    assert_int_equal(dg_host_side_at(host)->address(dg_host_line_of(host)), 0x52);
    /* Something else is none. */
    make(LINE_OF "nvm = it.nvm\n");
    memset(image, 0x5A, n);
    assert_int_equal(dg_host_memory_load(dg_engine_encoder(bench.engine, 0), image, n), DG_HOST_OK);
    assert_int_equal(dg_engine_power(bench.engine, DG_S(1), &bench.error), DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.key, "nvm");
    assert_int_equal(bench.error.line, 6);
    assert_string_equal(bench.error.what, "the encoder does not start: not its EEPROM");
}

static void a_host_with_eeproms_needs_less(void **state)
{
    (void)state;
    make(mixed);
    const size_t n = dg_engine_size(&bench.setup);
    size_t memories = 0;
    for (size_t i = 0; i < bench.plan.encoder_count; i++) {
        memories += dg_host_memory_size(dg_engine_encoder(bench.engine, i));
    }
    bench.setup.memory_is_host = true;
    assert_true(dg_engine_size(&bench.setup) <= n - memories);
    make_in(dg_engine_size(&bench.setup));
    assert_non_null(bench.engine);
    assert_int_equal(dg_engine_power(bench.engine, DG_S(1), &bench.error), DG_ERR_ARGUMENT);
}

/* ------------------------------------------------------------ time */

static void wires_and_time(void **state)
{
    static const uint8_t request[] = {0x40, 0x42, 0x02};
    (void)state;
    switch_on(LINE_OF "address = 0x40\n");
    (void)dg_engine_step(bench.engine, DG_S(2));
    for (size_t i = 0; i < sizeof request; i++) {
        const struct dg_tap_event event = {
            .at = DG_S(2),
            .kind = DG_TAP_CHARACTER,
            .character = {DG_BAUD_ANY, 'E', request[i], false},
        };
        (void)dg_bus_rx(dg_engine_bus(bench.engine, 0), &event);
    }
    while (dg_engine_next(bench.engine) != DG_NEVER) {
        const dg_ns next = dg_engine_next(bench.engine);
        assert_true(dg_engine_step(bench.engine, next) > next);
    }
    assert_int_equal(bench.heard_count, 7);
    assert_int_equal(bench.heard[0].character.byte, 0x40);
    assert_int_equal(bench.heard[1].character.byte, 0x42);
}

static void say_to(size_t bus, dg_ns at, uint16_t id)
{
    const struct dg_tap_event event = {.at = at, .kind = DG_TAP_FRAME, .frame = {.id = id}};

    (void)dg_bus_rx(dg_engine_bus(bench.engine, bus), &event);
}

/* A node says that it is there, at the moment at which it is. */
static void nodes_boot_with_the_power(void **state)
{
    (void)state;
    switch_on(BUS_OF "node = 9\n");
    for (dg_ns at = DG_S(1); at < DG_S(5) && bench.heard_count == 0;) {
        const dg_ns next = dg_engine_step(bench.engine, at);
        assert_true(next > at);
        at = next;
    }
    assert_int_equal(bench.heard[0].frame.id, 0x709);
}

/* Ack, behind the second rising edge: the bus knows that its encoder is on. */
static void a_chain_answers_from_the_power_on(void **state)
{
    (void)state;
    switch_on(CHAIN_OF);
    (void)dg_engine_step(bench.engine, DG_S(3));
    struct dg_bus *bus = dg_engine_bus(bench.engine, 0);
    for (unsigned i = 1; i <= 4u; i++) {
        const bool high = dg_bus_edge(bus, DG_S(3) + i * DG_US(1), i % 2u == 0);
        assert_int_equal(high, i == 2u || i == 3u);
    }
}

/* Nobody looks at a shaft that stands, and everybody when it turns. */
static void encoders_sleep_while_their_shaft_stands(void **state)
{
    (void)state;
    switch_on("[shaft s]\n[shaft load]\ndriver = s\n" BUS_OF "shaft = load\n");
    connect_client();
    say_to(0, DG_S(3), 0); /* too short for NMT: nothing */
    assert_true(dg_engine_step(bench.engine, DG_S(4)) > DG_S(5));
    dg_engine_control(bench.engine)->encoders[0]->shaft =
        dg_engine_control(bench.engine)->shafts[0];
    assert_string_equal(ask(DG_S(4), "SHAF:VEL 100RPM"), "");
    assert_true(dg_engine_next(bench.engine) < DG_S(5));
}

static void a_ring_is_cut_where_the_plan_says(void **state)
{
    static const uint16_t out[8];
    (void)state;
    switch_on(
        "[bus loop]\nwire = modbus\nbreak_at = 1\n[encoder a]\nmodel = ocd-ib-k2\nbus = loop\n"
        "[encoder b]\nmodel = ocd-ib-k2\nbus = loop\n");
    (void)dg_engine_step(bench.engine, DG_S(3));
    struct dg_bus *bus = dg_engine_bus(bench.engine, 0);
    const struct dg_tap_event event = {
        .at = DG_S(3), .kind = DG_TAP_WORDS, .words = {.out = out, .count = 4, .identify = true}};
    (void)dg_bus_rx(bus, &event);
    assert_int_equal(dg_ring_state(bus)->reached, 1);
}

/* ------------------------------------------------------------ control plane */

static void clients_work_on_it(void **state)
{
    (void)state;
    switch_on(mixed);
    connect_client();
    (void)dg_engine_step(bench.engine, DG_S(2));
    assert_string_equal(ask(DG_S(2), "INST:SEL n-2;:POW?"), "1\n");
    assert_string_equal(ask(DG_S(2), "INST:WIRE?"), "\"can:vcan0/2\"\n");
    assert_non_null(strstr(ask(DG_S(2), "STAT?"), "wire_kbaud="));
    assert_string_equal(ask(DG_S(2), "INST:SEL a;:SHAF:PROF \"0\";PROF?;PROF \"45.123456789DEG\""),
                        "\"0\"\n");
    assert_int_equal(dg_host_angle(dg_engine_encoder(bench.engine, 0), DG_S(3)), 538343809);
    assert_string_equal(ask(DG_S(2), "SHAF:PROF \"90DEG\";PROF?"), "\"90DEG\"\n");
    assert_int_equal(dg_host_angle(dg_engine_encoder(bench.engine, 1), DG_S(3)), DG_TURN / 16);
    assert_refused(DG_S(2), "SHAF:PROF \"x.csv\"", "-256");
    assert_refused(DG_S(2), "SHAF:PROF \"5KM\"", "-224");
    assert_refused(DG_S(2), "INST:SEL n-1;:SHAF:PROF \"0\"", "-221");
    const unsigned before = bench.woken;
    assert_string_equal(ask(DG_S(2), "INST:SEL b;:POW OFF;:POW?"), "0\n");
    assert_true(bench.woken > before);
    assert_false(dg_host_powered(dg_engine_encoder(bench.engine, 4)));
}

/* In one big step a fault ends when it should, not when somebody comes. */
static void faults_end_at_their_own_moment(void **state)
{
    int64_t value = 0;
    (void)state;
    switch_on(mixed);
    connect_client();
    (void)dg_engine_step(bench.engine, DG_S(2));
    assert_string_equal(ask(DG_S(2), "INST:SEL n-1;:FAUL:SET temperature_high,DUR 5S;:FAUL:ACT?"),
                        "\"temperature_high\"\n");
    assert_true(dg_engine_next(bench.engine) <= DG_S(7));
    (void)dg_engine_step(bench.engine, DG_S(6));
    assert_string_equal(ask(DG_S(6), "FAUL:ACT?"), "\"temperature_high\"\n");
    (void)dg_engine_step(bench.engine, DG_S(20));
    assert_string_equal(ask(DG_S(20), "FAUL:ACT?"), "\"\"\n");
    assert_int_equal(dg_host_world_get(dg_engine_encoder(bench.engine, 1), "temperature", &value),
                     DG_HOST_OK);
    assert_int_equal(value, 37000);
}

static void the_host_may_do_some_of_it(void **state)
{
    struct dg_rig_ops ops = dg_engine_ops;
    (void)state;
    read_plan(mixed);
    ops.profile = NULL;
    bench.setup.ops = &ops;
    make_in(dg_engine_size(&bench.setup));
    assert_int_equal(dg_engine_power(bench.engine, DG_S(1), &bench.error), DG_OK);
    connect_client();
    assert_refused(DG_S(2), "SHAF:PROF \"0\"", "-241");
    assert_ptr_equal(dg_engine_ctx(dg_engine_control(bench.engine)), &bench);
}

/* What a node costs, all told: a rig of thousands has to fit. */
static void a_node_is_small(void **state)
{
    (void)state;
    read_plan("[bus vcan]\nwire = can\naddress = vcan0\n[encoder n]\nbus = vcan\nmodel = f3668\n"
              "node = 1..10\n");
    const size_t ten = dg_engine_size(&bench.setup);
    read_plan("[bus vcan]\nwire = can\naddress = vcan0\n[encoder n]\nbus = vcan\nmodel = f3668\n"
              "node = 1..110\n");
    bench.setup.memory_is_host = false;
    assert_true((dg_engine_size(&bench.setup) - ten) / 100u <= 6u * 1024u);
}

/* Its model is made of a file, in the memory of the plan. */
static void an_encoder_of_an_eds_file(void **state)
{
    (void)state;
    switch_on("[shaft s]\nmotion = 90DEG\n[bus b]\nwire = slcan\n"
              "[encoder a]\nmodel = vendor.eds\nbus = b\nnode = 1..2\n");
    for (uint16_t node = 1; node <= 2; node++) {
        const struct dg_tap_event request = {
            .at = DG_S(2),
            .kind = DG_TAP_FRAME,
            .frame = {.id = (uint16_t)(0x600u + node), .dlc = 8, .data = {0x40, 0x04, 0x60}},
        };
        bench.heard_count = 0;
        (void)dg_bus_rx(dg_engine_bus(bench.engine, 0), &request);
        (void)dg_engine_step(bench.engine, DG_S(2) + DG_MS(1));
        const struct dg_tap_event *answer = NULL;
        for (size_t i = 0; i < bench.heard_count; i++) {
            const bool own = bench.heard[i].frame.id == 0x580u + node;
            answer = own ? &bench.heard[i] : answer;
        }
        assert_non_null(answer);
        assert_int_equal(answer->frame.data[4] | answer->frame.data[5] << 8, 900);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_encoder_of_an_eds_file),
        cmocka_unit_test(memory_is_as_much_as_it_says),
        cmocka_unit_test(parts_are_those_of_the_plan),
        cmocka_unit_test(what_clients_see_has_the_order_of_the_plan),
        cmocka_unit_test(settings_addresses_and_numbers),
        cmocka_unit_test(shafts_turn_from_the_beginning),
        cmocka_unit_test(what_is_wrong_is_told_with_its_place),
        cmocka_unit_test(a_name_that_nobody_has_gets_the_list),
        cmocka_unit_test(the_host_has_rows_of_its_own),
        cmocka_unit_test(files_are_the_hosts),
        cmocka_unit_test(what_is_wrong_with_a_file_is_told_with_its_place),
        cmocka_unit_test(an_eeprom_may_be_there_before_the_power),
        cmocka_unit_test(a_host_with_eeproms_needs_less),
        cmocka_unit_test(wires_and_time),
        cmocka_unit_test(nodes_boot_with_the_power),
        cmocka_unit_test(a_chain_answers_from_the_power_on),
        cmocka_unit_test(encoders_sleep_while_their_shaft_stands),
        cmocka_unit_test(a_ring_is_cut_where_the_plan_says),
        cmocka_unit_test(clients_work_on_it),
        cmocka_unit_test(faults_end_at_their_own_moment),
        cmocka_unit_test(the_host_may_do_some_of_it),
        cmocka_unit_test(a_node_is_small),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
