// SPDX-License-Identifier: MIT
// The playground: the page with encoders that are calculated here, and time. The address has a state, see link.js. With
// `still` the clock stands, and the masters ask nothing by themselves; the console of the browser has `drehgeber.rig`.
import { Engine } from "./engine.js";
import { readLink, writeLink } from "./link.js";
import { ENCODERS, PLAYGROUND, rowOf } from "./masters.js";
import { $, Page, angleOf } from "./page.js";
import { degrees } from "./parts.js";
import { Rig } from "./rig.js";
import { Panel } from "./view.js";

const MODELS = ENCODERS.map(({ model }) => model);
const KEPT = "drehgeber.eeprom.";
// What a browser does not show it does not run either: no leap when it comes back.
const LEAP_MS = 100;
const PASS_NS = 20_000_000n;
const BUTTON_NS = 10_000_000n;
const START_RPM = 10;
const TRY_RPM = 60;
const WORN = "led_current_high";

// A server may have unpacked it already.
async function unpack(bytes) {
  const [first] = new Uint8Array(bytes, 0, 1);
  const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return first === 0 ? bytes : new Response(unpacked).arrayBuffer();
}

async function moduleBytes() {
  const inside = $("module");
  if (inside) {
    return unpack(Uint8Array.from(atob(inside.textContent.trim()), (character) => character.charCodeAt(0)).buffer);
  }
  const response = await fetch("drehgeber.wasm.gz");
  return unpack(await response.arrayBuffer());
}

// Storage may be forbidden, or full: then nothing is kept.
const storage = {
  get(model) {
    try {
      const text = localStorage.getItem(KEPT + model);
      return text ? Uint8Array.from(atob(text), (character) => character.charCodeAt(0)) : null;
    } catch {
      return null;
    }
  },
  put(model, image) {
    try {
      localStorage.setItem(KEPT + model, btoa(String.fromCharCode(...image)));
    } catch {
      /* as said */
    }
  },
};

class Playground extends Page {
  constructor(engine, images) {
    super(new Rig(engine, PLAYGROUND, images, (frame) => this.panelOf(frame.encoder)?.say(frame)));
    this.link = {};
    this.guard(() => { this.link = readLink(location.hash); });
    this.runs = !this.link.still;
    document.body.classList.toggle("small", self !== top); // a part of another page
    this.tabs(this.rig.encoders.map((encoder) => this.panel(encoder)));
    this.time();
    this.tries();
    this.owns();
    this.linkPages();
    if (this.runs && !matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.rig.turn(START_RPM);
    }
    if (!this.runs) {
      this.panels.forEach((panel) => {
        panel.asks = false;
        panel.repeat.checked = false;
      });
    }
    this.command("*IDN?");
    this.showRun();
    this.links();
    this.begin();
  }

  panel(encoder) {
    const row = encoder.own ? rowOf(encoder, this.rig.encoders) : ENCODERS.find(({ model }) => model === encoder.model);
    encoder.master = row.master?.(encoder);
    const options = { keep: encoder.own ? undefined : storage.put, about: row, master: row };
    return new Panel(encoder, (run) => this.guard(run), options);
  }

  // The shaft follows the hand by its speed.
  get follows() {
    return this.runs;
  }

  frame(at) {
    const passed = Math.min(at - (this.lastFrame ?? at), LEAP_MS);
    if (this.runs) {
      this.guardLoop(() => {
        this.follow(passed);
        this.pass(BigInt(Math.round(passed * 1e6 * Number($("pace").value))));
      });
    }
    super.frame(at);
  }

  // Time goes on, in steps that are short for who asks again and again.
  pass(ns) {
    for (let left = ns; left > 0n; left -= PASS_NS) {
      this.rig.advance(left < PASS_NS ? left : PASS_NS);
      this.panels.forEach((panel) => panel.tick(panel === this.shown));
    }
  }

  refresh() {
    super.refresh();
    this.showTries();
    this.panels.forEach((panel) => {
      const late = panel.encoder.late;
      if (late) {
        this.answer(late);
      }
    });
  }

  // A text that the user has put in becomes encoders; those before go, unless the text is wrong.
  owns() {
    $("own").addEventListener("submit", (event) => {
      event.preventDefault();
      this.guard(() => this.own($("own-text").value));
    });
  }

  own(text) {
    $("own-wrong").hidden = true;
    let encoders;
    try {
      encoders = this.rig.own(text);
    } catch (error) {
      $("own-wrong").textContent = error.message;
      $("own-wrong").hidden = false;
      return;
    }
    this.panels.filter(({ encoder }) => encoder.own).forEach((panel) => this.removeTab(panel));
    const panels = encoders.map((encoder) => this.panel(encoder));
    panels.forEach((panel) => {
      panel.asks = this.runs;
      panel.repeat.checked = this.runs;
      this.addTab(panel);
    });
    this.show(panels[0]);
  }

