/* SPDX-License-Identifier: MIT */
/*
 * Prints the generated part of src/biss/README.md from the device's own tables.
 */
#include <stdio.h>

#include "biss_private.h"
#include "parts.h"

/* What is where; a row of the device without one here is an error. */
static const struct {
    unsigned first;
    unsigned bank;
    const char *content;
} contents[] = {
    {0x00, 3, "EDS, common part (5.2.1.3.1)"},
    {0x00, 4, "EDS, BP3 part (5.2.1.3.2)"},
    {0x00, 7, "user data, virgin FFh"},
    {0x1B, 0, "OFFS_ST, DIR, RESO_CC, OFFS_MT (1Bh-21h), EMASK (22h), WMASK (23h)"},
    {0x40, 0, "bank select"},
    {0x41, 0, "EDS bank, profile id (42h-43h), serial number (44h-47h)"},
    {0x60, 0, "read: status; write: command"},
    {0x61, 0, "ST (61h-64h) and MT (65h-67h), as latched last"},
    {0x68, 0, "life counter"},
    {0x69, 0, "error register"},
    {0x6A, 0, "temperature in 0.1 degC, signed, low byte first"},
    {0x78, 0, "device id"},
    {0x7C, 0, "device id: timeout in bits 2..0, in RAM"},
    {0x7D, 0, "device id, manufacturer id 4Bh 55h (7Eh-7Fh)"},
};
#define CONTENT_COUNT DG_COUNT(contents)

static const char *content_of(const struct biss_register *row)
{
    for (size_t i = 0; i < CONTENT_COUNT; i++) {
        if (contents[i].first == row->first && contents[i].bank == row->bank_first) {
            return contents[i].content;
        }
    }
    return NULL;
}

/* 'a' or 'a-b', empty for every bank. */
static void print_range(const char *format, const char *dash, unsigned first, unsigned last)
{
    printf(format, first);
    if (last != first) {
        printf("%s", dash);
        printf(format, last);
    }
}

static int print_registers(void)
{
    puts("| bank | address | access | content |");
    puts("|---|---|---|---|");
    for (unsigned i = 0; i < dg_biss_register_count; i++) {
        const struct biss_register *row = &dg_biss_registers[i];
        const char *content = content_of(row);
        if (content == NULL) {
            (void)fprintf(stderr, "no content for %02Xh\n", row->first);
            return 1;
        }
        printf("| ");
        if (row->first <= BISS_WINDOW_END) {
            print_range("%u", "-", row->bank_first, row->bank_last);
        }
        printf(" | ");
        print_range("%02Xh", "-", row->first, row->last);
        printf(" | r%s%s | %s |\n", (row->access & BISS_WRITE) != 0 ? "w" : "",
               (row->access & BISS_EEPROM) != 0 ? ", EEPROM: busy" : "", content);
    }
    return 0;
}

static int print_regions(void)
{
    puts("| region | bytes | address |");
    puts("|---|---|---|");
    for (unsigned i = 0; i < dg_biss_layout.region_count; i++) {
        const struct dg_store_region *region = &dg_biss_layout.regions[i];
        printf("| %s | %u | %04Xh |\n", region->name, region->size,
               (unsigned)dg_store_address(&dg_biss_layout, (uint8_t)i));
    }
    return 0;
}

int main(int argc, char **argv)
{
    static const struct part parts[] = {
        {"registers", print_registers},
        {"regions", print_regions},
    };
    return print_one(argc, argv, parts, DG_COUNT(parts));
}
