/* SPDX-License-Identifier: MIT */
/* The EDS file, read back as a loader does it: sections and keys of CiA 306. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/drehgeber.h"

#define TEXT_MAX 64u

struct file {
    char *text;
    size_t size;
};

static void write_text(void *to, const char *text, size_t n)
{
    assert_int_equal(fwrite(text, 1, n, to), n);
}

static struct file print_device(const struct dg_co_device *device)
{
    struct file file = {NULL, 0};
    FILE *to = open_memstream(&file.text, &file.size);
    assert_non_null(to);
    dg_co_eds(dg_cia406_sheet(device), write_text, to);
    assert_int_equal(fclose(to), 0);
    return file;
}

static struct file print(const char *model)
{
    return print_device(dg_cia406_model_of(dg_device_find(model))->device);
}

/* The value of a key in a section; NULL when there is none. The next call overwrites it. */
static const char *get(const struct file *file, const char *section, const char *key)
{
    static char value[256];
    char head[TEXT_MAX];
    char line[TEXT_MAX];
    (void)snprintf(head, sizeof head, "[%s]\r\n", section);
    (void)snprintf(line, sizeof line, "\n%s=", key);
    const char *at = strstr(file->text, head);
    if (at == NULL) {
        return NULL;
    }
    at += strlen(head) - 1;
    const char *end = strstr(at, "\n[");
    const char *found = strstr(at, line);
    if (found == NULL || (end != NULL && found > end)) {
        return NULL;
    }
    found += strlen(line);
    (void)snprintf(value, sizeof value, "%.*s", (int)strcspn(found, "\r"), found);
    return value;
}

static unsigned long number(const struct file *file, const char *section, const char *key)
{
    const char *value = get(file, section, key);
    assert_non_null(value);
    return strtoul(value, NULL, 0);
}

static void assert_value(const struct file *file, const char *section, const char *key,
                         const char *wanted)
{
    const char *value = get(file, section, key);
    if (wanted == NULL) {
        assert_null(value);
        return;
    }
    assert_non_null(value);
    assert_string_equal(value, wanted);
}

