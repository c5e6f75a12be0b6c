/* SPDX-License-Identifier: MIT */
/*
 * The EEPROM of the device: its regions, their delivery state, and the working copy read from
 * them at power-on.
 */
#include <string.h>

#include "drehgeber/crc.h"
#include "hiperface_private.h"

/* Steps that do not fit their byte in region 'resolution' stand in region 'steps'. What fits stays
 * in its byte: images from before that region existed mean what they say. */
#define STEPS_ELSEWHERE 0u
#define SERIAL_SIZE 9u
#define VERSION_SIZE 20u
#define DATE_SIZE 8u
/* Of region 'type': codes, then these. */
#define TYPE_SERIAL 2u
#define TYPE_SIZE (TYPE_SERIAL + SERIAL_SIZE + VERSION_SIZE + DATE_SIZE)
#define DESIGNATION_SIZE 18u
/* All parameters of the label are given; no second selector follows (5.1.1.2.2). */
#define LABEL_SELECTOR 0x07FFu
#define LABEL_PARAMETERS 0x1Eu

static void default_resolution(const void *ctx, uint8_t *out)
{
    const struct dg_hf_model *model = ctx;

    dg_store_be16(&out[0], model->periods_per_turn);
    out[2] =
        (uint8_t)(model->steps_per_period > UINT8_MAX ? STEPS_ELSEWHERE : model->steps_per_period);
    dg_store_be32(&out[3], model->turns);
}

static void default_steps(const void *ctx, uint8_t *out)
{
    const struct dg_hf_model *model = ctx;

    dg_store_be32(out, model->steps_per_period);
}

static void default_implemented(const void *ctx, uint8_t *out)
{
    const struct dg_hf_model *model = ctx;

    out[0] = model->implemented_blocks;
}

static void default_uart(const void *ctx, uint8_t *out)
{
    (void)ctx;
    out[0] = DG_HF_UART_DEFAULT;
    out[1] = DG_HF_ADDRESS_DEFAULT;
}

static void default_memory(const void *ctx, uint8_t *out)
{
    const struct dg_hf_model *model = ctx;

    out[0] = model->memory_blocks;
}

static void default_codes(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memset(out, DG_HF_CODE_DEFAULT, 4);
}

/* Trims of a sensor that needs none, an offset of 0, no data fields, a counter of 0. */
static void default_zero4(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memset(out, 0, 4);
}

static void default_zero16(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memset(out, 0, 16);
}

static void default_counter(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memset(out, 0, 3);
}

static void default_fields(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memset(out, 0, 1u + HF_FIELDS_MAX);
}

/* A text of at most `size` characters, padded with 00h. */
static void write_padded_text(struct dg_writer *w, const char *text, size_t size)
{
    bool ended = false;

    for (size_t i = 0; i < size; i++) {
        ended = ended || text[i] == '\0';
        dg_write_u8(w, ended ? 0 : (uint8_t)text[i]);
    }
}

static void default_type(const void *ctx, uint8_t *out)
{
    const struct dg_hf_model *model = ctx;
    struct dg_writer w = dg_writer(out, TYPE_SIZE);

    dg_write_u8(&w, model->type_code);
    dg_write_u8(&w, model->option_code);
    write_padded_text(&w, model->serial, SERIAL_SIZE);
    write_padded_text(&w, model->version, VERSION_SIZE);
    write_padded_text(&w, model->date, DATE_SIZE);
}

static void default_label(const void *ctx, uint8_t *out)
{
    const struct dg_hf_model *model = ctx;
    const uint16_t parameters[] = {
        model->temperature_channel,
        (uint16_t)model->temperature_min_degc,
        (uint16_t)model->temperature_max_degc,
        model->led_channel,
        model->led_min_ma,
        model->led_max_ma,
        model->vector_channel,
        model->vector_min,
        model->vector_max,
        model->speed_max_rpm,
        model->acceleration_max_krad_s2,
    };
    struct dg_writer w = dg_writer(out, HF_LABEL_SIZE);

    memset(out, 0, HF_LABEL_SIZE);
    dg_write_u8(&w, 0); /* the check sum, below */
    dg_write_u8(&w, 0); /* rotary, counting up from 0 */
    dg_write_be32(&w, model->periods_per_turn);
    dg_write_be32(&w, model->turns);
    write_padded_text(&w, model->designation, DESIGNATION_SIZE);
    dg_write_be16(&w, LABEL_SELECTOR);
    for (size_t i = 0; i < DG_COUNT(parameters); i++) {
        dg_write_be16(&w, parameters[i]);
    }
    out[0] = dg_xor8(0, out, HF_LABEL_SIZE);
}

