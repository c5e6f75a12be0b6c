/* SPDX-License-Identifier: MIT */
/*
 * A line of characters. Each encoder says what is next, this file makes it happen in the order of
 * time:
 *
 *   dg_bus_rx --[paced: coming]--> arrive --> listen --> dg_host_feed --\
 *                                                                        > deadline, setting
 *   dg_bus_step ----> go_on -------------------------> dg_host_step ----/
 *                       \--> dg_bus_reply_go_on --> dg_bus_spread --> dg_host_feed
 *
 * At the same moment: what comes in, what is over of replies, what is due.
 */
#include "characters_private.h"

#include "drehgeber/wire_fault.h"

#define ENCODERS_MAX 32u
#define BITS_WITHOUT_PARITY 10u /* start bit, eight of data, stop bit */
#define NS_PER_S UINT64_C(1000000000)

/* --- settings --- */

static void set_pace(struct characters_pace *pace, uint32_t baud, char parity)
{
    const uint32_t bits = BITS_WITHOUT_PARITY + (parity != 'N' ? 1u : 0u);

    *pace = (struct characters_pace){.baud = baud, .parity = parity};
    if (baud != 0) {
        const dg_ns most = dg_bit_times_ns(bits, baud);
        const uint32_t over = (uint32_t)(most * baud - bits * NS_PER_S);
        pace->whole = most - (over > 0 ? 1u : 0u);
        pace->rest = over > 0 ? baud - over : 0;
    }
}

static void follow_pace(struct characters_pace *pace, uint32_t baud, char parity)
{
    if (baud != pace->baud || parity != pace->parity) {
        set_pace(pace, baud, parity);
    }
}

static dg_ns rounded_up(const struct characters_pace *pace)
{
    return dg_after(pace->whole, pace->rest > 0 ? 1u : 0u);
}

static bool fits_setting(const struct characters_place *self, uint32_t baud, char parity)
{
    return self->end.any_line || baud == DG_BAUD_ANY ||
           (baud == self->pace.baud && (parity == 0 || parity == self->pace.parity));
}

static bool is_parity(char parity)
{
    return parity == 'N' || parity == 'E' || parity == 'O';
}

/* What the master sends at, as far as it is known; else as the first encoder. */
static const struct characters_pace *pace_of(const struct dg_bus *self, uint32_t baud, char parity)
{
    struct characters_line *line = characters_line_of(self);
    const struct characters_pace *first = &characters_place_at(self, 0)->pace;

    if (!is_parity(parity)) {
        parity = first->parity;
    }
    follow_pace(&line->pace, baud == DG_BAUD_ANY || baud == 0 ? first->baud : baud, parity);
    return &line->pace;
}

/* --- calls into an encoder --- */

static void follow_setting(struct characters_place *self)
{
    if (dg_host_uart(self->place.host, &self->uart) == DG_HOST_OK) {
        follow_pace(&self->pace, self->uart.baud, (char)self->uart.parity);
    }
}

/* Behind each of them: its deadline, the setting it may have changed, what it has said. */
static void follow_encoder(struct characters_place *self, dg_ns now, dg_ns deadline)
{
    /* Whoever asks for the present again would stop time. */
    self->place.deadline = deadline > now ? deadline : dg_after(now, 1);
    follow_setting(self);
    dg_bus_reply_begin(self, now);
}

/* dg_host_wire.feed promises that the setting stays when a character comes and nothing else
 * happens: that is most of them, and asking costs as much as hearing. */
static void follow_character(struct characters_place *self, dg_ns now, dg_ns deadline)
{
    if (self->steady && self->said == 0 && self->place.deadline > now && deadline > now) {
        self->place.deadline = deadline;
    } else {
        follow_encoder(self, now, deadline);
    }
}

static void feed_character(struct characters_place *self, dg_ns at, uint8_t byte, unsigned flags)
{
    const struct dg_host_event event = {.at = at,
                                        .kind = DG_HOST_BYTES,
                                        .flags = (uint16_t)flags,
                                        .length = (flags & DG_HOST_START) != 0 ? 0 : 1,
                                        .data = {byte}};

    follow_character(self, at, dg_host_feed(self->place.host, &event));
}

static void hear_character(struct characters_place *self, dg_ns at, uint8_t byte, bool damaged)
{
    feed_character(self, at, byte, damaged ? DG_HOST_ENDED | DG_HOST_DAMAGED : DG_HOST_ENDED);
}

