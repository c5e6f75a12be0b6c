/* SPDX-License-Identifier: MIT */
/*
 * The library's masters of clocked lines, with encoders on a wire: registers over control frames of
 * BiSS, and what they say of frames.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/bus_master.h"
#include "drehgeber/devices.h"
#include "drehgeber/ssi.h"
#include "edges_rig.h"
#include "ssi_private.h"

#define LINE_MAX 200u
#define TURN ((int64_t)1 << 32)

static struct dg_bus_master master;
static char line[LINE_MAX];
static char noted[LINE_MAX];
static enum dg_severity severity;

static void keep_note(void *ctx, const struct dg_tap_event *event)
{
    (void)ctx;
    if (event->kind == DG_TAP_NOTE) {
        struct dg_text to = dg_text_in(noted, sizeof noted);
        dg_text_add(&to, event->note);
        severity = event->severity;
    }
}

static struct dg_bus_master_setup setup_of(const struct dg_master_protocol *protocol)
{
    return (struct dg_bus_master_setup){
        .size = sizeof(struct dg_bus_master_setup),
        .protocol = protocol,
        .clock_hz = 1000000,
    };
}

static void begin(const struct dg_master_protocol *protocol, size_t encoders)
{
    const struct dg_bus_master_setup setup = setup_of(protocol);
    const struct dg_bus_edges_setup wire = dg_bus_master_wire(&setup);

    edges_rig_begin(&wire, encoders);
    edges_rig.ops.tap = keep_note;
    noted[0] = '\0';
}

/* All encoders have been attached, and have power. */
static void begin_master(const struct dg_master_protocol *protocol)
{
    struct dg_bus_master_setup setup = setup_of(protocol);

    setup.bus = edges_rig.bus;
    dg_bus_master_init(&master, &setup, edges_rig.now);
    dg_bus_master_pause(&master, READY);
}

static void put_on(size_t place, const char *model, const char *key, const char *value)
{
    struct dg_host *host = edges_rig_model(place, model);

    (void)dg_host_set(host, "busy_jitter_us", "0");
    if (key != NULL) {
        assert_int_equal(dg_host_set(host, key, value), DG_HOST_OK);
    }
    edges_rig_attach(place);
    edges_rig_power(place, true);
}

/* One of two, so that texts have names. */
static void begin_chain(const char *key, const char *value)
{
    begin(&dg_biss_master, 2);
    put_on(0, "s3684-biss", key, value);
    put_on(1, "s3674-biss", NULL, NULL);
    begin_master(&dg_biss_master);
}

static int read_registers(size_t place, uint8_t address, uint8_t *got, size_t n)
{
    struct dg_biss_access access = {.place = place, .address = address, .got = got, .n = n};
    const int result = dg_biss_access(&master, &access);

    return result < 0 ? result : (int)access.done;
}

static int write_registers(size_t place, uint8_t address, const uint8_t *sent, size_t n)
{
    struct dg_biss_access access = {.place = place, .address = address, .sent = sent, .n = n};
    const int result = dg_biss_access(&master, &access);

    return result < 0 ? result : (int)access.done;
}

/* ------------------------------------------------------------ registers */

static void registers_are_read(void **state)
{
    uint8_t bytes[64];
    (void)state;
    begin_chain(NULL, NULL);
    assert_int_equal(read_registers(0, 0x78, bytes, 8), 8);
    assert_memory_equal(bytes, "\x04\x00\xCC\x15\x00\x00\x4B\x55", 8); /* 5.2.1.3 */
    assert_string_equal(noted, "s3684-biss: register 78h = 04 00 CC 15 00 00 4B 55");
    assert_int_equal(severity, DG_SEVERITY_OK);
    assert_int_equal(read_registers(1, 0x41, bytes, 3), 3);
    assert_memory_equal(bytes, "\x03\x62\x17", 3);
    assert_string_equal(noted, "s3674-biss: register 41h = 03 62 17");
}

