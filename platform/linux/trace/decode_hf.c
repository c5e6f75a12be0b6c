/* SPDX-License-Identifier: MIT */
/*
 * Frames of the parameter channel of the S36 (manual 5.1): address, command, data, check sum.
 */
#include <string.h>

#include "decode.h"

#define FRAME_LEAST 3u
#define BROADCAST 0xFFu
#define WARNING 0x80u
#define CODE 0x7Fu
#define READ_STATUS 0x50u

/*
 * In the texts a sign and a number of bytes stand for data, MSB first:
 *   # hexadecimal   @ decimal   % decimal with sign   $ ASCII   & all that is left, hexadecimal
 */
/* clang-format off */
static const struct command {
    uint8_t code;
    const char *request;
    const char *reply;
} commands[] = {
    {0x42, "read position",                                        "position @4"},
    {0x43, "set position @4, code #1",                             "position set"},
    {0x44, "read analog value #1",                                 "analog value #1: %2"},
    {0x46, "read counter",                                         "counter @3"},
    {0x47, "increment counter",                                    "counter incremented"},
    {0x49, "erase counter, code #1",                               "counter erased"},
    {0x4A, "read data field #1 offset #1 count @1, code #1",       "data field #1 offset #1 count @1:&"},
    {0x4B, "save data field #1 offset #1 count @1, code #1:&",     "data field #1 offset #1 count @1 saved"},
    {0x4C, "determine data field status #1",                       "data field #1 status #1"},
    {0x4D, "create data field #1 status #1, code #1",              "data field #1 created, status #1"},
    {0x4E, "determine available memory area",                      "memory blocks free @1, data fields @1"},
    {0x4F, "modify access key @1 from #1 to #1",                   "access key @1 modified"},
    {0x50, "read encoder status",                                  "status"},
    {0x52, "read type label",                                      "type label: UART #1, type #1, memory blocks @1, option #1"},
    {0x53, "reset encoder",                                        "encoder reset"},
    {0x55, "assign address #1, code #1",                           "address assigned"},
    {0x56, "read serial number and version",                       "serial number $9, version $20, date $8"},
    {0x57, "configure serial interface #1, code #1",               "serial interface #1"},
    {0x6A, "set position with synchronization @4, code #1",        "position @4"},
};

/* Status messages, 5.1.3. */
static const struct {
    uint8_t code;
    const char *text;
} errors[] = {
    {0x00, "no error"},
    {0x01, "faulty compensation data"},
    {0x02, "faulty internal angular offset"},
    {0x03, "data field partitioning table destroyed"},
    {0x05, "internal I2C bus not operational"},
    {0x06, "internal check sum error"},
    {0x08, "counter overflow"},
    {0x0A, "check sum error"},
    {0x0B, "unknown command code"},
    {0x0C, "wrong command length"},
    {0x0D, "wrong argument"},
    {0x0E, "data field may not be written"},
    {0x0F, "wrong access code"},
    {0x10, "insufficient memory"},
    {0x11, "address outside of the data field"},
    {0x12, "wrong data field number"},
    {0x1D, "LED current"},
    {0x1E, "temperature"},
    {0x1F, "speed too high"},
    {0x20, "singleturn"},
    {0x21, "multiturn amplitude"},
    {0x22, "multiturn synchronization"},
    {0x23, "multiturn vector length"},
};
/* clang-format on */
#define COMMAND_COUNT DG_COUNT(commands)
#define ERROR_COUNT DG_COUNT(errors)

/* What is left of the data. */
struct data {
    const uint8_t *at;
    size_t n;
};

static uint32_t number(const uint8_t *bytes, size_t n)
{
    uint32_t value = 0;
    for (size_t i = 0; i < n; i++) {
        value = value << 8 | bytes[i];
    }
    return value;
}

/* ASCII up to its zero. */
static void add_ascii(struct lx_text *text, const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n && bytes[i] != 0; i++) {
        const bool printable = bytes[i] >= ' ' && bytes[i] <= '~';
        lx_text_add(text, "%c", printable ? bytes[i] : '?');
    }
}

