/* SPDX-License-Identifier: MIT */
/* States of buses: whose they are, and that nothing changes before all of one was looked at. */
#include "bus_tape.h"

#include <string.h>

#include "drehgeber/crc.h"
#include "drehgeber/version.h"

#define VERSION_MAX 24u
#define ORDER UINT32_C(0x01020304)

static const char magic[8] = {'D', 'G', 'B', 'U', 'S', 'S', 'T', '\1'};
static const char version[] = DG_VERSION;
_Static_assert(sizeof version <= VERSION_MAX, "the version has room");

/* The builds that understand each other: same layouts, same byte order. */
struct header {
    char magic[8];
    char version[VERSION_MAX];
    uint32_t order;   /* of the bytes in a number */
    uint32_t pointer; /* bytes of one */
    uint32_t medium;
    uint32_t wire; /* bytes of each ... */
    uint32_t place;
    uint32_t encoders;
    uint32_t size; /* of all behind the header */
    uint32_t sum;  /* likewise */
};

static struct header bus_header_of(const struct dg_bus *self)
{
    struct header header = {
        .order = ORDER,
        .pointer = sizeof(void *),
        .medium = self->medium->medium,
        .wire = (uint32_t)self->medium->wire_size,
        .place = (uint32_t)self->medium->place_size,
        .encoders = (uint32_t)self->count,
    };

    memcpy(header.magic, magic, sizeof magic);
    memcpy(header.version, version, sizeof version);
    return header;
}

/* ------------------------------------------------------------ a walk */

/* A number of up to four bytes, at any address. */
static uint32_t number_at(const uint8_t *bytes, size_t size)
{
    uint32_t number = bytes[0];
    uint16_t half;

    if (size == sizeof number) {
        memcpy(&number, bytes, sizeof number);
    } else if (size == sizeof half) {
        memcpy(&half, bytes, sizeof half);
        number = half;
    }
    return number;
}

static bool is_in_range(const struct bus_member *row, const uint8_t *bytes)
{
    return row->most == UINT32_MAX || number_at(bytes, row->size) <= row->most;
}

/* What the state has not got, or what is out of its range, comes nowhere. */
static void read_member(struct bus_tape *self, const struct bus_member *row, uint8_t *to)
{
    const uint8_t *bytes = self->from + self->at;

    dg_bus_tape_expect(self, row->size <= self->size - self->at && is_in_range(row, bytes));
    if (!self->good) {
        return;
    }
    if (to != NULL) {
        memcpy(to + row->offset, bytes, row->size);
    }
    self->at += row->size;
}

static void write_member(struct bus_tape *self, const struct bus_member *row, const uint8_t *from)
{
    if (self->to != NULL && row->size <= self->size - self->at) {
        memcpy(self->to + self->at, from + row->offset, row->size);
    }
    self->at += row->size;
}

void dg_bus_tape_members(struct bus_tape *self, const struct bus_member *rows, size_t count,
                         const void *from, void *to)
{
    for (size_t i = 0; i < count; i++) {
        if (self->way == BUS_TAPE_SAVE) {
            write_member(self, &rows[i], from);
        } else {
            read_member(self, &rows[i], to);
        }
    }
}

dg_ns dg_bus_tape_moment(struct bus_tape *self, dg_ns moment)
{
    static const struct bus_member row = {0, sizeof moment, UINT32_MAX};
    dg_ns result = moment;

    dg_bus_tape_members(self, &row, 1, &moment, &result);
    return result;
}

size_t dg_bus_tape_length(struct bus_tape *self, size_t count, size_t most)
{
    const struct bus_member row = {0, sizeof(uint32_t), (uint32_t)most};
    const uint32_t length = (uint32_t)count;
    uint32_t result = length;

    dg_bus_tape_members(self, &row, 1, &length, &result);
    return self->good ? result : 0;
}

/* What an encoder waits for the bus does at its moment: a deadline that its handle has not would
 * make it live through all that lies in between. One that wanted the present again waits a
 * nanosecond. */
