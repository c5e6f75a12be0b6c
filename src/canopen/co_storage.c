/* SPDX-License-Identifier: MIT */
/*
 * Parameters that survive power-off: 1010h, 1011h, bus parameters and LSS (C7, C8).
 *
 * Region 'saved' tells whether the parameter regions hold anything; 1011h only clears it. A region
 * holds the values of its rows in the dictionary's order, least significant byte first. Where a row
 * has gone (1019h, 1800h:6) a byte stays free, so that older memories fit.
 */
#include <string.h>

#include "co_od.h"
#include "co_pdo.h"
#include "co_storage.h"

#define SAVE 0x65766173u
#define LOAD 0x64616F6Cu

/* A stored COB-ID that follows the node-ID has bit 29, which none of this node's COB-IDs has, and
 * none of the reserved bits. */
#define FOLLOWS CO_COB_EXTENDED
#define RESERVED 0x1FFFF800u

/* Rows of one region while they are packed or unpacked. */
struct pack {
    uint8_t region;
    uint8_t at;
    uint16_t first;
    uint16_t last;
    uint8_t node_id;                          /* the memory's own */
    bool valid;                               /* all values are inside their limits */
    uint8_t bytes[DG_STORE_CHECKED_MAX + 3u]; /* room for a whole 32 bits at the last one */
};

void dg_co_default_saved(const void *ctx, uint8_t *out)
{
    (void)ctx;
    out[0] = 0;
}

void dg_co_default_serial(const void *ctx, uint8_t *out)
{
    const uint32_t *serial = ctx;

    dg_store_le32(out, *serial);
}

int dg_co_format(const struct dg_co_device *device, struct dg_nvm nvm, uint32_t serial)
{
    return dg_store_format(device->layout, nvm, &serial);
}

static bool accessible(const struct dg_co_node *self)
{
    return self->mounted && self->setup.world->eeprom_acknowledges;
}

/* A region that is in order; `to` keeps its content otherwise. */
static bool load_region(struct dg_co_node *self, uint8_t region, uint8_t *to)
{
    uint16_t size = self->setup.device->layout->regions[region].size;

    return accessible(self) && !dg_store_damaged(&self->store, region) &&
           dg_store_read(&self->store, region, 0, to, size) == DG_OK;
}

/* Bit rate, node-ID or none yet, termination. */
static bool bus_valid(const struct dg_co_node *self, const uint8_t *bus)
{
    bool node_id = (bus[1] >= 1 && bus[1] <= 127) || bus[1] == DG_CO_UNCONFIGURED;

    return dg_co_kbaud(self->setup.device, bus[0]) != 0 && node_id && bus[2] <= 1;
}

/* As delivered. */
static void load_default_bus(const struct dg_co_node *self, uint8_t *bus)
{
    self->setup.device->layout->regions[DG_CO_REGION_BUS].defaults(&self->serial, bus);
}

int dg_co_mount(struct dg_store *self, const struct dg_co_device *device, struct dg_nvm nvm)
{
    uint8_t bytes[4] = {0};
    int result = dg_store_mount(self, device->layout, nvm);

    if (result == DG_ERR_OLDER) {
        (void)dg_store_read(self, DG_CO_REGION_SERIAL, 0, bytes, sizeof bytes);
        const uint32_t serial = dg_load_le32(bytes);
        result = dg_store_grow(self, &serial);
    }
    return result;
}

int dg_co_burn_node_id(const struct dg_co_device *device, struct dg_nvm nvm, uint32_t id)
{
    struct dg_store store;
    uint8_t bus[3];

    if (id < 1 || id > 127) {
        return DG_ERR_ARGUMENT;
    }
    int result = dg_co_mount(&store, device, nvm);
    if (result == DG_OK) {
        result = dg_store_read(&store, DG_CO_REGION_BUS, 0, bus, sizeof bus);
    }
    bus[1] = (uint8_t)id;
    return result == DG_OK ? dg_store_put(&store, DG_CO_REGION_BUS, 0, bus, sizeof bus) : result;
}

