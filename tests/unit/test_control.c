/* SPDX-License-Identifier: MIT */
/*
 * The control plane's commands for encoders, shafts, the world, power, time, traces and BiSS, each
 * with its errors, against a host that remembers what it was asked for.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "control_rig.h"
#include "drehgeber/instruments.h"

#define QUARTER (DG_TURN / 4)

static struct control_rig rig;

static int setup(void **state)
{
    (void)state;
    control_rig_start(&rig);
    return 0;
}

static void expect(const char *line, const char *answer)
{
    control_rig_expect(&rig, line, answer);
}

static void refuse(const char *line, const char *error, const char *text)
{
    control_rig_refuse(&rig, line, error, text);
}

static void select_encoder(const char *name)
{
    char line[32];

    (void)snprintf(line, sizeof line, "INST:SEL %s", name);
    expect(line, "");
}

/* ------------------------------------------------------------ the session */

/* An instrument's own commands are there when the rig has that instrument, whatever is selected. */
static void test_commands_of_instruments(void **state)
{
    (void)state;
    select_encoder("hf");
    assert_non_null(strstr(control_rig_say(&rig, "SYST:HELP?"), "\"BISS:FRAMe?\""));
    rig.rig.instruments = NULL;
    rig.rig.instrument_count = 0;
    assert_null(strstr(control_rig_say(&rig, "SYST:HELP?"), "BISS"));
    assert_non_null(strstr(control_rig_say(&rig, "SYST:HELP?"), "TRACe:LAST? [N]"));
    select_encoder("biss-1");
    refuse("BISS:FRAM?", "-113", NULL);
    rig.rig.instruments = &dg_instruments[1];
    rig.rig.instrument_count = 1;
    refuse("BISS:FRAM?", "-240", "no data");
}

static void test_identity(void **state)
{
    (void)state;
    const char *idn = control_rig_say(&rig, "*IDN?");
    assert_int_equal(strncmp(idn, "drehgeber,rig,0,", 16), 0);
    assert_true(strlen(idn) > 16);
    rig.rig.encoder_count = 1;
    dg_control_init(&rig.control, &rig.rig, rig.control.write, rig.control.ctx);
    idn = control_rig_say(&rig, "*IDN?");
    assert_int_equal(strncmp(idn, "drehgeber,s3684-rs485,0,", 24), 0);
}

static void test_encoders(void **state)
{
    (void)state;
    expect("INST:CAT?", "\"hf\",\"biss-1\",\"can\",\"k3\",\"k2\"");
    expect("INSTrument:SELect?", "\"hf\"");
    expect("INST:MOD?", "\"s3684-rs485\"");
    expect("INST:WIRE?", "\"pty:/dev/pts/4\"");
    expect("INST:SEL CAN", "");
    expect("INST:SEL?;MOD?;WIRE?", "\"can\";\"f3668\";\"can:vcan0/63\"");
    expect("INST:SEL \"biss-1\";SEL?", "\"biss-1\"");
    refuse("INST:SEL nobody", "-224", "nobody");
    refuse("INST:SEL", "-109", NULL);
    expect("INST:SEL?", "\"biss-1\"");
}

/* A rig file takes a-1 and a_1 for two names. */
static void test_names_alike(void **state)
{
    (void)state;
    expect("INST:SEL Biss_1;SEL?", "\"biss-1\"");
    rig.encoders[3]->name = "biss_1";
    expect("INST:SEL BISS_1;SEL?", "\"biss_1\"");
    expect("INST:SEL \"biss-1\";SEL?", "\"biss-1\"");
}

/* Each client has its own selection. */
static void test_two_clients(void **state)
{
    struct dg_control other;

    (void)state;
    dg_control_init(&other, &rig.rig, rig.control.write, rig.control.ctx);
    select_encoder("k3");
    rig.length = 0;
    assert_int_equal(dg_control_rx(&other, rig.now, "INST:SEL?\n", 10), 10);
    assert_string_equal(rig.answer, "\"hf\"\n");
    expect("INST:SEL?", "\"k3\"");
}

/* ------------------------------------------------------------ shafts */

