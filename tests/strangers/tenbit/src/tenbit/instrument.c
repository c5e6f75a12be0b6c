/* SPDX-License-Identifier: MIT */
/*
 * Words of ten bits as an instrument.
 */
#include "drehgeber/instruments.h"
#include "drehgeber/tenbit.h"

static const char *mode(const void *self, dg_ns now)
{
    const struct dg_tenbit *device = self;

    if (!device->powered) {
        return "off";
    }
    return device->deadline != DG_NEVER && now < device->deadline ? "transmitting" : "idle";
}

static void state(const void *self, dg_ns now, struct dg_scpi *to)
{
    const struct dg_tenbit *device = self;

    (void)now;
    dg_state_word(to, "leds", "-");
    dg_state_error_bits(to, 0);
    dg_state_number(to, "frames", device->frames);
}

static void line_frame(const void *self, struct dg_line_frame *to)
{
    to->bits = DG_TENBIT_BITS;
    to->open = ((const struct dg_tenbit *)self)->model->open;
}

static bool clock_of(const void *self)
{
    return ((const struct dg_tenbit *)self)->clock;
}

/* clang-format off */
static const struct dg_fault_row faults[] = {
    {"wire_drop",   DG_FAULT_ON_WIRE(DROP),   0,                 "the line driver is broken now and then", "the line reads as nobody drives it, for the word", "W1"},
    {"wire_delay",  DG_FAULT_ON_WIRE(DELAY),  (int64_t)DG_US(3), "the cable is too long for the clock", "each bit is read some clocks late", "W1"},
    {"wire_damage", DG_FAULT_ON_WIRE(DAMAGE), 0,                 "a disturbance on the line", "one bit of the word is flipped", "W1"},
    {"wire_break",  DG_FAULT_ON_WIRE(BREAK),  0,                 "a wire of the data line is broken", "the line reads as nobody drives it", "W1"},
};
/* clang-format on */

const struct dg_instrument dg_tenbit_instrument = {
    .stack = &dg_tenbit_stack,
    .faults = faults,
    .fault_count = DG_COUNT(faults),
    .mode = mode,
    .state = state,
    .line_frame = line_frame,
    .clock = clock_of,
};
