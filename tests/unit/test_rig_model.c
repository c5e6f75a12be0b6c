/* SPDX-License-Identifier: MIT */
/*
 * Models that are texts: [model NAME] of a rig file. What a figure does on a wire is the protocols'
 * to test; here is what the reader takes, what it makes of it, and what it says of the rest.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/hal.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/interbus.h"
#include "drehgeber/model.h"
#include "drehgeber/rig.h"
#include "drehgeber/ssi.h"

#define MEMORY_SIZE 65536u

struct bench {
    _Alignas(16) unsigned char memory[MEMORY_SIZE];
    struct dg_plan plan;
    struct dg_plan_error error;
};

static int read_in(struct bench *self, const char *text, size_t size)
{
    const struct dg_plan_setup setup = {
        .size = sizeof setup,
        .file = "lab/bench.ini",
        .text = {text, strlen(text)},
        .memory = self->memory,
        .memory_size = size,
    };
    return dg_plan_read(&self->plan, &setup, &self->error);
}

static void read_good(struct bench *self, const char *text)
{
    if (read_in(self, text, MEMORY_SIZE) != DG_OK) {
        fail_msg("%u: %s = %s: %s; %s", self->error.line, self->error.key, self->error.value,
                 self->error.what, self->error.right);
    }
}

/* Refused in a section that begins with base = `base`, in line 3. */
static void assert_refused(struct bench *self, const char *base, const char *line, const char *what,
                           const char *right)
{
    char text[200];
    (void)snprintf(text, sizeof text, "[model x]\nbase = %s\n%s\n", base, line);
    assert_int_equal(read_in(self, text, MEMORY_SIZE), DG_ERR_ARGUMENT);
    assert_int_equal(self->error.line, 3);
    assert_string_equal(self->error.what, what);
    assert_string_equal(self->error.right, right);
    assert_null(self->plan.memory);
}

static const char la24[] =
    "[model la24]\nbase = s3674-biss\nst = 24\nlc = 0\ntitle = linear, 24 bit\n"
    "source = nobody's\nunmodelled = its lamp\n";

static void figures_of_a_copy(void **state)
{
    static struct bench bench;
    (void)state;
    read_good(&bench, la24);
    assert_int_equal(bench.plan.model_count, 1);
    assert_int_equal(bench.plan.encoder_count, 0);
    const struct dg_plan_model *row = &bench.plan.models[0];
    assert_string_equal(row->device->name, "la24");
    assert_string_equal(row->device->resolution, "linear, 24 bit");
    assert_string_equal(row->device->wire, "BiSS-C");
    assert_string_equal(row->source, "nobody's");
    assert_string_equal(row->unmodelled, "its lamp");
    assert_ptr_equal(row->base, &dg_s3674_biss);
    const struct dg_biss_model *figures = dg_biss_model_of(row->device);
    const struct dg_biss_model *before = dg_biss_model_of(&dg_s3674_biss);
    assert_int_equal(figures->singleturn_bits, 24);
    assert_false(figures->life_counter);
    assert_int_equal(figures->busy, before->busy);
    assert_int_equal(before->singleturn_bits, 21);
    assert_ptr_equal(dg_plan_find_model(&bench.plan, "la24"), row->device);
    assert_ptr_equal(dg_plan_find_model(&bench.plan, "ssi-13"), &dg_ssi_13);
    assert_null(dg_plan_find_model(&bench.plan, "LA24"));
}

/* An encoder of such a model is one of its protocol. */
static void an_encoder_of_a_text(void **state)
{
    static struct bench bench;
    static _Alignas(16) unsigned char memory[32768];
    char text[400];
    char got[16];
    (void)state;
    (void)snprintf(text, sizeof text, "%s[encoder a]\nmodel = la24\nwire = sim\n", la24);
    read_good(&bench, text);
    const struct dg_device *model = bench.plan.encoders[0].model;
    assert_ptr_equal(model, bench.plan.models[0].device);
    struct dg_host *host = dg_host_init(memory, sizeof memory, model, dg_host_wire_of(model));
    assert_non_null(host);
    assert_true(dg_host_get(host, "st", got, sizeof got) > 0);
    assert_string_equal(got, "24");
    assert_int_equal(dg_host_power(host, 0, true), DG_HOST_OK);
}

