// SPDX-License-Identifier: MIT
// A rig that runs elsewhere, over WebSockets: lines of SCPI go there, lines of answers come back. What is known of it is
// what was answered last; the shaft turns on between answers as it was told to turn.
import { SINCOS } from "./figures.js";
import { TURN, catalogueOf, degrees, stateOf, unhex, unitsOf } from "./parts.js";

const ROUND_MS = 200;
const RETRY_MS = 1000;
const SILENT_MS = 3000;
const SAMPLES_MAX = 150;
const OTHERS = 8;
const MEMORY_MS = 1000;
const CLOSED = { token: 4001 };
// Two answers that stand before everything else, so that what a line of somebody else answers is not taken for them.
const FIRST = "SYST:VERS?;VERS?;";
const MARK = "1999.0;1999.0;";

// A connection. Answers come in the order of the questions.
class Line {
  constructor(token, told) {
    this.waiting = [];
    this.ready = false;
    this.socket = new WebSocket(`ws://${location.host}/rig`, "drehgeber");
    this.socket.onopen = () => this.socket.send(`SYST:TOK "${token}"`);
    this.socket.onmessage = ({ data }) => this.take(data, told);
    this.socket.onclose = ({ code, reason }) => this.end(code, reason, told);
  }

  take(text, told) {
    if (!this.ready) {
      this.ready = true;
      told.ready(text === "ready watch");
      return;
    }
    const question = this.waiting[0];
    question?.lines.push(text);
    if (text.startsWith(MARK)) {
      this.waiting.shift()?.resolve(question.lines);
    }
  }

  end(code, reason, told) {
    this.ready = false;
    this.waiting.splice(0).forEach(({ reject }) => reject(new Error("the connection broke")));
    told.closed(code, reason);
  }

  // Lines of which only the last begins with the mark. @return all that is answered, that with the mark last
  ask(...lines) {
    // A connection that goes is told of only after it is closed.
    if (!this.ready || this.socket.readyState !== WebSocket.OPEN) {
      return Promise.reject(new Error("no connection: not sent"));
    }
    return new Promise((resolve, reject) => {
      this.waiting.push({ lines: [], resolve, reject });
      lines.forEach((line) => this.socket.send(line));
    });
  }

  // A line of queries. @return its units
  async query(queries) {
    const [line] = await this.ask(`${FIRST}:${queries}`);
    return unitsOf(line).slice(2);
  }

  // @return {said, errors}
  async command(...lines) {
    const said = await this.ask(...lines, `${FIRST}:SYST:ERR:ALL?`);
    const [list] = unitsOf(said.pop()).slice(2);
    const errors = [];
    for (let i = 0; i + 1 < list.length; i += 2) {
      if (Number(list[i]) !== 0) {
        errors.push(`${list[i]},"${list[i + 1]}"`);
      }
    }
    return { said, errors };
  }
}

class LiveEncoder {
  constructor(rig, name, [[model], [wire], [shaft], state]) {
    Object.assign(this, { rig, key: name, model, wire, shaft, catalogue: [], samples: [], told: 0, memory: null, read: -Infinity });
    this.take(state);
    this.about = { title: name, name: model, ...("sin_plus_uv" in this.state ? { ...SINCOS, drawing: "samples" } : {}) };
    this.last = null;
  }

  take(state) {
    this.state = stateOf(state);
    const { sin_plus_uv: sin, sin_minus_uv: sinLow, cos_plus_uv: cos, cos_minus_uv: cosLow } = this.state;
    if (!this.powered) {
      this.samples = [];
    } else if (sin !== undefined) {
      this.samples = [...this.samples, [(sin - sinLow) / 1e6, (cos - cosLow) / 1e6]].slice(-SAMPLES_MAX);
    }
  }

  get powered() {
    return this.state.power === "1";
  }

  get position() {
    return this.powered ? this.state.position : null;
  }

  faults() {
    return this.catalogue;
  }

  // Names of those at work.
  takeActive(names) {
    this.catalogue.forEach((fault) => {
      fault.active = names.includes(fault.name);
    });
  }

  fault(name, on) {
    this.catalogue.find((one) => one.name === name).active = on;
    this.scpi(`FAUL:${on ? "SET" : "CLE"} ${name}`);
  }

