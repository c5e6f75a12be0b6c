/* SPDX-License-Identifier: MIT */
/*
 * A panel for any encoder: whoever calls this links every instrument.
 */
#include "drehgeber/instruments.h"
#include "host_private.h"

struct dg_host_panel *dg_host_panel_make(void *memory, size_t size, struct dg_host *host)
{
    return dg_host_panel_init(memory, size, host, dg_instrument_of(host->refs.device->stack));
}
