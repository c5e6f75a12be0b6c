/* SPDX-License-Identifier: MIT */
/*
 * Locks of a program whose linker leads their calls here (--wrap): whoever takes one that it has,
 * gives back or waits with one that it has not, or frees one that is taken, ends the program.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <pthread.h>
#include <string.h>

#include "give_up.h"

#define CHECKED(name, parameters, arguments)                                                       \
    int __real_##name parameters;                                                                  \
    int __wrap_##name parameters;                                                                  \
    int __wrap_##name parameters                                                                   \
    {                                                                                              \
        const int reason = __real_##name arguments;                                                \
        if (reason != 0 && reason != ETIMEDOUT) {                                                  \
            give_up(strerror(reason), #name);                                                      \
        }                                                                                          \
        return reason;                                                                             \
    }

int __wrap_pthread_mutex_init(pthread_mutex_t *lock, const pthread_mutexattr_t *attributes);
int __wrap_pthread_mutex_init(pthread_mutex_t *lock, const pthread_mutexattr_t *attributes)
{
    static const pthread_mutex_t checking = PTHREAD_ERRORCHECK_MUTEX_INITIALIZER_NP;
    (void)attributes;
    *lock = checking;
    return 0;
}

CHECKED(pthread_mutex_lock, (pthread_mutex_t * lock), (lock))
CHECKED(pthread_mutex_unlock, (pthread_mutex_t * lock), (lock))
CHECKED(pthread_mutex_destroy, (pthread_mutex_t * lock), (lock))
CHECKED(pthread_cond_wait, (pthread_cond_t * condition, pthread_mutex_t *lock), (condition, lock))
CHECKED(pthread_cond_timedwait,
        (pthread_cond_t * condition, pthread_mutex_t *lock, const struct timespec *until),
        (condition, lock, until))
