/* SPDX-License-Identifier: MIT */
/*
 * A node whose bytes have come from elsewhere: its pointers anew, and what to look at before.
 */
#include "co_block.h"
#include "co_od.h"

void dg_co_attach(struct dg_co_node *self, const struct dg_co_setup *setup)
{
    self->setup = setup != NULL ? *setup : (struct dg_co_setup){0};
    self->store.nvm = self->setup.nvm;
    self->store.layout = setup != NULL ? setup->device->layout : NULL;
    /* Of a download that is under way; otherwise nobody looks at it. */
    self->sdo.object.row = NULL;
    self->sdo.object.dictionary = NULL;
    if (setup != NULL) {
        struct dg_co_object *object = &self->sdo.object;
        (void)dg_co_find(setup->device, DG_CO_KEY(object->index, object->sub), object);
    }
}

static bool values_fit(const struct dg_co_node *self)
{
    struct dg_co_object object = dg_co_first();
    bool good = true;

    do {
        const bool slot = co_is(&object, DG_CO_SLOT);
        good = good && (!slot || dg_co_in_range(&object, self->value[object.slot]));
    } while (dg_co_next(self->setup.device, &object));
    return good;
}

/* @return its bytes in a TPDO, or more than one has */
static uint8_t mapped_size(const struct dg_co_device *device, uint16_t number)
{
    const struct dg_co_dictionary *half = co_numbered_in(device, number);

    if ((number & 0x7FFFu) >= half->count) {
        return UINT8_MAX;
    }
    const struct dg_co_object object = co_object(half, co_row_in(half, number));
    return co_is(&object, DG_CO_MAP | DG_CO_R) ? co_size(&object) : UINT8_MAX;
}

/* One that is not valid is mapped anew before it is. */
static bool tpdo_fits(const struct dg_co_node *self, uint8_t n)
{
    const struct dg_co_tpdo *tpdo = &self->tpdo[n];
    uint32_t length = 0;

    if (!tpdo->valid || self->state == DG_CO_OFF) {
        return (self->sync_mask >> n & 1u) == 0 || self->state == DG_CO_OFF;
    }
    for (uint8_t i = 0; i < tpdo->mapped_count && i < DG_CO_MAPPED_MAX; i++) {
        length += mapped_size(self->setup.device, tpdo->mapped[i]);
    }
    return tpdo->mapped_count <= DG_CO_MAPPED_MAX && length == tpdo->length && length <= 8;
}

/* A block upload counts what was sent since the last acknowledgement from `done` on. */
static bool sdo_fits(const struct dg_co_node *self)
{
    const struct dg_co_sdo *sdo = &self->sdo;
    const uint32_t sent = sdo->state == DG_CO_SDO_BLOCK_UPLOAD ? SDO_SEGMENT * sdo->seqno : 0;
    const bool comes = sdo->state == DG_CO_SDO_DOWNLOAD || sdo->state == DG_CO_SDO_BLOCK_DOWNLOAD ||
                       sdo->state == DG_CO_SDO_BLOCK_DOWNLOAD_END;
    struct dg_co_object object = dg_co_first();

    if (sdo->state == DG_CO_SDO_IDLE) {
        return sdo->deadline == DG_NEVER;
    }
    if (sdo->state == DG_CO_SDO_DEVICE) { /* which looks for itself */
        return true;
    }
    if (comes) {
        const uint32_t key = DG_CO_KEY(sdo->object.index, sdo->object.sub);
        return dg_co_find(self->setup.device, key, &object) == DG_CO_OK &&
               co_is(&object, DG_CO_W) && object.slot == sdo->object.slot &&
               sdo->length <= SDO_SEGMENT * sdo->seqno + 4u;
    }
    return sdo->length <= DG_CO_STRING_MAX && sdo->done + sent < sdo->length + SDO_SEGMENT;
}

static bool state_fits(const struct dg_co_node *self)
{
    const struct dg_co_device *device = self->setup.device;

    switch (self->state) {
    case DG_CO_OFF:
        return true;
    case DG_CO_BOOT:
    case DG_CO_STOPPED:
    case DG_CO_OPERATIONAL:
    case DG_CO_PRE_OPERATIONAL:
        return self->now != DG_NEVER && dg_co_kbaud(device, self->bit_rate) != 0 &&
               dg_co_kbaud(device, self->lss.bit_rate) != 0 && values_fit(self) && sdo_fits(self);
    }
    return false;
}

bool dg_co_fits(const struct dg_co_node *self)
{
    const uint32_t causes = DG_CO_CAUSES + self->setup.device->cause_count;
    bool good = state_fits(self) && self->active_causes >> causes == 0 &&
                self->sync_mask >> DG_CO_TPDOS == 0;

    for (uint8_t n = 0; n < DG_CO_TPDOS; n++) {
        good = good && tpdo_fits(self, n);
    }
    return good;
}
