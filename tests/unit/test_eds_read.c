/* SPDX-License-Identifier: MIT */
/*
 * Encoders from EDS files: a made-up one of another maker, the F3668's own, and what readers of the
 * field tolerate. Masters are SDO clients on a handle.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "drehgeber/cia406.h"
#include "drehgeber/host_wire.h"

#define MEMORY 65536u
#define HANDLE 32768u
#define NODE_ID 7u
#define SAVE 0x65766173u
#define LOAD 0x64616F6Cu
#define NOTES 64u

/* 14 bits a turn, 14 bits of turns. */
static const char acme[] =
    "[FileInfo]\r\nFileName=ac1414.eds\r\nFileVersion=-\r\n\r\n"
    "[DeviceInfo]\r\nVendorName=Acme\r\nVendorNumber=0x1234\r\nProductName=AC 1414\r\n"
    "ProductNumber=0x1414\r\nRevisionNumber=001\r\nBaudRate_125=1\r\nBaudRate_250=0\r\n"
    "BaudRate_500=1\r\n\r\n"
    "[1000]\r\nParameterName=Device type\r\nObjectType=0x7\r\nDataType=0x0007\r\nAccessType=ro\r\n"
    "DefaultValue=0x00020196\r\n"
    "[1001]\nDataType=5\nAccessType=ro\nPDOMapping=1\n"
    "[1005]\nDataType=7\nAccessType=rw\nDefaultValue=0x80\n"
    "[1008]\nDataType=9\nAccessType=const\nDefaultValue=AC1414\n"
    "[1010]\nObjectType=8\nSubNumber=2\n[1010sub0]\nDataType=5\nAccessType=ro\nDefaultValue=1\n"
    "[1010sub1]\nDataType=7\nAccessType=rw\nDefaultValue=1\n"
    "[1014]\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+0x80\n"
    "[1017]\nDataType=6\nAccessType=rw ; in ms\nDefaultValue=0x64 # 100 ms\n"
    "[1018]\nObjectType=9\n[1018sub0]\nDataType=5\nAccessType=ro\nDefaultValue=4\n"
    "[1018sub1]\nDataType=7\nAccessType=ro\nDefaultValue=0x1234\n"
    "[1018sub2]\nDataType=7\nAccessType=ro\nDefaultValue=0x1414\n"
    "[1018sub3]\nDataType=7\nAccessType=ro\nDefaultValue=1\n"
    "[1018sub4]\nDataType=7\nAccessType=ro\nDefaultValue=0x12345678\n"
    "[1200]\nObjectType=9\n[1200sub1]\nDataType=7\nAccessType=ro\nDefaultValue=0x600 + $NODEID\n"
    "[1800]\nObjectType=9\n[1800sub0]\nDataType=5\nAccessType=ro\nDefaultValue=5\n"
    "[1800sub1]\nDataType=7\nAccessType=rw\nDefaultValue=$nodeid + 0x180\n"
    "[1800Sub2]\nDataType=5\nAccessType=RW\nDefaultValue=1\n"
    "[1800sub5]\nDataType=6\nAccessType=rw\nDefaultValue=0\n"
    "[1801]\nObjectType=9\n[1801sub1]\nDataType=7\nAccessType=rw\n"
    "DefaultValue=$NODEID+0x80000280\n"
    "[1a00]\nObjectType=9\n[1a00sub0]\nDataType=5\nAccessType=rw\nDefaultValue=2\n"
    "[1a00sub1]\nDataType=7\nAccessType=rw\nDefaultValue=0x60040020\n"
    "[1a00sub2]\nDataType=7\nAccessType=rw\nDefaultValue=0x20010010\n"
    "[2000]\nDataType=5\nAccessType=rw\nDefaultValue=3\nLowLimit=1\nHighLimit=8\n"
    "[2001]\nDataType=6\nAccessType=rwr\nPDOMapping=1\nDefaultValue=0x1234\n"
    "[2002]\nDataType=3\nAccessType=rw\nDefaultValue=0xFFFE\nLowLimit=-5\nHighLimit=0x7FFF\n"
    "[2010]\nObjectType=8\nDataType=6\nAccessType=rw\nDefaultValue=7\nCompactSubObj=4\n"
    "[2010Value]\nNrOfEntries=1\n2=9\n"
    "[2020]\nDataType=0x20\nAccessType=rw\n"
    "[2021]\nDataType=0x0F\nAccessType=ro\nDefaultValue=domain\n"
    "[6000]\nDataType=6\nAccessType=rw\nDefaultValue=4\n"
    "[6001]\nDataType=7\nAccessType=rw\nDefaultValue=16384\nLowLimit=1\nHighLimit=16384\n"
    "[6002]\nDataType=7\nAccessType=rw\nDefaultValue=268435456\n"
    "[6003]\nDataType=7\nAccessType=rw\nDefaultValue=0\n"
    "[6004]\nDataType=7\nAccessType=ro\nPDOMapping=1\n"
    "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=16384\n"
    "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=16384\n";

