/* SPDX-License-Identifier: MIT */
/* BiSS encoders on the simulated wire, in a clock that stands still until the test steps it. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "descriptors.h"
#include "sim_rig.h"
#include "timer.h"

static void open_one(struct sim_rig *self)
{
    sim_rig_plan(self, 1);
    sim_rig_open(self);
}

/* --- the clock --- */

static void frames_come_by_the_rigs_clock(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_one(&rig);
    assert_int_equal(rig.heard.notes, 1);
    assert_string_equal(rig.heard.note, "position 0:0 nERR 1 nWARN 1 LC 0 CRC ok");
    assert_true(rig.heard.edges > 2 * SIM_RIG_DATA_BITS);
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_MS(50));
    assert_int_equal(rig.heard.notes, 1);
    rig.shaft[0] = (dg_angle)5 << 31; /* 2.5 turns */
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_MS(100));
    assert_int_equal(rig.heard.notes, 2);
    assert_string_equal(rig.heard.note, "position 2:1048576 nERR 1 nWARN 1 LC 1 CRC ok");
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_MS(1100));
    assert_int_equal(rig.heard.notes, 12);
    sim_rig_close(&rig);
}

/* It stands still: nothing happens in real time. */
static void a_clock_that_stands_still_reads_nothing(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_one(&rig);
    const dg_ns end = lx_now() + DG_MS(150);
    while (lx_now() < end) {
        (void)sd_event_run(rig.event, 20000);
    }
    assert_int_equal(rig.heard.notes, 1);
    sim_rig_close(&rig);
}

static void a_clock_that_runs_reads_by_itself(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_one(&rig);
    rig.clock = (struct lx_clock){lx_now(), SIM_RIG_READY, 10000}; /* ten times as fast */
    rig.bus->ops->changed(rig.bus, NULL, SIM_RIG_READY);
    const dg_ns end = lx_now() + DG_S(5);
    while (rig.heard.notes < 11 && lx_now() < end) {
        (void)sd_event_run(rig.event, 20000);
    }
    assert_true(rig.heard.notes >= 11);
    sim_rig_close(&rig);
}

static void after_a_long_step_old_frames_are_left_out(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_one(&rig);
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_S(3600));
    assert_in_range(rig.heard.notes, 1000, 1003);
    assert_true(rig.heard.last >= SIM_RIG_READY + DG_S(3600) - DG_MS(101));
    sim_rig_close(&rig);
}

/* As many as if somebody had listened, and their end as well. */
static void frames_that_nobody_sees_are_counted(void **state)
{
    const dg_ns end = SIM_RIG_READY + DG_MS(50) + DG_S(90);
    uint64_t bits[2];
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        struct sim_rig rig;
        open_one(&rig);
        const struct dg_biss *device = rig.station[0].control->device;
        if (i == 1) {
            lx_tap_remove(&rig.bus->tap, &rig.heard.listener);
        }
        rig.shaft[0] = (dg_angle)3 << 31;
        sim_rig_step_to(&rig, end);
        assert_int_equal(device->counters.frames, 901);
        assert_in_range(end - device->line.last, DG_MS(50), DG_MS(51)); /* it was clocked */
        assert_int_equal(sim_rig_frame(&rig, 0), 0);
        bits[i] = rig.bits;
        sim_rig_close(&rig);
    }
    assert_int_equal(bits[0], bits[1]);
}

/* Nobody listens: the loop has nothing to do, and whoever looks finds what has gone by. */
static void a_wire_that_nobody_looks_at_sleeps(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_one(&rig);
    const struct dg_biss *device = rig.station[0].control->device;
    lx_tap_remove(&rig.bus->tap, &rig.heard.listener);
    rig.clock = (struct lx_clock){lx_now(), SIM_RIG_READY, 100000}; /* a frame each millisecond */
    rig.bus->ops->changed(rig.bus, rig.station, SIM_RIG_READY);
    while (sd_event_run(rig.event, 200000) > 0) {
    }
    const uint32_t before = device->counters.frames;
    const dg_ns now = lx_clock_now(&rig.clock);
    rig.bus->ops->look(rig.bus, now);
    assert_true(device->counters.frames > before + 100u);
    assert_true(device->counters.frames >= (now - SIM_RIG_READY) / DG_MS(100));
    sim_rig_close(&rig);
}