static void test_shaft_names(void **state)
{
    (void)state;
    expect("SHAF:CAT?", "\"main\",\"geared\"");
    expect("SHAF:NAME?", "\"main\"");
    select_encoder("k2");
    expect("SHAF:NAME?", "\"geared\"");
}

static void test_position(void **state)
{
    (void)state;
    expect("SHAF:POS?", "0.000000");
    expect("SHAF:POS 90", "");
    assert_int_equal(dg_shaft_angle(&rig.shaft[0].shaft, rig.now), QUARTER);
    assert_int_equal(rig.changes, 1);
    assert_null(rig.changed);
    expect("SHAF:POS -33.3 DEG;POS?", "-33.300000");
    expect("SHAF:POS 2.5REV;POS?", "900.000000");
    expect("SHAF:POS -0.000001;POS?", "-0.000001");
    expect("SHAF:POS MAX;POS?", "386547056640.000000");
    expect("SHAF:POS MIN;POS?", "-386547056640.000000");
    refuse("SHAF:POS 2E9REV", "-222", NULL);
    refuse("SHAF:POS", "-109", NULL);
    refuse("SHAF:POS 1RPM", "-131", NULL);
    refuse("SHAF:POS 1,2", "-108", NULL);
}

/* 9 degrees are no whole number of 2^-32 turn: what is next to them is shown as them. */
/* A node is misspelt rather than too many. */
static void test_headers_that_are_near(void **state)
{
    static const struct {
        const char *line;
        const char *near;
    } rows[] = {
        {"SYST:ERR:CUNT?", "closest is SYSTem:ERRor:COUNt?"},
        {"TIME:SCLE?", "closest is TIME:SCALe?"},
        {"TIME:ORGIN?", "closest is TIME:ORIGin?"},
        {"WORL:TEMP:PROF:STT?", "closest is WORLd:TEMPerature:PROFile:STATe?"},
        {"WORL:LED:CURR:PRF?", "closest is WORLd:LED:CURRent:PROFile?"},
        {"WORL:TEMP:X?", "closest is WORLd:TEMPerature?"},
        {"FAUL:ST x", "closest is FAULt:SET NAME"},
        {"PO?", "closest is POWer?"},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        refuse(rows[i].line, "-113", rows[i].near);
    }
}

static void test_position_is_the_nearest(void **state)
{
    static const struct {
        dg_angle angle;
        const char *degrees;
    } rows[] = {
        {QUARTER / 10, "9.000000"},
        {QUARTER / 10 + 1, "9.000000"},
        {-(QUARTER / 10), "-9.000000"},
        {-1, "0.000000"},
        {-6, "-0.000001"},
        {5, "0.000000"},
        {6, "0.000001"},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_int_equal(dg_shaft_set_position(&rig.shaft[0].shaft, rig.now, rows[i].angle), DG_OK);
        expect("SHAF:POS?", rows[i].degrees);
    }
}

static void test_velocity(void **state)
{
    (void)state;
    expect("SHAF:VEL?", "0.000");
    expect("SHAF:VEL 60.5RPM;VEL?", "60.500");
    rig.now += DG_S(60);
    expect("SHAF:POS?", "21780.000000");
    expect("SHAF:VEL -3000;VEL?", "-3000.000");
    refuse("SHAF:VEL 1000001", "-222", NULL);
    expect("SHAF:STOP;VEL?", "0.000");
    expect("SHAF:MOV?", "0");
}

static void test_acceleration(void **state)
{
    (void)state;
    expect("SHAF:ACC?", "0.000");
    expect("SHAF:ACC 600RPM/S;ACC?", "600.000");
    expect("SHAF:VEL 60;MOV?", "1");
    rig.now += DG_MS(50);
    expect("SHAF:VEL?;MOV?", "30.000;1");
    rig.now += DG_MS(50);
    expect("SHAF:VEL?;MOV?", "60.000;0");
    expect("SHAF:STOP;MOV?", "1");
    rig.now += DG_MS(100);
    expect("SHAF:VEL?;MOV?", "0.000;0");
    refuse("SHAF:ACC -1", "-222", NULL);
    refuse("SHAF:ACC 1000000001", "-222", NULL);
}

