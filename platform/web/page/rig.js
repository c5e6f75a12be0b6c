// SPDX-License-Identifier: MIT
// Four encoders on one shaft, in virtual time: nothing happens but when advance() is called. Times are nanoseconds,
// angles 2^-32 turns, both as BigInt. Layouts are those that host.h promises.

const EVENT = { size: 32, at: 0, id: 8, kind: 14, length: 15, data: 16 };
const FAULT = { size: 48, name: 0, cause: 32, effect: 36, active: 40 };
const KIND = { bytes: 1, can: 2, edge: 4 };
const MEDIUM = { characters: 0, frames: 1, edges: 2, words: 3 };
// struct dg_host_frame.
const FRAME = { end: 8, bits: 16, position: 24, count: 40, error: 41, warning: 42, good: 43 };
// struct web_source of page_models.c, and memory for what is read: what is longer is asked for anew.
const SOURCE = { text: 0, n: 4, memory: 8, size: 12, wrong: 16, all: 16 + 1024 };
const READ_MIN = 1 << 18;
const READ_MAX = 1 << 26;
const RUN = 16;
const REPLY_NS = 100_000_000n;
const ANSWER = 32768;
const ERROR = "SYST:ERR?";
// Queues have 64 events: no encoder says more than that in so short a time.
const STEP_NS = 5_000_000n;

export const SECOND = 1_000_000_000n;

export const unsigned = (value) => BigInt.asUintN(64, value);

export class Encoder {
  constructor(rig, device, image) {
    this.rig = rig;
    this.engine = rig.engine;
    this.c = rig.engine.c;
    this.device = device;
    this.model = this.engine.text(this.c.web_device_name(device));
    this.what = this.engine.text(this.c.web_device_what(device));
    this.words = this.engine.place(this.c.web_words_size(device));
    this.c.web_words_init(this.words, device);
    this.event = this.engine.place(EVENT.size);
    this.faultAt = this.engine.place(FAULT.size);
    this.raw = { true: [], false: [] };
    this.waiting = [];
    this.busyUntil = 0n;
    this.edges = [];
    this.make();
    if (image && !this.starts(image)) {
      this.refused = `${this.model} does not start with the EEPROM that was kept here: it is as delivered`;
      this.make();
    }
    this.starts(null);
    this.medium = this.c.dg_host_medium(this.host);
    this.key = this.engine.text(this.c.dg_host_protocol(this.host));
    if (!Object.values(MEDIUM).includes(this.medium)) {
      throw new Error(`${this.model} speaks ${this.key}: this page does not know its wire`);
    }
    this.c.dg_host_step(this.host, rig.now);
    while (this.receive() !== null);
    const size = this.c.dg_host_panel_size();
    this.panel = this.c.dg_host_panel_make(this.engine.place(size), size, this.host);
    if (this.medium === MEDIUM.words) {
      this.ring = this.engine.place(this.c.web_ring_size());
      this.c.web_ring_init(this.ring, this.words, this.host, this.panel);
    }
  }

  make() {
    const size = this.c.web_host_size(this.device);
    this.host = this.c.web_host_make(this.engine.place(size), size, this.device);
  }

  // On for a second, with this image or, unless it is on, as delivered.
  starts(image) {
    if (image) {
      const { scratch } = this.engine;
      this.engine.bytes(scratch, image.length).set(image);
      if (this.c.dg_host_memory_load(this.host, scratch, image.length) < 0) {
        return false;
      }
    }
    return this.powered || this.c.dg_host_power(this.host, this.rig.now - SECOND, 1) === 0;
  }

