/* SPDX-License-Identifier: MIT */
/* What is said of an EEPROM file, to the word: when it is refused, when it is taken although it is
   not whole, and when something becomes of it while it is in use. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "drehgeber/devices.h"
#include "eeprom_rig.h"
#include "stderr_heard.h"

static int set_up(void **state)
{
    const int result = eeprom_place_set_up(state);
    struct eeprom_place *place = *state;
    place->loud = true;
    return result;
}

/* --- refused --- */

static void is_refused(struct eeprom_place *place, const char *says)
{
    struct eeprom eeprom;
    struct lx_error error = {.right = ""};
    char line[256];
    (void)snprintf(line, sizeof line, "%s: %s", place->path, says);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), -1);
    eeprom_close(&eeprom);
    assert_string_equal(lx_error_line(&error).text, line);
}

#define GIVE "; give a file made by drehgeber, or the name of a new one"

static void what_is_no_image_is_named(void **state)
{
    static uint8_t bytes[16384];
    struct eeprom_place *place = *state;
    const uint32_t size = dg_store_size(&dg_hf_layout);
    char line[128];
    assert_true(size < sizeof bytes);
    eeprom_write_bytes(place->path, bytes, 0);
    (void)snprintf(line, sizeof line, "0 bytes, an image of this encoder has %u" GIVE, size);
    is_refused(place, line);
    eeprom_write_bytes(place->path, bytes, size + 1u);
    (void)snprintf(line, sizeof line, "%u bytes, an image of this encoder has %u" GIVE, size + 1u,
                   size);
    is_refused(place, line);
    eeprom_write_bytes(place->path, bytes, size);
    is_refused(place, "something else, no image of this kind of encoder" GIVE);
    memset(bytes, 0xFF, size);
    eeprom_write_bytes(place->path, bytes, size);
    is_refused(place, "blank, no image of this kind of encoder" GIVE);
    assert_int_equal(unlink(place->path), 0);
    assert_int_equal(mkfifo(place->path, 0600), 0);
    is_refused(place, "not a regular file; give the name of a new one");
}

/* Whose figures it has: one as it can be ordered, or nobody's; the first of them that differs. */
static void an_image_of_another_encoder_says_whose_it_is(void **state)
{
    static const char right[] =
        "run that one with the same settings, or give the name of a new file";
    struct eeprom_place *place = *state;
    const struct dg_hf_model own = place->model;
    struct dg_hf_model others[] = {own, own, own, own, own};
    static const char *const what[] = {"periods, steps or turns", "type code or option",
                                       "user memory size", "implemented memory", "type label"};
    char line[256];
    eeprom_make(place);
    others[0].periods_per_turn = 1024;
    others[1].type_code = 0x28;
    others[2].memory_blocks = 22;
    others[3].implemented_blocks = 128;
    (void)strcpy(others[4].designation, "other");
    for (size_t i = 0; i < DG_COUNT(others); i++) {
        place->model = others[i];
        (void)snprintf(line, sizeof line, "belongs to s3684-rs485 (%s differs); %s", what[i],
                       right);
        is_refused(place, line);
    }
    assert_int_equal(unlink(place->path), 0);
    place->model = others[2];
    eeprom_make(place);
    place->model = own;
    (void)snprintf(
        line, sizeof line,
        "belongs to an encoder with other factory figures (user memory size differs); %s", right);
    is_refused(place, line);
}

static void an_image_of_another_unit_says_its_serial_number(void **state)
{
    struct eeprom_place *place = *state;
    (void)strcpy(place->model.serial, "000000005");
    eeprom_make(place);
    place->serial_given = true;
    place->serial = 5;
    eeprom_make(place);
    place->serial = 6;
    is_refused(place, "belongs to serial number 5; run that one, or give the name of a new file");
    place->serial_given = false;
    eeprom_make(place); /* whoever gives none takes it as it is */
}

static void a_file_in_use_says_by_whom(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    is_refused(place, "in use by another encoder, trace or recording; give every encoder a file of "
                      "its own");
    eeprom_close(&eeprom);
}

/* --- taken --- */

/* Open it. What is said then, behind its name; "": nothing. */
static void is_taken(struct eeprom *eeprom, struct eeprom_place *place, const char *says)
{
    struct stderr_heard heard;
    struct lx_error error;
    char said[256];
    char wanted[256] = "";
    if (says[0] != '\0') {
        (void)snprintf(wanted, sizeof wanted, "drehgeber: %s: %s\n", place->path, says);
    }
    stderr_hear(&heard);
    const int result = eeprom_open(eeprom, place->path, place, &error);
    stderr_heard(&heard, said, sizeof said);
    assert_int_equal(result, 0);
    assert_string_equal(said, wanted);
}

static void what_is_cut_off_is_told(void **state)
{
    struct eeprom_place *place = *state;
    const uint32_t size = dg_store_size(&dg_hf_layout);
    struct eeprom eeprom;
    char says[128];
    is_taken(&eeprom, place, "");
    eeprom_close(&eeprom);
    is_taken(&eeprom, place, "");
    eeprom_close(&eeprom);
    assert_int_equal(truncate(place->path, size - 1), 0);
    (void)snprintf(says, sizeof says, "truncated, %u of %u bytes; missing bytes read FFh",
                   size - 1u, size);
    is_taken(&eeprom, place, says);
    eeprom_close(&eeprom);
}

