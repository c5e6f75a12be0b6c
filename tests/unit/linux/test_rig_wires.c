/* SPDX-License-Identifier: MIT */
/* Rigs of several wires, in virtual time: what is done for each wire, shaft and encoder of them. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "rig_parts.h"
#include "timer.h"
#include "virtual_rig.h"

#define SIM_E "[encoder e]\nmodel = s3684-biss\nwire = sim\nshaft = s\n"
#define SIM_F "[encoder f]\nmodel = ssi-25\nwire = sim\nshaft = t\n"
#define TWO "[rig]\nfiles = .\n[shaft s]\n[shaft t]\n" SIM_E SIM_F
#define CAN "[encoder c]\nmodel = f3668\nwire = slcan:tcp:127.0.0.1:0\n"

static char folder[] = "/tmp/test_rig_wires.XXXXXX";

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) == NULL || chdir(folder) != 0 ? -1 : 0;
}

static int remove_folder(void **state)
{
    (void)state;
    (void)unlink("rig.ini");
    return chdir("/") != 0 || rmdir(folder) != 0 ? -1 : 0;
}

static struct virtual_rig *open_rig(const char *text)
{
    struct virtual_rig *rig = calloc(1, sizeof *rig);
    FILE *file = fopen("rig.ini", "w");
    assert_non_null(rig);
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
    virtual_rig_open(rig, "rig.ini", NULL);
    return rig;
}

static void close_rig(struct virtual_rig *rig)
{
    virtual_rig_close(rig);
    free(rig);
}

static void answers(struct virtual_rig *rig, const char *question, const char *answer)
{
    virtual_rig_ask(rig, question);
    if (strcmp(rig->answer, answer) != 0) {
        fail_msg("%s: %s, not %s", question, rig->answer, answer);
    }
}

static void refuses(struct virtual_rig *rig, const char *command, const char *words)
{
    virtual_rig_ask(rig, command);
    answers(rig, "SYST:ERR?", words);
}

/* A file that a client has written, and its end. */
static void is_written(const char *name, const char *content)
{
    char text[512] = "";
    FILE *file = fopen(name, "r");
    assert_non_null(file);
    assert_true(fread(text, 1, sizeof text - 1, file) > 0);
    (void)fclose(file);
    assert_int_equal(unlink(name), 0);
    assert_string_equal(text, content);
}

/* --- time --- */

/* Wherever it stands in the file. */
static void one_wire_of_real_time_keeps_time(void **state)
{
    static const char *const rigs[] = {CAN "[encoder e]\nmodel = s3684-biss\nwire = sim\n",
                                       "[encoder e]\nmodel = s3684-biss\nwire = sim\n" CAN};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rigs); i++) {
        struct virtual_rig *rig = open_rig(rigs[i]);
        refuses(rig, "TIME:SCAL 0",
                "-221,\"Settings conflict;a wire of this rig runs in real time; expected only sim "
                "wires\"");
        answers(rig, "TIME:SCAL?", "1.000");
        close_rig(rig);
    }
}

/* Frames of the wire of the encoder that is selected: the page of the port, 'Simulated wires'. */
static unsigned frames_of(struct virtual_rig *rig)
{
    virtual_rig_ask(rig, "STAT?");
    const char *at = strstr(rig->answer, "wire_frames=");
    assert_non_null(at);
    return (unsigned)strtoul(at + strlen("wire_frames="), NULL, 10);
}

/* Ten frames a second are read of each. */
static void every_wire_goes_by_the_time_of_the_rig(void **state)
{
    struct virtual_rig *rig = open_rig(TWO);
    unsigned before[2] = {0};
    (void)state;
    virtual_rig_pass(rig, DG_S(1));
    virtual_rig_order(rig, "TIME:SCAL 0");
    for (size_t i = 0; i < 2; i++) {
        virtual_rig_order(rig, i == 0 ? "INST:SEL e" : "INST:SEL f");
        before[i] = frames_of(rig);
        assert_true(before[i] > 0);
    }
    virtual_rig_pass(rig, DG_S(3));
    virtual_rig_order(rig, "TIME:STEP 2S");
    for (size_t i = 0; i < 2; i++) {
        virtual_rig_order(rig, i == 0 ? "INST:SEL e" : "INST:SEL f");
        assert_int_equal(frames_of(rig), before[i] + 20);
    }
    virtual_rig_order(rig, "TIME:SCAL 2");
    virtual_rig_pass(rig, DG_S(1));
    for (size_t i = 0; i < 2; i++) {
        virtual_rig_order(rig, i == 0 ? "INST:SEL e" : "INST:SEL f");
        assert_int_equal(frames_of(rig), before[i] + 40);
    }
    close_rig(rig);
}