/* A fault happens to each frame at its moment, seen or not. */
static void a_fault_is_used_up_by_frames_that_nobody_sees(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_one(&rig);
    const struct dg_faults *faults = &rig.station[0].control->faults;
    lx_tap_remove(&rig.bus->tap, &rig.heard.listener);
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_S(10));
    sim_rig_bend(&rig, 0, DG_WIRE_DAMAGE, 3);
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_MS(10250));
    assert_int_not_equal(faults->wire, 0);
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_MS(10350));
    assert_int_equal(faults->wire, 0);
    sim_rig_close(&rig);
}

/* A long access takes wire time; the frames that were due meanwhile wait for it. */
static void time_never_runs_backwards(void **state)
{
    struct sim_rig rig;
    uint8_t bytes[64];
    const uint8_t bank = 7;
    (void)state;
    open_one(&rig);
    const struct dg_biss *device = rig.station[0].control->device;
    assert_int_equal(sim_rig_write(&rig, 0, 0x40, &bank, 1), 0);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(sim_rig_read(&rig, 0, 0x00, bytes, sizeof bytes), 0);
    }
    const dg_ns ahead = device->line.last;
    assert_true(ahead > SIM_RIG_READY + DG_MS(100));
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    assert_true(device->line.last > ahead);
    const unsigned notes = rig.heard.notes;
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_MS(100));
    assert_int_equal(rig.heard.notes, notes); /* still ahead */
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_S(1));
    assert_true(rig.heard.notes > notes);
    sim_rig_close(&rig);
}

/* --- frames and registers --- */

static void a_frame_on_request(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_one(&rig);
    rig.shaft[0] = (dg_angle)3 << 32;
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    assert_int_equal(rig.count, SIM_RIG_DATA_BITS + 1);
    assert_int_equal(sim_rig_position(&rig), 3 * SIM_RIG_COUNTS_PER_TURN);
    assert_true(sim_rig_crc_ok(&rig));
    sim_rig_close(&rig);
}

static void registers_can_be_read_and_written(void **state)
{
    static const uint8_t id[] = {0x04, 0x00, 0xC0, 0x15, 0x0C, 0x00, 0x4B, 0x55};
    const uint8_t bank = 7;
    const uint8_t data[] = {0xA5, 0x5A};
    struct sim_rig rig;
    uint8_t bytes[8];
    (void)state;
    open_one(&rig);
    assert_int_equal(sim_rig_read(&rig, 0, 0x78, bytes, 8), 0);
    assert_memory_equal(bytes, id, 2);
    assert_memory_equal(bytes + 6, id + 6, 2); /* between them are figures of the model */
    assert_non_null(strstr(rig.heard.note, "register 78h = 04 00 "));
    assert_int_equal(sim_rig_write(&rig, 0, 0x40, &bank, 1), 0);
    assert_int_equal(sim_rig_write(&rig, 0, 3, data, 2), 0);
    assert_int_equal(sim_rig_read(&rig, 0, 3, bytes, 2), 0);
    assert_memory_equal(bytes, data, 2);
    assert_int_equal(sim_rig_write(&rig, 0, 0x78, data, 1), DG_SCPI_HARDWARE);
    assert_non_null(strstr(rig.detail, "register 78h: refused"));
    sim_rig_close(&rig);
}

static void without_power_there_is_no_answer(void **state)
{
    struct sim_rig rig;
    uint8_t byte = 0;
    (void)state;
    open_one(&rig);
    struct dg_biss *device = rig.station[0].control->device;
    dg_biss_power_off(device);
    rig.bus->ops->changed(rig.bus, rig.station, SIM_RIG_READY);
    assert_int_equal(sim_rig_frame(&rig, 0), DG_SCPI_HARDWARE);
    assert_string_equal(rig.heard.note, "no answer");
    assert_int_equal(sim_rig_read(&rig, 0, 0x78, &byte, 1), DG_SCPI_HARDWARE);
    assert_int_equal(dg_biss_power_on(device, SIM_RIG_READY), DG_OK);
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_MS(150));
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    assert_true(sim_rig_crc_ok(&rig));
    sim_rig_close(&rig);
}

