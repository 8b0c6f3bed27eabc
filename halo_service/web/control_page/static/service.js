// The connection to the service: live values by WebSocket, everything else by calls.

const RETRY_MS = 1000;

export class Service extends EventTarget {
  constructor() {
    super();
    this.last = {}; // The last value of each kind.
    this.log = [];
    this.shows = [];
    this.connected = false;
    this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/live`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.connected = true;
      this.log = [];
      this.show(this.shows);
      this.emit("connection", true);
    };
    this.socket.onmessage = ({ data }) => {
      if (data instanceof ArrayBuffer) this.picture(data);
      else this.value(JSON.parse(data));
    };
    this.socket.onclose = () => {
      this.connected = false;
      this.emit("connection", false);
      setTimeout(() => this.connect(), RETRY_MS);
    };
  }

  value(value) {
    this.last[value.kind] = value;
    if (value.kind === "log") {
      this.log.push(value);
      if (this.log.length > 300) this.log.shift();
    }
    this.emit(value.kind, value);
  }

  picture(data) {
    const length = new DataView(data).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    const image = new Blob([new Uint8Array(data, 4 + length)], { type: "image/jpeg" });
    this.emit("picture", { header, image });
  }

  emit(kind, detail) {
    this.dispatchEvent(new CustomEvent(kind, { detail }));
  }

  // Calls `run` with each value of a kind until the returned function is called.
  on(kind, run) {
    const handler = ({ detail }) => run(detail);
    this.addEventListener(kind, handler);
    return () => this.removeEventListener(kind, handler);
  }

  // Which pictures to send.
  show(kinds) {
    this.shows = kinds;
    this.send({ show: kinds });
  }

  send(value) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(value));
  }

  // Where the frames come from now: camera, virtual or recording.
  get source() {
    return this.last.scene?.source ?? "";
  }

  get operator() {
    return this.last.hello?.role !== "viewer";
  }

  // Asks the service; throws an Error with its sentence where it refuses.
  async call(name, body = {}) {
    const file = body instanceof Blob;
    let answer;
    try {
      answer = await fetch(`/call/${name}`, {
        method: "POST",
        headers: {
          "Content-Type": file ? "application/octet-stream" : "application/json",
          "X-Halo-Page": "1",
        },
        body: file ? body : JSON.stringify(body),
      });
    } catch {
      throw new Error("The service does not answer. Is it still running?");
    }
    if (answer.headers.get("Content-Type") === "application/octet-stream") return answer.blob();
    const value = await answer.json();
    if (!answer.ok) throw new Error(value.error);
    return value;
  }
}
