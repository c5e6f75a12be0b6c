/* SPDX-License-Identifier: MIT */
/*
 * The functions of host.h that know all models, of a program whose models are strangers: what the
 * library has under these names is not linked then.
 */
#include "strangers.h"

#include <string.h>

#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/control.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/instrument.h"
#include "drehgeber/interbus.h"
#include "drehgeber/ssi.h"

/* A stranger, and what it behaves as. */
static const struct stranger {
    const char *model;
    const char *protocol;
    int medium;
    const struct dg_device *as;
    const struct dg_bus_side *side;
    const struct dg_instrument *instrument;
} strangers[] = {
    {STRANGER_CHARACTERS, "unknown-characters", DG_MEDIUM_CHARACTERS, &dg_s3684_rs485, &dg_hf_side,
     &dg_hf_instrument},
    {STRANGER_FRAMES, "unknown-frames", DG_MEDIUM_FRAMES, &dg_f3668, &dg_cia406_side,
     &dg_cia406_instrument},
    {STRANGER_EDGES, "unknown-edges", DG_MEDIUM_EDGES, &dg_ssi_25, &dg_ssi_side,
     &dg_ssi_instrument},
    {STRANGER_WORDS, "unknown-words", DG_MEDIUM_WORDS, &dg_ocd_ib_k3, &dg_ib_side,
     &dg_ib_instrument},
    {STRANGER_FUTURE, "unknown-future", DG_MEDIUM_COUNT, &dg_ssi_25, &dg_ssi_side,
     &dg_ssi_instrument},
};
#define STRANGER_COUNT DG_COUNT(strangers)

/* The objects that make a stranger known to handles. */
static struct made {
    struct dg_stack stack;
    struct dg_device device;
    struct dg_host_wire wire;
    struct dg_bus_side side;
    struct dg_instrument instrument;
} made[STRANGER_COUNT];

/* Protocols know their own models by the stack: they furnish the one that a stranger behaves as. */
static void furnish(void *settings, const struct dg_device *device)
{
    for (size_t i = 0; i < STRANGER_COUNT; i++) {
        if (device == &made[i].device) {
            strangers[i].side->wire->furnish(settings, strangers[i].as);
        }
    }
}

static struct made *make_stranger(const char *model)
{
    for (size_t i = 0; i < STRANGER_COUNT; i++) {
        const struct stranger *row = &strangers[i];
        struct made *self = &made[i];
        if (strcmp(row->model, model) != 0) {
            continue;
        }
        self->stack = *row->as->stack;
        self->stack.name = row->protocol;
        self->stack.medium = (enum dg_medium)row->medium;
        self->device = *row->as;
        self->device.name = row->model;
        self->device.stack = &self->stack;
        self->wire = *row->side->wire;
        self->wire.stack = &self->stack;
        self->wire.furnish = row->side->wire->furnish != NULL ? furnish : NULL;
        self->wire.uart = NULL; /* nor does it tell a data rate */
        self->side = *row->side;
        self->side.wire = &self->wire;
        self->instrument = *row->instrument;
        self->instrument.stack = &self->stack;
        return self;
    }
    return NULL;
}

/* None of them is a text. */
const struct dg_bus_side *dg_bus_side_of(const struct dg_device *model)
{
    (void)model;
    return NULL;
}

const struct dg_host_wire *dg_host_wire_of(const struct dg_device *model)
{
    (void)model;
    return NULL;
}

const char *dg_host_name(size_t index)
{
    return index < STRANGER_COUNT ? strangers[index].model : NULL;
}

size_t dg_host_size_of(const char *name)
{
    const struct made *self = make_stranger(name);

    return self != NULL ? dg_host_size(&self->device, &self->wire) : 0;
}

struct dg_host *dg_host_make(void *memory, size_t size, const char *name)
{
    const struct made *self = make_stranger(name);
    struct dg_host *host =
        self != NULL ? dg_host_init(memory, size, &self->device, &self->wire) : NULL;

    if (host != NULL) {
        dg_host_take_side(host, &self->side);
    }
    return host;
}

struct dg_host_panel *dg_host_panel_make(void *memory, size_t size, struct dg_host *host)
{
    return dg_host_panel_init(memory, size, host, &make_stranger(dg_host_model(host))->instrument);
}
