/* SPDX-License-Identifier: MIT */
/*
 * States of a rig of each medium, saved at any moment while something happens to it all the time:
 * what goes on from them in another rig, in dirty memory, is what would have gone on. What is not
 * such a state is refused.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/crc.h"
#include "drehgeber/host_wire.h"
#include "effort.h"
#include "engine_rig.h"

#define OPERATIONS 90u
#define STEP DG_MS(17)
#define READY DG_S(3)
#define TOLD_MAX 40000u
#define STATE_MAX ((size_t)1u << 20u)
/* So many deadlines in a row, and time stands. */
#define STEPS_MAX 1000000u
/* Of the header: where the number of encoders is, and its end. */
#define ENCODERS_AT 44u
#define HEADER_SIZE 64u

struct told {
    dg_ns at;
    uint32_t what[3];
    uint8_t bytes[8];
};

struct world {
    struct engine_rig rig;
    struct dg_rig_course course;
    dg_ns now;
};

struct scene {
    const char *text;
    const char *defect; /* of the encoder, */
    const char *fault;  /* of the wire */
    void (*say)(struct world *world, unsigned i);
};

static struct world worlds[2];
static struct told told[TOLD_MAX];
static struct told expected[TOLD_MAX];
static size_t told_count;
static uint8_t state_bytes[STATE_MAX];

static void keep(const struct told *one)
{
    assert_true(told_count < TOLD_MAX);
    told[told_count++] = *one;
}

/* ------------------------------------------------------------ a rig */

static void keep_event(void *ctx, size_t place, const struct dg_tap_event *event)
{
    struct told one = {.at = event->at, .what = {event->kind, (uint32_t)place}};

    (void)ctx;
    if (event->kind == DG_TAP_CHARACTER) {
        one.what[2] = event->character.byte;
    } else if (event->kind == DG_TAP_FRAME) {
        one.what[2] = event->frame.id;
        memcpy(one.bytes, event->frame.data, sizeof one.bytes);
    } else if (event->kind == DG_TAP_LEVELS) {
        one.what[2] = event->levels.data ? 1u : 0u;
    }
    keep(&one);
}

static int open_door(void *ctx, size_t index, struct dg_engine_wire *to,
                     struct dg_plan_error *error)
{
    static const struct dg_bus_ops door = {.tx = keep_event};

    (void)index;
    (void)error;
    to->ops = &door;
    to->ctx = ctx;
    return 0;
}

static int find_motion(void *ctx, size_t index, const char *path, struct dg_motion *to,
                       struct dg_plan_error *error)
{
    static const struct dg_motion_point points[] = {
        {0, 0}, {DG_S(2), DG_TURN}, {DG_S(3), 0}, {DG_S(9), 5 * DG_TURN / 3}};

    (void)ctx;
    (void)index;
    (void)path;
    (void)error;
    *to = (struct dg_motion){
        .kind = DG_MOTION_REPLAY, .points = points, .point_count = DG_COUNT(points)};
    return 0;
}

static struct dg_rig_course *find_course(void *ctx, size_t index,
                                         const struct dg_plan_setting *setting,
                                         struct dg_plan_error *error)
{
    static const struct dg_course_point points[] = {
        {0, 20000}, {DG_MS(700), 130000}, {DG_MS(900), 30000}};
    struct world *world = ctx;

    (void)index;
    (void)setting;
    (void)error;
    world->course = (struct dg_rig_course){.course = {.points = points, .count = DG_COUNT(points)}};
    return &world->course;
}

static void make_world(const struct scene *scene, struct world *world)
{
    memset(world, 0xA5, sizeof *world);
    engine_rig_read(&world->rig, scene->text);
    world->rig.setup.wire = open_door;
    world->rig.setup.motion = find_motion;
    world->rig.setup.course = find_course;
    world->rig.setup.ctx = world;
    engine_rig_make(&world->rig);
    assert_non_null(world->rig.engine);
}

static void pass_to(struct world *world, dg_ns until)
{
    dg_ns next = dg_engine_next(world->rig.engine);

    for (unsigned steps = 0; next <= until; steps++) {
        assert_true(steps < STEPS_MAX);
        const dg_ns later = dg_engine_step(world->rig.engine, next);
        next = later > next ? later : next + 1u;
    }
    (void)dg_engine_step(world->rig.engine, until);
    world->now = until;
}

