/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "say.h"

#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <unistd.h>

/* Lines that were left out since the last one, of the one stderr that a process has. */
static unsigned long left_out;

/* Whether stderr takes a line now: a reader that does not read must not hold up the wires. A pipe
   that is said to be writable has room for more than a line. */
static bool has_stderr_room(void)
{
    struct pollfd out = {.fd = STDERR_FILENO, .events = POLLOUT};
    return poll(&out, 1, 0) != 0;
}

/* The line is put together first: one write, so that lines of several processes do not mix. */
static void print_line(const char *before, const char *format, va_list arguments)
{
    char text[LX_LINE_MAX];
    (void)vsnprintf(text, sizeof text, format, arguments);
    flockfile(stderr); /* the thread that writes EEPROM files has lines, too */
    if (!has_stderr_room()) {
        left_out++;
        funlockfile(stderr);
        return;
    }
    if (left_out > 0) {
        (void)fprintf(stderr, "drehgeber: %lu lines left out, because they were not read\n",
                      left_out);
        left_out = 0;
    }
    (void)fprintf(stderr, "%s%s\n", before, text);
    funlockfile(stderr);
}

static const char own[] = "drehgeber: ";

void lx_note(const struct lx_say *say, const char *format, ...)
{
    if (say->quiet) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    print_line(own, format, arguments);
    va_end(arguments);
}

void lx_complain(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    print_line(own, format, arguments);
    va_end(arguments);
}

void lx_print(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    print_line("", format, arguments);
    va_end(arguments);
}