/* Values of the manual and of CiA 301, chapter 10 and the predefined connection set. */
static const struct {
    const char *section;
    const char *key;
    const char *value; /* NULL: not there */
} rows[] = {
    {"FileInfo", "FileName", "f3668.eds"},
    {"FileInfo", "EDSVersion", "4.0"},
    {"DeviceInfo", "VendorNumber", "0x13"},
    {"DeviceInfo", "ProductNumber", "0x56682001"},
    {"DeviceInfo", "RevisionNumber", "0x6C"},
    {"DeviceInfo", "BaudRate_250", "1"},
    {"DeviceInfo", "BaudRate_800", "0"},
    {"DeviceInfo", "NrOfRXPDO", "0"},
    {"DeviceInfo", "NrOfTXPDO", "4"},
    {"DeviceInfo", "LSS_Supported", "1"},
    {"DummyUsage", "Dummy0007", "0"},
    {"MandatoryObjects", "SupportedObjects", "3"},
    {"MandatoryObjects", "1", "0x1000"},
    {"MandatoryObjects", "2", "0x1001"},
    {"MandatoryObjects", "3", "0x1018"},
    {"1000", "ObjectType", "0x7"},
    {"1000", "DataType", "0x0007"},
    {"1000", "AccessType", "const"},
    {"1000", "DefaultValue", "0x20196"},
    {"1000", "PDOMapping", "0"},
    {"1000", "ObjFlags", NULL},
    {"1001", "AccessType", "ro"},
    {"1001", "PDOMapping", "1"},
    {"1001", "DefaultValue", NULL},
    {"1003", "ObjectType", "0x8"},
    {"1003", "SubNumber", "9"},
    {"1003", "DataType", NULL},
    {"1003sub0", "AccessType", "rw"},
    {"1003sub8", "AccessType", "ro"},
    {"1008", "DataType", "0x0009"},
    {"1008", "DefaultValue", "F36x8 CANopen encoder"},
    {"1008", "LowLimit", NULL},
    {"1009", "DefaultValue", "1.00"},
    {"100A", "DefaultValue", "1.08"},
    {"1003sub0", "ObjFlags", "0x1"},
    {"1003sub1", "ObjFlags", NULL},
    {"100B", "DefaultValue", "$NODEID+0x0"},
    {"1010", "ObjFlags", "0x1"},
    {"1010sub0", "ObjFlags", NULL},
    {"1010sub1", "ObjFlags", "0x1"},
    {"1010sub1", "DefaultValue", "0x1"},
    {"1011sub1", "ObjFlags", "0x1"},
    {"1013", "AccessType", "rwr"},
    {"1013", "PDOMapping", "1"},
    {"1013", "DefaultValue", NULL},
    {"1014", "AccessType", "ro"},
    {"1014", "DefaultValue", "$NODEID+0x80"},
    {"1018", "ObjectType", "0x9"},
    {"1018sub1", "DefaultValue", "0x13"},
    {"1018sub4", "DefaultValue", NULL},
    {"1018sub1", "PDOMapping", "0"},
    {"1019", "ParameterName", NULL},
    {"1029sub1", "HighLimit", "0x2"},
    {"650Asub1", "DataType", "0x0004"}, /* INTEGER32: no hexadecimal number */
    {"650Asub1", "DefaultValue", "0"},
    {"1029sub1", "LowLimit", NULL},
    {"1800", "ObjectType", "0x9"},
    {"1800sub1", "DefaultValue", "$NODEID+0x180"},
    {"1801sub1", "DefaultValue", "$NODEID+0x280"},
    {"1802sub1", "DefaultValue", "$NODEID+0x380"},
    {"1803sub1", "DefaultValue", "$NODEID+0x480"},
    {"1800sub1", "HighLimit", NULL},
    {"1800sub0", "DefaultValue", "0x5"},
    {"1800sub4", "ParameterName", NULL},
    {"1800sub6", "ParameterName", NULL},
    {"1801sub2", "DefaultValue", "0x1"},
    {"1A00sub1", "DefaultValue", "0x60040020"},
    {"1A00", "ObjFlags", NULL},
    {"1A00sub1", "PDOMapping", "0"},
    {"2101", "DefaultValue", "$NODEID+0x0"},
    {"2101", "LowLimit", "0x1"},
    {"2101", "HighLimit", NULL}, /* see below */
    {"6001", "PDOMapping", "0"},
    {"2105", "ObjectType", "0x7"},
    {"2105", "SubNumber", NULL},
    {"2105", "AccessType", "rw"},
    {"2105", "ObjFlags", "0x1"},
    {"2105", "DefaultValue", NULL},
    {"300A", "AccessType", "wo"},
    {"300A", "DefaultValue", NULL},
    {"300B", "ObjFlags", "0x1"},
    {"300B", "DefaultValue", NULL},
    {"6000", "PDOMapping", "0"},
    {"6003", "ObjFlags", "0x1"},
    {"6003", "DefaultValue", "0x0"},
    {"6004", "AccessType", "ro"},
    {"6004", "PDOMapping", "1"},
    {"6004", "DefaultValue", NULL},
    {"6030sub1", "DataType", "0x0003"},
    {"6501", "DefaultValue", "0x10000"},
};

static void known_values(void **state)
{
    const struct file file = print("f3668");
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_value(&file, rows[i].section, rows[i].key, rows[i].value);
    }
    free(file.text);
}

static void models_differ_where_they_should(void **state)
{
    const struct file file = print("f3658");
    (void)state;
    assert_value(&file, "FileInfo", "FileName", "f3658.eds");
    assert_value(&file, "DeviceInfo", "ProductName", "F3658");
    assert_value(&file, "1000", "DefaultValue", "0x10196");
    free(file.text);
}

/* Numbers have no leading zeros, but for an object's index and its data type. */
/* 16 bits of turns make no other product of it. */
static void more_turns_are_the_same_product(void **state)
{
    struct file file = print_device(&dg_cia406_multiturn_32);
    (void)state;
    assert_value(&file, "DeviceInfo", "ProductName", "F3668");
    assert_value(&file, "DeviceInfo", "OrderCode", "F3668");
    free(file.text);
}