static void begin(const struct scene *scene, struct world *world)
{
    make_world(scene, world);
    told_count = 0;
    engine_rig_power(&world->rig);
    pass_to(world, READY);
}

/* ------------------------------------------------------------ what happens */

static void command(struct world *world, const char *line)
{
    char text[128] = "INST:SEL a;:";

    (void)strncat(text, line, sizeof text - sizeof "INST:SEL a;:");
    assert_string_equal(engine_rig_ask(&world->rig, world->now, text), "");
    assert_string_equal(engine_rig_ask(&world->rig, world->now, "SYST:ERR?"), "0,\"No error\"");
}

static void set_fault(struct world *world, const char *fault)
{
    char line[64] = "FAUL:SET ";

    (void)strncat(line, fault, sizeof line - sizeof "FAUL:SET ");
    command(world, line);
}

static void disturb(const struct scene *scene, struct world *world, unsigned i)
{
    static const char *const lines[] = {
        "SHAF:VEL 100RPM", "POW OFF",        "SHAF:PROF \"sine:90DEG,1S\"",
        "POW ON",          "SHAF:ACC 5000",  "WORL:SUPP 4.9V",
        "SHAF:VEL -70RPM", "SHAF:POS 90DEG",
    };

    if (i % 16u == 7u) {
        set_fault(world, scene->fault);
    } else if (i % 16u == 15u) {
        set_fault(world, scene->defect);
    } else {
        command(world, lines[i / 8u % DG_COUNT(lines)]);
    }
}

static void say_characters(struct world *world, unsigned i)
{
    static const uint8_t requests[][4] = {
        {0x40, 0x42, 0x02}, {0x41, 0x42, 0x03}, {0x40, 0x53, 0x13}, {0xFF, 0x52, 0xAD}};

    for (size_t n = 0; n < 3u; n++) {
        const struct dg_tap_event event = {
            .at = world->now,
            .kind = DG_TAP_CHARACTER,
            .character = {DG_BAUD_ANY, 'E', requests[i % DG_COUNT(requests)][n], false}};
        (void)dg_bus_rx(dg_engine_bus(world->rig.engine, 0), &event);
    }
}

