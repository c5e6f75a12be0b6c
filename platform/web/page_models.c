/* SPDX-License-Identifier: MIT */
/*
 * Which encoder the page means: one that is built in, or what somebody has put into the page, the
 * text of a model or an EDS file.
 */
#include <string.h>

#include "drehgeber/devices.h"
#include "drehgeber/host.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/model.h"
#include "drehgeber/rig.h"

/* What the page gives and gets; `wrong` is one line, "" where more memory is right. */
struct web_source {
    const char *text;
    size_t n;
    uint8_t *memory;
    size_t size;
    char wrong[1024];
};

const struct dg_device *web_device(const char *name);
const char *web_device_name(const struct dg_device *device);
const char *web_device_what(const struct dg_device *device);
size_t web_host_size(const struct dg_device *device);
struct dg_host *web_host_make(void *memory, size_t size, const struct dg_device *device);
/* `name` says by its ending what the text is. @return NULL with source->wrong */
const struct dg_device *web_device_read(struct web_source *source, const char *name);

const struct dg_device *web_device(const char *name)
{
    return dg_device_find(name);
}

const char *web_device_name(const struct dg_device *device)
{
    return device->name;
}

const char *web_device_what(const struct dg_device *device)
{
    return device->resolution;
}

size_t web_host_size(const struct dg_device *device)
{
    const struct dg_host_wire *wire = dg_host_wire_of(device);

    return wire == NULL ? 0 : dg_host_size(device, wire);
}

struct dg_host *web_host_make(void *memory, size_t size, const struct dg_device *device)
{
    struct dg_host *self = dg_host_init(memory, size, device, dg_host_wire_of(device));

    if (self != NULL) {
        dg_host_take_side(self, dg_bus_side_of(device));
    }
    return self;
}

/* ------------------------------------------------------------ what is put in */

/* "line 3: ", as people count, who see one text. */
static void say_line(struct dg_text *to, unsigned line)
{
    if (line != 0) {
        dg_text_add(to, "line ");
        dg_text_add_number(to, line);
        dg_text_add(to, ": ");
    }
}

static void say_reason(struct dg_text *to, const char *what, const char *right)
{
    dg_text_add(to, what);
    dg_text_add(to, what[0] != '\0' && right[0] != '\0' ? "; " : "");
    dg_text_add(to, right);
}

/* A file of the kind that its ending says. */
static const struct dg_device *read_page_model(struct web_source *source,
                                               const struct dg_model_file *kind)
{
    const struct dg_model_source from = {source->text, source->n, source->memory, source->size};
    struct dg_text wrong = dg_text_in(source->wrong, sizeof source->wrong);
    struct dg_model_made made = {.device = NULL};
    struct dg_model_flaw flaw;
    const int result = kind->read(&from, &made, &flaw);

    if (result == DG_ERR_ARGUMENT) {
        say_line(&wrong, flaw.line);
        say_reason(&wrong, flaw.what, flaw.right);
    }
    return result == DG_OK ? made.device : NULL;
}

/* The last model of a text. The plan is in front of what it is made of. */
static const struct dg_device *read_models(struct web_source *source)
{
    struct dg_text wrong = dg_text_in(source->wrong, sizeof source->wrong);
    struct dg_plan *plan = (struct dg_plan *)(void *)source->memory;
    const size_t own = (sizeof *plan + DG_HOST_ALIGN - 1u) / DG_HOST_ALIGN * DG_HOST_ALIGN;
    struct dg_plan_error error;

    if (source->size <= own) {
        return NULL;
    }
    const struct dg_plan_setup setup = {
        .size = sizeof setup,
        .file = "text",
        .text = {source->text, source->n},
        .memory = source->memory + own,
        .memory_size = source->size - own,
    };
    const int result = dg_plan_read(plan, &setup, &error);
    if (result == DG_ERR_ARGUMENT) {
        say_line(&wrong, error.line);
        dg_text_add(&wrong, error.key);
        if (error.valued != DG_PLAN_UNVALUED) {
            dg_text_add(&wrong, " ");
            dg_text_add(&wrong, error.value);
        }
        dg_text_add(&wrong, error.key[0] != '\0' ? ": " : "");
        say_reason(&wrong, error.what, error.right);
    } else if (result == DG_OK && plan->model_count == 0) {
        dg_text_add(&wrong, "no [model NAME] in it");
    }
    return result == DG_OK && plan->model_count > 0 ? plan->models[plan->model_count - 1u].device
                                                    : NULL;
}

const struct dg_device *web_device_read(struct web_source *source, const char *name)
{
    const struct dg_model_file *kind = dg_model_file_of(name);

    source->wrong[0] = '\0';
    return kind != NULL ? read_page_model(source, kind) : read_models(source);
}
