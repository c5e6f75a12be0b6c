/* SPDX-License-Identifier: MIT */
/*
 * A reply in characters, as events of several each:
 *
 *   |40|43| .. |..|  .. |           the second event begins at the 16th end of a character
 *   at             at
 */
#include <string.h>

#include "host_private.h"

#define RUN_MAX (sizeof((struct dg_host_event *)0)->data)

dg_ns dg_host_characters_ns(const struct dg_host_line *line, size_t count)
{
    const struct dg_host *self = (const struct dg_host *)(const void *)line;
    struct dg_host_uart uart;

    if (self->line.on_bus || self->refs.wire->uart == NULL) {
        return 0;
    }
    self->refs.wire->uart(line, false, &uart);
    return dg_host_uart_ns(&uart, (uint32_t)count);
}

void dg_host_say_reply(struct dg_host *self, const uint8_t *bytes, size_t n)
{
    struct dg_host_line *line = &self->line;
    struct dg_host_event event = {.kind = DG_HOST_BYTES,
                                  .id = (uint32_t)dg_host_characters_ns(line, 1)};
    const dg_ns start = line->until;

    for (size_t done = 0; done < n; done += event.length) {
        const size_t rest = n - done;
        event.at = dg_after(start, done == 0 ? 0 : dg_host_characters_ns(line, done));
        event.length = (uint8_t)(rest < RUN_MAX ? rest : RUN_MAX);
        memset(event.data, 0, sizeof event.data);
        memcpy(event.data, bytes + done, event.length);
        dg_host_deliver(self, &event);
    }
    line->until = dg_after(start, dg_host_characters_ns(line, n));
}

void dg_host_emit_reply(struct dg_host_line *line, const uint8_t *bytes, size_t n)
{
    struct dg_host *self = (struct dg_host *)(void *)line;

    line->until = line->now;
    if (self->refs.faults != NULL) {
        self->refs.faults->reply(self->refs.faults_ctx, bytes, n);
    } else {
        dg_host_say_reply(self, bytes, n);
    }
}
