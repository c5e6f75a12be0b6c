/* SPDX-License-Identifier: MIT */
#include "bus_scenes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bus_characters.h"
#include "drehgeber/bus_edges.h"
#include "drehgeber/bus_words.h"
#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"

struct bus_told bus_told[BUS_SCENE_TOLD_MAX];
size_t bus_told_count;

/* So many deadlines in a row, and time stands. */
#define STEPS_MAX 1000000u

/* A number below `n` that depends on nothing but these two. */
static uint32_t pick(unsigned i, unsigned which, uint32_t n)
{
    uint32_t x = (i + 1u) * 2654435761u + which * 40503u;

    x ^= x >> 15;
    x *= 2246822519u;
    x ^= x >> 13;
    x *= 3266489917u;
    return (x ^ x >> 16) % n;
}

/* ------------------------------------------------------------ what is told */

static void keep(const struct bus_told *told)
{
    assert_true(bus_told_count < BUS_SCENE_TOLD_MAX);
    bus_told[bus_told_count++] = *told;
}

static void describe(struct bus_told *told, const struct dg_tap_event *event)
{
    if (event->kind == DG_TAP_CHARACTER) {
        told->what[2] = event->character.baud;
        told->what[3] = event->character.byte * 2u + (event->character.damaged ? 1u : 0u);
        told->bytes[0] = (uint8_t)event->character.parity;
    } else if (event->kind == DG_TAP_FRAME) {
        told->what[2] = event->frame.id;
        told->what[3] = (event->frame.rtr ? 16u : 0u) + event->frame.dlc;
        memcpy(told->bytes, event->frame.data, sizeof told->bytes);
    } else if (event->kind == DG_TAP_LEVELS) {
        told->what[2] = (event->levels.clock ? 2u : 0u) + (event->levels.data ? 1u : 0u);
    } else if (event->kind == DG_TAP_WORDS) {
        told->what[2] = (event->words.valid ? 2u : 0u) + (event->words.identify ? 1u : 0u);
        told->what[3] = event->words.count;
        memcpy(told->bytes, event->words.in, sizeof told->bytes);
    } else {
        memcpy(told->bytes, event->note, sizeof told->bytes);
    }
}

static void keep_event(uint32_t mark, size_t place, const struct dg_tap_event *event)
{
    struct bus_told told = {
        .at = event->at,
        .what = {mark + event->kind * 2u + (event->ours ? 1u : 0u), (uint32_t)place}};

    describe(&told, event);
    keep(&told);
}

static void tx(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    keep_event(0x100, place, event);
}

static void tap(void *ctx, const struct dg_tap_event *event)
{
    (void)ctx;
    keep_event(0, 0, event);
}

static enum dg_bus_answer answer(void *ctx, size_t place)
{
    const struct bus_world *world = ctx;

    return place == 0 ? world->answer : DG_BUS_SAY;
}

static uint64_t ticket(void *ctx, size_t place)
{
    const struct bus_world *world = ctx;

    return place == 0 ? world->ticket : 0;
}

static const struct dg_bus_ops ops = {.tx = tx, .tap = tap, .answer = answer, .ticket = ticket};

/* ------------------------------------------------------------ worlds */

static void add_encoder(const struct bus_scene *scene, struct bus_world *world, size_t i)
{
    const struct dg_device *model = dg_device_find(scene->models[i]);
    struct dg_host *host = dg_host_init_on_bus(&world->places[i], sizeof world->places[i], model,
                                               dg_bus_side_of(model));

    assert_non_null(host);
    world->hosts[i] = host;
    scene->set(i, host);
    world->control[i] = (struct dg_encoder){.name = "e",
                                            .model = model,
                                            .instrument = dg_instrument_of(model->stack),
                                            .device = dg_host_line_of(host)->device,
                                            .world = dg_host_world(host),
                                            .faults.random = 1};
    assert_int_equal(dg_bus_attach(world->bus, host, &world->control[i]), (int)i);
}

static const void *wire_of(const struct bus_scene *scene, struct bus_world *world)
{
    static struct dg_bus_frames_setup frames;
    static struct dg_bus_words_setup words;

    if (scene->medium == &dg_bus_frames) {
        frames = *(const struct dg_bus_frames_setup *)scene->wire;
        frames.room = world->rooms;
        frames.rooms = BUS_SCENE_ROOMS;
        return &frames;
    }
    if (scene->medium == &dg_bus_words) {
        words = *(const struct dg_bus_words_setup *)scene->wire;
        words.in = world->in;
        words.words = BUS_SCENE_WORDS;
        return &words;
    }
    return scene->wire;
}

