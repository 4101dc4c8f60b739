// The executed automata as they stand in their UPPAAL file; where they are is lit, the edge that was taken last is bold.
import { make, put, svg } from "/static/dom.js";

const RADIUS = 11;
const SCALE = 0.82;

export class Automata {
  constructor(box, tabs, drawn) {
    this.drawn = drawn.automata;
    this.cards = Object.fromEntries(drawn.cards.map((card) => [card.name, card.label]));
    this.clocks = make("div", { className: "clocks" });
    this.figure = make("div", { className: "drawing", tabIndex: 0, role: "region", "aria-label": "Drawing of the automaton, to be scrolled" });
    this.which = make("select", { id: "automata-edge" });
    this.which.addEventListener("change", () => this.showEdge());
    this.neededTitle = make("p", { className: "spoken-title" });
    this.needed = make("ul", { className: "spoken needed" });
    this.spokenTitle = make("p", { className: "spoken-title" });
    this.spoken = make("ul", { className: "spoken" });
    box.replaceChildren(this.clocks, this.figure,
      make("label", { className: "edge-choice" }, "Edge ", this.which),
      make("details", { id: "automata-requirements" }, make("summary", { textContent: "Requirements that need this edge, or speak of it" }),
        this.neededTitle, this.needed, this.spokenTitle, this.spoken));
    this.fold = box.closest("details");
    this.fold.ontoggle = () => {  // what is folded has no size to scroll in
      this.key = "";
      if (this.last) this.show(...this.last);
    };
    this.buttons = this.drawn.processes.map((process) => {
      const label = process.who ? this.cards[process.who] : process.name;
      const button = make("button", { type: "button", className: "small", textContent: label });
      button.addEventListener("click", () => this.choose(process));
      return button;
    });
    tabs.replaceChildren(...this.buttons);
    if (this.drawn.processes.length) this.choose(this.drawn.processes[0]);
  }

  choose(process, last = this.last) {
    this.process = process;
    this.clocks.replaceChildren();
    this.buttons.forEach((button, index) => button.setAttribute("aria-pressed", String(this.drawn.processes[index] === process)));
    const template = this.drawn.templates.find((each) => each.name === process.template);
    this.template = template;
    this.figure.replaceChildren(this.picture(template));
    const name = (number) => template.locations[number].name || "?";
    this.which.replaceChildren(make("option", { value: "", textContent: "that was taken last" }),
      ...template.edges.map((edge, index) => make("option", { value: String(index), textContent: `${index + 1}. ${name(edge.source)} → ${name(edge.target)}` })));
    this.key = "";
    this.last = last;
    this.showEdge();
    if (last) this.show(...last);
  }

  picture(template) {
    const spots = [...template.locations.map((each) => [each.x, each.y]), ...template.edges.flatMap((edge) => edge.way)];
    const texts = [...template.locations, ...template.edges].flatMap((each) => each.labels);
    const ends = texts.map((label) => [label.x + Math.max(...label.lines.map((line) => line.length)) * 6.2, label.y + label.lines.length * 15]);
    const all = [...spots, ...ends, ...texts.map((label) => [label.x, label.y])];
    const left = Math.min(...all.map((spot) => spot[0])) - 20;
    const top = Math.min(...all.map((spot) => spot[1])) - 20;
    const width = Math.max(...all.map((spot) => spot[0])) - left + 20;
    const height = Math.max(...all.map((spot) => spot[1])) - top + 20;
    this.corner = [left, top];
    const picture = svg("svg", { viewBox: `${left} ${top} ${width} ${height}`, width: width * SCALE, height: height * SCALE, role: "img", "aria-label": `Automaton ${template.name}` });
    this.edges = template.edges.map((edge) => this.edge(edge));
    this.places = template.locations.map((each) => svg("circle", { class: "place", cx: each.x, cy: each.y, r: RADIUS }));
    this.names = template.locations.map((each) => each.name);
    this.titles = [];
    picture.append(...this.edges.flat(), ...this.places);
    template.locations.forEach((each) => {
      if (each.initial) picture.append(svg("circle", { class: "edge", cx: each.x, cy: each.y, r: RADIUS - 3.5 }));
      this.titles.push(...this.labels(each.labels, each.name, picture));
    });
    for (const edge of template.edges) this.labels(edge.labels, "", picture);
    return picture;
  }

  centre(location) {
    const spot = this.drawn.templates.find((each) => each.name === this.process.template).locations.find((each) => each.name === location);
    if (!spot) return;
    const box = this.figure;
    box.scrollLeft = (spot.x - this.corner[0]) * SCALE - box.clientWidth / 2;
    box.scrollTop = (spot.y - this.corner[1]) * SCALE - box.clientHeight / 2;
  }

