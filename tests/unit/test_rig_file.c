/* SPDX-License-Identifier: MIT */
/*
 * Models that are files: model = vendor.eds in a rig file. The host is a folder of texts, which
 * remembers what it was asked for.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/cia406.h"
#include "drehgeber/hal.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/model.h"
#include "drehgeber/rig.h"
#include "wire_list.h"

#define MEMORY_SIZE 262144u
#define FILES_MAX 4u
#define HANDLE 32768u

struct file {
    const char *path;
    const char *text;
};

static struct {
    _Alignas(16) unsigned char memory[MEMORY_SIZE];
    struct dg_plan plan;
    struct dg_plan_error error;
    struct file files[FILES_MAX];
    struct dg_plan_text large; /* of all files that are called so */
    char asked[200];           /* names, each with a blank behind it */
} bench;

static const char vendor[] = "[DeviceInfo]\nProductName=Acme 3600\n"
                             "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x00020196\n"
                             "[6004]\nDataType=7\nAccessType=ro\n"
                             "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=3600\n"
                             "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=37\n"
                             "[2000]\nDataType=0x20\nAccessType=rw\n";
static const char configured[] = "[DeviceComissioning]\nNodeID=5\n"
                                 "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x00020196\n";

static const char *fetch(void *ctx, const char *path, struct dg_plan_text *to)
{
    const size_t n = strlen(bench.asked);

    assert_ptr_equal(ctx, &bench);
    (void)snprintf(bench.asked + n, sizeof bench.asked - n, "%s ", path);
    for (size_t i = 0; i < FILES_MAX && bench.files[i].path != NULL; i++) {
        const struct file *file = &bench.files[i];
        if (strcmp(file->path, path) == 0) {
            *to = (struct dg_plan_text){file->text, strlen(file->text)};
            return NULL;
        }
    }
    *to = bench.large;
    return strstr(path, "/large.eds") != NULL ? NULL : "no such file";
}

static int setup(void **state)
{
    (void)state;
    memset(&bench, 0, sizeof bench);
    bench.files[0] = (struct file){.path = "lab/vendor.eds", .text = vendor};
    return 0;
}

static int read_in(const char *text, size_t size)
{
    const struct dg_plan_setup from = {
        .size = sizeof from,
        .file = "lab/bench.ini",
        .text = {text, strlen(text)},
        .memory = bench.memory,
        .memory_size = size,
        .include = fetch,
        .ctx = &bench,
    };

    bench.asked[0] = '\0';
    return dg_plan_read(&bench.plan, &from, &bench.error);
}

static void read_good(const char *text)
{
    if (read_in(text, MEMORY_SIZE) != DG_OK) {
        fail_msg("%u: %s = %s: %s; %s", bench.error.line, bench.error.key, bench.error.value,
                 bench.error.what, bench.error.right);
    }
}

static void assert_refused(const char *text, unsigned line, const char *what, const char *right)
{
    assert_int_equal(read_in(text, MEMORY_SIZE), DG_ERR_ARGUMENT);
    assert_int_equal(bench.error.line, line);
    assert_string_equal(bench.error.what, what);
    assert_string_equal(bench.error.right, right);
    assert_null(bench.plan.memory);
}

/* A number of the encoder's dictionary, by an SDO upload. */
static uint32_t upload(const struct dg_device *model, uint32_t node, uint16_t index)
{
    static _Alignas(DG_HOST_ALIGN) uint8_t memory[HANDLE];
    struct dg_host *host = dg_host_init(memory, sizeof memory, model, dg_host_wire_of(model));
    struct dg_host_event event = {
        .at = 1000000000u,
        .id = 0x600u + node,
        .kind = DG_HOST_CAN,
        .length = 8,
        .data = {0x40, (uint8_t)index, (uint8_t)(index >> 8)},
    };

    assert_non_null(host);
    assert_int_equal(dg_host_power(host, 0, true), DG_HOST_OK);
    (void)dg_host_step(host, event.at);
    assert_int_equal(dg_host_send(host, &event), DG_HOST_OK);
    (void)dg_host_step(host, event.at);
    while (dg_host_receive(host, &event) > 0) {
        if (event.id == 0x580u + node) {
            assert_int_equal(event.data[0] & 0xE0, 0x40);
            return event.data[4] | (uint32_t)event.data[5] << 8 | (uint32_t)event.data[6] << 16 |
                   (uint32_t)event.data[7] << 24;
        }
    }
    fail_msg("no answer for %04Xh", index);
    return 0;
}

/* ---------------------------------------------------------------- what it makes */

