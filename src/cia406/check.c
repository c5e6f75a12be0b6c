/* SPDX-License-Identifier: MIT */
/*
 * States that somebody has made: what a device goes by, and whether it fits together.
 */
#include <string.h>

#include "cia406_private.h"

/* Of a block of an SDO (CiA 301). */
#define SEGMENTS_MAX 127u

#define OF_NODE(member, max) DG_STACK_RANGE(dg_cia406_device, node.member, 0, max)
#define OF_EACH(n)                                                                                 \
    OF_NODE(tpdo[n].valid, 1), OF_NODE(tpdo[n].rtr_allowed, 1), OF_NODE(tpdo[n].pending, 1),       \
        OF_NODE(tpdo[n].sampled, 1)

static const struct dg_stack_range ranges[] = {
    OF_NODE(store.region_count, DG_STORE_REGIONS_MAX),
    OF_NODE(store.unapplied, 1),
    OF_NODE(mounted, 1),
    OF_NODE(emcy_count, DG_CO_HISTORY),
    OF_NODE(emcy_first, DG_CO_HISTORY - 1u),
    OF_NODE(history_count, DG_CO_HISTORY),
    OF_NODE(history_newest, DG_CO_HISTORY - 1u),
    OF_NODE(guard_toggle, 1),
    OF_NODE(bus_off, 1),
    OF_NODE(bus_absent, 1),
    OF_NODE(bus_found, 1),
    OF_NODE(lss.configuration, 1),
    OF_NODE(lss.changed, 1),
    OF_NODE(sdo.state, DG_CO_SDO_STATE_COUNT - 1u),
    OF_NODE(sdo.sized, 1),
    OF_NODE(sdo.crc, 1),
    OF_NODE(sdo.seqno, SEGMENTS_MAX),
    OF_NODE(sdo.blksize, SEGMENTS_MAX),
    OF_EACH(0),
    OF_EACH(1),
    OF_EACH(2),
    OF_EACH(3),
    DG_STACK_BOOL(dg_cia406_device, encoder.usf_lost),
    DG_STACK_BOOL(dg_cia406_device, encoder.zero_unsaved),
    DG_STACK_BOOL(dg_cia406_device, encoder.serial_open),
    DG_STACK_RANGE(dg_cia406_device, encoder.wrong_count, 0, PASSWORD_DELAYS_MAX),
};
_Static_assert(DG_CO_TPDOS == 4, "a row for each");

/* Which dictionary there is goes by the turns, or comes from a file. */
static bool fits(const void *own, const void *settings, const void *device)
{
    const struct dg_cia406_settings *mine = own;
    struct dg_cia406_settings theirs;
    struct dg_cia406_device self;

    memcpy(&theirs, settings, sizeof theirs);
    memcpy(&self, device, sizeof self);
    if ((theirs.model.turns == 1) != (mine->model.turns == 1)) {
        return false;
    }
    theirs.model.device = mine->model.device;
    dg_cia406_settings_apply(&theirs);
    self.node.setup.device = theirs.model.device;
    return self.node.store.region_count <= theirs.model.device->layout->region_count &&
           dg_co_fits(&self.node);
}

const struct dg_stack_check dg_cia406_check = {ranges, DG_COUNT(ranges), fits};
