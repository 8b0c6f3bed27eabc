// Contact, height and force of the last ten seconds, with the thresholds.

import { colour, el, fitted } from "../dom.js";

const SPAN_MS = 10_000;
const LEFT_PX = 56;
const DASHES = [[], [7, 4], [2, 3], [10, 3, 2, 3]];

export class Strip {
  constructor() {
    this.canvas = el("canvas", { role: "img", "aria-label": "Contact, height and force over the last ten seconds" });
    this.element = el(
      "figure",
      {},
      this.canvas,
      el("figcaption", {}, "Contact: the probability that the finger touches. A touch begins above the line 'down' and ends below the line 'up'. Thick: touching. Each finger has its own dashes."),
    );
    this.thresholds = {};
    this.points = []; // {at, slot, probability, height, force, touch}
  }

  add(frame) {
    const at = performance.now();
    for (const each of frame.pointers) {
      this.points.push({
        at, slot: each.slot, touch: each.touch,
        probability: each.probability, height: each.hover_mm, force: each.touch ? each.force_g : null,
      });
    }
    while (this.points.length && at - this.points[0].at > SPAN_MS) this.points.shift();
  }

  draw() {
    const { context, width, height } = fitted(this.canvas, innerWidth < 700 ? 0.75 : 0.42);
    context.clearRect(0, 0, width, height);
    const now = performance.now();
    const { down_level, up_level, hover_range_mm, press_g } = this.thresholds;
    const forces = this.points.map((each) => each.force ?? 0);
    const rows = [
      { name: "probability", label: "contact", unit: "", low: 0, high: 1, marks: [[down_level, "down"], [up_level, "up"]] },
      { name: "height", label: "height", unit: "mm", low: 0, high: Math.min(hover_range_mm ?? 100, 60), marks: [] },
      { name: "force", label: "force", unit: "g", low: 0, high: Math.max(1.3 * (press_g ?? 100), ...forces), marks: press_g ? [[press_g, "press"]] : [] },
    ];
    const tall = height / rows.length;
    rows.forEach((row, n) => this.drawRow(context, row, n * tall + 6, tall - 12, width, now));
  }

  drawRow(context, { name, label, unit, low, high, marks }, top, tall, width, now) {
    const y = (value) => top + tall * (1 - (Math.min(Math.max(value, low), high) - low) / (high - low));
    const x = (at) => width - ((now - at) / SPAN_MS) * (width - LEFT_PX);
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = colour("soft");
    context.fillText(label, 4, top + 11);
    context.fillText(`${Math.round(high * 10) / 10} ${unit}`, 4, top + 26);
    context.strokeStyle = colour("line");
    context.lineWidth = 1;
    context.strokeRect(LEFT_PX, top, width - LEFT_PX - 1, tall);
    context.setLineDash([4, 4]);
    for (const [value, words] of marks) {
      if (value === undefined) continue;
      context.strokeStyle = colour("soft");
      context.beginPath();
      context.moveTo(LEFT_PX, y(value));
      context.lineTo(width, y(value));
      context.stroke();
      context.fillText(words, LEFT_PX + (words === "up" ? 44 : 4), y(value) - 2);
    }
    const last = new Map();
    for (const point of this.points) {
      const before = last.get(point.slot);
      last.set(point.slot, point);
      if (!before || point.at - before.at > 400 || point[name] === null || before[name] === null) continue;
      context.setLineDash(DASHES[point.slot % DASHES.length]);
      context.strokeStyle = colour(point.touch ? "touch" : "accent");
      context.lineWidth = point.touch ? 3 : 1.5;
      context.beginPath();
      context.moveTo(x(before.at), y(before[name]));
      context.lineTo(x(point.at), y(point[name]));
      context.stroke();
    }
    context.setLineDash([]);
  }
}
