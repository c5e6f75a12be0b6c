/* SPDX-License-Identifier: MIT */
/*
 * The layouts that host.h promises, held on every machine this is compiled for. Nothing is compiled
 * into anything.
 */
#include "host_private.h"

#define SIZE(type, size)                                                                           \
    _Static_assert(sizeof(struct type) == (size), #type " has the size it has always had")
#define PLACE(type, member, place)                                                                 \
    _Static_assert(offsetof(struct type, member) == (place),                                       \
                   #type "." #member " is where it has always been")

SIZE(dg_host_event, 32);
PLACE(dg_host_event, at, 0);
PLACE(dg_host_event, id, 8);
PLACE(dg_host_event, flags, 12);
PLACE(dg_host_event, kind, 14);
PLACE(dg_host_event, length, 15);
PLACE(dg_host_event, data, 16);

SIZE(dg_host_frame, 48);
PLACE(dg_host_frame, at, 0);
PLACE(dg_host_frame, end, 8);
PLACE(dg_host_frame, bits, 16);
PLACE(dg_host_frame, position, 24);
PLACE(dg_host_frame, multiturn, 32);
PLACE(dg_host_frame, singleturn, 36);
PLACE(dg_host_frame, count, 40);
PLACE(dg_host_frame, error, 41);
PLACE(dg_host_frame, warning, 42);
PLACE(dg_host_frame, good, 43);
PLACE(dg_host_frame, life, 44);
PLACE(dg_host_frame, reserved, 45);

_Static_assert((int)DG_HOST_MEDIUM_CHARACTERS == (int)DG_MEDIUM_CHARACTERS, "one numbering");
_Static_assert((int)DG_HOST_MEDIUM_FRAMES == (int)DG_MEDIUM_FRAMES, "one numbering");
_Static_assert((int)DG_HOST_MEDIUM_EDGES == (int)DG_MEDIUM_EDGES, "one numbering");
_Static_assert((int)DG_HOST_MEDIUM_WORDS == (int)DG_MEDIUM_WORDS, "one numbering");
_Static_assert(DG_MEDIUM_COUNT == 4, "host.h promises a number for each medium");

SIZE(dg_host_uart, 8);
PLACE(dg_host_uart, baud, 0);
PLACE(dg_host_uart, parity, 4);
PLACE(dg_host_uart, timeout_bits, 5);
PLACE(dg_host_uart, reserved, 6);

/* Three pointers, two numbers, eight bytes: on machines of 32 bits one word is left free behind the
 * pointers or not, as the machine aligns numbers of 64. */
SIZE(dg_host_key,
     (3u * sizeof(void *) + _Alignof(int64_t) - 1u) / _Alignof(int64_t) * _Alignof(int64_t) + 24u);
PLACE(dg_host_key, unit, sizeof(void *));
PLACE(dg_host_key, help, 2u * sizeof(void *));
PLACE(dg_host_key, max, offsetof(struct dg_host_key, min) + 8u);
PLACE(dg_host_key, type, offsetof(struct dg_host_key, max) + 8u);
PLACE(dg_host_key, places, offsetof(struct dg_host_key, max) + 9u);
PLACE(dg_host_key, always, offsetof(struct dg_host_key, max) + 10u);
