/* SPDX-License-Identifier: MIT */
/*
 * The encoder profile for any number of steps and turns:
 *
 *   6004h = (floor(raw * 6001h / steps) + offset) mod 6002h
 *
 * with scaling, else (raw + offset) mod (steps * turns). Of 6000h bits 0 and 2 count, the others
 * are kept for who reads them: they are the manufacturer's.
 */
#include <string.h>

#include "any.h"
#include "drehgeber/bits.h"

/* 6000h and 6031h:2 as they were written: what the F36x8's parts look at is SLOT_PARAMETERS and
 * SLOT_SPEED_WINDOW_MS. */
#define SLOT_WRITTEN SLOT_CUSTOMER
#define SLOT_WINDOW (SLOT_CUSTOMER + 1)
#define COUNTED ((uint32_t)DG_CIA406_CCW | (uint32_t)DG_CIA406_SCALING)
#define TURN_BITS 32u
#define WINDOW_MAX_MS 1000u

static const struct dg_cia406_file *any_file_of(const struct dg_co_node *node)
{
    return (const struct dg_cia406_file *)(const void *)node->setup.device;
}

/* ------------------------------------------------------------ position */

/* 1..2^32 */
static uint64_t range_of(const struct dg_co_node *node)
{
    return (uint64_t)any_file_of(node)->steps * any_file_of(node)->turns;
}

/* Whole turns and what is left of the last one, each by itself: no product leaves 64 bits. */
static uint32_t raw_at(const struct dg_co_node *node)
{
    const struct dg_cia406_file *file = any_file_of(node);
    const dg_angle angle = dg_world_angle(node->setup.world, node->now);
    const int64_t turns = file->turns;
    const int64_t turn = angle >> TURN_BITS;
    const uint64_t inside = (uint64_t)(turn % turns + turns) % file->turns;
    const uint64_t part = (uint64_t)(angle & (int64_t)UINT32_MAX);

    return (uint32_t)(inside * file->steps + (part * file->steps >> TURN_BITS));
}

/* Ascending as the code sequence says. */
static uint64_t in_sequence(const struct dg_co_node *node)
{
    const uint64_t raw = encoder_of(node)->raw;

    return parameter(node, DG_CIA406_CCW) && raw != 0 ? range_of(node) - raw : raw;
}

/* 6002h, if it is in force; 0 is the physical range. */
uint64_t dg_cia406_any_range(const struct dg_co_node *node)
{
    const uint32_t range = node->value[SLOT_TMR];

    return parameter(node, DG_CIA406_SCALING) && range != 0 ? range : range_of(node);
}

/* Before the preset. */
static uint64_t scale_sample(const struct dg_co_node *node)
{
    const uint32_t steps = any_file_of(node)->steps;
    const uint32_t wanted = node->value[SLOT_MUR];
    const bool counts = parameter(node, DG_CIA406_SCALING) && wanted != 0;
    const uint64_t raw = in_sequence(node);

    return (counts ? raw / steps * wanted + raw % steps * wanted / steps : raw) %
           dg_cia406_any_range(node);
}

static void sample(struct dg_co_node *node)
{
    encoder_of(node)->raw = raw_at(node);
    node->value[SLOT_POSITION] =
        (uint32_t)((scale_sample(node) + node->value[SLOT_OFFSET]) % dg_cia406_any_range(node));
}

static void use_parameters(struct dg_co_node *node)
{
    const uint32_t window_ms = node->value[SLOT_WINDOW];

    node->value[SLOT_PARAMETERS] = node->value[SLOT_WRITTEN] & COUNTED;
    node->value[SLOT_SPEED_WINDOW_MS] = window_ms != 0 ? window_ms : 1u;
    node->value[SLOT_OFFSET] = (uint32_t)(node->value[SLOT_OFFSET] % dg_cia406_any_range(node));
}

