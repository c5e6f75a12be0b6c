/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a C file names that was made of an EDS file (`drehgeber model FILE.eds --c`): the rows of
 * its dictionary say by name which value of the node they show, and which hook they have. Such a
 * program contains no reader of EDS files.
 */
#ifndef DREHGEBER_EDS_ROWS_H
#define DREHGEBER_EDS_ROWS_H

#include "drehgeber/eds.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Names of the stack's own values, in their order: VALUE(name) for each. */
#define DG_CO_VALUES(VALUE)                                                                        \
    VALUE(SYNC_COB_ID)                                                                             \
    VALUE(SYNC_PERIOD_US)                                                                          \
    VALUE(SYNC_WINDOW_US)                                                                          \
    VALUE(GUARD_TIME_MS)                                                                           \
    VALUE(LIFE_FACTOR)                                                                             \
    VALUE(TIME_COB_ID)                                                                             \
    VALUE(NODE_ID)                                                                                 \
    VALUE(EMCY_COB_ID)                                                                             \
    VALUE(EMCY_INHIBIT_100US)                                                                      \
    VALUE(CONSUMER_1)                                                                              \
    VALUE(CONSUMER_2)                                                                              \
    VALUE(HEARTBEAT_MS)                                                                            \
    VALUE(BEHAVIOUR_1)                                                                             \
    VALUE(BEHAVIOUR_2)                                                                             \
    VALUE(BEHAVIOUR_3)                                                                             \
    DG_CO_VALUES_OF_TPDO(VALUE, 1)                                                                 \
    DG_CO_VALUES_OF_TPDO(VALUE, 2)                                                                 \
    DG_CO_VALUES_OF_TPDO(VALUE, 3)                                                                 \
    DG_CO_VALUES_OF_TPDO(VALUE, 4)                                                                 \
    VALUE(BUS_BIT_RATE)                                                                            \
    VALUE(BUS_NODE_ID)                                                                             \
    VALUE(BUS_TERMINATION)
/** Those of TPDO `n`. */
#define DG_CO_VALUES_OF_TPDO(VALUE, n)                                                             \
    VALUE(TPDO##n##_COB_ID)                                                                        \
    VALUE(TPDO##n##_TYPE)                                                                          \
    VALUE(TPDO##n##_INHIBIT_100US)                                                                 \
    VALUE(TPDO##n##_EVENT_MS)                                                                      \
    VALUE(TPDO##n##_MAPPED)                                                                        \
    VALUE(TPDO##n##_ENTRY_1)                                                                       \
    VALUE(TPDO##n##_ENTRY_2)                                                                       \
    VALUE(TPDO##n##_ENTRY_3)                                                                       \
    VALUE(TPDO##n##_ENTRY_4)                                                                       \
    VALUE(TPDO##n##_ENTRY_5)                                                                       \
    VALUE(TPDO##n##_ENTRY_6)                                                                       \
    VALUE(TPDO##n##_ENTRY_7)                                                                       \
    VALUE(TPDO##n##_ENTRY_8)

/** Slots of rows with DG_CO_SLOT. */
enum dg_co_value {
#define DG_CO_VALUE(name) DG_CO_VALUE_##name,
    DG_CO_VALUES(DG_CO_VALUE)
#undef DG_CO_VALUE
    /** the first one of the device profile */
    DG_CO_VALUE_APPLICATION
};

/** Hooks of rows, by their place in dg_co_row_hooks. */
enum dg_co_row_hook {
    DG_CO_HOOK_NONE,
    DG_CO_HOOK_BASE,    /**< as the base's row with this key, which has one */
    DG_CO_HOOK_CELL,    /**< the default of the row is the number of a cell */
    DG_CO_HOOK_FOLLOWS, /**< a constant, the node-ID is added */
    DG_CO_HOOK_KEEP,    /**< 1010h: "save" with the cells */
    DG_CO_ROW_HOOK_COUNT
};

/** dg_co_dictionary.hooks of such a device. */
DG_API extern dg_co_hook *const dg_co_row_hooks[DG_CO_ROW_HOOK_COUNT];

/** Which of them row `n` of a file that was read would have; DG_CO_ROW_HOOK_COUNT: none, as its
 * hook is one of another kind. */
DG_API enum dg_co_row_hook dg_co_row_hook_of(const struct dg_co_file *self, uint16_t n);

/** dg_co_device.reset of such a device: its cells, then as the base. */
DG_API bool dg_co_reset_file(struct dg_co_node *node, bool application);
/** dg_co_device.sample of such a device: as the base, which has one. */
DG_API void dg_co_sample_file(struct dg_co_node *node);
/** dg_co_device.step of such a device: as the base, which has one. */
DG_API dg_ns dg_co_step_file(struct dg_co_node *node);

#ifdef __cplusplus
}
#endif

#endif
