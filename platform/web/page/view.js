// SPDX-License-Identifier: MIT
// An encoder's part of the page: what can be asked of it, what went over its wire, how it is, what can happen to it,
// and its EEPROM.
//
// An encoder is {key, model, rig, position, powered, state, faults(), fault(), scpi(), power()}, and what of {memory,
// erase(), refused} its kind has; rig.js has one that is calculated here, live.js one that runs elsewhere.
// What is shown of it is {title, name, figure, drawn, drawing, what}; of the first kind there is a master, of masters.js.
import { drawFrame, drawSamples, drawSinCos, glows } from "./figures.js";
import { button, form, hex, make } from "./parts.js";

const LINES = 300;
const NOTHING = "No error was told so far.";
const ASK_NS = 500_000_000n;
const LOOK_NS = 30_000_000n;

// What STATe? calls in one word, or counts in units that people do not.
const volts = (uv) => (uv === "-" ? uv : `${(Number(uv) / 1e6).toFixed(3)} V`);
const hexadecimals = (digits) => `${digits}h`;
const FACTS = {
  sin_plus_uv: ["sine +", volts],
  sin_minus_uv: ["sine −", volts],
  cos_plus_uv: ["cosine +", volts],
  cos_minus_uv: ["cosine −", volts],
  baud: ["baud rate", (baud) => `${baud} Bd`],
  address: ["address", hexadecimals],
  locks: ["locks", hexadecimals],
  last_command: ["last command", hexadecimals],
};

// What can be drawn of an encoder: the parts it is made of, and what is done with them for each picture of the screen.
const curves = (panel) => {
  panel.canvas.className = "sincos";
  return [panel.canvas, panel.caption];
};
const DRAWINGS = {
  samples: { parts: curves, draw: (panel) => { panel.caption.textContent = drawSamples(panel.canvas, panel.encoder.samples); } },
  sincos: { parts: curves, draw: (panel) => { panel.caption.textContent = drawSinCos(panel.canvas, panel.encoder); } },
  lines: {
    parts: ({ canvas, caption, extra }) => [canvas, caption, make("h3", {}, "CDM and CDS of the last register access"), extra],
    draw: (panel) => panel.drawLines(),
  },
  words: {
    parts: (panel) => {
      panel.extra = make("ol", { className: "bits", "aria-label": "Bits of IN" });
      return [panel.caption, panel.extra];
    },
    draw: (panel) => panel.drawWords(),
  },
  bits: {
    parts: (panel) => {
      panel.extra = make("ol", { className: "bits", "aria-label": "Bits of the frame" });
      return [panel.caption, panel.extra];
    },
    draw: (panel) => panel.drawBits(),
  },
};

export class Panel {
  // `guard` runs what may throw, and says so; `about` is what is shown of it, `keep` is told of a changed EEPROM, `master`
  // is of masters.js or none.
  constructor(encoder, guard, { about, keep, master }) {
    this.encoder = encoder;
    this.master = master;
    this.rig = encoder.rig;
    this.guard = guard;
    this.keep = keep;
    this.about = about;
    this.asks = true;
    this.nextAsk = 0n;
    this.nextLine = 0n;
    this.plan = [];
    this.image = null;
    this.key = encoder.key;
    this.build();
  }

