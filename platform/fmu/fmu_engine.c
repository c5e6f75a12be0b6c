/* SPDX-License-Identifier: MIT */
/*
 * A rig on the library's engine (rig_engine.h). Whatever encoders do with each other is in there.
 * Here are the doors: what a bus carries waits for the importer, and what that sends goes to the
 * bus.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/hal.h"
#include "drehgeber/instruments.h"
#include "fmu_engine.h"

/* 10^-9 rpm, which is as fine as a double tells it, in the unit of dg_shaft_turn(). */
#define SPEED_STEP INT64_C(1000)
#define SPEED_MAX (INT64_C(1000000000) * DG_MOTION_SPEED_MAX_MRPM)

/* --- points --- */

static void free_rig_points(struct fmu_rig *self)
{
    while (self->points != NULL) {
        struct point_list *next = self->points->next;
        free(self->points->points);
        free(self->points);
        self->points = next;
    }
}

/* @return NULL without points or memory, with `error` */
static struct point_list *keep_rig_points(struct fmu_rig *self, void *points,
                                          struct dg_plan_error *error)
{
    struct point_list *row = points == NULL ? NULL : calloc(1, sizeof *row);
    if (row == NULL) {
        free(points);
        memset(error, 0, sizeof *error);
        (void)snprintf(error->what, sizeof error->what, "it is not in the FMU");
        return NULL;
    }
    row->points = points;
    row->next = self->points;
    self->points = row;
    return row;
}

static int find_rig_motion(void *ctx, size_t index, const char *path, struct dg_motion *to,
                           struct dg_plan_error *error)
{
    struct fmu_rig *self = ctx;
    struct dg_motion_point *points;
    const size_t count =
        fmu_bundle_motion(&self->bundle, self->plan.shafts[index].motion_line, &points);
    (void)path;
    if (keep_rig_points(self, points, error) == NULL) {
        return -1;
    }
    *to = (struct dg_motion){.kind = DG_MOTION_REPLAY, .points = points, .point_count = count};
    return 0;
}

static struct dg_rig_course *find_rig_course(void *ctx, size_t index,
                                             const struct dg_plan_setting *setting,
                                             struct dg_plan_error *error)
{
    struct fmu_rig *self = ctx;
    struct dg_course_point *points;
    const size_t count = fmu_bundle_course(&self->bundle, setting->line, &points);
    struct point_list *row = keep_rig_points(self, points, error);
    (void)index;
    if (row == NULL) {
        return NULL;
    }
    row->course = (struct dg_rig_course){.course = {.points = points, .count = count}};
    return &row->course;
}

/* --- what a wire carries --- */

static struct fmu_encoder *encoder_at_place(const struct rig_wire *wire, size_t place)
{
    const struct fmu_rig *rig = wire->all->rig;
    size_t i = 0;
    while (rig->plan.encoders[i].wire != wire->index || dg_engine_place(rig->engine, i) != place) {
        i++;
    }
    return &wire->all->encoders[i];
}

static void tell_importer_frame(const struct rig_wire *wire, size_t place,
                                const struct dg_tap_event *event)
{
    struct dg_host_event frame = {.at = event->at,
                                  .id = event->frame.id,
                                  .flags = event->frame.rtr ? DG_HOST_REMOTE : 0,
                                  .kind = DG_HOST_CAN,
                                  .length = event->frame.dlc};
    memcpy(frame.data, event->frame.data, event->frame.dlc);
    wire_configure(wire->leader);
    wire_put(wire->leader, encoder_at_place(wire, place), &frame);
}

/* A bus tells a character when it is over. */
static void tell_importer_character(const struct rig_wire *wire, size_t place,
                                    const struct dg_tap_event *event)
{
    const struct dg_host_uart uart =
        dg_bus_characters_uart(dg_engine_bus(wire->all->rig->engine, wire->index), place);
    const uint64_t each = dg_host_uart_ns(&uart, 1);
    const struct dg_host_event character = {
        .at = event->at > each ? event->at - each : 0,
        .id = (uint32_t)each,
        .flags = event->character.damaged ? DG_HOST_DAMAGED : 0,
        .kind = DG_HOST_BYTES,
        .length = 1,
        .data = {event->character.byte},
    };
    if (!wire_join(wire->leader, &character)) {
        wire_put(wire->leader, wire->leader, &character);
    }
}

static void tell_importer(void *ctx, size_t place, const struct dg_tap_event *event)
{
    const struct rig_wire *wire = ctx;
    if (event->kind == DG_TAP_FRAME) {
        tell_importer_frame(wire, place, event);
    } else if (event->kind == DG_TAP_CHARACTER) {
        tell_importer_character(wire, place, event);
    }
}