  // The site has the pages above the page's folder, the tree above the build's. Elsewhere there are none.
  linkPages() {
    $("pages").href = location.protocol === "file:" ? "../../../README.md" : "../index.html";
    $("pages").hidden = !location.pathname.includes("/playground/");
  }

  // ---------------------------------------------------------------- the address

  links() {
    if (this.link.model || this.link.shaft || this.link.fault || "power" in this.link) {
      this.guard(() => this.followLink(this.link));
    }
    addEventListener("hashchange", () => this.guard(() => this.followLink(readLink(location.hash))));
    $("link").addEventListener("click", () => this.copyLink());
  }

  // What a link does not name becomes as it was at the start, so that a link means the same everywhere.
  followLink({ model = MODELS[0], shaft, fault = [], power = true }) {
    const panel = this.panels.find(({ encoder }) => encoder.model === model);
    if (!panel) {
      throw new Error(`model=${model}: expected ${MODELS.join(", ")}`);
    }
    const unknown = fault.find((name) => !panel.faults.has(name));
    if (unknown !== undefined) {
      throw new Error(`fault=${unknown}: ${model} has no such fault; the list of faults has the names`);
    }
    this.panels.forEach(({ encoder }) => encoder.scpi("FAUL:CLE"));
    this.show(panel);
    this.turnTo(shaft);
    fault.forEach((name) => panel.setFault(name, true));
    if (panel.encoder.powered !== power) {
      panel.switch(power);
    }
  }

  turnTo(shaft) {
    this.rig.accelerate(0);
    if (shaft) {
      this.rig.turn(shaft.rpm ?? 0);
    }
    if (shaft?.degrees !== undefined) {
      this.rig.place(angleOf(shaft.degrees));
    }
  }

  // A browser may forbid the clipboard; the address bar has the link in any case.
  async copyLink() {
    const { encoder } = this.shown;
    history.replaceState(null, "", writeLink({
      model: encoder.model,
      rpm: this.rig.speed,
      degrees: degrees(this.rig.angle),
      faults: encoder.faults().filter(({ active }) => active).map(({ name }) => name),
      powered: encoder.powered,
      still: !this.runs,
    }));
    const copied = await navigator.clipboard?.writeText(location.href).then(() => true, () => false);
    $("tried").textContent = `The link to this state is ${copied ? "on the clipboard and " : ""}in the address bar: encoder, shaft and faults.`;
  }

  // ---------------------------------------------------------------- the three steps

  tries() {
    const on = (id, act) => $(id).addEventListener("click", () => this.guard(() => {
      $("tried").textContent = act(this.shown);
      this.showTries();
    }));
    on("try-turn", () => {
      this.rig.accelerate(0);
      this.rig.turn(this.rig.speed === TRY_RPM ? -TRY_RPM : TRY_RPM);
      return `The shaft turns at ${TRY_RPM} rpm, and all four positions count. Press again to turn it the other way.`;
    });
    on("try-led", () => this.wear());
    on("try-power", (panel) => {
      panel.switch(!panel.encoder.powered);
      return panel.encoder.powered
        ? `${panel.about.title} has power again and knows the angle without a reference run: that is what "absolute" means.`
        : `${panel.about.title} has no power and does not answer. The shaft still turns. Press again to switch it on.`;
    });
  }

  // INTERBUS has no such fault: the first encoder is shown instead.
  wear() {
    if (!this.shown.faults.has(WORN)) {
      this.show(this.panels[0]);
    }
    const panel = this.shown;
    const worn = !this.isWorn(panel);
    panel.setFault(WORN, worn);
    return worn
      ? `The light source of ${panel.about.title} is worn out. In a second its master asks what is wrong: see Wire and Faults.`
      : `${panel.about.title} has a new light source. Its error memory may still hold the old error.`;
  }

  isWorn(panel) {
    return panel.encoder.faults().some(({ name, active }) => name === WORN && active);
  }

  showTries() {
    $("try-led").setAttribute("aria-pressed", String(this.isWorn(this.shown)));
    $("try-power").setAttribute("aria-pressed", String(!this.shown.encoder.powered));
  }

  time() {
    $("run").addEventListener("click", () => {
      this.runs = !this.runs;
      this.showRun();
    });
    $("step").addEventListener("click", () => this.pass(BUTTON_NS));
  }

  showRun() {
    $("run").setAttribute("aria-pressed", String(this.runs));
    $("run").textContent = this.runs ? "Running" : "Standing";
  }

  // The hand on the shaft: it goes where the hand is, without leaps.
  follow(passedMs) {
    if (this.drag && passedMs > 0) {
      const missing = this.drag.want - degrees(this.rig.angle);
      const seconds = (Math.max(passedMs, 16) * 2) / 1000 * Number($("pace").value);
      this.rig.turn(Math.max(-12000, Math.min(12000, missing / 6 / seconds)));
    }
  }
}

const engine = await Engine.load(await moduleBytes());
const images = Object.fromEntries(MODELS.map((model) => [model, storage.get(model)]));
globalThis.drehgeber = new Playground(engine, images);
