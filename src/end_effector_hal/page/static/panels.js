// What both pages show of a moment, live or recorded: state, alarms, interlocks, and an event that was opened.
import { byId, make, put, setTone, seconds } from "/static/dom.js";

const STATE_TONES = {
  OFF: "idle", STAND_BY: "idle", GRIPPING: "busy", GRIPPED: "ok", RELEASING: "release", GRIP_ERROR: "bad", RELEASE_ERROR: "bad",
};
const STOP_TONES = { CLOSED: "ok", OPEN: "bad", STOPPED: "bad", "NOT KNOWN": "warn" };
const OUTCOME_TONES = { SUCCEEDED: "ok", FAILED: "bad", CANCELLED: "warn" };
const CHANGER_TONES = { LOCKED: "ok", UNLOCKED: "warn", UNLOCKING: "busy", LOCKING: "busy", FAULT: "bad", UNKNOWN: "warn" };

export function identity(drawn) {
  document.title = drawn.name;
  put("tool-name", drawn.name);
  put("tool-summary", drawn.summary);
  const changer = drawn.lanes.some((lane) => lane.name === "tool changer");
  byId("panel-changer").hidden = !changer;
}

// The buttons that choose how many seconds the timeline shows; NaN: all.
export function spans(choose) {
  const buttons = [...document.querySelectorAll("[data-span]")];
  for (const button of buttons) {
    button.onclick = () => {
      buttons.forEach((other) => other.setAttribute("aria-pressed", String(other === button)));
      choose(Number(button.dataset.span));
    };
  }
}

export function lateness(state) {
  put("fact-late", state && state.worst_late_ms !== null ? `${state.worst_late_ms.toFixed(1)} ms of ${state.bound_ms} ms${state.missed ? `, ${state.missed} deadlines missed` : ""}` : "–");
}

const PANELS = ["state", "held", "lift", "changer", "e-stop", "goal"];

export function overview(view) {
  const state = view.state;
  if (!state) {
    for (const name of PANELS) put(`${name}-word`, "–");
    for (const name of ["state-reason", "held-detail", "lift-detail", "changer-detail", "e-stop-detail", "goal-detail"]) put(name, "");
    for (const name of PANELS) setTone(`panel-${name}`, "idle");
    byId("goal-bar").style.width = "0";
    alarms([]);
    return;
  }
  alarms(state.alarms);
  put("state-word", state.word);
  setTone("panel-state", STATE_TONES[state.name] || "idle");
  put("state-reason", state.reason || (state.maintenance ? "Maintenance." : `for ${seconds((view.at - state.since) / 1e6)}`));
  flag("held", state.held, ...(state.arbiter_lost ? ["warn", "as last known: the line arbiter is lost"]
    : state.held ? held(state, view.cards) : ["idle", "nothing is held"]));
  flag("lift", state.lift_allowed, state.lift_allowed ? "ok" : state.held ? "warn" : "idle",
    state.lift_allowed ? "confirmed by the sensors" : state.held ? "not proven now" : "nothing is gripped");
  if (state.changer) {
    put("changer-word", state.changer);
    setTone("panel-changer", CHANGER_TONES[state.changer] || "idle");
    put("changer-detail", [state.unlock_output ? "unlock output on" : "unlock output off", state.armed ? "armed" : ""].filter(Boolean).join(", "));
  }
  const stop = state.e_stop;
  byId("panel-e-stop").hidden = !stop;
  if (stop) {
    put("e-stop-word", stop.word);
    setTone("panel-e-stop", STOP_TONES[stop.word]);
    put("e-stop-detail", stop.why);
  }
  const flags = document.querySelectorAll(".panel.flag:not([hidden])").length;
  document.querySelector(".overview").style.setProperty("--flags", flags);
  goal(view, state.goal, state.goal ? null : state.last);
}

// What runs; while nothing runs what has become of the last command.
function goal(view, running, last) {
  const soFar = running ? (view.at - running.since) / 1e6 : 0;
  put("goal-caption", last ? "Last command" : "Running");
  put("goal-word", running ? running.name : last ? last.word : "Nothing");
  setTone("panel-goal", running ? "busy" : last ? OUTCOME_TONES[last.outcome] : "idle");
  byId("goal-course").hidden = Boolean(last);
  byId("goal-bar").style.width = running && running.at_most_s ? `${Math.min(100, 100 * soFar / running.at_most_s)}%` : "0";
  put("goal-detail", running ? `${seconds(soFar)} so far${running.at_most_s ? `, at most ${running.at_most_s.toFixed(2)} s${view.proven ? " (proven)" : ""}` : ""}`
    : last ? last.reason || `after ${last.seconds.toFixed(2)} s` : "");
}

function held(state, cards) {
  if (state.secure) return ["ok", "secure"];
  if (!cards?.some((card) => card.hold?.secure === false)) return ["ok", "not yet known to be secure"];
  return [state.lift_allowed ? "ok" : "warn", "not secure"];  // a grip gets firm in its first second
}

function alarms(all) {
  const list = byId("alarms");
  list.hidden = !all.length;
  const key = all.map((alarm) => alarm.text).join("\n");
  if (list.dataset.key === key) return;
  list.dataset.key = key;
  list.replaceChildren(...all.map((alarm) => Object.assign(document.createElement("li"), { textContent: alarm.text, className: alarm.over ? "over" : "" })));
}

function flag(name, on, tone, detail) {
  if (on === null) {
    put(`${name}-word`, "–");
    put(`${name}-detail`, "not recorded");
    setTone(`panel-${name}`, "idle");
    return;
  }
  put(`${name}-word`, on ? "YES" : "NO");
  put(`${name}-detail`, detail);
  setTone(`panel-${name}`, tone);
}

export function interlocks(rows) {
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

export function showEvent(entry, epoch, scroll = true) {
  const box = byId("event");
  box.hidden = !entry;
  if (!entry) return;
  const at = ((entry.at - epoch) / 1e6).toFixed(3);
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
      `${name} ${value === null ? "no valid reading" : typeof value === "boolean" ? (value ? "on" : "off") : typeof value === "string" ? value : `${value.toFixed(1)} kPa gauge`}`);
    if (readings.length) lines.push(`readings: ${readings.join(", ")}`);
  }
  const code = Object.assign(document.createElement("code"), { textContent: lines.join("\n") });
  const close = Object.assign(document.createElement("button"), { type: "button", className: "small", textContent: "Close" });
  close.addEventListener("click", () => { box.hidden = true; });
  box.replaceChildren(head, code, close);
  if (scroll) box.scrollIntoView({ block: "nearest" });
}
