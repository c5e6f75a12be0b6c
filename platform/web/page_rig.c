/* SPDX-License-Identifier: MIT */
/*
 * From the text of a rig file to a rig at work, in one block of memory:
 *
 *   | struct web_rig | plan | engine | encoders, wires, their words |
 */
#include <string.h>

#include "drehgeber/hal.h"
#include "drehgeber/instruments.h"
#include "drehgeber/version.h"
#include "page.h"

/* Frames that may wait on a wire: nothing is paced here, and few are late. */
#define FRAMES_WAIT 512u

/* A rig. */
struct web_rig {
    char wrong[1024]; /* the page's: why there is none, in a line; "" where more memory is right */
    uint8_t *at;      /* free memory */
    uint8_t *end;
    struct dg_plan plan;
    struct dg_rig_ops ops;
    struct dg_engine *engine;
    struct web_rig *other; /* one with encoders on the same shaft; NULL */
    struct web_wire *wires;
    struct web_encoder *encoders;
};

/* Make a rig, on since `begin`, in `size` bytes. texts[0] is its file; texts[1], if there is one,
 * is every file that it names. Encoders of a rig with a `first` sit on the shaft of that one.
 * @return 0; else see self->wrong */
int web_rig_make(struct web_rig *self, size_t size, struct dg_plan_text texts[2],
                 struct web_rig *first, dg_ns begin);
/* Let time pass. */
void web_rig_step(struct web_rig *self, dg_ns now);
/* Encoder `index`; NULL behind the last one. */
const struct web_encoder *web_encoder(const struct web_rig *self, size_t index);
/* A line of SCPI, with its end, and what is answered; "": what comes late. @return 0; 1: not
 * taken, as one before it waits for something; DG_ERR_SPACE: the answer is too long */
int web_scpi(struct web_client *self, dg_ns now, const char *line, char *answer, size_t size);

/* @return zeros; NULL: there is not enough */
static void *carve(struct web_rig *self, size_t n)
{
    const size_t whole = (n + DG_HOST_ALIGN - 1u) / DG_HOST_ALIGN * DG_HOST_ALIGN;
    uint8_t *here = self->at;

    if ((size_t)(self->end - here) < whole) {
        return NULL;
    }
    self->at += whole;
    return memset(here, 0, whole);
}

/* ------------------------------------------------------------ the plan */

static const char *give_file(void *ctx, const char *path, struct dg_plan_text *to)
{
    (void)path;
    *to = *(const struct dg_plan_text *)ctx;
    return NULL;
}

/* A text of models alone: the last one is an encoder, on any wire that can carry it. */
static int add_lone_encoder(struct dg_plan *plan)
{
    const struct dg_device *model = plan->models[plan->model_count - 1u].device;
    const struct dg_plan_wire_kind *kind = dg_plan_wires;

    while (!dg_plan_carries(kind, model->stack)) {
        kind++;
    }
    return (plan->shaft_count > 0 || dg_plan_add_shaft(plan, "shaft", NULL) == 0) &&
                   dg_plan_add_wire(plan, model->name, kind, NULL) >= 0 &&
                   dg_plan_add_encoder(plan, model->name, model, 0, plan->wire_count - 1u) >= 0
               ? DG_OK
               : DG_ERR_SPACE;
}

static int read_page_plan(struct web_rig *self, struct dg_plan_text texts[2],
                          struct dg_plan_error *error)
{
    const size_t room = (size_t)(self->end - self->at) / 2u;
    const struct dg_plan_setup setup = {
        .size = sizeof setup,
        .file = "text",
        .text = texts[0],
        .memory = carve(self, room),
        .memory_size = room,
        .include = texts[1].text != NULL ? give_file : NULL,
        .ctx = &texts[1],
    };
    const int result = dg_plan_read(&self->plan, &setup, error);

    if (result != DG_OK || self->plan.encoder_count > 0) {
        return result;
    }
    if (self->plan.model_count > 0) {
        return add_lone_encoder(&self->plan);
    }
    *error = (struct dg_plan_error){.what = "no [encoder NAME] and no [model NAME] in it"};
    return DG_ERR_ARGUMENT;
}

/* ------------------------------------------------------------ what the control plane asks */

static struct web_rig *rig_of(const struct dg_rig *rig)
{
    return dg_engine_ctx(rig);
}

