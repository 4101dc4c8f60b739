// The page: gets views from its process, shows them. It decides nothing: every sentence comes from the HAL.
import { Cards } from "/static/cards.js";
import { Commands } from "/static/commands.js";
import { Log } from "/static/log.js";
import { TimeLine } from "/static/timeline.js";
import { Automata } from "/static/automata.js";
import { byId, put, setTone, seconds } from "/static/dom.js";

const STATE_TONES = {
  OFF: "idle", STAND_BY: "idle", GRIPPING: "busy", GRIPPED: "ok", RELEASING: "release", GRIP_ERROR: "bad", RELEASE_ERROR: "bad",
};
const CHANGER_TONES = { LOCKED: "ok", UNLOCKED: "warn", UNLOCKING: "busy", LOCKING: "busy", FAULT: "bad", UNKNOWN: "warn" };

const page = pageNumber();
let drawn = null;
let parts = null;
let heardAt = 0;
let lastView = null;

function pageNumber() {
  let number = sessionStorage.getItem("eehal-page");
  if (!number) {
    number = [...crypto.getRandomValues(new Uint8Array(12))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
    sessionStorage.setItem("eehal-page", number);
  }
  return number;
}

function connect() {
  const source = new EventSource(`/events?page=${page}`);
  source.addEventListener("drawn", (event) => begin(JSON.parse(event.data)));
  source.addEventListener("view", (event) => {
    heardAt = performance.now();
    show(JSON.parse(event.data));
  });
  source.addEventListener("error", () => {
    if (source.readyState === EventSource.CLOSED) {
      fetch("/", { method: "HEAD" }).then((answer) => {
        if (answer.status === 401) ended = "This page belongs to an earlier start. Open the address that eehal page has printed.";
      }).catch(() => {});
      setTimeout(connect, 1000);
    }
  });
}
let ended = "";

function begin(content) {
  drawn = content;
  document.title = content.name;
  put("tool-name", content.name);
  put("tool-summary", content.summary);
  const changer = content.lanes.some((lane) => lane.name === "tool changer");
  document.querySelector(".overview").classList.toggle("no-changer", !changer);
  byId("panel-changer").hidden = !changer;
  parts = {
    cards: new Cards(byId("cards"), content),
    commands: new Commands(page, content),
    log: new Log(byId("log"), content, showEvent),
    timeline: new TimeLine(content, showEvent),
    automata: new Automata(byId("automata"), byId("automata-tabs"), content),
  };
}

function show(view) {
  if (!parts) return;
  lastView = view;
  freshness(view.news);
  facts(view);
  overview(view);
  parts.cards.show(view);
  parts.commands.show(view);
  parts.log.add(view.log);
  parts.timeline.add(view);
  parts.automata.show(view.automata);
  interlocks(view.interlocks);
  put("pages", view.pages > 1 ? `${view.pages} pages are open.` : "");
}

function freshness(news) {
  document.body.classList.toggle("stale", !news.fresh);
  const bar = byId("news");
  bar.hidden = news.fresh;
  if (!news.fresh) {
    const age = news.age_s === null ? "No news yet" : `No news for ${seconds(news.age_s)}`;
    bar.textContent = `${age}. ${news.why} What you see is old.`;
  }
}

// The page's own process may be gone as well: then nothing comes at all.
setInterval(() => {
  const age = (performance.now() - heardAt) / 1000;
  if (heardAt && age > 1.2) {
    freshness({ fresh: false, age_s: age, why: ended || "The process of this page is not heard." });
    if (parts) parts.commands.unheard();
  }
}, 200);

function facts(view) {
  const state = view.state;
  const rate = `${view.rate_hz.toFixed(view.rate_hz < 10 ? 1 : 0)} of ${drawn.expected_hz.toFixed(drawn.expected_hz < 10 ? 1 : 0)} Hz`;
  put("fact-rate", state ? `${state.link_up ? "up" : "DOWN"}, ${rate}` : rate);
  put("fact-late", state ? `${state.worst_late_ms.toFixed(1)} ms of ${state.bound_ms} ms${state.missed ? `, ${state.missed} too late` : ""}` : "–");
  const mark = view.verdict.holds === null ? "○" : view.verdict.holds ? "●" : "■";
  const when = view.verdict.at ? ` ${view.verdict.at.slice(0, 16).replace("T", " ")}` : "";
  put("fact-verdict", `${mark} ${view.verdict.text.replace(/ \([^)]*\)\.$/, "")}${when ? `,${when}` : ""}`);
}

function overview(view) {
  const state = view.state;
  if (!state) return;
  alarms(state.alarms);
  put("state-word", state.word);
  setTone("panel-state", STATE_TONES[state.name] || "idle");
  put("state-reason", state.reason || (state.maintenance ? "Maintenance." : `for ${seconds(state.since_s)}`));
  flag("held", state.held, state.held ? "ok" : "idle", state.held ? (state.secure ? "secure" : "not secure, or not known") : "nothing is held");
  flag("lift", state.lift_allowed, state.lift_allowed ? "ok" : state.held ? "warn" : "idle",
    state.lift_allowed ? "confirmed by the sensors" : state.held ? "not proven now" : "nothing is gripped");
  if (state.changer) {
    put("changer-word", state.changer);
    setTone("panel-changer", CHANGER_TONES[state.changer] || "idle");
    put("changer-detail", [state.unlock_output ? "unlock output on" : "unlock output off", state.armed ? "armed" : ""].filter(Boolean).join(", "));
  }
  const goal = state.goal;
  put("goal-word", goal ? goal.name : "Nothing");
  setTone("panel-goal", goal ? "busy" : "idle");
  byId("goal-bar").style.width = goal && goal.at_most_s ? `${Math.min(100, 100 * goal.so_far_s / goal.at_most_s)}%` : "0";
  put("goal-detail", goal ? `${seconds(goal.so_far_s)} so far${goal.at_most_s ? `, at most ${goal.at_most_s.toFixed(2)} s${view.verdict.holds ? " (proven)" : ""}` : ""}` : "");
}

function alarms(texts) {
  const list = byId("alarms");
  list.hidden = !texts.length;
  const key = texts.join("\n");
  if (list.dataset.key === key) return;
  list.dataset.key = key;
  list.replaceChildren(...texts.map((text) => Object.assign(document.createElement("li"), { textContent: text, className: text.startsWith("Over:") ? "over" : "" })));
}

function flag(name, on, tone, detail) {
  put(`${name}-word`, on ? "YES" : "NO");
  put(`${name}-detail`, detail);
  setTone(`panel-${name}`, tone);
}

function interlocks(rows) {
  const body = byId("interlocks");
  if (body.children.length !== rows.length) {
    body.replaceChildren(...rows.map((row) => {
      const line = document.createElement("tr");
      const rule = document.createElement("td");
      const id = Object.assign(document.createElement("span"), { className: "id", textContent: row.id });
      rule.append(id, row.rule);
      const now = document.createElement("td");
      now.append(Object.assign(document.createElement("span"), { className: "tag" }), Object.assign(document.createElement("span"), { className: "why" }));
      line.append(rule, now);
      return line;
    }));
  }
  rows.forEach((row, index) => {
    const line = body.children[index];
    line.dataset.state = row.state;
    put(line.querySelector(".tag"), row.state === "blocking" && row.blocks ? `blocks ${row.blocks}` : row.state);
    put(line.querySelector(".why"), row.why);
  });
}

function showEvent(entry) {
  const box = byId("event");
  box.hidden = !entry;
  if (!entry) return;
  const at = ((entry.at - drawn.epoch) / 1e6).toFixed(3);
  const head = Object.assign(document.createElement("p"), { textContent: `${at} s: ${entry.text}` });
  head.style.fontWeight = "600";
  const lines = [];
  const detail = entry.detail;
  if (detail) {
    for (const edge of detail.edges) {
      lines.push(`${edge.process}: ${edge.source} → ${edge.target}`);
      if (edge.guard) lines.push(`  guard   ${edge.guard}`);
      if (edge.synchronisation) lines.push(`  channel ${edge.synchronisation}`);
      if (edge.assignment) lines.push(`  update  ${edge.assignment}`);
    }
    if (detail.received) lines.push(`event ${detail.received}`);
    lines.push(`late by ${detail.late_ms.toFixed(1)} ms`);
    const readings = Object.entries(detail.readings).map(([name, value]) =>
      `${name} ${value === null ? "no valid reading" : typeof value === "boolean" ? (value ? "on" : "off") : `${value.toFixed(1)} kPa`}`);
    if (readings.length) lines.push(`readings: ${readings.join(", ")}`);
  }
  const code = Object.assign(document.createElement("code"), { textContent: lines.join("\n") });
  const close = Object.assign(document.createElement("button"), { type: "button", className: "small", textContent: "Close" });
  close.addEventListener("click", () => { box.hidden = true; });
  box.replaceChildren(head, code, close);
  box.scrollIntoView({ block: "nearest" });
}

connect();
