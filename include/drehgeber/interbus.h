/* SPDX-License-Identifier: MIT */
/**
 * @file
 * OCD absolute encoders with INTERBUS (ENCOM profiles K1, K2, K3), each for itself; the ring that
 * they stand in is bus_words.h. Source: manual UMD OCD IB 11/03, chapters 2, 3.3, 5 and 9; what it
 * leaves open is decided in src/interbus/README.md, 'Inaccuracies and choices'. It is emulated at
 * the level of process data: words and time go in, words come out. Bits on the wire are not.
 *
 * A data cycle n exchanges both directions at once, so that IN(n) cannot depend on OUT(n):
 *
 *   OUT  00000000 020000FF 020000FF 020000FF 020000FF 80000000 80000000
 *   IN   position position position position C20000FF C20000FF position
 *                 |<- param_cycles = 3 ---->|         |<- 1 ->|
 *
 * Due commands are executed first, then IN is latched at `now`, then OUT is sampled. All state
 * lives in the caller's structs; any number can live side by side. Nothing here blocks except the
 * memory's operations.
 */
#ifndef DREHGEBER_INTERBUS_H
#define DREHGEBER_INTERBUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/hal.h"
#include "drehgeber/key.h"
#include "drehgeber/quantity.h"
#include "drehgeber/stack.h"
#include "drehgeber/store.h"
#include "drehgeber/time.h"
#include "drehgeber/world.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_instrument;
struct dg_model_text;
struct dg_words;

/** Cam programs, and cams of each (5.4.4). */
#define DG_IB_PROGRAMS 8u
#define DG_IB_CAMS 8u
/** Widest position: 25 bits (2.1.3). */
#define DG_IB_DATA_MASK 0x01FFFFFFu
/** Most steps of the discs a turn, and most turns. */
#define DG_IB_STEPS_MAX 8192u
#define DG_IB_TURNS_MAX 4096u
/** Registers of the protocol chip in the read-out mode (5.4.3). */
#define DG_IB_OPC_REGISTERS 16u
/** So long after the last cycle the master counts as gone (LEDs). */
#define DG_IB_BUS_TIMEOUT DG_MS(100)
/** Half a period of a blinking LED. */
#define DG_IB_BLINK DG_MS(500)

/** ENCOM profiles (2.1). */
enum dg_ib_profile {
    DG_IB_K1, /**< 16 bit IN, right-aligned; ID word 0136h */
    DG_IB_K2, /**< 32 bit IN, right-aligned; ID word 0236h */
    DG_IB_K3, /**< 32 bit IN and OUT: 7 status or control bits, 25 data bits; ID word 0237h */
    DG_IB_PROFILE_COUNT
};

/**
 * Words of a K3 beside position and answers (9.3, 9.4, 9.6): data out of range; no such command in
 * this mode; stored parameter lost, or it could not be stored; cam edge above the largest position;
 * self-test and read-out; no such item (bits 24..0 of the command are added); no valid position.
 */
#define DG_IB_ILLEGAL_DATA 0x82000000u
#define DG_IB_UNKNOWN_CODE 0x84000000u
#define DG_IB_LOST 0x86000000u
#define DG_IB_CAM_POSITION 0x98000004u
#define DG_IB_READ_OUT 0xA0000000u
#define DG_IB_UNKNOWN_ITEM 0xA4000000u
#define DG_IB_NOT_VALID 0x80000000u

/** Modes; the values that 20210009h answers (9.2). Program p = 1..8 is DG_IB_CAM + p. */
enum dg_ib_mode {
    DG_IB_POSITION_K2 = 0, /**< position of a K1 or K2 */
    DG_IB_POSITION = 1,
    DG_IB_SPEED = 2,
    DG_IB_CAM = 2,
};

/** EEPROM regions of a K3; the row of dg_ib_layout.regions with the same index. */
enum dg_ib_region {
    DG_IB_REGION_STEPS,       /**< "steps": 4 bytes, most significant first */
    DG_IB_REGION_REVOLUTIONS, /**< "revolutions": 4 bytes */
    DG_IB_REGION_DIRECTION,   /**< "direction": 3 or 4 */
    DG_IB_REGION_PRESET,      /**< "preset": preset 4 bytes, offset 4 bytes, preset flag */
    DG_IB_REGION_SHIFT,       /**< "shift": 4 bytes */
    DG_IB_REGION_MODE,        /**< "mode": start-up mode, enum dg_ib_mode */
    DG_IB_REGION_SHIFT_IW,    /**< "shift-iw": 0..25 */
    DG_IB_REGION_CAMS,        /**< "cams-1" to "cams-8": 8 regions */
    DG_IB_REGION_TIME =
        DG_IB_REGION_CAMS + 8, /**< "time": operating time; its damage is no error */
    DG_IB_REGION_COUNT
};

