// SPDX-License-Identifier: MIT
// A master on RS485, bit by bit: its characters at RX, what the encoder sends at TX, and DE around it.
import { HZ, ms, us } from "./pico.mjs";

const RX = 2, TX = 3, DE = 4;

const ones = (byte) => [...byte.toString(2)].filter((bit) => bit === "1").length;
export const xor = (bytes) => bytes.reduce((sum, byte) => sum ^ byte, 0);

export class Master {
  constructor(pico, { baud = 9600, parity = "E" } = {}) {
    Object.assign(this, { pico, baud, parity });
    this.tx = pico.watch(TX);
    this.de = pico.watch(DE);
    pico.chip.gpio[RX].setInputValue(true);
  }

  get bit() {
    return HZ / this.baud; // cycles
  }

  /** Bits of a character, from the start bit to the stop bit. */
  bits(byte) {
    const data = Array.from({ length: 8 }, (_, i) => byte >> i & 1);
    const parity = { N: [], E: [ones(byte) & 1], O: [ones(byte) & 1 ^ 1] }[this.parity];
    return [0, ...data, ...parity, 1];
  }

  /** Characters one behind the other; `spoil` may change the bits of one. @return when the last one ends */
  send(bytes, spoil = (bits) => bits) {
    let at = this.pico.cycle + 10;
    bytes.forEach((byte, i) => {
      spoil(this.bits(byte), i).forEach((bit) => {
        this.pico.drive(Math.round(at), RX, bit === 1);
        at += this.bit;
      });
    });
    this.pico.drive(Math.round(at), RX, true);
    this.pico.run(Math.ceil(at) - this.pico.cycle);
    return at;
  }

  levelAt(cycle) {
    return this.tx.findLast((edge) => edge.at <= cycle)?.level ?? 1;
  }

  /** What is sent until there is silence for 11 bits, of what TX has done since there were `from` edges: characters,
   * and edges that are not where they belong. */
  receive(within = ms(40), from = this.tx.length) {
    const { pico } = this, first = pico.cycle;
    const edges = () => this.tx.slice(from);
    const end = pico.cycle + within;
    while (!edges().length && pico.cycle < end) pico.run(us(20));
    if (!edges().length) return null;
    while (pico.cycle < edges().at(-1).at + 11 * this.bit) pico.run(us(20));
    const begin = edges()[0].at, length = this.bits(0).length, last = edges().at(-1).at, bytes = [];
    let at = begin, good = true;
    for (; at <= last; at += length * this.bit) {
      const bits = Array.from({ length }, (_, i) => this.levelAt(at + (i + 0.5) * this.bit));
      const byte = bits.slice(1, 9).reduce((value, bit, i) => value | bit << i, 0);
      good &&= bits.join() === this.bits(byte).join();
      bytes.push(byte);
    }
    // Edges against a clock that does not drift from the first start bit on.
    const jitter = Math.max(...edges().map((edge) => {
      const bits = (edge.at - begin) / this.bit;
      return Math.abs(bits - Math.round(bits));
    }));
    const up = this.de.findLast((edge) => edge.level === 1 && edge.at >= first);
    const down = this.de.findLast((edge) => edge.level === 0 && edge.at >= begin);
    return { bytes, good, jitter, begin, end: at, lead: (begin - up?.at) / this.bit, tail: (down?.at - at) / this.bit };
  }

  /** A request with its check sum, and what comes back. */
  ask(request, options = {}) {
    const frame = [...request, xor(request)];
    const sent = this.send(frame, options.spoil);
    const reply = this.receive(options.within);
    return reply && { ...reply, after: reply.begin - sent };
  }
}