/* --- shafts --- */

/* A shaft that turns otherwise at moments that nobody has waited for: what was before is written. */
static void each_shaft_has_a_recording_of_its_own(void **state)
{
    struct virtual_rig *rig = open_rig(TWO);
    (void)state;
    virtual_rig_order(rig, "TIME:SCAL 0");
    virtual_rig_order(rig, "SHAF:REC:STAR \"s.csv\",250MS");
    virtual_rig_order(rig, "SHAF:VEL 30RPM");
    virtual_rig_order(rig, "INST:SEL f");
    virtual_rig_order(rig, "SHAF:REC:STAR \"t.csv\",125MS");
    virtual_rig_order(rig, "SHAF:VEL 60RPM");
    virtual_rig_order(rig, "TIME:STEP 250MS");
    virtual_rig_order(rig, "SHAF:VEL 120RPM");
    virtual_rig_order(rig, "TIME:STEP 250MS");
    virtual_rig_order(rig, "SHAF:VEL -60RPM");
    virtual_rig_order(rig, "TIME:STEP 249MS");
    virtual_rig_order(rig, "SHAF:REC:STOP");
    virtual_rig_order(rig, "TIME:STEP 1MS");
    refuses(rig, "INST:SEL e;:SHAF:REC:STAR \"q.csv\"",
            "-221,\"Settings conflict;recorded already; SHAFt:RECord:STOP first\"");
    virtual_rig_order(rig, "SHAF:REC:STOP");
    is_written("s.csv", "time_s,angle_deg\n0.000000000,0.000000000\n0.250000000,45.000000000\n"
                        "0.500000000,90.000000000\n0.750000000,135.000000000\n");
    is_written("t.csv", "time_s,angle_deg\n0.000000000,0.000000000\n0.125000000,45.000000000\n"
                        "0.250000000,90.000000000\n0.375000000,180.000000000\n"
                        "0.500000000,270.000000000\n0.625000000,225.000000000\n");
    close_rig(rig);
}

/* Each shaft keeps the points of its own motions, also when another one plays one after the other. */
static void each_shaft_plays_motions_of_its_own(void **state)
{
    struct virtual_rig *rig = open_rig(TWO);
    (void)state;
    virtual_rig_order(rig, "SHAF:PROF \"2REV\"");
    virtual_rig_order(rig, "INST:SEL f");
    answers(rig, "SHAF:PROF?;POS?", "\"rest\";0.000000");
    for (unsigned i = 1; i <= 4; i++) {
        virtual_rig_order(rig, "SHAF:PROF \"%uDEG\"", i);
    }
    answers(rig, "SHAF:PROF?;POS?", "\"4DEG\";4.000000");
    virtual_rig_order(rig, "INST:SEL e");
    answers(rig, "SHAF:PROF?;POS?", "\"2REV\";720.000000");
    close_rig(rig);
}

/* --- worlds --- */

static void each_encoder_follows_courses_of_its_own(void **state)
{
    struct virtual_rig *rig = open_rig(TWO);
    char usual[32];
    (void)state;
    virtual_rig_ask(rig, "WORL:TEMP?");
    (void)snprintf(usual, sizeof usual, "%.31s", rig->answer);
    virtual_rig_order(rig, "INST:SEL f");
    virtual_rig_order(rig, "WORL:TEMP:PROF:POIN 0,40,10S,50");
    virtual_rig_pass(rig, DG_S(5));
    answers(rig, "WORL:TEMP?;TEMP:PROF?", "45.000;\"points\"");
    virtual_rig_order(rig, "INST:SEL e");
    answers(rig, "WORL:TEMP?", usual);
    answers(rig, "WORL:TEMP:PROF?", "\"\"");
    virtual_rig_ask(rig, "STAT?");
    assert_non_null(strstr(rig->answer, ",courses=-"));
    close_rig(rig);
}

