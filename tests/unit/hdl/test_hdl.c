/* SPDX-License-Identifier: MIT */
/*
 * An encoder for simulators, without one: delays, seeds, characters bit by bit, what is refused.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "hdl.h"
#include "hdl_names.h"

#define NS INT64_C(1000)
#define US INT64_C(1000000)
#define CHANGES 4000u

/* --- a simulator: the loop that each model has --- */

struct sim {
    struct dg_hdl *encoder;
    int64_t now;
    int inputs;
    int outputs;
    int64_t hinted; /* when there was something to tell */
    unsigned hints;
    size_t count;
    int64_t at[CHANGES];
    int levels[CHANGES];
};

static void look_at_wires(struct sim *self)
{
    int outputs = dg_hdl_wires(self->encoder, self->now, self->inputs);

    assert_int_equal((outputs & DG_HDL_HINT) != 0, dg_hdl_hint(self->encoder, 0)[0] != '\0');
    if ((outputs & DG_HDL_HINT) != 0) {
        self->hints++;
        self->hinted = self->now;
        outputs &= ~DG_HDL_HINT;
    }
    if (outputs != self->outputs) {
        assert_true(self->count < CHANGES);
        self->at[self->count] = self->now;
        self->levels[self->count++] = outputs;
    }
    self->outputs = outputs;
}

static void wait_until(struct sim *self, int64_t until)
{
    int64_t next = dg_hdl_next(self->encoder);

    while (next != DG_HDL_NEVER && next <= until) {
        assert_true(next > self->now);
        self->now = next;
        look_at_wires(self);
        next = dg_hdl_next(self->encoder);
    }
    self->now = until;
    look_at_wires(self);
}

static void begin_with(struct sim *self, const char *model, const char *settings)
{
    memset(self, 0, sizeof *self);
    self->encoder = dg_hdl_open(model, settings, "90DEG", "");
    assert_non_null(self->encoder);
    assert_string_equal(dg_hdl_error(self->encoder), "");
    self->inputs = DG_HDL_CLOCK;
    self->outputs = -1;
    look_at_wires(self);
    wait_until(self, NS); /* power */
    self->now = 0;
    self->count = 0;
}

static void set(struct sim *self, int inputs)
{
    self->inputs = inputs;
    look_at_wires(self);
}

static void clock_frame(struct sim *self, unsigned clocks, int64_t period)
{
    for (unsigned i = 0; i < clocks; i++) {
        wait_until(self, self->now + period / 2);
        set(self, 0);
        wait_until(self, self->now + period / 2);
        set(self, DG_HDL_CLOCK);
    }
    wait_until(self, self->now + 20 * US);
}

/* --- delays --- */

static void the_output_follows_by_the_delays(void **state)
{
    struct sim sim;

    (void)state;
    begin_with(&sim, "s3684-biss", "tco_ns=7.25 delay_in_ns=12.5 delay_out_ns=100");
    clock_frame(&sim, 1, US);
    assert_int_equal(sim.at[0], US + 12500 + 7250 + 100000);
    assert_int_equal(sim.levels[0], DG_HDL_DATA);
    assert_int_equal(dg_hdl_latched(sim.encoder), 1 << 19);
    dg_hdl_close(sim.encoder);
}

/* --- power --- */

/* What the input does at these moments, from 0 on. */
struct beginning {
    const char *model;
    const char *settings;
    int64_t at[3];
    int levels[3];
    bool latches;
};

static void play_beginning(const struct beginning *row)
{
    struct sim sim = {.outputs = -1};

    sim.encoder = dg_hdl_open(row->model, row->settings, "90DEG", "");
    for (size_t i = 0; i < 3; i++) {
        while (dg_hdl_next(sim.encoder) != DG_HDL_NEVER && dg_hdl_next(sim.encoder) < row->at[i]) {
            sim.now = dg_hdl_next(sim.encoder);
            look_at_wires(&sim);
        }
        sim.now = row->at[i];
        set(&sim, row->levels[i]);
    }
    wait_until(&sim, sim.now + US);
    assert_int_equal(dg_hdl_latched(sim.encoder) >= 0, row->latches);
    dg_hdl_close(sim.encoder);
}

