/* SPDX-License-Identifier: MIT */
/* What the control plane of a rig says of its wires and shafts, and what a host may do instead. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/host_wire.h"
#include "engine_rig.h"

#define NOW DG_S(2)

static struct engine_rig rig;

static const char each_medium[] = "[shaft motor]\n"
                                  "[shaft load]\ndriver = motor\nratio = 1:2\n"
                                  "[shaft other]\n"
                                  "[bus rs]\nwire = pty\n"
                                  "[bus vcan]\nwire = can\naddress = vcan0\n"
                                  "[bus chain]\nwire = sim\n"
                                  "[bus loop]\nwire = modbus\n"
                                  "[encoder a]\nmodel = s3684-rs485\nbus = rs\nshaft = motor\n"
                                  "[encoder n]\nmodel = f3668\nbus = vcan\nnode = 7\nshaft = load\n"
                                  "[encoder b]\nmodel = s3684-biss\nbus = chain\nshaft = other\n"
                                  "[encoder k]\nmodel = ocd-ib-k2\nbus = loop\nshaft = motor\n"
                                  "[encoder k2]\nmodel = ocd-ib-k2\nbus = loop\nshaft = motor\n";

static void expect(const char *line, const char *answer)
{
    assert_string_equal(engine_rig_ask(&rig, NOW, line), answer);
}

static void expect_refused(const char *line, const char *error)
{
    assert_string_equal(engine_rig_refusal(&rig, NOW, line), error);
}

static bool is_told(const char *name, const char *word)
{
    char select[32];

    (void)snprintf(select, sizeof select, "INST:SEL %s", name);
    expect(select, "");
    return strstr(engine_rig_ask(&rig, NOW, "STAT?"), word) != NULL;
}

/* ------------------------------------------------------------ wires */

static void a_wire_is_its_kind_its_address_and_the_encoders(void **state)
{
    (void)state;
    engine_rig_start(&rig, each_medium);
    expect("INST:SEL a;WIRE?", "\"pty:\"");
    expect("INST:SEL n;WIRE?", "\"can:vcan0/7\"");
    expect("INST:SEL b;WIRE?", "\"sim:\"");
    expect("INST:SEL k2;WIRE?", "\"modbus:127.0.0.1:5020/1\"");
}

static void nobody_is_selected_by_a_name_that_nobody_has(void **state)
{
    (void)state;
    engine_rig_start(&rig, each_medium);
    expect("INST:SEL n", "");
    (void)engine_rig_ask(&rig, NOW, "INST:SEL nobody");
    assert_memory_equal(engine_rig_ask(&rig, NOW, "SYST:ERR?"), "-224", 4);
    expect("INST:SEL?", "\"n\"");
}

/* Each medium has counters of its own, and a chain has none. */
static void counters_are_those_of_the_medium(void **state)
{
    static const struct {
        const char *name;
        const char *words[4];
    } rows[] = {
        {"a", {"wire_collided=0", "wire_baud=9600", "wire_overrun=0"}},
        {"n", {"wire_stalls=0", "wire_lost=0", "wire_kbaud=250"}},
        {"k", {"wire_cycles=0", "wire_ids=0", "wire_crc_errors=0", "wire_interrupted=0"}},
    };
    (void)state;
    engine_rig_start(&rig, each_medium);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        for (size_t j = 0; j < 4 && rows[i].words[j] != NULL; j++) {
            assert_true(is_told(rows[i].name, rows[i].words[j]));
        }
    }
    assert_false(is_told("b", "wire_"));
}

static void cycles_of_a_ring_are_counted(void **state)
{
    static const uint16_t out[4];
    const struct dg_tap_event event = {
        .at = NOW, .kind = DG_TAP_WORDS, .words = {.out = out, .count = 4, .identify = true}};
    (void)state;
    engine_rig_start(&rig, each_medium);
    (void)dg_engine_step(rig.engine, NOW);
    (void)dg_bus_rx(dg_engine_bus(rig.engine, 3), &event);
    assert_true(is_told("k", "wire_ids=1"));
}

static void count_seven(void *ctx, size_t index, struct dg_scpi *to)
{
    assert_ptr_equal(ctx, &rig);
    (void)dg_state_number(to, "port_index", index);
}

static void name_it(void *ctx, size_t index, char *to, size_t size)
{
    assert_ptr_equal(ctx, &rig);
    (void)snprintf(to, size, "door %zu", index);
}

static void a_host_has_counters_and_addresses_of_its_own(void **state)
{
    (void)state;
    engine_rig_read(&rig, each_medium);
    rig.setup.ctx = &rig;
    rig.setup.counters = count_seven;
    rig.setup.address = name_it;
    engine_rig_power(&rig);
    assert_true(is_told("n", "port_index=1"));
    assert_true(is_told("n", "wire_kbaud=250"));
    assert_true(is_told("b", "port_index=2"));
    expect("INST:SEL b;WIRE?", "\"door 2\"");
}

