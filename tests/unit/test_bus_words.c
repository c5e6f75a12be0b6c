/* SPDX-License-Identifier: MIT */
/*
 * A ring as a bus: images, ID cycles, transmission errors, breaks, LEDs, faults of the wire, what
 * is held back, what the tap is told, cycles that nobody runs, and a ring of one, which is as an
 * encoder alone.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "drehgeber/interbus.h"
#include "host_rig.h"
#include "ring_rig.h"

#define DEVICES RING_RIG_ENCODERS

/* K1, K3, K2, K3: words 0, 1-2, 3-4, 5-6. */
static const char *const names[DEVICES] = {"ocd-ib-k1", "ocd-ib-k3", "ocd-ib-k2", "ocd-ib-k3"};

static struct ring_rig rig;
static uint16_t *const out = rig.out;
static uint16_t *const in = rig.in;

/* Turn its shaft to the middle of a step of 4096 a turn. */
static void turn_to(size_t place, int64_t steps)
{
    dg_host_shaft(rig.encoders[place], rig.now, steps * (DG_TURN / 4096) + DG_TURN / 8192, 0);
}

static const struct dg_ib *device(size_t place)
{
    return ring_rig_device(&rig, place);
}

static const struct dg_ring_counters *counters(void)
{
    return &dg_ring_state(rig.bus)->counters;
}

static int set_up_closed(void **state)
{
    (void)state;
    ring_rig_init(&rig);
    for (size_t i = 0; i < DEVICES; i++) {
        (void)dg_host_set(ring_rig_add(&rig, names[i]), "self_test_ms", "0");
        turn_to(i, 0x100 * ((int64_t)i + 1));
    }
    return 0;
}

static void open_ring(void)
{
    ring_rig_open(&rig);
    rig.now = DG_S(1);
}

static int set_up(void **state)
{
    (void)set_up_closed(state);
    open_ring();
    return 0;
}

static enum dg_ring_result cycle(void)
{
    rig.now += DG_MS(1);
    return ring_rig_cycle(&rig);
}

static uint16_t identify(void)
{
    return ring_rig_identify(&rig);
}

static void check_ids(const uint16_t expected[DEVICES])
{
    for (size_t i = 0; i < DEVICES; i++) {
        assert_int_equal(dg_ring_id_word(rig.bus, i), expected[i]);
    }
}

static void images(void **state)
{
    static const uint16_t positions[7] = {0x100, 0, 0x200, 0, 0x300, 0, 0x400};

    (void)state;
    assert_int_equal(dg_ring_state(rig.bus)->words, 7);
    assert_int_equal(cycle(), DG_RING_IDENTIFY);
    assert_int_equal(identify(), DEVICES);
    assert_int_equal(cycle(), DG_RING_OK);
    assert_memory_equal(in, positions, sizeof positions);
    out[1] = 0x0800;
    out[2] = 0x0007;
    out[3] = 0x0800; /* a K2 does not look */
    out[5] = 0x2021;
    out[6] = 0x0001;
    for (int i = 0; i < 4; i++) {
        assert_int_equal(cycle(), DG_RING_OK);
    }
    static const uint16_t answers[7] = {0x100, 0xC800, 7, 0, 0x300, 0xA000, 0x1000};
    assert_memory_equal(in, answers, sizeof answers);
}

