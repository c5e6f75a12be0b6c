/* SPDX-License-Identifier: MIT */
/*
 * A node as a whole: what it refuses to be made of, nodes side by side, a copy that does the same
 * again, time that runs backwards, and every frame there is in every NMT state (CiA 301: services
 * per state).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "co_rig.h"

#define SDO_RX 0x63F
#define SDO_TX 0x5BF
#define EMCY 0x0BF
#define GUARD 0x73F
#define LSS_RX 0x7E5
#define SAVE 0x65766173u /* "save" */

static struct co_rig rig;

static int setup(void **state)
{
    (void)state;
    co_rig_start(&rig);
    return 0;
}

/* ------------------------------------------------------------ setup and power */

static void a_setup_that_lacks_something_is_refused(void **state)
{
    static const struct dg_co_ops no_send = {.send = NULL};
    struct dg_co_node node;
    struct dg_co_setup setups[5];
    (void)state;

    for (size_t i = 0; i < DG_COUNT(setups); i++) {
        setups[i] = rig.node.setup;
    }
    setups[0].device = NULL;
    setups[1].world = NULL;
    setups[2].nvm.ops = NULL;
    setups[3].ops = NULL;
    setups[4].ops = &no_send;
    for (size_t i = 0; i < DG_COUNT(setups); i++) {
        assert_int_equal(dg_co_init(&node, &setups[i]), DG_ERR_ARGUMENT);
    }
    assert_int_equal(dg_co_init(&node, &rig.node.setup), DG_OK);
    assert_int_equal(node.state, DG_CO_OFF);
}

static void bit_rates_need_not_be_listened_to(void **state)
{
    struct dg_co_ops silent = *rig.node.setup.ops;
    struct dg_co_setup setup_without = rig.node.setup;
    (void)state;

    silent.bit_rate = NULL;
    setup_without.ops = &silent;
    assert_int_equal(dg_co_init(&rig.node, &setup_without), DG_OK);
    assert_int_equal(dg_co_power_on(&rig.node, rig.now), DG_OK);
    assert_int_equal(rig.node.bit_rate, 5);
}

static void without_power_nothing_happens(void **state)
{
    uint16_t ids[DG_CO_FILTERS_MAX];
    const struct dg_can_frame start = {.dlc = 2, .data = {1, 0}};
    (void)state;

    dg_co_power_off(&rig.node);
    assert_true(dg_co_rx(&rig.node, rig.now, &start) == DG_NEVER);
    assert_true(dg_co_step(&rig.node, rig.now) == DG_NEVER);
    assert_true(dg_co_bus(&rig.node, rig.now, DG_CO_BUS_OFF) == DG_NEVER);
    assert_int_equal(dg_co_filters(&rig.node, ids), 0);
    assert_int_equal(rig.node.state, DG_CO_OFF);
    co_rig_expect_count(&rig, 0);
}

static void history_does_not_survive_power_off(void **state)
{
    uint32_t count;
    (void)state;

    (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_OVERRUN);
    assert_int_equal(co_rig_read(&rig, 0x1003, 0, &count), 0);
    assert_int_equal(count, 1);
    dg_co_power_off(&rig.node);
    assert_int_equal(dg_co_power_on(&rig.node, rig.now), DG_OK);
    assert_int_equal(co_rig_read(&rig, 0x1003, 0, &count), 0);
    assert_int_equal(count, 0);
}

/* A node that is on and gets its power anew with another memory in it. */
static void switched_on_again_onto_a_foreign_memory_it_goes_off(void **state)
{
    (void)state;
    assert_int_not_equal(rig.node.state, DG_CO_OFF);
    memset(rig.nvm.bytes, 0x5A, rig.nvm.size);
    assert_int_equal(dg_co_power_on(&rig.node, rig.now), DG_ERR_FOREIGN);
    assert_int_equal(rig.node.state, DG_CO_OFF);
    co_rig_forget(&rig);
    co_rig_rx(&rig, 0, "81 00");
    co_rig_run(&rig, DG_S(2));
    co_rig_expect_count(&rig, 0);
}

/* ------------------------------------------------------------ side by side, again */

