/* SPDX-License-Identifier: MIT */
/*
 * Requests that are cut, prolonged, damaged, overlong or unknown: the protocol group answers
 * (5.1.3.1, 5.1.3.7, 5.1.3.8), and nothing in the device or its EEPROM changes.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "hf_rig.h"

#define LONGEST 1000u

/* One valid request of every command, the longest one twice. `fill` bytes of data follow. */
static const struct request {
    const char *command;
    uint16_t fill;
} requests[] = {
    {"42", 0},
    {"43 00 00 12 34 55", 0},
    {"44 48", 0},
    {"46", 0},
    {"47", 0},
    {"49 55", 0},
    {"4A 00 00 20 55", 0},
    {"4B 00 10 01 55", 1},
    {"4B 00 00 80 55", 128},
    {"4C 00", 0},
    {"4D 01 C8 55", 0},
    {"4E", 0},
    {"4F 01 55 66", 0},
    {"50", 0},
    {"52", 0},
    {"53", 0},
    {"55 41 55", 0},
    {"56", 0},
    {"57 E5 55", 0},
    {"6A 00 00 12 34 55", 0},
};
#define REQUESTS DG_COUNT(requests)

/* Commands and the lengths of their data, from the tables in 5.1.2. */
static const struct {
    uint8_t code;
    uint8_t min;
    uint8_t max;
} manual[] = {
    {0x42, 0, 0}, {0x43, 5, 5}, {0x44, 1, 1},   {0x46, 0, 0}, {0x47, 0, 0},
    {0x49, 1, 1}, {0x4A, 4, 4}, {0x4B, 5, 132}, {0x4C, 1, 1}, {0x4D, 3, 3},
    {0x4E, 0, 0}, {0x4F, 3, 3}, {0x50, 0, 0},   {0x52, 0, 0}, {0x53, 0, 0},
    {0x55, 2, 2}, {0x56, 0, 0}, {0x57, 2, 2},   {0x6A, 5, 5},
};

static struct hf_rig rig;
static struct hf_rig calm;
static struct dg_hf untouched;

static size_t frame_of(const struct request *request, uint8_t *frame)
{
    frame[0] = DG_HF_ADDRESS_DEFAULT;
    size_t n = 1 + hf_rig_hex(request->command, &frame[1], DG_HF_FRAME_MAX);

    for (uint16_t i = 0; i < request->fill; i++) {
        frame[n++] = (uint8_t)(0x31u * i + 7u);
    }
    frame[n] = hf_rig_xor(frame, n);
    return n + 1;
}

/* The device without what every frame leaves behind. */
static void strip(struct dg_hf *device)
{
    memset(&device->counters, 0, sizeof device->counters);
    memset(device->frame, 0, sizeof device->frame);
    device->length = 0;
    device->sum = 0;
    device->verdict = 0;
    device->command = 0;
    device->frame_damaged = false;
    device->deadline = 0;
    device->last_rx = 0;
}

/* Send; expect the error response `status`, or silence, and nothing changed. */
static void assert_refused(const uint8_t *frame, size_t n, int status)
{
    const uint32_t writes = rig.nvm.writes;
    struct dg_hf device;
    const size_t length = hf_rig_send(&rig, frame, n);

    if (status == HF_RIG_SILENCE) {
        assert_int_equal(length, 0);
    } else {
        const uint8_t expected[] = {DG_HF_ADDRESS_DEFAULT, 0x50, (uint8_t)status,
                                    (uint8_t)(DG_HF_ADDRESS_DEFAULT ^ 0x50u ^ (uint8_t)status)};
        assert_int_equal(length, sizeof expected);
        assert_memory_equal(rig.reply, expected, sizeof expected);
    }
    memcpy(&device, &rig.device, sizeof device);
    strip(&device);
    assert_memory_equal(&device, &untouched, sizeof device);
    assert_int_equal(rig.nvm.writes, writes);
}

static int set_up(void **state)
{
    (void)state;
    rig = calm;
    memcpy(&untouched, &rig.device, sizeof untouched);
    strip(&untouched);
    return 0;
}

static void assert_nothing_stored(void)
{
    assert_memory_equal(rig.nvm.bytes, calm.nvm.bytes, sizeof rig.nvm.bytes);
    assert_int_equal(hf_rig_ask(&rig, "50"), 0);
    assert_int_equal(rig.reply[2], 0);
}

