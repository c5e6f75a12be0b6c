/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "pdo_rig.h"

struct pdo_rig pdo_rig;

/* ------------------------------------------------------------ the device */

static enum dg_co_abort read_sample(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    (void)node;
    (void)object;
    (void)op;
    *value = pdo_rig.sample;
    return DG_CO_OK;
}

/* As 6200h: TPDO1's event timer seen through another object. */
static enum dg_co_abort cyclic_timer(struct dg_co_node *node, const struct dg_co_object *object,
                                     enum dg_co_op op, uint32_t *value)
{
    (void)object;
    if (op == DG_CO_READ) {
        *value = node->value[dg_co_slot_event_timer];
        return DG_CO_OK;
    }
    node->value[dg_co_slot_event_timer] = *value;
    dg_co_pdo_rearm(node, 0);
    return DG_CO_OK;
}

/* clang-format off */
static const struct dg_co_row rows[] = {
    DG_CO_ROW(0x2001, 0, 0, DG_CO_U8, DG_CO_R | DG_CO_MAP | DG_CO_EVENT, 0, 0, 0, 1),
    DG_CO_ROW(0x2002, 0, 0, DG_CO_U16, DG_CO_R | DG_CO_MAP | DG_CO_EVENT, 0, 0, 0, 1),
    DG_CO_ROW(0x2003, 0, 0, DG_CO_U32, DG_CO_R | DG_CO_MAP | DG_CO_EVENT, 0, 0, 0, 1),
    DG_CO_ROW(0x2004, 1, 0, DG_CO_I8, DG_CO_R | DG_CO_MAP, 0, 0xFFFFFFFE, 0, 0),
    DG_CO_ROW(0x2005, 0, 0, DG_CO_U32, DG_CO_R, 0, 0, 0, 0),
    DG_CO_ROW(0x2006, 0, 0, DG_CO_U32, DG_CO_W | DG_CO_MAP, 0, 0, 0, 0),
    DG_CO_ROW(0x2007, 0, 0, DG_CO_STRING, DG_CO_R, 0, 0, 0, 0),
    DG_CO_ROW(0x2008, 0, 0, DG_CO_U32, DG_CO_R | DG_CO_MAP, 0, 0x44332211, 0, 0),
    DG_CO_ROW(0x2160, 0, 0, DG_CO_U32, DG_CO_R | DG_CO_MAP, 0, 0x017F3A15, 0, 0),
    DG_CO_ROW(0x2162, 0, 0, DG_CO_U16, DG_CO_R | DG_CO_MAP, 0, 0x2900, 0, 0),
    DG_CO_ROW(0x6004, 0, 0, DG_CO_U32, DG_CO_R | DG_CO_MAP | DG_CO_EVENT, 0, 0, 0, 1),
    DG_CO_ROW(0x6030, 1, 0, DG_CO_I16, DG_CO_R | DG_CO_MAP, 0, 0xFFFFFF85, 0, 0),
    DG_CO_ROW(0x6200, 0, 0, DG_CO_U16, DG_CO_R | DG_CO_W, 0, 0, 0, 2),
};
/* clang-format on */

static dg_co_hook *const hooks[] = {NULL, read_sample, cyclic_timer};

/* clang-format off */
static const struct dg_co_figure figures[] = {
    {DG_CO_KEY(0x1801, 2), 1},
    {DG_CO_KEY(0x1A00, 0), 1}, {DG_CO_KEY(0x1A00, 1), 0x60040020},
    {DG_CO_KEY(0x1A01, 0), 1}, {DG_CO_KEY(0x1A01, 1), 0x60040020},
    {DG_CO_KEY(0x1A02, 0), 1}, {DG_CO_KEY(0x1A02, 1), 0x60300110},
    {DG_CO_KEY(0x1A03, 0), 2}, {DG_CO_KEY(0x1A03, 1), 0x21600020}, {DG_CO_KEY(0x1A03, 2), 0x21620010},
};
/* clang-format on */
static const uint16_t kbaud[] = {250};

static void default_bus(const void *ctx, uint8_t *out)
{
    static const uint8_t bus[3] = {0, 0x3F, 0};

    (void)ctx;
    memcpy(out, bus, sizeof bus);
}

static const struct dg_store_region regions[] = {DG_CO_STORE_REGIONS(default_bus)};
const struct dg_store_layout pdo_rig_layout = {
    .id = 0x7E57,
    .journal_size = DG_CO_JOURNAL_SIZE,
    .region_count = DG_COUNT(regions),
    .regions = regions,
};
static const struct dg_co_cause causes[] = {{0x1000, 0x01, DG_CO_CLASS_DEVICE}};
static const char *const strings[] = {"test", "1", "1"};

