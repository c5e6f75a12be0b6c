/* SPDX-License-Identifier: MIT */
/* An example first, then the reference; every table in it is the one the program works with. */
#define _GNU_SOURCE
#include "help.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "columns.h"
#include "trace.h"

const char help_intro[] =
    "  drehgeber run s3684-rs485 --pty=enc --shaft 60RPM --nvm enc.nvm\n\n"
    "makes ./enc a serial port (9600 Bd, 8E1) of a multiturn encoder that turns at 60\n"
    "rpm. The command prints 'ready s3684-rs485 pty:/dev/pts/4' and runs until Ctrl-C\n"
    "or SIGTERM. Send the bytes 40 42 02 to ask for the position.\n";

const char help_motion[] =
    "  Units: DEG REV (angle), RPM (speed), S MS (time). Positive is clockwise. The\n"
    "  encoder is ready at time 0. A file has lines 'time_s,angle_deg'.\n";

const char help_time[] = "  time   with --silkit, as the encoder has it: coordinated (default),\n"
                         "         autonomous or real\n";

const char help_exit[] =
    "0 after SIGTERM or SIGINT, 2 for a wrong or missing command line, 1 otherwise.\n";

static const struct {
    const char *command;
    const char *text;
} abouts[] = {
    {"list", "The command prints a line for each model: its name, its protocol, its\n"
             "resolution.\n"},
    {"faults", "A fault is a cause: you break something, and the encoder reports the matching\n"
               "code. A running encoder lists the same faults with FAULt:CATalog?, and FAULt:SET\n"
               "lets one happen:\n\n"
               "  drehgeber ctl 'FAUL:SET led_current_high,DUR 5S'\n"},
    {"run", "The encoder answers once the command has printed 'ready MODEL WIRE:ADDRESS', and\n"
            "runs until SIGTERM, SIGINT, SIGHUP or SIGQUIT. A rig file has shafts, gears\n"
            "between them, wires and encoders; the command prints 'ready rig' when all of\n"
            "them answer. Use ctl, top or web to control what runs.\n\n"
            "  drehgeber run s3684-rs485 --pty=enc --shaft 60RPM --nvm enc.nvm\n"
            "  drehgeber run f3668 --can vcan0 --node 1..127 --shaft 60RPM\n"
            "  drehgeber run vendor.eds --slcan --shaft 60RPM\n"
            "  drehgeber run bench.ini\n"},
    {"check", "The command prints a line for each object that only stores a value, is left out,\n"
              "or is read differently from the file, with its line number. The last line is the\n"
              "sum.\n\n"
              "  drehgeber check vendor.eds\n"},
    {"eds", "The command makes an electronic data sheet (CiA 306) from the object dictionary.\n\n"
            "  drehgeber eds f3668 > f3668.eds\n"
            "  drehgeber eds f3668 | drehgeber run - --slcan\n\n"
            "For a file, --explain prints what each object does in the simulated encoder: it\n"
            "is simulated, stores a value, is constant, or is refused.\n\n"
            "  drehgeber eds vendor.eds --explain\n"},
    {"model", "The command prints the model's figures as a struct, and a dg_device for\n"
              "dg_host_init() and similar functions. Link it with the library, or with the\n"
              "protocol's folder of the sources. An EDS file becomes rows of its dictionary.\n\n"
              "  drehgeber model rls-la11-26 --c > rls_la11_26.c\n"
              "  drehgeber model vendor.eds --c > vendor.c\n"},
    {"biss", "The command switches the encoder on and prints its answers.\n\n"
             "  drehgeber biss s3684-biss read --shaft 90DEG --trace biss.vcd\n"
             "  drehgeber biss s3684-biss registers 0x78 8\n"
             "  drehgeber biss s3684-biss eds\n"},
    {"ssi", "The command switches the encoder on and reads its word, once for each 'read'.\n\n"
            "  drehgeber ssi ssi-25 read --shaft 90DEG --trace ssi.vcd\n"},
    {"map", "The command prints the registers of the Modbus/TCP coupler. Use --ring for a\n"
            "ring of several encoders.\n\n"
            "  drehgeber map --ring ocd-ib-k3,ocd-ib-k1\n"},
    {"fmu", "Inputs of the FMU are shafts, faults and what encoders sense; settings are its\n"
            "parameters. Outputs are positions, signals, frames, and in FMI 3 also CAN\n"
            "(FMI-LS-BUS) and RS485 as clocked binaries. The FMU contains its sources.\n"
            "Everything in a rig file acts in its FMU, except ports, traces and EEPROM\n"
            "files. Shafts without a motion are inputs, and encoders on one bus share it.\n\n"
            "  drehgeber fmu s3684-biss --output axis.fmu\n"
            "  drehgeber fmu vendor.eds --output vendor.fmu\n"},
    {"verify", "WIRE is --tty, --pty or --rs485 for RS485, --gpio for BiSS and SSI, --modbus\n"
               "for INTERBUS, and --can, --slcan or --socketcand for CANopen. --silkit is for\n"
               "RS485 and CANopen in a simulation, with --set time=... as the encoder has it.\n"
               "Without --write, verify changes nothing. Without --alone, it sends nothing\n"
               "that another device would obey. It prints\n"
               "'agrees', 'differs' or 'not seen: why' for each clause. The status is 1 when a\n"
               "clause differs. CLAUSE is one clause, or the beginning of several; without it,\n"
               "verify checks all of them. When a run with --write was interrupted, --restore\n"
               "puts back the old values; after a run with --power, give that, too. Please send\n"
               "us your report (--report).\n"
               "The EDS file of a CANopen device can be the MODEL: verify reads its objects.\n\n"
               "  drehgeber verify s3684-rs485 --tty=/dev/ttyUSB0 --report s3684.txt\n"
               "  drehgeber verify s3684-biss --gpio=gpiochip0:4,5\n"
               "  drehgeber verify f3668 --can=can0 --node 63\n"
               "  drehgeber verify vendor.eds --can=can0 --node 5\n"
               "  drehgeber verify f3668 --can=can0 --write --power ./relay\n"
               "  drehgeber verify f3668 --can=can0 --restore --power ./relay\n"},
    {"ctl", "ctl sends the commands and prints the answers; without a command it reads them\n"
            "from stdin. Without --control, ctl talks to the only running rig. A number\n"
            "without a unit is in DEG, RPM, RPM/S, MS, DEGC, MV or UA; DURation of FAULt:SET\n"
            "needs its unit. On a terminal, ctl shows control characters of an answer as\n"
            "\\x1B; a file or pipe gets the bytes. When no answer has come for 5 s, ctl\n"
            "prints a line on stderr.\n\n"
            "  drehgeber ctl 'SHAF:ACC 600RPM/S; MOVE 90DEG,120RPM; *OPC?' 'SHAF:POS?'\n"},
    {"top", "top shows shafts as dials, a line for each encoder, and what is on its wire. The\n"
            "window needs at least 40 columns and 10 lines; a large one shows more. Without\n"
            "an address, top shows the only running rig. When NO_COLOR is set, top uses no\n"
            "colours.\n"},
    {"web", "web prints 'ready web http://127.0.0.1:8080/#token=...' and serves that page\n"
            "until SIGTERM, SIGINT or SIGHUP. The page shows shafts, encoders, LEDs and\n"
            "wires, and has faults to click and a prompt. Without an address, it shows the\n"
            "only running rig. A user who has the token can control the rig; with --watch the\n"
            "page only shows it.\n\n"
            "  drehgeber web --listen 127.0.0.1:0 --watch\n"},
    {"explain", "CAPTURE is a log of candump, a pcapng or pcap file (SocketCAN), a VCD file or a\n"
                "sigrok session (RS485, BiSS, SSI), or a serial log. A serial log has lines\n"
                "'SECONDS < BYTES' for bytes to the encoder, with > for its answers. explain\n"
                "prints a line for each message: time, direction, meaning, [chapter].\n\n"
                "With --against, explain sends the master's messages to MODEL at their recorded\n"
                "times, and prints each answer that differs: the recorded bytes and those of the\n"
                "model. Positions come from CAPTURE. The status is 1 when an answer differs.\n\n"
                "  drehgeber explain bus.log\n"
                "  drehgeber explain bus.log --against=f3668 --node=63\n"},
    {"help", "--help after a command prints the same text and starts nothing.\n"},
};

