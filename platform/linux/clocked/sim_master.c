/* SPDX-License-Identifier: MIT */
#include "sim_master.h"

#include <stdio.h>

int lx_sim_master_name(const struct lx_sim_master *self, size_t encoder, char *text, size_t size)
{
    const struct lx_clocked *line = self->wire.line;
    return line->count == 1
               ? 0
               : snprintf(text, size, "%.32s: ", line->station[encoder]->control->name);
}

void lx_sim_master_note(const struct lx_sim_master *self, const char *text,
                        enum dg_severity severity)
{
    const struct dg_tap_event event = {
        .at = self->wire.now,
        .kind = DG_TAP_NOTE,
        .ours = true,
        .severity = severity,
        .note = text,
    };
    lx_tap_tell(self->tap, &event);
}

void lx_sim_master_init(struct lx_sim_master *self, const struct lx_tap *tap,
                        struct lx_clocked *line, const struct dg_plan_timing *timing, dg_ns now)
{
    self->tap = tap;
    lx_clocked_wire_init(&self->wire, line, timing, now);
}

void lx_sim_master_pause(struct lx_sim_master *self, dg_ns now)
{
    lx_clocked_listen(self->wire.line);
    lx_clocked_wire_pause(&self->wire, now);
}

/* Of the frame read last. */
static enum dg_severity severity_of(const struct lx_clocked *line, size_t encoder)
{
    struct lx_clocked_word word;
    if (line->protocol->judge(line, encoder) != LX_CLOCKED_GOOD) {
        return DG_SEVERITY_ERROR;
    }
    line->protocol->word(line, encoder, &word);
    if (word.error) {
        return DG_SEVERITY_ERROR;
    }
    return word.warning ? DG_SEVERITY_WARNING : DG_SEVERITY_OK;
}

void lx_sim_master_frame(struct lx_sim_master *self)
{
    struct lx_clocked *line = self->wire.line;
    lx_clocked_listen(line);
    line->protocol->read(line, &self->wire);
    for (size_t i = 0; lx_tap_on(self->tap) && i < line->count; i++) {
        char text[LX_SIM_NOTE_MAX];
        const int n = lx_sim_master_name(self, i, text, sizeof text);
        if (line->protocol->judge(line, i) == LX_CLOCKED_SILENT) {
            (void)snprintf(text + n, sizeof text - (size_t)n, "no answer");
        } else {
            line->protocol->note(line, &self->wire, i, text + n, sizeof text - (size_t)n);
        }
        lx_sim_master_note(self, text, severity_of(line, i));
    }
}
