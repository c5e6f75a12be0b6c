/* SPDX-License-Identifier: MIT */
#include "fmu.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/crc.h"
#include "encoder.h"

size_t fmu_count(const struct fmu *self)
{
    return self->count;
}

struct dg_host *fmu_host(const struct fmu *self, size_t encoder)
{
    return self->encoders[encoder].host;
}

const char *fmu_prefix(const struct fmu *self, size_t encoder)
{
    return self->encoders[encoder].prefix;
}

const char *fmu_wire_prefix(const struct fmu *self, size_t encoder)
{
    return self->encoders[encoder].leads ? self->encoders[encoder].wire : NULL;
}

void fmu_use_events(struct fmu *self, bool events)
{
    self->events = events;
}

/* --- time --- */

/* To the nearest one, without the library that llround() needs. */
int64_t fmu_nearest(double value)
{
    return (int64_t)(value < 0 ? value - 0.5 : value + 0.5);
}

static uint64_t ns_of(const struct fmu *self, double time)
{
    const double ns = (time - self->start) * 1e9;
    return ns <= 0 ? 0 : (uint64_t)fmu_nearest(ns);
}

/* Nor is what is no number. */
bool fmu_is_small(double value, double limit)
{
    return value < limit && value > -limit;
}

/* 2^-32 turns; as angles do, what lies beyond 64 bits wraps. */
int64_t fmu_turns(double rad)
{
    const double limit = 9.2e18;
    const double units = rad * (4294967296.0 / 6.283185307179586476925);
    if (!(units > -limit)) {
        return (int64_t)-limit;
    }
    return units < limit ? fmu_nearest(units) : (int64_t)limit;
}

/* BiSS, SSI: at this moment, if the one before is over. */
static void latch_outputs(struct fmu *self, struct fmu_encoder *encoder)
{
    struct dg_host_frame frame;
    if (self->now < encoder->now.busy || self->ops->frame(encoder, &frame) != DG_HOST_OK) {
        return;
    }
    encoder->now.frame = frame;
    encoder->now.busy = frame.end;
}

void fmu_latch_unread(struct fmu *self)
{
    for (size_t i = 0; i < self->count; i++) {
        if (self->encoders[i].unread) {
            self->encoders[i].unread = false;
            latch_outputs(self, &self->encoders[i]);
        }
    }
}

/* A frame takes its time, and a step may be shorter: what was set meanwhile begins at its end. */
static void settle_shaft(struct fmu *self, size_t index)
{
    struct fmu_turn *now = &self->shafts[index].now;
    uint64_t at = self->now;
    if (!now->angle_new && !now->speed_new) {
        return;
    }
    fmu_latch_unread(self);
    for (size_t i = 0; i < self->count; i++) {
        const struct fmu_encoder *encoder = &self->encoders[i];
        at = encoder->shaft == index && encoder->now.busy > at ? encoder->now.busy : at;
    }
    const double ahead = (double)(at - self->now) * 1e-9;
    const int64_t angle = fmu_turns(now->angle + now->speed * ahead);
    self->ops->turn(self, index, at, now->angle_new ? &angle : NULL, now->speed);
    now->angle_new = now->speed_new = false;
}

void fmu_settle(struct fmu *self)
{
    for (size_t i = 0; i < self->shaft_count; i++) {
        settle_shaft(self, i);
    }
}

void fmu_latch(struct fmu *self)
{
    for (size_t i = 0; i < self->count; i++) {
        if (self->encoders[i].now.ma) {
            self->encoders[i].now.ma = false;
            latch_outputs(self, &self->encoders[i]);
        }
    }
}

