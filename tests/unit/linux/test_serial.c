/* SPDX-License-Identifier: MIT */
/* A port, and a master on its other side. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "serial.h"
#include "timer.h"

#define TURN_US 100000u

static const struct lx_say quiet = {.quiet = true};

/* Who has the port, and the descriptor of who talks to it. */
struct owner {
    sd_event *event;
    struct lx_serial *port;
    int master;
    size_t pause_after; /* characters; 0: never */
    unsigned backs;
    size_t count;
    char heard[64];
    size_t more[64];
};

static void keep_character(void *ctx, dg_ns now, const struct lx_character *character)
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

static void is_back(void *ctx)
{
    struct owner *self = ctx;
    self->backs++;
}

static struct lx_serial_setup setup_of(struct owner *self, const char *where)
{
    return (struct lx_serial_setup){
        .event = self->event,
        .say = &quiet,
        .where = where,
        .uart = {.baud = 9600, .parity = 'E'},
        .found_baud = 19200,
        .rx = keep_character,
        .back = is_back,
        .ctx = self,
    };
}

static void open_port(struct owner *self)
{
    struct lx_error error = {.right = ""};
    assert_true(sd_event_new(&self->event) >= 0);
    const struct lx_serial_setup setup = setup_of(self, NULL);
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
static void turn_loop(struct owner *self)
{
    while (sd_event_run(self->event, TURN_US) > 0) {
    }
}

static void turn_for(struct owner *self, dg_ns span)
{
    const dg_ns end = dg_after(lx_now(), span);
    while (lx_now() < end) {
        assert_true(sd_event_run(self->event, TURN_US) >= 0);
    }
}

static void send_text(struct owner *self, const char *text)
{
    assert_int_equal(write(self->master, text, strlen(text)), strlen(text));
}

static void what_follows_is_counted(void **state)
{
    struct owner self = {.count = 0};
    (void)state;
    open_port(&self);
    send_text(&self, "abc");
    turn_loop(&self);
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
    send_text(&self, "abcd");
    turn_loop(&self);
    assert_int_equal(self.count, 2);
    send_text(&self, "ef");
    turn_loop(&self);
    assert_int_equal(self.count, 2);
    self.pause_after = 3;
    lx_serial_pause(self.port, false);
    assert_int_equal(self.count, 3);
    turn_loop(&self);
    assert_int_equal(self.count, 3);
    lx_serial_pause(self.port, false);
    turn_loop(&self);
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

static void set_speed(int fd, speed_t speed, tcflag_t flags)
{
    struct termios line;
    assert_int_equal(tcgetattr(fd, &line), 0);
    line.c_cflag |= flags;
    assert_int_equal(cfsetispeed(&line, speed), 0);
    assert_int_equal(cfsetospeed(&line, speed), 0);
    assert_int_equal(tcsetattr(fd, TCSANOW, &line), 0);
}

/* A client that opens the port as it left it would be refused, did nothing change: CLOCAL does. */
static void a_pty_hears_how_fast_its_client_is(void **state)
{
    struct owner self = {.count = 0};
    struct termios line;
    (void)state;
    open_port(&self);
    send_text(&self, "a");
    turn_loop(&self);
    assert_int_equal(self.port->baud, 19200);
    set_speed(self.master, B38400, CLOCAL);
    turn_loop(&self);
    assert_int_equal(self.count, 1); /* what was set is no character */
    assert_int_equal(tcgetattr(self.master, &line), 0);
    assert_int_equal(line.c_cflag & (CLOCAL | CREAD), CREAD);
    assert_int_equal(cfgetospeed(&line), B38400);
    send_text(&self, "b");
    turn_loop(&self);
    assert_int_equal(self.port->baud, 38400);
    set_speed(self.master, B134, 0);
    send_text(&self, "c");
    turn_loop(&self);
    assert_int_equal(self.port->baud, 0); /* none that an encoder has */
    assert_memory_equal(self.heard, "abc", 3);
    self.port->setup.any_line = true;
    send_text(&self, "d");
    turn_loop(&self);
    assert_true(self.port->baud == LX_BAUD_ANY);
    close_port(&self);
}

/* --- a link to a pty --- */

/* A pty of our own, on whose slave side the port is. */
static int make_pty(char slave[64])
{
    const int fd = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    assert_true(fd >= 0);
    assert_int_equal(grantpt(fd), 0);
    assert_int_equal(unlockpt(fd), 0);
    assert_int_equal(ptsname_r(fd, slave, 64), 0);
    return fd;
}

/* Refused, with these words. */
static void is_refused(struct owner *self, const char *link, const char *what, const char *right)
{
    struct lx_error error = {.what = "", .right = ""};
    const struct lx_serial_setup setup = setup_of(self, link);
    assert_null(lx_pty_open(&setup, &error));
    assert_string_equal(error.what, what);
    assert_string_equal(error.right, right);
}

static void a_link_leads_to_one_pty(void **state)
{
    char folder[] = "/tmp/test_serial.XXXXXX";
    char link[64];
    char target[64] = "";
    char taken[64];
    struct owner self = {.count = 0};
    struct lx_error error;
    (void)state;
    assert_non_null(mkdtemp(folder));
    assert_true(sd_event_new(&self.event) >= 0);
    (void)snprintf(link, sizeof link, "%s/link", folder);
    (void)snprintf(taken, sizeof taken, "in use by process %ld", (long)getpid());
    assert_int_equal(symlink("/dev/pts/none", link), 0); /* what a run has left behind */
    const struct lx_serial_setup setup = setup_of(&self, link);
    self.port = lx_pty_open(&setup, &error);
    assert_non_null(self.port);
    assert_int_equal(readlink(link, target, sizeof target - 1), strlen(self.port->address));
    assert_string_equal(target, self.port->address);
    is_refused(&self, link, taken, "give another name");
    assert_int_equal(access(link, F_OK), 0);
    lx_serial_close(self.port);
    assert_int_equal(access(link, F_OK), -1);
    assert_int_equal(mkdir(link, 0700), 0);
    is_refused(&self, link, "exists and is not a link to a pty", "remove it or give another name");
    assert_int_equal(rmdir(link), 0);
    assert_int_equal(rmdir(folder), 0);
    is_refused(&self, link, "cannot make the link: No such file or directory", "");
    (void)sd_event_unref(self.event);
}

/* Also where it has taken the place of ours meanwhile. A link to a pty that nobody holds was left
   behind, and its number is somebody else's now. */
static void a_link_of_somebody_else_stays(void **state)
{
    char folder[] = "/tmp/test_serial.XXXXXX";
    char link[64];
    char target[LX_ADDRESS_MAX] = "";
    char slave[64];
    struct owner self = {.count = 0};
    struct lx_error error;
    (void)state;
    assert_non_null(mkdtemp(folder));
    assert_true(sd_event_new(&self.event) >= 0);
    (void)snprintf(link, sizeof link, "%s/link", folder);
    const struct lx_serial_setup setup = setup_of(&self, link);
    assert_int_equal(symlink("/dev/null", link), 0);
    is_refused(&self, link, "exists and is not a link to a pty", "remove it or give another name");
    assert_int_equal(unlink(link), 0);
    self.master = make_pty(slave);
    assert_int_equal(symlink(slave, link), 0);
    self.port = lx_pty_open(&setup, &error);
    assert_non_null(self.port);
    assert_true(readlink(link, target, sizeof target - 1) > 0);
    assert_string_equal(target, self.port->address);
    assert_int_equal(unlink(link), 0);
    assert_int_equal(symlink(slave, link), 0);
    lx_serial_close(self.port);
    assert_int_equal(unlink(link), 0); /* it is there */
    assert_int_equal(rmdir(folder), 0);
    (void)close(self.master);
    (void)sd_event_unref(self.event);
}

/* --- somebody else's port --- */

static void open_tty(struct owner *self, const char *path)
{
    struct lx_error error = {.what = ""};
    assert_true(sd_event_new(&self->event) >= 0);
    const struct lx_serial_setup setup = setup_of(self, path);
    self->port = lx_tty_open(&setup, &error);
    assert_string_equal(error.what, "");
    assert_non_null(self->port);
}

/* As a terminal has it, and worse. */
static void mess_up(int fd)
{
    struct termios line;
    assert_int_equal(tcgetattr(fd, &line), 0);
    line.c_iflag |= IGNPAR | IGNBRK | BRKINT | IXON | IXOFF | ICRNL | ISTRIP;
    line.c_lflag |= ICANON | ECHO | ISIG;
    line.c_oflag |= OPOST | ONLCR;
    line.c_cflag |= CSTOPB | CRTSCTS | PARODD;
    line.c_cflag &= ~(tcflag_t)(CLOCAL | CREAD);
    line.c_cc[VMIN] = 0;
    line.c_cc[VTIME] = 5;
    assert_int_equal(tcsetattr(fd, TCSANOW, &line), 0);
}

/* Raw as cfmakeraw() has it, and damage is marked (PARMRK, INPCK): termios(3). */
static void is_set_to(int fd, speed_t speed, bool odd)
{
    struct termios line;
    assert_int_equal(tcgetattr(fd, &line), 0);
    assert_int_equal(line.c_iflag & (IGNPAR | IGNBRK | BRKINT | IXON | IXOFF | ICRNL | ISTRIP), 0);
    assert_int_equal(line.c_iflag & (INPCK | PARMRK), INPCK | PARMRK);
    assert_int_equal(line.c_lflag & (ICANON | ECHO | ISIG), 0);
    assert_int_equal(line.c_oflag & OPOST, 0);
    assert_int_equal(line.c_cflag & (CSTOPB | CRTSCTS), 0);
    assert_int_equal(line.c_cflag & (CLOCAL | CREAD), CLOCAL | CREAD);
    assert_int_equal(line.c_cflag & PARODD, odd ? PARODD : 0);
    assert_int_equal(line.c_cc[VMIN], 1);
    assert_int_equal(line.c_cc[VTIME], 0);
    assert_int_equal(cfgetospeed(&line), speed);
    assert_int_equal(cfgetispeed(&line), speed);
}

static void a_uart_is_set_up_and_its_characters_are_heard(void **state)
{
    struct owner self = {.count = 0};
    char slave[64];
    (void)state;
    self.master = make_pty(slave);
    mess_up(self.master);
    send_text(&self, "old");
    open_tty(&self, slave);
    is_set_to(self.master, B9600, false);
    assert_false(self.port->timed);
    send_text(&self, "a\xFF\xFF\x11\r"); /* also what is special to PARMRK and to terminals */
    turn_loop(&self);
    assert_int_equal(self.count, 5);
    assert_memory_equal(self.heard, "a\xFF\xFF\x11\r", 5);
    assert_int_equal(self.port->baud, 9600);
    assert_int_equal(self.port->parity, 'E');
    lx_serial_set(self.port, &(struct lx_uart){.baud = 38400, .parity = 'O'});
    is_set_to(self.master, B38400, true);
    send_text(&self, "b");
    turn_loop(&self);
    assert_int_equal(self.port->baud, 38400);
    assert_int_equal(self.port->parity, 'O');
    lx_serial_set(self.port, &(struct lx_uart){.baud = 9600, .parity = 'N'});
    is_set_to(self.master, B9600, false);
    close_port(&self);
}

static void what_is_no_uart_is_refused(void **state)
{
    static const struct {
        const char *path;
        const char *what;
        const char *right;
    } rows[] = {
        {"/dev/null", "not a serial port", "expected a serial port such as /dev/ttyUSB0"},
        {"/dev/none", "cannot use it at 9600 Bd 8E1: No such file or directory", ""},
    };
    struct owner self = {.count = 0};
    struct lx_error error;
    char path[2u * LX_ADDRESS_MAX];
    (void)state;
    assert_true(sd_event_new(&self.event) >= 0);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct lx_serial_setup setup = setup_of(&self, rows[i].path);
        error = (struct lx_error){.what = "", .right = ""};
        assert_null(lx_tty_open(&setup, &error));
        assert_string_equal(error.what, rows[i].what);
        assert_string_equal(error.right, rows[i].right);
    }
    memset(path, '/', sizeof path);
    path[LX_ADDRESS_MAX] = '\0';
    const struct lx_serial_setup setup = setup_of(&self, path);
    error = (struct lx_error){.what = "", .right = ""};
    assert_null(lx_tty_open(&setup, &error));
    assert_string_equal(error.what, "the path is too long");
    (void)sd_event_unref(self.event);
}

/* Under its own name a pty may be anybody's next time; a link is put right by whoever made it. */
static void a_port_behind_a_link_is_looked_for(void **state)
{
    char folder[] = "/tmp/test_serial.XXXXXX";
    char link[64];
    char slave[64];
    (void)state;
    assert_non_null(mkdtemp(folder));
    (void)snprintf(link, sizeof link, "%s/link", folder);
    for (unsigned linked = 0; linked < 2; linked++) {
        struct owner self = {.count = 0};
        self.master = make_pty(slave);
        assert_int_equal(symlink(slave, link), 0);
        open_tty(&self, linked ? link : slave);
        assert_int_equal(close(self.master), 0);
        turn_loop(&self);
        assert_false(lx_serial_up(self.port));
        assert_int_equal(lx_serial_send(self.port, (const uint8_t *)"x", 1), 0);
        assert_int_equal(unlink(link), 0);
        assert_int_equal(symlink("/dev/null", link), 0); /* no port: it is looked for again */
        turn_for(&self, linked ? DG_MS(1200) : 0);
        self.master = make_pty(slave);
        assert_int_equal(unlink(link), 0);
        assert_int_equal(symlink(slave, link), 0);
        const dg_ns end = dg_after(lx_now(), DG_MS(linked ? 5000 : 1200));
        while (self.backs == 0 && lx_now() < end) {
            assert_true(sd_event_run(self.event, TURN_US) >= 0);
        }
        assert_int_equal(self.backs, linked);
        assert_int_equal(lx_serial_up(self.port), linked);
        send_text(&self, "a");
        turn_loop(&self);
        assert_int_equal(self.count, linked);
        assert_int_equal(unlink(link), 0);
        close_port(&self);
    }
    assert_int_equal(rmdir(folder), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_follows_is_counted),
        cmocka_unit_test(a_paused_port_keeps_the_rest),
        cmocka_unit_test(a_port_sends_what_there_is_room_for),
        cmocka_unit_test(a_pty_is_found_with_its_data_rate),
        cmocka_unit_test(a_pty_hears_how_fast_its_client_is),
        cmocka_unit_test(a_link_leads_to_one_pty),
        cmocka_unit_test(a_link_of_somebody_else_stays),
        cmocka_unit_test(a_uart_is_set_up_and_its_characters_are_heard),
        cmocka_unit_test(what_is_no_uart_is_refused),
        cmocka_unit_test(a_port_behind_a_link_is_looked_for),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
