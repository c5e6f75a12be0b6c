/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: the TCP port of the bus coupler in front of a K1, a K2 and a K3. The input is a
 * stream of operations: connections that come and go, bytes in pieces of any length, requests that
 * are nearly right, cycles of the ring. Every whole request has one answer, as long as this file
 * says and in order; only who sends no Modbus is cut off; registers that do not exist stay as they
 * are; and in the end the ring runs and a good client is served.
 *
 * Connections and their loop are real, the cycles' time is not: it only goes on from the clock.
 */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <errno.h>
#include <limits.h>
#include <netinet/tcp.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "drehgeber/bits.h"
#include "drehgeber/devices.h"
#include "fuzz_input.h"
#include "modbus.h"
#include "modbus_rig.h"

#define DEVICES 3u
#define WORDS 5u       /* of either image: 1, 2, 2 */
#define CLIENTS 6u     /* that the operations speak for */
#define HONEST CLIENTS /* the one that is served in the end */
#define SOCKETS (CLIENTS + 1u)
#define PLACES 3u /* for them in a crowd */
#define ASKED_MAX 1024u
#define HEADER 7u
#define BEFORE_LENGTH 6u
#define WRITTEN 12u /* bytes that answer a write ... */
#define REFUSED 9u  /* ... and an exception */
#define UNTOUCHED 0xA5u
#define PATIENCE DG_S(5)

struct client {
    int fd; /* -1: none */
    size_t asked_length;
    size_t got_length;
    uint8_t asked[ASKED_MAX]; /* and not answered yet */
    uint8_t got[LX_MODBUS_ADU_MAX];
};

static struct bench {
    sd_event *event;
    struct modbus_rig rig;
    struct lx_ring *ring;
    struct lx_modbus coupler;
    struct sockaddr_in port;
    struct client clients[SOCKETS];
    bool crowded; /* more clients than places: some lose theirs */
    dg_ns now;
} bench;

/* The registers that exist, K1 to K3 behind the coupler, by address. */
static const struct dg_ib_registers inside[] = {
    {0x0000, WORDS}, {0x0800, WORDS}, {0x1000, 10}, {0x100C, 1},
    {0x1010, 6},     {0x1020, 1},     {0x1120, 4},  {0x2000, 16 * DEVICES},
};
#define INSIDE DG_COUNT(inside)

static uint16_t take16(struct fuzz_input *input)
{
    const uint8_t high = fuzz_take(input);

    return (uint16_t)(high << 8 | fuzz_take(input));
}

/* --- what a request deserves --- */

static bool exists(uint32_t address)
{
    for (size_t i = 0; i < INSIDE; i++) {
        if (address >= inside[i].first && address - inside[i].first < inside[i].count) {
            return true;
        }
    }
    return false;
}

static bool can_read(const uint8_t *range)
{
    const uint32_t first = dg_load_be16(range);
    const uint32_t count = dg_load_be16(range + 2);

    for (uint32_t i = 0; i < count && i <= MODBUS_MAX_READ_REGISTERS; i++) {
        if (!exists(first + i)) {
            return false;
        }
    }
    return count >= 1 && count <= MODBUS_MAX_READ_REGISTERS;
}

/* OUT by whole devices, and the settings of the watchdog. */
static bool can_write(uint32_t first, uint32_t count, const uint8_t *values)
{
    const uint32_t end = first + count;

    if (first >= 0x0800 && end <= 0x0800 + WORDS) {
        return bench.coupler.map.tear ||
               (first != 0x0802 && first != 0x0804 && end != 0x0802 && end != 0x0804);
    }
    if (first < 0x1120 || end > 0x1124) {
        return false;
    }
    for (uint32_t i = 0; i < count; i++) {
        const uint16_t value = dg_load_be16(values + (size_t)2u * i);
        if ((first + i == 0x1122 && value > 1) || (first + i == 0x1123 && value > 2)) {
            return false;
        }
    }
    return true;
}

