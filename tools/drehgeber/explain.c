/* SPDX-License-Identifier: MIT */
#include "explain.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "drehgeber/drehgeber.h"
#include "explain_edges.h"
#include "file.h"
#include "run.h"
#include "stacks.h"

/* Bytes of a message that a line has; a difference has all. */
#define BYTES_SHOWN 32u

/* What the command is doing. */
struct explain_recording {
    const struct options *options;
    FILE *file;
    struct explain_talk talk;
    struct explain_model model;
    bool compares;
    dg_ns base; /* of the recording */
    uint64_t messages;
    uint64_t differences;
    struct lx_error error;
};

/* --- lines --- */

static void print_time(const struct explain_recording *self, dg_ns at)
{
    const dg_ns since = dg_elapsed(at, self->base);
    (void)printf("%" PRIu64 ".%06" PRIu64, since / DG_S(1), since % DG_S(1) / DG_US(1));
}

static void print_bytes(const char *before, const uint8_t *bytes, size_t n, size_t most)
{
    (void)printf("%s", before);
    for (size_t i = 0; i < n && i < most; i++) {
        (void)printf(" %02X", bytes[i]);
    }
    (void)printf(n > most ? " ..." : "");
}

/* "0.012345 > 40h -> 42h position 74565  [5.1.2.1]" */
static void print_message(const struct explain_recording *self,
                          const struct explain_message *message)
{
    print_time(self, message->at);
    (void)printf(" %c %s", message->ours ? '>' : '<', message->text);
    if (self->talk.medium == DG_MEDIUM_EDGES) {
        print_bytes(":", message->bytes, message->n, BYTES_SHOWN);
    }
    if (message->clause != NULL) {
        (void)printf("  [%s]", message->clause);
    }
    (void)putchar('\n');
}

static void print_side(const char *name, const uint8_t *bytes, size_t n, const char *text)
{
    (void)printf("  %s", name);
    print_bytes("", bytes, n, EXPLAIN_BYTES_MAX);
    (void)printf("%s%s\n", text[0] != '\0' ? "  " : "", text);
}

/* What the model would have sent, in the words of the recording. */
static void print_model_message(struct explain_recording *self,
                                const struct explain_difference *difference)
{
    const struct explain_said *said = difference->model;
    const struct explain_message *came = difference->came;
    const struct explain_message *asked = difference->asked;
    struct explain_message message = {.ours = true, .at = difference->at, .key = said->key};
    message.each = came != NULL ? came->each : asked != NULL ? asked->each : 0;
    message.n = said->n;
    for (size_t i = 0; i < said->n; i++) {
        message.bytes[i] = said->bytes[i];
    }
    if (self->talk.medium != DG_MEDIUM_EDGES &&
        (self->talk.medium == DG_MEDIUM_FRAMES || message.each > 0)) {
        explain_talk_say(&self->talk, &message);
    }
    print_side("model:", said->bytes, said->n, message.text);
}

static void on_difference(void *ctx, const struct explain_difference *difference)
{
    struct explain_recording *self = ctx;
    const struct explain_message *came = difference->came;
    self->differences++;
    if (difference->asked != NULL) {
        print_message(self, difference->asked);
    } else if (came != NULL) {
        print_message(self, came);
    } else {
        print_time(self, difference->at);
        (void)puts(" > nothing");
    }
    if (came == NULL) {
        (void)puts("  came:  nothing");
    } else {
        print_side("came: ", came->bytes, came->n,
                   self->talk.medium == DG_MEDIUM_EDGES ? "" : came->text);
    }
    if (difference->model == NULL) {
        (void)puts("  model: nothing");
    } else {
        print_model_message(self, difference);
    }
}

static void on_frame(void *ctx, const struct explain_message *message)
{
    const struct explain_recording *self = ctx;
    if (!self->compares) {
        print_message(self, message);
    }
}

/* --- what is done --- */

static int tell_all(struct explain_recording *self)
{
    struct explain_message message;
    int found;
    while ((found = explain_talk_next(&self->talk, &message, &self->error)) == 1) {
        print_message(self, &message);
        self->messages++;
    }
    return found;
}

static int replay_recording(struct explain_recording *self)
{
    struct explain_replay *replay = lx_allocate(sizeof *replay, "a recording", &self->error);
    if (replay == NULL) {
        return -1;
    }
    replay->model = &self->model;
    replay->talk = &self->talk;
    replay->differs = on_difference;
    replay->ctx = self;
    replay->frames = self->talk.medium == DG_MEDIUM_FRAMES;
    const int result = explain_replay_run(replay, &self->error);
    self->messages = replay->messages;
    free(replay);
    return result;
}

static int tell_edges(struct explain_recording *self)
{
    struct explain_edges *edges = lx_allocate(sizeof *edges, "a recording", &self->error);
    if (edges == NULL) {
        return -1;
    }
    edges->model = self->compares ? &self->model : NULL;
    edges->talk = &self->talk;
    edges->frame = on_frame;
    edges->differs = on_difference;
    edges->ctx = self;
    const int result = explain_edges_run(edges, &self->error);
    self->messages = edges->messages;
    free(edges);
    return result;
}

