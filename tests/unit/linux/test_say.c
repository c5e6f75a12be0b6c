/* SPDX-License-Identifier: MIT */
/* Lines on stderr, and whom they hold up: nobody, also when nobody reads them. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "say.h"

#define PATIENCE_S 10

/* stderr is a pipe; what has come out of it. */
struct bench {
    int old;
    int out;
    char text[4096];
};

static void take_stderr(struct bench *self)
{
    int both[2];
    assert_int_equal(pipe2(both, O_CLOEXEC), 0);
    self->old = dup(STDERR_FILENO);
    assert_true(self->old >= 0 && dup2(both[1], STDERR_FILENO) >= 0);
    (void)close(both[1]);
    self->out = both[0];
    assert_int_equal(fcntl(self->out, F_SETFL, O_NONBLOCK), 0);
    (void)alarm(PATIENCE_S); /* a line that holds up ends the test */
}

static void give_stderr(struct bench *self)
{
    (void)alarm(0);
    assert_true(dup2(self->old, STDERR_FILENO) >= 0);
    (void)close(self->old);
    (void)close(self->out);
}

static const char *heard(struct bench *self)
{
    const ssize_t n = read(self->out, self->text, sizeof self->text - 1);
    self->text[n > 0 ? n : 0] = '\0';
    return self->text;
}

/* Until it takes nothing more. */
static void fill_stderr(void)
{
    static const char bytes[4096];
    const int flags = fcntl(STDERR_FILENO, F_GETFL);
    assert_int_equal(fcntl(STDERR_FILENO, F_SETFL, flags | O_NONBLOCK), 0);
    while (write(STDERR_FILENO, bytes, sizeof bytes) > 0) {
    }
    assert_int_equal(fcntl(STDERR_FILENO, F_SETFL, flags), 0);
}

static void empty_stderr(struct bench *self)
{
    while (read(self->out, self->text, sizeof self->text) > 0) {
    }
}

static void *complain(void *ctx)
{
    lx_complain("%s", (const char *)ctx);
    return NULL;
}

static void complain_elsewhere(char *text)
{
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, complain, text), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
}

static void each_line_says_who_says_it(void **state)
{
    static const struct lx_say all = {.quiet = false};
    static const struct lx_say quiet = {.quiet = true};
    struct bench self;
    (void)state;
    take_stderr(&self);
    lx_complain("%s is %d", "a", 1);
    assert_string_equal(heard(&self), "drehgeber: a is 1\n");
    lx_note(&all, "%s is %d", "b", 2);
    assert_string_equal(heard(&self), "drehgeber: b is 2\n");
    lx_note(&quiet, "%s is %d", "c", 3);
    assert_string_equal(heard(&self), "");
    lx_print("%s is %d", "d", 4);
    assert_string_equal(heard(&self), "d is 4\n");
    give_stderr(&self);
}

static void a_long_line_is_cut(void **state)
{
    char text[LX_LINE_MAX + 1u];
    struct bench self;
    (void)state;
    memset(text, 'x', sizeof text - 1u);
    text[sizeof text - 1u] = '\0';
    take_stderr(&self);
    lx_print("%s", text);
    assert_int_equal(strlen(heard(&self)), LX_LINE_MAX); /* its end stands for the zero */
    give_stderr(&self);
}

/* Of whichever thread; the next line that is taken says how many they were. */
static void lines_that_nobody_reads_are_counted(void **state)
{
    struct bench self;
    (void)state;
    take_stderr(&self);
    fill_stderr();
    lx_complain("one");
    complain_elsewhere("two");
    lx_print("three");
    empty_stderr(&self);
    complain_elsewhere("four");
    assert_string_equal(
        heard(&self), "drehgeber: 3 lines left out, because they were not read\ndrehgeber: four\n");
    lx_complain("five");
    assert_string_equal(heard(&self), "drehgeber: five\n");
    give_stderr(&self);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_line_says_who_says_it),
        cmocka_unit_test(a_long_line_is_cut),
        cmocka_unit_test(lines_that_nobody_reads_are_counted),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
