/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An absolute encoder with SSI, the synchronous serial interface: one slave, edge for edge. There
 * is no standard; the sources are public descriptions by makers of encoders and masters, named in
 * src/ssi/README.md, and what they leave open is decided there, 'Inaccuracies and choices'.
 *
 * Levels and time go in, levels come out:
 *
 *   clock ¯¯|__|¯¯|__|¯¯|__|¯ ... ¯|__|¯¯|__|¯¯¯¯¯¯¯¯¯¯¯¯¯
 *           f1 r1    r2    r3         rn    rn+1
 *   data  ¯¯¯¯¯|MSB  |     |   ...    |LSB  |_______|¯¯¯¯¯
 *           ^ position stored               |<-tm ->| from the last falling edge
 *
 * Data moves on rising edges only. Within the monoflop time tm the word stands still: whoever
 * clocks on gets it again, with a 0 between its last bit and its first one. After tm without a
 * falling edge data is high, and the next falling edge stores the position anew.
 *
 * The host calls dg_ssi_clock() for every edge of the clock and dg_ssi_step() at the moment that it
 * returned; a host that cannot be on time calls late, the result is the same. A host whose hardware
 * shifts whole words uses dg_ssi_frame(). A master takes a word apart by dg_ssi_frame_decode().
 *
 * All state lives in the caller's struct dg_ssi; any number can live side by side. There is no
 * EEPROM, and nothing here blocks.
 */
#ifndef DREHGEBER_SSI_H
#define DREHGEBER_SSI_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/form.h"
#include "drehgeber/hal.h"
#include "drehgeber/key.h"
#include "drehgeber/stack.h"
#include "drehgeber/time.h"
#include "drehgeber/world.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_instrument;
struct dg_master_protocol;
struct dg_model_text;

/** Monoflop time: as most encoders have it, and what dg_ssi_init() takes. Encoders have 10 to 30
 * us; longer ones are for lines slower than SSI is. */
#define DG_SSI_MONOFLOP_NS DG_US(20)
#define DG_SSI_MONOFLOP_MIN_NS DG_US(10)
#define DG_SSI_MONOFLOP_MAX_NS DG_S(1)
/** Clock period at 2 MHz: shorter ones are answered, and counted. */
#define DG_SSI_PERIOD_MIN_NS ((dg_ns)500)
/** Width of a position, multiturn and singleturn together, and of its parts; in words of another
 * form it may have any up to DG_SSI_FORM_BITS_MAX, with all bits around it. */
#define DG_SSI_BITS_MIN 10u
#define DG_SSI_BITS_MAX 32u
#define DG_SSI_MULTITURN_BITS_MAX 24u
#define DG_SSI_SINGLETURN_BITS_MIN 8u
#define DG_SSI_SINGLETURN_BITS_MAX 31u
#define DG_SSI_FORM_BITS_MAX 64u
/** In these, the parts of a position: 0 or more, and 1 or more. */
#define DG_SSI_FORM_PART_BITS_MAX 32u
/** Longest word without a form: a position, error bit and parity bit. */
#define DG_SSI_WORD_BITS_MAX (DG_SSI_BITS_MAX + 2u)

/** Limits behind the error bit. */
#define DG_SSI_LED_MAX_UA 30000u
#define DG_SSI_AMPLITUDE_MIN_PERMILLE 600u
#define DG_SSI_AMPLITUDE_MAX_PERMILLE 1400u
#define DG_SSI_OFFSET_MAX_PERMILLE 100
#define DG_SSI_TEMPERATURE_MIN_MDEGC (-40000)
#define DG_SSI_TEMPERATURE_MAX_MDEGC 100000
#define DG_SSI_SUPPLY_MIN_MV 4750u

