// halo.js as a UDP client: prints its port, then each event as a line of JSON, until `lost` of the
// last service.
import { createSocket } from "node:dgram";
import { Session } from "../../../clients/web/halo.js";

const print = (event) => process.stdout.write(JSON.stringify(event) + "\n");
const now = () => performance.now() / 1000;
const lost = (event) => {
  print(event);
  if (event.node === process.argv[2]) process.exit(0);
};
const handlers = { frame: print, collision: print, lost };
const session = new Session(handlers, { everything: true });
const socket = createSocket("udp4");
socket.on("message", (datagram) => session.receive(new Uint8Array(datagram), now()));
socket.bind(0, "127.0.0.1", () => print(socket.address().port));
setInterval(() => session.receive(null, now()), 250);
