/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: logs of candump, in words and against a CANopen encoder.
 */
#define _GNU_SOURCE
#include "explain_input.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    if (n > 0 && n < 4096 && read_events(&explain_candump, bytes, n)) {
        replay_events(bytes, n, "f3668");
    }
    return 0;
}
