/* SPDX-License-Identifier: MIT */
/*
 * The BiSS encoder on GPIO lines, on lines made up here: edges that queued, edges that got lost, a
 * chip that goes. That the kernel's lines do the same is shown end to end.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include <errno.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "clocked_rig.h"
#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"
#include "gpio.h"
#include "host_rig.h"
#include "stacks.h"

#define QUEUE_MAX 64u
#define RUNS_MAX 2000u
#define RUN_US 1000u
/* No clock of this test gets there. */
#define LATER DG_S(1000000000)

/* Two lines; first the base. */
struct fake {
    struct lx_gpio_lines base;
    struct lx_gpio_edge queue[QUEUE_MAX];
    size_t queued;
    unsigned written; /* times that SLO was set */
    int ma;           /* level, or a negative errno */
    bool slo;
};

static struct fake fake;
static struct host_rig_place place;
static struct dg_encoder control;
static struct lx_clocked *line;
static struct dg_biss *slave;
static struct lx_gpio gpio;
static struct lx_tap tap;
static unsigned gone;
static sd_event *event;
static const struct lx_say say = {.quiet = true};

static int fake_read(struct lx_gpio_lines *base, struct lx_gpio_edge *edges, size_t n)
{
    uint64_t unused = 0;
    const size_t count = fake.queued < n ? fake.queued : n;

    /* Edges are also asked for when nothing has woken anybody. */
    assert_true(read(base->fd, &unused, sizeof unused) == sizeof unused || errno == EAGAIN);
    memcpy(edges, fake.queue, count * sizeof edges[0]);
    fake.queued = 0;
    return fake.ma < 0 ? fake.ma : (int)count;
}

static int fake_get_clock(struct lx_gpio_lines *base)
{
    (void)base;
    return fake.ma;
}

static int fake_set_data(struct lx_gpio_lines *base, bool level)
{
    (void)base;
    fake.slo = level;
    fake.written++;
    return fake.ma < 0 ? fake.ma : 0;
}

static void fake_close(struct lx_gpio_lines *base)
{
    (void)close(base->fd);
}

static const struct lx_gpio_lines_ops fake_ops = {
    .read = fake_read,
    .get_input = fake_get_clock,
    .set_output = fake_set_data,
    .close = fake_close,
};

static void on_gone(void *ctx)
{
    (void)ctx;
    gone++;
}

/* The encoder on GPIO lines, with its settings and no power yet. */
static struct dg_host *make(const struct dg_device *model)
{
    return dg_host_init_on_bus(place.bytes, sizeof place.bytes, model, dg_bus_side_of(model));
}

static void begin_on(struct dg_host *host, const struct lx_clocked_protocol *protocol)
{
    static const struct dg_bus_edges_setup wire = {.size = sizeof wire,
                                                   .period_ns = LX_GPIO_PERIOD};
    struct lx_error error;

    control = (struct dg_encoder){
        .name = "a",
        .instrument = dg_instrument_of(dg_host_wire_at(host)->stack),
        .model = dg_device_find(dg_host_model(host)),
        .device = dg_host_line_of(host)->device,
        .world = dg_host_world(host),
    };
    assert_int_equal(dg_host_power(host, 0, true), DG_OK);
    lx_clocked_close(line);
    line = lx_clocked_new(protocol);
    assert_non_null(line);
    clocked_rig_connect(line, host, &control, &wire, &tap);
    const struct lx_gpio_setup setup = {.event = event,
                                        .say = &say,
                                        .line = line,
                                        .name = "fake:4,5",
                                        .lines = &fake.base,
                                        .gone = on_gone};
    assert_int_equal(lx_gpio_open(&gpio, &setup, &error), 0);
}

static void begin_as(const struct dg_biss_model *model)
{
    struct dg_host *host = make(dg_device_find("s3674-biss"));

    *(struct dg_biss_model *)dg_host_line_of(host)->settings = *model;
    begin_on(host, lx_biss_stack.clocked);
    slave = dg_bus_device(line->bus, 0);
}