static int tell_recording(struct explain_recording *self)
{
    if (self->talk.medium == DG_MEDIUM_EDGES) {
        return tell_edges(self);
    }
    return self->compares ? replay_recording(self) : tell_all(self);
}

/* --- from the command line --- */

static int make_model(struct explain_recording *self)
{
    const struct options *options = self->options;
    if (options->model == NULL) {
        return 0;
    }
    if (options->device == NULL) {
        struct lx_words right = {"valid:"};
        lx_stack_models(NULL, &right);
        return lx_refuse(&self->error, right.text, "--against %s: no such model", options->model);
    }
    self->compares = true;
    return explain_model_make(&self->model, options, &self->error);
}

/* What a line has that does not say it. */
static void set_line(struct explain_recording *self)
{
    struct dg_host_uart uart;
    if (self->compares && dg_host_uart(self->model.model, &uart) == DG_HOST_OK) {
        self->talk.source->uart = uart;
    }
}

static int open_recording(struct explain_recording *self)
{
    const char *path = self->options->capture;
    self->file = lx_file_read(NULL, path, &self->error);
    if (self->file == NULL) {
        return -1;
    }
    self->talk.source = explain_source_open(self->file, path, &self->error);
    if (self->talk.source == NULL) {
        return -1;
    }
    set_line(self);
    return 0;
}

/* Its first event may be the end of a character. */
static dg_ns begin_of(const struct dg_tap_event *event)
{
    const struct dg_host_uart uart = {
        .baud = event->kind == DG_TAP_CHARACTER ? event->character.baud : 0,
        .parity = event->kind == DG_TAP_CHARACTER ? (uint8_t)event->character.parity : 'N',
    };
    return dg_elapsed(event->at, uart.baud == 0 ? 0 : dg_host_uart_ns(&uart, 1));
}

/* @return how the program ends; EXIT_OK: go on */
static int check_medium(struct explain_recording *self)
{
    static const char *const titles[] = {"characters", "CAN frames", "levels of a clocked line",
                                         "words of a ring"};
    _Static_assert(DG_COUNT(titles) == DG_MEDIUM_COUNT, "a title for each medium");
    const struct options *options = self->options;
    if (!self->compares || (enum dg_medium)options->device->stack->medium == self->talk.medium) {
        return EXIT_OK;
    }
    (void)lx_fail(&self->error, "%s has %s, %s has %s on its wire", options->capture,
                  titles[self->talk.medium], options->model,
                  titles[options->device->stack->medium]);
    return EXIT_USAGE;
}

static void note_sum(const struct explain_recording *self)
{
    const struct lx_say *say = &self->options->say;
    if (self->compares) {
        lx_note(say, "%" PRIu64 " messages of the encoder, %" PRIu64 " differences", self->messages,
                self->differences);
    } else {
        lx_note(say, "%" PRIu64 " messages", self->messages);
    }
    if (self->talk.source->left_out > 0) {
        lx_note(say,
                "%" PRIu64 " frames are left out: extended, of errors, CAN FD or of another wire",
                self->talk.source->left_out);
    }
}

static int explain_recording(struct explain_recording *self)
{
    if (make_model(self) != 0) {
        return EXIT_USAGE;
    }
    if (open_recording(self) != 0) {
        return EXIT_OTHER;
    }
    self->talk.address = self->compares ? explain_model_address(&self->model) : 0;
    self->talk.wire.words = self->compares ? dg_words_of(self->options->device->stack) : NULL;
    const int found = explain_talk_begin(&self->talk, &self->error);
    if (found < 0) {
        return EXIT_OTHER;
    }
    if (found == 1) {
        self->base = begin_of(&self->talk.event);
        const int fits = check_medium(self);
        if (fits != EXIT_OK) {
            return fits;
        }
        if (tell_recording(self) != 0) {
            return EXIT_OTHER;
        }
    }
    note_sum(self);
    return self->differences == 0 ? EXIT_OK : EXIT_OTHER;
}

int explain_command(const struct options *options)
{
    struct explain_recording *self = calloc(1, sizeof *self);
    if (self == NULL) {
        lx_complain("no memory");
        return EXIT_OTHER;
    }
    if (options->capture == NULL) {
        lx_complain("explain needs a recording; expected 'drehgeber %s'", options->row->usage);
        free(self);
        return EXIT_USAGE;
    }
    self->options = options;
    const int status = explain_recording(self);
    (void)fflush(stdout);
    if (self->error.what[0] != '\0') {
        (void)complain(&self->error, status);
    }
    explain_talk_end(&self->talk);
    explain_source_close(self->talk.source);
    explain_model_free(&self->model);
    if (self->file != NULL) {
        (void)fclose(self->file);
    }
    free(self);
    return status;
}
