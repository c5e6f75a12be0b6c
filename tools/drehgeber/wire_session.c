/* SPDX-License-Identifier: MIT */
#include "wire_session.h"

#include <stdio.h>
#include <string.h>

#include "run.h"

/* Shown of an idle wire in front of the first edge. */
#define TRACE_AHEAD DG_US(1)

const char *take_word(struct words *words)
{
    if (words->count == 0) {
        return NULL;
    }
    words->count--;
    return *words->at++;
}

/* --- open, close --- */

/* Only a rig lets the world go on. */
static int refuse_courses(const struct dg_plan_settings *settings, struct lx_error *error)
{
    for (size_t i = 0; i < settings->count; i++) {
        const struct dg_plan_setting *row = &settings->list[i];
        if (dg_keys_find(&dg_world_keys, row->key) != NULL && dg_course_is(row->value)) {
            (void)lx_refuse(error, "expected a value", "only run has courses");
            return lx_about(error, LX_ABOUT_SETTING, row->key, row->value);
        }
    }
    return 0;
}

static const struct lx_stack *stack_of(const struct wire_session *self)
{
    return lx_stack_of(self->plan.encoders[0].model);
}

static int read_options(struct wire_session *self, const struct options *options,
                        struct lx_error *error)
{
    if (options_plan(options, &self->plan, error) != 0 ||
        refuse_courses(&self->plan.encoders[0].settings, error) != 0) {
        return -1;
    }
    if (options->trace != NULL &&
        lx_trace_fits(options->trace, stack_of(self)->trace, error) != 0) {
        (void)lx_about(error, LX_ABOUT_KEY, "trace", NULL);
        return -1;
    }
    const struct lx_engine_setup setup = {.bus = {.say = &options->say, .plan = &self->plan}};
    self->plan.shafts[0].motion = NULL; /* it begins with the end of the initialisation */
    if (lx_engine_make(&self->engine, &setup, error) != 0) {
        return -1;
    }
    self->line = lx_sim_bus_line(self->engine.wires[0].bus);
    return 0;
}

/* The encoder is at the motion of this session. */
static void place_shaft(struct wire_session *self, dg_ns start)
{
    struct dg_world *world = self->engine.stations[0].control->world;
    self->shaft.motion.start = start;
    world->angle = dg_motion_angle;
    world->angle_ctx = &self->shaft.motion;
    world->calm = NULL;
}

/* The initialisation, in which nothing happens on the wire, is not in it. */
static int open_trace(struct wire_session *self, const struct options *options, dg_ns ready,
                      struct lx_error *error)
{
    const struct lx_stack *stack = stack_of(self);
    const struct lx_trace_setup trace = {
        .path = options->trace,
        .kind = stack->trace,
        .words = dg_words_of(stack->core),
        .wire = options->model,
        .tap = &self->tap,
    };
    self->trace = lx_trace_open(&trace, ready, error);
    lx_clocked_listen(self->line);
    dg_bus_master_pause(&self->master, dg_after(ready, TRACE_AHEAD));
    if (self->trace == NULL) {
        (void)lx_about(error, LX_ABOUT_KEY, "trace", NULL);
        return EXIT_OTHER;
    }
    return 0;
}

/* The encoder gets its power at `now`; its initialisation is over afterwards, and the motion begins
   with the end of it. To be closed in any case. */
static int open_session(struct wire_session *self, const struct options *options, dg_ns now,
                        struct lx_error *error)
{
    const char *shaft = options->shaft == NULL ? "0" : options->shaft;

    memset(self, 0, sizeof *self);
    if (read_options(self, options, error) != 0) {
        return EXIT_USAGE;
    }
    const int parsed = lx_shaft_parse(&self->shaft, shaft, NULL, error);
    if (parsed != 0) {
        (void)lx_about(error, LX_ABOUT_KEY, "motion", NULL);
        return parsed == LX_SHAFT_WORDS ? EXIT_USAGE : EXIT_OTHER;
    }
    const struct lx_bus *bus = self->engine.wires[0].bus;
    const dg_ns ready = dg_after(now, lx_clocked_init(self->line));
    place_shaft(self, ready);
    if (lx_clocked_open(self->line, &bus->setup, bus->core, &self->tap, now, error) != 0) {
        return EXIT_OTHER;
    }
    const struct dg_bus_master_setup master = lx_sim_bus_master(bus);
    dg_bus_master_init(&self->master, &master, now);
    lx_clocked_listen(self->line);
    dg_bus_master_pause(&self->master, ready);
    return options->trace == NULL ? 0 : open_trace(self, options, ready, error);
}

/* @return 0, or how the program ends, with `error`: the trace is not whole */
static int close_session(struct wire_session *self, struct lx_error *error)
{
    const int result = lx_trace_close(self->trace, error);
    lx_engine_close(&self->engine);
    lx_shaft_free(&self->shaft);
    lx_plan_free(&self->plan);
    return result == 0 ? 0 : EXIT_OTHER;
}

/* --- commands --- */

enum dg_master_verdict wire_session_read(struct wire_session *self)
{
    const struct dg_master_protocol *protocol = self->line->protocol->master;
    char text[DG_BUS_NOTE_MAX];
    struct dg_text to = dg_text_in(text, sizeof text);
    dg_bus_master_read(&self->master);
    const enum dg_master_verdict verdict = protocol->judge(&self->master, 0);
    if (verdict != DG_MASTER_SILENT) {
        protocol->line(&self->master, 0, &to);
        (void)printf("%s\n", text);
    }
    return verdict;
}

int wire_command_usage(const struct wire_command *self, const char *what, const char *word,
                       struct lx_error *error)
{
    (void)lx_fail(error, "%s%s; expected %s", what, word, self->right);
    return EXIT_USAGE;
}

/* Everything but what the words say. */
static bool is_command_right(const struct wire_command *self, const struct options *options)
{
    const struct dg_device *device = options->device;
    struct lx_words models = {""};

    if (device == NULL || lx_stack_of(device) != self->stack) {
        lx_stack_models(self->stack, &models);
        lx_complain("%s needs %s; valid:%s", self->name, self->needs, models.text);
        return false;
    }
    if (options->wire != NULL && !lx_wire_of(options->wire)->simulated) {
        lx_complain("%s %s has a simulated wire; expected 'drehgeber run %s --%s %s'", self->name,
                    options->model, options->model, options->wire->name, options->where);
        return false;
    }
    if (options->word_count == 0) {
        lx_complain("%s %s does nothing; expected %s", self->name, options->model, self->right);
        return false;
    }
    return true;
}

int wire_command_run(const struct wire_command *self, const struct options *options)
{
    struct wire_session session;
    struct lx_error error;
    struct lx_error close_error;
    struct words words = {options->words, options->word_count};

    if (!is_command_right(self, options)) {
        return EXIT_USAGE;
    }
    int status = open_session(&session, options, 0, &error);
    while (status == 0 && words.count > 0) {
        status = self->act(&session, &words, &error);
    }
    if (status == 0 && (fflush(stdout) != 0 || ferror(stdout) != 0)) {
        (void)lx_fail(&error, "cannot write to stdout");
        status = EXIT_OTHER;
    }
    const int closed = close_session(&session, &close_error);
    if (status != 0 || closed != 0) {
        (void)complain(status != 0 ? &error : &close_error, 0);
    }
    return status != 0 ? status : closed;
}
