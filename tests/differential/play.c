/* SPDX-License-Identifier: MIT */
/*
 * usage: differential_play [steps|looks|restore|fresh]... < SCRIPTS > LOGS
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "play_ring.h"

static struct player player;
static bool in_ring; /* the script is about one */

static const struct {
    const char *name;
    unsigned bit;
} disturbances[] = {
    {"steps", DISTURB_STEPS},
    {"looks", DISTURB_LOOKS},
    {"restore", DISTURB_RESTORE},
    {"fresh", DISTURB_FRESH},
};

/* A character of RS485 has a line of its own, with its end: hosts differ in how many they tell at
 * once. */
static void log_event(const struct dg_host_event *event)
{
    if (event->kind == DG_HOST_BYTES) {
        for (unsigned i = 0; i < event->length; i++) {
            printf("  @%" PRIu64 " byte %02x\n", event->at + (i + UINT64_C(1)) * event->id,
                   event->data[i]);
        }
        return;
    }
    if (event->kind == DG_HOST_EDGE) {
        printf("  @%" PRIu64 " edge %u\n", event->at, event->data[0]);
        return;
    }
    printf("  @%" PRIu64 " %s %" PRIx32 " %x ", event->at,
           event->kind == DG_HOST_CAN ? "message" : "event", event->id, event->flags);
    for (unsigned i = 0; i < event->length; i++) {
        printf("%02x", event->data[i]);
    }
    printf(";\n");
}

void player_drain(struct player *self)
{
    struct dg_host_event event;
    int result;

    while ((result = dg_host_receive(self->host, &event)) != 0) {
        if (result < 0) {
            printf("  lost\n");
        } else {
            log_event(&event);
        }
    }
}

void player_step(struct player *self, uint64_t now)
{
    if (self->panel != NULL) {
        (void)dg_host_panel_step(self->panel, now);
    } else {
        (void)dg_host_step(self->host, now);
    }
    self->now = now > self->now ? now : self->now;
}

bool player_begin(struct player *self, const char *model)
{
    const unsigned disturbance = self->disturbance;

    memset(self, 0xA5, sizeof *self);
    self->host = dg_host_make(&self->places[0], sizeof self->places[0], model);
    self->place = 0;
    self->panel = NULL;
    self->disturbance = disturbance;
    self->chance = 1;
    self->now = 0;
    memset(self->turns, 0, sizeof self->turns);
    self->was_on = false;
    self->label = "";
    return self->host != NULL;
}

struct dg_host *player_make_alike(struct player *self, bool all)
{
    struct host_rig_place *place = &self->places[self->place ^ 1u];
    char value[64];
    struct dg_host_key key;

    memset(place, (int)(self->chance & 0xFFu), sizeof *place);
    struct dg_host *other = dg_host_make(place, sizeof *place, dg_host_model(self->host));
    for (size_t i = 0; dg_host_key(self->host, i, &key) == DG_HOST_OK; i++) {
        if ((all || key.always == 0) &&
            (dg_host_get(self->host, key.name, value, sizeof value) < 0 ||
             dg_host_set(other, key.name, value) != DG_HOST_OK)) {
            printf("  setting %s is not taken over\n", key.name);
        }
    }
    return other;
}

void player_exchange(struct player *self, struct dg_host *host)
{
    self->place ^= 1u;
    self->host = host;
}

/* @return whether the line is one of a script */
static bool play_line(unsigned *number, char *line)
{
    char *words[WORDS_MAX];
    int count = 0;

    for (char *word = strtok(line, " \n"); word != NULL; word = strtok(NULL, " \n")) {
        if (count == WORDS_MAX) {
            return false;
        }
        words[count++] = word;
    }
    if (count == 3 && strcmp(words[0], "script") == 0) {
        printf("script %s %s\n", words[1], words[2]);
        *number = 0;
        in_ring = strcmp(words[1], "ring") == 0;
        if (in_ring) {
            ring_begin(player.disturbance);
        }
        return in_ring || player_begin(&player, words[1]);
    }
    *number += 1;
    if (in_ring) {
        return count >= 2 && ring_perform(*number, words, count);
    }
    return player.host != NULL && count >= 2 && player_perform(&player, *number, words, count);
}

static bool read_disturbances(int count, char *names[])
{
    for (int i = 0; i < count; i++) {
        const unsigned before = player.disturbance;

        for (size_t k = 0; k < DG_COUNT(disturbances); k++) {
            player.disturbance |=
                strcmp(names[i], disturbances[k].name) == 0 ? disturbances[k].bit : 0u;
        }
        if (player.disturbance == before) {
            return false;
        }
    }
    return true;
}

int main(int argc, char *argv[])
{
    char line[LINE_MAX_CHARS];
    unsigned number = 0;

    if (!read_disturbances(argc - 1, argv + 1)) {
        fprintf(stderr, "usage: differential_play [steps|looks|restore|fresh]...\n");
        return 2;
    }
    while (fgets(line, sizeof line, stdin) != NULL) {
        if (!play_line(&number, line)) {
            fprintf(stderr, "differential_play: operation %u is unknown\n", number);
            return 2;
        }
    }
    return fflush(stdout) == 0 ? 0 : 1;
}
