/* SPDX-License-Identifier: MIT */
/* CANopenNode, with a list of objects that is made at the start. */
#include <string.h>

#define OD_DEFINITION
#include "CANopen.h"
#include "peer.h"

#define ROWS_MAX 256u
#define PERIOD_US 100u
#define STARTUP_MS 500u

static uint32_t values[ROWS_MAX];
static OD_obj_record_t records[ROWS_MAX];
static OD_obj_var_t variables[ROWS_MAX];
static OD_entry_t entries[ROWS_MAX];
static OD_t od = {0, entries};
static CO_config_t config;
static CO_t *co;

static OD_attr_t attributes(const struct row *row)
{
    return (OD_attr_t)((row->readable ? ODA_SDO_R : 0) | (row->writable ? ODA_SDO_W : 0) |
                       (row->mappable ? ODA_TPDO : 0) | (row->bits > 8 ? ODA_MB : 0) |
                       (row->type == TYPE_STRING ? ODA_STR : 0));
}

/* An object for each index: a variable, or a record of its sub-indices. */
static void make_dictionary(void)
{
    for (size_t i = 0, next; i < row_count; i = next) {
        OD_entry_t *entry = &entries[od.size++];
        for (next = i; next < row_count && rows[next].index == rows[i].index; next++) {
            const struct row *row = &rows[next];
            void *data = row->text != NULL ? (void *)(uintptr_t)row->text : &values[next];
            values[next] = row->value;
            records[next] = (OD_obj_record_t){data, row->sub, attributes(row), row->bits / 8u};
        }
        const bool alone = next == i + 1;
        variables[i] =
            (OD_obj_var_t){records[i].dataOrig, records[i].attribute, records[i].dataLength};
        *entry = (OD_entry_t){rows[i].index, (uint8_t)(next - i), alone ? ODT_VAR : ODT_REC,
                              alone ? (void *)&variables[i] : (void *)&records[i], NULL};
    }
}

static void configure(void)
{
    config = (CO_config_t){.CNT_NMT = 1,
                           .ENTRY_H1017 = OD_find(&od, 0x1017),
                           .CNT_HB_CONS = 1,
                           .CNT_ARR_1016 = 2,
                           .ENTRY_H1016 = OD_find(&od, 0x1016),
                           .ENTRY_H100C = OD_find(&od, 0x100C),
                           .ENTRY_H100D = OD_find(&od, 0x100D),
                           .CNT_EM = 1,
                           .ENTRY_H1001 = OD_find(&od, 0x1001),
                           .ENTRY_H1014 = OD_find(&od, 0x1014),
                           .ENTRY_H1015 = OD_find(&od, 0x1015),
                           .CNT_ARR_1003 = 8,
                           .ENTRY_H1003 = OD_find(&od, 0x1003),
                           .CNT_SDO_SRV = 1,
                           .CNT_TIME = 1,
                           .ENTRY_H1012 = OD_find(&od, 0x1012),
                           .CNT_SYNC = 1,
                           .ENTRY_H1005 = OD_find(&od, 0x1005),
                           .ENTRY_H1006 = OD_find(&od, 0x1006),
                           .ENTRY_H1007 = OD_find(&od, 0x1007),
                           .CNT_TPDO = 4,
                           .ENTRY_H1800 = OD_find(&od, 0x1800),
                           .ENTRY_H1A00 = OD_find(&od, 0x1A00),
                           .CNT_LEDS = 1,
                           .CNT_LSS_SLV = 1};
}

bool peer_start(void)
{
    static uint8_t node_id = NODE_ID;
    static uint16_t kbaud = 250;
    CO_LSS_address_t identity = {.addr = {0}};
    uint32_t where = 0;

    make_dictionary();
    configure();
    co = CO_new(&config, NULL);
    if (co == NULL || CO_CANinit(co, co, kbaud) != CO_ERROR_NO ||
        CO_LSSinit(co, &identity, &node_id, &kbaud) != CO_ERROR_NO ||
        CO_CANopenInit(co, NULL, NULL, &od, NULL, 0, STARTUP_MS, 1000, 1000, false, NODE_ID,
                       &where) != CO_ERROR_NO ||
        CO_CANopenInitPDO(co, co->em, &od, NODE_ID, &where) != CO_ERROR_NO) {
        return false;
    }
    CO_CANsetNormalMode(co->CANmodule);
    (void)CO_process(co, false, PERIOD_US, NULL);
    return true;
}

