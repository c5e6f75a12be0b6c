/* SPDX-License-Identifier: MIT */
/*
 * Parameters that survive power-off: 1010h, 1011h, 2105h and LSS 17h (manual chapters 8, 9, 12; C7,
 * C8, C10). Then the hostile world: a memory that does not answer, is damaged, blank or another
 * device's; power that fails in every write of every command; every bit that can rot.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "co_od.h"
#include "co_rig.h"
#include "effort.h"

#define SDO_RX 0x63F
#define SDO_TX 0x5BF
#define EMCY 0x0BF
#define BOOT_UP 0x73F
#define LSS 0x7E5
#define RESET_NODE 0x81
#define SAVE 0x65766173u /* "save" */
#define LOAD 0x64616F6Cu /* "load" */
#define DAMAGED "00 51 01 00 00 00 00 00"

static struct co_rig rig;
/* The encoder without its supervision, whose own emergencies are no matter of the stack. */
static struct dg_co_device bare;
static const struct dg_co_device *const device = &bare;
static const struct dg_cia406_model model = {.turns = 4096, .device = &bare};

static void start_node(void)
{
    bare = dg_cia406_multiturn;
    bare.step = NULL;
    co_rig_start_model(&rig, &model);
}

static int setup(void **state)
{
    (void)state;
    start_node();
    return 0;
}

/* Regions that the stack looks after; the profile's own follow. */
static const uint8_t stack_regions = DG_CO_REGION_APPLICATION + 1;

static void write_ok(uint16_t index, uint8_t sub, uint32_t value, uint8_t size)
{
    assert_int_equal(co_rig_write(&rig, index, sub, value, size), 0);
}

static uint32_t read_ok(uint16_t index, uint8_t sub)
{
    return co_rig_get(&rig, index, sub);
}

static void power_cycle(void)
{
    dg_co_power_off(&rig.node);
    co_rig_forget(&rig);
    assert_int_equal(co_rig_power_on(&rig), DG_OK);
}

/* ------------------------------------------------------------ the commands */

static void saved_values_survive_and_others_do_not(void **state)
{
    (void)state;
    write_ok(0x100C, 0, 500, 2);
    write_ok(0x1802, 5, 250, 2);
    write_ok(0x1010, 1, SAVE, 4);
    write_ok(0x100C, 0, 600, 2);
    write_ok(0x100D, 0, 3, 1);
    power_cycle();
    co_rig_expect_count(&rig, 1); /* boot-up, no EMCY */
    co_rig_expect(&rig, 0, BOOT_UP, "00");
    assert_int_equal(read_ok(0x100C, 0), 500);
    assert_int_equal(read_ok(0x100D, 0), 0);
    assert_int_equal(read_ok(0x1802, 5), 250);
}

static void defaults_come_back_at_the_next_reset(void **state)
{
    (void)state;
    write_ok(0x100C, 0, 500, 2);
    write_ok(0x1801, 2, 10, 1);
    write_ok(0x1010, 1, SAVE, 4);
    write_ok(0x1011, 1, LOAD, 4);
    assert_int_equal(read_ok(0x100C, 0), 500);
    co_rig_nmt(&rig, RESET_NODE);
    assert_int_equal(read_ok(0x100C, 0), 0);
    assert_int_equal(read_ok(0x1801, 2), 1);
    power_cycle();
    assert_int_equal(read_ok(0x100C, 0), 0);
    write_ok(0x100C, 0, 700, 2); /* and can be saved again */
    write_ok(0x1010, 1, SAVE, 4);
    power_cycle();
    assert_int_equal(read_ok(0x100C, 0), 700);
    assert_int_equal(read_ok(0x1801, 2), 1);
}

