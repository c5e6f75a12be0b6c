/* SPDX-License-Identifier: MIT */
/* Trace files, read back by parsers of this test's own. */
#define _GNU_SOURCE
#include <inttypes.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "can_bus.h"
#include "drehgeber/bits.h"
#include "stacks.h"
#include "stderr_heard.h"
#include "trace.h"

#define FILE_SIZE 65536

/* A folder of its own, a tap, and what was read of a file. */
struct place {
    char folder[32];
    char path[64];
    struct lx_tap tap;
    struct lx_error error;
    size_t length;
    char text[FILE_SIZE];
};

static int set_up(void **state)
{
    struct place *self = calloc(1, sizeof *self);
    assert_non_null(self);
    (void)strcpy(self->folder, "/tmp/test_trace.XXXXXX");
    assert_non_null(mkdtemp(self->folder));
    *state = self;
    return 0;
}

/* rmdir() fails when a test leaves anything but its file behind. */
static int tear_down(void **state)
{
    struct place *self = *state;
    (void)unlink(self->path);
    const int result = rmdir(self->folder);
    free(self);
    return result;
}

static struct lx_trace *open_trace(struct place *self, const char *name,
                                   const struct lx_stack *stack, dg_ns now)
{
    (void)snprintf(self->path, sizeof self->path, "%s/%s", self->folder, name);
    const struct lx_trace_setup setup = {
        .path = self->path,
        .kind = stack->trace,
        .words = stack->core == NULL ? NULL : dg_words_of(stack->core),
        .wire = "/dev/vcan0",
        .tap = &self->tap,
    };
    return lx_trace_open(&setup, now, &self->error);
}

static void read_file(struct place *self)
{
    FILE *file = fopen(self->path, "rb");
    assert_non_null(file);
    self->length = fread(self->text, 1, sizeof self->text - 1, file);
    self->text[self->length] = '\0';
    (void)fclose(file);
}

static void close_trace(struct place *self, struct lx_trace *trace)
{
    assert_int_equal(lx_trace_close(trace, &self->error), 0);
    assert_null(self->tap.first);
    read_file(self);
}

static void tell_note(struct place *self, dg_ns at, const char *note)
{
    const struct dg_tap_event event = {.at = at, .kind = DG_TAP_NOTE, .note = note};
    lx_tap_tell(&self->tap, &event);
}

static void tell_frame(struct place *self, dg_ns at, bool ours, struct dg_can_frame frame)
{
    const struct dg_tap_event event = {
        .at = at, .kind = DG_TAP_FRAME, .ours = ours, .frame = frame};
    lx_tap_tell(&self->tap, &event);
}

static void tell_levels(struct place *self, dg_ns at, bool ma, bool slo)
{
    const struct dg_tap_event event = {
        .at = at, .kind = DG_TAP_LEVELS, .levels = {.clock = ma, .data = slo}};
    lx_tap_tell(&self->tap, &event);
}

/* ---------------------------------------------------------------- opening and closing */

static void endings_are_checked(void **state)
{
    static const struct {
        const struct lx_stack *stack;
        const char *name;
        const char *says; /* NULL: opens */
    } names[] = {
        {&lx_hf_stack, "a.vcd", NULL},
        {&lx_biss_stack, "a.vcd", NULL},
        {&lx_cia406_stack, "a.log", NULL},
        {&lx_cia406_stack, "a.pcapng", NULL},
        {&lx_cia406_stack, "a.pcap", NULL},
        {&lx_ib_stack, "a.csv", NULL},
        {&lx_hf_stack, "a.log", "a trace of RS485 ends in .vcd"},
        {&lx_biss_stack, "a.csv", "ends in .vcd"},
        {&lx_cia406_stack, "a.vcd", "ends in .log, .pcapng, .pcap"},
        {&lx_ib_stack, "csv", "ends in .csv"},
        {&lx_ib_stack, ".csv", "ends in .csv"},
        {&lx_ib_stack, "no/such/folder.csv", "No such file or directory"},
    };
    struct place *place = *state;
    for (size_t i = 0; i < DG_COUNT(names); i++) {
        struct lx_trace *trace = open_trace(place, names[i].name, names[i].stack, 0);
        assert_int_equal(trace != NULL, names[i].says == NULL);
        if (names[i].says != NULL) {
            assert_non_null(strstr(lx_error_line(&place->error).text, names[i].says));
            assert_null(place->tap.first);
            continue;
        }
        close_trace(place, trace);
        (void)unlink(place->path);
    }
    assert_int_equal(lx_trace_close(NULL, &place->error), 0);
}

