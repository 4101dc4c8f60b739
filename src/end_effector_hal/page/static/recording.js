// A recording: its moments, its log and its timeline are here as a whole; scrubbing asks nobody.
import { Cards } from "/static/cards.js";
import { Log } from "/static/log.js";
import { TimeLine } from "/static/timeline.js";
import { Automata } from "/static/automata.js";
import { Differences } from "/static/differences.js";
import { identity, interlocks, lateness, overview, showEvent, spans } from "/static/panels.js";
import { byId, make, put } from "/static/dom.js";

const AGAIN_MS = 500;
const GROWN_MS = 3000;
const MARKED = new Set(["transition", "time-out"]);
const QUIET = new Set(["automaton"]);

class Recording {
  constructor(content) {
    this.content = content;
    this.drawn = content.drawn;
    this.epoch = content.drawn.epoch;
    this.times = content.times;
    this.tracks = Object.entries(content.tracks).map(([path, [steps, values]]) => {
      let number = 0;
      return { path: path.split("."), numbers: steps.map((step) => (number += step)), values };
    });
    this.log = content.log.map((entry) => (entry.detail ? { ...entry, detail: { ...entry.detail, edges: entry.detail.edges.map((edge) => content.edges[edge]) } } : entry));
    this.events = this.log.filter((entry) => !QUIET.has(entry.kind));
    this.begin = content.recording.begin_s;
    this.end = content.recording.end_s;
  }

  seconds(entry) {
    return (entry.at - this.epoch) / 1e6;
  }

  // What the page shows at a moment: the newest value of each track.
  view(at) {
    const number = after(this.times, Math.round(at * 1e6)) - 1;
    const found = { at: this.epoch + at * 1e6, state: null, cards: [], interlocks: [], automata: {} };
    const state = {};
    let known = false;
    for (const { path, numbers, values } of this.tracks) {
      const index = after(numbers, number) - 1;
      if (index < 0) continue;
      const value = values[index];
      const [room, name, key] = path;
      if (room === "state") {
        if (name === undefined) known = value; else state[name] = value;
      } else if (room === "cards") (found.cards[name] ??= {})[key] = value;
      else if (room === "interlocks") found.interlocks[name] = value;
      else if (value !== null) found.automata[name] = value;
    }
    if (known) found.state = state; else found.cards = null;
    found.proven = this.content.summary.holds;
    return found;
  }

  entriesUntil(at) {
    return after(this.log, this.epoch + Math.round(at * 1e6), (entry) => entry.at);
  }

  next(at) {
    return this.events[after(this.events, this.epoch + Math.round(at * 1e6), (entry) => entry.at)];
  }

  previous(at) {
    let index = after(this.events, this.epoch + Math.round(at * 1e6) - 1, (entry) => entry.at) - 1;
    const time = this.events[index]?.at;
    while (index > 0 && this.events[index - 1].at === time) index -= 1;
    return this.events[index];
  }

  // Where something is known: before it every card is empty.
  firstEvent() {
    const found = this.events.find((entry) => MARKED.has(entry.kind) && this.view(this.seconds(entry)).state);
    return found ? Math.max(this.begin, this.seconds(found)) : this.begin;
  }

  firstGrip() {
    const found = this.content.changes.find((change) => change.lane === "" && change.word === "GRIPPING");
    return found ? this.seconds(found) : null;
  }
}

// What the address says: the run of a file with several, a moment or an event.
function asksFor(name) {
  return new URLSearchParams(location.hash.slice(1)).get(name);
}

// How many of them are at most `most`; they are in order.
function after(list, most, key = (each) => each) {
  let low = 0;
  let high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (key(list[middle]) <= most) low = middle + 1; else high = middle;
  }
  return low;
}

