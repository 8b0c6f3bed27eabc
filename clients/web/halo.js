// Touch, hover and pressure from a halo service, in a browser or in Node 22.
//
//   import { connect } from "./halo.js";
//   const halo = connect("ws://127.0.0.1:4258/halo", {
//     down: (touch) => console.log("down", touch.u, touch.v),
//     frame: (frame) => draw(frame.pointers),
//   });
//
// No dependency. A restarted service is found again; the touches of a lost one end.

import { Assembler } from "./assembly.js";
import { ProtocolError } from "./codec.js";

export { Assembler, ProtocolError };
export { decode } from "./codec.js";

const SUBPROTOCOL = "halo.1.osc";
const RETRY_MS = 500;
const TICK_MS = 250; // How often lost services are detected while nothing arrives.
const MAX_RETIRED = 64;

// Connects, and calls the functions of `handlers`:
//   frame(frame)     each frame: {node, surface, session, frame, time_us, pointers, events, ...}
//   down(touch)      a touch began: {id, slot, u, v, strike_mm_s, contacts, key, pointer?}
//   move(touch)      it goes on, once a frame: {...pointer, key}
//   up(touch)        it ended, or its service is lost: {id, slot, u, v, contacts, key}
//   report(report)   a scene, homography, pose or health, by its `kind`
//   lost(lost)       the service fell silent or restarted
//   collision(two)   two running services have one node name
// `node`, `surface`: what to follow; without them, the first service that sends a frame.
// `everything: true` reports all services. Returns an object with `close()`.
export function connect(url, handlers = {}, { node, surface, everything = false } = {}) {
  if (typeof WebSocket === "undefined") {
    throw new Error("there is no WebSocket here: use Node 22, or node --experimental-websocket");
  }
  const session = new Session(handlers, { node, surface, everything });
  return new Connection(url, session);
}

// Events of the service that is followed. Pure: datagrams and times are arguments.
export class Session {
  constructor(handlers = {}, { node, surface, everything = false } = {}) {
    this.handlers = handlers;
    this.follow = { node, surface, everything };
    this.assembler = new Assembler();
    this.current = null; // Node, surface and session that are followed.
    this.retired = []; // Replaced sessions.
    this.bad = 0; // Datagrams that could not be read.
  }

  // Process a datagram (a Uint8Array); without one, only detect lost services.
  receive(datagram, nowS) {
    for (const event of this.events(datagram, nowS)) this.process(event);
  }

  events(datagram, nowS) {
    if (!datagram) return this.assembler.expire(nowS);
    try {
      return this.assembler.receive(datagram, nowS);
    } catch (error) {
      if (!(error instanceof ProtocolError)) throw error;
      this.bad += 1;
      return this.assembler.expire(nowS);
    }
  }

  process(event) {
    if (event.kind === "frame" && this.replaces(event)) this.restart();
    if (this.accepts(event)) this.report(event);
  }

  // Whether a frame is of a newer session of the service that is followed.
  replaces(frame) {
    const { current } = this;
    if (!current || this.follow.everything || same(current, frame)) return false;
    return samePlace(current, frame) && !this.retired.some((old) => same(old, frame));
  }

  restart() {
    const { node, surface, session } = this.current;
    const ended = this.assembler.close(JSON.stringify([node, surface, session]));
    for (const event of ended) this.report(event);
    this.retired = [...this.retired.slice(1 - MAX_RETIRED), this.current];
    this.current = null;
  }

  accepts(event) {
    const matches =
      (this.follow.node ?? event.node) === event.node &&
      (this.follow.surface ?? event.surface) === event.surface;
    if (this.follow.everything) return matches;
    if (event.kind === "lost") return this.acceptsLoss(event);
    if (event.kind === "collision")
      return this.current ? samePlace(this.current, event) : matches;
    // A report of another session is of a service with the same name: it must not move a picture.
    if (event.kind !== "frame") return this.current ? same(this.current, event) : matches;
    const free = !this.current && !this.retired.some((old) => same(old, event));
    if (free && matches) this.current = placeOf(event);
    return this.current !== null && same(this.current, event);
  }

  acceptsLoss(lost) {
    const followed = this.current !== null && same(this.current, lost);
    if (followed) this.current = null;
    this.retired = this.retired.filter((old) => !same(old, lost));
    return followed;
  }

  report(event) {
    const { handlers } = this;
    if (event.kind === "frame") {
      handlers.frame?.(event);
      for (const [kind, touch] of touches(event)) handlers[kind]?.(touch);
    } else if (event.kind === "lost") handlers.lost?.(event);
    else if (event.kind === "collision") handlers.collision?.(event);
    else handlers.report?.(event);
  }
}

// The touches of a frame: ["down" | "move" | "up", touch], those of one finger in order.
export function touches(frame) {
  const keyOf = ({ id, contacts }) =>
    [frame.node, frame.surface, frame.session, id, contacts].join("/");
  const living = new Map(frame.pointers.map((pointer) => [pointer.id, pointer]));
  const found = frame.events.map(({ kind, ...touch }) => [
    kind,
    { ...touch, key: keyOf(touch), pointer: living.get(touch.id) },
  ]);
  const reported = new Set(found.map(([, { key }]) => key));
  for (const pointer of frame.pointers) {
    const key = keyOf(pointer);
    if (pointer.state === "touch" && !reported.has(key)) found.push(["move", { ...pointer, key }]);
  }
  return found;
}

const placeOf = ({ node, surface, session }) => ({ node, surface, session });
const samePlace = (a, b) => a.node === b.node && a.surface === b.surface;
const same = (a, b) => samePlace(a, b) && a.session === b.session;

class Connection {
  constructor(url, session) {
    this.url = url;
    this.session = session;
    this.closed = false;
    this.timer = setInterval(() => session.receive(null, now()), TICK_MS);
    this.open();
  }

  // Whether the connection to a service is open now.
  get connected() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  close() {
    this.closed = true;
    clearInterval(this.timer);
    clearTimeout(this.retry);
    this.socket.close();
  }

  open() {
    this.socket = new WebSocket(this.url, [SUBPROTOCOL]);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = ({ data }) => {
      if (data instanceof ArrayBuffer) this.session.receive(new Uint8Array(data), now());
    };
    // A refused connection ends with both, or in Node with an error alone.
    this.socket.onclose = this.socket.onerror = () => this.openLater();
  }

  openLater() {
    clearTimeout(this.retry);
    if (!this.closed) this.retry = setTimeout(() => this.open(), RETRY_MS);
  }
}

const now = () => performance.now() / 1000;
