/* SPDX-License-Identifier: MIT */
/*
 * Courses at work. rig.c calls them by a pointer, so that an image without any links none of this.
 */
#include "control_private.h"

/* It may begin before there is a device, and with it a fault. */
static void put_course_value(struct dg_encoder *encoder, size_t quantity, int32_t value)
{
    const struct dg_quantity *row = &dg_quantities[quantity];

    if (encoder->device == NULL) {
        dg_quantity_set(row, encoder->world, value);
        return;
    }
    const struct dg_fault_target target = dg_encoder_target(encoder);
    dg_control_put_behind(&encoder->faults, &target, row->offset, value);
}

static void step_course(struct dg_rig_course *self, struct dg_encoder *encoder, dg_ns now)
{
    const dg_ns since = dg_elapsed(now, self->start);
    int32_t value;

    if (dg_course_at(&self->course, since, &value)) {
        put_course_value(encoder, self->quantity, value);
    }
    self->due = dg_after(self->start, dg_course_next(&self->course, since));
    if (self->due == DG_NEVER) {
        dg_control_unfollow(encoder, self->quantity);
    }
}

int dg_rig_follow(struct dg_rig *self, struct dg_encoder *encoder, struct dg_rig_course *course,
                  dg_ns now)
{
    const int result = dg_course_check(&course->course);

    if (result != DG_OK) {
        return result;
    }
    dg_control_unfollow(encoder, course->quantity);
    course->start = now;
    course->step = step_course;
    course->next = encoder->courses;
    encoder->courses = course;
    step_course(course, encoder, now);
    dg_rig_watch(self, encoder);
    return DG_OK;
}

void dg_rig_unfollow(struct dg_rig *self, struct dg_encoder *encoder, size_t quantity)
{
    dg_control_unfollow(encoder, quantity);
    dg_rig_watch(self, encoder);
}
