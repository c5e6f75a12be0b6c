/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder behind an opaque handle, for hosts that know nothing of protocols: bindings of other
 * languages, simulators, FMUs, network ports. Whoever uses it needs no layout of a struct but those
 * in this header, and no start sequence of a protocol.
 *
 *   struct dg_host *encoder = dg_host_make(memory, dg_host_size_of("f3668"), "f3668");
 *   dg_host_set(encoder, "node", "5");
 *   dg_host_power(encoder, now, true);
 *   dg_host_shaft(encoder, now, angle, turns_per_s);
 *   dg_host_send(encoder, &frame);
 *   next = dg_host_step(encoder, now);
 *   while (dg_host_receive(encoder, &frame) > 0) ...
 *
 * The host owns memory and time. Nothing is allocated, nothing happens outside of these calls.
 * A handle is for one thread at a time; two handles share nothing but a shaft they were put on.
 *
 * Time goes on in dg_host_step(), and in every call that takes `now`: whatever is due up to then
 * happens at its own moment, in the order of time, however far apart the calls are. A `now` before
 * the latest one is taken for that one, and so is DG_HOST_NEVER, which is no moment. Memory is
 * `dg_host_size()` bytes at a multiple of DG_HOST_ALIGN, and must not be moved.
 *
 * ABI: names, types, values and layouts in this header stay what they are until the SONAME of the
 * library changes; what is added comes behind. tests/abi has the list.
 */
#ifndef DREHGEBER_HOST_H
#define DREHGEBER_HOST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_device;     /* a model: devices.h */
struct dg_shaft;      /* shaft.h */
struct dg_nvm;        /* hal.h */
struct dg_host_wire;  /* a protocol's side of this: host_wire.h */
struct dg_instrument; /* its side of the control plane: instruments.h */

/** An encoder. Lives in the host's memory. */
struct dg_host;

/** What the memory of a handle has to be aligned for. */
#define DG_HOST_ALIGN 16u
/** Events that wait in either direction at most. */
#define DG_HOST_QUEUE 64u
/** Identifiers that a CAN encoder listens to at most. */
#define DG_HOST_FILTERS 16u
/** "Nothing will happen by itself." */
#define DG_HOST_NEVER UINT64_MAX

/** What the functions return: 0, one of these, or where they say so something positive. Those down
 * to OLDER are enum dg_result. */
enum dg_host_result {
    DG_HOST_OK = 0,
    DG_HOST_ERR_ARGUMENT = -1, /**< outside of its range; nothing was changed */
    DG_HOST_ERR_IO = -2,       /**< the EEPROM does not acknowledge */
    DG_HOST_ERR_SPACE = -3,    /**< does not fit, or the queue is full; nothing was changed */
    DG_HOST_ERR_DAMAGED = -4,  /**< the check sum is wrong */
    DG_HOST_ERR_BLANK = -5,    /**< the EEPROM is empty */
    DG_HOST_ERR_FOREIGN = -6,  /**< the EEPROM is another device's */
    DG_HOST_ERR_OLDER = -7,    /**< of an earlier release */
    DG_HOST_ERR_NAME = -8,     /**< this encoder has nothing of that name */
    DG_HOST_ERR_STATE = -9,  /**< not now: too late to set, no power, or in the middle of a frame */
    DG_HOST_ERR_WIRE = -10,  /**< not on the wire that this encoder has */
    DG_HOST_ERR_LOST = -11,  /**< events were lost: nobody fetched them in time */
    DG_HOST_ERR_OTHER = -12, /**< a state of another model, version or build */
    DG_HOST_ERR_REFUSED = -13, /**< the encoder answered, and refuses */
    DG_HOST_ERR_SILENT = -14,  /**< the encoder did not answer */
};

/** The result in words, without a stop; "unknown result" for others. Never NULL. */
DG_API const char *dg_host_result_text(int result);

/* ---------------------------------------------------------------- making one */

/** A model as memory and handle need it: struct dg_device and the protocol's side, both linked by
 * whoever names them and nobody else, e.g. dg_host_init(m, n, &dg_f3668, &dg_cia406_wire). */
DG_API extern const struct dg_host_wire dg_hf_wire, dg_biss_wire, dg_ssi_wire, dg_cia406_wire,
    dg_ib_wire;

/** Bytes that a handle of this model needs, EEPROM and queues included; 0: `wire` is not that of
 * the model. */
