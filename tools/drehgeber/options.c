/* SPDX-License-Identifier: MIT */
#include "options.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "can.h"
#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"

enum key {
    KEY_HELP = 'h',
    KEY_VERSION = 'V',
    KEY_QUIET = 'q',
    KEY_PTY = 256,
    KEY_TTY,
    KEY_CAN,
    KEY_SLCAN,
    KEY_NODE,
    KEY_SIM,
    KEY_GPIO,
    KEY_TRACE,
    KEY_FILES,
    KEY_MODBUS,
    KEY_RING,
    KEY_NVM,
    KEY_SERIAL,
    KEY_SET,
    KEY_SHAFT,
    KEY_CONTROL,
    KEY_VERBOSE,
};

static const struct {
    const char *name;
    enum command command;
} commands[] = {
    {"list", COMMAND_LIST}, {"run", COMMAND_RUN}, {"eds", COMMAND_EDS}, {"biss", COMMAND_BISS},
    {"map", COMMAND_MAP},   {"ctl", COMMAND_CTL}, {"top", COMMAND_TOP},
};
#define COMMAND_COUNT (sizeof commands / sizeof commands[0])
#define RIGHT                                                                                      \
    "'drehgeber list', 'drehgeber run MODEL [WIRE] [OPTIONS]', 'drehgeber run RIG.ini', "          \
    "'drehgeber eds MODEL', 'drehgeber biss MODEL ACTION', 'drehgeber map MODEL', "                \
    "'drehgeber ctl COMMAND' or 'drehgeber top [ADDRESS]'"

static const struct {
    const struct dg_stack *stack;
    const char *all;
    const char *usual;
} wires_of[] = {
    {&dg_hf_stack, "--pty[=LINK] or --tty DEV", "pty"},
    {&dg_biss_stack, "--sim or --gpio CHIP:MA,SLO", "sim"},
    {&dg_ib_stack, "--modbus HOST:PORT", "modbus"},
    {&dg_cia406_stack, "--can IFNAME or --slcan[=LINK]", "slcan"},
};

/* The row of a stack. */
static size_t row_of_stack(const struct dg_stack *stack)
{
    size_t i = 0;
    while (i < sizeof wires_of / sizeof wires_of[0] - 1 && wires_of[i].stack != stack) {
        i++;
    }
    return i;
}

/* clang-format off */
static const struct argp_option table[] = {
    {.doc = "Wires (one of them):", .group = 1},
    {.name = "pty",     .key = KEY_PTY,     .arg = "LINK",      .flags = OPTION_ARG_OPTIONAL, .doc = "RS485 on a pseudo-terminal, and a symbolic link to it while it runs (default)"},
    {.name = "tty",     .key = KEY_TTY,     .arg = "DEV",       .doc = "RS485 on a serial port; data rate and parity are the encoder's own"},
    {.name = "sim",     .key = KEY_SIM,     .doc = "BiSS on a simulated wire with a master that reads positions (default)"},
    {.name = "gpio",    .key = KEY_GPIO,    .arg = "CHIP:MA,SLO", .doc = "BiSS on two lines of a GPIO chip: its name, path or label, and two offsets, e.g. gpiochip0:4,5"},
    {.name = "can",     .key = KEY_CAN,     .arg = "IFNAME",    .doc = "CAN on a network interface (SocketCAN)"},
    {.name = "slcan",   .key = KEY_SLCAN,   .arg = "LINK",      .flags = OPTION_ARG_OPTIONAL, .doc = "CAN behind an SLCAN adapter on a pseudo-terminal (default where the kernel has no CAN)"},
    {.name = "modbus",  .key = KEY_MODBUS,  .arg = "HOST:PORT", .doc = "INTERBUS: the Modbus/TCP coupler in front of the ring (default: 127.0.0.1:5020)"},
    {.doc = "Options:", .group = 2},
    {.name = "ring",    .key = KEY_RING,    .arg = "MODELS",    .doc = "INTERBUS: all encoders of the ring, with commas between them"},
    {.name = "nvm",     .key = KEY_NVM,     .arg = "FILE",      .doc = "keep the EEPROM in FILE, made when it does not exist (default: forgotten at the end)"},
    {.name = "serial",  .key = KEY_SERIAL,  .arg = "N",         .doc = "serial number, up to 9 digits, CANopen 10"},
    {.name = "node",    .key = KEY_NODE,    .arg = "N[..M]",    .doc = "CANopen node-ID (default: 63), or several; each has its own EEPROM FILE.N"},
    {.name = "shaft",   .key = KEY_SHAFT,   .arg = "MOTION",    .doc = "what the shaft does, see below (default: 0)"},
    {.name = "set",     .key = KEY_SET,     .arg = "KEY=VALUE", .doc = "see below; may be given again"},
    {.name = "control", .key = KEY_CONTROL, .arg = "ADDRESS",   .doc = "SCPI at unix:PATH or tcp:HOST:PORT (loopback; ,open: beyond it, too), ,token=FILE behind it: for who knows the token; may be given again (default: unix:$XDG_RUNTIME_DIR/drehgeber/NAME.sock; in a service unix:$RUNTIME_DIRECTORY/NAME.sock)"},
    {.name = "files",   .key = KEY_FILES,   .arg = "DIR",       .doc = "traces, recordings and motions that SCPI names lie below DIR (default: here for unix:, nowhere for tcp:)"},
    {.name = "trace",   .key = KEY_TRACE,   .arg = "FILE",      .doc = "what goes over the wire: .vcd (RS485, BiSS), .log or .pcapng (CAN), .csv (INTERBUS)"},
    {.name = "verbose", .key = KEY_VERBOSE,                     .doc = "what goes over the wire in words, on stderr"},
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
    const char *name = name_of(key);
    if (self->wire != NULL) {
        return fail(self, "more than one wire: --", name,
                    "give one of --pty, --tty, --sim, --gpio, --modbus, --can, --slcan");
    }
    self->wire = lx_wire_find(name, strlen(name));
    self->where = value;
    return 0;
}

