// SPDX-License-Identifier: MIT
// Rows of tests/conformance against an image: reading them, and a board in delivery state for each. Models with other
// figures than the image's are made by writing these into its constants.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";

import { Flash } from "./flash.mjs";
import { Pico, constants, ms, us } from "./pico.mjs";

const TESTS = fileURLToPath(new URL("..", import.meta.url));
const INIT = ms(120); // longer than the initialisation of any

/** Rows of a file: {name, steps}, their repetitions written out. */
export function rowsOf(file) {
  const rows = [];
  let repeated = null;
  for (const line of fs.readFileSync(path.join(TESTS, "conformance", file), "utf8").split("\n")) {
    const step = line.replace(/#.*/, "").trim(), [word, times] = step.split(" ");
    if (line.startsWith("[")) rows.push({ name: line, steps: [] });
    else if (word === "repeat") repeated = { times: Number(times), steps: [] };
    else if (word === "end") {
      for (let i = 0; i < repeated.times; i++) rows.at(-1).steps.push(...repeated.steps);
      repeated = null;
    } else if (step && rows.length) (repeated ?? rows.at(-1)).steps.push(step);
  }
  return rows;
}

/** Where members of a structure are: {member: {at, size}} */
export function layoutOf(header, structure, members) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "rows-"));
  const [source, object, binary] = ["c", "o", "bin"].map((end) => path.join(folder, `layout.${end}`));
  const of = members.map((member) => `offsetof(struct ${structure}, ${member}), sizeof((struct ${structure} *)0)->${member}`);
  fs.writeFileSync(source, `#include <stddef.h>\n#include "drehgeber/${header}"\nconst unsigned layout[] = {${of.join(", ")}};\n`);
  execFileSync("arm-none-eabi-gcc", ["-mcpu=cortex-m0plus", "-mthumb", "-I", path.join(TESTS, "../include"), "-c", source, "-o", object]);
  execFileSync("arm-none-eabi-objcopy", ["-O", "binary", "-j", ".rodata", object, binary]);
  const bytes = fs.readFileSync(binary);
  fs.rmSync(folder, { recursive: true });
  return Object.fromEntries(members.map((member, i) => [member, { at: bytes.readUInt32LE(8 * i), size: bytes.readUInt32LE(8 * i + 4) }]));
}

const spanIn = { ms: (n) => ms(n), us: (n) => us(n), ns: (n) => n / 8 };

/** Cycles of `5ms`, `300us`, `100ns`; `44b` are bits of so many cycles. */
export function span(word, bit) {
  const [, n, unit] = /^(\d+)(ms|us|ns|b)$/.exec(word);
  return Math.ceil(unit === "b" ? Number(n) * bit : spanIn[unit](Number(n)));
}

const QUANTITIES = {
  temperature_mdegc: ["TEMP", (value) => `${value / 1000}DEGC`], led_current_ua: ["LED:CURR", (value) => `${value}UA`],
  supply_mv: ["SUPP", (value) => `${value}MV`], battery_mv: ["BATT", (value) => `${value}MV`],
  sin_amplitude_permille: ["AMPL:SIN", String], cos_amplitude_permille: ["AMPL:COS", String],
  sin_offset_permille: ["OFFS:SIN", String], cos_offset_permille: ["OFFS:COS", String],
  singleturn_ok: ["SING", String], multiturn_amplitude_ok: ["MULT:AMPL", String], multiturn_sync_ok: ["MULT:SYNC", String],
  multiturn_vector_ok: ["MULT:VECT", String], eeprom_acknowledges: ["EEPR", String], watchdog_fired: ["WATC", String],
};

/** A board with an image, which `given` puts into its delivery state again and again. */
export class Board {
  /** `figures`: {at, value, size} in the constant called `model`; `connect` makes what is outside of the chip */
  constructor(image, model, figures, countsPerTurn, connect = () => null) {
    const patches = figures.map(({ at, value, size }) => ({ at: constants(image, model) + at, value, size }));
    this.pico = new Pico(image, { patches });
    this.flash = new Flash(this.pico);
    this.can = connect(this.pico);
    this.countsPerTurn = countsPerTurn;
    this.pico.ask("*IDN?");
    this.pico.run(INIT);
  }

  /** As delivered, and switched on. */
  deliver(window) {
    this.pico.order("POW OFF", "NVM:ERAS", "WORL:DEF", "SHAF:VEL 0RPM", "SHAF:POS 0DEG");
    this.power(true, window);
  }

  /** `window`: no more time passes than the console takes to do it, whose UART waits for more, and which waits for flash. */
  power(on, window) {
    const { pico, flash } = this;
    pico.tell(`POW ${on ? "ON" : "OFF"}`);
    pico.run(Math.ceil(pico.told) - pico.cycle + us(600));
    while (flash.until > pico.cycle) pico.run(flash.until - pico.cycle + us(200));
    if (!window) pico.run(on ? INIT : ms(10));
  }

  /** In the middle of a count. */
  position(count) {
    const turns = (Number(count) + 0.5) / this.countsPerTurn;
    this.pico.order(`SHAF:POS ${(turns * 360).toFixed(6)}DEG`);
  }

  /** A step that all rows have. @return false: it is not one */
  step(step, bit) {
    const [what, ...words] = step.split(" ");
    if (what === "wait") this.pico.run(span(words[0], bit));
    else if (what === "power") this.power(words[0] === "on", words[1] === "window");
    else if (what === "world") {
      for (const word of words) {
        const [name, value] = word.split("=");
        this.pico.order(`WORL:${QUANTITIES[name][0]} ${QUANTITIES[name][1](Number(value))}`);
      }
    } else return false;
    return true;
  }
}

/** What all rows may have, for `possible`. */
export const COMMON = [/^wait \d+(ms|us|ns|b)$/, /^power (off|on)( window)?$/, /^world( \w+=-?\d+)+$/];

/** One of so many rows is done, and all of them with DREHGEBER_ROWS=all. */
export const some = (rows, of) => process.env.DREHGEBER_ROWS === "all" ? rows : rows.filter((_, i) => i % of === 0);

/** Rows of which every step is known. */
export const possible = (rows, known) => rows.filter(({ steps }) => steps.length > 1 &&
  steps.every((step) => [...COMMON, ...known].some((one) => one.test(step))));

/** Do rows one after the other; `begin` takes `given` and gives what does the other steps, and its `finish`. */
export function doRows(rows, begin) {
  for (const { name, steps } of rows) {
    let bench;
    for (const step of [...steps, null]) {
      try {
        if (step === null) bench.finish?.();
        else if (step.startsWith("given")) bench = begin(step);
        else assert.notEqual(bench.step(step), false, "not a step");
      } catch (error) {
        throw new Error(`${name}\n  ${step ?? "its end"}\n${error.message}`);
      }
    }
  }
}
