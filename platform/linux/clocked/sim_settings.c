/* SPDX-License-Identifier: MIT */
#include "sim_settings.h"

#include <stddef.h>
#include <string.h>

#include "figure.h"
#include "settings.h"

struct key {
    const char *name;
    size_t offset;
    uint32_t min;
    uint32_t max;
    uint32_t initial;
    const char *help;
};

#define TIMING(field) offsetof(struct lx_clocked_timing, field)

/* clang-format off */
static const struct key keys[] = {
    {"clock_hz",      TIMING(clock_hz),      LX_CLOCK_MIN_HZ, LX_CLOCK_MAX_HZ,      LX_CLOCK_HZ, "simulated wire: clock of the master, in Hz"},
    {"line_delay_ns", TIMING(line_delay_ns), 0,                    LX_CABLE_DELAY_MAX_NS, 0,                "simulated wire: delay of the cable each way, in ns; 5 ns are a metre"},
};
/* clang-format on */
#define KEY_COUNT (sizeof keys / sizeof keys[0])

const char *const lx_sim_keys[] = {"clock_hz", "line_delay_ns", NULL};
_Static_assert(sizeof lx_sim_keys / sizeof lx_sim_keys[0] == KEY_COUNT + 1u, "a row for each key");

/* The row of "key=value", or NULL. */
static const struct key *find(const char *assignment)
{
    const size_t n = strcspn(assignment, "=");
    for (size_t i = 0; i < KEY_COUNT; i++) {
        if (strlen(keys[i].name) == n && memcmp(keys[i].name, assignment, n) == 0) {
            return &keys[i];
        }
    }
    return NULL;
}

static void store(struct lx_clocked_timing *self, const struct key *key, uint32_t value)
{
    memcpy((uint8_t *)self + key->offset, &value, sizeof value);
}

void lx_sim_settings_init(struct lx_clocked_timing *self)
{
    for (size_t i = 0; i < KEY_COUNT; i++) {
        store(self, &keys[i], keys[i].initial);
    }
}

bool lx_sim_settings_has(const char *assignment)
{
    return find(assignment) != NULL;
}

int lx_sim_settings_set(struct lx_clocked_timing *self, const char *assignment,
                        struct lx_error *error)
{
    const struct key *key = find(assignment);
    const char *equals = strchr(assignment, '=');
    uint64_t value = 0;
    if (key == NULL) {
        return lx_fail(error, "--set %s: clock_hz or line_delay_ns is right", assignment);
    }
    if (equals == NULL || !lx_unsigned_parse(equals + 1, &value) || value < key->min ||
        value > key->max) {
        return lx_fail(error, "--set %s: a number in %lu..%lu is right", assignment,
                       (unsigned long)key->min, (unsigned long)key->max);
    }
    store(self, key, (uint32_t)value);
    return 0;
}

int lx_sim_settings_plan(struct lx_clocked_timing *self, const struct lx_plan *plan,
                         const struct lx_plan_wire *wire, struct lx_error *error)
{
    lx_sim_settings_init(self);
    for (size_t i = 0; i < wire->settings.count; i++) {
        const struct lx_plan_setting *setting = &wire->settings.list[i];
        char assignment[LX_ASSIGNMENT_MAX];
        if (lx_settings_assignment(assignment, plan, setting, error) != 0) {
            return -1;
        }
        if (lx_sim_settings_set(self, assignment, error) != 0) {
            return lx_settings_refuse(plan, setting->line, error);
        }
    }
    return 0;
}

void lx_sim_settings_help(FILE *to)
{
    for (size_t i = 0; i < KEY_COUNT; i++) {
        (void)fprintf(to, "  %-23s %s (%lu..%lu, default %lu)\n", keys[i].name, keys[i].help,
                      (unsigned long)keys[i].min, (unsigned long)keys[i].max,
                      (unsigned long)keys[i].initial);
    }
}
