/* SPDX-License-Identifier: MIT */
#include "fmi.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int fmi_failed(const struct fmi *self, const char *what, int result)
{
    char text[128];
    if (self == NULL) {
        return FMI_ERROR;
    }
    (void)snprintf(text, sizeof text, "%s: %s", what, dg_host_result_text(result));
    self->tell(self, text);
    return FMI_ERROR;
}

int fmi_refused(const struct fmi *self, const char *what)
{
    return fmi_failed(self, what, DG_HOST_ERR_ARGUMENT);
}

/* What a result of host.h is to an importer. */
static int status_of(const struct fmi *self, const char *what, int result)
{
    return result == DG_HOST_OK ? FMI_OK : fmi_failed(self, what, result);
}

/* --- life --- */

/* Two hexadecimal digits. @return -1: they are none */
static int hex_byte_of(const char *text)
{
    char digits[3] = "";
    char *end;
    (void)snprintf(digits, sizeof digits, "%.2s", text);
    const unsigned long code = strtoul(digits, &end, 16);
    return isxdigit((unsigned char)digits[0]) != 0 && end == digits + 2 ? (int)code : -1;
}

/* The path in a URI of FMI 2; a text that is none is a path already. */
static const char *skip_scheme(const char *resources, bool *uri)
{
    static const char scheme[] = "file:";
    *uri = strncmp(resources, scheme, strlen(scheme)) == 0;
    if (!*uri) {
        return resources;
    }
    const char *at = resources + strlen(scheme);
    if (strncmp(at, "//", 2) == 0) {
        at += 2 + strcspn(at + 2, "/"); /* a host, which is this one */
    }
    const bool drive = at[0] == '/' && at[1] != '\0' && at[2] == ':';
    return drive ? at + 1 : at;
}

/* Where an importer says that resources are: FMI 2 says a URI. @return 0, or -1: it is too long */
static int path_of(const char *resources, const char *name, char *to, size_t size)
{
    bool uri;
    const char *at = skip_scheme(resources, &uri);
    size_t n = 0;
    while (*at != '\0' && n + 1 < size) {
        const int code = uri && *at == '%' ? hex_byte_of(at + 1) : -1;
        const unsigned char byte = (unsigned char)(code > 0 ? code : 0);
        memcpy(&to[n++], code > 0 ? (const char *)&byte : at, 1);
        at += code > 0 ? 3 : 1;
    }
    const int rest = snprintf(to + n, size - n, "/%s", name);
    return *at == '\0' && rest >= 0 && (size_t)rest < size - n ? 0 : -1;
}

static char *read_stream(FILE *file, size_t *n)
{
    size_t room = 65536;
    char *bytes = malloc(room);
    *n = 0;
    while (bytes != NULL) {
        *n += fread(bytes + *n, 1, room - *n, file);
        if (*n < room) {
            break;
        }
        room *= 2;
        char *more = realloc(bytes, room);
        if (more == NULL) {
            free(bytes);
        }
        bytes = more;
    }
    return bytes;
}

static char *read_resource(void *ctx, const char *name, size_t *n)
{
    char path[4096];
    FILE *file =
        ctx == NULL || path_of(ctx, name, path, sizeof path) != 0 ? NULL : fopen(path, "rb");
    char *bytes = file == NULL ? NULL : read_stream(file, n);
    if (file != NULL) {
        (void)fclose(file);
    }
    return bytes;
}

void *fmi_begin(struct fmi *self, const char *token, const char *resources)
{
    char folder[4096] = "";
    (void)snprintf(folder, sizeof folder, "%s", resources == NULL ? "" : resources);
    const struct fmu_files files = {.read = read_resource,
                                    .ctx = folder[0] == '\0' ? NULL : folder};
    self->fmu = fmu_make_with(token, &files);
    if (self->fmu == NULL) {
        (void)fmi_failed(self, "the token (guid) of the model description is another build's",
                         DG_HOST_ERR_OTHER);
        free(self);
        return NULL;
    }
    return self;
}

void fmi_end(struct fmi *self)
{
    if (self != NULL) {
        fmu_free(self->fmu);
        free(self->texts);
        free(self);
    }
}

static int power_on_encoders(struct fmi *self)
{
    return status_of(self, "power-on", fmu_start(self->fmu, self->start));
}

int fmi_initialize(struct fmi *self)
{
    if (self == NULL || self->initializing || fmu_started(self->fmu)) {
        return fmi_failed(self, "EnterInitializationMode", DG_HOST_ERR_STATE);
    }
    self->initializing = true;
    return FMI_OK;
}

int fmi_initialized(struct fmi *self)
{
    if (self == NULL || !self->initializing) {
        return fmi_failed(self, "ExitInitializationMode", DG_HOST_ERR_STATE);
    }
    self->initializing = false;
    return power_on_encoders(self);
}

int fmi_terminate(struct fmi *self)
{
    if (self == NULL) {
        return FMI_ERROR;
    }
    self->terminated = true;
    return FMI_OK;
}

int fmi_may_step(struct fmi *self, double now, double span)
{
    if (self == NULL || self->terminated || !fmu_started(self->fmu)) {
        return fmi_failed(self, "DoStep", DG_HOST_ERR_STATE);
    }
    if (!fmu_may_step(self->fmu, now, span)) {
        char text[96];
        (void)snprintf(text, sizeof text, "DoStep from %.9g s for %.9g s, the FMU is at %.9g s",
                       now, span, fmu_time(self->fmu));
        return fmi_refused(self, text);
    }
    return FMI_OK;
}

