/* SPDX-License-Identifier: MIT */
/*
 * The F36x8 devices: their dictionaries, causes, EEPROM, and what happens at reset and in time.
 */
#include "cia406_private.h"

#include <string.h>

#include "drehgeber/bits.h"

#define EVENT_MS 1u
#define LOOK_MS 100u
#define PASSWORD_DELAY_MS 1000u

dg_ns dg_cia406_in_ms(const struct dg_co_node *node, uint32_t ms)
{
    return dg_after(node->now, DG_MS(ms));
}

/* 6200h is 1800h:5 seen through another object (C5). */
static enum dg_co_abort hook_cyclic_timer(struct dg_co_node *node,
                                          const struct dg_co_object *object, enum dg_co_op op,
                                          uint32_t *value)
{
    (void)object;
    if (op == DG_CO_READ) {
        *value = node->value[dg_co_slot_event_timer];
    } else {
        node->value[dg_co_slot_event_timer] = *value;
        dg_co_pdo_rearm(node, 0);
    }
    return DG_CO_OK;
}

/* 2100h has no rate 7 (chapter 8). */
static enum dg_co_abort hook_bit_rate(struct dg_co_node *node, const struct dg_co_object *object,
                                      enum dg_co_op op, uint32_t *value)
{
    (void)node;
    (void)object;
    return op == DG_CO_WRITE && *value == 7 ? DG_CO_RANGE : DG_CO_OK;
}

/* 6031h:2 knows four windows (chapter 13, C18). */
static enum dg_co_abort hook_window(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    bool known = *value == 1 || *value == 10 || *value == 100 || *value == 200;

    (void)node;
    (void)object;
    return op == DG_CO_WRITE && !known ? DG_CO_RANGE : DG_CO_OK;
}

/* 6500h shows 6000h. */
static enum dg_co_abort hook_status(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    (void)object;
    (void)op;
    *value = node->value[SLOT_PARAMETERS];
    return DG_CO_OK;
}

/* 300Ah opens 300Bh; every wrong password makes the next attempt wait longer (C25). */
static enum dg_co_abort hook_password(struct dg_co_node *node, const struct dg_co_object *object,
                                      enum dg_co_op op, uint32_t *value)
{
    struct dg_cia406 *self = encoder_of(node);

    (void)object;
    (void)op; /* write-only, and not kept */
    self->serial_open = node->now >= self->locked_until && *value == self->model->password;
    if (self->serial_open) {
        self->wrong_count = 0;
        return DG_CO_OK;
    }
    self->locked_until = dg_cia406_in_ms(node, PASSWORD_DELAY_MS << self->wrong_count);
    if (self->wrong_count < PASSWORD_DELAYS_MAX) {
        self->wrong_count++;
    }
    return DG_CO_STORE;
}

/* 300Bh, 650Bh: the serial number, which 1018h:4 shows, too. */
static enum dg_co_abort hook_serial(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    struct dg_cia406 *self = encoder_of(node);
    uint8_t bytes[4];

    (void)object;
    if (op != DG_CO_WRITE) {
        *value = node->serial;
        return DG_CO_OK;
    }
    if (!self->serial_open) {
        return DG_CO_STATE;
    }
    dg_store_le32(bytes, *value);
    if (!node->mounted || !node->setup.world->eeprom_acknowledges ||
        dg_store_put(&node->store, DG_CO_REGION_SERIAL, 0, bytes, sizeof bytes) != DG_OK) {
        return DG_CO_HARDWARE;
    }
    self->serial_open = false;
    node->serial = *value;
    return DG_CO_OK;
}

static bool reset(struct dg_co_node *node, bool application)
{
    struct dg_cia406 *self = encoder_of(node);

    if (application) {
        self->serial_open = false;
        self->flash_until = 0;
        dg_cia406_restore_zero(node);
        dg_cia406_health_start(node);
    }
    dg_cia406_sample(node);
    return parameter(node, DG_CIA406_OPERATIONAL);
}

/* With USF the zero has to be looked after before the shaft can go a quarter of the range at 250
 * turns/s. */
static uint32_t look_ms(const struct dg_co_node *node)
{
    uint32_t turns = encoder_of(node)->model->turns;

    return parameter(node, DG_CIA406_USF) && turns < LOOK_MS ? turns : LOOK_MS;
}

