// SPDX-License-Identifier: MIT
// The rows of tests/conformance/hiperface.rows against the RS485 images, bit by bit: all but those that need hands in the
// EEPROM or look at voltages. How many these are is told; fewer than there were is a failure.
import assert from "node:assert/strict";
import { test } from "node:test";

import { HZ, ms, symbols } from "./pico.mjs";
import { Board, doRows, layoutOf, possible, rowsOf, some, span } from "./rows.mjs";
import { Master, xor } from "./rs485.mjs";

const LEAST = 238, EACH = 2; // of them one of so many in a check
const BAUDS = [600, 1200, 2400, 4800, 9600, 19200, 38400];
const LATE_MAX = ms(0.6); // a quarter of a bit at 600 Bd, and processing
const PATIENCE = ms(250);
const COUNTS = 65536; // 2048 periods of 32

// Of struct dg_hf_model: the name in a row, the member, and what a value is multiplied with.
const FIGURES = {
  memory: ["memory_blocks", 1], reaction_ms: ["reaction", 1e6], init_ms: ["init", 1e6],
  ...Object.fromEntries(["periods_per_turn", "steps_per_period", "turns", "type_code", "option_code", "temperature_channel",
    "led_channel", "vector_channel", "temperature_min_degc", "temperature_max_degc", "led_min_ma", "led_max_ma", "vector_min",
    "vector_max", "speed_max_rpm", "acceleration_max_krad_s2", "implemented_blocks"].map((name) => [name, [name, 1]])),
};
const LAYOUT = layoutOf("hiperface.h", "dg_hf_model", Object.values(FIGURES).map(([member]) => member));

const KNOWN = [new RegExp(`^given s36[78]4-rs485( (${Object.keys(FIGURES).join("|")})=-?\\d+| raw=\\w+| window)*$`),
  /^[<>]\+?( @\d+ms)?( ~\d+(ms|us|b)| [0-9A-F]{2}(!|x\d+)?)+$/, /^noise( ~\d+(ms|us|b)| [0-9A-F]{2}(!|x\d+)?)+$/,
  /^< none( \d+(ms|us|b))?$/, /^line [0-9A-F]{2}$/, /^angle -?\w+ counts$/, /^eeprom (silent|back)$/, /^uart \d+ [NEO] \d+$/];

// The power has to go within half a millisecond; the console takes one.
const TOO_FAST = "[L-3] A request whose reply has not started was not executed";

class Bench {
  constructor(board, figures) {
    this.board = board;
    this.pico = board.pico;
    this.master = board.master ??= new Master(board.pico);
    this.reaction = ms(figures.reaction_ms ?? 1);
    this.line(0xe4);
  }

  line(setting) {
    Object.assign(this.master, { baud: BAUDS[setting & 7], parity: "N.EO"[setting >> 4 & 3] });
    this.silence = setting & 0x40 ? 44 : 11;
  }

  /** @return when the last character ends */
  send(words, sum) {
    let bytes = [], damaged = [], all = 0, end = 0;
    const flush = () => {
      end = this.master.send(bytes, (bits, i) => damaged[i] ? bits.map((bit, k) => k === 9 ? bit ^ 1 : bit) : bits);
      bytes = [];
      damaged = [];
    };
    for (const word of words) {
      if (word[0] === "~") {
        flush();
        this.pico.run(span(word.slice(1), this.master.bit));
        continue;
      }
      const [, hex, spoiled, times] = /^(..)(!?)(?:x(\d+))?$/.exec(word), byte = Number.parseInt(hex, 16);
      for (let i = 0; i < Number(times ?? 1); i++) {
        bytes.push(byte);
        damaged.push(spoiled === "!");
        all ^= byte;
      }
    }
    if (sum) bytes.push(all);
    flush();
    return end;
  }

  request(words, sum) {
    this.from = this.master.tx.length; // noise behind it may be longer than its reply takes
    this.end = this.send(words, sum);
  }

  receive(words, sum) {
    const reaction = words[0][0] === "@" ? span(words.shift().slice(1)) : this.reaction;
    const wanted = words.flatMap((word) => {
      const [hex, times] = word.split("x");
      return Array(Number(times ?? 1)).fill(Number.parseInt(hex, 16));
    });
    const nominal = this.silence * this.master.bit + reaction;
    const reply = this.master.receive(Math.ceil(nominal) + PATIENCE, this.from);
    assert.ok(reply, "silence");
    assert.deepEqual(reply.bytes, sum ? [...wanted, xor(wanted)] : wanted);
    assert.ok(reply.good && reply.jitter < 0.02, "bits");
    this.from = this.master.tx.length;
    const late = reply.begin - this.end - nominal, stores = this.board.flash.until > this.end;
    assert.ok(late >= 0 && (stores || late < LATE_MAX), `${late / HZ * 1e6} us late`);
  }

  step(step) {
    const [what, ...words] = step.split(" "), { master, pico, board } = this;
    if (what === ">" || what === ">+") this.request(words, what === ">+");
    else if (what === "noise") this.send(words, false);
    else if (step.startsWith("< none")) {
      assert.equal(master.receive(words[1] ? span(words[1], master.bit) : ms(160), this.from), null);
    }
    else if (what === "<" || what === "<+") this.receive(words, what === "<+");
    else if (what === "line") this.line(Number.parseInt(words[0], 16));
    else if (what === "angle") board.position(words[0]);
    else if (what === "eeprom") board.step(`world eeprom_acknowledges=${words[0] === "back" ? 1 : 0}`);
    else if (what === "uart") this.uart(Number(words[0]), words[1]);
    else return board.step(step, master.bit);
    return true;
  }

  /** The setting of the port; its silence shows in the moments of replies. */
  uart(baud, parity) {
    const { chip } = this.pico, at = symbols(this.pico.image).uart;
    assert.deepEqual([chip.readUint32(at), String.fromCharCode(chip.readUint8(at + 4))], [baud, parity]);
  }
}

const boards = {};

function begin(step) {
  const [, model, ...words] = step.split(" ");
  const figures = Object.fromEntries(words.filter((word) => word.includes("=")).map((word) => word.split("=")));
  const { raw = 0, ...others } = figures, key = `${model} ${JSON.stringify(others)}`;
  const patches = Object.entries(others).map(([name, value]) => {
    const [member, factor] = FIGURES[name];
    return { ...LAYOUT[member], value: Number(value) * factor };
  });
  const counts = (others.periods_per_turn ?? 2048) * (others.steps_per_period ?? 32);
  boards[key] ??= new Board(`drehgeber-${model}`, model.replace("-", "_"), patches, counts);
  boards[key].deliver(words.includes("window"));
  const bench = new Bench(boards[key], others);
  if (Number(raw)) boards[key].position(raw);
  return bench;
}

test("rows of the conformance tests", (t) => {
  const rows = rowsOf("hiperface.rows"), ready = possible(rows, KNOWN).filter(({ name }) => name !== TOO_FAST);
  const tried = some(ready, EACH);
  doRows(tried, begin);
  t.diagnostic(`${tried.length} of ${ready.length} rows, of ${rows.length}`);
  assert.ok(ready.length >= LEAST);
});
