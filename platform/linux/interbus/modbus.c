/* SPDX-License-Identifier: MIT */
/*
 * Requests are collected without blocking and checked here; libmodbus makes the answers. Its own
 * receiver would wait for the rest of a request, and the ring with it.
 *
 *   client -- on_bytes --> bytes -- take_request() --> check --> time --> map --> modbus_reply()
 *   timer  -- on_time  --> time: watchdog, drive(): ring
 */
#define _GNU_SOURCE
#include "modbus.h"

#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "drehgeber/bits.h"
#include "peers.h"

#define HEADER 7u
#define LENGTH_AT 4u
/* What a client that is sent away may still send, and for how long. */
#define FAREWELL_BYTES 65536u
#define FAREWELL DG_S(2)
#define FUNCTION_MASK 0x7Fu

/* A request after its header. */
struct request {
    const uint8_t *pdu;
    size_t length;
    struct lx_range read;
    struct lx_range write;
    const uint8_t *values; /* most significant byte first */
};

static struct lx_range range_at(const uint8_t *pdu)
{
    return (struct lx_range){dg_load_be16(pdu), dg_load_be16(pdu + 2)};
}

_Static_assert(LX_MODBUS_ADU_MAX == HEADER + 6u + 2u * MODBUS_MAX_WRITE_REGISTERS + 1u,
               "the longest request has as many values as Modbus allows");

/* Both lengths of a list of values: its byte count, and what there is. A request with none is too
   short, one with more than Modbus allows is longer than LX_MODBUS_ADU_MAX. */
static bool values_fit(const struct request *rq, size_t at)
{
    return rq->pdu[at] == 2u * rq->write.count && rq->length == at + 1u + rq->pdu[at];
}

static bool count_fits(const struct lx_range *range)
{
    return range->count >= 1 && range->count <= MODBUS_MAX_READ_REGISTERS;
}

static bool parse_read(struct request *rq)
{
    rq->read = range_at(rq->pdu + 1);
    return count_fits(&rq->read);
}

static bool parse_write_one(struct request *rq)
{
    rq->write = (struct lx_range){dg_load_be16(rq->pdu + 1), 1};
    rq->values = rq->pdu + 3;
    return true;
}

static bool parse_write(struct request *rq)
{
    rq->write = range_at(rq->pdu + 1);
    rq->values = rq->pdu + 6;
    return values_fit(rq, 5);
}

static bool parse_both(struct request *rq)
{
    rq->read = range_at(rq->pdu + 1);
    rq->write = range_at(rq->pdu + 5);
    rq->values = rq->pdu + 10;
    return count_fits(&rq->read) && values_fit(rq, 9);
}

/* Function codes, and the bytes of a request: exactly, or with values more than that. */
static const struct {
    uint8_t code;
    uint8_t length;
    bool exact;
    bool (*parse)(struct request *rq);
} functions[] = {
    {MODBUS_FC_READ_HOLDING_REGISTERS, 5, true, parse_read},
    {MODBUS_FC_READ_INPUT_REGISTERS, 5, true, parse_read},
    {MODBUS_FC_WRITE_SINGLE_REGISTER, 5, true, parse_write_one},
    {MODBUS_FC_WRITE_MULTIPLE_REGISTERS, 8, false, parse_write},
    {MODBUS_FC_WRITE_AND_READ_REGISTERS, 12, false, parse_both},
};

/* 0 or the exception. */
static unsigned parse(struct request *rq)
{
    for (size_t i = 0; i < DG_COUNT(functions); i++) {
        if (functions[i].code != rq->pdu[0]) {
            continue;
        }
        const size_t n = functions[i].length;
        const bool fits = functions[i].exact ? rq->length == n : rq->length >= n;
        return fits && functions[i].parse(rq) ? 0 : MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
    }
    return MODBUS_EXCEPTION_ILLEGAL_FUNCTION;
}

/* 0 or the exception; then nothing has been written. */
static unsigned execute(struct lx_modbus *self, const struct request *rq)
{
    uint16_t values[MODBUS_MAX_WRITE_REGISTERS];
    if (!lx_map_readable(&self->map, rq->read) || !lx_map_writable(&self->map, rq->write)) {
        return MODBUS_EXCEPTION_ILLEGAL_DATA_ADDRESS;
    }
    for (size_t i = 0; i < rq->write.count; i++) {
        values[i] = dg_load_be16(rq->values + 2u * i);
    }
    if (!lx_map_write(&self->map, rq->write, values)) {
        return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
    }
    lx_map_read(&self->map, rq->read, &self->registers[rq->read.first]);
    return 0;
}

/* Sleep until a cycle does something by itself. */
static void rest(struct lx_modbus *self)
{
    lx_timer_at(&self->timer, lx_ring_time_next(&self->time));
}

