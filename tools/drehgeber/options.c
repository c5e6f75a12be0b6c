/* SPDX-License-Identifier: MIT */
#include "options.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "can.h"
#include "drehgeber/drehgeber.h"
#include "eds_file.h"
#include "options_rows.h"

/* --- the table of options --- */

/* Options that only those commands have which list them in `takes`. */
static bool of_few(const struct argp_option *option)
{
    static const int keys[] = {KEY_JSON,         KEY_EXPLAIN, KEY_OUTPUT,  KEY_FMI,    KEY_LISTEN,
                               KEY_TOKEN,        KEY_WATCH,   KEY_TIMEOUT, KEY_C,      KEY_AGAINST,
                               KEY_ADDRESS,      KEY_ALONE,   KEY_JUNIT,   KEY_REPORT, KEY_WRITE,
                               KEY_IRREVERSIBLE, KEY_RESTORE, KEY_JOURNAL, KEY_POWER};
    for (size_t i = 0; i < DG_COUNT(keys); i++) {
        if (option->key == keys[i]) {
            return true;
        }
    }
    return false;
}

static bool takes(const struct command_row *row, const struct argp_option *option)
{
    struct lx_words word = {""};
    if (row == NULL || option->key == KEY_HELP) {
        return true;
    }
    if (row->takes == NULL) {
        return !of_few(option);
    }
    lx_words_add(&word, " %s ", option->name == NULL ? "" : option->name);
    return option->name == NULL ? row->takes[0] != '\0' : strstr(row->takes, word.text) != NULL;
}

static struct argp_option option_of(const struct dg_plan_wire_kind *wire, int key)
{
    return (struct argp_option){
        .name = wire->name,
        .key = key,
        .arg = wire->where,
        .flags = lx_wire_is_optional(wire) ? OPTION_ARG_OPTIONAL : 0,
        .doc = lx_wire_of(wire)->help,
        .group = 1,
    };
}

static bool serves(const struct argp_option *option, const struct lx_stack *stack)
{
    return stack == NULL || ((option->key != KEY_RING || stack->is_ring) &&
                             ((option->key != KEY_NODE && option->key != KEY_NVM_CONVERT) ||
                              options_numbered(stack)));
}

struct argp_option *options_table(const struct command_row *row, const struct lx_stack *stack)
{
    struct argp_option *table = calloc(dg_plan_wire_count + option_row_count + 2u, sizeof *table);
    size_t n = 0;
    if (table == NULL) {
        return NULL;
    }
    if (row == NULL || row->wires) {
        table[n++] = (struct argp_option){.doc = "Wires (one of them):", .group = 1};
        for (size_t i = 0; i < dg_plan_wire_count; i++) {
            if (stack == NULL || dg_plan_carries(&dg_plan_wires[i], stack->core)) {
                table[n++] = option_of(&dg_plan_wires[i], KEY_WIRE + (int)i);
            }
        }
    }
    for (size_t i = 0; i < option_row_count; i++) {
        if (takes(row, &option_rows[i]) && serves(&option_rows[i], stack)) {
            table[n++] = option_rows[i];
        }
    }
    return table;
}

/* "--pty[=LINK]", "--tty DEV" */
static void add_option(struct lx_words *to, const struct argp_option *row)
{
    const bool optional = (row->flags & OPTION_ARG_OPTIONAL) != 0;
    lx_words_add(to, "--%s", row->name);
    if (row->arg != NULL) {
        lx_words_add(to, optional ? "[=%s]" : " %s", row->arg);
    }
}

bool options_end(const struct argp_option *row)
{
    return row->name == NULL && row->doc == NULL;
}

/* The row with this key. */
static const struct argp_option *row_with(const struct options *self, int key)
{
    const struct argp_option *row = self->table;
    while (row->name == NULL || row->key != key) {
        row++;
    }
    return row;
}

/* --- what is given --- */

static error_t take_wire(struct options *self, int key, const char *value)
{
    const struct dg_plan_wire_kind *wire = &dg_plan_wires[key - KEY_WIRE];
    struct lx_words right = {"give one of "};
    if (self->wire == NULL) {
        self->wire = wire;
        self->where = value;
        return 0;
    }
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        lx_words_add(&right, "%s--%s", i == 0 ? "" : ", ", dg_plan_wires[i].name);
    }
    (void)lx_refuse(&self->error, right.text, "more than one wire: --%s", wire->name);
    return EINVAL;
}

