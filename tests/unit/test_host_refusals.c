/* SPDX-License-Identifier: MIT */
/*
 * What a handle refuses, and what it does without power; STATe? of an SSI encoder behind its panel.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/ssi.h"
#include "host_rig.h"
#include "ram_nvm.h"

static struct ram_nvm ram;
static struct host_rig_place panel_place;

static void the_memory_of_a_host_is_the_hosts(void **state)
{
    uint8_t bytes[8] = {0};
    struct dg_host *self = host_rig_make(&host_rig_here, "s3684-biss");
    const struct dg_nvm nvm = ram_nvm_port(&ram);
    const struct dg_nvm none = {NULL, NULL};

    (void)state;
    ram_nvm_init(&ram, sizeof ram.bytes);
    assert_string_equal(dg_host_model(self), "s3684-biss");
    assert_string_equal(dg_host_protocol(self), host_rig_model("s3684-biss")->protocol);
    assert_int_equal(dg_host_memory_copy(self, bytes, sizeof bytes), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_memory_load(self, bytes, sizeof bytes), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_memory_port(self, NULL), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_memory_port(self, &none), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_memory_port(self, &nvm), DG_HOST_OK);
    assert_int_equal(dg_host_memory_copy(self, bytes, sizeof bytes), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_memory_load(self, bytes, sizeof bytes), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_power(self, 0, false), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_int_equal(dg_host_memory_port(self, &nvm), DG_HOST_ERR_STATE);

    /* The next one takes it over, one of another kind does not. */
    self = host_rig_make(&host_rig_here, "s3684-biss");
    assert_int_equal(dg_host_memory_port(self, &nvm), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    self = host_rig_make(&host_rig_here, "f3668");
    assert_int_equal(dg_host_memory_port(self, &nvm), DG_HOST_OK);
    assert_true(dg_host_power(self, 0, true) < 0);
    assert_false(dg_host_powered(self));
}

static void nothing_answers_without_power(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host_frame frame;
    uint8_t byte = 0;
    uint64_t now = READY + MS;

    (void)state;
    assert_int_equal(dg_host_registers_read(self, &now, 0x78, &byte, 0), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_registers_read(self, &now, 0x80, &byte, 1), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_registers_write(self, &now, 0x78, &byte, 0), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_registers_write(self, &now, 0x80, &byte, 1), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_power(self, now, false), DG_HOST_OK);
    assert_int_equal(dg_host_frame(self, now + MS, &frame), DG_HOST_ERR_STATE);
    now += 2 * MS;
    assert_int_equal(dg_host_registers_read(self, &now, 0x78, &byte, 1), DG_HOST_ERR_STATE);

    self = host_rig_start(&host_rig_here, "ocd-ib-k3");
    host_rig_drain(self);
    assert_int_equal(dg_host_power(self, READY, false), DG_HOST_OK);
    const struct dg_host_event cycle = {.at = READY + MS, .kind = DG_HOST_WORDS, .length = 4};
    struct dg_host_event back;
    assert_int_equal(dg_host_send(self, &cycle), DG_HOST_OK);
    (void)dg_host_step(self, READY + 2 * MS);
    assert_int_equal(dg_host_receive(self, &back), 0);
}

static void ask(struct dg_host_panel *board, uint64_t at, const char *line, const char *has)
{
    char answer[1024] = "";
    const int n = dg_host_scpi(board, at, line, answer, sizeof answer);

    if (n <= 0 || strstr(answer, has) == NULL) {
        print_error("%s: %d '%s' lacks '%s'\n", line, n, answer, has);
        fail();
    }
}

static void an_ssi_encoder_says_how_it_is(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ssi-28");
    struct dg_host_panel *board = dg_host_panel_make(&panel_place, sizeof panel_place, self);
    struct dg_host_frame frame;
    char answer[8];

    (void)state;
    assert_non_null(board);
    ask(board, READY, "STAT?", "power=1,mode=idle");
    ask(board, READY, "STAT?", "leds=-,errors=-,frames=0,repeats=0");
    assert_int_equal(dg_host_frame(self, READY + MS, &frame), DG_HOST_OK);
    ask(board, READY + 2 * MS, "STAT?", "frames=1,repeats=0,aborted=0,fast=0,word=000D0001");
    ask(board, READY + 2 * MS, "FAUL:SET led_current_high;:FAUL:SET watchdog_fired;:STAT?",
        "errors=01/40");
    assert_int_equal(dg_host_scpi(board, READY + 2 * MS, "SSI:FRAM?", answer, sizeof answer), 0);
    ask(board, READY + 2 * MS, "SYST:ERR?", "-241");
    ask(board, READY + 2 * MS, "POW OFF;:STAT?", "power=0,mode=off");
    ask(board, READY + 2 * MS, "POW ON;:STAT?", "power=1,mode=");
    assert_int_equal(dg_ssi_stack.mount(NULL, NULL), DG_ERR_ARGUMENT);
}

/* 25 bits are seven digits: 3.25 turns are 6800h, and 5C00h in Gray code. */
static void its_word_has_the_digits_of_its_bits(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ssi-25");
    struct dg_host_panel *board = dg_host_panel_make(&panel_place, sizeof panel_place, self);
    struct dg_host_frame frame;

    (void)state;
    assert_int_equal(dg_host_frame(self, READY, &frame), DG_HOST_OK);
    ask(board, frame.end, "STAT?", "word=0005C00");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_memory_of_a_host_is_the_hosts),
        cmocka_unit_test(nothing_answers_without_power),
        cmocka_unit_test(an_ssi_encoder_says_how_it_is),
        cmocka_unit_test(its_word_has_the_digits_of_its_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
