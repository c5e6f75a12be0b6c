/* SPDX-License-Identifier: MIT */
#include "biss_settings.h"

#include <stddef.h>

#include "biss_clocked.h"
#include "trace_format.h"

/* Threads of a host are slower than the encoder's own timeout is short. */
#define TIMEOUT_MIN_US (DG_BISS_TIMEOUT_NS / DG_US(1))
#define TIMEOUT_MAX_US (DG_BISS_TIMEOUT_MAX_NS / DG_US(1))

/* clang-format off */
static const struct dg_key timeout =
    {"timeout_us", "us", offsetof(struct dg_biss_model, timeout), DG_KEY_NS, 0, 1000, TIMEOUT_MIN_US, TIMEOUT_MAX_US, NULL, "gpio: silence on MA that ends a frame; 20000 unless set"};
/* clang-format on */

static void defaults(void *settings, const struct dg_device *device)
{
    *(struct dg_biss_model *)settings = *dg_biss_model_of(device);
}

static int check(const void *settings, struct lx_error *error)
{
    const struct dg_biss_model *model = settings;
    struct lx_words right = {""};
    if (model->busy + model->busy_jitter <= DG_BISS_BUSY_S_MAX_NS) {
        return 0;
    }
    lx_words_add(&right, "together at most %u is right", (unsigned)(DG_BISS_BUSY_S_MAX_NS / 1000u));
    return lx_refuse(error, right.text, "busy_us %g and busy_jitter_us %g",
                     (double)model->busy / 1000.0, (double)model->busy_jitter / 1000.0);
}

static const char title[] = "BiSS";
static const struct lx_trace_format *const formats[] = {&lx_trace_biss, NULL};
static const struct lx_trace_kind trace = {title, formats, false};

const struct lx_stack lx_biss_stack = {
    .core = &dg_biss_stack,
    .title = title,
    .trace = &trace,
    .clocked = &lx_clocked_biss,
    .wire = "sim",
    .spoiled = "the encoder answers P = 1",
    .keys = &dg_biss_keys,
    .instead = &timeout,
    .settings_size = sizeof(struct dg_biss_model),
    .defaults = defaults,
    .check = check,
};

int lx_biss_own_timeout(const struct dg_plan *plan, const struct dg_plan_encoder *encoder,
                        const struct dg_biss_model *model, struct lx_error *error)
{
    if (model->timeout == 0) {
        return 0;
    }
    (void)lx_refuse(error, "only with gpio", "the simulated wire has the encoder's own timeout");
    (void)lx_about(error, LX_ABOUT_SETTING, "timeout_us", NULL);
    return lx_plan_stands(plan, dg_plan_setting_line(encoder, "timeout_us"), error);
}