static error_t take_argument(struct options *self, unsigned index, char *value)
{
    for (size_t i = 0; index == 0 && i < COMMAND_COUNT; i++) {
        if (strcmp(value, commands[i].name) == 0) {
            self->command = commands[i].command;
            return 0;
        }
    }
    if (index > 0 && self->command == COMMAND_CTL) {
        self->words[self->word_count++] = value;
        return 0;
    }
    if (index == 1 && self->command != COMMAND_LIST) {
        self->model = value;
        return 0;
    }
    if (index > 1 && self->command == COMMAND_BISS) {
        self->words[self->word_count++] = value;
        return 0;
    }
    return fail(self, index == 0 ? "unknown command " : "superfluous argument ", value,
                "right is " RIGHT);
}

/* Options whose value is kept as it is. */
static const struct {
    int key;
    size_t offset; /* of the text in struct options */
} texts[] = {
    {KEY_RING, offsetof(struct options, ring)},     {KEY_NVM, offsetof(struct options, nvm)},
    {KEY_SERIAL, offsetof(struct options, serial)}, {KEY_NODE, offsetof(struct options, node)},
    {KEY_SHAFT, offsetof(struct options, shaft)},   {KEY_TRACE, offsetof(struct options, trace)},
    {KEY_FILES, offsetof(struct options, files)},
};
#define TEXT_COUNT (sizeof texts / sizeof texts[0])

static error_t take_option(struct options *self, int key, const char *value)
{
    for (size_t i = 0; i < TEXT_COUNT; i++) {
        if (texts[i].key == key) {
            memcpy((char *)self + texts[i].offset, &value, sizeof value);
            return 0;
        }
    }
    switch (key) {
    case KEY_SET:
        self->sets[self->set_count++] = value;
        return 0;
    case KEY_CONTROL:
        self->controls[self->control_count++] = value;
        return 0;
    case KEY_VERBOSE:
        self->verbose = true;
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
        return lx_fail(
            &self->error,
            "unknown option %s; valid: --pty[=LINK] --tty DEV --sim --gpio CHIP:MA,SLO --can IFNAME "
            "--slcan[=LINK] --modbus HOST:PORT --ring MODELS --nvm FILE --serial N --node N[..M] "
            "--shaft MOTION --set KEY=VALUE --control ADDRESS --files DIR --trace FILE --verbose --quiet "
            "--help --version",
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
        return lx_fail(&self->error,
                       "no command; right is " RIGHT ", 'drehgeber --help' says more");
    }
    if (self->command == COMMAND_LIST && self->option != NULL) {
        return lx_fail(&self->error, "list takes no option --%s; right is 'drehgeber list'",
                       self->option);
    }
    if (self->command == COMMAND_EDS && self->option != NULL) {
        return lx_fail(&self->error, "eds takes no option --%s; right is 'drehgeber eds MODEL'",
                       self->option);
    }
    return 0;
}

int options_parse(struct options *self, int argc, char **argv)
{
    *self = (struct options){.command = COMMAND_NONE};
    self->sets = calloc((size_t)argc + 1, sizeof *self->sets);
    self->words = calloc((size_t)argc + 1, sizeof *self->words);
    self->controls = calloc((size_t)argc + 1, sizeof *self->controls);
    if (self->sets == NULL || self->words == NULL || self->controls == NULL) {
        return lx_fail(&self->error, "no memory");
    }
    const unsigned flags = ARGP_NO_HELP | ARGP_NO_ERRS | ARGP_NO_EXIT;
    const error_t result = argp_parse(&options_argp, argc, argv, flags, NULL, self);
    if (result != 0 && self->error.text[0] != '\0') {
        return -1;
    }
    return result != 0 ? explain_culprit(self) : check_command(self);
}

/* A kernel that has CAN also has an interface that the user wants it on; there is no guessing. */
const struct lx_wire *options_wire(const struct options *self, const struct dg_stack *stack,
                                   struct lx_error *error)
{
    const char *all = wires_of[row_of_stack(stack)].all;
    const char *usual = wires_of[row_of_stack(stack)].usual;
    if (self->wire != NULL && self->wire->stack == stack) {
        return self->wire;
    }
    if (self->wire != NULL) {
        (void)lx_fail(error, "--%s is no wire of %s; right is %s", self->wire->name, self->model,
                      all);
        return NULL;
    }
    if (stack == &dg_cia406_stack && lx_can_in_kernel()) {
        (void)lx_fail(error, "%s needs a wire; right is %s", self->model, all);
        return NULL;
    }
    return lx_wire_find(usual, strlen(usual));
}

void options_free(struct options *self)
{
    free(self->sets);
    self->sets = NULL;
    free(self->words);
    self->words = NULL;
    free(self->controls);
    self->controls = NULL;
}