/* Range, byte count and values at `at`, of at most `most` registers, to the end of the request. */
static bool can_write_list(const uint8_t *pdu, size_t length, size_t at, uint16_t most)
{
    const uint16_t count = dg_load_be16(pdu + at + 2);

    return count >= 1 && count <= most && pdu[at + 4] == 2u * count &&
           length == at + 5u + pdu[at + 4] &&
           can_write(dg_load_be16(pdu + at), count, pdu + at + 5);
}

/* Bytes of the answer to a whole request. */
static size_t deserved(const uint8_t *request, size_t length)
{
    const uint8_t *pdu = request + HEADER;
    const size_t n = length - HEADER;

    switch (pdu[0]) {
    case MODBUS_FC_READ_HOLDING_REGISTERS:
    case MODBUS_FC_READ_INPUT_REGISTERS:
        return n == 5 && can_read(pdu + 1) ? REFUSED + 2u * dg_load_be16(pdu + 3) : REFUSED;
    case MODBUS_FC_WRITE_SINGLE_REGISTER:
        return n == 5 && can_write(dg_load_be16(pdu + 1), 1, pdu + 3) ? WRITTEN : REFUSED;
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS:
        return n >= 8 && can_write_list(pdu, n, 1, 123) ? WRITTEN : REFUSED;
    case MODBUS_FC_WRITE_AND_READ_REGISTERS:
        return n >= 12 && can_read(pdu + 1) && can_write_list(pdu, n, 5, 121)
                   ? REFUSED + 2u * dg_load_be16(pdu + 3)
                   : REFUSED;
    default:
        return REFUSED;
    }
}

/* --- clients --- */

/* Until there is nothing more to do. */
static void turn_loop(void)
{
    int result;

    do {
        result = sd_event_run(bench.event, 0);
    } while (result > 0);
    fuzz_must(result == 0);
}

static bool is_garbage(const struct client *self)
{
    const uint16_t length = dg_load_be16(self->asked + 4);

    return self->asked_length >= HEADER &&
           (dg_load_be16(self->asked + 2) != 0 || length < 2 || length > 254);
}

/* Bytes of the first request, 0: it is not whole. */
static size_t whole(const struct client *self)
{
    const size_t length = BEFORE_LENGTH + (size_t)dg_load_be16(self->asked + 4);

    return self->asked_length >= HEADER && self->asked_length >= length ? length : 0;
}

static void forget(struct client *self)
{
    if (self->fd >= 0) {
        (void)close(self->fd);
    }
    self->fd = -1;
}

static void cut_off(struct client *self)
{
    fuzz_must(bench.crowded || is_garbage(self));
    forget(self);
}

static bool check_answer(struct client *self)
{
    const size_t asked = whole(self);

    fuzz_must(!is_garbage(self) && asked != 0);
    const size_t length = deserved(self->asked, asked);
    const size_t told =
        self->got_length < BEFORE_LENGTH ? length - BEFORE_LENGTH : dg_load_be16(self->got + 4);
    fuzz_must(told + BEFORE_LENGTH == length && length <= LX_MODBUS_ADU_MAX);
    if (self->got_length < length) {
        return false;
    }
    /* Transaction, protocol and unit are the request's; a write is read back. */
    fuzz_must(memcmp(self->got, self->asked, 4) == 0 && self->got[6] == self->asked[6]);
    fuzz_must(self->got[7] == (length == REFUSED ? self->asked[7] | 0x80u : self->asked[7]));
    fuzz_must(length != WRITTEN || memcmp(self->got + 8, self->asked + 8, 4) == 0);
    self->asked_length -= asked;
    memmove(self->asked, self->asked + asked, self->asked_length);
    self->got_length -= length;
    memmove(self->got, self->got + length, self->got_length);
    return true;
}

static void read_answers(struct client *self)
{
    while (self->fd >= 0) {
        const ssize_t n = recv(self->fd, self->got + self->got_length,
                               sizeof self->got - self->got_length, MSG_DONTWAIT);
        if (n < 0 && errno == EAGAIN) {
            return;
        }
        if (n <= 0) {
            cut_off(self);
            return;
        }
        self->got_length += (size_t)n;
        while (self->got_length > 0 && check_answer(self)) {
        }
    }
}

