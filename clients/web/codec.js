// OSC bytes to messages, by the table of protocol/SPEC.md.
//
// Rule: pure. `decode` returns messages in the JSON view, or throws a ProtocolError; a datagram is
// refused as a whole.

export class ProtocolError extends Error {}

const ROOT = "/halo/1/";
const MAX_BYTES = 65507;
const MAX_DEPTH = 4;
const BUNDLE = "#bundle";
const MODULUS = 2 ** 24;
export const MAX_POINTERS = 64;
export const MAX_EVENTS = 256;

const WORDS = {
  hand: ["unknown", "left", "right"],
  finger: ["thumb", "index", "middle", "ring", "little"],
  state: ["hover", "touch"],
  calibration: ["none", "partial", "complete"],
  source: ["camera", "recording", "virtual"],
  tracker: ["off", "starting", "searching", "tracking", "failed"],
  camera: ["starting", "running", "lost", "ended"],
  profile_fit: ["unknown", "good", "moved", "tilted", "hidden", "marker"],
  load: ["none", "reduced", "least", "dropping"],
};

// Kind -> its fields, `name:type`. Later minor versions append `name:type=value`, with the value (of
// a list: `0,0,1`) for messages of older ones, which end before it.
const ROWS = Object.fromEntries(
  Object.entries({
    frame: "node:s session:s frame:i time_s:i time_frac_us:i count:i session_ms:i",
    pointer:
      "id:i slot:i hand:i finger:i state:i u:f v:f x_mm:f y_mm:f hover_mm:f pressure:f " +
      "vx_mm_s:f vy_mm_s:f confidence:f contacts:i force_g:f",
    down: "id:i slot:i u:f v:f strike_mm_s:f ago_ms:f contacts:i",
    up: "id:i slot:i u:f v:f ago_ms:f contacts:i",
    scene:
      "node:s session:s version:s width_mm:f height_mm:f calibration:i revision:i source:i " +
      "rate_hz:f control_port:i collision:i calibrated_s:i service_version:s " +
      "zenoh_version:s",
    homography: "node:s session:s revision:i width_px:i height_px:i projector_from_surface:f9",
    pose:
      "node:s session:s revision:i camera_from_surface:f12 anchor_from_surface:f12 anchored:i",
    health:
      "node:s session:s fps:f latency_ms:f drops:i bad_frames:i tracker:i camera:i tracker_ms:f " +
      "clock_jumps:i clock_error_ms:f profile_fit:i zenoh_missing:i write_errors:i " +
      "memory_mb:i load:i looks_hz:f time_s:i time_frac_us:i nodes:i clock_offset_ms:f " +
      "clock_deviation_ms:f",
  }).map(([kind, text]) => [kind, text.split(" ").map(field)]),
);

function field(text) {
  const [name, type, value] = text.split(/[:=]/);
  const tag = type[0];
  const missing = value?.split(",").map((each) => (tag === "s" ? each : Number(each)));
  return { name, tag, length: Number(type.slice(1) || 1), list: type.length > 1, missing };
}

// The messages of a datagram (a Uint8Array), in order: `{kind, surface, ...fields}`.
export function decode(datagram) {
  require(datagram.length <= MAX_BYTES, `a datagram has at most ${MAX_BYTES} bytes`);
  require(datagram.length > 0, "the datagram is empty");
  const messages = [];
  read(new Reader(datagram), MAX_DEPTH, messages);
  return messages;
}

function read(reader, depth, messages) {
  require(reader.left % 4 === 0, "the size of an OSC packet must be a multiple of 4");
  if (!reader.startsWith(BUNDLE)) {
    const message = readMessage(reader);
    if (message) messages.push(message);
    return;
  }
  require(depth > 0, `bundles are nested more than ${MAX_DEPTH} deep`);
  require(reader.left >= 16, "a bundle has at least 16 bytes");
  reader.skip(16);
  while (reader.left) {
    const size = reader.int();
    require(size > 0 && size <= reader.left, `an element of ${size} bytes is cut off`);
    read(reader.part(size), depth - 1, messages);
  }
}

function readMessage(reader) {
  const address = reader.string(ANY_TEXT);
  require(address.startsWith("/"), "an OSC address begins with a slash");
  if (!address.startsWith(ROOT)) return null;
  const [surface, ...rest] = address.slice(ROOT.length).split("/");
  const kind = rest.join("/");
  if (kind !== "alive" && !Object.hasOwn(ROWS, kind)) return null;
  checkName(surface, "surface");
  require(surface !== "control" && surface !== "sim", `surface '${surface}' is reserved`);
  const tags = reader.string(ANY_TEXT);
  const fields = kind === "alive" ? readAlive(reader, tags) : readFields(ROWS[kind], reader, tags);
  const message = { kind, surface, ...fields };
  CHECKS[kind](message);
  return message;
}