static const char *say_wire(struct dg_rig *rig, const struct dg_encoder *encoder)
{
    (void)rig;
    (void)encoder;
    return "host";
}

/* Those of the other rig turn with it. */
static void look_at_shaft(struct dg_rig *rig, struct dg_rig_shaft *shaft, dg_ns now)
{
    const struct web_rig *other = rig_of(rig)->other;

    dg_engine_ops.turns(rig, shaft, now);
    if (other != NULL) {
        dg_engine_ops.turns(dg_engine_control(other->engine), shaft, now);
    }
}

static void turn_page_shaft(struct dg_rig *rig, struct dg_rig_shaft *shaft, dg_ns now)
{
    const struct web_rig *other = rig_of(rig)->other;

    dg_engine_ops.turned(rig, shaft, now);
    if (other != NULL) {
        dg_engine_ops.turned(dg_engine_control(other->engine), shaft, now);
    }
}

/* ------------------------------------------------------------ the engine */

static int open_page_wire(void *ctx, size_t index, struct dg_engine_wire *to,
                          struct dg_plan_error *error)
{
    const struct web_rig *self = ctx;

    (void)error;
    to->ctx = &self->wires[index];
    to->ops = web_wire_ops(to->plan->stack->medium);
    to->frames.line.company = DG_BUS_SOMEBODY;
    return 0;
}

static bool make_page_wires(struct web_rig *self)
{
    self->wires = carve(self, self->plan.wire_count * sizeof *self->wires);
    for (size_t i = 0; self->wires != NULL && i < self->plan.wire_count; i++) {
        const struct dg_words *words = dg_words_of(self->plan.wires[i].stack);
        void *memory = carve(self, words == NULL ? 0 : words->size);
        if (memory == NULL) {
            return false;
        }
        web_wire_init(&self->wires[i], words, memory);
    }
    return self->wires != NULL;
}

static int make_page_engine(struct web_rig *self, dg_ns begin, struct dg_plan_error *error)
{
    const struct dg_engine_setup setup = {
        .size = sizeof setup,
        .plan = &self->plan,
        .begin = begin,
        .frames_wait = FRAMES_WAIT,
        .instruments = dg_instruments,
        .instrument_count = dg_instrument_count,
        .ops = &self->ops,
        .wire = open_page_wire,
        .ctx = self,
    };
    const size_t n = dg_engine_size(&setup);
    void *memory = carve(self, n);

    self->encoders = carve(self, self->plan.encoder_count * sizeof *self->encoders);
    if (memory == NULL || self->encoders == NULL || !make_page_wires(self)) {
        return DG_ERR_SPACE;
    }
    self->ops = dg_engine_ops;
    self->ops.counters = NULL; /* what a port counts */
    self->ops.wire = say_wire;
    self->ops.turns = look_at_shaft;
    self->ops.turned = turn_page_shaft;
    self->engine = dg_engine_make(memory, n, &setup, error);
    return self->engine != NULL ? DG_OK : DG_ERR_ARGUMENT;
}

/* Whoever waits for a motion waits for that one's, too. */
static void sit_on_shaft(struct web_rig *self, const struct web_rig *first)
{
    struct dg_rig *rig = dg_engine_control(self->engine);
    struct dg_rig_shaft *shaft = dg_engine_control(first->engine)->shafts[0];

    rig->shafts[0] = shaft;
    for (size_t i = 0; i < rig->encoder_count; i++) {
        rig->encoders[i]->shaft = shaft;
        dg_host_shaft_of(dg_engine_encoder(self->engine, i), &shaft->shaft);
    }
}

/* ------------------------------------------------------------ sessions */

static void collect_answer(void *ctx, const char *bytes, size_t n)
{
    struct web_client *self = ctx;
    const size_t fits = n < self->room ? n : self->room;

    memcpy(self->answer, bytes, fits);
    self->answer += fits;
    self->room -= fits;
}

/* *IDN? tells the model, as for a rig of one encoder. */
static void begin_client(struct web_client *self, struct dg_rig *rig, size_t index)
{
    struct dg_text idn = dg_text_in(self->control.idn, sizeof self->control.idn);

    dg_control_init(&self->control, rig, collect_answer, self);
    self->index = (uint32_t)index;
    dg_text_add(&idn, "drehgeber,");
    dg_text_add(&idn, rig->encoders[index]->model->name);
    dg_text_add(&idn, ",0," DG_VERSION);
}

