/* SPDX-License-Identifier: MIT */
/*
 * An encoder from its settings to its end.
 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/key.h"
#include "drehgeber/shaft.h"
#include "hdl_private.h"

#define AT(field) offsetof(struct hdl_settings, field)
#define DELAY_MAX_PS (100000 * HDL_PS_PER_NS)
#define POWER_ON_MAX_PS (1000000 * HDL_PS_PER_NS)
#define SEPARATORS " \t\n,;"

/* clang-format off */
static const struct dg_key rows[] = {
    /* name          unit  offset        type        places factor min                  max           words help */
    {"tco_ns",       "ns", AT(tco),       DG_KEY_U32, 3, 1,        1, 10000 * HDL_PS_PER_NS,          NULL, "from the encoder's edge to its output"},
    {"delay_in_ns",  "ns", AT(delay_in),  DG_KEY_U32, 3, 1,        0,          DELAY_MAX_PS,          NULL, "of the cable to the encoder"},
    {"delay_out_ns", "ns", AT(delay_out), DG_KEY_U32, 3, 1,        0,          DELAY_MAX_PS,          NULL, "of the cable from the encoder"},
    {"jitter_ns",    "ns", AT(jitter),    DG_KEY_U32, 3, 1,        0,  1000 * HDL_PS_PER_NS,          NULL, "up to as much more for each edge"},
    {"control",      "",   AT(control),    DG_KEY_TEXT, 0, 1,      0,       HDL_CONTROL_MAX,          NULL, "socket for SCPI: unix:PATH"},
    {"power_on_ns",  "ns", AT(power_on),  DG_KEY_U32, 3, 1,        1, POWER_ON_MAX_PS,                NULL, "from the first look to power"},
    {"seed",         "",   AT(seed),      DG_KEY_U32, 0, 1,        0,            UINT32_MAX,          NULL, "of jitter and chance"},
};
/* clang-format on */
static const struct dg_keys keys = {rows, DG_COUNT(rows)};
static const struct hdl_settings usual = {
    .tco = 10 * HDL_PS_PER_NS, .power_on = HDL_PS_PER_NS, .seed = 1};

int hdl_fail(struct dg_hdl *self, int result, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    (void)vsnprintf(self->error, sizeof self->error, format, arguments);
    va_end(arguments);
    return result;
}

const char *dg_hdl_error(const struct dg_hdl *self)
{
    return self->error;
}

/* --- settings --- */

/* What a key of the encoder takes, for whoever has given something else. */
static void describe_setting(const struct dg_host *host, const char *name, struct lx_words *to)
{
    struct dg_host_key key;
    size_t i = 0;

    while (dg_host_key(host, i, &key) == DG_HOST_OK && strcmp(key.name, name) != 0) {
        i++;
    }
    if (key.type == DG_HOST_KEY_WORD) {
        for (size_t word = 0; dg_host_word(host, name, word) != NULL; word++) {
            lx_words_add(to, "%s%s", word == 0 ? "" : " or ", dg_host_word(host, name, word));
        }
    } else {
        int64_t unit = 1;
        for (uint8_t place = 0; place < key.places; place++) {
            unit *= 10;
        }
        lx_words_add(to, "%lld..%lld%s", (long long)(key.min / unit), (long long)(key.max / unit),
                     key.type == DG_HOST_KEY_TEXT ? " characters" : "");
    }
}

static int set_hdl_setting(struct dg_hdl *self, struct dg_host *host, const char *name,
                           const char *value)
{
    const struct dg_key *own = dg_keys_find(&keys, name);
    const int result =
        own != NULL ? dg_key_set(own, &self->settings, value) : dg_host_set(host, name, value);

    if (result == DG_HOST_OK) {
        return result;
    }
    if (result == DG_HOST_ERR_NAME) {
        return hdl_fail(self, result, "%s has no setting '%s'", dg_host_model(host), name);
    }
    struct lx_words right = {""};
    if (own != NULL && own->type == DG_KEY_TEXT) {
        lx_words_add(&right, "unix:PATH of at most %d characters", (int)own->max);
    } else if (own != NULL) {
        const double unit = own->places == 0 ? 1.0 : 1000.0;
        lx_words_add(&right, "%.10g..%.10g", (double)own->min / unit, (double)own->max / unit);
    } else {
        describe_setting(host, name, &right);
    }
    return hdl_fail(self, result, "%s=%s: expected %s", name, value, right.text);
}

