/* SPDX-License-Identifier: MIT */
/* The RS485 line in a VCD file, requests and replies together, sampled as a UART would. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "stacks.h"
#include "trace.h"

#define CHANGES_MAX 16384u
#define TEXTS_MAX 128u
#define BYTES_MAX 1024u
#define STEP_NS 1000u /* of the file */

/* Of a line, as time.h has them: rounded up to whole nanoseconds. */
static dg_ns bit_times(uint32_t bits, uint32_t baud)
{
    return (bits * DG_S(1) + baud - 1u) / baud;
}

/* What a file says. */
struct dump {
    size_t count;
    struct {
        dg_ns at;
        bool level;
        bool ours;
    } changes[CHANGES_MAX];
    bool request;
    bool reply;
    size_t text_count;
    struct {
        dg_ns at;
        char text[DG_WORDS_MAX];
    } texts[TEXTS_MAX];
    dg_ns end;
    size_t real_count;
    dg_ns real_end;
};

/* A character as it was found. */
struct found {
    dg_ns start;
    bool ours;
    uint8_t byte;
    bool parity_ok;
    bool stop_ok;
};

struct bench {
    char path[32];
    struct lx_tap tap;
    struct lx_trace *trace;
    struct dump dump;
    size_t count;
    struct found found[BYTES_MAX];
    uint32_t random;
};

static int set_up(void **state)
{
    struct bench *self = calloc(1, sizeof *self);
    assert_non_null(self);
    (void)strcpy(self->path, "/tmp/test_uart.XXXXXX.vcd");
    const int fd = mkstemps(self->path, 4);
    assert_true(fd >= 0);
    (void)close(fd);
    self->random = 1;
    *state = self;
    return 0;
}

static int tear_down(void **state)
{
    struct bench *self = *state;
    const int result = unlink(self->path);
    free(self);
    return result;
}

static uint8_t random_byte(struct bench *self)
{
    self->random = self->random * 1664525u + 1013904223u;
    return (uint8_t)(self->random >> 24);
}

static void begin_with(struct bench *self, dg_ns now, const struct dg_words *words)
{
    struct lx_error error;
    const struct lx_trace_setup setup = {
        .path = self->path,
        .kind = lx_hf_stack.trace,
        .words = words,
        .wire = "pty",
        .tap = &self->tap,
    };
    self->trace = lx_trace_open(&setup, now, &error);
    assert_non_null(self->trace);
}

static void begin(struct bench *self, dg_ns now)
{
    begin_with(self, now, &dg_hf_words);
}

static dg_ns whole(dg_ns at)
{
    return at / STEP_NS * STEP_NS;
}

/* One of the two lines; they are never low at once, and the wire is what both are. */
static void take_level(struct dump *self, char id, bool level)
{
    *(id == 'a' ? &self->reply : &self->request) = level;
    assert_true(self->request || self->reply);
    if (self->count == 0 || self->changes[self->count - 1].level != level) {
        assert_true(self->count < CHANGES_MAX);
        self->changes[self->count].at = self->end;
        self->changes[self->count].ours = id == 'a';
        self->changes[self->count++].level = level;
    }
}

static void take_line(struct dump *self, const char *line)
{
    char text[DG_WORDS_MAX] = "";
    if (line[0] == '#') {
        const dg_ns at = strtoull(line + 1, NULL, 10) * STEP_NS;
        assert_true(at > self->end || at == 0); /* never back, never twice */
        self->end = at;
    } else if (line[0] == 's') {
        assert_true(self->text_count < TEXTS_MAX);
        if (line[1] != ' ') {
            assert_int_equal(sscanf(line, "s%159s t", text), 1);
        }
        self->texts[self->text_count].at = self->end;
        (void)strcpy(self->texts[self->text_count++].text, text);
    } else if (line[0] == 'r') {
        char id[8];
        unsigned volts = 0;
        unsigned uv = 0;
        assert_int_equal(sscanf(line, "r%u.%6u %7s", &volts, &uv, id), 3);
        assert_int_equal(volts * 1000000u + uv, 2500000u + self->real_count);
        assert_true(id[0] != '\0' && strchr("SsCc", id[0]) != NULL && strcmp(id + 1, "1") == 0);
        self->real_count++;
        self->real_end = self->end;
    } else if (line[1] == 'q' || line[1] == 'a') {
        assert_true(line[0] == '0' || line[0] == '1');
        take_level(self, line[1], line[0] == '1');
    }
}

