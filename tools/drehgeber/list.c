/* SPDX-License-Identifier: MIT */
#include "list.h"

#include <stdio.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "columns.h"
#include "complain.h"
#include "drehgeber/drehgeber.h"
#include "json.h"
#include "models.h"
#include "run.h"

/* Where the text behind a fault's name begins, and how wide a line may be: as the terminal, but not
   so wide that nobody finds the next line. */
#define TEXT_AT 26
#define WIDTH_MIN 60
#define WIDTH_MAX 120

/* --- models --- */

static void list_line(const struct dg_device *device)
{
    (void)printf("%-12s %s, %s\n", device->name, device->wire, device->resolution);
}

static void list_wires(const struct lx_stack *stack)
{
    const char *between = "";
    (void)fputs("\"wires\": [", stdout);
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        if (dg_plan_carries(&dg_plan_wires[i], stack->core)) {
            (void)fputs(between, stdout);
            json_string(dg_plan_wires[i].name);
            between = ", ";
        }
    }
    (void)fputs("]", stdout);
}

static void list_model(const struct dg_device *device)
{
    const struct lx_stack *stack = lx_stack_of(device);
    const struct {
        const char *name;
        const char *text;
    } members[] = {
        {"model", device->name},
        {"speaks", device->wire},
        {"resolution", device->resolution},
        {"stack", stack->core->name},
        {"usual_wire", stack->wire},
    };
    (void)fputs("  {", stdout);
    for (size_t i = 0; i < DG_COUNT(members); i++) {
        json_member(members[i].name, members[i].text);
        (void)fputs(", ", stdout);
    }
    list_wires(stack);
    (void)fputs("}", stdout);
}

/* The way each is told, and what stands between them. */
struct listing {
    void (*tell)(const struct dg_device *device);
    const char *between;
    const char *before; /* the next one */
};

static void list_device(struct listing *self, const struct dg_device *device)
{
    (void)fputs(self->before, stdout);
    self->tell(device);
    self->before = self->between;
}

/* All models of a file of the folder. */
static bool list_file(void *ctx, const struct dg_plan *plan, const struct lx_error *error)
{
    if (error != NULL) {
        (void)complain(error, EXIT_OTHER);
    }
    for (size_t i = 0; i < plan->model_count; i++) {
        list_device(ctx, plan->models[i].device);
    }
    return false;
}

int list_command(const struct options *options)
{
    struct listing listing = {list_line, "", ""};
    if (options->json) {
        listing = (struct listing){list_model, ",\n", "[\n"};
    }
    for (size_t i = 0; i < dg_device_count; i++) {
        list_device(&listing, dg_devices[i]);
    }
    (void)models_search(list_file, &listing);
    (void)fputs(options->json ? "\n]\n" : "", stdout);
    return EXIT_OK;
}

/* --- faults --- */

static const struct {
    const char *word; /* as FAULt:CATalog? says */
    const char *title;
} kinds[] = {
    [DG_FAULT_WORLD] = {"WORLD", "What it senses"},
    [DG_FAULT_MEMORY] = {"MEMORY", "Its EEPROM, by region"},
    [DG_FAULT_WIRE] = {"WIRE", "Its wire"},
};
_Static_assert(DG_COUNT(kinds) == DG_FAULT_WIRE + 1, "a row for each kind");

static int line_width(void)
{
    struct winsize size;
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) {
        return COLUMNS_WIDTH;
    }
    return size.ws_col < WIDTH_MIN ? WIDTH_MIN : size.ws_col > WIDTH_MAX ? WIDTH_MAX : size.ws_col;
}

static void put_fault(const struct dg_fault_entry *entry, int width)
{
    char effect[512];
    const int column = printf("%s", entry->name);
    columns_put(entry->cause, column < TEXT_AT ? column : TEXT_AT, TEXT_AT, width);
    (void)snprintf(effect, sizeof effect, "-> %s (%s)", entry->effect, entry->chapter);
    columns_put(effect, 0, TEXT_AT, width);
}

static void put_table(const struct dg_device *device, const struct dg_fault_target *target)
{
    struct dg_fault_entry entry;
    int kind = -1;
    const int width = line_width();
    (void)printf("What can happen to %s, what it does about it (and where that is said);\n"
                 "with an encoder that runs: drehgeber ctl 'FAUL:SET NAME', 'FAUL:CLE NAME'.\n",
                 device->name);
    for (size_t i = 0; dg_fault_entry(target, i, &entry); i++) {
        if ((int)entry.kind != kind) {
            (void)printf("\n%s:\n", kinds[entry.kind].title);
            kind = (int)entry.kind;
        }
        put_fault(&entry, width);
    }
}

static void put_json(const struct dg_fault_target *target)
{
    struct dg_fault_entry entry;
    for (size_t i = 0; dg_fault_entry(target, i, &entry); i++) {
        const struct {
            const char *name;
            const char *text;
        } members[] = {
            {"name", entry.name},     {"kind", kinds[entry.kind].word}, {"cause", entry.cause},
            {"effect", entry.effect}, {"chapter", entry.chapter},
        };
        (void)fputs(i == 0 ? "[\n  {" : ",\n  {", stdout);
        for (size_t j = 0; j < DG_COUNT(members); j++) {
            (void)fputs(j == 0 ? "" : ", ", stdout);
            json_member(members[j].name, members[j].text);
        }
        (void)fputs("}", stdout);
    }
    (void)fputs("\n]\n", stdout);
}

int faults_command(const struct options *options)
{
    const struct dg_device *device = options->device;
    if (device == NULL) {
        struct lx_words right = {""};
        for (size_t i = 0; i < dg_device_count; i++) {
            lx_words_add(&right, " %s", dg_devices[i]->name);
        }
        lx_complain("faults needs a model; valid:%s", right.text);
        return EXIT_USAGE;
    }
    const struct dg_fault_target target = {
        .instrument = dg_instrument_of(device->stack),
        .layout = device->stack->layout(device->model),
        .singleturn = !device->stack->senses_multiturn(device->model),
    };
    if (options->json) {
        put_json(&target);
    } else {
        put_table(device, &target);
    }
    return EXIT_OK;
}