/* 6000h, 6001h, 6002h */
static enum dg_co_abort hook_scaling(struct dg_co_node *node, const struct dg_co_object *object,
                                     enum dg_co_op op, uint32_t *value)
{
    (void)object;
    (void)value;
    if (op == DG_CO_WRITTEN) {
        use_parameters(node);
    }
    return DG_CO_OK;
}

/* 6003h: the position becomes the preset at once. */
static enum dg_co_abort hook_preset(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    const uint64_t range = dg_cia406_any_range(node);

    (void)object;
    if (op != DG_CO_WRITE) {
        return DG_CO_OK;
    }
    if (*value >= range) {
        return DG_CO_RANGE;
    }
    encoder_of(node)->raw = raw_at(node);
    node->value[SLOT_OFFSET] = (uint32_t)((*value + range - scale_sample(node)) % range);
    return DG_CO_OK;
}

/* 6509h: preset minus scaled position, with its sign. */
static enum dg_co_abort hook_offset(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    const uint64_t range = dg_cia406_any_range(node);
    const uint32_t preset = node->value[SLOT_PRESET];

    (void)object;
    if (op == DG_CO_READ) {
        *value = preset - (uint32_t)((preset % range + range - *value % range) % range);
    }
    return DG_CO_OK;
}

/* ------------------------------------------------------------ the rest of it */

/* 6030h: steps/s in 32 bits, rpm in 16, where steps/s would not fit. */
static enum dg_co_abort hook_speed(struct dg_co_node *node, const struct dg_co_object *object,
                                   enum dg_co_op op, uint32_t *value)
{
    const uint32_t window_ms = node->value[SLOT_SPEED_WINDOW_MS];
    const dg_ns before = dg_elapsed(node->now, DG_MS(window_ms));

    (void)op;
    if (object->row->flags >> 12 != DG_CO_I32) {
        *value = (uint32_t)dg_cia406_rpm(node);
        return DG_CO_OK;
    }
    const int64_t counts = dg_cia406_counts(node, node->now) - dg_cia406_counts(node, before);
    const int64_t most = INT64_C(1) << TURN_BITS;
    const int64_t moved = counts > most ? most : counts < -most ? -most : counts;
    const int64_t speed = moved * 1000 / (int64_t)window_ms; /* in 1/65536 turn a second */
    const int64_t steps = any_file_of(node)->steps;
    const int64_t a_second =
        speed / DG_CIA406_STEPS * steps + speed % DG_CIA406_STEPS * steps / DG_CIA406_STEPS;
    const int64_t signed_one = parameter(node, DG_CIA406_CCW) ? -a_second : a_second;
    *value = (uint32_t)(signed_one > INT32_MAX   ? INT32_MAX
                        : signed_one < INT32_MIN ? INT32_MIN
                                                 : signed_one);
    return DG_CO_OK;
}

/* 6031h:2 */
static enum dg_co_abort hook_window(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    (void)object;
    if (op == DG_CO_WRITTEN) {
        use_parameters(node);
    }
    return op == DG_CO_WRITE && (*value == 0 || *value > WINDOW_MAX_MS) ? DG_CO_RANGE : DG_CO_OK;
}

/* 6200h is 1800h:5 seen through another object. */
static enum dg_co_abort hook_timer(struct dg_co_node *node, const struct dg_co_object *object,
                                   enum dg_co_op op, uint32_t *value)
{
    (void)object;
    if (op == DG_CO_READ) {
        *value = node->value[dg_co_slot_event_timer];
    } else if (op == DG_CO_WRITE) {
        node->value[dg_co_slot_event_timer] = *value;
        dg_co_pdo_rearm(node, 0);
    }
    return DG_CO_OK;
}

/* 6008h: 6004h in 64 bits. */
static enum dg_co_abort hook_wide_position(struct dg_co_node *node,
                                           const struct dg_co_object *object, enum dg_co_op op,
                                           uint32_t *value)
{
    (void)object;
    (void)op;
    value[0] = node->value[SLOT_POSITION];
    value[1] = 0;
    return DG_CO_OK;
}

