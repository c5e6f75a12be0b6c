/* SPDX-License-Identifier: MIT */
/*
 * Questions and answers:
 *
 *   top_client_tick() --> ask_topic() --> link --> the rig
 *   view <-- take_...() <-- hear_lines() <-- link <-- the rig
 *
 * Every question begins with one that cannot fail, so it has a line of answer in any case, and the
 * lines come in the order of the questions. A round is over when all of it was answered; the next
 * one is not begun before. Only what is to be seen is asked for: a rig may have hundreds.
 */
#define _GNU_SOURCE
#include "top_client.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/figure.h"
#include "rig_link.h"
#include "timer.h"
#include "top_answer.h"

#define MARK "1999.0" /* what SYSTem:VERSion? answers */
#define ASKED_MAX 1024u
#define QUESTION_MAX 200u
#define SURVEY_MAX 128u /* encoders that are asked for what stays as it is, in a round */
#define RETRY_EVERY DG_S(1)
#define SILENT_AFTER DG_S(1)
#define DEAD_AFTER DG_S(10)
#define MESSAGE_STAYS DG_S(5)
#define COUNT_OVER DG_S(1)
#define UDEG_PLACES 6u
#define MRPM_PLACES 3u
#define BUSY "no answer: not sent"

enum topic {
    TOPIC_CATALOGUE,
    TOPIC_ENCODER,
    TOPIC_STATE,
    TOPIC_SHAFT,
    TOPIC_FRAMES,
    TOPIC_FAULTS,
    TOPIC_END,
};

struct question {
    enum topic topic;
    size_t index; /* encoder; of TOPIC_SHAFT the shaft */
};

struct top_client {
    struct top_view *view;
    sd_event *event;
    sd_event_source *io;
    void (*changed)(void *ctx);
    void *ctx;
    struct question asked[ASKED_MAX]; /* not answered yet: a ring */
    size_t asked_first;
    size_t asked_count;
    size_t surveyed;     /* encoders that were asked what stays as it is */
    dg_ns heard;         /* something, or since when something should be */
    dg_ns retry;         /* when to connect again */
    dg_ns message_until; /* the message is shown */
    struct rig_link link;
};

/* --- texts --- */

static void copy_text(char *to, size_t size, const char *text)
{
    (void)snprintf(to, size, "%s", text == NULL ? "" : text);
}

/* A list: `text` behind what is there. */
static void append_word(char *to, size_t size, const char *text)
{
    const size_t used = strlen(to);
    (void)snprintf(to + used, size - used, "%s%s", used == 0 ? "" : " ", text);
}

static int64_t decimal(const char *text, unsigned places)
{
    struct dg_decimal out = {.value = 0};
    return text != NULL && dg_decimal_parse(text, strlen(text), places, &out) ? out.value : 0;
}

static void show_message(struct top_client *self, const char *text)
{
    copy_text(self->view->message, sizeof self->view->message, text);
    self->message_until = dg_after(lx_now(), MESSAGE_STAYS);
}

bool top_fault_active(const struct top_encoder *encoder, const char *name)
{
    const size_t n = strlen(name);
    const char *at = encoder->faults;
    while (*at != '\0') {
        const size_t word = strcspn(at, " ");
        if (word == n && memcmp(at, name, n) == 0) {
            return true;
        }
        at += word + strspn(at + word, " ");
    }
    return false;
}

/* --- answers --- */

static void free_lists(struct top_view *view)
{
    free(view->encoders);
    free(view->shafts);
    view->encoders = NULL;
    view->shafts = NULL;
    view->encoder_count = 0;
    view->shaft_count = 0;
}

static bool add_encoder(struct top_view *view, const char *name)
{
    struct top_encoder *more =
        realloc(view->encoders, (view->encoder_count + 1) * sizeof *view->encoders);
    if (more == NULL) {
        return false;
    }
    view->encoders = more;
    more[view->encoder_count] = (struct top_encoder){.shaft = TOP_NONE, .up = true, .rate = -1};
    copy_text(more[view->encoder_count].name, sizeof more->name, name);
    view->encoder_count++;
    return true;
}