static void an_encoder_of_a_file(void **state)
{
    (void)state;
    read_good("[encoder a]\nmodel = vendor.eds\nwire = slcan\n");
    assert_string_equal(bench.asked, "lab/vendor.eds ");
    assert_int_equal(bench.plan.model_file_count, 1);
    const struct dg_plan_model_file *file = &bench.plan.model_files[0];
    assert_string_equal(file->file, "lab/vendor.eds");
    assert_int_equal(file->line, 2);
    assert_int_equal(file->lacks, 1); /* 2000h is of a type that there is not */
    const struct dg_device *model = bench.plan.encoders[0].model;
    assert_ptr_equal(model, file->device);
    assert_string_equal(model->name, "acme-3600");
    assert_ptr_equal(model->stack, &dg_cia406_stack);
    assert_int_equal(upload(model, DG_CIA406_NODE_DEFAULT, 0x6501), 3600);
    assert_int_equal(upload(model, DG_CIA406_NODE_DEFAULT, 0x6502), 37);
}

/* Any encoders have it, also those of a range; what is noted is noted once. */
static void many_encoders_of_one_file(void **state)
{
    (void)state;
    bench.files[1] = (struct file){.path = "lab/more/OTHER.DCF", .text = configured};
    read_good("[bus b]\nwire = slcan\n"
              "[encoder a]\nmodel = vendor.eds\nbus = b\nnode = 1..3\n"
              "[encoder z]\nmodel = more/OTHER.DCF\nbus = b\n"
              "[encoder y]\nmodel = vendor.eds\nbus = b\nnode = 9\n");
    assert_string_equal(bench.asked, "lab/vendor.eds lab/more/OTHER.DCF ");
    assert_int_equal(bench.plan.encoder_count, 5);
    for (size_t i = 0; i < 5; i++) {
        assert_ptr_equal(bench.plan.encoders[i].model,
                         bench.plan.model_files[i == 3 ? 1 : 0].device);
    }
    assert_int_equal(upload(bench.plan.encoders[3].model, 5, 0x1000), 0x20196);
}

/* Names are relative to the folder of the file that they stand in. */
static void a_model_of_an_included_file(void **state)
{
    (void)state;
    bench.files[1] = (struct file){.path = "lab/cell/one.ini",
                                   .text = "[encoder a]\nmodel = acme.eds\nwire = slcan\n"};
    bench.files[2] = (struct file){.path = "lab/cell/acme.eds", .text = vendor};
    read_good("[rig]\ninclude = cell/one.ini\n");
    assert_string_equal(bench.asked, "lab/cell/one.ini lab/cell/acme.eds ");
    assert_int_equal(dg_plan_place(&bench.plan, bench.plan.model_files[0].line).line, 2);
}

/* Its memory is the plan's: with any smaller one it says so, and leaves the rest alone. */
static void memory_of_any_size(void **state)
{
    static const char text[] = "[encoder a]\nmodel = vendor.eds\nwire = slcan\n"
                               "[encoder b]\nmodel = vendor.eds\nwire = slcan\n";
    size_t size = 0;
    int result = DG_ERR_SPACE;

    (void)state;
    for (; size < MEMORY_SIZE && result == DG_ERR_SPACE; size += 8) {
        memset(bench.memory + size, 0xA5, 64);
        result = read_in(text, size);
        for (size_t i = 0; i < 64; i++) {
            assert_int_equal(bench.memory[size + i], 0xA5);
        }
    }
    assert_int_equal(result, DG_OK);
    assert_true(size < 24000);
}

/* ---------------------------------------------------------------- what is refused */

/* Nobody is asked for a file that is not below the folder of the one that names it. */
static void no_way_out_of_the_folder(void **state)
{
    static const char *const names[] = {"/etc/vendor.eds", "../vendor.eds", "a/../../vendor.eds",
                                        "a/..//vendor.eds"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char text[100];
        char what[64];
        (void)snprintf(text, sizeof text, "[encoder a]\nmodel = %s\nwire = slcan\n", names[i]);
        (void)snprintf(what, sizeof what, "%s is not allowed", names[i]);
        assert_refused(text, 2, what, "expected a file in the folder of this one, or below it");
        assert_string_equal(bench.asked, "");
    }
}

/* A file that names others is one of words that mean nothing here. */
static void a_model_opens_nothing(void **state)
{
    (void)state;
    bench.files[1] = (struct file){.path = "lab/link.eds",
                                   .text = "include = vendor.eds\n[rig]\ninclude = vendor.eds\n"
                                           "[FileInfo]\nFileName=vendor.eds\nEDSFile=vendor.eds\n"
                                           "LastEDS=vendor.eds\n[2FFF]\nUploadFile=vendor.eds\n"
                                           "DownloadFile=vendor.eds\n"
                                           "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0\n"};
    read_good("[encoder a]\nmodel = link.eds\nwire = slcan\n");
    assert_string_equal(bench.asked, "lab/link.eds ");
}

