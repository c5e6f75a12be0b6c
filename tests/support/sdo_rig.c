/* SPDX-License-Identifier: MIT */
#include "sdo_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define NODE_ID 0x3Fu
#define TIMEOUT DG_S(1)
#define FULL 0xFFFFFFFFu

static void sample(struct dg_co_node *node)
{
    struct sdo_rig *rig = node->setup.application;

    rig->samples++;
}

static dg_co_hook read_samples, refuse_write, refuse_read;

static enum dg_co_abort read_samples(struct dg_co_node *node, const struct dg_co_object *object,
                                     enum dg_co_op op, uint32_t *value)
{
    const struct sdo_rig *rig = node->setup.application;

    (void)object;
    (void)op;
    *value = rig->samples;
    return DG_CO_OK;
}

static enum dg_co_abort refuse_write(struct dg_co_node *node, const struct dg_co_object *object,
                                     enum dg_co_op op, uint32_t *value)
{
    (void)node;
    (void)object;
    return op == DG_CO_WRITE ? (enum dg_co_abort) * value : DG_CO_OK;
}

static enum dg_co_abort refuse_read(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    (void)node;
    (void)object;
    (void)value;
    return op == DG_CO_READ ? DG_CO_NO_DATA : DG_CO_OK;
}

/* clang-format off */
#define RWS (DG_CO_RW | DG_CO_SLOT)
static const struct dg_co_row rows[] = {
    /* index, sub, more, type, flags, slot, default, limits, hook */
    DG_CO_ROW(0x2000, 0, 0, DG_CO_U16, DG_CO_R, 0, 0, 0, 1),
    DG_CO_ROW(0x2001, 0, 0, DG_CO_I8, RWS, SDO_RIG_I8, 0, 1, 0),
    DG_CO_ROW(0x2002, 0, 0, DG_CO_I16, RWS, SDO_RIG_I16, 0, 2, 0),
    DG_CO_ROW(0x2003, 0, 0, DG_CO_I32, RWS, SDO_RIG_I32, 0, 3, 0),
    DG_CO_ROW(0x2004, 0, 0, DG_CO_U8, RWS, SDO_RIG_U8, 0, 0, 0),
    DG_CO_ROW(0x2005, 0, 0, DG_CO_U16, RWS, SDO_RIG_U16, 0, 0, 0),
    DG_CO_ROW(0x2006, 0, 0, DG_CO_U32, RWS, SDO_RIG_U32, 0, 0, 0),
    DG_CO_ROW(0x2007, 0, 0, DG_CO_U8, DG_CO_R | DG_CO_CONST, 0, 1, 0, 0),
    DG_CO_ROW(0x2007, 1, 0, DG_CO_U32, RWS, SDO_RIG_ARRAY, 0, 0, 0),
    DG_CO_ROW(0x2008, 0, 0, DG_CO_U32, DG_CO_W | DG_CO_SLOT, SDO_RIG_WRITE_ONLY, 0, 0, 0),
    DG_CO_ROW(0x200A, 0, 0, DG_CO_U32, DG_CO_RW, 0, 0, 0, 2),
    DG_CO_ROW(0x200B, 0, 0, DG_CO_U8, DG_CO_R, 0, 0, 0, 3),
    DG_CO_ROW(0x2010, 0, 0, DG_CO_STRING, DG_CO_R, 0, 0, 0, 0),
    DG_CO_ROW(0x2011, 0, 0, DG_CO_STRING, DG_CO_R, 0, 1, 0, 0),
    DG_CO_ROW(0x2012, 0, 0, DG_CO_STRING, DG_CO_R, 0, 2, 0, 0),
    DG_CO_ROW(0x2013, 0, 0, DG_CO_STRING, DG_CO_R, 0, 3, 0, 0),
    DG_CO_ROW(0x2014, 0, 0, DG_CO_STRING, DG_CO_R, 0, 4, 0, 0),
    DG_CO_ROW(0x2015, 0, 0, DG_CO_STRING, DG_CO_R, 0, 5, 0, 0),
    DG_CO_ROW(0x2016, 0, 0, DG_CO_STRING, DG_CO_R, 0, 6, 0, 0),
    DG_CO_ROW(0x2017, 0, 0, DG_CO_STRING, DG_CO_R, 0, 7, 0, 0),
    DG_CO_ROW(0x2018, 0, 0, DG_CO_STRING, DG_CO_R, 0, 8, 0, 0),
};
/* clang-format on */

