// SPDX-License-Identifier: MIT
// The page: time, shaft, prompt and four encoders. `#still` in the address leaves the clock standing, and nothing is
// asked by itself; `drehgeber.rig` is there for who wants more than the page has.
import { Engine } from "./engine.js";
import { MODELS, Rig, TURN } from "./rig.js";
import { make, Panel } from "./view.js";

const KEPT = "drehgeber.eeprom.";
const REFRESH_MS = 200;
// What a browser does not show it does not run either: no leap when it comes back.
const LEAP_MS = 100;
const PASS_NS = 20_000_000n;
const BUTTON_NS = 10_000_000n;
const ERROR = "SYST:ERR?";

const $ = (id) => document.getElementById(id);
const degrees = (angle) => (Number(BigInt.asIntN(64, angle)) * 360) / Number(TURN);
const angleOf = (value) => BigInt(Math.round((value / 360) * Number(TURN)));

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

class Page {
  constructor(engine, images) {
    this.rig = new Rig(engine, images, (frame) => this.panelOf(frame.encoder)?.say(frame));
    this.panels = this.rig.encoders.map((encoder) => new Panel(encoder, (run) => this.guard(run), storage.put));
    this.runs = location.hash !== "#still";
    this.history = [];
    this.lastFrame = null;
    this.lastRefresh = 0;
    this.drag = null;
    this.ticks();
    this.tabs();
    this.time();
    this.shaft();
    this.prompt();
    if (!this.runs) {
      this.panels.forEach((panel) => {
        panel.asks = false;
        panel.repeat.checked = false;
      });
    }
    this.command("*IDN?");
    this.showRun();
    requestAnimationFrame((at) => this.frame(at));
  }

  panelOf(encoder) {
    return this.panels?.find((panel) => panel.encoder === encoder);
  }

  guard(run) {
    try {
      run();
      $("trouble").hidden = true;
    } catch (error) {
      $("trouble").textContent = error.message;
      $("trouble").hidden = false;
    }
  }

  // ---------------------------------------------------------------- time

  frame(at) {
    const passed = Math.min(at - (this.lastFrame ?? at), LEAP_MS);
    this.lastFrame = at;
    this.guardLoop(() => {
      if (this.runs) {
        this.follow(passed);
        this.pass(BigInt(Math.round(passed * 1e6 * Number($("pace").value))));
      }
      this.draw();
      if (at - this.lastRefresh > REFRESH_MS) {
        this.lastRefresh = at;
        this.refresh();
      }
    });
    requestAnimationFrame((next) => this.frame(next));
  }

  guardLoop(run) {
    try {
      run();
    } catch (error) {
      this.guard(() => {
        throw error;
      });
    }
  }

  // Time goes on, in steps that are short for who asks again and again.
  pass(ns) {
    for (let left = ns; left > 0n; left -= PASS_NS) {
      this.rig.advance(left < PASS_NS ? left : PASS_NS);
      this.panels.forEach((panel) => panel.tick(panel === this.shown));
    }
  }

  draw() {
    const { rig } = this;
    const now = degrees(rig.angle);
    const within = ((now % 360) + 360) % 360;
    $("rotor").setAttribute("transform", `rotate(${within})`);
    $("dial").setAttribute("aria-valuenow", within.toFixed(1));
    $("angle").textContent = `${now.toFixed(3)}°`;
    $("speed").textContent = `${rig.speed.toFixed(1)} rpm`;
    $("time").textContent = `${(Number(rig.now) / 1e9).toFixed(3)} s`;
    this.panels.forEach((panel) => panel.draw(panel === this.shown));
  }

