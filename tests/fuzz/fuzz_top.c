/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: what `top` reads. The input is what a hostile control plane answers, and what the
 * user does meanwhile. Texts that come to the screen end where they must and are printable, places
 * in lists exist, and a connection that breaks is told.
 */
#define _GNU_SOURCE
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "fuzz_input.h"
#include "timer.h"
#include "top_client.h"

#define MARK "1999.0;"
#define QUESTIONS 4096u

/* The client and the other end of its connections. */
static struct bench {
    sd_event *event;
    struct top_view view;
    struct top_client *client;
    int listener;
    int peer; /* -1: none */
    struct sockaddr_un address;
} bench;

static bool printable(const char *text, size_t size)
{
    const char *end = memchr(text, '\0', size);

    fuzz_must(end != NULL);
    for (; text < end; text++) {
        if (*text < ' ' || *text > '~') {
            return false;
        }
    }
    return true;
}

#define PRINTABLE(array) fuzz_must(printable(array, sizeof(array)))

static void check_encoder(const struct top_encoder *encoder)
{
    PRINTABLE(encoder->name);
    PRINTABLE(encoder->model);
    PRINTABLE(encoder->wire);
    PRINTABLE(encoder->mode);
    PRINTABLE(encoder->position);
    PRINTABLE(encoder->leds);
    PRINTABLE(encoder->errors);
    PRINTABLE(encoder->faults);
    PRINTABLE(encoder->more);
    fuzz_must(encoder->shaft == TOP_NONE || encoder->shaft < bench.view.shaft_count);
    fuzz_must(encoder->rate >= -1);
}

static void check(void)
{
    const struct top_view *view = &bench.view;

    for (size_t i = 0; i < view->encoder_count; i++) {
        check_encoder(&view->encoders[i]);
    }
    for (size_t i = 0; i < view->shaft_count; i++) {
        PRINTABLE(view->shafts[i].name);
        fuzz_must(view->shafts[i].encoder == TOP_NONE ||
                  view->shafts[i].encoder < view->encoder_count);
    }
    fuzz_must(view->frame_count <= TOP_FRAMES && view->fault_count <= DG_FAULTS_MAX);
    for (size_t i = 0; i < view->frame_count; i++) {
        PRINTABLE(view->frames[i]);
    }
    for (size_t i = 0; i < view->fault_count; i++) {
        PRINTABLE(view->faults[i].name);
        PRINTABLE(view->faults[i].cause);
        PRINTABLE(view->faults[i].effect);
    }
    PRINTABLE(view->time);
    PRINTABLE(view->trouble);
    PRINTABLE(view->message);
    fuzz_must(view->selected < view->encoder_count || view->selected == 0);
}

static void ignore(void *ctx)
{
    (void)ctx;
}

static void serve(void)
{
    int result;

    do {
        result = sd_event_run(bench.event, 0);
        check();
    } while (result > 0);
    fuzz_must(result == 0);
}

/* Whoever asks must not be kept from asking. */
static void read_questions(void)
{
    char bytes[QUESTIONS];

    while (bench.peer >= 0 && recv(bench.peer, bytes, sizeof bytes, MSG_DONTWAIT) > 0) {
    }
}

static void send_bytes(const void *bytes, size_t n)
{
    if (bench.peer >= 0 && n > 0) {
        (void)send(bench.peer, bytes, n, MSG_NOSIGNAL | MSG_DONTWAIT);
    }
}

static void hang_up(void)
{
    if (bench.peer >= 0) {
        (void)close(bench.peer);
    }
    bench.peer = -1;
}

/* --- operations --- */

static size_t some(struct fuzz_input *input)
{
    const size_t left = (size_t)(input->end - input->at);
    const size_t wanted = fuzz_take(input);

    return wanted < left ? wanted : left > 0 ? left - 1u : 0;
}

static void op_bytes(struct fuzz_input *input)
{
    const size_t n = some(input);

    send_bytes(input->at, n);
    input->at += n;
}

/* A line as it should be. */
static void op_line(struct fuzz_input *input)
{
    const size_t n = some(input);

    send_bytes(MARK, strlen(MARK));
    send_bytes(input->at, n);
    send_bytes("\n", 1);
    input->at += n;
}

/* Encoders and shafts to talk about. */
static void op_catalogue(struct fuzz_input *input)
{
    static const char two[] =
        MARK "\"a1\",\"b2\";\"main\",\"pitch\"\n" MARK "\"f3668\";\"can:can0/63\";\"main\"\n";

    (void)input;
    send_bytes(two, strlen(two));
}

static void op_serve(struct fuzz_input *input)
{
    (void)input;
    read_questions();
    serve();
}

static void op_tick(struct fuzz_input *input)
{
    const dg_ns later = (dg_ns)(fuzz_take(input) & 15u) * DG_S(1);

    bench.view.rows = 2;
    top_client_tick(bench.client, dg_after(lx_now(), later));
    const int peer = accept4(bench.listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (peer >= 0) {
        hang_up();
        bench.peer = peer;
    }
    check();
}

static void op_hang_up(struct fuzz_input *input)
{
    (void)input;
    hang_up();
}

static void op_select(struct fuzz_input *input)
{
    const size_t wanted = fuzz_take(input);

    if (wanted < bench.view.encoder_count) {
        bench.view.selected = wanted;
        bench.view.faults_of = wanted;
        top_client_ask_faults(bench.client, wanted);
    }
}

static void op_do(struct fuzz_input *input)
{
    (void)top_client_do(bench.client, fuzz_take(input), "POW OFF");
    (void)top_fault_active(&(struct top_encoder){.faults = "a b"}, "b");
}

/* --- an input --- */

static void remove_file(void)
{
    (void)unlink(bench.address.sun_path);
}

static void open_listener(void)
{
    fuzz_must(sd_event_new(&bench.event) >= 0);
    bench.address.sun_family = AF_UNIX;
    (void)snprintf(bench.address.sun_path, sizeof bench.address.sun_path, "/tmp/fuzz_top.%d",
                   (int)getpid());
    remove_file();
    fuzz_must(atexit(remove_file) == 0);
    bench.listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    fuzz_must(bind(bench.listener, (const struct sockaddr *)&bench.address, sizeof bench.address) ==
              0);
    fuzz_must(listen(bench.listener, 4) == 0);
}

static void set_up(void)
{
    struct lx_error error;

    if (bench.event == NULL) {
        open_listener();
    }
    bench.view = (struct top_view){.faults_of = TOP_NONE};
    (void)snprintf(bench.view.where, sizeof bench.view.where, "unix:%s", bench.address.sun_path);
    bench.client = top_client_open(bench.event, &bench.view, ignore, NULL, &error);
    fuzz_must(bench.client != NULL);
    bench.peer = accept4(bench.listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    fuzz_must(bench.peer >= 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct fuzz_input *) = {
        op_bytes, op_line, op_line,    op_line,   op_catalogue, op_serve,
        op_tick,  op_tick, op_hang_up, op_select, op_do,
    };
    struct fuzz_input input = {.at = bytes, .end = bytes + n};

    set_up();
    while (input.at < input.end) {
        operations[fuzz_take(&input) % (DG_COUNT(operations))](&input);
    }
    serve();
    hang_up();
    serve();
    top_client_close(bench.client);
    return 0;
}
