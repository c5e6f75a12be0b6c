/* SPDX-License-Identifier: MIT */
/* Pieces that the screen of `top` is made of. */
#ifndef DREHGEBER_TOOL_TOP_DRAW_H
#define DREHGEBER_TOOL_TOP_DRAW_H

#include <ncurses.h>

#define TOP_CELL_MAX 512

enum top_pair {
    TOP_PAIR_GOOD = 1,
    TOP_PAIR_BAD,
    TOP_PAIR_WARNING,
};

static inline int top_at_least(int value, int least)
{
    return value > least ? value : least;
}

static inline int top_at_most(int value, int most)
{
    return value < most ? value : most;
}

/* Colours of the terminal that was just switched over, if it has some and the user wants them
   (NO_COLOR, no-color.org). */
void top_draw_begin(void);

/* A colour; bold where there is none. */
attr_t top_colour(enum top_pair pair);

/* At most `width` columns of a text, the last one '~' when that is not all of it. */
void top_put(int y, int x, int width, const char *text);
void top_put_with(attr_t look, int y, int x, int width, const char *text);

/* "bus:on err:off" as BUS:on ERR:off, each in its colour. */
void top_put_leds(int y, int x, int width, const char *leds);

/* How much of `text` goes into a line of `width` columns: up to a blank, if there is one. */
int top_line_length(const char *text, int width);

#endif
