/* SPDX-License-Identifier: MIT */
/*
 * The device as a C object: several side by side, copies, replay, and what happens exactly at,
 * before and after a deadline (5.1.1.1, R1, R6a, R6b).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "hf_rig.h"

/* 9600 Bd: a character of 11 bits, the timeout of 44 bits, rounded up. */
#define CHARACTER ((dg_ns)1145834)
#define TIMEOUT ((dg_ns)4583334)
#define REACTION DG_MS(1)

static struct hf_rig rig;
static struct hf_rig other;
static struct hf_rig saved;

static const uint8_t read_position[] = {0x40, 0x42, 0x02};

static const struct dg_hf_model *multiturn(void)
{
    return dg_hf_model_of(dg_device_find("s3684-rs485"));
}

static int set_up(void **state)
{
    (void)state;
    return hf_rig_init(&rig, multiturn()) != DG_OK || hf_rig_power_on(&rig) != DG_OK ||
           hf_rig_init(&other, multiturn()) != DG_OK || hf_rig_power_on(&other) != DG_OK;
}

/* Characters one after the other; the return value is the last deadline. */
static dg_ns receive(struct hf_rig *to, const uint8_t *bytes, size_t n)
{
    dg_ns deadline = DG_NEVER;

    for (size_t i = 0; i < n; i++) {
        to->now += CHARACTER;
        deadline = dg_hf_rx(&to->device, to->now, bytes[i], DG_HF_RX_OK);
    }
    return deadline;
}

static dg_ns step_encoder(struct hf_rig *to, dg_ns now)
{
    to->now = now;
    return dg_hf_step(&to->device, now);
}

/* Side by side. */

static void two_devices_with_interleaved_characters(void **state)
{
    const uint8_t set[] = {0x40, 0x43, 0x00, 0x00, 0x00, 0x07, 0x55, 0x51};

    (void)state;
    rig.angle = 5 * DG_TURN;
    other.angle = 9 * DG_TURN;
    for (size_t i = 0; i < sizeof set; i++) {
        if (i < sizeof read_position) {
            (void)receive(&rig, &read_position[i], 1);
        }
        (void)receive(&other, &set[i], 1);
    }
    hf_rig_run(&other);
    hf_rig_run(&rig);
    static const uint8_t position[] = {0x40, 0x42, 0x00, 0x05, 0x00, 0x00, 0x07};
    static const uint8_t done[] = {0x40, 0x43, 0x03};
    assert_int_equal(rig.reply_length, sizeof position);
    assert_memory_equal(rig.reply, position, sizeof position);
    assert_int_equal(other.reply_length, sizeof done);
    assert_memory_equal(other.reply, done, sizeof done);
    assert_int_equal(rig.device.offset, 0);
}

/* Every address a slave can have, and its neighbour on the same wire. */
static void on_one_wire_only_the_addressed_device_answers(void **state)
{
    (void)state;
    for (unsigned address = 0x40; address <= 0x5E; address++) {
        const uint8_t mine[] = {0x55, (uint8_t)address, 0x55};
        const uint8_t next[] = {0x55, (uint8_t)(address + 1u), 0x55};
        assert_int_equal(hf_rig_ask_bytes(&rig, mine, sizeof mine), 0);
        assert_int_equal(hf_rig_ask_bytes(&other, next, sizeof next), 0);
        const uint8_t frame[] = {(uint8_t)address, 0x46, (uint8_t)(address ^ 0x46u)};
        assert_int_equal(hf_rig_send(&rig, frame, sizeof frame), 6);
        assert_int_equal(rig.reply[0], address);
        assert_int_equal(hf_rig_send(&other, frame, sizeof frame), 0);
    }
}

/* Copies. */

/* A stretch of a device's life, made from `seed`: requests right and wrong, pauses, resets. */
static void live(struct hf_rig *self, uint32_t seed)
{
    static const char *const requests[] = {
        "42",       "47", "4D 00 CF 55",       "4B 00 05 03 55 01 02 03",
        "44 48",    "53", "43 00 00 10 00 55", "4A 00 00 10 55",
        "57 E5 55", "50", "4F 01 55 66",       "99"};

    for (int i = 0; i < 60; i++) {
        seed = seed * 1664525u + 1013904223u;
        self->angle += (dg_angle)seed;
        self->world.temperature_mdegc = (seed & 0x10000u) != 0 ? 130000 : 37000;
        (void)hf_rig_ask(self, requests[(seed >> 20) % (DG_COUNT(requests))]);
        self->now += seed >> 8;
        (void)dg_hf_rx(&self->device, self->now, (uint8_t)(seed >> 24), (uint8_t)(seed >> 8 & 1u));
        hf_rig_run(self);
    }
}