/* `bus` are the bus parameters, or their defaults. */
static int mount_store(struct dg_co_node *self, uint8_t *bus)
{
    int result = DG_ERR_IO;

    load_default_bus(self, bus);
    if (self->setup.world->eeprom_acknowledges) {
        result = dg_co_mount(&self->store, self->setup.device, self->setup.nvm);
    }
    self->mounted = result == DG_OK;
    if (load_region(self, DG_CO_REGION_BUS, bus) && !bus_valid(self, bus)) {
        self->store.damaged |= 1u << DG_CO_REGION_BUS; /* as if its sum had failed */
        load_default_bus(self, bus);
    }
    return result;
}

int dg_co_mount_node(struct dg_co_node *self)
{
    uint8_t bus[3];
    uint8_t serial[4] = {0};
    int result = mount_store(self, bus);

    (void)load_region(self, DG_CO_REGION_SERIAL, serial);
    self->lss.bit_rate = bus[0];
    self->lss.node_id = bus[1];
    self->termination = bus[2];
    self->serial = dg_load_le32(serial);
    return result;
}

void dg_co_remount(struct dg_co_node *self)
{
    uint8_t bus[3];

    (void)mount_store(self, bus);
}

/* The node-ID that the memory holds, whatever is in force. */
static uint8_t stored_node_id(struct dg_co_node *self)
{
    uint8_t bus[3];

    load_default_bus(self, bus);
    (void)load_region(self, DG_CO_REGION_BUS, bus);
    return bus[1];
}

/* ------------------------------------------------------------ COB-IDs (C33)
 *
 * What has its default in the 11 bits of the CAN-ID is stored so that it follows the node-ID; bits
 * 30 and 31 are stored as they are. Earlier releases stored all of them absolute: there the default
 * of the memory's own node-ID is taken for one that follows.
 */

static bool is_default(uint32_t cob_id, uint32_t initial)
{
    return ((cob_id ^ initial) & CO_COB_CAN_ID) == 0;
}

static uint32_t mark_default(uint32_t cob_id, uint32_t initial)
{
    return is_default(cob_id, initial) ? cob_id | FOLLOWS : cob_id;
}

/* `before`: the default with the node-ID the memory holds; `initial`: with the one in force. */
static uint32_t resolve_mark(uint32_t stored, uint32_t before, uint32_t initial)
{
    if ((stored & RESERVED) != 0 || ((stored & FOLLOWS) == 0 && !is_default(stored, before))) {
        return stored;
    }
    return (stored & (CO_COB_INVALID | CO_COB_BIT30)) | initial;
}

/* Parameters of a memory of an earlier release, about to have another node-ID: the COB-ID stands
 * first in its region. */
static void mark_region(struct dg_co_node *self, uint8_t n, uint8_t node_id)
{
    const uint8_t region = (uint8_t)(DG_CO_REGION_TPDO1 + n);
    const uint16_t size = self->setup.device->layout->regions[region].size;
    uint8_t bytes[DG_STORE_CHECKED_MAX];

    if (!load_region(self, region, bytes)) {
        return;
    }
    uint32_t stored = dg_load_le32(bytes);
    uint32_t marked = mark_default(stored, co_predefined(n, node_id));
    if (marked != stored && (stored & RESERVED) == 0) {
        dg_store_le32(bytes, marked);
        (void)dg_store_stage(&self->store, region, 0, bytes, size);
    }
}

/* ------------------------------------------------------------ rows */

/* Visit what a region holds, in the dictionary's order. */
static void each_kept(struct dg_co_node *self, struct pack *pack,
                      void (*visit)(struct dg_co_node *self, const struct dg_co_object *object,
                                    struct pack *pack))
{
    struct dg_co_object object = dg_co_first();

