/* SPDX-License-Identifier: MIT */
/*
 * Faults of the wire behind handles: what a master of BiSS or SSI that clocks edges gets to see of
 * each, how often, and that chance goes by a seed; those of a cycle of INTERBUS.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/shaft.h"
#include "drehgeber/ssi.h"
#include "drehgeber/tap.h"
#include "host_rig.h"

#define US UINT64_C(1000)
#define HALF (US / 2u) /* of a period of the clock, unless a row says otherwise */
#define PAUSE (50u * US)
#define CLOCKS_MAX 1200u

static struct host_rig_place panel_place[2];

struct bench {
    struct dg_host *host;
    struct dg_host_panel *panel;
    uint64_t now;
    uint64_t half;
};

/* Without a life counter frames of a shaft at rest are the same. */
static struct bench begin_with(struct host_rig_place *place, unsigned panel, const char *model,
                               const char *busy_jitter_us)
{
    struct bench self = {.host = host_rig_make(place, model), .now = READY, .half = HALF};

    (void)dg_host_set(self.host, "lc", "0");
    (void)dg_host_set(self.host, "busy_jitter_us", busy_jitter_us);
    assert_int_equal(dg_host_power(self.host, 0, true), DG_HOST_OK);
    dg_host_shaft(self.host, 0, 13 * TURN / 4, 0);
    (void)dg_host_step(self.host, READY);
    self.panel = dg_host_panel_make(&panel_place[panel], sizeof panel_place[panel], self.host);
    assert_non_null(self.panel);
    return self;
}

static struct bench begin(struct host_rig_place *place, unsigned panel, const char *model)
{
    return begin_with(place, panel, model, "0");
}

static void fault(struct bench *self, const char *name, bool on)
{
    assert_int_equal(dg_host_fault_set(self->panel, self->now, name, on), DG_HOST_OK);
}

static const char *scpi(struct bench *self, const char *line)
{
    static char answer[64];

    assert_true(dg_host_scpi(self->panel, self->now, line, answer, sizeof answer) >= 0);
    return answer;
}

/* @return the line behind the rising edge */
static bool clock_once(struct bench *self)
{
    self->now += self->half;
    (void)dg_host_clock(self->host, self->now, false);
    self->now += self->half;
    return dg_host_clock(self->host, self->now, true) > 0;
}

static uint64_t take_frame(struct bench *self, unsigned n)
{
    uint64_t bits = 0;

    while (n-- > 0) {
        bits = bits << 1 | clock_once(self);
    }
    return bits;
}

static void rest_line(struct bench *self)
{
    self->now += PAUSE;
    (void)dg_host_panel_step(self->panel, self->now);
}

/* ------------------------------------------------------------ BiSS */

#define BISS "s3684-biss"

struct biss_frame {
    bool ack;       /* e2 found a low line */
    unsigned start; /* clocks from e2 to the start bit */
    uint64_t bits;
    struct dg_biss_data data;
};

static struct biss_frame read_biss(struct bench *self)
{
    struct dg_biss_model model = *dg_biss_model_of(&dg_s3684_biss);
    struct biss_frame frame = {.start = 1};

    model.life_counter = false;
    assert_true(clock_once(self));
    frame.ack = !clock_once(self);
    while (!clock_once(self)) {
        assert_true(frame.start++ < CLOCKS_MAX);
    }
    (void)take_frame(self, 1); /* CDS */
    frame.bits = take_frame(self, dg_biss_frame_bits(&model));
    dg_biss_frame_decode(&model, frame.bits, &frame.data);
    rest_line(self);
    return frame;
}

static void assert_healthy(struct bench *self, const struct biss_frame *like)
{
    const struct biss_frame frame = read_biss(self);
    uint64_t at;
    uint64_t counts;

    assert_true(frame.ack);
    assert_int_equal(frame.start, like->start);
    assert_true(frame.data.crc_ok);
    assert_int_equal(dg_host_latched(self->host, &at, &counts), DG_HOST_OK);
    assert_int_equal(frame.data.position, counts);
}

/* The encoder itself has sent a frame; the master has seen none. */
static void a_dropped_frame_is_high(void **state)
{
    struct bench self = begin(&host_rig_here, 0, BISS);
    const struct biss_frame healthy = read_biss(&self);
    uint64_t before;
    uint64_t at;
    uint64_t counts;

    (void)state;
    assert_int_equal(dg_host_latched(self.host, &before, &counts), DG_HOST_OK);
    (void)scpi(&self, "FAUL:SET wire_drop,COUN 1");
    assert_int_equal(take_frame(&self, 60), (UINT64_C(1) << 60) - 1u);
    rest_line(&self);
    assert_int_equal(dg_host_latched(self.host, &at, &counts), DG_HOST_OK);
    assert_true(at > before);
    assert_healthy(&self, &healthy);
}

