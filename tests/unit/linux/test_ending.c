/* SPDX-License-Identifier: MIT */
/* A program that is busy asks whether a signal that ends it is pending. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <signal.h>

#include "drehgeber/api.h"
#include "ending.h"

/* Whether this signal ends a program while it is pending. */
static bool ends_it(int number)
{
    const struct timespec now = {0};
    sigset_t set;
    (void)sigemptyset(&set);
    (void)sigaddset(&set, number);
    assert_int_equal(sigprocmask(SIG_BLOCK, &set, NULL), 0);
    assert_int_equal(raise(number), 0);
    const bool ends = lx_ending_asked();
    (void)sigtimedwait(&set, NULL, &now);
    assert_false(lx_ending_asked());
    assert_int_equal(sigprocmask(SIG_UNBLOCK, &set, NULL), 0);
    return ends;
}

static void others_end_nothing(void **state)
{
    static const int numbers[] = {SIGUSR1, SIGUSR2, SIGALRM, SIGPIPE, SIGCHLD, SIGWINCH};
    (void)state;
    assert_false(lx_ending_asked());
    for (size_t i = 0; i < DG_COUNT(numbers); i++) {
        assert_false(ends_it(numbers[i]));
    }
}

static void each_of_four_ends_it(void **state)
{
    static const int numbers[] = {SIGTERM, SIGINT, SIGHUP, SIGQUIT};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(numbers); i++) {
        assert_true(ends_it(numbers[i]));
    }
}

/* nohup ignores SIGHUP for its program. */
static void what_is_ignored_ends_nothing(void **state)
{
    sigset_t set;
    (void)state;
    (void)signal(SIGHUP, SIG_IGN);
    lx_ending_signals(&set);
    (void)signal(SIGHUP, SIG_DFL);
    assert_int_equal(sigismember(&set, SIGHUP), 0);
    assert_int_equal(sigismember(&set, SIGQUIT), 1);
    assert_int_equal(sigismember(&set, SIGTERM), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(others_end_nothing),
        cmocka_unit_test(each_of_four_ends_it),
        cmocka_unit_test(what_is_ignored_ends_nothing),
    };
    return cmocka_run_group_tests_name("signals that end a program", tests, NULL, NULL);
}
