/* SPDX-License-Identifier: MIT */
/*
 * Eleven characters as an instrument.
 */
#include "drehgeber/eleven.h"
#include "drehgeber/instruments.h"

static const char *mode(const void *self, dg_ns now)
{
    const struct dg_eleven *device = self;

    if (!device->powered) {
        return "off";
    }
    return device->due != DG_NEVER && now < device->due ? "replying" : "idle";
}

static void state(const void *self, dg_ns now, struct dg_scpi *to)
{
    const struct dg_eleven *device = self;
    const bool lost = device->powered && !device->world->singleturn_ok;

    (void)now;
    dg_state_word(to, "leds", "-");
    dg_state_error_bits(to, lost ? DG_ELEVEN_LOST : 0);
    dg_state_number(to, "frames", device->counters.replies);
    dg_state_number(to, "strange", device->counters.strange);
    dg_state_number(to, "damaged", device->counters.damaged);
}

/* clang-format off */
static const struct dg_fault_row faults[] = {
    {"singleturn_lost", DG_FAULT_SENSES(singleturn_ok), 0,                 DG_CAUSE_SCRATCH, "bit 0 of the status is set", "E1"},
    {"wire_drop",       DG_FAULT_ON_WIRE(DROP),         0,                 "the line driver is broken now and then", "no reply", "E2"},
    {"wire_deaf",       DG_FAULT_ON_WIRE(DEAF),         0,                 "the receiver is broken now and then", "no reply", "E2"},
    {"wire_delay",      DG_FAULT_ON_WIRE(DELAY),        (int64_t)DG_MS(1), "somebody else delays the reply", "the reply is late", "E2"},
    {"wire_damage",     DG_FAULT_ON_WIRE(DAMAGE),       0,                 "a disturbance on the line", "one bit of the reply is flipped", "E2"},
};
/* clang-format on */

const struct dg_instrument dg_eleven_instrument = {
    .stack = &dg_eleven_stack,
    .faults = faults,
    .fault_count = DG_COUNT(faults),
    .mode = mode,
    .state = state,
};
