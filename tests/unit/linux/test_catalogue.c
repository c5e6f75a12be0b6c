/* SPDX-License-Identifier: MIT */
/*
 * The catalogue of encoders that are sold, in tools/models: all of it is read, all of it says where
 * its figures are from, and what each encoder sends was worked out by hand from these. Gray code: a
 * bit is turned round where the one in front of it is 1; check sums: long division by 1000011, sent
 * inverted.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <dirent.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/hal.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/ssi.h"
#include "frame_row.h"
#include "hf_rig.h"
#include "plan.h"

#define MEMORY_SIZE 32768u
#define FILES_MAX 64u
#define QUARTER (INT64_C(1) << 30)

/* All files of the catalogue. */
struct catalogue {
    struct dg_plan plans[FILES_MAX];
    char paths[FILES_MAX][512];
    size_t count;
};

static int is_of_models(const struct dirent *entry)
{
    return strstr(entry->d_name, ".ini") != NULL;
}

static int read_catalogue(void **state)
{
    static struct catalogue catalogue;
    struct dirent **entries = NULL;
    const int count = scandir(CATALOGUE, &entries, is_of_models, alphasort);
    assert_in_range(count, 1, FILES_MAX);
    for (int i = 0; i < count; i++) {
        struct lx_error error;
        char *path = catalogue.paths[i];
        (void)snprintf(path, sizeof catalogue.paths[i], CATALOGUE "/%s", entries[i]->d_name);
        if (lx_plan_read(&catalogue.plans[i], path, &error) != 0) {
            fail_msg("%s", lx_error_line(&error).text);
        }
        free(entries[i]);
    }
    free(entries);
    catalogue.count = (size_t)count;
    *state = &catalogue;
    return 0;
}

static int free_catalogue(void **state)
{
    struct catalogue *self = *state;
    for (size_t i = 0; i < self->count; i++) {
        lx_plan_free(&self->plans[i]);
    }
    return 0;
}

static const struct dg_device *find_sold(const struct catalogue *self, const char *name)
{
    const struct dg_device *found = NULL;
    for (size_t i = 0; i < self->count; i++) {
        const struct dg_device *device = dg_plan_find_model(&self->plans[i], name);
        found = device == NULL ? found : device;
    }
    if (found == NULL) {
        fail_msg("%s is not in the catalogue", name);
    }
    return found;
}

static const struct frame_row frames[] = {
    /* BiSS-C at 90 degrees, or 5 turns and 90 degrees: nERR and nWARN are 1 */
    {"rls-la11-26", 1, "01000000000000000000000000 1 1 110011", 0, 0x1000000, NULL, 0, false,
     false},
    {"rls-la11-26", 1, "01000000000000000000000000 0 1 110101", 0, 0x1000000, "watchdog_fired", 1,
     true, false},
    /* the same bits: what is finer than 24 bits is 0 */
    {"rls-la11-24", 1, "010000000000000000000000 00 1 1 110011", 0, 0x400000, NULL, 0, false,
     false},
    {"renishaw-resolute-26", 1, "01000000000000000000000000 1 1 110011", 0, 0x1000000, NULL, 0,
     false, false},
    {"renishaw-resolute-32", 1, "01000000000000000000000000000000 1 1 100001", 0, 0x40000000, NULL,
     0, false, false},
    {"posital-kcd-bc03b-1617", 21, "0000000000000101 01000000000000000 1 1 111111", 5, 0x8000, NULL,
     0, false, false},
    {"lika-amm3616", 21, "000000000101 0100000000000000 1 1 011001", 5, 0x4000, NULL, 0, false,
     false},
    /* its error bit is not used */
    {"lika-amm3616", 21, "000000000101 0100000000000000 1 1 011001", 5, 0x4000, "watchdog_fired", 1,
     false, false},
    {"lika-amm3619", 21, "000000000101 0100000000000000000 1 1 101110", 5, 0x20000, NULL, 0, false,
     false},
    {"lika-smra-14", 1, "01000000000000 1 1 000110", 0, 0x1000, NULL, 0, false, false},
    {"siko-msa213c", 1, "0100000000000000000000000 1 1 011111", 0, 0x800000, NULL, 0, false, false},
    {"siko-msa213c", 1, "0100000000000000000000000 0 1 011001", 0, 0x800000, "watchdog_fired", 1,
     true, false},
    /* a 1 is an error */
    {"broadcom-as37-h39b", 21, "0000000000000101 01000000000000000000000 0 1 110011", 5, 0x200000,
     NULL, 0, false, false},
    {"broadcom-as37-h39b", 21, "0000000000000101 01000000000000000000000 1 1 110101", 5, 0x200000,
     "watchdog_fired", 1, true, false},
    /* SSI */
    {"rls-la11-26-ssi", 1, "01000000000000000000000000", 0, 0x1000000, NULL, 0, false, false},
    {"posital-ucd-s101b-1416", 21, "00000000000101 0100000000000000", 5, 0x4000, NULL, 0, false,
     false},
    {"posital-ucd-shd1g-0013", 1, "0110000000000 0", 0, 0x800, NULL, 0, false, false},
    {"wachendorff-wdga36e-1218", 21, "000000000000000101 010000000000", 5, 0x400, NULL, 0, false,
     false},
    {"baumer-bmmh30-1213", 21, "0000000000111 111000000000", 5, 0x400, NULL, 0, false, false},
    {"nanotec-asa5618", 21, "0000000000000000 0000000000000101 01000000000000000", 5, 0x8000, NULL,
     0, false, false},
    {"numerik-jena-lak12", 1, "0 01000000000000000000000000000000", 0, 0x40000000, NULL, 0, false,
     false},
    {"kuebler-7063fs2-17", 21, "000000000111 11100000000000000", 5, 0x8000, NULL, 0, false, false},
};

