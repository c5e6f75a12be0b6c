/* SPDX-License-Identifier: MIT */
/*
 * What hosts and commands do with encoders alike: power, faults, deadlines.
 */
#include "control_private.h"

struct dg_fault_target dg_encoder_target(const struct dg_encoder *self)
{
    const struct dg_stack *stack = self->model->stack;
    const void *model = stack->model(self->device); /* a host may have changed its figures */

    return (struct dg_fault_target){
        .instrument = self->instrument,
        .world = self->world,
        .layout = self->nvm.ops != NULL ? stack->layout(model) : NULL,
        .nvm = self->nvm,
        .singleturn = !stack->senses_multiturn(model),
    };
}

int dg_encoder_power(struct dg_encoder *self, dg_ns now, bool on)
{
    const struct dg_stack *stack = self->model->stack;

    stack->power_off(self->device);
    return on ? stack->power_on(self->device, now) : DG_OK;
}

bool dg_encoder_powered(const struct dg_encoder *self)
{
    return self->model->stack->powered(self->device);
}

int dg_encoder_format(const struct dg_encoder *self)
{
    const struct dg_stack_setup setup = {.model = self->model->stack->model(self->device),
                                         .world = self->world,
                                         .nvm = self->nvm,
                                         .serial = self->serial};

    return self->model->stack->format(&setup);
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