int fmu_start(struct fmu *self, double start)
{
    int result = DG_HOST_OK;
    if (self->started) {
        return result;
    }
    if (!fmu_is_small(start, FMU_TIME_MAX)) {
        return DG_HOST_ERR_ARGUMENT;
    }
    self->started = true;
    self->start = start;
    fmu_settle(self);
    result = self->ops->start(self);
    for (size_t i = 0; i < self->count && result == DG_HOST_OK; i++) {
        struct fmu_encoder *encoder = &self->encoders[i];
        for (uint32_t k = 0; k < FMU_FAULTS_MAX && result == DG_HOST_OK; k++) {
            result = encoder_begin_fault(encoder, k);
        }
    }
    return result;
}

bool fmu_started(const struct fmu *self)
{
    return self->started;
}

double fmu_time(const struct fmu *self)
{
    return self->start + (double)self->now * 1e-9;
}

/* From a number to the next one that a double can be. */
static double ulp_of(double value)
{
    double next = value < 0 ? -value : value;
    const double from = next;
    uint64_t bits;
    memcpy(&bits, &next, sizeof bits);
    bits++;
    memcpy(&next, &bits, sizeof next);
    return next - from;
}

/* Importers add up their steps, which is not exact; far from 0 a double is coarser than that. */
static bool is_at(const struct fmu *self, double time)
{
    const double least = 1e-6;
    const double coarse = 4 * ulp_of(fmu_time(self));
    const double tolerance = coarse > least ? coarse : least;
    const double gap = time - fmu_time(self);
    return gap >= -tolerance && gap <= tolerance;
}

bool fmu_may_step(const struct fmu *self, double now, double span)
{
    return self->started && is_at(self, now) && span >= 0 &&
           fmu_is_small(now - self->start + span, FMU_TIME_MAX);
}

static uint64_t next_of(const struct fmu *self, uint64_t to)
{
    const uint64_t next = self->ops->next(self);
    return next < to ? next : to;
}

double fmu_step(struct fmu *self, double now, double span, bool early)
{
    const uint64_t end = ns_of(self, now + span);
    const uint64_t to = end > self->now ? end : self->now;
    bool over = false;
    for (size_t i = 0; i < self->count; i++) {
        self->encoders[i].unread = false;
    }
    fmu_settle(self);
    for (size_t i = 0; i < self->count; i++) {
        wire_configure(&self->encoders[i]);
    }
    while (!over) {
        const uint64_t next = early ? next_of(self, to) : to;
        const uint64_t at = next > self->now ? next : self->now + 1;
        self->now = at < to ? at : to;
        self->ops->run(self, self->now);
        over = self->now >= to || (early && fmu_ticks(self));
    }
    for (size_t i = 0; i < self->count && !self->events; i++) {
        self->encoders[i].unread = (self->encoders[i].has & FMU_HAS_MASTER) != 0;
    }
    if (self->now == to) {
        return now + span;
    }
    /* The importer may be ahead by the tolerance: its time does not go back. */
    return fmu_time(self) > now ? fmu_time(self) : now;
}

/* --- clocks and wires --- */

struct fmu_encoder *fmu_encoder_of(const struct fmu *self, uint32_t reference, enum fmu_group group)
{
    const size_t index = reference >> 16;
    const bool is = index < self->count && (reference >> 8 & 0xFFu) == (uint32_t)group;
    return is && (group != FMU_BUS || self->encoders[index].leads) ? &self->encoders[index] : NULL;
}

struct fmu_shaft *fmu_shaft_of(const struct fmu *self, uint32_t reference)
{
    const size_t index = reference >> 16;
    const bool is = index < self->shaft_count && (reference >> 8 & 0xFFu) == (uint32_t)FMU_INPUT &&
                    (reference & 0xFFu) < (uint32_t)FMU_POWER;
    return is && self->shafts[index].input ? &self->shafts[index] : NULL;
}

static bool ticks(const struct fmu_encoder *encoder)
{
    return encoder->now.waiting > 0 && !encoder->now.taken;
}

bool fmu_ticks(const struct fmu *self)
{
    for (size_t i = 0; i < self->count; i++) {
        if (ticks(&self->encoders[i])) {
            return true;
        }
    }
    return false;
}

