/* SPDX-License-Identifier: MIT */
/*
 * What all buses have in common: the queue.
 *
 *   lx_can_send --> write() --no room--> queue, reading paused
 *   1 ms timer ---> write() ... until it is empty, flush() --> reading goes on, settle()
 *
 * A CAN socket without room does not become writable in the eyes of poll() (its limit is the
 * interface's queue, not the socket's), so time it is that says when to try again.
 */
#include "can.h"

#include <stdlib.h>
#include <string.h>

#define RETRY DG_MS(1)
/* A wire that takes nothing at all is asked less and less often. */
#define RETRY_MAX DG_MS(64)
/* --- the queue --- */

/* @return false when the wire has no room */
static bool drain_queue(struct lx_can *self)
{
    while (self->count > 0) {
        if (!self->ops->write(self, &self->queue[self->first])) {
            return false;
        }
        self->first++;
        self->count--;
        self->delay = RETRY;
    }
    self->first = 0;
    return true;
}

static void pause_wire(struct lx_can *self, bool paused)
{
    if (self->ops->pause != NULL) {
        self->ops->pause(self, paused);
    }
}

static void hold_reading(struct lx_can *self)
{
    if (!self->stalled) {
        self->stalled = true;
        self->counters.stalls++;
        pause_wire(self, true);
    }
}

static void release_reading(struct lx_can *self, dg_ns now)
{
    if (self->stalled) {
        self->stalled = false;
        pause_wire(self, self->crowded);
        self->setup.settle(self->setup.ctx, now);
    }
}

void lx_can_crowd(struct lx_can *self, bool crowded)
{
    if (self->crowded != crowded) {
        self->crowded = crowded;
        pause_wire(self, lx_can_is_paused(self));
    }
}

static void try_again(void *ctx, dg_ns now)
{
    struct lx_can *self = ctx;
    self->delay = self->delay < RETRY_MAX ? 2 * self->delay : RETRY_MAX;
    if (!drain_queue(self) || (self->ops->flush != NULL && !self->ops->flush(self))) {
        hold_reading(self);
        lx_timer_at(&self->retry, dg_after(now, self->delay));
        return;
    }
    if (self->ops->push != NULL) {
        self->ops->push(self);
    }
    release_reading(self, now);
}

void lx_can_stall(struct lx_can *self)
{
    if (self->stalled) {
        return;
    }
    hold_reading(self);
    self->delay = RETRY;
    lx_timer_at(&self->retry, dg_after(lx_now(), RETRY));
}

/* Room for one more: that of frames that are gone, or new. Frames come in and deadlines are met
   only while little waits, so that and what one frame or one moment makes all encoders send is the
   most it ever holds. */
static bool make_frame_room(struct lx_can *self)
{
    if (self->first + self->count < self->capacity) {
        return true;
    }
    if (self->first > self->capacity / 2u) {
        memmove(self->queue, self->queue + self->first, self->count * sizeof *self->queue);
        self->first = 0;
        return true;
    }
    const size_t capacity = self->capacity == 0 ? 64 : 2 * self->capacity;
    struct dg_can_frame *queue = realloc(self->queue, capacity * sizeof *queue);
    if (queue == NULL) {
        return false;
    }
    self->queue = queue;
    self->capacity = capacity;
    return true;
}

/* Behind all others. */
static void append_frame(struct lx_can *self, const struct dg_can_frame *frame)
{
    if (!make_frame_room(self)) {
        self->counters.lost++;
        return;
    }
    self->queue[self->first + self->count] = *frame;
    self->count++;
}

void lx_can_send(struct lx_can *self, const struct dg_can_frame *frame)
{
    const bool in_turn = self->count == 0 && !self->stalled;
    if (in_turn && self->ops->write(self, frame)) {
        return;
    }
    append_frame(self, frame);
    if (in_turn) {
        lx_can_stall(self);
    }
}

void lx_can_discard(struct lx_can *self)
{
    self->counters.lost += self->count;
    self->first = 0;
    self->count = 0;
}

struct lx_can *lx_can_make(const struct lx_can_kind *kind, const struct lx_can_setup *setup,
                           struct lx_error *error)
{
    struct lx_can *self = lx_allocate(kind->size, "a CAN bus", error);
    if (self == NULL) {
        return NULL;
    }
    self->kind = kind;
    self->ops = kind->ops;
    self->setup = *setup;
    self->company = DG_BUS_SOMEBODY;
    /* Nobody waits for the timer before the bus is there. */
    if (kind->start(self, error) != 0 ||
        lx_timer_make(&self->retry, setup->event, try_again, self, error) != 0) {
        lx_can_close(self);
        return NULL;
    }
    return self;
}

bool lx_can_is_up(const struct lx_can *self)
{
    return self->ops->up == NULL || self->ops->up(self);
}

void lx_can_close(struct lx_can *self)
{
    if (self == NULL) {
        return;
    }
    self->ops->close(self);
    lx_timer_close(&self->retry);
    free(self->queue);
    free(self);
}
