/* SPDX-License-Identifier: MIT */
/*
 * Layer setting services (CiA 305; C8-C10). Node-ID and bit rate that are
 * configured here come into force at the next reset node, which leaving the configuration state
 * performs, and survive power-off only after "store".
 */
#include <string.h>

#include "co_lss.h"
#include "co_storage.h"

enum {
    WAITING = 1,
    CONFIGURATION = 2,
};

/* Answers and result codes. */
#define SELECTED 0x44u
#define IDENTIFIED 0x4Fu
#define NOT_CONFIGURED 0x50u
#define RESULT_OK 0u
#define RESULT_REFUSED 1u
#define RESULT_MEDIA 2u

#define SELECTIVE_FIRST 0x40u
#define IDENTIFY_FIRST 0x46u
#define INQUIRE_FIRST 0x5Au
#define FASTSCAN_CONFIRM 0x80u
#define IDENTITY_PARTS 4u
#define NO_RATE 0xFFu

static void answer_master(struct dg_co_node *self, uint8_t cs, uint32_t value)
{
    uint8_t data[8] = {cs};

    dg_store_le32(&data[1], value);
    dg_co_send(self, CO_ID_LSS_TX, data, sizeof data);
}

/* Vendor, product, revision, serial number. */
static uint32_t identity(const struct dg_co_node *self, uint8_t part)
{
    const struct dg_co_device *device = self->setup.device;
    const uint32_t parts[IDENTITY_PARTS] = {device->vendor_id, device->product_code,
                                            device->revision, self->serial};
    return parts[part];
}

static bool unconfigured(const struct dg_co_node *self)
{
    return self->id == DG_CO_UNCONFIGURED && self->lss.node_id == DG_CO_UNCONFIGURED;
}

static void switch_global(struct dg_co_node *self, const uint8_t *data)
{
    bool changed = self->lss.changed;

    if (data[1] > 1) {
        return;
    }
    self->lss.configuration = data[1] == 1;
    if (!self->lss.configuration && changed) {
        dg_co_reset(self, true); /* unlike CiA 305 (C10) */
    }
}

static void switch_selective(struct dg_co_node *self, const uint8_t *data)
{
    uint8_t part = (uint8_t)(data[0] - SELECTIVE_FIRST);
    bool match = (part == 0 || self->lss.selective == part) &&
                 dg_load_le32(&data[1]) == identity(self, part);

    self->lss.selective = match ? (uint8_t)(part + 1u) : 0;
    if (self->lss.selective == IDENTITY_PARTS) {
        self->lss.selective = 0;
        self->lss.configuration = true;
        answer_master(self, SELECTED, 0);
    }
}

static void configure_node_id(struct dg_co_node *self, const uint8_t *data)
{
    bool valid = (data[1] >= 1 && data[1] <= 127) || data[1] == DG_CO_UNCONFIGURED;

    if (valid) {
        self->lss.node_id = data[1];
        self->lss.changed = true;
    }
    answer_master(self, data[0], valid ? RESULT_OK : RESULT_REFUSED);
}

/* The device's number for a bit rate of CiA 305's table 0; NO_RATE: it has none, or none is meant.
 */
static uint8_t rate_number_of(const struct dg_co_device *device, uint8_t index)
{
    static const uint16_t kbaud[] = {1000, 800, 500, 250, 125, 0, 50, 20, 10};
    uint16_t wanted = index < DG_COUNT(kbaud) ? kbaud[index] : 0;
    uint8_t number = 0;

    while (wanted != 0 && number < device->kbaud_count) {
        if (device->kbaud[number] == wanted) {
            return number;
        }
        number++;
    }
    return NO_RATE;
}

static void configure_bit_timing(struct dg_co_node *self, const uint8_t *data)
{
    uint8_t number = data[1] == 0 ? rate_number_of(self->setup.device, data[2]) : NO_RATE;
    bool valid = number != NO_RATE;

    if (valid) {
        self->lss.bit_rate = number;
        self->lss.changed = true;
    }
    answer_master(self, data[0], valid ? RESULT_OK : RESULT_REFUSED);
}

/* Silent for one delay, then the new rate, then silent for one more. */
static void activate_bit_timing(struct dg_co_node *self, const uint8_t *data)
{
    dg_ns delay = DG_MS(dg_load_le16(&data[1]));

    self->lss.switch_at = dg_co_after(self->now, delay);
    self->lss.silent_until = dg_co_after(self->lss.switch_at, delay);
}

static void store(struct dg_co_node *self, const uint8_t *data)
{
    enum dg_co_abort abort = dg_co_save_bus(self, self->lss.bit_rate, self->lss.node_id);

    answer_master(self, data[0], abort == DG_CO_OK ? RESULT_OK : RESULT_MEDIA);
}

