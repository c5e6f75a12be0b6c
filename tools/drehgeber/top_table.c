/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "top_table.h"

#include <inttypes.h>
#include <ncurses.h>
#include <stdio.h>
#include <string.h>

#include "drehgeber/api.h"
#include "top_draw.h"

#define UDEG_PER_DEG 1000000
#define UDEG_PER_MDEG 1000
#define UDEG_PER_TURN ((int64_t)360 * UDEG_PER_DEG)

enum column {
    COLUMN_NAME,
    COLUMN_MODEL,
    COLUMN_WIRE,
    COLUMN_LEDS,
    COLUMN_MODE,
    COLUMN_POSITION,
    COLUMN_SHAFT,
    COLUMN_ANGLE,
    COLUMN_MORE,
    COLUMN_ERRORS,
    COLUMN_RATE,
    COLUMN_FAULTS,
    COLUMN_COUNT,
};

/* `least` is what a column needs to be of use, if its texts are not shorter. */
static const struct {
    const char *title;
    int least;
    int most;
} columns[COLUMN_COUNT] = {
    [COLUMN_NAME] = {"NAME", 8, 32},   [COLUMN_MODEL] = {"MODEL", 11, 11},
    [COLUMN_WIRE] = {"WIRE", 6, 28},   [COLUMN_LEDS] = {"LEDS", 17, 28},
    [COLUMN_MODE] = {"MODE", 11, 14},  [COLUMN_POSITION] = {"POSITION", 10, 10},
    [COLUMN_SHAFT] = {"SHAFT", 8, 32}, [COLUMN_ANGLE] = {"ANGLE", 11, 20},
    [COLUMN_MORE] = {"MORE", 32, 200}, [COLUMN_ERRORS] = {"ERRORS", 6, 20},
    [COLUMN_RATE] = {"FRM/S", 5, 7},   [COLUMN_FAULTS] = {"FAULTS", 6, 60},
};

/* Who gives way, and in the opposite order who gets what is left; the first ones are extras. */
#define EXTRAS 3u
static const enum column order[] = {
    COLUMN_MORE,   COLUMN_ANGLE, COLUMN_SHAFT,  COLUMN_MODEL, COLUMN_RATE,     COLUMN_WIRE,
    COLUMN_FAULTS, COLUMN_LEDS,  COLUMN_ERRORS, COLUMN_MODE,  COLUMN_POSITION, COLUMN_NAME,
};
_Static_assert(DG_COUNT(order) == COLUMN_COUNT, "each has its place");

static const struct top_shaft *encoder_shaft_of(const struct top_view *view,
                                                const struct top_encoder *encoder)
{
    return encoder->shaft == TOP_NONE ? NULL : &view->shafts[encoder->shaft];
}

static void rate_text(const struct top_encoder *encoder, char *to, size_t size)
{
    if (encoder->rate < 0) {
        (void)snprintf(to, size, "%s", encoder->known ? "-" : "");
    } else {
        (void)snprintf(to, size, "%" PRId64, encoder->rate);
    }
}

/* "2:90.000", turns and degrees. */
static void angle_text(const struct top_shaft *shaft, char *to, size_t size)
{
    if (shaft == NULL || !shaft->known) {
        (void)snprintf(to, size, "%s", "");
        return;
    }
    const int64_t rest = (shaft->udeg % UDEG_PER_TURN + UDEG_PER_TURN) % UDEG_PER_TURN;
    (void)snprintf(to, size, "%" PRId64 ":%03d.%03d", (shaft->udeg - rest) / UDEG_PER_TURN,
                   (int)(rest / UDEG_PER_DEG), (int)(rest % UDEG_PER_DEG / UDEG_PER_MDEG));
}

static void cell_text(const struct top_view *view, const struct top_encoder *encoder,
                      enum column column, char *to, size_t size)
{
    const struct top_shaft *shaft = encoder_shaft_of(view, encoder);
    const char *const texts[COLUMN_COUNT] = {
        [COLUMN_NAME] = encoder->name,     [COLUMN_MODEL] = encoder->model,
        [COLUMN_WIRE] = encoder->wire,     [COLUMN_LEDS] = encoder->leds,
        [COLUMN_MODE] = encoder->mode,     [COLUMN_POSITION] = encoder->position,
        [COLUMN_ERRORS] = encoder->errors, [COLUMN_FAULTS] = encoder->faults,
        [COLUMN_MORE] = encoder->more,     [COLUMN_SHAFT] = shaft == NULL ? "" : shaft->name,
    };
    if (column == COLUMN_RATE) {
        rate_text(encoder, to, size);
    } else if (column == COLUMN_ANGLE) {
        angle_text(shaft, to, size);
    } else {
        (void)snprintf(to, size, "%s", texts[column]);
    }
}

