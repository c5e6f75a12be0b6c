/* SPDX-License-Identifier: MIT */
/* Whose an EEPROM file is, and what is taken all the same. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "clocked.h"
#include "descriptors.h"
#include "drehgeber/devices.h"
#include "eeprom_rig.h"
#include "image.h"
#include "sim_rig.h"

static void memory_forgets(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    struct dg_store store;
    assert_int_equal(eeprom_open(&eeprom, NULL, place, &error), 0);
    assert_int_equal(dg_store_mount(&store, &dg_hf_layout, eeprom.part.device.nvm), DG_OK);
    assert_int_equal(eeprom.part.device.nvm.ops->read(eeprom.part.device.nvm.ctx,
                                                      eeprom.image.memory.size, &store, 1),
                     DG_ERR_IO);
    assert_int_equal(eeprom.part.device.nvm.ops->write(eeprom.part.device.nvm.ctx,
                                                       eeprom.image.memory.size, &store, 1),
                     DG_ERR_IO);
    eeprom_close(&eeprom);
}

static void files_that_are_no_image_are_refused(void **state)
{
    struct eeprom_place *place = *state;
    const uint32_t size = dg_store_size(&dg_hf_layout);
    uint8_t *bytes = malloc(size + 1);
    assert_non_null(bytes);
    memset(bytes, 0xFF, size + 1);
    eeprom_write_bytes(place->path, bytes, 0);
    eeprom_refused(place, "0 bytes");
    eeprom_write_bytes(place->path, bytes, size + 1);
    eeprom_refused(place, "an image of this encoder has");
    eeprom_write_bytes(place->path, bytes, size);
    eeprom_refused(place, "blank");
    memset(bytes, 'x', size);
    eeprom_write_bytes(place->path, bytes, size);
    eeprom_refused(place, "something else");
    eeprom_write_bytes(place->path, bytes, 10);
    eeprom_refused(place, "something else");
    free(bytes);
}

/* A file that was cut to less than what says its kind is not one that NVM:ERASe has left. */
static void a_stump_is_refused(void **state)
{
    struct eeprom_place *place = *state;
    for (off_t length = 1; length < 12; length++) {
        (void)unlink(place->path);
        eeprom_make(place);
        assert_int_equal(truncate(place->path, length), 0);
        eeprom_refused(place, "no image of this kind of encoder");
        assert_int_equal(eeprom_length_of(place->path), length);
    }
}

static void other_factory_figures_are_refused(void **state)
{
    struct eeprom_place *place = *state;
    const struct dg_hf_model own = place->model;
    eeprom_make(place);
    place->model = *dg_hf_model_of(&dg_s3674_rs485);
    eeprom_refused(place, "belongs to s3684-rs485");
    struct dg_hf_model others[] = {own, own, own, own, own};
    others[0].periods_per_turn = 1024;
    others[1].memory_blocks = 22;
    others[2].type_code = 0x28;
    (void)strcpy(others[3].designation, "other");
    others[4].temperature_max_degc = 60;
    for (size_t i = 0; i < DG_COUNT(others); i++) {
        place->model = others[i];
        eeprom_refused(place, "differs");
    }
    place->model = own;
    place->serial = 1;
    place->serial_given = true;
    eeprom_refused(place, "belongs to serial number 123456789");
}

/* A later firmware, or no --serial: still the same unit. */
static void a_units_own_identity_is_kept(void **state)
{
    struct eeprom_place *place = *state;
    struct lx_error error;
    struct eeprom eeprom;
    (void)strcpy(place->model.serial, "000000777");
    eeprom_make(place);
    place->model = *dg_hf_model_of(&dg_s3684_rs485);
    (void)strcpy(place->model.version, "v9.9.9-new");
    (void)strcpy(place->model.date, "01012030");
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    eeprom_close(&eeprom);
}

/* A damaged region is for the device to report, whatever it says. */
static void a_damaged_image_is_taken(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    eeprom_make(place);
    const int fd = open(place->path, O_WRONLY);
    const off_t at = (off_t)dg_store_address(&dg_hf_layout, DG_HF_REGION_RESOLUTION);
    assert_int_equal(pwrite(fd, "?", 1, at), 1);
    (void)close(fd);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    eeprom_close(&eeprom);
}

