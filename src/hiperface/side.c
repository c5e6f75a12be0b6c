/* SPDX-License-Identifier: MIT */
/*
 * What a bus asks of an encoder with RS485.
 */
#include "drehgeber/hiperface.h"
#include "drehgeber/host_wire.h"

/* A memory that was silent when power came on was not read. */
static int address(const struct dg_host_line *line)
{
    const struct dg_hf *device = line->device;
    const bool known =
        device->store.layout != NULL && !dg_store_damaged(&device->store, DG_HF_REGION_UART);

    return known ? device->address : -1;
}

static bool wants(const struct dg_host_line *line, uint8_t byte)
{
    const struct dg_hf *device = line->device;

    return byte == device->address || byte == DG_HF_ADDRESS_BROADCAST;
}

const struct dg_bus_side dg_hf_side = {
    .wire = &dg_hf_wire,
    .wants = wants,
    .address = address,
};
