/* SPDX-License-Identifier: MIT */
/*
 * The master inside a handle of BiSS: registers that are late, refused, silent; and where time
 * ends. Frames and answers as 5.2.2 and the protocol description have them.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "host_rig.h"
#include "ram_nvm.h"

#define BANK 0x40
#define USER 7
/* Most that a register access may take (protocol description, table 2). */
#define BUSY_MAX (20 * MS)

static struct ram_nvm ram;

static struct dg_host *started(const char *key, const char *value)
{
    struct dg_host *self = host_rig_make(&host_rig_here, "s3684-biss");

    assert_int_equal(dg_host_set(self, key, value), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    (void)dg_host_step(self, READY);
    return self;
}

static void choose_bank(struct dg_host *self, uint64_t *now, uint8_t bank)
{
    assert_int_equal(dg_host_registers_write(self, now, BANK, &bank, 1), 1);
}

/* At 1 MHz: 3 us to the start bit, CDS and 47 bits (5.2.1), the timeout of 13 us from the last
 * rising edge on, and MA is high for a period before the next frame may begin. With CDM = 1 the
 * last edge is half a period later. */
static void a_frame_takes_its_clocks(void **state)
{
    const uint64_t period = 1000;
    const uint64_t whole = 3 * period + 48 * period + 13000 + period;
    struct dg_host *self = started("busy_us", "3");
    struct dg_host_frame frame;
    uint64_t now = 2 * READY;
    uint8_t byte;

    (void)state;
    assert_int_equal(dg_host_frame(self, READY, &frame), DG_HOST_OK);
    assert_int_equal(frame.at, READY);
    assert_int_equal(frame.count, 47);
    assert_int_equal(frame.end - frame.at, whole);
    assert_int_equal(dg_host_frame(self, frame.end, &frame), DG_HOST_OK);
    /* 47 frames for a byte, of which 10 have CDM = 1. */
    assert_int_equal(dg_host_registers_read(self, &now, 0x78, &byte, 1), 1);
    assert_int_equal(now - 2 * READY, 47 * whole + 10 * (period / 2));
}

static void a_register_that_is_busy_is_waited_for(void **state)
{
    static const uint8_t written[3] = {0x12, 0x34, 0x56};
    struct dg_host *self = started("eeprom_write_us", "19000");
    uint8_t bytes[3] = {0};
    uint64_t now = READY;

    (void)state;
    choose_bank(self, &now, USER);
    assert_int_equal(dg_host_registers_write(self, &now, 0x3D, written, 3), 3);
    const uint64_t begun = now;
    assert_int_equal(dg_host_registers_read(self, &now, 0x3D, bytes, 3), 3);
    assert_memory_equal(bytes, written, sizeof written);
    /* What is left of the last write's 19 ms. */
    assert_in_range(now - begun, 18 * MS, BUSY_MAX + 4 * MS);
}

/* A frame of a slow line may take longer than a register, which is there in the next one. */
static void a_slow_line_finds_it_in_its_next_frame(void **state)
{
    struct dg_host *self = started("timeout_us", "30000");
    const uint8_t written = 0x77;
    uint8_t byte = 0;
    uint64_t now = READY;

    (void)state;
    choose_bank(self, &now, USER);
    assert_int_equal(dg_host_registers_write(self, &now, 0, &written, 1), 1);
    assert_int_equal(dg_host_registers_read(self, &now, 0, &byte, 1), 1);
    assert_int_equal(byte, 0x77);
}

/* A byte that the host's EEPROM does not give never becomes ready. */
static void a_byte_that_never_comes_is_silence(void **state)
{
    struct dg_host *self = host_rig_make(&host_rig_here, "s3684-biss");
    const struct dg_nvm nvm = ram_nvm_port(&ram);
    struct dg_host_frame frame;
    uint8_t byte = 0;
    uint64_t now = READY;

    (void)state;
    ram_nvm_init(&ram, sizeof ram.bytes);
    assert_int_equal(dg_host_memory_port(self, &nvm), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    (void)dg_host_step(self, READY);
    choose_bank(self, &now, USER);
    ram.no_acknowledge = true;
    const uint64_t begun = now;
    assert_int_equal(dg_host_registers_read(self, &now, 0, &byte, 1), DG_HOST_ERR_SILENT);
    assert_in_range(now - begun, BUSY_MAX, BUSY_MAX + 10 * MS);
    /* The line itself works. */
    assert_int_equal(dg_host_frame(self, now, &frame), DG_HOST_OK);
    now = frame.end;
    assert_int_equal(dg_host_registers_read(self, &now, 0x78, &byte, 1), 1);
    assert_int_equal(byte, 0x04);
}

/* 22h and 23h are the last ones of bank 0, with the stop bit of either kind. */
static void what_follows_the_last_register_is_not_counted(void **state)
{
    static const char *const kinds[] = {"own", "early"};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(kinds); i++) {
        struct dg_host *self = started("stop_bit", kinds[i]);
        uint8_t bytes[4] = {0xFB, 0x04, 0x11, 0x22};
        uint64_t now = READY;
        assert_int_equal(dg_host_registers_write(self, &now, 0x22, bytes, 4), 2);
        memset(bytes, 0, sizeof bytes);
        assert_int_equal(dg_host_registers_read(self, &now, 0x22, bytes, 4), 2);
        assert_true(bytes[0] == 0xFB && bytes[1] == 0x04);
        assert_int_equal(dg_host_registers_read(self, &now, 0x24, bytes, 1), DG_HOST_ERR_REFUSED);
    }
}

/* Its own stop bit refuses the first byte, which then is not counted: nothing was written. */
static void a_byte_that_cannot_be_stored_is_refused(void **state)
{
    struct dg_host *self = started("autostore", "1");
    uint8_t byte = 0x04;
    uint64_t now = READY;

    (void)state;
    assert_int_equal(dg_host_world_set(self, now, "eeprom_acknowledges", 0), DG_HOST_OK);
    assert_int_equal(dg_host_registers_write(self, &now, 0x23, &byte, 1), DG_HOST_ERR_REFUSED);
    choose_bank(self, &now, USER);
    assert_int_equal(dg_host_registers_read(self, &now, 0, &byte, 1), DG_HOST_ERR_REFUSED);
}

/* While it initialises nERR and nWARN are low (choice 19 of its page). */
static void a_frame_says_when_it_was_latched(void **state)
{
    struct dg_host *self = host_rig_make(&host_rig_here, "s3684-biss");
    struct dg_host_frame frame;
    uint64_t at = 0;
    uint64_t counts = 0;

    (void)state;
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_int_equal(dg_host_latched(self, &at, &counts), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_frame(self, MS, &frame), DG_HOST_OK);
    assert_true(frame.good == 1 && frame.error == 1 && frame.warning == 1 && frame.at == MS);
    assert_int_equal(dg_host_latched(self, &at, &counts), DG_HOST_OK);
    assert_int_equal(at, MS);
    assert_int_equal(dg_host_frame(self, READY, &frame), DG_HOST_OK);
    assert_true(frame.good == 1 && frame.error == 0 && frame.warning == 0 && frame.at == READY);
    assert_int_equal(dg_host_latched(self, &at, &counts), DG_HOST_OK);
    assert_int_equal(at, READY);
}

/* 7Fh ends the identification; an address has seven bits. */
static void the_last_address_is_7f(void **state)
{
    struct dg_host *self = started("serial", "1");
    uint8_t bytes[2] = {0};
    uint64_t now = READY;

    (void)state;
    assert_int_equal(dg_host_registers_read(self, &now, 0x7F, bytes, 1), 1);
    assert_int_equal(bytes[0], 0x55); /* the second half of the manufacturer's id */
    assert_int_equal(dg_host_registers_read(self, &now, 0x80, bytes, 1), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_registers_write(self, &now, 0x7F, bytes, 1), DG_HOST_ERR_REFUSED);
    assert_int_equal(dg_host_registers_write(self, &now, 0x80, bytes, 1), DG_HOST_ERR_ARGUMENT);
}

static void a_call_that_cannot_be_changes_nothing(void **state)
{
    struct dg_host *self = started("serial", "1");
    uint8_t bytes[DG_BISS_BANK_SIZE + 1u] = {0};
    struct dg_host_frame frame;
    uint64_t now = READY;

    (void)state;
    assert_int_equal(dg_host_registers_read(self, &now, 0, bytes, sizeof bytes),
                     DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_registers_write(self, &now, 0, bytes, sizeof bytes),
                     DG_HOST_ERR_ARGUMENT);
    assert_int_equal(now, READY);
    /* In the middle of a frame of a master outside, and with MA low behind it. */
    assert_int_equal(dg_host_clock(self, now, false), 0);
    assert_int_equal(dg_host_registers_read(self, &now, 0x78, bytes, 1), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_frame(self, now, &frame), DG_HOST_ERR_STATE);
    (void)dg_host_step(self, READY + MS);
    now = READY + MS;
    assert_int_equal(dg_host_registers_read(self, &now, 0x78, bytes, 1), DG_HOST_ERR_STATE);
    (void)dg_host_clock(self, now, true);
    (void)dg_host_step(self, READY + 2 * MS);
    assert_int_equal(dg_host_registers_read(self, &now, 0x78, bytes, 1), 1);
    /* Other protocols have none. */
    self = host_rig_start(&host_rig_there, "ssi-25");
    assert_int_equal(dg_host_registers_read(self, &now, 0x78, bytes, 1), DG_HOST_ERR_WIRE);
    assert_int_equal(dg_host_registers_write(self, &now, 0x78, bytes, 1), DG_HOST_ERR_WIRE);
}

/* Behind the last moment there is no timeout, so no frame either; nothing goes on for ever, and
 * time does not go back. */
static void an_access_ends_where_time_ends(void **state)
{
    const uint64_t step = 29989;
    unsigned silent = 0;
    unsigned whole = 0;

    (void)state;
    for (uint64_t left = 1; left < 15 * MS; left += step) {
        struct dg_host *self = started("busy_us", "40");
        const uint64_t begun = UINT64_MAX - left;
        uint64_t now = begun;
        uint8_t bytes[2] = {0};
        const int result = dg_host_registers_read(self, &now, 0x78, bytes, 2);
        assert_true(result == 2 || result == DG_HOST_ERR_SILENT);
        assert_true(now >= begun);
        silent += result == 2 ? 0 : 1;
        whole += result == 2 ? 1 : 0;
        if (result == 2) {
            assert_int_equal(bytes[0], 0x04);
        }
    }
    assert_true(silent > 10 && whole > 10);
}

static void a_frame_ends_where_time_ends(void **state)
{
    static const char *const names[] = {"s3684-biss", "ssi-25"};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(names); i++) {
        for (uint64_t left = 1; left < 100000; left += 997) {
            struct dg_host *self = host_rig_start(&host_rig_here, names[i]);
            struct dg_host_frame frame = {0};
            const int result = dg_host_frame(self, UINT64_MAX - left, &frame);
            assert_int_equal(result, DG_HOST_OK);
            assert_true(frame.end >= UINT64_MAX - left);
            assert_int_equal(dg_host_step(self, UINT64_MAX - 1), DG_HOST_NEVER);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_takes_its_clocks),
        cmocka_unit_test(a_register_that_is_busy_is_waited_for),
        cmocka_unit_test(a_slow_line_finds_it_in_its_next_frame),
        cmocka_unit_test(a_byte_that_never_comes_is_silence),
        cmocka_unit_test(what_follows_the_last_register_is_not_counted),
        cmocka_unit_test(a_byte_that_cannot_be_stored_is_refused),
        cmocka_unit_test(a_frame_says_when_it_was_latched),
        cmocka_unit_test(the_last_address_is_7f),
        cmocka_unit_test(a_call_that_cannot_be_changes_nothing),
        cmocka_unit_test(an_access_ends_where_time_ends),
        cmocka_unit_test(a_frame_ends_where_time_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
