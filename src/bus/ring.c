/* SPDX-License-Identifier: MIT */
/*
 * A ring: one shift register through all encoders, each with a window by its place. What becomes of
 * a cycle is modelled: loop-back, check sequence, breaks, dead cycles; who is held back or torn.
 *
 *   data cycle -- faults: dropped, or a transmission error somewhere?
 *              -- whole? identified? -- no --> ID cycle, if the master does that
 *              -- transmission error? dead?
 *              -- each: OUT --> exchange --> IN -- held back? torn? --> image
 *              -- tap: a note when something is new, then the words
 */
#include <string.h>

#include "bus_tape.h"
#include "drehgeber/text.h"
#include "ring_private.h"

#define NOTE_MAX 80u
#define BITS_PER_WORD 16u

/* ------------------------------------------------------------ faults of the wire */

/* Whether a data cycle comes next that a transmission error could end. */
static bool is_data_next(const struct ring *ring)
{
    return ring->configured && ring->dead == 0 && ring->spoil_at == DG_RING_WHOLE;
}

/* What faults do to the cycle to come, which may be an ID cycle. @return false: it does not take
 * place */
static bool prepare_cycle(struct dg_bus *self, bool data)
{
    struct ring *ring = ring_of(self);

    ring->bent = false;
    for (size_t i = 0; i < self->count; i++) {
        struct dg_faults *faults = faults_of(member_at(self, i));
        if (faults == NULL || faults->wire == 0) {
            continue;
        }
        ring->bent = true;
        if (dg_fault_wire_takes(faults, DG_WIRE_DROP)) {
            return false;
        }
        if (data && is_data_next(ring) && dg_fault_wire_takes(faults, DG_WIRE_DAMAGE)) {
            ring->spoil_at = (uint16_t)i;
        }
    }
    return true;
}

/* ------------------------------------------------------------ cycles */

static bool is_cut_before(const struct dg_bus *self, size_t index)
{
    const struct member *member = member_at(self, index);
    const struct dg_faults *faults = faults_of(member);
    const struct dg_stack *stack = dg_host_wire_at(member->place.host)->stack;

    return index == ring_of(self)->cut_at || !stack->powered(member->line->device) ||
           (faults != NULL && dg_fault_wire_active(faults, DG_WIRE_BREAK));
}

/* Encoders before the first break; one without power is a break. */
static uint16_t count_reachable(const struct dg_bus *self)
{
    size_t n = 0;

    while (n < self->count && !is_cut_before(self, n)) {
        n++;
    }
    return (uint16_t)n;
}

/* An encoder that was switched on again takes part only after an ID cycle. */
static bool are_all_identified(const struct dg_bus *self)
{
    for (size_t i = 0; i < self->count; i++) {
        const struct member *member = member_at(self, i);
        if (!member->ops->identified(member->line)) {
            return false;
        }
    }
    return ring_of(self)->configured;
}

static void run_id_cycle(struct dg_bus *self)
{
    struct ring *ring = ring_of(self);
    const uint16_t reached = count_reachable(self);

    for (uint16_t i = 0; i < reached; i++) {
        struct member *member = member_at(self, i);
        const bool last = reached < self->count && i + 1u == reached;
        member->id = member->ops->identify(member->line, self->now, last);
    }
    ring->configured = reached == self->count;
    ring->is.reached = reached;
    ring->is.counters.ids++;
}

static enum dg_ring_result interrupt_ring(struct ring *ring)
{
    ring->configured = false;
    ring->dead = 0;
    ring->is.counters.interrupted++;
    return DG_RING_INTERRUPTED;
}

static enum dg_ring_result spoil_cycle(struct dg_bus *self)
{
    struct ring *ring = ring_of(self);
    struct member *member = member_at(self, ring->spoil_at);

    member->ops->spoil(member->line);
    ring->spoil_at = DG_RING_WHOLE;
    ring->dead = DG_RING_DEAD_CYCLES;
    ring->is.counters.crc_errors++;
    return DG_RING_CRC;
}

/* What becomes of a data cycle. */
static enum dg_ring_result judge_cycle(struct dg_bus *self)
{
    struct ring *ring = ring_of(self);

    ring->is.counters.cycles++;
    if (count_reachable(self) < self->count) {
        return interrupt_ring(ring);
    }
    if (!are_all_identified(self)) {
        return DG_RING_IDENTIFY;
    }
    if (ring->spoil_at < self->count) {
        return spoil_cycle(self);
    }
    if (ring->dead > 0) {
        ring->dead--;
        ring->is.counters.dead++;
        return DG_RING_DEAD;
    }
    dg_bus_ring_decide_to_bend(self);
    ring->steady = !ring->bent;
    return DG_RING_OK;
}

