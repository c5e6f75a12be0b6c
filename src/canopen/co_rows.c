/* SPDX-License-Identifier: MIT */
/*
 * Rows of a device from the entries of its EDS file. A row that the base has, too, takes its slot
 * and its hook; what may be written besides becomes a cell, the rest is constant.
 */
#include <string.h>

#include "co_file.h"
#include "co_storage.h"

_Static_assert(DG_CO_VALUE_APPLICATION == DG_CO_SLOT_APPLICATION, "all of the stack's are named");

#define NODE_ID_MAX 127u
/* May be written where the file says so, and changes nothing. */
#define EMCY_COB_ID DG_CO_KEY(0x1014, 0)

/* ------------------------------------------------------------ types and numbers */

/* As what a row holds it; DG_CO_TYPE_COUNT: not at all. */
static enum dg_co_type row_type_of(const struct eds_entry *entry)
{
    static const uint8_t types[] = {
        [0x01] = DG_CO_U8,     [0x02] = DG_CO_I8,     [0x03] = DG_CO_I16,    [0x04] = DG_CO_I32,
        [0x05] = DG_CO_U8,     [0x06] = DG_CO_U16,    [0x07] = DG_CO_U32,    [0x08] = DG_CO_U32,
        [0x09] = DG_CO_STRING, [0x0A] = DG_CO_STRING, [0x0B] = DG_CO_STRING, [0x0F] = DG_CO_STRING,
    };
    const uint8_t type = entry->type < sizeof types ? types[entry->type] : 0;

    return type != 0 ? (enum dg_co_type)type : DG_CO_TYPE_COUNT;
}

static struct dg_co_object object_of(const struct dg_co_row *row)
{
    return (struct dg_co_object){.row = row};
}

/* Whether the bits fit the type: signed as such or as two's complement of its width. */
static bool fits_type(const struct dg_co_object *object, uint32_t value)
{
    return dg_co_extend(object, value) == value || co_cut(object, value) == value;
}

/* A number of an entry, sign-extended; `otherwise` when there is none. */
static uint32_t entry_number_of(struct eds_maker *self, const struct eds_entry *entry,
                                const char *key, struct eds_span text,
                                const struct dg_co_object *object, uint32_t otherwise)
{
    const struct eds_number number = dg_co_take_number(text);

    if (text.n == 0) {
        return otherwise;
    }
    if (!number.valid || !fits_type(object, number.value)) {
        dg_co_note_entry(&self->in, entry, key, "is no number of its type, and left out",
                         "a number, as 7, 0x0007 or $NODEID+0x180");
        return otherwise;
    }
    return dg_co_extend(object, number.value);
}

static bool is_within(const struct dg_co_object *object, struct dg_co_limits range, uint32_t value)
{
    return co_type(object) <= DG_CO_I32
               ? (int32_t)value >= (int32_t)range.min && (int32_t)value <= (int32_t)range.max
               : value >= range.min && value <= range.max;
}

/* As the file says, else `all`. */
static struct dg_co_limits limits_of(struct eds_maker *self, const struct eds_entry *entry,
                                     const struct dg_co_object *object, uint32_t initial,
                                     bool follows, struct dg_co_limits all)
{
    const struct dg_co_limits range = {
        entry_number_of(self, entry, "LowLimit", entry->low, object, all.min),
        entry_number_of(self, entry, "HighLimit", entry->high, object, all.max),
    };

    if (dg_co_take_number(entry->low).follows || dg_co_take_number(entry->high).follows) {
        return all;
    }
    if (!is_within(object, range, initial + (follows ? 1u : 0u)) ||
        !is_within(object, range, initial + (follows ? NODE_ID_MAX : 0u))) {
        dg_co_note_entry(&self->in, entry, "",
                         "its default is outside of its limits, which are left out", NULL);
        return all;
    }
    return range;
}

/* @return the number of these limits in the table, 0: none */
static uint8_t keep_limits(struct eds_maker *self, const struct eds_entry *entry,
                           const struct dg_co_object *object, struct dg_co_limits range)
{
    const struct dg_co_limits all = dg_co_type_limits(object);
    uint8_t n = 1;

    if (range.min == all.min && range.max == all.max) {
        return 0;
    }
    while (n < self->limit_count &&
           (self->limits[n].min != range.min || self->limits[n].max != range.max)) {
        n++;
    }
    if (n == EDS_LIMITS_MAX) {
        dg_co_note_lack(&self->in, entry, "",
                        "one limit too many for objects that behave: any value may be written",
                        NULL);
        return 0;
    }
    self->limits[n] = range;
    self->limit_count = n < self->limit_count ? self->limit_count : (uint8_t)(n + 1u);
    return n;
}