static void test_move(void **state)
{
    (void)state;
    expect("SHAF:MOVE 180DEG;MOV?", "1"); /* half a turn at 60 rpm */
    rig.now += DG_MS(500) - 1;
    expect("SHAF:MOV?", "1");
    rig.now += 1;
    expect("SHAF:MOV?;POS?", "0;180.000000");
    expect("SHAF:MOVE 0,600RPM", "");
    rig.now += DG_MS(50);
    expect("SHAF:MOV?;POS?", "0;0.000000");
    refuse("SHAF:MOVE 90,0", "-222", NULL);
    refuse("SHAF:MOVE 90,-1", "-222", NULL);
    refuse("SHAF:MOVE", "-109", NULL);
    rig.now += DG_MS(50);
    expect("SHAF:MOV?;POS?", "0;0.000000"); /* what is refused moves nothing */
}

static void test_waiting_for_a_move(void **state)
{
    (void)state;
    assert_string_equal(control_rig_say(&rig, "SHAF:MOVE 360;*OPC?;POS?"), "");
    assert_int_equal(dg_control_step(&rig.control, rig.now), rig.now + DG_S(1));
    assert_int_equal(dg_control_rx(&rig.control, rig.now, "SHAF:POS?\n", 10), 0);
    rig.now += DG_S(1);
    assert_int_equal(dg_control_step(&rig.control, rig.now), DG_NEVER);
    assert_string_equal(rig.answer, "1;360.000000\n");
    expect("SHAF:POS?", "360.000000");
}

/* What is played never ends, and *OPC? does not wait for it. */
static void test_nobody_waits_for_a_profile(void **state)
{
    const struct dg_motion turn = {.kind = DG_MOTION_SPEED, .mrpm = 60000};

    (void)state;
    assert_int_equal(dg_shaft_play(&rig.shaft[0].shaft, rig.now, &turn), DG_OK);
    expect("SHAF:MOV?", "1");
    expect("*OPC?", "1");
}

static void test_geared_shaft(void **state)
{
    (void)state;
    select_encoder("k2");
    refuse("SHAF:VEL 1", "-221", "geared");
    refuse("SHAF:STOP", "-221", "geared");
    refuse("SHAF:MOVE 1", "-221", "geared");
    refuse("SHAF:ACC 1", "-221", "geared");
    assert_int_equal(rig.changes, 0);
    expect("SHAF:POS 10;POS?", "10.000000");
    expect("INST:SEL hf;:SHAF:VEL 60;:INST:SEL k2;:SHAF:VEL?", "30.000");
    rig.now += DG_S(1);
    expect("SHAF:POS?", "190.000000");
    expect("INST:SEL hf;:SHAF:MOVE 0;:INST:SEL k2;:SHAF:MOV?", "1");
}

static void test_profile(void **state)
{
    (void)state;
    expect("SHAF:PROF \"sine:90DEG,2S\"", "");
    assert_string_equal(rig.call, "profile");
    assert_ptr_equal(rig.whom, &rig.shaft[0]);
    assert_string_equal(rig.text, "sine:90DEG,2S");
    assert_int_equal(rig.changes, 1);
    expect("SHAF:PROF?", "\"sine:90DEG,2S\"");
    rig.result = DG_SCPI_ILLEGAL;
    refuse("SHAF:PROF nonsense", "-224", "as profile says");
    assert_int_equal(rig.changes, 1);
    refuse("SHAF:PROF", "-109", NULL);
    rig.ops.profile = NULL;
    rig.ops.profile_text = NULL;
    refuse("SHAF:PROF x", "-241", NULL);
    refuse("SHAF:PROF?", "-241", NULL);
}

