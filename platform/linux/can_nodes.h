/* SPDX-License-Identifier: MIT */
/**
 * @file
 * CANopen encoders on the event loop: several nodes of one model on one bus and one shaft, each
 * with an EEPROM of its own. On a SocketCAN or SLCAN wire they do not hear each other, only what
 * others send.
 */
#ifndef DREHGEBER_LINUX_CAN_NODES_H
#define DREHGEBER_LINUX_CAN_NODES_H

#include "can.h"
#include "drehgeber/cia406.h"
#include "nvm_file.h"
#include "nvm_memory.h"

/** What the encoders are made of. Everything pointed to must outlive them. */
struct lx_can_nodes_setup {
    sd_event *event;
    const struct lx_say *say;
    const struct dg_cia406_model *model;
    const struct dg_world *world;
    lx_can_open *open;
    const char *where; /**< for `open` */
    const char *nvm;   /**< file of the EEPROM, of several nodes with .NODE behind it; NULL: none */
    uint32_t serial;   /**< of the first node; the next ones count up */
    bool serial_given; /**< it was asked for: a file with another one is refused */
    uint8_t first;     /**< node-IDs first..last in delivery state */
    uint8_t last;
};

/** One encoder. */
struct lx_can_node {
    struct lx_can_nodes *all;
    struct dg_co_node device;
    struct dg_cia406 encoder;
    struct lx_nvm_memory memory;
    struct lx_nvm_file file;
    char *path;     /**< of `file`; owned */
    uint16_t kbaud; /**< bit rate in force */
    bool hears;     /**< the wire has this rate, too */
};

/** Running encoders. Not to be moved. */
struct lx_can_nodes {
    struct lx_can_nodes_setup setup;
    struct lx_can *bus;
    struct lx_timer timer;
    struct dg_co_net net;                    /**< nodes that hear the wire */
    uint8_t filter_version[DG_CO_NET_NODES]; /**< of `net`, when the bus was told */
    bool told;                /**< the bus knows who listens to what, but for filter_version */
    bool retuned;             /**< a node's bit rate has changed */
    struct lx_can_node *node; /**< owned */
    unsigned count;
};

/**
 * Open the bus and switch the power on at `now`.
 * @return 0, or -1 with one line in `error`, then close
 */
int lx_can_nodes_open(struct lx_can_nodes *self, const struct lx_can_nodes_setup *setup, dg_ns now,
                      struct lx_error *error);

/** Switch the power off and close everything; also after a failed open, or when all is zero. */
void lx_can_nodes_close(struct lx_can_nodes *self);

#endif
