// Record what the camera sees, and replay it in the camera's place.

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
      ...(service.operator ? controls(read) : [el("p", { className: "soft" }, "Only the operator's page can record and replay.")]),
      read.result ? el("p", {}, `The last recording: ${read.result}.`) : "",
    );
    files.replaceChildren(
      read.recordings.length
        ? table(["recording", "size, MB", "replay"], read.recordings.map((each) => [each.name, (each.bytes / 1e6).toFixed(0), choice(each, read)]), [1])
        : el("p", {}, "There is no recording yet."),
      read.recordings.length
        ? el("p", { className: "small soft" }, "A replay uses the current profile and settings, and goes to all outputs. It repeats until you stop it. The files are in ", el("code", {}, folder(read.recordings[0].path)), ".")
        : "",
    );
  };
  const controls = (read) => [
    read.running
      ? el("div", { className: "row" }, el("strong", { className: "bad" }, `● recording ${read.writes}`), button("Stop recording", act("stop-recording"), { className: "main" }))
      : read.replayed
        ? el("div", { className: "row" }, el("strong", {}, `▶ ${read.replayed} is replayed instead of the camera.`), button("Stop the replay", act("stop-replay"), { className: "main" }), el("a", { className: "button", href: "#live" }, "Open Live"))
        : el("div", { className: "row" }, button("Record", () => act("start-recording", { colour: colour.checked })(), { className: "main" }), colour, el("label", { htmlFor: "record-colour" }, "with colour")),
  ];
  const choice = ({ name }, read) =>
    name === read.replayed
      ? "▶ now"
      : service.operator && !read.running
        ? button("Replay", act("replay", { name }), { "aria-label": `Replay ${name}` })
        : "";
  const act = (name, body = {}) => async () => {
    await service.call(name, body);
    await load();
  };
  root.append(
    el("h1", {}, "Record"),
    card("", el("p", {}, "A recording contains every depth and infrared picture, about 15 MB a second. It ends after ten minutes. It shows the people that the camera sees, above all with colour."), state),
    card("Recordings", files),
  );
  load().catch((error) => toast(error.message));
  const timer = setInterval(() => load().catch(() => {}), EVERY_MS);
  return () => clearInterval(timer);
}

const folder = (path) => path.replace(/[\\/][^\\/]*$/, "");
