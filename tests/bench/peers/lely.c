/* SPDX-License-Identifier: MIT */
/* lely-core, with the EDS file itself: PEER_EDS is its path. */
#include <string.h>
#include <time.h>

#include <lely/can/net.h>
#include <lely/co/dcf.h>
#include <lely/co/dev.h>
#include <lely/co/nmt.h>

#include "peer.h"

static can_net_t *net;
static struct timespec now;

static int report_frame(const struct can_msg *msg, void *data)
{
    (void)data;
    if ((msg->flags & CAN_FLAG_RTR) == 0) {
        from_peer((uint16_t)msg->id, msg->len, msg->data);
    }
    return 0;
}

bool peer_start(void)
{
    co_dev_t *dev = co_dev_create_from_dcf_file(PEER_EDS);

    net = can_net_create();
    if (dev == NULL || net == NULL || co_dev_set_id(dev, NODE_ID) != 0) {
        return false;
    }
    can_net_set_send_func(net, report_frame, NULL);
    co_nmt_t *nmt = co_nmt_create(net, dev);
    return nmt != NULL && can_net_set_time(net, &now) == 0 &&
           co_nmt_cs_ind(nmt, CO_NMT_CS_RESET_NODE) == 0;
}

/* All that a frame needs; its clock is set by peer_wait(). */
void to_peer(const struct peer_frame *frame)
{
    struct can_msg msg = CAN_MSG_INIT;

    msg.id = frame->id;
    msg.len = frame->dlc;
    memcpy(msg.data, frame->data, sizeof frame->data);
    (void)can_net_recv(net, &msg);
}

void peer_wait(void)
{
    now.tv_nsec += 1000000;
    if (now.tv_nsec >= 1000000000) {
        now.tv_nsec -= 1000000000;
        now.tv_sec++;
    }
    (void)can_net_set_time(net, &now);
}
