/* SPDX-License-Identifier: MIT */
/*
 * Saved states: whose they are, what is in them and what is not, and what a damaged one does.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/crc.h"
#include "drehgeber/drehgeber.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
#include "drehgeber/ssi.h"
#include "host_private.h"
#include "host_rig.h"
#include "ram_nvm.h"

static uint8_t blob[HOST_RIG_MEMORY_MAX];
static uint8_t again[HOST_RIG_MEMORY_MAX];
static struct ram_nvm ram;
static struct host_rig_place panel_place;

static size_t save(struct dg_host *self, uint8_t *to)
{
    assert_int_equal(dg_host_save(self, to, sizeof blob), DG_HOST_OK);
    return dg_host_state_size(self);
}

/* Before the first power-on there are settings, and no device yet. */
static void a_state_may_be_saved_before_the_first_power_on(void **state)
{
    struct dg_host *self = host_rig_make(&host_rig_here, "s3684-rs485");
    struct dg_host *other = host_rig_make(&host_rig_there, "s3684-rs485");
    char text[16];

    (void)state;
    assert_int_equal(dg_host_set(self, "address", "45h"), DG_HOST_OK);
    const size_t n = save(self, blob);
    assert_memory_equal(blob, "DGSTATE\1", 8);
    assert_int_equal(dg_host_restore(other, blob, n), DG_HOST_OK);
    assert_true(dg_host_get(other, "address", text, sizeof text) > 0);
    assert_string_equal(text, "69");
    assert_false(dg_host_powered(other));
    assert_int_equal(dg_host_set(other, "address", "46h"), DG_HOST_OK);
    assert_int_equal(dg_host_power(other, 0, true), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);

    /* One that is on becomes one that never was. */
    assert_int_equal(dg_host_restore(self, blob, n), DG_HOST_OK);
    assert_false(dg_host_powered(self));
    assert_int_equal(dg_host_set(self, "address", "47h"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
}

/* The longest name is cut: the sizes of the model's parts still stand for it. */
static void a_state_keeps_no_more_than_the_beginning_of_a_long_name(void **state)
{
    struct dg_device device = dg_ssi_25;
    struct dg_host *self;
    struct dg_host *other;

    (void)state;
    device.name = "an-encoder-with-a-name-of-more-than-31-characters";
    self = dg_host_init(&host_rig_here, sizeof host_rig_here, &device, &dg_ssi_wire);
    other = dg_host_init(&host_rig_there, sizeof host_rig_there, &device, &dg_ssi_wire);
    const size_t n = save(self, blob);
    assert_int_equal(dg_host_restore(other, blob, n), DG_HOST_OK);
    assert_string_equal(dg_host_model(other), device.name);
    device.name = "an-encoder-with-another-name-of-more-than-31-characters";
    assert_int_equal(dg_host_restore(other, blob, n), DG_HOST_ERR_OTHER);
}

static void put_number(uint8_t *to, uint32_t value, size_t size)
{
    const uint16_t half = (uint16_t)value;

    if (size == sizeof value) {
        memcpy(to, &value, sizeof value);
    } else if (size == sizeof half) {
        memcpy(to, &half, sizeof half);
    } else {
        *to = (uint8_t)value;
    }
}

/* With the sum of what somebody has made of it. */
static void forge(const struct dg_host *self, size_t offset, uint32_t value, size_t size)
{
    const size_t n = dg_host_state_size(self);
    const size_t head = n - dg_host_size(self->refs.device, self->refs.wire);

    memcpy(again, blob, n);
    put_number(again + head + offset, value, size);
    put_number(again + head - sizeof value, dg_crc32(0, again + head, n - head), sizeof value);
}

/* What the handle itself counts by is looked at even when the sum is right. */
static void a_queue_that_cannot_be_is_damage(void **state)
{
    static const struct {
        size_t offset;
        uint32_t bad;
        uint32_t good;
    } rows[] = {
        {offsetof(struct host_queues, in.first), DG_HOST_QUEUE, DG_HOST_QUEUE - 1u},
        {offsetof(struct host_queues, in.count), DG_HOST_QUEUE + 1u, 0},
        {offsetof(struct host_queues, out.first), UINT32_MAX, 0},
        {offsetof(struct host_queues, out.count), DG_HOST_QUEUE + 1u, DG_HOST_QUEUE},
    };
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    const size_t n = save(self, blob);
    const size_t queues = dg_host_round(sizeof *self);

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_host *other = host_rig_make(&host_rig_there, "f3668");
        forge(self, queues + rows[i].offset, rows[i].bad, sizeof rows[i].bad);
        assert_int_equal(dg_host_restore(other, again, n), DG_HOST_ERR_DAMAGED);
        assert_false(dg_host_powered(other));
        forge(self, queues + rows[i].offset, rows[i].good, sizeof rows[i].good);
        assert_int_equal(dg_host_restore(other, again, n), DG_HOST_OK);
        assert_true(dg_host_powered(other));
    }
    forge(self, offsetof(struct dg_host, memory_size), 1u << 20, sizeof self->memory_size);
    assert_int_equal(dg_host_restore(self, again, n), DG_HOST_ERR_DAMAGED);
}

/* ------------------------------------------------------------ numbers that an encoder goes by */

struct bound {
    const char *model;
    bool own; /* of the handle, not of the device */
    size_t offset;
    size_t size;
    uint32_t most;
};
#define BOUND(model, own, type, member, most)                                                      \
    {                                                                                              \
        model, own, offsetof(struct type, member), sizeof(((struct type *)0)->member), most        \
    }
#define HOST(member, most) BOUND("f3668", true, dg_host, member, most)
#define BISS(member, most) BOUND("s3684-biss", false, dg_biss, member, most)
#define CAN(member, most) BOUND("f3668", false, dg_cia406_device, member, most)
#define TPDO(n)                                                                                    \
    CAN(node.tpdo[n].valid, 1), CAN(node.tpdo[n].rtr_allowed, 1), CAN(node.tpdo[n].pending, 1),    \
        CAN(node.tpdo[n].sampled, 1)
#define HF(member, most) BOUND("s3684-rs485", false, dg_hf, member, most)
#define IB(member, most) BOUND("ocd-ib-k3", false, dg_ib, member, most)
#define SSI(member, most) BOUND("ssi-25", false, dg_ssi, member, most)

/* A bool is 0 or 1, an enum has its last value, an index the last place of its table. */
static const struct bound bounds[] = {
    HOST(line.level, 1),
    HOST(line.behind, 1),
    HOST(line.chained, 1),
    HOST(made, 1),
    HOST(loaded, 1),
    HOST(untold, 1),
    HOST(controller, DG_HOST_BUS_OFF),
    BISS(store.region_count, DG_BISS_REGION_COUNT),
    BISS(store.unapplied, 1),
    BISS(line.state, DG_BISS_RETURN),
    BISS(line.length, 63), /* bits of a number of 64 */
    BISS(line.ma, 1),
    BISS(line.slo, 1),
    BISS(line.is_last, 1),
    BISS(line.hinted, 1),
    BISS(control.state, DG_BISS_CONTROL_STATE_COUNT - 1u),
    BISS(control.address, 0x7F),
    BISS(control.r, 1),
    BISS(control.w, 1),
    BISS(control.addressed, 1),
    BISS(control.mine, 1),
    BISS(control.refused, 1),
    BISS(control.cds, 1),
    BISS(control.id, 7),
    BISS(started, 1),
    BISS(mounted, 1),
    BISS(configured, 1),
    BISS(simulated, 1),
    BISS(channel_off, 1),
    BISS(communication_off, 1),
    CAN(node.store.unapplied, 1),
    CAN(node.mounted, 1),
    CAN(node.emcy_count, DG_CO_HISTORY),
    CAN(node.emcy_first, DG_CO_HISTORY - 1u),
    CAN(node.history_count, DG_CO_HISTORY),
    CAN(node.history_newest, DG_CO_HISTORY - 1u),
    CAN(node.guard_toggle, 1),
    CAN(node.bus_off, 1),
    CAN(node.bus_absent, 1),
    CAN(node.bus_found, 1),
    CAN(node.lss.configuration, 1),
    CAN(node.lss.changed, 1),
    CAN(node.sdo.sized, 1),
    CAN(node.sdo.crc, 1),
    CAN(node.sdo.seqno, 127), /* CiA 301: segments of a block */
    CAN(node.sdo.blksize, 127),
    CAN(node.sync_mask, (1u << DG_CO_TPDOS) - 1u),
    TPDO(0),
    TPDO(1),
    TPDO(2),
    TPDO(3),
    CAN(encoder.usf_lost, 1),
    CAN(encoder.zero_unsaved, 1),
    CAN(encoder.serial_open, 1),
    CAN(encoder.wrong_count, 8), /* C41: delays of wrong passwords */
    HF(store.region_count, DG_HF_REGION_COUNT),
    HF(store.unapplied, 1),
    HF(frame_damaged, 1),
    HF(length, DG_HF_FRAME_MAX + 1u), /* one more: too long */
    HF(stack_count, DG_HF_STACK_DEPTH),
    IB(store.region_count, DG_IB_REGION_COUNT),
    IB(store.unapplied, 1),
    IB(powered, 1),
    IB(mounted, 1),
    IB(reconfigure, 1),
    IB(crc_error, 1),
    IB(outgoing_off, 1),
    IB(invalid, 1),
    IB(frozen, 1),
    IB(preset_flag, 1),
    IB(sent.steps, DG_IB_DATA_MASK),
    IB(sent.revolutions, DG_IB_TURNS_MAX),
    IB(mode, DG_IB_CAM + DG_IB_PROGRAMS),
    IB(shift_iw, 25), /* 9.5: bits of a word */
    IB(program_number, DG_IB_PROGRAMS),
    SSI(state, DG_SSI_SHIFT),
    SSI(left, 25),
    SSI(clock, 1),
    SSI(data, 1),
};

/* One more than there may be is damage, whatever the sum says; the most there may be is not. */
static void numbers_have_their_bounds(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(bounds); i++) {
        const struct bound *row = &bounds[i];
        struct dg_host *self = host_rig_start(&host_rig_here, row->model);
        struct dg_host *other = host_rig_make(&host_rig_there, row->model);
        const uint8_t *base = row->own ? (uint8_t *)self : self->line.device;
        const size_t offset = (size_t)(base - (uint8_t *)self) + row->offset;
        const size_t n = save(self, blob);

        forge(self, offset, row->most + 1u, row->size);
        if (dg_host_restore(other, again, n) != DG_HOST_ERR_DAMAGED) {
            fail_msg("row %zu of %s: %u is taken", i, row->model, (unsigned)row->most + 1u);
        }
        forge(self, offset, row->most, row->size);
        if (dg_host_restore(other, again, n) != DG_HOST_OK) {
            fail_msg("row %zu of %s: %u is refused", i, row->model, (unsigned)row->most);
        }
    }
}

