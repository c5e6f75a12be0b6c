/* SPDX-License-Identifier: MIT */
#include "engine_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static void collect(void *ctx, const char *bytes, size_t n)
{
    struct engine_rig *self = ctx;

    assert_true(strlen(self->answer) + n < sizeof self->answer);
    (void)strncat(self->answer, bytes, n);
}

static void fail_with(const struct dg_plan_error *error)
{
    fail_msg("line %u: %s: %s; %s", error->line, error->key, error->what, error->right);
}

void engine_rig_read(struct engine_rig *self, const char *text)
{
    const struct dg_plan_setup from = {.size = sizeof from,
                                       .file = "rig.ini",
                                       .text = {text, strlen(text)},
                                       .memory = self->plan_memory,
                                       .memory_size = sizeof self->plan_memory};

    memset(&self->error, 0, sizeof self->error);
    memset(&self->setup, 0, sizeof self->setup);
    if (dg_plan_read(&self->plan, &from, &self->error) != DG_OK) {
        fail_with(&self->error);
    }
    self->setup.size = sizeof self->setup;
    self->setup.plan = &self->plan;
    self->setup.begin = ENGINE_RIG_ON;
    self->setup.instruments = dg_instruments;
    self->setup.instrument_count = dg_instrument_count;
}

void engine_rig_make(struct engine_rig *self)
{
    assert_true(dg_engine_size(&self->setup) <= sizeof self->memory);
    self->engine = dg_engine_make(self->memory, sizeof self->memory, &self->setup, &self->error);
}

void engine_rig_power(struct engine_rig *self)
{
    engine_rig_make(self);
    if (self->engine == NULL ||
        dg_engine_power(self->engine, ENGINE_RIG_ON, &self->error) != DG_OK) {
        fail_with(&self->error);
    }
    engine_rig_connect(self);
}

void engine_rig_connect(struct engine_rig *self)
{
    dg_control_init(&self->client, dg_engine_control(self->engine), collect, self);
}

void engine_rig_start(struct engine_rig *self, const char *text)
{
    engine_rig_read(self, text);
    engine_rig_power(self);
}

const char *engine_rig_ask(struct engine_rig *self, dg_ns now, const char *line)
{
    self->answer[0] = '\0';
    (void)dg_control_rx(&self->client, now, line, strlen(line));
    (void)dg_control_rx(&self->client, now, "\n", 1);
    self->answer[strcspn(self->answer, "\n")] = '\0';
    return self->answer;
}

const char *engine_rig_refusal(struct engine_rig *self, dg_ns now, const char *line)
{
    assert_string_equal(engine_rig_ask(self, now, line), "");
    return engine_rig_ask(self, now, "SYST:ERR?");
}
