/* SPDX-License-Identifier: MIT */
/* The EEPROM in RAM: what each kind of power cut leaves of three writes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "ram_nvm.h"

enum { SIZE = 16 };

static struct ram_nvm ram;

static int write_at(uint32_t address, const char *text)
{
    const struct dg_nvm nvm = ram_nvm_port(&ram);
    return nvm.ops->write(nvm.ctx, address, text, strlen(text));
}

static int sync_all(void)
{
    const struct dg_nvm nvm = ram_nvm_port(&ram);
    return nvm.ops->sync(nvm.ctx);
}

/* Content of the memory, '.' for an erased byte. */
static void assert_content(const char *expected)
{
    const struct dg_nvm nvm = ram_nvm_port(&ram);
    char text[SIZE + 1] = {0};
    assert_int_equal(nvm.ops->read(nvm.ctx, 0, text, SIZE), DG_OK);
    for (int i = 0; i < SIZE; i++) {
        text[i] = text[i] == '\xFF' ? '.' : text[i];
    }
    assert_string_equal(text, expected);
}

static int set_up(void **state)
{
    (void)state;
    ram_nvm_init(&ram, SIZE);
    return 0;
}

static void starts_erased_and_keeps_what_is_written(void **state)
{
    (void)state;
    assert_content("................");
    assert_int_equal(write_at(2, "abc"), DG_OK);
    assert_int_equal(write_at(13, "xyz"), DG_OK);
    assert_content("..abc........xyz");
    assert_int_equal(sync_all(), DG_OK);
    assert_int_equal(ram.writes, 2);
    assert_int_equal(ram.syncs, 1);
}

static void refuses_what_leaves_the_memory(void **state)
{
    const struct dg_nvm nvm = ram_nvm_port(&ram);
    uint8_t bytes[SIZE + 1] = {0};
    (void)state;
    assert_int_equal(nvm.ops->read(nvm.ctx, 0, bytes, SIZE + 1), DG_ERR_IO);
    assert_int_equal(nvm.ops->read(nvm.ctx, SIZE, bytes, 1), DG_ERR_IO);
    assert_int_equal(nvm.ops->read(nvm.ctx, UINT32_MAX, bytes, 1), DG_ERR_IO);
    assert_int_equal(nvm.ops->read(nvm.ctx, SIZE, bytes, 0), DG_OK);
    assert_int_equal(write_at(14, "abc"), DG_ERR_IO);
    assert_int_equal(write_at(UINT32_MAX, "a"), DG_ERR_IO);
    assert_content("................");
}

static void refuses_everything_without_acknowledge(void **state)
{
    const struct dg_nvm nvm = ram_nvm_port(&ram);
    uint8_t byte = 0;
    (void)state;
    assert_int_equal(write_at(0, "a"), DG_OK);
    ram.no_acknowledge = true;
    assert_int_equal(nvm.ops->read(nvm.ctx, 0, &byte, 1), DG_ERR_IO);
    assert_int_equal(write_at(0, "b"), DG_ERR_IO);
    assert_int_equal(sync_all(), DG_ERR_IO);
    ram.no_acknowledge = false;
    assert_content("a...............");
}

struct cut_row {
    enum ram_nvm_tear tear;
    uint32_t nth;
    uint32_t tear_at;
    const char *left;
};

/* clang-format off */
static const struct cut_row cut_rows[] = {
    /* "ss" is synced; then writes 2, 3 and 4 of the memory's life: "aaaa", "bbbb", "cccc" */
    {RAM_NVM_ORDERED,   0, 0, "ss.............."},
    {RAM_NVM_ORDERED,   0, 3, "ssaaa..........."},
    {RAM_NVM_ORDERED,   1, 1, "ssaaaab........."},
    {RAM_NVM_ORDERED,   2, 4, "ssaaaabbbbcccc.."},
    {RAM_NVM_ORDERED,   2, 9, "ssaaaabbbbcccc.."},
    {RAM_NVM_UNSYNCED,  0, 4, "ss.............."},
    {RAM_NVM_UNSYNCED,  2, 4, "ss.............."},
    {RAM_NVM_REORDERED, 0, 4, "ss.............."},
    {RAM_NVM_REORDERED, 1, 2, "ss....bb........"},
    {RAM_NVM_REORDERED, 2, 4, "ss....bbbb......"},
};
/* clang-format on */

