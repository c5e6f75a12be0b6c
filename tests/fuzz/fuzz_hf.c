/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: an S36 with RS485 in a hostile world. The input is a stream of operations:
 * characters, whole requests, time, a bent world, a rotting, failing or powerless EEPROM. After
 * each one: nothing overflows, every reply is well formed and belongs to exactly one frame for this
 * device.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/devices.h"
#include "fuzz_input.h"
#include "hf_rig.h"

/* The device under test and what the observer knows about the line. */
struct bench {
    struct hf_rig rig;
    struct dg_hf_model model;
    bool pending;     /* a frame for this device has begun and is not answered */
    unsigned replies; /* seen so far */
};

static uint64_t range(const struct dg_hf *device)
{
    return (uint64_t)device->periods * device->steps * device->turns;
}

/* The newest reply (5.1.1.2). Its frame's command is still in the device's buffer. */
static void check_reply(struct bench *bench)
{
    const struct dg_hf *device = &bench->rig.device;
    const uint8_t *reply = bench->rig.reply;
    const size_t n = bench->rig.reply_length;
    const uint8_t command = reply[1] & 0x7Fu;

    fuzz_must(bench->pending);
    bench->pending = false;
    fuzz_must(n >= 3 && n <= DG_HF_FRAME_MAX);
    fuzz_must(hf_rig_xor(reply, n) == 0);
    fuzz_must(reply[0] == device->address);
    fuzz_must(command == 0x50 || command == device->frame[1]);
    fuzz_must(command != 0x50 || n == 4);
    fuzz_must(((reply[1] & 0x80u) != 0) == (device->stack_count > 0));
    fuzz_must(command != 0x4A || (n == 6u + reply[4] && reply[3] + reply[4] <= 128));
    fuzz_must(command != 0x42 || (n == 7 && dg_load_be32(&reply[2]) < range(device)));
}

/* After every call into the device. */
static void check(struct bench *bench)
{
    const struct dg_hf *device = &bench->rig.device;
    struct dg_hf_sincos sincos;

    fuzz_must(bench->rig.replies - bench->replies <= 1);
    if (bench->rig.replies != bench->replies) {
        check_reply(bench);
    }
    bench->replies = bench->rig.replies;
    fuzz_must(device->stack_count <= DG_HF_STACK_DEPTH);
    fuzz_must(device->length <= DG_HF_FRAME_MAX + 1u);
    fuzz_must(dg_hf_position(device, bench->rig.now) < range(device));
    dg_hf_sincos(device, bench->rig.now, &sincos);
    fuzz_must(sincos.sin_plus_uv + sincos.sin_minus_uv == 5000000);
}

static void pass(struct bench *bench, uint64_t ns)
{
    bench->rig.now = dg_after(bench->rig.now, ns);
}

static void step_encoder(struct bench *bench)
{
    const dg_ns deadline = dg_hf_step(&bench->rig.device, bench->rig.now);

    fuzz_must(deadline > bench->rig.now || deadline == DG_NEVER);
    check(bench);
}

/* A frame that ends without a reply is a reset (5.1.2.15). */
static void close_unanswered(struct bench *bench)
{
    fuzz_must(!bench->pending || bench->rig.device.frame[1] == 0x53);
    bench->pending = false;
}

static void character(struct bench *bench, uint8_t byte, uint8_t flags)
{
    const struct dg_hf *device = &bench->rig.device;

    (void)dg_hf_rx(&bench->rig.device, bench->rig.now, byte, flags);
    check(bench);
    if (device->line == DG_HF_COLLECT && device->length == 1 && (flags & DG_HF_RX_START) == 0) {
        close_unanswered(bench);
        fuzz_must(flags == DG_HF_RX_OK);
        fuzz_must(byte == device->address || byte == DG_HF_ADDRESS_BROADCAST);
        bench->pending = true;
    } else if (device->line != DG_HF_COLLECT && device->line != DG_HF_REPLY) {
        close_unanswered(bench);
    }
}

/* Characters one after the other, then silence until the reply is out or nothing comes. */
static void frame(struct bench *bench, const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        pass(bench, DG_MS(1));
        character(bench, bytes[i], DG_HF_RX_OK);
    }
    for (int i = 0; i < 4; i++) {
        pass(bench, DG_MS(50));
        step_encoder(bench);
    }
}

static void request(struct bench *bench, const uint8_t *command, size_t n)
{
    uint8_t bytes[DG_HF_FRAME_MAX + 8u] = {bench->rig.device.address};

    memcpy(&bytes[1], command, n);
    bytes[n + 1] = hf_rig_xor(bytes, n + 1);
    frame(bench, bytes, n + 2);
}

/* Operations; each takes what it needs from the input. */

static void op_character(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    pass(bench, (uint64_t)(how >> 2) << 18);
    character(bench, fuzz_take(input), how & 3u);
}

/* A request in order but for its data. */
static void op_request(struct bench *bench, struct fuzz_input *input)
{
    uint8_t command[DG_HF_FRAME_MAX];
    const size_t n = 1u + fuzz_take(input) % (sizeof command - 1u);

    for (size_t i = 0; i < n; i++) {
        command[i] = fuzz_take(input);
    }
    request(bench, command, n);
}

