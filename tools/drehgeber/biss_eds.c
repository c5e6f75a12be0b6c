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
    const char *symbol;
    uint32_t scale; /* of the value, in the unit */
    const char *unit;
    const char *description;
};

/* clang-format off */
/* 5.2.1.3.1 */
static const struct field common_fields[] = {
    {0x00, 1, "EDS_VER",  1,   "",     "EDS version"},
    {0x01, 1, "EDS_LEN",  1,   "banks","EDS length"},
    {0x02, 1, "USR_STA",  1,   "",     "first user bank"},
    {0x03, 1, "USR_END",  1,   "",     "last user bank"},
    {0x04, 1, "TMA",      1,   "ns",   "minimum clock period on MA"},
    {0x05, 1, "TO_MIN",   250, "ns",   "minimum BiSS timeout"},
    {0x06, 1, "TO_MAX",   250, "ns",   "maximum BiSS timeout"},
    {0x07, 1, "TOS_MIN",  25,  "ns",   "minimum BiSS timeout_S"},
    {0x08, 1, "TOS_MAX",  25,  "ns",   "maximum BiSS timeout_S"},
    {0x09, 1, "TCLK_MIN", 25,  "ns",   "minimum sampling period, adaptive timeout"},
    {0x0A, 1, "TCLK_MAX", 25,  "ns",   "maximum sampling period, adaptive timeout"},
    {0x0B, 1, "TCYC",     250, "ns",   "minimum cycle time"},
    {0x0C, 1, "TBUSY_S",  250, "ns",   "maximum processing time SCD"},
    {0x0D, 1, "BUSY_S",   1,   "TMA",  "additional processing time SCD"},
    {0x0E, 2, "PON_DLY",  1,   "ms",   "maximum power on delay, control communication"},
    {0x10, 1, "DC_NUM",   1,   "",     "number of data channels"},
    {0x11, 1, "SL_NUM",   1,   "",     "number of slave addresses"},
    {0x12, 1, "SL_OFF",   1,   "",     "slave ID within this device"},
    {0x14, 1, "BANK1",    1,   "",     "bank of the profile EDS, data channel 1"},
    {0x15, 1, "DLEN1",    1,   "bit",  "data length, data channel 1"},
    {0x16, 1, "FORMAT1",  1,   "",     "data format, data channel 1"},
    {0x17, 1, "CPOLY1",   1,   "",     "CRC polynomial (8:1), data channel 1"},
    {0x3F, 1, "CHKSUM",   1,   "",     "sum of all bytes before"},
    {0},
};

/* 5.2.1.3.2 */
static const struct field profile_fields[] = {
    {0x00, 1, "BP_VER",   1,   "",     "BiSS profile 3 version"},
    {0x01, 1, "BP_LEN",   1,   "banks","length of this profile"},
    {0x02, 1, "BP_ID1",   1,   "",     "profile identification"},
    {0x03, 1, "BP_ID2",   1,   "bit",  "position, nE and nW"},
    {0x04, 1, "FB1",      1,   "",     "feedback bit 1: error"},
    {0x05, 1, "FB2",      1,   "",     "feedback bit 2: warning"},
    {0x06, 1, "PON_PDL",  100, "ms",   "maximum power on delay, position data"},
    {0x08, 1, "EN_TYP",   1,   "",     "encoder type, 0: rotary"},
    {0x09, 1, "POS_NUM",  1,   "",     "position value"},
    {0x0A, 1, "MT_LEN",   1,   "bit",  "data length MULTITURN"},
    {0x0B, 1, "MT_FMT",   1,   "",     "data format MULTITURN"},
    {0x0C, 1, "CO_LEN",   1,   "bit",  "data length COARSE"},
    {0x0D, 1, "CO_FMT",   1,   "",     "data format COARSE"},
    {0x0E, 1, "FI_LEN",   1,   "bit",  "data length FINE"},
    {0x0F, 1, "FI_FMT",   1,   "",     "data format FINE"},
    {0x10, 4, "MT_CNT",   1,   "turns","distinguishable revolutions"},
    {0x14, 4, "SIP_CNT",  1,   "",     "signal periods per revolution"},
    {0x18, 4, "SIP_RES",  1,   "LSB",  "resolution factor per signal period"},
    {0x1C, 4, "CPOLY",    1,   "",     "CRC polynomial (32:1)"},
    {0x20, 4, "CSTART",   1,   "",     "CRC start value"},
    {0x24, 2, "ABS_ACU",  1,   "",     "absolute accuracy"},
    {0x26, 2, "REL_ACU",  1,   "",     "repeat accuracy"},
    {0x28, 2, "SPD_ACU",  1,   "",     "speed-depending accuracy"},
    {0x2A, 2, "HYST",     1,   "",     "hysteresis"},
    {0x2C, 2, "SPD_MAX",  1,   "",     "maximum rotational speed"},
    {0x2E, 2, "ACC_MAX",  1,   "",     "maximum angular acceleration"},
    {0x30, 2, "TMP_MIN",  1,   "",     "minimum operating temperature"},
    {0x32, 2, "TMP_MAX",  1,   "",     "maximum operating temperature"},
    {0x34, 2, "VLT_MIN",  1,   "",     "minimum operating voltage"},
    {0x36, 2, "VLT_MAX",  1,   "",     "maximum operating voltage"},
    {0x38, 2, "CUR_MAX",  1,   "",     "maximum current consumption"},
    {0x3F, 1, "CHKSUM",   1,   "",     "sum of all bytes before"},
    {0},
};
/* clang-format on */

static void print_field(const struct field *field, const uint8_t *bank, FILE *to)
{
    char hex[12] = "";
    uint32_t value = 0;

    for (uint8_t i = 0; i < field->size; i++) {
        const uint8_t byte = bank[field->address + i];
        (void)snprintf(&hex[2 * i], sizeof hex - 2u * i, "%02X", byte);
        value = value << 8 | byte;
    }
    (void)fprintf(to, "0x%02X  %-8s  %-8s  %10" PRIu32 " %-5s  %s\n", field->address, field->symbol,
                  hex, value * field->scale, field->unit, field->description);
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
