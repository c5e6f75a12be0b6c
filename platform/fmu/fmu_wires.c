/* SPDX-License-Identifier: MIT */
/*
 * Wires as bytes. CAN: the operations of FMI-LS-BUS 1.0, packed, the least significant byte first:
 * code (4), length of all (4), then what belongs to it. RS485 has no layered standard: characters
 * with their moment, see README.md.
 */
#include <string.h>

#include "encoder.h"

/* Operations of CAN, and how many bytes each has at least. */
enum {
    TRANSMIT = 0x10,
    CONFIRM = 0x20,
    BUS_ERROR = 0x31,
    CONFIGURATION = 0x40,
    STATUS = 0x41,
    TRANSMIT_SIZE = 16,
    BUS_ERROR_SIZE = 15,
    HEADER_SIZE = 8,
};

/* Errors of a sender that make it go bus-off; nobody counts beyond. */
#define BUS_OFF_ERRORS 256u

static void put_le32(uint8_t *to, uint32_t value)
{
    for (unsigned i = 0; i < 4; i++) {
        to[i] = (uint8_t)(value >> 8 * i);
    }
}

static uint32_t get_le32(const uint8_t *from)
{
    return (uint32_t)from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16 |
           (uint32_t)from[3] << 24;
}

static uint16_t get_le16(const uint8_t *from)
{
    return (uint16_t)(from[0] | from[1] << 8);
}

/* Room for `n` bytes; NULL: the importer is behind, and has to fetch first. */
static uint8_t *find_room(struct fmu_encoder *self, size_t n)
{
    struct fmu_course *now = &self->now;
    if (now->taken) {
        now->waiting = 0;
        now->taken = false;
    }
    if (n > self->room - now->waiting) {
        return NULL;
    }
    uint8_t *at = self->out + now->waiting;
    now->waiting += (uint32_t)n;
    return at;
}

static uint8_t *put_operation(struct fmu_encoder *self, uint32_t code, size_t n)
{
    uint8_t *at = find_room(self, n);
    if (at != NULL) {
        put_le32(at, code);
        put_le32(at + 4, (uint32_t)n);
    }
    return at;
}

/* --- CAN --- */

static void put_frame(struct fmu_encoder *self, struct fmu_encoder *from,
                      const struct dg_host_event *event)
{
    uint8_t *at = put_operation(self, TRANSMIT, TRANSMIT_SIZE + (size_t)event->length);
    if (at == NULL) {
        return;
    }
    put_le32(at + 8, event->id);
    at[12] = 0;
    at[13] = (event->flags & DG_HOST_REMOTE) != 0 ? 1 : 0;
    at[14] = event->length;
    at[15] = 0;
    memcpy(at + TRANSMIT_SIZE, event->data, event->length);
    if (event->id > 0x80u && event->id < 0x100u && event->length == 8) { /* EMCY */
        from->now.error = (uint32_t)event->data[0] | (uint32_t)event->data[1] << 8 |
                          (uint32_t)event->data[2] << 16;
    }
}

static void tell_status(struct fmu_encoder *self)
{
    uint8_t *at = put_operation(self, STATUS, HEADER_SIZE + 1);
    if (at != NULL) {
        at[8] = (uint8_t)(self->now.status + 1u);
    }
}

void wire_configure(struct fmu_encoder *self)
{
    if ((self->has & FMU_HAS_FRAMES) == 0 || !self->leads || self->now.configured) {
        return;
    }
    const int64_t rate = self->all->ops->bit_rate(self);
    uint8_t *at = rate <= 0 ? NULL : put_operation(self, CONFIGURATION, HEADER_SIZE + 5);
    if (at != NULL) {
        at[8] = 1; /* CAN_BAUDRATE */
        put_le32(at + 9, (uint32_t)rate);
        tell_status(self);
        self->now.configured = true;
    }
}

/* ISO 11898-1: what a controller counts. */

static enum dg_host_bus state_of(const struct fmu_course *of)
{
    if (of->transmit >= BUS_OFF_ERRORS) {
        return DG_HOST_BUS_OFF;
    }
    return of->transmit > 127u || of->receive > 127u ? DG_HOST_BUS_PASSIVE : DG_HOST_BUS_ACTIVE;
}

/* The one that counts for the wire of this one. */
static struct fmu_encoder *leader_of(struct fmu_encoder *self)
{
    struct fmu_encoder *at = self;
    while (!at->leads || strcmp(at->wire, self->wire) != 0) {
        at--; /* it comes before those that follow */
    }
    return at;
}

