/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: EEPROM images whose sums are right and whose contents are not, for every model. The
 * input names a model, changes to what it is delivered with (parts of regions, journals, headers of
 * earlier releases), and then what is asked of the device that was powered on with it. It starts or
 * refuses the image, and no value leaves its range.
 */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "biss_rig.h"
#include "drehgeber/bits.h"
#include "drehgeber/cia406.h"
#include "drehgeber/crc.h"
#include "drehgeber/devices.h"
#include "fuzz_input.h"
#include "hf_rig.h"
#include "ib_rig.h"

#define HEADER 12u
#define JOURNAL (2u * HEADER)
#define CHANGES (JOURNAL + 8u)
#define SUM_SEED 0xFFFFu
#define CHANGES_MAX 16u
#define REQUESTS_MAX 64u
#define COMMAND_MAX 8u

/* The memory at hand. */
struct image {
    const struct dg_store_layout *layout;
    struct ram_nvm *nvm;
};

static void take_bytes(struct fuzz_input *input, uint8_t *to, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        to[i] = fuzz_take(input);
    }
}

/* --- what is done to an image --- */

/* Part of a region, whose sum is right again, or now and then is not. */
static void change_region(struct image *image, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);
    const uint8_t region = how % image->layout->region_count;
    const struct dg_store_region *row = &image->layout->regions[region];
    uint8_t *bytes = image->nvm->bytes + dg_store_address(image->layout, region);
    const size_t offset = fuzz_take(input) % row->size;
    const size_t wanted = fuzz_take(input) % 32u + 1u;

    take_bytes(input, bytes + offset, wanted < row->size - offset ? wanted : row->size - offset);
    if (row->check == DG_STORE_CHECKED && how < 0xF0) {
        dg_store_be16(bytes + row->size, dg_crc16(SUM_SEED, bytes, row->size));
    }
}

/* A whole journal with any changes. */
static void put_journal(struct image *image, struct fuzz_input *input)
{
    uint8_t *bytes = image->nvm->bytes;
    const uint16_t room = image->layout->journal_size;
    uint16_t length = 0;

    for (uint8_t count = fuzz_take(input) % 4u + 1u; count > 0; count--) {
        const uint8_t n = fuzz_take(input) % 64u;
        if (6u + n > (size_t)room - length) {
            break;
        }
        uint8_t *change = bytes + CHANGES + length;
        take_bytes(input, change, 4);
        dg_store_le16(change + 4, (uint16_t)(n + (change[1] > 0xF0 ? change[1] : 0u)));
        change[1] = 0;
        take_bytes(input, change + 6, n);
        length = (uint16_t)(length + 6u + n);
    }
    dg_store_le16(bytes + JOURNAL, length);
    dg_store_le16(bytes + JOURNAL + 2, (uint16_t)~length);
    const uint32_t sum = dg_crc32(dg_crc32(0, bytes + JOURNAL, 4), bytes + CHANGES, length);
    dg_store_le32(bytes + JOURNAL + 4, sum);
}

/* The header, its copy or both are those of fewer regions. */
static void put_header(struct image *image, struct fuzz_input *input)
{
    const uint8_t which = fuzz_take(input);
    const uint8_t regions = fuzz_take(input) % (image->layout->region_count + 1u);

    for (unsigned i = 0; i < 2; i++) {
        if ((which >> i & 1u) != 0) {
            dg_store_le32(image->nvm->bytes + i * HEADER + 8,
                          dg_store_address(image->layout, regions));
        }
    }
}

static void flip_bit(struct image *image, struct fuzz_input *input)
{
    const uint32_t where = fuzz_take32(input);

    image->nvm->bytes[(where >> 3) % image->nvm->size] ^= (uint8_t)(1u << (where & 7u));
}

