/* SPDX-License-Identifier: MIT */
/* Tables of docs/rigs.md: kinds of wire, what can be set of them, and of encoders on them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "key.h"
#include "manual.h"
#include "trace.h"

/* A bar would end the cell. */
static void print_cell(const char *text)
{
    (void)fputs(" ", stdout);
    for (; *text != '\0'; text++) {
        (void)printf(*text == '|' ? "\\%c" : "%c", *text);
    }
    (void)fputs(" |", stdout);
}

/* --- wires --- */

static const char *address_of(const struct dg_plan_wire_kind *kind)
{
    return kind->where == NULL ? "none" : kind->where;
}

static const char *usual_of(const struct dg_plan_wire_kind *kind)
{
    if (kind->where_needed) {
        return "needed";
    }
    if (kind->usual != NULL) {
        return kind->usual;
    }
    return kind->where == NULL ? "" : "any";
}

static void print_wires(void)
{
    (void)puts("| kind | address | default | encoders | what it is |");
    (void)puts("|---|---|---|---|---|");
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        const struct dg_plan_wire_kind *kind = &dg_plan_wires[i];
        (void)printf("| `%s` |", kind->name);
        print_cell(address_of(kind));
        print_cell(usual_of(kind));
        (void)printf(" %zu |", kind->stations_max);
        print_cell(lx_wire_of(kind)->help);
        (void)putchar('\n');
    }
}

/* --- settings --- */

/* `wires`: which have it, NULL: there is no such column. `base` NULL: no default is told. */
static void print_setting(const struct dg_key *key, const void *base, const char *wires)
{
    (void)printf("| `%s` |", key->name);
    if (wires != NULL) {
        print_cell(wires);
    }
    print_cell(lx_key_range(key).text);
    print_cell(base == NULL ? "" : lx_key_value(key, base).text);
    print_cell(key->help);
    (void)putchar('\n');
}

/* Names of the kinds that have the keys of the first one; "": an earlier one has told them. */
static struct lx_words wires_with_keys_of(size_t first)
{
    struct lx_words names = {""};
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        if (dg_plan_wires[i].keys == dg_plan_wires[first].keys) {
            if (i < first) {
                return (struct lx_words){""};
            }
            lx_words_add(&names, "%s`%s`", i == first ? "" : " ", dg_plan_wires[i].name);
        }
    }
    return names;
}

static void print_wire_keys(void)
{
    (void)puts("| key | of | takes | default | what it is |");
    (void)puts("|---|---|---|---|---|");
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        const struct dg_keys *keys = dg_plan_wires[i].keys;
        const struct lx_words names = keys == NULL ? (struct lx_words){""} : wires_with_keys_of(i);
        for (size_t j = 0; names.text[0] != '\0' && j < keys->count; j++) {
            print_setting(&keys->rows[j], dg_plan_wires[i].settings, names.text);
        }
    }
}

static void print_list(const struct lx_keys *keys)
{
    for (size_t i = 0; i < keys->count; i++) {
        const struct dg_key *key = lx_keys_row(keys, i);
        if (key != NULL) {
            print_setting(key, keys->base, NULL);
        }
    }
}

/* The first model of each protocol, and what can be set of it. */
static void print_encoders_of(const struct lx_stack *stack, const struct dg_device *model)
{
    void *settings = calloc(1, stack->handle->settings_size);
    struct lx_keys lists[LX_STACK_LISTS];
    if (settings != NULL) {
        lx_stack_deliver(stack, model, settings);
        lx_stack_keys(stack, NULL, settings, NULL, lists);
        (void)printf("\n%s; defaults are those of `%s`:\n\n", stack->trace->title, model->name);
        (void)puts("| key | takes | default | what it is |");
        (void)puts("|---|---|---|---|");
        print_list(&lists[LX_STACK_END]);
        print_list(&lists[LX_STACK_OWN]);
        print_list(&lists[LX_STACK_CORE]);
    }
    free(settings);
}

static void print_settings(void)
{
    struct dg_world world;
    const struct lx_keys senses = {
        .rows = dg_world_keys.rows, .count = dg_world_keys.count, .base = &world};
    dg_world_init(&world);
    (void)puts("| key | takes | default | what it is |");
    (void)puts("|---|---|---|---|");
    print_list(&senses);
    for (size_t i = 0; i < lx_stack_count; i++) {
        size_t model = 0;
        while (dg_devices[model]->stack != lx_stacks[i]->core) {
            model++;
        }
        print_encoders_of(lx_stacks[i], dg_devices[model]);
    }
}

bool manual_table(const char *name)
{
    static const struct {
        const char *name;
        void (*print)(void);
    } tables[] = {
        {"wires", print_wires},
        {"wire-keys", print_wire_keys},
        {"settings", print_settings},
    };
    for (size_t i = 0; i < DG_COUNT(tables); i++) {
        if (strcmp(tables[i].name, name) == 0) {
            tables[i].print();
            return true;
        }
    }
    return false;
}
