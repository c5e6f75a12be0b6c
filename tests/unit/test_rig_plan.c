/* SPDX-License-Identifier: MIT */
/*
 * The reader of rig files as a host without files sees it: memory that is too small, kinds of wire
 * of its own, files that include each other. What it takes and says of a text is held by
 * linux/test_plan.c and golden.verdicts.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/hal.h"
#include "drehgeber/rig.h"

#define MEMORY_SIZE 131072u

/* A host has more to say of a kind than the reader asks. */
struct kind {
    struct dg_plan_wire_kind kind;
    int of_the_host;
};

static const struct kind kinds[] = {
    {{.name = "rope", .stations_max = 127, .media = DG_PLAN_CARRIES(FRAMES), .where = "KNOT"}, 1},
    {{.name = "string", .stations_max = 1, .media = DG_PLAN_CARRIES_ALL}, 2},
};

/* Files that can be included. */
struct file {
    const char *path;
    const char *text;
};

struct bench {
    const struct file *files;
    size_t count;
    unsigned asked;
    _Alignas(16) unsigned char memory[MEMORY_SIZE + 32u];
    struct dg_plan plan;
    struct dg_plan_error error;
};

static const char *include_file(void *ctx, const char *path, struct dg_plan_text *to)
{
    struct bench *self = ctx;
    self->asked++;
    for (size_t i = 0; i < self->count; i++) {
        if (strcmp(self->files[i].path, path) == 0) {
            *to = (struct dg_plan_text){self->files[i].text, strlen(self->files[i].text)};
            return NULL;
        }
    }
    return "not there";
}

static int read_in(struct bench *self, const char *text, size_t size)
{
    const struct dg_plan_setup setup = {
        .size = sizeof setup,
        .file = "lab/bench.ini",
        .text = {text, strlen(text)},
        .memory = self->memory,
        .memory_size = size,
        .wires = kinds,
        .wire_count = DG_COUNT(kinds),
        .wire_stride = sizeof kinds[0],
        .include = include_file,
        .ctx = self,
    };
    return dg_plan_read(&self->plan, &setup, &self->error);
}

static void read_good(struct bench *self, const char *text)
{
    if (read_in(self, text, MEMORY_SIZE) != DG_OK) {
        fail_msg("%s:%u: %s: %s; %s", self->error.included, self->error.line, self->error.key,
                 self->error.what, self->error.right);
    }
}

static void assert_refused(struct bench *self, const char *text, const char *included,
                           unsigned line, const char *what)
{
    assert_int_equal(read_in(self, text, MEMORY_SIZE), DG_ERR_ARGUMENT);
    assert_string_equal(self->error.included, included);
    assert_int_equal(self->error.line, line);
    assert_string_equal(self->error.what, what);
    assert_null(self->plan.memory);
}

static const char nodes[] = "[rig]\ncontrol = unix:s,token=t\nfiles = x\n"
                            "[shaft m]\nmotion = 60RPM\n[bus b]\nwire = rope\n"
                            "[encoder a]\nmodel = f3668\nbus = b\nnode = 1..100\nserial = 7\n"
                            "nvm = a.nvm\ntemperature = 85\n";

/* However little there is, nothing is written beyond it. */
static void memory_of_any_size(void **state)
{
    static struct bench bench;
    int result = DG_ERR_SPACE;
    size_t size = 0;
    (void)state;
    while (result != DG_OK) {
        memset(bench.memory, 0xA5, sizeof bench.memory);
        result = read_in(&bench, nodes, size);
        assert_true(result == DG_OK || result == DG_ERR_SPACE);
        for (size_t i = size; i < sizeof bench.memory; i++) {
            assert_int_equal(bench.memory[i], 0xA5);
        }
        assert_true(result == DG_OK || bench.plan.encoders == NULL);
        size += size < 1024u ? 1u : 997u;
        assert_true(size <= MEMORY_SIZE);
    }
    assert_int_equal(bench.plan.encoder_count, 100);
    assert_true(size < 80u * 1024u); /* 0.7 kB a node, all told */
    for (size_t i = 1; i < 100; i++) {
        assert_ptr_equal(bench.plan.encoders[i].settings.list,
                         bench.plan.encoders[0].settings.list);
    }
    assert_string_equal(bench.plan.encoders[99].nvm, "lab/a.nvm.100");
    assert_string_equal(bench.plan.encoders[99].serial, "106");
    assert_string_equal(bench.plan.controls[0].where, "unix:lab/s");
    assert_string_equal(bench.plan.controls[0].token_file, "lab/t");
    assert_string_equal(bench.plan.files, "lab/x");
}

static void kinds_of_wire_are_the_hosts(void **state)
{
    static struct bench bench;
    (void)state;
    read_good(&bench, "[encoder a]\nmodel = ssi-25\nwire = string\n");
    assert_ptr_equal(bench.plan.wires[0].kind, &kinds[1].kind);
    assert_refused(&bench, "[encoder a]\nmodel = ssi-25\nwire = pty\n", "", 3,
                   "pty is no kind of wire");
    assert_string_equal(bench.error.right, "rope and string are right");
    assert_string_equal(bench.error.file, "lab/bench.ini");
}

static void a_setup_of_another_version(void **state)
{
    struct dg_plan_setup setup = {.size = sizeof setup - 1u, .file = "x"};
    struct dg_plan plan;
    struct dg_plan_error error;
    (void)state;
    assert_int_equal(dg_plan_read(&plan, &setup, &error), DG_ERR_ARGUMENT);
    assert_string_equal(error.what, "not a setup of this version");
}

/* --- files that include each other --- */

