/* SPDX-License-Identifier: MIT */
/*
 * Timers in virtual time: deadlines come in their order, at their own moments, and none of it
 * waits.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/time.h"
#include "timer.h"

#define SEEN_MAX 8u

/* What was called, and when since the beginning. */
static struct {
    dg_ns begin;
    size_t count;
    char name[SEEN_MAX + 1u];
    dg_ns at[SEEN_MAX];
} seen;

struct waiter {
    struct lx_timer timer;
    char name;
    dg_ns every; /* 0: once */
};

static void due(void *ctx, dg_ns now)
{
    struct waiter *self = ctx;

    assert_int_equal(now, lx_now());
    assert_true(seen.count < SEEN_MAX);
    seen.name[seen.count] = self->name;
    seen.at[seen.count++] = now - seen.begin;
    seen.name[seen.count] = '\0';
    if (self->every != 0) {
        lx_timer_at(&self->timer, now + self->every);
    }
}

static void open_at(struct waiter *self, char name, dg_ns at, dg_ns every)
{
    *self = (struct waiter){.name = name, .every = every};
    assert_int_equal(lx_timer_open(&self->timer, NULL, due, self), 0);
    lx_timer_at(&self->timer, at == DG_NEVER ? at : seen.begin + at);
}

static int begin(void **state)
{
    (void)state;
    lx_time_own();
    seen.begin = lx_now();
    seen.count = 0;
    return 0;
}

static void time_stands_still_until_it_is_let_pass(void **state)
{
    const dg_ns real = lx_real_now();

    (void)state;
    while (lx_real_now() < real + DG_US(50)) {
    }
    assert_int_equal(lx_now(), seen.begin);
    assert_false(lx_time_pass(seen.begin + DG_S(3600)));
    assert_int_equal(lx_now(), seen.begin + DG_S(3600));
}

static void deadlines_come_in_their_order(void **state)
{
    struct waiter a;
    struct waiter b;
    struct waiter c;
    struct waiter never;

    (void)state;
    open_at(&a, 'a', DG_S(3), 0);
    open_at(&b, 'b', DG_S(1), DG_S(1));
    open_at(&c, 'c', DG_S(3), 0);
    open_at(&never, 'n', DG_NEVER, 0);
    while (lx_time_pass(seen.begin + DG_S(4) - 1u)) {
    }
    /* b asked anew for its third one behind the others. */
    assert_string_equal(seen.name, "bbacb");
    assert_int_equal(seen.at[1], DG_S(2));
    assert_int_equal(seen.at[4], DG_S(3));
    assert_int_equal(lx_now(), seen.begin + DG_S(4) - 1u);
    lx_timer_at(&b.timer, DG_NEVER);
    assert_false(lx_time_pass(seen.begin + DG_S(10)));
}

static void one_that_is_over_comes_now(void **state)
{
    struct waiter a;

    (void)state;
    assert_false(lx_time_pass(seen.begin + DG_S(5)));
    open_at(&a, 'a', DG_S(1), 0);
    assert_true(lx_time_pass(lx_now()));
    assert_int_equal(seen.at[0], DG_S(5));
    assert_false(lx_time_pass(lx_now()));
}

static void who_is_closed_or_moved_is_not_called(void **state)
{
    struct waiter a;
    struct waiter b;

    (void)state;
    open_at(&a, 'a', DG_S(1), 0);
    open_at(&b, 'b', DG_S(2), 0);
    lx_timer_close(&a.timer);
    lx_timer_close(&a.timer);
    lx_timer_at(&b.timer, seen.begin + DG_S(7));
    assert_true(lx_time_pass(seen.begin + DG_S(8)));
    assert_int_equal(seen.at[0], DG_S(7));
    assert_string_equal(seen.name, "b");
    assert_false(lx_time_pass(seen.begin + DG_S(8)));
}

/* Any number, asked for, moved and taken back in any order: each comes at its moment, the first who
 * asked first. */
struct many {
    struct lx_timer timer;
    unsigned asked; /* of all, the how manieth to ask; 0: it does not wait */
};

static struct {
    struct many *last; /* that came */
    dg_ns at;
    unsigned asked;
    unsigned came;
} order;

