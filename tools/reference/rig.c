/* SPDX-License-Identifier: MIT */
/*
 * Prints the tables of docs/rigs.md that are about sections of rig files, from the rows of the
 * reader. Those about wires and settings are of the command line: ../manual.
 */
#include <stdio.h>

#include "parts.h"
#include "rig_private.h"

static void print_key_row(const struct rig_key *key)
{
    (void)printf("| `%s` | %s | %s | %s |\n", key->name, key->takes,
                 key->usual == NULL ? "needed" : key->usual, key->help);
}

/* Whether an earlier model has the same key for its addresses. */
static bool is_told(size_t model, const char *key)
{
    size_t i = 0;

    while (i < model && (dg_devices[i]->stack->address_key == NULL ||
                         strcmp(dg_devices[i]->stack->address_key, key) != 0)) {
        i++;
    }
    return i < model;
}

/* Addresses are keys of their protocols. */
static void print_addresses(void)
{
    for (size_t i = 0; i < dg_device_count; i++) {
        const struct dg_device *model = dg_devices[i];
        const struct dg_key *row = dg_plan_address_row(model);
        if (row == NULL || is_told(i, row->name)) {
            continue;
        }
        const struct rig_number first = dg_plan_address_text(model, (int)row->min);
        const struct rig_number last = dg_plan_address_text(model, (int)row->max);
        const struct rig_number usual =
            dg_plan_address_text(model, model->stack->address_delivered);
        char takes[128];
        (void)snprintf(takes, sizeof takes, "%s to %s, or FIRST..LAST", first.text, last.text);
        const struct rig_key key = {row->name, takes, usual.text, row->help};
        print_key_row(&key);
    }
}

static int print_section(const char *name)
{
    const struct rig_kind *kind = dg_plan_kind_find(name);

    puts("| key | takes | default | what it is |");
    puts("|---|---|---|---|");
    for (const struct rig_key *key = kind->keys; key->name != NULL; key++) {
        print_key_row(key);
    }
    if (kind->numbered) {
        print_addresses();
    }
    return 0;
}

static int print_rig(void)
{
    return print_section("rig");
}

static int print_shaft(void)
{
    return print_section("shaft");
}

static int print_bus(void)
{
    return print_section("bus");
}

static int print_encoder(void)
{
    return print_section("encoder");
}

int main(int argc, char **argv)
{
    static const struct part parts[] = {
        {"rig", print_rig},
        {"shaft", print_shaft},
        {"bus", print_bus},
        {"encoder", print_encoder},
    };
    return print_one(argc, argv, parts, DG_COUNT(parts));
}
