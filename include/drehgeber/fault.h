/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Defects as causes: what can go wrong with an encoder's physics, its EEPROM and its wire. A fault
 * bends a quantity of the world, flips a bit of the memory, or tells the port what to do to the
 * next frames; the device finds its own error codes.
 */
#ifndef DREHGEBER_FAULT_H
#define DREHGEBER_FAULT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/store.h"
#include "drehgeber/world.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_instrument;

/** What a port does to a frame or to its wire. */
enum dg_wire_fault {
    DG_WIRE_DROP,      /**< what the encoder sends does not arrive */
    DG_WIRE_DEAF,      /**< what the master sends does not arrive */
    DG_WIRE_DELAY,     /**< what the encoder sends arrives late, by dg_fault_row.value ns */
    DG_WIRE_DAMAGE,    /**< one bit of what the encoder sends is flipped */
    DG_WIRE_DUPLICATE, /**< what the encoder sends arrives twice */
    DG_WIRE_TEAR,      /**< INTERBUS: IN is half of this cycle and half of the one before */
    DG_WIRE_BREAK,   /**< INTERBUS: the bus into this device is cut; BiSS: SLO is cut, reads high */
    DG_WIRE_BUS_OFF, /**< CAN: the controller is bus-off */
    DG_WIRE_PASSIVE, /**< CAN: the controller is error passive */
    DG_WIRE_OVERRUN, /**< CAN: the controller has lost a received frame (an event, not a state) */
    DG_WIRE_FAULT_COUNT
};

/** What a CAN controller is, from good to bad. The numbers are those of enum dg_co_bus_event and
 * enum dg_host_bus. */
enum dg_controller {
    DG_CONTROLLER_ACTIVE,
    DG_CONTROLLER_PASSIVE,
    DG_CONTROLLER_OFF,
};

/** What a fault works on. */
enum dg_fault_kind {
    DG_FAULT_WORLD,  /**< sets a quantity of dg_world to `value` */
    DG_FAULT_MEMORY, /**< flips a bit of an EEPROM region; seen from the next power-on on */
    DG_FAULT_WIRE,   /**< enum dg_wire_fault; the last one */
};

/** An entry of the catalogue. Memory faults have no row: there is one for each checked region of
 * the encoder's layout, called "eeprom_" and the region's name with '_' for '-'. */
struct dg_fault_row {
    const char *name; /**< letters, digits, '_'; e.g. "led_current_high" */
    enum dg_fault_kind kind;
    uint8_t wire;        /**< enum dg_wire_fault */
    uint8_t size;        /**< of the quantity in bytes: 1 (bool), 2 or 4 */
    uint16_t offset;     /**< in struct dg_world */
    int64_t value;       /**< of the quantity; of DG_WIRE_DELAY the nanoseconds */
    const char *cause;   /**< physical cause, one line */
    const char *effect;  /**< what the device will do, with its codes, one line */
    const char *chapter; /**< of the manual, or a decision (R8, C6, I4, biss k=18) */
};

/** Most entries of an encoder's catalogue: its rows first, then its checked regions. */
#define DG_FAULTS_MAX 64u

/** How long a fault lasts. The usual one: no count, 1000000 ppm, DG_NEVER. */
struct dg_fault_limits {
    uint32_t count;           /**< wire: frames it happens to, then it is over; 0: no limit */
    uint32_t probability_ppm; /**< wire: of each frame, 0..1000000 */
    dg_ns duration;           /**< then it is over; DG_NEVER: until cleared */
};

/** A bit of the memory that is flipped. */
struct dg_fault_flip {
    uint32_t address; /**< of its byte */
    uint16_t sum;     /**< of the region when it was flipped */
    uint8_t mask;     /**< the bit */
    uint8_t value;    /**< of the byte since */
};

/** One active fault. */
struct dg_fault {
    bool active;
    uint32_t left; /**< frames; 0: no limit */
    uint32_t probability_ppm;
    uint32_t happened; /**< WIRE: frames it happened to */
    dg_ns until;       /**< DG_NEVER: until cleared */
    /** What is needed to undo it. */
    union {
        int64_t healthy;           /**< WORLD: value before */
        struct dg_fault_flip flip; /**< MEMORY */
    };
};

