// SPDX-License-Identifier: MIT
// The rows of tests/conformance/hiperface.rows against the images, over the wire: those that need nothing but a wire,
// power and time. How many these are is told; fewer than there were is a failure.
import assert from "node:assert/strict";
import fs from "node:fs";
import { test } from "node:test";

import { Flash } from "./flash.mjs";
import { HZ, Pico, ms } from "./pico.mjs";
import { Master, xor } from "./rs485.mjs";

const ROWS = new URL("../conformance/hiperface.rows", import.meta.url);
const LEAST = 85;
const BAUDS = [600, 1200, 2400, 4800, 9600, 19200, 38400];
const LATE_MAX = ms(0.6); // a quarter of a bit at 600 Bd, and processing

function rowsOf(text) {
  const rows = [];
  for (const line of text.split("\n")) {
    const step = line.replace(/#.*/, "").trim();
    if (line.startsWith("[")) rows.push({ name: line, steps: [] });
    else if (step && rows.length) rows.at(-1).steps.push(step);
  }
  return rows;
}

const KNOWN = [/^given s36[78]4-rs485$/, /^[<>]\+?( [0-9A-F]{2}(!|x\d+)?)+$/, /^< none( \d+ms)?$/, /^wait \d+ms$/, /^line [0-9A-F]{2}$/,
  /^power o(n|ff)$/];
const possible = ({ steps }) => steps.length > 1 && steps.every((step) => KNOWN.some((known) => known.test(step)));

const bytesOf = (words) => words.flatMap((word) => {
  const [, hex, times] = /^(..)(?:x(\d+))?!?$/.exec(word);
  return Array(Number(times ?? 1)).fill(Number.parseInt(hex, 16));
});

class Device {
  constructor(model) {
    this.pico = new Pico(`drehgeber-${model}`, { flash: Device.delivered[model] });
    this.flash = new Flash(this.pico);
    this.master = new Master(this.pico);
    this.pico.ask("*IDN?");
    Device.delivered[model] ??= this.flash.kept();
    this.pico.run(ms(120));
  }

  frame(words, sum) {
    const bytes = bytesOf(words);
    return sum ? [...bytes, xor(bytes)] : bytes;
  }

  step(step) {
    const [what, ...words] = step.split(" "), { master, pico } = this;
    if (what === ">" || what === ">+") {
      const damaged = words.map((word) => word.endsWith("!"));
      this.end = master.send(this.frame(words, what === ">+"), (bits, i) => damaged[i] ? bits.map((bit, k) => k === 9 ? bit ^ 1 : bit) : bits);
    } else if (step.startsWith("< none")) {
      assert.equal(master.receive(ms(words[1] ? Number.parseInt(words[1]) : 160)), null);
    } else if (what === "<" || what === "<+") {
      const reply = master.receive(ms(200));
      assert.ok(reply, "silence");
      assert.deepEqual(reply.bytes, this.frame(words, what === "<+"));
      assert.ok(reply.good && reply.jitter < 0.02);
      const late = reply.begin - this.end - this.silence * master.bit - ms(1);
      const stores = this.flash.until > this.end;
      assert.ok(late >= 0 && (stores || late < LATE_MAX), `${late / HZ * 1e6} us late`);
    } else if (what === "wait") {
      pico.run(ms(Number.parseInt(words[0])));
    } else if (what === "line") {
      const setting = Number.parseInt(words[0], 16);
      Object.assign(master, { baud: BAUDS[setting & 7], parity: "N.EO"[setting >> 4 & 3] });
      this.silence = setting & 0x40 ? 44 : 11;
    } else if (what === "power") {
      pico.order(`POW ${words[0] === "on" ? 1 : 0}`);
      if (words[0] === "on") pico.run(ms(120));
    }
  }
}
Device.delivered = {};
Device.prototype.silence = 44;

test("rows of the conformance tests", (t) => {
  const rows = rowsOf(fs.readFileSync(ROWS, "utf8"));
  const tried = rows.filter(possible);
  for (const { name, steps } of tried) {
    let device;
    for (const step of steps) {
      try {
        if (step.startsWith("given")) device = new Device(step.split(" ")[1]);
        else device.step(step);
      } catch (error) {
        throw new Error(`${name}\n  ${step}\n${error.message}`);
      }
    }
  }
  t.diagnostic(`${tried.length} of ${rows.length} rows`);
  assert.ok(tried.length >= LEAST);
});
