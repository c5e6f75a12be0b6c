/* SPDX-License-Identifier: MIT */
/*
 * The tables of the S36 with RS485: the commands against 5.1.2 and against the buffers, the EEPROM
 * layout, the models; and every command driven to see that its row tells the truth.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "hf_rig.h"
#include "hiperface_private.h"

#define RESET 0x53u

/* The tables of 5.1.2: data bytes of request and reply, reaction time. Where the text contradicts
 * its own example, the example: 43h replies nothing, 55h replies (spec R3, R7). */
static const struct {
    uint8_t code;
    uint8_t request_min;
    uint8_t request_max;
    uint8_t reply_max;
    uint8_t reaction_ms;
} manual[] = {
    {0x42, 0, 0, 4, 10}, {0x43, 5, 5, 0, 40}, {0x44, 1, 1, 3, 5},    {0x46, 0, 0, 3, 5},
    {0x47, 0, 0, 0, 30}, {0x49, 1, 1, 0, 30}, {0x4A, 4, 4, 131, 30}, {0x4B, 5, 132, 3, 250},
    {0x4C, 1, 1, 2, 5},  {0x4D, 3, 3, 2, 70}, {0x4E, 0, 0, 2, 5},    {0x4F, 3, 3, 1, 40},
    {0x50, 0, 0, 1, 5},  {0x52, 0, 0, 4, 5},  {0x53, 0, 0, 0, 0},    {0x55, 2, 2, 0, 40},
    {0x56, 0, 0, 37, 5}, {0x57, 2, 2, 1, 40}, {0x6A, 5, 5, 4, 40},
};

/* What the reference pages are made from: names and error conditions of the same rows. */
#define DG_HF_COMMAND(code, name, min, max, reply, reaction_ms, flags, handler, errors)            \
    {name, errors},
static const struct {
    const char *name;
    const char *errors;
} words[] = {
#include "commands.def"
};

static struct hf_rig rig;

static int set_up(void **state)
{
    (void)state;
    return hf_rig_init(&rig, dg_hf_model_of(dg_device_find("s3684-rs485"))) != DG_OK ||
           hf_rig_power_on(&rig) != DG_OK;
}

static void commands_are_those_of_the_manual(void **state)
{
    (void)state;
    assert_int_equal(dg_hf_command_count, DG_COUNT(manual));
    for (size_t i = 0; i < DG_COUNT(manual); i++) {
        const struct hf_command *row = &dg_hf_commands[i];
        assert_int_equal(row->code, manual[i].code);
        assert_int_equal(row->request_min, manual[i].request_min);
        assert_int_equal(row->request_max, manual[i].request_max);
        assert_int_equal(row->reply_max, manual[i].reply_max);
        assert_int_equal(row->reaction_ms, manual[i].reaction_ms);
    }
}

static void commands_are_sorted_and_found(void **state)
{
    size_t found = 0;

    (void)state;
    for (uint8_t i = 1; i < dg_hf_command_count; i++) {
        assert_true(dg_hf_commands[i - 1].code < dg_hf_commands[i].code);
    }
    for (unsigned code = 0; code <= 0xFF; code++) {
        const uint8_t at = dg_hf_command_find((uint8_t)code);
        const struct hf_command *row = at < dg_hf_command_count ? &dg_hf_commands[at] : NULL;
        found += row != NULL;
        assert_true(row == NULL || row->code == code);
    }
    assert_int_equal(found, dg_hf_command_count);
}

