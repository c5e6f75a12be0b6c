/* SPDX-License-Identifier: MIT */
/*
 * A device from the entries of an EDS file: identity, dictionary, memory.
 *
 *   memory   | hidden rows | rows | cells | limits | hooks | strings | longs | free | entries |
 */
#include <string.h>

#include "co_file.h"
#include "drehgeber/crc.h"
#include "drehgeber/text.h"

/* Longest key of an object. */
#define KEY_MAX 16u
#define LAYOUT_SEED 0x45445331u

static const struct eds_place nowhere;

/* ------------------------------------------------------------ entries */

static const struct eds_entry *find_entry(const struct eds_reader *in, uint32_t key)
{
    size_t first = 0;
    size_t last = in->count;

    while (first < last) {
        const size_t middle = first + (last - first) / 2u;
        if (in->entries[middle].key < key) {
            first = middle + 1u;
        } else {
            last = middle;
        }
    }
    return first < in->count && in->entries[first].key == key ? &in->entries[first] : NULL;
}

/* The default of an object as a number; 0 without one. */
static uint32_t default_of(const struct eds_reader *in, uint32_t key)
{
    const struct eds_entry *entry = find_entry(in, key);

    return entry != NULL ? dg_co_take_number(entry->initial).value : 0;
}

/* Of entries with one key the first stays, with the default that a [xxxxValue] gives it. An array
 * or record is none of its own, nor is a value of nothing. */
static bool is_row(struct eds_entry *entry, size_t same)
{
    if (same > 1 && entry[same - 1u].rank == EDS_VALUE && !entry->configured) {
        entry->initial = entry[same - 1u].initial;
    }
    if (entry->rank != EDS_OBJECT) {
        return entry->rank != EDS_VALUE;
    }
    return entry->object == 0 ? entry->type != 0 : entry->object == DG_CO_VAR || entry->object == 2;
}

/* "1018sub1", in `to` */
static size_t name_entry(const struct eds_entry *entry, char to[10])
{
    static const char digits[] = "0123456789ABCDEF";
    const uint32_t sub = entry->key >> 8 & 0xFFu;
    size_t n = 4;

    for (uint8_t i = 0; i < 4; i++) {
        to[i] = digits[entry->key >> (28u - 4u * i) & 0xFu];
    }
    if (entry->rank == EDS_OBJECT) {
        return n;
    }
    memcpy(&to[n], "sub", 3);
    n += 3;
    if (sub >= 0x10u) {
        to[n++] = digits[sub >> 4];
    }
    to[n++] = digits[sub & 0xFu];
    return n;
}

/* Of a key of an entry; `name` is room for the section's. */
static struct eds_place key_place_of(const struct eds_entry *entry, const char *key, char name[10])
{
    return (struct eds_place){
        .line = entry->line,
        .section = {name, name_entry(entry, name)},
        .key = {key, dg_text_length(key, KEY_MAX)},
    };
}

void dg_co_note_entry(struct eds_reader *self, const struct eds_entry *entry, const char *key,
                      const char *what, const char *right)
{
    char name[10];
    const struct eds_place place = key_place_of(entry, key, name);

    dg_co_note_place(self, &place, what, right);
}

void dg_co_note_lack(struct eds_reader *self, const struct eds_entry *entry, const char *key,
                     const char *what, const char *right)
{
    char name[10];
    struct eds_place place = key_place_of(entry, key, name);

    place.lacks = true;
    dg_co_note_place(self, &place, what, right);
}

/* Whether both are of one object. */
static bool is_of(const struct eds_entry *a, const struct eds_entry *b)
{
    return (a->key ^ b->key) >> 16 == 0;
}

