/* SPDX-License-Identifier: MIT */
#include "character_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/host_wire.h"
#include "drehgeber/instruments.h"
#include "hf_rig.h"

static void keep_sent(void *ctx, size_t place, const struct dg_tap_event *event)
{
    struct character_rig *self = ctx;

    assert_true(self->count < CHARACTER_RIG_EVENTS);
    assert_true(event->ours);
    self->sent[self->count++] = (struct character_told){place, *event};
}

static void keep_seen(void *ctx, const struct dg_tap_event *event)
{
    struct character_rig *self = ctx;

    assert_true(self->seen_count < CHARACTER_RIG_EVENTS);
    self->seen[self->seen_count++] = (struct character_told){0, *event};
}

static enum dg_bus_answer answer(void *ctx, size_t place)
{
    const struct character_rig *self = ctx;

    return place == 0 ? self->answer : DG_BUS_SAY;
}

void character_rig_whole(void *ctx, size_t place, dg_ns at, const uint8_t *bytes, size_t n)
{
    struct character_rig *self = ctx;

    (void)place;
    assert_true(self->whole_count + n <= sizeof self->whole);
    self->whole_at = self->whole_count == 0 ? at : self->whole_at;
    memcpy(self->whole + self->whole_count, bytes, n);
    self->whole_count += n;
}

static const struct dg_bus_ops ops = {.tx = keep_sent, .tap = keep_seen, .answer = answer};

static void add_encoder(struct character_rig *self, const char *address)
{
    const size_t i = dg_bus_count(self->bus);

    self->hosts[i] = host_rig_make(&self->places[i], "s3684-rs485");
    assert_int_equal(dg_host_set(self->hosts[i], "address", address), DG_HOST_OK);
    assert_int_equal(dg_host_power(self->hosts[i], 0, true), DG_HOST_OK);
    self->control[i] = (struct dg_encoder){.instrument = &dg_hf_instrument};
    assert_int_equal(dg_bus_attach(self->bus, self->hosts[i], &self->control[i]), (int)i);
}

void character_rig_make(struct character_rig *self, const struct dg_characters_setup *wire,
                        size_t encoders)
{
    static const char *const addresses[CHARACTER_RIG_MAX] = {"0x40", "0x41", "0x42", "0x43"};
    const struct dg_bus_setup setup = {.size = sizeof setup,
                                       .medium = &dg_bus_characters,
                                       .encoders = CHARACTER_RIG_MAX,
                                       .wire = wire,
                                       .ops = &ops,
                                       .ctx = self};

    memset(self, 0, sizeof *self);
    assert_in_range(dg_bus_size(&dg_bus_characters, CHARACTER_RIG_MAX), 1, sizeof self->memory);
    self->bus = dg_bus_init(self->memory, sizeof self->memory, &setup);
    assert_non_null(self->bus);
    for (size_t i = 0; i < encoders; i++) {
        add_encoder(self, addresses[i]);
    }
    self->now = READY;
    (void)dg_bus_step(self->bus, self->now);
}

const struct dg_characters_setup character_rig_paced = {.size = sizeof character_rig_paced,
                                                        .paced = true};

/* All that is due by then, deadline by deadline. */
void character_rig_pass_to(struct character_rig *self, dg_ns until)
{
    dg_ns next = dg_bus_next(self->bus);

    while (next <= until) {
        next = dg_bus_step(self->bus, next);
    }
    (void)dg_bus_step(self->bus, until);
    self->now = until;
}

void character_rig_say_at(struct character_rig *self, uint32_t baud, char parity, const char *hex)
{
    uint8_t bytes[DG_REPLY_MAX];
    const size_t n = hf_rig_hex(hex, bytes, sizeof bytes);

    for (size_t i = 0; i < n; i++) {
        const struct dg_tap_event event = {.at = self->now,
                                           .kind = DG_TAP_CHARACTER,
                                           .character = {baud, parity, bytes[i], false}};
        (void)dg_bus_rx(self->bus, &event);
    }
}

void character_rig_say(struct character_rig *self, const char *hex)
{
    self->count = 0;
    self->seen_count = 0;
    character_rig_say_at(self, 9600, 'E', hex);
}

/* `bytes` of a reply that began at `begin`, from character `first` of it on. */
void character_rig_expect_sent(const struct character_rig *self, size_t from, dg_ns begin,
                               size_t first, const char *hex)
{
    uint8_t bytes[DG_REPLY_MAX];
    const size_t n = hf_rig_hex(hex, bytes, sizeof bytes);

    assert_true(self->count >= from + n);
    for (size_t i = 0; i < n; i++) {
        const struct dg_tap_event *event = &self->sent[from + i].event;
        assert_int_equal(event->character.byte, bytes[i]);
        assert_int_equal(event->at - begin,
                         dg_bit_times_ns((uint32_t)(11 * (first + i + 1)), 9600));
    }
}

void character_rig_expect_answer(struct character_rig *self, const char *request, size_t place)
{
    const dg_ns begin = self->now + 3 * CHARACTER + ANSWER;

    character_rig_say(self, request);
    character_rig_pass_to(self, self->now + REST);
    assert_int_equal(self->count, 7);
    assert_int_equal(self->sent[0].place, place);
    assert_int_equal(self->sent[0].event.at, begin + CHARACTER);
    assert_int_equal(self->sent[6].event.at, begin + dg_bit_times_ns(77, 9600));
}

void character_rig_expect_silence(struct character_rig *self, const char *request)
{
    character_rig_say(self, request);
    character_rig_pass_to(self, self->now + REST);
    assert_int_equal(self->count, 0);
}

void character_rig_bend(struct character_rig *self, size_t place, enum dg_wire_fault fault,
                        uint32_t count)
{
    struct dg_faults *faults = &self->control[place].faults;

    faults->wire |= 1u << fault;
    faults->slot[fault] = (uint8_t)fault;
    faults->fault[fault] = (struct dg_fault){
        .active = true, .left = count, .probability_ppm = 1000000, .until = DG_NEVER};
}

const struct dg_hf *character_rig_device(const struct character_rig *self, size_t place)
{
    return dg_host_line_of(self->hosts[place])->device;
}
