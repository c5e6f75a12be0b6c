/* SPDX-License-Identifier: MIT */
/*
 * What a host goes by that knows no protocols.
 */
#include "host_private.h"

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
