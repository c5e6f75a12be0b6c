/* SPDX-License-Identifier: MIT */
/*
 * Values of a file that 32 bits do not hold: texts, domains, numbers of 64 bits. The SDO server
 * refuses them, as it has no room for them, and what it refuses comes here:
 *
 *   40h, A0h, 2xh, C0h -> refused by the server -> one of these? -> DG_CO_SDO_DEVICE
 *   60h, A3h, 00h, 01h .. in DG_CO_SDO_DEVICE -> refused by the server -> the transfer goes on
 *
 * What is sent is a copy, and what comes in becomes the value when all of it is there. A block goes
 * out at the pace of the bus, a segment in each frame time, so that no queue has to take 127 of
 * them.
 *
 *   behind the cells   | transfer | length, 2 | bytes | length, 2 | bytes ...
 */
#include <string.h>

#include "co_block.h"
#include "co_file.h"
#include "co_sdo.h"
#include "drehgeber/crc.h"

/** Bits of requests and segments, as the server has them. */
#define TOGGLE 0x10u
#define NO_MORE 0x01u
#define EXPEDITED 0x02u
#define SIZED 0x01u
#define BLOCK 0x80u
#define BLOCK_CRC 0x04u
#define BLOCK_SIZE 0x02u
/** Segments of a block that comes in: a sequence number is none of the requests from 20h on. */
#define DOWNLOAD_BLKSIZE 0x1Fu
/** Bits of a frame with 8 bytes, stuffed as often as can be. */
#define FRAME_BITS 135u

/* What a transfer waits for, or does. */
enum step {
    STEP_NONE,
    STEP_UPLOAD,
    STEP_DOWNLOAD,
    STEP_BLOCK_UPLOAD_START,
    STEP_BLOCK_SENDING, /* segments go out, each at dg_co_sdo.deadline */
    STEP_BLOCK_UPLOAD,
    STEP_BLOCK_UPLOAD_END,
    STEP_BLOCK_DOWNLOAD,
    STEP_BLOCK_DOWNLOAD_END,
    STEP_COUNT
};
#define IN(step) (1u << (step))

/* What is not here is in dg_co_sdo: toggle, CRC, numbers of segments. */
struct transfer {
    uint16_t number;    /* of dg_co_file.longs */
    uint16_t length;    /* bytes */
    uint16_t announced; /* by the client, with dg_co_sdo.sized */
    uint16_t done;      /* bytes sent and, in a block upload, confirmed */
    uint8_t step;       /* enum step */
    bool over;          /* more has come in than the value takes */
    uint8_t bytes[DG_EDS_LONG_MAX + SDO_SEGMENT];
};

static struct transfer *transfer_of(const struct dg_co_node *node)
{
    uint8_t *application = node->setup.application;

    return (struct transfer *)(void *)(application + co_file_of(node)->longs_at);
}

static const struct dg_co_long *long_of(const struct dg_co_node *node)
{
    return &co_file_of(node)->longs[transfer_of(node)->number];
}

uint8_t *dg_co_long_bytes(const struct dg_co_node *node)
{
    return (uint8_t *)transfer_of(node) + sizeof(struct transfer);
}

/* Of one that has a place. */
static uint8_t *long_bytes_of(const struct dg_co_node *node, const struct dg_co_long *self)
{
    return dg_co_long_bytes(node) + self->at;
}

/* One behind the other, those that are kept in front. */
size_t dg_co_place_longs(struct dg_co_long *longs, uint16_t count, uint16_t *kept)
{
    size_t at = 0;

    for (uint16_t i = 0; i < count; i++) {
        const size_t size = EDS_LENGTH_SIZE + longs[i].most;
        longs[i].kept = eds_is_placed(&longs[i]) && at + size <= EDS_LONGS_KEPT;
        longs[i].at = (uint32_t)at;
        at += longs[i].kept ? size : 0u;
    }
    *kept = (uint16_t)at;
    for (uint16_t i = 0; i < count; i++) {
        if (eds_is_placed(&longs[i]) && !longs[i].kept) {
            longs[i].at = (uint32_t)at;
            at += EDS_LENGTH_SIZE + longs[i].most;
        }
    }
    return count == 0 ? 0 : sizeof(struct transfer) + at;
}

const struct dg_co_long *dg_co_find_long(const struct dg_co_file *self, uint32_t key)
{
    uint32_t first = 0;
    uint32_t last = self->long_count;

    while (first < last) {
        const uint32_t middle = first + (last - first) / 2u;
        if (self->longs[middle].key < key) {
            first = middle + 1u;
        } else {
            last = middle;
        }
    }
    return first < self->long_count && self->longs[first].key == key ? &self->longs[first] : NULL;
}

