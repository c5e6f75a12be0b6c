/* SPDX-License-Identifier: MIT */
/*
 * The parameter channel of the S36 in words (manual 5.1): address, command, data, check sum.
 * Characters add up to a frame:
 *
 *   40 42 02 . . . . 40 42 00 00 30 39 0B . . . . . . . . . . . . . .
 *   `request `       `reply: the other direction ends the request   ` 44 bits of silence end it
 */
#include "drehgeber/words.h"
#include "drehgeber/hiperface.h"

/* Silence that ends a frame: the longest timeout of a request, 5.1.1.1. */
#define SILENCE_BITS 44u
#define CHARACTER_BITS 11u

/* More than the longest frame has. */
#define FRAME_ROOM 140u
#define FRAME_LEAST 3u
#define BROADCAST 0xFFu
#define WARNING 0x80u
#define CODE 0x7Fu
#define READ_STATUS 0x50u

/* A frame that is being collected; length 0: none. */
struct hf_words {
    dg_ns begin;
    dg_ns last; /* end of its last character */
    uint32_t baud;
    uint16_t length; /* may be more than there is room for */
    bool ours;
    bool damaged;
    uint8_t bytes[FRAME_ROOM];
};

/*
 * In the texts a sign and a number of bytes stand for data, MSB first:
 *   # hexadecimal   @ decimal   % decimal with sign   $ ASCII   & all that is left, hexadecimal
 * A request is worth a notice when the encoder is another one behind it: its position, its fields
 * and keys, its line.
 */
/* clang-format off */
#define OK DG_SEVERITY_OK
#define NOTICE DG_SEVERITY_NOTICE
static const struct command {
    uint8_t code;
    uint8_t severity; /* of the request */
    const char *clause;
    const char *request;
    const char *reply;
} commands[] = {
    {0x42, OK,     "5.1.2.1",  "read position",                                        "position @4"},
    {0x43, NOTICE, "5.1.2.2",  "set position @4, code #1",                             "position set"},
    {0x44, OK,     "5.1.2.3",  "read analog value #1",                                 "analog value #1: %2"},
    {0x46, OK,     "5.1.2.4",  "read counter",                                         "counter @3"},
    {0x47, OK,     "5.1.2.5",  "increment counter",                                    "counter incremented"},
    {0x49, NOTICE, "5.1.2.6",  "erase counter, code #1",                               "counter erased"},
    {0x4A, OK,     "5.1.2.7",  "read data field #1 offset #1 count @1, code #1",       "data field #1 offset #1 count @1:&"},
    {0x4B, OK,     "5.1.2.8",  "save data field #1 offset #1 count @1, code #1:&",     "data field #1 offset #1 count @1 saved"},
    {0x4C, OK,     "5.1.2.9",  "determine data field status #1",                       "data field #1 status #1"},
    {0x4D, NOTICE, "5.1.2.10", "create data field #1 status #1, code #1",              "data field #1 created, status #1"},
    {0x4E, OK,     "5.1.2.11", "determine available memory area",                      "memory blocks free @1, data fields @1"},
    {0x4F, NOTICE, "5.1.2.12", "modify access key @1 from #1 to #1",                   "access key @1 modified"},
    {0x50, OK,     "5.1.2.13", "read encoder status",                                  "status"},
    {0x52, OK,     "5.1.2.14", "read type label",                                      "type label: UART #1, type #1, memory blocks @1, option #1"},
    {0x53, NOTICE, "5.1.2.15", "reset encoder",                                        "encoder reset"},
    {0x55, NOTICE, "5.1.2.16", "assign address #1, code #1",                           "address assigned"},
    {0x56, OK,     "5.1.2.17", "read serial number and version",                       "serial number $9, version $20, date $8"},
    {0x57, NOTICE, "5.1.2.18", "configure serial interface #1, code #1",               "serial interface #1"},
    {0x6A, NOTICE, "5.1.2.19", "set position with synchronization @4, code #1",        "position @4"},
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

/* What is left of the data. */
struct data {
    const uint8_t *at;
    size_t n;
};

static uint32_t bytes_number_of(const uint8_t *bytes, size_t n)
{
    uint32_t value = 0;

    for (size_t i = 0; i < n; i++) {
        value = value << 8 | bytes[i];
    }
    return value;
}

/* ASCII up to its zero. */
static void add_ascii(struct dg_text *text, const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n && bytes[i] != 0; i++) {
        const bool printable = bytes[i] >= ' ' && bytes[i] <= '~';
        char character = '?';

        if (printable) {
            character = (char)bytes[i];
        }
        dg_text_add_n(text, &character, 1);
    }
}

