/* SPDX-License-Identifier: MIT */
/*
 * States of a rig: what is its own, and behind it those of its encoders and of its buses.
 *
 *   | header | now | shafts | courses of the plan | faults and handle of each encoder | buses |
 *
 * One walk writes and reads, so that the two cannot differ. Points of motions and courses are the
 * host's: a state says that they are played, and the rig that goes on has the same ones.
 */
#include "engine_private.h"

#include <string.h>

#include "drehgeber/crc.h"
#include "drehgeber/hal.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/quantity.h"
#include "drehgeber/version.h"

#define VERSION_MAX 24u
#define ORDER UINT32_C(0x01020304)
/* Speeds of a phase and what an acceleration adds to them, in 10^-12 rpm (shaft.c). */
#define SPEED_MAX (INT64_C(1000000000) * DG_MOTION_SPEED_MAX_MRPM)
#define CHANGE_MAX UINT64_C(4000000000000000000)

static const char magic[8] = {'D', 'G', 'R', 'I', 'G', 'S', 'T', '\1'};
static const char version[] = DG_VERSION;
_Static_assert(sizeof version <= VERSION_MAX, "the version has room");

/* The builds that understand each other: same layouts, same byte order. */
struct header {
    char magic[8];
    char version[VERSION_MAX];
    uint32_t order;   /* of the bytes in a number */
    uint32_t pointer; /* bytes of one */
    uint32_t shafts;
    uint32_t encoders;
    uint32_t wires;
    uint32_t courses;
    uint32_t size; /* of all behind the header */
    uint32_t sum;  /* likewise */
};

/* A shaft, without pointers. */
struct shaft_state {
    struct dg_shaft_course course;
    struct dg_shaft_course before;
    dg_ns jumped;
    int64_t mrpm_per_s;
    dg_angle offset;
    char profile[ENGINE_PROFILE_MAX];
};

/* A course of the plan. */
struct course_state {
    dg_ns start;
    dg_ns due;
    uint64_t followed; /* 1: it is */
};

/* A state on its way. */
struct engine_tape {
    uint8_t *to;         /* NULL: it is read */
    const uint8_t *from; /* NULL: it is written */
    size_t size;
    size_t at;
    int result; /* enum dg_host_result: the first one that is not 0 */
};

static void expect_of(struct engine_tape *self, bool holds, enum dg_host_result otherwise)
{
    if (!holds && self->result == DG_HOST_OK) {
        self->result = otherwise;
    }
}

/* @return whether there are `n` more */
static bool has_bytes(struct engine_tape *self, size_t n)
{
    expect_of(self, n <= self->size - self->at, DG_HOST_ERR_DAMAGED);
    return self->result == DG_HOST_OK;
}

static void pass_bytes(struct engine_tape *self, void *it, size_t n)
{
    if (!has_bytes(self, n)) {
        return;
    }
    if (self->to != NULL) {
        memcpy(self->to + self->at, it, n);
    } else {
        memcpy(it, self->from + self->at, n);
    }
    self->at += n;
}

/* ------------------------------------------------------------ shafts */

static bool is_replayed(const struct dg_shaft_course *self)
{
    return self->plays && self->motion.kind == DG_MOTION_REPLAY;
}

/* Points that are not of the plan's file come from a host that plays others. */
static void drop_points(struct engine_tape *tape, const struct engine_shaft *shaft,
                        struct dg_shaft_course *course)
{
    expect_of(tape, !is_replayed(course) || course->motion.points == shaft->points,
              DG_HOST_ERR_STATE);
    course->motion.points = NULL;
    course->motion.point_count = 0;
}

static uint64_t magnitude_of(int64_t value)
{
    return value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
}

/* Its speed stays one up to `next`; NULL: for good. */
static bool is_sound_phase(const struct dg_shaft_phase *self, const struct dg_shaft_phase *next)
{
    const uint64_t accel = magnitude_of(self->mrpm_per_s);

    return self->part < DG_SHAFT_PARTS && magnitude_of(self->prpm) <= (uint64_t)SPEED_MAX &&
           (accel == 0 ||
            (next != NULL && next->at >= self->at && next->at - self->at <= CHANGE_MAX / accel));
}