/* 6009h is 6003h in 64 bits. */
static enum dg_co_abort hook_wide_preset(struct dg_co_node *node, const struct dg_co_object *object,
                                         enum dg_co_op op, uint32_t *value)
{
    if (op != DG_CO_WRITE) {
        value[0] = node->value[SLOT_PRESET];
        value[1] = 0;
        return DG_CO_OK;
    }
    const enum dg_co_abort abort =
        value[1] == 0 ? hook_preset(node, object, op, value) : DG_CO_RANGE;
    if (abort == DG_CO_OK) {
        node->value[SLOT_PRESET] = value[0];
    }
    return abort;
}

static DG_CO_TELL(hook_status, node->value[SLOT_WRITTEN]) static DG_CO_TELL(hook_serial,
                                                                            node->serial)

    /* The F36x8's part comes first: what it samples is replaced. */
    static bool reset(struct dg_co_node *node, bool application)
{
    use_parameters(node);
    node->value[SLOT_CAMS] = 0;
    (void)dg_cia406_multiturn.reset(node, application);
    sample(node);
    return false;
}

/* ------------------------------------------------------------ the device */

/* Hooks by number, and the numbers. */
#define HOOKS(HOOK)                                                                                \
    HOOK(hook_scaling)                                                                             \
    HOOK(hook_preset)                                                                              \
    HOOK(hook_wide_position)                                                                       \
    HOOK(hook_wide_preset)                                                                         \
    HOOK(hook_speed)                                                                               \
    HOOK(hook_window)                                                                              \
    HOOK(dg_cia406_hook_acceleration)                                                              \
    HOOK(hook_timer)                                                                               \
    HOOK(dg_cia406_hook_channel)                                                                   \
    HOOK(dg_cia406_hook_cams)                                                                      \
    HOOK(hook_status)                                                                              \
    HOOK(dg_cia406_hook_health)                                                                    \
    HOOK(dg_cia406_hook_time)                                                                      \
    HOOK(hook_offset)                                                                              \
    HOOK(hook_serial)
#define POINTER(hook) hook,
#define NUMBER(hook) NUMBER_##hook,

static dg_co_hook *const hooks[] = {NULL, HOOKS(POINTER)};
enum { NUMBER_NULL, HOOKS(NUMBER) };