DG_API size_t dg_host_size(const struct dg_device *model, const struct dg_host_wire *wire);

/**
 * Make an encoder, without power, its shaft at rest at 0, as delivered.
 * @return NULL: `size` is too small, `memory` is not aligned, `wire` is not that of the model
 */
DG_API struct dg_host *dg_host_init(void *memory, size_t size, const struct dg_device *model,
                                    const struct dg_host_wire *wire);

/** Name of model `index` of all there are, as on the command line; NULL behind the last one. These
 * three link every model. */
DG_API const char *dg_host_name(size_t index);
/** As dg_host_size(); 0: there is no such model. */
DG_API size_t dg_host_size_of(const char *name);
/** As dg_host_init(). @return NULL also when there is no such model */
DG_API struct dg_host *dg_host_make(void *memory, size_t size, const char *name);

/** Its model, e.g. "s3684-rs485". */
DG_API const char *dg_host_model(const struct dg_host *self);
/** Its protocol in a word, to be shown: what a host does goes by dg_host_medium(). */
DG_API const char *dg_host_protocol(const struct dg_host *self);

/* ---------------------------------------------------------------- settings */

/** A setting. The texts last as long as the library. */
struct dg_host_key {
    const char *name; /**< for dg_host_set() */
    const char *unit; /**< "" without */
    const char *help; /**< what it is */
    int64_t min;      /**< smallest number, or fewest characters of a text */
    int64_t max;      /**< largest number, or most characters */
    uint8_t type;     /**< enum dg_host_key_type */
    uint8_t places;   /**< decimals of a number; min and max count the last one */
    uint8_t always;   /**< 1: may be set at any time; 0: before the first power-on */
    uint8_t reserved[5];
};

/** How a setting is written. */
enum dg_host_key_type {
    DG_HOST_KEY_NUMBER = 0, /**< 12, 0.5, 0x27, 27h */
    DG_HOST_KEY_WORD = 1,   /**< one of some words, see dg_host_word() */
    DG_HOST_KEY_TEXT = 2,   /**< characters */
};

/** Setting `index` of this encoder: address, serial number and factory figures, then its world.
 * @return 0; DG_HOST_ERR_NAME behind the last one */
DG_API int dg_host_key(const struct dg_host *self, size_t index, struct dg_host_key *to);

/** Word `index` that this setting can be, e.g. "0" and "1", or "own" and "early". @return it, which
 * lasts as long as the library; NULL behind the last one, and of a setting that is no word */
DG_API const char *dg_host_word(const struct dg_host *self, const char *key, size_t index);

/** Set one. @return 0; DG_HOST_ERR_NAME; DG_HOST_ERR_ARGUMENT: not such a value;
 * DG_HOST_ERR_STATE: it was on already */
DG_API int dg_host_set(struct dg_host *self, const char *key, const char *value);

/** What it is, as text. @return its characters; DG_HOST_ERR_NAME; DG_HOST_ERR_SPACE */
DG_API int dg_host_get(const struct dg_host *self, const char *key, char *to, size_t size);

/* ---------------------------------------------------------------- EEPROM and power */

/** Bytes of the EEPROM; 0: it has none. */
DG_API size_t dg_host_memory_size(const struct dg_host *self);

/** Copy the EEPROM. @return 0; DG_HOST_ERR_SPACE: `n` is less; DG_HOST_ERR_STATE: it is the host's
 * (dg_host_memory_port()) */
DG_API int dg_host_memory_copy(const struct dg_host *self, void *to, size_t n);

/** Put an image there while it is off; it will not be formatted then. @return as above, with
 * DG_HOST_ERR_STATE also while it is on, DG_HOST_ERR_SPACE also when `n` is more */
DG_API int dg_host_memory_load(struct dg_host *self, const void *from, size_t n);

/** Use the host's EEPROM before the first power-on, which formats it when it is blank. Saved states
 * do not contain it. */
DG_API int dg_host_memory_port(struct dg_host *self, const struct dg_nvm *nvm);

/**
 * Switch the power, also from on to on: a power cycle. The first power-on formats the EEPROM unless
 * it was loaded, and makes the encoder of its settings.
 * @return 0; DG_HOST_ERR_ARGUMENT: settings that do not go together; DG_HOST_ERR_BLANK,
 * DG_HOST_ERR_FOREIGN: it stays off; DG_HOST_ERR_IO
 */