/* ------------------------------------------------------------ the rig */

static struct {
    struct dg_cia406_file file;
    struct dg_eds_note error;
    struct dg_eds_note notes[NOTES];
    size_t note_count;
    _Alignas(max_align_t) uint8_t memory[8u * MEMORY];
    struct dg_host *host;
    _Alignas(DG_HOST_ALIGN) uint8_t handle[HANDLE];
    uint8_t node;
    uint64_t now;
} rig;

static void keep_note(void *ctx, const struct dg_eds_note *note)
{
    assert_ptr_equal(ctx, &rig);
    assert_non_null(note->what);
    if (rig.note_count < NOTES) {
        rig.notes[rig.note_count] = *note;
    }
    rig.note_count++;
}

static int read_in(const char *text, size_t n, size_t memory_size)
{
    const struct dg_eds_setup setup = {
        .size = sizeof setup,
        .text = text,
        .n = n,
        .memory = rig.memory,
        .memory_size = memory_size,
        .note = keep_note,
        .ctx = &rig,
    };

    rig.note_count = 0;
    rig.error = (struct dg_eds_note){.line = 0};
    return dg_cia406_read(&rig.file, &setup, &rig.error);
}

static void read_text(const char *text)
{
    assert_int_equal(read_in(text, strlen(text), sizeof rig.memory), DG_OK);
}

static bool is_noted(const char *section, const char *what)
{
    for (size_t i = 0; i < rig.note_count && i < NOTES; i++) {
        if (strcmp(rig.notes[i].section, section) == 0 && strstr(rig.notes[i].what, what) != NULL) {
            return true;
        }
    }
    return false;
}

static struct dg_host *make_host(uint8_t *memory, const struct dg_device *device)
{
    const struct dg_host_wire *wire = dg_host_wire_of(&dg_f3668);
    const size_t size = dg_host_size(device, wire);
    char text[8];

    assert_true(size > 0 && size <= HANDLE);
    struct dg_host *host = dg_host_init(memory, size, device, wire);
    assert_non_null(host);
    (void)snprintf(text, sizeof text, "%u", rig.node);
    assert_int_equal(dg_host_set(host, "node", text), DG_HOST_OK);
    return host;
}

static void start_encoder(const struct dg_device *device)
{
    rig.node = NODE_ID;
    rig.now = DG_S(1);
    rig.host = make_host(rig.handle, device);
    assert_int_equal(dg_host_power(rig.host, rig.now, true), DG_HOST_OK);
}

static void drain(void)
{
    struct dg_host_event event;

    while (dg_host_receive(rig.host, &event) != 0) {
    }
}

static void send_frame(uint32_t id, const uint8_t *data, uint8_t n)
{
    struct dg_host_event event = {.at = rig.now, .id = id, .kind = DG_HOST_CAN, .length = n};

    memcpy(event.data, data, n);
    assert_int_equal(dg_host_send(rig.host, &event), DG_HOST_OK);
    (void)dg_host_step(rig.host, rig.now);
}

/* @return false: nothing with this identifier */
static bool fetch_frame(uint32_t id, struct dg_host_event *to)
{
    while (dg_host_receive(rig.host, to) > 0) {
        if (to->id == id) {
            return true;
        }
    }
    return false;
}