/* Something of everything: transfers, states, events, time, a save. Deterministic. */
static void live(struct co_rig *self)
{
    self->motion = (struct dg_motion){.kind = DG_MOTION_SPEED, .mrpm = 60000};
    (void)co_rig_write(self, 0x1017, 0, 100, 2);
    (void)co_rig_write(self, 0x1800, 5, 30, 2);
    (void)co_rig_write(self, 0x1016, 1, 0x000501F4, 4);
    co_rig_forget(self);
    co_rig_rx(self, SDO_RX, "40 08 10 00");
    co_rig_rx(self, SDO_RX, "60");
    co_rig_rx(self, 0, "01 3F");
    co_rig_rx(self, 0x705, "05");
    co_rig_run(self, DG_MS(200));
    co_rig_rx(self, 0x80, "");
    co_rig_rtr(self, 0x1BF);
    co_rig_rx(self, SDO_RX, "23 10 10 01 73 61 76 65");
    co_rig_run(self, DG_MS(50));
    (void)dg_co_bus(&self->node, self->now, DG_CO_BUS_PASSIVE);
    (void)dg_co_bus(&self->node, self->now, DG_CO_BUS_ACTIVE);
    co_rig_rx(self, 0, "80 00");
    co_rig_rx(self, LSS_RX, "04 01 00 00 00 00 00 00");
    co_rig_rx(self, LSS_RX, "5E 00 00 00 00 00 00 00");
    co_rig_run(self, DG_MS(75));
}

static void a_copy_does_the_same_again(void **state)
{
    static struct co_rig begin;
    static struct co_rig first;
    (void)state;

    memcpy(&begin, &rig, sizeof rig);
    live(&rig);
    assert_true(rig.count > 15);
    memcpy(&first, &rig, sizeof rig);
    memcpy(&rig, &begin, sizeof rig);
    live(&rig);
    assert_memory_equal(&rig, &first, sizeof rig);
}

/* A node holds no pointers into itself: it can be moved while it lives. */
static void a_node_can_be_moved(void **state)
{
    static struct co_rig other;
    struct dg_co_node moved;
    (void)state;

    co_rig_start(&other);
    live(&other);
    co_rig_rx(&rig, SDO_RX, "40 08 10 00"); /* a transfer is under way */
    moved = rig.node;
    memset(&rig.node, 0xA5, sizeof rig.node);
    rig.node = moved;
    memset(&moved, 0xA5, sizeof moved);
    co_rig_forget(&rig);
    live(&rig);
    assert_int_equal(rig.count, other.count);
    assert_memory_equal(rig.frame, other.frame, other.count * sizeof other.frame[0]);
}

static void two_nodes_do_not_notice_each_other(void **state)
{
    static struct co_rig alone;
    static struct co_rig other;
    (void)state;

    co_rig_start(&alone);
    co_rig_start(&other);
    live(&alone);
    co_rig_rx(&other, 0, "01 00");
    (void)co_rig_write(&other, 0x1005, 0, 0x90, 4);
    (void)co_rig_write(&other, 0x1017, 0, 7, 2);
    (void)co_rig_write(&other, 0x1010, 1, SAVE, 4);
    live(&rig);
    co_rig_run(&other, DG_MS(500));
    assert_int_equal(rig.count, alone.count);
    assert_memory_equal(rig.frame, alone.frame, alone.count * sizeof alone.frame[0]);
    assert_memory_equal(rig.at, alone.at, alone.count * sizeof alone.at[0]);
    assert_memory_equal(rig.nvm.bytes, alone.nvm.bytes, alone.nvm.size);
    assert_memory_equal(rig.node.value, alone.node.value, sizeof alone.node.value);
    assert_int_equal(other.node.value[0], 0x90);
}

/* ------------------------------------------------------------ time */

static void time_that_runs_backwards_stands_still(void **state)
{
    const struct dg_can_frame upload = {.id = SDO_RX, .dlc = 8, .data = {0x40, 0, 0x10, 0}};
    const dg_ns begin = rig.now;
    (void)state;

    assert_int_equal(co_rig_write(&rig, 0x1017, 0, 100, 2), 0);
    co_rig_run(&rig, DG_MS(250));
    co_rig_forget(&rig);
    assert_true(dg_co_step(&rig.node, 0) == begin + DG_MS(300));
    assert_true(dg_co_rx(&rig.node, begin + DG_MS(50), &upload) == begin + DG_MS(300));
    assert_true(dg_co_bus(&rig.node, 1, DG_CO_BUS_OVERRUN) == begin + DG_MS(300));
    assert_true(rig.node.now == begin + DG_MS(200)); /* the deadline it was stepped at last */
    co_rig_expect_count(&rig, 3); /* the answer, 8110h and its end; no heartbeat */
    co_rig_expect(&rig, 0, SDO_TX, "43 00 10 00 96 01 02 00");
}

