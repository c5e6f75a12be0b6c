/* SPDX-License-Identifier: MIT */
/* The decoder. RS485 frames are those of the manual's chapter 5.1.4, CAN frames those of CiA 301.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
#include "trace.h"

#define LENGTH(array) (sizeof(array) / sizeof((array)[0]))
#define BAUD 9600u

/* The lines that were given. */
struct lines {
    unsigned count;
    dg_ns at;
    bool ours;
    char text[LX_DECODE_MAX]; /* of the last */
};

static void on_line(void *ctx, dg_ns at, bool ours, const char *text)
{
    struct lines *self = ctx;
    assert_true(strlen(text) < LX_DECODE_MAX);
    self->count++;
    self->at = at;
    self->ours = ours;
    (void)strcpy(self->text, text);
}

/* Bytes of a text in hexadecimal. */
static size_t bytes_of(const char *hex, uint8_t *out)
{
    size_t n = 0;
    char *end = NULL;
    for (unsigned long value = strtoul(hex, &end, 16); end != hex; value = strtoul(hex, &end, 16)) {
        out[n++] = (uint8_t)value;
        hex = end;
    }
    return n;
}

static struct dg_tap_event character(dg_ns at, bool ours, uint8_t byte)
{
    return (struct dg_tap_event){
        .at = at,
        .kind = DG_TAP_CHARACTER,
        .ours = ours,
        .character = {.baud = BAUD, .parity = 'E', .byte = byte},
    };
}

/* One character after the other, the first one's start bit at `start`. @return end of the last */
static dg_ns say(struct lx_decoder *decoder, dg_ns start, bool ours, const char *hex)
{
    uint8_t bytes[256];
    const size_t n = bytes_of(hex, bytes);
    for (size_t i = 0; i < n; i++) {
        start += dg_bit_times_ns(11, BAUD);
        const struct dg_tap_event event = character(start, ours, bytes[i]);
        lx_decoder_event(decoder, &event);
    }
    return start;
}

/* clang-format off */
static const struct {
    bool ours;
    const char *hex;
    const char *text;
} frames[] = {
    {false, "40 42 02",                      "40h 42h read position"},
    {true,  "40 42 00 00 30 39 0B",          "40h -> 42h position 12345"},
    {true,  "40 C2 00 00 00 00 82",          "40h -> 42h position 0, warning"},
    {false, "40 43 00 00 00 00 55 56",       "40h 43h set position 0, code 55h"},
    {true,  "40 43 03",                      "40h -> 43h position set"},
    {false, "40 44 48 4C",                   "40h 44h read analog value 48h"},
    {true,  "40 44 48 00 25 69",             "40h -> 44h analog value 48h: 37"},
    {true,  "40 44 48 FF FB 48",             "40h -> 44h analog value 48h: -5"},
    {true,  "40 46 00 00 00 06",             "40h -> 46h counter 0"},
    {false, "40 47 07",                      "40h 47h increment counter"},
    {true,  "40 49 09",                      "40h -> 49h counter erased"},
    {false, "40 4A 00 00 10 55 4F",          "40h 4Ah read data field 00h offset 00h count 16, code 55h"},
    {true,  "40 4A 00 00 02 12 34 2E",       "40h -> 4Ah data field 00h offset 00h count 2: 12 34"},
    {false, "40 4B 00 00 08 55 FF 00 FF 00 FF 00 FF 00 56",
     "40h 4Bh save data field 00h offset 00h count 8, code 55h: FF 00 FF 00 FF 00 FF 00"},
    {true,  "40 4C 00 C8 C4",                "40h -> 4Ch data field 00h status C8h"},
    {false, "40 4D 00 C8 55 90",             "40h 4Dh create data field 00h status C8h, code 55h"},
    {true,  "40 4E 16 00 18",                "40h -> 4Eh memory blocks free 22, data fields 0"},
    {false, "40 4F 02 55 66 3E",             "40h 4Fh modify access key 2 from 55h to 66h"},
    {false, "40 50 10",                      "40h 50h read encoder status"},
    {true,  "40 50 00 10",                   "40h -> 50h no error"},
    {true,  "40 50 0D 1D",                   "40h -> 50h error 0Dh wrong argument"},
    {true,  "40 D0 0B 9B",                   "40h -> 50h error 0Bh unknown command code, warning"},
    {true,  "40 50 77 67",                   "40h -> 50h error 77h unknown"},
    {true,  "40 52 E4 22 16 00 C2",          "40h -> 52h type label: UART E4h, type 22h, memory blocks 22, option 00h"},
    {false, "40 53 13",                      "40h 53h reset encoder"},
    {false, "40 55 41 55 01",                "40h 55h assign address 41h, code 55h"},
    {true,  "41 55 14",                      "41h -> 55h address assigned"},
    {true,  "40 56 31 32 33 34 35 36 37 38 39 76 31 2E 30 2E 38 00 00 00 00 00 00 00 00 00 00 00 00 00 00 "
            "31 32 30 37 32 30 31 39 66",    "40h -> 56h serial number 123456789, version v1.0.8, date 12072019"},
    {false, "FF 57 E4 55 19",                "all 57h configure serial interface E4h, code 55h"},
    {true,  "40 6A 00 05 D2 C1 3C",          "40h -> 6Ah position 381633"},
    {false, "40 42 03",                      "40h 42h read position, check sum wrong"},
    {false, "40 99 01 D8",                   "40h 99h unknown command: 01"},
    {false, "40 43 00 00 03",                "40h 43h set position ?, code ?"},
    {false, "40 42 01 03",                   "40h 42h read position, too many: 01"},
    {false, "40 42",                         "too short: 40 42"},
    {true,  "40",                            "-> too short: 40"},
};
/* clang-format on */

