/* SPDX-License-Identifier: MIT */
/*
 * A device that has nothing in common with the encoders: eight digital inputs (CiA 401), with a
 * node-ID, bit rates, TPDOs and defaults of its own. Only the stack's public headers are needed.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "drehgeber/eds.h"
#include "ram_nvm.h"

#define FRAMES 32u
#define NODE_ID 0x11u
#define SAVE 0x65766173u /* "save" */
#define REFUSED 0x80u

/* ------------------------------------------------------------ the device */

static uint8_t inputs;

static enum dg_co_abort read_inputs(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    (void)node;
    (void)object;
    (void)op;
    *value = inputs;
    return DG_CO_OK;
}

/* clang-format off */
static const struct dg_co_row rows[] = {
    DG_CO_ROW(0x2000, 0, 0, DG_CO_U32, DG_CO_RW, 0, 1, 0, 1),
    DG_CO_ROW(0x6000, 0, 0, DG_CO_U8, DG_CO_R | DG_CO_CONST, 0, 1, 0, 0),
    DG_CO_ROW(0x6000, 1, 0, DG_CO_U8, DG_CO_R | DG_CO_MAP | DG_CO_EVENT, 0, 0, 0, 2),
    DG_CO_ROW(0x6005, 0, 0, DG_CO_U8, DG_CO_RW | DG_CO_SLOT | DG_CO_SAVE | DG_CO_FIGURE, DG_CO_SLOT_APPLICATION, 0, 1, 0),
    DG_CO_ROW(0x6006, 0, 0, DG_CO_I16, DG_CO_RW | DG_CO_SLOT, DG_CO_SLOT_APPLICATION + 1, 0xFFFFFFFBu, 2, 0),
};
static dg_co_hook *const hooks[] = {NULL, dg_co_hook_save_bus, read_inputs};
static const struct dg_co_limits limits[] = {{0, 0}, {0, 1}, {0xFFFFFF9Cu, 100}};
static const struct dg_co_figure figures[] = {
    {DG_CO_KEY(0x1017, 0), 1000},
    {DG_CO_KEY(0x1A00, 0), 1},
    {DG_CO_KEY(0x1A00, 1), 0x60000108},
    {DG_CO_KEY(0x6005, 0), 1},
};
/* clang-format on */

static const uint16_t kbaud[] = {1000, 0, 100, 50};

static void default_bus(const void *ctx, uint8_t *out)
{
    static const uint8_t bus[3] = {3, NODE_ID, 0};

    assert_non_null(ctx);
    memcpy(out, bus, sizeof bus);
}

static const struct dg_store_region regions[] = {
    DG_CO_STORE_REGIONS(default_bus),
    [DG_CO_REGION_APPLICATION] = {"inputs", 1, DG_STORE_CHECKED, 0, NULL},
};
static const struct dg_store_layout layout = {
    .id = 0x44493038u,
    .journal_size = DG_CO_JOURNAL_SIZE + 6u + 1u,
    .region_count = DG_COUNT(regions),
    .regions = regions,
};
static const char *const strings[] = {"8 inputs", "A", "1"};
static const struct dg_co_device device = {
    .name = "DI8",
    .dictionary = {DG_CO_ROWS(rows), limits, hooks},
    .figures = figures,
    .figure_count = DG_COUNT(figures),
    .kbaud = kbaud,
    .kbaud_count = DG_COUNT(kbaud),
    .strings = strings,
    .device_type = 0x00010191,
    .layout = &layout,
};

/* ------------------------------------------------------------ its bus */

static struct ram_nvm nvm;
static struct dg_world world;
static struct dg_co_node node;
static dg_ns now;
static uint16_t rate;
static struct dg_can_frame sent[FRAMES];
static size_t count;

static void keep(void *ctx, const struct dg_can_frame *frame)
{
    (void)ctx;
    assert_true(count < FRAMES);
    sent[count++] = *frame;
}

static void keep_rate(void *ctx, uint16_t value)
{
    (void)ctx;
    rate = value;
}

static const struct dg_co_ops ops = {.send = keep, .bit_rate = keep_rate};

static void power_on(void)
{
    const struct dg_co_setup setup = {
        .device = &device, .world = &world, .nvm = ram_nvm_port(&nvm), .ops = &ops};

    count = 0;
    rate = 0;
    assert_int_equal(dg_co_init(&node, &setup), DG_OK);
    assert_int_equal(dg_co_power_on(&node, now), DG_OK);
}

static int setup(void **state)
{
    (void)state;
    inputs = 0;
    now = DG_S(1);
    dg_world_init(&world);
    ram_nvm_init(&nvm, dg_store_size(&layout));
    assert_int_equal(dg_co_format(&device, ram_nvm_port(&nvm), 7), DG_OK);
    power_on();
    return 0;
}

