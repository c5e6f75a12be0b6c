/* SPDX-License-Identifier: MIT */
/*
 *   device -- write, sync --> bytes
 *                        \--> jobs -- line --> thread -- write, sync --> file
 *   loop <-- eventfd -- news, done --------------/
 *
 * The thread takes a queue's jobs up to the first sync, then it is the next queue's turn. A part
 * that fails stays at the front and stops its queue. Two things can be the case then:
 *
 * - Nobody has been told yes for what failed, as the disk said no within a moment. Then the sync
 *   says no, too, the queue is emptied, and the device reads what the file has become: all is as if
 *   it had worked on the file itself.
 * - The device went on, and may have written more since. It cannot be told any more: its next
 *   writes are refused, and each of them makes the thread try again from the part that failed on,
 *   in the old order, so that power may fail in between. Only when it is through with all of it the
 *   device may write again.
 *
 * The lock is held for moments only, never while the disk works. What is not shared belongs to the
 * loop; the memory below belongs to the thread while its queue is lined up. A bus may be stepped on
 * another thread while the loop stands still (silkit_lanes.c): then the device's side is there, and
 * what all queues share has the lock.
 */
#define _GNU_SOURCE
#include "nvm_writer.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include "nvm_memory.h"
#include "timer.h"

/* It writes, syncs, and prints a line. */
#define STACK_BYTES ((size_t)256 * 1024)
/* What an end waits for the disk before it says so. */
#define PATIENCE DG_S(1)

struct lx_nvm_job {
    struct lx_nvm_job *next;
    uint64_t ticket; /* of a sync; 0: a write */
    uint32_t address;
    uint32_t size;
    uint8_t bytes[];
};

struct lx_nvm_writer {
    sd_event *event;
    void (*settled)(void *ctx);
    void *ctx;
    struct lx_nvm_queue *open; /* queues */
    uint64_t issued;
    bool on_trial;
    bool runs;
    pthread_t thread;
    int wake; /* eventfd */
    sd_event_source *io;
    pthread_mutex_t lock;
    pthread_cond_t work;
    pthread_cond_t progress;
    /* what the thread looks at, too */
    struct lx_nvm_queue *first; /* in line */
    struct lx_nvm_queue *last;
    struct lx_nvm_queue *news;         /* queues that have some, the latest first */
    const struct lx_nvm_queue *served; /* its part is being carried out, since */
    dg_ns began;
    bool ends;
};

/* --- jobs --- */

static void append_jobs(struct lx_nvm_jobs *self, struct lx_nvm_job *first, struct lx_nvm_job *last)
{
    if (self->first == NULL) {
        self->first = first;
    } else {
        self->last->next = first;
    }
    self->last = last;
    last->next = NULL;
}

static void free_all(struct lx_nvm_jobs *self)
{
    while (self->first != NULL) {
        struct lx_nvm_job *job = self->first;
        self->first = job->next;
        free(job);
    }
}

static struct lx_nvm_job *make_job(uint64_t ticket, uint32_t address, const void *from, size_t n)
{
    struct lx_nvm_job *job = malloc(sizeof *job + n);
    if (job != NULL) {
        *job = (struct lx_nvm_job){.ticket = ticket, .address = address, .size = (uint32_t)n};
        if (n > 0) {
            memcpy(job->bytes, from, n);
        }
    }
    return job;
}

/* --- the thread --- */

static void line_up(struct lx_nvm_queue *queue)
{
    struct lx_nvm_writer *self = queue->setup.writer;
    if (queue->lined_up) {
        return;
    }
    queue->lined_up = true;
    queue->behind = NULL;
    if (self->first == NULL) {
        self->first = queue;
    } else {
        self->last->behind = queue;
    }
    self->last = queue;
    (void)pthread_cond_signal(&self->work);
}

/* @return NULL: it ends */
static struct lx_nvm_queue *next_in_line(struct lx_nvm_writer *self)
{
    while (self->first == NULL && !self->ends) {
        (void)pthread_cond_wait(&self->work, &self->lock);
    }
    struct lx_nvm_queue *queue = self->first;
    if (queue != NULL) {
        self->first = queue->behind;
    }
    return queue;
}

