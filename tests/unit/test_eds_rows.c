/* SPDX-License-Identifier: MIT */
/*
 * EDS files that were written down as C: which hook each row is given, and that such rows do on the
 * bus what those of the file do.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "drehgeber/eds_rows.h"
#include "eds_rig.h"

#define SAVE 0x65766173u
#define LOAD 0x64616F6Cu
#define ROWS_MAX 128u

#define TYPE "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
#define PARTS                                                                                      \
    "[1010sub1]\nDataType=7\nAccessType=rw\n[1010sub2]\nDataType=7\nAccessType=rw\n"               \
    "[1011sub1]\nDataType=7\nAccessType=rw\n[1011sub2]\nDataType=7\nAccessType=rw\n"
#define VALUES                                                                                     \
    "[2000]\nDataType=3\nAccessType=rw\nDefaultValue=-5\nLowLimit=-9\nHighLimit=9\n"               \
    "[2001]\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+7\n"                                  \
    "[2002]\nDataType=7\nAccessType=ro\nDefaultValue=$NODEID+8\n"                                  \
    "[2003]\nDataType=5\nAccessType=ro\nDefaultValue=0xA5\n"
#define ENCODER                                                                                    \
    "[1800sub1]\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+0x180\n"                          \
    "[1800sub2]\nDataType=5\nAccessType=rw\nDefaultValue=1\n"                                      \
    "[1A00sub0]\nDataType=5\nAccessType=rw\nDefaultValue=1\n"                                      \
    "[1A00sub1]\nDataType=7\nAccessType=rw\nDefaultValue=0x60040020\n"                             \
    "[6003]\nDataType=7\nAccessType=rw\n[6004]\nDataType=7\nAccessType=ro\nPDOMapping=1\n"
#define FILE_TEXT TYPE PARTS VALUES ENCODER

static struct eds_rig rig;
/* What the C file would have: the same figures and cells, rows by the names of hooks. */
static struct dg_cia406_file written;
static struct dg_co_row rows[ROWS_MAX];

static void write_down(void)
{
    const struct dg_co_device *from = &rig.file.file.device;
    struct dg_co_device *device = &written.file.device;

    assert_true(from->hidden + (size_t)from->dictionary.count <= ROWS_MAX);
    written = rig.file;
    memcpy(rows, from->dictionary.rows - from->hidden,
           (from->hidden + (size_t)from->dictionary.count) * sizeof *rows);
    for (uint16_t i = 0; i < from->dictionary.count; i++) {
        rows[from->hidden + i].hook = (uint8_t)dg_co_row_hook_of(&rig.file.file, i);
        assert_in_range(rows[from->hidden + i].hook, 0, DG_CO_ROW_HOOK_COUNT - 1);
    }
    device->dictionary.rows = &rows[from->hidden];
    device->dictionary.hooks = dg_co_row_hooks;
    device->layout = &written.file.layout;
    device->sample = dg_co_sample_file;
    device->step = dg_co_step_file;
    written.model.device = device;
}

static void start_model(const struct dg_cia406_model *model)
{
    co_rig_start_model(&rig.co, model);
    assert_int_equal(dg_co_burn_node_id(model->device, ram_nvm_port(&rig.co.nvm), EDS_RIG_NODE),
                     DG_OK);
    assert_int_equal(co_rig_power_on(&rig.co), DG_OK);
    co_rig_forget(&rig.co);
}

static void start_written(const char *text)
{
    eds_rig_read_text(&rig, text);
    write_down();
    start_model(&written.model);
}

/* @return the hook that the row of a key would have */
static enum dg_co_row_hook hook_at(uint32_t key)
{
    const struct dg_co_dictionary *dictionary = &rig.file.file.device.dictionary;

    for (uint16_t i = 0; i < dictionary->count; i++) {
        if ((dictionary->rows[i].key & 0xFFFFFF00u) == key) {
            return dg_co_row_hook_of(&rig.file.file, i);
        }
    }
    fail_msg("no row of %08x", key);
    return DG_CO_ROW_HOOK_COUNT;
}

/* ------------------------------------------------------------ hooks by name */

static void each_row_is_given_its_hook(void **state)
{
    static const struct {
        uint32_t key;
        enum dg_co_row_hook hook;
    } expected[] = {
        {DG_CO_KEY(0x1000, 0), DG_CO_HOOK_BASE},    {DG_CO_KEY(0x1010, 1), DG_CO_HOOK_KEEP},
        {DG_CO_KEY(0x1010, 2), DG_CO_HOOK_KEEP},    {DG_CO_KEY(0x1011, 1), DG_CO_HOOK_BASE},
        {DG_CO_KEY(0x1011, 2), DG_CO_HOOK_BASE},    {DG_CO_KEY(0x1800, 1), DG_CO_HOOK_BASE},
        {DG_CO_KEY(0x2000, 0), DG_CO_HOOK_CELL},    {DG_CO_KEY(0x2001, 0), DG_CO_HOOK_CELL},
        {DG_CO_KEY(0x2002, 0), DG_CO_HOOK_FOLLOWS}, {DG_CO_KEY(0x2003, 0), DG_CO_HOOK_NONE},
        {DG_CO_KEY(0x6003, 0), DG_CO_HOOK_BASE},    {DG_CO_KEY(0x6004, 0), DG_CO_HOOK_NONE},
    };
    (void)state;
    eds_rig_read_text(&rig, FILE_TEXT);
    for (size_t i = 0; i < DG_COUNT(expected); i++) {
        if (hook_at(expected[i].key) != expected[i].hook) {
            fail_msg("%08x: hook %d", expected[i].key, hook_at(expected[i].key));
        }
    }
}

