/* SPDX-License-Identifier: MIT */
/*
 * A plant of packed buses that share shafts, with faults by SCPI, EEPROM writes and a bus that is
 * traced, in a simulation whose library is a fake: what its buses say is the same for any number of
 * threads, and of rigs that it is spread over. Built with ThreadSanitizer it shows that no two
 * threads meet:
 *
 *   cmake -B build/tsan -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS=-fsanitize=thread
 *   cmake --build build/tsan --target test_silkit_lanes && build/tsan/tests/test_silkit_lanes
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "drehgeber/bits.h"
#include "rig.h"
#include "silkit/fake.h"
#include "timer.h"

#define MS UINT64_C(1000000)
#define BUSES 8u
#define NODES 3u
#define STEPS 700u
#define STARTED 520u /* nodes have booted */
/* Their EEPROMs are files, and a disk takes its own time: what they say is no part of it. */
#define SAVING 2u
/* It is traced. */
#define TRACED 5u
#define TEXT_MAX 8192u

static const struct lx_say quiet = {.quiet = true};

struct part {
    char folder[32];
    struct dg_plan plan;
    sd_event *event;
    struct lx_rig *rig;
    struct fake_silkit *fake;
    int client[2]; /* of its control plane; the first one of EEPROM files, as it may wait for them
                    */
};

/* What a plant has said. */
struct said {
    uint64_t bus[BUSES];
    unsigned count[BUSES];
    char trace[1u << 18u];
};

/* --- the rig --- */

static void add(char *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void add(char *text, const char *format, ...)
{
    const size_t n = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text + n, TEXT_MAX - n, format, arguments);
    va_end(arguments);
    assert_true(strlen(text) < TEXT_MAX - 1u);
}

static void add_bus(char *text, const char *folder, unsigned bus)
{
    add(text, "[bus b%u]\nwire = silkit\naddress = silkit://127.0.0.1:1,b%u\nframes = packed\n",
        bus, bus);
    if (bus == TRACED) {
        add(text, "trace = %s/b.log\n", folder);
    }
    for (unsigned i = 1; i <= NODES; i++) {
        add(text, "[encoder e%u-%u]\nmodel = f3668\nbus = b%u\nnode = %u\nshaft = s%u\n", bus, i,
            bus, i, (bus + i) % 3u);
        if (bus < SAVING) {
            add(text, "nvm = %s/%u-%u.nvm\n", folder, bus, i);
        }
    }
}

