/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "drehgeber/hal.h"
#include "motion_model.h"
#include "motion_words.h"
#include "record.h"
#include "stderr_heard.h"
#include "timer.h"

#define START DG_S(1000)
#define STOPPED ((struct lx_clock){.virtual_ = START})

/* A folder of its own with one file, an event loop and a shaft for each test. */
struct place {
    char folder[32];
    char path[64];
    sd_event *event;
    struct lx_clock clock;
    struct dg_shaft shaft;
};

static int set_up(void **state)
{
    struct place *self = calloc(1, sizeof *self);
    assert_non_null(self);
    (void)strcpy(self->folder, "/tmp/test_record.XXXXXX");
    assert_non_null(mkdtemp(self->folder));
    (void)snprintf(self->path, sizeof self->path, "%s/shaft.csv", self->folder);
    assert_true(sd_event_new(&self->event) >= 0);
    self->clock = STOPPED;
    dg_shaft_init(&self->shaft);
    *state = self;
    return 0;
}

/* rmdir() fails when a test leaves anything but its file behind. */
static int tear_down(void **state)
{
    struct place *self = *state;
    (void)unlink(self->path);
    (void)sd_event_unref(self->event);
    const int result = rmdir(self->folder);
    free(self);
    return result;
}

static struct lx_record *opened_as(struct place *place, const char *path, dg_ns interval)
{
    const struct lx_record_setup setup = {path,          &place->shaft, place->event,
                                          &place->clock, interval,      NULL};
    struct lx_error error = {.right = ""};
    struct lx_record *record = lx_record_open(&setup, START, &error);
    assert_string_equal(lx_error_line(&error).text, "");
    assert_non_null(record);
    return record;
}

static struct lx_record *opened(struct place *place, dg_ns interval)
{
    return opened_as(place, place->path, interval);
}

static void closed(struct lx_record *record, dg_ns now)
{
    struct lx_error error = {.right = ""};
    assert_int_equal(lx_record_close(record, now, &error), 0);
}

static struct lx_shaft read_back(const struct place *place)
{
    struct lx_shaft recording;
    struct lx_error error = {.right = ""};
    assert_int_equal(lx_shaft_parse(&recording, place->path, NULL, &error), 0);
    return recording;
}

/* splitmix64 */
static void the_file_by_hand(void **state)
{
    struct place *place = *state;
    char text[200] = "";
    (void)dg_shaft_set_velocity(&place->shaft, START, -60000);
    closed(opened(place, DG_MS(250)), START + DG_MS(999));
    FILE *file = fopen(place->path, "re");
    assert_non_null(file);
    assert_true(fread(text, 1, sizeof text - 1, file) > 0);
    (void)fclose(file);
    assert_string_equal(text, "time_s,angle_deg\n"
                              "0.000000000,0.000000000\n"
                              "0.250000000,-90.000000000\n"
                              "0.500000000,-180.000000000\n"
                              "0.750000000,-270.000000000\n");
}

/* Random angles of the whole range come back as they were, to the last unit. */
static void angles_read_back_the_same(void **state)
{
    enum { COUNT = 20000 };
    static dg_angle angles[COUNT];
    const dg_angle most = INT64_C(16666666) * DG_TURN;
    struct place *place = *state;
    uint64_t seed = 1;
    angles[0] = most;
    angles[1] = -most;
    for (size_t i = 2; i < COUNT; i++) {
        angles[i] = (dg_angle)random_bits(&seed) >> (random_bits(&seed) % 64);
        angles[i] %= most;
    }
    (void)dg_shaft_set_position(&place->shaft, START, angles[0]);
    struct lx_record *record = opened(place, DG_MS(1));
    for (size_t i = 1; i < COUNT; i++) {
        (void)dg_shaft_set_position(&place->shaft, START + DG_MS(i), angles[i]);
        lx_record_write(record, START + DG_MS(i));
    }
    closed(record, START + DG_MS(COUNT) - 1);
    struct lx_shaft recording = read_back(place);
    assert_int_equal(recording.motion.point_count, COUNT);
    for (size_t i = 0; i < COUNT; i++) {
        assert_true(recording.points[i].at == DG_MS(i));
        assert_true(recording.points[i].angle == angles[i]);
    }
    lx_shaft_free(&recording);
}

