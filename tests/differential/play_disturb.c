/* SPDX-License-Identifier: MIT */
/*
 * What must not change the log: time in small steps, looks, states that are saved and restored.
 */
#include <stdio.h>
#include <string.h>

#include "play.h"

/* Steps in between at most, before an operation. */
#define STEPS_MAX 3u
/* One look in so many is at everything: texts and whole states take nearly all of the time. */
#define WHOLE_LOOKS 8u

static uint8_t state[HOST_RIG_MEMORY_MAX];

/* Marsaglia's xorshift. */
uint32_t player_draw(struct player *self)
{
    self->chance ^= self->chance << 13;
    self->chance ^= self->chance >> 17;
    self->chance ^= self->chance << 5;
    return self->chance;
}

static void look_at_texts_and_state(struct player *self)
{
    const struct dg_host *host = self->host;
    struct dg_host_fault fault;
    struct dg_host_key key;
    char value[64];

    for (size_t i = 0; dg_host_key(host, i, &key) == DG_HOST_OK; i++) {
        (void)dg_host_get(host, key.name, value, sizeof value);
    }
    for (size_t i = 0; self->panel != NULL && dg_host_fault(self->panel, i, &fault) == 0; i++) {
    }
    (void)dg_host_memory_copy(host, state, sizeof state);
    (void)dg_host_save(self->host, state, sizeof state);
}

/* Everything in host.h that is a look, at moments in the past and in the future, too. */
static void look_around(struct player *self)
{
    const struct dg_host *host = self->host;
    const uint64_t at = self->now - 1000 + player_draw(self) % 100000u;
    uint16_t ids[DG_HOST_FILTERS];
    uint64_t counts[2];
    int32_t uv[4];
    struct dg_host_uart uart;

    (void)dg_host_position(host, at, counts);
    (void)dg_host_positions(host, at, 1000, counts, 2);
    (void)dg_host_latched(host, &counts[0], &counts[1]);
    (void)dg_host_sincos(host, at, uv);
    (void)dg_host_uart(host, &uart);
    (void)dg_host_bit_rate(host);
    (void)dg_host_bus_state(host);
    (void)dg_host_filters(host, ids);
    (void)dg_host_answer_at(host);
    (void)dg_host_angle(host, at);
    (void)dg_host_next(host);
    (void)dg_host_lost(host);
    if (player_draw(self) % WHOLE_LOOKS == 0) {
        look_at_texts_and_state(self);
    }
}

void player_go_on_elsewhere(struct player *self)
{
    struct host_rig_place *place = &self->places[self->place ^ 1u];
    const size_t n = dg_host_state_size(self->host);

    memset(place, (int)(player_draw(self) & 0xFFu), sizeof *place);
    struct dg_host *other = dg_host_make(place, sizeof *place, dg_host_model(self->host));
    if (dg_host_save(self->host, state, sizeof state) != DG_HOST_OK ||
        dg_host_restore(other, state, n) != DG_HOST_OK) {
        printf("  a state is not restored\n");
        return;
    }
    memset(self->host, (int)(player_draw(self) & 0xFFu), n);
    player_exchange(self, other);
}

static void disturb_now(struct player *self)
{
    if ((self->disturbance & DISTURB_LOOKS) != 0) {
        look_around(self);
    }
    if ((self->disturbance & DISTURB_RESTORE) != 0 && player_draw(self) % 4u == 0) {
        player_go_on_elsewhere(self);
    }
}

void player_disturb(struct player *self, uint64_t until)
{
    disturb_now(self);
    if ((self->disturbance & DISTURB_STEPS) == 0) {
        return;
    }
    for (unsigned n = player_draw(self) % (STEPS_MAX + 1u); n > 0 && self->now < until; n--) {
        player_step(self, self->now + 1u + player_draw(self) % (until - self->now));
        player_drain(self);
        disturb_now(self);
    }
}
