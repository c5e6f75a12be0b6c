/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: a rig file. The input is the file. A plan that is made refers to nothing that is not
 * there; one that is refused is empty again, and one printable line says why.
 */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "drehgeber/host_wire.h"
#include "fuzz_input.h"
#include "memory_file.h"
#include "plan.h"
#include "wire.h"

static bool printable(const char *text)
{
    for (; *text != '\0'; text++) {
        if ((uint8_t)*text < ' ' || *text == 0x7F) {
            return false;
        }
    }
    return true;
}

static void check_settings(const struct dg_plan_settings *settings)
{
    for (size_t i = 0; i < settings->count; i++) {
        fuzz_must(settings->list[i].key != NULL && settings->list[i].value != NULL);
        fuzz_must(settings->list[i].line > 0);
    }
}

/* Whatever was taken can be made. */
static void check_model(const struct dg_plan_model *model)
{
    static _Alignas(DG_HOST_ALIGN) unsigned char memory[65536];
    const struct dg_device *device = model->device;
    const struct dg_host_wire *wire = dg_host_wire_of(device);

    fuzz_must(dg_plan_name_fits(device->name) && device->stack == model->base->stack);
    fuzz_must(model->depth >= 1 && model->depth <= DG_PLAN_BASES_MAX);
    fuzz_must(dg_host_size(device, wire) <= sizeof memory);
    fuzz_must(dg_host_init(memory, sizeof memory, device, wire) != NULL);
}

static void check_plan(const struct dg_plan *plan)
{
    fuzz_must(plan->name != NULL && plan->control_count <= DG_PLAN_CONTROLS_MAX);
    fuzz_must(plan->encoder_count >= 1 || plan->model_count >= 1);
    for (size_t i = 0; i < plan->model_count; i++) {
        check_model(&plan->models[i]);
        fuzz_must(dg_plan_find_model(plan, plan->models[i].device->name) == plan->models[i].device);
    }
    for (size_t i = 0; i < plan->shaft_count; i++) {
        const struct dg_plan_shaft *shaft = &plan->shafts[i];
        fuzz_must(dg_plan_name_fits(shaft->name) && shaft->driver < (int)i);
        fuzz_must(shaft->driver < 0 || (shaft->ratio[0] != 0 && shaft->ratio[1] != 0));
    }
    for (size_t i = 0; i < plan->wire_count; i++) {
        fuzz_must(dg_plan_name_fits(plan->wires[i].name) && plan->wires[i].kind != NULL);
        fuzz_must(dg_plan_find_wire(plan, plan->wires[i].name) == (int)i);
        check_settings(&plan->wires[i].settings);
    }
    for (size_t i = 0; i < plan->encoder_count; i++) {
        const struct dg_plan_encoder *encoder = &plan->encoders[i];
        fuzz_must(dg_plan_name_fits(encoder->name) && encoder->model != NULL);
        fuzz_must(encoder->shaft < plan->shaft_count && encoder->wire < plan->wire_count);
        check_settings(&encoder->settings);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static const struct dg_plan empty;
    const char *file = memory_file_write(bytes, n);
    struct lx_error error = {.right = ""};
    struct dg_plan plan;

    if (lx_plan_read(&plan, file, &error) == 0) {
        check_plan(&plan);
        lx_plan_free(&plan);
    } else {
        fuzz_must(strncmp(lx_error_line(&error).text, file, strlen(file)) == 0 &&
                  printable(lx_error_line(&error).text));
    }
    fuzz_must(memcmp(&plan, &empty, sizeof plan) == 0);
    return 0;
}
