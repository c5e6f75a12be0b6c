/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the INTERBUS encoders: what their files share.
 */
#ifndef DREHGEBER_INTERBUS_PRIVATE_H
#define DREHGEBER_INTERBUS_PRIVATE_H

#include "drehgeber/bits.h"
#include "drehgeber/interbus.h"

/** Words and bits of OUT (9.1). */
#define IB_RELEASE 0x80000000u
#define IB_FRABA_PRESET 0x60000000u
#define IB_CODE_MASK 0xFE000000u
#define IB_ANSWER_BITS 0xC0000000u
#define IB_READ_OUT_BIT 0x00010000u

/** Directions (5.3). */
#define IB_CLOCKWISE 3u
#define IB_COUNTERCLOCKWISE 4u

#define IB_SHIFT_IW_MAX 25u

/** The operating time is counted, and stored, in these. */
#define IB_TIME_UNIT DG_S(600)

/** Of dg_ib.lost and struct dg_ib_sent. */
#define IB_REGION_BIT(region) (1u << (region))

/** Bytes of a cam program in the EEPROM: masks, then on and off of each cam. */
#define IB_CAMS_SIZE (3u + 8u * DG_IB_CAMS)

/** In which modes a command exists. */
enum ib_modes {
    IB_IN_POSITION = 1, /**< position and speed mode */
    IB_IN_CAM = 2,
};

/** A handler's result beside answers and errors. */
enum ib_result {
    IB_ACCEPTED = 0, /**< no answer of its own */
    IB_IGNORED = 1,  /**< nothing happened; neither accepted nor refused */
};

/** Executes a command; returns its answer, an error, or enum ib_result. */
typedef uint32_t ib_handler(struct dg_ib *self, dg_ns now, uint32_t word);

/** One row of the command table: `word & mask == value` in one of `modes`. */
struct ib_command {
    uint32_t mask;
    uint32_t value;
    uint8_t modes;
    bool at_once; /**< handled in the next cycle, not after param_cycles */
    ib_handler *handler;
};

/** command.c: the table, and everything between OUT and a handler. */
extern const struct ib_command dg_ib_commands[];
extern const uint8_t dg_ib_command_count;
/** OUT is another one: a new command begins to wait. */
void dg_ib_sample(struct dg_ib *self, uint32_t out);
/** One cycle has passed while a command waits: execute it if it is due. */
void dg_ib_execute(struct dg_ib *self, dg_ns now);
/** The error `word` is shown from now on. */
void dg_ib_refuse(struct dg_ib *self, uint32_t word);

/** position.c */
bool dg_ib_fits(const struct dg_ib_model *model, uint32_t steps, uint32_t revolutions);
/** Steps of the whole range of a K3 with this gear factor, which has to fit. */
uint32_t dg_ib_range_of(const struct dg_ib_model *model, uint32_t steps, uint32_t revolutions);
/** What the shaft does at the latch. */
struct ib_latch {
    dg_angle angle;
    int32_t mrpm;
};
uint32_t dg_ib_speed(const struct dg_ib *self, int32_t mrpm);
/** dg_ib_position() at an angle. */
uint32_t dg_ib_position_at(const struct dg_ib *self, dg_angle angle);
/** The offset that makes the position at `now` the preset. */
uint32_t dg_ib_preset_offset(const struct dg_ib *self, dg_ns now);

/** cam.c: the word of the cam mode, without bit 31. */
uint32_t dg_ib_cam_word(const struct dg_ib *self, dg_angle angle);
/** readout.c: the value of the item in force, or the error. */
uint32_t dg_ib_item(const struct dg_ib *self);

/** memory.c */
int dg_ib_model_check(const struct dg_ib_model *model);
/** The EEPROM of `model`, or NULL: it has none. */
const struct dg_store_layout *dg_ib_layout_of(const struct dg_ib_model *model);
/** Mount it, grown when it is of an earlier release. @return as dg_store_mount() */
int dg_ib_mount(struct dg_store *self, const struct dg_ib_model *model, struct dg_nvm nvm);
/** Working copy from every region that is in order; the others are lost and have their defaults. */
void dg_ib_load(struct dg_ib *self);
/** Read cam program 1..8; a lost one is empty. */
void dg_ib_load_program(struct dg_ib *self, uint8_t number, struct dg_ib_program *out);
/** Store a region; it is not lost any more. @return false: not stored */
bool dg_ib_put_u32(struct dg_ib *self, uint8_t region, uint32_t value);
bool dg_ib_put_u8(struct dg_ib *self, uint8_t region, uint8_t value);
bool dg_ib_put_preset(struct dg_ib *self, uint32_t preset, uint32_t offset, bool flag);
/** Store what waits, all or nothing; then it is in force. */
bool dg_ib_put_sent(struct dg_ib *self, const struct dg_ib_sent *sent);
bool dg_ib_put_program(struct dg_ib *self, const struct dg_ib_program *program);
/** Delivery state of the profile's parameters and of whatever is lost, all or nothing. */
bool dg_ib_put_defaults(struct dg_ib *self);

/** Handlers, by file. */
ib_handler dg_ib_normal, dg_ib_release, dg_ib_activate_preset, dg_ib_fraba_preset; /* parameter.c */
ib_handler dg_ib_set_steps, dg_ib_set_revolutions, dg_ib_set_direction, dg_ib_set_preset;
ib_handler dg_ib_set_shift, dg_ib_set_defaults, dg_ib_set_mode;
ib_handler dg_ib_read_out;                                                        /* readout.c */
ib_handler dg_ib_set_program, dg_ib_set_mask, dg_ib_set_shift_iw, dg_ib_set_edge; /* cam.c */
ib_handler dg_ib_read_mask, dg_ib_read_edge, dg_ib_read_shift_iw;

#endif