/* Numbers that are in their range and do not fit together: the largest that does is taken, or there
 * is none. */
struct misfit {
    const char *model;
    size_t offset; /* in the device */
    size_t size;
    uint32_t bad;
    uint32_t good;
    bool has_good;
};
#define MISFIT(model, type, member, bad)                                                           \
    {                                                                                              \
        model, offsetof(struct type, member), sizeof(((struct type *)0)->member), bad, 0, false    \
    }
#define EDGE(model, type, member, good)                                                            \
    {                                                                                              \
        model, offsetof(struct type, member), sizeof(((struct type *)0)->member), (good) + 1u,     \
            good, true                                                                             \
    }
#define NODE(member, bad) MISFIT("f3668", dg_cia406_device, node.member, bad)

static const struct misfit misfits[] = {
    /* 2048 x 32 x 4096 positions; a turn has a period, a period has a step */
    EDGE("s3684-rs485", dg_hf, offset, 2048u * 32u * 4096u - 1u),
    MISFIT("s3684-rs485", dg_hf, periods, 0),
    MISFIT("s3684-rs485", dg_hf, steps, 0),
    MISFIT("s3684-rs485", dg_hf, turns, 0),
    MISFIT("s3684-biss", dg_biss, control.id, 8),
    /* the discs have 4096 steps a turn, and 4096 turns */
    MISFIT("ocd-ib-k3", dg_ib, steps, 0),
    EDGE("ocd-ib-k3", dg_ib, steps, 4096),
    MISFIT("ocd-ib-k3", dg_ib, revolutions, 0),
    EDGE("ocd-ib-k3", dg_ib, revolutions, 4096),
    MISFIT("ocd-ib-k2", dg_ib, mounted, 1), /* it has no EEPROM */
    EDGE("ssi-13", dg_ssi, left, 13),
    EDGE("ssi-13", dg_ssi, bits, 13),
    /* bit rates 0 to 8 but 7 (2100h) */
    EDGE("f3668", dg_cia406_device, node.bit_rate, 8),
    NODE(bit_rate, 7),
    EDGE("f3668", dg_cia406_device, node.lss.bit_rate, 8),
    NODE(lss.bit_rate, 7),
    /* TPDO1 has 6004h: four bytes, of which one more entry makes eight, or none */
    NODE(tpdo[0].length, 5),
    NODE(tpdo[0].mapped_count, 0),
    NODE(tpdo[0].mapped_count, DG_CO_MAPPED_MAX + 1u),
    NODE(tpdo[0].mapped[0], 0x7FFF),
    NODE(tpdo[0].mapped[0], 0xFFFF),
    NODE(active_causes, 0x80000000u),
};

