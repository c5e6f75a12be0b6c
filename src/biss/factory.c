/* SPDX-License-Identifier: MIT */
/*
 * The EEPROM of the device, and its start: everything in force is read at power-on.
 */
#include <string.h>

#include "biss_private.h"

static void default_config(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memset(out, 0, BISS_CONFIG_SIZE);
    out[BISS_EMASK] = DG_BISS_EMASK_DEFAULT;
    out[BISS_WMASK] = DG_BISS_WMASK_DEFAULT;
}

#define USER(name)                                                                                 \
    {                                                                                              \
        name, DG_BISS_BANK_SIZE, DG_STORE_CHECKED, DG_BISS_CONFIGURATION, NULL                     \
    }

/* clang-format off */
/* name, size, check, error bit its damage raises (5.2.3), delivery state */
static const struct dg_store_region regions[] = {
    {"config", BISS_CONFIG_SIZE, DG_STORE_CHECKED, DG_BISS_CONFIGURATION, default_config},
    USER("user7"),  USER("user8"),  USER("user9"),  USER("user10"), USER("user11"),
    USER("user12"), USER("user13"), USER("user14"), USER("user15"), USER("user16"),
    USER("user17"), USER("user18"), USER("user19"), USER("user20"), USER("user21"),
    USER("user22"), USER("user23"), USER("user24"), USER("user25"), USER("user26"),
    USER("user27"), USER("user28"), USER("user29"), USER("user30"), USER("user31"),
};
/* clang-format on */

_Static_assert(DG_COUNT(regions) == DG_BISS_REGION_COUNT, "a region a bank");

/* The longest commit is a bank. */
const struct dg_store_layout dg_biss_layout = {
    .id = 0x42495331u,
    .journal_size = 6u + DG_BISS_BANK_SIZE,
    .region_count = DG_BISS_REGION_COUNT,
    .regions = regions,
};

static bool widths_ok(const struct dg_biss_model *model)
{
    const uint32_t mt = model->multiturn_bits;
    const uint32_t st = model->singleturn_bits;

    if (model->form != NULL) {
        return model->form->fits(model);
    }
    return mt <= DG_BISS_MULTITURN_BITS_MAX && st >= DG_BISS_SINGLETURN_BITS_MIN &&
           st <= DG_BISS_SINGLETURN_BITS_MAX && mt + st <= BISS_USUAL_BITS_MAX;
}

bool dg_biss_model_ok(const struct dg_biss_model *model)
{
    return widths_ok(model) && model->busy <= DG_BISS_BUSY_S_MAX_NS &&
           model->busy_jitter <= DG_BISS_BUSY_S_MAX_NS - model->busy &&
           model->timeout <= DG_BISS_TIMEOUT_MAX_NS &&
           model->eeprom_read <= DG_BISS_BUSY_R_MAX_NS &&
           model->eeprom_write <= DG_BISS_BUSY_R_MAX_NS - model->eeprom_read;
}

int dg_biss_format(struct dg_nvm nvm)
{
    return dg_store_format(&dg_biss_layout, nvm, NULL);
}

int dg_biss_init(struct dg_biss *self, const struct dg_biss_setup *setup)
{
    if (setup->model == NULL || setup->world == NULL || setup->world->angle == NULL ||
        setup->nvm.ops == NULL || !dg_biss_model_ok(setup->model)) {
        return DG_ERR_ARGUMENT;
    }
    *self = (struct dg_biss){.setup = *setup, .noise = setup->model->serial};
    dg_biss_power_off(self);
    return DG_OK;
}

bool dg_biss_eeprom(const struct dg_biss *self)
{
    return self->mounted && self->setup.world->eeprom_acknowledges;
}

const struct dg_store_layout *dg_biss_layout_of(const struct dg_biss_model *model)
{
    return model->layout != NULL ? model->layout : &dg_biss_layout;
}

int dg_biss_mount(struct dg_store *self, const struct dg_biss_model *model, struct dg_nvm nvm)
{
    int result = dg_store_mount(self, dg_biss_layout_of(model), nvm);

    return result == DG_ERR_OLDER ? dg_store_grow(self, model) : result;
}

/* @return dg_store_mount()'s */
static int load_factory(struct dg_biss *self)
{
    int result = DG_ERR_IO;

    if (self->setup.world->eeprom_acknowledges) {
        result = dg_biss_mount(&self->store, self->setup.model, self->setup.nvm);
    }
    self->mounted = result == DG_OK;
    if (!self->mounted) {
        self->store.damaged = 0; /* nothing is known of it */
    }
    if (!self->mounted || dg_store_damaged(&self->store, DG_BISS_REGION_CONFIG) ||
        dg_store_read(&self->store, DG_BISS_REGION_CONFIG, 0, self->config, BISS_CONFIG_SIZE) !=
            DG_OK) {
        default_config(NULL, self->config);
    }
    return result;
}

int dg_biss_restart(struct dg_biss *self, dg_ns now)
{
    const uint8_t incomplete = DG_BISS_CONFIGURATION | DG_BISS_ABSOLUTE;

    self->control = (struct dg_biss_control){.id = DG_BISS_NO_ID};
    self->position = 0;
    self->ready_at = dg_after(now, self->setup.model->init);
    self->checked_at = 0;
    self->bank = 0;
    self->timeout = 0;
    self->life = 0;
    self->started = false;
    self->simulated = false;
    self->channel_off = false;
    self->communication_off = false;
    /* Low whatever comes in on SLI, which is passed on only behind the first e2. */
    self->line.slo = !self->setup.model->sl_low_at_start;
    self->line.is_last = true;
    self->line.hint = 0;
    self->line.hinted = false;
    const int result = load_factory(self);
    self->configured = (dg_biss_errors(self, now) & incomplete) == 0;
    return result;
}

int dg_biss_power_on(struct dg_biss *self, dg_ns now)
{
    dg_biss_power_off(self);
    const int result = dg_biss_restart(self, now);
    if (result == DG_ERR_BLANK || result == DG_ERR_FOREIGN) {
        dg_biss_power_off(self);
        return result;
    }
    self->line.state = DG_BISS_IDLE;
    self->line.last = now;
    return DG_OK;
}

void dg_biss_power_off(struct dg_biss *self)
{
    self->line = (struct dg_biss_line){
        .deadline = DG_NEVER, .ma = true, .slo = true, .is_last = true, .last = self->line.last};
}
