/* SPDX-License-Identifier: MIT */
/*
 * A rig in a simulation whose library is a fake: what comes late, twice, out of order or not at all
 * is called here by the test.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dlfcn.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "drehgeber/bits.h"
#include "rig.h"
#include "silkit.h"
#include "silkit/fake.h"
#include "timer.h"

#define MS UINT64_C(1000000)
#define LATE UINT64_C(1700000000000000000) /* somebody's time of day */

static const char text[] = "[rig]\nname = cell\ncontrol = unix:%s/rig.sock\n"
                           "[shaft motor]\nmotion = 60RPM\n"
                           "[shaft axis]\ndriver = motor\nratio = 1:2\n"
                           "[bus can]\nwire = silkit\naddress = silkit://h:1,CAN\n%s"
                           "[bus line]\nwire = silkit\naddress = silkit://h:1,LINE\n"
                           "[encoder n]\nmodel = f3668\nbus = can\n"
                           "[encoder l]\nmodel = s3684-rs485\nbus = line\n"
                           "[encoder b]\nmodel = s3684-biss\nwire = silkit:silkit://h:1,CHAIN\n"
                           "[encoder s]\nmodel = ssi-25\nwire = silkit:silkit://h:1,SSI\n"
                           "[encoder i]\nmodel = ocd-ib-k2\nwire = silkit:silkit://h:1,RING\n";

static const struct lx_say quiet = {.quiet = true};

static const char *hangs; /* for the next bench */

struct bench {
    char folder[32];
    char file[64];
    struct dg_plan plan;
    sd_event *event;
    struct lx_rig *rig;
    struct fake_silkit *fake;
    enum lx_rig_result result;
    struct lx_error error;
};

static void open_bench(struct bench *self, const char *keys, const char *refuses)
{
    *self = (struct bench){.folder = "/tmp/silkit.XXXXXX"};
    void *library = dlopen(FAKE_SILKIT, RTLD_NOW);
    assert_non_null(library);
    self->fake = dlsym(library, "fake_silkit");
    assert_non_null(self->fake);
    *self->fake = (struct fake_silkit){.refuses = refuses, .hangs = hangs};
    assert_int_equal(setenv("DREHGEBER_SILKIT_LIBRARY", FAKE_SILKIT, 1), 0);
    assert_non_null(mkdtemp(self->folder));
    (void)snprintf(self->file, sizeof self->file, "%s/rig.ini", self->folder);
    FILE *file = fopen(self->file, "w");
    assert_non_null(file);
    (void)fprintf(file, text, self->folder, keys);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(lx_plan_read(&self->plan, self->file, &self->error), 0);
    assert_true(sd_event_new(&self->event) >= 0);
    const struct lx_rig_setup setup = {.event = self->event, .say = &quiet, .plan = &self->plan};
    self->result = lx_rig_open(&self->rig, &setup, lx_now(), &self->error);
}