/* A base that is a text itself hands on what it has changed. */
static void models_on_models(void **state)
{
    static struct bench bench;
    static const char four[] = "[model a]\nbase = ssi-25\nmonoflop_us = 30\n"
                               "[model b]\nbase = a\nst = 14\n"
                               "[model c]\nbase = b\nmt = 8\ntitle = eight\n"
                               "[model d]\nbase = c\ncode = binary\n";
    char text[300];
    (void)state;
    read_good(&bench, four);
    const struct dg_ssi_model *figures = dg_ssi_model_of(dg_plan_find_model(&bench.plan, "d"));
    assert_int_equal(figures->monoflop, DG_US(30));
    assert_int_equal(figures->singleturn_bits, 14);
    assert_int_equal(figures->multiturn_bits, 8);
    assert_int_equal(figures->code, DG_SSI_BINARY);
    assert_string_equal(bench.plan.models[3].device->resolution, "eight");
    assert_int_equal(bench.plan.models[3].depth, DG_PLAN_BASES_MAX);
    (void)snprintf(text, sizeof text, "%s[model e]\nbase = d\n", four);
    assert_int_equal(read_in(&bench, text, MEMORY_SIZE), DG_ERR_ARGUMENT);
    assert_int_equal(bench.error.line, 15);
    assert_string_equal(bench.error.what, "d stands on 4 models already");
}

static const struct dg_device *find_lent(void *ctx, const char *name)
{
    static const struct dg_device lent = {"lent", "SSI", "of somebody", &dg_ssi_stack, NULL, 0};
    struct dg_device *made = ctx;
    *made = lent;
    made->model = dg_ssi_25.model;
    return strcmp(name, "lent") == 0 ? made : NULL;
}

/* Models that a host has besides: behind those of the file, and as a base. */
static void models_of_the_host(void **state)
{
    static struct bench bench;
    static struct dg_device lent;
    static const char text[] =
        "[model own]\nbase = lent\nst = 14\n[encoder a]\nmodel = lent\nwire = sim\n";
    struct dg_plan_setup setup = {
        .size = sizeof setup,
        .file = "lab/bench.ini",
        .text = {text, sizeof text - 1u},
        .memory = bench.memory,
        .memory_size = MEMORY_SIZE,
        .ctx = &lent,
        .find_model = find_lent,
    };
    (void)state;
    assert_int_equal(dg_plan_read(&bench.plan, &setup, &bench.error), DG_OK);
    assert_ptr_equal(bench.plan.encoders[0].model, &lent);
    assert_int_equal(dg_ssi_model_of(bench.plan.models[0].device)->singleturn_bits, 14);
    assert_int_equal(dg_ssi_model_of(bench.plan.models[0].device)->multiturn_bits, 12);
    assert_null(dg_plan_find_model(&bench.plan, "lent")); /* nobody is asked any more */
    setup.find_model = NULL;
    assert_int_equal(dg_plan_read(&bench.plan, &setup, &bench.error), DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.what, "lent is unknown");
}

static void names_that_are_taken(void **state)
{
    static struct bench bench;
    (void)state;
    assert_int_equal(read_in(&bench, "[model ssi-25]\nbase = ssi-13\n", MEMORY_SIZE),
                     DG_ERR_ARGUMENT);
    assert_int_equal(bench.error.line, 1);
    assert_string_equal(bench.error.key, "[model ssi-25]");
    assert_string_equal(bench.error.what, "ssi-25 is built in");
    assert_int_equal(
        read_in(&bench, "[model a]\nbase = ssi-13\n[model a]\nbase = ssi-13\n", MEMORY_SIZE),
        DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.what, "line 1 has the name already");
    assert_int_equal(read_in(&bench, "[model -v]\nbase = ssi-13\n", MEMORY_SIZE), DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.what, "-v looks like an option");
    assert_string_equal(bench.error.right, "expected a letter, digit or '_' in front");
}

