/* SPDX-License-Identifier: MIT */
/* c-open's log, switched off as in its release. */
#ifndef BENCH_PEERS_OSAL_LOG_H
#define BENCH_PEERS_OSAL_LOG_H

#define LOG_DEBUG(...)
#define LOG_INFO(...)
#define LOG_WARNING(...)
#define LOG_ERROR(...)

#endif
