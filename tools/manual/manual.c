/* SPDX-License-Identifier: MIT */
/*
 * usage: reference-manual man [COMMAND] | bash | zsh | commands | wires | wire-keys | settings
 *
 * tools/reference/update writes what it prints into tools/man, tools/completion and docs/rigs.md.
 */
#include "manual.h"

#include <stdio.h>
#include <string.h>

#include "drehgeber/drehgeber.h"

bool manual_is_first(const struct command_row *row)
{
    return command_find(row->name) == row;
}

char manual_short(const struct argp_option *option)
{
    return (char)(option->key > ' ' && option->key <= '~' ? option->key : '\0');
}

static bool usage_has(const struct command_row *row, const char *word)
{
    for (size_t i = 0; i < command_row_count; i++) {
        if (strcmp(command_rows[i].name, row->name) == 0 &&
            strstr(command_rows[i].usage, word) != NULL) {
            return true;
        }
    }
    return false;
}

bool manual_takes_model(const struct command_row *row)
{
    return usage_has(row, " MODEL");
}

bool manual_takes_rig(const struct command_row *row)
{
    return usage_has(row, "RIG.ini");
}

void manual_models(const struct dg_stack *stack)
{
    for (size_t i = 0; i < dg_device_count; i++) {
        if (stack == NULL || dg_devices[i]->stack == stack) {
            (void)printf(" %s", dg_devices[i]->name);
        }
    }
}

static void put_keys(const struct lx_keys *lists, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < lists[i].count; j++) {
            const struct dg_key *row = lx_keys_row(&lists[i], j);
            if (row != NULL) {
                (void)printf(" %s", row->name);
            }
        }
    }
}

void manual_keys(const struct lx_stack *stack)
{
    struct lx_keys lists[LX_STACK_LISTS];
    lx_stack_keys(stack, NULL, NULL, NULL, lists);
    put_keys(lists, LX_STACK_LISTS);
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        bool before = dg_plan_wires[i].keys == NULL;
        for (size_t j = 0; j < i; j++) {
            before = before || dg_plan_wires[j].keys == dg_plan_wires[i].keys;
        }
        if (!before && dg_plan_carries(&dg_plan_wires[i], stack->core)) {
            const struct dg_keys *keys = dg_plan_wires[i].keys;
            put_keys(&(struct lx_keys){.rows = keys->rows, .count = keys->count}, 1);
        }
    }
}

static void print_commands(void)
{
    for (size_t i = 0; i < command_row_count; i++) {
        if (manual_is_first(&command_rows[i])) {
            (void)puts(command_rows[i].name);
        }
    }
}

int main(int argc, char **argv)
{
    const char *what = argc > 1 ? argv[1] : "";
    if (strcmp(what, "man") == 0 && argc <= 3 && manual_page(argv[2])) {
        return 0;
    }
    if (argc == 2 && strcmp(what, "bash") == 0) {
        manual_bash();
        return 0;
    }
    if (argc == 2 && strcmp(what, "zsh") == 0) {
        manual_zsh();
        return 0;
    }
    if (argc == 2 && strcmp(what, "commands") == 0) {
        print_commands();
        return 0;
    }
    if (argc == 2 && manual_table(what)) {
        return 0;
    }
    (void)fputs(
        "usage: reference-manual man [COMMAND] | bash | zsh | commands | wires | wire-keys | "
        "settings\n",
        stderr);
    return 2;
}