static void finish(struct bench *self)
{
    char line[256];
    struct lx_error error;
    assert_int_equal(lx_trace_close(self->trace, &error), 0);
    FILE *file = fopen(self->path, "r");
    assert_non_null(file);
    memset(&self->dump, 0, sizeof self->dump);
    self->dump.request = true;
    self->dump.reply = true;
    bool body = false;
    bool step = false;
    while (fgets(line, sizeof line, file) != NULL) {
        if (body) {
            take_line(&self->dump, line);
        }
        step |= strcmp(line, "$timescale 1 us $end\n") == 0;
        body |= strcmp(line, "$enddefinitions $end\n") == 0;
    }
    (void)fclose(file);
    assert_true(step);
}

static bool level_at(const struct dump *self, dg_ns at)
{
    size_t low = 0;
    size_t high = self->count;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (self->changes[middle].at <= at) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return self->changes[low].level;
}

/* The falling edge at or after `from`; the number of changes without one. */
static size_t falling_edge(const struct dump *self, dg_ns from)
{
    size_t i = 1;
    while (i < self->count && (self->changes[i].at < from || self->changes[i].level)) {
        i++;
    }
    return i;
}

static struct found receive(const struct dump *dump, size_t edge, uint32_t baud, char parity)
{
    const dg_ns bit = 1000000000u / baud;
    const dg_ns start = dump->changes[edge].at;
    dg_ns at = start + bit / 2;
    struct found found = {.start = start, .ours = dump->changes[edge].ours, .parity_ok = true};
    unsigned ones = 0;
    for (unsigned i = 0; i < 8; i++) {
        at += bit;
        const bool one = level_at(dump, at);
        found.byte = (uint8_t)(found.byte | one << i);
        ones += one;
    }
    if (parity != 'N') {
        at += bit;
        ones += level_at(dump, at);
        found.parity_ok = ones % 2 == (parity == 'O' ? 1 : 0);
    }
    found.stop_ok = level_at(dump, at + bit);
    return found;
}

static void receive_all(struct bench *self, uint32_t baud, char parity)
{
    const dg_ns bit = 1000000000u / baud;
    dg_ns from = 0;
    self->count = 0;
    for (size_t edge = falling_edge(&self->dump, from); edge < self->dump.count;
         edge = falling_edge(&self->dump, from)) {
        assert_true(self->count < BYTES_MAX);
        self->found[self->count++] = receive(&self->dump, edge, baud, parity);
        from = self->dump.changes[edge].at + (parity == 'N' ? 9 : 10) * bit + bit * 4 / 5;
    }
}

static void report_byte(struct bench *self, dg_ns at, bool ours, uint8_t byte)
{
    const struct dg_tap_event event = {
        .at = at,
        .kind = DG_TAP_CHARACTER,
        .ours = ours,
        .character = {.baud = 9600, .parity = 'E', .byte = byte},
    };
    lx_tap_tell(&self->tap, &event);
}

static void tell_note(struct bench *self, dg_ns at, const char *note)
{
    const struct dg_tap_event event = {.at = at, .kind = DG_TAP_NOTE, .note = note};
    lx_tap_tell(&self->tap, &event);
}

static void text_is(const struct dump *self, size_t i, dg_ns at, const char *text)
{
    assert_true(i < self->text_count);
    assert_string_equal(self->texts[i].text, text);
    assert_true(self->texts[i].at == whole(at));
}

