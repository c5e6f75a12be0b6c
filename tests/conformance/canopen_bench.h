/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Steps of the F36x8 that need nothing of the bench but its memory, or not even that.
 */
#ifndef TESTS_CONFORMANCE_CANOPEN_BENCH_H
#define TESTS_CONFORMANCE_CANOPEN_BENCH_H

#include "conformance.h"
#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/store.h"
#include "ram_nvm.h"

/** damage REGION OFFSET [MASK]: bytes that change by themselves */
bool canopen_damage(struct ram_nvm *nvm, const struct dg_store_layout *layout, char **words,
                    size_t n, struct cf_report *report);
/** stored REGION OFFSET BYTES: what an earlier release has left there, with its sum */
bool canopen_stored(struct ram_nvm *nvm, const struct dg_store_layout *layout, char **words,
                    size_t n, struct cf_report *report);
/** eds SECTION KEY VALUE|none: a line of the model's EDS file */
bool canopen_eds(const struct dg_device *device, char **words, size_t n, struct cf_report *report);

/** With DREHGEBER_FROM_EDS in the environment a device that was made of the EDS file of `device`,
 * until the next call; NULL: its file cannot be read. Otherwise `device`, as for the one with 65536
 * turns, of which 6502h does not say how many there are. */
const struct dg_co_device *canopen_from_eds(const struct dg_co_device *device);

#endif
