/* SPDX-License-Identifier: MIT */
/*
 * STATe? of every kind of encoder, in every mode it can be in; asking changes nothing.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "control_rig.h"
#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"

static struct control_rig rig;

static int setup(void **state)
{
    (void)state;
    control_rig_start(&rig);
    return 0;
}

static void choose(const char *name)
{
    char line[32];

    (void)snprintf(line, sizeof line, "INST:SEL %s", name);
    control_rig_expect(&rig, line, "");
}

/* "KEY=VALUE" is a whole part of the answer. */
static bool has(const char *part)
{
    const size_t n = strlen(part);
    const char *at = control_rig_say(&rig, "STAT?");

    while (at != NULL && (strncmp(at, part, n) != 0 || (at[n] != ',' && at[n] != '\0'))) {
        at = strchr(at, ',');
        at = at == NULL ? NULL : at + 1;
    }
    return at != NULL;
}

static void expect(const char *part)
{
    if (!has(part)) {
        fail_msg("%s is not in %s", part, control_rig_say(&rig, "STAT?"));
    }
}

static void wait_ns(dg_ns span)
{
    rig.now += span;
    rig.hf.now = rig.now;
    rig.biss.now = rig.now;
    co_rig_run(&rig.co, rig.now - rig.co.now);
    rig.k3.now = rig.now;
    rig.k2.now = rig.now;
    (void)dg_hf_step(&rig.hf.device, rig.now);
}

static void test_all_have_the_same_beginning(void **state)
{
    static const char *const keys[] = {
        "power=", ",mode=", ",position=", ",leds=", ",errors=", ",frames="};

    (void)state;
    for (size_t i = 0; i < CONTROL_RIG_ENCODERS; i++) {
        choose(rig.encoder[i].name);
        const char *at = control_rig_say(&rig, "STAT?");
        for (size_t k = 0; k < DG_COUNT(keys); k++) {
            const char *next = strstr(at, keys[k]);
            assert_non_null(next);
            at = next;
        }
        expect("power=1");
        control_rig_expect(&rig, "POW OFF", "");
        expect("power=0");
        expect("mode=off");
        expect("position=-");
    }
}

static void test_counters_of_the_port(void **state)
{
    (void)state;
    expect("wire=pty:/dev/pts/4");
    rig.ops.counters = NULL;
    assert_false(has("wire=pty:/dev/pts/4"));
    expect("power=1");
}

/* ------------------------------------------------------------ RS485 */

static void test_rs485(void **state)
{
    (void)state;
    expect("mode=window");
    wait_ns(DG_MS(200));
    expect("mode=on");
    expect("leds=-");
    expect("errors=-");
    expect("address=40");
    expect("baud=9600");
    expect("parity=E");
    expect("locks=00");
    control_rig_expect(&rig, "SHAF:POS 90", "");
    expect("position=16384");
    assert_int_equal(hf_rig_ask(&rig.hf, "42"), 0);
    assert_int_equal(hf_rig_ask(&rig.hf, "43"), 0x0C);
    expect("frames=2");
    expect("replies=2");
    expect("error_replies=1");
    expect("others=0");
    expect("damaged=0");
    expect("interrupted=0");
    expect("deaf=0");
}

/* Communication ends the start-up window before its time (5.1.2.18, R27). */
static void test_rs485_window(void **state)
{
    (void)state;
    expect("mode=window");
    assert_int_equal(hf_rig_ask(&rig.hf, "42"), 0);
    assert_true(rig.hf.now < rig.now + DG_MS(100));
    expect("mode=on");
}

/* A quarter of a turn is 512 whole periods: sine 0, cosine at its peak (4.1.3). */
static void test_rs485_process_channel(void **state)
{
    (void)state;
    control_rig_expect(&rig, "SHAF:POS 90", "");
    expect("sin_plus_uv=2500000");
    expect("sin_minus_uv=2500000");
    expect("cos_plus_uv=2750000");
    expect("cos_minus_uv=2250000");
    control_rig_expect(&rig, "WORL:AMPL:COS 500;:WORL:OFFS:SIN 100", "");
    expect("sin_plus_uv=2525000");
    expect("sin_minus_uv=2475000");
    expect("cos_plus_uv=2625000");
    expect("cos_minus_uv=2375000");
    control_rig_expect(&rig, "POW OFF", "");
    expect("cos_plus_uv=-");
}

