// SPDX-License-Identifier: MIT
// The flash chip and the ROM's functions for it. The ROM is a stand-in: the real one is not ours, and rp2040js
// has no flash behind its SSI. Each function stops at a BKPT, which is done here, and waits as long as a
// W25Q16JV takes (typical times of its data sheet); interrupts go on meanwhile. The power can fail anywhere.
import { ms, us } from "./pico.mjs";

const FUNCTIONS = ["IF", "EX", "RE", "RP", "FC", "CX"];
const FIND = 0x100, FIRST = 0x200, EACH = 16, FIND_BREAK = 0, BUSY_BREAK = 0x20;
const AT = 0x10000000;
export const LOG = 0x1f0000, LOG_END = 0x200000;
export const SECTOR = 4096, PAGE = 256;
export const ERASE = ms(45), PROGRAM = us(400);

export class PowerCut extends Error {}

export class Flash {
  /** `cut`: {operation, part}: the power fails in this erase or program, counted from 0, when 0..1 of it is done. */
  constructor(pico, cut) {
    this.pico = pico;
    this.cut = cut;
    this.operations = []; // {what, address, at}
    this.until = 0;
    const rom = new Uint16Array(8192);
    const put = (address, ...words) => rom.set(words, address / 2);
    put(0x14, 0x80, 0, FIND | 1);
    put(FIND, 0xbe00 + FIND_BREAK, 0x4770); // bx lr
    FUNCTIONS.forEach((_, i) => put(FIRST + i * EACH, 0xbe01 + i, 0xbe00 + BUSY_BREAK, 0x2b00, 0xd1fc, 0x4770)); // cmp r3, #0; bne
    pico.chip.bootrom.set(new Uint32Array(rom.buffer));
    pico.chip.onBreak = (code) => this.called(code);
  }

  called(code) {
    const { registers } = this.pico.chip.core;
    if (code === FIND_BREAK) {
      const name = String.fromCharCode(registers[1] & 255, registers[1] >> 8);
      registers[0] = FIRST + FUNCTIONS.indexOf(name) * EACH + 1;
    } else if (code === BUSY_BREAK) {
      registers[3] = this.pico.cycle < this.until ? 1 : 0;
    } else if (FUNCTIONS[code - 1] === "RE") {
      this.work("erase", registers[0], registers[1], ERASE * registers[1] / SECTOR);
    } else if (FUNCTIONS[code - 1] === "RP") {
      const bytes = this.pico.chip.sram.slice(registers[1] - 0x20000000, registers[1] - 0x20000000 + registers[2]);
      this.work("program", registers[0], registers[2], PROGRAM * registers[2] / PAGE, bytes);
    }
  }

  work(what, address, n, cycles, bytes) {
    if (address < LOG || address + n > LOG_END) throw new Error(`${what} at ${address.toString(16)} is not in the log`);
    const { flash } = this.pico.chip;
    const fails = this.cut && this.operations.length === this.cut.operation;
    const done = fails ? Math.floor(n * this.cut.part) : n;
    for (let i = 0; i < done; i++) flash[address + i] = bytes ? flash[address + i] & bytes[i] : 0xff;
    this.operations.push({ what, address, at: this.pico.cycle });
    this.until = this.pico.cycle + cycles;
    if (fails) throw new PowerCut();
  }

  count(what) {
    return this.operations.filter((operation) => operation.what === what).length;
  }

  /** What is left when the power is gone. */
  kept() {
    return { at: LOG, bytes: this.pico.chip.flash.slice(LOG, LOG_END) };
  }
}
