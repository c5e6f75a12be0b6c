/* SPDX-License-Identifier: MIT */
/* RS485 encoders on one line: who hears what, power, the tap, plans. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "hf_rig.h"
#include "line_rig.h"
#include "serial.h"
#include "timer.h"

static void set_speed(struct line_rig *self, uint32_t baud)
{
    struct termios line;
    const speed_t speed = (speed_t)lx_speed_of_baud(baud);
    assert_int_equal(tcgetattr(self->master, &line), 0);
    assert_int_equal(cfsetispeed(&line, speed) | cfsetospeed(&line, speed), 0);
    assert_int_equal(tcsetattr(self->master, TCSANOW, &line), 0);
}

/* --- multi-drop --- */

static void every_encoder_answers_at_its_address(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, LINE_STATIONS_MAX, NULL);
    for (size_t i = 0; i < LINE_STATIONS_MAX; i++) {
        line_rig_set(&rig, i, "pace=0");
    }
    line_rig_open_pty(&rig);
    rig.shaft = (dg_angle)5 << 32;
    for (uint8_t i = 0; i < LINE_STATIONS_MAX; i++) {
        line_rig_answers(&rig, (uint8_t)(0x40 + i));
        assert_int_equal(rig.reply[3], 5); /* 5 * 65536 */
    }
    rig.shaft = 0;
    line_rig_close(&rig);
}

static void a_changed_address_is_only_its_own(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 3, NULL);
    line_rig_open_pty(&rig);
    line_rig_request(&rig, 0x41, "55 5E 55");
    assert_int_equal(line_rig_receive(&rig, 3, LINE_PATIENCE), 3);
    assert_int_equal(rig.reply[0], 0x5E);
    line_rig_silent(&rig, 0x41);
    line_rig_answers(&rig, 0x5E);
    line_rig_answers(&rig, 0x40);
    line_rig_answers(&rig, 0x42);
    line_rig_close(&rig);
}

/* 19200 Bd, 8E1, long timeout: 57h, then a reset. The others hear noise then. */
static void a_changed_data_rate_is_only_its_own(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 3, NULL);
    line_rig_open_pty(&rig);
    (void)line_rig_ask(&rig, 0x41, "57 E5 55", 4);
    line_rig_request(&rig, 0x41, "53");
    line_rig_run(&rig, DG_MS(120));
    line_rig_silent(&rig, 0x41);
    line_rig_answers(&rig, 0x42);
    const uint32_t damaged = line_rig_device(&rig, 2)->counters.damaged;
    const uint32_t heard_damaged = line_rig_device(&rig, 1)->counters.damaged;
    set_speed(&rig, 19200);
    line_rig_answers(&rig, 0x41);
    /* 3 characters of the master and 7 of the reply */
    assert_int_equal(line_rig_device(&rig, 2)->counters.damaged - damaged, 10);
    assert_int_equal(line_rig_device(&rig, 1)->counters.damaged, heard_damaged);
    line_rig_silent(&rig, 0x42);
    line_rig_close(&rig);
}

/* Everybody hears the master and the others, nobody itself. */
static void encoders_hear_each_other(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 2, NULL);
    line_rig_open_pty(&rig);
    line_rig_answers(&rig, 0x40);
    assert_int_equal(line_rig_device(&rig, 0)->counters.frames, 1);
    assert_int_equal(line_rig_device(&rig, 0)->counters.others, 0);
    assert_int_equal(line_rig_device(&rig, 1)->counters.others, 2); /* the request and the reply */
    assert_int_equal(line_rig_device(&rig, 1)->counters.damaged, 0);
    line_rig_answers(&rig, 0x41);
    line_rig_close(&rig);
}