/* Frames of random bytes, with damage, at every setting there is. */
static void all_bytes_at_all_settings(void **state)
{
    static const uint32_t bauds[] = {600, 1200, 2400, 4800, 9600, 19200, 38400};
    static const char parities[] = {'N', 'E', 'O'};
    struct bench *bench = *state;
    for (size_t i = 0; i < DG_COUNT(bauds) * sizeof parities; i++) {
        const uint32_t baud = bauds[i / sizeof parities];
        const char parity = parities[i % sizeof parities];
        const uint32_t bits = parity == 'N' ? 10 : 11;
        struct dg_tap_event sent[300];
        dg_ns at = DG_S(7);
        begin(bench, at);
        for (size_t n = 0; n < 300; n++) {
            /* A frame is 20 characters, a pause sometimes one bit, sometimes long. */
            at += n % 20 == 0 ? bit_times(60, baud) : 0;
            at += n % 7 == 0 ? bit_times(1, baud) : 0;
            at += bit_times(bits, baud);
            sent[n] = (struct dg_tap_event){
                .at = at,
                .kind = DG_TAP_CHARACTER,
                .ours = n / 20 % 2 != 0,
                .character = {.baud = baud,
                              .parity = parity,
                              .byte = random_byte(bench),
                              .damaged = n % 13 == 5},
            };
            lx_tap_tell(&bench->tap, &sent[n]);
        }
        finish(bench);
        receive_all(bench, baud, parity);
        assert_int_equal(bench->count, 300);
        for (size_t n = 0; n < 300; n++) {
            const struct found *found = &bench->found[n];
            const bool damaged = sent[n].character.damaged;
            const dg_ns start = sent[n].at - DG_S(7) - bit_times(bits, baud);
            assert_int_equal(found->byte, sent[n].character.byte);
            assert_int_equal(found->parity_ok, parity == 'N' || !damaged);
            assert_int_equal(found->stop_ok, parity != 'N' || !damaged);
            assert_int_equal(found->ours, sent[n].ours);
            /* Rounding to whole nanoseconds, added up over a frame. */
            assert_true(found->start >= whole(start) && found->start < start + 50);
        }
        assert_true(level_at(&bench->dump, bench->dump.end));
    }
}

/* Each voltage 1 uV above the one before. */
static void tell_sample(struct bench *self, dg_ns at, int32_t *uv)
{
    struct dg_tap_event event = {.at = at, .kind = DG_TAP_SINCOS};
    event.sincos.encoder = 1;
    for (int i = 0; i < 4; i++) {
        event.sincos.uv[i] = uv[0] + i;
    }
    uv[0] += 4;
    lx_tap_tell(&self->tap, &event);
}

/* A sample every 700 us, told before and while the characters around it are: all stand at their
 * time and the line is as without. */
static void sine_and_cosine_do_not_disturb_the_line(void **state)
{
    static const char *const names[] = {"a", "b"};
    static const uint32_t bauds[] = {600, 9600, 38400};
    struct bench *bench = *state;
    bench->tap.encoders = names;
    bench->tap.encoder_count = 2;
    for (size_t i = 0; i < DG_COUNT(bauds); i++) {
        const dg_ns each = bit_times(11, bauds[i]);
        dg_ns sample = DG_S(1) + DG_US(700);
        dg_ns at = DG_S(1);
        int32_t uv = 2500000;
        size_t samples = 0;
        begin(bench, DG_S(1));
        for (size_t n = 0; n < 300; n++) {
            at += each + (n % 20 == 0 ? bit_times(60, bauds[i]) : 0);
            for (; sample < at; sample += DG_US(700)) {
                tell_sample(bench, sample, &uv);
                samples++;
            }
            const struct dg_tap_event event = {
                .at = at,
                .kind = DG_TAP_CHARACTER,
                .ours = n / 20 % 2 != 0,
                .character = {.baud = bauds[i], .parity = 'E', .byte = (uint8_t)(n * 7u)},
            };
            lx_tap_tell(&bench->tap, &event);
        }
        finish(bench);
        assert_int_equal(bench->dump.real_count, 4 * samples);
        assert_true(bench->dump.real_end == sample - DG_US(700) - DG_S(1));
        receive_all(bench, bauds[i], 'E');
        assert_int_equal(bench->count, 300);
        for (size_t n = 0; n < 300; n++) {
            assert_int_equal(bench->found[n].byte, (uint8_t)(n * 7u));
            assert_true(bench->found[n].parity_ok && bench->found[n].stop_ok);
        }
    }
}

