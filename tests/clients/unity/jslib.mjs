// Runs HaloWebSocket.jslib as a WebGL build would: with functions in a library and a memory of bytes.
// Prints each message as hex until the connection has closed.
import { readFileSync } from "node:fs";

const [file, url] = process.argv.slice(2);
const memory = new Uint8Array(1 << 17);
const library = {};
const shared = {
  LibraryManager: { library },
  mergeInto: Object.assign,
  HEAPU8: memory,
  UTF8ToString: () => url, // C# passes a pointer to the text.
};
if (url === "flood") {
  // A socket that gets 1,000 messages before the page reads one.
  globalThis.WebSocket = class {
    readyState = 3;
    constructor() {
      setTimeout(() => {
        for (let i = 0; i < 1000; i++) this.onmessage({ data: Uint8Array.of(i >> 8, i).buffer });
      });
    }
    close() {}
  };
}
const code = readFileSync(file, "utf8");
new Function(...Object.keys(shared), code)(...Object.values(shared));
// Emscripten makes what begins with $ visible to the functions that depend on it.
globalThis.haloSockets = library.$haloSockets;

const BUFFER = 1024;
const CAPACITY = 65507;
const id = library.HaloSocketOpen(0);
const timer = setInterval(() => {
  let length;
  while ((length = library.HaloSocketReceive(id, BUFFER, CAPACITY)) > 0)
    console.log(Buffer.from(memory.subarray(BUFFER, BUFFER + length)).toString("hex"));
  if (library.HaloSocketState(id) !== 3) return;
  clearInterval(timer);
  library.HaloSocketClose(id);
}, 16);
