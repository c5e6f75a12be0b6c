/* SPDX-License-Identifier: MIT */
/*
 * CAN frames in the words of CANopen, by the predefined connection set of CiA 301: the CAN-ID says
 * the service and the node.
 *
 * SDO: the first byte says the service (7.2.4), but for the segments of a block transfer, whose
 * first byte is a number. Who sends segments is remembered for each node:
 *
 *   upload:    A3h from the client   -> segments from the server, last one marked -> C1h
 *   download:  A0h from the server   -> segments from the client, last one marked -> C1h
 */
#include "drehgeber/words.h"

#include "drehgeber/bits.h"
#include "drehgeber/canopen.h"

#define TOGGLE 0x80u
#define TIME_MS_MASK 0x0FFFFFFFu
#define EMCY_MANUFACTURER 3u

#define ABORT 0x80u
#define BLOCK_MASK 0xE3u
#define BLOCK_DOWNLOAD_AGREED 0xA0u
#define BLOCK_RECEIVED 0xA2u
#define BLOCK_UPLOAD_START 0xA3u
#define BLOCK_END 0xC1u
#define LAST 0x80u
#define EXPEDITED 2u
#define SIZED 1u
#define SEGMENT_END 1u

/* Block transfer of a node, in dg_co_words.blocks. */
enum block {
    BLOCK_FROM_CLIENT = 1,
    BLOCK_FROM_SERVER = 2,
    BLOCK_LAST = 4, /* the last segment has been seen; it may be repeated */
};

/* What an SDO carries besides its service. */
enum content {
    NOTHING,
    OBJECT,
    VALUE,   /* object and expedited data, or object and size */
    SEGMENT, /* up to seven bytes */
    CODE,    /* object and abort code */
    NUMBERS, /* segments received in order, segments of the next block */
};

/* A frame on its way to words. */
struct told {
    const struct dg_can_frame *frame;
    uint8_t node;
    struct dg_co_words *memory;
    struct dg_words_draft *to;
};

/* A code and its name. */
struct name {
    uint8_t code;
    uint8_t severity;
    const char *name;
};

/* clang-format off */
#define OK DG_SEVERITY_OK
#define NOTICE DG_SEVERITY_NOTICE
#define NODES DG_CO_NET_NODES
static const struct name nmt_commands[] = {
    {0x01, NOTICE, "start"},
    {0x02, NOTICE, "stop"},
    {0x80, NOTICE, "enter pre-operational"},
    {0x81, NOTICE, "reset"},
    {0x82, NOTICE, "reset communication"},
};

/* Whoever boots was reset, or has just got its power. */
static const struct name nmt_states[] = {
    {0x00, NOTICE, "boot-up"},
    {0x04, OK,     "stopped"},
    {0x05, OK,     "operational"},
    {0x7F, OK,     "pre-operational"},
};

/* Layer setting services, CiA 305: bytes of the argument, from the master and from the slave. What changes a slave's
   node-ID or bit timing is worth a notice; its reply begins with an error code, 0: done. */