/* Words KEY=VALUE. */
static int set_all(struct dg_hdl *self, struct dg_host *host, const char *settings)
{
    int result = DG_HOST_OK;

    /* Not every model has them. */
    (void)dg_host_set(host, "init_ms", "0");
    (void)dg_host_set(host, "hint_us", "100");
    for (const char *word = settings; result == DG_HOST_OK;) {
        char text[256];
        word += strspn(word, SEPARATORS);
        const size_t n = strcspn(word, SEPARATORS);
        if (n == 0) {
            break;
        }
        (void)snprintf(text, sizeof text, "%.*s", (int)n, word);
        char *value = strchr(text, '=');
        if (value == NULL || n >= sizeof text) {
            return hdl_fail(self, DG_HOST_ERR_ARGUMENT, "'%s' is not KEY=VALUE", text);
        }
        *value++ = '\0';
        result = set_hdl_setting(self, host, text, value);
        word += n;
    }
    return result;
}

/* --- the encoder --- */

static void *allocate_aligned(size_t size)
{
    return aligned_alloc(DG_HOST_ALIGN,
                         (size + DG_HOST_ALIGN - 1u) / DG_HOST_ALIGN * DG_HOST_ALIGN);
}

static size_t size_of(const struct dg_hdl *self, const char *model)
{
    return self->device == NULL ? dg_host_size_of(model)
                                : dg_host_size(self->device, dg_host_wire_of(self->device));
}

static struct dg_host *make_in(struct dg_hdl *self, void *memory, size_t size, const char *model)
{
    if (self->device == NULL) {
        return dg_host_make(memory, size, model);
    }
    const struct dg_bus_side *side = dg_bus_side_of(self->device);
    struct dg_host *host = dg_host_init(memory, size, self->device, side->wire);
    if (host != NULL) {
        dg_host_take_side(host, side);
    }
    return host;
}

/* An encoder without power, with these settings. @return NULL with an error */
static struct dg_host *make_host(struct dg_hdl *self, const char *model, const char *settings)
{
    const size_t size = size_of(self, model);
    void *memory = size != 0 ? allocate_aligned(size) : NULL;
    struct dg_host *host = memory != NULL ? make_in(self, memory, size, model) : NULL;

    if (size == 0) {
        (void)hdl_fail(self, DG_HOST_ERR_NAME, "there is no model '%s'", model);
    } else if (host == NULL) {
        (void)hdl_fail(self, DG_HOST_ERR_SPACE, "no memory for an encoder");
    }
    if (host == NULL || set_all(self, host, settings) != DG_HOST_OK) {
        free(memory);
        return NULL;
    }
    return host;
}

static int choose_wire(struct dg_hdl *self)
{
    static const struct hdl_wire_ops *const wires[] = {
        [DG_HOST_MEDIUM_CHARACTERS] = &hdl_serial,
        [DG_HOST_MEDIUM_EDGES] = &hdl_clocked,
    };
    const int medium = dg_host_medium(self->host);
    struct dg_host_uart uart;
    const bool known = medium >= 0 && (size_t)medium < DG_COUNT(wires) && wires[medium] != NULL;

    /* A UART in hardware needs the data rate of its encoder. */
    if (!known ||
        (wires[medium] == &hdl_serial && dg_host_uart(self->host, &uart) == DG_HOST_ERR_WIRE)) {
        return hdl_fail(self, DG_HOST_ERR_WIRE, "%s speaks %s; expected BiSS, SSI or RS485",
                        dg_host_model(self->host), dg_host_protocol(self->host));
    }
    self->wire = wires[medium];
    return DG_HOST_OK;
}

