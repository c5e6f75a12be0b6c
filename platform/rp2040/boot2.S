/* SPDX-License-Identifier: MIT */
/* The first 256 bytes of flash, which the ROM loads to SRAM and starts when their CRC is right
   (data sheet, 2.8.1.3.1); the CRC is tools/rp2040/uf2's to fill in. Flash is read with the ROM's own
   slow command from then on: once, as all code is copied to SRAM. */
    .syntax unified
    .cpu cortex-m0plus
    .thumb
    .section .boot2, "ax"
    .global boot2
    .thumb_func
boot2:
    movs r2, #0x14          /* the ROM's table of functions, and what finds them in it (2.8.2) */
    ldrh r0, [r2]
    ldr r1, =0x5843         /* 'C', 'X': flash_enter_cmd_xip */
    movs r2, #0x18
    ldrh r3, [r2]
    blx r3
    blx r0
    ldr r0, =0x10000100     /* stack and entry, see link.ld */
    ldmia r0!, {r1, r2}
    msr msp, r1
    bx r2
    .pool