static void say_frames(struct world *world, unsigned i)
{
    static const struct dg_can_frame said[] = {
        {0x000, false, 2, {1, 0}},
        {0x080, false, 0, {0}},
        {0x601, false, 8, {0x40, 0x04, 0x60}},
        {0x602, false, 8, {0x2B, 0x17, 0x10, 0, 30}},
        {0x601, false, 8, {0x2B, 0x00, 0x18, 5, 7}},
        {0x603, false, 8, {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'}},
    };
    const struct dg_tap_event event = {
        .at = world->now, .kind = DG_TAP_FRAME, .frame = said[i % DG_COUNT(said)]};

    (void)dg_bus_rx(dg_engine_bus(world->rig.engine, 0), &event);
}

/* Now and then it stops in the middle of a frame. */
static void say_edges(struct world *world, unsigned i)
{
    const unsigned edges = i % 5u == 0 ? 30u : 160u;

    for (unsigned n = 1; n <= edges; n++) {
        (void)dg_bus_edge(dg_engine_bus(world->rig.engine, 0), world->now + n * 500u, n % 2u == 0);
    }
    world->now += edges * 500u;
}

static void say_words(struct world *world, unsigned i)
{
    static const uint16_t out[8];
    struct dg_bus *bus = dg_engine_bus(world->rig.engine, 0);
    const struct dg_ring_state *ring = dg_ring_state(bus);
    const struct dg_tap_event event = {
        .at = world->now,
        .kind = DG_TAP_WORDS,
        .words = {.out = out, .count = ring->words, .identify = i % 7u == 0}};

    (void)dg_bus_rx(bus, &event);
    struct told one = {.at = world->now, .what = {ring->result, ring->reached, ring->words}};
    memcpy(one.bytes, dg_engine_wire_of(world->rig.engine, 0)->words.in, sizeof one.bytes);
    keep(&one);
}

/* What can be asked without changing anything. */
static void look_at_world(struct world *world)
{
    keep(&(struct told){.at = dg_engine_next(world->rig.engine), .what = {0x1000}});
    for (size_t i = 0; i < world->rig.plan.encoder_count; i++) {
        struct dg_host *host = dg_engine_encoder(world->rig.engine, i);
        struct told one = {.at = (dg_ns)dg_host_angle(host, world->now),
                           .what = {0x1001, (uint32_t)i}};
        uint64_t counts = 0;
        int64_t temperature = 0;
        (void)dg_host_position(host, world->now, &counts);
        (void)dg_host_world_get(host, "temperature", &temperature);
        one.what[2] = (uint32_t)temperature;
        memcpy(one.bytes, &counts, sizeof counts);
        keep(&one);
    }
}

static dg_ns moment_of(unsigned i)
{
    return READY + (i + 1u) * STEP + i % 3u * DG_US(13);
}

static void play(const struct scene *scene, struct world *world, unsigned from, unsigned to)
{
    for (unsigned i = from; i < to; i++) {
        pass_to(world, moment_of(i));
        look_at_world(world);
        if (i % 4u == 3u) {
            disturb(scene, world, i);
        } else {
            scene->say(world, i);
        }
    }
}

/* ------------------------------------------------------------ rigs */

#define SHAFTS                                                                                     \
    "[shaft motor]\nmotion = turn.csv\n"                                                           \
    "[shaft load]\ndriver = motor\nratio = 1:4\n"

static const struct scene scenes[] = {
    {SHAFTS "[bus rs]\nwire = pty\n"
            "[encoder a]\nmodel = s3684-rs485\nbus = rs\naddress = 0x40\nshaft = motor\n"
            "temperature = warm.csv,LOOP\n"
            "[encoder b]\nmodel = s3684-rs485\nbus = rs\naddress = 0x41\nshaft = load\n",
     "temperature_high,DUR 60MS", "wire_delay,COUN 2", say_characters},
    {SHAFTS "[bus vcan]\nwire = can\naddress = vcan0\npace = 1\n"
            "[encoder a]\nmodel = f3668\nbus = vcan\nnode = 1\nshaft = motor\n"
            "temperature = warm.csv,LOOP,STEP\n"
            "[encoder n]\nmodel = f3668\nbus = vcan\nnode = 2..3\nshaft = load\n",
     "temperature_high,DUR 60MS", "wire_delay,COUN 2", say_frames},
    {SHAFTS "[bus c]\nwire = sim\nline_delay_ns = 100\n"
            "[encoder a]\nmodel = s3684-biss\nbus = c\nshaft = motor\n"
            "temperature = warm.csv,ONCE\n"
            "[encoder b]\nmodel = s3674-biss\nbus = c\nshaft = load\n",
     "temperature_high,DUR 60MS", "wire_damage,COUN 2", say_edges},
    {SHAFTS "[bus loop]\nwire = modbus\n"
            "[encoder a]\nmodel = ocd-ib-k2\nbus = loop\nshaft = motor\ntemperature = warm.csv\n"
            "[encoder b]\nmodel = ocd-ib-k3\nbus = loop\nshaft = load\n",
     "singleturn_lost,DUR 60MS", "wire_tear,COUN 2", say_words},
};

/* ------------------------------------------------------------ there and back */

static size_t save(struct world *world)
{
    const size_t n = dg_engine_state_size(world->rig.engine);

    assert_in_range(n, HEADER_SIZE + 1u, sizeof state_bytes);
    assert_int_equal(dg_engine_save(world->rig.engine, state_bytes, n), DG_HOST_OK);
    return n;
}

/* In a rig that was never on, or in one that has lived; what was in the first one is gone. */
static void go_on_elsewhere(const struct scene *scene, bool fresh)
{
    const size_t count = told_count;
    const dg_ns now = worlds[0].now;
    const size_t n = save(&worlds[0]);

    make_world(scene, &worlds[1]);
    if (fresh) {
        engine_rig_connect(&worlds[1].rig);
    } else {
        engine_rig_power(&worlds[1].rig);
        pass_to(&worlds[1], READY);
        set_fault(&worlds[1], scene->defect);
        command(&worlds[1], "WORL:TEMP 20");
    }
    memset(&worlds[0], 0x5A, sizeof worlds[0]);
    assert_int_equal(dg_engine_restore(worlds[1].rig.engine, state_bytes, n), DG_HOST_OK);
    worlds[1].now = now;
    told_count = count;
}

static void compare_with_expected(const struct scene *scene, size_t count, unsigned i)
{
    for (size_t n = 0; n < count && n < told_count; n++) {
        if (memcmp(&told[n], &expected[n], sizeof expected[n]) != 0) {
            fail_msg("%.40s..., saved behind operation %u: %zu is %llu %x %x %x, not %llu %x %x %x",
                     strstr(scene->text, "[bus"), i, n, (unsigned long long)told[n].at,
                     told[n].what[0], told[n].what[1], told[n].what[2],
                     (unsigned long long)expected[n].at, expected[n].what[0], expected[n].what[1],
                     expected[n].what[2]);
        }
    }
    assert_int_equal(told_count, count);
}

static void save_everywhere(const struct scene *scene)
{
    const unsigned step = effort(7, 1);

    begin(scene, &worlds[0]);
    play(scene, &worlds[0], 0, OPERATIONS);
    const size_t count = told_count;
    memcpy(expected, told, count * sizeof expected[0]);
    assert_true(count > 3u * OPERATIONS);
    for (unsigned i = 0; i < OPERATIONS; i += step) {
        begin(scene, &worlds[0]);
        play(scene, &worlds[0], 0, i);
        pass_to(&worlds[0], moment_of(i) - i % 5u * DG_MS(3));
        go_on_elsewhere(scene, i % 2u == 0);
        play(scene, &worlds[1], i, OPERATIONS);
        compare_with_expected(scene, count, i);
    }
}

static void a_rig_goes_on_elsewhere(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(scenes); i++) {
        save_everywhere(&scenes[i]);
    }
}

/* ------------------------------------------------------------ what is none */

static void sign(size_t n)
{
    const uint32_t sum = dg_crc32(0, state_bytes + HEADER_SIZE, n - HEADER_SIZE);

    memcpy(state_bytes + HEADER_SIZE - sizeof sum, &sum, sizeof sum);
}

static int restore(size_t n)
{
    make_world(&scenes[0], &worlds[1]);
    return dg_engine_restore(worlds[1].rig.engine, state_bytes, n);
}

static void what_is_no_state_is_refused(void **state)
{
    (void)state;
    begin(&scenes[0], &worlds[0]);
    const size_t n = save(&worlds[0]);
    assert_int_equal(dg_engine_save(worlds[0].rig.engine, state_bytes, n - 1u), DG_HOST_ERR_SPACE);
    assert_int_equal(restore(n), DG_HOST_OK);
    assert_int_equal(restore(n - 1u), DG_HOST_ERR_SPACE);
    assert_int_equal(restore(HEADER_SIZE - 1u), DG_HOST_ERR_SPACE);
    state_bytes[n - 1u] ^= 1u;
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    state_bytes[n - 1u] ^= 1u;
    state_bytes[ENCODERS_AT] ^= 1u;
    assert_int_equal(restore(n), DG_HOST_ERR_OTHER);
    state_bytes[ENCODERS_AT] ^= 1u;
    assert_int_equal(restore(n), DG_HOST_OK);
}

/* Behind the moment is the first shaft. */
static void what_somebody_has_made_is_looked_at(void **state)
{
    uint8_t *shaft = state_bytes + HEADER_SIZE + sizeof(dg_ns);
    struct dg_shaft_course course;

    (void)state;
    begin(&scenes[0], &worlds[0]);
    const size_t n = save(&worlds[0]);
    memcpy(&course, shaft, sizeof course);
    assert_true(course.plays);
    assert_int_equal(course.motion.kind, DG_MOTION_REPLAY);
    assert_null(course.motion.points);
    shaft[offsetof(struct dg_shaft_course, plays)] = 2;
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    course.motion.kind = DG_MOTION_KIND_COUNT;
    memcpy(shaft, &course, sizeof course);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    course.plays = false;
    course.count = DG_SHAFT_PHASES + 1u;
    memcpy(shaft, &course, sizeof course);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    course.count = 1;
    course.phase[0] = (struct dg_shaft_phase){.mrpm_per_s = 1};
    memcpy(shaft, &course, sizeof course);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    course.phase[0].mrpm_per_s = 0;
    memcpy(shaft, &course, sizeof course);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_OK);
}

