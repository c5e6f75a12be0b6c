/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The control plane: encoders and shafts as SCPI instruments, for whatever byte stream carries it.
 * An encoder is an instrument; a session selects one (the first one to begin with), and SHAFt acts
 * on the shaft that it sits on.
 *
 * The commands are rows (struct dg_scpi_command) that say their parameters and what they do. They
 * are listed in src/control/README.md, which is written from these rows, and by SYSTem:HELP? of
 * whatever is running.
 */
#ifndef DREHGEBER_CONTROL_H
#define DREHGEBER_CONTROL_H

#include "drehgeber/api.h"
#include "drehgeber/course.h"
#include "drehgeber/fault.h"
#include "drehgeber/instrument.h"
#include "drehgeber/scpi.h"
#include "drehgeber/shaft.h"
#include "drehgeber/tap.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_encoder;

/** A shaft with a name. */
struct dg_rig_shaft {
    const char *name;
    struct dg_shaft shaft;
    void *host; /**< the host's own */
};

/** An encoder's place among those of a rig that wait for the end of a fault or for a course; all
 * zero: it does not.
 * dg_rig_watch()'s and dg_rig_step()'s own. */
struct dg_rig_wait {
    dg_ns until;
    struct dg_encoder *child;  /**< a pairing heap: the first child, who waits no shorter, */
    struct dg_encoder *next;   /**< the next one of the same parent, */
    struct dg_encoder *before; /**< and the one before it, or the parent */
    bool waits;
};

/** A course that a quantity of an encoder's world follows, in memory of the host's; dg_rig_follow()
 * fills it. It and the points stay while dg_rig_course_of() has it. */
struct dg_rig_course {
    struct dg_course course;
    size_t quantity; /**< enum dg_quantity_id */
    dg_ns start;
    dg_ns due; /**< when it is looked at next */
    void (*step)(struct dg_rig_course *self, struct dg_encoder *encoder, dg_ns now);
    struct dg_rig_course *next; /**< of the same encoder */
};

/** An encoder as an instrument. The host fills it; names and pointers must outlive it. */
struct dg_encoder {
    const char *name; /**< unique in the rig: letters, digits, '_', '-'; not case sensitive */
    const struct dg_device *model;
    const struct dg_instrument *instrument; /**< of model->stack */
    void *device;                           /**< as model->stack makes it */
    struct dg_world *world;                 /**< its own; angle from `shaft` */
    struct dg_rig_shaft *shaft;
    struct dg_nvm nvm; /**< ops NULL: none */
    uint32_t serial;   /**< burnt in by `format`, where the model does not say */
    struct dg_faults faults;
    const void *port; /**< what commands of the instrument's own ask of the port, e.g. a struct
                           dg_biss_port_ops; NULL: it has nothing for them */
    void *port_ctx;   /**< handed to it */
    void *host;       /**< the host's own */
    struct dg_rig_wait wait;       /**< all zero to begin with */
    struct dg_rig_course *courses; /**< that its world follows; NULL to begin with */
};

struct dg_rig;

/** What WORLd:...:PROFile asks of the host: the file `path`, or points if that is NULL. */
struct dg_rig_course_wish {
    size_t quantity; /**< enum dg_quantity_id */
    const char *path;
    const struct dg_course_point *points; /**< in order, of values within the limits */
    size_t count;
    bool loop;
    bool steps;
};

/** Longest line of dg_rig_ops.last(), with its zero. */
#define DG_RIG_LINE_MAX 256u

/** What went over a wire, in words. */
struct dg_rig_line {
    enum dg_severity severity;
    char text[DG_RIG_LINE_MAX];
};

/** Of dg_rig_ops.profile(): not an error, and not through yet. */
#define DG_RIG_READS 1

/** What a rig needs of its host. Optional ones may be NULL: the commands answer -241. Each gives 0
 * or an enum dg_scpi_error; `detail` has room for DG_SCPI_DETAIL_MAX characters and a zero. */