const char *help_about(const char *command)
{
    size_t i = 0;
    while (i + 1u < DG_COUNT(abouts) && strcmp(abouts[i].command, command) != 0) {
        i++;
    }
    return abouts[i].text;
}

/* Where the text of a model begins, of a command, of an option and of a setting. */
#define MODEL_AT 15
#define COMMAND_AT 40
#define OPTION_AT 29
#define SETTING_AT 26

/* The text behind what has been printed up to `column`, or below it. */
static void print_text(const char *text, int column, int at)
{
    if (column >= at) {
        (void)putchar('\n');
        column = 0;
    }
    columns_put(text, column, at, COLUMNS_WIDTH);
}

static void print_command(const struct command_row *row)
{
    print_text(row->help, printf("  drehgeber %s", row->usage), COMMAND_AT);
}

static void print_option(const struct argp_option *option)
{
    const bool optional = (option->flags & OPTION_ARG_OPTIONAL) != 0;
    int column = isascii(option->key) ? printf("  -%c, ", option->key) : printf("      ");
    column += printf("--%s", option->name);
    if (option->arg != NULL) {
        column += printf(optional ? "[=%s]" : "=%s", option->arg);
    }
    print_text(option->doc, column, OPTION_AT);
}

static void print_options(const struct command_row *row, const struct lx_stack *stack)
{
    struct argp_option *table = options_table(row, stack);
    for (size_t i = 0; table != NULL && !options_end(&table[i]); i++) {
        if (table[i].name != NULL) {
            print_option(&table[i]);
        } else {
            (void)printf("%s %s\n", i == 0 ? "" : "\n", table[i].doc);
        }
    }
    free(table);
}

