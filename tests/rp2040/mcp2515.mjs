// SPDX-License-Identifier: MIT
// An MCP2515 on SPI0 with its /CS and /INT, as its data sheet DS20001801 describes it, and the bus behind it: as much
// as the firmware uses. Frames are {id, rtr, extended, data}; each takes its bits, without stuffed ones. It leaves the bus
// for another mode when what it sends is sent, and is on it again 11 bits later.
import { HZ } from "./pico.mjs";

const CS = 17, INT = 20;
const CRYSTAL = 16e6;
const RXF = [0x00, 0x04, 0x08, 0x10, 0x14, 0x18], RXM0 = 0x20, RXM1 = 0x24;
const CANSTAT = 0x0e, CANCTRL = 0x0f, TEC = 0x1c, CNF3 = 0x28, CNF2 = 0x29, CNF1 = 0x2a, CANINTE = 0x2b, CANINTF = 0x2c;
const EFLG = 0x2d, TXB0CTRL = 0x30, RXB0CTRL = 0x60, RXB1CTRL = 0x70;
const RX0IF = 1, RX1IF = 2, TX0IF = 4, ERRIF = 0x20, TXREQ = 8;
const TXEP = 0x10, TXBO = 0x20, RX1OVR = 0x80;
const MODE = 0xe0, CONFIGURATION = 0x80, ANY = 0x60, ROLLOVER = 4;
const CONFIGURED = [...RXF.flatMap((at) => [at, at + 1, at + 2, at + 3]), RXM0, RXM0 + 1, RXM1, RXM1 + 1, CNF3, CNF2, CNF1];

export class Mcp2515 {
  constructor(pico) {
    this.pico = pico;
    this.sent = []; // frames of the encoder, with the cycle at which they are complete
    this.alone = false; // nobody acknowledges
    this.filtered = 0; // frames that it did not want
    this.away = 0; // times it left the bus
    this.reset();
    this.bytes = null; // of the instruction at hand
    const spi = pico.chip.spi[0];
    spi.onTransmit = (byte) => {
      const answer = this.bytes ? this.exchange(byte) : 0xff;
      pico.at(pico.cycle + Math.round(8 * HZ / spi.clockFrequency), () => spi.completeTransmit(answer));
    };
    pico.chip.gpio[CS].addListener((value) => {
      if (value === 0) this.bytes = [];
      else if (this.bytes) this.end();
    });
    pico.chip.gpio[INT].setInputValue(true);
  }

  reset() {
    this.registers = new Uint8Array(128);
    this.registers[CANSTAT] = this.registers[CANCTRL] = CONFIGURATION;
  }

  get kbaud() {
    const { registers } = this;
    const quanta = 1 + (registers[CNF2] & 7) + 1 + (registers[CNF2] >> 3 & 7) + 1 + (registers[CNF3] & 7) + 1;
    return CRYSTAL / 2 / ((registers[CNF1] & 63) + 1) / quanta / 1000;
  }

  /** Sample point, of a bit. */
  get samplePoint() {
    const { registers } = this, before = 3 + (registers[CNF2] & 7) + (registers[CNF2] >> 3 & 7);
    return before / (before + 1 + (registers[CNF3] & 7));
  }

  get normal() {
    return (this.registers[CANSTAT] & MODE) === 0;
  }

  update() {
    this.pico.chip.gpio[INT].setInputValue((this.registers[CANINTF] & this.registers[CANINTE]) === 0);
  }

  write(at, value) {
    if (CONFIGURED.includes(at) && this.mode !== CONFIGURATION) throw new Error(`register ${at.toString(16)} is written on the bus`);
    this.registers[at] = value;
    if (at === CANCTRL) this.change();
    this.update();
  }

  get mode() {
    return this.registers[CANSTAT] & MODE;
  }

  /** The mode that is asked for. */
  change() {
    const { registers } = this, wanted = registers[CANCTRL] & MODE;
    if (wanted === this.mode || registers[TXB0CTRL] & TXREQ && this.normal) return;
    if (wanted === CONFIGURATION) {
      registers[CANSTAT] = CONFIGURATION;
      registers[TEC] = registers[EFLG] = 0;
      this.away++;
      return;
    }
    this.after(11, () => {
      registers[CANSTAT] = registers[CANCTRL] & MODE;
      this.transmit();
    });
  }