  get memory() {
    const n = this.c.dg_host_memory_size(this.host);
    this.engine.checked(this.c.dg_host_memory_copy(this.host, this.engine.scratch, n), "EEPROM");
    return this.engine.bytes(this.engine.scratch, n).slice();
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

  write({ at, id = 0, kind, data }) {
    const { view } = this.engine;
    this.engine.bytes(this.event, EVENT.size).fill(0);
    view.setBigUint64(this.event + EVENT.at, at, true);
    view.setUint32(this.event + EVENT.id, id, true);
    view.setUint8(this.event + EVENT.kind, kind);
    view.setUint8(this.event + EVENT.length, data.length);
    this.engine.bytes(this.event + EVENT.data, data.length).set(data);
  }

  send(event, about) {
    this.write(event);
    this.engine.checked(this.c.dg_host_send(this.host, this.event), about);
  }

  // What the encoder has said, or null; the event itself stays in memory for its words.
  receive() {
    if (this.c.dg_host_receive(this.host, this.event) <= 0) {
      return null;
    }
    const { view } = this.engine;
    const length = view.getUint8(this.event + EVENT.length);
    return {
      at: view.getBigUint64(this.event + EVENT.at, true),
      id: view.getUint32(this.event + EVENT.id, true),
      kind: view.getUint8(this.event + EVENT.kind),
      data: this.engine.bytes(this.event + EVENT.data, length).slice(),
    };
  }

  uart() {
    const at = this.engine.scratch;
    this.engine.checked(this.c.dg_host_uart(this.host, at), "the line");
    return { at, characterNs: unsigned(this.c.dg_host_uart_ns(at, 1)) };
  }

  decodeUart(ours, data) {
    if (this.powered) {
      const { at } = this.uart();
      this.raw[ours].push(...data);
      this.c.web_words_uart(this.words, this.event, ours ? 1 : 0, at);
    }
  }

  // RS485: a frame as it is; requests wait for each other's reply.
  request(bytes) {
    if (!this.powered) {
      return;
    }
    if (this.rig.now < this.busyUntil) {
      this.waiting.push(bytes);
      return;
    }
    const { characterNs } = this.uart();
    for (let done = 0; done < bytes.length; done += RUN) {
      const data = bytes.slice(done, done + RUN);
      const at = this.rig.now + BigInt(done) * characterNs;
      this.send({ at, id: Number(characterNs), kind: KIND.bytes, data }, "the request");
      this.decodeUart(false, data);
    }
    this.busyUntil = this.rig.now + BigInt(bytes.length) * characterNs + REPLY_NS;
  }

  // RS485: address, command and data, with the check sum behind them.
  ask(...bytes) {
    const frame = [Number(`0x${this.state.address ?? "40"}`), ...bytes];
    this.request(Uint8Array.from([...frame, frame.reduce((sum, byte) => sum ^ byte, 0)]));
  }

  // CANopen: a frame of the master.
  frame(id, data) {
    this.send({ at: this.rig.now, id, kind: KIND.can, data }, "the frame");
    this.raw.false.push(...data);
    this.c.web_words_can(this.words, this.event, 0);
    this.rig.advance(0n);
  }

  sdoRead(index, sub) {
    this.frame(0x600 + this.node, [0x40, index & 0xff, index >> 8, sub, 0, 0, 0, 0]);
  }

  // INTERBUS: a data cycle; the bytes of IN, or null. A quiet one is told by the next that is not.
  cycle(out, quiet = false) {
    if (!this.c.web_ring_cycle(this.ring, this.rig.now, out >>> 0, quiet ? 0 : 1)) {
      if (!quiet) {
        this.note("no data in this cycle", false, "error");
      }
      return null;
    }
    this.lastIn = this.ringBytes();
    this.lastOut = out;
    return this.lastIn;
  }

  ringBytes() {
    const { scratch } = this.engine;
    return this.engine.bytes(scratch, this.c.web_ring_in(this.ring, scratch)).slice();
  }

  identify() {
    const id = this.c.web_ring_identify(this.ring, this.rig.now);
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
    this.rig.advance(end > this.rig.now ? end - this.rig.now : 0n);
    return this.lastBits;
  }

  // BiSS: the clock at a level from then on.
  clock(at, level) {
    return this.engine.checked(this.c.dg_host_clock(this.host, at, level), "the clock");
  }

  note(words, ours, severity) {
    this.rig.heard({ encoder: this, at: this.rig.now, ours, severity, bytes: [], words });
  }

  // A line of what goes over the wire.
  said(line) {
    const bytes = this.ring && line.ours ? this.ringBytes() : this.raw[line.ours].splice(0);
    this.rig.heard({ encoder: this, bytes, ...line });
    if (line.ours && this.medium === MEDIUM.characters) {
      this.busyUntil = this.rig.now;
    }
  }

  drain() {
    for (let event = this.receive(); event !== null; event = this.receive()) {
      if (event.kind === KIND.bytes) {
        this.decodeUart(true, event.data);
      } else if (event.kind === KIND.can) {
        this.raw.true.push(...event.data);
        this.c.web_words_can(this.words, this.event, 1);
      } else if (event.kind === KIND.edge) {
        this.edges.push({ at: event.at, level: event.data[0] });
      }
    }
  }

  // Until then; what it says is told.
  run(now) {
    this.c.dg_host_panel_step(this.panel, now);
    this.drain();
    this.c.web_words_step(this.words, now);
  }

  later() {
    if (this.waiting.length > 0 && this.rig.now >= this.busyUntil) {
      this.request(this.waiting.shift());
    }
  }

  // ---------------------------------------------------------------- faults and SCPI

  faults() {
    const at = this.faultAt;
    const found = [];
    while (this.c.dg_host_fault(this.panel, found.length, at) === 0) {
      const { view } = this.engine;
      found.push({
        name: this.engine.text(at + FAULT.name),
        cause: this.engine.text(view.getUint32(at + FAULT.cause, true)),
        effect: this.engine.text(view.getUint32(at + FAULT.effect, true)),
        active: view.getUint8(at + FAULT.active) === 1,
      });
    }
    return found;
  }

  fault(name, on) {
    const [text] = this.engine.spell(name);
    this.engine.checked(this.c.dg_host_fault_set(this.panel, this.rig.now, text, on ? 1 : 0), name);
    this.rig.advance(0n);
  }

  scpi(line) {
    const [text] = this.engine.spell(line);
    const { scratch } = this.engine;
    this.engine.checked(this.c.dg_host_scpi(this.panel, this.rig.now, text, scratch, ANSWER), line);
    const answer = this.engine.text(scratch);
    this.drain();
    return answer;
  }

  // STATe? as an object.
  get state() {
    const row = this.scpi("STAT?").replaceAll('"', "");
    return Object.fromEntries(row.split(/[,\s]+/).map((word) => word.split("=")));
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

  get node() {
    return Number(this.setting("node"));
  }
}

export class Rig {
  // An encoder of each model; `images` are EEPROMs by model; `heard` is told of every frame {encoder, at, ours, severity, bytes, words}.
  constructor(engine, models, images, heard) {
    this.engine = engine;
    this.c = engine.c;
    this.now = SECOND;
    this.heard = heard;
    engine.line = (wire, line) => this.encoders.find((one) => one.words === wire).said(line);
    this.encoders = [];
    for (const model of models) {
      const [name] = engine.spell(model);
      this.encoders.push(new Encoder(this, this.c.web_device(name), images[model]));
    }
    // The first one's shaft is everybody's; theirs follow, so that SHAFt:POSition? is right at each of them.
    this.shaft = this.c.dg_host_panel_shaft(this.encoders[0].panel);
    this.encoders.slice(1).forEach((encoder) => this.couple(encoder));
  }

  couple(encoder) {
    this.engine.checked(this.c.dg_shaft_couple(this.c.dg_host_panel_shaft(encoder.panel), this.shaft, 1, 1), "the shaft");
  }

  // The model of a text, or of an EDS file: what begins no [model] is one.
  readModel(text) {
    const { engine } = this;
    const bytes = new TextEncoder().encode(text);
    const source = engine.place(SOURCE.all);
    const at = engine.place(bytes.length);
    const [name] = engine.spell(/^[ \t]*\[model\s/m.test(text) ? "text.ini" : "text.eds");
    for (let size = READ_MIN; size <= READ_MAX; size *= 4) {
      const memory = engine.place(size);
      engine.bytes(at, bytes.length).set(bytes);
      [[SOURCE.text, at], [SOURCE.n, bytes.length], [SOURCE.memory, memory], [SOURCE.size, size]].forEach(
        ([member, value]) => engine.view.setUint32(source + member, value, true));
      const device = this.c.web_device_read(source, name);
      const wrong = engine.text(source + SOURCE.wrong);
      if (wrong) {
        throw new Error(wrong);
      }
      if (device) {
        return device;
      }
    }
    throw new Error("too long for this page");
  }

  // The user's encoder, in the place of the one before: on the same shaft from now on.
  own(text) {
    const encoder = new Encoder(this, this.readModel(text), null);
    encoder.key = "own";
    this.couple(encoder);
    this.encoders = [...this.encoders.filter(({ key }) => key !== "own"), encoder];
    this.advance(0n);
    return encoder;
  }

  encoder(key) {
    return this.encoders.find((one) => one.key === key);
  }

  // Time goes on for everybody.
  advance(ns) {
    const end = this.now + ns;
    do {
      const next = this.now + STEP_NS < end ? this.now + STEP_NS : end;
      this.encoders.forEach((one) => one.run(next));
      this.now = next;
      this.encoders.forEach((one) => one.later());
    } while (this.now < end);
  }

  // ---------------------------------------------------------------- the shaft

  get angle() {
    return this.c.dg_host_angle(this.encoders[0].host, this.now);
  }

  // In rpm.
  get speed() {
    return this.c.dg_shaft_mrpm(this.shaft, this.now) / 1000;
  }

  // Be there at rest.
  place(angle) {
    this.c.dg_shaft_set_position(this.shaft, this.now, angle);
    this.advance(0n);
  }

  accelerate(rpmPerS) {
    const value = BigInt(Math.round(rpmPerS * 1000));
    this.engine.checked(this.c.dg_shaft_set_acceleration(this.shaft, value), "the acceleration");
  }

  turn(rpm) {
    this.engine.checked(this.c.dg_shaft_set_velocity(this.shaft, this.now, Math.round(rpm * 1000)), "the speed");
  }

  move(angle, rpm) {
    this.engine.checked(this.c.dg_shaft_move(this.shaft, this.now, angle, Math.round(rpm * 1000)), "the way");
  }

  // A line at the prompt: what is answered, and errors. SHAFt belongs to the first encoder, everything else to the one
  // that is asked.
  ask(encoder, line) {
    const session = /^\s*:?shaf/i.test(line) ? this.encoders[0] : encoder;
    const said = session.scpi(line);
    const errors = [];
    for (let error = session.scpi(ERROR); !/^[+]?0,/.test(error); error = session.scpi(ERROR)) {
      errors.push(error);
    }
    return { said: said ? [said] : [], errors };
  }
}