static void id_words(void **state)
{
    static const uint16_t expected[DEVICES] = {0x0136, 0x0237, 0x0236, 0x0237};
    struct dg_ib_model loop = *dg_ib_model_of(dg_device_find("ocd-ib-k3"));

    (void)state;
    assert_int_equal(identify(), DEVICES);
    check_ids(expected);
    loop.loop = true;
    assert_int_equal(dg_ib_id_word(&loop), 0x02B3);
    loop.profile = DG_IB_K2;
    assert_int_equal(dg_ib_id_word(&loop), 0x02B2);
    loop.profile = DG_IB_K1;
    assert_int_equal(dg_ib_id_word(&loop), 0x01B2);

    ((struct dg_ib *)ring_rig_device(&rig, 1))->reconfigure = true;
    ring_rig_world(&rig, 0)->singleturn_ok = false;
    ring_rig_world(&rig, 1)->singleturn_ok = false; /* a K3 says it in IN */
    assert_int_equal(identify(), DEVICES);
    assert_int_equal(dg_ring_id_word(rig.bus, 0), 0x2136);
    assert_int_equal(dg_ring_id_word(rig.bus, 1), 0x8237);
    assert_true(dg_ib_module_error(device(0)));
    assert_false(dg_ib_module_error(device(1)));
    ring_rig_world(&rig, 0)->singleturn_ok = true;
    ring_rig_world(&rig, 2)->multiturn_sync_ok = false;
    assert_int_equal(cycle(), DG_RING_OK);
    assert_true(dg_ib_module_error(device(2)));
    ring_rig_world(&rig, 2)->multiturn_sync_ok = true;
    assert_int_equal(cycle(), DG_RING_OK);
    assert_false(dg_ib_module_error(device(0)));
    assert_false(dg_ib_module_error(device(2)));
    assert_int_equal(identify(), DEVICES);
    check_ids(expected);
}

/* After a transmission error: five cycles without data, inputs held, no OUT taken. */
static void transmission_errors(void **state)
{
    (void)state;
    (void)identify();
    assert_int_equal(cycle(), DG_RING_OK);
    turn_to(1, 0x777);
    dg_ring_spoil(rig.bus, 2);
    assert_int_equal(cycle(), DG_RING_CRC);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(cycle(), DG_RING_DEAD);
        assert_int_equal(in[2], 0x200);
    }
    assert_int_equal(device(1)->counters.cycles, 1);
    assert_int_equal(cycle(), DG_RING_OK);
    assert_int_equal(in[2], 0x777);
    assert_int_equal(device(2)->counters.crc_errors, 1);
    assert_int_equal(device(1)->counters.crc_errors, 0);
    assert_int_equal(counters()->crc_errors, 1);
    assert_int_equal(counters()->dead, 5);
    (void)identify();
    assert_int_equal(dg_ring_id_word(rig.bus, 2), 0x4236);
    (void)identify();
    assert_int_equal(dg_ring_id_word(rig.bus, 2), 0x0236);

    dg_ring_spoil(rig.bus, 0);
    assert_int_equal(cycle(), DG_RING_CRC);
    assert_int_equal(cycle(), DG_RING_DEAD);
    dg_ring_spoil(rig.bus, 0); /* again, while dead: from the beginning */
    assert_int_equal(cycle(), DG_RING_CRC);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(cycle(), DG_RING_DEAD);
    }
    assert_int_equal(cycle(), DG_RING_OK);
}

static void an_interrupted_ring(void **state)
{
    (void)state;
    for (uint16_t at = 0; at < DEVICES; at++) {
        (void)identify();
        assert_int_equal(cycle(), DG_RING_OK);
        in[0] = 0x5555;
        dg_ring_cut(rig.bus, at);
        assert_int_equal(cycle(), DG_RING_INTERRUPTED);
        assert_int_equal(identify(), at);
        for (uint16_t i = 0; i < at; i++) {
            assert_int_equal((dg_ib_leds(device(i), rig.now) & DG_IB_LED_RD) != 0, i + 1 == at);
        }
        assert_int_equal(cycle(), DG_RING_INTERRUPTED);
        assert_int_equal(in[0], 0x5555);
        dg_ring_cut(rig.bus, DG_RING_WHOLE);
        assert_int_equal(cycle(), DG_RING_IDENTIFY);
        assert_int_equal(identify(), DEVICES);
        assert_int_equal(cycle(), DG_RING_OK);
        for (uint16_t i = 0; i < DEVICES; i++) {
            assert_int_equal(dg_ib_leds(device(i), rig.now) & DG_IB_LED_RD, 0);
        }
    }
}

/* The start after a break leaves no dead cycles behind. */
static void a_break_ends_dead_cycles(void **state)
{
    (void)state;
    (void)identify();
    dg_ring_spoil(rig.bus, 1);
    assert_int_equal(cycle(), DG_RING_CRC);
    dg_ring_cut(rig.bus, 1);
    assert_int_equal(cycle(), DG_RING_INTERRUPTED);
    dg_ring_cut(rig.bus, DG_RING_WHOLE);
    (void)identify();
    assert_int_equal(cycle(), DG_RING_OK);
}

