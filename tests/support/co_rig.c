/* SPDX-License-Identifier: MIT */
#include "co_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"

_Static_assert(offsetof(struct co_rig, cells) ==
                   offsetof(struct co_rig, encoder) + sizeof(struct dg_cia406),
               "cells lie behind the encoder");

static const struct dg_cia406_model f3668 = {.turns = 4096, .device = &dg_cia406_multiturn};

static void keep_frame(void *ctx, const struct dg_can_frame *frame)
{
    struct co_rig *self = ctx;

    if (self->count < CO_RIG_FRAMES) {
        self->frame[self->count] = *frame;
        self->at[self->count] = self->now;
    }
    self->count++;
}

static void bit_rate(void *ctx, uint16_t kbaud)
{
    struct co_rig *self = ctx;

    self->kbaud = kbaud;
}

static const struct dg_co_ops ops = {.send = keep_frame, .bit_rate = bit_rate};

void co_rig_start(struct co_rig *self)
{
    co_rig_start_model(self, &f3668);
}

void co_rig_start_model(struct co_rig *self, const struct dg_cia406_model *model)
{
    memset(self, 0, sizeof *self);
    self->model = model;
    self->now = DG_S(1);
    dg_world_init(&self->world);
    self->world.angle = dg_motion_angle;
    self->world.angle_ctx = &self->motion;
    ram_nvm_init(&self->nvm, dg_store_size(model->device->layout));
    assert_int_equal(dg_co_format(model->device, ram_nvm_port(&self->nvm), 1234567890u), DG_OK);
    assert_int_equal(co_rig_power_on(self), DG_OK);
    co_rig_forget(self);
}

int co_rig_power_on(struct co_rig *self)
{
    const struct dg_co_setup setup = {
        .device = self->model->device,
        .world = &self->world,
        .nvm = ram_nvm_port(&self->nvm),
        .ops = &ops,
        .ctx = self,
        .application = &self->encoder,
    };

    assert_int_equal(dg_cia406_init(&self->encoder, self->model), DG_OK);
    assert_int_equal(dg_co_init(&self->node, &setup), DG_OK);
    return dg_co_power_on(&self->node, self->now);
}

void co_rig_forget(struct co_rig *self)
{
    self->count = 0;
}

static uint8_t parse(const char *bytes, uint8_t *to)
{
    uint8_t n = 0;

    while (*bytes != '\0') {
        char *end;
        unsigned long byte = strtoul(bytes, &end, 16);
        assert_true(end != bytes && n < 8);
        to[n++] = (uint8_t)byte;
        bytes = end;
        while (*bytes == ' ') {
            bytes++;
        }
    }
    return n;
}

/* What it returns is what a step at the same moment finds, which has nothing left to do. */
static void receive(struct co_rig *self, const struct dg_can_frame *frame)
{
    const dg_ns deadline = dg_co_rx(&self->node, self->now, frame);
    const uint32_t before = self->count;
    struct dg_co_node copy = self->node;

    assert_true(dg_co_step(&copy, self->now) == deadline);
    assert_int_equal(self->count, before);
}

void co_rig_rx(struct co_rig *self, uint16_t id, const char *bytes)
{
    struct dg_can_frame frame = {.id = id};

    frame.dlc = parse(bytes, frame.data);
    if (id >= 0x600 && id <= 0x67F) {
        frame.dlc = 8;
    }
    receive(self, &frame);
}

void co_rig_rtr(struct co_rig *self, uint16_t id)
{
    const struct dg_can_frame frame = {.id = id, .rtr = true};

    receive(self, &frame);
}

void co_rig_run(struct co_rig *self, dg_ns span)
{
    dg_ns end = dg_after(self->now, span);
    dg_ns next = dg_co_step(&self->node, self->now);

    while (next <= end) {
        self->now = next;
        next = dg_co_step(&self->node, self->now);
        assert_true(next > self->now);
    }
    self->now = end;
}

