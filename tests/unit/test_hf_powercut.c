/* SPDX-License-Identifier: MIT */
/*
 * The power fails in every write of every command that stores something: afterwards the device
 * shows, over the wire, the old or the new state as a whole, and the new one once it has replied.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "effort.h"
#include "hf_rig.h"

/* A command that stores. `fill` bytes of data follow. */
struct command {
    const char *request;
    uint16_t fill;
};

/* clang-format off */
static struct command commands[] = {
    {"43 01 23 45 67 55",   0},
    {"6A 01 23 45 67 55",   0},
    {"47",                  0},
    {"49 55",               0},
    {"4B 00 03 05 55",      5},
    {"4B 01 00 80 66",    128},
    {"4D 04 C8 55",         0}, /* create, 16 bytes */
    {"4D 04 CF 55",         0}, /* create, 128 bytes */
    {"4D 03 FC 88",         0}, /* enlarge by 16 bytes */
    {"4D 03 FF 88",         0}, /* enlarge by 64 bytes */
    {"4D 01 9F 66",         0}, /* write-protect */
    {"4D 03 CB 88",         0}, /* bind to Code 0 */
    {"4D 03 7B 88",         0}, /* erase */
    {"4F 00 55 99",         0},
    {"4F 03 88 99",         0},
    {"55 47 55",            0},
    {"57 BD 55",            0},
};
/* clang-format on */
#define COMMANDS DG_COUNT(commands)

/* Everything a master can find out. */
struct sight {
    size_t n;
    uint8_t bytes[4096];
};

static struct hf_rig rig;
static struct hf_rig lived_in;
static struct hf_rig powerless;
static struct sight before;
static struct sight after;
static struct sight seen;

static void note(struct sight *sight, const uint8_t *bytes, size_t n)
{
    assert_true(n <= sizeof sight->bytes - sight->n);
    memcpy(&sight->bytes[sight->n], bytes, n);
    sight->n += n;
}

/* Ask by broadcast, which also shows the address, and note the reply. */
static void look_at_encoder(struct sight *sight, const uint8_t *command, size_t n)
{
    uint8_t frame[16] = {DG_HF_ADDRESS_BROADCAST};

    memcpy(&frame[1], command, n);
    frame[n + 1u] = hf_rig_xor(frame, n + 1u);
    assert_true(hf_rig_send(&rig, frame, n + 2u) > 0);
    note(sight, rig.reply, rig.reply_length);
}

/* Status of a field, and what each access code opens that is or may become its own. */
static void look_at_field(struct sight *sight, uint8_t number)
{
    const uint8_t codes[] = {0x55, 0x99, (uint8_t)(0x55u + 0x11u * number)};
    const uint8_t status[] = {0x4C, number};

    look_at_encoder(sight, status, sizeof status);
    uint8_t size = (uint8_t)(((rig.reply[3] & 7u) + 1u) * 16u);
    for (size_t i = 0; i < sizeof codes; i++) {
        const uint8_t read[] = {0x4A, number, 0, size, codes[i]};
        look_at_encoder(sight, read, sizeof read);
    }
}

static void look_at_everything(struct sight *sight)
{
    static const uint8_t plain[] = {0x50, 0x42, 0x46, 0x52, 0x56, 0x4E};
    static const uint8_t label[] = {0x4A, 0xFF, 0, 64, 0};
    const struct dg_hf_uart uart = dg_hf_uart(&rig.device);

    sight->n = 0;
    note(sight,
         (const uint8_t[]){(uint8_t)(uart.baud / 600u), (uint8_t)uart.parity, uart.timeout_bits},
         3);
    look_at_encoder(sight, label, sizeof label);
    for (size_t i = 0; i < sizeof plain; i++) {
        look_at_encoder(sight, &plain[i], 1);
    }
    uint8_t fields = rig.reply[3];
    for (uint8_t number = 0; number < fields; number++) {
        look_at_field(sight, number);
    }
}

static bool same(const struct sight *a, const struct sight *b)
{
    return a->n == b->n && memcmp(a->bytes, b->bytes, a->n) == 0;
}

static int send_command(const struct command *command)
{
    uint8_t bytes[DG_HF_FRAME_MAX];
    size_t n = hf_rig_hex(command->request, bytes, sizeof bytes);

    for (uint16_t i = 0; i < command->fill; i++) {
        bytes[n++] = (uint8_t)(0xA0u + i);
    }
    return hf_rig_ask_bytes(&rig, bytes, n);
}

/* Start from the power failure in `powerless`; with `cut`, fail again in that write of the start.
 * Returns whether there was such a write. */
static bool start_again(int64_t cut, enum ram_nvm_tear tear, uint32_t tear_at)
{
    bool failed = false;

    rig = powerless;
    ram_nvm_restore(&rig.nvm);
    if (cut >= 0) {
        ram_nvm_cut(&rig.nvm, (uint32_t)cut, tear, tear_at);
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        failed = rig.nvm.dead;
        ram_nvm_restore(&rig.nvm);
    }
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    return failed;
}

