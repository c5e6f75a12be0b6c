/* SPDX-License-Identifier: MIT */
/*
 * The power fails in every write of every kind of storing access, in every way a write can tear:
 * what was acknowledged is there, what was not is old or new, and nothing else has changed.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "biss_rig.h"
#include "drehgeber/devices.h"

static struct biss_rig rig;
static struct biss_rig fresh;
static unsigned cuts; /* that happened */

static int setup(void **state)
{
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3674-biss"));

    (void)state;
    model.eeprom_read = 0;
    model.eeprom_write = 0;
    if (biss_rig_init(&rig, &model, 1) != DG_OK || biss_rig_power_on(&rig) != DG_OK) {
        return 1;
    }
    rig.words = true;
    fresh = rig;
    cuts = 0;
    return 0;
}

static int get(uint8_t bank, uint8_t address)
{
    rig.slave[0].bank = bank;
    return biss_rig_get(&rig, address);
}

/* The last write counts when it came through before the power failed. */
static void cut_in_user_bank(uint32_t nth, enum ram_nvm_tear tear, uint32_t tear_at)
{
    uint8_t acknowledged = 0xFF;
    uint8_t sent = 0xFF;

    rig = fresh;
    rig.slave[0].bank = 12;
    ram_nvm_cut(&rig.nvm[0], nth, tear, tear_at);
    for (uint8_t value = 1; value < 6 && !rig.nvm[0].dead; value++) {
        sent = value;
        (void)biss_rig_put(&rig, 0x21, value);
        acknowledged = rig.p ? acknowledged : value;
    }
    cuts += rig.nvm[0].dead;
    ram_nvm_restore(&rig.nvm[0]);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    const int found = get(12, 0x21);
    assert_true(found == acknowledged || found == sent);
    assert_int_equal(get(12, 0x20), 0xFF);
    assert_int_equal(get(12, 0x22), 0xFF);
    assert_int_equal(get(11, 0x21), 0xFF);
    assert_int_equal(get(0, 0x69), 0);
    rig.slave[0].bank = 12;
    assert_int_equal(biss_rig_put(&rig, 0x21, 0x77), 1);
    assert_int_equal(get(12, 0x21), 0x77);
}

static void test_user_bank(void **state)
{
    (void)state;
    for (uint32_t tear = 0; tear < RAM_NVM_TEAR_COUNT; tear++) {
        for (uint32_t nth = 0; nth < 20; nth++) {
            for (uint32_t at = 0; at < 72; at += 9) {
                cut_in_user_bank(nth, (enum ram_nvm_tear)tear, at);
            }
        }
    }
    assert_true(cuts == RAM_NVM_TEAR_COUNT * 20u * 8u);
}

/* Nine bytes at once: all new when command 01 had P = 0, otherwise all old or all new. */
static void cut_in_config(uint32_t nth, enum ram_nvm_tear tear, uint32_t tear_at)
{
    static const uint8_t old[9] = {0, 0, 0, 0, 0, 0, 0, 0xFB, 0};
    static const uint8_t new[9] = {0x84, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x7B, 0x88};
    uint8_t found[9] = {0};

    rig = fresh;
    assert_int_equal(biss_rig_write(&rig, 0, 0x1B, new, 9), 9);
    ram_nvm_cut(&rig.nvm[0], nth, tear, tear_at);
    const int stored = biss_rig_put(&rig, 0x60, 0x01);
    const bool dead = rig.nvm[0].dead;
    assert_true(stored == 1 || (dead && stored == BISS_RIG_REFUSED));
    cuts += dead;
    ram_nvm_restore(&rig.nvm[0]);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    assert_int_equal(biss_rig_read(&rig, 0, 0x1B, found, 9), 9);
    const bool is_new = memcmp(found, new, 9) == 0;
    assert_true(is_new || (stored != 1 && memcmp(found, old, 9) == 0));
    assert_int_equal(biss_rig_get(&rig, 0x69), 0);
}

static void test_config(void **state)
{
    (void)state;
    for (uint32_t tear = 0; tear < RAM_NVM_TEAR_COUNT; tear++) {
        for (uint32_t nth = 0; nth < 8; nth++) {
            for (uint32_t at = 0; at < 20; at++) {
                cut_in_config(nth, (enum ram_nvm_tear)tear, at);
            }
        }
    }
    assert_true(cuts > RAM_NVM_TEAR_COUNT * 3u * 20u);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_user_bank, setup),
        cmocka_unit_test_setup(test_config, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
