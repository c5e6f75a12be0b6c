/* SPDX-License-Identifier: MIT */
/* Queues in front of memories that are slow, stuck, or say no: early, or too late. */
#define _GNU_SOURCE
#include <pthread.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/store.h"
#include "nvm_writer.h"
#include "stderr_heard.h"
#include "timer.h"

#define SIZE 4096u
#define LOG_MAX 512u
#define FILES 2u

/* A memory as the thread finds it. What was done is logged: 'a' and so on a write of that byte, '|'
   a sync, '!' one that failed; in capitals those of the second memory. */
static struct disk {
    pthread_mutex_t lock;
    pthread_cond_t changed;
    char log[LOG_MAX];
    size_t logged;
    bool stuck;                 /* syncs do not return, */
    char held;                  /* nor does a write of this byte; 0: all do */
    unsigned inside;            /* those that are in one */
    unsigned fails;             /* so many syncs fail */
    int fails_at;               /* the one of the syncs from now on that fails, 0: none */
    struct lx_nvm_queue *asked; /* while a memory is read, somebody asks this one; NULL: nobody */
    bool answered;              /* ... and was answered before the read was over */
} disk = {.lock = PTHREAD_ERRORCHECK_MUTEX_INITIALIZER_NP, .changed = PTHREAD_COND_INITIALIZER};

struct memory {
    uint8_t bytes[SIZE];
    int offset; /* between the letters of the log and its own */
};

static void *ask_state(void *queue)
{
    (void)lx_nvm_queue_state(queue, 1);
    return NULL;
}

/* Whoever asks needs the lock of the writer. One that has to wait for it is left alone here: it
   gets it when the read is over. */
static void ask_while_reading(struct lx_nvm_queue *queue)
{
    pthread_t asking;
    struct timespec until;
    assert_int_equal(pthread_create(&asking, NULL, ask_state, queue), 0);
    assert_int_equal(clock_gettime(CLOCK_REALTIME, &until), 0);
    until.tv_sec += 5;
    disk.answered = pthread_timedjoin_np(asking, NULL, &until) == 0;
    if (!disk.answered) {
        (void)pthread_detach(asking);
    }
}

static int read_memory(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct memory *self = ctx;
    if (disk.asked != NULL) {
        ask_while_reading(disk.asked);
    }
    memcpy(to, self->bytes + address, n);
    return DG_OK;
}

static void note(char letter)
{
    if (disk.logged + 1u < LOG_MAX) {
        disk.log[disk.logged++] = letter;
        disk.log[disk.logged] = '\0';
    }
}

static int write_memory(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct memory *self = ctx;
    (void)pthread_mutex_lock(&disk.lock);
    disk.inside++;
    (void)pthread_cond_broadcast(&disk.changed);
    while (disk.held != 0 && disk.held == *(const char *)from) {
        (void)pthread_cond_wait(&disk.changed, &disk.lock);
    }
    disk.inside--;
    memcpy(self->bytes + address, from, n);
    note((char)(*(const char *)from + self->offset));
    (void)pthread_mutex_unlock(&disk.lock);
    return DG_OK;
}

static int sync_memory(void *ctx)
{
    (void)ctx;
    (void)pthread_mutex_lock(&disk.lock);
    disk.inside++;
    (void)pthread_cond_broadcast(&disk.changed);
    while (disk.stuck) {
        (void)pthread_cond_wait(&disk.changed, &disk.lock);
    }
    disk.inside--;
    const bool fails = disk.fails > 0 || disk.fails_at == 1;
    disk.fails -= disk.fails > 0 ? 1u : 0u;
    disk.fails_at -= disk.fails_at > 0 ? 1 : 0;
    note(fails ? '!' : '|');
    (void)pthread_mutex_unlock(&disk.lock);
    return fails ? DG_ERR_IO : DG_OK;
}

static const struct dg_nvm_ops memory_ops = {read_memory, write_memory, sync_memory};

static void set_stuck(bool stuck)
{
    (void)pthread_mutex_lock(&disk.lock);
    disk.stuck = stuck;
    (void)pthread_cond_broadcast(&disk.changed);
    (void)pthread_mutex_unlock(&disk.lock);
}