static void hear_reply(struct bus_place *from, const struct dg_host_event *event)
{
    if (event->kind == DG_HOST_BYTES) {
        dg_bus_reply_add((struct characters_place *)(void *)from, event->data, event->length);
    }
}

/* --- what everybody hears --- */

static void tell_character(const struct dg_bus *self, dg_ns at, bool ours,
                           const struct characters_pace *pace, uint8_t byte, bool damaged)
{
    const struct dg_tap_event event = {
        .at = at,
        .kind = DG_TAP_CHARACTER,
        .ours = ours,
        .character = {pace->baud, pace->parity, byte, damaged},
    };

    dg_bus_tell(self, &event);
}

void dg_bus_spread(struct characters_place *from, dg_ns at, uint8_t byte, bool damaged)
{
    const struct dg_bus *bus = from->place.bus;

    characters_line_of(bus)->heard = 0;
    if (bus->watched) {
        tell_character(bus, at, true, &from->pace, byte, damaged);
    }
    for (size_t i = 0; i < bus->count; i++) {
        struct characters_place *to = characters_place_at(bus, i);
        if (to != from && !dg_bus_reply_is_busy(to)) {
            hear_character(to, at, byte,
                           damaged || !fits_setting(to, from->pace.baud, from->pace.parity));
        }
    }
}

static bool is_for(const struct characters_place *self, uint8_t byte)
{
    const struct dg_bus_side *side = dg_host_side_at(self->place.host);

    return side->wants == NULL || side->wants(dg_host_line_of(self->place.host), byte);
}

/* Whether the master's character is kept from the encoder (fault). Decided at the first one of a
 * request for it; what is for others it would not take anyway. */
static bool is_deaf(struct characters_place *self, dg_ns now, uint8_t byte)
{
    const dg_ns heard = characters_line_of(self->place.bus)->heard;

    if (self->place.control == NULL || (self->place.control->faults.wire == 0 && !self->deaf)) {
        return false;
    }
    const dg_ns silence = dg_bit_times_ns(self->uart.timeout_bits, self->uart.baud);
    if (heard == 0 || dg_elapsed(now, heard) > silence) {
        self->deaf = is_for(self, byte) && dg_wire_fault_hear(self->place.control) != DG_WIRE_HEARD;
    }
    return self->deaf;
}

/* A character of the master, as one encoder hears it. */
static void listen_to_character(struct characters_place *self,
                                const struct characters_coming *coming, bool damaged)
{
    if (dg_host_powered(self->place.host) && !dg_bus_reply_is_busy(self) &&
        !is_deaf(self, coming->end, coming->byte)) {
        hear_character(self, coming->end, coming->byte,
                       damaged || !fits_setting(self, coming->baud, coming->parity));
    }
}

static bool anybody_sends(const struct dg_bus *self, dg_ns now)
{
    bool sends = false;

    for (size_t i = 0; i < self->count && !sends; i++) {
        sends = dg_bus_reply_sends(characters_place_at(self, i), now);
    }
    return sends;
}

/* A character of the master is over. */
static void deliver_character(struct dg_bus *self, const struct characters_coming *coming)
{
    struct characters_line *line = characters_line_of(self);
    const bool meets = anybody_sends(self, coming->end);

    if (self->watched) {
        tell_character(self, coming->end, false, pace_of(self, coming->baud, coming->parity),
                       coming->byte, coming->damaged);
    }
    line->counters.collided += meets ? 1u : 0u;
    for (size_t i = 0; i < self->count; i++) {
        listen_to_character(characters_place_at(self, i), coming, coming->damaged || meets);
    }
    line->heard = coming->end;
}

/* A character begins on a line that was idle: whose frame goes on must not take it for over. */
static void begin_character(struct dg_bus *self, dg_ns now)
{
    for (size_t i = 0; i < self->count; i++) {
        struct characters_place *to = characters_place_at(self, i);
        if (dg_host_powered(to->place.host) && !dg_bus_reply_is_busy(to) && !to->deaf) {
            feed_character(to, now, 0, DG_HOST_START);
        }
    }
}

/* --- on its way in --- */

static dg_ns coming_next(const struct characters_line *line)
{
    return line->count > 0 ? line->coming[line->first].end : DG_NEVER;
}

