/* SPDX-License-Identifier: MIT */
#include "words_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void on_line(void *ctx, const struct dg_words_line *line)
{
    struct words_rig *self = ctx;

    assert_true(strlen(line->text) < DG_WORDS_MAX);
    assert_true(line->severity < DG_SEVERITY_COUNT);
    self->count++;
    self->at = line->at;
    self->ours = line->ours;
    self->severity = line->severity;
    self->clause = line->clause;
    (void)strcpy(self->text, line->text);
}

void words_rig_init(struct words_rig *self, const struct dg_words *words)
{
    memset(self, 0, sizeof *self);
    assert_true(words == NULL || words->size <= sizeof self->memory);
    self->wire = (struct dg_words_wire){words, &self->memory, {on_line, self}};
}

size_t words_rig_hex(const char *hex, uint8_t *bytes)
{
    size_t n = 0;
    char *end = NULL;

    for (unsigned long value = strtoul(hex, &end, 16); end != hex; value = strtoul(hex, &end, 16)) {
        bytes[n++] = (uint8_t)value;
        hex = end;
    }
    return n;
}