    pack->at = 0;
    do {
        if (!co_is(&object, DG_CO_SAVE) || dg_co_region_of(&object) != pack->region) {
            continue;
        }
        if (co_is(&object, DG_CO_GAP)) {
            pack->bytes[pack->at++] = 0;
        }
        visit(self, &object, pack);
        pack->at = (uint8_t)(pack->at + co_size(&object));
    } while (dg_co_next(self->setup.device, &object));
}

static void unpack_row(struct dg_co_node *self, const struct dg_co_object *object,
                       struct pack *pack)
{
    uint32_t value = dg_co_extend(object, dg_load_le32(&pack->bytes[pack->at]));

    if (object->index < pack->first || object->index > pack->last) {
        return;
    }
    if (co_is(object, DG_CO_ID)) {
        const uint32_t initial = dg_co_default(self->setup.device, object);
        value = resolve_mark(value, initial + pack->node_id, initial + self->id);
    }
    if (dg_co_in_range(object, value)) {
        self->value[object->slot] = value;
    } else {
        pack->valid = false;
    }
}

/* What a store has too much is overwritten by the next. */
static void pack_row(struct dg_co_node *self, const struct dg_co_object *object, struct pack *pack)
{
    uint32_t value = self->value[object->slot];

    if (co_is(object, DG_CO_ID)) {
        value = mark_default(value, dg_co_initial(self, object));
    }
    dg_store_le32(&pack->bytes[pack->at], value);
}

static void set_defaults(struct dg_co_node *self, uint16_t first, uint16_t last)
{
    struct dg_co_object object = dg_co_first();

    do {
        if (co_is(&object, DG_CO_SLOT) && object.index >= first && object.index <= last) {
            self->value[object.slot] = dg_co_initial(self, &object);
        }
    } while (dg_co_next(self->setup.device, &object));
}

/* Regions that 1010h writes: not the bus parameters, the mark, the serial number, nor what a device
 * keeps by itself. */
static bool is_parameters(uint8_t region)
{
    return region >= DG_CO_REGION_COMMUNICATION && region <= DG_CO_REGION_APPLICATION &&
           region != DG_CO_REGION_SERIAL;
}

bool dg_co_load(struct dg_co_node *self, uint16_t first, uint16_t last)
{
    struct pack pack = {.first = first, .last = last, .valid = true};
    uint32_t termination = last < 0x2000 ? self->value[DG_CO_SLOT_TERMINATION] : self->termination;
    uint8_t saved = 0;
    bool loaded = load_region(self, DG_CO_REGION_SAVED, &saved);

    set_defaults(self, first, last);
    self->value[DG_CO_SLOT_BIT_RATE] = self->bit_rate;
    self->value[DG_CO_SLOT_NODE_ID] = self->id;
    self->value[DG_CO_SLOT_TERMINATION] = termination;
    if (saved != 1) {
        return loaded;
    }
    pack.node_id = stored_node_id(self);
    for (uint8_t i = 0; i < self->setup.device->layout->region_count; i++) {
        pack.region = i;
        if (!is_parameters(i)) {
            continue;
        }
        if (load_region(self, i, pack.bytes)) {
            each_kept(self, &pack, unpack_row);
        } else {
            loaded = false;
        }
    }
    return loaded && pack.valid;
}

void dg_co_report_memory(struct dg_co_node *self, bool loaded)
{
    static const uint8_t none[5];

    const uint32_t mine = (2u << DG_CO_REGION_APPLICATION) - 1u;
    if (!loaded || (self->store.damaged & mine) != 0) {
        dg_co_raise(self, DG_CO_CAUSE_MEMORY, none);
    }
}

/* The wire's view of a commit. */
static enum dg_co_abort committed(struct dg_co_node *self)
{
    return dg_store_commit(&self->store) == DG_OK ? DG_CO_OK : DG_CO_HARDWARE;
}

enum dg_co_abort dg_co_save_bus(struct dg_co_node *self, uint8_t bit_rate, uint8_t node_id)
{
    const uint8_t bus[3] = {bit_rate, node_id, self->termination};

