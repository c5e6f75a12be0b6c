// SPDX-License-Identifier: MIT
// The rows of tests/conformance/canopen.rows against the images with an MCP2515, whose model has the bus. Left out are rows
// with moments to the nanosecond, with errors or other data rates of the bus, hands in the EEPROM, and the EDS file.
import assert from "node:assert/strict";
import { test } from "node:test";

import { Mcp2515 } from "./mcp2515.mjs";
import { ms } from "./pico.mjs";
import { Board, doRows, possible, rowsOf, some, span } from "./rows.mjs";

const LEAST = 155, EACH = 2; // of them one of so many in a check
const SOON = ms(6); // some frames of 250 kbit/s, one behind the other
const ANSWER = ms(150); // of an SDO that stores

const HEX = "[0-9A-F]{2}", KNOWN = [/^given f36[56]8( boot)?$/, new RegExp(`^>!? [0-9A-F]+( ${HEX})*$`), /^rtr [0-9A-F]+( \d)?$/,
  new RegExp(`^< [0-9A-F]+( ${HEX})*$`), /^< none( \d+(ms|us))?$/, /^skip \d+$/, /^node [0-9A-F]+$/, /^turn -?\w+$/,
  /^(read|write) [0-9A-F]{4}:[0-9A-F]+(( [0-9A-F]{2})+| abort [0-9A-F]{8}|( [0-9A-F]{2})+ abort [0-9A-F]{8})$/, /^eeprom (silent|back)$/];

const bytesOf = (words) => words.map((hex) => Number.parseInt(hex, 16));
const text = ({ id, data }) => `${id.toString(16)}#${Buffer.from(data).toString("hex")}`.toUpperCase();

// They know the clock of 1013h to the microsecond, a serial number that is not the image's, or a shaft that is elsewhere
// without having been fast.
const OTHERWISE = /1013|D2 02 96 49|CIA-8-9\] LSS|fastscan with the known identity|Position and speed in TPDO1|Eight bytes are full/;

class Bench {
  constructor(board) {
    Object.assign(this, { board, pico: board.pico, can: board.can, node: 0x3f });
  }

  get sent() {
    return this.can.sent;
  }

  say(id, data, rtr = false) {
    this.can.receive({ id, data, rtr });
    this.pico.run(SOON);
  }

  next() {
    const end = this.pico.cycle + ANSWER;
    while (!this.sent.length && this.pico.cycle < end) this.pico.run(ms(1));
    assert.ok(this.sent.length, "no frame");
    return this.sent.shift();
  }

  /** An expedited SDO, and the answer that belongs to it. */
  sdo(write, [object, ...words]) {
    const [index, sub] = object.split(":").map((hex) => Number.parseInt(hex, 16)), at = words.indexOf("abort");
    const data = bytesOf(at < 0 ? words : words.slice(0, at)), head = [index & 255, index >> 8, sub];
    const size = 4 - data.length << 2 | 3;
    this.say(0x600 + this.node, write ? [0x20 | size, ...head, ...data, ...Array(4 - data.length).fill(0)] : [0x40, ...head, 0, 0, 0, 0]);
    let wanted = write ? [0x60, ...head] : [0x40 | size, ...head, ...data];
    if (at >= 0) wanted = [0x80, ...head, ...bytesOf(words[at + 1].match(/../g)).reverse()];
    const answer = text(this.next());
    assert.equal(answer, text({ id: 0x580 + this.node, data: [...wanted, ...Array(8 - wanted.length).fill(0)] }));
  }

  step(step) {
    const [what, ...words] = step.split(" "), { board, pico } = this;
    if (what === ">" || what === ">!") {
      const [id, ...data] = bytesOf(words), filled = what === ">" && (id >= 0x600 && id <= 0x67f || id === 0x7e5);
      this.say(id, [...data, ...Array(filled ? 8 - data.length : 0).fill(0)]);
    } else if (what === "rtr") {
      const id = Number.parseInt(words[0], 16), length = words.length > 1 ? Number(words[1]) : (id & 0x780) === 0x700 ? 1 : 0;
      this.say(id, Array(length).fill(0), true);
    } else if (step.startsWith("< none")) {
      pico.run(words[1] ? span(words[1]) : SOON);
      assert.deepEqual(this.sent.map(text), []);
    } else if (what === "<") {
      const [id, ...data] = bytesOf(words);
      assert.equal(text(this.next()), text({ id, data }));
    } else if (what === "skip") {
      pico.run(SOON);
      assert.equal(this.sent.length, Number(words[0]), this.sent.map(text).join(" "));
      this.sent.length = 0;
    } else if (what === "read" || what === "write") this.sdo(what === "write", words);
    else if (what === "node") this.node = Number.parseInt(words[0], 16);
    else if (what === "turn") {
      if (words[0].endsWith("DEG")) pico.order(`SHAF:POS ${words[0]}`);
      else board.position(words[0]);
    } else if (what === "eeprom") board.step(`world eeprom_acknowledges=${words[0] === "back" ? 1 : 0}`);
    else return board.step(step);
    return true;
  }

  finish() {
    this.pico.run(SOON);
    assert.deepEqual(this.sent.map(text), [], "left over");
  }
}

const boards = {};

function begin(step) {
  const [, model, boot] = step.split(" ");
  boards[model] ??= new Board(`drehgeber-${model}-mcp2515`, model, [], 65536, (pico) => new Mcp2515(pico));
  const bench = new Bench(boards[model]);
  boards[model].power(false);
  bench.sent.length = 0; // of the row before
  boards[model].deliver();
  if (!boot) bench.sent.length = 0;
  return bench;
}

test("rows of the conformance tests", (t) => {
  const rows = rowsOf("canopen.rows");
  const ready = possible(rows, KNOWN).filter(({ name, steps }) => ![name, ...steps].some((line) => OTHERWISE.test(line)));
  const tried = some(ready, EACH);
  doRows(tried, begin);
  t.diagnostic(`${tried.length} of ${ready.length} rows, of ${rows.length}`);
  assert.ok(ready.length >= LEAST);
});