/* A device that lost its power breaks the ring, and needs an ID cycle when it is back. */
static void a_device_without_power(void **state)
{
    (void)state;
    (void)identify();
    assert_int_equal(cycle(), DG_RING_OK);
    ring_rig_power(&rig, 2, false);
    assert_int_equal(cycle(), DG_RING_INTERRUPTED);
    ring_rig_power(&rig, 2, true);
    assert_int_equal(cycle(), DG_RING_IDENTIFY);
    (void)identify();
    assert_int_equal(cycle(), DG_RING_OK);
    ring_rig_power(&rig, 1, false); /* off and on between two cycles */
    ring_rig_power(&rig, 1, true);
    assert_int_equal(cycle(), DG_RING_IDENTIFY);
}

/* 3.3, I20 */
static void leds(void **state)
{
    const struct dg_ib *second = device(1);

    (void)state;
    assert_int_equal(dg_ib_leds(second, rig.now), DG_IB_LED_UL);
    (void)identify();
    assert_int_equal(dg_ib_leds(second, rig.now), DG_IB_LED_UL | DG_IB_LED_RC);
    (void)cycle();
    assert_int_equal(dg_ib_leds(second, rig.now), DG_IB_LED_UL | DG_IB_LED_RC | DG_IB_LED_BA);
    assert_int_equal(dg_ib_leds(second, rig.now + DG_IB_BUS_TIMEOUT),
                     DG_IB_LED_UL | DG_IB_LED_RC | DG_IB_LED_BA);
    assert_int_equal(dg_ib_leds(second, rig.now + DG_IB_BUS_TIMEOUT + 1), DG_IB_LED_UL);
    rig.now = DG_S(2);
    (void)identify();
    assert_int_equal(dg_ib_leds(second, rig.now),
                     DG_IB_LED_UL | DG_IB_LED_RC | DG_IB_LED_BA | DG_IB_LED_BA_BLINKS);
    rig.now = DG_S(2) + DG_MS(500);
    (void)identify();
    assert_int_equal(dg_ib_leds(second, rig.now),
                     DG_IB_LED_UL | DG_IB_LED_RC | DG_IB_LED_BA_BLINKS);
}

/* 2.1: the message is bits 13 to 15; the ID code below stays what the device has. */
static void a_message_leaves_the_id_code(void **state)
{
    static const uint16_t expected[DEVICES] = {0x8136, 0x8237, 0x8236, 0x8237};

    (void)state;
    for (size_t i = 0; i < DEVICES; i++) {
        ((struct dg_ib *)ring_rig_device(&rig, i))->reconfigure = true;
    }
    assert_int_equal(identify(), DEVICES);
    check_ids(expected);
}

/* ------------------------------------------------------------ what makes no ring */

static uint64_t no_ticket(void *ctx, size_t place)
{
    (void)ctx;
    (void)place;
    return 0;
}

static void what_makes_no_ring(void **state)
{
    const struct dg_bus_ops ops = {.answer = NULL};
    const struct dg_bus_ops holds = {.ticket = no_ticket};
    const struct dg_bus_words_setup wire = {sizeof wire, in, 3, false};
    const struct dg_bus_words_setup strange = {sizeof wire - 1, in, 3, false};
    const struct dg_bus_words_setup nowhere = {sizeof wire, NULL, 3, false};
    struct dg_bus_setup setup = {sizeof setup, &dg_bus_words, DEVICES, &wire, &ops, NULL};
    void *memory = rig.of_bus.bytes;
    const size_t size = sizeof rig.of_bus.bytes;

    (void)state;
    assert_int_equal(dg_bus_size(&dg_bus_words, 0), 0);
    assert_int_equal(dg_bus_size(&dg_bus_words, DG_RING_MAX + 1), 0);
    assert_true(dg_bus_size(&dg_bus_words, DG_RING_MAX) > 0);
    const void *const bad[] = {NULL, &strange, &nowhere};
    for (size_t i = 0; i < DG_COUNT(bad); i++) {
        setup.wire = bad[i];
        assert_null(dg_bus_init(memory, size, &setup));
    }
    setup.wire = &wire;
    setup.ops = &holds; /* nobody could say when it is durable */
    assert_null(dg_bus_init(memory, size, &setup));
    setup.ops = &ops;
    struct dg_bus *bus = dg_bus_init(memory, size, &setup);
    assert_non_null(bus);
    assert_int_equal(dg_bus_attach(bus, host_rig_start(&host_rig_here, "f3668"), NULL),
                     DG_ERR_ARGUMENT);
    assert_int_equal(dg_bus_attach(bus, rig.encoders[1], NULL), 0);
    assert_int_equal(dg_bus_attach(bus, rig.encoders[2], NULL), DG_ERR_SPACE); /* 3 words */
    assert_int_equal(dg_bus_attach(bus, rig.encoders[0], NULL), 1);
    assert_int_equal(dg_bus_count(bus), 2);
    assert_ptr_equal(dg_bus_encoder(bus, 1), rig.encoders[0]);
    assert_true(dg_bus_next(bus) == DG_NEVER);
}