/* clang-format off */
/* name, size, check, start-up code (5.1.3.2 - 5.1.3.5, 5.1.3.14, 5.1.3.15), delivery state */
static const struct dg_store_region regions[DG_HF_REGION_COUNT] = {
    [DG_HF_REGION_RESOLUTION]  = {"resolution",     7, DG_STORE_CHECKED, DG_HF_COMPENSATION, default_resolution},
    [DG_HF_REGION_CALIBRATION] = {"calibration",   16, DG_STORE_CHECKED, DG_HF_COMPENSATION, default_zero16},
    [DG_HF_REGION_OFFSET]      = {"offset",         4, DG_STORE_CHECKED, DG_HF_ANGLE_OFFSET, default_zero4},
    [DG_HF_REGION_SYNC]        = {"sync",           4, DG_STORE_CHECKED, DG_HF_ANGLE_OFFSET, default_zero4},
    [DG_HF_REGION_UART]        = {"uart",           2, DG_STORE_CHECKED, DG_HF_PARTITION,    default_uart},
    [DG_HF_REGION_MEMORY]      = {"memory",         1, DG_STORE_CHECKED, DG_HF_PARTITION,    default_memory},
    [DG_HF_REGION_CODES]       = {"codes",          4, DG_STORE_CHECKED, DG_HF_PARTITION,    default_codes},
    [DG_HF_REGION_FIELDS]      = {"fields",       113, DG_STORE_CHECKED, DG_HF_PARTITION,    default_fields},
    [DG_HF_REGION_TYPE]        = {"type",          39, DG_STORE_CHECKED, DG_HF_I2C,          default_type},
    [DG_HF_REGION_COUNTER]     = {"counter",        3, DG_STORE_CHECKED, DG_HF_COUNTER,      default_counter},
    [DG_HF_REGION_LABEL]       = {"label",         64, DG_STORE_CHECKED, DG_HF_FIELD_NUMBER, default_label},
    [DG_HF_REGION_FIELD_SUMS]  = {"field-sums",   224, DG_STORE_RAW,     0,                  NULL},
    [DG_HF_REGION_USER]        = {"user",        1792, DG_STORE_RAW,     0,                  NULL},
    [DG_HF_REGION_STEPS]       = {"steps",          4, DG_STORE_CHECKED, DG_HF_COMPENSATION, default_steps},
    [DG_HF_REGION_IMPLEMENTED] = {"implemented",    1, DG_STORE_CHECKED, DG_HF_PARTITION,    default_implemented},
};
/* clang-format on */

_Static_assert(39 == TYPE_SIZE, "type: codes, serial number, version, date");
_Static_assert(113 == 1 + HF_FIELDS_MAX, "fields: count and a status byte each");
_Static_assert(224 == 2 * HF_FIELDS_MAX, "field-sums: a CRC-16 each");
_Static_assert(1792 == HF_BLOCK * HF_FIELDS_MAX, "user: 70h blocks");

/* The longest commit is 4Bh's: 128 bytes of content and a sum, 6 bytes of journal each. */
const struct dg_store_layout dg_hf_layout = {
    .id = 0x48463101u,
    .journal_size = 6u + 128u + 6u + 2u,
    .region_count = DG_HF_REGION_COUNT,
    .regions = regions,
};

/* turns * periods * steps has to fit 32 bits of position. */
static bool resolution_fits(uint32_t periods, uint32_t steps, uint32_t turns)
{
    uint64_t per_turn = (uint64_t)periods * steps;

    return per_turn != 0 && per_turn <= DG_HF_STEPS_PER_TURN_MAX && turns != 0 &&
           turns <= ((uint64_t)1 << 32) / per_turn;
}

static bool implemented_fits(uint8_t implemented, uint8_t blocks)
{
    return implemented == 0 || (implemented >= blocks && implemented <= DG_HF_IMPLEMENTED_MAX);
}

int dg_hf_model_check(const struct dg_hf_model *model)
{
    if (!resolution_fits(model->periods_per_turn, model->steps_per_period, model->turns)) {
        return DG_ERR_ARGUMENT;
    }
    if (model->init > DG_HF_INIT_MAX || model->memory_blocks == 0 ||
        model->memory_blocks > HF_FIELDS_MAX ||
        !implemented_fits(model->implemented_blocks, model->memory_blocks)) {
        return DG_ERR_ARGUMENT;
    }
    return DG_OK;
}

int dg_hf_format(const struct dg_hf_model *model, struct dg_nvm nvm)
{
    int result = dg_hf_model_check(model);

    return result == DG_OK ? dg_store_format(dg_hf_layout_of(model), nvm, model) : result;
}

int dg_hf_mount(struct dg_store *self, const struct dg_hf_model *model, struct dg_nvm nvm)
{
    int result = dg_store_mount(self, dg_hf_layout_of(model), nvm);

    return result == DG_ERR_OLDER ? dg_store_grow(self, model) : result;
}

static bool read_intact(struct dg_store *store, uint8_t region, uint8_t *to)
{
    return !dg_store_damaged(store, region) &&
           dg_store_read(store, region, 0, to, regions[region].size) == DG_OK;
}

int64_t dg_hf_serial(struct dg_store *store)
{
    uint8_t type[TYPE_SIZE];
    int64_t serial = 0;

    if (!read_intact(store, DG_HF_REGION_TYPE, type)) {
        return -1;
    }
    for (size_t i = TYPE_SERIAL; i < TYPE_SERIAL + SERIAL_SIZE; i++) {
        if (type[i] < '0' || type[i] > '9') {
            return -1;
        }
        serial = 10 * serial + (type[i] - '0');
    }
    return serial;
}

