/* SPDX-License-Identifier: MIT */
/*
 * EDS and DCF files as other projects write them, and mutants of each. What they have in common
 * with theirs is the structure, which was written anew; no text is copied:
 *
 *   the sample of canopen (Python)       https://github.com/canopen-python/canopen, MIT
 *   the fake slave of ros2_canopen       https://github.com/ros-industrial/ros2_canopen, Apache-2.0
 *   the demo device of CANopenNode       https://github.com/CANopenNode/CANopenDemo, Apache-2.0
 *   a slave of the tests of lely-core    https://gitlab.com/lely_industries/lely-core, Apache-2.0
 *   the slave of c-open                  https://github.com/rtlabs-com/c-open, GPL-3.0
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "eds_client.h"

#define MUTANTS 500u
#define TEXT_MAX 8192u

#define HEAD                                                                                       \
    "[FileInfo]\nFileName=own.eds\nFileVersion=1\nEDSVersion=4.0\nCreationDate=01-01-2026\n"
#define RATES "BaudRate_10=1\nBaudRate_125=1\nBaudRate_250=1\nBaudRate_1000=1\n"
#define DUMMIES "[DummyUsage]\nDummy0001=0\nDummy0005=1\n[Comments]\nLines=1\nLine1=own words\n"
#define U32(section, access, value)                                                                \
    "[" section "]\nParameterName=Of " section                                                     \
    "\nObjectType=0x7\nDataType=0x0007\nAccessType=" access "\nDefaultValue=" value                \
    "\nPDOMapping=0\n"
#define U8(section, access, value)                                                                 \
    "[" section "]\nParameterName=Of " section                                                     \
    "\nObjectType=0x7\nDataType=0x0005\nAccessType=" access "\nDefaultValue=" value                \
    "\nPDOMapping=1\n"

/* A DCF: values of its own beside defaults, names that are not ASCII, floats in decimal, arrays
   without sub-sections and compact ones, limits that its default breaks, wrong lists. */
static const char python_sample[] = HEAD
    "[DeviceInfo]\nVendorName=Own\nVendorNumber=1\n" RATES
    "[DeviceComissioning]\nNodeID=0x10\nNodeName=Own\nBaudrate=250\nNetNumber=0\n" DUMMIES
    "[MandatoryObjects]\nSupportedObjects=3\n1=0x1000\n2=0x1001\n3=0x1018\n"
    "[OptionalObjects]\nSupportedObjects=9\n1=0x1003\n" U32("1000", "ro", "0x00000000") U8(
        "1001", "ro",
        "0x00") "[1003]\nParameterName=Errors\nObjectType=0x8\nSubNumber=9\n" U8("1003sub0", "rw",
                                                                                 "3")
        U32("1003sub1", "ro",
            "0") "[1018]\nParameterName=Identity\nObjectType=0x9\nSubNumber=5\n" U8("1018sub0",
                                                                                    "ro", "4")
            U32("1018sub1", "ro",
                "0") "[3002]\nParameterName=Rate (Hz)\nObjectType=0x7\nDataType=0x0008\n"
                     "AccessType=ro\nDefaultValue=5.2\nLowLimit=4.5\nParameterValue=5.200000\n"
                     "[3003]\nParameterName=Open \xC2\xB0 %\nObjectType=0x8\nDataType=0x0008\nAccessType=rw\n"
                     "[3004]\nCompactSubObj=3\nParameterName=Status\nObjectType=8\nDataType=0x0006\nAccessType=ro\n"
                     "DefaultValue=3\n[3004Name]\nNrOfEntries=2\n1=One\n3=Three\n"
                     "[3040]\nParameterName=Limits\nDataType=0x2\nAccessType=rw\nLowLimit=-30\nHighLimit=80\n"
                     "DefaultValue=-3\n"
                     "[3041]\nParameterName=Broken\nDataType=0x3\nAccessType=rw\nLowLimit=10\nHighLimit=-10\n"
                     "DefaultValue=0\n"
                     "[3050]\nParameterName=Extensions\nObjectType=0x9\nSubNumber=0x2\n" U8(
                         "3050sub0", "ro",
                         "0x2") "[3050sub1]\nParameterName=Unit\nDataType=0x0005\nAccessType=rw\nDefaultValue=7\nFactor=0.1\n"
                                "Unit=mm\nDescription=own\n"
                                "[3063]\nParameterName=Domain\nObjectType=0x2\nDataType=0x0007\nAccessType=rw\n";