/* A note has room for some; a bank has 64. */
static void registers_are_written(void **state)
{
    static const uint8_t bank = 8;
    uint8_t sent[64];
    uint8_t got[64] = {0};
    (void)state;
    begin_chain(NULL, NULL);
    for (size_t i = 0; i < sizeof sent; i++) {
        sent[i] = (uint8_t)(0xFFu - 3u * i);
    }
    assert_int_equal(write_registers(0, 0x40, &bank, 1), 1);
    assert_string_equal(noted, "s3684-biss: register 40h = 08");
    assert_int_equal(write_registers(0, 0, sent, sizeof sent), sizeof sent);
    assert_memory_equal(noted, "s3684-biss: register 00h = FF FC F9", 35);
    assert_int_equal(read_registers(0, 0, got, sizeof got), sizeof got);
    assert_memory_equal(got, sent, sizeof sent);
}

static void refused_registers_are_named(void **state)
{
    static const uint8_t sent[2] = {1, 2};
    uint8_t bytes[8];
    (void)state;
    begin_chain(NULL, NULL);
    assert_int_equal(read_registers(0, 0x48, bytes, 1), DG_BISS_REFUSED);
    assert_string_equal(noted, "s3684-biss: register 48h: refused: not implemented or protected");
    assert_int_equal(severity, DG_SEVERITY_ERROR);
    assert_int_equal(read_registers(0, 0x46, bytes, 4), DG_BISS_REFUSED); /* 46h, 47h are there */
    assert_string_equal(noted, "s3684-biss: register 48h: refused: not implemented or protected");
    assert_int_equal(write_registers(0, 0x78, sent, 2), DG_BISS_REFUSED);
    begin_chain("stop_bit", "early");
    assert_int_equal(read_registers(0, 0x46, bytes, 2), 2);
    assert_int_equal(read_registers(0, 0x46, bytes, 4), DG_BISS_REFUSED);
}

/* Who has no power says nothing; who has is not there alone. */
static void nobody_answers_without_power(void **state)
{
    uint8_t bytes[2];
    char text[LINE_MAX];
    const struct dg_biss_access access = {.address = 0x78, .got = bytes, .n = 2};
    (void)state;
    begin(&dg_biss_master, 1);
    put_on(0, "s3684-biss", NULL, NULL);
    edges_rig_power(0, false);
    begin_master(&dg_biss_master);
    assert_int_equal(read_registers(0, 0x78, bytes, 2), DG_BISS_SILENT);
    assert_string_equal(noted, "register 78h: no answer");
    dg_biss_access_explain(&master, &access, DG_BISS_TOO_BUSY, text, sizeof text);
    assert_string_equal(text, "register 78h: busy for more than 20 ms");
    dg_biss_access_explain(&master, &access, DG_BISS_DAMAGED, text, sizeof text);
    assert_string_equal(text, "register 78h: wrong check sum");
}

/* Of each access under faults a master has the right bytes, or says that it has none. */
static void damaged_frames_are_no_registers(void **state)
{
    static const enum dg_wire_fault faults[] = {DG_WIRE_DAMAGE, DG_WIRE_DROP, DG_WIRE_DELAY,
                                                DG_WIRE_TEAR, DG_WIRE_BREAK};
    uint8_t bytes[8];
    unsigned failed = 0;
    (void)state;
    for (size_t i = 0; i < DG_COUNT(faults); i++) {
        begin_chain(NULL, NULL);
        edges_rig_bend(0, faults[i], 0);
        dg_bus_master_pause(&master, master.now + DG_MS(1));
        const int result = read_registers(0, 0x78, bytes, 8);
        assert_true(result < 0 || result == 8);
        failed += result < 0 ? 1u : 0u;
        edges_rig_heal(0);
        dg_bus_master_pause(&master, master.now + DG_S(1));
        assert_int_equal(read_registers(0, 0x78, bytes, 8), 8);
        assert_memory_equal(bytes, "\x04\x00\xCC\x15\x00\x00\x4B\x55", 8);
    }
    assert_true(failed >= 2);
}

/* ------------------------------------------------------------ frames, in words */

static const char *print_line(size_t place)
{
    struct dg_text to = dg_text_in(line, sizeof line);

    dg_bus_master_read(&master);
    master.setup.protocol->line(&master, place, &to);
    return line;
}

