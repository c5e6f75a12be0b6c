/* SPDX-License-Identifier: MIT */
/*
 * For languages without pointers (VHDL): instances by number, which a test bench finds by their
 * names; texts one character at a time; moments as microseconds and the picoseconds behind them.
 * The list lasts as long as the process, as the simulation does, unless somebody ends it.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/api.h"
#include "hdl_names.h"
#include "hdl_private.h"

#define PS_PER_US 1000000
/* Of a name and what is said of it. */
#define NOTE_MAX 1400

struct instance {
    char *name;
    struct dg_hdl *encoder;
    const char *answer;
};

static struct instance *instances;
static int32_t count;
static bool ends; /* somebody tells at the end */

void dg_hdl_make_none(void)
{
    for (int32_t i = 0; i < count; i++) {
        free(instances[i].name);
        dg_hdl_close(instances[i].encoder);
    }
    free(instances);
    instances = NULL;
    count = 0;
}

static int64_t ps_of_us(int32_t us, int32_t ps)
{
    return (int64_t)us * PS_PER_US + ps;
}

static struct dg_hdl *encoder_of(int32_t id)
{
    return id >= 0 && id < count ? instances[id].encoder : NULL;
}

int32_t dg_hdl_find(const char *name)
{
    for (int32_t i = 0; i < count; i++) {
        if (strcmp(instances[i].name, hdl_text(name)) == 0) {
            return i;
        }
    }
    return -1;
}

static char *copy_of(const char *text)
{
    const size_t size = strlen(text) + 1u;
    char *copy = malloc(size);

    return copy != NULL ? memcpy(copy, text, size) : NULL;
}

/* These languages have no place for what is said at the end. */
static void tell_at_end(void)
{
    for (int32_t i = 0; i < count; i++) {
        const char *text = dg_hdl_hint(instances[i].encoder, 1);
        if (text[0] != '\0') {
            (void)printf("%s: %s\n", instances[i].name, text);
        }
    }
}

int32_t dg_hdl_make(const char *name, const char *model, const char *settings, const char *motion,
                    const char *memory)
{
    struct instance *more = realloc(instances, ((size_t)count + 1u) * sizeof *more);

    if (more == NULL) {
        return -1;
    }
    instances = more;
    if (!ends) {
        ends = atexit(tell_at_end) == 0;
    }
    if (dg_hdl_find(name) >= 0) {
        return -2;
    }
    const struct instance one = {.name = copy_of(hdl_text(name)),
                                 .encoder = dg_hdl_open(model, settings, motion, memory),
                                 .answer = ""};
    if (one.name == NULL || one.encoder == NULL) {
        free(one.name);
        dg_hdl_close(one.encoder);
        return -1;
    }
    instances[count] = one;
    return count++;
}

int32_t dg_hdl_look(int32_t id, int32_t us, int32_t ps, int32_t inputs)
{
    return dg_hdl_wires(encoder_of(id), ps_of_us(us, ps), inputs);
}

int32_t dg_hdl_rest(int32_t id, int32_t us, int32_t ps, int32_t most)
{
    const int64_t next = dg_hdl_next(encoder_of(id));
    const int64_t rest = next - ps_of_us(us, ps);

    return next == DG_HDL_NEVER || rest > most ? most : (int32_t)rest;
}

/* The signature of the steering functions differs in what they take; each gives 0 or less. */
int32_t dg_hdl_steer(int32_t id, int32_t us, int32_t ps, int32_t what, const char *name,
                     double value)
{
    struct dg_hdl *self = encoder_of(id);
    const int64_t now = ps_of_us(us, ps);

    switch ((enum dg_hdl_steering)what) {
    case DG_HDL_TURN:
        return dg_hdl_turn(self, now, value);
    case DG_HDL_SPEED:
        return dg_hdl_speed(self, now, value);
    case DG_HDL_MOTION:
        return dg_hdl_motion(self, now, name);
    case DG_HDL_WORLD:
        return dg_hdl_world(self, now, name, value);
    case DG_HDL_FAULT:
        return dg_hdl_fault(self, now, name, value != 0.0);
    case DG_HDL_POWER:
        return dg_hdl_power(self, now, value != 0.0);
    case DG_HDL_COMMAND:
        instances[id].answer = dg_hdl_command(self, now, name);
        return instances[id].answer != NULL ? 0 : -1;
    }
    return -1;
}

int32_t dg_hdl_character(int32_t id, int32_t which, int32_t index)
{
    const char *text = instances[id].answer;
    char note[NOTE_MAX];

    if (which == DG_HDL_ERROR) {
        text = dg_hdl_error(encoder_of(id));
    } else if (which == DG_HDL_NOTE) {
        (void)snprintf(note, sizeof note, "%s: %s", instances[id].name,
                       dg_hdl_hint(encoder_of(id), 0));
        text = note;
    }
    return text != NULL && (size_t)index < strlen(text) ? (unsigned char)text[index] : 0;
}

double dg_hdl_real(int32_t id, int32_t us, int32_t ps, int32_t what)
{
    const struct dg_hdl *self = encoder_of(id);
    const int64_t at = ps_of_us(us, ps);

    switch ((enum dg_hdl_look)what) {
    case DG_HDL_POSITION:
        return (double)dg_hdl_position(self, at);
    case DG_HDL_LATCHED:
        return (double)dg_hdl_latched(self);
    case DG_HDL_LATCHED_AT_US:
        return (double)dg_hdl_latched_at(self) / PS_PER_US;
    case DG_HDL_SINE:
        return dg_hdl_volts(self, at, 0) - dg_hdl_volts(self, at, 1);
    case DG_HDL_COSINE:
        return dg_hdl_volts(self, at, 2) - dg_hdl_volts(self, at, 3);
    }
    return 0.0;
}
