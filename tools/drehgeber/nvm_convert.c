/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "nvm_convert.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "drehgeber/cia406.h"
#include "figures.h"
#include "file.h"
#include "nvm_memory.h"

/* Longer than any image. */
#define IMAGE_MAX 65536u
/* How much of a list is told. */
#define OBJECTS_TOLD 8u

/* What does not fit, in words. */
struct misfits {
    const char *path;
    const struct lx_say *say; /* a note for each; NULL: they are collected */
    struct lx_words words;
    unsigned count;
};

/* A kind of models that are files. */
struct nvm_kind {
    bool (*has)(const struct dg_device *model);
    /* What of an image, which is a copy, is not the model's. @return false: the encoder's own
       reader has something to say of it, or nothing */
    bool (*differs)(const struct dg_device *model, struct dg_nvm image, struct misfits *to);
    /* Into memory that is as delivered. @return false: nothing fits */
    bool (*convert)(const struct dg_device *model, struct dg_nvm from, struct dg_nvm to,
                    struct misfits *misfits);
    const char *whose;  /* an image that differs */
    const char *needed; /* what can be converted */
};

/* What a port of a model's kind is mounted by. */
static struct dg_stack_setup setup_of(const struct dg_device *model, struct dg_nvm nvm)
{
    return (struct dg_stack_setup){.model = model->model, .nvm = nvm};
}

/* ---------------------------------------------------------------- EDS files */

static const char *const reasons[] = {
    [DG_CO_FOREIGN] = "differs",
    [DG_CO_GONE] = "is no value of the file",
    [DG_CO_NEW] = "is not in the image",
    [DG_CO_RETYPED] = "has another type",
    [DG_CO_OUTSIDE] = "is outside of its limits",
};
_Static_assert(DG_COUNT(reasons) == DG_CO_MISFIT_COUNT, "a reason for each");

static void tell_object(void *ctx, uint32_t key, enum dg_co_misfit why)
{
    struct misfits *self = ctx;
    char object[16];
    const unsigned sub = key >> 8 & 0xFFu;
    (void)snprintf(object, sizeof object, sub == 0 ? "%04Xh" : "%04Xh:%u", key >> 16, sub);
    self->count++;
    if (self->say != NULL) {
        lx_note(self->say, "%s: %s %s: as delivered", self->path, object, reasons[why]);
    } else if (self->count <= OBJECTS_TOLD) {
        lx_words_add(&self->words, "%s%s %s", self->count == 1 ? "" : ", ", object, reasons[why]);
    }
}

/* The file that the model comes from; NULL: it is built in. */
static const struct dg_co_file *file_of(const struct dg_device *model)
{
    const struct dg_cia406_model *figures = dg_cia406_model_of(model);
    return figures == NULL || !figures->device->whole
               ? NULL
               : (const struct dg_co_file *)(const void *)figures->device;
}

static bool eds_has(const struct dg_device *model)
{
    return file_of(model) != NULL;
}

static bool eds_differs(const struct dg_device *model, struct dg_nvm image, struct misfits *to)
{
    const struct dg_stack_setup setup = setup_of(model, image);
    struct dg_store store;
    const bool differs =
        model->stack->mount(&setup, &store) == DG_ERR_FOREIGN &&
        dg_co_convert(file_of(model), image, (struct dg_nvm){NULL, NULL}, tell_object, to) == DG_OK;
    if (to->count == 0) {
        lx_words_add(&to->words, "other limits");
    } else if (to->count > OBJECTS_TOLD) {
        lx_words_add(&to->words, " and %u more", to->count - OBJECTS_TOLD);
    }
    return differs;
}

static bool eds_convert(const struct dg_device *model, struct dg_nvm from, struct dg_nvm to,
                        struct misfits *misfits)
{
    const struct dg_co_file *file = file_of(model);
    return dg_co_format(&file->device, to, 0) == DG_OK &&
           dg_co_convert(file, from, to, tell_object, misfits) == DG_OK;
}

/* ---------------------------------------------------------------- texts */

static const struct dg_model_stamp *stamp_of(const struct dg_device *model)
{
    return dg_model_stamp_of(dg_model_text_of(model->stack), model->model);
}

static bool text_has(const struct dg_device *model)
{
    return stamp_of(model) != NULL;
}

static bool text_differs(const struct dg_device *model, struct dg_nvm image, struct misfits *to)
{
    return lx_figures_differ(stamp_of(model), image, &to->words);
}

static void tell_region(void *ctx, const char *what)
{
    const struct misfits *self = ctx;
    lx_note(self->say, "%s: %s: as delivered", self->path, what);
}

static bool text_convert(const struct dg_device *model, struct dg_nvm from, struct dg_nvm to,
                         struct misfits *misfits)
{
    const struct dg_stack_setup setup = setup_of(model, to);
    return model->stack->format(&setup) == DG_OK &&
           dg_model_stamp_convert(stamp_of(model), from, to, tell_region, misfits) == DG_OK;
}

/* ---------------------------------------------------------------- kinds */

static const struct nvm_kind kinds[] = {
    {
        .has = eds_has,
        .differs = eds_differs,
        .convert = eds_convert,
        .whose = "another EDS file",
        .needed = "expected an image in which the encoder of an EDS file has saved",
    },
    {
        .has = text_has,
        .differs = text_differs,
        .convert = text_convert,
        .whose = "other figures",
        .needed = "expected an image of an encoder of the same protocol",
    },
};

