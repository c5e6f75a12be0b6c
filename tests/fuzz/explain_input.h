/* SPDX-License-Identifier: MIT */
/*
 * What the targets of recordings share: the input is a file of one format. It is read to its end or
 * to an error that names a place in it; what was read is said in words, and replayed into a model.
 */
#ifndef TESTS_FUZZ_EXPLAIN_INPUT_H
#define TESTS_FUZZ_EXPLAIN_INPUT_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "drehgeber/devices.h"
#include "explain_edges.h"
#include "fuzz_input.h"

#define PATH "recording"

/* A file in memory with these bytes, at its beginning. */
static FILE *open_bytes(const uint8_t *bytes, size_t n)
{
    const int fd = memfd_create(PATH, MFD_CLOEXEC);

    fuzz_must(fd >= 0 && pwrite(fd, bytes, n, 0) == (ssize_t)n);
    FILE *file = fdopen(fd, "r");
    fuzz_must(file != NULL);
    return file;
}

static void check_error(const struct lx_error *error, size_t n)
{
    unsigned long long place = 0;

    if (strstr(error->what, ": no lib") != NULL) { /* the floor of edges finds that */
        return;
    }
    fuzz_must(sscanf(error->what, PATH ":%llu: ", &place) == 1 && place <= n);
    fuzz_must(error->right[0] != '\0');
}

static void check_event(const struct dg_tap_event *event, dg_ns before)
{
    fuzz_must(event->at >= before);
    if (event->kind == DG_TAP_FRAME) {
        fuzz_must(event->frame.id <= 0x7FF && event->frame.dlc <= 8);
    } else if (event->kind == DG_TAP_CHARACTER) {
        fuzz_must(event->character.baud > 0 && strchr("NEO", event->character.parity) != NULL);
    }
}

/* @return whether the file is one of the format, and nothing in it is wrong */
static bool read_events(const struct explain_format *format, const uint8_t *bytes, size_t n)
{
    FILE *file = open_bytes(bytes, n);
    struct lx_error error = {.what = ""};
    struct explain_source *source = explain_source_open(file, PATH, &error);
    const bool is_format = source != NULL && source->format == format;
    struct dg_tap_event event;
    dg_ns before = 0;
    int found = source == NULL ? -1 : 1;

    while (found == 1 && (found = explain_source_next(source, &event, &error)) == 1) {
        check_event(&event, before);
        before = event.at;
    }
    if (found < 0) {
        check_error(&error, n);
    }
    explain_source_close(source);
    fuzz_must(fclose(file) == 0);
    return found == 0 && is_format;
}

static void check_difference(void *ctx, const struct explain_difference *difference)
{
    (void)ctx;
    fuzz_must(difference->came != NULL || difference->model != NULL);
}

static void check_frame(void *ctx, const struct explain_message *message)
{
    (void)ctx;
    fuzz_must(message->n <= sizeof message->bytes);
}

/* The whole way of the command. */
static void replay_events(const uint8_t *bytes, size_t n, const char *model)
{
    static struct explain_replay replay;
    static struct explain_edges edges;
    struct options options = {.model = model, .device = dg_device_find(model)};
    struct lx_error error = {.what = ""};
    struct explain_model encoder;
    FILE *file = open_bytes(bytes, n);
    struct explain_talk talk = {.source = explain_source_open(file, PATH, &error)};

    fuzz_must(explain_model_make(&encoder, &options, &error) == 0);
    talk.address = explain_model_address(&encoder);
    const int found = talk.source == NULL ? 0 : explain_talk_begin(&talk, &error);
    if (found == 1 && talk.medium == options.device->stack->medium) {
        if (talk.medium == DG_MEDIUM_EDGES) {
            memset(&edges, 0, sizeof edges);
            edges.model = &encoder;
            edges.talk = &talk;
            edges.differs = check_difference;
            edges.frame = check_frame;
            fuzz_must(explain_edges_run(&edges, &error) == 0);
        } else {
            memset(&replay, 0, sizeof replay);
            replay.model = &encoder;
            replay.talk = &talk;
            replay.differs = check_difference;
            replay.frames = talk.medium == DG_MEDIUM_FRAMES;
            fuzz_must(explain_replay_run(&replay, &error) == 0);
        }
    }
    explain_talk_end(&talk);
    explain_source_close(talk.source);
    explain_model_free(&encoder);
    fuzz_must(fclose(file) == 0);
}

#endif