static dg_co_hook *const hooks[] = {NULL, read_samples, refuse_write, refuse_read};
static const struct dg_co_limits limits[] = {
    {0, 0}, {(uint32_t)-100, 100}, {(uint32_t)-1000, 1000}, {(uint32_t)-100000, 100000}};

static const char *const strings[] = {"",
                                      "1.08",
                                      "F3668",
                                      "1234567",
                                      "12345678",
                                      "123456789",
                                      "ABCDEFGHIJKLMN",
                                      "0123456789ABCDEFGHIJKLMNOPQRSTUV",
                                      "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghij"};

static const uint16_t kbaud[] = {250};

static void default_bus(const void *ctx, uint8_t *out)
{
    static const uint8_t bus[3] = {0, NODE_ID, 0};

    (void)ctx;
    memcpy(out, bus, sizeof bus);
}

static const struct dg_store_region regions[] = {DG_CO_STORE_REGIONS(default_bus)};
static const struct dg_store_layout layout = {
    .id = 0x53444F31u,
    .journal_size = DG_CO_JOURNAL_SIZE,
    .region_count = DG_COUNT(regions),
    .regions = regions,
};

static const struct dg_co_device device = {
    .name = "SDO rig",
    .dictionary = {DG_CO_ROWS(rows), limits, hooks},
    .kbaud = kbaud,
    .kbaud_count = DG_COUNT(kbaud),
    .save_ms = 14,
    .strings = strings,
    .device_type = 0x00020196,
    .vendor_id = 0x13,
    .product_code = 0x56682001,
    .revision = 108,
    .layout = &layout,
    .sample = sample,
};

static void capture(void *ctx, const struct dg_can_frame *frame)
{
    struct sdo_rig *self = ctx;

    assert_true(self->count < SDO_RIG_FRAMES_MAX);
    self->frames[self->count++] = *frame;
}

static const struct dg_co_ops ops = {.send = capture};

void sdo_rig_init(struct sdo_rig *self)
{
    memset(self, 0, sizeof *self);
    dg_world_init(&self->world);
    ram_nvm_init(&self->nvm, RAM_NVM_MAX);
    struct dg_co_setup setup = {.device = &device,
                                .world = &self->world,
                                .nvm = ram_nvm_port(&self->nvm),
                                .ops = &ops,
                                .ctx = self,
                                .application = self};

    assert_int_equal(dg_co_format(&device, setup.nvm, 1234567890u), DG_OK);
    assert_int_equal(dg_co_init(&self->node, &setup), DG_OK);
    assert_int_equal(dg_co_power_on(&self->node, self->now), DG_OK);
    assert_int_equal(self->node.id, NODE_ID);
    assert_int_equal(self->node.state, DG_CO_PRE_OPERATIONAL);
    self->count = 0; /* boot-up */
}

void sdo_rig_receive(struct sdo_rig *self, uint16_t id, const char *bytes)
{
    struct dg_can_frame frame = {.id = id};
    unsigned byte;
    int used;

    while (frame.dlc < sizeof frame.data && sscanf(bytes, "%2X%n", &byte, &used) == 1) {
        frame.data[frame.dlc++] = (uint8_t)byte;
        bytes += used;
    }
    (void)dg_co_rx(&self->node, self->now, &frame);
}

