/* SPDX-License-Identifier: MIT */
/*
 * The SDO server (CiA 301): requests find their handler, expedited and
 * segmented transfers. Block transfers are in co_block.c.
 *
 *              40h long                21h
 *   UPLOAD <------------- IDLE ---------------> DOWNLOAD     60h.. / 00h.. until the last segment
 *              A0h         |           C0h
 *   BLOCK_UPLOAD_START <---+------------------> BLOCK_DOWNLOAD
 *   | A3h                                       | segments, until the last one
 *   BLOCK_UPLOAD: A2h after every block         BLOCK_DOWNLOAD_END
 *   | all confirmed                             | C1h
 *   BLOCK_UPLOAD_END --A1h--> IDLE              IDLE
 *
 * Any of 40h, 2xh, A0h, C0h starts anew from every state; an abort by either side and the timeout
 * lead to IDLE.
 */
#include <string.h>

#include "co_block.h"
#include "co_od.h"
#include "co_sdo.h"

/** CiA 301 leaves the server's timeout open. */
#define TIMEOUT_MS 1000u

/** Bit 4 of segments. */
#define TOGGLE 0x10u
/** Bits of a download request. */
#define EXPEDITED 0x02u
#define SIZED 0x01u
/** Bit of a segment. */
#define NO_MORE 0x01u

#define IN(state) (1u << (state))
#define ANY 0xFFFFu
#define ANY_OTHER 0x7FFFu /* ends nothing */

static sdo_handler upload_initiate, upload_segment, download_initiate, download_segment, ignore;
static sdo_handler refuse;

/*
 * Requests by byte 0; the first row that fits serves. A request of IN(...) that comes in another
 * state is as unknown as E0h. Rows for ANY state end what was running.
 *
 * In a block download byte 0 is a sequence number. It cannot be mistaken for a new request, since
 * the blocks this server asks for are short (co_block.c); so the last row but one takes all that is
 * left, and in other states the last one.
 */
static const struct {
    uint8_t mask;
    uint8_t value;
    uint16_t states;
    sdo_handler *serve;
} commands[] = {
    /* clang-format off */
    {0xE0, 0x00, IN(DG_CO_SDO_DOWNLOAD),           download_segment},
    {0xE0, 0x20, ANY, download_initiate},
    {0xE0, 0x40, ANY, upload_initiate},
    {0xE0, 0x60, IN(DG_CO_SDO_UPLOAD),             upload_segment},
    {0xFF, SDO_ABORT, ANY, ignore},
    {0xF8, 0x80, IN(DG_CO_SDO_BLOCK_DOWNLOAD_END), ignore}, /* last segment, received twice */
    {0xE3, 0xA0, ANY, co_block_upload},
    {0xE3, 0xA3, IN(DG_CO_SDO_BLOCK_UPLOAD_START), co_block_upload_start},
    {0xE3, 0xA2, IN(DG_CO_SDO_BLOCK_UPLOAD),       co_block_upload_acknowledge},
    {0xE3, 0xA1, IN(DG_CO_SDO_BLOCK_UPLOAD_END),   co_block_upload_end},
    {0xE1, 0xC0, ANY, co_block_download},
    {0xE1, 0xC1, IN(DG_CO_SDO_BLOCK_DOWNLOAD_END), co_block_download_end},
    {0x00, 0x00, IN(DG_CO_SDO_BLOCK_DOWNLOAD),     co_block_download_segment},
    {0x00, 0x00, ANY_OTHER,                        refuse},
    /* clang-format on */
};
#define COMMANDS DG_COUNT(commands)
/* By the command specifier, bits 5-7: the first row that can fit. */
static const uint8_t first_row[8] = {0, 1, 2, 3, 4, 6, 10, COMMANDS - 2};

void co_sdo_become(struct dg_co_node *self, enum dg_co_sdo_state state)
{
    self->sdo.state = state;
    self->sdo.deadline = state == DG_CO_SDO_IDLE ? DG_NEVER : co_after_ms(self->now, TIMEOUT_MS);
}

/* An answer whose bytes are all set. Held back when a hook has asked for it. */
static void send_answer(struct dg_co_node *self, struct dg_can_frame *frame)
{
    if (self->sdo.state == DG_CO_SDO_DELAYED) {
        memcpy(self->sdo.answer, frame->data, sizeof self->sdo.answer);
        return;
    }
    frame->id = (uint16_t)(CO_ID_SDO_TX + self->id);
    frame->rtr = false;
    frame->dlc = 8;
    co_send_frame(self, frame);
}

void co_sdo_send(struct dg_co_node *self, uint8_t command, const uint8_t *bytes, uint8_t n)
{
    struct dg_can_frame frame = {.data = {command}};

    memcpy(&frame.data[1], bytes, n);
    send_answer(self, &frame);
}

void co_sdo_send_segment(struct dg_co_node *self, uint8_t command, const uint8_t *bytes)
{
    struct dg_can_frame frame;

    frame.data[0] = command;
    memcpy(&frame.data[1], bytes, SDO_SEGMENT);
    send_answer(self, &frame);
}

