/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A rig as a text says it: shafts, wires and encoders on them. The reader takes the text of a rig
 * file and makes a plan of it, in memory of the host: it opens nothing, and whatever can be known
 * without opening anything is checked.
 *
 *   struct dg_plan_setup setup = {sizeof setup, "bench.ini", text, n, memory, size, ...};
 *   struct dg_plan plan;
 *   dg_plan_read(&plan, &setup, &error) == DG_ERR_SPACE: again, with more memory
 *
 * Sections, keys and words: docs/rigs.md. What a file means is the same on every host, so the kinds
 * of wires are here as well: dg_plan_wires. Which of them a host can make is its own to say.
 */
#ifndef DREHGEBER_RIG_H
#define DREHGEBER_RIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/devices.h"
#include "drehgeber/key.h"
#include "drehgeber/motion.h"
#include "drehgeber/text.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Longest name of a rig, shaft, bus or encoder. */
#define DG_PLAN_NAME_MAX 32u
/** Longest line, without its end. */
#define DG_PLAN_LINE_MAX 198u
/** Control addresses of a rig. */
#define DG_PLAN_CONTROLS_MAX 4u
/** Threads a rig may have. */
#define DG_PLAN_THREADS_MAX 64u
/** Models that a model stands on, with the built-in one. */
#define DG_PLAN_BASES_MAX 4u
/** Files that include each other, with the first one. */
#define DG_PLAN_DEPTH_MAX 8u
/** Bytes of all included files together. */
#define DG_PLAN_INCLUDED_MAX 1048576u
/** Bytes of all files that are models together. */
#define DG_PLAN_MODEL_FILES_MAX 8388608u

/* ---------------------------------------------------------------- what was read */

/** Where a word stands: lines count through a file and all that it includes, in the order in which
 * they are read; dg_plan_place() knows the file. 0: on the command line. */
typedef unsigned dg_plan_line;

/** A setting, or a word of a section. */
struct dg_plan_setting {
    const char *key;
    const char *value;
    dg_plan_line line;
};

/** Settings of one thing. */
struct dg_plan_settings {
    struct dg_plan_setting *list;
    size_t count;
};

/** A model that is a text: figures of a copy of another model. */
struct dg_plan_model {
    const struct dg_device *device; /**< as everywhere; its name is the section's */
    const struct dg_device *base;   /**< built-in, or a model above */
    const char *source;             /**< what was read, in the words of the file; NULL: not said */
    const char *unmodelled;         /**< what it is not like, likewise */
    unsigned depth;                 /**< models below it, with the built-in one */
    dg_plan_line line;              /**< of the section */
};

/** A file that is a model, such as an EDS file. */
struct dg_plan_model_file {
    const char *file;               /**< from where the first file is */
    const struct dg_device *device; /**< as everywhere; its name is not the file's */
    unsigned lacks;                 /**< what it promises and the encoder does not do */
    uint8_t address;                /**< of encoders without one; 0: as of all of the protocol */
    dg_plan_line line;              /**< of the first word that names it */
};

/** An address that nobody has given. */
#define DG_PLAN_AS_DELIVERED (-1)

/** A shaft. */
struct dg_plan_shaft {
    const char *name;
    const char *motion; /**< in words, see dg_motion_read(); NULL: at rest at 0, or geared */
    int driver;         /**< index of the shaft that drives it, declared before; -1: none */
    int32_t ratio[2];   /**< turns of this shaft, for as many of the driver */
    dg_plan_line line;
    dg_plan_line motion_line; /**< of the key */
};

/** A kind of wire. */
struct dg_plan_wire_kind {
    const char *name;    /**< as in wire = NAME */
    size_t stations_max; /**< encoders that fit on one; all of one stack, unless it is mixed */
    const char *where;   /**< what its address looks like, for messages, e.g. "CHIP:CLOCK,DATA";
                              NULL: it has none */
    const char *usual;   /**< address when none is given; NULL: the bus finds one */
    const struct dg_keys *keys; /**< settings of the wire itself; NULL: none */
    const void *settings;       /**< what they set, as nobody has set it; NULL: none */
    unsigned media;             /**< it can carry: DG_PLAN_CARRIES() */
    bool mixed;                 /**< encoders of several stacks may be on one */
    bool where_needed;
    bool where_is_path;    /**< a file name: in a rig file relative to its folder */
    bool where_may_be_tcp; /**< ... or tcp:HOST:PORT */
};

