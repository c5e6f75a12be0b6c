/* SPDX-License-Identifier: MIT */
#include "options.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum key {
    KEY_HELP = 'h',
    KEY_VERSION = 'V',
    KEY_QUIET = 'q',
    KEY_PTY = 256,
    KEY_TTY,
    KEY_MODBUS,
    KEY_RING,
    KEY_NVM,
    KEY_SERIAL,
    KEY_SET,
    KEY_SHAFT,
};

static const struct wire wires[] = {
    {"pty", KEY_PTY, lx_pty_open},
    {"tty", KEY_TTY, lx_tty_open},
    {"modbus", KEY_MODBUS, NULL},
};
#define WIRE_COUNT (sizeof wires / sizeof wires[0])

const struct wire *const options_default_wire = &wires[0];

/* clang-format off */
static const struct argp_option table[] = {
    {.doc = "Wires (one of them):", .group = 1},
    {.name = "pty",     .key = KEY_PTY,     .arg = "LINK",      .flags = OPTION_ARG_OPTIONAL, .doc = "a pseudo-terminal, and a symbolic link to it while it runs (default)"},
    {.name = "tty",     .key = KEY_TTY,     .arg = "DEV",       .doc = "a serial port; data rate and parity are the encoder's own"},
    {.name = "modbus",  .key = KEY_MODBUS,  .arg = "HOST:PORT", .doc = "INTERBUS: the Modbus/TCP coupler in front of the ring (default: 127.0.0.1:5020)"},
    {.doc = "Options:", .group = 2},
    {.name = "ring",    .key = KEY_RING,    .arg = "MODELS",    .doc = "INTERBUS: all encoders of the ring, with commas between them"},
    {.name = "nvm",     .key = KEY_NVM,     .arg = "FILE",      .doc = "keep the EEPROM in FILE, made when it does not exist (default: forgotten at the end)"},
    {.name = "serial",  .key = KEY_SERIAL,  .arg = "N",         .doc = "serial number, up to 9 digits"},
    {.name = "shaft",   .key = KEY_SHAFT,   .arg = "MOTION",    .doc = "what the shaft does, see below (default: 0)"},
    {.name = "set",     .key = KEY_SET,     .arg = "KEY=VALUE", .doc = "see below; may be given again"},
    {.name = "quiet",   .key = KEY_QUIET,                       .doc = "no notes on stderr, only complaints"},
    {.name = "help",    .key = KEY_HELP,                        .doc = "this text"},
    {.name = "version", .key = KEY_VERSION,                     .doc = "the version"},
    {0},
};
/* clang-format on */

static error_t fail(struct options *self, const char *what, const char *value, const char *right)
{
    (void)lx_fail(&self->error, "%s%s; %s", what, value, right);
    return EINVAL;
}

/* The name of the option with this key. */
static const char *name_of(int key)
{
    const struct argp_option *row = table;
    while (row->key != key) {
        row++;
    }
    return row->name;
}

static error_t take_wire(struct options *self, int key, const char *value)
{
    for (size_t i = 0; i < WIRE_COUNT; i++) {
        if (wires[i].option != key) {
            continue;
        }
        if (self->wire != NULL) {
            return fail(self, "more than one wire: --", wires[i].name,
                        "give one of --pty, --tty, --modbus");
        }
        self->wire = &wires[i];
        self->where = value;
    }
    return 0;
}

static error_t take_argument(struct options *self, unsigned index, const char *value)
{
    if (index == 0 && strcmp(value, "list") == 0) {
        self->command = COMMAND_LIST;
    } else if (index == 0 && strcmp(value, "run") == 0) {
        self->command = COMMAND_RUN;
    } else if (index == 0 && strcmp(value, "map") == 0) {
        self->command = COMMAND_MAP;
    } else if (index == 0) {
        return fail(self, "unknown command ", value,
                    "right is 'drehgeber list', 'drehgeber run MODEL [WIRE] [OPTIONS]' or "
                    "'drehgeber map MODEL'");
    } else if (index == 1 && self->command != COMMAND_LIST) {
        self->model = value;
    } else {
        return fail(self, "superfluous argument ", value,
                    "right is 'drehgeber list' or 'drehgeber run MODEL [WIRE] [OPTIONS]'");
    }
    return 0;
}

