/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SCPI: the language of test instruments (IEEE 488.2-1992, SCPI-99 volume 1), for whatever byte
 * stream carries it. One session is one client: its line, its error queue, its status registers.
 *
 * The engine knows the common commands (*IDN? and so on, SYSTem:ERRor?, SYSTem:HELP?); all others
 * are rows of the host's table. Bytes and time go in, answers come out through ops->write. Nothing
 * blocks: a command that has to wait (*WAI, *OPC?) stops the session from taking bytes.
 */
#ifndef DREHGEBER_SCPI_H
#define DREHGEBER_SCPI_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Longest line without its end; a longer one is dropped whole with -363. */
#define DG_SCPI_LINE_MAX 512u
/** Length of the error queue; the last place becomes -350 when it overflows. */
#define DG_SCPI_ERRORS_MAX 16u
/** Longest device-dependent text of an error (after the ';'). */
#define DG_SCPI_DETAIL_MAX 95u

/** Error numbers (SCPI-99 volume 2, chapter 21). */
enum dg_scpi_error {
    DG_SCPI_NO_ERROR = 0,
    DG_SCPI_INVALID_CHARACTER = -101,
    DG_SCPI_SYNTAX = -102,
    DG_SCPI_DATA_TYPE = -104,
    DG_SCPI_SUPERFLUOUS = -108, /**< parameter not allowed */
    DG_SCPI_MISSING = -109,     /**< missing parameter */
    DG_SCPI_UNDEFINED = -113,   /**< undefined header; also for lines with binary garbage */
    DG_SCPI_NO_SUFFIX = -130,   /**< suffix error: a duration without a unit */
    DG_SCPI_SUFFIX = -131,      /**< invalid suffix */
    DG_SCPI_STRING = -151,      /**< invalid string data */
    DG_SCPI_EXECUTION = -200,
    DG_SCPI_CONFLICT = -221, /**< settings conflict */
    DG_SCPI_RANGE = -222,    /**< data out of range */
    DG_SCPI_ILLEGAL = -224,  /**< illegal parameter value */
    DG_SCPI_MEMORY = -225,   /**< out of memory */
    DG_SCPI_HARDWARE = -240,
    DG_SCPI_MISSING_HARDWARE = -241,
    DG_SCPI_STORAGE = -250,    /**< mass storage error */
    DG_SCPI_FILE_NAME = -256,  /**< no such file */
    DG_SCPI_FILE_ERROR = -257, /**< a name that must not be written */
    DG_SCPI_QUEUE = -350,      /**< queue overflow */
    DG_SCPI_OVERRUN = -363,    /**< input buffer overrun */
};

/** Bits of the standard event status register (*ESR?). */
enum dg_scpi_esr {
    DG_SCPI_ESR_OPC = 1,
    DG_SCPI_ESR_QUERY = 4,
    DG_SCPI_ESR_DEVICE = 8,
    DG_SCPI_ESR_EXECUTION = 16,
    DG_SCPI_ESR_COMMAND = 32,
    DG_SCPI_ESR_POWER_ON = 128,
};

/** Bits of the status byte (*STB?). */
enum dg_scpi_stb {
    DG_SCPI_STB_ERRORS = 4,  /**< the error queue is not empty */
    DG_SCPI_STB_ANSWER = 16, /**< an answer is waiting; never seen, answers go out at once */
    DG_SCPI_STB_EVENT = 32,  /**< ESR & ESE is not 0 */
    DG_SCPI_STB_SERVICE = 64 /**< STB & SRE is not 0 */
};

struct dg_scpi;

/** A row of the host's table. */
struct dg_scpi_command {
    /** Header with the short form in capitals and optional parts in brackets, e.g.
     * "SHAFt:POSition" or "SYSTem:ERRor[:NEXT]". A query has no '?' here. The first row that fits
     * and has what is asked for is taken: command and query may stand in a row each. */
    const char *header;
    /** The command: pulls its parameters. NULL: there is only the query. */
    void (*set)(struct dg_scpi *self);
    /** The query, behind '?': pulls its parameters, then puts its answer; -108 and no answer when
     * it has left a parameter. Without parts the answer is empty. NULL: there is only the command.
     */
    void (*query)(struct dg_scpi *self);
    uint32_t argument; /**< as self->command->argument: one function may serve several rows */
    /** Of the command (of the query where there is no command), for help, e.g. "ANGLE" or
     * "NAME[,COUNt n]"; "" without. It has as many commas as the longest command: with more
     * it is not begun, but gives -108. With "..." in it there may be any number. */
    const char *parameters;
    const char *help; /**< one line */
};