/* "save" is answered later. */
static struct dg_host_event ask(uint8_t command, uint16_t index, uint8_t sub, uint32_t value)
{
    struct dg_host_event answer;
    uint8_t data[8] = {command};

    dg_store_le16(&data[1], index);
    data[3] = sub;
    dg_store_le32(&data[4], value);
    drain();
    send_frame(0x600u + rig.node, data, sizeof data);
    if (!fetch_frame(0x580u + rig.node, &answer)) {
        rig.now += DG_MS(50);
        (void)dg_host_step(rig.host, rig.now);
        assert_true(fetch_frame(0x580u + rig.node, &answer));
    }
    return answer;
}

static uint32_t upload(uint16_t index, uint8_t sub)
{
    const struct dg_host_event answer = ask(0x40, index, sub, 0);

    return dg_load_le32(&answer.data[4]);
}

static uint32_t abort_of(const struct dg_host_event *answer)
{
    return answer->data[0] == 0x80 ? dg_load_le32(&answer->data[4]) : 0;
}

static uint32_t refusal(uint16_t index, uint8_t sub)
{
    const struct dg_host_event answer = ask(0x40, index, sub, 0);

    return abort_of(&answer);
}

static uint32_t download(uint16_t index, uint8_t sub, uint32_t value, uint8_t n)
{
    const struct dg_host_event answer = ask((uint8_t)(0x23u + 4u * (4u - n)), index, sub, value);

    return abort_of(&answer);
}

static void turn_to(double turns)
{
    dg_host_shaft(rig.host, rig.now, (int64_t)(turns * 4294967296.0), 0);
}

static void power_cycle(void)
{
    rig.now += DG_S(1);
    assert_int_equal(dg_host_power(rig.host, rig.now, false), DG_HOST_OK);
    assert_int_equal(dg_host_power(rig.host, rig.now, true), DG_HOST_OK);
    drain();
}

static void start_acme(void)
{
    read_text(acme);
    start_encoder(&rig.file.device);
    turn_to(1.25);
}

/* ------------------------------------------------------------ another maker's encoder */

static void objects_are_those_of_the_file(void **state)
{
    (void)state;
    start_acme();
    assert_string_equal(rig.file.device.name, "ac-1414");
    assert_string_equal(rig.file.device.resolution, "16384 steps, 16384 turns");
    assert_int_equal(upload(0x1000, 0), 0x00020196);
    assert_int_equal(upload(0x1017, 0), 100);
    assert_int_equal(upload(0x1018, 1), 0x1234);
    assert_int_equal(upload(0x1018, 2), 0x1414);
    assert_int_equal(upload(0x1014, 0), 0x80u + NODE_ID);
    assert_int_equal(upload(0x1200, 1), 0x600u + NODE_ID);
    assert_int_equal(upload(0x6501, 0), 16384);
    assert_int_equal(upload(0x1800, 2), 1);
    assert_int_equal(upload(0x1801, 1), 0x80000280u + NODE_ID);
}

static void what_is_not_in_the_file_is_not_there(void **state)
{
    (void)state;
    start_acme();
    assert_int_equal(refusal(0x1006, 0), DG_CO_NO_OBJECT);
    assert_int_equal(refusal(0x1802, 1), DG_CO_NO_OBJECT);
    assert_int_equal(refusal(0x1800, 3), DG_CO_NO_SUB);
    assert_int_equal(refusal(0x6030, 1), DG_CO_NO_OBJECT);
    assert_int_equal(refusal(0x2100, 0), DG_CO_NO_OBJECT);
    assert_int_equal(refusal(0x2020, 0), DG_CO_NO_OBJECT);
    assert_true(is_noted("2020", "has no such type"));
    assert_int_equal(upload(0x1001, 0), 0);
}

