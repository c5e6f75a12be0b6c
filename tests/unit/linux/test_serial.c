/* SPDX-License-Identifier: MIT */
/* A port, and a master on its other side. */
#include <fcntl.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#include <cmocka.h>

#include "serial.h"

#define TURN_US 100000u

static const struct lx_say quiet = {.quiet = true};

/* Who has the port, and the descriptor of who talks to it. */
struct owner {
    sd_event *event;
    struct lx_serial *port;
    int master;
    size_t pause_after; /* characters; 0: never */
    size_t count;
    char heard[64];
    size_t more[64];
};

static void hear(void *ctx, dg_ns now, const struct lx_character *character)
{
    struct owner *self = ctx;
    (void)now;
    assert_false(character->damaged);
    assert_true(self->count < sizeof self->heard);
    self->more[self->count] = self->port->more;
    self->heard[self->count++] = (char)character->byte;
    if (self->count == self->pause_after) {
        lx_serial_pause(self->port, true);
    }
}

static void open_port(struct owner *self)
{
    struct lx_error error = {.right = ""};
    assert_true(sd_event_new(&self->event) >= 0);
    const struct lx_serial_setup setup = {
        .event = self->event,
        .say = &quiet,
        .uart = {.baud = 9600, .parity = 'E'},
        .found_baud = 19200,
        .rx = hear,
        .ctx = self,
    };
    self->port = lx_pty_open(&setup, &error);
    assert_non_null(self->port);
    self->master = open(self->port->address, O_RDWR | O_NOCTTY | O_NONBLOCK);
    assert_true(self->master >= 0);
}

static void close_port(struct owner *self)
{
    (void)close(self->master);
    lx_serial_close(self->port);
    (void)sd_event_unref(self->event);
}

/* Until nothing more happens. */
static void turn(struct owner *self)
{
    while (sd_event_run(self->event, TURN_US) > 0) {
    }
}

static void say(struct owner *self, const char *text)
{
    assert_int_equal(write(self->master, text, strlen(text)), strlen(text));
}

static void what_follows_is_counted(void **state)
{
    struct owner self = {.count = 0};
    (void)state;
    open_port(&self);
    say(&self, "abc");
    turn(&self);
    assert_int_equal(self.count, 3);
    assert_memory_equal(self.heard, "abc", 3);
    assert_true(self.more[0] == 2 && self.more[1] == 1 && self.more[2] == 0);
    close_port(&self);
}

/* In the middle of what was read at once: the rest waits, and what comes behind it, too. */
static void a_paused_port_keeps_the_rest(void **state)
{
    struct owner self = {.pause_after = 2};
    (void)state;
    open_port(&self);
    say(&self, "abcd");
    turn(&self);
    assert_int_equal(self.count, 2);
    say(&self, "ef");
    turn(&self);
    assert_int_equal(self.count, 2);
    self.pause_after = 3;
    lx_serial_pause(self.port, false);
    assert_int_equal(self.count, 3);
    turn(&self);
    assert_int_equal(self.count, 3);
    lx_serial_pause(self.port, false);
    turn(&self);
    assert_int_equal(self.count, 6);
    assert_memory_equal(self.heard, "abcdef", 6);
    close_port(&self);
}

static void a_port_sends_what_there_is_room_for(void **state)
{
    static const uint8_t flood[1u << 18];
    struct owner self = {.count = 0};
    char got[4];
    (void)state;
    open_port(&self);
    assert_true(lx_serial_up(self.port));
    assert_int_equal(lx_serial_send(self.port, (const uint8_t *)"xyz", 3), 3);
    struct pollfd io = {.fd = self.master, .events = POLLIN};
    assert_int_equal(poll(&io, 1, 1000), 1);
    assert_int_equal(read(self.master, got, sizeof got), 3);
    assert_memory_equal(got, "xyz", 3);
    const size_t sent = lx_serial_send(self.port, flood, sizeof flood);
    assert_true(sent > 0 && sent < sizeof flood);
    assert_int_equal(self.port->counters.lost, 0);
    lx_serial_put(self.port, flood, sizeof flood);
    assert_true(self.port->counters.lost > 0);
    close_port(&self);
}

static void a_pty_is_found_with_its_data_rate(void **state)
{
    struct owner self = {.count = 0};
    struct termios line;
    (void)state;
    open_port(&self);
    assert_int_equal(tcgetattr(self.master, &line), 0);
    assert_int_equal(cfgetospeed(&line), B19200);
    close_port(&self);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_follows_is_counted),
        cmocka_unit_test(a_paused_port_keeps_the_rest),
        cmocka_unit_test(a_port_sends_what_there_is_room_for),
        cmocka_unit_test(a_pty_is_found_with_its_data_rate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