/** All kinds. A host that cannot make one says so when it makes the rig. */
DG_API extern const struct dg_plan_wire_kind dg_plan_wires[];
DG_API extern const size_t dg_plan_wire_count;

/** In dg_plan_wire_kind.media: it carries what travels as DG_MEDIUM_`medium`. */
#define DG_PLAN_CARRIES(medium) (1u << DG_MEDIUM_##medium)
#define DG_PLAN_CARRIES_ALL ((1u << DG_MEDIUM_COUNT) - 1u)

/** A wire: a bus, or the private line of one encoder. */
struct dg_plan_wire {
    const char *name; /**< of the [bus NAME] section, or of the encoder it belongs to */
    const struct dg_plan_wire_kind *kind;
    const char *where;                /**< LINK, DEV, IFNAME, HOST:PORT, CHIP:CLOCK,DATA; or NULL */
    const char *trace;                /**< file, or NULL */
    struct dg_plan_settings settings; /**< of the wire itself, e.g. cycle of a ring */
    dg_plan_line line;                /**< of the section */
    dg_plan_line where_line;          /**< of the key with the address, or the kind */
    dg_plan_line trace_line;
    bool is_private;              /**< of one encoder, in whose section it stands */
    size_t encoder_count;         /**< on it so far */
    const struct dg_stack *stack; /**< that they speak; NULL: there are none */
};

/** An encoder. Encoders of one section share the list of their settings. */
struct dg_plan_encoder {
    const char *name;
    const struct dg_device *model;
    size_t shaft;       /**< index */
    size_t wire;        /**< index */
    const char *nvm;    /**< file, or NULL */
    const char *serial; /**< or NULL */
    int address;        /**< in the stack's own sense (node-ID, RS485 address), or
                             DG_PLAN_AS_DELIVERED */
    struct dg_plan_settings settings;
    dg_plan_line line;     /**< of the section */
    dg_plan_line nvm_line; /**< of the keys */
    dg_plan_line serial_line;
    dg_plan_line address_line;
};

/** Where clients control the rig. */
struct dg_plan_control {
    const char *where;      /**< unix:PATH or tcp:HOST:PORT */
    const char *token_file; /**< NULL: no token is asked for */
    bool tcp;
    bool open;         /**< tcp: beyond loopback, too */
    dg_plan_line line; /**< of the key; 0: the command line */
};

/** What a point of a course counts in [rig] memory. */
#define DG_PLAN_POINT_BYTES 16u
/** Most that [rig] memory may say. */
#define DG_PLAN_COURSE_MEMORY_MAX ((uint64_t)1 << 40)

/* Of the reader only. */
struct dg_plan_source;
struct dg_plan_piece;
struct dg_plan_name;

/** A rig. All zero is an empty one without memory. All that it points to lies in its memory, but
 * for `file`, kinds of wires and built-in models. */
struct dg_plan {
    const char *file;  /**< for messages, borrowed; NULL: the command line */
    const char *name;  /**< of the rig: the file's without its ending, or of the model */
    const char *files; /**< the folder for files that clients name; NULL: none */
    dg_plan_line files_line;
    uint32_t threads;       /**< that may step the buses of a rig; 0: nothing is said of it */
    uint64_t course_memory; /**< for the points of courses that clients ask for, each of which
                               counts DG_PLAN_POINT_BYTES; 0: no bound */
    struct dg_plan_control controls[DG_PLAN_CONTROLS_MAX]; /**< none: the host's default */
    size_t control_count;
    struct dg_plan_shaft *shafts;
    size_t shaft_count;
    struct dg_plan_wire *wires;
    size_t wire_count;
    struct dg_plan_encoder *encoders; /**< those of a wire in the order of their places on it */
    size_t encoder_count;
    struct dg_plan_model *models; /**< that the file brings, whether encoders have them or not */
    size_t model_count;
    struct dg_plan_model_file *model_files; /**< each once */
    size_t model_file_count;
    void *memory; /**< what the host has lent; NULL: none */
    /* Of the reader only. */
    struct dg_plan_name *names; /* a hash table of what stands once */
    size_t name_room;
    size_t name_count;
    struct dg_plan_source *sources; /* files that were included */
    size_t source_count;
    struct dg_plan_piece *pieces; /* lines in a row of one file; none: all are of `file` */
    size_t piece_count;
    unsigned char *at;                                                  /* free memory */
    unsigned char *end;                                                 /* behind it */
    bool out;                                                           /* there was not enough */
    const struct dg_device *(*find_model)(void *ctx, const char *name); /* as in dg_plan_setup */
    void *ctx;
};

