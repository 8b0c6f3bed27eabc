// The log of the service, newest first.

import { card, el } from "../dom.js";

export function mount(root, service) {
  const list = el("ol", { className: "log" });
  root.append(el("h1", {}, "Log"), card("", list));
  const line = ({ time_s, level, text }) => {
    const when = new Date(1000 * time_s).toLocaleTimeString();
    const mark = level === "info" ? "" : `${level}: `;
    return el("li", { className: level }, `${when} ${mark}${text}`);
  };
  const showAll = () => list.replaceChildren(...service.log.map(line).reverse());
  showAll();
  const stops = [
    service.on("log", (value) => {
      list.prepend(line(value));
      while (list.children.length > 300) list.lastChild.remove();
    }),
    service.on("connection", showAll),
  ];
  return () => stops.forEach((stop) => stop());
}
