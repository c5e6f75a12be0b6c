/* SPDX-License-Identifier: MIT */
/*
 * Clocked lines of the library: one encoder on a bus is the bare handle, several are the chain that
 * their slaves make by themselves, and faults sit behind each driver.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/shaft.h"
#include "edges_rig.h"
#include "effort.h"
#include "motion_model.h"

/* --- one encoder is the bare handle --- */

/* The same encoder beside the bus, with its queues. */
static struct host_rig_place alone_memory;
static struct host_rig_place panel_memory;

struct alone {
    struct dg_host *host;
    struct dg_host_panel *panel;
    const char *model;
};

static struct alone begin_both(const char *model, const char *jitter)
{
    struct alone self = {.host = host_rig_make(&alone_memory, model), .model = model};
    struct dg_host *const both[] = {self.host, edges_rig_model(0, model)};

    for (size_t i = 0; i < 2; i++) {
        (void)dg_host_set(both[i], "busy_jitter_us", jitter);
        (void)dg_host_set(both[i], "init_ms", "0");
    }
    edges_rig_attach(0);
    assert_int_equal(dg_host_power(self.host, edges_rig.now, true), DG_OK);
    edges_rig_power(0, true);
    self.panel = dg_host_panel_make(&panel_memory, sizeof panel_memory, self.host);
    assert_non_null(self.panel);
    dg_host_panel_seed(self.panel, 1);
    const struct dg_instrument *instrument = edges_rig.place[0].control.instrument;
    if (instrument->seed != NULL) {
        instrument->seed(edges_rig.place[0].control.device, 1);
    }
    dg_host_shaft_of(edges_rig.place[0].host, dg_host_panel_shaft(self.panel));
    assert_int_equal(dg_shaft_set_velocity(dg_host_panel_shaft(self.panel), 0, 6000000), 0);
    return self;
}

/* All that the handle told, at the same moments, is what the wire has carried. */
static void compare_levels(const struct alone *self)
{
    struct dg_host_event event;

    for (size_t i = 0; i < edges_rig.heard_count; i++) {
        assert_int_equal(dg_host_receive(self->host, &event), 1);
        assert_int_equal(event.at, edges_rig.heard[i].at);
        assert_int_equal(event.data[0], edges_rig.heard[i].levels.data);
    }
    assert_int_equal(dg_host_receive(self->host, &event), 0);
    edges_rig.heard_count = 0;
}

static void compare_latches(const struct alone *self)
{
    uint64_t at[2] = {0};
    uint64_t counts[2] = {0};

    assert_int_equal(dg_host_latched(self->host, &at[0], &counts[0]),
                     dg_host_latched(edges_rig.place[0].host, &at[1], &counts[1]));
    assert_int_equal(at[0], at[1]);
    assert_int_equal(counts[0], counts[1]);
}

static void set_fault(const struct alone *self, const char *name, bool on)
{
    struct edges_rig_place *place = &edges_rig.place[0];
    const struct dg_fault_target target = dg_encoder_target(&place->control);
    static const struct dg_fault_limits usual = {.probability_ppm = 1000000, .duration = DG_NEVER};
    const int index = dg_fault_find(&target, name);

    assert_int_equal(dg_host_fault_set(self->panel, edges_rig.now, name, on), DG_HOST_OK);
    assert_true(index >= 0);
    assert_int_equal(
        on ? dg_fault_set(&place->control.faults, &target, (size_t)index, edges_rig.now, &usual)
           : dg_fault_clear(&place->control.faults, &target, (size_t)index),
        0);
    (void)dg_bus_changed(edges_rig.bus, 0, edges_rig.now);
}

/* Half a period, mostly; now and then nothing, or a long while. */
static dg_ns random_pause(uint64_t *seed)
{
    switch (random_bits(seed) % 300u) {
    case 0:
        return 0;
    case 1:
        return 12000 + random_bits(seed) % 2000u;
    case 2:
        return DG_US(100);
    default:
        return 250 + random_bits(seed) % 20u;
    }
}

static void disturb(const struct alone *self, uint64_t *seed)
{
    static const char *const faults[] = {"wire_drop", "wire_delay", "wire_damage", "wire_break"};

    switch (random_bits(seed) % 1000u) {
    case 0:
        set_fault(self, faults[random_bits(seed) % 4u], true);
        break;
    case 1:
    case 2:
        for (size_t i = 0; i < 4; i++) {
            set_fault(self, faults[i], false);
        }
        break;
    case 3:
        assert_int_equal(dg_host_power(self->host, edges_rig.now, false), DG_OK);
        edges_rig_power(0, false);
        break;
    case 4:
    case 5:
        assert_int_equal(dg_host_power(self->host, edges_rig.now, true), DG_OK);
        edges_rig_power(0, true);
        break;
    default:
        break;
    }
}

