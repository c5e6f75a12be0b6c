/* SPDX-License-Identifier: MIT */
/*
 * Telnet (RFC 854, 855) in five states, and under the COM port option one row for each command:
 * how many bytes its value has, and what it does. Every setting is answered with what is in force.
 */
#include "drehgeber/rfc2217.h"

#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/bus_characters.h"

/* Telnet commands. */
enum {
    SE = 240,
    BRK = 243,
    SB = 250,
    WILL = 251,
    WONT = 252,
    DO = 253,
    DONT = 254,
    IAC = 255,
};

/* Options that are known; a bit for each in `enabled`. */
static const uint8_t options[] = {0 /* binary */, 3 /* suppress go ahead */, 44 /* COM port */};
#define COM_PORT 44u
#define COM_PORT_BIT (1u << 2)

/* What a command of the port is more than the client's. */
#define SERVER 100u

#define NOTIFY_LINE 6u
#define NOTIFY_MODEM 7u
#define FLOW_SUSPEND 8u
/* Always: the line is idle and there is room; carrier, data set ready, clear to send. */
#define LINE_IDLE 0x60u
#define MODEM_READY 0xB0u

/* SET-CONTROL values that matter here, and the last one there is. */
#define BREAK_ON 5u
#define CONTROL_LAST 19u

#define DATA_BITS 8u
/* No parity that an encoder could have. */
#define NO_SUCH_PARITY '?'

/* --- answers --- */

static void put_answer(struct dg_rfc2217_event *event, const uint8_t *bytes, size_t n)
{
    if (event->length + n <= sizeof event->answer) {
        memcpy(event->answer + event->length, bytes, n);
        event->length += n;
    }
}

/* A value is data: IAC stands there twice. */
static size_t escape_bytes(uint8_t *to, const uint8_t *bytes, size_t n)
{
    size_t length = 0;
    for (size_t i = 0; i < n; i++) {
        to[length++] = bytes[i];
        if (bytes[i] == IAC) {
            to[length++] = IAC;
        }
    }
    return length;
}

static size_t encode_command(uint8_t *to, uint8_t code, const uint8_t *value, size_t n)
{
    const uint8_t begin[] = {IAC, SB, COM_PORT, (uint8_t)(code + SERVER)};
    const uint8_t end[] = {IAC, SE};
    memcpy(to, begin, sizeof begin);
    size_t length = sizeof begin + escape_bytes(to + sizeof begin, value, n);
    memcpy(to + length, end, sizeof end);
    return length + sizeof end;
}

static void answer_option(struct dg_rfc2217_event *event, uint8_t code, const uint8_t *value,
                          size_t n)
{
    uint8_t text[DG_RFC2217_ANSWER_MAX];
    put_answer(event, text, encode_command(text, code, value, n));
}

static void answer_byte(struct dg_rfc2217_event *event, uint8_t code, uint8_t value)
{
    answer_option(event, code, &value, 1);
}

/* --- the COM port's commands --- */

/* A command of a client. */
struct call {
    struct dg_rfc2217 *self;
    const struct dg_rfc2217_uart *found;
    struct dg_rfc2217_event *event;
    uint8_t code;
    const uint8_t *value;
};

static void tell_name(const struct call *call)
{
    static const char name[] = "drehgeber";
    answer_option(call->event, call->code, (const uint8_t *)name, sizeof name - 1u);
}

static void set_baud(const struct call *call)
{
    const uint32_t baud = dg_load_be32(call->value);
    uint8_t value[4];
    if (baud >= DG_RFC2217_BAUD_MIN && baud <= DG_RFC2217_BAUD_MAX) {
        call->self->baud = baud;
    }
    dg_store_be32(value, call->self->baud == 0 ? call->found->baud : call->self->baud);
    answer_option(call->event, call->code, value, sizeof value);
}

/* One of `first`..`last`; all else asks what is in force, `found` when nothing was said. */
static void set_figure(const struct call *call, uint8_t *to, uint8_t first, uint8_t last,
                       uint8_t found)
{
    if (*call->value >= first && *call->value <= last) {
        *to = *call->value;
    }
    answer_byte(call->event, call->code, *to == 0 ? found : *to);
}

static void set_data_bits(const struct call *call)
{
    set_figure(call, &call->self->data_bits, 5, 8, 8);
}

/* By code; the first is no parity at all. */
static const char parities[] = {'\0', 'N', 'O', 'E', 'M', 'S'};

