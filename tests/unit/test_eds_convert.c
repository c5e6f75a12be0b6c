/* SPDX-License-Identifier: MIT */
/*
 * The EEPROM of an EDS file's encoder, with another file. Masters are SDO clients on a handle.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "eds_client.h"
#include "failing_nvm.h"
#include "ram_nvm.h"

#define IMAGE 16384u
#define TOLD_MAX 16u

#define HEAD(type)                                                                                 \
    "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=" type "\n"                                   \
    "[1010sub1]\nDataType=7\nAccessType=rw\nDefaultValue=1\n"                                      \
    "[1017]\nDataType=6\nAccessType=rw\nDefaultValue=0\n"                                          \
    "[6003]\nDataType=7\nAccessType=rw\nDefaultValue=0\n"                                          \
    "[6004]\nDataType=7\nAccessType=ro\n"                                                          \
    "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=4096\n"                                       \
    "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=4096\n"
#define VALUE(index, type, more) "[" #index "]\nAccessType=rw\nDataType=" #type "\n" more

static const char before[] =
    HEAD("0x20196") VALUE(2000, 7, "") VALUE(2001, 5, "") VALUE(2002, 6, "") VALUE(2003, 3, "");
static const char after[] =
    HEAD("0x20196") VALUE(2000, 7, "HighLimit=10\n") VALUE(2001, 5, "DefaultValue=2\n")
        VALUE(2002, 7, "DefaultValue=6\n") VALUE(2004, 7, "DefaultValue=8\n");

static struct eds_client first, second;
static struct {
    uint32_t key;
    enum dg_co_misfit why;
} told[TOLD_MAX];
static size_t told_count;

static void read_file(struct eds_client *self, const char *text)
{
    assert_int_equal(eds_client_read(self, text, strlen(text)), DG_OK);
    eds_client_make(self);
}

static void save(struct eds_client *self)
{
    assert_int_equal(eds_client_download(self, 0x1010, 1, EDS_CLIENT_SAVE, 4), 0);
}

static void write_values(uint32_t at_2000)
{
    eds_client_switch_on(&first);
    assert_int_equal(eds_client_download(&first, 0x2000, 0, at_2000, 4), 0);
    assert_int_equal(eds_client_download(&first, 0x2001, 0, 9, 1), 0);
    assert_int_equal(eds_client_download(&first, 0x2002, 0, 0x1234, 2), 0);
    assert_int_equal(eds_client_download(&first, 0x2003, 0, 0xFFFE, 2), 0);
    assert_int_equal(eds_client_download(&first, 0x1017, 0, 0x300, 2), 0);
    assert_int_equal(eds_client_download(&first, 0x6003, 0, 77, 4), 0);
}

static void keep_misfit(void *ctx, uint32_t key, enum dg_co_misfit why)
{
    assert_ptr_equal(ctx, told);
    assert_true(told_count < TOLD_MAX);
    told[told_count].key = key;
    told[told_count++].why = why;
}

/* What the image of the first one is to the second one's file; `to`: copied there. */
static int convert(struct dg_nvm to)
{
    static struct ram_nvm image;
    const size_t size = dg_host_memory_size(first.host);

    assert_true(size <= IMAGE);
    ram_nvm_init(&image, IMAGE);
    assert_int_equal(dg_host_memory_copy(first.host, image.bytes, size), DG_HOST_OK);
    told_count = 0;
    return dg_co_convert(&second.file.file, ram_nvm_port(&image), to, keep_misfit, told);
}

static void assert_told(uint32_t key, enum dg_co_misfit why)
{
    for (size_t i = 0; i < told_count; i++) {
        if (told[i].key == key) {
            assert_int_equal(told[i].why, why);
            return;
        }
    }
    fail_msg("nothing is said of %08Xh", key);
}

/* ------------------------------------------------------------ tests */