struct dg_rig_ops {
    /** Something about `encoder` has changed (power, world, faults): look at deadlines anew. NULL
     * as encoder: a shaft did. Not optional. */
    void (*changed)(struct dg_rig *self, struct dg_encoder *encoder, dg_ns now);
    /** Address of the encoder's wire, as in the ready line, e.g. "can:vcan0/5". Not optional. */
    const char *(*wire)(struct dg_rig *self, const struct dg_encoder *encoder);
    /** STATe?: append what the port counts for this encoder (dg_scpi_put_*), as the instrument
     * does: wire_late (deadlines missed), wire_up (0, 1), and what is the wire's own. */
    void (*counters)(struct dg_rig *self, const struct dg_encoder *encoder, struct dg_scpi *to);
    /** SHAFt:PROFile: play what `text` says. @return DG_RIG_READS, too: it is being read, and
     * profile_more() goes on with it */
    int (*profile)(struct dg_rig *self, struct dg_rig_shaft *shaft, dg_ns now, const char *text,
                   char *detail);
    /** Text of the profile being played, or of the state: for SHAFt:PROFile?. */
    const char *(*profile_text)(struct dg_rig *self, const struct dg_rig_shaft *shaft);
    /** Record a shaft every `interval`; `path` NULL: stop. */
    int (*record)(struct dg_rig *self, struct dg_rig_shaft *shaft, dg_ns now, const char *path,
                  dg_ns interval, char *detail);
    /** Trace the encoder's wire; `path` NULL: stop. */
    int (*trace)(struct dg_rig *self, struct dg_encoder *encoder, const char *path, char *detail);
    /** Decoded frame `back` (0: newest) of the encoder's wire. @return false: there is none */
    bool (*last)(struct dg_rig *self, const struct dg_encoder *encoder, unsigned back,
                 struct dg_rig_line *line);
    /** The rig's clock runs at `permille` of real time from now on. */
    int (*set_scale)(struct dg_rig *self, uint32_t permille, char *detail);
    /** Its present rate in permille. */
    uint32_t (*scale)(struct dg_rig *self);
    /** Let `span` pass. @return as above */
    int (*step)(struct dg_rig *self, dg_ns span, char *detail);
    /** Before somebody reads what `encoder` and its wire have come to, or changes power, world or
     * faults of it: let it be what it is at `now`. May be asked again. NULL: it always is. */
    void (*look)(struct dg_rig *self, struct dg_encoder *encoder, dg_ns now);
    /** `shaft` is about to turn otherwise from `now` on, and with it those that it drives; then it
     * does. NULL: nobody minds before it does, and changed() hears of it then. */
    void (*turns)(struct dg_rig *self, struct dg_rig_shaft *shaft, dg_ns now);
    void (*turned)(struct dg_rig *self, struct dg_rig_shaft *shaft, dg_ns now);
    /** The index of the encoder called `name`, case aside, else of the first one where '-' and '_'
     * are the same; encoder_count: there is none. NULL: all are looked through. */
    size_t (*find)(struct dg_rig *self, const char *name);
    /** Read on, and play it at the end; `gone`: give it up. @return as profile(). NULL: profile()
     * is always through at once. */
    int (*profile_more)(struct dg_rig *self, struct dg_rig_shaft *shaft, dg_ns now, bool gone,
                        char *detail);
    /** WORLd:...:PROFile: let a quantity follow a course from `now` on, by dg_rig_follow(). All
     * that `wish` points to is gone behind the call. @return as profile(); course_more() goes on
     * with it
     */
    int (*course)(struct dg_rig *self, struct dg_encoder *encoder,
                  const struct dg_rig_course_wish *wish, dg_ns now, char *detail);
    /** As profile_more(): an encoder has one at a time. */
    int (*course_more)(struct dg_rig *self, struct dg_encoder *encoder, dg_ns now, bool gone,
                       char *detail);
    /** What `quantity`, which follows a course, follows: for WORLd:...:PROFile?. */
    const char *(*course_text)(struct dg_rig *self, const struct dg_encoder *encoder,
                               size_t quantity);
};