static void add_field(struct dg_words_draft *draft, char sign, const uint8_t *bytes, size_t n)
{
    switch (sign) {
    case '#':
        dg_words_add_code(draft, bytes_number_of(bytes, n), (unsigned)(2u * n));
        break;
    case '@':
        dg_text_add_number(&draft->text, bytes_number_of(bytes, n));
        break;
    case '%':
        dg_text_add_number(&draft->text, (int16_t)bytes_number_of(bytes, n));
        break;
    default:
        add_ascii(&draft->text, bytes, n);
        break;
    }
}

/* A sign of a text with its figure. @return what follows it */
static const char *fill_in(struct dg_words_draft *draft, const char *at, struct data *data)
{
    const char sign = *at++;
    size_t n = sign == '&' ? data->n : 0;

    for (; *at >= '0' && *at <= '9'; at++) {
        n = n * 10u + (size_t)(*at - '0');
    }
    if (sign == '&') {
        dg_words_add_bytes(draft, "", data->at, n);
    } else if (n > data->n) {
        dg_words_judge(draft, DG_SEVERITY_WARNING);
        dg_text_add(&draft->text, "?");
        n = data->n;
    } else {
        add_field(draft, sign, data->at, n);
    }
    data->at += n;
    data->n -= n;
    return at;
}

static bool is_sign(char c)
{
    return c == '#' || c == '@' || c == '%' || c == '$' || c == '&';
}

/* How many characters there are up to the next sign. */
static size_t plain_length(const char *text)
{
    size_t n = 0;

    while (text[n] != '\0' && !is_sign(text[n])) {
        n++;
    }
    return n;
}

static void add_filled(struct dg_words_draft *draft, const char *at, struct data data)
{
    while (*at != '\0') {
        const size_t plain = plain_length(at);

        dg_text_add_n(&draft->text, at, plain);
        at += plain;
        if (*at != '\0') {
            at = fill_in(draft, at, &data);
        }
    }
    dg_words_add_bytes(draft, ", too many:", data.at, data.n);
    dg_words_judge(draft, data.n > 0 ? DG_SEVERITY_WARNING : DG_SEVERITY_OK);
}

static const char *error_text(uint8_t code)
{
    for (size_t i = 0; i < DG_COUNT(errors); i++) {
        if (errors[i].code == code) {
            return errors[i].text;
        }
    }
    return "unknown";
}

static const struct command *find_words(uint8_t code)
{
    for (size_t i = 0; i < DG_COUNT(commands); i++) {
        if (commands[i].code == code) {
            return &commands[i];
        }
    }
    return NULL;
}

/* An entry of the error stack, or how a slave refuses any other request: 5.1.1.2. */
static void add_status(struct dg_words_draft *draft, uint8_t code)
{
    if (code != 0) {
        draft->clause = "5.1.3";
        dg_words_judge(draft, DG_SEVERITY_ERROR);
        dg_text_add(&draft->text, "error ");
        dg_words_add_code(draft, code, 2);
        dg_text_add(&draft->text, " ");
    }
    dg_text_add(&draft->text, error_text(code));
}

static void add_command(struct dg_words_draft *draft, bool reply, uint8_t code, struct data data)
{
    const struct command *command = find_words(code);

    dg_words_add_code(draft, code, 2);
    dg_text_add(&draft->text, " ");
    draft->clause = command == NULL ? "5.1.1.2" : command->clause;
    if (command == NULL) {
        dg_words_judge(draft, DG_SEVERITY_WARNING);
        dg_text_add(&draft->text, "unknown command");
        dg_words_add_bytes(draft, ":", data.at, data.n);
    } else if (reply && code == READ_STATUS && data.n == 1) {
        add_status(draft, data.at[0]);
    } else if (reply) {
        add_filled(draft, command->reply, data);
    } else {
        dg_words_judge(draft, (enum dg_severity)command->severity);
        add_filled(draft, command->request, data);
    }
}

static void add_wrong(struct dg_words_draft *draft, const char *text)
{
    draft->clause = "5.1.1.1";
    dg_words_judge(draft, DG_SEVERITY_ERROR);
    dg_text_add(&draft->text, text);
}

/* What is wrong with the frame as such, of which `n` bytes are known. */
static void add_damage(struct dg_words_draft *draft, const struct hf_words *frame, size_t n)
{
    uint8_t sum = 0;

    for (size_t i = 0; i < n; i++) {
        sum ^= frame->bytes[i];
    }
    if (frame->length > n) {
        dg_text_add(&draft->text, ", ");
        dg_text_add_number(&draft->text, frame->length);
        add_wrong(draft, " bytes are too many");
    } else if (sum != 0) {
        add_wrong(draft, ", check sum wrong");
    }
    if (frame->damaged) {
        add_wrong(draft, ", damaged");
    }
}

