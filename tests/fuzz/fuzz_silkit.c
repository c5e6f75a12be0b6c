/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: packed frames of a participant of a simulation. The input is a message. What is good
 * is frames that a bus can carry, and packed again it is the same but for its moments.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz_input.h"
#include "silkit_pack.h"

/* Where the moments are is the same in both. */
static void forget_moments(uint8_t *bytes, size_t n)
{
    struct dg_can_frame frame;
    size_t at = LX_SILKIT_PACK_HEAD;

    memset(bytes, 0, 8);
    for (size_t before = at; lx_silkit_pack_next(bytes, n, &at, &frame); before = at) {
        memset(bytes + before, 0, 4);
    }
}

static void check_again(const uint8_t *bytes, size_t n)
{
    struct lx_silkit_pack pack = {.bytes = NULL};
    struct dg_can_frame frame;
    uint8_t *copy = malloc(n);
    size_t at = LX_SILKIT_PACK_HEAD;

    fuzz_must(copy != NULL);
    memcpy(copy, bytes, n);
    forget_moments(copy, n);
    while (lx_silkit_pack_next(bytes, n, &at, &frame)) {
        fuzz_must(frame.id <= 0x7FF && frame.dlc <= 8 && at <= n);
        fuzz_must(lx_silkit_pack_add(&pack, 0, &frame));
    }
    fuzz_must(at == n);
    fuzz_must(pack.count == 0 ? n == LX_SILKIT_PACK_HEAD : pack.length == n);
    fuzz_must(pack.count == 0 || memcmp(pack.bytes, copy, n) == 0);
    lx_silkit_pack_free(&pack);
    free(copy);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    if (lx_silkit_pack_is_good(bytes, n)) {
        check_again(bytes, n);
    }
    return 0;
}