  scpi(line) {
    this.told++;
    this.rig.tell(this, line);
  }

  power(on) {
    this.scpi(on ? "POW ON" : "POW OFF");
  }

  // Lines of the wire with their severities, of which those before `last` are known. @return those that are new
  takeFrames(lines, severities) {
    const known = lines.lastIndexOf(this.last);
    const lost = known < 0 && this.last !== null && lines.length > 0;
    const told = lines.map((line, i) => ({ line, severity: (severities[i] ?? "ok").toLowerCase() }));
    const fresh = told.slice(known + 1).filter(({ line }) => line !== "");
    this.last = fresh.at(-1)?.line ?? this.last;
    return fresh.map(({ line, severity }) => {
      const [, seconds, way, words] = /^(\S+) ([<>]) (.*)$/s.exec(line) ?? [null, "0", ">", line];
      return { at: BigInt(Math.round(Number(seconds) * 1e9)), ours: way === ">", severity, bytes: [], words };
    }).map((line, i) => (lost && i === 0 ? { ...line, words: `… ${line.words}` } : line));
  }
}

export class LiveRig {
  // `page` is told: found() when there are other encoders than before, heard() of a
  // frame, trouble() of no answers and well() of answers, refused() of an error, locked() of a wrong token.
  constructor(token, page) {
    this.token = token;
    this.page = page;
    this.encoders = [];
    this.shown = null;
    this.seconds = 0;
    this.pace = 0;
    this.heard = performance.now();
    this.turned = { degrees: 0, rpm: 0 };
    this.held = 0;
    this.connect();
  }

  connect() {
    this.line = new Line(this.token, {
      ready: (watches) => {
        this.watches = watches;
        this.run(this.line).catch((error) => this.page.trouble(error.message));
      },
      closed: (code, reason) => this.retry(code, reason),
    });
    this.prompt = null;
  }

  retry(code, reason) {
    this.prompt?.socket.close();
    if (code === CLOSED.token) {
      this.page.locked();
      return;
    }
    this.page.trouble(`no connection, trying again: ${reason || "drehgeber web does not answer"}`);
    setTimeout(() => this.connect(), RETRY_MS);
  }

  // As long as this line lives.
  async run(line) {
    await this.survey(line);
    this.page.well();
    while (line.ready) {
      const late = setTimeout(() => this.page.trouble("the rig does not answer"), SILENT_MS);
      try {
        await this.round(line);
      } finally {
        clearTimeout(late);
      }
      this.page.well();
      await new Promise((resolve) => setTimeout(resolve, ROUND_MS));
    }
  }

  async survey(line) {
    const [names] = await line.query("INST:CAT?");
    const found = [];
    for (const name of names) {
      found.push(new LiveEncoder(this, name, await line.query(`INST:SEL "${name}";MOD?;WIRE?;:SHAF:NAME?;:STAT?`)));
    }
    const same = (one, i) => one.model === this.encoders[i]?.model && one.key === this.encoders[i].key;
    if (found.length !== this.encoders.length || !found.every(same)) {
      this.encoders = found;
      this.page.found();
    }
    this.encoders.forEach((encoder, i) => Object.assign(encoder, { last: null, shaft: found[i].shaft }));
  }

  async round(line) {
    const { shown } = this;
    const held = this.held;
    const select = `INST:SEL "${shown.key}";:`;
    const [[angle], [rpm], [seconds]] = await line.query(`${select}SHAF:POS?;VEL?;:TIME?`);
    if (held === this.held && shown === this.shown) {
      this.takeShaft(Number(angle), Number(rpm), Number(seconds));
    }
    const { told } = shown;
    const [state, active] = await line.query(`${select}STAT?;:FAUL:ACT?`);
    shown.take(state);
    if (shown.catalogue.length === 0) {
      shown.catalogue = catalogueOf((await line.query(`${select}FAUL:CAT?`))[0]);
    }
    if (told === shown.told) {
      shown.takeActive(active);
    }
    const [frames, severities] = await line.query(`${select}TRAC:LAST? 32;LAST:SEV? 32`);
    shown.takeFrames(frames ?? [], severities ?? []).forEach((frame) => this.page.heard({ encoder: shown, ...frame }));
    await this.look(line, shown, select);
    await line.command(); // what was refused of this is no error of anybody's
    await this.others(line);
  }

