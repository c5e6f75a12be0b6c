/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "stall.h"
#include "timer.h"

#define HELD DG_MS(30)
#define ROUND_US 100000u

/* A loop with two pipes; whoever reads the first one takes his time. */
struct bench {
    sd_event *event;
    struct lx_stall stall;
    struct lx_timer timer;
    int pipe[2][2];
    sd_event_source *source[2];
    dg_ns deadline_in; /* the slow one sets a deadline so long after its beginning; 0: none */
    unsigned times;
    dg_ns by;
};

static void nap(dg_ns span)
{
    const struct timespec time = {.tv_nsec = (long)span};
    (void)nanosleep(&time, NULL);
}

static void held_up(void *ctx, dg_ns by)
{
    struct bench *self = ctx;
    self->times++;
    self->by = by;
}

static void due(void *ctx, dg_ns now)
{
    (void)ctx;
    (void)now;
}

static int on_slow(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct bench *self = ctx;
    const dg_ns begin = lx_now();
    char byte;
    (void)source;
    (void)events;
    assert_int_equal(read(fd, &byte, 1), 1);
    nap(HELD);
    if (self->deadline_in != 0) {
        lx_timer_at(&self->timer, begin + self->deadline_in);
    }
    return 0;
}

static int on_quick(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    char byte;
    (void)source;
    (void)events;
    (void)ctx;
    assert_int_equal(read(fd, &byte, 1), 1);
    return 0;
}

static int set_up(void **state)
{
    static const sd_event_io_handler_t handlers[2] = {on_slow, on_quick};
    struct bench *self = calloc(1, sizeof *self);
    assert_non_null(self);
    assert_true(sd_event_new(&self->event) >= 0);
    assert_int_equal(lx_stall_open(&self->stall, self->event, held_up, self), 0);
    assert_true(lx_timer_open(&self->timer, self->event, due, self) >= 0);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(pipe(self->pipe[i]), 0);
        assert_true(sd_event_add_io(self->event, &self->source[i], self->pipe[i][0], EPOLLIN,
                                    handlers[i], self) >= 0);
    }
    assert_true(sd_event_source_set_priority(self->source[0], SD_EVENT_PRIORITY_NORMAL - 1) >= 0);
    *state = self;
    return 0;
}

static int tear_down(void **state)
{
    struct bench *self = *state;
    lx_stall_close(&self->stall);
    lx_timer_close(&self->timer);
    for (int i = 0; i < 2; i++) {
        self->source[i] = sd_event_source_disable_unref(self->source[i]);
        (void)close(self->pipe[i][0]);
        (void)close(self->pipe[i][1]);
    }
    (void)sd_event_unref(self->event);
    free(self);
    return 0;
}

static void write_to(const struct bench *self, int pipe)
{
    assert_int_equal(write(self->pipe[pipe][1], "x", 1), 1);
}

/* Until nothing comes any more. */
static void run(const struct bench *self)
{
    while (sd_event_run(self->event, ROUND_US) > 0) {
    }
}

static void input_that_waits_for_a_slow_call_is_seen(void **state)
{
    struct bench *self = *state;
    write_to(self, 0);
    write_to(self, 1);
    run(self);
    assert_int_equal(self->times, 1);
    assert_true(self->by >= HELD && self->by < DG_S(10));
}

static void a_deadline_that_waits_for_a_slow_call_is_seen(void **state)
{
    struct bench *self = *state;
    lx_timer_at(&self->timer, lx_now() + DG_MS(15));
    write_to(self, 0);
    run(self);
    assert_int_equal(self->times, 1);
}

/* Also when it has set a deadline that is over by its end: that is its own. */
static void a_slow_call_for_which_nobody_waits_is_none(void **state)
{
    struct bench *self = *state;
    write_to(self, 0);
    run(self);
    self->deadline_in = DG_MS(5);
    write_to(self, 0);
    run(self);
    assert_int_equal(self->times, 0);
}

static void a_long_wait_is_none(void **state)
{
    struct bench *self = *state;
    run(self);
    write_to(self, 1);
    run(self);
    assert_int_equal(self->times, 0);
}

/* Somebody else has to do it. */
static pid_t stop_me(void)
{
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child == 0) {
        nap(HELD);
        (void)kill(parent, SIGSTOP);
        nap(HELD);
        _exit(kill(parent, SIGCONT) == 0 ? 0 : 1);
    }
    return child;
}

static void the_end_of_a_stop_is_seen(void **state)
{
    struct bench *self = *state;
    int status = -1;
    write_to(self, 1);
    assert_int_equal(sd_event_run(self->event, ROUND_US), 1);
    const pid_t child = stop_me();
    while (self->times == 0) {
        assert_true(sd_event_run(self->event, UINT64_MAX) > 0);
    }
    run(self);
    assert_int_equal(self->times, 1);
    assert_true(self->by == DG_NEVER);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
}

#define ON_A_BENCH(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON_A_BENCH(input_that_waits_for_a_slow_call_is_seen),
        ON_A_BENCH(a_deadline_that_waits_for_a_slow_call_is_seen),
        ON_A_BENCH(a_slow_call_for_which_nobody_waits_is_none),
        ON_A_BENCH(a_long_wait_is_none),
        ON_A_BENCH(the_end_of_a_stop_is_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
