/* SPDX-License-Identifier: MIT */
/*
 * EEPROMs of models that are texts: whose figures one has, and what of it goes on with others.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
#include "drehgeber/rig.h"
#include "drehgeber/ssi.h"
#include "drehgeber/stamp.h"
#include "failing_nvm.h"
#include "ram_nvm.h"

#define MEMORY_SIZE 65536u

static const char text[] = "[model la25]\nbase = s3674-biss\nst = 25\nmt = 0\nlc = 0\n"
                           "[model la26]\nbase = la25\nst = 26\nbusy_us = 3\n"
                           "[model slow26]\nbase = la26\nbusy_us = 30\n"
                           "[model sin512]\nbase = s3684-rs485\nperiods = 512\nsteps = 128\n"
                           "[model sin1024]\nbase = sin512\nperiods = 1024\n"
                           "[model small]\nbase = sin1024\nmemory = 20\nimplemented = 20\n"
                           "[model drum]\nbase = ocd-ib-k3\nsteps = 1000\n"
                           "[model drum8]\nbase = drum\nturns = 8\n"
                           "[model small-k2]\nbase = ocd-ib-k2\nsteps = 1000\n"
                           "[model reel]\nbase = ssi-25\nst = 10\n";

struct bench {
    _Alignas(16) unsigned char memory[MEMORY_SIZE];
    struct dg_plan plan;
    struct dg_plan_error error;
    struct ram_nvm from;
    struct ram_nvm to;
    char told[300];
};
static struct bench bench;

static int read_plan(void **state)
{
    const struct dg_plan_setup setup = {
        .size = sizeof setup,
        .file = "models.ini",
        .text = {text, sizeof text - 1u},
        .memory = bench.memory,
        .memory_size = MEMORY_SIZE,
    };
    (void)state;
    return dg_plan_read(&bench.plan, &setup, &bench.error);
}

static const struct dg_device *find(const char *name)
{
    const struct dg_device *device = dg_plan_find_model(&bench.plan, name);
    assert_non_null(device);
    return device;
}

static const struct dg_model_stamp *stamp_of(const char *name)
{
    const struct dg_device *device = find(name);
    return dg_model_stamp_of(dg_model_text_of(device->stack), device->model);
}

static const struct dg_store_layout *layout_of(const char *name)
{
    const struct dg_device *device = find(name);
    return device->stack->layout(device->model);
}

static struct dg_stack_setup deliver(const char *name, struct ram_nvm *nvm)
{
    const struct dg_device *device = find(name);
    const struct dg_stack_setup setup = {.model = device->model, .nvm = ram_nvm_port(nvm)};
    ram_nvm_init(nvm, dg_store_size(device->stack->layout(device->model)));
    assert_int_equal(device->stack->format(&setup), DG_OK);
    return setup;
}

static int mount(const char *name, struct ram_nvm *nvm)
{
    const struct dg_device *device = find(name);
    const struct dg_stack_setup setup = {.model = device->model, .nvm = ram_nvm_port(nvm)};
    struct dg_store store;
    return device->stack->mount(&setup, &store);
}

static void put_byte(const char *name, struct ram_nvm *nvm, uint8_t region, uint8_t byte)
{
    const struct dg_store_layout *layout = layout_of(name);
    uint8_t bytes[DG_STORE_CHECKED_MAX];
    struct dg_store store;
    const uint16_t size = layout->regions[region].check == DG_STORE_CHECKED
                              ? layout->regions[region].size
                              : (uint16_t)DG_BISS_BANK_SIZE;
    memset(bytes, byte, sizeof bytes);
    assert_int_equal(dg_store_mount(&store, layout, ram_nvm_port(nvm)), DG_OK);
    assert_int_equal(dg_store_put(&store, region, 0, bytes, size), DG_OK);
}

/* The first byte. */
static uint8_t get(const char *name, struct ram_nvm *nvm, uint8_t region)
{
    uint8_t byte = 0;
    struct dg_store store;
    assert_int_equal(dg_store_mount(&store, layout_of(name), ram_nvm_port(nvm)), DG_OK);
    assert_false(dg_store_damaged(&store, region));
    assert_int_equal(dg_store_read(&store, region, 0, &byte, 1), DG_OK);
    return byte;
}

