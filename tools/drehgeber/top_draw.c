/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "top_draw.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool coloured(void)
{
    const char *unwanted = getenv("NO_COLOR");
    return has_colors() && (unwanted == NULL || unwanted[0] == '\0');
}

void top_draw_begin(void)
{
    if (coloured()) {
        (void)start_color();
        (void)use_default_colors();
        (void)init_pair(TOP_PAIR_GOOD, COLOR_GREEN, -1);
        (void)init_pair(TOP_PAIR_BAD, COLOR_RED, -1);
        (void)init_pair(TOP_PAIR_WARNING, COLOR_YELLOW, -1);
    }
}

attr_t top_colour(enum top_pair pair)
{
    return coloured() ? (attr_t)COLOR_PAIR(pair) : A_BOLD;
}

void top_put(int y, int x, int width, const char *text)
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

void top_put_with(attr_t look, int y, int x, int width, const char *text)
{
    (void)attron(look);
    top_put(y, x, width, text);
    (void)attroff(look);
}

/* What a lamp looks like, "err:blink": the red ones have their names from CiA 303-3 and INTERBUS.
 */
static attr_t lamp(const char *led)
{
    const char *pattern = strchr(led, ':');
    const bool red = strncasecmp(led, "err", 3) == 0 || strncasecmp(led, "rd", 2) == 0;
    if (pattern == NULL) { /* "-": the encoder has no LEDs */
        return A_NORMAL;
    }
    if (strcmp(pattern, ":off") == 0) {
        return A_DIM;
    }
    return top_colour(red ? TOP_PAIR_BAD : TOP_PAIR_GOOD) |
           (strcmp(pattern, ":on") == 0 ? A_NORMAL : A_BLINK);
}

void top_put_leds(int y, int x, int width, const char *leds)
{
    char text[TOP_CELL_MAX];
    char *rest = text;
    char *led;
    (void)snprintf(text, sizeof text, "%s", leds);
    while ((led = strsep(&rest, " ")) != NULL && width > 0) {
        const int length = (int)strlen(led);
        const attr_t look = lamp(led);
        for (char *c = led; *c != '\0' && *c != ':'; c++) {
            *c = (char)(*c >= 'a' && *c <= 'z' ? *c - 'a' + 'A' : *c);
        }
        top_put_with(look, y, x, width, led);
        x += length + 1;
        width -= length + 1;
    }
}

int top_line_length(const char *text, int width)
{
    int length = (int)strlen(text);
    if (length <= width) {
        return length;
    }
    for (length = width; length > 0 && text[length] != ' '; length--) {
    }
    return length > 0 ? length : width;
}
