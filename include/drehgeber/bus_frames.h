/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A bus of frames (CAN 2.0A): what only this medium has. Encoders hear the other end, and each
 * other behind what happens at the same moment; who is asked goes by what each listens to, so that
 * a frame costs what its listeners cost.
 *
 * Without `pace` a frame takes no time: it is there when it is sent. Moments are those at which an
 * encoder sends, in the order of their places; `arbitrate` has a lower identifier go first.
 *
 * Encoders are deaf and mute while their bit rate is not the wire's, or while it has no channel. A
 * damaged frame is a frame with wrong data: there is no bus simulated below frames.
 */
#ifndef DREHGEBER_BUS_FRAMES_H
#define DREHGEBER_BUS_FRAMES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/bus.h"
#include "drehgeber/frame.h"
#include "drehgeber/host.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The medium. dg_bus_setup.wire is a struct dg_bus_frames_setup; NULL: all zero but `size`. */
DG_API extern const struct dg_bus_medium dg_bus_frames;

/** Encoders on one bus at most. */
#define DG_BUS_FRAMES_ENCODERS 127u
/** Frames that wait for their time (`pace`) before the encoders have to wait, too: until half of
 * them are gone. What one moment makes all encoders send may exceed it. */
#define DG_BUS_FRAMES_PACED 32u
/** Acknowledgements of one encoder that wait for its memory: two blocks of an upload, and some. A
 * client that asks on and on is not waited for. */
#define DG_BUS_FRAMES_ANSWERS 256u

/** Whether there is anybody else on the wire. */
enum dg_bus_company {
    DG_BUS_UNKNOWN, /**< nothing has been heard so far */
    DG_BUS_SOMEBODY,
    DG_BUS_NOBODY, /**< nobody acknowledges, or there is no wire */
};

/** What the wire is, but for its encoders. */
struct dg_bus_frames_line {
    uint32_t bit_rate; /**< in bit/s; 0: it has none of its own: encoders of each hear it */
    bool tolerant;     /**< encoders of another bit rate hear it all the same */
    bool closed;       /**< there is no channel: all are deaf and mute */
    enum dg_bus_company company;
};

/** What this medium tells its host, inside of calls. Each may be NULL. Beside
 * dg_bus_frames_set_line() and dg_bus_frames_stall() they must not call back. */
struct dg_bus_frames_ops {
    /** dg_bus_frames_listens() may answer otherwise from now on. Comes before a frame goes out
     * whose answer somebody has begun to listen to. */
    void (*filter)(void *ctx);
    /** The bit rate of an encoder is another one. */
    void (*retuned)(void *ctx, size_t place, uint32_t bit_rate);
};

/** Room for a frame that waits, of the host's. Private. */
struct dg_bus_frames_room {
    dg_ns at;
    struct dg_can_frame frame;
    uint16_t next;
    uint8_t from;
};

/** What such a bus is made of. */
struct dg_bus_frames_setup {
    size_t size;                         /**< sizeof(struct dg_bus_frames_setup) */
    const struct dg_bus_frames_ops *ops; /**< NULL: none; ctx is that of the bus */
    /** Memory for frames that wait: for other encoders to hear them, for their time, their delay,
     * the memory of their encoder. What does not fit is lost and counted. Has to outlive the bus.
     */
    struct dg_bus_frames_room *room;
    size_t rooms; /**< 0: nothing can wait; at most 65534 */
    struct dg_bus_frames_line line;
    bool pace;      /**< each frame takes its time at the bit rate */
    bool arbitrate; /**< of several that are to be sent a lower identifier goes first; those of one
                         encoder keep their order. Then a frame is told when it has won */
    bool real_time; /**< what is due when the host comes late is done at the moment it comes, and
                         what is missed is left out. Not so: each at its own moment */
};

/** Only count up. */
struct dg_bus_frames_counters {
    uint64_t stalls; /**< times the encoders had to wait for the wire's pace */
    uint64_t lost;   /**< frames that found no room to wait in */
};

/** The wire is another one from the next call on. @return whether it is: dg_bus_step() then */
DG_API bool dg_bus_frames_set_line(struct dg_bus *self, const struct dg_bus_frames_line *line);

/** The controller at `now` is in a state, or has lost a frame (DG_HOST_BUS_ACTIVE to _OVERRUN).
 * Bus-off lasts until it is active again. Faults make an encoder's worse, never better.
 * @return as dg_bus_step() */
DG_API dg_ns dg_bus_frames_controller(struct dg_bus *self, dg_ns now, enum dg_host_bus event);