/* 64 bits have no row in C, neither beside objects of the base nor in the place of one. */
static void a_hook_of_another_kind_has_no_name(void **state)
{
    (void)state;
    eds_rig_read_text(&rig, TYPE "[2000]\nDataType=0x1B\nAccessType=rw\nDefaultValue=1\n"
                                 "[6003]\nDataType=0x1B\nAccessType=rw\nDefaultValue=1\n");
    assert_int_equal(hook_at(DG_CO_KEY(0x2000, 0)), DG_CO_ROW_HOOK_COUNT);
    assert_int_equal(hook_at(DG_CO_KEY(0x6003, 0)), DG_CO_ROW_HOOK_COUNT);
}

/* ------------------------------------------------------------ on the bus */

static void written_rows_answer_as_the_file(void **state)
{
    (void)state;
    start_written(FILE_TEXT);
    assert_int_equal(co_rig_get(&rig.co, 0x1000, 0), 0x20196);
    assert_int_equal(co_rig_get(&rig.co, 0x2000, 0), 0xFFFB);
    assert_int_equal(co_rig_write(&rig.co, 0x2000, 0, 10, 2), DG_CO_RANGE);
    assert_int_equal(co_rig_get(&rig.co, 0x2001, 0), EDS_RIG_NODE + 7u);
    assert_int_equal(co_rig_get(&rig.co, 0x2002, 0), EDS_RIG_NODE + 8u);
    assert_int_equal(co_rig_write(&rig.co, 0x2002, 0, 1, 4), DG_CO_READ_ONLY);
    assert_int_equal(co_rig_get(&rig.co, 0x2003, 0), 0xA5);
    assert_int_equal(co_rig_get(&rig.co, 0x1800, 1), 0x180u + EDS_RIG_NODE);
    co_rig_put(&rig.co, 0x6003, 0, 4711, 4); /* the position is that from now on */
    assert_int_equal(co_rig_get(&rig.co, 0x6004, 0), 4711);
}

/* "save" keeps cells and what the base has; "load" of each part is the base's. */
static void written_rows_keep_their_values(void **state)
{
    (void)state;
    start_written(FILE_TEXT);
    co_rig_put(&rig.co, 0x2000, 0, 7, 2);
    co_rig_put(&rig.co, 0x6003, 0, 4711, 4);
    assert_int_not_equal(co_rig_write(&rig.co, 0x1010, 1, LOAD, 4), 0);
    co_rig_put(&rig.co, 0x1010, 1, SAVE, 4);
    eds_rig_power_cycle(&rig);
    assert_int_equal(co_rig_get(&rig.co, 0x2000, 0), 7);
    assert_int_equal(co_rig_get(&rig.co, 0x6003, 0), 4711);
    assert_int_not_equal(co_rig_write(&rig.co, 0x1011, 2, SAVE, 4), 0);
    co_rig_put(&rig.co, 0x1011, 1, LOAD, 4);
    eds_rig_power_cycle(&rig);
    assert_int_equal(co_rig_get(&rig.co, 0x2000, 0), 0xFFFB);
    assert_int_equal(co_rig_get(&rig.co, 0x6003, 0), 0);
}

/* SYNC samples the shaft once, by the base's function; its step lets time pass. */
static void written_rows_sample_and_step(void **state)
{
    static const char sync[] = "";
    struct dg_can_frame of_file;
    (void)state;
    for (int round = 0; round < 2; round++) {
        start_written(FILE_TEXT);
        if (round == 0) {
            start_model(&rig.file.model);
        }
        rig.co.motion =
            (struct dg_motion){.kind = DG_MOTION_SPEED, .start = rig.co.now, .mrpm = 60000};
        co_rig_nmt(&rig.co, 1);
        co_rig_run(&rig.co, DG_MS(250));
        co_rig_forget(&rig.co);
        co_rig_rx(&rig.co, 0x080, sync);
        co_rig_expect_count(&rig.co, 1);
        assert_int_equal(rig.co.frame[0].id, 0x180u + EDS_RIG_NODE);
        assert_int_equal(dg_load_le32(rig.co.frame[0].data), 65536 / 4);
        if (round == 0) {
            of_file = rig.co.frame[0];
        } else {
            assert_memory_equal(rig.co.frame[0].data, of_file.data, sizeof of_file.data);
        }
    }
}

/* A row that asks for what the base does not have is no object. */
static void a_row_of_no_base_is_no_object(void **state)
{
    uint32_t value;
    (void)state;
    eds_rig_read_text(&rig, FILE_TEXT);
    write_down();
    for (size_t i = 0; i < ROWS_MAX; i++) {
        if ((rows[i].key & 0xFFFFFF00u) == DG_CO_KEY(0x2000, 0)) {
            rows[i].hook = DG_CO_HOOK_BASE;
        }
    }
    start_model(&written.model);
    assert_int_equal(co_rig_read(&rig.co, 0x2000, 0, &value), DG_CO_NO_OBJECT);
    assert_int_equal(co_rig_get(&rig.co, 0x2001, 0), EDS_RIG_NODE + 7u);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_row_is_given_its_hook),
        cmocka_unit_test(a_hook_of_another_kind_has_no_name),
        cmocka_unit_test(written_rows_answer_as_the_file),
        cmocka_unit_test(written_rows_keep_their_values),
        cmocka_unit_test(written_rows_sample_and_step),
        cmocka_unit_test(a_row_of_no_base_is_no_object),
    };
    return cmocka_run_group_tests_name("eds_rows", tests, NULL, NULL);
}