/* BiSS latches with a rising edge, SSI with a falling one. */
static void what_registers_do_before_power_on_is_no_edge(void **state)
{
    static const struct beginning rows[] = {
        {"s3684-biss", "", {0, 0, 0}, {0, 1, 1}, false},
        {"s3684-biss", "", {0, 5 * NS, 9 * NS}, {0, 1, 1}, false},
        {"s3684-biss", "", {0, NS, 9 * NS}, {0, 1, 1}, false},
        {"s3684-biss", "", {0, NS / 2, NS}, {1, 0, 1}, false},
        {"s3684-biss", "", {0, 5 * NS, 9 * NS}, {1, 0, 1}, true},
        {"s3684-biss", "", {0, NS, 9 * NS}, {1, 0, 1}, true},
        {"s3684-biss", "power_on_ns=7", {0, 5 * NS, 9 * NS}, {1, 0, 1}, false},
        {"s3684-biss", "delay_in_ns=100", {0, 5 * NS, 9 * NS}, {0, 1, 1}, false},
        {"s3684-biss", "delay_in_ns=100", {0, 5 * NS, 9 * NS}, {1, 0, 1}, true},
        {"ssi-25", "", {0, 0, 0}, {0, 1, 1}, false},
        {"ssi-25", "", {0, 0, 5 * NS}, {1, 0, 0}, false},
        {"ssi-25", "", {0, 5 * NS, 9 * NS}, {0, 1, 0}, true},
    };

    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        print_message("%s %zu\n", rows[i].model, i);
        play_beginning(&rows[i]);
    }
}

static void power_comes_behind_the_first_look(void **state)
{
    struct dg_hdl *self = dg_hdl_open("s3684-biss", "power_on_ns=2.5", "90DEG", "");

    (void)state;
    assert_int_equal(dg_hdl_position(self, 0), 1 << 19); /* it can be asked before */
    assert_int_equal(dg_hdl_wires(self, 3 * NS, 1), DG_HDL_DATA);
    assert_int_equal(dg_hdl_next(self), 5500);
    assert_int_equal(dg_hdl_wires(self, 5500, 1), 0);
    dg_hdl_close(self);
    /* Somebody leaves it off. */
    self = dg_hdl_open("s3684-biss", "", "", "");
    assert_int_equal(dg_hdl_power(self, 0, 0), 0);
    assert_int_equal(dg_hdl_wires(self, 0, 1), DG_HDL_DATA);
    assert_int_equal(dg_hdl_wires(self, US, 1), DG_HDL_DATA);
    assert_int_equal(dg_hdl_position(self, US), -1);
    dg_hdl_close(self);
}

/* Without a pulse of MA, 100 us behind power-on. */
static void what_may_keep_a_master_waiting_is_told(void **state)
{
    struct sim sim;

    (void)state;
    begin_with(&sim, "s3684-biss", "");
    wait_until(&sim, 1000 * US);
    assert_int_equal(sim.hints, 1);
    assert_int_equal(sim.hinted, NS + 100 * US);
    assert_string_equal(dg_hdl_hint(sim.encoder, 1), "");
    dg_hdl_close(sim.encoder);
    begin_with(&sim, "s3684-biss", "hint_us=20");
    wait_until(&sim, 19 * US);
    assert_int_equal(sim.hints, 0);
    assert_non_null(strstr(dg_hdl_hint(sim.encoder, 1), "hangs here")); /* the end */
    dg_hdl_close(sim.encoder);
    begin_with(&sim, "s3684-biss", "");
    clock_frame(&sim, 60, US);
    wait_until(&sim, 1000 * US);
    assert_int_equal(sim.hints, 0);
    assert_string_equal(dg_hdl_hint(sim.encoder, 1), "");
    dg_hdl_close(sim.encoder);
    assert_string_equal(dg_hdl_hint(NULL, 1), "");
}

