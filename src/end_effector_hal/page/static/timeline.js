// Lanes of states on a canvas, measured values below with uPlot, on one scale of time; a click opens the nearest event.
import { make } from "/static/dom.js";

const LEAST_LABELS = 118;
const MOST_LABELS = 180;
const AXIS_LABEL = 18;
const RIGHT = 16;
const LANE = 26;
const KEPT_S = 185;
const COLOURS = ["#0b6fc2", "#c2570c", "#0d8a5a", "#8a4fc7", "#a3781a", "#c23a6b"];

export class TimeLine {
  constructor(root, drawn, open) {
    this.drawn = drawn;
    this.open = open;
    this.span = 60;
    this.still = false;
    this.data = [[], ...drawn.curves.map(() => [])];
    this.changes = Object.fromEntries(drawn.lanes.map((lane) => [lane.name, []]));
    this.events = [];
    this.from = -this.span;
    this.to = 0;
    this.end = 0;
    this.root = root;
    this.canvas = make("canvas", { role: "img", "aria-label": "States over time" });
    this.canvas.style.height = `${drawn.lanes.length * LANE + 24}px`;
    const pen = this.pen();
    this.labels = Math.min(MOST_LABELS, Math.max(LEAST_LABELS, ...drawn.lanes.map((lane) => pen.measureText(lane.label).width + 16)));
    this.canvas.onclick = (event) => this.click(event);
    this.holder = make("div");
    this.marker = make("div", { className: "marker", hidden: true });
    root.replaceChildren(this.canvas, this.holder, this.marker);
    [this.part] = Object.keys(drawn.curves[0]?.marks ?? {});
    this.plots = this.makePlots();
    window.addEventListener("resize", () => this.resize());
    this.lastDrawn = 0;
  }

  spanTo(span) {
    this.span = span;
    this.from = this.to - span;
    this.draw();
  }

  holdStill() {
    this.still = !this.still;
    return this.still;
  }

  makePlots() {
    this.holder.replaceChildren();
    const curves = this.drawn.curves.map((each, index) => ({ ...each, index }));
    const groups = [...new Set(curves.map((each) => each.unit))].map((unit) => curves.filter((each) => each.unit === unit));
    return groups.map((group) => {
      const holder = make("div");
      this.holder.append(holder);
      const style = getComputedStyle(document.documentElement);
      const ink = style.getPropertyValue("--muted").trim();
      const grid = { stroke: style.getPropertyValue("--line").trim(), width: 1 };
      const most = Math.max(...group.map((each) => each.most));
      const low = Math.min(...group.map((each) => each.low));
      const options = {
        width: this.width(), height: 170, legend: { live: false }, cursor: { drag: { x: false, y: false }, y: false },
        padding: [12, RIGHT, 0, 0],
        scales: { x: { time: false, range: () => [this.from, this.to] }, y: { range: [low - (most - low) * 0.04, most] } },
        axes: [
          { stroke: ink, grid, ticks: grid, values: (_, ticks) => ticks.map((tick) => (tick < 0 ? "" : `${tick} s`)) },
          { stroke: ink, grid, ticks: grid, size: this.labels - AXIS_LABEL, label: group[0].unit, labelSize: AXIS_LABEL },
        ],
        series: [{}, ...group.map((each) => ({ label: each.label, stroke: COLOURS[each.index % COLOURS.length], width: 1.6, dash: each.index % 2 ? [7, 4] : undefined, points: { show: false } }))],
        hooks: { draw: [(plot) => drawMarks(plot, this.marks(group), ink)] },
      };
      return { plot: new window.uPlot(options, this.slice(group), holder), group };
    });
  }

  // The thresholds of the part by whose values the tool judges now.
  marks(group) {
    return group.flatMap((each) => (each.marks[this.part] ?? []).filter((mark) => !each.own || ["lost", "confirmed", "secure"].includes(mark.word)))
      .filter((mark, index, all) => all.findIndex((other) => other.word === mark.word && other.at === mark.at) === index);
  }

