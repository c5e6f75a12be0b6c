/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "characters.h"
#include "drehgeber/hiperface.h"
#include "serial.h"

static const uint8_t reply[] = {0x40, 0x43, 0x03};

/* 11 bits at 9600 Bd are 1145833.3 ns; every end is rounded from the start of the reply. */
static void characters_keep_an_absolute_schedule(void **state)
{
    const struct lx_uart uart = {9600, 'E'};
    struct lx_line line = {.sent = 0};
    const uint8_t *bytes = NULL;
    (void)state;
    lx_line_set(&line, &uart);
    assert_true(lx_line_next(&line) == DG_NEVER);
    assert_false(lx_line_busy(&line, 0));
    lx_line_start(&line, 1000, reply, sizeof reply);
    assert_true(lx_line_next(&line) == 1000 + 1145834);
    assert_int_equal(lx_line_take(&line, 1000 + 1145833, &bytes), 0);
    assert_int_equal(lx_line_take(&line, 1000 + 1145834, &bytes), 1);
    assert_int_equal(bytes[0], 0x40);
    assert_true(lx_line_next(&line) == 1000 + 2291667);
    /* late by more than a character: both at once, nothing adds up */
    assert_true(lx_line_busy(&line, 1000 + 3437500));
    assert_int_equal(lx_line_take(&line, 1000 + 4000000, &bytes), 2);
    assert_memory_equal(bytes, reply + 1, 2);
    assert_true(lx_line_next(&line) == DG_NEVER);
    assert_false(lx_line_busy(&line, 1000 + 4000000));
}

static void without_parity_a_character_is_shorter(void **state)
{
    const struct lx_uart uart = {38400, 'N'};
    struct lx_line line = {.sent = 0};
    (void)state;
    lx_line_set(&line, &uart);
    lx_line_start(&line, 0, reply, sizeof reply);
    assert_true(lx_line_next(&line) == 260417); /* 10 / 38400 s */
}

static void a_uart_takes_all_and_stays_busy(void **state)
{
    const struct lx_uart uart = {600, 'O'};
    struct lx_line line = {.sent = 0};
    const uint8_t *bytes = NULL;
    (void)state;
    lx_line_set(&line, &uart);
    lx_line_start(&line, 0, reply, sizeof reply);
    assert_int_equal(lx_line_take_all(&line, &bytes), 3);
    assert_memory_equal(bytes, reply, 3);
    assert_true(lx_line_next(&line) == DG_NEVER);
    assert_true(lx_line_busy(&line, DG_MS(55) - 1)); /* 33 / 600 s */
    assert_false(lx_line_busy(&line, DG_MS(55)));
}

/* A request that is handed over at once takes its time on the line all the same. */
static void requests_take_the_time_of_their_characters(void **state)
{
    static struct lx_intake intake;
    const struct lx_coming coming = {.character = {.byte = 0x40}, .baud = 9600};
    (void)state;
    assert_true(lx_intake_next(&intake) == DG_NEVER && lx_intake_last(&intake) == DG_NEVER);
    for (int i = 0; i < 3; i++) {
        assert_true(lx_intake_put(&intake, 1000, 1146, &coming));
    }
    assert_true(lx_intake_next(&intake) == 1000 + 1146);
    assert_true(lx_intake_last(&intake) == 1000 + 3 * 1146);
    assert_true(lx_intake_take(&intake).end == 1000 + 1146);
    assert_true(lx_intake_take(&intake).end == 1000 + 2 * 1146);
    /* On a busy line a character waits for its turn, on an idle one it begins at once. */
    assert_true(lx_intake_put(&intake, 4000, 1146, &coming));
    assert_true(lx_intake_take(&intake).end == 1000 + 3 * 1146);
    const struct lx_coming fourth = lx_intake_take(&intake);
    assert_true(fourth.end == 1000 + 4 * 1146);
    assert_int_equal(fourth.character.byte, 0x40);
    assert_int_equal(fourth.baud, 9600);
    assert_true(lx_intake_next(&intake) == DG_NEVER);
    assert_true(lx_intake_put(&intake, 9000, 1146, &coming));
    assert_true(lx_intake_next(&intake) == 9000 + 1146);
}

static void a_flood_is_cut_off(void **state)
{
    static struct lx_intake intake;
    (void)state;
    for (unsigned i = 0; i < LX_INTAKE_MAX; i++) {
        const struct lx_coming coming = {.character = {.byte = (uint8_t)i}};
        assert_true(lx_intake_put(&intake, 0, 10, &coming));
    }
    const struct lx_coming more = {.character = {.byte = 0xEE}};
    assert_false(lx_intake_put(&intake, 0, 10, &more));
    assert_true(lx_intake_last(&intake) == 10u * LX_INTAKE_MAX);
    for (unsigned i = 0; i < LX_INTAKE_MAX; i++) {
        const struct lx_coming coming = lx_intake_take(&intake);
        assert_int_equal(coming.character.byte, (uint8_t)i);
        assert_true(coming.end == 10u * (i + 1u));
    }
    assert_true(lx_intake_put(&intake, 0, 10, &more));
    assert_int_equal(lx_intake_take(&intake).character.byte, 0xEE);
}

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
            assert_true(n < sizeof wanted / sizeof wanted[0]);
            assert_int_equal(got.byte, wanted[n].byte);
            assert_int_equal(got.damaged, wanted[n].damaged);
            n++;
        }
    }
    assert_int_equal(n, sizeof wanted / sizeof wanted[0]);
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
        cmocka_unit_test(characters_keep_an_absolute_schedule),
        cmocka_unit_test(without_parity_a_character_is_shorter),
        cmocka_unit_test(a_uart_takes_all_and_stays_busy),
        cmocka_unit_test(requests_take_the_time_of_their_characters),
        cmocka_unit_test(a_flood_is_cut_off),
        cmocka_unit_test(parity_marks),
        cmocka_unit_test(every_data_rate_is_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