/* More edges than the queue has room for at first are on the way. */
static void a_long_cable_loses_no_edge(void **state)
{
    struct sim far;
    struct sim near;

    (void)state;
    begin_with(&far, "s3684-biss", "delay_in_ns=100000 delay_out_ns=100000");
    begin_with(&near, "s3684-biss", "");
    clock_frame(&far, 300, US / 2);
    clock_frame(&near, 300, US / 2);
    wait_until(&far, far.now + 300 * US);
    assert_int_equal(far.count, near.count);
    for (size_t i = 0; i < far.count; i++) {
        assert_int_equal(far.at[i], near.at[i] + 200 * US);
        assert_int_equal(far.levels[i], near.levels[i]);
    }
    dg_hdl_close(far.encoder);
    dg_hdl_close(near.encoder);
}

static void the_same_seed_gives_the_same_trace(void **state)
{
    static const char *const settings[] = {"jitter_ns=20 seed=4", "jitter_ns=20 seed=4",
                                           "jitter_ns=20 seed=5"};
    static struct sim sims[3];

    (void)state;
    for (size_t i = 0; i < 3; i++) {
        begin_with(&sims[i], "s3684-biss", settings[i]);
    }
    for (size_t i = 0; i < 3; i++) {
        /* How often somebody looks in between changes nothing. */
        wait_until(&sims[i], (int64_t)i * 1000);
        wait_until(&sims[i], US);
        clock_frame(&sims[i], 80, US);
    }
    assert_int_equal(sims[0].count, sims[1].count);
    assert_memory_equal(sims[0].at, sims[1].at, sims[0].count * sizeof sims[0].at[0]);
    assert_memory_not_equal(sims[0].at, sims[2].at, sims[0].count * sizeof sims[0].at[0]);
    for (size_t i = 0; i < 3; i++) {
        dg_hdl_close(sims[i].encoder);
    }
}

/* @return sum of what came of eight frames */
static int64_t chance(const char *settings, const char *fault)
{
    struct sim sim;
    int64_t sum = 0;

    begin_with(&sim, "s3684-biss", settings);
    if (fault != NULL) {
        assert_int_equal(dg_hdl_fault(sim.encoder, 0, fault, 1), 0);
    }
    for (unsigned i = 0; i < 8; i++) {
        clock_frame(&sim, 80, US);
    }
    for (size_t i = 0; i < sim.count; i++) {
        sum = (sum * 31 + sim.at[i]) % INT64_C(1000000007);
    }
    dg_hdl_close(sim.encoder);
    return sum;
}

/* Of the processing time and of faults, too. */
static void the_seed_is_that_of_all_chance(void **state)
{
    static const struct {
        const char *settings[3];
        const char *fault;
    } rows[] = {
        {{"busy_jitter_us=15 seed=4", "busy_jitter_us=15 seed=4", "busy_jitter_us=15 seed=5"},
         NULL},
        {{"seed=4", "seed=4", "seed=5"}, "wire_damage"},
    };

    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const int64_t one = chance(rows[i].settings[0], rows[i].fault);
        assert_true(chance(rows[i].settings[1], rows[i].fault) == one);
        assert_true(chance(rows[i].settings[2], rows[i].fault) != one);
    }
}

/* A fault sits in front of delays: what is on the cable stays. */
static void a_fault_is_seen_behind_the_cable(void **state)
{
    struct sim sim;

    (void)state;
    begin_with(&sim, "s3684-biss", "tco_ns=10 delay_out_ns=500");
    clock_frame(&sim, 80, US); /* up to then SLO is low */
    sim.count = 0;
    assert_int_equal(dg_hdl_fault(sim.encoder, sim.now, "wire_drop", 1), 0);
    clock_frame(&sim, 80, US);
    assert_int_equal(sim.count, 0);
    assert_int_equal(dg_hdl_fault(sim.encoder, sim.now, "wire_drop", 0), 0);
    const int64_t e2 = sim.now + 2 * US;
    clock_frame(&sim, 80, US);
    assert_int_equal(sim.at[0], e2 + 510000);
    assert_int_equal(sim.levels[0], 0);
    dg_hdl_close(sim.encoder);
}