/* @param bytes of the course, which may be any */
static bool is_sound_course(const struct engine_shaft *shaft, const struct dg_shaft_course *bytes)
{
    struct dg_shaft_course course;
    uint8_t plays;

    memcpy(&plays, (const uint8_t *)bytes + offsetof(struct dg_shaft_course, plays), sizeof plays);
    if (plays > 1u) {
        return false;
    }
    memcpy(&course, bytes, sizeof course);
    if (course.plays) {
        struct dg_motion motion = course.motion;
        motion.points = shaft->points;
        motion.point_count = shaft->point_count;
        return dg_motion_set(&course.motion, &motion) == DG_OK;
    }
    bool good = course.count >= 1u && course.count <= DG_SHAFT_PHASES;
    for (size_t i = 0; good && i < course.count; i++) {
        good =
            is_sound_phase(&course.phase[i], i + 1u < course.count ? &course.phase[i + 1u] : NULL);
    }
    return good;
}

static void give_points(const struct engine_shaft *shaft, struct dg_shaft_course *course)
{
    if (course->plays) {
        struct dg_motion motion = course->motion;
        motion.points = shaft->points;
        motion.point_count = shaft->point_count;
        (void)dg_motion_set(&course->motion, &motion);
    }
}

static void put_shaft(struct engine_tape *tape, struct engine_shaft *shaft,
                      struct shaft_state *state)
{
    struct dg_shaft *to = &shaft->control.shaft;

    expect_of(tape,
              is_sound_course(shaft, &state->course) && is_sound_course(shaft, &state->before) &&
                  magnitude_of(state->mrpm_per_s) <= (uint64_t)DG_SHAFT_ACCELERATION_MAX &&
                  state->profile[ENGINE_PROFILE_MAX - 1u] == '\0',
              DG_HOST_ERR_DAMAGED);
    if (tape->result != DG_HOST_OK) {
        return;
    }
    to->course = state->course;
    to->before = state->before;
    to->jumped = state->jumped;
    to->mrpm_per_s = state->mrpm_per_s;
    to->offset = state->offset;
    give_points(shaft, &to->course);
    give_points(shaft, &to->before);
    memcpy(shaft->profile, state->profile, sizeof shaft->profile);
}

static void pass_shaft(struct engine_tape *tape, struct engine_shaft *shaft)
{
    const struct dg_shaft *from = &shaft->control.shaft;
    struct shaft_state state = {.course = from->course,
                                .before = from->before,
                                .jumped = from->jumped,
                                .mrpm_per_s = from->mrpm_per_s,
                                .offset = from->offset};

    if (tape->to != NULL) {
        memcpy(state.profile, shaft->profile, sizeof state.profile);
        drop_points(tape, shaft, &state.course);
        drop_points(tape, shaft, &state.before);
    }
    pass_bytes(tape, &state, sizeof state);
    if (tape->from != NULL && tape->result == DG_HOST_OK) {
        put_shaft(tape, shaft, &state);
    }
}

/* ------------------------------------------------------------ courses */

static bool is_followed(const struct dg_engine *self, const struct engine_course *course)
{
    return dg_rig_course_of(&self->encoders[course->encoder].control, course->it->quantity) ==
           course->it;
}

static size_t count_followed(const struct dg_engine *self)
{
    size_t n = 0;

    for (size_t i = 0; i < self->control.encoder_count; i++) {
        for (const struct dg_rig_course *at = self->encoders[i].control.courses; at != NULL;
             at = at->next) {
            n++;
        }
    }
    return n;
}