/* Those that were left out keep their pace. One at this moment came before what has woken it, but
 * for the operating time. */
static void find_next_look(struct dg_co_node *node)
{
    struct dg_cia406 *self = encoder_of(node);
    const uint32_t ms = look_ms(node);
    const dg_ns over = dg_elapsed(node->now, dg_cia406_health_next(self) <= node->now ? 1u : 0u);

    if (self->look_at <= over) {
        const dg_ns span = dg_divide_ns(over - self->look_at, 20000);
        const dg_ns looks = dg_divide_ns(span, (uint16_t)(50u * ms)) + 1u;
        self->look_at = dg_after(self->look_at, looks * DG_MS(ms));
    }
}

/* Whether the next looks can find no other speed: the shaft stays slower than the speed at which a
 * warning ends, and no warning lasts. With USF the zero follows a shaft that turns, so it has to
 * stand. */
static bool is_calm(const struct dg_co_node *node)
{
    const enum dg_calm calm = dg_world_calm(node->setup.world, node->now);
    const bool slow = calm == DG_CALM_SLOW && !parameter(node, DG_CIA406_USF);

    return (calm == DG_CALM_STANDS || slow) && (node->active_causes >> CAUSE_SPEED & 1u) == 0;
}

/* When the shaft has been calm for as long as a speed is measured over (6031h:2), with nothing in
 * between, the next looks would see the same. Whatever happens wakes it: one that is called looks
 * again. */
static dg_ns look_around(struct dg_co_node *node)
{
    struct dg_cia406 *self = encoder_of(node);
    const uint32_t ms = look_ms(node);
    uint32_t calm_ms = self->calm_ms;

    if (calm_ms == DG_CIA406_ASLEEP) {
        find_next_look(node);
        calm_ms = 0;
    }
    self->calm_ms = 0;
    if (self->look_at <= node->now) {
        self->look_at = dg_cia406_in_ms(node, ms);
        dg_cia406_watch_zero(node);
        dg_cia406_health_look(node);
        if (is_calm(node)) {
            calm_ms += ms;
            self->calm_ms =
                calm_ms < node->value[SLOT_SPEED_WINDOW_MS] ? (uint16_t)calm_ms : DG_CIA406_ASLEEP;
        }
    }
    return self->calm_ms == DG_CIA406_ASLEEP ? dg_cia406_health_next(self) : self->look_at;
}

dg_ns dg_cia406_step_node(struct dg_co_node *node)
{
    struct dg_cia406 *self = encoder_of(node);
    const dg_ns look_at = look_around(node);

    if (!parameter(node, DG_CIA406_EVENT_MODE) || node->state != DG_CO_OPERATIONAL) {
        return look_at;
    }
    if (self->event_at <= node->now) {
        self->event_at = dg_cia406_in_ms(node, EVENT_MS);
        dg_co_pdo_event(node);
    }
    return dg_earliest(look_at, self->event_at);
}

/* Hooks by number, and the numbers. */
#define HOOKS(HOOK)                                                                                \
    HOOK(hook_bit_rate)                                                                            \
    HOOK(dg_co_hook_save_bus)                                                                      \
    HOOK(dg_cia406_hook_sensor)                                                                    \
    HOOK(dg_cia406_hook_battery)                                                                   \
    HOOK(dg_cia406_hook_raw)                                                                       \
    HOOK(hook_password)                                                                            \
    HOOK(hook_serial)                                                                              \
    HOOK(dg_cia406_hook_scaling)                                                                   \
    HOOK(dg_cia406_hook_preset)                                                                    \
    HOOK(dg_cia406_hook_speed)                                                                     \
    HOOK(hook_window)                                                                              \
    HOOK(dg_cia406_hook_acceleration)                                                              \
    HOOK(hook_cyclic_timer)                                                                        \
    HOOK(dg_cia406_hook_areas)                                                                     \
    HOOK(hook_status)                                                                              \
    HOOK(dg_cia406_hook_health)                                                                    \
    HOOK(dg_cia406_hook_time)                                                                      \
    HOOK(dg_cia406_hook_offset)
#define POINTER(hook) hook,
#define NUMBER(hook) NUMBER_##hook,

static dg_co_hook *const hooks[] = {NULL, HOOKS(POINTER)};
enum { NUMBER_NULL, HOOKS(NUMBER) };

