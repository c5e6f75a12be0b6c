// SPDX-License-Identifier: MIT
// The F3668 on a Raspberry Pi Pico with an MCP2515, on a bus.
import assert from "node:assert/strict";
import { test } from "node:test";

import { Flash } from "./flash.mjs";
import { Mcp2515 } from "./mcp2515.mjs";
import { HZ, Pico, ms, us } from "./pico.mjs";

const IMAGE = "drehgeber-f3668-mcp2515";
const NODE = 63; // as delivered, with 250 kbit/s

class Bus {
  constructor(alone = false) {
    this.pico = new Pico(IMAGE);
    this.flash = new Flash(this.pico);
    this.can = new Mcp2515(this.pico);
    this.can.alone = alone;
    this.pico.ask("*IDN?");
    this.pico.run(ms(20));
  }

  /** @return frames of the encoder within `within`, as text */
  say(id, hex, within = ms(5), extra = {}) {
    this.can.sent.length = 0;
    this.sent = this.pico.cycle;
    this.can.receive({ id, data: [...Buffer.from(hex, "hex")], ...extra });
    this.pico.run(within);
    return this.frames();
  }

  frames() {
    return this.can.sent.map(({ id, data }) => `${id.toString(16).toUpperCase()}#${Buffer.from(data).toString("hex").toUpperCase()}`);
  }
}

test("boot-up, SDO, NMT, PDO and SYNC", (t) => {
  const bus = new Bus();
  assert.equal(bus.can.kbaud, 250);
  assert.equal(bus.can.samplePoint, 0.875);
  assert.deepEqual(bus.frames(), ["73F#00"]);
  bus.pico.order("SHAF:POS 90DEG");
  bus.pico.run(ms(300));
  assert.deepEqual(bus.say(0x600 + NODE, "4004600000000000"), ["5BF#4304600000400000"]);
  const [answer] = bus.can.sent;
  const own = (answer.at - bus.sent) / HZ * 1e6 - bus.can.bits(answer) / 0.25;
  t.diagnostic(`6004h: the answer begins ${own.toFixed(0)} us behind the request`);
  assert.deepEqual(bus.say(0, "013F").slice(0, 2), ["1BF#00400000", "3BF#0000"]);
  assert.deepEqual(bus.say(0x80, ""), ["2BF#00400000"]);
  assert.deepEqual(bus.say(0x1bf, "", ms(5), { rtr: true }), ["1BF#00400000"]);
  assert.deepEqual(bus.say(0x600 + NODE, "4004600000000000", ms(5), { extended: true }), []);
  assert.deepEqual(bus.pico.complaints, []);
});

test("frames one behind the other are all heard, a lost one is told", () => {
  const bus = new Bus();
  bus.say(0, "013F");
  const frame = { id: 0x80, data: [] };
  const next = us(47 / 0.25); // without a bit between them
  for (const i of [1, 2, 3]) bus.pico.at(bus.pico.cycle + i * next, () => bus.can.receive(frame));
  assert.deepEqual(bus.say(0x80, ""), Array(4).fill("2BF#00000000"));
  for (let i = 0; i < 3; i++) bus.can.receive(frame); // more than it has buffers
  bus.can.sent.length = 0;
  bus.pico.run(ms(20));
  assert.ok(bus.frames().some((text) => text.startsWith("BF#1081")), `8110h: ${bus.frames()}`);
});

test("filters keep what is not for the node from the processor", (t) => {
  const bus = new Bus();
  const through = [];
  for (let id = 0; id < 0x800; id++) {
    const before = bus.can.filtered;
    bus.can.receive({ id, data: [] });
    bus.pico.run(us(300));
    if (bus.can.filtered === before) through.push(id);
  }
  const own = [0, 0x80, ...[0x180, 0x280, 0x380, 0x480, 0x600, 0x700].map((id) => id + NODE), 0x7e5];
  assert.deepEqual(own.filter((id) => !through.includes(id)), []);
  assert.ok(through.every((id) => id === 0x7e5 || [0, NODE].includes(id & 0x7f)), `${through}`);
  t.diagnostic(`as delivered ${through.length} of 2048 identifiers come through`);
  assert.equal(bus.can.away, 0);
});

test("filters are open before the answer", (t) => {
  const bus = new Bus();
  const heartbeat = (state) => bus.can.receive({ id: 0x705, data: [state] });
  const sdo = (hex) => assert.match(bus.say(0x600 + NODE, hex)[0], /^5BF#60/);
  heartbeat(5);
  assert.equal(bus.can.filtered, 1);
  let answer;
  bus.can.sent.push = (frame) => {
    answer = frame;
    heartbeat(5); // at once
  };
  bus.can.receive({ id: 0x600 + NODE, data: [0x23, 0x16, 0x10, 1, 50, 0, 5, 0] }); // 1016h: node 5 within 50 ms
  const asked = bus.pico.cycle;
  bus.pico.run(ms(5));
  delete bus.can.sent.push;
  assert.equal(answer.data[0], 0x60);
  const own = (answer.at - asked) / HZ * 1e6 - bus.can.bits(answer) / 0.25;
  t.diagnostic(`1016h, with a change of filters: the answer begins ${own.toFixed(0)} us behind the request`);
  assert.equal(bus.can.away, 1);
  bus.pico.run(ms(100)); // the one heartbeat was heard: it is missed from now on
  assert.ok(bus.frames().some((text) => text.startsWith("BF#3081")), `8130h: ${bus.frames()}`);
  assert.match(bus.say(0x600 + NODE, "2316100100000000")[0], /^5BF#60/); // none any more, which costs nothing
  assert.equal(bus.can.away, 1);
});

test("error passive and bus-off are told when they are over", () => {
  const bus = new Bus(true);
  bus.pico.run(ms(50));
  assert.deepEqual(bus.frames(), []); // nobody acknowledges
  assert.match(bus.pico.ask("STAT?"), /mode=pre/);
  bus.can.alone = false;
  bus.pico.run(ms(50));
  assert.equal(bus.frames()[0], "73F#00");
  bus.can.sent.length = 0;
  bus.can.disturb();
  bus.pico.run(ms(200));
  assert.ok(bus.frames().some((text) => text.startsWith("BF#4081")), `8140h: ${bus.frames()}`);
});

test("every data rate of 2100h", () => {
  const bus = new Bus();
  const sdo = (hex) => assert.match(bus.say(0x600 + NODE, hex, ms(60))[0], /^5BF#60/);
  [10, 20, 50, 100, 125, 250, 500, null, 1000].forEach((kbaud, code) => {
    if (!kbaud) return;
    sdo(`2F002100${code.toString(16).padStart(2, "0")}000000`);
    sdo("2305210073617665"); // save
    bus.can.sent.length = 0;
    bus.pico.order("POW 0", "POW 1");
    bus.pico.run(ms(30));
    assert.equal(bus.can.kbaud, kbaud);
    assert.deepEqual(bus.frames(), ["73F#00"]);
    assert.equal(bus.can.samplePoint, kbaud === 1000 ? 0.75 : 0.875);
  });
});
