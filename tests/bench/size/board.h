/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a board brings along: a clock, a wire, a memory, what its sensors say, and room. Nothing is
 * known of it where it is used.
 */
#ifndef BENCH_SIZE_BOARD_H
#define BENCH_SIZE_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/canopen.h"
#include "drehgeber/control.h"

#define BOARD_DEVICE_MAX 4096u
#define BOARD_HANDLE_MAX 16384u

extern volatile dg_ns board_now;
extern volatile bool board_received; /**< something has come */
extern volatile uint32_t board_in;   /**< it */
extern volatile uint32_t board_out;  /**< what goes out */
extern volatile struct dg_can_frame board_rx, board_tx;
extern struct dg_nvm board_nvm;
extern struct dg_world board_world;
extern unsigned char board_device[BOARD_DEVICE_MAX], board_handle[BOARD_HANDLE_MAX];
extern struct dg_encoder board_encoder;
extern struct dg_rig_shaft board_shaft;
extern struct dg_control board_control;
extern const struct dg_rig_ops board_ops;

/** A session's bytes. */
void board_write(void *ctx, const char *bytes, size_t n);

#endif
