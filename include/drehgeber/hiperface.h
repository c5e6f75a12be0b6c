/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Kübler Sendix S36 with RS485 + SinCos (HIPERFACE-compatible): the parameter channel and the
 * process channel. Source: manual R67057.0002, chapters 3.2, 4.1.3 and 5.1; what it leaves open is
 * decided in src/hiperface/README.md, 'Inaccuracies and choices'.
 *
 * Bytes and time go in, reply frames come out:
 *
 *   master  |40|42|02|                                     |
 *           rx rx rx .. timeout .. reaction time .. tx(40 42 p p p p x)
 *                    ^ 11 or 44 bit times          ^ position latched here
 *
 * The host calls dg_hf_rx() for every received character and dg_hf_step() at the moment that the
 * last call returned. All state lives in the caller's struct dg_hf; any number can live side by
 * side. Nothing here blocks except the memory's operations.
 */
#ifndef DREHGEBER_HIPERFACE_H
#define DREHGEBER_HIPERFACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/hal.h"
#include "drehgeber/key.h"
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

/** Longest frame in either direction: address, command, 132 data bytes, check sum (5.1.2.8). */
#define DG_HF_FRAME_MAX 135u
/** Address as delivered, the last one, and the broadcast address (5.1.1.2). */
#define DG_HF_ADDRESS_DEFAULT 0x40u
#define DG_HF_ADDRESS_LAST 0x5Fu
#define DG_HF_ADDRESS_BROADCAST 0xFFu
/** UART setting as delivered: 9600 Bd, even parity, long timeout, standard slave (5.1.1.2.4). */
#define DG_HF_UART_DEFAULT 0xE4u
/** Access codes as delivered (5.1.1.2.3). */
#define DG_HF_CODE_DEFAULT 0x55u
/** Depth of the error stack (5.1.2.13). */
#define DG_HF_STACK_DEPTH 4u
/** Most steps a turn a model may have: periods * steps. */
#define DG_HF_STEPS_PER_TURN_MAX 0x1000000u
/** Most implemented memory that 52h tells, in blocks of 16 bytes (5.1.2.14). */
#define DG_HF_IMPLEMENTED_MAX 0x80u
/** Longest initialisation time a model may have. */
#define DG_HF_INIT_MAX DG_S(600)

/** Status codes on the wire (5.1.3; 1Dh, 1Fh-23h from the command tables; 1Eh is in no list
 *  of the manual: chosen, R32 in src/hiperface/README.md). */
enum dg_hf_status {
    DG_HF_NO_ERROR = 0x00,
    DG_HF_COMPENSATION = 0x01,      /**< faulty compensation data */
    DG_HF_ANGLE_OFFSET = 0x02,      /**< faulty internal angular offset */
    DG_HF_PARTITION = 0x03,         /**< data field partitioning table destroyed */
    DG_HF_I2C = 0x05,               /**< internal I2C bus not operational */
    DG_HF_CHECKSUM_INTERNAL = 0x06, /**< internal check sum error */
    DG_HF_COUNTER = 0x08,           /**< counter overflow */
    DG_HF_CHECKSUM = 0x0A,          /**< check sum of the request is wrong */
    DG_HF_COMMAND = 0x0B,           /**< unknown command code */
    DG_HF_LENGTH = 0x0C,            /**< wrong number of bytes */
    DG_HF_ARGUMENT = 0x0D,          /**< wrong command argument */
    DG_HF_WRITE_PROTECTED = 0x0E,   /**< the data field may not be written */
    DG_HF_ACCESS_CODE = 0x0F,       /**< wrong access code */
    DG_HF_FIELD_SIZE = 0x10,        /**< insufficient memory, size fixed */
    DG_HF_FIELD_OFFSET = 0x11,      /**< outside of the data field */
    DG_HF_FIELD_NUMBER = 0x12,      /**< no such data field */
    DG_HF_LED_CURRENT = 0x1D,       /**< LED current above its limit */
    DG_HF_TEMPERATURE = 0x1E,       /**< temperature outside its limits */
    DG_HF_SPEED = 0x1F,             /**< too fast to acquire the position */
    DG_HF_SINGLETURN = 0x20,        /**< singleturn signal lost */
    DG_HF_MULTITURN_AMPLITUDE = 0x21,
    DG_HF_MULTITURN_SYNC = 0x22,
    DG_HF_MULTITURN_VECTOR = 0x23,
};