static void tell_misfit(void *ctx, const struct dg_model_misfit *misfit)
{
    char *to = ctx;
    (void)snprintf(to + strlen(to), sizeof bench.told - strlen(to), "%s %s %s;", misfit->key,
                   misfit->found == NULL ? "-" : misfit->found,
                   misfit->expected == NULL ? "-" : misfit->expected);
}

static void tell_what(void *ctx, const char *what)
{
    char *to = ctx;
    (void)snprintf(to + strlen(to), sizeof bench.told - strlen(to), "%s;", what);
}

static int compare(const char *name, struct ram_nvm *nvm)
{
    bench.told[0] = '\0';
    return dg_model_stamp_compare(stamp_of(name), ram_nvm_port(nvm), tell_misfit, bench.told);
}

static int convert(const char *name)
{
    (void)deliver(name, &bench.to);
    bench.told[0] = '\0';
    return dg_model_stamp_convert(stamp_of(name), ram_nvm_port(&bench.from),
                                  ram_nvm_port(&bench.to), tell_what, bench.told);
}

/* Behind the regions of its protocol, and nothing else is another one's. */
static void a_text_has_a_layout_of_its_own(void **state)
{
    const struct dg_store_layout *layout = layout_of("la26");
    (void)state;
    assert_int_equal(layout->region_count, DG_BISS_REGION_COUNT + 1);
    assert_string_equal(layout->regions[DG_BISS_REGION_COUNT].name, "figures");
    assert_ptr_equal(layout->regions[0].defaults, dg_biss_layout.regions[0].defaults);
    assert_int_equal(layout->journal_size, dg_biss_layout.journal_size);
    assert_true(layout->id != dg_biss_layout.id);
    assert_string_equal(stamp_of("la26")->figures, "protocol=biss\nmt=0\nst=26\n");
    assert_int_equal(layout_of("slow26")->id, layout->id);
    assert_true(layout_of("la25")->id != layout->id);
    assert_null(layout_of("small-k2"));
    assert_null(layout_of("reel"));
    assert_null(stamp_of("reel"));
    assert_ptr_equal(dg_biss_stack.layout(dg_s3674_biss.model), &dg_biss_layout);
}

static void figures_are_in_the_memory(void **state)
{
    const char *figures = "protocol=biss\nmt=0\nst=26\n";
    (void)state;
    (void)deliver("la26", &bench.from);
    const uint32_t at = dg_store_address(layout_of("la26"), DG_BISS_REGION_COUNT);
    assert_memory_equal(&bench.from.bytes[at], figures, strlen(figures) + 1u);
    assert_int_equal(mount("la26", &bench.from), DG_OK);
    assert_int_equal(mount("slow26", &bench.from), DG_OK);
    assert_int_equal(mount("la25", &bench.from), DG_ERR_FOREIGN);
}

static void others_are_named(void **state)
{
    (void)state;
    (void)deliver("la25", &bench.from);
    assert_int_equal(compare("la25", &bench.from), DG_OK);
    assert_int_equal(compare("la26", &bench.from), DG_ERR_ARGUMENT);
    assert_string_equal(bench.told, "st 25 26;");
    (void)deliver("sin512", &bench.from);
    assert_int_equal(compare("small", &bench.from), DG_ERR_ARGUMENT);
    assert_string_equal(bench.told, "periods 512 1024;memory 112 20;implemented 0 20;");
    (void)deliver("drum", &bench.from);
    assert_int_equal(compare("drum8", &bench.from), DG_ERR_ARGUMENT);
    assert_string_equal(bench.told, "turns 4096 8;");
    assert_int_equal(compare("la26", &bench.from), DG_ERR_FOREIGN);
}

