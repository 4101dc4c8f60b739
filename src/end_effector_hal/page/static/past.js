// What was recorded before, and how the grips change over time: both are asked for, never read by themselves.
import { byId, make, put, seconds, svg } from "/static/dom.js";

export function past() {
  asks("past", "recordings", list);
  asks("history", "grips", change);
  byId("past-jump").onclick = () => byId("past-show").click();
}

// A button that opens its part of the page and asks for what is in it.
function asks(name, what, show) {
  const button = byId(`${name}-show`);
  const words = button.textContent;
  button.onclick = async () => {
    byId(name).hidden = false;
    button.setAttribute("aria-expanded", "true");
    button.disabled = true;
    put(`${name}-said`, `Looking for ${what} …`);
    try {
      const answer = await fetch(`/${name}`);
      if (!answer.ok) throw new Error((await answer.text()).trim());
      show(await answer.json());
    } catch (error) {
      put(`${name}-said`, error.message);
    }
    button.disabled = false;
    put(button, `${words} again`);
  };
}

// Each recording opens in a tab of its own.
function list({ folder, recordings }) {
  put("past-said", recordings.length ? `${recordings.length} in ${folder}, newest first.` : `There is none in ${folder}. eehal page --recordings names another folder.`);
  byId("past-table").hidden = !recordings.length;
  byId("past-rows").replaceChildren(...recordings.map((each) => make("tr", {},
    make("td", {}, new Date(each.changed * 1000).toLocaleString("sv-SE").slice(0, 16)),
    make("td", {}, make("a", { href: `/past/${each.id}/`, target: "_blank", rel: "noopener" }, each.name)),
    make("td", {}, each.story), make("td", {}, each.length_s === null ? "–" : seconds(each.length_s)), make("td", {}, each.tool))));
}

function change({ said, days, trends, notes }) {
  put("history-said", [said, ...notes].join(" · "));
  byId("history-table").hidden = !days.length;
  byId("history-rows").replaceChildren(...days.map((each) => make("tr", {},
    ...[each.day, each.part || "–", each.grips, Object.entries(each.outcomes).map(([name, count]) => `${count} ${name}`).join(", "),
      each.first_attempt_rate === null ? "–" : `${Math.round(100 * each.first_attempt_rate)} %`].map((text) => make("td", {}, text)))));
  byId("history-trends").replaceChildren(...trends.map((each) => make("figure", {}, make("figcaption", {}, each.title), bars(each), make("p", { className: "meaning" }, `${each.ends}; ${each.column}, from 0 to ${each.top_label}`))));
}

// From 0 to the value at the top, as the terminal shows them; below 0 a mark at the foot.
function bars({ title, ends, values, top }) {
  return svg("svg", { class: "bars", viewBox: `-0.3 0 ${Math.max(values.length, 12)} 40`, preserveAspectRatio: "none", role: "img", "aria-label": `${title}: ${ends}` },
    ...values.map((value, at) => {
      const height = Math.max(1, (40 * value) / top);
      return svg("rect", { class: value < 0 ? "below" : "", x: at, y: 40 - height, width: 0.8, height });
    }));
}