/* NULL: it is built in, or has no EEPROM. */
static const struct nvm_kind *nvm_kind_of(const struct dg_device *model)
{
    for (size_t i = 0; i < DG_COUNT(kinds); i++) {
        if (kinds[i].has(model)) {
            return &kinds[i];
        }
    }
    return NULL;
}

/* A copy of an image. @return 0; 1: there is none; -1 with `error` */
static int read_image(struct lx_nvm_memory *self, const char *path, struct lx_error *error)
{
    if (access(path, F_OK) != 0 && errno == ENOENT) {
        return 1;
    }
    FILE *stream = lx_file_read(NULL, path, error);
    if (stream == NULL) {
        return -1;
    }
    const int made = lx_nvm_memory_init(self, IMAGE_MAX);
    const size_t n = made == 0 ? fread(self->bytes, 1, IMAGE_MAX, stream) : 0;
    const bool failed = made != 0 || ferror(stream) != 0;
    (void)fclose(stream);
    if (failed) {
        lx_nvm_memory_free(self);
        return lx_fail(error, "%s: cannot read", path);
    }
    return n == 0 ? 1 : 0;
}

/* ---------------------------------------------------------------- another one's */

static int check_image(const struct nvm_kind *kind, const struct dg_plan_encoder *encoder,
                       struct lx_error *error)
{
    struct misfits misfits = {.path = encoder->nvm};
    struct lx_nvm_memory image = {.bytes = NULL};
    int result = read_image(&image, encoder->nvm, error);
    if (result == 0 && kind->differs(encoder->model, lx_nvm_memory_port(&image), &misfits)) {
        result = lx_refuse(error, "--nvm-convert NEW makes one of what fits", "%s: of %s: %s",
                           encoder->nvm, kind->whose, misfits.words.text);
    }
    lx_nvm_memory_free(&image);
    return result < 0 ? -1 : 0;
}

int nvm_check(const struct dg_plan *plan, struct lx_error *error)
{
    int result = 0;
    for (size_t i = 0; result == 0 && i < plan->encoder_count; i++) {
        const struct dg_plan_encoder *encoder = &plan->encoders[i];
        const struct nvm_kind *kind = encoder->nvm == NULL ? NULL : nvm_kind_of(encoder->model);
        result = kind == NULL ? 0 : check_image(kind, encoder, error);
    }
    return result;
}

/* ---------------------------------------------------------------- converting */

/* Never over something. */
static int write_image(const struct lx_nvm_memory *self, const char *path, struct lx_error *error)
{
    FILE *stream = fopen(path, "wxe");
    if (stream == NULL) {
        return lx_refuse(error, "expected the name of a new file", "%s: %s", path, strerror(errno));
    }
    const bool whole = fwrite(self->bytes, 1, self->size, stream) == self->size;
    if (fclose(stream) != 0 || !whole) {
        (void)lx_fail(error, "%s: cannot write: %s", path, strerror(errno));
        (void)unlink(path);
        return -1;
    }
    return 0;
}

/* @return 0, or -1 with `error` */
static int convert_image(const struct dg_plan_encoder *encoder, struct lx_nvm_memory *from,
                         struct lx_nvm_memory *to, struct misfits *misfits, struct lx_error *error)
{
    const struct dg_device *model = encoder->model;
    const struct nvm_kind *kind = nvm_kind_of(model);
    if (lx_nvm_memory_init(to, dg_store_size(model->stack->layout(model->model))) != 0) {
        return lx_fail(error, "no memory for an EEPROM");
    }
    return kind->convert(model, lx_nvm_memory_port(from), lx_nvm_memory_port(to), misfits)
               ? 0
               : lx_refuse(error, kind->needed, "%s: nothing that could be converted",
                           encoder->nvm);
}

/* The one encoder, of a file and with an EEPROM file. */
static bool is_convertible(const struct dg_plan *plan)
{
    return plan->encoder_count == 1 && plan->encoders[0].nvm != NULL &&
           nvm_kind_of(plan->encoders[0].model) != NULL;
}

int nvm_convert(struct dg_plan *plan, const char *path, const struct lx_say *say,
                struct lx_error *error)
{
    struct lx_nvm_memory from = {.bytes = NULL};
    struct lx_nvm_memory to = {.bytes = NULL};
    if (!is_convertible(plan)) {
        (void)lx_refuse(error, "expected 'run FILE --nvm OLD --nvm-convert NEW'", "%s", "");
        return lx_about(error, LX_ABOUT_KEY, "nvm-convert", path);
    }
    struct dg_plan_encoder *encoder = &plan->encoders[0];
    struct misfits misfits = {.path = encoder->nvm, .say = say};
    int result = read_image(&from, encoder->nvm, error);
    if (result == 1) {
        result = lx_fail(error, "%s: there is no image", encoder->nvm);
    }
    result = result == 0 ? convert_image(encoder, &from, &to, &misfits, error) : result;
    result = result == 0 ? write_image(&to, path, error) : result;
    lx_nvm_memory_free(&from);
    lx_nvm_memory_free(&to);
    encoder->nvm = result == 0 ? dg_plan_copy(plan, path) : encoder->nvm;
    return encoder->nvm == NULL ? lx_fail(error, "no memory for %s", path) : result;
}
