// All settings as forms, made from the JSON schema of halo.toml.

import { button, el, toast } from "../dom.js";

const TITLES = { "": "Service", source: "Source", osc: "OSC", tuio: "TUIO", zenoh: "Zenoh", web: "WebSocket and OSCQuery", page: "This page", control: "Control port", sensing: "Touch and hover", tracking: "Hand tracking" };
const ORDER = ["sensing", "osc", "tuio", "", "source", "tracking", "zenoh", "web", "page", "control"];

export function mount(root, service) {
  const place = el("div", {}, el("p", {}, "Loading."));
  root.append(el("h1", {}, "Settings"), place);
  let open = "sensing";
  const load = async () => {
    const read = await service.call("settings");
    const forms = sections(read.schema).map(([section, properties]) =>
      new Form(service, read, section, properties, (name) => { open = name; return load(); }),
    );
    forms.sort((a, b) => rank(a.section) - rank(b.section));
    place.replaceChildren(
      el("p", {}, read.exists ? "Save writes to " : "Save makes the file ", el("code", {}, read.file), ". Your comments in it and its order stay."),
      ...forms.map((form) => form.element(form.section === open)),
    );
  };
  load().catch((error) => toast(error.message));
}

const rank = (section) => (ORDER.includes(section) ? ORDER.indexOf(section) : ORDER.length);

// [section, properties] of the schema; the section "" has what is at the top of the file.
function sections(schema) {
  const top = {};
  const found = [];
  for (const [name, property] of Object.entries(schema.properties)) {
    const reference = property.$ref ?? property.allOf?.[0]?.$ref;
    if (reference) found.push([name, schema.$defs[reference.split("/").pop()].properties]);
    else top[name] = property;
  }
  return [["", top], ...found];
}

class Form {
  constructor(service, read, section, properties, reload) {
    Object.assign(this, { service, read, section, properties, reload });
    this.inputs = new Map();
    this.changed = new Set();
  }

  of(values) {
    return this.section ? values[this.section] : values;
  }

  element(open) {
    const atOnce = this.read.at_once.includes(this.section);
    const save = button("Save", () => this.save(), { className: "main" });
    const fields = Object.entries(this.properties).map(([key, property]) => this.field(key, property));
    const controls = this.service.operator
      ? el("div", { className: "row" }, save, el("span", { className: "soft small" }, atOnce ? "Changes are used at once." : "Changes are used after the service starts again."))
      : el("p", { className: "soft" }, "Only the operator's page can change these.");
    return el(
      "details",
      { className: "card", open },
      el("summary", {}, el("strong", {}, TITLES[this.section] ?? this.section), el("span", { className: "soft" }, this.section ? ` [${this.section}]` : "")),
      fields,
      controls,
    );
  }

  field(key, property) {
    const id = `set-${this.section}-${key}`;
    const value = this.of(this.read.values)[key];
    const standard = this.of(this.read.defaults)[key];
    const running = this.of(this.read.running)[key];
    const input = control(id, property, value, !this.service.operator);
    this.inputs.set(key, { input, property });
    const words = el("span", { className: "soft small" });
    const row = el(
      "div",
      { className: "setting" },
      el("label", { htmlFor: id }, named(key), property.unit ? `, ${property.unit}` : ""),
      el("span", { className: "soft small" }, ` ${key}`),
      el("p", { className: "help", id: `${id}-help` }, described(property.description ?? "")),
      el("div", { className: "row" }, input, words),
    );
    input.setAttribute("aria-describedby", `${id}-help`);
    const describe = () => {
      const differs = !same(read(input, property), standard);
      words.replaceChildren(
        `default: ${shown(standard)}`,
        same(running, value) ? "" : ` · the service uses ${shown(running)} now`,
      );
      if (differs && this.service.operator) {
        const back = el("button", { type: "button", className: "small", onclick: () => { write(input, property, standard); note(); } }, "Default");
        back.setAttribute("aria-label", `Default for ${key}`);
        words.append(" ", back);
      }
    };
    const note = () => {
      const changed = !same(read(input, property), value);
      row.classList.toggle("changed", changed);
      if (changed) this.changed.add(key);
      else this.changed.delete(key);
      describe();
    };
    input.addEventListener("input", note);
    describe();
    return row;
  }

  async save() {
    const changes = [...this.changed].map((key) => {
      const { input, property } = this.inputs.get(key);
      const value = read(input, property);
      const back = same(value, this.of(this.read.defaults)[key]);
      return { section: this.section, key, value: back ? null : value };
    });
    if (changes.length === 0) return toast("Nothing is changed.");
    const { later } = await this.service.call("change-settings", { changes });
    toast(later.length ? "Saved. Start the service again to use it." : "Saved, and used from now on.");
    await this.reload(this.section);
  }
}

const UNIT = /_(mm_s|mm|ms|s|g)$/;
const named = (key) => key.replace(UNIT, "").replaceAll("_", " ");

// Text with `code` in it.
const described = (text) => text.split("`").map((part, n) => (n % 2 ? el("code", {}, part) : part));

const kind = (property) => property.type ?? (property.enum ? "string" : "string");
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
const shown = (value) => (Array.isArray(value) ? value.join(" ") || "none" : value === "" ? "empty" : `${value}`);

function control(id, property, value, disabled) {
  let input;
  if (property.enum) {
    input = el("select", { id, disabled }, property.enum.map((each) => el("option", { value: each }, each)));
  } else if (kind(property) === "boolean") {
    input = el("input", { id, disabled, type: "checkbox" });
  } else if (kind(property) === "array") {
    input = el("textarea", { id, disabled, rows: 2, spellcheck: false, placeholder: "one a line" });
  } else if (["number", "integer"].includes(kind(property))) {
    input = el("input", { id, disabled, type: "number", step: kind(property) === "integer" ? 1 : "any", min: property.minimum, max: property.maximum });
  } else {
    input = el("input", { id, disabled, type: "text", spellcheck: false, maxLength: 500 });
  }
  write(input, property, value);
  return input;
}

function write(input, property, value) {
  if (input.type === "checkbox") input.checked = value;
  else if (kind(property) === "array") input.value = value.join("\n");
  else input.value = value;
}

function read(input, property) {
  if (input.type === "checkbox") return input.checked;
  if (kind(property) === "array") return input.value.split("\n").map((each) => each.trim()).filter(Boolean);
  if (input.type === "number") return input.value === "" ? null : Number(input.value);
  return input.value;
}