/* ------------------------------------------------------------ values */

static void store_long(const struct dg_co_node *node, const struct dg_co_long *self,
                       const uint8_t *bytes, uint16_t n)
{
    uint8_t *to = long_bytes_of(node, self);

    dg_store_le16(to, n);
    memcpy(to + EDS_LENGTH_SIZE, bytes, n);
}

void dg_co_reset_longs(const struct dg_co_node *node)
{
    const struct dg_co_file *file = co_file_of(node);

    for (uint16_t i = 0; i < file->long_count; i++) {
        const struct dg_co_long *one = &file->longs[i];
        if (eds_is_placed(one)) {
            store_long(node, one, one->initial, one->n);
        }
    }
}

/* @return how many bytes there are; those of a state that somebody has made are as many as fit */
static uint16_t read_long(const struct dg_co_node *node, const struct dg_co_long *self,
                          const uint8_t **bytes)
{
    *bytes = self->initial;
    if (!eds_is_placed(self)) {
        return self->n;
    }
    const uint8_t *from = long_bytes_of(node, self);
    const uint16_t n = dg_load_le16(from);
    *bytes = from + EDS_LENGTH_SIZE;
    return n < self->least ? self->least : n > self->most ? self->most : n;
}

/* A number with its sign. */
static uint64_t long_number_of(const struct dg_co_long *self, const uint8_t *bytes)
{
    const uint32_t unused = 8u * (8u - self->most);
    uint8_t whole[8] = {0};

    memcpy(whole, bytes, self->most);
    const uint64_t value = dg_load_le32(whole) | (uint64_t)dg_load_le32(&whole[4]) << 32;
    const uint64_t sign = self->kind == DG_CO_LONG_SIGNED ? UINT64_C(1) << (63u - unused) : 0;
    return (value ^ sign) - sign;
}

bool dg_co_long_is_inside(const struct dg_co_long *self, const uint8_t *bytes)
{
    if (self->kind == DG_CO_LONG_BYTES) {
        return true;
    }
    const uint64_t value = long_number_of(self, bytes);
    return self->kind == DG_CO_LONG_SIGNED
               ? (int64_t)value >= (int64_t)self->min && (int64_t)value <= (int64_t)self->max
               : value >= self->min && value <= self->max;
}

/* Both words of a number, or of the first 8 bytes. */
static enum dg_co_abort read_words(struct dg_co_node *node, const struct dg_co_long *self,
                                   uint32_t words[2])
{
    const uint8_t *bytes;
    uint8_t whole[8] = {0};

    if (self->bound.row != NULL) {
        return co_hook(&self->bound)(node, &self->bound, DG_CO_READ, words);
    }
    const uint16_t n = read_long(node, self, &bytes);
    memcpy(whole, bytes, n < sizeof whole ? n : sizeof whole);
    words[0] = dg_load_le32(whole);
    words[1] = dg_load_le32(&whole[4]);
    return DG_CO_OK;
}

/* For PDOs. The SDO server has no room for both: what it is refused comes here. */
enum dg_co_abort dg_co_hook_wide(struct dg_co_node *node, const struct dg_co_object *object,
                                 enum dg_co_op op, uint32_t *value)
{
    uint32_t words[2] = {0};

    (void)op;
    if (value == &node->sdo.value) {
        return DG_CO_HARDWARE;
    }
    const enum dg_co_abort abort =
        read_words(node, &co_file_of(node)->longs[object->row->initial], words);
    *value = words[object->row->slot];
    return abort;
}

/* ------------------------------------------------------------ upload */

/* Wait for the next request, or send. */
static void enter_step(struct dg_co_node *node, enum step step)
{
    transfer_of(node)->step = (uint8_t)step;
    dg_co_sdo_become(node, DG_CO_SDO_DEVICE);
}

/* A copy, with zeros behind it: whole segments are sent. */
static void fetch_stored(const struct dg_co_node *node)
{
    struct transfer *t = transfer_of(node);
    const uint8_t *bytes;

    t->length = read_long(node, long_of(node), &bytes);
    memcpy(t->bytes, bytes, t->length);
    memset(&t->bytes[t->length], 0, SDO_SEGMENT);
}

