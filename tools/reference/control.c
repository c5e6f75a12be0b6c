/* SPDX-License-Identifier: MIT */
/*
 * Prints the generated parts of src/control/README.md, and what protocols add in their own pages,
 * from the command tables and the catalogues.
 */
#include <stdio.h>
#include <string.h>

#include "drehgeber/control.h"
#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"
#include "drehgeber/quantity.h"

static void print_command_rows(const struct dg_scpi_commands *list)
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

static void print_command_table(const struct dg_scpi_commands *list)
{
    puts("| command | parameters | query | what |");
    puts("|---|---|---|---|");
    print_command_rows(list);
}

static const char *fault_kind_of(enum dg_fault_kind kind)
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
        printf("| `%s` | %s | %s | %s | %s |\n", entry.name, fault_kind_of(entry.kind), entry.cause,
               entry.effect, entry.chapter);
    }
}

/* Whether `word` is the name of `stack`, with `behind` behind it. */
static bool names(const char *word, const struct dg_stack *stack, const char *behind)
{
    const size_t n = strlen(stack->name);

    return strncmp(word, stack->name, n) == 0 && strcmp(word + n, behind) == 0;
}

/* All quantities have the same three: the header without the quantity's part. */
static void print_courses(void)
{
    puts("| command | parameters | query | what |");
    puts("|---|---|---|---|");
    for (size_t i = 0; i < dg_course_commands.count; i += DG_QUANTITY_COUNT) {
        struct dg_scpi_command row = dg_course_commands.rows[i];
        char header[64];
        (void)snprintf(header, sizeof header, "WORLd:...%s", strstr(row.header, ":PROFile"));
        row.header = header;
        print_command_rows(&(struct dg_scpi_commands){&row, 1});
    }
}

/* STACK: its faults; the last one of a stack has everything that can fail. STACK-commands: its own
 * commands. */
static bool print_part(const char *word)
{
    const struct dg_device *found = NULL;

    for (size_t i = 0; i < dg_device_count; i++) {
        found = names(word, dg_devices[i]->stack, "") ? dg_devices[i] : found;
    }
    if (found != NULL) {
        print_faults(found);
        return true;
    }
    for (size_t i = 0; i < dg_instrument_count; i++) {
        if (names(word, dg_instruments[i]->stack, "-commands")) {
            print_command_table(&dg_instruments[i]->commands);
            return true;
        }
    }
    return false;
}

int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "commands") == 0) {
        print_command_table(&dg_control_commands);
        return 0;
    }
    if (argc == 2 && strcmp(argv[1], "courses") == 0) {
        print_courses();
        return 0;
    }
    if (argc == 2 && print_part(argv[1])) {
        return 0;
    }
    (void)fprintf(stderr, "usage: reference-control commands|courses|STACK|STACK-commands\n");
    return 2;
}