function readAlive(reader, tags) {
  require(/^,i*$/.test(tags), "alive is a list of ints");
  const ids = Array.from(tags.slice(1), () => reader.int());
  require(reader.left === 0, "alive has bytes too many");
  return { ids };
}

function readFields(row, reader, tags) {
  let expected = ",";
  const fields = {};
  for (const { name, tag, length, list, missing } of row) {
    let values = missing;
    if (!missing || tags !== expected) {
      expected += tag.repeat(length);
      require(tags.startsWith(expected), `the types must start with ${expected}, not ${tags}`);
      values = Array.from({ length }, () => reader.value(tag));
    }
    fields[name] = list ? [...values] : worded(name, values[0]);
  }
  require(tags.length > expected.length || reader.left === 0, "there are bytes too many");
  return fields;
}

// An enumeration as its word; an unknown number stays a number.
const worded = (name, value) => WORDS[name]?.[value] ?? value;

class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.position = 0;
  }

  get left() {
    return this.bytes.length - this.position;
  }

  startsWith(text) {
    if (this.left < text.length + 1) return false;
    const raw = this.bytes.subarray(this.position, this.position + text.length + 1);
    return raw.every((byte, i) => byte === (i < text.length ? text.charCodeAt(i) : 0));
  }

  skip(count) {
    require(count <= this.left, `${count} bytes are needed, ${this.left} are left`);
    this.position += count;
    return this.position - count;
  }

  part(size) {
    const start = this.skip(size);
    return new Reader(this.bytes.subarray(start, start + size));
  }

  int() {
    return this.view.getInt32(this.skip(4));
  }

  value(tag) {
    if (tag === "s") return this.string();
    const value = tag === "i" ? this.int() : this.view.getFloat32(this.skip(4));
    require(Number.isFinite(value), "each number must be finite");
    return value;
  }

  string(text = TEXT) {
    const stop = this.bytes.indexOf(0, this.position);
    require(stop >= 0, "a string has no end");
    const start = this.skip(stop - this.position + 4 - ((stop - this.position) % 4));
    try {
      return text.decode(this.bytes.subarray(start, stop));
    } catch {
      throw new ProtocolError("a string is not UTF-8");
    }
  }
}

const TEXT = new TextDecoder("utf-8", { fatal: true, ignoreBOM: true });
// Addresses of other programs are skipped, whatever they hold.
const ANY_TEXT = new TextDecoder("utf-8", { ignoreBOM: true });

function require(condition, sentence) {
  if (!condition) throw new ProtocolError(sentence);
}

function checkName(name, what) {
  require(/^[a-z0-9_-]{1,32}$/.test(name), `${what} must be 1 to 32 of a-z 0-9 _ -`);
}

function checkRange(message, name, first, last) {
  const value = message[name];
  require(value >= first && value <= last, `${name} must be ${first} to ${last}, not ${value}`);
}

function checkSender({ node, session }) {
  checkName(node, "node");
  require(/^[g-z][a-z0-9_-]{0,31}$/.test(session), "session must start with g to z");
}

function checkTime(message) {
  checkRange(message, "time_s", 0, 2 ** 31 - 1);
  checkRange(message, "time_frac_us", 0, 999999);
}

function checkFrame(message) {
  checkSender(message);
  checkRange(message, "frame", 0, MODULUS - 1);
  checkTime(message);
  checkRange(message, "session_ms", 0, MODULUS - 1);
  checkRange(message, "count", 0, MAX_POINTERS);
}

function checkCounted(message) {
  for (const name of ["id", "slot", "contacts"]) checkRange(message, name, 0, 2 ** 31 - 1);
}

function checkAlive({ ids }) {
  require(ids.length <= MAX_POINTERS, `at most ${MAX_POINTERS} pointers can be alive`);
  require(new Set(ids).size === ids.length, "the alive list has an id twice");
}

function checkScene(message) {
  checkSender(message);
  require(/^\d{1,4}\.\d{1,4}\.\d{1,4}$/.test(message.version), "version must be major.minor.patch");
  checkRange(message, "collision", 0, 1);
  checkRange(message, "control_port", 0, 65535);
  checkRange(message, "calibrated_s", 0, Infinity);
  for (const name of ["service_version", "zenoh_version"]) {
    require(/^[0-9A-Za-z.+_-]{0,32}$/.test(message[name]), `${name} must be a version`);
  }
  require(message.width_mm > 0 && message.height_mm > 0, "the size of a surface must be positive");
}

function checkHealth(message) {
  checkSender(message);
  checkTime(message);
}

function checkHomography(message) {
  checkSender(message);
  require(message.width_px > 0 && message.height_px > 0, "the size must be positive");
}

function checkPose(message) {
  checkSender(message);
  checkRange(message, "anchored", 0, 1);
}

const CHECKS = {
  frame: checkFrame,
  pointer: checkCounted,
  alive: checkAlive,
  down: checkCounted,
  up: checkCounted,
  scene: checkScene,
  homography: checkHomography,
  pose: checkPose,
  health: checkHealth,
};
