/* SPDX-License-Identifier: MIT */
/*
 * CAN frames by the predefined connection set of CiA 301: the CAN-ID says the service and the node.
 */
#include "decode.h"
#include "drehgeber/bits.h"

#define NODES 0x7Fu
#define TOGGLE 0x80u
#define TIME_MS_MASK 0x0FFFFFFFu
#define EMCY_MANUFACTURER 3u

/* A code and its name. */
struct name {
    uint8_t code;
    const char *name;
};

/* clang-format off */
static const struct name nmt_commands[] = {
    {0x01, "start"}, {0x02, "stop"}, {0x80, "enter pre-operational"}, {0x81, "reset"},
    {0x82, "reset communication"},
};

static const struct name nmt_states[] = {
    {0x00, "boot-up"}, {0x04, "stopped"}, {0x05, "operational"}, {0x7F, "pre-operational"},
};

/* Layer setting services, CiA 305: bytes of the argument, from the master and from the slave. */
static const struct lss {
    uint8_t code;
    uint8_t request;
    uint8_t reply;
    const char *name;
} lss_commands[] = {
    {0x04, 1, 0, "switch state global"},
    {0x11, 1, 1, "configure node-ID"},
    {0x13, 2, 1, "configure bit timing"},
    {0x15, 2, 0, "activate bit timing"},
    {0x17, 0, 1, "store configuration"},
    {0x40, 4, 0, "switch state selective vendor-ID"},
    {0x41, 4, 0, "switch state selective product code"},
    {0x42, 4, 0, "switch state selective revision"},
    {0x43, 4, 0, "switch state selective serial number"},
    {0x44, 0, 0, "switch state selective"},
    {0x46, 4, 0, "identify vendor-ID"},
    {0x47, 4, 0, "identify product code"},
    {0x48, 4, 0, "identify revision from"},
    {0x49, 4, 0, "identify revision to"},
    {0x4A, 4, 0, "identify serial number from"},
    {0x4B, 4, 0, "identify serial number to"},
    {0x4C, 0, 0, "identify non-configured"},
    {0x4F, 0, 0, "identify slave"},
    {0x50, 0, 0, "identify non-configured slave"},
    {0x51, 4, 0, "fastscan"},
    {0x5A, 0, 4, "inquire vendor-ID"},
    {0x5B, 0, 4, "inquire product code"},
    {0x5C, 0, 4, "inquire revision"},
    {0x5D, 0, 4, "inquire serial number"},
    {0x5E, 0, 1, "inquire node-ID"},
};
/* clang-format on */

/* A frame on its way to words. */
struct service_frame {
    const struct dg_can_frame *frame;
    uint8_t node;
    struct lx_decoder *decoder;
};

static void add_name(struct lx_text *text, const struct name *names, size_t n, uint8_t code)
{
    for (size_t i = 0; i < n; i++) {
        if (names[i].code == code) {
            lx_text_add(text, "%s", names[i].name);
            return;
        }
    }
    lx_text_add(text, "%02Xh", code);
}

static void add_nmt(const struct service_frame *self, struct lx_text *text)
{
    const uint8_t *data = self->frame->data;
    lx_text_add(text, " ");
    add_name(text, nmt_commands, DG_COUNT(nmt_commands), data[0]);
    if (data[1] == 0) {
        lx_text_add(text, " all nodes");
    } else {
        lx_text_add(text, " node %u", data[1]);
    }
}

static void add_sync(const struct service_frame *self, struct lx_text *text)
{
    if (self->frame->dlc > 0) {
        lx_text_add(text, " %u", self->frame->data[0]);
    }
}

static void add_time(const struct service_frame *self, struct lx_text *text)
{
    const uint8_t *data = self->frame->data;
    lx_text_add(text, " %u ms, day %u", dg_load_le32(data) & TIME_MS_MASK, dg_load_le16(data + 4));
}

static void add_emcy(const struct service_frame *self, struct lx_text *text)
{
    const uint8_t *data = self->frame->data;
    const uint16_t code = dg_load_le16(data);
    lx_text_add(text, " %04Xh%s register %02Xh", code, code == 0 ? " no error," : "", data[2]);
    lx_text_bytes(text, ":", data + EMCY_MANUFACTURER, self->frame->dlc - EMCY_MANUFACTURER);
}

static void add_pdo(const struct service_frame *self, struct lx_text *text)
{
    lx_text_bytes(text, ":", self->frame->data, self->frame->dlc);
}