static void numbers_are_as_short_as_they_are(void **state)
{
    struct dg_co_sheet sheet = *dg_cia406_sheet_of(&dg_f3668);
    struct dg_co_device device = *sheet.device;
    struct file file = {NULL, 0};
    FILE *to = open_memstream(&file.text, &file.size);
    (void)state;
    device.vendor_id = 1;
    device.product_code = 2;
    device.revision = 3;
    sheet.device = &device;
    assert_non_null(to);
    dg_co_eds(&sheet, write_text, to);
    assert_int_equal(fclose(to), 0);
    assert_value(&file, "DeviceInfo", "VendorNumber", "0x1");
    assert_value(&file, "DeviceInfo", "ProductNumber", "0x2");
    assert_value(&file, "DeviceInfo", "RevisionNumber", "0x3");
    assert_value(&file, "1018sub2", "DefaultValue", "0x2");
    free(file.text);
}

/* What a sheet says of a model twice is what the list of models says. */
static void sheets_are_those_of_their_models(void **state)
{
    unsigned count = 0;
    (void)state;
    for (size_t i = 0; i < dg_device_count; i++) {
        const struct dg_device *const device = dg_devices[i];
        if (device->stack == &dg_cia406_stack) {
            const struct dg_co_sheet *sheet = dg_cia406_sheet(dg_cia406_model_of(device)->device);
            assert_string_equal(sheet->model, device->name);
            assert_string_equal(sheet->resolution, device->resolution);
            count++;
        }
    }
    assert_int_equal(count, 2);
    assert_ptr_equal(dg_cia406_sheet(&dg_cia406_multiturn_32)->device, &dg_cia406_multiturn_32);
    assert_null(dg_cia406_sheet(NULL));
    assert_string_equal(dg_cia406_sheet_of(&dg_f3658)->model, "f3658");
    assert_null(dg_cia406_sheet_of(&dg_ocd_ib_k3));
    assert_null(dg_cia406_sheet_of(NULL));
}

/* Every listed object has its section, and every section of an object is listed, once. */
static void lists_and_sections_agree(void **state)
{
    static const char *const lists[] = {"MandatoryObjects", "OptionalObjects",
                                        "ManufacturerObjects"};
    const struct file file = print("f3668");
    unsigned listed = 0;
    unsigned sections = 0;
    char key[TEXT_MAX];
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        const unsigned long count = number(&file, lists[i], "SupportedObjects");
        assert_in_range(count, 1, 500);
        for (unsigned long n = 1; n <= count; n++) {
            (void)snprintf(key, sizeof key, "%lu", n);
            const unsigned long index = number(&file, lists[i], key);
            (void)snprintf(key, sizeof key, "%04lX", index);
            assert_non_null(get(&file, key, "ParameterName"));
            listed++;
        }
        (void)snprintf(key, sizeof key, "%lu", count + 1);
        assert_null(get(&file, lists[i], key));
    }
    for (const char *at = strstr(file.text, "\n["); at != NULL; at = strstr(at + 1, "\n[")) {
        char *end = NULL;
        (void)strtoul(at + 2, &end, 16);
        sections += end == at + 6 && *end == ']';
    }
    assert_int_equal(sections, listed);
    free(file.text);
}

/* SubNumber is the number of sections "<index>sub<n>" behind an array or record. */
static void sub_numbers_count_the_sub_indexes(void **state)
{
    const struct file file = print("f3668");
    char section[TEXT_MAX];
    unsigned counted = 0;
    (void)state;
    for (unsigned index = 0x1000; index < 0x7000; index++) {
        unsigned long subs = 0;
        (void)snprintf(section, sizeof section, "%04X", index);
        if (get(&file, section, "SubNumber") == NULL) {
            continue;
        }
        const unsigned long wanted = number(&file, section, "SubNumber");
        for (unsigned sub = 0; sub <= 0xFF; sub++) {
            (void)snprintf(section, sizeof section, "%04Xsub%X", index, sub);
            subs += get(&file, section, "ParameterName") != NULL;
        }
        assert_int_equal(subs, wanted);
        counted++;
    }
    assert_in_range(counted, 10, 200);
    free(file.text);
}

