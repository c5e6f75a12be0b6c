/* SPDX-License-Identifier: MIT */
/*
 * Error stack, start-up checks and monitors (5.1.1.2 'Error displays', 5.1.2.13, 5.1.3).
 */
#include <string.h>

#include "hiperface_private.h"

/* A code that is waiting already is not entered again; the oldest gives way (5.1.2.13, R9). */
void dg_hf_push(struct dg_hf *self, enum dg_hf_status status)
{
    for (uint8_t i = 0; i < self->stack_count; i++) {
        if (self->stack[i] == (uint8_t)status) {
            return;
        }
    }
    if (self->stack_count >= DG_HF_STACK_DEPTH) {
        memmove(&self->stack[0], &self->stack[1], DG_HF_STACK_DEPTH - 1u);
        self->stack_count = DG_HF_STACK_DEPTH - 1u;
    }
    self->stack[self->stack_count++] = (uint8_t)status;
}

enum dg_hf_status dg_hf_read_status(struct dg_hf *self, struct hf_request *rq)
{
    uint8_t oldest = DG_HF_NO_ERROR;

    if (self->stack_count > 0) {
        oldest = self->stack[0];
        memmove(&self->stack[0], &self->stack[1], DG_HF_STACK_DEPTH - 1u);
        self->stack_count--;
    }
    dg_write_u8(&rq->reply, oldest);
    return DG_HF_NO_ERROR;
}

enum dg_hf_status dg_hf_io(int result)
{
    return result == DG_OK ? DG_HF_NO_ERROR : DG_HF_I2C;
}

enum dg_hf_status dg_hf_get(struct dg_hf *self, enum dg_hf_region region, void *to)
{
    uint16_t size = dg_hf_layout.regions[region].size;

    return dg_hf_io(dg_store_read(&self->store, (uint8_t)region, 0, to, size));
}

enum dg_hf_status dg_hf_put(struct dg_hf *self, enum dg_hf_region region, const void *from)
{
    uint16_t size = dg_hf_layout.regions[region].size;

    return dg_hf_io(dg_store_put(&self->store, (uint8_t)region, 0, from, size));
}

/* Every damaged region: its own code, then 06h; and what it locks besides what 06h does. Of the
 * regions with 03h each locks the commands that are about it (R25). */
void dg_hf_start_up_checks(struct dg_hf *self)
{
    static const uint8_t locks[DG_HF_REGION_COUNT] = {
        [DG_HF_REGION_RESOLUTION] = HF_LOCK_POSITION, [DG_HF_REGION_CALIBRATION] = HF_LOCK_POSITION,
        [DG_HF_REGION_OFFSET] = HF_LOCK_POSITION,     [DG_HF_REGION_SYNC] = HF_LOCK_POSITION,
        [DG_HF_REGION_UART] = HF_LOCK_UART,           [DG_HF_REGION_MEMORY] = HF_LOCK_FIELDS,
        [DG_HF_REGION_CODES] = HF_LOCK_CODES,         [DG_HF_REGION_FIELDS] = HF_LOCK_FIELDS,
        [DG_HF_REGION_TYPE] = HF_LOCK_EEPROM,         [DG_HF_REGION_LABEL] = HF_LOCK_POSITION,
        [DG_HF_REGION_STEPS] = HF_LOCK_POSITION,      [DG_HF_REGION_IMPLEMENTED] = HF_LOCK_FIELDS,
    };

    for (uint8_t region = 0; region < DG_HF_REGION_COUNT; region++) {
        if (dg_store_damaged(&self->store, region)) {
            dg_hf_push(self, (enum dg_hf_status)dg_hf_layout.regions[region].startup_code);
            dg_hf_push(self, DG_HF_CHECKSUM_INTERNAL);
            self->locks |= (uint8_t)(HF_LOCK_CHECKSUM | locks[region]);
        }
    }
}

enum dg_hf_status dg_hf_corrupt(struct dg_hf *self)
{
    dg_hf_push(self, DG_HF_PARTITION);
    dg_hf_push(self, DG_HF_CHECKSUM_INTERNAL);
    self->locks |= HF_LOCK_WRITE;
    return DG_HF_PARTITION;
}

/* A monitored quantity: entered when it leaves its limits, once until it has been back. */
static void watch_quantity(struct dg_hf *self, uint8_t bit, bool out, enum dg_hf_status status)
{
    if (out && (self->monitors & bit) == 0) {
        dg_hf_push(self, status);
    }
    self->monitors = (uint8_t)(out ? self->monitors | bit : self->monitors & ~bit);
}

/* Group 'Others'. */
void dg_hf_monitor(struct dg_hf *self)
{
    const struct dg_world *world = self->setup.world;
    const int32_t mdegc = world->temperature_mdegc;
    const bool led = world->led_current_ua > self->led_max_ma * 1000u;
    const bool temperature =
        mdegc < self->temperature_min_degc * 1000 || mdegc > self->temperature_max_degc * 1000;

    if (!led && !temperature && self->monitors == 0) {
        return;
    }
    watch_quantity(self, 1u, led, DG_HF_LED_CURRENT);
    watch_quantity(self, 2u, temperature, DG_HF_TEMPERATURE);
}