static void bus_parameters_are_kept_by_2105h_alone(void **state)
{
    (void)state;
    write_ok(0x2100, 0, 6, 1);
    write_ok(0x2101, 0, 5, 1);
    write_ok(0x2102, 0, 0, 1);
    write_ok(0x1010, 1, SAVE, 4);
    power_cycle();
    assert_int_equal(rig.node.id, 0x3F);
    assert_int_equal(rig.kbaud, 250);
    assert_int_equal(read_ok(0x2102, 0), 1);

    write_ok(0x2100, 0, 6, 1);
    write_ok(0x2101, 0, 5, 1);
    write_ok(0x2102, 0, 0, 1);
    write_ok(0x100C, 0, 500, 2);
    write_ok(0x2105, 0, SAVE, 4);
    assert_int_equal(rig.node.id, 0x3F); /* not before reset node */
    assert_int_equal(rig.kbaud, 250);
    co_rig_nmt(&rig, RESET_NODE);
    assert_int_equal(rig.node.id, 5);
    assert_int_equal(rig.kbaud, 500);
    power_cycle();
    assert_int_equal(rig.node.id, 5);
    assert_int_equal(rig.kbaud, 500);
    assert_int_equal(read_ok(0x2100, 0), 6);
    assert_int_equal(read_ok(0x2101, 0), 5);
    assert_int_equal(read_ok(0x2102, 0), 0);
    assert_int_equal(read_ok(0x100C, 0), 0);
    /* Saved by 2105h, so not touched by 1011h. */
    write_ok(0x1011, 1, LOAD, 4);
    power_cycle();
    assert_int_equal(rig.node.id, 5);
}

static void bus_parameters_that_are_not_saved_are_gone_after_reset_node(void **state)
{
    (void)state;
    write_ok(0x2100, 0, 8, 1);
    write_ok(0x2101, 0, 5, 1);
    co_rig_nmt(&rig, RESET_NODE);
    assert_int_equal(rig.kbaud, 250);
    assert_int_equal(read_ok(0x2100, 0), 5);
    assert_int_equal(read_ok(0x2101, 0), 0x3F);
}

/* The three command objects; the answer to "save" takes 14 ms, that to "load" none. */
static const struct {
    uint16_t index;
    const char *read;
    const char *one;
    const char *right;
    const char *wrong; /* the signature reversed */
    const char *done;
    const char *refused;
    unsigned delay_ms;
} commands[] = {
    {0x1010, "40 10 10 01 00 00 00 00", "43 10 10 01 01 00 00 00", "23 10 10 01 73 61 76 65",
     "23 10 10 01 65 76 61 73", "60 10 10 01 00 00 00 00", "80 10 10 01 20 00 00 08", 14},
    {0x1011, "40 11 10 01 00 00 00 00", "43 11 10 01 01 00 00 00", "23 11 10 01 6C 6F 61 64",
     "23 11 10 01 73 61 76 65", "60 11 10 01 00 00 00 00", "80 11 10 01 20 00 00 08", 0},
    {0x2105, "40 05 21 00 00 00 00 00", "43 05 21 00 01 00 00 00", "23 05 21 00 73 61 76 65",
     "23 05 21 00 6C 6F 61 64", "60 05 21 00 00 00 00 00", "80 05 21 00 20 00 00 08", 14},
};

/* A request and the only answer to it, after `delay_ms`. */
static void ask(const char *request, const char *answer, unsigned delay_ms)
{
    const dg_ns begin = rig.now;

    co_rig_forget(&rig);
    co_rig_rx(&rig, SDO_RX, request);
    co_rig_expect_count(&rig, delay_ms == 0 ? 1 : 0);
    co_rig_run(&rig, DG_MS(100));
    co_rig_expect_count(&rig, 1);
    co_rig_expect(&rig, 0, SDO_TX, answer);
    assert_int_equal(rig.at[0] - begin, DG_MS(delay_ms));
}

static void signatures_are_checked_and_answers_take_their_time(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(commands); i++) {
        const uint32_t writes = rig.nvm.writes;
        ask(commands[i].read, commands[i].one, 0);
        ask(commands[i].wrong, commands[i].refused, 0);
        assert_int_equal(rig.nvm.writes, writes);
        ask(commands[i].right, commands[i].done, commands[i].delay_ms);
        assert_true(rig.nvm.writes > writes);
    }
}