/* Of another size, or nothing of a ring: nobody is there for it. */
static void what_is_no_cycle(void **state)
{
    struct dg_tap_event event = {.at = rig.now, .kind = DG_TAP_WORDS, .words = {.out = out}};

    (void)state;
    event.words.count = 6;
    (void)dg_bus_rx(rig.bus, &event);
    event.kind = DG_TAP_NOTE;
    event.words.count = 7;
    (void)dg_bus_rx(rig.bus, &event);
    assert_int_equal(counters()->cycles, 0);
    event.kind = DG_TAP_WORDS;
    (void)dg_bus_rx(rig.bus, &event);
    assert_int_equal(counters()->cycles, 1);
}

/* ------------------------------------------------------------ faults of the wire */

/* A cycle that does not take place reaches nobody. */
static void dropped_cycles(void **state)
{
    (void)state;
    (void)identify();
    assert_int_equal(cycle(), DG_RING_OK);
    ring_rig_bend(&rig, 2, DG_WIRE_DROP, 3);
    turn_to(0, 0x111);
    for (unsigned i = 0; i < 3; i++) {
        assert_int_equal(cycle(), DG_RING_OK); /* of the latest one that took place */
        assert_true(dg_ring_state(rig.bus)->dropped);
        assert_int_equal(in[0], 0x100);
    }
    assert_int_equal(device(0)->counters.cycles, 1);
    assert_int_equal(counters()->cycles, 1);
    assert_int_equal(cycle(), DG_RING_OK);
    assert_false(dg_ring_state(rig.bus)->dropped);
    assert_int_equal(in[0], 0x111);
    ring_rig_bend(&rig, 0, DG_WIRE_DROP, 1);
    const uint32_t ids = counters()->ids;
    (void)identify();
    assert_int_equal(counters()->ids, ids);
}

/* As often as the fault says, not in dead cycles, and not in an ID cycle. */
static void damaged_cycles(void **state)
{
    (void)state;
    ring_rig_bend(&rig, 1, DG_WIRE_DAMAGE, 2);
    assert_int_equal(cycle(), DG_RING_IDENTIFY);
    (void)identify();
    for (unsigned error = 1; error <= 2; error++) {
        assert_int_equal(cycle(), DG_RING_CRC);
        for (unsigned i = 0; i < DG_RING_DEAD_CYCLES; i++) {
            assert_int_equal(cycle(), DG_RING_DEAD);
        }
        assert_int_equal(device(1)->counters.crc_errors, error);
    }
    assert_int_equal(cycle(), DG_RING_OK);
    (void)identify();
    assert_int_equal(dg_ring_id_word(rig.bus, 1), 0x4237);
    assert_int_equal(dg_ring_id_word(rig.bus, 0), 0x0136);
}

/* The first break counts, of a fault or as set. */
static void breaks_by_faults(void **state)
{
    (void)state;
    dg_ring_cut(rig.bus, 2);
    assert_int_equal(identify(), 2);
    ring_rig_bend(&rig, 1, DG_WIRE_BREAK, 0);
    assert_int_equal(identify(), 1);
    ring_rig_bend(&rig, 0, DG_WIRE_BREAK, 0);
    assert_int_equal(identify(), 0);
    ring_rig_mend(&rig, 0, DG_WIRE_BREAK);
    ring_rig_mend(&rig, 1, DG_WIRE_BREAK);
    assert_int_equal(identify(), 2);
    dg_ring_cut(rig.bus, DG_RING_WHOLE);
    assert_int_equal(identify(), DEVICES);
}