static void numbers_fit_together(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(misfits); i++) {
        const struct misfit *row = &misfits[i];
        struct dg_host *self = host_rig_start(&host_rig_here, row->model);
        struct dg_host *other = host_rig_make(&host_rig_there, row->model);
        const uint8_t *device = self->line.device;
        const size_t offset = (size_t)(device - (uint8_t *)self) + row->offset;
        const size_t n = save(self, blob);

        forge(self, offset, row->bad, row->size);
        if (dg_host_restore(other, again, n) != DG_HOST_ERR_DAMAGED) {
            fail_msg("row %zu of %s: %u is taken", i, row->model, (unsigned)row->bad);
        }
        forge(self, offset, row->good, row->size);
        if (row->has_good && dg_host_restore(other, again, n) != DG_HOST_OK) {
            fail_msg("row %zu of %s: %u is refused", i, row->model, (unsigned)row->good);
        }
    }
}

/* Sixteen characters wait: as many as an event has. */
static void a_full_event_may_wait(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    struct dg_host *other = host_rig_make(&host_rig_there, "s3684-rs485");
    const struct dg_host_event full = {.at = 2 * READY, .kind = DG_HOST_BYTES, .length = 16};

    (void)state;
    assert_int_equal(dg_host_send(self, &full), DG_HOST_OK);
    const size_t n = save(self, blob);
    assert_int_equal(dg_host_restore(other, blob, n), DG_HOST_OK);
}

