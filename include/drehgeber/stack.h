/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The seam between a protocol and everything else. A folder of src/ with a protocol exports one
 * const struct dg_stack; whoever only makes encoders, switches them on and lets time pass needs
 * nothing but this, and no table anywhere is indexed by protocols.
 *
 *   struct dg_stack_setup setup = {device->model, &world, nvm, SERIAL, &port, ctx};
 *   void *self = memory of stack->device_size bytes, aligned for max_align_t
 *   stack->format(&setup), once in the life of the EEPROM
 *   stack->init(self, &setup), stack->power_on(self, now), stack->step(self, now) ...
 *
 * What goes over the wire is each protocol's own business: a port knows the struct behind `self`
 * (struct dg_hf, dg_biss, dg_cia406_device, dg_ib) and calls its functions.
 */
#ifndef DREHGEBER_STACK_H
#define DREHGEBER_STACK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/hal.h"
#include "drehgeber/store.h"
#include "drehgeber/time.h"
#include "drehgeber/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What a device of any stack is made of. Everything pointed to must outlive the device. */
struct dg_stack_setup {
    const void *model; /**< the stack's own kind: struct dg_hf_model, dg_biss_model, ... */
    const struct dg_world *world;
    struct dg_nvm nvm; /**< ops NULL: none; only for models without an EEPROM, see `layout` */
    uint32_t serial;   /**< `format` burns it in where the model does not say */
    uint32_t address;  /**< likewise, on a wire that has some: an RS485 address, a node-ID; 0: as
                            delivered */
    const void *port;  /**< the wire's operations: struct dg_hf_ops, dg_co_ops; NULL where the stack
                            has none (dg_biss, dg_ib) */
    void *ctx;         /**< handed to them */
};

/** What travels on the wire of a protocol. Hosts go by this, and never by a protocol's name. */
enum dg_medium {
    DG_MEDIUM_CHARACTERS, /**< an asynchronous line: start bit, byte, parity, stop bit */
    DG_MEDIUM_FRAMES,     /**< CAN: frames with an identifier */
    DG_MEDIUM_EDGES,      /**< a clocked line: the master's clock, and a level of the encoder */
    DG_MEDIUM_WORDS,      /**< a ring: cycles of words, in and out */
    DG_MEDIUM_COUNT
};

/**
 * A protocol. Operations take `self`, the device's memory; they do not block but for the memory's
 * operations, and none is NULL but `differs` and `serial`.
 *
 * A device is plain data: it may be copied, compared, moved and kept. Its only pointers are those
 * of its setup and ones that `attach` can make anew.
 */
struct dg_stack {
    const char *name;          /**< lower case, unique; to be shown, not to be compared */
    enum dg_medium medium;     /**< of its wire */
    const char *address_key;   /**< the setting that is an encoder's address on a wire; NULL: it has
                                    none there; then nothing is said of addresses */
    const char *address_what;  /**< an address in words: "a node-ID" */
    uint8_t address_delivered; /**< as long as nobody has set another one */
    bool address_hex;          /**< written so */
    size_t device_size;        /**< bytes of a device, aligned for max_align_t */

    /** The EEPROM of `model`, or NULL: it has none. */
    const struct dg_store_layout *(*layout)(const void *model);
    /** Whether `model` looks at the multiturn sensor and its battery. */
    bool (*senses_multiturn)(const void *model);

    /** Burn the delivery state into setup->nvm; world and port are not looked at. Nothing is done
     * for a model without an EEPROM. @return 0; DG_ERR_ARGUMENT: a figure of the model, or the
     * address, is out of range; DG_ERR_IO */
    int (*format)(const struct dg_stack_setup *setup);
    /** Mount the memory of a model that has one, as power_on() does: what an earlier release has
     * written grows. @return as dg_store_mount(), dg_store_grow() */
    int (*mount)(const struct dg_stack_setup *setup, struct dg_store *store);
    /** What figures of the factory a mounted memory has that are not this model's, in words; NULL:
     * none. What is damaged is the device's to report. NULL as operation: there are none in it. */
    const char *(*differs)(const struct dg_stack_setup *setup, struct dg_store *store);
    /** The serial number in a mounted memory; -1: damaged. NULL as operation: there is none. */
    int64_t (*serial)(struct dg_store *store);
    /** Make a device, without power. The memory is not touched. @return 0; DG_ERR_ARGUMENT: a
     * pointer is missing, a figure is out of range */
    int (*init)(void *self, const struct dg_stack_setup *setup);
    /**
     * `self` holds the bytes of a device of the same model, made by the same build, maybe in
     * another process: these are its pointers now. NULL as setup: take all pointers out, so that
     * the bytes can be kept; nothing else may be called before the next attach().
     */
    void (*attach)(void *self, const struct dg_stack_setup *setup);

