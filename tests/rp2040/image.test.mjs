// SPDX-License-Identifier: MIT
// What is dropped on a board is what the emulator runs (UF2: https://github.com/microsoft/uf2).
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { test } from "node:test";

const IMAGES = process.env.DREHGEBER_IMAGES;
const FLASH = 0x10000000, LOG = 0x101f0000, FAMILY = 0xe48bff56, SRAM = 264 * 1024, STACK = 16 * 1024;
const WIRES = ["biss", "rs485", "slcan", "mcp2515", "ssi"];

const names = fs.readdirSync(IMAGES).filter((name) => name.endsWith(".uf2")).map((name) => name.slice(0, -4));

test("there is an image for every wire", () => {
  for (const wire of WIRES) assert.ok(names.some((name) => name.includes(wire)), wire);
});

test("UF2 files have the images, 256 bytes a block, below the EEPROM", () => {
  for (const name of names) {
    const image = fs.readFileSync(path.join(IMAGES, `${name}.bin`)), file = fs.readFileSync(path.join(IMAGES, `${name}.uf2`));
    const count = Math.ceil(image.length / 256), got = [];
    assert.equal(file.length, 512 * count);
    for (let i = 0; i < count; i++) {
      const word = (n) => file.readUInt32LE(512 * i + 4 * n);
      const head = [0x0a324655, 0x9e5d5157, 0x2000, FLASH + 256 * i, 256, i, count, FAMILY];
      assert.deepEqual(Array.from({ length: 8 }, (_, n) => word(n)), head, `${name}, block ${i}`);
      assert.equal(word(127), 0x0ab16f30);
      got.push(file.subarray(512 * i + 32, 512 * i + 288));
    }
    assert.ok(Buffer.concat(got).subarray(0, image.length).equals(image));
    assert.ok(FLASH + 256 * count <= LOG);
  }
});

test("all but the stack fits SRAM", (t) => {
  for (const name of names) {
    const [, sizes] = execFileSync("arm-none-eabi-size", [path.join(IMAGES, `${name}.elf`)], { encoding: "utf8" }).split("\n");
    const [text, data, bss] = sizes.trim().split(/\s+/).map(Number);
    t.diagnostic(`${name}: ${(text / 1024).toFixed(1)} KiB code and tables, ${((data + bss) / 1024).toFixed(1)} KiB data`);
    assert.ok(text + data + bss <= SRAM - STACK);
  }
});