static void test_recording(void **state)
{
    (void)state;
    expect("SHAF:REC:STAR \"a b.csv\"", "");
    assert_string_equal(rig.call, "record");
    assert_ptr_equal(rig.whom, &rig.shaft[0]);
    assert_string_equal(rig.text, "a b.csv");
    assert_int_equal(rig.number[0], DG_MS(1));
    expect("SHAFt:RECord:STARt \"x.csv\",250US", "");
    assert_int_equal(rig.number[0], DG_US(250));
    expect("SHAF:REC:STOP", "");
    assert_string_equal(rig.text, "NULL");
    refuse("SHAF:REC:STAR", "-109", NULL);
    refuse("SHAF:REC:STAR x.csv,99US", "-222", NULL);
    refuse("SHAF:REC:STAR x.csv,99.999US", "-222", NULL);
    refuse("SHAF:REC:STAR x.csv,3600.001S", "-222", "3600000");
    expect("SHAF:REC:STAR x.csv,100US", "");
    assert_int_equal(rig.number[0], DG_US(100));
    expect("SHAF:REC:STAR x.csv,3600S", "");
    assert_int_equal(rig.number[0], DG_S(3600));
    rig.result = DG_SCPI_FILE_NAME;
    refuse("SHAF:REC:STAR x.csv", "-256", "as record says");
    rig.ops.record = NULL;
    refuse("SHAF:REC:STAR x.csv", "-241", NULL);
    refuse("SHAF:REC:STOP", "-241", NULL);
}

/* ------------------------------------------------------------ the world */

/* clang-format off */
static const struct {
    const char *header;
    const char *healthy;
    const char *given;
    const char *then;
    const char *beyond;
} quantities[] = {
    {"WORLd:TEMPerature",          "37.000", "-12.5DEGC", "-12.500", "1000.001"},
    {"WORL:LED:CURR",              "12000",  "31MA",      "31000",   "-1"},
    {"WORL:SUPP",                  "5000",   "4.5V",      "4500",    "100001"},
    {"WORL:BATT",                  "3610",   "2400",      "2400",    "101V"},
    {"WORLd:AMPLitude:SIN",        "1000",   "600",       "600",     "2001"},
    {"WORL:AMPL:COS",              "1000",   "1400",      "1400",    "-1"},
    {"WORLd:OFFSet:SIN",           "0",      "-100",      "-100",    "-1001"},
    {"WORL:OFFS:COS",              "0",      "100",       "100",     "1001"},
    {"WORLd:SINGleturn",           "1",      "OFF",       "0",       NULL},
    {"WORLd:MULTiturn:AMPLitude",  "1",      "0",         "0",       NULL},
    {"WORL:MULT:SYNC",             "1",      "off",       "0",       NULL},
    {"WORL:MULT:VECT",             "1",      "OFF",       "0",       NULL},
    {"WORLd:EEPRom",               "1",      "OFF",       "0",       NULL},
    {"WORLd:WATChdog",             "0",      "ON",        "1",       NULL},
};
/* clang-format on */
#define QUANTITIES DG_COUNT(quantities)

static void say_quantity(size_t i, const char *format, const char *value, const char *answer)
{
    char line[80];

    (void)snprintf(line, sizeof line, format, quantities[i].header, value);
    expect(line, answer);
}

static void test_every_quantity(void **state)
{
    struct dg_world healthy;
    char line[80];

    (void)state;
    select_encoder("can");
    for (size_t i = 0; i < QUANTITIES; i++) {
        say_quantity(i, "%s?%s", "", quantities[i].healthy);
        const unsigned before = rig.changes;
        say_quantity(i, "%s %s", quantities[i].given, "");
        assert_int_equal(rig.changes, before + 1u);
        assert_ptr_equal(rig.changed, &rig.encoder[CONTROL_RIG_CAN]);
        say_quantity(i, "%s?%s", "", quantities[i].then);
        (void)snprintf(line, sizeof line, "%s %s", quantities[i].header,
                       quantities[i].beyond == NULL ? "maybe" : quantities[i].beyond);
        refuse(line, quantities[i].beyond == NULL ? "-224" : "-222", NULL);
        assert_int_equal(rig.changes, before + 1u);
    }
    expect("WORL:DEF", "");
    dg_world_init(&healthy);
    healthy.angle = rig.co.world.angle;
    healthy.angle_ctx = rig.co.world.angle_ctx;
    assert_memory_equal(&healthy, &rig.co.world, sizeof healthy);
    for (size_t i = 0; i < QUANTITIES; i++) {
        say_quantity(i, "%s?%s", "", quantities[i].healthy);
    }
}