/* Of this moment. */
static enum dg_co_abort fetch_bound(struct dg_co_node *node)
{
    struct transfer *t = transfer_of(node);
    uint32_t words[2] = {0};

    if (node->setup.device->sample != NULL) {
        node->setup.device->sample(node);
    }
    const enum dg_co_abort abort = read_words(node, long_of(node), words);
    t->length = sizeof words;
    memset(t->bytes, 0, sizeof words + SDO_SEGMENT);
    dg_store_le32(t->bytes, words[0]);
    dg_store_le32(&t->bytes[4], words[1]);
    return abort;
}

static enum dg_co_abort fetch_long(struct dg_co_node *node)
{
    transfer_of(node)->done = 0;
    if (long_of(node)->bound.row != NULL) {
        return fetch_bound(node);
    }
    fetch_stored(node);
    return DG_CO_OK;
}

static enum dg_co_abort offer_blocks(struct dg_co_node *node, const uint8_t *data)
{
    node->sdo.blksize = data[4];
    node->sdo.crc = (data[0] & BLOCK_CRC) != 0;
    enter_step(node, STEP_BLOCK_UPLOAD_START);
    return co_sdo_confirm(node, 0xC0u | BLOCK_SIZE | BLOCK_CRC, transfer_of(node)->length);
}

/* A client of blocks may want short data without their protocol. */
static enum dg_co_abort begin_upload(struct dg_co_node *node, const uint8_t *data)
{
    const struct transfer *t = transfer_of(node);

    if ((long_of(node)->access & DG_CO_R) == 0) {
        return DG_CO_WRITE_ONLY;
    }
    const enum dg_co_abort abort = fetch_long(node);
    if (abort != DG_CO_OK) {
        return abort;
    }
    node->sdo.toggle = 0;
    if ((data[0] & BLOCK) != 0 && (data[5] == 0 || t->length > data[5])) {
        return offer_blocks(node, data);
    }
    if (t->length > 0 && t->length <= 4) {
        return co_sdo_confirm(node, 0x43u + 4u * (4u - t->length), dg_load_le32(t->bytes));
    }
    enter_step(node, STEP_UPLOAD);
    return co_sdo_confirm(node, 0x41, t->length);
}

static enum dg_co_abort begin_block_upload(struct dg_co_node *node, const uint8_t *data)
{
    return co_block_size_valid(data[4]) ? begin_upload(node, data) : DG_CO_BLOCK_SIZE;
}

static enum dg_co_abort send_segment(struct dg_co_node *node, const uint8_t *data)
{
    struct transfer *t = transfer_of(node);
    const uint8_t toggle = node->sdo.toggle;
    const uint8_t *bytes = &t->bytes[t->done];
    const uint32_t left = t->length - t->done;
    const uint32_t n = left < SDO_SEGMENT ? left : SDO_SEGMENT;

    if ((data[0] & TOGGLE) != toggle) {
        return DG_CO_TOGGLE;
    }
    node->sdo.toggle = toggle ^ TOGGLE;
    t->done = (uint16_t)(t->done + n);
    dg_co_sdo_become(node, n == left ? DG_CO_SDO_IDLE : DG_CO_SDO_DEVICE);
    return dg_co_sdo_send_segment(
        node, (uint8_t)(toggle | (SDO_SEGMENT - n) << 1 | (n == left ? NO_MORE : 0u)), bytes);
}

/* One block from the first byte that is not confirmed. */
static enum dg_co_abort start_block(struct dg_co_node *node, const uint8_t *data)
{
    (void)data;
    node->sdo.seqno = 0;
    enter_step(node, STEP_BLOCK_SENDING);
    node->sdo.deadline = node->now;
    return DG_CO_OK;
}

static void send_next(struct dg_co_node *node)
{
    const struct transfer *t = transfer_of(node);
    struct dg_co_sdo *sdo = &node->sdo;
    const uint32_t at = t->done + SDO_SEGMENT * sdo->seqno;
    const bool last = at + SDO_SEGMENT >= t->length;
    const uint32_t baud = 1000u * dg_co_kbaud(node->setup.device, node->bit_rate);

    sdo->seqno++;
    (void)dg_co_sdo_send_segment(node, (uint8_t)(sdo->seqno | (last ? SDO_LAST : 0u)),
                                 &t->bytes[at]);
    if (last || sdo->seqno >= sdo->blksize) {
        enter_step(node, STEP_BLOCK_UPLOAD);
    } else {
        sdo->deadline = dg_co_after(node->now, dg_bit_times_ns(FRAME_BITS, baud));
    }
}