void co_sdo_confirm(struct dg_co_node *self, uint8_t command, uint32_t value)
{
    struct dg_can_frame frame;

    dg_store_le64(frame.data, command | (uint64_t)self->sdo.object.index << 8 |
                                  (uint64_t)self->sdo.object.sub << 24 | (uint64_t)value << 32);
    send_answer(self, &frame);
}

static void abort_transfer(struct dg_co_node *self, enum dg_co_abort code)
{
    co_sdo_become(self, DG_CO_SDO_IDLE);
    co_sdo_confirm(self, SDO_ABORT, code);
}

static void send_delayed(struct dg_co_node *self)
{
    co_sdo_become(self, DG_CO_SDO_IDLE);
    co_send(self, (uint16_t)(CO_ID_SDO_TX + self->id), self->sdo.answer, sizeof self->sdo.answer);
}

static enum dg_co_abort ignore(struct dg_co_node *self, const uint8_t *data)
{
    (void)self;
    (void)data;
    return DG_CO_OK;
}

static enum dg_co_abort refuse(struct dg_co_node *self, const uint8_t *data)
{
    (void)self;
    (void)data;
    return DG_CO_SPECIFIER;
}

/* ---- upload */

static void fetch_text(struct dg_co_sdo *sdo, const char *text)
{
    uint8_t *to = sdo->buffer;

    while (to < &sdo->buffer[DG_CO_STRING_MAX] && *text != '\0') {
        *to++ = (uint8_t)*text++;
    }
    sdo->length = (uint8_t)(to - sdo->buffer);
}

enum dg_co_abort co_sdo_fetch(struct dg_co_node *self)
{
    struct dg_co_sdo *sdo = &self->sdo;
    const struct dg_co_device *device = self->setup.device;
    const struct dg_co_object *object = &sdo->object;
    enum dg_co_abort abort = co_find(device, &sdo->object);
    uint32_t value;

    if (abort != DG_CO_OK) {
        return abort;
    }
    if (!co_is(object, DG_CO_R)) {
        return DG_CO_WRITE_ONLY;
    }
    sdo->done = 0;
    sdo->length = 0;
    if (co_type(object) == DG_CO_STRING) {
        /* Zeros behind the data: whole segments are sent. */
        memset(sdo->buffer, 0, sizeof sdo->buffer);
        fetch_text(sdo, device->strings[object->row->initial]);
        return DG_CO_OK;
    }
    if (object->index >= 0x2000 && !co_is(object, DG_CO_CONST) && device->sample != NULL) {
        device->sample(self);
    }
    abort = co_read(self, object, &value);
    if (abort == DG_CO_OK) {
        sdo->length = co_size(object);
        dg_store_le64(sdo->buffer, co_cut(object, value));
    }
    return abort;
}

void co_sdo_upload(struct dg_co_node *self)
{
    struct dg_co_sdo *sdo = &self->sdo;

    /* An expedited answer cannot say that there are no bytes. */
    if (sdo->length > 0 && sdo->length <= 4) {
        co_sdo_confirm(self, (uint8_t)(0x43u | (4u - sdo->length) << 2), dg_load_le32(sdo->buffer));
        return;
    }
    sdo->toggle = 0;
    co_sdo_become(self, DG_CO_SDO_UPLOAD);
    co_sdo_confirm(self, 0x41, sdo->length);
}

static enum dg_co_abort upload_initiate(struct dg_co_node *self, const uint8_t *data)
{
    enum dg_co_abort abort = co_sdo_fetch(self);

    (void)data;
    if (abort == DG_CO_OK) {
        co_sdo_upload(self);
    }
    return abort;
}

static enum dg_co_abort upload_segment(struct dg_co_node *self, const uint8_t *data)
{
    struct dg_co_sdo *sdo = &self->sdo;
    uint8_t left = (uint8_t)(sdo->length - sdo->done);
    uint8_t n = left < SDO_SEGMENT ? left : SDO_SEGMENT;
    bool last = n == left;

    if ((data[0] & TOGGLE) != sdo->toggle) {
        return DG_CO_TOGGLE;
    }
    co_sdo_send_segment(self,
                        (uint8_t)(sdo->toggle | (SDO_SEGMENT - n) << 1 | (last ? NO_MORE : 0u)),
                        &sdo->buffer[sdo->done]);
    sdo->toggle ^= TOGGLE;
    sdo->done = (uint8_t)(sdo->done + n);
    co_sdo_become(self, last ? DG_CO_SDO_IDLE : DG_CO_SDO_UPLOAD);
    return DG_CO_OK;
}

/* ---- download */

enum dg_co_abort co_sdo_length(const struct dg_co_node *self, uint32_t length)
{
    uint32_t size = co_size(&self->sdo.object);

    if (length == size) {
        return DG_CO_OK;
    }
    /* The announced size was right, so the client contradicts itself. */
    if (self->sdo.sized) {
        return DG_CO_LENGTH;
    }
    return length > size ? DG_CO_TOO_LONG : DG_CO_TOO_SHORT;
}

