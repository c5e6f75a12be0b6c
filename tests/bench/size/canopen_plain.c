/* SPDX-License-Identifier: MIT */
/* The rows of the F3668, each a plain value of its own: what the stack and a dictionary cost. */
#include "canopen_device.h"
#include "cia406_private.h"

enum {
    R = DG_CO_R,
    W = DG_CO_W,
    M = DG_CO_MAP,
    S = DG_CO_SAVE,
    V = DG_CO_SLOT,
    C = DG_CO_CONST,
    I = DG_CO_ID,
    E = DG_CO_EVENT,
    X = DG_CO_ACTION,
    L = DG_CO_LIVE,
    F = 0,
};

#define DG_CO_PARENT(index, kind, name)
#define DG_CO_OBJECT(index, sub, more, type, access, slot, initial, limits, hook, name)            \
    DG_CO_ROW(index, sub, more, DG_CO_##type, access, slot, initial, limits, 0),
#define DG_CO_MORE(index, sub, name)

enum { FULL, TO_1, TO_8, NODE_ID, CELSIUS, RANGE, U16_FROM_1, TO_65536, TO_200, POSITION = FULL };
static dg_co_hook *const hooks[] = {NULL};
static const struct dg_co_limits limits[] = {{0, 0},          {0, 1},       {0, 8},
                                             {1, 127},        {0x20, 0xAC}, {1, UINT32_MAX},
                                             {1, UINT16_MAX}, {1, 65536},   {1, 200}};

static const struct dg_co_row rows[] = {
#include "objects.def"
};

static void default_bus(const void *ctx, uint8_t *out)
{
    (void)ctx;
    out[0] = 1;
    out[1] = 1;
    out[2] = 0;
}

static const uint16_t kbaud[] = {0, 250};
static const char *const strings[] = {"F36x8 CANopen encoder", "1.00", "1.08"};
static const struct dg_store_region regions[] = {
    DG_CO_STORE_REGIONS(default_bus),
    [REGION_PROFILE] = {"profile", 60, DG_STORE_CHECKED, 0, NULL},
};
static const struct dg_store_layout layout = {.id = 1,
                                              .journal_size = DG_CO_JOURNAL_SIZE + 6u + 60u,
                                              .region_count = DG_COUNT(regions),
                                              .regions = regions};
static const struct dg_co_device plain = {.dictionary = {DG_CO_ROWS(rows), limits, hooks},
                                          .kbaud = kbaud,
                                          .kbaud_count = DG_COUNT(kbaud),
                                          .strings = strings,
                                          .layout = &layout,
                                          .device_type = 0x00020196};

const struct dg_co_device *const device = &plain;

void *device_start(void)
{
    return NULL;
}
