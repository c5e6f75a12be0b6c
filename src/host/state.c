/* SPDX-License-Identifier: MIT */
/*
 * States: the memory of a handle as it is, without its pointers, behind a header that says whose it
 * is. What a pointer said is said by the handle that the state is restored into.
 *
 *   | header | struct dg_host | queues | settings | device | EEPROM |
 */
#include "host_private.h"

#include <string.h>

#include "drehgeber/crc.h"
#include "drehgeber/version.h"

#define MODEL_MAX 32u
#define VERSION_MAX 24u

static const char magic[8] = {'D', 'G', 'S', 'T', 'A', 'T', 'E', '\1'};
static const char version[] = DG_VERSION;
_Static_assert(sizeof version <= VERSION_MAX, "the version has room");

/* The builds that understand each other: same layouts, same byte order. */
struct header {
    char magic[8];
    char model[MODEL_MAX];
    char version[VERSION_MAX];
    uint32_t order;   /* of the bytes in a number */
    uint32_t pointer; /* bytes of one */
    uint32_t handle;  /* bytes of each part ... */
    uint32_t queues;
    uint32_t settings; /* ... */
    uint32_t device;
    uint32_t memory;
    uint32_t own_memory; /* 1: the EEPROM is in here */
    uint32_t sum;        /* of all behind the header */
};
#define ORDER UINT32_C(0x01020304)

static struct host_parts parts_of(const struct dg_host *self)
{
    const uint8_t *base = (const uint8_t *)self;
    const size_t memory = (size_t)(self->refs.memory - base);

    return (struct host_parts){
        .settings = (size_t)((const uint8_t *)self->line.settings - base),
        .device = (size_t)((const uint8_t *)self->line.device - base),
        .memory = memory,
        .end = memory + self->memory_size,
    };
}

static size_t size_in_all(const struct dg_host *self)
{
    return parts_of(self).end;
}

static struct header host_header_of(const struct dg_host *self)
{
    const struct host_parts parts = parts_of(self);
    struct header header = {
        .order = ORDER,
        .pointer = sizeof(void *),
        .handle = sizeof(struct dg_host),
        .queues = (uint32_t)(parts.settings - HOST_QUEUES_AT),
        .settings = (uint32_t)(parts.device - parts.settings),
        .device = (uint32_t)(parts.memory - parts.device),
        .memory = (uint32_t)(parts.end - parts.memory),
        .own_memory = self->refs.nvm.ops == NULL ? 1u : 0u,
    };

    memcpy(header.magic, magic, sizeof magic);
    memcpy(header.version, version, sizeof version);
    for (size_t i = 0; i < MODEL_MAX - 1u && self->refs.device->name[i] != '\0'; i++) {
        header.model[i] = self->refs.device->name[i];
    }
    return header;
}

size_t dg_host_state_size(const struct dg_host *self)
{
    return sizeof(struct header) + size_in_all(self);
}

/* ------------------------------------------------------------ pointers */

/* What the handle points to: its own parts, its shaft, and what the host has handed over. */
static void drop_pointers(struct dg_host *self)
{
    self->refs = (struct host_refs){0};
    self->line.on_bus = false;
    self->line.settings = NULL;
    self->line.device = NULL;
    self->world.angle = NULL;
    self->world.angle_ctx = NULL;
    self->world.calm = NULL;
}

static void take_pointers(struct dg_host *self, const struct dg_host *from)
{
    self->refs = from->refs;
    self->line.on_bus = from->line.on_bus;
    self->line.settings = from->line.settings;
    self->line.device = from->line.device;
    self->world.angle = from->world.angle;
    self->world.angle_ctx = from->world.angle_ctx;
    self->world.calm = from->world.calm;
}

/* Between these two the parts have no pointers and nothing else may be done with them. */
static void detach_parts(struct dg_host *self)
{
    if (self->made) {
        self->refs.device->stack->attach(self->line.device, NULL);
    }
    if (self->refs.wire->arrange != NULL) {
        self->refs.wire->arrange(self->line.settings, NULL);
    }
}

static void attach_parts(struct dg_host *self)
{
    const struct dg_stack_setup setup = dg_host_setup(self);

    if (self->made) {
        self->refs.device->stack->attach(self->line.device, &setup);
    }
}

/* ------------------------------------------------------------ saving */

int dg_host_save(struct dg_host *self, void *to, size_t n)
{
    struct header header = host_header_of(self);
    const struct dg_host kept = *self;
    const size_t size = size_in_all(self);
    uint8_t *body = (uint8_t *)to + sizeof header;

    if (n < dg_host_state_size(self)) {
        return DG_HOST_ERR_SPACE;
    }
    detach_parts(self);
    drop_pointers(self);
    memcpy(body, self, size);
    take_pointers(self, &kept);
    attach_parts(self);
    header.sum = dg_crc32(0, body, size);
    memcpy(to, &header, sizeof header);
    return DG_HOST_OK;
}

/* ------------------------------------------------------------ checking
 *
 * The sum tells a damaged state. One that somebody has made has a right one: every number that the
 * handle or its device goes by is looked at before one of them is there.
 */

static bool are_members_in_range(const struct dg_stack_range *row, const uint8_t *base)
{
    bool good = true;

    for (uint8_t i = 0; i < row->count; i++) {
        const uint8_t *at = base + row->offset + (size_t)i * row->size;
        uint32_t value = at[0];
        uint16_t half;
        if (row->size == sizeof value) {
            memcpy(&value, at, sizeof value);
        } else if (row->size == sizeof half) {
            memcpy(&half, at, sizeof half);
            value = half;
        }
        good = good && value >= row->min && value <= row->max;
    }
    return good;
}

