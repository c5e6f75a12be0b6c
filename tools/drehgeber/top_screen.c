/* SPDX-License-Identifier: MIT */
/*
 *                         24 lines and more               16 to 23       10 to 15
 *   header                1 line                          1              1
 *   dials                 5 lines, more on a large one    a line instead
 *   table of encoders     as many lines as are left
 *   the selected encoder  4 lines, more on a large one    3              2
 *   its last frames       4 lines or more, and a title    2 or more      none
 *   message, keys         2 lines                         2              1
 */
#define _GNU_SOURCE
#include "top_screen.h"

#include <ncurses.h>
#include <stdio.h>
#include <string.h>

#include "top_dial.h"
#include "top_draw.h"
#include "top_table.h"

#define WIDTH_MIN 40
#define HEIGHT_MIN 10
#define WIDTH_FULL 80 /* from here on there is room for words */
#define HEADER_HEIGHT 1
#define TITLE_HEIGHT 1
#define MORE_MAX 6 /* lines of what there is to say of an encoder */

void top_screen_begin(void)
{
    (void)cbreak();
    (void)noecho();
    (void)nonl();
    (void)keypad(stdscr, TRUE);
    (void)nodelay(stdscr, TRUE);
    (void)set_escdelay(25);
    (void)curs_set(0);
    top_draw_begin();
}

/* --- where everything is --- */

/* What heights of the screen have, the least first. */
static const struct heights {
    int from;
    bool dials;
    int more;   /* lines of the selected encoder's state */
    int frames; /* at least; 0: none */
    int foot;
} heights[] = {
    {HEIGHT_MIN, false, 0, 0, 1},
    {16, false, 1, 2, 2},
    {24, true, 2, 4, 2},
};

struct layout {
    int dial_rows; /* 0: a line for the shaft instead */
    int table;     /* line of its title */
    int rows;
    int detail;
    int more;   /* lines of it */
    int frames; /* lines of them */
    int foot;
};

static const struct heights *height(void)
{
    const struct heights *found = &heights[0];
    for (size_t i = 1; i < DG_COUNT(heights); i++) {
        found = LINES >= heights[i].from ? &heights[i] : found;
    }
    return found;
}

/* A second row of dials and so on for every two that fit into what is more than the least. */
static int dial_rows(const struct top_view *view, const struct heights *has)
{
    const int in_row = top_at_least(COLS / TOP_DIAL_WIDTH, 1);
    const int wanted = ((int)view->shaft_count + in_row - 1) / in_row;
    const int room = 1 + (LINES - has->from) / (2 * TOP_DIAL_HEIGHT);
    return has->dials ? top_at_least(top_at_most(wanted, room), 1) : 0;
}

/* Lines that the selected encoder's state needs. */
static int more_lines(const struct top_view *view)
{
    const char *text =
        view->selected < view->encoder_count ? view->encoders[view->selected].more : "";
    int lines = 0;
    while (*text != '\0') {
        text += top_line_length(text, COLS);
        text += *text == ' ' ? 1 : 0;
        lines++;
    }
    return top_at_most(lines, MORE_MAX);
}

static struct layout layout_of(const struct top_view *view)
{
    const struct heights *has = height();
    struct layout at = {.dial_rows = dial_rows(view, has), .more = has->more, .foot = has->foot};
    const int shafts = at.dial_rows == 0 ? 1 : at.dial_rows * TOP_DIAL_HEIGHT;
    const int title = has->frames == 0 ? 0 : TITLE_HEIGHT;
    const int encoders = (int)view->encoder_count;
    at.table = HEADER_HEIGHT + shafts;
    int room = LINES - at.table - TITLE_HEIGHT - 2 - at.more - title - at.foot;
    if (has->dials) { /* more of the state, before lines of the table stay empty */
        const int grow = more_lines(view) - at.more;
        at.more += top_at_least(top_at_most(grow, room - encoders - has->frames), 0);
        room -= at.more - has->more;
    }
    at.frames = has->frames == 0
                    ? 0
                    : top_at_most(top_at_least(room - encoders, has->frames), (int)TOP_FRAMES);
    at.rows = top_at_least(room - at.frames, 1);
    at.detail = at.table + TITLE_HEIGHT + at.rows;
    return at;
}

void top_screen_arrange(struct top_view *view)
{
    view->rows = (size_t)layout_of(view).rows;
    if (view->first + view->rows > view->encoder_count) {
        view->first = view->encoder_count > view->rows ? view->encoder_count - view->rows : 0;
    }
    if (view->selected < view->first) {
        view->first = view->selected;
    }
    if (view->selected >= view->first + view->rows) {
        view->first = view->selected + 1 - view->rows;
    }
}

/* --- the shaft and the selected encoder --- */