  markFor(state) {
    if (!state || state.judged === this.part) return;
    this.part = state.judged;
    for (const { plot } of this.plots) plot.redraw(false);
  }

  width() {
    return Math.max(200, this.root.clientWidth - 26);
  }

  slice(group) {
    return [this.data[0], ...group.map((each) => this.data[each.index + 1])];
  }

  add(view) {
    const epoch = this.drawn.epoch;
    for (const row of view.samples) {
      this.data[0].push((row[0] - epoch) / 1e6);
      for (let index = 1; index < row.length; index += 1) this.data[index].push(row[index]);
    }
    for (const change of view.changes) this.changes[change.lane]?.push({ at: (change.at - epoch) / 1e6, word: change.word });
    this.markFor(view.state);
    this.events.push(...view.log.filter((entry) => entry.detail && entry.kind !== "automaton"));
    if (this.still) return;
    this.to = this.end = (view.at - epoch) / 1e6;
    this.from = this.to - this.span;
    this.forget();
    if (!document.hidden && performance.now() - this.lastDrawn > 190) this.draw();
  }

  forget() {
    const from = this.to - KEPT_S;
    const first = this.data[0].findIndex((at) => at >= from);
    if (first > 500) for (const column of this.data) column.splice(0, first);
    for (const lane of Object.values(this.changes)) while (lane.length > 1 && lane[1].at < from) lane.shift();
    this.events = this.events.filter((entry) => (entry.at - this.drawn.epoch) / 1e6 >= from);
  }

  draw() {
    this.lastDrawn = performance.now();
    for (const { plot, group } of this.plots) plot.setData(this.slice(group));
    this.drawLanes();
  }

  // A whole recording at once: columns of samples in seconds and kPa, changes of the lanes, events.
  load(columns, changes, events, end) {
    this.data = columns;
    for (const change of changes) this.changes[change.lane]?.push({ at: (change.at - this.drawn.epoch) / 1e6, word: change.word });
    this.events = events;
    this.end = end;
    for (const { plot, group } of this.plots) plot.setData(this.slice(group));
  }

  // Another part of what was loaded.
  look(from, to) {
    this.from = from;
    this.to = to;
    for (const { plot } of this.plots) plot.setScale("x", { min: from, max: to });
    this.drawLanes();
  }

  // A line at one moment; outside of what is shown there is none.
  mark(at) {
    this.marker.hidden = at < this.from || at > this.to;
    this.marker.style.left = `${this.canvas.offsetLeft + this.x(at, this.width())}px`;
  }

  resize() {
    for (const { plot } of this.plots) plot.setSize({ width: this.width(), height: 170 });
    this.drawLanes();
  }

  x(at, width) {
    return this.labels + ((at - this.from) / (this.to - this.from)) * (width - this.labels - RIGHT);
  }

  pen() {
    const pen = this.canvas.getContext("2d");
    pen.font = `12px ${getComputedStyle(document.documentElement).getPropertyValue("--font")}`;
    return pen;
  }

  drawLanes() {
    const canvas = this.canvas;
    const ratio = window.devicePixelRatio || 1;
    const width = this.width();
    const height = this.drawn.lanes.length * LANE + 24;
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    canvas.style.width = `${width}px`;
    const pen = this.pen();
    pen.scale(ratio, ratio);
    const style = getComputedStyle(document.documentElement);
    const known = {};
    const colour = (name) => (known[name] ??= style.getPropertyValue(name).trim());
    pen.textBaseline = "middle";
    this.drawn.lanes.forEach((lane, index) => {
      const y = index * LANE + 20;
      pen.fillStyle = colour("--muted");
      pen.textAlign = "right";
      pen.fillText(fit(pen, lane.label, this.labels - 14), this.labels - 10, y + LANE / 2 - 2);
      pen.textAlign = "left";
      const changes = this.changes[lane.name];
      changes.forEach((change, number) => {
        const end = number + 1 < changes.length ? changes[number + 1].at : this.end;
        const from = Math.max(this.labels, this.x(change.at, width));
        const to = Math.min(width - RIGHT, this.x(end, width));
        if (to <= this.labels || from >= width - RIGHT || !change.word) return;
        const [fill, ink] = toneOf(change.word);
        pen.fillStyle = colour(fill);
        pen.fillRect(from, y, Math.max(1, to - from - 1), LANE - 4);
        pen.fillStyle = colour(ink);
        const text = fit(pen, change.word, to - from - 8);
        if (text === change.word || text.length > 4) pen.fillText(text, from + 5, y + LANE / 2 - 2);
      });
    });
    for (const entry of this.events) {
      const x = this.x((entry.at - this.drawn.epoch) / 1e6, width);
      if (x < this.labels || x > width - RIGHT) continue;
      pen.fillStyle = colour(entry.kind === "time-out" ? "--warn" : "--muted");
      pen.beginPath();
      pen.moveTo(x, 14);
      pen.lineTo(x - 4, 5);
      pen.lineTo(x + 4, 5);
      pen.fill();
    }
  }