/* --- RS485 --- */

static void put_character(struct sim *self, unsigned byte, unsigned parity, unsigned stop)
{
    const unsigned bits = byte << 1 | parity << 9 | stop << 10;

    for (unsigned i = 0; i <= 10; i++) {
        set(self, (int)(bits >> i & 1u));
        wait_until(self, self->now + 1000000 * US / 9600);
    }
    set(self, DG_HDL_RX);
}

/* 42h of address 40h. @return characters of the answer */
static int64_t ask(struct sim *self, unsigned parity, unsigned stop)
{
    self->count = 0;
    wait_until(self, self->now + 50000 * US);
    put_character(self, 0x40, 1, 1);
    put_character(self, 0x42, parity, stop);
    wait_until(self, self->now + 300 * US);
    put_character(self, 0x02, 1, 1);
    wait_until(self, self->now + 50000 * US);
    assert_true(self->count > 2);
    return (self->at[self->count - 1u] - self->at[0] + 100 * US) / (11 * (1000000 * US / 9600));
}

static void characters_go_bit_by_bit(void **state)
{
    struct sim sim;

    (void)state;
    begin_with(&sim, "s3684-rs485", "");
    sim.inputs = DG_HDL_RX;
    assert_int_equal(ask(&sim, 0, 1), 7);
    assert_int_equal(sim.levels[0], DG_HDL_DRIVER); /* a start bit */
    assert_int_equal(sim.levels[sim.count - 1u], DG_HDL_TX);
    const int64_t sent = sim.at[sim.count - 1u] - sim.at[0];
    assert_in_range(sent, 77 * (1000000 * US / 9600), 77 * (1000000 * US / 9600 + 1));
    /* A wrong parity or stop bit is seen as such, and answered with an error. */
    assert_int_equal(ask(&sim, 1, 1), 4);
    assert_int_equal(ask(&sim, 0, 0), 4);
    assert_int_equal(ask(&sim, 0, 1), 7);
    dg_hdl_close(sim.encoder);
}

static void power_that_goes_ends_a_character(void **state)
{
    struct sim sim;

    (void)state;
    begin_with(&sim, "s3684-rs485", "");
    put_character(&sim, 0x40, 1, 1);
    put_character(&sim, 0x42, 0, 1);
    put_character(&sim, 0x02, 1, 1);
    while (sim.outputs == DG_HDL_TX) {
        wait_until(&sim, sim.now + 100 * US);
    }
    wait_until(&sim, sim.now + 3000 * US);
    assert_int_equal(dg_hdl_power(sim.encoder, sim.now, 0), 0);
    wait_until(&sim, sim.now + US);
    assert_int_equal(sim.outputs, DG_HDL_TX);
    sim.count = 0;
    wait_until(&sim, sim.now + 50000 * US);
    assert_int_equal(sim.count, 0);
    dg_hdl_close(sim.encoder);
}

/* --- what is refused --- */

static void wrong_settings_are_one_line(void **state)
{
    static const struct {
        const char *model;
        const char *settings;
        const char *motion;
        const char *line;
    } rows[] = {
        {"s3684", "", "", "there is no model 's3684'"},
        {"f3668", "", "", "f3668 speaks canopen; expected BiSS, SSI or RS485"},
        {"s3684-biss", "st=33", "", "st=33: expected 8..32"},
        {"s3684-biss", "lc=2", "", "lc=2: expected 0 or 1"},
        {"s3684-rs485", "address=96", "", "address=96: expected 64..95"},
        {"s3684-biss", "tco_ns=0", "", "tco_ns=0: expected 0.001..10000"},
        {"s3684-biss", "seed=-1", "", "seed=-1: expected 0..4294967295"},
        {"s3684-biss", "control=tcp:1:1", "", "control=tcp:1:1: expected unix:PATH"},
        {"s3684-biss", "control=unix:/", "", "unix:/: exists and is no socket"},
        {"s3684-biss", "stop", "", "'stop' is not KEY=VALUE"},
        {"s3684-biss", "sp=1 st=12", "", "s3684-biss has no setting 'sp'"},
        {"s3684-biss", "busy_us=30 busy_jitter_us=30", "",
         "busy_us=30 busy_jitter_us=30: do not go together"},
        {"s3684-biss", "", "fast", "motion fast: 'fast' is not a number with a unit"},
    };

    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct dg_hdl *self = dg_hdl_open(rows[i].model, rows[i].settings, rows[i].motion, "");
        assert_non_null(self);
        assert_non_null(strstr(dg_hdl_error(self), rows[i].line));
        assert_null(strchr(dg_hdl_error(self), '\n'));
        dg_hdl_close(self);
    }
}