class Player {
  constructor(recordings) {
    this.recordings = recordings;
    this.main = recordings[0];
    this.at = this.main.firstEvent();
    this.shift = 0;
    this.playing = false;
    this.dirty = true;
    this.selected = null;
    this.begin = this.main.begin;
    this.end = Math.max(...recordings.map((each) => each.end));
    const open = (entry, at) => this.open(entry, at);
    byId("second").hidden = recordings.length < 2; // what is hidden has no width to be drawn in
    this.lines = recordings.map((each, index) => new TimeLine(byId(index ? "second" : "timeline"), each.drawn, index ? (entry, at) => this.openOther(entry, at) : open));
    recordings.forEach((each, index) => {
      const [times, ...columns] = each.content.samples;
      this.lines[index].load([times.map((ms) => ms / 1000), ...columns], each.content.changes, each.events.filter((entry) => MARKED.has(entry.kind)), each.end);
    });
    this.show(0);
    this.span = this.end - this.begin > 180 ? 60 : NaN;
    for (const button of document.querySelectorAll("[data-span]")) button.setAttribute("aria-pressed", String(Object.is(Number(button.dataset.span), this.span)));
    spans((span) => {
      this.span = span;
      this.look(true);
      this.draw();
    });
    this.bind();
    this.look(true);
    this.fromAddress();
    requestAnimationFrame((now) => this.frame(now));
  }

  // Which of the recordings the cards, the log and the automata show.
  show(index) {
    this.shown = this.recordings[index];
    this.offset = () => (index ? this.shift : 0);
    const { drawn, log } = this.shown;
    identity(drawn);
    this.cards = new Cards(byId("cards"), drawn);
    this.automata = new Automata(byId("automata"), byId("automata-tabs"), drawn);
    this.log = new Log(byId("log"), drawn, (entry) => this.open(entry));
    this.log.load(log);
    const traced = this.shown.tracks.some((track) => track.path[0] === "interlocks");
    for (const name of ["interlocks", "automata"]) byId(name).closest("section").hidden = !traced;
    byId("event").hidden = true;
    this.dirty = true;
  }

  bind() {
    const scrub = byId("scrub");
    scrub.min = this.begin;
    scrub.max = this.end;
    scrub.oninput = () => this.goTo(Number(scrub.value));
    scrub.onchange = () => this.toAddress();
    byId("play").onclick = () => this.play(!this.playing);
    byId("next").onclick = () => this.step(1);
    byId("previous").onclick = () => this.step(-1);
    window.addEventListener("hashchange", () => this.fromAddress());
    document.addEventListener("keydown", (event) => this.key(event));
    for (const row of document.querySelectorAll("[data-at]")) row.addEventListener("click", () => this.goTo(Number(row.dataset.at) + Number(row.dataset.which) * this.shift));
    if (this.recordings.length < 2) return;
    byId("compare").hidden = byId("first-name").hidden = byId("second-name").hidden = false;
    put("first-name", this.main.content.recording.name);
    put("second-name", this.recordings[1].content.recording.name);
    byId("shown").replaceChildren(...this.recordings.map((each, index) => make("option", { value: index, textContent: each.content.recording.name })));
    byId("shown").onchange = (event) => this.show(Number(event.target.value));
    byId("shift").oninput = (event) => this.shiftTo(Number(event.target.value) || 0);
    this.differences = new Differences((each) => this.openDifference(each));
    byId("align").onclick = () => {
      const [first, second] = this.recordings.map((each) => each.firstGrip());
      if (first === null || second === null) return;
      this.align(first - second);
    };
  }

  align(seconds) {
    byId("shift").value = seconds.toFixed(3);
    this.shiftTo(seconds);
  }

  shiftTo(seconds) {
    const other = this.recordings[1];
    this.shift = seconds;
    this.begin = Math.min(this.main.begin, other.begin + seconds);
    this.end = Math.max(this.main.end, other.end + seconds);
    byId("scrub").min = this.begin;
    byId("scrub").max = this.end;
    this.look(true);
    this.dirty = true;
  }

  key(event) {
    const where = event.target.tagName;
    if (event.ctrlKey || event.altKey || event.metaKey || ["INPUT", "SELECT", "TEXTAREA"].includes(where)) return;
    const acts = {
      ArrowRight: () => this.step(1), ArrowLeft: () => this.step(-1), Home: () => this.goTo(this.begin), End: () => this.goTo(this.end),
    };
    if (event.key === " " && !["BUTTON", "A"].includes(where)) acts[" "] = () => this.play(!this.playing);
    if (!acts[event.key]) return;
    event.preventDefault();
    acts[event.key]();
  }