static void commands_fit_the_buffers(void **state)
{
    (void)state;
    assert_int_equal(HF_DATA_MAX, DG_HF_FRAME_MAX - 3u);
    for (uint8_t i = 0; i < dg_hf_command_count; i++) {
        const struct hf_command *row = &dg_hf_commands[i];
        assert_in_range(row->code, 0x40, 0x7F); /* 5.1.2 */
        assert_true(row->request_min <= row->request_max);
        assert_true(row->request_max <= HF_DATA_MAX);
        assert_true(row->reply_max <= HF_DATA_MAX);
        assert_true((row->handler == NULL) == (row->code == RESET));
        /* Code 0 is looked for in the last byte, so there has to be one, always at one place. */
        assert_true((row->flags & HF_CODE0) == 0 || row->request_min > 0);
        assert_true((row->flags & HF_CODE0) == 0 || row->request_min == row->request_max);
        /* What is locked with 03h or 06h is so because it uses the EEPROM. */
        assert_true((row->flags & (HF_LOCK_CHECKSUM | HF_LOCK_PARTITION)) == 0 ||
                    (row->flags & HF_LOCK_EEPROM) != 0);
    }
}

/* Whether the row's error conditions have `code`, two digits. */
static bool can_answer(size_t row, const char *code)
{
    return strstr(words[row].errors, code) != NULL;
}

static void names_and_error_conditions_agree_with_the_flags(void **state)
{
    (void)state;
    assert_int_equal(DG_COUNT(words), dg_hf_command_count);
    for (size_t i = 0; i < DG_COUNT(words); i++) {
        const uint8_t flags = dg_hf_commands[i].flags;
        assert_true(strlen(words[i].name) > 0);
        for (size_t k = 0; k < i; k++) {
            assert_string_not_equal(words[i].name, words[k].name);
        }
        assert_int_equal(can_answer(i, "02"), (flags & HF_LOCK_POSITION) != 0);
        assert_int_equal(can_answer(i, "05"), (flags & HF_LOCK_EEPROM) != 0);
        assert_int_equal(can_answer(i, "06"), (flags & HF_LOCK_CHECKSUM) != 0);
        assert_int_equal(can_answer(i, "03"), (flags & HF_LOCK_PARTITION) != 0);
        assert_true(can_answer(i, "0F") || (flags & HF_CODE0) == 0);
        uint8_t codes[16];
        const size_t n = hf_rig_hex(words[i].errors, codes, sizeof codes);
        assert_int_equal(strlen(words[i].errors), n == 0 ? 0 : 3 * n - 1);
        for (size_t k = 1; k < n; k++) {
            assert_true(codes[k - 1] < codes[k]);
        }
    }
}

/* EEPROM. */

static void regions_have_names_sizes_and_start_up_errors(void **state)
{
    (void)state;
    assert_int_equal(dg_hf_layout.region_count, DG_HF_REGION_COUNT);
    assert_in_range(dg_hf_layout.region_count, 1, DG_STORE_REGIONS_MAX);
    for (uint8_t i = 0; i < dg_hf_layout.region_count; i++) {
        const struct dg_store_region *region = &dg_hf_layout.regions[i];
        const bool checked = region->check == DG_STORE_CHECKED;
        assert_true(region->size > 0);
        assert_true(!checked || region->size <= DG_STORE_CHECKED_MAX);
        assert_int_equal(region->startup_code != 0, checked);
        assert_true(!checked || region->defaults != NULL);
        assert_true(strlen(region->name) > 0);
        assert_int_equal(strspn(region->name, "abcdefghijklmnopqrstuvwxyz-"), strlen(region->name));
        assert_int_equal(dg_store_find(&dg_hf_layout, region->name), i); /* so it is unique */
    }
}

static void regions_stand_one_behind_the_other(void **state)
{
    (void)state;
    for (uint8_t i = 0; i < dg_hf_layout.region_count; i++) {
        const struct dg_store_region *region = &dg_hf_layout.regions[i];
        const uint32_t next = i + 1u < dg_hf_layout.region_count
                                  ? dg_store_address(&dg_hf_layout, (uint8_t)(i + 1u))
                                  : dg_store_size(&dg_hf_layout);
        const uint32_t sum = region->check == DG_STORE_CHECKED ? 2 : 0;
        assert_int_equal(next - dg_store_address(&dg_hf_layout, i), region->size + sum);
    }
    assert_true(dg_store_size(&dg_hf_layout) <= RAM_NVM_MAX);
}

