/* SPDX-License-Identifier: MIT */
#include "ssi_settings.h"

#include <stddef.h>

#include "ssi_clocked.h"
#include "trace.h"

/* clang-format off */
static const struct dg_key monoflop =
    {"monoflop_us", "us", offsetof(struct dg_ssi_model, monoflop), DG_KEY_NS, 0, 1000, DG_SSI_MONOFLOP_MIN_NS / DG_US(1), DG_SSI_MONOFLOP_MAX_NS / DG_US(1), NULL, "silence on the clock that ends a word; gpio: 20000 unless set"};
/* clang-format on */

static void defaults(void *settings, const struct dg_device *device)
{
    *(struct dg_ssi_model *)settings = *dg_ssi_model_of(device);
}

static int check(const void *settings, struct lx_error *error)
{
    const struct dg_ssi_model *model = settings;
    const unsigned bits = (unsigned)model->multiturn_bits + model->singleturn_bits;
    struct lx_words right = {""};
    if (bits >= DG_SSI_BITS_MIN && bits <= DG_SSI_BITS_MAX) {
        return 0;
    }
    lx_words_add(&right, "together %u to %u bits are right", DG_SSI_BITS_MIN, DG_SSI_BITS_MAX);
    return lx_refuse(error, right.text, "mt %u and st %u", model->multiturn_bits,
                     model->singleturn_bits);
}

static const char title[] = "SSI";
static const struct lx_trace_format *const formats[] = {&lx_trace_ssi, NULL};
static const struct lx_trace_kind trace = {title, formats, false};

const struct lx_stack lx_ssi_stack = {
    .core = &dg_ssi_stack,
    .title = title,
    .trace = &trace,
    .clocked = &lx_clocked_ssi,
    .wire = "sim",
    .keys = &dg_ssi_keys,
    .instead = &monoflop,
    .settings_size = sizeof(struct dg_ssi_model),
    .defaults = defaults,
    .check = check,
};
