/* SPDX-License-Identifier: MIT */
/*
 * Random walks through the command space of a K3, next to a model of its own: written from the
 * manual's chapter 9 as one chain of decisions, without tables, store or overlays.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "ib_rig.h"

#define STEPS 4096u
#define TURNS 4096u
#define DELAY 3

struct model {
    uint32_t s, u, cw, preset, flag, offset, shift, iw, mode;
    uint32_t on[9][8], off[9][8], have_on[9], have_off[9], mask[9];
    uint32_t last, held, item, count;
    uint32_t program;
    bool standing;
    /* I22: not released yet; 0 of steps and revolutions: not sent */
    uint32_t new_s, new_u, new_preset, new_shift;
    bool has_preset, has_shift, said_preset, said_shift;
};

static struct ib_rig rig;
static struct model model;
static uint32_t noise;
static unsigned pairs_taken;
static unsigned pairs_refused;

static uint32_t next(void)
{
    noise = noise * 1664525u + 1013904223u;
    return noise >> 8;
}

static uint64_t range(void)
{
    return (uint64_t)model.s * TURNS / model.u;
}

static uint64_t without_offset(void)
{
    const uint64_t all = (uint64_t)STEPS * TURNS;
    const uint64_t turned = ((uint64_t)rig.angle >> 20) % all; /* 2^32 / 4096 */
    const uint64_t raw = model.cw ? turned : (all - turned) % all;

    return raw * model.s / ((uint64_t)model.u * STEPS) % range() + model.shift;
}

static uint32_t position(void)
{
    return (uint32_t)((without_offset() + model.offset) % range());
}

static void take_preset(void)
{
    model.offset =
        (uint32_t)((model.preset % range() + range() - without_offset() % range()) % range());
}

static uint32_t cam_word(void)
{
    const uint32_t p = position();
    const uint32_t n = model.mode - 2;
    uint32_t word = (p >> model.iw) % 0x20000 * 0x100;

    for (uint32_t i = 0; i < 8; i++) {
        const uint32_t on = model.on[n][i];
        const uint32_t off = model.off[n][i];
        const bool all = model.have_on[n] >> i & model.have_off[n] >> i & model.mask[n] >> i & 1;
        /* Steps since the edge on against the length of the cam. */
        const uint32_t all_steps = 0x2000000;
        const bool within = (p - on) % all_steps < (off - on) % all_steps;
        const bool wrapped = on > off ? p >= on || p < off : within;
        word += all && wrapped ? 1u << i : 0;
    }
    return word;
}

static uint32_t item_value(void)
{
    static const uint32_t fixed[16] = {[0] = 1234567, [7] = 0x110, [10] = 2, [12] = 370};
    const uint32_t changing[16] = {
        [1] = model.s,     [2] = model.u,    [3] = model.cw ? 3 : 4, [4] = model.preset,
        [5] = model.shift, [6] = model.flag, [9] = model.mode};
    const uint32_t i = model.item & 0xFFFF;

    if (i <= 0xFF && i % 16 == 13) {
        return 0xA0000000 + (i == 0xCD ? 0x37 : 0);
    }
    if (i > 12 || i == 11) {
        return 0xA4000000 + (model.item & 0x1FFFFFF);
    }
    return 0xA0000000 + fixed[i] + changing[i];
}

static bool held_error(void)
{
    return model.held >= 0x80000000 && model.held < 0xA0000000;
}

static void forget_sent(void)
{
    model.new_s = model.new_u = model.new_preset = model.new_shift = 0;
    model.has_preset = model.has_shift = model.said_preset = model.said_shift = false;
}

/* 08 and 0A: with steps or revolutions before them, only noted. */
static uint32_t preset_or_shift(uint32_t word)
{
    const uint32_t v = word & 0x1FFFFFF;
    const bool preset = word >> 25 == 4;

    if (model.new_s == 0 && model.new_u == 0) {
        if (v >= range()) {
            return 0x82000000;
        }
        *(preset ? &model.preset : &model.shift) = v;
        model.flag = preset ? 1 : model.flag;
    } else {
        *(preset ? &model.new_preset : &model.new_shift) = v;
        *(preset ? &model.has_preset : &model.has_shift) = true;
    }
    *(preset ? &model.said_preset : &model.said_shift) = true;
    return word + 0xC0000000;
}

