/* SPDX-License-Identifier: MIT */
/* Clocks of 50 kHz to 10 MHz on the simulated BiSS wire, and cables that delay it. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sim_rig.h"

/* e1, e2, start bit, CDS, data; a busy time adds to them. */
#define CLOCKS (4u + SIM_RIG_DATA_BITS)

/* --- clocks and cables --- */

/* `timing` has settings of the wire with blanks between them. */
static void add_timings(struct sim_rig *self, const char *timings, unsigned line)
{
    char words[128];
    char *rest = NULL;
    struct lx_error error;
    (void)snprintf(words, sizeof words, "%s", timings);
    for (char *word = strtok_r(words, " ", &rest); word != NULL;
         word = strtok_r(NULL, " ", &rest)) {
        assert_int_equal(lx_plan_add_assignment(&self->plan.wires[0].settings, word, line, &error),
                         0);
    }
}

static void open_timed(struct sim_rig *self, size_t count, const char *timings)
{
    sim_rig_plan(self, count);
    add_timings(self, timings, 0);
    sim_rig_open(self);
}

/* A frame from each encoder, and its serial number. */
static void assert_all_answer(struct sim_rig *self, unsigned turn)
{
    uint8_t bytes[8];
    for (size_t i = 0; i < self->plan.encoder_count; i++) {
        self->shaft[i] = ((dg_angle)(turn + i) << 32) + ((dg_angle)turn * 0x1234567);
    }
    const uint64_t part = (uint64_t)turn * 0x1234567u >> 11;
    for (size_t i = 0; i < self->plan.encoder_count; i++) {
        assert_int_equal(sim_rig_frame(self, i), 0);
        assert_true(sim_rig_crc_ok(self));
        assert_int_equal(sim_rig_position(self), (turn + i) * SIM_RIG_COUNTS_PER_TURN + part);
        assert_int_equal(sim_rig_read(self, i, 0x78, bytes, sizeof bytes), 0);
        assert_int_equal(bytes[7], 0x55);
    }
}

static void every_clock_and_cable_gives_the_right_position(void **state)
{
    static const char *const timings[] = {
        "clock_hz=50000",
        "clock_hz=50000 line_delay_ns=5000",
        "clock_hz=76923 line_delay_ns=999",
        "line_delay_ns=200",
        "line_delay_ns=500", /* there and back: one clock */
        "clock_hz=3000000 line_delay_ns=1234",
        "clock_hz=9999999 line_delay_ns=1",
        "clock_hz=10000000",
        "clock_hz=10000000 line_delay_ns=25", /* half a clock */
        "clock_hz=10000000 line_delay_ns=200",
        "clock_hz=10000000 line_delay_ns=5000", /* longer than the frame */
        "compensate=0 line_delay_ns=250",       /* half a clock */
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(timings); i++) {
        struct sim_rig rig;
        open_timed(&rig, 1, timings[i]);
        for (unsigned turn = 0; turn < 6; turn++) {
            assert_all_answer(&rig, turn);
        }
        sim_rig_close(&rig);
        open_timed(&rig, 3, timings[i]);
        assert_all_answer(&rig, 3);
        sim_rig_close(&rig);
    }
}

/* Of the frame whose levels were kept: rising edge `n` of MA, 1 is e1. */
static dg_ns rising(const struct sim_rig *self, unsigned n)
{
    bool before = true;
    for (size_t i = 0; i < self->heard.count; i++) {
        n -= self->heard.level[i].ma && !before;
        before = self->heard.level[i].ma;
        if (n == 0) {
            return self->heard.level[i].at;
        }
    }
    fail();
    return 0;
}

/* The first time that SLO gets to `level` after `since`. */
static dg_ns slo_gets(const struct sim_rig *self, bool level, dg_ns since)
{
    for (size_t i = 0; i < self->heard.count; i++) {
        if (self->heard.level[i].at >= since && self->heard.level[i].slo == level) {
            return self->heard.level[i].at;
        }
    }
    fail();
    return 0;
}

/* The levels are those at the master's end. */
static void a_cable_delays_slo(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_timed(&rig, 1, "clock_hz=10000000 line_delay_ns=200");
    assert_non_null(strstr(rig.heard.note, "CRC ok, line delay 400 ns"));
    do { /* one whose last bit is low, so that the end of the timeout is seen */
        rig.heard.count = 0;
        assert_int_equal(sim_rig_frame(&rig, 0), 0);
    } while ((rig.bits & 1u) != 0);
    const dg_ns e2 = rising(&rig, 2);
    assert_int_equal(e2, rising(&rig, 1) + 100u);
    assert_int_equal(slo_gets(&rig, false, e2), e2 + 400u);
    const dg_ns start = slo_gets(&rig, true, e2 + 400u);
    assert_int_equal((start - e2) % 100u, 0);
    /* All clocks and no more: the master knew of the start bit early enough. */
    const dg_ns last = e2 + (start - e2 - 400u) + (dg_ns)100 * (CLOCKS - 3u);
    assert_int_equal(rising(&rig, (unsigned)((last - e2) / 100u) + 2u), last);
    assert_int_equal(slo_gets(&rig, true, last + 500u), last + 13000u + 400u);
    assert_int_equal(rig.heard.level[rig.heard.count - 1u].at, last + 13000u + 400u);
    sim_rig_close(&rig);
}

