/* SPDX-License-Identifier: MIT */
/*
 * TIME: what the host can do with its clock, if it can.
 */
#include "control_private.h"

#define SECOND_PLACES 9u
#define SCALE_PLACES 3u
#define SCALE_MAX_PERMILLE 1000000
#define STEP_MAX DG_S(86400)

static const struct dg_scpi_range scales = {DG_SCPI_PLAIN, SCALE_PLACES, 0, SCALE_MAX_PERMILLE};
static const struct dg_scpi_range spans = {DG_SCPI_TIME, 0, 0, (int64_t)STEP_MAX};

void dg_control_time(struct dg_scpi *self)
{
    dg_scpi_put_number(self, (int64_t)dg_elapsed(self->now, dg_control_rig_of(self)->origin),
                       SECOND_PLACES);
}

void dg_control_origin(struct dg_scpi *self)
{
    dg_scpi_put_number(self, (int64_t)dg_control_rig_of(self)->origin, SECOND_PLACES);
}

void dg_control_set_scale(struct dg_scpi *self)
{
    char detail[CONTROL_DETAIL_SIZE] = "";
    int64_t permille;

    if (!dg_scpi_number(self, &scales, &permille) ||
        !control_offered(self, dg_control_ops_of(self)->set_scale != NULL)) {
        return;
    }
    const int code =
        dg_control_ops_of(self)->set_scale(dg_control_rig_of(self), (uint32_t)permille, detail);
    dg_scpi_raise(self, code, detail);
}

void dg_control_scale(struct dg_scpi *self)
{
    if (control_offered(self, dg_control_ops_of(self)->scale != NULL)) {
        dg_scpi_put_number(self, dg_control_ops_of(self)->scale(dg_control_rig_of(self)),
                           SCALE_PLACES);
    }
}

void dg_control_step_time(struct dg_scpi *self)
{
    char detail[CONTROL_DETAIL_SIZE] = "";
    int64_t span;

    if (dg_scpi_number(self, &spans, &span) &&
        control_offered(self, dg_control_ops_of(self)->step != NULL)) {
        const int code =
            dg_control_ops_of(self)->step(dg_control_rig_of(self), (dg_ns)span, detail);
        dg_scpi_raise(self, code, detail);
        /* The rest of the line is done then. */
        self->now = code == DG_SCPI_NO_ERROR ? dg_after(self->now, (dg_ns)span) : self->now;
    }
}