static void bases_that_are_none(void **state)
{
    static struct bench bench;
    (void)state;
    assert_int_equal(read_in(&bench, "[model a]\nst = 13\n", MEMORY_SIZE), DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.what, "without a base");
    assert_int_equal(read_in(&bench, "[model a]\nbase = a\n", MEMORY_SIZE), DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.what, "a is unknown");
    assert_non_null(strstr(bench.error.right, " ssi-13 ssi-25"));
    assert_int_equal(
        read_in(&bench, "[model a]\nbase = ssi-13\n[model b]\nbase = c\n", MEMORY_SIZE),
        DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.right + strlen(bench.error.right) - 2u, " a");
    assert_int_equal(read_in(&bench, "[model a]\nbase = f3668\n", MEMORY_SIZE), DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.what, "f3668 has no figures that a text can change");
    assert_int_equal(bench.error.line, 2);
}

/* Registers come from a base only if the text says so, each text anew. */
static void what_is_inherited(void **state)
{
    static struct bench bench;
    (void)state;
    read_good(&bench, "[model a]\nbase = s3674-biss\n"
                      "[model b]\nbase = s3674-biss\ninherit = registers\n"
                      "[model c]\nbase = b\n[model d]\nbase = a\ninherit = registers\n");
    assert_true(dg_biss_model_of(dg_plan_find_model(&bench.plan, "a"))->unidirectional);
    assert_false(dg_biss_model_of(dg_plan_find_model(&bench.plan, "b"))->unidirectional);
    assert_true(dg_biss_model_of(dg_plan_find_model(&bench.plan, "c"))->unidirectional);
    assert_false(dg_biss_model_of(dg_plan_find_model(&bench.plan, "d"))->unidirectional);
    read_good(&bench, "[model a]\nbase = s3674-biss\ninherit = registers,eds\n"
                      "[model b]\nbase = a\ninherit = registers\n"
                      "[model c]\nbase = b\ninherit = eds,registers\n");
    assert_false(dg_biss_model_of(dg_plan_find_model(&bench.plan, "a"))->no_eds);
    assert_true(dg_biss_model_of(dg_plan_find_model(&bench.plan, "b"))->no_eds);
    assert_false(dg_biss_model_of(dg_plan_find_model(&bench.plan, "c"))->no_eds);
    assert_false(dg_biss_model_of(dg_plan_find_model(&bench.plan, "c"))->unidirectional);
    assert_refused(&bench, "s3674-biss", "inherit = registers,banks", "registers,banks is unknown",
                   "expected inherit = registers,eds");
    assert_refused(&bench, "s3674-biss", "inherit = edx", "edx is unknown",
                   "expected inherit = registers,eds");
    assert_refused(&bench, "ssi-13", "inherit = registers",
                   "ssi-13 has nothing to inherit but figures", "leave it out");
}

static void figures_that_are_none(void **state)
{
    static struct bench bench;
    (void)state;
    assert_refused(
        &bench, "s3684-rs485", "address = 0x41", "no figure of s3684-rs485",
        "expected one of: base inherit title source unmodelled serial reaction_us init_ms periods "
        "steps turns memory implemented type option version date designation temperature_min "
        "temperature_max led_min_ma led_max_ma speed_max_rpm commands temperature_channel "
        "led_channel vector_channel vector_min vector_max acceleration_max");
    assert_refused(&bench, "ssi-13", "mt = 40", "", "expected a number in 0..32");
    assert_string_equal(bench.error.key, "mt");
    assert_string_equal(bench.error.value, "40");
    assert_refused(&bench, "ssi-13", "code = grey", "", "expected gray or binary");
    assert_refused(&bench, "s3674-biss", "busy_us = 1.0005", "",
                   "expected a number in 0..40 us with at most 3 decimals");
    assert_refused(&bench, "s3684-rs485", "date = x", "", "expected 8 characters");
    assert_refused(&bench, "s3684-rs485", "serial = ", "", "expected 1 to 9 digits");
}

#define FRAME_OF_SSI                                                                               \
    "expected a frame of P and any of E T F Y, each once, 0 and 1, together at most 64 bits"
#define START_OF_CRC                                                                               \
    "expected crc_start with at most as many bits as crc_poly has after its first 1"
#define FRAME_OF_BISS                                                                              \
    "expected a frame of P and any of E W L C, each once, 0 and 1, together at most 63 bits"

#define DIGITS "expected device_id of 12 hexadecimal digits"