static void take_sample(struct dg_co_node *node)
{
    static const uint8_t details[5];

    pdo_rig.samples++;
    pdo_rig.sample = pdo_rig.live;
    if (pdo_rig.fault) {
        dg_co_raise(node, DG_CO_CAUSES, details);
    }
}

static dg_ns device_step(struct dg_co_node *node)
{
    if (pdo_rig.event) {
        pdo_rig.event = false;
        dg_co_pdo_event(node);
    }
    return DG_NEVER;
}

const struct dg_co_device pdo_rig_device = {
    .name = "test",
    .dictionary = {DG_CO_ROWS(rows), NULL, hooks},
    .figures = figures,
    .figure_count = DG_COUNT(figures),
    .kbaud = kbaud,
    .kbaud_count = DG_COUNT(kbaud),
    .causes = causes,
    .cause_count = 1,
    .strings = strings,
    .layout = &pdo_rig_layout,
    .sample = take_sample,
    .step = device_step,
};

/* The same memory in a device without 2001h-2008h. */
#define REST (DG_COUNT(rows) - 8)
const struct dg_co_device pdo_rig_smaller_device = {
    .name = "test",
    .dictionary = {&rows[8], REST, DG_CO_POWER(REST), NULL, hooks},
    .figures = figures,
    .figure_count = DG_COUNT(figures),
    .kbaud = kbaud,
    .kbaud_count = DG_COUNT(kbaud),
    .causes = causes,
    .cause_count = 1,
    .strings = strings,
    .layout = &pdo_rig_layout,
    .sample = take_sample,
};

/* ------------------------------------------------------------ the rig */

static void keep_frame(void *ctx, const struct dg_can_frame *frame)
{
    (void)ctx;
    assert_true(pdo_rig.count < PDO_RIG_FRAMES);
    pdo_rig.sent[pdo_rig.count++] = (struct pdo_sent){*frame, pdo_rig.now};
}

static const struct dg_co_ops ops = {.send = keep_frame};

void pdo_forget(void)
{
    pdo_rig.count = 0;
    pdo_rig.samples = 0;
}

void pdo_power_on(const struct dg_co_device *with)
{
    struct dg_co_setup setup = {
        .device = with, .world = &pdo_rig.world, .nvm = ram_nvm_port(&pdo_rig.nvm), .ops = &ops};

    assert_int_equal(dg_co_init(&pdo_rig.node, &setup), DG_OK);
    assert_int_equal(dg_co_power_on(&pdo_rig.node, pdo_rig.now), DG_OK);
    pdo_forget();
}

int pdo_set_up(void **state)
{
    (void)state;
    memset(&pdo_rig, 0, sizeof pdo_rig);
    dg_world_init(&pdo_rig.world);
    ram_nvm_init(&pdo_rig.nvm, dg_store_size(&pdo_rig_layout));
    pdo_rig.now = DG_S(1);
    pdo_rig.live = 0x01020304;
    if (dg_co_format(&pdo_rig_device, ram_nvm_port(&pdo_rig.nvm), 1) != DG_OK) {
        return -1;
    }
    pdo_power_on(&pdo_rig_device);
    return 0;
}

/* Time passes, deadlines are served exactly. */
void pdo_run_until(dg_ns end)
{
    for (dg_ns due = dg_co_step(&pdo_rig.node, pdo_rig.now); due <= end;
         due = dg_co_step(&pdo_rig.node, pdo_rig.now)) {
        assert_true(due > pdo_rig.now);
        pdo_rig.now = due;
    }
    pdo_rig.now = end;
    (void)dg_co_step(&pdo_rig.node, pdo_rig.now);
}

void pdo_run_ms(uint32_t ms)
{
    pdo_run_until(pdo_rig.now + DG_MS(ms));
}

void pdo_receive(struct dg_can_frame frame)
{
    (void)dg_co_rx(&pdo_rig.node, pdo_rig.now, &frame);
}

void pdo_nmt(uint8_t command)
{
    pdo_receive((struct dg_can_frame){.id = 0, .dlc = 2, .data = {command, 0}});
}

void pdo_sync(void)
{
    pdo_receive((struct dg_can_frame){.id = 0x80});
}

void pdo_sync_counted(uint8_t counter)
{
    pdo_receive((struct dg_can_frame){.id = 0x80, .dlc = 1, .data = {counter}});
}

