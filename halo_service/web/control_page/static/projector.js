// Shows the set-up's patterns, pixel for pixel, in the projector's browser.

import { Service } from "./service.js";

const canvas = document.getElementById("picture");
const hint = document.getElementById("hint");
const service = new Service();

// The projector's own pixels: a scaled desktop has more of them than CSS pixels.
const size = () => [Math.round(innerWidth * devicePixelRatio), Math.round(innerHeight * devicePixelRatio)];

function report() {
  const [width, height] = size();
  document.getElementById("size").textContent = `${width} × ${height} pixels`;
  if (service.connected) service.send({ projector: [width, height] });
}

document.getElementById("full").addEventListener("click", () => document.documentElement.requestFullscreen());
document.addEventListener("fullscreenchange", () => {
  hint.hidden = document.fullscreenElement !== null;
  report();
});
addEventListener("resize", report);
service.on("connection", report);

service.on("picture", async ({ header, image }) => {
  if (header.kind !== "projector") return;
  const bitmap = await createImageBitmap(image);
  canvas.width = bitmap.width;
  canvas.height = bitmap.height;
  canvas.getContext("2d").drawImage(bitmap, 0, 0);
  bitmap.close();
  hint.hidden = true;
  // Two frames of the screen later it is certainly shown.
  requestAnimationFrame(() => requestAnimationFrame(() => service.send({ drawn: header.number })));
});