/* A fault may make a controller worse than what was counted. Of several on a wire each has its own,
   and the wire is told what was counted. */
void wire_follow(struct fmu_encoder *self)
{
    struct fmu_encoder *leader = leader_of(self);
    if (!leader->now.configured) {
        return;
    }
    const int counted = (int)state_of(&leader->now);
    const int known = dg_host_bus_state(self->host);
    self->now.bus = (uint8_t)(known > counted ? known : counted);
    const uint8_t status = self->shares ? (uint8_t)counted : self->now.bus;
    if (status != leader->now.status) {
        leader->now.status = status;
        tell_status(leader);
    }
}

static int send_change(struct fmu_encoder *self, uint64_t now, enum dg_host_bus before)
{
    const enum dg_host_bus state = state_of(&self->now);
    const struct dg_host_event event = {.at = now, .id = (uint32_t)state, .kind = DG_HOST_BUS};
    return state != before ? self->all->ops->send(self, &event) : DG_HOST_OK;
}

static int count_error(struct fmu_encoder *self, uint64_t now, bool sender, bool primary)
{
    const enum dg_host_bus before = state_of(&self->now);
    uint16_t *counter = sender ? &self->now.transmit : &self->now.receive;
    const uint16_t most = sender ? BUS_OFF_ERRORS : BUS_OFF_ERRORS - 1u;
    *counter = (uint16_t)(*counter + (sender || primary ? 8u : 1u));
    *counter = *counter < most ? *counter : most;
    return send_change(self, now, before);
}

/* What is good does not end bus-off. */
static int count_good(struct fmu_encoder *self, uint64_t now, bool sender)
{
    const enum dg_host_bus before = state_of(&self->now);
    uint16_t *counter = sender ? &self->now.transmit : &self->now.receive;
    if (before == DG_HOST_BUS_OFF) {
        return DG_HOST_OK;
    }
    *counter = !sender && *counter > 127u ? 127u : (uint16_t)(*counter - (*counter > 0 ? 1u : 0u));
    return send_change(self, now, before);
}

int wire_reset(struct fmu_encoder *self, uint64_t now)
{
    const enum dg_host_bus before = state_of(&self->now);
    self->now.transmit = 0;
    self->now.receive = 0;
    return send_change(self, now, before);
}

static int frame_in(struct fmu_encoder *self, uint64_t now, const uint8_t *at, size_t n)
{
    struct dg_host_event event = {.at = now, .kind = DG_HOST_CAN};
    const size_t length = get_le16(at + 14);
    if (length > 8 || n < TRANSMIT_SIZE + length) {
        return DG_HOST_ERR_ARGUMENT;
    }
    if (at[12] != 0) {
        return DG_HOST_OK; /* the controller takes standard frames */
    }
    event.id = get_le32(at + 8);
    event.flags = at[13] != 0 ? DG_HOST_REMOTE : 0;
    event.length = (uint8_t)length;
    memcpy(event.data, at + TRANSMIT_SIZE, length);
    (void)count_good(self, now, false);
    return self->all->ops->send(self, &event);
}

static int operation_in(struct fmu_encoder *self, uint64_t now, const uint8_t *at, size_t n)
{
    switch (get_le32(at)) {
    case TRANSMIT:
        return n < TRANSMIT_SIZE ? DG_HOST_ERR_ARGUMENT : frame_in(self, now, at, n);
    case CONFIRM:
        return count_good(self, now, true);
    case BUS_ERROR:
        return n < BUS_ERROR_SIZE ? DG_HOST_ERR_ARGUMENT
                                  : count_error(self, now, at[14] != 0, at[13] == 1);
    default:
        return DG_HOST_OK; /* of buses and nodes that this one is not */
    }
}

static int take_can(struct fmu_encoder *self, uint64_t now, const uint8_t *bytes, size_t n)
{
    int result = DG_HOST_OK;
    while (result == DG_HOST_OK && n > 0) {
        const size_t length = n < HEADER_SIZE ? 0 : get_le32(bytes + 4);
        if (length < HEADER_SIZE || length > n) {
            return DG_HOST_ERR_ARGUMENT;
        }
        result = operation_in(self, now, bytes, length);
        bytes += length;
        n -= length;
    }
    return result;
}

/* --- RS485 --- */