static error_t take_option(struct options *self, int key, const char *value)
{
    switch (key) {
    case KEY_RING:
        self->ring = value;
        return 0;
    case KEY_NVM:
        self->nvm = value;
        return 0;
    case KEY_SERIAL:
        self->serial = value;
        return 0;
    case KEY_SET:
        self->sets[self->set_count++] = value;
        return 0;
    case KEY_SHAFT:
        self->shaft = value;
        return 0;
    case KEY_QUIET:
        self->say.quiet = true;
        return 0;
    default:
        return take_wire(self, key, value);
    }
}

static error_t take(int key, char *value, struct argp_state *state)
{
    struct options *self = state->input;
    switch (key) {
    case KEY_HELP:
    case KEY_VERSION: /* whatever else is there does not matter */
        self->command = key == KEY_HELP ? COMMAND_HELP : COMMAND_VERSION;
        state->next = state->argc;
        return 0;
    case ARGP_KEY_ARG:
        return take_argument(self, state->arg_num, value);
    case ARGP_KEY_ERROR:
        self->culprit = state->next > 0 ? state->argv[state->next - 1] : "";
        return 0;
    case ARGP_KEY_INIT:
    case ARGP_KEY_NO_ARGS:
    case ARGP_KEY_END:
    case ARGP_KEY_SUCCESS:
    case ARGP_KEY_FINI:
    case ARGP_KEY_ARGS:
        return ARGP_ERR_UNKNOWN;
    default:
        self->option = name_of(key);
        return take_option(self, key, value);
    }
}

const struct argp options_argp = {.options = table, .parser = take};

/* The option table's row of "--name" or "--name=value". */
static const struct argp_option *row_of(const char *argument)
{
    if (strncmp(argument, "--", 2) != 0) {
        return NULL;
    }
    const size_t n = strcspn(argument + 2, "=");
    for (const struct argp_option *row = table; row->name != NULL || row->doc != NULL; row++) {
        if (row->name != NULL && strlen(row->name) == n &&
            strncmp(argument + 2, row->name, n) == 0) {
            return row;
        }
    }
    return NULL;
}

/* getopt's own messages say what was wrong only, so this says it all. */
static int explain_culprit(struct options *self)
{
    const struct argp_option *row = row_of(self->culprit);
    if (row == NULL) {
        return lx_fail(&self->error,
                       "unknown option %s; valid: --pty[=LINK] --tty DEV --modbus HOST:PORT "
                       "--ring MODELS --nvm FILE --serial N "
                       "--shaft MOTION --set KEY=VALUE --quiet --help --version",
                       self->culprit);
    }
    if (row->arg == NULL) {
        return lx_fail(&self->error, "%s: --%s takes no value", self->culprit, row->name);
    }
    return lx_fail(&self->error, "--%s without a value; right is --%s %s", row->name, row->name,
                   row->arg);
}

static int check_command(struct options *self)
{
    if (self->command == COMMAND_NONE) {
        return lx_fail(&self->error, "no command; right is 'drehgeber list', 'drehgeber run MODEL "
                                     "[WIRE] [OPTIONS]', 'drehgeber map MODEL' or 'drehgeber "
                                     "--help'");
    }
    if (self->command == COMMAND_LIST && self->option != NULL) {
        return lx_fail(&self->error, "list takes no option --%s; right is 'drehgeber list'",
                       self->option);
    }
    return 0;
}

int options_parse(struct options *self, int argc, char **argv)
{
    *self = (struct options){.command = COMMAND_NONE};
    self->sets = calloc((size_t)argc + 1, sizeof *self->sets);
    if (self->sets == NULL) {
        return lx_fail(&self->error, "no memory");
    }
    const unsigned flags = ARGP_NO_HELP | ARGP_NO_ERRS | ARGP_NO_EXIT;
    const error_t result = argp_parse(&options_argp, argc, argv, flags, NULL, self);
    if (result != 0 && self->error.text[0] != '\0') {
        return -1;
    }
    return result != 0 ? explain_culprit(self) : check_command(self);
}

void options_free(struct options *self)
{
    free(self->sets);
    self->sets = NULL;
}