/* 100 us, in whole clocks, at any rate; nothing else is different. */
static void a_late_start_bit_comes_100_us_later(void **state)
{
    static const struct {
        uint64_t half;
        unsigned clocks;
    } rows[] = {{US, 50}, {HALF, 100}, {50, 1000}};
    struct bench self = begin(&host_rig_here, 0, BISS);

    (void)state;
    (void)read_biss(&self);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        self.half = rows[i].half;
        const struct biss_frame healthy = read_biss(&self);
        fault(&self, "wire_delay", true);
        const struct biss_frame late = read_biss(&self);
        assert_true(late.ack);
        assert_int_equal(late.start, healthy.start + rows[i].clocks);
        assert_true(late.data.crc_ok);
        assert_int_equal(late.data.position, healthy.data.position);
        fault(&self, "wire_delay", false);
        assert_healthy(&self, &healthy);
    }
}

static void damage_is_one_bit_and_counted(void **state)
{
    struct bench self = begin(&host_rig_here, 0, BISS);
    const struct biss_frame healthy = read_biss(&self);

    (void)state;
    (void)scpi(&self, "FAUL:SET wire_damage,COUN 3");
    for (unsigned i = 0; i < 3; i++) {
        assert_int_equal(scpi(&self, "FAUL:HAPP? wire_damage")[0], '0' + (int)i);
        const struct biss_frame frame = read_biss(&self);
        const uint64_t flipped = frame.bits ^ healthy.bits;
        assert_true(frame.ack);
        assert_int_equal(frame.start, healthy.start);
        assert_false(frame.data.crc_ok);
        assert_true(flipped != 0 && (flipped & (flipped - 1u)) == 0);
    }
    assert_string_equal(scpi(&self, "FAUL:ACT?"), "\"\"");
    assert_healthy(&self, &healthy);
}

/* It is a state: at once, and between frames. */
static void a_broken_wire_reads_high(void **state)
{
    struct bench self = begin(&host_rig_here, 0, BISS);
    struct dg_host_event event;

    (void)state;
    host_rig_drain(self.host);
    fault(&self, "wire_break", true); /* SLO is low up to the first frame */
    assert_int_equal(dg_host_receive(self.host, &event), 1);
    assert_int_equal(event.at, self.now);
    assert_int_equal(event.data[0], 1);
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(take_frame(&self, 60), (UINT64_C(1) << 60) - 1u);
        rest_line(&self);
    }
    assert_int_equal(dg_host_receive(self.host, &event), 0);
    fault(&self, "wire_break", false);
    const struct biss_frame first = read_biss(&self);
    assert_true(first.ack && first.data.crc_ok);
}

/* A frame that has begun is not bent any more; a frame that is cut short takes its fault with it.
 */
static void a_fault_is_of_whole_frames(void **state)
{
    struct bench self = begin(&host_rig_here, 0, BISS);
    const struct biss_frame healthy = read_biss(&self);

    (void)state;
    assert_true(clock_once(&self));
    (void)scpi(&self, "FAUL:SET wire_drop,COUN 1");
    assert_false(clock_once(&self));
    rest_line(&self);
    assert_int_equal(take_frame(&self, 5), 31);
    rest_line(&self);
    assert_healthy(&self, &healthy);
}

/* Frames of the master inside are read in front of the fault, and are none to it. */
static void own_frames_meet_no_fault(void **state)
{
    struct bench self = begin(&host_rig_here, 0, BISS);
    struct dg_host_frame frame;

    (void)state;
    (void)read_biss(&self);
    (void)scpi(&self, "FAUL:SET wire_damage,COUN 1");
    assert_int_equal(dg_host_frame(self.host, self.now, &frame), DG_HOST_OK);
    assert_int_equal(frame.good, 1);
    self.now = frame.end + PAUSE;
    assert_int_equal(scpi(&self, "FAUL:HAPP? wire_damage")[0], '0');
    assert_false(read_biss(&self).data.crc_ok);
}

/* ------------------------------------------------------------ SSI */

static unsigned word_bits(void)
{
    return dg_ssi_word_bits(dg_ssi_25.model);
}

struct word {
    bool first;    /* line behind the first falling edge */
    uint64_t bits; /* each as it is behind its rising edge */
    bool last;     /* one clock later */
};

static struct word read_ssi(struct bench *self)
{
    struct word word = {0};

    word.first = dg_host_clock(self->host, self->now + 1u, false) > 0;
    word.bits = take_frame(self, word_bits());
    word.last = clock_once(self);
    rest_line(self);
    return word;
}