DG_API int dg_host_power(struct dg_host *self, uint64_t now, bool on);

/** Whether it is on. */
DG_API bool dg_host_powered(const struct dg_host *self);

/* ---------------------------------------------------------------- physics */

/**
 * The shaft is at `angle` (2^-32 turns, clockwise looking at it) at `now` and turns on at `rate`
 * (2^-32 turns per second), both exactly: angle + floor(rate * t). What was before stays what it
 * was.
 */
DG_API void dg_host_shaft(struct dg_host *self, uint64_t now, int64_t angle, int64_t rate);

/** Sit on a shaft that others may share; NULL: on its own one again. Saved states do not contain
 * it. `shaft` has to outlive that. */
DG_API void dg_host_shaft_of(struct dg_host *self, struct dg_shaft *shaft);

/** Sit on the shaft of another encoder; NULL: on its own again. It has to outlive that.
 * @return 0; DG_HOST_ERR_ARGUMENT: that one sits on somebody's shaft itself */
DG_API int dg_host_share(struct dg_host *self, struct dg_host *other);

/** Its angle at any moment. */
DG_API int64_t dg_host_angle(const struct dg_host *self, uint64_t at);

/** Set a quantity of the world, e.g. "temperature" in 0.001 degC, as quantity.h counts them. A
 * fault of the panel's that bends it is over, as with WORLd.
 * @return 0; DG_HOST_ERR_NAME; DG_HOST_ERR_ARGUMENT: out of its range */
DG_API int dg_host_world_set(struct dg_host *self, uint64_t now, const char *name, int64_t value);
/** What it is. @return 0 or DG_HOST_ERR_NAME */
DG_API int dg_host_world_get(const struct dg_host *self, const char *name, int64_t *value);

/* ---------------------------------------------------------------- time and wire */

/** What an event is. */
enum dg_host_kind {
    DG_HOST_BYTES = 1, /**< RS485: `length` characters without pauses, the first one's start bit at
                            `at`; `id`: nanoseconds a character takes, 0 (sent): as the encoder's */
    DG_HOST_CAN = 2,   /**< a frame `id`, complete at `at`; `length`: DLC */
    DG_HOST_BUS = 3,   /**< CAN, sent: the controller is, `id`: enum dg_host_bus */
    DG_HOST_EDGE = 4,  /**< BiSS, SSI: the master's clock, or the encoder's line, is at data[0] */
    DG_HOST_WORDS = 5, /**< INTERBUS: a data cycle, `id`: OUT, then IN; `length`: bytes of IN */
};

/** Bits of dg_host_event.flags. */
enum dg_host_flag {
    DG_HOST_DAMAGED = 1,  /**< BYTES, sent: parity or framing error, or another data rate */
    DG_HOST_START = 2,    /**< BYTES, sent: only the edge of a start bit at `at`, no data yet */
    DG_HOST_ENDED = 4,    /**< BYTES, sent: `at` is the end of the first character's stop bit, and
                               start bits are not told: each has to be complete in time */
    DG_HOST_REMOTE = 8,   /**< CAN: a remote frame */
    DG_HOST_IDENTIFY = 16 /**< WORDS: an ID cycle; received: `id` is the ID word */
};

/** dg_host_event.id of DG_HOST_BUS. */
enum dg_host_bus {
    DG_HOST_BUS_ACTIVE = 0,  /**< error active */
    DG_HOST_BUS_PASSIVE = 1, /**< error passive */
    DG_HOST_BUS_OFF = 2,     /**< bus-off */
    DG_HOST_BUS_OVERRUN = 3, /**< a frame was lost */
    DG_HOST_BUS_ABSENT = 4,  /**< nobody acknowledges */
    DG_HOST_BUS_PRESENT = 5, /**< somebody does */
};

/** What goes over the wire, in either direction. Fill unused members with 0. */
struct dg_host_event {
    uint64_t at;      /**< ns */
    uint32_t id;      /**< as the kind says */
    uint16_t flags;   /**< enum dg_host_flag */
    uint8_t kind;     /**< enum dg_host_kind */
    uint8_t length;   /**< bytes in data */
    uint8_t data[16]; /**< what is sent */
};

