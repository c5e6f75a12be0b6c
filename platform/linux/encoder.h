/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An RS485 encoder on the event loop: the device of the core, its deadline, its line.
 */
#ifndef DREHGEBER_LINUX_ENCODER_H
#define DREHGEBER_LINUX_ENCODER_H

#include "eeprom.h"
#include "serial.h"
#include "settings.h"

/** Opens one kind of line. */
typedef struct lx_serial *lx_serial_open(const struct lx_serial_setup *setup,
                                         struct lx_error *error);

/** What an encoder is made of. Everything pointed to must outlive it. */
struct lx_encoder_setup {
    sd_event *event;
    const struct lx_say *say;
    const struct lx_settings *settings;
    struct dg_nvm nvm;
    lx_serial_open *open;
    const char *where; /**< for `open` */
};

/** A running encoder. Not to be moved. */
struct lx_encoder {
    struct dg_hf device;
    struct lx_serial *port;
    struct lx_timer timer;
    struct dg_hf_uart uart; /**< what the line has been told */
};

/** Switch the power on at `now` and open the line. @return 0, or -1 with `error`, then close */
int lx_encoder_open(struct lx_encoder *self, const struct lx_encoder_setup *setup, dg_ns now,
                    struct lx_error *error);

/** Switch the power off and close the line; also after a failed open. */
void lx_encoder_close(struct lx_encoder *self);

#endif