void bus_scene_make(const struct bus_scene *scene, struct bus_world *world)
{
    memset(world, 0xA5, sizeof *world);
    memset(world->in, 0, sizeof world->in);
    world->answer = DG_BUS_SAY;
    world->ticket = 0;
    world->now = 0;
    const struct dg_bus_setup setup = {.size = sizeof setup,
                                       .medium = scene->medium,
                                       .encoders = BUS_SCENE_ENCODERS,
                                       .wire = wire_of(scene, world),
                                       .ops = &ops,
                                       .ctx = world};
    world->bus = dg_bus_init(world->memory, sizeof world->memory, &setup);
    assert_non_null(world->bus);
    for (size_t i = 0; i < BUS_SCENE_ENCODERS && scene->models[i] != NULL; i++) {
        add_encoder(scene, world, i);
    }
    bus_told_count = 0;
}

void bus_scene_begin(const struct bus_scene *scene, struct bus_world *world)
{
    bus_scene_make(scene, world);
    for (size_t i = 0; i < dg_bus_count(world->bus); i++) {
        assert_int_equal(dg_host_power(world->hosts[i], 0, true), DG_HOST_OK);
        (void)dg_bus_changed(world->bus, i, 0);
    }
    bus_scene_pass_to(world, READY);
}

dg_ns bus_scene_moment(const struct bus_scene *scene, unsigned i)
{
    dg_ns at = READY;

    for (unsigned n = 0; n <= i; n++) {
        at += scene->least + pick(n, 0, scene->more);
    }
    return at;
}

void bus_scene_pass_to(struct bus_world *world, dg_ns until)
{
    dg_ns next = dg_bus_next(world->bus);

    for (unsigned steps = 0; next <= until && next != DG_NEVER; steps++) {
        assert_true(steps < STEPS_MAX);
        next = dg_bus_step(world->bus, next);
    }
    (void)dg_bus_step(world->bus, until);
    world->now = until;
}

static void look_at_places(const struct bus_scene *scene, const struct bus_world *world)
{
    struct bus_told told = {.at = dg_bus_next(world->bus), .what = {0x1000}};

    keep(&told);
    for (size_t i = 0; i < dg_bus_count(world->bus); i++) {
        told = (struct bus_told){.what = {0x1001, (uint32_t)i}};
        scene->look(world, i, &told);
        keep(&told);
    }
}

void bus_scene_play(const struct bus_scene *scene, struct bus_world *world, unsigned from,
                    unsigned to)
{
    for (unsigned i = from; i < to; i++) {
        bus_scene_pass_to(world, bus_scene_moment(scene, i));
        look_at_places(scene, world);
        scene->perform(world, i);
    }
}

/* ------------------------------------------------------------ what may happen to each of them */

static void switch_power(struct bus_world *world, size_t place, bool on)
{
    assert_int_equal(dg_host_power(world->hosts[place], world->now, on), DG_HOST_OK);
    (void)dg_bus_changed(world->bus, place, world->now);
}

static void set_wire_fault(struct bus_world *world, size_t place, enum dg_wire_fault fault,
                           uint32_t count)
{
    struct dg_faults *faults = &world->control[place].faults;

    faults->wire |= 1u << fault;
    faults->slot[fault] = (uint8_t)fault;
    faults->fault[fault] = (struct dg_fault){
        .active = true, .left = count, .probability_ppm = 1000000, .until = DG_NEVER};
    (void)dg_bus_changed(world->bus, place, world->now);
}

/* The memory has all it was handed, or has lost it. */
static void settle_memory(struct bus_world *world, enum dg_bus_answer said)
{
    world->answer = said;
    (void)dg_bus_durable(world->bus, 0, world->now);
    world->answer = DG_BUS_SAY;
}

static void disturb(struct bus_world *world, unsigned i, const enum dg_wire_fault faults[4])
{
    const size_t place = pick(i, 2, (uint32_t)dg_bus_count(world->bus));

    switch (pick(i, 3, 16)) {
    case 0:
        switch_power(world, place, false);
        break;
    case 1:
    case 2:
    case 3:
        switch_power(world, place, true);
        break;
    case 4:
    case 5:
    case 6:
        world->answer = DG_BUS_KEEP;
        world->ticket++;
        break;
    case 7:
    case 8:
    case 9:
        settle_memory(world, pick(i, 4, 4) == 0 ? DG_BUS_DROP : DG_BUS_SAY);
        break;
    default:
        set_wire_fault(world, place, faults[pick(i, 4, 4)], 1u + pick(i, 5, 3));
        break;
    }
}

/* ------------------------------------------------------------ characters */