static const struct lss {
    uint8_t code;
    uint8_t request;
    uint8_t reply;
    bool changes;
    const char *name;
} lss_commands[] = {
    {0x04, 1, 0, false, "switch state global"},
    {0x11, 1, 1, true,  "configure node-ID"},
    {0x13, 2, 1, true,  "configure bit timing"},
    {0x15, 2, 0, true,  "activate bit timing"},
    {0x17, 0, 1, true,  "store configuration"},
    {0x40, 4, 0, false, "switch state selective vendor-ID"},
    {0x41, 4, 0, false, "switch state selective product code"},
    {0x42, 4, 0, false, "switch state selective revision"},
    {0x43, 4, 0, false, "switch state selective serial number"},
    {0x44, 0, 0, false, "switch state selective"},
    {0x46, 4, 0, false, "identify vendor-ID"},
    {0x47, 4, 0, false, "identify product code"},
    {0x48, 4, 0, false, "identify revision from"},
    {0x49, 4, 0, false, "identify revision to"},
    {0x4A, 4, 0, false, "identify serial number from"},
    {0x4B, 4, 0, false, "identify serial number to"},
    {0x4C, 0, 0, false, "identify non-configured"},
    {0x4F, 0, 0, false, "identify slave"},
    {0x50, 0, 0, false, "identify non-configured slave"},
    {0x51, 4, 0, false, "fastscan"},
    {0x5A, 0, 4, false, "inquire vendor-ID"},
    {0x5B, 0, 4, false, "inquire product code"},
    {0x5C, 0, 4, false, "inquire revision"},
    {0x5D, 0, 4, false, "inquire serial number"},
    {0x5E, 0, 1, false, "inquire node-ID"},
};
static const struct sdo {
    bool reply;
    uint8_t mask;
    uint8_t value;
    enum content content;
    const char *name;
} sdos[] = {
    {false, 0xE0, 0x00, SEGMENT, "download segment"},
    {false, 0xE0, 0x20, VALUE,   "download"},
    {false, 0xE0, 0x40, OBJECT,  "upload"},
    {false, 0xE0, 0x60, NOTHING, "upload segment"},
    {false, 0xE0, 0x80, CODE,    "abort"},
    {false, 0xE3, 0xA0, OBJECT,  "block upload"},
    {false, 0xE3, 0xA1, NOTHING, "block upload end"},
    {false, 0xE3, 0xA2, NUMBERS, "block upload received"},
    {false, 0xE3, 0xA3, NOTHING, "block upload start"},
    {false, 0xE1, 0xC0, OBJECT,  "block download"},
    {false, 0xE1, 0xC1, NOTHING, "block download end"},
    {true,  0xE0, 0x00, SEGMENT, "upload segment"},
    {true,  0xE0, 0x20, NOTHING, "download segment"},
    {true,  0xE0, 0x40, VALUE,   "upload"},
    {true,  0xE0, 0x60, OBJECT,  "download"},
    {true,  0xE0, 0x80, CODE,    "abort"},
    {true,  0xE3, 0xA0, OBJECT,  "block download"},
    {true,  0xE3, 0xA1, NOTHING, "block download end"},
    {true,  0xE3, 0xA2, NUMBERS, "block download received"},
    {true,  0xE1, 0xC0, OBJECT,  "block upload"},
    {true,  0xE1, 0xC1, NOTHING, "block upload end"},
};

/* SDO abort codes, CiA 301, 7.2.4.3.17. */
static const struct {
    uint32_t code;
    const char *text;
} aborts[] = {
    {0x05030000, "toggle bit"},
    {0x05040000, "timeout"},
    {0x05040001, "command specifier"},
    {0x05040002, "block size"},
    {0x05040003, "sequence number"},
    {0x05040004, "CRC"},
    {0x05040005, "out of memory"},
    {0x06010000, "access"},
    {0x06010001, "write-only"},
    {0x06010002, "read-only"},
    {0x06020000, "no such object"},
    {0x06040041, "cannot be mapped"},
    {0x06040042, "PDO too long"},
    {0x06040043, "incompatible parameter"},
    {0x06040047, "incompatible inside"},
    {0x06060000, "hardware"},
    {0x06070010, "length"},
    {0x06070012, "too long"},
    {0x06070013, "too short"},
    {0x06090011, "no such sub-index"},
    {0x06090030, "value range"},
    {0x06090031, "value too high"},
    {0x06090032, "value too low"},
    {0x06090036, "maximum below minimum"},
    {0x08000000, "general error"},
    {0x08000020, "cannot be stored"},
    {0x08000021, "local control"},
    {0x08000022, "device state"},
    {0x08000023, "no dictionary"},
    {0x08000024, "no data"},
};
/* clang-format on */

static void add_words(const struct told *self, const char *text)
{
    dg_text_add(&self->to->text, text);
}

static void add_number(const struct told *self, const char *before, uint32_t value)
{
    add_words(self, before);
    dg_text_add_number(&self->to->text, value);
}

static void add_code(const struct told *self, const char *before, uint32_t code, unsigned digits)
{
    add_words(self, before);
    dg_words_add_code(self->to, code, digits);
}

static void judge_frame(const struct told *self, enum dg_severity severity)
{
    dg_words_judge(self->to, severity);
}

/* --- SDO --- */

static const char *abort_text(uint32_t code)
{
    for (size_t i = 0; i < DG_COUNT(aborts); i++) {
        if (aborts[i].code == code) {
            return aborts[i].text;
        }
    }
    return "unknown";
}