static void receive(uint16_t id, uint8_t dlc, uint64_t data)
{
    struct dg_can_frame frame = {.id = id, .dlc = dlc};

    dg_store_le32(&frame.data[0], (uint32_t)data);
    dg_store_le32(&frame.data[4], (uint32_t)(data >> 32));
    (void)dg_co_rx(&node, now, &frame);
}

/* The answer to one expedited request; it comes at once. */
static const struct dg_can_frame *sdo(uint8_t command, uint16_t index, uint8_t sub, uint32_t value)
{
    count = 0;
    receive(0x600u + NODE_ID, 8,
            command | (uint64_t)index << 8 | (uint64_t)sub << 24 | (uint64_t)value << 32);
    assert_int_equal(count, 1);
    assert_int_equal(sent[0].id, 0x580u + NODE_ID);
    return &sent[0];
}

static uint32_t get(uint16_t index, uint8_t sub)
{
    const struct dg_can_frame *answer = sdo(0x40, index, sub, 0);

    assert_int_not_equal(answer->data[0], REFUSED);
    return dg_load_le32(&answer->data[4]);
}

static uint32_t put_value(uint8_t command, uint16_t index, uint8_t sub, uint32_t value)
{
    const struct dg_can_frame *answer = sdo(command, index, sub, value);

    return answer->data[0] == REFUSED ? dg_load_le32(&answer->data[4]) : 0;
}

/* ------------------------------------------------------------ tests */

static void it_boots_with_its_own_node_id_and_bit_rate(void **state)
{
    (void)state;
    assert_int_equal(count, 1);
    assert_int_equal(sent[0].id, 0x700u + NODE_ID);
    assert_int_equal(rate, 50);
    assert_int_equal(get(0x1000, 0), 0x00010191);
    assert_int_equal(node.value[DG_CO_SLOT_TERMINATION], 0);
}

static void defaults_are_its_own(void **state)
{
    (void)state;
    assert_int_equal(get(0x1017, 0), 1000);
    assert_int_equal(put_value(0x2B, 0x1017, 0, 0), 0);
    assert_int_equal(get(0x6005, 0), 1);
    assert_int_equal(get(0x1029, 2), 0); /* the stack's */
    assert_int_equal(get(0x1801, 2), 255);
}

/* TPDO1 carries what it says; the others, which map nothing, are not valid. */
static void its_tpdo_carries_its_object(void **state)
{
    (void)state;
    assert_int_equal(get(0x1A00, 1), 0x60000108);
    assert_int_equal(get(0x1A01, 0), 0);
    assert_int_equal(get(0x1800, 1), 0x180u + NODE_ID);
    assert_int_equal(get(0x1801, 1), 0x80000280u + NODE_ID);
    assert_int_equal(put_value(0x2B, 0x1017, 0, 0), 0);
    receive(0, 2, 0x01); /* NMT start */
    count = 0;
    inputs = 0xA5;
    dg_co_pdo_event(&node);
    assert_int_equal(count, 1);
    assert_int_equal(sent[0].id, 0x180u + NODE_ID);
    assert_int_equal(sent[0].dlc, 1);
    assert_int_equal(sent[0].data[0], 0xA5);
}

/* Of CiA 305's table it has 1000 and 50 kBd; its number 1 is none, its 100 kBd has no index there.
 */
static void lss_sets_the_bit_rates_it_has(void **state)
{
    (void)state;
    receive(0x7E5, 8, 0x0104); /* to configuration */
    for (uint8_t index = 0; index < 12; index++) {
        const bool has = index == 0 || index == 6;
        count = 0;
        receive(0x7E5, 8, 0x13u | (uint32_t)index << 16);
        assert_int_equal(count, 1);
        assert_int_equal(sent[0].data[1], has ? 0 : 1);
    }
    receive(0x7E5, 8, 0x0013); /* 1000 kBd */
    count = 0;
    receive(0x7E5, 8, 0x17); /* store */
    assert_int_equal(sent[0].data[1], 0);
    dg_co_power_off(&node);
    power_on();
    assert_int_equal(rate, 1000);
    assert_int_equal(node.bit_rate, 0);
}

static void damaged_bus_parameters_become_the_delivered_ones(void **state)
{
    static const uint8_t no_rate[3] = {1, 0x22, 1};
    (void)state;
    assert_int_equal(dg_store_put(&node.store, DG_CO_REGION_BUS, 0, no_rate, 3), DG_OK);
    power_on();
    assert_int_equal(rate, 50);
    assert_int_equal(node.id, NODE_ID);
    nvm.bytes[dg_store_address(&layout, DG_CO_REGION_BUS)] ^= 1;
    power_on();
    assert_int_equal(rate, 50);
    assert_int_equal(node.id, NODE_ID);
}

