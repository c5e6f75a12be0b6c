/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: an EDS file. The input is the file. One that is refused says why; one that is read
 * is an encoder, each of whose objects is read, written, mapped and saved, and comes back at
 * power-on.
 */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "drehgeber/cia406.h"
#include "fuzz_input.h"
#include "ram_nvm.h"

#define NODE_ID 5u
#define CELLS_MAX 32768u
#define SAVE 0x65766173u
#define WRITE 0x22u /* without a size: as many bytes as the object has */

static struct {
    struct dg_cia406_file file;
    _Alignas(max_align_t) uint8_t memory[1u << 20];
    struct {
        struct dg_cia406_device device;
        uint32_t cells[CELLS_MAX];
    } encoder;
    struct dg_world world;
    struct ram_nvm nvm;
    dg_ns now;
    unsigned sent;
} bench;

static void count_note(void *ctx, const struct dg_eds_note *note)
{
    fuzz_must(ctx == &bench && note->what != NULL && note->what[0] != '\0');
    fuzz_must(memchr(note->section, '\0', sizeof note->section) != NULL);
    fuzz_must(memchr(note->value, '\0', sizeof note->value) != NULL);
}

static void keep_frame(void *ctx, const struct dg_can_frame *frame)
{
    fuzz_must(ctx == &bench && frame->dlc <= 8);
    bench.sent++;
}

static const struct dg_co_ops ops = {.send = keep_frame};

static void send_request(uint8_t command, uint32_t key, uint32_t value)
{
    struct dg_can_frame frame = {.id = 0x600u + NODE_ID, .dlc = 8, .data = {command}};

    dg_store_le16(&frame.data[1], (uint16_t)(key >> 16));
    frame.data[3] = (uint8_t)(key >> 8);
    dg_store_le32(&frame.data[4], value);
    bench.now += DG_MS(1);
    (void)dg_co_rx(&bench.encoder.device.node, bench.now, &frame);
    bench.now += DG_MS(20);
    (void)dg_co_step(&bench.encoder.device.node, bench.now);
}

/* A value that 32 bits do not hold, up and down; a block of it takes its time. */
static void use_blocks(uint32_t key)
{
    struct dg_co_node *node = &bench.encoder.device.node;

    send_request(0xA4, key, 0x7Fu);
    send_request(0xA3, 0, 0);
    for (unsigned i = 0; i < 150; i++) {
        bench.now += DG_MS(1);
        (void)dg_co_step(node, bench.now);
    }
    send_request(0xA2, 0x7F7F0000u, 0); /* confirms 127, of 127 or of fewer */
    send_request(0xA2, 0x7F01u << 16, 0);
    send_request(0xA1, 0, 0);
    send_request(0xC0, key, 0);
    send_request(0x01, key, 0);
    send_request(0x82, key, 0);
    send_request(0xC1, 0, 0);
}

/* What a master may do to each object, and a SYNC in between. */
static void use_objects(void)
{
    const struct dg_co_dictionary *dictionary = &bench.file.file.device.dictionary;
    const struct dg_can_frame sync = {.id = 0x080};

    for (uint16_t i = 0; i < dictionary->count; i++) {
        const uint32_t key = dictionary->rows[i].key;
        bench.sent = 0;
        send_request(0x40, key, 0);
        send_request(WRITE, key, key >> 16 == 0x1010 ? SAVE : i);
        fuzz_must(bench.sent >= 2 || bench.encoder.device.node.id != NODE_ID);
        if (dictionary->rows[i].flags == DG_CO_STRING << 12) {
            use_blocks(key);
        }
        (void)dg_co_rx(&bench.encoder.device.node, bench.now, &sync);
    }
}

static void power_on(void)
{
    struct dg_co_node *node = &bench.encoder.device.node;
    const struct dg_can_frame go = {.id = 0, .dlc = 2, .data = {1, NODE_ID}};

    bench.now += DG_S(1);
    fuzz_must(dg_co_power_on(node, bench.now) == DG_OK);
    (void)dg_co_rx(node, bench.now, &go);
    fuzz_must(dg_co_fits(node));
}

static void run_encoder(void)
{
    const struct dg_co_device *device = &bench.file.file.device;
    const struct dg_stack_setup setup = {
        .model = &bench.file.model,
        .world = &bench.world,
        .nvm = ram_nvm_port(&bench.nvm),
        .serial = 1,
        .address = NODE_ID,
        .port = &ops,
        .ctx = &bench,
    };

    if (bench.file.device.more > sizeof bench.encoder.cells) {
        return;
    }
    fuzz_must(dg_store_size(device->layout) <= RAM_NVM_MAX);
    dg_world_init(&bench.world);
    ram_nvm_init(&bench.nvm, dg_store_size(device->layout));
    fuzz_must(dg_cia406_stack.format(&setup) == DG_OK);
    fuzz_must(dg_cia406_stack.init(&bench.encoder.device, &setup) == DG_OK);
    power_on();
    use_objects();
    power_on();
    use_objects();
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    const struct dg_eds_setup setup = {
        .size = sizeof setup,
        .text = (const char *)bytes,
        .n = n,
        .memory = bench.memory,
        .memory_size = sizeof bench.memory,
        .note = count_note,
        .ctx = &bench,
    };
    struct dg_eds_note error = {.what = NULL};

    bench.now = 0;
    const int result = dg_cia406_read(&bench.file, &setup, &error);
    if (result == DG_OK) {
        run_encoder();
    } else {
        fuzz_must(result == DG_ERR_SPACE || error.what != NULL);
    }
    return 0;
}
