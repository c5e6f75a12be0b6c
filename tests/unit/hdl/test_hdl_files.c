/* SPDX-License-Identifier: MIT */
/*
 * Encoders of files of models in simulators.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "hdl.h"

static void write_file(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");

    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* MODEL names a file, and one of the models in it. */
static void a_file_is_a_model(void **state)
{
    static const struct {
        const char *behind;
        const char *line; /* NULL: it is right */
        int64_t position; /* of a quarter */
    } rows[] = {
        {"/trees.ini", NULL, 1 << 6},
        {"/trees.ini:tree", NULL, 1 << 18},
        {"/trees.ini:bush", "trees.ini has no model 'bush'; it has tree and twig", 0},
        {"/none.ini", "none.ini: cannot open", 0},
        {"/wrong.ini:tree", "wrong.ini:3: st 99: expected a number in 1..32", 0},
        {"/empty.ini", "empty.ini: without encoders", 0},
        {"/trees", "there is no model '", 0},
    };
    char folder[] = "/tmp/drehgeber-hdl-XXXXXX";
    char path[128];

    (void)state;
    assert_non_null(mkdtemp(folder));
    (void)snprintf(path, sizeof path, "%s/trees.ini", folder);
    write_file(path, "[model tree]\nbase = ssi-13\nst = 20\n[model twig]\nbase = tree\nst = 8\n");
    (void)snprintf(path, sizeof path, "%s/wrong.ini", folder);
    write_file(path, "[model tree]\nbase = ssi-13\nst = 99\n");
    (void)snprintf(path, sizeof path, "%s/empty.ini", folder);
    write_file(path, "");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        (void)snprintf(path, sizeof path, "%s%s", folder, rows[i].behind);
        struct dg_hdl *self = dg_hdl_open(path, "", "90DEG", "");
        assert_non_null(self);
        if (rows[i].line == NULL) {
            assert_string_equal(dg_hdl_error(self), "");
            assert_int_equal(dg_hdl_position(self, 0), rows[i].position);
        } else {
            assert_non_null(strstr(dg_hdl_error(self), rows[i].line));
        }
        dg_hdl_close(self);
    }
    for (size_t i = 0; i < 3; i++) {
        static const char *const names[] = {"trees", "wrong", "empty"};
        (void)snprintf(path, sizeof path, "%s/%s.ini", folder, names[i]);
        (void)unlink(path);
    }
    (void)rmdir(folder);
}

/* An EEPROM of other figures is refused with them, and stays as it is. */
static void a_memory_of_other_figures(void **state)
{
    static const char *const texts[] = {"[model la]\nbase = s3674-biss\nst = 25\n",
                                        "[model la]\nbase = s3674-biss\nst = 26\n"};
    char folder[] = "/tmp/drehgeber-hdl-XXXXXX";
    char path[128];
    char memory[128];
    char bytes[2][4096] = {"", ""};
    size_t n[2];

    (void)state;
    assert_non_null(mkdtemp(folder));
    (void)snprintf(path, sizeof path, "%s/la.ini", folder);
    (void)snprintf(memory, sizeof memory, "%s/la.nvm", folder);
    for (size_t i = 0; i < 2; i++) {
        write_file(path, texts[i]);
        struct dg_hdl *self = dg_hdl_open(path, "", "", memory);
        assert_non_null(self);
        if (i == 0) {
            assert_string_equal(dg_hdl_error(self), "");
        } else {
            assert_non_null(
                strstr(dg_hdl_error(self), "la.nvm: of other figures: st: 25, expected 26"));
        }
        dg_hdl_close(self);
        FILE *file = fopen(memory, "r");
        assert_non_null(file);
        n[i] = fread(bytes[i], 1, sizeof bytes[i], file);
        assert_int_equal(fclose(file), 0);
    }
    assert_true(n[0] > 1000 && n[0] == n[1]);
    assert_memory_equal(bytes[0], bytes[1], n[0]);
    (void)unlink(memory);
    (void)unlink(path);
    (void)rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_is_a_model),
        cmocka_unit_test(a_memory_of_other_figures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