static void wrong_steering_is_one_line(void **state)
{
    struct sim sim;

    (void)state;
    begin_with(&sim, "s3674-biss", "");
    assert_true(dg_hdl_turn(sim.encoder, 0, 1e12) < 0);
    assert_true(dg_hdl_turn(sim.encoder, 0, 0.0 / (double)sim.count) < 0);
    assert_true(dg_hdl_speed(sim.encoder, 0, -1.1e6) < 0);
    assert_true(dg_hdl_motion(sim.encoder, 0, "1") < 0);
    assert_true(dg_hdl_world(sim.encoder, 0, "weather", 1.0) < 0);
    assert_string_equal(dg_hdl_error(sim.encoder), "world: s3674-biss senses no 'weather'");
    assert_true(dg_hdl_world(sim.encoder, 0, "temperature", 1e9) < 0);
    assert_true(dg_hdl_fault(sim.encoder, 0, "fire", 1) < 0);
    assert_null(dg_hdl_command(sim.encoder, 0, "SHAFt:JUMP"));
    assert_non_null(strstr(dg_hdl_error(sim.encoder), "SHAFt:JUMP: -113"));
    assert_string_equal(dg_hdl_command(sim.encoder, 0, "SHAFt:POSition?"), "90.000000");
    dg_hdl_close(sim.encoder);
}

/* --- steering --- */

static void a_text_that_is_null_is_empty(void **state)
{
    struct dg_hdl *none = dg_hdl_open(NULL, NULL, NULL, NULL);
    struct dg_hdl *self = dg_hdl_open("s3684-rs485", NULL, NULL, NULL);

    (void)state;
    assert_non_null(strstr(dg_hdl_error(none), "there is no model ''"));
    dg_hdl_close(none);
    assert_string_equal(dg_hdl_error(self), "");
    assert_true(dg_hdl_motion(self, 0, NULL) < 0);
    assert_true(dg_hdl_world(self, 0, NULL, 1.0) < 0);
    assert_true(dg_hdl_fault(self, 0, NULL, 1) < 0);
    assert_string_equal(dg_hdl_command(self, 0, NULL), "");
    dg_hdl_close(self);
    assert_int_equal(dg_hdl_find(NULL), -1);
    assert_int_equal(dg_hdl_make(NULL, NULL, NULL, NULL, NULL), 0);
    assert_int_equal(dg_hdl_find(""), 0);
    assert_int_equal(dg_hdl_character(0, 1, 0), 't');
    dg_hdl_make_none();
}

static void time_has_an_end(void **state)
{
    static const char *const models[] = {"s3684-biss", "ssi-25", "s3684-rs485"};

    (void)state;
    for (size_t i = 0; i < sizeof models / sizeof models[0]; i++) {
        struct dg_hdl *self =
            dg_hdl_open(models[i], "delay_in_ns=100000 delay_out_ns=100000", "", "");
        assert_string_equal(dg_hdl_error(self), "");
        const int idle = dg_hdl_wires(self, INT64_MAX, 1);
        assert_int_equal(dg_hdl_wires(self, INT64_MAX, 0), idle);
        assert_int_equal(dg_hdl_wires(self, INT64_MAX, 1), idle);
        assert_int_equal(dg_hdl_turn(self, INT64_MAX, 0.25), 0);
        assert_int_equal(dg_hdl_power(self, INT64_MAX, 0), 0);
        const int64_t next = dg_hdl_next(self);
        assert_true(next == DG_HDL_NEVER || next > INT64_MAX / 2);
        dg_hdl_close(self);
    }
}