/* The rows above are what they claim to be: each one is executed. */
static void whole_requests_are_executed(void **state)
{
    (void)state;
    for (size_t i = 0; i < REQUESTS; i++) {
        uint8_t frame[DG_HF_FRAME_MAX];
        const size_t n = frame_of(&requests[i], frame);
        rig = calm;
        const size_t length = hf_rig_send(&rig, frame, n);
        if (frame[1] == 0x53) {
            assert_int_equal(length, 0);
            assert_int_equal(rig.device.counters.frames, calm.device.counters.frames + 1u);
        } else {
            assert_true(length >= 3);
            assert_int_equal(rig.reply[1], frame[1]);
        }
    }
}

static void cut_requests_change_nothing(void **state)
{
    (void)state;
    for (size_t i = 0; i < REQUESTS; i++) {
        uint8_t frame[DG_HF_FRAME_MAX];
        const size_t n = frame_of(&requests[i], frame);
        for (size_t cut = 0; cut < n; cut++) {
            const int wrong = hf_rig_xor(frame, cut) != 0 ? DG_HF_CHECKSUM : DG_HF_LENGTH;
            assert_refused(frame, cut, cut == 0 ? HF_RIG_SILENCE : wrong);
        }
    }
    assert_nothing_stored();
}

static void a_byte_more_changes_nothing(void **state)
{
    (void)state;
    for (size_t i = 0; i < REQUESTS; i++) {
        uint8_t frame[DG_HF_FRAME_MAX + 1u];
        const size_t n = frame_of(&requests[i], frame);
        for (unsigned byte = 0; byte <= 0xFF; byte++) {
            /* Behind the check sum: 00h keeps it right. Beyond 135 bytes nobody looks (R14). */
            frame[n] = (uint8_t)byte;
            const bool length = byte == 0 || n == DG_HF_FRAME_MAX;
            assert_refused(frame, n + 1, length ? DG_HF_LENGTH : DG_HF_CHECKSUM);
            /* Before it. */
            const uint8_t sum = frame[n - 1];
            frame[n - 1] = (uint8_t)byte;
            frame[n] = (uint8_t)(sum ^ byte);
            assert_refused(frame, n + 1, DG_HF_LENGTH);
            frame[n - 1] = sum;
        }
    }
    assert_nothing_stored();
}

/* Any byte that is not what was meant; the address decides who is meant at all. */
static void a_damaged_byte_changes_nothing(void **state)
{
    (void)state;
    for (size_t i = 0; i < REQUESTS; i++) {
        uint8_t frame[DG_HF_FRAME_MAX];
        const size_t n = frame_of(&requests[i], frame);
        for (size_t at = 0; at < n; at++) {
            for (unsigned damage = 1; damage <= 0xFF; damage++) {
                const uint8_t right = frame[at];
                frame[at] = (uint8_t)(right ^ damage);
                const bool foreign = at == 0 && frame[0] != DG_HF_ADDRESS_BROADCAST;
                assert_refused(frame, n, foreign ? HF_RIG_SILENCE : DG_HF_CHECKSUM);
                frame[at] = right;
            }
        }
    }
    assert_nothing_stored();
}

/* R13: parity or framing error; the first byte is the address. */
static void a_flagged_character_changes_nothing(void **state)
{
    (void)state;
    for (size_t i = 0; i < REQUESTS; i++) {
        uint8_t frame[DG_HF_FRAME_MAX];
        const size_t n = frame_of(&requests[i], frame);
        for (size_t at = 0; at < n; at++) {
            const unsigned before = rig.replies;
            for (size_t k = 0; k < n; k++) {
                rig.now += DG_MS(1);
                (void)dg_hf_rx(&rig.device, rig.now, frame[k],
                               k == at ? DG_HF_RX_DAMAGED : DG_HF_RX_OK);
            }
            hf_rig_run(&rig);
            assert_int_equal(rig.replies - before, at == 0 ? 0 : 1);
            assert_true(at == 0 || (rig.reply[1] == 0x50 && rig.reply[2] == DG_HF_CHECKSUM));
        }
    }
    assert_nothing_stored();
}

/* R14 */
static void overlong_frames_change_nothing(void **state)
{
    static uint8_t frame[LONGEST];

    (void)state;
    for (size_t n = DG_HF_FRAME_MAX + 1u; n <= LONGEST; n++) {
        memset(frame, 0x4B, sizeof frame);
        frame[0] = DG_HF_ADDRESS_DEFAULT;
        frame[n - 1] = hf_rig_xor(frame, n - 1);
        assert_refused(frame, n, DG_HF_LENGTH);
        frame[n - 1] ^= 1u;
        assert_refused(frame, n, DG_HF_LENGTH);
    }
    /* One for somebody else is nobody's business, however long. */
    frame[0] = DG_HF_ADDRESS_DEFAULT + 1u;
    assert_refused(frame, LONGEST, HF_RIG_SILENCE);
    assert_nothing_stored();
    assert_int_equal(hf_rig_ask(&rig, "42"), 0);
}