static void what_has_no_format_is_refused(void **state)
{
    static const struct lx_trace_kind kind = {.title = "a wire of your own"};
    static const struct lx_stack stack = {.trace = &kind};
    static const char says[] = "a.vcd: the data on a wire of your own cannot be traced";
    struct place *place = *state;
    assert_int_equal(lx_trace_fits("a.vcd", &kind, &place->error), -1);
    assert_string_equal(lx_error_line(&place->error).text, says);
    assert_null(open_trace(place, "a.vcd", &stack, 0));
    assert_non_null(strstr(lx_error_line(&place->error).text, says));
    assert_null(place->tap.first);
}

/* A file without a head can be opened; its first line goes nowhere. */
static void a_full_disk_ends_the_trace_not_the_wire(void **state)
{
    struct place *place = *state;
    char complaint[256];
    char expected[256];
    struct stderr_heard heard;
    (void)snprintf(place->path, sizeof place->path, "%s/full.log", place->folder);
    assert_int_equal(symlink("/dev/full", place->path), 0);
    struct lx_trace *trace = open_trace(place, "full.log", &lx_cia406_stack, 0);
    assert_non_null(trace);
    tell_frame(place, DG_MS(10), true, (struct dg_can_frame){.id = 1});
    stderr_hear(&heard);
    tell_frame(place, DG_S(1), true, (struct dg_can_frame){.id = 1});
    tell_frame(place, DG_S(2), true, (struct dg_can_frame){.id = 1});
    stderr_heard(&heard, complaint, sizeof complaint);
    (void)snprintf(expected, sizeof expected,
                   "drehgeber: %s: No space left on device; the trace ends here\n", place->path);
    assert_string_equal(complaint, expected);
    assert_int_equal(lx_trace_close(trace, &place->error), -1);
    assert_non_null(strstr(lx_error_line(&place->error).text, "No space left on device"));
    assert_null(place->tap.first);
}

static void a_full_disk_is_seen_at_once_or_at_the_end(void **state)
{
    struct place *place = *state;
    (void)snprintf(place->path, sizeof place->path, "%s/full.pcapng", place->folder);
    assert_int_equal(symlink("/dev/full", place->path), 0);
    assert_null(open_trace(place, "full.pcapng", &lx_cia406_stack, 0));
    assert_non_null(strstr(lx_error_line(&place->error).text, "No space left on device"));
    (void)unlink(place->path);

    (void)snprintf(place->path, sizeof place->path, "%s/full.log", place->folder);
    assert_int_equal(symlink("/dev/full", place->path), 0);
    struct lx_trace *trace = open_trace(place, "full.log", &lx_cia406_stack, 0);
    tell_frame(place, DG_MS(10), true, (struct dg_can_frame){.id = 1});
    assert_int_equal(lx_trace_close(trace, &place->error), -1);
    assert_non_null(
        strstr(lx_error_line(&place->error).text, "not complete: No space left on device"));
}

/* What was written stays. */
static void a_limit_of_the_file_is_a_full_disk(void **state)
{
    struct place *place = *state;
    struct rlimit old;
    struct lx_trace *trace = open_trace(place, "a.log", &lx_cia406_stack, 0);
    assert_non_null(trace);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    const struct rlimit small = {.rlim_cur = 100, .rlim_max = old.rlim_max};
    (void)signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    for (unsigned i = 0; i < 5000; i++) {
        tell_frame(place, i, true, (struct dg_can_frame){.id = 1, .dlc = 8});
    }
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    assert_int_equal(lx_trace_close(trace, &place->error), -1);
    read_file(place);
    assert_int_equal(place->length, 100);
}

static void a_pipe_without_a_reader_is_refused(void **state)
{
    struct place *place = *state;
    (void)snprintf(place->path, sizeof place->path, "%s/fifo.log", place->folder);
    assert_int_equal(mkfifo(place->path, 0600), 0);
    assert_null(open_trace(place, "fifo.log", &lx_cia406_stack, 0));
    assert_non_null(strstr(lx_error_line(&place->error).text, "fifo.log: cannot open: "));
}

static void written_every_second(void **state)
{
    struct place *place = *state;
    struct lx_trace *trace = open_trace(place, "a.log", &lx_cia406_stack, DG_S(5));
    assert_non_null(trace);
    tell_frame(place, DG_S(5) + DG_MS(999), true, (struct dg_can_frame){.id = 1});
    read_file(place);
    assert_int_equal(place->length, 0);
    tell_frame(place, DG_S(6), true, (struct dg_can_frame){.id = 2});
    read_file(place);
    assert_non_null(strstr(place->text, " 002#\n"));
    tell_frame(place, DG_S(6) + DG_MS(500), true, (struct dg_can_frame){.id = 3});
    close_trace(place, trace);
    assert_non_null(strstr(place->text, " 003#\n"));
}

