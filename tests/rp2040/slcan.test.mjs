// SPDX-License-Identifier: MIT
// The F3668 on a Raspberry Pi Pico behind SLCAN on UART1: what python-can's slcan would send, as text.
import assert from "node:assert/strict";
import { test } from "node:test";

import { Flash } from "./flash.mjs";
import { HZ, Pico, ms } from "./pico.mjs";

const IMAGE = "drehgeber-f3668-slcan";
const CHARACTER = 10 * HZ / 1e6; // at 1 MBd

class Adapter {
  constructor(kept) {
    this.pico = new Pico(IMAGE, { flash: kept });
    this.flash = new Flash(this.pico);
    this.said = "";
    this.answered = 0; // when the latest frame came that was no heartbeat
    this.pico.chip.uart[1].onByte = (byte) => {
      this.said += String.fromCharCode(byte);
      if (/t[^7][^\r]*\r$/.test(this.said)) this.answered = this.pico.cycle;
    };
    this.pico.ask("*IDN?");
  }

  /** @return what comes back within `within`, by lines; what was sent ends at this.sent */
  say(line, within = ms(5)) {
    let at = this.pico.cycle;
    for (const character of `${line}\r`) {
      at += CHARACTER;
      this.pico.at(Math.round(at), () => this.pico.chip.uart[1].feedByte(character.charCodeAt(0)));
    }
    this.said = "";
    this.sent = at;
    this.pico.run(Math.ceil(at) - this.pico.cycle + within);
    return this.said.split("\r").slice(0, -1);
  }

  open() {
    assert.deepEqual(this.say("S5"), [""]); // 250 kbit/s
    assert.deepEqual(this.say("O"), [""]);
  }

  /** SDO; node 63, as delivered */
  sdo(hex, within) {
    const lines = this.say(`t63F8${hex}`, within);
    const answers = lines.filter((answer) => answer.startsWith("t5BF8"));
    assert.equal(answers.length, 1, `no answer: ${lines}`);
    return answers[0].slice(5);
  }
}

test("the channel, a position by SDO, NMT, PDO and SYNC", (t) => {
  const adapter = new Adapter();
  adapter.pico.order("SHAF:POS 90DEG");
  adapter.pico.run(ms(300)); // which is a speed for some time
  adapter.open();
  assert.equal(adapter.sdo("4004600000000000"), "4304600000400000"); // 6004h: 4000h of 65536
  t.diagnostic(`6004h: answered ${((adapter.answered - adapter.sent) / HZ * 1e6).toFixed(0)} us behind the request`);
  assert.equal(adapter.sdo("4000100000000000"), "4300100096010200"); // 1000h
  const [taken, ...pdos] = adapter.say("t0002013F");
  assert.equal(taken, "z");
  assert.deepEqual(pdos.slice(0, 2), ["t1BF400400000", "t3BF20000"]); // position, speed
  assert.match(pdos[2], /^t4BF600400000[0-9A-F]{4}$/); // position and its CRC
  assert.deepEqual(adapter.say("t0800"), ["z", "t2BF400400000"]);
  t.diagnostic(`SYNC: answered ${((adapter.answered - adapter.sent) / HZ * 1e6).toFixed(0)} us behind it`);
  assert.deepEqual(adapter.pico.complaints, []);
});

test("a channel at another bit rate hears nothing", () => {
  const adapter = new Adapter();
  adapter.say("S6"); // 500 kbit/s
  adapter.say("O");
  assert.deepEqual(adapter.say("t63F84004600000000000"), ["z"]);
  adapter.say("C");
  adapter.open();
  adapter.sdo("4004600000000000");
});

test("heartbeats go on, and what is saved is there after a reset", (t) => {
  const adapter = new Adapter();
  adapter.open();
  assert.equal(adapter.sdo("2B17100064000000"), "6017100000000000"); // 1017h: 100 ms
  assert.equal(adapter.sdo("2310100173617665", ms(300)).slice(0, 8), "60101001"); // save
  t.diagnostic(`1010h "save": answered ${((adapter.answered - adapter.sent) / HZ * 1e3).toFixed(1)} ms behind the request`);
  adapter.said = "";
  adapter.pico.run(ms(1050));
  assert.equal(adapter.said.match(/t73F17F\r/g).length, 10);
  const again = new Adapter(adapter.flash.kept());
  again.open();
  assert.equal(again.sdo("4017100000000000").slice(0, 12), "4B1710006400");
});
