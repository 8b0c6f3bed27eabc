// Datagrams in, events out: frames are put together, each touch is reported once, lost services
// end. The rules and their reasons are in protocol/SPEC.md.
//
// Rule: pure. Time in seconds is an argument. State is separate for each (node, surface, session),
// and bounded.

import { decode, MAX_EVENTS, ProtocolError } from "./codec.js";

const MODULUS = 2 ** 24;
const TIMEOUT_S = 3.0; // Silence after which a service counts as lost.
const SUPERSEDED_S = 0.5; // The same for a session with pointers, once its node has a newer one.
const JOIN_MS = 200; // Events so long before our first frame are late copies of what was earlier.
const MAX_STREAMS = 64;
const MAX_REMEMBERED = 256; // Fingers that left and may still have repeated events.
const UNKNOWN_STRIKE = -1;
const REPORTS = new Set(["scene", "homography", "pose", "health"]);

const ahead = (a, b) => (a - b + MODULUS) % MODULUS;
const isNewer = (a, b) => ahead(a, b) > 0 && ahead(a, b) < MODULUS / 2;
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
const keyOf = (surface, { node, session }) => JSON.stringify([node, surface, session]);

export class Assembler {
  constructor() {
    this.streams = new Map();
    this.ranks = new Map(); // Sessions, numbered by first arrival.
    this.collisions = new Set();
  }

  // The events of a datagram, after those of sessions that have expired. A ProtocolError for a
  // malformed one; the state is unchanged then.
  receive(datagram, nowS) {
    const arrived = parts(decode(datagram));
    const events = this.expire(nowS);
    for (const item of arrived) {
      events.push(...(REPORTS.has(item.kind) ? [item] : this.receivePart(item, nowS)));
    }
    return events;
  }

  // Close sessions that were silent for too long; to be called a few times a second.
  expire(nowS) {
    const newest = this.newest();
    const events = [];
    for (const [key, stream] of [...this.streams]) {
      const superseded = newest.get(stream.place) !== stream && stream.last?.pointers.length > 0;
      const limitS = superseded ? SUPERSEDED_S : TIMEOUT_S;
      if (nowS - stream.receivedS > limitS) events.push(...this.close(key));
    }
    return events;
  }

  close(key) {
    const stream = this.streams.get(key);
    if (!stream) return [];
    this.streams.delete(key);
    for (const pair of this.collisions) {
      const [node, surface, ...sessions] = JSON.parse(pair);
      if (JSON.stringify([node, surface]) === stream.place && sessions.includes(stream.session)) {
        this.collisions.delete(pair);
      }
    }
    return stream.close();
  }

  receivePart(part, nowS) {
    const key = keyOf(part.surface, part.header);
    const events = [];
    if (!this.streams.has(key)) {
      if (this.streams.size >= MAX_STREAMS) events.push(...this.close(this.quietest()));
      this.streams.set(key, new Stream(part, nowS));
      this.rank(key);
    }
    const stream = this.streams.get(key);
    const frames = stream.receive(part, nowS);
    if (frames.length) events.push(...this.collision(stream, nowS));
    return [...events, ...frames];
  }

  quietest() {
    const byTime = [...this.streams].sort(([, a], [, b]) => a.receivedS - b.receivedS);
    return byTime[0][0];
  }

  // The session of each (node, surface) that started last.
  newest() {
    const byRank = [...this.streams].sort(([a], [b]) => this.ranks.get(a) - this.ranks.get(b));
    return new Map(byRank.map(([, stream]) => [stream.place, stream]));
  }

  // A session that comes back keeps its number.
  rank(key) {
    const rank = this.ranks.get(key) ?? Math.max(0, ...this.ranks.values()) + 1;
    this.ranks.delete(key);
    this.ranks.set(key, rank);
    const closed = [...this.ranks.keys()].filter((each) => !this.streams.has(each));
    const surplus = Math.max(0, closed.length - MAX_STREAMS);
    for (const each of closed.slice(0, surplus)) this.ranks.delete(each);
  }