/* What becomes nothing is told, unless it is the head of others. */
static void note_dropped(struct eds_reader *in, const struct eds_entry *entry, bool head)
{
    const bool known = entry->object <= DG_CO_RECORD && entry->object != 1 && entry->object != 3;

    if (entry->rank == EDS_VALUE) {
        dg_co_note_entry(in, entry, "", "a default of no sub-index: left out", NULL);
    } else if (!known) {
        dg_co_note_entry(in, entry, "ObjectType", "is none: left out", "0x7, 0x8 or 0x9");
    } else if (!head) {
        dg_co_note_entry(in, entry, entry->object == 0 ? "DataType" : "",
                         entry->object == 0 ? "is missing: left out" : "has no sub-index: left out",
                         NULL);
    }
}

static void merge_entries(struct eds_reader *in)
{
    size_t kept = 0;
    size_t same = 1;

    for (size_t i = 0; i < in->count; i += same) {
        struct eds_entry *entry = &in->entries[i];
        for (same = 1; i + same < in->count && entry[same].key == entry->key; same++) {
        }
        if (same > 1 && entry[1].rank == entry->rank && entry->rank != EDS_VALUE) {
            dg_co_note_entry(in, entry, "", "stands there twice: the first one counts", NULL);
        }
        if (is_row(entry, same)) {
            in->entries[kept++] = *entry;
        } else {
            note_dropped(in, entry, i + same < in->count && is_of(entry, &entry[same]));
        }
    }
    in->count = kept;
}

/* ------------------------------------------------------------ the device */

#define BUS_DEFAULT(n)                                                                             \
    static void bus_default_##n(const void *ctx, uint8_t *out)                                     \
    {                                                                                              \
        static const uint8_t bus[3] = {n, DG_CO_UNCONFIGURED, 0};                                  \
        (void)ctx;                                                                                 \
        memcpy(out, bus, sizeof bus);                                                              \
    }
BUS_DEFAULT(0)
BUS_DEFAULT(1)
BUS_DEFAULT(2)
BUS_DEFAULT(3)
BUS_DEFAULT(4)
BUS_DEFAULT(5)
BUS_DEFAULT(6)
BUS_DEFAULT(7)
BUS_DEFAULT(8)

/* The base's, else those that the file has, all without any. */
static void make_rates(struct eds_maker *self)
{
    const struct eds_info *info = &self->in.info;

    if (self->to->base->kbaud != NULL) {
        return;
    }
    uint16_t *kbaud = dg_co_keep_bytes(&self->in, EDS_RATES * sizeof *kbaud);

    for (uint8_t i = 0; i < EDS_RATES && kbaud != NULL; i++) {
        const bool there = info->rates == 0 || (info->rates >> i & 1u) != 0;
        kbaud[i] = there || dg_co_eds_kbaud[i] == info->kbaud ? dg_co_eds_kbaud[i] : 0;
    }
    self->to->device.kbaud = kbaud;
    self->to->device.kbaud_count = EDS_RATES;
}

/* The number of the bit rate as delivered: of a DCF, else the base's, else the lowest one. */
static uint8_t delivered_rate(const struct eds_maker *self, uint8_t base)
{
    const uint16_t *kbaud = self->to->device.kbaud;
    const uint16_t wanted = self->in.info.kbaud;
    uint8_t lowest = 0;

    for (uint8_t i = self->to->device.kbaud_count; i-- > 0;) {
        if (i >= EDS_RATES) {
            continue; /* no default of it here */
        }
        if (wanted != 0 && kbaud[i] == wanted) {
            return i;
        }
        lowest = kbaud[i] != 0 ? i : lowest;
    }
    return kbaud[base] != 0 ? base : lowest;
}

/* The same on any machine. @return the CRC `id` with `count` words more */
static uint32_t add_words(uint32_t id, const uint32_t *words, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint8_t bytes[4];
        dg_store_le32(bytes, words[i]);
        id = dg_crc32(id, bytes, sizeof bytes);
    }
    return id;
}

/* What a memory of this file looks like: an image of another one is foreign, also of one that let a
 * cell have values that this one does not. */
