/* SPDX-License-Identifier: MIT */
/*
 * Value change dump (IEEE 1364): levels, and a text. Strings are GTKWave's extension; sigrok skips
 * them (src/input/vcd.c of libsigrok: no white space, and a backslash would begin an escape).
 *
 * BiSS levels are held back for a moment, so that the note on a frame, which comes when it is over,
 * can stand where it began. A time in a file never goes back: what comes late is written late.
 */
#include <inttypes.h>
#include <string.h>

#include "drehgeber/biss.h"
#include "trace_format.h"

#define TEXT_ID 't'
#define SINCOS_IDS "SsCc"
#define UV_PER_V 1000000
/* Readers that take samples see a level only when time goes on after it. */
#define LAST_LEVEL_NS DG_US(1)
/* Levels of BiSS that are held back: some frames, and not for long. */
#define HELD 1024u
#define HELD_MAX DG_MS(100)

static void put_time(struct lx_vcd *self, dg_ns at)
{
    if (at > self->at) {
        (void)fprintf(self->file, "#%" PRIu64 "\n", at);
        self->at = at;
    }
}

static void put_text(const struct lx_vcd *self, const char *text)
{
    (void)fputc('s', self->file);
    for (; *text != '\0'; text++) {
        const bool plain = *text > ' ' && *text <= '~' && *text != '\\';
        (void)fputc(plain ? *text : '_', self->file);
    }
    (void)fprintf(self->file, " %c\n", TEXT_ID);
}

/* Identifiers of two characters and more; those of the wire have one. */
static void declare_sincos(struct lx_vcd *self, size_t encoder, const char *name)
{
    static const char *const lines[LX_VCD_SINCOS] = {"sin_plus", "sin_minus", "cos_plus",
                                                     "cos_minus"};
    (void)fprintf(self->file, "$scope module %s $end\n", name);
    for (size_t i = 0; i < LX_VCD_SINCOS; i++) {
        (void)fprintf(self->file, "$var real 64 %c%zu %s $end\n", SINCOS_IDS[i], encoder, lines[i]);
    }
    (void)fputs("$upscope $end\n", self->file);
}

void lx_vcd_begin(struct lx_vcd *self, const struct lx_trace *trace, const char *scope,
                  const char *const *names, const char *ids)
{
    self->file = trace->file;
    (void)fprintf(self->file,
                  LX_VCD_BEGIN " %s $end\n$timescale 1 ns $end\n$scope module %s $end\n",
                  trace->wire, scope);
    for (size_t i = 0; ids[i] != '\0'; i++) {
        (void)fprintf(self->file, "$var wire 1 %c %s $end\n", ids[i], names[i]);
    }
    (void)fprintf(self->file, "$var string 1 %c text $end\n", TEXT_ID);
    for (size_t i = 0; i < trace->tap->encoder_count; i++) {
        declare_sincos(self, i, trace->tap->encoders[i]);
    }
    (void)fputs("$upscope $end\n$enddefinitions $end\n#0\n$dumpvars\n", self->file);
    for (size_t i = 0; ids[i] != '\0'; i++) {
        (void)fprintf(self->file, "1%c\n", ids[i]);
    }
    put_text(self, "");
    (void)fputs("$end\n", self->file);
}

void lx_vcd_advance(struct lx_vcd *self, dg_ns at)
{
    size_t done = 0;
    for (; done < self->count && self->texts[done].at <= at; done++) {
        put_time(self, self->texts[done].at);
        put_text(self, self->texts[done].text);
    }
    self->count -= done;
    memmove(self->texts, self->texts + done, self->count * sizeof self->texts[0]);
}

void lx_vcd_level(struct lx_vcd *self, dg_ns at, char id, bool level)
{
    lx_vcd_advance(self, at);
    put_time(self, at);
    (void)fprintf(self->file, "%d%c\n", level, id);
}

void lx_vcd_sincos(struct lx_vcd *self, dg_ns at, size_t encoder, const int32_t uv[LX_VCD_SINCOS])
{
    lx_vcd_advance(self, at);
    put_time(self, at);
    for (size_t i = 0; i < LX_VCD_SINCOS; i++) { /* no voltage here is below 0 */
        (void)fprintf(self->file, "r%d.%06d %c%zu\n", uv[i] / UV_PER_V, uv[i] % UV_PER_V,
                      SINCOS_IDS[i], encoder);
    }
}

