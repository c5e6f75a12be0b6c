/* SPDX-License-Identifier: MIT */
/*
 * SDO: the first byte says the service (CiA 301, 7.2.4), but for the segments of a block transfer,
 * whose first byte is a number. Who sends segments is remembered for each node:
 *
 *   upload:    A3h from the client   -> segments from the server, last one marked -> C1h
 *   download:  A0h from the server   -> segments from the client, last one marked -> C1h
 */
#include "decode.h"
#include "drehgeber/bits.h"

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

/* Block transfer of a node, in lx_decoder.bytes. */
enum block {
    BLOCK_FROM_CLIENT = 1,
    BLOCK_FROM_SERVER = 2,
    BLOCK_LAST = 4, /* the last segment has been seen; it may be repeated */
};

/* What a frame carries besides its service. */
enum content {
    NOTHING,
    OBJECT,
    VALUE,   /* object and expedited data, or object and size */
    SEGMENT, /* up to seven bytes */
    CODE,    /* object and abort code */
    NUMBERS, /* segments received in order, segments of the next block */
};

/* clang-format off */
static const struct service {
    bool reply;
    uint8_t mask;
    uint8_t value;
    enum content content;
    const char *name;
} services[] = {
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

static const char *abort_text(uint32_t code)
{
    for (size_t i = 0; i < DG_COUNT(aborts); i++) {
        if (aborts[i].code == code) {
            return aborts[i].text;
        }
    }
    return "unknown";
}

static void add_object(const uint8_t *data, struct lx_text *text)
{
    lx_text_add(text, " %04Xh:%02X", dg_load_le16(data + 1), data[3]);
}

static void add_value(const uint8_t *data, struct lx_text *text)
{
    const uint32_t value = dg_load_le32(data + 4);
    const bool sized = (data[0] & SIZED) != 0;
    add_object(data, text);
    if ((data[0] & EXPEDITED) == 0 && sized) {
        lx_text_add(text, ", %u bytes", value);
        return;
    }
    if ((data[0] & EXPEDITED) == 0) {
        lx_text_add(text, ", in segments");
        return;
    }
    const int bytes = sized ? 4 - (data[0] >> 2 & 3) : 4;
    lx_text_add(text, " = %0*Xh", 2 * bytes, bytes < 4 ? value & ((1u << 8 * bytes) - 1u) : value);
}

static void add_segment(const uint8_t *data, struct lx_text *text)
{
    const size_t unused = data[0] >> 1 & 7u;
    lx_text_add(text, "%s", (data[0] & SEGMENT_END) != 0 ? ", the last" : "");
    lx_text_bytes(text, ":", data + 1, 7u - unused);
}

static void add_content(enum content content, const uint8_t *data, struct lx_text *text)
{
    const uint32_t code = dg_load_le32(data + 4);
    switch (content) {
    case NOTHING:
        break;
    case OBJECT:
        add_object(data, text);
        break;
    case VALUE:
        add_value(data, text);
        break;
    case SEGMENT:
        add_segment(data, text);
        break;
    case CODE:
        add_object(data, text);
        lx_text_add(text, ": %08Xh %s", code, abort_text(code));
        break;
    case NUMBERS:
        lx_text_add(text, " up to %u, next %u", data[1], data[2]);
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

void lx_decode_sdo(struct lx_decoder *self, const struct dg_can_frame *frame, uint8_t node,
                   bool reply, struct lx_text *text)
{
    const uint8_t first = frame->data[0];
    lx_text_add(text, reply ? " -> " : " ");
    const bool segment = is_segment(self->bytes[node], reply, first);
    self->bytes[node] = next_block(self->bytes[node], reply, first);
    if (segment) {
        lx_text_add(text, "block segment %u%s", first & ~LAST,
                    (first & LAST) != 0 ? ", the last" : "");
        lx_text_bytes(text, ":", frame->data + 1, sizeof frame->data - 1);
        return;
    }
    for (size_t i = 0; i < DG_COUNT(services); i++) {
        const struct service *row = &services[i];
        if (row->reply == reply && (first & row->mask) == row->value) {
            lx_text_add(text, "%s", row->name);
            add_content(row->content, frame->data, text);
            return;
        }
    }
    lx_text_add(text, "unknown service");
    lx_text_bytes(text, ":", frame->data, sizeof frame->data);
}
