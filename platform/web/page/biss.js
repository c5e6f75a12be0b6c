// SPDX-License-Identifier: MIT
// A BiSS master, edge by edge, with 1 MHz: a frame with its waveform, and registers by the bits CDM and CDS that frames
// carry, one each. CDM is the clock inverted while the encoder's timeout runs.
import { unsigned } from "./rig.js";

const HALF = 500n;
const START_CLOCKS_MAX = 200;
const ZERO_FRAMES = 14;
const PATIENCE_NS = 40_000_000n;
const NEVER = (1n << 64n) - 1n;

// Remainder of bits times x^width, inverted.
function crc(bits, polynomial, width) {
  let remainder = 0;
  for (const bit of [...bits, ...Array(width).fill(0)]) {
    remainder = (remainder << 1) | bit;
    remainder ^= (remainder >> width) & 1 ? polynomial : 0;
  }
  return remainder ^ ((1 << width) - 1);
}

const crc4 = (bits) => crc(bits, 0x13, 4);
const crc6 = (bits) => crc(bits, 0x43, 6);
const bitsOf = (value, n) => Array.from({ length: n }, (_, i) => (value >> (n - 1 - i)) & 1);
const number = (bits) => bits.reduce((sum, bit) => sum * 2n + BigInt(bit), 0n);

export class BissMaster {
  constructor(encoder) {
    this.encoder = encoder;
    this.rig = encoder.rig;
    this.last = null; // frame: {ma, slo, marks, ...}
    this.control = []; // bits of the last access: {name, cdm, cds}
  }

  edge(ns, level) {
    this.now += ns;
    const slo = this.encoder.clock(this.now, level);
    this.ma.push({ at: this.now, level });
    return slo;
  }

  bit() {
    this.edge(HALF, 0);
    return this.edge(HALF, 1);
  }

  // A frame, latched half a clock from now; `cdm` may be a function of CDS.
  frame(cdm = 0) {
    const { encoder, rig } = this;
    encoder.edges.length = 0;
    this.ma = [];
    this.now = rig.now;
    const marks = [];
    const mark = (name) => marks.push({ at: this.now, name });
    this.edge(0n, 0);
    this.edge(HALF, 1);
    const at = this.now;
    mark("latch");
    this.bit(); // Ack
    let clocks = 0;
    while (!this.bit()) {
      if (++clocks === START_CLOCKS_MAX) {
        this.edge(HALF, 1);
        rig.advance(this.now - rig.now);
        throw new Error("the encoder does not answer");
      }
    }
    mark("S");
    const cds = this.bit();
    mark("CDS");
    const sizes = this.sizes();
    const bits = [];
    for (const [name, n] of sizes) {
      for (let i = 0; i < n; i++) {
        bits.push(this.bit());
        if (i === 0) {
          mark(name);
        }
      }
    }
    const sent = typeof cdm === "function" ? cdm(cds) : cdm;
    this.end(sent, mark);
    rig.advance(this.now - rig.now);
    this.last = { at, from: this.ma[0].at, to: this.now, ma: this.ma, slo: encoder.edges.slice(), marks, cdm: sent };
    return Object.assign(this.last, { cds, bits, ...BissMaster.decode(bits, sizes) });
  }

  end(cdm, mark) {
    const { c, bus } = this.encoder;
    this.edge(HALF, cdm ? 0 : 1);
    mark(`CDM ${cdm}`);
    const due = unsigned(c.dg_bus_step(bus, this.now));
    this.now = due === NEVER ? this.now : due;
    c.dg_bus_step(bus, this.now);
    this.edge(HALF, 1);
    mark("idle");
    this.now += HALF;
  }

  sizes() {
    const get = (key) => Number(this.encoder.setting(key));
    this.kept ??= [["MT", get("mt")], ["ST", get("st")], ["nERR", 1], ["nWARN", 1], ["LC", get("lc") ? 6 : 0], ["CRC", 6]];
    return this.kept;
  }

  static decode(bits, sizes) {
    const found = {};
    let at = 0;
    for (const [name, n] of sizes) {
      found[name] = number(bits.slice(at, at + n));
      at += n;
    }
    return { ...found, good: BigInt(crc6(bits.slice(0, -6))) === found.CRC };
  }

