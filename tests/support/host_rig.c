/* SPDX-License-Identifier: MIT */
#include "host_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

struct host_rig_place host_rig_here;
struct host_rig_place host_rig_there;

/* What each protocol is to a host. */
#define HIPERFACE "hiperface", &dg_hf_wire, DG_HOST_MEDIUM_CHARACTERS, "address"
#define BISS "biss", &dg_biss_wire, DG_HOST_MEDIUM_EDGES, NULL
#define SSI "ssi", &dg_ssi_wire, DG_HOST_MEDIUM_EDGES, NULL
#define CANOPEN "canopen", &dg_cia406_wire, DG_HOST_MEDIUM_FRAMES, "node"
#define INTERBUS "interbus", &dg_ib_wire, DG_HOST_MEDIUM_WORDS, NULL

/* clang-format off */
const struct host_rig_model host_rig_models[] = {
    /* name         resolution                                 multi  memory wire       position at 3.25 turns    width */
    {"s3674-rs485", "2048 periods x 32 steps, singleturn",     false, true,  HIPERFACE, 16384,                    0},
    {"s3684-rs485", "2048 periods x 32 steps, 4096 turns",     true,  true,  HIPERFACE, 3 * 65536 + 16384,        0},
    {"s3674-biss",  "21 bit, singleturn",                      true,  true,  BISS,      1u << 19,                 21 + 2 + 6 + 6},
    {"s3684-biss",  "21 bit, 4096 turns",                      true,  true,  BISS,      3u << 21 | 1u << 19,      12 + 21 + 2 + 6 + 6},
    {"ssi-13",      "13 bit Gray, singleturn",                 false, false, SSI,       1u << 11,                 13},
    {"ssi-25",      "13 bit Gray, 4096 turns",                 true,  false, SSI,       3u << 13 | 1u << 11,      25},
    {"ssi-28",      "16 bit, 4096 turns, error bit, parity",   true,  false, SSI,       3u << 16 | 1u << 14,      12 + 16 + 1 + 1},
    {"f3658",       "65536 steps, singleturn",                 false, true,  CANOPEN,   16384,                    0},
    {"f3668",       "65536 steps, 4096 turns",                 true,  true,  CANOPEN,   3 * 65536 + 16384,        0},
    {"ocd-ib-k1",   "4096 steps, singleturn",                  false, false, INTERBUS,  1024,                     2},
    {"ocd-ib-k2",   "4096 steps, 4096 turns",                  true,  false, INTERBUS,  3 * 4096 + 1024,          4},
    {"ocd-ib-k3",   "4096 steps, 4096 turns, parameters",      true,  true,  INTERBUS,  3 * 4096 + 1024,          4},
};
/* clang-format on */
const size_t host_rig_model_count = DG_COUNT(host_rig_models);

const struct host_rig_model *host_rig_model(const char *name)
{
    const struct host_rig_model *found = NULL;

    for (size_t i = 0; i < host_rig_model_count; i++) {
        found = strcmp(host_rig_models[i].name, name) == 0 ? &host_rig_models[i] : found;
    }
    assert_non_null(found);
    return found;
}

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
