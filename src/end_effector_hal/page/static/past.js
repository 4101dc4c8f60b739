// What was recorded before: a list that is asked for, never by itself. Each opens in a tab of its own.
import { byId, make, put, seconds } from "/static/dom.js";

export function past() {
  const button = byId("past-show");
  byId("past-jump").onclick = () => button.click();
  button.onclick = async () => {
    byId("past").hidden = false;
    button.setAttribute("aria-expanded", "true");
    button.disabled = true;
    put("past-said", "Looking for recordings …");
    try {
      const answer = await fetch("/past");
      if (!answer.ok) throw new Error((await answer.text()).trim());
      list(await answer.json());
    } catch (error) {
      put("past-said", error.message);
    }
    button.disabled = false;
    put(button, "List them again");
  };
}

function list({ folder, recordings }) {
  put("past-said", recordings.length ? `${recordings.length} in ${folder}, newest first.` : `There is none in ${folder}. eehal page --recordings names another folder.`);
  byId("past-table").hidden = !recordings.length;
  byId("past-rows").replaceChildren(...recordings.map((each) => make("tr", {},
    make("td", {}, new Date(each.changed * 1000).toLocaleString("sv-SE").slice(0, 16)),
    make("td", {}, make("a", { href: `/past/${each.id}/`, target: "_blank", rel: "noopener" }, each.name)),
    make("td", {}, each.story), make("td", {}, each.length_s === null ? "–" : seconds(each.length_s)), make("td", {}, each.tool))));
}