/* The part that is done in one go: up to the first sync. */
static struct lx_nvm_job *end_of_part(const struct lx_nvm_queue *queue)
{
    struct lx_nvm_job *job = queue->jobs.first;
    while (job->ticket == 0 && job->next != NULL) {
        job = job->next;
    }
    return job;
}

/* Without the lock. The loop may hang more behind the last job meanwhile, so its `next` is not
   looked at. */
static int carry_out(const struct dg_nvm *nvm, const struct lx_nvm_job *first,
                     const struct lx_nvm_job *last)
{
    for (const struct lx_nvm_job *job = first;; job = job->next) {
        const int result = job->ticket != 0
                               ? nvm->ops->sync(nvm->ctx)
                               : nvm->ops->write(nvm->ctx, job->address, job->bytes, job->size);
        if (result != DG_OK || job == last) {
            return result;
        }
    }
}

static void finish_jobs(struct lx_nvm_queue *queue, struct lx_nvm_job *last)
{
    struct lx_nvm_job *first = queue->jobs.first;
    queue->done = last->ticket != 0 ? last->ticket : queue->done;
    queue->jobs.first = last->next; /* `last` of an empty list is not looked at */
    append_jobs(&queue->spent, first, last);
    queue->lined_up = false;
    if (queue->jobs.first != NULL) {
        line_up(queue);
    } else {
        queue->stalled = false;
    }
}

static void tell_loop(struct lx_nvm_writer *self, struct lx_nvm_queue *queue)
{
    const uint64_t one = 1;
    if (!queue->news) {
        queue->news = true;
        queue->tells = self->news;
        self->news = queue;
    }
    const ssize_t written = write(self->wake, &one, sizeof one);
    (void)written; /* it cannot overflow, and else it is readable already */
}

static void serve_queue(struct lx_nvm_writer *self, struct lx_nvm_queue *queue)
{
    struct lx_nvm_job *first = queue->jobs.first;
    struct lx_nvm_job *last = end_of_part(queue);
    const bool synced = last->ticket != 0;
    self->served = queue;
    self->began = lx_real_now();
    (void)pthread_cond_broadcast(&self->progress);
    (void)pthread_mutex_unlock(&self->lock);
    const int result = carry_out(&queue->setup.below, first, last);
    (void)pthread_mutex_lock(&self->lock);
    self->served = NULL;
    if (result == DG_OK) {
        finish_jobs(queue, last);
    } else {
        queue->stalled = true;
        queue->lined_up = false;
    }
    if (synced || queue->stalled) {
        tell_loop(self, queue);
    }
    (void)pthread_cond_broadcast(&self->progress);
}

static void *run(void *ctx)
{
    struct lx_nvm_writer *self = ctx;
    struct lx_nvm_queue *queue = NULL;
    (void)pthread_mutex_lock(&self->lock);
    while ((queue = next_in_line(self)) != NULL) {
        serve_queue(self, queue);
    }
    (void)pthread_mutex_unlock(&self->lock);
    return NULL;
}

/* --- the device's side --- */

static int read_copy(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct lx_nvm_queue *self = ctx;
    return lx_nvm_read(self->bytes, self->setup.size, address, to, n);
}

/* With the lock: what a queue that has stalled does about it, see above. @return DG_ERR_IO */
static int refuse_write(struct lx_nvm_queue *self)
{
    if (self->lined_up) {
        return DG_ERR_IO; /* it is being tried again */
    }
    if (self->issued != self->done) {
        line_up(self);
        return DG_ERR_IO;
    }
    append_jobs(&self->spent, self->jobs.first, self->jobs.last);
    self->jobs = (struct lx_nvm_jobs){NULL, NULL};
    self->stalled = false;
    self->emptied = true;
    return DG_ERR_IO;
}

/* Give the lock back. The thread has no job of a queue that was emptied, so its memory is read
   without the lock. @return `result` */
static int unlock_with(struct lx_nvm_queue *self, int result)
{
    const struct dg_nvm *below = &self->setup.below;
    (void)pthread_mutex_unlock(&self->setup.writer->lock);
    if (self->emptied) {
        self->emptied = false;
        (void)below->ops->read(below->ctx, 0, self->bytes, self->setup.size);
    }
    return result;
}

