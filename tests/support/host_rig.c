/* SPDX-License-Identifier: MIT */
#include "host_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

struct host_rig_place host_rig_here;
struct host_rig_place host_rig_there;

const struct host_rig_model host_rig_models[] = {
    {"s3674-rs485", "hiperface", 16384, 0},
    {"s3684-rs485", "hiperface", 3 * 65536 + 16384, 0},
    {"s3674-biss", "biss", 1u << 19, 21 + 2 + 6 + 6},
    {"s3684-biss", "biss", 3u << 21 | 1u << 19, 12 + 21 + 2 + 6 + 6},
    {"f3658", "canopen", 16384, 0},
    {"f3668", "canopen", 3 * 65536 + 16384, 0},
    {"ocd-ib-k1", "interbus", 1024, 2},
    {"ocd-ib-k2", "interbus", 3 * 4096 + 1024, 4},
    {"ocd-ib-k3", "interbus", 3 * 4096 + 1024, 4},
    {"ssi-25", "ssi", 3u << 13 | 1u << 11, 25},
    {"ssi-13", "ssi", 1u << 11, 13},
    {"ssi-28", "ssi", 3u << 16 | 1u << 14, 12 + 16 + 1 + 1},
};
const size_t host_rig_model_count = sizeof host_rig_models / sizeof host_rig_models[0];

struct dg_host *host_rig_make(struct host_rig_place *place, const char *name)
{
    memset(place, 0xA5, sizeof *place);
    return dg_host_make(place, sizeof *place, name);
}

struct dg_host *host_rig_start(struct host_rig_place *place, const char *name)
{
    struct dg_host *self = host_rig_make(place, name);

    assert_non_null(self);
    dg_host_shaft(self, 0, 3 * TURN + TURN / 4, 0);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_true(dg_host_step(self, READY) > READY);
    return self;
}

void host_rig_drain(struct dg_host *self)
{
    struct dg_host_event event;

    while (dg_host_receive(self, &event) > 0) {
    }
}
