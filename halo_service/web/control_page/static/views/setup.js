// The calibration step by step: prompts, progress, live signal and verdict of each.

import { button, card, el, toast } from "../dom.js";
import { CornerPicture } from "./setup-corners.js";
import { Guide } from "./setup-guide.js";

const STEPS = {
  camera: "Where it is, what it measures, how bright it is. Nothing is stored.",
  background: "The empty surface. Clear it, and keep hands away.",
  surface: "Where your area is on the table. It is put in the middle of the picture; choose another way to place it yourself. 'halo targets' writes the sheet to print.",
  touch: "Hold your index finger in each state that is asked for, still, for a few seconds.",
  sweep: "Put the finger on the printed 45 degree wedge (calibration/targets), and slide both over the whole surface, for even touches everywhere.",
  projector: "Where its pixels are on the surface. Skip it without a projector.",
  anchor: "A printed marker that a headset sees too; 'halo targets' writes it. Skip it without a headset.",
  verify: "Touch each projected crossing, and see the errors in mm and px. It needs the projector.",
};
const OPTIONAL = ["projector", "anchor", "verify"];
const WAYS = {
  surface: [["view", "in the middle of the picture"], ["picture", "drag four corners in the picture"], ["markers", "printed sheet"], ["touch", "touch the corners"]],
  projector: [["markers", "projected board"], ["gray", "stripes (most exact)"], ["touch", "touch crosses"]],
};
const NUMBERS = {
  surface: [["width_mm", "width, mm", 300], ["height_mm", "height, mm", 200]],
  touch: [["hover_mm", "height of the hover spacer, mm", ""], ["subtle_mm", "height of the subtle spacer, mm", ""], ["touch_g", "relaxed touch, g", ""], ["press_g", "press on a kitchen scale, g", ""], ["hard_g", "hold a hard press too, g", ""]],
  anchor: [["marker", "number of the marker", 0], ["size_mm", "side of its black square, mm", ""]],
};

export function mount(root, service) {
  const name = el("input", { type: "text", id: "profile-name", maxLength: 64, size: 16 });
  const about = el("div");
  const guide = new Guide();
  const rows = new Map();
  const list = el("ol", { className: "steps" });
  const verdict = el("div", { role: "status" });
  const running = el("div", { id: "running" });
  const corners = new CornerPicture(service);
  let state = null;

  for (const [step, words] of Object.entries(STEPS)) {
    const row = new StepRow(step, words, service, corners, () => state);
    rows.set(step, row);
    list.append(row.element);
  }

  const show = (value) => {
    state = value;
    if (document.activeElement !== name) name.value = value.profile;
    about.replaceChildren(
      value.error ? el("p", { className: "bad" }, value.error) : "",
      value.virtual
        ? el("p", {}, "There is no camera, so a virtual user follows the prompts. You see what a person would do, and how long it takes.")
        : "",
      el("p", {}, value.missing.length ? `Still missing: ${value.missing.join(", ")}.` : "✓ The calibration is complete."),
    );
    running.replaceChildren(
      value.running
        ? el("div", { className: "row" }, el("strong", {}, `Running: ${value.running}`), button("Stop", () => service.call("wizard-stop"), { className: "danger" }))
        : "",
      value.running ? guide.element : "",
    );
    verdict.replaceChildren(
      value.verdict && !value.running
        ? card("", el("p", { className: `prompt ${value.verdict.good ? "good" : "bad"}` }, `${value.verdict.good ? "✓" : "✕"} ${value.verdict.step}`), ...value.verdict.text.split("\n").map((line) => el("p", {}, line)))
        : "",
      value.can_undo && service.operator
        ? el("p", {}, button("Undo the last step", async () => show(await service.call("wizard-undo"))))
        : "",
    );
    for (const row of rows.values()) row.show(value);
    if (!value.running) guide.clear();
  };

  root.append(
    el("h1", {}, "Set up"),
    card(
      "Profile",
      el("div", { className: "row" }, el("label", { htmlFor: "profile-name" }, "Name"), name,
        service.operator ? button("Use this name", async () => show(await service.call("wizard-profile", { name: name.value.trim() }))) : ""),
      about,
    ),
    running,
    verdict,
    card("Steps", list),
  );
  const stops = [service.on("wizard", show), service.on("guide", (value) => guide.show(value))];
  const load = () => service.call("wizard").then(show).catch((error) => toast(error.message));
  stops.push(service.on("connection", (on) => on && load()));
  load();
  return () => {
    stops.forEach((stop) => stop());
    corners.close();
  };
}