/* An address and its check sum: nothing that could be a command (5.1.3.8). */
static void an_address_alone_is_too_short(void **state)
{
    static const uint8_t own[] = {DG_HF_ADDRESS_DEFAULT, DG_HF_ADDRESS_DEFAULT};
    static const uint8_t all[] = {DG_HF_ADDRESS_BROADCAST, DG_HF_ADDRESS_BROADCAST};

    (void)state;
    assert_refused(own, sizeof own, DG_HF_LENGTH);
    assert_refused(all, sizeof all, DG_HF_LENGTH);
    assert_refused(all, 1, DG_HF_CHECKSUM);
}

/* What 5.1.2 has to say about a command and a number of data bytes; 0: it is analysed further. */
static int manual_says(uint8_t code, size_t n)
{
    for (size_t i = 0; i < DG_COUNT(manual); i++) {
        if (manual[i].code == code) {
            return n < manual[i].min || n > manual[i].max ? DG_HF_LENGTH : 0;
        }
    }
    return DG_HF_COMMAND;
}

static void every_code_with_every_length(void **state)
{
    uint8_t frame[DG_HF_FRAME_MAX] = {DG_HF_ADDRESS_DEFAULT};

    (void)state;
    for (unsigned code = 0; code <= 0xFF; code++) {
        for (size_t n = 0; n <= DG_HF_FRAME_MAX - 3u; n++) {
            const int expected = manual_says((uint8_t)code, n);
            frame[1] = (uint8_t)code;
            memset(&frame[2], 0, n + 1);
            frame[4] = code == 0x4B && n > 4 ? (uint8_t)(n - 4) : 0;
            frame[n + 2] = 0;
            frame[n + 2] = hf_rig_xor(frame, n + 2);
            if (expected != 0) {
                assert_refused(frame, n + 3, expected);
                continue;
            }
            const size_t length = hf_rig_send(&rig, frame, n + 3);
            const bool error = rig.reply[1] == 0x50 && code != 0x50;
            assert_true(length >= 3 || code == 0x53);
            /* Data of zeros have a wrong access code, or are fine. */
            assert_true(code == 0x53 || !error || rig.reply[2] == DG_HF_ACCESS_CODE ||
                        (code == 0x44 && rig.reply[2] == DG_HF_ARGUMENT));
            (void)set_up(state);
        }
    }
}

/* 4Bh announces a number of bytes: it has to be the frame's (5.1.2.8). */
static void save_data_announces_its_length(void **state)
{
    uint8_t frame[DG_HF_FRAME_MAX];

    (void)state;
    for (unsigned announced = 0; announced <= 0xFF; announced++) {
        for (size_t data = 1; data <= 128; data++) {
            frame[0] = DG_HF_ADDRESS_DEFAULT;
            frame[1] = 0x4B;
            memset(&frame[2], 0, data + 4);
            frame[4] = (uint8_t)announced;
            frame[data + 6] = hf_rig_xor(frame, data + 6);
            /* A wrong access code shows that the length was accepted. */
            assert_refused(frame, data + 7, announced == data ? DG_HF_ACCESS_CODE : DG_HF_LENGTH);
        }
    }
    assert_nothing_stored();
}

/* A device with one data field of 128 bytes behind Code 0, after its start-up window. */
static int prepare(void **state)
{
    (void)state;
    if (hf_rig_init(&rig, dg_hf_model_of(dg_device_find("s3684-rs485"))) != DG_OK ||
        hf_rig_power_on(&rig) != DG_OK) {
        return -1;
    }
    const int status = hf_rig_ask(&rig, "4D 00 CF 55");
    calm = rig;
    return status;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(whole_requests_are_executed, set_up),
        cmocka_unit_test_setup(cut_requests_change_nothing, set_up),
        cmocka_unit_test_setup(a_byte_more_changes_nothing, set_up),
        cmocka_unit_test_setup(a_damaged_byte_changes_nothing, set_up),
        cmocka_unit_test_setup(a_flagged_character_changes_nothing, set_up),
        cmocka_unit_test_setup(overlong_frames_change_nothing, set_up),
        cmocka_unit_test_setup(an_address_alone_is_too_short, set_up),
        cmocka_unit_test_setup(every_code_with_every_length, set_up),
        cmocka_unit_test_setup(save_data_announces_its_length, set_up),
    };
    return cmocka_run_group_tests(tests, prepare, NULL);
}