static void values_store(void **state)
{
    (void)state;
    start_acme();
    assert_int_equal(upload(0x2000, 0), 3);
    assert_int_equal(download(0x2000, 0, 8, 1), 0);
    assert_int_equal(upload(0x2000, 0), 8);
    assert_int_equal(download(0x2000, 0, 9, 1), DG_CO_RANGE);
    assert_int_equal(download(0x2000, 0, 0, 1), DG_CO_RANGE);
    assert_int_equal(upload(0x2002, 0), 0xFFFE);
    assert_int_equal(download(0x2002, 0, 0xFFFA, 2), DG_CO_RANGE);
    assert_int_equal(download(0x2002, 0, 0xFFFB, 2), 0);
    assert_int_equal(upload(0x2010, 0), 4);
    assert_int_equal(upload(0x2010, 1), 7);
    assert_int_equal(upload(0x2010, 2), 9);
    assert_int_equal(refusal(0x2010, 5), DG_CO_NO_SUB);
    assert_int_equal(download(0x6501, 0, 1, 4), DG_CO_READ_ONLY);
}

static void a_sync_sends_what_the_file_maps(void **state)
{
    const uint8_t go[2] = {1, 0};
    struct dg_host_event event;
    (void)state;
    start_acme();
    send_frame(0, go, 2);
    drain();
    send_frame(0x80, go, 0);
    assert_true(fetch_frame(0x180u + NODE_ID, &event));
    assert_int_equal(event.length, 6);
    assert_int_equal(dg_load_le32(event.data), 20480);
    assert_int_equal(dg_load_le16(&event.data[4]), 0x1234);
}

static void the_position_is_scaled_and_preset(void **state)
{
    (void)state;
    start_acme();
    assert_int_equal(upload(0x6004, 0), 20480);
    assert_int_equal(download(0x6001, 0, 20000, 4), DG_CO_RANGE);
    assert_int_equal(download(0x6001, 0, 1000, 4), 0);
    assert_int_equal(download(0x6002, 0, 4096000, 4), 0);
    assert_int_equal(upload(0x6004, 0), 1250);
    assert_int_equal(download(0x6003, 0, 4096000, 4), DG_CO_RANGE);
    assert_int_equal(download(0x6003, 0, 100, 4), 0);
    assert_int_equal(upload(0x6004, 0), 100);
    turn_to(2.25);
    assert_int_equal(upload(0x6004, 0), 1100);
    assert_int_equal(download(0x6000, 0, 5, 2), 0);
    turn_to(1.25);
    const uint32_t at = upload(0x6004, 0);
    turn_to(2.25);
    assert_int_equal(upload(0x6004, 0), at - 1000u);
}

static void what_was_saved_survives(void **state)
{
    (void)state;
    start_acme();
    assert_int_equal(download(0x2000, 0, 6, 1), 0);
    assert_int_equal(download(0x2010, 4, 77, 2), 0);
    assert_int_equal(download(0x6001, 0, 1000, 4), 0);
    assert_int_equal(download(0x6002, 0, 4096000, 4), 0);
    assert_int_equal(download(0x6003, 0, 0, 4), 0);
    assert_int_equal(download(0x1017, 0, 250, 2), 0);
    power_cycle();
    assert_int_equal(upload(0x2000, 0), 3); /* nobody has saved */
    assert_int_equal(upload(0x1017, 0), 100);
    assert_int_equal(download(0x2000, 0, 6, 1), 0);
    assert_int_equal(download(0x2010, 4, 77, 2), 0);
    assert_int_equal(download(0x6001, 0, 1000, 4), 0);
    assert_int_equal(download(0x6002, 0, 4096000, 4), 0);
    assert_int_equal(download(0x6003, 0, 0, 4), 0);
    assert_int_equal(download(0x1017, 0, 250, 2), 0);
    assert_int_equal(download(0x1010, 1, SAVE, 4), 0);
    power_cycle();
    assert_int_equal(upload(0x2000, 0), 6);
    assert_int_equal(upload(0x2010, 4), 77);
    assert_int_equal(upload(0x6001, 0), 1000);
    assert_int_equal(upload(0x6004, 0), 0);
    assert_int_equal(upload(0x1017, 0), 250);
    assert_int_equal(upload(0x1001, 0), 0);
}

