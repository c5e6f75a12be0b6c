/* SPDX-License-Identifier: MIT */
/*
 * The EEPROM of a K3: its regions, their delivery state, and the working copy. A region that is
 * damaged at power-on, or holds what no command could have stored, is lost (I17).
 */
#include <string.h>

#include "interbus_private.h"

#define SELF_TEST_MAX DG_S(1)
#define K1_COUNTS_MAX 65536u
#define PRESET_SIZE 9u

static void default_steps(const void *ctx, uint8_t *out)
{
    const struct dg_ib_model *model = ctx;

    dg_store_be32(out, model->steps - (model->steps_minus_one ? 1u : 0u));
}

static void default_revolutions(const void *ctx, uint8_t *out)
{
    (void)ctx;
    dg_store_be32(out, 1);
}

static void default_direction(const void *ctx, uint8_t *out)
{
    (void)ctx;
    out[0] = IB_CLOCKWISE;
}

static void default_preset(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memset(out, 0, PRESET_SIZE);
}

/* No zero shift; no operating time. */
static void default_zero4(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memset(out, 0, 4);
}

static void default_mode(const void *ctx, uint8_t *out)
{
    (void)ctx;
    out[0] = DG_IB_POSITION;
}

static void default_shift_iw(const void *ctx, uint8_t *out)
{
    (void)ctx;
    out[0] = 0;
}

static void default_cams(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memset(out, 0, IB_CAMS_SIZE);
}

/* clang-format off */
/* name, size, check, top byte of the start-up error, delivery state */
static const struct dg_store_region regions[DG_IB_REGION_COUNT] = {
    [DG_IB_REGION_STEPS]       = {"steps",        4,            DG_STORE_CHECKED, DG_IB_LOST >> 24, default_steps},
    [DG_IB_REGION_REVOLUTIONS] = {"revolutions",  4,            DG_STORE_CHECKED, DG_IB_LOST >> 24, default_revolutions},
    [DG_IB_REGION_DIRECTION]   = {"direction",    1,            DG_STORE_CHECKED, DG_IB_LOST >> 24, default_direction},
    [DG_IB_REGION_PRESET]      = {"preset",       PRESET_SIZE,  DG_STORE_CHECKED, DG_IB_LOST >> 24, default_preset},
    [DG_IB_REGION_SHIFT]       = {"shift",        4,            DG_STORE_CHECKED, DG_IB_LOST >> 24, default_zero4},
    [DG_IB_REGION_MODE]        = {"mode",         1,            DG_STORE_CHECKED, DG_IB_LOST >> 24, default_mode},
    [DG_IB_REGION_SHIFT_IW]    = {"shift-iw",     1,            DG_STORE_CHECKED, DG_IB_LOST >> 24, default_shift_iw},
    [DG_IB_REGION_CAMS + 0]    = {"cams-1",       IB_CAMS_SIZE, DG_STORE_CHECKED, DG_IB_LOST >> 24, default_cams},
    [DG_IB_REGION_CAMS + 1]    = {"cams-2",       IB_CAMS_SIZE, DG_STORE_CHECKED, DG_IB_LOST >> 24, default_cams},
    [DG_IB_REGION_CAMS + 2]    = {"cams-3",       IB_CAMS_SIZE, DG_STORE_CHECKED, DG_IB_LOST >> 24, default_cams},
    [DG_IB_REGION_CAMS + 3]    = {"cams-4",       IB_CAMS_SIZE, DG_STORE_CHECKED, DG_IB_LOST >> 24, default_cams},
    [DG_IB_REGION_CAMS + 4]    = {"cams-5",       IB_CAMS_SIZE, DG_STORE_CHECKED, DG_IB_LOST >> 24, default_cams},
    [DG_IB_REGION_CAMS + 5]    = {"cams-6",       IB_CAMS_SIZE, DG_STORE_CHECKED, DG_IB_LOST >> 24, default_cams},
    [DG_IB_REGION_CAMS + 6]    = {"cams-7",       IB_CAMS_SIZE, DG_STORE_CHECKED, DG_IB_LOST >> 24, default_cams},
    [DG_IB_REGION_CAMS + 7]    = {"cams-8",       IB_CAMS_SIZE, DG_STORE_CHECKED, DG_IB_LOST >> 24, default_cams},
    [DG_IB_REGION_TIME]        = {"time",         4,            DG_STORE_CHECKED, 0,                default_zero4},
};
/* clang-format on */