/* The same address twice: both answer at the same time, and the line carries the AND. */
static void replies_at_the_same_time_collide(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 3, NULL);
    rig.plan.encoders[1].address = 0x40;
    line_rig_open_pty(&rig);
    lx_tap_add(&rig.bus->tap, &rig.heard.listener);
    rig.station[1].control->world->angle_ctx = &(dg_angle){(dg_angle)0x00FF << 32};
    rig.shaft = (dg_angle)0x0F0F << 32;
    line_rig_request(&rig, 0x40, LINE_READ_POSITION);
    (void)line_rig_receive(&rig, 7, LINE_PATIENCE);
    const size_t n = line_rig_receive(&rig, 14, DG_MS(100));
    /* What began later is lost in what ends first: between one reply and both of them. */
    assert_in_range(n, 7, 13);
    assert_true(rig.heard.damaged > 0);
    assert_false(rig.heard.disordered);
    if (n == 7) {
        assert_int_equal(rig.reply[3] & 0x0F, 0x0F);
        assert_int_equal(rig.reply[3] & 0xF0, 0);
    }
    assert_true(line_rig_device(&rig, 2)->counters.damaged > 0);
    rig.shaft = 0;
    lx_tap_remove(&rig.bus->tap, &rig.heard.listener);
    line_rig_close(&rig);
}

/* A reply of 40 characters, and a request into it. @return whether it came in time: a machine that
   stands still lets the encoder read it when the reply is over */
static bool talk_into_a_reply(struct line_rig *rig)
{
    static const uint8_t frame[] = {0x40, 0x42, 0x02};
    const struct dg_hf *other = line_rig_device(rig, 1);
    const uint32_t damaged = other->counters.damaged;
    line_rig_request(rig, 0x40, "56");
    assert_true(line_rig_receive(rig, 3, LINE_PATIENCE) >= 3);
    assert_int_equal(write(rig->master, frame, sizeof frame), sizeof frame);
    (void)line_rig_receive(rig, 40, LINE_PATIENCE);
    (void)line_rig_receive(rig, 41, DG_MS(20));
    return other->counters.damaged - damaged == 3;
}

static void a_request_into_a_reply_is_lost(void **state)
{
    struct line_rig rig;
    int attempts = 20;
    (void)state;
    line_rig_plan(&rig, 2, NULL);
    line_rig_open_pty(&rig);
    while (!talk_into_a_reply(&rig)) {
        assert_true(--attempts > 0);
        line_rig_run(&rig, DG_MS(100));
    }
    assert_int_equal(rig.length, 40); /* the first reply only, undamaged */
    assert_int_equal(hf_rig_xor(rig.reply, 40), 0);
    line_rig_close(&rig);
}

/* --- power, tap, counters --- */

static void without_power_it_is_silent_and_deaf(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 2, NULL);
    line_rig_open_pty(&rig);
    for (int i = 0; i == 0 || (i < 20 && rig.length == 40); i++) { /* in the middle of a reply */
        line_rig_request(&rig, 0x40, "56");
        assert_true(line_rig_receive(&rig, 3, LINE_PATIENCE) >= 3);
    }
    dg_hf_power_off(line_rig_device(&rig, 0));
    line_rig_changed(&rig, 0);
    const size_t n = line_rig_receive(&rig, 40, LINE_SILENCE);
    assert_true(n < 40);
    line_rig_silent(&rig, 0x40);
    line_rig_answers(&rig, 0x41);
    assert_int_equal(dg_hf_power_on(line_rig_device(&rig, 0), lx_now()), DG_OK);
    line_rig_changed(&rig, 0);
    line_rig_run(&rig, DG_MS(110));
    line_rig_answers(&rig, 0x40);
    line_rig_close(&rig);
}

static void the_tap_hears_both_directions(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 1, NULL);
    line_rig_open_pty(&rig);
    lx_tap_add(&rig.bus->tap, &rig.heard.listener);
    line_rig_answers(&rig, 0x40);
    assert_int_equal(rig.heard.count, 10);
    assert_int_equal(rig.heard.ours, 7);
    assert_int_equal(rig.heard.damaged, 0);
    assert_false(rig.heard.disordered);
    assert_memory_equal(rig.heard.bytes, "\x40\x42\x02", 3);
    assert_memory_equal(rig.heard.bytes + 3, rig.reply, 7);
    lx_tap_remove(&rig.bus->tap, &rig.heard.listener);
    line_rig_close(&rig);
}