static int write_later(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct lx_nvm_queue *self = ctx;
    struct lx_nvm_writer *writer = self->setup.writer;
    const bool inside = lx_nvm_inside(self->setup.size, address, n);
    struct lx_nvm_job *job = inside ? make_job(0, address, from, n) : NULL;
    int result = DG_ERR_IO;
    if (job == NULL) {
        return result;
    }
    (void)pthread_mutex_lock(&writer->lock);
    if (self->stalled) {
        append_jobs(&self->spent, job, job);
        result = refuse_write(self);
    } else {
        append_jobs(&self->jobs, job, job);
        line_up(self);
        memcpy(self->bytes + address, from, n);
        result = DG_OK;
    }
    return unlock_with(self, result);
}

/* When the moment that began at `begin` is over. The disk may be busy with another file. */
static dg_ns end_of_moment(const struct lx_nvm_queue *self, dg_ns begin)
{
    const struct lx_nvm_writer *writer = self->setup.writer;
    const dg_ns most = dg_after(begin, LX_NVM_MOMENT_MAX);
    if (writer->served == NULL) {
        return most;
    }
    const dg_ns since = writer->served == self ? writer->began : begin;
    return dg_earliest(most, dg_after(since, LX_NVM_MOMENT));
}

static struct timespec to_timespec(dg_ns moment)
{
    return (struct timespec){.tv_sec = (time_t)(moment / DG_S(1)),
                             .tv_nsec = (long)(moment % DG_S(1))};
}

/* With the lock: until the sync is decided, or the moment is over. */
static void wait_a_moment(const struct lx_nvm_queue *self)
{
    struct lx_nvm_writer *writer = self->setup.writer;
    const dg_ns begin = lx_real_now();
    dg_ns end = end_of_moment(self, begin);
    while (self->done != self->issued && !self->stalled && lx_real_now() < end) {
        const struct timespec until = to_timespec(end);
        (void)pthread_cond_timedwait(&writer->progress, &writer->lock, &until);
        end = end_of_moment(self, begin);
    }
}

/* With the lock. Behind others that are under way the moment has been taken already. */
static int issue_job(struct lx_nvm_queue *self, struct lx_nvm_job *job)
{
    const bool alone = self->issued == self->done;
    self->issued = job->ticket;
    append_jobs(&self->jobs, job, job);
    line_up(self);
    if (alone) {
        wait_a_moment(self);
    }
    if (alone && self->stalled) {
        self->issued = self->done; /* nobody has been told yes */
        return refuse_write(self);
    }
    self->waits += alone && self->done != self->issued ? 1u : 0u;
    return DG_OK;
}

static int sync_later(void *ctx)
{
    struct lx_nvm_queue *self = ctx;
    struct lx_nvm_writer *writer = self->setup.writer;
    struct lx_nvm_job *job = make_job(0, 0, NULL, 0);
    if (job == NULL) {
        return DG_ERR_IO;
    }
    (void)pthread_mutex_lock(&writer->lock);
    job->ticket = ++writer->issued;
    int result = DG_ERR_IO;
    if (self->stalled) {
        append_jobs(&self->spent, job, job);
        result = refuse_write(self);
    } else {
        result = issue_job(self, job);
    }
    return unlock_with(self, result);
}

static const struct dg_nvm_ops queue_ops = {
    .read = read_copy, .write = write_later, .sync = sync_later};

/* --- the loop's side --- */

/* @return a queue that has news, and has it no more; NULL: none has */
static struct lx_nvm_queue *take_news(struct lx_nvm_writer *self)
{
    struct lx_nvm_jobs spent = {NULL, NULL};
    (void)pthread_mutex_lock(&self->lock);
    struct lx_nvm_queue *queue = self->news;
    if (queue != NULL) {
        self->news = queue->tells;
        queue->news = false;
        spent = queue->spent;
        queue->spent = (struct lx_nvm_jobs){NULL, NULL};
    }
    (void)pthread_mutex_unlock(&self->lock);
    free_all(&spent);
    return queue;
}

static int on_wake(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct lx_nvm_writer *self = ctx;
    uint64_t count = 0;
    const ssize_t taken = read(fd, &count, sizeof count);
    (void)taken;
    (void)source;
    (void)events;
    for (struct lx_nvm_queue *queue = take_news(self); queue != NULL; queue = take_news(self)) {
        if (queue->setup.settled != NULL) {
            queue->setup.settled(queue->setup.ctx, lx_now());
        }
    }
    if (self->settled != NULL) {
        self->settled(self->ctx);
    }
    return 0;
}

