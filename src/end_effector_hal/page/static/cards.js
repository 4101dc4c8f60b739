// A card for each actuator: output, evidence, measured values against their marks, attempts, the time-out, the hold.
import { make, put, svg, seconds } from "/static/dom.js";

const EVIDENCE = { UNKNOWN: "? unknown", GONE: "○ gone", PARTIAL: "◐ partial", CONFIRMED: "● confirmed" };

export class Cards {
  constructor(list, drawn) {
    this.cards = drawn.cards.map((card, index) => new Card(card, index));
    list.replaceChildren(...this.cards.map((card) => card.element));
  }

  show(view) {
    if (!view.cards) return;
    view.cards.forEach((now, index) => this.cards[index].show(now, view.at, view.state));
  }
}

class Card {
  constructor(drawn, index) {
    this.drawn = drawn;
    this.pill = make("span", { className: "pill" });
    const title = make("h3", {}, make("span", {}, `${index + 1}`), drawn.label);
    this.output = make("dd");
    this.evidence = make("dd");
    this.pairs = make("dl", { className: "pairs" },
      make("div", {}, make("dt", {}, "Output"), this.output), make("div", {}, make("dt", {}, "Evidence"), this.evidence));
    this.bits = drawn.bits.map((bit) => {
      const value = make("dd");
      this.pairs.append(make("div", {}, make("dt", {}, bit.replaceAll("_", " ")), value));
      return value;
    });
    this.element = make("li", { className: "card", id: `card-${drawn.name}` }, make("header", {}, title, this.pill));
    this.unused = make("p", { className: "unused", hidden: true });
    this.element.append(this.unused);
    this.gauges = drawn.gauges.map((gauge) => new Gauge(gauge));
    for (const gauge of this.gauges) this.element.append(...gauge.elements);
    this.attempts = make("div", { className: "attempts", hidden: true });
    this.timer = make("div", { className: "timer", hidden: true });
    this.timerText = make("span");
    this.timerBar = make("span");
    this.timer.append(this.timerText, make("span", { className: "bar" }, this.timerBar));
    this.hold = make("div", { className: "hold", hidden: true });
    this.element.append(this.pairs, this.attempts, this.timer, this.hold);
  }

  show(now, at, state) {
    const driven = now.phase === "inactive" && now.output;  // by maintenance: the automata know nothing of it
    this.element.dataset.phase = driven ? "driven" : now.phase;
    put(this.pill, now.blows ? "BLOWN OFF" : now.phase === "releasing" ? "RELEASING" : driven ? "OUTPUT ON" : now.state);
    put(this.output, now.output === null ? "not recorded" : now.output ? `● on${now.kept ? ", kept" : ""}` : "○ off");
    put(this.evidence, EVIDENCE[now.evidence] ?? "not recorded");
    this.bits.forEach((element, index) => put(element, now.bits[index] === undefined || now.bits[index] === null ? "?" : now.bits[index] ? "on" : "off"));
    this.unused.hidden = !now.unused;
    put(this.unused, now.unused ? `not used for ${state.part}` : "");
    this.gauges.forEach((gauge, index) => {
      gauge.markFor(state.judged);
      gauge.show(now.values[index] ?? null, index ? null : now.margin_kpa, this.drawn.margin_from);
    });
    this.showAttempt(now.attempt, now.phase);
    this.showTimer(now.timer, at);
    this.showHold(now.hold);
  }

  showAttempt(attempt, phase) {
    this.attempts.hidden = !attempt;
    if (!attempt) return;
    const key = JSON.stringify([attempt.number, attempt.confirmed, phase]);
    if (this.attemptKey !== key) {
      this.attemptKey = key;
      const dots = [];
      for (let number = 1; number <= attempt.of; number += 1) {
        const last = number === attempt.number;
        const kind = number > attempt.number ? "" : !last ? "failed" : attempt.confirmed ? "good" : phase === "pending" ? "now" : "failed";
        dots.push(make("i", { className: kind, "aria-hidden": "true" }));
      }
      this.attemptText = make("span");
      this.attempts.replaceChildren(...dots, this.attemptText);
    }
    put(this.attemptText, `attempt ${attempt.number} of ${attempt.of}${attempt.confirmed ? `, confirmed after ${attempt.seconds.toFixed(2)} s` : ""}`);
  }

  showTimer(timer, at) {
    this.timer.hidden = !timer;
    if (!timer) return;
    const left = Math.max(0, (timer.until - at) / 1e6);
    put(this.timerText, `${timer.what} in ${seconds(left)} of ${timer.of_s.toFixed(1)} s`);
    this.timerBar.style.width = `${(100 * left) / timer.of_s}%`;
  }

