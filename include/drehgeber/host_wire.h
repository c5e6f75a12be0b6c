/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A protocol's side of dg_host: one const object in a file of its own in the protocol's folder,
 * linked by whoever names it. Not for hosts, and without the promise that host.h makes.
 */
#ifndef DREHGEBER_HOST_WIRE_H
#define DREHGEBER_HOST_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/host.h"
#include "drehgeber/key.h"
#include "drehgeber/stack.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_encoder; /* control.h */
struct dg_rig;     /* likewise */

/** What a wire sees of its handle, and keeps there. dg_stack_setup.ctx of the device. */
struct dg_host_line {
    void *device;   /**< as the stack makes it */
    void *settings; /**< dg_host_wire.settings_size bytes */
    dg_ns now;      /**< the moment that is being served */
    dg_ns latched;  /**< clocked lines: the latest frame is of this moment; 0: there was none */
    dg_ns until;    /**< characters: what the encoder sends is on the line until then */
    uint32_t part;  /**< the wire's own: parts of the event at hand that were taken */
    uint32_t rate;  /**< the wire's own */
    bool level;     /**< the wire's own: of the encoder's line as told last */
    bool behind;    /**< clocked lines: level of the line of the next encoder in a chain */
    bool chained;   /**< ... of which there is one */
    bool on_bus;    /**< a bus hears what it says; not in a state */
};

/** Identifiers that services of one encoder share at most. */
#define DG_HOST_SHARED 3u

/** Frames: what a bus asks of an encoder. None is NULL; each may be asked without power. */
struct dg_host_controller {
    /** Another number whenever one of those below may give another answer. */
    uint32_t (*version)(const void *device);
    /** The identifiers it listens to. @return how many */
    uint8_t (*listens)(const void *device, uint16_t ids[DG_HOST_FILTERS]);
    /** In force, in bit/s; 0: not known. */
    uint32_t (*bit_rate)(const void *device);
    /** What tells its encoders apart on a bus, as in force. */
    uint32_t (*address)(const void *device);
    /** Identifiers that two of its services have, both of which send, for who tells the user.
     * @return how many */
    uint8_t (*shared)(const void *device, uint16_t ids[DG_HOST_SHARED]);
    /** Whether it does not know yet that somebody acknowledges (DG_HOST_BUS_PRESENT), or that
     * nobody does (DG_HOST_BUS_ABSENT). */
    bool (*is_news)(const void *device, enum dg_host_bus event);
    /** Whether a frame that it sends with this identifier may acknowledge that something was
     * stored. */
    bool (*acknowledges)(const void *device, uint32_t id);
};

/** What a ring asks of an encoder in it; words are numbers of up to 32 bits, IN and OUT of one
 * size. No operation is NULL. */
struct dg_host_ring {
    /** Words of 16 bits in either image: 1 or 2. Also before the first power-on. */
    uint8_t (*words)(const struct dg_host_line *line);
    /** Whether an ID cycle was here since it was switched on. */
    bool (*identified)(const struct dg_host_line *line);
    /** Its part of an ID cycle. `last`: the ring is cut behind it. @return its ID word */
    uint16_t (*identify)(struct dg_host_line *line, dg_ns now, bool last);
    /** Its part of a data cycle. @return IN */
    uint32_t (*exchange)(struct dg_host_line *line, dg_ns now, uint32_t out);
    /** A transmission error was found here. */
    void (*spoil)(struct dg_host_line *line);
    /** Until when data cycles with the same OUT as at `now` only count and latch; `now`: not even
     * the next one. DG_NEVER */
    dg_ns (*quiet)(const struct dg_host_line *line, dg_ns now);
    /** Count data cycles that are not run. */
    void (*skip)(struct dg_host_line *line, uint32_t cycles);
};

