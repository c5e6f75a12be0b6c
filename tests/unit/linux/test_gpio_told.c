/* SPDX-License-Identifier: MIT */
/*
 * What a user is told of the clock on GPIO lines: which one this host can follow, that it was too
 * fast, that edges of it were lost. In virtual time, on lines made up here; README.md of the port.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cmocka.h>

#include "clocked_rig.h"
#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"
#include "gpio.h"
#include "host_rig.h"
#include "stacks.h"
#include "stderr_heard.h"

/* Rising edges of a frame of an s3674-biss: two at its head, start bit, CDS, data. */
#define EDGES_PER_FRAME 39u
/* A master that looks half a period after its edge may have 2500 Hz; one behind that is late. */
#define IN_TIME (DG_US(200) - 1u)
#define LATE (DG_US(600) - 1u)
#define HALF_PERIOD DG_US(500)

/* The lines, and the encoder on them. */
static struct {
    struct lx_gpio_lines lines;
    struct lx_gpio_edge edge[2]; /* that the kernel has seen */
    size_t count;
    int level; /* of the clock, or a negative errno */
    struct host_rig_place place;
    struct dg_encoder control;
    struct lx_clocked *line;
    struct lx_gpio gpio;
    struct lx_tap tap;
    sd_event *event;
    dg_ns begin;
} bench;

static int read_made_up(struct lx_gpio_lines *lines, struct lx_gpio_edge *edges, size_t n)
{
    uint64_t woken = 0;
    const size_t count = bench.count;
    assert_true(count <= n);
    assert_true(read(lines->fd, &woken, sizeof woken) == sizeof woken || errno == EAGAIN);
    memcpy(edges, bench.edge, count * sizeof edges[0]);
    bench.count = 0;
    return (int)count;
}

static int clock_made_up(struct lx_gpio_lines *lines)
{
    (void)lines;
    return bench.level;
}

static int set_made_up(struct lx_gpio_lines *lines, bool level)
{
    (void)lines;
    (void)level;
    return 0;
}

static void close_made_up(struct lx_gpio_lines *lines)
{
    (void)close(lines->fd);
}

static const struct lx_gpio_lines_ops made_up = {
    .read = read_made_up,
    .get_input = clock_made_up,
    .set_output = set_made_up,
    .close = close_made_up,
};

static void gone(void *ctx)
{
    (void)ctx;
    fail_msg("the chip has gone");
}

/* @return as lx_gpio_open() */
static int open_lines(int level, struct lx_error *error)
{
    static const struct dg_bus_edges_setup wire = {.size = sizeof wire,
                                                   .period_ns = LX_GPIO_PERIOD};
    static const struct lx_say say = {.quiet = false};
    const struct dg_device *model = dg_device_find("s3674-biss");
    struct dg_host *host = dg_host_init_on_bus(bench.place.bytes, sizeof bench.place.bytes, model,
                                               dg_bus_side_of(model));
    struct dg_biss_model *settings = dg_host_line_of(host)->settings;
    settings->timeout = DG_MS(20);
    settings->hint = 0;
    bench.level = level;
    bench.begin = lx_now();
    bench.control =
        (struct dg_encoder){.name = "a",
                            .instrument = dg_instrument_of(dg_host_wire_at(host)->stack),
                            .model = model,
                            .device = dg_host_line_of(host)->device,
                            .world = dg_host_world(host)};
    assert_int_equal(dg_host_power(host, 0, true), DG_OK);
    bench.line = lx_clocked_new(lx_biss_stack.clocked);
    assert_non_null(bench.line);
    clocked_rig_connect(bench.line, host, &bench.control, &wire, &bench.tap);
    const struct lx_gpio_setup setup = {.event = bench.event,
                                        .say = &say,
                                        .line = bench.line,
                                        .name = "chip:4,5",
                                        .lines = &bench.lines,
                                        .gone = gone};
    return lx_gpio_open(&bench.gpio, &setup, error);
}

static int set_up(void **state)
{
    (void)state;
    lx_time_own();
    memset(&bench, 0, sizeof bench);
    bench.lines = (struct lx_gpio_lines){&made_up, eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};
    return bench.lines.fd < 0 || sd_event_new(&bench.event) < 0 ? -1 : 0;
}

static int tear_down(void **state)
{
    (void)state;
    lx_gpio_close(&bench.gpio);
    lx_clocked_close(bench.line);
    (void)sd_event_unref(bench.event);
    return 0;
}

static void begin(void)
{
    struct lx_error error;
    assert_int_equal(open_lines(1, &error), 0);
}

/* --- the clock and time --- */

static void serve(void)
{
    while (sd_event_run(bench.event, 0) > 0) {
    }
}

static void pass_to(dg_ns end)
{
    serve();
    while (lx_time_pass(end)) {
        serve();
    }
}

