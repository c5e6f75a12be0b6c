/* SPDX-License-Identifier: MIT */
/*
 * What is true of every command: the rows of the tables, the limits of numbers, and that the host
 * is asked to look at an encoder before its client is told of it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "control_rig.h"
#include "drehgeber/instruments.h"
#include "scpi_private.h"

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

/* Whether another row of the list has one of its functions. */
static bool shares_functions(const struct dg_scpi_commands *list, const struct dg_scpi_command *row)
{
    size_t others = 0;

    for (size_t i = 0; i < list->count; i++) {
        const struct dg_scpi_command *other = &list->rows[i];
        const bool set = other->set != NULL && other->set == row->set;
        const bool query = other->query != NULL && other->query == row->query;
        others += other != row && (set || query) ? 1u : 0u;
    }
    return others > 0;
}

static void expect_rows(const struct dg_scpi_commands *list)
{
    for (size_t i = 0; i < list->count; i++) {
        const struct dg_scpi_command *row = &list->rows[i];
        /* It tells a function which of its rows it serves; nobody looks at it where there is one.
         */
        assert_true(row->argument == 0 || shares_functions(list, row));
        assert_true(row->set != NULL || row->query != NULL);
        assert_non_null(row->parameters);
        assert_true(strlen(row->help) > 0 && strlen(row->help) <= DG_SCPI_LINE_MAX);
        assert_null(strpbrk(row->help, "\n"));
        assert_true(strlen(row->header) > 0 && row->header[strlen(row->header) - 1u] != '?');
    }
}

static void test_table(void **state)
{
    (void)state;
    expect_rows(&dg_scpi_own);
    expect_rows(&dg_control_commands);
    expect_rows(&dg_course_commands);
    for (size_t i = 0; i < dg_instrument_count; i++) {
        expect_rows(&dg_instruments[i]->commands);
    }
    assert_non_null(strstr(control_rig_say(&rig, "SYST:HELP?"), "FAULt:SET NAME"));
}

static const struct dg_encoder *looked_at;
static dg_ns looked_when;

static void look_at_encoder(struct dg_rig *to, struct dg_encoder *encoder, dg_ns now)
{
    assert_ptr_equal(to, &rig.rig);
    looked_at = encoder;
    looked_when = now;
}

/* A host that lets encoders lie until somebody asks brings the selected one up to now before its
 * client is told of it. */
static void test_look(void **state)
{
    (void)state;
    rig.ops.look = look_at_encoder;
    expect("INST:SEL can", "");
    looked_at = NULL;
    rig.now += DG_S(5);
    assert_true(strlen(control_rig_say(&rig, "STAT?")) > 0);
    assert_ptr_equal(looked_at, &rig.encoder[CONTROL_RIG_CAN]);
    assert_int_equal(looked_when, rig.now);
}

/* The least and the most of each number, and what is one place beyond. */
static void test_limits(void **state)
{
    static const struct {
        const char *taken;
        const char *refused;
    } rows[] = {
        {"SHAF:POS 1073741824REV", "SHAF:POS 1073741824.000001REV"}, /* 2^30 turns */
        {"SHAF:POS -1073741824REV", "SHAF:POS -1073741824.000001REV"},
        {"SHAF:VEL 1000000", "SHAF:VEL 1000000.001"},
        {"SHAF:VEL -1000000", "SHAF:VEL -1000000.001"},
        {"SHAF:ACC 1000000000", "SHAF:ACC 1000000000.001"},
        {"SHAF:ACC 0", "SHAF:ACC -0.001"},
        {"SHAF:MOVE 90,1000000", "SHAF:MOVE 90,1000000.001"},
        {"SHAF:MOVE 90,0.001", "SHAF:MOVE 90,0"},
        {"SHAF:REC:STAR x.csv,100US", "SHAF:REC:STAR x.csv,99.999US"},
        {"SHAF:REC:STAR x.csv,3600S", "SHAF:REC:STAR x.csv,3600000.001MS"},
        {"FAUL:SET wire_drop,COUNT 1", "FAUL:SET wire_drop,COUNT 0"},
        {"FAUL:SET wire_drop,COUNT 4294967295", "FAUL:SET wire_drop,COUNT 4294967296"},
        {"FAUL:SET wire_drop,PROB 0", "FAUL:SET wire_drop,PROB -0.000001"},
        {"FAUL:SET wire_drop,PROB 1", "FAUL:SET wire_drop,PROB 1.000001"},
        {"FAUL:SET wire_drop,DUR 1NS", "FAUL:SET wire_drop,DUR 0NS"},
        {"WORL:TEMP:PROF:POIN 0,20,9000000000S,30", "WORL:TEMP:PROF:POIN 0,20,9000000001S,30"},
        {"TIME:SCAL 0", "TIME:SCAL -0.001"},
        {"TIME:SCAL 1000", "TIME:SCAL 1000.001"},
        {"TIME:STEP 0", "TIME:STEP -1NS"},
        {"TIME:STEP 86400S", "TIME:STEP 86400000.001MS"},
        {"*ESE 0", "*ESE -1"},
        {"*ESE 255", "*ESE 256"},
        {"*SRE 255", "*SRE 256"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        expect(rows[i].taken, "");
        control_rig_refuse(&rig, rows[i].refused, "-222", NULL);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_table, setup),
        cmocka_unit_test_setup(test_look, setup),
        cmocka_unit_test_setup(test_limits, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