static void one_encoder_is_the_bare_handle(void **state)
{
    static const char *const models[] = {"s3684-biss", "s3674-biss", "ssi-13", "ssi-25"};
    const uint32_t edges = effort(20000, 400000);

    (void)state;
    for (size_t m = 0; m < DG_COUNT(models); m++) {
        uint64_t seed = m + 1u;
        edges_rig_begin(NULL, 1);
        const struct alone alone = begin_both(models[m], m % 2u == 0 ? "0" : "2");
        bool level = true;
        for (uint32_t i = 0; i < edges; i++) {
            edges_rig.now += random_pause(&seed);
            disturb(&alone, &seed);
            level = random_bits(&seed) % 200u == 0 ? level : !level;
            const dg_ns at = random_bits(&seed) % 300u == 0 ? edges_rig.now - 30u : edges_rig.now;
            const int told = dg_host_clock(alone.host, at, level);
            assert_int_equal(dg_bus_edge(edges_rig.bus, at, level), told);
            compare_levels(&alone);
            compare_latches(&alone);
            assert_int_equal(dg_bus_next(edges_rig.bus), dg_host_next(alone.host));
        }
        compare_latches(&alone);
        assert_true(dg_host_line_of(alone.host)->latched > edges_rig.now - DG_MS(1));
    }
}

/* Whoever watches the clock, and whoever hands edges over as events, gets the same. */
static void an_edge_is_an_event(void **state)
{
    struct dg_tap_event event = {.kind = DG_TAP_LEVELS};
    uint64_t bits[2] = {0};

    (void)state;
    for (size_t way = 0; way < 2; way++) {
        edges_rig_begin(NULL, 1);
        (void)edges_rig_model(0, "ssi-25");
        edges_rig_attach(0);
        edges_rig_power(0, true);
        edges_rig.now = READY;
        edges_rig_rest();
        edges_rig.taps = 0;
        for (unsigned i = 0; i < 50; i++) {
            edges_rig.now += EDGES_RIG_HALF;
            event.at = edges_rig.now;
            event.levels.clock = i % 2u != 0;
            if (way == 0) {
                (void)dg_bus_edge(edges_rig.bus, edges_rig.now, event.levels.clock);
            } else {
                const dg_ns next = dg_bus_rx(edges_rig.bus, &event);
                assert_int_equal(next, dg_bus_next(edges_rig.bus));
            }
            bits[way] = bits[way] << 1 | dg_bus_edges_data(edges_rig.bus, edges_rig.now);
            assert_int_equal(dg_bus_edges_clock(edges_rig.bus), event.levels.clock);
        }
        assert_int_equal(edges_rig.taps, 50);
    }
    assert_int_equal(bits[0], bits[1]);
}

/* Without an edge, whenever it gets its power: before it is connected, or later. */
static void the_end_of_a_start_is_told(void **state)
{
    (void)state;
    for (size_t early = 0; early < 2; early++) {
        edges_rig_begin(NULL, 1);
        struct dg_host *host = edges_rig_model(0, "ssi-25");
        assert_int_equal(dg_host_set(host, "init_ms", "7"), DG_HOST_OK);
        if (early == 1) {
            assert_int_equal(dg_host_power(host, 0, true), DG_OK);
        }
        edges_rig_attach(0);
        if (early == 0) {
            edges_rig_power(0, true);
        }
        assert_int_equal(dg_bus_next(edges_rig.bus), 7 * MS);
        assert_int_equal(dg_bus_step(edges_rig.bus, SECOND), DG_NEVER);
        assert_int_equal(edges_rig.heard_count, 1);
        assert_int_equal(edges_rig.heard[0].at, 7 * MS);
        assert_true(edges_rig.heard[0].levels.data);
    }
}

/* --- chains --- */

static void begin_chain(const struct dg_bus_edges_setup *wire)
{
    edges_rig_begin(wire, EDGES_RIG_ENCODERS);
    for (size_t i = 0; i < EDGES_RIG_ENCODERS; i++) {
        struct dg_host *host = edges_rig_model(i, i == 1 ? "s3674-biss" : "s3684-biss");
        (void)dg_host_set(host, "lc", "0");
        (void)dg_host_set(host, "busy_jitter_us", "0");
        edges_rig_attach(i);
        edges_rig_power(i, true);
        dg_host_shaft(host, 0, (int64_t)(i + 1u) * TURN / 8, 0);
    }
    edges_rig.now = READY;
    (void)dg_bus_step(edges_rig.bus, edges_rig.now);
}

