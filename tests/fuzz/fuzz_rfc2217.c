/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: a client of a serial port by RFC 2217. The input is what comes in, byte by byte.
 * Every answer is whole telnet, settings stay in their ranges, what the client was told of them is
 * what is in force, characters come out as they went in, and an option is agreed to once.
 */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/bus_characters.h"
#include "drehgeber/rfc2217.h"
#include "fuzz_input.h"

#define IAC 255u
#define SE 240u
#define SB 250u
#define WILL 251u
#define WONT 252u
#define DO 253u
#define DONT 254u
#define COM_PORT 44u

static const struct dg_rfc2217_uart found = {.baud = 9600, .parity = 'E'};

/* What the client was told, with the setting that is in force. */
static void check_told(const struct dg_rfc2217 *self, uint8_t code, const uint8_t *value, size_t n)
{
    static const char parities[] = "?NOEMS";

    fuzz_must(n == (code == 101 ? 4u : code == 100 ? strlen("drehgeber") : 1u));
    switch (code) {
    case 101:
        fuzz_must(dg_load_be32(value) == (self->baud == 0 ? found.baud : self->baud));
        break;
    case 102:
        fuzz_must(*value == (self->data_bits == 0 ? 8 : self->data_bits));
        break;
    case 103:
        fuzz_must(*value >= 1 && *value <= 5 &&
                  parities[*value] == (self->parity == 0 ? found.parity : self->parity));
        break;
    case 104:
        fuzz_must(*value == (self->stop_bits == 0 ? 1 : self->stop_bits));
        break;
    default:
        fuzz_must(code == 100 || (code >= 105 && code <= 112 && code != 108 && code != 109));
        break;
    }
}

/* @return bytes of the command behind IAC SB */
static size_t check_command(const struct dg_rfc2217 *self, const uint8_t *text, size_t n)
{
    uint8_t value[DG_RFC2217_ANSWER_MAX];
    size_t length = 0;
    size_t at = 2;

    fuzz_must(n > 4 && text[0] == COM_PORT);
    while (at + 1u < n && !(text[at] == IAC && text[at + 1u] == SE)) {
        fuzz_must(text[at] != IAC || text[at + 1u] == IAC);
        value[length++] = text[at];
        at += text[at] == IAC ? 2u : 1u;
    }
    fuzz_must(at + 1u < n);
    check_told(self, text[1], value, length);
    return at + 2u;
}

static void check_answer(const struct dg_rfc2217 *self, const struct dg_rfc2217_event *event)
{
    size_t at = 0;

    fuzz_must(event->length <= sizeof event->answer);
    while (at < event->length) {
        const uint8_t *text = event->answer + at;
        const size_t left = event->length - at;
        fuzz_must(left >= 3 && text[0] == IAC && text[1] >= SB);
        at += text[1] == SB ? 2u + check_command(self, text + 2, left - 2u) : 3u;
    }
}

static void check_setting(const struct dg_rfc2217 *self)
{
    fuzz_must(self->baud == 0 ||
              (self->baud >= DG_RFC2217_BAUD_MIN && self->baud <= DG_RFC2217_BAUD_MAX));
    fuzz_must(self->parity == 0 || strchr("NOEMS", self->parity) != NULL);
    fuzz_must(self->data_bits == 0 || (self->data_bits >= 5 && self->data_bits <= 8));
    fuzz_must(self->stop_bits <= 3);
}

/* The client reads what is printed as that character. */
static void check_print(const struct dg_rfc2217 *self, uint8_t character)
{
    uint8_t text[DG_RFC2217_TEXT_MAX];
    const struct dg_rfc2217_sound sound = {{DG_BAUD_ANY, 0}, character, DG_RFC2217_PARITY};
    const size_t n = dg_rfc2217_print(self, &sound, text);
    const size_t state = (self->line_mask & DG_RFC2217_PARITY) != 0 ? 7 : 0;
    if (self->data_bits != 0) {
        character &= (uint8_t)((1u << self->data_bits) - 1u);
    }

    fuzz_must(n == state + (character == IAC ? 2u : 1u) && text[n - 1u] == character);
}

/* A client that repeats itself is not answered: the other side might do that for ever. */
static void check_quiet(const struct dg_rfc2217 *self)
{
    static const uint8_t known[] = {0, 3, COM_PORT};

    for (size_t i = 0; i < sizeof known; i++) {
        for (size_t side = 0; side < 2; side++) {
            struct dg_rfc2217 other = *self;
            struct dg_rfc2217_event event;
            const bool on = (self->enabled[side] >> i & 1u) != 0;
            const uint8_t text[] = {
                IAC, (uint8_t)(side == 0 ? (on ? WILL : WONT) : (on ? DO : DONT)), known[i]};
            for (size_t k = 0; k < sizeof text; k++) {
                dg_rfc2217_feed(&other, &found, text[k], &event);
                fuzz_must(event.length == 0 && event.what == DG_RFC2217_NOTHING);
            }
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    struct dg_rfc2217 client = {.baud = 0};
    struct dg_rfc2217_event event;

    for (size_t i = 0; i < n; i++) {
        const enum dg_rfc2217_state before = client.state;
        dg_rfc2217_feed(&client, &found, bytes[i], &event);
        check_answer(&client, &event);
        check_setting(&client);
        if (before == DG_RFC2217_DATA) {
            fuzz_must((event.what == DG_RFC2217_CHARACTER) == (bytes[i] != IAC));
        }
        if (event.what == DG_RFC2217_CHARACTER) {
            fuzz_must(event.character == bytes[i] && client.state == DG_RFC2217_DATA);
            check_print(&client, bytes[i]);
        }
    }
    if (client.state == DG_RFC2217_DATA) {
        check_quiet(&client);
    }
    return 0;
}