/* ---------------------------------------------------------------- errors */

/** Whether a word's value is told, and how it stands in a text. */
enum dg_plan_valued {
    DG_PLAN_UNVALUED,  /**< it is not told */
    DG_PLAN_KEY_VALUE, /**< KEY VALUE */
    DG_PLAN_SETTING,   /**< KEY=VALUE, of an encoder or a wire */
};

/** What is wrong, where it stands, what would be right; each of them one printable line. */
struct dg_plan_error {
    const char *file;   /**< borrowed from the setup; NULL: unknown, likewise */
    unsigned line;      /**< 0: unknown */
    char included[256]; /**< which files led to the one with this line, and that one: "bench.ini:2:
                             shafts.ini"; "": it is `file` */
    char key[64];       /**< word or section; "": `what` says it */
    char value[256];    /**< as it was given */
    uint8_t valued;     /**< enum dg_plan_valued: whether it is to be told */
    char what[400];     /**< what was wrong; "": that is clear from what would be right */
    char right[512];    /**< what would be right; "": `what` says it */
};

/* ---------------------------------------------------------------- reading */

/** The text of a file. */
struct dg_plan_text {
    const char *text; /**< any bytes, no zero behind them is needed */
    size_t n;
};

/** What a plan is read from. */
struct dg_plan_setup {
    size_t size;      /**< sizeof(struct dg_plan_setup) */
    const char *file; /**< its name, for messages, for the rig's name, and whose folder relative
                           names are relative to */
    struct dg_plan_text text;
    void *memory; /**< for the plan, as long as it is used; aligned for any type */
    size_t memory_size;
    /** The text of a file that is included, or is a model, valid until dg_plan_read() returns.
     * `path` leads there from where `file` does, and not out of its folder by its words; links are
     * the host's to look at. NULL: there are no files. @return NULL, or what is wrong with it, in
     * words */
    const char *(*include)(void *ctx, const char *path, struct dg_plan_text *to);
    void *ctx;
    /** A model that is neither built in nor a section above, for as long as the plan is used; NULL:
     * none is called so. NULL: there are no others. */
    const struct dg_device *(*find_model)(void *ctx, const char *name);
};

/**
 * Read a rig file (INI): sections, keys, models, names, references, ratios, forms of motions and
 * addresses. A file of nothing but models is one, too: its plan has no encoders.
 * @return 0; DG_ERR_SPACE: more memory is needed, `error` says nothing then; DG_ERR_ARGUMENT with
 * `error`, or not a setup of this version. Whatever failed: the plan is empty.
 */
DG_API int dg_plan_read(struct dg_plan *self, const struct dg_plan_setup *setup,
                        struct dg_plan_error *error);

/** Where a line stands. */
struct dg_plan_place {
    const char *file; /**< NULL: the command line */
    unsigned line;    /**< of it */
    size_t folder;    /**< characters of `file` that are its folder, with '/' */
};

/** Where a line stands. */
DG_API struct dg_plan_place dg_plan_place(const struct dg_plan *self, dg_plan_line line);

/** Append the files that led to the one of this line, and that one: "bench.ini:2: shafts.ini". */
DG_API void dg_plan_say_files(const struct dg_plan *self, dg_plan_line line, struct dg_text *to);

