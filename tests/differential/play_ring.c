/* SPDX-License-Identifier: MIT */
/*
 * A ring of several encoders: each is a player of its own, and cycles are those of the bus.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/bus_words.h"
#include "drehgeber/host_wire.h"
#include "play_ring.h"

#define WORDS_OF_RING ((size_t)RING_PLAYERS * DG_RING_WORDS_MAX)
#define DIGITS_OF_WORD 4u

static struct player players[RING_PLAYERS];
/* The bus is in one of these, its IN image beside it. */
static struct {
    struct host_rig_place memory;
    uint16_t in[WORDS_OF_RING];
} places[2];
static unsigned at;
static char labels[RING_PLAYERS][4];
static uint16_t out[WORDS_OF_RING];
static size_t count;
static struct dg_bus *bus; /* NULL: no cycle yet */
static unsigned disturbance;
static uint8_t state[HOST_RIG_MEMORY_MAX];

void ring_begin(unsigned disturbances)
{
    count = 0;
    bus = NULL;
    disturbance = disturbances;
    memset(places[at].in, 0, sizeof places[at].in);
}

/* The master identifies by itself, as the package's does. */
static bool make_bus(void)
{
    static const struct dg_bus_ops ops = {.tx = NULL};
    const struct dg_bus_words_setup wire = {sizeof wire, places[at].in, WORDS_OF_RING, true};
    const struct dg_bus_setup setup = {sizeof setup, &dg_bus_words, RING_PLAYERS,
                                       &wire,        &ops,          NULL};

    bus = dg_bus_init(&places[at].memory, sizeof places[at].memory, &setup);
    for (size_t i = 0; bus != NULL && i < count; i++) {
        if (dg_bus_attach(bus, players[i].host, NULL) != (int)i) {
            bus = NULL;
        }
    }
    return bus != NULL;
}

/* Encoders and ring in other, dirty memory. */
static void go_on_elsewhere(void)
{
    const size_t n = dg_bus_state_size(bus);
    const bool saved = n <= sizeof state && dg_bus_save(bus, state, n) == DG_HOST_OK;

    for (size_t i = 0; i < count; i++) {
        player_go_on_elsewhere(&players[i]);
    }
    memset(&places[at], (int)(player_draw(&players[0]) & 0xFFu), sizeof places[at]);
    at ^= 1u;
    if (!make_bus() || !saved || dg_bus_restore(bus, state, n) != DG_HOST_OK) {
        printf("  a ring is not restored\n");
    }
}

static const struct dg_ring_state *run_cycle(uint64_t now, bool identify)
{
    const struct dg_tap_event event = {
        .at = now,
        .kind = DG_TAP_WORDS,
        .words = {.out = out, .count = dg_ring_state(bus)->words, .identify = identify},
    };

    for (size_t i = 0; i < count; i++) {
        struct player *player = &players[i];
        player_step(player, now);
        dg_bus_control(bus, i, player->panel != NULL ? dg_host_panel_encoder(player->panel) : NULL);
        (void)dg_bus_changed(bus, i, now);
    }
    (void)dg_bus_rx(bus, &event);
    if ((disturbance & DISTURB_RESTORE) != 0 && player_draw(&players[0]) % 4u == 0) {
        go_on_elsewhere();
    }
    return dg_ring_state(bus);
}

/* Four digits a word; those that are not there are 0. */
static void read_image(const char *word)
{
    char digits[DIGITS_OF_WORD + 1u] = "";

    memset(out, 0, sizeof out);
    for (size_t i = 0; i < WORDS_OF_RING && strlen(word) >= DIGITS_OF_WORD; i++) {
        memcpy(digits, word, DIGITS_OF_WORD);
        out[i] = (uint16_t)strtoul(digits, NULL, 16);
        word += DIGITS_OF_WORD;
    }
}

static bool play_cycle(unsigned number, uint64_t now, const char *image)
{
    if (bus == NULL && !make_bus()) {
        return false;
    }
    read_image(image);
    const struct dg_ring_state *is = run_cycle(now, false);
    if (is->result == DG_RING_IDENTIFY && !is->dropped) {
        is = run_cycle(now, false);
    }
    if (is->dropped || is->result != DG_RING_OK) {
        printf("%u cycle %d\n", number, DG_HOST_ERR_SILENT);
        return true;
    }
    printf("%u cycle 0 ", number);
    for (size_t i = 0; i < is->words; i++) {
        printf("%04x", places[at].in[i]);
    }
    printf(";\n");
    return true;
}

static bool play_identify(unsigned number, uint64_t now)
{
    if (bus == NULL && !make_bus()) {
        return false;
    }
    const struct dg_ring_state *is = run_cycle(now, true);
    if (is->dropped) {
        printf("%u identify %d\n", number, DG_HOST_ERR_SILENT);
        return true;
    }
    printf("%u identify 0 ", number);
    for (size_t i = 0; i < is->reached; i++) {
        printf("%04x", dg_ring_id_word(bus, i));
    }
    printf(";\n");
    return true;
}

/* "N:encoder MODEL" */
static bool add_encoder(unsigned number, const char *name, const char *model)
{
    if (count == RING_PLAYERS) {
        return false;
    }
    struct player *player = &players[count];
    player->disturbance = 0;
    if (!player_begin(player, model)) {
        return false;
    }
    (void)snprintf(labels[count], sizeof labels[count], "%zu:", count + 1u);
    player->label = labels[count++];
    printf("%u %s 0\n", number, name);
    return true;
}

bool ring_perform(unsigned number, char *words[], int n)
{
    const uint64_t now = strtoull(words[0], NULL, 0);
    char *colon = strchr(words[1], ':');

    if (colon == NULL) {
        return strcmp(words[1], "cycle") == 0 && n == 3
                   ? play_cycle(number, now, words[2])
                   : strcmp(words[1], "identify") == 0 && n == 2 && play_identify(number, now);
    }
    if (strcmp(colon, ":encoder") == 0 && n == 3) {
        return add_encoder(number, words[1], words[2]);
    }
    const size_t place = strtoul(words[1], NULL, 10) - 1u;
    words[1] = colon + 1;
    return place < count && player_perform(&players[place], number, words, n);
}
