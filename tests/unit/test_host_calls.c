/* SPDX-License-Identifier: MIT */
/*
 * A handle and its host: memory, settings, EEPROM, shafts, world, queues, picoseconds.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "host_rig.h"

static uint8_t image[HOST_RIG_MEMORY_MAX];

/* ------------------------------------------------------------ memory and settings */

static void memory_that_does_not_do_is_refused(void **state)
{
    const size_t n = dg_host_size_of("f3668");

    (void)state;
    assert_true(n > 0);
    assert_int_equal(n % DG_HOST_ALIGN, 0);
    assert_null(dg_host_make(&host_rig_here, n - 1u, "f3668"));
    assert_null(dg_host_make(host_rig_here.bytes + 8, n, "f3668"));
    assert_null(dg_host_make(NULL, n, "f3668"));
    assert_null(dg_host_make(&host_rig_here, sizeof host_rig_here, "f366"));
    assert_int_equal(dg_host_size_of(""), 0);
    assert_int_equal(dg_host_size(&dg_ssi_25, &dg_hf_wire), 0);
    assert_null(dg_host_init(&host_rig_here, sizeof host_rig_here, &dg_ssi_25, &dg_hf_wire));
    assert_non_null(dg_host_make(&host_rig_here, n, "f3668"));
}

/* Each is taken, and told as it was taken. */
static void check_words(struct dg_host *self, const struct dg_host_key *key)
{
    size_t n = 0;
    char after[64];

    for (; dg_host_word(self, key->name, n) != NULL; n++) {
        const char *word = dg_host_word(self, key->name, n);
        assert_int_equal(dg_host_set(self, key->name, word), DG_HOST_OK);
        assert_true(dg_host_get(self, key->name, after, sizeof after) >= 0);
        assert_string_equal(after, word);
    }
    assert_true(key->type == DG_HOST_KEY_WORD ? n >= 2 : n == 0);
}

/* A value that is allowed, as text. */
static void check_key(struct dg_host *self, const struct dg_host_key *key)
{
    char before[64];
    char after[64];

    assert_true(key->name[0] != '\0' && key->help[0] != '\0' && key->unit != NULL);
    assert_true(key->min <= key->max);
    assert_true(dg_host_get(self, key->name, before, sizeof before) >= 0);
    check_words(self, key);
    assert_int_equal(dg_host_set(self, key->name, before), DG_HOST_OK);
    assert_true(dg_host_get(self, key->name, after, sizeof after) >= 0);
    assert_string_equal(before, after);
    assert_int_equal(dg_host_get(self, key->name, after, strlen(before)), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_set(self, key->name, "no such value, too long for a text as well"),
                     DG_HOST_ERR_ARGUMENT);
}

static void every_setting_is_told_and_taken_as_it_is_told(void **state)
{
    (void)state;
    for (size_t i = 0; i < host_rig_model_count; i++) {
        struct dg_host *self = host_rig_make(&host_rig_here, host_rig_models[i].name);
        struct dg_host_key key;
        size_t n = 0;
        for (; dg_host_key(self, n, &key) == DG_HOST_OK; n++) {
            check_key(self, &key);
        }
        assert_true(n > 8);
        assert_int_equal(dg_host_set(self, "no_such_key", "1"), DG_HOST_ERR_NAME);
        assert_null(dg_host_word(self, "no_such_key", 0));
        assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
        for (n = 0; dg_host_key(self, n, &key) == DG_HOST_OK; n++) {
            char value[64];
            assert_true(dg_host_get(self, key.name, value, sizeof value) >= 0);
            assert_int_equal(dg_host_set(self, key.name, value),
                             key.always ? DG_HOST_OK : DG_HOST_ERR_STATE);
        }
    }
}