static void without_a_cable_there_is_no_delay(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_timed(&rig, 1, "clock_hz=3000000");
    assert_null(strstr(rig.heard.note, "delay"));
    rig.heard.count = 0;
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    const dg_ns e2 = rising(&rig, 2);
    assert_int_equal(slo_gets(&rig, false, e2), e2);
    /* No whole nanoseconds, and yet three clocks are a microsecond. */
    for (unsigned i = 3; i < 48; i += 3) {
        const dg_ns span = rising(&rig, i + 2u) - e2;
        assert_in_range(span, i * 1000u / 3u - 1u, i * 1000u / 3u + 1u);
    }
    sim_rig_close(&rig);
}

static void faults_behind_a_cable(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_timed(&rig, 1, "clock_hz=10000000 line_delay_ns=777");
    sim_rig_bend(&rig, 0, DG_WIRE_DROP, 1);
    assert_int_equal(sim_rig_frame(&rig, 0), DG_SCPI_HARDWARE);
    assert_string_equal(rig.heard.note, "no answer");
    assert_all_answer(&rig, 5);
    sim_rig_bend(&rig, 0, DG_WIRE_DELAY, 1);
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    assert_true(sim_rig_crc_ok(&rig));
    sim_rig_bend(&rig, 0, DG_WIRE_DAMAGE, 1);
    assert_int_equal(sim_rig_frame(&rig, 0), 0);
    assert_false(sim_rig_crc_ok(&rig));
    sim_rig_bend(&rig, 0, DG_WIRE_BREAK, 0);
    assert_int_equal(sim_rig_frame(&rig, 0), DG_SCPI_HARDWARE);
    rig.station[0].control->faults = (struct dg_faults){0};
    assert_all_answer(&rig, 6);
    sim_rig_close(&rig);
}

/* Power that comes and goes while the clock stands still: more changes than a cable holds. */
static void power_behind_a_cable(void **state)
{
    struct sim_rig rig;
    (void)state;
    open_timed(&rig, 1, "clock_hz=10000000 line_delay_ns=5000");
    struct dg_biss *device = rig.station[0].control->device;
    for (unsigned i = 0; i < 250; i++) {
        sim_rig_bend(&rig, 0, DG_WIRE_BREAK, 0);
        sim_rig_step_to(&rig, SIM_RIG_READY);
        dg_biss_power_off(device);
        rig.station[0].control->faults = (struct dg_faults){0};
        sim_rig_step_to(&rig, SIM_RIG_READY);
        assert_int_equal(dg_biss_power_on(device, SIM_RIG_READY), DG_OK);
        sim_rig_step_to(&rig, SIM_RIG_READY);
    }
    sim_rig_step_to(&rig, SIM_RIG_READY + DG_MS(150));
    assert_all_answer(&rig, 7);
    sim_rig_close(&rig);
}

static void timings_out_of_range_are_refused(void **state)
{
    static const char *const rows[][2] = {
        {"clock_hz=49999", "rig.ini:4: clock_hz=49999: expected a number in 50000..10000000 Hz"},
        {"clock_hz=10000001",
         "rig.ini:4: clock_hz=10000001: expected a number in 50000..10000000 Hz"},
        {"clock_hz=fast", "rig.ini:4: clock_hz=fast: expected a number in 50000..10000000 Hz"},
        {"line_delay_ns=5001", "rig.ini:4: line_delay_ns=5001: expected a number in 0..5000 ns"},
        {"line_delay_ns=", "rig.ini:4: line_delay_ns=: expected a number in 0..5000 ns"},
        {"compensate=0 line_delay_ns=251",
         "rig.ini:4: compensate=0: the way there and back, 502 ns, is longer than half a period of "
         "1000000 Hz; expected clock_hz up to 996015"},
        {"line_delay_ns=5000 compensate=0 clock_hz=50001",
         "rig.ini:4: compensate=0: the way there and back, 10000 ns, is longer than half a period "
         "of 50001 Hz; expected clock_hz up to 50000"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct sim_rig rig;
        sim_rig_plan(&rig, 1);
        rig.plan.file = "rig.ini";
        add_timings(&rig, rows[i][0], 4);
        sim_rig_prepare(&rig);
        assert_string_equal(sim_rig_refused(&rig).text, rows[i][1]);
        rig.event = sd_event_unref(rig.event);
        plan_rig_free(&rig.plan);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_clock_and_cable_gives_the_right_position),
        cmocka_unit_test(a_cable_delays_slo),
        cmocka_unit_test(without_a_cable_there_is_no_delay),
        cmocka_unit_test(faults_behind_a_cable),
        cmocka_unit_test(power_behind_a_cable),
        cmocka_unit_test(timings_out_of_range_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