/* What a handle keeps has the values, too, and comes back into another handle of the model. */
static void a_state_has_the_values(void **state)
{
    static uint8_t kept[2u * HANDLE];
    static _Alignas(DG_HOST_ALIGN) uint8_t other[HANDLE];
    (void)state;
    start_acme();
    assert_int_equal(download(0x2000, 0, 6, 1), 0);
    assert_int_equal(dg_host_save(rig.host, kept, sizeof kept), DG_HOST_OK);
    assert_int_equal(upload(0x2000, 0), 6);
    rig.host = make_host(other, &rig.file.device);
    assert_int_equal(dg_host_restore(rig.host, kept, sizeof kept), DG_HOST_OK);
    assert_int_equal(upload(0x2000, 0), 6);
    assert_int_equal(download(0x2000, 0, 9, 1), DG_CO_RANGE);
    turn_to(1.25);
    assert_int_equal(upload(0x6004, 0), 20480);
}

/* 37 turns of 3600 steps: no power of two. */
static void any_number_of_steps_and_turns_will_do(void **state)
{
    static const struct {
        double turns;
        uint32_t position;
    } rows[] = {
        {0.5, 1800}, {36.75, 36u * 3600u + 2700u}, {37.25, 900}, {-0.25, 37u * 3600u - 900u}};
    (void)state;
    read_text("[1000]\nDataType=7\nDefaultValue=0x20196\nAccessType=ro\n"
              "[6004]\nDataType=7\nAccessType=ro\n"
              "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=3600\n"
              "[6502]\nDataType=7\nAccessType=ro\nDefaultValue=37\n");
    start_encoder(&rig.file.device);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        turn_to(rows[i].turns);
        assert_int_equal(upload(0x6004, 0), rows[i].position);
    }
}

static void another_profile_is_values_only(void **state)
{
    (void)state;
    read_text("[1000]\nDataType=7\nDefaultValue=0x192\nAccessType=ro\n"
              "[6004]\nDataType=7\nAccessType=ro\nDefaultValue=5\n"
              "[6040]\nDataType=6\nAccessType=rww\nDefaultValue=0x0F\n");
    assert_true(is_noted("1000", "another profile"));
    start_encoder(&rig.file.device);
    turn_to(1.25);
    assert_int_equal(upload(0x6004, 0), 5);
    assert_int_equal(download(0x6040, 0, 6, 2), 0);
    assert_int_equal(upload(0x6040, 0), 6);
}

/* ------------------------------------------------------------ its own file */

static struct {
    char bytes[MEMORY];
    size_t n;
} own;

static void append(void *ctx, const char *bytes, size_t n)
{
    (void)ctx;
    assert_true(n < sizeof own.bytes - own.n);
    memcpy(own.bytes + own.n, bytes, n);
    own.n += n;
    own.bytes[own.n] = '\0';
}

/* What the file cannot say: bus parameters as delivered are the handle's. */
static void the_f3668_from_its_own_file_is_an_f3668(void **state)
{
    static struct dg_host_event wanted[1024];
    static uint32_t keys[1024];
    size_t count = 0;
    (void)state;
    start_encoder(&dg_f3668);
    turn_to(1.25);
    for (uint32_t index = 0x1000; index < 0x6600; index++) {
        for (uint32_t sub = 0; sub < 9; sub++) {
            const struct dg_host_event answer = ask(0x40, (uint16_t)index, (uint8_t)sub, 0);
            if (abort_of(&answer) == DG_CO_NO_OBJECT) {
                break;
            }
            assert_true(count < DG_COUNT(wanted));
            keys[count] = DG_CO_KEY(index, sub);
            wanted[count++] = answer;
        }
    }
    own.n = 0;
    dg_co_eds(dg_cia406_sheet_of(&dg_f3668), append, NULL);
    read_text(own.bytes);
    assert_int_equal(rig.note_count, 0);
    start_encoder(&rig.file.device);
    turn_to(1.25);
    for (size_t i = 0; i < count; i++) {
        const struct dg_host_event answer =
            ask(0x40, (uint16_t)(keys[i] >> 16), (uint8_t)(keys[i] >> 8), 0);
        if (memcmp(answer.data, wanted[i].data, 8) != 0) {
            print_message("%06X: %08X, not %08X\n", keys[i] >> 8, dg_load_le32(&answer.data[4]),
                          dg_load_le32(&wanted[i].data[4]));
        }
        assert_memory_equal(answer.data, wanted[i].data, 8);
    }
    assert_in_range(count, 165, 1023);
}

