/* SPDX-License-Identifier: MIT */
/*
 *   encoder -- cut or bus-off? drop? -- delay, damage, duplicate --> wire
 *   wire -- cut or bus-off? deaf? overrun? --> encoder
 *
 * A fault that happens counts down, so what an earlier one has taken away is not asked further.
 */
#include "drehgeber/wire_fault.h"

#define BITS_PER_BYTE 8u

static bool is_cut_off(const struct dg_faults *faults)
{
    return dg_fault_wire_active(faults, DG_WIRE_BREAK) ||
           dg_fault_wire_active(faults, DG_WIRE_BUS_OFF);
}

/* What has no bytes has no bit to flip. */
static void flip_bit(struct dg_faults *faults, size_t length, struct dg_wire_sent *sent)
{
    if (length > 0 && dg_fault_wire_takes(faults, DG_WIRE_DAMAGE)) {
        const uint32_t bit = dg_fault_pick(faults, BITS_PER_BYTE * (uint32_t)length);
        sent->damaged = bit / BITS_PER_BYTE;
        sent->flip = (uint8_t)(1u << bit % BITS_PER_BYTE);
    }
}

struct dg_wire_sent dg_wire_fault_send(struct dg_encoder *encoder, size_t length)
{
    struct dg_faults *faults = &encoder->faults;
    struct dg_wire_sent sent = DG_WIRE_UNBENT;

    if (faults->wire == 0) {
        return sent;
    }
    if (is_cut_off(faults) || dg_fault_wire_takes(faults, DG_WIRE_DROP)) {
        sent.times = 0;
        return sent;
    }
    if (dg_fault_wire_takes(faults, DG_WIRE_DELAY)) {
        sent.delay = (dg_ns)dg_fault_wire_value(encoder->instrument, DG_WIRE_DELAY);
    }
    flip_bit(faults, length, &sent);
    sent.times += dg_fault_wire_takes(faults, DG_WIRE_DUPLICATE) ? 1u : 0u;
    return sent;
}

enum dg_wire_heard dg_wire_fault_hear(struct dg_encoder *encoder)
{
    struct dg_faults *faults = &encoder->faults;

    if (faults->wire == 0) {
        return DG_WIRE_HEARD;
    }
    if (is_cut_off(faults) || dg_fault_wire_takes(faults, DG_WIRE_DEAF)) {
        return DG_WIRE_UNHEARD;
    }
    return dg_fault_wire_takes(faults, DG_WIRE_OVERRUN) ? DG_WIRE_LOST : DG_WIRE_HEARD;
}