/* A device whose frames end after `timeout`, 0: after its own. */
static void begin(dg_ns timeout)
{
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3674-biss"));

    model.timeout = timeout;
    begin_as(&model);
}

static int setup(void **state)
{
    (void)state;
    tap = (struct lx_tap){.first = NULL};
    gone = 0;
    fake = (struct fake){.base = {&fake_ops, eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)}, .ma = 1};
    return fake.base.fd < 0 || sd_event_new(&event) < 0;
}

static int teardown(void **state)
{
    (void)state;
    lx_gpio_close(&gpio);
    lx_clocked_close(line);
    line = NULL;
    event = sd_event_unref(event);
    return 0;
}

static void queue(dg_ns at, bool level)
{
    const uint64_t one = 1;

    assert_true(fake.queued < QUEUE_MAX);
    fake.queue[fake.queued++] = (struct lx_gpio_edge){.at = at, .level = level};
    fake.ma = level;
    assert_int_equal(write(fake.base.fd, &one, sizeof one), sizeof one);
}

/* `n` clocks from `at` on, 1 us apart. @return when the last edge was */
static dg_ns queue_clocks(dg_ns at, unsigned n)
{
    for (unsigned i = 0; i < n; i++) {
        queue(at + DG_US(2u * i), false);
        queue(at + DG_US(2u * i + 1u), true);
    }
    return at + DG_US(2u * n - 1u);
}

static void run(void)
{
    assert_true(sd_event_run(event, RUN_US) >= 0);
}

static void test_queued_edges_are_caught_up_with(void **state)
{
    (void)state;
    begin(DG_S(1));
    const dg_ns last = queue_clocks(lx_now(), 8);
    while (lx_now() < last + DG_MS(1)) {
    }
    run();
    assert_int_equal(gpio.counters.edges, 16);
    assert_int_equal(gpio.counters.late, 7);
    assert_int_equal(gpio.counters.lost, 0);
    assert_int_equal(slave->counters.frames, 1);
    assert_int_equal(slave->line.state, DG_BISS_DATA);
    /* Only the level that is still worth it. */
    assert_int_equal(fake.written, 1);
    assert_int_equal(fake.slo, dg_biss_slo(slave, false));
    /* All as late as the first. */
    assert_int_equal(gpio.rate.edges, 8);
    assert_true(gpio.rate.worst_ns >= DG_US(1014));
}

static void test_every_clock_is_answered(void **state)
{
    static const bool slo[] = {true, false, true, false};

    (void)state;
    begin(DG_S(1));
    for (unsigned i = 0; i < 4; i++) {
        (void)queue_clocks(LATER + DG_MS(i), 1);
        run();
        assert_int_equal(fake.slo, slo[i]);
        assert_int_equal(fake.written, i + 1u);
    }
    assert_int_equal(gpio.counters.late, 0);
    assert_int_equal(gpio.counters.lost, 0);
    assert_int_equal(gpio.rate.edges, 4);
}

/* A rising edge that is answered `answer` after it, the falling one `half` after it. */
static void clock_once(dg_ns at, dg_ns answer, dg_ns half)
{
    queue(at, true);
    run();
    gpio.answered = at + answer;
    queue(at + half, false);
    run();
}

/* The yardstick is half a period: a master may look at SLO at the falling edge. */
static void test_answers_behind_the_falling_edge_are_late(void **state)
{
    dg_ns at = LATER;

    (void)state;
    begin(DG_S(1));
    queue(at, false);
    run();
    clock_once(at += DG_MS(2), DG_US(400), DG_US(500));
    assert_int_equal(gpio.counters.late, 0);
    clock_once(at += DG_MS(2), DG_US(500), DG_US(500));
    assert_int_equal(gpio.counters.late, 0);
    clock_once(at += DG_MS(2), DG_US(501), DG_US(500));
    assert_int_equal(gpio.counters.late, 1);
    /* Once for each, and not without an edge: the end of a frame. */
    clock_once(at += DG_MS(2), DG_MS(700), DG_US(500));
    assert_int_equal(gpio.counters.late, 2);
    queue(at += DG_MS(2), true);
    run();
    gpio.answered = at + DG_MS(3);
    assert_int_equal(gpio.counters.late, 2);
    queue(at + DG_MS(30), false);
    run();
    assert_int_equal(gpio.counters.late, 2);
    assert_int_equal(gpio.counters.lost, 0);
    assert_int_equal(gpio.rate.edges, 5);
}

