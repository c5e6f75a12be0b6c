/* SPDX-License-Identifier: MIT */
/*
 *   loop    run(): asks lanes that have something to do, does that of lane 0, waits for the others
 *   thread  serve(): waits to be asked, takes its lane to `until`, says so
 *
 * `asked` and `busy` are under the lock; all else of a lane belongs to its thread while it is asked
 * to, and to the loop before and afterwards.
 */
#define _GNU_SOURCE
#include "silkit_lanes.h"

#include <stdlib.h>
#include <string.h>

#include "silkit_parts.h"

/* Lanes are written by different processors all the time: they do not share a line of a cache. */
#define APART 128u
/* 2^32 times the golden ratio, without its whole turn. */
#define GOLDEN 0x9E3779B9u

struct lane {
    struct lx_silkit *all;
    struct lx_strand *strand;
    struct lx_silkit_list mail; /* sorted */
    dg_ns until;
    uint64_t end;
    bool asked;
    pthread_cond_t ask;
    pthread_t thread;
    bool runs; /* the thread is there */
    uint8_t apart[APART];
};

struct lx_silkit_lanes {
    struct lane *lane; /* owned */
    size_t count;
    struct lx_silkit_port **port; /* owned list: those that have a lane, in their order */
    size_t port_count;
    pthread_mutex_t lock;
    pthread_cond_t done; /* nobody is busy */
    size_t busy;
    bool ends;
};

/* --- a lane --- */

static bool has_mail(const struct lane *self, uint64_t end)
{
    return self->mail.first < self->mail.count && self->mail.at[self->mail.first].time < end;
}

static bool is_lane_due(const struct lane *self, dg_ns until, uint64_t end)
{
    return lx_strand_next(self->strand) <= until || has_mail(self, end);
}

static void step_lane(struct lane *self)
{
    lx_strand_enter(self->strand);
    while (has_mail(self, self->end)) {
        const dg_ns at = lx_silkit_moment_of(self->all, self->mail.at[self->mail.first].time);
        while (lx_time_pass(at)) {
        }
        lx_silkit_deliver(self->all, &self->mail, at, self->end);
    }
    while (lx_time_pass(self->until)) {
    }
    lx_strand_enter(NULL);
    lx_silkit_list_trim(&self->mail);
}

static void *serve(void *ctx)
{
    struct lane *self = ctx;
    struct lx_silkit_lanes *lanes = self->all->lanes;
    (void)pthread_mutex_lock(&lanes->lock);
    while (!lanes->ends) {
        if (!self->asked) {
            (void)pthread_cond_wait(&self->ask, &lanes->lock);
            continue;
        }
        (void)pthread_mutex_unlock(&lanes->lock);
        step_lane(self);
        (void)pthread_mutex_lock(&lanes->lock);
        self->asked = false;
        if (--lanes->busy == 0) {
            (void)pthread_cond_signal(&lanes->done);
        }
    }
    (void)pthread_mutex_unlock(&lanes->lock);
    return NULL;
}

/* --- all of them --- */

static void ask_lane(struct lx_silkit_lanes *self, struct lane *lane)
{
    (void)pthread_mutex_lock(&self->lock);
    lane->asked = true;
    self->busy++;
    (void)pthread_cond_signal(&lane->ask);
    (void)pthread_mutex_unlock(&self->lock);
}

static void wait_for_all(struct lx_silkit_lanes *self)
{
    (void)pthread_mutex_lock(&self->lock);
    while (self->busy > 0) {
        (void)pthread_cond_wait(&self->done, &self->lock);
    }
    (void)pthread_mutex_unlock(&self->lock);
}

void lx_silkit_lanes_run(struct lx_silkit *self, dg_ns until, uint64_t end)
{
    struct lx_silkit_lanes *lanes = self->lanes;
    struct lane *own = NULL;
    bool asked = false;
    for (size_t i = lanes == NULL ? 0 : lanes->count; i-- > 0;) {
        struct lane *lane = &lanes->lane[i];
        lane->until = until;
        lane->end = end;
        if (!is_lane_due(lane, until, end)) {
            lx_strand_skip(lane->strand, until);
        } else if (!lane->runs) {
            own = lane;
        } else {
            ask_lane(lanes, lane);
            asked = true;
        }
    }
    if (own != NULL) {
        step_lane(own);
    }
    if (asked) {
        wait_for_all(lanes);
    }
}

/* Buses that are at work at the same moment are most often neighbours, or each tenth, or each
 * hundredth one. Multiples of the golden ratio spread all of these evenly over the lanes. */
static struct lane *home_of(const struct lx_silkit_lanes *self, size_t index)
{
    const uint32_t turn = (uint32_t)index * GOLDEN;
    return &self->lane[(uint64_t)turn * self->count >> 32u];
}

