// SPDX-License-Identifier: MIT
// The encoders of the playground and their masters.
import { BissMaster } from "./biss.js";
import { SINCOS } from "./figures.js";
import { hexadecimal, unhex } from "./parts.js";

// A master that is silent for longer than 100 ms counts as gone.
const BUS_NS = 50_000_000n;

// A clocked wire of any form, which the library's master reads.
const CLOCKED = {
  figure: "Bits of the latest frame", drawing: "bits", drawn: "As the encoder sends them, position, flags and check sum.",
  ask: (e) => e.read(),
  look: (e) => [() => e.read()],
  buttons: (e) => [["Frame", () => e.read()]],
  forms: () => [],
};

// What is shown of an encoder that the user has put in: the master of its wire, with its own name where it is not alone.
export function rowOf(encoder, others) {
  const same = others.find(({ medium }) => medium === encoder.medium);
  const master = encoder.clocked ? CLOCKED : ENCODERS.find(({ model }) => model === same.model);
  const title = others.filter(({ own }) => own).length > 1 ? encoder.name : "Yours";
  return { ...master, model: encoder.model, title, name: encoder.model, what: `The encoder of your text: ${encoder.model}, ${encoder.what}.` };
}

// Each encoder of the playground, in the order of the tabs: its model, its kind of wire, what it is called, what is drawn of
// it (`drawing`, of view.js), and what its master can do. `ask` is what is repeated, `look` tells of an error; a form is its
// fields, the text of its button, and what is done with the fields' values; `master` makes one that has a state of its own.
export const ENCODERS = [
  {
    model: "s3684-rs485", wire: "pty",
    title: "RS485", name: "S36", ...SINCOS, drawing: "sincos",
    what: "A Kübler S36 for servo motors: the drive asks for the position in bytes, then follows two voltages, sine and cosine.",
    ask: (e) => e.ask(0x42),
    look: (e) => [() => e.ask(0x42), () => e.ask(0x50)],
    buttons: (e) => [
      ["42h position", () => e.ask(0x42)],
      ["50h status", () => e.ask(0x50)],
      ["44h temperature", () => e.ask(0x44, 0x48)],
      ["52h type label", () => e.ask(0x52)],
      ["56h serial number", () => e.ask(0x56)],
      ["53h reset", () => e.ask(0x53)],
    ],
    forms: (e) => [[[["Bytes", "40 42 02", "wide-field"]], "Send", (text) => e.request(unhex(text))]],
  },
  {
    model: "s3684-biss", wire: "sim",
    title: "BiSS-C", name: "S36", figure: "Lines of the latest frame", drawing: "lines",
    what: "A Kübler S36 for fast drives: the drive gives a clock and gets the position bit by bit, with a check sum.",
    drawn: "The drive's clock is MA; the encoder puts one bit on SLO for each of its pulses.",
    master: (e) => new BissMaster(e),
    ask: (e) => e.master.read(),
    look: (e) => [() => e.master.read(), () => e.master.readRegisters(0x69, 1)],
    buttons: (e) => [
      ["Frame", () => e.master.read()],
      ["69h errors", () => e.master.readRegisters(0x69, 1)],
      ["6Bh warnings", () => e.master.readRegisters(0x6b, 1)],
      ["78h device ID", () => e.master.readRegisters(0x78, 8)],
    ],
    forms: (e) => [
      [[["Register", "40"], ["Count", "8"]], "Read", (address, n) =>
        e.master.readRegisters(hexadecimal(address, "register") & 0x7f, Math.min(64, Math.max(1, Number(n) || 1)))],
      [[["Register", "40"], ["Bytes", "00", "wide-field"]], "Write", (address, bytes) =>
        e.master.writeRegisters(hexadecimal(address, "register") & 0x7f, unhex(bytes))],
    ],
  },
  {
    model: "f3668", wire: "slcan",
    title: "CANopen", name: "F36x8",
    what: "A Kübler F36x8 on a CAN bus, as in cranes and vehicles: many devices share two wires and send messages.",
    ask: (e) => e.sdoRead(0x6004, 0),
    look: (e) => [() => e.sdoRead(0x1001, 0), () => e.sdoRead(0x1003, 1), () => e.sdoRead(0x6503, 0)],
    buttons: (e) => [
      ["SDO 6004h position", () => e.sdoRead(0x6004, 0)],
      ["NMT start", () => e.frame(0, [1, 0])],
      ["NMT pre-op", () => e.frame(0, [0x80, 0])],
      ["SYNC", () => e.frame(0x80, [])],
      ["NMT reset", () => e.frame(0, [0x81, 0])],
    ],
    forms: (e) => [
      [[["Index", "1018"], ["Sub", "1"]], "Read", (index, sub) =>
        e.sdoRead(hexadecimal(index, "index"), hexadecimal(sub, "sub-index"))],
      [[["ID", "000"], ["Data", "01 00", "wide-field"]], "Send", (id, data) =>
        e.frame(hexadecimal(id, "identifier") & 0x7ff, data ? [...unhex(data)].slice(0, 8) : [])],
    ],
  },
  {
    model: "ocd-ib-k3", wire: "modbus",
    title: "INTERBUS", name: "OCD", figure: "Words of the latest cycle", drawing: "words",
    what: "A POSITAL OCD in a ring of devices: a controller shifts 32 bits through it and gets 32 bits back, again and again.",
    drawn: "The 32 bits that came back last.",
    every: BUS_NS,
    ask: (e, quiet) => e.cycle(e.lastOut ?? 0, quiet),
    look: (e) => [() => e.identify(), () => e.cycle(e.lastOut ?? 0)],
    buttons: (e) => [["Data cycle", () => e.cycle(e.lastOut ?? 0)], ["ID cycle", () => e.identify()]],
    forms: (e) => [[[["OUT", "00000000", "wide-field"]], "Cycle with it", (out) => e.cycle(hexadecimal(out, "OUT"))]],
  },
];

// The rig of the playground, as a rig file says it.
export const PLAYGROUND = `[shaft shaft]\n${ENCODERS.map(({ model, wire }) =>
  `[encoder ${model}]\nmodel = ${model}\nwire = ${wire}\n`).join("")}`;