  // The EEPROM, if it has one.
  async look(line, shown, select) {
    if (performance.now() - shown.read > MEMORY_MS) {
      const [data] = await line.query(`${select}NVM:DATA?`);
      shown.memory = data ? unhex(data[0]) : null;
      shown.read = data ? performance.now() : Infinity;
    }
  }

  // Some of those that are not shown, in turn.
  async others(line) {
    for (let n = 0; n < Math.min(OTHERS, this.encoders.length - 1); n++) {
      this.next = ((this.next ?? 0) + 1) % this.encoders.length;
      const encoder = this.encoders[this.next];
      if (encoder !== this.shown) {
        encoder.take((await line.query(`INST:SEL "${encoder.key}";:STAT?`))[0]);
      }
    }
  }

  takeShaft(angle, rpm, seconds) {
    const now = performance.now();
    const passed = (now - this.heard) / 1000;
    this.pace = passed > 0 ? Math.max(0, (seconds - this.seconds) / passed) : 0;
    this.pace = this.pace > 0.8 && this.pace < 1.25 ? 1 : this.pace; // answers do not come as evenly as they are asked for
    Object.assign(this, { heard: now, seconds, turned: { degrees: angle, rpm } });
  }

  show(encoder) {
    this.shown = encoder;
  }

  // ---------------------------------------------------------------- the shaft of the encoder that is shown

  get passed() {
    return (Math.min(performance.now() - this.heard, SILENT_MS) / 1000) * this.pace;
  }

  get now() {
    return BigInt(Math.round((this.seconds + this.passed) * 1e9));
  }

  get angle() {
    const { degrees, rpm } = this.turned;
    return BigInt(Math.round(((degrees + rpm * 6 * this.passed) / 360) * Number(TURN)));
  }

  get speed() {
    return this.turned.rpm;
  }

  // The hand is faster than the answers: of what it wants meanwhile the last counts.
  place(angle) {
    if (this.watches) {
      return;
    }
    const wanted = degrees(angle);
    Object.assign(this, { heard: performance.now(), turned: { degrees: wanted, rpm: 0 }, wanted });
    this.held++;
    if (!this.placing) {
      this.placing = this.follow().finally(() => {
        this.placing = null;
      });
    }
  }

  async follow() {
    while (this.wanted !== null) {
      const { wanted } = this;
      this.wanted = null;
      await this.tell(this.shown, `SHAF:POS ${wanted.toFixed(6)} DEG`);
    }
    this.held++;
  }

  accelerate(rpmPerS) {
    this.tell(this.shown, `SHAF:ACC ${rpmPerS} RPM/S`);
  }

  turn(rpm) {
    this.tell(this.shown, rpm === 0 ? "SHAF:STOP" : `SHAF:VEL ${rpm} RPM`);
  }

  move(angle, rpm) {
    this.tell(this.shown, `SHAF:MOVE ${degrees(angle).toFixed(6)} DEG,${rpm} RPM`);
  }

  // ---------------------------------------------------------------- SCPI

  // A command of the page's own; what is wrong with it is told.
  async tell(encoder, line) {
    if (this.watches) {
      return;
    }
    try {
      const { errors } = await this.line.command(`INST:SEL "${encoder.key}";:${line}`);
      if (errors.length > 0) {
        this.page.refused(errors.join(", "));
      }
    } catch (error) {
      this.page.refused(error.message);
    }
  }

  // A line at the prompt has a connection of its own: it may wait for a motion.
  async ask(encoder, line) {
    this.prompt ??= await this.open();
    return this.prompt.command(`INST:SEL "${encoder.key}"`, line);
  }

  open() {
    return new Promise((resolve, reject) => {
      const line = new Line(this.token, {
        ready: () => resolve(line),
        closed: (code, reason) => {
          this.prompt = this.prompt === line ? null : this.prompt;
          reject(new Error(reason || "no connection"));
        },
      });
    });
  }
}
