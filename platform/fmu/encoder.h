/* SPDX-License-Identifier: MIT */
/* One encoder of an FMU: for the sources of this folder only. */
#ifndef DREHGEBER_FMU_ENCODER_H
#define DREHGEBER_FMU_ENCODER_H

#include "drehgeber/host_wire.h"
#include "fmu.h"

/** What an encoder has, a bit each: the medium of its wire, and what only some of a medium can do.
 */
enum {
    FMU_HAS_CHARACTERS = 1 << DG_HOST_MEDIUM_CHARACTERS,
    FMU_HAS_FRAMES = 1 << DG_HOST_MEDIUM_FRAMES,
    FMU_HAS_EDGES = 1 << DG_HOST_MEDIUM_EDGES,
    FMU_HAS_WORDS = 1 << DG_HOST_MEDIUM_WORDS,
    FMU_HAS_SINCOS = 1 << 4, /**< dg_host_sincos() */
    FMU_HAS_MASTER = 1 << 5, /**< dg_host_frame() */
};

/** "There is none." */
#define FMU_NOBODY SIZE_MAX

/** What has become of one: plain data, as it is saved. What is of a wire counts for its first one.
 */
struct fmu_course {
    uint64_t busy;              /* the end of the last frame: nothing begins before */
    struct dg_host_frame frame; /* last one */
    uint64_t faults[2];         /* that are set, a bit each */
    uint32_t error;             /* code of the last EMCY and its register */
    uint32_t waiting;           /* bytes in `out` */
    uint32_t coming;            /* bytes in `in` */
    uint16_t transmit, receive; /* error counters of CAN */
    uint8_t bus;                /* enum dg_host_bus: active, passive or off */
    uint8_t status;             /* the same, as the wire was told */
    bool power;
    bool rx, ma;     /* clocks that tick */
    bool taken;      /* the importer has seen `out` */
    bool configured; /* the bus has heard of its bit rate */
};

/** How a shaft is turned: likewise. */
struct fmu_turn {
    double angle, speed;
    bool angle_new, speed_new;
};

/** A shaft that an importer may turn. */
struct fmu_shaft {
    char prefix[FMU_NAME_MAX]; /* of its inputs: "shaft.", "NAME.shaft.", "NAME." */
    size_t first;              /* encoder that it is described with; FMU_NOBODY: none */
    bool input;                /* no: it has a motion or a driver */
    struct fmu_turn now;
};

/** One of them. */
struct fmu_encoder {
    struct fmu *all;
    char prefix[FMU_NAME_MAX];
    char wire[FMU_NAME_MAX];        /* what names of its wire begin with */
    char model[40];                 /* its name, or that of its file */
    const struct dg_device *device; /* in `made`; NULL: the name says it */
    void *made;                     /* owned; NULL: it is built in */
    size_t shaft;                   /* whose inputs turn it */
    bool leads;                     /* the first one on its wire, which it has the variables of */
    bool shares;                    /* ... with others */
    unsigned has;                   /* FMU_HAS_... */
    void *memory;                   /* owned; NULL: it is a rig's */
    struct dg_host *host;
    void *panel_memory; /* owned */
    struct dg_host_panel *panel;
    bool unread; /* the frame of this moment, which nobody has asked for yet, is latched then */
    struct fmu_course now;
    uint8_t *out; /* owned: what waits for the importer; NULL: another one has it */
    uint8_t *in;  /* owned: what it has sent that begins later; NULL */
    size_t room;  /* of either */
};

/** What encoders run on: a handle by itself, or a rig. Results are 0 or those of host.h; moments
 * without a parameter are now. */
struct fmu_ops {
    /** Encoders as they were made, with their settings. @return 0 or -1 */
    int (*make)(struct fmu *self);
    void (*free)(struct fmu *self);
    /** All get their power at 0, and those that are off lose it at once. */
    int (*start)(struct fmu *self);
    /** A shaft is at `angle` (2^-32 turns; NULL: where it is) from `at` on, and turns on. */
    void (*turn)(struct fmu *self, size_t shaft, uint64_t at, const int64_t *angle, double rad_s);
    int (*power)(struct fmu_encoder *encoder, bool on);
    int (*sense)(struct fmu_encoder *encoder, const char *quantity, int64_t value);
    /** Entry `index` of the catalogue; DG_HOST_ERR_NAME behind the last one. */
    int (*entry)(struct fmu_encoder *encoder, size_t index, struct dg_host_fault *to);
    int (*fault)(struct fmu_encoder *encoder, size_t index, bool on);
    /** A frame of a clocked wire that is latched now. */
    int (*frame)(struct fmu_encoder *encoder, struct dg_host_frame *to);
    /** A frame of CAN, or what its controller is, goes to all on the wire. */
    int (*send)(struct fmu_encoder *encoder, const struct dg_host_event *event);
    /** Characters do: `n` from `at` on, behind a head of FMU_SERIAL_SIZE bytes. */
    int (*say)(struct fmu_encoder *encoder, uint64_t at, const uint8_t *head, size_t n);
    /** In bit/s; 0 or less: nobody knows. */
    int64_t (*bit_rate)(const struct fmu_encoder *encoder);
    /** Time goes on to `to`; what was sent waits for the importer. */
    void (*run)(struct fmu *self, uint64_t to);
    /** When something happens next. */
    uint64_t (*next)(const struct fmu *self);
    size_t (*state_size)(const struct fmu *self);
    int (*save)(struct fmu *self, uint8_t *to);
    /** Of `n` bytes; courses are those of the state by now. */
    int (*restore)(struct fmu *self, const uint8_t *from, size_t n);
};
extern const struct fmu_ops fmu_alone_ops, fmu_rig_ops;

