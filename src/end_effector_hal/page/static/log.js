// The log, newest first, with a filter.
import { byId, make } from "/static/dom.js";

const MOST = 400;
const FEW = 40;

export class Log {
  constructor(list, drawn, open) {
    this.list = list;
    this.epoch = drawn.epoch;
    this.open = open;
    this.entries = [];
    this.until = Infinity;
    list.replaceChildren();
    byId("log-kind").onchange = () => this.redraw();
    byId("log-find").oninput = () => this.redraw();
  }

  add(entries) {
    if (!entries.length) return;
    const late = this.entries.length > 0 && entries[0].at < this.entries[this.entries.length - 1].at;
    this.entries.push(...entries);
    if (late) this.entries.sort((one, other) => one.at - other.at || one.n - other.n);
    this.entries.splice(0, Math.max(0, this.entries.length - 2000));
    if (late) {
      this.redraw();
      return;
    }
    const shown = entries.filter((entry) => this.wanted(entry)).reverse();
    this.list.prepend(...shown.map((entry) => this.line(entry)));
    while (this.list.children.length > MOST) this.list.lastChild.remove();
  }

  // A whole recording: what is shown is chosen by the moment; a search finds the later ones, too.
  load(entries) {
    this.entries = entries;
  }

  at(number) {
    if (number === this.until) return;
    this.until = number;
    if (!this.searched()) this.redraw();
  }

  redraw() {
    const most = this.until === Infinity || this.searched() ? MOST : FEW;
    const shown = [];
    let index = this.searched() ? this.entries.length : Math.min(this.entries.length, this.until);
    while (index > 0 && shown.length < most) {
      index -= 1;
      if (this.wanted(this.entries[index])) shown.push(this.entries[index]);
    }
    this.list.replaceChildren(...shown.map((entry) => this.line(entry)));
  }

  searched() {
    return byId("log-find").value.trim() !== "";
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