/* What IN holds after a release, 0: the position. */
static uint32_t release(void)
{
    const struct model old = model;

    forget_sent();
    if (old.new_s == 0 && old.new_u == 0) {
        return 0;
    }
    model.s = old.new_s != 0 ? old.new_s : old.s;
    model.u = old.new_u != 0 ? old.new_u : old.u;
    model.preset = old.has_preset ? old.new_preset : old.preset;
    model.shift = old.has_shift ? old.new_shift : old.shift;
    model.flag = old.has_preset ? 1 : old.flag;
    if (model.s <= model.u * STEPS && !(old.said_preset && model.preset >= range()) &&
        !(old.said_shift && model.shift >= range())) {
        pairs_taken++;
        return 0;
    }
    pairs_refused++;
    model.s = old.s;
    model.u = old.u;
    model.preset = old.preset;
    model.shift = old.shift;
    model.flag = old.flag;
    return 0x82000000;
}

/* What a profile parameter answers. */
static uint32_t profile(uint32_t word)
{
    const uint32_t v = word & 0x1FFFFFF;
    const uint32_t ok = word + 0xC0000000;

    switch (word >> 25) {
    case 1:
        return v > 0 ? (model.new_s = v, ok) : 0x82000000;
    case 2:
        return v > 0 && v <= TURNS ? (model.new_u = v, ok) : 0x82000000;
    case 3:
        return v == 3 || v == 4 ? (model.cw = v == 3, ok) : 0x82000000;
    case 4:
    case 5:
        return preset_or_shift(word);
    case 7:
        if (v == 0) {
            forget_sent();
            model.s = STEPS;
            model.u = model.cw = 1;
            model.preset = model.flag = model.offset = model.shift = 0;
            return ok;
        }
        return 0x82000000;
    default:
        return 0x84000000;
    }
}

/* In every mode, of the program selected last. */
static uint32_t cam_look(uint32_t word)
{
    const uint32_t n = model.program;
    const uint32_t v = word & 0xFF;

    if (word >= 0x20100000 && word <= 0x201000FF) {
        return v <= 25 ? (model.iw = v, word + 0xC0000000) : 0x82000000;
    }
    if (word == 0x20200000) {
        return 0xA0000000 + model.mask[n];
    }
    if (word >= 0x20200010 && word <= 0x20200017) {
        return 0xA0000000 + model.on[n][word & 7];
    }
    if (word >= 0x20200020 && word <= 0x20200027) {
        return 0xA0000000 + model.off[n][word & 7];
    }
    return word == 0x20200030 || word == 0x20200040 ? 0xA0000000 + model.iw : 0x84000000;
}

static uint32_t cam_command(uint32_t word)
{
    const uint32_t n = model.mode - 2;
    const uint32_t cam = word >> 25 & 15;
    const uint32_t v = word & 0x1FFFFFF;

    if (word >> 29 == 2 || word >> 29 == 3) {
        if (cam > 7) {
            return 0x84000000;
        }
        if (v >= range()) {
            return 0x98000004;
        }
        (word >> 29 == 2 ? model.on : model.off)[n][cam] = v;
        (word >> 29 == 2 ? model.have_on : model.have_off)[n] |= 1u << cam;
        return word | 0xC0000000;
    }
    if (word >= 0x20400000 && word <= 0x204000FF) {
        model.mask[n] = word & 0xFF;
        return word + 0xC0000000;
    }
    return cam_look(word);
}

static uint32_t answer_to(uint32_t word)
{
    if (word < 0x20000000) {
        return profile(word);
    }
    if (word >= 0x20800000 && word <= 0x20800008) {
        model.mode = word == 0x20800000 ? 1 : 2 + (word & 15);
        model.program = word == 0x20800000 ? model.program : word & 15;
        return word + 0xC0000000;
    }
    if (model.mode > 2) {
        return cam_command(word);
    }
    if (word == 0x20400000 || word == 0x20400001) {
        model.mode = 1 + (word & 1);
        return word + 0xC0000000;
    }
    return cam_look(word);
}

static void handle(uint32_t word)
{
    if (word >> 25 != 0 || (word >> 16 & 1) == 0) {
        model.item = 0;
    }
    if (word >> 25 == 0) {
        return;
    }
    if (word >> 16 == 0x2021) {
        model.item = word;
        model.held = held_error() ? 0 : model.held;
    } else if (word == 0x80000000) {
        model.held = release();
    } else if (model.mode <= 2 && (word == 0x40000000 || word == 0x60000000)) {
        if (word == 0x60000000 || model.flag) {
            take_preset();
            model.flag = word == 0x60000000 ? model.flag : 0;
            model.held = held_error() ? 0 : model.held;
        }
        model.standing = word == 0x60000000;
    } else {
        model.held = answer_to(word);
    }
}