/* Somebody has begun to listen to a bus, or does not any more. */
static void find_place(struct lx_silkit_lanes *self, size_t index)
{
    struct lx_silkit_port *port = self->port[index];
    struct lane *home = home_of(self, index);
    const bool alone = !lx_tap_on(port->tap);
    if (alone != port->in_lane && lx_timer_move(port->timer, alone ? home->strand : NULL) == 0) {
        port->in_lane = alone;
        port->lane = (size_t)(home - self->lane);
    }
}

void lx_silkit_lanes_begin(struct lx_silkit *self)
{
    struct lx_silkit_lanes *lanes = self->lanes;
    struct lx_silkit_list *list = &self->pending;
    if (lanes == NULL) {
        return;
    }
    for (size_t i = 0; i < lanes->port_count; i++) {
        find_place(lanes, i);
    }
    size_t left = list->first;
    for (size_t i = list->first; i < list->count; i++) {
        const struct lx_silkit_message *message = &list->at[i];
        const struct lx_silkit_port *port = message->port;
        if (message->time >= self->at || !port->in_lane ||
            !lx_silkit_list_add(&lanes->lane[port->lane].mail, message)) {
            list->at[left++] = *message;
        }
    }
    list->count = left;
}

/* --- making --- */

static int start_threads(struct lx_silkit_lanes *self, struct lx_error *error)
{
    sigset_t before;
    int result = 0;
    lx_silkit_mask(&before);
    for (size_t i = 1; result == 0 && i < self->count; i++) {
        result = pthread_create(&self->lane[i].thread, NULL, serve, &self->lane[i]);
        self->lane[i].runs = result == 0;
    }
    lx_silkit_unmask(&before);
    return result == 0 ? 0 : lx_fail(error, "no thread for a rig: %s", strerror(result));
}

static bool make_lanes(struct lx_silkit_lanes *self, struct lx_silkit *all, size_t count)
{
    bool done = true;
    self->lane = calloc(count > 0 ? count : 1u, sizeof *self->lane);
    self->port = calloc(self->port_count, sizeof(struct lx_silkit_port *));
    if (self->lane == NULL || self->port == NULL) {
        return false;
    }
    self->count = count;
    for (size_t i = 0; i < count; i++) {
        self->lane[i].all = all;
        self->lane[i].strand = lx_strand_new();
        (void)pthread_cond_init(&self->lane[i].ask, NULL);
        done = done && self->lane[i].strand != NULL;
    }
    for (size_t i = 0, n = 0; i < all->count; i++) {
        if (all->port[i]->timer != NULL) {
            self->port[n++] = all->port[i];
        }
    }
    return done;
}

int lx_silkit_lanes_open(struct lx_silkit *self, struct lx_error *error)
{
    size_t ports = 0;
    for (size_t i = 0; i < self->count; i++) {
        ports += self->port[i]->timer != NULL ? 1u : 0u;
    }
    if (self->clock == NULL || ports == 0) {
        return 0;
    }
    struct lx_silkit_lanes *lanes = calloc(1, sizeof *lanes);
    if (lanes == NULL) {
        return lx_fail(error, "no memory for a rig");
    }
    self->lanes = lanes;
    lanes->port_count = ports;
    (void)pthread_mutex_init(&lanes->lock, NULL);
    (void)pthread_cond_init(&lanes->done, NULL);
    if (!make_lanes(lanes, self, self->threads < ports ? self->threads : ports)) {
        return lx_fail(error, "no memory for a rig");
    }
    return start_threads(lanes, error);
}

static void end_lane(struct lx_silkit_lanes *self, struct lane *lane)
{
    if (lane->runs) {
        (void)pthread_mutex_lock(&self->lock);
        self->ends = true;
        (void)pthread_cond_signal(&lane->ask);
        (void)pthread_mutex_unlock(&self->lock);
        (void)pthread_join(lane->thread, NULL);
        lane->runs = false;
    }
    lx_silkit_list_free(&lane->mail);
}

void lx_silkit_lanes_end(struct lx_silkit *self)
{
    for (size_t i = 0; self->lanes != NULL && i < self->lanes->count; i++) {
        end_lane(self->lanes, &self->lanes->lane[i]);
    }
}

void lx_silkit_lanes_free(struct lx_silkit *self)
{
    struct lx_silkit_lanes *lanes = self->lanes;
    if (lanes == NULL) {
        return;
    }
    for (size_t i = 0; i < lanes->count; i++) {
        lx_strand_free(lanes->lane[i].strand);
        (void)pthread_cond_destroy(&lanes->lane[i].ask);
    }
    (void)pthread_cond_destroy(&lanes->done);
    (void)pthread_mutex_destroy(&lanes->lock);
    free(lanes->port);
    free(lanes->lane);
    free(lanes);
    self->lanes = NULL;
}