/** The wire. Operations may be NULL where they say so. */
struct dg_host_wire {
    const struct dg_stack *stack;
    const struct dg_keys *keys; /**< offsets count from the beginning of settings */
    uint32_t blind;             /**< bit n: it does not sense enum dg_quantity_id n */
    size_t settings_size;
    /** Settings of this model, as delivered. They begin with a copy of the stack's own struct;
     * NULL: that is all of them. */
    void (*furnish)(void *settings, const struct dg_device *device);
    /** Bit n: this model has not row n of `keys`. NULL: each has all. */
    uint32_t (*without)(const void *settings);
    /** Put serial number, address and port of the settings into `setup`, which has the model as
     * ordered; make what pointers settings have. `setup` NULL: take the pointers out. NULL: there
     * is nothing to put anywhere. */
    void (*arrange)(void *settings, struct dg_stack_setup *setup);
    /** Whether `event` is one of this wire. @return 0, DG_HOST_ERR_WIRE, DG_HOST_ERR_ARGUMENT.
     * NULL: edges are, which `clock` takes. */
    int (*check)(const struct dg_host_event *event);
    /** When the next part of `event`, line->part, is due. NULL: event->at. */
    dg_ns (*due)(const struct dg_host_line *line, const struct dg_host_event *event);
    /** Take the next part at line->now. @return whether it was the last one. NULL with `check`. */
    bool (*take)(struct dg_host_line *line, const struct dg_host_event *event);
    /** Take a whole event at line->now, with all that is due then. @return when it wants to be
     * called again. For dg_host_feed(); NULL: `take`, then what is due is asked for. `uart` is the
     * same behind a character if nothing was due and nothing is said. */
    dg_ns (*feed)(struct dg_host_line *line, const struct dg_host_event *event);
    /** Clocked lines: level of the encoder's line, and the master's clock. NULL. */
    bool (*level)(const struct dg_host_line *line);
    bool (*clock)(struct dg_host_line *line, dg_ns now, bool level);
    /** Clocked lines: the position in the latest frame. NULL with `clock`. */
    uint64_t (*latched)(const struct dg_host_line *line);
    /** Whether encoders of this wire make chains: `level` and `clock` look at line->behind. */
    bool chains;
    /** What the user should know at `now`, once; NULL: nothing. `due`: when to ask again. NULL
     * where the protocol has nothing to say. */
    const char *(*hint)(struct dg_host_line *line, dg_ns now, dg_ns *due);
    /** Characters: the setting in force, or the `stored` one that will be. NULL: of another medium.
     */
    void (*uart)(const struct dg_host_line *line, bool stored, struct dg_host_uart *to);
    /** A frame by an own master from line->now on, which it moves on. NULL: has none. */
    int (*frame)(struct dg_host_line *line, struct dg_host_frame *to);
    /** States of others: of the stack, whose settings begin with its own struct. */
    const struct dg_stack_check *state;
};

/** What only a bus asks of an encoder, in an object of its own: who names no more than the wire
 * links nothing of it, and such a handle goes on no bus. Operations may be NULL where they say
 * so. */
struct dg_bus_side {
    const struct dg_host_wire *wire;
    /** Characters: whether a request that begins with `byte` is for this encoder. NULL: each is. */
    bool (*wants)(const struct dg_host_line *line, uint8_t byte);
    /** The address in force on a wire with several; -1: nobody can tell. NULL: there is none. */
    int (*address)(const struct dg_host_line *line);
    /** NULL but of frames. */
    const struct dg_host_controller *controller;
    /** DG_MEDIUM_WORDS: what a ring asks of it; NULL with all others. */
    const struct dg_host_ring *ring;
};

/** The protocols' own. */
DG_API extern const struct dg_bus_side dg_hf_side, dg_biss_side, dg_ssi_side, dg_cia406_side,
    dg_ib_side;

/** The encoder has sent something, but for characters. */
DG_API void dg_host_emit(struct dg_host_line *line, const struct dg_host_event *event);

/** Characters: the encoder says a whole reply from line->now on, as runs without pauses; its end is
 * line->until. */
DG_API void dg_host_emit_reply(struct dg_host_line *line, const uint8_t *bytes, size_t n);
/** Characters: how long so many of them take at the setting in force; only the last one is rounded
 * up. 0 on a bus, which counts by itself, and of a protocol without `uart`. */
DG_API dg_ns dg_host_characters_ns(const struct dg_host_line *line, size_t count);

/** Bytes of a handle without queues, for one that is put on a bus. It takes events by
 * dg_host_feed() and tells a listener; dg_host_send() is DG_HOST_ERR_STATE.
 * @return as dg_host_size() */
