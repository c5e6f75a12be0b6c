/* SPDX-License-Identifier: MIT */
/* The port's side of RFC 2217. Bytes are those of RFC 854, 855 and 2217, chapter 3. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bus_characters.h"
#include "drehgeber/rfc2217.h"

static const struct dg_rfc2217_uart found = {.baud = 9600, .parity = 'E'};

/* What came of some bytes. */
struct outcome {
    size_t answered;
    uint8_t answer[64];
    size_t heard;
    uint8_t characters[16]; /* a break is a B */
};

static struct outcome send_bytes(struct dg_rfc2217 *self, const char *bytes, size_t n)
{
    struct outcome out = {.answered = 0};
    for (size_t i = 0; i < n; i++) {
        struct dg_rfc2217_event event;
        dg_rfc2217_feed(self, &found, (uint8_t)bytes[i], &event);
        memcpy(out.answer + out.answered, event.answer, event.length);
        out.answered += event.length;
        if (event.what != DG_RFC2217_NOTHING) {
            out.characters[out.heard++] = event.what == DG_RFC2217_BREAK ? 'B' : event.character;
        }
    }
    return out;
}

#define TEXT(text) (text), sizeof(text) - 1

static void told(struct dg_rfc2217 *self, const char *bytes, size_t n, const char *answer,
                 size_t length)
{
    const struct outcome out = send_bytes(self, bytes, n);
    assert_int_equal(out.answered, length);
    assert_memory_equal(out.answer, answer, length);
    assert_int_equal(out.heard, 0);
}

static void heard(struct dg_rfc2217 *self, const char *bytes, size_t n, const char *characters,
                  size_t length)
{
    const struct outcome out = send_bytes(self, bytes, n);
    assert_int_equal(out.heard, length);
    assert_memory_equal(out.characters, characters, length);
}

static void options_are_agreed_to_once(void **state)
{
    struct dg_rfc2217 self = {.baud = 0};
    (void)state;
    told(&self, TEXT("\xFF\xFB\x2C"), TEXT("\xFF\xFD\x2C\xFF\xFA\x2C\x6B\xB0\xFF\xF0"));
    told(&self, TEXT("\xFF\xFB\x2C"), TEXT(""));
    told(&self, TEXT("\xFF\xFD\x2C"), TEXT("\xFF\xFB\x2C"));
    told(&self, TEXT("\xFF\xFD\x00\xFF\xFB\x03"), TEXT("\xFF\xFB\x00\xFF\xFD\x03"));
    told(&self, TEXT("\xFF\xFB\x01\xFF\xFD\x22"), TEXT("\xFF\xFE\x01\xFF\xFC\x22"));
    told(&self, TEXT("\xFF\xFC\x2C\xFF\xFE\x00"), TEXT("\xFF\xFE\x2C\xFF\xFC\x00"));
    told(&self, TEXT("\xFF\xFC\x2C\xFF\xFE\x01"), TEXT(""));
}

