// SPDX-License-Identifier: MIT
// The S36 with RS485 on a Raspberry Pi Pico, asked bit by bit. Frames are those of the manual, 5.1.4.
import assert from "node:assert/strict";
import { test } from "node:test";

import { Flash } from "./flash.mjs";
import { HZ, Pico, ms } from "./pico.mjs";
import { Master } from "./rs485.mjs";

const IMAGE = "drehgeber-s3684-rs485";
const BAUDS = [600, 1200, 2400, 4800, 9600, 19200, 38400];
const PARITIES = { N: 0, E: 2, O: 3 }; // 57h, bits 5 and 4
const CODE = 0x55;
const LATE_MAX = ms(0.15);

function started(kept) {
  const pico = new Pico(IMAGE, { flash: kept });
  const flash = new Flash(pico);
  const master = new Master(pico);
  pico.ask("*IDN?");
  return { pico, flash, master };
}

/** When a reply is due: 44 bits of silence, and 1 ms. */
const nominal = (master) => 44 * master.bit + ms(1);

function assertReply(reply, bytes, master) {
  assert.ok(reply, "silence");
  assert.deepEqual(reply.bytes.slice(0, -1), bytes);
  assert.ok(reply.good, "start, parity and stop bits");
  assert.ok(reply.jitter < 0.02, `edges are off by ${reply.jitter} bits`);
  assert.ok(reply.lead > 0 && reply.lead < 1, `DE rises ${reply.lead} bits before the start bit`);
  assert.ok(reply.tail > 0 && reply.tail < 1, `DE falls ${reply.tail} bits behind the stop bit`);
  assert.ok(reply.after >= nominal(master), "a reply is not early");
}

test("position at the usual moment", (t) => {
  const { pico, master } = started();
  pico.order("SHAF:POS 90DEG");
  const reply = master.ask([0x40, 0x42]);
  assertReply(reply, [0x40, 0x42, 0, 0, 0x40, 0], master);
  const late = reply.after - nominal(master);
  t.diagnostic(`start bit ${(late / HZ * 1e6).toFixed(1)} us behind the nominal moment, DE leads by ` +
    `${reply.lead.toFixed(2)} bits and trails by ${reply.tail.toFixed(2)}`);
  assert.ok(late < LATE_MAX);
  assert.deepEqual(pico.complaints, []);
});

test("every data rate and parity of 57h", (t) => {
  const { pico, master } = started();
  BAUDS.forEach((baud, rate) => {
    for (const parity of baud === 9600 ? "NEO" : "EON"[rate % 3]) {
      const setting = 0xc4 & ~7 | PARITIES[parity] << 4 | rate;
      assertReply(master.ask([0x40, 0x57, setting, CODE], { within: ms(200) }), [0x40, 0x57, setting], master);
      assert.equal(master.ask([0x40, 0x53], { within: ms(105) + 44 * master.bit / 1 }), null); // in force behind it
      Object.assign(master, { baud, parity });
      const reply = master.ask([0x40, 0x42], { within: ms(200) });
      assertReply(reply, [0x40, 0x42, 0, 0, 0, 0], master);
      t.diagnostic(`${baud} 8${parity}1: DE leads by ${(reply.lead * 1e6 / baud).toFixed(0)} us, trails by ` +
        `${(reply.tail * 1e6 / baud).toFixed(0)} us, late ${((reply.after - nominal(master)) / HZ * 1e6).toFixed(0)} us`);
    }
  });
  assert.deepEqual(pico.complaints, []);
});

test("a parity or framing error is answered with 0Ah, one in the address with silence", () => {
  const { master } = started();
  const flip = (at, which) => (bits, i) => bits.map((bit, k) => i === at && k === which ? bit ^ 1 : bit);
  assertReply(master.ask([0x40, 0x42], { spoil: flip(1, 9) }), [0x40, 0x50, 0x0a], master); // parity
  assertReply(master.ask([0x40, 0x42], { spoil: flip(1, 10) }), [0x40, 0x50, 0x0a], master); // stop bit
  assert.equal(master.ask([0x40, 0x42], { spoil: flip(0, 9) }), null);
  assertReply(master.ask([0x40, 0x42]), [0x40, 0x42, 0, 0, 0, 0], master);
});

test("a long reply has no pauses, also while the console talks", () => {
  const { pico, master } = started();
  master.ask([0x40, 0x4d, 0x00, 0xcf, CODE]); // a data field of 128 bytes
  pico.tell("SYST:HELP?"); // some kilobytes
  const reply = master.ask([0x40, 0x4a, 0x00, 0x00, 0x80, CODE], { within: ms(60) });
  assert.equal(reply.bytes.length, 134);
  assert.ok(reply.good && reply.jitter < 0.02);
});

test("what is acknowledged is in flash, within the manual's time", (t) => {
  const { pico, flash, master } = started();
  let most = 0;
  const before = flash.count("program");
  for (let i = 1; i <= 20; i++) {
    const reply = master.ask([0x40, 0x47]); // the counter goes up
    assertReply(reply, [0x40, 0x47], master);
    most = Math.max(most, reply.after);
  }
  const pages = (flash.count("program") - before) / 20;
  t.diagnostic(`47h: reply ${(most / HZ * 1e3).toFixed(1)} ms behind the request, ${pages} pages each`);
  assert.ok(most < ms(30), "5.1.2.5 allows 30 ms");
  assertReply(started(flash.kept()).master.ask([0x40, 0x46]), [0x40, 0x46, 0, 0, 20], master);
});

test("sine and cosine follow the shaft", (t) => {
  const { pico } = started();
  const channel = pico.chip.pwm.channels[5], STEPS = 1024;
  for (const rpm of [0.6, 6, 60, 120]) {
    pico.order(`SHAF:POS 0DEG;VEL ${rpm}RPM`);
    const writes = []; // [cycle, phase in periods, amplitude]
    const write = channel.writeRegister.bind(channel);
    channel.writeRegister = (offset, value) => {
      write(offset, value);
      const [sin, cos] = [value & 0xffff, value >>> 16].map((level) => level / STEPS - 0.5);
      if (offset === 0x0c) writes.push([pico.cycle, Math.atan2(sin, cos) / 2 / Math.PI, Math.hypot(sin, cos)]);
    };
    pico.run(ms(rpm < 1 ? 200 : 20));
    channel.writeRegister = write;
    const perCycle = rpm / 60 * 2048 / HZ; // periods
    const starts = writes.map(([at, phase]) => ((phase - at * perCycle) % 1 + 1) % 1);
    const spread = Math.max(...starts.map((start) => Math.abs(((start - starts[0] + 1.5) % 1) - 0.5)));
    assert.ok(writes.every(([, , amplitude]) => Math.abs(amplitude - 0.4) < 0.003), `${rpm} rpm: the amplitude`);
    assert.ok(spread < 0.01 + perCycle * ms(0.01), `${rpm} rpm: the phase is off by ${spread} periods`);
    const each = (writes.at(-1)[0] - writes[0][0]) / (writes.length - 1);
    t.diagnostic(`${rpm} rpm: renewed every ${(each / HZ * 1e6).toFixed(0)} us, ${(1 / perCycle / each).toFixed(1)} times a period`);
  }
  pico.order("SHAF:POS 0DEG", "WORL:AMPL:COS 500");
  pico.run(ms(5));
  assert.equal(channel.cc, STEPS / 2 + 409 / 2 >>> 0 << 16 | STEPS / 2);
});