/** What sets the error bit, each with its cause in struct dg_world; set while its cause lasts. */
enum dg_ssi_error {
    DG_SSI_LIGHT = 0x01,       /**< led_current_ua above DG_SSI_LED_MAX_UA */
    DG_SSI_SIGNAL = 0x02,      /**< a sin/cos amplitude or offset outside its limits */
    DG_SSI_TEMPERATURE = 0x04, /**< temperature_mdegc outside its limits */
    DG_SSI_SUPPLY = 0x08,      /**< supply_mv below DG_SSI_SUPPLY_MIN_MV */
    DG_SSI_SINGLETURN = 0x10,  /**< singleturn_ok is false */
    DG_SSI_MULTITURN = 0x20, /**< one of multiturn_*_ok is false; models with multiturn bits only */
    DG_SSI_SYSTEM = 0x40,    /**< watchdog_fired */
};

/** How the position is coded, all of it as one number. */
enum dg_ssi_code { DG_SSI_GRAY, DG_SSI_BINARY, DG_SSI_CODE_COUNT };

/** The bit behind the position. */
enum dg_ssi_error_bit {
    DG_SSI_ERROR_NONE, /**< there is none */
    DG_SSI_ERROR_HIGH, /**< 1 is an error */
    DG_SSI_ERROR_LOW,  /**< 0 is an error */
    DG_SSI_ERROR_BIT_COUNT
};

/** The last bit of the word, over all bits before it as they are sent. */
enum dg_ssi_parity {
    DG_SSI_PARITY_NONE, /**< there is none */
    DG_SSI_PARITY_EVEN, /**< the ones of the word and this bit are an even number */
    DG_SSI_PARITY_ODD,  /**< an odd number */
    DG_SSI_PARITY_COUNT
};

struct dg_ssi_form;

/** What a model is. Every figure is configuration. */
struct dg_ssi_model {
    uint8_t multiturn_bits;  /**< 0..DG_SSI_MULTITURN_BITS_MAX */
    uint8_t singleturn_bits; /**< DG_SSI_SINGLETURN_BITS_MIN..DG_SSI_SINGLETURN_BITS_MAX; with the
                                  multiturn bits DG_SSI_BITS_MIN..DG_SSI_BITS_MAX */
    uint8_t code;            /**< enum dg_ssi_code */
    uint8_t error_bit;       /**< enum dg_ssi_error_bit */
    uint8_t parity;          /**< enum dg_ssi_parity */
    bool once;               /**< the word is sent once and zeros follow; otherwise it goes round */
    const struct dg_ssi_form *form; /**< words of another form; NULL: position, error bit, parity */
    dg_ns monoflop;                 /**< tm, DG_SSI_MONOFLOP_MIN_NS..DG_SSI_MONOFLOP_MAX_NS */
    dg_ns init;                     /**< after power-on: data is low, clocks are not answered */
};

/** What a device is made of. Everything pointed to must outlive the device. */
struct dg_ssi_setup {
    const struct dg_ssi_model *model;
    const struct dg_world *world;
};

/** Things nobody has to act on; they only count up. */
struct dg_ssi_counters {
    uint32_t frames;  /**< positions stored */
    uint32_t repeats; /**< words begun again within the monoflop time */
    uint32_t aborted; /**< words the monoflop time ended before their last bit */
    uint32_t fast;    /**< falling edges less than DG_SSI_PERIOD_MIN_NS behind the one before */
};

/** What the line automaton is doing. */
enum dg_ssi_state {
    DG_SSI_OFF,   /**< no power */
    DG_SSI_START, /**< initialising, or not yet tm without a falling edge since */
    DG_SSI_IDLE,  /**< the next falling edge stores the position */
    DG_SSI_SHIFT, /**< the word stands still and is shifted out */
    DG_SSI_STATE_COUNT
};

/**
 * A device. Caller-owned plain data without pointers into itself: it can be copied, compared and
 * replayed. The fields are readable for tests and displays; only this module writes them.
 */