static bool all_in_range(const struct dg_stack_range *rows, size_t count, const uint8_t *base)
{
    bool good = true;

    for (size_t i = 0; i < count; i++) {
        good = good && are_members_in_range(&rows[i], base);
    }
    return good;
}

static bool all_hold(const struct dg_keys *keys, const void *base)
{
    bool good = true;

    for (size_t i = 0; i < keys->count; i++) {
        good = good && dg_key_holds(&keys->rows[i], base);
    }
    return good;
}

static struct dg_host_event event_at(const uint8_t *queue, uint32_t place)
{
    struct dg_host_event event;

    memcpy(&event, queue + offsetof(struct host_queue, event) + place * sizeof event, sizeof event);
    return event;
}

/* What waits for the device was sent by somebody. `part` of the first one has been taken. */
static bool fits_device(const uint8_t *queue, uint32_t part, const struct dg_host_wire *wire)
{
    uint32_t first;
    uint32_t count;
    bool good = true;

    memcpy(&first, queue + offsetof(struct host_queue, first), sizeof first);
    memcpy(&count, queue + offsetof(struct host_queue, count), sizeof count);
    for (uint32_t i = 0; i < count; i++) {
        const struct dg_host_event event = event_at(queue, (first + i) % DG_HOST_QUEUE);
        good = good && dg_host_check_event(wire, &event) == DG_HOST_OK;
        good = good && (i > 0 || part <= 2u * event.length);
    }
    return good && (count > 0 || part == 0);
}

/* What waits for the host has its length. */
static bool fits_host(const uint8_t *queue)
{
    bool good = true;

    for (uint32_t i = 0; i < DG_HOST_QUEUE; i++) {
        const struct dg_host_event event = event_at(queue, i);
        good = good && event.length <= sizeof event.data;
    }
    return good;
}

/* @param queues those of the state; the handle on a bus has none */
static bool queues_fit(const struct dg_host *self, const uint8_t *queues, uint32_t part)
{
    static const struct dg_stack_range rows[] = {
        DG_STACK_RANGE(host_queues, in.first, 0, DG_HOST_QUEUE - 1u),
        DG_STACK_RANGE(host_queues, in.count, 0, DG_HOST_QUEUE),
        DG_STACK_RANGE(host_queues, out.first, 0, DG_HOST_QUEUE - 1u),
        DG_STACK_RANGE(host_queues, out.count, 0, DG_HOST_QUEUE),
    };

    if (self->refs.queues == NULL) {
        return part == 0;
    }
    return all_in_range(rows, DG_COUNT(rows), queues) &&
           fits_device(queues + offsetof(struct host_queues, in), part, self->refs.wire) &&
           fits_host(queues + offsetof(struct host_queues, out));
}

static bool handle_fits(const struct dg_host *self, const uint8_t *body)
{
    static const struct dg_stack_range rows[] = {
        DG_STACK_BOOL(dg_host, line.level),
        DG_STACK_BOOL(dg_host, line.behind),
        DG_STACK_BOOL(dg_host, line.chained),
        DG_STACK_BOOL(dg_host, made),
        DG_STACK_BOOL(dg_host, loaded),
        DG_STACK_BOOL(dg_host, untold),
        DG_STACK_RANGE(dg_host, controller, 0, DG_HOST_BUS_OFF),
    };
    struct dg_host state;

    if (!all_in_range(rows, DG_COUNT(rows), body)) {
        return false;
    }
    memcpy(&state, body, sizeof state);
    return state.memory_size == self->memory_size && state.line.now != DG_NEVER &&
           all_hold(&dg_world_keys, &state.world) &&
           queues_fit(self, body + dg_host_round(sizeof state), state.line.part);
}

static bool is_handle_sound(const struct dg_host *self, const uint8_t *body)
{
    const struct dg_stack_check *check = self->refs.wire->state;
    const struct host_parts parts = parts_of(self);
    const uint8_t *settings = body + parts.settings;
    const uint8_t *device = body + parts.device;

    if (!handle_fits(self, body) || !all_hold(self->refs.wire->keys, settings)) {
        return false;
    }
    /* One that was never on is made of its settings. */
    return body[offsetof(struct dg_host, made)] == 0 ||
           (all_in_range(check->ranges, check->count, device) &&
            check->fits(self->line.settings, settings, device));
}

int dg_host_restore(struct dg_host *self, const void *from, size_t n)
{
    const uint8_t *body = (const uint8_t *)from + sizeof(struct header);
    const struct header mine = host_header_of(self);
    const size_t size = size_in_all(self);
    struct header header;
    struct dg_host state;

    if (n < dg_host_state_size(self)) {
        return DG_HOST_ERR_SPACE;
    }
    memcpy(&header, from, sizeof header);
    if (memcmp(&header, &mine, offsetof(struct header, sum)) != 0) {
        return DG_HOST_ERR_OTHER;
    }
    if (header.sum != dg_crc32(0, body, size) || !is_handle_sound(self, body)) {
        return DG_HOST_ERR_DAMAGED;
    }
    memcpy(&state, body, sizeof state);
    take_pointers(&state, self);
    memcpy(self, body, size);
    *self = state;
    attach_parts(self);
    return DG_HOST_OK;
}