static void settings_are_kept_in_range(void **state)
{
    struct dg_rfc2217 self = {.baud = 0};
    (void)state;
    told(&self, TEXT("\xFF\xFA\x2C\x01\0\0\0\0\xFF\xF0"),
         TEXT("\xFF\xFA\x2C\x65\0\0\x25\x80\xFF\xF0"));
    told(&self, TEXT("\xFF\xFA\x2C\x01\0\0\x4B\0\xFF\xF0"),
         TEXT("\xFF\xFA\x2C\x65\0\0\x4B\0\xFF\xF0"));
    assert_int_equal(self.baud, 19200);
    told(&self, TEXT("\xFF\xFA\x2C\x01\0\0\0\x31\xFF\xF0"), /* 49 */
         TEXT("\xFF\xFA\x2C\x65\0\0\x4B\0\xFF\xF0"));
    told(&self, TEXT("\xFF\xFA\x2C\x01\0\0\0\xFF\xFF\xFF\xF0"), /* 255, twice FF */
         TEXT("\xFF\xFA\x2C\x65\0\0\0\xFF\xFF\xFF\xF0"));
    told(&self, TEXT("\xFF\xFA\x2C\x02\x07\xFF\xF0"), TEXT("\xFF\xFA\x2C\x66\x07\xFF\xF0"));
    told(&self, TEXT("\xFF\xFA\x2C\x02\x09\xFF\xF0"), TEXT("\xFF\xFA\x2C\x66\x07\xFF\xF0"));
    told(&self, TEXT("\xFF\xFA\x2C\x03\x00\xFF\xF0"), TEXT("\xFF\xFA\x2C\x67\x03\xFF\xF0"));
    told(&self, TEXT("\xFF\xFA\x2C\x03\x02\xFF\xF0"), TEXT("\xFF\xFA\x2C\x67\x02\xFF\xF0"));
    assert_int_equal(self.parity, 'O');
    told(&self, TEXT("\xFF\xFA\x2C\x04\x02\xFF\xF0"), TEXT("\xFF\xFA\x2C\x68\x02\xFF\xF0"));
    told(&self, TEXT("\xFF\xFA\x2C\x05\x09\xFF\xF0"), TEXT("\xFF\xFA\x2C\x69\x09\xFF\xF0"));
    told(&self, TEXT("\xFF\xFA\x2C\x05\x07\xFF\xF0"), TEXT("\xFF\xFA\x2C\x69\x09\xFF\xF0"));
    told(&self, TEXT("\xFF\xFA\x2C\x05\x04\xFF\xF0"), TEXT("\xFF\xFA\x2C\x69\x06\xFF\xF0"));
}

/* Masks of the line and of the modem, and what to throw away: acknowledged as they are. */
static void what_needs_nothing_is_acknowledged(void **state)
{
    struct dg_rfc2217 self = {.baud = 0};
    (void)state;
    told(&self, TEXT("\xFF\xFA\x2C\x0A\x0E\xFF\xF0"), TEXT("\xFF\xFA\x2C\x6E\x0E\xFF\xF0"));
    told(&self, TEXT("\xFF\xFA\x2C\x0B\x0F\xFF\xF0"), TEXT("\xFF\xFA\x2C\x6F\x0F\xFF\xF0"));
    told(&self, TEXT("\xFF\xFA\x2C\x0C\x03\xFF\xF0"), TEXT("\xFF\xFA\x2C\x70\x03\xFF\xF0"));
}

static void what_is_no_command_is_nothing(void **state)
{
    struct dg_rfc2217 self = {.baud = 0};
    (void)state;
    told(&self, TEXT("\xFF\xFA\xFF\xF0\xFF\xFA\x2C\xFF\xF0"), TEXT(""));
    told(&self, TEXT("\xFF\xFA\x2C\x0D\x01\xFF\xF0\xFF\xFA\x18\x01\xFF\xF0"), TEXT(""));
    told(&self, TEXT("\xFF\xFA\x2C\x01\0\0\x25\xFF\xF0"), TEXT("")); /* too short */
    told(&self, TEXT("\xFF\xFA\x2C\x03\x02\xFF\xF1"), TEXT(""));     /* not ended */
    told(&self,
         TEXT("\xFF\xFA\x2C\x03\x02"
              "12345678901234567890\xFF\xF0"),
         TEXT(""));
    assert_int_equal(self.parity, 0);
    told(&self, TEXT("\xFF\xF1\xFF\xF6\xFF\xF0"), TEXT(""));
    told(&self, TEXT("\xFF\xFA\x2C\x03\x02\xFF\xFD\x03"), TEXT("\xFF\xFB\x03")); /* cut off */
    assert_int_equal(self.parity, 0);
    heard(&self, TEXT("x"), TEXT("x"));
}

static void characters_and_breaks(void **state)
{
    struct dg_rfc2217 self = {.baud = 0};
    (void)state;
    heard(&self, TEXT("\x40\x42\x02\0\r\n"), TEXT("\x40\x42\x02\0\r\n"));
    heard(&self,
          TEXT("a\xFF\xFF"
               "b"),
          TEXT("a\xFF"
               "b"));
    heard(&self,
          TEXT("a\xFF\xF3"
               "b"),
          TEXT("aBb"));
    heard(&self, TEXT("\xFF\xFA\x2C\x05\x05\xFF\xF0"), TEXT("B"));
}