static void hold_write(char byte)
{
    (void)pthread_mutex_lock(&disk.lock);
    disk.held = byte;
    (void)pthread_cond_broadcast(&disk.changed);
    (void)pthread_mutex_unlock(&disk.lock);
}

/* Until the thread is in a sync or a write that does not return. */
static void await_stuck(void)
{
    (void)pthread_mutex_lock(&disk.lock);
    while (disk.inside == 0) {
        (void)pthread_cond_wait(&disk.changed, &disk.lock);
    }
    (void)pthread_mutex_unlock(&disk.lock);
}

static bool still_fails(void)
{
    (void)pthread_mutex_lock(&disk.lock);
    const bool fails = disk.fails > 0;
    (void)pthread_mutex_unlock(&disk.lock);
    return fails;
}

/* An assertion leaves the test, so none is made with the lock. A quick thread has written the first
   byte before the sync behind it is asked for: then only the sync is tried again. */
static void logged_one_of(const char *expected, const char *quick)
{
    char log[LOG_MAX] = "";
    (void)pthread_mutex_lock(&disk.lock);
    memcpy(log, disk.log, disk.logged);
    disk.log[0] = '\0';
    disk.logged = 0;
    (void)pthread_mutex_unlock(&disk.lock);
    assert_string_equal(log, strcmp(log, quick) == 0 ? quick : expected);
}

static void logged(const char *expected)
{
    logged_one_of(expected, expected);
}

/* A loop with files on that disk. */
struct bench {
    sd_event *event;
    struct lx_nvm_writer *writer;
    struct memory memory[FILES];
    struct lx_nvm_queue queue[FILES];
    struct dg_nvm nvm[FILES];
    unsigned settled[FILES];
};

static void on_settled(void *ctx, dg_ns now)
{
    unsigned *count = ctx;
    assert_true(now <= lx_now());
    ++*count;
}

static int set_up(void **state)
{
    struct bench *self = calloc(1, sizeof *self);
    struct lx_error error;
    assert_non_null(self);
    assert_true(sd_event_new(&self->event) >= 0);
    self->writer = lx_nvm_writer_new(self->event, NULL, NULL);
    assert_non_null(self->writer);
    for (size_t i = 0; i < FILES; i++) {
        memset(self->memory[i].bytes, '-', SIZE);
        self->memory[i].offset = i == 0 ? 0 : 'A' - 'a';
        const struct lx_nvm_queue_setup setup = {
            .writer = self->writer,
            .below = {&memory_ops, &self->memory[i]},
            .size = SIZE,
            .settled = on_settled,
            .ctx = &self->settled[i],
        };
        assert_int_equal(lx_nvm_queue_open(&self->queue[i], &setup, &self->nvm[i], &error), 0);
    }
    disk.stuck = false;
    disk.held = 0;
    disk.fails = 0;
    disk.fails_at = 0;
    disk.logged = 0;
    disk.log[0] = '\0';
    *state = self;
    return 0;
}

static void close_all(struct bench *self)
{
    for (size_t i = 0; i < FILES; i++) {
        lx_nvm_queue_close(&self->queue[i]);
    }
}

static int tear_down(void **state)
{
    struct bench *self = *state;
    set_stuck(false);
    hold_write(0);
    close_all(self);
    lx_nvm_writer_free(self->writer);
    self->event = sd_event_unref(self->event);
    free(self);
    return 0;
}

static int put_text(struct bench *self, size_t file, uint32_t address, const char *text)
{
    const struct dg_nvm *nvm = &self->nvm[file];
    int result = DG_OK;
    for (size_t i = 0; result == DG_OK && text[i] != '\0'; i++) {
        result = text[i] == '|' ? nvm->ops->sync(nvm->ctx)
                                : nvm->ops->write(nvm->ctx, address + (uint32_t)i, &text[i], 1);
    }
    return result;
}

static char byte_at(struct bench *self, size_t file, uint32_t address)
{
    char byte = 0;
    const struct dg_nvm *nvm = &self->nvm[file];
    assert_int_equal(nvm->ops->read(nvm->ctx, address, &byte, 1), DG_OK);
    return byte;
}