/* A lost falling edge: the next rising one tells. */
static void test_rising_edge_behind_a_rising_one(void **state)
{
    (void)state;
    begin(DG_S(1));
    queue(LATER, false);
    queue(LATER + DG_MS(1), true);
    run();
    gpio.answered = LATER + DG_MS(5);
    queue(LATER + DG_MS(2), true);
    run();
    assert_int_equal(gpio.counters.late, 1);
    assert_int_equal(gpio.counters.lost, 1);
}

/* Frames are those of the model: e1, e2, start bit, CDS, data. */
static void test_frames_of_the_model(void **state)
{
    (void)state;
    begin(DG_S(1));
    assert_int_equal(gpio.rate.edges_per_frame, 39);
    lx_gpio_close(&gpio);
    fake.base.fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    begin_as(dg_biss_model_of(dg_device_find("s3684-biss")));
    assert_int_equal(gpio.rate.edges_per_frame, 51);
}

/* Low, as the line was taken; the first rising edge sets it. */
static void test_slo_begins_as_the_device_has_it(void **state)
{
    (void)state;
    begin(DG_S(1));
    assert_false(gpio.data);
    assert_int_equal(fake.written, 0);
    for (dg_ns end = lx_now() + DG_MS(900); lx_now() < end && !slave->line.hinted;) {
        run();
    }
    assert_true(slave->line.hinted); /* the user has been told why a master may wait */
    queue(LATER, false);
    run();
    assert_int_equal(fake.written, 0);
    queue(LATER + DG_US(1), true);
    run();
    assert_true(fake.slo);
}

static void test_missing_edges_are_noticed(void **state)
{
    (void)state;
    begin(DG_S(1));
    const dg_ns last = queue_clocks(lx_now(), 4);
    queue(last + 1u, true); /* a falling edge is missing */
    queue(last + 2u, false);
    fake.queue[fake.queued - 1u].gap = true;
    run();
    assert_int_equal(gpio.counters.edges, 10);
    assert_int_equal(gpio.counters.lost, 2);
}

static void run_until(const uint64_t *counter)
{
    for (unsigned i = 0; *counter == 0 && i < RUNS_MAX; i++) {
        run();
    }
    assert_true(*counter != 0);
}

/* The falling edge of CDM = 1 got lost: MA is looked at before the timeout ends. */
static void test_lost_last_edge_is_made_up_for(void **state)
{
    (void)state;
    begin(0);
    (void)queue_clocks(lx_now(), 5);
    fake.ma = 0;
    run_until(&gpio.counters.lost);
    for (unsigned i = 0; slave->line.state != DG_BISS_RETURN && i < RUNS_MAX; i++) {
        run();
    }
    assert_int_equal(slave->line.state, DG_BISS_RETURN);
    assert_int_equal(slave->control.zeros, 0);
    assert_true(fake.slo);
}

/* MA is low already when the timeout ends, its edge is still to come: the next frame's. */
static void test_edge_on_its_way_is_waited_for(void **state)
{
    (void)state;
    begin(0);
    const dg_ns last = queue_clocks(lx_now(), 5);
    fake.ma = 0;
    for (unsigned i = 0; !gpio.doubtful && i < RUNS_MAX; i++) {
        run();
    }
    assert_true(gpio.doubtful);
    const dg_ns next = last + DG_US(20);
    queue(next, false);
    queue(next + DG_US(1), true);
    run();
    assert_int_equal(gpio.counters.lost, 0);
    assert_int_equal(slave->counters.frames, 2);
    assert_int_equal(slave->control.zeros, 1);
}

