// SPDX-License-Identifier: MIT
// Encoders that are calculated here, in virtual time: rigs of the library's (page_rig.c), and what their masters ask. Nothing
// happens but when advance() is called. Times are nanoseconds, angles 2^-32 turns, both as BigInt.
import { catalogueOf, degrees, stateOf, unitsOf } from "./parts.js";

const MEDIUM = { characters: 0, edges: 2 };
// struct dg_host_frame, as host.h promises.
const FRAME = { end: 8, bits: 16, position: 24, count: 40, error: 41, warning: 42, good: 43 };
// The first words of struct web_encoder, page.h.
const MEMBERS = ["host", "wireAt", "bus", "place", "shaft", "name", "what", "page", "prompt"];
const WORD = 4;
// Memory for a rig: one that needs more is made anew.
const RIG_MIN = 1 << 19;
const RIG_MAX = 1 << 26;
const REQUEST_MAX = 270;
const REPLY_NS = 100_000_000n;
const ANSWER = 32768;
const ERROR = "SYST:ERR?";
// Masters look that often whether they go on.
const STEP_NS = 5_000_000n;

export const SECOND = 1_000_000_000n;

export const unsigned = (value) => BigInt.asUintN(64, value);
const isFine = (error) => /^[+]?0,/.test(error);
const inDegrees = (angle) => `${degrees(angle).toFixed(9)} DEG`;

