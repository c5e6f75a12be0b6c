/* SPDX-License-Identifier: MIT */
/* Rig files as people write them: names, ratios, motions, addresses, and what is refused of them.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/hal.h"
#include "drehgeber/rig.h"

static struct {
    _Alignas(16) unsigned char memory[65536];
    struct dg_plan plan;
    struct dg_plan_error error;
} bench;

static const char *give_file(void *ctx, const char *path, struct dg_plan_text *to)
{
    static const char text[] = "[shaft s]\n";

    (void)ctx;
    (void)path;
    *to = (struct dg_plan_text){text, sizeof text - 1u};
    return NULL;
}

static int read_plan(const char *text)
{
    const struct dg_plan_setup from = {.size = sizeof from,
                                       .file = "rig.ini",
                                       .text = {text, strlen(text)},
                                       .memory = bench.memory,
                                       .memory_size = sizeof bench.memory,
                                       .include = give_file};

    return dg_plan_read(&bench.plan, &from, &bench.error);
}

struct row {
    const char *text;
    const char *said; /* NULL: it is right */
};

static void expect_rows(const char *form, const struct row *rows, size_t count)
{
    char text[512];

    for (size_t i = 0; i < count; i++) {
        (void)snprintf(text, sizeof text, form, rows[i].text);
        const int result = read_plan(text);
        const struct dg_plan_error *error = &bench.error;
        const bool said =
            result != DG_OK && rows[i].said != NULL &&
            (strstr(error->what, rows[i].said) != NULL || strstr(error->right, rows[i].said));
        if (rows[i].said == NULL ? result != DG_OK : !said) {
            fail_msg("%s: %d: %s; %s", rows[i].text, result, error->what, error->right);
        }
    }
}

#define ENCODER "[encoder a]\nmodel = s3684-rs485\nwire = pty\n"

static void names_are_letters_digits_and_two_signs(void **state)
{
    static const struct row rows[] = {
        {"a_b-C9", NULL},   {"0", NULL},        {"a b", "letters"}, {"a:b", "letters"},
        {"a@b", "letters"}, {"a{b", "letters"}, {"a[b", "letters"}, {"a/b", "letters"},
    };
    (void)state;
    expect_rows("[shaft %s]\n" ENCODER, rows, DG_COUNT(rows));
}

static void ratios_are_two_whole_numbers(void **state)
{
    static const struct row rows[] = {
        {"1:4", NULL}, {"-3:7", NULL}, {"1.5:2", ""},        {"1.:2", ""},          {"0:2", ""},
        {"1:0", ""},   {"1", ""},      {"3000000000:1", ""}, {"-3000000000:1", ""}, {"1:x", ""},
    };
    (void)state;
    expect_rows("[shaft m]\n[shaft s]\ndriver = m\nratio = %s\n" ENCODER, rows, DG_COUNT(rows));
}

static void motions_have_units(void **state)
{
    static const struct row rows[] = {
        {"0", NULL},
        {"0.0", NULL},
        {"0.5", "has no unit"},
        {"ramp:60RPM,1S,2S", NULL},
        {"ramp:60RPM,1S,2", "has no unit"},
        {"ramp:60RPM,1S,2REV", "stands where"},
        {"ramp:60RPM,1S,2S,3S", "is too much"},
        {"sine:90DEG,2S,3S", "is too much"},
        {"2S", "is a time"},
        {"2000001RPM", "is outside"},
    };
    (void)state;
    expect_rows("[shaft s]\nmotion = %s\n" ENCODER, rows, DG_COUNT(rows));
}

static void addresses_of_control_have_a_host_and_a_port(void **state)
{
    static const struct row rows[] = {
        {"tcp:127.0.0.1:5025", NULL},
        {"tcp:[::1]:5025", NULL},
        {"tcp:abc:5025", NULL},
        {"tcp:[]:5025", ""},
        {"tcp:[a:5025", NULL},
        {"tcp:a]c:5025", NULL},
        {"tcp:abc:65536", ""},
        {"tcp:abc:50x5", ""},
        {"tcp::5025", ""},
        {"unix:here", NULL},
        {"unix:", ""},
        {"tcp:ab]:5025", NULL},
        {"serial:x", "expected unix:PATH or tcp:HOST:PORT"},
    };
    (void)state;
    expect_rows("[rig]\ncontrol = %s\n" ENCODER, rows, DG_COUNT(rows));
}