/* A valid request, one of its bytes perhaps replaced. */
static void op_known_request(struct bench *bench, struct fuzz_input *input)
{
    static const char *const known[] = {
        "42",
        "43 00 00 12 34 55",
        "44 48",
        "46",
        "47",
        "49 55",
        "4A 00 00 10 55",
        "4A FF 00 40 00",
        "4B 00 00 04 55 01 02 03 04",
        "4C 00",
        "4D 00 CF 55",
        "4D 01 DB 55",
        "4D 01 5B 55",
        "4E",
        "4F 01 55 66",
        "50",
        "52",
        "53",
        "55 41 55",
        "56",
        "57 C3 55",
        "57 E6 55",
        "6A 00 00 12 34 55",
        "43 FF FF FF FF 55",
        "43 00 00 00 00 55",
    };
    uint8_t command[32];
    const size_t n =
        hf_rig_hex(known[fuzz_take(input) % (DG_COUNT(known))], command, sizeof command);
    const size_t at = fuzz_take(input) % (2u * n);

    if (at < n) {
        command[at] = fuzz_take(input);
    }
    request(bench, command, n);
}

static void op_time(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    pass(bench, (uint64_t)fuzz_take(input) << (how & 63u));
    if ((how & 64u) != 0) {
        step_encoder(bench);
    }
}

static void op_shaft(struct bench *bench, struct fuzz_input *input)
{
    bench->rig.angle = (dg_angle)((uint64_t)fuzz_take32(input) << 32 | fuzz_take32(input));
    bench->rig.angle_per_ms = (int64_t)(int32_t)fuzz_take32(input) * 256;
    check(bench);
}

static void op_quantities(struct bench *bench, struct fuzz_input *input)
{
    struct dg_world *world = &bench->rig.world;

    world->temperature_mdegc = (int32_t)fuzz_take32(input);
    world->led_current_ua = fuzz_take32(input);
    world->sin_amplitude_permille = (uint16_t)(fuzz_take32(input) % 2001u);
    world->cos_amplitude_permille = (uint16_t)(fuzz_take32(input) % 2001u);
    world->sin_offset_permille = (int16_t)(fuzz_take32(input) % 2001u - 1000u);
    world->cos_offset_permille = (int16_t)(fuzz_take32(input) % 2001u - 1000u);
}

static void op_sensors(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t bits = fuzz_take(input);

    bench->rig.world.singleturn_ok = (bits & 1u) != 0;
    bench->rig.world.multiturn_amplitude_ok = (bits & 2u) != 0;
    bench->rig.world.multiturn_sync_ok = (bits & 4u) != 0;
    bench->rig.world.multiturn_vector_ok = (bits & 8u) != 0;
    bench->rig.world.eeprom_acknowledges = (bits & 16u) != 0;
}

static void op_rot(struct bench *bench, struct fuzz_input *input)
{
    const uint32_t where = fuzz_take32(input);

    bench->rig.nvm.bytes[(where >> 3) % bench->rig.nvm.size] ^= (uint8_t)(1u << (where & 7u));
}

static void op_io_failure(struct bench *bench, struct fuzz_input *input)
{
    bench->rig.fail_from = bench->rig.accesses + fuzz_take(input) % 64u;
    bench->rig.fail_count = fuzz_take(input) % 8u;
}

static void op_power_cut(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    ram_nvm_cut(&bench->rig.nvm, how & 31u, (enum ram_nvm_tear)((how >> 5) % RAM_NVM_TEAR_COUNT),
                fuzz_take(input));
}

static void op_power(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    if ((how & 1u) != 0) {
        ram_nvm_restore(&bench->rig.nvm);
    }
    bench->pending = false;
    const int result = dg_hf_power_on(&bench->rig.device, bench->rig.now);
    fuzz_must(result == DG_OK || result == DG_ERR_BLANK || result == DG_ERR_FOREIGN);
    fuzz_must((result != DG_OK) == (bench->rig.device.line == DG_HF_OFF));
    if ((how & 6u) == 6u) {
        dg_hf_power_off(&bench->rig.device);
    }
    check(bench);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct bench *, struct fuzz_input *) = {
        op_character, op_request,    op_known_request, op_time,      op_shaft, op_quantities,
        op_sensors,   op_io_failure, op_rot,           op_power_cut, op_power,
    };
    static struct bench bench;
    struct fuzz_input input = {.at = bytes, .end = bytes + n};

    memset(&bench, 0, sizeof bench);
    const char *const model = (fuzz_take(&input) & 1u) != 0 ? "s3684-rs485" : "s3674-rs485";
    bench.model = *dg_hf_model_of(dg_device_find(model));
    const uint8_t how = fuzz_take(&input);
    if ((how & 1u) != 0) {
        bench.model.periods_per_turn = (uint16_t)fuzz_take32(&input);
        bench.model.steps_per_period = (how & 4u) != 0 ? fuzz_take32(&input) : fuzz_take(&input);
        bench.model.turns = fuzz_take32(&input);
        bench.model.implemented_blocks = (how & 8u) != 0 ? fuzz_take(&input) : 0;
    }
    if (hf_rig_init(&bench.rig, &bench.model) != DG_OK) {
        return 0;
    }
    fuzz_must(dg_hf_power_on(&bench.rig.device, 0) == DG_OK);
    if ((how & 2u) != 0) {
        fuzz_must(hf_rig_ask(&bench.rig, "4D 00 C9 55") == 0); /* a data field to begin with */
        bench.replies = bench.rig.replies;
    }
    while (input.at < input.end) {
        operations[fuzz_take(&input) % (DG_COUNT(operations))](&bench, &input);
    }
    return 0;
}