static uint32_t layout_id(const struct eds_maker *self)
{
    const struct dg_co_device *device = &self->to->device;
    uint32_t id = add_words(LAYOUT_SEED,
                            (const uint32_t[]){device->device_type, device->vendor_id,
                                               device->product_code, device->revision},
                            4);

    for (uint16_t i = 0; i < self->to->kept; i++) {
        const struct dg_co_cell *cell = &self->cells[i];
        id = add_words(id, (const uint32_t[]){cell->key, cell->limits.min, cell->limits.max}, 3);
    }
    for (uint16_t i = 0; i < self->to->long_count; i++) {
        const struct dg_co_long *one = &self->longs[i];
        const uint32_t words[] = {one->key | one->kind, one->most};
        id = one->kept ? add_words(id, words, DG_COUNT(words)) : id;
    }
    return id;
}

/* Of the store behind the base's regions. */
static const char *cells_name(struct eds_reader *in, uint32_t n)
{
    const char text[] = {'v', 'a', 'l', 'u', 'e', 's', (char)('a' + n)};

    return dg_co_keep_text(in, (struct eds_span){text, sizeof text}, sizeof text);
}

/* Bus parameters as delivered: the base's, unless the file has another bit rate. */
static void choose_bus(struct eds_maker *self, struct dg_store_region *region)
{
    static void (*const bus_defaults[EDS_RATES])(const void *ctx, uint8_t *out) = {
        bus_default_0, bus_default_1, bus_default_2, bus_default_3, bus_default_4,
        bus_default_5, bus_default_6, bus_default_7, bus_default_8,
    };
    const uint32_t serial = 0;
    uint8_t bus[3];

    region->defaults(&serial, bus);
    const uint8_t rate = delivered_rate(self, bus[0] < EDS_RATES ? bus[0] : 0);
    region->defaults = rate != bus[0] ? bus_defaults[rate] : region->defaults;
}

/* The base's regions, and as many as the cells take. */
static void make_file_layout(struct eds_maker *self)
{
    const struct dg_store_layout *base = self->to->base->layout;
    struct dg_co_file *to = self->to;
    const uint32_t own = to->long_kept > 0 ? 2u : 1u;
    const uint32_t room = (DG_STORE_REGIONS_MAX - own - base->region_count) * EDS_CELLS_A_REGION;
    struct dg_store_region *regions =
        dg_co_keep_bytes(&self->in, DG_STORE_REGIONS_MAX * sizeof *regions);

    to->kept = to->cell_count < room ? to->cell_count : (uint16_t)room;
    if (self->in.out) {
        return;
    }
    memcpy(regions, base->regions, base->region_count * sizeof *regions);
    choose_bus(self, &regions[DG_CO_REGION_BUS]);
    uint8_t count = base->region_count;
    const uint32_t words = eds_word_count(to->kept, to->longs_kept);
    if (words > 0) {
        regions[count++] =
            (struct dg_store_region){.name = "objects", .size = (uint16_t)(4u * words)};
    }
    for (uint32_t n = 0; n * EDS_CELLS_A_REGION < to->kept; n++) {
        regions[count++] = (struct dg_store_region){
            .name = cells_name(&self->in, n),
            .size = (uint16_t)(4u * eds_cells_in(to->kept, n)),
            .check = DG_STORE_CHECKED,
        };
    }
    if (to->long_kept > 0) {
        regions[count++] = (struct dg_store_region){
            .name = "texts", .size = (uint16_t)(2u * (EDS_COPY_HEAD + to->long_kept))};
    }
    to->layout = *base;
    to->layout.id = layout_id(self);
    to->layout.regions = regions;
    to->layout.region_count = count;
    to->device.layout = &to->layout;
}

static uint32_t identity_entry_of(const struct eds_maker *self, uint8_t sub, uint32_t otherwise)
{
    const uint32_t value = default_of(&self->in, DG_CO_KEY(0x1018, sub));

    return value != 0 ? value : otherwise;
}

