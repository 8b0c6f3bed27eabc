// The calibration step by step: prompts, progress, live signal and verdict of each.

import { button, card, el, toast } from "../dom.js";
import { CornerPicture } from "./setup-corners.js";
import { Guide } from "./setup-guide.js";

const STEPS = {
  camera: "Checks the camera: its height and tilt, what it measures, too bright or too dark. Clear the table first.",
  background: "Measures the empty table. Clear it, and take your hands away.",
  surface: "Your area on the table. The background step puts it in the middle of the picture. Do this step only if you want another place or size.",
  touch: "Measures your index finger. Hold it still in each of four states, a few seconds each: above the table, nearly touching, touching, pressing.",
  sweep: "Makes touches equal everywhere. Put the finger on the printed 45 degree wedge, and slide both over the whole area for 20 seconds.",
  projector: "Finds where the projector's pixels are on the table. Skip it if you have no projector.",
  anchor: "Finds a printed marker that a headset sees too. Skip it if you have no headset.",
  verify: "Checks touches: touch each crossing that the projector shows, and see the errors in mm and px. It needs the projector step.",
};
const OPTIONAL = ["surface", "projector", "anchor", "verify"];
const PRINTED = {
  surface: "Only the way 'printed sheet' needs a print: the command 'halo targets FOLDER' writes it.",
  sweep: "The wedge is a small ramp for a 3D printer: calibration/targets/wedge.scad in the source folder.",
  anchor: "The command 'halo targets FOLDER' writes the marker to print.",
};
const WAYS = {
  surface: [["view", "in the middle of the picture"], ["picture", "drag four corners in the picture"], ["markers", "printed sheet"], ["touch", "touch the corners"]],
  projector: [["markers", "projected board"], ["gray", "stripes (most exact)"], ["touch", "touch crosses"]],
};
const NUMBERS = {
  surface: [["width_mm", "width, mm", 300], ["height_mm", "height, mm", 200]],
  touch: [["hover_mm", "height of the hover spacer, mm", "", "10"], ["subtle_mm", "height of the subtle spacer, mm", "", "1"], ["touch_g", "weight of a relaxed touch, g", "", "25"], ["press_g", "weight of a medium press, g", ""], ["hard_g", "weight of a hard press, g (adds a fifth state)", ""]],
  anchor: [["marker", "number of the marker", 0], ["size_mm", "side of its black square, mm", "", "80"]],
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
    const row = new StepRow(step, words, service, corners, () => state, async () => {
      if (state && name.value.trim() !== state.profile) await use(name.value.trim());
    });
    rows.set(step, row);
    list.append(row.element);
  }

  const use = async (chosen) => show(await service.call("wizard-profile", { name: chosen }));
  const everyStart = async () => {
    await service.call("change-settings", { changes: [{ section: "", key: "profile", value: state.profile }] });
    toast(`Saved: the service uses '${state.profile}' at every start.`);
    show(await service.call("wizard"));
  };
  const show = (value) => {
    state = value;
    if (document.activeElement !== name) name.value = value.profile;
    about.replaceChildren(
      value.error ? el("p", { className: "bad" }, value.error) : "",
      value.virtual
        ? el("p", {}, "There is no camera. A virtual user does what each step asks for: press Start and watch.")
        : "",
      el("p", {}, status(value)),
      value.missing.length ? el("p", {}, `Still missing: ${value.missing.join(", ")}.`) : el("p", {}, "✓ The calibration is complete."),
      value.missing.length === 0 && service.operator
        ? el("div", { className: "row" }, el("a", { className: "button", href: "#live" }, "See touches in Live"),
          value.at_start === value.profile ? el("span", { className: "soft" }, "The service uses it at every start.") : button("Use it at every start", everyStart))
        : "",
    );
    running.replaceChildren(
      value.running
        ? el("div", { className: "row" }, el("strong", {}, `Running: ${value.running}`), button("Stop", () => service.call("wizard-stop"), { className: "danger" }))
        : "",
      value.running ? guide.element : "",
    );
    verdict.replaceChildren(
      value.verdict && !value.running
        ? card("", el("p", { className: `prompt ${value.verdict.good ? "good" : "bad"}` }, `${value.verdict.good ? "✓" : "✕"} ${value.verdict.step}`),
          ...value.verdict.text.split("\n").map((line) => el("p", {}, line)),
          value.verdict.good && value.steps[value.verdict.step]?.quality === "fair"
            ? el("p", {}, "◐ Fair: it works. Do the step again if you want better touches.")
            : "",
          value.verdict.points.length
            ? el("details", {}, el("summary", {}, "Error at each touch"), el("ul", { className: "small" }, value.verdict.points.map((line) => el("li", {}, line))))
            : "",
          value.verdict.map.length ? el("pre", { className: "map", role: "img", "aria-label": "What of the picture is measured" }, value.verdict.map.join("\n")) : "",
          value.verdict.good && following(value) && service.operator
            ? el("p", {}, button(`Next: ${title(following(value))}`, () => rows.get(following(value)).run(), { className: "main", off: () => Boolean(state.running) }))
            : "")
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
        service.operator ? button("Use this name", () => use(name.value.trim())) : ""),
      el("p", { className: "soft" }, "A profile stores what the steps measure: one camera, one table, one finger. The name is yours to choose."),
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

function status({ profile, exists, in_use }) {
  if (in_use === profile) return `The service uses the profile '${profile}'.`;
  const other = in_use ? `The service uses the profile '${in_use}' now.` : "The service uses no profile now, so it finds no touches.";
  return exists
    ? `${other} '${profile}' is another one; the service changes to it after the next step, or in Profiles.`
    : `${other} '${profile}' does not exist yet: the background step makes it, and the service then uses it.`;
}

const when = (date) => new Date(date).toLocaleString([], { dateStyle: "medium", timeStyle: "short" });

function result({ quality, text, date, by_background, outdated }) {
  if (by_background) return `◦ ${text}`;
  const mark = outdated ? "! done before a later step, so do it again" : quality === "good" ? "✓ good" : "◐ fair";
  return `${mark}, ${when(date)}. ${text}`;
}

// The next step that is not done; undefined: all are, but for optional ones.
const following = (state) => Object.keys(STEPS).find((step) => !state.steps[step] && !OPTIONAL.includes(step));

class StepRow {
  constructor(step, words, service, corners, state, ready) {
    Object.assign(this, { step, service, corners, ready });
    this.result = el("p", { className: "small" });
    this.extra = el("div");
    this.inputs = new Map();
    const optional = OPTIONAL.includes(step) ? el("span", { className: "soft" }, " (optional)") : "";
    this.start = button("Start", () => this.run(), { "aria-label": `Start ${step}`, off: () => Boolean(state()?.running) });
    this.element = el(
      "li",
      {},
      el("h3", {}, title(step), optional),
      el("p", { className: "soft" }, words),
      PRINTED[step] ? el("p", { className: "soft small" }, PRINTED[step]) : "",
      this.options(),
      this.extra,
      el("div", { className: "row" }, service.operator ? this.start : ""),
      this.result,
    );
    if (step === "projector" || step === "verify") {
      this.screen = el("p", { className: "small" });
      this.extra.append(
        el("p", {}, el("a", { className: "button", href: "/projector.html", target: "_blank", rel: "noopener" }, "Open the projector page"), " Move it to the projector's screen, and make it full screen."),
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
    const numbers = (NUMBERS[this.step] ?? []).map(([key, words, value, usual]) => {
      const id = `${this.step}-${key}`;
      const input = el("input", { id, type: "number", step: "any", min: 0, value, placeholder: usual });
      this.inputs.set(key, input);
      return el("div", { className: "row" }, el("label", { htmlFor: id }, words), input);
    });
    if (numbers.length === 0) return parts;
    if (this.step === "touch") {
      const words = "With spacers under the finger and a kitchen scale, heights and forces become exact. Without them the service assumes 10 mm, 1 mm and 25 g.";
      return [el("details", {}, el("summary", {}, "I have spacers or a kitchen scale"), el("p", { className: "soft" }, words), numbers)];
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
    await this.ready();
    this.service.value(await this.service.call("wizard-run", request));
    document.getElementById("running").scrollIntoView({ behavior: "smooth" });
  }

  show(state) {
    if (this.step === "camera") {
      const { serial, depth_mode, fps } = this.service.last.hello ?? {};
      if (serial) this.extra.replaceChildren(el("p", { className: "small" }, `Camera ${serial}, ${depth_mode}, ${fps} frames a second. Another one: Settings, Source.`));
    }
    const found = state.steps[this.step];
    this.result.textContent = found ? result(found) : "";
    this.start.textContent = found && !found.by_background ? "Do it again" : "Start";
    this.start.classList.toggle("main", following(state) === this.step);
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