static void a_request_before_the_delayed_answer_is_answered_after_it(void **state)
{
    (void)state;
    co_rig_rx(&rig, SDO_RX, commands[0].right);
    co_rig_run(&rig, DG_MS(5));
    co_rig_expect_count(&rig, 0);
    co_rig_rx(&rig, SDO_RX, "40 00 10 00");
    co_rig_run(&rig, DG_MS(100));
    co_rig_expect_count(&rig, 2);
    co_rig_expect(&rig, 0, SDO_TX, commands[0].done);
    co_rig_expect(&rig, 1, SDO_TX, "43 00 10 00 96 01 02 00");
}

static void a_reset_or_stop_takes_the_delayed_answer_with_it(void **state)
{
    static const uint8_t nmt[] = {0x02, 0x81, 0x82};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(nmt); i++) {
        start_node();
        co_rig_rx(&rig, SDO_RX, commands[0].right);
        co_rig_nmt(&rig, nmt[i]);
        co_rig_run(&rig, DG_MS(100));
        co_rig_expect_count(&rig, 0);
    }
}

/* ------------------------------------------------------------ a memory that does not answer */

static void no_answer_from_the_memory_is_told(void **state)
{
    (void)state;
    for (unsigned how = 0; how < 2; how++) {
        start_node();
        rig.nvm.no_acknowledge = how == 0;
        rig.world.eeprom_acknowledges = how != 0 ? false : true;
        for (size_t i = 0; i < DG_COUNT(commands); i++) {
            const uint32_t signature = commands[i].index == 0x1011 ? LOAD : SAVE;
            const uint8_t sub = commands[i].index == 0x2105 ? 0 : 1;
            assert_int_equal(co_rig_write(&rig, commands[i].index, sub, signature, 4), 0x06060000);
        }
        co_rig_rx(&rig, LSS, "04 01 00 00 00 00 00 00");
        co_rig_forget(&rig);
        co_rig_rx(&rig, LSS, "17 00 00 00 00 00 00 00");
        co_rig_expect(&rig, 0, 0x7E4, "17 02 00 00 00 00 00 00");
        co_rig_rx(&rig, LSS, "04 00 00 00 00 00 00 00");
        rig.nvm.no_acknowledge = false; /* and when it answers again, it works again */
        rig.world.eeprom_acknowledges = true;
        write_ok(0x100C, 0, 500, 2);
        write_ok(0x1010, 1, SAVE, 4);
        power_cycle();
        assert_int_equal(read_ok(0x100C, 0), 500);
    }
}

/* Nothing is silently replaced by defaults: 5100h, from power-on and from either reset. */
static void parameters_that_cannot_be_read_are_the_defaults_and_an_emergency(void **state)
{
    static const uint8_t nmt[] = {0, 0x81, 0x82};
    (void)state;
    for (size_t i = 0; i < 2 * DG_COUNT(nmt); i++) {
        const uint8_t command[2] = {nmt[i / 2], 0};
        struct dg_can_frame frame = {.dlc = 2};
        memcpy(frame.data, command, sizeof command);
        start_node();
        write_ok(0x100C, 0, 500, 2);
        write_ok(0x1010, 1, SAVE, 4);
        rig.nvm.no_acknowledge = i % 2 == 0;
        rig.world.eeprom_acknowledges = i % 2 == 0;
        co_rig_forget(&rig);
        if (command[0] == 0) {
            assert_int_equal(co_rig_power_on(&rig), DG_OK);
        } else {
            (void)dg_co_rx(&rig.node, rig.now, &frame);
        }
        co_rig_expect_count(&rig, 2);
        co_rig_expect(&rig, 0, BOOT_UP, "00");
        co_rig_expect(&rig, 1, EMCY, DAMAGED);
        assert_int_equal(read_ok(0x100C, 0), 0);
        rig.nvm.no_acknowledge = false;
        rig.world.eeprom_acknowledges = true;
        power_cycle();
        co_rig_expect_count(&rig, 1);
        assert_int_equal(read_ok(0x100C, 0), 500);
    }
}

static unsigned reads_of_parameters;

/* The parameters can be read once, to check their sum. */
static int read_once(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct dg_nvm nvm = ram_nvm_port(ctx);

    if (address == dg_store_address(device->layout, DG_CO_REGION_COMMUNICATION)) {
        reads_of_parameters++;
    }
    return reads_of_parameters > 1 ? DG_ERR_IO : nvm.ops->read(ctx, address, to, n);
}