/** The EEPROM table of a K3. K1 and K2 have no memory. */
DG_API extern const struct dg_store_layout dg_ib_layout;

/** What a model is. Every figure is configuration; src/devices has the models of the manual. */
struct dg_ib_model {
    enum dg_ib_profile profile;
    bool loop;            /**< INTERBUS Loop: class byte B2h or B3h instead of 36h or 37h (2.2) */
    uint16_t steps;       /**< per turn, 1..8192 */
    uint16_t turns;       /**< 1: singleturn; 1..4096. A K1 has at most 65536 steps in all */
    bool steps_minus_one; /**< K3: one step more than the parameter says; 2021000Ah bit 0 */
    bool temperature_sensor; /**< K3: fitted; without, 2021000Ch answers A421000Ch */
    uint8_t param_cycles;    /**< K3: cycles a command stands before its answer, 1..255 */
    uint8_t id_code;         /**< class byte of the ID word; 0: that of profile and loop (2.2) */
    uint32_t serial;         /**< 20210000h, 25 bits */
    uint32_t version;        /**< 20210007h, 25 bits */
    dg_ns self_test;         /**< after power-on, 0..1 s */
    const struct dg_store_layout *layout; /**< of a K3's EEPROM: its first regions are those of
                                               dg_ib_layout; NULL: that one. See model.h */
};

/** What a device is made of. Everything pointed to must outlive the device. */
struct dg_ib_setup {
    const struct dg_ib_model *model;
    const struct dg_world *world;
    struct dg_nvm nvm; /**< not used by K1 and K2 */
};

/** Things nobody has to act on; they only count up. */
struct dg_ib_counters {
    uint32_t cycles;         /**< data cycles with valid data */
    uint32_t commands;       /**< commands accepted */
    uint32_t refused;        /**< commands answered with an error */
    uint32_t dropped;        /**< commands that changed before they were handled */
    uint32_t presets_unset;  /**< 40000000h without the preset flag, 60000000h with a lost preset */
    uint32_t releases_stale; /**< 80000000h without a rising edge of bit 31 */
    uint32_t crc_errors;     /**< transmission errors found here */
};

/** A cam program: cam n is on in on[n] <= position < off[n], through zero when on[n] > off[n]. */
struct dg_ib_program {
    uint32_t on[DG_IB_CAMS];
    uint32_t off[DG_IB_CAMS];
    uint8_t mask;      /**< bit n: cam n is activated */
    uint8_t on_given;  /**< bit n: on[n] was set; without both edges a cam reads 0 */
    uint8_t off_given; /**< likewise off[n] */
};

/**
 * Parameters that were sent and not released yet (I22). The read-out, the position and the EEPROM
 * do not know what waits; without power it is gone.
 */
struct dg_ib_sent {
    uint32_t steps;
    uint32_t revolutions;
    uint32_t preset;
    uint32_t shift;
    uint8_t waits;  /**< bit n: the value of region n above waits for the release */
    uint8_t judged; /**< bit n: region n was accepted since the last release, stored or waiting */
};

/**
 * A device. Caller-owned plain data without pointers into itself: it can be copied, compared and
 * replayed. The fields are readable for tests and displays; only this module writes them, but for
 * `opc` and `reconfigure`, which are also the host's after dg_ib_init().
 */
struct dg_ib {
    struct dg_ib_setup setup;
    struct dg_store store;
    struct dg_ib_counters counters;
    uint8_t opc[DG_IB_OPC_REGISTERS]; /**< 202100xDh; 12: class byte, the rest 0 */

    /* bus */
    bool powered;
    bool mounted;      /**< the EEPROM could be read at the start */
    bool reconfigure;  /**< message bits of the next ID cycle */
    bool crc_error;    /**< likewise */
    bool outgoing_off; /**< outgoing bus switched off (LED RD) */
    bool invalid;      /**< the last IN had no valid position; of a K1 and K2: module error */
    dg_ns ready_at;    /**< end of the self-test */
    dg_ns last_id;     /**< last ID cycle; DG_NEVER: none since power-on */
    dg_ns last_data;   /**< last data cycle, likewise */

    /* commands */
    uint32_t out;          /**< last OUT sampled */
    uint32_t pending;      /**< command not handled yet */
    uint8_t wait;          /**< cycles until it is handled; 0: none */
    bool sampled;          /**< `out` was on the bus since power-on */
    bool frozen;           /**< 60000000h stands on the bus */
    uint32_t answer;       /**< parameter answer or error held in IN; 0: in operation */
    uint32_t item;         /**< read-out command in force; 0: none */
    uint32_t last_command; /**< last one handled */
    uint32_t last_error;   /**< last error answered, 0: none since power-on */
    uint32_t lost;         /**< bit n: region n was found damaged and not set since */
    struct dg_ib_sent sent;

