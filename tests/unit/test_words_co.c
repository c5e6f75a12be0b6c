/* SPDX-License-Identifier: MIT */
/* The words of CANopen. Frames are those of CiA 301 and CiA 305. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/cia406.h"
#include "words_rig.h"

/* Severities, as in the tables below. */
#define OK DG_SEVERITY_OK
#define NOTICE DG_SEVERITY_NOTICE
#define WARN DG_SEVERITY_WARNING
#define ERROR DG_SEVERITY_ERROR

/* clang-format off */
/* CiA 301: an EMCY with another code than 0000h is an error, that one is the end of all (7.2.7.1); an abort is one (7.2.4.3.17).
   A node that boots was reset, NMT changes states (7.3.2). What is shorter than its service lays down is lost. */
static const struct {
    uint16_t id;
    const char *hex;
    enum dg_severity severity;
    const char *text;
} can[] = {
    {0x000, "01 05",                   NOTICE, "NMT start node 5"},
    {0x000, "82 00",                   NOTICE, "NMT reset communication all nodes"},
    {0x000, "33 01",                   WARN,   "NMT 33h node 1"},
    {0x000, "01",                      ERROR,  "NMT, too short: 01"},
    {0x000, "02 05",                   NOTICE, "NMT stop node 5"},
    {0x000, "80 05",                   NOTICE, "NMT enter pre-operational node 5"},
    {0x000, "81 05",                   NOTICE, "NMT reset node 5"},
    {0x080, "",                        OK,     "SYNC"},
    {0x080, "07",                      OK,     "SYNC 7"},
    {0x085, "10 81 11 01 02 03 04 05", ERROR,  "EMCY node 5 8110h register 11h: 01 02 03 04 05"},
    {0x085, "00 00 00 00 00 00 00 00", NOTICE, "EMCY node 5 0000h no error, register 00h: 00 00 00 00 00"},
    {0x085, "00 10 01",                ERROR,  "EMCY node 5 1000h register 01h"},
    {0x085, "00 10",                   ERROR,  "EMCY node 5, too short: 00 10"},
    {0x0FF, "00 00 00",                NOTICE, "EMCY node 127 0000h no error, register 00h"},
    {0x100, "0D 30 B3 02 39",          ERROR,  "TIME, too short: 0D 30 B3 02 39"},
    {0x100, "0D 30 B3 02 39 30",       OK,     "TIME 45297677 ms, day 12345"},
    {0x185, "39 30 00 00",             OK,     "TPDO1 node 5: 39 30 00 00"},
    {0x2FF, "01",                      OK,     "TPDO2 node 127: 01"},
    {0x381, "01",                      OK,     "TPDO3 node 1: 01"},
    {0x481, "",                        OK,     "TPDO4 node 1"},
    {0x205, "01",                      OK,     "RPDO1 node 5: 01"},
    {0x180, "",                        OK,     "id 180h"},
    {0x181, "",                        OK,     "TPDO1 node 1"},
    {0x27F, "",                        OK,     "RPDO1 node 127"},
    {0x281, "",                        OK,     "TPDO2 node 1"},
    {0x301, "",                        OK,     "RPDO2 node 1"},
    {0x37F, "01",                      OK,     "RPDO2 node 127: 01"},
    {0x3FF, "",                        OK,     "TPDO3 node 127"},
    {0x47F, "",                        OK,     "RPDO3 node 127"},
    {0x501, "",                        OK,     "RPDO4 node 1"},
    {0x57F, "01",                      OK,     "RPDO4 node 127: 01"},
    {0x585, "20 00 00 00 00 00 00 00", OK,     "SDO node 5 -> download segment"},
    {0x585, "60 04 60 00 00 00 00",    ERROR,  "SDO node 5, too short: 60 04 60 00 00 00 00"},
    {0x605, "40 04 60 00 00 00 00",    ERROR,  "SDO node 5, too short: 40 04 60 00 00 00 00"},
    {0x600, "40",                      OK,     "id 600h: 40"},
    {0x605, "40 04 60 00 00 00 00 00", OK,     "SDO node 5 upload 6004h:00"},
    {0x585, "43 04 60 00 39 30 00 00", OK,     "SDO node 5 -> upload 6004h:00 = 00003039h"},
    {0x585, "4B 00 62 00 0A 00 00 00", OK,     "SDO node 5 -> upload 6200h:00 = 000Ah"},
    {0x585, "41 08 10 00 14 00 00 00", OK,     "SDO node 5 -> upload 1008h:00, 20 bytes"},
    {0x605, "2F 01 18 02 FE 00 00 00", OK,     "SDO node 5 download 1801h:02 = FEh"},
    {0x605, "22 01 18 02 FE 00 00 00", OK,     "SDO node 5 download 1801h:02 = 000000FEh"},
    {0x605, "20 01 18 02 FE 00 00 00", OK,     "SDO node 5 download 1801h:02, in segments"},
    {0x585, "60 01 18 02 00 00 00 00", OK,     "SDO node 5 -> download 1801h:02"},
    {0x605, "60 00 00 00 00 00 00 00", OK,     "SDO node 5 upload segment"},
    {0x585, "09 41 42 43 00 00 00 00", OK,     "SDO node 5 -> upload segment, the last: 41 42 43"},
    {0x605, "10 31 32 33 34 35 36 37", OK,     "SDO node 5 download segment: 31 32 33 34 35 36 37"},
    {0x585, "80 FF 9F 00 00 00 02 06", ERROR,  "SDO node 5 -> abort 9FFFh:00: 06020000h no such object"},
    {0x605, "80 FF 9F 00 78 56 34 12", ERROR,  "SDO node 5 abort 9FFFh:00: 12345678h unknown"},
    {0x585, "E0 00 00 00 00 00 00 00", WARN,   "SDO node 5 -> unknown service: E0 00 00 00 00 00 00 00"},
    {0x585, "A3 00 00 00 00 00 00 00", WARN,   "SDO node 5 -> unknown service: A3 00 00 00 00 00 00 00"},
    {0x605, "E0 00 00 00 00 00 00 00", WARN,   "SDO node 5 unknown service: E0 00 00 00 00 00 00 00"},
    {0x585, "43 04",                   ERROR,  "SDO node 5, too short: 43 04"},
    {0x705, "00",                      NOTICE, "heartbeat node 5 boot-up"},
    {0x705, "85",                      OK,     "heartbeat node 5 operational, toggle"},
    {0x705, "7F",                      OK,     "heartbeat node 5 pre-operational"},
    {0x705, "04",                      OK,     "heartbeat node 5 stopped"},
    {0x705, "03",                      WARN,   "heartbeat node 5 03h"},
    {0x77F, "05",                      OK,     "heartbeat node 127 operational"},
    {0x7E4, "11 00 00 00 00 00 00",    ERROR,  "LSS, too short: 11 00 00 00 00 00 00"},
    {0x7E5, "11 05 00 00 00 00 00",    ERROR,  "LSS, too short: 11 05 00 00 00 00 00"},
    {0x7E5, "04 01 00 00 00 00 00 00", OK,     "LSS switch state global 01h"},
    {0x7E5, "11 05 00 00 00 00 00 00", NOTICE, "LSS configure node-ID 05h"},
    {0x7E4, "11 00 00 00 00 00 00 00", NOTICE, "LSS -> configure node-ID 00h"},
    {0x7E5, "43 78 56 34 12 00 00 00", OK,     "LSS switch state selective serial number 12345678h"},
    {0x7E4, "44 00 00 00 00 00 00 00", OK,     "LSS -> switch state selective"},
    {0x7E5, "99 00 00 00 00 00 00 00", WARN,   "LSS: 99 00 00 00 00 00 00 00"},
    {0x580, "43 04",                   OK,     "id 580h: 43 04"},
    {0x701, "",                        ERROR,  "heartbeat node 1, too short"},
};
/* clang-format on */