static void a_part_that_cannot_be_read_is_an_emergency(void **state)
{
    static const struct dg_nvm_ops failing = {.read = read_once};
    (void)state;

    write_ok(0x100C, 0, 500, 2);
    write_ok(0x1010, 1, SAVE, 4);
    rig.node.setup.nvm.ops = &failing;
    reads_of_parameters = 0;
    co_rig_forget(&rig);
    co_rig_rx(&rig, 0, "82 00");
    co_rig_expect_count(&rig, 2);
    co_rig_expect(&rig, 0, BOOT_UP, "00");
    co_rig_expect(&rig, 1, EMCY, DAMAGED);
    assert_int_equal(read_ok(0x100C, 0), 0);
}

static void a_blank_or_foreign_memory_is_not_touched(void **state)
{
    (void)state;
    for (unsigned how = 0; how < 2; how++) {
        const uint8_t fill = how == 0 ? 0xFF : 0x5A;
        memset(rig.nvm.bytes, fill, rig.nvm.size);
        const uint32_t writes = rig.nvm.writes;
        co_rig_forget(&rig);
        assert_int_equal(co_rig_power_on(&rig), how == 0 ? DG_ERR_BLANK : DG_ERR_FOREIGN);
        assert_int_equal(rig.nvm.writes, writes);
        assert_int_equal(rig.node.state, DG_CO_OFF);
        co_rig_rx(&rig, LSS, "04 01 00 00 00 00 00 00");
        co_rig_rx(&rig, 0, "81 00");
        co_rig_run(&rig, DG_S(2));
        co_rig_expect_count(&rig, 0);
    }
}

/* ------------------------------------------------------------ what the memory says, as a whole */

/* Everything that depends on the memory, as power-on leaves it. */
struct sight {
    uint8_t id;
    uint8_t bit_rate;
    uint32_t serial;
    uint32_t value[DG_CO_VALUES_MAX];
};

static void look_at_node(struct sight *sight)
{
    memset(sight, 0, sizeof *sight);
    sight->id = rig.node.id;
    sight->bit_rate = rig.node.bit_rate;
    sight->serial = rig.node.serial;
    memcpy(sight->value, rig.node.value, sizeof sight->value);
    struct dg_co_object row = dg_co_first();
    do {
        if (co_is(&row, DG_CO_SLOT | DG_CO_LIVE)) {
            sight->value[row.slot] = 0; /* measured, not set */
        }
    } while (dg_co_next(device, &row));
}