static void the_end_of_time_is_no_moment(void **state)
{
    const dg_ns begin = rig.now;
    (void)state;

    assert_int_equal(co_rig_write(&rig, 0x1017, 0, 100, 2), 0);
    co_rig_forget(&rig);
    assert_true(dg_co_step(&rig.node, DG_NEVER) == begin + DG_MS(100));
    co_rig_expect_count(&rig, 0);
    assert_true(dg_co_step(&rig.node, DG_NEVER - 1) == DG_NEVER);
    co_rig_expect_count(&rig, 1);
}

/* ------------------------------------------------------------ every frame in every state */

/* What a data frame says to the services that look at its data. */
static const uint8_t payloads[][8] = {
    {0x40, 0x00, 0x10, 0x00}, /* SDO: upload of 1000h */
    {0x01, 0x3F},             /* NMT: start */
    {0x04, 0x01},             /* LSS: switch to configuration */
    {0x00},
};

/* What must come of a frame. */
struct outcome {
    unsigned count; /* frames sent */
    uint16_t id;    /* CAN-ID of the first */
    enum dg_co_state state;
    bool configuration;
    bool error; /* an entry in 1003h */
};

/* On a remote frame: guarding in every state, TPDOs in Operational. */
static void remote(uint16_t id, bool operational, struct outcome *wanted)
{
    const bool tpdo = id == 0x1BF || id == 0x2BF || id == 0x3BF || id == 0x4BF;

    if (id == GUARD || (tpdo && operational)) {
        wanted->count = 1;
        wanted->id = id;
    }
}

/* SDO and SYNC not in Stopped, LSS not in Operational, NMT always; PDOs in Operational only. */
static struct outcome expected(enum dg_co_state state, const struct dg_can_frame *frame)
{
    const bool operational = state == DG_CO_OPERATIONAL;
    const bool stopped = state == DG_CO_STOPPED;
    struct outcome wanted = {.state = state};

    if (frame->rtr) {
        remote(frame->id, operational, &wanted);
    } else if (frame->id == SDO_RX && frame->dlc == 8 && !stopped) {
        wanted.count = 1; /* an answer or an abort */
        wanted.id = SDO_TX;
    } else if (frame->id == 0x080 && !stopped) {
        wanted.count = frame->dlc != 0 || operational ? 1 : 0;
        wanted.id = frame->dlc != 0 ? EMCY : 0x2BF;
        wanted.error = frame->dlc != 0;
    } else if (frame->id == 0x000 && frame->dlc == 2 && frame->data[0] == 0x01) {
        wanted.state = DG_CO_OPERATIONAL;
        wanted.count = operational ? 0 : 3; /* TPDOs of type 255 */
        wanted.id = 0x1BF;
    } else if (frame->id == LSS_RX && frame->dlc == 8 && frame->data[0] == 0x04) {
        wanted.configuration = !operational;
    }
    return wanted;
}

static void assert_outcome(const struct dg_can_frame *frame, const struct outcome *wanted)
{
    co_rig_forget(&rig);
    (void)dg_co_rx(&rig.node, rig.now, frame);
    if (rig.count != wanted->count || rig.node.state != wanted->state ||
        (rig.count > 0 && rig.frame[0].id != wanted->id) ||
        rig.node.lss.configuration != wanted->configuration ||
        rig.node.history_count != (wanted->error ? 1 : 0)) {
        fail_msg("state %02X: frame %03X, length %u, RTR %d: %u answers, the first %03X",
                 (unsigned)wanted->state, frame->id, frame->dlc, frame->rtr, rig.count,
                 rig.frame[0].id);
    }
}