/** What the wire does from now on: it happens at `at`, in dg_host_step() or another call with a
 * `now` not before that; earlier than one that waits, or than the latest `now`: then.
 * @return 0; DG_HOST_ERR_WIRE, DG_HOST_ERR_ARGUMENT: no such event; DG_HOST_ERR_SPACE:
 * DG_HOST_QUEUE wait already; DG_HOST_ERR_STATE: it was never on */
DG_API int dg_host_send(struct dg_host *self, const struct dg_host_event *event);

/** Fetch what the encoder has sent. @return 1; 0: nothing is left; DG_HOST_ERR_LOST: once behind
 * what was left when the queue was full, and before what came after */
DG_API int dg_host_receive(struct dg_host *self, struct dg_host_event *to);

/** How many events were lost since it was made. */
DG_API uint32_t dg_host_lost(const struct dg_host *self);

/** Have `heard` called for what the encoder sends, in the call it happens in, in place of the
 * queue; NULL: the queue again. It must not call for this handle. */
DG_API void dg_host_listen(struct dg_host *self,
                           void (*heard)(void *ctx, const struct dg_host_event *event), void *ctx);

/** Let time pass. @return when to call again at the latest to have events in time; DG_HOST_NEVER */
DG_API uint64_t dg_host_step(struct dg_host *self, uint64_t now);
/** The same moment; nothing happens. */
DG_API uint64_t dg_host_next(const struct dg_host *self);

/** The same in picoseconds, for simulators: `now` is rounded down to the nanosecond, and the result
 * is exact, so that nothing is early. */
DG_API uint64_t dg_host_step_ps(struct dg_host *self, uint64_t now);

/** BiSS, SSI: the master's clock is at `level` from `now` on. @return level of the encoder's line,
 * 0 or 1, with an edge event when it is new; DG_HOST_ERR_WIRE; DG_HOST_ERR_STATE: never on */
DG_API int dg_host_clock(struct dg_host *self, uint64_t now, bool level);
/** The same in picoseconds. */
DG_API int dg_host_clock_ps(struct dg_host *self, uint64_t now, bool level);

/** BiSS: the line of the next encoder in the chain, which is this one's SLI, is at `level` from
 * `now` on; low until then, as that of the last one is. @return level of the encoder's line, as
 * above; DG_HOST_ERR_WIRE; DG_HOST_ERR_STATE: never on */
DG_API int dg_host_behind(struct dg_host *self, uint64_t now, bool level);

/** BiSS: what the user should be told, for hosts that can speak: why a master may hang, when none
 * has clocked for the setting hint_us since this was asked first after a start. Once a start; in a
 * chain the last encoder says it. `now` as of dg_host_step(), DG_HOST_NEVER at the end of time.
 * @param due when to ask again, unless something happens before; DG_HOST_NEVER. @return NULL:
 * nothing */
DG_API const char *dg_host_hint(struct dg_host *self, uint64_t now, uint64_t *due);

/** BiSS, SSI: the position in the latest frame, as a master got it or will get it to the end, and
 * the moment it is of. @return 0; DG_HOST_ERR_WIRE; DG_HOST_ERR_STATE: there was none yet */
DG_API int dg_host_latched(const struct dg_host *self, uint64_t *at, uint64_t *counts);

/** A frame as a master sees it. */
struct dg_host_frame {
    uint64_t at;         /**< the position is of this moment */
    uint64_t end;        /**< the encoder is ready for the next one */
    uint64_t bits;       /**< as they came, behind start bit and CDS (BiSS), right-aligned */
    uint64_t position;   /**< multiturn and singleturn, right-aligned, binary */
    uint32_t multiturn;  /**< 0 without */
    uint32_t singleturn; /**< counts in the turn */
    uint8_t count;       /**< of bits */
    uint8_t error;       /**< 1: the encoder tells an error */
    uint8_t warning;     /**< 1: it tells a warning (BiSS) */
    uint8_t good;        /**< 1: check sum or parity are right */
    uint8_t life;        /**< life counter (BiSS) */
    uint8_t reserved[3];
};

/** BiSS, SSI: be the master, with a clock of 1 MHz, and read a frame that is latched at `now`. Time
 * goes on to to->end; no edges are told. @return 0; DG_HOST_ERR_WIRE; DG_HOST_ERR_STATE: no power,
 * or in the middle of a frame */
DG_API int dg_host_frame(struct dg_host *self, uint64_t now, struct dg_host_frame *to);

