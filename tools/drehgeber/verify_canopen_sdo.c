/* SPDX-License-Identifier: MIT */
/* Objects of a CANopen encoder, one at a time, by SDO. */
#include <string.h>

#include "verify_canopen.h"

/* The answer to the upload that was asked for last; late ones, to other uploads, are dropped. @return false:
   none came that brings something */
static bool await_upload(struct canopen *self, struct dg_can_frame *to)
{
    const uint16_t id = (uint16_t)(SDO_ANSWER + self->node);
    const dg_ns until = self->base.since + ANSWER_MAX;
    struct cf_report report = {0};
    for (unsigned i = 0; i < LATE_MAX; i++) {
        if (verify_canopen_receive_id(self, id, until, to, &report) != 1) {
            return false;
        }
        if (to->dlc == 8 && memcmp(to->data + 1, self->request.data + 1, 3) == 0) {
            self->abort = to->data[0] == 0x80u ? le32(to->data + 4) : 0;
            return to->data[0] >> 5 == 2u;
        }
    }
    return false;
}

/* Upload an object of at most four bytes. @return how many, 0: it was not answered so */
size_t verify_canopen_upload(struct canopen *self, uint16_t index, uint8_t sub, uint32_t *value)
{
    struct dg_can_frame frame = {.id = (uint16_t)(SDO_REQUEST + self->node), .dlc = 8};
    struct cf_report report = {0};
    uint8_t bytes[4] = {0};
    self->abort = 0;
    frame.data[0] = 0x40;
    frame.data[1] = (uint8_t)index;
    frame.data[2] = (uint8_t)(index >> 8);
    frame.data[3] = sub;
    if (!verify_canopen_send_frame(self, &frame, &report) || !await_upload(self, &frame)) {
        return 0;
    }
    if ((frame.data[0] & 2u) == 0) {
        /* It is longer, and would go on in segments. */
        self->abort = LONGER;
        frame = self->request;
        frame.data[0] = 0x80;
        (void)verify_canopen_send_frame(self, &frame, &report);
        return 0;
    }
    /* A server may leave open how many bytes of the four are data. */
    const size_t n = (frame.data[0] & 1u) != 0 ? 4u - (frame.data[0] >> 2 & 3u) : 4u;
    memcpy(bytes, frame.data + 4, n);
    *value = le32(bytes);
    return n;
}

bool verify_canopen_download(struct canopen *self, const struct cf_unit *unit)
{
    struct dg_can_frame frame = {.id = (uint16_t)(SDO_REQUEST + self->node), .dlc = 8};
    struct cf_report report = {0};
    memcpy(frame.data, unit->bytes, unit->n < 8 ? unit->n : 8u);
    return verify_canopen_send_frame(self, &frame, &report) &&
           verify_canopen_receive_id(self, (uint16_t)(SDO_ANSWER + self->node),
                                     self->base.since + ANSWER_MAX, &frame, &report) == 1 &&
           frame.data[0] == 0x60u;
}