struct dg_ssi {
    struct dg_ssi_setup setup;
    enum dg_ssi_state state;
    uint8_t bits; /**< of the word as stored last; 0: there was none */
    uint8_t left; /**< of these, still to come */
    bool clock;   /**< level of the clock line, which is the master's: power does not change it */
    bool data;    /**< level of the data line */
    struct dg_ssi_counters counters;
    uint64_t word;     /**< as stored last, right-aligned */
    uint64_t position; /**< as stored last: multiturn and singleturn, right-aligned, binary */
    dg_ns deadline;    /**< end of the initialisation or of tm, or DG_NEVER */
    dg_ns fell;        /**< the latest falling edge */
    dg_ns last;        /**< latest `now` */
};

/** A word taken apart. */
struct dg_ssi_frame {
    uint64_t position;   /**< multiturn and singleturn, right-aligned, binary */
    uint32_t multiturn;  /**< turns, 0 without multiturn bits */
    uint32_t singleturn; /**< counts in the turn */
    bool error;          /**< the error bit says that there is an error */
    bool toggle;         /**< the toggle bit, of a form that has one */
    bool power_fail;     /**< the bit for a supply that is too low, likewise */
};

/** Words of another form, of models that are texts: what makes them, and takes them apart. An
 * object of their own (src/ssi/form.c), so that an image without such models carries none of it. */
struct dg_ssi_form {
    /** Whether all figures are in their ranges. */
    bool (*fits)(const struct dg_ssi_model *model);
    /** As dg_ssi_position(). */
    uint64_t (*find_position)(const struct dg_ssi *self, dg_ns now);
    /** The word of what was stored. @param errors bits of enum dg_ssi_error @return its bits */
    uint8_t (*make_word)(const struct dg_ssi *self, uint8_t errors, uint64_t *word);
    /** As dg_ssi_frame_decode(). */
    int (*take_apart)(const struct dg_ssi_model *model, uint64_t bits, struct dg_ssi_frame *frame);
    char layout[DG_FORM_MAX + 1u]; /**< form.h; P: position, E: error, T: toggle, F: power fail, Y:
                                        parity */
    uint8_t parity_over; /**< 0: all bits in front of it, 1: the position as it is coded */
    bool error_parity;   /**< an error inverts the parity bit */
    uint8_t around;      /**< bits of the layout, those of the position not counted */
};

/** Whether all figures are in their ranges: dg_ssi_form.fits where words are as the layout says.
 * For models that are C, as `drehgeber model --c` writes them; they link src/ssi/form.c. */
DG_API bool dg_ssi_layout_fits(const struct dg_ssi_model *model);
/** dg_ssi_form.find_position of such a model. */
DG_API uint64_t dg_ssi_layout_find_position(const struct dg_ssi *self, dg_ns now);
/** dg_ssi_form.make_word of such a model. @return bits of the word, 1..64 */
DG_API uint8_t dg_ssi_layout_make_word(const struct dg_ssi *self, uint8_t errors, uint64_t *word);
/** dg_ssi_form.take_apart of such a model. @return 0 or DG_ERR_DAMAGED */
DG_API int dg_ssi_layout_take_apart(const struct dg_ssi_model *model, uint64_t bits,
                                    struct dg_ssi_frame *frame);

/**
 * Make a device, without power, the clock line high.
 * @return 0 or DG_ERR_ARGUMENT (a pointer is missing, a figure is out of range)
 */
DG_API int dg_ssi_init(struct dg_ssi *self, const struct dg_ssi_setup *setup);

/**
 * Switch the power on at `now`; data is low until the device is ready, after model->init and when
 * the clock has not fallen for a monoflop time. Also from the powered state: a power cycle.
 */
DG_API void dg_ssi_power_on(struct dg_ssi *self, dg_ns now);

/** Switch the power off. Data is low: nobody drives it. */
DG_API void dg_ssi_power_off(struct dg_ssi *self);

/**
 * The clock line is at `level` from `now` on; the same level again is no edge. A monoflop time that
 * ended at or before `now` comes first. Without power the level is only remembered.
 * @return the level of the data line
 */
DG_API bool dg_ssi_clock(struct dg_ssi *self, dg_ns now, bool level);