/* The third one has the address of the first. */
static void set_character_encoder(size_t place, struct dg_host *host)
{
    static const char *const addresses[] = {"0x40", "0x41", "0x40"};

    (void)dg_host_set(host, "address", addresses[place]);
    dg_host_shaft(host, 0, (int64_t)(place + 1u) * TURN / 7, TURN / 3);
}

static void say_characters(struct bus_world *world, unsigned i)
{
    static const uint8_t requests[][6] = {
        {3, 0x40, 0x42, 0x02}, {3, 0x41, 0x42, 0x03}, {3, 0x40, 0x53, 0x13},
        {3, 0x40, 0x52, 0x12}, {3, 0x41, 0x56, 0x17}, {5, 0x41, 0x57, 0xE5, 0x55, 0xA6},
        {3, 0xFF, 0x52, 0xAD}, {2, 0x40, 0x42},
    };
    const uint8_t *request = requests[pick(i, 6, DG_COUNT(requests))];

    for (uint8_t n = 1; n <= request[0]; n++) {
        const struct dg_tap_event event = {.at = world->now,
                                           .kind = DG_TAP_CHARACTER,
                                           .character = {9600, 'E', request[n], false}};
        (void)dg_bus_rx(world->bus, &event);
    }
}

/* More than can be on its way at once; some of it is damaged. */
static void flood_line(struct bus_world *world, unsigned i)
{
    for (uint32_t n = 0; n < 280; n++) {
        const struct dg_tap_event event = {
            .at = world->now,
            .kind = DG_TAP_CHARACTER,
            .character = {9600, n % 3u == 0 ? 'O' : 'E', (uint8_t)pick(i, n, 256), n % 5u == 0}};
        (void)dg_bus_rx(world->bus, &event);
    }
}

static void perform_characters(struct bus_world *world, unsigned i)
{
    static const enum dg_wire_fault faults[4] = {DG_WIRE_DELAY, DG_WIRE_DUPLICATE, DG_WIRE_DAMAGE,
                                                 DG_WIRE_DEAF};

    if (pick(i, 1, 4) == 0) {
        disturb(world, i, faults);
    } else if (pick(i, 1, 80) == 5) {
        flood_line(world, i);
    } else {
        say_characters(world, i);
    }
}

/* Whoever plays the line is late now and then. */
static void perform_late(struct bus_world *world, unsigned i)
{
    perform_characters(world, i);
    if (pick(i, 13, 5) == 0) {
        world->now += 15 * MS;
        (void)dg_bus_step(world->bus, world->now);
    }
}

/* A master whose start bits are seen, and whose characters come as they are over. */
static void perform_plain(struct bus_world *world, unsigned i)
{
    if (pick(i, 1, 4) == 1) {
        (void)dg_bus_characters_start(world->bus, world->now);
    } else {
        perform_characters(world, i);
    }
}

static void look_at_characters(const struct bus_world *world, size_t i, struct bus_told *told)
{
    const struct dg_host_uart uart = dg_bus_characters_uart(world->bus, i);
    const struct dg_characters_counters counted = dg_bus_characters_counters(world->bus);

    told->at = uart.baud;
    told->what[2] = (uint32_t)counted.collided;
    told->what[3] = (uint32_t)counted.overrun;
    told->bytes[0] = uart.parity;
    told->bytes[1] = uart.timeout_bits;
    told->bytes[2] = (uint8_t)counted.late;
}

/* Whoever has a port that does the timing is told replies. */
static void keep_whole(void *ctx, size_t place, dg_ns at, const uint8_t *bytes, size_t n)
{
    struct bus_told told = {.at = at, .what = {0x200, (uint32_t)place, (uint32_t)n}};

    (void)ctx;
    memcpy(told.bytes, bytes, n < sizeof told.bytes ? n : sizeof told.bytes);
    keep(&told);
}

static const struct dg_characters_setup whole = {
    .size = sizeof whole, .paced = true, .live = true, .late = 1, .whole = keep_whole};
static const struct dg_characters_setup paced = {.size = sizeof paced, .paced = true};
static const struct dg_characters_setup plain = {.size = sizeof plain};

/* ------------------------------------------------------------ frames */

static void set_frame_encoder(size_t place, struct dg_host *host)
{
    static const char *const nodes[] = {"1", "2", "3"};

    (void)dg_host_set(host, "node", nodes[place]);
    dg_host_shaft(host, 0, (int64_t)(place + 1u) * TURN / 7, TURN / 3);
}