static void two_traces_of_a_tap(void **state)
{
    struct place *place = *state;
    struct lx_trace *log = open_trace(place, "a.log", &lx_cia406_stack, 0);
    char path[64];
    (void)strcpy(path, place->path);
    struct lx_trace *pcap = open_trace(place, "a.pcapng", &lx_cia406_stack, 0);
    assert_true(log != NULL && pcap != NULL);
    assert_int_equal(lx_trace_close(log, &place->error), 0);
    assert_int_equal(unlink(path), 0);
    tell_frame(place, 1, true, (struct dg_can_frame){.id = 1});
    close_trace(place, pcap);
    assert_true(place->length > 100);
}

/* ---------------------------------------------------------------- CAN */

static double wall_clock(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_REALTIME, &now);
    return (double)now.tv_sec + (double)now.tv_nsec / 1e9;
}

static void candump_lines(void **state)
{
    static const char *const expected[] = {"123#0102", "7FF#R", "005#R4", "000#", "080#FF"};
    static const struct dg_can_frame frames[] = {
        {.id = 0x123, .dlc = 2, .data = {1, 2}}, {.id = 0x7FF, .rtr = true},
        {.id = 5, .rtr = true, .dlc = 4},        {.id = 0},
        {.id = 0x80, .dlc = 1, .data = {0xFF}},
    };
    struct place *place = *state;
    const double before = wall_clock();
    struct lx_trace *trace = open_trace(place, "a.log", &lx_cia406_stack, DG_S(1000));
    const double after = wall_clock();
    assert_non_null(trace);
    tell_note(place, DG_S(1000), "not a frame");
    for (size_t i = 0; i < DG_COUNT(frames); i++) {
        tell_frame(place, DG_S(1003) + DG_MS(i), i != 0, frames[i]);
    }
    close_trace(place, trace);
    const char *line = strtok(place->text, "\n");
    for (size_t i = 0; i < DG_COUNT(frames); i++) {
        double at = 0;
        char wire[16];
        char frame[32];
        assert_non_null(line);
        assert_int_equal(sscanf(line, "(%17lf) %15s %31s", &at, wire, frame), 3);
        assert_true(line[11] == '.' && line[18] == ')');
        at -= 3.0 + (double)i / 1e3;
        assert_true(at > before - 0.001 && at < after + 0.001);
        assert_string_equal(wire, "vcan0");
        assert_string_equal(frame, expected[i]);
        line = strtok(NULL, "\n");
    }
    assert_null(line);
}

static uint32_t word(const struct place *place, size_t at)
{
    assert_true(at + 4 <= place->length);
    return dg_load_le32((const uint8_t *)place->text + at);
}

/* As the pcapng draft places it: a section header with the application's name, 4.1, and the
 * description of an interface with its name and nanoseconds, 4.2. */
/* clang-format off */
static const uint8_t pcapng_head[] = {
    0x0A, 0x0D, 0x0D, 0x0A,  48, 0, 0, 0,  0x4D, 0x3C, 0x2B, 0x1A,  1, 0, 0, 0,
    0xFF, 0xFF, 0xFF, 0xFF,  0xFF, 0xFF, 0xFF, 0xFF,
    4, 0, 9, 0,  'd', 'r', 'e', 'h', 'g', 'e', 'b', 'e', 'r', 0, 0, 0,  0, 0, 0, 0,  48, 0, 0, 0,
    1, 0, 0, 0,  44, 0, 0, 0,  227, 0, 0, 0,  0, 0, 0, 0,
    2, 0, 5, 0,  'v', 'c', 'a', 'n', '0', 0, 0, 0,  9, 0, 1, 0,  9, 0, 0, 0,  0, 0, 0, 0,  44, 0, 0, 0,
};
/* clang-format on */