/* The names of all commands. */
static struct lx_words valid_commands(void)
{
    struct lx_words right = {"valid:"};
    for (size_t i = 0; i < command_row_count; i++) {
        if (command_find(command_rows[i].name) == &command_rows[i]) {
            lx_words_add(&right, " %s", command_rows[i].name);
        }
    }
    lx_words_add(&right, "; 'drehgeber --help' says more");
    return right;
}

/* Whether `name` is what the `n` characters may mean, and nearer than the one that set `best`:
   two of five characters may be wrong. */
static bool is_nearer(const char *name, const char *text, size_t n, unsigned *best)
{
    const unsigned edits = dg_text_edits(name, strlen(name), text, n, false);
    if (edits > 2u * n / 5u || edits >= *best) {
        return false;
    }
    *best = edits;
    return true;
}

static const struct command_row *command_near(const char *text)
{
    const struct command_row *found = NULL;
    unsigned best = UINT_MAX;
    for (size_t i = 0; i < command_row_count; i++) {
        if (is_nearer(command_rows[i].name, text, strlen(text), &best)) {
            found = &command_rows[i];
        }
    }
    return found;
}

/* What run takes. */
static bool is_runnable(const char *word)
{
    return word != NULL && (dg_device_find(word) != NULL || strstr(word, ".ini") != NULL ||
                            dg_model_file_of(word) != NULL);
}

/* `next`: the word behind it; NULL: none. */
static int unknown_command(struct options *self, const char *value, const char *next)
{
    const struct command_row *near = command_near(value);
    struct lx_words right = valid_commands();
    if (is_runnable(value) || (near == NULL && is_runnable(next))) {
        (void)snprintf(right.text, sizeof right.text, "expected 'drehgeber run %s'",
                       is_runnable(value) ? value : next);
    } else if (near != NULL) {
        (void)snprintf(right.text, sizeof right.text, "closest is 'drehgeber %s'", near->usage);
    }
    return lx_refuse(&self->error, right.text, "unknown command %s", value);
}

/* Most who give too much mean something that is written otherwise. */
static int superfluous(struct options *self, const char *value)
{
    const bool link = self->wire != NULL && self->where == NULL && lx_wire_is_optional(self->wire);
    struct lx_words right = {""};
    if (link) {
        lx_words_add(&right, "expected --%s=%s", self->wire->name, value);
    } else if (self->command == COMMAND_RUN) {
        lx_words_add(&right, "expected one model, or 'drehgeber run RIG.ini' with one encoder in "
                             "each [encoder NAME]");
    } else if (self->command == COMMAND_EDS) {
        lx_words_add(&right, "expected 'drehgeber eds %s > %s'", self->model, value);
    } else {
        lx_words_add(&right, "expected 'drehgeber %s'", self->row->usage);
    }
    return lx_refuse(&self->error, right.text, "superfluous argument %s", value);
}

static error_t take_argument(struct options *self, unsigned index, char *value, const char *next)
{
    if (index == 0) {
        self->row = command_find(value);
        self->command = self->row == NULL ? COMMAND_NONE : self->row->command;
        return self->row != NULL || unknown_command(self, value, next) == 0 ? 0 : EINVAL;
    }
    if (self->command == COMMAND_CTL || (index > 1 && self->row->ask != NULL)) {
        self->words[self->word_count++] = value;
        return 0;
    }
    if (index == 1 && self->command == COMMAND_EXPLAIN) {
        self->capture = value;
        return 0;
    }
    if (index == 1 && self->command != COMMAND_LIST) {
        self->model = value;
        return 0;
    }
    (void)superfluous(self, value);
    return EINVAL;
}