    if (!accessible(self)) {
        return DG_CO_HARDWARE;
    }
    uint8_t before = stored_node_id(self);
    dg_store_begin(&self->store);
    (void)dg_store_stage(&self->store, DG_CO_REGION_BUS, 0, bus, sizeof bus);
    for (uint8_t n = 0; n < DG_CO_TPDOS && before != node_id; n++) {
        mark_region(self, n, before);
    }
    return committed(self);
}

/* "save" is answered when the device's memory would have taken it. */
static void answer_later(struct dg_co_node *self)
{
    self->sdo.state = DG_CO_SDO_DELAYED;
    self->sdo.deadline = dg_co_after(self->now, DG_MS(self->setup.device->save_ms));
}

static enum dg_co_abort save_parameters(struct dg_co_node *self)
{
    static const uint8_t saved[1] = {1};
    struct pack pack = {0};

    dg_store_begin(&self->store);
    (void)dg_store_stage(&self->store, DG_CO_REGION_SAVED, 0, saved, sizeof saved);
    for (uint8_t i = 0; i < self->setup.device->layout->region_count; i++) {
        if (!is_parameters(i)) {
            continue;
        }
        pack.region = i;
        each_kept(self, &pack, pack_row);
        if (pack.at > 0) {
            (void)dg_store_stage(&self->store, i, 0, pack.bytes, pack.at);
        }
    }
    return committed(self);
}

/* Common to 1010h:1, 1011h:1 and the bus parameters: reading says "on command" (1), writing wants a
 * signature. */
static enum dg_co_abort signature(struct dg_co_node *self, enum dg_co_op op, uint32_t *value,
                                  uint32_t wanted)
{
    if (op == DG_CO_READ) {
        *value = 1;
        return DG_CO_OK;
    }
    if (*value != wanted) {
        return DG_CO_STORE;
    }
    return accessible(self) ? DG_CO_OK : DG_CO_HARDWARE;
}

enum dg_co_abort dg_co_hook_store(struct dg_co_node *self, const struct dg_co_object *object,
                                  enum dg_co_op op, uint32_t *value)
{
    enum dg_co_abort abort = signature(self, op, value, SAVE);

    (void)object;
    if (op != DG_CO_WRITE || abort != DG_CO_OK) {
        return abort;
    }
    abort = save_parameters(self);
    if (abort == DG_CO_OK) {
        answer_later(self);
    }
    return abort;
}

enum dg_co_abort dg_co_hook_restore(struct dg_co_node *self, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    static const uint8_t saved[1] = {0};
    enum dg_co_abort abort = signature(self, op, value, LOAD);

    (void)object;
    if (op != DG_CO_WRITE || abort != DG_CO_OK) {
        return abort;
    }
    dg_store_begin(&self->store);
    (void)dg_store_stage(&self->store, DG_CO_REGION_SAVED, 0, saved, sizeof saved);
    return committed(self);
}

enum dg_co_abort dg_co_hook_save_bus(struct dg_co_node *self, const struct dg_co_object *object,
                                     enum dg_co_op op, uint32_t *value)
{
    uint8_t bit_rate = (uint8_t)self->value[DG_CO_SLOT_BIT_RATE];
    uint8_t node_id = (uint8_t)self->value[DG_CO_SLOT_NODE_ID];
    enum dg_co_abort abort = signature(self, op, value, SAVE);

    (void)object;
    if (op != DG_CO_WRITE || abort != DG_CO_OK) {
        return abort;
    }
    uint8_t before = self->termination;
    self->termination = (uint8_t)self->value[DG_CO_SLOT_TERMINATION];
    abort = dg_co_save_bus(self, bit_rate, node_id);
    if (abort == DG_CO_OK) {
        self->lss.bit_rate = bit_rate; /* in force after the next reset node (C8) */
        self->lss.node_id = node_id;
        answer_later(self);
    } else {
        self->termination = before;
    }
    return abort;
}
