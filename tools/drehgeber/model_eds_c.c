/* SPDX-License-Identifier: MIT */
/*
 * The encoder of an EDS file as C: its rows, its cells and its memory as constants. What behaves is
 * in the library: rows have the name of their value and that of their hook.
 */
#define _GNU_SOURCE
#include "model_eds_c.h"

#include <inttypes.h>
#include <stdio.h>

#include "drehgeber/drehgeber.h"
#include "run.h"

/* Nothing that a file says leads into the regions behind the base's. */
#define BASE_REGIONS (DG_CO_REGION_APPLICATION + 3)

/* In the order of bits of enum dg_co_flags. */
static const char flag_letters[] = "RWMISVCGEXLF";
_Static_assert((int)DG_CO_FIGURE == 1 << (sizeof flag_letters - 2u), "a letter for each");

static const char *const type_names[DG_CO_TYPE_COUNT] = {
    [DG_CO_I8] = "I8",   [DG_CO_I16] = "I16", [DG_CO_I32] = "I32",       [DG_CO_U8] = "U8",
    [DG_CO_U16] = "U16", [DG_CO_U32] = "U32", [DG_CO_STRING] = "STRING",
};

#define STACK_VALUE(name) [DG_CO_VALUE_##name] = "DG_CO_VALUE_" #name,
#define PROFILE_VALUE(name) [DG_CIA406_VALUE_##name] = "DG_CIA406_VALUE_" #name,
static const char *const value_names[] = {DG_CO_VALUES(STACK_VALUE)
                                              DG_CIA406_VALUES(PROFILE_VALUE)};

static const char *const hook_names[DG_CO_ROW_HOOK_COUNT] = {
    [DG_CO_HOOK_NONE] = "DG_CO_HOOK_NONE", [DG_CO_HOOK_BASE] = "DG_CO_HOOK_BASE",
    [DG_CO_HOOK_CELL] = "DG_CO_HOOK_CELL", [DG_CO_HOOK_FOLLOWS] = "DG_CO_HOOK_FOLLOWS",
    [DG_CO_HOOK_KEEP] = "DG_CO_HOOK_KEEP",
};

static const struct {
    const struct dg_co_device *device;
    const char *name;
} bases[] = {
    {&dg_cia406_any, "dg_cia406_any"},
    {&dg_cia406_singleturn, "dg_cia406_singleturn"},
    {&dg_cia406_multiturn, "dg_cia406_multiturn"},
};

const struct dg_cia406_file *model_eds_of(const struct dg_device *device)
{
    const struct dg_cia406_model *model = dg_cia406_model_of(device);
    return model != NULL && model->device->whole
               ? (const struct dg_cia406_file *)(const void *)model->device
               : NULL;
}

static const char *base_of(const struct dg_co_file *file)
{
    for (size_t i = 0; i < DG_COUNT(bases); i++) {
        if (bases[i].device == file->base) {
            return bases[i].name;
        }
    }
    return NULL;
}

/* ---------------------------------------------------------------- rows */

static void put_flags(uint32_t flags)
{
    const char *between = "";
    for (uint32_t i = 0; flag_letters[i] != '\0'; i++) {
        if ((flags >> i & 1u) != 0) {
            (void)printf("%s%c", between, flag_letters[i]);
            between = " | ";
        }
    }
    (void)fputs(between[0] == '\0' ? "0" : "", stdout);
}

static void put_row(const struct dg_co_row *row, enum dg_co_row_hook hook)
{
    (void)printf("    DG_CO_ROW(0x%04" PRIX32 ", %" PRIu32 ", %" PRIu32 ", DG_CO_%s, ",
                 row->key >> 16, row->key >> 8 & 0xFFu, row->key & 0xFu,
                 type_names[row->flags >> 12]);
    put_flags(row->flags & 0x0FFFu);
    (void)printf(", %s, 0x%" PRIX32 ", %" PRIu32 ", %s),\n",
                 (row->flags & DG_CO_SLOT) != 0 ? value_names[row->slot] : "0", row->initial,
                 row->key >> 4 & 0xFu, hook_names[hook]);
}

static void put_rows(const struct dg_co_file *file, const char *symbol)
{
    const struct dg_co_device *device = &file->device;
    const struct dg_co_row *hidden = device->dictionary.rows - device->hidden;
    (void)printf("static const struct dg_co_row %s_rows[] = {\n", symbol);
    for (uint16_t i = 0; i < device->hidden; i++) {
        put_row(&hidden[i], DG_CO_HOOK_NONE);
    }
    for (uint16_t i = 0; i < device->dictionary.count; i++) {
        put_row(&device->dictionary.rows[i], dg_co_row_hook_of(file, i));
    }
    (void)fputs("};\n", stdout);
}

