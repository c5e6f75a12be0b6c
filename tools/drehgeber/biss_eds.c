/* SPDX-License-Identifier: MIT */
#include "biss_eds.h"

#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>

#define CHECKSUM 0x3Fu

/* A field as the manual's tables have it; numbers are big endian. */
struct field {
    uint8_t address;
    uint8_t size;
    uint16_t scale; /* of the value, in the unit */
    const char *symbol;
    const char *unit;
    const char *description;
};

/* clang-format off */
/* 5.2.1.3.1 */
static const struct field common_fields[] = {
    {0x00, 1, 1,    "EDS_VER",   "",     "EDS version"},
    {0x01, 1, 1,    "EDS_LEN",   "banks","EDS length"},
    {0x02, 1, 1,    "USR_STA",   "",     "first user bank"},
    {0x03, 1, 1,    "USR_END",   "",     "last user bank"},
    {0x04, 1, 1,    "TMA",       "ns",   "minimum clock period on MA"},
    {0x05, 1, 250,  "TO_MIN",    "ns",   "minimum BiSS timeout"},
    {0x06, 1, 250,  "TO_MAX",    "ns",   "maximum BiSS timeout"},
    {0x07, 1, 25,   "TOS_MIN",   "ns",   "minimum BiSS timeout_S"},
    {0x08, 1, 25,   "TOS_MAX",   "ns",   "maximum BiSS timeout_S"},
    {0x09, 1, 25,   "TCLK_MIN",  "ns",   "minimum sampling period, adaptive timeout"},
    {0x0A, 1, 25,   "TCLK_MAX",  "ns",   "maximum sampling period, adaptive timeout"},
    {0x0B, 1, 250,  "TCYC",      "ns",   "minimum cycle time"},
    {0x0C, 1, 250,  "TBUSY_S",   "ns",   "maximum processing time SCD"},
    {0x0D, 1, 1,    "BUSY_S",    "TMA",  "additional processing time SCD"},
    {0x0E, 2, 1,    "PON_DLY",   "ms",   "maximum power on delay, control communication"},
    {0x10, 1, 1,    "DC_NUM",    "",     "number of data channels"},
    {0x11, 1, 1,    "SL_NUM",    "",     "number of slave addresses"},
    {0x12, 1, 1,    "SL_OFF",    "",     "slave ID within this device"},
    {0x14, 1, 1,    "BANK1",     "",     "bank of the profile EDS, data channel 1"},
    {0x15, 1, 1,    "DLEN1",     "bit",  "data length, data channel 1"},
    {0x16, 1, 1,    "FORMAT1",   "",     "data format, data channel 1"},
    {0x17, 1, 1,    "CPOLY1",    "",     "CRC polynomial (8:1), data channel 1"},
    {0x3F, 1, 1,    "CHKSUM",    "",     "sum of all bytes before"},
    {0},
};

/* 5.2.1.3.2 */
static const struct field profile_fields[] = {
    {0x00, 1, 1,    "BP_VER",    "",     "BiSS profile 3 version"},
    {0x01, 1, 1,    "BP_LEN",    "banks","length of this profile"},
    {0x02, 1, 1,    "BP_ID1",    "",     "profile identification"},
    {0x03, 1, 1,    "BP_ID2",    "bit",  "position, nE and nW"},
    {0x04, 1, 1,    "FB1",       "",     "feedback bit 1: error"},
    {0x05, 1, 1,    "FB2",       "",     "feedback bit 2: warning"},
    {0x06, 1, 100,  "PON_PDL",   "ms",   "maximum power on delay, position data"},
    {0x08, 1, 1,    "EN_TYP",    "",     "encoder type, 0: rotary"},
    {0x09, 1, 1,    "POS_NUM",   "",     "position value"},
    {0x0A, 1, 1,    "MT_LEN",    "bit",  "data length MULTITURN"},
    {0x0B, 1, 1,    "MT_FMT",    "",     "data format MULTITURN"},
    {0x0C, 1, 1,    "CO_LEN",    "bit",  "data length COARSE"},
    {0x0D, 1, 1,    "CO_FMT",    "",     "data format COARSE"},
    {0x0E, 1, 1,    "FI_LEN",    "bit",  "data length FINE"},
    {0x0F, 1, 1,    "FI_FMT",    "",     "data format FINE"},
    {0x10, 4, 1,    "MT_CNT",    "turns","distinguishable revolutions"},
    {0x14, 4, 1,    "SIP_CNT",   "",     "signal periods per revolution"},
    {0x18, 4, 1,    "SIP_RES",   "LSB",  "resolution factor per signal period"},
    {0x1C, 4, 1,    "CPOLY",     "",     "CRC polynomial (32:1)"},
    {0x20, 4, 1,    "CSTART",    "",     "CRC start value"},
    {0x24, 2, 1,    "ABS_ACU",   "",     "absolute accuracy"},
    {0x26, 2, 1,    "REL_ACU",   "",     "repeat accuracy"},
    {0x28, 2, 1,    "SPD_ACU",   "",     "speed-depending accuracy"},
    {0x2A, 2, 1,    "HYST",      "",     "hysteresis"},
    {0x2C, 2, 1,    "SPD_MAX",   "",     "maximum rotational speed"},
    {0x2E, 2, 1,    "ACC_MAX",   "",     "maximum angular acceleration"},
    {0x30, 2, 1,    "TMP_MIN",   "",     "minimum operating temperature"},
    {0x32, 2, 1,    "TMP_MAX",   "",     "maximum operating temperature"},
    {0x34, 2, 1,    "VLT_MIN",   "",     "minimum operating voltage"},
    {0x36, 2, 1,    "VLT_MAX",   "",     "maximum operating voltage"},
    {0x38, 2, 1,    "CUR_MAX",   "",     "maximum current consumption"},
    {0x3F, 1, 1,    "CHKSUM",    "",     "sum of all bytes before"},
    {0},
};
/* clang-format on */

static void print_field(const struct field *field, const uint8_t *bank, FILE *to)
{
    const int digits = 2 * field->size;
    uint32_t value = 0;

    for (uint8_t i = 0; i < field->size; i++) {
        value = value << 8 | bank[field->address + i];
    }
    (void)fprintf(to, "0x%02X  %-8s  %0*" PRIX32 "%*s  %10" PRIu32 " %-5s  %s\n", field->address,
                  field->symbol, digits, value, 8 - digits, "", value * field->scale, field->unit,
                  field->description);
}

static bool print_bank(const char *title, const struct field *field, const uint8_t *bank, FILE *to)
{
    uint8_t sum = 0;

    (void)fprintf(to, "%s\n", title);
    for (; field->symbol != NULL; field++) {
        print_field(field, bank, to);
    }
    for (unsigned i = 0; i < CHECKSUM; i++) {
        sum = (uint8_t)(sum + bank[i]);
    }
    (void)fprintf(to, "check sum %s\n", sum == bank[CHECKSUM] ? "valid" : "WRONG");
    return sum == bank[CHECKSUM];
}

int biss_eds_print(const uint8_t common[64], const uint8_t profile[64], FILE *to)
{
    const bool first = print_bank("Bank 3: EDS, common part", common_fields, common, to);

    (void)fprintf(to, "\n");
    return print_bank("Bank 4: EDS, BP3 part", profile_fields, profile, to) && first ? 0 : -1;
}