static enum dg_co_abort take_confirmation(struct dg_co_node *node, const uint8_t *data)
{
    struct transfer *t = transfer_of(node);
    struct dg_co_sdo *sdo = &node->sdo;
    const uint8_t ackseq = data[1];
    uint32_t crc = 0;

    if (ackseq > sdo->seqno) {
        return DG_CO_SEQUENCE;
    }
    if (!co_block_size_valid(data[2])) {
        return DG_CO_BLOCK_SIZE;
    }
    t->done = (uint16_t)(t->done + ackseq * SDO_SEGMENT);
    sdo->blksize = data[2];
    /* Without data there is still a segment to be confirmed. */
    if (ackseq < sdo->seqno || t->done < t->length) {
        return start_block(node, data);
    }
    if (sdo->crc) {
        crc = dg_crc16(0, t->bytes, t->length);
    }
    enter_step(node, STEP_BLOCK_UPLOAD_END);
    return dg_co_sdo_send(node, 0xC1u | (uint32_t)(t->done - t->length) << 2 | crc << 8, 0);
}

static enum dg_co_abort end_upload(struct dg_co_node *node, const uint8_t *data)
{
    (void)data;
    dg_co_sdo_become(node, DG_CO_SDO_IDLE);
    return DG_CO_OK;
}

/* ------------------------------------------------------------ download */

/* What is wrong with `length` bytes; an announced size was right, so the client contradicts itself.
 */
static enum dg_co_abort judge_length(const struct dg_co_node *node, uint32_t length)
{
    const struct dg_co_long *self = long_of(node);

    if (node->sdo.sized && length != transfer_of(node)->announced) {
        return DG_CO_LENGTH;
    }
    return length > self->most ? DG_CO_TOO_LONG : length < self->least ? DG_CO_TOO_SHORT : DG_CO_OK;
}

/* Bytes that may come in. */
static uint32_t room_of(const struct dg_co_node *node)
{
    return node->sdo.sized ? transfer_of(node)->announced : long_of(node)->most;
}

static enum dg_co_abort open_download(struct dg_co_node *node, bool sized, uint32_t size)
{
    struct transfer *t = transfer_of(node);

    if ((long_of(node)->access & DG_CO_W) == 0) {
        return DG_CO_READ_ONLY;
    }
    node->sdo.sized = false;
    node->sdo.toggle = 0;
    t->length = 0;
    t->done = 0;
    t->over = false;
    const enum dg_co_abort abort = sized ? judge_length(node, size) : DG_CO_OK;
    node->sdo.sized = sized && abort == DG_CO_OK;
    t->announced = node->sdo.sized ? (uint16_t)size : 0;
    return abort;
}

/* @return what is wrong with all that has come in; else it is the value now */
static enum dg_co_abort write_long(struct dg_co_node *node)
{
    const struct transfer *t = transfer_of(node);
    const enum dg_co_abort abort = judge_length(node, t->length);

    if (abort != DG_CO_OK) {
        return abort;
    }
    if (!dg_co_long_is_inside(long_of(node), t->bytes)) {
        return DG_CO_RANGE;
    }
    dg_co_sdo_become(node, DG_CO_SDO_IDLE);
    const struct dg_co_long *self = long_of(node);
    if (self->bound.row != NULL) {
        uint32_t words[2] = {dg_load_le32(t->bytes), dg_load_le32(&t->bytes[4])};
        node->others = 0;
        return co_hook(&self->bound)(node, &self->bound, DG_CO_WRITE, words);
    }
    store_long(node, self, t->bytes, t->length);
    return DG_CO_OK;
}

/* 22h does not say how many bytes count: four, or as many as a shorter number has. */
static enum dg_co_abort write_at_once(struct dg_co_node *node, const uint8_t *data)
{
    struct transfer *t = transfer_of(node);
    const uint16_t most = long_of(node)->most;
    const uint32_t said = 4u - (data[0] >> 2 & 3u);

    t->length = (uint16_t)((data[0] & SIZED) != 0 ? said : most < 4u ? most : 4u);
    memcpy(t->bytes, &data[4], 4);
    return write_long(node);
}

static enum dg_co_abort begin_download(struct dg_co_node *node, const uint8_t *data)
{
    const bool expedited = (data[0] & EXPEDITED) != 0;
    const uint32_t size = expedited ? 4u - (data[0] >> 2 & 3u) : dg_load_le32(&data[4]);
    enum dg_co_abort abort = open_download(node, (data[0] & SIZED) != 0, size);