static void change_image(struct image *image, struct fuzz_input *input)
{
    static void (*const changes[])(struct image *, struct fuzz_input *) = {
        change_region, change_region, change_region, change_region,
        change_region, put_journal,   put_header,    flip_bit,
    };

    for (uint8_t count = fuzz_take(input) % CHANGES_MAX; count > 0; count--) {
        changes[fuzz_take(input) % (DG_COUNT(changes))](image, input);
    }
}

/* --- a device that is used with it --- */

static bool started(int result)
{
    fuzz_must(result == DG_OK || result == DG_ERR_BLANK || result == DG_ERR_FOREIGN ||
              result == DG_ERR_IO);
    return result == DG_OK;
}

static bool goes_on(struct fuzz_input *input, unsigned *count)
{
    return input->at < input->end && (*count)++ < REQUESTS_MAX;
}

static void use_hiperface(const struct dg_device *model, struct fuzz_input *input)
{
    static struct hf_rig rig;
    uint8_t command[COMMAND_MAX];
    unsigned count = 0;

    fuzz_must(hf_rig_init(&rig, dg_hf_model_of(model)) == DG_OK);
    change_image(&(struct image){&dg_hf_layout, &rig.nvm}, input);
    if (!started(hf_rig_power_on(&rig))) {
        return;
    }
    while (goes_on(input, &count)) {
        const size_t n = fuzz_take(input) % COMMAND_MAX + 1u;
        const struct dg_hf *device = &rig.device;
        take_bytes(input, command, n);
        (void)hf_rig_ask_bytes(&rig, command, n);
        fuzz_must(dg_hf_position(device, rig.now) <
                  (uint64_t)device->periods * device->steps * device->turns);
    }
}

static void use_biss(const struct dg_device *model, struct fuzz_input *input)
{
    static struct biss_rig rig;
    unsigned count = 0;

    fuzz_must(biss_rig_init(&rig, dg_biss_model_of(model), 1) == DG_OK);
    change_image(&(struct image){&dg_biss_layout, &rig.nvm[0]}, input);
    if (!started(biss_rig_power_on(&rig))) {
        return;
    }
    const uint8_t bits = (uint8_t)(rig.model.multiturn_bits + rig.model.singleturn_bits);
    while (goes_on(input, &count)) {
        const uint8_t how = fuzz_take(input);
        const uint8_t address = fuzz_take(input) & 0x7Fu;
        if ((how & 1u) != 0) {
            (void)biss_rig_put(&rig, address, fuzz_take(input));
        } else if ((how & 2u) != 0) {
            (void)biss_rig_get(&rig, address);
        } else {
            (void)biss_rig_command(&rig, how & 0x80u, address & 3u);
        }
        fuzz_must(dg_biss_position(&rig.slave[0], rig.now) >> bits == 0);
    }
}

static void use_interbus(const struct dg_device *model, struct fuzz_input *input)
{
    static struct ib_rig rig;
    unsigned count = 0;

    fuzz_must(ib_rig_init(&rig, dg_ib_model_of(model)) == DG_OK);
    change_image(&(struct image){&dg_ib_layout, &rig.nvm}, input);
    if (!started(ib_rig_power_on(&rig))) {
        return;
    }
    while (goes_on(input, &count)) {
        const uint32_t out = fuzz_take32(input);
        (void)ib_rig_send(&rig, out);
        if ((out & 1u) != 0) {
            (void)ib_rig_release(&rig);
        }
        fuzz_must(dg_ib_range(&rig.device) > 0);
        fuzz_must(dg_ib_position(&rig.device, rig.now) < dg_ib_range(&rig.device));
    }
}

/* --- CANopen --- */

static struct node {
    struct ram_nvm nvm;
    struct dg_world world;
    struct dg_cia406 encoder;
    struct dg_co_node node;
    struct dg_can_frame last;
    dg_ns now;
} node;

static void on_frame(void *ctx, const struct dg_can_frame *frame)
{
    (void)ctx;
    fuzz_must(frame->id <= 0x7FF && frame->dlc <= 8);
    node.last = *frame;
}