/* ------------------------------------------------------------ shafts */

static void a_profile_is_what_the_shaft_does(void **state)
{
    (void)state;
    engine_rig_start(&rig, each_medium);
    expect("INST:SEL a;:SHAF:PROF?", "\"rest\"");
    expect("SHAF:VEL 60RPM", "");
    (void)dg_engine_step(rig.engine, NOW);
    expect("SHAF:PROF?", "\"steered\"");
    expect("SHAF:PROF \"sine:90DEG,2S\";PROF?", "\"sine:90DEG,2S\"");
    expect("INST:SEL n;:SHAF:PROF?", "\"geared\"");
    expect("INST:SEL b;:SHAF:PROF?", "\"rest\"");
    expect_refused("INST:SEL n;:SHAF:PROF \"60RPM\"",
                   "-221,\"Settings conflict;geared; its driver turns it\"");
}

/* What is wrong, and what would be right where that has room behind it. */
static void a_profile_that_is_none_is_refused_in_words(void **state)
{
    char line[400] = "SHAF:PROF \"";
    (void)state;
    engine_rig_start(&rig, each_medium);
    expect_refused("SHAF:PROF \"5\"", "-224,\"Illegal parameter value;'5' has no unit; expected "
                                      "5DEG or 5RPM, for example\"");
    expect_refused("SHAF:PROF \"x.csv\"", "-256,\"File name not found;there are no files here\"");
    expect_refused("SHAF:PROF \"ramp:60RPM\"",
                   "-224,\"Illegal parameter value;a time such as 2S or "
                   "500MS is missing\"");
    (void)memset(line + strlen(line), 'x', 150);
    (void)strcat(line, "\"");
    const char *said = engine_rig_refusal(&rig, NOW, line);
    assert_memory_equal(said, "-224", 4);
    assert_null(strstr(said, "sine:"));
    expect("SHAF:PROF?", "\"rest\"");
}

/* 38 digits: with them the whole refusal has as many characters as fit. */
#define DIGITS "00000000000000000000000000000000000005"
#define WRONG DIGITS "' has no unit"
#define RIGHT "; expected an angle such as 90DEG or 2.5REV"
_Static_assert(sizeof "'" WRONG RIGHT - 1u == DG_SCPI_DETAIL_MAX, "all of it, and no more");

static void what_would_be_right_is_said_when_all_of_it_fits(void **state)
{
    (void)state;
    engine_rig_start(&rig, each_medium);
    expect_refused("SHAF:PROF \"sine:" DIGITS ",2S\"",
                   "-224,\"Illegal parameter value;'" WRONG RIGHT "\"");
    expect_refused("SHAF:PROF \"sine:0" DIGITS ",2S\"",
                   "-224,\"Illegal parameter value;'0" WRONG "\"");
}

/* Who sits on another shaft is not disturbed. */
static void encoders_turn_with_their_own_shaft(void **state)
{
    (void)state;
    engine_rig_start(&rig, each_medium);
    expect("INST:SEL b;:SHAF:PROF \"90DEG\"", "");
    assert_int_equal(dg_host_angle(dg_engine_encoder(rig.engine, 2), DG_S(3)), DG_TURN / 4);
    assert_int_equal(dg_host_angle(dg_engine_encoder(rig.engine, 0), DG_S(3)), 0);
    expect("INST:SEL a;:SHAF:PROF \"180DEG\"", "");
    assert_int_equal(dg_host_angle(dg_engine_encoder(rig.engine, 1), DG_S(3)), DG_TURN / 4);
    assert_int_equal(dg_host_angle(dg_engine_encoder(rig.engine, 2), DG_S(3)), DG_TURN / 4);
}

static int turn_at_once(struct dg_rig *control, struct dg_rig_shaft *shaft, dg_ns now,
                        const char *text, char *detail)
{
    const struct dg_motion motion = {.kind = DG_MOTION_SPEED, .mrpm = 60000};

    (void)control;
    (void)text;
    (void)detail;
    return dg_shaft_play(&shaft->shaft, now, &motion);
}

/* The engine does not know its words then: the shaft is steered. */
static void a_host_may_play_profiles_of_its_own(void **state)
{
    struct dg_rig_ops ops = dg_engine_ops;
    (void)state;
    engine_rig_read(&rig, each_medium);
    ops.profile = turn_at_once;
    rig.setup.ops = &ops;
    engine_rig_power(&rig);
    expect("SHAF:PROF \"of the host\"", "");
    (void)dg_engine_step(rig.engine, NOW);
    expect("SHAF:PROF?", "\"steered\"");
    assert_int_equal(dg_host_angle(dg_engine_encoder(rig.engine, 0), DG_S(3)), DG_TURN);
}

static void count_call(void *ctx)
{
    ++*(unsigned *)ctx;
}