static void test_rs485_errors_newest_first(void **state)
{
    (void)state;
    wait_ns(DG_MS(200));
    rig.hf.world.led_current_ua = 40000;
    assert_int_equal(hf_rig_ask(&rig.hf, "52"), 0);
    rig.hf.world.temperature_mdegc = 125000;
    assert_int_equal(hf_rig_ask(&rig.hf, "52"), 0);
    expect("errors=1E/1D");
    expect("errors=1E/1D"); /* asking took nothing off the stack */
}

static void test_rs485_after_a_reset(void **state)
{
    static const uint8_t reset[] = {0x40, 0x53, 0x13};

    (void)state;
    wait_ns(DG_MS(200));
    for (size_t i = 0; i < sizeof reset; i++) {
        rig.now += DG_MS(1);
        (void)dg_hf_rx(&rig.hf.device, rig.now, reset[i], DG_HF_RX_OK);
    }
    wait_ns(DG_MS(10));
    expect("mode=initialising");
    wait_ns(DG_MS(200));
    expect("mode=on");
}

/* ------------------------------------------------------------ BiSS */

static void test_biss(void **state)
{
    (void)state;
    choose("biss-1");
    control_rig_expect(&rig, "SHAF:POS 2.5REV", "");
    expect("mode=initialising");
    expect("position=0");
    expect("nerr=0");
    expect("nwarn=0");
    wait_ns(DG_MS(200));
    expect("mode=idle");
    expect("position=5242880");
    expect("leds=-");
    expect("errors=-");
    expect("nerr=1");
    expect("nwarn=1");
    expect("bank=0");
    expect("life=0");
    assert_int_equal(biss_rig_put(&rig.biss, 0x40, 7), 1);
    rig.now = rig.biss.now;
    expect("bank=7");
    expect("writes=1");
    expect("reads=0");
    expect("refused=0");
    expect("damaged=0");
    expect("commands=0");
    char frames[32];
    (void)snprintf(frames, sizeof frames, "frames=%u", (unsigned)rig.biss.frames);
    expect(frames);
}

static void test_biss_errors(void **state)
{
    (void)state;
    choose("biss-1");
    wait_ns(DG_MS(200));
    rig.biss.world.led_current_ua = 40000;
    rig.biss.world.multiturn_sync_ok = false;
    rig.biss.world.watchdog_fired = true;
    expect("errors=01/08/80");
    expect("nerr=0");
    expect("nwarn=1");
}

static void test_biss_modes(void **state)
{
    (void)state;
    choose("biss-1");
    wait_ns(DG_MS(200));
    biss_rig_zeros(&rig.biss);
    (void)biss_rig_frame(&rig.biss, true);
    rig.now = rig.biss.now;
    expect("mode=control");
    biss_rig_zeros(&rig.biss);
    assert_int_equal(biss_rig_command(&rig.biss, 0, 0), 0);
    rig.now = rig.biss.now;
    expect("mode=channel-off");
}

/* ------------------------------------------------------------ CANopen */

static void test_canopen(void **state)
{
    (void)state;
    choose("can");
    control_rig_expect(&rig, "SHAF:POS 90", "");
    expect("mode=preoperational");
    expect("position=16384");
    expect("leds=bus:blink/err:off");
    expect("errors=-");
    expect("node=63");
    expect("bus_off=0");
    expect("causes=00000000");
    expect("shared_ids=-");
    expect("frames=0");
    expect("sent=2"); /* two boot-up messages: the rig has switched it on twice */
    co_rig_nmt(&rig.co, 0x01);
    expect("mode=operational");
    expect("leds=bus:on/err:off");
    co_rig_nmt(&rig.co, 0x02);
    expect("mode=stopped");
    expect("leds=bus:slow/err:off");
    expect("frames=2");
    expect("malformed=0");
    expect("late_sync=0");
}

static void test_canopen_counts_both_ways(void **state)
{
    (void)state;
    choose("can");
    assert_int_equal(co_rig_get(&rig.co, 0x1018, 1), 0x13);
    assert_int_equal(co_rig_get(&rig.co, 0x1018, 1), 0x13);
    expect("frames=2");
    expect("sent=4");
}

