/* SPDX-License-Identifier: MIT */
/*
 * The exchanges of bench_canopen.c with any stack. An answer is looked at as far as all stacks
 * agree: its identifier, that it is an abort or none, and its bytes where they are constants.
 */
#include <string.h>

#include "bench.h"
#include "peer.h"

#define SDO_ANSWER (0x580u + NODE_ID)
#define SDO_ABORT 0x80u
#define ABORT 1000u /* what an abort counts for */

const struct row rows[] = {
#include "rows.inc"
};
const size_t row_count = sizeof rows / sizeof rows[0];

static uint64_t answered;
static uint8_t last[8];

struct exchange {
    const struct peer_frame *frames;
    size_t count;
};

/* clang-format off */
#define SDO(...) {.id = 0x600u + NODE_ID, .dlc = 8, .data = {__VA_ARGS__}}
#define EXCHANGE(name, ...)                                                                        \
    static const struct peer_frame name##_frames[] = {__VA_ARGS__};                                \
    static const struct exchange name = {name##_frames, sizeof name##_frames / sizeof name##_frames[0]}

EXCHANGE(sync, {.id = 0x80});
EXCHANGE(upload_first, SDO(0x40, 0x00, 0x10, 0x00));
EXCHANGE(upload_middle, SDO(0x40, 0x03, 0x1A, 0x08));
EXCHANGE(upload_last, SDO(0x40, 0x0E, 0x65, 0x00));
EXCHANGE(upload_position, SDO(0x40, 0x04, 0x60, 0x00));
EXCHANGE(upload_nothing, SDO(0x40, 0x00, 0x50, 0x00));
EXCHANGE(download, SDO(0x2B, 0x17, 0x10, 0x00));
EXCHANGE(segmented, SDO(0x40, 0x08, 0x10, 0x00), SDO(0x60), SDO(0x70), SDO(0x60));
#ifndef PEER_WITHOUT_BLOCKS
EXCHANGE(block, SDO(0xA4, 0x08, 0x10, 0x00, 0x7F), SDO(0xA3), SDO(0xA2, 3, 0x7F), SDO(0xA1));
#endif
EXCHANGE(foreign, {.id = 0x181, .dlc = 8});
/* clang-format on */

void from_peer(uint16_t id, uint8_t dlc, const uint8_t *data)
{
    answered += id == SDO_ANSWER && data[0] == SDO_ABORT ? ABORT : 1u;
    memcpy(last, data, dlc <= 8 ? dlc : 8);
}

static void receive(const void *what)
{
    const struct exchange *exchange = what;

    for (size_t i = 0; i < exchange->count; i++) {
        to_peer(&exchange->frames[i]);
    }
}

static void pass(const void *what)
{
    (void)what;
    for (unsigned ms = 0; ms < 1000; ms++) {
        peer_wait();
    }
}

/* Lets TPDOs of other types have their say, and asks for 1000h: the same device type from
 * everybody. */
static bool start_node(void)
{
    static const struct peer_frame operational = {.dlc = 2, .data = {0x01, NODE_ID}};
    static const uint8_t type[8] = {0x43, 0x00, 0x10, 0x00, 0x96, 0x01, 0x02, 0x00};

    if (!peer_start()) {
        return false;
    }
    to_peer(&operational);
    receive(&sync);
    peer_wait();
    receive(&upload_first);
    return memcmp(last, type, sizeof type) == 0;
}

static uint64_t answers(void)
{
    return answered;
}

int main(int argc, char **argv)
{
    static const struct bench benches[] = {
        {"sync-to-tpdo", receive, &sync, 1, 1},
        {"upload-first", receive, &upload_first, 1, 1},
        {"upload-middle", receive, &upload_middle, 1, 1},
        {"upload-last", receive, &upload_last, 1, 1},
        {"upload-position", receive, &upload_position, 1, 1},
        {"upload-nothing", receive, &upload_nothing, ABORT, 1},
        {"download", receive, &download, 1, 1},
        {"segmented-upload-21", receive, &segmented, 4, 1},
#ifndef PEER_WITHOUT_BLOCKS
        {"block-upload-21", receive, &block, 5, 1},
#endif
        {"foreign-frame", receive, &foreign, 0, 1},
        {"millisecond", pass, NULL, 0, 1000},
    };
    static const struct bench_set set = {.benches = benches,
                                         .count = sizeof benches / sizeof benches[0],
                                         .start = start_node,
                                         .answers = answers};

    return bench_main(argc, argv, &set);
}
