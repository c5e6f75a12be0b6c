/* SPDX-License-Identifier: MIT */
/*
 * A rig in a simulation whose library is a fake: what it tells the library of itself, and what it
 * tells the user of the library and of others (docs/silkit.md).
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "drehgeber/bits.h"
#include "memory_file.h"
#include "rig.h"
#include "silkit/fake.h"
#include "stderr_heard.h"
#include "timer.h"

#define MS UINT64_C(1000000)
#define NAME "[rig]\nname = cell\n"
#define HERE "silkit://127.0.0.1:1"
#define CAN NAME "[encoder n]\nmodel = f3668\nwire = silkit:" HERE ",CAN\n"
#define LINE_ENCODER "[encoder l]\nmodel = s3684-rs485\nwire = silkit:" HERE ",LINE\n"
#define LINE NAME LINE_ENCODER
#define REST                                                                                       \
    "[encoder b]\nmodel = s3684-biss\nwire = silkit:" HERE ",CHAIN\n"                              \
    "[encoder i]\nmodel = ocd-ib-k2\nwire = silkit:" HERE ",RING\n"                                \
    "[bus pack]\nwire = silkit\naddress = " HERE ",PACK\nframes = packed\n"                        \
    "[encoder p]\nmodel = f3668\nbus = pack\n"
#define ALL NAME "[shaft axis]\n" LINE_ENCODER "shaft = axis\n" REST

struct bench {
    struct dg_plan plan;
    sd_event *event;
    struct lx_rig *rig;
    struct fake_silkit *fake;
    enum lx_rig_result result;
    struct lx_error error;
};

static void open_bench(struct bench *self, const char *rig, const struct fake_silkit *fake)
{
    static const struct lx_say loud = {.quiet = false};
    static const struct lx_say quiet = {.quiet = true};
    static struct lx_say say;
    void *library = dlopen(FAKE_SILKIT, RTLD_NOW);
    assert_non_null(library);
    *self = (struct bench){.fake = dlsym(library, "fake_silkit"), .error = {.right = ""}};
    assert_non_null(self->fake);
    *self->fake = *fake;
    const char *file = memory_file_write((const uint8_t *)rig, strlen(rig));
    if (lx_plan_read(&self->plan, file, &self->error) != 0) {
        fail_msg("%s", lx_error_line(&self->error).text);
    }
    assert_true(sd_event_new(&self->event) >= 0);
    const struct lx_rig_setup setup = {.event = self->event, .say = &say, .plan = &self->plan};
    say = quiet; /* it has no control plane, and says so */
    self->result = lx_rig_open(&self->rig, &setup, lx_now(), &self->error);
    say = loud;
}

static void close_bench(struct bench *self)
{
    if (self->rig != NULL) {
        assert_int_equal(lx_rig_close(self->rig, &self->error), 0);
    }
    lx_plan_free(&self->plan);
    self->event = sd_event_unref(self->event);
}

/* What the loop of the command does until it would wait. */
static void run(struct bench *self)
{
    do {
        while (sd_event_get_state(self->event) != SD_EVENT_FINISHED &&
               sd_event_run(self->event, 0) > 0) {
        }
    } while (sd_event_get_state(self->event) != SD_EVENT_FINISHED && lx_rig_step(self->rig));
}

static void enter_step(struct bench *self, uint64_t at)
{
    self->fake->step(self->fake->ctx, NULL, at, MS);
    run(self);
}

static void begin(struct bench *self)
{
    assert_int_equal(self->result, LX_RIG_OK);
    self->fake->ready(self->fake->ctx, NULL);
    run(self);
    enter_step(self, 0);
}

static const struct fake_topic *topic(const struct bench *self, const char *name)
{
    for (unsigned i = 0; i < self->fake->topics; i++) {
        if (strcmp(self->fake->topic[i].topic, name) == 0) {
            return &self->fake->topic[i];
        }
    }
    fail_msg("no topic %s", name);
    return NULL;
}

static void publish(struct bench *self, const char *name, size_t n)
{
    static const uint8_t zeros[5000];
    const struct fake_topic *to = topic(self, name);
    const struct lx_sk_data_event event = {.timestamp = 1, .data = {.data = zeros, .size = n}};
    to->handler(to->ctx, NULL, &event);
}