static void the_same_inputs_give_the_same_bytes(void **state)
{
    (void)state;
    memcpy(&saved, &rig, sizeof saved);
    live(&rig, 1);
    memcpy(&other, &rig, sizeof other);
    memcpy(&rig, &saved, sizeof rig);
    live(&rig, 1);
    assert_memory_equal(&rig, &other, sizeof rig);
    memcpy(&rig, &saved, sizeof rig);
    live(&rig, 2);
    assert_memory_not_equal(&rig, &other, sizeof rig);
}

/* A device copied to another place goes on there: nothing in it points into itself. */
static void a_copy_elsewhere_goes_on(void **state)
{
    struct dg_hf copy;

    (void)state;
    dg_ns deadline = receive(&rig, read_position, sizeof read_position);
    memcpy(&copy, &rig.device, sizeof copy);
    memset(&rig.device, 0xA5, sizeof rig.device);
    deadline = dg_hf_step(&copy, deadline);
    rig.now = deadline;
    assert_int_equal(dg_hf_step(&copy, deadline), DG_NEVER);
    assert_int_equal(rig.replies, 1);
    assert_int_equal(rig.reply_length, 7);
    assert_int_equal(rig.reply_at, deadline);
}

/* Deadlines. */

static void a_frame_ends_with_the_timeout_and_is_answered_after_the_reaction_time(void **state)
{
    (void)state;
    const dg_ns deadline = receive(&rig, read_position, sizeof read_position);
    const dg_ns last = rig.now;
    assert_int_equal(deadline, last + TIMEOUT);
    assert_int_equal(step_encoder(&rig, last), deadline);
    assert_int_equal(step_encoder(&rig, deadline - 1), deadline);
    assert_int_equal(rig.device.counters.frames, 0);
    assert_int_equal(step_encoder(&rig, deadline), deadline + REACTION);
    assert_int_equal(rig.device.counters.frames, 1);
    assert_int_equal(step_encoder(&rig, deadline + REACTION - 1), deadline + REACTION);
    assert_int_equal(rig.replies, 0);
    assert_int_equal(step_encoder(&rig, deadline + REACTION), DG_NEVER);
    assert_int_equal(rig.replies, 1);
    assert_int_equal(step_encoder(&rig, deadline + DG_S(1)), DG_NEVER);
    assert_int_equal(rig.replies, 1);
}

/* R6a: however late the host is, the position is the one at the start of the reply. */
static void a_late_step_replies_with_the_position_of_then(void **state)
{
    (void)state;
    rig.angle_per_ms = DG_TURN / 65536 * 3;
    const dg_ns deadline = receive(&rig, read_position, sizeof read_position);
    assert_int_equal(step_encoder(&rig, deadline + DG_S(2)), DG_NEVER);
    assert_int_equal(rig.replies, 1);
    const uint64_t position = 3u * ((deadline + DG_S(2)) / 1000000u);
    const uint8_t low[] = {(uint8_t)(position >> 16), (uint8_t)(position >> 8), (uint8_t)position};
    assert_memory_equal(&rig.reply[3], low, sizeof low);
    assert_int_equal(rig.reply_at, deadline + DG_S(2));
}

/* Two characters of a frame, and what becomes of a third one `gap` after them. */
static unsigned frames_with_a_gap(dg_ns gap, bool start_first)
{
    (void)receive(&rig, read_position, 2);
    rig.now += gap;
    if (start_first) {
        (void)dg_hf_rx(&rig.device, rig.now, 0xEE, DG_HF_RX_START);
        rig.now += CHARACTER;
    }
    (void)dg_hf_rx(&rig.device, rig.now, 0x02, DG_HF_RX_OK);
    hf_rig_run(&rig);
    assert_int_equal(rig.replies, 1);
    return rig.reply[2] == DG_HF_CHECKSUM ? 2 : 1;
}

