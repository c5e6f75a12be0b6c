/* SPDX-License-Identifier: MIT */
/*
 * An interface's kind, bit rate and counters, as `ip -details -statistics link` shows them: one
 * question to rtnetlink.
 *
 *   IFLA_LINKINFO { IFLA_INFO_KIND "can" | "vcan" | ..., IFLA_INFO_DATA { IFLA_CAN_BITTIMING } }
 *   IFLA_STATS64
 */
#define _GNU_SOURCE
#include <errno.h>
#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "can.h"

#define ANSWER_MAX 16384u

/* A list of attributes in memory of any alignment. */
struct attributes {
    const char *at;
    size_t left;
};

/* The content of the attribute called `type`; empty when there is none. */
static struct attributes find_attribute(struct attributes list, unsigned short type)
{
    struct rtattr head;
    while (list.left >= sizeof head) {
        memcpy(&head, list.at, sizeof head);
        if (head.rta_len < sizeof head || head.rta_len > list.left) {
            break;
        }
        if ((head.rta_type & NLA_TYPE_MASK) == type) {
            return (struct attributes){list.at + sizeof head, head.rta_len - sizeof head};
        }
        const size_t whole = RTA_ALIGN((size_t)head.rta_len);
        if (whole > list.left) {
            break;
        }
        list.at += whole;
        list.left -= whole;
    }
    return (struct attributes){NULL, 0};
}

/* A virtual interface takes what it sends for received, too, as everything on it is both. */
static void count(struct attributes statistics, struct lx_can_link *link)
{
    struct rtnl_link_stats64 stats;
    if (statistics.left < sizeof stats.rx_packets * 4) { /* the first four members */
        return;
    }
    memset(&stats, 0, sizeof stats);
    memcpy(&stats, statistics.at, statistics.left < sizeof stats ? statistics.left : sizeof stats);
    link->frames = stats.tx_packets + (link->is_virtual ? 0 : stats.rx_packets);
    link->bytes = stats.tx_bytes + (link->is_virtual ? 0 : stats.rx_bytes);
}

static int parse_link(const char *answer, size_t n, struct lx_can_link *link)
{
    static const char virtual_kind[] = "vcan";
    struct nlmsghdr head;
    struct nlmsgerr failure;
    struct ifinfomsg info;
    const size_t fixed = NLMSG_LENGTH(sizeof info);
    if (n < sizeof head) {
        return -EBADMSG;
    }
    memcpy(&head, answer, sizeof head);
    if (head.nlmsg_type == NLMSG_ERROR && n >= NLMSG_LENGTH(sizeof failure)) {
        memcpy(&failure, answer + NLMSG_HDRLEN, sizeof failure);
        return failure.error != 0 ? failure.error : -EBADMSG;
    }
    if (head.nlmsg_type != RTM_NEWLINK || n < fixed) {
        return -EBADMSG;
    }
    memcpy(&info, answer + NLMSG_HDRLEN, sizeof info);
    const struct attributes all = {answer + NLMSG_ALIGN(fixed), n - NLMSG_ALIGN(fixed)};
    const struct attributes details = find_attribute(all, IFLA_LINKINFO);
    const struct attributes kind = find_attribute(details, IFLA_INFO_KIND);
    const struct attributes timing =
        find_attribute(find_attribute(details, IFLA_INFO_DATA), IFLA_CAN_BITTIMING);
    *link = (struct lx_can_link){.up = (info.ifi_flags & (unsigned)IFF_UP) != 0};
    link->is_virtual =
        kind.left >= sizeof virtual_kind && memcmp(kind.at, virtual_kind, sizeof virtual_kind) == 0;
    count(find_attribute(all, IFLA_STATS64), link);
    if (timing.left >= sizeof link->bitrate) { /* the first member of struct can_bittiming */
        memcpy(&link->bitrate, timing.at, sizeof link->bitrate);
    }
    return 0;
}

static int ask_kernel(int fd, unsigned index, struct lx_can_link *link)
{
    char answer[ANSWER_MAX];
    struct {
        struct nlmsghdr head;
        struct ifinfomsg info;
    } request = {
        .head = {.nlmsg_len = sizeof request,
                 .nlmsg_type = RTM_GETLINK,
                 .nlmsg_flags = NLM_F_REQUEST},
        .info = {.ifi_family = AF_UNSPEC, .ifi_index = (int)index},
    };
    if (send(fd, &request, sizeof request, 0) < 0) {
        return -errno;
    }
    /* The kernel has answered when send() returns. */
    const ssize_t n = recv(fd, answer, sizeof answer, MSG_DONTWAIT);
    return n < 0 ? -errno : parse_link(answer, (size_t)n, link);
}

int lx_can_link_read(unsigned index, struct lx_can_link *link)
{
    const int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    if (fd < 0) {
        return -errno;
    }
    const int result = ask_kernel(fd, index, link);
    (void)close(fd);
    return result;
}