static void a_cut_off_image_reads_erased(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    uint8_t bytes[8];
    eeprom_make(place);
    const off_t length = eeprom_length_of(place->path) - 100;
    assert_int_equal(truncate(place->path, length), 0);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    assert_int_equal(eeprom_length_of(place->path), length);
    const uint32_t at = (uint32_t)length;
    assert_int_equal(eeprom.part.device.nvm.ops->read(eeprom.part.device.nvm.ctx, at, bytes, 8),
                     DG_OK);
    assert_memory_equal(bytes, "\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF", 8);
    /* a write behind the end leaves no zeros in between */
    assert_int_equal(eeprom.part.device.nvm.ops->write(eeprom.part.device.nvm.ctx, at + 4, "ab", 2),
                     DG_OK);
    assert_int_equal(eeprom.part.device.nvm.ops->read(eeprom.part.device.nvm.ctx, at, bytes, 8),
                     DG_OK);
    assert_memory_equal(bytes,
                        "\xFF\xFF\xFF\xFF"
                        "ab\xFF\xFF",
                        8);
    eeprom_close(&eeprom);
}

/* As the last release would have written it, had its table ended before "user". */
static void make_older_image(struct eeprom_place *place)
{
    struct eeprom eeprom;
    struct lx_error error;
    struct dg_store_layout older = dg_hf_layout;
    older.region_count--;
    assert_int_equal(eeprom_open(&eeprom, NULL, place, &error), 0);
    assert_int_equal(dg_store_format(&older, eeprom.part.device.nvm, &place->model), DG_OK);
    eeprom_write_bytes(place->path, eeprom.image.memory.bytes, dg_store_size(&older));
    eeprom_close(&eeprom);
}

/* Looking at it changes nothing; mounted as the device does, the file has all of today's length. */
static void an_image_of_an_earlier_release_is_taken_and_grows(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    struct dg_store store;
    uint8_t bytes[4] = {0};
    make_older_image(place);
    const off_t length = eeprom_length_of(place->path);
    assert_true(length < (off_t)dg_store_size(&dg_hf_layout));
    place->model = *dg_hf_model_of(&dg_s3674_rs485);
    eeprom_refused(place, "belongs to s3684-rs485");
    assert_int_equal(eeprom_length_of(place->path), length);
    place->model = *dg_hf_model_of(&dg_s3684_rs485);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    assert_int_equal(eeprom_length_of(place->path), length);
    assert_int_equal(dg_store_mount(&store, &dg_hf_layout, eeprom.part.device.nvm), DG_ERR_OLDER);
    assert_int_equal(dg_store_grow(&store, &place->model), DG_OK);
    assert_int_equal(eeprom_length_of(place->path), dg_store_size(&dg_hf_layout));
    assert_int_equal(dg_store_put(&store, DG_HF_REGION_USER, 1788, "last", 4), DG_OK);
    eeprom_close(&eeprom);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    assert_int_equal(dg_store_mount(&store, &dg_hf_layout, eeprom.part.device.nvm), DG_OK);
    assert_int_equal(dg_store_read(&store, DG_HF_REGION_USER, 1788, bytes, 4), DG_OK);
    assert_memory_equal(bytes, "last", 4);
    eeprom_close(&eeprom);
}

/* A process that ends after some of its writes. */
struct ending {
    struct dg_nvm below;
    uint32_t writes; /* that it still gets through */
};

static int ending_read(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct ending *self = ctx;
    return self->below.ops->read(self->below.ctx, address, to, n);
}

static int ending_write(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct ending *self = ctx;
    if (self->writes == 0) {
        return DG_ERR_IO;
    }
    self->writes--;
    return self->below.ops->write(self->below.ctx, address, from, n);
}

/* @return whether it came to its end */
static bool erase(struct eeprom *eeprom, uint32_t writes)
{
    static const struct dg_nvm_ops ops = {.read = ending_read, .write = ending_write};
    struct ending ending = {eeprom->part.device.nvm, writes};
    struct dg_stack_setup setup = eeprom->part.device;
    setup.nvm = (struct dg_nvm){&ops, &ending};
    return eeprom->part.stack->format(&setup) == DG_OK;
}

