/* SPDX-License-Identifier: MIT */
/**
 * @file
 * States of buses: one walk over what is in a state writes it, looks at it, and takes it over, so
 * that the three cannot differ. Each medium has rows of its members, and walks over its lists.
 *
 *   | struct header | now, called | the medium's wire | place 0 | place 1 | ...
 *
 * Pointers, the setup and what follows from other things have no row: they stay those of the bus.
 */
#ifndef DREHGEBER_BUS_TAPE_H
#define DREHGEBER_BUS_TAPE_H

#include "bus_private.h"

/** Which way a state goes. */
enum bus_tape_way {
    BUS_TAPE_SAVE,    /**< into memory, or without any only counted */
    BUS_TAPE_CHECK,   /**< out of it; nothing changes */
    BUS_TAPE_RESTORE, /**< out of it, behind that */
};

/** A state on its way. */
struct bus_tape {
    enum bus_tape_way way;
    uint8_t *to;         /**< SAVE; NULL: it is counted */
    const uint8_t *from; /**< CHECK, RESTORE */
    size_t size;         /**< of either */
    size_t at;
    size_t rooms; /**< of frames that have come so far */
    dg_ns now;    /**< the moment that the state is of */
    bool good;    /**< so far */
};

/** A member that is in a state. */
struct bus_member {
    uint16_t offset;
    uint16_t size;
    uint32_t most; /**< of a number of up to 4 bytes; UINT32_MAX: any bytes are good */
};
#define BUS_MEMBER(type, member, most)                                                             \
    {                                                                                              \
        offsetof(struct type, member), sizeof(((struct type *)0)->member), most                    \
    }
#define BUS_ANY(type, member) BUS_MEMBER(type, member, UINT32_MAX)
#define BUS_BOOL(type, member) BUS_MEMBER(type, member, 1)

/** These members of `from` are next, or come into `to`; NULL: nowhere. */
void dg_bus_tape_members(struct bus_tape *self, const struct bus_member *rows, size_t count,
                         const void *from, void *to);

/** A moment is next. @return it, or the one in the state */
dg_ns dg_bus_tape_moment(struct bus_tape *self, dg_ns moment);

/** A list is next. @return how many it has: `count`, or as many as the state says, up to `most` */
size_t dg_bus_tape_length(struct bus_tape *self, size_t count, size_t most);

/** The deadline of an encoder is next, which its handle has to agree with. @return as a moment */
dg_ns dg_bus_tape_deadline(struct bus_tape *self, const struct bus_place *place);

/** What has to be so in a good state. */
static inline void dg_bus_tape_expect(struct bus_tape *self, bool holds)
{
    self->good = self->good && holds;
}

/** Where members come to: nowhere before all of the state was looked at. */
static inline void *dg_bus_tape_into(const struct bus_tape *self, void *to)
{
    return self->way == BUS_TAPE_RESTORE ? to : NULL;
}

#endif
