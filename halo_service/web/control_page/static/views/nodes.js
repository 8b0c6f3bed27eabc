// All nodes in reach: rate, latency, clock, versions, and what is wrong with them.

import { card, el, table, toast } from "../dom.js";

const EVERY_MS = 1000;
const NUMBERS = [3, 4, 5];
const CLOCK = "Clock: the node's clock minus that of this machine. The real difference is larger by the delay of the fastest message, below 1 ms on a wired network. Age: of the calibration.";

export function mount(root, service) {
  const warnings = el("ul", { className: "steps" });
  const warned = el("div", { role: "status" }, warnings);
  const count = el("p", { className: "soft small" }, "Looking for nodes …");
  let shown = null;
  let said = "";
  const load = async () => {
    const { head, rows, more, warnings: texts } = await service.call("nodes");
    if (!shown) {
      shown = table(head, [], NUMBERS);
      count.before(shown);
    }
    shown.querySelector("tbody").replaceChildren(
      ...rows.map((row) => el("tr", {}, row.map((each, n) => el("td", { className: NUMBERS.includes(n) ? "number" : "" }, each)))),
    );
    count.textContent = rows.length
      ? `${rows.length + more} nodes${more ? `, ${more} of them not shown` : ""}. ! marks a node with a warning.`
      : "No node is found. Nodes are found by Zenoh at the routers of the settings, and by mDNS.";
    if (said !== texts.join("\n")) {
      said = texts.join("\n");
      warnings.replaceChildren(...texts.map((each) => el("li", { className: "warn" }, each)));
    }
  };
  root.append(
    el("h1", {}, "Nodes"),
    card("All nodes in reach", warned, count, el("p", { className: "small soft" }, CLOCK)),
  );
  load().catch((error) => toast(error.message));
  const timer = setInterval(() => load().catch(() => {}), EVERY_MS);
  return () => clearInterval(timer);
}