/* Identity and functions, before there are rows. */
static void begin_device(struct eds_maker *self)
{
    const struct eds_info *info = &self->in.info;
    const uint32_t type = default_of(&self->in, DG_CO_KEY(0x1000, 0));
    const uint32_t vendor = identity_entry_of(self, 1, info->vendor_id);
    const uint32_t product = identity_entry_of(self, 2, info->product_code);
    const struct dg_co_device *base = self->ground->choose(type, vendor, product);

    *self->to = (struct dg_co_file){
        .device = *base,
        .base = base,
        .profile = self->ground->profile,
        .node_id = info->node_id,
        .serial = default_of(&self->in, DG_CO_KEY(0x1018, 4)),
        .cells_at = self->ground->cells_at,
    };
    struct dg_co_device *device = &self->to->device;
    device->figures = NULL;
    device->figure_count = 0;
    device->whole = true;
    device->device_type = type;
    device->vendor_id = vendor;
    device->product_code = product;
    device->revision = identity_entry_of(self, 3, info->revision);
    device->reset = dg_co_reset_file;
    device->name = dg_co_keep_text(&self->in, info->product, DG_CO_STRING_MAX);
    self->to->vendor = dg_co_keep_text(&self->in, info->vendor, DG_CO_STRING_MAX);
}

static size_t count_longs(const struct eds_reader *in)
{
    size_t count = 0;

    for (size_t i = 0; i < in->count; i++) {
        count += dg_co_is_long(&in->entries[i]) ? 1u : 0u;
    }
    return count;
}

/* Room for tables, as large as they can become. */
static bool make_table_room(struct eds_maker *self)
{
    struct dg_co_device *device = &self->to->device;
    const size_t count = self->in.count;
    const size_t longs = count_longs(&self->in);

    device->hidden = dg_co_hide_rows(self->to->base, NULL);
    struct dg_co_row *rows =
        dg_co_keep_bytes(&self->in, (device->hidden + count + longs) * sizeof *rows);
    self->cells = dg_co_keep_bytes(&self->in, count * sizeof *self->cells);
    self->limits = dg_co_keep_bytes(&self->in, EDS_LIMITS_MAX * sizeof *self->limits);
    self->hooks = dg_co_keep_bytes(&self->in, EDS_HOOKS_MAX * sizeof *self->hooks);
    self->strings = dg_co_keep_bytes(&self->in, count * sizeof *self->strings);
    self->longs = dg_co_keep_bytes(&self->in, longs * sizeof *self->longs);
    if (self->in.out) {
        return false;
    }
    (void)dg_co_hide_rows(self->to->base, rows);
    self->rows = rows + device->hidden;
    self->limit_count = 1;
    self->hook_count = 1;
    return true;
}

/* Behind the application's state: cells, then the rest. */
static void place_values(struct eds_maker *self)
{
    struct dg_co_file *to = self->to;
    const size_t cells = to->cell_count * sizeof(uint32_t);

    to->cells = self->cells;
    to->longs = self->longs;
    to->longs_at = to->cells_at + cells;
    to->more = cells;
    if (to->long_count > 0) {
        to->more += dg_co_place_longs(self->longs, to->long_count, &to->long_kept);
        to->device.refused = dg_co_serve_long;
    }
    for (uint16_t i = 0; i < to->long_count; i++) {
        const struct dg_co_long *one = &self->longs[i];
        to->longs_kept = (uint16_t)(to->longs_kept + (one->kept ? 1u : 0u));
        self->forgets = self->forgets || (!one->kept && eds_is_placed(one));
    }
}