/* Every default fills its region to the last byte and not beyond, whatever was there. */
static void defaults_fill_their_regions(void **state)
{
    (void)state;
    for (uint8_t i = 0; i < dg_hf_layout.region_count; i++) {
        const struct dg_store_region *region = &dg_hf_layout.regions[i];
        uint8_t low[DG_STORE_CHECKED_MAX + 8];
        uint8_t high[DG_STORE_CHECKED_MAX + 8];
        if (region->defaults == NULL) {
            continue;
        }
        memset(low, 0x00, sizeof low);
        memset(high, 0xFF, sizeof high);
        for (size_t d = 0; d < dg_device_count; d++) {
            if (dg_devices[d]->stack != &dg_hf_stack) {
                continue;
            }
            region->defaults(dg_hf_model_of(dg_devices[d]), low);
            region->defaults(dg_hf_model_of(dg_devices[d]), high);
            assert_memory_equal(low, high, region->size);
            for (size_t k = region->size; k < sizeof low; k++) {
                assert_true(low[k] == 0x00 && high[k] == 0xFF);
            }
        }
    }
}

/* 6 bytes for each change of a commit (store.h). */
static void the_journal_holds_the_longest_commit(void **state)
{
    const uint32_t content = (6 + 128) + (6 + 2);
    const uint32_t table = 6u + dg_hf_layout.regions[DG_HF_REGION_FIELDS].size + (6 + 2);

    (void)state;
    assert_true(dg_hf_layout.journal_size >= content);
    assert_true(dg_hf_layout.journal_size >= table);
    for (uint8_t i = 0; i < dg_hf_layout.region_count; i++) {
        const struct dg_store_region *region = &dg_hf_layout.regions[i];
        assert_true(region->check != DG_STORE_CHECKED ||
                    dg_hf_layout.journal_size >= 6u + region->size);
    }
    /* And in practice: all of a field's content at once, created and enlarged at once. */
    uint8_t save[4 + 1 + 128] = {0x4B, 0, 0, 128, DG_HF_CODE_DEFAULT};
    assert_int_equal(hf_rig_ask(&rig, "4D 00 CF 55"), 0);
    assert_int_equal(hf_rig_ask_bytes(&rig, save, sizeof save), 0);
    assert_int_equal(hf_rig_ask(&rig, "4D 00 4F 55"), 0);
    assert_int_equal(hf_rig_ask(&rig, "4D 00 C8 55"), 0);
    assert_int_equal(hf_rig_ask(&rig, "4D 00 CF 55"), 0);
}

/* 112 fields of one block: no further one fits, and the last one works. */
static void as_many_fields_as_there_are_blocks(void **state)
{
    (void)state;
    for (unsigned number = 0; number < HF_FIELDS_MAX; number++) {
        const uint8_t create[] = {0x4D, (uint8_t)number, 0xC8, DG_HF_CODE_DEFAULT};
        assert_int_equal(hf_rig_ask_bytes(&rig, create, sizeof create), 0);
    }
    assert_int_equal(hf_rig_ask(&rig, "4D 70 C8 55"), DG_HF_FIELD_SIZE);
    assert_int_equal(hf_rig_ask(&rig, "4E"), 0);
    assert_int_equal(rig.reply[2], 0);
    assert_int_equal(rig.reply[3], HF_FIELDS_MAX);
    assert_int_equal(hf_rig_ask(&rig, "4B 6F 0F 01 55 A5"), 0);
    assert_int_equal(hf_rig_ask(&rig, "4A 6F 0E 02 55"), 0);
    assert_int_equal(rig.reply[5], 0xFF);
    assert_int_equal(rig.reply[6], 0xA5);
    assert_int_equal(hf_rig_ask(&rig, "4A 6F 0F 02 55"), DG_HF_FIELD_OFFSET);
    assert_int_equal(hf_rig_ask(&rig, "4B 6F 0F 02 55 A5 A5"), DG_HF_FIELD_OFFSET);
    assert_int_equal(hf_rig_ask(&rig, "4A 6F FF FF 55"), DG_HF_FIELD_OFFSET);
}