  build() {
    const { about, key, encoder } = this;
    this.value = make("b", {}, "–");
    this.tab = make("button", { type: "button", id: `tab-${key}`, role: "tab", "aria-controls": `panel-${key}` },
      `${about.title}`, make("small", {}, about.name), make("br"), this.value);
    this.lamps = make("ul", { className: "lamps", "aria-label": "Status LEDs" });
    this.log = make("ol", { className: "scroll log", tabIndex: 0, "aria-label": `Wire of ${about.title}` });
    const clear = button("Clear", () => this.log.replaceChildren());
    const wire = this.card("Wire", "span", "What master (▶) and encoder (◀) say to each other.", this.lamps, ...(this.master ? this.asking(clear) : [make("div", { className: "row" }, clear)]), this.log);
    this.facts = make("dl");
    this.place = make("span");
    const steer = (text, act) => Object.assign(button(text, act), { disabled: this.rig.watches === true });
    this.supply = steer("Off", () => this.guard(() => this.switch(!encoder.powered)));
    const state = this.card("Device", "", "What the encoder knows of itself at this moment.", this.facts,
      make("div", { className: "row" }, this.supply,
        steer("Power cycle", () => this.guard(() => { this.switch(false); this.switch(true); this.look(2); }))));
    const figure = about.drawing ? [this.card(about.figure, "", about.drawn, ...this.figure())] : [];
    this.list = make("ul", { className: "scroll faults", tabIndex: 0, "aria-label": "Catalogue of faults" });
    this.find = make("input", { type: "search", placeholder: "e.g. LED, 1Dh, eeprom", "aria-label": "Search the faults", oninput: () => this.filter() });
    this.latest = make("p", { className: "latest", role: "status" }, NOTHING);
    const faults = this.card("Faults", "", "Click what goes wrong; the encoder finds the error by itself, as a real one does.",
      make("div", { className: "row" }, make("span", { className: "grow" }, this.find),
        steer("Clear all", () => this.guard(() => { encoder.scpi("FAUL:CLE"); this.latest.textContent = NOTHING; this.showFaults(); this.look(); }))),
      this.latest, this.list);
    const memory = this.memoryCard();
    this.node = make("div", { id: `panel-${key}`, role: "tabpanel", "aria-labelledby": `tab-${key}`, hidden: true },
      ...(this.master ? [make("p", { className: "what" }, about.what)] : []),
      make("div", { className: "grid" }, wire, ...(figure.length > 0 ? [...figure, faults, memory, state] : [state, faults, memory])));
    this.listFaults();
    if (encoder.refused) {
      this.say({ at: this.rig.now, ours: true, bytes: [], words: encoder.refused });
    }
  }

  // What the master can be told.
  asking(clear) {
    const { encoder, master } = this;
    const act = (run) => (...values) => this.guard(() => this.powered(() => run(...values)));
    this.repeat = make("input", { type: "checkbox", checked: true, onchange: () => { this.asks = this.repeat.checked; } });
    return [
      make("div", { className: "row" },
        ...master.buttons(encoder).map(([text, run]) => button(text, act(run))),
        make("label", {}, this.repeat, " keep asking"),
        clear),
      ...master.forms(encoder).map(([fields, text, run]) => form(fields, text, act(run)))];
  }

  memoryCard() {
    this.dump = make("pre", { className: "scroll hex", tabIndex: 0, "aria-label": "EEPROM" });
    this.size = make("span", { className: "soft" });
    const erase = button("As delivered", () => this.guard(() => { this.encoder.erase(); this.refresh(true); }));
    this.store = this.card("EEPROM", "", "What the encoder remembers without power. Bytes that changed are marked.", make("div", { className: "row" }, this.size, ...(this.encoder.erase ? [erase] : [])), this.dump);
    this.store.hidden = true; // until something is known of it
    return this.store;
  }

  card(title, kind, what, ...children) {
    return make("section", { className: `card ${kind}`, "aria-label": `${title} of ${this.about.title}` },
      make("h2", {}, title), make("p", { className: "hint" }, what), ...children);
  }

  figure() {
    this.canvas = make("canvas", { role: "img", "aria-label": this.about.figure });
    this.caption = make("p", { className: "soft" });
    this.extra = make("ol", { className: "control scroll", tabIndex: 0, "aria-label": "CDM and CDS of the last register access" });
    return DRAWINGS[this.about.drawing].parts(this);
  }

  // ---------------------------------------------------------------- what is done to it

  powered(run) {
    if (!this.encoder.powered) {
      throw new Error(`${this.about.title}: no power`);
    }
    run();
  }

  setFault(name, on) {
    try {
      this.encoder.fault(name, on);
      this.look();
    } finally {
      this.showFaults();
      this.refresh(true);
    }
  }

  switch(on) {
    this.encoder.power(on);
    this.rig.advance?.(0n);
    this.refresh(true);
  }

  // Ask what is wrong, when the encoder had the time to find it.
  look(seconds = 1) {
    if (!this.master) {
      return;
    }
    let due = this.rig.now + BigInt(seconds) * 1_000_000_000n;
    this.plan = this.master.look(this.encoder).map((run) => {
      due += LOOK_NS;
      return { due, run };
    });
  }