static void figures_that_do_not_fit(void **state)
{
    static const struct {
        const char *text;
        const char *right;
    } rows[] = {
        {"ssi-28\nmt = 32\nst = 32", FRAME_OF_SSI},
        {"ssi-28\nframe = E", FRAME_OF_SSI},
        {"ssi-28\nframe = P E E Y", FRAME_OF_SSI},
        {"ssi-28\nframe = P E Y L", FRAME_OF_SSI},
        {"ssi-28\nmt = 32\nst = 32\nframe = P E Y", FRAME_OF_SSI},
        {"ssi-28\nframe = P Y", "expected E in the frame and error_bit = high or low, or neither"},
        {"ssi-13\nframe = P E", "expected E in the frame and error_bit = high or low, or neither"},
        {"ssi-28\nframe = P E", "expected Y in the frame and parity = even or odd, or neither"},
        {"ssi-13\nparity_over = position",
         "expected Y in the frame, which parity_over and error_parity are about"},
        {"s3684-biss\nst = 32\nmt = 18", "expected mt and st, together at most 49"},
        {"s3684-biss\nframe = E W C", FRAME_OF_BISS},
        {"s3684-biss\nframe = P E W C", "expected L in the frame and lc = 1, or neither"},
        {"s3684-biss\nst = 32\nmt = 14\ncrc_poly = 190D9h", FRAME_OF_BISS},
        {"s3684-biss\ncrc_start = 64", START_OF_CRC},
        {"s3684-biss\ndevice_id = 0400C000000G", DIGITS},
        {"s3684-biss\ndevice_id = 0400C000000/", DIGITS},
        {"s3684-biss\ndevice_id = 0400C00000:0", DIGITS},
        {"s3684-biss\ndevice_id = 0400C00000@0", DIGITS},
        {"s3684-biss\ncrc_poly = 25h\ncrc_start = 20h", START_OF_CRC},
        {"s3684-biss\nbusy_us = 30\nbusy_jitter_us = 30",
         "expected busy_us and busy_jitter_us, together at most 40"},
        {"s3684-rs485\nsteps = 16777216",
         "expected periods x steps at most 16777216, with the turns 2^32; implemented 0 or "
         "memory..128"},
        {"ocd-ib-k1\nsteps = 8192\nturns = 4096",
         "expected steps x turns at most 65536 for a K1, steps from 2 on with steps_minus_one"},
    };
    static struct bench bench;
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        char text[200];
        (void)snprintf(text, sizeof text, "[model x]\nbase = %s\n", rows[i].text);
        assert_int_equal(read_in(&bench, text, MEMORY_SIZE), DG_ERR_ARGUMENT);
        assert_int_equal(bench.error.line, 1);
        assert_string_equal(bench.error.what, "figures that do not fit each other");
        assert_string_equal(bench.error.right, rows[i].right);
    }
}

/* Only models may stand alone: a shaft without an encoder is a file that is not finished. */
static void a_catalogue_has_no_shafts(void **state)
{
    static struct bench bench;
    (void)state;
    assert_int_equal(read_in(&bench, "[model a]\nbase = ssi-13\n[shaft s]\n", MEMORY_SIZE),
                     DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.what, "lab/bench.ini: without encoders");
    assert_int_equal(
        read_in(&bench, "[model a]\nbase = ssi-13\n[bus b]\nwire = slcan\n", MEMORY_SIZE),
        DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.what, "[bus b]: without encoders");
}

/* However little there is, it says that it is not enough. */
static void memory_of_any_size(void **state)
{
    static struct bench bench;
    int result = DG_ERR_SPACE;
    size_t size = 0;
    (void)state;
    while (result != DG_OK) {
        result = read_in(&bench, la24, size);
        assert_true(result == DG_OK || result == DG_ERR_SPACE);
        assert_true(++size < 8192u);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figures_of_a_copy),       cmocka_unit_test(an_encoder_of_a_text),
        cmocka_unit_test(models_on_models),        cmocka_unit_test(models_of_the_host),
        cmocka_unit_test(names_that_are_taken),    cmocka_unit_test(bases_that_are_none),
        cmocka_unit_test(figures_that_are_none),   cmocka_unit_test(what_is_inherited),
        cmocka_unit_test(figures_that_do_not_fit), cmocka_unit_test(a_catalogue_has_no_shafts),
        cmocka_unit_test(memory_of_any_size),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
