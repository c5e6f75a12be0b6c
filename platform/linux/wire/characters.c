/* SPDX-License-Identifier: MIT */
/*
 * Time of a character = its bits at the data rate, always counted from the start of the reply:
 *
 *   start   end_of(0)   end_of(1)   end_of(2)
 *     |40---------|43---------|03---------|        late once is late once
 */
#include "characters.h"

#include <string.h>

#define ESCAPE 0xFFu

/* End of the stop bit of character `index`. */
static dg_ns end_of(const struct lx_line *self, size_t index)
{
    const uint32_t bits = (uint32_t)(index + 1) * self->bits;
    return dg_after(self->start, dg_bit_times_ns(bits, self->baud));
}

void lx_line_start(struct lx_line *self, dg_ns now, const uint8_t *bytes, size_t n)
{
    self->length = n < sizeof self->bytes ? n : sizeof self->bytes;
    memcpy(self->bytes, bytes, self->length);
    self->sent = 0;
    self->start = now;
}

void lx_line_set(struct lx_line *self, const struct lx_uart *uart)
{
    self->baud = uart->baud;
    self->bits = lx_character_bits(uart->parity);
}

size_t lx_line_take(struct lx_line *self, dg_ns now, const uint8_t **bytes)
{
    const size_t first = self->sent;
    while (self->sent < self->length && end_of(self, self->sent) <= now) {
        self->sent++;
    }
    *bytes = self->bytes + first;
    return self->sent - first;
}

size_t lx_line_take_all(struct lx_line *self, const uint8_t **bytes)
{
    const size_t first = self->sent;
    self->sent = self->length;
    *bytes = self->bytes + first;
    return self->length - first;
}

dg_ns lx_line_next(const struct lx_line *self)
{
    return self->sent < self->length ? end_of(self, self->sent) : DG_NEVER;
}

bool lx_line_busy(const struct lx_line *self, dg_ns now)
{
    return self->sent < self->length || (self->length > 0 && now < end_of(self, self->length - 1));
}

bool lx_line_on(const struct lx_line *self, dg_ns at, uint8_t *byte)
{
    if (self->sent >= self->length) {
        return false;
    }
    *byte = self->bytes[self->sent];
    return at > (self->sent == 0 ? self->start : end_of(self, self->sent - 1));
}

void lx_line_repeat(struct lx_line *self)
{
    if (self->length > 0) {
        self->start = end_of(self, self->length - 1);
        self->sent = 0;
    }
}

void lx_line_stop(struct lx_line *self)
{
    self->length = 0;
    self->sent = 0;
}

bool lx_intake_put(struct lx_intake *self, dg_ns now, dg_ns each, const struct lx_coming *coming)
{
    if (self->count == LX_INTAKE_MAX) {
        return false;
    }
    struct lx_coming *place = &self->coming[(self->first + self->count) % LX_INTAKE_MAX];
    self->end = dg_after(now > self->end ? now : self->end, each);
    self->count++;
    *place = *coming;
    place->end = self->end;
    return true;
}

dg_ns lx_intake_next(const struct lx_intake *self)
{
    return self->count > 0 ? self->coming[self->first].end : DG_NEVER;
}

dg_ns lx_intake_last(const struct lx_intake *self)
{
    return self->count > 0 ? self->end : DG_NEVER;
}

struct lx_coming lx_intake_take(struct lx_intake *self)
{
    const struct lx_coming first = self->coming[self->first];
    self->first = (self->first + 1) % LX_INTAKE_MAX;
    self->count--;
    return first;
}

bool lx_parmrk_feed(struct lx_parmrk *self, uint8_t byte, struct lx_character *out)
{
    const uint8_t seen = self->seen;
    if (seen == 0 && byte == ESCAPE) {
        self->seen = 1;
        return false;
    }
    if (seen == 1 && byte == 0) {
        self->seen = 2;
        return false;
    }
    /* After one FF, everything but 00 stands for itself; the kernel only sends FF there. */
    self->seen = 0;
    out->byte = byte;
    out->damaged = seen == 2;
    return true;
}