/* Without a save_ms "save" is answered in the call. What was saved comes back. */
static void saving_takes_as_long_as_it_says(void **state)
{
    (void)state;
    assert_int_equal(put_value(0x2F, 0x6005, 0, 0), 0);
    assert_int_equal(put_value(0x23, 0x1010, 1, SAVE), 0);
    assert_int_equal(put_value(0x23, 0x2000, 0, SAVE), 0);
    dg_co_power_off(&node);
    power_on();
    assert_int_equal(get(0x6005, 0), 0);
}

/* ------------------------------------------------------------ its EDS file */

static struct {
    char bytes[65536];
    size_t n;
} text;

static void append(void *ctx, const char *bytes, size_t n)
{
    assert_ptr_equal(ctx, &text);
    assert_true(n < sizeof text.bytes - text.n);
    memcpy(text.bytes + text.n, bytes, n);
    text.n += n;
    text.bytes[text.n] = '\0';
}

static void its_eds_file_is_written_from_its_rows(void **state)
{
    static const struct dg_co_name names[] = {
        {0x6000, 0, DG_CO_ARRAY, "Inputs"},
        {0x6000, 0, DG_CO_VAR, "Number of inputs"},
        {0x6000, 1, DG_CO_VAR, "Inputs 1 to 8"},
    };
    static const struct dg_co_sheet sheet = {&device,  "di8", "8 inputs",
                                             "Nobody", names, DG_COUNT(names)};
    static const char *const wanted[] = {
        "FileName=di8.eds\r\n",
        "Description=DI8, 8 inputs, as drehgeber ",
        "VendorName=Nobody\r\n",
        "BaudRate_50=1\r\nBaudRate_125=0\r\nBaudRate_250=0\r\nBaudRate_500=0\r\nBaudRate_800=0\r\n"
        "BaudRate_1000=1\r\n",
        "[ManufacturerObjects]\r\nSupportedObjects=1\r\n1=0x2000\r\n",
        "ParameterName=Producer heartbeat time\r\nObjectType=0x7\r\nDataType=0x0006\r\nAccessType=rw\r\n"
        "DefaultValue=0x3E8\r\n",
        "[6000]\r\nParameterName=Inputs\r\nObjectType=0x8\r\nSubNumber=2\r\n\r\n[6000sub0]\r\n"
        "ParameterName=Number of inputs\r\n",
        "[6000sub1]\r\nParameterName=Inputs 1 to 8\r\nObjectType=0x7\r\nDataType=0x0005\r\nAccessType=ro\r\n"
        "PDOMapping=1\r\n",
        "[6006]\r\nParameterName=Unnamed\r\nObjectType=0x7\r\nDataType=0x0003\r\nAccessType=rw\r\n"
        "DefaultValue=-5\r\nLowLimit=-100\r\nHighLimit=100\r\nPDOMapping=0\r\n\r\n",
    };
    (void)state;
    text.n = 0;
    dg_co_eds(&sheet, append, &text);
    for (size_t i = 0; i < DG_COUNT(wanted); i++) {
        assert_non_null(strstr(text.bytes, wanted[i]));
    }
}

/* In the factory, or by who sets up a rig: in the EEPROM before it is powered. */
static void a_node_id_is_burnt(void **state)
{
    (void)state;
    dg_co_power_off(&node);
    assert_int_equal(dg_co_burn_node_id(&device, ram_nvm_port(&nvm), 0), DG_ERR_ARGUMENT);
    assert_int_equal(dg_co_burn_node_id(&device, ram_nvm_port(&nvm), 128), DG_ERR_ARGUMENT);
    assert_int_equal(dg_co_burn_node_id(&device, ram_nvm_port(&nvm), 127), DG_OK);
    power_on();
    assert_int_equal(node.id, 127);
    ram_nvm_init(&nvm, dg_store_size(&layout));
    assert_int_equal(dg_co_burn_node_id(&device, ram_nvm_port(&nvm), 1), DG_ERR_BLANK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(it_boots_with_its_own_node_id_and_bit_rate, setup),
        cmocka_unit_test_setup(defaults_are_its_own, setup),
        cmocka_unit_test_setup(its_tpdo_carries_its_object, setup),
        cmocka_unit_test_setup(lss_sets_the_bit_rates_it_has, setup),
        cmocka_unit_test_setup(damaged_bus_parameters_become_the_delivered_ones, setup),
        cmocka_unit_test_setup(saving_takes_as_long_as_it_says, setup),
        cmocka_unit_test(its_eds_file_is_written_from_its_rows),
        cmocka_unit_test_setup(a_node_id_is_burnt, setup),
    };
    return cmocka_run_group_tests_name("co_device", tests, NULL, NULL);
}
