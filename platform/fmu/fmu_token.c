/* SPDX-License-Identifier: MIT */
/*
 * Making encoders of a token, see fmu.h.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/version.h"
#include "encoder.h"

static int hex(char c)
{
    const char *digits = "0123456789ABCDEF";
    const char *at = c == '\0' ? NULL : strchr(digits, c);
    return at == NULL ? -1 : (int)(at - digits);
}

const char *encoder_word(const char *from, const char *ends, char *to, size_t size)
{
    size_t n = 0;
    while (*from != '\0' && strchr(ends, *from) == NULL) {
        char c = *from++;
        if (c == '%') {
            const int high = hex(from[0]);
            const int low = high < 0 ? -1 : hex(from[1]);
            if (low < 0) {
                return NULL;
            }
            c = (char)(16 * high + low);
            from += 2;
        }
        if (n + 1 >= size) {
            return NULL;
        }
        to[n++] = c;
    }
    to[n] = '\0';
    return from;
}

bool fmu_can_have(struct dg_host *host)
{
    return encoder_has(host) != 0;
}

unsigned encoder_has(struct dg_host *host)
{
    const int medium = dg_host_medium(host);
    struct dg_host_frame frame;
    int32_t uv[4];
    if (medium < DG_HOST_MEDIUM_CHARACTERS || medium > DG_HOST_MEDIUM_WORDS) {
        return 0;
    }
    if (medium == DG_HOST_MEDIUM_FRAMES && dg_host_bit_rate(host) == DG_HOST_ERR_WIRE) {
        return 0; /* FMI-LS-BUS begins with it */
    }
    const bool sincos = dg_host_sincos(host, 0, uv) != DG_HOST_ERR_WIRE;
    const bool master = dg_host_frame(host, 0, &frame) != DG_HOST_ERR_WIRE;
    return 1u << medium | (sincos ? FMU_HAS_SINCOS : 0u) | (master ? FMU_HAS_MASTER : 0u);
}

/* Not every C library has aligned_alloc(). */
void *encoder_aligned(void *memory)
{
    const uintptr_t past = (uintptr_t)memory % DG_HOST_ALIGN;
    return (char *)memory + (past == 0 ? 0 : DG_HOST_ALIGN - past);
}

/* @return NULL: `model` is none, or no memory */
static struct dg_host *make_built_in(struct fmu_encoder *self)
{
    const size_t size = dg_host_size_of(self->model);
    self->memory = size == 0 ? NULL : calloc(1, size + DG_HOST_ALIGN);
    return self->memory == NULL ? NULL
                                : dg_host_make(encoder_aligned(self->memory), size, self->model);
}

static struct dg_host *make_of_device(struct fmu_encoder *self)
{
    const struct dg_host_wire *wire = dg_host_wire_of(self->device);
    const size_t size = dg_host_size(self->device, wire);
    self->memory = calloc(1, size + DG_HOST_ALIGN);
    if (self->memory == NULL) {
        return NULL;
    }
    struct dg_host *host = dg_host_init(encoder_aligned(self->memory), size, self->device, wire);
    if (host != NULL) {
        dg_host_take_side(host, dg_bus_side_of(self->device));
    }
    return host;
}

static int encoder_make(struct fmu_encoder *self)
{
    free(self->memory);
    free(self->panel_memory);
    self->panel_memory = NULL;
    self->panel = NULL;
    self->host = self->device == NULL ? make_built_in(self) : make_of_device(self);
    if (self->host == NULL) {
        return -1;
    }
    self->has = encoder_has(self->host);
    self->now = (struct fmu_course){.power = true, .frame = {.good = 0}};
    return self->has != 0 ? 0 : -1;
}

static const char *take_token_settings(struct fmu_encoder *self, const char *at)
{
    while (at != NULL && *at == ',') {
        char key[FMU_NAME_MAX];
        char value[FMU_NAME_MAX];
        at = encoder_word(at + 1, "=", key, sizeof key);
        at = at == NULL || *at != '=' ? NULL : encoder_word(at + 1, ", ", value, sizeof value);
        if (at != NULL && dg_host_set(self->host, key, value) != DG_HOST_OK) {
            return NULL;
        }
    }
    return at;
}

/* " NAME=MODEL@OTHER,KEY=VALUE" */
static const char *take_encoder(struct fmu_encoder *self, const char *at, size_t index,
                                const struct fmu_files *files)
{
    char name[FMU_NAME_MAX / 2];
    at = encoder_word(at + 1, "=", name, sizeof name);
    at = at == NULL || *at != '=' ? NULL : encoder_take_model(self, at + 1, files);
    if (at == NULL || encoder_make(self) != 0) {
        return NULL;
    }
    (void)snprintf(self->prefix, sizeof self->prefix, "%s%s", name, *name == '\0' ? "" : ".");
    self->owner = -1;
    if (*at == '@') {
        char *end = NULL;
        const unsigned long owner = strtoul(at + 1, &end, 10);
        if (owner >= index) {
            return NULL;
        }
        self->owner = (int)owner;
        at = end;
    }
    return take_token_settings(self, at);
}

static int build_token(struct fmu *self, const struct fmu_files *files)
{
    static const char head[] = "drehgeber " DG_VERSION;
    const char *at = self->token + strlen(head);
    if (strncmp(self->token, head, strlen(head)) != 0) {
        return -1;
    }
    for (size_t i = 0; i < self->count; i++) {
        at = *at == ' ' ? take_encoder(&self->encoders[i], at, i, files) : NULL;
        if (at == NULL) {
            return -1;
        }
    }
    for (size_t i = 0; i < self->count; i++) {
        const int owner = self->encoders[i].owner;
        if (owner >= 0 &&
            dg_host_share(self->encoders[i].host, self->encoders[owner].host) != DG_HOST_OK) {
            return -1;
        }
    }
    self->start = 0;
    self->now = 0;
    self->started = false;
    return *at == '\0' ? 0 : -1;
}

static size_t encoders_in(const char *token)
{
    size_t n = 0;
    for (; *token != '\0'; token++) {
        n += *token == ' ' ? 1 : 0;
    }
    return n - (n > 0 ? 1 : 0); /* behind "drehgeber" stands the version */
}

struct fmu *fmu_make(const char *token)
{
    return fmu_make_with(token, NULL);
}

struct fmu *fmu_make_with(const char *token, const struct fmu_files *files)
{
    struct fmu *self = calloc(1, sizeof *self);
    const size_t n = token == NULL ? 0 : strlen(token);
    if (self == NULL || n == 0) {
        free(self);
        return NULL;
    }
    self->token = malloc(n + 1);
    self->count = encoders_in(token);
    self->encoders = calloc(self->count + 1, sizeof *self->encoders);
    if (self->token != NULL) {
        memcpy(self->token, token, n + 1);
    }
    if (self->token == NULL || self->encoders == NULL || self->count == 0 ||
        build_token(self, files) != 0) {
        fmu_free(self);
        return NULL;
    }
    return self;
}

void fmu_free(struct fmu *self)
{
    if (self == NULL) {
        return;
    }
    for (size_t i = 0; self->encoders != NULL && i < self->count; i++) {
        free(self->encoders[i].memory);
        free(self->encoders[i].panel_memory);
        free(self->encoders[i].made);
    }
    free(self->encoders);
    free(self->token);
    free(self);
}

int fmu_reset(struct fmu *self)
{
    return build_token(self, NULL);
}