/* A loop that is held up for longer than the shortest response time misses deadlines: here each
   time it has done something, so it does not matter when the machine itself holds it up. */
static void late_deadlines_are_counted(void **state)
{
    const struct timespec nap = {.tv_nsec = (long)DG_MS(30)};
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 1, NULL);
    line_rig_open_pty(&rig);
    line_rig_request(&rig, 0x40, LINE_READ_POSITION);
    const uint64_t late = rig.bus->late;
    const dg_ns end = lx_now() + LINE_PATIENCE;
    while (rig.bus->late == late && lx_now() < end) {
        assert_true(sd_event_run(rig.event, 1000u) >= 0);
        (void)nanosleep(&nap, NULL);
    }
    assert_true(rig.bus->late > late);
    assert_int_equal(line_rig_receive(&rig, 7, LINE_PATIENCE), 7);
    line_rig_close(&rig);
}

/* --- plans --- */

static void what_does_not_fit_is_refused(void **state)
{
    static const struct {
        const char *setting;
        const char *serial;
        const char *says;
    } rows[] = {
        {"pace=2", NULL, "rig.ini:7: pace=2: expected 0 or 1"},
        {"turns=70000", NULL, "rig.ini:5: turns x periods x steps"},
        {NULL, "12a", "rig.ini:9: serial 12a: expected 1 to 9 digits"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct line_rig rig;
        struct lx_error error;
        line_rig_plan(&rig, 1, NULL);
        struct dg_plan_encoder *encoder = rig.plan.encoders;
        rig.plan.file = "rig.ini";
        encoder->line = 5;
        encoder->serial_line = 9;
        if (rows[i].setting != NULL) {
            (void)lx_plan_add_assignment(&encoder->settings, rows[i].setting, 7, &error);
        }
        encoder->serial = rows[i].serial;
        line_rig_prepare(&rig);
        assert_non_null(strstr(line_rig_refused(&rig).text, rows[i].says));
        rig.event = sd_event_unref(rig.event);
        plan_rig_free(&rig.plan);
    }
}

static void settings_reach_the_station(void **state)
{
    struct line_rig rig;
    (void)state;
    line_rig_plan(&rig, 2, NULL);
    line_rig_set(&rig, 1, "temperature=85");
    line_rig_set(&rig, 1, "led_current_ua=31000");
    line_rig_set(&rig, 1, "reaction_us=500");
    rig.plan.encoders[1].serial = "4711";
    line_rig_open_pty(&rig);
    assert_int_equal(rig.station[0].control->world->temperature_mdegc, 37000);
    assert_int_equal(rig.station[1].control->world->temperature_mdegc, 85000);
    assert_int_equal(rig.station[1].control->world->led_current_ua, 31000);
    assert_ptr_equal(rig.station[1].control->world->angle_ctx, &rig.shaft);
    assert_true(line_rig_device(&rig, 1)->setup.model->reaction == DG_US(500));
    (void)line_rig_ask(&rig, 0x41, "56", 40);
    assert_memory_equal(rig.reply + 2, "000004711", 9);
    line_rig_close(&rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_encoder_answers_at_its_address),
        cmocka_unit_test(a_changed_address_is_only_its_own),
        cmocka_unit_test(a_changed_data_rate_is_only_its_own),
        cmocka_unit_test(encoders_hear_each_other),
        cmocka_unit_test(replies_at_the_same_time_collide),
        cmocka_unit_test(a_request_into_a_reply_is_lost),
        cmocka_unit_test(without_power_it_is_silent_and_deaf),
        cmocka_unit_test(the_tap_hears_both_directions),
        cmocka_unit_test(late_deadlines_are_counted),
        cmocka_unit_test(what_does_not_fit_is_refused),
        cmocka_unit_test(settings_reach_the_station),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
