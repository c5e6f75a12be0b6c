/* SPDX-License-Identifier: MIT */
/*
 * Words in a column of a page.
 */
#ifndef DREHGEBER_TOOL_COLUMNS_H
#define DREHGEBER_TOOL_COLUMNS_H

/* How wide a page is without a terminal, and every help. */
#define COLUMNS_WIDTH 80

/* Print words in as many lines of `width` columns as they need, each from column `at` on; `column`
   is where the first line has got to, at most `at`. */
void columns_put(const char *text, int column, int at, int width);

#endif
