/* SPDX-License-Identifier: MIT */
/*
 * The reader of rig files as a host without files sees it: memory that is too small, kinds of wire,
 * files that include each other. What it takes and says of a text is held by
 * linux/test_plan.c and golden.verdicts.
 */
#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bus_words.h"
#include "drehgeber/hal.h"
#include "drehgeber/rig.h"
#include "wire_list.h"

#define MEMORY_SIZE 131072u

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
                            "[shaft m]\nmotion = 60RPM\n[bus b]\nwire = slcan\n"
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

#define ENCODER "[encoder a]\nmodel = ssi-25\nwire = sim\n"

static void clients_have_memory_for_courses(void **state)
{
    static const char *const wrong[] = {"15", "-1", "1k", "1099511627777"};
    static struct bench bench;
    (void)state;
    read_good(&bench, ENCODER);
    assert_true(bench.plan.course_memory == 0);
    read_good(&bench, "[rig]\nmemory = 48\n[rig]\nmemory = 16\n" ENCODER);
    assert_true(bench.plan.course_memory == 48);
    read_good(&bench, "[rig]\nmemory = 1099511627776\n" ENCODER);
    assert_true(bench.plan.course_memory == DG_PLAN_COURSE_MEMORY_MAX);
    for (size_t i = 0; i < DG_COUNT(wrong); i++) {
        char text[80];
        char what[60];
        (void)snprintf(text, sizeof text, "[rig]\nmemory = %s\n" ENCODER, wrong[i]);
        (void)snprintf(what, sizeof what, "%s is not a valid number", wrong[i]);
        assert_refused(&bench, text, "", 2, what);
        assert_string_equal(bench.error.right, "expected a number in 16..1099511627776");
    }
}

static void names_are_letters_digits_and_two_signs(void **state)
{
    static const char *const wrong[] = {"!a", "a!", ":", "\xC3\xA9t", "a.b", "[a"};
    static struct bench bench;
    (void)state;
    read_good(&bench, "[encoder _A-9]\nmodel = ssi-25\nwire = sim\n");
    for (size_t i = 0; i < DG_COUNT(wrong); i++) {
        char text[80];
        char what[60];
        (void)snprintf(text, sizeof text, "[encoder %s]\nmodel = ssi-25\nwire = sim\n", wrong[i]);
        (void)snprintf(what, sizeof what, "[encoder %s]", wrong[i]);
        assert_refused(&bench, text, "", 1, "");
        assert_string_equal(bench.error.key, what);
    }
}

static void assert_right(const struct bench *self, unsigned media, const char *between)
{
    char right[400];
    (void)snprintf(right, sizeof right, "expected %s", list_wires(media, between));
    assert_string_equal(self->error.right, right);
}

/* Each key is compared with all before it: a section of 100 000 would take a minute. */
static void a_section_has_so_many_keys(void **state)
{
    enum { MOST = 256, GIVEN = 2 }; /* model, wire */
    static struct bench bench;
    char text[64 + 12 * MOST];
    (void)state;
    for (int count = MOST - 1; count <= MOST + 1; count++) {
        int n = snprintf(text, sizeof text, "[encoder a]\nmodel = ssi-25\nwire = sim\n");
        for (int i = GIVEN; i < count; i++) {
            n += snprintf(text + n, sizeof text - (size_t)n, "k%d = 1\n", i);
        }
        if (count <= MOST) {
            read_good(&bench, text);
            assert_int_equal(bench.plan.encoders[0].settings.count, count - GIVEN);
        } else {
            assert_refused(&bench, text, "", 1 + MOST + 1, "one more than 256 in a section");
            assert_string_equal(bench.error.key, "k256");
        }
    }
}

