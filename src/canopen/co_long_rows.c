/* SPDX-License-Identifier: MIT */
/*
 * Values of an EDS file that 32 bits do not hold: their defaults, limits and rows.
 */
#include <string.h>

#include "co_file.h"

#define DOMAIN 0x0Fu
#define OCTETS 0x0Au
#define VISIBLE 0x09u

/* Numbers by DataType; TIME_OF_DAY, TIME_DIFFERENCE and REAL64 are bytes without limits. */
static const struct {
    uint8_t bytes;
    uint8_t kind; /* enum dg_co_long_kind */
} widths[] = {
    [0x0C] = {6, DG_CO_LONG_BYTES},    [0x0D] = {6, DG_CO_LONG_BYTES},
    [0x10] = {3, DG_CO_LONG_SIGNED},   [0x11] = {8, DG_CO_LONG_BYTES},
    [0x12] = {5, DG_CO_LONG_SIGNED},   [0x13] = {6, DG_CO_LONG_SIGNED},
    [0x14] = {7, DG_CO_LONG_SIGNED},   [0x15] = {8, DG_CO_LONG_SIGNED},
    [0x16] = {3, DG_CO_LONG_UNSIGNED}, [0x18] = {5, DG_CO_LONG_UNSIGNED},
    [0x19] = {6, DG_CO_LONG_UNSIGNED}, [0x1A] = {7, DG_CO_LONG_UNSIGNED},
    [0x1B] = {8, DG_CO_LONG_UNSIGNED},
};

/* @return bytes of a number, 0: it is none of these */
static uint8_t width_of(const struct eds_entry *entry)
{
    return entry->type < DG_COUNT(widths) ? widths[entry->type].bytes : 0;
}

static bool is_string_entry(const struct eds_entry *entry)
{
    return (entry->type >= VISIBLE && entry->type <= 0x0Bu) || entry->type == DOMAIN;
}

static uint32_t hex_value_of(char c)
{
    const char small = (char)(c >= 'A' && c <= 'F' ? c - 'A' + 'a' : c);

    if (small >= '0' && small <= '9') {
        return (uint32_t)(small - '0');
    }
    return small >= 'a' && small <= 'f' ? (uint32_t)(small - 'a') + 10u : 16u;
}

/* Octets and domains are written as digits, two for a byte, blanks between them or not.
 * @param to NULL: they are only counted
 * @return how many; 0: it is a text */
static size_t read_octets(const struct eds_entry *entry, uint8_t *to)
{
    const struct eds_span text = entry->initial;
    size_t digits = 0;

    if (entry->type != OCTETS && entry->type != DOMAIN) {
        return 0;
    }
    for (size_t i = 0; i < text.n; i++) {
        const uint32_t digit = hex_value_of(text.at[i]);
        if (text.at[i] == ' ' && digits % 2u == 0) {
            continue;
        }
        if (digit > 0xFu || digits / 2u == DG_EDS_LONG_MAX) {
            return 0;
        }
        if (to != NULL) {
            to[digits / 2u] = (uint8_t)((uint32_t)to[digits / 2u] << 4 | digit);
        }
        digits++;
    }
    return digits % 2u == 0 ? digits / 2u : 0;
}

bool dg_co_is_long(const struct eds_entry *entry)
{
    return width_of(entry) != 0 ||
           (is_string_entry(entry) &&
            ((entry->access & DG_CO_W) != 0 || entry->initial.n > DG_CO_STRING_MAX ||
             read_octets(entry, NULL) != 0));
}

/* ------------------------------------------------------------ texts */

static void make_text(struct eds_maker *self, struct eds_entry *entry, struct dg_co_long *to)
{
    const size_t octets = read_octets(entry, NULL);
    const size_t n = octets != 0 ? octets : entry->initial.n;

    to->n = (uint16_t)(n < DG_EDS_LONG_MAX ? n : DG_EDS_LONG_MAX);
    if (n > DG_EDS_LONG_MAX) {
        dg_co_note_lack(&self->in, entry, "DefaultValue", "is cut off behind 1024 characters",
                        NULL);
    }
    if ((to->access & DG_CO_W) != 0 && self->text_count == EDS_TEXTS_MAX) {
        dg_co_note_lack(&self->in, entry, "AccessType",
                        "one text too many that can be written: read only", "at most 64 of them");
        to->access = DG_CO_R;
    }
    self->text_count += (to->access & DG_CO_W) != 0 ? 1u : 0u;
    to->most = (to->access & DG_CO_W) != 0 ? DG_EDS_LONG_MAX : to->n;
    uint8_t *bytes = dg_co_keep_bytes(&self->in, to->n);
    if (bytes == NULL) {
        return;
    }
    to->initial = bytes;
    if (octets != 0) {
        (void)read_octets(entry, bytes);
    } else if (to->n > 0) { /* without a default there is no text at all */
        memcpy(bytes, entry->initial.at, to->n);
    }
}

/* ------------------------------------------------------------ numbers */

/* All bits that its bytes have. */
static uint64_t ones_of(const struct dg_co_long *self)
{
    return UINT64_MAX >> (64u - 8u * self->most);
}

/* With its sign, if it has one. */
static uint64_t extend_sign(const struct dg_co_long *self, uint64_t value)
{
    const uint64_t sign = self->kind == DG_CO_LONG_SIGNED ? ones_of(self) / 2u + 1u : 0;

    return ((value & ones_of(self)) ^ sign) - sign;
}

