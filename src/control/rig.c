/* SPDX-License-Identifier: MIT */
/*
 * What hosts and commands do with encoders alike: power, faults, deadlines.
 */
#include "control_private.h"

struct dg_fault_target dg_encoder_target(const struct dg_encoder *self)
{
    return (struct dg_fault_target){
        .stack = self->kind->stack,
        .world = self->world,
        .layout = self->nvm.ops != NULL ? self->kind->layout(self) : NULL,
        .nvm = self->nvm,
        .singleturn = self->kind->singleturn(self),
    };
}

int dg_encoder_power(struct dg_encoder *self, dg_ns now, bool on)
{
    self->kind->power_off(self);
    return on ? self->kind->power_on(self, now) : DG_OK;
}

dg_ns dg_rig_step(struct dg_rig *self, dg_ns now)
{
    dg_ns next = DG_NEVER;

    for (size_t i = 0; i < self->encoder_count; i++) {
        struct dg_encoder *encoder = self->encoders[i];
        const struct dg_fault_target target = dg_encoder_target(encoder);
        const bool due = control_due(&encoder->faults, now);
        next = dg_earliest(next, dg_fault_step(&encoder->faults, &target, now));
        if (due) {
            self->ops->changed(self, encoder, now);
        }
    }
    return next;
}