int fmu_clock_set(struct fmu *self, uint32_t reference, bool on)
{
    struct fmu_encoder *encoder = fmu_encoder_of(self, reference, FMU_BUS);
    const uint32_t index = reference & 0xFFu;
    if (encoder == NULL || (index != FMU_RX_CLOCK && index != FMU_MA)) {
        return DG_HOST_ERR_NAME;
    }
    *(index == FMU_MA ? &encoder->now.ma : &encoder->now.rx) = on;
    return DG_HOST_OK;
}

int fmu_clock_get(struct fmu *self, uint32_t reference, bool *on)
{
    const struct fmu_encoder *encoder = fmu_encoder_of(self, reference, FMU_BUS);
    if (encoder == NULL) {
        return DG_HOST_ERR_NAME;
    }
    switch ((enum fmu_bus)(reference & 0xFFu)) {
    case FMU_RX_CLOCK:
        *on = encoder->now.rx;
        return DG_HOST_OK;
    case FMU_TX_CLOCK:
        *on = ticks(encoder);
        return DG_HOST_OK;
    case FMU_MA:
        *on = encoder->now.ma;
        return DG_HOST_OK;
    case FMU_RX:
    case FMU_TX:
        break;
    }
    return DG_HOST_ERR_NAME;
}

int fmu_binary_get(struct fmu *self, uint32_t reference, const uint8_t **bytes, size_t *n)
{
    struct fmu_encoder *encoder = fmu_encoder_of(self, reference, FMU_BUS);
    if (encoder == NULL || (reference & 0xFFu) > FMU_TX) {
        return DG_HOST_ERR_NAME;
    }
    const bool out = (reference & 0xFFu) == FMU_TX;
    *bytes = encoder->out;
    *n = out ? encoder->now.waiting : 0;
    encoder->now.taken = encoder->now.taken || out;
    return DG_HOST_OK;
}

int fmu_binary_set(struct fmu *self, uint32_t reference, const uint8_t *bytes, size_t n)
{
    struct fmu_encoder *encoder = fmu_encoder_of(self, reference, FMU_BUS);
    if (encoder == NULL || (reference & 0xFFu) != FMU_RX) {
        return DG_HOST_ERR_NAME;
    }
    if (!encoder->now.rx) {
        return DG_HOST_OK; /* a start value: nothing is on the wire while its clock is quiet */
    }
    fmu_settle(self);
    const int result = wire_take(encoder, self->now, bytes, n);
    self->ops->run(self, self->now);
    return result;
}

void fmu_clocks_end(struct fmu *self)
{
    fmu_settle(self);
    fmu_latch(self);
    for (size_t i = 0; i < self->count; i++) {
        struct fmu_course *now = &self->encoders[i].now;
        now->rx = false;
        if (now->taken) {
            now->waiting = 0;
            now->taken = false;
        }
    }
}

/* --- states --- */

/* Behind the token: what is no encoder's. */
struct moment {
    double start;
    uint64_t now;
    uint64_t started;
};

static size_t courses_size(const struct fmu *self)
{
    size_t n = self->shaft_count * sizeof(struct fmu_turn);
    for (size_t i = 0; i < self->count; i++) {
        const struct fmu_encoder *encoder = &self->encoders[i];
        n += sizeof encoder->now + (encoder->out != NULL ? encoder->room : 0) +
             (encoder->in != NULL ? encoder->room : 0);
    }
    return n;
}

static size_t own_size(const struct fmu *self)
{
    return strlen(self->token) + sizeof(struct moment) + courses_size(self) + sizeof(uint32_t);
}

/* What is set begins, for what is on a wire then is in the state. */
size_t fmu_state_size(struct fmu *self)
{
    fmu_settle(self);
    fmu_latch_unread(self);
    return own_size(self) + self->ops->state_size(self);
}