/* Behind a power-off and behind the start nothing of a device need be other than 0. */
static void a_state_without_power_is_whole(void **state)
{
    (void)state;
    for (size_t i = 0; i < host_rig_model_count; i++) {
        struct dg_host *self = host_rig_start(&host_rig_here, host_rig_models[i].name);
        struct dg_host *other = host_rig_make(&host_rig_there, host_rig_models[i].name);
        assert_int_equal(dg_host_power(self, READY, false), DG_HOST_OK);
        const size_t n = save(self, blob);
        assert_int_equal(dg_host_restore(other, blob, n), DG_HOST_OK);
        assert_false(dg_host_powered(other));
        assert_int_equal(dg_host_power(other, 2 * READY, true), DG_HOST_OK);
        assert_true(dg_host_powered(other));
    }
}

/* Before its first segment a download has no more than the four bytes of its request. */
static void a_download_has_what_its_segments_brought(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    struct dg_host *other = host_rig_make(&host_rig_there, "f3668");
    const struct dg_host_event begun = {.at = READY,
                                        .kind = DG_HOST_CAN,
                                        .id = 0x63F,
                                        .length = 8,
                                        .data = {0x21, 0x17, 0x10, 0, 2}};
    const size_t offset = (size_t)((uint8_t *)self->line.device - (uint8_t *)self) +
                          offsetof(struct dg_cia406_device, node.sdo.length);

    (void)state;
    assert_int_equal(dg_host_send(self, &begun), DG_HOST_OK);
    (void)dg_host_step(self, READY);
    const size_t n = save(self, blob);
    forge(self, offset, 4, 1);
    assert_int_equal(dg_host_restore(other, again, n), DG_HOST_OK);
    forge(self, offset, 5, 1);
    assert_int_equal(dg_host_restore(other, again, n), DG_HOST_ERR_DAMAGED);
}

