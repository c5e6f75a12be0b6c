/* SPDX-License-Identifier: MIT */
/* Wires on TCP ports, with clients on the other side of real connections. */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmocka.h>

#include "access.h"
#include "can.h"
#include "descriptors.h"
#include "peers.h"
#include "serial.h"

#define TURN_US 50000u
#define IDLE_TURNS 40u /* two seconds */
#define CLIENTS 3u

static const struct lx_say quiet = {.quiet = true};

/* A wire of either sort, and its clients. */
struct bench {
    sd_event *event;
    struct lx_can *can;
    struct lx_serial *port;
    int client[CLIENTS];
    unsigned frames;
    struct dg_can_frame frame; /* the last one that came in */
    unsigned settled;          /* so often the bus was looked at */
    size_t count;
    uint8_t heard[32];
};

static void on_frame(void *ctx, dg_ns now, const struct dg_can_frame *frame)
{
    struct bench *self = ctx;
    (void)now;
    self->frames++;
    self->frame = *frame;
}

static void on_foreign(void *ctx, uint32_t bits)
{
    (void)ctx;
    (void)bits;
}

static void settle_wire(void *ctx, dg_ns now)
{
    struct bench *self = ctx;
    (void)now;
    self->settled++;
    if (self->can != NULL) {
        self->can->ops->push(self->can);
    }
}

static void on_character(void *ctx, dg_ns now, const struct lx_character *character)
{
    struct bench *self = ctx;
    (void)now;
    assert_true(self->count < sizeof self->heard);
    self->heard[self->count++] = character->byte;
}

/* Until nothing more happens. */
static void turn_loop(const struct bench *self)
{
    while (sd_event_run(self->event, TURN_US) > 0) {
    }
}

static int join(const struct bench *self, const char *address)
{
    const struct sockaddr_in to = {
        .sin_family = AF_INET,
        .sin_port = htons((uint16_t)strtoul(strrchr(address, ':') + 1, NULL, 10)),
        .sin_addr.s_addr = htonl(INADDR_LOOPBACK),
    };
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&to, sizeof to), 0);
    turn_loop(self);
    return fd;
}

static void send_text(const struct bench *self, unsigned client, const char *text, size_t n)
{
    assert_int_equal(send(self->client[client], text, n, MSG_NOSIGNAL), n);
    turn_loop(self);
}

#define SAY(self, client, text) send_text(self, client, text, sizeof(text) - 1u)

static void hears(const struct bench *self, unsigned client, const char *text, size_t n)
{
    char got[256];
    const ssize_t length = recv(self->client[client], got, sizeof got, MSG_DONTWAIT);
    assert_int_equal(length, n == 0 ? -1 : (ssize_t)n);
    assert_memory_equal(got, text, n);
}

#define HEARS(self, client, text) hears(self, client, text, sizeof(text) - 1u)

static void open_can(struct bench *self, lx_can_open *open, const char *where)
{
    struct lx_error error = {.what = ""};
    *self = (struct bench){.event = NULL};
    assert_true(sd_event_new(&self->event) >= 0);
    const struct lx_can_setup setup = {.event = self->event,
                                       .say = &quiet,
                                       .where = where,
                                       .rx = on_frame,
                                       .foreign = on_foreign,
                                       .settle = settle_wire,
                                       .ctx = self};
    self->can = open(&setup, &error);
    assert_non_null(self->can);
    self->can->ops->expect(self->can, 250);
    for (size_t i = 0; i < CLIENTS; i++) {
        self->client[i] = join(self, self->can->address);
    }
}

static void open_port(struct bench *self, const char *where)
{
    struct lx_error error = {.what = ""};
    *self = (struct bench){.event = NULL};
    assert_true(sd_event_new(&self->event) >= 0);
    const struct lx_serial_setup setup = {.event = self->event,
                                          .say = &quiet,
                                          .where = where,
                                          .uart = {.baud = 9600, .parity = 'E'},
                                          .found_baud = 9600,
                                          .rx = on_character,
                                          .ctx = self};
    self->port = lx_net_port_open(&setup, &error);
    assert_non_null(self->port);
    for (size_t i = 0; i < CLIENTS; i++) {
        self->client[i] = join(self, self->port->address);
    }
}