enum { DG_CO_SHORT_FLAGS };
#define OBJECT(index, sub, more, type, access, slot, initial, hook)                                \
    DG_CO_ROW(index, sub, more, DG_CO_##type, access, slot, initial, 0, NUMBER_##hook)

/* What is set of cams and work areas is a cell of the file, in a channel each. */
#define CHANNEL(index, type, initial) OBJECT(index, 1, CHANNELS - 1u, type, R | W, 0, initial, NULL)
#define EIGHT_CAMS(index, type)                                                                    \
    CHANNEL(index, type, 0), CHANNEL((index) + 1, type, 0), CHANNEL((index) + 2, type, 0),         \
        CHANNEL((index) + 3, type, 0), CHANNEL((index) + 4, type, 0),                              \
        CHANNEL((index) + 5, type, 0), CHANNEL((index) + 6, type, 0),                              \
        CHANNEL((index) + 7, type, 0)

/* Rows that nobody may read or write are for values that something counts on. */
/* clang-format off */
static const struct dg_co_row rows[] = {
    OBJECT(0x2120, 2, 0, U8,  S|V,       SLOT_TEMPERATURE_LOW, 0x00, NULL),
    OBJECT(0x2120, 3, 0, U8,  S|V,       SLOT_TEMPERATURE_HIGH, 0xFF, NULL),
    OBJECT(0x6000, 0, 0, U16, R|W|S|V,   SLOT_WRITTEN, 0, hook_scaling),
    OBJECT(0x6001, 0, 0, U32, R|W|S|V,   SLOT_MUR, 0, hook_scaling),
    OBJECT(0x6002, 0, 0, U32, R|W|S|V,   SLOT_TMR, 0, hook_scaling),
    OBJECT(0x6003, 0, 0, U32, R|W|S|V,   SLOT_PRESET, 0, hook_preset),
    OBJECT(0x6004, 0, 0, U32, R|E|V,     SLOT_POSITION, 0, NULL),
    OBJECT(0x6008, 0, 0, WIDE, R|E,      0, 0, hook_wide_position),
    OBJECT(0x6009, 0, 0, WIDE, R|W,      0, 0, hook_wide_preset),
    OBJECT(0x6030, 1, 0, I16, R,         0, 0, hook_speed),
    OBJECT(0x6031, 1, 0, U16, R|W|S|V,   SLOT_SPEED_SOURCE, 2, NULL),
    OBJECT(0x6031, 2, 0, U16, R|W|S|V,   SLOT_WINDOW, 100, hook_window),
    OBJECT(0x6031, 3, 0, U16, R|W|S|V,   SLOT_SPEED_MULTIPLIER, 1, NULL),
    OBJECT(0x6031, 4, 0, U16, R|W|S|V,   SLOT_SPEED_DIVISOR, 1, NULL),
    OBJECT(0x6040, 1, 0, I16, R,         0, 0, dg_cia406_hook_acceleration),
    OBJECT(0x6200, 0, 0, U16, R|W,       0, 0, hook_timer),
    OBJECT(0x6300, 1, CHANNELS - 1u, U8, R, 0, 0, dg_cia406_hook_cams),
    CHANNEL(0x6301, U8, 0),
    CHANNEL(0x6302, U8, 0),
    EIGHT_CAMS(0x6310, U32),
    EIGHT_CAMS(0x6320, U32),
    EIGHT_CAMS(0x6330, U16),
    OBJECT(0x6400, 1, CHANNELS - 1u, U8, R, 0, 0, dg_cia406_hook_channel),
    CHANNEL(0x6401, U32, 0),
    CHANNEL(0x6402, U32, 0xFFFFFFFF),
    OBJECT(0x6500, 0, 0, U16, R,         0, 0, hook_status),
    OBJECT(0x6503, 0, 0, U16, R,         0, 0, dg_cia406_hook_health),
    OBJECT(0x6505, 0, 0, U16, R,         0, 0, dg_cia406_hook_health),
    OBJECT(0x6508, 0, 0, U32, R,         0, 0, dg_cia406_hook_time),
    OBJECT(0x6509, 0, 0, I32, R|S|V,     SLOT_OFFSET, 0, hook_offset),
    OBJECT(0x650B, 0, 0, U32, R,         0, 0, hook_serial),
};
/* clang-format on */
#define PROFILE_SIZE 28u

static void default_bus(const void *ctx, uint8_t *out)
{
    static const uint8_t bus[3] = {5, DG_CO_UNCONFIGURED, 0};

    (void)ctx;
    memcpy(out, bus, sizeof bus);
}

static const struct dg_store_region regions[REGION_COUNT] = {
    DG_CO_STORE_REGIONS(default_bus),
    [REGION_PROFILE] = {"profile", PROFILE_SIZE, DG_STORE_CHECKED, 0, NULL},
    [REGION_USF] = {"usf", 21, DG_STORE_CHECKED, 0, dg_cia406_default_usf},
    [REGION_TIME] = {"time", 4, DG_STORE_CHECKED, 0, dg_cia406_default_time},
};

static const struct dg_store_layout layout = {
    .id = 0x434F3100u,
    .journal_size = DG_CO_JOURNAL_SIZE + 6u + PROFILE_SIZE + 6u + DG_STORE_CHECKED_MAX,
    .region_count = REGION_COUNT,
    .regions = regions,
};

const struct dg_co_device dg_cia406_any = {
    .dictionary = {DG_CO_ROWS(rows), NULL, hooks},
    .save_ms = 14,
    .layout = &layout,
    .reset = reset,
    .sample = sample,
    .step = dg_cia406_step_node,
};
