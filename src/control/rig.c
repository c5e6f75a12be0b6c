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

/* ------------------------------------------------------------ courses */

struct dg_rig_course *dg_rig_course_of(const struct dg_encoder *encoder, size_t quantity)
{
    struct dg_rig_course *course = encoder->courses;

    while (course != NULL && course->quantity != quantity) {
        course = course->next;
    }
    return course;
}

void dg_control_unfollow(struct dg_encoder *encoder, size_t quantity)
{
    struct dg_rig_course **at = &encoder->courses;

    while (*at != NULL && (*at)->quantity != quantity) {
        at = &(*at)->next;
    }
    if (*at != NULL) {
        *at = (*at)->next;
    }
}

/* One that is over leaves the list. */
static void step_courses(struct dg_encoder *encoder, dg_ns now)
{
    struct dg_rig_course *course = encoder->courses;

    while (course != NULL) {
        struct dg_rig_course *next = course->next;
        if (course->due <= now) {
            course->step(course, encoder, now);
        }
        course = next;
    }
}

static dg_ns next_point(const struct dg_encoder *encoder)
{
    dg_ns next = DG_NEVER;

    for (const struct dg_rig_course *at = encoder->courses; at != NULL; at = at->next) {
        next = dg_earliest(next, at->due);
    }
    return next;
}

/* ------------------------------------------------------------ who waits for faults and courses */

/* Two heaps become one. */
static struct dg_encoder *join_encoders(struct dg_encoder *a, struct dg_encoder *b)
{
    if (a == NULL || b == NULL) {
        return a == NULL ? b : a;
    }
    struct dg_encoder *first = b->wait.until < a->wait.until ? b : a;
    struct dg_encoder *child = first == a ? b : a;

    child->wait.before = first;
    child->wait.next = first->wait.child;
    if (child->wait.next != NULL) {
        child->wait.next->wait.before = child;
    }
    first->wait.child = child;
    return first;
}

/* The first of a list, alone. */
static struct dg_encoder *pop_encoder(struct dg_encoder **list)
{
    struct dg_encoder *first = *list;

    if (first != NULL) {
        *list = first->wait.next;
        first->wait.next = NULL;
        first->wait.before = NULL;
    }
    return first;
}

/* Children whose parent goes: two by two, then all of these from the last one on. */
static struct dg_encoder *join_all(struct dg_encoder *list)
{
    struct dg_encoder *pairs = NULL;
    struct dg_encoder *whole = NULL;

    while (list != NULL) {
        struct dg_encoder *one = pop_encoder(&list);
        struct dg_encoder *pair = join_encoders(one, pop_encoder(&list));
        pair->wait.next = pairs;
        pairs = pair;
    }
    while (pairs != NULL) {
        whole = join_encoders(whole, pop_encoder(&pairs));
    }
    return whole;
}

static void take_out(struct dg_rig *self, struct dg_encoder *encoder)
{
    struct dg_rig_wait *wait = &encoder->wait;
    struct dg_encoder *children = join_all(wait->child);

    if (self->waits == encoder) {
        self->waits = children;
    } else {
        *(wait->before->wait.child == encoder ? &wait->before->wait.child
                                              : &wait->before->wait.next) = wait->next;
        if (wait->next != NULL) {
            wait->next->wait.before = wait->before;
        }
        self->waits = join_encoders(self->waits, children);
    }
    *wait = (struct dg_rig_wait){.waits = false};
}

void dg_rig_watch(struct dg_rig *self, struct dg_encoder *encoder)
{
    const dg_ns until = dg_earliest(dg_control_next_end(&encoder->faults), next_point(encoder));

    if (encoder->wait.waits) {
        take_out(self, encoder);
    }
    if (until != DG_NEVER) {
        encoder->wait = (struct dg_rig_wait){.until = until, .waits = true};
        self->waits = join_encoders(self->waits, encoder);
    }
}

dg_ns dg_rig_step(struct dg_rig *self, dg_ns now)
{
    while (self->waits != NULL && self->waits->wait.until <= now) {
        struct dg_encoder *encoder = self->waits;
        const struct dg_fault_target target = dg_encoder_target(encoder);
        if (self->ops->look != NULL) {
            self->ops->look(self, encoder, now);
        }
        step_courses(encoder, now);
        (void)dg_fault_step(&encoder->faults, &target, now);
        dg_rig_watch(self, encoder);
        self->ops->changed(self, encoder, now);
    }
    return self->waits == NULL ? DG_NEVER : self->waits->wait.until;
}
