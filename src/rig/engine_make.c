/* SPDX-License-Identifier: MIT */
/*
 * From a plan to a rig, wire by wire, so that what is wrong is found in the order of the plan:
 *
 *   shaft --> dg_shaft, its gear, its motion
 *   wire  --> its line --> each encoder on it: handle, settings, shaft --> its bus --> attached
 */
#include "engine_private.h"

#include <string.h>

#include "drehgeber/hal.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/shaft.h"

/* ---------------------------------------------------------------- shafts */

static int couple_shaft(struct dg_engine *self, size_t index, struct dg_plan_error *error)
{
    const struct dg_plan *plan = self->setup.plan;
    const struct dg_plan_shaft *row = &plan->shafts[index];

    if (row->driver < 0 || dg_shaft_couple(&self->shafts[index].control.shaft,
                                           &self->shafts[row->driver].control.shaft, row->ratio[0],
                                           row->ratio[1]) == DG_OK) {
        return 0;
    }
    (void)dg_plan_refuse(error, NULL, RIG_SAY("[shaft ", row->name, "]: the gear cannot be"));
    return dg_plan_stand(plan, row->line, error);
}

/* Of words, or of a file of the host's. */
static int find_motion(const struct dg_engine *self, size_t index, struct dg_motion *to,
                       struct dg_plan_error *error)
{
    const char *text = self->setup.plan->shafts[index].motion;

    if (!dg_motion_is_file(text)) {
        return dg_motion_read(to, text, error);
    }
    return self->setup.motion != NULL ? self->setup.motion(self->setup.ctx, index, text, to, error)
                                      : dg_plan_refuse(error, RIG_SAY("expected a motion in words"),
                                                       RIG_SAY(text, ": there are no files here"));
}

/* Encoders look back for their speed: before, the shaft has always been where its motion begins. */
static int begin_shaft_motion(struct dg_engine *self, size_t index, struct dg_plan_error *error)
{
    const struct dg_plan_shaft *row = &self->setup.plan->shafts[index];
    struct engine_shaft *shaft = &self->shafts[index];
    struct dg_motion motion = {.points = NULL};

    if (row->motion == NULL) {
        return 0;
    }
    if (find_motion(self, index, &motion, error) == 0) {
        struct dg_text text = dg_text_in(shaft->profile, sizeof shaft->profile);
        shaft->points = motion.points;
        shaft->point_count = motion.point_count;
        (void)dg_shaft_set_position(&shaft->control.shaft, 0, dg_motion_angle(&motion, 0));
        dg_text_add(&text, row->motion);
        return dg_shaft_play(&shaft->control.shaft, self->setup.begin, &motion);
    }
    (void)dg_plan_about(error, "motion", NULL);
    return dg_plan_stand(self->setup.plan, row->motion_line, error);
}

static int make_shafts(struct dg_engine *self, struct dg_plan_error *error)
{
    int result = 0;

    for (size_t i = 0; result == 0 && i < self->setup.plan->shaft_count; i++) {
        struct dg_rig_shaft *shaft = &self->shafts[i].control;
        shaft->name = self->setup.plan->shafts[i].name;
        shaft->host = self;
        self->control.shafts[i] = shaft;
        dg_shaft_init(&shaft->shaft);
        result = couple_shaft(self, i, error);
        result = result == 0 ? begin_shaft_motion(self, i, error) : result;
    }
    return result;
}

/* ---------------------------------------------------------------- encoders */

static const char *say_no_mode(const void *device, dg_ns now)
{
    (void)device;
    (void)now;
    return "-";
}

static void say_no_state(const void *device, dg_ns now, struct dg_scpi *to)
{
    (void)device;
    (void)now;
    dg_state_word(to, "leds", "-");
    dg_state_word(to, "errors", "-");
}

static const struct dg_damage_row any_region = {.effect = "a check sum is wrong", .chapter = "-"};

/* Of a protocol that the host has none of: what the control plane asks of every encoder. */
static const struct dg_instrument no_instrument = {
    .damage = &any_region,
    .mode = say_no_mode,
    .state = say_no_state,
};

static const struct dg_instrument *instrument_of(const struct dg_engine *self,
                                                 const struct dg_stack *stack)
{
    for (size_t i = 0; i < self->control.instrument_count; i++) {
        if (self->setup.instruments[i]->stack == stack) {
            return self->setup.instruments[i];
        }
    }
    return &no_instrument;
}

/* A handle that sits on its shaft, and what the control plane sees of it. */
static void place_handle(struct dg_engine *self, size_t index, uint8_t *memory)
{
    const struct dg_plan_encoder *row = &self->setup.plan->encoders[index];
    struct engine_encoder *encoder = &self->encoders[index];
    struct dg_rig_shaft *shaft = &self->shafts[row->shaft].control;

    encoder->host = dg_host_init_on_bus(memory, dg_engine_handle_size(&self->setup, row->model),
                                        row->model, dg_bus_side_of(row->model));
    dg_host_shaft_of(encoder->host, &shaft->shaft);
    dg_host_world(encoder->host)->calm = dg_shaft_calm;
    encoder->control = (struct dg_encoder){
        .name = row->name,
        .model = row->model,
        .instrument = instrument_of(self, row->model->stack),
        .world = dg_host_world(encoder->host),
        .shaft = shaft,
        .faults = {.random = (uint32_t)index},
        .host = encoder,
    };
    self->control.encoders[index] = &encoder->control;
}

