/* SPDX-License-Identifier: MIT */
/*
 * Scripts of a ring: README.md, "Several encoders on a wire".
 */
#ifndef TESTS_DIFFERENTIAL_PLAY_RING_H
#define TESTS_DIFFERENTIAL_PLAY_RING_H

#include "play.h"

/* Most encoders. */
#define RING_PLAYERS 3u

/* A script begins: nobody is in the ring. Of enum disturbance a ring has RESTORE. */
void ring_begin(unsigned disturbances);

/* As player_perform(), of any of its encoders or of all. */
bool ring_perform(unsigned number, char *words[], int n);

#endif
