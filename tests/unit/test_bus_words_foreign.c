/* SPDX-License-Identifier: MIT */
/*
 * A protocol that nobody knows in a ring, beside encoders of another one: a counter that adds OUT
 * to itself. All that the ring asks of it is what struct dg_host_ring has.
 */
#include <setjmp.h>
#include <stdalign.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "drehgeber/interbus.h"
#include "ring_rig.h"

#define ID_WORD 0x4711u
#define PERIOD DG_MS(10)

/* Its device: it counts by itself, too, once in PERIOD. */
struct counter {
    bool powered;
    bool identified;
    bool last;     /* the ring is cut behind it */
    bool spoilt;   /* a transmission error was found here */
    uint32_t sum;  /* modulo 2^16 it is IN */
    uint32_t runs; /* cycles, those that were skipped included */
    dg_ns due;
};

DG_STACK_WITHOUT_MEMORY;

static bool senses_multiturn(const void *model)
{
    (void)model;
    return false;
}

static int format(const struct dg_stack_setup *setup)
{
    (void)setup;
    return DG_OK;
}

static int init(void *self, const struct dg_stack_setup *setup)
{
    (void)setup;
    *(struct counter *)self = (struct counter){.due = DG_NEVER};
    return DG_OK;
}

static void attach(void *self, const struct dg_stack_setup *setup)
{
    (void)self;
    (void)setup;
}

static int power_on(void *self, dg_ns now)
{
    *(struct counter *)self = (struct counter){.powered = true, .due = now + PERIOD};
    return DG_OK;
}

static void power_off(void *self)
{
    *(struct counter *)self = (struct counter){.due = DG_NEVER};
}

static bool powered(const void *self)
{
    return ((const struct counter *)self)->powered;
}

static dg_ns step(void *self, dg_ns now)
{
    struct counter *counter = self;

    if (counter->due <= now) {
        counter->sum += 0x1000;
        counter->due += PERIOD;
    }
    return counter->due;
}

static const void *model(const void *self)
{
    return self;
}

static uint64_t position(const void *self, dg_ns now)
{
    (void)now;
    return ((const struct counter *)self)->sum;
}

static const struct dg_stack stack = {
    .name = "counter",
    .medium = DG_MEDIUM_WORDS,
    .device_size = sizeof(struct counter),
    .mount = mount,
    DG_STACK_OPERATIONS,
};

/* ------------------------------------------------------------ in a ring */

static uint8_t words(const struct dg_host_line *line)
{
    (void)line;
    return 1;
}

static bool identified(const struct dg_host_line *line)
{
    return ((const struct counter *)line->device)->identified;
}

static uint16_t identify(struct dg_host_line *line, dg_ns now, bool last)
{
    struct counter *counter = line->device;

    (void)now;
    counter->identified = true;
    counter->last = last;
    return (uint16_t)(ID_WORD + (counter->spoilt ? 0x1000u : 0u));
}

static uint32_t exchange(struct dg_host_line *line, dg_ns now, uint32_t out)
{
    struct counter *counter = line->device;

    (void)now;
    counter->runs++;
    counter->sum += out;
    return counter->sum;
}

static void spoil(struct dg_host_line *line)
{
    ((struct counter *)line->device)->spoilt = true;
}

static dg_ns quiet(const struct dg_host_line *line, dg_ns now)
{
    (void)now;
    return ((const struct counter *)line->device)->due;
}

static void count_skipped(struct dg_host_line *line, uint32_t cycles)
{
    ((struct counter *)line->device)->runs += cycles;
}

static const struct dg_host_ring in_ring = {
    .words = words,
    .identified = identified,
    .identify = identify,
    .exchange = exchange,
    .spoil = spoil,
    .quiet = quiet,
    .skip = count_skipped,
};
static bool fits(const void *own, const void *settings, const void *kept)
{
    (void)own;
    (void)settings;
    (void)kept;
    return true;
}

static const struct dg_stack_check any_state = {.fits = fits};
static const struct dg_keys no_keys = {0};
static const uint32_t figures;
static const struct dg_device device = {.name = "counter", .stack = &stack, .model = &figures};
static const struct dg_host_wire wire = {
    .stack = &stack,
    .keys = &no_keys,
    .settings_size = sizeof figures,
    .state = &any_state,
};
static const struct dg_bus_side side = {.wire = &wire, .ring = &in_ring};

/* ------------------------------------------------------------ between a K1 and a K3 */

#define COUNTER 1u

static struct ring_rig rig;

static struct counter *counter(void)
{
    return ring_rig_device(&rig, COUNTER);
}

static int set_up(void **state)
{
    struct ring_rig_place *place = &rig.places[COUNTER];

    (void)state;
    ring_rig_init(&rig);
    (void)ring_rig_add(&rig, "ocd-ib-k1");
    rig.encoders[COUNTER] = dg_host_init_on_bus(place->bytes, sizeof place->bytes, &device, &side);
    rig.count++;
    (void)ring_rig_add(&rig, "ocd-ib-k3");
    ring_rig_open(&rig);
    rig.now = DG_S(1) + DG_MS(1);
    return rig.encoders[COUNTER] != NULL ? 0 : -1;
}