dg_ns dg_bus_tape_deadline(struct bus_tape *self, const struct bus_place *place)
{
    const dg_ns deadline = dg_bus_tape_moment(self, place->deadline);
    const dg_ns own = dg_host_next(place->host);
    const dg_ns served = dg_host_line_of(place->host)->now;

    dg_bus_tape_expect(self, deadline >= self->now);
    dg_bus_tape_expect(self, deadline == own || (own <= served && deadline <= dg_after(served, 1)));
    return deadline;
}

static void pass_bus(const struct dg_bus *self, struct bus_tape *tape, struct dg_bus *to)
{
    const dg_ns now = dg_bus_tape_moment(tape, self->now);
    const dg_ns called = dg_bus_tape_moment(tape, self->called);

    dg_bus_tape_expect(tape, called <= now && now != DG_NEVER);
    tape->now = now;
    self->medium->pass_wire(self, tape);
    for (size_t i = 0; i < self->count; i++) {
        self->medium->pass_place(dg_bus_place_at(self, i), tape);
    }
    if (to != NULL) {
        to->now = now;
        to->called = called;
    }
}

/* ------------------------------------------------------------ states */

static size_t body_size(const struct dg_bus *self)
{
    struct bus_tape tape = {.way = BUS_TAPE_SAVE, .good = true};

    pass_bus(self, &tape, NULL);
    return tape.at;
}

size_t dg_bus_state_size(const struct dg_bus *self)
{
    return sizeof(struct header) + body_size(self);
}

int dg_bus_save(const struct dg_bus *self, void *to, size_t n)
{
    struct header header = bus_header_of(self);
    struct bus_tape tape = {.way = BUS_TAPE_SAVE,
                            .to = (uint8_t *)to + sizeof header,
                            .size = body_size(self),
                            .good = dg_bus_next(self) >= self->now};

    if (n < sizeof header + tape.size) {
        return DG_HOST_ERR_SPACE;
    }
    pass_bus(self, &tape, NULL);
    if (!tape.good) {
        return DG_HOST_ERR_STATE;
    }
    header.size = (uint32_t)tape.size;
    header.sum = dg_crc32(0, tape.to, tape.size);
    memcpy(to, &header, sizeof header);
    return DG_HOST_OK;
}

/* The sum tells a damaged state. One that somebody has made has a right one: all of it is looked at
 * before any of it is there. */
static bool is_sound_bus(const struct dg_bus *self, const struct header *header,
                         const uint8_t *body)
{
    struct bus_tape tape = {
        .way = BUS_TAPE_CHECK, .from = body, .size = header->size, .good = true};

    if (header->sum != dg_crc32(0, body, header->size)) {
        return false;
    }
    pass_bus(self, &tape, NULL);
    return tape.good && tape.at == tape.size;
}

/* It is the present for all encoders, also for those that nothing has happened to for long:
 * whatever moment a state says, none lives through what lies before it. */
int dg_bus_restore(struct dg_bus *self, const void *from, size_t n)
{
    const uint8_t *body = (const uint8_t *)from + sizeof(struct header);
    const struct header mine = bus_header_of(self);
    struct header header;

    if (n < sizeof header) {
        return DG_HOST_ERR_SPACE;
    }
    memcpy(&header, from, sizeof header);
    if (memcmp(&header, &mine, offsetof(struct header, size)) != 0) {
        return DG_HOST_ERR_OTHER;
    }
    if (header.size > n - sizeof header) {
        return DG_HOST_ERR_SPACE;
    }
    if (!is_sound_bus(self, &header, body)) {
        return DG_HOST_ERR_DAMAGED;
    }
    struct bus_tape tape = {
        .way = BUS_TAPE_RESTORE, .from = body, .size = header.size, .good = true};
    pass_bus(self, &tape, self);
    if (self->medium->restored != NULL) {
        self->medium->restored(self);
    }
    for (size_t i = 0; i < self->count; i++) {
        dg_host_skip(dg_bus_encoder(self, i), self->now);
    }
    return DG_HOST_OK;
}