/* @return false: the client does not take its answers */
static bool answer(struct lx_modbus *self, struct lx_modbus_client *client, size_t length)
{
    struct request rq = {.pdu = client->bytes + HEADER, .length = length - HEADER};
    const dg_ns now = lx_now();
    unsigned exception = parse(&rq);
    lx_ring_time_to(&self->time, now);
    lx_map_request(&self->map, now);
    if (exception == 0) {
        exception = execute(self, &rq);
    }
    if (exception == 0 && rq.write.count > 0) {
        lx_ring_time_stir(&self->time);
    }
    rest(self);
    modbus_mapping_t mapping = {
        .nb_registers = LX_MAP_END,
        .nb_input_registers = LX_MAP_END,
        .tab_registers = self->registers,
        .tab_input_registers = self->registers,
    };
    (void)modbus_set_socket(self->protocol, client->fd);
    self->counters.requests++;
    if (exception != 0) {
        /* libmodbus adds 80h to the function, which takes the bit away again where it was set. */
        client->bytes[HEADER] &= FUNCTION_MASK;
        return modbus_reply_exception(self->protocol, client->bytes, exception) > 0;
    }
    return modbus_reply(self->protocol, client->bytes, (int)length, &mapping) > 0;
}

static void drop(struct lx_modbus_client *client)
{
    client->io = sd_event_source_disable_unref(client->io);
    if (client->fd >= 0) {
        (void)close(client->fd);
    }
    client->fd = -1;
    client->leaving = false;
}

/* Wait for the first client that has had time enough to leave. */
static void await_leavers(struct lx_modbus *self)
{
    dg_ns first = DG_NEVER;
    for (size_t i = 0; i < LX_MODBUS_CLIENTS; i++) {
        const struct lx_modbus_client *client = &self->clients[i];
        first = client->leaving && client->end < first ? client->end : first;
    }
    lx_timer_at(&self->farewell, first);
}

static void on_farewell(void *ctx, dg_ns now)
{
    struct lx_modbus *self = ctx;
    for (size_t i = 0; i < LX_MODBUS_CLIENTS; i++) {
        if (self->clients[i].leaving && self->clients[i].end <= now) {
            drop(&self->clients[i]);
        }
    }
    await_leavers(self);
}

/* Closing a connection with bytes that nobody has read resets it, and answers on their way are
 * lost. So: the end of the stream behind the last answer, and what still comes is read until the
 * client has understood. Whoever needs a place takes this one first. */
static void send_away(struct lx_modbus_client *client)
{
    if (shutdown(client->fd, SHUT_WR) != 0) {
        drop(client);
        return;
    }
    client->leaving = true;
    client->heard = 0;
    client->length = 0;
    client->end = dg_after(lx_now(), FAREWELL);
    await_leavers(client->owner);
}

/* Bytes of the request at the beginning of the buffer, header included; 0: no Modbus. */
static size_t request_length(const struct lx_modbus_client *client)
{
    const uint16_t protocol = dg_load_be16(client->bytes + 2);
    const size_t length = dg_load_be16(client->bytes + LENGTH_AT);
    /* The length counts the unit's byte, too, and there is a function code at least. */
    if (protocol != 0 || length < 2 || length > LX_MODBUS_ADU_MAX - HEADER + 1u) {
        return 0;
    }
    return length + HEADER - 1u;
}

enum outcome { STAYS, SENT_AWAY, GONE };

/* Answer the requests that are complete. */
static enum outcome take_requests(struct lx_modbus_client *client)
{
    struct lx_modbus *self = client->owner;
    while (client->length >= HEADER) {
        const size_t length = request_length(client);
        if (length == 0) {
            return SENT_AWAY;
        }
        if (client->length < length) {
            break;
        }
        if (!answer(self, client, length)) {
            return GONE;
        }
        client->length -= length;
        memmove(client->bytes, client->bytes + length, client->length);
    }
    return STAYS;
}

static void hear(struct lx_modbus_client *client, size_t n)
{
    client->heard = lx_now();
    client->length += n;
    const enum outcome outcome = take_requests(client);
    if (outcome == SENT_AWAY) {
        send_away(client);
    } else if (outcome == GONE) {
        drop(client);
    }
}

static int on_bytes(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct lx_modbus_client *client = ctx;
    (void)source;
    (void)events;
    const ssize_t n = recv(fd, client->bytes + client->length,
                           sizeof client->bytes - client->length, MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
        return 0;
    }
    if (n > 0 && !client->leaving) {
        hear(client, (size_t)n);
        return 0;
    }
    client->unheard += n > 0 ? (size_t)n : 0u;
    if (n <= 0 || client->unheard > FAREWELL_BYTES) {
        drop(client);
    }
    return 0;
}

