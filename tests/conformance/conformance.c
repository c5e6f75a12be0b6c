/* SPDX-License-Identifier: MIT */
/*
 * conformance NAME CLAUSES ROWS [PAGE]
 *
 * Every row is a test; clauses and rows that do not fit each other fail too, and so do clauses that
 * the device page should list and does not. NAME says what runs
 * the rows. `selftest` is the runner's own test and turns it round: every row must fail with its
 * title in the reason, and every kind of finding must occur.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "audit.h"
#include "canopen_from_eds.h"
#include "canopen_steps.h"

static struct cf_suite suite;
static const struct cf_device *device;

static void prove_row(void **state)
{
    const struct cf_row *row = *state;
    struct cf_report report;

    if (!cf_run(&suite, row, device, &report)) {
        print_error("%s\n", report.text);
        fail();
    }
}

static int prove(void)
{
    static struct CMUnitTest tests[CF_ROWS_MAX];
    struct cf_audit audit = cf_audit(&suite, device, stderr);
    unsigned findings = audit.duplicate + audit.unknown + audit.uncovered + audit.expectless +
                        audit.clauseless + audit.same_titled + audit.unlisted;
    int failed;

    for (size_t i = 0; i < suite.row_count; i++) {
        tests[i] = (struct CMUnitTest){
            .name = suite.rows[i].title, .test_func = prove_row, .initial_state = &suite.rows[i]};
    }
    failed = _cmocka_run_group_tests(suite.rows_name, tests, suite.row_count, NULL, NULL);
    (void)fflush(stderr);
    cf_summary(&suite, stdout);
    if (findings > 0) {
        (void)fprintf(stderr, "%u findings: clauses and rows do not fit each other\n", findings);
    }
    return failed == 0 && findings == 0 && suite.row_count > 0 ? 0 : 1;
}

/* The title of a row that must fail is part of the reason it must fail for. */
static int expect_fail(void)
{
    struct cf_audit audit = cf_audit(&suite, device, stdout);
    bool lists = false;
    int wrong = 0;

    for (size_t i = 0; i < suite.row_count; i++) {
        const struct cf_row *row = &suite.rows[i];
        struct cf_report report;
        bool passed = cf_run(&suite, row, device, &report);

        if (passed || strstr(report.text, row->title) == NULL) {
            (void)fprintf(stderr, "%s:%d: should fail for `%s`, but: %s\n", suite.rows_name,
                          row->line, row->title, passed ? "passed" : report.text);
            wrong++;
        }
    }
    for (size_t i = 0; i < suite.clause_count; i++) {
        lists = lists || suite.clauses[i].listed != NULL;
    }
    if ((lists && audit.unlisted == 0) || audit.duplicate == 0 || audit.unknown == 0 ||
        audit.uncovered == 0 || audit.expectless == 0 || audit.clauseless == 0 ||
        audit.same_titled == 0) {
        (void)fprintf(stderr, "%s: the audit misses a kind of finding\n", suite.rows_name);
        wrong++;
    }
    (void)printf("%zu rows had to fail, %d did otherwise\n", suite.row_count, wrong);
    return wrong == 0 && suite.row_count > 0 ? 0 : 1;
}

int main(int argc, char **argv)
{
    /* clang-format off */
    static const struct {
        const char *name;
        const struct cf_device *(*device)(void);
        int (*run)(void);
    } suites[] = {
        {"hiperface", cf_hiperface, prove},
        {"biss", cf_biss, prove},
        {"biss-selftest", cf_biss, expect_fail},
        {"selftest", cf_hiperface, expect_fail},
        {"ssi", cf_ssi, prove},
        {"ssi-selftest", cf_ssi, expect_fail},
        {"canopen", cf_canopen, prove},
        {"canopen-selftest", cf_canopen, expect_fail},
        {"interbus", cf_interbus, prove},
        {"interbus-selftest", cf_interbus, expect_fail},
        {"cia406", cf_canopen, prove},
    };
    /* clang-format on */
    int result = 2;

    cf_canopen_make(canopen_from_eds);
    for (size_t i = 0; (argc == 4 || argc == 5) && i < sizeof suites / sizeof suites[0]; i++) {
        if (strcmp(argv[1], suites[i].name) == 0) {
            device = suites[i].device();
            result = cf_load(&suite, argv[2], argv[3], argv[4]) ? suites[i].run() : 1;
            cf_unload(&suite);
        }
    }
    if (result == 2) {
        (void)fprintf(
            stderr, "usage: conformance %s CLAUSES ROWS [PAGE]\n",
            "hiperface|selftest|biss|ssi|ssi-selftest|canopen|canopen-selftest|cia406|interbus|interbus-selftest");
    }
    return result;
}
