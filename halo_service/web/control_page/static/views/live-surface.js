// The surface from above: a ring for a finger in the air, wider with its height; a disc for a touch,
// larger with its pressure; its way; and a ring that grows where a touch began.

import { colour, el, fitted } from "../dom.js";

const TRAIL_MS = 1500;
const DOWN_MS = 700;
const MARGIN_PX = 26;

export class SurfaceView {
  constructor() {
    this.canvas = el("canvas", { role: "img", "aria-label": "Surface from above with the fingers" });
    this.element = el("figure", {}, this.canvas, el("figcaption", {}, "Disc: touch, larger with more pressure. Ring: in the air, wider with more height. The user sits at the lower edge."));
    this.scene = { width_mm: 300, height_mm: 200, projector: null };
    this.clear();
  }

  clear() {
    this.pointers = [];
    this.trails = new Map();
    this.downs = [];
  }

  add(frame) {
    const now = performance.now();
    this.pointers = frame.pointers;
    for (const { id, x_mm, y_mm, touch } of frame.pointers) {
      if (!this.trails.has(id)) this.trails.set(id, []);
      this.trails.get(id).push({ x_mm, y_mm, touch, at: now });
    }
    for (const event of frame.events) {
      if (event.type === "down") this.downs.push({ ...event, at: now });
    }
  }

  draw() {
    const { width_mm, height_mm, projector } = this.scene;
    const { context, width, height } = fitted(this.canvas, height_mm / width_mm);
    const scale = (width - 2 * MARGIN_PX) / width_mm;
    const top = (height - scale * height_mm) / 2;
    const at = (x, y) => [MARGIN_PX + x * scale, top + y * scale];
    context.clearRect(0, 0, width, height);
    this.drawSurface(context, at, width_mm, height_mm, projector);
    const now = performance.now();
    for (const [id, trail] of this.trails) {
      while (trail.length && now - trail[0].at > TRAIL_MS) trail.shift();
      if (trail.length === 0) this.trails.delete(id);
      else drawTrail(context, trail, at, now);
    }
    this.downs = this.downs.filter((down) => now - down.at < DOWN_MS);
    for (const down of this.downs) drawDown(context, at(down.x_mm, down.y_mm), (now - down.at) / DOWN_MS);
    for (const pointer of this.pointers) drawPointer(context, at(pointer.x_mm, pointer.y_mm), pointer, scale);
  }

  drawSurface(context, at, width_mm, height_mm, projector) {
    context.lineWidth = 2;
    context.strokeStyle = colour("soft");
    context.strokeRect(...at(0, 0), at(width_mm, 0)[0] - at(0, 0)[0], at(0, height_mm)[1] - at(0, 0)[1]);
    context.lineWidth = 1;
    context.strokeStyle = colour("line");
    context.beginPath();
    for (let x = 50; x < width_mm; x += 50) { context.moveTo(...at(x, 0)); context.lineTo(...at(x, height_mm)); }
    for (let y = 50; y < height_mm; y += 50) { context.moveTo(...at(0, y)); context.lineTo(...at(width_mm, y)); }
    context.stroke();
    if (!projector) return;
    context.setLineDash([8, 6]);
    context.strokeStyle = colour("accent");
    context.beginPath();
    projector.forEach(([x, y], n) => (n ? context.lineTo(...at(x, y)) : context.moveTo(...at(x, y))));
    context.closePath();
    context.stroke();
    context.setLineDash([]);
  }
}

function drawTrail(context, trail, at, now) {
  context.lineCap = "round";
  for (let n = 1; n < trail.length; n++) {
    context.globalAlpha = 0.7 * (1 - (now - trail[n].at) / TRAIL_MS);
    context.strokeStyle = colour(trail[n].touch ? "touch" : "accent");
    context.lineWidth = trail[n].touch ? 4 : 1.5;
    context.beginPath();
    context.moveTo(...at(trail[n - 1].x_mm, trail[n - 1].y_mm));
    context.lineTo(...at(trail[n].x_mm, trail[n].y_mm));
    context.stroke();
  }
  context.globalAlpha = 1;
}

function drawDown(context, [x, y], age) {
  context.globalAlpha = 1 - age;
  context.strokeStyle = colour("touch");
  context.lineWidth = 3;
  context.beginPath();
  context.arc(x, y, 10 + 34 * age, 0, 2 * Math.PI);
  context.stroke();
  context.globalAlpha = 1;
}

function drawPointer(context, [x, y], pointer, scale) {
  const radius = pointer.touch
    ? 7 + 14 * Math.min(pointer.pressure ?? 0, 1.5)
    : 7 + Math.min((pointer.hover_mm ?? 0) * scale * 0.5, 50);
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  if (pointer.touch) {
    context.fillStyle = colour("touch");
    context.fill();
  } else {
    context.lineWidth = 2.5;
    context.strokeStyle = colour("accent");
    context.stroke();
    context.beginPath();
    context.arc(x, y, 2.5, 0, 2 * Math.PI);
    context.fillStyle = colour("accent");
    context.fill();
  }
  context.fillStyle = colour("text");
  context.font = "13px system-ui, sans-serif";
  const words = pointer.touch ? "touch" : `${Math.round(pointer.hover_mm ?? 0)} mm`;
  context.fillText(`${pointer.slot} ${words}`, x + radius + 5, y - 5);
}
