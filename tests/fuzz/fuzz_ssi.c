/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: an encoder with SSI on a hostile line. The input is a model and a stream of
 * operations: edges at any time, words, whole words, a bent world, power; and any bits for the
 * decoder. After each one: the state is one there is, data never moved on a falling edge, and
 * behind a pause words are whole.
 */
#include "fuzz_input.h"
#include "ssi_rig.h"

static struct ssi_rig rig;

static void check(const struct dg_ssi *device)
{
    const bool powered = device->state == DG_SSI_IDLE || device->state == DG_SSI_SHIFT;

    fuzz_must(!rig.strayed);
    fuzz_must(device->state <= DG_SSI_SHIFT);
    fuzz_must(device->left <= dg_ssi_word_bits(&rig.model));
    fuzz_must(device->word >> dg_ssi_word_bits(&rig.model) == 0);
    fuzz_must(powered || !device->data);
    fuzz_must(device->state != DG_SSI_IDLE || device->data);
    fuzz_must((device->deadline == DG_NEVER) ==
              (device->state == DG_SSI_IDLE || device->state == DG_SSI_OFF));
    fuzz_must(device->deadline == DG_NEVER ||
              device->deadline <= rig.now + rig.model.monoflop + rig.model.init);
}

static void pass(uint64_t ns)
{
    rig.now += ns;
}

static void op_edges(struct fuzz_input *input)
{
    for (unsigned n = fuzz_take(input); n > 0; n--) {
        const uint8_t how = fuzz_take(input);
        pass((uint64_t)(how & 0x1Fu) << (how >> 5 << 1));
        (void)ssi_rig_edge(&rig, (how & 1u) != 0);
        fuzz_must(dg_ssi_step(&rig.device, rig.now) > rig.now);
    }
}

/* Behind silence with the clock high any number of words is right. */
static void op_words(struct fuzz_input *input)
{
    const unsigned bits = ssi_rig_bits(&rig.model);
    uint64_t first = 0;

    (void)ssi_rig_edge(&rig, true);
    rig.low_ns = 1u + fuzz_take(input);
    rig.high_ns = 1u + fuzz_take(input);
    (void)ssi_rig_wait(&rig, rig.model.init + rig.model.monoflop);
    if (!dg_ssi_data(&rig.device)) {
        fuzz_must(rig.device.state == DG_SSI_OFF);
        return;
    }
    const unsigned words = 1u + fuzz_take(input) % 4u;
    for (unsigned n = 0; n < words; n++) {
        const uint64_t word = ssi_rig_take(&rig, bits + 1u);
        const uint64_t want = ssi_rig_word(&rig.model, (uint32_t)rig.device.position,
                                           dg_ssi_errors(&rig.device) != 0);
        first = n == 0 ? word : first;
        fuzz_must(first == want << 1);
        fuzz_must(word == (n > 0 && rig.model.once ? 0 : first));
    }
}

static void op_frame(struct fuzz_input *input)
{
    struct dg_ssi_frame frame;
    uint64_t bits = 0;

    (void)ssi_rig_edge(&rig, (fuzz_take(input) & 1u) != 0);
    (void)ssi_rig_wait(&rig, rig.model.monoflop);
    const uint8_t n = dg_ssi_frame(&rig.device, rig.now, &bits);
    fuzz_must((n == 0) == !dg_ssi_data(&rig.device));
    if (n != 0) {
        fuzz_must(n == ssi_rig_bits(&rig.model) && bits >> n == 0);
        fuzz_must(dg_ssi_frame_decode(&rig.model, bits, &frame) == DG_OK);
        fuzz_must(frame.position == dg_ssi_position(&rig.device, rig.now));
    }
}

/* Any bits: whatever comes out would have been sent so, unless the parity says otherwise. */
static void op_decode(struct fuzz_input *input)
{
    const uint64_t bits = (uint64_t)fuzz_take32(input) << 32 | fuzz_take32(input);
    const uint64_t mask = ((uint64_t)1 << ssi_rig_bits(&rig.model)) - 1u;
    struct dg_ssi_frame frame;

    const int result = dg_ssi_frame_decode(&rig.model, bits, &frame);
    const uint64_t again = ssi_rig_word(&rig.model, (uint32_t)frame.position, frame.error);
    const uint64_t parity = rig.model.parity == DG_SSI_PARITY_NONE ? 0 : 1;
    fuzz_must(result == DG_OK || result == DG_ERR_DAMAGED);
    fuzz_must(((bits & mask) ^ again) == (result == DG_OK ? 0 : parity));
    fuzz_must(frame.singleturn >> rig.model.singleturn_bits == 0);
    fuzz_must(frame.multiturn >> rig.model.multiturn_bits == 0);
}

static void op_time(struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    pass((uint64_t)fuzz_take(input) << (how & 31u));
    if ((how & 64u) != 0) {
        fuzz_must(dg_ssi_step(&rig.device, rig.now) > rig.now);
    }
}

static void op_world(struct fuzz_input *input)
{
    struct dg_world *world = &rig.world;
    const uint8_t bits = fuzz_take(input);

    rig.angle = (dg_angle)((uint64_t)fuzz_take32(input) << 32 | fuzz_take32(input));
    rig.angle_per_us = (int32_t)fuzz_take32(input);
    world->temperature_mdegc = (int32_t)fuzz_take32(input);
    world->led_current_ua = fuzz_take32(input);
    world->supply_mv = fuzz_take32(input);
    world->sin_offset_permille = (int16_t)(fuzz_take32(input) % 2001u - 1000u);
    world->singleturn_ok = (bits & 1u) != 0;
    world->multiturn_sync_ok = (bits & 2u) != 0;
    world->watchdog_fired = (bits & 4u) != 0;
}

static void op_power(struct fuzz_input *input)
{
    if ((fuzz_take(input) & 3u) == 0) {
        dg_ssi_power_off(&rig.device);
    } else {
        dg_ssi_power_on(&rig.device, rig.now);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct fuzz_input *) = {
        op_edges, op_words, op_frame, op_decode, op_time, op_world, op_power};
    struct fuzz_input input = {.at = bytes, .end = bytes + n};
    struct dg_ssi_model model = {.init = DG_US(fuzz_take(&input))};

    model.multiturn_bits = fuzz_take(&input) % 27u;
    model.singleturn_bits = fuzz_take(&input) % 34u;
    model.code = fuzz_take(&input) % 3u;
    model.error_bit = fuzz_take(&input) % 4u;
    model.parity = fuzz_take(&input) % 4u;
    model.once = (fuzz_take(&input) & 1u) != 0;
    model.monoflop = DG_US(9u + fuzz_take(&input));
    const unsigned width = (unsigned)model.multiturn_bits + model.singleturn_bits;
    const bool good = width >= 10 && width <= 32 && model.singleturn_bits >= 8 &&
                      model.singleturn_bits <= 31 && model.code <= 1 && model.error_bit <= 2 &&
                      model.parity <= 2 && model.monoflop >= DG_US(10);
    fuzz_must((ssi_rig_init(&rig, &model) == DG_OK) == good);
    while (good && input.at < input.end) {
        operations[fuzz_take(&input) % (DG_COUNT(operations))](&input);
        check(&rig.device);
    }
    return 0;
}
