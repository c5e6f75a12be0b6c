/* SPDX-License-Identifier: MIT */
/* Rows of clauses, run against a real encoder. */
#define _GNU_SOURCE
#include "verify.h"

#include <errno.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "complain.h"
#include "eds_file.h"
#include "say.h"
#include "silkit.h"
#include "stacks.h"
#include "timer.h"
#include "verify_parts.h"
#include "verify_silkit.h"
#include "verify_stream.h"

static const struct verify_protocol *const protocols[] = {
    &verify_hiperface, &verify_biss, &verify_ssi, &verify_canopen, &verify_interbus,
};

/* How often a row is made for which this host was late. */
#define TRIES_MAX 5u

/* What --help and the lines call what a row needs. */
static const struct {
    unsigned need;
    const char *text;
} needs[] = {
    {CF_SHAFT, "a shaft that is turned as the row says"},
    {CF_INSIDE, "a change, or a measurement, inside the encoder, which no wire can reach"},
    {CF_EXACT, "times or settings of the wire that this host cannot make exactly"},
    {CF_ALONE, "an encoder that is alone on its wire (--alone)"},
    {CF_WRITE, "to change the encoder and to change it back (--write)"},
    {CF_ONE_WAY, "to change the encoder permanently (--irreversible)"},
    {CF_POWER, "a supply that can be cut (--power)"},
    {CF_RING, "other encoders on its wire, or a wire that is cut"},
};

/* --- the rehearsal --- */

/* What a row would do. */
struct rehearsal {
    const struct verify_protocol *protocol;
    struct verify_encoder *encoder;
    unsigned needs;
    uint64_t takes; /* ns that it waits */
};

static bool same_unit(const struct cf_unit *a, const struct cf_unit *b)
{
    return b->bytes != NULL && a->id == b->id && a->rtr == b->rtr && a->n == b->n &&
           memcmp(a->bytes, b->bytes, a->n) == 0;
}

static bool rehearse_sent(void *ctx, const struct cf_unit *request, struct cf_report *report)
{
    struct rehearsal *self = ctx;
    (void)report;
    self->needs |= self->protocol->needs(self->encoder, request);
    return true;
}

static bool rehearse_answered(void *ctx, const struct cf_answer *answer, struct cf_report *report)
{
    struct rehearsal *self = ctx;
    self->takes += answer->earliest_ns;
    return same_unit(&answer->want, &answer->got) ||
           cf_fail(report, "the model of this encoder answers differently");
}

/* A span that is shorter than a host may be late. */
static bool rehearse_silent(void *ctx, uint64_t ns, struct cf_report *report)
{
    struct rehearsal *self = ctx;
    (void)report;
    self->takes += ns;
    self->needs |= ns > 1u && ns < DG_MS(50) ? CF_EXACT : 0u;
    return true;
}

static bool rehearse_waited(void *ctx, uint64_t ns, struct cf_report *report)
{
    struct rehearsal *self = ctx;
    (void)report;
    self->takes += ns;
    return true;
}

static bool rehearse_powered(void *ctx, bool on, struct cf_report *report)
{
    struct rehearsal *self = ctx;
    (void)on;
    (void)report;
    self->needs |= CF_POWER;
    return true;
}

static bool rehearse_needs(void *ctx, unsigned wanted, struct cf_report *report)
{
    struct rehearsal *self = ctx;
    (void)report;
    self->needs |= wanted;
    return true;
}

static const struct cf_beside_ops rehearsal_ops = {
    .sent = rehearse_sent,
    .answered = rehearse_answered,
    .silent = rehearse_silent,
    .waited = rehearse_waited,
    .powered = rehearse_powered,
    .needs = rehearse_needs,
};

/* --- a row --- */

/* Everything at work. */
struct verify {
    const struct options *options;
    const struct verify_protocol *protocol;
    struct verify_encoder *encoder;
    unsigned allowed;               /* bits of enum cf_need */
    struct verify_journal *journal; /* owned; NULL: nothing may be changed */
    struct verify_result result;
};

bool verify_fail(struct verify_encoder *self, enum verify_outcome outcome, struct cf_report *report,
                 const char *format, ...)
{
    va_list args;
    va_start(args, format);
    (void)vsnprintf(report->text, sizeof report->text, format, args);
    va_end(args);
    self->outcome = outcome;
    return false;
}

