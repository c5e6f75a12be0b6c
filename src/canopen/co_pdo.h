/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What co_pdo.c (TPDOs at work) and co_mapping.c (their parameters, 1800h and 1A00h) share.
 */
#ifndef DREHGEBER_SRC_CO_PDO_H
#define DREHGEBER_SRC_CO_PDO_H

#include "canopen_private.h"

/** Transmission types, and the ends of their ranges. */
enum co_pdo_type {
    CO_PDO_ACYCLIC = 0,
    CO_PDO_CYCLIC_MAX = 240,
    CO_PDO_REQUEST_SYNC = 252,
    CO_PDO_REQUEST = 253,
    CO_PDO_EVENT = 254, /* and 255 */
};

static inline uint32_t co_pdo_parameter(const struct dg_co_node *self, uint8_t n, uint8_t slot)
{
    return self->value[CO_TPDO(n, slot)];
}

static inline bool co_pdo_takes_events(uint8_t type)
{
    return type == CO_PDO_ACYCLIC || type >= CO_PDO_EVENT;
}

/** Forget events, samples and the phase of SYNC of TPDO `n`; its event timer runs from now. */
void co_pdo_restart(struct dg_co_node *self, uint8_t n);

#endif
