// SPDX-License-Identifier: MIT
// What the playground and the panel of a running rig share: shaft, prompt, and a part for each encoder. A rig is
// {angle, speed, now, place(), turn(), accelerate(), move(), ask()}, and show() when only one encoder is followed.
import { TURN, degrees, make } from "./parts.js";

const REFRESH_MS = 200;

export const $ = (id) => document.getElementById(id);
export const angleOf = (value) => BigInt(Math.round((value / 360) * Number(TURN)));

export class Page {
  constructor(rig) {
    this.rig = rig;
    this.panels = [];
    this.history = [];
    this.lastFrame = null;
    this.lastRefresh = 0;
    this.drag = null;
    this.ticks();
    this.shaft();
    this.prompt();
  }

  begin() {
    requestAnimationFrame((at) => this.frame(at));
  }

  panelOf(encoder) {
    return this.panels.find((panel) => panel.encoder === encoder);
  }

  guard(run) {
    try {
      run();
      $("trouble").hidden = true;
    } catch (error) {
      this.complain(error);
    }
  }

  complain(error) {
    $("trouble").textContent = error.message;
    $("trouble").hidden = false;
  }

  // ---------------------------------------------------------------- time

  frame(at) {
    this.lastFrame = at;
    this.guardLoop(() => {
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
      this.complain(error);
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
  }

  // ---------------------------------------------------------------- tabs

  tabs(panels) {
    $("tabs").replaceChildren();
    $("panels").replaceChildren();
    panels.forEach((panel) => this.addTab(panel));
    this.show(panels[0]);
  }

  addTab(panel) {
    this.panels.push(panel);
    $("tabs").append(panel.tab);
    $("panels").append(panel.node);
    panel.tab.addEventListener("click", () => this.show(panel));
    panel.tab.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (step) {
        const next = this.panels.at((this.panels.indexOf(panel) + step) % this.panels.length);
        this.show(next);
        next.tab.focus();
      }
    });
  }

  removeTab(panel) {
    this.panels = this.panels.filter((one) => one !== panel);
    panel.tab.remove();
    panel.node.remove();
  }

  show(shown) {
    this.shown = shown;
    this.rig.show?.(shown.encoder);
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
    if (!this.follows) {
      this.rig.place(angleOf(this.drag.want));
    }
  }

  release() {
    if (this.drag && this.follows) {
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
        this.command(line).catch((error) => this.complain(error));
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

  // The rig may be elsewhere, and take its time.
  async command(line) {
    const { shown } = this;
    this.answer(`${shown.about.title}> ${line}`, "command");
    const { said, errors } = await this.rig.ask(shown.encoder, line);
    said.forEach((text) => this.answer(text));
    errors.forEach((text) => this.answer(text, "error"));
    shown.showFaults();
    shown.refresh(true);
  }

  answer(text, kind = "") {
    $("said").append(make("div", { className: kind }, text));
    $("said").scrollTop = $("said").scrollHeight;
  }
}
