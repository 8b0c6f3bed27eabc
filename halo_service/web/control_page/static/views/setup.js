// How to set up a camera.

import { card, el } from "../dom.js";

export function mount(root) {
  root.append(
    el("h1", {}, "Set up"),
    card("", el("p", {}, "Calibrate in a terminal, then choose the profile in Profiles:"), el("pre", {}, "halo calibrate --profile desk")),
  );
}