/**
 * Do what is due at `now`: the end of the monoflop time or of the start. May be called early
 * (nothing happens) or late.
 * @return when to call again; DG_NEVER when only an edge can change anything
 */
DG_API dg_ns dg_ssi_step(struct dg_ssi *self, dg_ns now);

/** Level of the data line. */
DG_API bool dg_ssi_data(const struct dg_ssi *self);

/**
 * A whole word at once, for hosts whose hardware shifts and keeps the monoflop time: store the
 * position at `now`, the first falling edge. Not to be mixed with dg_ssi_clock() inside a word.
 * @param bits the word, right-aligned
 * @return number of bits; 0 without power and while starting
 */
DG_API uint8_t dg_ssi_frame(struct dg_ssi *self, dg_ns now, uint64_t *bits);

/** `n` words have gone by, and nobody has looked: each of them counted what `each` says. Not inside
 * of a word; the one stored last stays. */
DG_API void dg_ssi_skip(struct dg_ssi *self, const struct dg_ssi_counters *each, uint64_t n);

/**
 * Position at `now`, multiturn and singleturn right-aligned, binary: counts of the angle modulo the
 * width. Regardless of errors and initialisation.
 */
DG_API uint64_t dg_ssi_position(const struct dg_ssi *self, dg_ns now);

/** What is wrong: bits of enum dg_ssi_error. */
DG_API uint8_t dg_ssi_errors(const struct dg_ssi *self);

/** Bits of a word of this model. A master clocks one more. */
DG_API uint8_t dg_ssi_word_bits(const struct dg_ssi_model *model);

/**
 * Take a word apart, as a master does.
 * @param bits the bits that came from the first rising edge on, right-aligned, as many as
 *        dg_ssi_word_bits() says; what stands above them is ignored
 * @return 0, or DG_ERR_DAMAGED when the parity is wrong; `frame` is filled in either way
 */
DG_API int dg_ssi_frame_decode(const struct dg_ssi_model *model, uint64_t bits,
                               struct dg_ssi_frame *frame);

/** Gray code of a number: neighbours differ in one bit. */
DG_API uint32_t dg_ssi_gray(uint32_t binary);
/** The number of a Gray code. */
DG_API uint32_t dg_ssi_binary(uint32_t gray);

/** The protocol: models are struct dg_ssi_model, devices struct dg_ssi; they have no EEPROM, and
 * setup.nvm, setup.serial and setup.port are not looked at. */
DG_API extern const struct dg_stack dg_ssi_stack;
/** What is looked at before a state of one is believed, see stack.h. */
DG_API extern const struct dg_stack_check dg_ssi_check;
/** Its models in src/devices: singleturn, multiturn; multiturn in binary with error bit and parity.
 */
DG_API extern const struct dg_device dg_ssi_13, dg_ssi_25, dg_ssi_28;
/** What a text can say of its models, see model.h; an object file of its own. */
DG_API extern const struct dg_model_text dg_ssi_model_text;
/** The protocol as an instrument, see instrument.h; an object file of its own. */
DG_API extern const struct dg_instrument dg_ssi_instrument;

/** Its master, see bus_master.h; an object file of its own. */
DG_API extern const struct dg_master_protocol dg_ssi_master;

/** What can be set of a struct dg_ssi_model, for hosts. */
DG_API extern const struct dg_keys dg_ssi_keys;

/**
 * What SCPI's SSI: asks of a port whose wire it clocks itself; dg_encoder.port of such an encoder
 * is one. It gives 0 or an enum dg_scpi_error; `detail` has room for DG_SCPI_DETAIL_MAX characters
 * and a zero.
 */
struct dg_ssi_port_ops {
    /** Clock one word now: its bits, right-aligned. */
    int (*frame)(void *ctx, uint64_t *bits, char *detail);
};

/** The figures of a model of this stack; NULL when it is of another one. */
DG_API const struct dg_ssi_model *dg_ssi_model_of(const struct dg_device *device);

#ifdef __cplusplus
}
#endif

#endif