/* A header that is damaged has a copy. */
static void an_image_with_one_header(void **state)
{
    (void)state;
    (void)deliver("la25", &bench.from);
    bench.from.bytes[5] ^= 1u;
    assert_int_equal(compare("la26", &bench.from), DG_ERR_ARGUMENT);
    assert_string_equal(bench.told, "st 25 26;");
}

/* ... and some of another model, of another release. */
static void figures_that_only_one_has(void **state)
{
    (void)state;
    (void)deliver("la25", &bench.from);
    uint8_t *figures = &bench.from.bytes[dg_store_address(layout_of("la25"), DG_BISS_REGION_COUNT)];
    (void)strcpy((char *)figures, "protocol=biss\nmt=0\nlc=1\n");
    assert_int_equal(compare("la26", &bench.from), DG_ERR_ARGUMENT);
    assert_string_equal(bench.told, "st - 26;lc 1 -;");
    figures[20] = 0x1B;
    assert_int_equal(compare("la26", &bench.from), DG_ERR_FOREIGN);
    assert_string_equal(bench.told, "");
}

static void images_without_figures(void **state)
{
    struct dg_nvm nvm = ram_nvm_port(&bench.from);
    (void)state;
    ram_nvm_init(&bench.from, dg_store_size(&dg_biss_layout));
    assert_int_equal(dg_biss_format(nvm), DG_OK);
    assert_int_equal(compare("la26", &bench.from), DG_ERR_OLDER);
    assert_string_equal(bench.told, "");
    assert_int_equal(compare("drum", &bench.from), DG_ERR_FOREIGN);
    ram_nvm_init(&bench.from, dg_store_size(layout_of("la26")));
    assert_int_equal(compare("la26", &bench.from), DG_ERR_FOREIGN);
    bench.from.no_acknowledge = true;
    assert_int_equal(compare("la26", &bench.from), DG_ERR_IO);
}

static void what_a_biss_encoder_keeps(void **state)
{
    (void)state;
    (void)deliver("la25", &bench.from);
    put_byte("la25", &bench.from, DG_BISS_REGION_CONFIG, 0x04);
    put_byte("la25", &bench.from, DG_BISS_REGION_COUNT - 1, 0x5A);
    const struct ram_nvm before = bench.from;
    assert_int_equal(convert("la26"), DG_OK);
    assert_string_equal(bench.told, "");
    assert_int_equal(get("la26", &bench.to, DG_BISS_REGION_CONFIG), 0x04);
    assert_int_equal(get("la26", &bench.to, DG_BISS_REGION_COUNT - 1), 0x5A);
    assert_int_equal(get("la26", &bench.to, DG_BISS_REGION_USER), 0xFF);
    assert_memory_equal(bench.from.bytes, before.bytes, before.size);
    assert_int_equal(compare("la26", &bench.to), DG_OK);
}

/* Of a built-in model nobody knows figures: what depends on none goes on. */
static void what_a_hiperface_encoder_keeps(void **state)
{
    const struct dg_hf_model *figures = dg_hf_model_of(&dg_s3684_rs485);
    (void)state;
    ram_nvm_init(&bench.from, dg_store_size(&dg_hf_layout));
    assert_int_equal(dg_hf_format(figures, ram_nvm_port(&bench.from)), DG_OK);
    assert_int_equal(convert("sin1024"), DG_OK);
    assert_string_equal(bench.told, "position offset;data fields;");
    (void)deliver("sin512", &bench.from);
    put_byte("sin512", &bench.from, DG_HF_REGION_CODES, 0x77);
    put_byte("sin512", &bench.from, DG_HF_REGION_OFFSET, 0x01);
    put_byte("sin512", &bench.from, DG_HF_REGION_USER, 0x33);
    assert_int_equal(convert("sin1024"), DG_OK);
    assert_string_equal(bench.told, "position offset;");
    assert_int_equal(get("sin1024", &bench.to, DG_HF_REGION_CODES), 0x77);
    assert_int_equal(get("sin1024", &bench.to, DG_HF_REGION_USER), 0x33);
    assert_int_equal(get("sin1024", &bench.to, DG_HF_REGION_OFFSET), 0);
    assert_int_equal(get("sin1024", &bench.to, DG_HF_REGION_RESOLUTION), 1024 / 256);
    assert_int_equal(convert("small"), DG_OK);
    assert_string_equal(bench.told, "position offset;data fields;");
    assert_int_equal(get("small", &bench.to, DG_HF_REGION_USER), 0xFF);
}

