/* SPDX-License-Identifier: MIT */
/* A device on the bus: power, the data cycle, the ID cycle, LEDs; how long a cycle takes. */
#include "drehgeber/angle.h"
#include "drehgeber/wide.h"
#include "interbus_private.h"

#define MESSAGE_RECONFIGURE 0x8000u
#define MESSAGE_CRC 0x4000u
#define MESSAGE_MODULE 0x2000u
/* Class bytes of the Loop have other upper bits, 36h -> B2h, 37h -> B3h (2.2). */
#define CLASS_LOOP 0x84u
#define CLASS_MASK 0xFFu
#define OPC_CLASS 12u

/* Fastest change of the LSB with a valid code word (6.1): 800 kHz, in steps a turn * 0.001 rpm. */
#define FASTEST ((uint64_t)800000 * 60000)

/* By profile: ID word, and words of a window (2.1, 2.2). */
static const struct {
    uint16_t id;
    uint8_t words;
} profiles[DG_IB_PROFILE_COUNT] = {
    [DG_IB_K1] = {0x0136, 1},
    [DG_IB_K2] = {0x0236, 2},
    [DG_IB_K3] = {0x0237, 2},
};

uint16_t dg_ib_id_word(const struct dg_ib_model *model)
{
    const uint16_t id = profiles[model->profile].id;

    if (model->id_code != 0) {
        return (uint16_t)((id & ~CLASS_MASK) | model->id_code);
    }
    return (uint16_t)(id ^ (model->loop ? CLASS_LOOP : 0u));
}

uint8_t dg_ib_image_words(const struct dg_ib_model *model)
{
    return profiles[model->profile].words;
}

static bool memory_is_there(const struct dg_ib_setup *setup)
{
    return setup->model->profile != DG_IB_K3 || setup->nvm.ops != NULL;
}

int dg_ib_init(struct dg_ib *self, const struct dg_ib_setup *setup)
{
    if (setup->model == NULL || setup->world == NULL || !memory_is_there(setup)) {
        return DG_ERR_ARGUMENT;
    }
    if (dg_ib_model_check(setup->model) != DG_OK) {
        return DG_ERR_ARGUMENT;
    }
    *self = (struct dg_ib){.setup = *setup, .mode = DG_IB_POSITION_K2};
    self->opc[OPC_CLASS] = (uint8_t)dg_ib_id_word(setup->model);
    return DG_OK;
}

/* Everything that does not survive without power. */
static void forget_commands(struct dg_ib *self, dg_ns now)
{
    const struct dg_ib before = *self;

    *self = (struct dg_ib){
        .setup = before.setup,
        .counters = before.counters,
        .reconfigure = before.reconfigure,
        .ready_at = dg_after(now, before.setup.model->self_test),
        .time_mark = now,
        .last_id = DG_NEVER,
        .last_data = DG_NEVER,
        .out = IB_RELEASE, /* I2: one that stands there already releases nothing */
        .mode = DG_IB_POSITION_K2,
        .program_number = 1,
    };
    for (uint8_t i = 0; i < DG_IB_OPC_REGISTERS; i++) {
        self->opc[i] = before.opc[i];
    }
}

int dg_ib_power_on(struct dg_ib *self, dg_ns now)
{
    forget_commands(self, now);
    if (self->setup.model->profile == DG_IB_K3) {
        const int result = self->setup.world->eeprom_acknowledges
                               ? dg_ib_mount(&self->store, self->setup.model, self->setup.nvm)
                               : DG_ERR_IO;
        self->mounted = result == DG_OK;
        if (result != DG_OK && result != DG_ERR_IO) {
            return result;
        }
        dg_ib_load(self); /* of a silent memory everything is lost, until the next start */
    }
    self->powered = true;
    return DG_OK;
}

void dg_ib_power_off(struct dg_ib *self)
{
    self->powered = false;
}

static void count_tens_of_minutes(struct dg_ib *self, dg_ns now)
{
    dg_ns passed = dg_elapsed(now, self->time_mark);

    if (passed >= IB_TIME_UNIT) {
        self->time_10min += (uint32_t)(passed / IB_TIME_UNIT);
        self->time_mark += passed - passed % IB_TIME_UNIT;
        (void)dg_ib_put_u32(self, DG_IB_REGION_TIME, self->time_10min);
    }
}

/* No valid position; a module error of K1 and K2 (I19). */
static inline bool is_invalid(const struct dg_ib *self, dg_ns now, int32_t mrpm)
{
    const struct dg_world *world = self->setup.world;
    const struct dg_ib_model *model = self->setup.model;
    const uint32_t speed = mrpm < 0 ? 0 - (uint32_t)mrpm : (uint32_t)mrpm;
    const uint64_t lsb = dg_product(speed, model->steps);

    if (now < self->ready_at || lsb > FASTEST || !world->singleturn_ok) {
        return true;
    }
    return model->turns > 1 && !(world->multiturn_amplitude_ok && world->multiturn_sync_ok &&
                                 world->multiturn_vector_ok);
}