/* No ObjectType, two-digit ones, 254 errors by CompactSubObj, values that store, dummies that are
   types, one PDO in each direction. */
static const char ros_slave[] =
    "[DeviceInfo]\nVendorName=Own\nVendorNumber=0x360\n" RATES "NrOfRxPDO=1\nNrOfTxPDO=1\n" DUMMIES
    "[ManufacturerObjects]\nSupportedObjects=2\n1=0x4000\n2=0x4001\n"
    "[1000]\nParameterName=Type\nDataType=0x0007\nAccessType=ro\nDefaultValue=0x00000000\n"
    "[1001]\nParameterName=Errors\nDataType=0x0005\nAccessType=ro\n"
    "[1003]\nParameterName=Field\nObjectType=0x08\nDataType=0x0007\nAccessType=ro\n"
    "CompactSubObj=254\n"
    "[1014]\nParameterName=EMCY\nDataType=0x0007\nAccessType=rw\nDefaultValue=$NODEID+0x80\n"
    "[1016]\nParameterName=Consumers\nObjectType=0x08\nDataType=0x0007\nAccessType=rw\n"
    "CompactSubObj=1\n[1017]\nParameterName=Producer\nDataType=0x0006\nAccessType=rw\n"
    "[1018]\nSubNumber=5\nParameterName=Identity\nObjectType=0x09\n"
    "[1018sub0]\nDataType=0x0005\nAccessType=const\nDefaultValue=4\n"
    "[1018sub1]\nDataType=0x0007\nAccessType=ro\nDefaultValue=0x360\n"
    "[1400]\nSubNumber=6\nObjectType=0x09\n[1400sub0]\nDataType=0x0005\nAccessType=const\n"
    "DefaultValue=5\n[1400sub1]\nDataType=0x0007\nAccessType=rw\nDefaultValue=$NODEID+0x200\n"
    "[1600]\nObjectType=0x09\nDataType=0x0007\nAccessType=rw\nCompactSubObj=1\n"
    "[1600Value]\nNrOfEntries=1\n1=0x40000020\n"
    "[1800]\nObjectType=0x09\n[1800sub1]\nDataType=0x0007\nAccessType=rw\n"
    "DefaultValue=$NODEID+0x180\n[1800sub2]\nDataType=0x0005\nAccessType=rw\nDefaultValue=0xFF\n"
    "[1A00]\nObjectType=0x09\nDataType=0x0007\nAccessType=rw\nCompactSubObj=1\n"
    "[1A00Value]\nNrOfEntries=1\n1=0x40010020\n"
    "[4000]\nDataType=0x0007\nAccessType=rww\nPDOMapping=1\n"
    "[4001]\nDataType=0x0007\nAccessType=rwr\nPDOMapping=1\nDefaultValue=0x11223344\n";

/* Comments in sections, empty defaults, defaults with leading zeros, COB-IDs with flags, mapping of
   objects that are not there, all integer types, UTF-8. */