static void test_worlds_are_apart(void **state)
{
    (void)state;
    expect("WORL:TEMP 50", "");
    assert_int_equal(rig.hf.world.temperature_mdegc, 50000);
    assert_int_equal(rig.biss.world.temperature_mdegc, 37000);
}

/* ------------------------------------------------------------ power */

static void test_power(void **state)
{
    (void)state;
    for (size_t i = 0; i < CONTROL_RIG_ENCODERS; i++) {
        const struct dg_encoder *encoder = &rig.encoder[i];
        select_encoder(encoder->name);
        expect("POW?", "1");
        expect("POW OFF", "");
        assert_false(dg_encoder_powered(encoder));
        assert_ptr_equal(rig.changed, encoder);
        expect("POW?", "0");
        expect("POWer ON;POW?", "1");
        assert_true(dg_encoder_powered(encoder));
        expect("POW 0;POW?;POW 1;POW?", "0;1");
    }
    refuse("POW", "-109", NULL);
    refuse("POW MAYBE", "-224", NULL);
    refuse("POW OFF OFF", "-108", NULL);
    expect("POW?", "1");
}

/* A cycle begins anew, ON does not. */
static void test_power_cycle(void **state)
{
    (void)state;
    rig.now += DG_S(5);
    (void)dg_hf_step(&rig.hf.device, rig.now);
    expect("POW ON", "");
    assert_int_equal(rig.hf.device.window_end, DG_NEVER);
    assert_int_equal(rig.changes, 0);
    expect("POW CYCL", "");
    assert_int_equal(rig.hf.device.window_end, rig.now + DG_MS(100));
    assert_int_equal(rig.changes, 1);
}

static void test_foreign_memory(void **state)
{
    (void)state;
    rig.hf.nvm.bytes[0] ^= 1u;
    rig.hf.nvm.bytes[12] ^= 1u;
    refuse("POW CYCLE", "-240", "hf: its EEPROM is another device's");
    expect("POW?", "0");
    memset(rig.hf.nvm.bytes, 0xFF, rig.hf.nvm.size);
    refuse("POW ON", "-240", "hf: its EEPROM is blank");
    expect("POW?;:NVM:ERAS;:POW ON;POW?", "0;1");
}

/* ------------------------------------------------------------ time, traces */

static void test_time(void **state)
{
    (void)state;
    rig.now = DG_S(12) + 345;
    expect("TIME?", "12.000000345");
    expect("TIME:ORIG?", "0.000000000");
    rig.rig.origin = DG_MS(2500);
    expect("TIME?;:TIME:ORIG?", "9.500000345;2.500000000");
    rig.rig.origin = 0;
    expect("TIME:SCAL 0.5", "");
    assert_int_equal(rig.number[0], 500);
    expect("TIME:SCAL?", "0.500");
    expect("TIME:SCAL MAX;SCAL?", "1000.000");
    refuse("TIME:SCAL -1", "-222", NULL);
    expect("TIME:STEP 20US", "");
    assert_int_equal(rig.number[0], 20000);
    refuse("TIME:STEP -1", "-222", NULL);
    rig.result = DG_SCPI_CONFLICT;
    refuse("TIME:SCAL 0", "-221", "as scale says");
    refuse("TIME:STEP 1S", "-221", "as step says");
    rig.ops.set_scale = NULL;
    rig.ops.scale = NULL;
    rig.ops.step = NULL;
    refuse("TIME:SCAL 1", "-241", NULL);
    refuse("TIME:SCAL?", "-241", NULL);
    refuse("TIME:STEP 1", "-241", NULL);
}