  labels(labels, name, picture) {
    const titles = [];
    for (const label of labels) {
      if (label.kind === "comments") continue;
      label.lines.forEach((line, index) => {
        const text = svg("text", { class: label.kind, x: label.x, y: label.y + 12 + 15 * index });
        text.textContent = line;
        picture.append(text);
        if (label.kind === "name") titles.push([name, text]);
      });
    }
    return titles;
  }

  edge(edge) {
    let way = edge.way;
    if (way.length === 2 && way[0][0] === way[1][0] && way[0][1] === way[1][1]) {
      const [x, y] = way[0];
      way = [way[0], [x - 34, y - 46], [x + 34, y - 46], way[1]];
    }
    way = [towards(way[0], way[1]), ...way.slice(1, -1), towards(way[way.length - 1], way[way.length - 2])];
    const line = svg("polyline", { class: "edge", points: way.map((spot) => spot.join(",")).join(" ") });
    const reach = svg("polyline", { class: "reach", points: way.map((spot) => spot.join(",")).join(" ") });
    reach.addEventListener("click", () => {
      this.which.value = String(this.template.edges.indexOf(edge));
      this.showEdge();
    });
    return [line, head(way[way.length - 2], way[way.length - 1]), reach];
  }

  // The requirements that need an edge: each was seen to fail of an edit of it. And those that speak of it: they name
  // one of its ends, or what it writes.
  showEdge() {
    const now = this.last && this.last[0][this.process.name];
    const index = this.which.value === "" ? (now && now.last ? now.last.edge : -1) : Number(this.which.value);
    this.edges.forEach((edge, number) => edge[0].classList.toggle("chosen", this.which.value !== "" && number === index));
    const edge = this.template.edges[index];
    const listed = (numbers) => numbers.map((number) => this.drawn.requirements[number])
      .map((each) => make("li", {}, make("b", { textContent: each.id }), ` ${each.sentence}`));
    const { edits, by } = edge ? edge.needed : { edits: 0, by: [] };
    put(this.neededTitle, !edge ? "" : edits ? `Needed by ${by.length} requirements (edits of this edge that were judged: ${edits}).`
      : "Which requirements need it is not known: no edit of it was judged.");
    this.needed.replaceChildren(...listed(by));
    const rest = edge ? edge.requirements.filter((number) => !by.includes(number)) : [];
    put(this.spokenTitle, edge ? `${rest.length} ${by.length ? "others" : "requirements"} speak of it.` : "None was taken yet.");
    this.spoken.replaceChildren(...listed(rest));
  }

  show(automata, at) {
    this.last = [automata, at];
    if (!this.fold.open) return;
    const now = automata[this.process.name];
    if (!now) {
      if (this.key) this.choose(this.process, null);
      return;
    }
    const key = `${now.location} ${now.last ? now.last.at : ""}`;
    if (key !== this.key) {
      this.key = key;
      this.centre(now.location);
      this.places.forEach((place, index) => place.classList.toggle("here", this.names[index] === now.location));
      for (const [name, text] of this.titles) text.classList.toggle("here", name === now.location);
      this.edges.forEach((edge, index) => edge.forEach((each) => each.classList.toggle("last", Boolean(now.last) && now.last.edge === index)));
      this.showEdge();
      this.bars = now.clocks.map((clock) => ({ text: make("span"), bar: make("span") }));
      const here = make("div", {}, make("span", {}, `in ${now.location}`));
      this.clocks.replaceChildren(here, ...this.bars.map((each) => make("div", {}, each.text, make("span", { className: "bar" }, each.bar))));
    }
    now.clocks.forEach((clock, index) => {
      const bar = this.bars[index];
      if (!bar) return;
      const seconds = (at - clock.since) / 1e6;
      put(bar.text, `clock ${clock.name} ${seconds.toFixed(1)} s${clock.limit_ms ? ` of ${(clock.limit_ms / 1000).toFixed(2)} s` : ""} (${clock.bound})`);
      bar.bar.style.width = clock.limit_ms ? `${Math.min(100, (100_000 * seconds) / clock.limit_ms)}%` : "0";
    });
  }
}

function towards(from, to) {
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]) || 1;
  return [from[0] + ((to[0] - from[0]) * RADIUS) / length, from[1] + ((to[1] - from[1]) * RADIUS) / length];
}

function head(before, end) {
  const length = Math.hypot(end[0] - before[0], end[1] - before[1]) || 1;
  const along = [(end[0] - before[0]) / length, (end[1] - before[1]) / length];
  const base = [end[0] - 10 * along[0], end[1] - 10 * along[1]];
  const side = [-along[1] * 3.6, along[0] * 3.6];
  const corners = [end, [base[0] + side[0], base[1] + side[1]], [base[0] - side[0], base[1] - side[1]]];
  return svg("polygon", { class: "head", points: corners.map((spot) => spot.join(",")).join(" ") });
}