static void a_character_at_the_very_timeout_belongs_to_the_frame(void **state)
{
    (void)state;
    assert_int_equal(frames_with_a_gap(TIMEOUT, false), 1);
}

static void a_character_after_the_timeout_does_not(void **state)
{
    (void)state;
    assert_int_equal(frames_with_a_gap(TIMEOUT + 1, false), 2);
    assert_int_equal(rig.device.counters.interrupted, 1);
}

static void a_start_bit_at_the_very_timeout_keeps_the_frame_open(void **state)
{
    (void)state;
    assert_int_equal(frames_with_a_gap(TIMEOUT, true), 1);
    assert_int_equal(rig.device.counters.frames, 1);
}

static void a_start_bit_after_the_timeout_does_not(void **state)
{
    (void)state;
    assert_int_equal(frames_with_a_gap(TIMEOUT + 1, true), 2);
}

/* A start bit whose character never comes: the frame ends a character later than the timeout. */
static void a_start_bit_alone_only_delays(void **state)
{
    (void)state;
    (void)receive(&rig, read_position, sizeof read_position);
    rig.now += DG_MS(2);
    const dg_ns deadline = dg_hf_rx(&rig.device, rig.now, 0, DG_HF_RX_START);
    assert_int_equal(deadline, rig.now + 5729167); /* 44 bits and a character */
    hf_rig_run(&rig);
    assert_int_equal(rig.replies, 1);
    assert_int_equal(rig.reply[1], 0x42);
    assert_int_equal(rig.reply_at, deadline + REACTION);
}

static void a_start_bit_on_an_idle_line_means_nothing(void **state)
{
    (void)state;
    assert_int_equal(dg_hf_rx(&rig.device, rig.now, 0x40, DG_HF_RX_START), DG_NEVER);
    assert_int_equal(rig.device.line, DG_HF_IDLE);
    /* Nor does a damaged one count: there is no character yet. */
    (void)dg_hf_rx(&rig.device, rig.now, 0x40, DG_HF_RX_START | DG_HF_RX_DAMAGED);
    assert_int_equal(rig.device.counters.damaged, 0);
    assert_int_equal(hf_rig_ask(&rig, "42"), 0);
}

/* The host never stepped: the next character finds the frame before it due, and answers it. */
static void a_character_does_what_was_due_before_it(void **state)
{
    (void)state;
    (void)receive(&rig, read_position, sizeof read_position);
    rig.now += DG_MS(500);
    (void)dg_hf_rx(&rig.device, rig.now, 0x40, DG_HF_RX_OK);
    assert_int_equal(rig.replies, 1);
    assert_int_equal(rig.device.line, DG_HF_COLLECT);
    (void)receive(&rig, &read_position[1], 2);
    hf_rig_run(&rig);
    assert_int_equal(rig.replies, 2);
    assert_int_equal(rig.reply[1], 0x42);
}

/* time.h: an earlier `now` means that no time has passed. */
static void time_going_backwards_is_time_standing_still(void **state)
{
    (void)state;
    dg_ns deadline = receive(&rig, read_position, 2);
    assert_int_equal(dg_hf_step(&rig.device, 0), deadline);
    assert_int_equal(dg_hf_rx(&rig.device, rig.now - DG_MS(5), 0x02, DG_HF_RX_OK), deadline);
    assert_int_equal(dg_hf_rx(&rig.device, 0, 0, DG_HF_RX_START), deadline + CHARACTER - 1);
    (void)step_encoder(&rig, rig.now);
    assert_int_equal(rig.device.counters.frames, 0);
    hf_rig_run(&rig);
    assert_int_equal(rig.replies, 1);
    assert_int_equal(rig.reply[1], 0x42);
}

