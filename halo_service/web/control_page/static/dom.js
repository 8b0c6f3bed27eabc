// Builds elements; text is always text, never HTML.

export function el(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name in made && !name.startsWith("aria")) made[name] = value;
    else made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.flat().filter((each) => each !== null && each !== undefined));
  return made;
}

export const card = (title, ...children) =>
  el("section", { className: "card" }, title && el("h2", {}, title), ...children);

// `off`: whether the button stays disabled after the call.
export function button(text, run, { off = () => false, ...properties } = {}) {
  const made = el("button", { type: "button", ...properties }, text);
  made.addEventListener("click", async () => {
    made.disabled = true;
    try {
      await run();
    } catch (error) {
      toast(error.message);
    } finally {
      made.disabled = off();
    }
  });
  return made;
}

export function table(heads, rows, numbers = []) {
  const kind = (n) => (numbers.includes(n) ? "number" : "");
  return el(
    "div",
    { className: "scroll", tabIndex: 0, role: "group", "aria-label": "Table" },
    el(
      "table",
      {},
      el("thead", {}, el("tr", {}, heads.map((each, n) => el("th", { scope: "col", className: kind(n) }, each)))),
      el("tbody", {}, rows.map((row) => el("tr", {}, row.map((each, n) => el("td", { className: kind(n) }, each))))),
    ),
  );
}

let fading;
export function toast(text) {
  const shown = document.getElementById("toast");
  shown.textContent = text;
  shown.hidden = false;
  clearTimeout(fading);
  fading = setTimeout(() => (shown.hidden = true), 9000);
}

// The colours of the style sheet, for canvases; read again when light and dark change.
let colours;
export function colour(name) {
  if (!colours) {
    colours = new Map();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => colours.clear());
  }
  if (!colours.has(name)) {
    colours.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  }
  return colours.get(name);
}

// A canvas with as many pixels as the screen shows; returns its context and size in CSS pixels.
export function fitted(canvas, aspect) {
  const width = canvas.clientWidth || 300;
  const height = Math.round(width * aspect);
  const scale = devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
  }
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  return { context, width, height };
}