static void read_file(const struct eeprom_place *place, uint8_t *bytes, uint32_t size)
{
    const int fd = open(place->path, O_RDONLY);
    assert_int_equal(read(fd, bytes, size), (ssize_t)size);
    (void)close(fd);
}

/* Wherever NVM:ERASe is interrupted the next start has the image from before, or the delivery
   state; and what it found is what it leaves. */
static void an_interrupted_erase_is_ended_or_undone(void **state)
{
    static uint8_t old[16384];
    static uint8_t delivered[sizeof old];
    static uint8_t found[sizeof old];
    struct eeprom_place *place = *state;
    const uint32_t size = dg_store_size(&dg_hf_layout);
    const uint8_t uart[2] = {0x45, 0xE4};
    struct eeprom eeprom;
    struct lx_error error;
    struct dg_store store;
    unsigned ended = 0;
    unsigned undone = 0;
    bool done = false;
    assert_true(size <= sizeof old);
    eeprom_make(place);
    read_file(place, delivered, size);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    assert_int_equal(dg_store_mount(&store, &dg_hf_layout, eeprom.part.device.nvm), DG_OK);
    assert_int_equal(dg_store_put(&store, DG_HF_REGION_UART, 0, uart, sizeof uart), DG_OK);
    eeprom_close(&eeprom);
    read_file(place, old, size);
    for (uint32_t writes = 0; !done; writes++) {
        eeprom_write_bytes(place->path, old, size);
        assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
        done = erase(&eeprom, writes);
        eeprom_close(&eeprom);
        assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
        assert_int_equal(dg_store_mount(&store, &dg_hf_layout, eeprom.part.device.nvm), DG_OK);
        eeprom_close(&eeprom);
        read_file(place, found, size);
        const bool as_old = memcmp(found, old, size) == 0;
        assert_true(as_old || memcmp(found, delivered, size) == 0);
        assert_false(as_old && done);
        undone += as_old ? 1u : 0u;
        ended += as_old || done ? 0u : 1u;
    }
    assert_true(undone == 2 && ended > 10); /* no mark, one of two */
}

/* Whoever is told that the file fails is told what this kind of encoder answers. */
static void a_kind_says_what_it_answers_without_its_memory(void **state)
{
    struct eeprom_place *place = *state;
    struct sim_rig rig;
    struct lx_error error;
    sim_rig_plan(&rig, 1);
    rig.plan.encoders[0].nvm = dg_plan_copy(&rig.plan, place->path);
    sim_rig_prepare(&rig);
    rig.setup.bus.writer = lx_nvm_writer_new(rig.event, NULL, NULL);
    assert_non_null(rig.setup.bus.writer);
    sim_rig_make(&rig);
    assert_int_equal(rig.bus->ops->open(rig.bus, SIM_RIG_POWER_ON, &error), 0);
    const uint8_t *queue = (const uint8_t *)rig.station[0].queue;
    const struct lx_image *image = (const void *)(queue - offsetof(struct lx_image, queue));
    assert_string_equal(image->file.answer, "the encoder answers P = 1");
    lx_engine_close(&rig.engine);
    lx_nvm_writer_free(rig.setup.bus.writer);
    rig.event = sd_event_unref(rig.event);
    plan_rig_free(&rig.plan);
}

#define IN_A_PLACE(test)                                                                           \
    cmocka_unit_test_setup_teardown(test, eeprom_place_set_up, eeprom_place_tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_A_PLACE(memory_forgets),
        IN_A_PLACE(files_that_are_no_image_are_refused),
        IN_A_PLACE(a_stump_is_refused),
        IN_A_PLACE(other_factory_figures_are_refused),
        IN_A_PLACE(a_units_own_identity_is_kept),
        IN_A_PLACE(a_damaged_image_is_taken),
        IN_A_PLACE(a_cut_off_image_reads_erased),
        IN_A_PLACE(an_image_of_an_earlier_release_is_taken_and_grows),
        IN_A_PLACE(an_interrupted_erase_is_ended_or_undone),
        cmocka_unit_test(no_descriptor_is_left),
        IN_A_PLACE(a_kind_says_what_it_answers_without_its_memory),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