static const struct file machine[] = {
    {"lab/shafts.ini", "; of the machine\n[shaft motor]\nmotion = 60RPM\n"},
    {"lab/sub/wires.ini", "[rig]\ninclude = more/bus.ini\n[bus c]\nwire = rope\ntrace = c.log\n"},
    {"lab/sub/more/bus.ini", "[bus b]\nwire = rope\ntrace = b.log"},
    {"lab/empty.ini", ""},
    {"lab/broken.ini", "[rig]\n\ninclude = broken/deep.ini\n"},
    {"lab/broken/deep.ini", "[shaft a]\nratio = 1:2\n"},
    {"lab/twice.ini", "[shaft motor]\n"},
    {"lab/loop.ini", "[rig]\ninclude = loop.ini\n"},
};

static void use_machine(struct bench *self)
{
    self->files = machine;
    self->count = DG_COUNT(machine);
}

/* Where a word stands is told as its file has it. */
static void assert_place(const struct bench *self, dg_plan_line line, const char *file,
                         unsigned line_of_it)
{
    const struct dg_plan_place place = dg_plan_place(&self->plan, line);
    assert_string_equal(place.file, file);
    assert_int_equal(place.line, line_of_it);
}

static void included_where_the_word_stands(void **state)
{
    static struct bench bench;
    (void)state;
    use_machine(&bench);
    read_good(&bench, "[rig]\ninclude = shafts.ini\nname = x\ninclude = empty.ini\n"
                      "include = sub/wires.ini\n"
                      "[encoder a]\nmodel = f3668\nbus = b\nshaft = motor\nnvm = a.nvm\n"
                      "[encoder c]\nmodel = f3668\nbus = c\n");
    assert_int_equal(bench.asked, 4);
    assert_string_equal(bench.plan.name, "x");
    assert_string_equal(bench.plan.wires[0].trace, "lab/sub/more/b.log");
    assert_string_equal(bench.plan.wires[1].trace, "lab/sub/c.log");
    assert_string_equal(bench.plan.encoders[0].nvm, "lab/a.nvm");
    assert_place(&bench, bench.plan.shafts[0].line, "lab/shafts.ini", 2);
    assert_place(&bench, bench.plan.shafts[0].motion_line, "lab/shafts.ini", 3);
    assert_place(&bench, bench.plan.wires[0].line, "lab/sub/more/bus.ini", 1);
    assert_place(&bench, bench.plan.wires[1].line, "lab/sub/wires.ini", 3);
    assert_place(&bench, bench.plan.encoders[0].line, "lab/bench.ini", 6);
    assert_place(&bench, bench.plan.encoders[1].line, "lab/bench.ini", 11);
    assert_place(&bench, 0, "lab/bench.ini", 0);
    char text[80];
    struct dg_text files = dg_text_in(text, sizeof text);
    dg_plan_say_files(&bench.plan, bench.plan.wires[0].line, &files);
    assert_string_equal(text, "lab/bench.ini:5: lab/sub/wires.ini:2: lab/sub/more/bus.ini");
}

static void errors_name_the_files(void **state)
{
    static struct bench bench;
    (void)state;
    use_machine(&bench);
    assert_refused(&bench, "[rig]\ninclude = broken.ini\n",
                   "lab/bench.ini:2: lab/broken.ini:3: lab/broken/deep.ini", 2, "without a driver");
    assert_string_equal(bench.error.key, "ratio");
    assert_refused(&bench, "[rig]\ninclude = shafts.ini\ninclude = twice.ini\n",
                   "lab/bench.ini:3: lab/twice.ini", 1,
                   "line 2 of lab/shafts.ini has the name already");
    assert_refused(&bench, "[rig]\ninclude = none.ini\n", "", 2, "not there");
    assert_string_equal(bench.error.key, "include");
    assert_refused(&bench, "[rig]\ninclude =\n", "", 2, "empty");
    assert_int_equal(read_in(&bench, "[rig]\ninclude = loop.ini\n", MEMORY_SIZE), DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.what, "8 files include each other already");
}

/* Nothing above the folder is ever asked for. */
static void no_way_out_of_the_folder(void **state)
{
    static const char *const paths[] = {"/etc/passwd", "..",    "../x.ini", "sub/../../x.ini",
                                        "a/..",        "a//b/", "sub/",     "//x"};
    static struct bench bench;
    (void)state;
    use_machine(&bench);
    for (size_t i = 0; i < DG_COUNT(paths); i++) {
        char text[80];
        char what[80];
        (void)snprintf(text, sizeof text, "[rig]\ninclude = %s\n", paths[i]);
        (void)snprintf(what, sizeof what, "%s is none", paths[i]);
        assert_refused(&bench, text, "", 2, what);
    }
    assert_int_equal(bench.asked, 0);
}

static void a_megabyte_is_enough(void **state)
{
    static struct bench bench;
    static char half[DG_PLAN_INCLUDED_MAX / 2u + 1u];
    const struct file files[] = {{"lab/half.ini", half}, {"lab/more.ini", "; \n"}};
    static const char twice[] = "[rig]\ninclude = half.ini\ninclude = half.ini\n"
                                "[encoder a]\nmodel = f3668\nwire = rope\n";
    (void)state;
    memset(half, '\n', sizeof half - 1u);
    bench.files = files;
    bench.count = DG_COUNT(files);
    read_good(&bench, twice);
    assert_refused(&bench, "[rig]\ninclude = half.ini\ninclude = half.ini\ninclude = more.ini\n",
                   "", 4, "more than 1048576 bytes in all included files");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_of_any_size),
        cmocka_unit_test(kinds_of_wire_are_the_hosts),
        cmocka_unit_test(a_setup_of_another_version),
        cmocka_unit_test(included_where_the_word_stands),
        cmocka_unit_test(errors_name_the_files),
        cmocka_unit_test(no_way_out_of_the_folder),
        cmocka_unit_test(a_megabyte_is_enough),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