static void add_field(struct lx_text *text, char sign, const uint8_t *bytes, size_t n)
{
    switch (sign) {
    case '#':
        lx_text_add(text, "%0*Xh", (int)(2 * n), number(bytes, n));
        break;
    case '@':
        lx_text_add(text, "%u", number(bytes, n));
        break;
    case '%':
        lx_text_add(text, "%d", (int16_t)number(bytes, n));
        break;
    default:
        add_ascii(text, bytes, n);
        break;
    }
}

/* A sign of a text with its figure. @return what follows it */
static const char *fill_in(struct lx_text *text, const char *at, struct data *data)
{
    const char sign = *at++;
    size_t n = sign == '&' ? data->n : 0;
    for (; *at >= '0' && *at <= '9'; at++) {
        n = n * 10 + (size_t)(*at - '0');
    }
    if (sign == '&') {
        lx_text_bytes(text, "", data->at, n);
    } else if (n > data->n) {
        lx_text_add(text, "?");
        n = data->n;
    } else {
        add_field(text, sign, data->at, n);
    }
    data->at += n;
    data->n -= n;
    return at;
}

static void add_words(struct lx_text *text, const char *at, struct data data)
{
    while (*at != '\0') {
        const size_t plain = strcspn(at, "#@%$&");
        lx_text_add(text, "%.*s", (int)plain, at);
        at += plain;
        if (*at != '\0') {
            at = fill_in(text, at, &data);
        }
    }
    lx_text_bytes(text, ", too many:", data.at, data.n);
}

static const char *error_text(uint8_t code)
{
    for (size_t i = 0; i < ERROR_COUNT; i++) {
        if (errors[i].code == code) {
            return errors[i].text;
        }
    }
    return "unknown";
}

static const struct command *find(uint8_t code)
{
    for (size_t i = 0; i < COMMAND_COUNT; i++) {
        if (commands[i].code == code) {
            return &commands[i];
        }
    }
    return NULL;
}

static void add_command(struct lx_text *text, bool reply, uint8_t code, struct data data)
{
    const struct command *command = find(code);
    lx_text_add(text, "%02Xh ", code);
    if (command == NULL) {
        lx_text_add(text, "unknown command");
        lx_text_bytes(text, ":", data.at, data.n);
    } else if (reply && code == READ_STATUS && data.n == 1) {
        /* An entry of the error stack, or how a slave refuses any other request: 5.1.1.2. */
        if (data.at[0] != 0) {
            lx_text_add(text, "error %02Xh ", data.at[0]);
        }
        lx_text_add(text, "%s", error_text(data.at[0]));
    } else {
        add_words(text, reply ? command->reply : command->request, data);
    }
}

/* What is wrong with the frame as such. */
static void add_damage(struct lx_text *text, const struct lx_decoder *frame, size_t n)
{
    uint8_t sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum ^= frame->bytes[i];
    }
    if (frame->length > n) {
        lx_text_add(text, ", %u bytes are too many", frame->length);
    } else if (sum != 0) {
        lx_text_add(text, ", check sum wrong");
    }
    if (frame->damaged) {
        lx_text_add(text, ", damaged");
    }
}

void lx_decode_hf(const struct lx_decoder *self, struct lx_text *text)
{
    const uint8_t *bytes = self->bytes;
    const size_t n = self->length < sizeof self->bytes ? self->length : sizeof self->bytes;
    const char *arrow = self->ours ? "-> " : "";
    if (n < FRAME_LEAST) {
        lx_text_add(text, "%stoo short:", arrow);
        lx_text_bytes(text, "", bytes, n);
        lx_text_add(text, "%s", self->damaged ? ", damaged" : "");
        return;
    }
    if (bytes[0] == BROADCAST) {
        lx_text_add(text, "all %s", arrow);
    } else {
        lx_text_add(text, "%02Xh %s", bytes[0], arrow);
    }
    const uint8_t code = (uint8_t)(bytes[1] & (self->ours ? CODE : 0xFFu));
    add_command(text, self->ours, code, (struct data){bytes + 2, n - FRAME_LEAST});
    if (self->ours && (bytes[1] & WARNING) != 0) {
        lx_text_add(text, ", warning");
    }
    add_damage(text, self, n);
}
