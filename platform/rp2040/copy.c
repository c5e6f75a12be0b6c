/* SPDX-License-Identifier: MIT */
/* What of the C library the core calls. Those of newlib-nano go byte by byte, which costs a latch
   200 cycles. */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

static int aligned(const void *a, const void *b)
{
    return (((uintptr_t)a | (uintptr_t)b) & 3u) == 0;
}

/* Whole words, four at a time. @return bytes that are left */
static inline size_t copy_words(uint8_t **to, const uint8_t **from, size_t n)
{
    uint8_t *out = *to;
    const uint8_t *in = *from;

    for (; n >= 16u; n -= 16u) {
        __asm volatile("ldmia %0!, {r3, r4, r5, r6}\n\tstmia %1!, {r3, r4, r5, r6}"
                       : "+l"(in), "+l"(out)
                       :
                       : "r3", "r4", "r5", "r6", "memory");
    }
    if ((n & 8u) != 0) {
        __asm volatile("ldmia %0!, {r3, r4}\n\tstmia %1!, {r3, r4}"
                       : "+l"(in), "+l"(out)
                       :
                       : "r3", "r4", "memory");
    }
    if ((n & 4u) != 0) {
        __asm volatile("ldmia %0!, {r3}\n\tstmia %1!, {r3}"
                       : "+l"(in), "+l"(out)
                       :
                       : "r3", "memory");
    }
    *to = out;
    *from = in;
    return n & 3u;
}

void *memcpy(void *restrict to, const void *restrict from, size_t n)
{
    uint8_t *out = to;
    const uint8_t *in = from;

    if (aligned(to, from)) {
        n = copy_words(&out, &in, n);
    }
    while (n-- > 0) {
        __asm volatile("");
        *out++ = *in++;
    }
    return to;
}

void *memset(void *to, int value, size_t n)
{
    uint8_t *out = to;

    if (aligned(to, to)) {
        for (; n >= 4u; n -= 4u, out += 4) {
            __asm volatile("");
            *(uint32_t *)(void *)out = (uint8_t)value * 0x01010101u;
        }
    }
    while (n-- > 0) {
        __asm volatile("");
        *out++ = (uint8_t)value;
    }
    return to;
}
