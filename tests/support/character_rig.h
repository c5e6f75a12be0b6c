/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Encoders on a line of characters of the library (bus_characters.h), in virtual time, and its
 * master. What goes wrong fails the test.
 */
#ifndef TESTS_SUPPORT_CHARACTER_RIG_H
#define TESTS_SUPPORT_CHARACTER_RIG_H

#include "drehgeber/bus_characters.h"
#include "drehgeber/control.h"
#include "drehgeber/hiperface.h"
#include "host_rig.h"

#define CHARACTER_RIG_MAX 4u
#define CHARACTER_RIG_EVENTS 512u
#define CHARACTER_RIG_BUS 16384u
/** At 9600 Bd with even parity: 11 bits, 44 bits, the usual reaction. */
#define CHARACTER 1145834u
#define SILENCE 4583334u
#define REACTION MS
/** From the end of a request to the first start bit of its reply. */
#define ANSWER (SILENCE + REACTION)
/** The fault wire_delay; longer than all that could still come. */
#define DELAY (300 * MS)
#define REST (100 * MS)

/** A character, and the encoder that sent it. */
struct character_told {
    size_t place;
    struct dg_tap_event event;
};

/** The line, with encoders at 40h, 41h ... */
struct character_rig {
    struct host_rig_place places[CHARACTER_RIG_MAX];
    struct dg_host *hosts[CHARACTER_RIG_MAX];
    struct dg_encoder control[CHARACTER_RIG_MAX];
    alignas(DG_HOST_ALIGN) uint8_t memory[CHARACTER_RIG_BUS];
    struct dg_bus *bus;
    dg_ns now;
    enum dg_bus_answer answer;                        /**< of the first encoder's memory */
    struct character_told sent[CHARACTER_RIG_EVENTS]; /**< by encoders */
    size_t count;
    struct character_told seen[CHARACTER_RIG_EVENTS]; /**< by whoever looks */
    size_t seen_count;
    dg_ns whole_at; /**< of replies that were told at once, the first one */
    uint8_t whole[4 * DG_REPLY_MAX];
    size_t whole_count;
};

/** A line whose master hands over requests at once. */
extern const struct dg_characters_setup character_rig_paced;

/** Make it, with power and initialised. `wire` has &character_rig_whole or tells characters. */
void character_rig_make(struct character_rig *self, const struct dg_characters_setup *wire,
                        size_t encoders);

/** dg_characters_setup.whole: keep what is told at once. */
void character_rig_whole(void *ctx, size_t place, dg_ns at, const uint8_t *bytes, size_t n);

/** Time goes on, deadline by deadline. */
void character_rig_pass_to(struct character_rig *self, dg_ns until);

/** The master says these characters now. */
void character_rig_say_at(struct character_rig *self, uint32_t baud, char parity, const char *hex);
/** The same at 9600 Bd with even parity; what came before is forgotten. */
void character_rig_say(struct character_rig *self, const char *hex);

/** From sent[from] on: these characters of a reply that began at `begin`, from its character
 * `first` on. */
void character_rig_expect_sent(const struct character_rig *self, size_t from, dg_ns begin,
                               size_t first, const char *hex);
/** A request of three characters is answered by `place`, with seven, exactly then. */
void character_rig_expect_answer(struct character_rig *self, const char *request, size_t place);
/** Nobody answers. */
void character_rig_expect_silence(struct character_rig *self, const char *request);

/** Let a fault happen to `count` requests or replies. */
void character_rig_bend(struct character_rig *self, size_t place, enum dg_wire_fault fault,
                        uint32_t count);

/** An encoder's device. */
const struct dg_hf *character_rig_device(const struct character_rig *self, size_t place);

#endif
