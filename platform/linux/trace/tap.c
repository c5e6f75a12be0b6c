/* SPDX-License-Identifier: MIT */
#include "tap.h"

bool lx_tap_asked(const struct lx_tap *self)
{
    const struct lx_tap_listener *listener = self->first;
    while (listener != NULL && !listener->sincos) {
        listener = listener->next;
    }
    return listener != NULL;
}

/* A listener may leave while it is told. */
void lx_tap_tell(const struct lx_tap *self, const struct dg_tap_event *event)
{
    for (struct lx_tap_listener *listener = self->first; listener != NULL;) {
        struct lx_tap_listener *next = listener->next;
        if (event->kind != DG_TAP_SINCOS || listener->sincos) {
            listener->event(listener->ctx, event);
        }
        listener = next;
    }
}

void lx_tap_add(struct lx_tap *self, struct lx_tap_listener *listener)
{
    struct lx_tap_listener **end = &self->first;
    while (*end != NULL) {
        end = &(*end)->next;
    }
    listener->next = NULL;
    *end = listener;
}

void lx_tap_remove(struct lx_tap *self, struct lx_tap_listener *listener)
{
    for (struct lx_tap_listener **at = &self->first; *at != NULL; at = &(*at)->next) {
        if (*at == listener) {
            *at = listener->next;
            return;
        }
    }
}
