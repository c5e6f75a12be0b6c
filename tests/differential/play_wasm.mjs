// SPDX-License-Identifier: MIT
// The player as a program of WebAssembly, in node. usage: node --no-warnings play_wasm.mjs PLAY.wasm < SCRIPTS
import { readFile } from "node:fs/promises";
import { WASI } from "node:wasi";

const file = process.argv[2];
const wasi = new WASI({ version: "preview1", args: [file] });
const { instance } = await WebAssembly.instantiate(await readFile(file), wasi.getImportObject());
process.exitCode = wasi.start(instance);