static void settings_make_the_encoder(void **state)
{
    struct dg_host *self = host_rig_make(&host_rig_here, "f3668");
    struct dg_host_event event;
    struct dg_host_frame frame;
    uint64_t counts = 0;
    uint64_t now = READY;
    uint8_t serial[4];

    (void)state;
    assert_int_equal(dg_host_set(self, "node", "128"), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_set(self, "node", "5"), DG_HOST_OK);
    assert_int_equal(dg_host_set(self, "mt_bits", "16"), DG_HOST_OK);
    dg_host_shaft(self, 0, 5000 * TURN, 0);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    (void)dg_host_step(self, READY);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.id, 0x705);
    assert_int_equal(dg_host_position(self, READY, &counts), DG_HOST_OK);
    assert_int_equal(counts, 5000u << 16);

    self = host_rig_make(&host_rig_here, "s3684-biss");
    assert_int_equal(dg_host_set(self, "serial", "0x12345678"), DG_HOST_OK);
    assert_int_equal(dg_host_set(self, "st", "18"), DG_HOST_OK);
    assert_int_equal(dg_host_set(self, "lc", "0"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_int_equal(dg_host_frame(self, now, &frame), DG_HOST_OK);
    assert_int_equal(frame.count, 12 + 18 + 2 + 6);
    now = frame.end;
    assert_int_equal(dg_host_registers_read(self, &now, 0x44, serial, 4), 4);
    assert_true(serial[0] == 0x12 && serial[3] == 0x78);

    self = host_rig_make(&host_rig_here, "s3684-rs485");
    assert_int_equal(dg_host_set(self, "address", "0x60"), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_set(self, "address", "41h"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    event = (struct dg_host_event){
        .at = READY, .kind = DG_HOST_BYTES, .length = 3, .data = {0x41, 0x42, 0x03}};
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    (void)dg_host_step(self, READY + 100 * MS);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.data[0], 0x41);
}

static void settings_that_do_not_go_together_make_none(void **state)
{
    struct dg_host *self = host_rig_make(&host_rig_here, "s3684-rs485");

    (void)state;
    assert_int_equal(dg_host_set(self, "periods", "65535"), DG_HOST_OK);
    assert_int_equal(dg_host_set(self, "steps", "16777216"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_ERR_ARGUMENT);
    assert_false(dg_host_powered(self));
    assert_int_equal(dg_host_set(self, "steps", "1"), DG_HOST_OK);
    assert_int_equal(dg_host_set(self, "turns", "1"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
}

static void an_image_is_another_ones_memory(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    uint64_t now = READY;
    uint8_t byte = 0x5A;
    struct dg_host *other = host_rig_make(&host_rig_there, "s3684-biss");
    const size_t n = dg_host_memory_size(self);

    (void)state;
    assert_int_equal(dg_host_registers_write(self, &now, 0x23, &byte, 1), 1);
    byte = 1; /* command 01: store */
    assert_int_equal(dg_host_registers_write(self, &now, 0x60, &byte, 1), 1);
    assert_int_equal(dg_host_memory_load(self, image, n), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_memory_copy(self, image, n - 1u), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_memory_copy(self, image, n), DG_HOST_OK);
    assert_int_equal(dg_host_memory_load(other, image, n - 1u), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_memory_load(other, image, n), DG_HOST_OK);
    assert_int_equal(dg_host_power(other, 0, true), DG_HOST_OK);
    now = READY;
    byte = 0;
    assert_int_equal(dg_host_registers_read(other, &now, 0x23, &byte, 1), 1);
    assert_int_equal(byte, 0x5A);
    other = host_rig_make(&host_rig_there, "s3684-rs485");
    memset(image, 0xFF, sizeof image);
    assert_int_equal(dg_host_memory_load(other, image, dg_host_memory_size(other)), DG_HOST_OK);
    assert_int_equal(dg_host_power(other, 0, true), DG_HOST_ERR_BLANK);
    assert_false(dg_host_powered(other));
}

/* ------------------------------------------------------------ physics and time */

/* floor(rate * t / 1 s) modulo 2^64, by integers of any length (Python). */
static void a_shaft_turns_exactly_between_two_steps(void **state)
{
    static const struct {
        int64_t rate;
        uint64_t t;
        int64_t turned;
    } courses[] = {
        {1, UINT64_C(1), INT64_C(0)},
        {1, UINT64_C(333333333), INT64_C(0)},
        {1, UINT64_C(1000000001), INT64_C(1)},
        {-1, UINT64_C(999), INT64_C(-1)},
        {-1, UINT64_C(1000000000), INT64_C(-1)},
        {-1, UINT64_C(86400000000001), INT64_C(-86401)},
        {12 * TURN + 7, UINT64_C(1), INT64_C(51)},
        {12 * TURN + 7, UINT64_C(333333333), INT64_C(17179869169)},
        {12 * TURN + 7, UINT64_C(1000000001), INT64_C(51539607610)},
        {-200 * TURN - 1, UINT64_C(999), INT64_C(-858135)},
        {-200 * TURN - 1, UINT64_C(1000000000), INT64_C(-858993459201)},
        {-200 * TURN - 1, UINT64_C(86400000000001), INT64_C(-74217034874967259)},
        {INT64_MAX, UINT64_C(1), INT64_C(9223372036)},
        {INT64_MAX, UINT64_C(333333333), INT64_C(3074457342543801256)},
        {INT64_MAX, UINT64_C(1000000001), INT64_C(-9223372027631403773)},
        {INT64_MIN, UINT64_C(999), INT64_C(-9214148664818)},
        {INT64_MIN, UINT64_C(1000000000), INT64_MIN},
        {INT64_MIN, UINT64_C(86400000000001), INT64_C(-9223372037)},
        {-1000000001, UINT64_C(1), INT64_C(-2)},
        {-1000000001, UINT64_C(333333333), INT64_C(-333333334)},
        {-1000000001, UINT64_C(1000000001), INT64_C(-1000000003)},
        {1000000000, UINT64_C(1) << 63, INT64_MIN}, /* 584 years fit */
        {1000000000, UINT64_MAX - SECOND, -1 - (int64_t)SECOND},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(courses); i++) {
        struct dg_host *self = host_rig_make(&host_rig_here, "f3658");
        const uint64_t want = (uint64_t)TURN + (uint64_t)courses[i].turned;
        dg_host_shaft(self, 0, -TURN, 0);
        dg_host_shaft(self, SECOND, TURN, courses[i].rate);
        assert_int_equal(dg_host_angle(self, SECOND + courses[i].t), want);
        assert_int_equal(dg_host_angle(self, SECOND - 1u), -TURN);
    }
}

static void encoders_share_a_shaft(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host *other = host_rig_start(&host_rig_there, "f3668");
    uint64_t a = 0;
    uint64_t b = 0;

    (void)state;
    assert_int_equal(dg_host_share(other, self), DG_HOST_OK);
    assert_int_equal(dg_host_share(self, other), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_share(self, self), DG_HOST_OK); /* its own one, as before */
    assert_int_equal(dg_host_angle(other, READY), dg_host_angle(self, READY));
    dg_host_shaft(self, READY, 7 * TURN, 3 * TURN);
    for (uint64_t t = READY; t < READY + SECOND; t += 77 * MS) {
        assert_int_equal(dg_host_position(self, t, &a), DG_HOST_OK);
        assert_int_equal(dg_host_position(other, t, &b), DG_HOST_OK);
        assert_int_equal(a >> 5, b);
    }
    assert_int_equal(dg_host_share(other, NULL), DG_HOST_OK);
    assert_int_equal(dg_host_angle(other, READY), 3 * TURN + TURN / 4);
}

static void the_world_is_bent_by_name(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host_frame frame;
    int64_t value = 0;
    char text[16];

    (void)state;
    assert_int_equal(dg_host_world_get(self, "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 37000);
    assert_int_equal(dg_host_world_set(self, READY, "temperature", 1000001), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_world_set(self, READY, "no_such", 1), DG_HOST_ERR_NAME);
    assert_int_equal(dg_host_set(self, "temperature", "-12.5"), DG_HOST_OK);
    assert_int_equal(dg_host_get(self, "temperature", text, sizeof text), 7);
    assert_string_equal(text, "-12.500");
    assert_int_equal(dg_host_world_set(self, READY, "singleturn_ok", 0), DG_HOST_OK);
    assert_int_equal(dg_host_frame(self, READY, &frame), DG_HOST_OK);
    assert_int_equal(frame.error, 1);
    assert_int_equal(dg_host_world_set(self, READY, "temperature", -1000001), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_world_get(self, "no_such", &value), DG_HOST_ERR_NAME);
    assert_int_equal(dg_host_get(self, "no_such", text, sizeof text), DG_HOST_ERR_NAME);
    self = host_rig_make(&host_rig_here, "ocd-ib-k1");
    /* What others have, a singleturn has not. */
    assert_int_equal(dg_host_set(self, "turns", "1"), DG_HOST_ERR_NAME);
    assert_int_equal(dg_host_get(self, "turns", text, sizeof text), DG_HOST_ERR_NAME);
    assert_int_equal(dg_host_world_get(self, "multiturn_sync_ok", &value), DG_HOST_ERR_NAME);
    assert_int_equal(dg_host_world_set(self, READY, "supply_mv", 1), DG_HOST_ERR_NAME);
    assert_int_equal(dg_host_world_set(self, READY, "multiturn_sync_ok", 0), DG_HOST_ERR_NAME);
}

static void what_nobody_fetches_is_counted_and_told(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ocd-ib-k2");
    struct dg_host_event event = {.at = READY, .kind = DG_HOST_WORDS};
    unsigned n = 0;

    (void)state;
    host_rig_drain(self);
    for (unsigned i = 0; i < DG_HOST_QUEUE; i++) {
        assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    }
    assert_int_equal(dg_host_send(self, &event), DG_HOST_ERR_SPACE);
    (void)dg_host_step(self, READY);
    assert_int_equal(dg_host_lost(self), 0);
    event.at += 5;
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    assert_int_equal(dg_host_step(self, READY + 5), DG_HOST_NEVER);
    assert_int_equal(dg_host_lost(self), 1);
    while (dg_host_receive(self, &event) == 1) {
        n++;
    }
    assert_int_equal(n, DG_HOST_QUEUE);
    assert_int_equal(dg_host_receive(self, &event), 0); /* the loop was told */
    event = (struct dg_host_event){.at = READY + 6, .kind = DG_HOST_WORDS};
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    (void)dg_host_step(self, READY + 6);
    assert_int_equal(dg_host_receive(self, &event), 1);
}

/* The high word first; nothing behind them. An unknown command is answered with 84000000h (9.1). */
static void words_stand_as_in_the_ring(void **state)
{
    static const uint8_t unknown[16] = {0x84};
    struct dg_host *self = host_rig_start(&host_rig_here, "ocd-ib-k3");
    struct dg_host_event event = {.at = READY, .kind = DG_HOST_WORDS, .id = 0x10000000};

    (void)state;
    for (unsigned i = 0; i < 20; i++) {
        host_rig_drain(self);
        event.at = READY + i * MS;
        assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
        (void)dg_host_step(self, event.at);
    }
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.id, 0x84000000);
    assert_int_equal(event.length, 4);
    assert_memory_equal(event.data, unknown, sizeof unknown);
}

/* An edge within a frame of the handle's own master happens at its end, and sets off the monoflop
 * of 20 us. */
static void an_edge_within_a_frame_comes_behind_it(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ssi-25");
    const struct dg_host_event low = {.at = READY + 1000, .kind = DG_HOST_EDGE, .length = 1};
    struct dg_host_frame frame;

    (void)state;
    assert_int_equal(dg_host_send(self, &low), DG_HOST_OK);
    assert_int_equal(dg_host_frame(self, READY, &frame), DG_HOST_OK);
    assert_true(frame.end > low.at);
    assert_int_equal(dg_host_next(self), frame.end + 20000);
}

static void count(void *ctx, const struct dg_host_event *event)
{
    assert_int_equal(event->kind, DG_HOST_WORDS);
    ++*(unsigned *)ctx;
}

static void a_listener_hears_at_once(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ocd-ib-k1");
    struct dg_host_event event = {.at = READY, .kind = DG_HOST_WORDS};
    unsigned heard = 0;

    (void)state;
    host_rig_drain(self);
    dg_host_listen(self, count, &heard);
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    (void)dg_host_step(self, READY);
    assert_int_equal(heard, 1);
    dg_host_listen(self, NULL, NULL);
    assert_int_equal(dg_host_receive(self, &event), 0);
}

static void events_of_other_wires_are_refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < host_rig_model_count; i++) {
        const struct host_rig_model *row = &host_rig_models[i];
        const bool rs485 = row->wire == &dg_hf_wire;
        const bool biss = row->wire == &dg_biss_wire;
        const bool clocked = row->medium == DG_HOST_MEDIUM_EDGES;
        struct dg_host *self = host_rig_make(&host_rig_here, row->name);
        struct dg_host_event event = {.at = 0, .length = 1};
        unsigned own = 0;
        int32_t uv[4];
        uint64_t now = READY;
        uint8_t byte = 0;
        assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
        for (unsigned kind = 0; kind < 256; kind++) {
            event.kind = (uint8_t)kind;
            const int result = dg_host_send(self, &event);
            own += result == DG_HOST_OK ? 1u : 0u;
            assert_true(result == DG_HOST_OK || result == DG_HOST_ERR_WIRE);
        }
        assert_int_equal(own, row->medium == DG_HOST_MEDIUM_FRAMES ? 2 : 1);
        assert_int_equal(dg_host_sincos(self, READY, uv) == DG_HOST_ERR_WIRE, !rs485);
        assert_int_equal(dg_host_clock(self, now, true) == DG_HOST_ERR_WIRE, !clocked);
        assert_int_equal(dg_host_registers_read(self, &now, 0, &byte, 1) == DG_HOST_ERR_WIRE,
                         !biss);
    }
}

/* The line of an SSI encoder by its edges, in picoseconds. */
static void a_simulator_clocks_in_picoseconds(void **state)
{
    const uint64_t position = host_rig_model("ssi-25")->position;
    struct dg_host *self = host_rig_start(&host_rig_here, "ssi-25");
    const uint64_t ps = 1000;
    uint64_t now = READY * ps + 999; /* still the same nanosecond */
    uint64_t bits = 0;

    (void)state;
    assert_int_equal(dg_host_clock_ps(self, now, true), 1);
    for (int i = 0; i < 25; i++) {
        (void)dg_host_clock_ps(self, now, false);
        bits = bits << 1 | (uint64_t)dg_host_clock_ps(self, now + 250 * ps, true);
        now += 500 * ps;
    }
    assert_int_equal(bits, position ^ position >> 1);
    const uint64_t end = (READY + 24u * 500u + 20000u) * ps;
    assert_int_equal(dg_host_step_ps(self, end - 1u), end); /* not early */
    assert_int_equal(dg_host_step_ps(self, end), DG_HOST_NEVER);
    assert_int_equal(dg_host_frame(self, READY, &(struct dg_host_frame){0}), DG_HOST_OK);
}

/* The middle of a word is no moment for a frame. */
static void a_frame_waits_for_the_end_of_another(void **state)
{
    static const char *const names[] = {"s3684-biss", "ssi-25"};
    struct dg_host_frame frame;

    (void)state;
    for (size_t i = 0; i < DG_COUNT(names); i++) {
        struct dg_host *self = host_rig_make(&host_rig_here, names[i]);
        assert_int_equal(dg_host_frame(self, 0, &frame), DG_HOST_ERR_STATE);
        assert_int_equal(dg_host_clock(self, 0, false), DG_HOST_ERR_STATE);
        self = host_rig_start(&host_rig_here, names[i]);
        (void)dg_host_clock(self, READY, false);
        (void)dg_host_clock(self, READY + 500, true);
        (void)dg_host_clock(self, READY + 1000, false);
        assert_int_equal(dg_host_frame(self, READY + 1500, &frame), DG_HOST_ERR_STATE);
        /* The clock rests high: one that is low, however long, is the middle of something. */
        assert_int_equal(dg_host_frame(self, READY + MS, &frame), DG_HOST_ERR_STATE);
        (void)dg_host_clock(self, READY + MS, true);
        assert_int_equal(dg_host_frame(self, READY + 2 * MS, &frame), DG_HOST_OK);
    }
}

static void positions_in_a_row_are_those_one_by_one(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    uint64_t counts[5] = {0};
    uint64_t one = 0;

    (void)state;
    dg_host_shaft(self, READY, 0, 100 * TURN);
    assert_int_equal(dg_host_positions(self, READY, 250000, counts, 4), DG_HOST_OK);
    for (uint64_t i = 0; i < 4; i++) {
        assert_int_equal(dg_host_position(self, READY + i * 250000, &one), DG_HOST_OK);
        assert_int_equal(counts[i], one);
        assert_int_equal(one, i * (1u << 21) / 40u);
    }
    assert_int_equal(counts[4], 0);
    assert_int_equal(dg_host_power(self, READY, false), DG_HOST_OK);
    assert_int_equal(dg_host_positions(self, READY, 1, counts, 1), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_positions(self, READY, 1, counts, 0), DG_HOST_ERR_STATE);
}

static void results_have_words(void **state)
{
    (void)state;
    for (int result = -14; result <= 0; result++) {
        assert_string_not_equal(dg_host_result_text(result), "unknown result");
        assert_string_not_equal(dg_host_result_text(result), "");
    }
    assert_string_equal(dg_host_result_text(1), "unknown result");
    assert_string_equal(dg_host_result_text(-15), "unknown result");
    assert_string_equal(dg_host_result_text(INT32_MIN), "unknown result");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_that_does_not_do_is_refused),
        cmocka_unit_test(every_setting_is_told_and_taken_as_it_is_told),
        cmocka_unit_test(settings_make_the_encoder),
        cmocka_unit_test(settings_that_do_not_go_together_make_none),
        cmocka_unit_test(an_image_is_another_ones_memory),
        cmocka_unit_test(a_shaft_turns_exactly_between_two_steps),
        cmocka_unit_test(encoders_share_a_shaft),
        cmocka_unit_test(the_world_is_bent_by_name),
        cmocka_unit_test(what_nobody_fetches_is_counted_and_told),
        cmocka_unit_test(words_stand_as_in_the_ring),
        cmocka_unit_test(an_edge_within_a_frame_comes_behind_it),
        cmocka_unit_test(a_listener_hears_at_once),
        cmocka_unit_test(events_of_other_wires_are_refused),
        cmocka_unit_test(a_simulator_clocks_in_picoseconds),
        cmocka_unit_test(a_frame_waits_for_the_end_of_another),
        cmocka_unit_test(positions_in_a_row_are_those_one_by_one),
        cmocka_unit_test(results_have_words),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