static void a_cut_leaves_what_its_kind_says(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof cut_rows / sizeof cut_rows[0]; i++) {
        const struct cut_row *row = &cut_rows[i];
        ram_nvm_init(&ram, SIZE);
        assert_int_equal(write_at(0, "ss"), DG_OK);
        assert_int_equal(sync_all(), DG_OK);
        ram_nvm_cut(&ram, row->nth, row->tear, row->tear_at);
        assert_int_equal(write_at(2, "aaaa"), row->nth == 0 ? DG_ERR_IO : DG_OK);
        assert_int_equal(write_at(6, "bbbb"), row->nth <= 1 ? DG_ERR_IO : DG_OK);
        assert_int_equal(write_at(10, "cccc"), DG_ERR_IO);
        assert_true(ram.dead);
        assert_int_equal(sync_all(), DG_ERR_IO);
        ram_nvm_restore(&ram);
        assert_content(row->left);
    }
}

static void a_garbled_write_leaves_noise_behind_the_tear(void **state)
{
    (void)state;
    ram_nvm_cut(&ram, 1, RAM_NVM_GARBLED, 2);
    assert_int_equal(write_at(0, "aaaa"), DG_OK);
    assert_int_equal(write_at(4, "bbbbbbbb"), DG_ERR_IO);
    ram_nvm_restore(&ram);
    assert_memory_equal(ram.bytes, "aaaabb", 6);
    assert_memory_not_equal(ram.bytes + 6, "bbbbbb", 6);
    assert_memory_not_equal(ram.bytes + 6, "\xFF\xFF\xFF\xFF\xFF\xFF", 6);
    assert_memory_equal(ram.bytes + 12, "\xFF\xFF\xFF\xFF", 4);
}

static void restored_power_stays_and_makes_the_rest_durable(void **state)
{
    (void)state;
    ram_nvm_cut(&ram, 0, RAM_NVM_ORDERED, 1);
    assert_int_equal(write_at(0, "ab"), DG_ERR_IO);
    ram_nvm_restore(&ram);
    assert_int_equal(write_at(1, "c"), DG_OK);
    assert_int_equal(sync_all(), DG_OK);
    ram_nvm_cut(&ram, 0, RAM_NVM_UNSYNCED, 0);
    assert_int_equal(write_at(2, "d"), DG_ERR_IO);
    ram_nvm_restore(&ram);
    assert_content("ac..............");
}

static void two_memories_do_not_meet(void **state)
{
    static struct ram_nvm other;
    const struct dg_nvm nvm = ram_nvm_port(&other);
    (void)state;
    ram_nvm_init(&other, SIZE);
    ram_nvm_cut(&ram, 0, RAM_NVM_ORDERED, 0);
    assert_int_equal(write_at(0, "a"), DG_ERR_IO);
    assert_int_equal(nvm.ops->write(nvm.ctx, 0, "b", 1), DG_OK);
    assert_int_equal(other.bytes[0], 'b');
    assert_int_equal(ram.bytes[0], 0xFF);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(starts_erased_and_keeps_what_is_written, set_up),
        cmocka_unit_test_setup(refuses_what_leaves_the_memory, set_up),
        cmocka_unit_test_setup(refuses_everything_without_acknowledge, set_up),
        cmocka_unit_test_setup(a_cut_leaves_what_its_kind_says, set_up),
        cmocka_unit_test_setup(a_garbled_write_leaves_noise_behind_the_tear, set_up),
        cmocka_unit_test_setup(restored_power_stays_and_makes_the_rest_durable, set_up),
        cmocka_unit_test_setup(two_memories_do_not_meet, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