static void kinds_of_wire_are_everybodys(void **state)
{
    static struct bench bench;
    (void)state;
    read_good(&bench, "[encoder a]\nmodel = ssi-25\nwire = sim\nline_delay_ns = 5\n");
    assert_ptr_equal(bench.plan.wires[0].kind, dg_plan_find_kind("sim", 3));
    assert_int_equal(bench.plan.wires[0].settings.count, 1);
    assert_refused(&bench, "[encoder a]\nmodel = ssi-25\nwire = pty\n", "", 3,
                   "pty is no wire of ssi-25");
    assert_right(&bench, DG_PLAN_CARRIES(EDGES), " or ");
    assert_refused(&bench, "[bus a]\nwire = pt\n", "", 2, "pt is no kind of wire");
    assert_right(&bench, DG_PLAN_CARRIES_ALL, ", ");
    assert_string_equal(bench.error.file, "lab/bench.ini");
}

/* Whatever is right for a row lies in the settings that its kind has. */
static void check_rows(const struct dg_keys *keys, void *settings)
{
    for (size_t i = 0; i < keys->count; i++) {
        const struct dg_key *row = &keys->rows[i];
        char text[32];
        (void)snprintf(text, sizeof text, "%" PRId64, row->max);
        const char *most = row->words == NULL ? text : row->words[row->max];
        assert_int_equal(dg_key_set(row, settings, most), DG_OK);
        assert_true(dg_key_get(row, settings, text, sizeof text) > 0);
        assert_string_equal(text, most);
    }
}

static void settings_of_wires(void **state)
{
    struct dg_plan_timing timing = dg_plan_timing_usual;
    struct dg_plan_ring ring = dg_plan_ring_usual;
    struct dg_plan_simulation simulation = dg_plan_simulation_usual;
    bool pace = false;
    (void)state;
    check_rows(dg_plan_find_kind("sim", 3)->keys, &timing);
    assert_int_equal(timing.clock_hz, DG_PLAN_CLOCK_MAX_HZ);
    check_rows(dg_plan_find_kind("modbus", 6)->keys, &ring);
    assert_int_equal(ring.break_at, DG_RING_MAX - 1);
    check_rows(dg_plan_find_kind("silkit", 6)->keys, &simulation);
    assert_int_equal(simulation.time, DG_PLAN_REAL);
    assert_int_equal(simulation.step_us, 1000000);
    assert_true(simulation.aggregate);
    assert_int_equal(simulation.frames, DG_PLAN_FRAMES_PACKED);
    check_rows(dg_plan_find_kind("can", 3)->keys, &pace);
    assert_true(pace);
}

static void a_setup_of_another_version(void **state)
{
    struct dg_plan_setup setup = {.size = sizeof setup - 1u, .file = "x"};
    struct dg_plan plan;
    struct dg_plan_error error;
    (void)state;
    assert_int_equal(dg_plan_read(&plan, &setup, &error), DG_ERR_ARGUMENT);
    assert_string_equal(error.what, "not a setup of this version");
    setup.size = sizeof setup;
    setup.file = NULL;
    assert_int_equal(dg_plan_read(&plan, &setup, &error), DG_ERR_ARGUMENT);
}

/* A host without files says so. */
static void a_host_that_includes_nothing(void **state)
{
    static struct bench bench;
    static const char text[] = "[rig]\ninclude = shafts.ini\n";
    const struct dg_plan_setup setup = {.size = sizeof setup,
                                        .file = "bench.ini",
                                        .text = {text, sizeof text - 1u},
                                        .memory = bench.memory,
                                        .memory_size = MEMORY_SIZE};
    (void)state;
    assert_int_equal(dg_plan_read(&bench.plan, &setup, &bench.error), DG_ERR_ARGUMENT);
    assert_int_equal(bench.error.line, 2);
    assert_string_equal(bench.error.key, "include");
    struct dg_plan_setup nowhere = setup;
    nowhere.memory = NULL;
    assert_int_equal(dg_plan_read(&bench.plan, &nowhere, &bench.error), DG_ERR_SPACE);
}

/* --- files that include each other --- */