static void frames_of_all(void **state)
{
    static _Alignas(16) unsigned char memory[MEMORY_SIZE];
    for (size_t i = 0; i < DG_COUNT(frames); i++) {
        const struct dg_device *model = find_sold(*state, frames[i].figures);
        struct dg_host *host = dg_host_init(memory, MEMORY_SIZE, model, dg_host_wire_of(model));
        uint64_t now = DG_S(1);
        assert_non_null(host);
        assert_int_equal(dg_host_power(host, 0, true), DG_HOST_OK);
        (void)dg_host_step(host, now);
        frame_row_check(host, &now, &frames[i]);
    }
}

/* A quarter and 5 turns in steps of 1 / 32768; 52h tells the code. */
static void replies_of_hiperface(void **state)
{
    static const uint8_t read_position[] = {0x40, 0x42, 0x02};
    static const uint8_t read_label[] = {0x40, 0x52, 0x12};
    static struct hf_rig rig;
    static const struct {
        const char *name;
        int64_t quarters;
        uint8_t position[7];
        uint8_t type;
    } rows[] = {
        {"sick-srs50", 1, {0x40, 0x42, 0x00, 0x00, 0x20, 0x00, 0x22}, 0x22},
        {"sick-srm50", 21, {0x40, 0x42, 0x00, 0x02, 0xA0, 0x00, 0xA0}, 0x27},
    };
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_device *model = find_sold(*state, rows[i].name);
        assert_int_equal(hf_rig_init(&rig, dg_hf_model_of(model)), DG_OK);
        rig.angle = rows[i].quarters * QUARTER;
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        assert_int_equal(hf_rig_send(&rig, read_position, sizeof read_position), 7);
        assert_memory_equal(rig.reply, rows[i].position, 7);
        assert_int_equal(hf_rig_send(&rig, read_label, sizeof read_label), 7);
        assert_int_equal(rig.reply[3], rows[i].type);
    }
}

static bool is_tested(const struct dg_device *device)
{
    bool tested = device->stack == &dg_hf_stack;
    for (size_t i = 0; i < DG_COUNT(frames); i++) {
        tested = tested || strcmp(frames[i].figures, device->name) == 0;
    }
    return tested;
}

/* No row without a source, what is not modelled, and a frame above. */
static void all_say_where_they_are_from(void **state)
{
    const struct catalogue *self = *state;
    size_t count = 0;
    for (size_t i = 0; i < self->count; i++) {
        for (size_t j = 0; j < self->plans[i].model_count; j++) {
            const struct dg_plan_model *row = &self->plans[i].models[j];
            if (row->source == NULL || row->unmodelled == NULL || !is_tested(row->device)) {
                fail_msg("%s: %s has no source, no unmodelled or no frame", self->paths[i],
                         row->device->name);
            }
            assert_ptr_equal(find_sold(self, row->device->name), row->device); /* and no rival */
            count++;
        }
        assert_int_equal(self->plans[i].encoder_count, 0);
    }
    assert_in_range(count, 8, 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_of_all),
        cmocka_unit_test(replies_of_hiperface),
        cmocka_unit_test(all_say_where_they_are_from),
    };
    return cmocka_run_group_tests(tests, read_catalogue, free_catalogue);
}