/* Signals are the loop's. @return 0 or an errno */
static int start_thread(struct lx_nvm_writer *self)
{
    pthread_attr_t attributes;
    sigset_t all;
    sigset_t before;
    int reason = pthread_attr_init(&attributes);
    if (reason != 0) {
        return reason;
    }
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &before);
    reason = pthread_attr_setstacksize(&attributes, STACK_BYTES);
    if (reason == 0) {
        reason = pthread_create(&self->thread, &attributes, run, self);
    }
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    (void)pthread_attr_destroy(&attributes);
    self->runs = reason == 0;
    return reason;
}

/* @return 0 or an errno */
static int start_writer(struct lx_nvm_writer *self)
{
    if (self->runs) {
        return 0;
    }
    self->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (self->wake < 0) {
        return errno;
    }
    int result = self->event == NULL
                     ? 0
                     : sd_event_add_io(self->event, &self->io, self->wake, EPOLLIN, on_wake, self);
    if (result >= 0 && self->io != NULL) {
        result = sd_event_source_set_priority(self->io, SD_EVENT_PRIORITY_IMPORTANT);
    }
    return result < 0 ? -result : start_thread(self);
}

struct lx_nvm_writer *lx_nvm_writer_new(sd_event *event, void (*settled)(void *ctx), void *ctx)
{
    struct lx_nvm_writer *self = calloc(1, sizeof *self);
    pthread_condattr_t clock;
    if (self == NULL) {
        return NULL;
    }
    self->event = event;
    self->settled = settled;
    self->ctx = ctx;
    self->wake = -1;
    (void)pthread_condattr_init(&clock);
    (void)pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    (void)pthread_mutex_init(&self->lock, NULL);
    (void)pthread_cond_init(&self->work, NULL);
    (void)pthread_cond_init(&self->progress, &clock);
    (void)pthread_condattr_destroy(&clock);
    return self;
}

void lx_nvm_writer_free(struct lx_nvm_writer *self)
{
    if (self == NULL) {
        return;
    }
    if (self->runs) {
        (void)pthread_mutex_lock(&self->lock);
        self->ends = true;
        (void)pthread_cond_signal(&self->work);
        (void)pthread_mutex_unlock(&self->lock);
        (void)pthread_join(self->thread, NULL);
    }
    self->io = sd_event_source_disable_unref(self->io);
    if (self->wake >= 0) {
        (void)close(self->wake);
    }
    (void)pthread_cond_destroy(&self->progress);
    (void)pthread_cond_destroy(&self->work);
    (void)pthread_mutex_destroy(&self->lock);
    free(self);
}

void lx_nvm_writer_try(struct lx_nvm_writer *self, bool on_trial)
{
    self->on_trial = on_trial;
}

bool lx_nvm_writer_on_trial(const struct lx_nvm_writer *self)
{
    return self != NULL && self->on_trial;
}

uint64_t lx_nvm_writer_ticket(const struct lx_nvm_writer *self)
{
    return self == NULL ? 0 : self->issued;
}

/* Of a queue that has gone on behind `ticket` its later syncs are waited for, too. */
enum lx_nvm_state lx_nvm_writer_state(struct lx_nvm_writer *self, uint64_t after, uint64_t ticket)
{
    enum lx_nvm_state worst = LX_NVM_THROUGH;
    for (struct lx_nvm_queue *queue = self == NULL ? NULL : self->open; queue != NULL;
         queue = queue->later) {
        if (queue->issued > after) {
            const uint64_t own = queue->issued < ticket ? queue->issued : ticket;
            const enum lx_nvm_state state = lx_nvm_queue_state(queue, own);
            worst = state > worst ? state : worst;
        }
    }
    return worst;
}

static void link_queue(struct lx_nvm_queue *self, struct lx_nvm_writer *writer)
{
    self->later = writer->open;
    self->open = &writer->open;
    if (self->later != NULL) {
        self->later->open = &self->later;
    }
    writer->open = self;
}

static void unlink_queue(const struct lx_nvm_queue *self)
{
    *self->open = self->later;
    if (self->later != NULL) {
        self->later->open = self->open;
    }
}

