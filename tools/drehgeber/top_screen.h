/* SPDX-License-Identifier: MIT */
/* The screen of `top`: a header, dials, a table, what there is to say of one encoder, the keys. */
#ifndef DREHGEBER_TOOL_TOP_SCREEN_H
#define DREHGEBER_TOOL_TOP_SCREEN_H

#include <stdbool.h>
#include <stddef.h>

#include "top_view.h"

/* What lies over it. */
enum top_popup {
    TOP_POPUP_NONE,
    TOP_POPUP_HELP,
    TOP_POPUP_FAULTS,
};

struct top_screen {
    enum top_popup popup;
    size_t choice; /* line of the popup */
};

/* Colours and keys of the terminal that was just switched over. */
void top_screen_begin(void);

/* How many lines the table has, and which is the first one, so that the selected one is seen. */
void top_screen_arrange(struct top_view *view);

void top_screen_draw(const struct top_screen *self, const struct top_view *view);

#endif