/* --- counters --- */

/* What STATe? says of a wire after a second in which nobody has come to it. The coupler runs a cycle
   a millisecond, of which the first one identifies; the master of a simulated wire reads every 100
   ms, from the end of the initialisation on. */
static void each_kind_of_wire_counts_its_own(void **state)
{
    static const struct {
        const char *rig;
        const char *counters;
    } rows[] = {
        {"[encoder e]\nmodel = s3684-rs485\nwire = rs485:tcp:127.0.0.1:0\n",
         ",wire_up=1,wire_late=0,wire_collided=0,wire_lost=0,wire_baud=9600,wire_overrun=0,"},
        {CAN,
         ",wire_up=1,wire_late=0,wire_stalls=0,wire_lost=0,wire_kbaud=250,wire_load_permille=0,"},
        {"[encoder e]\nmodel = ocd-ib-k3\nwire = modbus:127.0.0.1:0\n",
         ",wire_up=1,wire_late=0,wire_cycles=1001,wire_ids=1,wire_crc_errors=0,wire_interrupted=0,"
         "wire_requests=0,"},
        {"[encoder e]\nmodel = s3684-biss\nwire = sim\n",
         ",wire_up=1,wire_late=0,wire_frames=10,wire_silent=0,wire_wrong=0,"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct virtual_rig *rig = open_rig(rows[i].rig);
        virtual_rig_pass(rig, DG_S(1));
        virtual_rig_ask(rig, "STAT?");
        if (strstr(rig->answer, rows[i].counters) == NULL) {
            fail_msg("%s: no %s", rig->answer, rows[i].counters);
        }
        close_rig(rig);
    }
}

/* --- the control plane --- */

/* Two addresses, two sockets: they are there as long as the rig is. */
static void every_control_address_is_served_and_given_back(void **state)
{
    static const char *const sockets[] = {"a.sock", "b.sock", "c.sock"};
    struct virtual_rig *rig = open_rig("[rig]\ncontrol = unix:a.sock\ncontrol = unix:b.sock\n"
                                       "control = unix:c.sock\n" CAN);
    (void)state;
    for (size_t i = 0; i < DG_COUNT(sockets); i++) {
        assert_int_equal(access(sockets[i], F_OK), 0);
    }
    close_rig(rig);
    for (size_t i = 0; i < DG_COUNT(sockets); i++) {
        assert_int_equal(access(sockets[i], F_OK), -1);
    }
}

/* --- traces --- */

static void each_wire_has_a_trace_of_its_own(void **state)
{
    struct virtual_rig *rig = open_rig(TWO);
    (void)state;
    refuses(rig, "TRAC:STAR \"e.log\"",
            "-257,\"File name error;e.log: the name of a trace of BiSS ends in .vcd\"");
    virtual_rig_order(rig, "TRAC:STAR \"e.vcd\"");
    refuses(rig, "TRAC:STAR \"f.vcd\"",
            "-221,\"Settings conflict;traced already; TRACe:STOP first\"");
    virtual_rig_order(rig, "INST:SEL f");
    virtual_rig_order(rig, "TRAC:STAR \"f.vcd\"");
    virtual_rig_order(rig, "TRAC:STOP");
    virtual_rig_order(rig, "TRAC:STOP"); /* nothing is left to stop */
    virtual_rig_order(rig, "INST:SEL e");
    refuses(rig, "TRAC:STAR \"g.vcd\"",
            "-221,\"Settings conflict;traced already; TRACe:STOP first\"");
    virtual_rig_order(rig, "TRAC:STOP");
    assert_int_equal(unlink("e.vcd"), 0);
    assert_int_equal(unlink("f.vcd"), 0);
    close_rig(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_wire_of_real_time_keeps_time),
        cmocka_unit_test(every_wire_goes_by_the_time_of_the_rig),
        cmocka_unit_test(each_shaft_has_a_recording_of_its_own),
        cmocka_unit_test(each_shaft_plays_motions_of_its_own),
        cmocka_unit_test(each_encoder_follows_courses_of_its_own),
        cmocka_unit_test(each_kind_of_wire_counts_its_own),
        cmocka_unit_test(every_control_address_is_served_and_given_back),
        cmocka_unit_test(each_wire_has_a_trace_of_its_own),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