static struct dg_host *on_the_hosts_memory(struct host_rig_place *place, bool loaded)
{
    struct dg_host *self = host_rig_make(place, "s3684-biss");
    const struct dg_nvm nvm = ram_nvm_port(&ram);

    if (!loaded) {
        ram_nvm_init(&ram, sizeof ram.bytes);
    }
    assert_int_equal(dg_host_memory_port(self, &nvm), DG_HOST_OK);
    return self;
}

/* The host's EEPROM is not in it, so a handle without one cannot go on from it, nor the other way
 * round; one with another EEPROM of the host's works on that. */
static void the_memory_of_a_host_stays_outside(void **state)
{
    struct dg_host *self = on_the_hosts_memory(&host_rig_here, false);
    struct dg_host *own = host_rig_start(&host_rig_there, "s3684-biss");
    struct dg_host_frame frame;
    uint64_t now = READY;
    uint8_t byte = 0x5A;

    (void)state;
    const size_t n_own = save(own, blob);
    assert_int_equal(dg_host_restore(self, blob, n_own), DG_HOST_ERR_OTHER);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    (void)dg_host_step(self, now);
    assert_int_equal(dg_host_registers_write(self, &now, 0x23, &byte, 1), 1);
    const size_t n = save(self, blob);
    assert_int_equal(dg_host_restore(own, blob, n), DG_HOST_ERR_OTHER);

    own = on_the_hosts_memory(&host_rig_there, true);
    assert_int_equal(dg_host_restore(own, blob, n), DG_HOST_OK);
    byte = 0;
    assert_int_equal(dg_host_registers_read(own, &now, 0x23, &byte, 1), 1);
    assert_int_equal(byte, 0x5A); /* in force, not stored */
    const uint32_t writes = ram.writes;
    byte = 1; /* command 01: store */
    assert_int_equal(dg_host_registers_write(own, &now, 0x60, &byte, 1), 1);
    assert_true(ram.writes > writes);
    assert_int_equal(dg_host_frame(own, now, &frame), DG_HOST_OK);
}

static void never(void *ctx, const struct dg_host_event *event)
{
    (void)event;
    ++*(unsigned *)ctx;
}

/* The same encoder with a listener, a panel and a shaft of the host's, and without them. */
static void what_a_host_has_attached_is_not_in_it(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    struct dg_host *other = host_rig_make(&host_rig_there, "f3668");
    static struct dg_shaft shaft;
    unsigned heard = 0;

    (void)state;
    const size_t n = save(self, blob);
    assert_memory_equal(blob, "DGSTATE\1f3668\0", 14);
    assert_string_equal((const char *)blob + 40, dg_version());
    assert_int_equal(dg_host_restore(other, blob, n), DG_HOST_OK);
    assert_non_null(dg_host_panel_make(&panel_place, sizeof panel_place, other));
    dg_shaft_init(&shaft);
    dg_host_shaft_of(other, &shaft);
    dg_host_listen(other, never, &heard);
    memset(again, 0xA5, sizeof again);
    assert_int_equal(dg_host_save(other, again, n), DG_HOST_OK);
    assert_memory_equal(blob, again, n);
    assert_int_equal(again[n], 0xA5);

    /* But it stays attached, also when it goes on from a state. */
    const struct dg_host_event read = {
        .at = READY, .kind = DG_HOST_CAN, .id = 0x63F, .length = 8, .data = {0x40, 0x01, 0x10}};
    for (unsigned round = 1; round <= 2; round++) {
        assert_int_equal(dg_host_send(other, &read), DG_HOST_OK);
        (void)dg_host_step(other, READY);
        assert_int_equal(heard, round);
        assert_int_equal(dg_host_angle(other, READY), 0);
        assert_int_equal(dg_host_restore(other, blob, n), DG_HOST_OK);
    }
    dg_host_shaft_of(other, NULL);
    assert_int_equal(dg_host_angle(other, READY), 3 * TURN + TURN / 4);
}

