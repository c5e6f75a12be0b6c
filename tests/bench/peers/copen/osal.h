/* SPDX-License-Identifier: MIT */
/* What c-open asks of an operating system: here there is none. Time is handed over, its thread
 * never runs. */
#ifndef BENCH_PEERS_OSAL_H
#define BENCH_PEERS_OSAL_H

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define BIT(n) (1u << (n))
#define NELEMENTS(a) (sizeof(a) / sizeof((a)[0]))
#define MIN(a, b) ((a) < (b) ? (a) : (b))
#define MAX(a, b) ((a) > (b) ? (a) : (b))
#define CC_ASSERT(x) assert(x)
#define CC_TO_LE16(x) (x)
#define CC_TO_LE32(x) (x)
#define CC_TO_LE64(x) (x)
#define CC_ATOMIC_GET8(p) (*(p))
#define CC_ATOMIC_GET16(p) (*(p))
#define CC_ATOMIC_GET32(p) (*(p))
#define CC_ATOMIC_GET64(p) (*(p))
#define CC_ATOMIC_SET8(p, v) (*(p) = (v))
#define CC_ATOMIC_SET16(p, v) (*(p) = (v))
#define CC_ATOMIC_SET32(p, v) (*(p) = (v))
#define CC_ATOMIC_SET64(p, v) (*(p) = (v))
#define OS_WAIT_FOREVER 0xFFFFFFFFu

typedef uint64_t os_tick_t; /* microseconds */
typedef int os_mbox_t, os_sem_t, os_timer_t, os_thread_t;

extern os_tick_t peer_now;
extern int os_object; /* any of them */

#define os_tick_current() peer_now
#define os_tick_from_us(us) ((os_tick_t)(us))
#define os_usleep(us) ((void)(us))
#define os_mbox_create(size) (&os_object)
#define os_mbox_destroy(mbox) ((void)(mbox))
#define os_mbox_post(mbox, message, time) ((void)(mbox), (void)(message), 0)
#define os_mbox_fetch(mbox, message, time) ((void)(mbox), (void)(message), 0)
#define os_sem_create(count) (&os_object)
#define os_sem_wait(sem, time) ((void)(sem))
#define os_sem_signal(sem) ((void)(sem))
#define os_timer_create(us, f, arg, once) ((void)(f), &os_object)
#define os_timer_start(timer) ((void)(timer))
#define os_timer_destroy(timer) ((void)(timer))
#define os_thread_create(name, prio, size, f, arg) ((void)(f), &os_object)

#endif