uint64_t wire_moment(const uint8_t *head)
{
    return get_le32(head) | (uint64_t)get_le32(head + 4) << 32;
}

uint32_t wire_each(const uint8_t *head)
{
    return get_le32(head + 8);
}

size_t wire_count(const uint8_t *head)
{
    return get_le16(head + 12);
}

static void put_characters(struct fmu_encoder *self, const struct dg_host_event *event)
{
    uint8_t *at = find_room(self, FMU_SERIAL_SIZE + (size_t)event->length);
    if (at == NULL) {
        return;
    }
    memset(at, 0, FMU_SERIAL_SIZE);
    put_le32(at, (uint32_t)event->at);
    put_le32(at + 4, (uint32_t)(event->at >> 32));
    put_le32(at + 8, event->id);
    at[12] = event->length;
    at[14] = (uint8_t)(event->flags & DG_HOST_DAMAGED);
    memcpy(at + FMU_SERIAL_SIZE, event->data, event->length);
}

static int take_serial_operation(struct fmu_encoder *self, uint64_t now, const uint8_t *bytes,
                                 size_t n)
{
    int result = DG_HOST_OK;
    while (result == DG_HOST_OK && n > 0) {
        const size_t count = n < FMU_SERIAL_SIZE ? n : wire_count(bytes);
        if (n < FMU_SERIAL_SIZE || count > n - FMU_SERIAL_SIZE) {
            return DG_HOST_ERR_ARGUMENT;
        }
        const uint64_t at = wire_moment(bytes);
        result = self->all->ops->say(self, at > now ? at : now, bytes, count);
        bytes += FMU_SERIAL_SIZE + count;
        n -= FMU_SERIAL_SIZE + count;
    }
    return result;
}

/* --- both --- */

int wire_take(struct fmu_encoder *self, uint64_t now, const uint8_t *bytes, size_t n)
{
    if ((self->has & FMU_HAS_FRAMES) != 0) {
        return take_can(self, now, bytes, n);
    }
    return (self->has & FMU_HAS_CHARACTERS) != 0 ? take_serial_operation(self, now, bytes, n)
                                                 : DG_HOST_ERR_WIRE;
}

/* The last characters that wait. @return NULL: there are none, or they have been seen */
static uint8_t *find_last(const struct fmu_encoder *self)
{
    size_t at = 0;
    size_t last = 0;
    while (self->now.waiting - at >= FMU_SERIAL_SIZE) {
        last = at;
        at += FMU_SERIAL_SIZE + wire_count(self->out + at);
        if (at > self->now.waiting) {
            return NULL;
        }
    }
    return at == 0 || at != self->now.waiting || self->now.taken ? NULL : self->out + last;
}

/* A character that begins where others end, as far as the time of each is one of whole ns. */
bool wire_join(struct fmu_encoder *self, const struct dg_host_event *event)
{
    uint8_t *last = find_last(self);
    const size_t count = last == NULL ? 0 : wire_count(last);
    if (last == NULL || self->now.waiting == self->room || count == UINT16_MAX ||
        wire_each(last) != event->id || (last[14] & DG_HOST_DAMAGED) != event->flags) {
        return false;
    }
    const uint64_t end = wire_moment(last) + count * event->id;
    if (event->at > end + count || end > event->at + count) {
        return false;
    }
    self->out[self->now.waiting++] = event->data[0];
    last[12] = (uint8_t)(count + 1);
    last[13] = (uint8_t)((count + 1) >> 8);
    return true;
}

void wire_put(struct fmu_encoder *self, struct fmu_encoder *from, const struct dg_host_event *event)
{
    if (event->kind == DG_HOST_CAN) {
        put_frame(self, from, event);
    } else if (event->kind == DG_HOST_BYTES) {
        put_characters(self, event);
    }
}

void wire_collect(struct fmu_encoder *self)
{
    struct dg_host_event event;
    const size_t most = TRANSMIT_SIZE + sizeof event.data;
    if ((self->has & FMU_HAS_FRAMES) != 0) {
        if (!self->now.configured) {
            return; /* a bus knows its bit rate before there are frames */
        }
        wire_follow(self);
    }
    while (self->now.taken || self->room - self->now.waiting >= most) {
        const int result = dg_host_receive(self->host, &event);
        if (result == 0) {
            return;
        }
        if (result > 0) {
            wire_put(self, self, &event);
        }
    }
}