/* ------------------------------------------------------------ bad files */

static void a_file_without_objects_is_refused(void **state)
{
    (void)state;
    assert_int_equal(read_in("hello", 5, sizeof rig.memory), DG_ERR_ARGUMENT);
    assert_string_equal(rig.error.what, "no object");
    assert_int_equal(read_in("", 0, sizeof rig.memory), DG_ERR_ARGUMENT);
    assert_int_equal(read_in("[1000]\n", 7, sizeof rig.memory), DG_ERR_ARGUMENT);
    assert_string_equal(rig.error.what, "no object that can be read");
}

static void a_file_that_is_too_long_is_refused(void **state)
{
    static char text[DG_EDS_BYTES_MAX + 1u];
    size_t n = 0;
    (void)state;
    assert_int_equal(read_in(text, sizeof text, sizeof rig.memory), DG_ERR_ARGUMENT);
    assert_string_equal(rig.error.what, "too long");
    for (unsigned i = 0; i <= DG_EDS_OBJECTS_MAX; i++) {
        n += (size_t)sprintf(text + n, "[%04X]\n", 0x2000u + i);
    }
    assert_int_equal(read_in(text, n, sizeof rig.memory), DG_ERR_ARGUMENT);
    assert_string_equal(rig.error.what, "too many objects");
}

static void little_memory_is_said(void **state)
{
    size_t size = 64;
    (void)state;
    while (read_in(acme, strlen(acme), size) == DG_ERR_SPACE) {
        size += 64;
        assert_true(size < sizeof rig.memory);
    }
    start_encoder(&rig.file.device);
    assert_int_equal(upload(0x2000, 0), 3);
}

static void what_is_tolerated_is_noted(void **state)
{
    (void)state;
    read_text("[1000]\nDataType=7\nDefaultValue=0x10196\nAccessType=ro\njunk\n"
              "[2000]\nDataType=6\nDefaultValue=No\nAccessType=rw\n"
              "[2001]\nDataType=5\nDefaultValue=9\nHighLimit=8\nAccessType=rw\n"
              "[2002]\nDataType=5\nAccessType=sometimes\n"
              "[2003]\nDataType=0x1C\nAccessType=ro\nDefaultValue=1\n"
              "[2000]\nDataType=6\nAccessType=ro\n"
              "[OptionalObjects]\nSupportedObjects=1\n1=0x2000\n");
    assert_true(is_noted("1000", "is left out"));
    assert_true(is_noted("2000", "is no number of its type"));
    assert_true(is_noted("2000", "twice"));
    assert_true(is_noted("2001", "outside of its limits"));
    assert_true(is_noted("2002", "no access"));
    assert_true(is_noted("2003", "has no such type"));
    assert_true(is_noted("", "lists name other objects"));
    assert_true(is_noted("6501", "without a default"));
    start_encoder(&rig.file.device);
    assert_int_equal(upload(0x2001, 0), 9);
}

/* A DCF has a node-ID, a bit rate and values of its own. */
static void a_dcf_is_configured(void **state)
{
    (void)state;
    read_text("[DeviceInfo]\nBaudRate_125=1\nBaudRate_500=1\n"
              "[DeviceComissioning]\nNodeID=0x22\nBaudrate=500\n"
              "[1000]\nDataType=7\nDefaultValue=0x10196\nAccessType=ro\n"
              "[1017]\nDataType=6\nParameterValue=300\nDefaultValue=0\nAccessType=rw\n");
    assert_int_equal(rig.file.file.node_id, 0x22);
    start_encoder(&rig.file.device);
    assert_int_equal(dg_host_bit_rate(rig.host), 500);
    assert_int_equal(upload(0x1017, 0), 300);
}

