/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The same encoder, made of its EDS file.
 */
#ifndef TESTS_CONFORMANCE_CANOPEN_FROM_EDS_H
#define TESTS_CONFORMANCE_CANOPEN_FROM_EDS_H

#include "drehgeber/cia406.h"

/** With DREHGEBER_FROM_EDS in the environment a device that was made of the EDS file of `device`,
 * until the next call; NULL: its file cannot be read. Otherwise `device`, as for the one with 65536
 * turns, of which 6502h does not say how many there are. */
const struct dg_co_device *canopen_from_eds(const struct dg_co_device *device);

#endif
