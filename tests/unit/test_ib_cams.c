/* SPDX-License-Identifier: MIT */
/* Cams at every boundary and across zero, programs, masks, shift_iw. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "ib_rig.h"

static struct ib_rig rig;

static int set_up(void **state)
{
    (void)state;
    if (ib_rig_init(&rig, dg_ib_model_of(dg_device_find("ocd-ib-k3"))) != DG_OK ||
        ib_rig_power_on(&rig) != DG_OK || ib_rig_send(&rig, 0x20800001) != 0xE0800001) {
        return -1;
    }
    return 0;
}

static void edges(uint32_t cam, uint32_t on, uint32_t off)
{
    assert_int_equal(ib_rig_send(&rig, 0x40000000 | cam << 25 | on), 0xC0000000 | cam << 25 | on);
    assert_int_equal(ib_rig_send(&rig, 0x60000000 | cam << 25 | off), 0xE0000000 | cam << 25 | off);
}

static uint32_t cams_at(int64_t counts)
{
    ib_rig_turn_to(&rig, counts);
    const uint32_t in = ib_rig_cycle(&rig, 0);
    assert_int_equal(in >> 25, 0);
    return in & 0xFF;
}

/* 16 steps in all: every pair of edges at every position. */
static void every_pair_of_edges(void **state)
{
    struct dg_ib_model model = *dg_ib_model_of(dg_device_find("ocd-ib-k3"));

    (void)state;
    model.steps = 16;
    model.turns = 1;
    model.param_cycles = 1;
    assert_int_equal(ib_rig_init(&rig, &model), DG_OK);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
    (void)ib_rig_send(&rig, 0x20800008);
    (void)ib_rig_send(&rig, 0x204000FF);
    for (uint32_t on = 0; on < 16; on++) {
        for (uint32_t off = 0; off < 16; off++) {
            const uint32_t cam = (on + off) % 8;
            edges(cam, on, off);
            (void)ib_rig_release(&rig);
            /* Walk forward from the edge on until the edge off. */
            bool expected[16] = {false};
            for (uint32_t p = on; p != off; p = (p + 1) % 16) {
                expected[p] = true;
            }
            for (uint32_t p = 0; p < 16; p++) {
                assert_int_equal(cams_at(p) >> cam & 1, expected[p]);
            }
        }
    }
}

static void boundaries(void **state)
{
    (void)state;
    edges(0, 0x10, 0x20);
    edges(7, 0xFFFFF0, 0x10);
    edges(3, 0, 0xFFFFFF);
    edges(4, 0x55, 0x55);
    (void)ib_rig_send(&rig, 0x204000FF);
    (void)ib_rig_release(&rig);
    assert_int_equal(cams_at(0x0F), 0x88);
    assert_int_equal(cams_at(0x10), 0x09);
    assert_int_equal(cams_at(0x1F), 0x09);
    assert_int_equal(cams_at(0x20), 0x08);
    assert_int_equal(cams_at(0x55), 0x08);
    assert_int_equal(cams_at(-0x11), 0x08);
    assert_int_equal(cams_at(-0x10), 0x88);
    assert_int_equal(cams_at(-2), 0x88);
    assert_int_equal(cams_at(-1), 0x80);
    assert_int_equal(cams_at(0), 0x88);
}

static void a_cam_needs_both_edges_and_its_bit(void **state)
{
    (void)state;
    (void)ib_rig_send(&rig, 0x204000FF);
    (void)ib_rig_send(&rig, 0x42000000); /* cam 1 on at 0 */
    (void)ib_rig_send(&rig, 0x64000100); /* cam 2 off at 100h */
    edges(5, 0, 0x100);
    (void)ib_rig_release(&rig);
    assert_int_equal(cams_at(5), 0x20);
    (void)ib_rig_send(&rig, 0x62000100);
    (void)ib_rig_release(&rig);
    assert_int_equal(cams_at(5), 0x22);
    (void)ib_rig_send(&rig, 0x204000DF);
    (void)ib_rig_release(&rig);
    assert_int_equal(cams_at(5), 0x02);
}

static void shift_iw(void **state)
{
    (void)state;
    edges(0, 0, 0xFFFFFF);
    (void)ib_rig_send(&rig, 0x20400001);
    ib_rig_turn_to(&rig, 0xABCDEF);
    for (uint32_t shift = 0; shift <= 25; shift++) {
        assert_int_equal(ib_rig_send(&rig, 0x20100000 | shift), 0xE0100000 | shift);
        assert_int_equal(ib_rig_send(&rig, 0x20200030), 0xA0000000 | shift);
        assert_int_equal(ib_rig_send(&rig, 0x20200040), 0xA0000000 | shift);
        assert_int_equal(ib_rig_release(&rig), (0xABCDEFu >> shift & 0x1FFFF) << 8 | 1);
    }
}

/* Programs keep their cams; shift_iw is common. */
static void programs(void **state)
{
    (void)state;
    for (uint32_t p = 1; p <= 8; p++) {
        (void)ib_rig_send(&rig, 0x20800000 | p);
        edges(p - 1, p, 0x100 + p);
        (void)ib_rig_send(&rig, 0x20400000 | 1u << (p - 1));
    }
    (void)ib_rig_send(&rig, 0x20100019);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
    for (uint32_t p = 1; p <= 8; p++) {
        assert_int_equal(ib_rig_send(&rig, 0x20800000 | p), 0xE0800000 | p);
        assert_int_equal(ib_rig_send(&rig, 0x20200000), 0xA0000000 | 1u << (p - 1));
        assert_int_equal(ib_rig_send(&rig, 0x20200010 | (p - 1)), 0xA0000000 | p);
        assert_int_equal(ib_rig_send(&rig, 0x20200020 | (p - 1)), 0xA0000000 | (0x100 + p));
        assert_int_equal(ib_rig_send(&rig, 0x20200010 | (p % 8)), 0xA0000000);
        assert_int_equal(ib_rig_release(&rig), 0);
        assert_int_equal(cams_at(p), 1u << (p - 1));
        ib_rig_turn_to(&rig, 0);
    }
}

/* Edges are checked against the range in force, and the profile's parameters act in cam mode. */
static void the_largest_position(void **state)
{
    (void)state;
    assert_int_equal(ib_rig_send(&rig, 0x40FFFFFF), 0xC0FFFFFF);
    assert_int_equal(ib_rig_send(&rig, 0x02000010), 0xC2000010);
    assert_int_equal(ib_rig_send(&rig, 0x42FFFFFF), 0xC2FFFFFF); /* it waits for the release */
    assert_int_equal(ib_rig_release(&rig) >> 31, 0);
    assert_int_equal(ib_rig_send(&rig, 0x4000FFFF), 0xC000FFFF);
    assert_int_equal(ib_rig_send(&rig, 0x40010000), 0x98000004);
    assert_int_equal(ib_rig_send(&rig, 0x60010000), 0x98000004);
    assert_int_equal(ib_rig_send(&rig, 0x20200010), 0xA000FFFF);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pair_of_edges),
        cmocka_unit_test_setup(boundaries, set_up),
        cmocka_unit_test_setup(a_cam_needs_both_edges_and_its_bit, set_up),
        cmocka_unit_test_setup(shift_iw, set_up),
        cmocka_unit_test_setup(programs, set_up),
        cmocka_unit_test_setup(the_largest_position, set_up),
    };
    return cmocka_run_group_tests_name("cams of an OCD INTERBUS", tests, NULL, NULL);
}
