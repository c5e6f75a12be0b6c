/* SPDX-License-Identifier: MIT */
/* One row for each block of registers: reading, writing, checking and the printed map use it. */
#include "drehgeber/ring_coupler.h"

#include "drehgeber/bits.h"
#include "drehgeber/ring_master.h"
#include "drehgeber/text.h"
#include "drehgeber/version.h"

#define OUTPUT_IMAGE 0x0800u
#define DEVICES 0x2000u
#define DEVICE_REGISTERS 16u
#define RESET_FIRST 0xBECFu
#define RESET_SECOND 0xAFFEu
#define TEXT_REGISTERS 10u
#define ID_MESSAGES 0xE000u
#define DESCRIPTION_MAX 160u

/* Sizes that depend on the ring. */
enum size { FIXED, IMAGE, PER_DEVICE };

struct row {
    uint16_t first;
    uint16_t count; /* when FIXED */
    enum size size;
    uint16_t (*read)(const struct dg_ib_coupler *self, uint16_t index);
    void (*write)(struct dg_ib_coupler *self, uint16_t index, uint16_t value); /* NULL: read only */
    uint16_t most; /* that may be written */
    const char *what;
};

static uint16_t high(uint32_t value)
{
    return (uint16_t)(value >> 16);
}

/* Register 0 or 1 of a pair, high word first. */
static uint16_t half(uint32_t value, uint16_t index)
{
    return index == 0 ? high(value) : (uint16_t)value;
}

static const struct dg_ring_state *state_of(const struct dg_ib_coupler *self)
{
    return dg_ring_state(self->master->setup.bus);
}

static size_t device_count(const struct dg_ib_coupler *self)
{
    return dg_bus_count(self->master->setup.bus);
}

static const struct dg_ib *device_at(const struct dg_ib_coupler *self, size_t place)
{
    return dg_bus_device(self->master->setup.bus, place);
}

static const struct dg_ib_model *model_at(const struct dg_ib_coupler *self, size_t place)
{
    return dg_bus_settings(self->master->setup.bus, place);
}

static unsigned id_at(const struct dg_ib_coupler *self, size_t place)
{
    return dg_ring_id_word(self->master->setup.bus, place) & ~ID_MESSAGES;
}

static uint16_t read_input(const struct dg_ib_coupler *self, uint16_t index)
{
    return dg_ring_master_in(self->master)[index];
}

static uint16_t read_output(const struct dg_ib_coupler *self, uint16_t index)
{
    return self->master->setup.out[index];
}

static void write_output(struct dg_ib_coupler *self, uint16_t index, uint16_t value)
{
    self->master->setup.out[index] = value;
    dg_ring_master_start(self->master, self->now);
}

static uint16_t read_text(const struct dg_ib_coupler *self, uint16_t index)
{
    char to[2u * TEXT_REGISTERS + 1u] = "";
    struct dg_text text = dg_text_in(to, sizeof to);

    (void)self;
    dg_text_add(&text, "drehgeber IB " DG_VERSION);
    return dg_load_be16((const uint8_t *)to + (size_t)2u * index);
}

/* The ring that was found is not the one that is expected. */
static bool mismatch(const struct dg_ib_coupler *self)
{
    const uint16_t reached = state_of(self)->reached;

    for (uint16_t i = 0; i < reached; i++) {
        if (id_at(self, i) != dg_ib_id_word(model_at(self, i))) {
            return true;
        }
    }
    return reached < device_count(self);
}

static bool has_module_error(const struct dg_ib_coupler *self)
{
    for (size_t i = 0; i < device_count(self); i++) {
        if (dg_ib_module_error(device_at(self, i))) {
            return true;
        }
    }
    return false;
}

static uint16_t read_status(const struct dg_ib_coupler *self, uint16_t index)
{
    const bool whole = state_of(self)->result == DG_RING_OK;

    (void)index;
    return (uint16_t)((whole && !self->master->stopped ? 1u : 0u) | (whole ? 0u : 2u) |
                      (has_module_error(self) ? 4u : 0u) | (mismatch(self) ? 8u : 0u));
}

static uint16_t read_image_bits(const struct dg_ib_coupler *self, uint16_t index)
{
    (void)index;
    return (uint16_t)(16u * state_of(self)->words);
}

static uint16_t read_zero(const struct dg_ib_coupler *self, uint16_t index)
{
    (void)self;
    (void)index;
    return 0;
}

