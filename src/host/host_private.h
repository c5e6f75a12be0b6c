/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A handle from inside. Behind it, in the same memory: queues, settings, device, EEPROM, each at a
 * multiple of DG_HOST_ALIGN.
 */
#ifndef DREHGEBER_HOST_PRIVATE_H
#define DREHGEBER_HOST_PRIVATE_H

#include "drehgeber/devices.h"
#include "drehgeber/host.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/world.h"

/** Events in their order. */
struct host_queue {
    uint32_t first; /**< place of the oldest one */
    uint32_t count;
    struct dg_host_event event[DG_HOST_QUEUE];
};

/** Of a handle that its host feeds and empties; one on a bus has none. */
struct host_queues {
    struct host_queue in;
    struct host_queue out;
};

/** Where a shaft is: angle + floor(rate * (t - at) / 1 s). */
struct host_course {
    dg_ns at;
    dg_angle angle;
    int64_t rate; /**< 2^-32 turns per second */
};

/** Faults at work, of the wire as long as the handle is on no bus. */
struct host_faults {
    /** What the encoder says is bent, but for characters. @return how often it arrives */
    unsigned (*arrives)(void *ctx, struct dg_host_event *event);
    /** The encoder says a reply in characters, by dg_host_say_reply() as often as it arrives. */
    void (*reply)(void *ctx, const uint8_t *bytes, size_t n);
    /** What the other end does may be bent. @return whether the encoder hears it */
    bool (*hears)(void *ctx, struct dg_host_event *event);
    /** Clocked lines: what gets to the other end while the encoder's line is at `raw`. Asked behind
     * each edge of the clock. */
    bool (*bent)(void *ctx, bool raw);
    /** The host sets the quantity of the world at `offset`: the fault that bends it is over, and
     * the encoder feels its wire before it looks at the new one. */
    void (*overridden)(void *ctx, size_t offset);
    /** Power has come: the encoder feels its wire before anything else. */
    void (*feel)(void *ctx);
};

/** What a handle points to, beside the parts in `line` and the shaft in `world`: none of it is in a
 * state. */
struct host_refs {
    const struct dg_device *device;
    const struct dg_host_wire *wire;
    const struct dg_bus_side *side; /**< NULL: it goes on no bus */
    struct host_queues *queues;     /**< behind the handle; NULL: it is on a bus */
    void (*heard)(void *ctx, const struct dg_host_event *event); /**< NULL: into `queues` */
    void *heard_ctx;
    const struct host_faults *faults; /**< NULL: none */
    void *faults_ctx;
    struct dg_nvm nvm; /**< the host's own; ops NULL: `memory` */
    uint8_t *memory;
};

/** The handle. */
struct dg_host {
    struct dg_host_line line; /**< first: operations get it and find the handle */
    struct host_refs refs;
    uint32_t memory_size;
    dg_ns deadline; /**< of the device */
    struct dg_world world;
    struct host_course course;
    struct host_course before; /**< in force before course.at: encoders look back */
    uint8_t controller;        /**< CAN: enum dg_controller, as the host said last */
    bool made;                 /**< was switched on: settings are in force */
    bool loaded;               /**< `memory` has an image */
    bool untold;               /**< events were lost, and nobody knows yet */
    uint32_t lost;
};

/** Up to a multiple of DG_HOST_ALIGN. */
static inline size_t dg_host_round(size_t n)
{
    return (n + DG_HOST_ALIGN - 1u) / DG_HOST_ALIGN * DG_HOST_ALIGN;
}

/** Where queues begin, if a handle has some. */
#define HOST_QUEUES_AT dg_host_round(sizeof(struct dg_host))

/** Where the parts behind them begin, in this order, counted from the handle. */
struct host_parts {
    size_t settings; /**< HOST_QUEUES_AT: there are no queues, it is on a bus */
    size_t device;
    size_t memory;
    size_t end; /**< as memory: the model has no EEPROM, or it is the host's */
};

/** handle.c */
/** Of a handle that is alone and has its own memory. */
struct host_parts dg_host_parts_of(const struct dg_device *model, const struct dg_host_wire *wire);
/** As dg_host_init(), of a handle with such parts. */
struct dg_host *dg_host_init_parts(void *memory, size_t size, const struct dg_device *model,
                                   const struct dg_host_wire *wire, const struct host_parts *parts);

/** physics.c: the angle of a handle's own shaft, `course`. */
dg_angle dg_host_own_angle(void *handle, dg_ns at);
/** Sit on a shaft, which `angle_of` tells the angle of. */
void dg_host_sit(struct dg_host *self, void *shaft, dg_angle (*angle_of)(void *shaft, dg_ns at));

/** time.c: whatever is due up to `now` happens, and what the host changed is looked at. */
void dg_host_run(struct dg_host *self, dg_ns now);
/** Whatever is due before `now` happens, and it is `now`. */
void dg_host_run_until(struct dg_host *self, dg_ns now);
/** What the encoder has sent gets to its host, whatever faults there are. */
void dg_host_deliver(struct dg_host *self, const struct dg_host_event *event);
/** runs.c: a reply goes out, from line->until on, which is its end then. */
void dg_host_say_reply(struct dg_host *self, const uint8_t *bytes, size_t n);
/** The next part of an event, which faults may bend. @return whether it was the last one */
bool dg_host_take_event(struct dg_host *self, struct dg_host_event *event);
/** The line may have another level than was told. */
void dg_host_look_at_level(struct dg_host *self);
/** What came in and what is due at the present moment. */
void dg_host_serve(struct dg_host *self);
/** What the wire's controller is by itself, if `event` says so. */
void dg_host_note_controller(struct dg_host *self, const struct dg_host_event *event);
/** Whether a handle of this wire can take `event`. @return as dg_host_wire.check */
int dg_host_check_event(const struct dg_host_wire *wire, const struct dg_host_event *event);

#endif
