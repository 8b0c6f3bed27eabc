// A sketch on your table: a ring that shrinks as a finger comes near, a line as wide as its
// pressure, and a wave for each hit, larger for a faster finger.

import { connect } from "../halo.js";

const HIGHEST_MM = 60; // A finger this high has the largest ring.
const LIFE_FRAMES = 60; // How long a wave and a piece of a line are visible.
const status = document.querySelector("#status");
let size = { width_mm: 300, height_mm: 200 };
let pointers = [];
let waves = [];
let strokes = [];

// `index.html?ws://192.168.1.5:4258/halo` opens another service.
const url = decodeURIComponent(location.search.slice(1)) || "ws://127.0.0.1:4258/halo";
const halo = connect(url, {
  frame: (frame) => (pointers = frame.pointers),
  down: (touch) => waves.push({ ...touch, age: 0 }),
  move: (touch) => strokes.push({ ...touch, age: 0 }),
  report: (report) => {
    if (report.kind === "scene") size = report;
  },
  lost: () => (pointers = []),
});

// p5 looks for these functions on the window; in a module they must be put there.
Object.assign(window, { setup, draw, windowResized });

function setup() {
  createCanvas(windowWidth, windowHeight);
}

function windowResized() {
  resizeCanvas(windowWidth, windowHeight);
}

// A place on the surface in pixels: the surface fills the window, without being stretched.
function spot({ u, v }, diameter) {
  const scale = Math.min(width / size.width_mm, height / size.height_mm);
  const x = width / 2 + (u - 0.5) * size.width_mm * scale;
  circle(x, height / 2 + (v - 0.5) * size.height_mm * scale, diameter);
}

function draw() {
  background(16, 20, 24);
  noStroke();
  for (const piece of strokes) {
    fill(255, 180, 84, 255 * (1 - piece.age / LIFE_FRAMES));
    spot(piece, 6 + 40 * piece.pressure);
  }
  noFill();
  strokeWeight(3);
  for (const wave of waves) {
    stroke(255, 255, 255, 255 * (1 - wave.age / LIFE_FRAMES));
    spot(wave, 20 + wave.age * (1 + Math.max(wave.strike_mm_s, 0) / 50));
  }
  stroke(89, 194, 255);
  for (const pointer of pointers) {
    const height = Math.min(pointer.hover_mm, HIGHEST_MM) / HIGHEST_MM;
    if (pointer.state === "hover") spot(pointer, 20 + 160 * height);
  }
  waves = older(waves);
  strokes = older(strokes);
  status.textContent = halo.connected
    ? `fingers: ${pointers.length}`
    : `waiting for ${url}: start halo serve`;
}

const older = (list) =>
  list.map((each) => ({ ...each, age: each.age + 1 })).filter(({ age }) => age < LIFE_FRAMES);

if (!window.p5) status.textContent = "put p5.min.js into this folder: see clients/web/README.md";
