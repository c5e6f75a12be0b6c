/* SPDX-License-Identifier: MIT */
/* A command that goes on behind its handler: the line waits, and so do the bytes behind it. */
#include "drehgeber/scpi.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static struct {
    struct dg_scpi session;
    unsigned left; /* parts of the command */
    bool fails;    /* at its end */
    bool gone;
    bool inside; /* whoever steps the session from there steps nothing */
    char out[64];
    size_t length;
} rig;

static bool poll(struct dg_scpi *self, bool gone)
{
    assert_false(rig.inside);
    rig.inside = true;
    assert_int_equal(dg_scpi_step(self, 0), self->now);
    rig.inside = false;
    rig.gone = gone;
    if (gone || --rig.left > 0) {
        return false;
    }
    dg_scpi_raise(self, rig.fails ? DG_SCPI_ILLEGAL : DG_SCPI_NO_ERROR, "in the end");
    return true;
}

static void begin(struct dg_scpi *self)
{
    dg_scpi_hold(self, poll);
}

static void answer(struct dg_scpi *self)
{
    dg_scpi_put_unsigned(self, 7);
}

static const struct dg_scpi_command rows[] = {
    {"LONG", begin, NULL, 0, "", "takes its time"},
    {"SEVen", NULL, answer, 0, "", "7"},
};
static const struct dg_scpi_commands list = {rows, DG_COUNT(rows)};

static const struct dg_scpi_commands *commands(const struct dg_scpi *self, size_t index)
{
    (void)self;
    return index == 0 ? &list : NULL;
}

static void take_answer(void *ctx, const char *bytes, size_t n)
{
    (void)ctx;
    assert_true(rig.length + n < sizeof rig.out);
    memcpy(rig.out + rig.length, bytes, n);
    rig.length += n;
}

static int setup(void **state)
{
    static const struct dg_scpi_ops ops = {.commands = commands, .write = take_answer};
    const struct dg_scpi_setup made = {.ops = &ops, .idn = "a,b,c,d"};
    (void)state;
    memset(&rig, 0, sizeof rig);
    dg_scpi_init(&rig.session, &made);
    rig.left = 3;
    return 0;
}

static size_t send_text(const char *text)
{
    return dg_scpi_rx(&rig.session, 5, text, strlen(text));
}

static void the_line_waits(void **state)
{
    (void)state;
    assert_int_equal(send_text("LONG;SEV?\nSEV?\n"), 10); /* and no byte of the next one */
    assert_int_equal(rig.left, 3);
    assert_int_equal(dg_scpi_step(&rig.session, 6), 6); /* again at once */
    assert_int_equal(send_text("SEV?\n"), 0);           /* looks, too */
    assert_int_equal(rig.left, 1);
    assert_int_equal(rig.length, 0);
    assert_int_equal(dg_scpi_step(&rig.session, 7), DG_NEVER);
    assert_string_equal(rig.out, "7\n");
    assert_int_equal(send_text("SEV?\n"), 5);
    assert_string_equal(rig.out, "7\n7\n");
}

static void an_error_ends_the_line(void **state)
{
    (void)state;
    rig.fails = true;
    assert_int_equal(send_text("SEV?;LONG;SEV?\n"), 15);
    for (int i = 0; i < 3; i++) {
        (void)dg_scpi_step(&rig.session, 6);
    }
    assert_string_equal(rig.out, "7\n");
    assert_int_equal(send_text("SYST:ERR?\n"), 10);
    assert_non_null(strstr(rig.out, "-224,\"Illegal parameter value;in the end\""));
}

static void a_client_that_goes_gives_up(void **state)
{
    (void)state;
    assert_int_equal(send_text("LONG\n"), 5);
    dg_scpi_leave(&rig.session);
    assert_true(rig.gone);
    assert_null(rig.session.poll);
    rig.gone = false;
    dg_scpi_leave(&rig.session);
    assert_false(rig.gone);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(the_line_waits, setup),
        cmocka_unit_test_setup(an_error_ends_the_line, setup),
        cmocka_unit_test_setup(a_client_that_goes_gives_up, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
