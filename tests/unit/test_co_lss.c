/* SPDX-License-Identifier: MIT */
/*
 * Layer setting services (CiA 305; manual chapters 6 and 9; C8-C10), with frames written by hand.
 * The rig's identity: vendor 13h, product 56682001h, revision 108 (6Ch), serial 1234567890
 * (499602D2h).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "co_rig.h"

#define MASTER 0x7E5
#define SLAVE 0x7E4

static struct co_rig rig;

static int setup(void **state)
{
    (void)state;
    co_rig_start(&rig);
    return 0;
}

/* A request and its only answer; NULL: none. */
static void ask(const char *request, const char *answer)
{
    co_rig_forget(&rig);
    co_rig_rx(&rig, MASTER, request);
    co_rig_expect_count(&rig, answer == NULL ? 0 : 1);
    if (answer != NULL) {
        co_rig_expect(&rig, 0, SLAVE, answer);
    }
}

#define CONFIGURE "04 01 00 00 00 00 00 00"
#define WAIT "04 00 00 00 00 00 00 00"

static void inquiries_answer_in_configuration_only(void **state)
{
    (void)state;
    ask("5E 00 00 00 00 00 00 00", NULL);
    ask(CONFIGURE, NULL);
    ask("5A 00 00 00 00 00 00 00", "5A 13 00 00 00 00 00 00");
    ask("5B 00 00 00 00 00 00 00", "5B 01 20 68 56 00 00 00");
    ask("5C 00 00 00 00 00 00 00", "5C 6C 00 00 00 00 00 00");
    ask("5D 00 00 00 00 00 00 00", "5D D2 02 96 49 00 00 00");
    ask("5E 00 00 00 00 00 00 00", "5E 3F 00 00 00 00 00 00");
    ask(WAIT, NULL);
    ask("5E 00 00 00 00 00 00 00", NULL);
}

static void nothing_works_in_operational_or_with_a_short_frame(void **state)
{
    (void)state;
    co_rig_rx(&rig, MASTER, "04 01");
    ask("5E 00 00 00 00 00 00 00", NULL);
    co_rig_nmt(&rig, 0x01);
    ask(CONFIGURE, NULL);
    ask("5E 00 00 00 00 00 00 00", NULL);
    co_rig_nmt(&rig, 0x02);
    ask(CONFIGURE, NULL);
    ask("5E 00 00 00 00 00 00 00", "5E 3F 00 00 00 00 00 00");
}

static void selective_switch_wants_the_whole_identity_in_order(void **state)
{
    (void)state;
    ask("40 13 00 00 00 00 00 00", NULL);
    ask("41 01 20 68 56 00 00 00", NULL);
    ask("43 D2 02 96 49 00 00 00", NULL); /* revision left out */
    ask("40 13 00 00 00 00 00 00", NULL);
    ask("41 01 20 68 56 00 00 00", NULL);
    ask("42 6C 00 00 00 00 00 00", NULL);
    ask("43 D3 02 96 49 00 00 00", NULL); /* another serial number */
    ask("40 13 00 00 00 00 00 00", NULL);
    ask("41 01 20 68 56 00 00 00", NULL);
    ask("42 6C 00 00 00 00 00 00", NULL);
    ask("43 D2 02 96 49 00 00 00", "44 00 00 00 00 00 00 00");
    ask("5E 00 00 00 00 00 00 00", "5E 3F 00 00 00 00 00 00");
    ask("04 02 00 00 00 00 00 00", NULL); /* no mode of switch state global */
    ask("5E 00 00 00 00 00 00 00", "5E 3F 00 00 00 00 00 00");
}

/* Behind a part that is another node's all begins with the first one again. */
static void a_part_that_differs_deselects(void **state)
{
    static const char *const other[] = {
        "40 14 00 00 00 00 00 00",
        "41 02 20 68 56 00 00 00",
        "42 6B 00 00 00 00 00 00",
        "43 D1 02 96 49 00 00 00",
    };
    static const char *const own[] = {
        "40 13 00 00 00 00 00 00",
        "41 01 20 68 56 00 00 00",
        "42 6C 00 00 00 00 00 00",
        "43 D2 02 96 49 00 00 00",
    };
    (void)state;
    for (size_t wrong = 0; wrong < DG_COUNT(own); wrong++) {
        for (size_t part = 0; part < DG_COUNT(own); part++) {
            if (part == wrong) {
                ask(other[part], NULL);
            }
            if (part > 0 || wrong > 0) { /* the right first part would begin anew */
                ask(own[part], NULL);
            }
        }
    }
    ask("5E 00 00 00 00 00 00 00", NULL);
}

