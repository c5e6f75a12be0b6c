// SPDX-License-Identifier: MIT
// The SSI encoders on a Raspberry Pi Pico, clocked by a master that samples at falling edges.
import assert from "node:assert/strict";
import { test } from "node:test";

import { Flash } from "./flash.mjs";
import { HZ, NS, Pico, ms, us } from "./pico.mjs";

const CLOCK = 2, DATA = 3;
const MONOFLOP = us(20);
const AGE_US = 25;
const MODELS = { 13: { bits: 13, gray: true }, 25: { bits: 25, gray: true }, 28: { bits: 30, gray: false } };

const binary = (gray) => {
  for (let span = 1; span < 32; span *= 2) gray ^= gray >>> span;
  return gray >>> 0;
};

class Master {
  constructor(model) {
    this.model = MODELS[model];
    this.pico = new Pico(`drehgeber-ssi-${model}`);
    this.flash = new Flash(this.pico);
    this.edges = this.pico.watch(DATA);
    this.pico.chip.gpio[CLOCK].setInputValue(true);
    this.mhz = 1;
    this.pico.ask("*IDN?");
    this.pico.run(ms(120)); // the initialisation of the encoder
  }

  level(cycle) {
    return this.edges.findLast((edge) => edge.at <= cycle)?.level ?? 0;
  }

  /** @return what it sees at `clocks` falling edges behind the first one, and when data follows the clock */
  clock(clocks) {
    const { pico } = this, period = HZ / 1e6 / this.mhz, begin = pico.cycle + 10, falls = [], rises = [];
    for (let k = 0; k < clocks; k++) {
      falls.push(Math.round(begin + k * period));
      rises.push(Math.round(begin + (k + 0.5) * period));
      pico.drive(falls[k], CLOCK, false);
      pico.drive(rises[k], CLOCK, true);
    }
    this.f1 = falls[0];
    this.last = falls.at(-1);
    const end = rises.at(-1) + Math.round(period / 2);
    pico.run(end - pico.cycle);
    const late = this.edges.filter(({ at }) => at > rises[0] && at < end)
      .map(({ at }) => at - rises.findLast((rise) => rise <= at));
    return { bits: rises.map((rise, k) => this.level(falls[k + 1] ?? end)), late };
  }

  /** A word, with the 0 behind it, and the pause for a new one. */
  word() {
    const { bits, late } = this.clock(this.model.bits + 1);
    const word = bits.slice(0, -1).reduce((value, bit) => value * 2 + bit, 0);
    this.pico.run(Math.ceil(this.last + MONOFLOP + us(8) - this.pico.cycle));
    return { word, late, over: bits.at(-1), value: this.model.gray ? binary(word) : Math.floor(word / 4), flags: word % 4 };
  }
}

test("words of all models at 0.1, 1 and 2 MHz", (t) => {
  for (const model of Object.keys(MODELS)) {
    const master = new Master(model);
    assert.equal(master.level(master.pico.cycle), 1); // idle
    master.pico.order("SHAF:POS 123.456DEG");
    master.pico.run(us(200));
    const st = model === "28" ? 16 : 13;
    for (const mhz of [0.1, 1, 2]) {
      master.mhz = mhz;
      for (let i = 0; i < 5; i++) {
        const { word, value, late, over, flags } = master.word();
        assert.equal(value, Math.floor(123.456 / 360 * 2 ** st), `ssi-${model}, ${mhz} MHz`);
        assert.equal(over, 0);
        if (model === "28") {
          assert.equal(flags >> 1, 0); // no error, and even parity
          assert.equal([...word.toString(2)].filter((bit) => bit === "1").length % 2, 0);
        }
        assert.ok(Math.max(...late) * NS <= 80, "data follows the clock");
        if (i === 0 && mhz === 2) t.diagnostic(`ssi-${model}: data ${Math.min(...late) * NS} to ${Math.max(...late) * NS} ns behind the clock`);
      }
    }
    assert.deepEqual(master.pico.complaints, []);
  }
});

test("clocked on within tm the same word comes again, after tm a new one", () => {
  const master = new Master("13");
  master.pico.order("SHAF:VEL 3000RPM");
  master.pico.run(us(200));
  const { bits } = master.clock(2 * 14);
  assert.equal(bits.slice(0, 14).join(""), bits.slice(14).join(""));
  master.pico.run(us(40));
  assert.notEqual(master.word().word, Number.parseInt(bits.slice(0, 13).join(""), 2));
});

test("a word that was cut leaves nothing behind", () => {
  const master = new Master("25");
  master.pico.order("SHAF:POS 90DEG");
  for (let cut = 1; cut < 27; cut++) {
    master.clock(cut);
    assert.equal(master.level(master.pico.cycle + 1), master.level(master.pico.cycle)); // tm is not over
    master.pico.run(us(30));
    assert.equal(master.level(master.pico.cycle), 1);
    assert.equal(master.word().value, 2048, `cut behind ${cut} clocks`);
  }
});

test("a turning shaft: how old a position is", (t) => {
  const master = new Master("25");
  const rpm = 12000, perUs = rpm / 60e6 * 8192; // counts
  master.pico.order(`SHAF:POS 0DEG;VEL ${rpm}RPM`);
  master.pico.run(us(200));
  const origin = [];
  for (let i = 0; i < 200; i++) {
    const { value } = master.word();
    origin.push(master.f1 * NS / 1000 - (value + 0.5) / perUs); // when the shaft would have been at 0
    master.pico.run(us(50 + i * 3.7));
  }
  const spread = (Math.max(...origin) - Math.min(...origin)) / 2;
  t.diagnostic(`within ${spread.toFixed(1)} us of the first falling edge, give or take`);
  assert.ok(spread < AGE_US + 1);
});

test("the error bit, and silence without power", () => {
  const master = new Master("28");
  master.pico.order("WORL:TEMP 120DEGC");
  master.pico.run(us(200));
  assert.equal(master.word().flags >> 1, 1);
  master.pico.order("POW 0");
  assert.equal(master.level(master.pico.cycle), 0);
  assert.ok(master.clock(31).bits.every((bit) => bit === 0));
  master.pico.order("POW 1");
  master.pico.run(ms(150));
  assert.equal(master.level(master.pico.cycle), 1);
  master.word();
});