/** BiSS: read or write `n` (1..64) registers from `address` on, with frames one behind the other
 * from `*now`; then it is `*now`. @return how many; DG_HOST_ERR_REFUSED: not the first one;
 * DG_HOST_ERR_SILENT; DG_HOST_ERR_DAMAGED; as dg_host_frame() */
DG_API int dg_host_registers_read(struct dg_host *self, uint64_t *now, uint8_t address,
                                  uint8_t *bytes, size_t n);
/** Likewise. */
DG_API int dg_host_registers_write(struct dg_host *self, uint64_t *now, uint8_t address,
                                   const uint8_t *bytes, size_t n);

/** RS485: the setting in force. */
struct dg_host_uart {
    uint32_t baud;
    uint8_t parity;       /**< 'N', 'E' or 'O' */
    uint8_t timeout_bits; /**< end of a frame */
    uint8_t reserved[2];
};

/** @return 0; DG_HOST_ERR_WIRE; DG_HOST_ERR_STATE: no power */
DG_API int dg_host_uart(const struct dg_host *self, struct dg_host_uart *to);
/** Nanoseconds that `count` characters (0..5000) without pauses take at a setting, rounded up;
 * DG_HOST_NEVER: a data rate of 0. */
DG_API uint64_t dg_host_uart_ns(const struct dg_host_uart *uart, uint32_t count);
/** CAN: kbit/s in force. @return that; DG_HOST_ERR_WIRE; DG_HOST_ERR_STATE: no power */
DG_API int dg_host_bit_rate(const struct dg_host *self);
/** CAN: what the encoder takes its controller for, by what it was told (DG_HOST_BUS) and by faults.
 * @return DG_HOST_BUS_ACTIVE, _PASSIVE or _OFF; DG_HOST_ERR_WIRE; DG_HOST_ERR_STATE: no power */
DG_API int dg_host_bus_state(const struct dg_host *self);
/** CAN: the identifiers it listens to at the moment, for whoever has many on one bus; what it
 * hears, time and power change them. @return how many of `ids` are set; DG_HOST_ERR_WIRE;
 * DG_HOST_ERR_STATE: no power */
DG_API int dg_host_filters(const struct dg_host *self, uint16_t ids[DG_HOST_FILTERS]);
/** CAN: when it answers the SDO request that it has not answered yet: "save" takes its time. For
 * hosts whose time stands still while somebody waits. @return DG_HOST_NEVER: there is none */
DG_API uint64_t dg_host_answer_at(const struct dg_host *self);

/* ---------------------------------------------------------------- looks */

/** The position as the wire would tell it at any moment; nothing changes. @return 0;
 * DG_HOST_ERR_STATE: no power */
DG_API int dg_host_position(const struct dg_host *self, uint64_t at, uint64_t *counts);
/** The same `n` times, every `interval` ns from `at` on. */
DG_API int dg_host_positions(const struct dg_host *self, uint64_t at, uint64_t interval,
                             uint64_t *counts, size_t n);

/** RS485: the process channel at any moment: sin+, sin-, cos+, cos- in microvolts.
 * @return 0; DG_HOST_ERR_WIRE; DG_HOST_ERR_STATE: no power */
DG_API int dg_host_sincos(const struct dg_host *self, uint64_t at, int32_t to[4]);

/* ---------------------------------------------------------------- states */

/** Bytes of a state. */
DG_API size_t dg_host_state_size(const struct dg_host *self);

/** Save everything: settings, EEPROM, world, own shaft, queues, what the encoder is doing. There
 * is no pointer in it, and what goes on from it is the same byte for byte. @return 0 or
 * DG_HOST_ERR_SPACE */
DG_API int dg_host_save(struct dg_host *self, void *to, size_t n);

/**
 * Go on from a state that a handle of the same model and the same build of the library has saved,
 * maybe in another process. The host's own EEPROM and shaft, and its listener, stay those of this
 * handle. What a state says is believed, whoever made it, but nothing that would lead out of the
 * memory of the handle or never end: that is DG_HOST_ERR_DAMAGED as well.
 * @return 0; nothing was changed: DG_HOST_ERR_OTHER, DG_HOST_ERR_DAMAGED, DG_HOST_ERR_SPACE: too
 * short
 */
DG_API int dg_host_restore(struct dg_host *self, const void *from, size_t n);

/* ---------------------------------------------------------------- faults and SCPI */