/* The high half is of the cycle before, as that was and not as it was seen. */
static void torn_words(void **state)
{
    (void)state;
    (void)identify();
    turn_to(0, 0x123);
    turn_to(1, 0x12345);
    assert_int_equal(cycle(), DG_RING_OK);
    ring_rig_bend(&rig, 0, DG_WIRE_TEAR, 2);
    ring_rig_bend(&rig, 1, DG_WIRE_TEAR, 1);
    turn_to(0, 0x456);
    turn_to(1, 0x23456);
    turn_to(3, 0x23456);
    assert_int_equal(cycle(), DG_RING_OK);
    assert_int_equal(in[0], 0x156);
    assert_int_equal(in[1], 1);
    assert_int_equal(in[2], 0x3456);
    assert_int_equal(in[5], 2); /* nobody tore these */
    turn_to(0, 0x789);
    assert_int_equal(cycle(), DG_RING_OK);
    assert_int_equal(in[0], 0x489);
    assert_int_equal(in[1], 2);
    assert_int_equal(cycle(), DG_RING_OK);
    assert_int_equal(in[0], 0x789);
}

/* ------------------------------------------------------------ held back */

static enum dg_bus_answer disk;
static uint64_t stored;

static enum dg_bus_answer ask_disk(void *ctx, size_t place)
{
    (void)ctx;
    return place == 1 ? disk : DG_BUS_SAY;
}

static uint64_t ask_ticket(void *ctx, size_t place)
{
    (void)ctx;
    return place == 1 ? stored : 0;
}

static int set_up_slow(void **state)
{
    (void)set_up_closed(state);
    disk = DG_BUS_SAY;
    stored = 0;
    rig.ops.answer = ask_disk;
    rig.ops.ticket = ask_ticket;
    open_ring();
    (void)identify();
    return cycle() == DG_RING_OK ? 0 : -1;
}

/* A command that stores: its answer is there when the fourth cycle with it is over. */
static void store(uint16_t value)
{
    out[1] = 0x0A00;
    out[2] = value;
    for (int i = 0; i < 3; i++) {
        assert_int_equal(cycle(), DG_RING_OK);
    }
    stored++;
    assert_int_equal(cycle(), DG_RING_OK);
}

static void an_answer_waits_until_it_is_durable(void **state)
{
    (void)state;
    disk = DG_BUS_KEEP;
    store(0x55);
    for (int i = 0; i < 3; i++) {
        turn_to(1, 0x300 + i);
        assert_int_equal(in[1], 0);
        assert_int_equal(in[2], 0x200);
        assert_int_equal(in[0], 0x100);
        assert_int_equal(cycle(), DG_RING_OK);
    }
    disk = DG_BUS_SAY;
    assert_true(dg_bus_durable(rig.bus, 1, rig.now) == DG_NEVER);
    assert_int_equal(in[1], 0); /* with the next cycle */
    assert_int_equal(cycle(), DG_RING_OK);
    assert_int_equal(in[1], 0xCA00);
    assert_int_equal(in[2], 0x55);
}

/* What is lost is not answered; another command is. */
static void a_lost_answer_never_comes(void **state)
{
    (void)state;
    disk = DG_BUS_KEEP;
    store(0x55);
    disk = DG_BUS_DROP;
    for (int i = 0; i < 3; i++) {
        assert_int_equal(cycle(), DG_RING_OK);
        assert_int_equal(in[2], 0x200);
    }
    out[1] = 0x2021; /* the serial number */
    out[2] = 0;
    assert_int_equal(cycle(), DG_RING_OK);
    assert_int_equal(in[1], 0xCA00); /* what was behind the words that were held back */
    for (int i = 0; i < 3; i++) {
        assert_int_equal(cycle(), DG_RING_OK);
    }
    assert_int_equal(in[1] >> 8, 0xA0);
}

/* What an encoder stores by itself holds up nothing. */
static void nobody_waits_for_the_operating_time(void **state)
{
    (void)state;
    disk = DG_BUS_KEEP;
    stored++;
    turn_to(1, 0x345);
    assert_int_equal(cycle(), DG_RING_OK);
    assert_int_equal(in[2], 0x345);
}

