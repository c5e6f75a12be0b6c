/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Kübler Sendix S36 with BiSS-C: one slave, edge for edge. Source: manual R67057.0002, chapter 5.2,
 * and the BiSS C protocol description Rev C6; what they leave open is decided in
 * src/biss/README.md, 'Inaccuracies and choices'.
 *
 * Levels and time go in, levels come out:
 *
 *   MA   ¯|_|¯|_|¯|_|¯|_|¯|_|¯ ... ¯|_|¯|_________|¯
 *         e1  e2  eS                  CDM inverted
 *   SLO  ¯¯¯¯¯|___|¯|CDS|D D D ... C C|_______|¯¯¯
 *         ^ position latched                  ^ timeout: CDM is read, registers are accessed
 *
 * SLO is low from power-on to the first e1 (dg_biss_model.sl_low_at_start): a master that waits for
 * SL to be high before its first clock waits for ever.
 *
 * The host calls dg_biss_ma() for every edge of MA and dg_biss_step() at the moment that it
 * returned; a host that cannot be on time calls late, the result is the same. Several slaves on one
 * line are a struct dg_biss_chain. A host whose hardware shifts whole frames uses dg_biss_frame()
 * and dg_biss_frame_end() instead.
 *
 * All state lives in the caller's struct dg_biss; any number can live side by side. Nothing here
 * blocks except the memory's operations.
 */
#ifndef DREHGEBER_BISS_H
#define DREHGEBER_BISS_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/form.h"
#include "drehgeber/hal.h"
#include "drehgeber/key.h"
#include "drehgeber/stack.h"
#include "drehgeber/store.h"
#include "drehgeber/time.h"
#include "drehgeber/world.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_bus_master;
struct dg_instrument;
struct dg_master_protocol;
struct dg_model_text;

/** Silence on MA that ends a frame (5.2.1.2), and the short one chosen by 7Ch bits 2..0 (1..7). */
#define DG_BISS_TIMEOUT_NS ((dg_ns)13000)
#define DG_BISS_TIMEOUT_S_NS ((dg_ns)1300)
/** Longest one a host may choose instead, see dg_biss_model.timeout. */
#define DG_BISS_TIMEOUT_MAX_NS ((dg_ns)1000000000)
/** Longest delay of the start bit, and longest register access (protocol description, table 2). */
#define DG_BISS_BUSY_S_MAX_NS ((dg_ns)40000)
#define DG_BISS_BUSY_R_MAX_NS ((dg_ns)20000000)
/** Frames with CDM = 0 before a control frame; as many abort one (5.2.2). */
#define DG_BISS_ZEROS 14u
/** Most slaves with an ID of their own (5.2.2). */
#define DG_BISS_CHAIN_MAX 8u
/** What a host tells its user when dg_biss_hint() says so. */
#define DG_BISS_HINT                                                                               \
    "SLO is low until the first MA pulse (BiSS C6, Bus reset); a master that waits for SLO = 1 "   \
    "hangs here: send a pulse, or set sl_low_at_start=0"
/** Bytes a bank has, and the user banks (5.2.1.3). */
#define DG_BISS_BANK_SIZE 64u
#define DG_BISS_BANK_USER_FIRST 7u
#define DG_BISS_BANK_USER_LAST 31u

/** Parts of a frame behind the position (5.2.1.2): nERR and nWARN, the life counter where the model
 * has one, and the inverted CRC6. */
#define DG_BISS_FLAG_BITS 2u
#define DG_BISS_LIFE_BITS 6u
#define DG_BISS_CRC_BITS 6u

/** Limits behind the error register. */
#define DG_BISS_LED_MAX_UA 30000u
#define DG_BISS_AMPLITUDE_MIN_PERMILLE 600u
#define DG_BISS_AMPLITUDE_MAX_PERMILLE 1400u
#define DG_BISS_OFFSET_MAX_PERMILLE 100
#define DG_BISS_TEMPERATURE_MIN_MDEGC (-40000)
#define DG_BISS_TEMPERATURE_MAX_MDEGC 120000