static const struct fake_silkit usual = {.refuses = NULL};

/* --- what the library is told --- */

static void a_participant_has_a_name_a_registry_and_a_time(void **state)
{
    static const struct {
        const char *rig;
        const char *name;
        int mode;
        uint64_t duration;
    } rows[] = {
        {CAN, "cell", LX_SK_COORDINATED, MS},
        {NAME "[encoder n]\nmodel = f3668\nwire = silkit:" HERE ",CAN,bench\nstep_us = 500\n",
         "bench", LX_SK_COORDINATED, MS / 2},
        {CAN "time = autonomous\nstep_us = 1\n", "cell", LX_SK_AUTONOMOUS, 1000},
        {CAN "time = real\n", "cell", LX_SK_AUTONOMOUS, 0},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct bench bench;
        open_bench(&bench, rows[i].rig, &usual);
        assert_int_equal(bench.result, LX_RIG_OK);
        assert_string_equal(bench.fake->participant, rows[i].name);
        assert_string_equal(bench.fake->registry, HERE);
        assert_string_equal(bench.fake->network, "CAN");
        assert_int_equal(bench.fake->mode, rows[i].mode);
        assert_int_equal(bench.fake->duration, rows[i].duration);
        assert_int_equal(bench.fake->configs, 0);
        assert_int_equal(bench.fake->baud, 250000); /* as an F3668 is delivered */
        close_bench(&bench);
        assert_int_equal(bench.fake->left, 1);
    }
}

/* Who has a registry on loopback has its own ports there, too. */
static void ports_are_where_the_registry_is(void **state)
{
    static const struct {
        const char *host;
        bool loopback;
    } rows[] = {{"127.0.0.1", true}, {"127.9.9.9", true},  {"localhost", true},     {"[::1]", true},
                {"h", false},        {"128.0.0.1", false}, {"localhost.org", false}};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct stderr_heard heard;
        struct bench bench;
        char rig[256];
        char said[256];
        char wanted[256] = "";
        char begin_of_ports[128];
        (void)snprintf(rig, sizeof rig,
                       NAME "[encoder n]\nmodel = f3668\nwire = silkit:silkit://%s:1,CAN\n"
                            "aggregate = 0\n",
                       rows[i].host);
        stderr_hear(&heard);
        open_bench(&bench, rig, &usual);
        stderr_heard(&heard, said, sizeof said);
        assert_int_equal(bench.result, LX_RIG_OK);
        if (rows[i].loopback) {
            const char *config = bench.fake->config;
            (void)snprintf(begin_of_ports, sizeof begin_of_ports,
                           "{\"Logging\":{\"Sinks\":[]},\"Middleware\":{\"AcceptorUris\":["
                           "\"local:///tmp/cell-%ld-",
                           (long)getpid());
            assert_ptr_equal(strstr(config, begin_of_ports), config);
            assert_string_equal(strstr(config, ".silkit"), ".silkit\",\"tcp://127.0.0.1:0\"]}}");
        } else {
            assert_string_equal(bench.fake->config, "{\"Logging\":{\"Sinks\":[]}}");
            (void)snprintf(
                wanted, sizeof wanted,
                "drehgeber: silkit://%s:1: beyond loopback; every machine that reaches the ports "
                "of cell can turn its shafts and is on its wires\n",
                rows[i].host);
        }
        assert_string_equal(said, wanted);
        close_bench(&bench);
    }
}