/* A new file has what another encoder with these settings finds in its EEPROM. */
static int open_hdl_memory(struct dg_hdl *self, const char *settings, const char *path)
{
    const size_t size = dg_host_memory_size(self->host);
    struct lx_nvm_image image = {.size = (uint32_t)size, .answer = "nothing is stored"};
    struct lx_error error = {.what = ""};

    if (size == 0) {
        return hdl_fail(self, DG_HOST_ERR_WIRE, "%s has no EEPROM, and no use for %s",
                        dg_host_model(self->host), path);
    }
    struct dg_host *fresh = make_host(self, dg_host_model(self->host), settings);
    uint8_t *bytes = malloc(size);
    int result = fresh != NULL && bytes != NULL ? dg_host_power(fresh, 0, true) : DG_HOST_ERR_SPACE;
    if (result == DG_HOST_OK) {
        result = dg_host_memory_copy(fresh, bytes, size);
    }
    if (result == DG_HOST_OK) {
        image.bytes = bytes;
        result = lx_nvm_file_open(&self->memory, path, &image, &error);
        const struct dg_nvm port = lx_nvm_file_port(&self->memory);
        result = result == 0 ? dg_host_memory_port(self->host, &port) : DG_HOST_ERR_IO;
    }
    free(bytes);
    free(fresh);
    if (error.what[0] != '\0') {
        return hdl_fail(self, result, "%s", lx_error_reason(&error).text);
    }
    return result == DG_HOST_OK
               ? result
               : hdl_fail(self, result, "%s: %s", path, dg_host_result_text(result));
}

static void heard(void *ctx, const struct dg_host_event *event)
{
    struct dg_hdl *self = ctx;

    self->wire->heard(self, event);
}

static int make_panel(struct dg_hdl *self)
{
    void *memory = allocate_aligned(dg_host_panel_size());

    self->panel =
        memory != NULL ? dg_host_panel_make(memory, dg_host_panel_size(), self->host) : NULL;
    if (self->panel == NULL) {
        free(memory);
        return hdl_fail(self, DG_HOST_ERR_SPACE, "no memory for an encoder");
    }
    return DG_HOST_OK;
}

/* It can be asked and steered from the first moment on. Its lines are at rest until its power
   comes, which is switched on for them in dg_hdl_wires(). */
static int start_encoder(struct dg_hdl *self, const char *settings, const char *memory)
{
    int result = dg_host_power(self->host, 0, true);

    if (result == DG_HOST_ERR_ARGUMENT) {
        return hdl_fail(self, result, "%s: do not go together", settings);
    }
    if (result != DG_HOST_OK) {
        return hdl_fail_memory(self, result, memory);
    }
    self->inputs = self->wire->idle_in;
    self->in.levels = self->wire->idle_in;
    self->outputs = self->wire->idle_out;
    self->power_at = HDL_NEVER;
    self->hint_due = HDL_NEVER;
    if (self->wire->reset != NULL) {
        self->wire->reset(self);
    }
    self->out.levels = self->outputs;
    self->random = self->settings.seed;
    dg_host_listen(self->host, heard, self);
    self->panel_due = HDL_NEVER;
    if (make_panel(self) != DG_HOST_OK) {
        return DG_HOST_ERR_SPACE;
    }
    dg_host_panel_seed(self->panel, self->settings.seed);
    return hdl_control_open(self);
}

static int set_up(struct dg_hdl *self, const char *model, const char *settings, const char *memory)
{
    self->settings = usual;
    self->memory.fd = -1;
    self->host = hdl_read_model(self, model) == 0 ? make_host(self, model, settings) : NULL;
    if (self->host == NULL) {
        return DG_HOST_ERR_ARGUMENT;
    }
    int result = choose_wire(self);
    if (result == DG_HOST_OK && memory[0] != '\0') {
        result = open_hdl_memory(self, settings, memory);
    }
    return result == DG_HOST_OK ? start_encoder(self, settings, memory) : result;
}

struct dg_hdl *dg_hdl_open(const char *model, const char *settings, const char *motion,
                           const char *memory)
{
    struct dg_hdl *self = calloc(1, sizeof *self);

    if (self == NULL) {
        return NULL;
    }
    int result = set_up(self, hdl_text(model), hdl_text(settings), hdl_text(memory));
    if (result == DG_HOST_OK && hdl_text(motion)[0] != '\0') {
        result = dg_hdl_motion(self, 0, motion);
    }
    if (result != DG_HOST_OK) {
        lx_nvm_file_unmake(&self->memory);
    }
    return self;
}

void dg_hdl_close(struct dg_hdl *self)
{
    if (self == NULL) {
        return;
    }
    hdl_control_close(self->control);
    lx_nvm_file_close(&self->memory);
    lx_shaft_free(&self->shaft);
    hdl_queue_free(&self->in);
    hdl_queue_free(&self->out);
    free(self->panel);
    free(self->host);
    free(self->models);
    free(self);
}