/* ------------------------------------------------------------ the tap */

static char told[512];

static void keep_event(void *ctx, const struct dg_tap_event *event)
{
    const size_t used = strlen(told);

    (void)ctx;
    assert_int_equal(event->at, rig.now);
    assert_false(event->ours);
    if (event->kind == DG_TAP_NOTE) {
        (void)snprintf(told + used, sizeof told - used, "%s|", event->note);
        return;
    }
    assert_int_equal(event->kind, DG_TAP_WORDS);
    assert_int_equal(event->words.count, 7);
    assert_ptr_equal(event->words.in, in);
    /* all of it, where a sanitizer sees it */
    assert_int_equal(memcmp(event->words.out, out, event->words.count * sizeof *out), 0);
    (void)snprintf(told + used, sizeof told - used, "%c", event->words.valid ? '+' : '-');
}

static int set_up_tapped(void **state)
{
    (void)set_up_closed(state);
    rig.ops.tap = keep_event;
    rig.wire.identifies = true;
    told[0] = '\0';
    open_ring();
    return 0;
}

/* ID cycles, breaks and errors, once each. This master identifies by itself. */
static void notes(void **state)
{
    (void)state;
    assert_int_equal(cycle(), DG_RING_IDENTIFY);
    assert_int_equal(cycle(), DG_RING_OK);
    dg_ring_spoil(rig.bus, 3);
    for (int i = 0; i < 7; i++) {
        (void)cycle();
    }
    ring_rig_power(&rig, 1, false);
    assert_int_equal(cycle(), DG_RING_INTERRUPTED);
    assert_int_equal(cycle(), DG_RING_INTERRUPTED);
    ring_rig_power(&rig, 1, true);
    assert_int_equal(cycle(), DG_RING_IDENTIFY);
    assert_int_equal(cycle(), DG_RING_OK);
    ring_rig_bend(&rig, 0, DG_WIRE_DROP, 1);
    assert_int_equal(cycle(), DG_RING_OK);
    assert_string_equal(told, "ID cycle: 4 of 4 devices|-+transmission error|------+"
                              "ID cycle: 1 of 4 devices, interrupted before device 1|--"
                              "ID cycle: 4 of 4 devices|-+-");
    assert_int_equal(counters()->ids, 4);
}

/* Whoever comes later hears what it is then. */
static void nobody_is_told(void **state)
{
    (void)state;
    dg_bus_watch(rig.bus, false);
    (void)cycle();
    dg_ring_cut(rig.bus, 0);
    assert_int_equal(cycle(), DG_RING_INTERRUPTED);
    assert_string_equal(told, "");
    dg_bus_watch(rig.bus, true);
    assert_int_equal(cycle(), DG_RING_INTERRUPTED);
    assert_string_equal(told, "ID cycle: 0 of 4 devices, interrupted before device 0|-");
}

static void run_id_cycle(const uint16_t *words, uint16_t count)
{
    (void)dg_bus_rx(
        rig.bus, &(struct dg_tap_event){.at = rig.now,
                                        .kind = DG_TAP_WORDS,
                                        .words = {.out = words, .count = count, .identify = true}});
}

/* An ID cycle that the master asks for moves no words. It takes place whatever the master has for
 * an image, and only a whole one is shown. */
static void an_id_cycle_is_told(void **state)
{
    (void)state;
    run_id_cycle(out, 7);
    assert_string_equal(told, "ID cycle: 4 of 4 devices|-");
    assert_int_equal(counters()->cycles, 0);
    run_id_cycle(&(uint16_t){0}, 1);
    run_id_cycle(NULL, 7);
    assert_string_equal(told, "ID cycle: 4 of 4 devices|-");
    assert_int_equal(counters()->ids, 3);
}

/* ------------------------------------------------------------ cycles that nobody runs */

static struct dg_ring_counters counted_by_hand(unsigned n)
{
    const struct dg_ring_counters before = *counters();

    for (unsigned i = 0; i < n; i++) {
        (void)cycle();
    }
    struct dg_ring_counters after = *counters();
    after.cycles -= before.cycles;
    after.ids -= before.ids;
    after.interrupted -= before.interrupted;
    return after;
}