static void close_bench(struct bench *self)
{
    char socket[64];
    (void)lx_rig_close(self->rig, &self->error);
    lx_plan_free(&self->plan);
    self->event = sd_event_unref(self->event);
    (void)snprintf(socket, sizeof socket, "%s/rig.sock", self->folder);
    (void)unlink(socket);
    (void)unlink(self->file);
    assert_int_equal(rmdir(self->folder), 0);
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

static void step_simulation(struct bench *self, uint64_t at)
{
    self->fake->step(self->fake->ctx, NULL, at, MS);
    run(self);
}

static void receive(const struct bench *self, uint64_t at, uint32_t id, uint32_t flags,
                    const void *bytes, size_t n)
{
    struct lx_sk_frame frame = {
        .id = id, .flags = flags, .dlc = (uint16_t)n, .data = {.data = bytes, .size = n}};
    struct lx_sk_frame_event event = {.timestamp = at, .frame = &frame};
    self->fake->frame(self->fake->can_ctx, NULL, &event);
}

static struct fake_topic *topic(const struct bench *self, const char *name)
{
    for (unsigned i = 0; i < self->fake->topics; i++) {
        if (strcmp(self->fake->topic[i].topic, name) == 0) {
            return &self->fake->topic[i];
        }
    }
    fail_msg("no topic %s", name);
    return NULL;
}

static void publish(const struct bench *self, uint64_t at, const char *name, const void *bytes,
                    size_t n)
{
    const struct fake_topic *to = topic(self, name);
    const struct lx_sk_data_event event = {.timestamp = at, .data = {.data = bytes, .size = n}};
    to->handler(to->ctx, NULL, &event);
}

static void begin(struct bench *self)
{
    self->fake->ready(self->fake->ctx, NULL);
    run(self);
    assert_int_equal(self->fake->started, 1);
    assert_int_equal(self->fake->frames, 0); /* nobody could answer yet */
    step_simulation(self, 0);
}

/* ---------------------------------------------------------------- tests */

static void boot_up_is_sent_in_the_first_step(void **state)
{
    struct bench bench;
    (void)state;
    open_bench(&bench, "", NULL);
    assert_int_equal(bench.result, LX_RIG_OK);
    begin(&bench);
    assert_int_equal(bench.fake->frames, 1);
    assert_int_equal(bench.fake->sent[0].id, 0x73F);
    assert_int_equal(bench.fake->completed, 1);
    close_bench(&bench);
    assert_int_equal(bench.fake->stopped, 1);
    assert_int_equal(bench.fake->left, 1);
}

/* Real time has no steps whose end the library could wait for. */
static void messages_of_a_step_go_together(void **state)
{
    static const char together[] =
        "{\"Logging\":{\"Sinks\":[]},\"Experimental\":"
        "{\"TimeSynchronization\":{\"EnableMessageAggregation\":\"On\"}}}";
    static const char each[] = "{\"Logging\":{\"Sinks\":[]}}";
    static const struct {
        const char *keys;
        const char *config;
    } rows[] = {{"", together},
                {"aggregate = 1\n", together},
                {"aggregate = 0\n", each},
                {"time = real\n", each}};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct bench bench;
        open_bench(&bench, rows[i].keys, NULL);
        assert_int_equal(bench.result, LX_RIG_OK);
        assert_string_equal(bench.fake->config, rows[i].config);
        close_bench(&bench);
    }
}

/* Two SYNCs that came the wrong way round, a third one of this very step. */
static void frames_are_handled_in_the_order_of_their_moments(void **state)
{
    struct bench bench;
    (void)state;
    open_bench(&bench, "", NULL);
    begin(&bench);
    receive(&bench, MS / 2, 0, 0, "\x01\x00", 2);
    step_simulation(&bench, MS);
    bench.fake->frames = 0;
    receive(&bench, 502 * MS, 0x80, 0, "", 0);
    receive(&bench, 501 * MS, 0x80, 0, "", 0);
    receive(&bench, 503 * MS, 0x80, 0, "", 0);
    step_simulation(&bench, 503 * MS);
    assert_int_equal(bench.fake->frames, 2);
    assert_int_equal(dg_load_le32(bench.fake->sent[0].bytes), 501 * 65536 / 1000);
    assert_int_equal(dg_load_le32(bench.fake->sent[1].bytes), 502 * 65536 / 1000);
    step_simulation(&bench, 504 * MS);
    assert_int_equal(bench.fake->frames, 3);
    assert_int_equal(dg_load_le32(bench.fake->sent[2].bytes), 503 * 65536 / 1000);
    close_bench(&bench);
}

static void who_has_another_clock_is_heard_at_once(void **state)
{
    static const uint8_t upload[8] = {0x40, 0x04, 0x60};
    struct bench bench;
    (void)state;
    open_bench(&bench, "", NULL);
    begin(&bench);
    bench.fake->frames = 0;
    receive(&bench, LATE, 0x63F, 0, upload, sizeof upload);
    receive(&bench, LATE, 0x63F, 0x200, upload, sizeof upload);  /* 29 bits */
    receive(&bench, LATE, 0x63F, 0x1000, upload, sizeof upload); /* CAN FD */
    receive(&bench, LATE, 0x63F, 0, text, 64);
    step_simulation(&bench, MS);
    assert_int_equal(bench.fake->frames, 1);
    assert_int_equal(bench.fake->sent[0].id, 0x5BF);
    close_bench(&bench);
}

/* Of the can bus as a packed one: what a step has made it say, in one message. */
static const struct fake_topic *packed(struct bench *bench, uint64_t at)
{
    const struct fake_topic *from = topic(bench, "CAN/frames");
    const unsigned before = from->count;
    step_simulation(bench, at);
    assert_int_equal(from->count, before + 1u);
    return from;
}

#define PACKED "frames = packed\n"
#define HEAD(count) 0, 0, 0, 0, 0, 0, 0, 0, count, 0, 0, 0