/* A number of an entry, or `otherwise`. Nothing of 64 bits follows the node-ID. */
static uint64_t wide_number_of(struct eds_maker *self, const struct eds_entry *entry,
                               const char *key, struct eds_span text, const struct dg_co_long *to,
                               uint64_t otherwise)
{
    const struct eds_number number = dg_co_take_number(text);
    const uint64_t value = number.wide;

    if (text.n == 0) {
        return otherwise;
    }
    if (!number.valid_wide || number.follows ||
        (extend_sign(to, value) != value && (value & ones_of(to)) != value)) {
        dg_co_note_entry(&self->in, entry, key, "is no number of its type, and left out",
                         "a number, as 7 or 0x0007");
        return otherwise;
    }
    return extend_sign(to, value);
}

static bool is_within_limits(const struct dg_co_long *self, uint64_t value)
{
    return self->kind == DG_CO_LONG_SIGNED
               ? (int64_t)value >= (int64_t)self->min && (int64_t)value <= (int64_t)self->max
               : value >= self->min && value <= self->max;
}

static void find_limits(struct eds_maker *self, const struct eds_entry *entry,
                        struct dg_co_long *to, uint64_t initial)
{
    const bool has_sign = to->kind == DG_CO_LONG_SIGNED;
    const uint64_t most = has_sign ? ones_of(to) / 2u : ones_of(to);
    const uint64_t least = has_sign ? ~most : 0;

    to->min = wide_number_of(self, entry, "LowLimit", entry->low, to, least);
    to->max = wide_number_of(self, entry, "HighLimit", entry->high, to, most);
    if (!is_within_limits(to, initial)) {
        dg_co_note_entry(&self->in, entry, "",
                         "its default is outside of its limits, which are left out", NULL);
        to->min = least;
        to->max = most;
    }
}

static void make_number(struct eds_maker *self, const struct eds_entry *entry,
                        struct dg_co_long *to)
{
    uint8_t *bytes = dg_co_keep_bytes(&self->in, sizeof(uint64_t));

    to->kind = widths[entry->type].kind;
    to->least = width_of(entry);
    to->most = to->least;
    to->n = to->least;
    if (bytes == NULL) {
        return;
    }
    const uint64_t initial = wide_number_of(self, entry, "DefaultValue", entry->initial, to, 0);
    dg_store_le64(bytes, initial);
    to->initial = bytes;
    find_limits(self, entry, to, initial);
}

/* ------------------------------------------------------------ rows */

/* It behaves as an object of 64 bits of the base. */
static void bind_long(struct eds_maker *self, const struct eds_entry *entry, struct dg_co_long *to)
{
    struct dg_co_object base;

    if (!dg_co_find_base(self, entry, &base) || co_type(&base) == DG_CO_STRING) {
        return;
    }
    if (co_type(&base) != DG_CO_WIDE || to->kind == DG_CO_LONG_BYTES || to->most != 8u) {
        dg_co_note_lack(&self->in, entry, "DataType",
                        "has not the type that it behaves with: a value only", NULL);
        return;
    }
    if ((to->access & DG_CO_W) != 0 && !co_is(&base, DG_CO_W)) {
        dg_co_note_lack(&self->in, entry, "AccessType", "the encoder itself sets it: read only",
                        NULL);
        to->access = DG_CO_R;
    }
    to->bound = base;
    self->to->plain--;
    self->to->bound++;
}

/* Whether a TPDO has the low half of it as delivered, as some encoders have 6008h. */
static bool is_halved(const struct eds_maker *self, uint32_t key)
{
    bool found = false;

    for (size_t i = 0; i < self->in.count; i++) {
        const struct eds_entry *entry = &self->in.entries[i];
        found = found || ((entry->key & 0xFE000000u) == DG_CO_KEY(0x1A00, 0) &&
                          dg_co_take_number(entry->initial).value == (key | 32u));
    }
    return found;
}

/* For TPDOs, which have all of it or half. All of it are two rows with one key, of which a search
 * finds the last. */
static uint16_t make_mapped(const struct eds_maker *self, const struct dg_co_long *from,
                            struct dg_co_row *row)
{
    row->flags = (uint16_t)(DG_CO_U32 << 12 | DG_CO_R | DG_CO_MAP);
    if (from->bound.row != NULL) {
        row->flags |= from->bound.row->flags & DG_CO_EVENT;
    }
    if (is_halved(self, from->key)) {
        return 1;
    }
    row[1] = *row;
    row[1].flags ^= (DG_CO_U32 ^ DG_CO_WIDE) << 12;
    row[0].slot = EDS_HIGH;
    return 2;
}

uint16_t dg_co_make_long(struct eds_maker *self, struct eds_entry *entry, struct dg_co_row *row)
{
    struct dg_co_long *to = &self->longs[self->to->long_count];

    *to = (struct dg_co_long){.key = entry->key, .access = entry->access & DG_CO_RW};
    if (width_of(entry) != 0) {
        make_number(self, entry, to);
    } else {
        make_text(self, entry, to);
    }
    /* Also of those that no PDO has: it is none of the base's, so their rows are told apart. */
    row->hook = dg_co_keep_hook(self, dg_co_hook_wide);
    row->flags = (uint16_t)(DG_CO_STRING << 12);
    row->initial = self->to->long_count++;
    self->to->plain++;
    bind_long(self, entry, to);
    return entry->map && to->least == 8u && (to->access & DG_CO_R) != 0 ? make_mapped(self, to, row)
                                                                        : 1;
}