static void end(struct bench *self)
{
    for (size_t i = 0; i < CLIENTS; i++) {
        (void)close(self->client[i]);
    }
    turn_loop(self);
    lx_can_close(self->can);
    lx_serial_close(self->port);
    (void)sd_event_unref(self->event);
}

static void slcan_adapters_share_a_bus(void **state)
{
    const struct dg_can_frame frame = {.id = 0x5BF, .dlc = 1, .data = {0x43}};
    struct bench bench;
    (void)state;
    open_can(&bench, lx_slcan_open, "tcp:127.0.0.1:0");
    assert_false(bench.can->ops->open(bench.can));
    SAY(&bench, 0, "S6\rO\r"); /* another bit rate, as long as it is alone */
    assert_true(bench.can->ops->open(bench.can));
    assert_int_equal(bench.can->ops->bit_rate(bench.can), 500000);
    SAY(&bench, 1, "S5\rO\r");
    SAY(&bench, 2, "S5\rZ1\rO\r");
    assert_true(bench.can->ops->open(bench.can));
    assert_int_equal(bench.can->ops->bit_rate(bench.can), 250000);
    HEARS(&bench, 0, "\r\r");
    HEARS(&bench, 1, "\r\r");
    HEARS(&bench, 2, "\r\r\r");
    SAY(&bench, 0, "t1230\r");
    HEARS(&bench, 0, "z\r");
    HEARS(&bench, 1, "");
    SAY(&bench, 2, "t1231aa\rT1ABCDE010\r");
    HEARS(&bench, 2, "z\rZ\r");
    HEARS(&bench, 1, "t1231AA\rT1ABCDE010\r");
    assert_int_equal(bench.frames, 1);
    assert_int_equal(bench.frame.id, 0x123);
    lx_can_send(bench.can, &frame);
    bench.can->ops->push(bench.can);
    HEARS(&bench, 0, "");
    HEARS(&bench, 1, "t5BF143\r");
    bench.can->ops->pause(bench.can, true);
    SAY(&bench, 1, "t1240\r");
    assert_int_equal(bench.frames, 1);
    bench.can->ops->pause(bench.can, false);
    turn_loop(&bench);
    assert_int_equal(bench.frames, 2);
    end(&bench);
}

static void socketcand_clients_share_a_bus(void **state)
{
    const struct dg_can_frame frame = {.id = 0x5BF, .dlc = 1, .data = {0x43}};
    struct bench bench;
    (void)state;
    open_can(&bench, lx_socketcand_open, "127.0.0.1:0,can1");
    assert_non_null(strstr(bench.can->address, ",can1"));
    lx_can_send(bench.can, &frame);
    assert_int_equal(bench.can->counters.lost, 1);
    SAY(&bench, 0, "< open can1 >< rawmode >");
    SAY(&bench, 1, "< open can1 >");
    HEARS(&bench, 0, "< hi >< ok >< ok >");
    HEARS(&bench, 1, "< hi >< ok >");
    SAY(&bench, 1, "< send 123 1 aa >< send 1ABCDE01 0 >");
    assert_int_equal(bench.frames, 1);
    HEARS(&bench, 1, "");
    HEARS(&bench, 2, "< hi >");
    char got[128] = "";
    assert_true(recv(bench.client[0], got, sizeof got - 1u, MSG_DONTWAIT) > 0);
    assert_non_null(strstr(got, "< frame 123 "));
    assert_non_null(strstr(got, "< frame 1ABCDE01 "));
    end(&bench);
}

/* An encoder whose master is gone is acknowledged by nobody. */
static void a_bus_is_looked_at_when_a_client_leaves(void **state)
{
    struct bench bench;
    (void)state;
    open_can(&bench, lx_slcan_open, "tcp:127.0.0.1:0");
    SAY(&bench, 0, "S5\rO\r");
    assert_true(bench.can->ops->open(bench.can));
    bench.settled = 0;
    (void)close(bench.client[0]);
    turn_loop(&bench);
    assert_false(bench.can->ops->open(bench.can));
    assert_int_equal(bench.settled, 1);
    bench.client[0] = -1;
    end(&bench);
}

