// Four corners that are dragged in the infrared picture, or moved with the arrow keys.

import { el } from "../dom.js";

const NAMES = ["far left", "far right", "near right", "near left"];
const STEP = 2; // The picture has every second pixel of the camera.
const GRAB_PX = 30;

export class CornerPicture {
  constructor(service) {
    this.service = service;
    this.places = null;
    this.held = null;
    this.size = [320, 288];
    this.canvas = el("canvas", { width: 320, height: 288, "aria-hidden": "true" });
    this.handles = NAMES.map((name, n) => el("button", {
      type: "button", className: "small", onkeydown: (event) => this.key(event, n), "aria-label": `${name} corner, move with the arrow keys`,
    }, name));
    this.element = el(
      "figure",
      {},
      this.canvas,
      el("figcaption", {}, "Drag the corners; or choose one here and move it with the arrow keys (Shift: in larger steps). The user sits at the lower edge."),
      el("div", { className: "row" }, this.handles),
    );
    this.canvas.addEventListener("pointerdown", (event) => this.grab(event));
    this.canvas.addEventListener("pointermove", (event) => this.drag(event));
    for (const end of ["pointerup", "pointercancel"]) this.canvas.addEventListener(end, () => (this.held = null));
    // A finger that holds a corner must not scroll the page; next to the corners it still may.
    this.canvas.addEventListener("touchstart", (event) => this.held !== null && event.preventDefault(), { passive: false });
    this.stop = null;
  }

  open() {
    this.stop ??= this.service.on("picture", (picture) => this.draw(picture));
    this.service.show(["infrared"]);
  }

  close() {
    this.stop?.();
    this.stop = null;
    this.service.show([]);
  }

  corners() {
    if (!this.places) throw new Error("Wait for the picture.");
    return this.places.map(([x, y]) => [x * STEP, y * STEP]);
  }

  async draw({ header, image }) {
    if (header.kind !== "infrared") return;
    this.bitmap = await createImageBitmap(image);
    this.size = [header.width, header.height];
    this.canvas.width = header.width;
    this.canvas.height = header.height;
    const known = header.surface;
    const side = known ? known.length / 4 : 0;
    this.places ??= known
      ? [0, 1, 2, 3].map((n) => known[n * side])
      : [[0.3, 0.35], [0.7, 0.35], [0.7, 0.65], [0.3, 0.65]].map(([x, y]) => [x * header.width, y * header.height]);
    this.paint();
  }

  paint() {
    if (!this.bitmap || !this.places) return;
    const context = this.canvas.getContext("2d");
    context.drawImage(this.bitmap, 0, 0);
    context.fillStyle = "#ffe066";
    context.font = "12px system-ui, sans-serif";
    context.beginPath();
    this.places.forEach(([x, y], n) => (n ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.closePath();
    // Yellow on a dark edge: the picture may be as bright as the yellow.
    for (const [colour, width] of [["#000", 4], ["#ffe066", 2]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.stroke();
    }
    context.strokeStyle = "#000";
    context.lineWidth = 3;
    this.places.forEach(([x, y], n) => {
      context.beginPath();
      context.arc(x, y, 6, 0, 2 * Math.PI);
      context.stroke();
      context.fill();
      const inside = x + 9 + context.measureText(NAMES[n]).width < this.size[0];
      context.textAlign = inside ? "left" : "right";
      const at = inside ? x + 9 : x - 9;
      context.strokeText(NAMES[n], at, y - 7);
      context.fillText(NAMES[n], at, y - 7);
    });
  }

  at(event) {
    const box = this.canvas.getBoundingClientRect();
    return [((event.clientX - box.left) / box.width) * this.size[0], ((event.clientY - box.top) / box.height) * this.size[1]];
  }

  grab(event) {
    if (!this.places) return;
    const [x, y] = this.at(event);
    const away = this.places.map(([a, b]) => Math.hypot(a - x, b - y));
    const nearest = away.indexOf(Math.min(...away));
    if (away[nearest] > GRAB_PX) return;
    this.held = nearest;
    this.canvas.setPointerCapture(event.pointerId);
    event.preventDefault();
  }

  drag(event) {
    if (this.held === null) return;
    this.move(this.held, this.at(event));
  }

  key(event, n) {
    const step = event.shiftKey ? 10 : 1;
    const by = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }[event.key];
    if (!by || !this.places) return;
    event.preventDefault();
    this.move(n, [this.places[n][0] + by[0], this.places[n][1] + by[1]]);
  }

  move(n, [x, y]) {
    this.places[n] = [Math.min(Math.max(x, 0), this.size[0] - 1), Math.min(Math.max(y, 0), this.size[1] - 1)];
    this.paint();
  }
}