/* @return how many limits or texts the rows name, the first one included */
static uint32_t count_named(const struct dg_co_dictionary *from, bool texts)
{
    uint32_t count = 0;
    for (uint16_t i = 0; i < from->count; i++) {
        const struct dg_co_row *row = &from->rows[i];
        const bool is = texts ? row->flags >> 12 == DG_CO_STRING : (row->key & 0xF0u) != 0;
        const uint32_t number = texts ? row->initial : row->key >> 4 & 0xFu;
        count = is && number >= count ? number + 1u : count;
    }
    return count;
}

/* ---------------------------------------------------------------- tables */

static void put_limits(const struct dg_co_limits *limits, uint32_t count, const char *symbol)
{
    (void)printf("static const struct dg_co_limits %s_limits[] = {\n", symbol);
    for (uint32_t i = 0; i < count; i++) {
        (void)printf("    {0x%" PRIX32 ", 0x%" PRIX32 "},\n", limits[i].min, limits[i].max);
    }
    (void)fputs("};\n", stdout);
}

static void put_cells(const struct dg_co_file *file, const char *symbol)
{
    (void)printf("static const struct dg_co_cell %s_cells[] = {\n", symbol);
    for (uint16_t i = 0; i < file->cell_count; i++) {
        const struct dg_co_cell *cell = &file->cells[i];
        (void)printf("    {DG_CO_KEY(0x%04" PRIX32 ", %" PRIu32 "), 0x%" PRIX32 ", {0x%" PRIX32
                     ", 0x%" PRIX32 "}, %s, DG_CO_%s},\n",
                     cell->key >> 16, cell->key >> 8 & 0xFFu, cell->initial, cell->limits.min,
                     cell->limits.max, cell->follows ? "true" : "false", type_names[cell->type]);
    }
    (void)fputs("};\n", stdout);
}

static void put_strings(const char *const *strings, uint32_t count, const char *symbol)
{
    (void)printf("static const char *const %s_strings[] = {\n", symbol);
    for (uint32_t i = 0; i < count; i++) {
        (void)fputs("    ", stdout);
        model_put_text(strings[i]);
        (void)fputs(",\n", stdout);
    }
    (void)fputs("};\n", stdout);
}

static void put_rates(const struct dg_co_device *device, const char *symbol)
{
    (void)printf("static const uint16_t %s_kbaud[] = {", symbol);
    for (uint8_t i = 0; i < device->kbaud_count; i++) {
        (void)printf("%s%u", i == 0 ? "" : ", ", device->kbaud[i]);
    }
    (void)fputs("};\n", stdout);
}

/* Bus parameters as delivered, and the regions of the memory. */
static void put_regions(const struct dg_co_file *file, const char *symbol)
{
    const struct dg_store_layout *layout = &file->layout;
    const uint32_t serial = 0;
    uint8_t bus[3];
    layout->regions[DG_CO_REGION_BUS].defaults(&serial, bus);
    (void)printf("static void %s_bus(const void *ctx, uint8_t *out)\n{\n    (void)ctx;\n", symbol);
    for (size_t i = 0; i < DG_COUNT(bus); i++) {
        (void)printf("    out[%zu] = %u;\n", i, bus[i]);
    }
    (void)printf("}\n\nstatic const struct dg_store_region %s_regions[] = {\n"
                 "    DG_CO_STORE_REGIONS(%s_bus),\n    DG_CIA406_STORE_REGIONS(%u),\n",
                 symbol, symbol, layout->regions[DG_CO_REGION_APPLICATION].size);
    for (uint8_t i = BASE_REGIONS; i < layout->region_count; i++) {
        const struct dg_store_region *region = &layout->regions[i];
        (void)printf("    {\"%s\", %u, %s, 0, NULL},\n", region->name, region->size,
                     region->check == DG_STORE_CHECKED ? "DG_STORE_CHECKED" : "DG_STORE_RAW");
    }
    (void)fputs("};\n", stdout);
}

/* ---------------------------------------------------------------- the device */