  refresh() {
    this.panels.forEach((panel) => panel.refresh(panel === this.shown));
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

  // ---------------------------------------------------------------- tabs

  tabs() {
    this.panels.forEach((panel, i) => {
      $("tabs").append(panel.tab);
      $("panels").append(panel.node);
      panel.tab.addEventListener("click", () => this.show(panel));
      panel.tab.addEventListener("keydown", (event) => {
        const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
        if (step) {
          const next = this.panels.at((i + step) % this.panels.length);
          this.show(next);
          next.tab.focus();
        }
      });
    });
    this.show(this.panels[0]);
  }

  show(shown) {
    this.shown = shown;
    for (const panel of this.panels) {
      panel.tab.setAttribute("aria-selected", String(panel === shown));
      panel.tab.tabIndex = panel === shown ? 0 : -1;
      panel.node.hidden = panel !== shown;
    }
    $("asked").textContent = shown.about.title;
    shown.log.scrollTop = shown.log.scrollHeight;
    this.guardLoop(() => {
      shown.refresh(true);
      shown.draw(true);
    });
  }

  // ---------------------------------------------------------------- shaft

  ticks() {
    for (let i = 0; i < 36; i++) {
      const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
      line.setAttribute("transform", `rotate(${i * 10})`);
      line.setAttribute("y1", i % 9 === 0 ? "-74" : "-80");
      line.setAttribute("y2", "-88");
      $("ticks").append(line);
    }
  }

  shaft() {
    const value = (id) => {
      const { valueAsNumber } = $(id);
      if (Number.isNaN(valueAsNumber)) {
        throw new Error(`${id} is a number`);
      }
      return valueAsNumber;
    };
    const on = (id, event, act) =>
      $(id).addEventListener(event, (happened) => {
        happened.preventDefault();
        this.guard(() => act(happened));
      });
    on("turning", "submit", () => {
      this.rig.accelerate(value("ramp"));
      this.rig.turn(value("rpm"));
    });
    on("stop", "click", () => this.rig.turn(0));
    on("going", "submit", () => {
      this.rig.accelerate(value("ramp"));
      this.rig.move(angleOf(value("target")), Math.abs(value("rpm")) || 60);
    });
    on("be", "click", () => this.rig.place(angleOf(value("target"))));
    on("dial", "pointerdown", (event) => {
      $("dial").setPointerCapture(event.pointerId);
      $("dial").focus();
      this.rig.accelerate(0);
      this.drag = { at: this.bearing(event), want: degrees(this.rig.angle) };
    });
    on("dial", "pointermove", (event) => this.drag && this.pull(event));
    ["pointerup", "pointercancel"].forEach((name) => on("dial", name, () => this.release()));
    $("dial").addEventListener("keydown", (event) => this.guard(() => this.key(event)));
  }

  bearing(event) {
    const { left, top, width, height } = $("dial").getBoundingClientRect();
    return (Math.atan2(event.clientY - top - height / 2, event.clientX - left - width / 2) * 180) / Math.PI;
  }

  pull(event) {
    const bearing = this.bearing(event);
    const turned = ((bearing - this.drag.at + 540) % 360) - 180;
    this.drag.at = bearing;
    this.drag.want += turned;
    if (!this.runs) {
      this.rig.place(angleOf(this.drag.want));
    }
  }

  // The hand on the shaft: it goes where the hand is, without leaps.
  follow(passedMs) {
    if (this.drag && passedMs > 0) {
      const missing = this.drag.want - degrees(this.rig.angle);
      const seconds = (Math.max(passedMs, 16) * 2) / 1000 * Number($("pace").value);
      this.rig.turn(Math.max(-12000, Math.min(12000, missing / 6 / seconds)));
    }
  }

  release() {
    if (this.drag && this.runs) {
      this.rig.turn(0);
    }
    this.drag = null;
  }

  key(event) {
    const by = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (by === undefined && event.key !== "Home") {
      return;
    }
    event.preventDefault();
    this.rig.place(event.key === "Home" ? 0n : angleOf(degrees(this.rig.angle) + by));
  }

  // ---------------------------------------------------------------- SCPI

  prompt() {
    $("prompt").addEventListener("submit", (event) => {
      event.preventDefault();
      const line = $("line").value.trim();
      if (line !== "") {
        this.guard(() => this.command(line));
        this.history.push(line);
        this.back = this.history.length;
        $("line").value = "";
      }
    });
    $("line").addEventListener("keydown", (event) => {
      const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
      if (step && this.history.length > 0) {
        event.preventDefault();
        this.back = Math.max(0, Math.min(this.history.length, (this.back ?? 0) + step));
        $("line").value = this.history[this.back] ?? "";
      }
    });
  }

  command(line) {
    const session = this.rig.session(this.shown.encoder, line);
    this.answer(`${this.shown.about.title}> ${line}`, "command");
    const said = session.scpi(line);
    if (said) {
      this.answer(said);
    }
    for (let error = session.scpi(ERROR); !/^[+]?0,/.test(error); error = session.scpi(ERROR)) {
      this.answer(error, "error");
    }
    this.shown.showFaults();
    this.shown.refresh(true);
  }

  answer(text, kind = "") {
    $("said").append(make("div", { className: kind }, text));
    $("said").scrollTop = $("said").scrollHeight;
  }
}

const engine = await Engine.load(await moduleBytes());
const images = Object.fromEntries(MODELS.map((model) => [model, storage.get(model)]));
globalThis.drehgeber = new Page(engine, images);