static void put_edge(dg_ns at, bool level)
{
    const uint64_t one = 1;
    assert_true(bench.count < DG_COUNT(bench.edge));
    bench.edge[bench.count++] = (struct lx_gpio_edge){.at = at, .level = level};
    bench.level = level;
    assert_int_equal(write(bench.lines.fd, &one, sizeof one), sizeof one);
}

/* After a millisecond the clock, which was high, has fallen and risen; that is answered `reaction`
   after it has risen. */
static void clock_once(dg_ns reaction)
{
    pass_to(lx_now() + DG_MS(1));
    put_edge(lx_now() - reaction - 1u, false);
    put_edge(lx_now() - reaction, true);
    serve();
}

static void clock_many(unsigned n)
{
    for (unsigned i = 0; i < n; i++) {
        clock_once(IN_TIME);
    }
}

/* The master looks half a period after the edge, and nothing has come yet. */
static void clock_late(void)
{
    clock_once(LATE);
    put_edge(lx_now() - LATE + HALF_PERIOD, false);
    serve();
    put_edge(lx_now(), true);
    serve();
}

/* All that is said until `end`, after the beginning. */
static void says(dg_ns end, const char *text)
{
    struct stderr_heard heard;
    char said[512];
    stderr_hear(&heard);
    pass_to(bench.begin + end);
    stderr_heard(&heard, said, sizeof said);
    assert_string_equal(said, text);
}

#define FOLLOWS                                                                                    \
    "drehgeber: chip:4,5: SLO follows within 199 us of the kernel's time of an edge: a clock up "  \
    "to 2500 Hz works for "
#define UNKNOWN "; the time before the kernel's is unknown\n"

/* After 5, 100 and 3000 frames, and between frames only. */
static void the_clock_that_it_can_follow_is_told_three_times(void **state)
{
    (void)state;
    begin();
    clock_many(5u * EDGES_PER_FRAME - 1u);
    says(DG_S(1), "");
    clock_many(1);
    says(DG_S(2), FOLLOWS "all of 5 frames seen (99.9 % is known after 3000)" UNKNOWN);
    clock_many(95u * EDGES_PER_FRAME - 1u);
    says(DG_S(7), "");
    clock_many(1);
    says(DG_S(8), FOLLOWS "all of 100 frames seen (99.9 % is known after 3000)" UNKNOWN);
    lx_gpio_rate_take(&bench.gpio.rate, IN_TIME, 2900u * EDGES_PER_FRAME - 1u);
    says(DG_S(10), "");
    clock_many(1);
    says(DG_S(11), FOLLOWS "99.9 % of frames (3000 seen)" UNKNOWN);
    lx_gpio_rate_take(&bench.gpio.rate, IN_TIME, 100000u * EDGES_PER_FRAME);
    says(DG_S(20), "");
}

/* What is due to be told is told once, the latest of it. */
static void frames_of_a_second_are_told_together(void **state)
{
    (void)state;
    begin();
    clock_many(10);
    lx_gpio_rate_take(&bench.gpio.rate, IN_TIME, 100u * EDGES_PER_FRAME);
    says(DG_S(1), FOLLOWS "all of 100 frames seen (99.9 % is known after 3000)" UNKNOWN);
    says(DG_S(3), "");
}

#define TOO_FAST(n)                                                                                \
    "drehgeber: chip:4,5: the master's clock is too fast, " n " times SLO was set later than "     \
    "half a period after its edge; expected at most 833 Hz for all of 0 frames seen (99.9 % is "   \
    "known after 3000)\n"

/* Of trouble that follows within 10 s of other trouble nothing more is said. */
static void a_clock_that_is_too_fast_is_told_once_per_episode(void **state)
{
    (void)state;
    begin();
    clock_late();
    says(DG_S(1), TOO_FAST("1"));
    says(DG_S(10) + DG_MS(500), "");
    clock_late();
    says(DG_S(21) + DG_MS(500), "");
    clock_late();
    clock_late();
    says(DG_S(22), TOO_FAST("2"));
    says(DG_S(40), "");
}

#define CLEAN                                                                                      \
    "drehgeber: chip:4,5: edges of MA were lost, frames are damaged; expected a clean clock of "   \
    "at most 2500 Hz for all of 0 frames seen (99.9 % is known after 3000)\n"

/* The clock rises behind a rising edge. */
static void lost_edges_are_told(void **state)
{
    (void)state;
    begin();
    pass_to(bench.begin + DG_MS(1));
    put_edge(lx_now() - IN_TIME, true);
    serve();
    says(DG_S(1), CLEAN);
    says(DG_S(3), "");
}

/* The kernel says that its queue was too short. */
static void a_gap_is_a_lost_edge(void **state)
{
    (void)state;
    begin();
    clock_many(1);
    pass_to(lx_now() + DG_MS(1));
    put_edge(lx_now(), false);
    bench.edge[0].gap = true;
    serve();
    says(DG_S(1), CLEAN);
}

