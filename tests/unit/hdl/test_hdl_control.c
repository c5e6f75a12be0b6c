/* SPDX-License-Identifier: MIT */
/*
 * The control socket of an encoder for simulators: lines and answers, a command that waits for the
 * simulation, one client behind the other, what is not replaced.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmocka.h>

#include "hdl.h"

#define US INT64_C(1000000)
#define LOOKS_MAX 10000u

static char folder[] = "/tmp/hdl_control_XXXXXX";
static char path[64];
static char settings[80];

static int make_folder(void **state)
{
    (void)state;
    if (mkdtemp(folder) == NULL) {
        return -1;
    }
    (void)snprintf(path, sizeof path, "%s/c.sock", folder);
    (void)snprintf(settings, sizeof settings, "control=unix:%s", path);
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    return rmdir(folder);
}

/* A simulator that is idle: it looks when it is told to. */
struct sim {
    struct dg_hdl *encoder;
    int64_t now;
};

static struct sim begin(void)
{
    struct sim self = {.encoder = dg_hdl_open("s3684-biss", settings, "90DEG", "")};

    assert_non_null(self.encoder);
    assert_string_equal(dg_hdl_error(self.encoder), "");
    return self;
}

static void look_at_wires(struct sim *self)
{
    const int64_t next = dg_hdl_next(self->encoder);

    assert_true(next > self->now && next <= self->now + 100 * US);
    self->now = next;
    (void)dg_hdl_wires(self->encoder, self->now, DG_HDL_CLOCK);
    (void)usleep(1000);
}

static int connect_to(void)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0);

    (void)snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    return fd;
}

static void send_text(int fd, const char *text)
{
    assert_int_equal(send(fd, text, strlen(text), MSG_NOSIGNAL), (ssize_t)strlen(text));
}

/* Simulate until `text` has come; nothing else may have. */
static void expect(struct sim *self, int fd, const char *text)
{
    char got[256] = "";
    size_t n = 0;

    for (unsigned i = 0; i < LOOKS_MAX && n < strlen(text); i++) {
        look_at_wires(self);
        const ssize_t more = recv(fd, got + n, sizeof got - 1u - n, 0);
        n += more > 0 ? (size_t)more : 0;
    }
    assert_string_equal(got, text);
}

static void expect_end(struct sim *self, int fd)
{
    char byte;
    ssize_t n = -1;

    for (unsigned i = 0; i < LOOKS_MAX && n < 0; i++) {
        look_at_wires(self);
        n = recv(fd, &byte, 1, 0);
        n = n < 0 && errno == ECONNRESET ? 0 : n; /* not all of it was read */
    }
    assert_int_equal(n, 0);
    (void)close(fd);
}

static void lines_are_answered(void **state)
{
    struct sim sim = begin();
    struct stat info;
    const int fd = connect_to();

    (void)state;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0600);
    send_text(fd, "SHAF:POS?\r\nSHAF:POS 4");
    expect(&sim, fd, "90.000000\n");
    send_text(fd, "5\nNONSENSE\n\nSHAF:POS?\rSYST:ERR?;ERR?\n");
    expect(&sim, fd,
           "45.000000\n-113,\"Undefined header;NONSENSE; SYSTem:HELP? has all\";0,\"No error\"\n");
    assert_int_equal(dg_hdl_position(sim.encoder, sim.now), 1 << 18);
    send_text(fd, "FAUL:SET wire_drop\nFAUL:ACT?\n");
    (void)shutdown(fd, SHUT_WR);
    expect(&sim, fd, "\"wire_drop\"\n");
    expect_end(&sim, fd);
    dg_hdl_close(sim.encoder);
    assert_int_not_equal(stat(path, &info), 0);
}

/* 25 ms of the simulation; what comes behind waits. */
static void a_command_waits_for_the_simulation(void **state)
{
    struct sim sim = begin();
    const int fd = connect_to();

    (void)state;
    send_text(fd, "SHAF:POS 0;MOVE 90,600RPM;*OPC?\nSHAF:POS?\n");
    expect(&sim, fd, "1\n90.000000\n");
    assert_true(sim.now >= 25000 * US);
    send_text(fd, "SHAF:MOVE 180,600RPM;*OPC?\n");
    expect(&sim, fd, "1\n");
    (void)close(fd);
    dg_hdl_close(sim.encoder);
}

static void the_next_client_finds_an_empty_session(void **state)
{
    struct sim sim = begin();
    const int one = connect_to();
    const int two = connect_to();

    (void)state;
    send_text(two, "SYST:ERR?\n");
    send_text(one, "NONSENSE\n*IDN?;*OPC?\n");
    for (unsigned i = 0; i < 20; i++) {
        look_at_wires(&sim);
    }
    (void)close(one); /* it does not wait for its answers */
    expect(&sim, two, "0,\"No error\"\n");
    (void)close(two);
    dg_hdl_close(sim.encoder);
}

static void a_line_without_an_end_ends_the_connection(void **state)
{
    struct sim sim = begin();
    const int fd = connect_to();
    char line[2048];

    (void)state;
    memset(line, 'A', sizeof line);
    assert_int_equal(send(fd, line, sizeof line, MSG_NOSIGNAL), (ssize_t)sizeof line);
    expect_end(&sim, fd);
    dg_hdl_close(sim.encoder);
}

static void a_socket_in_use_is_left_alone(void **state)
{
    struct sim sim = begin();
    struct dg_hdl *other = dg_hdl_open("ssi-25", settings, "", "");

    (void)state;
    assert_non_null(strstr(dg_hdl_error(other), "in use already"));
    dg_hdl_close(other);
    const int fd = connect_to();
    send_text(fd, "SHAF:POS?\n");
    expect(&sim, fd, "90.000000\n");
    (void)close(fd);
    dg_hdl_close(sim.encoder);
    /* One that nobody listens at is replaced. */
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    (void)snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
    const int dead = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(dead, (const struct sockaddr *)&address, sizeof address), 0);
    (void)close(dead);
    sim = begin();
    dg_hdl_close(sim.encoder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_are_answered),
        cmocka_unit_test(a_command_waits_for_the_simulation),
        cmocka_unit_test(the_next_client_finds_an_empty_session),
        cmocka_unit_test(a_line_without_an_end_ends_the_connection),
        cmocka_unit_test(a_socket_in_use_is_left_alone),
    };

    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