static const char node_demo[] = HEAD
    "Description=\xC3\xA9\n[DeviceInfo]\nVendorName=-\nProductName=Own demo\n" RATES
    "LSS_Supported=1\n" DUMMIES U32("1000", "ro", "0x00000000") U8(
        "1001", "ro",
        "0x00") "[1003]\nParameterName=Field\nObjectType=0x8\n;StorageLocation=RAM\nSubNumber=0x3\n" U8("1003sub0",
                                                                                                        "rw",
                                                                                                        "")
        U32("1003sub1", "ro", "") U32(
            "1003sub2", "ro",
            "") "[1010]\nObjectType=0x8\n;StorageLocation=RAM\nSubNumber=0x3\n" U8("1010sub0", "ro",
                                                                                   "0x02")
            U32("1010sub1", "rw", "0x00000001") U32("1010sub2", "rw", "0x00000003") U8(
                "1019", "rw",
                "0") "[1021]\nDataType=0x000F\nObjectType=0x7\nAccessType=ro\n"
                     "[1200]\nObjectType=0x9\nSubNumber=0x3\n" U8("1200sub0", "ro", "2")
                         U32("1200sub1", "ro", "$NODEID+0x600") U32(
                             "1200sub2", "ro",
                             "$NODEID+0x580") "[1801]\nObjectType=0x9\nSubNumber=0x7\n" U8("1801sub0",
                                                                                           "ro",
                                                                                           "0x06")
                             U32("1801sub1", "rw", "$NODEID+0xC0000280") U8("1801sub2", "rw", "254") U8(
                                 "1801sub6",
                                 "rw",
                                 "0") "[1A01]\nObjectType=0x9\nSubNumber=0x2\n" U8("1A01sub0", "rw",
                                                                                   "1")
                                 U32("1A01sub1", "rw",
                                     "0x68000108") "[2100]\nObjectType=0x7\n;StorageLocation=RAM\nDataType=0x000A\nAccessType=ro\n"
                                                   "DefaultValue=00000000000000000000\n"
                                                   "[2105]\nDataType=0x0015\nAccessType=rw\nDefaultValue=1\n[2106]\nDataType=0x001B\nAccessType=rw\n"
                                                   "[2107]\nDataType=0x0011\nAccessType=rw\nDefaultValue=1.5\n"
                                                   "[2110]\nObjectType=0x8\nSubNumber=0x3\n" U8(
                                                       "2110sub0", "ro", "0x02") U32("2110sub1",
                                                                                     "rw", "010")
                                                       U32("2110sub2", "rw",
                                                           "0x0A") "[2122]\nDataType=0x000F\nAccessType=rw\nDefaultValue=\n";

/* Bits in a mapping, a node-ID in hexadecimal, no name of the product. */
static const char lely_slave[] =
    "[DeviceInfo]\nVendorName=Own\nVendorNumber=0x00000360\n" RATES
    "[DeviceComissioning]\nNodeID=0x02\n[ManufacturerObjects]\nSupportedObjects=2\n1=0x2000\n"
    "2=0x2001\n[1000]\nDataType=0x0007\nAccessType=ro\n[1001]\nDataType=0x0005\nAccessType=ro\n"
    "[1018]\nSubNumber=5\nObjectType=0x09\n[1018sub0]\nDataType=0x0005\nAccessType=const\n"
    "DefaultValue=0x4\n[1018sub4]\nDataType=0x0007\nAccessType=ro\n"
    "[1800]\nSubNumber=3\nObjectType=0x09\n[1800sub0]\nDataType=0x0005\nAccessType=const\n"
    "DefaultValue=0x02\n[1800sub1]\nDataType=0x0007\nAccessType=rw\nDefaultValue=$NODEID+0x180\n"
    "[1800sub2]\nDataType=0x0005\nAccessType=rw\nDefaultValue=0x01\n"
    "[1A00]\nObjectType=0x09\nDataType=0x0007\nAccessType=rw\nCompactSubObj=2\n"
    "[1A00Value]\nNrOfEntries=2\n1=0x2000001c\n2=0x20010020\n"
    "[2000]\nDataType=0x0007\nAccessType=rw\nPDOMapping=1\n"
    "[2001]\nDataType=0x0007\nAccessType=rw\nPDOMapping=1\n";