/* Eight on one wire: each has its data and its registers, also the ones behind others. */
static void a_chain_of_eight(void **state)
{
    struct sim_rig rig;
    uint8_t serial[4];
    (void)state;
    sim_rig_plan(&rig, SIM_RIG_ENCODERS_MAX);
    for (size_t i = 0; i < SIM_RIG_ENCODERS_MAX; i++) {
        char digits[8];
        (void)snprintf(digits, sizeof digits, "%zu", 100 + i);
        rig.plan.encoders[i].serial = dg_plan_copy(&rig.plan, digits);
    }
    sim_rig_open(&rig);
    for (size_t i = 0; i < SIM_RIG_ENCODERS_MAX; i++) {
        rig.shaft[i] = (dg_angle)(i + 1) << 32;
    }
    for (size_t i = 0; i < SIM_RIG_ENCODERS_MAX; i++) {
        assert_int_equal(sim_rig_frame(&rig, i), 0);
        assert_int_equal(sim_rig_position(&rig), (i + 1) * SIM_RIG_COUNTS_PER_TURN);
        assert_true(sim_rig_crc_ok(&rig));
        assert_int_equal(sim_rig_read(&rig, i, 0x44, serial, sizeof serial), 0);
        assert_int_equal(serial[3], 100 + i);
    }
    assert_non_null(strstr(rig.heard.note, "b7: register 44h = 00 00 00 6B"));
    sim_rig_close(&rig);
}

/* --- faults --- */

static void a_dropped_frame_has_no_ack(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_one(&rig);
    sim_rig_bend(&rig, 0, DG_WIRE_DROP, 1);
    assert_int_equal(sim_rig_frame(&rig, 0), DG_SCPI_HARDWARE);
    assert_string_equal(rig.detail, "no answer");
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    assert_true(sim_rig_crc_ok(&rig));
    sim_rig_close(&rig);
}

/* It sends no frame that could be dropped: the fault waits for one. */
static void without_power_no_fault_is_used_up(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_one(&rig);
    struct dg_biss *device = rig.station[0].control->device;
    sim_rig_bend(&rig, 0, DG_WIRE_DROP, 1);
    dg_biss_power_off(device);
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_MS(250));
    assert_int_equal(dg_biss_power_on(device, SIM_RIG_READY + DG_MS(250)), DG_OK);
    assert_int_equal(sim_rig_frame(&rig, 0), DG_SCPI_HARDWARE);
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    assert_true(sim_rig_crc_ok(&rig));
    sim_rig_close(&rig);
}

static void a_damaged_frame_has_a_wrong_crc(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_one(&rig);
    rig.shaft[0] = (dg_angle)1000 << 32;
    for (int i = 0; i < 200; i++) {
        sim_rig_bend(&rig, 0, DG_WIRE_DAMAGE, 1);
        assert_int_equal(sim_rig_frame(&rig, 0), 0);
        assert_false(sim_rig_crc_ok(&rig));
        assert_int_equal(sim_rig_frame(&rig, 0), 0);
        assert_true(sim_rig_crc_ok(&rig));
        assert_int_equal(sim_rig_position(&rig), 1000 * SIM_RIG_COUNTS_PER_TURN);
    }
    sim_rig_close(&rig);
}

static void a_delayed_frame_has_a_late_start_bit(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_one(&rig);
    rig.shaft[0] = (dg_angle)7 << 32;
    sim_rig_bend(&rig, 0, DG_WIRE_DELAY, 1);
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    assert_true(sim_rig_crc_ok(&rig));
    assert_int_equal(sim_rig_position(&rig), 7 * SIM_RIG_COUNTS_PER_TURN);
    assert_non_null(strstr(rig.heard.note, "start bit after 10"));
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    assert_null(strstr(rig.heard.note, "start bit"));
    sim_rig_close(&rig);
}

static void a_cut_wire_reads_high(void **state)
{
    struct sim_rig rig;
    uint8_t byte = 0;
    (void)state;
    open_one(&rig);
    sim_rig_bend(&rig, 0, DG_WIRE_BREAK, 0);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(sim_rig_frame(&rig, 0), DG_SCPI_HARDWARE);
    }
    assert_int_equal(sim_rig_read(&rig, 0, 0x78, &byte, 1), DG_SCPI_HARDWARE);
    rig.station[0].control->faults = (struct dg_faults){0};
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    assert_true(sim_rig_crc_ok(&rig));
    sim_rig_close(&rig);
}

