/* SPDX-License-Identifier: MIT */
/*
 * The seam of all protocols: every model of the table is made, fed and carried elsewhere by its
 * stack alone. What goes over the wires is no business of this file.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
#include "ram_nvm.h"

#define DEVICE_MAX 4096u
#define SERIAL 4711u
/* Longer than any model initialises. */
#define READY DG_S(1)
#define TURNS 3

/* A host's memory for a device, and what the device is made of. */
struct place {
    union {
        max_align_t align;
        unsigned char bytes[DEVICE_MAX];
    } device;
    struct dg_world world;
    struct ram_nvm nvm;
    struct dg_stack_setup setup;
    uint32_t sent; /* frames and replies */
};

static struct place here;
static struct place there;

static dg_angle turns(void *ctx, dg_ns now)
{
    (void)ctx;
    (void)now;
    return TURNS * DG_TURN + DG_TURN / 4;
}

static void reply(void *ctx, const uint8_t *bytes, size_t n)
{
    struct place *self = ctx;

    (void)bytes;
    (void)n;
    self->sent++;
}

static void count_frame(void *ctx, const struct dg_can_frame *frame)
{
    struct place *self = ctx;

    (void)frame;
    self->sent++;
}

/* The port's side of a stack; one that is missing here is one whose wire nobody wants. */
static const void *port_of(const struct dg_stack *stack)
{
    static const struct dg_hf_ops hf = {.tx = reply};
    static const struct dg_co_ops co = {.send = count_frame};

    if (stack == &dg_hf_stack) {
        return &hf;
    }
    return stack == &dg_cia406_stack ? &co : NULL;
}

static void furnish(struct place *self, const struct dg_device *device)
{
    const struct dg_store_layout *layout = device->stack->layout(device->model);

    memset(self, 0, sizeof *self);
    dg_world_init(&self->world);
    self->world.angle = turns;
    ram_nvm_init(&self->nvm, layout != NULL ? dg_store_size(layout) : 0);
    self->setup = (struct dg_stack_setup){.model = device->model,
                                          .world = &self->world,
                                          .serial = SERIAL,
                                          .port = port_of(device->stack),
                                          .ctx = self};
    if (layout != NULL) {
        self->setup.nvm = ram_nvm_port(&self->nvm);
    }
}

static void start_encoder(struct place *self, const struct dg_device *device)
{
    const struct dg_stack *stack = device->stack;

    furnish(self, device);
    assert_true(stack->device_size <= sizeof self->device);
    assert_int_equal(stack->format(&self->setup), DG_OK);
    if (stack->init(&self->device, &self->setup) != DG_OK) {
        fail_msg("%s is not made; does port_of() know its wire?", device->name);
    }
    assert_false(stack->powered(&self->device));
    assert_int_equal(stack->power_on(&self->device, 0), DG_OK);
    assert_true(stack->powered(&self->device));
}

/* Call `check` for every model. */
static void each(void (*check)(const struct dg_device *device))
{
    for (size_t i = 0; i < dg_device_count; i++) {
        check(dg_devices[i]);
    }
}

/* ------------------------------------------------------------ the objects */

static void check_object(const struct dg_device *device)
{
    const struct dg_stack *stack = device->stack;

    assert_non_null(device->model);
    assert_non_null(stack);
    assert_true(stack->name[0] >= 'a' && stack->name[0] <= 'z');
    assert_true((unsigned)stack->medium < DG_MEDIUM_COUNT);
    assert_true(stack->device_size > 0);
    assert_true(stack->layout != NULL && stack->senses_multiturn != NULL);
    assert_true(stack->format != NULL && stack->mount != NULL);
    assert_true(stack->init != NULL && stack->attach != NULL);
    assert_true(stack->power_on != NULL && stack->power_off != NULL && stack->powered != NULL);
    assert_true(stack->step != NULL && stack->model != NULL && stack->position != NULL);
    for (size_t i = 0; i < dg_device_count; i++) {
        const struct dg_stack *other = dg_devices[i]->stack;
        assert_true(other == stack || strcmp(other->name, stack->name) != 0);
    }
}

static void every_stack_is_whole(void **state)
{
    (void)state;
    each(check_object);
}

/* An accessor has the figures of a model of its own stack, and of no other. */
static void check_accessors(const struct dg_device *device)
{
    const struct {
        const struct dg_stack *stack;
        const void *model;
    } rows[] = {
        {&dg_hf_stack, dg_hf_model_of(device)},
        {&dg_biss_stack, dg_biss_model_of(device)},
        {&dg_cia406_stack, dg_cia406_model_of(device)},
        {&dg_ib_stack, dg_ib_model_of(device)},
    };

    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_ptr_equal(rows[i].model, rows[i].stack == device->stack ? device->model : NULL);
    }
}

