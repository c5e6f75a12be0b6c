/* SPDX-License-Identifier: MIT */
/*
 * Status registers and the error queue (IEEE 488.2 chapters 10 to 12, SCPI-99 volume 2, 21), and
 * what *OPC, *OPC? and *WAI wait for.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "scpi_private.h"
#include "scpi_rig.h"

static struct scpi_rig rig;

static int set_up(void **state)
{
    (void)state;
    scpi_rig_init(&rig);
    return 0;
}

/* Send a line, compare the answer. */
static void ask(const char *line, const char *answer)
{
    scpi_rig_send(&rig, line);
    assert_string_equal(rig.out, answer);
}

/* 11.5.1: power-on is told once; reading the event register clears it. */
static void power_on(void **state)
{
    (void)state;
    ask("*ESR?;*ESR?;*ESE?;*SRE?;*STB?;:SYST:ERR?\n", "128;0;0;0;0;0,\"No error\"\n");
}

/* SCPI-99 21.8: classes of errors, and the standard's texts. */
static const struct {
    int code;
    unsigned bit;
    const char *text;
} errors[] = {
    {-100, 32, "Command error"},
    {-101, 32, "Invalid character"},
    {-102, 32, "Syntax error"},
    {-104, 32, "Data type error"},
    {-108, 32, "Parameter not allowed"},
    {-109, 32, "Missing parameter"},
    {-113, 32, "Undefined header"},
    {-131, 32, "Invalid suffix"},
    {-151, 32, "Invalid string data"},
    {-199, 32, "Command error"},
    {-200, 16, "Execution error"},
    {-221, 16, "Settings conflict"},
    {-222, 16, "Data out of range"},
    {-224, 16, "Illegal parameter value"},
    {-225, 16, "Out of memory"},
    {-240, 16, "Hardware error"},
    {-241, 16, "Hardware missing"},
    {-250, 16, "Mass storage error"},
    {-256, 16, "File name not found"},
    {-299, 16, "Execution error"},
    {-300, 8, "Device-specific error"},
    {-350, 8, "Queue overflow"},
    {-363, 8, "Input buffer overrun"},
    {-400, 4, "Query error"},
    {-499, 4, "Query error"},
    {-500, 8, "Device-specific error"},
    {-32768, 8, "Device-specific error"},
    {-99, 8, "Device-specific error"},
    {1, 8, "Device-specific error"},
    {32767, 8, "Device-specific error"},
};

static void each_error_has_its_bit_and_text(void **state)
{
    char detail[DG_SCPI_DETAIL_MAX + 1u];
    (void)state;

    memset(detail, 'x', DG_SCPI_DETAIL_MAX);
    detail[DG_SCPI_DETAIL_MAX] = '\0';
    for (size_t i = 0; i < DG_COUNT(errors); i++) {
        char line[64];
        char answer[256];
        (void)snprintf(line, sizeof line, "*CLS;RAIS %d\n*ESR?;:SYST:ERR?\n", errors[i].code);
        (void)snprintf(answer, sizeof answer, "%u;%d,\"%s;%s\"\n", errors[i].bit, errors[i].code,
                       errors[i].text, detail);
        ask(line, answer);
    }
}

/* 21.8.1: first in, first out; what does not fit turns the last entry into -350. */
static void the_queue_overflows(void **state)
{
    (void)state;
    for (unsigned round = 0; round < 3; round++) { /* the ring turns */
        for (unsigned i = 1; i <= DG_SCPI_ERRORS_MAX + 2u; i++) {
            char line[16];
            (void)snprintf(line, sizeof line, "NO%u\n", i);
            ask(line, "");
            assert_int_equal(rig.session.error_count,
                             i < DG_SCPI_ERRORS_MAX ? i : DG_SCPI_ERRORS_MAX);
        }
        ask("SYST:ERR:COUN?\n", "16\n");
        ask("*ESR?\n", round == 0 ? "168\n" : "40\n");
        for (unsigned i = 1; i < DG_SCPI_ERRORS_MAX; i++) {
            char answer[64];
            (void)snprintf(answer, sizeof answer,
                           "-113,\"Undefined header;NO%u; SYSTem:HELP? has all\"\n", i);
            ask("SYST:ERR?\n", answer);
        }
        ask("SYST:ERR:COUN?;NEXT?;NEXT?;COUN?\n", "1;-350,\"Queue overflow\";0,\"No error\";0\n");
        ask("NO\nSYST:ERR?\n", "-113,\"Undefined header;NO; SYSTem:HELP? has all\"\n");
    }
}

static void all_errors_at_once(void **state)
{
    (void)state;
    ask("SYST:ERR:ALL?\n", "0,\"No error\"\n");
    ask("NO;*TST?\nSHAF:POS\nSYST:ERR:ALL?;COUN?\n",
        "-113,\"Undefined header;NO; SYSTem:HELP? has all\",-109,\"Missing parameter;SHAFt:POSition ANGLE\";0\n");
}