/* Its deadlines are met between cycles: 100 of them by now. */
static void it_stands_in_the_ring(void **state)
{
    (void)state;
    assert_int_equal(dg_ring_state(rig.bus)->words, 4);
    assert_int_equal(ring_rig_cycle(&rig), DG_RING_IDENTIFY);
    assert_int_equal(ring_rig_identify(&rig), 3);
    assert_int_equal(dg_ring_id_word(rig.bus, 0), 0x0136);
    assert_int_equal(dg_ring_id_word(rig.bus, COUNTER), ID_WORD);
    assert_int_equal(dg_ring_id_word(rig.bus, 2), 0x0237);
    rig.out[1] = 7;
    assert_int_equal(ring_rig_cycle(&rig), DG_RING_OK);
    assert_int_equal(rig.in[1], (0x1000 * 100 + 7) & 0xFFFF);
    assert_int_equal(counter()->sum, 0x1000 * 100 + 7);
    assert_int_equal(dg_bus_next(rig.bus), DG_S(1) + PERIOD);
    (void)dg_bus_step(rig.bus, DG_S(1) + 2 * PERIOD);
    assert_int_equal(counter()->sum, 0x1000 * 102 + 7);
}

static void it_feels_what_happens_to_the_ring(void **state)
{
    (void)state;
    (void)ring_rig_identify(&rig);
    dg_ring_spoil(rig.bus, COUNTER);
    assert_int_equal(ring_rig_cycle(&rig), DG_RING_CRC);
    dg_ring_cut(rig.bus, 2);
    assert_int_equal(ring_rig_identify(&rig), 2);
    assert_int_equal(dg_ring_id_word(rig.bus, COUNTER), ID_WORD + 0x1000);
    assert_true(counter()->last);
    ring_rig_power(&rig, COUNTER, false);
    assert_int_equal(ring_rig_identify(&rig), 1);
}

static void it_says_when_it_has_to_be_run(void **state)
{
    (void)state;
    (void)ring_rig_identify(&rig);
    for (int i = 0; i < 2; i++) { /* the K3 handles its first OUT */
        rig.now += DG_MS(1);
        assert_int_equal(ring_rig_cycle(&rig), DG_RING_OK);
    }
    assert_int_equal(dg_ring_quiet(rig.bus), counter()->due);
    dg_ring_skip(rig.bus, 5);
    assert_int_equal(counter()->runs, 7);
}

/* Whoever waits for something still does at another place, and nobody waits when it has left. */
static void its_deadlines_move_with_it(void **state)
{
    (void)state;
    assert_int_equal(dg_bus_step(rig.bus, rig.now), DG_S(1) + PERIOD);
    assert_int_equal(dg_bus_detach(rig.bus, 0, rig.now), DG_S(1) + PERIOD);
    (void)dg_bus_detach(rig.bus, 1, rig.now);
    (void)dg_bus_step(rig.bus, DG_S(1) + PERIOD);
    assert_int_equal(counter()->sum, 0x1000 * 101);
    assert_int_equal(dg_bus_detach(rig.bus, 0, DG_S(1) + PERIOD), DG_NEVER);
    assert_int_equal(dg_bus_step(rig.bus, DG_S(2)), DG_NEVER);
    assert_int_equal(counter()->sum, 0x1000 * 101);
}

/* The ring goes back to where it was, with what the encoder waits for. */
static void its_deadlines_are_in_states(void **state)
{
    static uint8_t of_ring[1024];
    static uint8_t of_encoder[1024];
    const size_t n = dg_bus_state_size(rig.bus);

    (void)state;
    (void)dg_bus_step(rig.bus, rig.now);
    assert_int_equal(dg_host_save(rig.encoders[COUNTER], of_encoder, sizeof of_encoder), 0);
    assert_int_equal(dg_bus_save(rig.bus, of_ring, sizeof of_ring), 0);
    (void)dg_bus_step(rig.bus, DG_S(1) + 5 * PERIOD);
    assert_int_equal(dg_bus_restore(rig.bus, of_ring, n), DG_HOST_ERR_DAMAGED); /* it has not */
    assert_int_equal(dg_host_restore(rig.encoders[COUNTER], of_encoder, sizeof of_encoder), 0);
    assert_int_equal(dg_bus_restore(rig.bus, of_ring, n), DG_HOST_OK);
    assert_int_equal(dg_bus_next(rig.bus), DG_S(1) + PERIOD);
    (void)dg_bus_step(rig.bus, DG_S(1) + 2 * PERIOD);
    assert_int_equal(counter()->sum, 0x1000 * 102);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(it_stands_in_the_ring, set_up),
        cmocka_unit_test_setup(it_feels_what_happens_to_the_ring, set_up),
        cmocka_unit_test_setup(it_says_when_it_has_to_be_run, set_up),
        cmocka_unit_test_setup(its_deadlines_move_with_it, set_up),
        cmocka_unit_test_setup(its_deadlines_are_in_states, set_up),
    };
    return cmocka_run_group_tests_name("a protocol that nobody knows, in a ring", tests, NULL,
                                       NULL);
}