static void faults_of_an_ssi_line(void **state)
{
    struct bench self = begin(&host_rig_here, 0, "ssi-25");
    const struct word healthy = read_ssi(&self);

    (void)state;
    assert_true(healthy.first && !healthy.last);
    fault(&self, "wire_drop", true);
    struct word word = read_ssi(&self);
    assert_true(!word.first && word.bits == 0 && !word.last);
    assert_int_equal(dg_host_clock(self.host, self.now, true), 1);
    fault(&self, "wire_drop", false);

    fault(&self, "wire_delay", true);
    word = read_ssi(&self);
    assert_true(word.first);
    assert_int_equal(word.bits, healthy.bits >> 1 | UINT64_C(1) << (word_bits() - 1u));
    assert_int_equal(word.last, healthy.bits & 1u);
    fault(&self, "wire_delay", false);

    fault(&self, "wire_damage", true);
    word = read_ssi(&self);
    const uint64_t flipped = word.bits ^ healthy.bits;
    assert_true(flipped != 0 && (flipped & (flipped - 1u)) == 0);
    fault(&self, "wire_damage", false);

    fault(&self, "wire_break", true);
    assert_int_equal(dg_host_clock(self.host, self.now, true), 0);
    word = read_ssi(&self);
    assert_true(!word.first && word.bits == 0 && !word.last);
    assert_int_equal(dg_host_clock(self.host, self.now, true), 0);
    fault(&self, "wire_break", false);
    word = read_ssi(&self);
    assert_true(word.first && word.bits == healthy.bits && !word.last);
}

/* ------------------------------------------------------------ queues, chance */

#define EDGES 120u

/* The edges of a frame, and what came of them. @return how many */
static size_t edges_of(struct bench *self, bool queued, struct dg_host_event *to)
{
    size_t n = 0;

    host_rig_drain(self->host);
    for (unsigned i = 0; i < EDGES; i++) {
        const struct dg_host_event edge = {
            .at = self->now + (i + 1u) * HALF, .kind = DG_HOST_EDGE, .length = 1, .data = {i & 1u}};
        if (queued) {
            assert_int_equal(dg_host_send(self->host, &edge), DG_HOST_OK);
            (void)dg_host_panel_step(self->panel, i % 7u == 0 ? edge.at : self->now);
        } else {
            assert_true(dg_host_clock(self->host, edge.at, (i & 1u) != 0) >= 0);
        }
    }
    self->now += (EDGES + 1u) * HALF;
    rest_line(self);
    while (dg_host_receive(self->host, &to[n]) == 1) {
        n++;
    }
    return n;
}

static void edges_of_the_queue_are_bent_likewise(void **state)
{
    static const char *const faults[] = {"wire_drop", "wire_delay", "wire_damage", "wire_break"};
    static const char *const models[] = {BISS, "ssi-25"};
    struct dg_host_event clocked[DG_HOST_QUEUE];
    struct dg_host_event queued[DG_HOST_QUEUE];

    (void)state;
    for (size_t i = 0; i < 8; i++) {
        struct bench one = begin(&host_rig_here, 0, models[i / 4u]);
        struct bench two = begin(&host_rig_there, 1, models[i / 4u]);
        fault(&one, faults[i % 4u], true);
        fault(&two, faults[i % 4u], true);
        const size_t n = edges_of(&one, false, clocked);
        assert_int_equal(edges_of(&two, true, queued), n);
        assert_memory_equal(clocked, queued, n * sizeof queued[0]);
    }
}

/* Which bits are damaged, and when start bits come. */
static uint64_t chance_of(struct bench *self, uint32_t seed)
{
    uint64_t sum = 0;

    dg_host_panel_seed(self->panel, seed);
    fault(self, "wire_damage", true);
    for (unsigned i = 0; i < 8; i++) {
        const struct biss_frame frame = read_biss(self);
        sum = sum * 31u + frame.bits;
        sum = sum * 31u + frame.start;
    }
    fault(self, "wire_damage", false);
    return sum;
}

/* Of jitter alone: no bit says so. */
static unsigned starts_of(struct bench *self, uint32_t seed)
{
    unsigned sum = 0;

    dg_host_panel_seed(self->panel, seed);
    for (unsigned i = 0; i < 6; i++) {
        sum = sum * 20u + read_biss(self).start;
    }
    return sum;
}

static void chance_goes_by_the_seed(void **state)
{
    struct bench self = begin_with(&host_rig_here, 0, BISS, "15");

    (void)state;
    const uint64_t chance = chance_of(&self, 7);
    assert_true(chance_of(&self, 8) != chance);
    assert_true(chance_of(&self, 7) == chance);
    const unsigned starts = starts_of(&self, 7);
    assert_true(starts_of(&self, 8) != starts);
    assert_int_equal(starts_of(&self, 7), starts);
}