static void an_image_tells_what_does_not_fit(void **state)
{
    (void)state;
    read_file(&first, before);
    read_file(&second, after);
    write_values(11);
    save(&first);
    assert_int_equal(convert((struct dg_nvm){NULL, NULL}), DG_OK);
    assert_told(DG_CO_KEY(0x2000, 0), DG_CO_OUTSIDE);
    assert_told(DG_CO_KEY(0x2002, 0), DG_CO_RETYPED);
    assert_told(DG_CO_KEY(0x2003, 0), DG_CO_GONE);
    assert_told(DG_CO_KEY(0x2004, 0), DG_CO_NEW);
    assert_int_equal(told_count, 4);
    read_file(&second, HEAD("0x10196") VALUE(2000, 7, ""));
    assert_int_equal(convert((struct dg_nvm){NULL, NULL}), DG_OK);
    assert_told(DG_CO_KEY(0x1000, 0), DG_CO_FOREIGN);
}

#define IDENTITY(sub, value)                                                                       \
    "[1018]\nObjectType=9\n[1018sub" #sub "]\nDataType=7\nAccessType=ro\nDefaultValue=" value "\n"

/* Each of the values of the image, and each word of the identity, counts for itself. */
static void every_value_of_an_image_is_compared(void **state)
{
    static const char *const identities[] = {
        HEAD("0x20196") VALUE(2000, 7, "") IDENTITY(1, "9"),
        HEAD("0x20196") VALUE(2000, 7, "") IDENTITY(2, "9"),
        HEAD("0x20196") VALUE(2000, 7, "") IDENTITY(3, "9"),
    };
    (void)state;
    read_file(&first, before);
    write_values(5);
    save(&first);
    read_file(&second, HEAD("0x20196"));
    assert_int_equal(convert((struct dg_nvm){NULL, NULL}), DG_OK);
    for (uint16_t index = 0x2000; index <= 0x2003; index++) {
        assert_told(DG_CO_KEY(index, 0), DG_CO_GONE);
    }
    assert_int_equal(told_count, 4);
    for (uint8_t i = 0; i < DG_COUNT(identities); i++) {
        read_file(&second, identities[i]);
        assert_int_equal(convert((struct dg_nvm){NULL, NULL}), DG_OK);
        assert_told(DG_CO_KEY(0x1018, i + 1u), DG_CO_FOREIGN);
        assert_int_equal(told_count, 4);
    }
}

/* With it the encoder of the other file goes on where the first one ended. */
static void what_fits_is_copied(void **state)
{
    static struct ram_nvm memory;
    static uint8_t bytes[IMAGE];
    (void)state;
    for (uint32_t at_2000 = 5; at_2000 < 15; at_2000 += 6) {
        read_file(&first, before);
        read_file(&second, after);
        write_values(at_2000);
        save(&first);
        const size_t size = dg_host_memory_size(second.host);
        ram_nvm_init(&memory, IMAGE);
        assert_int_equal(dg_co_format(&second.file.file.device, ram_nvm_port(&memory), 1), DG_OK);
        assert_int_equal(convert(ram_nvm_port(&memory)), DG_OK);
        memcpy(bytes, memory.bytes, size);
        assert_int_equal(dg_host_memory_load(second.host, bytes, size), DG_HOST_OK);
        assert_int_equal(dg_host_power(second.host, second.now, true), DG_HOST_OK);
        assert_int_equal(eds_client_upload(&second, 0x2000, 0), at_2000 > 10 ? 0 : at_2000);
        assert_int_equal(eds_client_upload(&second, 0x2001, 0) & 0xFFu, 9);
        assert_int_equal(eds_client_upload(&second, 0x2002, 0), 6);
        assert_int_equal(eds_client_upload(&second, 0x2004, 0), 8);
        assert_int_equal(eds_client_upload(&second, 0x1017, 0) & 0xFFFFu, 0x300);
        assert_int_equal(eds_client_upload(&second, 0x6003, 0), 77);
    }
}

