/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A simulated wire of a rig, for what a protocol offers besides (lx_clocked_protocol.offer).
 */
#ifndef DREHGEBER_LINUX_SIM_BUS_H
#define DREHGEBER_LINUX_SIM_BUS_H

#include "bus.h"
#include "clocked.h"

/** Its line, for who has a master of its own and does not open the bus. */
struct lx_clocked *lx_sim_bus_line(struct lx_bus *bus);

/** What the plan says of its master, behind its bus. */
struct dg_bus_master_setup lx_sim_bus_master(const struct lx_bus *bus);

/** Its master, at the present moment; nothing else may happen on the wire up to lx_sim_bus_end().
 */
struct dg_bus_master *lx_sim_bus_begin(struct lx_bus *bus);

/** Let the master read a frame out of turn. In between. */
void lx_sim_bus_read(struct lx_bus *bus);

/** The master goes on reading by itself. */
void lx_sim_bus_end(struct lx_bus *bus);

/** All three, for a command. @return the master; NULL: no answer, as `detail` says */
const struct dg_bus_master *lx_sim_bus_ask(struct lx_bus *bus, char *detail);

#endif
