// SPDX-License-Identifier: MIT
// The S36 with BiSS-C on a Raspberry Pi Pico, clocked by a master of its own.
import assert from "node:assert/strict";
import { test } from "node:test";

import { Master } from "./biss.mjs";
import { Flash } from "./flash.mjs";
import { HZ, NS, Pico, ms, symbols, us } from "./pico.mjs";

const IMAGE = "drehgeber-s3684-biss";
const COUNTS = 2 ** 33; // 12 and 21 bits
const START_MAX_US = 40; // BiSS C, table 2
const LATCH_CYCLES_MAX = 2400;

function started(options = {}, kept = undefined, levels = {}) {
  const pico = new Pico(IMAGE, { flash: kept });
  for (const [pin, level] of Object.entries(levels)) pico.chip.gpio[pin].setInputValue(level);
  const flash = new Flash(pico);
  const master = new Master(pico, options);
  pico.ask("*IDN?");
  pico.run(ms(120)); // the initialisation of the encoder
  master.frame(); // after power-on SLO is low up to the first e1
  return { pico, flash, master };
}

/** What has to be added to 8 ns a cycle to have the time of the firmware. */
function offsetOf(pico) {
  const zero = pico.chip.readUint32(symbols(IMAGE).cycles_at_zero);
  const micros = Math.floor(pico.cycle * NS / 1000);
  const ahead = (-pico.chip.ppb.readUint32(0x18) - zero - micros * 125) << 8 >> 8;
  return BigInt(micros * 1000 + ahead * 8 - pico.cycle * NS);
}

test("SLO is low from power-on to the first clock", () => {
  const pico = new Pico(IMAGE);
  new Flash(pico);
  const master = new Master(pico);
  pico.ask("*IDN?");
  assert.equal(master.edges.at(-1).level, 0);
  assert.equal(master.frame().bits[0], 1);
  assert.equal(master.edges.at(-1).level, 1);
});

test("frames are right at 0.5, 1, 5, 10 and 11 MHz", (t) => {
  const { pico, master } = started();
  pico.order("SHAF:POS 123.456DEG");
  for (const mhz of [0.5, 1, 5, 10, 11]) {
    master.mhz = mhz;
    const late = new Set();
    for (let i = 0; i < 20; i++) {
      const frame = master.frame(i & 1);
      assert.ok(frame.good, `${mhz} MHz, frame ${i}`);
      assert.equal(frame.position, Math.floor(123.456 / 360 * 2 ** 21));
      assert.ok(frame.nerr && frame.nwarn);
      assert.ok(frame.delay < START_MAX_US, `start bit ${frame.delay} us behind e1`);
      for (const { at } of frame.edges) {
        const rise = frame.rises.findLast((rise) => rise <= at);
        if (at <= frame.end) late.add(at - rise);
      }
    }
    const most = Math.max(...late) * NS;
    t.diagnostic(`${mhz} MHz: SLO follows MA within ${Math.min(...late) * NS} to ${most} ns`);
    assert.ok(most <= 48);
  }
  assert.deepEqual(pico.complaints, []);
});

test("the highest clock with valid frames", (t) => {
  const { pico, master } = started();
  pico.order("SHAF:POS 123.456DEG");
  let highest = 0;
  for (const mhz of [10, 11, 12, 12.5, 13, 14, 15, 16, 18, 20]) {
    master.mhz = mhz;
    if (!Array.from({ length: 40 }, (_, i) => master.frame(i & 1)).every(({ good }) => good)) break;
    highest = mhz;
  }
  t.diagnostic(`${highest} MHz, point to point without delay`);
  assert.ok(highest >= 11);
});

