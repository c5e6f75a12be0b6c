/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: sessions of sigrok, in words and against encoders on clocked lines.
 */
#define _GNU_SOURCE
#include "explain_input.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    if (n > 0 && n < 4096 && read_events(&explain_sr, bytes, n)) {
        replay_events(bytes, n, "s3684-biss");
        replay_events(bytes, n, "ssi-28");
    }
    return 0;
}
