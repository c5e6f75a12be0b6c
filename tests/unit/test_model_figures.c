/* SPDX-License-Identifier: MIT */
/*
 * Figures that no built-in model has, of encoders whose frames have no form of their own: which
 * commands of HIPERFACE there are and what 44h and 52h tell, the ID word of INTERBUS. Frames were
 * worked out by hand: address, command, data, and the XOR of all of them.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/interbus.h"
#include "drehgeber/rig.h"
#include "hf_rig.h"

#define MEMORY_SIZE 32768u

struct bench {
    _Alignas(16) unsigned char memory[MEMORY_SIZE];
    struct dg_plan plan;
    struct dg_plan_error error;
};
static struct bench bench;

static int read_model(const char *figures)
{
    char text[400];
    const int n = snprintf(text, sizeof text, "[model x]\n%s\n", figures);
    const struct dg_plan_setup setup = {
        .size = sizeof setup,
        .file = "x.ini",
        .text = {text, (size_t)n},
        .memory = bench.memory,
        .memory_size = MEMORY_SIZE,
    };
    return dg_plan_read(&bench.plan, &setup, &bench.error);
}

static const struct dg_device *make_model(const char *figures)
{
    if (read_model(figures) != DG_OK) {
        fail_msg("%s: %s %s; %s", figures, bench.error.key, bench.error.what, bench.error.right);
    }
    return bench.plan.models[0].device;
}

/* ---------------------------------------------------------------- HIPERFACE */

static struct hf_rig rig;

static void start_encoder(const char *figures)
{
    assert_int_equal(hf_rig_init(&rig, dg_hf_model_of(make_model(figures))), DG_OK);
    rig.angle = (int64_t)1 << 30; /* a quarter turn */
    rig.world.temperature_mdegc = 37000;
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
}

static void assert_reply(const char *request, size_t n, const char *reply, size_t length)
{
    assert_int_equal(hf_rig_send(&rig, (const uint8_t *)request, n), length);
    assert_memory_equal(rig.reply, reply, length);
}
#define ASSERT_REPLY(request, reply)                                                               \
    assert_reply(request, sizeof request - 1u, reply, sizeof reply - 1u)

static const char sin1024[] = "base = s3674-rs485\nperiods = 1024\nsteps = 32\ntype = 32h\n"
                              "memory = 64\ntemperature_channel = 40h\n"
                              "commands = 42h, 44h,50h,52h\n";

/* A quarter of 32768 steps is 2000h; 52h: setting, type, memory, option. */
static void commands_that_are_there(void **state)
{
    (void)state;
    start_encoder(sin1024);
    ASSERT_REPLY("\x40\x42\x02", "\x40\x42\x00\x00\x20\x00\x22");
    ASSERT_REPLY("\x40\x44\x40\x44", "\x40\x44\x40\x00\x25\x61");
    ASSERT_REPLY("\x40\x52\x12", "\x40\x52\xE4\x32\x40\x00\x84");
    ASSERT_REPLY("\x40\x50\x10", "\x40\x50\x00\x10");
}

/* Each of them, as a code that there never was; and the answer is not on the error stack. */
static void commands_that_are_not(void **state)
{
    static const uint8_t codes[] = {0x41, 0x43, 0x46, 0x47, 0x49, 0x4A, 0x4B, 0x4C,
                                    0x4D, 0x4E, 0x4F, 0x53, 0x55, 0x56, 0x57, 0x6A};
    (void)state;
    start_encoder(sin1024);
    for (size_t i = 0; i < sizeof codes; i++) {
        const char request[3] = {0x40, (char)codes[i], (char)(0x40 ^ codes[i])};
        assert_reply(request, 3, "\x40\x50\x0B\x1B", 4);
    }
    ASSERT_REPLY("\x40\x50\x10", "\x40\x50\x00\x10");
    start_encoder("base = s3674-rs485\n");
    ASSERT_REPLY("\x40\x46\x06", "\x40\x46\x00\x00\x00\x06");
}

