// The first look: what this is, and the three next steps.

import { card, el } from "../dom.js";

const CALIBRATED = { complete: "complete", partial: "not complete yet: open Set up" };

export function mount(root, service) {
  const about = el("div");
  const cameras = el("ul", { "aria-label": "Cameras that are plugged in" });
  root.append(
    el("h1", {}, "Touch on any table"),
    about,
    el(
      "div",
      { className: "cards" },
      card(
        "1. Connect your program",
        el("p", {}, "Unity, TouchDesigner, Max, Pure Data, a browser or your own code receives the touches by OSC, TUIO, WebSocket or Zenoh."),
        el("p", {}, "Send a test pattern first: a pointer that draws a circle."),
        el("a", { className: "button", href: "#outputs" }, "Open Outputs"),
      ),
      card(
        "2. Try it without a camera",
        el("p", {}, "Without a camera the service simulates one, with a hand that touches and hovers. Everything on this page works with it, Set up too."),
        el("a", { className: "button", href: "#live" }, "Open Live"),
      ),
      card(
        "3. Set up your camera",
        el("p", {}, "Mount an Orbbec Femto Bolt or Mega, or an Azure Kinect, 45 to 70 cm above the table. It looks down. Set up measures the table and your finger, step by step, in a few minutes."),
        cameras,
        el("a", { className: "button", href: "#setup" }, "Open Set up"),
      ),
    ),
  );
  const show = () => {
    const { hello, scene } = service.last;
    if (!hello || !scene) return;
    const words = {
      virtual: "No camera is used now. A virtual camera shows a simulated hand above a simulated table, with the noise of the real sensor. The touches are not real.",
      camera: `The camera ${hello.serial} is used.`,
      recording: "A recording is replayed instead of a camera.",
    };
    const own = scene.profile === "virtual" && scene.source === "virtual" ? " (the service made it for the virtual table)" : "";
    const profile = scene.profile
      ? `The service uses the profile '${scene.profile}'${own}. Its calibration is ${CALIBRATED[scene.calibrated]}.`
      : "There is no profile yet, so no touch is found: open Set up.";
    about.replaceChildren(card("Now", el("p", {}, words[scene.source]), el("p", {}, profile)));
  };
  show();
  list(cameras, service);
  try {
    localStorage.setItem("halo-seen", "1");
  } catch {
    // See app.js.
  }
  const stops = [service.on("hello", show), service.on("scene", show)];
  return () => stops.forEach((stop) => stop());
}

// What is plugged in, and what each camera lacks.
async function list(cameras, service) {
  let found = [];
  try {
    ({ cameras: found } = await service.call("cameras"));
  } catch {
    return;
  }
  const lines = found.map((each) => `${each.title} ${each.serial}: ${each.fault || `start the service with ${each.source}`}`);
  cameras.replaceChildren(...(lines.length ? lines : ["No camera is plugged in."]).map((line) => el("li", {}, line)));
}
