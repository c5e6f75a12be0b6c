/* SPDX-License-Identifier: MIT */
/*
 * Memory files of a ring that an earlier release has written: its images were shorter, and stand
 * closer together in a file that several devices share.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "drehgeber/bits.h"
#include "drehgeber/devices.h"
#include "modbus_rig.h"

#define BYTES_MAX 16384u

struct bench {
    char folder[40];
    char path[64];
    char link[64];
    const char *nvm;
    struct modbus_rig rig; /* a K2 between two K3 */
    struct lx_ring *ring;
    struct lx_error error;
    uint8_t bytes[BYTES_MAX]; /* of the file */
};

static int set_up(void **state)
{
    struct bench *self = calloc(1, sizeof *self);
    assert_non_null(self);
    (void)strcpy(self->folder, "/tmp/test_ring_files.XXXXXX");
    assert_non_null(mkdtemp(self->folder));
    (void)snprintf(self->path, sizeof self->path, "%s/nvm", self->folder);
    (void)snprintf(self->link, sizeof self->link, "%s/link", self->folder);
    self->nvm = self->path;
    self->ring = &self->rig.ring;
    *state = self;
    return 0;
}

/* rmdir() fails when anything else is left behind. */
static int tear_down(void **state)
{
    struct bench *self = *state;
    (void)unlink(self->path);
    (void)unlink(self->link);
    const int result = rmdir(self->folder);
    free(self);
    return result;
}

static int open_ring(struct bench *self)
{
    static const struct dg_device *const models[] = {&dg_ocd_ib_k3, &dg_ocd_ib_k2, &dg_ocd_ib_k3};
    modbus_rig_plan(&self->rig, models, 3);
    for (size_t i = 0; i < 3; i++) {
        self->rig.plan.encoders[i].nvm = self->nvm;
    }
    return modbus_rig_open(&self->rig, NULL, NULL, 0, &self->error);
}

static const struct dg_ib *device(const struct bench *self, size_t place)
{
    return dg_bus_device(self->ring->bus, place);
}

static size_t read_file(struct bench *self, uint8_t *bytes)
{
    FILE *file = fopen(self->path, "r");
    assert_non_null(file);
    const size_t n = fread(bytes, 1, BYTES_MAX, file);
    assert_int_equal(fclose(file), 0);
    return n;
}

