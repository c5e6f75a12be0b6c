/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A CANopen slave: CiA 301 V4.2 communication and CiA 305 layer setting services. What a device is
 * (its profile's objects, defaults, bit rates, identity) stands in a struct dg_co_device;
 * src/cia406 has some. What the standards leave open is decided in src/canopen/README.md.
 *
 * Frames and time go in, frames come out. SYNC, RTR and SDO requests are answered inside
 * dg_co_rx(); what waits for time happens in dg_co_step(). All state lives in the caller's struct
 * dg_co_node, plain data without pointers into itself; any number can live side by side.
 */
#ifndef DREHGEBER_CANOPEN_H
#define DREHGEBER_CANOPEN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/frame.h"
#include "drehgeber/hal.h"
#include "drehgeber/store.h"
#include "drehgeber/time.h"
#include "drehgeber/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/** TPDOs of a node, entries a TPDO can map, heartbeat consumers, depth of 1003h. */
#define DG_CO_TPDOS 4u
#define DG_CO_MAPPED_MAX 8u
#define DG_CO_CONSUMERS 2u
#define DG_CO_HISTORY 8u
/** Values a dictionary can keep (rows with a slot). */
#define DG_CO_VALUES_MAX 93u
/** Longest string in a dictionary. */
#define DG_CO_STRING_MAX 32u
/** Node-ID of a node that has none yet (CiA 305). */
#define DG_CO_UNCONFIGURED 0xFFu

/** NMT states, with the values of heartbeats. */
enum dg_co_state {
    DG_CO_BOOT = 0x00,
    DG_CO_STOPPED = 0x04,
    DG_CO_OPERATIONAL = 0x05,
    DG_CO_PRE_OPERATIONAL = 0x7F,
    DG_CO_OFF = 0xFF, /**< no power; never on the wire */
};

/** SDO abort codes; 0 is success. Hooks return them, too. */
enum dg_co_abort {
    DG_CO_OK = 0,
    DG_CO_TOGGLE = 0x05030000,
    DG_CO_TIMEOUT = 0x05040000,
    DG_CO_SPECIFIER = 0x05040001,
    DG_CO_BLOCK_SIZE = 0x05040002,
    DG_CO_SEQUENCE = 0x05040003,
    DG_CO_CRC = 0x05040004,
    DG_CO_ACCESS = 0x06010000,
    DG_CO_WRITE_ONLY = 0x06010001, /**< read of a write-only object */
    DG_CO_READ_ONLY = 0x06010002,  /**< write of a read-only object */
    DG_CO_NO_OBJECT = 0x06020000,
    DG_CO_NOT_MAPPABLE = 0x06040041,
    DG_CO_PDO_LENGTH = 0x06040042,
    DG_CO_INCOMPATIBLE = 0x06040043,
    DG_CO_HARDWARE = 0x06060000,
    DG_CO_LENGTH = 0x06070010,
    DG_CO_TOO_LONG = 0x06070012,
    DG_CO_TOO_SHORT = 0x06070013,
    DG_CO_NO_SUB = 0x06090011,
    DG_CO_RANGE = 0x06090030,
    DG_CO_STORE = 0x08000020,
    DG_CO_STATE = 0x08000022,
    DG_CO_NO_DATA = 0x08000024,
};

/* ---------------------------------------------------------------- the dictionary */

struct dg_co_node;
struct dg_co_object;

/** Data types, with the numbers of CiA 301. */
enum dg_co_type {
    DG_CO_I8 = 0x02,
    DG_CO_I16 = 0x03,
    DG_CO_I32 = 0x04,
    DG_CO_U8 = 0x05,
    DG_CO_U16 = 0x06,
    DG_CO_U32 = 0x07,
    DG_CO_STRING = 0x09, /**< default is the index into dg_co_device.strings */
    DG_CO_WIDE = 0x0B,   /**< low 32 of 64 bits, for PDOs; the row in front has the others */
    DG_CO_TYPE_COUNT
};

/** Properties of a row. */
enum dg_co_flags {
    DG_CO_R = 1,        /**< may be read */
    DG_CO_W = 2,        /**< may be written */
    DG_CO_RW = 3,       /**< both */
    DG_CO_MAP = 4,      /**< may be mapped into a TPDO; the row stands for one sub-index */
    DG_CO_ID = 8,       /**< the node-ID is added to the default; with DG_CO_SLOT */
    DG_CO_SAVE = 16,    /**< 1010h keeps it: the stack's in regions of their own, the device's in
                           DG_CO_REGION_APPLICATION */
    DG_CO_SLOT = 32,    /**< has a value in dg_co_node.value; without it the default or the hook */
    DG_CO_CONST = 64,   /**< never changes; an EDS says const */
    DG_CO_GAP = 128,    /**< in its region a byte in front of it stays free: layouts never shrink */
    DG_CO_EVENT = 256,  /**< dg_co_pdo_event() sends TPDOs that map it when it has changed */
    DG_CO_ACTION = 512, /**< not to be written back: ObjFlags=1 in an EDS */
    DG_CO_LIVE = 1024,  /**< what is read is no setting: no default in an EDS */
    DG_CO_FIGURE = 2048, /**< a row of dg_co_device.figures, if there is one, has its
                              default; with DG_CO_SLOT */
};

/** What a hook is called for. */
enum dg_co_op {
    DG_CO_READ,  /**< `*value` is the slot's value or the default; replace it by the current one */
    DG_CO_WRITE, /**< `*value` is wanted and inside min..max; refuse or adapt it */
    DG_CO_WRITTEN, /**< `*value` has just been stored in the slot; act on it */
};

/**
 * Behaviour of a row. `node->now` is the moment. Signed values are sign-extended to 32 bits.
 * For DG_CO_WRITTEN the result is ignored.
 */
typedef enum dg_co_abort dg_co_hook(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value);

/** The definition of a hook that only tells: `*value` is `what`, an expression of `node`. */
#define DG_CO_TELL(hook, what)                                                                     \
    enum dg_co_abort hook(struct dg_co_node *node, const struct dg_co_object *object,              \
                          enum dg_co_op op, uint32_t *value)                                       \
    {                                                                                              \
        (void)object;                                                                              \
        (void)op;                                                                                  \
        *value = (what);                                                                           \
        return DG_CO_OK;                                                                           \
    }

/**
 * One row of a dictionary: a sub-index of an object, or some in a row that are alike. Const, 12
 * bytes, as flash is what a dictionary costs; made by DG_CO_ROW().
 */
struct dg_co_row {
    uint32_t key;     /**< index, sub-index, number of the limits, how many more are alike */
    uint16_t flags;   /**< enum dg_co_flags; enum dg_co_type above them */
    uint8_t slot;     /**< in dg_co_node.value, with DG_CO_SLOT; of the first */
    uint8_t hook;     /**< its number, or 0 */
    uint32_t initial; /**< default; signed ones sign-extended */
};
/** Index and sub-index as rows are sorted by them. */
#define DG_CO_KEY(index, sub) ((uint32_t)(index) << 16 | (uint32_t)(sub) << 8)
/**
 * A row: `more` (0..15) sub-indices behind are alike, with a slot each; `limits` (0..15) and `hook`
 * are places in the tables of its dictionary, or 0. Without limits all that the type holds may
 * be written.
 */
#define DG_CO_ROW(index, sub, more, type, flags, slot, initial, limits, hook)                      \
    {                                                                                              \
        DG_CO_KEY(index, sub) | (uint32_t)(limits) << 4 | (more),                                  \
            (uint16_t)((type) << 12 | (flags)), slot, hook, initial                                \
    }

/** In a file with a table of rows: enum { DG_CO_SHORT_FLAGS };, enum dg_co_flags as letters. */
#define DG_CO_SHORT_FLAGS                                                                          \
    R = DG_CO_R, W = DG_CO_W, M = DG_CO_MAP, I = DG_CO_ID, S = DG_CO_SAVE, V = DG_CO_SLOT,         \
    C = DG_CO_CONST, G = DG_CO_GAP, E = DG_CO_EVENT, X = DG_CO_ACTION, L = DG_CO_LIVE,             \
    F = DG_CO_FIGURE

/** What may be written; signed ones sign-extended, and compared as the type says. */
struct dg_co_limits {
    uint32_t min;
    uint32_t max;
};

/** Rows, and what the numbers in them stand for. */
struct dg_co_dictionary {
    const struct dg_co_row *rows; /**< sorted by index and sub-index, at least one */
    uint16_t count;
    uint16_t power;                    /**< the highest power of two that is not above `count` */
    const struct dg_co_limits *limits; /**< by number; 0 is none */
    dg_co_hook *const *hooks;          /**< by number; the one of 0 is NULL */
};

/** The first three members of a dictionary from an array of at most 255 rows. */
#define DG_CO_ROWS(array)                                                                          \
    (array), sizeof(array) / sizeof((array)[0]), DG_CO_POWER(sizeof(array) / sizeof((array)[0]))
#define DG_CO_POWER(count)                                                                         \
    ((count) >> 7 != 0   ? 128                                                                     \
     : (count) >> 6 != 0 ? 64                                                                      \
     : (count) >> 5 != 0 ? 32                                                                      \
     : (count) >> 4 != 0 ? 16                                                                      \
     : (count) >> 3 != 0 ? 8                                                                       \
     : (count) >> 2 != 0 ? 4                                                                       \
     : (count) >> 1 != 0 ? 2                                                                       \
                         : 1)

/** A sub-index as it was found: what a hook is called with. */
struct dg_co_object {
    const struct dg_co_row *row;
    const struct dg_co_dictionary *dictionary; /**< of the row: the stack's or the device's */
    uint8_t slot; /**< in dg_co_node.value, with DG_CO_SLOT; these three as a row's key has them */
    uint8_t sub;
    uint16_t index;
};

/** Default of a row with DG_CO_FIGURE, where the device or the model says it. Those of the stack's
 * rows are all that can be written and saved, but for COB-IDs: TPDOs as delivered. */
struct dg_co_figure {
    uint32_t key; /**< DG_CO_KEY() */
    uint32_t initial;
};

/** Classes of 1029h. */
enum dg_co_error_class {
    DG_CO_CLASS_NONE, /**< no reaction */
    DG_CO_CLASS_COMMUNICATION,
    DG_CO_CLASS_DEVICE,
    DG_CO_CLASS_MANUFACTURER,
};

/** A cause of an EMCY. A table of them belongs to the device; the first ones are the stack's. */
struct dg_co_cause {
    uint16_t code;    /**< EMCY code */
    uint8_t reg;      /**< error register while the cause lasts */
    uint8_t class_of; /**< enum dg_co_error_class */
};

/** Causes of the stack itself; a device's own begin at DG_CO_CAUSES. */
enum dg_co_stack_cause {
    DG_CO_CAUSE_OVERRUN,   /**< 8110h */
    DG_CO_CAUSE_PASSIVE,   /**< 8120h */
    DG_CO_CAUSE_BUS_OFF,   /**< 8140h when it is over */
    DG_CO_CAUSE_LIFE,      /**< 8130h life guarding */
    DG_CO_CAUSE_HEARTBEAT, /**< 8130h, a consumer's node is silent; one more for the second */
    DG_CO_CAUSE_HEARTBEAT_2,
    DG_CO_CAUSE_SYNC_LENGTH, /**< 8240h */
    DG_CO_CAUSE_MEMORY,      /**< 5100h: stored parameters are damaged */
    DG_CO_CAUSES
};

/** Slots of the bus parameters, for which a device has rows of its own or none, and the first slot
 * a device profile may use for itself. */
#define DG_CO_SLOT_BIT_RATE 67u
#define DG_CO_SLOT_NODE_ID 68u
#define DG_CO_SLOT_TERMINATION 69u
#define DG_CO_SLOT_APPLICATION 70u

/** Regions of the store that the stack itself uses, in this order at the start of every layout. */
enum dg_co_region {
    DG_CO_REGION_BUS,           /**< "bus": number of the bit rate, node-ID, termination */
    DG_CO_REGION_SAVED,         /**< "saved": 1 when 1010h has been used since 1011h */
    DG_CO_REGION_COMMUNICATION, /**< "communication": 1005h-1029h */
    DG_CO_REGION_TPDO1,         /**< "tpdo1": 1800h and 1A00h; three more follow */
    DG_CO_REGION_TPDO2,
    DG_CO_REGION_TPDO3,
    DG_CO_REGION_TPDO4,
    DG_CO_REGION_SERIAL,      /**< "serial": the serial number */
    DG_CO_REGION_APPLICATION, /**< first region of the device profile */
};

/** What a node is: const, shared by all nodes of the kind. */
struct dg_co_device {
    const char *name;                   /**< product name, for the EDS */
    struct dg_co_dictionary dictionary; /**< from 2000h on; from 1000h on if it is `whole` */
    const struct dg_co_figure *figures; /**< of the stack's and of the device's rows, sorted */
    uint8_t figure_count;
    /** The dictionary is all that a master finds, rows for 1000h-1FFFh included: none of them is
     * repeated or saved, those with a slot of the stack have its slot. The stack's own rows are
     * there for what is saved and for what the dictionary leaves out. */
    bool whole;
    uint16_t hidden; /**< rows in front of the dictionary's first: with slots, found by no master */
    const uint16_t *kbaud; /**< bit rates by the number that stands for them; 0: none */
    uint8_t kbaud_count;
    uint16_t save_ms;                 /**< "save" is answered so long after the request */
    const struct dg_co_cause *causes; /**< from DG_CO_CAUSES on */
    uint8_t cause_count;
    const char *const *strings; /**< 1008h, 1009h, 100Ah, at most DG_CO_STRING_MAX long */
    uint32_t device_type;       /**< 1000h */
    uint32_t vendor_id;         /**< 1018h:1-3 */
    uint32_t product_code;
    uint32_t revision;
    const struct dg_store_layout *layout;
    /**
     * Reset: values are loaded, boot-up comes next. `application`: 2000h-9FFFh are reset, too.
     * True: boot into operational. May be NULL.
     */
    bool (*reset)(struct dg_co_node *node, bool application);
    /** Take a sample at node->now; once for all objects of a SYNC, a TPDO, an SDO read of what is
     * not constant. May be NULL. */
    void (*sample)(struct dg_co_node *node);
    /** Periodic work; returns the next moment it is wanted, which neither sample() nor the reading
     * of an object moves, nor the writing of one below 2000h, nor an NMT state that is not
     * Operational behind another one that is not. May be NULL. */
    dg_ns (*step)(struct dg_co_node *node);
    /** An SDO request that the server refuses, of 8 bytes, before the abort: the device may serve
     * it, and has the next ones of the transfer in DG_CO_SDO_DEVICE. `data` NULL: the deadline of
     * dg_co_sdo is over. What it does not serve it aborts. May be NULL. */
    void (*refused)(struct dg_co_node *node, const uint8_t *data, enum dg_co_abort abort);
};

/** The bus's operations. */
struct dg_co_ops {
    /**
     * Queue a frame. Must keep the order of calls, must not block, must not call back. The port
     * holds back what it cannot send yet (and stops delivering received frames meanwhile).
     */
    void (*send)(void *ctx, const struct dg_can_frame *frame);
    /** The bit rate in force has become `kbaud`; may be NULL. */
    void (*bit_rate)(void *ctx, uint16_t kbaud);
};

/** What a node is made of. Everything pointed to must outlive it. */
struct dg_co_setup {
    const struct dg_co_device *device;
    const struct dg_world *world;
    struct dg_nvm nvm;
    const struct dg_co_ops *ops;
    void *ctx;         /**< handed to ops */
    void *application; /**< the device profile's state */
};

/** SDO server: what is running. */
enum dg_co_sdo_state {
    DG_CO_SDO_IDLE,
    DG_CO_SDO_UPLOAD,             /**< segments go out */
    DG_CO_SDO_DOWNLOAD,           /**< segments come in */
    DG_CO_SDO_BLOCK_UPLOAD_START, /**< block upload agreed, waiting for A3h */
    DG_CO_SDO_BLOCK_UPLOAD,       /**< waiting for the acknowledgement of a block */
    DG_CO_SDO_BLOCK_UPLOAD_END,   /**< waiting for the last A1h */
    DG_CO_SDO_BLOCK_DOWNLOAD,     /**< segments of a block come in */
    DG_CO_SDO_BLOCK_DOWNLOAD_END, /**< waiting for C1h */
    DG_CO_SDO_DELAYED,            /**< the answer to "save" is due at `deadline` */
    DG_CO_SDO_DEVICE,             /**< what the device does in dg_co_device.refused */
    DG_CO_SDO_STATE_COUNT
};

/** The SDO server of a node. */
struct dg_co_sdo {
    enum dg_co_sdo_state state;
    dg_ns deadline;             /**< timeout, or when `answer` is due; DG_NEVER while idle */
    struct dg_co_object object; /**< what the transfer is about; found when it was begun */
    uint32_t multiplexor;       /**< its index and sub-index as bytes 1-3 of frames have them */
    uint32_t value;             /**< what a hook has read */
    uint8_t toggle;             /**< bit 4 of the next segment */
    bool sized;                 /**< the client announced the size */
    bool crc;                   /**< block transfer with CRC */
    uint8_t blksize;            /**< segments of a block the client takes */
    uint8_t seqno;              /**< block upload: segments sent; download: last segment in order */
    uint8_t length;             /**< bytes in buffer */
    uint8_t done;               /**< bytes sent and, in a block upload, confirmed */
    uint8_t answer;             /**< byte 0 of a delayed answer */
    uint8_t buffer[DG_CO_STRING_MAX + 8];
};

/** A TPDO at work; its parameters are values of the dictionary. */
struct dg_co_tpdo {
    uint16_t can_id;
    bool valid;
    bool rtr_allowed;
    bool pending; /**< an event waits for the inhibit time, or for the next SYNC (type 0) */
    bool sampled; /**< `last` counts: for the next RTR (type 252), for the detection of changes */
    uint8_t type;
    uint8_t sync_count; /**< SYNCs since the last one that it was sent at */
    uint8_t mapped_count;
    uint8_t length;      /**< bytes */
    uint8_t event_bytes; /**< bit n: byte n is of an object with DG_CO_EVENT */
    uint8_t last[8 + 3]; /**< data sent or sampled last; room for a whole 32-bit store at byte 7 */
    dg_ns event_at;      /**< event timer, or DG_NEVER */
    dg_ns inhibit_until;
    /** Rows by their place; bit 15: in the device's dictionary. */
    uint16_t mapped[DG_CO_MAPPED_MAX];
};

/** Counters; nobody has to act on them. */
struct dg_co_counters {
    uint32_t rx;        /**< frames for this node */
    uint32_t tx;        /**< frames sent */
    uint32_t malformed; /**< frames of a known service with a wrong length, dropped */
    uint32_t late_sync; /**< synchronous TPDOs given up because the window 1007h was over */
};

/** LSS slave. */
struct dg_co_lss {
    bool configuration; /**< state configuration, not waiting */
    bool changed;       /**< node-ID or bit timing were configured since the switch */
    uint8_t selective;  /**< selective identity parts matched so far */
    uint8_t identify;   /**< identify parts matched so far */
    uint8_t fastscan;   /**< part of the identity the scan is at */
    uint8_t node_id;    /**< pending */
    uint8_t bit_rate;   /**< pending, number in dg_co_device.kbaud */
    dg_ns silent_until; /**< activate bit timing: nothing is sent before */
    dg_ns switch_at;    /**< activate bit timing: the new rate is in force from then */
};

/**
 * A node. Readable for tests and displays; only the stack writes it. What is used most stands
 * first: there an instruction of a small machine reaches it.
 */
struct dg_co_node {
    enum dg_co_state state;
    uint8_t id; /**< node-ID in force, DG_CO_UNCONFIGURED without one */
    bool mounted;
    uint8_t sync_mask;  /**< bit n: TPDO n is valid and synchronous */
    uint8_t emcy_count; /**< EMCYs that wait for the inhibit time 1015h */
    uint8_t emcy_first;
    uint8_t history_count;
    uint8_t history_newest;
    uint8_t filter_version; /**< changes whenever dg_co_filters() may have changed */
    uint8_t bit_rate;       /**< in force, number in dg_co_device.kbaud */
    uint8_t termination;    /**< as stored */
    bool guard_toggle;
    bool bus_off;    /**< between bus-off and error active */
    bool bus_absent; /**< there is no bus, see DG_CO_BUS_ABSENT */
    bool bus_found;  /**< there has been one since power-on: told, or heard */
    struct dg_co_lss lss;
    struct dg_co_setup setup;

    dg_ns now;      /**< moment of the call that is being served */
    dg_ns deadline; /**< of all services */
    dg_ns others;   /**< of all but the SDO server; 0: what is being served may have moved one */
    dg_ns pdo_at;   /**< next deadline of the TPDOs; 0: to be found anew */
    dg_ns rx_at;    /**< moment the latest frame came in; before `now` when delivered late */
    dg_ns heartbeat_at;
    dg_ns guard_at;                     /**< life time is over */
    dg_ns consumer_at[DG_CO_CONSUMERS]; /**< heartbeat overdue; DG_NEVER: none seen yet */
    dg_ns emcy_until;
    uint32_t active_causes; /**< bit n: cause n lasts */
    uint32_t serial;        /**< 1018h:4 */
    uint32_t clock_us;      /**< 1013h is this plus `now` in us */
    uint32_t time_ms;       /**< latest TIME: ms after midnight, days since 1984-01-01 */
    uint16_t time_days;     /**< with `time_ms` */
    struct dg_co_counters counters;

    struct dg_co_sdo sdo;
    uint32_t value[DG_CO_VALUES_MAX];
    struct dg_co_tpdo tpdo[DG_CO_TPDOS];
    struct dg_store store;
    uint32_t history[DG_CO_HISTORY]; /**< 1003h: at history_newest, then backwards round */
    uint8_t emcy[DG_CO_HISTORY][8];
};

/**
 * Rows of a layout for the regions that the stack uses (enum dg_co_region); a device appends its
 * own from DG_CO_REGION_APPLICATION on. Their defaults take a const uint32_t *serial as ctx.
 * `default_bus` fills three bytes: number of the bit rate, node-ID (DG_CO_UNCONFIGURED: none yet),
 * termination 0 or 1. They also serve when the memory cannot be read.
 */
#define DG_CO_STORE_REGIONS(default_bus)                                                           \
    [DG_CO_REGION_BUS] = {"bus", 3, DG_STORE_CHECKED, 0, (default_bus)},                           \
    [DG_CO_REGION_SAVED] = {"saved", 1, DG_STORE_CHECKED, 0, dg_co_default_saved},                 \
    [DG_CO_REGION_COMMUNICATION] = {"communication", 35, DG_STORE_CHECKED, 0, NULL},               \
    [DG_CO_REGION_TPDO1] = {"tpdo1", 43, DG_STORE_CHECKED, 0, NULL},                               \
    [DG_CO_REGION_TPDO2] = {"tpdo2", 43, DG_STORE_CHECKED, 0, NULL},                               \
    [DG_CO_REGION_TPDO3] = {"tpdo3", 43, DG_STORE_CHECKED, 0, NULL},                               \
    [DG_CO_REGION_TPDO4] = {"tpdo4", 43, DG_STORE_CHECKED, 0, NULL},                               \
    [DG_CO_REGION_SERIAL] = {"serial", 4, DG_STORE_CHECKED, 0, dg_co_default_serial}
/** Journal bytes that saving the stack's own regions takes. */
#define DG_CO_JOURNAL_SIZE (6u + 1u + 6u + 35u + 4u * (6u + 43u))
/** Default of the region "saved": nothing was ever saved. */
DG_API void dg_co_default_saved(const void *ctx, uint8_t *out);
/** Default of the region "serial". @param ctx the serial number, a uint32_t */
DG_API void dg_co_default_serial(const void *ctx, uint8_t *out);

/** Burn the delivery state: the device's defaults, `serial`. @return as dg_store_format */
DG_API int dg_co_format(const struct dg_co_device *device, struct dg_nvm nvm, uint32_t serial);

/** Mount a memory as a node does when it starts: one of an earlier release grows, and keeps its
 * serial number. @return as dg_store_mount(), dg_store_grow() */
DG_API int dg_co_mount(struct dg_store *self, const struct dg_co_device *device, struct dg_nvm nvm);

/** Give a memory in its delivery state another node-ID. @return 0; DG_ERR_ARGUMENT: not 1..127; as
 * dg_store_put() */
DG_API int dg_co_burn_node_id(const struct dg_co_device *device, struct dg_nvm nvm, uint32_t id);

/** Make a node, without power. @return 0 or DG_ERR_ARGUMENT */
DG_API int dg_co_init(struct dg_co_node *self, const struct dg_co_setup *setup);

/** As dg_stack.attach: `self` holds the bytes of a node of the same device; these are its pointers
 * now, none with NULL. */
DG_API void dg_co_attach(struct dg_co_node *self, const struct dg_co_setup *setup);
/** Whether all that such a node goes by fits: its mapped objects and its transfer are in the
 * dictionary, its values in their limits. Only setup.device is looked at of what it points to. */
DG_API bool dg_co_fits(const struct dg_co_node *self);

/**
 * Power on: mount the store, load values, boot-up frame, pre-operational (or operational).
 * @return 0; DG_ERR_BLANK, DG_ERR_FOREIGN: not this device's memory, the node stays off
 */
DG_API int dg_co_power_on(struct dg_co_node *self, dg_ns now);
/** Power off: what was not saved is lost, and the node neither hears nor sends. */
DG_API void dg_co_power_off(struct dg_co_node *self);

/** A frame came in. @return the next deadline, as dg_co_step() */
DG_API dg_ns dg_co_rx(struct dg_co_node *self, dg_ns now, const struct dg_can_frame *frame);

/** Do what is due. @return when to call again, or DG_NEVER */
DG_API dg_ns dg_co_step(struct dg_co_node *self, dg_ns now);

/** What the CAN controller reports besides frames. */
enum dg_co_bus_event {
    DG_CO_BUS_ACTIVE,  /**< error active: passive and bus-off are over */
    DG_CO_BUS_PASSIVE, /**< error passive: 8120h */
    DG_CO_BUS_OFF,     /**< 1029h:1 at once, 8140h when it is over */
    DG_CO_BUS_OVERRUN, /**< a received frame was lost: 8110h */
    DG_CO_BUS_ABSENT,  /**< no bus: nothing is connected, or nobody acknowledges */
    DG_CO_BUS_PRESENT, /**< there is one; what a node assumes until it is told */
};
/**
 * Whether there is a bus is the wire's state and not the node's: it is also taken without power and
 * survives power-off and power-on. A node without a bus goes on as ever (what it sends is lost) and
 * shows it on its LEDs: a bus is lost when DG_CO_BUS_PRESENT or a frame has come since power-on,
 * else there has not been one yet. So a host that finds out only by a boot-up that nobody
 * acknowledges tells nothing before. The other events mean nothing without power.
 * @return the next deadline, as dg_co_step()
 */
DG_API dg_ns dg_co_bus(struct dg_co_node *self, dg_ns now, enum dg_co_bus_event event);
/**
 * The node's controller is in `state` (active, passive or bus-off), whatever it was: dg_co_bus() if
 * that is new, by way of active where it has to be. So a host may say it again, e.g. behind a power
 * cycle, which forgets it.
 * @return the next deadline, as dg_co_step()
 */
DG_API dg_ns dg_co_controller(struct dg_co_node *self, dg_ns now, enum dg_co_bus_event state);

/** What the node takes its controller for: active, passive or bus-off. */
DG_API enum dg_co_bus_event dg_co_controller_state(const struct dg_co_node *self);

/** Most CAN-IDs a node listens to. */
#define DG_CO_FILTERS_MAX 16u
/**
 * The CAN-IDs this node listens to at the moment, for a port's filters. Asked again when
 * filter_version has changed.
 * @return how many of `ids` are set
 */
DG_API uint8_t dg_co_filters(const struct dg_co_node *self, uint16_t ids[DG_CO_FILTERS_MAX]);

/** Most CAN-IDs that services of a node can share: two each of SYNC, EMCY, TIME and the TPDOs. */
#define DG_CO_SHARED_MAX 3u
/**
 * The CAN-IDs that more than one service of this node has at the moment (SYNC, EMCY, TIME if it is
 * consumed, valid TPDOs), for a host to say so: a master may configure that, and all of them send.
 * Changes only with filter_version.
 * @return how many of `ids` are set
 */
DG_API uint8_t dg_co_shared_ids(const struct dg_co_node *self, uint16_t ids[DG_CO_SHARED_MAX]);

/* ---------------------------------------------------------------- for device profiles */

/**
 * A cause has begun: one EMCY, an entry in 1003h, the error register, the reaction of 1029h.
 * Nothing happens when it lasts already.
 * @param cause enum dg_co_stack_cause, or DG_CO_CAUSES + index in device->causes
 * @param manufacturer the five manufacturer bytes
 */
DG_API void dg_co_raise(struct dg_co_node *self, uint8_t cause, const uint8_t manufacturer[5]);
/** A cause is over; EMCY 0000h with the last one. Nothing happens when it does not last. */
DG_API void dg_co_clear(struct dg_co_node *self, uint8_t cause);
/** The profile's event for TPDOs of type 0, 254 and 255: objects with DG_CO_EVENT may have changed.
 */
DG_API void dg_co_pdo_event(struct dg_co_node *self);
/** The event timer of TPDO `tpdo` (0..3) was written through another object. */
DG_API void dg_co_pdo_rearm(struct dg_co_node *self, uint8_t tpdo);
/** Slot of the event timer of TPDO1 (1800h:5), for profiles that show it as an object of theirs. */
DG_API extern const uint8_t dg_co_slot_event_timer;
/** Hook of a device's object that saves the bus parameters when "save" is written to it. */
DG_API dg_co_hook dg_co_hook_save_bus;

/** Nodes that a bus can have: as many as there are node-IDs. */
#define DG_CO_NET_NODES 127u

/* ---------------------------------------------------------------- frames in words */

struct dg_tap_event;
struct dg_words_to;

/** What the words of a bus remember: of each node, the SDO block transfer that it is in. All zero
 * at first. */
struct dg_co_words {
    uint8_t blocks[DG_CO_NET_NODES + 1u];
};
/** dg_words.event (words.h) for profiles: frames by the predefined connection set of CiA 301 and by
 * CiA 305. `self` is a struct dg_co_words. An object file of its own. */
DG_API void dg_co_words_event(void *self, const struct dg_tap_event *event,
                              const struct dg_words_to *to);
/** dg_words.side: who sends a frame, on a wire with a node of that number; 0: any.
 * @return enum dg_words_side */
DG_API int dg_co_words_side(const struct dg_tap_event *event, uint32_t node);

#ifdef __cplusplus
}
#endif

#endif
