/* SPDX-License-Identifier: MIT */
#include "row_figures.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/time.h"
#include "drehgeber/world.h"

/* clang-format off */
#define WORLD(field, kind) CF_FIGURE(#field, dg_world, field, kind)
const struct cf_figure cf_world_figures[] = {
    WORLD(temperature_mdegc, I32),      WORLD(led_current_ua, U32),
    WORLD(sin_amplitude_permille, U16), WORLD(cos_amplitude_permille, U16),
    WORLD(sin_offset_permille, I16),    WORLD(cos_offset_permille, I16),
    WORLD(singleturn_ok, BOOL),         WORLD(multiturn_amplitude_ok, BOOL),
    WORLD(multiturn_sync_ok, BOOL),     WORLD(multiturn_vector_ok, BOOL),
    WORLD(eeprom_acknowledges, BOOL),   WORLD(watchdog_fired, BOOL),
    {NULL, 0, 0, CF_U8},
};
/* clang-format on */

const struct cf_figure *cf_find_figure(const struct cf_figure *figures, const char *name, size_t n)
{
    while (figures->name != NULL &&
           (strlen(figures->name) != n || strncmp(figures->name, name, n) != 0)) {
        figures++;
    }
    return figures->name != NULL ? figures : NULL;
}

static void set_number(uint8_t *to, enum cf_kind kind, long long value)
{
    const int16_t i16 = (int16_t)value;
    const uint16_t u16 = (uint16_t)value;
    const int32_t i32 = (int32_t)value;
    const uint32_t u32 = (uint32_t)value;
    const uint8_t u8 = (uint8_t)value;
    const bool yes = value != 0;
    const dg_ns us = DG_US(value);
    const dg_ns ms = DG_MS(value);
    const struct {
        const void *from;
        size_t n;
    } forms[] = {
        [CF_U8] = {&u8, sizeof u8},    [CF_I16] = {&i16, sizeof i16},
        [CF_U16] = {&u16, sizeof u16}, [CF_U32] = {&u32, sizeof u32},
        [CF_I32] = {&i32, sizeof i32}, [CF_BOOL] = {&yes, sizeof yes},
        [CF_US] = {&us, sizeof us},    [CF_MS] = {&ms, sizeof ms},
    };

    memcpy(to, forms[kind].from, forms[kind].n);
}

bool cf_set_figure(const struct cf_figure *figures, void *object, const char *word)
{
    const size_t n = strcspn(word, "=");
    const struct cf_figure *figure = word[n] == '=' ? cf_find_figure(figures, word, n) : NULL;

    if (figure == NULL) {
        return false;
    }
    uint8_t *to = (uint8_t *)object + figure->offset;
    if (figure->kind == CF_TEXT) {
        memset(to, 0, figure->size);
        (void)snprintf((char *)to, figure->size, "%s", word + n + 1);
    } else {
        set_number(to, figure->kind, strtoll(word + n + 1, NULL, 0));
    }
    return true;
}