    if (abort == DG_CO_OK && expedited) {
        abort = write_at_once(node, data);
    } else if (abort == DG_CO_OK) {
        enter_step(node, STEP_DOWNLOAD);
    }
    return abort == DG_CO_OK ? dg_co_sdo_written(node, WRITTEN_AT_ONCE) : abort;
}

static enum dg_co_abort take_segment(struct dg_co_node *node, const uint8_t *data)
{
    struct transfer *t = transfer_of(node);
    const uint32_t n = SDO_SEGMENT - (data[0] >> 1 & 7u);
    const uint8_t answer = (uint8_t)(0x20u | (data[0] & TOGGLE));

    if ((data[0] & TOGGLE) != node->sdo.toggle) {
        return DG_CO_TOGGLE;
    }
    if (t->length + n > room_of(node)) {
        return node->sdo.sized ? DG_CO_LENGTH : DG_CO_TOO_LONG;
    }
    memcpy(&t->bytes[t->length], &data[1], n);
    t->length = (uint16_t)(t->length + n);
    node->sdo.toggle ^= TOGGLE;
    if ((data[0] & NO_MORE) == 0) {
        enter_step(node, STEP_DOWNLOAD);
        return dg_co_sdo_send(node, answer, 0);
    }
    const enum dg_co_abort abort = write_long(node);
    return abort == DG_CO_OK ? dg_co_sdo_written(node, answer) : abort;
}

static enum dg_co_abort begin_block_download(struct dg_co_node *node, const uint8_t *data)
{
    const enum dg_co_abort abort =
        open_download(node, (data[0] & BLOCK_SIZE) != 0, dg_load_le32(&data[4]));

    if (abort != DG_CO_OK) {
        return abort;
    }
    node->sdo.crc = (data[0] & BLOCK_CRC) != 0;
    node->sdo.seqno = 0;
    enter_step(node, STEP_BLOCK_DOWNLOAD);
    return co_sdo_confirm(node, 0xA0u | BLOCK_CRC, DOWNLOAD_BLKSIZE);
}

/* The last segment of all may have bytes that do not count. */
static void keep_segment(const struct dg_co_node *node, const uint8_t *bytes)
{
    struct transfer *t = transfer_of(node);

    t->over = t->over || (t->length > 0 && t->length >= room_of(node));
    if (!t->over) {
        memcpy(&t->bytes[t->length], bytes, SDO_SEGMENT);
        t->length = (uint16_t)(t->length + SDO_SEGMENT);
    }
}

static enum dg_co_abort take_block_segment(struct dg_co_node *node, const uint8_t *data)
{
    const struct transfer *t = transfer_of(node);
    struct dg_co_sdo *sdo = &node->sdo;
    const uint8_t seqno = data[0] & 0x7Fu;
    const bool last = (data[0] & SDO_LAST) != 0;
    const bool in_order = seqno == sdo->seqno + 1;

    if (seqno == 0 || seqno > DOWNLOAD_BLKSIZE) {
        return DG_CO_SEQUENCE;
    }
    enter_step(node, last && in_order ? STEP_BLOCK_DOWNLOAD_END : STEP_BLOCK_DOWNLOAD);
    if (in_order) {
        keep_segment(node, &data[1]);
        sdo->seqno = seqno;
    }
    if (!last && seqno < DOWNLOAD_BLKSIZE) {
        return DG_CO_OK;
    }
    /* The block is over; the client listens only now. */
    if (t->over) {
        return sdo->sized ? DG_CO_LENGTH : DG_CO_TOO_LONG;
    }
    const uint32_t confirmed = sdo->seqno;
    sdo->seqno = 0;
    return dg_co_sdo_send(node, 0xA2u | confirmed << 8 | DOWNLOAD_BLKSIZE << 16, 0);
}

static enum dg_co_abort end_download(struct dg_co_node *node, const uint8_t *data)
{
    struct transfer *t = transfer_of(node);
    const uint32_t unused = data[0] >> 2 & 7u;

    if (unused > t->length) {
        return DG_CO_LENGTH;
    }
    t->length = (uint16_t)(t->length - unused);
    enum dg_co_abort abort = judge_length(node, t->length);
    if (abort == DG_CO_OK && node->sdo.crc &&
        dg_crc16(0, t->bytes, t->length) != dg_load_le16(&data[1])) {
        abort = DG_CO_CRC;
    }
    if (abort == DG_CO_OK) {
        abort = write_long(node);
    }
    return abort == DG_CO_OK ? dg_co_sdo_written(node, 0xA1) : abort;
}

