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
 * lead to IDLE. All else is refused in DEVICE, which is what a device does with what is refused.
 */
#include <string.h>

#include "co_block.h"
#include "co_od.h"
#include "co_sdo.h"

/** CiA 301 leaves the server's timeout open. */
#define TIMEOUT_MS 1000u

/** Bit 4 of segments. */
#define TOGGLE 0x10u
/** Bit of an upload request: A0h, not 40h. */
#define BLOCK 0x80u
/** Bits of a download request. */
#define EXPEDITED 0x02u
#define SIZED 0x01u
/** Bit of a segment. */
#define NO_MORE 0x01u

#define IN(state) (1u << (state))
#define OTHER (IN(DG_CO_SDO_STATE_COUNT) - 1u - IN(DG_CO_SDO_DELAYED)) /* all but this one */
#define BEGINS 0x8000u                                                 /* ends what was running */
#define ANY (BEGINS | OTHER)

static sdo_handler upload_initiate, upload_blocks, upload_segment, download_initiate;
static sdo_handler download_segment, ignore, refuse, overtake;

/*
 * Requests by byte 0. The search begins at the row whose number is the command specifier (bits
 * 5-7), and the first row that fits serves. A request of IN(...) that comes in another state is as
 * unknown as E0h.
 *
 * In a block download byte 0 is a sequence number. It cannot be mistaken for a new request, since
 * the blocks this server asks for are short (co_block.c); so one row takes all that is left, and in
 * other states the next one. While an answer is held back nothing but an abort comes before the
 * last.
 */
struct command {
    uint8_t mask;
    uint8_t value;
    uint16_t states;
    sdo_handler *serve;
};
static const struct command commands[] = {
    /* clang-format off */
    {0xE0, 0x00, IN(DG_CO_SDO_DOWNLOAD),           download_segment},
    {0xE0, 0x20, ANY, download_initiate},
    {0xE0, 0x40, ANY, upload_initiate},
    {0xE0, 0x60, IN(DG_CO_SDO_UPLOAD),             upload_segment},
    {0xFF, SDO_ABORT, ANY | IN(DG_CO_SDO_DELAYED), ignore},
    {0xE3, 0xA0, ANY, upload_blocks},
    {0xE1, 0xC0, ANY, dg_co_block_download},
    {0xE1, 0xC1, IN(DG_CO_SDO_BLOCK_DOWNLOAD_END), dg_co_block_download_end},
    {0xE3, 0xA1, IN(DG_CO_SDO_BLOCK_UPLOAD_END),   dg_co_block_upload_end},
    {0xE3, 0xA2, IN(DG_CO_SDO_BLOCK_UPLOAD),       dg_co_block_upload_acknowledge},
    {0xE3, 0xA3, IN(DG_CO_SDO_BLOCK_UPLOAD_START), dg_co_block_upload_start},
    {0xF8, 0x80, IN(DG_CO_SDO_BLOCK_DOWNLOAD_END), ignore}, /* last segment, received twice */
    {0x00, 0x00, IN(DG_CO_SDO_BLOCK_DOWNLOAD),     dg_co_block_download_segment},
    {0x00, 0x00, OTHER,                            refuse},
    {0x00, 0x00, IN(DG_CO_SDO_DELAYED),            overtake},
    /* clang-format on */
};

void dg_co_sdo_become(struct dg_co_node *self, enum dg_co_sdo_state state)
{
    self->sdo.state = state;
    self->sdo.deadline =
        state == DG_CO_SDO_IDLE ? DG_NEVER : dg_after(self->now, DG_MS(TIMEOUT_MS));
}

/* An answer whose bytes are all set. */
static enum dg_co_abort send_answer(struct dg_co_node *self, struct dg_can_frame *frame)
{
    frame->id = (uint16_t)(CO_ID_SDO_TX + self->id);
    frame->rtr = false;
    frame->dlc = 8;
    dg_co_send_frame(self, frame);
    return DG_CO_OK;
}

enum dg_co_abort dg_co_sdo_send(struct dg_co_node *self, uint32_t low, uint32_t high)
{
    struct dg_can_frame frame;

    dg_store_le32(frame.data, low);
    dg_store_le32(&frame.data[4], high);
    return send_answer(self, &frame);
}

enum dg_co_abort dg_co_sdo_send_segment(struct dg_co_node *self, uint8_t command,
                                        const uint8_t *bytes)
{
    struct dg_can_frame frame;

    frame.data[0] = command;
    memcpy(&frame.data[1], bytes, SDO_SEGMENT);
    return send_answer(self, &frame);
}

void dg_co_sdo_abort(struct dg_co_node *self, enum dg_co_abort code)
{
    dg_co_sdo_become(self, DG_CO_SDO_IDLE);
    (void)co_sdo_confirm(self, SDO_ABORT, code);
}

void dg_co_sdo_refuse(struct dg_co_node *self, const uint8_t *data, enum dg_co_abort abort)
{
    const struct dg_co_device *device = self->setup.device;

    if (device->refused != NULL) {
        device->refused(self, data, abort);
        return;
    }
    dg_co_sdo_abort(self, abort);
}

