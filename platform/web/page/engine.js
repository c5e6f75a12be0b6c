// SPDX-License-Identifier: MIT
// The module of WebAssembly: its memory, its texts, and the two functions it asks of the page.

const PAGE = 65536;
const ALIGN = 16;

// Conversions of C, as far as the words of traces use them.
const CONVERSION = /%(0?)(\*|\d+)?(?:\.(\*))?(l{0,2}|z)([scduX%])/g;

export class Engine {
  // `bytes` of the module.
  static async load(bytes) {
    const engine = new Engine();
    const page = {
      vsnprintf: (to, size, format, list) => engine.print(to, size, format, list),
      line: (decoder, at, ours, text) => engine.line(decoder, BigInt.asUintN(64, at), ours !== 0, engine.text(text)),
    };
    const { instance } = await WebAssembly.instantiate(bytes, { page });
    engine.c = instance.exports;
    engine.end = engine.c.__heap_base.value;
    engine.scratch = engine.place(PAGE);
    return engine;
  }

  // A line of words from a decoder; whoever decodes sets this.
  line() {}

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

  // vsnprintf(): the arguments lie behind each other in memory.
  print(to, size, format, list) {
    const next = () => {
      list += 4;
      return this.view.getInt32(list - 4, true);
    };
    const said = this.text(format).replace(CONVERSION, (_, zero, width, precision, length, kind) => {
      if (kind === "%") {
        return "%";
      }
      const wide = width === "*" ? next() : Number(width ?? 0);
      const most = precision === "*" ? next() : Infinity;
      const long = length === "ll";
      if (long) {
        list = Math.ceil(list / 8) * 8;
      }
      const value = long ? this.view.getBigInt64((list += 8) - 8, true) : next();
      return Engine.convert(this, kind, value, most).padStart(wide, zero || " ");
    });
    const coded = new TextEncoder().encode(said);
    if (size > 0) {
      const fits = Math.min(coded.length, size - 1);
      this.bytes(to, fits).set(coded.subarray(0, fits));
      this.view.setUint8(to + fits, 0);
    }
    return coded.length;
  }

  static convert(engine, kind, value, most) {
    const unsigned = typeof value === "bigint" ? BigInt.asUintN(64, value) : value >>> 0;
    switch (kind) {
      case "s":
        return Number.isFinite(most)
          ? new TextDecoder().decode(engine.bytes(value, most)).replace(/\0.*/s, "")
          : engine.text(value);
      case "c":
        return String.fromCharCode(value);
      case "d":
        return String(value);
      case "u":
        return String(unsigned);
      default:
        return unsigned.toString(16).toUpperCase();
    }
  }
}