static void note_whole(struct eds_maker *self)
{
    struct eds_reader *in = &self->in;
    const struct dg_co_file *to = self->to;

    if (in->info.listed != 0 && in->info.listed != in->objects) {
        dg_co_note_place(in, &nowhere,
                         "lists name other objects than there are sections: sections count", NULL);
    }
    if ((to->device.device_type & 0xFFFFu) != self->ground->profile) {
        const struct eds_place type = {.section = {"1000", 4}, .lacks = true};
        dg_co_note_place(in, &type, "another profile: its objects are values only", NULL);
    }
    if (to->kept < to->cell_count || self->forgets) {
        const struct eds_place place = {.lacks = true};
        dg_co_note_place(in, &place,
                         "more values than 1010h can keep: those behind are lost at power-off",
                         NULL);
    }
}

static int make_eds_device(struct eds_maker *self)
{
    struct dg_co_device *device = &self->to->device;

    merge_entries(&self->in);
    begin_device(self);
    if (!make_table_room(self)) {
        return DG_ERR_SPACE;
    }
    dg_co_make_rows(self);
    if (device->dictionary.count == 0) {
        return dg_co_refuse_text(&self->in, 0, "no object that can be read", "an EDS or DCF file");
    }
    device->dictionary.limits = self->limits;
    device->dictionary.hooks = self->hooks;
    device->strings = self->strings;
    place_values(self);
    make_rates(self);
    make_file_layout(self);
    note_whole(self);
    return self->in.out ? DG_ERR_SPACE : DG_OK;
}

int dg_co_read(struct dg_co_file *self, const struct dg_eds_setup *setup,
               const struct dg_co_ground *ground, struct dg_eds_note *error)
{
    uint8_t *memory = setup->memory;
    struct eds_maker maker = {
        .in = {.setup = setup, .error = error, .front = memory},
        .ground = ground,
        .to = self,
    };

    *self = (struct dg_co_file){.base = NULL};
    if (setup->size != sizeof *setup || memory == NULL) {
        return dg_co_refuse_text(&maker.in, 0, "not a setup of this version", NULL);
    }
    maker.in.back = memory + setup->memory_size / sizeof(uint64_t) * sizeof(uint64_t);
    int result = dg_co_scan_text(&maker.in);
    result = result != DG_OK ? result : make_eds_device(&maker);
    self->used = (size_t)(maker.in.front - memory);
    return result;
}

void dg_co_say_place(const struct dg_eds_note *note, struct dg_text *to)
{
    if (note->section[0] != '\0') {
        dg_text_add(to, "[");
        dg_text_add(to, note->section);
        dg_text_add(to, "]");
    }
    if (note->key[0] != '\0') {
        dg_text_add(to, note->section[0] != '\0' ? " " : "");
        dg_text_add(to, note->key);
        dg_text_add(to, note->value[0] != '\0' ? "=" : "");
        dg_text_add(to, note->value);
    }
}

enum dg_co_role dg_co_role_of(const struct dg_co_file *self, uint16_t n)
{
    const struct dg_co_object object = {.row = &self->device.dictionary.rows[n]};
    dg_co_hook *const hook = self->device.dictionary.hooks[object.row->hook];
    const struct dg_co_long *found = dg_co_find_long(self, object.row->key & 0xFFFFFF00u);

    if (found != NULL && found->bound.row != NULL) {
        return DG_CO_SIMULATED;
    }
    if (found != NULL) {
        return (found->access & DG_CO_W) != 0 ? DG_CO_STORES : DG_CO_CONSTANT;
    }
    if (hook == dg_co_hook_cell) {
        struct dg_co_object base;
        const bool own = (self->device.device_type & 0xFFFFu) == self->profile;
        return own && dg_co_find(self->base, object.row->key & 0xFFFFFF00u, &base) == DG_CO_OK &&
                       co_is(&base, DG_CO_W) && !co_is(&base, DG_CO_SLOT)
                   ? DG_CO_SIMULATED
                   : DG_CO_STORES;
    }
    return hook == dg_co_hook_follows || co_is(&object, DG_CO_CONST) ? DG_CO_CONSTANT
                                                                     : DG_CO_SIMULATED;
}