/* Faults come and go by themselves; all else is told. @return whether words move in it */
static bool begin_cycle(struct dg_bus *self, bool data)
{
    struct ring *ring = ring_of(self);

    if (ring->steady && data) {
        ring->is.counters.cycles++;
        return true;
    }
    ring->steady = false;
    ring->id_only = !data;
    ring->is.dropped = !prepare_cycle(self, data);
    if (ring->is.dropped) {
        return false;
    }
    if (data) {
        ring->is.result = judge_cycle(self);
    }
    const bool anew = ring->setup.identifies && (ring->is.result == DG_RING_INTERRUPTED ||
                                                 ring->is.result == DG_RING_IDENTIFY);
    if (!data || anew) {
        run_id_cycle(self);
    }
    return data && ring->is.result == DG_RING_OK;
}

static void exchange_words(const struct dg_bus *self, const uint16_t *out)
{
    const struct ring *ring = ring_of(self);
    uint16_t *in = ring->setup.in;

    for (size_t i = 0; i < self->count; i++) {
        const struct member *member = member_at(self, i);
        const bool one = member->words == 1;
        const uint32_t word = member->ops->exchange(
            member->line, self->now, one ? *out : (uint32_t)out[0] << BITS_PER_WORD | out[1]);
        in[0] = (uint16_t)(word >> BITS_PER_WORD);
        in[member->words - 1u] = (uint16_t)word; /* of one word, all of it */
        in += member->words;
        out += member->words;
    }
}

/* ------------------------------------------------------------ what is told */

/* ID cycles, breaks and errors, once each: a broken ring may be identified again in every cycle.
 * @return whether there is something to say */
static bool describe_state(const struct dg_bus *self, struct dg_text *text)
{
    const struct dg_ring_state *is = &ring_of(self)->is;
    const bool whole = is->reached >= self->count;

    if (is->result == DG_RING_CRC) {
        dg_text_add(text, "transmission error");
        return true;
    }
    if (whole && is->result != DG_RING_IDENTIFY) {
        return false;
    }
    dg_text_add(text, "ID cycle: ");
    dg_text_add_number(text, is->reached);
    dg_text_add(text, " of ");
    dg_text_add_number(text, (int64_t)self->count);
    dg_text_add(text, " devices");
    if (!whole) {
        dg_text_add(text, ", interrupted before device ");
        dg_text_add_number(text, is->reached);
    }
    return true;
}

static void tell_state(struct dg_bus *self)
{
    struct ring *ring = ring_of(self);
    char note[NOTE_MAX];
    struct dg_text text = dg_text_in(note, sizeof note);
    struct dg_tap_event event = {.at = self->now, .kind = DG_TAP_NOTE, .note = note};

    if (ring->is.result == ring->told && ring->is.reached == ring->told_reached) {
        return;
    }
    ring->told = ring->is.result;
    ring->told_reached = ring->is.reached;
    if (describe_state(self, &text)) {
        const bool whole = ring->is.result != DG_RING_CRC && ring->is.reached >= self->count;
        event.severity = whole ? DG_SEVERITY_NOTICE : DG_SEVERITY_ERROR;
        self->ops->tap(self->ctx, &event);
    }
}

static void tell_cycle(struct dg_bus *self, const struct dg_tap_event *asked)
{
    const struct ring *ring = ring_of(self);
    struct dg_tap_event event = *asked;
    uint8_t widths[DG_RING_MAX];

    tell_state(self);
    /* With an ID cycle there may be no OUT image, or one that is too short: nothing to show. */
    if (event.words.out == NULL || event.words.count != ring->is.words) {
        return;
    }
    for (size_t i = 0; i < self->count; i++) {
        widths[i] = member_at(self, i)->words;
    }
    event.at = self->now;
    event.words.widths = widths;
    event.words.in = ring->setup.in;
    event.words.count = ring->is.words;
    event.words.valid =
        !asked->words.identify && !ring->is.dropped && ring->is.result == DG_RING_OK;
    self->ops->tap(self->ctx, &event);
}

/* ------------------------------------------------------------ as a medium */

static int begin(struct dg_bus *self, const void *setup)
{
    const struct dg_bus_words_setup *given = setup;
    struct ring *ring = ring_of(self);

    if (given == NULL || given->size != sizeof *given || given->in == NULL ||
        (self->ops->ticket != NULL && self->ops->answer == NULL)) {
        return DG_ERR_ARGUMENT;
    }
    *ring = (struct ring){
        .setup = *given,
        .is = {.result = DG_RING_IDENTIFY},
        .cut_at = DG_RING_WHOLE,
        .spoil_at = DG_RING_WHOLE,
    };
    return DG_OK;
}

