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
void dg_co_sdo_become(struct dg_co_node *self, enum dg_co_sdo_state state);
/** Answer with these bytes, least significant first. These five return DG_CO_OK, for handlers that
 * end with them. */
enum dg_co_abort dg_co_sdo_send(struct dg_co_node *self, uint32_t low, uint32_t high);
/** Byte 0, and seven more. */
enum dg_co_abort dg_co_sdo_send_segment(struct dg_co_node *self, uint8_t command,
                                        const uint8_t *bytes);
/** Byte 0, the multiplexor, 32 bits. */
static inline enum dg_co_abort co_sdo_confirm(struct dg_co_node *self, uint32_t command,
                                              uint32_t value)
{
    return dg_co_sdo_send(self, command | self->sdo.multiplexor, value);
}
/** Byte 0 and, with this one, the multiplexor: a download is complete, or has begun. Held back when
 * a hook has asked for it. */
#define WRITTEN_AT_ONCE 0x60u
enum dg_co_abort dg_co_sdo_written(struct dg_co_node *self, uint8_t command);
/** Begin a download: the object must exist, be writable and, if `sized`, have `size` bytes. */
enum dg_co_abort dg_co_sdo_open(struct dg_co_node *self, const uint8_t *data, bool sized,
                                uint32_t size);
/** What is wrong with a download of `length` bytes. */
enum dg_co_abort dg_co_sdo_length(const struct dg_co_node *self, uint32_t length);
/** Write the buffer to the object. The transfer is over, unless a hook delays the answer. */
enum dg_co_abort dg_co_sdo_write(struct dg_co_node *self);

/* co_block.c: requests of block transfers */

/** Whether a client may ask for so many segments in a block. */
static inline bool co_block_size_valid(uint8_t blksize)
{
    return blksize > 0 && blksize <= 127u;
}
/** Offers what is in the buffer. */
sdo_handler dg_co_block_upload;
sdo_handler dg_co_block_upload_start, dg_co_block_upload_acknowledge;
sdo_handler dg_co_block_upload_end;
sdo_handler dg_co_block_download, dg_co_block_download_segment, dg_co_block_download_end;

#endif