/* A file of this folder or below it, whatever its name begins with. */
static void files_are_included_from_below(void **state)
{
    static const struct row rows[] = {
        {"a.ini", NULL},
        {"lab/a.ini", NULL},
        {".a/b.ini", NULL},
        {"./a.ini", NULL},
        {"a./b.ini", NULL},
        {"../a.ini", "or below it"},
        {"lab/../a.ini", "or below it"},
        {"/a.ini", "or below it"},
        {".x", NULL},
        {"x.", NULL},
        {"lab//a.ini", "or below it"},
        {"xy", NULL},
    };
    (void)state;
    expect_rows("[rig]\ninclude = %s\n" ENCODER, rows, DG_COUNT(rows));
}

static void what_is_wrong_with_an_encoder(void **state)
{
    static const struct row rows[] = {
        {"[encoder a]\nwire = pty\nmodl = s3684-rs485\n", "expected model = s3684-rs485"},
        {"[encoder a]\nwire = pty\nmodl = nothing\n", ""},
        {"[encoder a]\nwire = pty:x:y\nmodl = nothing\n", ""},
        {"[bus c]\nwire = sim\n[encoder a]\nbus = c\nmodel = ssi-25\n[encoder b]\nbus = c\n"
         "model = s3684-biss\n",
         "has encoders of another protocol"},
        {"[bus c]\nwire = sim:x\n", "a kind and an address"},
        {"[bus c]\nwire = foo:x\n", ""},
        {"[bus c]\nwire = gpio\naddress = gpiochip0:1,2\n[bus d]\nwire = gpio\n"
         "address = gpiochip0:1,2\n",
         "is the wire in line"},
        {"[encoder a]\nmodel = ssi-25\nwire = sim\nclock_hz = 1000000\nclock_hz = 2\n", "already"},
        {"[encoder a]\nmodel = ssi-25\nwire = foo\n", ""},
        {"[encoder a]\nmodel = f3668\nwire = can:vcan0\nnode = 1..3\n",
         "several encoders have no wire of their own"},
        {"[bus v]\nwire = can\naddress = vcan0\n[encoder a]\nmodl = f3668\nbus = v\n"
         "node = 1..3\n",
         ""},
        {"[bus c]\nwire = sim\n[encoder a]\nmodel = ssi-25\nbus = c\nnode = 1..3\n", ""},
        {"[bus v]\nwire = can\naddress = vcan0\n[encoder a]\nmodel = f3668\nbus = v\n"
         "node = 1..3\nserial = 10\n",
         NULL},
    };
    (void)state;
    expect_rows("%s", rows, DG_COUNT(rows));
}

/* A serial number that is none is left to the encoder's own rows to refuse. */
static void serial_numbers_of_a_range_count_up(void **state)
{
    (void)state;
    assert_int_equal(read_plan("[bus v]\nwire = can\naddress = vcan0\n[encoder a]\nmodel = f3668\n"
                               "bus = v\nnode = 1..3\nserial = 10\n"),
                     DG_OK);
    assert_string_equal(bench.plan.encoders[2].serial, "12");
    assert_int_equal(read_plan("[bus v]\nwire = can\naddress = vcan0\n[encoder a]\nmodel = f3668\n"
                               "bus = v\nnode = 1..3\nserial = ten\n"),
                     DG_OK);
    assert_string_equal(bench.plan.encoders[2].serial, "ten");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_letters_digits_and_two_signs),
        cmocka_unit_test(ratios_are_two_whole_numbers),
        cmocka_unit_test(motions_have_units),
        cmocka_unit_test(addresses_of_control_have_a_host_and_a_port),
        cmocka_unit_test(files_are_included_from_below),
        cmocka_unit_test(what_is_wrong_with_an_encoder),
        cmocka_unit_test(serial_numbers_of_a_range_count_up),
    };
    return cmocka_run_group_tests_name("plan_written", tests, NULL, NULL);
}
