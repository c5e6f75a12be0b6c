// SPDX-License-Identifier: MIT
// The module of WebAssembly: its memory, its texts, and the functions it asks of the page.

const PAGE = 65536;
const ALIGN = 16;

// enum dg_severity.
const SEVERITIES = ["ok", "notice", "warning", "error"];

export class Engine {
  // `bytes` of the module.
  static async load(bytes) {
    const engine = new Engine();
    const page = {
      line: (wire, at, ours, severity, text) => {
        const said = [wire, wire + 4].map((word) => engine.view.getUint32(word, true));
        const line = { at: BigInt.asUintN(64, at), ours: ours !== 0, severity: SEVERITIES[severity], words: engine.text(text) };
        engine.line(wire, { ...line, bytes: engine.bytes(...said).slice() });
      },
      level: (wire, at, level) => engine.level(wire, { at: BigInt.asUintN(64, at), level }),
    };
    const { instance } = await WebAssembly.instantiate(bytes, { page });
    engine.c = instance.exports;
    engine.end = engine.c.__heap_base.value;
    engine.scratch = engine.place(PAGE);
    return engine;
  }

  // A line {at, ours, severity, bytes, words} of a wire, and an edge {at, level} of its data; who makes the wires sets these.
  line() {}

  level() {}

  get view() {
    const { buffer } = this.c.memory;
    if (this.kept?.buffer !== buffer) {
      this.kept = new DataView(buffer);
    }
    return this.kept;
  }

  bytes(at, n) {
    return new Uint8Array(this.c.memory.buffer, at, n);
  }

  // Memory for good: nothing here is ever given back.
  place(size) {
    const at = Math.ceil(this.end / ALIGN) * ALIGN;
    this.end = at + size;
    const missing = this.end - this.c.memory.buffer.byteLength;
    if (missing > 0) {
      this.c.memory.grow(Math.ceil(missing / PAGE));
    }
    return at;
  }

  text(at) {
    let end = at;
    while (this.view.getUint8(end) !== 0) {
      end++;
    }
    return new TextDecoder().decode(this.bytes(at, end - at));
  }

  // Texts for one call, side by side at the end of the scratch memory.
  spell(...texts) {
    let at = this.scratch + PAGE / 2;
    return texts.map((text) => {
      const coded = new TextEncoder().encode(`${text}\0`);
      const here = at;
      at += coded.length;
      if (at > this.scratch + PAGE) {
        throw new Error("too long");
      }
      this.bytes(here, coded.length).set(coded);
      return here;
    });
  }

  // A result of the library, which is an error when it is negative.
  checked(result, about) {
    if (result < 0) {
      throw new Error(`${about}: ${this.text(this.c.dg_host_result_text(result))}`);
    }
    return result;
  }
}
