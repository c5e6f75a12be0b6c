/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EDS file (CiA 306) of a CANopen device, from the dictionary that the node works with: access,
 * defaults and limits from its rows, names from a list that only this is for. Who does not call it
 * does not carry it: it is in objects of its own, and no device points to a sheet.
 */
#ifndef DREHGEBER_EDS_H
#define DREHGEBER_EDS_H

#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/canopen.h"

#ifdef __cplusplus
extern "C" {
#endif

/** ObjectType of CiA 306. */
enum dg_co_kind {
    DG_CO_VAR = 0x7, /**< of a row */
    DG_CO_ARRAY = 0x8,
    DG_CO_RECORD = 0x9,
};

/** Name of a row, or of the array or record that the rows of an index belong to. */
struct dg_co_name {
    uint16_t index;
    uint8_t sub;  /**< of a row */
    uint8_t kind; /**< enum dg_co_kind */
    const char *text;
};

/** What an EDS file says of a device beside its dictionary. */
struct dg_co_sheet {
    const struct dg_co_device *device;
    const char *model;              /**< the file's name, without ".eds" */
    const char *resolution;         /**< in words */
    const char *vendor;             /**< name of the manufacturer */
    const struct dg_co_name *names; /**< of the device's rows */
    uint16_t name_count;
};

/**
 * Write the EDS file through `write`, in pieces of any length that are not terminated. It is the
 * same for every run of a version. `write` may do what it likes but change the sheet.
 */
DG_API void dg_co_eds(const struct dg_co_sheet *sheet,
                      void (*write)(void *ctx, const char *text, size_t n), void *ctx);

#ifdef __cplusplus
}
#endif

#endif
