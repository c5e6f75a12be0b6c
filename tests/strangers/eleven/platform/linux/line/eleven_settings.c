/* SPDX-License-Identifier: MIT */
#include "eleven_settings.h"

#include "trace_format.h"

#define LINE offsetof(struct lx_eleven_settings, line)

static const struct dg_key keys[] = {LX_LINE_KEYS(LINE)};

static void defaults(void *settings, const struct dg_device *device)
{
    struct lx_eleven_settings *self = settings;
    *self = (struct lx_eleven_settings){
        .encoder = *(const struct dg_eleven_model *)device->model,
        .line = LX_LINE_USUAL,
    };
}

static const char title[] = "eleven characters";
static const struct lx_trace_format *const formats[] = {&lx_trace_uart, NULL};
static const struct lx_trace_kind trace = {title, formats, false};

const struct lx_stack lx_eleven_stack = {
    .core = &dg_eleven_stack,
    .title = title,
    .trace = &trace,
    .words = &dg_eleven_words,
    .wire = "pty",
    .line = LINE,
    .baud = DG_ELEVEN_BAUD,
    .own = {keys, DG_COUNT(keys)},
    .keys = &dg_eleven_keys,
    .settings_size = sizeof(struct lx_eleven_settings),
    .defaults = defaults,
};