/* Fields as the pcapng draft places them. */
static void pcapng_blocks(void **state)
{
    const struct dg_can_frame data = {.id = 0x123, .dlc = 3, .data = {0xA, 0xB, 0xC, 0xD}};
    const struct dg_can_frame remote = {.id = 0x7FF, .rtr = true, .dlc = 4, .data = {9}};
    struct place *place = *state;
    struct lx_trace *trace = open_trace(place, "a.pcapng", &lx_cia406_stack, 0);
    assert_non_null(trace);
    tell_note(place, 0, "not a frame");
    tell_frame(place, DG_S(9), false, data);
    tell_frame(place, DG_S(10) + 1, true, remote);
    close_trace(place, trace);

    size_t blocks[8];
    size_t count = 0;
    for (size_t at = 0; at < place->length; at += word(place, at + 4)) {
        const uint32_t length = word(place, at + 4);
        assert_true(count < DG_COUNT(blocks) && length >= 12 && length % 4 == 0);
        assert_int_equal(word(place, at + length - 4), length);
        blocks[count++] = at;
    }
    assert_int_equal(count, 4);
    assert_memory_equal(place->text, pcapng_head, sizeof pcapng_head);
    assert_int_equal(blocks[2], sizeof pcapng_head);

    static const uint8_t expected[2][16] = {
        {0, 0, 1, 0x23, 3, 0, 0, 0, 0xA, 0xB, 0xC},
        {0x40, 0, 7, 0xFF, 4},
    };
    uint64_t at[2];
    for (size_t i = 0; i < 2; i++) {
        const size_t block = blocks[2 + i];
        assert_int_equal(word(place, block), 6);
        assert_int_equal(word(place, block + 8), 0); /* the interface */
        at[i] = (uint64_t)word(place, block + 12) << 32 | word(place, block + 16);
        assert_int_equal(word(place, block + 20), 16);
        assert_int_equal(word(place, block + 24), 16);
        assert_memory_equal(place->text + block + 28, expected[i], 16);
        assert_int_equal(word(place, block + 44), 4u << 16 | 2u);
        assert_int_equal(word(place, block + 48), 1 + i);
        assert_int_equal(word(place, block + 52), 0);
    }
    assert_true(at[1] - at[0] == DG_S(1) + 1);
}

/* ---------------------------------------------------------------- INTERBUS */

static void tell_words(struct place *self, dg_ns at, const uint16_t *words, uint16_t n, bool valid)
{
    const struct dg_tap_event event = {
        .at = at,
        .kind = DG_TAP_WORDS,
        .words = {.in = words, .out = words + n, .count = n, .valid = valid}};
    lx_tap_tell(&self->tap, &event);
}

static void rows_of_changes(void **state)
{
    uint16_t words[6] = {1, 2, 0xA, 0xB, 7, 8};
    struct place *place = *state;
    struct lx_trace *trace = open_trace(place, "a.csv", &lx_ib_stack, DG_S(1));
    assert_non_null(trace);
    tell_note(place, DG_S(1), "ID cycle");
    tell_words(place, DG_S(1), words, 0, true);
    tell_words(place, DG_S(1) + DG_MS(1), words, 2, true);
    tell_words(place, DG_S(1) + DG_MS(2), words, 2, true);
    words[3] = 0xFFFF;
    tell_words(place, DG_S(1) + DG_MS(3), words, 2, true);
    tell_words(place, DG_S(1) + DG_MS(4), words, 2, false);
    words[1] = 9;
    tell_words(place, DG_S(12) + 1, words, 3, false);
    tell_words(place, DG_S(13), words, 1, false);
    close_trace(place, trace);
    assert_string_equal(place->text, "time_s,in_0,in_1,out_0,out_1,valid\n"
                                     "0.001000000,0001,0002,000A,000B,1\n"
                                     "0.003000000,0001,0002,000A,FFFF,1\n"
                                     "0.004000000,0001,0002,000A,FFFF,0\n"
                                     "11.000000001,0001,0009,FFFF,0007,0\n"
                                     "12.000000000,0001,0009,0009,0007,0\n");
}

/* ---------------------------------------------------------------- BiSS */

static void biss_levels(void **state)
{
    struct place *place = *state;
    struct lx_trace *trace = open_trace(place, "a.vcd", &lx_biss_stack, DG_US(100));
    assert_non_null(trace);
    tell_levels(place, DG_US(100), true, true);
    tell_levels(place, DG_US(101), false, true);
    tell_levels(place, DG_US(102), true, true);
    tell_levels(place, DG_US(103), false, false);
    tell_note(place, DG_US(101), "position 10 \\ \xC3\xA4");
    tell_levels(place, DG_S(1) + DG_US(100), true, true);
    read_file(place); /* whoever looks sees what was a second ago */
    assert_non_null(strstr(place->text, "#300\n0m\n0s\n"));
    close_trace(place, trace);
    assert_string_equal(place->text,
                        "$comment drehgeber: vcan0 $end\n$timescale 10 ns $end\n"
                        "$scope module biss $end\n$var wire 1 m MA $end\n$var wire 1 s SLO $end\n"
                        "$var string 1 t text $end\n$upscope $end\n$enddefinitions $end\n"
                        "#0\n$dumpvars\n1m\n1s\ns t\n$end\n"
                        "#100\nsposition_10_____ t\n0m\n#200\n1m\n#300\n0m\n0s\n"
                        "#100000000\n1m\n1s\n#100000100\n");
}