/* A second power failure, in every write of the start after the first one, changes nothing. */
static void assert_survives_start(const struct sight *expected)
{
    static const uint32_t tears[] = {0, 1, 7};
    bool failed = true;

    for (int64_t cut = 0; failed; cut++) {
        failed = false;
        for (int tear = 0; tear < RAM_NVM_TEAR_COUNT; tear++) {
            for (size_t i = 0; i < DG_COUNT(tears); i++) {
                if (start_again(cut, (enum ram_nvm_tear)tear, tears[i])) {
                    failed = true;
                    look_at_everything(&seen);
                    assert_true(same(&seen, expected));
                }
            }
        }
    }
}

/* What was not stored can be stored now. */
static void assert_works_again(const struct command *command)
{
    assert_int_equal(send_command(command), 0);
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    look_at_everything(&seen);
    assert_true(same(&seen, &after));
}

/* The power fails in write `cut` of the command, or right after its reply. */
static void assert_old_or_new(const struct command *command, uint32_t writes, uint32_t cut,
                              enum ram_nvm_tear tear, uint32_t tear_at)
{
    rig = lived_in;
    ram_nvm_cut(&rig.nvm, cut, tear, tear_at);
    int status = send_command(command);
    if (cut == writes) {
        const struct dg_nvm nvm = ram_nvm_port(&rig.nvm);
        assert_int_equal(nvm.ops->write(nvm.ctx, 0, "", 0), DG_ERR_IO);
    }
    assert_true(rig.nvm.dead);
    assert_int_equal(status, cut == writes ? 0 : DG_HF_I2C);

    powerless = rig;
    (void)start_again(-1, tear, tear_at);
    look_at_everything(&seen);
    const struct sight *expected = same(&seen, &after) ? &after : &before;
    assert_true(same(&seen, expected));
    assert_true(status != 0 || expected == &after);
    if (expected == &before) {
        assert_works_again(command);
    }
    /* Not in every byte of a torn write: the start only sees whether the journal is whole. */
    if (tear_at % 32u <= effort(0, 1)) {
        assert_survives_start(expected);
    }
}

/* Nothing, a byte, more, and all of the write get through. */
static uint32_t next_tear(uint32_t tear_at, uint32_t size)
{
    const uint32_t next = tear_at == 0 ? 1 : tear_at + effort(5, 1);
    return next > size && tear_at < size ? size : next;
}

static void is_stored_whole_or_not_at_all(void **state)
{
    const struct command *command = *state;

    rig = lived_in;
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    look_at_everything(&before);
    rig = lived_in;
    rig.write_count = 0;
    assert_int_equal(send_command(command), 0);
    const uint32_t writes = rig.write_count;
    assert_in_range(writes, 1, HF_RIG_WRITES_MAX);
    uint16_t sizes[HF_RIG_WRITES_MAX + 1] = {0};
    memcpy(sizes, rig.write_size, sizeof rig.write_size);
    sizes[writes] = 0;
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    look_at_everything(&after);
    assert_false(same(&before, &after));

    for (uint32_t cut = 0; cut <= writes; cut++) {
        assert_old_or_new(command, writes, cut, RAM_NVM_UNSYNCED, 0);
        for (uint32_t tear_at = 0; tear_at <= sizes[cut];
             tear_at = next_tear(tear_at, sizes[cut])) {
            assert_old_or_new(command, writes, cut, RAM_NVM_ORDERED, tear_at);
            assert_old_or_new(command, writes, cut, RAM_NVM_REORDERED, tear_at);
            assert_old_or_new(command, writes, cut, RAM_NVM_GARBLED, tear_at);
        }
    }
}

/* A device with a history: four fields, each behind another code, and nothing as delivered. */
static int live(void **state)
{
    static const struct command history[] = {
        {"43 00 12 34 55 55", 0}, {"4D 00 C8 55", 0}, {"4D 01 DF 55", 0},    {"4D 02 EA 55", 0},
        {"4D 03 FB 55", 0},       {"4F 01 55 66", 0}, {"4F 02 55 77", 0},    {"4F 03 55 88", 0},
        {"4B 01 00 10 66", 16},   {"55 42 55", 0},    {"4B 03 0A 20 88", 32}};

    (void)state;
    if (hf_rig_init(&rig, dg_hf_model_of(dg_device_find("s3684-rs485"))) != DG_OK ||
        hf_rig_power_on(&rig) != DG_OK) {
        return -1;
    }
    for (size_t i = 0; i < DG_COUNT(history); i++) {
        if (send_command(&history[i]) != 0) {
            return -1;
        }
    }
    for (int i = 0; i < 0xFF; i++) {
        (void)hf_rig_ask(&rig, "47");
    }
    lived_in = rig;
    return 0;
}

int main(void)
{
    struct CMUnitTest tests[COMMANDS];

    for (size_t i = 0; i < COMMANDS; i++) {
        tests[i] = (struct CMUnitTest){.name = commands[i].request,
                                       .test_func = is_stored_whole_or_not_at_all,
                                       .initial_state = &commands[i]};
    }
    return cmocka_run_group_tests_name("power cut in", tests, live, NULL);
}