static void test_canopen_errors_and_leds(void **state)
{
    (void)state;
    choose("can");
    wait_ns(DG_MS(200));
    rig.co.world.temperature_mdegc = 125000;
    wait_ns(DG_MS(200));
    expect("errors=4200");
    expect("leds=bus:blink/err:blink");
    rig.co.world.singleturn_ok = false;
    wait_ns(DG_MS(200));
    expect("errors=1000/4200");
    expect("leds=bus:fast/err:fast-other");
    rig.co.world.watchdog_fired = true;
    expect("leds=bus:300ms/err:300ms");
    rig.co.world.watchdog_fired = false;
    rig.co.world.singleturn_ok = true;
    wait_ns(DG_S(5));
    (void)dg_co_bus(&rig.co.node, rig.now, DG_CO_BUS_OFF);
    expect("bus_off=1");
    expect("leds=bus:blink/err:on");
}

/* Without a node-ID only LSS works: it stays in the initialisation. */
static void test_canopen_without_a_node_id(void **state)
{
    static const struct dg_can_frame frames[] = {
        {.id = 0x7E5, .dlc = 8, .data = {0x04, 0x01}},
        {.id = 0x7E5, .dlc = 8, .data = {0x11, 0xFF}},
        {.id = 0x7E5, .dlc = 8, .data = {0x17}},
        {.id = 0x7E5, .dlc = 8, .data = {0x04, 0x00}},
    };

    (void)state;
    choose("can");
    for (size_t i = 0; i < DG_COUNT(frames); i++) {
        (void)dg_co_rx(&rig.co.node, rig.now, &frames[i]);
    }
    control_rig_expect(&rig, "POW CYCL", "");
    expect("mode=init");
    expect("node=255");
}

/* The sample of the bus stays what it was. */
static void test_canopen_asking_takes_no_sample(void **state)
{
    static struct dg_co_node before;

    (void)state;
    choose("can");
    wait_ns(DG_MS(200));
    before = rig.co.node;
    const struct dg_cia406 encoder = rig.co.encoder;
    control_rig_expect(&rig, "SHAF:POS 45", "");
    expect("position=8192");
    assert_memory_equal(&before, &rig.co.node, sizeof before);
    assert_memory_equal(&encoder, &rig.co.encoder, sizeof encoder);
}

/* ------------------------------------------------------------ INTERBUS */

static void run_ib(void)
{
    wait_ns(DG_MS(200));
    (void)ib_rig_cycle(&rig.k3, 0);
    (void)ib_rig_cycle(&rig.k2, 0);
    rig.now = rig.k3.now;
}

static void send_k3(uint32_t out)
{
    (void)ib_rig_send(&rig.k3, out);
    rig.now = rig.k3.now;
}

static void release_k3(void)
{
    (void)ib_rig_release(&rig.k3);
    rig.now = rig.k3.now;
}

static void test_k3_modes(void **state)
{
    (void)state;
    choose("k3");
    control_rig_expect(&rig, "SHAF:POS 90", "");
    expect("mode=self-test");
    run_ib();
    expect("mode=position");
    expect("position=1024");
    expect("errors=-");
    expect("valid=1");
    send_k3(0x20400001);
    expect("mode=parameter");
    expect("last_command=20400001");
    release_k3();
    expect("mode=speed");
    send_k3(0x20800003);
    release_k3();
    expect("mode=cam-3");
    send_k3(0x20210000);
    expect("mode=read-out");
    (void)ib_rig_cycle(&rig.k3, 0);
    (void)ib_rig_cycle(&rig.k3, 0);
    rig.now = rig.k3.now;
    expect("mode=cam-3");
    send_k3(0x20800009);
    expect("errors=84000000");
    expect("refused=1");
    expect("commands=5"); /* three, and two releases */
    release_k3();
    expect("errors=84000000");
    expect("dropped=0");
    expect("presets_unset=0");
    expect("releases_stale=0");
    expect("crc_errors=0");
    expect("frames=28"); /* 1, 4 for each of four commands, 3 for each of three releases, 2 */
}

