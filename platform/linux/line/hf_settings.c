/* SPDX-License-Identifier: MIT */
#include "stacks.h"
#include "trace_format.h"

/* Sine and cosine in a trace: time between samples; 0: none. */
static const dg_ns sincos_usual = DG_MS(1);

/* clang-format off */
static const struct dg_key keys[] = {
    {"sincos_us", "us", 0, DG_KEY_NS, 0, 1000, 0, 1000000, NULL, "time between samples of sine and cosine in a VCD trace; 0: no samples"},
};
/* clang-format on */

static int check_steps(const struct dg_hf_model *model, struct lx_error *error)
{
    const uint64_t steps = (uint64_t)model->periods_per_turn * model->steps_per_period;
    const uint64_t counts = steps * model->turns;
    struct lx_words right = {""};
    if (steps > DG_HF_STEPS_PER_TURN_MAX) {
        lx_words_add(&right, "expected at most %lu", (unsigned long)DG_HF_STEPS_PER_TURN_MAX);
        return lx_refuse(error, right.text, "periods x steps is %llu", (unsigned long long)steps);
    }
    /* 42h answers with 32 bits of position. */
    return counts <= (uint64_t)1 << 32
               ? 0
               : lx_refuse(error, "expected at most 4294967296", "turns x periods x steps is %llu",
                           (unsigned long long)counts);
}

static int check(const void *settings, struct lx_error *error)
{
    const struct dg_hf_model *model = &((const struct dg_hf_settings *)settings)->model;
    struct lx_words right = {""};
    if (model->implemented_blocks != 0 && model->implemented_blocks < model->memory_blocks) {
        lx_words_add(&right, "expected %u..128, or 0: as memory", model->memory_blocks);
        return lx_refuse(error, right.text, "implemented is %u", model->implemented_blocks);
    }
    return check_steps(model, error);
}

const struct lx_stack lx_hf_stack = {
    .core = &dg_hf_stack,
    .handle = &dg_hf_wire,
    .trace = &(const struct lx_trace_kind){"RS485", {&lx_trace_uart}, true},
    .wire = "pty",
    .baud = 38400,
    .spoiled = "the encoder answers 05h",
    .own = {keys, DG_COUNT(keys)},
    .usual = &sincos_usual,
    .check = check,
};