static void bytes_go_to_all_others(void **state)
{
    struct bench bench;
    (void)state;
    open_port(&bench, "tcp:127.0.0.1:0");
    SAY(&bench, 0, "\x40\x42\x02");
    assert_int_equal(bench.count, 3);
    assert_int_equal(bench.port->baud, LX_BAUD_ANY);
    HEARS(&bench, 0, "");
    HEARS(&bench, 1, "\x40\x42\x02");
    lx_serial_put(bench.port, (const uint8_t *)"ab", 2);
    HEARS(&bench, 0, "ab");
    HEARS(&bench, 2,
          "\x40\x42\x02"
          "ab");
    assert_int_equal(bench.port->counters.lost, 0);
    assert_int_equal(shutdown(bench.client[0], SHUT_WR), 0); /* still hears */
    turn_loop(&bench);
    lx_serial_put(bench.port, (const uint8_t *)"c", 1);
    HEARS(&bench, 0, "c");
    end(&bench);
}

/* Telnet's Synch (RFC 854): its DM is sent as urgent data, and has its place among the others. */
static void urgent_bytes_are_bytes(void **state)
{
    struct bench bench;
    (void)state;
    open_port(&bench, "tcp:127.0.0.1:0");
    assert_int_equal(send(bench.client[0], "\x40\x42", 2, MSG_OOB), 2);
    SAY(&bench, 0, "\x02");
    assert_int_equal(bench.count, 3);
    HEARS(&bench, 1, "\x40\x42\x02");
    end(&bench);
}

static void settings_go_with_characters(void **state)
{
    struct bench bench;
    (void)state;
    open_port(&bench, "rfc2217:127.0.0.1:0");
    SAY(&bench, 0, "\xFF\xFA\x2C\x01\0\0\x4B\0\xFF\xF0\xFF\xFA\x2C\x03\x02\xFF\xF0x");
    assert_int_equal(bench.port->baud, 19200);
    assert_int_equal(bench.port->parity, 'O');
    HEARS(&bench, 0, "\xFF\xFA\x2C\x65\0\0\x4B\0\xFF\xF0\xFF\xFA\x2C\x67\x02\xFF\xF0");
    SAY(&bench, 1, "\xFF\xFA\x2C\x02\x07\xFF\xF0\xFF\xF3");
    assert_int_equal(bench.port->parity, '?');
    assert_int_equal(bench.heard[1], 0); /* a break */
    HEARS(&bench, 1, "x\xFF\xFA\x2C\x66\x07\xFF\xF0");
    bench.port->sends = (struct lx_uart){.baud = 9600, .parity = 'E'};
    lx_serial_put(bench.port, (const uint8_t *)"\xFF", 1);
    HEARS(&bench, 0, "\0\0"); /* a break and a character at another data rate */
    HEARS(&bench, 1, "\x7F"); /* seven data bits of it */
    HEARS(&bench, 2, "x\0\xFF\xFF");
    SAY(&bench, 2, "\xFF\xFA\x2C\x0A\xFF\xFF\xFF\xF0");
    HEARS(&bench, 2, "\xFF\xFA\x2C\x6E\xFF\xFF\xFF\xF0");
    SAY(&bench, 1, "\xFF\xFA\x2C\x05\x05\xFF\xF0"); /* framing error and break */
    HEARS(&bench, 2, "\xFF\xFA\x2C\x6A\x18\xFF\xF0\0");
    end(&bench);
}