static bool add_shaft(struct top_view *view, const char *name)
{
    struct top_shaft *more = realloc(view->shafts, (view->shaft_count + 1) * sizeof *view->shafts);
    if (more == NULL) {
        return false;
    }
    view->shafts = more;
    more[view->shaft_count] = (struct top_shaft){.encoder = TOP_NONE};
    copy_text(more[view->shaft_count].name, sizeof more->name, name);
    view->shaft_count++;
    return true;
}

static size_t find_encoder(const struct top_view *view, const char *name)
{
    size_t i = 0;
    while (i < view->encoder_count && strcmp(view->encoders[i].name, name) != 0) {
        i++;
    }
    return i < view->encoder_count ? i : 0;
}

/* Names of encoders, then of shafts. After a connection that was lost it may be another rig; the
   encoder that was selected stays so if it is there. */
static void take_catalogue(struct top_client *self, struct top_answer *answer, size_t index)
{
    struct top_view *view = self->view;
    char selected[sizeof view->encoders->name] = "";
    const char *name;
    (void)index;
    if (view->selected < view->encoder_count) {
        copy_text(selected, sizeof selected, view->encoders[view->selected].name);
    }
    free_lists(view);
    while ((name = top_answer_part(answer)) != NULL && add_encoder(view, name)) {
    }
    (void)top_answer_next(answer);
    while ((name = top_answer_part(answer)) != NULL && add_shaft(view, name)) {
    }
    view->selected = find_encoder(view, selected);
    view->frame_count = 0;
    view->faults_of = TOP_NONE;
    self->surveyed = 0;
}

/* Model, wire, shaft. */
static void take_encoder(struct top_client *self, struct top_answer *answer, size_t index)
{
    struct top_view *view = self->view;
    struct top_encoder *encoder = &view->encoders[index];
    copy_text(encoder->model, sizeof encoder->model, top_answer_part(answer));
    (void)top_answer_next(answer);
    copy_text(encoder->wire, sizeof encoder->wire, top_answer_part(answer));
    (void)top_answer_next(answer);
    const char *shaft = top_answer_part(answer);
    for (size_t i = 0; shaft != NULL && i < view->shaft_count; i++) {
        if (strcmp(view->shafts[i].name, shaft) == 0) {
            encoder->shaft = i;
            view->shafts[i].encoder =
                view->shafts[i].encoder == TOP_NONE ? index : view->shafts[i].encoder;
        }
    }
}

static void count_frames(struct top_encoder *encoder, uint64_t frames)
{
    const dg_ns now = lx_now();
    const dg_ns span = dg_elapsed(now, encoder->counted);
    if (encoder->counted != 0 && span < COUNT_OVER) {
        return;
    }
    if (encoder->counted != 0) { /* a new start counts from 0 */
        const uint64_t more = frames > encoder->frames ? frames - encoder->frames : 0;
        encoder->rate = (int64_t)((more * DG_S(1) + span / 2) / span);
    }
    encoder->frames = frames;
    encoder->counted = now;
}

/* Texts of the state; the others are numbers or not known here. */
static const struct {
    const char *key;
    size_t offset;
    size_t size;
} texts[] = {
    {"mode=", offsetof(struct top_encoder, mode), sizeof(((struct top_encoder *)0)->mode)},
    {"position=", offsetof(struct top_encoder, position),
     sizeof(((struct top_encoder *)0)->position)},
    {"leds=", offsetof(struct top_encoder, leds), sizeof(((struct top_encoder *)0)->leds)},
    {"errors=", offsetof(struct top_encoder, errors), sizeof(((struct top_encoder *)0)->errors)},
};

static const char *behind(const char *text, const char *key)
{
    const size_t n = strlen(key);
    return strncmp(text, key, n) == 0 ? text + n : NULL;
}

static bool take_encoder_text(struct top_encoder *encoder, const char *part)
{
    for (size_t i = 0; i < DG_COUNT(texts); i++) {
        const char *value = behind(part, texts[i].key);
        if (value != NULL) {
            copy_text((char *)encoder + texts[i].offset, texts[i].size, value);
            return true;
        }
    }
    return false;
}