/* Options whose value is kept as it is. */
static const struct {
    int key;
    size_t offset; /* of the text in struct options */
} texts[] = {
    {KEY_RING, offsetof(struct options, ring)},
    {KEY_NVM, offsetof(struct options, nvm)},
    {KEY_NVM_CONVERT, offsetof(struct options, nvm_convert)},
    {KEY_SERIAL, offsetof(struct options, serial)},
    {KEY_NODE, offsetof(struct options, node)},
    {KEY_SHAFT, offsetof(struct options, shaft)},
    {KEY_TRACE, offsetof(struct options, trace)},
    {KEY_FILES, offsetof(struct options, files)},
    {KEY_TIME, offsetof(struct options, time)},
    {KEY_OUTPUT, offsetof(struct options, output)},
    {KEY_FMI, offsetof(struct options, fmi)},
    {KEY_LISTEN, offsetof(struct options, listen)},
    {KEY_TOKEN, offsetof(struct options, token)},
    {KEY_TIMEOUT, offsetof(struct options, timeout)},
    {KEY_MODEL, offsetof(struct options, models)},
    {KEY_AGAINST, offsetof(struct options, model)},
    {KEY_ADDRESS, offsetof(struct options, address)},
    {KEY_JUNIT, offsetof(struct options, junit)},
    {KEY_JOURNAL, offsetof(struct options, journal)},
    {KEY_POWER, offsetof(struct options, power)},
    {KEY_REPORT, offsetof(struct options, report)},
};
#define TEXT_COUNT DG_COUNT(texts)

/* Options without one: that they are given is what they say. */
static const struct {
    int key;
    size_t offset; /* of the bool in struct options */
} switches[] = {
    {KEY_JSON, offsetof(struct options, json)},
    {KEY_VERBOSE, offsetof(struct options, verbose)},
    {KEY_WATCH, offsetof(struct options, watch)},
    {KEY_QUIET, offsetof(struct options, say.quiet)},
    {KEY_C, offsetof(struct options, c)},
    {KEY_EXPLAIN, offsetof(struct options, explain)},
    {KEY_ALONE, offsetof(struct options, alone)},
    {KEY_WRITE, offsetof(struct options, write)},
    {KEY_IRREVERSIBLE, offsetof(struct options, irreversible)},
    {KEY_RESTORE, offsetof(struct options, restore)},
};

/* An empty one is most likely an empty variable of a script. */
static error_t take_option_text(struct options *self, int key, size_t offset, const char *value)
{
    struct lx_words right = {"expected "};
    memcpy((char *)self + offset, &value, sizeof value);
    if (*value != '\0') {
        return 0;
    }
    add_option(&right, row_with(self, key));
    (void)lx_refuse(&self->error, right.text, "--%s: empty", row_with(self, key)->name);
    return EINVAL;
}

static error_t take_option(struct options *self, int key, const char *value)
{
    const bool given = true;
    for (size_t i = 0; i < TEXT_COUNT; i++) {
        if (texts[i].key == key) {
            return take_option_text(self, key, texts[i].offset, value);
        }
    }
    for (size_t i = 0; i < DG_COUNT(switches); i++) {
        if (switches[i].key == key) {
            memcpy((char *)self + switches[i].offset, &given, sizeof given);
            return 0;
        }
    }
    if (key == KEY_SET) {
        return lx_plan_add_assignment(&self->settings, value, 0, &self->error) == 0 ? 0 : EINVAL;
    }
    if (key == KEY_CONTROL) {
        self->controls[self->control_count++] = value;
        return 0;
    }
    return take_wire(self, key, value);
}

static bool is_option(const char *word)
{
    return word[0] == '-' && word[1] != '\0';
}

/* The word that the parser stopped in: of short options behind each other it may be the next one
   still, else the parser is past it. */
static const char *find_culprit(const struct options *self, const struct argp_state *state)
{
    int next = self->parsed;
    while (next < state->argc && !is_option(state->argv[next])) {
        next++;
    }
    return state->argv[next == state->next ? next : state->next - 1];
}

static error_t take(int key, char *value, struct argp_state *state)
{
    struct options *self = state->input;
    switch (key) {
    case KEY_HELP: /* among short options; see find_help() */
    case KEY_VERSION:
        return ARGP_ERR_UNKNOWN;
    case ARGP_KEY_ARG:
        return take_argument(self, state->arg_num, value,
                             state->next < state->argc ? state->argv[state->next] : NULL);
    case ARGP_KEY_ERROR:
        self->culprit = find_culprit(self, state);
        return 0;
    case ARGP_KEY_INIT:
    case ARGP_KEY_NO_ARGS:
    case ARGP_KEY_END:
    case ARGP_KEY_SUCCESS:
    case ARGP_KEY_FINI:
    case ARGP_KEY_ARGS:
        return ARGP_ERR_UNKNOWN;
    default:
        self->parsed = state->next;
        self->option = row_with(self, key)->name;
        self->given |= UINT64_C(1) << (row_with(self, key) - self->table);
        return take_option(self, key, value);
    }
}

