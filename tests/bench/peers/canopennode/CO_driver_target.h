/* SPDX-License-Identifier: MIT */
/* What CANopenNode asks of a target: here frames of this comparison, one thread, nothing to lock.
 */
#ifndef BENCH_PEERS_CO_DRIVER_TARGET_H
#define BENCH_PEERS_CO_DRIVER_TARGET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "peer.h"

/* Configured as its own example for Linux, but for gateway and clients: an encoder has none. */
#define CO_CONFIG_SDO_SRV (0x02 | 0x04 | 0x4000)
#define CO_CONFIG_SDO_SRV_BUFFER_SIZE 900
#define CO_CONFIG_CRC16 1
#define CO_CONFIG_NODE_GUARDING 1
#define CO_CONFIG_STORAGE 0
#define CO_MULTIPLE_OD

#define CO_LITTLE_ENDIAN
#define CO_SWAP_16(x) x
#define CO_SWAP_32(x) x
#define CO_SWAP_64(x) x
typedef uint_fast8_t bool_t;
typedef float float32_t;
typedef double float64_t;

#define CO_CANrxMsg_readIdent(frame) (((const struct peer_frame *)(frame))->id)
#define CO_CANrxMsg_readDLC(frame) (((const struct peer_frame *)(frame))->dlc)
#define CO_CANrxMsg_readData(frame) (((const struct peer_frame *)(frame))->data)

typedef struct {
    uint16_t ident, mask;
    void *object;
    void (*CANrx_callback)(void *object, void *message);
} CO_CANrx_t;

typedef struct {
    uint32_t ident;
    uint8_t DLC;
    uint8_t data[8];
    volatile bool_t bufferFull, syncFlag;
} CO_CANtx_t;

typedef struct {
    CO_CANrx_t *rxArray;
    CO_CANtx_t *txArray;
    uint16_t rxSize, txSize, CANerrorStatus;
    volatile bool_t CANnormal;
} CO_CANmodule_t;

#define CO_LOCK_CAN_SEND(module) ((void)(module))
#define CO_UNLOCK_CAN_SEND(module) ((void)(module))
#define CO_LOCK_EMCY(module) ((void)(module))
#define CO_UNLOCK_EMCY(module) ((void)(module))
#define CO_LOCK_OD(module) ((void)(module))
#define CO_UNLOCK_OD(module) ((void)(module))
#define CO_MemoryBarrier()
#define CO_FLAG_READ(flag) ((flag) != NULL)
#define CO_FLAG_SET(flag) ((flag) = (void *)1)
#define CO_FLAG_CLEAR(flag) ((flag) = NULL)

#endif
