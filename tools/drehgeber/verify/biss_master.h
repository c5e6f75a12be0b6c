/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A BiSS C master, written from the protocol description alone: own frame logic, own check sums. It
 * drives MA, samples SL, and shares no code with the slaves it talks to. Its time is virtual. A line
 * that has a time of its own and is late moves `now` of its master on.
 *
 *         e1  e2  e3      eS  eS+1            last        timeout
 *   MA ‾\_/‾\_/‾\_/‾\_/‾\_/‾\_/‾\_/‾ ... ‾\_/‾\_/‾‾‾‾‾‾‾‾‾‾‾‾   CDM = 0
 *                                                \________/‾‾   CDM = 1
 *   SL ‾‾‾‾‾‾‾\_Ack_______/ S  |CDS|D .. D|C .... C\________/‾‾
 *
 * A bit is what SL shows at the end of its clock, just before the next rising edge.
 */
#ifndef DREHGEBER_VERIFY_BISS_MASTER_H
#define DREHGEBER_VERIFY_BISS_MASTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/time.h"

/** Slaves of a chain that get an ID. */
#define BISS_SLAVES_MAX 8u
/** Registers of one sequential access. */
#define BISS_SEQUENCE_MAX 64u
/** Data and check bits of one frame. */
#define BISS_BITS_MAX 512u
/** Frames of one control frame that are recorded. */
#define BISS_RECORD_MAX 2048u

/** The two lines. */
struct biss_line {
    /** Drive MA to `level` at `now`. @return SL after it */
    bool (*ma)(void *ctx, dg_ns now, bool level);
    /** @return SL at `now`, MA left alone */
    bool (*sl)(void *ctx, dg_ns now);
    void *ctx;
};

/** Data channel of a slave: multiturn, singleturn, nERR, nWARN, life counter, inverted CRC6. */
struct biss_channel {
    uint8_t mt_bits;
    uint8_t st_bits;
    uint8_t lc_bits; /**< 0 or 6 */
};

/** What a data channel carried. */
struct biss_word {
    uint64_t position; /**< multiturn and singleturn together */
    bool n_error;
    bool n_warning;
    uint8_t lc;
    uint8_t crc; /**< as sent: inverted */
    bool crc_good;
};

/** One frame. */
struct biss_frame {
    dg_ns latch;              /**< e1 */
    bool acknowledged;        /**< SL was high before e1 and after it, and low after e2 */
    bool started;             /**< a start bit came within the patience */
    bool cds;                 /**< control data of the slaves */
    bool stopped;             /**< SL was low after the last bit */
    bool timed_out;           /**< SL went high again behind the last edge */
    unsigned start_edge;      /**< rising edge of the start bit; 3 is the earliest */
    unsigned falling_changes; /**< changes of SL at falling edges or between edges; must be 0 */
    dg_ns timeout;            /**< from the last MA edge until SL went high */
    char bits[BISS_BITS_MAX]; /**< everything behind CDS as '0' and '1', terminated */
    struct biss_word words[BISS_SLAVES_MAX]; /**< in the order they arrive */
};

/** A master and its configuration; plain data. */
struct biss_master {
    struct biss_line line;
    dg_ns now;
    dg_ns period_ns;         /**< of MA: 100 (10 MHz) to 20 000 (50 kHz) */
    unsigned jitter_percent; /**< of a half period, either way */
    unsigned extra_clocks;   /**< behind the last check bit */
    size_t channel_count;    /**< data channels, in the order they arrive */
    struct biss_channel channels[BISS_SLAVES_MAX];
    unsigned disturbed; /**< the CDS bit of the n-th frame from now arrives inverted; 0: of none */
    bool stray; /**< a master that cannot answer in the same frame: CDM = 1 in frame 19 of a read */
    dg_ns timeout_max; /**< how long it waits for SL behind a frame; 40 us, more on slow lines */

    /* state */
    bool ma;
    bool sl;
    bool fresh; /**< the next frame is the first of a start: SL is not looked at before its e1 */
    uint32_t noise;                /**< of the jitter */
    char cdm[BISS_RECORD_MAX + 1]; /**< one character per frame since biss_master_record() */
    char cds[BISS_RECORD_MAX + 1];
    size_t recorded;
    unsigned bad_frames; /**< without Ack, start, stop, timeout, or with a bad CRC; counted up */
    const char *fault;   /**< of the latest of these, in words */
    unsigned frames;     /**< counted up */
};

/** A register access, and what came of it. */
struct biss_access {
    bool write;
    uint8_t id;
    uint8_t address;
    size_t n;                        /**< registers wanted, 1..BISS_SEQUENCE_MAX */
    uint8_t data[BISS_SEQUENCE_MAX]; /**< written, or read */
    uint8_t address_flips;           /**< bits of the address CRC sent wrong */
    uint8_t data_flips;              /**< bits of the data CRC sent wrong */
    dg_ns patience;                  /**< longest busy waited for; 0: 20 ms (tbusy_r) */

    uint16_t idl;  /**< bit n: IDLn */
    bool r;        /**< echo */
    bool w;        /**< echo */
    bool late;     /**< no start bit within the patience; given up */
    bool crc_good; /**< of all bytes returned; of a write also that they are those sent */
    bool stop;     /**< last P received: 1 means that register was refused */
    size_t done;   /**< bytes exchanged */
    unsigned busy[BISS_SEQUENCE_MAX]; /**< frames the start bit of a byte was late */
};

/** A command, and what came of it. */
struct biss_command {
    uint8_t ids;       /**< bit n addresses ID n; 0: broadcast */
    uint8_t code;      /**< 0..3 */
    bool execute;      /**< EX */
    bool reduced;      /**< in reduced frames; broadcast only */
    uint8_t crc_flips; /**< bits of the CRC sent wrong */

    uint16_t idl; /**< bit n: IDLn */
    uint8_t ida;  /**< bit n: ID n acknowledged */
};

/** CRC over '0' and '1' characters, most significant first, start value 0, not inverted. */
uint8_t biss_crc4(const char *bits, size_t n);
uint8_t biss_crc6(const char *bits, size_t n);

/** 1 MHz, no jitter, no channel, MA high. */
void biss_master_init(struct biss_master *self, struct biss_line line, dg_ns now);

/** Drive one edge half a period (with jitter) after the last one. @return SL after it */
bool biss_master_edge(struct biss_master *self, bool level);

/** Clock a frame up to its last bit. CDM can still be chosen: frame->cds is known. */
void biss_master_clock(struct biss_master *self, struct biss_frame *frame);

/** End it: hold MA, wait for the slaves' timeout, return MA to high. */
void biss_master_end(struct biss_master *self, struct biss_frame *frame, bool cdm);

/** Both. */
void biss_master_frame(struct biss_master *self, struct biss_frame *frame, bool cdm);

/** A reduced frame: two clocks and the timeout. */
void biss_master_reduced(struct biss_master *self, struct biss_frame *frame, bool cdm);

/** Forget the recorded control bits. */
void biss_master_record(struct biss_master *self);

/** One frame for each '0' or '1' of `cdm`; what came back is in `self->cds`. */
void biss_master_bits(struct biss_master *self, const char *cdm);

/** 14 zeros, then the access. */
void biss_master_access(struct biss_master *self, struct biss_access *access);

/** 14 zeros, then the command. */
void biss_master_command(struct biss_master *self, struct biss_command *command);

#endif
