/* SPDX-License-Identifier: MIT */
#include "top_answer.h"

#include <stddef.h>
#include <string.h>

/* From behind the opening quote to behind the closing one; doubled ones become one. */
static char *unquote_text(char *text)
{
    char *to = text;
    char *from = text;
    while (*from != '\0' && (from[0] != '"' || from[1] == '"')) {
        from += *from == '"' ? 1 : 0;
        *to++ = *from++;
    }
    from += *from == '"' ? 1 : 0;
    /* The quote has left room for this zero; without it the line ends here anyway. */
    *to = '\0';
    return from;
}

char *top_answer_part(struct top_answer *self)
{
    char *part = self->at;
    char *end = part;
    if (self->ended) {
        return NULL;
    }
    if (*part == '"') {
        end = unquote_text(++part);
    }
    end += strcspn(end, ",;\r");
    self->ended = *end != ',';
    self->at = end + (*end == ',' || *end == ';' ? 1 : 0);
    *end = '\0';
    return part;
}

bool top_answer_next(struct top_answer *self)
{
    while (top_answer_part(self) != NULL) {
    }
    self->ended = *self->at == '\0';
    return !self->ended;
}
