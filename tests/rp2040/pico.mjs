// SPDX-License-Identifier: MIT
// A Raspberry Pi Pico in lockstep: the processor, both PIOs and the pins of rp2040js go by one count of cycles
// of 8 ns. What rp2040js does otherwise than silicon, and what is made of it here:
// - its PIO is not coupled to the processor and knows neither clock dividers nor delays: paced here
// - its inputs have no synchronisers: two cycles are added to every edge at a pin
// - a WAIT that is over costs a cycle less: added
// - its SysTick goes round a cycle early, every 2^24: counted here
// - its flash cannot be written: a ROM of our own calls us, see flash.mjs
// It leans on what is no interface of rp2040js (machines, step, waiting, cycles), whose version is pinned.
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

const { RP2040 } = createRequire(path.join(process.env.DREHGEBER_NODE, "package.json"))("rp2040js");
const IMAGES = process.env.DREHGEBER_IMAGES;
const ENTRY = 0x10000100; // stack and entry, where boot2 finds them
const SYST_CVR = 0x18;
const SYNCHRONISER = 2;
const UART_BITS = 10;

export const HZ = 125e6;
export const NS = 1e9 / HZ;
export const us = (n) => Math.round(n * HZ / 1e6);
export const ms = (n) => us(n * 1000);

/** Addresses of what has a name in an image. */
export function symbols(image) {
  const lines = execFileSync("arm-none-eabi-nm", [path.join(IMAGES, `${image}.elf`)], { encoding: "utf8" });
  return Object.fromEntries(lines.trim().split("\n").map((line) => line.split(" ")).filter((word) => word.length === 3)
    .map(([address, , name]) => [name, Number.parseInt(address, 16)]));
}

/** Where a constant of an image is in flash, from which it is copied. */
export function constants(image, name) {
  const at = symbols(image);
  return at[name] - at.ram_begin + at.ram_load;
}

export class Pico {
  /** `flash`: {at, bytes}, other than the image's; `patches`: numbers in it, {at, value, size} */
  constructor(image, { flash, patches = [] } = {}) {
    this.image = image;
    this.chip = new RP2040();
    this.complaints = [];
    const complain = (name, text) => this.complaints.push(`${name}: ${text}`);
    this.chip.logger = { debug() {}, info() {}, warn: complain, error: complain };
    this.chip.flash.fill(0xff, 0, 0x200000);
    this.chip.flash.set(fs.readFileSync(path.join(IMAGES, `${image}.bin`)));
    if (flash) this.chip.flash.set(flash.bytes, flash.at);
    for (const { at, value, size } of patches) {
      for (let i = 0; i < size; i++) this.chip.flash[at - 0x10000000 + i] = Number(BigInt(value) >> BigInt(8 * i) & 0xffn);
    }
    this.cycle = 0;
    this.asleep = 0; // cycles of it
    this.events = []; // {at, what}, sorted
    this.systick();
    for (const pio of this.chip.pio) {
      pio.run = () => {};
      pio.due = [0, 0, 0, 0];
      pio.waited = [false, false, false, false];
    }
    // What boot2 does.
    const { core } = this.chip;
    core.SP = this.chip.readUint32(ENTRY);
    core.PC = this.chip.readUint32(ENTRY + 4) & ~1;
  }

  systick() {
    const { ppb, clock } = this.chip, read = ppb.readUint32.bind(ppb);
    ppb.readUint32 = (offset) => offset === SYST_CVR ? -Math.round(clock.nanos / NS) & 0xffffff : read(offset);
  }

  /** Have something happen at a cycle. */
  at(cycle, what) {
    let i = this.events.length;
    while (i > 0 && this.events[i - 1].at > cycle) i--;
    this.events.splice(i, 0, { at: cycle, what });
  }

  /** An edge at a pin. */
  drive(cycle, pin, level) {
    this.at(cycle + SYNCHRONISER, () => this.chip.gpio[pin].setInputValue(level));
  }

  /** Collect edges of a pin: [{at, level}] */
  watch(pin) {
    const edges = [];
    this.chip.gpio[pin].addListener((value) => edges.push({ at: this.cycle, level: value === 1 ? 1 : 0 }));
    return edges;
  }

