/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: pcap and pcapng of SocketCAN, in words and against a CANopen encoder.
 */
#define _GNU_SOURCE
#include "explain_input.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    if (n > 0 && n < 4096 && read_events(&explain_pcap, bytes, n)) {
        replay_events(bytes, n, "f3668");
    }
    return 0;
}
