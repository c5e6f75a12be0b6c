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

/* Those of the longest name that is built in, and in the catalogue. */
#define NAME_WIDTH 12
#define SOLD_WIDTH 24

/* --- models --- */

/* What stands in the list. */
struct entry {
    const struct dg_device *device;
    const struct dg_plan_model *text; /* NULL: it is built in */
    const struct model_file *file;    /* that has it; NULL: it is built in */
};

static void list_line(const struct entry *entry)
{
    const struct dg_device *device = entry->device;
    const int width = entry->text == NULL ? NAME_WIDTH : SOLD_WIDTH;
    (void)printf("%-*s %s, %s\n", width, device->name, device->wire, device->resolution);
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

static void list_member(const char *name, const char *text)
{
    if (text != NULL) {
        json_member(name, text);
        (void)fputs(", ", stdout);
    }
}

static void list_model(const struct entry *entry)
{
    const struct dg_device *device = entry->device;
    const struct dg_plan_model *row = entry->text;
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
        {"file", row == NULL ? NULL : entry->file->path},
        {"base", row == NULL ? NULL : row->base->name},
        {"source", row == NULL ? NULL : row->source},
        {"unmodelled", row == NULL ? NULL : row->unmodelled},
    };
    (void)fputs("  {", stdout);
    for (size_t i = 0; i < DG_COUNT(members); i++) {
        list_member(members[i].name, members[i].text);
    }
    list_wires(stack);
    (void)fputs("}", stdout);
}

/* The way each is told, and what stands between them. */
struct listing {
    void (*tell)(const struct entry *entry);
    const char *between;
    const char *before; /* the next one */
};

static void list_entry(struct listing *self, const struct entry *entry)
{
    (void)fputs(self->before, stdout);
    self->tell(entry);
    self->before = self->between;
}

/* All models of a file but those that nobody can name: of the catalogue, those that the user's
   folder has, too. */
static void list_file(struct listing *self, const struct model_file *files,
                      const struct model_file *file)
{
    const struct dg_plan *plan = &file->plan;
    struct lx_error error;
    if (plan->memory == NULL) {
        (void)complain(&file->unread, EXIT_OTHER);
    }
    for (size_t i = 0; i < plan->model_count; i++) {
        const struct entry entry = {plan->models[i].device, &plan->models[i], file};
        const struct dg_plan_model *meant = models_find(files, entry.device->name, &error);
        if (meant == entry.text) {
            list_entry(self, &entry);
        } else if (models_rival(files, file, entry.device->name) != NULL) {
            (void)complain(&error, EXIT_OTHER);
        }
    }
}

int list_command(const struct options *options)
{
    struct listing listing = {list_line, "", ""};
    if (options->json) {
        listing = (struct listing){list_model, ",\n", "[\n"};
    }
    for (size_t i = 0; i < dg_device_count; i++) {
        list_entry(&listing, &(struct entry){.device = dg_devices[i]});
    }
    struct model_file *files = models_read_all();
    for (const struct model_file *file = files; file != NULL; file = file->next) {
        list_file(&listing, files, file);
    }
    models_free(files);
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
    struct lx_words title = {""};
    lx_words_add(&title, "What can happen to %s, how it reacts (and where the manual says so);",
                 device->name);
    columns_put(title.text, 0, 0, width);
    (void)puts("in a running encoder: drehgeber ctl 'FAUL:SET NAME', 'FAUL:CLE NAME'.");
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