/* Half duplex: a request that comes while the reply is due is dropped, up to the next silence. */
static void characters_before_the_reply_are_dropped(void **state)
{
    (void)state;
    const dg_ns deadline = receive(&rig, read_position, sizeof read_position);
    (void)step_encoder(&rig, deadline);
    for (size_t i = 0; i < sizeof read_position; i++) {
        const dg_ns now = deadline + 1 + i;
        assert_int_equal(dg_hf_rx(&rig.device, now, read_position[i], DG_HF_RX_OK),
                         deadline + REACTION);
    }
    rig.now = deadline + REACTION;
    hf_rig_run(&rig);
    assert_int_equal(rig.replies, 1);
    assert_int_equal(rig.device.counters.interrupted, sizeof read_position);
    assert_int_equal(hf_rig_ask(&rig, "42"), 0);
}

static void no_power_no_reply(void **state)
{
    (void)state;
    (void)receive(&rig, read_position, sizeof read_position);
    dg_hf_power_off(&rig.device);
    assert_int_equal(step_encoder(&rig, rig.now + DG_S(1)), DG_NEVER);
    assert_int_equal(receive(&rig, read_position, sizeof read_position), DG_NEVER);
    assert_int_equal(step_encoder(&rig, rig.now + DG_S(1)), DG_NEVER);
    assert_int_equal(rig.replies, 0);
}

/* The end of time is a deadline like any other: it never comes, and nothing overflows. */
static void nothing_is_due_beyond_the_end_of_time(void **state)
{
    (void)state;
    rig.now = DG_NEVER - DG_MS(2) - 3 * CHARACTER;
    assert_int_equal(receive(&rig, read_position, sizeof read_position), DG_NEVER);
    assert_int_equal(dg_hf_step(&rig.device, DG_NEVER), DG_NEVER);
    assert_int_equal(rig.replies, 0);
}

/* Start-up window (5.1.2.18, R15). */

static void the_window_closes_in_silence_and_the_stored_setting_comes_into_force(void **state)
{
    (void)state;
    assert_int_equal(hf_rig_ask(&rig, "57 F6 55"), 0);
    assert_int_equal(dg_hf_uart(&rig.device).baud, 9600);
    const dg_ns on = rig.now;
    assert_int_equal(dg_hf_power_on(&rig.device, on), DG_OK);
    assert_int_equal(step_encoder(&rig, on), on + DG_MS(100));
    assert_int_equal(step_encoder(&rig, on + DG_MS(100) - 1), on + DG_MS(100));
    assert_int_equal(dg_hf_uart(&rig.device).baud, 9600);
    assert_int_equal(step_encoder(&rig, on + DG_MS(100)), DG_NEVER);
    assert_int_equal(dg_hf_uart(&rig.device).baud, 38400);
    assert_int_equal(dg_hf_uart(&rig.device).parity, 'O');
}

static void a_valid_frame_in_the_window_keeps_the_delivery_setting(void **state)
{
    (void)state;
    assert_int_equal(hf_rig_ask(&rig, "57 F6 55"), 0);
    assert_int_equal(dg_hf_power_on(&rig.device, rig.now), DG_OK);
    const dg_ns end = rig.now + DG_MS(100);
    rig.now = end - 4 * CHARACTER;
    (void)receive(&rig, read_position, sizeof read_position);
    hf_rig_run(&rig);
    assert_true(rig.now > end);
    assert_int_equal(rig.replies, 2);
    assert_int_equal(dg_hf_uart(&rig.device).baud, 9600);
    assert_int_equal(hf_rig_ask(&rig, "53"), HF_RIG_SILENCE);
    assert_int_equal(dg_hf_uart(&rig.device).baud, 9600);
}

static void a_damaged_frame_in_the_window_does_not(void **state)
{
    static const uint8_t damaged[] = {0x40, 0x42, 0x03};

    (void)state;
    assert_int_equal(hf_rig_ask(&rig, "57 F6 55"), 0);
    assert_int_equal(dg_hf_power_on(&rig.device, rig.now), DG_OK);
    (void)receive(&rig, damaged, sizeof damaged);
    hf_rig_run(&rig);
    assert_int_equal(rig.reply[2], DG_HF_CHECKSUM);
    (void)step_encoder(&rig, rig.now + DG_MS(100));
    assert_int_equal(dg_hf_uart(&rig.device).baud, 38400);
}

/* Setup. */