/* A character that is right at any setting but for `line`. */
static size_t print_any(const struct dg_rfc2217 *self, uint8_t byte, uint8_t line, uint8_t *text)
{
    const struct dg_rfc2217_sound sound = {{DG_BAUD_ANY, 0}, byte, line};
    return dg_rfc2217_print(self, &sound, text);
}

static void characters_are_told_with_what_was_wrong(void **state)
{
    struct dg_rfc2217 self = {.baud = 0};
    uint8_t text[DG_RFC2217_TEXT_MAX];
    (void)state;
    assert_int_equal(print_any(&self, 'a', DG_RFC2217_PARITY, text), 1);
    assert_int_equal(print_any(&self, 0xFF, 0, text), 2);
    assert_memory_equal(text, "\xFF\xFF", 2);
    told(&self, TEXT("\xFF\xFA\x2C\x0A\x04\xFF\xF0"), TEXT("\xFF\xFA\x2C\x6E\x04\xFF\xF0"));
    assert_int_equal(print_any(&self, 'a', DG_RFC2217_FRAMING, text), 1);
    assert_int_equal(print_any(&self, 0xFF, DG_RFC2217_PARITY, text), 9);
    assert_memory_equal(text, "\xFF\xFA\x2C\x6A\x04\xFF\xF0\xFF\xFF", 9);
    told(&self, TEXT("\xFF\xFA\x2C\x08\xFF\xF0"), TEXT(""));
    assert_true(self.suspended);
    told(&self, TEXT("\xFF\xFA\x2C\x09\xFF\xF0"), TEXT(""));
    assert_false(self.suspended);
}

/* At another data rate nothing is left of a character; another format leaves its bits. */
static void clients_hear_at_their_own_setting(void **state)
{
    static const struct dg_rfc2217_sound sound = {{9600, 'E'}, 0xC1, 0};
    static const struct {
        struct dg_rfc2217 client;
        uint8_t line;
        uint8_t byte;
    } rows[] = {
        {{.baud = 0}, 0, 0xC1},
        {{.baud = 9600, .parity = 'E'}, 0, 0xC1},
        {{.baud = 9600, .parity = 'O'}, DG_RFC2217_PARITY, 0xC1},
        {{.parity = 'N'}, DG_RFC2217_PARITY, 0xC1},
        {{.baud = 19200, .parity = 'E'}, DG_RFC2217_FRAMING, 0},
        {{.baud = 9600, .data_bits = 8}, 0, 0xC1},
        {{.baud = 9600, .data_bits = 7}, DG_RFC2217_PARITY, 0x41},
        {{.data_bits = 6, .parity = 'E'}, DG_RFC2217_PARITY, 0x01},
    };
    uint8_t text[DG_RFC2217_TEXT_MAX];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct dg_rfc2217 client = rows[i].client;
        assert_int_equal(dg_rfc2217_print(&client, &sound, text), 1);
        assert_int_equal(text[0], rows[i].byte);
        client.line_mask = 0xFF;
        const size_t n = dg_rfc2217_print(&client, &sound, text);
        assert_int_equal(n, rows[i].line == 0 ? 1 : 8);
        assert_int_equal(rows[i].line == 0 ? 0 : text[4], rows[i].line);
        assert_int_equal(text[n - 1u], rows[i].byte);
    }
}

static void settings_of_a_uart(void **state)
{
    const struct dg_rfc2217 silent = {.baud = 0};
    const struct dg_rfc2217 seven = {.baud = 1200, .parity = 'E', .data_bits = 7};
    (void)state;
    assert_int_equal(dg_rfc2217_setting(&silent).baud, DG_BAUD_ANY);
    assert_int_equal(dg_rfc2217_setting(&silent).parity, 0);
    assert_int_equal(dg_rfc2217_setting(&seven).baud, 1200);
    assert_int_equal(dg_rfc2217_setting(&seven).parity, '?');
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_are_agreed_to_once),
        cmocka_unit_test(settings_are_kept_in_range),
        cmocka_unit_test(what_needs_nothing_is_acknowledged),
        cmocka_unit_test(what_is_no_command_is_nothing),
        cmocka_unit_test(characters_and_breaks),
        cmocka_unit_test(characters_are_told_with_what_was_wrong),
        cmocka_unit_test(clients_hear_at_their_own_setting),
        cmocka_unit_test(settings_of_a_uart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