static enum lx_nvm_state state_of(struct bench *self, size_t file)
{
    return lx_nvm_queue_state(&self->queue[file], self->queue[file].issued);
}

/* Rounds of the loop until it is no longer pending. */
static enum lx_nvm_state settle_file(struct bench *self, size_t file)
{
    while (state_of(self, file) == LX_NVM_PENDING) {
        assert_true(sd_event_run(self->event, DG_S(10) / 1000u) >= 0);
    }
    while (sd_event_run(self->event, 0) > 0) {
    }
    return state_of(self, file);
}

/* A sync that is under way when it says yes, however fast the machine is. */
static void put_late(struct bench *self, size_t file, uint32_t address, const char *text)
{
    set_stuck(true);
    assert_int_equal(put_text(self, file, address, text), DG_OK);
    assert_int_equal(state_of(self, file), LX_NVM_PENDING);
    await_stuck();
}

static void what_is_written_is_read_at_once_and_written_in_order(void **state)
{
    struct bench *self = *state;
    assert_int_equal(put_text(self, 0, 0, "ab|cd|"), DG_OK);
    assert_int_equal(byte_at(self, 0, 4), 'd');
    assert_int_equal(settle_file(self, 0), LX_NVM_THROUGH);
    logged("ab|cd|");
    assert_memory_equal(self->memory[0].bytes, "ab-cd-", 6);
}

static void what_is_outside_is_refused(void **state)
{
    struct bench *self = *state;
    const struct dg_nvm *nvm = &self->nvm[0];
    uint8_t bytes[2] = {0};
    assert_int_equal(nvm->ops->write(nvm->ctx, SIZE - 1u, bytes, 2), DG_ERR_IO);
    assert_int_equal(nvm->ops->write(nvm->ctx, UINT32_MAX, bytes, 2), DG_ERR_IO);
    assert_int_equal(nvm->ops->read(nvm->ctx, SIZE - 1u, bytes, 2), DG_ERR_IO);
    assert_int_equal(nvm->ops->read(nvm->ctx, SIZE - 2u, bytes, 2), DG_OK);
}

static int do_not_read(void *ctx, uint32_t address, void *to, size_t n)
{
    (void)ctx;
    (void)address;
    (void)to;
    (void)n;
    return DG_ERR_IO;
}

/* Who opened it is told, and the queue is none: closing it is nothing. */
static void a_memory_that_cannot_be_read_has_no_queue(void **state)
{
    static const struct dg_nvm_ops unreadable = {do_not_read, write_memory, sync_memory};
    struct bench *self = *state;
    struct lx_error error = {.what = ""};
    struct lx_nvm_queue queue;
    struct dg_nvm nvm;
    const struct lx_nvm_queue_setup setup = {
        .writer = self->writer, .below = {&unreadable, &self->memory[0]}, .size = SIZE};
    assert_int_not_equal(lx_nvm_queue_open(&queue, &setup, &nvm, &error), 0);
    assert_string_not_equal(error.what, "");
    assert_int_equal(lx_nvm_queue_state(&queue, 7), LX_NVM_THROUGH);
    lx_nvm_queue_close(&queue);
}

static void without_a_writer_the_device_works_on_the_memory(void **state)
{
    struct bench *self = *state;
    struct lx_error error;
    struct lx_nvm_queue queue;
    struct dg_nvm nvm;
    const struct lx_nvm_queue_setup setup = {.below = {&memory_ops, &self->memory[0]}};
    assert_int_equal(lx_nvm_queue_open(&queue, &setup, &nvm, &error), 0);
    assert_ptr_equal(nvm.ops, &memory_ops);
    assert_ptr_equal(nvm.ctx, &self->memory[0]);
    assert_int_equal(lx_nvm_queue_state(&queue, 7), LX_NVM_THROUGH);
    lx_nvm_queue_close(&queue);
}