/* --- settings --- */

static const struct dg_device *any_of(const struct lx_stack *stack)
{
    size_t i = 0;
    while (dg_devices[i]->stack != stack->core) {
        i++;
    }
    return dg_devices[i];
}

/* With `device` its own defaults are told; without one those that all have, which are the port's.
 */
static void print_own(const struct lx_stack *stack, const struct dg_device *device, FILE *to)
{
    void *settings = calloc(1, stack->handle->settings_size);
    struct lx_keys lists[LX_STACK_LISTS];
    if (settings != NULL) {
        lx_stack_deliver(stack, device == NULL ? any_of(stack) : device, settings);
    }
    lx_stack_keys(stack, device, settings, NULL, lists);
    if (device == NULL) {
        lists[LX_STACK_CORE].base = NULL;
    }
    lx_keys_help(&lists[LX_STACK_END], to);
    lx_keys_help(&lists[LX_STACK_OWN], to);
    lx_keys_help(&lists[LX_STACK_CORE], to);
    free(settings);
}

void help_senses(const struct lx_stack *stack, FILE *to)
{
    struct dg_world world;
    const struct lx_keys keys = {
        .rows = dg_world_keys.rows,
        .count = dg_world_keys.count,
        .base = &world,
        .without = stack == NULL ? 0 : stack->handle->blind,
    };
    dg_world_init(&world);
    lx_keys_help(&keys, to);
}

/* The base of keys is written to only by setting them. */
static void *readable(const void *defaults)
{
    void *base;
    memcpy(&base, &defaults, sizeof base);
    return base;
}

static bool has_keys(const struct dg_plan_wire_kind *wire, const struct lx_stack *stack,
                     const struct dg_keys *keys)
{
    return wire->keys == keys && dg_plan_carries(wire, stack->core);
}