/* What the encoder senses is what the host does from then on. */
static void a_restored_encoder_is_on_its_own_shaft(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    struct dg_host *other = host_rig_make(&host_rig_there, "f3668");
    uint64_t counts = 0;

    (void)state;
    assert_int_equal(dg_host_restore(other, blob, save(self, blob)), DG_HOST_OK);
    dg_host_shaft(self, READY, 7 * TURN, 0);
    dg_host_shaft(other, READY, 9 * TURN, 0);
    assert_int_equal(dg_host_position(other, READY, &counts), DG_HOST_OK);
    assert_int_equal(counts, 9u << 16);
    assert_int_equal(dg_host_position(self, READY, &counts), DG_HOST_OK);
    assert_int_equal(counts, 7u << 16);
}

/* The panel is not of the encoder: neither its shaft nor its faults are in the state, but what they
 * have made of world and EEPROM is, and a panel that is there stays. */
static void a_panel_stays_outside(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    struct dg_host_panel *board = dg_host_panel_make(&panel_place, sizeof panel_place, self);
    struct dg_host *other = host_rig_make(&host_rig_there, "s3684-rs485");
    char answer[64];
    int64_t value = 0;

    (void)state;
    assert_int_equal(dg_host_fault_set(board, READY, "temperature_high", true), DG_HOST_OK);
    assert_int_equal(dg_host_fault_set(board, READY, "wire_drop", true), DG_HOST_OK);
    assert_int_equal(dg_host_scpi(board, READY, "SHAF:POS 90", answer, sizeof answer), 0);
    const size_t n = save(self, blob);
    assert_int_equal(dg_host_restore(other, blob, n), DG_HOST_OK);
    assert_int_equal(dg_host_world_get(other, "temperature", &value), DG_HOST_OK);
    assert_true(value > 100000);
    /* Its own shaft, where the host had put it. */
    assert_int_equal(dg_host_angle(other, READY), 3 * TURN + TURN / 4);
    const struct dg_host_event request = {
        .at = READY + MS, .kind = DG_HOST_BYTES, .length = 3, .data = {0x40, 0x50, 0x10}};
    struct dg_host_event event;
    host_rig_drain(other);
    assert_int_equal(dg_host_send(other, &request), DG_HOST_OK);
    (void)dg_host_step(other, READY + 100 * MS);
    assert_int_equal(dg_host_receive(other, &event), 1); /* nothing drops it here */

    assert_int_equal(dg_host_restore(self, blob, n), DG_HOST_OK);
    assert_int_equal(dg_host_angle(self, READY), TURN / 4);
    host_rig_drain(self);
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    (void)dg_host_step(self, READY + 100 * MS);
    assert_int_equal(dg_host_receive(self, &event), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_state_may_be_saved_before_the_first_power_on),
        cmocka_unit_test(a_state_keeps_no_more_than_the_beginning_of_a_long_name),
        cmocka_unit_test(a_queue_that_cannot_be_is_damage),
        cmocka_unit_test(numbers_have_their_bounds),
        cmocka_unit_test(numbers_fit_together),
        cmocka_unit_test(a_full_event_may_wait),
        cmocka_unit_test(a_state_without_power_is_whole),
        cmocka_unit_test(a_download_has_what_its_segments_brought),
        cmocka_unit_test(the_memory_of_a_host_stays_outside),
        cmocka_unit_test(what_a_host_has_attached_is_not_in_it),
        cmocka_unit_test(a_restored_encoder_is_on_its_own_shaft),
        cmocka_unit_test(a_panel_stays_outside),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