static uint8_t *put_state_bytes(uint8_t *to, const void *from, size_t n)
{
    memcpy(to, from, n);
    return to + n;
}

static uint8_t *put_courses(const struct fmu *self, uint8_t *at)
{
    for (size_t i = 0; i < self->shaft_count; i++) {
        at = put_state_bytes(at, &self->shafts[i].now, sizeof self->shafts[i].now);
    }
    for (size_t i = 0; i < self->count; i++) {
        const struct fmu_encoder *encoder = &self->encoders[i];
        at = put_state_bytes(at, &encoder->now, sizeof encoder->now);
        at = encoder->out == NULL ? at : put_state_bytes(at, encoder->out, encoder->room);
        at = encoder->in == NULL ? at : put_state_bytes(at, encoder->in, encoder->room);
    }
    return at;
}

int fmu_save(struct fmu *self, void *to, size_t n)
{
    const struct moment moment = {self->start, self->now, self->started ? 1u : 0u};
    uint8_t *at = to;
    if (n < fmu_state_size(self)) {
        return DG_HOST_ERR_SPACE;
    }
    at = put_state_bytes(at, self->token, strlen(self->token));
    at = put_state_bytes(at, &moment, sizeof moment);
    at = put_courses(self, at);
    const int result = self->ops->save(self, at);
    if (result != DG_HOST_OK) {
        return result;
    }
    at += self->ops->state_size(self);
    const uint32_t sum = dg_crc32(0, to, (size_t)(at - (uint8_t *)to));
    (void)put_state_bytes(at, &sum, sizeof sum);
    return DG_HOST_OK;
}

static const uint8_t *fetch_bytes(const uint8_t *from, void *to, size_t n)
{
    memcpy(to, from, n);
    return from + n;
}

static bool is_whole(const uint8_t *bytes, size_t n)
{
    uint32_t sum = 0;
    memcpy(&sum, bytes + n - sizeof sum, sizeof sum);
    return dg_crc32(0, bytes, n - sizeof sum) == sum;
}

/* Bytes that are bools. */
static bool are_flags(const uint8_t *bytes, const size_t *offsets, size_t count)
{
    bool good = true;
    for (size_t i = 0; i < count; i++) {
        good = good && bytes[offsets[i]] <= 1;
    }
    return good;
}

/* The library looks at its own numbers. A time too far away would be simulated, step by step. */
static bool course_fits(const struct fmu_encoder *encoder, const uint8_t *bytes, uint64_t now)
{
    static const size_t flags[] = {offsetof(struct fmu_course, power),
                                   offsetof(struct fmu_course, rx), offsetof(struct fmu_course, ma),
                                   offsetof(struct fmu_course, taken),
                                   offsetof(struct fmu_course, configured)};
    const uint64_t longest_frame = UINT64_C(1000000000);
    struct fmu_course course;
    if (!are_flags(bytes, flags, DG_COUNT(flags))) {
        return false;
    }
    memcpy(&course, bytes, sizeof course);
    return course.waiting <= (encoder->out == NULL ? 0 : encoder->room) &&
           course.coming <= (encoder->in == NULL ? 0 : encoder->room) &&
           course.bus <= DG_HOST_BUS_OFF && course.status <= DG_HOST_BUS_OFF &&
           (course.busy <= now || course.busy - now <= longest_frame);
}

/* What comes is whole. */
static bool coming_fits(const struct fmu_encoder *encoder)
{
    size_t at = 0;
    while (encoder->now.coming - at >= FMU_SERIAL_SIZE) {
        at += FMU_SERIAL_SIZE + wire_count(encoder->in + at);
        if (at > encoder->now.coming) {
            return false;
        }
    }
    return at == encoder->now.coming;
}

static bool moment_fits(const struct moment *moment)
{
    return moment->started <= 1 && fmu_is_small(moment->start, FMU_TIME_MAX) &&
           moment->now <= (uint64_t)FMU_TIME_MAX * 1000000000u;
}

