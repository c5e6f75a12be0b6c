/* SPDX-License-Identifier: MIT */
/*
 * Prints the generated part of src/control/README.md from the command tables and the catalogues.
 */
#include <stdio.h>
#include <string.h>

#include "drehgeber/control.h"
#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"

static void print_list(const struct dg_scpi_commands *list)
{
    for (size_t i = 0; i < list->count; i++) {
        const struct dg_scpi_command *row = &list->rows[i];
        const char *quote = row->parameters[0] != '\0' ? "`" : "";
        char parameters[80] = "";
        /* A bar would end the column. */
        for (size_t n = 0, k = 0; row->parameters[k] != '\0' && n + 3 < sizeof parameters; k++) {
            if (row->parameters[k] == '|') {
                parameters[n++] = '\\';
            }
            parameters[n++] = row->parameters[k];
            parameters[n] = '\0';
        }
        printf("| `%s` | %s%s%s | %s | %s |\n", row->header, quote, parameters, quote,
               row->query == NULL ? ""
               : row->set == NULL ? "only"
                                  : "yes",
               row->help);
    }
}

static void print_commands(void)
{
    puts("| command | parameters | query | what |");
    puts("|---|---|---|---|");
    print_list(&dg_control_commands);
    for (size_t i = 0; i < dg_instrument_count; i++) {
        print_list(&dg_instruments[i]->commands);
    }
}

static const char *kind_of(enum dg_fault_kind kind)
{
    static const char *const names[] = {
        [DG_FAULT_WORLD] = "world",
        [DG_FAULT_MEMORY] = "memory",
        [DG_FAULT_WIRE] = "wire",
    };
    _Static_assert(DG_COUNT(names) == DG_FAULT_WIRE + 1, "a word for each kind");

    return names[kind];
}

static void print_faults(const struct dg_device *device)
{
    const struct dg_fault_target target = {.instrument = dg_instrument_of(device->stack),
                                           .layout = device->stack->layout(device->model)};
    struct dg_fault_entry entry;

    puts("| name | kind | cause | what the device does | source |");
    puts("|---|---|---|---|---|");
    for (size_t i = 0; dg_fault_entry(&target, i, &entry); i++) {
        printf("| `%s` | %s | %s | %s | %s |\n", entry.name, kind_of(entry.kind), entry.cause,
               entry.effect, entry.chapter);
    }
}

/* The last one of a stack has everything that can fail. */
static const struct dg_device *last_of(const char *stack)
{
    const struct dg_device *found = NULL;

    for (size_t i = 0; i < dg_device_count; i++) {
        if (strcmp(dg_devices[i]->stack->name, stack) == 0) {
            found = dg_devices[i];
        }
    }
    return found;
}

int main(int argc, char **argv)
{
    const struct dg_device *device = argc == 2 ? last_of(argv[1]) : NULL;

    if (argc == 2 && strcmp(argv[1], "commands") == 0) {
        print_commands();
        return 0;
    }
    if (device != NULL) {
        print_faults(device);
        return 0;
    }
    (void)fprintf(stderr, "usage: reference-control commands|hiperface|biss|canopen|interbus\n");
    return 2;
}
