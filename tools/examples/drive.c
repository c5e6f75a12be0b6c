/* SPDX-License-Identifier: MIT */
/*
 * A drive loop in virtual time against all four encoders on one motor shaft. Every millisecond the
 * drive reads them as a master does, takes the speed from BiSS, and sets the motor's torque. Every
 * 100 ms it prints what it has read; in the end it says whether the four have always agreed.
 */
#include <stdio.h>
#include <string.h>

#include "drehgeber/drehgeber.h"

#define CYCLE DG_MS(1)
#define POWER_UP_MS 200u
#define END_MS 2400u
/* An exchange of 42h takes 18 ms at 9600 Bd. */
#define RS485_EVERY_MS 20u
#define PRINT_EVERY_MS 100u
/* All positions are compared in the OCD's steps: 4096 a turn, 4096 turns. */
#define STEP_BITS 24u
#define BISS_BITS 33u
/* The controller: 0.001 rpm/s for 0.001 rpm, and for 0.001 rpm over 1 s. */
#define PROPORTIONAL 100
#define INTEGRAL 1500
#define ACCELERATION_MAX 40000000

struct memory {
    uint8_t bytes[16384];
};

struct drive {
    struct dg_shaft motor;
    struct dg_world world;
    struct memory memory[4];
    struct dg_hf rs485;
    struct dg_biss biss;
    struct dg_co_node can;
    struct dg_cia406 can_encoder;
    struct dg_ib interbus;
    uint32_t position[4]; /* RS485, BiSS, CANopen, INTERBUS */
    bool rs485_replied;   /* in this cycle */
    uint64_t biss_counts; /* of the last frame */
    int64_t mrpm;
    int64_t sum;
    unsigned faults;
};

static int read_memory(void *ctx, uint32_t address, void *to, size_t n)
{
    memcpy(to, (const uint8_t *)ctx + address, n);
    return DG_OK;
}

static int write_memory(void *ctx, uint32_t address, const void *from, size_t n)
{
    memcpy((uint8_t *)ctx + address, from, n);
    return DG_OK;
}

static void rs485_tx(void *ctx, const uint8_t *bytes, size_t n)
{
    struct drive *self = ctx;

    self->rs485_replied = n == 7 && bytes[1] == 0x42;
    self->faults += self->rs485_replied ? 0u : 1u;
    self->position[0] = dg_load_be32(bytes + 2) >> (28 - STEP_BITS);
}

static void can_send(void *ctx, const struct dg_can_frame *frame)
{
    struct drive *self = ctx;

    if (frame->id == 0x280u + self->can.id) {
        self->position[2] = dg_load_le32(frame->data) >> (28 - STEP_BITS);
    }
}

static const struct dg_nvm_ops nvm_ops = {read_memory, write_memory, NULL};
static const struct dg_hf_ops rs485_ops = {rs485_tx};
static const struct dg_co_ops can_ops = {can_send, NULL};

/* Deliver the four, plug them onto the shaft, and switch them on. @return 0 when all went well */
static int power_up(struct drive *self)
{
    const struct dg_hf_model *rs485 = dg_hf_model_of(dg_device_find("s3684-rs485"));
    const struct dg_biss_model *biss = dg_biss_model_of(dg_device_find("s3684-biss"));
    const struct dg_cia406_model *can = dg_cia406_model_of(dg_device_find("f3668"));
    const struct dg_ib_model *interbus = dg_ib_model_of(dg_device_find("ocd-ib-k3"));
    struct dg_nvm nvm[4];

    for (size_t i = 0; i < 4; i++) {
        nvm[i] = (struct dg_nvm){&nvm_ops, &self->memory[i]};
    }
    const struct dg_hf_setup rs485_setup = {rs485, &self->world, nvm[0], &rs485_ops, self};
    const struct dg_biss_setup biss_setup = {biss, &self->world, nvm[1]};
    const struct dg_co_setup can_setup = {can->device, &self->world, nvm[2],
                                          &can_ops,    self,         &self->can_encoder};
    const struct dg_ib_setup interbus_setup = {interbus, &self->world, nvm[3]};

    dg_shaft_init(&self->motor);
    dg_world_init(&self->world);
    self->world.angle = dg_shaft_angle;
    self->world.angle_ctx = &self->motor;
    return dg_hf_format(rs485, nvm[0]) || dg_hf_init(&self->rs485, &rs485_setup) ||
           dg_hf_power_on(&self->rs485, 0) || dg_biss_format(nvm[1]) ||
           dg_biss_init(&self->biss, &biss_setup) || dg_biss_power_on(&self->biss, 0) ||
           dg_co_format(can->device, nvm[2], 1) || dg_cia406_init(&self->can_encoder, can) ||
           dg_co_init(&self->can, &can_setup) || dg_co_power_on(&self->can, 0) ||
           dg_ib_format(interbus, nvm[3]) || dg_ib_init(&self->interbus, &interbus_setup) ||
           dg_ib_power_on(&self->interbus, 0);
}

/* 42h, a character at a time; the reply comes, and its position is latched, in some later cycle. */
static void read_rs485(struct drive *self, dg_ns now, unsigned ms)
{
    static const uint8_t request[] = {0x40, 0x42, 0x02};
    const dg_ns begin = now - CYCLE * (ms % RS485_EVERY_MS);

    self->rs485_replied = false;
    for (uint32_t i = 0; i < sizeof request; i++) {
        const dg_ns at = begin + dg_bit_times_ns(11 * (i + 1), 9600);
        if (at > now - CYCLE && at <= now) {
            (void)dg_hf_rx(&self->rs485, at, request[i], DG_HF_RX_OK);
        }
    }
    (void)dg_hf_step(&self->rs485, now);
}