/** Bytes in front of characters: the first start bit, in ns from the start on (8; to the encoder
 * also 0: now), ns that a character takes (4), how many (2), flags (2). */
#define FMU_SERIAL_SIZE 16u

struct fmu_rig; /* fmu_rig.c */

/** All of them. */
struct fmu {
    char *token; /* owned */
    const struct fmu_ops *ops;
    size_t count;
    struct fmu_encoder *encoders; /* owned */
    size_t shaft_count;
    struct fmu_shaft *shafts; /* owned */
    struct fmu_rig *rig;      /* owned; NULL: there is one encoder, by itself */
    double start;             /* s: time 0 of the encoders */
    uint64_t now;             /* ns from there */
    bool started, events;
};

/* fmu.c */

/* Let them be as their inputs say at this moment. */
void fmu_settle(struct fmu *self);
/* Frames whose MA ticks. */
void fmu_latch(struct fmu *self);
/* Frames of the end of the latest step: before somebody looks at one, or changes what is in it. */
void fmu_latch_unread(struct fmu *self);
/* Of a variable of this group; NULL: there is none. */
struct fmu_encoder *fmu_encoder_of(const struct fmu *self, uint32_t reference,
                                   enum fmu_group group);
/* The shaft of an input; NULL: there is none. */
struct fmu_shaft *fmu_shaft_of(const struct fmu *self, uint32_t reference);
/* To the nearest one, of what fmu_is_small(). */
int64_t fmu_nearest(double value);
/* 2^-32 turns; as angles do, what lies beyond 64 bits wraps. */
int64_t fmu_turns(double rad);
/* Below the limit, and a number. */
bool fmu_is_small(double value, double limit);

/* fmu_model.c: "MODEL...", see fmu.h; one that was made before stays. @return what stands behind,
   or NULL */
const char *encoder_take_model(struct fmu_encoder *self, const char *at,
                               const struct fmu_files *files);
/* The bytes of a file that is called by its check sum, to be freed; NULL: it is not there. */
char *fmu_read_file(const struct fmu_files *files, const char *name, size_t *n);
/* fmu_rig.c: a rig of the file `name`, with as many encoders and shafts as it has. @return whether
   it can be read */
bool fmu_rig_read(struct fmu *self, const char *name, const struct fmu_files *files);
/* fmu_token.c */
/* Room for what waits on its wire, of `count` encoders. @return whether there is any */
bool encoder_make_room(struct fmu_encoder *self, size_t count, bool comes);
/* What stands before one of `ends`, without %XX. @return its end, or NULL: too long, or %XY */
const char *encoder_word(const char *from, const char *ends, char *to, size_t size);
/* Where in memory with DG_HOST_ALIGN more bytes a handle may be. */
void *encoder_aligned(void *memory);
/* FMU_HAS_... of a handle that was never on; 0: an FMU cannot have it. */
unsigned encoder_has(struct dg_host *host);
/* fmu_values.c. @return 0 or a result of host.h */
int encoder_begin_fault(struct fmu_encoder *encoder, uint32_t index);
int encoder_set_fault(struct fmu_encoder *encoder, uint32_t index, bool on);

/* fmu_wires.c */

/* What the encoder has sent, to `out` as the wire tells it to an importer. */
void wire_collect(struct fmu_encoder *self);
/* Something that `from` has sent waits on the wire of `self`. */
void wire_put(struct fmu_encoder *self, struct fmu_encoder *from,
              const struct dg_host_event *event);
/* A character that follows those that wait. @return whether it does, and is with them */
bool wire_join(struct fmu_encoder *self, const struct dg_host_event *event);
/* What an importer sends. @return 0 or a result of host.h */
int wire_take(struct fmu_encoder *self, uint64_t now, const uint8_t *bytes, size_t n);
/* Power has come: a controller has counted nothing yet. @return 0 or a result of host.h */
int wire_reset(struct fmu_encoder *self, uint64_t now);
/* The first words of a node to its bus. */
void wire_configure(struct fmu_encoder *self);
/* What the controller of this encoder has come to, and that of its wire. */
void wire_follow(struct fmu_encoder *self);
/* Characters by the head in front of them. */
uint64_t wire_moment(const uint8_t *head);
uint32_t wire_each(const uint8_t *head);
size_t wire_count(const uint8_t *head);

/* variables.c: the type of a setting or a quantity of the world. */
enum fmu_type fmu_key_type(const struct dg_host *host, const struct dg_host_key *key);

#endif
