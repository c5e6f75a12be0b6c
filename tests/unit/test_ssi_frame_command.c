/* SPDX-License-Identifier: MIT */
/*
 * SSI:FRAMe?: what the port clocked, taken apart; what it cannot.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/control.h"
#include "drehgeber/instrument.h"
#include "drehgeber/ssi.h"

static char said[256];
static uint64_t clocked;
static int port_says;

static void on_write(void *ctx, const char *bytes, size_t n)
{
    (void)ctx;
    assert_true(strlen(said) + n < sizeof said);
    strncat(said, bytes, n);
}

static void changed(struct dg_rig *rig, struct dg_encoder *encoder, dg_ns now)
{
    (void)rig;
    (void)encoder;
    (void)now;
}

static const char *wire(struct dg_rig *rig, const struct dg_encoder *encoder)
{
    (void)rig;
    (void)encoder;
    return "sim:";
}

static int frame(void *ctx, uint64_t *bits, char *detail)
{
    (void)ctx;
    (void)snprintf(detail, 8, "because");
    *bits = clocked;
    return port_says;
}

static const struct dg_rig_ops ops = {.changed = changed, .wire = wire};
static const struct dg_ssi_port_ops port = {.frame = frame};
static struct dg_world world;
static struct dg_ssi device;
static struct dg_rig_shaft shaft = {.name = "shaft"};
static struct dg_encoder encoder;

static void expect(const char *answer)
{
    static const struct dg_instrument *const instruments[] = {&dg_ssi_instrument};
    struct dg_encoder *encoders[] = {&encoder};
    struct dg_rig_shaft *shafts[] = {&shaft};
    struct dg_rig rig = {.encoders = encoders,
                         .encoder_count = 1,
                         .shafts = shafts,
                         .shaft_count = 1,
                         .ops = &ops,
                         .instruments = instruments,
                         .instrument_count = 1};
    struct dg_control control;
    static const char line[] = "SSI:FRAM?;:SYST:ERR?\nSYST:ERR?\n";

    said[0] = '\0';
    dg_control_init(&control, &rig, on_write, NULL);
    assert_int_equal(dg_control_rx(&control, 0, line, sizeof line - 1u), sizeof line - 1u);
    (void)dg_control_step(&control, 0);
    assert_non_null(strstr(said, answer));
}

static int set_up(void **state)
{
    const struct dg_stack_setup setup = {.model = dg_ssi_28.model, .world = &world};

    (void)state;
    dg_world_init(&world);
    assert_int_equal(dg_ssi_stack.init(&device, &setup), DG_OK);
    encoder = (struct dg_encoder){.name = "e",
                                  .model = &dg_ssi_28,
                                  .instrument = &dg_ssi_instrument,
                                  .device = &device,
                                  .world = &world,
                                  .shaft = &shaft,
                                  .port = &port};
    port_says = DG_SCPI_NO_ERROR;
    return 0;
}

static void a_word_is_taken_apart(void **state)
{
    (void)state;
    clocked = (uint64_t)0x34000u << 2 | 1u; /* three ones: the parity is one */
    expect("212992,0,1;0,\"No error\"");
    clocked = (uint64_t)0x34000u << 2 | 2u; /* error, four ones */
    expect("212992,1,1");
    clocked = (uint64_t)0x34000u << 2;
    expect("212992,0,0");
}

static void what_the_port_cannot_is_told(void **state)
{
    (void)state;
    port_says = DG_SCPI_HARDWARE;
    expect("-240,\"Hardware error;because\"");
    encoder.port = NULL;
    expect("-241");
}

static void another_encoder_has_no_word(void **state)
{
    (void)state;
    encoder.model = &dg_s3684_biss;
    expect("it is no SSI encoder");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_word_is_taken_apart, set_up),
        cmocka_unit_test_setup(what_the_port_cannot_is_told, set_up),
        cmocka_unit_test_setup(another_encoder_has_no_word, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