static const struct dg_can_frame said[] = {
    {0x000, false, 2, {1, 0}},
    {0x000, false, 2, {0x82, 1}},
    {0x080, false, 0, {0}},
    {0x601, false, 8, {0x40, 0x04, 0x60}},
    {0x602, false, 8, {0x40, 0x04, 0x60}},
    {0x603, false, 8, {0x40, 0x00, 0x10}},
    {0x601, false, 8, {0x2B, 0x17, 0x10, 0, 30}},
    {0x602, false, 8, {0x2B, 0x17, 0x10, 0, 50}},
    {0x603, false, 8, {0x23, 0x16, 0x10, 1, 100, 0, 1}},
    {0x601, false, 8, {0x2B, 0x00, 0x18, 5, 7}},
    {0x601, false, 8, {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'}},
    {0x601, false, 8, {0xA0, 0x08, 0x10, 0, 21}},
    {0x601, false, 8, {0xA3}},
    {0x701, true, 0, {0}},
};

static void send_frames(struct bus_world *world, unsigned i)
{
    const uint32_t count = pick(i, 6, 40) == 0 ? 50 : pick(i, 6, 40) % 4u;

    for (uint32_t n = 0; n <= count; n++) {
        const struct dg_tap_event event = {
            .at = world->now, .kind = DG_TAP_FRAME, .frame = said[pick(i, 7 + n, DG_COUNT(said))]};
        (void)dg_bus_rx(world->bus, &event);
    }
}

static void perform_frames(struct bus_world *world, unsigned i)
{
    static const enum dg_wire_fault faults[4] = {DG_WIRE_DELAY, DG_WIRE_DUPLICATE, DG_WIRE_DAMAGE,
                                                 DG_WIRE_OVERRUN};

    switch (pick(i, 1, 12)) {
    case 0:
    case 1:
        disturb(world, i, faults);
        break;
    case 2:
        (void)dg_bus_frames_controller(world->bus, world->now,
                                       (enum dg_host_bus)pick(i, 8, DG_HOST_BUS_ABSENT));
        break;
    case 3:
        (void)dg_bus_frames_set_line(
            world->bus, &(struct dg_bus_frames_line){
                            .bit_rate = pick(i, 8, 4) == 0 ? 125000 : 250000,
                            .tolerant = pick(i, 10, 2) == 0,
                            .closed = pick(i, 11, 4) == 0,
                            .company = (enum dg_bus_company)pick(i, 9, DG_BUS_NOBODY + 1)});
        break;
    default:
        send_frames(world, i);
        break;
    }
}

static void look_at_frames(const struct bus_world *world, size_t i, struct bus_told *told)
{
    const struct dg_bus_frames_counters *counted = dg_bus_frames_counters(world->bus);

    told->at = dg_bus_frames_bits(world->bus);
    told->what[2] = dg_bus_frames_bit_rate(world->bus);
    told->what[3] = (uint32_t)counted->stalls << 16 | (uint32_t)counted->lost;
    told->bytes[0] = dg_bus_frames_hears(world->bus, i);
    told->bytes[1] = dg_bus_frames_waits(world->bus);
    told->bytes[2] = dg_bus_frames_listens(world->bus, (uint16_t)(0x601u + i));
}

static const struct dg_bus_frames_setup at_once = {.size = sizeof at_once};
static const struct dg_bus_frames_setup in_pace = {
    .size = sizeof in_pace, .pace = true, .line.bit_rate = 10000, .line.tolerant = true};
static const struct dg_bus_frames_setup in_turn = {
    .size = sizeof in_turn, .pace = true, .arbitrate = true};

/* ------------------------------------------------------------ edges */

static void set_edge_encoder(size_t place, struct dg_host *host)
{
    (void)dg_host_set(host, "init_ms", "1");
    dg_host_shaft(host, 0, (int64_t)(place + 1u) * TURN / 7, TURN / 3);
}

static void perform_edges(struct bus_world *world, unsigned i)
{
    static const enum dg_wire_fault faults[4] = {DG_WIRE_DELAY, DG_WIRE_DROP, DG_WIRE_DAMAGE,
                                                 DG_WIRE_BREAK};

    if (pick(i, 1, 5) == 0) {
        disturb(world, i, faults);
    } else if (pick(i, 1, 20) > 1) {
        for (uint32_t n = 10u + pick(i, 6, 11); n > 0; n--) {
            (void)dg_bus_edge(world->bus, world->now, !dg_bus_edges_clock(world->bus));
            world->now += 250u;
        }
    }
}

static void look_at_edges(const struct bus_world *world, size_t i, struct bus_told *told)
{
    (void)i;
    told->at = dg_bus_edges_fell(world->bus);
    told->what[2] = dg_bus_edges_clock(world->bus);
    told->what[3] = dg_bus_edges_data(world->bus, world->now);
}

static const struct dg_bus_edges_setup long_cable = {
    .size = sizeof long_cable, .there_ns = 700, .back_ns = 1300};

/* ------------------------------------------------------------ words */

static void set_word_encoder(size_t place, struct dg_host *host)
{
    (void)dg_host_set(host, "self_test_ms", "1");
    dg_host_shaft(host, 0, (int64_t)(place + 1u) * TURN / 7, 40 * TURN);
}

static void run_cycle(struct bus_world *world, unsigned i)
{
    static const uint16_t commands[][2] = {{0, 0},      {0x0800, 7},     {0x2021, 1},
                                           {0x2221, 5}, {0x4000, 0x100}, {0x8000, 0}};
    uint16_t out[BUS_SCENE_WORDS] = {0};
    const uint16_t *command = commands[pick(i / 4u, 6, DG_COUNT(commands))];

    memcpy(&out[0], command, sizeof commands[0]);
    memcpy(&out[2], command, sizeof commands[0]);
    const struct dg_tap_event event = {.at = world->now,
                                       .kind = DG_TAP_WORDS,
                                       .words = {.out = out,
                                                 .count = dg_ring_state(world->bus)->words,
                                                 .identify = pick(i, 7, 10) == 0}};
    (void)dg_bus_rx(world->bus, &event);
}

static void perform_words(struct bus_world *world, unsigned i)
{
    static const enum dg_wire_fault faults[4] = {DG_WIRE_TEAR, DG_WIRE_DROP, DG_WIRE_DAMAGE,
                                                 DG_WIRE_TEAR};

    switch (pick(i, 1, 16)) {
    case 0:
    case 1:
        disturb(world, i, faults);
        break;
    case 2:
        dg_ring_spoil(world->bus, (uint16_t)pick(i, 8, 3));
        break;
    case 3:
        dg_ring_cut(world->bus, pick(i, 8, 3) == 0 ? 1 : DG_RING_WHOLE);
        break;
    case 4:
        dg_ring_skip(world->bus, 3);
        break;
    default:
        run_cycle(world, i);
        break;
    }
}

static void look_at_words(const struct bus_world *world, size_t i, struct bus_told *told)
{
    const struct dg_ring_state *is = dg_ring_state(world->bus);

    told->at = dg_ring_quiet(world->bus);
    told->what[2] = is->counters.cycles << 16 | is->counters.ids;
    told->what[3] =
        is->counters.crc_errors << 16 | is->counters.dead << 8 | is->counters.interrupted;
    told->bytes[0] = (uint8_t)is->result;
    told->bytes[1] = is->dropped;
    told->bytes[2] = (uint8_t)is->reached;
    told->bytes[3] = (uint8_t)dg_ring_id_word(world->bus, i);
}

static const struct dg_bus_words_setup identifying = {.size = sizeof identifying,
                                                      .identifies = true};

/* ------------------------------------------------------------ all of them */

#define S36_LINE {"s3684-rs485", "s3674-rs485", "s3684-rs485"}, &dg_bus_characters
#define F36_BUS {"f3668", "f3658", "f3668"}, &dg_bus_frames
#define CHARACTERS set_character_encoder, look_at_characters
#define FRAMES set_frame_encoder, look_at_frames, perform_frames
#define EDGES set_edge_encoder, look_at_edges, perform_edges
#define WORDS set_word_encoder, look_at_words, perform_words

/* clang-format off */
const struct bus_scene bus_scenes[] = {
    {"characters", S36_LINE, &paced, 1000000, 30000000, CHARACTERS, perform_characters},
    {"plain characters", S36_LINE, &plain, 0, 10000000, CHARACTERS, perform_plain},
    {"whole replies", S36_LINE, &whole, 1000000, 30000000, CHARACTERS, perform_late},
    {"frames", F36_BUS, &at_once, 0, 20000000, FRAMES},
    {"frames in pace", F36_BUS, &in_pace, 0, 10000000, FRAMES},
    {"frames in turn", F36_BUS, &in_turn, 0, 500000, FRAMES},
    {"chain", {"s3684-biss", "s3674-biss", "s3684-biss"}, &dg_bus_edges, &long_cable, 5000, 7000, EDGES},
    {"line of one", {"ssi-25"}, &dg_bus_edges, NULL, 5000, 15000, EDGES},
    {"ring", {"ocd-ib-k1", "ocd-ib-k3", "ocd-ib-k2"}, &dg_bus_words, &identifying, 0, 2000000, WORDS},
};
/* clang-format on */
const size_t bus_scene_count = DG_COUNT(bus_scenes);