int web_scpi(struct web_client *self, dg_ns now, const char *line, char *answer, size_t size)
{
    self->answer = answer;
    self->room = size - 1u;
    self->control.session.selected = self->index;
    while (*line != '\0' && dg_control_rx(&self->control, now, line, 1) == 1u) {
        line++;
    }
    (void)dg_control_step(&self->control, now);
    *self->answer = '\0';
    if (*line != '\0') {
        return 1;
    }
    return self->room > 0 ? DG_OK : DG_ERR_SPACE;
}

/* ------------------------------------------------------------ all of it */

static void fill_encoder(const struct web_rig *self, size_t index)
{
    struct dg_rig *rig = dg_engine_control(self->engine);
    const size_t on = self->plan.encoders[index].wire;
    struct web_encoder *encoder = &self->encoders[index];

    encoder->host = dg_engine_encoder(self->engine, index);
    encoder->wire = &self->wires[on];
    encoder->bus = dg_engine_bus(self->engine, on);
    encoder->place = dg_engine_place(self->engine, index);
    encoder->in = dg_engine_wire_of(self->engine, on)->words.in;
    encoder->shaft = &rig->encoders[index]->shaft->shaft;
    encoder->name = rig->encoders[index]->name;
    encoder->what = rig->encoders[index]->model->resolution;
    encoder->page = &encoder->clients[0];
    encoder->prompt = &encoder->clients[1];
    begin_client(encoder->page, rig, index);
    begin_client(encoder->prompt, rig, index);
}

static int begin_rig(struct web_rig *self, struct web_rig *first, dg_ns begin,
                     struct dg_plan_error *error)
{
    const int result = make_page_engine(self, begin, error);

    if (result != DG_OK) {
        return result;
    }
    if (first != NULL) {
        sit_on_shaft(self, first);
    }
    for (size_t i = 0; i < self->plan.encoder_count; i++) {
        fill_encoder(self, i);
    }
    dg_engine_control(self->engine)->origin = 0; /* TIME? is the page's */
    if (dg_engine_power(self->engine, begin, error) != 0) {
        return DG_ERR_ARGUMENT;
    }
    if (first != NULL) {
        self->other = first;
        first->other = self;
    }
    return DG_OK;
}

/* "line 3: ", as people count, who see one text. */
static void say_error(struct web_rig *self, const struct dg_plan_error *error)
{
    struct dg_text to = dg_text_in(self->wrong, sizeof self->wrong);

    if (error->line != 0) {
        dg_text_add(&to, "line ");
        dg_text_add_number(&to, error->line);
        dg_text_add(&to, ": ");
    }
    dg_text_add(&to, error->key);
    if (error->valued != DG_PLAN_UNVALUED) {
        dg_text_add(&to, " ");
        dg_text_add(&to, error->value);
    }
    dg_text_add(&to, error->key[0] != '\0' ? ": " : "");
    dg_text_add(&to, error->what);
    dg_text_add(&to, error->what[0] != '\0' && error->right[0] != '\0' ? "; " : "");
    dg_text_add(&to, error->right);
}

int web_rig_make(struct web_rig *self, size_t size, struct dg_plan_text texts[2],
                 struct web_rig *first, dg_ns begin)
{
    struct dg_plan_error error;

    memset(self, 0, sizeof *self);
    self->at = (uint8_t *)self + sizeof *self;
    self->at += -(uintptr_t)self->at % DG_HOST_ALIGN;
    self->end = (uint8_t *)self + size;
    int result = read_page_plan(self, texts, &error);
    if (result == DG_OK) {
        result = begin_rig(self, first, begin, &error);
    }
    if (result == DG_ERR_ARGUMENT) {
        say_error(self, &error);
    }
    return result;
}

void web_rig_step(struct web_rig *self, dg_ns now)
{
    (void)dg_engine_step(self->engine, now);
    for (size_t i = 0; i < self->plan.wire_count; i++) {
        (void)dg_words_step(&self->wires[i].words, now);
    }
}

const struct web_encoder *web_encoder(const struct web_rig *self, size_t index)
{
    return index < self->plan.encoder_count ? &self->encoders[index] : NULL;
}