test("1000 frames of a ramping shaft: each position is that of e1", (t) => {
  const { pico, master } = started();
  const rpmPerS = 12000;
  pico.order(`SHAF:POS 0DEG;ACC ${rpmPerS}RPM/S;VEL 6000RPM`);
  const offset = offsetOf(pico);
  const at = pico.read64(symbols(IMAGE).port_shaft); // course.at
  const differences = {};
  let last = 0n;
  for (let i = 0; i < 1000; i++) {
    const frame = master.frame();
    assert.ok(frame.good, `frame ${i}`);
    const e1 = BigInt(frame.e1) * BigInt(NS) + offset - at;
    assert.ok(e1 > 0n && e1 < 500000000n, "the ramp lasts half a second");
    const counts = e1 * e1 * BigInt(rpmPerS) * (1n << 21n) / (120n * 10n ** 18n);
    const difference = Number(BigInt(frame.position) - counts % BigInt(COUNTS));
    differences[difference] = (differences[difference] ?? 0) + 1;
    assert.ok(Math.abs(difference) <= 1, `frame ${i}: ${difference} counts off`);
    last = e1;
    pico.run(us(300));
  }
  t.diagnostic(`up to ${Math.round(rpmPerS * Number(last) / 1e9)} rpm; counts off: ${JSON.stringify(differences)}`);
});

test("from e1 to the FIFO in at most 2400 cycles, whatever the shaft does", (t) => {
  const { pico, master } = started();
  const machine = pico.chip.pio[0].machines[0];
  const write = machine.writeFIFO.bind(machine);
  let written = 0;
  machine.writeFIFO = (word) => {
    written = pico.cycle;
    write(word);
  };
  master.gapUs = 10;
  for (const motion of ["POS 77DEG", "VEL 12000RPM", "ACC 600RPM/S;VEL -3000RPM", "ACC 600RPM/S;MOVE 200REV,600RPM",
    'PROF "500RPM"', 'PROF "sine:90DEG,2S"', 'PROF "ramp:-3000RPM,1S,0.5S"']) {
    pico.order(`SHAF:${motion}`);
    let most = 0;
    for (let i = 0; i < 40; i++) {
      const frame = master.frame(i & 1);
      assert.ok(frame.good, motion);
      most = Math.max(most, written - frame.e1);
      pico.run(us(i * 37));
    }
    t.diagnostic(`${motion}: ${most} cycles, ${(most / HZ * 1e6).toFixed(1)} us`);
    assert.ok(most <= LATCH_CYCLES_MAX, `${motion}: ${most} cycles`);
  }
});

test("whole frames are right behind ones that were cut at any clock", () => {
  const { pico, master } = started();
  let seed = 1;
  const random = (n) => (seed = Math.imul(seed, 1103515245) + 12345 & 0x7fffffff) % n;
  master.gapUs = 0.6;
  pico.order("SHAF:VEL 1234RPM");
  for (const mhz of [1, 10]) {
    master.mhz = mhz;
    for (let i = 0; i < 200; i++) {
      if (i % 4 === 3) master.clock(1 + random(master.clocks), random(2));
      else assert.ok(master.frame(random(2)).good, `${mhz} MHz, frame ${i}`);
    }
  }
});

test("one clock is no frame and has no CDM", () => {
  const { master } = started();
  master.send(Array(10).fill(0));
  for (let i = 0; i < 5; i++) master.clock(1, 1); // they would begin a control frame
  master.send(Array(4).fill(0));
  assert.deepEqual(master.read(0x78, 2), [0x04, 0x00]);
});

test("registers are read and written over CDM, frames without a pause between them", () => {
  const { pico, flash, master } = started();
  pico.order("SHAF:POS 90DEG");
  for (const mhz of [1, 10]) {
    master.mhz = mhz;
    assert.deepEqual(master.read(0x78, 8), [0x04, 0x00, 0xcc, 0x15, 0x00, 0x00, 0x4b, 0x55]);
    assert.deepEqual(master.read(0x60, 1), [0x93]);
    assert.throws(() => master.write(0x78, [0]), /refused/);
    assert.deepEqual(master.read(0x78, 1), [0x04]);
  }
  const before = flash.operations.length;
  master.write(0x40, [7]); // bank 7, user data: busy
  master.write(0x00, [0x5a, 0xa5]);
  assert.ok(master.waited > 0, "the EEPROM works");
  assert.deepEqual(master.read(0x00, 3), [0x5a, 0xa5, 0xff]);
  pico.run(ms(20));
  assert.ok(flash.operations.length > before);
  const again = started({}, flash.kept());
  again.master.write(0x40, [7]);
  assert.deepEqual(again.master.read(0x00, 3), [0x5a, 0xa5, 0xff]);
});