static void add_object(const struct told *self)
{
    const uint8_t *data = self->frame->data;

    add_code(self, " ", dg_load_le16(data + 1), 4);
    add_words(self, ":");
    dg_text_add_hex(&self->to->text, data[3], 2);
}

static void add_value(const struct told *self)
{
    const uint8_t *data = self->frame->data;
    const uint32_t value = dg_load_le32(data + 4);
    const bool sized = (data[0] & SIZED) != 0;

    add_object(self);
    if ((data[0] & EXPEDITED) != 0) {
        add_code(self, " = ", value, sized ? 2u * (4u - (data[0] >> 2 & 3u)) : 8u);
    } else if (sized) {
        add_number(self, ", ", value);
        add_words(self, " bytes");
    } else {
        add_words(self, ", in segments");
    }
}

static void add_segment(const struct told *self)
{
    const uint8_t *data = self->frame->data;
    const size_t unused = data[0] >> 1 & 7u;

    add_words(self, (data[0] & SEGMENT_END) != 0 ? ", the last" : "");
    dg_words_add_bytes(self->to, ":", data + 1, 7u - unused);
}

static void add_abort(const struct told *self)
{
    const uint32_t code = dg_load_le32(self->frame->data + 4);

    self->to->clause = "CiA 301 7.2.4.3.17";
    judge_frame(self, DG_SEVERITY_ERROR);
    add_object(self);
    add_code(self, ": ", code, 8);
    add_words(self, " ");
    add_words(self, abort_text(code));
}

static void add_content(const struct told *self, enum content content)
{
    const uint8_t *data = self->frame->data;

    switch (content) {
    case NOTHING:
        break;
    case OBJECT:
        add_object(self);
        break;
    case VALUE:
        add_value(self);
        break;
    case SEGMENT:
        add_segment(self);
        break;
    case CODE:
        add_abort(self);
        break;
    case NUMBERS:
        add_number(self, " up to ", data[1]);
        add_number(self, ", next ", data[2]);
        break;
    }
}

/* Whether the frame is a segment of a block. */
static bool is_segment(uint8_t block, bool reply, uint8_t first)
{
    const uint8_t sender = reply ? BLOCK_FROM_SERVER : BLOCK_FROM_CLIENT;
    const bool end = (block & BLOCK_LAST) != 0 && (first & BLOCK_MASK) == BLOCK_END;

    return (block & sender) != 0 && first != ABORT && !end;
}

/* What a frame makes of the transfer. */
static uint8_t next_block(uint8_t block, bool reply, uint8_t first)
{
    if (is_segment(block, reply, first)) {
        return (first & LAST) != 0 ? block | BLOCK_LAST : block;
    }
    if (reply && (first & BLOCK_MASK) == BLOCK_DOWNLOAD_AGREED) {
        return BLOCK_FROM_CLIENT;
    }
    if (!reply && (first & BLOCK_MASK) == BLOCK_UPLOAD_START) {
        return BLOCK_FROM_SERVER;
    }
    return (first & BLOCK_MASK) == BLOCK_RECEIVED ? block : 0;
}

static void add_block_segment(const struct told *self)
{
    const uint8_t *data = self->frame->data;

    add_number(self, "block segment ", data[0] & (uint8_t)~LAST);
    add_words(self, (data[0] & LAST) != 0 ? ", the last" : "");
    dg_words_add_bytes(self->to, ":", data + 1, sizeof self->frame->data - 1u);
}

static void add_sdo(const struct told *self, bool reply)
{
    const uint8_t *data = self->frame->data;
    uint8_t *block = &self->memory->blocks[self->node];
    const bool segment = is_segment(*block, reply, data[0]);

    *block = next_block(*block, reply, data[0]);
    if (segment) {
        add_block_segment(self);
        return;
    }
    for (size_t i = 0; i < DG_COUNT(sdos); i++) {
        const struct sdo *row = &sdos[i];

        if (row->reply == reply && (data[0] & row->mask) == row->value) {
            add_words(self, row->name);
            add_content(self, row->content);
            return;
        }
    }
    judge_frame(self, DG_SEVERITY_WARNING);
    add_words(self, "unknown service");
    dg_words_add_bytes(self->to, ":", data, sizeof self->frame->data);
}