/* --- what the parser refuses --- */

/* "-o" */
static bool is_letter(const char *word)
{
    return word[0] == '-' && word[1] != '\0' && word[1] != '-' && word[2] == '\0';
}

/* The option table's row of "-o", "--name" or "--name=value". */
static const struct argp_option *option_row_of(const struct options *self, const char *argument)
{
    const bool whole = strncmp(argument, "--", 2) == 0;
    const size_t n = whole ? strcspn(argument + 2, "=") : 0;
    for (const struct argp_option *row = self->table; !options_end(row); row++) {
        const bool same = whole && row->name != NULL && strlen(row->name) == n &&
                          strncmp(argument + 2, row->name, n) == 0;
        if (same || (is_letter(argument) && row->key == argument[1])) {
            return row;
        }
    }
    return NULL;
}

/* What may be meant: of a letter the first option that begins so, else the nearest, also of one
   with a single dash; NULL. */
static const struct argp_option *option_near(const struct options *self, const char *culprit)
{
    const char *name = culprit + strspn(culprit, "-");
    const struct argp_option *found = NULL;
    unsigned best = UINT_MAX;
    for (const struct argp_option *row = self->table; !options_end(row); row++) {
        if (row->name == NULL || !takes(self->row, row)) {
            continue;
        }
        if (is_letter(culprit) ? found == NULL && row->name[0] == name[0]
                               : is_nearer(row->name, name, strcspn(name, "="), &best)) {
            found = row;
        }
    }
    return found;
}

static int unknown_option(struct options *self)
{
    const struct argp_option *near = option_near(self, self->culprit);
    const struct command_row *command = command_find(self->culprit + strspn(self->culprit, "-"));
    struct lx_words right = {""};
    if (command != NULL) {
        lx_words_add(&right, "expected 'drehgeber %s'", command->usage);
    } else if (near != NULL) {
        lx_words_add(&right, "closest is ");
        add_option(&right, near);
    } else {
        lx_words_add(&right, "valid:");
        for (const struct argp_option *row = self->table; !options_end(row); row++) {
            if (row->name != NULL && takes(self->row, row)) {
                lx_words_add(&right, " --%s", row->name);
            }
        }
    }
    return lx_refuse(&self->error, right.text, "unknown option %s", self->culprit);
}

/* getopt's own messages say what was wrong only, so this says it all. */
static int explain_culprit(struct options *self)
{
    const struct argp_option *row = option_row_of(self, self->culprit);
    struct lx_words right = {""};
    if (row == NULL) {
        return unknown_option(self);
    }
    if (row->arg == NULL) {
        return lx_fail(&self->error, "%s: --%s takes no value", self->culprit, row->name);
    }
    lx_words_add(&right, "expected ");
    add_option(&right, row);
    return lx_refuse(&self->error, right.text, "--%s without a value", row->name);
}

/* What was given and the command does not take, if that is to be said here; NULL. Commands that
   look at wires say more about one that does not fit. */
static const struct argp_option *not_taken(const struct options *self)
{
    const bool strict = self->command == COMMAND_LIST || self->command == COMMAND_FAULTS ||
                        self->command == COMMAND_EDS || self->command == COMMAND_CHECK ||
                        self->command == COMMAND_FMU || self->command == COMMAND_WEB ||
                        self->command == COMMAND_EXPLAIN;
    for (const struct argp_option *row = self->table; !options_end(row); row++) {
        const bool given = (self->given >> (row - self->table) & 1u) != 0;
        if (given && (strict || of_few(row)) && !takes(self->row, row)) {
            return row;
        }
    }
    return NULL;
}

static int check_command(struct options *self)
{
    struct lx_words right = valid_commands();
    if (self->command == COMMAND_NONE) {
        return lx_refuse(&self->error, right.text, "no command");
    }
    const struct argp_option *option = not_taken(self);
    if (option != NULL) {
        (void)snprintf(right.text, sizeof right.text, "expected 'drehgeber %s'", self->row->usage);
        return lx_refuse(&self->error, right.text, "%s takes no option --%s", self->row->name,
                         option->name);
    }
    return 0;
}