/* Waiting state, nothing selected or identified by half (CiA 305). */
static void a_reset_begins_anew(void **state)
{
    static const uint8_t resets[] = {0x81, 0x82};
    static const char *const selection[] = {
        "40 13 00 00 00 00 00 00",
        "41 01 20 68 56 00 00 00",
        "42 6C 00 00 00 00 00 00",
        "43 D2 02 96 49 00 00 00",
    };
    static const char *const identification[] = {
        "46 13 00 00 00 00 00 00", "47 01 20 68 56 00 00 00", "48 00 00 00 00 00 00 00",
        "49 FF FF FF FF 00 00 00", "4A 00 00 00 00 00 00 00", "4B FF FF FF FF 00 00 00",
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(resets); i++) {
        ask(CONFIGURE, NULL);
        co_rig_nmt(&rig, resets[i]);
        ask("5E 00 00 00 00 00 00 00", NULL);
        for (size_t cut = 1; cut < DG_COUNT(selection); cut++) {
            for (size_t part = 0; part < DG_COUNT(selection); part++) {
                if (part == cut) {
                    co_rig_nmt(&rig, resets[i]);
                }
                ask(selection[part], NULL);
            }
        }
        for (size_t cut = 1; cut < DG_COUNT(identification); cut++) {
            for (size_t part = 0; part < DG_COUNT(identification); part++) {
                if (part == cut) {
                    co_rig_nmt(&rig, resets[i]);
                }
                ask(identification[part], NULL);
            }
        }
    }
    for (size_t part = 0; part < DG_COUNT(identification); part++) { /* and it works */
        ask(identification[part], part == 5 ? "4F 00 00 00 00 00 00 00" : NULL);
    }
}

static void identify_compares_ranges(void **state)
{
    static const struct {
        const char *low_serial;
        const char *high_serial;
        bool found;
    } rows[] = {
        {"4A 00 00 00 00 00 00 00", "4B FF FF FF FF 00 00 00", true},
        {"4A D2 02 96 49 00 00 00", "4B D2 02 96 49 00 00 00", true},
        {"4A D3 02 96 49 00 00 00", "4B FF FF FF FF 00 00 00", false},
        {"4A 00 00 00 00 00 00 00", "4B D1 02 96 49 00 00 00", false},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        ask("46 13 00 00 00 00 00 00", NULL);
        ask("47 01 20 68 56 00 00 00", NULL);
        ask("48 00 00 00 00 00 00 00", NULL);
        ask("49 6C 00 00 00 00 00 00", NULL);
        ask(rows[i].low_serial, NULL);
        ask(rows[i].high_serial, rows[i].found ? "4F 00 00 00 00 00 00 00" : NULL);
    }
    ask("4C 00 00 00 00 00 00 00", NULL); /* it has a node-ID */
}

/* Each of the six services has its number, and the ends of both ranges are in them. */
static void identify_wants_all_six(void **state)
{
    static const struct {
        const char *request[6];
        bool found;
    } rows[] = {
        {{"46 13", "47 01 20 68 56", "48 6C", "49 6C", "4A D2 02 96 49", "4B D2 02 96 49"}, true},
        {{"46 12", "47 01 20 68 56", "48 6C", "49 6C", "4A D2 02 96 49", "4B D2 02 96 49"}, false},
        {{"46 13", "47 00 20 68 56", "48 6C", "49 6C", "4A D2 02 96 49", "4B D2 02 96 49"}, false},
        {{"46 13", "47 01 20 68 56", "48 6D", "49 6D", "4A D2 02 96 49", "4B D2 02 96 49"}, false},
        {{"46 13", "47 01 20 68 56", "48 6B", "49 6B", "4A D2 02 96 49", "4B D2 02 96 49"}, false},
        {{"46 13", "47 01 20 68 56", "49 6C", "48 6C", "4A D2 02 96 49", "4B D2 02 96 49"}, false},
        {{"46 13", "48 6C", "49 6C", "47 01 20 68 56", "4A D2 02 96 49", "4B D2 02 96 49"}, false},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        for (size_t part = 0; part < 6; part++) {
            char request[32];
            (void)snprintf(request, sizeof request, "%s%s", rows[i].request[part],
                           strlen(rows[i].request[part]) == 5 ? " 00 00 00 00 00 00" : " 00 00 00");
            ask(request, part == 5 && rows[i].found ? "4F 00 00 00 00 00 00 00" : NULL);
        }
    }
}

