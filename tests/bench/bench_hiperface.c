/* SPDX-License-Identifier: MIT */
/*
 * The S36 with RS485: requests as a port would see them, characters, the end of the frame, the
 * reply.
 */
#include "bench.h"
#include "drehgeber/devices.h"
#include "hf_rig.h"

#define CHARACTER_NS ((dg_ns)1145834) /* 11 bits at 9600 Bd */

static struct dg_hf device;
static struct dg_world world;
static struct ram_nvm nvm;
static dg_ns now;
static uint8_t asked;
static uint64_t answered;

struct request {
    uint8_t bytes[DG_HF_FRAME_MAX];
    size_t n;
};

/* An error is answered with 50h instead of the command's code. */
static void reply(void *ctx, const uint8_t *bytes, size_t n)
{
    (void)ctx;
    answered += n > 1 && bytes[1] == asked;
}

static dg_angle angle(void *ctx, dg_ns at)
{
    (void)ctx;
    return (dg_angle)at;
}

static void exchange(const void *what)
{
    const struct request *request = what;
    dg_ns deadline = DG_NEVER;

    asked = request->bytes[1];
    for (size_t i = 0; i < request->n; i++) {
        now += CHARACTER_NS;
        deadline = dg_hf_rx(&device, now, request->bytes[i], DG_HF_RX_OK);
    }
    while (deadline != DG_NEVER) {
        now = deadline;
        deadline = dg_hf_step(&device, now);
    }
}

/* Without address and check sum, which are added. */
static struct request request_of(const char *hexadecimal)
{
    struct request request = {.bytes = {DG_HF_ADDRESS_DEFAULT}};

    request.n = 1 + hf_rig_hex(hexadecimal, &request.bytes[1], sizeof request.bytes - 2u);
    request.bytes[request.n] = hf_rig_xor(request.bytes, request.n);
    request.n++;
    return request;
}

static struct request read_position, set_position, analog, counter, read_data, save_data,
    field_status, memory, status, label, serial;

/* clang-format off */
static const struct {
    struct request *request;
    const char *hexadecimal;
} requests[] = {
    {&read_position, "42"},
    {&set_position,  "43 00 00 12 34 55"},
    {&analog,        "44 48"},
    {&counter,       "46"},
    {&read_data,     "4A 00 00 20 55"},
    {&save_data,     "4B 00 00 04 55 01 02 03 04"},
    {&field_status,  "4C 00"},
    {&memory,        "4E"},
    {&status,        "50"},
    {&label,         "52"},
    {&serial,        "56"},
};

static const struct bench benches[] = {
    {"hiperface.42h", exchange, &read_position, 1, 1},
    {"hiperface.43h", exchange, &set_position, 1, 1},
    {"hiperface.44h", exchange, &analog, 1, 1},
    {"hiperface.46h", exchange, &counter, 1, 1},
    {"hiperface.4Ah-32", exchange, &read_data, 1, 1},
    {"hiperface.4Bh-4", exchange, &save_data, 1, 1},
    {"hiperface.4Ch", exchange, &field_status, 1, 1},
    {"hiperface.4Eh", exchange, &memory, 1, 1},
    {"hiperface.50h", exchange, &status, 1, 1},
    {"hiperface.52h", exchange, &label, 1, 1},
    {"hiperface.56h", exchange, &serial, 1, 1},
};
/* clang-format on */

/* A medium that is durable at once: copying all of it in each sync is what ram_nvm does, not what
   an encoder does. */
static struct dg_nvm durable_nvm(void)
{
    static struct dg_nvm_ops ops;
    struct dg_nvm port = ram_nvm_port(&nvm);

    ops = *port.ops;
    ops.sync = NULL;
    port.ops = &ops;
    return port;
}

static bool start_encoder(void)
{
    static const struct dg_hf_ops ops = {.tx = reply};
    const struct dg_hf_model *model = dg_hf_model_of(dg_device_find("s3684-rs485"));
    const struct dg_hf_setup setup = {
        .model = model, .world = &world, .nvm = durable_nvm(), .ops = &ops};
    const struct request field = request_of("4D 00 CF 55");

    dg_world_init(&world);
    world.angle = angle;
    ram_nvm_init(&nvm, dg_store_size(&dg_hf_layout));
    if (dg_hf_format(model, setup.nvm) != DG_OK || dg_hf_init(&device, &setup) != DG_OK ||
        dg_hf_power_on(&device, 0) != DG_OK) {
        return false;
    }
    now = DG_S(1);
    (void)dg_hf_step(&device, now);
    for (size_t i = 0; i < DG_COUNT(requests); i++) {
        *requests[i].request = request_of(requests[i].hexadecimal);
    }
    exchange(&field);
    return answered == 1;
}

static uint64_t answers(void)
{
    return answered;
}

int main(int argc, char **argv)
{
    static const struct bench_bytes bytes[] = {{"ram.dg_hf", sizeof(struct dg_hf)}};
    static const struct bench_set set = {.benches = benches,
                                         .count = DG_COUNT(benches),
                                         .bytes = bytes,
                                         .bytes_count = 1,
                                         .start = start_encoder,
                                         .answers = answers};

    return bench_main(argc, argv, &set);
}
