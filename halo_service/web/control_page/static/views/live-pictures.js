// Depth, infrared and colour, with what is sensed drawn on top. Only what is shown is sent.

import { el } from "../dom.js";

const KINDS = {
  depth: "Depth against the empty table. Orange, bright (+): it reads deeper, which is the halo. Blue, dark (−): it is above the table, such as a hand. Grey: as the empty table. Black: no measurement.",
  infrared: "Infrared: what the depth camera sees.",
  colour: "Colour.",
};

export class Pictures {
  constructor(service) {
    this.service = service;
    this.shown = new Map();
    this.place = el("div", { className: "pictures" });
    const choice = Object.keys(KINDS).map((kind) => {
      const box = el("input", { type: "checkbox", id: `show-${kind}`, onchange: () => this.toggle(kind, box.checked) });
      return el("span", {}, box, " ", el("label", { htmlFor: `show-${kind}` }, kind));
    });
    this.element = el("div", {}, el("div", { className: "row" }, choice), this.place);
    this.stop = service.on("picture", (picture) => this.draw(picture));
  }

  toggle(kind, on) {
    if (on) {
      const canvas = el("canvas", { role: "img", "aria-label": kind, width: 320, height: 240 });
      const scale = el("span");
      const figure = el("figure", {}, canvas, el("figcaption", {}, KINDS[kind], scale));
      this.shown.set(kind, { canvas, figure, scale });
      this.place.append(figure);
    } else {
      this.shown.get(kind)?.figure.remove();
      this.shown.delete(kind);
    }
    this.service.show([...this.shown.keys()]);
  }

  async draw({ header, image }) {
    const shown = this.shown.get(header.kind);
    if (!shown) return;
    const bitmap = await createImageBitmap(image);
    const { canvas } = shown;
    if (canvas.width !== header.width || canvas.height !== header.height) {
      canvas.width = header.width;
      canvas.height = header.height;
    }
    const context = canvas.getContext("2d", { willReadFrequently: header.kind === "depth" });
    context.drawImage(bitmap, 0, 0);
    bitmap.close();
    if (header.kind === "depth" && header.farther_mm) {
      paint(context, header.width, header.height);
      shown.scale.textContent = ` The scale ends at +${header.farther_mm} and −${header.nearer_mm} mm.`;
    }
    const line = header.width / 320;
    drawPolygon(context, header.surface, "#ffffff", 2 * line, []);
    drawPolygon(context, header.projector, "#57e0d8", 2 * line, [8 * line, 5 * line]);
    for (const outline of header.outlines ?? []) drawPolygon(context, outline, "#ffe066", line, []);
    for (const tip of header.tips ?? []) drawTip(context, tip, line);
  }

  close() {
    this.stop();
  }
}

// Grey 128 is the surface. Deeper: warm, and always brighter; nearer: blue, and always darker.
const NOISE = 9; // Grey levels: about 2 mm.
const PALETTE = new Uint8Array(256 * 3);
for (let grey = 0; grey < 256; grey++) {
  const deep = Math.max(grey - 128 - NOISE, 0) / 127;
  const near = Math.max(128 - grey - NOISE / 3, 0) / 127;
  const strong = Math.min(1, deep * 2.5);
  PALETTE[3 * grey] = deep ? 90 + 165 * strong : 90 - 80 * near;
  PALETTE[3 * grey + 1] = deep ? 90 + 110 * strong * (1 - 0.2 * deep) : 90 - 60 * near;
  PALETTE[3 * grey + 2] = deep ? 90 - 60 * strong : 90 + 60 * near;
}
PALETTE.fill(0, 0, 9);

function paint(context, width, height) {
  const image = context.getImageData(0, 0, width, height);
  const { data } = image;
  for (let n = 0; n < data.length; n += 4) {
    const from = 3 * data[n];
    data[n] = PALETTE[from];
    data[n + 1] = PALETTE[from + 1];
    data[n + 2] = PALETTE[from + 2];
  }
  context.putImageData(image, 0, 0);
}

function drawPolygon(context, points, stroke, width, dash) {
  if (!points) return;
  context.setLineDash(dash);
  context.strokeStyle = stroke;
  context.lineWidth = width;
  context.beginPath();
  points.forEach(([x, y], n) => (n ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.closePath();
  context.stroke();
  context.setLineDash([]);
}

function drawTip(context, { at: [x, y], touch, slot }, line) {
  context.lineWidth = 2 * line;
  context.strokeStyle = context.fillStyle = touch ? "#ff5d73" : "#57e0d8";
  context.beginPath();
  context.arc(x, y, 6 * line, 0, 2 * Math.PI);
  if (touch) context.fill();
  else context.stroke();
  context.font = `${12 * line}px system-ui, sans-serif`;
  const words = `${slot} ${touch ? "touch" : "hover"}`;
  const ink = context.fillStyle;
  context.fillStyle = "#000000b0";
  context.fillRect(x + 8 * line, y - 17 * line, context.measureText(words).width + 6 * line, 16 * line);
  context.fillStyle = ink;
  context.fillText(words, x + 11 * line, y - 5 * line);
}
