/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: serial logs, in words and against an encoder on a line.
 */
#define _GNU_SOURCE
#include "explain_input.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    if (n > 0 && n < 2048 && read_events(&explain_serial, bytes, n)) {
        replay_events(bytes, n, "s3684-rs485");
    }
    return 0;
}
