/* SPDX-License-Identifier: MIT */
/*
 * What the compiler and src/ call, without a C library. Copies and fills are instructions of the
 * machine (bulk memory).
 */
#include <string.h>

void *memcpy(void *restrict to, const void *restrict from, size_t n)
{
    return __builtin_memcpy(to, from, n);
}

void *memmove(void *to, const void *from, size_t n)
{
    return __builtin_memmove(to, from, n);
}

void *memset(void *to, int byte, size_t n)
{
    return __builtin_memset(to, byte, n);
}

int memcmp(const void *left, const void *right, size_t n)
{
    const unsigned char *a = left;
    const unsigned char *b = right;

    for (size_t i = 0; i < n; i++) {
        if (a[i] != b[i]) {
            return a[i] < b[i] ? -1 : 1;
        }
    }
    return 0;
}

/* Products that may be too long for 64 bits are made by this; it has to do without them itself. */
__int128 __multi3(__int128 left, __int128 right);
__int128 __multi3(__int128 left, __int128 right)
{
    const unsigned long long a = (unsigned long long)left;
    const unsigned long long b = (unsigned long long)right;
    const unsigned long long low = 0xFFFFFFFFu;
    const unsigned long long ll = (a & low) * (b & low);
    const unsigned long long hl = (a >> 32) * (b & low) + (ll >> 32);
    const unsigned long long lh = (a & low) * (b >> 32) + (hl & low);
    unsigned long long high = (a >> 32) * (b >> 32) + (hl >> 32) + (lh >> 32);

    high += (unsigned long long)(left >> 64) * b + a * (unsigned long long)(right >> 64);
    return (__int128)((unsigned __int128)high << 64 | (lh << 32 | (ll & low)));
}
