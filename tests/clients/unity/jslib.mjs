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
const code = readFileSync(file, "utf8");
new Function(...Object.keys(shared), code)(...Object.values(shared));
// Emscripten makes what begins with $ visible to the functions that depend on it.
globalThis.haloSockets = library.$haloSockets;

const id = library.HaloSocketOpen(0);
const BUFFER = 1024;
const CAPACITY = 65507;
const timer = setInterval(() => {
  let length;
  while ((length = library.HaloSocketReceive(id, BUFFER, CAPACITY)) > 0)
    console.log(Buffer.from(memory.subarray(BUFFER, BUFFER + length)).toString("hex"));
  if (library.HaloSocketState(id) === 3) {
    clearInterval(timer);
    library.HaloSocketClose(id);
  }
}, 16);
