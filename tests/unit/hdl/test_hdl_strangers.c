/* SPDX-License-Identifier: MIT */
/*
 * Protocols that the models for simulators have never heard of: a clocked one is clocked, all else
 * is refused by its name.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "hdl.h"
#include "strangers.h"

#define US INT64_C(1000000)

/* 25 bits in Gray code, the first one behind the first falling edge: a quarter of a turn. */
static void a_clocked_stranger_is_clocked(void **state)
{
    struct dg_hdl *self = dg_hdl_open(STRANGER_EDGES, "", "90DEG", "");
    uint32_t bits = 0;
    int64_t now = 100 * US;

    (void)state;
    assert_string_equal(dg_hdl_error(self), "");
    (void)dg_hdl_wires(self, 0, DG_HDL_CLOCK);
    (void)dg_hdl_wires(self, now, DG_HDL_CLOCK);
    for (int i = 0; i < 25; i++) {
        (void)dg_hdl_wires(self, now += US, 0);
        (void)dg_hdl_wires(self, now += US, DG_HDL_CLOCK);
        bits = bits << 1 | (uint32_t)(dg_hdl_wires(self, now + US / 2, DG_HDL_CLOCK) & DG_HDL_DATA);
    }
    assert_int_equal(bits, (1 << 11) ^ (1 << 10));
    assert_int_equal(dg_hdl_latched(self), 1 << 11);
    dg_hdl_close(self);
}

/* Without a data rate there is no UART for characters; the others have no pins here. */
static void other_strangers_are_refused_by_name(void **state)
{
    static const char *const rows[][2] = {
        {STRANGER_CHARACTERS, "stranger-characters speaks unknown-characters; "},
        {STRANGER_FRAMES, "stranger-frames speaks unknown-frames; "},
        {STRANGER_WORDS, "stranger-words speaks unknown-words; "},
        {STRANGER_FUTURE, "stranger-future speaks unknown-future; "},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_hdl *self = dg_hdl_open(rows[i][0], "", "", "");
        assert_non_null(strstr(dg_hdl_error(self), rows[i][1]));
        dg_hdl_close(self);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_clocked_stranger_is_clocked),
        cmocka_unit_test(other_strangers_are_refused_by_name),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
