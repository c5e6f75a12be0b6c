/* SPDX-License-Identifier: MIT */
/*
 * Pins of an RS485 encoder in a simulator whose master talks otherwise than as delivered.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "hdl.h"

#define US INT64_C(1000000)
#define MS (1000 * US)
#define SECOND (1000 * MS)
#define CHANGES 256u

struct pins {
    struct dg_hdl *encoder;
    int64_t now;
    int rx;
    size_t count; /* of changes of the encoder's outputs */
    int64_t at[CHANGES];
    int outputs[CHANGES];
};

static void look_at_pins(struct pins *self)
{
    const int outputs = dg_hdl_wires(self->encoder, self->now, self->rx) & ~DG_HDL_HINT;

    if (self->count == 0 || outputs != self->outputs[self->count - 1u]) {
        assert_true(self->count < CHANGES);
        self->at[self->count] = self->now;
        self->outputs[self->count++] = outputs;
    }
}

static void pass_time(struct pins *self, int64_t span)
{
    const int64_t end = self->now + span;

    for (int64_t next = dg_hdl_next(self->encoder); next != DG_HDL_NEVER && next < end;
         next = dg_hdl_next(self->encoder)) {
        self->now = next;
        look_at_pins(self);
    }
    self->now = end;
    look_at_pins(self);
}

/* A start bit, 8 bits, one of parity unless it is 'N', a stop bit; the first one is bit 0. */
static unsigned character_of(uint8_t byte, char parity, unsigned *bits)
{
    const unsigned odd = (unsigned)__builtin_popcount(byte) & 1u;
    const unsigned data = (unsigned)byte << 1;

    *bits = parity == 'N' ? 10 : 11;
    return parity == 'N' ? 1u << 9 | data : 1u << 10 | (parity == 'O' ? odd ^ 1u : odd) << 9 | data;
}

static void send_characters(struct pins *self, int64_t baud, char parity, const uint8_t *bytes,
                            size_t n)
{
    for (size_t i = 0; i < n; i++) {
        unsigned bits;
        const unsigned character = character_of(bytes[i], parity, &bits);
        for (unsigned k = 0; k < bits; k++) {
            self->rx = (character >> k & 1u) != 0 ? DG_HDL_RX : 0;
            look_at_pins(self);
            pass_time(self, SECOND / baud);
        }
    }
}

/* The outputs at a moment. */
static int find_outputs(const struct pins *self, int64_t at)
{
    size_t i = self->count - 1u;

    while (i > 0 && self->at[i] > at) {
        i--;
    }
    return self->outputs[i];
}

/* In the middle of each bit, driven; the driver goes off with the last stop bit. */
static void assert_answer(const struct pins *self, int64_t baud, char parity, const uint8_t *bytes,
                          size_t n)
{
    int64_t middle = self->at[1] + SECOND / baud / 2; /* at[0]: nobody sends */

    for (size_t i = 0; i < n; i++) {
        unsigned bits;
        const unsigned character = character_of(bytes[i], parity, &bits);
        for (unsigned k = 0; k < bits; k++) {
            assert_int_equal(find_outputs(self, middle),
                             DG_HDL_DRIVER | ((character >> k & 1u) != 0 ? DG_HDL_TX : 0));
            middle += SECOND / baud;
        }
    }
    assert_in_range(self->at[self->count - 1u], middle - SECOND / baud / 2 - US,
                    middle - SECOND / baud / 2 + US);
    assert_int_equal(self->outputs[self->count - 1u], DG_HDL_TX);
}

static void cycle_supply(struct pins *self)
{
    assert_int_equal(dg_hdl_power(self->encoder, self->now, 0), 0);
    pass_time(self, MS);
    assert_int_equal(dg_hdl_power(self->encoder, self->now, 1), 0);
    pass_time(self, 500 * MS); /* behind the start-up window */
}

/* 57h (5.1.1.2.4, 5.1.2.18): 38400 baud, a timeout of 44 bits, each parity; in force behind the
   next start. A quarter of a turn is 4000h of 65536 steps. */
static void the_pins_have_the_parity_of_the_encoder(void **state)
{
    static const struct {
        uint8_t setting[5];
        char parity;
    } rows[] = {
        {{0x40, 0x57, 0xF6, 0x55, 0xB4}, 'O'},
        {{0x40, 0x57, 0xE6, 0x55, 0xA4}, 'E'},
        {{0x40, 0x57, 0xC6, 0x55, 0x84}, 'N'},
    };
    static const uint8_t request[] = {0x40, 0x42, 0x02};
    static const uint8_t answer[] = {0x40, 0x42, 0x00, 0x00, 0x40, 0x00, 0x42};

    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static struct pins pins;
        memset(&pins, 0, sizeof pins);
        pins.encoder = dg_hdl_open("s3684-rs485", "", "90DEG", "");
        assert_string_equal(dg_hdl_error(pins.encoder), "");
        pins.rx = DG_HDL_RX;
        look_at_pins(&pins); /* power */
        pass_time(&pins, 500 * MS);
        send_characters(&pins, 9600, 'E', rows[i].setting, sizeof rows[i].setting);
        pass_time(&pins, 200 * MS);
        cycle_supply(&pins);
        pins.count = 0;
        send_characters(&pins, 38400, rows[i].parity, request, sizeof request);
        pass_time(&pins, 100 * MS);
        assert_true(pins.count > 2);
        assert_answer(&pins, 38400, rows[i].parity, answer, sizeof answer);
        dg_hdl_close(pins.encoder);
    }
}

/* A character whose parity is not the one that was set is a damaged one: no position. */
static void another_parity_is_a_damaged_character(void **state)
{
    static const uint8_t setting[] = {0x40, 0x57, 0xF4, 0x55, 0xB6}; /* 9600 baud, odd */
    static const uint8_t request[] = {0x40, 0x42, 0x02};
    static const char parities[] = {'O', 'E'};
    static struct pins pins;
    int64_t length[2];

    (void)state;
    pins.encoder = dg_hdl_open("s3684-rs485", "", "90DEG", "");
    pins.rx = DG_HDL_RX;
    look_at_pins(&pins); /* power */
    pass_time(&pins, 500 * MS);
    send_characters(&pins, 9600, 'E', setting, sizeof setting);
    pass_time(&pins, 200 * MS);
    cycle_supply(&pins);
    for (size_t i = 0; i < 2; i++) {
        pins.count = 0;
        send_characters(&pins, 9600, parities[i], request, sizeof request);
        pass_time(&pins, 200 * MS);
        length[i] = pins.count > 1 ? pins.at[pins.count - 1u] - pins.at[1] : 0;
    }
    assert_in_range(length[0] / (SECOND / 9600), 77, 78);
    assert_true(length[1] < 50 * (SECOND / 9600));
    dg_hdl_close(pins.encoder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_pins_have_the_parity_of_the_encoder),
        cmocka_unit_test(another_parity_is_a_damaged_character),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
