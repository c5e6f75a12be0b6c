/* SPDX-License-Identifier: MIT */
/* Shafts as dials. */
#ifndef DREHGEBER_TOOL_TOP_DIAL_H
#define DREHGEBER_TOOL_TOP_DIAL_H

#include "top_view.h"

#define TOP_DIAL_WIDTH 26 /* with the figures beside it */
#define TOP_DIAL_HEIGHT 5

/* As many as fit into `rows` rows of them from line `y` on, that of the selected encoder's shaft
   among them. */
void top_dial_draw_all(const struct top_view *view, int y, int rows);

#endif