/* Wires with the same keys are told once, by the first of them. @return the others' names, too; "":
   an earlier one has told */
static struct lx_words wires_with(const struct lx_stack *stack, size_t first)
{
    const struct dg_keys *keys = dg_plan_wires[first].keys;
    struct lx_words names = {""};
    size_t count = 0;
    size_t told = 0;
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        count += has_keys(&dg_plan_wires[i], stack, keys) ? 1u : 0u;
    }
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        char name[32];
        if (!has_keys(&dg_plan_wires[i], stack, keys)) {
            continue;
        }
        if (i < first) {
            return (struct lx_words){""};
        }
        (void)snprintf(name, sizeof name, "--%s", dg_plan_wires[i].name);
        lx_words_item(&names, name, told++, count, " and ");
    }
    return names;
}

/* Whether encoders are on such a wire when the command is done; NULL: any command. */
static bool has_wire(const struct command_row *row, const struct dg_plan_wire_kind *wire)
{
    return row == NULL || row->wires ||
           (row->command == COMMAND_ASK && lx_wire_of(wire)->simulated);
}

static void print_wire_keys(const struct command_row *row, const struct lx_stack *stack, FILE *to)
{
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        const struct dg_plan_wire_kind *wire = &dg_plan_wires[i];
        const struct dg_keys *rows = wire->keys;
        const bool has = rows != NULL && dg_plan_carries(wire, stack->core) && has_wire(row, wire);
        const struct lx_words names = has ? wires_with(stack, i) : (struct lx_words){""};
        if (names.text[0] != '\0') {
            const struct lx_keys keys = {
                .rows = rows->rows,
                .count = rows->count,
                .base = readable(wire->settings),
            };
            (void)fprintf(to, " of %s:\n", names.text);
            lx_keys_help(&keys, to);
        }
    }
}

void help_keys(const struct command_row *row, const struct lx_stack *stack,
               const struct dg_device *device, FILE *to)
{
    print_own(stack, device, to);
    print_wire_keys(row, stack, to);
}

/* Lines "  NAME   what it is (range)", which may be long, and " title:". */
static void print_lines(char *lines)
{
    char *rest = lines;
    const char *line;
    while ((line = strsep(&rest, "\n")) != NULL) {
        if (line[0] == ' ' && line[1] == ' ') {
            const size_t name = 2u + strcspn(line + 2, " ");
            const int column = printf("%.*s", (int)name, line);
            print_text(line + name + strspn(line + name, " "), column, SETTING_AT);
        } else if (line[0] != '\0') {
            (void)puts(line);
        }
    }
}

/* What can be set of encoders and wires. Without keys of encoders the wires' own heading, " of
   --can:", is that of the first ones. @return whether any is a factory figure */
static bool print_stack(const struct command_row *row, const struct lx_stack *stack,
                        const struct dg_device *device)
{
    char *lines = NULL;
    size_t n = 0;
    FILE *to = open_memstream(&lines, &n);
    if (to == NULL) {
        return false;
    }
    help_keys(row, stack, device, to);
    (void)fclose(to);
    const bool factory = strstr(lines, "(factory)") != NULL;
    if (strncmp(lines, "  ", 2) == 0) {
        (void)printf("\n KEY=VALUE of %s%s:\n", device == NULL ? stack->trace->title : device->name,
                     device == NULL ? " encoders" : "");
    } else if (lines[0] != '\0') {
        (void)fputs("\n KEY=VALUE", stdout);
    }
    print_lines(lines);
    free(lines);
    return factory;
}

static void print_senses(const struct command_row *row, const struct lx_stack *stack)
{
    char *lines = NULL;
    size_t n = 0;
    FILE *to = open_memstream(&lines, &n);
    if (to == NULL) {
        return;
    }
    help_senses(stack, to);
    (void)fclose(to);
    (void)printf("\n KEY=VALUE of what %s:\n",
                 stack == NULL ? "encoders sense (INTERBUS: not all of it)" : "it senses");
    print_lines(lines);
    free(lines);
    if (row == NULL || row->wires) {
        (void)fputs("  Over time: " DG_COURSE_FORM " instead of VALUE,\n"
                    "  with lines time_s,VALUE.\n",
                    stdout);
    }
}

