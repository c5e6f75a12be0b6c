// SPDX-License-Identifier: MIT
// The page's encoders with two that it has never heard of, beside an S36 and an SSI encoder, without a browser. What it
// finds is a line of JSON.
// usage: node page.mjs FOLDER-OF-THE-PAGE
import { readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";

const folder = `${process.argv[2]}/`;
const load = (name) => import(pathToFileURL(folder + name));
const { Engine } = await load("engine.js");
const { Rig, SECOND } = await load("rig.js");

// Model and wire.
const MODELS = { "s3684-rs485": "pty", "eleven-24": "pty", "ssi-25": "sim", "tenbit-low": "sim" };
const RIG = `[shaft shaft]\n${Object.entries(MODELS).map(([model, wire]) =>
  `[encoder ${model}]\nmodel = ${model}\nwire = ${wire}\n`).join("")}`;
const heard = [];
const engine = await Engine.load(await readFile(`${folder}drehgeber.wasm`));
const rig = new Rig(engine, RIG, {}, ({ encoder, ours, bytes, words }) => {
  heard.push([encoder.model, ours, [...bytes], words]);
});
const [s36, eleven, , tenbit] = rig.encoders;
rig.place(2n ** 30n);
eleven.request(Uint8Array.of(2));
s36.ask(0x42);
rig.advance(SECOND);
eleven.fault("singleturn_lost", true);
eleven.request(Uint8Array.of(2));
rig.advance(SECOND);
let bits = "";
for (let i = 0; i < 10; i++) {
  const at = rig.now + BigInt(i) * 1000n;
  tenbit.clock(at, 0);
  bits += tenbit.clock(at + 500n, 1);
}
const errors = rig.ask(tenbit, "SSI:FRAM?").errors;
console.log(JSON.stringify({
  media: rig.encoders.map((one) => one.medium),
  positions: rig.encoders.map((one) => String(one.position)),
  faults: eleven.faults().map(({ name }) => name),
  state: eleven.state.errors,
  heard,
  bits,
  errors,
}));
