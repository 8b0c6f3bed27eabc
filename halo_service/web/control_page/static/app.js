// The page: navigation, connection state, and one view at a time.

import { el } from "./dom.js";
import { Service } from "./service.js";

const VIEWS = {
  guide: "Start",
  live: "Live",
  setup: "Set up",
  settings: "Settings",
  profiles: "Profiles",
  outputs: "Outputs",
  nodes: "Nodes",
  record: "Record",
  log: "Log",
};

if (location.search.includes("token=")) history.replaceState(null, "", location.pathname + location.hash);

const service = new Service();
const main = document.getElementById("main");
const nav = document.getElementById("nav");
const state = document.getElementById("state");
const notice = document.getElementById("notice");
let leave = () => {};
let chosen = "";

for (const [name, title] of Object.entries(VIEWS)) {
  nav.append(el("a", { href: `#${name}` }, title));
}

function wanted() {
  const name = location.hash.slice(1);
  if (name in VIEWS) return name;
  let seen = null;
  try {
    seen = localStorage.getItem("halo-seen");
  } catch {
    // A browser that stores nothing shows the guide at every start.
  }
  return seen ? "live" : "guide";
}

async function open() {
  if (location.hash === "#main") return;
  const name = wanted();
  if (name === chosen) return;
  chosen = name;
  for (const link of nav.children) {
    if (link.hash === `#${name}`) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  document.title = `${VIEWS[name]} - Halo`;
  const { mount } = await import(`./views/${name}.js`);
  if (name !== chosen) return;
  leave();
  service.show([]);
  main.replaceChildren();
  leave = mount(main, service) ?? (() => {});
  if (document.activeElement?.closest("nav")) main.focus({ preventScroll: true });
  scrollTo(0, 0);
}

function showState() {
  const health = service.last.health;
  const lost = !service.connected;
  const camera = health && health.camera !== "running" ? `camera ${health.camera}` : "";
  state.textContent = lost ? "✕ no service" : camera ? `! ${camera}` : "✓ connected";
  state.className = `pill ${lost || camera ? "bad" : "good"}`;
  const hello = service.last.hello;
  document.getElementById("node").textContent = hello?.node ?? "";
  const texts = [];
  if (lost) texts.push("The service does not answer. This page connects again by itself when it runs.");
  else if (service.source === "virtual") texts.push("Virtual camera: all touches are simulated.");
  else if (service.last.scene?.recording) {
    texts.push(`The recording ${service.last.scene.recording} is replayed, not the camera. Stop it in Record.`);
  } else if (service.source === "recording") texts.push("A recording is replayed, not a camera.");
  if (!lost && hello?.role === "viewer") texts.push("You may look, but not change anything.");
  if (!lost && ["moved", "tilted", "hidden", "marker"].includes(health?.fit)) {
    texts.push(`The profile no longer fits (${health.fit}): measure the background again in Set up.`);
  }
  notice.textContent = texts.join(" ");
  notice.hidden = texts.length === 0;
}

for (const kind of ["connection", "hello", "health", "scene"]) service.on(kind, showState);
addEventListener("hashchange", open);
open();