/* ------------------------------------------------------------ INTERBUS */

/* A data cycle with the shaft at `angle`. @return events that came back */
static int cycle(struct bench *self, int64_t angle, struct dg_host_event *event)
{
    const struct dg_host_event data = {.at = self->now + MS, .kind = DG_HOST_WORDS};

    (void)dg_shaft_set_position(dg_host_panel_shaft(self->panel), self->now, angle);
    self->now += MS;
    assert_int_equal(dg_host_send(self->host, &data), DG_HOST_OK);
    (void)dg_host_panel_step(self->panel, self->now);
    return dg_host_receive(self->host, event);
}

static void in_words_are_torn(void **state)
{
    static const char *const models[] = {"ocd-ib-k1", "ocd-ib-k2", "ocd-ib-k3"};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(models); i++) {
        struct bench self = begin(&host_rig_here, 0, models[i]);
        struct dg_host_event old;
        struct dg_host_event now;
        struct dg_host_event torn;
        assert_int_equal(cycle(&self, 3 * TURN / 7 + 2 * TURN, &old), 1);
        assert_int_equal(cycle(&self, 900 * TURN + TURN / 5, &now), 1);
        assert_int_equal(cycle(&self, 3 * TURN / 7 + 2 * TURN, &old), 1);
        (void)scpi(&self, "FAUL:SET wire_tear,COUN 1");
        assert_int_equal(cycle(&self, 900 * TURN + TURN / 5, &torn), 1);
        const size_t half = now.length / 2u;
        assert_memory_not_equal(old.data, now.data, half);
        assert_memory_equal(torn.data, old.data, half);
        assert_memory_equal(torn.data + half, now.data + half, half);
        uint32_t id = 0;
        for (uint8_t n = 0; n < torn.length; n++) {
            id = id << 8 | torn.data[n];
        }
        assert_int_equal(torn.id, id);
        assert_int_equal(cycle(&self, 900 * TURN + TURN / 5, &torn), 1);
        assert_memory_equal(torn.data, now.data, sizeof now.data);
    }
}

static void a_cut_bus_brings_nothing_back(void **state)
{
    struct bench self = begin(&host_rig_here, 0, "ocd-ib-k3");
    struct dg_host_event event;

    (void)state;
    assert_int_equal(cycle(&self, TURN, &event), 1);
    fault(&self, "wire_break", true);
    assert_int_equal(cycle(&self, TURN, &event), 0);
    assert_int_equal(cycle(&self, TURN, &event), 0);
    fault(&self, "wire_break", false);
    assert_int_equal(cycle(&self, TURN, &event), 1);
}

/* The ID word that comes back. */
static uint32_t identify(struct bench *self)
{
    const struct dg_host_event cycle = {
        .at = self->now, .kind = DG_HOST_WORDS, .flags = DG_HOST_IDENTIFY};
    struct dg_host_event back;

    assert_int_equal(dg_host_send(self->host, &cycle), DG_HOST_OK);
    (void)dg_host_panel_step(self->panel, self->now);
    assert_int_equal(dg_host_receive(self->host, &back), 1);
    return back.id;
}

/* As in a ring: no data in the cycle and in five more, and the encoder says so to the next ID
 * cycle.
 */
static void a_damaged_cycle_is_a_transmission_error(void **state)
{
    struct bench self = begin(&host_rig_here, 0, "ocd-ib-k3");
    struct dg_host_event event;

    (void)state;
    assert_int_equal(identify(&self) & 0x4000u, 0);
    (void)scpi(&self, "FAUL:SET wire_damage,COUN 1");
    for (unsigned i = 0; i < 1 + DG_RING_DEAD_CYCLES; i++) {
        assert_int_equal(cycle(&self, TURN, &event), 0);
    }
    assert_int_equal(cycle(&self, TURN, &event), 1);
    assert_int_equal(identify(&self) & 0x4000u, 0x4000u);
    assert_int_equal(identify(&self) & 0x4000u, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_dropped_frame_is_high),
        cmocka_unit_test(a_late_start_bit_comes_100_us_later),
        cmocka_unit_test(damage_is_one_bit_and_counted),
        cmocka_unit_test(a_broken_wire_reads_high),
        cmocka_unit_test(a_fault_is_of_whole_frames),
        cmocka_unit_test(own_frames_meet_no_fault),
        cmocka_unit_test(faults_of_an_ssi_line),
        cmocka_unit_test(edges_of_the_queue_are_bent_likewise),
        cmocka_unit_test(chance_goes_by_the_seed),
        cmocka_unit_test(in_words_are_torn),
        cmocka_unit_test(a_cut_bus_brings_nothing_back),
        cmocka_unit_test(a_damaged_cycle_is_a_transmission_error),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
