// What differs between two recordings, as the process or the file says it: a list, each with the way to its moment.
import { byId, make, put } from "/static/dom.js";

const time = (seconds) => (seconds === null ? "–" : `${seconds.toFixed(3)} s`);

export class Differences {
  constructor(open) {
    this.open = open;
    this.chosen = null;
    byId("differences").hidden = false;
    put("differences-said", "Being compared …");
  }

  show({ said, rows, more }) {
    put("differences-said", said);
    byId("differences-table").hidden = !rows.length;
    byId("differences-rows").replaceChildren(...rows.map((each) => this.row(each)));
    put("differences-more", more);
    byId("differences-more").hidden = !more;
  }

  // A click anywhere in the row; for the keyboard it has a button.
  row(each) {
    const leads = each.shift_s !== null;
    const what = leads ? make("button", { type: "button", title: "Go there in both recordings", textContent: each.what }) : each.what;
    const row = make("tr", {}, make("td", {}, time(each.first_s)), make("td", {}, time(each.second_s)), make("td", {}, each.lane), make("td", {}, what));
    if (leads) {
      row.className = "leads";
      row.addEventListener("click", () => {
        this.open(each);
        this.choose(row);
      });
    }
    return row;
  }

  // The row whose moment is shown; null: that is over.
  choose(row) {
    if (this.chosen === row) return;
    this.chosen?.removeAttribute("aria-current");
    this.chosen = row;
    row?.setAttribute("aria-current", "true");
  }
}