/* The longest commit sets everything but the time, 6 bytes of journal each. */
const struct dg_store_layout dg_ib_layout = {
    .id = 0x49423101u,
    .journal_size = 15u * 6u + 4u + 4u + 1u + PRESET_SIZE + 4u + 1u + 1u + 8u * IB_CAMS_SIZE,
    .region_count = DG_IB_REGION_COUNT,
    .regions = regions,
};

/* 0E000000h sets these, whatever their state (I17). */
#define PROFILE_REGIONS                                                                            \
    (IB_REGION_BIT(DG_IB_REGION_STEPS) | IB_REGION_BIT(DG_IB_REGION_REVOLUTIONS) |                 \
     IB_REGION_BIT(DG_IB_REGION_DIRECTION) | IB_REGION_BIT(DG_IB_REGION_PRESET) |                  \
     IB_REGION_BIT(DG_IB_REGION_SHIFT))

int dg_ib_model_check(const struct dg_ib_model *model)
{
    uint32_t counts = (uint32_t)model->steps * model->turns;
    uint32_t least = model->steps_minus_one ? 2 : 1;

    if (model->profile >= DG_IB_PROFILE_COUNT || model->self_test > SELF_TEST_MAX ||
        model->steps < least || model->steps > DG_IB_STEPS_MAX || model->turns < 1 ||
        model->turns > DG_IB_TURNS_MAX || (model->profile == DG_IB_K1 && counts > K1_COUNTS_MAX)) {
        return DG_ERR_ARGUMENT;
    }
    if (model->param_cycles < 1 || model->serial > DG_IB_DATA_MASK ||
        model->version > DG_IB_DATA_MASK) {
        return DG_ERR_ARGUMENT;
    }
    return DG_OK;
}

const struct dg_store_layout *dg_ib_layout_of(const struct dg_ib_model *model)
{
    if (model->profile != DG_IB_K3) {
        return NULL;
    }
    return model->layout != NULL ? model->layout : &dg_ib_layout;
}

int dg_ib_format(const struct dg_ib_model *model, struct dg_nvm nvm)
{
    int result = dg_ib_model_check(model);

    return result == DG_OK && model->profile == DG_IB_K3
               ? dg_store_format(dg_ib_layout_of(model), nvm, model)
               : result;
}

int dg_ib_mount(struct dg_store *self, const struct dg_ib_model *model, struct dg_nvm nvm)
{
    int result = dg_store_mount(self, dg_ib_layout_of(model), nvm);

    return result == DG_ERR_OLDER ? dg_store_grow(self, model) : result;
}

/* A region as it is stored; lost, its delivery state. */
static void load_or_default(struct dg_ib *self, uint8_t region, uint8_t *to)
{
    const struct dg_store_region *row = &regions[region];

    if (!self->mounted || dg_store_damaged(&self->store, region) ||
        dg_store_read(&self->store, region, 0, to, row->size) != DG_OK) {
        row->defaults(self->setup.model, to);
        self->lost |= IB_REGION_BIT(region);
    }
}

static uint32_t load_u32(struct dg_ib *self, uint8_t region)
{
    uint8_t bytes[4];

    load_or_default(self, region, bytes);
    return dg_load_be32(bytes);
}

/* A byte of low..high; lost, its delivery state. */
static uint8_t load_u8(struct dg_ib *self, uint8_t region, uint8_t low, uint8_t high)
{
    uint8_t byte;

    load_or_default(self, region, &byte);
    if (byte < low || byte > high) {
        regions[region].defaults(self->setup.model, &byte);
        self->lost |= IB_REGION_BIT(region);
    }
    return byte;
}

