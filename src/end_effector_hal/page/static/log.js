// The log, newest first, with a filter.
import { byId, make } from "/static/dom.js";

const MOST = 400;

export class Log {
  constructor(list, drawn, open) {
    this.list = list;
    this.epoch = drawn.epoch;
    this.open = open;
    this.entries = [];
    list.replaceChildren();
    byId("log-kind").onchange = () => this.redraw();
    byId("log-find").oninput = () => this.redraw();
  }

  add(entries) {
    if (!entries.length) return;
    this.entries.push(...entries);
    this.entries.splice(0, Math.max(0, this.entries.length - 2000));
    const shown = entries.filter((entry) => this.wanted(entry)).reverse();
    this.list.prepend(...shown.map((entry) => this.line(entry)));
    while (this.list.children.length > MOST) this.list.lastChild.remove();
  }

  redraw() {
    const shown = this.entries.filter((entry) => this.wanted(entry)).slice(-MOST).reverse();
    this.list.replaceChildren(...shown.map((entry) => this.line(entry)));
  }

  wanted(entry) {
    const kinds = byId("log-kind").value;
    const find = byId("log-find").value.trim().toLowerCase();
    const kind = kinds === "*" || (kinds ? kinds.split(" ").includes(entry.kind) : entry.kind !== "automaton");
    return kind && (!find || entry.text.toLowerCase().includes(find));
  }

  line(entry) {
    const time = make("time", {}, `${((entry.at - this.epoch) / 1e6).toFixed(2)} s`);
    const text = entry.detail ? make("button", { type: "button", textContent: entry.text }) : make("span", {}, entry.text);
    if (entry.detail) text.addEventListener("click", () => this.open(entry));
    const line = make("li", {}, time, make("span", { className: "kind" }, entry.kind), make("span", { className: "text" }, text));
    line.dataset.kind = entry.kind;
    return line;
  }
}