/* Limits by number: those that objects.def names. Two differ between the models: `range` is the
 * physical range as 6002h says it, `last` the highest position. */
enum { FULL, TO_1, TO_8, NODE_ID, CELSIUS, RANGE, U16_FROM_1, TO_65536, TO_200, POSITION, LIMITS };
#define LIMITS_OF(range, last)                                                                     \
    {                                                                                              \
        [TO_1] = {0, 1}, [TO_8] = {0, 8}, [NODE_ID] = {1, 127}, [CELSIUS] = {0x20, 0xAC},          \
        [RANGE] = {1, (range)}, [U16_FROM_1] = {1, UINT16_MAX}, [TO_65536] = {1, 65536},           \
        [TO_200] = {1, 200}, [POSITION] = {0, (last)},                                             \
    }

/* The short names of objects.def. */
enum { DG_CO_SHORT_FLAGS };

#define DG_CO_PARENT(index, kind, name)
#define DG_CO_OBJECT(index, sub, more, type, access, slot, initial, limits, hook, name)            \
    DG_CO_ROW(index, sub, more, DG_CO_##type, access, slot, initial, limits, NUMBER_##hook),
#define DG_CO_MORE(index, sub, name)

static const struct dg_co_row rows[] = {
#include "objects.def"
};

/* As delivered, and what else differs between the models. Chapters 3, 4 and 10 (C2). */
/* clang-format off */
#define FIGURES(turn_bits, turns, range, last)                                                     \
    {                                                                                              \
        {DG_CO_KEY(0x1029, 2), 1},                                                                 \
        {DG_CO_KEY(0x1029, 3), 1},                                                                 \
        {DG_CO_KEY(0x1801, 2), 1},                                                                 \
        {DG_CO_KEY(0x1A00, 0), 1},                                                                 \
        {DG_CO_KEY(0x1A00, 1), 0x60040020},                                                        \
        {DG_CO_KEY(0x1A01, 0), 1},                                                                 \
        {DG_CO_KEY(0x1A01, 1), 0x60040020},                                                        \
        {DG_CO_KEY(0x1A02, 0), 1},                                                                 \
        {DG_CO_KEY(0x1A02, 1), 0x60300110},                                                        \
        {DG_CO_KEY(0x1A03, 0), 2},                                                                 \
        {DG_CO_KEY(0x1A03, 1), 0x21600020},                                                        \
        {DG_CO_KEY(0x1A03, 2), 0x21620010},                                                        \
        {DG_CO_KEY(0x2110, 2), (turn_bits)},                                                       \
        {DG_CO_KEY(0x6002, 0), (range)},                                                           \
        {DG_CO_KEY(0x6402, 1), (last)},                                                            \
        {DG_CO_KEY(0x6402, 2), (last)},                                                            \
        {DG_CO_KEY(0x6502, 0), (turns)},                                                           \
        {DG_CO_KEY(0x650A, 3), (last) & 0x7FFFFFFFu},                                              \
    }
/* clang-format on */
#define FIGURE_COUNT 18u
#define OF_MODEL(name, turn_bits, turns, range, last)                                              \
    static const struct dg_co_figure figures_##name[FIGURE_COUNT] =                                \
        FIGURES(turn_bits, turns, range, last);                                                    \
    static const struct dg_co_limits limits_##name[LIMITS] = LIMITS_OF(range, last)
OF_MODEL(singleturn, 0, 1, 0x10000u, 0xFFFFu);
OF_MODEL(multiturn, 12, 4096, 0x10000000u, 0x0FFFFFFFu);
/* 2^32 does not fit 6002h, nor 65536 6502h: their highest values stand for them. */
OF_MODEL(multiturn_32, 16, 0xFFFF, 0xFFFFFFFFu, 0xFFFFFFFFu);

/* By the number in 2100h (chapter 8); 7 is none. */
static const uint16_t kbaud[] = {10, 20, 50, 100, 125, 250, 500, 0, 1000};

/* Chapter 8: 250 kBd, node-ID 3Fh, terminated. */
static void default_bus(const void *ctx, uint8_t *out)
{
    static const uint8_t bus[3] = {5, 0x3F, 1};

    (void)ctx;
    memcpy(out, bus, sizeof bus);
}

void dg_cia406_default_usf(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memset(out, 0, 21);
}

void dg_cia406_default_time(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memset(out, 0, 4);
}

/* clang-format off */
const struct dg_co_cause dg_cia406_causes[DG_CIA406_CAUSES] = {
    [CAUSE_TEMPERATURE - DG_CO_CAUSES]   = {0x4200, 0x09, DG_CO_CLASS_DEVICE},
    [CAUSE_SPEED - DG_CO_CAUSES]         = {0x4200, 0x09, DG_CO_CLASS_DEVICE},
    [CAUSE_BATTERY_LOW - DG_CO_CAUSES]   = {0x3200, 0x01, DG_CO_CLASS_MANUFACTURER},
    [CAUSE_BATTERY_CABLE - DG_CO_CAUSES] = {0x3200, 0x05, DG_CO_CLASS_MANUFACTURER},
    [CAUSE_OPTICS - DG_CO_CAUSES]        = {0x5200, 0x01, DG_CO_CLASS_DEVICE},
    [CAUSE_POSITION - DG_CO_CAUSES]      = {0x1000, 0x01, DG_CO_CLASS_DEVICE},
    [CAUSE_HARDWARE - DG_CO_CAUSES]      = {0x1000, 0x01, DG_CO_CLASS_MANUFACTURER},
    [CAUSE_USF_MOVED - DG_CO_CAUSES]     = {0x6200, 0x01, DG_CO_CLASS_NONE},
    [CAUSE_USF_LOST - DG_CO_CAUSES]      = {0x6200, 0x01, DG_CO_CLASS_MANUFACTURER},
};

static const struct dg_store_region regions[REGION_COUNT] = {
    DG_CO_STORE_REGIONS(default_bus),
    [REGION_PROFILE] = {"profile", 60, DG_STORE_CHECKED, 0, NULL},
    [REGION_USF]     = {"usf",     21, DG_STORE_CHECKED, 0, dg_cia406_default_usf},
    [REGION_TIME]    = {"time",     4, DG_STORE_CHECKED, 0, dg_cia406_default_time},
};
/* clang-format on */

/* The id keeps one model's memory from being taken for another's. */
#define LAYOUT(number)                                                                             \
    {                                                                                              \
        .id = (number), .journal_size = DG_CO_JOURNAL_SIZE + 6u + 60u,                             \
        .region_count = REGION_COUNT, .regions = regions,                                          \
    }
static const struct dg_store_layout layout_singleturn = LAYOUT(0x434F3101u);
static const struct dg_store_layout layout_multiturn = LAYOUT(0x434F3102u);
static const struct dg_store_layout layout_multiturn_32 = LAYOUT(0x434F3103u);

static const char *const strings[] = {"F36x8 CANopen encoder", "1.00", "1.08"};

/* save_ms: chapter 12. */
#define F36X8(model)                                                                               \
    .dictionary = {DG_CO_ROWS(rows), limits_##model, hooks}, .figures = figures_##model,           \
    .figure_count = FIGURE_COUNT, .kbaud = kbaud, .kbaud_count = DG_COUNT(kbaud), .save_ms = 14,   \
    .causes = dg_cia406_causes, .cause_count = DG_CIA406_CAUSES, .strings = strings,               \
    .vendor_id = 0x13, .product_code = 0x56682001, .revision = 108, .reset = reset,                \
    .sample = dg_cia406_sample, .step = dg_cia406_step_node

const struct dg_co_device dg_cia406_singleturn = {
    F36X8(singleturn),
    .layout = &layout_singleturn,
    .name = "F3658",
    .device_type = 0x00010196,
};

const struct dg_co_device dg_cia406_multiturn = {
    F36X8(multiturn),
    .layout = &layout_multiturn,
    .name = "F3668",
    .device_type = 0x00020196,
};

const struct dg_co_device dg_cia406_multiturn_32 = {
    F36X8(multiturn_32),
    .layout = &layout_multiturn_32,
    .name = "F3668",
    .device_type = 0x00020196,
};

int dg_cia406_init(struct dg_cia406 *self, const struct dg_cia406_model *model)
{
    uint32_t turns = model->turns;

    if (model->device == NULL || turns == 0 || turns > 65536 || (turns & (turns - 1u)) != 0) {
        return DG_ERR_ARGUMENT;
    }
    *self = (struct dg_cia406){.model = model};
    return DG_OK;
}
