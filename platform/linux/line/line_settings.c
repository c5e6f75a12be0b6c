/* SPDX-License-Identifier: MIT */
#include "line_settings.h"

const char *const lx_line_own_any[2] = {"own", "any"};
