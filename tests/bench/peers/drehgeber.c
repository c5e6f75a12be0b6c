/* SPDX-License-Identifier: MIT */
/* This project: the F3668 with its profile, or its dictionary as plain values, as size/ has them.
 */
#include <string.h>

#include "canopen_device.h"
#include "peer.h"
#include "ram_nvm.h"

static struct dg_co_node node;
static struct dg_world world;
static struct ram_nvm nvm;
static dg_ns now;
static dg_ns due;

static void report_frame(void *ctx, const struct dg_can_frame *frame)
{
    (void)ctx;
    from_peer(frame->id, frame->dlc, frame->data);
}

static dg_angle angle(void *ctx, dg_ns at)
{
    (void)ctx;
    return (dg_angle)at;
}

/* The second TPDO with 6004h on every SYNC: so delivered is the F3668, not its plain dictionary. */
static void map_position(void)
{
    static const struct peer_frame writes[] = {
        {0x600u + NODE_ID, 8, {0x23, 0x01, 0x18, 1, 0x80u | 0x3Fu, 0x02, 0, 0x80}},
        {0x600u + NODE_ID, 8, {0x2F, 0x01, 0x18, 2, 1}},
        {0x600u + NODE_ID, 8, {0x2F, 0x01, 0x1A, 0, 0}},
        {0x600u + NODE_ID, 8, {0x23, 0x01, 0x1A, 1, 0x20, 0x00, 0x04, 0x60}},
        {0x600u + NODE_ID, 8, {0x2F, 0x01, 0x1A, 0, 1}},
        {0x600u + NODE_ID, 8, {0x23, 0x01, 0x18, 1, 0x80u | 0x3Fu, 0x02, 0, 0}},
    };
    for (size_t i = 0; i < sizeof writes / sizeof writes[0]; i++) {
        to_peer(&writes[i]);
    }
}

bool peer_start(void)
{
    static const struct dg_co_ops ops = {.send = report_frame};
    const struct dg_co_setup setup = {.device = device,
                                      .world = &world,
                                      .nvm = ram_nvm_port(&nvm),
                                      .ops = &ops,
                                      .application = device_start()};

    dg_world_init(&world);
    world.angle = angle;
    ram_nvm_init(&nvm, dg_store_size(device->layout));
    if (dg_co_format(device, setup.nvm, 1) != DG_OK ||
        dg_co_burn_node_id(device, setup.nvm, NODE_ID) != DG_OK ||
        dg_co_init(&node, &setup) != DG_OK || dg_co_power_on(&node, 0) != DG_OK) {
        return false;
    }
    map_position();
    return true;
}

void to_peer(const struct peer_frame *frame)
{
    struct dg_can_frame own = {.id = frame->id, .dlc = frame->dlc};

    memcpy(own.data, frame->data, sizeof own.data);
    now += DG_US(100);
    due = dg_co_rx(&node, now, &own);
}

void peer_wait(void)
{
    now += DG_MS(1);
    if (now >= due) {
        due = dg_co_step(&node, now);
    }
}