/* Those of each wire in the order of the plan. */
static void gather_encoders(struct dg_engine *self)
{
    uint8_t *memory = self->handles;

    for (size_t i = 0; i < self->setup.plan->wire_count; i++) {
        self->wires[i].first = ENGINE_NOBODY;
    }
    for (size_t i = 0; i < self->setup.plan->encoder_count; i++) {
        const struct dg_plan_encoder *row = &self->setup.plan->encoders[i];
        struct engine_wire *wire = &self->wires[row->wire];
        place_handle(self, i, memory);
        memory += dg_engine_handle_size(&self->setup, row->model);
        self->encoders[i].next = ENGINE_NOBODY;
        if (wire->first == ENGINE_NOBODY) {
            wire->first = i;
        } else {
            self->encoders[i].place = self->encoders[wire->last].place + 1u;
            self->encoders[wire->last].next = i;
        }
        wire->last = i;
    }
}

/* ---------------------------------------------------------------- wires */

static void hear_nobody(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    (void)place;
    (void)event;
}

static struct dg_engine_line line_usual(void)
{
    return (struct dg_engine_line){.pace = dg_plan_pace_usual,
                                   .timing = dg_plan_timing_usual,
                                   .ring = dg_plan_ring_usual,
                                   .simulation = dg_plan_simulation_usual};
}

/* As the plan has it; what waits and what comes in lies behind the bus. */
static void describe_wire(const struct dg_engine *self, struct engine_wire *wire, void *room)
{
    static const struct dg_bus_ops nobody = {.tx = hear_nobody};
    struct dg_engine_wire *is = &wire->is;
    const size_t count = is->plan->encoder_count;

    is->ops = &nobody;
    is->characters = (struct dg_characters_setup){.size = sizeof is->characters, .paced = true};
    is->frames = (struct dg_bus_frames_setup){.size = sizeof is->frames,
                                              .room = room,
                                              .rooms = dg_engine_rooms(&self->setup, count),
                                              .pace = is->line.pace};
    is->edges = (struct dg_bus_edges_setup){.size = sizeof is->edges,
                                            .there_ns = is->line.timing.line_delay_ns,
                                            .back_ns = is->line.timing.line_delay_ns};
    is->words = (struct dg_bus_words_setup){.size = sizeof is->words,
                                            .in = room,
                                            .words = count * DG_RING_WORDS_MAX,
                                            .identifies = true};
}

static const void *medium_setup(const struct dg_engine_wire *self)
{
    const void *const setups[] = {
        [DG_MEDIUM_CHARACTERS] = &self->characters,
        [DG_MEDIUM_FRAMES] = &self->frames,
        [DG_MEDIUM_EDGES] = &self->edges,
        [DG_MEDIUM_WORDS] = &self->words,
    };
    _Static_assert(DG_COUNT(setups) == DG_MEDIUM_COUNT, "each has one");

    return setups[self->plan->stack->medium];
}

/* All that is wrong with the settings of a bus was found by their rows. */
static int make_bus(struct engine_wire *wire, void *memory)
{
    const struct dg_bus_setup setup = {.size = sizeof setup,
                                       .medium = dg_engine_medium(wire->is.plan),
                                       .encoders = wire->is.plan->encoder_count,
                                       .wire = medium_setup(&wire->is),
                                       .ops = wire->is.ops,
                                       .ctx = wire->is.ctx};

    wire->bus = dg_bus_init(memory, dg_engine_bus_size(wire->is.plan), &setup);
    return wire->bus != NULL ? 0 : -1;
}

static int refuse_full_wire(const struct dg_engine *self, size_t index, struct dg_plan_error *error)
{
    const struct dg_plan_encoder *row = &self->setup.plan->encoders[index];
    const size_t place = self->encoders[index].place;

    if (place > 0 && self->setup.plan->wires[row->wire].stack == row->model->stack) {
        (void)dg_plan_refuse(error, NULL,
                             RIG_SAY("this wire is full: expected at most ",
                                     dg_plan_number(place).text, " encoders"));
    } else {
        (void)dg_plan_refuse(error, NULL, RIG_SAY(row->model->name, " cannot be on this wire"));
    }
    return dg_plan_stand(self->setup.plan, row->line, error);
}

