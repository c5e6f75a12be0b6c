// SPDX-License-Identifier: MIT
// The rows of tests/conformance/biss.rows against the BiSS images, bit by bit: frames, positions, flags, control frames and
// registers. Left out are rows that look at single edges or moments, which a processor's are not the model's (ma, sl, timeout,
// busy, a given edge), that change what the master does, chains, and hands in the EEPROM.
import assert from "node:assert/strict";
import { test } from "node:test";

import { Master, bitsOf, crc4, number } from "./biss.mjs";
import { HZ, us } from "./pico.mjs";
import { Board, doRows, layoutOf, possible, rowsOf, some } from "./rows.mjs";

const LEAST = 223, EACH = 4; // of them one of so many in a check
const BUSY_REGISTER = HZ * 0.02;

// Of struct dg_biss_model: the name in a row, the member, and what a value is multiplied with.
const FIGURES = {
  mt: ["multiturn_bits", 1], st: ["singleturn_bits", 1], lc: ["life_counter", 1], early: ["stop_bit_early", 1], busy_us: ["busy", 1000],
  jitter_us: ["busy_jitter", 1000], read_us: ["eeprom_read", 1000], write_us: ["eeprom_write", 1000], init_us: ["init", 1000],
  series: ["device_id[0]", 1], revision: ["device_id[5]", 1], autostore: ["autostore", 1], sl_low_at_start: ["sl_low_at_start", 1],
  serial: ["serial", 1],
};
const LAYOUT = layoutOf("biss.h", "dg_biss_model", Object.values(FIGURES).map(([member]) => member));

const ACCESS = /^(read|write)( (id|flip|dflip|more)=\w+)* [0-9A-F]{2}( ([0-9A-F]{2}(\.\.[0-9A-F]{2})?|\*)(x\d+)?| P| refused| silent)*$/;
const KNOWN = [new RegExp(`^given s36[78]4-biss( (${Object.keys(FIGURES).join("|")})=\\w+| window)*$`), /^pos \w+$/,
  /^scd [0-9A-F*][0-9A-F:*]*$/, /^frame [01] = [01x ]+$/, /^zeros \d+$/, /^control [01 ]+ = [01x ]+$/, /^word [0-9A-F]+ = [01x ]+$/,
  ACCESS, /^idl [0-9A-F]+$/, /^command( reduced)? ids=\w+ code=\w+( ex=0| flip=\w+)* = \w+ \w+$/];

// What the board does otherwise, see platform/rp2040/README.md; or needs the power at a moment that the console cannot keep.
const OTHERWISE = ["[X-10 5.2.2.3-6] a sequence cannot run from the window into 40h",
  "[X-4 5.2.2.3-6 5.2.2.4-4 5.2.2.4-5 B1-4 B1-5 B1-6] behind 3Fh, bit for bit: the refused byte comes back, and 40h stays",
  "[M-9] initialised after 100 ms, not after 99 or 101, as delivered"];

const bitsIn = (words) => words.join("");
const matches = (want, got) => want.length === got.length && [...want].every((bit, i) => bit === "x" || bit === got[i]);

class Bench {
  constructor(board, model, figures) {
    this.board = board;
    this.master = board.master ??= new Master(board.pico, { mhz: 5 });
    Object.assign(this.master, {
      multiturn: Number(figures.mt ?? (model === "s3684-biss" ? 12 : 0)), singleturn: Number(figures.st ?? 21),
      lifeBits: Number(figures.lc ?? 1) * 6, fresh: true, timeoutUs: 13, gapUs: 20,
    });
    this.bad = 0;
  }

  frame(cdm) {
    const frame = this.master.frame(cdm);
    if (!frame.good) this.bad++;
    return frame;
  }

  /** Frames for bits of CDM. @return those of CDS */
  exchange(cdm) {
    return [...cdm].map((bit) => this.frame(Number(bit)).cds).join("");
  }

