// What the service senses now: the surface from above, the last ten seconds, health, pictures.

import { card, el, table } from "../dom.js";
import { Health } from "./live-health.js";
import { Pictures } from "./live-pictures.js";
import { Strip } from "./live-strip.js";
import { SurfaceView } from "./live-surface.js";

export function mount(root, service) {
  const surface = new SurfaceView();
  const strip = new Strip();
  const health = new Health();
  const pictures = new Pictures(service);
  const list = el("div");
  const facts = el("p", { className: "soft small" });
  root.append(
    el("h1", {}, "Live"),
    el(
      "div",
      { className: "grid" },
      el("div", {}, card("Surface from above", surface.element, facts), card("Last ten seconds", strip.element)),
      el("div", {}, card("Fingers", list), card("Health", health.element)),
    ),
    card("Pictures", pictures.element),
  );
  const showScene = (scene) => {
    surface.scene = scene;
    strip.thresholds = scene.thresholds;
    facts.textContent =
      `Surface '${scene.surface}', ${Math.round(scene.width_mm)} × ${Math.round(scene.height_mm)} mm. ` +
      (scene.profile ? `Profile '${scene.profile}', calibration ${scene.calibrated}, revision ${scene.revision}.` : "No profile, so no touch is found: open Set up.") +
      (scene.projector ? " The dashed line is the projector's picture." : "");
  };
  let listed = 0;
  const showFrame = (frame) => {
    surface.add(frame);
    strip.add(frame);
    if (performance.now() - listed > 250) {
      listed = performance.now();
      list.replaceChildren(fingers(frame.pointers, surface.scene));
    }
  };
  if (service.last.scene) showScene(service.last.scene);
  if (service.last.health) health.show(service.last.health);
  list.replaceChildren(fingers([], surface.scene));
  const stops = [
    service.on("scene", showScene),
    service.on("frame", showFrame),
    service.on("health", (value) => health.show(value)),
    service.on("connection", () => surface.clear()),
  ];
  let drawn = requestAnimationFrame(function draw() {
    surface.draw();
    strip.draw();
    drawn = requestAnimationFrame(draw);
  });
  return () => {
    cancelAnimationFrame(drawn);
    stops.forEach((stop) => stop());
    pictures.close();
  };
}

const round = (value, unit) => (value === null ? "-" : `${Math.round(value)} ${unit}`);

function fingers(pointers, { calibrated }) {
  if (pointers.length === 0) {
    const ready = calibrated === undefined || calibrated === "complete";
    return el("p", { className: "soft" }, ready ? "No finger is near the surface." : "No touch is found before the touch step is done: open Set up.");
  }
  return table(
    ["no.", "finger", "state", "height", "force", "confidence"],
    pointers.map((each) => [
      `${each.slot}`,
      `${each.side} ${each.finger}`,
      each.touch ? "● touch" : "○ hover",
      round(each.hover_mm, "mm"),
      each.touch ? round(each.force_g, "g") : "-",
      `${Math.round(100 * each.confidence)} %`,
    ]),
    [3, 4, 5],
  );
}
