/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: a client that sends anything. The input is a stream of operations: raw bytes,
 * pieces of commands, time, and how long things take. A second session gets the same bytes one at a
 * time. After each operation: the state is sound, both sessions are alike, a line gives one answer
 * at most, and what is answered is printable.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "fuzz_input.h"
#include "scpi_rig.h"

#define PIECES DG_COUNT(pieces)

struct bench {
    struct scpi_rig rigs[2]; /* at once, and byte by byte */
    dg_ns now;
};

static const char *const pieces[] = {
    "SHAF:POS ",
    "SHAFT:VELOCITY",
    "SHAF:ACC ",
    "TIME:STEP ",
    "WORL:TEMP ",
    "SUPP ",
    "LED:CURR ",
    "NUMB ",
    "VAL:NOW ",
    "SENS:",
    "FAUL:SET x,",
    "COUN 3,",
    "PROB 0.5",
    "DUR 2S",
    "BYT 1,2",
    "FLAG ON",
    "TEXT ",
    "PART? ",
    "NOTH?",
    "FAIL",
    "RAIS ",
    "*OPC",
    "*OPC?",
    "*WAI",
    "*CLS",
    "*ESR?",
    "*STB?",
    "*SRE ",
    "*ESE 255",
    "*RST",
    "*IDN?",
    "SYST:ERR?",
    "SYST:HELP?",
    "ALL?",
    "COUN?",
    "\n",
    ";",
    ":",
    "?",
    ",",
    " ",
    "'",
    "\"",
    "''",
    "#H",
    "0x",
    "#Q7",
    "#B1",
    "1.5E",
    "-",
    "9223372036854775807",
    "6000000000DEG",
    "0.000000001",
    "REV",
    "MS",
    "MIN",
    "MAX",
    "\r\n",
    "E-",
    "E+99999",
    ".",
    "RPM/S",
};

static size_t lines_in(const char *bytes, size_t n)
{
    size_t lines = 0;

    for (size_t i = 0; i < n; i++) {
        lines += bytes[i] == '\n' || bytes[i] == '\r' ? 1u : 0u;
    }
    return lines;
}

static void check_state(const struct dg_scpi *session)
{
    fuzz_must(session->length <= DG_SCPI_LINE_MAX);
    fuzz_must(session->at <= DG_SCPI_LINE_MAX);
    fuzz_must(session->path <= session->at);
    fuzz_must(session->error_count <= DG_SCPI_ERRORS_MAX);
    fuzz_must(session->error_first < DG_SCPI_ERRORS_MAX);
    fuzz_must(!session->waiting || session->executing);
    fuzz_must(!session->answer_due || session->waiting);
    fuzz_must(session->executing == session->waiting);
    fuzz_must(session->command == NULL);
    for (size_t i = 0; i < session->error_count; i++) {
        const struct dg_scpi_queued *error =
            &session->errors[(session->error_first + i) % DG_SCPI_ERRORS_MAX];
        fuzz_must(error->code != 0);
        fuzz_must(memchr(error->detail, '\0', sizeof error->detail) != NULL);
    }
}

/* Whole answers only, but for the one of a line that waits. */
static void check_output(const struct scpi_rig *rig, size_t lines)
{
    size_t answers = 0;

    for (size_t i = 0; i < rig->length; i++) {
        fuzz_must(rig->out[i] == '\n' || (rig->out[i] >= ' ' && rig->out[i] <= '~') ||
                  rig->out[i] == '\t');
        answers += rig->out[i] == '\n' ? 1u : 0u;
    }
    fuzz_must(answers <= lines);
    fuzz_must(rig->length == 0 || rig->session.waiting || rig->out[rig->length - 1u] == '\n');
}