  spell(value, n) {
    return bitsOf(value, n).join("");
  }

  /** IDL0 comes first, in frame 1. */
  locks(cds) {
    return [...cds.slice(1, 10)].reduce((locks, bit, i) => locks | Number(bit) << i, 0);
  }

  address({ id, address, flip }) {
    const head = `1${this.spell(id, 3)}${this.spell(address, 7)}`;
    this.exchange("0".repeat(14));
    this.cds = this.exchange(`1${head}${this.spell(crc4([...head].map(Number)) ^ flip, 4)}`);
    this.idl = this.locks(this.cds);
  }

  /** S until it comes back; the frame it comes back in has the first bit. */
  start(first) {
    const until = this.board.pico.cycle + BUSY_REGISTER;
    for (;;) {
      let back = 0;
      this.frame((cds) => {
        back = cds;
        return cds ? first : Number(this.board.pico.cycle < until);
      });
      if (back) return;
      assert.ok(this.board.pico.cycle < until, "the register is busy for ever");
    }
  }

  /** @return {byte, stop, good} */
  byte(value, access, more) {
    const data = this.spell(value, 8), sum = this.spell(crc4([...data].map(Number)) ^ access.dflip, 4);
    const word = access.write ? data + sum : "0".repeat(12);
    this.start(Number(word[0]));
    const back = this.exchange(`${word.slice(1)}0`);
    let stop = 0;
    this.frame((cds) => {
      stop = cds;
      return more && !cds ? 1 : 0;
    });
    const got = [...back].map(Number), echo = access.write ? back === word : number(got.slice(8)) === crc4(got.slice(0, 8));
    return { byte: number(got.slice(0, 8)), stop, good: echo };
  }

  access(step) {
    const [what, ...words] = step.split(" ");
    const access = { write: what === "write", id: 0, flip: 0, dflip: 0, more: 0, address: null }, wanted = [];
    const keywords = { P: false, refused: false, silent: false };
    for (const word of words) {
      const [name, value] = word.split("=");
      if (value !== undefined) access[name] = Number.parseInt(value, 16);
      else if (word in keywords) keywords[word] = true;
      else if (access.address === null) access.address = Number.parseInt(word, 16);
      else {
        const [range, times] = word.split("x"), [low, high] = range === "*" ? [0, 255] : range.split("..").map((hex) => Number.parseInt(hex, 16));
        for (let i = 0; i < Number(times ?? 1); i++) wanted.push([low, high ?? low]);
      }
    }
    const n = (wanted.length || 1) + access.more, done = [];
    this.address(access);
    this.cds += this.exchange(access.write ? "0" : "1");
    const r = this.exchange(access.write ? "1" : "0");
    let granted = false, w = 0;
    this.frame((cds) => {
      w = String(cds);
      granted = r !== w && Number(w) === Number(access.write);
      return Number(granted);
    });
    let go = granted, stop = 0;
    while (go && done.length < n) {
      const got = this.byte(wanted[done.length]?.[0] ?? 0, access, done.length + 1 < n);
      assert.ok(got.good, "CRC4 or echo of a register");
      done.push(got.byte);
      stop = got.stop;
      go = !stop;
    }
    if (keywords.silent) {
      assert.ok(!`${this.cds.slice(10)}${r}${w}`.includes("1"), "not silent");
      return;
    }
    assert.equal(r === w, keywords.refused, `RW comes back as ${r}${w}`);
    if (keywords.refused) return;
    assert.equal(Boolean(stop), keywords.P, "P");
    assert.equal(done.length, wanted.length, `${done.length} bytes`);
    done.forEach((byte, i) => assert.ok(byte >= wanted[i][0] && byte <= wanted[i][1], `byte ${i}: ${byte.toString(16)}`));
  }