/* CiA 305: 1 to 127, and 255 for none. */
static void node_ids_have_their_range(void **state)
{
    static const struct {
        const char *request;
        const char *answer;
    } rows[] = {
        {"11 00 00 00 00 00 00 00", "11 01 00 00 00 00 00 00"},
        {"11 01 00 00 00 00 00 00", "11 00 00 00 00 00 00 00"},
        {"11 7F 00 00 00 00 00 00", "11 00 00 00 00 00 00 00"},
        {"11 80 00 00 00 00 00 00", "11 01 00 00 00 00 00 00"},
        {"11 FE 00 00 00 00 00 00", "11 01 00 00 00 00 00 00"},
        {"11 FF 00 00 00 00 00 00", "11 00 00 00 00 00 00 00"},
    };
    (void)state;
    ask(CONFIGURE, NULL);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        ask(rows[i].request, rows[i].answer);
    }
}

static void a_new_node_id_is_in_force_after_waiting_again(void **state)
{
    (void)state;
    ask(CONFIGURE, NULL);
    ask("11 00 00 00 00 00 00 00", "11 01 00 00 00 00 00 00");
    ask("11 80 00 00 00 00 00 00", "11 01 00 00 00 00 00 00");
    ask("11 05 00 00 00 00 00 00", "11 00 00 00 00 00 00 00");
    ask("5E 00 00 00 00 00 00 00", "5E 3F 00 00 00 00 00 00");
    co_rig_forget(&rig);
    co_rig_rx(&rig, MASTER, WAIT);
    co_rig_expect_count(&rig, 1);
    co_rig_expect(&rig, 0, 0x705, "00");
    co_rig_forget(&rig);
    co_rig_rx(&rig, 0x605, "40 01 21 00");
    co_rig_expect(&rig, 0, 0x585, "4F 01 21 00 05 00 00 00");
    /* Not stored: gone with the power. */
    assert_int_equal(co_rig_power_on(&rig), DG_OK);
    assert_int_equal(rig.node.id, 0x3F);
}

static void stored_settings_survive_power_off(void **state)
{
    (void)state;
    ask(CONFIGURE, NULL);
    ask("11 07 00 00 00 00 00 00", "11 00 00 00 00 00 00 00");
    ask("13 00 02 00 00 00 00 00", "13 00 00 00 00 00 00 00");
    ask("17 00 00 00 00 00 00 00", "17 00 00 00 00 00 00 00");
    assert_int_equal(rig.kbaud, 250);
    assert_int_equal(co_rig_power_on(&rig), DG_OK);
    assert_int_equal(rig.node.id, 7);
    assert_int_equal(rig.kbaud, 500);
}

static void a_memory_that_does_not_answer_is_a_media_error(void **state)
{
    (void)state;
    ask(CONFIGURE, NULL);
    rig.nvm.no_acknowledge = true;
    ask("17 00 00 00 00 00 00 00", "17 02 00 00 00 00 00 00");
}

static void bit_timing_knows_its_table(void **state)
{
    static const struct {
        const char *request;
        const char *answer;
    } rows[] = {
        {"13 00 00 00 00 00 00 00", "13 00 00 00 00 00 00 00"},
        {"13 00 01 00 00 00 00 00", "13 01 00 00 00 00 00 00"}, /* 800 kBd */
        {"13 00 05 00 00 00 00 00", "13 01 00 00 00 00 00 00"}, /* reserved */
        {"13 00 08 00 00 00 00 00", "13 00 00 00 00 00 00 00"},
        {"13 00 09 00 00 00 00 00", "13 01 00 00 00 00 00 00"},
        {"13 01 00 00 00 00 00 00", "13 01 00 00 00 00 00 00"}, /* another table */
    };
    (void)state;
    ask(CONFIGURE, NULL);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        ask(rows[i].request, rows[i].answer);
    }
}

/* CiA 305, table 0. */
static void every_bit_rate_comes_into_force(void **state)
{
    static const struct {
        const char *request;
        uint16_t kbaud;
    } rows[] = {
        {"13 00 00 00 00 00 00 00", 1000}, {"13 00 02 00 00 00 00 00", 500},
        {"13 00 03 00 00 00 00 00", 250},  {"13 00 04 00 00 00 00 00", 125},
        {"13 00 06 00 00 00 00 00", 50},   {"13 00 07 00 00 00 00 00", 20},
        {"13 00 08 00 00 00 00 00", 10},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        ask(CONFIGURE, NULL);
        ask(rows[i].request, "13 00 00 00 00 00 00 00");
        ask("17 00 00 00 00 00 00 00", "17 00 00 00 00 00 00 00");
        assert_int_equal(co_rig_power_on(&rig), DG_OK);
        assert_int_equal(rig.kbaud, rows[i].kbaud);
    }
}

