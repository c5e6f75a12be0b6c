/* SPDX-License-Identifier: MIT */
/*
 * Error stack, start-up checks and monitors (5.1.1.2 'Error displays', 5.1.2.13, 5.1.3).
 */
#include <string.h>

#include "hf.h"

/* A code that is waiting already is not entered again; the oldest gives way (5.1.2.13, R9). */
void dg_hf_push(struct dg_hf *self, enum dg_hf_status status)
{
    for (uint8_t i = 0; i < self->stack_count; i++) {
        if (self->stack[i] == (uint8_t)status) {
            return;
        }
    }
    if (self->stack_count == DG_HF_STACK_DEPTH) {
        memmove(&self->stack[0], &self->stack[1], DG_HF_STACK_DEPTH - 1u);
        self->stack_count--;
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

/* Every damaged region: its own code, then 06h; and what it locks. */
void dg_hf_start_up_checks(struct dg_hf *self)
{
    static const struct {
        uint8_t code;
        uint8_t lock;
    } locks[] = {
        {DG_HF_COMPENSATION, HF_LOCK_POSITION}, {DG_HF_ANGLE_OFFSET, HF_LOCK_POSITION},
        {DG_HF_PARTITION, HF_LOCK_FIELDS},      {DG_HF_I2C, HF_LOCK_EEPROM},
        {DG_HF_COUNTER, HF_LOCK_CHECKSUM},      {DG_HF_FIELD_NUMBER, HF_LOCK_POSITION},
    };

    for (uint8_t region = 0; region < DG_HF_REGION_COUNT; region++) {
        if (!dg_store_damaged(&self->store, region)) {
            continue;
        }
        uint8_t code = dg_hf_layout.regions[region].startup_code;
        dg_hf_push(self, (enum dg_hf_status)code);
        dg_hf_push(self, DG_HF_CHECKSUM_INTERNAL);
        self->locks |= HF_LOCK_CHECKSUM;
        for (uint8_t i = 0; i < sizeof locks / sizeof locks[0]; i++) {
            if (locks[i].code == code) {
                self->locks |= locks[i].lock;
            }
        }
    }
}

/* Group 'Others': entered when a quantity leaves its limits, once until it has been back. */
void dg_hf_monitor(struct dg_hf *self)
{
    const struct dg_world *world = self->setup.world;
    int32_t min_mdegc = self->temperature_min_degc * 1000;
    int32_t max_mdegc = self->temperature_max_degc * 1000;
    const struct {
        bool out;
        uint8_t status;
    } monitors[] = {
        {world->led_current_ua > self->led_max_ma * 1000u, DG_HF_LED_CURRENT},
        {world->temperature_mdegc < min_mdegc || world->temperature_mdegc > max_mdegc,
         DG_HF_TEMPERATURE},
    };

    for (uint8_t i = 0; i < sizeof monitors / sizeof monitors[0]; i++) {
        uint8_t bit = (uint8_t)(1u << i);
        if (monitors[i].out && (self->monitors & bit) == 0) {
            dg_hf_push(self, (enum dg_hf_status)monitors[i].status);
        }
        self->monitors = (uint8_t)(monitors[i].out ? self->monitors | bit : self->monitors & ~bit);
    }
}