static void take_part(struct top_encoder *encoder, const char *part)
{
    const char *value;
    if (take_encoder_text(encoder, part)) {
        return;
    }
    if ((value = behind(part, "power=")) != NULL) {
        encoder->powered = *value != '0';
    } else if ((value = behind(part, "frames=")) != NULL) {
        count_frames(encoder, (uint64_t)decimal(value, 0));
    } else {
        value = behind(part, "wire_up=");
        encoder->up = value == NULL ? encoder->up : *value != '0';
        append_word(encoder->more, sizeof encoder->more, part);
    }
}

static void blanks_for_slashes(char *text)
{
    while ((text = strchr(text, '/')) != NULL) {
        *text = ' ';
    }
}

/* The state, then the names of active faults. */
static void take_state(struct top_client *self, struct top_answer *answer, size_t index)
{
    struct top_encoder *encoder = &self->view->encoders[index];
    const char *part;
    encoder->more[0] = '\0';
    while ((part = top_answer_part(answer)) != NULL) {
        take_part(encoder, part);
    }
    blanks_for_slashes(encoder->leds);
    encoder->faults[0] = '\0';
    (void)top_answer_next(answer);
    while ((part = top_answer_part(answer)) != NULL) {
        append_word(encoder->faults, sizeof encoder->faults, part);
    }
    if (encoder->faults[0] == '\0') {
        copy_text(encoder->faults, sizeof encoder->faults, "-");
    }
    encoder->known = true;
}

/* Angle and speed. */
static void take_shaft(struct top_client *self, struct top_answer *answer, size_t index)
{
    struct top_shaft *shaft = &self->view->shafts[index];
    const int64_t udeg = decimal(top_answer_part(answer), UDEG_PLACES);
    (void)top_answer_next(answer);
    const int64_t mrpm = decimal(top_answer_part(answer), MRPM_PLACES);
    if (!shaft->held) {
        shaft->udeg = udeg;
        shaft->mrpm = mrpm;
        shaft->known = true;
    }
}

static void take_frames(struct top_client *self, struct top_answer *answer, size_t index)
{
    struct top_view *view = self->view;
    const char *part;
    if (index != view->selected) {
        return;
    }
    view->frame_count = 0;
    while (view->frame_count < TOP_FRAMES && (part = top_answer_part(answer)) != NULL) {
        copy_text(view->frames[view->frame_count], sizeof view->frames[0], part);
        view->frame_count += *part == '\0' ? 0 : 1;
    }
}

/* Name, kind, cause, effect, chapter of each. */
static void take_faults(struct top_client *self, struct top_answer *answer, size_t index)
{
    struct top_view *view = self->view;
    const char *name;
    if (index != view->faults_of) {
        return;
    }
    view->fault_count = 0;
    while (view->fault_count < DG_FAULTS_MAX && (name = top_answer_part(answer)) != NULL) {
        struct top_fault *fault = &view->faults[view->fault_count++];
        copy_text(fault->name, sizeof fault->name, name);
        (void)top_answer_part(answer);
        copy_text(fault->cause, sizeof fault->cause, top_answer_part(answer));
        copy_text(fault->effect, sizeof fault->effect, top_answer_part(answer));
        (void)top_answer_part(answer);
    }
}

/* The time, then the oldest error. */
static void take_end(struct top_client *self, struct top_answer *answer, size_t index)
{
    (void)index;
    copy_text(self->view->time, sizeof self->view->time, top_answer_part(answer));
    (void)top_answer_next(answer);
    const int64_t code = decimal(top_answer_part(answer), 0);
    const char *text = top_answer_part(answer);
    if (code != 0 && text != NULL) {
        show_message(self, text);
    }
}

/* --- questions --- */

#define FIRST "SYST:VERS?"
#define TO "SYST:VERS?;:INST:SEL \"%s\";"