static void say_can(struct words_rig *rig, uint16_t id, const char *hex)
{
    struct dg_tap_event event = {.at = 77, .kind = DG_TAP_FRAME, .ours = true};
    uint8_t bytes[8] = {0};
    event.frame.dlc = (uint8_t)words_rig_hex(hex, bytes);
    event.frame.id = id;
    memcpy(event.frame.data, bytes, sizeof bytes);
    dg_words_event(&rig->wire, &event);
}

static void can_frames_in_the_words_of_canopen(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(can); i++) {
        struct words_rig rig;
        words_rig_init(&rig, &dg_cia406_words);
        say_can(&rig, can[i].id, can[i].hex);
        assert_int_equal(rig.count, 1);
        assert_string_equal(rig.text, can[i].text);
        assert_true(rig.at == 77 && rig.ours);
        assert_int_equal(rig.severity, can[i].severity);
    }
}

/* clang-format off */
/* CiA 305: services with their arguments, from the master and from the slave. What there is no frame of has none.
   Those that change a slave are worth a notice; 78h in the reply of three of them is an error code: 0 would be success. */
static const struct {
    uint8_t code;
    enum dg_severity severity;
    enum dg_severity of_reply;
    const char *name;
    const char *request;
    const char *reply;
} lss[] = {
    {0x04, OK,     OK,     "switch state global",                    " 78h",       ""},
    {0x11, NOTICE, ERROR,  "configure node-ID",                      " 78h",       " 78h"},
    {0x13, NOTICE, ERROR,  "configure bit timing",                   " 5678h",     " 78h"},
    {0x15, NOTICE, NOTICE, "activate bit timing",                    " 5678h",     ""},
    {0x17, NOTICE, ERROR,  "store configuration",                    "",           " 78h"},
    {0x40, OK,     OK,     "switch state selective vendor-ID",       " 12345678h", ""},
    {0x41, OK,     OK,     "switch state selective product code",    " 12345678h", ""},
    {0x42, OK,     OK,     "switch state selective revision",        " 12345678h", ""},
    {0x43, OK,     OK,     "switch state selective serial number",   " 12345678h", ""},
    {0x44, OK,     OK,     "switch state selective",                 "",           ""},
    {0x46, OK,     OK,     "identify vendor-ID",                     " 12345678h", ""},
    {0x47, OK,     OK,     "identify product code",                  " 12345678h", ""},
    {0x48, OK,     OK,     "identify revision from",                 " 12345678h", ""},
    {0x49, OK,     OK,     "identify revision to",                   " 12345678h", ""},
    {0x4A, OK,     OK,     "identify serial number from",            " 12345678h", ""},
    {0x4B, OK,     OK,     "identify serial number to",              " 12345678h", ""},
    {0x4C, OK,     OK,     "identify non-configured",                "",           ""},
    {0x4F, OK,     OK,     "identify slave",                         "",           ""},
    {0x50, OK,     OK,     "identify non-configured slave",          "",           ""},
    {0x51, OK,     OK,     "fastscan",                               " 12345678h", ""},
    {0x5A, OK,     OK,     "inquire vendor-ID",                      "",           " 12345678h"},
    {0x5B, OK,     OK,     "inquire product code",                   "",           " 12345678h"},
    {0x5C, OK,     OK,     "inquire revision",                       "",           " 12345678h"},
    {0x5D, OK,     OK,     "inquire serial number",                  "",           " 12345678h"},
    {0x5E, OK,     OK,     "inquire node-ID",                        "",           " 78h"},
};