  step(way) {
    this.play(false);
    const at = this.at - this.offset();
    const entry = way > 0 ? this.shown.next(at) : this.shown.previous(at);
    if (entry) this.open(entry, at, false); else this.goTo(way > 0 ? this.end : this.begin);
  }

  open(entry, at, scroll = true) {
    if (entry) this.goTo(this.shown.seconds(entry) + this.offset(), entry); else if (at !== undefined) this.goTo(at);
    showEvent(entry, this.shown.epoch, scroll);
    this.toAddress();
  }

  openOther(entry, at) {
    const other = this.recordings[1];
    this.goTo((entry ? other.seconds(entry) : at) + this.shift);
    showEvent(entry, other.epoch);
  }

  // The moment of a difference in both of them, under each other.
  openDifference({ first_s: first, second_s: second, shift_s: shift }) {
    this.play(false);
    this.align(shift);
    this.goTo(first ?? second + shift);
    this.toAddress();
  }

  play(on) {
    if (on && this.at >= this.end) this.at = this.begin;
    this.playing = on;
    this.last = performance.now();
    byId("play").setAttribute("aria-pressed", String(on));
    put("play", on ? "❚❚ Pause" : "▶ Play");
    if (!on) this.toAddress();
  }

  goTo(at, selected = null) {
    this.at = Math.min(this.end, Math.max(this.begin, at));
    this.selected = selected;
    if (!selected) byId("event").hidden = true;
    this.differences?.choose(null);
    this.dirty = true;
  }

  frame(now) {
    if (this.playing) {
      this.goTo(this.at + ((now - this.last) / 1000) * Number(byId("speed").value));
      this.last = now;
      if (this.at >= this.end) this.play(false);
    }
    if (this.dirty) this.draw();
    requestAnimationFrame((next) => this.frame(next));
  }

  // The part of the timeline that is shown: it follows the moment page by page.
  look(redraw) {
    const all = Number.isNaN(this.span);
    const line = this.lines[0];
    if (!redraw && (all || (this.at >= line.from && this.at <= line.to))) return;
    const from = all ? this.begin : Math.max(this.begin, Math.min(this.at - this.span / 10, this.end - this.span));
    const to = all ? Math.max(this.end, from + 0.1) : from + this.span;
    this.lines.forEach((each, index) => each.look(from - index * this.shift, to - index * this.shift));
  }

  draw() {
    this.dirty = false;
    const at = this.at - this.offset();
    const view = this.shown.view(at);
    // what asks for sizes comes before what changes them: the browser lays out once
    this.automata.show(view.automata, view.at);
    this.look(false);
    this.lines.forEach((line, index) => {
      const [each, moment] = [this.recordings[index], this.at - index * this.shift];
      line.mark(moment);
      line.markFor((each === this.shown ? view : each.view(moment)).state);
    });
    overview(view);
    lateness(view.state);
    this.cards.show(view);
    interlocks(view.interlocks);
    this.log.at(this.shown.entriesUntil(at));
    put("moment", `${this.at.toFixed(3)} s`);
    byId("scrub").value = this.at;
    byId("scrub").setAttribute("aria-valuetext", `${this.at.toFixed(1)} seconds${view.state ? `, ${view.state.word}` : ""}`);
    byId("link").href = this.address();
    if (this.recordings.length > 1) {
      const now = this.recordings.map((each, index) => [each.content.recording.name, each.view(this.at - index * this.shift).state]);
      const [first, second] = now.map(([, state]) => state?.word);
      byId("compare").classList.toggle("differs", first !== second);
      put("other", now.map(([name, state]) => `${name}: ${state ? `${state.word}${state.held ? ", held" : ""}` : "nothing yet"}`).join(" · "));
    }
  }

  address() {
    const moment = this.selected ? `e=${this.selected.n}` : `t=${this.at.toFixed(3)}`;
    return asksFor("run") === null ? `#${moment}` : `#run=${asksFor("run")}&${moment}`;
  }

