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

bool encoder_make_room(struct fmu_encoder *self, size_t count, bool comes)
{
    self->room = count * FMU_WIRE_MAX;
    self->out = calloc(1, self->room);
    self->in = comes ? calloc(1, self->room) : NULL;
    return self->out != NULL && (!comes || self->in != NULL);
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

/* Behind "drehgeber VERSION ". @return whether it is one encoder, with its settings */
static bool take_encoder(struct fmu *self, const char *at, const struct fmu_files *files)
{
    at = *at != '=' ? NULL : encoder_take_model(self->encoders, at + 1, files);
    if (at == NULL || self->ops->make(self) != 0) {
        return false;
    }
    at = take_token_settings(self->encoders, at);
    return at != NULL && *at == '\0';
}

/* Encoders are as they were delivered. */
static void rewind_courses(struct fmu *self)
{
    self->start = 0;
    self->now = 0;
    self->started = false;
    for (size_t i = 0; i < self->count; i++) {
        self->encoders[i].now = (struct fmu_course){.power = true, .frame = {.good = 0}};
        self->encoders[i].unread = false;
    }
    for (size_t i = 0; i < self->shaft_count; i++) {
        self->shafts[i].now = (struct fmu_turn){.angle = 0};
    }
}

static const char *skip_head(const char *token)
{
    static const char head[] = "drehgeber " DG_VERSION " ";
    return strncmp(token, head, strlen(head)) == 0 ? token + strlen(head) : NULL;
}

static bool build_token(struct fmu *self, const struct fmu_files *files)
{
    const char *at = skip_head(self->token);
    rewind_courses(self);
    return self->rig != NULL ? self->ops->make(self) == 0 : take_encoder(self, at, files);
}

/* Its parts, which a rig has of its file. */
static bool make_one(struct fmu *self)
{
    self->ops = &fmu_alone_ops;
    self->encoders = calloc(1, sizeof *self->encoders);
    self->shafts = calloc(1, sizeof *self->shafts);
    if (self->encoders == NULL || self->shafts == NULL) {
        return false;
    }
    self->count = self->shaft_count = 1;
    self->encoders->all = self;
    self->encoders->leads = true;
    self->shafts->input = true;
    (void)snprintf(self->shafts->prefix, sizeof self->shafts->prefix, "shaft.");
    return encoder_make_room(self->encoders, 1, false);
}

static bool make_parts(struct fmu *self, const struct fmu_files *files)
{
    const char *at = skip_head(self->token);
    if (at == NULL) {
        return false;
    }
    return *at == '=' ? make_one(self) : fmu_rig_read(self, at, files);
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
    if (self->token != NULL) {
        memcpy(self->token, token, n + 1);
    }
    if (self->token == NULL || !make_parts(self, files) || !build_token(self, files)) {
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
    if (self->ops != NULL) {
        self->ops->free(self);
    }
    for (size_t i = 0; i < self->count; i++) {
        free(self->encoders[i].made);
        free(self->encoders[i].out);
        free(self->encoders[i].in);
    }
    free(self->encoders);
    free(self->shafts);
    free(self->token);
    free(self);
}

int fmu_reset(struct fmu *self)
{
    return build_token(self, NULL) ? 0 : -1;
}
