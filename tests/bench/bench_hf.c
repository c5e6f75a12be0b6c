/* SPDX-License-Identifier: MIT */
/*
 * How fast the S36 with RS485 is in virtual time.
 *
 * bench_hf                  requests per second, one figure a line
 * bench_hf --callgrind N    exactly N requests 42h and nothing measured: the instructions of one
 *                           are the difference of two runs, divided by the difference of N
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "drehgeber/devices.h"
#include "hf_rig.h"

#define SECONDS_EACH 1.0
#define BATCH 1000u
#define CHARACTER_NS ((dg_ns)1145834) /* 11 bits at 9600 Bd */

static struct hf_rig rig;

/* What a drive asks while it runs: mostly positions, at times something else. */
static const char *const mix[] = {
    "42", "42", "42", "44 48", "42", "42", "42", "50", "42", "4A 00 00 20 55",
    "42", "42", "46", "42",    "42", "52", "42", "42", "4E", "4B 00 00 04 55 01 02 03 04",
};
#define MIX (sizeof mix / sizeof mix[0])

struct frame {
    uint8_t bytes[DG_HF_FRAME_MAX];
    size_t n;
};

static struct frame frame_of(const char *command)
{
    struct frame frame = {.bytes = {DG_HF_ADDRESS_DEFAULT}};

    frame.n = 1 + hf_rig_hex(command, &frame.bytes[1], sizeof frame.bytes - 2u);
    frame.bytes[frame.n] = hf_rig_xor(frame.bytes, frame.n);
    frame.n++;
    return frame;
}

/* One request as a port would see it: characters, end of frame, reply. */
static void exchange(const struct frame *frame)
{
    dg_ns deadline = DG_NEVER;

    for (size_t i = 0; i < frame->n; i++) {
        rig.now += CHARACTER_NS;
        deadline = dg_hf_rx(&rig.device, rig.now, frame->bytes[i], DG_HF_RX_OK);
    }
    while (deadline != DG_NEVER) {
        rig.now = deadline;
        deadline = dg_hf_step(&rig.device, rig.now);
    }
}

static double now_s(void)
{
    struct timespec t;

    (void)timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void measure(const char *what, const struct frame *frames, size_t count)
{
    const double begin = now_s();
    const unsigned before = rig.replies;
    uint64_t requests = 0;
    double elapsed;

    do {
        for (unsigned i = 0; i < BATCH; i++) {
            exchange(&frames[requests++ % count]);
        }
        elapsed = now_s() - begin;
    } while (elapsed < SECONDS_EACH);
    if ((unsigned)requests != rig.replies - before) {
        (void)fprintf(stderr, "%s: %" PRIu64 " requests, %u replies\n", what, requests,
                      rig.replies - before);
        exit(1);
    }
    (void)printf("%-32s %10.0f\n", what, (double)requests / elapsed);
}

int main(int argc, char **argv)
{
    const bool counted = argc == 3 && strcmp(argv[1], "--callgrind") == 0;
    const struct frame position = frame_of("42");
    struct frame frames[MIX];

    if (argc != 1 && !counted) {
        (void)fprintf(stderr, "usage: bench_hf [--callgrind N]\n");
        return 2;
    }
    if (hf_rig_init(&rig, dg_hf_model_of(dg_device_find("s3684-rs485"))) != DG_OK ||
        hf_rig_power_on(&rig) != DG_OK || hf_rig_ask(&rig, "4D 00 CF 55") != 0) {
        return 1;
    }
    rig.angle_per_ms = DG_TURN / 20; /* 3000 rpm */
    if (counted) {
        for (unsigned long n = strtoul(argv[2], NULL, 10); n > 0; n--) {
            exchange(&position);
        }
        return 0;
    }
    for (size_t i = 0; i < MIX; i++) {
        frames[i] = frame_of(mix[i]);
    }
    measure("requests/s, 42h", &position, 1);
    measure("requests/s, mix of 8 commands", frames, MIX);
    return 0;
}
