/* SPDX-License-Identifier: MIT */
/* Which files a client of a rig may have its trace replace. The port asks for openat2(), which
   QEMU's user mode does not have. */
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

#include "can_bus.h"
#include "stacks.h"
#include "trace.h"

/* A folder of its own, and what was read of a file. */
struct place {
    char folder[32];
    char path[64];
    struct lx_tap tap;
    struct lx_error error;
    size_t length;
    char text[256];
};

static int set_up(void **state)
{
    static struct place place;

    place = (struct place){.folder = "/tmp/test_trace.XXXXXX"};
    assert_non_null(mkdtemp(place.folder));
    *state = &place;
    return 0;
}

static int tear_down(void **state)
{
    struct place *self = *state;
    return rmdir(self->folder);
}

static void read_file(struct place *self)
{
    FILE *file = fopen(self->path, "rb");
    assert_non_null(file);
    self->length = fread(self->text, 1, sizeof self->text, file);
    (void)fclose(file);
}

static void write_bytes(const struct place *self, const char *bytes, size_t n)
{
    FILE *file = fopen(self->path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
}

/* @return whether a client may write its trace in place of the file with these bytes; what is
 * refused stays as it was */
static bool is_replaced(struct place *self, const struct lx_folder *folder,
                        const struct lx_stack *stack, const char *bytes, size_t n)
{
    write_bytes(self, bytes, n);
    const struct lx_trace_setup setup = {.path = strrchr(self->path, '/') + 1,
                                         .folder = folder,
                                         .kind = stack->trace,
                                         .wire = "w",
                                         .tap = &self->tap};
    struct lx_trace *trace = lx_trace_open(&setup, 0, &self->error);
    if (trace != NULL) {
        assert_int_equal(lx_trace_close(trace, &self->error), 0);
        return true;
    }
    assert_non_null(strstr(lx_error_line(&self->error).text, "exists, and is not to be replaced"));
    read_file(self);
    assert_true(self->length == n && memcmp(self->text, bytes, n) == 0);
    return false;
}

/* Its own of this kind: the head of a VCD file with the program's name, of a pcapng file that
 * option (draft, 3.5.1 and 4.1: at 24 the code 4 and the length), the first columns of a ring. A
 * log of CAN begins with nothing that could be known. */
static void a_client_replaces_a_trace_of_its_kind_only(void **state)
{
    static const struct {
        const struct lx_stack *stack;
        const char *name;
        size_t at;
        size_t n;
        const char *mark;
    } rows[] = {
        {&lx_hf_stack, "a.vcd", 0, 19, "$comment drehgeber:"},
        {&lx_biss_stack, "b.vcd", 0, 19, "$comment drehgeber:"},
        {&lx_cia406_stack, "c.pcapng", 24, 13, "\x04\0\x09\0drehgeber"},
        {&lx_cia406_stack, "d.pcap", 24, 13, "\x04\0\x09\0drehgeber"},
        {&lx_cia406_stack, "e.log", 0, 0, ""},
        {&lx_ib_stack, "f.csv", 0, 12, "time_s,in_0,"},
    };
    struct place *place = *state;
    struct lx_folder folder;
    assert_int_equal(lx_folder_open(&folder, place->folder, &place->error), 0);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct lx_stack *stack = rows[i].stack;
        const size_t end = rows[i].at + rows[i].n;
        char bytes[64];
        memset(bytes, 'x', sizeof bytes);
        memcpy(bytes + rows[i].at, rows[i].mark, rows[i].n);
        (void)snprintf(place->path, sizeof place->path, "%s/%s", place->folder, rows[i].name);
        assert_true(is_replaced(place, &folder, stack, "", 0));
        assert_int_equal(is_replaced(place, &folder, stack, bytes, sizeof bytes), rows[i].n > 0);
        assert_int_equal(is_replaced(place, &folder, stack, bytes, end), end == 0 || rows[i].n > 0);
        for (size_t at = rows[i].at; at < end; at++) {
            assert_false(is_replaced(place, &folder, stack, bytes, at == 0 ? 1 : at));
            bytes[at] ^= 1;
            assert_false(is_replaced(place, &folder, stack, bytes, sizeof bytes));
            bytes[at] ^= 1;
        }
        assert_int_equal(unlink(place->path), 0);
    }
    lx_folder_close(&folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_client_replaces_a_trace_of_its_kind_only, set_up,
                                        tear_down),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
