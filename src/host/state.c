/* SPDX-License-Identifier: MIT */
/*
 * States: the memory of a handle as it is, without its pointers, behind a header that says whose it
 * is. What a pointer said is said by the handle that the state is restored into.
 *
 *   | header | struct dg_host | settings | device | EEPROM |
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
    uint32_t order;    /* of the bytes in a number */
    uint32_t pointer;  /* bytes of one */
    uint32_t handle;   /* bytes of each part ... */
    uint32_t settings; /* ... */
    uint32_t device;
    uint32_t memory;
    uint32_t own_memory; /* 1: the EEPROM is in here */
    uint32_t sum;        /* of all behind the header */
};
#define ORDER UINT32_C(0x01020304)

static struct header header_of(const struct dg_host *self)
{
    const struct host_parts parts = dg_host_parts_of(self->device, self->wire);
    struct header header = {
        .order = ORDER,
        .pointer = sizeof(void *),
        .handle = sizeof(struct dg_host),
        .settings = (uint32_t)parts.settings,
        .device = (uint32_t)parts.device,
        .memory = (uint32_t)parts.memory,
        .own_memory = self->nvm.ops == NULL ? 1u : 0u,
    };

    memcpy(header.magic, magic, sizeof magic);
    memcpy(header.version, version, sizeof version);
    for (size_t i = 0; i < MODEL_MAX - 1u && self->device->name[i] != '\0'; i++) {
        header.model[i] = self->device->name[i];
    }
    return header;
}

static size_t body_size(const struct dg_host *self)
{
    return dg_host_size(self->device, self->wire);
}

size_t dg_host_state_size(const struct dg_host *self)
{
    return sizeof(struct header) + body_size(self);
}

/* ------------------------------------------------------------ pointers */

/* What the handle points to: its own parts, and what the host has handed over. */
static void drop_pointers(struct dg_host *self)
{
    self->line.settings = NULL;
    self->line.device = NULL;
    self->device = NULL;
    self->wire = NULL;
    self->shaft = NULL;
    self->angle_of = NULL;
    self->heard = NULL;
    self->heard_ctx = NULL;
    self->faults = NULL;
    self->faults_ctx = NULL;
    self->nvm = (struct dg_nvm){0};
    self->memory = NULL;
    self->world.angle = NULL;
    self->world.angle_ctx = NULL;
}

static void take_pointers(struct dg_host *self, const struct dg_host *from)
{
    self->line.settings = from->line.settings;
    self->line.device = from->line.device;
    self->device = from->device;
    self->wire = from->wire;
    self->shaft = from->shaft;
    self->angle_of = from->angle_of;
    self->heard = from->heard;
    self->heard_ctx = from->heard_ctx;
    self->faults = from->faults;
    self->faults_ctx = from->faults_ctx;
    self->nvm = from->nvm;
    self->memory = from->memory;
    self->world.angle = dg_host_sense_angle;
    self->world.angle_ctx = self;
}

/* Between these two the parts have no pointers and nothing else may be done with them. */
static void detach(struct dg_host *self)
{
    if (self->made) {
        self->device->stack->attach(self->line.device, NULL);
    }
    if (self->wire->arrange != NULL) {
        self->wire->arrange(self->line.settings, NULL);
    }
}

static void attach(struct dg_host *self)
{
    const struct dg_stack_setup setup = dg_host_setup(self);

    if (self->made) {
        self->device->stack->attach(self->line.device, &setup);
    }
}

/* ------------------------------------------------------------ saving */

int dg_host_save(struct dg_host *self, void *to, size_t n)
{
    struct header header = header_of(self);
    const struct dg_host kept = *self;
    const size_t size = body_size(self);
    uint8_t *body = (uint8_t *)to + sizeof header;

    if (n < dg_host_state_size(self)) {
        return DG_HOST_ERR_SPACE;
    }
    detach(self);
    drop_pointers(self);
    memcpy(body, self, size);
    take_pointers(self, &kept);
    attach(self);
    header.sum = dg_crc32(0, body, size);
    memcpy(to, &header, sizeof header);
    return DG_HOST_OK;
}

/* ------------------------------------------------------------ checking
 *
 * The sum tells a damaged state. One that somebody has made has a right one: every number that the
 * handle or its device goes by is looked at before one of them is there.
 */

static bool in_range(const struct dg_stack_range *row, const uint8_t *base)
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
        good = good && in_range(&rows[i], base);
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

static int check_event(const struct dg_host_wire *wire, const struct dg_host_event *event)
{
    if (event->length > sizeof event->data) {
        return DG_HOST_ERR_ARGUMENT;
    }
    return wire->check != NULL ? wire->check(event) : dg_host_check_edge(event);
}

/* What waits for the device was sent by somebody; what waits for the host has its length. */
static bool queues_fit(const struct dg_host *state, const struct dg_host_wire *wire)
{
    bool good = true;

    for (uint32_t i = 0; i < DG_HOST_QUEUE; i++) {
        const uint32_t at = (state->in.first + i) % DG_HOST_QUEUE;
        const struct dg_host_event *out = &state->out.event[i];
        good = good && out->length <= sizeof out->data;
        good = good && (i >= state->in.count || check_event(wire, &state->in.event[at]) == 0);
    }
    const struct dg_host_event *first = &state->in.event[state->in.first];
    return good && state->line.part <= (state->in.count == 0 ? 0 : 2u * first->length);
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
        DG_STACK_RANGE(dg_host, in.first, 0, DG_HOST_QUEUE - 1u),
        DG_STACK_RANGE(dg_host, in.count, 0, DG_HOST_QUEUE),
        DG_STACK_RANGE(dg_host, out.first, 0, DG_HOST_QUEUE - 1u),
        DG_STACK_RANGE(dg_host, out.count, 0, DG_HOST_QUEUE),
        DG_STACK_RANGE(dg_host, controller, 0, DG_HOST_BUS_OFF),
    };
    struct dg_host state;

    if (!all_in_range(rows, sizeof rows / sizeof rows[0], body)) {
        return false;
    }
    memcpy(&state, body, sizeof state);
    return state.memory_size == self->memory_size && state.line.now != DG_NEVER &&
           all_hold(&dg_world_keys, &state.world) && queues_fit(&state, self->wire);
}

static bool is_sound(const struct dg_host *self, const uint8_t *body)
{
    const struct dg_stack_check *check = self->wire->state;
    const uint8_t *settings = body + dg_host_round(sizeof *self);
    const uint8_t *device = settings + dg_host_parts_of(self->device, self->wire).settings;

    if (!handle_fits(self, body) || !all_hold(self->wire->keys, settings)) {
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
    const struct header mine = header_of(self);
    const size_t size = body_size(self);
    struct header header;
    struct dg_host state;

    if (n < dg_host_state_size(self)) {
        return DG_HOST_ERR_SPACE;
    }
    memcpy(&header, from, sizeof header);
    if (memcmp(&header, &mine, offsetof(struct header, sum)) != 0) {
        return DG_HOST_ERR_OTHER;
    }
    if (header.sum != dg_crc32(0, body, size) || !is_sound(self, body)) {
        return DG_HOST_ERR_DAMAGED;
    }
    memcpy(&state, body, sizeof state);
    take_pointers(&state, self);
    memcpy(self, body, size);
    *self = state;
    self->world.angle_ctx = self;
    attach(self);
    return DG_HOST_OK;
}