/** The faults of one encoder, by their index in its catalogue. Plain data, zero-initialised is none
 * active. */
struct dg_faults {
    uint32_t random; /**< state of the generator behind probabilities; any value */
    uint32_t wire;   /**< bit n: enum dg_wire_fault n is active: the ports' fast way out */
    uint8_t slot[DG_WIRE_FAULT_COUNT]; /**< its place in `fault` while it is active */
    struct dg_fault fault[DG_FAULTS_MAX];
};

/** What a catalogue entry of one encoder is. */
struct dg_fault_entry {
    char name[32];
    enum dg_fault_kind kind;
    const struct dg_fault_row *row; /**< NULL for a region */
    uint8_t region;
    const char *cause;
    const char *effect; /**< of a region a general text; `code` says which start-up error */
    const char *chapter;
    uint8_t code; /**< region: dg_store_region.startup_code; else 0 */
};

/** What faults work on. */
struct dg_fault_target {
    const struct dg_instrument *instrument; /**< whose catalogue counts */
    struct dg_world *world;
    const struct dg_store_layout *layout; /**< NULL: no EEPROM */
    struct dg_nvm nvm;
    bool singleturn; /**< it does not look at the multiturn sensor and its battery */
};

/** Entry `index` of the catalogue of an encoder. @return false behind the last one */
DG_API bool dg_fault_entry(const struct dg_fault_target *target, size_t index,
                           struct dg_fault_entry *out);

/** Index of the entry called `name` (not case sensitive), or DG_ERR_ARGUMENT. */
DG_API int dg_fault_find(const struct dg_fault_target *target, const char *name);

/**
 * Let entry `index` happen from `now` on; again while active: with the new limits. What bent the
 * same quantity before gives way.
 * @return 0; DG_ERR_ARGUMENT: no such entry, or count or probability for what does not happen to
 *         single frames; DG_ERR_IO: the memory did not answer
 */
DG_API int dg_fault_set(struct dg_faults *self, const struct dg_fault_target *target, size_t index,
                        dg_ns now, const struct dg_fault_limits *limits);

/** Make good: the quantity is as before unless it was changed since, the flipped bit is flipped
 * back unless the region was written since. Nothing happens when it is not active.
 * @return 0 or DG_ERR_ARGUMENT; DG_ERR_IO: it is still active */
DG_API int dg_fault_clear(struct dg_faults *self, const struct dg_fault_target *target,
                          size_t index);

/** The quantity at `offset` of struct dg_world is set by somebody: whatever bent it is over. */
DG_API void dg_fault_override(struct dg_faults *self, const struct dg_fault_target *target,
                              size_t offset);

/** Clear what is over; what the memory does not let go stays until cleared. @return when to call
 * again; DG_NEVER */
DG_API dg_ns dg_fault_step(struct dg_faults *self, const struct dg_fault_target *target, dg_ns now);

/** Whether wire fault `fault` is active: for states (break, bus-off, passive). */
DG_API bool dg_fault_wire_active(const struct dg_faults *self, enum dg_wire_fault fault);

/** What the controller of a CAN node that is `own` by itself has become by faults: never better. */
DG_API enum dg_controller dg_fault_controller(const struct dg_faults *self, enum dg_controller own);

/** Let wire fault `fault` happen to a frame if it is active and chance has it; counts down.
 * @return whether it happens */
DG_API bool dg_fault_wire_takes(struct dg_faults *self, enum dg_wire_fault fault);

/** A bit of `n` (at least 1) to flip, by chance. */
DG_API uint32_t dg_fault_pick(struct dg_faults *self, uint32_t n);

/** dg_fault_row.value of wire fault `fault` of an instrument: the delay. */
DG_API int64_t dg_fault_wire_value(const struct dg_instrument *instrument,
                                   enum dg_wire_fault fault);

#ifdef __cplusplus
}
#endif

#endif
