/* SPDX-License-Identifier: MIT */
/*
 * A session: bytes become lines, lines become commands.
 *
 *   collecting --end of line--> executing --end, error--> collecting
 *                               executing --*WAI, *OPC?--> waiting --settled--> executing
 *                               executing --dg_scpi_hold()--> poll ... poll --over--> executing
 *
 * The header path stands at the beginning of the line: it is made of headers that were read there,
 * so it is never longer than what they took, and a relative header is moved down to its end.
 */
#include "scpi_private.h"

#include <string.h>

#define FIRST_PRINTABLE ' '
#define LAST_PRINTABLE '~'

void dg_scpi_init(struct dg_scpi *self, const struct dg_scpi_setup *setup)
{
    memset(self, 0, sizeof *self);
    self->setup = *setup;
    self->esr = DG_SCPI_ESR_POWER_ON;
}

/* Everything but blanks and printable characters is garbage, and so is the line. */
static bool is_printable(const char *line, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if ((line[i] < FIRST_PRINTABLE || line[i] > LAST_PRINTABLE) && line[i] != '\t') {
            return false;
        }
    }
    return true;
}

/* Read a header and make it absolute at the beginning of the line. @return its length there, with
 * '?'; common headers stay where they are, and so does the path. */
static size_t read_header(struct dg_scpi *self, const char **header)
{
    const bool common = self->line[self->at] == '*';

    if (self->line[self->at] == ':') {
        self->at++;
        self->path = 0;
    }
    const uint16_t begin = self->at;
    while (!dg_scpi_is_end(self->line[self->at]) && self->line[self->at] != ' ' &&
           self->line[self->at] != '\t') {
        self->at++;
    }
    const size_t n = (size_t)self->at - begin;
    *header = common ? &self->line[begin] : self->line;
    if (common) {
        return n;
    }
    memmove(&self->line[self->path], &self->line[begin], n);
    return self->path + n;
}

/* SCPI-99 6.2.4: the next relative header stands beside this one. */
static void set_path(struct dg_scpi *self, const char *header, size_t n)
{
    if (header[0] == '*') {
        return;
    }
    while (n > 0 && header[n - 1u] != ':') {
        n--;
    }
    self->path = (uint16_t)n;
}

/* @return false: there is no such command */
static bool find_header(struct dg_scpi *self)
{
    const char *header;
    const size_t n = read_header(self, &header);

    self->query = n > 0 && header[n - 1u] == '?';
    const size_t bare = n - (self->query ? 1u : 0u);
    self->command = dg_scpi_find(self, header, bare, self->query);
    if (self->command == NULL) {
        dg_scpi_refuse_header(self, header, n, self->query);
        return false;
    }
    set_path(self, header, bare);
    return true;
}

/* "..." stands for any number of them. */
static bool takes_any_number(const char *parameters)
{
    while (parameters[0] != '\0' && (parameters[0] != '.' || parameters[1] != '.')) {
        parameters++;
    }
    return parameters[0] != '\0';
}

/* More parameters than a command has are found before it does anything. */
static bool has_too_many(const struct dg_scpi *self)
{
    const char *parameters = self->command->parameters;

    return !self->query && !takes_any_number(parameters) &&
           dg_scpi_count(&self->line[self->at]) > dg_scpi_count(parameters);
}

static void call_handler(struct dg_scpi *self)
{
    const struct dg_scpi_command *command = self->command;

    if (has_too_many(self)) {
        dg_scpi_raise_usage(self, DG_SCPI_SUPERFLUOUS);
        return;
    }
    (self->query ? command->query : command->set)(self);
    if (dg_scpi_more(self)) {
        dg_scpi_raise_usage(self, DG_SCPI_SUPERFLUOUS);
    } else if (self->query && !self->put && !self->waiting) {
        dg_scpi_begin(self); /* a client that has asked waits for a line */
    }
}

static void end_line(struct dg_scpi *self)
{
    if (self->answered) {
        self->setup.ops->write(self->setup.ctx, "\n", 1);
    }
    self->executing = false;
}