/* By enum topic. */
static const struct {
    const char *line; /* the encoder's name goes in */
    void (*take)(struct top_client *self, struct top_answer *answer, size_t index);
} topics[] = {
    [TOPIC_CATALOGUE] = {FIRST ";:INST:CAT?;:SHAF:CAT?", take_catalogue},
    [TOPIC_ENCODER] = {TO "MOD?;WIRE?;:SHAF:NAME?", take_encoder},
    [TOPIC_STATE] = {TO ":STAT?;:FAUL:ACT?", take_state},
    [TOPIC_SHAFT] = {TO ":SHAF:POS?;VEL?", take_shaft},
    [TOPIC_FRAMES] = {TO ":TRAC:LAST? 32", take_frames},
    [TOPIC_FAULTS] = {TO ":FAUL:CAT?", take_faults},
    [TOPIC_END] = {FIRST ";:TIME?;:SYST:ERR:ALL?", take_end},
};

_Static_assert(TOP_FRAMES == 32, "TRACe:LAST? asks for as many");

/* @return false: there is no room for it; it can be asked in another round */
static bool ask_topic(struct top_client *self, enum topic topic, size_t index)
{
    const struct top_view *view = self->view;
    const size_t encoder = topic == TOPIC_SHAFT ? view->shafts[index].encoder : index;
    const char *name = encoder < view->encoder_count ? view->encoders[encoder].name : "";
    char line[QUESTION_MAX];
    const char *at = strstr(topics[topic].line, "%s");
    const int before =
        at == NULL ? (int)strlen(topics[topic].line) : (int)(at - topics[topic].line);
    (void)snprintf(line, sizeof line, "%.*s%s%s", before, topics[topic].line,
                   at == NULL ? "" : name, at == NULL ? "" : at + 2);
    if (self->asked_count == ASKED_MAX || !rig_link_say(&self->link, line)) {
        return false;
    }
    if (self->asked_count == 0) {
        self->heard = lx_now();
    }
    self->asked[(self->asked_first + self->asked_count++) % ASKED_MAX] =
        (struct question){.topic = topic, .index = index};
    return true;
}

static void ask_survey(struct top_client *self)
{
    for (unsigned n = 0; n < SURVEY_MAX && self->surveyed < self->view->encoder_count; n++) {
        self->surveyed += ask_topic(self, TOPIC_ENCODER, self->surveyed) ? 1 : 0;
    }
}

static void ask_shafts(struct top_client *self)
{
    struct top_view *view = self->view;
    for (size_t i = 0; i < view->shaft_count; i++) {
        view->shafts[i].held = false;
        if (view->shafts[i].encoder != TOP_NONE) {
            (void)ask_topic(self, TOPIC_SHAFT, i);
        }
    }
}

static void ask_round(struct top_client *self)
{
    const struct top_view *view = self->view;
    ask_survey(self);
    ask_shafts(self);
    for (size_t i = view->first; i < view->first + view->rows && i < view->encoder_count; i++) {
        (void)ask_topic(self, TOPIC_STATE, i);
    }
    if (view->encoder_count > 0) {
        (void)ask_topic(self, TOPIC_FRAMES, view->selected);
    }
    (void)ask_topic(self, TOPIC_END, 0);
}

static void watch_link(struct top_client *self)
{
    if (self->io != NULL) {
        (void)sd_event_source_set_io_events(self->io, rig_link_events(&self->link));
    }
}

/* --- the connection --- */

static void trouble(struct top_client *self, const char *what, const char *why)
{
    (void)snprintf(self->view->trouble, sizeof self->view->trouble, "%.40s%.80s", what, why);
}

/* It will be tried again in a while. */
static void hang_up(struct top_client *self, const char *why)
{
    self->io = sd_event_source_disable_unref(self->io);
    rig_link_close(&self->link);
    self->asked_count = 0;
    self->retry = dg_after(lx_now(), RETRY_EVERY);
    trouble(self, "no connection, trying again: ", why);
}

/* @return false: that is no answer, but somebody who sends us away */
static bool take_answer_line(struct top_client *self, char *line)
{
    struct top_answer answer = {.at = line};
    const char *mark = top_answer_part(&answer);
    if (self->asked_count == 0 || strcmp(mark, MARK) != 0) {
        hang_up(self, *mark == '\0' ? "that is not a control plane" : mark);
        return false;
    }
    const struct question question = self->asked[self->asked_first];
    self->asked_first = (self->asked_first + 1) % ASKED_MAX;
    self->asked_count--;
    self->view->trouble[0] = '\0';
    if (top_answer_next(&answer)) {
        topics[question.topic].take(self, &answer, question.index);
    }
    return true;
}

