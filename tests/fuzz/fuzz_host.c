/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: a handle in the hands of a host that does anything. The input is a model and a
 * stream of calls with any arguments, events of any kind, states that are saved, damaged and
 * restored. Whatever it was, a result is one that host.h names, time never stands, and a state that
 * was taken is given back the same.
 */
#include <stdalign.h>
#include <string.h>

#include "drehgeber/devices.h"
#include "drehgeber/host.h"
#include "drehgeber/ssi.h"
#include "fuzz_input.h"

#define MEMORY_MAX 32768u
/* Longer steps only cost time: a heartbeat may be due every millisecond. */
#define STEP_MAX UINT64_C(100000000)

static alignas(DG_HOST_ALIGN) uint8_t here[MEMORY_MAX];
static alignas(DG_HOST_ALIGN) uint8_t there[MEMORY_MAX];
static uint8_t state[MEMORY_MAX];
static uint8_t again[MEMORY_MAX];
static struct dg_host *host;
static uint64_t now;
static size_t model_index;

/* All by their names, and behind the list one as who links a single protocol makes it. */
static struct dg_host *make(uint8_t *memory, size_t model)
{
    return model < dg_device_count ? dg_host_make(memory, MEMORY_MAX, dg_devices[model]->name)
                                   : dg_host_init(memory, MEMORY_MAX, &dg_ssi_28, &dg_ssi_wire);
}

static void check(int result)
{
    fuzz_must(result >= DG_HOST_ERR_SILENT);
    fuzz_must(strcmp(dg_host_result_text(result < 0 ? result : 0), "unknown result") != 0);
}

static uint64_t take64(struct fuzz_input *input)
{
    const uint64_t high = fuzz_take32(input);

    return high << 32 | fuzz_take32(input);
}

static void op_time(struct fuzz_input *input)
{
    const uint64_t span = (uint64_t)fuzz_take(input) << (fuzz_take(input) & 31u);

    now += span < STEP_MAX ? span : STEP_MAX;
    const uint64_t next = dg_host_step(host, now);
    fuzz_must(next == dg_host_next(host));
    fuzz_must(dg_host_step_ps(host, now * 1000u) >= next);
}

static void op_send(struct fuzz_input *input)
{
    struct dg_host_event event = {.kind = fuzz_take(input) % 7u, .length = fuzz_take(input) % 20u};

    event.at = now + fuzz_take(input) * UINT64_C(10000);
    event.id = fuzz_take(input) | (uint32_t)fuzz_take(input) << 8;
    event.flags = fuzz_take(input);
    for (size_t i = 0; i < event.length && i < sizeof event.data; i++) {
        event.data[i] = fuzz_take(input);
    }
    check(dg_host_send(host, &event));
}

static void op_receive(struct fuzz_input *input)
{
    struct dg_host_event event;
    int result = 1;

    for (unsigned n = fuzz_take(input); n > 0 && result == 1; n--) {
        result = dg_host_receive(host, &event);
        fuzz_must(result == 1 || result == 0 || result == DG_HOST_ERR_LOST);
        fuzz_must(result != 1 || event.length <= sizeof event.data);
    }
}

static void op_set(struct fuzz_input *input)
{
    struct dg_host_key key;
    char value[24];
    char told[64];

    if (dg_host_key(host, fuzz_take(input) % 40u, &key) != DG_HOST_OK) {
        return;
    }
    for (size_t i = 0; i < sizeof value; i++) {
        value[i] = (char)fuzz_take(input);
    }
    value[sizeof value - 1u] = '\0';
    const int result = dg_host_set(host, key.name, value);
    check(result);
    fuzz_must(dg_host_get(host, key.name, told, sizeof told) >= 0);
    fuzz_must(result != DG_HOST_OK || dg_host_set(host, key.name, told) == DG_HOST_OK);
}