/* The media types of docs/silkit.md. */
static void topics_have_types(void **state)
{
    static const struct {
        const char *topic;
        const char *type;
    } rows[] = {
        {"LINE/request", "application/vnd.drehgeber.characters.v1"},
        {"LINE/reply", "application/vnd.drehgeber.characters.v1"},
        {"CHAIN/latch", "application/vnd.drehgeber.latch.v1"},
        {"CHAIN/frame", "application/vnd.drehgeber.frame.v1"},
        {"RING/out", "application/vnd.drehgeber.interbus.v1"},
        {"RING/in", "application/vnd.drehgeber.interbus.v1"},
        {"PACK/frames/to", "application/vnd.drehgeber.can.v1"},
        {"PACK/frames", "application/vnd.drehgeber.can.v1"},
        {"cell/shaft/axis/turn", "application/vnd.drehgeber.shaft.v1"},
        {"cell/shaft/axis", "application/vnd.drehgeber.shaft.v1"},
    };
    struct bench bench;
    (void)state;
    open_bench(&bench, ALL, &usual);
    assert_int_equal(bench.result, LX_RIG_OK);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_string_equal(topic(&bench, rows[i].topic)->media_type, rows[i].type);
    }
    close_bench(&bench);
}

/* CiA 301, 7.2.8.3.2.1: node guarding asks with a remote frame of one byte. */
static void frames_have_lengths_and_may_be_remote(void **state)
{
    struct lx_sk_frame guard = {.id = 0x73F, .flags = LX_SK_FRAME_REMOTE, .dlc = 1};
    struct lx_sk_frame_event event = {.timestamp = MS, .frame = &guard};
    struct bench bench;
    (void)state;
    open_bench(&bench, CAN, &usual);
    begin(&bench);
    assert_int_equal(bench.fake->frames, 1);
    assert_int_equal(bench.fake->sent[0].id, 0x73F);
    bench.fake->frame(bench.fake->can_ctx, NULL, &event);
    enter_step(&bench, 2 * MS);
    assert_int_equal(bench.fake->frames, 2);
    assert_int_equal(bench.fake->sent[1].id, 0x73F);
    for (size_t i = 0; i < 2; i++) {
        assert_int_equal(bench.fake->sent[i].flags, 0);
        assert_int_equal(bench.fake->sent[i].dlc, 1);
        assert_int_equal(bench.fake->sent[i].size, 1);
    }
    assert_int_equal(bench.fake->sent[0].bytes[0], 0x00);
    assert_int_equal(bench.fake->sent[1].bytes[0], 0x7F); /* pre-operational */
    close_bench(&bench);
}

/* docs/silkit.md, NETWORK/frame: the moment, then 24 bytes for each encoder of the chain. At a
   quarter of a turn 21 bits of singleturn are 2^19. */
static void a_frame_has_all_encoders_of_its_chain(void **state)
{
    static const char chain[] = NAME "[shaft s]\nmotion = 90DEG\n"
                                     "[bus c]\nwire = silkit\naddress = " HERE ",CHAIN\n"
                                     "[encoder x]\nmodel = s3684-biss\nbus = c\nshaft = s\n"
                                     "[encoder y]\nmodel = s3674-biss\nbus = c\nshaft = s\n"
                                     "[encoder z]\nmodel = s3674-biss\nbus = c\nshaft = s\n";
    struct bench bench;
    (void)state;
    open_bench(&bench, chain, &usual);
    begin(&bench);
    enter_step(&bench, 500 * MS);
    const struct fake_topic *frame = topic(&bench, "CHAIN/frame");
    assert_int_equal(frame->size, 8 + 3 * 24);
    for (size_t i = 0; i < 3; i++) {
        const uint8_t *entry = frame->bytes + 8 + 24 * i;
        assert_int_equal(entry[0], 0); /* good */
        assert_int_equal(entry[1], 0);
        assert_int_equal(dg_load_le32(entry + 4), 0);
        assert_int_equal(dg_load_le32(entry + 8), 1u << 19);
        assert_int_equal(dg_load_le32(entry + 12), 0);
    }
    close_bench(&bench);
}

/* --- what the library refuses --- */

/* There is no rig, and the line about it ends so. */
static void ends_in(const struct bench *self, const char *says)
{
    const struct lx_words line = lx_error_line(&self->error);
    assert_true(strlen(line.text) >= strlen(says));
    assert_string_equal(line.text + strlen(line.text) - strlen(says), says);
    assert_int_equal(self->result, LX_RIG_WORLD);
    assert_null(self->rig);
}