enum dg_co_abort dg_co_sdo_written(struct dg_co_node *self, uint8_t command)
{
    struct dg_co_sdo *sdo = &self->sdo;

    if (command != WRITTEN_AT_ONCE) {
        sdo->multiplexor = 0;
    }
    sdo->answer = command;
    return sdo->state == DG_CO_SDO_DELAYED ? DG_CO_OK : co_sdo_confirm(self, command, 0);
}

static void send_delayed(struct dg_co_node *self)
{
    dg_co_sdo_become(self, DG_CO_SDO_IDLE);
    (void)co_sdo_confirm(self, self->sdo.answer, 0);
}

/* An answer that is held back goes out in front of the one to the next request. */
static enum dg_co_abort overtake(struct dg_co_node *self, const uint8_t *data)
{
    send_delayed(self);
    return dg_co_sdo_rx(self, data);
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

/* The object of a request. */
static enum dg_co_abort find_object(struct dg_co_node *self, const uint8_t *data)
{
    return dg_co_find(self->setup.device, DG_CO_KEY(dg_load_le16(&data[1]), data[3]),
                      &self->sdo.object);
}

/* ---- upload */

/* Zeros behind the text: whole segments are sent. */
static void fetch_text(struct dg_co_sdo *sdo, const char *text)
{
    size_t n = 0;

    while (n < DG_CO_STRING_MAX && text[n] != '\0') {
        sdo->buffer[n] = (uint8_t)text[n];
        n++;
    }
    memset(&sdo->buffer[n], 0, SDO_SEGMENT);
    sdo->length = (uint8_t)n;
}

/* The value of an object, with a sample of its own if it can have changed. */
static enum dg_co_abort fetch_value(struct dg_co_node *self)
{
    const struct dg_co_object *object = &self->sdo.object;

    if (object->index >= 0x2000 && !co_is(object, DG_CO_CONST) &&
        self->setup.device->sample != NULL) {
        self->setup.device->sample(self);
    }
    return co_read(self, object, &self->sdo.value);
}

/* What is left of a value in the 1 to 4 bytes of its length. */
static uint32_t cut_value(const struct dg_co_sdo *sdo, uint32_t value)
{
    return value & 0xFFFFFFFFu >> 8u * (4u - sdo->length);
}

static enum dg_co_abort confirm_expedited(struct dg_co_node *self, uint32_t value)
{
    const uint32_t unused = 4u - self->sdo.length;

    return co_sdo_confirm(self, 0x43u + 4u * unused, cut_value(&self->sdo, value));
}

/* What is in the buffer. An expedited answer cannot say that there are no bytes. */
static enum dg_co_abort offer_value(struct dg_co_node *self, const uint8_t *data)
{
    struct dg_co_sdo *sdo = &self->sdo;

    sdo->done = 0;
    sdo->toggle = 0;
    if ((data[0] & BLOCK) != 0 && (data[5] == 0 || sdo->length > data[5])) {
        return dg_co_block_upload(self, data);
    }
    if (sdo->length > 0 && sdo->length <= 4) {
        return confirm_expedited(self, dg_load_le32(sdo->buffer));
    }
    dg_co_sdo_become(self, DG_CO_SDO_UPLOAD);
    return co_sdo_confirm(self, 0x41, sdo->length);
}

static enum dg_co_abort upload_initiate(struct dg_co_node *self, const uint8_t *data)
{
    struct dg_co_sdo *sdo = &self->sdo;
    enum dg_co_abort abort = find_object(self, data);

    if (abort != DG_CO_OK) {
        return abort;
    }
    if (!co_is(&sdo->object, DG_CO_R)) {
        return DG_CO_WRITE_ONLY;
    }
    sdo->length = co_size(&sdo->object);
    if (sdo->length == 0) {
        fetch_text(sdo, self->setup.device->strings[sdo->object.row->initial]);
        return offer_value(self, data);
    }
    abort = fetch_value(self);
    if (abort != DG_CO_OK) {
        return abort;
    }
    if ((data[0] & BLOCK) == 0) {
        return confirm_expedited(self, sdo->value);
    }
    dg_store_le64(sdo->buffer, cut_value(sdo, sdo->value));
    return offer_value(self, data);
}

/* A client of blocks may want short data without their protocol. */
static enum dg_co_abort upload_blocks(struct dg_co_node *self, const uint8_t *data)
{
    return co_block_size_valid(data[4]) ? upload_initiate(self, data) : DG_CO_BLOCK_SIZE;
}

static enum dg_co_abort upload_segment(struct dg_co_node *self, const uint8_t *data)
{
    struct dg_co_sdo *sdo = &self->sdo;
    const uint8_t toggle = sdo->toggle;
    const uint8_t *bytes = &sdo->buffer[sdo->done];
    uint8_t left = (uint8_t)(sdo->length - sdo->done);
    uint8_t n = left < SDO_SEGMENT ? left : SDO_SEGMENT;
    bool last = n == left;