static const struct dg_biss_model *figures_of(size_t place)
{
    return dg_host_line_of(edges_rig.place[place].host)->settings;
}

/* Clocks to the start bit. @return 0: there was no Ack */
static unsigned await_start(void)
{
    unsigned clocks = 1;

    assert_true(edges_rig_clock());
    if (edges_rig_clock()) {
        return 0;
    }
    while (!edges_rig_clock()) {
        assert_true(clocks++ < 2000);
    }
    (void)edges_rig_clock(); /* CDS */
    return clocks;
}

static struct dg_biss_data take_data(size_t place)
{
    const struct dg_biss_model *model = figures_of(place);
    struct dg_biss_data data;

    dg_biss_frame_decode(model, edges_rig_take(dg_biss_frame_bits(model)), &data);
    return data;
}

static void assert_chain_answers(void)
{
    assert_true(await_start() > 0);
    for (size_t i = 0; i < EDGES_RIG_ENCODERS; i++) {
        const struct dg_biss_data data = take_data(i);
        assert_true(data.crc_ok);
        assert_int_equal(data.singleturn, (i + 1u) << (figures_of(i)->singleturn_bits - 3u));
    }
    edges_rig_rest();
}

static void a_chain_sends_one_behind_the_other(void **state)
{
    (void)state;
    begin_chain(NULL);
    for (unsigned i = 0; i < 5; i++) {
        assert_chain_answers();
    }
    assert_int_equal(dg_bus_count(edges_rig.bus), EDGES_RIG_ENCODERS);
}

/* Whatever a master does: the slaves alone, each with its neighbour's level before the edge. */
static void a_chain_is_what_its_slaves_make_of_each_other(void **state)
{
    static struct edges_rig_place twin[EDGES_RIG_ENCODERS];
    const uint32_t edges = effort(20000, 200000);
    uint64_t seed = 7;
    bool level = true;

    (void)state;
    begin_chain(NULL);
    for (size_t i = 0; i < EDGES_RIG_ENCODERS; i++) {
        memset(&twin[i], 0, sizeof twin[i]);
        struct dg_host *host = edges_rig_make(&twin[i], edges_rig.place[i].control.model,
                                              dg_host_side_at(edges_rig.place[i].host), NULL);
        (void)dg_host_set(host, "lc", "0");
        (void)dg_host_set(host, "busy_jitter_us", "0");
        assert_int_equal(dg_host_power(host, 0, true), DG_OK);
        dg_host_shaft(host, 0, (int64_t)(i + 1u) * TURN / 8, 0);
    }
    for (uint32_t n = 0; n < edges; n++) {
        bool sli[EDGES_RIG_ENCODERS];
        bool below = false;
        edges_rig.now += random_pause(&seed);
        level = random_bits(&seed) % 200u == 0 ? level : !level;
        for (size_t i = EDGES_RIG_ENCODERS; i-- > 0;) {
            struct dg_biss *slave = dg_host_line_of(twin[i].host)->device;
            (void)dg_biss_step(slave, edges_rig.now);
            sli[i] = below;
            below = dg_biss_slo(slave, below);
        }
        below = false;
        for (size_t i = EDGES_RIG_ENCODERS; i-- > 0;) {
            (void)dg_biss_link(dg_host_line_of(twin[i].host)->device, edges_rig.now, level, sli[i]);
        }
        for (size_t i = EDGES_RIG_ENCODERS; i-- > 0;) {
            below = dg_biss_slo(dg_host_line_of(twin[i].host)->device, below);
        }
        assert_int_equal(dg_bus_edge(edges_rig.bus, edges_rig.now, level), below);
        for (size_t i = 0; i < EDGES_RIG_ENCODERS; i++) {
            const struct dg_biss *a = dg_host_line_of(twin[i].host)->device;
            const struct dg_biss *b = dg_host_line_of(edges_rig.place[i].host)->device;
            assert_memory_equal(&a->counters, &b->counters, sizeof a->counters);
            assert_memory_equal(&a->line, &b->line, sizeof a->line);
            assert_memory_equal(&a->control, &b->control, sizeof a->control);
        }
    }
    assert_true(dg_bus_next(edges_rig.bus) != 0);
}