/* SDO abort codes, CiA 301, 7.2.4.3.17. */
static const struct {
    const char *hex; /* as it goes over the bus */
    const char *text;
} aborts[] = {
    {"00 00 03 05", "05030000h toggle bit"},          {"00 00 04 05", "05040000h timeout"},
    {"01 00 04 05", "05040001h command specifier"},   {"02 00 04 05", "05040002h block size"},
    {"03 00 04 05", "05040003h sequence number"},     {"04 00 04 05", "05040004h CRC"},
    {"05 00 04 05", "05040005h out of memory"},       {"00 00 01 06", "06010000h access"},
    {"01 00 01 06", "06010001h write-only"},          {"02 00 01 06", "06010002h read-only"},
    {"00 00 02 06", "06020000h no such object"},      {"41 00 04 06", "06040041h cannot be mapped"},
    {"42 00 04 06", "06040042h PDO too long"},        {"43 00 04 06", "06040043h incompatible parameter"},
    {"47 00 04 06", "06040047h incompatible inside"}, {"00 00 06 06", "06060000h hardware"},
    {"10 00 07 06", "06070010h length"},              {"12 00 07 06", "06070012h too long"},
    {"13 00 07 06", "06070013h too short"},           {"11 00 09 06", "06090011h no such sub-index"},
    {"30 00 09 06", "06090030h value range"},         {"31 00 09 06", "06090031h value too high"},
    {"32 00 09 06", "06090032h value too low"},       {"36 00 09 06", "06090036h maximum below minimum"},
    {"00 00 00 08", "08000000h general error"},       {"20 00 00 08", "08000020h cannot be stored"},
    {"21 00 00 08", "08000021h local control"},       {"22 00 00 08", "08000022h device state"},
    {"23 00 00 08", "08000023h no dictionary"},       {"24 00 00 08", "08000024h no data"},
};
/* clang-format on */

