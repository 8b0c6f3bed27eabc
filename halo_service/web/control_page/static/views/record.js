// Record what the camera sees, to replay it later.

import { button, card, el, table, toast } from "../dom.js";

const EVERY_MS = 1000;

export function mount(root, service) {
  const state = el("div", { role: "status" });
  const files = el("div");
  const colour = el("input", { type: "checkbox", id: "record-colour" });
  let shown = "";
  const load = async () => {
    const read = await service.call("recordings");
    const now = JSON.stringify(read);
    if (now === shown) return;
    shown = now;
    state.replaceChildren(
      !service.operator
        ? el("p", { className: "soft" }, "Only the operator's page can record.")
        : read.running
          ? el("div", { className: "row" }, el("strong", { className: "bad" }, "● recording"), button("Stop", act("stop-recording", {}), { className: "main" }))
          : el("div", { className: "row" }, button("Record", () => act("start-recording", { colour: colour.checked })(), { className: "main" }), colour, el("label", { htmlFor: "record-colour" }, "with colour")),
      read.result ? el("p", {}, `The last recording: ${read.result}.`) : "",
    );
    files.replaceChildren(
      read.recordings.length
        ? table(["file", "MB", "to replay it as a camera"], read.recordings.map(({ name, path, bytes }) => [name, (bytes / 1e6).toFixed(0), el("code", {}, `halo serve --source "recording:${path}"`)]), [1])
        : el("p", {}, "There is no recording yet."),
    );
  };
  const act = (name, body) => async () => {
    await service.call(name, body);
    await load();
  };
  root.append(
    el("h1", {}, "Record"),
    card("", el("p", {}, "A recording holds every depth and infrared picture, about 15 MB a second. It ends after ten minutes. Faces that the camera sees are in it, with colour above all."), state),
    card("Recordings", files),
  );
  load().catch((error) => toast(error.message));
  const timer = setInterval(() => load().catch(() => {}), EVERY_MS);
  return () => clearInterval(timer);
}
