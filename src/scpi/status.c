/* SPDX-License-Identifier: MIT */
/*
 * Errors and status registers (IEEE 488.2 11, SCPI-99 volume 2, 19.7 and 21).
 */
#include "scpi_private.h"

#include <string.h>

/* Classes are the hundreds of error numbers: -1xx to -4xx. */
#define CLASS 100
#define CLASSES 5
#define DEVICE_SPECIFIC 3u

/* Errors in the order of their numbers; the first of a class stands for all others in it. */
static const struct {
    int16_t code;
    const char *text;
} texts[] = {
    {DG_SCPI_NO_ERROR, "No error"},
    {-100, "Command error"},
    {DG_SCPI_INVALID_CHARACTER, "Invalid character"},
    {DG_SCPI_SYNTAX, "Syntax error"},
    {DG_SCPI_DATA_TYPE, "Data type error"},
    {DG_SCPI_SUPERFLUOUS, "Parameter not allowed"},
    {DG_SCPI_MISSING, "Missing parameter"},
    {DG_SCPI_UNDEFINED, "Undefined header"},
    {DG_SCPI_NO_SUFFIX, "Suffix error"},
    {DG_SCPI_SUFFIX, "Invalid suffix"},
    {DG_SCPI_STRING, "Invalid string data"},
    {DG_SCPI_EXECUTION, "Execution error"},
    {DG_SCPI_CONFLICT, "Settings conflict"},
    {DG_SCPI_RANGE, "Data out of range"},
    {DG_SCPI_ILLEGAL, "Illegal parameter value"},
    {DG_SCPI_MEMORY, "Out of memory"},
    {DG_SCPI_HARDWARE, "Hardware error"},
    {DG_SCPI_MISSING_HARDWARE, "Hardware missing"},
    {DG_SCPI_STORAGE, "Mass storage error"},
    {DG_SCPI_FILE_NAME, "File name not found"},
    {DG_SCPI_FILE_ERROR, "File name error"},
    {-300, "Device-specific error"},
    {DG_SCPI_QUEUE, "Queue overflow"},
    {DG_SCPI_OVERRUN, "Input buffer overrun"},
    {-400, "Query error"},
};
#define TEXT_COUNT DG_COUNT(texts)

static const char *find_text(int code)
{
    for (size_t i = 0; i < TEXT_COUNT; i++) {
        if (texts[i].code == code) {
            return texts[i].text;
        }
    }
    return NULL;
}

/* 21.8: what is in no other class, positive numbers above all, is device-specific. */
static unsigned class_of(int code)
{
    const int class = -code / CLASS;

    return class > 0 && class < CLASSES ? (unsigned)class : DEVICE_SPECIFIC;
}

/* Standard text of an error number, and of its class for others. */
static const char *find_standard_text(int code)
{
    const char *const text = find_text(code);

    return text != NULL ? text : find_text(-(int)class_of(code) * CLASS);
}

static uint8_t esr_bit(int code)
{
    static const uint8_t bits[CLASSES] = {
        [1] = DG_SCPI_ESR_COMMAND,
        [2] = DG_SCPI_ESR_EXECUTION,
        [DEVICE_SPECIFIC] = DG_SCPI_ESR_DEVICE,
        [4] = DG_SCPI_ESR_QUERY,
    };

    return bits[class_of(code)];
}

static struct dg_scpi_queued *queue_place(struct dg_scpi *self, unsigned index)
{
    return &self->errors[(self->error_first + index) % DG_SCPI_ERRORS_MAX];
}

static void queue_error(struct dg_scpi *self, int code, const char *detail, size_t n)
{
    const bool full = self->error_count == DG_SCPI_ERRORS_MAX;
    struct dg_scpi_queued *entry =
        queue_place(self, full ? DG_SCPI_ERRORS_MAX - 1u : self->error_count);

    self->error_count = (uint8_t)(self->error_count + (full ? 0u : 1u));
    entry->code = (int16_t)(full ? DG_SCPI_QUEUE : code);
    n = full ? 0 : n;
    memcpy(entry->detail, detail, n);
    entry->detail[n] = '\0';
    self->esr |= esr_bit(code) | esr_bit(entry->code);
}

void dg_scpi_raise(struct dg_scpi *self, int code, const char *detail)
{
    const char *const text = detail != NULL ? detail : "";
    const size_t n = dg_scpi_length(text);

    if (code != DG_SCPI_NO_ERROR) {
        self->failed = true;
        queue_error(self, code, text, n < DG_SCPI_DETAIL_MAX ? n : DG_SCPI_DETAIL_MAX);
    }
}

void dg_scpi_usage(const struct dg_scpi_command *command, bool query,
                   const char *pieces[SCPI_USAGE])
{
    const bool described = !query || command->set == NULL;
    const char *const parameters = described ? command->parameters : "";

    pieces[0] = command->header;
    pieces[1] = query ? "?" : "";
    pieces[2] = parameters[0] != '\0' ? " " : "";
    pieces[3] = parameters;
}

void dg_scpi_add_usage(struct dg_text *to, const struct dg_scpi_command *command, bool query)
{
    const char *pieces[SCPI_USAGE];

    dg_scpi_usage(command, query, pieces);
    for (size_t i = 0; i < SCPI_USAGE; i++) {
        dg_text_add(to, pieces[i]);
    }
}

void dg_scpi_raise_usage(struct dg_scpi *self, int code)
{
    char room[SCPI_DETAIL_SIZE];
    struct dg_text detail = dg_text_in(room, sizeof room);

    dg_scpi_add_usage(&detail, self->command, self->query);
    dg_scpi_raise(self, code, detail.to);
}

uint8_t dg_scpi_status_byte(const struct dg_scpi *self)
{
    unsigned byte = self->error_count > 0 ? DG_SCPI_STB_ERRORS : 0u;

    byte |= (self->esr & self->ese) != 0 ? DG_SCPI_STB_EVENT : 0u;
    byte |= (byte & self->sre) != 0 ? DG_SCPI_STB_SERVICE : 0u;
    return (uint8_t)byte;
}

void dg_scpi_clear_errors(struct dg_scpi *self)
{
    self->error_first = 0;
    self->error_count = 0;
}

void dg_scpi_put_error(struct dg_scpi *self)
{
    static const struct dg_scpi_queued none = {.code = DG_SCPI_NO_ERROR};
    const struct dg_scpi_queued *error = self->error_count > 0 ? queue_place(self, 0) : &none;

    dg_scpi_put_number(self, error->code, 0);
    dg_scpi_begin(self);
    dg_scpi_append(self, "\"");
    dg_scpi_append(self, find_standard_text(error->code));
    if (error->detail[0] != '\0') {
        dg_scpi_append(self, ";");
        dg_scpi_append_quoted(self, error->detail);
    }
    dg_scpi_append(self, "\"");
    if (self->error_count > 0 && !self->failed) {
        self->error_first = (uint8_t)((self->error_first + 1u) % DG_SCPI_ERRORS_MAX);
        self->error_count--;
    }
}