/* CR LF, lines of nothing but a semicolon, defaults behind the mapping, lists of wrong length. */
static const char open_slave[] =
    "[FileInfo]\r\nFileName=own.eds\r\n;\r\n[DeviceInfo]\r\nBaudRate_125=1\r\nGranularity=8\r\n"
    "VendorName=Own\r\nProductName=Own slave\r\n;\r\n[MandatoryObjects]\r\nSupportedObjects=3\r\n"
    "1=0x1000\r\n2=0x1001\r\n3=0x1018\r\n;\r\n"
    "[1000]\r\nParameterName=Type\r\nObjectType=0x7\r\nDataType=0x0007\r\nAccessType=ro\r\n"
    "PDOMapping=0\r\nDefaultValue=0\r\n"
    "[1003]\r\nObjectType=0x8\r\nSubNumber=5\r\n[1003sub0]\r\nObjectType=0x7\r\nDataType=0x0005\r\n"
    "AccessType=rw\r\n[1005]\r\nDataType=0x0007\r\nAccessType=rw\r\nDefaultValue=0x80\r\n"
    "[1200]\r\nObjectType=0x9\r\nSubNumber=3\r\n[1200sub0]\r\nDataType=0x0005\r\nAccessType=ro\r\n"
    "DefaultValue=2\r\n[1200sub1]\r\nDataType=0x0007\r\nAccessType=ro\r\n"
    "DefaultValue=$NODEID+0x600\r\n"
    "[1A00]\r\nObjectType=0x9\r\nSubNumber=9\r\n[1A00sub0]\r\nDataType=0x0005\r\nAccessType=rw\r\n"
    "DefaultValue=1\r\n[1A00sub1]\r\nDataType=0x0007\r\nAccessType=rw\r\nDefaultValue=0x20010010\r\n"
    "[2001]\r\nObjectType=0x7\r\nDataType=0x0006\r\nAccessType=ro\r\nPDOMapping=1\r\n"
    "DefaultValue=0x55AA\r\n[2003]\r\nObjectType=0x8\r\nSubNumber=3\r\n"
    "[2003sub1]\r\nDataType=0x0009\r\nAccessType=rw\r\nDefaultValue=text\r\n";

static struct eds_client rig;

static void start_of(const char *text)
{
    assert_int_equal(eds_client_read(&rig, text, strlen(text)), DG_OK);
    eds_client_make(&rig);
    eds_client_switch_on(&rig);
}

/* ------------------------------------------------------------ as they are */

static void a_sample_of_python(void **state)
{
    (void)state;
    start_of(python_sample);
    assert_int_equal(rig.file.file.node_id, 0x10);
    assert_int_equal(eds_client_upload(&rig, 0x3004, 3), 3);
    assert_int_equal(eds_client_upload(&rig, 0x3050, 1), 7);
    assert_int_equal(eds_client_upload(&rig, 0x3040, 0) & 0xFFu, 0xFD);
    assert_int_equal(eds_client_download(&rig, 0x3040, 0, 0xE1, 1), 0x06090030);
    assert_int_equal(eds_client_download(&rig, 0x3041, 0, 0x7FFF, 2), 0);
    assert_true(rig.notes > 0);
}

static void a_fake_slave_of_ros(void **state)
{
    (void)state;
    start_of(ros_slave);
    assert_int_equal(eds_client_upload(&rig, 0x4001, 0), 0x11223344);
    assert_int_equal(eds_client_download(&rig, 0x4000, 0, 0x12345678, 4), 0);
    assert_int_equal(eds_client_upload(&rig, 0x4000, 0), 0x12345678);
    assert_int_equal(eds_client_upload(&rig, 0x1014, 0), 0x80 + EDS_CLIENT_NODE);
    assert_int_equal(eds_client_upload(&rig, 0x1A00, 1), 0x40010020);
    assert_int_equal(eds_client_upload(&rig, 0x1003, 0) & 0xFFu, 0);
    assert_int_equal(eds_client_download(&rig, 0x1017, 0, 100, 2), 0);
}

static void a_demo_device(void **state)
{
    (void)state;
    start_of(node_demo);
    assert_int_equal(eds_client_upload(&rig, 0x1200, 1), 0x600 + EDS_CLIENT_NODE);
    assert_int_equal(eds_client_upload(&rig, 0x2110, 1), 8);
    assert_int_equal(eds_client_upload(&rig, 0x2110, 2), 10);
    assert_int_equal(eds_client_download(&rig, 0x1010, 2, EDS_CLIENT_SAVE, 4), 0);
    assert_string_equal(rig.file.device.name, "own-demo");
}

static void a_slave_of_lely(void **state)
{
    (void)state;
    start_of(lely_slave);
    assert_int_equal(rig.file.file.node_id, 2);
    assert_int_equal(eds_client_upload(&rig, 0x1018, 0) & 0xFFu, 4);
    assert_int_equal(eds_client_download(&rig, 0x2001, 0, 5, 4), 0);
    assert_int_equal(eds_client_upload(&rig, 0x2001, 0), 5);
}

static void a_slave_of_c_open(void **state)
{
    (void)state;
    start_of(open_slave);
    assert_int_equal(eds_client_upload(&rig, 0x2001, 0) & 0xFFFFu, 0x55AA);
    assert_int_equal(eds_client_upload(&rig, 0x1A00, 0) & 0xFFu, 1);
    assert_int_equal(eds_client_upload(&rig, 0x1200, 1), 0x600 + EDS_CLIENT_NODE);
}

