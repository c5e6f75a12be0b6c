/* SPDX-License-Identifier: MIT */
#include "eleven_settings.h"

#include "trace_format.h"

#define LINE offsetof(struct lx_eleven_settings, line)

static const struct dg_key keys[] = {LX_LINE_KEYS(LINE)};

const struct lx_stack lx_eleven_stack = {
    .core = &dg_eleven_stack,
    .handle = &dg_eleven_wire,
    .trace = &(const struct lx_trace_kind){"eleven characters", {&lx_trace_uart}, false},
    .wire = "pty",
    .baud = DG_ELEVEN_BAUD,
    .own = {keys, DG_COUNT(keys)},
    .own_at = LINE,
    .own_size = sizeof(struct lx_line_settings),
    .usual = &lx_line_usual,
};
