/* SPDX-License-Identifier: MIT */
/* The line of an answer taken apart, in place: answers with ';' between them, parts with ','. */
#ifndef DREHGEBER_TOOL_TOP_ANSWER_H
#define DREHGEBER_TOOL_TOP_ANSWER_H

#include <stdbool.h>

/* A line; `at` is its text, which is changed. */
struct top_answer {
    char *at;
    bool ended; /* the last part of the answer at hand was taken */
};

/* The next part of the answer at hand, a string without its quotes. NULL: it has no more */
char *top_answer_part(struct top_answer *self);

/* Go to the next answer of the line. @return false: there is none */
bool top_answer_next(struct top_answer *self);

#endif