uint8_t dg_co_keep_hook(struct eds_maker *self, dg_co_hook *hook)
{
    uint8_t n = 0;

    while (n < self->hook_count && self->hooks[n] != hook) {
        n++;
    }
    if (n == EDS_HOOKS_MAX) {
        return 0;
    }
    self->hooks[n] = hook;
    self->hook_count = n < self->hook_count ? self->hook_count : (uint8_t)(n + 1u);
    return n;
}

/* ------------------------------------------------------------ texts */

const char *dg_co_keep_text(struct eds_reader *in, struct eds_span text, size_t most)
{
    const size_t n = text.n < most ? text.n : most;
    char *to = dg_co_keep_bytes(in, n + 1u);

    if (to == NULL) {
        return "";
    }
    for (size_t i = 0; i < n; i++) {
        to[i] = text.at[i];
    }
    return to;
}

static void make_string(struct eds_maker *self, const struct eds_entry *entry,
                        struct dg_co_row *row)
{
    row->flags = (uint16_t)(DG_CO_STRING << 12 | DG_CO_R | DG_CO_CONST);
    row->initial = self->string_count;
    self->strings[self->string_count++] =
        dg_co_keep_text(&self->in, entry->initial, DG_CO_STRING_MAX);
    self->to->plain++;
}

/* ------------------------------------------------------------ rows */

bool dg_co_find_base(const struct eds_maker *self, const struct eds_entry *entry,
                     struct dg_co_object *object)
{
    const uint32_t index = entry->key >> 16;
    const bool memory = (index == 0x1010 || index == 0x1011) && (entry->key & 0xFF00u) != 0;
    const uint32_t key = memory ? DG_CO_KEY(index, 1) : entry->key;
    const bool own = (self->to->device.device_type & 0xFFFFu) == self->ground->profile;

    return (own || index < 0x2000) && dg_co_find(self->to->base, key, object) == DG_CO_OK &&
           (object->row->flags & DG_CO_RW) != 0;
}

/* The file says what a master may do, as far as the base can. */
static uint16_t flags_of(struct eds_maker *self, const struct eds_entry *entry,
                         const struct dg_co_object *base)
{
    const bool writable = co_is(base, DG_CO_W) || entry->key == EMCY_COB_ID;
    const bool fixed = co_hook(base) == NULL && !co_is(base, DG_CO_SLOT);
    uint16_t flags = entry->access & DG_CO_RW;

    if ((flags & DG_CO_W) != 0 && !writable) {
        dg_co_note_lack(&self->in, entry, "AccessType", "the encoder itself sets it: read only",
                        NULL);
        flags = DG_CO_R;
    }
    flags |= entry->map ? DG_CO_MAP : 0;
    flags |= base->row->flags & (DG_CO_EVENT | DG_CO_SLOT | DG_CO_CONST);
    return flags | (fixed ? DG_CO_CONST : 0u);
}

/* The file's default, if the base takes it. @param follows whether it has the node-ID in it */
static uint32_t bound_default(struct eds_maker *self, const struct eds_entry *entry,
                              const struct dg_co_object *object, const struct dg_co_object *base,
                              bool *follows)
{
    const uint32_t own = dg_co_default(self->to->base, base);
    const uint32_t initial =
        entry_number_of(self, entry, "DefaultValue", entry->initial, object, own);

    *follows = entry->initial.n == 0
                   ? co_is(base, DG_CO_ID)
                   : dg_co_take_number(entry->initial).follows && co_is(base, DG_CO_SLOT);
    if (!co_is(base, DG_CO_SLOT) ||
        (dg_co_in_range(base, initial + (*follows ? 1u : 0u)) &&
         dg_co_in_range(base, initial + (*follows ? NODE_ID_MAX : 0u)))) {
        return initial;
    }
    dg_co_note_lack(&self->in, entry, "DefaultValue",
                    "is none that the encoder takes: its own is there", NULL);
    *follows = co_is(base, DG_CO_ID);
    return own;
}