/* A steered shaft, recorded and replayed: equal at every moment of the grid. */
static void a_recording_is_replayed(void **state)
{
    enum { COUNT = 5000 };
    static dg_angle angles[COUNT];
    const dg_ns interval = DG_US(300);
    struct place *place = *state;
    uint64_t seed = 2;
    (void)dg_shaft_set_acceleration(&place->shaft, 600000);
    struct lx_record *record = opened(place, interval);
    for (size_t i = 0; i < COUNT; i++) {
        const dg_ns now = START + i * interval;
        angles[i] = dg_shaft_angle(&place->shaft, now);
        /* Commands between two lines, seldom and at times several. */
        for (dg_ns later = 1; later < interval && random_bits(&seed) % 50 == 0; later *= 10) {
            const dg_angle target = (dg_angle)(random_bits(&seed) % 1000) * DG_TURN / 99;
            (void)dg_shaft_move(&place->shaft, now + later, target, 3000000);
            lx_record_write(record, now + later);
        }
    }
    closed(record, START + COUNT * interval - 1);
    struct lx_shaft recording = read_back(place);
    assert_int_equal(recording.motion.point_count, COUNT);
    struct dg_shaft replayed;
    dg_shaft_init(&replayed);
    assert_int_equal(dg_shaft_play(&replayed, DG_S(5), &recording.motion), DG_OK);
    for (size_t i = 0; i < COUNT; i++) {
        assert_true(dg_shaft_angle(&replayed, DG_S(5) + i * interval) == angles[i]);
    }
    lx_shaft_free(&recording);
}

/* Let so many wake-ups happen: one at least every 10 ms, or the test hangs and is ended. */
static void run(struct place *place, int wake_ups)
{
    for (int i = 0; i < wake_ups; i++) {
        assert_true(sd_event_run(place->event, UINT64_MAX) > 0);
    }
}

static void start_clock(struct place *place, dg_ns at, uint32_t permille)
{
    place->clock = (struct lx_clock){.real = lx_now(), .virtual_ = at, .permille = permille};
}

/* What wake-ups write is on the grid, whenever they come, and however time goes: in real time, not
 * at all, by a step longer than what one wake-up writes, and much faster. */
static void wake_ups_write_the_grid(void **state)
{
    enum { STEPPED = 2500 };
    struct place *place = *state;
    (void)dg_shaft_set_velocity(&place->shaft, START, 60000);
    start_clock(place, START, 1000);
    struct lx_record *record = opened(place, DG_MS(1));
    run(place, 20);
    const dg_ns stopped = lx_clock_now(&place->clock);
    start_clock(place, stopped, 0);
    run(place, 3);
    const dg_ns stepped = stopped + DG_MS(STEPPED);
    start_clock(place, stepped, 0);
    run(place, 5);
    start_clock(place, stepped, 100000);
    run(place, 5);
    const dg_ns end = lx_clock_now(&place->clock);
    /* Nothing is due at START: all lines are of wake-ups. */
    closed(record, START);
    struct lx_shaft recording = read_back(place);
    assert_true(recording.motion.point_count > (stepped - START) / DG_MS(1));
    assert_true(recording.motion.point_count <= (end - START) / DG_MS(1) + 1);
    for (size_t i = 0; i < recording.motion.point_count; i++) {
        assert_true(recording.points[i].at == DG_MS(i));
        assert_true(recording.points[i].angle == dg_shaft_angle(&place->shaft, START + DG_MS(i)));
    }
    lx_shaft_free(&recording);
}

/* What goes to stderr while `record` writes up to `now`. */
static void write_and_listen(struct lx_record *record, dg_ns now, char *said, size_t size)
{
    struct stderr_heard heard;
    stderr_hear(&heard);
    for (dg_ns at = START; at <= now; at += DG_MS(100)) {
        lx_record_write(record, at);
    }
    stderr_heard(&heard, said, size);
}

/* The hand of its user may follow a link. */
static struct lx_record *opened_on_full_disk(struct place *place)
{
    char path[80];
    (void)snprintf(path, sizeof path, "%s/full.csv", place->folder);
    assert_int_equal(symlink("/dev/full", path), 0);
    struct lx_record *record = opened_as(place, path, DG_MS(1));
    assert_int_equal(unlink(path), 0);
    return record;
}

static void a_full_disk_is_said_once(void **state)
{
    struct place *place = *state;
    struct lx_error error = {.right = ""};
    char said[1000];
    struct lx_record *record = opened_on_full_disk(place);
    write_and_listen(record, START + DG_S(2), said, sizeof said);
    assert_non_null(strstr(said, "/full.csv: the recording ends at 0."));
    assert_non_null(strstr(said, "No space left on device\n"));
    assert_ptr_equal(strchr(said, '\n'), said + strlen(said) - 1);
    assert_int_equal(sd_event_run(place->event, 15000), 0); /* no wake-up brings it back */
    assert_int_equal(lx_record_close(record, START + DG_S(9), &error), -1);
    assert_non_null(strstr(lx_error_line(&error).text, "No space left on device"));
}