  pioCycle(pio) {
    for (let i = 0; i < 4; i++) {
      const machine = pio.machines[i];
      if (!machine.enabled || pio.due[i] > this.cycle) continue;
      if (machine.waiting) machine.checkWait();
      const waited = pio.waited[i];
      pio.waited[i] = machine.waiting;
      if (machine.waiting) continue;
      if (waited) {
        pio.due[i] = this.cycle + 1;
        continue;
      }
      const before = machine.cycles;
      machine.step();
      pio.waited[i] = machine.waiting;
      const divider = machine.clockDivInt + machine.clockDivFrac / 256 || 65536;
      // What a machine with a divider does falls behind by parts of a cycle, which add up.
      pio.due[i] = (divider === 1 ? this.cycle : Math.max(pio.due[i], this.cycle - 1)) +
        Math.max(1, machine.cycles - before) * divider;
    }
    pio.checkChangedPins();
  }

  /** Cycles in which no machine does anything: all wait, or are in the middle of an instruction. */
  idle(pio) {
    if (pio.stopped) return Infinity;
    let cycles = Infinity;
    for (let i = 0; i < 4; i++) {
      const machine = pio.machines[i];
      if (!machine.enabled) continue;
      if (!machine.waiting || !pio.waited[i]) cycles = Math.min(cycles, Math.ceil(pio.due[i]) - this.cycle - 1);
    }
    return cycles;
  }

  /** Cycles until something happens while the processor sleeps. */
  quiet(end) {
    const { clock, pio } = this.chip;
    const still = Math.min(this.idle(pio[0]), this.idle(pio[1]));
    if (still < 1) return 1;
    const alarm = clock.nextAlarm ? Math.ceil(clock.nanosToNextAlarm / NS) : end - this.cycle;
    const event = this.events.length ? this.events[0].at - this.cycle : end - this.cycle;
    return Math.max(1, Math.min(still, alarm, event, end - this.cycle));
  }

  happen() {
    while (this.events.length && this.events[0].at <= this.cycle) this.events.shift().what();
  }

  /** Cycles pass: all of the chip but the processor. */
  pass(cycles) {
    const { clock, pio } = this.chip;
    for (const block of pio) if (block.stopped) block.checkChangedPins(); // by the processor
    clock.tick(cycles * NS);
    const event = this.events.length ? this.events[0].at - this.cycle : Infinity;
    if (cycles <= event && cycles <= Math.min(this.idle(pio[0]), this.idle(pio[1]))) {
      this.cycle += cycles;
      if (cycles === event) {
        this.happen();
        this.pioCycles(); // they see an edge in the cycle that it is in
      }
      return;
    }
    for (let i = 0; i < cycles; i++) {
      this.cycle++;
      this.happen();
      this.pioCycles();
    }
  }

  pioCycles() {
    for (const pio of this.chip.pio) {
      if (!pio.stopped) this.pioCycle(pio);
    }
  }

  run(cycles) {
    const end = this.cycle + cycles;
    const { core } = this.chip;
    while (this.cycle < end) {
      let taken;
      if (core.waiting) {
        taken = this.quiet(end);
        this.asleep += taken;
        if (core.interruptsUpdated && core.checkForInterrupts()) core.waiting = false;
      } else {
        taken = core.executeInstruction();
      }
      this.pass(taken);
    }
  }

  /** Run until something is so; at most for `cycles`. */
  until(condition, cycles) {
    const end = this.cycle + cycles;
    while (!condition()) {
      if (this.cycle >= end) throw new Error(`it was not so within ${cycles / ms(1)} ms`);
      this.run(us(1));
    }
  }

  /** A line to the console. */
  tell(line, baud = 115200) {
    const uart = this.chip.uart[0];
    this.told = Math.max(this.told ?? 0, this.cycle);
    for (const character of `${line}\n`) {
      this.told += UART_BITS * HZ / baud;
      this.at(Math.round(this.told), () => uart.feedByte(character.charCodeAt(0)));
    }
  }

  /** A line to the console, and its answer. */
  ask(line, within = ms(200)) {
    let answer = "";
    this.chip.uart[0].onByte = (byte) => { answer += String.fromCharCode(byte); };
    this.tell(line);
    this.until(() => answer.endsWith("\n"), within);
    return answer.trimEnd();
  }

  /** Several lines without an answer, and that there was no error. */
  order(...lines) {
    for (const line of lines) this.tell(line);
    const error = this.ask("SYST:ERR?", ms(500));
    if (!error.startsWith("0,")) throw new Error(`${lines}: ${error}`);
  }

  read64(address) {
    const read = (at) => BigInt(this.chip.readUint32(at));
    return read(address) | read(address + 4) << 32n;
  }
}
