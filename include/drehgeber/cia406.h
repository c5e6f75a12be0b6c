/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Kübler F36x8 CANopen: what the encoder adds to a CANopen node. Source: manual F36x8 CANopen,
 * chapters 10 to 15, 20 to 26 and 29; decisions in src/cia406/README.md.
 *
 * Counts are physical counts of 1/65536 turn ("unscaled"); units are what 6004h shows. All
 * arithmetic is exact in integers.
 */
#ifndef DREHGEBER_CIA406_H
#define DREHGEBER_CIA406_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/canopen.h"
#include "drehgeber/eds.h"
#include "drehgeber/key.h"
#include "drehgeber/stack.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_instrument;
struct dg_model_file;
struct dg_words;

/** Physical counts a turn (STA_U): 16 bit. */
#define DG_CIA406_STEPS 65536u
/** Node-ID as delivered (chapter 8), and the last one. */
#define DG_CIA406_NODE_DEFAULT 63u
#define DG_CIA406_NODE_MAX 127u

/** What a model is; every figure is configuration. */
struct dg_cia406_model {
    uint32_t turns;                    /**< MTA_U: 1 (singleturn) .. 65536; a power of two */
    const struct dg_co_device *device; /**< identity and dictionary */
    uint32_t password;                 /**< opens 300Bh, see 300Ah */
};

/** Bits of 6000h (chapter 26). */
enum dg_cia406_parameters {
    DG_CIA406_CCW = 0x0001,         /**< ascending counterclockwise */
    DG_CIA406_SCALING = 0x0004,     /**< 6001h and 6002h are in force */
    DG_CIA406_USF = 0x1000,         /**< universal scaling function */
    DG_CIA406_UNITS_PER_S = 0x2000, /**< 6030h in units/s instead of rpm */
    DG_CIA406_OPERATIONAL = 0x4000, /**< boots into Operational */
    DG_CIA406_EVENT_MODE = 0x8000,  /**< TPDOs of types 0, 254, 255 on every change of a position */
    DG_CIA406_WRITABLE = 0xF00F,    /**< the bits above, and 1 and 3, which have no effect */
};

/** What drives the two LEDs, later ones win (chapter 29). */
enum dg_cia406_lamp {
    DG_CIA406_LAMP_OFF,
    DG_CIA406_LAMP_ON,
    DG_CIA406_LAMP_BLINK,      /**< 250 ms on, 250 ms off */
    DG_CIA406_LAMP_SLOW,       /**< 1 s on, 1 s off */
    DG_CIA406_LAMP_FAST,       /**< 50 ms on, 50 ms off */
    DG_CIA406_LAMP_FAST_OTHER, /**< the same in opposite phase */
    DG_CIA406_LAMP_300,        /**< 300 ms on, 300 ms off */
    DG_CIA406_LAMP_COUNT
};

/** Both LEDs: the pattern, and whether they are lit at this moment. */
struct dg_cia406_leds {
    enum dg_cia406_lamp bus_pattern; /**< green */
    enum dg_cia406_lamp err_pattern; /**< red */
    bool bus;
    bool err;
};

/** dg_cia406.calm_ms: supervision is left out until the encoder is called, as it cannot find
 * anything new (world.h, `calm`). */
#define DG_CIA406_ASLEEP 0xFFFFu

/** An encoder behind a node: dg_co_setup.application points to it. Caller-owned plain data. */
struct dg_cia406 {
    const struct dg_cia406_model *model;
    uint32_t raw;        /**< physical position of the latest sample, 0..turns * steps - 1 */
    uint32_t zero;       /**< USF: physical position of the internal zero */
    uint64_t zero_y;     /**< USF: position there in 1/65536 unit, modulo TMR * 65536 */
    uint64_t y;          /**< position in 1/65536 unit while 6000h-6002h are written */
    bool usf_lost;       /**< the stored offset did not verify: a preset is due */
    bool zero_unsaved;   /**< USF: the internal zero could not be stored yet */
    dg_ns look_at;       /**< next supervision; asleep: the one that was left out first */
    dg_ns event_at;      /**< event mode: when the mapped values are compared next */
    dg_ns time_from;     /**< operating time is counted from here on */
    uint32_t time_10h;   /**< 6508h: operating time in 0.1 h */
    dg_ns flash_until;   /**< the error LED flashes until then */
    dg_ns locked_until;  /**< 300Ah refuses until then */
    uint8_t wrong_count; /**< wrong passwords in a row */
    bool serial_open;    /**< 300Bh may be written once */
    uint16_t calm_ms;    /**< so long supervision has found a calm shaft, or DG_CIA406_ASLEEP */
};