static void check(const struct bench *bench)
{
    const struct scpi_rig *a = &bench->rigs[0];
    const struct scpi_rig *b = &bench->rigs[1];

    check_state(&a->session);
    check_state(&b->session);
    fuzz_must(a->lost || b->lost ||
              (a->length == b->length && memcmp(a->out, b->out, a->length) == 0));
    fuzz_must(memcmp(a->values, b->values, sizeof a->values) == 0);
    fuzz_must(a->session.esr == b->session.esr && a->session.ese == b->session.ese);
    fuzz_must(a->session.error_count == b->session.error_count);
    fuzz_must(a->session.waiting == b->session.waiting && a->session.opc == b->session.opc);
    fuzz_must(a->stops == b->stops && a->resets == b->resets);
}

static void forget_output(struct scpi_rig *rig)
{
    rig->length = 0;
    rig->out[0] = '\0';
    rig->lost = false;
}

/* What a session does not take while it waits is dropped, as if the client had not sent it. */
static void send_bytes(struct bench *bench, const char *bytes, size_t n)
{
    struct scpi_rig *const whole = &bench->rigs[0];
    struct scpi_rig *const single = &bench->rigs[1];
    const bool held = whole->session.waiting;
    const size_t lines = lines_in(bytes, n) + (held ? 1u : 0u);

    forget_output(whole);
    forget_output(single);
    const size_t taken = dg_scpi_rx(&whole->session, bench->now, bytes, n);
    (void)dg_scpi_rx(&single->session, bench->now, NULL, 0);
    for (size_t i = 0; i < taken; i++) {
        fuzz_must(dg_scpi_rx(&single->session, bench->now, &bytes[i], 1) == 1);
    }
    fuzz_must(taken == n || whole->session.waiting);
    if (!whole->lost && !single->lost) {
        check_output(whole, lines);
    }
}

/* Operations; each takes what it needs from the input. */

static void op_piece(struct bench *bench, struct fuzz_input *input)
{
    const char *const piece = pieces[fuzz_take(input) % PIECES];

    send_bytes(bench, piece, strlen(piece));
}

static void op_bytes(struct bench *bench, struct fuzz_input *input)
{
    size_t n = fuzz_take(input);

    n = n < (size_t)(input->end - input->at) ? n : (size_t)(input->end - input->at);
    send_bytes(bench, (const char *)input->at, n);
    input->at += n;
}

static void op_flood(struct bench *bench, struct fuzz_input *input)
{
    char bytes[DG_SCPI_LINE_MAX];

    memset(bytes, fuzz_take(input), sizeof bytes);
    send_bytes(bench, bytes, fuzz_take(input) * 2u);
}

static void op_time(struct bench *bench, struct fuzz_input *input)
{
    bench->now = dg_after(bench->now, (dg_ns)fuzz_take(input) << (fuzz_take(input) % 40u));
    forget_output(&bench->rigs[0]);
    forget_output(&bench->rigs[1]);
    const dg_ns a = dg_scpi_step(&bench->rigs[0].session, bench->now);
    const dg_ns b = dg_scpi_step(&bench->rigs[1].session, bench->now);
    fuzz_must(a == b && a > bench->now);
}

static void op_busy(struct bench *bench, struct fuzz_input *input)
{
    const dg_ns until = dg_after(bench->now, (dg_ns)fuzz_take(input) << (fuzz_take(input) % 40u));

    bench->rigs[0].settles = until;
    bench->rigs[1].settles = until;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct bench *, struct fuzz_input *) = {
        op_piece, op_piece, op_piece, op_piece, op_bytes, op_bytes, op_flood, op_time, op_busy,
    };
    static struct bench bench;
    struct fuzz_input input = {.at = bytes, .end = bytes + n};

    memset(&bench, 0, sizeof bench);
    scpi_rig_init(&bench.rigs[0]);
    scpi_rig_init(&bench.rigs[1]);
    while (input.at < input.end) {
        operations[fuzz_take(&input) % (DG_COUNT(operations))](&bench, &input);
        check(&bench);
    }
    return 0;
}