  command(words) {
    const equals = words.indexOf("="), option = (name) => Number.parseInt(words.find((word) => word.startsWith(name))?.slice(name.length) ?? "0", 16);
    const reduced = words.includes("reduced"), execute = words.includes("ex=0") ? 0 : 1, ids = option("ids=");
    const head = `0${this.spell(ids, 8).split("").reverse().join("")}${this.spell(option("code="), 2)}`;
    const bit = (cdm) => {
      if (!reduced) return this.frame(cdm).cds;
      this.master.clock(2, cdm);
      return 0;
    };
    for (let i = 0; i < 14; i++) bit(0);
    const cds = [...`1${head}${this.spell(crc4([...head].map(Number)) ^ option("flip="), 4)}`].map((cdm) => bit(Number(cdm))).join("");
    let acknowledged = 0;
    bit(1);
    if (ids === 0) bit(execute);
    else for (let id = 0; id < 8; id++) acknowledged |= this.frame(id === 7 ? execute : 0).cds << id;
    const [locks, ida] = words.slice(equals + 1).map((hex) => Number.parseInt(hex, 16));
    assert.deepEqual([this.locks(cds), acknowledged], [locks, ida]);
  }

  word(wanted) {
    const got = this.frame(0);
    const values = [got.position, got.nerr * 16 + got.nwarn, got.life, number(got.data.slice(-6))];
    wanted.split(":").forEach((hex, i) => assert.ok(hex === "*" || Number.parseInt(hex, 16) === values[i],
      `${values.map((value) => value.toString(16))}`));
  }

  step(step) {
    const [what, ...words] = step.split(" "), equals = words.indexOf("=");
    if (what === "pos") this.board.position(words[0]);
    else if (what === "scd") this.word(words[0]);
    else if (what === "zeros") this.exchange("0".repeat(Number(words[0])));
    else if (what === "read" || what === "write") this.access(step);
    else if (what === "command") this.command(words);
    else if (what === "idl") assert.equal(this.idl, Number.parseInt(words[0], 16));
    else if (what === "frame") {
      const got = this.frame(Number(words[0])), bits = [got.cds, ...got.data].join("");
      assert.ok(matches(bitsIn(words.slice(equals + 1)), bits), bits);
    } else if (what === "control") {
      const cds = this.exchange(bitsIn(words.slice(0, equals)));
      assert.ok(matches(bitsIn(words.slice(equals + 1)), cds), cds);
    } else if (what === "word") {
      this.exchange("0".repeat(14));
      const cds = this.exchange(`1${(Number.parseInt(words[0], 16) >>> 1).toString(2).padStart(31, "0")}0`);
      assert.ok(matches(bitsIn(words.slice(equals + 1)), cds), cds);
    } else {
      this.master.fresh ||= step.startsWith("power on");
      return this.board.step(step);
    }
    return true;
  }

  finish() {
    assert.equal(this.bad, 0, "frames without Ack, start bit or a good CRC");
  }
}

const boards = {};

function begin(step) {
  const [, model, ...words] = step.split(" ");
  const figures = Object.fromEntries(words.filter((word) => word.includes("=")).map((word) => word.split("=")));
  const key = `${model} ${JSON.stringify(figures)}`;
  const patches = Object.entries(figures).map(([name, value]) => {
    const [member, factor] = FIGURES[name];
    return { ...LAYOUT[member], value: Number(value) * factor };
  });
  boards[key] ??= new Board(`drehgeber-${model}`, model.replace("-", "_"), patches, 2 ** Number(figures.st ?? 21));
  boards[key].deliver(words.includes("window"));
  boards[key].pico.run(us(40));
  return new Bench(boards[key], model, figures);
}

test("rows of the conformance tests", (t) => {
  const rows = rowsOf("biss.rows"), ready = possible(rows, KNOWN).filter(({ name }) => !OTHERWISE.includes(name)), tried = some(ready, EACH);
  doRows(tried, begin);
  t.diagnostic(`${tried.length} of ${ready.length} rows, of ${rows.length}`);
  assert.ok(ready.length >= LEAST);
});
