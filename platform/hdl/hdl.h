/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder in a simulator of hardware: levels and picoseconds go in, levels and the moment of the
 * next change come out. The models in this folder (SystemVerilog, VHDL, Verilog) are a loop around
 * three functions, and so is any other one:
 *
 *   self = dg_hdl_open("s3684-biss", "busy_us=5", "60RPM", "");
 *   if (dg_hdl_error(self)[0] != '\0') ...
 *   for (;;) {
 *       levels = dg_hdl_wires(self, now, inputs);         on every change of an input
 *       wait for an input, or until dg_hdl_next(self);    and at that moment
 *   }
 *
 * It has the delays that hardware has: from an input to the encoder, from there to its output, and
 * jitter, which is the same again with the same seed. Instances share nothing. One thread at a time
 * may use an instance.
 *
 * A function that fails returns a negative number of enum dg_host_result and leaves one line in
 * dg_hdl_error(). A text that is NULL is taken for "". Time ends after 53 days, at 2^62 ps: a `now`
 * behind that is taken for it.
 */
#ifndef DREHGEBER_HDL_H
#define DREHGEBER_HDL_H

#include <stdint.h>

/** Before each function of this library: it shows nothing else. */
#if defined(__GNUC__)
#define DG_HDL_API __attribute__((visibility("default")))
#else
#define DG_HDL_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** An encoder and its wires. */
struct dg_hdl;

/** Bits of what goes in, and of what comes out. */
enum dg_hdl_wire {
    DG_HDL_CLOCK = 1,  /**< in, BiSS and SSI: MA, the master's clock */
    DG_HDL_BEHIND = 2, /**< in, BiSS: SLI, the line of the next encoder; 0: this is the last one */
    DG_HDL_RX = 1,     /**< in, RS485: what the master sends, 1 when it is silent */
    DG_HDL_DATA = 1,   /**< out, BiSS and SSI: SLO, the encoder's line */
    DG_HDL_TX = 1,     /**< out, RS485: what the encoder sends, 1 when it is silent */
    DG_HDL_DRIVER = 2, /**< out, RS485: the encoder's driver is enabled */
    DG_HDL_HINT = 256, /**< out, no wire: dg_hdl_hint() has something to say */
};

/** Longest answer to a command, and longest error, with their zeros. */
#define DG_HDL_TEXT_MAX 4096u
/** dg_hdl_next(): nothing will happen by itself. */
#define DG_HDL_NEVER INT64_C(-1)

/**
 * An encoder. It is switched on `power_on_ns` behind the first dg_hdl_wires(): what the inputs do
 * before is no edge, nor is their return to rest (1) if they are not at rest then. Until then its
 * outputs are at rest.
 *
 * @param model    as `drehgeber list` has them, one with BiSS, SSI or RS485
 * @param settings words KEY=VALUE: those of the encoder (`drehgeber run MODEL --help`), and
 *                 tco_ns        0.001..10000  from the encoder's edge to its output; 10
 *                 delay_in_ns   0..100000     of the cable to the encoder; 0
 *                 delay_out_ns  0..100000     of the cable from the encoder; 0
 *                 jitter_ns     0..1000       up to as much more, for each edge either way; 0
 *                 power_on_ns   0.001..1000000  from the first look to power; 1
 *                 seed          0..2^32-1     of jitter, busy_jitter_us and chance in faults; 1
 *                 control       unix:PATH     a socket where one client at a time finds the panel
 *                                             (SCPI, as `drehgeber ctl`), looked at each 0.1 ms of
 *                                             the simulation, but not more often than each real
 *                                             one; none
 *                 `init_ms` is 0 and `hint_us` 100 unless it is said otherwise: there is no time
 *                 to wait in a simulation
 * @param motion   of its shaft in words: "90DEG", "60RPM", "sine:90DEG,2S", "ramp:3000RPM,1S",
 *                 a file; "" is 0
 * @param memory   file of its EEPROM, as `--nvm`; "": none. A new one is removed again if there is
 *                 an error
 * @return NULL: no memory. Otherwise dg_hdl_error() has to be looked at, and dg_hdl_close() to be
 *         called, also when that has something to say: then nothing else may be
 */
DG_HDL_API struct dg_hdl *dg_hdl_open(const char *model, const char *settings, const char *motion,
                                      const char *memory);

/** Give it back; NULL is fine. What was written to the memory's file is there without that. */
DG_HDL_API void dg_hdl_close(struct dg_hdl *self);

/** What was wrong with the latest call that failed; "" when none did. */
DG_HDL_API const char *dg_hdl_error(const struct dg_hdl *self);

/** The inputs are at these levels (enum dg_hdl_wire) from `now` (ps) on; what was due up to `now`
 * comes first. A `now` before the latest one is taken for that one. @return levels of the outputs
 */
DG_HDL_API int dg_hdl_wires(struct dg_hdl *self, int64_t now, int inputs);

/** When to call dg_hdl_wires() again (ps), unless an input changes before; DG_HDL_NEVER. Always
 * behind the latest `now`. */
DG_HDL_API int64_t dg_hdl_next(const struct dg_hdl *self);

/** What the user should be told: BiSS, no pulse of MA for `hint_us` (100 here) since a start, see
 * src/biss/README.md. When dg_hdl_wires() has given DG_HDL_HINT, or, with `at_end`, at the end of
 * the simulation. @return "": nothing */
DG_HDL_API const char *dg_hdl_hint(struct dg_hdl *self, int at_end);

/** The position in the latest frame (BiSS, SSI), of which the master had the first edge that got to
 * the encoder; -1: there was none. For RS485 the position at the latest `now`. */
DG_HDL_API int64_t dg_hdl_latched(const struct dg_hdl *self);
/** The moment (ps) that this position is of; -1: there was no frame. */
DG_HDL_API int64_t dg_hdl_latched_at(const struct dg_hdl *self);
/** The position as the encoder would tell it at any moment (ps), by where the shaft is then as far
 * as is known now; -1: no power. */
DG_HDL_API int64_t dg_hdl_position(const struct dg_hdl *self, int64_t at);

/** The shaft is at `turns` (+-2^20) at `now`, and rests. */
DG_HDL_API int dg_hdl_turn(struct dg_hdl *self, int64_t now, double turns);
/** It turns with `rpm` (+-10^6) from where it is. */
DG_HDL_API int dg_hdl_speed(struct dg_hdl *self, int64_t now, double rpm);
/** It moves as these words say, from `now` on. */
DG_HDL_API int dg_hdl_motion(struct dg_hdl *self, int64_t now, const char *words);
/** A quantity of the world, in its unit: "temperature" in degC, say. */
DG_HDL_API int dg_hdl_world(struct dg_hdl *self, int64_t now, const char *name, double value);
/** A fault of the catalogue (`drehgeber faults MODEL`) happens, or is made good. */
DG_HDL_API int dg_hdl_fault(struct dg_hdl *self, int64_t now, const char *name, int on);
/** Power, also from on to on: a power cycle. */
DG_HDL_API int dg_hdl_power(struct dg_hdl *self, int64_t now, int on);

/** A line of SCPI. @return what it answers, until the next call; NULL when it fails, which also is
 * when the encoder keeps an error in its queue: that is in dg_hdl_error() then, and out of it */
DG_HDL_API const char *dg_hdl_command(struct dg_hdl *self, int64_t now, const char *line);

/** RS485: sin+, sin-, cos+, cos- (index 0 to 3) in volts at any moment (ps); 0 without power. */
DG_HDL_API double dg_hdl_volts(const struct dg_hdl *self, int64_t at, int index);

#ifdef __cplusplus
}
#endif

#endif