/* A shaft of two phases, the first of which accelerates. */
static void phases_that_cannot_be_are_refused(void **state)
{
    static const struct {
        uint64_t span;
        int64_t accel;
        int64_t prpm;
        uint64_t part;
        uint8_t count;
        bool good;
    } rows[] = {
        {DG_S(1), 1000, 0, 0, 2, true},
        {DG_S(1), -1000, -1000, 0, 2, true},
        {DG_S(1), 1000, 0, DG_SHAFT_PARTS, 2, false},
        {DG_S(1), 1000, INT64_MAX, 0, 2, false},
        {DG_S(1), 1000, INT64_MIN, 0, 2, false},
        {0 - (uint64_t)DG_S(1), 1000, 0, 0, 2, false},
        {DG_S(1), INT64_MAX, 0, 0, 2, false},
        {0, 0, 0, 0, 0, false},
    };
    uint8_t *shaft = state_bytes + HEADER_SIZE + sizeof(dg_ns);

    (void)state;
    begin(&scenes[0], &worlds[0]);
    const size_t n = save(&worlds[0]);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_shaft_course course = {.count = rows[i].count};
        course.phase[0].at = READY;
        course.phase[0].mrpm_per_s = rows[i].accel;
        course.phase[0].prpm = rows[i].prpm;
        course.phase[0].part = rows[i].part;
        course.phase[1].at = READY + rows[i].span;
        memcpy(shaft, &course, sizeof course);
        sign(n);
        assert_int_equal(restore(n), rows[i].good ? DG_HOST_OK : DG_HOST_ERR_DAMAGED);
    }
}

