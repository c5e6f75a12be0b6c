/* SPDX-License-Identifier: MIT */
/*
 * What happens to a world or a wire, and what an encoder that answers with eleven characters says
 * then: its catalogue, row by row.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "drehgeber/control.h"
#include "drehgeber/eleven.h"
#include "host_rig.h"

static struct host_rig_place panel_place;

/* What it answers to one question; the wire's faults happen to a whole reply. */
static uint8_t answers(struct dg_host *self, uint64_t at, struct dg_host_event *reply)
{
    const struct dg_host_event request = {
        .at = at, .kind = DG_HOST_BYTES, .length = 1, .data = {dg_eleven_request(0)}};

    *reply = (struct dg_host_event){.length = 0};
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    (void)dg_host_step(self, at + 10 * MS);
    (void)dg_host_receive(self, reply);
    return reply->length;
}

static void every_fault_is_seen_and_goes(void **state)
{
    static const char *const names[] = {"singleturn_lost", "wire_drop", "wire_deaf", "wire_delay",
                                        "wire_damage"};
    struct dg_host *self = host_rig_start(&host_rig_here, "eleven-24");
    struct dg_host_panel *panel =
        dg_host_panel_make(panel_place.bytes, sizeof panel_place.bytes, self);
    struct dg_host_event good;
    struct dg_host_event bad;
    uint64_t at = READY;

    (void)state;
    assert_non_null(panel);
    assert_int_equal(dg_eleven_instrument.fault_count, DG_COUNT(names));
    for (size_t i = 0; i < DG_COUNT(names); i++) {
        assert_int_equal(answers(self, at += SECOND, &good), DG_ELEVEN_REPLY);
        assert_int_equal(dg_eleven_check(good.data, DG_ELEVEN_REPLY), 0);
        assert_int_equal(dg_host_fault_set(panel, at, names[i], true), DG_HOST_OK);
        (void)answers(self, at += SECOND, &bad);
        switch (i) {
        case 0:
            assert_int_equal(bad.data[4], DG_ELEVEN_LOST);
            break;
        case 1:
        case 2:
            assert_int_equal(bad.length, 0);
            break;
        case 3:
            assert_true(bad.at - at > MS);
            break;
        default:
            assert_int_not_equal(dg_eleven_check(bad.data, DG_ELEVEN_REPLY), 0);
            break;
        }
        assert_int_equal(dg_host_fault_set(panel, at, names[i], false), DG_HOST_OK);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {cmocka_unit_test(every_fault_is_seen_and_goes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