static void texts_stand_where_frames_begin(void **state)
{
    static const uint8_t request[] = {0x40, 0x42, 0x02};
    static const uint8_t reply[] = {0x40, 0x42, 0x00, 0x00, 0x30, 0x39, 0x0B};
    const dg_ns character = bit_times(11, 9600);
    struct bench *bench = *state;
    begin(bench, 0);
    for (size_t i = 0; i < sizeof request; i++) {
        report_byte(bench, DG_MS(10) + (i + 1) * character, false, request[i]);
    }
    tell_note(bench, DG_MS(15), "a note");
    for (size_t i = 0; i < sizeof reply; i++) {
        report_byte(bench, DG_MS(20) + (i + 1) * character, true, reply[i]);
        if (i == 3) {
            tell_note(bench, DG_MS(24), "in it");
        }
    }
    /* The first character has begun when this happens, and is told afterwards. */
    tell_note(bench, DG_MS(40) + character / 2, "during the first character");
    report_byte(bench, DG_MS(40) + character, false, 0x40);
    finish(bench);
    const struct dump *dump = &bench->dump;
    assert_int_equal(dump->text_count, 10);
    text_is(dump, 0, 0, "");
    text_is(dump, 1, DG_MS(10), "40h_42h_read_position");
    text_is(dump, 2, DG_MS(10) + 3 * character, "");
    text_is(dump, 3, DG_MS(15), "a_note");
    text_is(dump, 4, DG_MS(20), "40h_->_42h_position_12345");
    text_is(dump, 5, DG_MS(24), "in_it");
    text_is(dump, 6, DG_MS(20) + 7 * character, "");
    text_is(dump, 7, DG_MS(40), "too_short:_40");
    text_is(dump, 9, DG_MS(40) + character, "");
    assert_string_equal(dump->texts[8].text, "during_the_first_character");
    receive_all(bench, 9600, 'E');
    assert_int_equal(bench->count, 11);
}

/* A pty hands over a request at once: it is drawn as it would have come in. */
static void a_bunch_is_spread(void **state)
{
    const dg_ns character = bit_times(11, 9600);
    struct bench *bench = *state;
    begin(bench, 0);
    for (uint8_t i = 0; i < 3; i++) {
        report_byte(bench, DG_MS(10), false, i);
    }
    report_byte(bench, DG_MS(17), true, 3);
    finish(bench);
    receive_all(bench, 9600, 'E');
    assert_int_equal(bench->count, 4);
    for (uint8_t i = 0; i < 3; i++) {
        assert_int_equal(bench->found[i].byte, i);
        assert_true(bench->found[i].start == whole(DG_MS(10) - (3u - i) * character));
    }
    assert_true(bench->found[3].start == whole(DG_MS(17) - character));
}

static void a_bunch_without_the_time_for_it_comes_late(void **state)
{
    const dg_ns character = bit_times(11, 9600);
    struct bench *bench = *state;
    begin(bench, DG_MS(10));
    for (uint8_t i = 0; i < 3; i++) {
        report_byte(bench, DG_MS(11), false, i);
    }
    finish(bench);
    receive_all(bench, 9600, 'E');
    assert_int_equal(bench->count, 3);
    for (uint8_t i = 0; i < 3; i++) {
        assert_int_equal(bench->found[i].byte, i);
        assert_true(bench->found[i].start == whole(i * character));
    }
}

/* A flood that no line could carry does not push what comes after it into the future. */
static void a_flood_is_not_drawn_whole(void **state)
{
    struct bench *bench = *state;
    begin(bench, 0);
    for (unsigned i = 0; i < 5000; i++) {
        report_byte(bench, DG_MS(10), false, 0x55);
    }
    report_byte(bench, DG_S(5), true, 0xAA);
    finish(bench);
    assert_true(bench->dump.end < DG_S(5) + DG_MS(1));
    receive_all(bench, 9600, 'E');
    /* From 0 on one in 1.146 ms: 882 of them begin at most a second behind the 10 ms; and the last.
     */
    assert_int_equal(bench->count, 883);
    assert_int_equal(bench->found[bench->count - 1].byte, 0xAA);
}