  /** A byte of an instruction; @return what is on SO meanwhile */
  exchange(byte) {
    const { bytes, registers } = this, n = bytes.length, [instruction, at] = bytes;
    bytes.push(byte);
    if (n === 0) return 0;
    if (instruction === 0x03 && n >= 2) return registers[at + n - 2]; // READ
    if (instruction === 0x02 && n >= 2) this.write(at + n - 2, byte); // WRITE
    if (instruction === 0x05 && n === 3) this.write(at, registers[at] & ~bytes[2] | byte & bytes[2]); // BIT MODIFY
    if (instruction === 0xa0) return (registers[TXB0CTRL] & TXREQ ? 4 : 0) | registers[CANINTF] & 3; // READ STATUS
    if (instruction === 0x40) registers[TXB0CTRL + n] = byte; // LOAD TX BUFFER
    if (instruction === 0x90) return registers[RXB0CTRL + n];
    if (instruction === 0x94) return registers[RXB1CTRL + n];
    return 0;
  }

  end() {
    const [instruction] = this.bytes;
    if (instruction === 0xc0) this.reset();
    if (instruction === 0x90 || instruction === 0x94) this.registers[CANINTF] &= ~(instruction === 0x90 ? RX0IF : RX1IF);
    if (instruction === 0x81) this.request();
    this.bytes = null;
    this.update();
  }

  bits(frame) {
    return 47 + 8 * (frame.rtr ? 0 : frame.data.length); // with the pause between frames
  }

  after(bits, what) {
    this.pico.at(this.pico.cycle + Math.round(bits * HZ / this.kbaud / 1000), what);
  }

  request() {
    this.registers[TXB0CTRL] |= TXREQ;
    this.transmit();
  }

  transmit() {
    const { registers } = this, [high, low, , , dlc] = registers.slice(TXB0CTRL + 1, TXB0CTRL + 6);
    const frame = { id: high << 3 | low >> 5, rtr: (dlc & 0x40) !== 0, data: [...registers.slice(TXB0CTRL + 6, TXB0CTRL + 6 + (dlc & 15))] };
    if (!this.normal || !(registers[TXB0CTRL] & TXREQ) || registers[EFLG] & TXBO) return;
    this.after(this.bits(frame), () => {
      if (this.alone) { // which only makes it passive
        this.count(Math.min(registers[TEC] + 8, 128));
        this.transmit();
        return;
      }
      registers[TXB0CTRL] &= ~TXREQ;
      registers[CANINTF] |= TX0IF;
      this.count(Math.max(registers[TEC] - 1, 0));
      this.sent.push({ ...frame, at: this.pico.cycle });
      this.change();
      this.update();
    });
  }

  /** The transmit error counter, and what comes of it. */
  count(errors) {
    const { registers } = this, before = registers[EFLG];
    registers[TEC] = Math.min(errors, 255);
    registers[EFLG] = before & ~(TXEP | TXBO) | (errors >= 256 ? TXBO : 0) | (errors >= 128 ? TXEP : 0);
    if (registers[EFLG] !== before) registers[CANINTF] |= ERRIF;
    this.update();
  }

  /** Too many errors, and the return from them. */
  disturb() {
    this.count(256);
    this.registers[TXB0CTRL] &= ~TXREQ;
    this.after(128 * 11, () => this.count(0));
  }

  /** Whether a frame passes one of a buffer's filters. */
  wants(frame, control, mask, filters) {
    const { registers } = this, id = (at) => registers[at] << 3 | registers[at + 1] >> 5;
    if ((registers[control] & ANY) === ANY) return true;
    return filters.some((at) => (registers[at + 1] & 8) / 8 === (frame.extended ? 1 : 0) && !((id(at) ^ frame.id) & id(mask)));
  }

  /** Somebody sends a frame; it is complete now. Of one with 29 bits `id` is the first eleven. */
  receive(frame) {
    const { registers } = this;
    if (!this.normal || registers[EFLG] & TXBO) return;
    const full = [RX0IF, RX1IF].map((flag) => (registers[CANINTF] & flag) !== 0);
    const first = this.wants(frame, RXB0CTRL, RXM0, RXF.slice(0, 2));
    const second = first ? full[0] && registers[RXB0CTRL] & ROLLOVER : this.wants(frame, RXB1CTRL, RXM1, RXF.slice(2));
    if (!first && !second) {
      this.filtered++;
      return;
    }
    if (full[second ? 1 : 0]) {
      registers[EFLG] |= RX1OVR;
      registers[CANINTF] |= ERRIF;
    } else {
      const at = (second ? RXB1CTRL : RXB0CTRL) + 1;
      const low = (frame.id & 7) << 5 | (frame.rtr && !frame.extended ? 0x10 : 0) | (frame.extended ? 8 : 0);
      registers.set([frame.id >> 3 & 255, low, 0, 0, frame.data.length | (frame.rtr && frame.extended ? 0x40 : 0), ...frame.data], at);
      registers[CANINTF] |= second ? RX1IF : RX0IF;
    }
    this.update();
  }
}
