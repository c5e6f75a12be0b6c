/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a rig is to be: shafts, wires, encoders, in the user's words, in the order they were
 * declared. A rig file (plan_file.c) or a command line makes one; lx_rig_open() makes the rig.
 */
#ifndef DREHGEBER_LINUX_PLAN_H
#define DREHGEBER_LINUX_PLAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/devices.h"
#include "error.h"
#include "plan_names.h"

/** Control addresses of a rig. */
#define LX_PLAN_CONTROLS_MAX 4u

/** Where a word stands; 0: on the command line. */
typedef unsigned lx_line_number;

/** A setting, or a word of a section. */
struct lx_plan_setting {
    char *key;
    char *value;
    lx_line_number line;
};

/** Settings of one thing. */
struct lx_plan_settings {
    struct lx_plan_setting *list; /**< owned */
    size_t count;
};

/** An address that nobody has given. */
#define LX_PLAN_AS_DELIVERED (-1)

/** A shaft. */
struct lx_plan_shaft {
    char *name;
    char *motion;     /**< in words, see motion_words.h; NULL: at rest at 0, or geared */
    int driver;       /**< index of the shaft that drives it, declared before; -1: none */
    int32_t ratio[2]; /**< turns of this shaft, for as many of the driver */
    lx_line_number line;
    lx_line_number motion_line; /**< of the key */
};

/** A kind of wire; its rows are in wires.c. */
struct lx_wire;

/** A wire: a bus, or the private line of one encoder. */
struct lx_plan_wire {
    char *name; /**< of the [bus NAME] section, or of the encoder it belongs to */
    const struct lx_wire *kind;
    char *where;                      /**< LINK, DEV, IFNAME, HOST:PORT, CHIP:CLOCK,DATA; or NULL */
    char *trace;                      /**< file, or NULL */
    struct lx_plan_settings settings; /**< of the wire itself, e.g. cycle of a ring */
    lx_line_number line;              /**< of the section */
    lx_line_number where_line;        /**< of the key with the address, or the kind */
    lx_line_number trace_line;
    bool is_private;              /**< of one encoder, in whose section it stands */
    size_t encoder_count;         /**< on it so far */
    const struct dg_stack *stack; /**< that they speak; NULL: there are none */
};

/** An encoder. */
struct lx_plan_encoder {
    char *name;
    const struct dg_device *model;
    size_t shaft; /**< index */
    size_t wire;  /**< index */
    char *nvm;    /**< file, or NULL */
    char *serial; /**< or NULL */
    int address;  /**< node-ID (CANopen), address (RS485); or LX_PLAN_AS_DELIVERED */
    struct lx_plan_settings settings;
    lx_line_number line;     /**< of the section */
    lx_line_number nvm_line; /**< of the keys */
    lx_line_number serial_line;
    lx_line_number address_line;
};

/** A rig. All zero is an empty one. Strings are owned. */
struct lx_plan {
    const char *file; /**< for messages, borrowed; NULL: the command line */
    char *name;       /**< of the rig: the file's without its ending, or of the model */
    char *controls[LX_PLAN_CONTROLS_MAX]; /**< unix:PATH or tcp:HOST:PORT; none: the default */
    size_t control_count;
    char *files; /**< the folder for files that clients name; NULL: none */
    lx_line_number control_lines[LX_PLAN_CONTROLS_MAX]; /**< of the keys; 0: the command line */
    lx_line_number files_line;
    struct lx_plan_shaft *shafts;
    size_t shaft_count;
    struct lx_plan_wire *wires;
    size_t wire_count;
    struct lx_plan_encoder *encoders; /**< those of a wire in the order of their places on it */
    size_t encoder_count;
    struct lx_plan_names names; /**< of all of them */
};

/**
 * Read a rig file (INI). Everything that can be known without opening anything but the file is
 * checked: sections, keys, models, names, references, ratios, forms of motions and addresses.
 * Relative file names in it are relative to its folder. `file` must outlive the plan and `error`.
 * @return 0, or -1 with `error`: file, line, key, what is wrong, what would be right
 */
int lx_plan_read(struct lx_plan *self, const char *file, struct lx_error *error);

/** Give everything back; all zero afterwards. */
void lx_plan_free(struct lx_plan *self);

/** Append; all strings are copied. @return the index, or -1 without memory */
int lx_plan_add_shaft(struct lx_plan *self, const char *name, const char *motion);
int lx_plan_add_wire(struct lx_plan *self, const char *name, const struct lx_wire *kind,
                     const char *where);
int lx_plan_add_encoder(struct lx_plan *self, const char *name, const struct dg_device *model,
                        size_t shaft, size_t wire);
/** Index of the encoder called `name`, case aside, else of the first one where '-' and '_' are the
 * same; -1: there is none. */
int lx_plan_find_encoder(const struct lx_plan *self, const char *name);

/** Append a setting. @return 0, or -1 with `error` */
int lx_plan_add_setting(struct lx_plan_settings *self, const char *key, const char *value,
                        lx_line_number line, struct lx_error *error);
/** Append "KEY=VALUE". @return 0, or -1 with `error` */
int lx_plan_add_assignment(struct lx_plan_settings *self, const char *assignment,
                           lx_line_number line, struct lx_error *error);
/** Give the list back. */
void lx_plan_free_settings(struct lx_plan_settings *self);

/** Where the encoder's setting `key` stands, the section without one. */
lx_line_number lx_plan_setting_line(const struct lx_plan_encoder *encoder, const char *key);

/** `error` is about this setting. Always -1. */
int lx_plan_refuse_setting(const struct lx_plan *self, const struct lx_plan_setting *setting,
                           struct lx_error *error);

/** `error` is about the word `key` in `line`. Always -1. */
int lx_plan_refuse_key(const struct lx_plan *self, const char *key, lx_line_number line,
                       struct lx_error *error);

/** `error` is about the address of `wire`. Always -1. */
int lx_plan_refuse_wire(const struct lx_plan *self, const struct lx_plan_wire *wire,
                        struct lx_error *error);

#endif
