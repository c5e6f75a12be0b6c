/* SPDX-License-Identifier: MIT */
/*
 * Requests are collected without blocking and checked here; libmodbus makes the answers. Its own
 * receiver would wait for the rest of a request, and the ring with it.
 *
 *   client -- on_byte --> bytes --> check --> coupler's registers --> modbus_reply()
 *   timer  -- on_time  --> the ring's master
 */
#include "modbus.h"

#include <string.h>

#include "drehgeber/bits.h"

#define HEADER 7u
#define LENGTH_AT 4u
#define FUNCTION_MASK 0x7Fu

/* A client's request, as far as it has come. */
struct client {
    size_t length;
    uint8_t bytes[LX_MODBUS_ADU_MAX];
};

/* A request after its header. */
struct request {
    const uint8_t *pdu;
    size_t length;
    struct dg_ib_registers read;
    struct dg_ib_registers write;
    const uint8_t *values; /* most significant byte first */
};

static struct dg_ib_registers range_at(const uint8_t *pdu)
{
    return (struct dg_ib_registers){dg_load_be16(pdu), dg_load_be16(pdu + 2)};
}

_Static_assert(LX_MODBUS_ADU_MAX == HEADER + 6u + 2u * MODBUS_MAX_WRITE_REGISTERS + 1u,
               "the longest request has as many values as Modbus allows");

/* Both lengths of a list of values: its byte count, and what there is. A request with none is too
   short, one with more than Modbus allows is longer than LX_MODBUS_ADU_MAX. */
static bool written_values_fit(const struct request *rq, size_t at)
{
    return rq->pdu[at] == 2u * rq->write.count && rq->length == at + 1u + rq->pdu[at];
}

static bool count_fits(const struct dg_ib_registers *range)
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
    rq->write = (struct dg_ib_registers){dg_load_be16(rq->pdu + 1), 1};
    rq->values = rq->pdu + 3;
    return true;
}

static bool parse_write(struct request *rq)
{
    rq->write = range_at(rq->pdu + 1);
    rq->values = rq->pdu + 6;
    return written_values_fit(rq, 5);
}

static bool parse_both(struct request *rq)
{
    rq->read = range_at(rq->pdu + 1);
    rq->write = range_at(rq->pdu + 5);
    rq->values = rq->pdu + 10;
    return count_fits(&rq->read) && written_values_fit(rq, 9);
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
static unsigned parse_request(struct request *rq)
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
static unsigned execute_request(struct lx_modbus *self, const struct request *rq)
{
    uint16_t values[MODBUS_MAX_WRITE_REGISTERS];
    if (!dg_ib_coupler_readable(&self->map, rq->read) ||
        !dg_ib_coupler_writable(&self->map, rq->write)) {
        return MODBUS_EXCEPTION_ILLEGAL_DATA_ADDRESS;
    }
    for (size_t i = 0; i < rq->write.count; i++) {
        values[i] = dg_load_be16(rq->values + 2u * i);
    }
    if (!dg_ib_coupler_write(&self->map, rq->write, values)) {
        return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
    }
    dg_ib_coupler_read(&self->map, rq->read, &self->registers[rq->read.first]);
    return 0;
}

void lx_modbus_sleep(struct lx_modbus *self)
{
    lx_timer_at(&self->timer, dg_ring_master_next(self->setup.master));
}

/* @return false: the client does not take its answers */
static bool answer_client(struct lx_modbus *self, int fd, uint8_t *bytes, size_t length)
{
    struct request rq = {.pdu = bytes + HEADER, .length = length - HEADER};
    unsigned exception = parse_request(&rq);
    dg_ib_coupler_request(&self->map, lx_now());
    if (exception == 0) {
        exception = execute_request(self, &rq);
    }
    lx_modbus_sleep(self);
    modbus_mapping_t mapping = {
        .nb_registers = DG_IB_COUPLER_END,
        .nb_input_registers = DG_IB_COUPLER_END,
        .tab_registers = self->registers,
        .tab_input_registers = self->registers,
    };
    (void)modbus_set_socket(self->protocol, fd);
    self->requests++;
    if (exception != 0) {
        /* libmodbus adds 80h to the function, which takes the bit away again where it was set. */
        bytes[HEADER] &= FUNCTION_MASK;
        return modbus_reply_exception(self->protocol, bytes, exception) > 0;
    }
    return modbus_reply(self->protocol, bytes, (int)length, &mapping) > 0;
}

/* Bytes of the request at the beginning of the buffer, header included; 0: no Modbus. */
static size_t request_length(const struct client *client)
{
    const uint16_t protocol = dg_load_be16(client->bytes + 2);
    const size_t length = dg_load_be16(client->bytes + LENGTH_AT);
    /* The length counts the unit's byte, too, and there is a function code at least. */
    if (protocol != 0 || length < 2 || length > LX_MODBUS_ADU_MAX - HEADER + 1u) {
        return 0;
    }
    return length + HEADER - 1u;
}

static void on_byte(void *ctx, struct lx_peer *peer, dg_ns now, uint8_t byte, size_t more)
{
    struct client *client = (void *)peer->own;
    (void)now;
    (void)more;
    client->bytes[client->length++] = byte;
    if (client->length < HEADER) {
        return;
    }
    const size_t length = request_length(client);
    if (length == 0) {
        lx_peer_send_away(peer);
    } else if (client->length == length) {
        client->length = 0;
        peer->broken = !answer_client(ctx, peer->fd, client->bytes, length);
    }
}

static void on_time(void *ctx, dg_ns now)
{
    struct lx_modbus *self = ctx;
    dg_ring_master_due(self->setup.master, now);
    lx_modbus_sleep(self);
}

static const struct lx_peers_form form = {
    "", "expected HOST:PORT, e.g. 127.0.0.1:5020; beyond loopback HOST:PORT,open", false};

int lx_modbus_check(const char *where, struct lx_error *error)
{
    return lx_peers_check(&form, where, error);
}

static int listen_at(struct lx_modbus *self, struct lx_error *error)
{
    const struct lx_modbus_setup *setup = &self->setup;
    const struct lx_peers_setup peers = {
        .event = setup->event,
        .say = setup->say,
        .name = "modbus",
        .beyond = "writes to this ring, as with the real coupler",
        .strangers = true,
        .where = &self->where,
        .own_size = sizeof(struct client),
        .byte = on_byte,
        .ctx = self,
    };
    if (lx_peers_read(&form, setup->where, &self->where, error) != 0) {
        return -1;
    }
    self->protocol = modbus_new_tcp_pi(self->where.at.host, self->where.at.port);
    return self->protocol == NULL ? lx_fail(error, "no memory for the coupler")
                                  : lx_peers_open(&self->peers, &peers, error);
}

int lx_modbus_open(struct lx_modbus *self, const struct lx_modbus_setup *setup,
                   struct lx_error *error)
{
    memset(self, 0, sizeof *self);
    self->setup = *setup;
    self->peers.listener = -1;
    dg_ib_coupler_init(&self->map, setup->master, setup->tear);
    if (listen_at(self, error) != 0) {
        return -1;
    }
    const int result = lx_timer_open(&self->timer, setup->event, on_time, self);
    if (result < 0) {
        return lx_fail(error, "no event loop: %s", strerror(-result));
    }
    lx_timer_at(&self->timer, lx_now());
    return 0;
}

void lx_modbus_close(struct lx_modbus *self)
{
    lx_peers_close(&self->peers);
    lx_timer_close(&self->timer);
    modbus_free(self->protocol);
}