// A file that is a model, and a rig of it; what is wrong is wrong in that file.
const EDS_RIG = "[encoder own]\nmodel = text.eds\nwire = slcan\n";
const EDS_PLACE = /^.*text\.eds(:\d+)?: /;
const SECTION = { rig: /^[ \t]*\[encoder\s/im, model: /^[ \t]*\[model\s/im };

export class Encoder {
  constructor(rig, at) {
    const { engine } = rig;
    Object.assign(this, { rig, engine, at, c: engine.c, waiting: [], busyUntil: 0n, edges: [] });
    MEMBERS.forEach((name, i) => { this[name] = engine.view.getUint32(at + WORD * i, true); });
    this.name = engine.text(this.name);
    this.what = engine.text(this.what);
    this.model = engine.text(this.c.dg_host_model(this.host));
    this.key = engine.text(this.c.dg_host_protocol(this.host));
    this.medium = this.c.dg_host_medium(this.host);
    this.catalogue = catalogueOf(unitsOf(this.scpi("FAUL:CAT?"))[0]);
  }

  get memory() {
    const n = this.c.dg_host_memory_size(this.host);
    this.engine.checked(this.c.dg_host_memory_copy(this.host, this.engine.scratch, n), "EEPROM");
    return this.engine.bytes(this.engine.scratch, n).slice();
  }

  // Go on with that EEPROM, or as delivered.
  load(image) {
    const fits = image.length === this.c.dg_host_memory_size(this.host);
    this.power(false);
    if (fits) {
      this.engine.checked(this.c.dg_host_memory_load(this.host, this.put(image), image.length), "EEPROM");
    }
    this.power(true);
    if (!fits || !this.powered) {
      this.refused = `${this.model} does not start with the EEPROM that was kept here: it is as delivered`;
      this.erase();
    }
  }

  get clocked() {
    return this.medium === MEDIUM.edges;
  }

  get powered() {
    return this.c.dg_host_powered(this.host) !== 0;
  }

  setting(key) {
    const { scratch } = this.engine;
    const [name] = this.engine.spell(key);
    this.engine.checked(this.c.dg_host_get(this.host, name, scratch, 256), key);
    return this.engine.text(scratch);
  }

  get node() {
    return Number(this.setting("node"));
  }

  get position() {
    const { scratch } = this.engine;
    const result = this.c.dg_host_position(this.host, this.rig.now, scratch);
    return result < 0 ? null : this.engine.view.getBigUint64(scratch, true);
  }

  // RS485: sine and cosine as voltages between their two wires, or null without power.
  sincos(at) {
    const { scratch, view } = this.engine;
    if (this.c.dg_host_sincos(this.host, at, scratch) < 0) {
      return null;
    }
    const level = (i) => view.getInt32(scratch + 4 * i, true) / 1e6;
    return [level(0) - level(1), level(2) - level(3)];
  }

  // ---------------------------------------------------------------- the wire

  // Bytes for one call.
  put(bytes) {
    this.engine.bytes(this.engine.scratch, bytes.length).set(bytes);
    return this.engine.scratch;
  }

  // RS485: a frame as it is; requests wait for each other's reply.
  request(bytes) {
    if (!this.powered) {
      return;
    }
    if (bytes.length > REQUEST_MAX) {
      throw new Error(`${bytes.length} bytes: expected at most ${REQUEST_MAX}`);
    }
    if (this.rig.now < this.busyUntil) {
      this.waiting.push(bytes);
      return;
    }
    this.busyUntil = REPLY_NS + unsigned(this.c.web_request(this.at, this.rig.now, this.put(bytes), bytes.length));
  }

  // RS485: address, command and data, with the check sum behind them.
  ask(...bytes) {
    const frame = [Number(`0x${this.state.address ?? "40"}`), ...bytes];
    this.request(Uint8Array.from([...frame, frame.reduce((sum, byte) => sum ^ byte, 0)]));
  }

  // CANopen: a frame of the master.
  frame(id, data) {
    this.c.web_frame(this.at, this.rig.now, id, this.put(data), data.length);
    this.rig.advance(0n);
  }

  sdoRead(index, sub) {
    this.frame(0x600 + this.node, [0x40, index & 0xff, index >> 8, sub, 0, 0, 0, 0]);
  }

  // INTERBUS: a data cycle; the bytes of IN, or null. A quiet one is told by the next that is not.
  cycle(out, quiet = false) {
    const { scratch } = this.engine;
    const count = this.c.web_cycle(this.at, this.rig.now, out >>> 0, quiet ? 0 : 1, scratch);
    if (count < 0) {
      if (!quiet) {
        this.note("no data in this cycle", false, "error");
      }
      return null;
    }
    this.lastIn = this.engine.bytes(scratch, count).slice();
    this.lastOut = out;
    return this.lastIn;
  }

  identify() {
    const id = this.c.web_identify(this.at, this.rig.now);
    if (id < 0) {
      this.note("no ID cycle", true, "error");
      return null;
    }
    this.note(`ID ${id.toString(16).toUpperCase().padStart(4, "0")}`, true, "notice");
    return id;
  }

  // Clocked wires: a frame as the library's own master reads it, of any form.
  read() {
    const { scratch, view } = this.engine;
    this.engine.checked(this.c.dg_host_frame(this.host, this.rig.now, scratch), "the frame");
    const byte = (at) => view.getUint8(scratch + at);
    const count = byte(FRAME.count);
    this.lastBits = view.getBigUint64(scratch + FRAME.bits, true).toString(2).padStart(count, "0");
    const [error, warning, good] = [byte(FRAME.error), byte(FRAME.warning), byte(FRAME.good)];
    const flags = [[error, "error"], [warning, "warning"], [!good, "check sum wrong"]];
    const told = flags.filter(([is]) => is).map(([, word]) => word);
    const position = view.getBigUint64(scratch + FRAME.position, true);
    const end = view.getBigUint64(scratch + FRAME.end, true);
    this.note([`position ${position}`, ...told].join(", "), true, error || !good ? "error" : warning ? "warning" : "ok");
    this.c.dg_bus_changed(this.bus, this.place, end);
    this.rig.advance(end > this.rig.now ? end - this.rig.now : 0n);
    return this.lastBits;
  }

  // BiSS: the clock at a level from then on.
  clock(at, level) {
    return this.c.dg_bus_edge(this.bus, at, level);
  }

  note(words, ours, severity) {
    this.said({ at: this.rig.now, ours, severity, bytes: [], words });
  }

  // A line of what goes over the wire.
  said(line) {
    this.rig.heard({ encoder: this, ...line });
    if (line.ours && this.medium === MEDIUM.characters) {
      this.busyUntil = this.rig.now;
    }
  }

  later() {
    if (this.waiting.length > 0 && this.rig.now >= this.busyUntil) {
      this.request(this.waiting.shift());
    }
  }

  // ---------------------------------------------------------------- faults and SCPI

  faults() {
    const [active] = unitsOf(this.scpi("FAUL:ACT?"));
    return this.catalogue.map((fault) => ({ ...fault, active: active.includes(fault.name) }));
  }

  fault(name, on) {
    this.tell(`FAUL:${on ? "SET" : "CLE"} ${name}`);
    this.rig.advance(0n);
  }

  // A line in one of its two sessions, the page's and that of the prompt. @return what is answered; null: one before waits
  talk(session, line) {
    const [text] = this.engine.spell(line);
    const { scratch } = this.engine;
    const waits = this.engine.checked(this.c.web_scpi(session, this.rig.now, text, scratch, ANSWER), line.trim());
    return waits ? null : this.engine.text(scratch).replace(/\n$/, "");
  }

  scpi(line) {
    return this.talk(this.page, `${line}\n`);
  }

  // The same for a command that has to succeed.
  tell(line) {
    this.scpi(`*CLS;:${line}`);
    const error = this.scpi(ERROR);
    if (!isFine(error)) {
      throw new Error(error);
    }
  }

  // What the prompt is answered later.
  get late() {
    return this.talk(this.prompt, "");
  }

  get state() {
    return stateOf(unitsOf(this.scpi("STAT?"))[0]);
  }

  power(on) {
    this.scpi(on ? "POW ON" : "POW OFF");
    this.busyUntil = 0n;
    this.waiting.length = 0;
  }

  // The EEPROM as delivered.
  erase() {
    this.scpi("POW OFF");
    this.scpi("NVM:ERAS");
    this.scpi("POW ON");
  }
}

export class Rig {
  // The rig of a text; `images` are EEPROMs by model; `heard` is told of every frame {encoder, at, ours, severity, bytes, words}.
  constructor(engine, text, images, heard) {
    Object.assign(this, { engine, c: engine.c, heard, now: 0n, encoders: [] });
    engine.line = (wire, line) => this.on(wire).forEach((one) => one.said(line));
    engine.level = (wire, edge) => this.on(wire).forEach((one) => one.edges.push(edge));
    this.rigs = [this.make([text], 0, 0n)];
    const encoders = this.encodersOf(this.rigs[0]);
    encoders.filter(({ model }) => images[model]).forEach((one) => one.load(images[one.model]));
    this.advance(SECOND); // nobody listens yet
    this.encoders = encoders;
    this.show(encoders[0]);
  }

  // A rig of the library, its encoders on the shaft of the `first` one, if that is not 0.
  make(texts, first, begin) {
    const { engine } = this;
    const list = engine.place(4 * WORD);
    texts.forEach((text, i) => {
      const bytes = new TextEncoder().encode(text);
      const at = engine.place(bytes.length);
      engine.bytes(at, bytes.length).set(bytes);
      engine.view.setUint32(list + 2 * WORD * i, at, true);
      engine.view.setUint32(list + 2 * WORD * i + WORD, bytes.length, true);
    });
    for (let size = RIG_MIN; size <= RIG_MAX; size *= 4) {
      const at = engine.place(size);
      if (this.c.web_rig_make(at, size, list, first, begin) === 0) {
        return at;
      }
      const wrong = engine.text(at);
      if (wrong) {
        throw new Error(wrong.replace(EDS_PLACE, (_, line) => (line ? `line ${line.slice(1)}: ` : "")));
      }
    }
    throw new Error("too long for this page");
  }

  encodersOf(rig) {
    const found = [];
    for (let at = this.c.web_encoder(rig, 0); at !== 0; at = this.c.web_encoder(rig, found.length)) {
      found.push(new Encoder(this, at));
    }
    return found;
  }

  // The user's encoders, in the place of those before: a text of models alone or an EDS file is one, on the same shaft from
  // now on; a rig file has its own shafts.
  own(text) {
    const isRig = SECTION.rig.test(text);
    const texts = isRig || SECTION.model.test(text) ? [text] : [EDS_RIG, text];
    const guest = this.make(texts, isRig ? 0 : this.rigs[0], this.now - SECOND);
    this.c.web_rig_step(guest, this.now);
    const encoders = this.encodersOf(guest);
    encoders.forEach((one, i) => Object.assign(one, { own: true, key: i === 0 ? "own" : `own-${i + 1}` }));
    this.rigs = [this.rigs[0], guest];
    this.encoders = [...this.encoders.filter(({ own }) => !own), ...encoders];
    this.advance(0n);
    return encoders;
  }

  encoder(key) {
    return this.encoders.find((one) => one.key === key);
  }

  on(wire) {
    return this.encoders.filter((one) => one.wireAt === wire);
  }

  // Time goes on for everybody.
  advance(ns) {
    const end = this.now + ns;
    do {
      const next = this.now + STEP_NS < end ? this.now + STEP_NS : end;
      this.rigs.forEach((rig) => this.c.web_rig_step(rig, next));
      this.now = next;
      this.encoders.forEach((one) => one.later());
    } while (this.now < end);
  }

  // ---------------------------------------------------------------- the shaft of the encoder that is shown

  show(encoder) {
    this.shown = encoder;
  }

  get angle() {
    return this.c.dg_host_angle(this.shown.host, this.now);
  }

  // In rpm.
  get speed() {
    return this.c.dg_shaft_mrpm(this.shown.shaft, this.now) / 1000;
  }

  // Be there at rest.
  place(angle) {
    this.shown.tell(`SHAF:POS ${inDegrees(angle)}`);
    this.advance(0n);
  }

  accelerate(rpmPerS) {
    this.shown.tell(`SHAF:ACC ${rpmPerS.toFixed(3)} RPM/S`);
  }

  turn(rpm) {
    this.shown.tell(`SHAF:VEL ${rpm.toFixed(3)} RPM`);
  }

  move(angle, rpm) {
    this.shown.tell(`SHAF:MOVE ${inDegrees(angle)},${rpm.toFixed(3)} RPM`);
  }

  // A line at the prompt: what is answered, and errors.
  ask(encoder, line) {
    const talk = (words) => encoder.talk(encoder.prompt, `${words}\n`);
    const said = talk(line);
    if (said === null) {
      throw new Error("The line before is not done yet");
    }
    const errors = [];
    for (let error = talk(ERROR); error !== null && !isFine(error); error = talk(ERROR)) {
      errors.push(error);
    }
    return { said: said ? [said] : [], errors };
  }
}
