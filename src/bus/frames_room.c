/* SPDX-License-Identifier: MIT */
/* Frames that wait, in lists through one piece of memory. */
#include "frames_private.h"

static struct dg_bus_frames_room *room_at(const struct frames_wire *self, uint16_t place)
{
    return &self->setup.room[place - 1u];
}

static void append_place(struct frames_wire *self, struct frames_list *list, uint16_t place)
{
    room_at(self, place)->next = 0;
    if (list->count == 0) {
        list->first = place;
    } else {
        room_at(self, list->last)->next = place;
    }
    list->last = place;
    list->count++;
}

/* The one behind `before` leaves the list; 0: the first one. */
static uint16_t unlink_behind(struct frames_wire *self, struct frames_list *list, uint16_t before)
{
    const uint16_t place = before == 0 ? list->first : room_at(self, before)->next;
    const uint16_t next = room_at(self, place)->next;

    if (before == 0) {
        list->first = next;
    } else {
        room_at(self, before)->next = next;
    }
    list->last = next == 0 ? before : list->last;
    list->count--;
    return place;
}

/* What was never used is not touched before: a host's memory costs what is used of it. 0: none. */
static uint16_t find_unused(struct frames_wire *self)
{
    if (self->unused.count > 0) {
        return unlink_behind(self, &self->unused, 0);
    }
    return self->used < self->setup.rooms ? ++self->used : 0;
}

bool dg_bus_room_add(struct frames_wire *self, struct frames_list *list, size_t from, dg_ns at,
                     const struct dg_can_frame *frame)
{
    const uint16_t place = find_unused(self);

    if (place == 0) {
        self->counters.lost++;
        return false;
    }
    struct dg_bus_frames_room *room = room_at(self, place);
    room->at = at;
    room->frame = *frame;
    room->from = (uint8_t)from;
    append_place(self, list, place);
    return true;
}

static struct dg_bus_frames_room fetch_behind(struct frames_wire *self, struct frames_list *list,
                                              uint16_t before)
{
    const uint16_t place = unlink_behind(self, list, before);

    append_place(self, &self->unused, place);
    return *room_at(self, place);
}

struct dg_bus_frames_room dg_bus_room_fetch(struct frames_wire *self, struct frames_list *list)
{
    return fetch_behind(self, list, 0);
}

/* The first frame of each encoder takes part. */
struct dg_bus_frames_room dg_bus_room_arbitrate(struct frames_wire *self, struct frames_list *list)
{
    struct frames_set seen = {{0}};
    uint16_t winner = 0;
    uint16_t before = 0;

    for (uint16_t i = 0, place = list->first; place != 0;
         i = place, place = room_at(self, i)->next) {
        const struct dg_bus_frames_room *room = room_at(self, place);
        uint32_t *word = &seen.word[room->from / 32u];
        const uint32_t bit = UINT32_C(1) << room->from % 32u;
        if ((*word & bit) == 0 &&
            (winner == 0 || room->frame.id < room_at(self, winner)->frame.id)) {
            winner = place;
            before = i;
        }
        *word |= bit;
    }
    return fetch_behind(self, list, before);
}

void dg_bus_room_settle(struct frames_wire *self)
{
    uint16_t place = self->held.first;

    self->release = DG_NEVER;
    for (uint16_t left = self->held.count; left > 0; left--) {
        self->release = dg_earliest(self->release, room_at(self, place)->at);
        place = room_at(self, place)->next;
    }
    self->full = self->full && self->sending.count > DG_BUS_FRAMES_PACED / 2u;
}