static void print_factory(void)
{
    (void)fputs("  (factory): a new --nvm file gets this value; an existing one must have it.\n",
                stdout);
}

static void print_settings(void)
{
    for (size_t i = 0; i < lx_stack_count; i++) {
        (void)print_stack(NULL, lx_stacks[i], NULL);
    }
    print_senses(NULL, NULL);
    print_factory();
}

/* --- the whole --- */

static void print_models(void)
{
    for (size_t i = 0; i < dg_device_count; i++) {
        struct lx_words about = {""};
        lx_words_add(&about, "%s, %s", dg_devices[i]->wire, dg_devices[i]->resolution);
        print_text(about.text, printf("  %s", dg_devices[i]->name), MODEL_AT);
    }
}

static void print_everything(void)
{
    (void)printf("drehgeber - simulate absolute encoders, byte for byte\n\n"
                 "%s\n",
                 help_intro);
    for (size_t i = 0; i < command_row_count; i++) {
        print_command(&command_rows[i]);
    }
    (void)fputs("\n Models:\n", stdout);
    print_models();
    (void)fputs("\n", stdout);
    print_options(NULL, NULL);
    (void)printf("\n MOTION:\n  %s\n%s", dg_motion_forms, help_motion);
    print_settings();
    (void)printf("\n Exit status:\n  %s", help_exit);
}

static bool uses(const struct command_row *row, const char *option)
{
    return row->takes == NULL || strstr(row->takes, option) != NULL;
}

/* What whoever wrote the model had read, and what it is not like. */
static void print_text_of(const char *title, const char *text)
{
    struct lx_words line = {""};
    if (text != NULL) {
        lx_words_add(&line, "%s: %s", title, text);
        print_text(line.text, 0, 1);
    }
}

static void print_about(const struct dg_device *device, const struct dg_plan_model *text)
{
    struct lx_words about = {""};
    lx_words_add(&about, "%s: %s, %s; %s is its usual wire", device->name, device->wire,
                 device->resolution, lx_stack_of(device)->wire);
    (void)fputs("\n", stdout);
    print_text(about.text, 0, 1);
    if (text != NULL) {
        print_text_of("Source", text->source);
        print_text_of("Not modelled", text->unmodelled);
    }
}

static void print_one(const struct options *options)
{
    const struct command_row *row = options->row;
    const struct dg_device *device = options->device;
    for (size_t i = 0; i < command_row_count; i++) {
        if (command_rows[i].command == row->command) {
            print_command(&command_rows[i]);
        }
    }
    (void)printf("\n%s", help_about(row->name));
    if (device != NULL) {
        print_about(device, options->text);
    }
    (void)fputs("\n", stdout);
    print_options(row, device == NULL ? NULL : lx_stack_of(device));
    if (uses(row, " shaft ")) {
        (void)printf("\n MOTION:\n  %s\n%s", dg_motion_forms, help_motion);
    }
    if (row->command == COMMAND_VERIFY) {
        (void)printf("\n KEY=VALUE:\n%s", help_time);
    } else if (uses(row, " set ") && device != NULL) {
        const bool factory = print_stack(row, lx_stack_of(device), device);
        print_senses(row, lx_stack_of(device));
        if (factory && uses(row, " nvm ")) {
            print_factory();
        }
    } else if (uses(row, " set ")) {
        (void)printf("\n KEY=VALUE: 'drehgeber %s MODEL --help' lists those of a model\n",
                     row->command == COMMAND_EXPLAIN ? "run" : row->name);
    }
}

void help_print(const struct options *options)
{
    const struct command_row *row = options->row;
    if (row == NULL || row->command == COMMAND_HELP) {
        print_everything();
    } else {
        print_one(options);
    }
}