/* Instead of dials. */
static void draw_shaft(const struct top_view *view, int y)
{
    const struct top_encoder *encoder =
        view->selected < view->encoder_count ? &view->encoders[view->selected] : NULL;
    char text[TOP_CELL_MAX];
    if (encoder == NULL || encoder->shaft == TOP_NONE) {
        return;
    }
    top_dial_words(&view->shafts[encoder->shaft], text, sizeof text);
    top_put_with(A_BOLD, y, 0, COLS, text);
}

/* Words, on as many lines as there are for them. */
static void put_lines(int y, int lines, const char *text)
{
    for (int i = 0; i < lines; i++) {
        const int length = i + 1 < lines ? top_line_length(text, COLS) : (int)strlen(text);
        char line[TOP_CELL_MAX];
        (void)snprintf(line, sizeof line, "%.*s", length, text);
        top_put(y + i, 0, COLS, line);
        text += length + (text[length] == ' ' ? 1 : 0);
    }
}

/* LEDs, and behind them or in the other half what is wrong. */
static void draw_health(const struct top_encoder *encoder, int y)
{
    char text[TOP_CELL_MAX];
    const int at = COLS < WIDTH_FULL ? (int)strlen(encoder->leds) + 2 : COLS / 2;
    if (COLS < WIDTH_FULL) {
        top_put_leds(y, 0, COLS, encoder->leds);
        (void)snprintf(text, sizeof text, "%s", encoder->faults);
    } else {
        top_put(y, 0, COLS, "leds");
        top_put_leds(y, 5, COLS / 2 - 6, encoder->leds);
        (void)snprintf(text, sizeof text, "errors %s  faults %s", encoder->errors, encoder->faults);
    }
    top_put(y, at, COLS - at, text);
}

static void draw_detail(const struct top_view *view, const struct layout *at)
{
    if (view->selected >= view->encoder_count) {
        return;
    }
    const struct top_encoder *encoder = &view->encoders[view->selected];
    const char *shaft = encoder->shaft == TOP_NONE ? "" : view->shafts[encoder->shaft].name;
    char text[TOP_CELL_MAX];
    (void)mvhline(at->detail, 0, ACS_HLINE, COLS);
    (void)snprintf(text, sizeof text, " %zu/%zu  %s  %s  %s%s  shaft %s  power %s ",
                   view->selected + 1, view->encoder_count, encoder->name, encoder->model,
                   encoder->wire, encoder->up ? "" : " DOWN", shaft,
                   encoder->powered ? "on" : "OFF");
    top_put_with(A_BOLD, at->detail, 2, COLS - 2, text);
    draw_health(encoder, at->detail + 1);
    put_lines(at->detail + 2, at->more, encoder->more);
}

/* The newest at the bottom. */
static void draw_frames(const struct top_view *view, const struct layout *at)
{
    const size_t shown =
        (size_t)at->frames < view->frame_count ? (size_t)at->frames : view->frame_count;
    const int title = at->detail + 2 + at->more;
    if (at->frames == 0) {
        return;
    }
    (void)mvhline(title, 0, ACS_HLINE, COLS);
    top_put(title, 2, COLS - 2, " last frames on this wire ");
    for (size_t i = 0; i < shown; i++) {
        top_put(title + TITLE_HEIGHT + (int)i, 0, COLS,
                view->frames[view->frame_count - shown + i]);
    }
}

/* --- header and foot --- */

static void draw_header(const struct top_view *view)
{
    char text[TOP_CELL_MAX];
    char time[64] = "";
    if (view->time[0] != '\0') { /* a tenth of a second is enough */
        (void)snprintf(time, sizeof time, "%.*s s", (int)strcspn(view->time, ".") + 2, view->time);
    }
    (void)mvhline(0, 0, (chtype)' ' | A_REVERSE, COLS);
    (void)snprintf(text, sizeof text, "%s%s  %.200s", COLS < WIDTH_FULL ? "" : "drehgeber top  ",
                   view->rig, view->where);
    const int right = COLS - (int)strlen(time) - 1;
    top_put_with(A_REVERSE, 0, 1, right - 3, text);
    top_put_with(A_REVERSE, 0, right, COLS - right, time);
}

/* In a low window a message takes the place of the keys. */
static void draw_foot(const struct top_view *view, const struct layout *at)
{
    static const char few[] = "+- rpm  f faults  p power  ? help  q";
    static const char keys[] =
        "arrows: select, turn  +- rpm  space stop  f faults  c clear  p power  ? help  q";
    const char *text = view->trouble[0] != '\0' ? view->trouble : view->message;
    if (at->foot > 1 || text[0] == '\0') {
        top_put_with(A_REVERSE, LINES - 1, 0, COLS, COLS < WIDTH_FULL - 1 ? few : keys);
    }
    if (text[0] != '\0') {
        top_put_with(top_colour(TOP_PAIR_BAD) | A_BOLD, LINES - at->foot, 0, COLS, text);
    }
}

/* --- popups --- */

