// SPDX-License-Identifier: MIT
// The panel of a running rig: the page with encoders that are elsewhere. The token stands behind the address, where no
// server and no log sees it, or is asked for.
import { LiveRig } from "./live.js";
import { $, Page } from "./page.js";
import { make } from "./parts.js";
import { Panel } from "./view.js";

const REFUSED_MS = 5000;
const WHERE = "The token is part of the address that drehgeber web printed: it follows #token= there. Open that address, or paste " +
  "the token here. If drehgeber web was started with --token FILE, the token is the line in that file.";
// What changes the rig.
const STEERS = "#turning input, #turning button, #going input, #going button";

class Front extends Page {
  constructor(token) {
    super(null);
    this.until = 0;
    this.rig = new LiveRig(token, this);
  }

  // ---------------------------------------------------------------- what the rig says

  found() {
    const { shown } = this;
    this.lock();
    this.tabs(this.rig.encoders.map((encoder) => this.panel(encoder)));
    const again = this.panels.find((panel) => panel.key === shown?.key);
    if (again) {
      this.show(again);
    }
    if (!shown) {
      this.begin();
    }
  }

  panel(encoder) {
    const options = { about: encoder.about };
    return new Panel(encoder, (run) => this.guard(run), options);
  }

  heard(frame) {
    this.panelOf(frame.encoder)?.say(frame);
  }

  trouble(text) {
    this.complain(new Error(text));
  }

  well() {
    if (performance.now() > this.until) {
      $("trouble").hidden = true;
    }
  }

  refused(text) {
    this.until = performance.now() + REFUSED_MS;
    this.complain(new Error(text));
  }

  locked() {
    askForToken("That is not the token of this rig.");
  }

  // ---------------------------------------------------------------- the page

  // Of someone who only looks.
  lock() {
    const watches = this.rig.watches === true;
    document.querySelectorAll(STEERS).forEach((node) => {
      node.disabled = watches;
    });
    $("lead").textContent = watches ? "A running rig, to look at." : "A running rig.";
  }

  show(panel) {
    super.show(panel);
    $("shaft-title").textContent = `Shaft ${panel.encoder.shaft}`;
  }
}

function askForToken(why) {
  const field = make("input", { type: "password", autocomplete: "off", id: "token", "aria-label": "Token" });
  const form = make("form", { className: "card door" }, make("h2", {}, "Token"), make("p", {}, why), make("p", {}, WHERE),
    make("p", { className: "row" }, field, make("button", { type: "submit" }, "Look")));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    location.hash = `token=${field.value}`;
    location.reload();
  });
  const main = document.querySelector("main");
  [...main.children, $("timing")].forEach((node) => { node.hidden = true; });
  main.append(form);
  field.focus();
}

document.title = "drehgeber: a running rig";
$("lead").textContent = "A running rig.";
document.querySelectorAll(".playground").forEach((node) => node.remove());
const token = /^#token=([\x21-\x7e]+)$/.exec(location.hash)?.[1];
if (token) {
  globalThis.drehgeber = new Front(token);
} else {
  askForToken("This address has no token.");
}