#define WIDE "DefaultValue=0x123456789A\n"
static const char texts_before[] =
    HEAD("0x20196") VALUE(2000, 7, "") VALUE(2100, 9, "DefaultValue=old\n") VALUE(2101, 0x1B, WIDE)
        VALUE(2102, 0x15, "") VALUE(2103, 9, "") VALUE(2104, 0x1B, WIDE);
static const char texts_after[] = HEAD("0x20196") VALUE(2000, 7, "")
    VALUE(2099, 9, "DefaultValue=new\n") VALUE(2100, 9, "DefaultValue=text\n")
        VALUE(2101, 0x1B, "HighLimit=255\n") VALUE(2102, 0x1B, "") VALUE(2104, 0x1B, "");

/* Text of up to 4 characters, as it is in one frame. */
static uint32_t text_of(struct eds_client *self, uint16_t index)
{
    const struct dg_host_event answer = eds_client_ask(self, 0x40, index, 0, 0);

    return answer.data[0] == 0x43 ? dg_load_le32(&answer.data[4]) : answer.data[0];
}

/* Values of more than 32 bits go by their keys, too. */
static void texts_and_wide_numbers_are_copied(void **state)
{
    static struct ram_nvm memory;
    static uint8_t bytes[IMAGE];
    (void)state;
    read_file(&first, texts_before);
    read_file(&second, texts_after);
    eds_client_switch_on(&first);
    assert_int_equal(eds_client_download(&first, 0x2100, 0, 0x64636261, 4), 0);
    save(&first);
    const size_t size = dg_host_memory_size(second.host);
    ram_nvm_init(&memory, IMAGE);
    assert_int_equal(dg_co_format(&second.file.file.device, ram_nvm_port(&memory), 1), DG_OK);
    assert_int_equal(convert(ram_nvm_port(&memory)), DG_OK);
    assert_told(DG_CO_KEY(0x2099, 0), DG_CO_NEW);
    assert_told(DG_CO_KEY(0x2101, 0), DG_CO_OUTSIDE);
    assert_told(DG_CO_KEY(0x2102, 0), DG_CO_RETYPED);
    assert_told(DG_CO_KEY(0x2103, 0), DG_CO_GONE);
    assert_int_equal(told_count, 4);
    memcpy(bytes, memory.bytes, size);
    assert_int_equal(dg_host_memory_load(second.host, bytes, size), DG_HOST_OK);
    assert_int_equal(dg_host_power(second.host, second.now, true), DG_HOST_OK);
    assert_int_equal(text_of(&second, 0x2100), 0x64636261);
    const struct dg_host_event fresh = eds_client_ask(&second, 0x40, 0x2099, 0, 0);
    assert_int_equal(fresh.data[0], 0x47);
    assert_memory_equal(&fresh.data[4], "new", 3);
    const struct dg_host_event wide = eds_client_ask(&second, 0x40, 0x2104, 0, 0);
    assert_int_equal(dg_load_le32(&wide.data[4]), 8);
    const struct dg_host_event value = eds_client_ask(&second, 0x60, 0, 0, 0);
    assert_int_equal(dg_load_le32(&value.data[1]), 0x3456789A);
}

/* Values that were never saved are nobody's. */
static void what_was_not_saved_is_of_no_file(void **state)
{
    (void)state;
    read_file(&first, before);
    read_file(&second, after);
    write_values(5);
    assert_int_equal(convert((struct dg_nvm){NULL, NULL}), DG_ERR_FOREIGN);
    assert_int_equal(told_count, 0);
}