/* The device goes on after a moment; who waits is told in the loop. */
static void a_stuck_disk_keeps_the_device_for_a_moment_only(void **state)
{
    struct bench *self = *state;
    const dg_ns begin = lx_now();
    put_late(self, 0, 0, "a|");
    assert_true(lx_now() - begin >= LX_NVM_MOMENT);
    assert_int_equal(self->queue[0].waits, 1);
    const uint64_t first = self->queue[0].issued;
    assert_int_equal(put_text(self, 0, 2, "b|"), DG_OK); /* and waits no second time */
    assert_int_equal(self->queue[0].waits, 1);
    assert_int_equal(byte_at(self, 0, 2), 'b');
    (void)sd_event_run(self->event, 0);
    assert_int_equal(self->settled[0], 0);
    logged("a");
    set_stuck(false);
    assert_int_equal(settle_file(self, 0), LX_NVM_THROUGH);
    assert_int_equal(lx_nvm_queue_state(&self->queue[0], first), LX_NVM_THROUGH);
    assert_true(self->settled[0] >= 1);
    assert_int_equal(self->settled[1], 0);
    logged("|b|");
}

static dg_ns time_of_sync(struct bench *self, size_t file)
{
    const dg_ns begin = lx_now();
    assert_int_equal(put_text(self, file, 0, "|"), DG_OK);
    return lx_now() - begin;
}

/* A moment is the disk's time. Of what it has been busy with for long there is none left; behind
   another file's it is one from the sync on. The quickest of a few: a busy machine adds to it. */
static void a_moment_is_time_of_the_disk(void **state)
{
    struct bench *self = *state;
    dg_ns behind_own = DG_S(10);
    dg_ns behind_other = DG_S(10);
    for (unsigned i = 0; i < 10; i++) {
        hold_write('a');
        assert_int_equal(put_text(self, 0, 0, "a"), DG_OK);
        await_stuck();
        (void)usleep((useconds_t)(2u * LX_NVM_MOMENT / 1000u));
        behind_own = dg_earliest(behind_own, time_of_sync(self, 0));
        const dg_ns other = time_of_sync(self, 1);
        assert_true(other >= LX_NVM_MOMENT);
        behind_other = dg_earliest(behind_other, other);
        hold_write(0);
        assert_int_equal(settle_file(self, 0), LX_NVM_THROUGH);
        assert_int_equal(settle_file(self, 1), LX_NVM_THROUGH);
    }
    assert_true(behind_own < LX_NVM_MOMENT);
    assert_true(behind_other < LX_NVM_MOMENT_MAX / 2u);
}

static void a_sync_is_through_before_the_ones_behind_it(void **state)
{
    struct bench *self = *state;
    put_late(self, 0, 0, "a|");
    const uint64_t first = self->queue[0].issued;
    assert_int_equal(put_text(self, 0, 2, "b|"), DG_OK);
    disk.fails_at = 2;
    set_stuck(false);
    assert_int_equal(settle_file(self, 0), LX_NVM_LOST);
    assert_int_equal(lx_nvm_queue_state(&self->queue[0], first), LX_NVM_THROUGH);
    logged("a|b!");
}

static void files_take_turns(void **state)
{
    struct bench *self = *state;
    put_late(self, 0, 0, "a|");
    assert_int_equal(put_text(self, 0, 2, "b|c|"), DG_OK);
    assert_int_equal(put_text(self, 1, 0, "x|"), DG_OK);
    assert_int_equal(put_text(self, 1, 2, "y|"), DG_OK);
    logged("a");
    set_stuck(false);
    assert_int_equal(settle_file(self, 0), LX_NVM_THROUGH);
    assert_int_equal(settle_file(self, 1), LX_NVM_THROUGH);
    logged("|X|b|Y|c|");
}