/* Loaders and people alike: names for all, no spaces round '=', lines below 256 characters. */
static void lines_are_clean(void **state)
{
    const struct file file = print("f3668");
    (void)state;
    assert_null(strstr(file.text, "Unnamed"));
    assert_null(strstr(file.text, " ="));
    assert_null(strstr(file.text, "= "));
    assert_null(strstr(file.text, "=\r\n"));
    for (const char *at = file.text; *at != '\0'; at += strcspn(at, "\n") + 1) {
        assert_in_range(strcspn(at, "\n"), 1, 255);
        assert_int_equal(at[strcspn(at, "\n") - 1], '\r'); /* CiA 306 */
    }
    free(file.text);
}

/* lely-core's parser takes FFh for $NODEID where nobody has told it a node-ID, and warns of a
 * default that is out of range then. */
static void defaults_without_a_node_id_are_in_range(void **state)
{
    const struct file file = print("f3668");
    unsigned count = 0;
    (void)state;
    for (const char *at = file.text; (at = strstr(at, "=$NODEID+0x")) != NULL; at++) {
        const unsigned long value = 0xFF + strtoul(at + strlen("=$NODEID+"), NULL, 0);
        const char *end = strstr(at, "\r\n\r\n");
        const char *low = strstr(at, "\nLowLimit=");
        const char *high = strstr(at, "\nHighLimit=");
        assert_true(low == NULL || low > end ||
                    value >= strtoul(low + strlen("\nLowLimit="), NULL, 0));
        assert_true(high == NULL || high > end ||
                    value <= strtoul(high + strlen("\nHighLimit="), NULL, 0));
        count++;
    }
    assert_int_equal(count, 7); /* 100Bh, 1014h, four TPDOs, 2101h */
    free(file.text);
}

/* FileVersion.FileRevision begin the release's version; both dates are its day. */
static void version_and_dates_are_the_releases(void **state)
{
    const struct file file = print("f3668");
    char version[TEXT_MAX];
    char day[TEXT_MAX];
    unsigned month;
    unsigned date;
    unsigned year;
    (void)state;
    (void)snprintf(version, sizeof version, "%lu.%lu.", number(&file, "FileInfo", "FileVersion"),
                   number(&file, "FileInfo", "FileRevision"));
    assert_memory_equal(dg_version(), version, strlen(version));
    (void)snprintf(day, sizeof day, "%s", get(&file, "FileInfo", "CreationDate"));
    assert_value(&file, "FileInfo", "ModificationDate", day);
    assert_int_equal(strlen(day), strlen("MM-DD-YYYY"));
    assert_int_equal(sscanf(day, "%2u-%2u-%4u", &month, &date, &year), 3);
    assert_in_range(month, 1, 12);
    assert_in_range(date, 1, 31);
    assert_in_range(year, 2026, 9999);
    free(file.text);
}

static void the_same_every_time(void **state)
{
    const struct file one = print("f3668");
    const struct file two = print("f3668");
    (void)state;
    assert_int_equal(one.size, two.size);
    assert_string_equal(one.text, two.text);
    assert_non_null(strstr(get(&one, "FileInfo", "CreatedBy"), dg_version()));
    free(one.text);
    free(two.text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_values),
        cmocka_unit_test(models_differ_where_they_should),
        cmocka_unit_test(more_turns_are_the_same_product),
        cmocka_unit_test(numbers_are_as_short_as_they_are),
        cmocka_unit_test(sheets_are_those_of_their_models),
        cmocka_unit_test(lists_and_sections_agree),
        cmocka_unit_test(sub_numbers_count_the_sub_indexes),
        cmocka_unit_test(lines_are_clean),
        cmocka_unit_test(defaults_without_a_node_id_are_in_range),
        cmocka_unit_test(version_and_dates_are_the_releases),
        cmocka_unit_test(the_same_every_time),
    };
    return cmocka_run_group_tests_name("eds", tests, NULL, NULL);
}