    /* parameters: working copy of the EEPROM */
    uint32_t steps;       /**< as sent; one more are in force with steps_minus_one */
    uint32_t revolutions; /**< that these steps are spread over */
    uint32_t preset;
    uint32_t offset; /**< makes the preset's position; added before the shift */
    uint32_t shift;  /**< zero shift */
    uint8_t direction;
    bool preset_flag; /**< a preset was set and not activated yet */
    uint8_t mode;     /**< enum dg_ib_mode */
    uint8_t shift_iw;
    uint8_t program_number;       /**< 1..8: selected last, 1 before the first */
    struct dg_ib_program program; /**< that one; in cam mode the one in force */
    uint32_t time_10min;          /**< operating time up to `time_mark` */
    dg_ns time_mark;
};

/**
 * Burn the delivery state of a K3 into a memory. K1 and K2 have none: nothing is done.
 * @return 0; DG_ERR_ARGUMENT when a figure of the model is out of range; DG_ERR_IO
 */
DG_API int dg_ib_format(const struct dg_ib_model *model, struct dg_nvm nvm);

/**
 * Make a device, without power. The memory is not touched.
 * @return 0 or DG_ERR_ARGUMENT (a pointer is missing, a figure is out of range)
 */
DG_API int dg_ib_init(struct dg_ib *self, const struct dg_ib_setup *setup);

/**
 * Switch the power on: mount the EEPROM, begin the self-test. Also from the powered state.
 * Until `now` + model->self_test IN is A0000000h (K3) or 0 with a module error (K1, K2), and OUT is
 * not looked at; then the stored start-up mode is in force, no release needed.
 * @return 0, also with damaged regions or a silent EEPROM: IN is then 86000000h until 0E000000h is
 *         accepted or every lost parameter was sent again. DG_ERR_BLANK or DG_ERR_FOREIGN: not this
 *         device's memory; it stays off.
 */
DG_API int dg_ib_power_on(struct dg_ib *self, dg_ns now);

/** Switch the power off. What was not answered, and what waited for the release, is lost. */
DG_API void dg_ib_power_off(struct dg_ib *self);

/**
 * One data cycle with valid data. `out` of a K1 or K2 is not looked at. A K1's IN is bits 15..0.
 *
 * A word whose bits 31..25 are not 0 is a command when it differs from the OUT before it; after a
 * word with these bits 0 the same word is a command again. Release, both presets and the end of the
 * read-out act in the next cycle, the rest after model->param_cycles cycles, when it is checked,
 * stored and answered. It has to stand until then; a word that takes its place begins anew.
 *
 * Commands (9.1, 9.2, 9.5), P position and speed mode, C cam mode:
 *
 *   00xxxxxx      PC   normal operation; with bit 16 = 0 (as in every word) it ends the read-out
 *   80000000      PC   release, on the rising edge of bit 31: ends parameter state and errors, puts
 *                      steps and revolutions in force
 *   40000000      P    the preset, once for every 08xxxxxxh; the position is the preset then
 *   60000000      P    the preset, for as long as it stands
 *   02 04 06 08   PC   steps, revolutions, direction 3 or 4, preset
 *   0A 0E         PC   zero shift, default parameters: of the profile, and whatever was lost
 *   20400000/1    P    position mode, speed mode
 *   2080000p      PC   cam program p, 0: position mode
 *   2021xxxx      PC   read-out of item xxxx
 *   2040mmmm      C    mask of the cams
 *   201000xx      PC   shift_iw, one for all programs
 *   2020000x..    PC   read-backs: 00 mask, 1n and 2n edges of cam n, 30 and 40 shift_iw; of the
 *                      program selected last
 *   4nvvvvvv 6n.. C    edges on and off of cam n (bits 28..25)
 *
 * An accepted command is answered with OUT and bits 31, 30 set, held until the next answer or the
 * release; read-out and read-backs with A0000000h + value (read-backs held likewise, the read-out
 * live); presets with nothing. A refused one changes nothing and is answered with an error:
 * data of 02..0E and shift_iw 82000000h, cam edges 98000004h, an item A4000000h + item, all else
 * 84000000h.
 *
 * The answers to steps and revolutions are unchecked against each other: the pair, and each preset
 * and shift sent since the last release, is judged at the release, then stored in one commit. If it
 * is not allowed, the release is answered with 82000000h and all that waited is dropped; the next
 * release leaves that error.
 *
 * In operation IN is the position, the speed in rpm (25 bits two's complement, rounded to the
 * nearest), or the cam word; bit 31 says that there is no valid position.
 * @param in left as it is without power
 */
DG_API void dg_ib_cycle(struct dg_ib *self, dg_ns now, uint32_t out, uint32_t *in);