    if ((data[0] & TOGGLE) != toggle) {
        return DG_CO_TOGGLE;
    }
    sdo->toggle ^= TOGGLE;
    sdo->done = (uint8_t)(sdo->done + n);
    dg_co_sdo_become(self, last ? DG_CO_SDO_IDLE : DG_CO_SDO_UPLOAD);
    return dg_co_sdo_send_segment(
        self, (uint8_t)(toggle | (SDO_SEGMENT - n) << 1 | (last ? NO_MORE : 0u)), bytes);
}

/* ---- download */

enum dg_co_abort dg_co_sdo_length(const struct dg_co_node *self, uint32_t length)
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

enum dg_co_abort dg_co_sdo_open(struct dg_co_node *self, const uint8_t *data, bool sized,
                                uint32_t size)
{
    struct dg_co_sdo *sdo = &self->sdo;
    enum dg_co_abort abort = find_object(self, data);

    if (abort != DG_CO_OK) {
        return abort;
    }
    if (!co_is(&sdo->object, DG_CO_W)) {
        return DG_CO_READ_ONLY;
    }
    sdo->sized = false;
    abort = sized ? dg_co_sdo_length(self, size) : DG_CO_OK;
    sdo->sized = sized;
    sdo->toggle = 0;
    sdo->length = 0;
    return abort;
}

enum dg_co_abort dg_co_sdo_write(struct dg_co_node *self)
{
    const struct dg_co_object *object = &self->sdo.object;

    /* Before the hooks: one of them may make it DELAYED. */
    dg_co_sdo_become(self, DG_CO_SDO_IDLE);
    return dg_co_write(self, object, dg_co_extend(object, dg_load_le32(self->sdo.buffer)));
}

static enum dg_co_abort download_initiate(struct dg_co_node *self, const uint8_t *data)
{
    bool expedited = (data[0] & EXPEDITED) != 0;
    uint32_t size = expedited ? 4u - (data[0] >> 2 & 3u) : dg_load_le32(&data[4]);
    enum dg_co_abort abort = dg_co_sdo_open(self, data, (data[0] & SIZED) != 0, size);

    if (abort == DG_CO_OK && expedited) {
        /* 22h does not say how many bytes count: as many as the object has, as is common. */
        memcpy(self->sdo.buffer, &data[4], 4);
        abort = dg_co_sdo_write(self);
    } else if (abort == DG_CO_OK) {
        dg_co_sdo_become(self, DG_CO_SDO_DOWNLOAD);
    }
    return abort == DG_CO_OK ? dg_co_sdo_written(self, WRITTEN_AT_ONCE) : abort;
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
        abort = dg_co_sdo_length(self, length);
    }
    if (abort != DG_CO_OK) {
        return abort;
    }
    memcpy(&sdo->buffer[sdo->length], &data[1], n);
    sdo->length = (uint8_t)length;
    sdo->toggle ^= TOGGLE;
    if (!last) {
        dg_co_sdo_become(self, DG_CO_SDO_DOWNLOAD);
        return dg_co_sdo_send(self, 0x20u | (data[0] & TOGGLE), 0);
    }
    abort = dg_co_sdo_write(self);
    return abort == DG_CO_OK ? dg_co_sdo_written(self, (uint8_t)(0x20u | (data[0] & TOGGLE)))
                             : abort;
}

/* ---- frames and time */

static const struct command *find_request(enum dg_co_sdo_state state, uint8_t byte)
{
    const struct command *command = &commands[byte >> 5];

    while ((byte & command->mask) != command->value || (command->states >> state & 1u) == 0) {
        command++;
    }
    return command;
}

void dg_co_sdo_start(struct dg_co_node *self)
{
    dg_co_sdo_become(self, DG_CO_SDO_IDLE);
}

enum dg_co_abort dg_co_sdo_rx(struct dg_co_node *self, const uint8_t *data)
{
    struct dg_co_sdo *sdo = &self->sdo;
    const struct command *command = find_request(sdo->state, data[0]);

    /* An abort carries the multiplexor of the transfer; without one, that of the request. */
    if ((command->states & BEGINS) != 0 || sdo->state == DG_CO_SDO_IDLE) {
        dg_co_sdo_become(self, DG_CO_SDO_IDLE);
        sdo->multiplexor = dg_load_le32(data) & 0xFFFFFF00u;
    }
    return command->serve(self, data);
}

dg_ns dg_co_sdo_step(struct dg_co_node *self)
{
    struct dg_co_sdo *sdo = &self->sdo;

    if (sdo->state == DG_CO_SDO_IDLE || self->now < sdo->deadline) {
        return sdo->deadline;
    }
    if (sdo->state == DG_CO_SDO_DELAYED) {
        send_delayed(self);
    } else {
        dg_co_sdo_refuse(self, NULL, DG_CO_TIMEOUT);
    }
    return sdo->deadline;
}