static struct characters_coming take_coming(struct characters_line *line)
{
    const struct characters_coming first = line->coming[line->first];

    line->first = (line->first + 1u) % DG_COMING_MAX;
    line->count--;
    return first;
}

/* What is handed over begins now, or behind what is on the line. */
static void put_coming(struct dg_bus *self, const struct characters_coming *coming)
{
    struct characters_line *line = characters_line_of(self);

    if (line->end < self->now && line->count == 0) {
        begin_character(self, self->now);
    }
    if (line->count == DG_COMING_MAX) {
        line->counters.overrun++;
        return;
    }
    struct characters_coming *place = &line->coming[(line->first + line->count) % DG_COMING_MAX];
    line->end = dg_after(self->now > line->end ? self->now : line->end,
                         rounded_up(pace_of(self, coming->baud, coming->parity)));
    line->count++;
    *place = *coming;
    place->end = line->end;
}

/* --- time --- */

/* What comes next: a deadline of an encoder, and on the line a character that comes in, or a
 * character or the beginning of a reply. */
struct upcoming {
    dg_ns deadline;
    dg_ns coming;
    dg_ns reply;
    struct characters_place *sends;
};

static inline struct upcoming look_ahead(const struct dg_bus *self)
{
    struct upcoming to = {
        .deadline = DG_NEVER, .coming = coming_next(characters_line_of(self)), .reply = DG_NEVER};

    for (size_t i = 0; i < self->count; i++) {
        struct characters_place *place = characters_place_at(self, i);
        to.deadline = dg_earliest(to.deadline, place->place.deadline);
        if (place->reply.next < to.reply) {
            to.reply = place->reply.next;
            to.sends = place;
        }
    }
    return to;
}

/* In real time it is called later than it asked for. */
static void count_late(struct characters_place *self, dg_ns deadline)
{
    const struct dg_bus *bus = self->place.bus;
    struct characters_line *line = characters_line_of(bus);

    if (line->setup.late > 0 && bus->called > dg_after(deadline, line->setup.late) &&
        self->missed != bus->called) {
        self->missed = bus->called;
        line->counters.late++;
    }
}

/* All that were due at `deadline`, before one of them hears what another one says. What they say is
 * of the moment that they say it at. */
static void step_line_encoders(const struct dg_bus *self, dg_ns deadline, dg_ns now)
{
    for (size_t i = 0; i < self->count; i++) {
        struct characters_place *place = characters_place_at(self, i);
        if (place->place.deadline <= deadline) {
            count_late(place, deadline);
            dg_host_skip(place->place.host, now);
            follow_encoder(place, now, dg_host_step(place->place.host, now));
        }
    }
}

/* In real time the encoders are late when the host is, unless something has come in since. */
static dg_ns step_time(const struct dg_bus *self, dg_ns deadline, dg_ns on_line)
{
    const bool is_late = self->called > deadline && on_line > self->called;

    return characters_line_of(self)->setup.live && is_late ? self->called : deadline;
}

/* Whether a deadline comes first, up to `due`. */
static inline bool steps_next(const struct upcoming *next, dg_ns due)
{
    return next->deadline < dg_earliest(next->coming, next->reply) && next->deadline <= due;
}

static inline bool is_on_line(const struct upcoming *next, dg_ns now)
{
    const dg_ns at = dg_earliest(next->coming, next->reply);

    return at <= now && at != DG_NEVER;
}

static void serve_line(struct dg_bus *self, const struct upcoming *next)
{
    if (next->coming <= next->reply) {
        const struct characters_coming character = take_coming(characters_line_of(self));
        deliver_character(self, &character);
    } else {
        dg_bus_reply_go_on(next->sends, next->reply);
    }
}

/* All that happens on the line by `now`, and deadlines up to `due`, in the order of time. */
static void go_on_until(struct dg_bus *self, dg_ns now, dg_ns due)
{
    struct upcoming next = look_ahead(self);
    bool steps = steps_next(&next, due);

    while (steps || is_on_line(&next, now)) {
        if (steps) {
            const dg_ns on_line = dg_earliest(next.coming, next.reply);
            step_line_encoders(self, next.deadline, step_time(self, next.deadline, on_line));
        } else {
            serve_line(self, &next);
        }
        next = look_ahead(self);
        steps = steps_next(&next, due);
    }
}