static uint8_t parity_code_of(char parity)
{
    uint8_t code = 0;
    for (uint8_t i = 1; i < DG_COUNT(parities); i++) {
        code = parities[i] == parity ? i : code;
    }
    return code;
}

static void set_parity(const struct call *call)
{
    uint8_t code = parity_code_of(call->self->parity);
    set_figure(call, &code, 1, DG_COUNT(parities) - 1u, parity_code_of(call->found->parity));
    call->self->parity = parities[code % DG_COUNT(parities)];
}

static void set_stop_bits(const struct call *call)
{
    set_figure(call, &call->self->stop_bits, 1, 3, 1);
}

/* Nobody has flow control or modem lines here: what is set is remembered, and told who asks. */
static void set_control(const struct call *call)
{
    static const uint8_t group_of[CONTROL_LAST + 1u] = {0, 0, 0, 0, 1, 1, 1, 2, 2, 2,
                                                        3, 3, 3, 4, 4, 4, 4, 0, 4, 0};
    static const uint8_t asks[DG_RFC2217_CONTROLS] = {0, 4, 7, 10, 13};
    static const uint8_t found[DG_RFC2217_CONTROLS] = {1, 6, 8, 11, 14};
    const uint8_t value = *call->value;
    const uint8_t group = value > CONTROL_LAST ? 0 : group_of[value];
    uint8_t *control = &call->self->control[group];
    if (value <= CONTROL_LAST && value != asks[group]) {
        *control = value;
    }
    if (value == BREAK_ON) {
        call->event->what = DG_RFC2217_BREAK;
    }
    answer_byte(call->event, call->code, *control == 0 ? found[group] : *control);
}

static void tell_state(const struct call *call)
{
    answer_byte(call->event, call->code, call->code == NOTIFY_LINE ? LINE_IDLE : MODEM_READY);
}

static void set_flow(const struct call *call)
{
    call->self->suspended = call->code == FLOW_SUSPEND;
}

static void set_line_mask(const struct call *call)
{
    call->self->line_mask = *call->value;
    answer_byte(call->event, call->code, *call->value);
}

/* Of a mask for what never changes, and of what is to be thrown away: nothing waits here. */
static void echo_value(const struct call *call)
{
    answer_byte(call->event, call->code, *call->value);
}

/* By code. A value that is longer than it should be is cut off, a shorter one is no command. */
static const struct {
    uint8_t length;
    void (*act)(const struct call *call);
} commands[] = {
    {0, tell_name},     {4, set_baud},   {1, set_data_bits}, {1, set_parity}, {1, set_stop_bits},
    {1, set_control},   {0, tell_state}, {0, tell_state},    {0, set_flow},   {0, set_flow},
    {1, set_line_mask}, {1, echo_value}, {1, echo_value},
};

static void execute_setting(struct dg_rfc2217 *self, const struct dg_rfc2217_uart *found,
                            struct dg_rfc2217_event *event)
{
    if (self->length < 2 || self->length > DG_RFC2217_COMMAND_MAX || self->command[0] != COM_PORT ||
        self->command[1] >= DG_COUNT(commands)) {
        return;
    }
    const struct call call = {.self = self,
                              .found = found,
                              .event = event,
                              .code = self->command[1],
                              .value = self->command + 2};
    if (self->length - 2u >= commands[call.code].length) {
        commands[call.code].act(&call);
    }
}

/* --- telnet --- */

/* Agree to what is known, once; decline the rest. Who says no is believed. */
static void negotiate_option(struct dg_rfc2217 *self, uint8_t option,
                             struct dg_rfc2217_event *event)
{
    const bool theirs = self->verb == WILL || self->verb == WONT;
    const bool on = self->verb == WILL || self->verb == DO;
    unsigned bit = 0;
    for (size_t i = 0; i < DG_COUNT(options); i++) {
        bit |= options[i] == option ? 1u << i : 0u;
    }
    uint8_t *enabled = &self->enabled[theirs ? 0 : 1];
    const bool is_on = (*enabled & bit) != 0;
    if (is_on == on) {
        return;
    }
    static const uint8_t agree[2] = {WILL, DO};
    static const uint8_t decline[2] = {WONT, DONT};
    const uint8_t reply[] = {IAC, on && bit != 0 ? agree[theirs] : decline[theirs], option};
    const bool had_port = ((self->enabled[0] | self->enabled[1]) & COM_PORT_BIT) != 0;
    *enabled = (uint8_t)(on ? *enabled | bit : *enabled & ~bit);
    put_answer(event, reply, sizeof reply);
    if (on && bit == COM_PORT_BIT && !had_port) {
        answer_byte(event, NOTIFY_MODEM, MODEM_READY);
    }
}

