/* SPDX-License-Identifier: MIT */
/* What c-open's CMake would write: its own values, and as many objects as the dictionary has. */
#ifndef BENCH_PEERS_OPTIONS_H
#define BENCH_PEERS_OPTIONS_H

#define MAX_NODES 16
#define MAX_EMCY_COBIDS 4
#define MAX_HEARTBEATS 2
#define MAX_PDO_ENTRIES 8
#define MAX_TX_PDO 4
#define MAX_RX_PDO 4
#define MAX_ERRORS 8
#define SDO_TIMEOUT 100
#define CO_THREAD_PRIO 10
#define CO_THREAD_STACK_SIZE 4096

#endif
