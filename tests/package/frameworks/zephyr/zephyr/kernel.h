/* SPDX-License-Identifier: MIT */
/* As much of Zephyr as the example calls. */
#ifndef ZEPHYR_KERNEL_H
#define ZEPHYR_KERNEL_H

#include <stdint.h>

int64_t k_uptime_ticks(void);
uint64_t k_ticks_to_ns_floor64(uint64_t ticks);
void k_yield(void);

#endif
