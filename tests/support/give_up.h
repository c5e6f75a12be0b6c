/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The end of a test program whose surroundings fail it: nothing that it could judge is there.
 */
#ifndef TESTS_SUPPORT_GIVE_UP_H
#define TESTS_SUPPORT_GIVE_UP_H

#include <stdnoreturn.h>

/** "WHICH: WHAT" on stderr, and the end. */
noreturn void give_up(const char *what, const char *which);

#endif