static void on_bit_rate(void *ctx, uint16_t kbaud)
{
    (void)ctx;
    fuzz_must(kbaud >= 10 && kbaud <= 1000);
}

static void check_node(void)
{
    const struct dg_can_frame ask = {
        .id = (uint16_t)(0x600u + node.node.id), .dlc = 8, .data = {0x40, 0x04, 0x60}};
    const bool answers =
        node.node.state == DG_CO_PRE_OPERATIONAL || node.node.state == DG_CO_OPERATIONAL;

    fuzz_must((node.node.id >= 1 && node.node.id <= 127) || node.node.id == DG_CO_UNCONFIGURED);
    if (!answers || node.node.id == DG_CO_UNCONFIGURED) {
        return;
    }
    (void)dg_co_rx(&node.node, node.now, &ask);
    if (node.last.data[0] == 0x43) {
        fuzz_must(dg_load_le32(node.last.data + 4) <
                  (uint64_t)node.encoder.model->turns * DG_CIA406_STEPS);
    }
}

static void use_node(struct fuzz_input *input)
{
    static const uint16_t ids[] = {0x600, 0x600, 0x600, 0, 0x080, 0x7E5, 0x700, 0x180};
    unsigned count = 0;

    while (goes_on(input, &count)) {
        const uint8_t how = fuzz_take(input);
        struct dg_can_frame frame = {.id = ids[how & 7u], .dlc = 8};
        frame.id = (uint16_t)(frame.id + (how % 8u == 3 || how % 8u == 4 || how % 8u == 5
                                              ? 0u
                                              : node.node.id & 0x7Fu));
        frame.dlc = frame.id == 0 ? 2 : 8;
        frame.rtr = (how & 7u) >= 6;
        take_bytes(input, frame.data, frame.dlc);
        (void)dg_co_rx(&node.node, node.now, &frame);
        node.now = dg_after(node.now, DG_US(100) << (how >> 4));
        (void)dg_co_step(&node.node, node.now);
        check_node();
    }
}

static void use_canopen(const struct dg_device *model, struct fuzz_input *input)
{
    static const struct dg_co_ops ops = {.send = on_frame, .bit_rate = on_bit_rate};
    const struct dg_co_device *device = dg_cia406_model_of(model)->device;

    memset(&node, 0, sizeof node);
    dg_world_init(&node.world);
    ram_nvm_init(&node.nvm, dg_store_size(device->layout));
    const struct dg_co_setup setup = {.device = device,
                                      .world = &node.world,
                                      .nvm = ram_nvm_port(&node.nvm),
                                      .ops = &ops,
                                      .application = &node.encoder};
    fuzz_must(dg_co_format(device, setup.nvm, 1234567890u) == DG_OK);
    change_image(&(struct image){device->layout, &node.nvm}, input);
    fuzz_must(dg_cia406_init(&node.encoder, dg_cia406_model_of(model)) == DG_OK);
    fuzz_must(dg_co_init(&node.node, &setup) == DG_OK);
    if (started(dg_co_power_on(&node.node, 0))) {
        use_node(input);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static const struct {
        const struct dg_stack *stack;
        void (*use)(const struct dg_device *model, struct fuzz_input *input);
    } uses[] = {
        {&dg_hf_stack, use_hiperface},
        {&dg_biss_stack, use_biss},
        {&dg_cia406_stack, use_canopen},
        {&dg_ib_stack, use_interbus},
    };
    struct fuzz_input input = {.at = bytes, .end = bytes + n};
    const struct dg_device *model = dg_devices[fuzz_take(&input) % dg_device_count];

    if (model->stack->layout(model->model) == NULL) {
        return 0; /* no EEPROM */
    }
    for (size_t i = 0; i < DG_COUNT(uses); i++) {
        if (uses[i].stack == model->stack) {
            uses[i].use(model, &input);
            return 0;
        }
    }
    abort(); /* a stack that this program does not know */
}