static void figures_are_told_only_as_what_they_are(void **state)
{
    (void)state;
    each(check_accessors);
    assert_null(dg_hf_model_of(NULL));
    assert_null(dg_biss_model_of(NULL));
    assert_null(dg_cia406_model_of(NULL));
    assert_null(dg_ib_model_of(NULL));
}

/* ------------------------------------------------------------ operations */

static void check_life(const struct dg_device *device)
{
    const struct dg_stack *stack = device->stack;

    start_encoder(&here, device);
    assert_ptr_equal(stack->model(&here.device), device->model);
    assert_true(stack->step(&here.device, READY) > READY);
    stack->power_off(&here.device);
    assert_false(stack->powered(&here.device));
    assert_int_equal(stack->position(&here.device, READY), 0);
    assert_int_equal(stack->power_on(&here.device, READY), DG_OK);
    assert_int_equal(stack->power_on(&here.device, READY), DG_OK); /* a power cycle */
}

static void a_device_lives_behind_its_stack(void **state)
{
    (void)state;
    each(check_life);
}

static void check_missing(const struct dg_device *device)
{
    struct dg_stack_setup setup;

    furnish(&here, device);
    setup = here.setup;
    setup.model = NULL;
    assert_int_equal(device->stack->init(&here.device, &setup), DG_ERR_ARGUMENT);
    setup = here.setup;
    setup.world = NULL;
    assert_int_equal(device->stack->init(&here.device, &setup), DG_ERR_ARGUMENT);
    if (here.setup.nvm.ops != NULL) {
        setup = here.setup;
        setup.nvm.ops = NULL;
        assert_int_equal(device->stack->init(&here.device, &setup), DG_ERR_ARGUMENT);
        assert_int_equal(device->stack->init(&here.device, &here.setup), DG_OK);
        assert_int_equal(device->stack->power_on(&here.device, 0), DG_ERR_BLANK);
        assert_false(device->stack->powered(&here.device));
    }
    if (here.setup.port != NULL) {
        setup = here.setup;
        setup.port = NULL;
        assert_int_equal(device->stack->init(&here.device, &setup), DG_ERR_ARGUMENT);
    }
}

static void what_is_missing_is_refused(void **state)
{
    (void)state;
    each(check_missing);
}

/* 3.25 turns, in the steps and turns of each model as delivered. */
static void the_position_is_the_wires(void **state)
{
    static const struct {
        const char *name;
        uint64_t position;
    } rows[] = {
        {"s3674-rs485", 16384},
        {"s3684-rs485", 3 * 65536 + 16384},
        {"s3674-biss", 1ull << 19},
        {"s3684-biss", 3ull << 21 | 1ull << 19},
        {"f3658", 16384},
        {"f3668", 3 * 65536 + 16384},
        {"ocd-ib-k1", 1024},
        {"ocd-ib-k2", 3 * 4096 + 1024},
        {"ocd-ib-k3", 3 * 4096 + 1024},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_device *device = dg_device_find(rows[i].name);
        start_encoder(&here, device);
        const struct place before = here;
        assert_int_equal(device->stack->position(&here.device, READY), rows[i].position);
        assert_memory_equal(&before, &here, sizeof here);
    }
}

static void the_serial_number_of_a_node_is_burnt_in(void **state)
{
    (void)state;
    start_encoder(&here, &dg_f3668);
    const struct dg_cia406_device *device = (const void *)&here.device;
    assert_int_equal(device->node.serial, SERIAL);
}

static bool line_address_is(const void *self, uint32_t address)
{
    return ((const struct dg_hf *)self)->address == address;
}

static bool node_id_is(const void *self, uint32_t address)
{
    return ((const struct dg_cia406_device *)self)->node.id == address;
}

static void the_address_is_burnt_in(void **state)
{
    const struct {
        const struct dg_device *device;
        uint32_t first;
        uint32_t last;
        bool (*has)(const void *self, uint32_t address);
    } rows[] = {{&dg_s3684_rs485, 0x40, 0x5F, line_address_is}, {&dg_f3668, 1, 127, node_id_is}};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_stack *stack = rows[i].device->stack;
        for (uint32_t address = rows[i].first; address <= rows[i].last; address++) {
            furnish(&here, rows[i].device);
            here.setup.address = address;
            assert_int_equal(stack->format(&here.setup), DG_OK);
            assert_int_equal(stack->init(&here.device, &here.setup), DG_OK);
            assert_int_equal(stack->power_on(&here.device, 0), DG_OK);
            assert_true(rows[i].has(&here.device, address));
        }
        here.setup.address = rows[i].last + 1u;
        assert_int_equal(stack->format(&here.setup), DG_ERR_ARGUMENT);
        here.setup.address = 256u + rows[i].first;
        assert_int_equal(stack->format(&here.setup), DG_ERR_ARGUMENT);
    }
}