  // An older session that still sends frames well after a newer one began.
  collision(stream, nowS) {
    const newest = this.newest().get(stream.place);
    const { node, surface } = stream;
    const sessions = [stream.session, newest.session];
    const pair = JSON.stringify([node, surface, ...sessions]);
    const late = nowS - newest.firstS <= SUPERSEDED_S;
    if (stream === newest || late || this.collisions.has(pair)) return [];
    this.collisions.add(pair);
    return [{ kind: "collision", surface, node, sessions }];
  }
}

// The messages of one datagram as parts of frames, and reports.
function parts(messages) {
  const done = [];
  const begun = new Map();
  for (const message of messages) {
    const { kind, surface, ...fields } = message;
    const part = begun.get(surface);
    if (REPORTS.has(kind)) done.push(message);
    else if (kind === "frame") {
      refuse(part, "a frame starts before the last one has ended");
      begun.set(surface, { surface, header: fields, ids: [], pointers: new Map(), events: [] });
    } else {
      refuse(!part, "a message comes before its frame's header");
      if (kind === "pointer") {
        refuse(part.pointers.has(fields.id), `pointer ${fields.id} comes twice`);
        part.pointers.set(fields.id, fields);
      } else if (kind === "alive") {
        begun.delete(surface);
        done.push(closed(part, fields.ids));
      } else {
        refuse(part.events.length === MAX_EVENTS, "a frame has too many events");
        part.events.push({ kind, ...fields });
      }
    }
  }
  refuse(begun.size, "the alive list is missing");
  return done;
}

function closed(part, ids) {
  refuse(ids.length !== part.header.count, "count is not the number of ids");
  const alive = new Set(ids);
  refuse([...part.pointers.keys()].some((id) => !alive.has(id)), "a pointer is not alive");
  return { ...part, ids };
}

function refuse(condition, sentence) {
  if (condition) throw new ProtocolError(sentence);
}

// The frames of one session on one surface.
class Stream {
  constructor({ surface, header }, nowS) {
    this.surface = surface;
    this.node = header.node;
    this.session = header.session;
    this.place = JSON.stringify([header.node, surface]);
    this.firstS = nowS;
    this.receivedS = nowS;
    this.touches = new TouchCounter();
    this.joinedUs = timeUs(header);
    this.joining = true; // Until a whole frame was reported.
    this.last = null;
    this.pending = null;
  }

  // The frames that a part completes, or proves incomplete.
  receive(part, nowS) {
    this.receivedS = nowS;
    const ageMs = (timeUs(part.header) - this.joinedUs) / 1000;
    part.events = part.events.filter((each) => each.ago_ms <= ageMs + JOIN_MS);
    const number = part.header.frame;
    if (this.last && !isNewer(number, this.last.frame)) return this.lateEvents(part);
    const frames = [];
    if (!this.pending) this.pending = part;
    else if (isNewer(number, this.pending.header.frame)) {
      frames.push(this.report(this.pending, false));
      this.pending = part;
    } else if (!this.merge(part)) return [];
    if (this.pending.pointers.size === this.pending.header.count) {
      frames.push(this.report(this.pending, true));
      this.pending = null;
    }
    return frames;
  }

  // The last events of a lost session: no pointers, open touches ended.
  close() {
    const { surface, node, session, last } = this;
    const events = this.touches.close();
    const lost = { kind: "lost", surface, node, session };
    if (!last || !(last.pointers.length || events.length)) return [lost];
    return [{ ...last, pointers: [], events, missed: 0, complete: true }, lost];
  }

  // Add a part to the pending frame; false if it belongs to another one or adds nothing.
  merge(part) {
    const { pending } = this;
    if (!same(part.header, pending.header) || !same(part.ids, pending.ids)) return false;
    const newEvents = part.events.filter((each) => !pending.events.some((old) => same(old, each)));
    const newPointers = [...part.pointers.keys()].some((id) => !pending.pointers.has(id));
    if (!newPointers && !newEvents.length) return false;
    if (pending.events.length + newEvents.length > MAX_EVENTS) return false;
    for (const [id, pointer] of part.pointers) pending.pointers.set(id, pointer);
    pending.events.push(...newEvents);
    return true;
  }

