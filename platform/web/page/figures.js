// SPDX-License-Identifier: MIT
// What is drawn: sine and cosine, the lines of a BiSS frame.

// What an encoder with sine and cosine has as its figure.
export const SINCOS = { figure: "Process channel", drawn: "The two voltages that go round with the shaft, sine and cosine." };

const LISSAJOUS_V = 0.75;
const SAMPLES = 160;
const PERIODS_PER_TURN = 2048;

function colours() {
  const style = getComputedStyle(document.documentElement);
  return (name) => style.getPropertyValue(`--${name}`);
}

// A canvas as sharp as the screen. @return its context, in CSS pixels
function prepare(canvas) {
  const scale = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = '11px ui-monospace, "DejaVu Sans Mono", monospace';
  return { pen, width, height };
}

function stroke(pen, points, colour, width = 1.5) {
  pen.beginPath();
  points.forEach(([x, y], i) => (i === 0 ? pen.moveTo(x, y) : pen.lineTo(x, y)));
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.stroke();
}

// The window shows about three periods of what is turning now, 1 s at most.
function windowNs(rpm) {
  const hertz = (Math.abs(rpm) / 60) * PERIODS_PER_TURN;
  return BigInt(Math.round(Math.min(1, 3 / Math.max(hertz, 1e-3)) * 1e9));
}

function dot(pen, at, radius, colour) {
  pen.beginPath();
  pen.arc(...at, radius, 0, 7);
  pen.fillStyle = colour;
  pen.fill();
}

const sideOf = (width, height) => Math.min(height, width / 2.4);

// Cosine to the right, sine up, and the circle of a healthy encoder. @return where a pair of voltages is
function drawAxes(pen, get, { width, height }) {
  const side = sideOf(width, height);
  const centre = [side / 2, height / 2];
  const unit = Math.max(0, side / 2 - 6) / LISSAJOUS_V; // a window may be that small for a moment
  stroke(pen, [[centre[0], centre[1] - side / 2], [centre[0], centre[1] + side / 2]], get("grid"));
  stroke(pen, [[0, centre[1]], [side, centre[1]]], get("grid"));
  pen.beginPath();
  pen.arc(...centre, 0.5 * unit, 0, 7);
  pen.setLineDash([3, 3]);
  pen.strokeStyle = get("soft");
  pen.lineWidth = 1;
  pen.stroke();
  pen.setLineDash([]);
  pen.fillStyle = get("soft");
  pen.fillText("sin", centre[0] + 4, centre[1] - side / 2 + 11);
  pen.fillText("cos", side - 24, centre[1] - 4);
  return ([sin, cos]) => [centre[0] + cos * unit, centre[1] - sin * unit];
}

// What was measured at some moments: between them the signals have gone round many times. @return the last, in words
export function drawSamples(canvas, samples) {
  const { pen, width, height } = prepare(canvas);
  const get = colours();
  const put = drawAxes(pen, get, { width, height });
  const now = samples.at(-1);
  if (!now) {
    return "no power: no signals";
  }
  samples.forEach((sample) => dot(pen, put(sample), 2, get("trace2")));
  dot(pen, put(now), 5, get("accent"));
  const left = sideOf(width, height) + 16;
  pen.fillStyle = get("soft");
  pen.fillText(`sin ${now[0].toFixed(3)} V`, left, height / 2 - 8);
  pen.fillText(`cos ${now[1].toFixed(3)} V`, left, height / 2 + 12);
  return `${samples.length} measurements, the last sin ${now[0].toFixed(3)} V, cos ${now[1].toFixed(3)} V`;
}

const milliseconds = (ns) => {
  const ms = Number(ns) / 1e6;
  return ms < 100 ? ms.toPrecision(3) : ms.toFixed(0);
};

