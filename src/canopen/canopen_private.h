/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the CANopen stack: what its files share. One file per service.
 */
#ifndef DREHGEBER_SRC_CO_H
#define DREHGEBER_SRC_CO_H

#include "drehgeber/bits.h"
#include "drehgeber/canopen.h"

/** Slots of the stack's own values in dg_co_node.value. */
enum co_slot {
    CO_SYNC_COB_ID,
    CO_SYNC_PERIOD_US,
    CO_SYNC_WINDOW_US,
    CO_GUARD_TIME_MS,
    CO_LIFE_FACTOR,
    CO_TIME_COB_ID,
    CO_EMCY_INHIBIT_100US,
    CO_CONSUMER_1,
    CO_CONSUMER_2,
    CO_HEARTBEAT_MS,
    CO_BEHAVIOUR_1, /* 1029h:1-3, in the order of enum dg_co_error_class */
    CO_BEHAVIOUR_2,
    CO_BEHAVIOUR_3,
    CO_TPDO_SLOTS, /* CO_TPDO(n, ...) */
};

/** Parameters of a TPDO, from CO_TPDO_SLOTS on. */
enum co_tpdo_slot {
    CO_PDO_COB_ID,
    CO_PDO_TYPE,
    CO_PDO_INHIBIT_100US,
    CO_PDO_EVENT_MS,
    CO_PDO_MAPPED,  /* sub 0 of 1A00h */
    CO_PDO_ENTRIES, /* 8 of them */
    CO_PDO_SLOTS = CO_PDO_ENTRIES + DG_CO_MAPPED_MAX,
};
#define CO_TPDO(n, parameter) (CO_TPDO_SLOTS + (n)*CO_PDO_SLOTS + (parameter))
_Static_assert(CO_TPDO(DG_CO_TPDOS, 0) <= DG_CO_SLOT_APPLICATION, "room for the stack's slots");

/** CAN-IDs of the predefined connection set; a node's own are the base plus its node-ID. */
#define CO_ID_NMT 0x000u
#define CO_ID_EMCY 0x080u
#define CO_ID_SDO_TX 0x580u
#define CO_ID_SDO_RX 0x600u
#define CO_ID_GUARD 0x700u
#define CO_ID_LSS_TX 0x7E4u
#define CO_ID_LSS_RX 0x7E5u

/** Bits of COB-IDs. */
#define CO_COB_INVALID 0x80000000u
#define CO_COB_BIT30 0x40000000u /* TPDO: no RTR; SYNC, TIME: producer */
#define CO_COB_EXTENDED 0x20000000u
#define CO_COB_CAN_ID 0x7FFu

/** CAN-ID of TPDO `n` in the predefined connection set. */
static inline uint32_t co_predefined(uint8_t n, uint8_t node_id)
{
    return 0x180u + 0x100u * n + node_id;
}

/* co_od.c: the dictionary */

/** The stack's rows, 1000h-1FFFh, sorted. */
extern const struct dg_co_object co_objects[];
extern const uint16_t co_object_count;
/** Find a row; `*abort` says whether index or sub is missing when NULL is returned. */
const struct dg_co_object *co_find(const struct dg_co_node *self, uint16_t index, uint8_t sub,
                                   enum dg_co_abort *abort);
/** Bytes of a row's type; 0 for strings. */
static inline uint8_t co_size(const struct dg_co_object *object)
{
    static const uint8_t sizes[] = {
        [DG_CO_I8] = 1,  [DG_CO_I16] = 2, [DG_CO_I32] = 4,    [DG_CO_U8] = 1,
        [DG_CO_U16] = 2, [DG_CO_U32] = 4, [DG_CO_STRING] = 0,
    };
    return sizes[object->type];
}
/** A value as it stands on the wire or in the memory, sign-extended where the type is signed. */
uint32_t co_extend(const struct dg_co_object *object, uint32_t value);
/** Whether a value is inside min..max. */
bool co_in_range(const struct dg_co_object *object, uint32_t value);
/** Read any row but a string, whatever its access. */
enum dg_co_abort co_read(struct dg_co_node *self, const struct dg_co_object *object,
                         uint32_t *value);
/** Write a row with DG_CO_W: range, hook, slot, hook again. */
enum dg_co_abort co_write(struct dg_co_node *self, const struct dg_co_object *object,
                          uint32_t value);