/** EEPROM regions of the device; the row of dg_hf_layout.regions with the same index. */
enum dg_hf_region {
    DG_HF_REGION_RESOLUTION,  /**< "resolution": periods, steps (0: see "steps"), turns; 01h */
    DG_HF_REGION_CALIBRATION, /**< "calibration": sensor calibration; 01h */
    DG_HF_REGION_OFFSET,      /**< "offset": position offset; 02h */
    DG_HF_REGION_SYNC,        /**< "sync": sensor synchronisation; 02h */
    DG_HF_REGION_UART,        /**< "uart": UART setting and address; 03h */
    DG_HF_REGION_MEMORY,      /**< "memory": user memory size; 03h */
    DG_HF_REGION_CODES,       /**< "codes": the four access codes; 03h */
    DG_HF_REGION_FIELDS,      /**< "fields": number and status of the data fields; 03h */
    DG_HF_REGION_TYPE,        /**< "type": type code, option, serial number, firmware; 05h */
    DG_HF_REGION_COUNTER,     /**< "counter": the 24-bit counter; 08h */
    DG_HF_REGION_LABEL,       /**< "label": extended type label; 12h */
    DG_HF_REGION_FIELD_SUMS,  /**< "field-sums": a CRC-16 per data field */
    DG_HF_REGION_USER,        /**< "user": content of the data fields */
    DG_HF_REGION_STEPS,       /**< "steps": steps a period beyond 255; 01h */
    DG_HF_REGION_IMPLEMENTED, /**< "implemented": memory size told by 52h, 0: as "memory"; 03h */
    DG_HF_REGION_COUNT
};

/** The device's EEPROM table. */
DG_API extern const struct dg_store_layout dg_hf_layout;

/**
 * What a model is. Every figure is configuration; src/devices has the models of the manual.
 * dg_hf_format() burns the figures into the EEPROM, and a device reads them from there at power-on;
 * what is damaged there is taken from here. Only the two times are always taken from here.
 */
struct dg_hf_model {
    uint16_t periods_per_turn; /**< 1..65535 sine periods a turn */
    /** Steps of 42h in a period, 1..2^24 / periods; 32 in all slaves (5.1.2.1). What 42h counts is
     * a figure of its own (5.1.2: 20 bits singleturn): the type label has no field for it. */
    uint32_t steps_per_period;
    uint32_t turns;              /**< 1: singleturn; turns * periods * steps must not exceed 2^32 */
    uint8_t type_code;           /**< 52h byte 1 */
    uint8_t option_code;         /**< 52h byte 3 */
    uint8_t memory_blocks;       /**< user memory in blocks of 16 bytes, 1..112 (70h) */
    uint8_t implemented_blocks;  /**< 52h byte 2: memory_blocks..128 (80h); 0: as memory_blocks */
    char serial[10];             /**< 56h: 9 characters */
    char version[21];            /**< 56h: up to 19 characters; the 20th is always told as 00h */
    char date[9];                /**< 56h: 8 characters */
    char designation[19];        /**< label 0Ah: up to 18 characters, padded with 00h */
    uint8_t temperature_channel; /**< 44h channels, also told in the label at 1Eh */
    uint8_t led_channel;
    uint8_t vector_channel;
    int16_t temperature_min_degc; /**< limits, from label 20h on */
    int16_t temperature_max_degc;
    uint16_t led_min_ma;
    uint16_t led_max_ma;
    uint16_t vector_min; /**< permille of the nominal vector length */
    uint16_t vector_max;
    uint16_t speed_max_rpm; /**< fastest speed at which 42h acquires the position */
    uint16_t acceleration_max_krad_s2;
    dg_ns reaction; /**< from the request's timeout to the reply; never more than the command's */
    dg_ns init;     /**< 0..DG_HF_INIT_MAX: after power-on and 53h (5.1.2.15, 5.1.2.18) */
    uint32_t lacks; /**< commands that it answers as unknown ones (0Bh): bit 0 is the one with the
                         lowest code (42h), bit 1 the next one, of those in commands.def */
    const struct dg_store_layout *layout; /**< of the EEPROM: its first regions are those of
                                               dg_hf_layout; NULL: that one. See model.h */
};

/** The wire's operations. */
struct dg_hf_ops {
    /**
     * Send a whole reply, starting now, without a pause between its characters. Must not block
     * and must not call back into the device. `bytes` is valid during the call only. What comes
     * in while the reply is on the line is the port's to drop (half duplex).
     */
    void (*tx)(void *ctx, const uint8_t *bytes, size_t n);
};

