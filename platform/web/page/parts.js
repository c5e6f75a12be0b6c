// SPDX-License-Identifier: MIT
// What parts of the page are made of.

// Angles are 2^-32 turns, as BigInt.
export const TURN = 1n << 32n;
export const degrees = (angle) => (Number(BigInt.asIntN(64, angle)) * 360) / Number(TURN);

export function make(tag, properties = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in node && !name.includes("-")) {
      node[name] = value;
    } else {
      node.setAttribute(name, value);
    }
  }
  node.append(...children);
  return node;
}

export const button = (text, onclick) => make("button", { type: "button", onclick }, text);

export function hexadecimal(text, what) {
  const value = Number(/h$/i.test(text) ? `0x${text.slice(0, -1)}` : `0x${text.replace(/^0x/i, "")}`);
  if (!Number.isInteger(value)) {
    throw new Error(`${what} "${text}" is no hexadecimal number: expected 6004`);
  }
  return value;
}

// A form of a row: named fields and a button; `act` is handed their values.
export function form(fields, text, act) {
  const inputs = fields.map(([label, value, name]) =>
    make("input", { value, className: `mono ${name ?? "short"}`, "aria-label": label, spellcheck: false, autocomplete: "off" }),
  );
  const labels = fields.map(([label], i) =>
    make("label", { className: fields[i][2] ? "grow" : "" }, `${label} `, inputs[i]),
  );
  const node = make("form", { className: "row" }, ...labels, make("button", { type: "submit" }, text));
  node.addEventListener("submit", (event) => {
    event.preventDefault();
    act(...inputs.map((input) => input.value.trim()));
  });
  return node;
}

export const hex = (bytes) => Array.from(bytes, (byte) => byte.toString(16).toUpperCase().padStart(2, "0")).join(" ");

export function unhex(text) {
  const digits = text.replace(/[\s,]|0x/gi, "");
  if (!/^([0-9a-f]{2})+$/i.test(digits)) {
    throw new Error(`"${text}" is no row of bytes: expected 40 42`);
  }
  return Uint8Array.from(digits.match(/../g), (pair) => parseInt(pair, 16));
}

// What SCPI answers in a line: units with `;` between them, of items with `,` between them; strings without their quotes.
export function unitsOf(line) {
  const units = [[]];
  for (const [, quoted, plain, end] of line.matchAll(/(?:"((?:[^"]|"")*)"|([^,;]*))(;|,|$)/g)) {
    units.at(-1).push(quoted === undefined ? plain : quoted.replaceAll('""', '"'));
    if (end === ";") {
      units.push([]);
    } else if (end === "") {
      break;
    }
  }
  return units;
}

// Items of STATe?.
export const stateOf = (items) => Object.fromEntries(items.map((word) => word.split(/=(.*)/s)));

// Items of FAULt:CATalog?: five for each fault.
export const catalogueOf = (items) => Array.from({ length: Math.floor(items.length / 5) }, (_, i) => {
  const [name, , cause, effect] = items.slice(5 * i);
  return { name, cause, effect, active: false };
});