/**
 * A node with the encoder behind it: a device of dg_cia406_stack. The node points to the encoder,
 * so that a copy is to be attached (dg_stack.attach).
 */
struct dg_cia406_device {
    struct dg_co_node node;
    struct dg_cia406 encoder;
};

/** The singleturn device, the multiturn device with 4096 and the one with 65536 turns. */
DG_API extern const struct dg_co_device dg_cia406_singleturn;
DG_API extern const struct dg_co_device dg_cia406_multiturn;
DG_API extern const struct dg_co_device dg_cia406_multiturn_32;

/** Make an encoder. @return 0 or DG_ERR_ARGUMENT */
DG_API int dg_cia406_init(struct dg_cia406 *self, const struct dg_cia406_model *model);

/** What the EDS file of one of these devices says beside its dictionary, for dg_co_eds(); NULL:
 * none of them. */
DG_API const struct dg_co_sheet *dg_cia406_sheet(const struct dg_co_device *device);
/** The same of a model as it is delivered; NULL: it is none of these. */
DG_API const struct dg_co_sheet *dg_cia406_sheet_of(const struct dg_device *model);

/** What the LEDs show at node->now. `node` is a node of this profile. */
DG_API struct dg_cia406_leds dg_cia406_leds(const struct dg_co_node *node);

/** 6004h as a sample at `now` would have it. `node` is a node of this profile; it takes no sample.
 */
DG_API uint32_t dg_cia406_position(const struct dg_co_node *node, dg_ns now);

/** The protocol: models are struct dg_cia406_model, devices struct dg_cia406_device; setup.port is
 * a struct dg_co_ops. */
DG_API extern const struct dg_stack dg_cia406_stack;
/** What is looked at before a state of one is believed, see stack.h. */
DG_API extern const struct dg_stack_check dg_cia406_check;
/** Its models in src/devices: singleturn, multiturn. */
DG_API extern const struct dg_device dg_f3658, dg_f3668;
/** The protocol as an instrument, see instrument.h; an object file of its own. */
DG_API extern const struct dg_instrument dg_cia406_instrument;
/** What goes over its wire in words, see words.h; an object file of its own. */
DG_API extern const struct dg_words dg_cia406_words;

/* ---------------------------------------------------------------- from an EDS file */

/** An encoder from an EDS file: what is read into the memory of the host lasts as long as this. */
struct dg_cia406_file {
    struct dg_co_file file; /**< first: what computes finds the figures by the node's device */
    uint32_t steps;         /**< a turn, 6501h */
    uint32_t turns;         /**< 6502h; steps * turns is at most 2^32 */
    struct dg_cia406_model model;
    struct dg_device device; /**< a model as all others */
    char name[33];           /**< its name: ProductName in letters that names have */
    char resolution[33];
};

/**
 * Read the EDS or DCF file of an encoder. One with the identity of a built-in encoder behaves as
 * that, with its manufacturer's objects; any other one as the encoder profile has it.
 * @return as dg_co_read()
 */
DG_API int dg_cia406_read(struct dg_cia406_file *self, const struct dg_eds_setup *setup,
                          struct dg_eds_note *error);

/** What files are put on that are none of a built-in encoder: objects of the profile, and nothing
 * of a manufacturer. Its node's device is a struct dg_cia406_file. */
DG_API extern const struct dg_co_device dg_cia406_any;

/** Causes of EMCYs beyond the stack's. */
#define DG_CIA406_CAUSES 9u
/** dg_co_device.causes of all these devices. */
DG_API extern const struct dg_co_cause dg_cia406_causes[DG_CIA406_CAUSES];