static bool acts_in_the_next_cycle(uint32_t word)
{
    return word >> 25 == 0 || word == 0x80000000 ||
           (model.mode <= 2 && (word == 0x40000000 || word == 0x60000000));
}

/* One cycle; what IN has to be. */
static uint32_t expected(uint32_t out)
{
    static uint32_t waiting;

    if (model.count > 0 && --model.count == 0) {
        handle(waiting);
    }
    if (model.standing && model.last == 0x60000000) {
        take_preset();
    } else {
        model.standing = false;
    }
    const uint32_t operation = model.mode > 2 ? cam_word() : (model.mode == 2 ? 0 : position());
    if (out != model.last) {
        const bool stale = out == 0x80000000 && model.last >= 0x80000000;
        waiting = stale ? 0 : out;
        model.count = acts_in_the_next_cycle(waiting) ? 1 : DELAY;
        model.last = out;
    }
    if (model.item != 0) {
        return item_value();
    }
    return model.held != 0 ? model.held : operation;
}

/* Mostly words that mean something, at times with a bit turned. */
static uint32_t random_word(void)
{
    static const uint32_t patterns[][2] = {
        {0x00000000, 0x00000000}, {0x00000000, 0x01FFFFFF}, {0x80000000, 0x00000000},
        {0x80000000, 0x00000000}, {0x40000000, 0x00000000}, {0x60000000, 0x00000000},
        {0x02000000, 0x00001FFF}, {0x02000000, 0x01FFFFFF}, {0x02000000, 0x0000FFFF},
        {0x04000000, 0x0000001F}, {0x04000000, 0x00000FFF}, {0x06000000, 0x00000007},
        {0x08000000, 0x00FFFFFF}, {0x08000000, 0x000000FF}, {0x0A000000, 0x00FFFFFF},
        {0x0E000000, 0x00000000}, {0x20400000, 0x000001FF}, {0x20400000, 0x00000001},
        {0x20800000, 0x0000000F}, {0x20800000, 0x00000003}, {0x20210000, 0x0000000F},
        {0x20210000, 0x000000FF}, {0x20210000, 0x0000FFFF}, {0x20100000, 0x0000001F},
        {0x20200000, 0x0000003F}, {0x20200040, 0x00000000}, {0x40000000, 0x1EFFFFFF},
        {0x60000000, 0x1EFFFFFF}, {0x40000000, 0x0E000FFF}, {0x60000000, 0x0E000FFF},
        {0x00000000, 0xFFFFFFFF},
    };
    const uint32_t *const pattern = patterns[next() % (DG_COUNT(patterns))];
    const uint32_t bits = next() << 16 ^ next();
    const uint32_t word = pattern[0] | (bits & pattern[1]);

    return next() % 16 == 0 ? word ^ 1u << next() % 32 : word;
}

static void walk(uint32_t seed)
{
    assert_int_equal(ib_rig_init(&rig, dg_ib_model_of(dg_device_find("ocd-ib-k3"))), DG_OK);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
    memset(&model, 0, sizeof model);
    model.s = STEPS;
    model.u = model.cw = model.mode = model.program = 1;
    noise = seed;
    for (int i = 0; i < 400; i++) {
        const uint32_t word = random_word();
        const uint32_t cycles = next() % 4 == 0 ? 1 + next() % 3 : 4 + next() % 2;
        for (uint32_t k = 0; k < cycles; k++) {
            ib_rig_turn_to(&rig, (int64_t)(next() % (STEPS * TURNS)));
            const uint32_t in = ib_rig_cycle(&rig, word);
            const uint32_t wanted = expected(word);
            if (in != wanted) {
                fail_msg("seed %u, word %d: OUT %08X, IN %08X, not %08X", (unsigned)seed, i,
                         (unsigned)word, (unsigned)in, (unsigned)wanted);
            }
        }
    }
}

static void walks(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 400; seed++) {
        walk(seed);
    }
    /* The walks came along there. */
    assert_true(pairs_taken > 1000 && pairs_refused > 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(walks)};
    return cmocka_run_group_tests_name("random walks", tests, NULL, NULL);
}
