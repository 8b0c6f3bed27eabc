// Profiles: which there are, what is in them, and copies of them.

import { button, card, el, table, toast } from "../dom.js";

export function mount(root, service) {
  const place = el("div");
  const compare = el("div");
  const chosen = new Set();
  let atStart = "";
  const load = async () => {
    const { profiles, in_use, at_start, error } = await service.call("profiles");
    atStart = at_start;
    for (const name of chosen) if (!profiles.some((each) => each.name === name)) chosen.delete(name);
    place.replaceChildren(
      error ? el("p", { className: "bad" }, error) : "",
      profiles.length === 0
        ? card("", el("p", {}, "There is no profile of yours yet. Set up writes one. (The virtual camera's own is not listed.)"), el("a", { className: "button", href: "#setup" }, "Open Set up"))
        : el("div", { className: "cards" }, profiles.map((each) => profileCard(each, each.name === in_use))),
      service.operator ? importer() : "",
    );
    showCompared(profiles);
  };
  const act = (name, body) => async () => {
    await service.call(name, body);
    await load();
  };
  const profileCard = (profile, used) => {
    const { name } = profile;
    if (profile.error) return card(name, el("p", { className: "bad" }, profile.error), ...controls(name, used, false));
    const box = el("input", { type: "checkbox", id: `compare-${name}`, checked: chosen.has(name), onchange: () => { box.checked ? chosen.add(name) : chosen.delete(name); load(); } });
    return card(
      name,
      el("p", {}, used ? "● in use now. " : "", name === atStart ? "Used at every start. " : "", `Calibration ${profile.calibrated}, revision ${profile.revision}.`),
      el("ul", { className: "small" }, sorted(profile.steps).map(([step, { quality, date }]) =>
        el("li", {}, `${step}: ${quality}, ${new Date(date).toLocaleString([], { dateStyle: "medium", timeStyle: "short" })}`))),
      el("p", {}, box, " ", el("label", { htmlFor: box.id }, `show details of ${name}`)),
      ...controls(name, used, true),
    );
  };
  const controls = (name, used, readable) => {
    const save = async () => download(await service.call("export-profile", { name }), `${name}.halo-profile`);
    if (!service.operator) return [];
    const to = el("input", { type: "text", size: 12, maxLength: 64, "aria-label": `New name for ${name}`, placeholder: "new name" });
    return [
      el(
        "div",
        { className: "row" },
        readable && !used ? button("Use", async () => { await service.call("use-profile", { name }); setTimeout(load, 1200); }, { className: "main" }) : null,
        readable && name !== atStart
          ? button("Use at every start", act("change-settings", { changes: [{ section: "", key: "profile", value: name }] }))
          : null,
        readable ? button("Export", save) : null,
        used ? null : button("Delete", async () => { if (confirm(`Delete the profile ${name}?`)) await act("delete-profile", { name })(); }, { className: "danger" }),
      ),
      readable ? el("div", { className: "row" }, to, button("Copy", () => act("copy-profile", { name, to: to.value })()), used ? null : button("Rename", () => act("rename-profile", { name, to: to.value })())) : "",
    ];
  };
  const importer = () => {
    const file = el("input", { type: "file", id: "import-file", accept: ".halo-profile" });
    return card(
      "Import",
      el("label", { htmlFor: "import-file" }, "A profile that was exported here or by 'halo profile export'"),
      el("div", { className: "row" }, file, button("Import", async () => {
        if (!file.files[0]) throw new Error("Choose a file first.");
        const { name } = await service.call("import-profile", new Blob([file.files[0]]));
        toast(`Imported as ${name}.`);
        await load();
      })),
    );
  };
  const showCompared = (profiles) => {
    const shown = profiles.filter((each) => chosen.has(each.name) && !each.error);
    compare.replaceChildren();
    if (shown.length === 0) return;
    const keys = [];
    const cells = shown.map(({ facts, results }) => {
      const found = new Map();
      for (const [key, value] of [...facts, ...results]) found.set(key, [...(found.get(key) ?? []), value]);
      for (const key of found.keys()) if (!keys.includes(key)) keys.push(key);
      return found;
    });
    compare.append(card("Details", table(["", ...shown.map((each) => each.name)], keys.map((key) =>
      [key, ...cells.map((found) => el("div", {}, (found.get(key) ?? ["-"]).map((line) => el("div", {}, line))))]))));
  };
  root.append(el("h1", {}, "Profiles"), el("p", {}, "A profile is the calibration of one camera, table and finger. Show the details of two profiles to compare them."), place, compare);
  load().catch((error) => toast(error.message));
  return service.on("scene", () => load().catch(() => {}));
}

const ORDER = ["camera", "background", "surface", "touch", "sweep", "projector", "anchor", "verify"];
const sorted = (steps) => Object.entries(steps).sort(([a], [b]) => ORDER.indexOf(a) - ORDER.indexOf(b));

function download(blob, name) {
  const link = el("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