  // In the words of `drehgeber biss MODEL read`.
  words(frame) {
    const st = this.sizes()[1][1];
    const degrees = ((Number(frame.ST) * 360) / 2 ** st).toFixed(6);
    return (
      `MT ${frame.MT}  ST ${frame.ST}  ${degrees} deg  nERR ${frame.nERR}  nWARN ${frame.nWARN}  ` +
      `LC ${frame.LC}  CRC ${frame.good ? "valid" : "wrong"}`
    );
  }

  // nERR and nWARN are low when there is something.
  static severity({ nERR, nWARN, good }) {
    if (!good || nERR === 0n) {
      return "error";
    }
    return nWARN === 0n ? "warning" : "ok";
  }

  read() {
    const frame = this.frame(0);
    this.encoder.note(this.words(frame), true, BissMaster.severity(frame));
    return frame;
  }

  // ---------------------------------------------------------------- registers

  carry(name, cdm) {
    const { cds, cdm: sent } = this.frame(cdm);
    this.control.push({ name, cdm: sent, cds });
    return cds;
  }

  carryAll(name, bits) {
    return bits.map((bit) => this.carry(name, bit));
  }

  address(address, write) {
    const bits = [1, ...bitsOf(0, 3), ...bitsOf(address, 7)];
    for (let i = 0; i < ZERO_FRAMES; i++) {
      this.frame(0);
    }
    this.control = [];
    this.carry("S", 1);
    this.carryAll("CTS", bits.slice(0, 1));
    this.carryAll("ID", bits.slice(1, 4));
    this.carryAll("ADR", bits.slice(4));
    this.carryAll("CRC", bitsOf(crc4(bits), 4));
    this.carry("R", write ? 0 : 1);
    const r = this.carry("W", write ? 1 : 0);
    const w = this.carry("S", 1);
    return r === (write ? 0 : 1) && w === (write ? 1 : 0);
  }

  // S is repeated until it comes back, in a frame that has the first bit for its CDM.
  awaitStart(first) {
    const latest = this.rig.now + PATIENCE_NS;
    while (this.rig.now <= latest) {
      if (this.carry("S", (cds) => (cds ? first : 1))) {
        this.control.at(-1).name = "D";
        return true;
      }
    }
    return false;
  }

  // One byte. @return {byte, stop}
  exchange(byte, more) {
    const word = byte === null ? Array(12).fill(0) : [...bitsOf(byte, 8), ...bitsOf(crc4(bitsOf(byte, 8)), 4)];
    if (!this.awaitStart(word[0])) {
      throw new Error("the encoder does not answer");
    }
    const back = [...this.carryAll("D", word.slice(1, 8)), ...this.carryAll("CRC", word.slice(8)), this.carry("P", 0)];
    const stop = this.carry("S", (cds) => (more && !cds ? 1 : 0));
    const got = back.slice(0, 8);
    if (Number(number(back.slice(8))) !== crc4(got)) {
      throw new Error("the check sum of the register is wrong");
    }
    return { byte: Number(number(got)), stop: stop === 1 };
  }

  access(address, bytes) {
    const name = `register ${address.toString(16).toUpperCase().padStart(2, "0")}h`;
    const got = [];
    let stop = !this.address(address, bytes[0] !== null);
    for (let i = 0; i < bytes.length && !stop; i++) {
      const answer = this.exchange(bytes[i], i + 1 < bytes.length);
      stop = answer.stop;
      if (!stop) {
        got.push(answer.byte);
      }
    }
    const listed = got.map((byte) => byte.toString(16).toUpperCase().padStart(2, "0")).join(" ");
    if (got.length > 0) {
      this.encoder.note(`${name} = ${listed}`, true, "ok");
    } else {
      this.encoder.note(`${name}: refused`, true, "error");
    }
    return got;
  }

  readRegisters(address, n) {
    return this.access(address, Array(n).fill(null));
  }

  writeRegisters(address, bytes) {
    return this.access(address, [...bytes]);
  }
}