static int attach(struct bus_place *place)
{
    struct member *self = (struct member *)(void *)place;
    struct ring *ring = ring_of(place->bus);

    self->ops = dg_host_side_at(place->host)->ring;
    self->line = dg_host_line_of(place->host);
    self->words = self->ops->words(self->line);
    self->at = ring->is.words;
    if (self->at + (size_t)self->words > ring->setup.words) {
        return DG_ERR_SPACE;
    }
    ring->is.words = (uint16_t)(ring->is.words + self->words);
    ring->configured = false;
    ring->steady = false;
    ring->timed = place->index + 1u;
    return DG_OK;
}

/* The ring asks; an encoder says nothing by itself. */
static void hear_words(struct bus_place *from, const struct dg_host_event *event)
{
    (void)from;
    (void)event;
}

static void step_encoders(struct dg_bus *self, dg_ns now)
{
    struct ring *ring = ring_of(self);
    size_t timed = 0;

    for (size_t i = 0; i < ring->timed; i++) {
        struct bus_place *place = dg_bus_place_at(self, i);
        if (place->deadline <= now) {
            place->deadline = dg_host_step(place->host, now);
        }
        timed = place->deadline != DG_NEVER ? i + 1u : timed;
    }
    ring->timed = timed;
}

/* Many have no deadlines: they do everything in cycles. None hears of another one in between. */
static void go_on(struct dg_bus *self, dg_ns now)
{
    if (ring_of(self)->timed != 0) {
        step_encoders(self, now);
    }
}

static void take_cycle(struct dg_bus *self, const struct dg_tap_event *event)
{
    struct ring *ring = ring_of(self);
    const bool data = !event->words.identify;

    if (event->kind != DG_TAP_WORDS || (data && event->words.count != ring->is.words)) {
        return;
    }
    if (ring->timed != 0) {
        step_encoders(self, dg_elapsed(self->now, 1));
    }
    if (begin_cycle(self, data)) {
        exchange_words(self, event->words.out);
        if (ring->keeps) {
            dg_bus_ring_bend_words(self, event->words.out);
        }
    }
    if (self->watched) {
        tell_cycle(self, event);
    }
}

static dg_ns next(const struct dg_bus *self)
{
    dg_ns next = DG_NEVER;

    for (size_t i = 0; i < ring_of(self)->timed; i++) {
        next = dg_earliest(next, dg_bus_place_at(self, i)->deadline);
    }
    return next;
}

/* Power, worlds and faults are looked at in the next cycle. */
static void changed(struct bus_place *place, dg_ns now)
{
    struct ring *ring = ring_of(place->bus);

    (void)now;
    ring->steady = false;
    ring->timed = place->bus->count;
}

/* ------------------------------------------------------------ states */

static const struct bus_member ring_rows[] = {
    BUS_MEMBER(ring, is.result, DG_RING_IDENTIFY),
    BUS_BOOL(ring, is.dropped),
    BUS_MEMBER(ring, is.reached, DG_RING_MAX),
    BUS_ANY(ring, is.counters),
    BUS_ANY(ring, cut_at),
    BUS_ANY(ring, spoil_at),
    BUS_MEMBER(ring, dead, DG_RING_DEAD_CYCLES),
    BUS_BOOL(ring, configured),
    BUS_BOOL(ring, id_only),
    BUS_BOOL(ring, keeps),
    BUS_MEMBER(ring, told, DG_RING_IDENTIFY),
    BUS_ANY(ring, told_reached),
};

static const struct bus_member member_rows[] = {
    BUS_ANY(member, id),           BUS_ANY(member, whole),       BUS_ANY(member, held.settled),
    BUS_ANY(member, held.looked),  BUS_BOOL(member, held.holds), BUS_ANY(member, held.shown),
    BUS_ANY(member, held.command),
};

/* Both images have as many words as the encoders have; IN is the host's memory. */
static void pass_wire(const struct dg_bus *self, struct bus_tape *tape)
{
    static const struct bus_member word = {0, sizeof(uint16_t), UINT32_MAX};
    struct ring *ring = ring_of(self);
    const size_t words = dg_bus_tape_length(tape, ring->is.words, ring->is.words);

    dg_bus_tape_expect(tape, words == ring->is.words);
    dg_bus_tape_members(tape, ring_rows, DG_COUNT(ring_rows), ring, dg_bus_tape_into(tape, ring));
    for (size_t i = 0; i < words; i++) {
        uint16_t *in = &ring->setup.in[i];
        dg_bus_tape_members(tape, &word, 1, in, dg_bus_tape_into(tape, in));
    }
}