/* As many encoders have it; what is behind the range is still refused. */
static void a_preset_may_have_a_sign(void **state)
{
    (void)state;
    read_text("[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
              "[6002]\nDataType=4\nAccessType=rw\nDefaultValue=1000\n"
              "[6003]\nDataType=4\nAccessType=rw\nDefaultValue=0\n"
              "[6004]\nDataType=4\nAccessType=ro\n"
              "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=4096\n"
              "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=4096\n");
    assert_int_equal(rig.note_count, 0);
    start_encoder(&rig.file.device);
    assert_int_equal(download(0x6003, 0, 700, 4), 0);
    assert_int_equal(upload(0x6003, 0), 700);
    assert_int_equal(upload(0x6004, 0), 700);
    assert_int_equal(download(0x6002, 0, 5000, 4), 0);
    assert_int_equal(download(0x6003, 0, UINT32_MAX, 4), 0x06090030);
}

/* The layout of a file with a value [2000] of this kind, in a device of this type. */
static uint32_t layout_of(const char *type, const char *value)
{
    char text[512];
    const int n = snprintf(text, sizeof text,
                           "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=%s\n"
                           "[2000]\nAccessType=rw\nDefaultValue=5\n%s",
                           type, value);
    assert_int_equal(read_in(text, (size_t)n, sizeof rig.memory), DG_OK);
    return rig.file.file.layout.id;
}

/* Its image may have values that this one does not take. */
static void the_memory_of_another_file_is_foreign(void **state)
{
    (void)state;
    const uint32_t wide = layout_of("0x20196", "DataType=7\n");
    assert_int_equal(layout_of("0x20196", "DataType=7\nDefaultValue=6\n"), wide);
    assert_int_not_equal(layout_of("0x20196", "DataType=5\n"), wide);
    assert_int_not_equal(layout_of("0x20196", "DataType=4\n"), wide);
    assert_int_not_equal(layout_of("0x20196", "DataType=7\nHighLimit=10\n"), wide);
    assert_int_not_equal(layout_of("0x10196", "DataType=7\n"), wide);
}

/* Whatever is in it: what can be read starts and answers. */
static void damaged_files_do_no_harm(void **state)
{
    static char text[sizeof acme];
    uint32_t seed = 1;
    unsigned started = 0;
    (void)state;
    for (unsigned i = 0; i < 500; i++) {
        memcpy(text, acme, sizeof acme);
        for (unsigned n = 0; n <= i % 8u; n++) {
            seed = seed * 1664525u + 1013904223u;
            text[(seed >> 8) % (sizeof acme - 1u)] = (char)(seed >> 24);
        }
        seed = seed * 1664525u + 1013904223u;
        const size_t n = i % 5u == 0 ? (seed >> 8) % sizeof acme : sizeof acme - 1u;
        if (read_in(text, n, sizeof rig.memory) != DG_OK) {
            assert_string_not_equal(rig.error.what, "");
            continue;
        }
        started++;
        start_encoder(&rig.file.device);
        (void)refusal(0x1000, 0);
        (void)refusal(0x6004, 0);
        (void)download(0x2000, 0, 5, 1);
        (void)download(0x1010, 1, SAVE, 4);
        power_cycle();
    }
    assert_true(started > 400);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(objects_are_those_of_the_file),
        cmocka_unit_test(what_is_not_in_the_file_is_not_there),
        cmocka_unit_test(values_store),
        cmocka_unit_test(a_sync_sends_what_the_file_maps),
        cmocka_unit_test(the_position_is_scaled_and_preset),
        cmocka_unit_test(what_was_saved_survives),
        cmocka_unit_test(a_state_has_the_values),
        cmocka_unit_test(any_number_of_steps_and_turns_will_do),
        cmocka_unit_test(another_profile_is_values_only),
        cmocka_unit_test(the_f3668_from_its_own_file_is_an_f3668),
        cmocka_unit_test(a_file_without_objects_is_refused),
        cmocka_unit_test(a_file_that_is_too_long_is_refused),
        cmocka_unit_test(little_memory_is_said),
        cmocka_unit_test(what_is_tolerated_is_noted),
        cmocka_unit_test(a_dcf_is_configured),
        cmocka_unit_test(a_preset_may_have_a_sign),
        cmocka_unit_test(the_memory_of_another_file_is_foreign),
        cmocka_unit_test(damaged_files_do_no_harm),
    };
    return cmocka_run_group_tests_name("eds_read", tests, NULL, NULL);
}