void pdo_request(uint32_t id)
{
    pdo_receive((struct dg_can_frame){.id = (uint16_t)id, .rtr = true});
}

/* A change of the values that the device notices at once. */
void pdo_change(uint32_t value)
{
    pdo_rig.live = value;
    pdo_rig.event = true;
    (void)dg_co_step(&pdo_rig.node, pdo_rig.now);
}

/* Expedited download; the answer is taken out of the frames kept. @return 0 or the abort code */
uint32_t pdo_put(uint16_t index, uint8_t sub, uint32_t value, uint8_t size)
{
    struct dg_can_frame frame = {.id = 0x63F, .dlc = 8};
    uint32_t before = pdo_rig.count;

    frame.data[0] = (uint8_t)(0x23u | (4u - size) << 2);
    dg_store_le16(&frame.data[1], index);
    frame.data[3] = sub;
    dg_store_le32(&frame.data[4], value);
    pdo_receive(frame);
    for (uint32_t i = before; i < pdo_rig.count; i++) {
        struct dg_can_frame answer = pdo_rig.sent[i].frame;
        if (answer.id == 0x5BF) {
            pdo_rig.count--;
            memmove(&pdo_rig.sent[i], &pdo_rig.sent[i + 1],
                    (pdo_rig.count - i) * sizeof pdo_rig.sent[0]);
            return answer.data[0] == 0x60 ? 0 : dg_load_le32(&answer.data[4]);
        }
    }
    fail_msg("no answer");
    return 0;
}

uint32_t pdo_get(uint16_t index, uint8_t sub)
{
    struct dg_can_frame frame = {.id = 0x63F, .dlc = 8, .data = {0x40}};

    dg_store_le16(&frame.data[1], index);
    frame.data[3] = sub;
    pdo_receive(frame);
    frame = pdo_rig.sent[--pdo_rig.count].frame;
    assert_int_equal(frame.id, 0x5BF);
    assert_int_equal(frame.data[0] & 0xE0, 0x40);
    return dg_load_le32(&frame.data[4]);
}

void pdo_put_ok(uint16_t index, uint8_t sub, uint32_t value, uint8_t size)
{
    assert_int_equal(pdo_put(index, sub, value, size), 0);
}

void pdo_put_type(uint8_t n, uint8_t type)
{
    pdo_put_ok((uint16_t)(0x1800 + n), 2, type, 1);
}

/* TPDO n + 1 off. */
void pdo_disable(uint8_t n)
{
    pdo_put_ok((uint16_t)(0x1800 + n), 1, NOT_VALID | (TPDO1 + 0x100u * n), 4);
}

void pdo_enable(uint8_t n)
{
    pdo_put_ok((uint16_t)(0x1800 + n), 1, TPDO1 + 0x100u * n, 4);
}

/* TPDO2 alone, of this type, operational; nothing sent yet. */
void pdo_only_tpdo2(uint8_t type)
{
    pdo_disable(0);
    pdo_disable(2);
    pdo_disable(3);
    pdo_put_type(1, type);
    pdo_nmt(START);
    pdo_forget();
}

/* TPDO1 alone, type 255, operational; what was sent on entering is forgotten. */
void pdo_only_tpdo1(uint16_t event_ms, uint16_t inhibit_ms)
{
    pdo_disable(1);
    pdo_disable(2);
    pdo_disable(3);
    pdo_disable(0);
    pdo_put_ok(0x1800, 3, inhibit_ms * 10u, 2);
    pdo_put_ok(0x1800, 5, event_ms, 2);
    pdo_enable(0);
    pdo_nmt(START);
    pdo_forget();
}

void pdo_expect(uint32_t i, uint32_t id, const uint8_t *data, uint8_t dlc)
{
    assert_true(i < pdo_rig.count);
    assert_int_equal(pdo_rig.sent[i].frame.id, id);
    assert_false(pdo_rig.sent[i].frame.rtr);
    assert_int_equal(pdo_rig.sent[i].frame.dlc, dlc);
    assert_memory_equal(pdo_rig.sent[i].frame.data, data, dlc);
}

/* Frame i is a TPDO with the 32-bit value of that moment. */
void pdo_expect_u32(uint32_t i, uint32_t id, uint32_t value)
{
    const uint8_t data[] = {(uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16),
                            (uint8_t)(value >> 24)};

    pdo_expect(i, id, data, sizeof data);
}

void pdo_expect_at_ms(uint32_t i, dg_ns since, uint32_t ms)
{
    assert_true(i < pdo_rig.count);
    assert_int_equal(pdo_rig.sent[i].at - since, DG_MS(ms));
}