size_t verify_print_unit(const struct cf_unit *unit, char *to, size_t size)
{
    size_t at = 0;
    if (unit->bytes == NULL) {
        return (size_t)snprintf(to, size, " nothing");
    }
    if (unit->id != 0) {
        at = (size_t)snprintf(to, size, " %03X%s", unit->id, unit->rtr ? " remote" : "");
    }
    for (size_t i = 0; !unit->rtr && i < unit->n && at + 4 < size; i++) {
        at += (size_t)snprintf(to + at, size - at, " %02X", unit->bytes[i]);
    }
    return at;
}

/* "a row ...:" is not said: the text behind the file's name. */
static struct verify_row make_row(enum verify_outcome outcome, const char *text)
{
    struct verify_row row = {.outcome = outcome};
    if (outcome != VERIFY_AGREES) {
        row.text = strndup(text, VERIFY_TEXT_MAX);
    }
    return row;
}

/* What its steps need whatever they say. */
static unsigned needs_of_steps(const struct cf_suite *suite, const struct cf_row *row,
                               const struct cf_device *device)
{
    unsigned wanted = 0;
    for (size_t i = 0; i < row->line_count; i++) {
        const struct cf_step *step = cf_find_step(device, suite->lines[row->first_line + i].text);
        wanted |= step == NULL ? 0u : step->needs;
    }
    return wanted;
}

static struct verify_row refuse_row(unsigned missing)
{
    struct lx_words text = {"needs "};
    size_t n = 0;
    for (size_t i = 0; i < DG_COUNT(needs); i++) {
        if ((missing & needs[i].need) != 0) {
            lx_words_add(&text, "%s%s", n++ == 0 ? "" : "; ", needs[i].text);
        }
    }
    return make_row(VERIFY_NOT_SEEN, text.text);
}

/* Whether the row can be run, and is about such an encoder; if not, `to` says why. */
static bool rehearse(struct verify *self, const struct cf_suite *suite, const struct cf_row *row,
                     struct verify_row *to)
{
    const struct cf_device *device = self->protocol->rows();
    struct rehearsal rehearsal = {.protocol = self->protocol, .encoder = self->encoder};
    const struct cf_beside beside = {&rehearsal_ops, &rehearsal};
    struct cf_report report = {0};
    unsigned missing = needs_of_steps(suite, row, device) & ~self->allowed;
    if ((missing & (CF_SHAFT | CF_INSIDE)) != 0) {
        *to = refuse_row(missing & (CF_SHAFT | CF_INSIDE));
        return false;
    }
    self->protocol->rehearse(self->encoder, &beside, 0);
    const bool fits = cf_run(suite, row, device, &report);
    const bool quick = rehearsal.takes <= VERIFY_ROW_MAX;
    self->protocol->rehearse(self->encoder, &beside, VERIFY_SLACK);
    if (fits && !cf_run(suite, row, device, &report)) {
        missing |= CF_EXACT;
    }
    missing |= rehearsal.needs & ~self->allowed;
    self->encoder->cuts = (rehearsal.needs & CF_POWER) != 0;
    if (!fits) {
        *to = make_row(VERIFY_NOT_SEEN, "is about an encoder with other figures");
    } else if (missing != 0) {
        *to = refuse_row(missing);
    } else if (!quick) {
        *to = make_row(VERIFY_NOT_SEEN, "takes longer than 10 s");
    }
    return fits && missing == 0 && quick;
}

/* --- the supply --- */

/* Somebody sits in front of it, and waits for questions. */
static bool can_ask(const struct options *options)
{
    return options->power == NULL && !options->say.quiet && isatty(STDIN_FILENO) &&
           isatty(STDERR_FILENO);
}

/* @return false: what was typed is no Enter, and nothing was switched */
static bool ask_user(bool on)
{
    char line[80];
    (void)fprintf(stderr, "\r\nSwitch the encoder %s, and press Enter. ", on ? "on" : "off");
    return fgets(line, sizeof line, stdin) != NULL && line[0] == '\n';
}