/* @return what is behind, or NULL */
static const uint8_t *restore_shafts(struct fmu *self, const uint8_t *at)
{
    static const size_t flags[] = {offsetof(struct fmu_turn, angle_new),
                                   offsetof(struct fmu_turn, speed_new)};
    for (size_t i = 0; i < self->shaft_count; i++) {
        if (!are_flags(at, flags, DG_COUNT(flags))) {
            return NULL;
        }
        at = fetch_bytes(at, &self->shafts[i].now, sizeof self->shafts[i].now);
    }
    return at;
}

/* Likewise. A handle keeps the faults of its panel, so those of the state come before it. */
static const uint8_t *restore_courses(struct fmu *self, const uint8_t *at)
{
    for (size_t i = 0; at != NULL && i < self->count; i++) {
        struct fmu_encoder *encoder = &self->encoders[i];
        struct fmu_course course;
        if (!course_fits(encoder, at, self->now)) {
            return NULL;
        }
        at = fetch_bytes(at, &course, sizeof course);
        for (uint32_t k = 0; self->rig == NULL && k < FMU_FAULTS_MAX; k++) {
            (void)encoder_set_fault(encoder, k, (course.faults[k / 64u] >> k % 64u & 1u) != 0);
        }
        at = encoder->out == NULL ? at : fetch_bytes(at, encoder->out, encoder->room);
        at = encoder->in == NULL ? at : fetch_bytes(at, encoder->in, encoder->room);
        encoder->now = course;
        encoder->unread = false;
        if (!coming_fits(encoder)) {
            return NULL;
        }
    }
    return at;
}

/* Behind the token, and before the sum. @return 0, or a result of host.h */
static int restore_all(struct fmu *self, const uint8_t *at, const uint8_t *end)
{
    struct moment moment;
    at = fetch_bytes(at, &moment, sizeof moment);
    if (!moment_fits(&moment)) {
        return DG_HOST_ERR_DAMAGED;
    }
    self->start = moment.start;
    self->now = moment.now;
    self->started = moment.started == 1;
    at = restore_shafts(self, at);
    at = at == NULL ? NULL : restore_courses(self, at);
    if (at == NULL) {
        return DG_HOST_ERR_DAMAGED;
    }
    const int result = self->ops->restore(self, at, (size_t)(end - at));
    return result == DG_HOST_OK && self->ops->next(self) < self->now ? DG_HOST_ERR_DAMAGED : result;
}

/* What is on the wires of a rig is in its state, whatever that needs. */
static bool is_of_this(struct fmu *self, const uint8_t *bytes, size_t n)
{
    return (self->rig == NULL ? n == fmu_state_size(self) : n >= own_size(self)) &&
           memcmp(bytes, self->token, strlen(self->token)) == 0;
}

/* Importers keep states in files: one that is refused changes nothing. */
int fmu_restore(struct fmu *self, const void *from, size_t n)
{
    const uint8_t *at = from;
    const size_t head = strlen(self->token);
    const size_t sum = sizeof(uint32_t);
    if (!is_of_this(self, at, n)) {
        return DG_HOST_ERR_OTHER;
    }
    const size_t own = fmu_state_size(self);
    uint8_t *before = is_whole(at, n) ? malloc(own) : NULL;
    if (before == NULL) {
        return is_whole(at, n) ? DG_HOST_ERR_SPACE : DG_HOST_ERR_DAMAGED;
    }
    int result = fmu_save(self, before, own);
    if (result == DG_HOST_OK) {
        (void)fmu_start(self, self->start); /* only who was on has faults */
        result = restore_all(self, at + head, at + n - sum);
    }
    if (result != DG_HOST_OK) {
        (void)restore_all(self, before + head, before + own - sum);
    }
    free(before);
    return result;
}