/* One that is due in the past would be looked at every millisecond from there on. */
static void put_course(struct engine_tape *tape, struct dg_engine *self,
                       const struct engine_course *course, const struct course_state *state)
{
    struct dg_encoder *encoder = &self->encoders[course->encoder].control;

    expect_of(tape, state->followed <= 1u, DG_HOST_ERR_DAMAGED);
    if (state->followed != 1u) {
        return;
    }
    expect_of(tape, state->due >= self->now, DG_HOST_ERR_DAMAGED);
    course->it->start = state->start;
    course->it->due = state->due;
    course->it->next = encoder->courses;
    encoder->courses = course->it;
}

/* They are all of the plan, or there is one that only the host knows. */
static void pass_courses(struct engine_tape *tape, struct dg_engine *self)
{
    size_t n = 0;

    for (size_t i = 0; tape->from != NULL && i < self->control.encoder_count; i++) {
        self->encoders[i].control.courses = NULL;
    }
    for (size_t i = 0; i < self->course_count; i++) {
        const struct engine_course *course = &self->courses[i];
        struct course_state state = {course->it->start, course->it->due, is_followed(self, course)};
        n += (size_t)state.followed;
        pass_bytes(tape, &state, sizeof state);
        if (tape->from != NULL && tape->result == DG_HOST_OK) {
            put_course(tape, self, course, &state);
        }
    }
    expect_of(tape, tape->to == NULL || n == count_followed(self), DG_HOST_ERR_STATE);
}

/* ------------------------------------------------------------ encoders */

/* What undoes it is a value of the quantity, or a byte of the memory. */
static bool can_be_undone(const struct engine_encoder *self, const struct dg_fault_entry *entry,
                          const struct dg_fault *fault)
{
    if (entry->kind == DG_FAULT_WORLD) {
        const struct dg_quantity *row = dg_quantity_at(entry->row->offset);
        return fault->healthy >= row->min && fault->healthy <= row->max;
    }
    return entry->kind != DG_FAULT_MEMORY || fault->flip.address < dg_host_memory_size(self->host);
}

/* Behind its handle, which knows its figures. */
static bool are_faults_sound(const struct engine_encoder *self)
{
    const struct dg_faults *faults = &self->control.faults;
    bool good = faults->wire >> DG_WIRE_FAULT_COUNT == 0;

    for (size_t i = 0; i < DG_WIRE_FAULT_COUNT; i++) {
        good = good && faults->slot[i] < DG_FAULTS_MAX;
    }
    for (size_t i = 0; good && i < DG_FAULTS_MAX; i++) {
        struct dg_fault_entry entry;
        uint8_t active;
        memcpy(&active, &faults->fault[i].active, sizeof active);
        if (active != 0) {
            const struct dg_fault_target target = dg_encoder_target(&self->control);
            good = active == 1u && self->control.device != NULL &&
                   dg_fault_entry(&target, i, &entry) &&
                   can_be_undone(self, &entry, &faults->fault[i]);
        }
    }
    return good;
}

static void pass_handle(struct engine_tape *tape, struct engine_encoder *encoder)
{
    const size_t n = dg_host_state_size(encoder->host);

    if (has_bytes(tape, n)) {
        tape->result = tape->to != NULL ? dg_host_save(encoder->host, tape->to + tape->at, n)
                                        : dg_host_restore(encoder->host, tape->from + tape->at, n);
        tape->at += n;
    }
}

static void pass_encoder(struct engine_tape *tape, struct engine_encoder *encoder)
{
    struct dg_faults *faults = &encoder->control.faults;

    pass_bytes(tape, faults, sizeof *faults);
    pass_handle(tape, encoder);
    if (tape->from == NULL) {
        return;
    }
    dg_engine_know_device(encoder);
    expect_of(tape, are_faults_sound(encoder), DG_HOST_ERR_DAMAGED);
    if (tape->result != DG_HOST_OK) {
        memset(faults, 0, sizeof *faults);
    }
}

/* Who waits for the end of a fault or for a course follows from these. */
static void watch_all(struct dg_engine *self)
{
    self->control.waits = NULL;
    for (size_t i = 0; i < self->control.encoder_count; i++) {
        self->encoders[i].control.wait = (struct dg_rig_wait){.waits = false};
        dg_rig_watch(&self->control, &self->encoders[i].control);
    }
}

