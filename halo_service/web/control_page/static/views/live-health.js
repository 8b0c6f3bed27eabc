// Health as numbers, each with the course of its last two minutes.

import { colour, el, fitted } from "../dom.js";

const MOST = 120;
const LOADS = {
  none: "nothing",
  reduced: "some hand model runs",
  least: "most hand model runs",
  dropping: "most hand model runs, some frames",
};
const FIGURES = [
  ["fps", "frames a second", (value) => value?.toFixed(1)],
  ["latency_ms", "latency, ms", (value) => (value < 0 ? "-" : value?.toFixed(1))],
  ["tracker_ms", "age of hand positions, ms", (value) => (value < 0 ? "-" : value?.toFixed(0))],
  ["looks_hz", "hand model runs per s", (value) => (value < 0 ? "-" : value?.toFixed(0))],
  ["load", "skipped under load", (value) => LOADS[value] ?? "-"],
  ["cpu", "CPU, cores", (value) => value?.toFixed(2)],
  ["drops", "missed frames", String],
  ["bad_frames", "bad frames", String],
  ["tracker", "hand tracker", String],
  ["fit", "fit of the profile", String],
  ["osc_clients", "OSC receivers", String],
  ["web_clients", "WebSocket clients", String],
];

export class Health {
  constructor() {
    this.past = new Map();
    this.shown = new Map();
    this.element = el("dl", { className: "figures" });
    for (const [name, title] of FIGURES) {
      const value = el("dd", {}, "-");
      const plot = ["fps", "latency_ms", "tracker_ms", "cpu"].includes(name)
        ? el("canvas", { "aria-hidden": "true" })
        : null;
      this.shown.set(name, { value, plot });
      this.past.set(name, []);
      this.element.append(el("div", {}, el("dt", {}, title), value, plot && el("dd", {}, plot)));
    }
  }

  show(health) {
    for (const [name, , words] of FIGURES) {
      const { value, plot } = this.shown.get(name);
      value.textContent = words(health[name]) ?? "-";
      if (!plot) continue;
      const past = this.past.get(name);
      past.push(Math.max(health[name] ?? 0, 0));
      if (past.length > MOST) past.shift();
      drawPast(plot, past);
    }
  }
}

function drawPast(canvas, past) {
  const { context, width, height } = fitted(canvas, 28 / (canvas.clientWidth || 120));
  const most = Math.max(...past, 1e-6) * 1.15;
  context.clearRect(0, 0, width, height);
  context.strokeStyle = colour("accent");
  context.lineWidth = 1.5;
  context.beginPath();
  past.forEach((value, n) => {
    const x = width - ((past.length - 1 - n) / MOST) * width;
    const y = height - 1 - (height - 2) * (value / most);
    if (n) context.lineTo(x, y);
    else context.moveTo(x, y);
  });
  context.stroke();
}