static void frames_in_the_manuals_words(void **state)
{
    (void)state;
    for (size_t i = 0; i < LENGTH(frames); i++) {
        struct lines lines = {.count = 0};
        struct lx_decoder decoder;
        lx_decoder_init(&decoder, on_line, &lines);
        const dg_ns end = say(&decoder, DG_MS(5), frames[i].ours, frames[i].hex);
        assert_int_equal(lines.count, 0);
        const dg_ns due = lx_decoder_step(&decoder, end);
        assert_true(due > end && due < end + DG_MS(6));
        assert_true(lx_decoder_step(&decoder, due) == DG_NEVER);
        assert_int_equal(lines.count, 1);
        assert_string_equal(lines.text, frames[i].text);
        assert_int_equal(lines.ours, frames[i].ours);
        assert_true(lines.at == DG_MS(5));
    }
}

/* clang-format off */
/* The others of 5.1.4, without their check sums. */
static const struct {
    bool ours;
    const char *hex;
    const char *text;
} more_frames[] = {
    {false, "40 46",                   "40h 46h read counter"},
    {true,  "40 46 01 02 03",          "40h -> 46h counter 66051"},
    {true,  "40 47",                   "40h -> 47h counter incremented"},
    {false, "40 49 55",                "40h 49h erase counter, code 55h"},
    {true,  "40 4B 01 02 03",          "40h -> 4Bh data field 01h offset 02h count 3 saved"},
    {false, "40 4C 01",                "40h 4Ch determine data field status 01h"},
    {true,  "40 4D 01 C8",             "40h -> 4Dh data field 01h created, status C8h"},
    {false, "40 4E",                   "40h 4Eh determine available memory area"},
    {true,  "40 4F 02",                "40h -> 4Fh access key 2 modified"},
    {false, "40 52",                   "40h 52h read type label"},
    {true,  "40 53",                   "40h -> 53h encoder reset"},
    {false, "40 56",                   "40h 56h read serial number and version"},
    {true,  "40 57 E4",                "40h -> 57h serial interface E4h"},
    {false, "40 6A 00 00 01 07 55",    "40h 6Ah set position with synchronization 263, code 55h"},
};