/**
 * Bits of the error register 69h (5.2.3), each with its cause in struct dg_world. A bit is set
 * while its cause lasts, no longer. nERR is low while 69h & EMASK is not 0 or the simulated error
 * of command 05 is set, nWARN while 69h & WMASK is not 0.
 */
enum dg_biss_error {
    DG_BISS_CONTROL = 0x01,       /**< led_current_ua above DG_BISS_LED_MAX_UA */
    DG_BISS_SIGNAL = 0x02,        /**< a sin/cos amplitude or offset outside its limits */
    DG_BISS_TEMPERATURE = 0x04,   /**< temperature_mdegc outside its limits; monitored, and shown in
                                       69h, only while EMASK or WMASK has this bit */
    DG_BISS_SYNC = 0x08,          /**< multiturn_sync_ok is false */
    DG_BISS_CONFIGURATION = 0x10, /**< eeprom_acknowledges is false, a region is damaged, or command
                                       04 is checking */
    DG_BISS_INTERPOLATION = 0x20, /**< singleturn_ok is false */
    DG_BISS_ABSOLUTE = 0x40,      /**< multiturn_amplitude_ok or multiturn_vector_ok is false */
    DG_BISS_SYSTEM = 0x80,        /**< watchdog_fired */
};

/** EMASK (22h) and WMASK (23h) as delivered: no temperature monitoring, no warnings. */
#define DG_BISS_EMASK_DEFAULT 0xFBu
#define DG_BISS_WMASK_DEFAULT 0x00u

/** Bits of the status, 60h read. While initialising only ERR and WARN are set; a healthy device
 * shows 93h. */
enum dg_biss_status {
    DG_BISS_STATUS_INIT = 0x80,  /**< configuration complete: initialised, and at the start 69h had
                                      neither DG_BISS_CONFIGURATION nor DG_BISS_ABSOLUTE */
    DG_BISS_STATUS_ERR = 0x40,   /**< nERR is low */
    DG_BISS_STATUS_WARN = 0x20,  /**< nWARN is low */
    DG_BISS_STATUS_EWKH = 0x10,  /**< bank 0 (1Bh..23h) may be written: initialised */
    DG_BISS_STATUS_EWKL = 0x08,  /**< the EDS may be written: never */
    DG_BISS_STATUS_BUSY = 0x04,  /**< the EEPROM is working */
    DG_BISS_STATUS_ADV = 0x02,   /**< absolute data valid: initialised, 69h bit 6 is 0 */
    DG_BISS_STATUS_VALID = 0x01, /**< position valid: initialised, 69h bits 3, 5, 6 are 0 */
};

/** Commands, 60h written; other values do nothing. */
enum dg_biss_command {
    DG_BISS_NEW_POSITION = 0x00, /**< acquire the absolute position anew; nothing to see */
    DG_BISS_STORE = 0x01,        /**< bank 0 into the EEPROM */
    DG_BISS_SOFT_RESET = 0x03,   /**< as power-on, bus level excepted */
    DG_BISS_CHECK = 0x04,        /**< verify the EEPROM anew, see DG_BISS_CONFIGURATION; takes
                                      dg_biss_model.eeprom_write */
    DG_BISS_SIMULATE = 0x05,     /**< set the simulated error: ERR of 60h, nERR; not in 69h */
    DG_BISS_CLEAR = 0x06,        /**< clear the simulated error */
    DG_BISS_COMMAND_COUNT
};

/** Widths of MT and ST, and of a whole frame behind CDS. */
#define DG_BISS_MULTITURN_BITS_MAX 32u
#define DG_BISS_SINGLETURN_BITS_MIN 8u
#define DG_BISS_SINGLETURN_BITS_MAX 32u
#define DG_BISS_FRAME_BITS_MAX 63u

/** EEPROM regions; the row of dg_biss_layout.regions with the same index. */
enum dg_biss_region {
    DG_BISS_REGION_CONFIG, /**< "config": bank 0, 1Bh..23h */
    DG_BISS_REGION_USER,   /**< "user7", then "user8" .. "user31": 64 bytes each */
    DG_BISS_REGION_COUNT =
        DG_BISS_REGION_USER + DG_BISS_BANK_USER_LAST - DG_BISS_BANK_USER_FIRST + 1
};

