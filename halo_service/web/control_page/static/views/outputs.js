// Who is sent what, and a test pattern for each.

import { button, card, el, table, toast } from "../dom.js";

const EVERY_MS = 1000;
const FORMATS = "Formats: /frames (halo clients), /flat (any program that reads OSC), /tuio11 and /tuio2 (TUIO programs).";


export function mount(root, service) {
  const sent = el("div");
  const pattern = el("div");
  const to = el("input", { type: "text", id: "pattern-to", placeholder: "127.0.0.1:4256/flat", size: 26, maxLength: 200 });
  let before = new Map();
  let shownPattern = "";
  const load = async () => {
    const read = await service.call("outputs");
    const now = performance.now();
    const sentTo = ({ to, datagrams, bytes }) => {
      const last = before.get(to);
      const seconds = last ? (now - last.now) / 1000 : 1;
      return last
        ? [`${Math.round((datagrams - last.datagrams) / seconds)}`, ((bytes - last.bytes) / seconds / 1000).toFixed(1)]
        : ["-", "-"];
    };
    const rows = read.osc.map((each) => [
      each.to, each.rate_hz ? `${each.rate_hz} Hz` : "all frames", each.reached ? "✓ found" : "✕ not found", ...sentTo(each),
    ]);
    const clients = read.websocket.clients.map((each) => [each.to, `${each.dropped}`, ...sentTo(each)]);
    before = new Map([...read.osc, ...read.websocket.clients].map(({ to, datagrams, bytes }) => [to, { datagrams, bytes, now }]));
    sent.replaceChildren(
      card("OSC and TUIO by UDP", rows.length ? table(["receiver and format", "rate limit", "address", "datagrams / s", "kB / s"], rows, [3, 4]) : el("p", {}, "Nothing is sent by UDP."),
        el("p", { className: "small" }, "Change the receivers in ", el("a", { href: "#settings" }, "Settings"), ". UDP has no receipt: look in your program whether touches arrive.")),
      card("WebSocket", read.websocket.url ? el("p", {}, "Browsers connect to ", el("code", {}, read.websocket.url), clients.length ? "" : ". No program is connected.") : el("p", {}, "off"),
        clients.length ? table(["client and format", "dropped", "messages / s", "kB / s"], clients, [1, 2, 3]) : ""),
      card("Zenoh", el("p", {}, read.zenoh.length ? ["Programs connect to ", ...read.zenoh.map((each) => el("code", {}, each)), ". Zenoh does not say who reads."] : "off")),
    );
    const state = JSON.stringify([read.pattern, read.patterns]);
    if (state !== shownPattern) {
      shownPattern = state;
      showPattern(read);
    }
  };
  const act = (name, body) => async () => {
    await service.call(name, body);
    await load();
  };
  const showPattern = (read) => {
    const rows = read.patterns.map((each) => el("div", { className: "row" }, el("code", {}, each), button("Stop", act("stop-pattern", { to: each }))));
    pattern.replaceChildren(
      el("div", { className: "row" }, read.pattern
        ? [el("strong", {}, "The pattern is sent on all outputs, instead of touches."), button("Stop", act("stop-pattern", { to: "" }), { className: "main" })]
        : button("Send on all outputs", act("start-pattern", { to: "" }), { className: "main" })),
      ...rows,
    );
  };
  root.append(
    el("h1", {}, "Outputs"),
    card(
      "Test pattern",
      el("p", {}, "Checks the way to your program without a hand: a pointer draws a circle in four seconds. It touches for three and hovers for one."),
      service.operator ? pattern : el("p", { className: "soft" }, "Only the operator's page can send it."),
      service.operator ? el("div", { className: "row" }, el("label", { htmlFor: "pattern-to" }, "Or to one program:"), to, button("Send", async () => {
        if (!to.value.trim()) throw new Error("Write where to send it: host, port and format, such as 127.0.0.1:4256/flat.");
        await act("start-pattern", { to: to.value.trim() })();
      })) : "",
      service.operator ? el("p", { className: "small soft" }, FORMATS) : "",
    ),
    sent,
  );
  load().catch((error) => toast(error.message));
  const timer = setInterval(() => load().catch(() => {}), EVERY_MS);
  return () => clearInterval(timer);
}