static int open_rig_door(void *ctx, size_t index, struct dg_engine_wire *to,
                         struct dg_plan_error *error)
{
    static const struct dg_bus_ops door = {.tx = tell_importer};
    struct fmu_rig *self = ctx;
    (void)error;
    to->ops = &door;
    to->ctx = &self->wires[index];
    to->frames.line.closed = true; /* until the power is on */
    return 0;
}

/* --- making one --- */

static bool take_handles(struct fmu *all)
{
    for (size_t i = 0; i < all->count; i++) {
        struct fmu_encoder *encoder = &all->encoders[i];
        encoder->host = dg_engine_encoder(all->rig->engine, i);
        encoder->has = encoder_has(encoder->host);
        if (encoder->has == 0) {
            return false;
        }
        encoder->has &= encoder->shares ? ~(unsigned)FMU_HAS_MASTER : ~0u;
    }
    return true;
}

static int make_rig_engine(struct fmu *all)
{
    struct fmu_rig *self = all->rig;
    struct dg_plan_error ignored;
    const struct dg_engine_setup setup = {
        .size = sizeof setup,
        .plan = &self->plan,
        .instruments = dg_instruments,
        .instrument_count = dg_instrument_count,
        .wire = open_rig_door,
        .motion = find_rig_motion,
        .course = find_rig_course,
        .ctx = self,
    };
    const size_t size = dg_engine_size(&setup);
    free_rig_points(self);
    self->memory = self->memory == NULL ? calloc(1, size + DG_HOST_ALIGN) : self->memory;
    self->engine = self->memory == NULL
                       ? NULL
                       : dg_engine_make(encoder_aligned(self->memory), size, &setup,
                                        self->error != NULL ? self->error : &ignored);
    self->error = NULL;
    return self->engine != NULL && take_handles(all) ? 0 : -1;
}

static void free_rig_parts(struct fmu *all)
{
    struct fmu_rig *self = all->rig;
    free_rig_points(self);
    while (self->models != NULL) {
        struct shelf_model *next = self->models->next;
        free(self->models->of.made);
        free(self->models);
        self->models = next;
    }
    free(self->memory);
    free(self->wires);
    free(self->plan_memory);
    free(self->file);
    free(self->bundle.text);
    free(self);
}

/* --- what is done to it --- */

static struct dg_rig *rig_control_of(const struct fmu *all)
{
    return dg_engine_control(all->rig->engine);
}

static size_t index_in_rig(const struct fmu_encoder *self)
{
    return (size_t)(self - self->all->encoders);
}

static struct dg_encoder *control_of_encoder(const struct fmu_encoder *self)
{
    return rig_control_of(self->all)->encoders[index_in_rig(self)];
}

static struct dg_bus *rig_bus_of(const struct fmu_encoder *self)
{
    const struct fmu_rig *rig = self->all->rig;
    return dg_engine_bus(rig->engine, rig->plan.encoders[index_in_rig(self)].wire);
}

/* What was due before has met what was before. */
static void look_at_rig(const struct fmu_encoder *self)
{
    struct dg_rig *control = rig_control_of(self->all);
    control->ops->look(control, control_of_encoder(self), self->all->now);
}

static void tell_rig_change(const struct fmu_encoder *self)
{
    struct dg_rig *control = rig_control_of(self->all);
    dg_rig_watch(control, control_of_encoder(self));
    control->ops->changed(control, control_of_encoder(self), self->all->now);
}

static int power_rig_encoder(struct fmu_encoder *self)
{
    struct dg_plan_error ignored;
    return dg_engine_power_encoder(self->all->rig->engine, index_in_rig(self), 0, &ignored);
}

/* What those that are off say while they are made is nowhere. */
static int make_idle_encoders(struct fmu *all)
{
    int result = DG_HOST_OK;
    for (size_t i = 0; i < all->count && result == DG_HOST_OK; i++) {
        if (!all->encoders[i].now.power) {
            result = power_rig_encoder(&all->encoders[i]);
            (void)dg_host_power(all->encoders[i].host, 0, false);
        }
    }
    return result;
}

static void open_buses(const struct fmu *all)
{
    static const struct dg_bus_frames_line line = {.company = DG_BUS_SOMEBODY};
    const struct dg_plan *plan = &all->rig->plan;
    for (size_t i = 0; i < plan->wire_count; i++) {
        if (plan->wires[i].stack->medium == DG_MEDIUM_FRAMES) {
            (void)dg_bus_frames_set_line(dg_engine_bus(all->rig->engine, i), &line);
        }
    }
}

static int power_rig_encoders(struct fmu *all)
{
    int result = make_idle_encoders(all);
    open_buses(all);
    for (size_t i = 0; i < all->count && result == DG_HOST_OK; i++) {
        result = all->encoders[i].now.power ? power_rig_encoder(&all->encoders[i]) : DG_HOST_OK;
    }
    for (size_t i = 0; i < all->count && result == DG_HOST_OK; i++) {
        tell_rig_change(&all->encoders[i]);
    }
    return result;
}

