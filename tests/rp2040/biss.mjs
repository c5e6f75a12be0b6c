// SPDX-License-Identifier: MIT
// A BiSS-C master, made of the protocol description Rev C6 and the manual: clocks MA, samples SLO, checks
// CRCs by themselves, carries out register accesses with CDM and CDS.
import { HZ, us } from "./pico.mjs";

const MA = 2, SLO = 3;
const TIMEOUT_US = 13;
// It samples at the next rising edge, and as much later as the line is long.
const LINE = 0;

const crc = (bits, degree, polynomial) => {
  const top = degree - 1, mask = (1 << degree) - 1;
  const sum = bits.reduce((sum, bit) => (sum << 1 & mask) ^ ((sum >> top & 1) ^ bit ? polynomial : 0), 0);
  return sum ^ mask;
};
export const crc6 = (bits) => crc(bits, 6, 0x03);
export const crc4 = (bits) => crc(bits, 4, 0x03);
export const number = (bits) => bits.reduce((value, bit) => value * 2 + bit, 0);
export const bitsOf = (value, n) => Array.from({ length: n }, (_, i) => value >> n - 1 - i & 1);

export class Master {
  constructor(pico, { mhz = 10, multiturn = 12, singleturn = 21, lifeBits = 6, timeoutUs = TIMEOUT_US } = {}) {
    Object.assign(this, { pico, mhz, multiturn, singleturn, lifeBits, timeoutUs });
    this.edges = pico.watch(SLO);
    this.level = 1;
    this.gapUs = 0.6; // from the timeout to the next frame
    pico.chip.gpio[MA].setInputValue(true);
  }

  /** Clocks for a start bit within 40 us at the latest, and a frame. */
  get clocks() {
    return Math.ceil(40 * this.mhz) + this.multiturn + this.singleturn + 20;
  }

  levelAt(cycle) {
    const before = this.edges.findLast((edge) => edge.at <= cycle);
    return before ? before.level : this.level;
  }

  /** `cdm`: a level, or what makes one of the CDS that has come. @return cycles of the rising edges, SLO as sampled,
   * SLO's edges, the end of the last clock */
  clock(clocks, cdm) {
    const { pico } = this, half = HZ / 1e6 / this.mhz / 2, begin = pico.cycle + 10, rises = [];
    const before = this.level = this.edges.at(-1)?.level ?? this.level;
    this.edges.length = 0;
    for (let k = 0; k < clocks; k++) {
      pico.drive(Math.round(begin + 2 * k * half), MA, false);
      rises.push(Math.round(begin + (2 * k + 1) * half));
      pico.drive(rises[k], MA, true);
    }
    const end = Math.round(begin + 2 * clocks * half);
    pico.run(end + LINE - pico.cycle);
    const bits = rises.map((rise, k) => this.levelAt((rises[k + 1] ?? rise + 2 * half) + LINE));
    const start = bits.indexOf(1, bits.indexOf(0)), low = typeof cdm === "function" ? cdm(bits[start + 1]) : cdm;
    const over = pico.cycle + us(this.timeoutUs + this.gapUs);
    if (low) {
      pico.drive(pico.cycle, MA, false);
      pico.drive(over, MA, true);
    }
    pico.run(over + (low ? us(0.5) : 0) - pico.cycle);
    return { rises, bits, start, end, before, edges: [...this.edges] };
  }

  /** A whole frame. */
  frame(cdm = 0, clocks = this.clocks) {
    const seen = this.clock(clocks, cdm), { bits } = seen;
    const { start } = seen, from = start + 1;
    const data = bits.slice(from + 1, from + 3 + this.multiturn + this.singleturn + this.lifeBits);
    const sum = bits.slice(from + 1 + data.length, from + 7 + data.length);
    const st = this.multiturn + this.singleturn;
    const idle = seen.before === 1 || this.fresh; // after power-on SLO is low up to e1
    this.fresh = false;
    return {
      ...seen,
      data: [...data, ...sum],
      e1: seen.rises[0],
      delay: (seen.rises[start] - seen.rises[0]) / HZ * 1e6, // us from e1 to the start bit
      cds: bits[from],
      position: number(data.slice(0, st)),
      nerr: data[st],
      nwarn: data[st + 1],
      life: number(data.slice(st + 2)),
      good: idle && bits[0] === 1 && bits[1] === 0 && start > 1 && sum.length === 6 && number(sum) === crc6(data),
    };
  }

  /** A frame of a register access; @return CDS */
  bit(cdm) {
    const frame = this.frame(cdm);
    if (!frame.good) throw new Error("a frame of a register access is wrong");
    return frame.cds;
  }

  send(bits) {
    return bits.map((bit) => this.bit(bit));
  }

  /** S until it comes back: the frame it comes back in has `first` for its CDM. */
  await(first) {
    for (let tries = 0; tries < 5000; tries++) {
      let back = 0;
      this.bit((cds) => { back = cds; return cds ? first : 1; });
      if (back) return tries;
    }
    throw new Error("the slave is busy for ever");
  }

  /** @return false: refused */
  address(register, write) {
    const head = [1, 0, 0, 0, ...bitsOf(register, 7)]; // CTS, ID 0
    this.send([...Array(14).fill(0), 1, ...head, ...bitsOf(crc4(head), 4)]);
    this.bit(write ? 0 : 1); // R, and W; what comes back is a frame behind
    const r = this.bit(write ? 1 : 0);
    const w = this.bit(1);
    return r !== w && w === (write ? 1 : 0);
  }

  /** Registers from `first` on; `bytes` are written, or as many are read. */
  access(first, bytes, write) {
    if (!this.address(first, write)) throw new Error(`register ${first.toString(16)} is refused`);
    const result = [];
    this.waited = 0;
    bytes.forEach((byte, i) => {
      const data = bitsOf(byte, 8), word = write ? [...data, ...bitsOf(crc4(data), 4)] : Array(12).fill(0);
      this.waited += this.await(word[0]);
      const back = this.send([...word.slice(1), 0]);
      const last = i + 1 === bytes.length;
      let stop = 0;
      this.bit((cds) => { stop = cds; return !last && !cds ? 1 : 0; });
      if (number(back.slice(8)) !== crc4(back.slice(0, 8))) throw new Error("CRC4 of a register is wrong");
      if (stop) throw new Error(`register ${(first + i).toString(16)} is refused`);
      result.push(number(back.slice(0, 8)));
    });
    return result;
  }

  read(first, n) {
    return this.access(first, Array(n).fill(0), false);
  }

  write(first, bytes) {
    this.access(first, bytes, true);
  }
}
