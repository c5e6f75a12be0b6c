/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A test rig for the S36 with BiSS: slaves with their world and EEPROMs on one line in virtual
 * time, and a master as simple as can be. Everything lives in the struct; a rig may be saved and
 * put back by assignment, to the same place only.
 */
#ifndef TESTS_SUPPORT_BISS_RIG_H
#define TESTS_SUPPORT_BISS_RIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/biss.h"
#include "ram_nvm.h"

/** Negative results of an access; what is not negative counts bytes. */
enum {
    BISS_RIG_SILENT = -1,  /**< no echo of R */
    BISS_RIG_REFUSED = -2, /**< R = W, or P = 1; a write to nobody looks like R = W */
    BISS_RIG_STUCK = -3,   /**< no S within the longest busy time */
    BISS_RIG_CRC = -4,     /**< data echoed or read with a wrong CRC */
};

struct biss_rig {
    struct dg_world world;
    dg_angle angle;       /**< of the shaft, at time 0 */
    int64_t angle_per_us; /**< speed */
    struct dg_biss_model model;
    struct dg_biss slave[DG_BISS_CHAIN_MAX]; /**< [0] is nearest to the master */
    struct ram_nvm nvm[DG_BISS_CHAIN_MAX];
    uint8_t count;

    dg_ns now;
    dg_ns half_ns;     /**< half a clock period; 500 ns from biss_rig_init() */
    uint32_t jitter;   /**< permille of it, either way */
    uint32_t noise;    /**< state of the jitter */
    bool words;        /**< dg_biss_frame() instead of edges, with one slave */
    uint64_t frames;   /**< so far */
    uint32_t clocks;   /**< rising edges after e1 until the start bit, of the last frame */
    uint64_t bits;     /**< what came behind the CDS bit in the last frame, right-aligned */
    uint8_t data_bits; /**< how many of them are clocked; as many as the slaves have */
    bool p;            /**< the last stop bit received */
};

/** A healthy world, shaft at angle 0, `count` formatted slaves of `model`, off. @return
 * dg_biss_init()'s */
int biss_rig_init(struct biss_rig *self, const struct dg_biss_model *model, uint8_t count);

/** Power on, and wait for the end of the initialisation. @return dg_biss_power_on()'s of slave 0 */
int biss_rig_power_on(struct biss_rig *self);

/** MA is at `level`, a half period (with jitter) after the last edge. @return SL */
bool biss_rig_edge(struct biss_rig *self, bool level);

/** A frame up to its last bit. @return its CDS bit */
bool biss_rig_begin(struct biss_rig *self);

/** The CDM bit and the timeout of that frame. */
void biss_rig_end(struct biss_rig *self, bool cdm);

/** Both. @return the CDS bit */
bool biss_rig_frame(struct biss_rig *self, bool cdm);

/** A frame that is cut off after `edges` edges, the timeout waited for with MA high. */
void biss_rig_cut(struct biss_rig *self, uint32_t edges);

/** 14 frames with CDM = 0. */
void biss_rig_zeros(struct biss_rig *self);

/**
 * A frame for each character of `cdm`, '0' or '1', blanks ignored. What comes back goes to `cds`
 * without blanks, with a 0 behind it.
 */
void biss_rig_send(struct biss_rig *self, const char *cdm, char *cds);

/** 14 zeros and the addressing of a register. @return CDS behind R and W: R << 1 | W; IDLs lost */
unsigned biss_rig_address(struct biss_rig *self, uint8_t id, uint8_t address, bool write);

/** Read or write `n` registers in one control frame. @return how many were not refused, or why not
 * even one */
int biss_rig_read(struct biss_rig *self, uint8_t id, uint8_t address, uint8_t *bytes, size_t n);
int biss_rig_write(struct biss_rig *self, uint8_t id, uint8_t address, const uint8_t *bytes,
                   size_t n);

/** One register of slave 0. @return the byte or a negative result as above */
int biss_rig_get(struct biss_rig *self, uint8_t address);
/** @return 1 or a negative result as above */
int biss_rig_put(struct biss_rig *self, uint8_t address, uint8_t value);

/** A command; `ids` has IDS0 as its highest bit, 0 is a broadcast. @return IDA, likewise */
uint8_t biss_rig_command(struct biss_rig *self, uint8_t ids, uint8_t command);

/** CRC4 worked out here and not by the library. */
uint8_t biss_rig_crc4(unsigned bits, unsigned n);
/** CRC6 likewise. */
uint8_t biss_rig_crc6(uint64_t bits, unsigned n);

#endif