  showHold(hold) {
    this.hold.hidden = !hold;
    if (!hold) return;
    const falls = hold.leaks && hold.lost_in_s !== null;
    this.hold.className = `hold${falls ? " leak" : hold.secure === false || hold.leaks ? " weak" : ""}`;
    const left = falls ? (hold.lost_in_s > 0 ? `■ lost in ${seconds(hold.lost_in_s)}` : "■ lost") : hold.secure === false ? "▲ weak" : hold.leaks ? "▲ leaks" : "● secure";
    const right = hold.leak_kpa_s === null ? "" : hold.leaks ? `leak ${hold.leak_kpa_s.toFixed(2)} kPa/s` : "no leak";
    const text = hold.secure === null ? "● held" : left;
    if (this.holdKey !== text + right) {
      this.holdKey = text + right;
      this.hold.replaceChildren(make("span", {}, text), make("span", {}, right));
    }
  }
}

// One measured value against the marks of its thresholds.
class Gauge {
  constructor(drawn) {
    this.drawn = drawn;
    [this.marks] = Object.values(drawn.marks);
    this.value = make("b");
    this.margin = make("span", { className: "margin" });
    const unit = make("span", {}, drawn.own ? drawn.unit : `${drawn.unit}, ${drawn.label.toLowerCase()}`);
    this.elements = [make("div", { className: "reading" }, this.value, unit, this.margin), this.makeBar()];
  }

  x(value) {
    const { low, most } = this.drawn;
    return Math.max(0, Math.min(this.width, (this.width * (value - low)) / (most - low)));
  }

  // Drawn for the width that it has: its words have one size on every card.
  makeBar() {
    this.width = 0;
    this.fill = svg("rect", { class: "fill", x: 0, y: 18, width: 0, height: 14, rx: 3 });
    const box = this.box = svg("svg", { class: "gauge", "aria-hidden": "true" });
    new ResizeObserver(([{ contentRect }]) => {
      if (!contentRect.width || contentRect.width === this.width) return;
      this.width = contentRect.width;
      this.draw();
    }).observe(box);
    return box;
  }

  draw() {
    this.box.replaceChildren(svg("rect", { class: "track", x: 0, y: 18, width: this.width, height: 14, rx: 3 }), this.fill, ...this.makeMarks());
    this.fillTo(this.shown);
  }

  // Each part has its own thresholds.
  markFor(part) {
    const marks = this.drawn.marks[part] ?? [];
    if (marks === this.marks || (!marks.length && !this.marks.length)) return;
    this.marks = marks;
    if (this.width) this.draw();
  }

  // Words above and below in turn, moved apart so that none lies over another.
  makeMarks() {
    const marks = this.marks.map((mark) => ({ ...mark, x: this.x(mark.at) })).sort((a, b) => a.x - b.x);
    const ends = [-10, -10];
    const pen = document.createElement("canvas").getContext("2d");
    pen.font = `12px ${getComputedStyle(document.documentElement).getPropertyValue("--font")}`;
    return marks.flatMap((mark, index) => {
      const below = index % 2;
      const text = `${mark.word} ${+mark.at.toFixed(this.drawn.decimals)}`;
      const { width } = pen.measureText(text);
      const left = Math.min(this.width - width, Math.max(ends[below] + 6, mark.x - width / 2, 0));
      ends[below] = left + width;
      const words = svg("text", { x: left, y: below ? 49 : 10 });
      words.textContent = text;
      return [svg("line", { class: "mark", x1: mark.x, x2: mark.x, y1: 16, y2: 34 }),
        svg("line", { class: "lead", x1: mark.x, x2: left + width / 2, y1: below ? 34 : 16, y2: below ? 39 : 12 }), words];
    });
  }

  fillTo(value) {
    this.shown = value;
    this.fill.setAttribute("width", value === null || value === undefined ? 0 : this.x(value));
  }

  show(value, margin, from) {
    const { decimals } = this.drawn;
    put(this.value, value === null ? "–" : (Math.abs(value) < 0.5 / 10 ** decimals ? 0 : value).toFixed(decimals));
    this.fillTo(value);
    put(this.margin, value === null ? "no valid reading" : margin === null ? "" : `${margin >= 0 ? "+" : "−"}${Math.abs(margin).toFixed(1)} kPa from ${from || "its threshold"}`);
  }
}