static void test_k3_cam_programs(void **state)
{
    char mode[16];

    (void)state;
    choose("k3");
    run_ib();
    for (uint32_t program = 1; program <= DG_IB_PROGRAMS; program++) {
        send_k3(0x20800000u + program);
        release_k3();
        (void)snprintf(mode, sizeof mode, "mode=cam-%u", (unsigned)program);
        expect(mode);
    }
}

static void test_k3_lost(void **state)
{
    (void)state;
    choose("k3");
    control_rig_expect(&rig, "NVM:CORR shift;:POW CYCL", "");
    run_ib();
    expect("mode=lost");
}

static void test_k3_leds(void **state)
{
    (void)state;
    choose("k3");
    expect("leds=UL:on/RC:off/BA:off/RD:off");
    run_ib();
    expect("leds=UL:on/RC:on/BA:on/RD:off");
    rig.k3.device.outgoing_off = true;
    wait_ns(DG_S(1));
    (void)dg_ib_id(&rig.k3.device, rig.now);
    expect("leds=UL:on/RC:on/BA:blink/RD:on");
    control_rig_expect(&rig, "POW OFF", "");
    expect("leds=UL:off/RC:off/BA:off/RD:off");
}

static void test_k2(void **state)
{
    (void)state;
    choose("k2");
    expect("mode=self-test");
    run_ib();
    expect("mode=position");
    expect("errors=-");
    control_rig_expect(&rig, "FAUL:SET singleturn_lost", "");
    (void)ib_rig_cycle(&rig.k2, 0);
    expect("errors=2000");
    expect("valid=0");
}

/* ------------------------------------------------------------ encoders */

static void test_targets(void **state)
{
    (void)state;
    for (size_t i = 0; i < CONTROL_RIG_ENCODERS; i++) {
        const struct dg_fault_target target = dg_encoder_target(&rig.encoder[i]);
        assert_ptr_equal(target.instrument->stack, rig.encoder[i].model->stack);
        assert_true((target.layout == NULL) == (i == CONTROL_RIG_K2));
        assert_false(target.singleturn);
    }
    rig.encoder[CONTROL_RIG_HF].nvm.ops = NULL;
    assert_null(dg_encoder_target(&rig.encoder[CONTROL_RIG_HF]).layout);
    assert_int_equal(dg_encoder_format(&rig.encoder[CONTROL_RIG_K2]), DG_OK);
}

/* The figures of the device count, whatever the catalogue says of its model. */
static void test_target_of_other_figures(void **state)
{
    struct dg_hf_model model = *rig.hf.device.setup.model;

    (void)state;
    model.turns = 1;
    rig.hf.device.setup.model = &model;
    assert_true(dg_encoder_target(&rig.encoder[CONTROL_RIG_HF]).singleturn);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_all_have_the_same_beginning, setup),
        cmocka_unit_test_setup(test_counters_of_the_port, setup),
        cmocka_unit_test_setup(test_rs485, setup),
        cmocka_unit_test_setup(test_rs485_window, setup),
        cmocka_unit_test_setup(test_rs485_process_channel, setup),
        cmocka_unit_test_setup(test_rs485_errors_newest_first, setup),
        cmocka_unit_test_setup(test_rs485_after_a_reset, setup),
        cmocka_unit_test_setup(test_biss, setup),
        cmocka_unit_test_setup(test_biss_errors, setup),
        cmocka_unit_test_setup(test_biss_modes, setup),
        cmocka_unit_test_setup(test_canopen, setup),
        cmocka_unit_test_setup(test_canopen_counts_both_ways, setup),
        cmocka_unit_test_setup(test_canopen_errors_and_leds, setup),
        cmocka_unit_test_setup(test_canopen_without_a_node_id, setup),
        cmocka_unit_test_setup(test_canopen_asking_takes_no_sample, setup),
        cmocka_unit_test_setup(test_k3_modes, setup),
        cmocka_unit_test_setup(test_k3_cam_programs, setup),
        cmocka_unit_test_setup(test_k3_lost, setup),
        cmocka_unit_test_setup(test_k3_leds, setup),
        cmocka_unit_test_setup(test_k2, setup),
        cmocka_unit_test_setup(test_targets, setup),
        cmocka_unit_test_setup(test_target_of_other_figures, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