static void add_sdo_reply(const struct told *self)
{
    add_words(self, " -> ");
    add_sdo(self, true);
}

static void add_sdo_request(const struct told *self)
{
    add_words(self, " ");
    add_sdo(self, false);
}

/* --- the other services --- */

static void add_name(const struct told *self, const struct name *names, size_t n, uint8_t code)
{
    add_words(self, " ");
    for (size_t i = 0; i < n; i++) {
        if (names[i].code == code) {
            judge_frame(self, (enum dg_severity)names[i].severity);
            add_words(self, names[i].name);
            return;
        }
    }
    judge_frame(self, DG_SEVERITY_WARNING);
    add_code(self, "", code, 2);
}

static void add_nmt(const struct told *self)
{
    const uint8_t *data = self->frame->data;

    add_name(self, nmt_commands, DG_COUNT(nmt_commands), data[0]);
    if (data[1] == 0) {
        add_words(self, " all nodes");
    } else {
        add_number(self, " node ", data[1]);
    }
}

static void add_sync(const struct told *self)
{
    if (self->frame->dlc > 0) {
        add_number(self, " ", self->frame->data[0]);
    }
}

static void add_time(const struct told *self)
{
    const uint8_t *data = self->frame->data;

    add_number(self, " ", dg_load_le32(data) & TIME_MS_MASK);
    add_number(self, " ms, day ", dg_load_le16(data + 4));
}

/* An error, or the end of the last one (CiA 301, 7.2.7.1). */
static void add_emcy(const struct told *self)
{
    const uint8_t *data = self->frame->data;
    const uint16_t code = dg_load_le16(data);

    judge_frame(self, code == 0 ? DG_SEVERITY_NOTICE : DG_SEVERITY_ERROR);
    add_code(self, " ", code, 4);
    add_code(self, code == 0 ? " no error, register " : " register ", data[2], 2);
    dg_words_add_bytes(self->to, ":", data + EMCY_MANUFACTURER,
                       self->frame->dlc - EMCY_MANUFACTURER);
}

static void add_pdo(const struct told *self)
{
    dg_words_add_bytes(self->to, ":", self->frame->data, self->frame->dlc);
}

static void add_heartbeat(const struct told *self)
{
    const uint8_t state = self->frame->data[0];

    add_name(self, nmt_states, DG_COUNT(nmt_states), (uint8_t)(state & ~TOGGLE));
    add_words(self, (state & TOGGLE) != 0 ? ", toggle" : "");
}

static void judge_lss(const struct told *self, const struct lss *row, bool reply)
{
    const bool failed = reply && row->reply > 0 && self->frame->data[1] != 0;

    if (row->changes) {
        judge_frame(self, failed ? DG_SEVERITY_ERROR : DG_SEVERITY_NOTICE);
    }
}

static void add_lss(const struct told *self, bool reply)
{
    const uint8_t *data = self->frame->data;

    for (size_t i = 0; i < DG_COUNT(lss_commands); i++) {
        const struct lss *row = &lss_commands[i];

        if (row->code == data[0]) {
            const uint8_t bytes = reply ? row->reply : row->request;

            judge_lss(self, row, reply);
            add_words(self, " ");
            add_words(self, row->name);
            if (bytes > 0) {
                add_code(self, " ", dg_load_le32(data + 1), 2u * bytes);
            }
            return;
        }
    }
    judge_frame(self, DG_SEVERITY_WARNING);
    dg_words_add_bytes(self->to, ":", data, self->frame->dlc);
}

static void add_lss_reply(const struct told *self)
{
    add_words(self, " ->");
    add_lss(self, true);
}

static void add_lss_request(const struct told *self)
{
    add_lss(self, false);
}