static attr_t cell_look(const struct top_encoder *encoder, enum column column, const char *text)
{
    const bool something = text[0] != '\0' && strcmp(text, "-") != 0;
    if (column == COLUMN_ERRORS && something) {
        return top_colour(TOP_PAIR_BAD);
    }
    if (column == COLUMN_FAULTS && something) {
        return top_colour(TOP_PAIR_WARNING);
    }
    if (column == COLUMN_WIRE && !encoder->up) {
        return top_colour(TOP_PAIR_BAD);
    }
    return A_NORMAL;
}

/* As wide as what is to be seen in it. */
static int natural_width(const struct top_view *view, enum column column)
{
    char text[TOP_CELL_MAX];
    int width = (int)strlen(columns[column].title);
    for (size_t i = view->first; i < view->first + view->rows && i < view->encoder_count; i++) {
        cell_text(view, &view->encoders[i], column, text, sizeof text);
        width = top_at_least((int)strlen(text), width);
    }
    return top_at_most(width, columns[column].most);
}

/* From `first` on in their order, until there is room. @return the room */
static int give_way(int widths[COLUMN_COUNT], int room, size_t first, size_t end)
{
    for (size_t i = first; room < 0 && i < end; i++) {
        room += widths[order[i]] + 1;
        widths[order[i]] = 0;
    }
    return room;
}

/* What is left goes to those that have not all they need. */
static void share_room(int widths[COLUMN_COUNT], const int natural[COLUMN_COUNT], int room)
{
    for (size_t i = COLUMN_COUNT; i > 0; i--) {
        const enum column column = order[i - 1];
        const int more = widths[column] == 0 ? 0 : natural[column] - widths[column];
        /* A part of an address says less than the kind of wire alone. */
        const int gets = column == COLUMN_WIRE && more > room ? 0 : top_at_most(more, room);
        widths[column] += gets;
        room -= gets;
    }
}

/* Extras do not push together what is always there. 0: it is not shown. */
static void fit_columns(const struct top_view *view, int widths[COLUMN_COUNT])
{
    int natural[COLUMN_COUNT];
    int room = COLS + 1; /* a blank behind each but the last */
    for (size_t i = 0; i < COLUMN_COUNT; i++) {
        const enum column column = order[i];
        natural[column] = natural_width(view, column);
        widths[column] =
            i < EXTRAS ? top_at_most(natural[column], columns[column].least) : natural[column];
        room -= widths[column] + 1;
    }
    room = give_way(widths, room, 0, EXTRAS);
    for (size_t i = EXTRAS; room < 0 && i < COLUMN_COUNT; i++) {
        const int least = top_at_most(natural[order[i]], columns[order[i]].least);
        room += widths[order[i]] - least;
        widths[order[i]] = least;
    }
    room = give_way(widths, room, EXTRAS, COLUMN_COUNT);
    share_room(widths, natural, room);
}

static void draw_cell(const struct top_view *view, const struct top_encoder *encoder,
                      enum column column, int y, int x, int width)
{
    char text[TOP_CELL_MAX];
    cell_text(view, encoder, column, text, sizeof text);
    if (column == COLUMN_LEDS) {
        top_put_leds(y, x, width, text);
        return;
    }
    if (column == COLUMN_WIRE && (int)strlen(text) > width) {
        text[strcspn(text, ":")] = '\0';
    }
    top_put_with(cell_look(encoder, column, text), y, x, width, text);
}

static void draw_row(const struct top_view *view, const struct top_encoder *encoder, int y,
                     const int widths[COLUMN_COUNT], attr_t look)
{
    int x = 0;
    (void)mvhline(y, 0, (chtype)' ' | look, COLS);
    for (enum column i = COLUMN_NAME; i < COLUMN_COUNT; i++) {
        (void)attrset((int)look);
        draw_cell(view, encoder, i, y, x, top_at_most(widths[i], COLS - x));
        x += widths[i] == 0 ? 0 : widths[i] + 1;
    }
    (void)attrset(A_NORMAL);
}

void top_table_draw(const struct top_view *view, int y)
{
    int widths[COLUMN_COUNT];
    int x = 0;
    fit_columns(view, widths);
    for (int i = 0; i < COLUMN_COUNT; i++) {
        top_put_with(A_UNDERLINE | A_BOLD, y, x, top_at_most(widths[i], COLS - x),
                     columns[i].title);
        x += widths[i] == 0 ? 0 : widths[i] + 1;
    }
    for (size_t i = 0; i < view->rows && view->first + i < view->encoder_count; i++) {
        const struct top_encoder *encoder = &view->encoders[view->first + i];
        const attr_t stale =
            view->trouble[0] != '\0' || (encoder->known && !encoder->powered) ? A_DIM : A_NORMAL;
        const attr_t chosen = view->first + i == view->selected ? A_REVERSE : A_NORMAL;
        draw_row(view, encoder, y + 1 + (int)i, widths, stale | chosen);
    }
}