/** The device's EEPROM table; each region is checked. */
DG_API extern const struct dg_store_layout dg_biss_layout;

struct dg_biss_form;

/** What a model is. Every figure is configuration; src/devices has the models of the manual. */
struct dg_biss_model {
    uint8_t multiturn_bits;  /**< MT, 0..DG_BISS_MULTITURN_BITS_MAX */
    uint8_t singleturn_bits; /**< ST, DG_BISS_SINGLETURN_BITS_MIN..DG_BISS_SINGLETURN_BITS_MAX; a
                                  frame has at most DG_BISS_FRAME_BITS_MAX bits, 49 of MT and ST */
    bool life_counter;       /**< the frame has the 6 bits LC */
    bool autostore;          /**< each write to 1Bh..23h goes to the EEPROM at once */
    bool sl_low_at_start;    /**< SLO is low from power-on and command 03 to the first e1 */
    bool stop_bit_early;     /**< P = 1 says that the register behind the one just transferred will
                                  be refused; otherwise that the one just transferred was */
    bool unidirectional;     /**< no registers, no commands: CDS is 0, CDM is not looked at */
    uint32_t serial;         /**< 44h..47h */
    uint8_t device_id[8];    /**< 78h..7Fh: device, of which MT, ST and timeout are filled in by the
                                  device; behind it two bytes of the manufacturer */
    uint8_t profile_id;      /**< 42h and BP_ID in the EDS */
    bool no_eds; /**< with registers, but no EDS: banks 3 and 4 are not there, 41h is 0 */
    const struct dg_biss_form *form; /**< frames of another form; NULL: position, nERR, nWARN, LC if
                                          there is one, ~CRC6 */
    const struct dg_store_layout *layout; /**< of the EEPROM: its first regions are those of
                                               dg_biss_layout; NULL: that one. See model.h */
    dg_ns busy;         /**< from e1 to the earliest start bit, 0..DG_BISS_BUSY_S_MAX_NS */
    dg_ns busy_jitter;  /**< up to as much more in every frame, see dg_biss.noise; with busy at
                             most DG_BISS_BUSY_S_MAX_NS */
    dg_ns eeprom_read;  /**< before each byte of a user bank is there, or accepted */
    dg_ns eeprom_write; /**< after a byte was written, before the EEPROM takes another access;
                             with eeprom_read at most DG_BISS_BUSY_R_MAX_NS */
    dg_ns init;         /**< after power-on and soft reset: position 0, nERR and nWARN low,
                             registers refused except for reading 60h (PON_DLY) */
    dg_ns timeout;      /**< 0: as the device has it, by 7Ch. Otherwise always this long, up to
                             DG_BISS_TIMEOUT_MAX_NS: for lines slower than BiSS allows */
    dg_ns hint;         /**< dg_biss_hint() waits so long; 0: for ever */
};

/** What a device is made of. Everything pointed to must outlive the device. */
struct dg_biss_setup {
    const struct dg_biss_model *model;
    const struct dg_world *world;
    struct dg_nvm nvm;
};

/** Things nobody has to act on; they only count up. */
struct dg_biss_counters {
    uint32_t frames;   /**< rising edges e1 */
    uint32_t reads;    /**< registers read */
    uint32_t writes;   /**< registers written */
    uint32_t refused;  /**< accesses answered with an inverted W, further registers with P = 1 */
    uint32_t damaged;  /**< control frames with a bad CRC */
    uint32_t commands; /**< commands executed */
};

/** What the line automaton is doing. */
enum dg_biss_line_state {
    DG_BISS_OFF,    /**< no power */
    DG_BISS_IDLE,   /**< the next rising edge is e1 */
    DG_BISS_ACK,    /**< e1 has been, the next one is e2 */
    DG_BISS_WAIT,   /**< SLO is low until the start bit */
    DG_BISS_CDS,    /**< the start bit is on the line */
    DG_BISS_DATA,   /**< the data is shifted out, what is on SLI behind it */
    DG_BISS_RETURN, /**< timeout with MA low: the next rising edge returns to idle */
};