  // Late events of a frame that was already reported.
  lateEvents(part) {
    const { last } = this;
    if (part.header.frame !== last.frame || !part.events.length) return [];
    const events = this.touches.count(last.pointers, part.events, false, true);
    return events.length ? [{ ...last, events, missed: 0 }] : [];
  }

  report({ surface, header, ids, pointers, events }, complete) {
    const { last } = this;
    const known = new Map((last?.pointers ?? []).map((pointer) => [pointer.id, pointer]));
    for (const [id, pointer] of pointers) known.set(id, pointer);
    const alive = ids.filter((id) => known.has(id)).map((id) => known.get(id));
    const counted = this.touches.count(alive, events, this.joining, complete);
    this.joining &&= !complete;
    this.last = {
      kind: "frame",
      time_us: timeUs(header),
      surface,
      node: header.node,
      session: header.session,
      frame: header.frame,
      session_ms: header.session_ms,
      pointers: alive,
      events: counted,
      missed: last ? ahead(header.frame, last.frame) - 1 : 0,
      complete,
    };
    return this.last;
  }
}

const timeUs = (header) => header.time_s * 1e6 + header.time_frac_us;

const inOrder = (a, b) =>
  a.id - b.id || a.contacts - b.contacts || (a.kind === "up") - (b.kind === "up");

// Each touch once: repeated events are reported once, lost ones are inferred from the pointers.
class TouchCounter {
  constructor() {
    this.fingers = new Map(); // id -> its place, and the last touches that began and ended
    this.found = [];
  }

  // The new downs and ups of a frame. `joining`: touches that began before are not hits.
  // A frame that is not `whole` infers nothing: the next one repeats what it lost.
  count(pointers, events, joining, whole) {
    for (const event of [...events].sort(inOrder)) this.event(event, joining);
    for (const pointer of pointers) {
      const finger = this.finger(pointer);
      const touching = pointer.state === "touch";
      if (joining && pointer.contacts > finger.begun) {
        finger.begun = pointer.contacts;
        finger.ended = pointer.contacts - Number(touching);
      }
      if (!whole) continue;
      this.begin(finger, inferredDown(pointer));
      if (!touching) this.end(pointer.id, finger);
    }
    const living = new Set(pointers.map(({ id }) => id));
    if (whole) this.endAllBut(living);
    const gone = [...this.fingers.keys()].filter((id) => !living.has(id));
    const surplus = Math.max(0, gone.length - MAX_REMEMBERED);
    for (const id of gone.slice(0, surplus)) this.fingers.delete(id);
    return this.drain();
  }

  close() {
    this.endAllBut(new Set());
    return this.drain();
  }

  event(event, joining) {
    const finger = this.finger(event);
    if (event.kind === "down") return this.begin(finger, event);
    const number = event.contacts;
    if (number <= finger.ended) return;
    if (number > finger.begun && joining) {
      finger.begun = finger.ended = number; // It began before we joined.
      return;
    }
    this.begin(finger, inferredDown(event));
    finger.ended = number;
    this.found.push(event);
  }

  begin(finger, down) {
    if (down.contacts <= finger.begun) return;
    this.end(down.id, finger);
    finger.begun = down.contacts;
    finger.ended = down.contacts - 1; // Touches in between were lost and are over.
    this.found.push(down);
  }

  end(id, finger) {
    if (finger.ended >= finger.begun) return;
    const { slot, u, v, begun } = finger;
    this.found.push({ kind: "up", id, slot, u, v, ago_ms: 0, contacts: begun });
    finger.ended = begun;
  }

  endAllBut(living) {
    for (const [id, finger] of this.fingers) if (!living.has(id)) this.end(id, finger);
  }

  finger({ id, slot, u, v }) {
    const finger = this.fingers.get(id) ?? { begun: 0, ended: 0 };
    this.fingers.set(id, Object.assign(finger, { slot, u, v }));
    return finger;
  }

  drain() {
    return this.found.splice(0).sort(inOrder);
  }
}

const inferredDown = ({ id, slot, u, v, contacts }) => ({
  kind: "down",
  id,
  slot,
  u,
  v,
  strike_mm_s: UNKNOWN_STRIKE,
  ago_ms: 0,
  contacts,
});
