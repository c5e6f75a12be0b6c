/* SPDX-License-Identifier: MIT */
#include "top_dial.h"

#include <inttypes.h>
#include <ncurses.h>
#include <stdio.h>
#include <string.h>

#define UDEG_PER_DEG 1000000
#define UDEG_PER_MDEG 1000
#define UDEG_PER_TURN ((int64_t)360 * UDEG_PER_DEG)
#define FIGURES 10 /* column of the figures */

static const char *const faces[TOP_DIAL_HEIGHT] = {
    "  .---.  ", /* 0 deg: the middle of this line */
    " /     \\ ", "|   +   |", " \\     / ", "  '---'  ",
};

/*
 * The pointer: its tip on the rim at the character nearest to the angle, and half way there. A
 * character is about twice as high as wide.
 */
static const struct {
    int below_deg; /* from the row before on */
    char half;
    uint8_t half_y, half_x;
    uint8_t tip_y, tip_x;
} pointers[] = {
    {7, '|', 1, 4, 0, 4},   {20, '|', 1, 4, 0, 5},  {41, '/', 1, 5, 0, 6},   {73, '-', 2, 6, 1, 7},
    {107, '-', 2, 6, 2, 8}, {139, '-', 2, 6, 3, 7}, {160, '\\', 3, 5, 4, 6}, {173, '|', 3, 4, 4, 5},
    {187, '|', 3, 4, 4, 4}, {200, '|', 3, 4, 4, 3}, {221, '/', 3, 3, 4, 2},  {253, '-', 2, 2, 3, 1},
    {287, '-', 2, 2, 2, 0}, {319, '-', 2, 2, 1, 1}, {340, '\\', 1, 3, 0, 2}, {353, '|', 1, 4, 0, 3},
    {360, '|', 1, 4, 0, 4},
};

static void draw_pointer(int y, int x, int deg)
{
    size_t i = 0;
    while (deg >= pointers[i].below_deg) {
        i++;
    }
    (void)mvaddch(y + pointers[i].half_y, x + pointers[i].half_x, (chtype)pointers[i].half);
    (void)mvaddch(y + pointers[i].tip_y, x + pointers[i].tip_x, (chtype)'@' | A_BOLD);
}

static void draw_dial(const struct top_shaft *shaft, int y, int x, bool selected)
{
    for (int i = 0; i < TOP_DIAL_HEIGHT; i++) {
        (void)mvaddstr(y + i, x, faces[i]);
    }
    (void)attron(selected ? A_REVERSE : A_NORMAL);
    (void)mvaddnstr(y, x + FIGURES, shaft->name, TOP_DIAL_WIDTH - FIGURES - 1);
    (void)attroff(A_REVERSE);
    if (shaft->encoder == TOP_NONE) {
        (void)mvaddstr(y + 1, x + FIGURES, "no encoder");
    }
    if (!shaft->known) {
        return;
    }
    const int64_t rest = (shaft->udeg % UDEG_PER_TURN + UDEG_PER_TURN) % UDEG_PER_TURN;
    const int64_t turns = (shaft->udeg - rest) / UDEG_PER_TURN;
    draw_pointer(y, x, (int)(rest / UDEG_PER_DEG));
    (void)mvprintw(y + 1, x + FIGURES, "%d.%03d deg", (int)(rest / UDEG_PER_DEG),
                   (int)(rest % UDEG_PER_DEG / UDEG_PER_MDEG));
    (void)mvprintw(y + 2, x + FIGURES, "%" PRId64 " turns", turns);
    (void)mvprintw(y + 3, x + FIGURES, "%.3f rpm", (double)shaft->mrpm / 1000.0);
}

void top_dial_words(const struct top_shaft *shaft, char *to, size_t size)
{
    if (!shaft->known) {
        (void)snprintf(to, size, "%s", shaft->name);
        return;
    }
    const int64_t rest = (shaft->udeg % UDEG_PER_TURN + UDEG_PER_TURN) % UDEG_PER_TURN;
    (void)snprintf(to, size, "%s  %" PRId64 " turns %d.%03d deg  %.3f rpm", shaft->name,
                   (shaft->udeg - rest) / UDEG_PER_TURN, (int)(rest / UDEG_PER_DEG),
                   (int)(rest % UDEG_PER_DEG / UDEG_PER_MDEG), (double)shaft->mrpm / 1000.0);
}

void top_dial_draw_all(const struct top_view *view, int y, int rows)
{
    const size_t in_row = (size_t)(COLS / TOP_DIAL_WIDTH);
    const size_t page = in_row * (size_t)rows;
    const size_t selected =
        view->selected < view->encoder_count ? view->encoders[view->selected].shaft : TOP_NONE;
    const size_t first = selected == TOP_NONE ? 0 : selected / page * page;
    for (size_t i = 0; i < page && first + i < view->shaft_count; i++) {
        draw_dial(&view->shafts[first + i], y + (int)(i / in_row) * TOP_DIAL_HEIGHT,
                  (int)(i % in_row) * TOP_DIAL_WIDTH, first + i == selected);
    }
}
