/* SPDX-License-Identifier: MIT */
/** A ring of INTERBUS encoders without a master. What goes wrong in here fails the test. */
#ifndef TESTS_SUPPORT_MODBUS_RIG_H
#define TESTS_SUPPORT_MODBUS_RIG_H

#include "engine.h"
#include "modbus_ring.h"
#include "plan_rig.h"

/** A ring. Not to be moved while open. */
struct modbus_rig {
    struct dg_plan plan;
    struct lx_engine engine;
    struct lx_ring ring;
};

/** A plan of these models; settings and files may be added then. */
void modbus_rig_plan(struct modbus_rig *self, const struct dg_device *const *models, size_t count);

/** KEY=VALUE for one of them. */
void modbus_rig_set(struct modbus_rig *self, size_t index, const char *assignment);

/** Switch it on at `now`; `angle`, `ctx`: where all shafts are, NULL: at 0.
 * @return as lx_ring_open() */
int modbus_rig_open(struct modbus_rig *self, dg_angle (*angle)(void *ctx, dg_ns now), void *ctx,
                    dg_ns now, struct lx_error *error);

/** Give it back, with its plan; also when it was refused. */
void modbus_rig_close(struct modbus_rig *self);

#endif