const title = (step) => `${Object.keys(STEPS).indexOf(step) + 1}. ${step[0].toUpperCase()}${step.slice(1)}`;

class StepRow {
  constructor(step, words, service, corners, state) {
    Object.assign(this, { step, service, corners });
    this.result = el("p", { className: "small" });
    this.extra = el("div");
    this.inputs = new Map();
    const optional = OPTIONAL.includes(step) ? el("span", { className: "soft" }, " (optional)") : "";
    this.start = button("Start", () => this.run(), { className: "main", "aria-label": `Start ${step}`, off: () => Boolean(state()?.running) });
    this.element = el(
      "li",
      {},
      el("h3", {}, title(step), optional),
      el("p", { className: "soft" }, words),
      this.options(),
      this.extra,
      el("div", { className: "row" }, service.operator ? this.start : ""),
      this.result,
    );
    if (step === "projector" || step === "verify") {
      this.screen = el("p", { className: "small" });
      this.extra.append(
        el("p", {}, el("a", { className: "button", href: "/projector.html", target: "_blank", rel: "noopener" }, "Open the projector page"), " on the projector's screen, and make it full screen."),
        this.screen,
      );
    }
  }

  options() {
    const parts = [];
    if (WAYS[this.step]) {
      const id = `by-${this.step}`;
      this.by = el("select", { id, onchange: () => this.showCorners() }, WAYS[this.step].map(([value, words]) => el("option", { value }, words)));
      parts.push(el("div", { className: "row" }, el("label", { htmlFor: id }, "Way"), this.by));
    }
    const numbers = (NUMBERS[this.step] ?? []).map(([key, words, value]) => {
      const id = `${this.step}-${key}`;
      const input = el("input", { id, type: "number", step: "any", min: 0, value });
      this.inputs.set(key, input);
      return el("div", { className: "row" }, el("label", { htmlFor: id }, words), input);
    });
    if (numbers.length === 0) return parts;
    if (this.step === "touch") {
      return [el("details", {}, el("summary", {}, "What you measured (for heights and forces in mm and g)"), numbers)];
    }
    return [...parts, ...numbers];
  }

  showCorners() {
    if (this.step !== "surface") return;
    if (this.by.value === "picture") {
      this.extra.replaceChildren(this.corners.element);
      this.corners.open();
    } else {
      this.extra.replaceChildren();
      this.corners.close();
    }
  }

  async run() {
    const request = { step: this.step };
    if (this.by) request.by = this.by.value;
    for (const [key, input] of this.inputs) {
      if (input.value !== "") request[key] = Number(input.value);
    }
    if (request.by === "picture") request.corners_px = this.corners.corners();
    this.service.value(await this.service.call("wizard-run", request));
    document.getElementById("running").scrollIntoView({ behavior: "smooth" });
  }

  show(state) {
    const quality = state.qualities[this.step];
    const mark = { good: "✓ ", fair: "◐ " }[quality] ?? "";
    this.result.textContent = state.steps[this.step] ? mark + state.steps[this.step] : "";
    this.start.textContent = quality ? "Do it again" : "Start";
    this.start.disabled = Boolean(state.running);
    if (this.screen) {
      this.screen.textContent = state.screen
        ? `✓ The projector page is open, ${state.screen.join(" × ")} pixels.`
        : state.virtual
          ? "The virtual projector is used; the projector page shows the same."
          : "✕ The projector page is not open.";
    }
  }
}