static void test_trace(void **state)
{
    (void)state;
    select_encoder("can");
    expect("TRAC:STAR \"/tmp/a.log\"", "");
    assert_string_equal(rig.call, "trace");
    assert_ptr_equal(rig.whom, &rig.encoder[CONTROL_RIG_CAN]);
    assert_string_equal(rig.text, "/tmp/a.log");
    expect("TRACe:STOP", "");
    assert_string_equal(rig.text, "NULL");
    refuse("TRAC:STAR", "-109", NULL);
    rig.result = DG_SCPI_FILE_NAME;
    refuse("TRAC:STAR a.txt", "-256", "as trace says");
    rig.ops.trace = NULL;
    refuse("TRAC:STAR a.log", "-241", NULL);
    refuse("TRAC:STOP", "-241", NULL);
}

static void test_last_frames(void **state)
{
    (void)state;
    expect("TRAC:LAST?", "\"\"");
    rig.lines = 3;
    expect("TRAC:LAST?", "\"line 0\"");
    expect("TRAC:LAST? 2", "\"line 1\",\"line 0\"");
    expect("TRAC:LAST? 100", "\"line 2\",\"line 1\",\"line 0\"");
    refuse("TRAC:LAST? 0", "-222", NULL);
    refuse("TRAC:LAST? 101", "-222", NULL);
    rig.ops.last = NULL;
    refuse("TRAC:LAST?", "-241", NULL);
}

static void test_severities_of_last_frames(void **state)
{
    (void)state;
    expect("TRAC:LAST:SEV?", "\"\"");
    rig.lines = 4;
    expect("TRAC:LAST:SEV?", "OK");
    expect("TRAC:LAST:SEV? 9", "ERROR,WARNING,NOTICE,OK");
    expect("TRAC:LAST? 2;LAST:SEV? 2", "\"line 1\",\"line 0\";NOTICE,OK");
    refuse("TRAC:LAST:SEV? 0", "-222", NULL);
    rig.ops.last = NULL;
    refuse("TRAC:LAST:SEV?", "-241", NULL);
}

/* ------------------------------------------------------------ BiSS */

static void test_frame(void **state)
{
    (void)state;
    rig.now += DG_S(1);
    expect("SHAF:POS 2.5REV", "");
    select_encoder("biss-1");
    for (unsigned life = 0; life < 2; life++) {
        char answer[40];
        rig.frame_bits = dg_biss_frame(&rig.biss.slave[0], rig.now, &rig.frame);
        (void)snprintf(answer, sizeof answer, "5242880,1,1,%u,1", life);
        expect("BISS:FRAM?", answer);
    }
    assert_string_equal(rig.call, "frame");
    assert_ptr_equal(rig.whom, &rig.encoder[CONTROL_RIG_BISS]);
    rig.biss.world.watchdog_fired = true;
    rig.frame_bits = dg_biss_frame(&rig.biss.slave[0], rig.now, &rig.frame);
    expect("BISS:FRAM?", "5242880,0,1,2,1");
    rig.frame ^= 1u << 20;
    expect("BISS:FRAM?", "5242944,0,1,2,0");
}

static void test_frame_without_life_counter(void **state)
{
    (void)state;
    rig.biss.model.life_counter = false;
    rig.now += DG_S(1);
    select_encoder("biss-1");
    rig.frame_bits = dg_biss_frame(&rig.biss.slave[0], rig.now, &rig.frame);
    expect("BISS:FRAM?", "0,1,1,0,1");
}

static void test_frame_without_data(void **state)
{
    (void)state;
    select_encoder("biss-1");
    rig.frame_bits = 1;
    refuse("BISS:FRAM?", "-240", "biss-1: no data");
    rig.result = DG_SCPI_HARDWARE;
    refuse("BISS:FRAM?", "-240", "as frame says");
    rig.encoder[CONTROL_RIG_BISS].port = NULL;
    refuse("BISS:FRAM?", "-241", "no simulated BiSS wire");
    select_encoder("hf");
    refuse("BISS:FRAM?", "-241", "hf: it is no BiSS encoder");
}

