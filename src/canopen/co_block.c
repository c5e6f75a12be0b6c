/* SPDX-License-Identifier: MIT */
/*
 * SDO block transfer (CiA 301): segments in a row with one acknowledgement, CRC over the data.
 *
 *   upload    client  A0h        A3h                    A2h n          A1h
 *             server       C2h        01h 02h .. 8nh          C1h crc
 *
 *   download  client  C0h        01h 02h .. 8nh         C1h crc
 *             server       A0h                    A2h n          A1h
 *
 * An acknowledgement names the last segment that came in order; the ones behind it are repeated
 * in the next block, numbered from 1 again.
 */
#include <string.h>

#include "co_block.h"
#include "drehgeber/crc.h"

/**
 * Bits of the initiate requests and answers. A CRC is used when both sides offer it; this side
 * does so only to a client that has, as some clients look at the answer alone.
 */
#define CRC 0x04u
#define SIZE 0x02u

/**
 * Segments of a block this server receives. More than any object needs, as writable objects have 4
 * bytes at most. Below 20h, so that a new request is told from a sequence number.
 */
#define DOWNLOAD_BLKSIZE 5u
_Static_assert(DOWNLOAD_BLKSIZE < 0x20u, "20h is a download request");
_Static_assert(sizeof((struct dg_co_sdo *)0)->buffer >= (size_t)DOWNLOAD_BLKSIZE * SDO_SEGMENT,
               "a block fits the buffer");

/* ---- upload */

enum dg_co_abort dg_co_block_upload(struct dg_co_node *self, const uint8_t *data)
{
    struct dg_co_sdo *sdo = &self->sdo;

    sdo->blksize = data[4];
    sdo->crc = (data[0] & CRC) != 0;
    dg_co_sdo_become(self, DG_CO_SDO_BLOCK_UPLOAD_START);
    return co_sdo_confirm(self, 0xC0u | SIZE | CRC, sdo->length);
}

/* One block from the first byte that is not confirmed. */
static enum dg_co_abort send_block(struct dg_co_node *self)
{
    struct dg_co_sdo *sdo = &self->sdo;
    uint8_t at = sdo->done;
    bool last;

    sdo->seqno = 0;
    do {
        last = sdo->length - at <= (int)SDO_SEGMENT;
        sdo->seqno++;
        (void)dg_co_sdo_send_segment(self, (uint8_t)(sdo->seqno | (last ? SDO_LAST : 0u)),
                                     &sdo->buffer[at]);
        at = (uint8_t)(at + SDO_SEGMENT);
    } while (!last && sdo->seqno < sdo->blksize);
    dg_co_sdo_become(self, DG_CO_SDO_BLOCK_UPLOAD);
    return DG_CO_OK;
}

enum dg_co_abort dg_co_block_upload_start(struct dg_co_node *self, const uint8_t *data)
{
    (void)data;
    return send_block(self);
}

enum dg_co_abort dg_co_block_upload_acknowledge(struct dg_co_node *self, const uint8_t *data)
{
    struct dg_co_sdo *sdo = &self->sdo;
    uint8_t ackseq = data[1];
    uint32_t crc = 0;

    if (ackseq > sdo->seqno) {
        return DG_CO_SEQUENCE;
    }
    if (!co_block_size_valid(data[2])) {
        return DG_CO_BLOCK_SIZE;
    }
    sdo->done = (uint8_t)(sdo->done + ackseq * SDO_SEGMENT);
    sdo->blksize = data[2];
    /* Without data there is still a segment to be confirmed. */
    if (ackseq < sdo->seqno || sdo->done < sdo->length) {
        return send_block(self);
    }
    if (sdo->crc) {
        crc = dg_crc16(0, sdo->buffer, sdo->length);
    }
    dg_co_sdo_become(self, DG_CO_SDO_BLOCK_UPLOAD_END);
    return dg_co_sdo_send(self, 0xC1u | (uint32_t)(sdo->done - sdo->length) << 2 | crc << 8, 0);
}

enum dg_co_abort dg_co_block_upload_end(struct dg_co_node *self, const uint8_t *data)
{
    (void)data;
    dg_co_sdo_become(self, DG_CO_SDO_IDLE);
    return DG_CO_OK;
}

/* ---- download */

enum dg_co_abort dg_co_block_download(struct dg_co_node *self, const uint8_t *data)
{
    struct dg_co_sdo *sdo = &self->sdo;
    enum dg_co_abort abort =
        dg_co_sdo_open(self, data, (data[0] & SIZE) != 0, dg_load_le32(&data[4]));

    if (abort != DG_CO_OK) {
        return abort;
    }
    sdo->crc = (data[0] & CRC) != 0;
    sdo->seqno = 0;
    dg_co_sdo_become(self, DG_CO_SDO_BLOCK_DOWNLOAD);
    return co_sdo_confirm(self, 0xA0u | CRC, DOWNLOAD_BLKSIZE);
}

enum dg_co_abort dg_co_block_download_segment(struct dg_co_node *self, const uint8_t *data)
{
    struct dg_co_sdo *sdo = &self->sdo;
    uint8_t seqno = data[0] & 0x7Fu;
    bool last = (data[0] & SDO_LAST) != 0;
    bool in_order = seqno == sdo->seqno + 1;
    bool complete = last && in_order;

    if (seqno == 0 || seqno > DOWNLOAD_BLKSIZE) {
        return DG_CO_SEQUENCE;
    }
    dg_co_sdo_become(self, complete ? DG_CO_SDO_BLOCK_DOWNLOAD_END : DG_CO_SDO_BLOCK_DOWNLOAD);
    if (in_order) {
        memcpy(&sdo->buffer[sdo->length], &data[1], SDO_SEGMENT);
        sdo->length = (uint8_t)(sdo->length + SDO_SEGMENT);
        sdo->seqno = seqno;
    }
    if (!last && seqno < DOWNLOAD_BLKSIZE) {
        return DG_CO_OK;
    }
    /* The block is over; the client listens only now. A whole segment with more to come is more
     * than any object takes. */
    if (!complete && sdo->length > 0) {
        return dg_co_sdo_length(self, sdo->length);
    }
    return dg_co_sdo_send(self, 0xA2u | (uint32_t)sdo->seqno << 8 | DOWNLOAD_BLKSIZE << 16, 0);
}

enum dg_co_abort dg_co_block_download_end(struct dg_co_node *self, const uint8_t *data)
{
    struct dg_co_sdo *sdo = &self->sdo;
    uint8_t unused = data[0] >> 2 & 7u;

    sdo->length = (uint8_t)(sdo->length - unused);
    enum dg_co_abort abort = dg_co_sdo_length(self, sdo->length);
    if (abort == DG_CO_OK && sdo->crc &&
        dg_crc16(0, sdo->buffer, sdo->length) != dg_load_le16(&data[1])) {
        abort = DG_CO_CRC;
    }
    if (abort == DG_CO_OK) {
        abort = dg_co_sdo_write(self);
    }
    return abort == DG_CO_OK ? dg_co_sdo_written(self, 0xA1) : abort;
}