  // Called whenever time has gone on.
  tick(shown) {
    while (this.plan.length > 0 && this.rig.now >= this.plan[0].due) {
      const { run } = this.plan.shift();
      if (this.encoder.powered) {
        this.guard(run);
      }
    }
    if (shown && this.asks && this.encoder.powered && this.rig.now >= this.nextAsk) {
      const quiet = this.rig.now < this.nextLine;
      this.nextAsk = this.rig.now + (this.master.every ?? ASK_NS);
      this.nextLine = quiet ? this.nextLine : this.rig.now + ASK_NS;
      this.guard(() => this.master.ask(this.encoder, quiet));
    }
  }

  // ---------------------------------------------------------------- what is seen of it

  say({ at, ours, severity, bytes, words }) {
    const line = make("li", {},
      make("span", { className: "at mono" }, (Number(at) / 1e9).toFixed(6)),
      make("span", { className: ours ? "ours" : "", "aria-label": ours ? "encoder" : "master" }, ours ? "◀" : "▶"));
    if (bytes.length > 0) {
      line.append(make("span", { className: "bytes mono" }, hex(bytes)));
    }
    line.append(make("span", { className: `words ${severity}${bytes.length > 0 ? "" : " note"}` }, words));
    if (severity === "error" && ours) {
      this.latest.textContent = `Told last: ${words}`;
    }
    const atEnd = this.log.scrollHeight - this.log.scrollTop - this.log.clientHeight < 40;
    this.log.append(line);
    if (this.log.childElementCount > LINES) {
      this.log.firstElementChild.remove();
    }
    if (atEnd || this.log.clientHeight === 0) {
      this.log.scrollTop = this.log.scrollHeight;
    }
  }

  listFaults() {
    this.faults = new Map();
    this.list.replaceChildren();
    for (const fault of this.encoder.faults()) {
      const box = make("input", { type: "checkbox", id: `${this.key}-${fault.name}`, disabled: this.rig.watches === true });
      box.addEventListener("change", () => this.guard(() => this.setFault(fault.name, box.checked)));
      const row = make("li", {}, make("label", {}, box, make("b", {}, fault.name), make("span", {}, fault.cause), make("span", {}, `→ ${fault.effect}`)));
      this.faults.set(fault.name, { box, row, words: row.textContent.toLowerCase() });
      this.list.append(row);
    }
    this.showFaults();
    this.filter();
  }

  // Elsewhere they come later, and others set them, too.
  followFaults() {
    if (this.encoder.faults().length !== this.faults.size) {
      this.listFaults();
    } else if (!this.master) {
      this.showFaults();
    }
  }

  filter() {
    const wanted = this.find.value.toLowerCase();
    this.faults.forEach(({ row, words }) => { row.hidden = !words.includes(wanted); });
  }

  showFaults() {
    for (const { name, active } of this.encoder.faults()) {
      const { box, row } = this.faults.get(name);
      box.checked = active;
      row.classList.toggle("active", active);
    }
  }

  // What changes with every frame of the screen.
  draw(shown) {
    const { position } = this.encoder;
    this.value.textContent = position === null ? "off" : String(position);
    this.place.textContent = this.value.textContent;
    if (!shown) {
      return;
    }
    this.drawLamps();
    DRAWINGS[this.about.drawing]?.draw(this);
  }

  drawLamps() {
    (this.named ?? []).forEach(([name, pattern], i) => {
      this.lamps.children[i]?.classList.toggle("on", glows(name, pattern, this.rig.now));
    });
  }

  drawLines() {
    const { last, control } = this.encoder.master;
    if (this.drawn === last && this.drawnWidth === this.canvas.clientWidth) {
      return;
    }
    drawFrame(this.canvas, last);
    this.drawn = last;
    this.drawnWidth = this.canvas.clientWidth;
    this.caption.textContent = last === null ? "" : `CDS ${last.cds}, CDM ${last.cdm}: one bit of control each way in a frame`;
    if (this.drawnControl !== control) {
      this.drawnControl = control;
      this.extra.replaceChildren(...control.map(({ name, cdm, cds }) => make("li", {},
        make("i", {}, name),
        make("span", { className: cdm ? "one" : "" }, String(cdm)), make("br"),
        make("span", { className: cds ? "one" : "" }, String(cds)))));
    }
  }