/* Let the coupler work until it owes this client nothing. */
static void await_answers(struct client *self)
{
    const dg_ns end = dg_after(lx_now(), PATIENCE);

    read_answers(self);
    while (self->fd >= 0 && (is_garbage(self) || whole(self) != 0)) {
        fuzz_must(lx_now() < end);
        turn_loop();
        read_answers(self);
    }
}

/* Small pieces go at once, instead of when the one before has been acknowledged. */
static void hurry(int fd)
{
    const int yes = 1;

    fuzz_must(setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes) == 0);
}

static void join(struct client *self)
{
    /* No TIME_WAIT is left behind: there are more inputs than ports. */
    const struct linger reset = {.l_onoff = 1};

    if (self->fd >= 0) {
        return;
    }
    *self = (struct client){.fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    fuzz_must(self->fd >= 0);
    fuzz_must(setsockopt(self->fd, SOL_SOCKET, SO_LINGER, &reset, sizeof reset) == 0);
    hurry(self->fd);
    /* The fuzzer's own timer interrupts. */
    while (connect(self->fd, (const struct sockaddr *)&bench.port, sizeof bench.port) != 0) {
        fuzz_must(errno == EINTR);
    }
    turn_loop(); /* fewer wait for a place than may wait */
}

static void send_bytes(struct client *self, const uint8_t *bytes, size_t n)
{
    join(self);
    if (n > sizeof self->asked - self->asked_length) {
        return;
    }
    memcpy(self->asked + self->asked_length, bytes, n);
    self->asked_length += n;
    if (send(self->fd, bytes, n, MSG_NOSIGNAL) != (ssize_t)n) {
        read_answers(self);
        fuzz_must(self->fd < 0);
    }
}

/* --- the ring --- */

static void cycle(dg_ns time)
{
    const struct dg_ring_counters *counters = &bench.ring->is->counters;
    const uint64_t before = (uint64_t)counters->cycles + counters->ids;
    const dg_ns clock = lx_now();

    bench.now = dg_after(bench.now > clock ? bench.now : clock, time);
    (void)dg_ring_master_cycle(&bench.ring->master, bench.now);
    fuzz_must((uint64_t)counters->cycles + counters->ids > before);
    fuzz_must(!bench.ring->master.stopped || bench.ring->master.watchdog.fired);
}

/* --- operations; each takes what it needs from the input --- */

static struct client *client_of(struct fuzz_input *input)
{
    return &bench.clients[fuzz_take(input) % CLIENTS];
}

static void op_bytes(struct fuzz_input *input)
{
    struct client *client = client_of(input);
    const size_t left = (size_t)(input->end - input->at);
    const size_t wanted = fuzz_take(input) % 64u + 1u;
    const size_t n = wanted < left ? wanted : left > 0 ? left - 1u : 0;

    if (n > 0) {
        send_bytes(client, input->at, n);
        input->at += n;
    }
}

/* A range that exists, more or less. */
static void put_range(uint8_t *to, struct fuzz_input *input)
{
    dg_store_be16(to, (uint16_t)(inside[fuzz_take(input) % INSIDE].first + fuzz_take(input) % 6u));
    dg_store_be16(to + 2, fuzz_take(input) % 8u);
}

/* @return bytes of it: one of the functions that exist, as right as the input makes it */
static size_t put_pdu(uint8_t *to, struct fuzz_input *input)
{
    static const struct {
        uint8_t code;
        uint8_t lists; /* where its byte count is, 0: none */
    } functions[] = {{3, 0}, {4, 0}, {6, 0}, {16, 5}, {23, 9}};
    const size_t i = fuzz_take(input) % (DG_COUNT(functions));
    const size_t at = functions[i].lists;

    to[0] = functions[i].code;
    put_range(to + 1, input);
    if (at == 0) {
        return 5;
    }
    put_range(to + at - 4, input);
    to[at] = (uint8_t)(2u * to[at - 1]);
    for (size_t n = 0; n < to[at]; n++) {
        to[at + 1u + n] = n % 2 == 0 ? 0 : fuzz_take(input);
    }
    return at + 1u + to[at];
}

/* A request in two pieces or one. */
static void op_request(struct fuzz_input *input)
{
    struct client *client = client_of(input);
    uint8_t bytes[LX_MODBUS_ADU_MAX] = {0};
    const uint8_t how = fuzz_take(input);

    dg_store_be16(bytes, take16(input));
    bytes[BEFORE_LENGTH] = how;
    const size_t length = HEADER + put_pdu(bytes + HEADER, input);
    const size_t split = fuzz_take(input) % length;
    /* Now and then it says that it is longer than it is. */
    dg_store_be16(bytes + 4, (uint16_t)(length - BEFORE_LENGTH + (how > 0xE0 ? how & 7u : 0u)));
    send_bytes(client, bytes, split);
    if ((how & 1u) != 0) {
        turn_loop();
    }
    send_bytes(client, bytes + split, length - split);
}

/* A watchdog that fires soon, and any fallback. */
static void op_watchdog(struct fuzz_input *input)
{
    uint8_t request[] = {0,    1,    0, 0, 0, 15, 1, MODBUS_FC_WRITE_MULTIPLE_REGISTERS,
                         0x11, 0x20, 0, 4, 8, 0,  0, 0,
                         0,    0,    0, 0, 0};
    struct client *client = client_of(input);
    const uint8_t how = fuzz_take(input);

    request[14] = how >> 4;
    request[18] = how >> 2 & 1u;
    request[20] = how & 3u;
    send_bytes(client, request, sizeof request);
}

static void op_turn(struct fuzz_input *input)
{
    await_answers(client_of(input));
}

static void op_cycle(struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    cycle(DG_US(1) << (how & 31u));
}

static void op_leave(struct fuzz_input *input)
{
    forget(client_of(input));
}

/* --- an input --- */

static void open_coupler(void)
{
    socklen_t length = sizeof bench.port;
    struct lx_error error;

    fuzz_must(sd_event_new(&bench.event) >= 0);
    const struct lx_modbus_setup setup = {
        .event = bench.event, .where = "127.0.0.1:0", .master = &bench.rig.ring.master};
    fuzz_must(lx_modbus_open(&bench.coupler, &setup, &error) == 0);
    fuzz_must(getsockname(bench.coupler.peers.listener, (struct sockaddr *)&bench.port, &length) ==
              0);
    hurry(bench.coupler.peers.listener); /* its connections inherit it */
    /* Thousands of connections a second are what is wanted here. */
    fuzz_must(sd_event_source_set_ratelimit(bench.coupler.peers.io, 0, 0) >= 0);
    for (size_t i = 0; i < SOCKETS; i++) {
        bench.clients[i].fd = -1;
    }
}

/* In a crowd most places belong to others, who are heard all the time. */
static void set_places(bool crowded)
{
    static struct lx_peer other = {.heard = DG_NEVER, .end = DG_NEVER};

    bench.crowded = crowded;
    for (size_t i = PLACES; i < LX_PEERS_MAX; i++) {
        bench.coupler.peers.peer[i] = crowded ? &other : NULL;
    }
}

static void set_up(struct fuzz_input *input)
{
    static const struct dg_device *const models[DEVICES] = {&dg_ocd_ib_k1, &dg_ocd_ib_k2,
                                                            &dg_ocd_ib_k3};
    struct lx_error error;

    if (bench.event == NULL) {
        open_coupler();
    }
    bench.ring = &bench.rig.ring;
    modbus_rig_plan(&bench.rig, models, DEVICES);
    bench.now = lx_now();
    fuzz_must(modbus_rig_open(&bench.rig, NULL, NULL, bench.now, &error) == 0);
    bench.ring->master.next = dg_after(bench.now, DG_S(3600)); /* all cycles are operations */
    const uint8_t how = fuzz_take(input);
    dg_ib_coupler_init(&bench.coupler.map, &bench.ring->master, (how & 1u) != 0);
    set_places((how & 2u) != 0);
    memset(bench.coupler.registers, UNTOUCHED, sizeof bench.coupler.registers);
}

/* Whether all bytes are the same one; without a loop of this file, which would be slow. */
static bool is_all(const void *at, size_t n, uint8_t byte)
{
    const uint8_t *bytes = at;

    return n == 0 || (bytes[0] == byte && memcmp(bytes, bytes + 1, n - 1) == 0);
}

/* Between the registers that exist, nothing has been touched. */
static void check_outside(void)
{
    const uint16_t *registers = bench.coupler.registers;
    size_t at = 0;

    for (size_t i = 0; i <= INSIDE; i++) {
        const size_t end = i < INSIDE ? inside[i].first : DG_IB_COUPLER_END;
        fuzz_must(is_all(registers + at, (end - at) * sizeof *registers, UNTOUCHED));
        at = i < INSIDE ? end + inside[i].count : at;
    }
    const uint16_t *in = dg_ring_master_in(&bench.ring->master);
    fuzz_must(is_all(in + WORDS, (DEVICES * DG_RING_WORDS_MAX - WORDS) * sizeof *in, 0));
    fuzz_must(is_all(bench.ring->out + WORDS,
                     sizeof bench.ring->out - WORDS * sizeof *bench.ring->out, 0));
    fuzz_must(bench.coupler.map.fed_by_each <= 1);
    fuzz_must(bench.ring->master.watchdog.fallback < DG_RING_FALLBACK_COUNT);
}

/* A client that switches the watchdog off and writes OUT starts whatever had stopped. */
static void check_service(void)
{
    static const uint8_t watchdog_off[] = {1, 1, 0, 0, 0, 6, 1, 6, 0x11, 0x20, 0, 0};
    static const uint8_t write_out[] = {1,         2, 0, 0, 0, 17, 1, 16, 8, 0, 0, WORDS,
                                        2 * WORDS, 0, 0, 0, 0, 0,  0, 0,  0, 0, 0};
    struct client *client = &bench.clients[HONEST];

    send_bytes(client, watchdog_off, sizeof watchdog_off);
    send_bytes(client, write_out, sizeof write_out);
    await_answers(client);
    fuzz_must(client->fd >= 0 && client->asked_length == 0);
    cycle(DG_S(1));
    cycle(DG_MS(1));
    fuzz_must(bench.ring->is->result == DG_RING_OK && bench.ring->is->reached == DEVICES);
}

static bool occupied(void)
{
    const size_t places = bench.crowded ? PLACES : LX_PEERS_MAX;

    for (size_t i = 0; i < places; i++) {
        if (bench.coupler.peers.peer[i] != NULL) {
            return true;
        }
    }
    return false;
}

static void tear_down(void)
{
    const dg_ns end = dg_after(lx_now(), PATIENCE);

    for (size_t i = 0; i < SOCKETS; i++) {
        forget(&bench.clients[i]);
    }
    turn_loop();
    while (occupied()) {
        fuzz_must(lx_now() < end);
        turn_loop();
    }
    set_places(false);
    modbus_rig_close(&bench.rig);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct fuzz_input *) = {
        op_bytes, op_bytes, op_request, op_request, op_request,
        op_turn,  op_cycle, op_cycle,   op_leave,   op_watchdog,
    };
    struct fuzz_input input = {.at = bytes, .end = bytes + n};

    set_up(&input);
    while (input.at < input.end) {
        operations[fuzz_take(&input) % (DG_COUNT(operations))](&input);
    }
    for (size_t i = 0; i < SOCKETS; i++) {
        await_answers(&bench.clients[i]);
    }
    check_service();
    check_outside();
    tear_down();
    return 0;
}
