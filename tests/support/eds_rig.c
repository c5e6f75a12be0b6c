/* SPDX-License-Identifier: MIT */
#include "eds_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static void keep(void *ctx, const struct dg_eds_note *note)
{
    struct eds_rig *self = ctx;

    if (self->note_count < EDS_RIG_NOTES) {
        self->notes[self->note_count] = *note;
    }
    self->note_count++;
}

int eds_rig_read(struct eds_rig *self, const char *text, size_t n, size_t size)
{
    struct dg_eds_setup setup = {.size = sizeof setup, .text = text, .n = n, .note = keep};

    assert_true(size <= sizeof self->memory);
    setup.memory = self->memory;
    setup.memory_size = size;
    setup.ctx = self;
    self->note_count = 0;
    memset(&self->error, 0, sizeof self->error);
    return dg_cia406_read(&self->file, &setup, &self->error);
}

void eds_rig_read_text(struct eds_rig *self, const char *text)
{
    if (eds_rig_read(self, text, strlen(text), sizeof self->memory) != DG_OK) {
        fail_msg("%s: %s", self->error.section, self->error.what);
    }
}

void eds_rig_start(struct eds_rig *self, const char *text)
{
    const struct dg_co_device *device = &self->file.file.device;

    eds_rig_read_text(self, text);
    assert_true(self->file.device.more <= sizeof self->co.cells);
    co_rig_start_model(&self->co, &self->file.model);
    assert_int_equal(dg_co_burn_node_id(device, ram_nvm_port(&self->co.nvm), EDS_RIG_NODE), DG_OK);
    assert_int_equal(co_rig_power_on(&self->co), DG_OK);
    co_rig_forget(&self->co);
}

void eds_rig_power_cycle(struct eds_rig *self)
{
    dg_co_power_off(&self->co.node);
    assert_int_equal(co_rig_power_on(&self->co), DG_OK);
    co_rig_forget(&self->co);
}

bool eds_rig_is_noted(const struct eds_rig *self, const char *section, const char *what)
{
    for (size_t i = 0; i < self->note_count && i < EDS_RIG_NOTES; i++) {
        const struct dg_eds_note *note = &self->notes[i];
        if (strcmp(note->section, section) == 0 && strstr(note->what, what) != NULL) {
            return true;
        }
    }
    return false;
}
