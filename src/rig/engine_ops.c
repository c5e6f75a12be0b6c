/* SPDX-License-Identifier: MIT */
/* What the control plane asks of a rig and a rig can do by itself: nothing of it touches a file. */
#include "drehgeber/hal.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/instrument.h"
#include "engine_private.h"

static struct dg_engine *engine_of(struct dg_rig *control)
{
    return control->host;
}

static const struct engine_encoder *view_of(const struct dg_encoder *encoder)
{
    return encoder->host;
}

static int refuse_operation(enum dg_scpi_error code, char *detail, const char *text)
{
    struct dg_text to = dg_text_in(detail, DG_SCPI_DETAIL_MAX + 1u);

    dg_text_add(&to, text);
    return code;
}

static void wake_host(const struct dg_engine *self)
{
    if (self->setup.woken != NULL) {
        self->setup.woken(self->setup.ctx);
    }
}

/* ---------------------------------------------------------------- encoders */

static void look_at_encoder(struct dg_rig *control, struct dg_encoder *encoder, dg_ns now)
{
    dg_bus_look(dg_engine_bus_of(engine_of(control), view_of(encoder)), now);
}

static void change_encoder(const struct dg_engine *self, const struct dg_encoder *encoder,
                           dg_ns now)
{
    const struct engine_encoder *part = view_of(encoder);

    (void)dg_bus_changed(dg_engine_bus_of(self, part), part->place, now);
}

static void changed(struct dg_rig *control, struct dg_encoder *encoder, dg_ns now)
{
    const struct dg_engine *self = engine_of(control);

    if (encoder != NULL) {
        change_encoder(self, encoder, now);
    }
    wake_host(self);
}

/* "can:vcan0/5": the address of the wire and, where there is one, of the encoder on it. */
static void say_address(const struct dg_engine *self, size_t index, struct dg_text *to)
{
    const struct dg_plan_encoder *row = &self->setup.plan->encoders[index];
    const struct dg_plan_wire *wire = &self->setup.plan->wires[row->wire];
    const struct dg_bus_side *side = dg_host_side_at(self->encoders[index].host);

    dg_plan_add(to, RIG_SAY(wire->kind->name, ":", wire->where != NULL ? wire->where : ""));
    if (side->controller != NULL) {
        const void *device = dg_host_line_of(self->encoders[index].host)->device;
        dg_plan_add(to, RIG_SAY("/", dg_plan_number(side->controller->address(device)).text));
    } else if (side->ring != NULL) {
        dg_plan_add(to, RIG_SAY("/", dg_plan_number(self->encoders[index].place).text));
    }
}

static const char *wire(struct dg_rig *control, const struct dg_encoder *encoder)
{
    struct dg_engine *self = engine_of(control);
    const size_t index = dg_engine_index(control, encoder);
    struct dg_text to = dg_text_in(self->address, sizeof self->address);

    if (self->setup.address != NULL) {
        self->setup.address(self->setup.ctx, index, self->address, sizeof self->address);
    } else {
        say_address(self, index, &to);
    }
    return self->address;
}

static size_t find(struct dg_rig *control, const char *name)
{
    const int at = dg_plan_find_encoder(engine_of(control)->setup.plan, name);

    return at < 0 ? control->encoder_count : (size_t)at;
}

/* ---------------------------------------------------------------- counters */

static void count_characters(const struct dg_bus *bus, size_t place, struct dg_scpi *to)
{
    const struct dg_characters_counters counted = dg_bus_characters_counters(bus);

    dg_state_number(to, "wire_collided", counted.collided);
    dg_state_number(to, "wire_baud", dg_bus_characters_uart(bus, place).baud);
    dg_state_number(to, "wire_overrun", counted.overrun);
}

static void count_frames(const struct dg_bus *bus, size_t place, struct dg_scpi *to)
{
    const struct dg_bus_frames_counters *counted = dg_bus_frames_counters(bus);
    struct dg_host *host = dg_bus_encoder(bus, place);
    const void *device = dg_host_line_of(host)->device;

    dg_state_number(to, "wire_stalls", counted->stalls);
    dg_state_number(to, "wire_lost", counted->lost);
    dg_state_number(to, "wire_kbaud", dg_host_side_at(host)->controller->bit_rate(device) / 1000u);
}