/** After a cycle at `now`: until when further ones with the same OUT only count and latch. Of those
 * before that moment it is enough to run the last one and to count the others. What is done to the
 * device or its world ends it. @return `now`: not even the next one; DG_NEVER */
DG_API dg_ns dg_ib_quiet(const struct dg_ib *self, dg_ns now);

/** Position as a cycle would latch it at `now`, scaled, regardless of errors and mode. */
DG_API uint32_t dg_ib_position(const struct dg_ib *self, dg_ns now);

/** Steps of the whole range R: positions are 0..R-1. */
DG_API uint32_t dg_ib_range(const struct dg_ib *self);

/**
 * The device's part of an ID cycle: bit 15 reconfiguration request, 14 CRC error since the last ID
 * cycle, 13 module error, 12..8 length code, 7..0 class. Reported messages are cleared.
 */
DG_API uint16_t dg_ib_id(struct dg_ib *self, dg_ns now);

/** The ID word without messages, from the model alone. */
DG_API uint16_t dg_ib_id_word(const struct dg_ib_model *model);

/** Whether a K1 or K2 tells a module error, bit 13 of its ID word (I19); as its latest cycle found
 * it. */
DG_API bool dg_ib_module_error(const struct dg_ib *self);

/** Data words of a device in either image: 1 for a K1, 2 for K2 and K3. */
DG_API uint8_t dg_ib_image_words(const struct dg_ib_model *model);

/** LEDs (3.3); several of them, so bits. DG_IB_LED_BA says lit at this moment. */
enum dg_ib_led {
    DG_IB_LED_UL = 1,        /**< supply */
    DG_IB_LED_RC = 2,        /**< a cycle of either kind within DG_IB_BUS_TIMEOUT */
    DG_IB_LED_BA = 4,        /**< data cycles run: on. Suspended, only ID cycles come: blinks */
    DG_IB_LED_RD = 8,        /**< the outgoing bus is switched off */
    DG_IB_LED_BA_BLINKS = 16 /**< BA is in its blinking state, lit or not */
};

/** The LEDs at `now`: enum dg_ib_led, combined. Without power 0. */
DG_API uint8_t dg_ib_leds(const struct dg_ib *self, dg_ns now);

/** Most encoders in a ring: DG_RING_MAX of bus_words.h, for who knows no bus. */
#define DG_IB_RING_MAX 512u

/** Bit times of a data cycle of n bytes and m devices: 13 * (6 + n) + 4 * m. */
DG_API uint32_t dg_ib_bit_times(uint32_t bytes, uint32_t devices);

/** Cycle time of a ring whose images have `words` words: its bit times at `baud` (500000 or
 * 2000000) plus the master's time. */
DG_API dg_ns dg_ib_cycle_time(uint32_t words, uint32_t devices, uint32_t baud, dg_ns software);

/** The protocol: models are struct dg_ib_model, devices struct dg_ib; setup.port is not looked at.
 */
DG_API extern const struct dg_stack dg_ib_stack;
/** What is looked at before a state of one is believed, see stack.h. */
DG_API extern const struct dg_stack_check dg_ib_check;
/** Its models in src/devices: by ENCOM profile. */
DG_API extern const struct dg_device dg_ocd_ib_k1, dg_ocd_ib_k2, dg_ocd_ib_k3;
/** What a text can say of its models, see model.h; an object file of its own. */
DG_API extern const struct dg_model_text dg_ib_model_text;
/** The protocol as an instrument, see instrument.h; an object file of its own. */
DG_API extern const struct dg_instrument dg_ib_instrument;
/** What goes over its wire in words, see words.h; an object file of its own. */
DG_API extern const struct dg_words dg_ib_words;

/** What can be set of a struct dg_ib_model, for hosts. */
DG_API extern const struct dg_keys dg_ib_keys;

/** Bit n: it does not sense enum dg_quantity_id n; as in dg_host_wire. */
#define DG_IB_BLIND                                                                                \
    (((UINT32_C(1) << DG_QUANTITY_COUNT) - 1u) &                                                   \
     ~(DG_IB_SENSED(TEMPERATURE) | DG_IB_SENSED(SINGLETURN) | DG_IB_SENSED(MULTITURN_AMPLITUDE) |  \
       DG_IB_SENSED(MULTITURN_SYNC) | DG_IB_SENSED(MULTITURN_VECTOR) | DG_IB_SENSED(EEPROM)))
/** A bit of what it senses. */
#define DG_IB_SENSED(id) (UINT32_C(1) << DG_QUANTITY_##id)

/** The figures of a model of this stack; NULL when it is of another one. */
DG_API const struct dg_ib_model *dg_ib_model_of(const struct dg_device *device);

#ifdef __cplusplus
}
#endif

#endif