/* Behind both courses of a shaft are when it jumped, its acceleration, its offset and the words of its
   motion. */
#define SHAFT_SIZE (2u * sizeof(struct dg_shaft_course) + sizeof(dg_ns) + 16u + 64u)

static void the_rest_of_a_shaft_is_looked_at(void **state)
{
    uint8_t *rest =
        state_bytes + HEADER_SIZE + 2u * sizeof(dg_ns) + 2u * sizeof(struct dg_shaft_course);
    const int64_t most = INT64_MAX;
    int64_t accel;

    (void)state;
    begin(&scenes[0], &worlds[0]);
    const size_t n = save(&worlds[0]);
    memcpy(&accel, rest, sizeof accel);
    memcpy(rest, &most, sizeof most);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    memcpy(rest, &accel, sizeof accel);
    rest[16u + 63u] = 'x';
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    rest[16u + 63u] = 0;
    sign(n);
    assert_int_equal(restore(n), DG_HOST_OK);
}

/* Behind two shafts is the course of the plan: its start, when it is due, whether it is followed. */
static void a_course_that_cannot_be_is_refused(void **state)
{
    uint8_t *at = state_bytes + HEADER_SIZE + sizeof(dg_ns) + 2u * SHAFT_SIZE;
    uint64_t words[3];

    (void)state;
    begin(&scenes[0], &worlds[0]);
    const size_t n = save(&worlds[0]);
    memcpy(words, at, sizeof words);
    assert_int_equal(words[2], 1);
    words[2] = 2;
    memcpy(at, words, sizeof words);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    words[2] = 1;
    words[1] = 0;
    memcpy(at, words, sizeof words);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    words[2] = 0;
    memcpy(at, words, sizeof words);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_OK);
}

/* A rig whose first encoder is too warm. @return bytes of its state; its faults are `at`, behind shafts and
   course */
static size_t save_with_fault(uint8_t **at)
{

    begin(&scenes[0], &worlds[0]);
    set_fault(&worlds[0], "temperature_high");
    *at = state_bytes + HEADER_SIZE + sizeof(dg_ns) + 2u * SHAFT_SIZE + 24u;
    return save(&worlds[0]);
}