/** What a device is made of. Everything pointed to must outlive the device. */
struct dg_hf_setup {
    const struct dg_hf_model *model;
    const struct dg_world *world;
    struct dg_nvm nvm;
    const struct dg_hf_ops *ops;
    void *ctx; /**< handed to ops */
};

/** What is known to be wrong with a received character (dg_hf_rx). */
enum dg_hf_rx_flags {
    DG_HF_RX_OK = 0,
    DG_HF_RX_DAMAGED = 1, /**< parity or framing error, or sent with another UART setting */
    DG_HF_RX_START = 2,   /**< only a start bit so far: `byte` means nothing, the frame goes on */
};

/** Things nobody has to act on; they only count up. */
struct dg_hf_counters {
    uint32_t frames;      /**< frames addressed to this device */
    uint32_t replies;     /**< replies sent, error responses included */
    uint32_t errors;      /**< error responses among them */
    uint32_t others;      /**< frames for other devices, and ones whose first byte was damaged */
    uint32_t damaged;     /**< characters flagged as damaged */
    uint32_t interrupted; /**< characters that came in before the reply was out; dropped */
    uint32_t deaf;        /**< characters that came in while initialising after 53h; dropped */
};

/** What the line automaton is doing. */
enum dg_hf_line_state {
    DG_HF_OFF,     /**< no power */
    DG_HF_DEAF,    /**< initialising after 53h */
    DG_HF_IDLE,    /**< the next character is an address */
    DG_HF_COLLECT, /**< inside a frame for this device */
    DG_HF_SKIP,    /**< inside something else, until the line is silent */
    DG_HF_REPLY,   /**< the reply's moment has not come yet */
};

/**
 * A device. Caller-owned plain data without pointers into itself: it can be copied, compared and
 * replayed. The fields are readable for tests and displays; only this module writes them.
 */
struct dg_hf {
    struct dg_hf_setup setup;
    struct dg_store store;
    struct dg_hf_counters counters;

    /* line */
    enum dg_hf_line_state line;
    dg_ns deadline;      /**< of the line state, or DG_NEVER */
    dg_ns last_rx;       /**< end of the last character received */
    dg_ns window_end;    /**< end of the start-up window; DG_NEVER when it is over */
    uint32_t silence_ns; /**< that ends a frame, by the setting in force */
    uint8_t uart;        /**< setting in force */
    uint8_t uart_next;   /**< setting in force after the window or 53h */
    uint8_t uart_stored; /**< setting in the EEPROM */
    bool frame_damaged;  /**< a character of this frame was damaged */
    uint8_t sum;         /**< XOR over this frame, whoever it is for */
    uint16_t length;     /**< characters of this frame, also beyond the buffer */
    uint8_t frame[DG_HF_FRAME_MAX];
    uint8_t verdict; /**< when it is complete: enum dg_hf_status of its protocol checks */
    uint8_t command; /**< likewise: its row in the table of commands, the number of rows: none */

    /* working copy of the EEPROM, read at power-on */
    uint16_t periods;
    uint32_t steps;
    uint32_t turns;
    uint32_t offset; /**< counts added to the raw position, 0..range-1 */
    uint8_t address;
    uint8_t codes[4];
    uint8_t blocks;      /**< user memory */
    uint8_t implemented; /**< memory as 52h tells it */
    int16_t temperature_min_degc;
    int16_t temperature_max_degc;
    uint16_t led_max_ma;
    uint16_t speed_max_rpm;
    uint8_t channels[3]; /**< 44h: temperature, LED current, vector length */

    /* status */
    uint8_t stack[DG_HF_STACK_DEPTH]; /**< error stack, oldest first */
    uint8_t stack_count;
    uint8_t locks;    /**< what may not be done until the next start; bits as STATe? tells them */
    uint8_t monitors; /**< monitored quantities that are out of range and have been reported */
};

/** A UART setting in plain terms. */
struct dg_hf_uart {
    uint32_t baud;
    char parity;          /**< 'N', 'E' or 'O' */
    uint8_t timeout_bits; /**< end of frame, in bit times after the last character: 11 or 44 */
};

/** Differential outputs of the process channel against ground, in microvolts (4.1.3). */
struct dg_hf_sincos {
    int32_t sin_plus_uv;
    int32_t sin_minus_uv;
    int32_t cos_plus_uv;
    int32_t cos_minus_uv;
};

/**
 * Burn the delivery state of `model` into a memory.
 * @return 0; DG_ERR_ARGUMENT when a figure of the model is out of range; DG_ERR_IO
 */