/* --- an encoder that is switched on: its data rises without an edge of the clock --- */

static void test_data_follows_the_supply_without_a_clock(void **state)
{
    struct dg_host *host = make(dg_device_find("ssi-13"));

    (void)state;
    assert_int_equal(dg_host_set(host, "init_ms", "2"), DG_HOST_OK);
    begin_on(host, lx_ssi_stack.clocked);
    for (unsigned i = 0; !fake.slo && i < RUNS_MAX; i++) {
        run();
    }
    assert_true(fake.slo);
    fake.written = 0;
    assert_int_equal(dg_host_power(host, lx_now(), false), DG_OK);
    lx_gpio_changed(&gpio);
    assert_int_equal(fake.written, 1);
    assert_false(fake.slo);
    assert_int_equal(dg_host_power(host, lx_now(), true), DG_OK);
    lx_gpio_changed(&gpio);
    assert_int_equal(fake.written, 1); /* not before its end */
    for (unsigned i = 0; !fake.slo && i < RUNS_MAX; i++) {
        run();
    }
    assert_true(fake.slo);
    assert_int_equal(fake.written, 2);
}

static void test_chip_that_goes_is_told_once(void **state)
{
    (void)state;
    begin(DG_S(1));
    queue(lx_now(), false);
    fake.ma = -ENODEV;
    run();
    queue(lx_now(), true);
    fake.ma = -ENODEV;
    run();
    assert_int_equal(gone, 1);
}

static void set_fault(const char *name, uint32_t count)
{
    const struct dg_fault_target target = dg_encoder_target(&control);
    const struct dg_fault_limits limits = {count, 1000000, DG_NEVER};
    const int index = dg_fault_find(&target, name);

    assert_true(index >= 0);
    assert_int_equal(dg_fault_set(&control.faults, &target, (size_t)index, 0, &limits), DG_OK);
    lx_gpio_changed(&gpio);
}

/* Clock by clock. @return levels of SLO after each of them, the first one in front */
static uint32_t levels(dg_ns at, unsigned n)
{
    uint32_t bits = 0;

    for (unsigned i = 0; i < n; i++) {
        (void)queue_clocks(at + DG_US(2u * i), 1);
        run();
        bits = bits << 1 | fake.slo;
    }
    return bits;
}

/* Without the life counter all frames at rest are the same. */
static void test_faults_sit_behind_the_driver(void **state)
{
    enum { CLOCKS = 32 };
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3674-biss"));
    uint32_t changes = 0;

    (void)state;
    model.timeout = DG_S(1);
    model.life_counter = false;
    begin_as(&model);
    const uint32_t good = levels(LATER, CLOCKS);
    assert_int_equal(slave->counters.frames, 1);
    assert_int_equal(dg_bus_step(line->bus, LATER + DG_S(2)), DG_NEVER);

    set_fault("wire_damage", 1);
    for (uint32_t bits = levels(LATER + DG_S(3), CLOCKS) ^ good; bits != 0; bits &= bits - 1u) {
        changes++;
    }
    assert_int_equal(changes, 1);
    (void)dg_bus_step(line->bus, LATER + DG_S(5));

    set_fault("wire_drop", 1);
    assert_int_equal(levels(LATER + DG_S(6), CLOCKS), UINT32_MAX);
    (void)dg_bus_step(line->bus, LATER + DG_S(8));

    assert_int_equal(levels(LATER + DG_S(9), CLOCKS), good);
    (void)dg_bus_step(line->bus, LATER + DG_S(11));

    set_fault("wire_break", 0);
    assert_int_equal(levels(LATER + DG_S(12), CLOCKS), UINT32_MAX);
    assert_int_equal(slave->counters.frames, 5);
}