/* The next command of the line; empty ones are none. */
static void execute_next(struct dg_scpi *self)
{
    dg_scpi_skip_blanks(self);
    if (self->line[self->at] == '\0') {
        end_line(self);
        return;
    }
    if (self->line[self->at] == ';') {
        self->at++;
        return;
    }
    self->first = true;
    self->failed = false;
    self->put = false;
    if (find_header(self)) {
        call_handler(self);
        self->command = NULL;
    }
    if (self->failed) {
        end_line(self);
    }
}

/* End what *OPC, *OPC? and *WAI began, when it is time. @return when that will be, or DG_NEVER */
static dg_ns settle_waiting(struct dg_scpi *self)
{
    if (!self->waiting && !self->opc) {
        return DG_NEVER;
    }
    const dg_ns when = self->setup.ops->settled != NULL ? self->setup.ops->settled(self) : 0;
    if (when > self->now) {
        return when;
    }
    self->esr |= self->opc ? DG_SCPI_ESR_OPC : 0u;
    self->opc = false;
    self->waiting = false;
    if (self->answer_due) {
        self->answer_due = false;
        dg_scpi_put_number(self, 1, 0);
    }
    return DG_NEVER;
}

void dg_scpi_hold(struct dg_scpi *self, bool (*poll)(struct dg_scpi *self, bool gone))
{
    self->poll = poll;
}

/* As if it were called: nobody steps this session meanwhile. */
static bool poll_command(struct dg_scpi *self, bool gone)
{
    static const struct dg_scpi_command held = {.header = ""};

    self->command = &held;
    const bool over = self->poll(self, gone) || gone;
    self->command = NULL;
    if (over) {
        self->poll = NULL;
    }
    return over;
}

void dg_scpi_leave(struct dg_scpi *self)
{
    if (self->poll != NULL) {
        (void)poll_command(self, true);
        self->executing = false;
    }
}

/* A part of what a command goes on with. @return whether it does so still */
static bool continue_line(struct dg_scpi *self)
{
    if (self->poll == NULL) {
        return false;
    }
    if (poll_command(self, false) && self->failed) {
        end_line(self);
    }
    return self->poll != NULL;
}

dg_ns dg_scpi_step(struct dg_scpi *self, dg_ns now)
{
    if (self->command != NULL) {
        return self->now; /* a handler's change made the host step everybody: after the command */
    }
    self->now = now > self->now ? now : self->now; /* earlier: no time has passed (time.h) */
    if (continue_line(self)) {
        return self->now;
    }
    dg_ns deadline = settle_waiting(self);
    while (self->executing && !self->waiting) {
        execute_next(self);
        if (self->poll != NULL) {
            return self->now;
        }
        deadline = settle_waiting(self);
    }
    return deadline;
}

static void begin_line(struct dg_scpi *self)
{
    const bool usable = !self->overrun && is_printable(self->line, self->length);

    if (!self->overrun && !usable) {
        dg_scpi_raise(self, DG_SCPI_UNDEFINED, "not printable ASCII");
    }
    self->line[self->length] = '\0';
    self->length = 0;
    self->overrun = false;
    self->at = 0;
    self->path = 0;
    self->answered = false;
    self->executing = usable;
}

static void collect_input(struct dg_scpi *self, char c)
{
    if (c == '\n' || c == '\r') {
        begin_line(self);
        (void)dg_scpi_step(self, self->now);
    } else if (self->length < DG_SCPI_LINE_MAX) {
        self->line[self->length++] = c;
    } else if (!self->overrun) {
        self->overrun = true;
        dg_scpi_raise(self, DG_SCPI_OVERRUN, NULL);
    }
}

size_t dg_scpi_rx(struct dg_scpi *self, dg_ns now, const char *bytes, size_t n)
{
    size_t taken = 0;

    (void)dg_scpi_step(self, now);
    while (taken < n && !self->executing) {
        collect_input(self, bytes[taken]);
        taken++;
    }
    return taken;
}
