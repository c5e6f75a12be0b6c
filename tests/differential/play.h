/* SPDX-License-Identifier: MIT */
/*
 * The player: an encoder behind its handle, to which a script happens, and the log of it. README.md
 * explains both.
 */
#ifndef TESTS_DIFFERENTIAL_PLAY_H
#define TESTS_DIFFERENTIAL_PLAY_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/shaft.h"
#include "host_rig.h"

/* What must not change the log, beside the script. */
enum disturbance {
    DISTURB_STEPS = 1,   /* time passes in many steps in place of one */
    DISTURB_LOOKS = 2,   /* somebody looks at all there is to see */
    DISTURB_RESTORE = 4, /* the state goes on in a handle in other, dirty memory */
    DISTURB_FRESH = 8,   /* power comes on in a new handle with this one's EEPROM */
};

/* Longest line of a script, and most words of it. */
#define LINE_MAX_CHARS 256u
#define WORDS_MAX 6
/* Longest answer. */
#define SAID_MAX 1024u

/* The shaft is at `angle` and turns on. */
struct turn {
    uint64_t at;
    int64_t angle;
    int64_t rate;
};

struct player {
    struct host_rig_place places[2]; /* the handle is in one; the other is free */
    struct host_rig_place panel_place;
    unsigned place;
    struct dg_host *host;
    struct dg_host_panel *panel; /* NULL: there is none */
    struct dg_shaft driver;      /* of the panel's shaft */
    unsigned disturbance;        /* enum disturbance */
    uint32_t chance;             /* state of the disturbances' random numbers */
    uint64_t now;
    struct turn turns[2]; /* the latest of the shaft, and what was before */
    bool was_on;
    const char *label; /* in front of an operation's name: which of several it is about */
    size_t said_n;     /* of `said` */
    char said[SAID_MAX];
};

/* Make it anew, for an encoder. @return false: there is no such model */
bool player_begin(struct player *self, const char *model);

/* Do what a line says, whose words are words[0..count - 1], the moment first, and log it as
 * operation `number`. @return false: there is no such operation */
bool player_perform(struct player *self, unsigned number, char *words[], int count);

/* Log what the encoder has sent so far. */
void player_drain(struct player *self);

/* Let time pass up to `now`. */
void player_step(struct player *self, uint64_t now);

/* A new handle in the free place, with the settings of this one: all, or those that can be set
 * once. It is not yet this player's. */
struct dg_host *player_make_alike(struct player *self, bool all);

/* Go on with the handle in the free place. */
void player_exchange(struct player *self, struct dg_host *host);

/* Go on with the state of this one in a handle in the free place. */
void player_go_on_elsewhere(struct player *self);

/* The disturbances' next random number. */
uint32_t player_draw(struct player *self);

/* Do to the encoder what must not change the log, at any moment up to `until`. */
void player_disturb(struct player *self, uint64_t until);

#endif