/* As if the device had worked on the file itself. */
static void an_early_no_is_told_to_the_device(void **state)
{
    struct bench *self = *state;
    assert_int_equal(put_text(self, 0, 0, "a|"), DG_OK);
    assert_int_equal(settle_file(self, 0), LX_NVM_THROUGH);
    disk.fails = 1;
    const int result = put_text(self, 0, 0, "b|");
    if (result == DG_OK) { /* a busy machine: it was late, after all */
        assert_int_equal(settle_file(self, 0), LX_NVM_LOST);
        return;
    }
    assert_int_equal(result, DG_ERR_IO);
    assert_int_equal(state_of(self, 0), LX_NVM_THROUGH);
    assert_int_equal(byte_at(self, 0, 0), self->memory[0].bytes[0]);
    assert_int_equal(put_text(self, 0, 0, "c|"), DG_OK);
    assert_int_equal(settle_file(self, 0), LX_NVM_THROUGH);
    logged("a|b!c|");
}

/* What the file has become is read while others have the lock. */
static void an_early_no_reads_without_the_lock(void **state)
{
    struct bench *self = *state;
    disk.fails = 1;
    disk.answered = false;
    disk.asked = &self->queue[1];
    const int result = put_text(self, 0, 0, "b|");
    disk.asked = NULL;
    if (result == DG_OK) { /* a busy machine, as above */
        assert_int_equal(settle_file(self, 0), LX_NVM_LOST);
        return;
    }
    assert_int_equal(result, DG_ERR_IO);
    assert_true(disk.answered);
    assert_int_equal(byte_at(self, 0, 0), 'b');
}

/* Refused, tried again with each write, in the old order, and only then the device may write. */
static void a_late_no_refuses_what_comes_until_all_is_through(void **state)
{
    struct bench *self = *state;
    put_late(self, 0, 0, "a|");
    assert_int_equal(put_text(self, 0, 2, "b|c"), DG_OK);
    disk.fails = 2;
    set_stuck(false);
    assert_int_equal(settle_file(self, 0), LX_NVM_LOST);
    logged("a!");
    assert_int_equal(put_text(self, 0, 0, "d"), DG_ERR_IO);
    assert_int_equal(byte_at(self, 0, 0), 'a');
    assert_int_equal(byte_at(self, 0, 2), 'b');
    while (still_fails()) {
        assert_int_equal(put_text(self, 0, 0, "|"), DG_ERR_IO);
    }
    while (put_text(self, 0, 0, "d") != DG_OK) {
        assert_int_equal(byte_at(self, 0, 0), 'a');
    }
    assert_int_equal(put_text(self, 0, 0, "e|"), DG_OK);
    assert_int_equal(settle_file(self, 0), LX_NVM_THROUGH);
    logged_one_of("a!a|b|cde|", "!|b|cde|");
}

/* All that was to be synced is there; what is written behind it is still on its way. */
static void what_is_tried_again_is_not_taken_away(void **state)
{
    struct bench *self = *state;
    put_late(self, 0, 0, "a|");
    assert_int_equal(put_text(self, 0, 2, "b"), DG_OK);
    disk.fails = 1;
    set_stuck(false);
    assert_int_equal(settle_file(self, 0), LX_NVM_LOST);
    hold_write('b');
    assert_int_equal(put_text(self, 0, 0, "c"), DG_ERR_IO);
    while (state_of(self, 0) != LX_NVM_THROUGH) {
        (void)sched_yield();
    }
    await_stuck();
    assert_int_equal(put_text(self, 0, 0, "d|"), DG_ERR_IO);
    assert_int_equal(put_text(self, 0, 0, "|"), DG_ERR_IO);
    assert_int_equal(byte_at(self, 0, 2), 'b');
    hold_write(0);
    while (put_text(self, 0, 0, "e") != DG_OK) {
        assert_int_equal(byte_at(self, 0, 2), 'b');
    }
    close_all(self);
    logged_one_of("a!a|be", "a!|be");
    assert_memory_equal(self->memory[0].bytes, "e-b", 3);
}

static void a_file_that_fails_keeps_no_other_one(void **state)
{
    struct bench *self = *state;
    put_late(self, 0, 0, "a|");
    disk.fails = 1;
    set_stuck(false);
    assert_int_equal(settle_file(self, 0), LX_NVM_LOST);
    assert_int_equal(put_text(self, 1, 0, "x|"), DG_OK);
    assert_int_equal(settle_file(self, 1), LX_NVM_THROUGH);
    assert_int_equal(state_of(self, 0), LX_NVM_LOST);
    logged("a!X|");
}