static void add_whole(struct dg_words_draft *draft, const struct hf_words *frame, size_t n)
{
    const uint8_t *bytes = frame->bytes;
    const uint8_t code = (uint8_t)(bytes[1] & (frame->ours ? CODE : 0xFFu));

    if (bytes[0] == BROADCAST) {
        dg_text_add(&draft->text, "all");
    } else {
        dg_words_add_code(draft, bytes[0], 2);
    }
    dg_text_add(&draft->text, frame->ours ? " -> " : " ");
    add_command(draft, frame->ours, code, (struct data){bytes + 2, n - FRAME_LEAST});
    if (frame->ours && (bytes[1] & WARNING) != 0) {
        dg_words_judge(draft, DG_SEVERITY_WARNING);
        dg_text_add(&draft->text, ", warning");
    }
    add_damage(draft, frame, n);
}

static void add_fragment(struct dg_words_draft *draft, const struct hf_words *frame, size_t n)
{
    dg_text_add(&draft->text, frame->ours ? "-> " : "");
    add_wrong(draft, "too short:");
    dg_words_add_bytes(draft, "", frame->bytes, n);
    dg_text_add(&draft->text, frame->damaged ? ", damaged" : "");
}

/* The frame that was collected, if there is one. */
static void give_frame(struct hf_words *self, const struct dg_words_to *to)
{
    const size_t n = self->length < FRAME_ROOM ? self->length : FRAME_ROOM;
    struct dg_words_draft draft;

    if (n == 0) {
        return;
    }
    dg_words_begin(&draft);
    if (n < FRAME_LEAST) {
        add_fragment(&draft, self, n);
    } else {
        add_whole(&draft, self, n);
    }
    self->length = 0;
    dg_words_give(&draft, self->begin, self->ours, to);
}

/* A character that starts from then on begins a new frame. */
static dg_ns frame_end(const struct hf_words *self)
{
    return dg_after(self->last, dg_bit_times_ns(SILENCE_BITS, self->baud));
}

/* A character that started before frame_end() would have been told by then. */
static dg_ns wait_end(const struct hf_words *self)
{
    return dg_after(self->last, dg_bit_times_ns(SILENCE_BITS + CHARACTER_BITS, self->baud));
}

/* Characters that come in a bunch overlap, and so belong together. */
static void collect_character(struct hf_words *self, const struct dg_tap_event *event,
                              const struct dg_words_to *to)
{
    const uint32_t bits = event->character.parity == 'N' ? CHARACTER_BITS - 1u : CHARACTER_BITS;
    const dg_ns start = dg_elapsed(event->at, dg_bit_times_ns(bits, event->character.baud));

    if (event->ours != self->ours || start >= frame_end(self)) {
        give_frame(self, to);
    }
    if (self->length == 0) {
        self->begin = start;
        self->ours = event->ours;
        self->damaged = false;
    }
    if (self->length < FRAME_ROOM) {
        self->bytes[self->length] = event->character.byte;
    }
    self->length = (uint16_t)(self->length < UINT16_MAX ? self->length + 1u : UINT16_MAX);
    self->damaged |= event->character.damaged;
    self->baud = event->character.baud;
    self->last = event->at;
}

static void tell_event(void *self, const struct dg_tap_event *event, const struct dg_words_to *to)
{
    if (event->kind == DG_TAP_CHARACTER) {
        collect_character(self, event, to);
    }
}

static dg_ns tell_time(void *memory, dg_ns now, const struct dg_words_to *to)
{
    struct hf_words *self = memory;

    if (self->length > 0 && wait_end(self) <= now) {
        give_frame(self, to);
    }
    return self->length > 0 ? wait_end(self) : DG_NEVER;
}

/* A request begins with the address of its encoder or that of all, a reply with the encoder's own.
 */
static int find_side(const struct dg_tap_event *event, uint32_t address)
{
    const uint8_t first = event->character.byte;

    return address == 0 || first == address || first == BROADCAST ? DG_WORDS_AS_TOLD
                                                                  : DG_WORDS_OTHER;
}

const struct dg_words dg_hf_words = {
    .stack = &dg_hf_stack,
    .size = sizeof(struct hf_words),
    .event = tell_event,
    .step = tell_time,
    .side = find_side,
};