static void a_clock_that_cannot_be_read_is_told(void **state)
{
    struct lx_error error = {.right = ""};
    (void)state;
    assert_int_equal(open_lines(-ENODEV, &error), -1);
    assert_string_equal(lx_error_line(&error).text, "chip:4,5: cannot read MA: No such device");
}

/* --- where lines are, and why they cannot be had --- */

#define RIGHT "expected CHIP:CLOCK,DATA with two offsets, e.g. gpiochip0:4,5"

static void addresses_say_what_is_right(void **state)
{
    struct lx_gpio_address address;
    struct lx_error error;
    char text[LX_GPIO_ADDRESS_MAX + 1u];
    (void)state;
    assert_int_equal(lx_gpio_address_parse(&address, "chip:4", &error), -1);
    assert_string_equal(lx_error_line(&error).text, RIGHT);
    assert_int_equal(lx_gpio_address_parse(&address, "chip:4,4", &error), -1);
    assert_string_equal(lx_error_line(&error).text, "both are the same line; " RIGHT);
    assert_int_equal(lx_gpio_address_parse(&address, "chip:0,65535", &error), 0);
    assert_int_equal(address.clock, 0);
    assert_int_equal(address.data, 65535);
    assert_int_equal(lx_gpio_address_parse(&address, "chip:65536,0", &error), -1);
    for (size_t n = LX_GPIO_ADDRESS_MAX - 1u; n <= LX_GPIO_ADDRESS_MAX; n++) {
        memset(text, 'c', n);
        memcpy(text + n - 4u, ":1,2", 5);
        const bool fits = n < LX_GPIO_ADDRESS_MAX;
        assert_int_equal(lx_gpio_address_parse(&address, text, &error), fits ? 0 : -1);
        if (fits) {
            assert_string_equal(address.text, text);
            assert_int_equal(strlen(address.path), strlen("/dev/") + n - 4u);
        }
    }
}

static void what_cannot_be_had_says_why(void **state)
{
    static const struct {
        int reason;
        const char *says;
    } chips[] = {
        {ENOENT, "there is no /dev/chip and no chip with that label; 'gpiodetect' lists the chips"},
        {EACCES,
         "no permission for /dev/chip; expected a user who may read and write it, e.g. root "
         "or one of the group gpio"},
        {EPERM, "no permission for /dev/chip; expected a user who may read and write it, e.g. root "
                "or one of the group gpio"},
        {ENOTTY, "/dev/chip is no GPIO chip; 'gpiodetect' lists them"},
        {ENODEV, "/dev/chip is no GPIO chip; 'gpiodetect' lists them"},
        {EIO, "cannot use /dev/chip: Input/output error"},
    };
    static const struct {
        unsigned offset;
        int reason;
        const char *says;
    } lines[] = {
        {4, EBUSY, "line 4 is in use; 'gpioinfo' shows free ones"},
        {17, EBUSY, "line 17 is in use; 'gpioinfo' shows free ones"},
        {4, EINVAL, "cannot use line 4: Invalid argument; an encoder needs edge detection there"},
        {17, EINVAL, "cannot use line 17: Invalid argument"},
    };
    struct lx_gpio_address address;
    struct lx_error error;
    (void)state;
    assert_int_equal(lx_gpio_address_parse(&address, "chip:4,17", &error), 0);
    for (size_t i = 0; i < DG_COUNT(chips); i++) {
        assert_int_equal(lx_gpio_no_chip(&address, chips[i].reason, &error), -1);
        assert_string_equal(lx_error_line(&error).text, chips[i].says);
    }
    for (size_t i = 0; i < DG_COUNT(lines); i++) {
        assert_int_equal(lx_gpio_no_line(&address, lines[i].offset, lines[i].reason, &error), -1);
        assert_string_equal(lx_error_line(&error).text, lines[i].says);
    }
}

/* Both of them, whichever is the higher one. */
static void a_chip_has_to_have_both_lines(void **state)
{
    static const char *const addresses[] = {"chip:4,17", "chip:17,4"};
    struct lx_gpio_address address;
    struct lx_error error;
    (void)state;
    for (size_t i = 0; i < DG_COUNT(addresses); i++) {
        assert_int_equal(lx_gpio_address_parse(&address, addresses[i], &error), 0);
        assert_int_equal(lx_gpio_check_offsets(&address, 18, &error), 0);
        assert_int_equal(lx_gpio_check_offsets(&address, 17, &error), -1);
        assert_string_equal(lx_error_line(&error).text,
                            "/dev/chip has 17 lines; expected offsets below that");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_clock_that_it_can_follow_is_told_three_times, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(frames_of_a_second_are_told_together, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_clock_that_is_too_fast_is_told_once_per_episode, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(lost_edges_are_told, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_gap_is_a_lost_edge, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_clock_that_cannot_be_read_is_told, set_up, tear_down),
        cmocka_unit_test(addresses_say_what_is_right),
        cmocka_unit_test(what_cannot_be_had_says_why),
        cmocka_unit_test(a_chip_has_to_have_both_lines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