static void op_power(struct fuzz_input *input)
{
    check(dg_host_power(host, now, (fuzz_take(input) & 3u) != 0));
}

static void op_shaft(struct fuzz_input *input)
{
    const int64_t angle = (int64_t)take64(input);

    dg_host_shaft(host, now, angle, (int64_t)take64(input));
    (void)dg_host_angle(host, take64(input));
}

static void op_world(struct fuzz_input *input)
{
    static const char *const names[] = {
        "temperature",   "led_current_ua",    "sin_amplitude_permille",
        "singleturn_ok", "multiturn_sync_ok", "eeprom_acknowledges"};
    const char *name = names[fuzz_take(input) % (DG_COUNT(names))];

    check(dg_host_world_set(host, now, name, (int32_t)fuzz_take32(input)));
}

static void op_clock(struct fuzz_input *input)
{
    for (unsigned n = fuzz_take(input); n > 0; n--) {
        const uint8_t how = fuzz_take(input);
        now += (uint64_t)(how >> 1) << 5;
        check(dg_host_clock(host, now, (how & 1u) != 0));
    }
}

static void op_frame(struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);
    struct dg_host_frame frame = {.end = now};
    uint8_t bytes[64] = {fuzz_take(input), fuzz_take(input)};
    const uint8_t address = fuzz_take(input);

    check(dg_host_frame(host, now, &frame));
    now = frame.end > now ? frame.end : now;
    if (how < 64) {
        check(dg_host_registers_read(host, &now, address, bytes, how));
    } else if (how < 128) {
        check(dg_host_registers_write(host, &now, address, bytes, how - 64u));
    }
}

static void op_look(struct fuzz_input *input)
{
    struct dg_host_uart uart;
    uint64_t counts;
    int32_t uv[4];

    check(dg_host_position(host, take64(input), &counts));
    check(dg_host_sincos(host, take64(input), uv));
    check(dg_host_uart(host, &uart));
    check(dg_host_bit_rate(host));
    check(dg_host_bus_state(host));
}

static void op_memory(struct fuzz_input *input)
{
    const size_t n = dg_host_memory_size(host);

    fuzz_must(n <= sizeof state && dg_host_memory_copy(host, state, n) == DG_HOST_OK);
    if (n > 0) {
        state[fuzz_take32(input) % n] ^= fuzz_take(input);
    }
    check(dg_host_memory_load(host, state, n));
}

/* The state goes on at the other place; one byte of it wrong, nothing happens there. */
static void op_state(struct fuzz_input *input)
{
    uint8_t *other = (uint8_t *)host == here ? there : here;
    struct dg_host *next = make(other, model_index);
    const size_t n = dg_host_state_size(host);
    const size_t at = fuzz_take32(input) % n;
    const uint8_t flip = fuzz_take(input);

    fuzz_must(n <= sizeof state && dg_host_save(host, state, n) == DG_HOST_OK);
    state[at] ^= flip;
    fuzz_must((dg_host_restore(next, state, n) == DG_HOST_OK) == (flip == 0));
    fuzz_must(flip == 0 || !dg_host_powered(next));
    state[at] ^= flip;
    fuzz_must(dg_host_restore(next, state, n) == DG_HOST_OK);
    fuzz_must(dg_host_save(next, again, n) == DG_HOST_OK);
    fuzz_must(memcmp(state, again, n) == 0);
    host = next;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct fuzz_input *) = {
        op_time,  op_send,  op_receive, op_set,  op_power,  op_shaft,
        op_world, op_clock, op_frame,   op_look, op_memory, op_state};
    struct fuzz_input input = {.at = bytes, .end = bytes + n};

    now = 0;
    model_index = fuzz_take(&input) % (dg_device_count + 1u);
    host = make(here, model_index);
    fuzz_must(host != NULL);
    while (input.at < input.end) {
        operations[fuzz_take(&input) % (DG_COUNT(operations))](&input);
    }
    return 0;
}
