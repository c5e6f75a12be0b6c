/* SPDX-License-Identifier: MIT */
/* The table of encoders in `top`. */
#ifndef DREHGEBER_TOOL_TOP_TABLE_H
#define DREHGEBER_TOOL_TOP_TABLE_H

#include "top_view.h"

/* Its title in line `y`, and `view->rows` encoders from `view->first` on below it. On a narrow
   screen columns give way, the least wanted first; on a wide one there are more of them. */
void top_table_draw(const struct top_view *view, int y);

#endif
