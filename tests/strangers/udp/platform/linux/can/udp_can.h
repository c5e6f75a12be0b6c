/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A CAN bus in UDP datagrams (udp_can.c).
 */
#ifndef DREHGEBER_LINUX_UDP_CAN_H
#define DREHGEBER_LINUX_UDP_CAN_H

#include "can.h"

/** Opens one at HOST:PORT. @return NULL with one line in `error` */
lx_can_open lx_udp_can_open;

#endif