/* Kept while it is under way; behind a loss one answer is dropped, however late it comes. */
static void an_answer_is_kept_and_one_behind_a_loss_is_dropped(void **state)
{
    struct bench *self = *state;
    struct lx_nvm_queue *queue = &self->queue[0];
    assert_int_equal(lx_nvm_queue_answer(queue), DG_BUS_SAY);
    put_late(self, 0, 0, "a|");
    assert_int_equal(lx_nvm_queue_answer(queue), DG_BUS_KEEP);
    assert_int_equal(lx_nvm_queue_answer(queue), DG_BUS_KEEP);
    disk.fails = 1;
    set_stuck(false);
    assert_int_equal(settle_file(self, 0), LX_NVM_LOST);
    assert_int_equal(lx_nvm_queue_answer(queue), DG_BUS_DROP);
    assert_int_equal(put_text(self, 0, 0, "b"), DG_ERR_IO);
    assert_int_equal(lx_nvm_queue_answer(queue), DG_BUS_SAY); /* that it is refused */
    while (put_text(self, 0, 0, "b") != DG_OK) {
    }
    put_late(self, 0, 1, "|");
    assert_int_equal(lx_nvm_queue_answer(queue), DG_BUS_KEEP);
    set_stuck(false);
    assert_int_equal(settle_file(self, 0), LX_NVM_THROUGH);
    assert_int_equal(lx_nvm_queue_answer(queue), DG_BUS_SAY);
}

/* Whoever knows only that something was written behind `after`. */
static void the_writer_knows_of_all_files(void **state)
{
    struct bench *self = *state;
    const uint64_t begin = lx_nvm_writer_ticket(self->writer);
    assert_int_equal(lx_nvm_writer_state(self->writer, begin, begin), LX_NVM_THROUGH);
    put_late(self, 0, 0, "a|");
    const uint64_t first = lx_nvm_writer_ticket(self->writer);
    assert_true(first > begin);
    assert_int_equal(lx_nvm_writer_state(self->writer, begin, first), LX_NVM_PENDING);
    assert_int_equal(lx_nvm_writer_state(self->writer, first, first), LX_NVM_THROUGH);
    disk.fails = 1;
    set_stuck(false);
    assert_int_equal(settle_file(self, 0), LX_NVM_LOST);
    assert_int_equal(put_text(self, 1, 0, "x|"), DG_OK);
    assert_int_equal(settle_file(self, 1), LX_NVM_THROUGH);
    const uint64_t second = lx_nvm_writer_ticket(self->writer);
    assert_int_equal(lx_nvm_writer_state(self->writer, begin, second), LX_NVM_LOST);
    assert_int_equal(lx_nvm_writer_state(self->writer, first, second), LX_NVM_THROUGH);
    assert_int_equal(lx_nvm_writer_ticket(NULL), 0);
    assert_int_equal(lx_nvm_writer_state(NULL, 0, 7), LX_NVM_THROUGH);
}

static void *let_go(void *ctx)
{
    (void)ctx;
    (void)usleep(50000);
    set_stuck(false);
    return NULL;
}

/* In silence: only who waits for a second says so. */
static void closing_waits_for_the_disk(void **state)
{
    struct bench *self = *state;
    struct stderr_heard heard;
    char said[256];
    pthread_t helper;
    put_late(self, 0, 0, "a|b|c");
    assert_int_equal(put_text(self, 1, 0, "x|"), DG_OK);
    stderr_hear(&heard);
    assert_int_equal(pthread_create(&helper, NULL, let_go, NULL), 0);
    close_all(self);
    assert_int_equal(pthread_join(helper, NULL), 0);
    stderr_heard(&heard, said, sizeof said);
    assert_string_equal(said, "");
    logged("a|X|b|c");
    assert_memory_equal(self->memory[0].bytes, "a-b-c", 5);
}