/* I5: as long as 60000000h stands on the bus. What it led to is stored when it ends. */
static void hold_preset(struct dg_ib *self, dg_ns now)
{
    if (!self->frozen) {
        return;
    }
    self->frozen = self->out == IB_FRABA_PRESET;
    if (self->frozen) {
        self->offset = dg_ib_preset_offset(self, now);
    } else if (!dg_ib_put_preset(self, self->preset, self->offset, self->preset_flag)) {
        dg_ib_refuse(self, DG_IB_LOST);
    }
}

/* What a K3 shows in operation. */
static uint32_t operation_word_of(const struct dg_ib *self, const struct ib_latch *latch)
{
    uint32_t word;

    if (self->lost != 0) {
        return DG_IB_LOST;
    }
    if (self->mode > DG_IB_CAM) {
        word = dg_ib_cam_word(self, latch->angle);
    } else {
        word = self->mode == DG_IB_SPEED ? dg_ib_speed(self, latch->mrpm)
                                         : dg_ib_position_at(self, latch->angle);
    }
    return word | (self->invalid ? DG_IB_NOT_VALID : 0u);
}

static uint32_t cycle_k3(struct dg_ib *self, dg_ns now, uint32_t out, const struct ib_latch *latch)
{
    count_tens_of_minutes(self, now);
    if (now < self->ready_at) {
        return DG_IB_READ_OUT; /* I18: self-test */
    }
    if (self->wait > 0) {
        dg_ib_execute(self, now);
    }
    hold_preset(self, now);
    if (out != self->out || !self->sampled) {
        dg_ib_sample(self, out);
    }
    if (self->item != 0) {
        return dg_ib_item(self);
    }
    return self->answer != 0 ? self->answer : operation_word_of(self, latch);
}

void dg_ib_cycle(struct dg_ib *self, dg_ns now, uint32_t out, uint32_t *in)
{
    if (!self->powered) {
        return;
    }
    self->counters.cycles++;
    self->last_data = now;
    struct ib_latch latch;
    latch.mrpm = dg_world_moving(self->setup.world, now, &latch.angle);
    self->invalid = is_invalid(self, now, latch.mrpm);
    if (self->setup.model->profile == DG_IB_K3) {
        *in = cycle_k3(self, now, out, &latch);
    } else {
        *in = now < self->ready_at ? 0 : dg_ib_position_at(self, latch.angle);
    }
}

bool dg_ib_module_error(const struct dg_ib *self)
{
    return self->invalid && self->setup.model->profile != DG_IB_K3; /* I19 */
}

uint16_t dg_ib_id(struct dg_ib *self, dg_ns now)
{
    unsigned word = dg_ib_id_word(self->setup.model);

    self->last_id = now;
    self->invalid = is_invalid(self, now, dg_world_speed_mrpm(self->setup.world, now));
    word |= self->reconfigure ? MESSAGE_RECONFIGURE : 0u;
    word |= self->crc_error ? MESSAGE_CRC : 0u;
    word |= dg_ib_module_error(self) ? MESSAGE_MODULE : 0u;
    self->reconfigure = false;
    self->crc_error = false;
    return (uint16_t)word;
}

static bool recent(dg_ns now, dg_ns then)
{
    return then != DG_NEVER && dg_elapsed(now, then) <= DG_IB_BUS_TIMEOUT;
}

uint8_t dg_ib_leds(const struct dg_ib *self, dg_ns now)
{
    unsigned leds = DG_IB_LED_UL;

    if (!self->powered) {
        return 0;
    }
    leds |= self->outgoing_off ? DG_IB_LED_RD : 0u;
    if (recent(now, self->last_data)) {
        leds |= DG_IB_LED_RC | DG_IB_LED_BA;
    } else if (recent(now, self->last_id)) {
        leds |= DG_IB_LED_RC;
        if (self->last_data != DG_NEVER) {
            leds |= DG_IB_LED_BA_BLINKS | (now / DG_IB_BLINK % 2 == 0 ? DG_IB_LED_BA : 0u);
        }
    }
    return (uint8_t)leds;
}

uint32_t dg_ib_bit_times(uint32_t bytes, uint32_t devices)
{
    return 13u * (6u + bytes) + 4u * devices;
}

dg_ns dg_ib_cycle_time(uint32_t words, uint32_t devices, uint32_t baud, dg_ns software)
{
    return dg_after(dg_bit_times_ns(dg_ib_bit_times(2u * words, devices), baud), software);
}