/* Models. */

static void models_are_unique_and_run(void **state)
{
    (void)state;
    assert_true(dg_device_count > 0);
    for (size_t i = 0; i < dg_device_count; i++) {
        assert_ptr_equal(dg_device_find(dg_devices[i]->name), dg_devices[i]);
        if (dg_devices[i]->stack != &dg_hf_stack) {
            continue;
        }
        assert_int_equal(hf_rig_init(&rig, dg_hf_model_of(dg_devices[i])), DG_OK);
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        assert_int_equal(hf_rig_ask(&rig, "42"), 0);
        assert_int_equal(hf_rig_ask(&rig, "50"), 0);
        assert_int_equal(rig.reply[2], DG_HF_NO_ERROR);
    }
    assert_null(dg_device_find(""));
    assert_null(dg_device_find("s3684"));
    assert_null(dg_device_find("s3684-rs485x"));
}

/* Every command, right and wrong. */
static const char *const requests[] = {
    "42",
    "43 00 00 12 34 55",
    "43 00 00 12 34 00",
    "43 FF FF FF FF 55",
    "44 48",
    "44 49",
    "44 4A",
    "44 4B",
    "46",
    "47",
    "49 55",
    "49 54",
    "4D 00 CF 55",
    "4D 01 C8 55",
    "4D 00 C8 55",
    "4D 02 48 55",
    "4D FF C8 55",
    "4A 00 00 80 55",
    "4A 00 01 80 55",
    "4A 01 00 10 55",
    "4A FF 00 40 00",
    "4A 00 00 00 55",
    "4A 02 00 01 55",
    "4B 00 7F 01 55 AA",
    "4B 01 00 02 55 AA BB",
    "4B 01 00 02 54 AA BB",
    "4B FF 00 01 55 00",
    "4C 00",
    "4C FF",
    "4C 02",
    "4E",
    "4F 03 55 66",
    "4F 03 55 66",
    "4F 04 55 66",
    "50",
    "52",
    "53",
    "55 41 55",
    "55 60 55",
    "56",
    "57 E4 55",
    "57 E7 55",
    "6A 00 00 12 34 55",
    "6A 00 00 12 34 00",
};

/* A reply is never longer than its row says and one is as long, and an error response is one byte.
 */
static void replies_are_as_long_as_their_rows_say(void **state)
{
    size_t longest[0x80] = {0};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(requests); i++) {
        uint8_t code = 0;
        assert_int_equal(hf_rig_hex(requests[i], &code, 1), 1);
        const int status = hf_rig_ask(&rig, requests[i]);
        if (status > 0) {
            assert_int_equal(rig.reply_length, 4);
        } else if (status == 0) {
            const size_t n = rig.reply_length - 3u;
            longest[code] = n > longest[code] ? n : longest[code];
        } else {
            assert_int_equal(code, RESET);
        }
    }
    for (uint8_t i = 0; i < dg_hf_command_count; i++) {
        assert_int_equal(longest[dg_hf_commands[i].code], dg_hf_commands[i].reply_max);
    }
    assert_int_equal(rig.replies, DG_COUNT(requests) - 1u); /* all but the reset */
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(commands_are_those_of_the_manual),
        cmocka_unit_test(commands_are_sorted_and_found),
        cmocka_unit_test(commands_fit_the_buffers),
        cmocka_unit_test(names_and_error_conditions_agree_with_the_flags),
        cmocka_unit_test(regions_have_names_sizes_and_start_up_errors),
        cmocka_unit_test(regions_stand_one_behind_the_other),
        cmocka_unit_test(defaults_fill_their_regions),
        cmocka_unit_test_setup(the_journal_holds_the_longest_commit, set_up),
        cmocka_unit_test_setup(as_many_fields_as_there_are_blocks, set_up),
        cmocka_unit_test(models_are_unique_and_run),
        cmocka_unit_test_setup(replies_are_as_long_as_their_rows_say, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
