/* SPDX-License-Identifier: MIT */
/*
 *   header                 1 line
 *   dials                  5 lines, more of them on a large screen
 *   table of encoders      as many lines as are left
 *   the selected encoder   4 lines
 *   its last frames        4 lines or more
 *   message, keys          2 lines
 */
#define _GNU_SOURCE
#include "top_screen.h"

#include <inttypes.h>
#include <ncurses.h>
#include <stdio.h>
#include <string.h>

#include "top_dial.h"

#define WIDTH_MIN 80
#define HEIGHT_MIN 24
#define HEADER_HEIGHT 1
#define TITLE_HEIGHT 1
#define MORE_HEIGHT 2
#define DETAIL_HEIGHT (2 + MORE_HEIGHT + 1) /* with the title of the frames */
#define FOOT_HEIGHT 2
#define FRAMES_MIN 4
#define CELL_MAX 512

enum pair {
    PAIR_GOOD = 1,
    PAIR_BAD,
    PAIR_WARNING,
};

static attr_t colour(enum pair pair)
{
    return has_colors() ? (attr_t)COLOR_PAIR(pair) : A_BOLD;
}

void top_screen_begin(void)
{
    (void)cbreak();
    (void)noecho();
    (void)nonl();
    (void)keypad(stdscr, TRUE);
    (void)nodelay(stdscr, TRUE);
    (void)set_escdelay(25);
    (void)curs_set(0);
    if (has_colors()) {
        (void)start_color();
        (void)use_default_colors();
        (void)init_pair(PAIR_GOOD, COLOR_GREEN, -1);
        (void)init_pair(PAIR_BAD, COLOR_RED, -1);
        (void)init_pair(PAIR_WARNING, COLOR_YELLOW, -1);
    }
}

/* --- where everything is --- */

struct layout {
    int dial_rows;
    int table; /* line of its title */
    int rows;
    int detail;
    int frames; /* lines of them */
};

static int at_least(int value, int least)
{
    return value > least ? value : least;
}

static int at_most(int value, int most)
{
    return value < most ? value : most;
}

/* A second row of dials and so on for every two that fit into what is more than the least. */
static int dial_rows(const struct top_view *view)
{
    const int in_row = at_least(COLS / TOP_DIAL_WIDTH, 1);
    const int wanted = ((int)view->shaft_count + in_row - 1) / in_row;
    return at_least(at_most(wanted, 1 + (LINES - HEIGHT_MIN) / (2 * TOP_DIAL_HEIGHT)), 1);
}

