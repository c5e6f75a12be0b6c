// SPDX-License-Identifier: MIT
// The EEPROM in flash: what a power cut leaves anywhere in a write, while the halves of the log change, while a
// sector is erased. The counter of 46h and 47h says what is in it.
import assert from "node:assert/strict";
import { test } from "node:test";

import { Flash, LOG, PowerCut } from "./flash.mjs";
import { HZ, Pico, ms } from "./pico.mjs";
import { Master } from "./rs485.mjs";

const IMAGE = "drehgeber-s3684-rs485";
const HALF = 0x8000;
const ENDURANCE = 100000; // erases of a sector, W25Q16JV
const SECTORS = 16;

function started(kept, cut) {
  const pico = new Pico(IMAGE, { flash: kept });
  const flash = new Flash(pico, cut);
  const master = new Master(pico);
  return { pico, flash, master };
}

const isUp = (board) => board.pico.ask("*IDN?", ms(1000));
const counter = (board) => board.master.ask([0x40, 0x46]).bytes.slice(2, 5).reduce((value, byte) => value << 8 | byte, 0);
const count = (board) => assert.deepEqual(board.master.ask([0x40, 0x47], { within: ms(800) }).bytes.slice(0, 2), [0x40, 0x47]);

/** Runs until the power fails. @return whether it did */
function untilCut(act) {
  try {
    act();
  } catch (error) {
    if (error instanceof PowerCut) return true;
    throw error;
  }
  return false;
}

/** Cut the power at each operation of what `act` does with a board of this flash, torn at several places. */
function cutEverywhere(kept, act, check, parts = [0, 0.02, 0.4, 1]) {
  let operation = 0;
  for (let cut = true; cut; operation++) {
    for (const part of parts) {
      const board = started(kept, { operation, part });
      cut = untilCut(() => act(board));
      if (cut) check(started(board.flash.kept()), `operation ${operation}, ${part} of it done`);
    }
  }
  return operation - 1;
}

test("the first start: a power cut leaves an encoder as delivered", (t) => {
  const n = cutEverywhere(undefined, isUp, (board, what) => {
    isUp(board);
    assert.equal(counter(board), 0, what);
  }, [0.4]);
  t.diagnostic(`${n} pages`);
  assert.ok(n > 10);
});

test("a write: old or new, and new when it was acknowledged", (t) => {
  const first = started();
  isUp(first);
  count(first);
  count(first);
  const n = cutEverywhere(first.flash.kept(), (board) => {
    isUp(board);
    count(board);
    board.done = true;
  }, (board, what) => {
    isUp(board);
    assert.ok([2, 3].includes(counter(board)), what);
    count(board);
    assert.ok([3, 4].includes(counter(board)), what);
  });
  t.diagnostic(`${n} pages a write`);
  assert.ok(n >= 2);
});

test("going round: the halves change, the old one is erased when the line is quiet", (t) => {
  const board = started();
  isUp(board);
  let writes = 0, before;
  const halves = () => board.flash.operations.map(({ address }) => Math.floor((address - LOG) / HALF));
  const begin = halves().at(-1);
  while (halves().at(-1) === begin) {
    before = board.flash.kept();
    count(board);
    writes++;
    assert.ok(writes < 200, "a half is full some time");
  }
  const n = cutEverywhere(before, (again) => {
    isUp(again);
    count(again);
  }, (again, what) => {
    isUp(again);
    assert.ok([writes - 1, writes].includes(counter(again)), what);
    count(again);
  }, [0.4]);
  assert.ok(n > 10, "all of the memory is written");
  const full = board.flash.kept();
  board.pico.run(ms(1500)); // quiet
  assert.equal(board.flash.count("erase"), 8);
  assert.equal(counter(board), writes);
  for (const operation of [0, 3, 7]) { // of the erases
    for (const part of [0, 0.5]) {
      const torn = started(full, { operation, part });
      assert.ok(untilCut(() => {
        isUp(torn);
        torn.pico.run(ms(1500));
      }));
      const again = started(torn.flash.kept());
      isUp(again);
      assert.equal(counter(again), writes);
    }
  }
  const each = board.flash.count("program") / writes;
  t.diagnostic(`${writes} writes in a half, ${each.toFixed(1)} pages each; wear: ` +
    `${(writes * 2 * ENDURANCE / 1e6).toFixed(1)} million writes until each of ${SECTORS} sectors was erased ${ENDURANCE} times`);
});

test("without a quiet moment sectors are erased one by one between requests", (t) => {
  const board = started();
  isUp(board);
  let most = 0, late = 0;
  for (let i = 0; i < 250; i++) {
    const reply = board.master.ask([0x40, 0x47], { within: ms(800) });
    assert.deepEqual(reply.bytes.slice(0, 2), [0x40, 0x47]);
    most = Math.max(most, reply.after);
    late += reply.after > ms(30) ? 1 : 0;
  }
  t.diagnostic(`250 writes, ${board.flash.count("erase")} erases: the latest reply ${(most / HZ * 1e3).toFixed(1)} ms behind ` +
    `the request, ${late} later than 30`);
  assert.equal(counter(board), 250);
  // 5.1.2.5 allows 30 ms. A reply that meets an erase waits for it, 45 ms at most, and 7 (platform/rp2040/README.md, "EEPROM in flash"): only
  // those may be later.
  assert.ok(most <= ms(52));
  assert.ok(late <= board.flash.count("erase"));
});