/* What both the file and the base take. */
static struct dg_co_limits common_limits(struct dg_co_limits file, const struct dg_co_object *base)
{
    struct dg_co_limits range = file;

    range.min = dg_co_in_range(base, file.min) ? file.min : dg_co_limits_of(base).min;
    range.max = dg_co_in_range(base, file.max) ? file.max : dg_co_limits_of(base).max;
    return range;
}

/* What the base takes, in the object's type: all values of 32 bits are other ones with a sign. */
static struct dg_co_limits base_limits(const struct dg_co_object *object,
                                       const struct dg_co_object *base)
{
    const struct dg_co_limits range = dg_co_limits_of(base);
    const struct dg_co_limits all = dg_co_type_limits(base);
    const bool any = range.min == all.min && range.max == all.max;

    return any && co_is(base, DG_CO_SLOT) ? dg_co_type_limits(object) : range;
}

/* It behaves as the base's: slot and hook are its own. */
static void bind_row(struct eds_maker *self, const struct eds_entry *entry,
                     const struct dg_co_object *base, struct dg_co_row *row)
{
    const struct dg_co_object object = object_of(row);
    dg_co_hook *const hook = co_hook(base);
    bool follows;

    row->slot = base->slot;
    row->initial = bound_default(self, entry, &object, base, &follows);
    row->flags |= flags_of(self, entry, base) | (follows ? DG_CO_ID : 0u);
    row->hook = dg_co_keep_hook(self, hook == dg_co_hook_store ? dg_co_hook_keep : hook);
    /* The stack's hooks know what fits, and may set what a file's limits would not have. */
    if ((row->flags & DG_CO_W) != 0 && (hook == NULL || entry->key >= DG_CO_KEY(0x2000, 0))) {
        const struct dg_co_limits all = base_limits(&object, base);
        const struct dg_co_limits range =
            common_limits(limits_of(self, entry, &object, row->initial, follows, all), base);
        row->key |= (uint32_t)keep_limits(self, entry, &object, range) << 4;
    }
    self->to->bound++;
}

/* It only stores, or never changes. @param otherwise its default where the file has none */
static void make_plain(struct eds_maker *self, const struct eds_entry *entry, struct dg_co_row *row,
                       uint32_t otherwise)
{
    const struct dg_co_object object = object_of(row);
    const bool follows = dg_co_take_number(entry->initial).follows;
    const uint32_t initial =
        entry_number_of(self, entry, "DefaultValue", entry->initial, &object, otherwise);

    row->flags |= (entry->access & (DG_CO_R | DG_CO_W)) | (entry->map ? DG_CO_MAP : 0u);
    self->to->plain++;
    if ((entry->access & DG_CO_W) == 0) {
        row->flags |= follows ? 0u : DG_CO_CONST;
        row->initial = initial;
        row->hook = follows ? dg_co_keep_hook(self, dg_co_hook_follows) : 0;
        return;
    }
    row->initial = self->to->cell_count;
    row->hook = dg_co_keep_hook(self, dg_co_hook_cell);
    self->cells[self->to->cell_count++] = (struct dg_co_cell){
        .key = entry->key,
        .initial = initial,
        .limits = limits_of(self, entry, &object, initial, follows, dg_co_type_limits(&object)),
        .follows = follows,
        .type = (uint8_t)co_type(&object),
    };
}

static void note_plain(struct eds_maker *self, const struct eds_entry *entry, bool known)
{
    const uint32_t index = entry->key >> 16;
    const bool pdo = index >= 0x1400 && index < 0x1C00;

    if (known) {
        dg_co_note_lack(&self->in, entry, "DataType",
                        "has not the type that it behaves with: a value only", NULL);
    } else if (pdo && (entry->key & 0xFF00u) == 0x0100u) {
        dg_co_note_lack(&self->in, entry, "", "a PDO that this node does not have: values only",
                        "TPDO1 to TPDO4 with up to 8 entries");
    }
}

/* Whether a value of the base's can be one of this type: what is not kept is made anew each time,
 * and 32 bits may count from below 0 or not. */