static void what_a_k3_keeps(void **state)
{
    (void)state;
    (void)deliver("drum", &bench.from);
    put_byte("drum", &bench.from, DG_IB_REGION_DIRECTION, 4);
    put_byte("drum", &bench.from, DG_IB_REGION_CAMS, 0x01);
    put_byte("drum", &bench.from, DG_IB_REGION_TIME, 9);
    assert_int_equal(convert("drum8"), DG_OK);
    assert_string_equal(bench.told, "steps and revolutions;preset and shift;cam programs;");
    assert_int_equal(get("drum8", &bench.to, DG_IB_REGION_DIRECTION), 4);
    assert_int_equal(get("drum8", &bench.to, DG_IB_REGION_CAMS), 0);
    assert_int_equal(get("drum8", &bench.to, DG_IB_REGION_TIME), 9);
}

static void damage_is_not_copied(void **state)
{
    (void)state;
    (void)deliver("la25", &bench.from);
    put_byte("la25", &bench.from, DG_BISS_REGION_CONFIG, 0x04);
    bench.from.bytes[dg_store_address(layout_of("la25"), DG_BISS_REGION_CONFIG)] ^= 1u;
    assert_int_equal(convert("la26"), DG_OK);
    assert_int_equal(get("la26", &bench.to, DG_BISS_REGION_CONFIG), 0);
    (void)deliver("drum", &bench.from);
    assert_int_equal(convert("la26"), DG_ERR_FOREIGN);
}

/* One access to one of the memories fails, whichever: it is told, or the target can be used, and
 * the image stays as it was. */
static void convert_failing(const char *from, const char *to, bool source)
{
    struct failing_nvm failing;
    uint32_t refused = 0;
    int result = DG_ERR_IO;
    (void)deliver(from, &bench.from);
    const struct ram_nvm before = bench.from;
    for (uint32_t n = 0; n == 0 || failing.count >= n; n++) {
        (void)deliver(to, &bench.to);
        const struct dg_nvm image = ram_nvm_port(&bench.from);
        const struct dg_nvm memory = ram_nvm_port(&bench.to);
        result = dg_model_stamp_convert(
            stamp_of(to), source ? failing_nvm_port(&failing, image, n) : image,
            source ? memory : failing_nvm_port(&failing, memory, n), NULL, NULL);
        assert_true(result == DG_OK || result == DG_ERR_IO || result == DG_ERR_FOREIGN);
        refused += result != DG_OK ? 1u : 0u;
        assert_memory_equal(bench.from.bytes, before.bytes, before.size);
        assert_int_equal(mount(to, &bench.to), DG_OK);
    }
    assert_int_equal(result, DG_OK); /* nothing has failed any more */
    assert_true(refused > 0);
}

static void memories_that_fail_do_no_harm(void **state)
{
    (void)state;
    convert_failing("la25", "la26", true);
    convert_failing("la25", "la26", false);
    convert_failing("sin512", "sin1024", true);
    convert_failing("sin512", "sin1024", false);
}