int lx_nvm_queue_open(struct lx_nvm_queue *self, const struct lx_nvm_queue_setup *setup,
                      struct dg_nvm *nvm, struct lx_error *error)
{
    *self = (struct lx_nvm_queue){.setup = *setup};
    *nvm = setup->below;
    if (setup->writer == NULL) {
        return 0;
    }
    const int reason = start_writer(setup->writer);
    if (reason != 0) {
        self->setup.writer = NULL;
        return lx_fail(error, "no thread for EEPROM files: %s", strerror(reason));
    }
    self->bytes = malloc(setup->size);
    if (self->bytes == NULL ||
        setup->below.ops->read(setup->below.ctx, 0, self->bytes, setup->size) != DG_OK) {
        free(self->bytes);
        *self = (struct lx_nvm_queue){.bytes = NULL};
        return lx_fail(error, "no memory for an EEPROM");
    }
    link_queue(self, setup->writer);
    *nvm = (struct dg_nvm){&queue_ops, self};
    return 0;
}

/* With the lock: nobody hears of it any more. */
static void forget_news(const struct lx_nvm_queue *self)
{
    struct lx_nvm_queue **at = &self->setup.writer->news;
    while (self->news && *at != self) {
        at = &(*at)->tells;
    }
    if (self->news) {
        *at = self->tells;
    }
}

/* With the lock. A disk that is stuck is waited for as long as it takes, but not in silence. */
static void wait_for_end(const struct lx_nvm_queue *self)
{
    struct lx_nvm_writer *writer = self->setup.writer;
    const struct timespec patience = to_timespec(dg_after(lx_real_now(), PATIENCE));
    bool late = false;
    while (self->lined_up && !late) {
        late = pthread_cond_timedwait(&writer->progress, &writer->lock, &patience) == ETIMEDOUT;
    }
    if (self->lined_up) {
        lx_complain("%s: the disk is slow; waiting until the written data is durable",
                    self->setup.path);
    }
    while (self->lined_up) {
        (void)pthread_cond_wait(&writer->progress, &writer->lock);
    }
}

static void drain_jobs(struct lx_nvm_queue *self)
{
    struct lx_nvm_writer *writer = self->setup.writer;
    (void)pthread_mutex_lock(&writer->lock);
    if (self->jobs.first != NULL) {
        line_up(self);
    }
    wait_for_end(self);
    forget_news(self);
    (void)pthread_mutex_unlock(&writer->lock);
}

void lx_nvm_queue_close(struct lx_nvm_queue *self)
{
    if (self->bytes == NULL) {
        return;
    }
    drain_jobs(self);
    unlink_queue(self);
    free_all(&self->jobs);
    free_all(&self->spent);
    free(self->bytes);
    *self = (struct lx_nvm_queue){.bytes = NULL};
}

enum lx_nvm_state lx_nvm_queue_state(struct lx_nvm_queue *self, uint64_t ticket)
{
    enum lx_nvm_state state = LX_NVM_THROUGH;
    if (self->bytes == NULL) {
        return state;
    }
    (void)pthread_mutex_lock(&self->setup.writer->lock);
    if (self->done < ticket) {
        state = self->stalled ? LX_NVM_LOST : LX_NVM_PENDING;
    }
    (void)pthread_mutex_unlock(&self->setup.writer->lock);
    return state;
}

enum dg_bus_answer lx_nvm_answer_of(enum lx_nvm_state state)
{
    static const enum dg_bus_answer answers[] = {
        [LX_NVM_THROUGH] = DG_BUS_SAY,
        [LX_NVM_PENDING] = DG_BUS_KEEP,
        [LX_NVM_LOST] = DG_BUS_DROP,
    };
    return answers[state];
}

/* A loss that nothing was kept back for yet, as the answer to it comes later, ends with that. */
enum dg_bus_answer lx_nvm_queue_answer(struct lx_nvm_queue *self)
{
    if (self->known == self->issued) {
        return DG_BUS_SAY;
    }
    const enum lx_nvm_state state = lx_nvm_queue_state(self, self->issued);
    if (state != LX_NVM_PENDING) {
        self->known = self->issued;
    }
    return lx_nvm_answer_of(state);
}