static void put_eds_device(const struct dg_co_file *file, const char *symbol, bool limits,
                           bool strings)
{
    const struct dg_co_device *device = &file->device;
    (void)fputs("        .device = {\n            .name = ", stdout);
    model_put_text(device->name);
    (void)printf(",\n            .dictionary = {&%s_rows[%u], %u, %u, ", symbol, device->hidden,
                 device->dictionary.count, device->dictionary.power);
    (void)printf(limits ? "%s_limits" : "NULL", symbol);
    (void)printf(", dg_co_row_hooks},\n            .whole = true,\n            .hidden = %u,\n",
                 device->hidden);
    (void)printf("            .kbaud = %s_kbaud,\n            .kbaud_count = %u,\n"
                 "            .save_ms = %u,\n",
                 symbol, device->kbaud_count, device->save_ms);
    (void)fputs("            .causes = dg_cia406_causes,\n"
                "            .cause_count = DG_CIA406_CAUSES,\n",
                stdout);
    if (strings) {
        (void)printf("            .strings = %s_strings,\n", symbol);
    }
    (void)printf("            .device_type = 0x%" PRIX32 ",\n            .vendor_id = 0x%" PRIX32
                 ",\n            .product_code = 0x%" PRIX32 ",\n            .revision = 0x%" PRIX32
                 ",\n",
                 device->device_type, device->vendor_id, device->product_code, device->revision);
    (void)printf("            .layout = &%s_file.file.layout,\n"
                 "            .reset = dg_co_reset_file,\n"
                 "            .sample = dg_co_sample_file,\n"
                 "            .step = dg_co_step_file,\n        },\n",
                 symbol);
}

static void put_file(const struct dg_co_file *file, const char *symbol)
{
    const struct dg_store_layout *layout = &file->layout;
    (void)printf("        .base = &%s,\n        .profile = %u,\n", base_of(file), file->profile);
    (void)printf("        .layout = {0x%08" PRIX32 ", %u, %u, %s_regions},\n", layout->id,
                 layout->journal_size, layout->region_count, symbol);
    if (file->cell_count > 0) {
        (void)printf("        .cells = %s_cells,\n        .cell_count = %u,\n", symbol,
                     file->cell_count);
    }
    (void)printf("        .kept = %u,\n        .node_id = %u,\n        .serial = %" PRIu32
                 ",\n        .cells_at = sizeof(struct dg_cia406),\n        .vendor = ",
                 file->kept, file->node_id, file->serial);
    model_put_text(file->vendor);
    (void)fputs(",\n    },\n", stdout);
}

int model_eds_check(const struct dg_cia406_file *self, const char *path)
{
    for (uint16_t i = 0; i < self->file.device.dictionary.count; i++) {
        const struct dg_co_row *row = &self->file.device.dictionary.rows[i];
        const uint32_t key = row->key;
        const bool served = (row->flags & DG_CO_RW) != 0; /* by rows, and by nothing behind them */
        if (!served || dg_co_row_hook_of(&self->file, i) == DG_CO_ROW_HOOK_COUNT) {
            lx_complain("%s: C has no row for %04" PRIX32 "h:%" PRIu32 "; leave it out", path,
                        key >> 16, key >> 8 & 0xFFu);
            return EXIT_USAGE;
        }
    }
    return EXIT_OK;
}

void model_eds_put(const struct dg_cia406_file *self, const char *symbol)
{
    const struct dg_co_file *file = &self->file;
    const uint32_t limits = count_named(&file->device.dictionary, false);
    const uint32_t strings = count_named(&file->device.dictionary, true);
    (void)fputs("/* As dg_co_row.flags has them. */\nenum { DG_CO_SHORT_FLAGS };\n\n", stdout);
    put_rows(file, symbol);
    if (limits > 0) {
        put_limits(file->device.dictionary.limits, limits, symbol);
    }
    if (file->cell_count > 0) {
        put_cells(file, symbol);
    }
    if (strings > 0) {
        put_strings(file->device.strings, strings, symbol);
    }
    put_rates(&file->device, symbol);
    put_regions(file, symbol);
    (void)printf("\nstatic const struct dg_cia406_file %s_file = {\n    .file = {\n", symbol);
    put_eds_device(file, symbol, limits > 0, strings > 0);
    put_file(file, symbol);
    (void)printf("    .steps = %" PRIu32 ",\n    .turns = %" PRIu32
                 ",\n    .model = {.turns = %" PRIu32 ", .device = &%s_file.file.device},\n};\n",
                 self->steps, self->turns, self->model.turns, symbol);
}