static void can_is_told(uint16_t id, const char *hex, const char *before, const char *expected,
                        enum dg_severity severity)
{
    struct words_rig rig;
    char text[DG_WORDS_MAX];
    words_rig_init(&rig, &dg_cia406_words);
    say_can(&rig, id, hex);
    (void)snprintf(text, sizeof text, "%s%s", before, expected);
    assert_string_equal(rig.text, text);
    assert_int_equal(rig.severity, severity);
}

static void every_service_of_lss_and_every_abort_has_its_words(void **state)
{
    char hex[32];
    char expected[80];
    (void)state;
    for (size_t i = 0; i < DG_COUNT(lss); i++) {
        (void)snprintf(hex, sizeof hex, "%02X 78 56 34 12 00 00 00", lss[i].code);
        (void)snprintf(expected, sizeof expected, "%s%s", lss[i].name, lss[i].request);
        can_is_told(0x7E5, hex, "LSS ", expected, lss[i].severity);
        (void)snprintf(expected, sizeof expected, "%s%s", lss[i].name, lss[i].reply);
        can_is_told(0x7E4, hex, "LSS -> ", expected, lss[i].of_reply);
    }
    for (size_t i = 0; i < DG_COUNT(aborts); i++) {
        (void)snprintf(hex, sizeof hex, "80 04 60 00 %s", aborts[i].hex);
        can_is_told(0x585, hex, "SDO node 5 -> abort 6004h:00: ", aborts[i].text, ERROR);
        can_is_told(0x605, hex, "SDO node 5 abort 6004h:00: ", aborts[i].text, ERROR);
    }
}

static void remote_frames(void **state)
{
    struct dg_tap_event event = {.kind = DG_TAP_FRAME, .frame = {.id = 0x705, .rtr = true}};
    struct words_rig rig;
    (void)state;
    words_rig_init(&rig, &dg_cia406_words);
    dg_words_event(&rig.wire, &event);
    assert_string_equal(rig.text, "heartbeat node 5 requested");
    event.frame.id = 0x7FF;
    dg_words_event(&rig.wire, &event);
    assert_string_equal(rig.text, "id 7FFh requested");
}