static void a_setup_without_something_is_refused(void **state)
{
    static const struct dg_hf_ops mute = {.tx = NULL};
    struct dg_world no_shaft;
    struct dg_hf device;
    struct dg_hf_setup wrong[6];

    (void)state;
    dg_world_init(&no_shaft);
    no_shaft.angle = NULL;
    for (size_t i = 0; i < 6; i++) {
        wrong[i] = hf_rig_setup(&rig, multiturn());
        assert_int_equal(dg_hf_init(&device, &wrong[i]), DG_OK);
    }
    wrong[0].model = NULL;
    wrong[1].world = NULL;
    wrong[2].world = &no_shaft;
    wrong[3].nvm.ops = NULL;
    wrong[4].ops = NULL;
    wrong[5].ops = &mute;
    for (size_t i = 0; i < 6; i++) {
        assert_int_equal(dg_hf_init(&device, &wrong[i]), DG_ERR_ARGUMENT);
    }
}

static void assert_model(const struct dg_hf_model *model, int expected)
{
    const struct dg_hf_setup setup = hf_rig_setup(&rig, model);
    struct dg_hf device;

    assert_int_equal(dg_hf_init(&device, &setup), expected);
    assert_int_equal(dg_hf_format(model, setup.nvm), expected);
}

static void a_model_out_of_range_is_refused(void **state)
{
    struct dg_hf_model models[15];

    (void)state;
    for (size_t i = 0; i < 15; i++) {
        models[i] = *multiturn();
    }
    models[0].periods_per_turn = 0;
    models[1].steps_per_period = 0;
    models[2].turns = 0;
    models[3].turns = 65537;
    models[4].turns = UINT32_MAX;
    models[5].memory_blocks = 0;
    models[6].memory_blocks = 113;
    models[7].memory_blocks = 1;
    models[8].memory_blocks = 112;
    models[9].turns = 65536;
    models[10].turns = 256;
    models[10].steps_per_period = 8192; /* 2^24 steps a turn */
    models[11].implemented_blocks = 112;
    models[12].implemented_blocks = 128;
    models[13].turns = 1;
    models[13].steps_per_period = 8193;
    models[14].implemented_blocks = 111;
    for (size_t i = 0; i < 15; i++) {
        assert_model(&models[i], i < 7 || i > 12 ? DG_ERR_ARGUMENT : DG_OK);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(two_devices_with_interleaved_characters, set_up),
        cmocka_unit_test_setup(on_one_wire_only_the_addressed_device_answers, set_up),
        cmocka_unit_test_setup(the_same_inputs_give_the_same_bytes, set_up),
        cmocka_unit_test_setup(a_copy_elsewhere_goes_on, set_up),
        cmocka_unit_test_setup(
            a_frame_ends_with_the_timeout_and_is_answered_after_the_reaction_time, set_up),
        cmocka_unit_test_setup(a_late_step_replies_with_the_position_of_then, set_up),
        cmocka_unit_test_setup(a_character_at_the_very_timeout_belongs_to_the_frame, set_up),
        cmocka_unit_test_setup(a_character_after_the_timeout_does_not, set_up),
        cmocka_unit_test_setup(a_start_bit_at_the_very_timeout_keeps_the_frame_open, set_up),
        cmocka_unit_test_setup(a_start_bit_after_the_timeout_does_not, set_up),
        cmocka_unit_test_setup(a_start_bit_alone_only_delays, set_up),
        cmocka_unit_test_setup(a_start_bit_on_an_idle_line_means_nothing, set_up),
        cmocka_unit_test_setup(a_character_does_what_was_due_before_it, set_up),
        cmocka_unit_test_setup(time_going_backwards_is_time_standing_still, set_up),
        cmocka_unit_test_setup(characters_before_the_reply_are_dropped, set_up),
        cmocka_unit_test_setup(no_power_no_reply, set_up),
        cmocka_unit_test_setup(nothing_is_due_beyond_the_end_of_time, set_up),
        cmocka_unit_test_setup(the_window_closes_in_silence_and_the_stored_setting_comes_into_force,
                               set_up),
        cmocka_unit_test_setup(a_valid_frame_in_the_window_keeps_the_delivery_setting, set_up),
        cmocka_unit_test_setup(a_damaged_frame_in_the_window_does_not, set_up),
        cmocka_unit_test_setup(a_setup_without_something_is_refused, set_up),
        cmocka_unit_test_setup(a_model_out_of_range_is_refused, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