static uint16_t read_missed(const struct dg_ib_coupler *self, uint16_t index)
{
    return half(self->master->missed, index);
}

static uint16_t read_watchdog_left(const struct dg_ib_coupler *self, uint16_t index)
{
    const struct dg_ring_watchdog *watchdog = &self->master->watchdog;
    const dg_ns time = DG_MS(watchdog->time_ms);
    const dg_ns passed = dg_elapsed(self->now, watchdog->fed);

    (void)index;
    if (!watchdog->armed || watchdog->fired || passed >= time) {
        return 0;
    }
    return (uint16_t)((time - passed) / DG_MS(1));
}

static uint16_t read_watchdog_time(const struct dg_ib_coupler *self, uint16_t index)
{
    (void)index;
    return self->master->watchdog.time_ms;
}

static void write_watchdog_time(struct dg_ib_coupler *self, uint16_t index, uint16_t value)
{
    (void)index;
    self->master->watchdog.time_ms = value;
    self->master->watchdog.fed = self->now;
}

static uint16_t read_watchdog_fired(const struct dg_ib_coupler *self, uint16_t index)
{
    (void)index;
    return self->master->watchdog.fired ? 1 : 0;
}

static void write_watchdog_reset(struct dg_ib_coupler *self, uint16_t index, uint16_t value)
{
    (void)index;
    if (self->key == RESET_FIRST && value == RESET_SECOND && self->master->watchdog.fired) {
        dg_ring_master_reset(self->master);
    }
    self->key = value;
}

static uint16_t read_feeding(const struct dg_ib_coupler *self, uint16_t index)
{
    (void)index;
    return self->fed_by_each;
}

static void write_feeding(struct dg_ib_coupler *self, uint16_t index, uint16_t value)
{
    (void)index;
    self->fed_by_each = value;
}

static uint16_t read_fallback(const struct dg_ib_coupler *self, uint16_t index)
{
    (void)index;
    return self->master->watchdog.fallback;
}

static void write_fallback(struct dg_ib_coupler *self, uint16_t index, uint16_t value)
{
    (void)index;
    self->master->watchdog.fallback = value;
}

static uint16_t state_bits(const struct dg_ib *device, dg_ns now)
{
    const bool error = device->answer >> 29 == 4;

    return (uint16_t)((device->powered ? 1u : 0u) | (now < device->ready_at ? 2u : 0u) |
                      (device->answer != 0 && !error ? 4u : 0u) | (error ? 8u : 0u) |
                      (device->item != 0 ? 16u : 0u) | (device->preset_flag ? 32u : 0u) |
                      (device->lost != 0 ? 64u : 0u) | (device->invalid ? 128u : 0u));
}

static uint16_t read_device(const struct dg_ib_coupler *self, uint16_t index)
{
    const uint16_t number = (uint16_t)(index / DEVICE_REGISTERS);
    const struct dg_ib *device = device_at(self, number);
    const unsigned id = number < state_of(self)->reached ? id_at(self, number) : 0;
    const uint16_t registers[DEVICE_REGISTERS] = {
        [0] = (uint16_t)id,
        [1] = state_bits(device, self->now),
        [2] = high(device->counters.cycles),
        [3] = (uint16_t)device->counters.cycles,
        [4] = high(device->counters.crc_errors),
        [5] = (uint16_t)device->counters.crc_errors,
        [6] = dg_ib_leds(device, self->now),
        [7] = device->mode,
        [8] = high(device->last_command),
        [9] = (uint16_t)device->last_command,
        [10] = high(device->last_error),
        [11] = (uint16_t)device->last_error,
    };

    return registers[index % DEVICE_REGISTERS];
}