/** Default of a row for this node (the node-ID added where the row says so). */
uint32_t co_initial(const struct dg_co_node *self, const struct dg_co_object *object);
/** Call `visit` for every row of the node: the stack's, then the device's. */
void co_each(struct dg_co_node *self,
             void (*visit)(struct dg_co_node *self, const struct dg_co_object *object, void *ctx),
             void *ctx);
/** Whether a CAN-ID may not be given to a configurable COB-ID. */
bool co_restricted(uint32_t can_id);
/** Whether the node itself has a use for a CAN-ID: SYNC, EMCY, TIME if consumed, valid TPDOs. The
 * others it uses are restricted. */
bool co_in_use(const struct dg_co_node *self, uint32_t can_id);

/* co_storage.c: 1010h, 1011h, 2105h */

/** Mount the store and read what is not a value: bus parameters, serial number. */
int co_mount(struct dg_co_node *self);
/** Check the memory again, as every Initialisation does; bus parameters in force stay. */
void co_remount(struct dg_co_node *self);
/** Values of the rows from `first` to `last` index: defaults, then what 1010h has saved. False when
 * some of that cannot be read; those are the defaults. */
bool co_load(struct dg_co_node *self, uint16_t first, uint16_t last);
/** Keep bit rate (index of 2100h) and node-ID for the next start. */
enum dg_co_abort co_save_bus(struct dg_co_node *self, uint8_t bit_rate, uint8_t node_id);
/** 5100h when stored parameters are damaged, or not `loaded` (see co_load()). */
void co_report_memory(struct dg_co_node *self, bool loaded);

/* co_node.c */
void co_send(struct dg_co_node *self, uint16_t id, const uint8_t *data, uint8_t dlc);
/** The configured bit rate comes into force. */
void co_use_bit_rate(struct dg_co_node *self);
/** Enter Initialisation; `application` also resets 2000h-9FFFh (NMT 81h, LSS). */
void co_reset(struct dg_co_node *self, bool application);

/*
 * Services. *_start() sets the state after a reset (values are loaded). *_step() does what is due
 * at self->now and returns the next moment it wants to be called.
 */

/* co_nmt.c: state machine, guarding, heartbeat */
void co_nmt_start(struct dg_co_node *self);
void co_nmt_rx(struct dg_co_node *self, const struct dg_can_frame *frame);
void co_enter(struct dg_co_node *self, enum dg_co_state state);
void co_guard_rx(struct dg_co_node *self);
void co_heartbeat_rx(struct dg_co_node *self, const struct dg_can_frame *frame);
dg_ns co_nmt_step(struct dg_co_node *self);

/* co_emcy.c */
void co_emcy_start(struct dg_co_node *self);
dg_ns co_emcy_step(struct dg_co_node *self);
/** What 1029h says for a class of errors. */
void co_react(struct dg_co_node *self, enum dg_co_error_class class_of);

/* co_sdo.c, co_block.c */
void co_sdo_start(struct dg_co_node *self);
void co_sdo_rx(struct dg_co_node *self, const struct dg_can_frame *frame);
dg_ns co_sdo_step(struct dg_co_node *self);

/* co_pdo.c */
void co_pdo_start(struct dg_co_node *self);
/** The NMT state has become operational, or is not any more. */
void co_pdo_state(struct dg_co_node *self, bool operational);
void co_sync_rx(struct dg_co_node *self, const struct dg_can_frame *frame);
/** A remote frame: is it for one of this node's TPDOs? */
void co_pdo_rtr(struct dg_co_node *self, uint16_t id);
dg_ns co_pdo_step(struct dg_co_node *self);

/* co_lss.c */
void co_lss_start(struct dg_co_node *self);
void co_lss_rx(struct dg_co_node *self, const struct dg_can_frame *frame);
dg_ns co_lss_step(struct dg_co_node *self);
/** Whether the bus is silent because of a bit rate switch. */
static inline bool co_lss_silent(const struct dg_co_node *self)
{
    return self->now < self->lss.silent_until;
}

/* Hooks, by file. */
dg_co_hook co_hook_device, co_hook_sync_id, co_hook_time_id;
dg_co_hook co_hook_identity, co_hook_clock;                         /* co_od.c */
dg_co_hook co_hook_error_register, co_hook_status, co_hook_history; /* co_emcy.c */
dg_co_hook co_hook_consumer, co_hook_heartbeat;                     /* co_nmt.c */
dg_co_hook co_hook_store, co_hook_restore;                          /* co_storage.c */
dg_co_hook co_hook_tpdo, co_hook_mapping;                           /* co_pdo.c */

#endif
