/* SPDX-License-Identifier: MIT */
/*
 * A node whose bytes have come from elsewhere: its pointers anew.
 */
#include "co_od.h"
#include "co_pdo.h"

/* Row of an entry of 1A00h, NULL for an unused one. */
static const struct dg_co_object *row_of(const struct dg_co_node *self, uint32_t entry)
{
    enum dg_co_abort abort;

    return entry != 0 ? co_find(self, (uint16_t)(entry >> 16), (uint8_t)(entry >> 8), &abort)
                      : NULL;
}

/* The rows that were mapped are those of the first entries that are used. */
static void find_mapped_rows(struct dg_co_node *self, uint8_t n)
{
    struct dg_co_tpdo *tpdo = &self->tpdo[n];
    uint8_t found = 0;

    for (uint8_t i = 0; i < DG_CO_MAPPED_MAX && found < tpdo->mapped_count; i++) {
        const struct dg_co_object *row = row_of(self, self->value[CO_TPDO(n, CO_PDO_ENTRIES) + i]);
        if (row != NULL) {
            tpdo->mapped[found++] = row;
        }
    }
    tpdo->mapped_count = found;
}

static void find_rows(struct dg_co_node *self)
{
    enum dg_co_abort abort;

    /* Of a download that is under way; otherwise nobody looks at it. */
    self->sdo.object = co_find(self, self->sdo.index, self->sdo.sub, &abort);
    for (uint8_t n = 0; n < DG_CO_TPDOS; n++) {
        find_mapped_rows(self, n);
    }
}

void dg_co_attach(struct dg_co_node *self, const struct dg_co_setup *setup)
{
    self->setup = setup != NULL ? *setup : (struct dg_co_setup){0};
    self->store.nvm = self->setup.nvm;
    self->store.layout = setup != NULL ? setup->device->layout : NULL;
    self->sdo.object = NULL;
    for (uint8_t n = 0; n < DG_CO_TPDOS; n++) {
        for (uint8_t i = 0; i < DG_CO_MAPPED_MAX; i++) {
            self->tpdo[n].mapped[i] = NULL;
        }
    }
    if (setup != NULL) {
        find_rows(self);
    }
}