void lx_vcd_text(struct lx_vcd *self, dg_ns at, const char *text)
{
    if (self->count == LX_VCD_TEXTS) {
        lx_vcd_advance(self, self->texts[0].at); /* what began before it is late */
    }
    size_t place = self->count;
    for (; place > 0 && self->texts[place - 1].at > at; place--) {
        self->texts[place] = self->texts[place - 1];
    }
    self->texts[place].at = at;
    (void)snprintf(self->texts[place].text, sizeof self->texts[place].text, "%s", text);
    self->count++;
}

void lx_vcd_end(struct lx_vcd *self)
{
    lx_vcd_advance(self, DG_NEVER);
    put_time(self, dg_after(self->at, LAST_LEVEL_NS));
}

/* ---------------------------------------------------------------- BiSS */

/* A level that is held back. */
struct held {
    dg_ns at;
    char id;
    bool level;
};

struct biss {
    struct lx_vcd vcd;
    bool ma;
    bool slo;
    bool begun; /* there was an event */
    size_t first;
    size_t count;
    struct held held[HELD];
};

static void biss_begin(struct lx_trace *self)
{
    static const char *const names[] = {"MA", "SLO"};
    struct biss *biss = self->own;
    biss->ma = true;
    biss->slo = true;
    lx_vcd_begin(&biss->vcd, self, "biss", names, "ms");
}

/* All levels and texts up to `at`. */
static void release(struct biss *self, dg_ns at)
{
    while (self->count > 0 && self->held[self->first].at <= at) {
        const struct held *oldest = &self->held[self->first];
        lx_vcd_level(&self->vcd, oldest->at, oldest->id, oldest->level);
        self->first = (self->first + 1u) % HELD;
        self->count--;
    }
    lx_vcd_advance(&self->vcd, at);
}

static void hold(struct biss *self, dg_ns at, char id, bool level)
{
    if (self->count == HELD) {
        release(self, self->held[self->first].at);
    }
    self->held[(self->first + self->count) % HELD] = (struct held){at, id, level};
    self->count++;
}

static void on_note(struct biss *self, dg_ns at, const char *note)
{
    if (self->vcd.count == LX_VCD_TEXTS) {
        release(self, self->vcd.texts[0].at);
    }
    lx_vcd_text(&self->vcd, at, note);
}

/* SLO is low from power-on to the first clock. Nobody tells of it before the first edge of MA,
   which is a falling one and leaves SLO as it was. */
static void begin_at(struct biss *self, bool slo)
{
    if (!self->begun && slo != self->slo && self->vcd.at == 0) {
        self->slo = slo;
        lx_vcd_level(&self->vcd, 0, 's', slo);
    }
    self->begun = true;
}

static void on_levels(struct biss *self, dg_ns at, bool ma, bool slo)
{
    begin_at(self, slo);
    if (ma != self->ma) {
        hold(self, at, 'm', ma);
    }
    if (slo != self->slo) {
        hold(self, at, 's', slo);
    }
    self->ma = ma;
    self->slo = slo;
}

static void biss_event(struct lx_trace *self, const struct lx_tap_event *event)
{
    struct biss *biss = self->own;
    const dg_ns at = dg_elapsed(event->at, self->opened);
    release(biss, dg_elapsed(at, HELD_MAX));
    if (event->kind == LX_TAP_NOTE) {
        on_note(biss, at, event->note);
    } else if (event->kind == LX_TAP_LEVELS) {
        on_levels(biss, at, event->levels.ma, event->levels.slo);
    }
}

static void biss_end(struct lx_trace *self)
{
    struct biss *biss = self->own;
    release(biss, DG_NEVER);
    lx_vcd_end(&biss->vcd);
}

const struct lx_trace_format lx_trace_biss = {
    ".vcd", LX_VCD_MARK, &dg_biss_stack, sizeof(struct biss), biss_begin, biss_event, biss_end,
};
