// The page: gets views from its process, shows them. It decides nothing: every sentence comes from the HAL.
import { Cards } from "/static/cards.js";
import { Commands } from "/static/commands.js";
import { Faults } from "/static/faults.js";
import { past } from "/static/past.js";
import { Log } from "/static/log.js";
import { TimeLine } from "/static/timeline.js";
import { Automata } from "/static/automata.js";
import { identity, interlocks, lateness, overview, showEvent, spans } from "/static/panels.js";
import { byId, put, seconds } from "/static/dom.js";

const page = pageNumber();
let drawn = null;
let parts = null;
let heardAt = 0;

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
    ended = "";
    show(JSON.parse(event.data));
  });
  source.addEventListener("error", () => {
    if (source.readyState !== EventSource.CLOSED) return;
    whyNot().catch(() => {});
    setTimeout(connect, 1000);
  });
}

async function whyNot() {
  const answer = await fetch(`/events?page=${page}`);
  if (answer.status === 401) ended = "This page belongs to an earlier start. Open the address that eehal page has printed.";
  else if (!answer.ok) ended = (await answer.text()).trim();
  else answer.body.cancel();
}
let ended = "";

function begin(content) {
  drawn = content;
  identity(content);
  spans((span) => parts.timeline.spanTo(span));
  const still = byId("hold-still");
  still.onclick = () => still.setAttribute("aria-pressed", String(parts.timeline.holdStill()));
  const cards = new Cards(byId("cards"), content);
  const commands = new Commands(page, content);
  parts = {
    cards,
    commands,
    faults: new Faults(commands),
    log: new Log(byId("log"), content, open),
    timeline: new TimeLine(byId("timeline"), content, open),
    automata: new Automata(byId("automata"), byId("automata-tabs"), content),
  };
}

function open(entry) {
  showEvent(entry, drawn.epoch);
}

function show(view) {
  if (!parts) return;
  view.proven = view.verdict.holds;
  freshness(view.news);
  facts(view);
  overview(view);
  parts.cards.show(view);
  parts.commands.show(view);
  parts.faults.show(view);
  parts.log.add(view.log);
  parts.timeline.add(view);
  parts.automata.show(view.automata, view.at);
  interlocks(view.interlocks);
  put("pages", view.pages > 1 ? `${view.pages} pages are open.` : "");
}

function freshness(news) {
  document.body.classList.toggle("stale", !news.fresh);
  const bar = byId("news");
  bar.hidden = news.fresh;
  if (!news.fresh) {
    const age = news.age_s === null ? "No news yet" : `No news for ${seconds(news.age_s)}`;
    put("news-text", `${age}. ${news.why}${parts ? " What you see is old." : ""}`);
  }
  byId("news-reload").hidden = !news.deaf;
}

// The page's own process may be gone as well: then nothing comes at all.
setInterval(() => {
  const age = (performance.now() - heardAt) / 1000;
  if ((heardAt && age > 1.2) || (!heardAt && ended)) {
    freshness({ fresh: false, deaf: true, age_s: heardAt ? age : null, why: ended || "Lost connection to `eehal page`: this page is not live." });
    if (parts) {
      parts.commands.unheard();
      parts.faults.unheard();
    }
  }
}, 200);

function facts(view) {
  const state = view.state;
  const hertz = (value, of) => value.toFixed(of < 10 ? 1 : 0);
  const rate = drawn.sources
    .map(({ name, hz }, i) => `${name} ${hertz(view.rates_hz[i], view.rates_hz[i])} of ${hertz(hz, hz)} Hz`.trim())
    .join(", ");
  put("fact-rate", state ? `${state.link_up ? "up" : "DOWN"}, ${rate}` : rate);
  lateness(state);
  const mark = view.verdict.holds === null ? "○" : view.verdict.holds ? "●" : "■";
  const when = view.verdict.at ? ` ${view.verdict.at.slice(0, 16).replace("T", " ")}` : "";
  put("fact-verdict", `${mark} ${view.verdict.text.replace(/ \([^)]*\)\.$/, "")}${when ? `,${when}` : ""}`);
}

byId("news-reload").onclick = () => location.reload();
past();
connect();
