/* SPDX-License-Identifier: MIT */
/* Figures of models with words and frames of any form: which of them make an encoder. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "biss_private.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/rig.h"
#include "ssi_private.h"

/* ------------------------------------------------------------ in C */

/* 32 bits of each part, 64 bits of all, and what any SSI encoder has to keep to. */
static void ssi_words_of_a_form_have_up_to_64_bits(void **state)
{
    static const struct {
        uint8_t multiturn;
        uint8_t singleturn;
        uint8_t code;
        bool good;
    } rows[] = {{32, 32, 0, true},  {33, 31, 0, false}, {0, 1, 0, true},   {0, 0, 0, false},
                {31, 33, 0, false}, {32, 31, 0, true},  {12, 13, 9, false}};
    struct dg_ssi_form form = dg_ssi_any_form;
    struct dg_ssi_model model = *dg_ssi_model_of(&dg_ssi_25);
    (void)state;
    form.layout[0] = 'P';
    model.error_bit = DG_SSI_ERROR_NONE;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        model.multiturn_bits = rows[i].multiturn;
        model.singleturn_bits = rows[i].singleturn;
        model.code = rows[i].code;
        model.form = &form;
        form.around = 0;
        assert_int_equal(dg_ssi_model_ok(&model), rows[i].good);
    }
    model.code = 0;
    form.around = 2;
    model.multiturn_bits = 32;
    model.singleturn_bits = 31;
    assert_false(dg_ssi_model_ok(&model));
}

static void biss_frames_of_a_form_have_up_to_63_bits(void **state)
{
    static const struct {
        uint8_t multiturn;
        uint8_t singleturn;
        bool good;
    } rows[] = {{32, 17, true}, {33, 16, false}, {0, 7, false},  {0, 8, true},
                {0, 33, false}, {24, 25, true},  {32, 32, false}};
    struct dg_biss_form form = dg_biss_any_form;
    struct dg_biss_model model = *dg_biss_model_of(&dg_s3684_biss);
    (void)state;
    (void)memcpy(form.layout, "PEWC", 5);
    model.form = &form;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        model.multiturn_bits = rows[i].multiturn;
        model.singleturn_bits = rows[i].singleturn;
        (void)dg_biss_form_settle(&model, &form);
        assert_int_equal(dg_biss_model_ok(&model), rows[i].good);
    }
}

/* ------------------------------------------------------------ as a text */

static struct {
    _Alignas(16) unsigned char plan_memory[65536];
    _Alignas(16) unsigned char memory[32768];
    struct dg_plan plan;
    struct dg_plan_error error;
} bench;

static int read_model(const char *text)
{
    const struct dg_plan_setup setup = {.size = sizeof setup,
                                        .file = "x.ini",
                                        .text = {text, strlen(text)},
                                        .memory = bench.plan_memory,
                                        .memory_size = sizeof bench.plan_memory};
    return dg_plan_read(&bench.plan, &setup, &bench.error);
}