/* ------------------------------------------------------------ memories */

static void check_mount(const struct dg_device *device)
{
    const struct dg_stack *stack = device->stack;
    struct dg_store store;

    if (stack->layout(device->model) == NULL) {
        return;
    }
    furnish(&here, device);
    assert_int_equal(stack->mount(&here.setup, &store), DG_ERR_BLANK);
    assert_int_equal(stack->format(&here.setup), DG_OK);
    assert_int_equal(stack->mount(&here.setup, &store), DG_OK);
    assert_int_equal(store.region_count, stack->layout(device->model)->region_count);
    assert_true(stack->differs == NULL || stack->differs(&here.setup, &store) == NULL);
}

static void what_is_formatted_is_mounted_and_its_own(void **state)
{
    (void)state;
    each(check_mount);
}

/* What `made` has burnt in, in the eyes of `seen`. */
static const char *difference(const struct dg_device *made, const void *seen)
{
    struct dg_store store;

    furnish(&here, made);
    assert_int_equal(made->stack->format(&here.setup), DG_OK);
    here.setup.model = seen;
    assert_int_equal(made->stack->mount(&here.setup, &store), DG_OK);
    return made->stack->differs(&here.setup, &store);
}

static void a_memory_of_other_figures_is_told(void **state)
{
    struct dg_hf_model model = *dg_hf_model_of(&dg_s3684_rs485);

    (void)state;
    assert_string_equal(difference(&dg_s3684_rs485, dg_s3674_rs485.model),
                        "periods, steps or turns");
    model.type_code ^= 1u;
    assert_string_equal(difference(&dg_s3684_rs485, &model), "type code or option");
    model = *dg_hf_model_of(&dg_s3684_rs485);
    model.memory_blocks--;
    assert_string_equal(difference(&dg_s3684_rs485, &model), "user memory size");
    model = *dg_hf_model_of(&dg_s3684_rs485);
    model.speed_max_rpm++;
    assert_string_equal(difference(&dg_s3684_rs485, &model), "type label");
}

static void a_unit_has_a_serial_number_and_a_firmware(void **state)
{
    struct dg_hf_model model = *dg_hf_model_of(&dg_s3684_rs485);
    struct dg_store store;

    (void)state;
    memcpy(model.serial, "012345678", 9);
    model.version[0] = '!';
    model.date[0] = '!';
    assert_null(difference(&dg_s3684_rs485, &model));

    furnish(&here, &dg_s3684_rs485);
    here.setup.model = &model;
    assert_int_equal(dg_hf_stack.format(&here.setup), DG_OK);
    assert_int_equal(dg_hf_stack.mount(&here.setup, &store), DG_OK);
    assert_int_equal(dg_hf_stack.serial(&store), 12345678);

    furnish(&here, &dg_f3668);
    here.setup.serial = UINT32_MAX;
    assert_int_equal(dg_cia406_stack.format(&here.setup), DG_OK);
    assert_int_equal(dg_cia406_stack.mount(&here.setup, &store), DG_OK);
    assert_true(dg_cia406_stack.serial(&store) == UINT32_MAX);
}

/* What is damaged is for the device to report. */
static void damage_makes_no_stranger(void **state)
{
    struct dg_store store;

    (void)state;
    furnish(&here, &dg_s3684_rs485);
    assert_int_equal(dg_hf_stack.format(&here.setup), DG_OK);
    here.nvm.bytes[dg_store_address(&dg_hf_layout, DG_HF_REGION_TYPE)] ^= 1u;
    assert_int_equal(dg_hf_stack.mount(&here.setup, &store), DG_OK);
    assert_true(dg_store_damaged(&store, DG_HF_REGION_TYPE));
    assert_null(dg_hf_stack.differs(&here.setup, &store));
    assert_int_equal(dg_hf_stack.serial(&store), -1);

    furnish(&here, &dg_f3668);
    const struct dg_store_layout *layout = dg_cia406_stack.layout(dg_f3668.model);
    assert_int_equal(dg_cia406_stack.format(&here.setup), DG_OK);
    here.nvm.bytes[dg_store_address(layout, DG_CO_REGION_SERIAL)] ^= 1u;
    assert_int_equal(dg_cia406_stack.mount(&here.setup, &store), DG_OK);
    assert_int_equal(dg_cia406_stack.serial(&store), -1);
}

/* ------------------------------------------------------------ carried elsewhere */

static void carry(const struct dg_device *device)
{
    static unsigned char kept[DEVICE_MAX];
    const struct dg_stack *stack = device->stack;

    device->stack->attach(&here.device, NULL);
    memcpy(kept, &here.device, stack->device_size);
    memcpy(there.device.bytes, kept, stack->device_size);
    memcpy(there.nvm.bytes, here.nvm.bytes, sizeof here.nvm.bytes);
    memset(&here, 0xA5, sizeof here); /* nobody must look there any more */
    stack->attach(&there.device, &there.setup);
}