/* A free place, or the one of the client that was silent for longest. */
static struct lx_modbus_client *place(struct lx_modbus *self)
{
    struct lx_modbus_client *oldest = &self->clients[0];
    for (size_t i = 0; i < LX_MODBUS_CLIENTS; i++) {
        if (self->clients[i].fd < 0) {
            return &self->clients[i];
        }
        oldest = self->clients[i].heard < oldest->heard ? &self->clients[i] : oldest;
    }
    drop(oldest);
    return oldest;
}

static int on_connection(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct lx_modbus *self = ctx;
    (void)source;
    (void)events;
    const int socket = accept4(fd, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) {
        return 0; /* it has gone again, or there is no descriptor for it */
    }
    struct lx_modbus_client *client = place(self);
    *client = (struct lx_modbus_client){.owner = self, .fd = socket, .heard = lx_now()};
    if (sd_event_add_io(sd_event_source_get_event(self->io), &client->io, socket, EPOLLIN, on_bytes,
                        client) < 0) {
        drop(client);
    }
    return 0;
}

static void on_time(void *ctx, dg_ns now)
{
    struct lx_modbus *self = ctx;
    lx_ring_time_due(&self->time, now);
    rest(self);
}

void lx_modbus_look(struct lx_modbus *self, dg_ns now)
{
    lx_ring_time_to(&self->time, now);
    rest(self);
}

void lx_modbus_stir(struct lx_modbus *self, bool watched, dg_ns now)
{
    lx_ring_time_watch(&self->time, watched, now);
    lx_ring_time_stir(&self->time);
    rest(self);
}

void lx_modbus_unwatch(struct lx_modbus *self)
{
    lx_ring_time_unwatch(&self->time);
}

bool lx_modbus_address_fits(const char *where)
{
    struct lx_peers_where endpoint;
    return lx_peers_split(where, &endpoint) && endpoint.word[0] == '\0';
}

static int listen_at(struct lx_modbus *self, const struct lx_modbus_setup *setup,
                     struct lx_error *error)
{
    struct lx_peers_where where;
    if (!lx_peers_split(setup->where, &where) || where.word[0] != '\0') {
        return lx_refuse(error, LX_MODBUS_RIGHT, "%s", "");
    }
    self->protocol = modbus_new_tcp_pi(where.at.host, where.at.port);
    if (self->protocol == NULL) {
        return lx_fail(error, "no memory for the coupler");
    }
    self->listener = lx_peers_listen(&where, error);
    if (self->listener < 0) {
        return -1;
    }
    lx_host_port_real(&where.at, self->listener);
    /* Connections inherit it: an answer does not wait for the acknowledgement of the one before. */
    const int on = 1;
    (void)setsockopt(self->listener, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    lx_host_port_print(&where.at, self->address, sizeof self->address);
    return 0;
}

static int watch(struct lx_modbus *self, sd_event *event)
{
    int result = sd_event_add_io(event, &self->io, self->listener, EPOLLIN, on_connection, self);
    if (result >= 0) {
        result = lx_endpoint_calm(self->io);
    }
    if (result >= 0) {
        result = lx_timer_open(&self->timer, event, on_time, self);
    }
    if (result >= 0) {
        result = lx_timer_open(&self->farewell, event, on_farewell, self);
    }
    if (result >= 0) {
        lx_timer_at(&self->timer, lx_now());
    }
    return result;
}

int lx_modbus_open(struct lx_modbus *self, const struct lx_modbus_setup *setup,
                   struct lx_error *error)
{
    memset(self, 0, sizeof *self);
    self->setup = *setup;
    const struct lx_ring_time_setup time = {
        .map = &self->map, .period = setup->cycle, .drive = setup->drive, .ctx = setup->ctx};
    lx_ring_time_init(&self->time, &time);
    self->listener = -1;
    for (size_t i = 0; i < LX_MODBUS_CLIENTS; i++) {
        self->clients[i].fd = -1;
    }
    lx_map_init(&self->map, setup->ring);
    self->map.tear = setup->tear;
    if (listen_at(self, setup, error) != 0) {
        return -1;
    }
    const int result = watch(self, setup->event);
    return result < 0 ? lx_fail(error, "no event loop: %s", strerror(-result)) : 0;
}

void lx_modbus_close(struct lx_modbus *self)
{
    for (size_t i = 0; i < LX_MODBUS_CLIENTS; i++) {
        drop(&self->clients[i]);
    }
    lx_timer_close(&self->timer);
    lx_timer_close(&self->farewell);
    self->io = sd_event_source_disable_unref(self->io);
    if (self->listener >= 0) {
        (void)close(self->listener);
    }
    modbus_free(self->protocol);
}
