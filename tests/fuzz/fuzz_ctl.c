/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: what `ctl` reads. The input is all that a hostile control plane answers. All lines
 * but the last one are printed as they came; the last one is the list of errors and decides how the
 * program ends.
 *
 * The linker puts the functions below in place of lx_endpoint_connect() and lx_complain().
 */
#define _GNU_SOURCE
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "ctl.h"
#include "endpoint.h"
#include "fuzz_input.h"
#include "run.h"

#define ANSWERS_MAX 65536u

/* The other end: `answers` are all it says. */
static const uint8_t *answers;
static size_t answers_length;
static int peer;

int __wrap_lx_endpoint_connect(const char *where, struct lx_error *error);
void __wrap_lx_complain(const char *format, ...);

int __wrap_lx_endpoint_connect(const char *where, struct lx_error *error)
{
    int ends[2];

    (void)where;
    (void)error;
    fuzz_must(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0);
    fuzz_must(send(ends[1], answers, answers_length, MSG_DONTWAIT) == (ssize_t)answers_length);
    fuzz_must(shutdown(ends[1], SHUT_WR) == 0);
    peer = ends[1];
    return ends[0];
}

void __wrap_lx_complain(const char *format, ...)
{
    fuzz_must(format != NULL);
}

int complain(const struct lx_error *error, int status)
{
    (void)error;
    return status;
}

/* Where the last line begins, whole or not. */
static size_t last_line(const uint8_t *bytes, size_t n)
{
    const size_t body = n > 0 && bytes[n - 1] == '\n' ? n - 1 : n;
    const uint8_t *end = body > 0 ? memrchr(bytes, '\n', body) : NULL;

    return end == NULL ? 0 : (size_t)(end + 1 - bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    char *const words[] = {(char[]){"*IDN?"}, (char[]){"SHAF:POS?"}};
    FILE *const terminal = stdout;
    const struct ctl_wanted wanted = {.address = "unix:nowhere"};
    char *printed = NULL;
    size_t printed_length = 0;

    if (n > ANSWERS_MAX) {
        return 0;
    }
    answers = bytes;
    answers_length = n;
    stdout = open_memstream(&printed, &printed_length);
    fuzz_must(stdout != NULL);
    const int status = ctl_command(&wanted, words, 2);
    (void)fclose(stdout);
    stdout = terminal;
    (void)close(peer);

    const size_t last = last_line(bytes, n);
    const bool good = n - last >= 2 && memcmp(bytes + last, "0,", 2) == 0;
    fuzz_must(printed_length == last && (last == 0 || memcmp(printed, bytes, last) == 0));
    fuzz_must(status == (good ? EXIT_OK : EXIT_OTHER));
    free(printed);
    return 0;
}