/* --- the whole --- */

/* Whoever asks for help gets it, whatever else is there, and nothing is started. */
static enum command find_help(struct options *self, int argc, char **argv)
{
    enum command found = argc > 1 && strcmp(argv[1], "help") == 0 ? COMMAND_HELP : COMMAND_NONE;
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++) {
        const char *word = argv[i];
        const bool version = strcmp(word, "--version") == 0 || strcmp(word, "-V") == 0;
        if (version || strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0) {
            found = found != COMMAND_NONE ? found : version ? COMMAND_VERSION : COMMAND_HELP;
        } else if (self->row == NULL || self->row->command == COMMAND_HELP) {
            self->row = command_find(word);
        } else if (self->model == NULL && !is_option(word) &&
                   self->row->command != COMMAND_EXPLAIN) {
            self->model = word;
        }
    }
    return found;
}

int options_parse(struct options *self, int argc, char **argv)
{
    *self = (struct options){.command = COMMAND_NONE, .parsed = 1};
    self->command = find_help(self, argc, argv);
    if (self->command != COMMAND_NONE) {
        return options_find_model(self);
    }
    const struct command_row *const meant = self->row; /* options are parsed before arguments */
    self->row = NULL;
    self->model = NULL;
    self->table = options_table(NULL, NULL);
    self->words = calloc((size_t)argc + 1, sizeof *self->words);
    self->controls = calloc((size_t)argc + 1, sizeof *self->controls);
    if (self->table == NULL || self->words == NULL || self->controls == NULL) {
        return lx_fail(&self->error, "no memory");
    }
    const struct argp argp = {.options = self->table, .parser = take};
    const unsigned flags = ARGP_NO_HELP | ARGP_NO_ERRS | ARGP_NO_EXIT;
    const error_t result = argp_parse(&argp, argc, argv, flags, NULL, self);
    if (result != 0 && (self->error.what[0] != '\0' || self->error.right[0] != '\0')) {
        return -1;
    }
    if (result != 0) {
        self->row = meant;
        return explain_culprit(self);
    }
    const int found = options_find_model(self);
    return check_command(self) != 0 ? -1 : found;
}

/* "--pty[=LINK] or --tty DEV" */
static struct lx_words right_wires(const struct lx_stack *stack)
{
    struct lx_words right = {"expected"};
    const char *between = " ";
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        if (dg_plan_carries(&dg_plan_wires[i], stack->core)) {
            const struct argp_option row = option_of(&dg_plan_wires[i], 0);
            lx_words_add(&right, "%s", between);
            add_option(&right, &row);
            between = " or ";
        }
    }
    return right;
}

/* A kernel that has CAN also has an interface that the user wants it on; there is no guessing.
   An encoder in an FMU is on no wire, and fmu takes no option that names one. */
static bool must_be_said(const struct options *self, const struct lx_stack *stack)
{
    const struct dg_plan_wire_kind *can = dg_plan_find_kind("can", strlen("can"));
    return self->command != COMMAND_FMU && dg_plan_carries(can, stack->core) && lx_can_in_kernel();
}

const struct dg_plan_wire_kind *options_wire(const struct options *self,
                                             const struct dg_device *device, struct lx_error *error)
{
    const struct lx_stack *stack = lx_stack_of(device);
    if (self->wire != NULL && dg_plan_carries(self->wire, stack->core)) {
        return self->wire;
    }
    if (self->wire != NULL) {
        (void)lx_refuse(error, right_wires(stack).text, "--%s is no wire of %s", self->wire->name,
                        device->name);
        return NULL;
    }
    if (must_be_said(self, stack)) {
        (void)lx_refuse(error, right_wires(stack).text, "%s needs a wire", device->name);
        return NULL;
    }
    return dg_plan_find_kind(stack->wire, strlen(stack->wire));
}

void options_free(struct options *self)
{
    lx_plan_free_settings(&self->settings);
    models_free(self->file);
    free(self->table);
    free(self->words);
    free(self->controls);
    eds_file_close(self->eds);
    *self = (struct options){.command = COMMAND_NONE};
}