/* ------------------------------------------------------------ buses */

static void pass_bus(struct engine_tape *tape, struct dg_bus *bus)
{
    uint32_t n = tape->to != NULL ? (uint32_t)dg_bus_state_size(bus) : 0;

    pass_bytes(tape, &n, sizeof n);
    if (has_bytes(tape, n)) {
        tape->result = tape->to != NULL ? dg_bus_save(bus, tape->to + tape->at, n)
                                        : dg_bus_restore(bus, tape->from + tape->at, n);
        tape->at += n;
    }
}

/* ------------------------------------------------------------ all of it */

static void pass_engine(struct engine_tape *tape, struct dg_engine *self)
{
    pass_bytes(tape, &self->now, sizeof self->now);
    expect_of(tape, self->now != DG_NEVER, DG_HOST_ERR_DAMAGED);
    for (size_t i = 0; i < self->control.shaft_count; i++) {
        pass_shaft(tape, &self->shafts[i]);
    }
    pass_courses(tape, self);
    for (size_t i = 0; i < self->control.encoder_count; i++) {
        pass_encoder(tape, &self->encoders[i]);
    }
    for (size_t i = 0; i < self->setup.plan->wire_count; i++) {
        pass_bus(tape, self->wires[i].bus);
    }
}

static struct header engine_header_of(const struct dg_engine *self)
{
    struct header header = {
        .order = ORDER,
        .pointer = sizeof(void *),
        .shafts = (uint32_t)self->control.shaft_count,
        .encoders = (uint32_t)self->control.encoder_count,
        .wires = (uint32_t)self->setup.plan->wire_count,
        .courses = (uint32_t)self->course_count,
    };

    memcpy(header.magic, magic, sizeof magic);
    memcpy(header.version, version, sizeof version);
    return header;
}

size_t dg_engine_state_size(const struct dg_engine *self)
{
    size_t n = sizeof(struct header) + sizeof self->now +
               self->control.shaft_count * sizeof(struct shaft_state) +
               self->course_count * sizeof(struct course_state);

    for (size_t i = 0; i < self->control.encoder_count; i++) {
        n += sizeof(struct dg_faults) + dg_host_state_size(self->encoders[i].host);
    }
    for (size_t i = 0; i < self->setup.plan->wire_count; i++) {
        n += sizeof(uint32_t) + dg_bus_state_size(self->wires[i].bus);
    }
    return n;
}

int dg_engine_save(struct dg_engine *self, void *to, size_t n)
{
    struct header header = engine_header_of(self);
    struct engine_tape tape = {.to = (uint8_t *)to + sizeof header,
                               .size = dg_engine_state_size(self) - sizeof header};

    if (n < sizeof header + tape.size) {
        return DG_HOST_ERR_SPACE;
    }
    pass_engine(&tape, self);
    if (tape.result == DG_HOST_OK) {
        header.size = (uint32_t)tape.size;
        header.sum = dg_crc32(0, tape.to, tape.size);
        memcpy(to, &header, sizeof header);
    }
    return tape.result;
}

int dg_engine_restore(struct dg_engine *self, const void *from, size_t n)
{
    const struct header mine = engine_header_of(self);
    struct engine_tape tape = {.from = (const uint8_t *)from + sizeof mine};
    struct header header;

    if (n < sizeof header) {
        return DG_HOST_ERR_SPACE;
    }
    memcpy(&header, from, sizeof header);
    if (memcmp(&header, &mine, offsetof(struct header, size)) != 0) {
        return DG_HOST_ERR_OTHER;
    }
    if (header.size > n - sizeof header) {
        return DG_HOST_ERR_SPACE;
    }
    if (header.sum != dg_crc32(0, tape.from, header.size)) {
        return DG_HOST_ERR_DAMAGED;
    }
    tape.size = header.size;
    pass_engine(&tape, self);
    watch_all(self);
    return tape.result;
}
