// Prints each event of a MIDI file as a line of JSON: time in ticks, bytes, and the zone that
// JZZ's own MPE table has for its channel.
import { readFileSync } from "node:fs";
import JZZ from "jzz";
import SMF from "jzz-midi-smf";

SMF(JZZ);
const text = readFileSync(process.argv[2], "binary");
const file = new JZZ.MIDI.SMF(text);
const warnings = file.validate() ?? [];
const zones = new JZZ.MPE();
const parameter = {};
for (const event of file[0]) {
  if (event.ff !== undefined) continue;
  const bytes = Array.from(event);
  const channel = event.getChannel();
  if ((bytes[0] & 0xf0) === 0xb0) {
    const chosen = (parameter[channel] ??= [127, 127]);
    if (bytes[1] === 101) chosen[0] = bytes[2];
    if (bytes[1] === 100) chosen[1] = bytes[2];
    if (bytes[1] === 6 && chosen[0] === 0 && chosen[1] === 6) zones.setup(channel, bytes[2]);
  }
  console.log(JSON.stringify({ tick: event.tt, bytes, master: zones[channel].master }));
}
console.log(JSON.stringify({ warnings: warnings.map(String), ppqn: file.ppqn }));
