/* SPDX-License-Identifier: MIT */
/*
 * A client: its session, and what the handlers of its commands share.
 */
#include "control_private.h"

#include "drehgeber/version.h"

struct dg_rig *dg_control_rig_of(const struct dg_scpi *self)
{
    const struct dg_control *control = self->setup.ctx;

    return control->rig;
}

struct dg_encoder *dg_control_selected(const struct dg_scpi *self)
{
    struct dg_rig *rig = dg_control_rig_of(self);
    struct dg_encoder *encoder = rig->encoders[self->selected];

    if (rig->ops->look != NULL) {
        rig->ops->look(rig, encoder, self->now);
    }
    return encoder;
}

void dg_control_changed(struct dg_scpi *self)
{
    struct dg_rig *rig = dg_control_rig_of(self);
    struct dg_encoder *encoder = dg_control_selected(self);

    dg_rig_watch(rig, encoder);
    rig->ops->changed(rig, encoder, self->now);
}

void dg_control_refuse(struct dg_scpi *self, int code, const char *text)
{
    char detail[CONTROL_DETAIL_SIZE];
    struct dg_text to = dg_text_in(detail, sizeof detail);

    dg_text_add(&to, dg_control_selected(self)->name);
    dg_text_add(&to, ": ");
    dg_text_add(&to, text);
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

const struct dg_rig_ops *dg_control_ops_of(const struct dg_scpi *self)
{
    return dg_control_rig_of(self)->ops;
}

static const struct dg_scpi_commands *commands(const struct dg_scpi *self, size_t index)
{
    const struct dg_rig *rig = dg_control_rig_of(self);

    if (index == 0) {
        return &dg_control_commands;
    }
    if (index <= rig->instrument_count) {
        return &rig->instruments[index - 1u]->commands;
    }
    return index == rig->instrument_count + 1u ? rig->courses : NULL;
}

static void forward(void *ctx, const char *bytes, size_t n)
{
    const struct dg_control *self = ctx;

    self->write(self->ctx, bytes, n);
}

/* A name no model has stands for several. */
static const char *model_name_of(const struct dg_rig *rig)
{
    return rig->encoder_count == 1 ? rig->encoders[0]->model->name : "rig";
}

void dg_control_init(struct dg_control *self, struct dg_rig *rig,
                     void (*write)(void *ctx, const char *bytes, size_t n), void *ctx)
{
    static const struct dg_scpi_ops ops = {
        .commands = commands,
        .write = forward,
        .reset = dg_control_reset,
        .settled = dg_control_settled,
    };
    const struct dg_scpi_setup setup = {
        .ops = &ops,
        .ctx = self,
        .idn = self->idn,
    };
    struct dg_text idn = dg_text_in(self->idn, sizeof self->idn);

    dg_text_add(&idn, "drehgeber,");
    dg_text_add(&idn, model_name_of(rig));
    dg_text_add(&idn, ",0," DG_VERSION);
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