/** Whether `name` can be one: 1 to DG_PLAN_NAME_MAX letters, digits, '_', '-'. */
DG_API bool dg_plan_name_fits(const char *name);

/** Index of the encoder called `name`, case aside, else of the first one where '-' and '_' are the
 * same; -1: there is none. */
DG_API int dg_plan_find_encoder(const struct dg_plan *self, const char *name);
/** Index of the shaft called so, not case sensitive; -1: there is none so far. */
DG_API int dg_plan_find_shaft(const struct dg_plan *self, const char *name);
/** Index of the wire called so, likewise. */
DG_API int dg_plan_find_wire(const struct dg_plan *self, const char *name);
/** The model called so, of the plan or built-in; NULL: there is none so far. */
DG_API const struct dg_device *dg_plan_find_model(const struct dg_plan *self, const char *name);

/** Where the encoder's setting `key` stands, the section without one. */
DG_API dg_plan_line dg_plan_setting_line(const struct dg_plan_encoder *encoder, const char *key);

/* ---------------------------------------------------------------- without a text */

/** An empty plan in `memory`, aligned for any type: for a command line, which adds what it says. */
DG_API void dg_plan_begin(struct dg_plan *self, void *memory, size_t size);

/** Append a shaft; `motion` may be NULL. Strings are copied, likewise below. @return the index, or
 * -1: the memory is full */
DG_API int dg_plan_add_shaft(struct dg_plan *self, const char *name, const char *motion);
/** Append a wire; `where` may be NULL. @return as above */
DG_API int dg_plan_add_wire(struct dg_plan *self, const char *name,
                            const struct dg_plan_wire_kind *kind, const char *where);
/** Append an encoder on that shaft and that wire, which are there. @return as above */
DG_API int dg_plan_add_encoder(struct dg_plan *self, const char *name,
                               const struct dg_device *model, size_t shaft, size_t wire);

/** A copy of a text, of up to 65535 characters. @return NULL: the memory is full */
DG_API const char *dg_plan_copy(struct dg_plan *self, const char *text);
/** Zeroed room for `count` settings in the memory of the plan. @return false: it is full */
DG_API bool dg_plan_make_settings(struct dg_plan *self, struct dg_plan_settings *to, size_t count);

/* ---------------------------------------------------------------- kinds of wires, addresses */

/** The kind called `name` (n characters), or NULL. */
DG_API const struct dg_plan_wire_kind *dg_plan_find_kind(const char *name, size_t n);
/** Whether `key` is a setting of the wire itself, not of the encoders on it. */
DG_API bool dg_plan_wire_has(const struct dg_plan_wire_kind *kind, const char *key);
/** Whether an address of this kind is a path. */
DG_API bool dg_plan_is_path(const struct dg_plan_wire_kind *kind, const char *where);
/** Whether encoders of `stack` can be on it. */
DG_API bool dg_plan_carries(const struct dg_plan_wire_kind *kind, const struct dg_stack *stack);

/** The row of a model's addresses; NULL: they have no key. */
DG_API const struct dg_key *dg_plan_address_row(const struct dg_device *model);
/** Append "a node-ID in 1..127", of a model with such a row. */
DG_API void dg_plan_say_addresses(const struct dg_device *model, struct dg_text *to);

/* ---------------------------------------------------------------- settings of wires */

/** Clock of a master on a simulated wire: as usual, and the slowest and fastest one. At slower ones
 * encoders take half a period for the end of a frame. */
#define DG_PLAN_CLOCK_HZ 1000000u
#define DG_PLAN_CLOCK_MIN_HZ 50000u
#define DG_PLAN_CLOCK_MAX_HZ 10000000u

/** Settings of a simulated wire where a master clocks. (Wires that carry frames have a bool:
 * whether each frame takes its time.) */
struct dg_plan_timing {
    uint32_t clock_hz;      /**< DG_PLAN_CLOCK_MIN_HZ..DG_PLAN_CLOCK_MAX_HZ */
    uint32_t line_delay_ns; /**< of the cable, each way; 0..DG_BUS_CABLE_MAX_NS */
    bool compensate;        /**< the master takes its samples later by the way there and back */
};