/* clang-format off */
static const struct row rows[] = {
    {0x0000,       0,              IMAGE,      read_input,          NULL,                 0,      "input image (IN), words in ring order, high word first"},
    {OUTPUT_IMAGE, 0,              IMAGE,      read_output,         write_output,         0xFFFF, "output image (OUT); the two words of a device in one request"},
    {0x1000,       TEXT_REGISTERS, FIXED,      read_text,           NULL,                 0,      "identification, 2 characters in each"},
    {0x100C,       1,              FIXED,      read_status,         NULL,                 0,      "coupler status: b0 run, b1 bus error, b2 module error, b3 ID mismatch"},
    {0x1010,       1,              FIXED,      read_image_bits,     NULL,                 0,      "output image, bits"},
    {0x1011,       1,              FIXED,      read_image_bits,     NULL,                 0,      "input image, bits"},
    {0x1012,       2,              FIXED,      read_zero,           NULL,                 0,      "digital output and input image, bits: none"},
    {0x1014,       2,              FIXED,      read_missed,         NULL,                 0,      "missed cycles, high word first"},
    {0x1020,       1,              FIXED,      read_watchdog_left,  NULL,                 0,      "watchdog: ms left"},
    {0x1120,       1,              FIXED,      read_watchdog_time,  write_watchdog_time,  0xFFFF, "watchdog: time in ms, 0: off"},
    {0x1121,       1,              FIXED,      read_watchdog_fired, write_watchdog_reset, 0xFFFF, "watchdog: 1: has fired; write BECFh, then AFFEh, to reset"},
    {0x1122,       1,              FIXED,      read_feeding,        write_feeding,        1,      "watchdog: fed by 1: every request, 0: writes of OUT"},
    {0x1123,       1,              FIXED,      read_fallback,       write_fallback,       DG_RING_FALLBACK_COUNT - 1, "fallback: 0 OUT is zero, 1 OUT freezes, 2 the ring stops"},
    {DEVICES,      0,              PER_DEVICE, read_device,         NULL,                 0,      NULL},
};

/* Of a device; the high word first. */
static const struct {
    uint16_t at;
    const char *what;
} device_rows[] = {
    {0,  "ID word without messages; 0: not reached"},
    {1,  "state: b0 power, b1 self-test, b2 parameters, b3 error, b4 read-out, b5 preset set, b6 parameters lost, b7 position not valid"},
    {2,  "data cycles"},
    {4,  "CRC errors"},
    {6,  "LEDs: b0 UL, b1 RC, b2 BA, b3 RD, b4 BA blinks"},
    {7,  "mode: 0 K1 or K2, 1 position, 2 speed, 2 + p cam program p"},
    {8,  "last command"},
    {10, "last error"},
};
/* clang-format on */
#define ROWS DG_COUNT(rows)

static uint32_t count_of(const struct dg_ib_coupler *self, const struct row *row)
{
    switch (row->size) {
    case FIXED:
        return row->count;
    case IMAGE:
        return state_of(self)->words;
    case PER_DEVICE:
        return DEVICE_REGISTERS * (uint32_t)device_count(self);
    }
    return 0;
}

static const struct row *row_at(const struct dg_ib_coupler *self, uint32_t address)
{
    for (size_t i = 0; i < ROWS; i++) {
        if (address >= rows[i].first && address - rows[i].first < count_of(self, &rows[i])) {
            return &rows[i];
        }
    }
    return NULL;
}

/* Whether `boundary` is between the two words of a device. */
static bool splits(const struct dg_ib_coupler *self, uint32_t boundary)
{
    uint32_t at = OUTPUT_IMAGE;

    for (size_t i = 0; i < device_count(self) && at < boundary; i++) {
        at += dg_ib_image_words(model_at(self, i));
    }
    return boundary > OUTPUT_IMAGE && boundary < at;
}

void dg_ib_coupler_init(struct dg_ib_coupler *self, struct dg_ring_master *master, bool tear)
{
    *self = (struct dg_ib_coupler){.master = master, .tear = tear, .fed_by_each = 1};
}

void dg_ib_coupler_request(struct dg_ib_coupler *self, dg_ns now)
{
    dg_ring_master_to(self->master, now);
    self->now = now;
    if (self->fed_by_each != 0) {
        dg_ring_master_feed(self->master, now);
    }
}

bool dg_ib_coupler_readable(const struct dg_ib_coupler *self, struct dg_ib_registers range)
{
    for (uint32_t i = 0; i < range.count; i++) {
        if (row_at(self, range.first + i) == NULL) {
            return false;
        }
    }
    return true;
}

bool dg_ib_coupler_writable(const struct dg_ib_coupler *self, struct dg_ib_registers range)
{
    for (uint32_t i = 0; i < range.count; i++) {
        const struct row *row = row_at(self, range.first + i);
        if (row == NULL || row->write == NULL) {
            return false;
        }
    }
    const uint32_t end = (uint32_t)range.first + range.count;
    return self->tear || (!splits(self, range.first) && !splits(self, end));
}

void dg_ib_coupler_read(const struct dg_ib_coupler *self, struct dg_ib_registers range,
                        uint16_t *to)
{
    for (uint32_t i = 0; i < range.count; i++) {
        const struct row *row = row_at(self, range.first + i);
        to[i] = row == NULL ? 0 : row->read(self, (uint16_t)(range.first + i - row->first));
    }
}