/* Whatever stands where the figures were: other lines, halves of lines, no text. */
static void figures_that_are_none(void **state)
{
    static const struct {
        const char *figures;
        int result;
        const char *told;
    } rows[] = {
        {"", DG_ERR_FOREIGN, ""},
        {"\n", DG_ERR_FOREIGN, ""},
        {"protocol", DG_ERR_FOREIGN, ""},
        {"protocol=biss", DG_ERR_FOREIGN, ""},
        {"protocol=biss\n", DG_ERR_ARGUMENT, "mt - 0;st - 26;"},
        {"protocol=biss\nmt", DG_ERR_ARGUMENT, "mt - 0;st - 26;"},
        {"protocol=biss\nmt\nst=26", DG_ERR_ARGUMENT, "mt - 0;"},
        {"protocol=biss\nmt=0\nst=2", DG_ERR_ARGUMENT, "st 2 26;"},
        {"protocol=biss\nmt=0\nst=27\n", DG_ERR_ARGUMENT, "st 27 26;"},
        {"protocol=biss\nmt=0\nst=26\nx", DG_ERR_ARGUMENT, ""},
        {"protocol=biss\nmt=0\nst=\x7F\n", DG_ERR_FOREIGN, ""},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        (void)deliver("la25", &bench.from);
        char *at =
            (char *)&bench.from.bytes[dg_store_address(layout_of("la25"), DG_BISS_REGION_COUNT)];
        memset(at, 0, DG_MODEL_STAMP_PART);
        (void)strcpy(at, rows[i].figures);
        const int result = compare("la26", &bench.from);
        if (result != rows[i].result || strcmp(bench.told, rows[i].told) != 0) {
            fail_msg("'%s': %d, %s", rows[i].figures, result, bench.told);
        }
        assert_int_equal(
            dg_model_stamp_compare(stamp_of("la26"), ram_nvm_port(&bench.from), NULL, NULL),
            rows[i].result);
    }
    assert_null(dg_model_stamp_of(NULL, NULL));
}

/* Damage of the figures is no fault of an encoder. */
static void nobody_needs_the_figures(void **state)
{
    struct dg_biss self;
    struct dg_world world;
    struct dg_stack_setup setup = deliver("la26", &bench.from);
    (void)state;
    memset(&bench.from.bytes[dg_store_address(layout_of("la26"), DG_BISS_REGION_COUNT)], 0, 20);
    dg_world_init(&world);
    setup.world = &world;
    assert_int_equal(dg_biss_stack.init(&self, &setup), DG_OK);
    assert_int_equal(dg_biss_stack.power_on(&self, 0), DG_OK);
    assert_int_equal(dg_biss_errors(&self, DG_S(1)), 0);
    dg_biss_stack.attach(&self, NULL);
    assert_null(self.store.layout);
    dg_biss_stack.attach(&self, &setup);
    assert_ptr_equal(self.store.layout, layout_of("la26"));
}

/* By it an encoder knows its EEPROM: with another one those of users would be foreign. */
static void a_text_has_the_identifier_that_it_always_had(void **state)
{
    (void)state;
    assert_int_equal(layout_of("la25")->id, 0xA28718AB);
    assert_int_equal(layout_of("sin512")->id, 0xCE9C0948);
    assert_int_equal(layout_of("drum")->id, 0xD64C6B95);
}

/* An SSI encoder has no EEPROM, and so nothing in it has figures. */
static void without_an_eeprom_there_is_no_stamp(void **state)
{
    struct dg_model_stamp stamp = {.memory = NULL};
    (void)state;
    dg_model_stamp_make(&stamp, dg_model_text_of(find("reel")->stack), NULL);
    assert_null(stamp.memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_text_has_a_layout_of_its_own),
        cmocka_unit_test(figures_are_in_the_memory),
        cmocka_unit_test(others_are_named),
        cmocka_unit_test(an_image_with_one_header),
        cmocka_unit_test(figures_that_only_one_has),
        cmocka_unit_test(images_without_figures),
        cmocka_unit_test(what_a_biss_encoder_keeps),
        cmocka_unit_test(what_a_hiperface_encoder_keeps),
        cmocka_unit_test(what_a_k3_keeps),
        cmocka_unit_test(damage_is_not_copied),
        cmocka_unit_test(memories_that_fail_do_no_harm),
        cmocka_unit_test(figures_that_are_none),
        cmocka_unit_test(nobody_needs_the_figures),
        cmocka_unit_test(a_text_has_the_identifier_that_it_always_had),
        cmocka_unit_test(without_an_eeprom_there_is_no_stamp),
    };
    return cmocka_run_group_tests(tests, read_plan, NULL);
}
