/* SPDX-License-Identifier: MIT */
#include "line_settings.h"

const char *const lx_line_own_any[2] = {"own", "any"};

const struct lx_line_settings lx_line_usual = {.pace = true, .sincos = DG_MS(1)};
