/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/hiperface.h"
#include "serial.h"

/* What the tty gives, and the characters in it; D marks damaged ones. */
static void parity_marks(void **state)
{
    static const uint8_t given[] = {0x40, 0xFF, 0xFF, 0xFF, 0x00, 0x41, 0x00,
                                    0xFF, 0x00, 0x00, 0xFF, 0x00, 0xFF, 0x42};
    static const struct lx_character wanted[] = {
        {0x40, false}, {0xFF, false}, {0x41, true},  {0x00, false},
        {0x00, true},  {0xFF, true},  {0x42, false},
    };
    struct lx_parmrk decoder = {0};
    size_t n = 0;
    (void)state;
    for (size_t i = 0; i < sizeof given; i++) {
        struct lx_character got;
        if (lx_parmrk_feed(&decoder, given[i], &got)) {
            assert_true(n < DG_COUNT(wanted));
            assert_int_equal(got.byte, wanted[n].byte);
            assert_int_equal(got.damaged, wanted[n].damaged);
            n++;
        }
    }
    assert_int_equal(n, DG_COUNT(wanted));
}

/* Every data rate of 57h is one that termios has. */
static void every_data_rate_is_known(void **state)
{
    unsigned known = 0;
    (void)state;
    for (unsigned setting = 0; setting < 256; setting++) {
        struct dg_hf_uart uart;
        if (dg_hf_uart_decode((uint8_t)setting, &uart) != DG_OK) {
            continue;
        }
        assert_true(lx_speed_of_baud(uart.baud) != 0);
        assert_int_equal(lx_baud_of_speed(lx_speed_of_baud(uart.baud)), uart.baud);
        known++;
    }
    assert_true(known > 0);
    assert_int_equal(lx_baud_of_speed(0xFFFF), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parity_marks),
        cmocka_unit_test(every_data_rate_is_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
