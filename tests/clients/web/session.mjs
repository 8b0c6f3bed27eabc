// Reads steps and what to follow from standard input; writes what the handlers of halo.js get.
import { readFileSync } from "node:fs";
import { Session } from "../../../clients/web/halo.js";

const { steps, follow } = JSON.parse(readFileSync(0, "utf8"));
const found = [];
const kinds = ["frame", "lost", "collision", "report"];
const handlers = Object.fromEntries(kinds.map((kind) => [kind, (event) => found.push(event)]));
for (const kind of ["down", "move", "up"]) {
  handlers[kind] = ({ key }) => found.push({ kind, key });
}
const session = new Session(handlers, follow);
for (const { hex, at_s } of steps) {
  session.receive(hex === null ? null : Uint8Array.from(Buffer.from(hex, "hex")), at_s);
}
process.stdout.write(JSON.stringify({ found, bad: session.bad }));
