// A table in 3D: a ball above it for each finger, at its height, and a hill where a finger presses.
// Units are metres: x to the right, y up, z towards the user.

import * as THREE from "three";
import { connect } from "../halo.js";

const RADIUS_M = 0.008;
const HILL_M = 0.04; // Height of a hill at a pressure of 1.
const WIDE_M = 0.02; // Its width.
const status = document.querySelector("#status");
let size = { width_mm: 300, height_mm: 200 };
let pointers = [];
const balls = new Map(); // id of a finger -> its ball

// `index.html?ws://192.168.1.5:4258/halo` opens another service.
const url = decodeURIComponent(location.search.slice(1)) || "ws://127.0.0.1:4258/halo";
const halo = connect(url, {
  frame: (frame) => (pointers = frame.pointers),
  report: (report) => {
    if (report.kind === "scene" && isNewSize(report)) resize(report);
  },
  lost: () => (pointers = []),
});

const renderer = new THREE.WebGLRenderer({ antialias: true });
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(0x101418);
const camera = new THREE.PerspectiveCamera(40, 1, 0.01, 10);
camera.position.set(0, 0.35, 0.35);
camera.lookAt(0, 0, 0);
scene.add(new THREE.HemisphereLight(0xcfe4ff, 0x20262e, 2));
const sun = new THREE.DirectionalLight(0xffffff, 2);
sun.position.set(0.3, 1, 0.2);
scene.add(sun);
const table = new THREE.Mesh(
  new THREE.BufferGeometry(),
  new THREE.MeshStandardMaterial({ color: 0x3a4654, flatShading: true }),
);
scene.add(table);
resize(size);

const isNewSize = ({ width_mm, height_mm }) =>
  width_mm !== size.width_mm || height_mm !== size.height_mm;

function resize(report) {
  size = report;
  table.geometry.dispose();
  table.geometry = new THREE.PlaneGeometry(size.width_mm / 1000, size.height_mm / 1000, 75, 50);
  table.geometry.rotateX(-Math.PI / 2);
}

// Where a finger is, in metres; the origin is the centre of the table.
function placeOf({ u, v, hover_mm }) {
  return [((u - 0.5) * size.width_mm) / 1000, hover_mm / 1000, ((v - 0.5) * size.height_mm) / 1000];
}

function moveBalls() {
  for (const [id, ball] of balls) {
    if (pointers.some((pointer) => pointer.id === id)) continue;
    scene.remove(ball);
    balls.delete(id);
  }
  for (const pointer of pointers) {
    if (!balls.has(pointer.id)) balls.set(pointer.id, newBall());
    const ball = balls.get(pointer.id);
    const [x, y, z] = placeOf(pointer);
    ball.position.set(x, y + RADIUS_M + HILL_M * pointer.pressure, z);
    ball.material.color.set(pointer.state === "touch" ? 0xffb454 : 0x59c2ff);
  }
}

function newBall() {
  const ball = new THREE.Mesh(
    new THREE.SphereGeometry(RADIUS_M, 24, 16),
    new THREE.MeshStandardMaterial(),
  );
  scene.add(ball);
  return ball;
}

function shapeTable() {
  const places = table.geometry.attributes.position;
  const pressing = pointers.filter(({ state }) => state === "touch");
  const hills = pressing.map((pointer) => [...placeOf(pointer), HILL_M * pointer.pressure]);
  for (let i = 0; i < places.count; i++) {
    let height = 0;
    for (const [x, , z, hill] of hills) {
      const squared = (places.getX(i) - x) ** 2 + (places.getZ(i) - z) ** 2;
      height += hill * Math.exp(-squared / WIDE_M ** 2);
    }
    places.setY(i, height);
  }
  places.needsUpdate = true;
}

renderer.setAnimationLoop(() => {
  renderer.setSize(innerWidth, innerHeight);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
  moveBalls();
  shapeTable();
  renderer.render(scene, camera);
  status.textContent = halo.connected
    ? `fingers: ${pointers.length}`
    : `waiting for ${url}: start halo serve`;
});