/* All CAN-IDs, lengths, data and remote frames; the node is the same before each. */
static void send_every_frame(struct outcome (*expect)(enum dg_co_state state,
                                                      const struct dg_can_frame *frame))
{
    const struct dg_co_node node = rig.node;

    for (uint32_t i = 0; i < 0x800u * 9u * 2u * DG_COUNT(payloads); i++) {
        struct dg_can_frame frame = {.id = (uint16_t)(i & 0x7FFu),
                                     .dlc = (uint8_t)(i / 0x800u % 9u),
                                     .rtr = i / (0x800u * 9u) % 2u != 0};
        memcpy(frame.data, payloads[i / (0x800u * 9u * 2u)], 8);
        rig.node = node;
        const struct outcome wanted = expect(node.state, &frame);
        assert_outcome(&frame, &wanted);
    }
}

static void services_work_in_the_states_they_belong_to(void **state)
{
    static const uint8_t commands[] = {0x80, 0x01, 0x02};
    (void)state;

    for (size_t i = 0; i < DG_COUNT(commands); i++) {
        co_rig_nmt(&rig, commands[i]);
        send_every_frame(expected);
    }
}

/* Without a node-ID: LSS and nothing else. */
static struct outcome expected_of_nobody(enum dg_co_state state, const struct dg_can_frame *frame)
{
    return (struct outcome){
        .state = state,
        .configuration =
            frame->id == LSS_RX && frame->dlc == 8 && !frame->rtr && frame->data[0] == 0x04,
    };
}

static void lose_the_node_id(void)
{
    co_rig_rx(&rig, LSS_RX, "04 01 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS_RX, "11 FF 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS_RX, "04 00 00 00 00 00 00 00");
    assert_int_equal(rig.node.id, DG_CO_UNCONFIGURED);
    assert_int_equal(rig.node.state, DG_CO_BOOT);
}

static void without_a_node_id_there_is_only_lss(void **state)
{
    uint16_t ids[DG_CO_FILTERS_MAX];
    (void)state;

    lose_the_node_id();
    send_every_frame(expected_of_nobody);
    assert_int_equal(dg_co_filters(&rig.node, ids), 1);
    assert_int_equal(ids[0], LSS_RX);
}

/* 1029h "stopped" must not take a node without a node-ID out of Initialisation. */
static void without_a_node_id_the_bus_is_not_disturbed(void **state)
{
    static const enum dg_co_bus_event events[] = {DG_CO_BUS_PASSIVE, DG_CO_BUS_OVERRUN,
                                                  DG_CO_BUS_OFF, DG_CO_BUS_ACTIVE};
    (void)state;

    assert_int_equal(co_rig_write(&rig, 0x1029, 1, 2, 1), 0);
    assert_int_equal(co_rig_write(&rig, 0x1017, 0, 10, 2), 0);
    assert_int_equal(co_rig_write(&rig, 0x1010, 1, SAVE, 4), 0);
    lose_the_node_id();
    co_rig_forget(&rig);
    for (size_t i = 0; i < DG_COUNT(events); i++) {
        (void)dg_co_bus(&rig.node, rig.now, events[i]);
        co_rig_run(&rig, DG_MS(100));
    }
    assert_int_equal(rig.node.state, DG_CO_BOOT);
    co_rig_expect_count(&rig, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(switched_on_again_onto_a_foreign_memory_it_goes_off, setup),
        cmocka_unit_test_setup(a_setup_that_lacks_something_is_refused, setup),
        cmocka_unit_test_setup(bit_rates_need_not_be_listened_to, setup),
        cmocka_unit_test_setup(without_power_nothing_happens, setup),
        cmocka_unit_test_setup(history_does_not_survive_power_off, setup),
        cmocka_unit_test_setup(a_copy_does_the_same_again, setup),
        cmocka_unit_test_setup(a_node_can_be_moved, setup),
        cmocka_unit_test_setup(two_nodes_do_not_notice_each_other, setup),
        cmocka_unit_test_setup(time_that_runs_backwards_stands_still, setup),
        cmocka_unit_test_setup(the_end_of_time_is_no_moment, setup),
        cmocka_unit_test_setup(services_work_in_the_states_they_belong_to, setup),
        cmocka_unit_test_setup(without_a_node_id_there_is_only_lss, setup),
        cmocka_unit_test_setup(without_a_node_id_the_bus_is_not_disturbed, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