/** A list of commands. */
struct dg_scpi_commands {
    const struct dg_scpi_command *rows;
    size_t count; /**< 0: none */
};

/** What a session needs of its host. */
struct dg_scpi_ops {
    /** List `index` of the host's commands, NULL behind the last. They are looked through, and
     * told by SYSTem:HELP?, in this order, behind the engine's own. */
    const struct dg_scpi_commands *(*commands)(const struct dg_scpi *self, size_t index);
    /** Take `n` bytes of an answer. Must not block; what a slow client does not take is the
     * host's to keep or to drop together with the client. */
    void (*write)(void *ctx, const char *bytes, size_t n);
    /** *RST. NULL: nothing to reset. */
    void (*reset)(struct dg_scpi *self);
    /** When everything that was begun and takes time (a move) is over, for *OPC, *OPC?, *WAI; may
     * be asked again then. NULL: nothing takes time. */
    dg_ns (*settled)(struct dg_scpi *self);
};

/** What a session is made of. Everything pointed to must outlive it. */
struct dg_scpi_setup {
    const struct dg_scpi_ops *ops;
    void *ctx;       /**< the host's: of ops->write, and for handlers as self->setup.ctx */
    const char *idn; /**< answer of *IDN?: maker, model, serial number, version */
};

/** An error in the queue. */
struct dg_scpi_queued {
    int16_t code;
    char detail[DG_SCPI_DETAIL_MAX + 1u];
};

/** A session. Caller-owned plain data; handlers use the functions below. */
struct dg_scpi {
    struct dg_scpi_setup setup;
    dg_ns now;         /**< of the call that is being served */
    uint32_t selected; /**< the host's: which instrument this session has selected */

    char line[DG_SCPI_LINE_MAX + 1u];
    uint16_t length;
    bool overrun; /**< the line is too long: skipped up to its end */

    const struct dg_scpi_command *command;         /**< being called; NULL: none */
    bool (*poll)(struct dg_scpi *self, bool gone); /**< of dg_scpi_hold(); NULL: none */
    bool query;                                    /**< ... its query */

    uint16_t at;     /**< parser: place in the line */
    uint16_t path;   /**< length of the header path that the next relative header continues; it
                          stands at the beginning of the line */
    bool executing;  /**< a line is complete and not done yet */
    bool first;      /**< no parameter was taken yet */
    bool failed;     /**< the command at hand has raised an error */
    bool put;        /**< the command at hand has put a part of its answer */
    bool answered;   /**< the line has given an answer */
    bool waiting;    /**< *WAI or *OPC? holds the line */
    bool answer_due; /**< ... and it was *OPC? */
    bool opc;        /**< *OPC: bit 0 of ESR when everything has settled */

    uint8_t esr;
    uint8_t ese;
    uint8_t sre;
    uint8_t error_first;
    uint8_t error_count;
    struct dg_scpi_queued errors[DG_SCPI_ERRORS_MAX];
};

/** A fresh session: ESR has the power-on bit, the queue is empty. */
DG_API void dg_scpi_init(struct dg_scpi *self, const struct dg_scpi_setup *setup);

/**
 * Bytes came in: lines end with LF, CR LF, or CR. Commands are done at once. Ask dg_scpi_step()
 * for the deadline afterwards.
 * @return how many were taken: fewer than `n` while the session waits; offer the rest after
 * dg_scpi_step(). 0 when called by a handler of this session
 */
DG_API size_t dg_scpi_rx(struct dg_scpi *self, dg_ns now, const char *bytes, size_t n);

/** Go on when what a session waits for has settled. To be called also when that may have come
 * sooner than it was said to (a move was stopped); nothing happens when called by a handler of this
 * session. @return when to call again; DG_NEVER */
DG_API dg_ns dg_scpi_step(struct dg_scpi *self, dg_ns now);

/** The client has gone: what a handler has begun and not ended is given up. */
DG_API void dg_scpi_leave(struct dg_scpi *self);

/* ---------------------------------------------------------------- for handlers */

/** The command is not over when its handler returns: each dg_scpi_step() calls `poll`, which does a
 * part of the work, raises errors and puts answers as the handler would, until it says true: it is
 * over. dg_scpi_step() asks to be called again at once meanwhile. `gone`: dg_scpi_leave(); give it
 * up. */
DG_API void dg_scpi_hold(struct dg_scpi *self, bool (*poll)(struct dg_scpi *self, bool gone));

