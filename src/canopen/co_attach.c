/* SPDX-License-Identifier: MIT */
/*
 * A node whose bytes have come from elsewhere: its pointers anew.
 */
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
        (void)co_find(setup->device, DG_CO_KEY(object->index, object->sub), object);
    }
}
