/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the S36 RS485 device: what its files share.
 */
#ifndef DREHGEBER_HIPERFACE_PRIVATE_H
#define DREHGEBER_HIPERFACE_PRIVATE_H

#include "drehgeber/bits.h"
#include "drehgeber/hiperface.h"

/** Field number of the extended type label, its size and its status byte (5.1.1.2.2). */
#define HF_LABEL 0xFFu
#define HF_LABEL_SIZE 64u
#define HF_LABEL_STATUS 0x83u

/** Most data fields there can be: 70h blocks of 16 bytes. */
#define HF_FIELDS_MAX 112u
#define HF_BLOCK 16u

/** Shortest frame: address, command, check sum. */
#define HF_FRAME_LEAST 3u

/** A command that carries data beyond this does not exist. */
#define HF_DATA_MAX (DG_HF_FRAME_MAX - 3u)

/** Locks until the next start (5.1.3), and what a locked command answers. */
enum hf_lock {
    HF_LOCK_POSITION = 0x01, /**< 02h */
    HF_LOCK_FIELDS = 0x02,   /**< 03h: memory size or table of the data fields damaged */
    HF_LOCK_EEPROM = 0x04,   /**< 05h */
    HF_LOCK_CHECKSUM = 0x08, /**< 06h */
    HF_LOCK_WRITE = 0x10,    /**< 03h: a damaged data field was found in operation */
    HF_LOCK_UART = 0x20,     /**< 03h: UART settings damaged */
    HF_LOCK_CODES = 0x40,    /**< 03h: access codes damaged */
    HF_LOCK_PARTITION = HF_LOCK_FIELDS | HF_LOCK_WRITE | HF_LOCK_UART | HF_LOCK_CODES,
};

/** What a command is bound to besides locks. */
enum hf_flags {
    HF_CODE0 = 0x80, /**< its last byte is Code 0 */
};

/** A request whose frame is in order, and the reply under construction. */
struct hf_request {
    dg_ns now;
    const uint8_t *data;
    uint16_t length; /**< of data */
    struct dg_writer reply;
};

/** Executes a command whose general checks are passed. */
typedef enum dg_hf_status hf_handler(struct dg_hf *self, struct hf_request *rq);

/** One row of the command table. */
struct hf_command {
    uint8_t code;
    uint8_t request_min;
    uint8_t request_max;
    uint8_t reply_max;
    uint8_t reaction_ms;
    uint8_t flags;
    hf_handler *handler; /**< NULL: encoder reset, which the line itself performs */
};

/** command.c: the table, and everything between a frame and its handler (R8). */
extern const struct hf_command dg_hf_commands[];
extern const uint8_t dg_hf_command_count;
/** Row of a code, or dg_hf_command_count. */
uint8_t dg_hf_command_find(uint8_t code);
/** The protocol group's verdict on the frame in `self`, which is complete now. */
void dg_hf_check_frame(struct dg_hf *self);
/** Execute the frame in `self`, which was checked, and send the reply. */
void dg_hf_answer(struct dg_hf *self, dg_ns now);

/** status.c */
void dg_hf_push(struct dg_hf *self, enum dg_hf_status status);
/** A damaged data field in operation: saved with 06h, writing is locked (R24). Always 03h. */
enum dg_hf_status dg_hf_corrupt(struct dg_hf *self);
void dg_hf_start_up_checks(struct dg_hf *self);
void dg_hf_monitor(struct dg_hf *self);
/** The wire's view of a result of the store. */
enum dg_hf_status dg_hf_io(int result);
/** Read a whole region, whether it is in order or not. */
enum dg_hf_status dg_hf_get(struct dg_hf *self, enum dg_hf_region region, void *to);
/** Write a whole region, durably. */
enum dg_hf_status dg_hf_put(struct dg_hf *self, enum dg_hf_region region, const void *from);

/** factory.c */
/** The EEPROM of `model`. */
static inline const struct dg_store_layout *dg_hf_layout_of(const struct dg_hf_model *model)
{
    return model->layout != NULL ? model->layout : &dg_hf_layout;
}

/** Mount it, grown when it is of an earlier release. @return as dg_store_mount() */
int dg_hf_mount(struct dg_store *self, const struct dg_hf_model *model, struct dg_nvm nvm);
/** As dg_stack.differs. */
const char *dg_hf_differs(const struct dg_hf_model *model, struct dg_store *store);
/** As dg_stack.serial. */
int64_t dg_hf_serial(struct dg_store *store);
int dg_hf_model_check(const struct dg_hf_model *model);
/** Working copy from the model, then from every region that is in order. */
void dg_hf_load(struct dg_hf *self, bool mounted);

/** Handlers, by file. */
hf_handler dg_hf_read_position, dg_hf_set_position, dg_hf_set_synchronous; /* position.c */
hf_handler dg_hf_read_data, dg_hf_save_data, dg_hf_field_status, dg_hf_create_field; /* field.c */
hf_handler dg_hf_available_memory;
hf_handler dg_hf_read_status; /* status.c */
hf_handler dg_hf_read_analog, dg_hf_read_counter, dg_hf_count_up, dg_hf_erase_counter; /* unit.c */
hf_handler dg_hf_modify_key, dg_hf_read_type_label, dg_hf_assign_address, dg_hf_read_serial;
hf_handler dg_hf_configure_uart;

#endif
