/* SPDX-License-Identifier: MIT */
/*
 * From a frame to its reply: the command table and the order of checks (R8).
 *
 *   checksum 0Ah, command 0Bh, length 0Ch      dg_hf_check_frame()
 *   start-up locks 02h 03h 05h 06h, EEPROM 05h, Code 0 0Fh      permitted()
 *   field number, its access code, arguments, write protection      the handlers
 */
#include "drehgeber/crc.h"
#include "hiperface_private.h"

#define ERROR_RESPONSE 0x50u
#define WARNING_BIT 0x80u
#define SAVE_DATA 0x4Bu
#define SAVE_DATA_HEAD 4u

/* The flags' short names in commands.def. */
enum {
    C = HF_CODE0,
    P = HF_LOCK_POSITION,
    D = HF_LOCK_FIELDS,
    U = HF_LOCK_UART,
    K = HF_LOCK_CODES,
    W = HF_LOCK_WRITE,
    E = HF_LOCK_EEPROM,
    S = HF_LOCK_CHECKSUM,
};

#define DG_HF_COMMAND(code, name, min, max, reply, reaction_ms, flags, handler, errors)            \
    {code, min, max, reply, reaction_ms, flags, handler},

const struct hf_command dg_hf_commands[] = {
#include "commands.def"
};
#undef DG_HF_COMMAND
const uint8_t dg_hf_command_count = DG_COUNT(dg_hf_commands);

uint8_t dg_hf_command_find(uint8_t code)
{
    uint8_t row = 0;

    while (row < dg_hf_command_count && dg_hf_commands[row].code != code) {
        row++;
    }
    return row;
}

/* 4Bh announces its number of bytes; it has to agree with the frame's (5.1.2.8). */
static bool length_fits(const struct hf_command *row, const uint8_t *data, uint16_t n)
{
    if (n < row->request_min || n > row->request_max) {
        return false;
    }
    return row->code != SAVE_DATA || n == SAVE_DATA_HEAD + data[2];
}

/* `row` stays what it is unless the frame is one. */
static enum dg_hf_status judge_frame_errors(const struct dg_hf *self, uint8_t *row)
{
    if (self->frame_damaged) {
        return DG_HF_CHECKSUM;
    }
    if (self->length > DG_HF_FRAME_MAX) {
        return DG_HF_LENGTH;
    }
    if (self->sum != 0) {
        return DG_HF_CHECKSUM;
    }
    if (self->length < HF_FRAME_LEAST) {
        return DG_HF_LENGTH;
    }
    const uint8_t found = dg_hf_command_find(self->frame[1]);
    if (found == dg_hf_command_count || (self->setup.model->lacks >> found & 1u) != 0) {
        return DG_HF_COMMAND;
    }
    *row = found;
    if (!length_fits(&dg_hf_commands[found], &self->frame[2], (uint16_t)(self->length - 3u))) {
        return DG_HF_LENGTH;
    }
    return DG_HF_NO_ERROR;
}

void dg_hf_check_frame(struct dg_hf *self)
{
    self->command = dg_hf_command_count;
    self->verdict = (uint8_t)judge_frame_errors(self, &self->command);
}

/* What stands between a well-formed request and its handler. */
static enum dg_hf_status permitted(const struct dg_hf *self, const struct hf_command *row,
                                   const struct hf_request *rq)
{
    static const struct {
        uint8_t lock;
        uint8_t status;
    } locks[] = {
        {HF_LOCK_POSITION, DG_HF_ANGLE_OFFSET},
        {HF_LOCK_PARTITION, DG_HF_PARTITION},
        {HF_LOCK_EEPROM, DG_HF_I2C},
        {HF_LOCK_CHECKSUM, DG_HF_CHECKSUM_INTERNAL},
    };
    const uint8_t locked = row->flags & self->locks;

    for (uint8_t i = 0; locked != 0 && i < DG_COUNT(locks); i++) {
        if ((locked & locks[i].lock) != 0) {
            return (enum dg_hf_status)locks[i].status;
        }
    }
    if ((row->flags & HF_LOCK_EEPROM) != 0 && !self->setup.world->eeprom_acknowledges) {
        return DG_HF_I2C;
    }
    if ((row->flags & HF_CODE0) != 0 && rq->data[rq->length - 1u] != self->codes[0]) {
        return DG_HF_ACCESS_CODE;
    }
    return DG_HF_NO_ERROR;
}

void dg_hf_answer(struct dg_hf *self, dg_ns now)
{
    uint8_t reply[DG_HF_FRAME_MAX];
    struct hf_request rq = {
        .now = now,
        .data = &self->frame[2],
        .reply = dg_writer(&reply[2], HF_DATA_MAX),
    };

    dg_hf_monitor(self);
    enum dg_hf_status status = (enum dg_hf_status)self->verdict;
    if (status == DG_HF_NO_ERROR) {
        rq.length = (uint16_t)(self->length - 3u);
        status = permitted(self, &dg_hf_commands[self->command], &rq);
    }
    if (status == DG_HF_NO_ERROR) {
        status = dg_hf_commands[self->command].handler(self, &rq);
    }
    reply[1] = self->frame[1];
    if (status != DG_HF_NO_ERROR) {
        reply[1] = ERROR_RESPONSE;
        rq.reply = dg_writer(&reply[2], HF_DATA_MAX);
        dg_write_u8(&rq.reply, (uint8_t)status);
        self->counters.errors++;
    }
    /* 55h has changed the address, 50h the stack: both show in this reply (R3, R10). */
    reply[0] = self->address;
    if (self->stack_count > 0) {
        reply[1] |= WARNING_BIT;
    }
    size_t n = (size_t)(rq.reply.at - reply);
    reply[n] = dg_xor8(0, reply, n);
    self->counters.replies++;
    self->setup.ops->tx(self->setup.ctx, reply, n + 1u);
}