/* 11.2: bits of the status byte, each one's mask. */
static void status_byte(void **state)
{
    static const struct {
        const char *line;
        const char *answer;
    } rows[] = {
        {"*CLS;*STB?\n", "0\n"},
        {"NO\n*STB?\n", "4\n"},                  /* the queue is not empty */
        {"*ESE 32;*STB?\n", "36\n"},             /* a command error is an enabled event */
        {"*SRE 32;*STB?\n", "100\n"},            /* which requests service */
        {"*SRE 4;*STB?\n", "100\n"},             /* as the queue may */
        {"*SRE 16;*STB?\n", "36\n"},             /* no answer waits */
        {"*SRE 255;*SRE?;*STB?\n", "191;100\n"}, /* 11.3.2.3: bit 6 is no reason for bit 6 */
        {"*ESE 16;*STB?\n", "68\n"},
        {"*ESE #H20;*ESE?;*STB?\n", "32;100\n"},
        {"*ESR?;*STB?\n", "32;68\n"},
        {"SYST:ERR?;:*STB?\n", "-113,\"Undefined header;NO; SYSTem:HELP? has all\";0\n"},
        {"*ESE 256\n*ESE -1\n*SRE 256\n*ESE?;*SRE?\n", "32;191\n"}, /* 10.10, 10.34: 0 to 255 */
        {"*ESR?;:SYST:ERR:ALL?\n", "16;-222,\"Data out of range;0..255\",-222,\"Data out of "
                                   "range;0..255\",-222,\"Data out of range;0..255\"\n"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        ask(rows[i].line, rows[i].answer);
    }
}

/* 10.3: *CLS clears events and the queue, not the masks. 10.32: *RST clears none of them. */
static void clear_and_reset(void **state)
{
    (void)state;
    ask("*ESE 32;*SRE 4;NO\n*RST;*ESE?;*SRE?;*ESR?;:SYST:ERR:COUN?\n", "32;4;160;1\n");
    assert_int_equal(rig.resets, 1);
    ask("NO\n*CLS;*ESE?;*SRE?;*ESR?;:SYST:ERR:COUN?\n", "32;4;0;0\n");
    assert_int_equal(rig.resets, 1);
}

/* Hosts without anything to reset, and where nothing takes time. */
static void optional_operations(void **state)
{
    struct dg_scpi_setup setup = rig.session.setup;
    const struct dg_scpi_ops ops = {.write = setup.ops->write};
    (void)state;

    setup.ops = &ops;
    dg_scpi_init(&rig.session, &setup);
    ask("*RST;*OPC;*WAI;*OPC?;*ESR?\n", "1;129\n");
    assert_int_equal(rig.resets + rig.asked, 0);
}

static void common_queries(void **state)
{
    (void)state;
    ask("*IDN?\n", "drehgeber,rig,0,1.2.3\n");
    ask("*TST?\n", "0\n");
    ask("SYST:VERS?\n", "1999.0\n");
    ask("SYSTEM:VERSION?\n", "1999.0\n");
}

/* 12.5.2: *OPC tells when all is over, and holds nothing up meanwhile. */
static void operation_complete_event(void **state)
{
    (void)state;
    ask("*CLS;*OPC;*ESR?\n", "1\n"); /* nothing was going on */
    rig.settles = DG_S(2);
    ask("*OPC;*ESR?;*TST?\n", "0;0\n");
    assert_true(dg_scpi_step(&rig.session, DG_S(1)) == DG_S(2));
    ask("*ESR?\n", "0\n");
    rig.settles = DG_S(3); /* the move was made longer: asked again, not forgotten */
    assert_true(dg_scpi_step(&rig.session, DG_S(2)) == DG_S(3));
    assert_true(dg_scpi_step(&rig.session, DG_S(3)) == DG_NEVER);
    ask("*ESR?;*ESR?\n", "1;0\n");
    const unsigned asked = rig.asked;
    assert_true(dg_scpi_step(&rig.session, DG_S(4)) == DG_NEVER);
    assert_int_equal(rig.asked, asked); /* nothing is waited for any more */
}

/* 12.5.2: bytes alone bring the time along, too; *CLS and *RST forget *OPC. */
static void operation_complete_is_forgotten(void **state)
{
    static const char *const forgetters[] = {"*CLS\n", "*RST\n"};
    (void)state;

    for (size_t i = 0; i < DG_COUNT(forgetters); i++) {
        scpi_rig_init(&rig);
        rig.settles = DG_S(2);
        ask("*CLS;*OPC\n", "");
        ask(forgetters[i], "");
        assert_true(dg_scpi_step(&rig.session, DG_S(5)) == DG_NEVER);
        ask("*ESR?\n", "0\n");
    }
    scpi_rig_init(&rig);
    rig.settles = DG_S(2);
    ask("*CLS;*OPC\n", "");
    assert_int_equal(dg_scpi_rx(&rig.session, DG_S(2), "*ESR?\n", 6), 6);
    assert_string_equal(rig.out, "1\n");
}

/* Offer bytes at a time. @return how many are taken */
static size_t offer(dg_ns now, const char *text)
{
    rig.length = 0;
    rig.out[0] = '\0';
    return dg_scpi_rx(&rig.session, now, text, strlen(text));
}

/* 12.5.3: *OPC? answers when all is over; the rest of the line, and the next one, wait. */
static void operation_complete_query(void **state)
{
    static const char line[] = "*TST?;*OPC?;*TST?\n*IDN?\n";
    (void)state;

    ask("*OPC?\n", "1\n");
    rig.settles = DG_S(2);
    assert_int_equal(offer(0, line), 18);
    assert_string_equal(rig.out, "0");
    assert_true(dg_scpi_step(&rig.session, DG_S(1)) == DG_S(2));
    assert_int_equal(dg_scpi_rx(&rig.session, DG_S(1), &line[18], 6), 0);
    assert_string_equal(rig.out, "0");
    assert_true(dg_scpi_step(&rig.session, DG_S(2)) == DG_NEVER);
    assert_string_equal(rig.out, "0;1;0\n");
    assert_int_equal(dg_scpi_rx(&rig.session, DG_S(2), &line[18], 6), 6);
    assert_string_equal(rig.out, "0;1;0\ndrehgeber,rig,0,1.2.3\n");
}

/* 12.5.1: *WAI holds up what follows and answers nothing; bytes that come late are enough. */
static void wait_to_continue(void **state)
{
    (void)state;
    rig.settles = DG_S(1);
    assert_int_equal(offer(0, "*WAI;BYTE 7;*OPC?;BYTE?\nBYTE 8\n"), 24);
    assert_int_equal(rig.values[SCPI_RIG_BYTE], 0);
    assert_int_equal(offer(DG_S(1) - 1, "BYTE 8\n"), 0);
    assert_int_equal(rig.values[SCPI_RIG_BYTE], 0);
    assert_int_equal(offer(DG_S(1), "BYTE 8\n"), 7);
    assert_string_equal(rig.out, "1;7\n");
    assert_int_equal(rig.values[SCPI_RIG_BYTE], 8);
}

/* A line may wait more than once, and for something that began meanwhile. */
static void waiting_twice(void **state)
{
    (void)state;
    rig.settles = DG_S(1);
    (void)offer(0, "*OPC;*OPC?;*ESR?;*WAI;*OPC?\n");
    assert_string_equal(rig.out, "");
    assert_true(dg_scpi_step(&rig.session, DG_MS(500)) == DG_S(1));
    rig.settles = DG_S(2);
    assert_true(dg_scpi_step(&rig.session, DG_S(1)) == DG_S(2));
    assert_string_equal(rig.out, "");
    rig.settles = DG_S(1); /* stopped: sooner than it was said to */
    assert_true(dg_scpi_step(&rig.session, DG_S(1) + 1) == DG_NEVER);
    assert_string_equal(rig.out, "1;129;1\n");
}

/* time.h: an earlier moment is no time at all. */
static void time_never_runs_back(void **state)
{
    (void)state;
    rig.settles = DG_S(2);
    (void)dg_scpi_step(&rig.session, DG_S(2));
    ask("*OPC?\n", "1\n"); /* sent at 0 */
    assert_true(rig.session.now == DG_S(2));
}

/* What never ends is never answered, and costs nothing. */
static void endless(void **state)
{
    (void)state;
    rig.settles = DG_NEVER;
    (void)offer(0, "*OPC?\n");
    assert_true(dg_scpi_step(&rig.session, DG_S(1000)) == DG_NEVER);
    assert_string_equal(rig.out, "");
    assert_true(rig.session.waiting);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(power_on, set_up),
        cmocka_unit_test_setup(each_error_has_its_bit_and_text, set_up),
        cmocka_unit_test_setup(the_queue_overflows, set_up),
        cmocka_unit_test_setup(all_errors_at_once, set_up),
        cmocka_unit_test_setup(status_byte, set_up),
        cmocka_unit_test_setup(clear_and_reset, set_up),
        cmocka_unit_test_setup(optional_operations, set_up),
        cmocka_unit_test_setup(common_queries, set_up),
        cmocka_unit_test_setup(operation_complete_event, set_up),
        cmocka_unit_test_setup(operation_complete_is_forgotten, set_up),
        cmocka_unit_test_setup(operation_complete_query, set_up),
        cmocka_unit_test_setup(wait_to_continue, set_up),
        cmocka_unit_test_setup(waiting_twice, set_up),
        cmocka_unit_test_setup(time_never_runs_back, set_up),
        cmocka_unit_test_setup(endless, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