/* Segments of a block look like anything; what they are depends on what came before, by node. */
static void block_transfers(void **state)
{
    static const struct {
        uint16_t id;
        const char *hex;
        const char *text;
    } steps[] = {
        {0x605, "A4 08 10 00 02 00 00 00", "SDO node 5 block upload 1008h:00"},
        {0x585, "C6 08 10 00 0C 00 00 00", "SDO node 5 -> block upload 1008h:00"},
        {0x605, "A3 00 00 00 00 00 00 00", "SDO node 5 block upload start"},
        {0x585, "01 41 42 43 44 45 46 47", "SDO node 5 -> block segment 1: 41 42 43 44 45 46 47"},
        {0x586, "01 41 42 43 44 45 46 47",
         "SDO node 6 -> upload segment, the last: 41 42 43 44 45 46 47"},
        {0x585, "82 48 49 4A 4B 4C 00 00",
         "SDO node 5 -> block segment 2, the last: 48 49 4A 4B 4C 00 00"},
        {0x605, "A2 02 02 00 00 00 00 00", "SDO node 5 block upload received up to 2, next 2"},
        {0x585, "C9 12 34 00 00 00 00 00", "SDO node 5 -> block upload end"},
        {0x605, "A1 00 00 00 00 00 00 00", "SDO node 5 block upload end"},
        {0x605, "C2 00 62 00 02 00 00 00", "SDO node 5 block download 6200h:00"},
        {0x585, "A0 00 62 00 7F 00 00 00", "SDO node 5 -> block download 6200h:00"},
        {0x605, "81 0A 00 00 00 00 00 00",
         "SDO node 5 block segment 1, the last: 0A 00 00 00 00 00 00"},
        {0x585, "A2 01 7F 00 00 00 00 00",
         "SDO node 5 -> block download received up to 1, next 127"},
        {0x605, "D5 12 34 00 00 00 00 00", "SDO node 5 block download end"},
        {0x585, "A1 00 00 00 00 00 00 00", "SDO node 5 -> block download end"},
        {0x605, "40 04 60 00 00 00 00 00", "SDO node 5 upload 6004h:00"},
        {0x605, "A3 00 00 00 00 00 00 00", "SDO node 5 block upload start"},
        {0x605, "80 08 10 00 00 00 04 05", "SDO node 5 abort 1008h:00: 05040000h timeout"},
        {0x585, "01 41 42 43 44 45 46 47",
         "SDO node 5 -> upload segment, the last: 41 42 43 44 45 46 47"},
    };
    struct words_rig rig;
    (void)state;
    words_rig_init(&rig, &dg_cia406_words);
    for (size_t i = 0; i < DG_COUNT(steps); i++) {
        say_can(&rig, steps[i].id, steps[i].hex);
        assert_string_equal(rig.text, steps[i].text);
    }
}

/* By the predefined connection set: who sends a frame, and the chapter that says what it is. */
static void frames_have_a_sender_and_a_chapter(void **state)
{
    static const struct {
        uint16_t id;
        bool rtr;
        enum dg_words_side side; /* for node 5 */
        const char *clause;
    } rows[] = {
        {0x000, false, DG_WORDS_MASTER, "CiA 301 7.2.8"},
        {0x080, false, DG_WORDS_MASTER, "CiA 301 7.2.5"},
        {0x085, false, DG_WORDS_ENCODER, "CiA 301 7.2.7"},
        {0x100, false, DG_WORDS_MASTER, "CiA 301 7.2.6"},
        {0x185, false, DG_WORDS_ENCODER, "CiA 301 7.2.2"},
        {0x205, false, DG_WORDS_MASTER, "CiA 301 7.2.2"},
        {0x485, false, DG_WORDS_ENCODER, "CiA 301 7.2.2"},
        {0x585, false, DG_WORDS_ENCODER, "CiA 301 7.2.4"},
        {0x605, false, DG_WORDS_MASTER, "CiA 301 7.2.4"},
        {0x586, false, DG_WORDS_OTHER, "CiA 301 7.2.4"},
        {0x705, false, DG_WORDS_ENCODER, "CiA 301 7.2.8"},
        {0x705, true, DG_WORDS_MASTER, "CiA 301 7.2.8"},
        {0x7E4, false, DG_WORDS_ENCODER, "CiA 305"},
        {0x7E5, false, DG_WORDS_MASTER, "CiA 305"},
    };
    struct words_rig rig;
    (void)state;
    words_rig_init(&rig, &dg_cia406_words);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_tap_event event = {
            .kind = DG_TAP_FRAME,
            .frame = {.id = rows[i].id, .rtr = rows[i].rtr, .dlc = 8},
        };
        dg_words_event(&rig.wire, &event);
        assert_string_equal(rig.clause, rows[i].clause);
        assert_int_equal(dg_cia406_words.side(&event, 5), rows[i].side);
        assert_int_not_equal(dg_cia406_words.side(&event, 0), DG_WORDS_OTHER);
    }
    say_can(&rig, 0x585, "80 34 12 00 00 00 02 06");
    assert_string_equal(rig.clause, "CiA 301 7.2.4.3.17");
    say_can(&rig, 0x7FF, "00");
    assert_null(rig.clause);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(can_frames_in_the_words_of_canopen),
        cmocka_unit_test(every_service_of_lss_and_every_abort_has_its_words),
        cmocka_unit_test(remote_frames),
        cmocka_unit_test(block_transfers),
        cmocka_unit_test(frames_have_a_sender_and_a_chapter),
    };
    return cmocka_run_group_tests_name("words_co", tests, NULL, NULL);
}
