/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A half-duplex line of characters (RS485) with encoders on it, whatever protocol they speak.
 *
 *   master   |40|42|02|                                  a character each, as DG_TAP_CHARACTER
 *   encoder             silence, reaction |40|42|..|     in ops->tx: at the end of each stop bit
 *                                         whole(..)      or all of them at the first start bit
 *
 * Every encoder has a transmitter of its own, and hears the master and all the others, each
 * character at the end of its stop bit; while it sends, or keeps a reply, it hears nothing. Two at
 * once: the characters overlap and the line carries their AND (a 0 is driven against an idle 1),
 * once, when the first of them is over; the one that is over later is lost in it.
 */
#ifndef DREHGEBER_BUS_CHARACTERS_H
#define DREHGEBER_BUS_CHARACTERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/bus.h"
#include "drehgeber/host.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The medium, for struct dg_bus_setup, whose `wire` is a struct dg_characters_setup. A character
 * of the master is a DG_TAP_CHARACTER: `at` is the end of its stop bit, or on a paced line the
 * moment it was handed over; baud 0 is none that fits, parity 0 one that nobody knows. */
DG_API extern const struct dg_bus_medium dg_bus_characters;

/** A data rate that is right for everybody. */
#define DG_BAUD_ANY UINT32_MAX
/** Characters of a master on their way at once: two of the longest frames. */
#define DG_COMING_MAX ((size_t)2 * DG_REPLY_MAX)

/** A line. All zero but `size`: as usual. */
struct dg_characters_setup {
    size_t size; /**< sizeof(struct dg_characters_setup) */
    bool paced;  /**< a master hands over many characters at once: each begins at `at`, or when the
                      one before is over, and takes its time. Without, each is over at `at` */
    bool live;   /**< in real time, where calls are late: a reply begins when the call that it is
                      due in comes, so that its characters never come closer than on a line, and
                      is of that moment */
    dg_ns
        late; /**< what an encoder does later than this behind its moment was missed; 0: nothing */
    /** A reply begins at `at`, and whoever sends it does the timing: a UART, a model of one. What
     * others send then is in it. Valid during the call. NULL: ops->tx tells each character. */
    void (*whole)(void *ctx, size_t place, dg_ns at, const uint8_t *bytes, size_t n);
};

/** What an encoder's end of the line is like. All zero: as usual. */
struct dg_characters_end {
    bool any_line; /**< it reads every data rate and parity, and is read at every one */
    bool at_once;  /**< its replies take no time: all characters are told when the first one begins,
                        and it hears the master meanwhile. Not if the line tells whole replies */
};

/** Say so; until then it is as usual. */
DG_API void dg_bus_characters_set(struct dg_bus *self, size_t place,
                                  const struct dg_characters_end *end);

/** A UART does the timing of this line (dg_characters_setup.whole, so it is not paced): for a host
 * that only knows when its port is open, before anything is on the line. */
DG_API void dg_bus_characters_whole(struct dg_bus *self,
                                    void (*whole)(void *ctx, size_t place, dg_ns at,
                                                  const uint8_t *bytes, size_t n));

/** The edge of a start bit of the master at `at`, for hosts that see it; its character comes by
 * dg_bus_rx() when it is over. Not on a paced line, which knows. @return as dg_bus_rx() */
DG_API dg_ns dg_bus_characters_start(struct dg_bus *self, dg_ns at);

/** The setting of an encoder in force, or the last one that was. */
DG_API struct dg_host_uart dg_bus_characters_uart(const struct dg_bus *self, size_t place);

/** Whether an encoder reads a character that is sent so. */
DG_API bool dg_bus_characters_fits(const struct dg_bus *self, size_t place, uint32_t baud,
                                   char parity);

/** Things nobody has to act on; they only count up. */
struct dg_characters_counters {
    uint64_t collided; /**< characters of the master that were over while a reply was on the line */
    uint64_t late;     /**< calls in which an encoder was late, see dg_characters_setup.late */
    uint64_t overrun;  /**< ... that were lost, as DG_COMING_MAX were on their way */
};

/** What was counted so far. */
DG_API struct dg_characters_counters dg_bus_characters_counters(const struct dg_bus *self);

#ifdef __cplusplus
}
#endif

#endif