int fmi_reset(struct fmi *self)
{
    if (self == NULL) {
        return FMI_ERROR;
    }
    self->initializing = self->terminated = false;
    return fmu_reset(self->fmu) == 0 ? FMI_OK : FMI_ERROR;
}

/* --- values --- */

int fmi_get(struct fmi *self, uint32_t reference, struct fmu_value *to)
{
    if (self == NULL || (self->initializing && power_on_encoders(self) != FMI_OK)) {
        return FMI_ERROR;
    }
    return status_of(self, "get", fmu_get(self->fmu, reference, to));
}

static int set_variable(struct fmi *self, uint32_t reference, const struct fmu_value *value)
{
    if (self == NULL) {
        return FMI_ERROR;
    }
    return status_of(self, "set", fmu_set(self->fmu, reference, value));
}

int fmi_set_integer(struct fmi *self, uint32_t reference, enum fmu_type type, int64_t value)
{
    const struct fmu_value of = {.type = type, .real = (double)value, .integer = value};
    return set_variable(self, reference, &of);
}

int fmi_get_reals(struct fmi *self, const uint32_t references[], size_t n, double values[],
                  size_t room)
{
    struct fmu_value value;
    if (room < n) {
        return fmi_refused(self, "room for values");
    }
    for (size_t i = 0; i < n; i++) {
        if (fmi_get(self, references[i], &value) != FMI_OK) {
            return FMI_ERROR;
        }
        values[i] = value.real;
    }
    return FMI_OK;
}

int fmi_set_reals(struct fmi *self, const uint32_t references[], size_t n, const double values[],
                  size_t room)
{
    if (room < n) {
        return fmi_refused(self, "fewer values than variables");
    }
    for (size_t i = 0; i < n; i++) {
        const struct fmu_value value = {.type = FMU_REAL, .real = values[i]};
        if (set_variable(self, references[i], &value) != FMI_OK) {
            return FMI_ERROR;
        }
    }
    return FMI_OK;
}

int fmi_get_texts(struct fmi *self, const uint32_t references[], size_t n, const char *values[],
                  size_t room)
{
    struct fmu_value value;
    if (self == NULL) {
        return FMI_ERROR;
    }
    char(*texts)[FMU_NAME_MAX] = n == 0 ? NULL : calloc(n, sizeof *texts);
    free(self->texts);
    self->texts = texts;
    if (room < n || (n > 0 && texts == NULL)) {
        return fmi_failed(self, "Strings", DG_HOST_ERR_SPACE);
    }
    for (size_t i = 0; i < n; i++) {
        if (fmi_get(self, references[i], &value) != FMI_OK) {
            return FMI_ERROR;
        }
        memcpy(texts[i], value.text, sizeof texts[i]);
        values[i] = texts[i];
    }
    return FMI_OK;
}

int fmi_set_texts(struct fmi *self, const uint32_t references[], size_t n,
                  const char *const values[], size_t room)
{
    for (size_t i = 0; i < n; i++) {
        struct fmu_value value = {.type = FMU_TEXT};
        if (i >= room || values[i] == NULL || strlen(values[i]) >= sizeof value.text) {
            return fmi_refused(self, "a String");
        }
        memcpy(value.text, values[i], strlen(values[i]) + 1);
        if (set_variable(self, references[i], &value) != FMI_OK) {
            return FMI_ERROR;
        }
    }
    return FMI_OK;
}

/* --- states --- */

struct state {
    size_t n;
    uint8_t bytes[];
};

int fmi_state_get(struct fmi *self, void **to)
{
    if (self == NULL) {
        return FMI_ERROR;
    }
    const size_t n = fmu_state_size(self->fmu);
    struct state *old = *to;
    struct state *state = old != NULL && old->n >= n ? old : realloc(old, sizeof *state + n);
    if (state == NULL) {
        return FMI_ERROR;
    }
    state->n = n;
    *to = state;
    return status_of(self, "a state", fmu_save(self->fmu, state->bytes, n));
}

int fmi_state_set(struct fmi *self, const void *from)
{
    const struct state *state = from;
    if (self == NULL || state == NULL) {
        return fmi_refused(self, "a state");
    }
    self->terminated = false;
    return status_of(self, "a state", fmu_restore(self->fmu, state->bytes, state->n));
}

int fmi_state_free(void **state)
{
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return FMI_OK;
}

int fmi_state_size(struct fmi *self, const void *state, size_t *n)
{
    if (state == NULL) {
        return fmi_refused(self, "a state");
    }
    *n = ((const struct state *)state)->n;
    return FMI_OK;
}

int fmi_state_pack(struct fmi *self, const void *state, uint8_t bytes[], size_t n)
{
    const struct state *of = state;
    if (of == NULL || n < of->n) {
        return fmi_failed(self, "a state", DG_HOST_ERR_SPACE);
    }
    memcpy(bytes, of->bytes, of->n);
    return FMI_OK;
}

int fmi_state_unpack(const uint8_t bytes[], size_t n, void **to)
{
    struct state *state = malloc(sizeof *state + n);
    if (state == NULL) {
        return FMI_ERROR;
    }
    free(*to);
    state->n = n;
    memcpy(state->bytes, bytes, n);
    *to = state;
    return FMI_OK;
}