static void write_plan(const struct part *self, unsigned threads, unsigned from, unsigned to)
{
    char path[64];
    char text[TEXT_MAX] = "";
    add(text, "[rig]\nname = cell\ncontrol = unix:%s/rig.sock\nthreads = %u\n", self->folder,
        threads);
    add(text, "[shaft s0]\nmotion = 60RPM\n[shaft s1]\nmotion = SINE:30DEG,2S\n"
              "[shaft s2]\ndriver = s0\nratio = 1:2\n");
    for (unsigned bus = from; bus < to; bus++) {
        add_bus(text, self->folder, bus);
    }
    (void)snprintf(path, sizeof path, "%s/rig.ini", self->folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static int reach(const struct part *self)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    (void)snprintf(at.sun_path, sizeof at.sun_path, "%s/rig.sock", self->folder);
    const int client = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_true(client >= 0);
    assert_int_equal(connect(client, (const struct sockaddr *)&at, sizeof at), 0);
    return client;
}

static void open_part(struct part *self, unsigned threads, unsigned from, unsigned to)
{
    struct lx_error error;
    char path[64];
    *self = (struct part){.folder = "/tmp/lanes.XXXXXX"};
    lx_time_own(); /* each plant begins at the same moment */
    void *library = dlopen(FAKE_SILKIT, RTLD_NOW);
    assert_non_null(library);
    self->fake = dlsym(library, "fake_silkit");
    assert_non_null(self->fake);
    *self->fake = (struct fake_silkit){.refuses = NULL};
    assert_int_equal(setenv("DREHGEBER_SILKIT_LIBRARY", FAKE_SILKIT, 1), 0);
    assert_non_null(mkdtemp(self->folder));
    write_plan(self, threads, from, to);
    (void)snprintf(path, sizeof path, "%s/rig.ini", self->folder);
    assert_int_equal(lx_plan_read(&self->plan, path, &error), 0);
    assert_true(sd_event_new(&self->event) >= 0);
    const struct lx_rig_setup setup = {.event = self->event, .say = &quiet, .plan = &self->plan};
    assert_int_equal(lx_rig_open(&self->rig, &setup, lx_now(), &error), LX_RIG_OK);
    self->client[0] = reach(self);
    self->client[1] = reach(self);
}

static void close_rig(struct part *self)
{
    struct lx_error error;
    assert_int_equal(close(self->client[0]), 0);
    assert_int_equal(close(self->client[1]), 0);
    assert_int_equal(lx_rig_close(self->rig, &error), 0);
    lx_plan_free(&self->plan);
    self->event = sd_event_unref(self->event);
}

static void remove_files(const struct part *self)
{
    char command[64];
    (void)snprintf(command, sizeof command, "rm -r %s", self->folder);
    assert_int_equal(system(command), 0);
}

/* --- its life --- */

static void run(const struct part *self)
{
    do {
        while (sd_event_run(self->event, 0) > 0) {
        }
    } while (lx_rig_step(self->rig));
}

static struct fake_topic *topic(const struct part *self, unsigned bus, const char *last)
{
    char name[32];
    (void)snprintf(name, sizeof name, "b%u/%s", bus, last);
    for (unsigned i = 0; i < self->fake->topics; i++) {
        if (strcmp(self->fake->topic[i].topic, name) == 0) {
            return &self->fake->topic[i];
        }
    }
    fail_msg("no topic %s", name);
    return NULL;
}

static void send_frame(const struct part *self, unsigned bus, uint64_t at, uint16_t id,
                       const char *data, uint8_t n)
{
    uint8_t bytes[28] = {[8] = 1};
    const struct fake_topic *to = topic(self, bus, "frames/to");
    const struct lx_sk_data_event event = {.timestamp = at, .data = {bytes, 20u + n}};
    dg_store_le16(bytes + 16, id);
    bytes[18] = n;
    memcpy(bytes + 20, data, n);
    to->handler(to->ctx, NULL, &event);
}

static void turn_shaft(const struct part *self, uint64_t at)
{
    uint8_t bytes[16] = {0};
    dg_store_le64(bytes, at << 8u);
    dg_store_le64(bytes + 8, at << 10u);
    for (unsigned i = 0; i < self->fake->topics; i++) {
        const struct fake_topic *to = &self->fake->topic[i];
        const struct lx_sk_data_event event = {.timestamp = at, .data = {bytes, sizeof bytes}};
        if (strcmp(to->topic, "cell/shaft/s0/turn") == 0) {
            to->handler(to->ctx, NULL, &event);
        }
    }
}

/* Each command comes between two steps; its fault ends by itself, at its own moment. */
static void command(const struct part *self, unsigned bus)
{
    char text[128];
    const int n = snprintf(text, sizeof text,
                           "INST:SEL e%u-2;:FAUL:SET temperature_high,DUR 12500US;:FAUL:SET "
                           "wire_drop,COUN 2\nINST:SEL e%u-1;:NVM:CORR serial\n",
                           bus, bus);
    assert_int_equal(write(self->client[bus < SAVING ? 0 : 1], text, (size_t)n), n);
}

/* Not all buses in each step; those of a step in the other order, as it is nobody's. */
static void send_frames(const struct part *self, unsigned bus, unsigned step)
{
    static const char save[] = "\x23\x10\x10\x01save";
    const uint64_t at = step * MS - MS / 2u * (bus % 2u);
    if (step == STARTED) {
        send_frame(self, bus, at, 0, "\x01\x00", 2);
    }
    if (step > STARTED && (step + bus) % 3u == 0) {
        send_frame(self, bus, at, 0x80, "", 0);
    }
    if (step > STARTED && (step + bus) % 7u == 0) {
        send_frame(self, bus, at, 0x602, "\x40\x04\x60\0\0\0\0", 8);
    }
    if (bus < SAVING && step > STARTED && step % 20u == 0) {
        send_frame(self, bus, at, (uint16_t)(0x601u + step / 20u % NODES), save, 8);
    }
}

static void live(const struct part *self, unsigned from, unsigned to)
{
    self->fake->ready(self->fake->ctx, NULL);
    run(self);
    for (unsigned step = 0; step < STEPS; step++) {
        self->fake->step(self->fake->ctx, NULL, step * MS, MS);
        run(self);
        for (unsigned bus = to; bus-- > from;) {
            send_frames(self, bus, step);
            if (step > STARTED && step % 40u == bus % 4u * 10u) {
                command(self, bus);
            }
        }
        if (step > STARTED && step % 10u == 0) {
            turn_shaft(self, step * MS - MS / 4u);
        }
    }
}

/* While the rig is there: names of topics are its own. */
static void note_buses(const struct part *self, unsigned from, unsigned to, struct said *said)
{
    for (unsigned bus = from; bus < to; bus++) {
        said->bus[bus] = topic(self, bus, "frames")->hash;
        said->count[bus] = topic(self, bus, "frames")->count;
    }
}

/* When the rig is closed: then all of it is written. */
static void note_trace(const struct part *self, unsigned from, unsigned to, struct said *said)
{
    char path[64];
    if (from <= TRACED && TRACED < to) {
        (void)snprintf(path, sizeof path, "%s/b.log", self->folder);
        FILE *file = fopen(path, "r");
        assert_non_null(file);
        said->trace[fread(said->trace, 1, sizeof said->trace - 1u, file)] = '\0';
        assert_int_equal(fclose(file), 0);
    }
}

/* --- tests --- */

static struct said *live_in(unsigned rigs, unsigned threads)
{
    struct said *said = calloc(1, sizeof *said);
    assert_non_null(said);
    for (unsigned i = 0; i < rigs; i++) {
        const unsigned from = i * BUSES / rigs;
        const unsigned to = (i + 1u) * BUSES / rigs;
        struct part part;
        open_part(&part, threads, from, to);
        live(&part, from, to);
        note_buses(&part, from, to, said);
        close_rig(&part);
        note_trace(&part, from, to, said);
        remove_files(&part);
    }
    return said;
}

static void nothing_depends_on_threads_and_rigs(void **state)
{
    static const struct {
        unsigned rigs, threads;
    } rows[] = {{1, 1}, {1, 2}, {1, 4}, {1, 64}, {2, 3}, {4, 1}, {8, 2}};
    struct said *first = live_in(1, 2);
    (void)state;
    for (unsigned bus = 0; bus < BUSES; bus++) {
        assert_in_range(first->count[bus], 60, STEPS);
    }
    assert_int_not_equal(first->bus[SAVING], first->bus[SAVING + 1u]);
    assert_true(strlen(first->trace) > 10000);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct said *other = live_in(rows[i].rigs, rows[i].threads);
        for (unsigned bus = SAVING; bus < BUSES; bus++) {
            assert_int_equal(other->bus[bus], first->bus[bus]);
            assert_int_equal(other->count[bus], first->count[bus]);
        }
        assert_string_equal(other->trace, first->trace);
        free(other);
    }
    free(first);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_depends_on_threads_and_rigs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