/* clang-format off */
/* A node's service is at base + node; `nodes` is 0 for those of the whole network. */
static const struct service {
    uint16_t base;
    uint8_t nodes;
    uint8_t least; /* length of the data */
    bool reply;    /* an encoder sends it */
    const char *clause;
    const char *name;
    void (*add)(const struct told *self);
} services[] = {
    {0x000, 0,     2, false, "CiA 301 7.2.8", "NMT",       add_nmt},
    {0x080, 0,     0, false, "CiA 301 7.2.5", "SYNC",      add_sync},
    {0x080, NODES, 3, true,  "CiA 301 7.2.7", "EMCY",      add_emcy},
    {0x100, 0,     6, false, "CiA 301 7.2.6", "TIME",      add_time},
    {0x180, NODES, 0, true,  "CiA 301 7.2.2", "TPDO1",     add_pdo},
    {0x200, NODES, 0, false, "CiA 301 7.2.2", "RPDO1",     add_pdo},
    {0x280, NODES, 0, true,  "CiA 301 7.2.2", "TPDO2",     add_pdo},
    {0x300, NODES, 0, false, "CiA 301 7.2.2", "RPDO2",     add_pdo},
    {0x380, NODES, 0, true,  "CiA 301 7.2.2", "TPDO3",     add_pdo},
    {0x400, NODES, 0, false, "CiA 301 7.2.2", "RPDO3",     add_pdo},
    {0x480, NODES, 0, true,  "CiA 301 7.2.2", "TPDO4",     add_pdo},
    {0x500, NODES, 0, false, "CiA 301 7.2.2", "RPDO4",     add_pdo},
    {0x580, NODES, 8, true,  "CiA 301 7.2.4", "SDO",       add_sdo_reply},
    {0x600, NODES, 8, false, "CiA 301 7.2.4", "SDO",       add_sdo_request},
    {0x700, NODES, 1, true,  "CiA 301 7.2.8", "heartbeat", add_heartbeat},
    {0x7E4, 0,     8, true,  "CiA 305",       "LSS",       add_lss_reply},
    {0x7E5, 0,     8, false, "CiA 305",       "LSS",       add_lss_request},
};
/* clang-format on */

static const struct service *find_service(uint16_t id)
{
    for (size_t i = 0; i < DG_COUNT(services); i++) {
        const struct service *row = &services[i];

        if (row->nodes == 0 ? id == row->base : id > row->base && id <= row->base + row->nodes) {
            return row;
        }
    }
    return NULL;
}

static void add_head(const struct told *self, const struct service *row)
{
    if (row == NULL) {
        add_code(self, "id ", self->frame->id, 3);
    } else {
        add_words(self, row->name);
    }
    if (self->node > 0) {
        add_number(self, " node ", self->node);
    }
}

static void add_frame(const struct told *self)
{
    const struct dg_can_frame *frame = self->frame;
    const struct service *row = find_service(frame->id);
    struct told told = *self;

    told.node = row != NULL && row->nodes > 0 ? (uint8_t)(frame->id - row->base) : 0;
    add_head(&told, row);
    told.to->clause = row == NULL ? NULL : row->clause;
    if (frame->rtr) {
        add_words(&told, " requested");
    } else if (row != NULL && frame->dlc >= row->least) {
        row->add(&told);
    } else {
        judge_frame(&told, row == NULL ? DG_SEVERITY_OK : DG_SEVERITY_ERROR);
        add_words(&told, row == NULL ? "" : ", too short");
        dg_words_add_bytes(told.to, ":", frame->data, frame->dlc);
    }
}

void dg_co_words_event(void *self, const struct dg_tap_event *event, const struct dg_words_to *to)
{
    struct dg_can_frame frame = event->frame;
    struct dg_words_draft draft;

    if (event->kind != DG_TAP_FRAME) {
        return;
    }
    frame.dlc = frame.dlc < sizeof frame.data ? frame.dlc : (uint8_t)sizeof frame.data;
    dg_words_begin(&draft);
    add_frame(&(struct told){&frame, 0, self, &draft});
    dg_words_give(&draft, event->at, event->ours, to);
}

/* A frame of nobody's service, and one of another node's, is for none. Only nodes that have a
   number have services at it, and masters alone ask by remote frames. */
int dg_co_words_side(const struct dg_tap_event *event, uint32_t node)
{
    const struct dg_can_frame *frame = &event->frame;
    const struct service *row = find_service(frame->id);

    if (row == NULL || (node != 0 && row->nodes > 0 && frame->id != row->base + node)) {
        return DG_WORDS_OTHER;
    }
    return row->reply && !frame->rtr ? DG_WORDS_ENCODER : DG_WORDS_MASTER;
}
