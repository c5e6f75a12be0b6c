/* SPDX-License-Identifier: MIT */
#include "drehgeber/form.h"

#define WORD_BITS 64u

static struct dg_form_part *find_part(const struct dg_form *self, char letter)
{
    for (size_t i = 0; i < self->count; i++) {
        if (self->parts[i].letter == letter) {
            return &self->parts[i];
        }
    }
    return NULL;
}

static bool is_constant(char c)
{
    return c == '0' || c == '1';
}

/* Bits of a character: a blank has none. */
static uint8_t bits_of(const struct dg_form *self, char c)
{
    const struct dg_form_part *part = find_part(self, c);

    if (part != NULL) {
        return part->bits;
    }
    return is_constant(c) ? 1u : 0u;
}

static uint64_t part_value_of(const struct dg_form *self, char c)
{
    const struct dg_form_part *part = find_part(self, c);

    return part != NULL ? part->value : (uint64_t)(c == '1');
}

static unsigned times(const char *layout, char letter)
{
    unsigned count = 0;

    for (; *layout != '\0'; layout++) {
        count += *layout == letter ? 1u : 0u;
    }
    return count;
}

bool dg_form_has(const char *layout, char letter)
{
    return times(layout, letter) > 0;
}

bool dg_form_fits(const struct dg_form *self, uint32_t most)
{
    uint32_t bits = 0;

    for (const char *at = self->layout; *at != '\0'; at++) {
        const bool known = find_part(self, *at) != NULL;
        if ((known && times(self->layout, *at) > 1) ||
            (!known && !is_constant(*at) && *at != ' ')) {
            return false;
        }
        bits += bits_of(self, *at);
    }
    return bits >= 1u && bits <= most;
}

struct dg_form_word dg_form_pack(const struct dg_form *self, char end)
{
    struct dg_form_word word = {0, 0};

    for (const char *at = self->layout; *at != '\0' && *at != end; at++) {
        const uint8_t bits = bits_of(self, *at);
        word.bits = bits < WORD_BITS ? word.bits << bits : 0;
        word.bits |= part_value_of(self, *at);
        word.count = (uint8_t)(word.count + bits);
    }
    return word;
}

void dg_form_unpack(const struct dg_form *self, uint64_t bits)
{
    uint32_t left = dg_form_pack(self, '\0').count;

    for (const char *at = self->layout; *at != '\0'; at++) {
        struct dg_form_part *part = find_part(self, *at);
        left -= bits_of(self, *at);
        if (part != NULL) {
            part->value = bits >> left & UINT64_MAX >> (WORD_BITS - part->bits);
        }
    }
}
