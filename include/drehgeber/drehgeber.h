/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Everything of the library. Version numbers follow semver; the version of the library linked
 * against is dg_version().
 */
#ifndef DREHGEBER_DREHGEBER_H
#define DREHGEBER_DREHGEBER_H

#include "drehgeber/angle.h"
#include "drehgeber/api.h"
#include "drehgeber/bits.h"
#include "drehgeber/bus.h"
#include "drehgeber/bus_characters.h"
#include "drehgeber/bus_frames.h"
#include "drehgeber/bus_master.h"
#include "drehgeber/bus_queue.h"
#include "drehgeber/bus_reader.h"
#include "drehgeber/bus_words.h"
#include "drehgeber/canopen.h"
#include "drehgeber/control.h"
#include "drehgeber/course.h"
#include "drehgeber/crc.h"
#include "drehgeber/devices.h"
#include "drehgeber/eds.h"
#include "drehgeber/eds_rows.h"
#include "drehgeber/fault.h"
#include "drehgeber/figure.h"
#include "drehgeber/form.h"
#include "drehgeber/frame.h"
#include "drehgeber/hal.h"
#include "drehgeber/host.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/instrument.h"
#include "drehgeber/instruments.h"
#include "drehgeber/key.h"
#include "drehgeber/model.h"
#include "drehgeber/motion.h"
#include "drehgeber/protocols.h"
#include "drehgeber/quantity.h"
#include "drehgeber/rfc2217.h"
#include "drehgeber/rig.h"
#include "drehgeber/rig_engine.h"
#include "drehgeber/ring_coupler.h"
#include "drehgeber/ring_master.h"
#include "drehgeber/scpi.h"
#include "drehgeber/shaft.h"
#include "drehgeber/slcan.h"
#include "drehgeber/stack.h"
#include "drehgeber/stamp.h"
#include "drehgeber/store.h"
#include "drehgeber/tap.h"
#include "drehgeber/text.h"
#include "drehgeber/time.h"
#include "drehgeber/version.h"
#include "drehgeber/wide.h"
#include "drehgeber/wire_fault.h"
#include "drehgeber/words.h"
#include "drehgeber/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/** "major.minor.patch" of the library. */
DG_API const char *dg_version(void);

#ifdef __cplusplus
}
#endif

#endif