/** The line. */
struct dg_biss_line {
    dg_ns deadline; /**< end of the timeout, or DG_NEVER */
    dg_ns last;     /**< latest `now` */
    dg_ns start;    /**< end of the processing time: the last slave's start bit is not before it */
    dg_ns hint;     /**< dg_biss_hint() says so from then on; 0: it was not asked yet */
    uint64_t shift; /**< bit `length` of it is on SLO */
    uint32_t timeout; /**< of the frame, in ns: known at e1 */
    enum dg_biss_line_state state;
    uint8_t length; /**< of the data in bits */
    bool ma;        /**< level of MA */
    bool slo;       /**< own level of SLO; see dg_biss_slo() */
    bool is_last;   /**< SLI was low at e2: this slave makes the start bit */
    bool hinted;    /**< dg_biss_hint() has said so since the start */
};

/** What the control frame automaton waits for: the CDM bit of which frame. */
enum dg_biss_control_state {
    DG_BISS_CONTROL_IDLE,    /**< 14 zeros */
    DG_BISS_CONTROL_READY,   /**< S (k = 0) */
    DG_BISS_CONTROL_ADDRESS, /**< CTS, ID or IDS, ADR or CMD, CRC (1..15) */
    DG_BISS_CONTROL_R,       /**< (16) */
    DG_BISS_CONTROL_W,       /**< (17) */
    DG_BISS_CONTROL_S,       /**< (18), and S of a further byte (32) */
    DG_BISS_CONTROL_BUSY,    /**< S again, the register is not ready (19) */
    DG_BISS_CONTROL_DATA,    /**< data, CRC, P (19..31) */
    DG_BISS_CONTROL_SELECT,  /**< S of a command (16) */
    DG_BISS_CONTROL_EXECUTE, /**< up to EX (17 or 17..24) */
    DG_BISS_CONTROL_STATE_COUNT
};

/** A control frame. */
struct dg_biss_control {
    dg_ns ready;    /**< the EEPROM works until then */
    uint16_t shift; /**< what was collected in this state */
    enum dg_biss_control_state state;
    uint8_t count;   /**< bits collected in this state */
    uint8_t zeros;   /**< CDM = 0 in a row, at most DG_BISS_ZEROS */
    uint8_t id;      /**< own one in this control frame, DG_BISS_NO_ID without */
    uint8_t address; /**< of the register */
    uint8_t command; /**< 0..3 */
    bool r;
    bool w;
    bool addressed; /**< the command is for selected slaves */
    bool mine;      /**< this slave is one of them */
    bool refused;   /**< the register, or the one behind it, which the master may go on to */
    bool cds;       /**< to be sent in the next frame */
};

/** dg_biss_control.id of a slave that got none. */
#define DG_BISS_NO_ID 0xFFu

/**
 * A device. Caller-owned plain data without pointers into itself: it can be copied, compared and
 * replayed. The fields are readable for tests and displays; only this module writes them.
 */
struct dg_biss {
    struct dg_biss_setup setup;
    struct dg_store store;
    struct dg_biss_counters counters;
    struct dg_biss_line line;
    struct dg_biss_control control;
    uint64_t position; /**< MT:ST as latched last, right-aligned */
    dg_ns ready_at;    /**< end of the initialisation */
    dg_ns checked_at;  /**< end of command 04 */
    uint32_t noise;    /**< of busy_jitter: the serial number from dg_biss_init(), another value
                            is another sequence */
    uint8_t config[9]; /**< bank 0, 1Bh..23h, in force */
    uint8_t bank;      /**< 40h */
    uint8_t timeout;   /**< 7Ch bits 2..0 */
    uint8_t life;      /**< LC as sent last, 68h */
    bool started;      /**< a frame has been sent since the start */
    bool mounted;      /**< the EEPROM could be read at the start */
    bool configured;   /**< DG_BISS_STATUS_INIT, once initialised */
    bool simulated;    /**< simulated error */
    bool channel_off;  /**< no data in the frame (broadcast command 00) */
    bool communication_off; /**< takes no ID (addressed command 01) */
};

