/* SPDX-License-Identifier: MIT */
/*
 * What all buses have in common: the queue.
 *
 *   lx_can_send --> write() --no room--> queue, reading paused
 *   1 ms timer ---> write() ... until it is empty, flush() --> reading goes on, settle()
 *
 * On a wire that keeps the pace:
 *
 *   lx_can_send --> write() --the frame before is still on the wire--> queue
 *   timer, when it is through --> write() the next one
 *   the queue is full --> reading paused; half of it is gone --> reading goes on, settle()
 *
 * A CAN socket without room does not become writable in the eyes of poll() (its limit is the
 * interface's queue, not the socket's), so time it is that says when to try again.
 */
#include "can.h"

#include <stdlib.h>
#include <string.h>

#include "can_load.h"

#define RETRY DG_MS(1)
/* A wire that takes nothing at all is asked less and less often. */
#define RETRY_MAX DG_MS(64)
/* So much of what a late timer has cost is made up for. */
#define CATCH_UP DG_MS(5)

/* --- the wire --- */

/* One that has come in cannot have begun before the one before it was through. Of frames that come
   faster than the wire is, the present one counts, so that a flood does not add up to silence. */
void lx_can_count(struct lx_can *self, uint32_t bits)
{
    self->bits += bits;
    if (self->pace == 0) {
        return;
    }
    const dg_ns now = lx_now();
    const dg_ns longest = dg_bit_times_ns(LX_CAN_BITS(1u, 8u), self->pace);
    const dg_ns span = dg_bit_times_ns(bits, self->pace);
    if (self->busy_until > dg_elapsed(now, span)) {
        const dg_ns latest = dg_after(now, longest + span);
        self->busy_until = dg_earliest(dg_after(self->busy_until, span), latest);
    }
}

uint64_t lx_can_bits(const struct lx_can *self)
{
    return self->ops->bits == NULL ? self->bits : self->ops->bits(self);
}

static bool is_free(const struct lx_can *self, dg_ns now)
{
    return self->pace == 0 || self->busy_until <= now;
}

/* A frame that has waited for its time follows the one before it at once, however late the timer
   was, within bounds; another one begins now. */
static bool put(struct lx_can *self, dg_ns now, const struct dg_can_frame *frame, bool waited)
{
    const uint32_t bits = LX_CAN_BITS(1u, lx_can_bytes(frame));
    const dg_ns earliest = dg_elapsed(now, CATCH_UP);
    if (!self->ops->write(self, frame)) {
        return false;
    }
    self->bits += bits;
    if (self->pace != 0) {
        const bool follows = waited && self->busy_until > earliest;
        const dg_ns begin = !waited ? now : follows ? self->busy_until : earliest;
        self->busy_until = dg_after(begin, dg_bit_times_ns(bits, self->pace));
    }
    return true;
}

/* --- the queue --- */

/* @return false when the wire has no room; what only waits for its time stays, too */
static bool drain(struct lx_can *self, dg_ns now)
{
    while (self->count > 0 && is_free(self, now)) {
        if (!put(self, now, &self->queue[self->first], true)) {
            return false;
        }
        self->first++;
        self->count--;
        self->delay = RETRY;
    }
    if (self->count == 0) {
        self->first = 0;
    }
    return true;
}

static void hold(struct lx_can *self)
{
    if (!self->stalled) {
        self->stalled = true;
        self->counters.stalls++;
        self->ops->pause(self, true);
    }
}

static void release(struct lx_can *self, dg_ns now)
{
    if (self->stalled) {
        self->stalled = false;
        self->ops->pause(self, false);
        self->setup.settle(self->setup.ctx, now);
    }
}

static void try_again(void *ctx, dg_ns now)
{
    struct lx_can *self = ctx;
    self->delay = self->delay < RETRY_MAX ? 2 * self->delay : RETRY_MAX;
    if (!drain(self, now) || (self->ops->flush != NULL && !self->ops->flush(self))) {
        hold(self);
        lx_timer_at(&self->retry, dg_after(now, self->delay));
        return;
    }
    if (self->ops->push != NULL) {
        self->ops->push(self);
    }
    if (self->count > 0) {
        lx_timer_at(&self->retry, self->busy_until);
    }
    if (self->count <= LX_CAN_PACED_MAX / 2u) {
        release(self, now);
    }
}

void lx_can_stall(struct lx_can *self)
{
    if (self->stalled) {
        return;
    }
    hold(self);
    self->delay = RETRY;
    lx_timer_at(&self->retry, dg_after(lx_now(), RETRY));
}

/* Room for one more: that of frames that are gone, or new. Frames come in and deadlines are met
   only while little waits, so that and what one frame or one moment makes all encoders send is the
   most it ever holds. */
static bool make_room(struct lx_can *self)
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
static void append(struct lx_can *self, const struct dg_can_frame *frame)
{
    if (!make_room(self)) {
        self->counters.lost++;
        return;
    }
    self->queue[self->first + self->count] = *frame;
    self->count++;
}

void lx_can_send(struct lx_can *self, const struct dg_can_frame *frame)
{
    const dg_ns now = self->pace == 0 ? 0 : lx_now();
    const bool in_turn = self->count == 0 && is_free(self, now);
    if (in_turn && !self->stalled && put(self, now, frame, false)) {
        return;
    }
    append(self, frame);
    if (in_turn) {
        lx_can_stall(self);
        return;
    }
    if (self->count == 1) {
        lx_timer_at(&self->retry, self->busy_until);
    }
    if (self->count >= LX_CAN_PACED_MAX) {
        hold(self);
    }
}

void lx_can_discard(struct lx_can *self)
{
    self->counters.lost += self->count;
    self->first = 0;
    self->count = 0;
}

int lx_can_init(struct lx_can *self, const struct lx_can_ops *ops, const struct lx_can_setup *setup,
                struct lx_error *error)
{
    self->ops = ops;
    self->setup = *setup;
    const int result = lx_timer_open(&self->retry, setup->event, try_again, self);
    return result < 0 ? lx_fail(error, "no timer: %s", strerror(-result)) : 0;
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
