/* SPDX-License-Identifier: MIT */
/*
 * Which encoder one of a token is: built in; a text, which is its base with other figures; or made
 * of a file that the FMU has. See fmu.h.
 */
#include <stdlib.h>
#include <string.h>

#include "drehgeber/crc.h"
#include "drehgeber/devices.h"
#include "drehgeber/model.h"
#include "encoder.h"

#define ALIGN _Alignof(max_align_t)
/* Of the memory of a text, in front of its figures. */
#define OWN ((sizeof(struct dg_device) + ALIGN - 1u) / ALIGN * ALIGN)
/* Memory for what is made of a file: to begin with, and where it ends. */
#define ROOM_MIN ((size_t)65536)
#define ROOM_MAX ((size_t)1 << 28)
/* Digits of the check sum that a file is called by. */
#define SUM_DIGITS 8u

/* --- a text --- */

/* "-registers" takes out what the base has besides its frame, "st=26" is a figure. */
static const char *take_model_figure(const struct dg_model_text *text, void *model, const char *at)
{
    char key[FMU_NAME_MAX];
    char value[FMU_NAME_MAX] = "";
    at = encoder_word(at, "=;@, ", key, sizeof key);
    if (at == NULL) {
        return NULL;
    }
    if (key[0] == '-') {
        for (size_t i = 0; text->heirlooms != NULL && text->heirlooms[i] != NULL; i++) {
            if (strcmp(text->heirlooms[i], key + 1) == 0) {
                text->drop(model, i);
                return at;
            }
        }
        return NULL;
    }
    const struct dg_key *figure = dg_model_figure(text, key);
    at = *at != '=' ? NULL : encoder_word(at + 1, ";@, ", value, sizeof value);
    return figure != NULL && at != NULL && dg_key_set(figure, model, value) == DG_OK ? at : NULL;
}

/* A copy of the base, which `self` owns. @return its figures, or NULL */
static void *copy_base_model(struct fmu_encoder *self, const struct dg_device *base,
                             const struct dg_model_text *text)
{
    self->made = calloc(1, OWN + text->size);
    if (self->made == NULL) {
        return NULL;
    }
    void *model = (char *)self->made + OWN;
    if (text->copy != NULL) {
        text->copy(model, base->model);
    } else {
        memcpy(model, base->model, text->own_size);
    }
    return model;
}

/* ":BASE;KEY=VALUE..." */
static const char *take_text(struct fmu_encoder *self, const char *at)
{
    char name[FMU_NAME_MAX];
    at = encoder_word(at + 1, ";@, ", name, sizeof name);
    const struct dg_device *base = at == NULL ? NULL : dg_device_find(name);
    const struct dg_model_text *text = base == NULL ? NULL : dg_model_text_of(base->stack);
    void *model = text == NULL ? NULL : copy_base_model(self, base, text);
    if (model == NULL) {
        return NULL;
    }
    while (at != NULL && *at == ';') {
        at = take_model_figure(text, model, at + 1);
    }
    if (at == NULL || text->settle(model) != NULL) {
        return NULL;
    }
    struct dg_device *device = self->made;
    *device = *base;
    device->name = self->model;
    device->model = model;
    self->device = device;
    return at;
}

/* --- a file --- */

static bool is_sum_of(const char *name, const char *text, size_t n)
{
    static const char digits[] = "0123456789ABCDEF";
    const uint32_t sum = dg_crc32(0, (const uint8_t *)text, n);
    for (size_t i = 0; i < SUM_DIGITS; i++) {
        if (name[i] != digits[sum >> (28u - 4u * i) & 0xFu]) {
            return false;
        }
    }
    return name[SUM_DIGITS] == '.';
}

/* In as much memory as it takes. */
static void make_of(struct fmu_encoder *self, const struct dg_model_file *kind, const char *text,
                    size_t n)
{
    struct dg_model_flaw flaw;
    struct dg_model_made made = {.device = NULL};
    int result = DG_ERR_SPACE;
    for (size_t room = ROOM_MIN; result == DG_ERR_SPACE && room <= ROOM_MAX; room *= 2u) {
        free(self->made);
        self->made = calloc(1, room);
        const struct dg_model_source from = {text, n, self->made, room};
        result = self->made == NULL ? DG_ERR_ARGUMENT : kind->read(&from, &made, &flaw);
    }
    self->device = result == DG_OK ? made.device : NULL;
}

/* Its name is its check sum, so that a token has one text only. */
char *fmu_read_file(const struct fmu_files *files, const char *name, size_t *n)
{
    char *text = files == NULL ? NULL : files->read(files->ctx, name, n);
    if (text != NULL && !is_sum_of(name, text, *n)) {
        free(text);
        return NULL;
    }
    return text;
}

static void take_model_file(struct fmu_encoder *self, const struct fmu_files *files)
{
    const struct dg_model_file *kind = dg_model_file_of(self->model);
    size_t n = 0;
    char *text = kind == NULL ? NULL : fmu_read_file(files, self->model, &n);
    if (text != NULL) {
        make_of(self, kind, text, n);
    }
    free(text);
}

/* --- both, and what is built in --- */

const char *encoder_take_model(struct fmu_encoder *self, const char *at,
                               const struct fmu_files *files)
{
    at = encoder_word(at, ":@, ", self->model, sizeof self->model);
    if (at == NULL) {
        return NULL;
    }
    if (self->device != NULL) { /* made before: it stays */
        return at + strcspn(at, "@, ");
    }
    if (*at == ':') {
        return take_text(self, at);
    }
    if (dg_model_file_of(self->model) == NULL) { /* whoever makes it knows whether it is one */
        return at;
    }
    take_model_file(self, files);
    return self->device == NULL ? NULL : at;
}