/* No start bit, no P of the write: until the disk has it, and once when it will not. */
static void test_what_is_not_stored_is_not_acknowledged(void **state)
{
    enum { CLOCKS = 32 };
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3674-biss"));
    uint8_t byte = 0;
    struct lx_nvm_queue queue = {
        .setup = {.writer = lx_nvm_writer_new(event, NULL, NULL)}, .bytes = &byte, .issued = 1};
    dg_ns at = LATER;

    (void)state;
    model.timeout = DG_S(1);
    model.life_counter = false;
    begin_as(&model);
    assert_non_null(queue.setup.writer);
    const uint32_t good = levels(at, CLOCKS);
    (void)dg_bus_step(line->bus, at += DG_S(2));
    lx_clocked_hold(line, 0, &queue);
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(levels(at += DG_S(1), CLOCKS), UINT32_MAX);
        (void)dg_bus_step(line->bus, at += DG_S(2));
    }
    queue.done = 1;
    assert_int_equal(levels(at += DG_S(1), CLOCKS), good);
    (void)dg_bus_step(line->bus, at += DG_S(2));
    queue.issued = 2;
    queue.stalled = true;
    assert_int_equal(levels(at += DG_S(1), CLOCKS), UINT32_MAX);
    (void)dg_bus_step(line->bus, at += DG_S(2));
    assert_int_equal(levels(at += DG_S(1), CLOCKS), good);
    lx_nvm_writer_free(queue.setup.writer);
}

static void count_levels(void *ctx, const struct dg_tap_event *seen)
{
    unsigned *count = ctx;

    assert_int_equal(seen->kind, DG_TAP_LEVELS);
    (*count)++;
}

static void test_edges_are_told_to_the_tap(void **state)
{
    unsigned count = 0;
    struct lx_tap_listener listener = {.event = count_levels, .ctx = &count};

    (void)state;
    begin(DG_S(1));
    lx_tap_add(&tap, &listener);
    (void)queue_clocks(LATER, 4);
    run();
    assert_int_equal(count, 8);
}

/* --- a memory that is slow --- */

/* A sync takes as long as the test holds the lock. */
static pthread_mutex_t disk = PTHREAD_MUTEX_INITIALIZER;
static int disk_result;

static int read_disk(void *ctx, uint32_t address, void *to, size_t n)
{
    (void)ctx;
    (void)address;
    memset(to, 0, n);
    return DG_OK;
}

static int write_disk(void *ctx, uint32_t address, const void *from, size_t n)
{
    (void)ctx;
    (void)address;
    (void)from;
    (void)n;
    return DG_OK;
}

static int sync_disk(void *ctx)
{
    (void)ctx;
    (void)pthread_mutex_lock(&disk);
    const int result = disk_result;
    (void)pthread_mutex_unlock(&disk);
    return result;
}

/* A commit that is under way, and ends as `result`. */
static void commit_slowly(const struct dg_nvm *nvm, int result)
{
    (void)pthread_mutex_lock(&disk);
    assert_int_equal(nvm->ops->write(nvm->ctx, 0, "x", 1), DG_OK);
    assert_int_equal(nvm->ops->sync(nvm->ctx), DG_OK);
    disk_result = result;
}

static void end_commit(struct lx_nvm_queue *memory)
{
    (void)pthread_mutex_unlock(&disk);
    while (lx_nvm_queue_state(memory, memory->issued) == LX_NVM_PENDING) {
        run();
    }
}

/* @return whether there was an Ack: SLO low behind the second clock */
static bool acknowledged(void)
{
    const uint64_t edges = gpio.counters.edges + 4u;
    (void)queue_clocks(lx_now(), 2);
    while (gpio.counters.edges < edges) {
        run();
    }
    const bool low = !fake.slo;
    for (unsigned i = 0; slave->line.deadline != DG_NEVER && i < RUNS_MAX; i++) {
        run();
    }
    return low;
}