/** Units of numbers: the suffixes they take, the first one without any suffix. Values are counted
 * in the base unit. No suffix is case sensitive; blanks may stand before it. */
enum dg_scpi_unit {
    DG_SCPI_PLAIN,        /**< no suffix; 1 */
    DG_SCPI_ANGLE,        /**< DEG, REV; 2^-32 turn, rounded up (an angle of a step is in it) */
    DG_SCPI_SPEED,        /**< RPM; 0.001 rpm */
    DG_SCPI_ACCELERATION, /**< RPM/S; 0.001 rpm/s */
    DG_SCPI_TIME,         /**< MS, S, US, NS; 1 ns */
    DG_SCPI_TEMPERATURE,  /**< DEGC, CEL; 0.001 degC */
    DG_SCPI_VOLTAGE,      /**< MV, V; 1 mV */
    DG_SCPI_CURRENT,      /**< UA, MA; 1 uA */
    DG_SCPI_DURATION,     /**< as TIME, but the unit has to be said: -130 without */
    DG_SCPI_UNIT_COUNT
};

/** What a number may be. */
struct dg_scpi_range {
    enum dg_scpi_unit unit;
    uint8_t places; /**< PLAIN: decimals that the value is counted in, 0..9 */
    int64_t min;    /**< in the base unit */
    int64_t max;
};

/**
 * Take the next parameter as a number: decimal, with or without exponent, MIN and MAX; #H, #Q, #B
 * and 0x for plain whole ones. More decimals than the base unit has are truncated (angles rounded
 * up).
 * @return false: an error was raised (-109 none there, -102 more behind it, -104, -130, -131, -222
 * with the range), by this or before by the same command; `value` is as before. Likewise the others
 */
DG_API bool dg_scpi_number(struct dg_scpi *self, const struct dg_scpi_range *range, int64_t *value);

/** Take ON, OFF, 1 or 0. @return false: an error was raised */
DG_API bool dg_scpi_flag(struct dg_scpi *self, bool *value);

/** Take one of `count` words, given as in headers ("COUNt"). What follows in the same parameter,
 * behind a blank, is left for the next call. @return false: an error was raised (-224) */
DG_API bool dg_scpi_word(struct dg_scpi *self, const char *const *words, size_t count,
                         size_t *index);

/** Take the end of a parameter, which a word leaves open. @return false: there is more of it, and
 * `code` was raised; behind a blank -102, as a comma is missing */
DG_API bool dg_scpi_close(struct dg_scpi *self, int code);

/** Whether the next parameter begins with a letter: a word, where a number could be, too. */
DG_API bool dg_scpi_at_word(const struct dg_scpi *self);

/** Take a string in either quotes, or bare characters up to a blank, ',' or ';'. @param to always
 * terminated @return false: an error was raised (-109, -151; -222 when longer than size - 1) */
DG_API bool dg_scpi_text(struct dg_scpi *self, char *to, size_t size);

/** Whether another parameter is there; none after an error. */
DG_API bool dg_scpi_more(struct dg_scpi *self);

/** Queue an error and set its bit in ESR; the rest of the line is not done, and nothing more is
 * put. `code` 0: nothing. `detail` may be NULL; it is cut to DG_SCPI_DETAIL_MAX. */
DG_API void dg_scpi_raise(struct dg_scpi *self, int code, const char *detail);

/** Begin the next part of an answer: separators between parts and between answers come by
 * themselves. `places` decimals, 0..18: 1234 with 3 is 1.234. */
DG_API void dg_scpi_put_number(struct dg_scpi *self, int64_t value, unsigned places);
/** The same without decimals and without a sign. */
DG_API void dg_scpi_put_unsigned(struct dg_scpi *self, uint64_t value);
/** As is. */
DG_API void dg_scpi_put_word(struct dg_scpi *self, const char *text);
/** In double quotes, those inside doubled. */
DG_API void dg_scpi_put_string(struct dg_scpi *self, const char *text);
/** Begin a part made of pieces, of which any number may be appended. */
DG_API void dg_scpi_begin(struct dg_scpi *self);
/** Append a text as it is. */
DG_API void dg_scpi_append(struct dg_scpi *self, const char *text);
/** Append a number, as dg_scpi_put_number() does. */
DG_API void dg_scpi_append_number(struct dg_scpi *self, int64_t value, unsigned places);
/** Append `digits` hexadecimal digits, 1..16, upper case, no prefix. */
DG_API void dg_scpi_append_hex(struct dg_scpi *self, uint64_t value, unsigned digits);

#ifdef __cplusplus
}
#endif

#endif