/** Slaves on one line. slave[0] is nearest to the master; SLI of the last one is low. */
struct dg_biss_chain {
    struct dg_biss *slave[DG_BISS_CHAIN_MAX];
    uint8_t count; /**< 1..DG_BISS_CHAIN_MAX */
    /** The line between slave `index` and its neighbour, for index 0 the master: what gets there
     * while SLO is at `slo`. Called with `clocked` once for each rising edge of MA, when SLO has
     * followed it; otherwise somebody looks, as often as he likes, and the answer changes nothing.
     * Must not block, nor call this module for the chain. NULL: what is sent gets there. */
    bool (*link)(void *ctx, uint8_t index, bool slo, bool clocked);
    void *ctx; /**< of link */
};

/**
 * Burn the delivery state into a memory: offsets 0, masks as delivered, user banks FFh.
 * @return 0 or DG_ERR_IO
 */
DG_API int dg_biss_format(struct dg_nvm nvm);

/**
 * Make a device, without power. The memory is not touched.
 * @return 0 or DG_ERR_ARGUMENT (a pointer is missing, a figure is out of range)
 */
DG_API int dg_biss_init(struct dg_biss *self, const struct dg_biss_setup *setup);

/**
 * Switch the power on at `now`, MA high; the device is ready after model->init. Also from the
 * powered state: a power cycle. SLO is low with model->sl_low_at_start, otherwise high; a host that
 * drives a line puts it to dg_biss_slo() now. A new start of the life counter, all banks and masks
 * as stored.
 * @return 0, also with damaged regions or a silent EEPROM (DG_BISS_CONFIGURATION, bank 0 as
 *         delivered). DG_ERR_BLANK or DG_ERR_FOREIGN: not this device's memory; it stays off.
 */
DG_API int dg_biss_power_on(struct dg_biss *self, dg_ns now);

/** Switch the power off. SLO is high; what was not stored is lost. */
DG_API void dg_biss_power_off(struct dg_biss *self);

/**
 * MA is at `level` from `now` on; the same level again is no edge. Point to point: SLI is low.
 * A timeout that ended at or before `now` comes first.
 * @return the level of SLO
 */
DG_API bool dg_biss_ma(struct dg_biss *self, dg_ns now, bool level);

/** The same with a neighbour: `sli` is the level of SLI before this edge. */
DG_API bool dg_biss_link(struct dg_biss *self, dg_ns now, bool level, bool sli);

/**
 * Do what is due at `now`: the end of the timeout. May be called early (nothing happens) or late
 * (the access happens as of the deadline).
 * @return when to call again; DG_NEVER when only an edge can change anything
 */
DG_API dg_ns dg_biss_step(struct dg_biss *self, dg_ns now);

/**
 * Whether the user has to be told DG_BISS_HINT: SLO has been low since power-on or command 03, and
 * no pulse of MA has come for model->hint since somebody asked for the first time. True once for
 * each start. For hosts that can speak; the encoder does not mind.
 * @param now where time ends (DG_NEVER): whether there is still something to tell at the end
 * @param due when to ask again, unless an edge comes before; DG_NEVER: not by itself
 */
DG_API bool dg_biss_hint(struct dg_biss *self, dg_ns now, dg_ns *due);

/** Level of SLO. A slave that is not the last one passes `sli` on while it is idle. */
DG_API bool dg_biss_slo(const struct dg_biss *self, bool sli);

/** dg_biss_ma() for a chain. @return the level of the master's SL, the first slave's SLO */
DG_API bool dg_biss_chain_ma(struct dg_biss_chain *self, dg_ns now, bool level);

/** dg_biss_step() for a chain. */
DG_API dg_ns dg_biss_chain_step(struct dg_biss_chain *self, dg_ns now);

/** dg_biss_hint() for a chain: once for all of it. */
DG_API bool dg_biss_chain_hint(struct dg_biss_chain *self, dg_ns now, dg_ns *due);

/** The master's SL. */
DG_API bool dg_biss_chain_slo(const struct dg_biss_chain *self);