static void packed_frames_are_those_of_a_step(void **state)
{
    static const uint8_t start[] = {HEAD(1), 0, 0, 0, 0, 0, 0, 2, 0, 1, 0};
    /* The later SDO first: at one moment they are in the order of their identifiers. */
    static const uint8_t two[] = {HEAD(2), 0, 0, 0, 0, 0x3F, 6, 8, 0,    0x40, 4, 0x60, 0,
                                  0,       0, 0, 0, 0, 0,    0, 0, 0x80, 0,    0, 0};
    struct bench bench;
    (void)state;
    open_bench(&bench, PACKED, NULL);
    assert_int_equal(bench.result, LX_RIG_OK);
    bench.fake->ready(bench.fake->ctx, NULL);
    run(&bench);
    const struct fake_topic *from = packed(&bench, 0);
    static const uint8_t boot[] = {HEAD(1), 0, 0, 0, 0, 0x3F, 7, 1, 0, 0};
    assert_int_equal(from->size, sizeof boot);
    assert_memory_equal(from->bytes, boot, sizeof boot);
    publish(&bench, MS / 2, "CAN/frames/to", start, sizeof start);
    step_simulation(&bench, MS);
    const unsigned quiet_count = from->count;
    step_simulation(&bench, 2 * MS);
    assert_int_equal(from->count, quiet_count); /* nothing was said */
    publish(&bench, 501 * MS, "CAN/frames/to", two, sizeof two);
    (void)packed(&bench, 503 * MS);
    assert_int_equal(dg_load_le32(from->bytes), 501 * MS); /* when they were sent */
    assert_int_equal(dg_load_le16(from->bytes + 8), 2);
    assert_int_equal(dg_load_le16(from->bytes + 16), 0x2BF);
    assert_int_equal(dg_load_le32(from->bytes + 20), 501 * 65536 / 1000);
    assert_int_equal(dg_load_le16(from->bytes + 28), 0x5BF);
    assert_int_equal(bench.fake->frames, 0); /* there is no controller */
    assert_int_equal(bench.fake->started, 0);
    close_bench(&bench);
}

/* What comes behind its moment and what comes before it are the same. */
static void packed_frames_are_held_until_their_step_is_over(void **state)
{
    static const uint8_t start[] = {HEAD(1), 0, 0, 0, 0, 0, 0, 2, 0, 1, 0};
    static const uint8_t sync[] = {HEAD(1), 0, 0, 0, 0, 0x80, 0, 0, 0};
    struct bench bench;
    (void)state;
    open_bench(&bench, PACKED, NULL);
    bench.fake->ready(bench.fake->ctx, NULL);
    run(&bench);
    step_simulation(&bench, 0);
    publish(&bench, 0, "CAN/frames/to", start, sizeof start);
    step_simulation(&bench, 500 * MS);
    publish(&bench, 501 * MS, "CAN/frames/to", sync, sizeof sync); /* before the step at 501 ms, */
    const unsigned before = topic(&bench, "CAN/frames")->count;
    step_simulation(&bench, 501 * MS);
    assert_int_equal(topic(&bench, "CAN/frames")->count, before);
    publish(&bench, 501 * MS, "CAN/frames/to", sync, sizeof sync); /* ... and behind it */
    const struct fake_topic *from = packed(&bench, 502 * MS);
    assert_int_equal(dg_load_le16(from->bytes + 8), 2);
    assert_int_equal(dg_load_le32(from->bytes + 20), 501 * 65536 / 1000);
    assert_int_equal(dg_load_le32(from->bytes + 32), 501 * 65536 / 1000);
    close_bench(&bench);
}

static void what_is_no_packed_frames_is_left_out(void **state)
{
    static const uint8_t wide[] = {HEAD(1), 0, 0, 0, 0, 0, 8, 0, 0};
    static const uint8_t sync[] = {HEAD(1), 0, 0, 0, 0, 0x80, 0, 0, 0};
    struct bench bench;
    (void)state;
    open_bench(&bench, PACKED, NULL);
    bench.fake->ready(bench.fake->ctx, NULL);
    run(&bench);
    step_simulation(&bench, 0);
    publish(&bench, 1, "CAN/frames/to", (const uint8_t[]){HEAD(1), 0, 0, 0, 0, 0, 0, 2, 0, 1, 0},
            22);
    for (size_t n = 0; n < sizeof sync; n++) {
        publish(&bench, 1, "CAN/frames/to", sync, n);
    }
    publish(&bench, 1, "CAN/frames/to", wide, sizeof wide);
    step_simulation(&bench, MS);
    const unsigned before = topic(&bench, "CAN/frames")->count;
    publish(&bench, MS, "CAN/frames/to", sync, sizeof sync);
    publish(&bench, MS, "CAN/frames/to", wide, sizeof wide);
    step_simulation(&bench, 2 * MS);
    assert_int_equal(topic(&bench, "CAN/frames")->count, before + 1u);
    close_bench(&bench);
}