/** Regions of a layout behind DG_CO_STORE_REGIONS(): what 1010h keeps is so many bytes. */
#define DG_CIA406_STORE_REGIONS(size)                                                              \
    [DG_CO_REGION_APPLICATION] = {"profile", (size), DG_STORE_CHECKED, 0, NULL},                   \
    [DG_CO_REGION_APPLICATION + 1] = {"usf", 21, DG_STORE_CHECKED, 0, dg_cia406_default_usf},      \
    [DG_CO_REGION_APPLICATION + 2] = {"time", 4, DG_STORE_CHECKED, 0, dg_cia406_default_time}
/** Default of the region "usf": nothing is scaled. */
DG_API void dg_cia406_default_usf(const void *ctx, uint8_t *out);
/** Default of the region "time": none has passed. */
DG_API void dg_cia406_default_time(const void *ctx, uint8_t *out);

/** Names of the profile's values, in their order, as DG_CO_VALUES() of eds_rows.h. */
#define DG_CIA406_VALUES(VALUE)                                                                    \
    VALUE(PARAMETERS)                                                                              \
    VALUE(MUR)                                                                                     \
    VALUE(TMR)                                                                                     \
    VALUE(PRESET)                                                                                  \
    VALUE(OFFSET)                                                                                  \
    VALUE(SPEED_SOURCE)                                                                            \
    VALUE(SPEED_WINDOW_MS)                                                                         \
    VALUE(SPEED_MULTIPLIER)                                                                        \
    VALUE(SPEED_DIVISOR)                                                                           \
    VALUE(LOW_1)                                                                                   \
    VALUE(LOW_2)                                                                                   \
    VALUE(HIGH_1)                                                                                  \
    VALUE(HIGH_2)                                                                                  \
    VALUE(TEMPERATURE_LOW)                                                                         \
    VALUE(TEMPERATURE_HIGH)                                                                        \
    VALUE(CUSTOMER_1)                                                                              \
    VALUE(CUSTOMER_2)                                                                              \
    VALUE(CUSTOMER_3)                                                                              \
    VALUE(CUSTOMER_4)                                                                              \
    VALUE(POSITION)                                                                                \
    VALUE(TURN_BITS)                                                                               \
    VALUE(TURNS)                                                                                   \
    VALUE(LAST)

/** Slots of rows with DG_CO_SLOT. */
enum dg_cia406_value {
    DG_CIA406_VALUE_BEFORE = DG_CO_SLOT_APPLICATION - 1,
#define DG_CIA406_VALUE(name) DG_CIA406_VALUE_##name,
    DG_CIA406_VALUES(DG_CIA406_VALUE)
#undef DG_CIA406_VALUE
        DG_CIA406_VALUE_END
};

/** The same behind the seam of all protocols, see model.h; an object file of its own. */
DG_API extern const struct dg_model_file dg_cia406_model_file;

/** What can be set of an encoder before it is made. */
struct dg_cia406_settings {
    struct dg_cia406_model model;
    uint32_t serial; /**< of a new EEPROM; so is the next one */
    uint32_t node;
    bool wide; /**< 16 bits of turns, not 12; nothing for a singleturn */
};

/** The keys of a struct dg_cia406_settings, for hosts. */
DG_API extern const struct dg_keys dg_cia406_keys;

/** Bit n: encoders of `model` have not row n of dg_cia406_keys: a singleturn has no turns. */
DG_API uint32_t dg_cia406_without(const struct dg_cia406_model *model);

/** `self` becomes the settings of `model` as delivered. */
DG_API void dg_cia406_settings_init(struct dg_cia406_settings *self,
                                    const struct dg_cia406_model *model);

/** All are set: self->model becomes that of an encoder with them. */
DG_API void dg_cia406_settings_apply(struct dg_cia406_settings *self);

/** The figures of a model of this stack; NULL when it is of another one. */
DG_API const struct dg_cia406_model *dg_cia406_model_of(const struct dg_device *device);

#ifdef __cplusplus
}
#endif

#endif