static struct layout layout_of(const struct top_view *view)
{
    struct layout at = {.dial_rows = dial_rows(view)};
    at.table = HEADER_HEIGHT + at.dial_rows * TOP_DIAL_HEIGHT;
    const int room = LINES - at.table - TITLE_HEIGHT - DETAIL_HEIGHT - FOOT_HEIGHT;
    const int encoders = (int)view->encoder_count;
    at.frames = at_most(at_least(room - encoders, FRAMES_MIN), (int)TOP_FRAMES);
    at.rows = at_least(room - at.frames, 1);
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

/* --- pieces --- */

/* At most `width` columns of a text, the last one '~' when that is not all of it. */
static void put(int y, int x, int width, const char *text)
{
    const int length = (int)strlen(text);
    if (width <= 0) {
        return;
    }
    if (length <= width) {
        (void)mvaddstr(y, x, text);
        return;
    }
    (void)mvaddnstr(y, x, text, width - 1);
    (void)addch('~');
}

static void put_with(attr_t look, int y, int x, int width, const char *text)
{
    (void)attron(look);
    put(y, x, width, text);
    (void)attroff(look);
}

/* What a lamp looks like, "err:blink": the red ones have their names from CiA 303-3 and INTERBUS.
 */
static attr_t lamp(const char *led)
{
    const char *colon = strchr(led, ':');
    const char *pattern = colon == NULL ? "" : colon + 1;
    const bool red = strncasecmp(led, "err", 3) == 0 || strncasecmp(led, "rd", 2) == 0;
    if (strcmp(pattern, "off") == 0) {
        return A_DIM;
    }
    return colour(red ? PAIR_BAD : PAIR_GOOD) | (strcmp(pattern, "on") == 0 ? A_NORMAL : A_BLINK);
}

/* "bus:on err:off" as BUS:on ERR:off, each in its colour. */
static void put_leds(int y, int x, int width, const char *leds)
{
    char text[CELL_MAX];
    char *rest = text;
    char *led;
    (void)snprintf(text, sizeof text, "%s", leds);
    while ((led = strsep(&rest, " ")) != NULL && width > 0) {
        const int length = (int)strlen(led);
        const attr_t look = lamp(led);
        for (char *c = led; *c != '\0' && *c != ':'; c++) {
            *c = (char)(*c >= 'a' && *c <= 'z' ? *c - 'a' + 'A' : *c);
        }
        put_with(look, y, x, width, led);
        x += length + 1;
        width -= length + 1;
    }
}

/* --- the table --- */

enum column {
    COLUMN_NAME,
    COLUMN_MODEL,
    COLUMN_WIRE,
    COLUMN_LEDS,
    COLUMN_MODE,
    COLUMN_POSITION,
    COLUMN_ERRORS,
    COLUMN_RATE,
    COLUMN_FAULTS,
    COLUMN_COUNT,
};

/* On a narrow screen the widest shrink first, down to their least. */
static const struct {
    const char *title;
    int least;
    int most;
} columns[COLUMN_COUNT] = {
    [COLUMN_NAME] = {"NAME", 5, 32},     [COLUMN_MODEL] = {"MODEL", 11, 11},
    [COLUMN_WIRE] = {"WIRE", 4, 28},     [COLUMN_LEDS] = {"LEDS", 17, 28},
    [COLUMN_MODE] = {"MODE", 7, 14},     [COLUMN_POSITION] = {"POSITION", 10, 10},
    [COLUMN_ERRORS] = {"ERRORS", 6, 20}, [COLUMN_RATE] = {"FRM/S", 5, 7},
    [COLUMN_FAULTS] = {"FAULTS", 6, 60},
};

static void cell_text(const struct top_encoder *encoder, enum column column, char *to, size_t size)
{
    const char *const texts[COLUMN_COUNT] = {
        [COLUMN_NAME] = encoder->name,     [COLUMN_MODEL] = encoder->model,
        [COLUMN_WIRE] = encoder->wire,     [COLUMN_LEDS] = encoder->leds,
        [COLUMN_MODE] = encoder->mode,     [COLUMN_POSITION] = encoder->position,
        [COLUMN_ERRORS] = encoder->errors, [COLUMN_FAULTS] = encoder->faults,
    };
    if (column != COLUMN_RATE) {
        (void)snprintf(to, size, "%s", texts[column]);
    } else if (encoder->rate < 0) {
        (void)snprintf(to, size, "%s", encoder->known ? "-" : "");
    } else {
        (void)snprintf(to, size, "%" PRId64, encoder->rate);
    }
}

static attr_t cell_look(const struct top_encoder *encoder, enum column column, const char *text)
{
    const bool something = text[0] != '\0' && strcmp(text, "-") != 0;
    if (column == COLUMN_ERRORS && something) {
        return colour(PAIR_BAD);
    }
    if (column == COLUMN_FAULTS && something) {
        return colour(PAIR_WARNING);
    }
    if (column == COLUMN_WIRE && !encoder->up) {
        return colour(PAIR_BAD);
    }
    return A_NORMAL;
}

/* As wide as what is to be seen in it. */
static int natural_width(const struct top_view *view, enum column column)
{
    char text[CELL_MAX];
    int width = at_least((int)strlen(columns[column].title), columns[column].least);
    for (size_t i = view->first; i < view->first + view->rows && i < view->encoder_count; i++) {
        cell_text(&view->encoders[i], column, text, sizeof text);
        width = at_least((int)strlen(text), width);
    }
    return at_most(width, columns[column].most);
}

static void fit_columns(const struct top_view *view, int widths[COLUMN_COUNT])
{
    int total = COLUMN_COUNT - 1; /* blanks between them */
    for (enum column i = COLUMN_NAME; i < COLUMN_COUNT; i++) {
        widths[i] = natural_width(view, i);
        total += widths[i];
    }
    for (int widest = 0; total > COLS && widest != COLUMN_COUNT; total--) {
        widest = COLUMN_COUNT;
        for (int i = 0; i < COLUMN_COUNT; i++) {
            const bool can = widths[i] > columns[i].least;
            widest = can && (widest == COLUMN_COUNT || widths[i] > widths[widest]) ? i : widest;
        }
        if (widest != COLUMN_COUNT) {
            widths[widest]--;
        }
    }
}

static void draw_row(const struct top_encoder *encoder, int y, const int widths[COLUMN_COUNT],
                     attr_t look)
{
    char text[CELL_MAX];
    int x = 0;
    (void)mvhline(y, 0, (chtype)' ' | look, COLS);
    for (enum column i = COLUMN_NAME; i < COLUMN_COUNT; i++) {
        (void)attrset((int)look);
        cell_text(encoder, i, text, sizeof text);
        if (i == COLUMN_LEDS) {
            put_leds(y, x, at_most(widths[i], COLS - x), text);
        } else {
            put_with(cell_look(encoder, i, text), y, x, at_most(widths[i], COLS - x), text);
        }
        x += widths[i] + 1;
    }
    (void)attrset(A_NORMAL);
}

static void draw_table(const struct top_view *view, const struct layout *at)
{
    int widths[COLUMN_COUNT];
    int x = 0;
    fit_columns(view, widths);
    for (int i = 0; i < COLUMN_COUNT; i++) {
        put_with(A_UNDERLINE | A_BOLD, at->table, x, at_most(widths[i], COLS - x),
                 columns[i].title);
        x += widths[i] + 1;
    }
    for (size_t i = 0; i < view->rows && view->first + i < view->encoder_count; i++) {
        const struct top_encoder *encoder = &view->encoders[view->first + i];
        const attr_t stale =
            view->trouble[0] != '\0' || (encoder->known && !encoder->powered) ? A_DIM : A_NORMAL;
        const attr_t chosen = view->first + i == view->selected ? A_REVERSE : A_NORMAL;
        draw_row(encoder, at->table + TITLE_HEIGHT + (int)i, widths, stale | chosen);
    }
}

/* --- the selected encoder --- */

/* Words, on as many lines as there are for them. */
static void put_lines(int y, const char *text)
{
    for (int i = 0; i < MORE_HEIGHT; i++) {
        int length = (int)strlen(text);
        if (length > COLS && i + 1 < MORE_HEIGHT) {
            length = COLS;
            while (length > 0 && text[length] != ' ') {
                length--;
            }
            (void)mvaddnstr(y + i, 0, text, length);
        } else {
            put(y + i, 0, COLS, text);
        }
        text += length + (text[length] == ' ' ? 1 : 0);
    }
}

static void draw_detail(const struct top_view *view, const struct layout *at)
{
    if (view->selected >= view->encoder_count) {
        return;
    }
    const struct top_encoder *encoder = &view->encoders[view->selected];
    const char *shaft = encoder->shaft == TOP_NONE ? "" : view->shafts[encoder->shaft].name;
    char text[CELL_MAX];
    (void)mvhline(at->detail, 0, ACS_HLINE, COLS);
    (void)snprintf(text, sizeof text, " %s  %s  %s%s  shaft %s  power %s  %zu/%zu ", encoder->name,
                   encoder->model, encoder->wire, encoder->up ? "" : " DOWN", shaft,
                   encoder->powered ? "on" : "OFF", view->selected + 1, view->encoder_count);
    put_with(A_BOLD, at->detail, 2, COLS - 2, text);
    put(at->detail + 1, 0, COLS, "leds");
    put_leds(at->detail + 1, 5, COLS / 2 - 6, encoder->leds);
    (void)snprintf(text, sizeof text, "errors %s  faults %s", encoder->errors, encoder->faults);
    put(at->detail + 1, COLS / 2, COLS - COLS / 2, text);
    put_lines(at->detail + 2, encoder->more);
}

/* The newest at the bottom. */
static void draw_frames(const struct top_view *view, const struct layout *at)
{
    const size_t shown =
        (size_t)at->frames < view->frame_count ? (size_t)at->frames : view->frame_count;
    const int title = at->detail + DETAIL_HEIGHT - 1;
    (void)mvhline(title, 0, ACS_HLINE, COLS);
    put(title, 2, COLS - 2, " last frames on this wire ");
    for (size_t i = 0; i < shown; i++) {
        put(at->detail + DETAIL_HEIGHT + (int)i, 0, COLS,
            view->frames[view->frame_count - shown + i]);
    }
}

/* --- header and foot --- */

static void draw_header(const struct top_view *view)
{
    char text[CELL_MAX];
    char time[64] = "";
    if (view->time[0] != '\0') { /* a tenth of a second is enough */
        (void)snprintf(time, sizeof time, "%.*s s", (int)strcspn(view->time, ".") + 2, view->time);
    }
    (void)mvhline(0, 0, (chtype)' ' | A_REVERSE, COLS);
    (void)snprintf(text, sizeof text, "drehgeber top  %s  %.200s", view->rig, view->where);
    const int right = COLS - (int)strlen(time) - 1;
    put_with(A_REVERSE, 0, 1, right - 3, text);
    put_with(A_REVERSE, 0, right, COLS - right, time);
}

static void draw_foot(const struct top_view *view)
{
    static const char keys[] =
        "arrows: select, turn  +- rpm  space stop  f faults  c clear  p power  ? help  q";
    const char *text = view->trouble[0] != '\0' ? view->trouble : view->message;
    put_with(colour(PAIR_BAD) | A_BOLD, LINES - 2, 0, COLS, text);
    put_with(A_REVERSE, LINES - 1, 0, COLS, keys);
}

/* --- popups --- */

static WINDOW *open_popup(int height, int width, const char *title)
{
    WINDOW *window = newwin(height, width, (LINES - height) / 2, (COLS - width) / 2);
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
    static const char *const lines[] = {
        "up down, j k       select an encoder; page, home, end",
        "left right, h l    turn its shaft by 1 degree",
        "shift, H L         ... by 10 degrees",
        "+ -                faster or slower by 10 rpm",
        "space              stop the shaft",
        "f                  choose what happens to the encoder",
        "c                  clear all its faults",
        "p                  its power on or off",
        "?                  this; any key closes it",
        "q                  leave",
    };
    const int count = (int)DG_COUNT(lines);
    WINDOW *window = open_popup(count + 2, 60, " keys ");
    for (int i = 0; window != NULL && i < count; i++) {
        (void)mvwaddstr(window, i + 1, 2, lines[i]);
    }
    if (window != NULL) {
        close_popup(window);
    }
}

#define CAUSE_LINES 3 /* below the list: a line, the cause, the effect */

static void draw_fault(WINDOW *window, int y, const struct top_fault *fault, bool active)
{
    char text[CELL_MAX];
    const int width = getmaxx(window) - 4;
    (void)snprintf(text, sizeof text, "%c %-24s %s", active ? '*' : ' ', fault->name, fault->cause);
    (void)mvwaddnstr(window, y, 2, text, width);
}

static void draw_faults(const struct top_screen *self, const struct top_view *view)
{
    const struct top_encoder *encoder = &view->encoders[view->faults_of];
    const int list = at_most((int)view->fault_count, LINES - 6 - CAUSE_LINES);
    const int first =
        at_least(at_most((int)self->choice - list / 2, (int)view->fault_count - list), 0);
    char title[CELL_MAX];
    (void)snprintf(title, sizeof title, " %s: enter sets or clears, esc closes ", encoder->name);
    WINDOW *window = open_popup(list + CAUSE_LINES + 2, COLS - 6, title);
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
        put(0, 0, COLS, "window too small: 80x24 is right");
        (void)refresh();
        return;
    }
    draw_header(view);
    top_dial_draw_all(view, HEADER_HEIGHT, at.dial_rows);
    draw_table(view, &at);
    draw_detail(view, &at);
    draw_frames(view, &at);
    draw_foot(view);
    (void)wnoutrefresh(stdscr);
    draw_popup(self, view);
    (void)doupdate();
}