static void a_frame_has_a_line(void **state)
{
    (void)state;
    begin_chain(NULL, NULL);
    dg_host_shaft(edges_rig.place[0].host, 0, 5 * TURN + TURN / 4, 0);
    /* e1, e2, start bit, CDS, and the data of both */
    assert_int_equal(dg_biss_master.rises(edges_rig.bus),
                     4u + dg_biss_frame_bits(dg_bus_settings(edges_rig.bus, 0)) +
                         dg_biss_frame_bits(dg_bus_settings(edges_rig.bus, 1)));
    (void)print_line(0);
    (void)print_line(0); /* it was latched with the shaft there */
    assert_memory_equal(line, "MT 5  ST ", 9);
    assert_non_null(strstr(line, "  90.000000 deg  nERR 1  nWARN 1  LC "));
    assert_non_null(strstr(line, "  CRC valid"));
    assert_int_equal(dg_biss_master.judge(&master, 0), DG_MASTER_GOOD);
    edges_rig_bend(0, DG_WIRE_DAMAGE, 0);
    dg_bus_master_pause(&master, master.now + DG_MS(1));
    assert_non_null(strstr(print_line(0), "  CRC WRONG"));
    assert_int_equal(dg_biss_master.judge(&master, 0), DG_MASTER_WRONG);
}

/* To the nearest one, from the middle to the even one. */
static void angles_are_rounded(void **state)
{
    static const struct {
        uint32_t singleturn;
        uint8_t bits;
        const char *said;
    } rows[] = {
        {0, 13, "MT 7  ST 0  0.000000 deg"},
        {1, 13, "MT 7  ST 1  0.043945 deg"},          /* .0439453 */
        {8191, 13, "MT 7  ST 8191  359.956055 deg"},  /* .9560546 */
        {1, 10, "MT 7  ST 1  0.351562 deg"},          /* .3515625: even */
        {3, 10, "MT 7  ST 3  1.054688 deg"},          /* .0546875: even */
        {1, 16, "MT 7  ST 1  0.005493 deg"},          /* .0054931 */
        {65535, 16, "MT 7  ST 65535  359.994507 deg"} /* .9945068 */
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_text to = dg_text_in(line, sizeof line);
        dg_master_line_position(&to, 7, rows[i].singleturn, rows[i].bits);
        assert_string_equal(line, rows[i].said);
    }
}

/* What the bits of a layout say stands behind the position. */
static void a_word_tells_the_bits_of_its_layout(void **state)
{
    static const struct {
        const char *layout;
        const char *said;
    } rows[] = {
        {"PT", "  toggle "},
        {"PF", "  power fail 0"},
        {"PTFE", "  power fail 0"},
        {"P", "MT 0  ST 0"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_ssi_form form = dg_ssi_any_form;
        struct dg_ssi_model figures = *(const struct dg_ssi_model *)dg_ssi_25.model;
        struct dg_device model = dg_ssi_25;
        (void)strcpy(form.layout, rows[i].layout);
        figures.form = &form;
        model.model = &figures;
        begin(&dg_ssi_master, 1);
        (void)edges_rig_make(&edges_rig.place[0], &model, dg_bus_side_of(&dg_ssi_25),
                             &dg_ssi_instrument);
        edges_rig_attach(0);
        edges_rig_power(0, true);
        begin_master(&dg_ssi_master);
        assert_non_null(strstr(print_line(0), rows[i].said));
        assert_true((strstr(line, "toggle") != NULL) == (strchr(rows[i].layout, 'T') != NULL));
        assert_true((strstr(line, "power fail") != NULL) == (strchr(rows[i].layout, 'F') != NULL));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(registers_are_read),
        cmocka_unit_test(registers_are_written),
        cmocka_unit_test(refused_registers_are_named),
        cmocka_unit_test(nobody_answers_without_power),
        cmocka_unit_test(damaged_frames_are_no_registers),
        cmocka_unit_test(a_frame_has_a_line),
        cmocka_unit_test(angles_are_rounded),
        cmocka_unit_test(a_word_tells_the_bits_of_its_layout),
    };
    return cmocka_run_group_tests_name("bus_masters", tests, NULL, NULL);
}
