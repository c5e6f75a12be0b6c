/* SPDX-License-Identifier: MIT */
/*
 * States that somebody has made: what a device goes by, and whether it fits together.
 */
#include <string.h>

#include "hiperface_private.h"

static const struct dg_stack_range ranges[] = {
    DG_STACK_RANGE(dg_hf, store.region_count, 0, DG_STORE_REGIONS_MAX),
    DG_STACK_BOOL(dg_hf, store.unapplied),
    DG_STACK_RANGE(dg_hf, line, 0, DG_HF_REPLY),
    DG_STACK_BOOL(dg_hf, frame_damaged),
    DG_STACK_RANGE(dg_hf, length, 0, DG_HF_FRAME_MAX + 1u),
    DG_STACK_RANGE(dg_hf, blocks, 0, HF_FIELDS_MAX),
    DG_STACK_RANGE(dg_hf, stack_count, 0, DG_HF_STACK_DEPTH),
};

/* Figures that were never read are 0. */
static bool position_fits(const struct dg_hf *device)
{
    const struct dg_hf_model figures = {
        .periods_per_turn = device->periods,
        .steps_per_period = device->steps,
        .turns = device->turns,
        .memory_blocks = 1,
    };

    return device->line == DG_HF_OFF ||
           (dg_hf_model_check(&figures) == DG_OK &&
            device->offset < (uint64_t)device->periods * device->steps * device->turns);
}

/* A reply is that of the frame in the buffer; who waits for nothing has no deadline. */
static bool line_fits(const struct dg_hf *device)
{
    struct dg_hf again = *device;

    if (device->line == DG_HF_OFF || device->line == DG_HF_IDLE) {
        return device->deadline == DG_NEVER;
    }
    if (device->line == DG_HF_REPLY) {
        dg_hf_check_frame(&again);
    }
    return again.verdict == device->verdict && again.command == device->command;
}

/* No key sets it, so the rows of keys do not look at it: it is the model's. */
static bool knows_commands_alike(const struct dg_hf_model *mine, const struct dg_hf_model *restored)
{
    return mine->lacks == restored->lacks;
}

static bool fits(const void *own, const void *settings, const void *device)
{
    const struct dg_hf_settings *delivered = own;
    struct dg_hf_settings mine;
    struct dg_hf self;

    memcpy(&mine, settings, sizeof mine);
    memcpy(&self, device, sizeof self);
    self.setup.model = &delivered->model; /* a frame is judged by it */
    return knows_commands_alike(&delivered->model, &mine.model) &&
           self.store.region_count <= dg_hf_layout_of(&delivered->model)->region_count &&
           dg_hf_model_check(&mine.model) == DG_OK && position_fits(&self) && line_fits(&self);
}

const struct dg_stack_check dg_hf_check = {ranges, DG_COUNT(ranges), fits};