/* Beside one of this very step. */
static void another_clock_has_an_order(void **state)
{
    struct bench bench;
    (void)state;
    open_bench(&bench, "", NULL);
    begin(&bench);
    receive(&bench, MS, 0, 0, "\x01\x00", 2);
    for (uint64_t i = 0; i < 3; i++) {
        publish(&bench, LATE + i * MS, "LINE/request", &"\x40\x42\x02"[i], 1);
    }
    step_simulation(&bench, MS);
    for (uint64_t at = 2; at <= 40; at++) {
        step_simulation(&bench, at * MS);
    }
    assert_true(topic(&bench, "LINE/reply")->count > 0);
    close_bench(&bench);
}

static void states_of_the_controller_are_the_encoders(void **state)
{
    struct lx_sk_error_event event = {.timestamp = MS, .state = LX_SK_BUS_OFF};
    struct lx_sk_transmit_event lost = {.timestamp = MS, .status = 2};
    struct bench bench;
    (void)state;
    open_bench(&bench, "", NULL);
    begin(&bench);
    receive(&bench, MS / 2, 0, 0, "\x01\x00", 2);
    bench.fake->error(bench.fake->can_ctx, NULL, &event);
    bench.fake->transmit(bench.fake->can_ctx, NULL, &lost);
    step_simulation(&bench, 2 * MS);
    bench.fake->frames = 0;
    receive(&bench, 2 * MS, 0x80, 0, "", 0);
    step_simulation(&bench, 3 * MS);
    assert_int_equal(bench.fake->frames, 0);
    event = (struct lx_sk_error_event){.timestamp = 3 * MS, .state = LX_SK_ERROR_ACTIVE};
    bench.fake->error(bench.fake->can_ctx, NULL, &event);
    event.state = 77; /* none that is known */
    bench.fake->error(bench.fake->can_ctx, NULL, &event);
    step_simulation(&bench, 4 * MS);
    assert_true(bench.fake->frames > 0);
    assert_int_equal(bench.fake->sent[0].id, 0xBF);
    assert_int_equal(dg_load_le16(bench.fake->sent[0].bytes), 0x8140);
    close_bench(&bench);
}

static void topics_carry_what_goes_over_lines(void **state)
{
    static const uint8_t request[] = {0x40, 0x42, 0x02};
    uint8_t turn[16] = {0};
    struct bench bench;
    (void)state;
    open_bench(&bench, "", NULL);
    begin(&bench);
    dg_store_le64(turn, UINT64_C(1) << 30);
    publish(&bench, MS, "cell/shaft/motor/turn", turn, sizeof turn);
    publish(&bench, 1500 * MS, "LINE/request", request, sizeof request);
    for (uint64_t at = 10; at <= 1600; at += 10) {
        step_simulation(&bench, at * MS);
    }
    const struct fake_topic *reply = topic(&bench, "LINE/reply");
    assert_in_range(reply->count, 1, 2);                    /* within a step, or two */
    assert_int_equal(reply->bytes[reply->size - 1u], 0x42); /* the check sum of 40 42 00 00 40 00 */
    assert_int_equal(topic(&bench, "CHAIN/frame")->count, 161);
    assert_int_equal(topic(&bench, "CHAIN/frame")->bytes[8], 0);
    assert_int_equal(dg_load_le32(topic(&bench, "CHAIN/frame")->bytes + 16), 1u << 19);
    assert_int_equal(dg_load_le32(topic(&bench, "SSI/frame")->bytes + 16), 1u << 11);
    assert_int_equal(dg_load_le16(topic(&bench, "RING/in")->bytes), 0);
    assert_memory_equal(topic(&bench, "cell/shaft/motor")->bytes, turn, sizeof turn);
    assert_int_equal(dg_load_le32(topic(&bench, "cell/shaft/axis")->bytes), 1u << 29);
    publish(&bench, 1605 * MS, "CHAIN/latch", "", 0);
    step_simulation(&bench, 1610 * MS);
    assert_int_equal(topic(&bench, "CHAIN/frame")->count, 162);
    assert_int_equal(dg_load_le32(topic(&bench, "CHAIN/frame")->bytes), (uint32_t)(1605 * MS));
    step_simulation(&bench, 1620 * MS);
    assert_int_equal(topic(&bench, "CHAIN/frame")->count, 162);
    close_bench(&bench);
}