/* RFC 2217, 3, FLOWCONTROL-SUSPEND: data and commands wait for the RESUME. */
static void what_is_suspended_waits(void **state)
{
    static const char asks[] = "\xFF\xFA\x2C\x03\x00\xFF\xF0";
    struct bench bench;
    (void)state;
    open_port(&bench, "rfc2217:127.0.0.1:0");
    SAY(&bench, 0, "\xFF\xFA\x2C\x08\xFF\xF0");
    SAY(&bench, 1, "x");
    SAY(&bench, 0, asks);
    HEARS(&bench, 0, "");
    HEARS(&bench, 2, "x");
    SAY(&bench, 0, "\xFF\xFA\x2C\x09\xFF\xF0");
    HEARS(&bench, 0, "x\xFF\xFA\x2C\x67\x03\xFF\xF0");
    assert_int_equal(bench.port->counters.lost, 0);
    SAY(&bench, 0, "\xFF\xFA\x2C\x08\xFF\xF0");
    char flood[2u * LX_PEERS_OUTPUT_MAX]; /* more answers than there is room for */
    for (size_t i = 0; i < sizeof flood; i++) {
        flood[i] = asks[i % (sizeof asks - 1u)];
    }
    send_text(&bench, 0, flood, sizeof flood / (sizeof asks - 1u) * (sizeof asks - 1u));
    HEARS(&bench, 0, "");
    SAY(&bench, 0, "\xFF\xFA\x2C\x09\xFF\xF0y");
    assert_int_equal(bench.heard[bench.count - 1u], 'y');
    char got[8];
    assert_int_equal(recv(bench.client[0], got, sizeof got, MSG_DONTWAIT), sizeof got);
    end(&bench);
}

static void foreign_beginnings(void **state)
{
    static const struct {
        const char *text;
        bool foreign;
    } rows[] = {
        {"GET /", true},     {"options *", true}, {"\x16\x03", true}, {"GET", false},
        {"PUT \x71", false}, {"\x16\x01", false}, {"S5\r", false},    {"", false},
    };
    struct bench bench;
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const uint8_t *bytes = (const uint8_t *)rows[i].text;
        assert_int_equal(lx_begins_foreign(bytes, strlen(rows[i].text)), rows[i].foreign);
    }
    open_port(&bench, "tcp:127.0.0.1:0");
    SAY(&bench, 0, "GE");
    SAY(&bench, 0, "T /\x40\x42\x02");
    assert_int_equal(bench.count, 2);
    char got[4];
    assert_int_equal(recv(bench.client[0], got, sizeof got, MSG_DONTWAIT), 0);
    end(&bench);
}

static void the_most_silent_gives_up_its_place(void **state)
{
    struct bench bench;
    int more[LX_PEERS_MAX];
    char got[4];
    (void)state;
    open_port(&bench, "tcp:127.0.0.1:0");
    SAY(&bench, 0, "x");
    for (size_t i = 0; i < DG_COUNT(more) - 2u; i++) {
        more[i] = join(&bench, bench.port->address);
    }
    assert_int_equal(recv(bench.client[1], got, sizeof got, MSG_DONTWAIT), 1);
    assert_int_equal(recv(bench.client[1], got, sizeof got, MSG_DONTWAIT), 0);
    assert_int_equal(recv(bench.client[0], got, sizeof got, MSG_DONTWAIT), -1);
    for (size_t i = 0; i < DG_COUNT(more) - 2u; i++) {
        (void)close(more[i]);
    }
    end(&bench);
}

static void who_does_not_read_loses(void **state)
{
    struct bench bench;
    uint8_t flood[4096] = {0};
    (void)state;
    open_port(&bench, "tcp:127.0.0.1:0");
    while (bench.port->counters.lost == 0) {
        lx_serial_put(bench.port, flood, sizeof flood);
    }
    while (recv(bench.client[0], flood, sizeof flood, MSG_DONTWAIT) > 0) {
    }
    turn_loop(&bench);
    lx_serial_put(bench.port, (const uint8_t *)"!", 1);
    ssize_t n = 0;
    uint8_t last = 0;
    while ((n = recv(bench.client[0], flood, sizeof flood, MSG_DONTWAIT)) > 0) {
        last = flood[n - 1];
    }
    assert_int_equal(last, '!');
    end(&bench);
}