static void write_file(struct bench *self, size_t n)
{
    FILE *file = fopen(self->path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(self->bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
}

/* An image of `count` regions with a shift of its own at `to`. @return bytes */
static uint32_t make_image(uint8_t count, uint32_t shift, uint8_t *to)
{
    struct dg_store_layout older = dg_ib_layout;
    struct lx_nvm_memory memory;
    struct dg_store store;
    uint8_t bytes[4];
    older.region_count = count;
    const uint32_t size = dg_store_size(&older);
    assert_int_equal(lx_nvm_memory_init(&memory, size), 0);
    const struct dg_nvm nvm = lx_nvm_memory_port(&memory);
    assert_int_equal(dg_store_format(&older, nvm, dg_ib_model_of(&dg_ocd_ib_k3)), DG_OK);
    assert_int_equal(dg_store_mount(&store, &older, nvm), DG_OK);
    dg_store_be32(bytes, shift);
    assert_int_equal(dg_store_put(&store, DG_IB_REGION_SHIFT, 0, bytes, 4), DG_OK);
    memcpy(to, memory.bytes, size);
    lx_nvm_memory_free(&memory);
    return size;
}

/* @return bytes of the file */
static size_t make_file(struct bench *self, uint8_t count)
{
    const uint32_t first = make_image(count, 0x11, self->bytes);
    const size_t n = first + make_image(count, 0x22, self->bytes + first);
    write_file(self, n);
    return n;
}

static void images_are_moved_apart(void **state)
{
    struct bench *self = *state;
    struct stat info;
    for (uint8_t count = DG_IB_REGION_SHIFT + 1; count <= DG_IB_REGION_COUNT; count++) {
        (void)make_file(self, count);
        assert_int_equal(chmod(self->path, 0640), 0);
        for (int round = 0; round < 2; round++) {
            assert_int_equal(open_ring(self), 0);
            assert_int_equal(device(self, 0)->shift, 0x11);
            assert_int_equal(device(self, 2)->shift, 0x22);
            assert_int_equal(device(self, 0)->lost | device(self, 2)->lost, 0);
            modbus_rig_close(&self->rig);
            assert_int_equal(stat(self->path, &info), 0);
            assert_int_equal(info.st_size, 2 * dg_store_size(&dg_ib_layout));
            assert_int_equal(info.st_mode & 07777, 0640);
        }
    }
}

static void a_ring_that_is_refused_changes_nothing(void **state)
{
    struct bench *self = *state;
    static uint8_t after[BYTES_MAX];
    const size_t n = make_file(self, DG_IB_REGION_TIME);
    memset(self->bytes + n / 2, 'x', 24); /* the headers of the second image */
    write_file(self, n);
    assert_int_equal(open_ring(self), -1);
    assert_non_null(strstr(lx_error_line(&self->error).text, "holds no image of device 2"));
    modbus_rig_close(&self->rig);
    assert_int_equal(read_file(self, after), n);
    assert_memory_equal(after, self->bytes, n);
}

/* A link stays one, and the file is held all the time. */
static void links_are_followed_and_the_file_stays_locked(void **state)
{
    struct bench *self = *state;
    static const uint8_t byte = 0;
    const struct lx_nvm_image image = {&byte, BYTES_MAX, ""};
    struct lx_nvm_file other;
    struct lx_error error;
    struct stat info;
    (void)make_file(self, DG_IB_REGION_TIME);
    assert_int_equal(symlink("nvm", self->link), 0);
    self->nvm = self->link;
    assert_int_equal(open_ring(self), 0);
    assert_int_equal(lstat(self->link, &info), 0);
    assert_true(S_ISLNK(info.st_mode));
    assert_int_equal(lx_nvm_file_open(&other, self->path, &image, &error), -1);
    assert_non_null(strstr(lx_error_line(&error).text, "in use"));
    modbus_rig_close(&self->rig);
    assert_int_equal(lx_nvm_file_open(&other, self->path, &image, &error), 0);
    assert_int_equal(other.length, 2 * dg_store_size(&dg_ib_layout));
    lx_nvm_file_close(&other);
}

/* Whoever is told that the file fails is told what this kind of encoder answers. */
static void a_ring_says_what_it_answers_without_its_memory(void **state)
{
    struct bench *self = *state;
    (void)make_file(self, DG_IB_REGION_COUNT);
    assert_int_equal(open_ring(self), 0);
    assert_string_equal(self->ring->stores[0].image.file.answer, "the encoder answers 86000000h");
    modbus_rig_close(&self->rig);
}

static void is_not_replaced(struct bench *self, struct lx_nvm_file *file, const char *reason)
{
    char expected[160];
    (void)snprintf(expected, sizeof expected, "%s: cannot write it again: %s", self->path, reason);
    self->error = (struct lx_error){.what = ""};
    assert_int_equal(lx_nvm_file_replace(file, self->bytes, &self->error), -1);
    assert_string_equal(self->error.what, expected);
}

/* Where no file can be made, or none gets the name, the old one stays. */
static void a_file_that_cannot_be_replaced_stays(void **state)
{
    struct bench *self = *state;
    static uint8_t after[BYTES_MAX];
    const size_t n = make_file(self, DG_IB_REGION_TIME);
    struct lx_nvm_file file;
    const struct lx_nvm_image image = {self->bytes, BYTES_MAX, ""};
    assert_int_equal(lx_nvm_file_open(&file, self->path, &image, &self->error), 0);
    assert_int_equal(rename(self->path, self->link), 0);
    is_not_replaced(self, &file, "No such file or directory");
    assert_int_equal(mkdir(self->path, 0700), 0);
    is_not_replaced(self, &file, "Is a directory");
    assert_int_equal(rmdir(self->path), 0);
    assert_int_equal(rename(self->link, self->path), 0);
    assert_int_equal(file.length, n);
    lx_nvm_file_close(&file);
    assert_int_equal(read_file(self, after), n);
    assert_memory_equal(after, self->bytes, n);
}

#define IN_A_PLACE(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_A_PLACE(images_are_moved_apart),
        IN_A_PLACE(a_ring_that_is_refused_changes_nothing),
        IN_A_PLACE(links_are_followed_and_the_file_stays_locked),
        IN_A_PLACE(a_ring_says_what_it_answers_without_its_memory),
        IN_A_PLACE(a_file_that_cannot_be_replaced_stays),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
