/* SPDX-License-Identifier: MIT */
/*
 * What a host goes by that knows no protocols.
 */
#include "host_private.h"

/* Start bit, eight of data, maybe parity, stop bit. */
#define BITS_WITHOUT_PARITY 10u

int dg_host_medium(const struct dg_host *self)
{
    return (int)self->refs.device->stack->medium;
}

const char *dg_host_address_key(const struct dg_host *self)
{
    return self->refs.device->stack->address_key;
}

int dg_host_uart(const struct dg_host *self, struct dg_host_uart *to)
{
    if (self->refs.wire->uart == NULL) {
        return DG_HOST_ERR_WIRE;
    }
    if (!dg_host_powered(self)) {
        return DG_HOST_ERR_STATE;
    }
    self->refs.wire->uart(&self->line, false, to);
    return DG_HOST_OK;
}

uint64_t dg_host_uart_ns(const struct dg_host_uart *uart, uint32_t count)
{
    const uint32_t bits = BITS_WITHOUT_PARITY + (uart->parity != 'N' ? 1u : 0u);

    return dg_bit_times_ns(bits * count, uart->baud);
}