static void a_start_that_is_refused_is_one_line_and_leaves_nothing(void **state)
{
    static const struct {
        const char *rig;
        const char *function;
        const char *why;
        const char *says;
        unsigned left; /* a participant that was made */
    } rows[] = {
        {CAN, "config", NULL, ": SIL Kit: no configuration: no luck", 0},
        {CAN, "join", NULL, ": SIL Kit: no luck; start a registry there, e.g. sil-kit-registry", 0},
        {CAN, "join", "it already exists",
         ": SIL Kit: there is a participant cell already; expected " HERE
         ",CAN,PARTICIPANT with another name",
         0},
        {CAN, "lifecycle", NULL, ": SIL Kit: no lifecycle: no luck", 1},
        {CAN, "time", NULL, ": SIL Kit: no virtual time: no luck", 1},
        {CAN, "can", NULL, ": SIL Kit: CAN: no luck", 1},
        {LINE, "subscriber", NULL, ": SIL Kit: LINE/request: no luck", 1},
        {LINE, "publisher", NULL, ": SIL Kit: LINE/reply: no luck", 1},
        {CAN, "start", NULL, "SIL Kit: it does not start: no luck", 1},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct fake_silkit fake = {.refuses = rows[i].function, .why = rows[i].why};
        struct bench bench;
        open_bench(&bench, rows[i].rig, &fake);
        ends_in(&bench, rows[i].says);
        assert_int_equal(bench.fake->configs, 0);
        assert_int_equal(bench.fake->left, rows[i].left);
        close_bench(&bench);
    }
}

static void what_is_refused_later_is_said_once(void **state)
{
    static const struct {
        const char *rig;
        const char *function;
        const char *says;
    } rows[] = {
        {CAN, "send", "drehgeber: SIL Kit: a frame cannot be sent: no luck\n"},
        {CAN, "publish", "drehgeber: SIL Kit: a topic cannot be published: no luck\n"},
        {CAN, "complete", "drehgeber: SIL Kit: a step cannot be completed: no luck\n"},
        {CAN, "baud", "drehgeber: SIL Kit: no such bit rate: no luck\n"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct fake_silkit fake = {.refuses = rows[i].function};
        struct stderr_heard heard;
        struct bench bench;
        char said[512];
        stderr_hear(&heard);
        open_bench(&bench, rows[i].rig, &fake);
        begin(&bench);
        for (uint64_t at = 1; at <= 2000; at += 500) {
            enter_step(&bench, at * MS);
        }
        stderr_heard(&heard, said, sizeof said);
        assert_string_equal(said, rows[i].says);
        close_bench(&bench);
    }
}

/* --- what others do --- */

static void messages_of_another_length_are_told_once_per_topic(void **state)
{
    static const struct {
        const char *topic;
        size_t n;
        const char *says;
    } rows[] = {
        {"LINE/request", 4097,
         "drehgeber: SIL Kit: LINE/request: a message of 4097 bytes is ignored, and so are all others of a wrong "
         "length; expected at most 4096\n"},
        {"LINE/request", 4098, ""},
        {"LINE/request", 4096, ""},
        {"CHAIN/latch", 1,
         "drehgeber: SIL Kit: CHAIN/latch: a message of 1 bytes is ignored, and so are all others of a wrong length; "
         "expected 0\n"},
        {"RING/out", 3,
         "drehgeber: SIL Kit: RING/out: a message of 3 bytes is ignored, and so are all others of a wrong length; "
         "expected 4\n"},
        {"RING/out", 5, ""},
        {"PACK/frames/to", 5,
         "drehgeber: SIL Kit: PACK/frames/to: a message of 5 bytes is ignored, and so are all others of a wrong "
         "length; expected packed frames\n"},
        {"cell/shaft/axis/turn", 17,
         "drehgeber: SIL Kit: cell/shaft/axis/turn: a message of 17 bytes is ignored, and so are all others of a "
         "wrong length; expected 16\n"},
        {"cell/shaft/axis/turn", 15, ""},
    };
    struct bench bench;
    (void)state;
    open_bench(&bench, ALL, &usual);
    begin(&bench);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct stderr_heard heard;
        char said[256];
        publish(&bench, rows[i].topic, rows[i].n);
        stderr_hear(&heard);
        enter_step(&bench, (i + 1u) * MS);
        stderr_heard(&heard, said, sizeof said);
        assert_string_equal(said, rows[i].says);
    }
    close_bench(&bench);
}

