/* SPDX-License-Identifier: MIT */
/* An encoder of a CAN bus: what the plan says about it, its EEPROM, its power. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>

#include "can_bus.h"
#include "drehgeber/bits.h"
#include "figure.h"
#include "settings.h"

/* As delivered (manual, chapter 8). */
#define NODE_ID_DEFAULT 63u
#define NODE_ID_MAX 127u
/* Of the first encoder; the next ones count up. */
#define SERIAL_DEFAULT 1234567890u
#define SERIAL_DIGITS 10u

/* --- the plan --- */

/* A whole decimal number of at most `max_digits` digits. */
static bool take_number(const char *text, size_t max_digits, uint64_t *value)
{
    struct lx_decimal number = {0};
    const size_t n = strspn(text, "0123456789");
    if (n == 0 || n > max_digits || text[n] != '\0' || !lx_decimal_parse(text, n, 0, &number)) {
        return false;
    }
    *value = (uint64_t)number.value;
    return true;
}

static int take_node_id(struct lx_can_node *self, struct lx_error *error)
{
    const char *text = self->station->plan->address;
    uint64_t id = NODE_ID_DEFAULT;
    if (text != NULL && (!take_number(text, 3, &id) || id < 1 || id > NODE_ID_MAX)) {
        return lx_fail(error, "--node %s: a node-ID in 1..%u is right", text, NODE_ID_MAX);
    }
    self->id = (uint8_t)id;
    return 0;
}

/* The plan's node-IDs; what EEPROMs say is not known yet. */
static int check_unique(const struct lx_can_node *self, struct lx_error *error)
{
    const struct lx_can_node *all = self->bus->node;
    for (const struct lx_can_node *other = all; other < self; other++) {
        if (other->id == self->id) {
            return lx_fail(error, "--node %u: %s has this node-ID; another one is right", self->id,
                           other->station->plan->name);
        }
    }
    return 0;
}

static int take_serial(struct lx_can_node *self, struct lx_error *error)
{
    const char *text = self->station->plan->serial;
    uint64_t serial = SERIAL_DEFAULT + (uint64_t)self->station->place;
    if (text != NULL && (!take_number(text, SERIAL_DIGITS, &serial) || serial > UINT32_MAX)) {
        return lx_fail(error, "--serial %s: a number up to %lu is right", text,
                       (unsigned long)UINT32_MAX);
    }
    self->station->control.serial = (uint32_t)serial;
    return 0;
}

/* mt_bits=12 or 16 makes an f3668 the one with that many turns. */
static int set_turns(struct dg_cia406_model *model, const char *value, struct lx_error *error)
{
    const bool wide = strcmp(value, "16") == 0;
    if (model->turns == 1 || (!wide && strcmp(value, "12") != 0)) {
        return lx_fail(error, "--set mt_bits=%s: 12 or 16 is right, with f3668", value);
    }
    model->turns = wide ? 65536u : 4096u;
    model->device = wide ? &dg_cia406_multiturn_32 : &dg_cia406_multiturn;
    return 0;
}

static int take_settings(struct lx_can_node *self, struct lx_error *error)
{
    const struct lx_plan *plan = self->bus->bus.setup.plan;
    const struct lx_plan_settings *list = &self->station->plan->settings;
    struct lx_settings settings;
    lx_settings_init(&settings, NULL);
    settings.wire_keys = "pace";
    if (self->model.turns != 1) {
        lx_settings_name(&settings, "mt_bits");
    }
    for (size_t i = 0; i < list->count; i++) {
        const struct lx_plan_setting *setting = &list->list[i];
        if (strcmp(setting->key, "mt_bits") != 0) {
            if (lx_settings_take(&settings, plan, setting, error) != 0) {
                return -1;
            }
        } else if (set_turns(&self->model, setting->value, error) != 0) {
            return lx_settings_refuse(plan, setting->line, error);
        }
    }
    lx_settings_world(&settings, &self->station->world);
    return 0;
}

int lx_can_node_make(struct lx_can_bus *bus, size_t place, struct lx_error *error)
{
    struct lx_can_node *self = &bus->node[place];
    struct lx_station *station = bus->bus.setup.stations[place];
    const struct lx_plan_encoder *plan = station->plan;
    *self = (struct lx_can_node){
        .bus = bus,
        .station = station,
        .model = *dg_cia406_model_of(plan->model),
        .file = {.fd = -1},
        .index = LX_CAN_DEAF,
    };
    station->control.device = &self->device;
    if (take_node_id(self, error) != 0 || check_unique(self, error) != 0) {
        return lx_settings_refuse(bus->bus.setup.plan, plan->address_line, error);
    }
    if (take_serial(self, error) != 0) {
        return lx_settings_refuse(bus->bus.setup.plan, plan->serial_line, error);
    }
    return take_settings(self, error);
}

/* --- EEPROM and power --- */

/* The delivery state with this node-ID. */
static int deliver(struct lx_can_node *self)
{
    const struct dg_co_device *device = self->model.device;
    struct dg_store store;
    uint8_t bus[3] = {0}; /* bit rate, node-ID, termination */
    if (lx_nvm_memory_init(&self->memory, dg_store_size(device->layout)) != 0) {
        return DG_ERR_SPACE;
    }
    const struct dg_nvm nvm = lx_nvm_memory_port(&self->memory);
    int result = dg_co_format(device, nvm, self->station->control.serial);
    if (result == DG_OK) {
        result = dg_store_mount(&store, device->layout, nvm);
    }
    if (result == DG_OK) {
        result = dg_store_read(&store, DG_CO_REGION_BUS, 0, bus, sizeof bus);
    }
    bus[1] = self->id;
    return result == DG_OK ? dg_store_put(&store, DG_CO_REGION_BUS, 0, bus, sizeof bus) : result;
}