// Sine against cosine on the left, both against time on the right. @return what it shows, in words
export function drawSinCos(canvas, encoder) {
  const { pen, width, height } = prepare(canvas);
  const get = colours();
  const { rig } = encoder;
  const span = windowNs(rig.speed);
  const from = rig.now > span ? rig.now - span : 0n;
  const rows = Array.from({ length: SAMPLES }, (_, i) =>
    encoder.sincos(from + ((rig.now - from) * BigInt(i)) / BigInt(SAMPLES - 1)),
  );
  const now = rows.at(-1);
  const put = drawAxes(pen, get, { width, height });
  if (now === null) {
    return "no power: no signals";
  }
  const good = rows.filter((row) => row !== null);
  stroke(pen, good.map(put), get("accent"), 2);
  dot(pen, put(now), 5, get("accent"));
  const left = sideOf(width, height) + 16;
  const across = width - left - 4;
  [["sin", 0, "accent"], ["cos", 1, "trace2"]].forEach(([name, which, colour], i) => {
    const middle = height * (0.25 + 0.5 * i);
    const tall = height * 0.19;
    stroke(pen, [[left, middle], [width - 4, middle]], get("grid"));
    const points = rows
      .map((row, k) => row && [left + (across * k) / (SAMPLES - 1), middle - (row[which] / LISSAJOUS_V) * tall])
      .filter((point) => point !== null);
    stroke(pen, points, get(colour));
    pen.fillStyle = get(colour);
    pen.fillText(`${name} ${now[which].toFixed(3)} V`, left, middle - tall - 3);
  });
  return `sin ${now[0].toFixed(3)} V, cos ${now[1].toFixed(3)} V, ${milliseconds(span)} ms across`;
}

// MA and SLO of a frame; a wide one breaks into rows.
export function drawFrame(canvas, frame) {
  const rows = canvas.clientWidth < 560 ? 4 : 2;
  canvas.style.height = `${rows * 88 + 4}px`;
  const { pen, width } = prepare(canvas);
  const get = colours();
  if (frame === null) {
    pen.fillStyle = get("soft");
    pen.fillText("no frame yet: read one", 8, 20);
    return;
  }
  const begin = frame.from - 1000n;
  const span = Number(frame.to - begin);
  const part = span / rows;
  const left = 34;
  for (let row = 0; row < rows; row++) {
    const first = part * row;
    const x = (at) => left + ((Number(at - begin) - first) / part) * (width - left - 4);
    const top = row * 88;
    pen.save();
    pen.fillStyle = get("soft");
    pen.fillText("MA", 4, top + 36);
    pen.fillText("SLO", 4, top + 68);
    pen.beginPath();
    pen.rect(left, top, width - left, 86);
    pen.clip();
    let until = -Infinity;
    frame.marks.forEach((mark) => {
      const at = x(mark.at);
      stroke(pen, [[at, top + 14], [at, top + 80]], get("grid"));
      pen.fillStyle = /CD[MS]|latch/.test(mark.name) ? get("bad") : get("soft");
      const wide = pen.measureText(mark.name).width;
      const from = Math.min(at + 2, width - wide - 2); // the last name ends at the edge
      if (from >= until && at > left - 20 && at < width) {
        pen.fillText(mark.name, from, top + 11);
        until = from + wide + 2;
      }
    });
    line(pen, frame.ma, x, [top + 40, top + 22], frame, get("accent"));
    line(pen, frame.slo, x, [top + 72, top + 54], frame, get("trace2"));
    pen.restore();
  }
}

// A line that is high before its first edge.
function line(pen, edges, x, [low, high], frame, colour) {
  const y = (level) => (level ? high : low);
  const points = [[x(frame.from - 1000n), y(1)]];
  let level = 1;
  for (const edge of edges) {
    points.push([x(edge.at), y(level)], [x(edge.at), y(edge.level)]);
    level = edge.level;
  }
  points.push([x(frame.to), y(level)]);
  stroke(pen, points, colour);
}

// Half a period of a lamp in ms; the second half of `fast-other` is lit. The lamp BA blinks slower.
const HALF_MS = { blink: 250, slow: 1000, fast: 50, "fast-other": 50, "300ms": 300 };
const OWN_HALF_MS = { BA: 500 };

// Whether the lamp of this name and pattern is lit at that moment.
export function glows(name, pattern, ns) {
  if (!(pattern in HALF_MS)) {
    return pattern === "on";
  }
  const half = OWN_HALF_MS[name] ?? HALF_MS[pattern];
  const first = Math.floor(Number(ns / 1000000n) / half) % 2 === 0;
  return first !== (pattern === "fast-other");
}