static int attach_all(struct dg_engine *self, const struct engine_wire *wire,
                      struct dg_plan_error *error)
{
    for (size_t i = wire->first; i != ENGINE_NOBODY; i = self->encoders[i].next) {
        struct engine_encoder *encoder = &self->encoders[i];
        const bool controlled = encoder->control.instrument != &no_instrument;
        const struct dg_characters_end end = {.any_line = encoder->end.any_line,
                                              .at_once = !encoder->end.pace};
        if (dg_bus_attach(wire->bus, encoder->host, controlled ? &encoder->control : NULL) < 0) {
            return refuse_full_wire(self, i, error);
        }
        if (wire->is.plan->stack->medium == DG_MEDIUM_CHARACTERS) {
            dg_bus_characters_set(wire->bus, encoder->place, &end);
        }
    }
    if (wire->is.plan->stack->medium == DG_MEDIUM_WORDS) {
        dg_ring_cut(wire->bus, wire->is.line.ring.break_at);
    }
    return 0;
}

/* Its own settings, and the door. Behind the memory of the bus is its room. */
static int begin_wire(struct dg_engine *self, size_t index, uint8_t *memory,
                      struct dg_plan_error *error)
{
    const struct dg_plan_wire *plan = &self->setup.plan->wires[index];
    struct engine_wire *wire = &self->wires[index];
    uint8_t *room = memory + dg_engine_bus_size(plan);

    wire->is.plan = plan;
    wire->is.line = line_usual();
    if (dg_engine_line_read(self->setup.plan, plan, &wire->is.line, error) != 0) {
        return -1;
    }
    memset(room, 0,
           plan->stack->medium == DG_MEDIUM_WORDS ? dg_engine_room_size(&self->setup, plan) : 0);
    describe_wire(self, wire, room);
    return self->setup.wire == NULL ? 0
                                    : self->setup.wire(self->setup.ctx, index, &wire->is, error);
}

/* One that does not mind its pace speaks for its whole line. */
static int set_encoders(struct dg_engine *self, struct engine_wire *wire,
                        struct dg_plan_error *error)
{
    for (size_t i = wire->first; i != ENGINE_NOBODY; i = self->encoders[i].next) {
        if (dg_engine_set_encoder(self, i, error) != 0) {
            return -1;
        }
        wire->is.characters.paced = wire->is.characters.paced && self->encoders[i].end.pace;
    }
    return 0;
}

/* @param memory of its bus and what is behind it */
static int make_wire(struct dg_engine *self, size_t index, uint8_t *memory,
                     struct dg_plan_error *error)
{
    struct engine_wire *wire = &self->wires[index];

    if (begin_wire(self, index, memory, error) != 0 || set_encoders(self, wire, error) != 0) {
        return -1;
    }
    if (make_bus(wire, memory) != 0) {
        (void)dg_plan_refuse(error, NULL,
                             RIG_SAY("[bus ", wire->is.plan->name, "]: the host has no such bus"));
        return dg_plan_stand(self->setup.plan, wire->is.plan->line, error);
    }
    return attach_all(self, wire, error);
}

static int make_wires(struct dg_engine *self, struct dg_plan_error *error)
{
    const struct dg_plan *plan = self->setup.plan;
    uint8_t *memory = self->buses;
    int result = 0;

    for (size_t i = 0; result == 0 && i < plan->wire_count; i++) {
        result = make_wire(self, i, memory, error);
        memory += dg_engine_bus_size(&plan->wires[i]) +
                  dg_engine_room_size(&self->setup, &plan->wires[i]);
    }
    return result;
}

/* ---------------------------------------------------------------- all of it */

static void make_control(struct dg_engine *self)
{
    struct dg_rig *control = &self->control;

    control->encoder_count = self->setup.plan->encoder_count;
    control->shaft_count = self->setup.plan->shaft_count;
    control->instruments = self->setup.instruments;
    control->instrument_count = self->setup.instruments == NULL ? 0 : self->setup.instrument_count;
    control->origin = self->setup.begin;
    control->ops = self->setup.ops != NULL ? self->setup.ops : &dg_engine_ops;
    control->host = self;
}

struct dg_engine *dg_engine_make(void *memory, size_t size, const struct dg_engine_setup *setup,
                                 struct dg_plan_error *error)
{
    struct dg_engine *self = memory;
    const size_t needed = dg_engine_size(setup);

    if (needed == 0) {
        (void)dg_plan_refuse(
            error, NULL,
            RIG_SAY("no setup of this version, or a wire with no encoders or too many"));
        return NULL;
    }
    if (memory == NULL || size < needed || (uintptr_t)memory % DG_HOST_ALIGN != 0) {
        (void)dg_plan_refuse(error, RIG_SAY("expected ", dg_plan_number(needed).text, " bytes"),
                             RIG_SAY("no memory for a rig"));
        return NULL;
    }
    dg_engine_lay_out(self, setup);
    make_control(self);
    gather_encoders(self);
    return make_shafts(self, error) == 0 && make_wires(self, error) == 0 &&
                   dg_engine_begin_courses(self, error) == 0
               ? self
               : NULL;
}
