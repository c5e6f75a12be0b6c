/* SPDX-License-Identifier: MIT */
/* What a test sees of the fake library: the handlers it was given, to be called as the real one
   does from threads of its own, and what it was told. */
#ifndef DREHGEBER_TEST_FAKE_SILKIT_H
#define DREHGEBER_TEST_FAKE_SILKIT_H

#include "silkit_library.h"

#define FAKE_TOPICS 32u
#define FAKE_FRAMES 64u

struct fake_topic {
    const char *topic;
    char media_type[64];
    void *ctx;
    lx_sk_on_data *handler; /* NULL: it is published */
    uint8_t bytes[256];     /* published last */
    size_t size;
    unsigned count;
    uint64_t hash; /* of all that was published */
};

struct fake_silkit {
    const char *refuses; /* this function says no; NULL: none does */
    const char *hangs;   /* this one never comes back; likewise */
    const char *why;     /* it says no; NULL: it had no luck */
    char config[512];    /* of the participant */
    unsigned configs;    /* that were not given back */
    char participant[64], registry[64], network[64];
    int mode;          /* of the lifecycle */
    uint64_t duration; /* of a step */
    uint32_t baud;
    void *ctx; /* of what follows */
    lx_sk_on_lifecycle *ready, *stop, *shutdown;
    lx_sk_on_abort *abort;
    lx_sk_on_step *step;
    lx_sk_on_peer *gone;
    void *can_ctx;
    lx_sk_on_frame *frame;
    lx_sk_on_transmit *transmit;
    lx_sk_on_error *error;
    struct fake_topic topic[FAKE_TOPICS];
    unsigned topics;
    struct {
        uint32_t id;
        uint32_t flags;
        uint16_t dlc;
        size_t size;
        uint8_t bytes[8];
    } sent[FAKE_FRAMES];
    unsigned frames;
    unsigned completed, left, stopped, started;
};

#endif