static int64_t speed_of(double rad_s)
{
    const double steps = rad_s * (30e12 / 3.141592653589793238463 / (double)SPEED_STEP);
    const int64_t most = SPEED_MAX / SPEED_STEP;
    const double limit = (double)most;
    if (!(steps > -limit)) {
        return -SPEED_MAX;
    }
    return steps < limit ? fmu_nearest(steps) * SPEED_STEP : SPEED_MAX;
}

/* Before the power nobody looks. */
static void turn_rig_shaft(struct fmu *all, size_t index, uint64_t at, const int64_t *angle,
                           double rad_s)
{
    struct dg_rig *control = rig_control_of(all);
    struct dg_rig_shaft *shaft = control->shafts[index];
    const bool on = dg_host_made(all->encoders[0].host);
    if (on) {
        control->ops->turns(control, shaft, all->now);
    }
    (void)dg_shaft_turn(&shaft->shaft, at,
                        angle != NULL ? *angle : dg_shaft_angle(&shaft->shaft, at),
                        speed_of(rad_s));
    if (on) {
        control->ops->turned(control, shaft, all->now);
    }
}

static int power_in_rig(struct fmu_encoder *self, bool on)
{
    look_at_rig(self);
    const int result = dg_host_power(self->host, self->all->now, on);
    tell_rig_change(self);
    return result;
}

/* From now on it is that, whatever bent it, or was to. */
static int sense_quantity(struct fmu_encoder *self, const char *quantity, int64_t value)
{
    struct dg_encoder *control = control_of_encoder(self);
    const struct dg_key *row = dg_keys_find(&dg_world_keys, quantity);
    const size_t index = row == NULL ? 0 : (size_t)(row - dg_world_keys.rows);
    if (!dg_host_made(self->host)) {
        return dg_host_world_set(self->host, 0, quantity, value);
    }
    look_at_rig(self);
    const int result = dg_host_world_set(self->host, self->all->now, quantity, value);
    if (result == DG_HOST_OK && row != NULL) {
        const struct dg_fault_target target = dg_encoder_target(control);
        dg_rig_unfollow(rig_control_of(self->all), control, index);
        dg_fault_override(&control->faults, &target, dg_quantities[index].offset);
    }
    tell_rig_change(self);
    return result;
}

static int find_rig_fault(struct fmu_encoder *self, size_t index, struct dg_host_fault *to)
{
    struct dg_fault_entry entry;
    if (!dg_host_made(self->host)) {
        return DG_HOST_ERR_STATE;
    }
    const struct dg_fault_target target = dg_encoder_target(control_of_encoder(self));
    if (!dg_fault_entry(&target, index, &entry)) {
        return DG_HOST_ERR_NAME;
    }
    *to = (struct dg_host_fault){.cause = entry.cause, .effect = entry.effect};
    memcpy(to->name, entry.name, sizeof to->name);
    return DG_HOST_OK;
}

static int set_rig_fault(struct fmu_encoder *self, size_t index, bool on)
{
    static const struct dg_fault_limits usual = {.probability_ppm = 1000000, .duration = DG_NEVER};
    struct dg_encoder *control = control_of_encoder(self);
    struct dg_host_fault entry;
    int result = find_rig_fault(self, index, &entry);
    if (result != DG_HOST_OK) {
        return result;
    }
    look_at_rig(self);
    const struct dg_fault_target target = dg_encoder_target(control);
    result = on ? dg_fault_set(&control->faults, &target, index, self->all->now, &usual)
                : dg_fault_clear(&control->faults, &target, index);
    tell_rig_change(self);
    return result;
}

/* Of an encoder alone on its wire, at its end of that. */
static int read_rig_frame(struct fmu_encoder *self, struct dg_host_frame *to)
{
    look_at_rig(self);
    const int result = dg_host_frame(self->host, self->all->now, to);
    tell_rig_change(self);
    return result;
}

/* --- what an importer sends --- */

static int send_to_bus(struct fmu_encoder *self, const struct dg_host_event *event)
{
    if (event->kind == DG_HOST_BUS) {
        (void)dg_bus_frames_controller(rig_bus_of(self), event->at, (enum dg_host_bus)event->id);
        return DG_HOST_OK;
    }
    if (event->id > 0x7FFu) {
        return DG_HOST_ERR_ARGUMENT;
    }
    struct dg_tap_event frame = {
        .at = event->at,
        .kind = DG_TAP_FRAME,
        .frame = {.id = (uint16_t)event->id,
                  .rtr = (event->flags & DG_HOST_REMOTE) != 0,
                  .dlc = event->length},
    };
    memcpy(frame.frame.data, event->data, event->length);
    (void)dg_bus_rx(rig_bus_of(self), &frame);
    return DG_HOST_OK;
}