static bool run_relay(const char *program, bool on)
{
    char command[4096];
    const int n = snprintf(command, sizeof command, "%s %s", program, on ? "on" : "off");
    char shell[] = "sh";
    char option[] = "-c";
    char *const words[] = {shell, option, command, NULL};
    pid_t child = 0;
    int status = 0;
    return n > 0 && (size_t)n < sizeof command &&
           posix_spawn(&child, "/bin/sh", NULL, NULL, words, environ) == 0 &&
           waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool verify_powered(void *encoder, bool on, struct cf_report *report)
{
    struct verify_encoder *self = encoder;
    if (self->power != NULL && !run_relay(self->power, on)) {
        return verify_fail(self, VERIFY_LOST, report, "'%s %s' has failed", self->power,
                           on ? "on" : "off");
    }
    if (self->power == NULL && !ask_user(on)) {
        self->declined = true;
        return verify_fail(self, on ? VERIFY_LOST : VERIFY_NOT_SEEN, report,
                           "its supply was not switched");
    }
    self->off = !on;
    verify_stream_wait(self->stream, lx_now() + VERIFY_START);
    self->since = lx_now();
    return true;
}

bool verify_allowed(void *encoder, unsigned wanted, struct cf_report *report)
{
    (void)encoder;
    (void)wanted;
    (void)report;
    return true;
}

/* --- attempts --- */

/* Whatever became of the row, what it has changed is put back. A request that a busy host has torn is
   not answered: it has three chances. */
static bool put_back(struct verify *self)
{
    struct cf_report report = {""};
    if (self->journal == NULL || self->journal->count == 0) {
        return true;
    }
    bool back = false;
    for (unsigned i = 0; !back && i < 3; i++) {
        back = self->protocol->put_back(self->encoder, &report);
    }
    if (back && verify_journal_clear(self->journal)) {
        return true;
    }
    (void)snprintf(
        self->result.lost, sizeof self->result.lost,
        "the encoder does not have its old values (%.400s); --restore puts them back from %.400s",
        report.text, self->journal->path);
    return false;
}

/* Run a row that has been rehearsed. False: nobody is there any more. */
static bool try_once(struct verify *self, const struct cf_suite *suite, const struct cf_row *row,
                     struct verify_row *to)
{
    struct verify_encoder *encoder = self->encoder;
    struct cf_report report = {""};
    encoder->outcome = VERIFY_AGREES;
    encoder->held_up = false;
    if (!self->protocol->begin(encoder, &report)) {
        *to = make_row(VERIFY_NOT_SEEN, report.text);
        return false;
    }
    if (!cf_run(suite, row, self->protocol->rows(), &report) && encoder->outcome == VERIFY_AGREES) {
        encoder->outcome = VERIFY_NOT_SEEN; /* the model's own state: a step it refuses */
    }
    *to = make_row(encoder->outcome, report.text);
    self->allowed &= encoder->declined ? ~(unsigned)CF_POWER : ~0u;
    if (encoder->off && !verify_powered(encoder, true, &report)) {
        (void)snprintf(self->result.lost, sizeof self->result.lost,
                       "the encoder was left without supply (%.400s)", report.text);
    }
    const bool there = encoder->outcome != VERIFY_LOST && self->protocol->end(encoder, &report);
    return put_back(self) && there;
}

static bool cites_asked(const struct verify_result *result, const struct cf_row *row)
{
    bool asked = false;
    for (size_t i = 0; i < row->cited_count; i++) {
        asked = asked || verify_asked(result, row->cited[i]);
    }
    return asked;
}

/* A busy host may be late once: what differs has to differ again. One that knows that it was late
   makes the row again until it was not. */
static bool attempt_row(struct verify *self, const struct cf_suite *suite, const struct cf_row *row,
                        struct verify_row *to)
{
    bool there = try_once(self, suite, row, to);
    bool again = to->outcome == VERIFY_DIFFERS;
    for (unsigned i = 1; there && i < TRIES_MAX && to->outcome != VERIFY_AGREES &&
                         (again || self->encoder->held_up);
         i++) {
        char *const before = to->text;
        there = try_once(self, suite, row, to);
        free(before); /* each try makes its own; NOLINT(clang-analyzer-unix.Malloc) */
        again = false;
    }
    return there;
}

static void run_row(struct verify *self, struct verify_suite *suite, size_t index)
{
    const struct cf_row *row = &suite->rows->rows[index];
    struct verify_row *to = &suite->results[index];
    if (!cites_asked(&self->result, row)) {
        *to = make_row(VERIFY_NOT_SEEN, "was not requested");
        return;
    }
    if (self->result.lost[0] != '\0') {
        *to = make_row(VERIFY_NOT_SEEN, self->result.lost);
        return;
    }
    if (rehearse(self, suite->rows, row, to) && !attempt_row(self, suite->rows, row, to)) {
        if (self->result.lost[0] == '\0') {
            (void)snprintf(self->result.lost, sizeof self->result.lost,
                           "the encoder stopped answering in the row '%s'", row->title);
        }
        if (to->outcome == VERIFY_LOST) {
            to->outcome = VERIFY_DIFFERS;
        }
    }
    if (!self->options->say.quiet && isatty(STDERR_FILENO)) {
        (void)fprintf(stderr, "\r%s %zu of %zu ", suite->name, index + 1u, suite->rows->row_count);
    }
}

/* --- the command --- */

static const struct verify_protocol *protocol_of(const struct options *options)
{
    const struct dg_device *device = options->device;
    if (options->eds != NULL) {
        return &verify_canopen_file;
    }
    for (size_t i = 0; device != NULL && i < DG_COUNT(protocols); i++) {
        if (protocols[i]->stack == device->stack) {
            return protocols[i];
        }
    }
    return NULL;
}

/* Of a wire, that is: those of an encoder are its own. */
static int refuse_settings(const struct options *options, struct lx_error *error)
{
    for (size_t i = 0; i < options->settings.count; i++) {
        const char *key = options->settings.list[i].key;
        if (!verify_silkit_is(options) || strcmp(key, "time") != 0) {
            return lx_refuse(error, "expected none but time, with --silkit",
                             "--set %s: verify has no such setting", key);
        }
    }
    return 0;
}

static int refuse_options(const struct options *options, struct lx_error *error)
{
    struct lx_words right = {"expected one of:"};
    for (size_t i = 0; i < DG_COUNT(protocols); i++) {
        for (size_t k = 0; k < dg_device_count; k++) {
            if (dg_devices[k]->stack == protocols[i]->stack) {
                lx_words_add(&right, " %s", dg_devices[k]->name);
            }
        }
    }
    if (options->model == NULL) {
        return lx_refuse(error, right.text, "verify needs a model");
    }
    if (protocol_of(options) == NULL) {
        return lx_refuse(error, right.text, "verify has no clauses for %s", options->model);
    }

    if ((options->write || options->restore) && protocol_of(options)->writes == NULL) {
        return lx_refuse(error, "expected neither --write nor --restore", "verify only reads %s",
                         options->eds != NULL ? "what a file describes" : "such an encoder");
    }
    if ((options->journal != NULL || options->irreversible) && !options->write &&
        !options->restore) {
        return lx_refuse(error, "expected --write as well",
                         "without --write, verify changes nothing");
    }
    if (options->wire == NULL || options->where == NULL) {
        return lx_refuse(
            error,
            "expected --tty=/dev/ttyUSB0, --gpio=gpiochip0:4,5, --can=can0 or --modbus=HOST:PORT, "
            "for example",
            "verify needs the wire that leads to the encoder");
    }
    return refuse_settings(options, error);
}

static int write_file(const struct verify_result *result, const char *path,
                      void (*print)(const struct verify_result *, FILE *), struct lx_error *error)
{
    if (path == NULL) {
        return 0;
    }
    FILE *to = fopen(path, "we");
    if (to == NULL) {
        return lx_fail(error, "%s: %s", path, strerror(errno));
    }
    print(result, to);
    const bool failed = ferror(to) != 0;
    return fclose(to) != 0 || failed ? lx_fail(error, "%s: cannot be written", path) : 0;
}

/* @return how the program ends */
static int print_result(const struct verify *self)
{
    const struct verify_result *result = &self->result;
    struct lx_error error;
    (self->options->json ? verify_print_json : verify_print_lines)(result, stdout);
    if (write_file(result, self->options->junit, verify_print_junit, &error) != 0 ||
        write_file(result, self->options->report, verify_print_report, &error) != 0) {
        return complain(&error, EXIT_FAILURE);
    }
    if (fflush(stdout) != 0 || ferror(stdout) != 0) {
        lx_complain("cannot write to stdout");
        return EXIT_FAILURE;
    }
    int status = result->lost[0] != '\0' ? EXIT_FAILURE : EXIT_SUCCESS;
    for (size_t i = 0; i < result->suite_count; i++) {
        const struct verify_suite *suite = &result->suites[i];
        for (size_t k = 0; k < suite->rows->row_count; k++) {
            status = suite->results[k].outcome == VERIFY_DIFFERS ? EXIT_FAILURE : status;
        }
    }
    return status;
}

/* A word is a clause, or the beginning of several. */
static int check_words(const struct verify_result *result, struct lx_error *error)
{
    for (size_t i = 0; i < result->word_count; i++) {
        const struct verify_result one = {.words = result->words + i, .word_count = 1};
        size_t found = 0;
        for (size_t k = 0; k < result->suite_count; k++) {
            const struct cf_suite *suite = result->suites[k].rows;
            for (size_t n = 0; n < suite->clause_count; n++) {
                found += verify_asked(&one, suite->clauses[n].id) ? 1u : 0u;
            }
        }
        if (found == 0) {
            return lx_refuse(error, "expected a clause or its beginning, such as 5.1.2 or M12-7",
                             "no clause %s", result->words[i]);
        }
    }
    return 0;
}

/* What will be written is said first. */
static int open_journal(struct verify *self, struct lx_error *error)
{
    const struct options *options = self->options;
    if (!options->write && !options->restore) {
        return 0;
    }
    self->journal = calloc(1, sizeof *self->journal);
    if (self->journal == NULL) {
        return lx_fail(error, "no memory");
    }
    self->journal->model = self->result.model;
    if (verify_journal_open(self->journal, options->journal, options->restore, error) != 0) {
        return -1;
    }
    if (options->write) {
        lx_note(&options->say, "writes, and puts back after each experiment: %s; journal: %s",
                self->protocol->writes, self->journal->path);
    }
    return 0;
}

static void free_encoder(struct verify_encoder *self)
{
    self->protocol->close(self);
    free(self);
}

static int find_encoder(struct verify_encoder *self, const struct options *options,
                        struct lx_error *error)
{
    if (options->restore || self->protocol->identify(self, options->where, error) == 0) {
        return 0;
    }
    if (self->stream != NULL) {
        (void)verify_stream_explain(self->stream, error);
    }
    return -1;
}

/* To be freed. NULL with `error` */
static struct verify_encoder *make_encoder(const struct verify *self, struct lx_error *error)
{
    const struct verify_protocol *protocol = self->protocol;
    const struct options *options = self->options;
    if (protocol->wire != NULL && strcmp(options->wire->name, protocol->wire) != 0) {
        (void)lx_refuse(error, protocol->expects, "verify cannot use --%s", options->wire->name);
        return NULL;
    }
    struct verify_encoder *encoder = lx_allocate(protocol->size, "an encoder", error);
    if (encoder == NULL) {
        return NULL;
    }
    encoder->protocol = protocol;
    encoder->journal = self->journal;
    encoder->power = options->power;
    if (protocol->open(encoder, options, error) != 0 ||
        find_encoder(encoder, options, error) != 0) {
        free_encoder(encoder);
        return NULL;
    }
    return encoder;
}

/* @return how the program ends */
static int restore(struct verify *self)
{
    if (self->journal == NULL || self->journal->count == 0) {
        (void)puts("nothing is left to put back");
        return EXIT_SUCCESS;
    }
    if (!put_back(self)) {
        lx_complain("%s", self->result.lost);
        return EXIT_FAILURE;
    }
    (void)puts("the encoder is as it was");
    return EXIT_SUCCESS;
}

static int verify_encoder_rows(struct verify *self)
{
    struct lx_error error;
    if (verify_load_suites(&self->result, self->protocol, self->options, &error) != 0) {
        return complain(&error, EXIT_FAILURE);
    }
    if (check_words(&self->result, &error) != 0) {
        return complain(&error, 2);
    }
    if (open_journal(self, &error) != 0) {
        return complain(&error, EXIT_FAILURE);
    }
    self->encoder = make_encoder(self, &error);
    if (self->encoder == NULL) {
        return complain(&error, EXIT_FAILURE);
    }
    if (self->options->restore) {
        const int restored = restore(self);
        free_encoder(self->encoder);
        return restored;
    }
    self->result.encoder = self->encoder;
    if (self->options->alone && self->protocol->scan(self->encoder, &error) != 0) {
        free_encoder(self->encoder);
        return complain(&error, EXIT_FAILURE);
    }
    for (size_t i = 0; i < self->result.suite_count; i++) {
        struct verify_suite *suite = &self->result.suites[i];
        for (size_t k = 0; k < suite->rows->row_count; k++) {
            run_row(self, suite, k);
        }
    }
    if (!self->options->say.quiet && isatty(STDERR_FILENO)) {
        (void)fputs("\r\n", stderr);
    }
    const int status = print_result(self);
    free_encoder(self->encoder);
    return status;
}

int verify_command(const struct options *options)
{
    struct verify self = {.options = options};
    struct lx_error error;
    if (refuse_options(options, &error) != 0) {
        return complain(&error, 2);
    }
    self.protocol = protocol_of(options);
    self.result.model = options->eds != NULL ? options->eds->path : options->device->name;
    self.result.words = options->words;
    self.result.word_count = options->word_count;
    self.allowed = (options->alone ? CF_ALONE : 0u) | (options->write ? CF_WRITE : 0u) |
                   (options->irreversible ? CF_ONE_WAY : 0u) |
                   (options->power != NULL || can_ask(options) ? CF_POWER : 0u);
    const int status = verify_encoder_rows(&self);
    if (self.journal != NULL) {
        verify_journal_close(self.journal);
        free(self.journal);
    }
    verify_unload_suites(&self.result);
    if (lx_silkit_is_left_behind()) {
        (void)fflush(NULL);
        _exit(status);
    }
    return status;
}