static void the_test_bench_moves_the_shaft(void **state)
{
    struct sim sim;

    (void)state;
    begin_with(&sim, "s3674-biss", "st=12");
    assert_int_equal(dg_hdl_latched(sim.encoder), -1);
    assert_int_equal(dg_hdl_latched_at(sim.encoder), -1);
    assert_int_equal(dg_hdl_turn(sim.encoder, US, 0.5), 0);
    assert_int_equal(dg_hdl_position(sim.encoder, US), 2048);
    assert_int_equal(dg_hdl_speed(sim.encoder, US, 60000.0), 0);
    assert_int_equal(dg_hdl_position(sim.encoder, 251 * US), 2048 + 1024);
    assert_int_equal(dg_hdl_motion(sim.encoder, 2 * US, "45DEG"), 0);
    assert_int_equal(dg_hdl_position(sim.encoder, 3 * US), 512);
    dg_hdl_close(sim.encoder);
}

/* --- the EEPROM's file --- */

static void a_memory_stays_and_a_foreign_file_is_left_alone(void **state)
{
    char path[] = "/tmp/test_hdl_XXXXXX";
    char text[2048] = "this is a letter to somebody, and no EEPROM";
    char read[2048] = "";

    (void)state;
    assert_true(close(mkstemp(path)) == 0);
    assert_int_equal(unlink(path), 0);
    struct dg_hdl *self = dg_hdl_open("s3684-biss", "", "", path);
    assert_string_equal(dg_hdl_error(self), "");
    struct dg_hdl *other = dg_hdl_open("s3684-biss", "", "", path);
    char *named = strstr(dg_hdl_error(other), path);
    assert_non_null(named);
    assert_null(strstr(named + 1, path));
    assert_non_null(strstr(dg_hdl_error(other), "in use"));
    dg_hdl_close(other);
    dg_hdl_close(self);
    self = dg_hdl_open("s3684-biss", "", "", path);
    assert_string_equal(dg_hdl_error(self), "");
    dg_hdl_close(self);

    FILE *file = fopen(path, "w");
    assert_int_equal(fwrite(text, 1, 1000, file), 1000);
    assert_int_equal(fclose(file), 0);
    self = dg_hdl_open("s3684-biss", "", "", path);
    assert_non_null(strstr(dg_hdl_error(self), "the EEPROM is another device's"));
    dg_hdl_close(self);
    file = fopen(path, "r");
    assert_int_equal(fread(read, 1, sizeof read, file), 1000);
    assert_int_equal(fclose(file), 0);
    assert_memory_equal(read, text, sizeof text);
    self = dg_hdl_open("ssi-25", "", "", path);
    assert_non_null(strstr(dg_hdl_error(self), "ssi-25 has no EEPROM"));
    dg_hdl_close(self);
    (void)unlink(path);
    self = dg_hdl_open("s3684-biss", "", "fast", path);
    assert_non_null(strstr(dg_hdl_error(self), "motion fast"));
    dg_hdl_close(self);
    assert_int_equal(access(path, F_OK), -1);
}

static void cycle_power(struct sim *self)
{
    assert_int_equal(dg_hdl_power(self->encoder, self->now, 0), 0);
    wait_until(self, self->now + 100 * US);
    assert_int_equal(dg_hdl_power(self->encoder, self->now, 1), 0);
    wait_until(self, self->now + 100 * US);
}

/* 42h in the start-up window. @return from now to the start bit of the answer */
static int64_t ask_position(struct sim *self)
{
    const int64_t begin = self->now;

    self->count = 0;
    put_character(self, 0x40, 1, 1);
    put_character(self, 0x42, 0, 1);
    put_character(self, 0x02, 1, 1);
    wait_until(self, self->now + 30000 * US);
    assert_true(self->count > 2);
    assert_int_equal(self->levels[0], DG_HDL_DRIVER);
    const int64_t sent = self->at[self->count - 1u] - self->at[0];
    assert_in_range(sent, 77 * (1000000 * US / 9600), 77 * (1000000 * US / 9600 + 1));
    return self->at[0] - begin;
}