/* A host that turns shafts its own way still hears that something has changed. */
static void a_host_may_look_at_shafts_itself(void **state)
{
    struct dg_rig_ops ops = dg_engine_ops;
    unsigned woken = 0;
    (void)state;
    engine_rig_read(&rig, each_medium);
    ops.turns = NULL;
    ops.turned = NULL;
    rig.setup.ops = &ops;
    rig.setup.woken = count_call;
    rig.setup.ctx = &woken;
    engine_rig_power(&rig);
    expect("SHAF:VEL 60RPM", "");
    assert_int_equal(woken, 1);
}

/* ------------------------------------------------------------ without all that */

/* What the control plane asks of every encoder, whatever the host knows of its protocol. */
static void expect_state_of_all(const char *name)
{
    assert_true(is_told(name, "power=1"));
    assert_true(is_told(name, "mode=-"));
    assert_true(is_told(name, "leds=-"));
    expect("FAUL:ACT?", "\"\"");
    (void)engine_rig_ask(&rig, NOW, "FAUL:CAT?");
    assert_null(strstr(rig.answer, "wire_"));
    assert_memory_equal(engine_rig_refusal(&rig, NOW, "FAUL:SET wire_drop"), "-224", 4);
    expect("SYST:ERR?", "0,\"No error\"");
}

/* Nobody listens to the wires, nobody is woken, and no protocol has commands. */
static void a_rig_without_a_host_works(void **state)
{
    const struct dg_tap_event go = {
        .at = NOW, .kind = DG_TAP_FRAME, .frame = {.dlc = 2, .data = {1, 0}}};
    (void)state;
    engine_rig_read(&rig, each_medium);
    rig.setup.instruments = NULL;
    rig.setup.frames_wait = 16;
    engine_rig_power(&rig);
    (void)dg_engine_step(rig.engine, NOW);
    (void)dg_bus_rx(dg_engine_bus(rig.engine, 1), &go);
    (void)dg_engine_step(rig.engine, DG_S(3));
    expect("INST:SEL a;:SHAF:VEL 60RPM;VEL?", "60.000");
    expect_state_of_all("a");
    expect_state_of_all("n");
    expect_state_of_all("b");
    assert_true(dg_engine_step(rig.engine, DG_NEVER) == dg_engine_next(rig.engine));
}

/* A host that knows one protocol only has the faults of that one. */
static void instruments_may_be_some_of_them(void **state)
{
    const struct dg_instrument *some[1] = {NULL};
    (void)state;
    engine_rig_read(&rig, each_medium);
    for (size_t i = 0; i < dg_instrument_count; i++) {
        if (dg_instruments[i]->stack == rig.plan.encoders[1].model->stack) {
            some[0] = dg_instruments[i];
        }
    }
    rig.setup.instruments = some;
    rig.setup.instrument_count = 1;
    engine_rig_power(&rig);
    expect("INST:SEL n;:FAUL:SET temperature_high;:FAUL:ACT?", "\"temperature_high\"");
    expect_state_of_all("a");
}

/* Before there is power nobody answers, and nothing breaks. */
static void a_rig_without_power_is_silent(void **state)
{
    const struct dg_tap_event byte = {
        .at = NOW, .kind = DG_TAP_CHARACTER, .character = {DG_BAUD_ANY, 'E', 0x40, false}};
    const struct dg_tap_event frame = {.at = NOW, .kind = DG_TAP_FRAME, .frame = {.id = 0x607}};
    (void)state;
    engine_rig_read(&rig, each_medium);
    engine_rig_make(&rig);
    assert_non_null(rig.engine);
    (void)dg_bus_rx(dg_engine_bus(rig.engine, 0), &byte);
    (void)dg_bus_rx(dg_engine_bus(rig.engine, 1), &frame);
    (void)dg_engine_step(rig.engine, DG_S(3));
    for (size_t i = 0; i < rig.plan.encoder_count; i++) {
        assert_false(dg_host_powered(dg_engine_encoder(rig.engine, i)));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_wire_is_its_kind_its_address_and_the_encoders),
        cmocka_unit_test(nobody_is_selected_by_a_name_that_nobody_has),
        cmocka_unit_test(counters_are_those_of_the_medium),
        cmocka_unit_test(cycles_of_a_ring_are_counted),
        cmocka_unit_test(a_host_has_counters_and_addresses_of_its_own),
        cmocka_unit_test(a_profile_is_what_the_shaft_does),
        cmocka_unit_test(a_profile_that_is_none_is_refused_in_words),
        cmocka_unit_test(what_would_be_right_is_said_when_all_of_it_fits),
        cmocka_unit_test(encoders_turn_with_their_own_shaft),
        cmocka_unit_test(a_host_may_play_profiles_of_its_own),
        cmocka_unit_test(a_host_may_look_at_shafts_itself),
        cmocka_unit_test(a_rig_without_a_host_works),
        cmocka_unit_test(instruments_may_be_some_of_them),
        cmocka_unit_test(a_rig_without_power_is_silent),
    };
    return cmocka_run_group_tests_name("engine_said", tests, NULL, NULL);
}