/* A frame is drawn when the silence behind it ends it: no crowd of later notes pushes it away. */
static void a_frame_is_drawn_before_what_comes_after_it(void **state)
{
    struct bench *bench = *state;
    begin(bench, 0);
    report_byte(bench, DG_MS(10), false, 0x40);
    for (unsigned i = 0; i < 40; i++) {
        tell_note(bench, DG_MS(100) + i, "note");
    }
    finish(bench);
    receive_all(bench, 9600, 'E');
    assert_int_equal(bench->count, 1);
    assert_true(bench->found[0].start == whole(DG_MS(10) - bit_times(11, 9600)));
}

/* A stop bit that is low is so for three quarters: a receiver that samples in the middle sees it,
 * and the next start bit as well. */
static void a_damaged_stop_bit_ends_before_the_next_start_bit(void **state)
{
    const struct dg_tap_event event = {
        .at = DG_S(1),
        .kind = DG_TAP_CHARACTER,
        .character = {.baud = 600, .parity = 'N', .byte = 0xFF, .damaged = true},
    };
    struct bench *bench = *state;
    begin(bench, 0);
    lx_tap_tell(&bench->tap, &event);
    finish(bench);
    const struct dump *dump = &bench->dump;
    const dg_ns rises = dump->changes[dump->count - 1u].at;
    const dg_ns expected = whole(DG_S(1) - bit_times(1, 600) / 4u);
    assert_true(dump->changes[dump->count - 1u].level);
    assert_true(rises >= expected - DG_US(2) && rises <= expected + DG_US(2));
}

/* As many samples as may wait for the end of a frame; what comes after them is left out, and none
 * of them is lost. */
static void samples_beyond_those_that_may_wait_are_left_out(void **state)
{
    static const char *const names[] = {"a", "b"};
    const unsigned waiting = 16384;
    struct bench *bench = *state;
    int32_t uv = 2500000;
    bench->tap.encoders = names;
    bench->tap.encoder_count = 2;
    begin(bench, 0);
    report_byte(bench, DG_MS(10), false, 0x40);
    for (unsigned i = 0; i < waiting + 1u; i++) {
        tell_sample(bench, DG_MS(10) + 100u * i, &uv);
    }
    finish(bench);
    assert_int_equal(bench->dump.real_count, 4u * waiting);
}

/* Of a protocol that has no words each character is drawn as it comes. */
static void characters_without_words_are_drawn_at_once(void **state)
{
    struct bench *bench = *state;
    begin_with(bench, 0, NULL);
    for (unsigned i = 0; i < 2u * 140u; i++) {
        report_byte(bench, DG_MS(10) + i * bit_times(11, 9600), false, (uint8_t)i);
    }
    finish(bench);
    receive_all(bench, 9600, 'E');
    assert_int_equal(bench->count, 2u * 140u);
    for (size_t i = 0; i < bench->count; i++) {
        assert_int_equal(bench->found[i].byte, (uint8_t)i);
        assert_true(bench->found[i].parity_ok && bench->found[i].stop_ok);
    }
    assert_int_equal(bench->dump.text_count, 1); /* that of the beginning */
    assert_string_equal(bench->dump.texts[0].text, "");
}

static void a_line_without_a_rate_is_survived(void **state)
{
    const struct dg_tap_event event = {.at = DG_MS(5), .kind = DG_TAP_CHARACTER};
    struct bench *bench = *state;
    begin(bench, 0);
    lx_tap_tell(&bench->tap, &event);
    for (unsigned i = 0; i < 40; i++) {
        tell_note(bench, DG_MS(5) + i, "note");
    }
    finish(bench);
    assert_int_equal(bench->dump.count, 1);
    assert_int_equal(bench->dump.text_count, 41);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(all_bytes_at_all_settings, set_up, tear_down),
        cmocka_unit_test_setup_teardown(sine_and_cosine_do_not_disturb_the_line, set_up, tear_down),
        cmocka_unit_test_setup_teardown(texts_stand_where_frames_begin, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_bunch_is_spread, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_bunch_without_the_time_for_it_comes_late, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_flood_is_not_drawn_whole, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_frame_is_drawn_before_what_comes_after_it, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_damaged_stop_bit_ends_before_the_next_start_bit, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(samples_beyond_those_that_may_wait_are_left_out, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(characters_without_words_are_drawn_at_once, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_line_without_a_rate_is_survived, set_up, tear_down),
    };
    return cmocka_run_group_tests_name("trace_uart", tests, NULL, NULL);
}
