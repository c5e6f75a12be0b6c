/* SPDX-License-Identifier: MIT */
/*
 * CAN frames as candump -L prints them, and as pcapng (draft-ietf-opsawg-pcapng) with the link type
 * of SocketCAN: a section header, an interface, a packet for each frame. All fields of a block are
 * 32 bits or padded to them.
 */
#include <inttypes.h>
#include <string.h>

#include "drehgeber/bits.h"
#include "trace_format.h"

#define NS_PER_S 1000000000u
#define NS_PER_US 1000u

#define SECTION_HEADER 0x0A0D0D0Au
#define INTERFACE 1u
#define ENHANCED_PACKET 6u
#define BYTE_ORDER 0x1A2B3C4Du
#define LINKTYPE_CAN_SOCKETCAN 227u
#define OPTION_USER_APPLICATION 4u
#define OPTION_IF_NAME 2u
#define OPTION_IF_TSRESOL 9u
#define OPTION_EPB_FLAGS 2u
#define RESOLUTION_NS 9u
#define APPLICATION "drehgeber"
/* The option of the section header that names it, behind type, length, byte order, version and the
   section's length. */
#define MARK_BYTES "\x04\x00\x09\x00" APPLICATION
#define PCAPNG_MARK                                                                                \
    {                                                                                              \
        24, sizeof MARK_BYTES - 1u, MARK_BYTES                                                     \
    }
#define INBOUND 1u
#define OUTBOUND 2u

/* struct can_frame of Linux, the CAN-ID as it goes over a network. */
#define CAN_FRAME_SIZE 16u
#define CAN_FRAME_DATA 8u
#define CAN_FRAME_RTR 0x40000000u

/* Longest block here: type, length, 20 bytes, a frame, flags, end of options, length. */
#define BLOCK_MAX 96u

static uint64_t day_ns(const struct lx_trace *self, dg_ns at)
{
    return self->day_ns + at;
}

static uint8_t data_length(const struct dg_can_frame *frame)
{
    return frame->dlc < sizeof frame->data ? frame->dlc : (uint8_t)sizeof frame->data;
}

/* ---------------------------------------------------------------- candump -L */

static void log_event(struct lx_trace *self, const struct dg_tap_event *event)
{
    const struct dg_can_frame *frame = &event->frame;
    const uint8_t n = data_length(frame);
    if (event->kind != DG_TAP_FRAME) {
        return;
    }
    const uint64_t at = day_ns(self, event->at);
    (void)fprintf(self->file, "(%010" PRIu64 ".%06" PRIu64 ") %s %03X#", at / NS_PER_S,
                  at % NS_PER_S / NS_PER_US, self->wire, frame->id);
    if (frame->rtr) {
        /* A length of 0 is not printed. */
        (void)fprintf(self->file, n > 0 ? "R%u" : "R", n);
    }
    for (uint8_t i = 0; !frame->rtr && i < n; i++) {
        (void)fprintf(self->file, "%02X", frame->data[i]);
    }
    (void)fputc('\n', self->file);
}

const struct lx_trace_format lx_trace_log = {
    .ending = ".log",
    .size = 1,
    .event = log_event,
};

/* ---------------------------------------------------------------- pcapng */

/* A block under construction. */
struct block {
    uint8_t bytes[BLOCK_MAX];
    size_t length;
};

static void put16(struct block *self, uint16_t value)
{
    dg_store_le16(self->bytes + self->length, value);
    self->length += sizeof value;
}

static void put32(struct block *self, uint32_t value)
{
    dg_store_le32(self->bytes + self->length, value);
    self->length += sizeof value;
}

static void put_bytes(struct block *self, const void *bytes, size_t n)
{
    memcpy(self->bytes + self->length, bytes, n);
    self->length += (n + 3u) & ~(size_t)3u;
}

static void put_option(struct block *self, uint16_t code, const void *bytes, size_t n)
{
    put16(self, code);
    put16(self, (uint16_t)n);
    put_bytes(self, bytes, n);
}

static struct block block_of(uint32_t type)
{
    struct block block = {.length = 0};
    put32(&block, type);
    put32(&block, 0); /* the length, when it is known */
    return block;
}

static void write_block(struct lx_trace *self, struct block *block)
{
    const uint32_t length = (uint32_t)block->length + sizeof length;
    put32(block, length);
    dg_store_le32(block->bytes + sizeof length, length);
    (void)fwrite(block->bytes, 1, block->length, self->file);
}

static void pcapng_begin(struct lx_trace *self)
{
    const uint8_t resolution = RESOLUTION_NS;
    struct block section = block_of(SECTION_HEADER);
    put32(&section, BYTE_ORDER);
    put16(&section, 1); /* version 1.0 */
    put16(&section, 0);
    put32(&section, UINT32_MAX); /* length of the section: unknown */
    put32(&section, UINT32_MAX);
    put_option(&section, OPTION_USER_APPLICATION, APPLICATION, sizeof APPLICATION - 1u);
    put32(&section, 0); /* end of options */
    write_block(self, &section);

    struct block interface = block_of(INTERFACE);
    put16(&interface, LINKTYPE_CAN_SOCKETCAN);
    put16(&interface, 0);
    put32(&interface, 0); /* no limit of the packets' length */
    put_option(&interface, OPTION_IF_NAME, self->wire, strlen(self->wire));
    put_option(&interface, OPTION_IF_TSRESOL, &resolution, sizeof resolution);
    put32(&interface, 0); /* end of options */
    write_block(self, &interface);
}

static void pcapng_event(struct lx_trace *self, const struct dg_tap_event *event)
{
    const struct dg_can_frame *frame = &event->frame;
    uint8_t packet[CAN_FRAME_SIZE] = {0};
    uint8_t flags[4];
    if (event->kind != DG_TAP_FRAME) {
        return;
    }
    dg_store_be32(packet, frame->id | (frame->rtr ? CAN_FRAME_RTR : 0));
    packet[4] = data_length(frame);
    if (!frame->rtr) {
        memcpy(packet + CAN_FRAME_DATA, frame->data, data_length(frame));
    }
    dg_store_le32(flags, event->ours ? OUTBOUND : INBOUND);

    const uint64_t at = day_ns(self, event->at);
    struct block block = block_of(ENHANCED_PACKET);
    put32(&block, 0); /* interface */
    put32(&block, (uint32_t)(at >> 32));
    put32(&block, (uint32_t)at);
    put32(&block, sizeof packet); /* captured */
    put32(&block, sizeof packet); /* on the wire */
    put_bytes(&block, packet, sizeof packet);
    put_option(&block, OPTION_EPB_FLAGS, flags, sizeof flags);
    put32(&block, 0); /* end of options */
    write_block(self, &block);
}

const struct lx_trace_format lx_trace_pcapng = {
    .ending = ".pcapng",
    .also = ".pcap",
    .mark = PCAPNG_MARK,
    .size = 1,
    .begin = pcapng_begin,
    .event = pcapng_event,
};