static void check_bytes(const struct dg_device *device)
{
    const struct dg_stack *stack = device->stack;

    start_encoder(&here, device);
    start_encoder(&there, device);
    assert_int_equal(stack->step(&here.device, READY), stack->step(&there.device, READY));
    stack->attach(&here.device, NULL);
    stack->attach(&there.device, NULL);
    assert_memory_equal(&here.device, &there.device, stack->device_size);
}

/* Two devices at two places that went through the same are the same bytes. */
static void detached_devices_have_no_pointers(void **state)
{
    (void)state;
    each(check_bytes);
}

static void check_carried(const struct dg_device *device)
{
    const struct dg_stack *stack = device->stack;

    start_encoder(&here, device);
    (void)stack->step(&here.device, READY);
    const uint64_t position = stack->position(&here.device, READY);
    const dg_ns next = stack->step(&here.device, READY);
    furnish(&there, device);
    carry(device);
    assert_true(stack->powered(&there.device));
    assert_ptr_equal(stack->model(&there.device), device->model);
    assert_int_equal(stack->step(&there.device, READY), next);
    assert_int_equal(stack->position(&there.device, READY), position);
    assert_int_equal(stack->power_on(&there.device, 2 * READY), DG_OK);
}

static void a_carried_device_goes_on(void **state)
{
    (void)state;
    each(check_carried);
}

static void report_bytes(struct place *at, const char *hex)
{
    struct dg_cia406_device *device = (void *)&at->device;
    struct dg_can_frame frame = {.id = 0x600u + device->node.id, .dlc = 8};

    for (size_t i = 0; i < 8; i++) {
        const char *digits = "0123456789ABCDEF";
        frame.data[i] = (uint8_t)((strchr(digits, hex[2 * i]) - digits) << 4 |
                                  (strchr(digits, hex[2 * i + 1]) - digits));
    }
    (void)dg_co_rx(&device->node, READY, &frame);
}

/* A segmented download that is half done, and TPDOs with their mapped objects. */
static void a_node_is_carried_in_the_middle_of_things(void **state)
{
    static const struct dg_can_frame sync = {.id = 0x80};
    static const struct dg_can_frame operational = {.id = 0, .dlc = 2, .data = {1, 0}};
    struct dg_cia406_device *device = (void *)&here.device;

    (void)state;
    start_encoder(&here, &dg_f3668);
    (void)dg_co_rx(&device->node, READY, &operational);
    report_bytes(&here, "2117100004000000"); /* 1017h, 4 bytes announced: too long */
    assert_int_equal(device->node.sdo.state, DG_CO_SDO_IDLE);
    report_bytes(&here, "2117100002000000"); /* 2 bytes */
    assert_int_equal(device->node.sdo.state, DG_CO_SDO_DOWNLOAD);
    const uint8_t mapped = device->node.tpdo[1].mapped_count;
    assert_true(mapped > 0);
    const uint16_t first = device->node.tpdo[1].mapped[0];
    furnish(&there, &dg_f3668);
    carry(&dg_f3668);
    device = (void *)&there.device;
    assert_ptr_equal(device->node.setup.application, &device->encoder);
    assert_int_equal(device->node.tpdo[1].mapped_count, mapped);
    assert_int_equal(device->node.tpdo[1].mapped[0], first);
    report_bytes(&there, "0BE8030000000000"); /* the last segment: 1000 ms */
    assert_int_equal(device->node.sdo.state, DG_CO_SDO_IDLE);
    const uint32_t sent = there.sent;
    assert_int_equal(dg_co_step(&device->node, READY), READY + DG_MS(100));
    (void)dg_co_rx(&device->node, READY, &sync);
    assert_true(there.sent > sent);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_stack_is_whole),
        cmocka_unit_test(figures_are_told_only_as_what_they_are),
        cmocka_unit_test(a_device_lives_behind_its_stack),
        cmocka_unit_test(what_is_missing_is_refused),
        cmocka_unit_test(the_position_is_the_wires),
        cmocka_unit_test(the_serial_number_of_a_node_is_burnt_in),
        cmocka_unit_test(the_address_is_burnt_in),
        cmocka_unit_test(what_is_formatted_is_mounted_and_its_own),
        cmocka_unit_test(a_memory_of_other_figures_is_told),
        cmocka_unit_test(a_unit_has_a_serial_number_and_a_firmware),
        cmocka_unit_test(damage_makes_no_stranger),
        cmocka_unit_test(detached_devices_have_no_pointers),
        cmocka_unit_test(a_carried_device_goes_on),
        cmocka_unit_test(a_node_is_carried_in_the_middle_of_things),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