/* But once a second, and when it is turned, which is turning what it drives. */
static void a_shaft_that_goes_on_as_said_is_not_said_again(void **state)
{
    static const struct {
        uint64_t ms;
        unsigned count;
        bool turns;
    } rows[] = {{1, 1, false},    {2, 1, true},     {3, 2, false},    {999, 2, false},
                {1002, 2, false}, {1003, 3, false}, {2002, 3, false}, {2003, 4, false}};
    static const uint8_t turn[16] = {[12] = 1};
    struct bench bench;
    (void)state;
    open_bench(&bench, "", NULL);
    begin(&bench);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        step_simulation(&bench, rows[i].ms * MS);
        assert_int_equal(topic(&bench, "cell/shaft/motor")->count, rows[i].count);
        assert_int_equal(topic(&bench, "cell/shaft/axis")->count, rows[i].count);
        if (rows[i].turns) {
            publish(&bench, rows[i].ms * MS, "cell/shaft/motor/turn", turn, sizeof turn);
        }
    }
    close_bench(&bench);
}

static void other_lengths_are_left_out(void **state)
{
    static const uint8_t junk[5000];
    struct bench bench;
    (void)state;
    open_bench(&bench, "", NULL);
    begin(&bench);
    for (unsigned i = 0; i < 3; i++) {
        publish(&bench, MS, "cell/shaft/motor/turn", junk, 15);
        publish(&bench, MS, "LINE/request", junk, sizeof junk);
        publish(&bench, MS, "RING/out", junk, 3);
        publish(&bench, MS, "CHAIN/latch", junk, 1);
    }
    publish(&bench, MS, "RING/out", "\x00\x00\x00\x00", 4);
    step_simulation(&bench, 2 * MS);
    assert_int_equal(bench.fake->completed, 2);
    close_bench(&bench);
}

/* Also what comes after the end, when it is being taken down. */
static void what_comes_late_or_twice_harms_nobody(void **state)
{
    struct bench bench;
    (void)state;
    open_bench(&bench, "", NULL);
    begin(&bench);
    bench.fake->ready(bench.fake->ctx, NULL);
    bench.fake->step(bench.fake->ctx, NULL, MS, MS);
    step_simulation(&bench, MS);
    step_simulation(&bench, 0);
    step_simulation(&bench, 2 * MS);
    bench.fake->stop(bench.fake->ctx, NULL);
    bench.fake->stop(bench.fake->ctx, NULL);
    bench.fake->shutdown(bench.fake->ctx, NULL);
    bench.fake->abort(bench.fake->ctx, NULL, 0);
    receive(&bench, MS, 0x80, 0, "", 0);
    bench.fake->step(bench.fake->ctx, NULL, 3 * MS, MS);
    run(&bench);
    int code = -1;
    assert_int_equal(sd_event_get_exit_code(bench.event, &code), 0);
    assert_int_equal(code, 0);
    bench.fake->step(bench.fake->ctx, NULL, 4 * MS, MS);
    receive(&bench, MS, 0x80, 0, text, 8);
    close_bench(&bench);
    assert_int_equal(bench.fake->stopped, 0);
}

static void it_ends_as_the_others_do(void **state)
{
    static const struct {
        const char *gone;
        int code;
        bool begun;
        bool aborted;
    } rows[] = {
        {NULL, 0, true, false},
        {NULL, 1, true, true},
        {NULL, 1, false, true},
        {"SilKitRegistry", 1, false, false},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct lx_sk_connection peer = {.name = rows[i].gone};
        struct bench bench;
        open_bench(&bench, "", NULL);
        if (rows[i].begun) {
            begin(&bench);
        }
        if (rows[i].gone != NULL) {
            bench.fake->gone(bench.fake->ctx, NULL, &peer);
        } else if (rows[i].aborted) {
            bench.fake->abort(bench.fake->ctx, NULL, 50);
        } else {
            bench.fake->stop(bench.fake->ctx, NULL);
            bench.fake->shutdown(bench.fake->ctx, NULL);
        }
        run(&bench);
        int code = -1;
        assert_int_equal(sd_event_get_exit_code(bench.event, &code), 0);
        assert_int_equal(code, rows[i].code);
        close_bench(&bench);
    }
}