static void count_words(const struct dg_bus *bus, size_t place, struct dg_scpi *to)
{
    const struct dg_ring_counters *counted = &dg_ring_state(bus)->counters;

    (void)place;
    dg_state_number(to, "wire_cycles", counted->cycles);
    dg_state_number(to, "wire_ids", counted->ids);
    dg_state_number(to, "wire_crc_errors", counted->crc_errors);
    dg_state_number(to, "wire_interrupted", counted->interrupted);
}

/* What a host's port counts comes in front. */
static void counters(struct dg_rig *control, const struct dg_encoder *encoder, struct dg_scpi *to)
{
    static void (*const rows[DG_MEDIUM_COUNT])(const struct dg_bus *bus, size_t place,
                                               struct dg_scpi *to) = {
        [DG_MEDIUM_CHARACTERS] = count_characters,
        [DG_MEDIUM_FRAMES] = count_frames,
        [DG_MEDIUM_WORDS] = count_words,
    };
    const struct dg_engine *self = engine_of(control);
    const enum dg_medium medium = encoder->model->stack->medium;

    if (self->setup.counters != NULL) {
        self->setup.counters(self->setup.ctx, dg_engine_index(control, encoder), to);
    }
    if (rows[medium] != NULL) {
        rows[medium](dg_engine_bus_of(self, view_of(encoder)), view_of(encoder)->place, to);
    }
}

/* ---------------------------------------------------------------- shafts */

/* Whether `shaft` is this one, or drives it. */
static bool turns_with(const struct dg_encoder *encoder, const struct dg_rig_shaft *shaft)
{
    const struct dg_shaft *at = &encoder->shaft->shaft;

    while (at != NULL && at != &shaft->shaft) {
        at = at->driver;
    }
    return at != NULL;
}

/* What encoders that sleep while their shaft stands have not looked at yet. */
static void turns(struct dg_rig *control, struct dg_rig_shaft *shaft, dg_ns now)
{
    for (size_t i = 0; i < control->encoder_count; i++) {
        if (turns_with(control->encoders[i], shaft)) {
            look_at_encoder(control, control->encoders[i], now);
        }
    }
}

static void turned(struct dg_rig *control, struct dg_rig_shaft *shaft, dg_ns now)
{
    for (size_t i = 0; i < control->encoder_count; i++) {
        if (turns_with(control->encoders[i], shaft)) {
            change_encoder(engine_of(control), control->encoders[i], now);
        }
    }
    wake_host(engine_of(control));
}

/* What was wrong with a motion and, if there is room, what would be right: that is always said. */
static int refuse_words(const struct dg_plan_error *error, char *detail)
{
    char line[DG_SCPI_DETAIL_MAX + 2u];
    struct dg_text text = dg_text_in(line, sizeof line);

    dg_plan_add(&text, RIG_SAY(error->what, "; ", error->right));
    return refuse_operation(DG_SCPI_ILLEGAL, detail,
                            text.length > DG_SCPI_DETAIL_MAX ? error->what : line);
}

static int profile(struct dg_rig *control, struct dg_rig_shaft *shaft, dg_ns now, const char *text,
                   char *detail)
{
    struct engine_shaft *part = (struct engine_shaft *)shaft;
    struct dg_plan_error error;
    struct dg_motion motion;

    (void)control;
    if (shaft->shaft.driver != NULL) {
        return refuse_operation(DG_SCPI_CONFLICT, detail, "geared; its driver turns it");
    }
    if (dg_motion_is_file(text)) {
        return refuse_operation(DG_SCPI_FILE_NAME, detail, "there are no files here");
    }
    if (dg_motion_read(&motion, text, &error) != DG_OK) {
        return refuse_words(&error, detail);
    }
    (void)dg_shaft_play(&shaft->shaft, now, &motion); /* whatever was read, can be played */
    struct dg_text to = dg_text_in(part->profile, sizeof part->profile);
    dg_text_add(&to, text);
    return 0;
}

static const char *profile_text(struct dg_rig *control, const struct dg_rig_shaft *shaft)
{
    const struct engine_shaft *part = (const struct engine_shaft *)shaft;
    const struct dg_engine *self = engine_of(control);

    if (shaft->shaft.driver != NULL) {
        return "geared";
    }
    if (shaft->shaft.course.plays && part->profile[0] != '\0') {
        return part->profile;
    }
    return dg_shaft_mrpm(&shaft->shaft, self->now) == 0 ? "rest" : "steered";
}

const struct dg_rig_ops dg_engine_ops = {
    .changed = changed,
    .wire = wire,
    .counters = counters,
    .profile = profile,
    .profile_text = profile_text,
    .look = look_at_encoder,
    .turns = turns,
    .turned = turned,
    .find = find,
};