enum what { GONE, STOPPED, ABORTED };

static void the_end_of_others_is_told(void **state)
{
    static const struct {
        enum what what;
        const char *name;
        bool begun;
        const char *says;
    } rows[] = {
        {GONE, "drive", true, "drehgeber: SIL Kit: drive has left the simulation\n"},
        {GONE, "drive", false, "drehgeber: SIL Kit: drive has left the simulation\n"},
        {GONE, "SilKitRegistry", true,
         "drehgeber: SIL Kit: the registry has gone; present participants continue, no other can join\n"},
        {GONE, "SilKitRegistry", false,
         "drehgeber: SIL Kit: the registry has gone before the simulation has begun\n"},
        {STOPPED, NULL, true, "drehgeber: SIL Kit: the simulation has ended\n"},
        {ABORTED, NULL, true, "drehgeber: SIL Kit: the simulation was aborted\n"},
        {ABORTED, NULL, false, "drehgeber: SIL Kit: the simulation was aborted\n"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct lx_sk_connection peer = {.name = rows[i].name};
        struct stderr_heard heard;
        struct bench bench;
        char said[256];
        open_bench(&bench, CAN, &usual);
        if (rows[i].begun) {
            begin(&bench);
        }
        stderr_hear(&heard);
        if (rows[i].what == GONE) {
            bench.fake->gone(bench.fake->ctx, NULL, &peer);
        } else if (rows[i].what == STOPPED) {
            bench.fake->stop(bench.fake->ctx, NULL);
            bench.fake->shutdown(bench.fake->ctx, NULL);
        } else {
            bench.fake->abort(bench.fake->ctx, NULL, 0);
            bench.fake->abort(bench.fake->ctx, NULL, 0);
        }
        run(&bench);
        stderr_heard(&heard, said, sizeof said);
        assert_string_equal(said, rows[i].says);
        close_bench(&bench);
    }
}

/* The last one: a thread stays in the library. Who has not joined yet is known by its own name. */
static void a_signal_ends_a_join_that_hangs(void **state)
{
    const struct fake_silkit fake = {.hangs = "join"};
    struct bench bench;
    sigset_t end;
    (void)state;
    (void)sigemptyset(&end);
    (void)sigaddset(&end, SIGTERM);
    assert_int_equal(sigprocmask(SIG_BLOCK, &end, NULL), 0);
    assert_int_equal(raise(SIGTERM), 0);
    open_bench(&bench, CAN, &fake);
    ends_in(&bench, ": SIL Kit: cell: stopped before it was complete");
    close_bench(&bench);
    assert_int_equal(bench.fake->left, 0);
}

static int own_time(void **state)
{
    (void)setenv("XDG_RUNTIME_DIR", "/dev/null", 1);
    (void)unsetenv("RUNTIME_DIRECTORY");
    lx_time_own();
    if (setenv("DREHGEBER_SILKIT_LIBRARY", FAKE_SILKIT, 1) != 0) {
        return -1;
    }
    (void)memory_file_write((const uint8_t *)"", 0); /* which stays open */
    return descriptors_note(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_participant_has_a_name_a_registry_and_a_time),
        cmocka_unit_test(ports_are_where_the_registry_is),
        cmocka_unit_test(topics_have_types),
        cmocka_unit_test(frames_have_lengths_and_may_be_remote),
        cmocka_unit_test(a_frame_has_all_encoders_of_its_chain),
        cmocka_unit_test(a_start_that_is_refused_is_one_line_and_leaves_nothing),
        cmocka_unit_test(what_is_refused_later_is_said_once),
        cmocka_unit_test(messages_of_another_length_are_told_once_per_topic),
        cmocka_unit_test(the_end_of_others_is_told),
        cmocka_unit_test(no_descriptor_is_left),
        cmocka_unit_test(a_signal_ends_a_join_that_hangs),
    };
    return cmocka_run_group_tests(tests, own_time, NULL);
}
