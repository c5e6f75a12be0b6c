/* SPDX-License-Identifier: MIT */
/*
 * Shafts of a rig that takes part in a SIL Kit simulation:
 *
 *   PARTICIPANT/shaft/NAME/turn --> where it is, and how fast it goes on from there
 *   PARTICIPANT/shaft/NAME      <-- the same, at each step in which it does not go on as it said
 *
 * Both are 16 bytes, little endian: angle in 2^-32 turns, speed in 2^-32 turns a second.
 *
 * A plant has a thousand shafts, and most of them go on with one speed. Nobody looks at such a one
 * before it is turned again or SURE is over; then what the speed's last bit is short of adds up to
 * one bit of the angle.
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>

#include "drehgeber/bits.h"
#include "rig_parts.h"

#define MEDIA_TYPE "application/vnd.drehgeber.shaft.v1"
#define SIZE 16u
#define TURN INT64_C(0x100000000)
#define MRPM_PER_RPS 60000
#define PRPM_PER_MRPM INT64_C(1000000000)
#define SURE DG_S(1)

/* A shaft's topics. */
struct lx_rig_topics {
    struct lx_rig *rig;
    struct lx_rig_shaft *shaft;
    struct lx_silkit_port turn;
    struct lx_silkit_port position;
    const struct lx_rig_topics *driver; /* NULL: it turns by itself */
    unsigned turns;                     /* of it and all that drive it, when it was said last */
    dg_ns look;                         /* it goes on as said until then */
};

static int64_t load_number(const uint8_t *from)
{
    return (int64_t)((uint64_t)dg_load_le32(from) | (uint64_t)dg_load_le32(from + 4) << 32u);
}

/* To the nearest 0.001 rpm, at most what a shaft can do; in 10^-12 rpm. */
static int64_t prpm_of(int64_t speed)
{
    const int64_t limit = (int64_t)DG_MOTION_SPEED_MAX_MRPM * (TURN / MRPM_PER_RPS);
    const int64_t most = speed > limit ? limit : speed < -limit ? -limit : speed;
    const int64_t half = most < 0 ? -TURN / 2 : TURN / 2;
    return (most * MRPM_PER_RPS + half) / TURN * PRPM_PER_MRPM;
}

static void receive(void *ctx, dg_ns now, const struct lx_silkit_message *message, bool last)
{
    struct lx_rig_topics *self = ctx;
    const uint8_t *bytes = lx_silkit_bytes(message);
    struct dg_rig *control = self->rig->control;
    struct dg_rig_shaft *shaft = self->shaft->control;
    (void)last;
    lx_rig_read_none(self->shaft);
    lx_rig_ops.turns(control, shaft, now);
    (void)dg_shaft_turn(&shaft->shaft, now, load_number(bytes), prpm_of(load_number(bytes + 8)));
    lx_rig_ops.turned(control, shaft, now);
}

/* How often it was turned so far, by whatever drives it, too. */
static unsigned count_turns(const struct lx_rig_topics *self)
{
    unsigned turns = 0;
    for (; self != NULL; self = self->driver) {
        turns += self->shaft->turns;
    }
    return turns;
}

/* Whether it turns with one speed from `now` on, until somebody turns it. */
static bool is_steady(const struct lx_rig_topics *self, dg_ns now)
{
    while (self->driver != NULL) {
        self = self->driver;
    }
    const struct dg_shaft *shaft = &self->shaft->control->shaft;
    const enum dg_motion_kind kind = shaft->course.motion.kind;
    return shaft->course.plays ? kind == DG_MOTION_STANDSTILL || kind == DG_MOTION_SPEED
                               : dg_shaft_settled(shaft) <= now;
}

static void step_shafts(void *ctx, dg_ns now)
{
    struct lx_rig_topics *self = ctx;
    struct dg_shaft *shaft = &self->shaft->control->shaft;
    const unsigned turns = count_turns(self);
    if (turns == self->turns && now < self->look) {
        return;
    }
    self->turns = turns;
    self->look = is_steady(self, now) ? dg_after(now, SURE) : 0;
    const int64_t speed = (int64_t)dg_shaft_mrpm(shaft, now) * TURN / MRPM_PER_RPS;
    uint8_t bytes[SIZE];
    dg_store_le64(bytes, (uint64_t)dg_shaft_angle(shaft, now));
    dg_store_le64(bytes + 8, (uint64_t)speed);
    lx_silkit_publish(&self->position, bytes, sizeof bytes);
}

static int open_shaft(struct lx_rig_topics *self, struct lx_error *error)
{
    struct lx_silkit *silkit = self->rig->silkit;
    char name[LX_SILKIT_TOPIC_MAX / 2u];
    self->turn = (struct lx_silkit_port){
        .length_min = SIZE, .length_max = SIZE, .receive = receive, .ctx = self};
    self->position = (struct lx_silkit_port){.step = step_shafts, .ctx = self};
    (void)snprintf(name, sizeof name, "%s/shaft", lx_silkit_name(silkit));
    lx_silkit_name_topic(&self->position, name, self->shaft->control->name);
    if (lx_silkit_offer(silkit, &self->position, MEDIA_TYPE, error) != 0) {
        return -1;
    }
    if (self->shaft->control->shaft.driver != NULL) {
        return 0; /* another one turns it */
    }
    lx_silkit_name_topic(&self->turn, self->position.topic, "turn");
    return lx_silkit_subscribe(silkit, &self->turn, MEDIA_TYPE, error);
}

int lx_rig_join(struct lx_rig *self, struct lx_error *error)
{
    const size_t count = self->setup.plan->shaft_count;
    if (!lx_silkit_has_joined(self->silkit)) {
        return 0;
    }
    self->topics = lx_allocate(count * sizeof *self->topics, "the shafts", error);
    if (self->topics == NULL) {
        return -1;
    }
    int result = 0;
    for (size_t i = 0; result == 0 && i < count; i++) {
        self->topics[i].rig = self;
        const int driver = self->setup.plan->shafts[i].driver;
        self->topics[i].shaft = &self->shafts[i];
        self->topics[i].driver = driver < 0 ? NULL : &self->topics[driver];
        result = open_shaft(&self->topics[i], error);
    }
    return result == 0 ? lx_silkit_start(self->silkit, error) : -1;
}
