/* SPDX-License-Identifier: MIT */
#include "verify_coupler.h"

#include <errno.h>
#include <sys/socket.h>

#include "endpoint.h"

/* Of `drehgeber map`. */
#define INPUT_IMAGE 0x0000
#define OUTPUT_IMAGE 0x0800
#define IMAGE_BITS 0x1011
#define ID_WORD 0x2000
/* How often a request is made whose answer is late or damaged. */
#define TRIES 3u
/* Pieces of what nobody has asked for that are thrown away between them. */
#define PIECES_MAX 16u

int verify_coupler_open(struct verify_coupler *self, const char *where, unsigned words,
                        struct lx_error *error)
{
    struct lx_host_port at;
    *self = (struct verify_coupler){.words = words};
    if (!lx_host_port_split(where, &at)) {
        return lx_refuse(error, "expected HOST:PORT", "%s is no address of a coupler", where);
    }
    self->modbus = modbus_new_tcp_pi(at.host, at.port);
    if (self->modbus == NULL) {
        return lx_fail(error, "no memory");
    }
    /* Without a limit between bytes the other one is for the whole answer. */
    (void)modbus_set_byte_timeout(self->modbus, 0, 0);
    (void)modbus_set_response_timeout(self->modbus, VERIFY_COUPLER_LIMIT_MS / 1000u,
                                      VERIFY_COUPLER_LIMIT_MS % 1000u * 1000u);
    return modbus_connect(self->modbus) == 0
               ? 0
               : lx_fail(error, "%s: %s", where, modbus_strerror(errno));
}

/* Whether the coupler has answered, though not as it was asked to. */
static bool is_exception(int reason)
{
    return reason > MODBUS_ENOBASE && reason <= EMBXGTAR;
}

/* modbus_flush() would go on for as long as somebody sends. */
static void drop_rest(const struct verify_coupler *self)
{
    char piece[4096];
    const int fd = modbus_get_socket(self->modbus);
    for (unsigned i = 0; i < PIECES_MAX; i++) {
        if (recv(fd, piece, sizeof piece, MSG_DONTWAIT) <= 0) {
            return;
        }
    }
}

/* Whether the request that was made `tries` times is worth another try. */
static bool may_try_again(struct verify_coupler *self, unsigned tries)
{
    if (is_exception(errno)) {
        return false;
    }
    drop_rest(self);
    self->lost = tries >= TRIES;
    return !self->lost;
}

static bool read_registers(struct verify_coupler *self, int first, int count, uint16_t *to)
{
    for (unsigned i = 0; !self->lost;) {
        if (modbus_read_registers(self->modbus, first, count, to) == count) {
            return true;
        }
        if (!may_try_again(self, ++i)) {
            return false;
        }
    }
    return false;
}

bool verify_coupler_in(struct verify_coupler *self, uint32_t *in)
{
    uint16_t words[2] = {0, 0};
    if (!read_registers(self, INPUT_IMAGE, (int)self->words, words)) {
        return false;
    }
    *in = self->words == 1 ? words[0] : (uint32_t)words[0] << 16 | words[1];
    return true;
}

bool verify_coupler_out(struct verify_coupler *self, uint32_t out)
{
    const uint16_t words[2] = {self->words == 1 ? (uint16_t)out : (uint16_t)(out >> 16),
                               (uint16_t)out};
    for (unsigned i = 0; !self->lost;) {
        if (modbus_write_registers(self->modbus, OUTPUT_IMAGE, (int)self->words, words) ==
            (int)self->words) {
            return true;
        }
        if (!may_try_again(self, ++i)) {
            return false;
        }
    }
    return false;
}

bool verify_coupler_id(struct verify_coupler *self, uint16_t *id)
{
    return read_registers(self, ID_WORD, 1, id);
}

bool verify_coupler_ring(struct verify_coupler *self, uint16_t *words)
{
    const bool said = read_registers(self, IMAGE_BITS, 1, words);
    *words = said ? (uint16_t)(*words / 16u) : 0u;
    return said;
}

void verify_coupler_close(struct verify_coupler *self)
{
    if (self->modbus != NULL) {
        modbus_close(self->modbus);
        modbus_free(self->modbus);
    }
    self->modbus = NULL;
}
