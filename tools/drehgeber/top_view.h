/* SPDX-License-Identifier: MIT */
/*
 * What `top` knows of a rig: top_client.c fills it, top_screen.c draws it. Texts are cut to fit.
 */
#ifndef DREHGEBER_TOOL_TOP_VIEW_H
#define DREHGEBER_TOOL_TOP_VIEW_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/fault.h"
#include "drehgeber/time.h"
#include "server.h"

#define TOP_NONE SIZE_MAX /* no place in a list */
#define TOP_FRAMES 32u

struct top_shaft {
    char name[64];
    size_t encoder; /* one that sits on it, through which it is steered; TOP_NONE */
    bool known;     /* the two below are */
    bool held;      /* they were set by a key; what was asked before does not count */
    int64_t udeg;   /* angle in 10^-6 degrees */
    int64_t mrpm;
};

struct top_encoder {
    char name[64];
    char model[24];
    char wire[96];
    size_t shaft; /* TOP_NONE: not known yet */
    bool known;   /* what follows is */
    bool powered;
    bool up; /* its wire is */
    char mode[24];
    char position[24]; /* as the bus sees it; "-" */
    char leds[96];     /* "bus:on err:off"; "-" */
    char errors[96];   /* newest first; "-" */
    char faults[256];  /* names with a blank between them; "-" */
    char more[512];    /* the rest of the state: "replies=3 damaged=0" */
    uint64_t frames;   /* at the moment `counted` */
    dg_ns counted;     /* 0: never */
    int64_t rate;      /* frames per second; -1: not known */
};

struct top_fault {
    char name[32];
    char cause[160];
    char effect[256];
};

struct top_view {
    char where[LX_SERVER_ADDRESS_MAX]; /* address */
    char rig[64];                      /* name */
    char time[32];                     /* of the rig's clock in seconds */
    char trouble[128];                 /* why nothing of this is new; "": all is well */
    char message[160];                 /* the last refusal; "" */

    struct top_shaft *shafts; /* owned by the client */
    size_t shaft_count;
    struct top_encoder *encoders; /* likewise */
    size_t encoder_count;

    char frames[TOP_FRAMES][256]; /* of the wire of `selected`, newest last */
    size_t frame_count;
    struct top_fault faults[DG_FAULTS_MAX]; /* catalogue of `faults_of` */
    size_t fault_count;
    size_t faults_of; /* TOP_NONE: none */

    /* Set by the keys and the screen, for the client to know what is wanted. */
    size_t selected;
    size_t first; /* encoder in the first line of the table */
    size_t rows;  /* lines of the table */
};

/* Whether the encoder's list of active faults has this name. */
bool top_fault_active(const struct top_encoder *encoder, const char *name);

#endif
