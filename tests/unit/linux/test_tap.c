/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tap.h"

/* Who was told, in which order. */
struct log {
    char names[16];
    size_t count;
};

struct ear {
    struct lx_tap_listener listener;
    struct log *log;
    char name;
    struct lx_tap *leaves; /* NULL: stays */
};

static void on_event(void *ctx, const struct dg_tap_event *event)
{
    struct ear *self = ctx;
    assert_int_equal(event->kind, DG_TAP_NOTE);
    assert_string_equal(event->note, "heard");
    self->log->names[self->log->count++] = self->name;
    if (self->leaves != NULL) {
        lx_tap_remove(self->leaves, &self->listener);
    }
}

static void count_sincos(void *ctx, const struct dg_tap_event *event)
{
    unsigned *count = ctx;
    *count += event->kind == DG_TAP_SINCOS;
}

static const struct dg_tap_event heard = {.kind = DG_TAP_NOTE, .note = "heard"};

static void listen(struct lx_tap *tap, struct ear *ear)
{
    ear->listener = (struct lx_tap_listener){.event = on_event, .ctx = ear};
    lx_tap_add(tap, &ear->listener);
}

static void in_the_order_they_came(void **state)
{
    struct lx_tap tap = {.first = NULL};
    struct log log = {"", 0};
    struct ear ears[] = {{.log = &log, .name = 'a'}, {.log = &log, .name = 'b'}};
    (void)state;
    assert_false(lx_tap_on(&tap));
    lx_tap_tell(&tap, &heard);
    listen(&tap, &ears[0]);
    listen(&tap, &ears[1]);
    assert_true(lx_tap_on(&tap));
    lx_tap_tell(&tap, &heard);
    lx_tap_remove(&tap, &ears[0].listener);
    lx_tap_tell(&tap, &heard);
    lx_tap_remove(&tap, &ears[0].listener); /* does not listen any more */
    lx_tap_remove(&tap, &ears[1].listener);
    lx_tap_tell(&tap, &heard);
    assert_string_equal(log.names, "abb");
    assert_false(lx_tap_on(&tap));
}

static void leaving_while_told(void **state)
{
    struct lx_tap tap = {.first = NULL};
    struct log log = {"", 0};
    struct ear ears[] = {{.log = &log, .name = 'a', .leaves = &tap},
                         {.log = &log, .name = 'b'},
                         {.log = &log, .name = 'c', .leaves = &tap}};
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        listen(&tap, &ears[i]);
    }
    lx_tap_tell(&tap, &heard);
    lx_tap_tell(&tap, &heard);
    assert_string_equal(log.names, "abcb");
}

/* Who comes back is the last, whatever stood behind it before. */
static void coming_back(void **state)
{
    struct lx_tap tap = {.first = NULL};
    struct log log = {"", 0};
    struct ear ears[] = {{.log = &log, .name = 'a'}, {.log = &log, .name = 'b'}};
    (void)state;
    listen(&tap, &ears[0]);
    listen(&tap, &ears[1]);
    lx_tap_remove(&tap, &ears[0].listener);
    lx_tap_add(&tap, &ears[0].listener);
    assert_ptr_equal(tap.first, &ears[1].listener);
    assert_null(ears[0].listener.next);
    lx_tap_tell(&tap, &heard);
    assert_string_equal(log.names, "ba");
}

/* Sine and cosine cost time: only who asks is told. */
static void sine_and_cosine_for_those_who_ask(void **state)
{
    const struct dg_tap_event event = {.kind = DG_TAP_SINCOS, .note = NULL};
    struct lx_tap tap = {.first = NULL};
    unsigned told = 0;
    struct lx_tap_listener deaf = {.event = on_event, .ctx = NULL};
    struct lx_tap_listener keen = {.event = count_sincos, .ctx = &told, .sincos = true};
    (void)state;
    lx_tap_add(&tap, &deaf);
    assert_false(lx_tap_asked(&tap));
    lx_tap_tell(&tap, &event);
    lx_tap_add(&tap, &keen);
    assert_true(lx_tap_asked(&tap));
    lx_tap_tell(&tap, &event);
    assert_int_equal(told, 1);
    lx_tap_remove(&tap, &keen);
    assert_false(lx_tap_asked(&tap));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sine_and_cosine_for_those_who_ask),
        cmocka_unit_test(in_the_order_they_came),
        cmocka_unit_test(leaving_while_told),
        cmocka_unit_test(coming_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
