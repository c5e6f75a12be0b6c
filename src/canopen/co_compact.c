/* SPDX-License-Identifier: MIT */
/*
 * What an EDS file has no sections for (CiA 306): sub-indices of an object with CompactSubObj, and
 * PDOs. CompactPDO says which sub-indices of the communication parameters all of them have,
 * NrOfTXPDO and NrOfRXPDO how many there are. A section that there is for one has the last word.
 */
#include "co_file.h"

#define PDOS_MAX 512u
#define ENTRIES 8u
#define SUBS 6u /* of communication parameters, without sub-index 0 */

/* ------------------------------------------------------------ objects */

/* CompactSubObj=N: sub-index 0, and N of the object's type. */
static void expand_object(struct eds_reader *self, struct eds_entry object)
{
    for (uint32_t sub = 0; sub <= object.compact; sub++) {
        struct eds_entry *entry =
            dg_co_add_entry(self, object.key | sub << 8, EDS_COMPACT, object.line);
        if (entry == NULL) {
            return;
        }
        entry->type = sub == 0 ? DG_CO_U8 : object.type;
        entry->access = sub == 0 ? DG_CO_R | DG_CO_CONST : object.access;
        entry->compact = sub == 0 ? object.compact : 0;
        entry->map = sub != 0 && object.map;
        if (sub != 0) {
            entry->initial = object.initial;
            entry->low = object.low;
            entry->high = object.high;
        }
    }
}

static void expand_all(struct eds_reader *self)
{
    const size_t count = self->count;

    for (size_t i = 0; i < count && !self->out; i++) {
        const struct eds_entry *entry = &self->entries[self->count - count + i];
        if (entry->rank == EDS_OBJECT && entry->compact != 0) {
            expand_object(self, *entry);
        }
    }
}

/* ------------------------------------------------------------ PDOs */

/* clang-format off */
#define SPAN(text) {text, sizeof(text) - 1u}
/* Of CiA 301's predefined connection set; a PDO behind these is switched off. */
#define PREDEFINED 4u
static const struct eds_span rpdo_ids[PREDEFINED + 1u] = {
    SPAN("$NODEID+0x200"), SPAN("$NODEID+0x300"), SPAN("$NODEID+0x400"), SPAN("$NODEID+0x500"),
    SPAN("0x80000000"),
};
static const struct eds_span tpdo_ids[PREDEFINED + 1u] = {
    SPAN("$NODEID+0x180"), SPAN("$NODEID+0x280"), SPAN("$NODEID+0x380"), SPAN("$NODEID+0x480"),
    SPAN("0x80000000"),
};
/* clang-format on */

static void add_sub(struct eds_reader *self, uint32_t index, uint32_t sub, uint16_t type,
                    struct eds_span initial)
{
    struct eds_entry *entry = dg_co_add_entry(self, DG_CO_KEY(index, sub), EDS_COMPACT, 0);

    if (entry != NULL) {
        entry->type = type;
        entry->access = DG_CO_RW;
        entry->initial = initial;
    }
}

/* Bit 0 stands for sub-index 1. */
static void add_parameters(struct eds_reader *self, uint32_t index, struct eds_span cob_id)
{
    static const uint8_t types[SUBS] = {DG_CO_U32, DG_CO_U8,  DG_CO_U16,
                                        DG_CO_U8,  DG_CO_U16, DG_CO_U8};
    static const char digits[] = "0123456";
    uint32_t highest = 0;

    for (uint32_t sub = 1; sub <= SUBS; sub++) {
        if ((self->info.compact_pdo >> (sub - 1u) & 1u) != 0) {
            add_sub(self, index, sub, types[sub - 1u],
                    sub == 1 ? cob_id : (struct eds_span){"", 0});
            highest = sub;
        }
    }
    add_sub(self, index, 0, DG_CO_U8, (struct eds_span){&digits[highest], 1});
    if (!self->out) {
        self->entries->access = DG_CO_R | DG_CO_CONST;
    }
}

static void add_pdos(struct eds_reader *self, uint32_t first, uint32_t count,
                     const struct eds_span *ids)
{
    for (uint32_t n = 0; n < count && n < PDOS_MAX && !self->out; n++) {
        add_parameters(self, first + n, ids[n < PREDEFINED ? n : PREDEFINED]);
        for (uint32_t sub = 0; sub <= ENTRIES; sub++) {
            add_sub(self, first + 0x200u + n, sub, sub == 0 ? DG_CO_U8 : DG_CO_U32,
                    (struct eds_span){"", 0});
        }
    }
}

void dg_co_expand_entries(struct eds_reader *self)
{
    expand_all(self);
    if (self->info.compact_pdo != 0) {
        add_pdos(self, 0x1400, self->info.rpdos, rpdo_ids);
        add_pdos(self, 0x1800, self->info.tpdos, tpdo_ids);
    }
}