void sdo_rig_expect(struct sdo_rig *self, const char *answer)
{
    char text[SDO_RIG_FRAMES_MAX * 8u * 3u * 2u] = "";
    char *at = text;

    for (unsigned i = 0; i < self->count; i++) {
        const struct dg_can_frame *frame = &self->frames[i];

        assert_int_equal(frame->id, 0x580u + NODE_ID);
        assert_int_equal(frame->dlc, 8);
        assert_false(frame->rtr);
        for (unsigned j = 0; j < 8u; j++) {
            at += sprintf(at, "%s%02X", j > 0 ? " " : i > 0 ? " / " : "", frame->data[j]);
        }
    }
    self->count = 0;
    assert_string_equal(text, answer);
}

void sdo_rig_ask(struct sdo_rig *self, const char *request, const char *answer)
{
    sdo_rig_receive(self, 0x600u + NODE_ID, request);
    sdo_rig_expect(self, answer);
}

void sdo_rig_wait(struct sdo_rig *self, dg_ns span)
{
    dg_ns end = self->now + span;
    dg_ns next = dg_co_step(&self->node, self->now);

    while (next <= end) {
        assert_true(next > self->now);
        self->now = next;
        next = dg_co_step(&self->node, self->now);
    }
    self->now = end;
    (void)dg_co_step(&self->node, self->now);
}

void sdo_rig_play(struct sdo_rig *self, const struct sdo_rig_step *steps, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        sdo_rig_wait(self, SDO_RIG_PAUSE);
        sdo_rig_ask(self, steps[i].request, steps[i].answer);
    }
}

static void new_request(struct sdo_rig *self, const struct sdo_rig_step *steps)
{
    (void)steps;
    sdo_rig_ask(self, "40 00 10 00 00 00 00 00", "43 00 10 00 96 01 02 00");
}

static void client_abort(struct sdo_rig *self, const struct sdo_rig_step *steps)
{
    (void)steps;
    sdo_rig_ask(self, "80 00 00 00 00 00 00 08", "");
}

static void timeout(struct sdo_rig *self, const struct sdo_rig_step *steps)
{
    char abort[] = "80 xx xx xx 00 00 04 05";

    /* The multiplexor of the transfer's first request. */
    memcpy(&abort[3], &steps[0].request[3], sizeof "xx xx xx" - 1u);
    sdo_rig_wait(self, TIMEOUT - 1u);
    sdo_rig_expect(self, "");
    sdo_rig_wait(self, 1);
    sdo_rig_expect(self, abort);
}

static void noise(struct sdo_rig *self)
{
    uint32_t malformed = self->node.counters.malformed;

    sdo_rig_wait(self, TIMEOUT - SDO_RIG_PAUSE - 1u);
    sdo_rig_ask(self, "40 00 10 00 00 00 00", "");
    assert_int_equal(self->node.counters.malformed, malformed + 1u);
    sdo_rig_receive(self, 0x600u + NODE_ID + 1u, "40 00 10 00 00 00 00 00");
    sdo_rig_expect(self, "");
}

void sdo_rig_disturb(struct sdo_rig *self, const struct sdo_rig_step *steps, size_t n)
{
    static void (*const ends[])(struct sdo_rig * self, const struct sdo_rig_step *steps) = {
        new_request, client_abort, timeout};

    assert_true(n >= 2);
    for (size_t i = 0; i < DG_COUNT(ends) * (n - 1u); i++) {
        sdo_rig_init(self);
        sdo_rig_play(self, steps, i / DG_COUNT(ends) + 1u);
        ends[i % DG_COUNT(ends)](self, steps);
        /* The transfer is over: nothing more comes of it, and the next one works. */
        sdo_rig_wait(self, 2u * TIMEOUT);
        sdo_rig_expect(self, "");
        sdo_rig_play(self, steps, n);
    }
    sdo_rig_init(self);
    for (size_t i = 0; i < n; i++) {
        sdo_rig_play(self, &steps[i], 1);
        noise(self);
    }
}