static void collect_option(struct dg_rfc2217 *self, uint8_t byte)
{
    if (self->length < DG_RFC2217_COMMAND_MAX) {
        self->command[self->length] = byte;
    }
    self->length =
        (uint8_t)(self->length <= DG_RFC2217_COMMAND_MAX ? self->length + 1u : self->length);
}

static void on_telnet_data(struct dg_rfc2217 *self, uint8_t byte, struct dg_rfc2217_event *event)
{
    if (byte == IAC) {
        self->state = DG_RFC2217_COMMAND;
        return;
    }
    event->what = DG_RFC2217_CHARACTER;
    event->character = byte;
}

static void on_command(struct dg_rfc2217 *self, uint8_t byte, struct dg_rfc2217_event *event)
{
    self->state = DG_RFC2217_DATA;
    if (byte == IAC) {
        event->what = DG_RFC2217_CHARACTER;
        event->character = byte;
    } else if (byte >= WILL) {
        self->verb = byte;
        self->state = DG_RFC2217_OPTION;
    } else if (byte == SB) {
        self->length = 0;
        self->state = DG_RFC2217_SUB;
    } else if (byte == BRK) {
        event->what = DG_RFC2217_BREAK;
    }
}

void dg_rfc2217_feed(struct dg_rfc2217 *self, const struct dg_rfc2217_uart *found, uint8_t byte,
                     struct dg_rfc2217_event *event)
{
    event->what = DG_RFC2217_NOTHING;
    event->length = 0;
    switch (self->state) {
    case DG_RFC2217_DATA:
        on_telnet_data(self, byte, event);
        break;
    case DG_RFC2217_COMMAND:
        on_command(self, byte, event);
        break;
    case DG_RFC2217_OPTION:
        self->state = DG_RFC2217_DATA;
        negotiate_option(self, byte, event);
        break;
    case DG_RFC2217_SUB:
        if (byte == IAC) {
            self->state = DG_RFC2217_SUB_COMMAND;
        } else {
            collect_option(self, byte);
        }
        break;
    case DG_RFC2217_SUB_COMMAND: /* any other command ends it without effect */
        if (byte == IAC) {
            self->state = DG_RFC2217_SUB;
            collect_option(self, byte);
        } else if (byte == SE) {
            self->state = DG_RFC2217_DATA;
            execute_setting(self, found, event);
        } else {
            on_command(self, byte, event);
        }
        break;
    }
}

/* --- what the client hears --- */

struct dg_rfc2217_uart dg_rfc2217_setting(const struct dg_rfc2217 *self)
{
    struct dg_rfc2217_uart uart = {
        .baud = self->baud == 0 ? DG_BAUD_ANY : self->baud,
        .parity = self->parity,
    };

    if (self->data_bits != 0 && self->data_bits != DATA_BITS) {
        uart.parity = NO_SUCH_PARITY;
    }
    return uart;
}

size_t dg_rfc2217_print(const struct dg_rfc2217 *self, const struct dg_rfc2217_sound *sound,
                        uint8_t to[DG_RFC2217_TEXT_MAX])
{
    const struct dg_rfc2217_uart own = dg_rfc2217_setting(self);
    const struct dg_rfc2217_uart *sent = &sound->sent;
    const uint8_t bits = self->data_bits == 0 ? DATA_BITS : self->data_bits;
    uint8_t character = (uint8_t)(sound->byte & ((1u << bits) - 1u));
    uint8_t line = sound->line;

    if (own.baud != DG_BAUD_ANY && sent->baud != DG_BAUD_ANY && own.baud != sent->baud) {
        character = 0;
        line |= DG_RFC2217_FRAMING;
    } else if (own.parity != 0 && sent->parity != 0 && own.parity != sent->parity) {
        line |= DG_RFC2217_PARITY;
    }
    const uint8_t told = line & self->line_mask;
    const size_t n = told == 0 ? 0 : encode_command(to, NOTIFY_LINE, &told, 1);
    return n + escape_bytes(to + n, &character, 1);
}