/* Whatever stands in the image: it is refused, or what is made of it starts. */
static void convert_damaged(bool texts)
{
    static struct ram_nvm image, memory;
    uint32_t seed = 1;
    unsigned converted = 0;
    read_file(&first, texts ? texts_before : before);
    read_file(&second, texts ? texts_after : after);
    if (texts) {
        eds_client_switch_on(&first);
    } else {
        write_values(5);
    }
    save(&first);
    const size_t size = dg_host_memory_size(first.host);
    for (unsigned i = 0; i < 2000; i++) {
        ram_nvm_init(&image, IMAGE);
        ram_nvm_init(&memory, IMAGE);
        assert_int_equal(dg_host_memory_copy(first.host, image.bytes, size), DG_HOST_OK);
        for (unsigned n = 0; n <= i % 4u; n++) {
            seed = seed * 1664525u + 1013904223u;
            image.bytes[(seed >> 8) % size] = (uint8_t)(seed >> 24);
        }
        told_count = 0;
        assert_int_equal(dg_co_format(&second.file.file.device, ram_nvm_port(&memory), 1), DG_OK);
        const int result = dg_co_convert(&second.file.file, ram_nvm_port(&image),
                                         ram_nvm_port(&memory), NULL, NULL);
        assert_true(result == DG_OK || result == DG_ERR_FOREIGN);
        converted += result == DG_OK ? 1u : 0u;
    }
    assert_true(converted > 1000 && converted < 2000);
}

static void damaged_images_do_no_harm(void **state)
{
    (void)state;
    convert_damaged(false);
    convert_damaged(true);
}

/* One access to one of the memories fails, whichever: the image stays as it was, and the encoder of
 * the other file starts on what was made of it. */
static void convert_failing(bool texts, bool source)
{
    static struct ram_nvm image, memory, whole;
    struct failing_nvm failing;
    uint32_t refused = 0;
    uint32_t count = UINT32_MAX;
    read_file(&first, texts ? texts_before : before);
    read_file(&second, texts ? texts_after : after);
    if (texts) {
        eds_client_switch_on(&first);
    } else {
        write_values(5);
    }
    save(&first);
    const size_t size = dg_host_memory_size(first.host);
    ram_nvm_init(&image, IMAGE);
    assert_int_equal(dg_host_memory_copy(first.host, image.bytes, size), DG_HOST_OK);
    whole = image;
    for (uint32_t n = 0; n < count; n++) {
        ram_nvm_init(&memory, IMAGE);
        assert_int_equal(dg_co_format(&second.file.file.device, ram_nvm_port(&memory), 1), DG_OK);
        const struct dg_nvm from = ram_nvm_port(&image);
        const struct dg_nvm to = ram_nvm_port(&memory);
        const int result =
            dg_co_convert(&second.file.file, source ? failing_nvm_port(&failing, from, n) : from,
                          source ? to : failing_nvm_port(&failing, to, n), NULL, NULL);
        count = failing.count <= n ? 0 : UINT32_MAX; /* nothing has failed any more */
        assert_true(result == DG_OK || result == DG_ERR_IO || result == DG_ERR_FOREIGN);
        refused += result != DG_OK ? 1u : 0u;
        assert_memory_equal(image.bytes, whole.bytes, size);
        assert_int_equal(
            dg_host_memory_load(second.host, memory.bytes, dg_host_memory_size(second.host)),
            DG_HOST_OK);
        if (count == 0) {
            assert_int_equal(result, DG_OK);
        }
    }
    assert_true(refused > 0);
}

static void memories_that_fail_do_no_harm(void **state)
{
    (void)state;
    convert_failing(false, true);
    convert_failing(false, false);
    convert_failing(true, true);
    convert_failing(true, false);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_image_tells_what_does_not_fit),
        cmocka_unit_test(every_value_of_an_image_is_compared),
        cmocka_unit_test(what_fits_is_copied),
        cmocka_unit_test(texts_and_wide_numbers_are_copied),
        cmocka_unit_test(what_was_not_saved_is_of_no_file),
        cmocka_unit_test(damaged_images_do_no_harm),
        cmocka_unit_test(memories_that_fail_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