static bool same(const struct sight *a, const struct sight *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

/* Every region differs from its default, the node-ID does not. */
static void live_in(void)
{
    start_node();
    write_ok(0x100C, 0, 500, 2);
    write_ok(0x1017, 0, 1000, 2);
    write_ok(0x1016, 1, 0x00120064, 4);
    for (uint16_t n = 0; n < DG_CO_TPDOS; n++) {
        write_ok((uint16_t)(0x1800 + n), 5, 100u + n, 2);
        write_ok((uint16_t)(0x1800 + n), 2, 254, 1);
    }
    write_ok(0x2140, 1, 0x12345678, 4);
    write_ok(0x6003, 0, 1000, 4);
    write_ok(0x1010, 1, SAVE, 4);
    write_ok(0x2100, 0, 6, 1);
    write_ok(0x2102, 0, 0, 1);
    write_ok(0x2105, 0, SAVE, 4);
    power_cycle();
}

/* What `before` becomes when region `damaged` cannot be used. */
static void damage(struct sight *before, int damaged)
{
    if (damaged == DG_CO_REGION_BUS) {
        before->bit_rate = 5;
        before->value[DG_CO_SLOT_BIT_RATE] = 5;
        before->value[DG_CO_SLOT_TERMINATION] = 1;
    } else if (damaged == DG_CO_REGION_SERIAL) {
        before->serial = 0;
    }
    struct dg_co_object row = dg_co_first();
    do {
        if (co_is(&row, DG_CO_SAVE) &&
            (dg_co_region_of(&row) == damaged || damaged == DG_CO_REGION_SAVED)) {
            before->value[row.slot] =
                dg_co_default(device, &row) + (co_is(&row, DG_CO_ID) ? before->id : 0);
        }
    } while (dg_co_next(device, &row));
}

static void a_damaged_region_is_the_default_and_the_others_stay(void **state)
{
    struct sight expected;
    struct sight seen;
    (void)state;

    for (uint8_t region = 0; region < stack_regions; region++) {
        live_in();
        look_at_node(&expected);
        rig.nvm.bytes[dg_store_address(device->layout, region)] ^= 0x10;
        power_cycle();
        assert_int_equal(rig.frame[0].id, BOOT_UP);
        co_rig_expect(&rig, rig.count - 1, EMCY, DAMAGED);
        look_at_node(&seen);
        damage(&expected, region);
        assert_true(same(&seen, &expected));
        assert_int_equal(read_ok(0x1001, 0), 1);
        assert_int_equal(read_ok(0x1003, 1), 0x5100);
        /* Saving repairs what it writes; the serial number is burnt by the maker only. */
        write_ok(0x1010, 1, SAVE, 4);
        write_ok(0x2105, 0, SAVE, 4);
        power_cycle();
        assert_int_equal(read_ok(0x1001, 0), region == DG_CO_REGION_SERIAL ? 1 : 0);
    }
}

/* Initialisation checks the memory again; what is in force stays in force. */
static void damage_while_powered_is_noticed_by_either_reset(void **state)
{
    static const char *const resets[] = {"81 00", "82 00"};
    (void)state;

    for (size_t i = 0; i < DG_COUNT(resets); i++) {
        live_in();
        rig.nvm.bytes[dg_store_address(device->layout, DG_CO_REGION_TPDO2)] ^= 1;
        rig.nvm.bytes[dg_store_address(device->layout, DG_CO_REGION_BUS)] ^= 1;
        co_rig_forget(&rig);
        co_rig_rx(&rig, 0, resets[i]);
        co_rig_expect(&rig, rig.count - 1, EMCY, DAMAGED);
        assert_int_equal(read_ok(0x1801, 5), 0);
        assert_int_equal(read_ok(0x1802, 5), 102);
        assert_int_equal(rig.kbaud, 500);
    }
}

/* Region a byte of the memory belongs to, its sum included, or -1. */
static int region_at(uint32_t address)
{
    int region = device->layout->region_count - 1;

    while (region >= 0 && address < dg_store_address(device->layout, (uint8_t)region)) {
        region--;
    }
    return region;
}

static void every_bit_that_rots_is_noticed_or_does_not_matter(void **state)
{
    static struct co_rig lived_in;
    struct sight whole;
    struct sight seen;
    (void)state;

    live_in();
    look_at_node(&whole);
    lived_in = rig;
    for (uint32_t bit = 0; bit < 8u * rig.nvm.size; bit += effort(5, 1)) {
        struct sight expected = whole;
        const int region = region_at(bit / 8u);
        rig = lived_in;
        rig.nvm.bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
        power_cycle();
        look_at_node(&seen);
        damage(&expected, region);
        assert_true(same(&seen, &expected));
        const bool noticed = region >= 0 && region < stack_regions;
        assert_int_equal(rig.node.active_causes, noticed ? 1u << DG_CO_CAUSE_MEMORY : 0);
    }
}

/* Sums that fit and values that do not: another firmware's, or damage that hit the sum, too. */
static void values_out_of_range_do_not_come_into_force(void **state)
{
    uint8_t bytes[DG_STORE_CHECKED_MAX];
    (void)state;

    for (uint8_t region = 0; region < stack_regions; region++) {
        const uint16_t size = device->layout->regions[region].size;
        for (unsigned fill = 0; fill <= 0xFF; fill += 0x33) {
            live_in();
            memset(bytes, (int)fill, sizeof bytes);
            assert_int_equal(dg_store_put(&rig.node.store, region, 0, bytes, size), DG_OK);
            power_cycle();
            const bool tpdo = region >= DG_CO_REGION_TPDO1 && region <= DG_CO_REGION_TPDO4;
            const bool plain =
                region == DG_CO_REGION_SAVED || region == DG_CO_REGION_SERIAL || tpdo;
            assert_true(fill != 0xFF || plain == (rig.node.active_causes == 0));
            assert_true(!tpdo || !rig.node.tpdo[region - DG_CO_REGION_TPDO1].valid);
            assert_true(rig.node.id >= 1 && (rig.node.id <= 127 || rig.node.id == 0xFF));
            assert_true(rig.node.bit_rate <= 8 && rig.node.bit_rate != 7);
            assert_in_range(rig.node.value[DG_CO_SLOT_TERMINATION], 0, 1);
            struct dg_co_object row = dg_co_first();
            do {
                /* 6509h, the only signed one, may be anything. */
                if (co_is(&row, DG_CO_SAVE) && row.index != 0x6509) {
                    const struct dg_co_limits limits = dg_co_limits_of(&row);
                    assert_in_range(rig.node.value[row.slot], limits.min, limits.max);
                }
            } while (dg_co_next(device, &row));
        }
    }
}

/* ------------------------------------------------------------ power cut */

static bool save_parameters(void)
{
    write_ok(0x100D, 0, 7, 1);
    write_ok(0x1803, 3, 0, 2);
    write_ok(0x1801, 5, 77, 2);
    return co_rig_write(&rig, 0x1010, 1, SAVE, 4) == 0;
}

static bool load_defaults(void)
{
    return co_rig_write(&rig, 0x1011, 1, LOAD, 4) == 0;
}

static bool save_bus(void)
{
    write_ok(0x2100, 0, 8, 1);
    write_ok(0x2101, 0, 9, 1);
    write_ok(0x2102, 0, 1, 1);
    return co_rig_write(&rig, 0x2105, 0, SAVE, 4) == 0;
}

static bool store_by_lss(void)
{
    co_rig_rx(&rig, LSS, "04 01 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS, "11 0A 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS, "13 00 02 00 00 00 00 00");
    co_rig_forget(&rig);
    co_rig_rx(&rig, LSS, "17 00 00 00 00 00 00 00");
    co_rig_expect_count(&rig, 1);
    return rig.frame[0].data[1] == 0;
}

/* 1011h came before: what lies in the memory does not count. */
static void restored(void)
{
    live_in();
    assert_true(load_defaults());
    power_cycle();
}

static void earlier(void)
{
    static const uint32_t absolute[] = {0x1BF, 0x2BF, 0x333, 0x4BF};
    live_in();
    co_rig_store_cob_ids(&rig, absolute);
    power_cycle();
}

static struct store {
    const char *name;
    bool (*act)(void);
    void (*before)(void);
} stores[] = {
    {"1010h", save_parameters, live_in},
    {"1010h after 1011h", save_parameters, restored},
    {"1011h", load_defaults, live_in},
    {"2105h", save_bus, live_in},
    {"LSS store", store_by_lss, live_in},
    {"1010h, earlier release", save_parameters, earlier},
    {"2105h, earlier release", save_bus, earlier},
    {"LSS store, earlier release", store_by_lss, earlier},
};

/* Most bytes of a write that can get through; what tears later tears like this. */
static const uint32_t tears[] = {0, 1, 2, 5, 6, 7, 15, 31, 40};

static struct co_rig lived_in;
static struct co_rig powerless;
static struct sight before;
static struct sight after;

/* The memory as the power failure left it; with `cut`, fail again in that write of the start.
 * Returns whether there was such a write. */
static bool start_again(int cut, enum ram_nvm_tear tear, uint32_t tear_at)
{
    bool failed = false;

    rig = powerless;
    ram_nvm_restore(&rig.nvm);
    if (cut >= 0) {
        ram_nvm_cut(&rig.nvm, (uint32_t)cut, tear, tear_at);
        assert_int_equal(co_rig_power_on(&rig), DG_OK);
        failed = rig.nvm.dead;
        ram_nvm_restore(&rig.nvm);
    }
    power_cycle();
    assert_int_equal(rig.node.active_causes, 0);
    return failed;
}

/* Old or new as a whole, new if it was acknowledged; a second failure while it starts changes
 * nothing. */
static void assert_old_or_new(bool acknowledged)
{
    struct sight seen;
    struct sight again;
    bool failed = true;
    powerless = rig;
    (void)start_again(-1, RAM_NVM_ORDERED, 0);
    look_at_node(&seen);
    assert_true(same(&seen, &after) || (!acknowledged && same(&seen, &before)));
    for (int cut = 0; failed; cut++) {
        failed = start_again(cut, (enum ram_nvm_tear)(cut % RAM_NVM_TEAR_COUNT), 3);
        look_at_node(&again);
        assert_true(same(&again, &seen));
    }
}

static void power_may_fail(void **state)
{
    const struct store *store = *state;

    store->before();
    lived_in = rig;
    look_at_node(&before);
    const uint32_t first = rig.nvm.writes;
    assert_true(store->act());
    const uint32_t writes = rig.nvm.writes - first;
    assert_in_range(writes, 3, 100);
    power_cycle();
    look_at_node(&after);
    assert_false(same(&before, &after));
    for (uint32_t cut = 0; cut <= writes; cut++) {
        for (unsigned tear = 0; tear < RAM_NVM_TEAR_COUNT; tear++) {
            for (size_t i = 0; i < DG_COUNT(tears); i += effort(2, 1)) {
                rig = lived_in;
                ram_nvm_cut(&rig.nvm, cut, (enum ram_nvm_tear)tear, tears[i]);
                const bool acknowledged = store->act();
                assert_int_equal(acknowledged, cut == writes);
                assert_int_equal(rig.nvm.dead, cut < writes);
                assert_old_or_new(acknowledged);
            }
        }
    }
}

/* The power fails while the answer to "save" is still to come: it is durable already. */
static void a_save_is_durable_before_it_is_answered(void **state)
{
    (void)state;
    write_ok(0x100C, 0, 500, 2);
    co_rig_forget(&rig);
    co_rig_rx(&rig, SDO_RX, commands[0].right);
    co_rig_run(&rig, DG_MS(13));
    co_rig_expect_count(&rig, 0);
    power_cycle();
    assert_int_equal(read_ok(0x100C, 0), 500);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(saved_values_survive_and_others_do_not, setup),
        cmocka_unit_test_setup(defaults_come_back_at_the_next_reset, setup),
        cmocka_unit_test_setup(bus_parameters_are_kept_by_2105h_alone, setup),
        cmocka_unit_test_setup(bus_parameters_that_are_not_saved_are_gone_after_reset_node, setup),
        cmocka_unit_test_setup(signatures_are_checked_and_answers_take_their_time, setup),
        cmocka_unit_test_setup(a_request_before_the_delayed_answer_is_answered_after_it, setup),
        cmocka_unit_test(a_reset_or_stop_takes_the_delayed_answer_with_it),
        cmocka_unit_test_setup(a_save_is_durable_before_it_is_answered, setup),
        cmocka_unit_test(no_answer_from_the_memory_is_told),
        cmocka_unit_test(parameters_that_cannot_be_read_are_the_defaults_and_an_emergency),
        cmocka_unit_test_setup(a_part_that_cannot_be_read_is_an_emergency, setup),
        cmocka_unit_test_setup(a_blank_or_foreign_memory_is_not_touched, setup),
        cmocka_unit_test(a_damaged_region_is_the_default_and_the_others_stay),
        cmocka_unit_test(damage_while_powered_is_noticed_by_either_reset),
        cmocka_unit_test(every_bit_that_rots_is_noticed_or_does_not_matter),
        cmocka_unit_test(values_out_of_range_do_not_come_into_force),
    };
    struct CMUnitTest cuts[DG_COUNT(stores)];

    for (size_t i = 0; i < DG_COUNT(stores); i++) {
        cuts[i] = (struct CMUnitTest){
            .name = stores[i].name, .test_func = power_may_fail, .initial_state = &stores[i]};
    }
    return cmocka_run_group_tests(tests, NULL, NULL) +
           cmocka_run_group_tests_name("power may fail in", cuts, NULL, NULL);
}