static enum dg_co_abort ignore(struct dg_co_node *node, const uint8_t *data)
{
    (void)node;
    (void)data;
    return DG_CO_OK;
}

/* ------------------------------------------------------------ requests, time */

/* By byte 0; the first row that fits serves. Those of STEP_NONE begin a transfer. */
static const struct {
    uint8_t mask;
    uint8_t value;
    uint16_t steps;
    sdo_handler *serve;
} requests[] = {
    /* clang-format off */
    {0xE0, 0x40, IN(STEP_NONE),               begin_upload},
    {0xE0, 0x20, IN(STEP_NONE),               begin_download},
    {0xE3, 0xA0, IN(STEP_NONE),               begin_block_upload},
    {0xE1, 0xC0, IN(STEP_NONE),               begin_block_download},
    {0xE0, 0x60, IN(STEP_UPLOAD),             send_segment},
    {0xE0, 0x00, IN(STEP_DOWNLOAD),           take_segment},
    {0xE3, 0xA3, IN(STEP_BLOCK_UPLOAD_START), start_block},
    {0xE3, 0xA2, IN(STEP_BLOCK_UPLOAD),       take_confirmation},
    {0xE3, 0xA1, IN(STEP_BLOCK_UPLOAD_END),   end_upload},
    {0xE1, 0xC1, IN(STEP_BLOCK_DOWNLOAD_END), end_download},
    {0xE0, 0x80, IN(STEP_BLOCK_DOWNLOAD_END), ignore}, /* last segment, received twice */
    {0x00, 0x00, IN(STEP_BLOCK_DOWNLOAD),     take_block_segment},
    /* clang-format on */
};

/* In a state that somebody has made it may be anything. What was confirmed last of all may be more
 * than there is. */
static bool is_transfer_sound(const struct dg_co_node *node)
{
    const struct transfer *t = transfer_of(node);
    const uint32_t sent = t->step == STEP_BLOCK_SENDING ? SDO_SEGMENT * node->sdo.seqno : 0;
    const uint32_t at = t->step == STEP_BLOCK_UPLOAD_END ? 0 : t->done + sent;

    return t->step < STEP_COUNT && t->number < co_file_of(node)->long_count &&
           t->length < sizeof t->bytes && t->announced <= DG_EDS_LONG_MAX && at <= t->length &&
           at <= DG_EDS_LONG_MAX;
}

/* @return whether the request goes on with a transfer, or begins one of these values */
static bool is_ours(const struct dg_co_node *node, const uint8_t *data)
{
    const struct dg_co_file *file = co_file_of(node);

    if (node->sdo.state == DG_CO_SDO_DEVICE) {
        return is_transfer_sound(node);
    }
    const struct dg_co_long *found =
        dg_co_find_long(file, DG_CO_KEY(dg_load_le16(&data[1]), data[3]));
    if (node->sdo.state != DG_CO_SDO_IDLE || found == NULL) {
        return false;
    }
    transfer_of(node)->number = (uint16_t)(found - file->longs);
    transfer_of(node)->step = STEP_NONE;
    return true;
}

/* @return whether a segment was due; else the client has been silent for too long */
static bool send_due(struct dg_co_node *node)
{
    const bool due = node->sdo.state == DG_CO_SDO_DEVICE && is_transfer_sound(node) &&
                     transfer_of(node)->step == STEP_BLOCK_SENDING;

    if (due) {
        send_next(node);
    }
    return due;
}

/* @return what is still to be sent */
static enum dg_co_abort serve_transfer(struct dg_co_node *node, const uint8_t *data,
                                       enum dg_co_abort abort)
{
    if (data == NULL) {
        return send_due(node) ? DG_CO_OK : abort;
    }
    if (!is_ours(node, data)) {
        return abort;
    }
    for (size_t i = 0; i < DG_COUNT(requests); i++) {
        if ((data[0] & requests[i].mask) == requests[i].value &&
            (requests[i].steps >> transfer_of(node)->step & 1u) != 0) {
            return requests[i].serve(node, data);
        }
    }
    return abort;
}

void dg_co_serve_long(struct dg_co_node *node, const uint8_t *data, enum dg_co_abort abort)
{
    const enum dg_co_abort left = serve_transfer(node, data, abort);

    if (left != DG_CO_OK) {
        dg_co_sdo_abort(node, left);
    }
}
