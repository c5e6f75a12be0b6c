/* SPDX-License-Identifier: MIT */
/*
 * Properties that hold for any input: how it is cut into pieces makes no difference, every row of
 * the tables is found under every form of its header and under nothing else, and noise gives at
 * most one error a line.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "scpi_private.h"
#include "scpi_rig.h"

#define ROUNDS 3000u
#define FORMS 200u
#define HEADER_MAX 128u

static struct scpi_rig rig;
static struct scpi_rig other;
static uint64_t seed = 88172645463325252u;

static unsigned below(unsigned n)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (unsigned)(seed % n);
}

/* Lines of what a client may send, and of what it may not. */
static size_t random_input(char *to, size_t size)
{
    static const char *const pieces[] = {
        "SHAF:POS ",  "SHAFt:VELocity", "?",   ";",       ":",         "*IDN?",   "*ESR?",
        "SYST:ERR?",  "SYST:ERR:ALL?",  "\n",  "\n",      "\r\n",      " ",       "\t",
        "1.5E3",      "90DEG",          ",",   "'a;b'",   "\"",        "#H1F",    "FAUL:SET x",
        ",COUN 3",    "WORL:OFFS",      "COS", "VAL:NOW", "*OPC",      "*WAI",    "*CLS",
        "BYT 1,2,3",  "\x80",           "MAX", "NUMB",    "TEXT abc",  "PART? 5", "FAIL",
        "SYST:HELP?", "NOTH?",          "*",   "[",       "SHAF:STOP", "*OPC?",   "RAIS 5",
    };
    size_t n = 0;

    while (n + 16u < size) {
        const char *piece = pieces[below(DG_COUNT(pieces))];
        memcpy(&to[n], piece, strlen(piece));
        n += strlen(piece);
    }
    to[n] = '\n';
    return n + 1u;
}

/* The same state but for times, places of memory and what is left of lines. */
static void assert_same(const struct scpi_rig *a, const struct scpi_rig *b)
{
    assert_int_equal(a->length, b->length);
    assert_memory_equal(a->out, b->out, a->length);
    assert_memory_equal(a->values, b->values, sizeof a->values);
    assert_string_equal(a->text, b->text);
    assert_int_equal(a->session.esr, b->session.esr);
    assert_int_equal(a->session.ese, b->session.ese);
    assert_int_equal(a->session.error_count, b->session.error_count);
    assert_int_equal(a->session.length, b->session.length);
}

static void pieces_make_no_difference(void **state)
{
    (void)state;
    for (unsigned round = 0; round < ROUNDS; round++) {
        char input[600];
        const size_t n = random_input(input, sizeof input);
        scpi_rig_init(&rig);
        scpi_rig_init(&other);
        scpi_rig_send_bytes(&rig, input, n);
        for (size_t at = 0; at < n;) {
            const size_t piece = 1u + below((unsigned)(n - at));
            assert_int_equal(dg_scpi_rx(&other.session, 0, &input[at], piece), piece);
            at += piece;
        }
        assert_same(&rig, &other);
    }
}

/* One form of a header: long or short, optional nodes or not, letters as they come. */
static size_t random_form(const char *header, char *to)
{
    size_t n = 0;
    bool skipped = false;
    bool brief = below(2) != 0;

    for (const char *at = header; *at != '\0'; at++) {
        if (*at == '[') {
            skipped = below(2) != 0;
        } else if (*at == ']') {
            skipped = false;
        } else if (!skipped && !(brief && *at >= 'a' && *at <= 'z')) {
            to[n++] = below(2) != 0 ? (char)(*at | ' ') : dg_text_upper(*at);
        }
        brief = *at == ':' ? below(2) != 0 : brief;
    }
    to[n] = '\0';
    return n;
}

static void rows_are_found(const struct dg_scpi_command *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        for (unsigned form = 0; form < FORMS; form++) {
            char header[HEADER_MAX];
            const size_t n = random_form(rows[i].header, header);
            if (rows[i].set != NULL) {
                assert_ptr_equal(dg_scpi_find(&rig.session, header, n, false), &rows[i]);
            }
            if (rows[i].query != NULL) {
                assert_ptr_equal(dg_scpi_find(&rig.session, header, n, true), &rows[i]);
            }
        }
    }
}

static void random_forms_are_found(void **state)
{
    (void)state;
    scpi_rig_init(&rig);
    rows_are_found(dg_scpi_own.rows, dg_scpi_own.count);
    rows_are_found(scpi_rig_commands, scpi_rig_command_count);
}

/* One character more is another header. */
static void damaged_forms_are_not(void **state)
{
    (void)state;
    for (size_t i = 0; i < scpi_rig_command_count; i++) {
        for (unsigned round = 0; round < FORMS; round++) {
            char header[HEADER_MAX];
            const size_t n = random_form(scpi_rig_commands[i].header, header);
            const size_t at = below((unsigned)n + 1u);
            memmove(&header[at + 1u], &header[at], n - at);
            header[at] = "QX_7"[below(4)];
            assert_false(dg_scpi_matches(scpi_rig_commands[i].header, header, n + 1u));
        }
    }
}

/* What the queue holds comes from lines, one each at most; nothing else is remembered of noise. */
static void noise_gives_one_error_a_line(void **state)
{
    (void)state;
    for (unsigned round = 0; round < ROUNDS; round++) {
        char line[700];
        const size_t n = below(sizeof line - 1u);
        for (size_t i = 0; i < n; i++) {
            line[i] = (char)(round % 2u != 0 ? below(256) : ' ' + below('~' - ' ' + 1u));
            line[i] = line[i] == '\n' || line[i] == '\r' ? '\0' : line[i];
        }
        line[n] = '\n';
        scpi_rig_init(&rig);
        scpi_rig_send_bytes(&rig, line, n + 1u);
        assert_int_equal(rig.length, 0);
        assert_true(rig.session.error_count <= 1);
        scpi_rig_send(&rig, "*TST?\n");
        assert_string_equal(rig.out, "0\n");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_make_no_difference),
        cmocka_unit_test(random_forms_are_found),
        cmocka_unit_test(damaged_forms_are_not),
        cmocka_unit_test(noise_gives_one_error_a_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
