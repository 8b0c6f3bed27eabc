// Reads the golden vectors from standard input and writes what halo.js makes of them.
import { readFileSync } from "node:fs";
import { Assembler, decode, ProtocolError } from "../../../clients/web/halo.js";

const bytes = (hex) => Uint8Array.from(Buffer.from(hex, "hex"));

// The result, or null if the datagram is refused.
function attempt(action) {
  try {
    return action();
  } catch (error) {
    if (error instanceof ProtocolError) return null;
    throw error;
  }
}

function assembled(steps) {
  const assembler = new Assembler();
  return steps.map(({ hex, at_s }) =>
    hex === null ? assembler.expire(at_s) : attempt(() => assembler.receive(bytes(hex), at_s)),
  );
}

const { datagrams, assemblies } = JSON.parse(readFileSync(0, "utf8"));
const result = {
  datagrams: datagrams.map((hex) => attempt(() => decode(bytes(hex)))),
  assemblies: assemblies.map(assembled),
};
process.stdout.write(JSON.stringify(result));