/* What is refused leaves none. */
static void faults_that_cannot_be_are_refused(void **state)
{
    struct dg_faults faults;
    uint8_t *at;

    (void)state;
    const size_t n = save_with_fault(&at);
    const struct dg_encoder *encoder = dg_engine_control(worlds[0].rig.engine)->encoders[0];
    assert_memory_equal(at, &encoder->faults, sizeof encoder->faults);
    memcpy(&faults, at, sizeof faults);
    faults.wire = 1u << DG_WIRE_FAULT_COUNT;
    memcpy(at, &faults, sizeof faults);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    faults.wire = 0;
    faults.slot[0] = DG_FAULTS_MAX;
    memcpy(at, &faults, sizeof faults);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    faults.slot[0] = 0;
    for (size_t i = 0; i < DG_FAULTS_MAX; i++) {
        faults.fault[i].healthy = faults.fault[i].active ? INT64_MAX : faults.fault[i].healthy;
    }
    memcpy(at, &faults, sizeof faults);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    memset(&faults, 0, sizeof faults);
    encoder = dg_engine_control(worlds[1].rig.engine)->encoders[0];
    assert_memory_equal(&encoder->faults, &faults, sizeof faults);
    memcpy(at, &faults, sizeof faults);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_OK);
}

/* Neither below what the quantity can be, nor with another byte where there is a bool. */
static void faults_of_other_bytes_are_refused(void **state)
{
    struct dg_faults faults;
    uint8_t *at;

    (void)state;
    const size_t n = save_with_fault(&at);
    memcpy(&faults, at, sizeof faults);
    for (size_t i = 0; i < DG_FAULTS_MAX; i++) {
        faults.fault[i].healthy = faults.fault[i].active ? INT32_MIN : faults.fault[i].healthy;
    }
    memcpy(at, &faults, sizeof faults);
    sign(n);
    assert_int_equal(restore(n), DG_HOST_ERR_DAMAGED);
    memset(&faults, 0, sizeof faults);
    for (uint8_t active = 1; active <= 3u; active++) { /* 2 is no bool, and the last one no fault */
        struct dg_faults forged = faults;
        const uint8_t byte = active == 3u ? 1u : active;
        memcpy(&forged.fault[active == 3u ? DG_FAULTS_MAX - 1u : 0].active, &byte, 1);
        memcpy(at, &forged, sizeof forged);
        sign(n);
        assert_int_equal(restore(n), active == 1u ? DG_HOST_OK : DG_HOST_ERR_DAMAGED);
    }
}

/* Its points are nowhere but with the host. */
static void what_only_the_host_plays_cannot_be_saved(void **state)
{
    static const struct dg_course_point points[] = {{0, 1000}, {DG_S(9), 2000}};
    static const struct dg_motion_point turn[] = {{0, 0}, {DG_S(9), DG_TURN}};
    struct dg_rig_course own = {.course = {.points = points, .count = 2},
                                .quantity = DG_QUANTITY_TEMPERATURE};
    const struct dg_motion motion = {.kind = DG_MOTION_REPLAY, .points = turn, .point_count = 2};

    (void)state;
    begin(&scenes[0], &worlds[0]);
    struct dg_rig *rig = dg_engine_control(worlds[0].rig.engine);
    const size_t n = save(&worlds[0]);
    assert_int_equal(dg_rig_follow(rig, rig->encoders[1], &own, READY), DG_OK);
    assert_int_equal(dg_engine_save(worlds[0].rig.engine, state_bytes, n), DG_HOST_ERR_STATE);
    dg_rig_unfollow(rig, rig->encoders[1], own.quantity);
    assert_int_equal(dg_engine_save(worlds[0].rig.engine, state_bytes, n), DG_HOST_OK);
    assert_int_equal(dg_shaft_play(&rig->shafts[0]->shaft, READY, &motion), DG_OK);
    assert_int_equal(dg_engine_save(worlds[0].rig.engine, state_bytes, n), DG_HOST_ERR_STATE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rig_goes_on_elsewhere),
        cmocka_unit_test(what_is_no_state_is_refused),
        cmocka_unit_test(what_somebody_has_made_is_looked_at),
        cmocka_unit_test(phases_that_cannot_be_are_refused),
        cmocka_unit_test(the_rest_of_a_shaft_is_looked_at),
        cmocka_unit_test(a_course_that_cannot_be_is_refused),
        cmocka_unit_test(faults_that_cannot_be_are_refused),
        cmocka_unit_test(faults_of_other_bytes_are_refused),
        cmocka_unit_test(what_only_the_host_plays_cannot_be_saved),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