static void pass_place(struct bus_place *place, struct bus_tape *tape)
{
    const dg_ns deadline = dg_bus_tape_deadline(tape, place);

    dg_bus_tape_members(tape, member_rows, DG_COUNT(member_rows), place,
                        dg_bus_tape_into(tape, place));
    if (tape->way == BUS_TAPE_RESTORE) {
        place->deadline = deadline;
    }
}

/* All is looked at in the next cycle. */
static void restored(struct dg_bus *self)
{
    ring_of(self)->steady = false;
    ring_of(self)->timed = self->count;
}

/* ------------------------------------------------------------ an encoder leaves */

/* Its words leave both images. */
static void detach(struct bus_place *place)
{
    const struct member *self = (struct member *)(void *)place;
    struct ring *ring = ring_of(place->bus);
    uint16_t *in = ring->setup.in + self->at;
    const size_t behind = (size_t)ring->is.words - self->at - self->words;

    memmove(in, in + self->words, behind * sizeof *in);
    memset(in + behind, 0, self->words * sizeof *in);
    ring->is.words = (uint16_t)(ring->is.words - self->words);
}

/* What was to happen before an encoder, or at it, stays with it; a cut stays where it was. */
static void moved(struct dg_bus *self, size_t from)
{
    struct ring *ring = ring_of(self);

    for (size_t i = from; i < self->count; i++) {
        struct member *member = member_at(self, i);
        member->at =
            i == 0 ? 0 : (uint16_t)(member_at(self, i - 1u)->at + member_at(self, i - 1u)->words);
    }
    if (ring->cut_at != DG_RING_WHOLE && ring->cut_at > from) {
        ring->cut_at--;
    }
    if (ring->spoil_at == from) {
        ring->spoil_at = DG_RING_WHOLE;
    } else if (ring->spoil_at != DG_RING_WHOLE && ring->spoil_at > from) {
        ring->spoil_at--;
    }
    ring->configured = false;
    ring->steady = false;
    ring->timed = self->count;
}

const struct dg_bus_medium dg_bus_words = {
    .medium = DG_MEDIUM_WORDS,
    .wire_size = sizeof(struct ring),
    .place_size = sizeof(struct member),
    .encoders_most = DG_RING_MAX,
    .ordered = true,
    .is_read = true,
    .begin = begin,
    .attach = attach,
    .hear = hear_words,
    .take = take_cycle,
    .go_on = go_on,
    .next = next,
    .changed = changed,
    .pass_wire = pass_wire,
    .pass_place = pass_place,
    .restored = restored,
    .detach = detach,
    .moved = moved,
};

/* ------------------------------------------------------------ of a ring only */

const struct dg_ring_state *dg_ring_state(const struct dg_bus *self)
{
    return &ring_of(self)->is;
}

uint16_t dg_ring_id_word(const struct dg_bus *self, size_t place)
{
    return member_at(self, place)->id;
}

void dg_ring_cut(struct dg_bus *self, uint16_t place)
{
    ring_of(self)->cut_at = place;
    ring_of(self)->steady = false;
}

void dg_ring_spoil(struct dg_bus *self, uint16_t place)
{
    ring_of(self)->spoil_at = place;
    ring_of(self)->steady = false;
}

/*
 * With the same OUT as before, a cycle only counts and latches, unless
 *
 *   a command waits, or something is stored    the encoder knows
 *   the ring recovers                          ID cycle, dead cycles
 *   a fault may happen to it                   or be over
 */
dg_ns dg_ring_quiet(const struct dg_bus *self)
{
    const struct ring *ring = ring_of(self);
    dg_ns until = DG_NEVER;

    if (ring->id_only || ring->is.result == DG_RING_INTERRUPTED) {
        return dg_bus_is_bent(self) ? self->now : DG_NEVER;
    }
    if (ring->is.result != DG_RING_OK || dg_bus_is_bent(self)) {
        return self->now;
    }
    for (size_t i = 0; i < self->count; i++) {
        const struct member *member = member_at(self, i);
        until = dg_earliest(until, member->ops->quiet(member->line, self->now));
    }
    return until;
}

void dg_ring_skip(struct dg_bus *self, uint32_t cycles)
{
    struct ring *ring = ring_of(self);
    const bool interrupted = !ring->id_only && ring->is.result == DG_RING_INTERRUPTED;

    ring->is.counters.cycles += ring->id_only ? 0 : cycles;
    ring->is.counters.interrupted += interrupted ? cycles : 0;
    if (ring->id_only || (interrupted && ring->setup.identifies)) {
        ring->is.counters.ids += cycles;
    }
    if (ring->id_only || interrupted) {
        return;
    }
    for (size_t i = 0; i < self->count; i++) {
        const struct member *member = member_at(self, i);
        member->ops->skip(member->line, cycles);
    }
}