/* Few lines: the disk is found full when they are written at the end. */
static void a_full_disk_is_found_at_the_end(void **state)
{
    struct lx_error error = {.right = ""};
    struct lx_record *record = opened_on_full_disk(*state);
    assert_int_equal(lx_record_close(record, START, &error), -1);
    assert_non_null(
        strstr(lx_error_line(&error).text, "/full.csv: cannot write: No space left on device"));
}

static void angles_that_cannot_be_read_back_end_it(void **state)
{
    struct place *place = *state;
    struct lx_error error = {.right = ""};
    char said[1000];
    char folder_path[80];
    struct lx_record *record;
    (void)snprintf(folder_path, sizeof folder_path, "%s/far.csv", place->folder);
    (void)dg_shaft_set_position(&place->shaft, START + DG_MS(3), INT64_C(-16666666) * DG_TURN - 1);
    record = opened_as(place, folder_path, DG_MS(1));
    write_and_listen(record, START + DG_S(1), said, sizeof said);
    assert_non_null(strstr(said, "ends at 0.003000000 s: a recording holds up to 6000000000 deg"));
    assert_int_equal(lx_record_close(record, START + DG_S(1), &error), -1);
    (void)rename(folder_path, place->path);
    struct lx_shaft recording = read_back(place);
    assert_int_equal(recording.motion.point_count, 3);
    lx_shaft_free(&recording);
}

/* A clock so fast that ten million lines are due at once: nobody wants them. One less would be. */
static void more_lines_than_anybody_wants_end_it(void **state)
{
    struct place *place = *state;
    struct lx_error error = {.right = ""};
    struct stderr_heard heard;
    char said[256];
    char wanted[256];
    struct lx_record *record = opened(place, DG_US(100));
    stderr_hear(&heard);
    lx_record_write(record, START + 10000002 * DG_US(100));
    lx_record_write(record, START + 10000003 * DG_US(100));
    stderr_heard(&heard, said, sizeof said);
    (void)snprintf(
        wanted, sizeof wanted,
        "drehgeber: %s: the recording ends at 0.000100000 s: too many lines at once; use a "
        "longer interval or a slower clock\n",
        place->path);
    assert_string_equal(said, wanted);
    assert_int_equal(lx_record_close(record, START + DG_S(1001), &error), -1);
    assert_memory_equal(error.what, wanted + strlen("drehgeber: "), strlen(error.what));
    struct lx_shaft recording = read_back(place);
    assert_int_equal(recording.motion.point_count, 1);
    lx_shaft_free(&recording);
}

static void what_cannot_be_recorded(void **state)
{
    struct place *place = *state;
    struct lx_record_setup setup = {place->path,   &place->shaft,  place->event,
                                    &place->clock, DG_US(100) - 1, NULL};
    struct lx_error error = {.right = ""};
    assert_null(lx_record_open(&setup, START, &error));
    assert_non_null(strstr(lx_error_line(&error).text, "every 100 us to 1 h, not every 99999 ns"));
    setup.interval = DG_S(3600) + 1;
    assert_null(lx_record_open(&setup, START, &error));
    setup.interval = DG_S(3600);
    setup.path = "/no/such/folder/shaft.csv";
    assert_null(lx_record_open(&setup, START, &error));
    assert_string_equal(lx_error_line(&error).text,
                        "/no/such/folder/shaft.csv: cannot open: No such file or directory");
    assert_int_equal(lx_record_close(NULL, START, &error), 0);
    lx_record_write(NULL, START);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_file_by_hand, set_up, tear_down),
        cmocka_unit_test_setup_teardown(angles_read_back_the_same, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_recording_is_replayed, set_up, tear_down),
        cmocka_unit_test_setup_teardown(wake_ups_write_the_grid, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_full_disk_is_said_once, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_full_disk_is_found_at_the_end, set_up, tear_down),
        cmocka_unit_test_setup_teardown(angles_that_cannot_be_read_back_end_it, set_up, tear_down),
        cmocka_unit_test_setup_teardown(more_lines_than_anybody_wants_end_it, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_cannot_be_recorded, set_up, tear_down),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
