/* SPDX-License-Identifier: MIT */
/* Messages as doc/protocol.md of socketcand prints them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "socketcand.h"

#define UNKNOWN "< error unknown command >"
#define BAD_SEND "< error syntax error in send command >"

/* The event of the one message in `text`. */
static struct lx_socketcand_event send_text(struct lx_socketcand *self, const char *text)
{
    struct lx_socketcand_event event = {.reply = "nothing"};
    unsigned messages = 0;
    for (const char *at = text; *at != '\0'; at++) {
        messages += lx_socketcand_feed(self, "can0", (uint8_t)*at, &event) ? 1u : 0u;
    }
    assert_int_equal(messages, 1);
    return event;
}

static void modes(void **state)
{
    static const struct {
        const char *message;
        const char *reply;
        enum lx_socketcand_mode mode;
    } rows[] = {
        {"< echo >", "< echo >", LX_SOCKETCAND_NO_BUS},
        {"< rawmode >", UNKNOWN, LX_SOCKETCAND_NO_BUS},
        {"< send 123 0 >", UNKNOWN, LX_SOCKETCAND_NO_BUS},
        {"< open can1 >", "< error could not open bus >", LX_SOCKETCAND_NO_BUS},
        {"< open can0 x >", UNKNOWN, LX_SOCKETCAND_NO_BUS},
        {"junk > < open\tcan0\r\n>", "< ok >", LX_SOCKETCAND_BCM},
        {"< open can0 >", UNKNOWN, LX_SOCKETCAND_BCM},
        {"< rawmode >", "< ok >", LX_SOCKETCAND_RAW},
        {"< subscribe 0 0 123 >", UNKNOWN, LX_SOCKETCAND_RAW},
        {"< bcmmode >", "< ok >", LX_SOCKETCAND_BCM},
        {"< add 1 0 123 0 >", UNKNOWN, LX_SOCKETCAND_BCM},
        {"<>", UNKNOWN, LX_SOCKETCAND_BCM},
        {"< echo < echo >", "< echo >", LX_SOCKETCAND_BCM},
        {"< 1 2 3 4 5 6 7 8 9 10 11 12 >", UNKNOWN, LX_SOCKETCAND_BCM},
    };
    struct lx_socketcand self = {.mode = LX_SOCKETCAND_NO_BUS};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct lx_socketcand_event event = send_text(&self, rows[i].message);
        assert_string_equal(event.reply, rows[i].reply);
        assert_int_equal(self.mode, rows[i].mode);
        assert_false(event.has_frame);
    }
}

static void frames_that_are_sent(void **state)
{
    struct lx_socketcand self = {.mode = LX_SOCKETCAND_RAW};
    (void)state;
    struct lx_socketcand_event event = send_text(&self, "< send 1AA 8 11 22 33 44 55 66 77 88 >");
    assert_true(event.has_frame && !event.frame.extended && event.reply == NULL);
    assert_int_equal(event.frame.id, 0x1AA);
    assert_int_equal(event.frame.frame.id, 0x1AA);
    assert_int_equal(event.frame.frame.dlc, 8);
    assert_memory_equal(event.frame.frame.data, "\x11\x22\x33\x44\x55\x66\x77\x88", 8);
    event = send_text(&self, "< send 7 1 f >");
    assert_int_equal(event.frame.id, 7);
    assert_int_equal(event.frame.frame.data[0], 0x0F);
    event = send_text(&self, "< send 000001AA 0  >");
    assert_true(event.has_frame && event.frame.extended);
    assert_int_equal(event.frame.id, 0x1AA);
}

static void frames_that_are_none(void **state)
{
    static const char *const messages[] = {
        "< send 800 0 >",    "< send 20000000 0 >", "< send 123456789 0 >", "< send x 0 >",
        "< send 123 9 >",    "< send 123 1 >",      "< send 123 1 1 2 >",   "< send 123 1 100 >",
        "< send 123 1 -1 >", "< send 0x1 0 >",      "< send 123 1 g >",
    };
    struct lx_socketcand self = {.mode = LX_SOCKETCAND_BCM};
    char overlong[200];
    (void)state;
    for (size_t i = 0; i < DG_COUNT(messages); i++) {
        const struct lx_socketcand_event event = send_text(&self, messages[i]);
        assert_string_equal(event.reply, BAD_SEND);
        assert_false(event.has_frame);
    }
    memset(overlong, ' ', sizeof overlong);
    memcpy(overlong, "< send 123 0", 12);
    memcpy(overlong + sizeof overlong - 2, ">", 2);
    assert_string_equal(send_text(&self, overlong).reply, UNKNOWN);
    assert_true(send_text(&self, "< send 123 0 >").has_frame);
}

static void who_wants_what(void **state)
{
    struct lx_socketcand self = {.mode = LX_SOCKETCAND_BCM};
    const struct lx_can_wide frame = {.id = 0x5BF};
    const struct lx_can_wide other = {.id = 0x5BE};
    const struct lx_can_wide extended = {.extended = true, .id = 0x1ABCDE01};
    const struct lx_can_wide remote = {.id = 0x5BF, .frame = {.rtr = true}};
    (void)state;
    assert_false(lx_socketcand_wants(&self, &frame));
    assert_null(send_text(&self, "< subscribe 0 0 5BF >").reply);
    assert_true(lx_socketcand_wants(&self, &frame));
    assert_false(lx_socketcand_wants(&self, &other));
    assert_false(lx_socketcand_wants(&self, &extended));
    assert_null(send_text(&self, "< unsubscribe 5BF >").reply);
    assert_false(lx_socketcand_wants(&self, &frame));
    assert_string_equal(send_text(&self, "< subscribe 0 0 800 >").reply,
                        "< error syntax error in subscription >");
    (void)send_text(&self, "< rawmode >");
    assert_true(lx_socketcand_wants(&self, &frame) && lx_socketcand_wants(&self, &extended));
    assert_false(lx_socketcand_wants(&self, &remote));
}

static void frames_that_are_told(void **state)
{
    char text[LX_SOCKETCAND_TEXT_MAX];
    struct lx_can_wide frame = {.id = 0x80, .frame = {.dlc = 0}};
    (void)state;
    size_t n = lx_socketcand_print(&frame, DG_S(23) + DG_US(424242), text);
    assert_int_equal(n, strlen(text));
    assert_string_equal(text, "< frame 080 23.424242  >");
    frame = (struct lx_can_wide){
        .extended = true, .id = 0x123, .frame = {.dlc = 2, .data = {0x11, 0xAA}}};
    n = lx_socketcand_print(&frame, DG_US(1), text);
    assert_int_equal(n, strlen(text));
    assert_string_equal(text, "< frame 00000123 0.000001 11AA >");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(modes),
        cmocka_unit_test(frames_that_are_sent),
        cmocka_unit_test(frames_that_are_none),
        cmocka_unit_test(who_wants_what),
        cmocka_unit_test(frames_that_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
