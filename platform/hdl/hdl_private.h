/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder in a simulator from inside:
 *
 *   inputs  ----------- delay, jitter ----------> | in | ---\
 *                                                            dg_host
 *   outputs <-- delay, jitter, clock to output -- | out | <-/
 */
#ifndef DREHGEBER_HDL_PRIVATE_H
#define DREHGEBER_HDL_PRIVATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/host.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/rig.h"
#include "hdl.h"
#include "motion_words.h"
#include "nvm_file.h"

/** "Never" as a moment. */
#define HDL_NEVER INT64_MAX
/** Time ends here, after 53 days: delays and characters that are added to it fit. */
#define HDL_END (INT64_MAX / 2)
#define HDL_PS_PER_NS INT64_C(1000)
/** Longest address of a control socket: "unix:" and the path. */
#define HDL_CONTROL_MAX 112
/** With a control socket somebody looks at least so often, in ps. */
#define HDL_CONTROL_REST (INT64_C(100000) * HDL_PS_PER_NS)

/** Levels from `at` on. */
struct hdl_change {
    int64_t at;
    int levels;
};

/** Changes on their way, in the order of time: a ring that grows. */
struct hdl_queue {
    struct hdl_change *change; /**< owned */
    size_t room;
    size_t first;
    size_t count;
    int64_t last; /**< `at` of the newest one that ever was */
    int levels;   /**< of the newest one: what is at the beginning of the way */
};

/** What is said of the wires beside the encoder's own settings, in ps. */
struct hdl_settings {
    uint32_t tco;
    uint32_t delay_in;
    uint32_t delay_out;
    uint32_t jitter;
    uint32_t power_on;
    uint32_t seed;
    char control[HDL_CONTROL_MAX + 1]; /**< "": none */
};

/** The control socket, see panel_socket.c. */
struct hdl_control;

/** RS485: a character on its way in, and the end of one on its way out. */
struct hdl_uart {
    uint32_t baud;
    uint8_t parity; /**< 'N', 'E' or 'O' */
    bool high;      /**< what the encoder hears now */
    bool receives;  /**< since `began` */
    uint32_t bit;   /**< of the character that is awaited, 0: the start bit */
    uint32_t taken; /**< levels of the bits so far */
    int64_t began;
    int64_t due;     /**< the middle of that bit, or the end of the character */
    int64_t release; /**< end of the last stop bit that is sent: the driver goes off */
};

/** What a kind of wire does with levels. Moments are in ps. */
struct hdl_wire_ops {
    int idle_in;  /**< levels of the inputs when nobody does anything */
    int idle_out; /**< levels of the outputs until the first power */
    /** It is as before the first edge. NULL: nothing to do. */
    void (*reset)(struct dg_hdl *self);
    /** The inputs at the encoder's end are at these levels now. */
    void (*take)(struct dg_hdl *self, int64_t now, int levels);
    /** When there is something to do besides; HDL_NEVER. NULL: the encoder's own deadlines only. */
    int64_t (*due)(const struct dg_hdl *self);
    /** Do it. NULL with `due`. */
    void (*run)(struct dg_hdl *self, int64_t now);
    /** The encoder has sent something. */
    void (*heard)(struct dg_hdl *self, const struct dg_host_event *event);
};

/** See hdl.h. */
struct dg_hdl {
    struct hdl_settings settings;
    const struct hdl_wire_ops *wire;
    const struct dg_device *device; /**< of `plan`; NULL: one that is built in, by its name */
    struct dg_plan plan;            /**< of a file of models, in ... */
    void *models;                   /**< owned; NULL: no file was read */
    struct dg_host *host;           /**< owned, as the next one */
    struct dg_host_panel *panel;
    struct hdl_control *control; /**< owned; NULL: none */
    struct lx_nvm_file memory;
    struct lx_shaft shaft; /**< points of the motion at hand */
    int64_t now;
    int64_t due;      /**< nothing happens before by itself: neither does a change arrive, nor does
                           the encoder do anything */
    int64_t power_at; /**< the first power comes; HDL_NEVER before the first look, and afterwards */
    int64_t panel_due;
    int64_t hint_due; /**< when the encoder may have something to tell the user */
    const char *hint; /**< what it had to tell at the latest look; NULL: nothing */
    uint32_t random;
    bool looked;  /**< somebody has said how the inputs are, or has switched the power */
    bool listens; /**< the inputs were at rest at power-on, or have been since */
    struct hdl_uart uart;
    int inputs;
    int outputs;
    struct hdl_queue in;
    struct hdl_queue out;
    char error[1200];
    char answer[DG_HDL_TEXT_MAX];
};

/** hdl.c: leave a line in `error`, printf style. @return `result` */
int hdl_fail(struct dg_hdl *self, int result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** model_file.c: if MODEL names a file, read it: self->device is the model. @return 0, or -1 with
 * an error */
int hdl_read_model(struct dg_hdl *self, const char *model);
/** model_file.c: leave why power failed with `result`: of the EEPROM in the file `memory`, or ""
 * without one. @return `result` */
int hdl_fail_memory(struct dg_hdl *self, int result, const char *memory);

/** A text from outside: NULL is "". */
static inline const char *hdl_text(const char *text)
{
    return text != NULL ? text : "";
}

/** levels.c: the kinds. */
extern const struct hdl_wire_ops hdl_clocked;
/** uart.c: likewise. */
extern const struct hdl_wire_ops hdl_serial;
/** Power has gone: what has not left the encoder is not sent. */
void hdl_cut(struct dg_hdl *self);
/** Time goes on to `now`, or to what it is if that is later. @return nanoseconds */
uint64_t hdl_run(struct dg_hdl *self, int64_t now);
/** The outputs are at `levels` at the encoder's end from `now` on. */
void hdl_put(struct dg_hdl *self, int64_t now, int levels);
/** What the encoder does next may have changed from outside. */
void hdl_look(struct dg_hdl *self);
/** panel_socket.c: listen where the settings say. @return 0, or less with an error */
int hdl_control_open(struct dg_hdl *self);
/** Serve a client, if there is one, and if a millisecond has passed outside of the simulation. */
void hdl_control_poll(struct dg_hdl *self);
/** Remove the socket; NULL is fine. */
void hdl_control_close(struct hdl_control *self);
/** Give the queue back. */
void hdl_queue_free(struct hdl_queue *self);

#endif