/* ------------------------------------------------------------ mutants */

static uint32_t next_random(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return *seed >> 8;
}

/* Bytes become others, a piece is gone, or stands there twice. @return its length */
static size_t mutate(char *to, const char *text, uint32_t *seed)
{
    const size_t n = strlen(text);
    const size_t at = next_random(seed) % n;
    const size_t piece = 1u + next_random(seed) % 200u;
    const size_t part = piece < n - at ? piece : n - at;

    assert_true(n + part < TEXT_MAX);
    memcpy(to, text, n + 1u);
    switch (next_random(seed) % 4u) {
    case 0:
        memmove(to + at, to + at + part, n - at - part);
        return n - part;
    case 1:
        memcpy(to + at + part, text + at, n - at);
        return n + part;
    case 2:
        to[at] = (char)next_random(seed);
        to[next_random(seed) % n] = "0129-+$xX[]=;\n \r"[next_random(seed) % 16u];
        return n;
    default:
        for (uint32_t i = 0; i <= part % 8u; i++) {
            to[next_random(seed) % n] = text[next_random(seed) % n];
        }
        return n;
    }
}

/* Refused with a reason, or an encoder that answers, saves, and is there again behind a power cut.
   The test's own limit bounds the time. */
static void run_mutants(const char *text, unsigned least)
{
    static char mutant[TEXT_MAX];
    uint32_t seed = 1;
    unsigned started = 0;

    for (unsigned i = 0; i < MUTANTS; i++) {
        const size_t n = mutate(mutant, text, &seed);
        const int result = eds_client_read(&rig, mutant, n);
        if (result != DG_OK) {
            assert_int_equal(result, DG_ERR_ARGUMENT);
            assert_string_not_equal(rig.error.what, "");
            continue;
        }
        started++;
        eds_client_make(&rig);
        eds_client_switch_on(&rig);
        const struct dg_co_dictionary *dictionary = &rig.file.file.device.dictionary;
        for (uint16_t row = 0; row < dictionary->count; row = (uint16_t)(row + 7u)) {
            const uint32_t key = dictionary->rows[row].key;
            (void)eds_client_ask(&rig, 0x40, (uint16_t)(key >> 16), (uint8_t)(key >> 8), 0);
            (void)eds_client_ask(&rig, 0x2F, (uint16_t)(key >> 16), (uint8_t)(key >> 8), seed);
        }
        (void)eds_client_ask(&rig, 0x23, 0x1010, 1, EDS_CLIENT_SAVE);
        eds_client_switch_on(&rig);
        (void)eds_client_ask(&rig, 0x40, 0x1000, 0, 0);
    }
    assert_in_range(started, least, MUTANTS);
}

static void mutants_of_a_sample_of_python(void **state)
{
    (void)state;
    run_mutants(python_sample, MUTANTS * 9u / 10u);
}

static void mutants_of_a_fake_slave_of_ros(void **state)
{
    (void)state;
    run_mutants(ros_slave, MUTANTS * 9u / 10u);
}

static void mutants_of_a_demo_device(void **state)
{
    (void)state;
    run_mutants(node_demo, MUTANTS * 9u / 10u);
}

static void mutants_of_a_slave_of_lely(void **state)
{
    (void)state;
    run_mutants(lely_slave, MUTANTS * 9u / 10u);
}

static void mutants_of_a_slave_of_c_open(void **state)
{
    (void)state;
    run_mutants(open_slave, MUTANTS * 9u / 10u);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sample_of_python),
        cmocka_unit_test(a_fake_slave_of_ros),
        cmocka_unit_test(a_demo_device),
        cmocka_unit_test(a_slave_of_lely),
        cmocka_unit_test(a_slave_of_c_open),
        cmocka_unit_test(mutants_of_a_sample_of_python),
        cmocka_unit_test(mutants_of_a_fake_slave_of_ros),
        cmocka_unit_test(mutants_of_a_demo_device),
        cmocka_unit_test(mutants_of_a_slave_of_lely),
        cmocka_unit_test(mutants_of_a_slave_of_c_open),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