/* Status messages, 5.1.3. */
static const struct {
    uint8_t code;
    const char *text;
} messages[] = {
    {0x01, "faulty compensation data"},     {0x02, "faulty internal angular offset"},
    {0x03, "data field partitioning table destroyed"},
    {0x05, "internal I2C bus not operational"},
    {0x06, "internal check sum error"},     {0x08, "counter overflow"},
    {0x0A, "check sum error"},              {0x0B, "unknown command code"},
    {0x0C, "wrong command length"},         {0x0D, "wrong argument"},
    {0x0E, "data field may not be written"}, {0x0F, "wrong access code"},
    {0x10, "insufficient memory"},          {0x11, "address outside of the data field"},
    {0x12, "wrong data field number"},      {0x1D, "LED current"},
    {0x1E, "temperature"},                  {0x1F, "speed too high"},
    {0x20, "singleturn"},                   {0x21, "multiturn amplitude"},
    {0x22, "multiturn synchronization"},    {0x23, "multiturn vector length"},
};
/* clang-format on */

/* A frame that ends with its check sum: all bytes together are 0 (5.1.1). */
static void is_told(bool ours, const char *hex, const char *expected)
{
    struct lines lines = {.count = 0};
    struct lx_decoder decoder;
    uint8_t bytes[32];
    char whole[128];
    uint8_t sum = 0;
    const size_t n = bytes_of(hex, bytes);
    for (size_t i = 0; i < n; i++) {
        sum ^= bytes[i];
    }
    (void)snprintf(whole, sizeof whole, "%s %02X", hex, sum);
    lx_decoder_init(&decoder, on_line, &lines);
    (void)lx_decoder_step(&decoder, say(&decoder, DG_MS(5), ours, whole) + DG_S(1));
    assert_string_equal(lines.text, expected);
}

static void every_command_and_message_has_its_words(void **state)
{
    char hex[16];
    char expected[80];
    (void)state;
    for (size_t i = 0; i < LENGTH(more_frames); i++) {
        is_told(more_frames[i].ours, more_frames[i].hex, more_frames[i].text);
    }
    for (size_t i = 0; i < LENGTH(messages); i++) {
        (void)snprintf(hex, sizeof hex, "40 50 %02X", messages[i].code);
        (void)snprintf(expected, sizeof expected, "40h -> 50h error %02Xh %s", messages[i].code,
                       messages[i].text);
        is_told(true, hex, expected);
    }
}

static void a_frame_ends_with_the_other_direction_or_silence(void **state)
{
    const dg_ns bit = dg_bit_times_ns(1, BAUD);
    struct lines lines = {.count = 0};
    struct lx_decoder decoder;
    (void)state;
    lx_decoder_init(&decoder, on_line, &lines);
    assert_true(lx_decoder_step(&decoder, DG_S(1)) == DG_NEVER);
    dg_ns end = say(&decoder, 0, false, "40 42 02");
    end = say(&decoder, end + 12 * bit, true, "40 42 00");
    assert_int_equal(lines.count, 1);
    assert_string_equal(lines.text, "40h 42h read position");
    /* A pause of nearly 44 bits is inside a frame, also when the clock is looked at meanwhile. */
    (void)lx_decoder_step(&decoder, end + 43 * bit);
    end = say(&decoder, end + 43 * bit, true, "00 30 39 0B");
    assert_int_equal(lines.count, 1);
    (void)say(&decoder, end + 45 * bit, true, "40 43 03");
    assert_int_equal(lines.count, 2);
    assert_string_equal(lines.text, "40h -> 42h position 12345");
}

static void characters_in_a_bunch_are_a_frame(void **state)
{
    static const uint8_t bytes[] = {0x40, 0x42, 0x02};
    struct lines lines = {.count = 0};
    struct lx_decoder decoder;
    (void)state;
    lx_decoder_init(&decoder, on_line, &lines);
    for (size_t i = 0; i < sizeof bytes; i++) {
        const struct dg_tap_event event = character(DG_MS(1), false, bytes[i]);
        lx_decoder_event(&decoder, &event);
    }
    (void)lx_decoder_step(&decoder, DG_S(1));
    assert_int_equal(lines.count, 1);
    assert_string_equal(lines.text, "40h 42h read position");
    assert_true(lines.at == 0); /* began before time did */
}