static void activation_is_silent_for_two_delays(void **state)
{
    (void)state;
    ask(CONFIGURE, NULL);
    ask("13 00 04 00 00 00 00 00", "13 00 00 00 00 00 00 00");
    ask("15 64 00 00 00 00 00 00", NULL); /* 100 ms */
    co_rig_run(&rig, DG_MS(99));
    ask("5E 00 00 00 00 00 00 00", NULL);
    assert_int_equal(rig.kbaud, 250);
    co_rig_run(&rig, DG_MS(1));
    assert_int_equal(rig.kbaud, 125);
    ask("5E 00 00 00 00 00 00 00", NULL);
    co_rig_run(&rig, DG_MS(100));
    ask("5E 00 00 00 00 00 00 00", "5E 3F 00 00 00 00 00 00");
}

/* The master's side of fastscan (CiA 305): find every bit of the four parts. */
static void scan(uint32_t *identity)
{
    struct dg_can_frame frame = {.id = MASTER, .dlc = 8, .data = {0x51, 0, 0, 0, 0, 0x80, 0, 0}};

    co_rig_forget(&rig);
    (void)dg_co_rx(&rig.node, rig.now, &frame);
    co_rig_expect(&rig, 0, SLAVE, "4F 00 00 00 00 00 00 00");
    for (uint8_t sub = 0; sub < 4; sub++) {
        uint32_t number = 0;
        for (int bit = 31; bit >= 0; bit--) {
            for (uint8_t i = 0; i < 4; i++) {
                frame.data[1 + i] = (uint8_t)(number >> (8 * i));
            }
            frame.data[5] = (uint8_t)bit;
            frame.data[6] = sub;
            frame.data[7] = sub;
            co_rig_forget(&rig);
            (void)dg_co_rx(&rig.node, rig.now, &frame);
            number |= rig.count == 0 ? 1u << bit : 0;
        }
        for (uint8_t i = 0; i < 4; i++) {
            frame.data[1 + i] = (uint8_t)(number >> (8 * i));
        }
        frame.data[5] = 0;
        frame.data[7] = (uint8_t)((sub + 1) % 4);
        co_rig_forget(&rig);
        (void)dg_co_rx(&rig.node, rig.now, &frame);
        co_rig_expect_count(&rig, 1);
        identity[sub] = number;
    }
}

static void fastscan_finds_a_node_without_node_id(void **state)
{
    uint32_t identity[4];
    (void)state;
    ask("51 00 00 00 00 80 00 00", NULL); /* it has one */
    ask(CONFIGURE, NULL);
    ask("11 FF 00 00 00 00 00 00", "11 00 00 00 00 00 00 00");
    ask(WAIT, NULL); /* reset: no boot-up without a node-ID */
    ask("4C 00 00 00 00 00 00 00", "50 00 00 00 00 00 00 00");
    co_rig_rx(&rig, 0, "01 00");
    assert_int_equal(rig.node.state, DG_CO_BOOT);
    ask("51 00 00 00 00 20 00 00", NULL); /* there is no bit 32 */
    ask("51 13 00 00 00 00 04 00", NULL); /* nor a fifth part ... */
    ask("51 13 00 00 00 00 00 04", NULL); /* ... to go on with */
    ask("51 13 00 00 00 00 01 00", NULL); /* it is at the first one */
    scan(identity);
    assert_int_equal(identity[0], 0x13);
    assert_int_equal(identity[1], 0x56682001);
    assert_int_equal(identity[2], 108);
    assert_int_equal(identity[3], 1234567890);
    ask("11 21 00 00 00 00 00 00", "11 00 00 00 00 00 00 00");
    co_rig_forget(&rig);
    co_rig_rx(&rig, MASTER, WAIT);
    co_rig_expect(&rig, 0, 0x721, "00");
    assert_int_equal(rig.node.state, DG_CO_PRE_OPERATIONAL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(inquiries_answer_in_configuration_only, setup),
        cmocka_unit_test_setup(nothing_works_in_operational_or_with_a_short_frame, setup),
        cmocka_unit_test_setup(selective_switch_wants_the_whole_identity_in_order, setup),
        cmocka_unit_test_setup(a_part_that_differs_deselects, setup),
        cmocka_unit_test_setup(a_reset_begins_anew, setup),
        cmocka_unit_test_setup(identify_compares_ranges, setup),
        cmocka_unit_test_setup(identify_wants_all_six, setup),
        cmocka_unit_test_setup(node_ids_have_their_range, setup),
        cmocka_unit_test_setup(a_new_node_id_is_in_force_after_waiting_again, setup),
        cmocka_unit_test_setup(stored_settings_survive_power_off, setup),
        cmocka_unit_test_setup(a_memory_that_does_not_answer_is_a_media_error, setup),
        cmocka_unit_test_setup(bit_timing_knows_its_table, setup),
        cmocka_unit_test_setup(every_bit_rate_comes_into_force, setup),
        cmocka_unit_test_setup(activation_is_silent_for_two_delays, setup),
        cmocka_unit_test_setup(fastscan_finds_a_node_without_node_id, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