DG_API size_t dg_host_size_on_bus(const struct dg_device *model, const struct dg_bus_side *side);
/** The same for one whose EEPROM is the host's (dg_host_memory_port(), before the first power-on):
 * there is no room for one in it. */
DG_API size_t dg_host_size_with_port(const struct dg_device *model, const struct dg_bus_side *side);
/** Behind dg_host_memory_port(): there is an image of this encoder in it, as whoever opened it
 * knows. The first power-on does not look whether to format it. */
DG_API void dg_host_memory_known(struct dg_host *self);
/** Make one; with an EEPROM of its own if `size` has room for that. @return as dg_host_init() */
DG_API struct dg_host *dg_host_init_on_bus(void *memory, size_t size, const struct dg_device *model,
                                           const struct dg_bus_side *side);
/** A handle of this wire by dg_host_init() may go on a bus from now on, and its panel knows which
 * events are for it. `side` outlives it. */
DG_API void dg_host_take_side(struct dg_host *self, const struct dg_bus_side *side);
/** It is `now`, and nothing happens yet: what has become due since is late, and done at this moment
 * by the next call. For who cannot come in time. */
DG_API void dg_host_skip(struct dg_host *self, uint64_t now);
/** What a bus asks of this model's protocol; links all of them. NULL: it has none. */
DG_API const struct dg_bus_side *dg_bus_side_of(const struct dg_device *model);
/** The same for its wire alone. */
DG_API const struct dg_host_wire *dg_host_wire_of(const struct dg_device *model);

/** `event` of this wire happens at event->at, or at the latest moment that was served if that is
 * later: what was due before comes before, what is due then comes behind. All of it happens at that
 * moment: of characters one, DG_HOST_ENDED or DG_HOST_START. What waits in queues keeps its turn.
 * @return when to call again, as dg_host_step() */
DG_API uint64_t dg_host_feed(struct dg_host *self, const struct dg_host_event *event);

/** Frames: its controller says `event` (enum dg_host_bus) at the latest moment that was served, and
 * what that makes the encoder send it sends at once. On a bus nothing: that tells it. */
DG_API void dg_host_tell_controller(struct dg_host *self, uint32_t event);

/** As dg_host_listen(), for a bus: what the encoder says then begins at event->at, and how long it
 * takes is the bus's to say. */
DG_API void dg_host_join_bus(struct dg_host *self,
                             void (*heard)(void *ctx, const struct dg_host_event *event),
                             void *ctx);
/** Whether it was switched on once: then there is a device. */
DG_API bool dg_host_made(const struct dg_host *self);

/** The side of its protocol. */
DG_API const struct dg_host_wire *dg_host_wire_at(const struct dg_host *self);
/** What a bus asks of it; NULL: it was made without. */
DG_API const struct dg_bus_side *dg_host_side_at(const struct dg_host *self);
/** What a protocol sees of a handle, for a bus and the port around it; it lasts as long. */
DG_API struct dg_host_line *dg_host_line_of(struct dg_host *self);
/** What it senses, for a port that bends it; it lasts as long. */
DG_API struct dg_world *dg_host_world(struct dg_host *self);
/** What its device is made of: the port's view of model, world and memory. */
DG_API struct dg_stack_setup dg_host_setup(struct dg_host *self);

/** The encoder of a panel, whose faults happen to what it sends on a bus, too: dg_bus_control(). */
DG_API struct dg_encoder *dg_host_panel_encoder(struct dg_host_panel *self);
/** The rig of that one encoder, for dg_rig_follow(): dg_host_panel_step() goes on with courses, as
 * with faults that end. */
DG_API struct dg_rig *dg_host_panel_rig(struct dg_host_panel *self);

/** The line of a handle of this wire that was switched on, at its moment or at `now` if that is
 * later: time has gone on. @return NULL with `result`: another wire, or no power */
DG_API struct dg_host_line *dg_host_line_at(struct dg_host *self, const struct dg_host_wire *wire,
                                            dg_ns now, int *result);
/** A master's work on the clocked line of this handle ended at line->now; its edges are not told.
 */
DG_API void dg_host_line_done(struct dg_host *self);
/** The device of a handle of this wire that has power. @return NULL with `result` */
DG_API const void *dg_host_device(const struct dg_host *self, const struct dg_host_wire *wire,
                                  int *result);

#ifdef __cplusplus
}
#endif

#endif