  toAddress() {
    history.replaceState(null, "", this.address());
  }

  fromAddress() {
    const entry = this.shown.log.find((each) => each.n === Number(asksFor("e") ?? NaN));
    const at = Number.parseFloat(asksFor("t"));
    if (entry) this.open(entry); else if (Number.isFinite(at)) this.goTo(at);
  }
}

function about(recordings) {
  const days = recordings.map((each) => each.content.recording.started.slice(0, 19).replace("T", " "));
  put("about", `Recording of ${days.join(" and of ")} UTC, nothing is commanded here.`);
  const notes = recordings.flatMap((each) => each.content.recording.notes.map((note) => (recordings.length > 1 ? `${each.content.recording.name}: ${note}` : note)));
  tell(notes);
  const first = recordings[0].content;
  put("fact-verdict", first.summary.proven ? `${first.summary.holds ? "●" : "■"} ${first.summary.proven}` : "○ Not verified: `eehal verify` has not proven this description here.");
  byId("summaries").replaceChildren(...recordings.map((each, index) => summary(each.content, index)));
}

function tell(notes) {
  const list = byId("notes");
  list.append(...notes.map((note) => make("li", { textContent: note })));
  list.hidden = !list.children.length;
}

function summary(content, index) {
  const { recording, summary: told, drawn } = content;
  const box = make("article", {}, make("p", { className: "story", textContent: `${told.story}${recording.whole ? "" : ". The recording is not whole: see the notes above"}.` }));
  const rows = told.goals.map((goal) => {
    const jump = make("button", { type: "button", className: "small", textContent: `${goal.at_s.toFixed(1)} s` });
    jump.dataset.at = goal.at_s;
    jump.dataset.which = index;
    const took = goal.took_s === null ? "–" : `${goal.took_s.toFixed(2)} s`;
    const most = goal.at_most_s === null ? "–" : `${goal.at_most_s.toFixed(2)} s${told.holds ? " (proven)" : ""}`;
    const row = make("tr", {}, make("td", {}, jump), make("td", {}, goal.what), make("td", { className: goal.ok ? "good" : "failed" }, `${goal.ok ? "●" : "■"} ${goal.outcome}`),
      make("td", {}, took), make("td", {}, most), make("td", {}, ...goal.why.map((why) => make("div", {}, why))));
    return row;
  });
  if (rows.length) {
    const head = make("tr", {}, ...["At", "What", "Outcome", "Took", "At most", "Why"].map((text) => make("th", { scope: "col", textContent: text })));
    box.append(make("div", { className: "wide-table" }, make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows))));
  }
  if (told.more_goals) box.append(make("p", { textContent: `And ${told.more_goals} more.` }));
  const facts = {
    Tool: drawn.name, Recording: `${recording.name}, ${(recording.end_s - recording.begin_s).toFixed(1)} s${recording.whole ? "" : ", not whole"}`,
    Description: `${recording.hash} (${drawn.source})`, Automata: recording.model, "Recorded by": `version ${recording.version || "unknown"}`,
    "Shown by": `version ${recording.shown_by}`, Moments: `${content.times.length}, at most ${recording.step_s.toFixed(2)} s apart while readings change`,
  };
  box.append(make("dl", { className: "versions" }, ...Object.entries(facts).map(([name, text]) => make("div", {}, make("dt", {}, name), make("dd", {}, text)))));
  return box;
}

function judged(verdicts) {
  const place = byId("judged");
  const words = verdicts.map((verdict) => (verdict ? `${{ true: "●", false: "■", null: "○" }[verdict.ok]} ${verdict.text}` : "○ Replay and monitor: being judged …"));
  put(place, [...new Set(words)].join(" "));
  place.className = verdicts.every((each) => each?.ok) ? "good" : verdicts.some((each) => each?.ok === false) ? "failed" : "";
}

function judgedInFull(verdict, several, name) {
  tell(verdict.traces.flatMap((trace) => [...(trace.ok && !trace.notes.length ? [] : [`${trace.trace}: ${trace.text}`]), ...trace.notes.map((note) => `${trace.trace}: ${note}`)]).map((text) => (several ? `${name}: ${text}` : text)));
}

