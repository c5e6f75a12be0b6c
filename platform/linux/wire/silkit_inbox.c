/* SPDX-License-Identifier: MIT */
/*
 *   threads of the library                    loop
 *   handler --- put(), lock, wake ---> list --- take(), lock ---> list of its own
 *
 * The library may call late (until the participant has left, so this outlives it) and twice.
 */
#define _GNU_SOURCE
#include "silkit_inbox.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

/* A loop that is stopped by a debugger takes nothing, and somebody goes on sending. */
#define MESSAGES_MAX 1000000u
#define BYTES_MAX (64u << 20u)
#define LIST_FIRST 64u

const uint8_t *lx_silkit_bytes(const struct lx_silkit_message *self)
{
    return self->bytes == NULL ? self->few : self->bytes;
}

/* --- lists --- */

bool lx_silkit_list_add(struct lx_silkit_list *self, const struct lx_silkit_message *message)
{
    if (self->count == self->capacity) {
        const size_t capacity = self->capacity == 0 ? LIST_FIRST : 2u * self->capacity;
        struct lx_silkit_message *at = reallocarray(self->at, capacity, sizeof *at);
        if (at == NULL) {
            return false;
        }
        self->at = at;
        self->capacity = capacity;
    }
    self->at[self->count++] = *message;
    return true;
}

void lx_silkit_list_trim(struct lx_silkit_list *self)
{
    const size_t left = self->count - self->first;
    if (left > 0 && self->first > 0) {
        memmove(self->at, self->at + self->first, left * sizeof *self->at);
    }
    self->first = 0;
    self->count = left;
}

void lx_silkit_list_free(struct lx_silkit_list *self)
{
    for (size_t i = self->first; i < self->count; i++) {
        free(self->at[i].bytes);
    }
    free(self->at);
    *self = (struct lx_silkit_list){0};
}

/* --- any thread --- */

static bool add_message(struct lx_silkit_inbox *self, struct lx_silkit_message *message, size_t n)
{
    const bool fits = self->list.count < MESSAGES_MAX && n <= BYTES_MAX - self->bytes;
    message->order = self->order++;
    if (!fits || !lx_silkit_list_add(&self->list, message)) {
        return false;
    }
    self->bytes += n;
    return true;
}

/* What decides about the rig's life comes through whatever there is no room for. */
static void note_end(struct lx_silkit_inbox *self, enum lx_silkit_kind kind)
{
    if (kind == LX_SILKIT_SHUTDOWN || kind == LX_SILKIT_ABORTED) {
        self->ended = true;
        (void)pthread_cond_broadcast(&self->over);
    }
}

void lx_silkit_inbox_put(struct lx_silkit_inbox *self, const struct lx_silkit_message *message,
                         const void *bytes, size_t n)
{
    const uint64_t one = 1;
    struct lx_silkit_message copy = *message;
    copy.length = n;
    copy.bytes = n > LX_SILKIT_SHORT ? malloc(n) : NULL;
    if (n > LX_SILKIT_SHORT ? copy.bytes != NULL : n > 0) {
        memcpy(copy.bytes == NULL ? copy.few : copy.bytes, bytes, n);
    }
    const bool whole = copy.bytes != NULL || n <= LX_SILKIT_SHORT;
    (void)pthread_mutex_lock(&self->lock);
    note_end(self, message->kind);
    const bool wanted = !self->closed;
    const bool first = self->list.count == 0;
    const bool added = wanted && whole && add_message(self, &copy, copy.bytes == NULL ? 0 : n);
    self->lost += wanted && !added ? 1u : 0u;
    (void)pthread_mutex_unlock(&self->lock);
    if (!added) {
        free(copy.bytes);
    }
    if (first) { /* else the loop is to come already */
        (void)!write(self->wakes, &one, sizeof one);
    }
}

/* --- the loop --- */

int lx_silkit_inbox_open(struct lx_silkit_inbox *self)
{
    pthread_condattr_t clock;
    *self = (struct lx_silkit_inbox){.wakes = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    if (self->wakes < 0) {
        return -errno;
    }
    (void)pthread_mutex_init(&self->lock, NULL);
    (void)pthread_condattr_init(&clock);
    (void)pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    (void)pthread_cond_init(&self->over, &clock);
    (void)pthread_condattr_destroy(&clock);
    return 0;
}

void lx_silkit_inbox_close(struct lx_silkit_inbox *self)
{
    if (self->wakes < 0) {
        return;
    }
    (void)close(self->wakes);
    self->wakes = -1;
    lx_silkit_list_free(&self->list);
    (void)pthread_cond_destroy(&self->over);
    (void)pthread_mutex_destroy(&self->lock);
}

uint64_t lx_silkit_inbox_take(struct lx_silkit_inbox *self, struct lx_silkit_list *list)
{
    (void)pthread_mutex_lock(&self->lock);
    for (size_t i = 0; i < self->list.count; i++) {
        if (!lx_silkit_list_add(list, &self->list.at[i])) {
            free(self->list.at[i].bytes);
            self->lost++;
        }
    }
    self->list.count = 0;
    self->bytes = 0;
    const uint64_t lost = self->lost;
    (void)pthread_mutex_unlock(&self->lock);
    return lost;
}

bool lx_silkit_inbox_wait(struct lx_silkit_inbox *self, unsigned ms)
{
    struct timespec end;
    (void)clock_gettime(CLOCK_MONOTONIC, &end);
    end.tv_sec += (time_t)(ms / 1000u);
    end.tv_nsec += (long)(ms % 1000u) * 1000000;
    if (end.tv_nsec >= 1000000000) {
        end.tv_sec++;
        end.tv_nsec -= 1000000000;
    }
    (void)pthread_mutex_lock(&self->lock);
    self->closed = true;
    int result = 0;
    while (!self->ended && result == 0) {
        result = pthread_cond_timedwait(&self->over, &self->lock, &end);
    }
    const bool ended = self->ended;
    (void)pthread_mutex_unlock(&self->lock);
    return ended;
}
