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
static int64_t turns_of(double rad)
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
    if (self->now < encoder->now.busy ||
        dg_host_frame(encoder->host, self->now, &frame) != DG_HOST_OK) {
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
static void settle_one(struct fmu *self, struct fmu_encoder *encoder)
{
    struct fmu_course *now = &encoder->now;
    if (!now->angle_new && !now->speed_new) {
        return;
    }
    fmu_latch_unread(self); /* also of others on its shaft */
    const uint64_t at = now->busy > self->now ? now->busy : self->now;
    const double ahead = (double)(at - self->now) * 1e-9;
    const int64_t angle = now->angle_new ? turns_of(now->angle + now->speed * ahead)
                                         : dg_host_angle(encoder->host, at);
    dg_host_shaft(encoder->host, at, angle, turns_of(now->speed));
    now->angle_new = now->speed_new = false;
}

void fmu_settle(struct fmu *self)
{
    for (size_t i = 0; i < self->count; i++) {
        settle_one(self, &self->encoders[i]);
    }
}

/* With a panel an encoder sits on the shaft of that: back to where it was. */
struct dg_host_panel *encoder_panel(struct fmu *self, struct fmu_encoder *encoder)
{
    const size_t size = dg_host_panel_size();
    if (encoder->panel != NULL) {
        return encoder->panel;
    }
    free(encoder->panel_memory);
    encoder->panel_memory = calloc(1, size + DG_HOST_ALIGN);
    if (encoder->panel_memory != NULL) {
        void *place = encoder_aligned(encoder->panel_memory);
        encoder->panel = dg_host_panel_make(place, size, encoder->host);
    }
    (void)dg_host_share(encoder->host,
                        encoder->owner < 0 ? NULL : self->encoders[encoder->owner].host);
    return encoder->panel;
}

static void run_encoder(struct fmu_encoder *self, uint64_t to)
{
    if (self->panel != NULL) {
        (void)dg_host_panel_step(self->panel, to);
    } else {
        (void)dg_host_step(self->host, to);
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
    for (size_t i = 0; i < self->count && result == DG_HOST_OK; i++) {
        struct fmu_encoder *encoder = &self->encoders[i];
        result = dg_host_power(encoder->host, 0, true);
        if (result == DG_HOST_OK && !encoder->now.power) {
            result = dg_host_power(encoder->host, 0, false);
        }
        for (uint32_t k = 0; k < FMU_FAULTS_MAX && result == DG_HOST_OK; k++) {
            result = encoder_begin_fault(self, encoder, k);
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
    for (size_t i = 0; i < self->count; i++) {
        const uint64_t next = dg_host_next(self->encoders[i].host);
        to = next < to ? next : to;
    }
    return to;
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
        for (size_t i = 0; i < self->count; i++) {
            run_encoder(&self->encoders[i], self->now);
            wire_collect(&self->encoders[i]);
        }
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
    return is ? &self->encoders[index] : NULL;
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
    *bytes = encoder->now.out;
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
    run_encoder(encoder, self->now);
    wire_collect(encoder);
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

size_t fmu_state_size(const struct fmu *self)
{
    size_t n = strlen(self->token) + sizeof self->start + sizeof self->now + sizeof self->started +
               sizeof(uint32_t);
    for (size_t i = 0; i < self->count; i++) {
        n += sizeof self->encoders[i].now + dg_host_state_size(self->encoders[i].host);
    }
    return n;
}

static uint8_t *put_state_bytes(uint8_t *to, const void *from, size_t n)
{
    memcpy(to, from, n);
    return to + n;
}

int fmu_save(struct fmu *self, void *to, size_t n)
{
    uint8_t *at = to;
    if (n < fmu_state_size(self)) {
        return DG_HOST_ERR_SPACE;
    }
    fmu_settle(self);
    fmu_latch_unread(self);
    at = put_state_bytes(at, self->token, strlen(self->token));
    at = put_state_bytes(at, &self->start, sizeof self->start);
    at = put_state_bytes(at, &self->now, sizeof self->now);
    at = put_state_bytes(at, &self->started, sizeof self->started);
    for (size_t i = 0; i < self->count; i++) {
        struct fmu_encoder *encoder = &self->encoders[i];
        const size_t size = dg_host_state_size(encoder->host);
        at = put_state_bytes(at, &encoder->now, sizeof encoder->now);
        const int result = dg_host_save(encoder->host, at, size);
        if (result != DG_HOST_OK) {
            return result;
        }
        at += size;
    }
    const uint32_t sum = dg_crc32(0, to, (size_t)(at - (uint8_t *)to));
    (void)put_state_bytes(at, &sum, sizeof sum);
    return DG_HOST_OK;
}

static const uint8_t *fetch_bytes(const uint8_t *from, void *to, size_t n)
{
    memcpy(to, from, n);
    return from + n;
}

/* A handle keeps the faults of its panel, so those of the state have to be there before. */
static void apply_faults(struct fmu *self, struct fmu_encoder *encoder, const uint64_t faults[2])
{
    for (uint32_t i = 0; i < FMU_FAULTS_MAX; i++) {
        (void)encoder_set_fault(self, encoder, i, (faults[i / 64u] >> i % 64u & 1u) != 0);
    }
}

static bool is_whole(const uint8_t *bytes, size_t n)
{
    uint32_t sum = 0;
    memcpy(&sum, bytes + n - sizeof sum, sizeof sum);
    return dg_crc32(0, bytes, n - sizeof sum) == sum;
}

/* The library looks at its own numbers. A time too far away would be simulated, step by step. */
static bool course_fits(const uint8_t *bytes, uint64_t now)
{
    static const size_t flags[] = {
        offsetof(struct fmu_course, angle_new), offsetof(struct fmu_course, speed_new),
        offsetof(struct fmu_course, power),     offsetof(struct fmu_course, rx),
        offsetof(struct fmu_course, ma),        offsetof(struct fmu_course, taken),
        offsetof(struct fmu_course, configured)};
    const uint64_t longest_frame = UINT64_C(1000000000);
    struct fmu_course course;
    for (size_t i = 0; i < DG_COUNT(flags); i++) {
        if (bytes[flags[i]] > 1) {
            return false;
        }
    }
    memcpy(&course, bytes, sizeof course);
    return course.waiting <= sizeof course.out && course.bus <= DG_HOST_BUS_OFF &&
           (course.busy <= now || course.busy - now <= longest_frame);
}

static bool times_fit(double start, uint64_t now, uint8_t started)
{
    return started <= 1 && fmu_is_small(start, FMU_TIME_MAX) &&
           now <= (uint64_t)FMU_TIME_MAX * 1000000000u;
}

/* Behind the token. Faults come before a handle that has them. @return 0, or a result of host.h */
static int restore_all(struct fmu *self, const uint8_t *at)
{
    uint8_t started;
    at = fetch_bytes(at, &self->start, sizeof self->start);
    at = fetch_bytes(at, &self->now, sizeof self->now);
    at = fetch_bytes(at, &started, sizeof started);
    self->started = started == 1;
    if (!times_fit(self->start, self->now, started)) {
        return DG_HOST_ERR_DAMAGED;
    }
    for (size_t i = 0; i < self->count; i++) {
        struct fmu_encoder *encoder = &self->encoders[i];
        const size_t size = dg_host_state_size(encoder->host);
        struct fmu_course course;
        if (!course_fits(at, self->now)) {
            return DG_HOST_ERR_DAMAGED;
        }
        at = fetch_bytes(at, &course, sizeof course);
        apply_faults(self, encoder, course.faults);
        const int result = dg_host_restore(encoder->host, at, size);
        if (result != DG_HOST_OK || dg_host_next(encoder->host) < self->now) {
            return result != DG_HOST_OK ? result : DG_HOST_ERR_DAMAGED;
        }
        encoder->now = course;
        encoder->unread = false;
        at += size;
    }
    return DG_HOST_OK;
}

/* Importers keep states in files: one that is refused changes nothing. */
int fmu_restore(struct fmu *self, const void *from, size_t n)
{
    const uint8_t *at = from;
    const size_t head = strlen(self->token);
    if (n != fmu_state_size(self) || memcmp(at, self->token, head) != 0) {
        return DG_HOST_ERR_OTHER;
    }
    uint8_t *before = is_whole(at, n) ? malloc(n) : NULL;
    if (before == NULL) {
        return is_whole(at, n) ? DG_HOST_ERR_SPACE : DG_HOST_ERR_DAMAGED;
    }
    int result = fmu_save(self, before, n);
    if (result == DG_HOST_OK) {
        (void)fmu_start(self, self->start); /* only who was on has faults */
        result = restore_all(self, at + head);
    }
    if (result != DG_HOST_OK) {
        (void)restore_all(self, before + head);
    }
    free(before);
    return result;
}