static void what_goes_with_what_in_a_word(void **state)
{
    static const struct {
        const char *figures;
        const char *right; /* NULL: it is one */
    } rows[] = {
        {"base = ssi-25\nframe = PY\nparity = odd\nparity_over = position", NULL},
        {"base = ssi-25\nerror_parity = 1", "Y in the frame, which"},
        {"base = ssi-25\nparity_over = position", "Y in the frame, which"},
        {"base = ssi-25\nframe = P0\nerror_parity = 1", "Y in the frame, which"},
        {"base = ssi-25\nframe = PPY", "a frame of P and any of"},
        {"base = ssi-25\nframe = E", "a frame of P and any of"},
        {"base = ssi-25\nframe = PE0", "E in the frame and error_bit"},
        {"base = ssi-25\nframe = PT\nerror_bit = high", "E in the frame and error_bit"},
        {"base = ssi-25\nframe = PT\nparity = even", "Y in the frame and parity"},
        {"base = s3684-biss\nmt = 32\nst = 32", "mt and st, together at most 49"},
        {"base = s3684-biss\nbusy_us = 30\nbusy_jitter_us = 30", "busy_us and busy_jitter_us"},
        {"base = s3684-biss\nerror = high\nbusy_us = 30\nbusy_jitter_us = 30",
         "busy_us and busy_jitter_us"},
        {"base = s3684-biss\nwarning = high", NULL},
        {"base = s3684-biss\ncrc_start = 1", NULL},
        {"base = s3684-biss\ncrc = plain", NULL},
    };
    char text[256];
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        (void)snprintf(text, sizeof text, "[model x]\n%s\n", rows[i].figures);
        const int result = read_model(text);
        const bool said = result != DG_OK && rows[i].right != NULL &&
                          strstr(bench.error.right, rows[i].right) != NULL;
        if (rows[i].right == NULL ? result != DG_OK : !said) {
            fail_msg("%s: %s; %s", rows[i].figures, bench.error.what, bench.error.right);
        }
    }
}

/* A model on a model has the form of the one below it. */
static void a_form_is_handed_on(void **state)
{
    (void)state;
    assert_int_equal(read_model("[model a]\nbase = ssi-25\nframe = 1P0\n"
                                "[model b]\nbase = a\nmt = 10\n"
                                "[model c]\nbase = s3684-biss\nerror = high\n"
                                "[model d]\nbase = c\nmt = 10\n"),
                     DG_OK);
    const struct dg_ssi_model *word = dg_ssi_model_of(dg_plan_find_model(&bench.plan, "b"));
    assert_string_equal(word->form->layout, "1P0");
    assert_int_equal(word->multiturn_bits, 10);
    assert_true(dg_biss_model_of(dg_plan_find_model(&bench.plan, "d"))->form->error_high);
}

/* nERR as BiSS has it is 0 when something is wrong, turned round it is 1. */
static void an_error_has_the_level_of_the_form(void **state)
{
    static const struct {
        const char *text;
        bool high;
    } rows[] = {{"[model x]\nbase = s3684-biss\nlc = 0\nframe = PEWC\n", false},
                {"[model x]\nbase = s3684-biss\nlc = 0\nframe = PEWC\nerror = high\n", true}};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_host_frame good = {.at = 0};
        struct dg_host_frame bad = {.at = 0};
        assert_int_equal(read_model(rows[i].text), DG_OK);
        const struct dg_device *model = bench.plan.models[0].device;
        struct dg_host *host =
            dg_host_init(bench.memory, sizeof bench.memory, model, dg_host_wire_of(model));
        assert_non_null(host);
        assert_int_equal(dg_host_power(host, 0, true), DG_HOST_OK);
        (void)dg_host_step(host, DG_S(1));
        assert_int_equal(dg_host_frame(host, DG_S(1), &good), DG_HOST_OK);
        assert_int_equal(dg_host_world_set(host, DG_S(2), "singleturn_ok", 0), DG_HOST_OK);
        (void)dg_host_step(host, DG_S(3));
        assert_int_equal(dg_host_frame(host, DG_S(3), &bad), DG_HOST_OK);
        assert_false(good.error);
        assert_true(bad.error);
        assert_int_equal(bad.bits >> 7 & 1u, rows[i].high); /* in front of W and six bits of C */
        assert_int_not_equal(good.bits >> 7 & 1u, rows[i].high);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ssi_words_of_a_form_have_up_to_64_bits),
        cmocka_unit_test(biss_frames_of_a_form_have_up_to_63_bits),
        cmocka_unit_test(what_goes_with_what_in_a_word),
        cmocka_unit_test(a_form_is_handed_on),
        cmocka_unit_test(an_error_has_the_level_of_the_form),
    };
    return cmocka_run_group_tests_name("model_limits", tests, NULL, NULL);
}