/* Answers are ASCII; what is not shall not reach the terminal. */
static void make_printable(char *text)
{
    for (; *text != '\0'; text++) {
        if (*text < ' ' || *text > '~') {
            *text = '?';
        }
    }
}

static void hear_lines(struct top_client *self)
{
    char *line;
    while ((line = rig_link_line(&self->link)) != NULL) {
        self->heard = lx_now();
        make_printable(line);
        if (!take_answer_line(self, line)) {
            return;
        }
    }
}

static int on_io(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct top_client *self = ctx;
    const size_t before = self->asked_count;
    (void)source;
    (void)fd;
    (void)events;
    const int result = rig_link_serve(&self->link);
    hear_lines(self);
    if (result < 0 && self->link.fd >= 0) {
        hang_up(self, strerror(-result));
    }
    watch_link(self);
    if (before > 0 && self->asked_count == 0) {
        self->changed(self->ctx);
    }
    return 0;
}

/* Connected, or about to be. */
static int begin_session(struct top_client *self)
{
    const int result = sd_event_add_io(self->event, &self->io, self->link.fd, EPOLLIN, on_io, self);
    if (result >= 0) {
        (void)ask_topic(self, TOPIC_CATALOGUE, 0);
        watch_link(self);
    }
    return result;
}

static void connect_again(struct top_client *self)
{
    int result = rig_link_again(&self->link);
    if (result == 0) {
        result = begin_session(self);
    }
    if (result < 0) {
        hang_up(self, strerror(-result));
    }
}

static void complain_of_silence(struct top_client *self, dg_ns silent)
{
    char seconds[16];
    (void)snprintf(seconds, sizeof seconds, "%" PRIu64 " s", (uint64_t)(silent / DG_S(1)));
    if (silent >= DEAD_AFTER) {
        hang_up(self, "no answer");
    } else if (silent >= SILENT_AFTER) {
        trouble(self, "no answer for ", seconds);
    }
}

void top_client_tick(struct top_client *self, dg_ns now)
{
    if (now >= self->message_until) {
        self->view->message[0] = '\0';
    }
    if (self->link.fd < 0) {
        if (now >= self->retry) {
            connect_again(self);
        }
        return;
    }
    if (self->asked_count > 0) {
        complain_of_silence(self, dg_elapsed(now, self->heard));
        return;
    }
    ask_round(self);
    watch_link(self);
}

bool top_client_do(struct top_client *self, size_t encoder, const char *command)
{
    char line[QUESTION_MAX];
    if (encoder >= self->view->encoder_count) {
        return false;
    }
    (void)snprintf(line, sizeof line, "INST:SEL \"%s\";:%s", self->view->encoders[encoder].name,
                   command);
    if (self->view->trouble[0] != '\0' || !rig_link_say(&self->link, line)) {
        show_message(self, BUSY);
        return false;
    }
    watch_link(self);
    return true;
}

void top_client_ask_faults(struct top_client *self, size_t encoder)
{
    if (encoder < self->view->encoder_count) {
        (void)ask_topic(self, TOPIC_FAULTS, encoder);
        watch_link(self);
    }
}

struct top_client *top_client_open(sd_event *event, struct top_view *view,
                                   void (*changed)(void *ctx), void *ctx, struct lx_error *error)
{
    struct top_client *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)lx_fail(error, "no memory");
        return NULL;
    }
    self->view = view;
    self->event = event;
    self->changed = changed;
    self->ctx = ctx;
    self->link.fd = -1;
    if (rig_link_open(&self->link, view->where, error) != 0) {
        top_client_close(self);
        return NULL;
    }
    const int result = begin_session(self);
    if (result < 0) {
        (void)lx_fail(error, "no event loop: %s", strerror(-result));
        top_client_close(self);
        return NULL;
    }
    return self;
}

void top_client_close(struct top_client *self)
{
    if (self == NULL) {
        return;
    }
    self->io = sd_event_source_disable_unref(self->io);
    rig_link_end(&self->link);
    free_lists(self->view);
    free(self);
}