static void its_part_ends_behind_the_span(void **state)
{
    struct bench bench;
    (void)state;
    open_bench(&bench, "", NULL);
    lx_rig_end_after(bench.rig, 2 * MS);
    begin(&bench);
    step_simulation(&bench, MS);
    step_simulation(&bench, 2 * MS);
    assert_int_equal(bench.fake->completed, 3);
    step_simulation(&bench, 3 * MS);
    assert_int_equal(bench.fake->completed, 3);
    assert_int_equal(sd_event_get_state(bench.event), SD_EVENT_FINISHED);
    close_bench(&bench);
    assert_int_equal(bench.fake->completed, 4); /* the step it was asked for is not held up */
}

static void what_the_library_refuses_is_one_line(void **state)
{
    static const char *const functions[] = {"config", "join",      "lifecycle",  "time",
                                            "can",    "publisher", "subscriber", "start"};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(functions); i++) {
        struct bench bench;
        open_bench(&bench, "", functions[i]);
        assert_int_equal(bench.result, LX_RIG_WORLD);
        assert_non_null(strstr(lx_error_line(&bench.error).text, "no luck"));
        close_bench(&bench);
    }
}

/* The last one: a thread stays in the library. */
static void a_signal_ends_a_start_that_hangs(void **state)
{
    struct bench bench;
    sigset_t end;
    (void)state;
    (void)sigemptyset(&end);
    (void)sigaddset(&end, SIGTERM);
    assert_int_equal(sigprocmask(SIG_BLOCK, &end, NULL), 0);
    hangs = "subscriber";
    assert_int_equal(raise(SIGTERM), 0);
    open_bench(&bench, "", NULL);
    assert_int_equal(bench.result, LX_RIG_WORLD);
    assert_non_null(strstr(lx_error_line(&bench.error).text, "stopped before it was complete"));
    assert_true(lx_silkit_is_left_behind());
    receive(&bench, MS, 0x80, 0, "", 0); /* to nobody */
    close_bench(&bench);
    assert_int_equal(bench.fake->left, 0);
}

static void what_it_refuses_later_is_said_once(void **state)
{
    static const char *const functions[] = {"send", "publish", "complete", "baud"};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(functions); i++) {
        struct bench bench;
        open_bench(&bench, "", functions[i]);
        assert_int_equal(bench.result, LX_RIG_OK);
        begin(&bench);
        step_simulation(&bench, MS);
        assert_int_equal(bench.fake->completed, 2);
        close_bench(&bench);
    }
}

static int own_time(void **state)
{
    (void)state;
    lx_time_own();
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boot_up_is_sent_in_the_first_step),
        cmocka_unit_test(messages_of_a_step_go_together),
        cmocka_unit_test(frames_are_handled_in_the_order_of_their_moments),
        cmocka_unit_test(who_has_another_clock_is_heard_at_once),
        cmocka_unit_test(packed_frames_are_those_of_a_step),
        cmocka_unit_test(packed_frames_are_held_until_their_step_is_over),
        cmocka_unit_test(what_is_no_packed_frames_is_left_out),
        cmocka_unit_test(another_clock_has_an_order),
        cmocka_unit_test(states_of_the_controller_are_the_encoders),
        cmocka_unit_test(topics_carry_what_goes_over_lines),
        cmocka_unit_test(a_shaft_that_goes_on_as_said_is_not_said_again),
        cmocka_unit_test(other_lengths_are_left_out),
        cmocka_unit_test(what_comes_late_or_twice_harms_nobody),
        cmocka_unit_test(it_ends_as_the_others_do),
        cmocka_unit_test(its_part_ends_behind_the_span),
        cmocka_unit_test(what_the_library_refuses_is_one_line),
        cmocka_unit_test(what_it_refuses_later_is_said_once),
        cmocka_unit_test(a_signal_ends_a_start_that_hangs),
    };
    return cmocka_run_group_tests(tests, own_time, NULL);
}