/* A window with a frame, as large as there is room for. */
static WINDOW *open_popup(int wanted_height, int wanted_width, const char *title)
{
    const int lines = top_at_most(wanted_height, LINES);
    const int width = top_at_most(wanted_width, COLS);
    WINDOW *window = newwin(lines, width, (LINES - lines) / 2, (COLS - width) / 2);
    if (window == NULL) {
        return NULL;
    }
    (void)box(window, 0, 0);
    (void)mvwaddnstr(window, 0, 2, title, width - 4);
    return window;
}

static void close_popup(WINDOW *window)
{
    (void)wnoutrefresh(window);
    (void)delwin(window);
}

static void draw_help(void)
{
    static const struct {
        const char *keys;
        const char *text;
    } lines[] = {
        {"up down, j k", "select an encoder; page, home, end"},
        {"left right, h l", "turn its shaft by 1 degree"},
        {"shift, H L", "... by 10 degrees"},
        {"+ -", "faster or slower by 10 rpm"},
        {"space", "stop the shaft"},
        {"f", "choose what happens to the encoder"},
        {"c", "clear all its faults"},
        {"p", "its power on or off"},
        {"?", "this; any key closes it"},
        {"q", "leave"},
    };
    const int count = (int)DG_COUNT(lines);
    const bool narrow = COLS < WIDTH_FULL;
    const bool framed = LINES >= count + 2;
    const int edge = framed ? 1 : 0;
    WINDOW *window = open_popup(count + 2, narrow ? COLS : 60, " keys ");
    if (window == NULL) {
        return;
    }
    if (!framed) {
        (void)werase(window);
    }
    for (int i = 0; i < count; i++) {
        (void)mvwprintw(window, i + edge, 2 * edge, "%-*s %.*s", narrow ? 15 : 18, lines[i].keys,
                        getmaxx(window) - 4 * edge - (narrow ? 16 : 19), lines[i].text);
    }
    close_popup(window);
}

#define CAUSE_LINES 3 /* below the list: a line, the cause, the effect */

static void draw_fault(WINDOW *window, int y, const struct top_fault *fault, bool active)
{
    char text[TOP_CELL_MAX];
    const int width = getmaxx(window) - 4;
    (void)snprintf(text, sizeof text, "%c %-24s %s", active ? '*' : ' ', fault->name, fault->cause);
    (void)mvwaddnstr(window, y, 2, text, width);
}

static void draw_faults(const struct top_screen *self, const struct top_view *view)
{
    const struct top_encoder *encoder = &view->encoders[view->faults_of];
    const int margin = COLS < WIDTH_FULL ? 0 : 2;
    const int list = top_at_most((int)view->fault_count, LINES - 2 - 2 * margin - CAUSE_LINES);
    const int first =
        top_at_least(top_at_most((int)self->choice - list / 2, (int)view->fault_count - list), 0);
    char title[TOP_CELL_MAX];
    (void)snprintf(title, sizeof title, " %s: enter sets or clears, esc closes ", encoder->name);
    WINDOW *window = open_popup(list + CAUSE_LINES + 2, COLS - 3 * margin, title);
    if (window == NULL) {
        return;
    }
    const int width = getmaxx(window) - 4;
    for (int i = 0; i < list; i++) {
        const struct top_fault *fault = &view->faults[first + i];
        (void)wattrset(window, first + i == (int)self->choice ? A_REVERSE : A_NORMAL);
        draw_fault(window, i + 1, fault, top_fault_active(encoder, fault->name));
    }
    (void)wattrset(window, A_NORMAL);
    if (self->choice < view->fault_count) {
        (void)mvwhline(window, list + 1, 1, ACS_HLINE, width + 2);
        (void)mvwaddnstr(window, list + 2, 2, view->faults[self->choice].cause, width);
        (void)mvwaddnstr(window, list + 3, 2, view->faults[self->choice].effect, width);
    }
    close_popup(window);
}

static void draw_popup(const struct top_screen *self, const struct top_view *view)
{
    if (self->popup == TOP_POPUP_HELP) {
        draw_help();
    } else if (self->popup == TOP_POPUP_FAULTS && view->faults_of < view->encoder_count) {
        draw_faults(self, view);
    }
}

void top_screen_draw(const struct top_screen *self, const struct top_view *view)
{
    const struct layout at = layout_of(view);
    (void)erase();
    if (COLS < WIDTH_MIN || LINES < HEIGHT_MIN) {
        top_put(0, 0, COLS, "window too small: expected 40x10");
        (void)refresh();
        return;
    }
    draw_header(view);
    if (at.dial_rows == 0) {
        draw_shaft(view, HEADER_HEIGHT);
    } else {
        top_dial_draw_all(view, HEADER_HEIGHT, at.dial_rows);
    }
    top_table_draw(view, at.table);
    draw_detail(view, &at);
    draw_frames(view, &at);
    draw_foot(view, &at);
    (void)wnoutrefresh(stdscr);
    draw_popup(self, view);
    (void)doupdate();
}
