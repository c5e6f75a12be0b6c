/* SPDX-License-Identifier: MIT */
/*
 * What a bus asks of an F36x8: what its CAN controller sees.
 */
#include "drehgeber/cia406.h"
#include "drehgeber/host_wire.h"

/* An SDO server's answers, and the one to LSS. */
#define ID_SDO 0x580u
#define ID_LSS 0x7E4u

_Static_assert(DG_HOST_FILTERS == DG_CO_FILTERS_MAX, "a node has no more");
_Static_assert(DG_HOST_SHARED == DG_CO_SHARED_MAX, "a node has no more");

static uint32_t version(const void *self)
{
    const struct dg_cia406_device *device = self;

    return (uint32_t)device->node.filter_version << 8 | device->node.bit_rate;
}

/* One that was never on is all zero, and so has no device. */
static bool is_made(const struct dg_co_node *node)
{
    return node->setup.device != NULL;
}

static uint8_t listens(const void *self, uint16_t ids[DG_HOST_FILTERS])
{
    const struct dg_cia406_device *device = self;

    return is_made(&device->node) ? dg_co_filters(&device->node, ids) : 0;
}

static uint32_t bit_rate(const void *self)
{
    const struct dg_co_node *node = &((const struct dg_cia406_device *)self)->node;

    return is_made(node) ? 1000u * node->setup.device->kbaud[node->bit_rate] : 0;
}

static uint32_t address(const void *self)
{
    const struct dg_cia406_device *device = self;

    return device->node.id;
}

static uint8_t shared(const void *self, uint16_t ids[DG_HOST_SHARED])
{
    const struct dg_cia406_device *device = self;

    return is_made(&device->node) ? dg_co_shared_ids(&device->node, ids) : 0;
}

static bool is_news(const void *self, enum dg_host_bus event)
{
    const struct dg_cia406_device *device = self;
    const struct dg_co_node *node = &device->node;

    if (!is_made(node) || event == DG_HOST_BUS_ABSENT) {
        return is_made(node) && !node->bus_absent;
    }
    return node->bus_absent || (!node->bus_found && node->state != DG_CO_OFF);
}

/* Only an answer acknowledges. */
static bool acknowledges(const void *self, uint32_t id)
{
    const struct dg_cia406_device *device = self;

    return id == ID_SDO + device->node.id || id == ID_LSS;
}

static const struct dg_host_controller controller = {
    .version = version,
    .listens = listens,
    .bit_rate = bit_rate,
    .address = address,
    .shared = shared,
    .is_news = is_news,
    .acknowledges = acknowledges,
};

const struct dg_bus_side dg_cia406_side = {
    .wire = &dg_cia406_wire,
    .controller = &controller,
};
