// Reads lines of JSON {"address", "args"} from stdin; prints what tuio-client shows, one JSON line
// per line with "show": cursors of TUIO 1.1 and pointers of TUIO 2.0.
import { createInterface } from "node:readline";
import { Tuio11Client, Tuio20Client, TuioReceiver } from "./node_modules/tuio-client/dist/tuio-client.es.js"; // its "main" is not for Node

class Lines extends TuioReceiver {
  connect() {}
  disconnect() {}
}

const receiver = new Lines();
const tuio11 = new Tuio11Client(receiver);
const tuio20 = new Tuio20Client(receiver);
tuio11.connect();
tuio20.connect();

for await (const line of createInterface({ input: process.stdin })) {
  const message = JSON.parse(line);
  if (message.show) {
    const cursors = [...tuio11.getTuioCursors()].map((c) => [c.position.x, c.position.y]);
    const pointers = tuio20.getTuioPointerList().map((p) => [p.position.x, p.position.y, p.press, p.tuId]);
    console.log(JSON.stringify({ cursors, pointers }));
  } else {
    receiver.onOscMessage(message);
  }
}