static const struct file machine[] = {
    {"lab/shafts.ini", "; of the machine\n[shaft motor]\nmotion = 60RPM\n"},
    {"lab/sub/wires.ini", "[rig]\ninclude = more/bus.ini\n[bus c]\nwire = slcan\ntrace = c.log\n"},
    {"lab/sub/more/bus.ini", "[bus b]\nwire = slcan\ntrace = b.log"},
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

static const struct file halls[] = {
    {"lab/hall.ini", "[rig]\nname = hall\nthreads = 4\nfiles = a\nmemory = 4096\n"},
};

/* Of what two files say of the rig, the included one is believed: its section ends first. */
static void the_included_file_is_believed(void **state)
{
    static struct bench bench;
    (void)state;
    bench.files = halls;
    bench.count = DG_COUNT(halls);
    read_good(&bench, "[rig]\nthreads = 2\nfiles = b\nmemory = 1024\ncontrol = tcp:127.0.0.1:0\n"
                      "include = hall.ini\n" ENCODER);
    assert_int_equal(bench.plan.threads, 4);
    assert_string_equal(bench.plan.files, "lab/a");
    assert_int_equal(bench.plan.course_memory, 4096);
    assert_true(bench.plan.controls[0].tcp);
    assert_string_equal(bench.plan.controls[0].where, "tcp:127.0.0.1:0");
    assert_refused(&bench, "[rig]\nthreads = none\n" ENCODER, "", 2, "none is not a valid number");
}

/* Wherever the memory ends, the plan is empty, and nobody is told that a word is wrong. */
static void memory_that_ends_anywhere(void **state)
{
    static struct bench bench;
    int result = DG_ERR_SPACE;
    (void)state;
    use_machine(&bench);
    for (size_t size = 0; result != DG_OK; size++) {
        result = read_in(&bench,
                         "[rig]\nname = x\ncontrol = unix:s,token=t\nfiles = x\n"
                         "include = shafts.ini\ninclude = sub/wires.ini\n"
                         "[shaft wheel]\ndriver = motor\nratio = 1:10\n"
                         "[encoder a]\nmodel = f3668\nbus = b\nnode = 1..9\nserial = 7\n"
                         "nvm = a.nvm\ntemperature = 85\n"
                         "[encoder c]\nmodel = f3668\nbus = c\nserial = 8\n"
                         "[encoder own]\nmodel = ssi-25\nwire = sim\ntrace = d.vcd\n"
                         "temperature = 20\nbits = 13\n",
                         size);
        assert_true(result == DG_OK || result == DG_ERR_SPACE);
        assert_true(result == DG_OK || bench.plan.memory == NULL);
        assert_true(size < MEMORY_SIZE);
    }
    assert_int_equal(bench.plan.encoder_count, 11);
    assert_string_equal(bench.plan.wires[2].trace, "lab/d.vcd");
}

/* Addresses of the control plane, whose ports and hosts are looked at as far as words go. */
/* Names that nobody wrote need memory, too. */
static void memory_of_the_shortest_rig(void **state)
{
    static struct bench bench;
    int result = DG_ERR_SPACE;
    (void)state;
    for (size_t size = 0; result != DG_OK; size++) {
        result = read_in(&bench,
                         "[encoder a]\nmodel = s3684-biss\nwire = sim\nserial = 123456789\n", size);
        assert_true(result == DG_OK || result == DG_ERR_SPACE);
        assert_true(size < MEMORY_SIZE);
    }
    assert_string_equal(bench.plan.name, "bench");
    assert_string_equal(bench.plan.encoders[0].serial, "123456789");
}

static void control_addresses(void **state)
{
    static const struct {
        const char *text;
        bool good;
    } rows[] = {
        {"unix:s", true},
        {"unix:", false},
        {"unix:0123456789012345678901234567890123456789012345678901234567890123456789012345678901234"
         "567890123456789012345678901234",
         false},
        {"a:b", false},
        {"tcp:localhost:5025,open,open", false},
        {"tcp:[::1]:5025", true},
        {"tcp:localhost:65535,open,token=t", true},
        {"tcp:localhost:65536", false},
        {"tcp:[]:5025", false},
        {"tcp:[a:5025", true},
        {"tcp:ab:5025", true},
        {"tcp:ab]:5025", true},
        {"tcp:[]a:5025", true},
        {"tcp:abc:5025", true},
        {"tcp::5025", false},
        {"tcp:a:", false},
        {"tcp:a:5x", false},
        {"tcp:a:5025,shut", false},
        {"unix:s,open", false},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_access_words words;
        struct dg_plan_error error;
        const int result = dg_access_read(rows[i].text, &words, &error);
        if (result != (rows[i].good ? DG_OK : DG_ERR_ARGUMENT)) {
            fail_msg("%s: %d", rows[i].text, result);
        }
    }
}

/* A command line adds what it says; however little memory there is, nothing is half there. */
static void a_plan_without_a_text(void **state)
{
    static _Alignas(16) unsigned char memory[4096];
    struct dg_plan plan;
    int done = -1;
    (void)state;
    dg_plan_begin(&plan, NULL, 0);
    assert_int_equal(dg_plan_add_shaft(&plan, "main", NULL), -1);
    assert_null(dg_plan_copy(&plan, "x"));
    for (size_t size = 0; done < 0; size++) {
        struct dg_plan_settings none;
        assert_true(size < sizeof memory);
        dg_plan_begin(&plan, memory, size);
        const int shaft = dg_plan_add_shaft(&plan, "main", "60RPM");
        const int wire =
            shaft < 0 ? -1 : dg_plan_add_wire(&plan, "b", dg_plan_find_kind("slcan", 5), "knot");
        done = wire < 0 ? -1
                        : dg_plan_add_encoder(&plan, "a", dg_device_find("f3668"), (size_t)shaft,
                                              (size_t)wire);
        assert_true(dg_plan_make_settings(&plan, &none, 0));
    }
    assert_int_equal(dg_plan_find_shaft(&plan, "MAIN"), 0);
    assert_int_equal(dg_plan_find_wire(&plan, "b"), 0);
    assert_int_equal(dg_plan_find_encoder(&plan, "A"), 0);
    assert_string_equal(plan.wires[0].where, "knot");
}

static void where_settings_stand(void **state)
{
    static struct bench bench;
    char text[80];
    struct dg_text addresses = dg_text_in(text, sizeof text);
    (void)state;
    read_good(&bench, "[encoder a]\nmodel = f3668\nwire = slcan\ntemperature = 85\nnode = 7\n"
                      "rotor_ok = 1\n");
    assert_int_equal(dg_plan_setting_line(&bench.plan.encoders[0], "temperature"), 4);
    assert_int_equal(dg_plan_setting_line(&bench.plan.encoders[0], "rotor_ok"), 6);
    assert_int_equal(dg_plan_setting_line(&bench.plan.encoders[0], "wire"), 1);
    dg_plan_say_addresses(dg_device_find("s3684-biss"), &addresses);
    assert_string_equal(text, "");
    dg_plan_say_addresses(dg_device_find("f3668"), &addresses);
    assert_string_equal(text, "a node-ID in 1..127");
    assert_null(dg_plan_address_row(dg_device_find("ssi-25")));
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
        (void)snprintf(what, sizeof what, "%s is not allowed", paths[i]);
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
                                "[encoder a]\nmodel = f3668\nwire = slcan\n";
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
        cmocka_unit_test(clients_have_memory_for_courses),
        cmocka_unit_test(names_are_letters_digits_and_two_signs),
        cmocka_unit_test(a_section_has_so_many_keys),
        cmocka_unit_test(kinds_of_wire_are_everybodys),
        cmocka_unit_test(settings_of_wires),
        cmocka_unit_test(a_setup_of_another_version),
        cmocka_unit_test(included_where_the_word_stands),
        cmocka_unit_test(the_included_file_is_believed),
        cmocka_unit_test(memory_that_ends_anywhere),
        cmocka_unit_test(memory_of_the_shortest_rig),
        cmocka_unit_test(a_plan_without_a_text),
        cmocka_unit_test(where_settings_stand),
        cmocka_unit_test(a_host_that_includes_nothing),
        cmocka_unit_test(control_addresses),
        cmocka_unit_test(errors_name_the_files),
        cmocka_unit_test(no_way_out_of_the_folder),
        cmocka_unit_test(a_megabyte_is_enough),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
