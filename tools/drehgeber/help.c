/* SPDX-License-Identifier: MIT */
/* An example first, then the reference; every table in it is the one the program works with. */
#include "help.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "list.h"
#include "motion_words.h"

/* Where the text of a command begins. */
#define TEXT_AT 40

/* A line "  drehgeber ..." with the text behind it, which may go on in lines below. */
static void print_command(const struct command_row *row)
{
    const char *line = row->help;
    int at = printf("  drehgeber %s", row->usage);
    while (*line != '\0') {
        const size_t n = strcspn(line, "\n");
        (void)printf("%*s  %.*s\n", at < TEXT_AT ? TEXT_AT - at : 0, "", (int)n, line);
        line += n + (line[n] == '\n' ? 1u : 0u);
        at = 0;
    }
}

static void print_options(const struct command_row *row)
{
    static char name[] = "drehgeber";
    struct argp_option *table = options_table(row);
    const struct argp argp = {.options = table};
    if (table != NULL) {
        argp_help(&argp, stdout, ARGP_HELP_LONG, name);
    }
    free(table);
}

static void print_motions(void)
{
    (void)printf("\n MOTION:\n"
                 "  %s\n"
                 "  Units: DEG REV (angle), RPM (speed), S MS (time). Positive is clockwise, time\n"
                 "  0 is when the encoder is ready. A file has lines 'time_s,angle_deg'.\n",
                 lx_shaft_forms);
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
static void print_own(const struct lx_stack *stack, const struct dg_device *device)
{
    void *settings = calloc(1, stack->settings_size);
    struct lx_keys lists[LX_STACK_LISTS];
    if (settings != NULL) {
        stack->defaults(settings, device == NULL ? any_of(stack) : device);
    }
    lx_stack_keys(stack, device, settings, NULL, lists);
    if (device == NULL) {
        lists[LX_STACK_CORE].base = NULL;
    }
    lx_keys_help(&lists[LX_STACK_OWN], stdout);
    lx_keys_help(&lists[LX_STACK_CORE], stdout);
    free(settings);
}

static void print_world(const struct lx_stack *stack)
{
    struct dg_world world;
    const struct lx_keys keys = {
        .rows = dg_world_keys.rows,
        .count = dg_world_keys.count,
        .base = &world,
        .without = stack == NULL ? 0 : stack->blind,
    };
    dg_world_init(&world);
    lx_keys_help(&keys, stdout);
}

/* Whether an earlier kind of wire has the same keys. */
static bool told_before(size_t index)
{
    for (size_t i = 0; i < index; i++) {
        if (lx_wires[i].keys == lx_wires[index].keys) {
            return true;
        }
    }
    return false;
}

/* The base of keys is written to only by setting them. */
static void *readable(const void *defaults)
{
    void *base;
    memcpy(&base, &defaults, sizeof base);
    return base;
}

static void print_wire_keys(const struct lx_stack *stack)
{
    for (size_t i = 0; i < lx_wire_count; i++) {
        const struct lx_wire *wire = &lx_wires[i];
        if (wire->keys != NULL && !told_before(i) && lx_wire_carries(wire, stack)) {
            struct lx_keys keys = *wire->keys;
            keys.base = readable(wire->defaults);
            (void)printf(" of the %s wire itself:\n", stack->title);
            lx_keys_help(&keys, stdout);
        }
    }
}

static void print_stack(const struct lx_stack *stack, const struct dg_device *device)
{
    (void)printf("\n KEY=VALUE of %s%s:\n", device == NULL ? stack->title : device->name,
                 device == NULL ? " encoders" : "");
    print_own(stack, device);
    print_wire_keys(stack);
}

static void print_senses(const struct lx_stack *stack)
{
    (void)printf("\n KEY=VALUE of what %s:\n",
                 stack == NULL ? "encoders sense (INTERBUS: not all of it)" : "it senses");
    print_world(stack);
    (void)fputs("  (factory) is burnt into a new --nvm file; an existing one has to agree.\n",
                stdout);
}

static void print_settings(void)
{
    for (size_t i = 0; i < lx_stack_count; i++) {
        print_stack(lx_stacks[i], NULL);
    }
    print_senses(NULL);
}

/* --- the whole --- */

static void print_everything(void)
{
    (void)fputs(
        "drehgeber - be an absolute encoder, byte for byte\n"
        "\n"
        "  drehgeber run s3684-rs485 --pty=enc --shaft 60RPM --nvm enc.nvm\n"
        "\n"
        "makes ./enc a serial port (9600 Bd, 8E1) behind which a multiturn encoder turns\n"
        "at 60 rpm; it prints one line, 'ready s3684-rs485 pty:/dev/pts/4', and runs until\n"
        "Ctrl-C or SIGTERM. Ask it for its position with the bytes 40 42 02.\n"
        "\n",
        stdout);
    for (size_t i = 0; i < command_row_count; i++) {
        print_command(&command_rows[i]);
    }
    (void)fputs("\n Models:\n", stdout);
    list_models("  ");
    (void)fputs("\n", stdout);
    print_options(NULL);
    print_motions();
    print_settings();
    (void)fputs("\n Exit status: 0 after SIGTERM or SIGINT, 2 for a wrong command line, 1 for the "
                "rest.\n",
                stdout);
}

static bool uses(const struct command_row *row, const char *option)
{
    return row->takes == NULL || strstr(row->takes, option) != NULL;
}

static void print_one(const struct command_row *row, const struct dg_device *device)
{
    for (size_t i = 0; i < command_row_count; i++) {
        if (command_rows[i].command == row->command) {
            print_command(&command_rows[i]);
        }
    }
    if (device != NULL) {
        (void)printf("\n %s: %s, %s; %s is its usual wire\n", device->name, device->wire,
                     device->resolution, lx_stack_of(device)->wire);
    }
    (void)fputs("\n", stdout);
    print_options(row);
    if (uses(row, " shaft ")) {
        print_motions();
    }
    if (uses(row, " set ") && device != NULL) {
        print_stack(lx_stack_of(device), device);
        print_senses(lx_stack_of(device));
    } else if (uses(row, " set ")) {
        (void)printf("\n KEY=VALUE: 'drehgeber %s MODEL --help' says those of a model\n",
                     row->name);
    }
}

void help_print(const struct options *options)
{
    const struct command_row *row = options->row;
    if (row == NULL || row->command == COMMAND_HELP) {
        print_everything();
    } else {
        print_one(row, options->model == NULL ? NULL : dg_device_find(options->model));
    }
}