/** A rig: what all sessions work on. Caller-owned; arrays and names are borrowed. */
struct dg_rig {
    struct dg_encoder **encoders;
    size_t encoder_count; /**< at least 1 */
    struct dg_rig_shaft **shafts;
    size_t shaft_count;
    const struct dg_instrument *const *instruments; /**< whose own commands its sessions have */
    size_t instrument_count;
    const struct dg_scpi_commands *courses; /**< &dg_course_commands, or NULL: it has no courses */
    dg_ns origin;                           /**< TIME? counts from here: when the rig began */
    const struct dg_rig_ops *ops;
    void *host;               /**< the host's own */
    struct dg_encoder *waits; /**< the one whose wait ends first; NULL to begin with */
};

/** The commands that all rigs have; those of its instruments come behind them. */
DG_API extern const struct dg_scpi_commands dg_control_commands;

/** WORLd:...:PROFile, an object of its own: an image without courses has nothing of them. */
DG_API extern const struct dg_scpi_commands dg_course_commands;

/** A client of a rig. Not to be moved. */
struct dg_control {
    struct dg_scpi session;
    struct dg_rig *rig;
    void (*write)(void *ctx, const char *bytes, size_t n);
    void *ctx;    /**< of write */
    char idn[64]; /**< answer of *IDN?: the model, or "rig" for several encoders */
};

/** A new client. `write` as dg_scpi_ops.write. */
DG_API void dg_control_init(struct dg_control *self, struct dg_rig *rig,
                            void (*write)(void *ctx, const char *bytes, size_t n), void *ctx);

/** The client has sent something: as dg_scpi_rx(). */
DG_API size_t dg_control_rx(struct dg_control *self, dg_ns now, const char *bytes, size_t n);
/** Time has passed: as dg_scpi_step(). */
DG_API dg_ns dg_control_step(struct dg_control *self, dg_ns now);

/** Faults of `encoder` were set with a duration, other than by a command: dg_rig_step() looks after
 * that. */
DG_API void dg_rig_watch(struct dg_rig *self, struct dg_encoder *encoder);

/** Let a quantity follow `course` from `now` on in place of what it followed before; the host says
 * changed(). A fault that bends it goes before; what the course has come to is there behind it.
 * @return 0; DG_ERR_ARGUMENT: the course cannot be, see dg_course_check(); nothing has happened */
DG_API int dg_rig_follow(struct dg_rig *self, struct dg_encoder *encoder,
                         struct dg_rig_course *course, dg_ns now);

/** The quantity stays what it is. */
DG_API void dg_rig_unfollow(struct dg_rig *self, struct dg_encoder *encoder, size_t quantity);

/** What the quantity follows; NULL: nothing. A course that does not loop is over at its last point.
 */
DG_API struct dg_rig_course *dg_rig_course_of(const struct dg_encoder *encoder, size_t quantity);

/** End faults whose time is over, and go on with courses, of all encoders. @return when to call
 * again; DG_NEVER */
DG_API dg_ns dg_rig_step(struct dg_rig *self, dg_ns now);

/** What faults of this encoder work on. */
DG_API struct dg_fault_target dg_encoder_target(const struct dg_encoder *self);

/** POWer: off, then on when `on`; deadlines are the host's (ops->changed). @return 0 or dg_result
 */
DG_API int dg_encoder_power(struct dg_encoder *self, dg_ns now, bool on);

/** Whether it is on. */
DG_API bool dg_encoder_powered(const struct dg_encoder *self);

/**
 * The port of the encoder that a session works on, if that is one of `stack` on a wire that the
 * host clocks; else NULL, and the reason is raised: `foreign` behind its name, or `missing`. In
 * line, as an image has one protocol that asks.
 */
static inline const void *dg_control_port(struct dg_scpi *self, const struct dg_stack *stack,
                                          const char *foreign, const char *missing)
{
    const struct dg_encoder *encoder = dg_control_selected(self);
    if (encoder->model->stack != stack) {
        dg_control_refuse(self, DG_SCPI_MISSING_HARDWARE, foreign);
        return NULL;
    }
    if (encoder->port == NULL) {
        dg_scpi_raise(self, DG_SCPI_MISSING_HARDWARE, missing);
    }
    return encoder->port;
}

/** The delivery state into its EEPROM. @return 0 or an enum dg_result */
DG_API int dg_encoder_format(const struct dg_encoder *self);

#ifdef __cplusplus
}
#endif

#endif