/* All of them, or with `write` false none. @return false: one of them is not possible */
static bool write_registers(struct dg_ib_coupler *self, struct dg_ib_registers range,
                            const uint16_t *values, bool write)
{
    for (uint32_t i = 0; i < range.count; i++) {
        const struct row *row = row_at(self, range.first + i);
        if (row == NULL || row->write == NULL || values[i] > row->most) {
            return false;
        }
        if (write) {
            row->write(self, (uint16_t)(range.first + i - row->first), values[i]);
        }
    }
    return true;
}

bool dg_ib_coupler_write(struct dg_ib_coupler *self, struct dg_ib_registers range,
                         const uint16_t *values)
{
    if (!write_registers(self, range, values, false)) {
        return false;
    }
    (void)write_registers(self, range, values, true);
    if (range.count > 0) {
        dg_ring_master_stir(self->master);
    }
    return true;
}

/* ------------------------------------------------------------ in words */

/* Who is told. */
struct listener {
    void (*line)(void *ctx, const char *text);
    void *ctx;
};

static void pad_to(struct dg_text *text, size_t column)
{
    while (text->length < column) {
        dg_text_add(text, " ");
    }
}

static void describe_registers(const struct listener *to, struct dg_ib_registers range,
                               const char *access, const char *what)
{
    char line[DESCRIPTION_MAX];
    struct dg_text text = dg_text_in(line, sizeof line);

    dg_text_add_hex(&text, range.first, 4);
    if (range.count > 1) {
        dg_text_add(&text, "-");
        dg_text_add_hex(&text, range.first + range.count - 1u, 4);
    }
    pad_to(&text, 11);
    dg_text_add(&text, access);
    pad_to(&text, 15);
    dg_text_add(&text, what);
    to->line(to->ctx, line);
}

static void describe_device(const struct listener *to, size_t number,
                            const struct dg_ib_model *model, uint16_t word)
{
    const uint16_t words = dg_ib_image_words(model);
    const uint16_t first = (uint16_t)(DEVICES + DEVICE_REGISTERS * number);
    char line[DESCRIPTION_MAX];
    struct dg_text text = dg_text_in(line, sizeof line);

    dg_text_add(&text, "Device ");
    dg_text_add_number(&text, (int64_t)number);
    dg_text_add(&text, ": K");
    dg_text_add_number(&text, (int64_t)model->profile + 1);
    dg_text_add(&text, ", ID word ");
    dg_text_add_hex(&text, dg_ib_id_word(model), 4);
    dg_text_add(&text, "h");
    to->line(to->ctx, "");
    to->line(to->ctx, line);
    describe_registers(to, (struct dg_ib_registers){word, words}, "r", "IN");
    if (model->profile == DG_IB_K3) {
        const struct dg_ib_registers out = {(uint16_t)(OUTPUT_IMAGE + word), words};
        describe_registers(to, out, "rw", "OUT");
    }
    for (size_t i = 0; i < DG_COUNT(device_rows); i++) {
        const uint16_t at = device_rows[i].at;
        const bool pair = (at >= 2 && at < 6) || at >= 8;
        const struct dg_ib_registers range = {(uint16_t)(first + at), pair ? 2 : 1};
        describe_registers(to, range, "r", device_rows[i].what);
    }
}

void dg_ib_coupler_describe(const struct dg_ib_model *const *models, size_t count,
                            void (*line)(void *ctx, const char *text), void *ctx)
{
    const struct listener to = {line, ctx};
    uint16_t words = 0;

    for (size_t i = 0; i < count; i++) {
        words = (uint16_t)(words + dg_ib_image_words(models[i]));
    }
    line(ctx, "Modbus registers, addresses from 0 in hex. Read: functions 3, 4, 23; "
              "write: 6, 16, 23.");
    line(ctx, "");
    for (size_t i = 0; i < ROWS; i++) {
        const uint16_t n = rows[i].size == IMAGE ? words : rows[i].count;
        if (rows[i].size != PER_DEVICE) {
            describe_registers(&to, (struct dg_ib_registers){rows[i].first, n},
                               rows[i].write == NULL ? "r" : "rw", rows[i].what);
        }
    }
    words = 0;
    for (size_t i = 0; i < count; i++) {
        describe_device(&to, i, models[i], words);
        words = (uint16_t)(words + dg_ib_image_words(models[i]));
    }
}