static void check_skip(void)
{
    const uint32_t of_first = device(0)->counters.cycles;
    const struct dg_ring_counters wanted = counted_by_hand(5);
    const uint32_t more = device(0)->counters.cycles - of_first;
    const struct dg_ring_counters before = *counters();

    dg_ring_skip(rig.bus, 5);
    assert_int_equal(counters()->cycles - before.cycles, wanted.cycles);
    assert_int_equal(counters()->ids - before.ids, wanted.ids);
    assert_int_equal(counters()->interrupted - before.interrupted, wanted.interrupted);
    assert_int_equal(device(0)->counters.cycles, of_first + 2 * more);
}

static void what_nobody_has_to_run(void **state)
{
    (void)state;
    assert_int_equal(cycle(), DG_RING_IDENTIFY);
    assert_int_equal(dg_ring_quiet(rig.bus), rig.now);
    assert_int_equal(cycle(), DG_RING_OK);
    assert_int_equal(cycle(), DG_RING_OK);               /* the first OUT is handled */
    assert_int_equal(dg_ring_quiet(rig.bus), DG_S(600)); /* a K3 stores its operating time */
    check_skip();
    out[1] = 0x0800;
    assert_int_equal(cycle(), DG_RING_OK);
    assert_int_equal(dg_ring_quiet(rig.bus), rig.now); /* a command waits */
    dg_ring_spoil(rig.bus, 0);
    assert_int_equal(cycle(), DG_RING_CRC);
    assert_int_equal(dg_ring_quiet(rig.bus), rig.now);
    ring_rig_bend(&rig, 0, DG_WIRE_BREAK, 0);
    assert_int_equal(cycle(), DG_RING_INTERRUPTED);
    assert_int_equal(dg_ring_quiet(rig.bus), rig.now); /* a fault may end by itself */
    ring_rig_mend(&rig, 0, DG_WIRE_BREAK);
    dg_ring_cut(rig.bus, 1);
    assert_int_equal(cycle(), DG_RING_INTERRUPTED);
    assert_true(dg_ring_quiet(rig.bus) == DG_NEVER);
    check_skip();
    (void)identify();
    assert_true(dg_ring_quiet(rig.bus) == DG_NEVER);
    const uint32_t ids = counters()->ids;
    const uint32_t cycles = counters()->cycles;
    dg_ring_skip(rig.bus, 7);
    assert_int_equal(counters()->ids, ids + 7);
    assert_int_equal(counters()->cycles, cycles);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(images, set_up),
        cmocka_unit_test_setup(id_words, set_up),
        cmocka_unit_test_setup(transmission_errors, set_up),
        cmocka_unit_test_setup(an_interrupted_ring, set_up),
        cmocka_unit_test_setup(a_break_ends_dead_cycles, set_up),
        cmocka_unit_test_setup(a_device_without_power, set_up),
        cmocka_unit_test_setup(leds, set_up),
        cmocka_unit_test_setup(a_message_leaves_the_id_code, set_up),
        cmocka_unit_test_setup(what_makes_no_ring, set_up_closed),
        cmocka_unit_test_setup(what_is_no_cycle, set_up),
        cmocka_unit_test_setup(dropped_cycles, set_up),
        cmocka_unit_test_setup(damaged_cycles, set_up),
        cmocka_unit_test_setup(breaks_by_faults, set_up),
        cmocka_unit_test_setup(torn_words, set_up),
        cmocka_unit_test_setup(an_answer_waits_until_it_is_durable, set_up_slow),
        cmocka_unit_test_setup(a_lost_answer_never_comes, set_up_slow),
        cmocka_unit_test_setup(nobody_waits_for_the_operating_time, set_up_slow),
        cmocka_unit_test_setup(notes, set_up_tapped),
        cmocka_unit_test_setup(nobody_is_told, set_up_tapped),
        cmocka_unit_test_setup(an_id_cycle_is_told, set_up_tapped),
        cmocka_unit_test_setup(what_nobody_has_to_run, set_up_tapped),
    };
    return cmocka_run_group_tests_name("a ring as a bus", tests, NULL, NULL);
}