    /** Power. Also from the powered state: a power cycle. @return 0, also with damaged regions or a
     * silent EEPROM; DG_ERR_BLANK or DG_ERR_FOREIGN: not this device's memory, it stays off */
    int (*power_on)(void *self, dg_ns now);
    /** What was not stored is lost. */
    void (*power_off)(void *self);
    bool (*powered)(const void *self);
    /** Do what is due at `now`. May be called early or late. @return when to call again; DG_NEVER:
     * only the wire can change anything */
    dg_ns (*step)(void *self, dg_ns now);

    /** The model that it was made of. */
    const void *(*model)(const void *self);
    /** The position as the wire would tell it at `now`; 0 when it would tell none. Changes
     * nothing. */
    uint64_t (*position)(const void *self, dg_ns now);
};

/** For a protocol's own file, where every operation is a static function of the same name: all but
 * those that only some protocols have. */
#define DG_STACK_OPERATIONS                                                                        \
    .layout = layout, .senses_multiturn = senses_multiturn, .format = format, .init = init,        \
    .attach = attach, .power_on = power_on, .power_off = power_off, .powered = powered,            \
    .step = step, .model = model, .position = position

/** In the same file: `layout` and `mount` of a protocol whose models have no EEPROM. */
#define DG_STACK_WITHOUT_MEMORY                                                                    \
    static const struct dg_store_layout *layout(const void *model)                                 \
    {                                                                                              \
        (void)model;                                                                               \
        return NULL;                                                                               \
    }                                                                                              \
                                                                                                   \
    static int mount(const struct dg_stack_setup *setup, struct dg_store *store)                   \
    {                                                                                              \
        (void)setup;                                                                               \
        (void)store;                                                                               \
        return DG_ERR_ARGUMENT;                                                                    \
    }                                                                                              \
    _Static_assert(DG_ERR_ARGUMENT != 0, "there is nothing to mount")

/** In the same file: `init`, `power_on`, `power_off` and `model` of a protocol whose functions
 * begin with `name` and take a struct of that name. What it is made of is its member `setup`, which
 * a static function own() makes of what is handed over. */
#define DG_STACK_FORWARD(name)                                                                     \
    static int init(void *self, const struct dg_stack_setup *setup)                                \
    {                                                                                              \
        const struct name##_setup mine = own(setup);                                               \
                                                                                                   \
        return name##_init(self, &mine);                                                           \
    }                                                                                              \
                                                                                                   \
    static int power_on(void *self, dg_ns now)                                                     \
    {                                                                                              \
        return name##_power_on(self, now);                                                         \
    }                                                                                              \
                                                                                                   \
    static void power_off(void *self)                                                              \
    {                                                                                              \
        name##_power_off(self);                                                                    \
    }                                                                                              \
                                                                                                   \
    static const void *model(const void *self)                                                     \
    {                                                                                              \
        const struct name *device = self;                                                          \
                                                                                                   \
        return device->setup.model;                                                                \
    }                                                                                              \
    _Static_assert(_Alignof(struct name) <= _Alignof(max_align_t), "as device_size promises")

/** Numbers in a device that it goes by: an index, a divisor, a bool that is a bool. */
struct dg_stack_range {
    uint16_t offset; /**< of the first one */
    uint8_t size;    /**< of each: 1, 2 or 4 bytes */
    uint8_t count;
    uint32_t min;
    uint32_t max;
};
/** A row for one member, and for a bool. */
#define DG_STACK_RANGE(type, member, min, max)                                                     \
    {                                                                                              \
        offsetof(struct type, member), sizeof(((struct type *)0)->member), 1, min, max             \
    }
#define DG_STACK_BOOL(type, member) DG_STACK_RANGE(type, member, 0, 1)

/** What is looked at before a state is believed: the check sum of one says who damaged it, not who
 * made it. Bytes are at any address, pointers in them are NULL. */
struct dg_stack_check {
    const struct dg_stack_range *ranges; /**< of the device */
    size_t count;
    /** Whether the numbers fit together, each in its range, the settings in those of their keys.
     * @param own settings that these take the place of, of the same model */
    bool (*fits)(const void *own, const void *settings, const void *device);
};

/** An encoder as it can be ordered. */
struct dg_device {
    const char *name;       /**< as on the command line, e.g. "s3684-rs485" */
    const char *wire;       /**< what it speaks, e.g. "RS485 + SinCos (HIPERFACE-compatible)" */
    const char *resolution; /**< in words, e.g. "2048 periods x 32 steps, 4096 turns" */
    const struct dg_stack *stack;
    const void *model; /**< of the stack's own kind; typed by dg_hf_model_of() and its like */
    size_t more;       /**< bytes behind the stack's device_size that one of this model takes */
};

#ifdef __cplusplus
}
#endif

#endif