static bool is_alike(const struct dg_co_object *base, const struct dg_co_object *object)
{
    if (co_type(base) == DG_CO_WIDE) {
        return false;
    }
    return !co_is(base, DG_CO_SLOT) || co_type(base) == co_type(object) ||
           (co_size(base) == 4u && co_size(object) == 4u);
}

/* A value that the base counts on without having room for it: the file's own. */
static bool is_lent(const struct dg_co_object *base)
{
    return co_is(base, DG_CO_W) && !co_is(base, DG_CO_SLOT) && co_hook(base) == NULL;
}

/* As the base has it; the largest value is the largest one of the object's own type. */
static uint32_t lent_default(const struct eds_maker *self, const struct dg_co_object *object,
                             const struct dg_co_object *base)
{
    const uint32_t own = dg_co_default(self->to->base, base);

    return own == dg_co_type_limits(base).max ? dg_co_type_limits(object).max : own;
}

/* @return how many rows; 0: nothing can be made of it */
static uint16_t make_row(struct eds_maker *self, struct eds_entry *entry, struct dg_co_row *row)
{
    const enum dg_co_type type = row_type_of(entry);
    struct dg_co_object base;

    *row = (struct dg_co_row){.key = entry->key};
    if (type == DG_CO_TYPE_COUNT && !dg_co_is_long(entry)) {
        dg_co_note_lack(&self->in, entry, "DataType", "is left out: it has no such type",
                        "a data type of CiA 301, 0x1 to 0x1B");
        return 0;
    }
    if (entry->access == 0) {
        dg_co_note_entry(&self->in, entry, "AccessType", "is missing: read only",
                         "ro, wo, rw, rwr, rww or const");
        entry->access = DG_CO_R;
    }
    if (dg_co_is_long(entry)) {
        return dg_co_make_long(self, entry, row);
    }
    if (type == DG_CO_STRING) {
        make_string(self, entry, row);
        return 1;
    }
    row->flags = (uint16_t)((uint32_t)type << 12);
    const bool known = dg_co_find_base(self, entry, &base);
    const struct dg_co_object object = object_of(row);
    if (known && is_lent(&base)) {
        make_plain(self, entry, row, lent_default(self, &object, &base));
        self->to->plain--;
        self->to->bound++;
    } else if (known && is_alike(&base, &object)) {
        bind_row(self, entry, &base, row);
    } else {
        note_plain(self, entry, known);
        make_plain(self, entry, row, entry->rank == EDS_COMPACT ? entry->compact : 0);
    }
    return 1;
}

void dg_co_make_rows(struct eds_maker *self)
{
    struct dg_co_dictionary *to = &self->to->device.dictionary;
    uint16_t count = 0;

    for (size_t i = 0; i < self->in.count; i++) {
        struct dg_co_row *row = &self->rows[count];
        const uint16_t made = make_row(self, &self->in.entries[i], row);
        if (made > 0 && (count == 0 || (row[-1].key ^ row->key) >> 16 != 0)) {
            self->to->objects++;
        }
        count = (uint16_t)(count + made);
    }
    to->rows = self->rows;
    to->count = count;
    to->power = 1;
    while (2u * to->power <= count) {
        to->power = (uint16_t)(2u * to->power);
    }
}

/* Those that no walk over the stack's own rows of a device that is whole meets. */
static bool is_hidden(const struct dg_co_object *object)
{
    const bool tpdo = (object->index & 0xFDFCu) == 0x1800u && (object->index & 3u) != 0;

    return co_is(object, DG_CO_SLOT) && (tpdo || object->index >= 0x2000) &&
           (tpdo || object->slot >= DG_CO_SLOT_APPLICATION);
}

/* Values of the base: what the file has stands behind and has the last word. */
uint16_t dg_co_hide_rows(const struct dg_co_device *base, struct dg_co_row *to)
{
    struct dg_co_object object = dg_co_first();
    uint16_t count = 0;

    do {
        if (!is_hidden(&object)) {
            continue;
        }
        if (to != NULL) { /* any value of its type */
            to[count] = *object.row;
            to[count].key = DG_CO_KEY(object.index, object.sub);
            to[count].slot = object.slot;
            to[count].flags &= (uint16_t) ~(DG_CO_FIGURE | DG_CO_RW);
            to[count].initial = dg_co_default(base, &object);
            to[count].hook = 0;
        }
        count++;
    } while (dg_co_next(base, &object));
    return count;
}