test("the short timeout of 7Ch is in force at once", () => {
  const { master } = started();
  master.write(0x7c, [0x01]);
  master.timeoutUs = 1.3;
  master.gapUs = 20; // for the processor
  for (let i = 0; i < 20; i++) assert.ok(master.frame(i & 1).good, `frame ${i}`);
  assert.deepEqual(master.read(0x7c, 1), [0x01]);
});

test("steps and their direction turn the shaft", () => {
  const { pico, master } = started();
  const STEP = 14, DIRECTION = 15, COUNTS = 2 ** 21 / 3200;
  const step = (n, up, periodUs) => {
    pico.drive(pico.cycle, DIRECTION, up);
    for (let i = 0; i < n; i++) {
      const at = pico.cycle + us(1 + i * periodUs);
      pico.drive(at, STEP, true);
      pico.drive(at + us(periodUs / 2), STEP, false);
    }
    pico.run(us(n * periodUs) + ms(5));
  };
  for (const pin of [STEP, DIRECTION]) pico.chip.gpio[pin].setInputValue(false);
  const position = (steps) => assert.equal(master.frame().position, Math.floor(steps * COUNTS));
  step(800, true, 20); // a quarter, at 50 kHz
  position(800);
  step(900, false, 4); // and on below 0
  position(3200 * 4096 - 100);
  step(600, true, 20);
  position(500);
  pico.order("SHAF:POS 180DEG"); // and from there
  step(1, true, 100);
  position(1601);
});

test("A and B turn the shaft, each edge by a part of 4096", () => {
  const SELECT = 13, A = 14, B = 15, COUNTS = 2 ** 21 / 4096, TURN = [[0, 0], [1, 0], [1, 1], [0, 1]];
  for (const from of [0, 1, 2, 3]) {
    const { pico, master } = started({}, undefined, { [SELECT]: true, [A]: TURN[from][0] === 1, [B]: TURN[from][1] === 1 });
    let phase = from, edges = 0;
    const turn = (n, periodUs) => {
      const begin = pico.cycle + us(1);
      for (let i = 0; i < Math.abs(n); i++) {
        const before = TURN[phase & 3];
        phase += Math.sign(n);
        TURN[phase & 3].forEach((level, k) => {
          if (level !== before[k]) pico.drive(begin + Math.round(us(periodUs) * i), [A, B][k], level === 1);
        });
      }
      pico.run(us(Math.abs(n) * periodUs) + ms(5));
      edges += n;
      assert.equal(master.frame().position, ((Math.floor(edges * COUNTS) % 2 ** 33) + 2 ** 33) % 2 ** 33, `${n} edges, begun at ${from}`);
    };
    turn(1024, 2);
    turn(-1, 100);
    turn(-1500, 1); // and on below 0
    turn(3, 0.2);
    turn(2000, 0.5); // 2 million edges a second
    for (const n of [1, -1, 1, -1, -1, 1]) turn(n, 1); // to and fro at one edge
  }
});

test("frames are in time while the console works, and while flash is written and erased", (t) => {
  const { pico, flash, master } = started();
  master.write(0x40, [7]);
  let most = 0;
  for (let i = 0; i < 600; i++) {
    if (i % 4 === 0) pico.tell(["SHAF:VEL 60RPM", "STAT?", "SHAF:POS 90DEG", "WORL:TEMP 40DEGC", "FAUL:CAT?"][i / 4 % 5]);
    const frame = master.frame();
    assert.ok(frame.good, `frame ${i}`);
    most = Math.max(most, frame.delay);
    pico.run(us(i % 90));
  }
  for (let i = 0; flash.count("erase") < 8; i++) {
    assert.ok(i < 200, "a half is full some time");
    master.write(i % 64, [i & 255]); // throws when a frame is late
    pico.run(ms(20));
  }
  t.diagnostic(`the latest start bit ${most.toFixed(1)} us behind e1`);
  assert.ok(most < START_MAX_US);
});
