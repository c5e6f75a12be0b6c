/* SPDX-License-Identifier: MIT */
/* A PLC in front of an INTERBUS coupler: the input image, between two looks at the coupler. */
#define _GNU_SOURCE
#include "masters.h"

#include <modbus/modbus.h>
#include <stdlib.h>

#define RING_PERIOD (5 * NS_PER_MS)
#define COUPLER_STATUS 0x100Cu
#define STATUS_BUS_ERROR 2u
#define STATUS_MODULE_ERROR 4u
#define RING_CYCLE (10 * NS_PER_MS)
#define IMAGE_WORDS 5
#define POSITION_BITS 0x01FFFFFFu
#define NO_POSITION 0x80000000u
/* IN is of the last cycle of the ring, which was due not longer ago than this. */
#define IN_AGE (2 * RING_CYCLE)

static uint16_t coupler_status(modbus_t *coupler)
{
    uint16_t status = 0;
    if (modbus_read_input_registers(coupler, COUPLER_STATUS, 1, &status) != 1) {
        die("coupler");
    }
    return status;
}

static void look_at(struct master *self, struct device *device, const uint16_t *words, int64_t from)
{
    const bool has_states = device->address == IMAGE_WORDS - 2; /* a K3 */
    const bool single = device->turns <= 1.0;
    const uint32_t value = single ? words[0] : (uint32_t)words[0] << 16 | words[1];
    if (has_states && (value & NO_POSITION) != 0) {
        become(device, "invalid");
    } else if (check(self, device, has_states ? value & POSITION_BITS : value, from - IN_AGE)) {
        become(device, "ok");
    }
}

/* A device without states in its word can only be told by the ring that it has no position. */
static void ask_ring(struct master *self, modbus_t *coupler, struct device *ring)
{
    uint16_t in[IMAGE_WORDS];
    const uint16_t before = coupler_status(coupler);
    const int64_t from = now_ns();
    if (modbus_read_input_registers(coupler, 0, IMAGE_WORDS, in) != IMAGE_WORDS) {
        die("coupler");
    }
    took(self, from);
    const uint16_t status = before | coupler_status(coupler);
    if ((status & STATUS_BUS_ERROR) != 0) {
        become(ring, "bus-error");
    } else if ((status & STATUS_MODULE_ERROR) != 0) {
        become(ring, "module-error");
    } else {
        become(ring, "ok");
        for (size_t i = 0; i < self->count; i++) {
            look_at(self, &self->device[i], &in[self->device[i].address], from);
        }
    }
}

void run_ring(struct master *self)
{
    struct device ring = {.name = "ring"};
    modbus_t *coupler = modbus_new_tcp("127.0.0.1", (int)strtol(self->where, NULL, 10));
    if (coupler == NULL || modbus_connect(coupler) != 0) {
        die(self->where);
    }
    (void)modbus_set_response_timeout(coupler, 5, 0);
    for (int64_t at = now_ns(); goes_on(self); at += RING_PERIOD) {
        ask_ring(self, coupler, &ring);
        at = at > now_ns() - RING_PERIOD ? at : now_ns() - RING_PERIOD;
        sleep_until(at + RING_PERIOD);
    }
    modbus_close(coupler);
    modbus_free(coupler);
}
