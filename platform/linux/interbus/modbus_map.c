/* SPDX-License-Identifier: MIT */
/* One row for each block of registers: reading, writing, checking and the printed map use it. */
#include "modbus_map.h"

#include <stddef.h>
#include <string.h>

#include "drehgeber/drehgeber.h"

#define OUTPUT_IMAGE 0x0800u
#define DEVICES 0x2000u
#define DEVICE_REGISTERS 16u
#define RESET_FIRST 0xBECFu
#define RESET_SECOND 0xAFFEu
#define TEXT_REGISTERS 10u
#define ID_MESSAGES 0xE000u

/* Sizes that depend on the ring. */
enum size { FIXED, IMAGE, PER_DEVICE };

struct row {
    uint16_t first;
    uint16_t count; /* when FIXED */
    enum size size;
    uint16_t (*read)(const struct lx_map *self, uint16_t index);        /* NULL: `member` */
    void (*write)(struct lx_map *self, uint16_t index, uint16_t value); /* NULL: into `member` */
    uint16_t most; /* that may be written; 0: read only */
    size_t member; /* an uint16_t of struct lx_map; 0: none */
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

static uint16_t read_input(const struct lx_map *self, uint16_t index)
{
    return self->ring->in[index];
}

static uint16_t read_output(const struct lx_map *self, uint16_t index)
{
    return self->ring->out[index];
}

static void write_output(struct lx_map *self, uint16_t index, uint16_t value)
{
    struct lx_watchdog *watchdog = &self->watchdog;
    self->ring->out[index] = value;
    self->ring->stopped = false;
    watchdog->armed = true;
    watchdog->fired = false;
    watchdog->fed = self->now;
}

static uint16_t read_text(const struct lx_map *self, uint16_t index)
{
    char text[2u * TEXT_REGISTERS + 1u] = "";
    (void)self;
    (void)snprintf(text, sizeof text, "drehgeber IB %s", dg_version());
    return dg_load_be16((const uint8_t *)text + (size_t)2u * index);
}

/* The ring that was found is not the one that is expected. */
static bool mismatch(const struct lx_ring *ring)
{
    for (uint16_t i = 0; i < ring->is->reached; i++) {
        if ((dg_ring_id_word(ring->bus, i) & ~ID_MESSAGES) !=
            dg_ib_id_word(lx_ring_model(ring, i))) {
            return true;
        }
    }
    return ring->is->reached < ring->count;
}

static bool has_module_error(const struct lx_ring *ring)
{
    for (size_t i = 0; i < ring->count; i++) {
        if (dg_ib_module_error(lx_ring_device(ring, i))) {
            return true;
        }
    }
    return false;
}

static uint16_t read_status(const struct lx_map *self, uint16_t index)
{
    const struct lx_ring *ring = self->ring;
    const bool whole = ring->is->result == DG_RING_OK;
    (void)index;
    return (uint16_t)((whole && !ring->stopped ? 1u : 0u) | (whole ? 0u : 2u) |
                      (has_module_error(ring) ? 4u : 0u) | (mismatch(ring) ? 8u : 0u));
}

static uint16_t read_image_bits(const struct lx_map *self, uint16_t index)
{
    (void)index;
    return (uint16_t)(16u * self->ring->is->words);
}

static uint16_t read_zero(const struct lx_map *self, uint16_t index)
{
    (void)self;
    (void)index;
    return 0;
}

static uint16_t read_missed(const struct lx_map *self, uint16_t index)
{
    return half(self->missed, index);
}

static uint16_t read_watchdog_left(const struct lx_map *self, uint16_t index)
{
    const struct lx_watchdog *watchdog = &self->watchdog;
    const dg_ns time = DG_MS(watchdog->time_ms);
    const dg_ns passed = dg_elapsed(self->now, watchdog->fed);
    (void)index;
    if (!watchdog->armed || watchdog->fired || passed >= time) {
        return 0;
    }
    return (uint16_t)((time - passed) / DG_MS(1));
}

static void write_watchdog_time(struct lx_map *self, uint16_t index, uint16_t value)
{
    (void)index;
    self->watchdog.time_ms = value;
    self->watchdog.fed = self->now;
}

static uint16_t read_watchdog_fired(const struct lx_map *self, uint16_t index)
{
    (void)index;
    return self->watchdog.fired ? 1 : 0;
}

static void write_watchdog_reset(struct lx_map *self, uint16_t index, uint16_t value)
{
    struct lx_watchdog *watchdog = &self->watchdog;
    (void)index;
    if (watchdog->key == RESET_FIRST && value == RESET_SECOND && watchdog->fired) {
        watchdog->fired = false;
        watchdog->armed = false; /* until the next write to the output image */
        self->ring->stopped = false;
    }
    watchdog->key = value;
}

static uint16_t state_bits(const struct dg_ib *device, dg_ns now)
{
    const bool error = device->answer >> 29 == 4;
    return (uint16_t)((device->powered ? 1u : 0u) | (now < device->ready_at ? 2u : 0u) |
                      (device->answer != 0 && !error ? 4u : 0u) | (error ? 8u : 0u) |
                      (device->item != 0 ? 16u : 0u) | (device->preset_flag ? 32u : 0u) |
                      (device->lost != 0 ? 64u : 0u) | (device->invalid ? 128u : 0u));
}

static uint16_t read_device(const struct lx_map *self, uint16_t index)
{
    const uint16_t number = (uint16_t)(index / DEVICE_REGISTERS);
    const struct lx_ring *ring = self->ring;
    const struct dg_ib *device = lx_ring_device(ring, number);
    const unsigned id = number < ring->is->reached ? dg_ring_id_word(ring->bus, number) : 0;
    const uint16_t registers[DEVICE_REGISTERS] = {
        [0] = (uint16_t)(id & ~ID_MESSAGES),     [1] = state_bits(device, self->now),
        [2] = high(device->counters.cycles),     [3] = (uint16_t)device->counters.cycles,
        [4] = high(device->counters.crc_errors), [5] = (uint16_t)device->counters.crc_errors,
        [6] = dg_ib_leds(device, self->now),     [7] = device->mode,
        [8] = high(device->last_command),        [9] = (uint16_t)device->last_command,
        [10] = high(device->last_error),         [11] = (uint16_t)device->last_error,
    };
    return registers[index % DEVICE_REGISTERS];
}

#define MEMBER(name) offsetof(struct lx_map, watchdog.name)

/* clang-format off */
static const struct row rows[] = {
    {0x0000,       0,              IMAGE,      read_input,          NULL,                 0,      0,                "input image (IN), words in ring order, high word first"},
    {OUTPUT_IMAGE, 0,              IMAGE,      read_output,         write_output,         0xFFFF, 0,                "output image (OUT); the two words of a device in one request"},
    {0x1000,       TEXT_REGISTERS, FIXED,      read_text,           NULL,                 0,      0,                "identification, 2 characters in each"},
    {0x100C,       1,              FIXED,      read_status,         NULL,                 0,      0,                "coupler status: b0 run, b1 bus error, b2 module error, b3 ID mismatch"},
    {0x1010,       1,              FIXED,      read_image_bits,     NULL,                 0,      0,                "output image, bits"},
    {0x1011,       1,              FIXED,      read_image_bits,     NULL,                 0,      0,                "input image, bits"},
    {0x1012,       2,              FIXED,      read_zero,           NULL,                 0,      0,                "digital output and input image, bits: none"},
    {0x1014,       2,              FIXED,      read_missed,         NULL,                 0,      0,                "missed cycles, high word first"},
    {0x1020,       1,              FIXED,      read_watchdog_left,  NULL,                 0,      0,                "watchdog: ms left"},
    {0x1120,       1,              FIXED,      NULL,                write_watchdog_time,  0xFFFF, MEMBER(time_ms),  "watchdog: time in ms, 0: off"},
    {0x1121,       1,              FIXED,      read_watchdog_fired, write_watchdog_reset, 0xFFFF, 0,                "watchdog: 1: has fired; write BECFh, then AFFEh, to reset"},
    {0x1122,       1,              FIXED,      NULL,                NULL,                 1,      MEMBER(type),     "watchdog: fed by 1: every request, 0: writes of OUT"},
    {0x1123,       1,              FIXED,      NULL,                NULL,                 LX_FALLBACK_COUNT - 1, MEMBER(fallback), "fallback: 0 OUT is zero, 1 OUT freezes, 2 the ring stops"},
    {DEVICES,      0,              PER_DEVICE, read_device,         NULL,                 0,      0,                NULL},
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

static uint32_t count_of(const struct lx_map *self, const struct row *row)
{
    const struct lx_ring *ring = self->ring;
    switch (row->size) {
    case FIXED:
        return row->count;
    case IMAGE:
        return ring->is->words;
    case PER_DEVICE:
        return DEVICE_REGISTERS * (uint32_t)ring->count;
    }
    return 0;
}

static const struct row *map_row_of(const struct lx_map *self, uint32_t address)
{
    for (size_t i = 0; i < ROWS; i++) {
        if (address >= rows[i].first && address - rows[i].first < count_of(self, &rows[i])) {
            return &rows[i];
        }
    }
    return NULL;
}

/* Whether `boundary` is between the two words of a device. */
static bool splits(const struct lx_map *self, uint32_t boundary)
{
    const struct lx_ring *ring = self->ring;
    uint32_t at = OUTPUT_IMAGE;
    for (size_t i = 0; i < ring->count && at < boundary; i++) {
        at += dg_ib_image_words(lx_ring_model(ring, i));
    }
    return boundary > OUTPUT_IMAGE && boundary < at;
}

void lx_map_init(struct lx_map *self, struct lx_ring *ring)
{
    *self = (struct lx_map){.ring = ring, .watchdog = {.type = 1}};
}

bool lx_map_readable(const struct lx_map *self, struct lx_range range)
{
    for (uint32_t i = 0; i < range.count; i++) {
        if (map_row_of(self, range.first + i) == NULL) {
            return false;
        }
    }
    return true;
}

bool lx_map_writable(const struct lx_map *self, struct lx_range range)
{
    for (uint32_t i = 0; i < range.count; i++) {
        const struct row *row = map_row_of(self, range.first + i);
        if (row == NULL || row->most == 0) {
            return false;
        }
    }
    const uint32_t end = (uint32_t)range.first + range.count;
    return self->tear || (!splits(self, range.first) && !splits(self, end));
}

static uint16_t read_register(const struct lx_map *self, const struct row *row, uint16_t index)
{
    uint16_t value = 0;
    if (row->read != NULL) {
        return row->read(self, index);
    }
    memcpy(&value, (const uint8_t *)self + row->member, sizeof value);
    return value;
}

static void write_modbus_register(struct lx_map *self, const struct row *row, uint16_t index,
                                  uint16_t value)
{
    if (row->write != NULL) {
        row->write(self, index, value);
    } else {
        memcpy((uint8_t *)self + row->member, &value, sizeof value);
    }
}

void lx_map_read(const struct lx_map *self, struct lx_range range, uint16_t *to)
{
    for (uint32_t i = 0; i < range.count; i++) {
        const struct row *row = map_row_of(self, range.first + i);
        to[i] = read_register(self, row, (uint16_t)(range.first + i - row->first));
    }
}

bool lx_map_write(struct lx_map *self, struct lx_range range, const uint16_t *values)
{
    for (uint32_t i = 0; i < range.count; i++) {
        if (values[i] > map_row_of(self, range.first + i)->most) {
            return false;
        }
    }
    for (uint32_t i = 0; i < range.count; i++) {
        const struct row *row = map_row_of(self, range.first + i);
        write_modbus_register(self, row, (uint16_t)(range.first + i - row->first), values[i]);
    }
    return true;
}

void lx_map_request(struct lx_map *self, dg_ns now)
{
    self->now = now;
    if (self->watchdog.type == 1 && !self->watchdog.fired) {
        self->watchdog.fed = now;
    }
}

static bool watches(const struct lx_watchdog *watchdog)
{
    return watchdog->armed && !watchdog->fired && watchdog->time_ms != 0;
}

dg_ns lx_map_quiet(const struct lx_map *self)
{
    const struct lx_watchdog *watchdog = &self->watchdog;
    return watches(watchdog) ? dg_after(watchdog->fed, DG_MS(watchdog->time_ms) + 1u) : DG_NEVER;
}

void lx_map_tick(struct lx_map *self, dg_ns now)
{
    struct lx_watchdog *watchdog = &self->watchdog;
    if (!watches(watchdog) || dg_elapsed(now, watchdog->fed) <= DG_MS(watchdog->time_ms)) {
        return;
    }
    watchdog->fired = true;
    if (watchdog->fallback == LX_FALLBACK_ZERO) {
        memset(self->ring->out, 0, sizeof self->ring->out);
    }
    self->ring->stopped = watchdog->fallback == LX_FALLBACK_STOP;
}

static void print_row(FILE *to, unsigned first, unsigned count, const char *access,
                      const char *what)
{
    char range[16];
    (void)snprintf(range, sizeof range, count > 1 ? "%04X-%04X" : "%04X", first,
                   first + count - 1u);
    (void)fprintf(to, "%-10s %-3s %s\n", range, access, what);
}

static void print_device(FILE *to, size_t number, const struct dg_ib_model *model, uint16_t word)
{
    const unsigned words = dg_ib_image_words(model);
    const unsigned first = DEVICES + DEVICE_REGISTERS * (unsigned)number;
    (void)fprintf(to, "\nDevice %lu: K%d, ID word %04Xh\n", (unsigned long)number,
                  (int)model->profile + 1, dg_ib_id_word(model));
    print_row(to, word, words, "r", "IN");
    if (model->profile == DG_IB_K3) {
        print_row(to, OUTPUT_IMAGE + word, words, "rw", "OUT");
    }
    const size_t count = DG_COUNT(device_rows);
    for (size_t i = 0; i < count; i++) {
        const unsigned at = device_rows[i].at;
        const bool pair = (at >= 2 && at < 6) || at >= 8;
        print_row(to, first + at, pair ? 2 : 1, "r", device_rows[i].what);
    }
}

void lx_map_print(const struct dg_ib_model *const *models, size_t count, FILE *to)
{
    uint16_t words = 0;
    for (size_t i = 0; i < count; i++) {
        words = (uint16_t)(words + dg_ib_image_words(models[i]));
    }
    (void)fprintf(to, "Modbus registers, addresses from 0 in hex. Read: functions 3, 4, 23; "
                      "write: 6, 16, 23.\n\n");
    for (size_t i = 0; i < ROWS; i++) {
        if (rows[i].size != PER_DEVICE) {
            print_row(to, rows[i].first, rows[i].size == IMAGE ? words : rows[i].count,
                      rows[i].most == 0 ? "r" : "rw", rows[i].what);
        }
    }
    words = 0;
    for (size_t i = 0; i < count; i++) {
        print_device(to, i, models[i], words);
        words = (uint16_t)(words + dg_ib_image_words(models[i]));
    }
}
