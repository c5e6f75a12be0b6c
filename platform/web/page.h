/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A rig of the page: the library's (rig_engine.h), of the text of a rig file. page_rig.c makes it,
 * page_wires.c is what the page hears and says on its wires. The page reads what stands first in
 * web_rig, web_encoder and web_wire, in words of 32 bits; page/rig.js has the list.
 */
#ifndef DREHGEBER_WEB_PAGE_H
#define DREHGEBER_WEB_PAGE_H

#include "drehgeber/rig_engine.h"
#include "drehgeber/words.h"

/** Bytes of what is said that are shown with its line, at most. */
#define WEB_SAID_MAX 512u

/** Bytes that no line has told yet. */
struct web_said {
    uint32_t count;
    uint8_t bytes[WEB_SAID_MAX];
};

/** A wire. */
struct web_wire {
    const uint8_t *bytes; /**< of the line that is being told */
    uint32_t count;
    struct web_said said[2]; /**< by the master, by encoders */
    struct dg_words_wire words;
    uint16_t out[DG_RING_MAX * DG_RING_WORDS_MAX]; /**< OUT image of a ring */
};

/** A session of an encoder. */
struct web_client {
    struct dg_control control;
    uint32_t index; /**< of its encoder, which it selects in each line anew */
    char *answer;   /**< of the call at hand */
    size_t room;
};

/** An encoder. */
struct web_encoder {
    struct dg_host *host;
    struct web_wire *wire;
    struct dg_bus *bus;
    size_t place;
    const struct dg_shaft *shaft;
    const char *name;
    const char *what;          /**< a few words on its resolution */
    struct web_client *page;   /**< the page's own session, */
    struct web_client *prompt; /**< and that of who types */
    const uint16_t *in;        /**< IN image of its ring */
    struct web_client clients[2];
};

/** The wire begins to be told; `memory` is for its words. */
void web_wire_init(struct web_wire *self, const struct dg_words *words, void *memory);
/** The door of a wire of that medium, whose ctx is a struct web_wire. */
const struct dg_bus_ops *web_wire_ops(enum dg_medium medium);

#endif
