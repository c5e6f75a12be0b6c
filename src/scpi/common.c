/* SPDX-License-Identifier: MIT */
/*
 * Commands that every session has: common ones (IEEE 488.2 10) and SYSTem (SCPI-99 volume 2, 21).
 */
#include "scpi_private.h"

#define SCPI_VERSION 19990 /* 1999.0 */
#define REGISTER_MAX 255

/* Registers with an argument of their own: one row's function serves both masks. */
enum mask { EVENTS, REQUESTS };

static uint8_t *enable_mask_of(struct dg_scpi *self)
{
    return self->command->argument == EVENTS ? &self->ese : &self->sre;
}

static void set_mask(struct dg_scpi *self)
{
    static const struct dg_scpi_range range = {.unit = DG_SCPI_PLAIN, .max = REGISTER_MAX};
    /* 11.3.2.3: no bit lets the service request request itself. */
    const bool events = self->command->argument == EVENTS;
    const unsigned kept = events ? REGISTER_MAX : REGISTER_MAX - DG_SCPI_STB_SERVICE;
    int64_t value;

    if (dg_scpi_number(self, &range, &value)) {
        *enable_mask_of(self) = (uint8_t)((unsigned)value & kept);
    }
}

static void get_mask(struct dg_scpi *self)
{
    dg_scpi_put_number(self, *enable_mask_of(self), 0);
}

static void clear(struct dg_scpi *self)
{
    self->esr = 0;
    self->opc = false;
    dg_scpi_clear_errors(self);
}

static void reset(struct dg_scpi *self)
{
    self->opc = false;
    if (self->setup.ops->reset != NULL) {
        self->setup.ops->reset(self);
    }
}

static void get_idn(struct dg_scpi *self)
{
    dg_scpi_put_word(self, self->setup.idn);
}

/* Reading it clears it; not when there is no answer. */
static void get_events(struct dg_scpi *self)
{
    dg_scpi_put_number(self, self->esr, 0);
    if (!self->failed) {
        self->esr = 0;
    }
}

static void get_status_byte(struct dg_scpi *self)
{
    dg_scpi_put_number(self, dg_scpi_status_byte(self), 0);
}

static void get_self_test(struct dg_scpi *self)
{
    dg_scpi_put_number(self, 0, 0);
}

static void complete(struct dg_scpi *self)
{
    self->opc = true;
}

static void wait(struct dg_scpi *self)
{
    self->waiting = true;
}

static void wait_and_answer(struct dg_scpi *self)
{
    if (!dg_scpi_more(self)) {
        self->waiting = true;
        self->answer_due = true;
    }
}

static void get_error(struct dg_scpi *self)
{
    dg_scpi_put_error(self);
}

static void get_all_errors(struct dg_scpi *self)
{
    do {
        dg_scpi_put_error(self);
    } while (self->error_count > 0 && !self->failed);
}

static void get_error_count(struct dg_scpi *self)
{
    dg_scpi_put_number(self, self->error_count, 0);
}

static void get_version(struct dg_scpi *self)
{
    dg_scpi_put_number(self, SCPI_VERSION, 1);
}

static void put_usage(struct dg_scpi *self, const struct dg_scpi_command *row, bool query)
{
    const char *pieces[SCPI_USAGE];

    dg_scpi_usage(row, query, pieces);
    dg_scpi_begin(self);
    dg_scpi_append(self, "\"");
    for (size_t i = 0; i < SCPI_USAGE; i++) {
        dg_scpi_append_quoted(self, pieces[i]);
    }
    dg_scpi_append(self, "\"");
}

static void put_rows(struct dg_scpi *self, const struct dg_scpi_commands *list)
{
    for (size_t i = 0; i < list->count; i++) {
        const struct dg_scpi_command *row = &list->rows[i];
        if (row->set != NULL) {
            put_usage(self, row, false);
        }
        if (row->query != NULL) {
            put_usage(self, row, true);
        }
    }
}

static void get_help(struct dg_scpi *self)
{
    const struct dg_scpi_commands *list;

    for (size_t i = 0; (list = dg_scpi_command_list(self, i)) != NULL; i++) {
        put_rows(self, list);
    }
}

/* clang-format off */
static const struct dg_scpi_command rows[] = {
    {"*CLS", clear,    NULL,            0,        "",      "clear the event register and the error queue"},
    {"*ESE", set_mask, get_mask,        EVENTS,   "MASK",  "events that set bit 5 of the status byte"},
    {"*ESR", NULL,     get_events,      0,        "",      "event register; reading clears it"},
    {"*IDN", NULL,     get_idn,         0,        "",      "maker, model, serial number, version"},
    {"*OPC", complete, wait_and_answer, 0,        "",      "bit 0 of the event register, or 1, when all that takes time is over"},
    {"*RST", reset,    NULL,            0,        "",      "back to the state after the start"},
    {"*SRE", set_mask, get_mask,        REQUESTS, "MASK",  "bits of the status byte that set its bit 6"},
    {"*STB", NULL,     get_status_byte, 0,        "",      "status byte"},
    {"*TST", NULL,     get_self_test,   0,        "",      "self-test: 0, passed"},
    {"*WAI", wait,     NULL,            0,        "",      "go on when all that takes time is over"},
    {"SYSTem:ERRor[:NEXT]",    NULL, get_error,       0, "", "oldest error, which leaves the queue"},
    {"SYSTem:ERRor:ALL",       NULL, get_all_errors,  0, "", "all errors, which leave the queue"},
    {"SYSTem:ERRor:COUNt",     NULL, get_error_count, 0, "", "errors in the queue"},
    {"SYSTem:HELP[:HEADers]",  NULL, get_help,        0, "", "all commands"},
    {"SYSTem:VERSion",         NULL, get_version,     0, "", "version of SCPI"},
};
/* clang-format on */
const struct dg_scpi_commands dg_scpi_own = {rows, DG_COUNT(rows)};