/** The port has no room for what the encoders send, or has again: meanwhile they do nothing. */
DG_API void dg_bus_frames_stall(struct dg_bus *self, bool stalled);
/** Encoders wait, for the port or for the wire's pace: what comes in should wait, too. */
DG_API bool dg_bus_frames_waits(const struct dg_bus *self);

/** Whether an encoder listens to identifier 0..7FFh. */
DG_API bool dg_bus_frames_listens(const struct dg_bus *self, uint16_t id);
/** Whether the encoder at `place` hears the wire. */
DG_API bool dg_bus_frames_hears(const struct dg_bus *self, size_t place);
/** The bit rate in bit/s: the wire's, or where it has none that of the slowest encoder that hears
 * it; 0: not known. */
DG_API uint32_t dg_bus_frames_bit_rate(const struct dg_bus *self);

/** A frame of somebody else, with so many bits, that no encoder could understand has been on the
 * wire until `now`. With `pace` what is sent meanwhile is through later. */
DG_API void dg_bus_frames_count(struct dg_bus *self, dg_ns now, uint32_t bits);
/** Bits on the wire so far, of all frames that this bus has seen or was told of. */
DG_API uint64_t dg_bus_frames_bits(const struct dg_bus *self);
/** Its counters; they last as long as the bus. */
DG_API const struct dg_bus_frames_counters *dg_bus_frames_counters(const struct dg_bus *self);

/* ---------------------------------------------------------------- bit times and load */

/**
 * Most bits that frames take on the wire, from SOF to the third bit of the pause behind them, with
 * as many stuff bits as there can be. A frame of n bytes with g bits before and in its CRC that are
 * stuffed has at most g + 8n + 13 + floor((g + 8n - 1) / 4): with 11-bit identifiers g = 34 and
 * that is 55 + 10n, with 29-bit ones g = 54 and 80 + 10n (Davis, Burns, Bril, Lukkien: Controller
 * Area Network (CAN) schedulability analysis: Refuted, revisited and revised, Real-Time Systems 35,
 * 2007). With 8 bytes 135 bits: 13.5 ms at 10 kBd, where the manual asks for 14 ms (chapter 8).
 * Both are linear, so sums over frames and their bytes are exact as well.
 */
#define DG_CAN_BITS(frames, bytes) (55u * (frames) + 10u * (bytes))
#define DG_CAN_EXTENDED_BITS(frames, bytes) (80u * (frames) + 10u * (bytes))

/** Bytes of data that a frame carries: none, when it is a remote one. */
static inline uint32_t dg_can_bytes(const struct dg_can_frame *frame)
{
    return frame->rtr ? 0u : frame->dlc;
}

/** Load is measured in pieces of this. */
#define DG_BUS_LOAD_WINDOW DG_S(1)
/** Above this the bus is overloaded, until the load is no more than the other. A frame counts in
 * the window that it begins in, 135 bits at 10 kBd, one of a master in that in which it has come,
 * and a few milliseconds are made up for: up to 32 permille of a window that was full. */
#define DG_BUS_OVERLOAD_PERMILLE 1040u
#define DG_BUS_RELIEF_PERMILLE 900u

/** A bus whose load is measured. */
struct dg_bus_load {
    dg_ns since;       /**< when the running window began */
    uint64_t bits;     /**< on the wire until then */
    uint32_t permille; /**< of the latest whole window */
    bool overloaded;
};

/** Measure from `now` on; `bits` have been on the wire so far. */
DG_API void dg_bus_load_begin(struct dg_bus_load *self, dg_ns now, uint64_t bits);

/** Whether the running window is over at `now`. */
static inline bool dg_bus_load_due(const struct dg_bus_load *self, dg_ns now)
{
    return dg_elapsed(now, self->since) >= DG_BUS_LOAD_WINDOW;
}

/**
 * The running window is over.
 * @param bits on the wire so far, in both directions; less than before: the wire is another one
 * @param bit_rate in bit/s; 0: unknown, then there is no load
 * @return whether an overload begins
 */
DG_API bool dg_bus_load_close(struct dg_bus_load *self, dg_ns now, uint64_t bits,
                              uint32_t bit_rate);

/** The load at `now`, in permille: of the latest whole window, or of the running one when that is
 * over already; only then `bits` count. Parameters as above. */
DG_API uint32_t dg_bus_load_permille(const struct dg_bus_load *self, dg_ns now, uint64_t bits,
                                     uint32_t bit_rate);

#ifdef __cplusplus
}
#endif

#endif
