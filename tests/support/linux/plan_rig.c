/* SPDX-License-Identifier: MIT */
#include "plan_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

void plan_rig_begin(struct dg_plan *self, const char *name, const struct dg_plan_wire_kind *kind,
                    const char *where)
{
    struct lx_error error;
    assert_int_equal(lx_plan_make(self, &error), 0);
    assert_int_equal(dg_plan_add_shaft(self, "shaft", NULL), 0);
    assert_int_equal(dg_plan_add_wire(self, name, kind, where), 0);
}

void plan_rig_free(struct dg_plan *self)
{
    for (size_t i = 0; i < self->wire_count; i++) {
        lx_plan_free_settings(&self->wires[i].settings);
    }
    for (size_t i = 0; i < self->encoder_count; i++) {
        lx_plan_free_settings(&self->encoders[i].settings);
    }
    lx_plan_free(self);
}