static void commands_go_on_to_models_above(void **state)
{
    static const char three[] = "base = s3674-rs485\ncommands = 42h\n"
                                "[model y]\nbase = x\nperiods = 1024\n"
                                "[model z]\nbase = y\ncommands = 50h\n";
    (void)state;
    (void)make_model(three);
    const struct dg_hf_model *y = dg_hf_model_of(bench.plan.models[1].device);
    const struct dg_hf_model *z = dg_hf_model_of(bench.plan.models[2].device);
    assert_int_equal(y->lacks, 0x7FFFEu); /* 19 commands, and not the first */
    assert_int_equal(z->lacks, 0x7FFFFu & ~(UINT32_C(1) << 12));
}

static void commands_that_are_none(void **state)
{
    static const char *const lists[] = {"41h", "42h,,43h", "42h 43h", "read", "142h", ","};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(lists); i++) {
        char figures[80];
        (void)snprintf(figures, sizeof figures, "base = s3674-rs485\ncommands = %s", lists[i]);
        assert_int_equal(read_model(figures), DG_ERR_ARGUMENT);
        assert_string_equal(bench.error.what, "figures that do not fit each other");
        assert_string_equal(bench.error.right, "expected commands of 42h 43h 44h 46h 47h 49h to "
                                               "50h 52h 53h 55h 56h 57h 6Ah, as 42h,43h");
    }
}

/* ---------------------------------------------------------------- INTERBUS */

/* Without the request to configure the bus anew, which the first one has. */
static uint16_t id_of(const char *figures)
{
    static struct dg_ib device;
    static struct dg_world world;
    const struct dg_ib_model *model = dg_ib_model_of(make_model(figures));
    const struct dg_ib_setup setup = {.model = model, .world = &world};
    dg_world_init(&world);
    assert_int_equal(dg_ib_init(&device, &setup), DG_OK);
    assert_int_equal(dg_ib_power_on(&device, 0), DG_OK);
    (void)dg_ib_id(&device, DG_S(2));
    return dg_ib_id(&device, DG_S(2));
}

/* The upper byte is the length in words. */
static void id_words(void **state)
{
    (void)state;
    assert_int_equal(id_of("base = ocd-ib-k2\n"), 0x0236);
    assert_int_equal(id_of("base = ocd-ib-k2\nid_code = 33h\n"), 0x0233);
    assert_int_equal(id_of("base = ocd-ib-k2\nid_code = 33h\nloop = 1\n"), 0x0233);
    assert_int_equal(id_of("base = ocd-ib-k2\nprofile = k1\nturns = 1\n"), 0x0136);
    assert_int_equal(id_of("base = ocd-ib-k2\nprofile = k1\nturns = 1\nloop = 1\n"), 0x01B2);
}

static void profiles_of_texts(void **state)
{
    (void)state;
    const struct dg_ib_model *model =
        dg_ib_model_of(make_model("base = ocd-ib-k1\nprofile = k3\n"));
    assert_int_equal(model->profile, DG_IB_K3);
    assert_int_equal(dg_ib_image_words(model), 2);
    assert_non_null(dg_ib_stack.layout(model));
    model = dg_ib_model_of(make_model("base = ocd-ib-k3\nprofile = k1\nturns = 1\n"));
    assert_int_equal(dg_ib_image_words(model), 1);
    assert_null(dg_ib_stack.layout(model));
    assert_int_equal(read_model("base = ocd-ib-k3\nprofile = k4\n"), DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.right, "expected k1, k2 or k3");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(commands_that_are_there),
        cmocka_unit_test(commands_that_are_not),
        cmocka_unit_test(commands_go_on_to_models_above),
        cmocka_unit_test(commands_that_are_none),
        cmocka_unit_test(id_words),
        cmocka_unit_test(profiles_of_texts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