static void damage_and_length_are_told(void **state)
{
    struct lines lines = {.count = 0};
    struct lx_decoder decoder;
    (void)state;
    lx_decoder_init(&decoder, on_line, &lines);
    struct dg_tap_event event = character(DG_MS(3), false, 0x40);
    event.character.damaged = true;
    lx_decoder_event(&decoder, &event);
    (void)say(&decoder, DG_MS(3), false, "42 02");
    (void)lx_decoder_step(&decoder, DG_S(1));
    assert_string_equal(lines.text, "40h 42h read position, damaged");

    dg_ns at = DG_S(2);
    for (unsigned i = 0; i < 200; i++) {
        at = say(&decoder, at, false, "40");
    }
    (void)lx_decoder_step(&decoder, DG_S(9));
    assert_int_equal(lines.count, 2);
    assert_string_equal(lines.text,
                        "40h 40h unknown command: 40 40 40 40 40 40 40 40 40 40 40 40 40 "
                        "40 40 40 ..., 200 bytes are too many");
}

/* clang-format off */
static const struct {
    uint16_t id;
    const char *hex;
    const char *text;
} can[] = {
    {0x000, "01 05",                   "NMT start node 5"},
    {0x000, "82 00",                   "NMT reset communication all nodes"},
    {0x000, "33 01",                   "NMT 33h node 1"},
    {0x000, "01",                      "NMT, too short: 01"},
    {0x000, "02 05",                   "NMT stop node 5"},
    {0x000, "80 05",                   "NMT enter pre-operational node 5"},
    {0x000, "81 05",                   "NMT reset node 5"},
    {0x080, "",                        "SYNC"},
    {0x080, "07",                      "SYNC 7"},
    {0x085, "10 81 11 01 02 03 04 05", "EMCY node 5 8110h register 11h: 01 02 03 04 05"},
    {0x085, "00 00 00 00 00 00 00 00", "EMCY node 5 0000h no error, register 00h: 00 00 00 00 00"},
    {0x085, "00 10 01",                "EMCY node 5 1000h register 01h"},
    {0x085, "00 10",                   "EMCY node 5, too short: 00 10"},
    {0x0FF, "00 00 00",                "EMCY node 127 0000h no error, register 00h"},
    {0x100, "0D 30 B3 02 39",          "TIME, too short: 0D 30 B3 02 39"},
    {0x100, "0D 30 B3 02 39 30",       "TIME 45297677 ms, day 12345"},
    {0x185, "39 30 00 00",             "TPDO1 node 5: 39 30 00 00"},
    {0x2FF, "01",                      "TPDO2 node 127: 01"},
    {0x381, "01",                      "TPDO3 node 1: 01"},
    {0x481, "",                        "TPDO4 node 1"},
    {0x205, "01",                      "RPDO1 node 5: 01"},
    {0x180, "",                        "id 180h"},
    {0x181, "",                        "TPDO1 node 1"},
    {0x27F, "",                        "RPDO1 node 127"},
    {0x281, "",                        "TPDO2 node 1"},
    {0x301, "",                        "RPDO2 node 1"},
    {0x37F, "01",                      "RPDO2 node 127: 01"},
    {0x3FF, "",                        "TPDO3 node 127"},
    {0x47F, "",                        "RPDO3 node 127"},
    {0x501, "",                        "RPDO4 node 1"},
    {0x57F, "01",                      "RPDO4 node 127: 01"},
    {0x585, "20 00 00 00 00 00 00 00", "SDO node 5 -> download segment"},
    {0x585, "60 04 60 00 00 00 00",    "SDO node 5, too short: 60 04 60 00 00 00 00"},
    {0x605, "40 04 60 00 00 00 00",    "SDO node 5, too short: 40 04 60 00 00 00 00"},
    {0x600, "40",                      "id 600h: 40"},
    {0x605, "40 04 60 00 00 00 00 00", "SDO node 5 upload 6004h:00"},
    {0x585, "43 04 60 00 39 30 00 00", "SDO node 5 -> upload 6004h:00 = 00003039h"},
    {0x585, "4B 00 62 00 0A 00 00 00", "SDO node 5 -> upload 6200h:00 = 000Ah"},
    {0x585, "41 08 10 00 14 00 00 00", "SDO node 5 -> upload 1008h:00, 20 bytes"},
    {0x605, "2F 01 18 02 FE 00 00 00", "SDO node 5 download 1801h:02 = FEh"},
    {0x605, "22 01 18 02 FE 00 00 00", "SDO node 5 download 1801h:02 = 000000FEh"},
    {0x605, "20 01 18 02 FE 00 00 00", "SDO node 5 download 1801h:02, in segments"},
    {0x585, "60 01 18 02 00 00 00 00", "SDO node 5 -> download 1801h:02"},
    {0x605, "60 00 00 00 00 00 00 00", "SDO node 5 upload segment"},
    {0x585, "09 41 42 43 00 00 00 00", "SDO node 5 -> upload segment, the last: 41 42 43"},
    {0x605, "10 31 32 33 34 35 36 37", "SDO node 5 download segment: 31 32 33 34 35 36 37"},
    {0x585, "80 FF 9F 00 00 00 02 06", "SDO node 5 -> abort 9FFFh:00: 06020000h no such object"},
    {0x605, "80 FF 9F 00 78 56 34 12", "SDO node 5 abort 9FFFh:00: 12345678h unknown"},
    {0x585, "E0 00 00 00 00 00 00 00", "SDO node 5 -> unknown service: E0 00 00 00 00 00 00 00"},
    {0x585, "43 04",                   "SDO node 5, too short: 43 04"},
    {0x705, "00",                      "heartbeat node 5 boot-up"},
    {0x705, "85",                      "heartbeat node 5 operational, toggle"},
    {0x705, "7F",                      "heartbeat node 5 pre-operational"},
    {0x705, "04",                      "heartbeat node 5 stopped"},
    {0x705, "03",                      "heartbeat node 5 03h"},
    {0x77F, "05",                      "heartbeat node 127 operational"},
    {0x7E4, "11 00 00 00 00 00 00",    "LSS, too short: 11 00 00 00 00 00 00"},
    {0x7E5, "11 05 00 00 00 00 00",    "LSS, too short: 11 05 00 00 00 00 00"},
    {0x7E5, "04 01 00 00 00 00 00 00", "LSS switch state global 01h"},
    {0x7E5, "11 05 00 00 00 00 00 00", "LSS configure node-ID 05h"},
    {0x7E4, "11 00 00 00 00 00 00 00", "LSS -> configure node-ID 00h"},
    {0x7E5, "43 78 56 34 12 00 00 00", "LSS switch state selective serial number 12345678h"},
    {0x7E4, "44 00 00 00 00 00 00 00", "LSS -> switch state selective"},
    {0x7E5, "99 00 00 00 00 00 00 00", "LSS: 99 00 00 00 00 00 00 00"},
    {0x580, "43 04",                   "id 580h: 43 04"},
    {0x701, "",                        "heartbeat node 1, too short"},
};
/* clang-format on */

