/* SPDX-License-Identifier: MIT */
/*
 * A client: its session, and what the handlers of its commands share.
 */
#include "inside.h"

struct dg_rig *dg_control_rig(const struct dg_scpi *self)
{
    const struct dg_control *control = self->setup.ctx;

    return control->rig;
}

struct dg_encoder *dg_control_encoder(const struct dg_scpi *self)
{
    return dg_control_rig(self)->encoders[self->selected];
}

void dg_control_changed(struct dg_scpi *self)
{
    struct dg_rig *rig = dg_control_rig(self);

    rig->ops->changed(rig, dg_control_encoder(self), self->now);
}

void dg_control_refuse(struct dg_scpi *self, int code, const char *text)
{
    char detail[CONTROL_DETAIL_SIZE];
    struct control_text to = dg_control_text(detail, sizeof detail);

    dg_control_append(&to, dg_control_encoder(self)->name);
    dg_control_append(&to, ": ");
    dg_control_append(&to, text);
    dg_scpi_raise(self, code, detail);
}

bool dg_control_name(struct dg_scpi *self, char to[CONTROL_NAME_MAX])
{
    return dg_scpi_text(self, to, CONTROL_NAME_MAX);
}

void dg_control_put_none(struct dg_scpi *self, size_t count)
{
    if (count == 0) {
        dg_scpi_put_string(self, "");
    }
}

static void forward(void *ctx, const char *bytes, size_t n)
{
    const struct dg_control *self = ctx;

    self->write(self->ctx, bytes, n);
}

/* A name no model has stands for several. */
static const char *model_of(const struct dg_rig *rig)
{
    return rig->encoder_count == 1 ? rig->encoders[0]->model->name : "rig";
}

void dg_control_init(struct dg_control *self, struct dg_rig *rig,
                     void (*write)(void *ctx, const char *bytes, size_t n), void *ctx)
{
    static const struct dg_scpi_ops ops = {
        .write = forward,
        .reset = dg_control_reset,
        .settled = dg_control_settled,
    };
    const struct dg_scpi_setup setup = {
        .commands = dg_control_commands,
        .command_count = dg_control_command_count,
        .ops = &ops,
        .ctx = self,
        .idn = self->idn,
    };
    struct control_text idn = dg_control_text(self->idn, sizeof self->idn);

    dg_control_append(&idn, "drehgeber,");
    dg_control_append(&idn, model_of(rig));
    dg_control_append(&idn, ",0," DG_VERSION);
    self->rig = rig;
    self->write = write;
    self->ctx = ctx;
    dg_scpi_init(&self->session, &setup);
}

size_t dg_control_rx(struct dg_control *self, dg_ns now, const char *bytes, size_t n)
{
    return dg_scpi_rx(&self->session, now, bytes, n);
}

dg_ns dg_control_step(struct dg_control *self, dg_ns now)
{
    return dg_scpi_step(&self->session, now);
}
