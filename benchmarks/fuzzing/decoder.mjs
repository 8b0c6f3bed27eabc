// Reads datagrams, a line of hex each, from standard input, with halo.js; prints how many frames
// of the service `good` it showed, and its memory in MB. An exception ends it with an error.
import { createInterface } from "node:readline";
import { Session } from "../../clients/web/halo.js";

const early = Number(process.argv[2]) / 5;
const heapMb = () => {
  global.gc();
  return process.memoryUsage().heapUsed / 2 ** 20;
};
let [shown, lines, earlyMb] = [0, 0, 0];
const session = new Session({ frame: () => (shown += 1) }, { node: "good" });
for await (const line of createInterface({ input: process.stdin })) {
  lines += 1;
  if (lines > early) earlyMb ||= heapMb();
  session.receive(Uint8Array.from(Buffer.from(line, "hex")), lines / 1000);
}
console.log(JSON.stringify({ shown, early_mb: earlyMb, late_mb: heapMb() }));