DG_API int dg_hf_format(const struct dg_hf_model *model, struct dg_nvm nvm);

/**
 * Make a device, without power. The memory is not touched.
 * @return 0 or DG_ERR_ARGUMENT (a pointer is missing, a figure is out of range)
 */
DG_API int dg_hf_init(struct dg_hf *self, const struct dg_hf_setup *setup);

/**
 * Switch the power on: mount the EEPROM, run the start-up checks (5.1.3), open the start-up
 * window (5.1.2.18). Also from the powered state: a power cycle.
 * @return 0, also with damaged regions or a silent EEPROM: the device then answers with its
 *         start-up errors. DG_ERR_BLANK or DG_ERR_FOREIGN: not this device's memory; it stays off.
 */
DG_API int dg_hf_power_on(struct dg_hf *self, dg_ns now);

/** Switch the power off. What was not acknowledged is lost. */
DG_API void dg_hf_power_off(struct dg_hf *self);

/**
 * A character came in.
 *
 * A frame goes on when the next character starts within the timeout. A host that sees start bits
 * reports them with DG_HF_RX_START; without that, a character has to be complete within the
 * timeout (one that ends exactly with it is). At the same `now`, call this before dg_hf_step().
 * @param now the end of its stop bit, or with DG_HF_RX_START the edge of its start bit
 * @param flags enum dg_hf_rx_flags
 * @return the next deadline, as dg_hf_step()
 */
DG_API dg_ns dg_hf_rx(struct dg_hf *self, dg_ns now, uint8_t byte, uint8_t flags);

/**
 * Do what is due at `now`: end of frame, reply, end of the start-up window; and look at the
 * monitored quantities (5.1.3 'Others'). May be called early (nothing is due) or late (a reply is
 * sent, and its position latched, at `now`).
 *
 * A host calls it, besides at the deadlines, whenever it has changed the world: a temperature that
 * is out of its limits between two requests is on the error stack then. One that lets a quantity
 * follow a course calls it every 10 ms while it does, or when a limit is crossed.
 * @return when to call again; DG_NEVER when only a character can change anything
 */
DG_API dg_ns dg_hf_step(struct dg_hf *self, dg_ns now);

/** The UART setting in force; changes in dg_hf_power_on() and dg_hf_step() only. */
DG_API struct dg_hf_uart dg_hf_uart(const struct dg_hf *self);

/**
 * Decode a setting byte (5.1.1.2.4).
 * @return 0 or DG_ERR_ARGUMENT (reserved parity 01b, reserved data rate 111b)
 */
DG_API int dg_hf_uart_decode(uint8_t setting, struct dg_hf_uart *out);

/** Position as 42h would latch it at `now`, in steps, regardless of errors. */
DG_API uint32_t dg_hf_position(const struct dg_hf *self, dg_ns now);

/**
 * The process channel at `now` (4.1.3), phase-locked to the shaft: one period per `steps` steps of
 * the raw position, sin 0 and cos at its peak where a new period of the raw position begins. Pure.
 */
DG_API void dg_hf_sincos(const struct dg_hf *self, dg_ns now, struct dg_hf_sincos *out);

/** The protocol: models are struct dg_hf_model, devices struct dg_hf; setup.port is a struct
 * dg_hf_ops. */
DG_API extern const struct dg_stack dg_hf_stack;
/** What is looked at before a state of one is believed, see stack.h. */
DG_API extern const struct dg_stack_check dg_hf_check;
/** Its models in src/devices: singleturn, multiturn. */
DG_API extern const struct dg_device dg_s3674_rs485, dg_s3684_rs485;
/** What a text can say of its models, see model.h; an object file of its own. */
DG_API extern const struct dg_model_text dg_hf_model_text;
/** The protocol as an instrument, see instrument.h; an object file of its own. */
DG_API extern const struct dg_instrument dg_hf_instrument;
/** What goes over its wire in words, see words.h; an object file of its own. */
DG_API extern const struct dg_words dg_hf_words;

/** What can be set of an encoder before it is made. */
struct dg_hf_settings {
    struct dg_hf_model model;
    uint32_t address; /**< of a new EEPROM; 0: as delivered */
};

/** The keys of a struct dg_hf_settings, for hosts. */
DG_API extern const struct dg_keys dg_hf_keys;

/** The figures of a model of this stack; NULL when it is of another one. */
DG_API const struct dg_hf_model *dg_hf_model_of(const struct dg_device *device);

#ifdef __cplusplus
}
#endif

#endif