/* One frame: CDS, 12 bit turns, 21 bit angle, nERR, nWARN, life counter, CRC. */
static void read_biss(struct drive *self, dg_ns now)
{
    struct dg_biss_data data;
    uint64_t bits = 0;
    const uint8_t n = dg_biss_frame(&self->biss, now, &bits);

    dg_biss_frame_end(&self->biss, now + DG_US(60), false);
    dg_biss_frame_decode(self->biss.setup.model, bits, &data);
    const bool good = n == 48 && data.crc_ok && data.n_err && data.n_warn;
    const uint64_t counts = data.position;
    /* Modulo the range, with sign: 2^21 counts in 1 ms are 60 000 000 * 0.001 rpm. */
    int64_t way = (int64_t)((counts - self->biss_counts) & (((uint64_t)1 << BISS_BITS) - 1));
    way -= way >> (BISS_BITS - 1) << BISS_BITS;
    self->mrpm = way * 60000000 / (1 << 21);
    self->biss_counts = counts;
    self->position[1] = (uint32_t)(counts >> (BISS_BITS - STEP_BITS));
    self->faults += good ? 0u : 1u;
}

static void read_can(struct drive *self, dg_ns now)
{
    const struct dg_can_frame sync = {.id = 0x80};

    self->position[2] = UINT32_MAX; /* the TPDO has to come in the same call */
    (void)dg_co_step(&self->can, now);
    (void)dg_co_rx(&self->can, now, &sync);
}

static void read_interbus(struct drive *self, dg_ns now)
{
    uint32_t in = DG_IB_NOT_VALID;

    dg_ib_cycle(&self->interbus, now, 0, &in);
    self->faults += (in & DG_IB_NOT_VALID) == 0 ? 0u : 1u;
    self->position[3] = in & DG_IB_DATA_MASK;
}

/* A PI controller of the speed. Its output is the torque: an acceleration until the next cycle. */
static void control(struct drive *self, dg_ns now, int64_t wanted_mrpm)
{
    const int64_t error = wanted_mrpm - self->mrpm;
    int64_t output = PROPORTIONAL * error + INTEGRAL * self->sum / 1000;

    if (output > ACCELERATION_MAX || output < -ACCELERATION_MAX) {
        output = output > 0 ? ACCELERATION_MAX : -ACCELERATION_MAX; /* and no windup */
    } else {
        self->sum += error;
    }
    const bool down = output < 0;
    (void)dg_shaft_set_acceleration(&self->motor, (down ? -output : output) + 1); /* 0: at once */
    (void)dg_shaft_set_velocity(&self->motor, now,
                                down ? -DG_MOTION_SPEED_MAX_MRPM : DG_MOTION_SPEED_MAX_MRPM);
}

/* Forward, back through zero and to a standstill. */
static int64_t wanted_mrpm_at(unsigned ms)
{
    static const int64_t profile[] = {3000000, -1500000, 0};

    return profile[ms * 3 / END_MS];
}

/* @return whether all have told the same position, that of the moment `now` */
static bool cycle(struct drive *self, unsigned ms)
{
    const dg_ns now = CYCLE * (POWER_UP_MS + ms);

    read_rs485(self, now, ms);
    read_biss(self, now);
    read_can(self, now);
    read_interbus(self, now);
    control(self, now, wanted_mrpm_at(ms));
    if (self->rs485_replied && ms % PRINT_EVERY_MS < RS485_EVERY_MS) {
        printf("%5u %6d %9.3f %9u %9u %9u %9u\n", ms, (int)(wanted_mrpm_at(ms) / 1000),
               (double)self->mrpm / 1000, (unsigned)self->position[0], (unsigned)self->position[1],
               (unsigned)self->position[2], (unsigned)self->position[3]);
    }
    return self->position[1] == self->position[2] && self->position[2] == self->position[3] &&
           (!self->rs485_replied || self->position[0] == self->position[3]);
}

int main(void)
{
    static struct drive drive;
    const struct dg_can_frame start = {.dlc = 2, .data = {1, 0}}; /* NMT, all nodes */
    unsigned replies = 0;
    unsigned disagreements = 0;

    if (power_up(&drive)) {
        return 1;
    }
    (void)dg_co_rx(&drive.can, CYCLE, &start);
    (void)dg_ib_id(&drive.interbus, CYCLE);
    printf("   ms    rpm      is       RS485      BiSS   CANopen  INTERBUS\n");
    for (unsigned ms = 0; ms < END_MS; ms++) {
        disagreements += cycle(&drive, ms) ? 0u : 1u;
        replies += drive.rs485_replied ? 1u : 0u;
    }
    const bool stands = drive.mrpm > -1000 && drive.mrpm < 1000;
    const bool good =
        disagreements == 0 && drive.faults == 0 && stands && replies == END_MS / RS485_EVERY_MS;

    printf("%u cycles, %u replies on RS485, %u faults: %s\n", END_MS, replies, drive.faults,
           good ? "all four agree" : "they do not agree");
    return good ? 0 : 1;
}