static void closing_tries_once_more(void **state)
{
    struct bench *self = *state;
    put_late(self, 0, 0, "a|b|");
    disk.fails = 1;
    set_stuck(false);
    assert_int_equal(settle_file(self, 0), LX_NVM_LOST);
    close_all(self);
    logged_one_of("a!a|b|", "a!|b|");
    assert_memory_equal(self->memory[0].bytes, "a-b", 3);
}

/* --- through the store --- */

static void user_is_one_of(struct dg_nvm nvm, const char *const *values)
{
    struct dg_store store;
    char bytes[5] = "";
    assert_int_equal(dg_store_mount(&store, &dg_hf_layout, nvm), DG_OK);
    assert_int_equal(dg_store_read(&store, DG_HF_REGION_USER, 0, bytes, 4), DG_OK);
    while (*values != NULL && strcmp(*values, bytes) != 0) {
        values++;
    }
    assert_non_null(*values);
}

/* What a start would find on the disk as it is now. */
static void disk_has_one_of(const struct bench *self, const char *const *values)
{
    static struct memory copy;
    (void)pthread_mutex_lock(&disk.lock);
    copy = self->memory[0];
    (void)pthread_mutex_unlock(&disk.lock);
    user_is_one_of((struct dg_nvm){&memory_ops, &copy}, values);
}

static int put_user(struct dg_store *store, const char *value)
{
    return dg_store_put(store, DG_HF_REGION_USER, 0, value, 4);
}

/* Whichever sync of two commits fails after both were believed: a start finds the old value or a
   new one, and the device is not given another before all is there. */
static void a_commit_that_is_lost_mixes_nothing(void **state)
{
    struct bench *self = *state;
    static const char *const any[] = {"old.", "one.", "two.", NULL};
    for (int failing = 1; failing <= 4; failing++) {
        struct dg_store store;
        assert_int_equal(dg_hf_format(dg_hf_model_of(dg_device_find("s3684-rs485")), self->nvm[0]),
                         DG_OK);
        assert_int_equal(dg_store_mount(&store, &dg_hf_layout, self->nvm[0]), DG_OK);
        assert_int_equal(put_user(&store, "old."), DG_OK);
        assert_int_equal(settle_file(self, 0), LX_NVM_THROUGH);
        set_stuck(true);
        assert_int_equal(put_user(&store, "one."), DG_OK);
        assert_int_equal(put_user(&store, "two."), DG_OK);
        disk.fails_at = failing;
        set_stuck(false);
        assert_int_equal(settle_file(self, 0), LX_NVM_LOST);
        disk_has_one_of(self, any);
        assert_int_equal(put_user(&store, "bad."), DG_ERR_IO);
        while (put_user(&store, "new.") != DG_OK) {
        }
        assert_int_equal(settle_file(self, 0), LX_NVM_THROUGH);
        disk_has_one_of(self, (const char *const[]){"new.", NULL});
    }
}

#define ON_A_BENCH(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON_A_BENCH(what_is_written_is_read_at_once_and_written_in_order),
        ON_A_BENCH(what_is_outside_is_refused),
        ON_A_BENCH(a_memory_that_cannot_be_read_has_no_queue),
        ON_A_BENCH(without_a_writer_the_device_works_on_the_memory),
        ON_A_BENCH(a_stuck_disk_keeps_the_device_for_a_moment_only),
        ON_A_BENCH(a_moment_is_time_of_the_disk),
        ON_A_BENCH(a_sync_is_through_before_the_ones_behind_it),
        ON_A_BENCH(files_take_turns),
        ON_A_BENCH(an_early_no_is_told_to_the_device),
        ON_A_BENCH(an_early_no_reads_without_the_lock),
        ON_A_BENCH(a_late_no_refuses_what_comes_until_all_is_through),
        ON_A_BENCH(what_is_tried_again_is_not_taken_away),
        ON_A_BENCH(a_file_that_fails_keeps_no_other_one),
        ON_A_BENCH(an_answer_is_kept_and_one_behind_a_loss_is_dropped),
        ON_A_BENCH(the_writer_knows_of_all_files),
        ON_A_BENCH(closing_waits_for_the_disk),
        ON_A_BENCH(closing_tries_once_more),
        ON_A_BENCH(a_commit_that_is_lost_mixes_nothing),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
