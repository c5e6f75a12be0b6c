// SPDX-License-Identifier: MIT
// A link carries what the page shows: #model=f3668&shaft=90DEG&fault=led_current_high. More words: power=off, and `still` for
// a clock that stands.

const ANGLES = { DEG: 1, REV: 360 };

// "90DEG", "2.5REV" or "60RPM", as on the command line.
function readShaft(text) {
  const found = /^([+-]?\d+(?:\.\d+)?)(DEG|REV|RPM)$/i.exec(text);
  if (!found) {
    throw new Error(`shaft=${text}: expected 90DEG, 2.5REV or 60RPM`);
  }
  const unit = found[2].toUpperCase();
  const value = Number(found[1]);
  return unit === "RPM" ? { rpm: value } : { degrees: value * ANGLES[unit] };
}

function readPower(text) {
  if (text !== "on" && text !== "off") {
    throw new Error(`power=${text}: expected on or off`);
  }
  return text === "on";
}

const LINK_WORDS = {
  model: (text) => text,
  shaft: readShaft,
  fault: (text) => text.split(","),
  power: readPower,
  still: () => true,
};

// @return an object with the words of an address that are in it; a word that is unknown is an error
export function readLink(hash) {
  const link = {};
  for (const [word, text] of new URLSearchParams(hash.replace(/^#/, ""))) {
    if (!Object.hasOwn(LINK_WORDS, word)) {
      throw new Error(`${word}: expected ${Object.keys(LINK_WORDS).join(", ")}`);
    }
    link[word] = LINK_WORDS[word](text);
  }
  return link;
}

// The other way round: what readLink() makes this state of.
export function writeLink({ model, rpm, degrees, faults, powered, still }) {
  const words = [`model=${model}`, `shaft=${rpm === 0 ? `${Number(degrees.toFixed(3))}DEG` : `${Number(rpm.toFixed(3))}RPM`}`];
  if (faults.length > 0) {
    words.push(`fault=${faults.join(",")}`);
  }
  return `#${[...words, ...(powered ? [] : ["power=off"]), ...(still ? ["still"] : [])].join("&")}`;
}