static void say_can(struct lx_decoder *decoder, uint16_t id, const char *hex)
{
    struct dg_tap_event event = {.at = 77, .kind = DG_TAP_FRAME, .ours = true};
    uint8_t bytes[8] = {0};
    event.frame.dlc = (uint8_t)bytes_of(hex, bytes);
    event.frame.id = id;
    memcpy(event.frame.data, bytes, sizeof bytes);
    lx_decoder_event(decoder, &event);
}

static void can_frames_in_the_words_of_canopen(void **state)
{
    (void)state;
    for (size_t i = 0; i < LENGTH(can); i++) {
        struct lines lines = {.count = 0};
        struct lx_decoder decoder;
        lx_decoder_init(&decoder, on_line, &lines);
        say_can(&decoder, can[i].id, can[i].hex);
        assert_int_equal(lines.count, 1);
        assert_string_equal(lines.text, can[i].text);
        assert_true(lines.at == 77 && lines.ours);
    }
}

/* clang-format off */
/* CiA 305: services with their arguments, from the master and from the slave. What there is no frame of has none. */
static const struct {
    uint8_t code;
    const char *name;
    const char *request;
    const char *reply;
} lss[] = {
    {0x04, "switch state global",                    " 78h",       ""},
    {0x11, "configure node-ID",                      " 78h",       " 78h"},
    {0x13, "configure bit timing",                   " 5678h",     " 78h"},
    {0x15, "activate bit timing",                    " 5678h",     ""},
    {0x17, "store configuration",                    "",           " 78h"},
    {0x40, "switch state selective vendor-ID",       " 12345678h", ""},
    {0x41, "switch state selective product code",    " 12345678h", ""},
    {0x42, "switch state selective revision",        " 12345678h", ""},
    {0x43, "switch state selective serial number",   " 12345678h", ""},
    {0x44, "switch state selective",                 "",           ""},
    {0x46, "identify vendor-ID",                     " 12345678h", ""},
    {0x47, "identify product code",                  " 12345678h", ""},
    {0x48, "identify revision from",                 " 12345678h", ""},
    {0x49, "identify revision to",                   " 12345678h", ""},
    {0x4A, "identify serial number from",            " 12345678h", ""},
    {0x4B, "identify serial number to",              " 12345678h", ""},
    {0x4C, "identify non-configured",                "",           ""},
    {0x4F, "identify slave",                         "",           ""},
    {0x50, "identify non-configured slave",          "",           ""},
    {0x51, "fastscan",                               " 12345678h", ""},
    {0x5A, "inquire vendor-ID",                      "",           " 12345678h"},
    {0x5B, "inquire product code",                   "",           " 12345678h"},
    {0x5C, "inquire revision",                       "",           " 12345678h"},
    {0x5D, "inquire serial number",                  "",           " 12345678h"},
    {0x5E, "inquire node-ID",                        "",           " 78h"},
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

static void can_is_told(uint16_t id, const char *hex, const char *before, const char *expected)
{
    struct lines lines = {.count = 0};
    struct lx_decoder decoder;
    char text[LX_DECODE_MAX];
    lx_decoder_init(&decoder, on_line, &lines);
    say_can(&decoder, id, hex);
    (void)snprintf(text, sizeof text, "%s%s", before, expected);
    assert_string_equal(lines.text, text);
}

static void every_service_of_lss_and_every_abort_has_its_words(void **state)
{
    char hex[32];
    char expected[80];
    (void)state;
    for (size_t i = 0; i < LENGTH(lss); i++) {
        (void)snprintf(hex, sizeof hex, "%02X 78 56 34 12 00 00 00", lss[i].code);
        (void)snprintf(expected, sizeof expected, "%s%s", lss[i].name, lss[i].request);
        can_is_told(0x7E5, hex, "LSS ", expected);
        (void)snprintf(expected, sizeof expected, "%s%s", lss[i].name, lss[i].reply);
        can_is_told(0x7E4, hex, "LSS -> ", expected);
    }
    for (size_t i = 0; i < LENGTH(aborts); i++) {
        (void)snprintf(hex, sizeof hex, "80 04 60 00 %s", aborts[i].hex);
        can_is_told(0x585, hex, "SDO node 5 -> abort 6004h:00: ", aborts[i].text);
        can_is_told(0x605, hex, "SDO node 5 abort 6004h:00: ", aborts[i].text);
    }
}

static void remote_frames(void **state)
{
    struct dg_tap_event event = {.kind = DG_TAP_FRAME, .frame = {.id = 0x705, .rtr = true}};
    struct lines lines = {.count = 0};
    struct lx_decoder decoder;
    (void)state;
    lx_decoder_init(&decoder, on_line, &lines);
    lx_decoder_event(&decoder, &event);
    assert_string_equal(lines.text, "heartbeat node 5 requested");
    event.frame.id = 0x7FF;
    lx_decoder_event(&decoder, &event);
    assert_string_equal(lines.text, "id 7FFh requested");
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
    struct lines lines = {.count = 0};
    struct lx_decoder decoder;
    (void)state;
    lx_decoder_init(&decoder, on_line, &lines);
    for (size_t i = 0; i < LENGTH(steps); i++) {
        say_can(&decoder, steps[i].id, steps[i].hex);
        assert_string_equal(lines.text, steps[i].text);
    }
}

static void interbus_words_that_changed(void **state)
{
    uint16_t in[4] = {1, 2, 3, 4};
    uint16_t out[4] = {0};
    struct dg_tap_event event = {
        .at = 5, .kind = DG_TAP_WORDS, .words = {.in = in, .out = out, .count = 4, .valid = true}};
    struct lines lines = {.count = 0};
    struct lx_decoder decoder;
    (void)state;
    lx_decoder_init(&decoder, on_line, &lines);
    lx_decoder_event(&decoder, &event);
    assert_string_equal(lines.text, "IN[0] 0001 0002 0003 0004 OUT[0] 0000 0000 0000 0000");
    lx_decoder_event(&decoder, &event);
    assert_int_equal(lines.count, 1);
    in[0] = 0xC200;
    in[2] = 0xFFFF;
    in[3] = 0;
    out[3] = 0x8000;
    lx_decoder_event(&decoder, &event);
    assert_string_equal(lines.text, "IN[0] C200 IN[2] FFFF 0000 OUT[3] 8000");
    event.words.valid = false;
    lx_decoder_event(&decoder, &event);
    assert_string_equal(lines.text, "cycle not completed");
    in[0] = 1;
    event.words.valid = true;
    lx_decoder_event(&decoder, &event);
    assert_string_equal(lines.text, "IN[0] 0001, cycles are valid");
    lx_decoder_event(&decoder, &event);
    assert_int_equal(lines.count, 4);
}

static void notes_as_they_are(void **state)
{
    char note[400];
    struct dg_tap_event event = {.at = 9, .kind = DG_TAP_NOTE, .note = "power off"};
    struct lines lines = {.count = 0};
    struct lx_decoder decoder;
    (void)state;
    lx_decoder_init(&decoder, on_line, &lines);
    lx_decoder_event(&decoder, &event);
    assert_string_equal(lines.text, "power off");
    assert_true(lines.at == 9 && !lines.ours);
    event.kind = DG_TAP_LEVELS;
    lx_decoder_event(&decoder, &event);
    assert_int_equal(lines.count, 1);
    memset(note, 'x', sizeof note);
    note[sizeof note - 1] = '\0';
    event.kind = DG_TAP_NOTE;
    event.note = note;
    lx_decoder_event(&decoder, &event);
    assert_int_equal(strlen(lines.text), LX_DECODE_MAX - 1);
    assert_string_equal(lines.text + LX_DECODE_MAX - 5, "x...");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_in_the_manuals_words),
        cmocka_unit_test(every_command_and_message_has_its_words),
        cmocka_unit_test(a_frame_ends_with_the_other_direction_or_silence),
        cmocka_unit_test(characters_in_a_bunch_are_a_frame),
        cmocka_unit_test(damage_and_length_are_told),
        cmocka_unit_test(can_frames_in_the_words_of_canopen),
        cmocka_unit_test(every_service_of_lss_and_every_abort_has_its_words),
        cmocka_unit_test(remote_frames),
        cmocka_unit_test(block_transfers),
        cmocka_unit_test(interbus_words_that_changed),
        cmocka_unit_test(notes_as_they_are),
    };
    return cmocka_run_group_tests_name("decode", tests, NULL, NULL);
}