/* Steps that do not fit the revolutions, because either is damaged, have to be set again, too. */
static void load_scale(struct dg_ib *self)
{
    const struct dg_ib_model *model = self->setup.model;
    uint8_t bytes[4];

    self->steps = load_u32(self, DG_IB_REGION_STEPS) & DG_IB_DATA_MASK;
    self->revolutions = load_u32(self, DG_IB_REGION_REVOLUTIONS);
    if (self->revolutions < 1 || self->revolutions > model->turns) {
        self->revolutions = 1;
        self->lost |= IB_REGION_BIT(DG_IB_REGION_REVOLUTIONS);
    }
    if (!dg_ib_fits(model, self->steps, self->revolutions)) {
        default_steps(model, bytes);
        self->steps = dg_load_be32(bytes);
        self->lost |= IB_REGION_BIT(DG_IB_REGION_STEPS);
    }
}

void dg_ib_load(struct dg_ib *self)
{
    uint8_t bytes[PRESET_SIZE];

    self->lost = 0;
    load_scale(self);
    self->direction = load_u8(self, DG_IB_REGION_DIRECTION, IB_CLOCKWISE, IB_COUNTERCLOCKWISE);
    load_or_default(self, DG_IB_REGION_PRESET, bytes);
    self->preset = dg_load_be32(&bytes[0]) & DG_IB_DATA_MASK;
    self->offset = dg_load_be32(&bytes[4]) & DG_IB_DATA_MASK;
    self->preset_flag = bytes[8] != 0;
    self->shift = load_u32(self, DG_IB_REGION_SHIFT) & DG_IB_DATA_MASK;
    self->mode =
        load_u8(self, DG_IB_REGION_MODE, DG_IB_POSITION, DG_IB_CAM + (uint8_t)DG_IB_PROGRAMS);
    self->shift_iw = load_u8(self, DG_IB_REGION_SHIFT_IW, 0, IB_SHIFT_IW_MAX);
    if (self->mode > DG_IB_CAM) {
        self->program_number = (uint8_t)(self->mode - DG_IB_CAM);
    }
    for (uint8_t number = 1; number <= DG_IB_PROGRAMS; number++) {
        struct dg_ib_program program;
        dg_ib_load_program(self, number, &program);
        if (self->program_number == number) {
            self->program = program;
        }
    }
    self->time_10min = load_u32(self, DG_IB_REGION_TIME);
    self->lost &= ~IB_REGION_BIT(DG_IB_REGION_TIME); /* nobody can send it again */
}

void dg_ib_load_program(struct dg_ib *self, uint8_t number, struct dg_ib_program *out)
{
    uint8_t bytes[IB_CAMS_SIZE];

    load_or_default(self, (uint8_t)(DG_IB_REGION_CAMS + number - 1u), bytes);
    memset(out, 0, sizeof *out); /* also its padding: devices in one state are the same bytes */
    out->mask = bytes[0];
    out->on_given = bytes[1];
    out->off_given = bytes[2];
    for (uint8_t i = 0; i < DG_IB_CAMS; i++) {
        out->on[i] = dg_load_be32(&bytes[3u + 8u * i]);
        out->off[i] = dg_load_be32(&bytes[7u + 8u * i]);
    }
}

static bool writable(const struct dg_ib *self)
{
    return self->mounted && self->setup.world->eeprom_acknowledges;
}

static bool store_region(struct dg_ib *self, uint8_t region, const uint8_t *bytes)
{
    if (!writable(self) ||
        dg_store_put(&self->store, region, 0, bytes, regions[region].size) != DG_OK) {
        return false;
    }
    self->lost &= ~IB_REGION_BIT(region);
    return true;
}