static int refuse_image(const struct lx_can_node *self, struct lx_error *error)
{
    const char *path = self->station->plan->nvm;
    return lx_fail(error,
                   "%s: no image of this kind of encoder; give a file made by drehgeber, or the "
                   "name of a new one",
                   path == NULL ? "EEPROM" : path);
}

/* The serial number that was asked for is the file's. One that is damaged is nobody's. */
static int check_serial(const struct lx_can_node *self, struct dg_store *store,
                        struct lx_error *error)
{
    const struct lx_plan_encoder *plan = self->station->plan;
    uint8_t bytes[4] = {0};
    if (!dg_store_damaged(store, DG_CO_REGION_SERIAL)) {
        (void)dg_store_read(store, DG_CO_REGION_SERIAL, 0, bytes, sizeof bytes);
    }
    const uint32_t serial = dg_load_le32(bytes);
    if (plan->serial == NULL || serial == self->station->control.serial) {
        return 0;
    }
    return lx_fail(error,
                   "%s: belongs to serial number %lu; run that one, or give the name of a new file",
                   plan->nvm, (unsigned long)serial);
}

/* Looked at in a copy: mounting repairs and grows, and a file that is refused must stay as it is.
   The delivery state in memory has done its duty by now. */
static int check_file(struct lx_can_node *self, struct lx_error *error)
{
    const struct dg_store_layout *layout = self->model.device->layout;
    const struct dg_nvm file = lx_nvm_file_port(&self->file);
    struct dg_store store;
    if (file.ops->read(file.ctx, 0, self->memory.bytes, self->memory.size) != DG_OK) {
        return lx_fail(error, "%s: cannot read", self->file.path);
    }
    const int mounted = dg_store_mount(&store, layout, lx_nvm_memory_port(&self->memory));
    if (mounted != DG_OK && mounted != DG_ERR_OLDER) {
        return refuse_image(self, error);
    }
    if (check_serial(self, &store, error) != 0) {
        return -1;
    }
    lx_nvm_file_tell(&self->file, dg_store_address(layout, store.region_count),
                     self->bus->bus.setup.say);
    return 0;
}

/* In memory, or in its file; an EEPROM that does not answer belongs to nobody. */
static int open_file(struct lx_can_node *self, struct lx_error *error)
{
    const char *path = self->station->plan->nvm;
    const struct lx_nvm_image image = {self->memory.bytes, self->memory.size,
                                       "the encoder answers abort 06060000h"};
    self->station->control.nvm = lx_nvm_memory_port(&self->memory);
    if (path == NULL) {
        return 0;
    }
    if (lx_nvm_file_open(&self->file, path, &image, error) != 0) {
        return -1;
    }
    self->station->control.nvm = lx_nvm_file_port(&self->file);
    const bool answers = self->station->world.eeprom_acknowledges;
    return self->file.created || !answers ? 0 : check_file(self, error);
}

/* A file may know a node-ID that was set over the bus. */
static void tell_node_id(const struct lx_can_node *self)
{
    if (self->device.node.mounted && self->device.node.id != self->id) {
        lx_note(self->bus->bus.setup.say, "%s: its node-ID is %u, not %u", self->station->plan->nvm,
                self->device.node.id, self->id);
    }
}

static int open_eeprom(struct lx_can_node *self, void (*settled)(void *ctx, dg_ns now),
                       struct lx_error *error)
{
    struct dg_nvm *nvm = &self->station->control.nvm;
    if (open_file(self, error) != 0) {
        return -1;
    }
    const struct lx_nvm_queue_setup queue = {
        .writer = self->station->plan->nvm == NULL ? NULL : self->bus->bus.setup.writer,
        .below = *nvm,
        .size = self->memory.size,
        .settled = settled,
        .ctx = self,
    };
    self->station->queue = queue.writer == NULL ? NULL : &self->queue;
    return lx_nvm_queue_open(&self->queue, &queue, nvm, error);
}

static int power_on(struct lx_can_node *self, const struct dg_co_ops *ops, dg_ns now,
                    struct lx_error *error)
{
    const struct dg_co_setup device = {
        .device = self->model.device,
        .world = &self->station->world,
        .nvm = self->station->control.nvm,
        .ops = ops,
        .ctx = self,
        .application = &self->device.encoder,
    };
    if (dg_co_init(&self->device.node, &device) != DG_OK ||
        dg_co_power_on(&self->device.node, now) != DG_OK) {
        return refuse_image(self, error);
    }
    return 0;
}

int lx_can_node_open(struct lx_can_node *self, const struct dg_co_ops *ops,
                     void (*settled)(void *ctx, dg_ns now), dg_ns now, struct lx_error *error)
{
    const struct lx_bus_setup *setup = &self->bus->bus.setup;
    const struct lx_plan_encoder *plan = self->station->plan;
    if (dg_cia406_init(&self->device.encoder, &self->model) != DG_OK || deliver(self) != DG_OK) {
        (void)lx_fail(error, "these factory figures make no encoder, or there is no memory");
        return lx_settings_refuse(setup->plan, plan->line, error);
    }
    if (open_eeprom(self, settled, error) != 0 || power_on(self, ops, now, error) != 0) {
        return lx_settings_refuse(setup->plan, plan->nvm_line, error);
    }
    tell_node_id(self);
    return 0;
}

void lx_can_node_close(struct lx_can_node *self)
{
    dg_co_power_off(&self->device.node);
    lx_nvm_queue_close(&self->queue);
    free(self->answers.frames);
    lx_nvm_file_close(&self->file);
    lx_nvm_memory_free(&self->memory);
}