/* The rig file's line, then the line of the file, what is wrong there, what is right. */
static void what_is_wrong_in_it(void **state)
{
    static const char own[] =
        "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x00020196\n"
        "[1018]\nObjectType=9\n[1018sub1]\nDataType=7\nAccessType=ro\nDefaultValue=0x1EB\n"
        "[1018sub2]\nDataType=7\nAccessType=ro\nDefaultValue=%u\n"
        "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=1000\n";
    char text[400];
    (void)state;
    bench.files[1] = (struct file){.path = "lab/empty.eds", .text = "\n"};
    assert_refused("[encoder a]\nmodel = empty.eds\nwire = slcan\n", 2, "lab/empty.eds: no object",
                   "expected an EDS or DCF file, with sections as [1000]");
    assert_string_equal(bench.error.key, "model");
    (void)snprintf(text, sizeof text, own, (unsigned)dg_cia406_multiturn.product_code);
    char *vendor_id = strstr(text, "0x1EB");
    char digits[16];
    (void)snprintf(digits, sizeof digits, "%5u", (unsigned)dg_cia406_multiturn.vendor_id);
    memcpy(vendor_id, digits, 5);
    bench.files[1] = (struct file){.path = "lab/own.eds", .text = text};
    assert_refused("\n\n[encoder a]\nmodel = own.eds\nwire = slcan\n", 4,
                   "lab/own.eds:15: [6501] DefaultValue: not the figures of the encoder with this "
                   "identity",
                   "expected 65536 steps, and 4096 turns or one");
}

static void what_the_host_refuses(void **state)
{
    const struct dg_plan_setup alone = {
        .size = sizeof alone,
        .file = "lab/bench.ini",
        .text = {"[encoder a]\nmodel = vendor.eds\nwire = slcan\n", 42},
        .memory = bench.memory,
        .memory_size = MEMORY_SIZE,
    };
    (void)state;
    assert_refused("[encoder a]\nmodel = missing.eds\nwire = slcan\n", 2, "no such file", "");
    assert_int_equal(dg_plan_read(&bench.plan, &alone, &bench.error), DG_ERR_ARGUMENT);
    assert_string_equal(bench.error.what, "there are no other files here");
}

static void what_the_rest_of_the_section_says(void **state)
{
    char right[200];
    (void)state;
    (void)snprintf(right, sizeof right, "expected %s", list_wires(DG_PLAN_CARRIES(FRAMES), " or "));
    bench.files[1] = (struct file){.path = "lab/five.dcf", .text = configured};
    assert_refused("[encoder a]\nmodell = vendor.eds\nwire = slcan\n", 2, "no such key",
                   "expected model = vendor.eds");
    assert_refused("[encoder a]\nmodel = vendor.eds\nwire = pty\n", 3,
                   "pty is no wire of acme-3600", right);
    assert_refused("[bus b]\nwire = slcan\n[encoder a]\nmodel = five.dcf\nbus = b\n"
                   "[encoder z]\nmodel = vendor.eds\nbus = b\nnode = 5\n",
                   9, "5 is node of [encoder a] already", "expected node = N with another one");
}

/* Any number of large files would be any number of seconds: together they are bounded. */
static void all_texts_together(void **state)
{
    char text[9u * 64u];
    char *large = malloc(DG_EDS_BYTES_MAX);
    size_t n = 0;
    (void)state;
    assert_non_null(large);
    memset(large, '\n', DG_EDS_BYTES_MAX);
    memcpy(large, vendor, strlen(vendor));
    bench.large = (struct dg_plan_text){large, DG_EDS_BYTES_MAX};
    for (unsigned i = 1; i <= 9; i++) {
        n += (size_t)snprintf(text + n, sizeof text - n,
                              "[encoder e%u]\nmodel = %u/large.eds\nwire = slcan\n", i, i);
    }
    assert_refused(text, 26, "more than 8388608 bytes in all files that are models",
                   "expected less");
    free(large);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(an_encoder_of_a_file, setup),
        cmocka_unit_test_setup(many_encoders_of_one_file, setup),
        cmocka_unit_test_setup(a_model_of_an_included_file, setup),
        cmocka_unit_test_setup(memory_of_any_size, setup),
        cmocka_unit_test_setup(no_way_out_of_the_folder, setup),
        cmocka_unit_test_setup(a_model_opens_nothing, setup),
        cmocka_unit_test_setup(what_is_wrong_in_it, setup),
        cmocka_unit_test_setup(what_the_host_refuses, setup),
        cmocka_unit_test_setup(what_the_rest_of_the_section_says, setup),
        cmocka_unit_test_setup(all_texts_together, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