/* Vendor, product, then lowest and highest revision and serial number. */
static void identify(struct dg_co_node *self, const uint8_t *data)
{
    static const uint8_t parts[] = {0, 1, 2, 2, 3, 3};
    uint8_t step = (uint8_t)(data[0] - IDENTIFY_FIRST);
    uint32_t wanted = dg_load_le32(&data[1]);
    uint32_t mine = identity(self, parts[step]);
    bool exact = step < 2;
    bool lowest = step == 2 || step == 4;
    bool match = exact ? wanted == mine : lowest ? mine >= wanted : mine <= wanted;

    match = match && (step == 0 || self->lss.identify == step);
    self->lss.identify = match ? (uint8_t)(step + 1u) : 0;
    if (self->lss.identify == sizeof parts) {
        self->lss.identify = 0;
        answer_master(self, IDENTIFIED, 0);
    }
}

static void identify_non_configured(struct dg_co_node *self, const uint8_t *data)
{
    (void)data;
    if (unconfigured(self)) {
        answer_master(self, NOT_CONFIGURED, 0);
    }
}

/* IDNumber, BitCheck, LSSsub, LSSnext: the master narrows down one part of the identity bit by
 * bit, then goes to the next one; the last one to have matched all is in configuration. */
static void fastscan(struct dg_co_node *self, const uint8_t *data)
{
    uint32_t number = dg_load_le32(&data[1]);
    uint8_t bit_check = data[5];
    uint8_t sub = data[6];
    uint8_t next = data[7];

    if (!unconfigured(self)) {
        return;
    }
    if (bit_check == FASTSCAN_CONFIRM) {
        self->lss.fastscan = 0;
        answer_master(self, IDENTIFIED, 0);
        return;
    }
    if (bit_check > 31 || sub >= IDENTITY_PARTS || next >= IDENTITY_PARTS ||
        sub != self->lss.fastscan) {
        return;
    }
    if (((number ^ identity(self, sub)) & (0xFFFFFFFFu << bit_check)) != 0) {
        return;
    }
    self->lss.fastscan = next;
    self->lss.configuration = bit_check == 0 && next < sub;
    answer_master(self, IDENTIFIED, 0);
}

static void inquire(struct dg_co_node *self, const uint8_t *data)
{
    answer_master(self, data[0], identity(self, (uint8_t)(data[0] - INQUIRE_FIRST)));
}

static void inquire_node_id(struct dg_co_node *self, const uint8_t *data)
{
    answer_master(self, data[0], self->id);
}

/* clang-format off */
static const struct {
    uint8_t first; /* command specifiers first..last */
    uint8_t last;
    uint8_t states;
    void (*handler)(struct dg_co_node *self, const uint8_t *data);
} services[] = {
    {0x04, 0x04, WAITING | CONFIGURATION, switch_global},
    {0x11, 0x11, CONFIGURATION,           configure_node_id},
    {0x13, 0x13, CONFIGURATION,           configure_bit_timing},
    {0x15, 0x15, CONFIGURATION,           activate_bit_timing},
    {0x17, 0x17, CONFIGURATION,           store},
    {0x40, 0x43, WAITING,                 switch_selective},
    {0x46, 0x4B, WAITING | CONFIGURATION, identify},
    {0x4C, 0x4C, WAITING | CONFIGURATION, identify_non_configured},
    {0x51, 0x51, WAITING,                 fastscan},
    {0x5A, 0x5D, CONFIGURATION,           inquire},
    {0x5E, 0x5E, CONFIGURATION,           inquire_node_id},
};
/* clang-format on */

void dg_co_lss_rx(struct dg_co_node *self, const struct dg_can_frame *frame)
{
    uint8_t state = self->lss.configuration ? CONFIGURATION : WAITING;
    uint8_t cs = frame->data[0];

    if (frame->dlc != 8) {
        self->counters.malformed++;
        return;
    }
    for (uint8_t i = 0; i < DG_COUNT(services); i++) {
        if (cs >= services[i].first && cs <= services[i].last) {
            if ((services[i].states & state) != 0) {
                services[i].handler(self, frame->data);
            }
            return;
        }
    }
}

void dg_co_lss_start(struct dg_co_node *self)
{
    self->lss.configuration = false;
    self->lss.changed = false;
    self->lss.selective = 0;
    self->lss.identify = 0;
    self->lss.fastscan = 0;
    self->lss.switch_at = DG_NEVER;
}

dg_ns dg_co_lss_step(struct dg_co_node *self)
{
    if (self->lss.switch_at <= self->now) {
        self->lss.switch_at = DG_NEVER;
        dg_co_use_bit_rate(self);
    }
    return self->lss.switch_at;
}