static void a_fault_is_behind_its_own_driver(void **state)
{
    (void)state;
    begin_chain(NULL);
    assert_chain_answers();
    edges_rig_bend(1, DG_WIRE_DAMAGE, 1);
    assert_true(await_start() > 0);
    assert_true(take_data(0).crc_ok);
    assert_false(take_data(1).crc_ok);
    assert_true(take_data(2).crc_ok);
    edges_rig_rest();
    assert_chain_answers();
    edges_rig_bend(2, DG_WIRE_BREAK, 0);
    assert_true(await_start() > 0); /* of the high line behind it */
    assert_true(take_data(0).crc_ok);
    assert_true(take_data(1).crc_ok);
    assert_int_equal(edges_rig_take(dg_biss_frame_bits(figures_of(2))),
                     (UINT64_C(1) << dg_biss_frame_bits(figures_of(2))) - 1u);
    edges_rig_rest();
    edges_rig_heal(2);
    assert_chain_answers();
    edges_rig_bend(0, DG_WIRE_DROP, 1);
    assert_int_equal(await_start(), 0);
    edges_rig_rest();
    assert_chain_answers();
}

static void faults_may_come_behind_the_encoder(void **state)
{
    (void)state;
    edges_rig_begin(NULL, 1);
    struct dg_host *host = edges_rig_model(0, "s3684-biss");
    assert_int_equal(dg_bus_attach(edges_rig.bus, host, NULL), 0);
    edges_rig_power(0, true);
    edges_rig.now = READY;
    (void)dg_bus_step(edges_rig.bus, edges_rig.now);
    dg_bus_control(edges_rig.bus, 0, &edges_rig.place[0].control);
    edges_rig_bend(0, DG_WIRE_DROP, 1);
    assert_int_equal(await_start(), 0);
    edges_rig_rest();
    assert_true(await_start() > 0);
}

static void encoders_that_make_no_chain_are_refused(void **state)
{
    (void)state;
    edges_rig_begin(NULL, 2);
    (void)edges_rig_model(0, "ssi-25");
    (void)edges_rig_model(1, "ssi-25");
    edges_rig_attach(0);
    assert_int_equal(dg_bus_attach(edges_rig.bus, edges_rig.place[1].host, NULL), DG_ERR_ARGUMENT);
    (void)edges_rig_model(1, "s3684-biss");
    assert_int_equal(dg_bus_attach(edges_rig.bus, edges_rig.place[1].host, NULL), DG_ERR_ARGUMENT);
    (void)edges_rig_model(1, "f3668");
    assert_int_equal(dg_bus_attach(edges_rig.bus, edges_rig.place[1].host, NULL), DG_ERR_ARGUMENT);
    assert_int_equal(dg_bus_count(edges_rig.bus), 1);
    assert_int_equal(dg_bus_size(&dg_bus_edges, DG_BUS_CHAIN_MAX + 1u), 0);
}

/* That frame is lost, whatever comes meanwhile. */
static void what_is_not_durable_is_not_acknowledged(void **state)
{
    (void)state;
    begin_chain(NULL);
    edges_rig.ops.answer = edges_rig_answer;
    edges_rig.answer = DG_BUS_SAY;
    assert_chain_answers();
    edges_rig.answer = DG_BUS_KEEP;
    assert_int_equal(await_start(), 0);
    edges_rig.answer = DG_BUS_SAY;
    assert_true(edges_rig_clock());
    (void)dg_bus_durable(edges_rig.bus, 0, edges_rig.now);
    assert_true(edges_rig_clock());
    edges_rig_rest();
    assert_chain_answers();
}

/* Who goes back to before the first power-on has no device that an edge could get to. */
static void a_state_from_before_the_power(void **state)
{
    static uint8_t saved[sizeof edges_rig.place[0].memory];

    (void)state;
    edges_rig_begin(NULL, 1);
    struct dg_host *host = edges_rig_model(0, "s3684-biss");
    edges_rig_attach(0);
    assert_int_equal(dg_host_save(host, saved, sizeof saved), DG_HOST_OK);
    edges_rig_power(0, true);
    (void)edges_rig_take(4);
    edges_rig_rest();
    assert_int_equal(dg_host_restore(host, saved, sizeof saved), DG_HOST_OK);
    (void)dg_bus_changed(edges_rig.bus, 0, edges_rig.now);
    assert_int_equal(edges_rig_take(4), 0);
    edges_rig_power(0, true);
    edges_rig_rest();
    assert_true(dg_host_powered(host));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_encoder_is_the_bare_handle),
        cmocka_unit_test(an_edge_is_an_event),
        cmocka_unit_test(the_end_of_a_start_is_told),
        cmocka_unit_test(a_chain_sends_one_behind_the_other),
        cmocka_unit_test(a_chain_is_what_its_slaves_make_of_each_other),
        cmocka_unit_test(a_fault_is_behind_its_own_driver),
        cmocka_unit_test(faults_may_come_behind_the_encoder),
        cmocka_unit_test(encoders_that_make_no_chain_are_refused),
        cmocka_unit_test(what_is_not_durable_is_not_acknowledged),
        cmocka_unit_test(a_state_from_before_the_power),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