enum dg_co_abort co_sdo_open(struct dg_co_node *self, bool sized, uint32_t size)
{
    struct dg_co_sdo *sdo = &self->sdo;
    enum dg_co_abort abort = co_find(self->setup.device, &sdo->object);

    if (abort != DG_CO_OK) {
        return abort;
    }
    if (!co_is(&sdo->object, DG_CO_W)) {
        return DG_CO_READ_ONLY;
    }
    sdo->sized = false;
    abort = sized ? co_sdo_length(self, size) : DG_CO_OK;
    sdo->sized = sized;
    sdo->toggle = 0;
    sdo->length = 0;
    return abort;
}

enum dg_co_abort co_sdo_write(struct dg_co_node *self)
{
    const struct dg_co_object *object = &self->sdo.object;

    /* Before the hooks: one of them may make it DELAYED. */
    co_sdo_become(self, DG_CO_SDO_IDLE);
    return co_write(self, object, co_extend(object, dg_load_le32(self->sdo.buffer)));
}

static enum dg_co_abort download_initiate(struct dg_co_node *self, const uint8_t *data)
{
    bool expedited = (data[0] & EXPEDITED) != 0;
    uint32_t size = expedited ? 4u - (data[0] >> 2 & 3u) : dg_load_le32(&data[4]);
    enum dg_co_abort abort = co_sdo_open(self, (data[0] & SIZED) != 0, size);

    if (abort == DG_CO_OK && expedited) {
        /* 22h does not say how many bytes count: as many as the object has, as is common. */
        memcpy(self->sdo.buffer, &data[4], 4);
        abort = co_sdo_write(self);
    } else if (abort == DG_CO_OK) {
        co_sdo_become(self, DG_CO_SDO_DOWNLOAD);
    }
    if (abort == DG_CO_OK) {
        co_sdo_confirm(self, 0x60, 0);
    }
    return abort;
}

static enum dg_co_abort download_segment(struct dg_co_node *self, const uint8_t *data)
{
    struct dg_co_sdo *sdo = &self->sdo;
    uint8_t n = (uint8_t)(SDO_SEGMENT - (data[0] >> 1 & 7u));
    uint32_t length = (uint32_t)sdo->length + n;
    bool last = (data[0] & NO_MORE) != 0;
    enum dg_co_abort abort = DG_CO_OK;

    if ((data[0] & TOGGLE) != sdo->toggle) {
        return DG_CO_TOGGLE;
    }
    if (last || length > co_size(&sdo->object)) {
        abort = co_sdo_length(self, length);
    }
    if (abort != DG_CO_OK) {
        return abort;
    }
    memcpy(&sdo->buffer[sdo->length], &data[1], n);
    sdo->length = (uint8_t)length;
    sdo->toggle ^= TOGGLE;
    if (last) {
        abort = co_sdo_write(self);
    } else {
        co_sdo_become(self, DG_CO_SDO_DOWNLOAD);
    }
    if (abort == DG_CO_OK) {
        co_sdo_send(self, (uint8_t)(0x20u | (data[0] & TOGGLE)), data, 0);
    }
    return abort;
}

/* ---- frames and time */

static size_t find_command(enum dg_co_sdo_state state, uint8_t command)
{
    size_t i = first_row[command >> 5];

    while ((command & commands[i].mask) != commands[i].value ||
           (commands[i].states & IN(state)) == 0) {
        i++;
    }
    return i;
}

void co_sdo_start(struct dg_co_node *self)
{
    co_sdo_become(self, DG_CO_SDO_IDLE);
}

void co_sdo_rx(struct dg_co_node *self, const struct dg_can_frame *frame)
{
    struct dg_co_sdo *sdo = &self->sdo;
    const uint8_t *data = frame->data;

    if (frame->dlc != 8) {
        self->counters.malformed++;
        return;
    }
    if (sdo->state == DG_CO_SDO_DELAYED && data[0] != SDO_ABORT) {
        send_delayed(self);
    }
    size_t command = find_command(sdo->state, data[0]);
    /* An abort carries the multiplexor of the transfer; without one, that of the request. */
    if (commands[command].states == ANY || sdo->state == DG_CO_SDO_IDLE) {
        co_sdo_become(self, DG_CO_SDO_IDLE);
        sdo->object.index = dg_load_le16(&data[1]);
        sdo->object.sub = data[3];
    }
    enum dg_co_abort abort = commands[command].serve(self, data);
    if (abort != DG_CO_OK) {
        abort_transfer(self, abort);
    }
}

dg_ns co_sdo_step(struct dg_co_node *self)
{
    struct dg_co_sdo *sdo = &self->sdo;

    if (sdo->state == DG_CO_SDO_IDLE || self->now < sdo->deadline) {
        return sdo->deadline;
    }
    if (sdo->state == DG_CO_SDO_DELAYED) {
        send_delayed(self);
    } else {
        abort_transfer(self, DG_CO_TIMEOUT);
    }
    return sdo->deadline;
}
