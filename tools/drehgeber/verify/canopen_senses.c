/* SPDX-License-Identifier: MIT */
/* What the node senses, and its LEDs. */
#include <stdlib.h>
#include <string.h>

#include "canopen_bench.h"

/* world QUANTITY N: a cause, in the unit of dg_world; bits are 0 and 1 */
bool canopen_step_world(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    struct dg_world *world = &b->world;
    const struct {
        const char *name;
        uint32_t *figure;
        bool *bit;
    } quantities[] = {
        {"temperature_mdegc", (uint32_t *)&world->temperature_mdegc, NULL},
        {"battery_mv", &world->battery_mv, NULL},
        {"led_current_ua", &world->led_current_ua, NULL},
        {"singleturn_ok", NULL, &world->singleturn_ok},
        {"multiturn_amplitude_ok", NULL, &world->multiturn_amplitude_ok},
        {"multiturn_sync_ok", NULL, &world->multiturn_sync_ok},
        {"multiturn_vector_ok", NULL, &world->multiturn_vector_ok},
        {"eeprom_acknowledges", NULL, &world->eeprom_acknowledges},
        {"watchdog_fired", NULL, &world->watchdog_fired},
    };
    const size_t count = DG_COUNT(quantities);
    long value = n == 3 ? strtol(words[2], NULL, 10) : 0;
    size_t i = 0;

    while (i < count && (n != 3 || strcmp(quantities[i].name, words[1]) != 0)) {
        i++;
    }
    if (i == count) {
        return cf_fail(report, "world QUANTITY N");
    }
    if (quantities[i].figure != NULL) {
        *quantities[i].figure = (uint32_t)value;
    }
    if (quantities[i].bit != NULL) {
        *quantities[i].bit = value != 0;
    }
    return true;
}

/* --- LEDs ---------------------------------------------------------------------------------- */

static struct dg_cia406_leds step_lamps(struct canopen_bench *b)
{
    canopen_note_deadline(b, dg_co_step(&b->node, b->now));
    return dg_cia406_leds(&b->node);
}

static bool lit(struct canopen_bench *b, bool red)
{
    struct dg_cia406_leds leds = step_lamps(b);

    return red ? leds.err : leds.bus;
}

/* How long the LED stays as it is, at most 3 s. Leaves the bench at the change. */
static dg_ns until_change(struct canopen_bench *b, bool red)
{
    dg_ns from = b->now;
    bool first = lit(b, red);

    while (lit(b, red) == first && b->now < from + DG_S(3)) {
        canopen_run_until(b, b->now + DG_MS(1), false);
    }
    return b->now - from;
}

/* led bus|err on|off|T: lit, dark, or T lit and T dark */
bool canopen_step_led(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    bool red = n == 3 && strcmp(words[1], "err") == 0;
    const char *rest;
    dg_ns want = n == 3 ? canopen_span(words[2], &rest) : 0;
    bool on = n == 3 && strcmp(words[2], "on") == 0;

    if (n != 3 || (want == 0 && !on && strcmp(words[2], "off") != 0)) {
        return cf_fail(report, "led bus|err on|off|T");
    }
    if (want > 0) {
        (void)until_change(b, red);
        const dg_ns first = until_change(b, red);
        const dg_ns second = until_change(b, red);
        return (first == want && second == want) ||
               cf_fail(report, "led: it does not change after %s", words[2]);
    }
    return lit(b, red) == on || cf_fail(report, "led: it is not %s", words[2]);
}

/* leds together|apart: both in the same phase, or in opposite phase, for half a second */
bool canopen_step_leds(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    bool together = n == 2 && strcmp(words[1], "together") == 0;
    bool held = together || (n == 2 && strcmp(words[1], "apart") == 0);

    for (int i = 0; i < 500 && held; i++) {
        struct dg_cia406_leds leds = step_lamps(b);

        held = (leds.bus == leds.err) == together;
        canopen_run_until(b, b->now + DG_MS(1), false);
    }
    return held || cf_fail(report, "leds together|apart: they are not");
}

/* bus off|active|passive|overrun|absent|present: what the CAN controller reports, and whether there
 * is a bus; what is said of that without power holds when the power comes */
bool canopen_step_bus(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    static const struct {
        const char *word;
        enum dg_co_bus_event event;
    } events[] = {
        {"active", DG_CO_BUS_ACTIVE}, {"passive", DG_CO_BUS_PASSIVE},
        {"off", DG_CO_BUS_OFF},       {"overrun", DG_CO_BUS_OVERRUN},
        {"absent", DG_CO_BUS_ABSENT}, {"present", DG_CO_BUS_PRESENT},
    };

    for (size_t i = 0; n == 2 && i < DG_COUNT(events); i++) {
        if (strcmp(words[1], events[i].word) == 0) {
            canopen_note_deadline(b, dg_co_bus(&b->node, b->now, events[i].event));
            return true;
        }
    }
    return cf_fail(report, "bus off|active|passive|overrun|absent|present");
}
