/* SPDX-License-Identifier: MIT */
/*
 * What a handle says is due next, and what is not there to be set.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "host_rig.h"

/* A segmented upload of 1008h that nobody goes on with: after 1 s the node aborts it, and waits for
   its supervision, every 100 ms, again. */
static void a_node_waits_on_after_a_timeout(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    const uint64_t asked = READY + 7 * MS;
    const struct dg_host_event ask = {
        .at = asked, .id = 0x63F, .kind = DG_HOST_CAN, .length = 8, .data = {0x40, 0x08, 0x10}};
    static const uint8_t timeout[] = {0x80, 0x08, 0x10, 0x00, 0x00, 0x00, 0x04, 0x05};
    struct dg_host_event event;

    (void)state;
    host_rig_drain(self);
    assert_int_equal(dg_host_send(self, &ask), DG_HOST_OK);
    (void)dg_host_step(self, asked);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.data[0], 0x41);
    (void)dg_host_step(self, asked + 995 * MS);
    assert_int_equal(dg_host_next(self), asked + 1000 * MS);
    assert_int_equal(dg_host_step(self, asked + 1000 * MS), READY + 1100 * MS);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.id, 0x5BF);
    assert_memory_equal(event.data, timeout, sizeof timeout);
    assert_int_equal(dg_host_receive(self, &event), 0);
}

/* The same after an answer that had to wait for the EEPROM: 1010h:1 "save" takes 14 ms. */
static void a_node_waits_on_after_a_save(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    const uint64_t asked = READY + 7 * MS;
    const struct dg_host_event ask = {.at = asked,
                                      .id = 0x63F,
                                      .kind = DG_HOST_CAN,
                                      .length = 8,
                                      .data = {0x23, 0x10, 0x10, 0x01, 0x73, 0x61, 0x76, 0x65}};
    struct dg_host_event event;

    (void)state;
    host_rig_drain(self);
    assert_int_equal(dg_host_send(self, &ask), DG_HOST_OK);
    assert_int_equal(dg_host_step(self, asked), asked + 14 * MS);
    assert_int_equal(dg_host_receive(self, &event), 0);
    assert_int_equal(dg_host_step(self, asked + 14 * MS), READY + 100 * MS);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.data[0], 0x60);
}

static bool has_key(const char *model, const char *name)
{
    const struct dg_host *self = host_rig_make(&host_rig_here, model);
    struct dg_host_key key;
    bool has = false;

    for (size_t i = 0; dg_host_key(self, i, &key) == DG_HOST_OK; i++) {
        has = has || strcmp(key.name, name) == 0;
    }
    return has;
}

/* A singleturn has no bits of turns to be set. */
static void what_a_model_has_not_cannot_be_set(void **state)
{
    struct dg_host *self;

    (void)state;
    assert_true(has_key("f3668", "mt_bits"));
    assert_false(has_key("f3658", "mt_bits"));
    assert_true(has_key("f3658", "node"));
    self = host_rig_make(&host_rig_here, "f3658");
    assert_int_equal(dg_host_set(self, "mt_bits", "16"), DG_HOST_ERR_NAME);
    self = host_rig_make(&host_rig_here, "f3668");
    assert_int_equal(dg_host_set(self, "mt_bits", "16"), DG_HOST_OK);
}

/* Ten minutes are the longest an SSI encoder may take. */
static void ssi_initialises_for_ten_minutes_at_most(void **state)
{
    struct dg_host *self = host_rig_make(&host_rig_here, "ssi-25");

    (void)state;
    assert_int_equal(dg_host_set(self, "init_ms", "600001"), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_set(self, "init_ms", "600000"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_int_equal(dg_host_next(self), 600 * SECOND);
}

/* How far a fault bends the world: an LED that is regulated up to 40 mA, half the peak of a signal
   (src/control/README.md). */
static void faults_bend_the_world_so_far(void **state)
{
    static const struct {
        const char *model;
        const char *fault;
        const char *quantity;
        int64_t value;
    } rows[] = {
        {"s3684-rs485", "led_current_high", "led_current_ua", 40000},
        {"s3684-biss", "led_current_high", "led_current_ua", 40000},
        {"ssi-28", "led_current_high", "led_current_ua", 40000},
        {"f3668", "led_current_high", "led_current_ua", 40000},
        {"s3684-rs485", "sin_offset", "sin_offset_permille", 500},
        {"s3684-rs485", "cos_offset", "cos_offset_permille", 500},
        {"s3684-biss", "sin_offset", "sin_offset_permille", 500},
        {"s3684-biss", "cos_offset", "cos_offset_permille", 500},
        {"s3684-biss", "sin_amplitude_low", "sin_amplitude_permille", 500},
        {"s3684-biss", "cos_amplitude_low", "cos_amplitude_permille", 500},
        {"ssi-28", "sin_offset", "sin_offset_permille", 500},
        {"ssi-28", "cos_offset", "cos_offset_permille", 500},
    };
    static struct host_rig_place place;

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_host *self = host_rig_start(&host_rig_here, rows[i].model);
        struct dg_host_panel *panel = dg_host_panel_make(&place, sizeof place, self);
        int64_t value = 0;
        assert_non_null(panel);
        assert_int_equal(dg_host_fault_set(panel, READY, rows[i].fault, true), DG_HOST_OK);
        assert_int_equal(dg_host_world_get(self, rows[i].quantity, &value), DG_HOST_OK);
        assert_int_equal(value, rows[i].value);
    }
}

/* A panel is made in memory of any content: before the first cycle of words there was none. */
static void a_panel_takes_its_memory_as_it_is(void **state)
{
    static struct host_rig_place place;
    const struct dg_host_event words = {.at = READY + MS, .kind = DG_HOST_WORDS};

    (void)state;
    for (int content = 0; content <= 0xFF; content += 0xFF) {
        struct dg_host *self = host_rig_start(&host_rig_here, "ocd-ib-k2");
        struct dg_host_event torn;
        char answer[64];
        memset(&place, content, sizeof place);
        struct dg_host_panel *panel = dg_host_panel_make(&place, sizeof place, self);
        assert_non_null(panel);
        assert_int_equal(
            dg_host_scpi(panel, READY, "FAUL:SET wire_tear,COUN 1", answer, sizeof answer), 0);
        host_rig_drain(self);
        assert_int_equal(dg_host_send(self, &words), DG_HOST_OK);
        (void)dg_host_panel_step(panel, READY + MS);
        assert_int_equal(dg_host_receive(self, &torn), 1);
        assert_int_equal(torn.length, 4);
        assert_int_equal(torn.data[0] << 8 | torn.data[1], 0);
        assert_int_equal(torn.data[2] << 8 | torn.data[3], 3 * 4096 + 1024);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_node_waits_on_after_a_timeout),
        cmocka_unit_test(a_node_waits_on_after_a_save),
        cmocka_unit_test(what_a_model_has_not_cannot_be_set),
        cmocka_unit_test(ssi_initialises_for_ten_minutes_at_most),
        cmocka_unit_test(faults_bend_the_world_so_far),
        cmocka_unit_test(a_panel_takes_its_memory_as_it_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
