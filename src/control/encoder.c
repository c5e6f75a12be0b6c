/* SPDX-License-Identifier: MIT */
/*
 * INSTrument, POWer, STATe?, and *RST.
 */
#include "inside.h"

void dg_control_encoders(struct dg_scpi *self, uint32_t argument)
{
    const struct dg_rig *rig = dg_control_rig(self);

    (void)argument;
    for (size_t i = 0; i < rig->encoder_count; i++) {
        dg_scpi_put_string(self, rig->encoders[i]->name);
    }
}

void dg_control_select(struct dg_scpi *self, uint32_t argument)
{
    const struct dg_rig *rig = dg_control_rig(self);
    char name[CONTROL_NAME_MAX];
    char detail[CONTROL_DETAIL_SIZE];

    (void)argument;
    if (!dg_control_name(self, name)) {
        return;
    }
    for (size_t i = 0; i < rig->encoder_count; i++) {
        if (dg_control_same(rig->encoders[i]->name, name)) {
            self->selected = (uint32_t)i;
            return;
        }
    }
    struct control_text to = dg_control_text(detail, sizeof detail);
    dg_control_append(&to, name);
    dg_control_append(&to, ": no such encoder; INST:CAT? has their names");
    dg_scpi_raise(self, DG_SCPI_ILLEGAL, detail);
}

void dg_control_selected(struct dg_scpi *self, uint32_t argument)
{
    (void)argument;
    dg_scpi_put_string(self, dg_control_encoder(self)->name);
}

void dg_control_model(struct dg_scpi *self, uint32_t argument)
{
    (void)argument;
    dg_scpi_put_string(self, dg_control_encoder(self)->model->name);
}

void dg_control_wire(struct dg_scpi *self, uint32_t argument)
{
    struct dg_rig *rig = dg_control_rig(self);

    (void)argument;
    dg_scpi_put_string(self, rig->ops->wire(rig, dg_control_encoder(self)));
}

/* Why an encoder stays off. */
static const char *reason(int result)
{
    return result == DG_ERR_BLANK ? "its EEPROM is blank; NVM:ERASe makes the delivery state"
                                  : "its EEPROM is another device's; NVM:ERASe makes it its own";
}

static void switch_power(struct dg_scpi *self, bool on)
{
    const int result = dg_encoder_power(dg_control_encoder(self), self->now, on);

    if (result != DG_OK) {
        dg_control_refuse(self, DG_SCPI_HARDWARE, reason(result));
    }
    dg_control_changed(self);
}

void dg_control_power(struct dg_scpi *self, uint32_t argument)
{
    static const char *const words[] = {"OFF", "ON", "CYCLe", "0", "1"};
    enum { OFF, ON, CYCLE, ZERO };
    const struct dg_encoder *encoder = dg_control_encoder(self);
    size_t word;

    (void)argument;
    if (!dg_scpi_word(self, words, sizeof words / sizeof words[0], &word)) {
        return;
    }
    if (dg_scpi_more(self)) { /* before anything happens */
        dg_scpi_raise(self, DG_SCPI_SUPERFLUOUS, NULL);
        return;
    }
    const bool on = word != OFF && word != ZERO;
    if (word == CYCLE || on != encoder->kind->powered(encoder)) {
        switch_power(self, on);
    }
}

void dg_control_powered(struct dg_scpi *self, uint32_t argument)
{
    const struct dg_encoder *encoder = dg_control_encoder(self);

    (void)argument;
    dg_scpi_put_unsigned(self, encoder->kind->powered(encoder) ? 1 : 0);
}

void dg_control_state(struct dg_scpi *self, uint32_t argument)
{
    struct dg_rig *rig = dg_control_rig(self);
    const struct dg_encoder *encoder = dg_control_encoder(self);

    (void)argument;
    encoder->kind->state(encoder, self->now, self);
    if (rig->ops->counters != NULL) {
        rig->ops->counters(rig, encoder, self);
    }
}

/* Every encoder in turn, as if it had been selected; shafts go on as they are. */
void dg_control_reset(struct dg_scpi *self)
{
    const struct dg_rig *rig = dg_control_rig(self);
    const uint32_t selected = self->selected;

    for (self->selected = 0; self->selected < rig->encoder_count; self->selected++) {
        const struct dg_encoder *encoder = dg_control_encoder(self);
        dg_control_clear_all(self);
        dg_control_heal(self);
        if (encoder->kind->powered(encoder)) {
            dg_control_changed(self);
        } else {
            switch_power(self, true);
        }
    }
    self->selected = selected;
}
