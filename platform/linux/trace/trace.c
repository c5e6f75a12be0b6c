/* SPDX-License-Identifier: MIT */
/*
 * A trace file listens to a tap. The wire never waits for it: a file that cannot be written is said
 * once, and from then on the trace is deaf.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <stdio_ext.h>
#include <stdlib.h>
#include <string.h>

#include "timer.h"
#include "trace_format.h"

#define FLUSH_NS DG_S(1)

static bool ends_in(const char *path, const char *ending)
{
    const size_t n = strlen(path);
    const size_t end = strlen(ending);
    return n > end && strcmp(path + n - end, ending) == 0 && path[n - end - 1] != '/';
}

static const struct lx_trace_format *find_format(const char *path, const struct lx_trace_kind *kind,
                                                 struct lx_error *error)
{
    struct lx_words right = {""};
    if (kind->formats[0] == NULL) {
        (void)lx_fail(error, "%s: the data on %s cannot be traced", path, kind->title);
        return NULL;
    }
    for (size_t i = 0; kind->formats[i] != NULL; i++) {
        const struct lx_trace_format *format = kind->formats[i];
        const bool known = format->also != NULL && ends_in(path, format->also);
        if (known || ends_in(path, format->ending)) {
            return format;
        }
        lx_words_add(&right, "%s%s", i == 0 ? "" : ", ", format->ending);
        lx_words_add(&right, "%s%s", format->also == NULL ? "" : ", ",
                     format->also == NULL ? "" : format->also);
    }
    (void)lx_fail(error, "%s: the name of a trace of %s ends in %s", path, kind->title, right.text);
    return NULL;
}

int lx_trace_fits(const char *path, const struct lx_trace_kind *kind, struct lx_error *error)
{
    return find_format(path, kind, error) == NULL ? -1 : 0;
}

/* The name of an interface, or the last part of a path, fit for every format. */
static void set_wire(struct lx_trace *self, const char *wire)
{
    static const char fit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.";
    const char *slash = strrchr(wire, '/');
    const char *name = slash == NULL ? wire : slash + 1;
    (void)snprintf(self->wire, sizeof self->wire, "%s", name[0] == '\0' ? "wire" : name);
    for (char *at = self->wire + strspn(self->wire, fit); *at != '\0'; at += strspn(at, fit)) {
        *at = '_';
    }
}

/* After something was written: whether all is well. */
static bool check_stream(struct lx_trace *self)
{
    if (self->good && ferror(self->file) != 0) {
        self->reason = errno;
        self->good = false;
        __fpurge(self->file); /* else closing it would try again, and leave a gap */
    }
    return self->good;
}

static void flush_trace(struct lx_trace *self)
{
    (void)fflush(self->file);
    (void)check_stream(self);
}

static void on_event(void *ctx, const struct dg_tap_event *event)
{
    struct lx_trace *self = ctx;
    if (!self->good) {
        return;
    }
    self->format->event(self, event);
    if (check_stream(self) && dg_elapsed(event->at, self->flushed) >= FLUSH_NS) {
        self->flushed = event->at;
        flush_trace(self);
    }
    if (!self->good) {
        lx_complain("%s: %s; the trace ends here", self->path, strerror(self->reason));
    }
}

static void discard_trace(struct lx_trace *self)
{
    if (self->file != NULL) {
        (void)fclose(self->file);
    }
    free(self->memory);
    free(self->own);
    free(self->path);
    free(self);
}

static int begin_format(struct lx_trace *self, const struct lx_trace_setup *setup,
                        struct lx_error *error)
{
    const char *path = setup->path;
    const struct lx_file_wanted wanted = {
        .folder = setup->folder,
        .path = path,
        .mark = self->format->mark.n == 0 ? NULL : &self->format->mark,
    };
    self->own = calloc(1, self->format->size);
    self->memory = setup->words == NULL ? NULL : calloc(1, setup->words->size);
    self->path = strdup(path);
    if (self->own == NULL || self->path == NULL || (setup->words != NULL && self->memory == NULL)) {
        return lx_fail(error, "%s: no memory for a trace", path);
    }
    self->file = lx_file_create(&wanted, setup->held ? &self->held : NULL, error);
    if (self->file == NULL) {
        return -1;
    }
    self->good = true;
    if (self->format->begin != NULL) {
        self->format->begin(self);
    }
    flush_trace(self);
    return self->good
               ? 0
               : lx_fail(error, "cannot write the trace '%s': %s", path, strerror(self->reason));
}

struct lx_trace *lx_trace_open(const struct lx_trace_setup *setup, dg_ns now,
                               struct lx_error *error)
{
    const struct lx_trace_format *format = find_format(setup->path, setup->kind, error);
    if (format == NULL) {
        return NULL;
    }
    struct lx_trace *self = lx_allocate(sizeof *self, "a trace", error);
    if (self == NULL) {
        return NULL;
    }
    self->format = format;
    self->words = setup->words;
    self->tap = setup->tap;
    self->listener =
        (struct lx_tap_listener){.event = on_event, .ctx = self, .sincos = setup->kind->sincos};
    self->opened = now;
    self->flushed = now;
    self->day_ns = lx_time_of_day() - now;
    set_wire(self, setup->wire);
    if (begin_format(self, setup, error) != 0) {
        discard_trace(self);
        return NULL;
    }
    lx_tap_add(self->tap, &self->listener);
    return self;
}

int lx_trace_release(struct lx_trace *self, struct lx_error *error)
{
    if (self == NULL || self->held == NULL) {
        return 0;
    }
    flush_trace(self);
    const int reason = lx_file_release(self->held);
    self->held = NULL;
    return reason == 0
               ? 0
               : lx_fail(error, "cannot write the trace '%s': %s", self->path, strerror(reason));
}

int lx_trace_close(struct lx_trace *self, struct lx_error *error)
{
    int result = 0;
    if (self == NULL) {
        return 0;
    }
    lx_tap_remove(self->tap, &self->listener);
    if (self->good) {
        if (self->format->end != NULL) {
            self->format->end(self);
        }
        flush_trace(self);
    }
    if (fclose(self->file) != 0 && self->good) {
        self->reason = errno;
        self->good = false;
    }
    self->file = NULL;
    if (!self->good) {
        result = lx_fail(error, "the trace '%s' is not complete: %s", self->path,
                         strerror(self->reason));
    }
    discard_trace(self);
    return result;
}