void co_rig_expect(const struct co_rig *self, uint32_t n, uint16_t id, const char *bytes)
{
    uint8_t wanted[8];
    uint8_t length = parse(bytes, wanted);

    assert_true(n < self->count && n < CO_RIG_FRAMES);
    assert_int_equal(self->frame[n].id, id);
    assert_false(self->frame[n].rtr);
    assert_int_equal(self->frame[n].dlc, length);
    assert_memory_equal(self->frame[n].data, wanted, length);
}

void co_rig_expect_count(const struct co_rig *self, uint32_t count)
{
    assert_int_equal(self->count, count);
}

void co_rig_nmt(struct co_rig *self, uint8_t command)
{
    const struct dg_can_frame frame = {.dlc = 2, .data = {command, 0}};

    (void)dg_co_rx(&self->node, self->now, &frame);
    co_rig_forget(self);
}

/* One request, one answer; other frames that come with it do not count. */
static const struct dg_can_frame *sdo(struct co_rig *self, const struct dg_can_frame *request)
{
    co_rig_forget(self);
    (void)dg_co_rx(&self->node, self->now, request);
    if (self->count == 0) {
        co_rig_run(self, DG_MS(20)); /* the answer to "save" takes its time */
    }
    for (uint32_t i = 0; i < self->count && i < CO_RIG_FRAMES; i++) {
        if (self->frame[i].id == 0x580u + self->node.id) {
            return &self->frame[i];
        }
    }
    fail_msg("no answer to an SDO request");
    return NULL;
}

static struct dg_can_frame request(const struct co_rig *self, uint8_t command, uint16_t index,
                                   uint8_t sub)
{
    struct dg_can_frame frame = {.id = (uint16_t)(0x600u + self->node.id), .dlc = 8};

    frame.data[0] = command;
    dg_store_le16(&frame.data[1], index);
    frame.data[3] = sub;
    return frame;
}

uint32_t co_rig_write(struct co_rig *self, uint16_t index, uint8_t sub, uint32_t value,
                      uint8_t size)
{
    struct dg_can_frame frame = request(self, (uint8_t)(0x23u | (4u - size) << 2), index, sub);

    dg_store_le32(&frame.data[4], value);
    const struct dg_can_frame *answer = sdo(self, &frame);
    return answer->data[0] == 0x80 ? dg_load_le32(&answer->data[4]) : 0;
}

uint32_t co_rig_read(struct co_rig *self, uint16_t index, uint8_t sub, uint32_t *value)
{
    const struct dg_can_frame frame = request(self, 0x40, index, sub);
    const struct dg_can_frame *answer = sdo(self, &frame);

    *value = dg_load_le32(&answer->data[4]);
    return answer->data[0] == 0x80 ? *value : 0;
}

void co_rig_put(struct co_rig *self, uint16_t index, uint8_t sub, uint32_t value, uint8_t size)
{
    assert_int_equal(co_rig_write(self, index, sub, value, size), 0);
}

uint32_t co_rig_get(struct co_rig *self, uint16_t index, uint8_t sub)
{
    uint32_t value;

    assert_int_equal(co_rig_read(self, index, sub, &value), 0);
    return value;
}

void co_rig_store_cob_ids(struct co_rig *self, const uint32_t cob_ids[DG_CO_TPDOS])
{
    struct dg_store *const store = &self->node.store;

    assert_int_equal(co_rig_write(self, 0x1010, 1, 0x65766173, 4), 0);
    dg_store_begin(store);
    for (uint8_t n = 0; n < DG_CO_TPDOS; n++) {
        const uint8_t region = (uint8_t)(DG_CO_REGION_TPDO1 + n);
        const uint16_t size = store->layout->regions[region].size;
        uint8_t bytes[DG_STORE_CHECKED_MAX];
        assert_int_equal(dg_store_read(store, region, 0, bytes, size), DG_OK);
        dg_store_le32(bytes, cob_ids[n]); /* stands first */
        (void)dg_store_stage(store, region, 0, bytes, size);
    }
    assert_int_equal(dg_store_commit(store), DG_OK);
}