/** Settings of a ring behind a coupler. */
struct dg_plan_ring {
    uint32_t cycle_us; /**< from one data cycle to the next; 250..50000 */
    bool tear;         /**< half of an OUT word is taken (fault) */
    uint16_t break_at; /**< index of the encoder whose incoming bus is cut (fault), or
                            DG_RING_WHOLE */
};

/** Whose time a simulation has. */
enum dg_plan_time {
    DG_PLAN_COORDINATED, /**< virtual; begins and ends with all others */
    DG_PLAN_AUTONOMOUS,  /**< virtual; begins when it can */
    DG_PLAN_REAL,        /**< each one's own */
    DG_PLAN_TIME_COUNT
};

/** How frames of a bus travel in a simulation. */
enum dg_plan_frames {
    DG_PLAN_FRAMES_CAN,    /**< each by itself, on its CAN network */
    DG_PLAN_FRAMES_PACKED, /**< those of a step in one message of a topic */
    DG_PLAN_FRAMES_COUNT
};

/** Settings of a wire in a simulation. */
struct dg_plan_simulation {
    uint8_t time;     /**< enum dg_plan_time */
    uint32_t step_us; /**< of virtual time; 1..1000000 */
    bool aggregate;   /**< what is sent in a step goes out together, at its end */
    uint8_t frames;   /**< enum dg_plan_frames; each wire's own */
};

/** As nobody has set them: at once; 1 MHz and no delay; 1 ms and no faults; coordinated, steps of
 * 1 ms, messages together. */
DG_API extern const bool dg_plan_pace_usual;
DG_API extern const struct dg_plan_timing dg_plan_timing_usual;
DG_API extern const struct dg_plan_ring dg_plan_ring_usual;
DG_API extern const struct dg_plan_simulation dg_plan_simulation_usual;

/* ---------------------------------------------------------------- words */

/** The forms that a motion has, in one line, for help and errors. */
DG_API extern const char dg_motion_forms[];

/** Whether `text` is the name of a file with a motion: FILE.csv. */
DG_API bool dg_motion_is_file(const char *text);

/**
 * A motion in words:
 *
 *   0 | 90DEG | 2.5REV | 60RPM | sine:AMPLITUDE,PERIOD | ramp:SPEED,TIME[,HOLD]
 *
 * Units are not case sensitive: DEG REV (angle), RPM (speed), S MS (time). Angles are rounded up to
 * 2^-32 turn, so that an angle written down for a step is in that step.
 * @param to starts at 0; the host moves `start`
 * @return 0, or DG_ERR_ARGUMENT with `error`, about the key "motion"
 */
DG_API int dg_motion_read(struct dg_motion *to, const char *text, struct dg_plan_error *error);

/** The form of a course, for help and errors. */
#define DG_COURSE_FORM "FILE.csv[,ONCE|LOOP][,LINEAR|STEP]"

/** What the words of a course say. */
struct dg_course_words {
    size_t name; /**< characters of the file's name, at the beginning */
    bool loop;
    bool steps;
};

/** Whether `text` is meant for a course: it begins with the name of a CSV file. */
DG_API bool dg_course_is(const char *text);

/** A course of a quantity of the world in words, DG_COURSE_FORM; they are not case sensitive.
 * @return 0, or DG_ERR_ARGUMENT with `error` */
DG_API int dg_course_read(const char *text, struct dg_course_words *to,
                          struct dg_plan_error *error);

/** A control address in words, ADDRESS[,open][,token=FILE], taken apart. */
struct dg_access_words {
    size_t where;      /**< characters of the address, unix:PATH or tcp:HOST:PORT, at the beginning
                        */
    const char *token; /**< the rest of the text; NULL: no token */
    bool tcp;
    bool open; /**< tcp: beyond loopback, too */
};

/** Take a control address apart. @return 0, or DG_ERR_ARGUMENT with `error` */
DG_API int dg_access_read(const char *text, struct dg_access_words *to,
                          struct dg_plan_error *error);

#ifdef __cplusplus
}
#endif

#endif
