/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the S36 BiSS slave: what its files share.
 */
#ifndef DREHGEBER_BISS_PRIVATE_H
#define DREHGEBER_BISS_PRIVATE_H

#include "drehgeber/biss.h"

/** The part of the address space that 40h banks, and the end of each part (5.2.2.3). */
#define BISS_WINDOW_END 0x3Fu
#define BISS_ADDRESS_END 0x7Fu
/** Bank 0 as far as it is implemented. */
#define BISS_CONFIG_FIRST 0x1Bu
#define BISS_CONFIG_LAST 0x23u
#define BISS_CONFIG_SIZE (BISS_CONFIG_LAST - BISS_CONFIG_FIRST + 1u)
/** Places in dg_biss.config. */
#define BISS_DIR 0u
#define BISS_EMASK (0x22u - BISS_CONFIG_FIRST)
#define BISS_WMASK (0x23u - BISS_CONFIG_FIRST)
#define BISS_DIR_BIT 0x04u

/** Of MT and ST in a frame without a form, which may have a life counter. */
#define BISS_USUAL_BITS_MAX                                                                        \
    (DG_BISS_FRAME_BITS_MAX - DG_BISS_FLAG_BITS - DG_BISS_LIFE_BITS - DG_BISS_CRC_BITS)

/** What can be done with a register. */
enum biss_access {
    BISS_READ = 1,
    BISS_WRITE = 2,
    BISS_EEPROM = 4, /**< takes its time */
    BISS_EDS = 8,    /**< of models with an EDS */
};

/** Reads the register `offset` places behind the first of its row; `now` is the end of the timeout.
 * @return DG_OK, or anything else when there is no value */
typedef int biss_read(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value);
/** Writes it. @return DG_OK, or anything else when it is not there */
typedef int biss_write(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t value);

/** A row of the register table: addresses of one kind in a range of banks. */
struct biss_register {
    uint8_t bank_first; /**< banks mean nothing from 40h on */
    uint8_t bank_last;
    uint8_t first;
    uint8_t last;
    uint8_t access; /**< enum biss_access */
    biss_read *read;
    biss_write *write;
};

/** registers.c */
extern const struct biss_register dg_biss_registers[];
extern const uint8_t dg_biss_register_count;
/** The row when the access is possible now, or NULL: refused. */
const struct biss_register *dg_biss_permitted(const struct dg_biss *self, dg_ns now,
                                              uint8_t address, bool write);

/** eds.c: byte `offset` of a bank. */
uint8_t dg_biss_eds_common(const struct dg_biss_model *model, uint8_t offset);
uint8_t dg_biss_eds_profile(const struct dg_biss_model *model, uint8_t offset);

/** frame.c: MT, ST, nERR and nWARN in bits; LC in bits, 0 without one. */
uint8_t dg_biss_position_bits(const struct dg_biss_model *model);
uint8_t dg_biss_life_bits(const struct dg_biss_model *model);
/** What was latched last, with the `flags` of dg_biss_flags(), into `bits`: all behind CDS.
 * @return how many */
uint8_t dg_biss_frame_encode(const struct dg_biss *self, uint8_t flags, uint64_t *bits);

/** form.c: what makes frames of other forms; its figures are those of frames without one. */
extern const struct dg_biss_form dg_biss_any_form;
/** form.c: count the bits of `form`, which is that of `model`, if it fits. @return NULL, or what
 * would be right, in words */
const char *dg_biss_form_settle(const struct dg_biss_model *model, struct dg_biss_form *form);

/** factory.c */
/** Its figures are within their ranges, and fit together. */
bool dg_biss_model_ok(const struct dg_biss_model *model);
/** The EEPROM of `model`. */
const struct dg_store_layout *dg_biss_layout_of(const struct dg_biss_model *model);
/** Mount it, grown when it is of an earlier release. @return as dg_store_mount() */
int dg_biss_mount(struct dg_store *self, const struct dg_biss_model *model, struct dg_nvm nvm);
/** Everything but line, counters and setup begins anew at `now`. @return dg_store_mount()'s */
int dg_biss_restart(struct dg_biss *self, dg_ns now);
/** The EEPROM can be used. */
bool dg_biss_eeprom(const struct dg_biss *self);

/** sense.c: latch the position. @return number of data bits, put into `bits` */
uint8_t dg_biss_latch(struct dg_biss *self, dg_ns now, uint64_t *bits);
bool dg_biss_initialising(const struct dg_biss *self, dg_ns now);

/** control.c: the CDS bit of this frame; `sli` is the neighbour's. Takes the ID, if it is due. */
bool dg_biss_cds(struct dg_biss *self, bool sli);
/** The timeout of a frame ended at `now`. */
void dg_biss_cdm(struct dg_biss *self, dg_ns now, bool cdm);

#endif