/**
 * A whole frame at once, point to point, for hosts whose hardware does the shifting: latch at
 * `e1` and give what follows the start bit, which is not due before self->line.start.
 * To be followed by dg_biss_frame_end(); not to be mixed with dg_biss_ma() inside a frame.
 * @param bits CDS, and what is behind it, right-aligned
 * @return number of bits, 1..64; 0 without power
 */
DG_API uint8_t dg_biss_frame(struct dg_biss *self, dg_ns e1, uint64_t *bits);

/**
 * `n` whole frames have gone by, with CDM 0, and nobody has looked: afterwards all is as if they
 * had been clocked, but for the position that was latched last. Not inside of a frame.
 */
DG_API void dg_biss_skip(struct dg_biss *self, uint64_t n);

/** What is in a frame behind CDS. */
struct dg_biss_data {
    uint64_t position;   /**< MT:ST, right-aligned */
    uint32_t multiturn;  /**< MT */
    uint32_t singleturn; /**< ST */
    uint8_t life;        /**< LC; 0 without one */
    bool n_err;          /**< level: false is an error */
    bool n_warn;         /**< level: false is a warning */
    bool crc_ok;         /**< the CRC fits */
};

/** Frames of another form, of models that are texts: what makes them, and takes them apart. An
 * object of their own (src/biss/form.c), so that an image without such models carries none of it.
 */
struct dg_biss_form {
    /** Whether MT, ST and all around them fit. */
    bool (*fits)(const struct dg_biss_model *model);
    /** What was latched last, with the `flags` of dg_biss_flags(), into `bits`: all behind CDS.
     * @return how many */
    uint8_t (*make_frame)(const struct dg_biss *self, uint8_t flags, uint64_t *bits);
    /** As dg_biss_frame_decode(). */
    void (*take_apart)(const struct dg_biss_model *model, uint64_t bits, struct dg_biss_data *out);
    uint32_t crc_poly;             /**< with its first and last bit: 43h is x^6 + x + 1 */
    uint16_t crc_start;            /**< what the check sum begins with */
    bool crc_plain;                /**< sent as it is, otherwise inverted */
    bool error_high;               /**< 1 is an error, otherwise 0 */
    bool warning_high;             /**< likewise */
    uint8_t around;                /**< bits of the layout, those of the position not counted */
    char layout[DG_FORM_MAX + 1u]; /**< form.h; P: MT and ST, E: error, W: warning, L: life counter,
                                        C: CRC over all in front of it */
};

/** Whether MT, ST and all around them fit: dg_biss_form.fits where frames are as the layout says.
 * For models that are C, as `drehgeber model --c` writes them; they link src/biss/form.c. */
DG_API bool dg_biss_layout_fits(const struct dg_biss_model *model);
/** dg_biss_form.make_frame of such a model. @return bits of the frame, 16..63 */
DG_API uint8_t dg_biss_layout_make_frame(const struct dg_biss *self, uint8_t flags, uint64_t *bits);
/** dg_biss_form.take_apart of such a model. */
DG_API void dg_biss_layout_take_apart(const struct dg_biss_model *model, uint64_t bits,
                                      struct dg_biss_data *out);

/** Bits of a frame behind CDS, 16..63. */
DG_API uint8_t dg_biss_frame_bits(const struct dg_biss_model *model);

/** Take apart what a slave of this model sent behind CDS. `bits` is right-aligned, what is in front
 * of these dg_biss_frame_bits() bits is ignored. For masters: a wrong CRC is told, not refused. */
DG_API void dg_biss_frame_decode(const struct dg_biss_model *model, uint64_t bits,
                                 struct dg_biss_data *out);

/** The timeout of that frame ended at `now`; the master sent `cdm` (MA low: 1). */
DG_API void dg_biss_frame_end(struct dg_biss *self, dg_ns now, bool cdm);

/**
 * Position at `now`, MT:ST right-aligned, as a frame has it: counts of the angle, minus OFFS,
 * negated with DIR, modulo its width. OFFS_ST is left-aligned in 26 bits, what is below the
 * resolution is dropped; a borrow goes into MT. Regardless of errors and initialisation.
 */
DG_API uint64_t dg_biss_position(const struct dg_biss *self, dg_ns now);