  drawWords() {
    const bytes = this.encoder.lastIn;
    if (bytes === this.drawn || !bytes) {
      return;
    }
    this.drawn = bytes;
    this.listBits([...bytes].map((byte) => byte.toString(2).padStart(8, "0")).join(""), `IN ${hex(bytes)}`);
  }

  drawBits() {
    const bits = this.encoder.lastBits;
    if (bits !== this.drawn && bits) {
      this.drawn = bits;
      this.listBits(bits, `${bits.length} bits`);
    }
  }

  listBits(bits, caption) {
    this.caption.textContent = caption;
    this.extra.replaceChildren(...[...bits].map((bit, i) =>
      make("li", { className: bit === "1" ? "one" : "", title: `bit ${bits.length - 1 - i}` }, bit)));
  }

  // What is looked at some times in a second.
  refresh(shown) {
    const { encoder } = this;
    const { memory } = encoder;
    if (memory && (this.image === null || memory.some((byte, i) => byte !== this.image[i]))) {
      this.showMemory(memory);
      this.keep?.(encoder.model, memory);
    }
    if (shown) {
      this.showState(encoder.state);
      this.followFaults();
    }
  }

  showState(state) {
    const { power, mode, position, leds, errors, ...others } = state;
    this.supply.textContent = power === "1" ? "Switch off" : "Switch on";
    const lamps = leds === "-" ? [] : leds.split("/").map((word) => word.split(":"));
    const named = [["power", power === "1" ? "on" : "off"], ...lamps];
    if ("nerr" in others) {
      named.push(["nERR low", power === "1" && others.nerr === "0" ? "on" : "off"], ["nWARN low", power === "1" && others.nwarn === "0" ? "on" : "off"]);
    }
    this.named = named;
    const words = named.map(([name, pattern]) => `${name} ${pattern}`).join();
    if (words !== this.lampWords) {
      this.lampWords = words;
      this.lamps.replaceChildren(...named.map(([name, pattern]) =>
        make("li", { className: `lamp ${/err|RD|low/.test(name) ? "red" : ""}`, "aria-label": `${name}: ${pattern}` }, `${name}${/on|off/.test(pattern) ? "" : ` (${pattern})`}`)));
      this.drawLamps();
    }
    if (!this.master && errors !== this.errors) {
      this.errors = errors;
      this.latest.textContent = errors === "-" ? this.latest.textContent : `Told last: ${errors}`;
    }
    const rows = Object.entries({ wire: this.encoder.wire, mode, errors, position: this.place, ...others }).filter(([, value]) => value !== undefined);
    this.fill(this.facts, rows);
  }

  fill(list, rows) {
    const words = JSON.stringify(rows);
    if (list.words !== words) {
      list.words = words;
      list.replaceChildren(...rows.map(([name, value]) => {
        const [words, shown] = FACTS[name] ?? [name.replaceAll("_", " "), (text) => text];
        return make("div", {}, make("dt", {}, words),
          make("dd", { className: name === "errors" && value !== "-" ? "error" : "" }, shown(value)));
      }));
    }
  }

  // Sixteen bytes a line, eight on a narrow screen; what has changed since the line before is marked.
  showMemory(memory) {
    const across = matchMedia("(max-width: 600px)").matches ? 8 : 16;
    const before = this.image;
    const lines = document.createDocumentFragment();
    for (let at = 0; at < memory.length; at += across) {
      const row = memory.subarray(at, at + across);
      lines.append(make("span", { className: "addr" }, at.toString(16).toUpperCase().padStart(4, "0")), " ");
      row.forEach((byte, i) => {
        const changed = before !== null && before[at + i] !== byte;
        lines.append(" ", changed ? make("mark", {}, hex([byte])) : hex([byte]));
      });
      const text = Array.from(row, (byte) => (byte >= 32 && byte < 127 ? String.fromCharCode(byte) : "·")).join("");
      lines.append(`${"   ".repeat(across - row.length)}  ${text}\n`);
    }
    this.dump.replaceChildren(lines);
    const mark = this.dump.querySelector("mark");
    if (mark) {
      this.dump.scrollTop = mark.offsetTop - this.dump.clientHeight / 2;
    }
    this.size.textContent = `${memory.length} bytes${this.keep ? ", kept in this browser" : ""}`;
    this.store.hidden = false;
    this.image = memory;
  }
}