static void go_on(struct dg_bus *self, dg_ns now)
{
    go_on_until(self, now, now);
}

/* What is over at this moment comes before what comes in, what is due comes behind. */
static void finish_characters(struct dg_bus *self)
{
    go_on_until(self, self->now, dg_elapsed(self->now, 1));
}

static void take_character(struct dg_bus *self, const struct dg_tap_event *event)
{
    const struct characters_coming coming = {.end = self->now,
                                             .baud = event->character.baud,
                                             .parity = event->character.parity,
                                             .byte = event->character.byte,
                                             .damaged = event->character.damaged};

    if (event->kind != DG_TAP_CHARACTER || self->count == 0) {
        return;
    }
    finish_characters(self);
    if (characters_line_of(self)->setup.paced) {
        put_coming(self, &coming);
    } else {
        deliver_character(self, &coming);
    }
}

/* The last character is early enough, as each one tells when it ended; not for those who look at
 * the line as it goes. */
static dg_ns next_of_all(const struct dg_bus *self)
{
    const struct characters_line *line = characters_line_of(self);
    const struct upcoming next = look_ahead(self);
    const dg_ns coming = self->watched || line->count == 0 ? next.coming : line->end;

    return dg_earliest(coming, dg_earliest(next.reply, next.deadline));
}

/* --- the medium --- */

static int begin(struct dg_bus *self, const void *setup)
{
    const struct dg_characters_setup *own = setup;

    if (own != NULL && own->size != sizeof *own) {
        return DG_ERR_ARGUMENT;
    }
    if (own != NULL) {
        characters_line_of(self)->setup = *own;
    }
    return DG_OK;
}

static int attach(struct bus_place *place)
{
    struct characters_place *self = (struct characters_place *)(void *)place;
    const struct dg_host_wire *wire = dg_host_wire_at(place->host);

    if (wire->uart == NULL) {
        return DG_ERR_ARGUMENT;
    }
    self->reply.damaged = CHARACTERS_WHOLE;
    self->reply.next = DG_NEVER;
    self->steady = wire->feed != NULL;
    follow_setting(self);
    return DG_OK;
}

static void changed(struct bus_place *place, dg_ns now)
{
    struct characters_place *self = (struct characters_place *)(void *)place;

    follow_encoder(self, now, place->deadline);
    if (!dg_host_powered(place->host)) {
        dg_bus_reply_stop(self);
        self->deaf = false;
    }
}

static void durable(struct bus_place *place, dg_ns now)
{
    dg_bus_reply_release((struct characters_place *)(void *)place, now);
}

const struct dg_bus_medium dg_bus_characters = {
    .medium = DG_MEDIUM_CHARACTERS,
    .wire_size = sizeof(struct characters_line),
    .place_size = sizeof(struct characters_place),
    .encoders_most = ENCODERS_MAX,
    .ordered = true,
    .begin = begin,
    .attach = attach,
    .hear = hear_reply,
    .take = take_character,
    .go_on = go_on,
    .next = next_of_all,
    .changed = changed,
    .durable = durable,
    .pass_wire = dg_bus_characters_pass_wire,
    .pass_place = dg_bus_characters_pass_place,
};

/* --- what only this medium has --- */

void dg_bus_characters_set(struct dg_bus *self, size_t place, const struct dg_characters_end *end)
{
    characters_place_at(self, place)->end = *end;
}

void dg_bus_characters_whole(struct dg_bus *self, void (*whole)(void *ctx, size_t place, dg_ns at,
                                                                const uint8_t *bytes, size_t n))
{
    characters_line_of(self)->setup.whole = whole;
    characters_line_of(self)->setup.paced = false;
}

dg_ns dg_bus_characters_start(struct dg_bus *self, dg_ns at)
{
    dg_bus_run_until(self, at);
    finish_characters(self);
    begin_character(self, self->now);
    return dg_bus_step(self, self->now);
}

struct dg_host_uart dg_bus_characters_uart(const struct dg_bus *self, size_t place)
{
    return characters_place_at(self, place)->uart;
}

bool dg_bus_characters_fits(const struct dg_bus *self, size_t place, uint32_t baud, char parity)
{
    return fits_setting(characters_place_at(self, place), baud, parity);
}

struct dg_characters_counters dg_bus_characters_counters(const struct dg_bus *self)
{
    return characters_line_of(self)->counters;
}