  click(event) {
    const width = this.width();
    const x = event.offsetX;
    const at = this.from + ((x - this.labels) / (width - this.labels - RIGHT)) * (this.to - this.from);
    const nearest = this.events.map((entry) => [Math.abs(this.x((entry.at - this.drawn.epoch) / 1e6, width) - x), entry]).sort((a, b) => a[0] - b[0])[0];
    this.open(nearest && nearest[0] < 30 ? nearest[1] : null, Math.min(this.to, Math.max(this.from, at)));
  }
}

function toneOf(word) {
  if (/^o(n|ff)\b/.test(word)) return /: confirmed/.test(word) ? ["--ok-soft", "--ok"] : /: gone/.test(word) ? ["--idle-soft", "--muted"] : ["--soft", "--muted"];
  if (/ERROR|FAULT/.test(word)) return ["--bad-soft", "--bad"];
  if (/RELEASING/.test(word)) return ["--release-soft", "--release"];
  if (/PENDING|GRIPPING|ING$/.test(word)) return ["--busy-soft", "--busy"];
  if (/^(OFF|STAND_BY|RETRACTED|OPEN|INACTIVE|UNKNOWN)$/.test(word)) return ["--idle-soft", "--muted"];
  return ["--ok-soft", "--ok"];
}

function fit(pen, text, width) {
  if (pen.measureText(text).width <= width) return text;
  if (width < 14) return "";
  let cut = text;
  while (cut.length && pen.measureText(`${cut}…`).width > width) cut = cut.slice(0, -1);
  return cut ? `${cut}…` : "";
}

function drawMarks(plot, marks, ink) {
  const pen = plot.ctx;
  const ratio = window.devicePixelRatio || 1;
  pen.save();
  pen.strokeStyle = ink;
  pen.fillStyle = ink;
  pen.setLineDash([3 * ratio, 3 * ratio]);
  pen.font = `${10.5 * ratio}px sans-serif`;
  pen.textAlign = "left";
  const labels = [];
  let last = Infinity;
  for (const mark of [...marks].sort((a, b) => a.at - b.at)) {
    const y = plot.valToPos(mark.at, "y", true);
    pen.beginPath();
    pen.moveTo(plot.bbox.left, y);
    pen.lineTo(plot.bbox.left + plot.bbox.width, y);
    pen.stroke();
    if (last - y > 11 * ratio) {
      labels.push([mark.word, y]);
      last = y;
    } else if (!labels[labels.length - 1][0].split(", ").includes(mark.word)) {
      labels[labels.length - 1][0] += `, ${mark.word}`;
    }
  }
  pen.textBaseline = "middle";
  const paper = getComputedStyle(document.documentElement).getPropertyValue("--paper").trim();
  for (const [word, y] of labels) {
    const width = pen.measureText(word).width;
    pen.fillStyle = paper;
    pen.fillRect(plot.bbox.left + 6 * ratio, y - 6 * ratio, width + 8 * ratio, 12 * ratio);
    pen.fillStyle = ink;
    pen.fillText(word, plot.bbox.left + 10 * ratio, y);
  }
  pen.restore();
}