/* What it has sent waits for room, which may come with somebody else's flush. */
static void who_reads_again_goes_on(void **state)
{
    static char flood[1u << 16]; /* empty lines, each is answered by one */
    size_t asked = 0;
    size_t answered = 0;
    unsigned idle = 0;
    struct bench bench;
    (void)state;
    open_can(&bench, lx_slcan_open, "tcp:127.0.0.1:0");
    memset(flood, '\r', sizeof flood);
    for (ssize_t n = 1; n > 0 || sd_event_run(bench.event, TURN_US) > 0;) {
        n = send(bench.client[0], flood, sizeof flood, MSG_NOSIGNAL | MSG_DONTWAIT);
        asked += n < 0 ? 0 : (size_t)n;
    }
    while (answered < asked && idle < IDLE_TURNS) {
        const ssize_t n = recv(bench.client[0], flood, sizeof flood, MSG_DONTWAIT);
        answered += n < 0 ? 0 : (size_t)n;
        bench.can->ops->push(bench.can);
        idle = sd_event_run(bench.event, n < 0 ? TURN_US : 0) > 0 || n > 0 ? 0 : idle + 1u;
    }
    assert_int_equal(answered, asked);
    end(&bench);
}

/* A TCP port that somebody has: who wants it is told why, and keeps nothing of it. */
static void a_port_that_is_taken_is_refused(void **state)
{
    static const struct {
        const char *prefix;
        const char *behind;
        lx_can_open *open; /* NULL: a serial port */
    } rows[] = {
        {"tcp:", "", NULL},
        {"rfc2217:", "", NULL},
        {"tcp:", "", lx_slcan_open},
        {"", ",can0", lx_socketcand_open},
    };
    struct bench bench;
    (void)state;
    open_port(&bench, "tcp:127.0.0.1:0");
    const char *port = strrchr(bench.port->address, ':') + 1;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct lx_error error = {.what = ""};
        char where[64];
        const unsigned open = descriptors_open();
        (void)snprintf(where, sizeof where, "%s127.0.0.1:%s%s", rows[i].prefix, port,
                       rows[i].behind);
        const struct lx_serial_setup serial = {
            .event = bench.event, .say = &quiet, .where = where, .rx = on_character, .ctx = &bench};
        const struct lx_can_setup can = {.event = bench.event,
                                         .say = &quiet,
                                         .where = where,
                                         .rx = on_frame,
                                         .settle = settle_wire,
                                         .ctx = &bench};
        if (rows[i].open == NULL) {
            assert_null(lx_net_port_open(&serial, &error));
        } else {
            assert_null(rows[i].open(&can, &error));
        }
        assert_non_null(strstr(error.what, "Address already in use"));
        assert_int_equal(descriptors_open(), open);
    }
    end(&bench);
}

static void addresses(void **state)
{
    static const struct {
        const char *text;
        bool good;
        const char *word;
        bool open;
    } rows[] = {
        {"localhost:1", true, "", false},
        {"localhost:0000001", true, "", false},
        {"localhost:00000001", false, "", false},
        {"localhost:1,open", true, "", true},
        {"[::1]:0,can0", true, "can0", false},
        {"h:1,vcan-0.1,open", true, "vcan-0.1", true},
        {"h:1,", false, "", false},
        {"h:1,a b", false, "", false},
        {"h", false, "", false},
        {"h:65536", false, "", false},
        {"h:1,a,b", false, "", false},
        {",open", false, "", false},
        {"h:1,0123456789abcdef", false, "", false},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct lx_peers_where where;
        assert_int_equal(lx_peers_split(rows[i].text, &where), rows[i].good);
        if (rows[i].good) {
            assert_string_equal(where.word, rows[i].word);
            assert_int_equal(where.open, rows[i].open);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slcan_adapters_share_a_bus),
        cmocka_unit_test(socketcand_clients_share_a_bus),
        cmocka_unit_test(a_bus_is_looked_at_when_a_client_leaves),
        cmocka_unit_test(bytes_go_to_all_others),
        cmocka_unit_test(urgent_bytes_are_bytes),
        cmocka_unit_test(settings_go_with_characters),
        cmocka_unit_test(what_is_suspended_waits),
        cmocka_unit_test(foreign_beginnings),
        cmocka_unit_test(the_most_silent_gives_up_its_place),
        cmocka_unit_test(who_does_not_read_loses),
        cmocka_unit_test(who_reads_again_goes_on),
        cmocka_unit_test(a_port_that_is_taken_is_refused),
        cmocka_unit_test(addresses),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
