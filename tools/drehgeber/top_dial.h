/* SPDX-License-Identifier: MIT */
/* Shafts as dials. */
#ifndef DREHGEBER_TOOL_TOP_DIAL_H
#define DREHGEBER_TOOL_TOP_DIAL_H

#include <stddef.h>

#include "top_view.h"

#define TOP_DIAL_WIDTH 26 /* with the figures beside it */
#define TOP_DIAL_HEIGHT 5

/* A shaft in one line: "main  2 turns 90.000 deg  60.000 rpm". */
void top_dial_words(const struct top_shaft *shaft, char *to, size_t size);

/* As many as fit into `rows` rows of them from line `y` on, that of the selected encoder's shaft
   among them. */
void top_dial_draw_all(const struct top_view *view, int y, int rows);

#endif