/* P of a write comes with the frame behind it. */
static void test_what_is_not_on_the_disk_is_not_acknowledged(void **state)
{
    static const struct dg_nvm_ops ops = {read_disk, write_disk, sync_disk};
    struct lx_nvm_queue memory;
    struct dg_nvm nvm;
    struct lx_error error;
    const struct lx_nvm_queue_setup queued = {
        .writer = lx_nvm_writer_new(event, NULL, NULL), .below = {&ops, NULL}, .size = 1};
    (void)state;
    begin(DG_MS(20));
    assert_int_equal(lx_nvm_queue_open(&memory, &queued, &nvm, &error), 0);
    lx_clocked_hold(line, 0, &memory);
    assert_true(acknowledged());
    commit_slowly(&nvm, DG_OK);
    assert_false(acknowledged());
    assert_false(acknowledged());
    end_commit(&memory);
    assert_true(acknowledged());
    commit_slowly(&nvm, DG_ERR_IO);
    end_commit(&memory);
    assert_false(acknowledged()); /* the frame that would have had P */
    assert_true(acknowledged());
    lx_nvm_queue_close(&memory);
    lx_nvm_writer_free(queued.writer);
}

static void test_addresses(void **state)
{
    static const char *const wrong[] = {
        "",       "gpiochip0", "gpiochip0:4",     "gpiochip0:4,", "gpiochip0:,5",
        ":4,5",   "a:4,4",     "a:4,5,6",         "a:-4,5",       "a:4,65536",
        "a:4 ,5", "a:0x4,5",   "a:4,99999999999", "a,4:5",
    };
    struct lx_gpio_address address;
    struct lx_error error;

    (void)state;
    assert_int_equal(lx_gpio_address_parse(&address, "gpiochip0:4,17", &error), 0);
    assert_string_equal(address.path, "/dev/gpiochip0");
    assert_string_equal(address.text, "gpiochip0:4,17");
    assert_int_equal(address.clock, 4);
    assert_int_equal(address.data, 17);
    assert_int_equal(lx_gpio_address_parse(&address, "/dev/by:id/chip:0,1", &error), 0);
    assert_string_equal(address.path, "/dev/by:id/chip");
    for (size_t i = 0; i < DG_COUNT(wrong); i++) {
        assert_int_equal(lx_gpio_address_parse(&address, wrong[i], &error), -1);
        assert_non_null(strstr(lx_error_line(&error).text, "CHIP:CLOCK,DATA"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_queued_edges_are_caught_up_with, setup, teardown),
        cmocka_unit_test_setup_teardown(test_every_clock_is_answered, setup, teardown),
        cmocka_unit_test_setup_teardown(test_answers_behind_the_falling_edge_are_late, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(test_rising_edge_behind_a_rising_one, setup, teardown),
        cmocka_unit_test_setup_teardown(test_frames_of_the_model, setup, teardown),
        cmocka_unit_test_setup_teardown(test_slo_begins_as_the_device_has_it, setup, teardown),
        cmocka_unit_test_setup_teardown(test_missing_edges_are_noticed, setup, teardown),
        cmocka_unit_test_setup_teardown(test_lost_last_edge_is_made_up_for, setup, teardown),
        cmocka_unit_test_setup_teardown(test_edge_on_its_way_is_waited_for, setup, teardown),
        cmocka_unit_test_setup_teardown(test_data_follows_the_supply_without_a_clock, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(test_chip_that_goes_is_told_once, setup, teardown),
        cmocka_unit_test_setup_teardown(test_faults_sit_behind_the_driver, setup, teardown),
        cmocka_unit_test_setup_teardown(test_what_is_not_stored_is_not_acknowledged, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(test_edges_are_told_to_the_tap, setup, teardown),
        cmocka_unit_test_setup_teardown(test_what_is_not_on_the_disk_is_not_acknowledged, setup,
                                        teardown),
        cmocka_unit_test(test_addresses),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
