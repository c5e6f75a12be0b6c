/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the two halves of the SDO server share: co_sdo.c (expedited, segmented, the dispatcher) and
 * co_block.c (block transfer).
 */
#ifndef DREHGEBER_CO_BLOCK_H
#define DREHGEBER_CO_BLOCK_H

#include "canopen_private.h"

/** Bytes of data in a segment. */
#define SDO_SEGMENT 7u

/** Bits and fields of byte 0 that both halves use. */
enum sdo_command {
    SDO_ABORT = 0x80,
    SDO_LAST = 0x80, /* of a block's segment: no more follow */
};

/** A request's handler; `data` are the 8 bytes. What it returns other than DG_CO_OK is sent. */
typedef enum dg_co_abort sdo_handler(struct dg_co_node *self, const uint8_t *data);

/* co_sdo.c */

/** Wait in `state`, for a request or the timeout; DG_CO_SDO_IDLE waits for nothing. */
void co_sdo_become(struct dg_co_node *self, enum dg_co_sdo_state state);
/** Answer: byte 0, `n` bytes of at most 7, zeros. Held back when a hook has asked for it. */
void co_sdo_send(struct dg_co_node *self, uint8_t command, const uint8_t *bytes, uint8_t n);
/** The same with seven bytes. */
void co_sdo_send_segment(struct dg_co_node *self, uint8_t command, const uint8_t *bytes);
/** Answer: byte 0, the multiplexor, 32 bits. */
void co_sdo_confirm(struct dg_co_node *self, uint8_t command, uint32_t value);
/** Read the object into the buffer. */
enum dg_co_abort co_sdo_fetch(struct dg_co_node *self);
/** Answer an upload request with what is in the buffer, expedited if it fits. */
void co_sdo_upload(struct dg_co_node *self);
/** Begin a download: the object must exist, be writable and, if `sized`, have `size` bytes. */
enum dg_co_abort co_sdo_open(struct dg_co_node *self, bool sized, uint32_t size);
/** What is wrong with a download of `length` bytes. */
enum dg_co_abort co_sdo_length(const struct dg_co_node *self, uint32_t length);
/** Write the buffer to the object. The transfer is over, unless a hook delays the answer. */
enum dg_co_abort co_sdo_write(struct dg_co_node *self);

/* co_block.c: requests of block transfers */
sdo_handler co_block_upload, co_block_upload_start, co_block_upload_acknowledge;
sdo_handler co_block_upload_end;
sdo_handler co_block_download, co_block_download_segment, co_block_download_end;

#endif