/* From power-on to its first clock an encoder has SLO low, and the file says so from the start. */
static void biss_slo_before_the_first_clock(void **state)
{
    struct place *place = *state;
    struct lx_trace *trace = open_trace(place, "a.vcd", &lx_biss_stack, DG_US(100));
    tell_levels(place, DG_US(101), false, false);
    tell_levels(place, DG_US(101) + 500, true, true);
    tell_levels(place, DG_US(102), false, true);
    tell_levels(place, DG_US(102) + 500, true, false);
    close_trace(place, trace);
    read_file(place);
    assert_non_null(strstr(place->text, "1m\n1s\ns t\n$end\n0s\n#100\n0m\n#150\n1m\n1s\n#200\n0m\n"
                                        "#250\n1m\n0s\n"));
}

/* Notes wait for levels of the same moment and for each other; more of them than may wait let the
 * levels before them go, and no others. */
static void biss_notes_in_a_row(void **state)
{
    static const char letters[] = "abcdefghijklmnopqrst";
    struct place *place = *state;
    char expected[256] = "#100\n0m\n#200\n";
    struct lx_trace *trace = open_trace(place, "a.vcd", &lx_biss_stack, 0);
    assert_non_null(trace);
    tell_levels(place, DG_US(1), false, true);
    for (size_t i = 0; letters[i] != '\0'; i++) {
        const char note[] = {letters[i], '\0'};
        tell_note(place, DG_US(2), note);
        (void)snprintf(expected + strlen(expected), sizeof expected - strlen(expected), "s%c t\n",
                       letters[i]);
    }
    tell_levels(place, DG_US(3), true, true);
    tell_note(place, DG_US(5), "fourth");
    tell_note(place, DG_US(4), "third");
    close_trace(place, trace);
    (void)strcat(expected, "#300\n1m\n#400\nsthird t\n#500\nsfourth t\n");
    assert_non_null(strstr(place->text, expected));
}

/* More levels and notes than can be held back, and late ones: all are there, time never goes back.
 */
static void biss_levels_in_a_crowd(void **state)
{
    struct place *place = *state;
    struct lx_trace *trace = open_trace(place, "a.vcd", &lx_biss_stack, 0);
    unsigned edges = 0;
    unsigned notes = 0;
    uint64_t last = 0;
    assert_non_null(trace);
    for (unsigned i = 0; i < 3000; i++) {
        tell_levels(place, 1000 + 10 * i, i % 2 != 0, true);
        if (i % 50 == 0) {
            tell_note(place, i == 0 ? 0 : 1000 + 10 * (i - 50), "frame");
        }
    }
    close_trace(place, trace);
    for (const char *line = strtok(place->text, "\n"); line != NULL; line = strtok(NULL, "\n")) {
        edges += strcmp(line, "0m") == 0 || strcmp(line, "1m") == 0;
        notes += strcmp(line, "sframe t") == 0;
        if (line[0] == '#') {
            const uint64_t at = strtoull(line + 1, NULL, 10);
            assert_true(at >= last);
            last = at;
        }
    }
    assert_int_equal(edges, 3001); /* and the one of the head */
    assert_int_equal(notes, 60);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(endings_are_checked, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_has_no_format_is_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_full_disk_ends_the_trace_not_the_wire, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_full_disk_is_seen_at_once_or_at_the_end, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_limit_of_the_file_is_a_full_disk, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_pipe_without_a_reader_is_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(written_every_second, set_up, tear_down),
        cmocka_unit_test_setup_teardown(two_traces_of_a_tap, set_up, tear_down),
        cmocka_unit_test_setup_teardown(candump_lines, set_up, tear_down),
        cmocka_unit_test_setup_teardown(pcapng_blocks, set_up, tear_down),
        cmocka_unit_test_setup_teardown(rows_of_changes, set_up, tear_down),
        cmocka_unit_test_setup_teardown(biss_levels, set_up, tear_down),
        cmocka_unit_test_setup_teardown(biss_slo_before_the_first_clock, set_up, tear_down),
        cmocka_unit_test_setup_teardown(biss_notes_in_a_row, set_up, tear_down),
        cmocka_unit_test_setup_teardown(biss_levels_in_a_crowd, set_up, tear_down),
    };
    return cmocka_run_group_tests_name("trace", tests, NULL, NULL);
}