/* As the last release would have written it, had its table ended before "user". */
static void what_will_grow_is_told(void **state)
{
    struct eeprom_place *place = *state;
    struct dg_store_layout older = dg_hf_layout;
    struct eeprom eeprom;
    struct lx_error error;
    char says[128];
    older.region_count--;
    assert_int_equal(eeprom_open(&eeprom, NULL, place, &error), 0);
    assert_int_equal(dg_store_format(&older, eeprom.part.device.nvm, &place->model), DG_OK);
    eeprom_write_bytes(place->path, eeprom.image.memory.bytes, dg_store_size(&older));
    eeprom_close(&eeprom);
    (void)snprintf(says, sizeof says,
                   "from an earlier release, which can no longer open it: grows from %u to %u "
                   "bytes",
                   dg_store_size(&older), dg_store_size(&dg_hf_layout));
    is_taken(&eeprom, place, says);
    eeprom_close(&eeprom);
}

/* A memory that takes a few writes, and none behind them. */
struct ending {
    struct dg_nvm below;
    unsigned writes;
};

static int read_through(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct ending *self = ctx;
    return self->below.ops->read(self->below.ctx, address, to, n);
}

static int write_a_few(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct ending *self = ctx;
    if (self->writes == 0) {
        return DG_ERR_IO;
    }
    self->writes--;
    return self->below.ops->write(self->below.ctx, address, from, n);
}

static void an_erase_that_was_interrupted_is_told(void **state)
{
    static const struct dg_nvm_ops ops = {.read = read_through, .write = write_a_few};
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    is_taken(&eeprom, place, "");
    struct ending ending = {eeprom.part.device.nvm, 5};
    struct dg_stack_setup setup = eeprom.part.device;
    setup.nvm = (struct dg_nvm){&ops, &ending};
    assert_int_not_equal(eeprom.part.stack->format(&setup), DG_OK);
    eeprom_close(&eeprom);
    is_taken(&eeprom, place, "NVM:ERASe was interrupted, and is completed now");
    eeprom_close(&eeprom);
    is_taken(&eeprom, place, ""); /* it was */
    eeprom_close(&eeprom);
}

/* --- in use --- */

/* Write a byte, or have all of it on the disk. What is said then, behind its name; "": nothing. */
static void is_done(struct eeprom *eeprom, const struct eeprom_place *place, bool sync, bool good,
                    const char *says)
{
    const struct dg_nvm *nvm = &eeprom->part.device.nvm;
    struct stderr_heard heard;
    char said[256];
    char wanted[256] = "";
    if (says[0] != '\0') {
        (void)snprintf(wanted, sizeof wanted, "drehgeber: %s: %s\n", place->path, says);
    }
    stderr_hear(&heard);
    const int result = sync ? nvm->ops->sync(nvm->ctx) : nvm->ops->write(nvm->ctx, 200, "a", 1);
    stderr_heard(&heard, said, sizeof said);
    assert_string_equal(said, wanted);
    assert_int_equal(result, good ? DG_OK : DG_ERR_IO);
}

#define UNTIL "; the encoder answers 05h until it works again"

/* Once when it begins, and once when it is over, which only a sync can know. */
static void a_file_that_is_moved_or_replaced_is_told(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    char aside[80];
    (void)snprintf(aside, sizeof aside, "%s.aside", place->path);
    is_taken(&eeprom, place, "");
    assert_int_equal(rename(place->path, aside), 0);
    is_done(&eeprom, place, false, false, "moved while in use (move it back)" UNTIL);
    is_done(&eeprom, place, false, false, "");
    is_done(&eeprom, place, true, false, "");
    assert_int_equal(rename(aside, place->path), 0);
    is_done(&eeprom, place, false, true, "");
    is_done(&eeprom, place, true, true, "works again");
    is_done(&eeprom, place, true, true, "");
    assert_int_equal(rename(place->path, aside), 0);
    eeprom_write_bytes(place->path, (const uint8_t *)"x", 1);
    is_done(&eeprom, place, true, false,
            "replaced while in use (a restart takes the other one)" UNTIL);
    assert_int_equal(rename(aside, place->path), 0);
    is_done(&eeprom, place, true, true, "works again");
    assert_int_equal(unlink(place->path), 0);
    is_done(&eeprom, place, false, false, "deleted while in use (a restart makes a new one)" UNTIL);
    eeprom_close(&eeprom);
}

static void a_file_that_is_cut_off_is_told(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    is_taken(&eeprom, place, "");
    assert_int_equal(truncate(place->path, 100), 0);
    is_done(&eeprom, place, false, true,
            "truncated to 100 bytes while in use; the whole file is written again");
    is_done(&eeprom, place, false, true, "");
    is_done(&eeprom, place, true, true, "");
    assert_int_equal(eeprom_length_of(place->path), dg_store_size(&dg_hf_layout));
    assert_int_equal(truncate(place->path, 0), 0);
    is_done(&eeprom, place, true, true,
            "truncated to 0 bytes while in use; the whole file is written again");
    assert_int_equal(eeprom_length_of(place->path), dg_store_size(&dg_hf_layout));
    eeprom_close(&eeprom);
}

#define IN_A_PLACE(test) cmocka_unit_test_setup_teardown(test, set_up, eeprom_place_tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_A_PLACE(what_is_no_image_is_named),
        IN_A_PLACE(an_image_of_another_encoder_says_whose_it_is),
        IN_A_PLACE(an_image_of_another_unit_says_its_serial_number),
        IN_A_PLACE(a_file_in_use_says_by_whom),
        IN_A_PLACE(what_is_cut_off_is_told),
        IN_A_PLACE(what_will_grow_is_told),
        IN_A_PLACE(an_erase_that_was_interrupted_is_told),
        IN_A_PLACE(a_file_that_is_moved_or_replaced_is_told),
        IN_A_PLACE(a_file_that_is_cut_off_is_told),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