static void come(void *ctx, dg_ns now)
{
    struct many *self = ctx;

    assert_int_not_equal(self->asked, 0);
    assert_true(now > order.at || (now == order.at && self->asked > order.asked));
    order.at = now;
    order.asked = self->asked;
    order.came++;
    self->asked = 0;
}

static void many_come_in_their_order(void **state)
{
    enum { COUNT = 1000, ROUNDS = 4 };
    static struct many all[COUNT];
    uint32_t chance = 1;
    unsigned asked = 0;
    unsigned waiting = 0;

    (void)state;
    order.at = 0;
    order.came = 0;
    for (unsigned i = 0; i < COUNT; i++) {
        assert_int_equal(lx_timer_open(&all[i].timer, NULL, come, &all[i]), 0);
    }
    for (unsigned i = 0; i < ROUNDS * COUNT; i++) {
        struct many *one = &all[(chance = chance * 1664525u + 1013904223u) >> 12u & 511u];
        const dg_ns at = seen.begin + DG_MS(1 + (chance >> 24u));
        one = &one[i % 2u * (COUNT - 512u)];
        const bool again = chance >> 8u & 3u;
        if (one->timer.at != at) { /* who asks for what he has stays where he is */
            one->asked = again ? ++asked : 0;
        }
        lx_timer_at(&one->timer, again ? at : DG_NEVER);
        one->asked = again ? one->asked : 0;
    }
    for (unsigned i = 0; i < COUNT; i++) {
        waiting += all[i].asked != 0 ? 1u : 0u;
    }
    while (lx_time_pass(seen.begin + DG_S(1))) {
    }
    assert_true(waiting > COUNT / 2u);
    assert_int_equal(order.came, waiting);
    for (unsigned i = 0; i < COUNT; i++) {
        lx_timer_close(&all[i].timer);
    }
}

/* One that waits takes its deadline along, one that does not waits there neither. */
static void timers_move_between_strands(void **state)
{
    struct lx_strand *strand = lx_strand_new();
    struct waiter a;
    struct waiter b;

    (void)state;
    assert_non_null(strand);
    open_at(&a, 'a', DG_S(1), 0);
    open_at(&b, 'b', DG_NEVER, 0);
    assert_int_equal(lx_timer_move(&a.timer, strand), 0);
    assert_int_equal(lx_timer_move(&b.timer, strand), 0);
    assert_true(lx_strand_next(strand) == seen.begin + DG_S(1));
    assert_true(lx_strand_next(NULL) == DG_NEVER);
    assert_false(lx_time_pass(seen.begin + DG_S(2)));
    assert_int_equal(seen.count, 0);
    lx_strand_enter(strand);
    assert_int_equal(lx_now(), seen.begin);
    assert_true(lx_time_pass(seen.begin + DG_S(2)));
    assert_int_equal(seen.at[0], DG_S(1));
    assert_false(lx_time_pass(seen.begin + DG_S(2)));
    lx_timer_at(&a.timer, seen.begin + DG_S(5));
    lx_strand_enter(NULL);
    assert_int_equal(lx_timer_move(&b.timer, NULL), 0);
    assert_true(lx_strand_next(NULL) == DG_NEVER);
    assert_int_equal(lx_timer_move(&a.timer, NULL), 0);
    assert_true(lx_strand_next(strand) == DG_NEVER);
    assert_true(lx_strand_next(NULL) == seen.begin + DG_S(5));
    assert_true(lx_time_pass(seen.begin + DG_S(5)));
    assert_string_equal(seen.name, "aa");
    lx_timer_close(&a.timer);
    lx_timer_close(&b.timer);
    lx_strand_free(strand);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(time_stands_still_until_it_is_let_pass, begin),
        cmocka_unit_test_setup(deadlines_come_in_their_order, begin),
        cmocka_unit_test_setup(one_that_is_over_comes_now, begin),
        cmocka_unit_test_setup(who_is_closed_or_moved_is_not_called, begin),
        cmocka_unit_test_setup(many_come_in_their_order, begin),
        cmocka_unit_test_setup(timers_move_between_strands, begin),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