/* What an encoder was about when its power went does not bend what it does with power again:
   three characters, 44 bit times and 1 ms of reaction, at 9600 baud. */
static void power_begins_anew(void **state)
{
    const int64_t bit = 1000000 * US / 9600;
    const int64_t latest = (33 + 44) * bit + 1000 * US + US;
    struct sim sim;

    (void)state;
    begin_with(&sim, "s3684-rs485", "");
    sim.inputs = DG_HDL_RX;
    wait_until(&sim, 200000 * US);
    cycle_power(&sim);
    assert_in_range(ask_position(&sim), latest - 2 * US, latest);
    /* in the middle of an answer of 40 characters */
    put_character(&sim, 0x40, 1, 1);
    put_character(&sim, 0x56, 0, 1);
    put_character(&sim, 0x16, 1, 1);
    while (sim.outputs == DG_HDL_TX) {
        wait_until(&sim, sim.now + 100 * US);
    }
    wait_until(&sim, sim.now + 3000 * US);
    cycle_power(&sim);
    assert_in_range(ask_position(&sim), latest - 2 * US, latest);
    /* in the middle of a character of the master */
    set(&sim, 0);
    wait_until(&sim, sim.now + 2 * bit);
    set(&sim, DG_HDL_RX);
    cycle_power(&sim);
    assert_in_range(ask_position(&sim), latest - 2 * US, latest);
    dg_hdl_close(sim.encoder);
}

/* A million rpm; what is beyond is not taken modulo anything. */
static void the_fastest_shaft(void **state)
{
    struct sim sim;

    (void)state;
    begin_with(&sim, "s3674-biss", "");
    assert_int_equal(dg_hdl_speed(sim.encoder, 0, 1e6), 0);
    assert_string_equal(dg_hdl_command(sim.encoder, 0, "SHAFt:VELocity?"), "1000000.000");
    assert_int_equal(dg_hdl_speed(sim.encoder, 0, -1e6), 0);
    static const double beyond[] = {1000000.001, 5e6, -5e6, 4294967.296, 1e9};
    for (size_t i = 0; i < sizeof beyond / sizeof beyond[0]; i++) {
        assert_true(dg_hdl_speed(sim.encoder, 0, beyond[i]) < 0);
        assert_non_null(strstr(dg_hdl_error(sim.encoder), "is beyond +-1000000 rpm"));
    }
    assert_string_equal(dg_hdl_command(sim.encoder, 0, "SHAFt:VELocity?"), "-1000000.000");
    dg_hdl_close(sim.encoder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_output_follows_by_the_delays),
        cmocka_unit_test(what_registers_do_before_power_on_is_no_edge),
        cmocka_unit_test(power_comes_behind_the_first_look),
        cmocka_unit_test(what_may_keep_a_master_waiting_is_told),
        cmocka_unit_test(a_long_cable_loses_no_edge),
        cmocka_unit_test(the_same_seed_gives_the_same_trace),
        cmocka_unit_test(the_seed_is_that_of_all_chance),
        cmocka_unit_test(a_fault_is_seen_behind_the_cable),
        cmocka_unit_test(characters_go_bit_by_bit),
        cmocka_unit_test(power_that_goes_ends_a_character),
        cmocka_unit_test(wrong_settings_are_one_line),
        cmocka_unit_test(wrong_steering_is_one_line),
        cmocka_unit_test(a_text_that_is_null_is_empty),
        cmocka_unit_test(time_has_an_end),
        cmocka_unit_test(the_test_bench_moves_the_shaft),
        cmocka_unit_test(a_memory_stays_and_a_foreign_file_is_left_alone),
        cmocka_unit_test(power_begins_anew),
        cmocka_unit_test(the_fastest_shaft),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