bool dg_ib_put_u32(struct dg_ib *self, uint8_t region, uint32_t value)
{
    uint8_t bytes[4];

    dg_store_be32(bytes, value);
    return store_region(self, region, bytes);
}

bool dg_ib_put_u8(struct dg_ib *self, uint8_t region, uint8_t value)
{
    return store_region(self, region, &value);
}

static void preset_bytes(uint8_t *to, uint32_t preset, uint32_t offset, bool flag)
{
    dg_store_be32(&to[0], preset);
    dg_store_be32(&to[4], offset);
    to[8] = flag ? 1 : 0;
}

bool dg_ib_put_preset(struct dg_ib *self, uint32_t preset, uint32_t offset, bool flag)
{
    uint8_t bytes[PRESET_SIZE];

    preset_bytes(bytes, preset, offset, flag);
    return store_region(self, DG_IB_REGION_PRESET, bytes);
}

/* Nothing, unless this region waits. */
static void stage_sent(struct dg_ib *self, const struct dg_ib_sent *sent, uint8_t region,
                       const uint8_t *bytes)
{
    if ((sent->waits & IB_REGION_BIT(region)) != 0) {
        (void)dg_store_stage(&self->store, region, 0, bytes, regions[region].size);
    }
}

static bool store_sent(struct dg_ib *self, const struct dg_ib_sent *sent)
{
    uint8_t bytes[PRESET_SIZE];

    dg_store_begin(&self->store);
    dg_store_be32(bytes, sent->steps);
    stage_sent(self, sent, DG_IB_REGION_STEPS, bytes);
    dg_store_be32(bytes, sent->revolutions);
    stage_sent(self, sent, DG_IB_REGION_REVOLUTIONS, bytes);
    preset_bytes(bytes, sent->preset, self->offset, true);
    stage_sent(self, sent, DG_IB_REGION_PRESET, bytes);
    dg_store_be32(bytes, sent->shift);
    stage_sent(self, sent, DG_IB_REGION_SHIFT, bytes);
    /* A failed stage fails the commit. */
    return dg_store_commit(&self->store) == DG_OK;
}

bool dg_ib_put_sent(struct dg_ib *self, const struct dg_ib_sent *sent)
{
    if (!writable(self) || !store_sent(self, sent)) {
        return false;
    }
    self->lost &= ~(uint32_t)sent->waits;
    self->steps = sent->steps;
    self->revolutions = sent->revolutions;
    self->preset = sent->preset;
    self->shift = sent->shift;
    self->preset_flag =
        self->preset_flag || (sent->waits & IB_REGION_BIT(DG_IB_REGION_PRESET)) != 0;
    return true;
}

bool dg_ib_put_program(struct dg_ib *self, const struct dg_ib_program *program)
{
    uint8_t bytes[IB_CAMS_SIZE];

    bytes[0] = program->mask;
    bytes[1] = program->on_given;
    bytes[2] = program->off_given;
    for (uint8_t i = 0; i < DG_IB_CAMS; i++) {
        dg_store_be32(&bytes[3u + 8u * i], program->on[i]);
        dg_store_be32(&bytes[7u + 8u * i], program->off[i]);
    }
    return store_region(self, (uint8_t)(DG_IB_REGION_CAMS + self->program_number - 1u), bytes);
}

bool dg_ib_put_defaults(struct dg_ib *self)
{
    uint8_t bytes[IB_CAMS_SIZE];

    if (!writable(self)) {
        return false;
    }
    dg_store_begin(&self->store);
    for (uint8_t region = 0; region < DG_IB_REGION_COUNT; region++) {
        if (((PROFILE_REGIONS | self->lost) & IB_REGION_BIT(region)) != 0) {
            regions[region].defaults(self->setup.model, bytes);
            (void)dg_store_stage(&self->store, region, 0, bytes, regions[region].size);
        }
    }
    /* A failed stage fails the commit. */
    if (dg_store_commit(&self->store) != DG_OK) {
        return false;
    }
    dg_ib_load(self);
    return true;
}