static void test_read_registers(void **state)
{
    (void)state;
    select_encoder("biss-1");
    rig.bytes[0] = 0x4B;
    rig.bytes[1] = 0x55;
    expect("BISS:REG? #H7E,2", "75,85");
    assert_int_equal(rig.number[0], 0x7E);
    assert_int_equal(rig.number[1], 2);
    assert_ptr_equal(rig.whom, &rig.encoder[CONTROL_RIG_BISS]);
    expect("BISS:REG? 126", "75");
    refuse("BISS:REG? 128", "-222", NULL);
    refuse("BISS:REG? 0,0", "-222", NULL);
    refuse("BISS:REG? 0,65", "-222", NULL);
    refuse("BISS:REG?", "-109", NULL);
    rig.result = DG_SCPI_HARDWARE;
    refuse("BISS:REG? 1", "-240", "as read says");
    rig.encoder[CONTROL_RIG_BISS].port = NULL;
    refuse("BISS:REG? 1", "-241", "no simulated BiSS wire");
    select_encoder("can");
    refuse("BISS:REG? 1", "-241", "can: it is no BiSS encoder");
}

static void test_write_registers(void **state)
{
    char line[400] = "BISS:REG 0";

    (void)state;
    select_encoder("biss-1");
    expect("BISS:REG #H1B,1,2,#HFF", "");
    assert_int_equal(rig.number[0], 0x1B);
    assert_int_equal(rig.number[1], 3);
    assert_memory_equal(rig.bytes, "\x01\x02\xFF", 3);
    refuse("BISS:REG 27", "-109", NULL);
    refuse("BISS:REG 27,256", "-222", NULL);
    refuse("BISS:REG 128,1", "-222", NULL);
    for (unsigned i = 0; i < 64; i++) {
        (void)strcat(line, ",7");
    }
    expect(line, "");
    assert_int_equal(rig.number[1], 64);
    rig.call = NULL;
    (void)strcat(line, ",7");
    refuse(line, "-108", "64 bytes");
    assert_null(rig.call);
    rig.result = DG_SCPI_HARDWARE;
    refuse("BISS:REG 27,0", "-240", "as write says");
    rig.encoder[CONTROL_RIG_BISS].port = NULL;
    refuse("BISS:REG 27,0", "-241", "no simulated BiSS wire");
    select_encoder("k3");
    refuse("BISS:REG 27,0", "-241", NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_commands_of_instruments, setup),
        cmocka_unit_test_setup(test_identity, setup),
        cmocka_unit_test_setup(test_encoders, setup),
        cmocka_unit_test_setup(test_names_alike, setup),
        cmocka_unit_test_setup(test_two_clients, setup),
        cmocka_unit_test_setup(test_shaft_names, setup),
        cmocka_unit_test_setup(test_position, setup),
        cmocka_unit_test_setup(test_headers_that_are_near, setup),
        cmocka_unit_test_setup(test_position_is_the_nearest, setup),
        cmocka_unit_test_setup(test_velocity, setup),
        cmocka_unit_test_setup(test_acceleration, setup),
        cmocka_unit_test_setup(test_move, setup),
        cmocka_unit_test_setup(test_waiting_for_a_move, setup),
        cmocka_unit_test_setup(test_nobody_waits_for_a_profile, setup),
        cmocka_unit_test_setup(test_geared_shaft, setup),
        cmocka_unit_test_setup(test_profile, setup),
        cmocka_unit_test_setup(test_recording, setup),
        cmocka_unit_test_setup(test_every_quantity, setup),
        cmocka_unit_test_setup(test_worlds_are_apart, setup),
        cmocka_unit_test_setup(test_power, setup),
        cmocka_unit_test_setup(test_power_cycle, setup),
        cmocka_unit_test_setup(test_foreign_memory, setup),
        cmocka_unit_test_setup(test_time, setup),
        cmocka_unit_test_setup(test_trace, setup),
        cmocka_unit_test_setup(test_last_frames, setup),
        cmocka_unit_test_setup(test_severities_of_last_frames, setup),
        cmocka_unit_test_setup(test_frame, setup),
        cmocka_unit_test_setup(test_frame_without_life_counter, setup),
        cmocka_unit_test_setup(test_frame_without_data, setup),
        cmocka_unit_test_setup(test_read_registers, setup),
        cmocka_unit_test_setup(test_write_registers, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