/** The error register 69h as it reads at `now`. */
DG_API uint8_t dg_biss_errors(const struct dg_biss *self, dg_ns now);

/** nERR (bit 1) and nWARN (bit 0) as a frame latched at `now` has them. */
DG_API uint8_t dg_biss_flags(const struct dg_biss *self, dg_ns now);

/** CRC6 (43h) over the last `n` bits of `bits`, as sent: inverted. @param n 0..64 */
DG_API uint8_t dg_biss_crc6(uint64_t bits, uint8_t n);

/** CRC4 (13h) over the last `n` bits of `bits`, as sent: inverted. @param n 0..64 */
DG_API uint8_t dg_biss_crc4(uint64_t bits, uint8_t n);

/**
 * What SCPI's BISS: asks of a port whose wire it clocks itself; dg_encoder.port of such an encoder
 * is one. Each gives 0 or an enum dg_scpi_error; `detail` has room for DG_SCPI_DETAIL_MAX
 * characters and a zero. None may be NULL.
 */
struct dg_biss_port_ops {
    /** Clock one frame now: what follows the start bit, as dg_biss_frame() gives it. */
    int (*frame)(void *ctx, uint64_t *bits, uint8_t *count, char *detail);
    /** Read or write `n` registers from `address` on. */
    int (*read)(void *ctx, uint8_t address, uint8_t *bytes, size_t n, char *detail);
    int (*write)(void *ctx, uint8_t address, const uint8_t *bytes, size_t n, char *detail);
};

/** The protocol: models are struct dg_biss_model, devices struct dg_biss; setup.port is not looked
 * at. */
DG_API extern const struct dg_stack dg_biss_stack;
/** What is looked at before a state of one is believed, see stack.h. */
DG_API extern const struct dg_stack_check dg_biss_check;
/** Its models in src/devices: singleturn, multiturn. */
DG_API extern const struct dg_device dg_s3674_biss, dg_s3684_biss;
/** What a text can say of its models, see model.h; an object file of its own. */
DG_API extern const struct dg_model_text dg_biss_model_text;
/** The protocol as an instrument, see instrument.h; an object file of its own. */
DG_API extern const struct dg_instrument dg_biss_instrument;

/** Its master, see bus_master.h; an object file of its own, likewise what follows. */
DG_API extern const struct dg_master_protocol dg_biss_master;

/** What an access to registers can end in; what is not negative counts registers. */
enum dg_biss_failure {
    DG_BISS_SILENT = -1,   /**< the encoder did not answer */
    DG_BISS_REFUSED = -2,  /**< register not implemented, protected, or not ready */
    DG_BISS_TOO_BUSY = -3, /**< longer than 20 ms */
    DG_BISS_DAMAGED = -4,  /**< a check sum is wrong */
};

/** Registers of an encoder of a chain, to be read or written. */
struct dg_biss_access {
    size_t place; /**< of the encoder, 0 is next to the master */
    uint8_t address;
    const uint8_t *sent; /**< NULL: they are read */
    uint8_t *got;        /**< NULL: they are written */
    size_t n;
    size_t done; /**< how many were accessed; out */
};

/** Read or write registers, in as many control frames as it takes: a sequence ends where the next
 * register is refused. Who looks at the bus is told in words.
 * @return what is not negative, or enum dg_biss_failure for register address + done */
DG_API int dg_biss_access(struct dg_bus_master *master, struct dg_biss_access *access);

/** An enum dg_biss_failure in words. */
DG_API const char *dg_biss_failure_text(int failure);

/** An access that ended in `failure`, in words: "register 78h: ...". */
DG_API void dg_biss_access_explain(const struct dg_bus_master *master,
                                   const struct dg_biss_access *access, int failure, char *to,
                                   size_t size);

/** What can be set of a struct dg_biss_model, for hosts. */
DG_API extern const struct dg_keys dg_biss_keys;

/** The figures of a model of this stack; NULL when it is of another one. */
DG_API const struct dg_biss_model *dg_biss_model_of(const struct dg_device *device);

#ifdef __cplusplus
}
#endif

#endif
