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

/** What has become of one: plain data, as it is saved. */
struct fmu_course {
    double angle, speed;
    uint64_t busy;              /* the end of the last frame: nothing begins before */
    struct dg_host_frame frame; /* last one */
    uint64_t faults[2];         /* that are set, a bit each */
    uint32_t error;             /* code of the last EMCY and its register */
    uint16_t transmit, receive; /* error counters of CAN */
    uint16_t waiting;           /* bytes in `out` */
    uint8_t bus;                /* enum dg_host_bus: active, passive or off */
    bool angle_new, speed_new, power;
    bool rx, ma;     /* clocks that tick */
    bool taken;      /* the importer has seen `out` */
    bool configured; /* the bus has heard of its bit rate */
    uint8_t out[FMU_WIRE_MAX];
};

/** One of them. */
struct fmu_encoder {
    char prefix[FMU_NAME_MAX];
    char model[40];                 /* its name, or that of its file */
    const struct dg_device *device; /* in `made`; NULL: the name says it */
    void *made;                     /* owned; NULL: it is built in */
    int owner;                      /* of its shaft; -1: itself */
    unsigned has;                   /* FMU_HAS_... */
    void *memory;                   /* owned */
    struct dg_host *host;
    void *panel_memory; /* owned */
    struct dg_host_panel *panel;
    bool unread; /* the frame of this moment, which nobody has asked for yet, is latched then */
    struct fmu_course now;
};

/** All of them. */
struct fmu {
    char *token; /* owned */
    size_t count;
    struct fmu_encoder *encoders; /* owned */
    double start;                 /* s: time 0 of the encoders */
    uint64_t now;                 /* ns from there */
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
/* Its panel, which is made the first time; NULL: it was never on, or no memory. */
struct dg_host_panel *encoder_panel(struct fmu *self, struct fmu_encoder *encoder);
/* To the nearest one, of what fmu_is_small(). */
int64_t fmu_nearest(double value);
/* Below the limit, and a number. */
bool fmu_is_small(double value, double limit);

/* fmu_model.c: "MODEL...", see fmu.h; one that was made before stays. @return what stands behind,
   or NULL */
const char *encoder_take_model(struct fmu_encoder *self, const char *at,
                               const struct fmu_files *files);
/* fmu_token.c */
/* What stands before one of `ends`, without %XX. @return its end, or NULL: too long, or %XY */
const char *encoder_word(const char *from, const char *ends, char *to, size_t size);
/* Where in memory with DG_HOST_ALIGN more bytes a handle may be. */
void *encoder_aligned(void *memory);
/* FMU_HAS_... of a handle that was never on; 0: an FMU cannot have it. */
unsigned encoder_has(struct dg_host *host);
/* fmu_values.c. @return 0 or a result of host.h */
int encoder_begin_fault(struct fmu *self, struct fmu_encoder *encoder, uint32_t index);
int encoder_set_fault(struct fmu *self, struct fmu_encoder *encoder, uint32_t index, bool on);

/* fmu_wires.c */

/* What the encoder has sent, to `out` as the wire tells it to an importer. */
void wire_collect(struct fmu_encoder *self);
/* What an importer sends. @return 0 or a result of host.h */
int wire_take(struct fmu_encoder *self, uint64_t now, const uint8_t *bytes, size_t n);
/* Power has come: a controller has counted nothing yet. @return 0 or a result of host.h */
int wire_reset(struct fmu_encoder *self, uint64_t now);
/* The first words of a node to its bus. */
void wire_configure(struct fmu_encoder *self);

/* variables.c: the type of a setting or a quantity of the world. */
enum fmu_type fmu_key_type(const struct dg_host *host, const struct dg_host_key *key);

#endif