/** The control plane of one encoder, in memory of the host's as the handle is; links it. What it
 * has done to world and EEPROM is in saved states and lasts there. The panel itself is not: neither
 * its shaft nor which faults are at work, nor the session of SCPI. A handle that goes on from a
 * state keeps the panel it has, with the faults of that. */
struct dg_host_panel;

/** Bytes of a panel. */
DG_API size_t dg_host_panel_size(void);

/**
 * Put a panel before an encoder that was switched on, which has to outlive it; one at a time. The
 * encoder sits on the panel's shaft then, which is at the same angle, at rest: SHAFt moves it.
 * Faults of the wire happen to what is for the encoder; of one by dg_host_init() alone, which does
 * not know that, to all that comes (dg_host_take_side() in host_wire.h).
 * @return NULL: too small, not aligned, never on, or `instrument` is not that of its protocol
 */
DG_API struct dg_host_panel *dg_host_panel_init(void *memory, size_t size, struct dg_host *host,
                                                const struct dg_instrument *instrument);
/** The same with the instrument of its protocol; links all of them. @return NULL also: it has none
 */
DG_API struct dg_host_panel *dg_host_panel_make(void *memory, size_t size, struct dg_host *host);

/** The shaft of the panel, which its encoder sits on: others may sit on it, too, by
 * dg_host_shaft_of(), and it may be coupled to another one (dg_shaft_couple()). */
DG_API struct dg_shaft *dg_host_panel_shaft(struct dg_host_panel *self);

/** What happens by chance, faults and busy_jitter_us of BiSS, goes by `seed` from now on: the same
 * again with the same one. Until then that is 0 for faults, and the serial number. */
DG_API void dg_host_panel_seed(struct dg_host_panel *self, uint32_t seed);

/** Something that can happen to the encoder. The texts last as long as the library. */
struct dg_host_fault {
    char name[32];
    const char *cause;  /**< what has happened */
    const char *effect; /**< what the device will do */
    uint8_t active;     /**< 1: it lasts */
    uint8_t reserved[7];
};

/** Entry `index` of its catalogue. @return 0; DG_HOST_ERR_NAME behind the last one */
DG_API int dg_host_fault(const struct dg_host_panel *self, size_t index, struct dg_host_fault *to);

/** Let a fault happen until it is made good. Those of the wire happen to what is sent and received;
 * of BiSS and SSI to levels and edges, from the next frame on, but not to dg_host_frame() and
 * registers, which are read at the encoder's own end of the line. @return 0; DG_HOST_ERR_NAME;
 * DG_HOST_ERR_IO */
DG_API int dg_host_fault_set(struct dg_host_panel *self, uint64_t now, const char *name, bool on);

/** A line of SCPI, without its end, and what is answered, with a zero behind it and no LF at the
 * end. A command that waits answers in a later call: with "" when there is nothing else to say.
 * @return characters of the answer; DG_HOST_ERR_SPACE: it was cut, or the line
 * was not taken to its end */
DG_API int dg_host_scpi(struct dg_host_panel *self, uint64_t now, const char *line, char *answer,
                        size_t size);

/** dg_host_step() of its encoder, with the end of faults that have a time. */
DG_API uint64_t dg_host_panel_step(struct dg_host_panel *self, uint64_t now);

/* ---------------------------------------------------------------- media */

/** What travels on the wire of an encoder. A host goes by this, and refuses one that it does not
 * know: later releases may have more. What only some encoders of a medium can do is found by
 * asking: functions that say so answer DG_HOST_ERR_WIRE, also before the first power-on. */
enum dg_host_medium {
    DG_HOST_MEDIUM_CHARACTERS = 0, /**< DG_HOST_BYTES */
    DG_HOST_MEDIUM_FRAMES = 1,     /**< DG_HOST_CAN and DG_HOST_BUS */
    DG_HOST_MEDIUM_EDGES = 2,      /**< DG_HOST_EDGE and dg_host_clock() */
    DG_HOST_MEDIUM_WORDS = 3,      /**< DG_HOST_WORDS */
};

/** @return enum dg_host_medium */
DG_API int dg_host_medium(const struct dg_host *self);
/** The setting that is its address on a wire, e.g. "node". @return NULL: it has none there */
DG_API const char *dg_host_address_key(const struct dg_host *self);

#ifdef __cplusplus
}
#endif

#endif
