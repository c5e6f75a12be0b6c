/* SPDX-License-Identifier: MIT */
/* What the traces' words are made with; page/engine.js has it. */
#ifndef DREHGEBER_WEB_STDIO_H
#define DREHGEBER_WEB_STDIO_H

#include <stdarg.h>
#include <stddef.h>

/** Only named here. */
typedef struct web_file FILE;

/** C11 7.21.6.12, with the conversions d, u, X, c, s and %. */
int vsnprintf(char *to, size_t size, const char *format, va_list arguments)
    __attribute__((import_module("page"), import_name("vsnprintf")));

#endif
