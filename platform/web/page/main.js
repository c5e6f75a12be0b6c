// SPDX-License-Identifier: MIT
// The playground: the page with encoders that are calculated here, and time. `#still` in the address leaves the clock
// standing, and nothing is asked by itself; `drehgeber.rig` is there for who wants more than the page has.
import { BissMaster } from "./biss.js";
import { Engine } from "./engine.js";
import { MASTERS } from "./masters.js";
import { $, Page, degrees } from "./page.js";
import { MODELS, Rig } from "./rig.js";
import { Panel } from "./view.js";

const KEPT = "drehgeber.eeprom.";
// What a browser does not show it does not run either: no leap when it comes back.
const LEAP_MS = 100;
const PASS_NS = 20_000_000n;
const BUTTON_NS = 10_000_000n;

async function moduleBytes() {
  const inside = $("module");
  if (inside) {
    return Uint8Array.from(atob(inside.textContent.trim()), (character) => character.charCodeAt(0));
  }
  const response = await fetch("drehgeber.wasm");
  return response.arrayBuffer();
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
    super(new Rig(engine, images, (frame) => this.panelOf(frame.encoder)?.say(frame)));
    this.runs = location.hash !== "#still";
    this.tabs(this.rig.encoders.map((encoder) => this.panel(encoder)));
    this.time();
    if (!this.runs) {
      this.panels.forEach((panel) => {
        panel.asks = false;
        panel.repeat.checked = false;
      });
    }
    this.command("*IDN?");
    this.showRun();
    this.begin();
  }

  panel(encoder) {
    if (encoder.protocol === "biss") {
      encoder.master = new BissMaster(encoder);
    }
    const options = { keep: storage.put, master: MASTERS[encoder.protocol] };
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
    this.panels.forEach((panel) => {
      const late = panel.encoder.scpi("");
      if (late) {
        this.answer(late);
      }
    });
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
