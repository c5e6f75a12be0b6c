/* SPDX-License-Identifier: MIT */
#include "say.h"

#include <stdarg.h>
#include <stdio.h>

/* The line is put together first: one write, so that lines of several processes do not mix. */
static void print_line(const char *format, va_list arguments)
{
    char text[600];
    (void)vsnprintf(text, sizeof text, format, arguments);
    (void)fprintf(stderr, "drehgeber: %s\n", text);
}

int lx_fail(struct lx_error *error, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    return -1;
}

void lx_note(const struct lx_say *say, const char *format, ...)
{
    if (say->quiet) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    print_line(format, arguments);
    va_end(arguments);
}

void lx_complain(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    print_line(format, arguments);
    va_end(arguments);
}