static void add_heartbeat(const struct service_frame *self, struct lx_text *text)
{
    const uint8_t state = self->frame->data[0];
    lx_text_add(text, " ");
    add_name(text, nmt_states, DG_COUNT(nmt_states), (uint8_t)(state & ~TOGGLE));
    lx_text_add(text, "%s", (state & TOGGLE) != 0 ? ", toggle" : "");
}

static void add_sdo_reply(const struct service_frame *self, struct lx_text *text)
{
    lx_decode_sdo(self->decoder, self->frame, self->node, true, text);
}

static void add_sdo_request(const struct service_frame *self, struct lx_text *text)
{
    lx_decode_sdo(self->decoder, self->frame, self->node, false, text);
}

static void add_lss(const struct dg_can_frame *frame, bool reply, struct lx_text *text)
{
    for (size_t i = 0; i < DG_COUNT(lss_commands); i++) {
        const struct lss *row = &lss_commands[i];
        if (row->code != frame->data[0]) {
            continue;
        }
        const uint8_t bytes = reply ? row->reply : row->request;
        lx_text_add(text, " %s", row->name);
        if (bytes > 0) {
            const uint32_t mask = bytes < 4 ? (1u << 8 * bytes) - 1u : UINT32_MAX;
            lx_text_add(text, " %0*Xh", 2 * bytes, dg_load_le32(frame->data + 1) & mask);
        }
        return;
    }
    lx_text_bytes(text, ":", frame->data, frame->dlc);
}

static void add_lss_reply(const struct service_frame *self, struct lx_text *text)
{
    lx_text_add(text, " ->");
    add_lss(self->frame, true, text);
}

static void add_lss_request(const struct service_frame *self, struct lx_text *text)
{
    add_lss(self->frame, false, text);
}

/* clang-format off */
/* A node's service is at base + node; `nodes` is 0 for those of the whole network. */
static const struct service {
    uint16_t base;
    uint8_t nodes;
    uint8_t least; /* length of the data */
    const char *name;
    void (*add)(const struct service_frame *self, struct lx_text *text);
} services[] = {
    {0x000, 0,     2, "NMT",       add_nmt},
    {0x080, 0,     0, "SYNC",      add_sync},
    {0x080, NODES, 3, "EMCY",      add_emcy},
    {0x100, 0,     6, "TIME",      add_time},
    {0x180, NODES, 0, "TPDO1",     add_pdo},
    {0x200, NODES, 0, "RPDO1",     add_pdo},
    {0x280, NODES, 0, "TPDO2",     add_pdo},
    {0x300, NODES, 0, "RPDO2",     add_pdo},
    {0x380, NODES, 0, "TPDO3",     add_pdo},
    {0x400, NODES, 0, "RPDO3",     add_pdo},
    {0x480, NODES, 0, "TPDO4",     add_pdo},
    {0x500, NODES, 0, "RPDO4",     add_pdo},
    {0x580, NODES, 8, "SDO",       add_sdo_reply},
    {0x600, NODES, 8, "SDO",       add_sdo_request},
    {0x700, NODES, 1, "heartbeat", add_heartbeat},
    {0x7E4, 0,     8, "LSS",       add_lss_reply},
    {0x7E5, 0,     8, "LSS",       add_lss_request},
};
/* clang-format on */

static const struct service *find(uint16_t id)
{
    for (size_t i = 0; i < DG_COUNT(services); i++) {
        const struct service *row = &services[i];
        if (row->nodes == 0 ? id == row->base : id > row->base && id <= row->base + row->nodes) {
            return row;
        }
    }
    return NULL;
}

void lx_decode_can(struct lx_decoder *self, const struct dg_can_frame *frame, struct lx_text *text)
{
    struct dg_can_frame copy = *frame;
    const struct service *row = find(frame->id);
    copy.dlc = copy.dlc < sizeof copy.data ? copy.dlc : (uint8_t)sizeof copy.data;
    if (row == NULL) {
        lx_text_add(text, "id %03Xh", frame->id);
    } else {
        lx_text_add(text, "%s", row->name);
    }
    const uint8_t node = row != NULL && row->nodes > 0 ? (uint8_t)(frame->id - row->base) : 0;
    if (node > 0) {
        lx_text_add(text, " node %u", node);
    }
    if (frame->rtr) {
        lx_text_add(text, " requested");
    } else if (row != NULL && copy.dlc >= row->least) {
        row->add(&(struct service_frame){&copy, node, self}, text);
    } else {
        lx_text_add(text, "%s", row == NULL ? "" : ", too short");
        lx_text_bytes(text, ":", copy.data, copy.dlc);
    }
}