/* What its interrupt does, and then only what this frame needs. */
void to_peer(const struct peer_frame *frame)
{
    for (uint16_t i = 0; i < co->CANmodule->rxSize; i++) {
        const CO_CANrx_t *rx = &co->CANmodule->rxArray[i];
        if (((frame->id ^ rx->ident) & rx->mask) == 0 && rx->CANrx_callback != NULL) {
            rx->CANrx_callback(rx->object, (void *)(uintptr_t)frame);
            break;
        }
    }
    if (frame->id == 0x600u + NODE_ID) {
        while (CO_SDOserver_process(co->SDOserver, true, PERIOD_US, NULL) ==
               CO_SDO_RT_blockUploadInProgress) {
        }
    } else if (frame->id == 0x80u) {
        CO_process_TPDO(co, CO_process_SYNC(co, PERIOD_US, NULL), PERIOD_US, NULL);
    } else if (frame->id == 0) {
        (void)CO_process(co, false, PERIOD_US, NULL);
    }
}

void peer_wait(void)
{
    (void)CO_process(co, false, 1000, NULL);
    CO_process_TPDO(co, CO_process_SYNC(co, 1000, NULL), 1000, NULL);
}

/* The driver. */
void CO_CANsetConfigurationMode(void *module)
{
    (void)module;
}

void CO_CANsetNormalMode(CO_CANmodule_t *module)
{
    module->CANnormal = true;
}

CO_ReturnError_t CO_CANmodule_init(CO_CANmodule_t *module, void *port, CO_CANrx_t rx[],
                                   uint16_t rx_size, CO_CANtx_t tx[], uint16_t tx_size,
                                   uint16_t kbaud)
{
    (void)port;
    (void)kbaud;
    *module = (CO_CANmodule_t){.rxArray = rx, .rxSize = rx_size, .txArray = tx, .txSize = tx_size};
    memset(rx, 0, rx_size * sizeof *rx);
    memset(tx, 0, tx_size * sizeof *tx);
    return CO_ERROR_NO;
}

void CO_CANmodule_disable(CO_CANmodule_t *module)
{
    (void)module;
}

CO_ReturnError_t CO_CANrxBufferInit(CO_CANmodule_t *module, uint16_t index, uint16_t id,
                                    uint16_t mask, bool_t rtr, void *object,
                                    void (*callback)(void *object, void *message))
{
    (void)rtr;
    if (index >= module->rxSize) {
        return CO_ERROR_ILLEGAL_ARGUMENT;
    }
    module->rxArray[index] = (CO_CANrx_t){id, mask & 0x7FFu, object, callback};
    return CO_ERROR_NO;
}

CO_CANtx_t *CO_CANtxBufferInit(CO_CANmodule_t *module, uint16_t index, uint16_t id, bool_t rtr,
                               uint8_t length, bool_t sync)
{
    (void)rtr;
    if (index >= module->txSize) {
        return NULL;
    }
    module->txArray[index] = (CO_CANtx_t){.ident = id, .DLC = length, .syncFlag = sync};
    return &module->txArray[index];
}

CO_ReturnError_t CO_CANsend(CO_CANmodule_t *module, CO_CANtx_t *buffer)
{
    (void)module;
    from_peer((uint16_t)buffer->ident, buffer->DLC, buffer->data);
    return CO_ERROR_NO;
}

void CO_CANclearPendingSyncPDOs(CO_CANmodule_t *module)
{
    (void)module;
}

void CO_CANmodule_process(CO_CANmodule_t *module)
{
    (void)module;
}
