/* SPDX-License-Identifier: MIT */
/*
 * Value change dump (IEEE 1364): levels, and a text. Strings are GTKWave's extension; sigrok skips
 * them (src/input/vcd.c of libsigrok: no white space, and a backslash would begin an escape).
 * A time in a file never goes back: what comes late is written late.
 */
#include <inttypes.h>
#include <string.h>

#include "trace_format.h"

#define TEXT_ID 't'
#define SINCOS_IDS "SsCc"
#define UV_PER_V 1000000
/* Readers that take samples see a level only when time goes on after it; no step is longer. */
#define LAST_LEVEL_NS DG_US(1)

static void put_time(struct lx_vcd *self, dg_ns at)
{
    if (at / self->step_ns > self->at / self->step_ns) {
        (void)fprintf(self->file, "#%" PRIu64 "\n", at / self->step_ns);
    }
    self->at = at > self->at ? at : self->at;
}

static void put_vcd_text(const struct lx_vcd *self, const char *text)
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

static void put_step(const struct lx_vcd *self)
{
    static const char *const units[] = {"ns", "us", "ms"};
    dg_ns step = self->step_ns;
    size_t unit = 0;
    for (; step >= 1000u && unit + 1u < DG_COUNT(units); unit++) {
        step /= 1000u;
    }
    (void)fprintf(self->file, "$timescale %" PRIu64 " %s $end\n", step, units[unit]);
}

void lx_vcd_begin(struct lx_vcd *self, const struct lx_trace *trace, const struct lx_vcd_head *head)
{
    const char *ids = head->ids;
    self->file = trace->file;
    self->step_ns = head->step_ns;
    (void)fprintf(self->file, LX_VCD_BEGIN " %s $end\n", trace->wire);
    put_step(self);
    (void)fprintf(self->file, "$scope module %s $end\n", head->scope);
    for (size_t i = 0; ids[i] != '\0'; i++) {
        (void)fprintf(self->file, "$var wire 1 %c %s $end\n", ids[i], head->names[i]);
    }
    (void)fprintf(self->file, "$var string 1 %c text $end\n", TEXT_ID);
    for (size_t i = 0; i < trace->tap->encoder_count; i++) {
        declare_sincos(self, i, trace->tap->encoders[i]);
    }
    (void)fputs("$upscope $end\n$enddefinitions $end\n#0\n$dumpvars\n", self->file);
    for (size_t i = 0; ids[i] != '\0'; i++) {
        (void)fprintf(self->file, "1%c\n", ids[i]);
    }
    put_vcd_text(self, "");
    (void)fputs("$end\n", self->file);
}

void lx_vcd_advance(struct lx_vcd *self, dg_ns at)
{
    size_t done = 0;
    for (; done < self->count && self->texts[done].at <= at; done++) {
        put_time(self, self->texts[done].at);
        put_vcd_text(self, self->texts[done].text);
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