/* Regions that nobody can write over the wire. Serial number, firmware version and date are the
 * unit's, not the model's. */
const char *dg_hf_differs(const struct dg_hf_model *model, struct dg_store *store)
{
    static const struct {
        uint8_t region;
        const char *what;
    } burnt[] = {
        {DG_HF_REGION_RESOLUTION, "periods, steps or turns"},
        {DG_HF_REGION_STEPS, "steps"},
        {DG_HF_REGION_TYPE, "type code or option"},
        {DG_HF_REGION_MEMORY, "user memory size"},
        {DG_HF_REGION_IMPLEMENTED, "implemented memory"},
        {DG_HF_REGION_LABEL, "type label"},
    };
    uint8_t mine[DG_STORE_CHECKED_MAX];
    uint8_t bytes[DG_STORE_CHECKED_MAX];

    for (uint8_t i = 0; i < DG_COUNT(burnt); i++) {
        const uint8_t region = burnt[i].region;
        const uint16_t size = region == DG_HF_REGION_TYPE ? TYPE_SERIAL : regions[region].size;
        regions[region].defaults(model, mine);
        if (read_intact(store, region, bytes) && memcmp(mine, bytes, size) != 0) {
            return burnt[i].what;
        }
    }
    return NULL;
}

/* Read a region that is in order; `to` keeps its content otherwise. */
static bool load_sound_region(struct dg_hf *self, enum dg_hf_region region, uint8_t *to)
{
    return !dg_store_damaged(&self->store, (uint8_t)region) &&
           dg_hf_get(self, region, to) == DG_HF_NO_ERROR;
}

static void load_from_model(struct dg_hf *self)
{
    const struct dg_hf_model *model = self->setup.model;

    self->periods = model->periods_per_turn;
    self->steps = model->steps_per_period;
    self->turns = model->turns;
    self->blocks = model->memory_blocks;
    self->offset = 0;
    self->address = DG_HF_ADDRESS_DEFAULT;
    self->uart_stored = DG_HF_UART_DEFAULT;
    self->implemented =
        model->implemented_blocks != 0 ? model->implemented_blocks : model->memory_blocks;
    memset(self->codes, DG_HF_CODE_DEFAULT, sizeof self->codes);
}

static void load_resolution(struct dg_hf *self)
{
    uint8_t bytes[7];
    uint8_t beyond[4] = {0};

    if (!load_sound_region(self, DG_HF_REGION_RESOLUTION, bytes)) {
        return;
    }
    uint32_t periods = dg_load_be16(&bytes[0]);
    uint32_t steps = bytes[2];
    uint32_t turns = dg_load_be32(&bytes[3]);
    if (steps == STEPS_ELSEWHERE && load_sound_region(self, DG_HF_REGION_STEPS, beyond)) {
        steps = dg_load_be32(beyond);
    }
    if (resolution_fits(periods, steps, turns)) {
        self->periods = (uint16_t)periods;
        self->steps = steps;
        self->turns = turns;
    }
}

static void load_memory_size(struct dg_hf *self)
{
    uint8_t blocks;

    /* More blocks than there are would be fields beyond their table. */
    if (load_sound_region(self, DG_HF_REGION_MEMORY, &blocks) && blocks <= HF_FIELDS_MAX) {
        self->blocks = blocks;
    }
    if (load_sound_region(self, DG_HF_REGION_IMPLEMENTED, &blocks) &&
        implemented_fits(blocks, self->blocks)) {
        self->implemented = blocks != 0 ? blocks : self->blocks;
    }
}

static void load_limits(struct dg_hf *self, const uint8_t *label)
{
    const uint8_t *parameter = &label[LABEL_PARAMETERS];

    self->channels[0] = parameter[1];
    self->temperature_min_degc = (int16_t)dg_load_be16(&parameter[2]);
    self->temperature_max_degc = (int16_t)dg_load_be16(&parameter[4]);
    self->channels[1] = parameter[7];
    self->led_max_ma = dg_load_be16(&parameter[10]);
    self->channels[2] = parameter[13];
    self->speed_max_rpm = dg_load_be16(&parameter[18]);
}

void dg_hf_load(struct dg_hf *self, bool mounted)
{
    uint8_t bytes[HF_LABEL_SIZE];

    load_from_model(self);
    default_label(self->setup.model, bytes);
    if (mounted) {
        (void)load_sound_region(self, DG_HF_REGION_LABEL, bytes);
    }
    load_limits(self, bytes);
    if (!mounted) {
        return;
    }
    load_resolution(self);
    load_memory_size(self);
    if (load_sound_region(self, DG_HF_REGION_OFFSET, bytes)) {
        uint64_t range = (uint64_t)self->periods * self->steps * self->turns;
        self->offset = (uint32_t)(dg_load_be32(bytes) % range);
    }
    if (load_sound_region(self, DG_HF_REGION_UART, bytes)) {
        self->uart_stored = bytes[0];
        self->address = bytes[1];
    }
    (void)load_sound_region(self, DG_HF_REGION_CODES, self->codes);
}