/* A fault of one encoder of a chain does not touch what its neighbours send. */
static void in_a_chain_a_damage_is_one_encoders(void **state)
{
    struct sim_rig rig;
    (void)state;
    sim_rig_plan(&rig, 3);
    sim_rig_open(&rig);
    for (size_t i = 0; i < 3; i++) {
        sim_rig_bend(&rig, 1, DG_WIRE_DAMAGE, 1);
        assert_int_equal(sim_rig_frame(&rig, i), 0);
        assert_int_equal(sim_rig_crc_ok(&rig), i != 1);
    }
    sim_rig_bend(&rig, 2, DG_WIRE_DELAY, 3);
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(sim_rig_frame(&rig, i), 0);
        assert_true(sim_rig_crc_ok(&rig));
    }
    sim_rig_close(&rig);
}

/* --- plans --- */

static void what_does_not_fit_is_refused(void **state)
{
    static const struct {
        const char *setting;
        const char *serial;
        const char *says;
    } rows[] = {
        {"mt=33", NULL, "rig.ini:7: mt=33: expected a number in 0..32"},
        {"lines=0", NULL, "rig.ini:7: lines: no such key"},
        {NULL, "x", "rig.ini:9: serial x: expected a number in 0..4294967295"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct sim_rig rig;
        struct lx_error error = {.right = ""};
        sim_rig_plan(&rig, 1);
        struct dg_plan_encoder *encoder = rig.plan.encoders;
        rig.plan.file = "rig.ini";
        encoder->serial_line = 9;
        if (rows[i].setting != NULL) {
            (void)lx_plan_add_assignment(&encoder->settings, rows[i].setting, 7, &error);
        }
        encoder->serial = rows[i].serial;
        sim_rig_prepare(&rig);
        assert_non_null(strstr(sim_rig_refused(&rig).text, rows[i].says));
        rig.event = sd_event_unref(rig.event);
        plan_rig_free(&rig.plan);
    }
}

static void settings_reach_the_station(void **state)
{
    struct sim_rig rig;
    struct lx_error error;
    (void)state;
    sim_rig_plan(&rig, 1);
    struct dg_plan_settings *settings = &rig.plan.encoders[0].settings;
    assert_int_equal(lx_plan_add_assignment(settings, "temperature=85", 0, &error), 0);
    assert_int_equal(lx_plan_add_assignment(settings, "st=20", 0, &error), 0);
    assert_int_equal(lx_plan_add_assignment(settings, "lc=0", 0, &error), 0);
    assert_int_equal(lx_plan_add_assignment(settings, "busy_us=30", 0, &error), 0);
    sim_rig_open(&rig);
    assert_int_equal(rig.station[0].control->world->temperature_mdegc, 85000);
    assert_ptr_equal(rig.station[0].control->world->angle_ctx, &rig.shaft[0]);
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    assert_int_equal(rig.count, SIM_RIG_DATA_BITS + 1 - 1 - 6);
    const struct dg_biss *device = rig.station[0].control->device;
    assert_true(device->setup.model->busy == DG_US(30));
    sim_rig_close(&rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_come_by_the_rigs_clock),
        cmocka_unit_test(a_clock_that_stands_still_reads_nothing),
        cmocka_unit_test(a_clock_that_runs_reads_by_itself),
        cmocka_unit_test(after_a_long_step_old_frames_are_left_out),
        cmocka_unit_test(frames_that_nobody_sees_are_counted),
        cmocka_unit_test(a_wire_that_nobody_looks_at_sleeps),
        cmocka_unit_test(a_fault_is_used_up_by_frames_that_nobody_sees),
        cmocka_unit_test(time_never_runs_backwards),
        cmocka_unit_test(a_frame_on_request),
        cmocka_unit_test(registers_can_be_read_and_written),
        cmocka_unit_test(without_power_there_is_no_answer),
        cmocka_unit_test(a_chain_of_eight),
        cmocka_unit_test(a_dropped_frame_has_no_ack),
        cmocka_unit_test(without_power_no_fault_is_used_up),
        cmocka_unit_test(a_damaged_frame_has_a_wrong_crc),
        cmocka_unit_test(a_delayed_frame_has_a_late_start_bit),
        cmocka_unit_test(a_cut_wire_reads_high),
        cmocka_unit_test(in_a_chain_a_damage_is_one_encoders),
        cmocka_unit_test(what_does_not_fit_is_refused),
        cmocka_unit_test(settings_reach_the_station),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
