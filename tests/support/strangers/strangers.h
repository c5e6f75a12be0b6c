/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Protocols that no host has heard of, one for each medium and one of a medium that does not exist
 * yet. Each behaves as a real one does, under a name of its own; a program with strangers.c has
 * these in place of the library's models.
 */
#ifndef TESTS_SUPPORT_STRANGERS_H
#define TESTS_SUPPORT_STRANGERS_H

#include "drehgeber/host.h"

/** Their models. The protocol of each is "unknown-" and its medium. */
#define STRANGER_CHARACTERS "stranger-characters"
#define STRANGER_FRAMES "stranger-frames"
#define STRANGER_EDGES "stranger-edges"
#define STRANGER_WORDS "stranger-words"
#define STRANGER_FUTURE "stranger-future"

/** Bytes that each handle fits in. */
#define STRANGER_MEMORY_MAX 32768u

#endif
