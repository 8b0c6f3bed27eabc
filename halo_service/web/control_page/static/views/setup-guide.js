// One running step: what to do, how long still, what is seen.

import { colour, el, fitted } from "../dom.js";

const MOST = 300;

export class Guide {
  constructor() {
    this.words = el("p", { className: "prompt", role: "status" });
    this.ring = el("canvas", { className: "ring", role: "img", "aria-label": "How much of the step is done" });
    this.left = el("p", {});
    this.signal = el("canvas", { role: "img", "aria-label": "Strength of the halo around the finger" });
    this.seen = el("p", { className: "soft" });
    this.map = el("pre", { className: "map", "aria-label": "What of the surface is covered" });
    this.said = el("ul", { className: "small" });
    this.element = el(
      "section",
      { className: "card" },
      this.words,
      el("div", { className: "row" }, this.ring, el("div", {}, this.left, this.seen)),
      this.signal,
      this.map,
      this.said,
    );
    this.clear();
  }

  clear() {
    this.past = [];
    this.words.textContent = "Starting: the camera and the hand tracker need a few seconds.";
    for (const part of [this.left, this.seen, this.map, this.said]) part.textContent = "";
    this.map.hidden = this.signal.hidden = true;
    this.drawRing({ share: 0 });
  }

  show(guide) {
    if (this.words.textContent !== guide.prompt && guide.prompt) this.words.textContent = guide.prompt;
    const phase = { ready: "Get ready", measure: "Hold" }[guide.phase] ?? "";
    this.left.textContent = guide.phase === "count" ? `${Math.round(100 * guide.share)} % done` : phase ? `${phase}: ${guide.left_s.toFixed(1)} s` : "";
    this.seen.textContent = guide.seen;
    this.map.hidden = guide.map.length === 0;
    this.map.textContent = guide.map.join("\n");
    this.said.replaceChildren(...guide.said.map((line) => el("li", {}, line)).reverse());
    this.drawRing(guide);
    this.past.push(guide.signal);
    if (this.past.length > MOST) this.past.shift();
    this.signal.hidden = this.past.every((each) => each === null);
    if (!this.signal.hidden) this.drawSignal(guide.most);
  }

  drawRing({ share, phase }) {
    const { context, width } = fitted(this.ring, 1);
    const middle = width / 2;
    context.clearRect(0, 0, width, width);
    context.lineWidth = width / 9;
    context.strokeStyle = colour("line");
    context.beginPath();
    context.arc(middle, middle, middle - width / 12, 0, 2 * Math.PI);
    context.stroke();
    context.strokeStyle = colour(phase === "measure" ? "touch" : "accent");
    context.beginPath();
    context.arc(middle, middle, middle - width / 12, -Math.PI / 2, -Math.PI / 2 + 2 * Math.PI * share);
    context.stroke();
  }

  drawSignal(most) {
    const { context, width, height } = fitted(this.signal, 0.15);
    context.clearRect(0, 0, width, height);
    context.strokeStyle = colour("accent");
    context.lineWidth = 2;
    context.beginPath();
    let lifted = true;
    this.past.forEach((value, n) => {
      if (value === null) {
        lifted = true;
        return;
      }
      const x = (n / MOST) * width;
      const y = height - 3 - (height - 6) * Math.max(value / most, 0);
      if (lifted) context.moveTo(x, y);
      else context.lineTo(x, y);
      lifted = false;
    });
    context.stroke();
    context.fillStyle = colour("soft");
    context.font = "12px system-ui, sans-serif";
    context.fillText("halo around the finger", 6, 14);
  }
}
