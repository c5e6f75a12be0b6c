/* SPDX-License-Identifier: MIT */
/* Lines of a plan. */
#include "clocked.h"

#include <stdlib.h>

static const struct lx_clocked_protocol *protocol_of(const struct lx_station *station)
{
    return lx_stack_of(station->plan->model)->clocked;
}

/* All have to speak the protocol of the first one. @return it, or NULL with `error` */
static const struct lx_clocked_protocol *choose(const struct lx_bus_setup *setup,
                                                struct lx_error *error)
{
    const struct lx_clocked_protocol *first = protocol_of(setup->stations[0]);
    for (size_t i = 0; i < setup->count; i++) {
        const struct lx_plan_encoder *encoder = setup->stations[i]->plan;
        if (first == NULL || protocol_of(setup->stations[i]) != first) {
            (void)lx_fail(error, "%s cannot be on this wire", encoder->model->name);
            (void)lx_stands(error, setup->plan->file, encoder->line);
            return NULL;
        }
        if (i == first->encoders_max) {
            (void)lx_fail(error, "this wire is full: at most %zu encoders is right",
                          first->encoders_max);
            (void)lx_stands(error, setup->plan->file, encoder->line);
            return NULL;
        }
    }
    return first;
}

struct lx_clocked *lx_clocked_make(const struct lx_bus_setup *setup, enum lx_clocked_master master,
                                   struct lx_error *error)
{
    const struct lx_clocked_protocol *protocol = choose(setup, error);
    if (protocol == NULL) {
        return NULL;
    }
    struct lx_clocked *self = calloc(1, protocol->size);
    if (self == NULL) {
        (void)lx_fail(error, "no memory for %zu encoders", setup->count);
        return NULL;
    }
    protocol->init(self);
    self->protocol = protocol;
    for (size_t i = 0; i < setup->count; i++) {
        if (protocol->place(self, setup, i, master, error) != 0) {
            free(self);
            return NULL;
        }
    }
    return self;
}

int lx_clocked_check_rate(const struct lx_clocked *self, uint32_t hz, struct lx_error *error)
{
    return self->protocol->check_rate == NULL ? 0 : self->protocol->check_rate(self, hz, error);
}

int lx_clocked_open(struct lx_clocked *self, const struct lx_bus_setup *setup, size_t index,
                    dg_ns now, struct lx_error *error)
{
    return self->protocol->open(self, setup, index, now, error);
}

void lx_clocked_close(struct lx_clocked *self)
{
    if (self != NULL) {
        self->protocol->close(self);
        free(self);
    }
}

dg_ns lx_clocked_hint(struct lx_clocked *self, const struct lx_say *say, const char *name,
                      dg_ns now)
{
    dg_ns due = DG_NEVER;
    const char *text = self->ops->hint != NULL ? self->ops->hint(self, now, &due) : NULL;
    if (text != NULL) {
        lx_note(say, "%s: %s", name, text);
    }
    return due;
}

void lx_clocked_offer(const struct lx_clocked *self, const struct lx_bus_setup *setup)
{
    for (size_t i = 0; i < setup->count && self->protocol->offer != NULL; i++) {
        self->protocol->offer(setup->stations[i]);
    }
}