/* Which data rate it is, if characters take so long: that of the encoders, or another one. */
static uint32_t baud_of(const struct dg_host_uart *uart, uint32_t each)
{
    const uint64_t bits = uart->parity == 'N' ? 10 : 11;
    return each == 0 || each == dg_host_uart_ns(uart, 1)
               ? DG_BAUD_ANY
               : (uint32_t)((bits * UINT64_C(1000000000) + each / 2u) / each);
}

/* They begin now; the bus lets each take its time. */
static void deliver_characters(struct fmu_encoder *self, uint64_t at, const uint8_t *head, size_t n)
{
    const struct dg_host_uart uart = dg_bus_characters_uart(rig_bus_of(self), 0);
    for (size_t i = 0; i < n; i++) {
        const struct dg_tap_event event = {
            .at = at,
            .kind = DG_TAP_CHARACTER,
            .character = {.baud = baud_of(&uart, wire_each(head)),
                          .parity = (char)uart.parity,
                          .byte = head[FMU_SERIAL_SIZE + i],
                          .damaged = (head[14] & DG_HOST_DAMAGED) != 0},
        };
        (void)dg_bus_rx(rig_bus_of(self), &event);
    }
}

/* What begins later waits for its moment. */
static int say_to_bus(struct fmu_encoder *self, uint64_t at, const uint8_t *head, size_t n)
{
    const size_t size = FMU_SERIAL_SIZE + n;
    if (at <= self->all->now && self->now.coming == 0) {
        deliver_characters(self, at, head, n);
        return DG_HOST_OK;
    }
    if (size > self->room - self->now.coming) {
        return DG_HOST_ERR_SPACE;
    }
    memcpy(self->in + self->now.coming, head, size);
    self->now.coming += (uint32_t)size;
    return DG_HOST_OK;
}

/* DG_NEVER: nothing does. */
static uint64_t next_to_come(const struct fmu_encoder *self)
{
    return self->now.coming == 0 ? DG_NEVER : wire_moment(self->in);
}

static void take_coming(struct fmu_encoder *self, uint64_t now)
{
    const size_t size = FMU_SERIAL_SIZE + wire_count(self->in);
    deliver_characters(self, now, self->in, size - FMU_SERIAL_SIZE);
    self->now.coming -= (uint32_t)size;
    memmove(self->in, self->in + size, self->now.coming);
}

/* --- time --- */

static uint64_t first_to_come(const struct fmu *all)
{
    uint64_t first = DG_NEVER;
    for (size_t i = 0; i < all->count; i++) {
        const uint64_t at = next_to_come(&all->encoders[i]);
        first = at < first ? at : first;
    }
    return first;
}

static void run_rig(struct fmu *all, uint64_t to)
{
    for (uint64_t at = first_to_come(all); at <= to; at = first_to_come(all)) {
        (void)dg_engine_step(all->rig->engine, at);
        for (size_t i = 0; i < all->count; i++) {
            if (next_to_come(&all->encoders[i]) <= at) {
                take_coming(&all->encoders[i], at);
            }
        }
    }
    (void)dg_engine_step(all->rig->engine, to);
    for (size_t i = 0; i < all->count; i++) {
        struct fmu_encoder *encoder = &all->encoders[i];
        if ((encoder->has & FMU_HAS_FRAMES) != 0) {
            wire_follow(encoder);
        }
    }
}

static uint64_t next_of_rig(const struct fmu *all)
{
    const uint64_t next = dg_engine_next(all->rig->engine);
    const uint64_t first = first_to_come(all);
    return first < next ? first : next;
}

static int64_t bus_bit_rate_of(const struct fmu_encoder *self)
{
    return dg_bus_frames_bit_rate(rig_bus_of(self));
}

/* --- states --- */

static size_t rig_state_size(const struct fmu *all)
{
    return dg_engine_state_size(all->rig->engine);
}

static int save_rig_state(struct fmu *all, uint8_t *to)
{
    return dg_engine_save(all->rig->engine, to, rig_state_size(all));
}

static int restore_rig(struct fmu *all, const uint8_t *from, size_t n)
{
    return dg_engine_restore(all->rig->engine, from, n);
}

const struct fmu_ops fmu_rig_ops = {
    .make = make_rig_engine,
    .free = free_rig_parts,
    .start = power_rig_encoders,
    .turn = turn_rig_shaft,
    .power = power_in_rig,
    .sense = sense_quantity,
    .entry = find_rig_fault,
    .fault = set_rig_fault,
    .frame = read_rig_frame,
    .send = send_to_bus,
    .say = say_to_bus,
    .bit_rate = bus_bit_rate_of,
    .run = run_rig,
    .next = next_of_rig,
    .state_size = rig_state_size,
    .save = save_rig_state,
    .restore = restore_rig,
};
