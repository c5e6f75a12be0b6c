/* SPDX-License-Identifier: MIT */
/*
 * INSTrument, POWer, STATe?, and *RST.
 */
#include "control_private.h"

void dg_control_encoders(struct dg_scpi *self)
{
    const struct dg_rig *rig = dg_control_rig_of(self);

    for (size_t i = 0; i < rig->encoder_count; i++) {
        dg_scpi_put_string(self, rig->encoders[i]->name);
    }
}

/* `a_b` without quotes is "a-b", unless there is an encoder of that name. */
static size_t find_encoder(struct dg_rig *rig, const char *name)
{
    size_t found = rig->encoder_count;

    if (rig->ops->find != NULL) {
        return rig->ops->find(rig, name);
    }
    for (size_t i = 0; i < rig->encoder_count; i++) {
        const char *other = rig->encoders[i]->name;
        if (dg_text_same(other, name, SIZE_MAX, dg_text_upper)) {
            return i;
        }
        if (found == rig->encoder_count && dg_control_same(other, name)) {
            found = i;
        }
    }
    return found;
}

void dg_control_select(struct dg_scpi *self)
{
    struct dg_rig *rig = dg_control_rig_of(self);
    char name[CONTROL_NAME_MAX];
    char detail[CONTROL_DETAIL_SIZE];

    if (!dg_control_name(self, name)) {
        return;
    }
    const size_t found = find_encoder(rig, name);
    if (found < rig->encoder_count) {
        self->selected = (uint32_t)found;
        return;
    }
    struct dg_text to = dg_text_in(detail, sizeof detail);
    dg_text_add(&to, name);
    dg_text_add(&to, ": no such encoder; INST:CAT? has their names");
    dg_scpi_raise(self, DG_SCPI_ILLEGAL, detail);
}

void dg_control_selection(struct dg_scpi *self)
{
    dg_scpi_put_string(self, dg_control_selected(self)->name);
}

void dg_control_model(struct dg_scpi *self)
{
    dg_scpi_put_string(self, dg_control_selected(self)->model->name);
}

void dg_control_wire(struct dg_scpi *self)
{
    struct dg_rig *rig = dg_control_rig_of(self);

    dg_scpi_put_string(self, rig->ops->wire(rig, dg_control_selected(self)));
}

/* Why an encoder stays off. */
static const char *reason(int result)
{
    return result == DG_ERR_BLANK ? "its EEPROM is blank; NVM:ERASe makes the delivery state"
                                  : "its EEPROM is another device's; NVM:ERASe makes it its own";
}

static void switch_power(struct dg_scpi *self, bool on)
{
    const int result = dg_encoder_power(dg_control_selected(self), self->now, on);

    if (result != DG_OK) {
        dg_control_refuse(self, DG_SCPI_HARDWARE, reason(result));
    }
    dg_control_changed(self);
}

void dg_control_power(struct dg_scpi *self)
{
    static const char *const words[] = {"OFF", "ON", "CYCLe", "0", "1"};
    enum { OFF, ON, CYCLE, ZERO };
    const struct dg_encoder *encoder = dg_control_selected(self);
    size_t word;

    if (!dg_scpi_word(self, words, DG_COUNT(words), &word)) {
        return;
    }
    if (dg_scpi_more(self)) { /* before anything happens */
        dg_scpi_raise(self, DG_SCPI_SUPERFLUOUS, NULL);
        return;
    }
    const bool on = word != OFF && word != ZERO;
    if (word == CYCLE || on != dg_encoder_powered(encoder)) {
        switch_power(self, on);
    }
}

void dg_control_powered(struct dg_scpi *self)
{
    const struct dg_encoder *encoder = dg_control_selected(self);

    dg_scpi_put_unsigned(self, dg_encoder_powered(encoder) ? 1 : 0);
}

static void put_common(const struct dg_encoder *encoder, struct dg_scpi *to)
{
    const bool powered = dg_encoder_powered(encoder);

    dg_state_number(to, "power", powered ? 1 : 0);
    dg_state_word(to, "mode", encoder->instrument->mode(encoder->device, to->now));
    if (powered) {
        dg_state_number(to, "position", encoder->model->stack->position(encoder->device, to->now));
    } else {
        dg_state_word(to, "position", "-");
    }
}

void dg_control_state(struct dg_scpi *self)
{
    struct dg_rig *rig = dg_control_rig_of(self);
    const struct dg_encoder *encoder = dg_control_selected(self);

    put_common(encoder, self);
    encoder->instrument->state(encoder->device, self->now, self);
    if (rig->ops->counters != NULL) {
        rig->ops->counters(rig, encoder, self);
    }
}

/* Every encoder in turn, as if it had been selected; shafts go on as they are. */
void dg_control_reset(struct dg_scpi *self)
{
    const struct dg_rig *rig = dg_control_rig_of(self);
    const uint32_t selected = self->selected;

    for (self->selected = 0; self->selected < rig->encoder_count; self->selected++) {
        const struct dg_encoder *encoder = dg_control_selected(self);
        dg_control_clear_all(self);
        dg_control_heal(self);
        if (dg_encoder_powered(encoder)) {
            dg_control_changed(self);
        } else {
            switch_power(self, true);
        }
    }
    self->selected = selected;
}