async function asked(path, progress) {
  for (;;) {
    const answer = await fetch(path);
    if (answer.status === 200) return answer.json();
    const said = answer.status === 202 ? await answer.json() : null;
    if (!said) throw new Error((await answer.text()).trim());
    progress(said);
    await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
  }
}

function ready(contents) {
  const recordings = contents.map((content) => new Recording(content));
  about(recordings);
  byId("player").hidden = false;
  byId("news").hidden = true;
  document.body.classList.remove("stale");
  return new Player(recordings);
}

// From the process of `eehal page`: the recordings, then what the replay says, then whether there is more by now.
async function fromProcess() {
  const contents = [];
  const { count } = await asked("recordings", () => {});
  for (let number = 0; number < count; number += 1) {
    contents.push(await asked(`recording/${number}`, (said) => put("news", said.progress === null ? "Reading the recording …" : `Reading the recording: ${Math.round(said.progress * 100)} %`)));
  }
  const { differences } = ready(contents);
  if (differences) asked("differences", () => {}).catch((error) => ({ said: error.message, rows: [], more: "" })).then((found) => differences.show(found));
  const verdicts = contents.map(() => null);
  judged(verdicts);
  for (let number = 0; number < count; number += 1) {
    verdicts[number] = await asked(`recording/${number}/verdict`, () => {});
    judged(verdicts);
    judgedInFull(verdicts[number], count > 1, contents[number].recording.name);
  }
  const timer = setInterval(async () => {
    try {
      const { grown } = await (await fetch("recordings")).json();
      if (!grown) return;
      clearInterval(timer);
      byId("news").hidden = false;
      put("news", "The recording has grown since it was read. Load the page again to see the rest.");
    } catch { /* the page works without its process */ }
  }, GROWN_MS);
}

function fromFile(text) {
  const { contents, verdicts, differences } = JSON.parse(text);
  const player = ready(contents);
  if (differences) player.differences.show(differences);
  judged(verdicts);
  verdicts.forEach((verdict, index) => judgedInFull(verdict, contents.length > 1, contents[index].recording.name));
}

// A file with several runs: their table, or the one that the address names.
function fromRuns(rows) {
  const shown = asksFor("run");
  window.addEventListener("hashchange", () => {
    if (asksFor("run") !== shown) location.reload();
  });
  const run = shown === null ? null : document.getElementById(`run-${shown}`);
  if (run) {
    byId("all-runs").hidden = false;
    fromFile(run.textContent);
    return;
  }
  byId("news").hidden = true;
  document.body.className = "recorded index";
  put("about", `${rows.length} runs in the order of their names, nothing is commanded here.`);
  const good = rows.filter((row) => row.ok).length;
  const bad = rows.filter((row) => row.ok === false).length;
  put("judged", `${bad ? "■" : "●"} Replay and monitor: ${good} with identical decisions, every step allowed by the automata${bad ? `; ${bad} not, or not wholly read` : ""}.`);
  byId("judged").className = bad ? "failed" : "good";
  byId("runs").hidden = false;
  byId("runs-rows").replaceChildren(...rows.map((row, number) => make("tr", {},
    make("td", {}, document.getElementById(`run-${number}`) ? make("a", { href: `#run=${number}`, textContent: row.name }) : row.name),
    make("td", {}, row.started.slice(0, 19).replace("T", " ")), make("td", {}, row.story),
    make("td", {}, row.length_s === null ? "–" : `${row.length_s.toFixed(1)} s`), make("td", {}, row.tool),
    make("td", { className: { true: "good", false: "failed", null: "" }[row.ok] }, `${{ true: "●", false: "■", null: "○" }[row.ok]} ${row.replay}`))));
}

function failed(error) {
  byId("news").hidden = false;
  put("news", error.message);
}

const [index, inside] = ["index", "recordings"].map((name) => document.getElementById(name));
if (index) fromRuns(JSON.parse(index.textContent)); else if (inside) fromFile(inside.textContent); else fromProcess().catch(failed);
