// Faults of a testbench: choose, arm, go. Without a testbench there is nothing to see.
import { byId, make, put } from "/static/dom.js";

const WORDS = { arm: "Arm", go: "Go", nominal: "Nominal again" };
const UNHEARD = "Lost connection to `eehal page`.";

export class Faults {
  constructor(commands) {
    this.commands = commands;
    this.refused = {};
    this.offered = [];
    this.kind = byId("fault-kind");
    this.place = byId("fault-place");
    this.number = byId("fault-number");
    this.text = byId("fault-text");
    this.kind.onchange = () => this.choose();
    this.place.onchange = () => this.write();
    this.number.oninput = () => this.write();
    this.text.oninput = () => this.follow();
    for (const word of Object.keys(WORDS)) byId(`fault-${word}`).onclick = () => this.press(word);
  }

  show(view) {
    const now = view.faults;
    if (view.offered) this.offer(view.offered);
    byId("faults").hidden = !now;
    if (!now) {
      this.answer("", null);
      return;
    }
    byId("faults").classList.toggle("silent", now.silent);
    const fine = now.scenario === "nominal";
    byId("faults-now").classList.toggle("wrong", !fine && !now.silent);
    const armed = view.armed ? ` ${view.armed.name} has armed ${view.armed.scenario}.` : "";
    put("faults-now", now.silent ? "▲ The testbench is silent." : `${fine ? "○ Nothing is wrong." : `■ Now: ${now.scenario}.`}${armed}`);
    const mine = view.armed && view.armed.page === this.commands.page;
    const left = view.armed ? `${Math.ceil(view.armed.left_s)} s left.` : "";
    const common = now.silent ? "The testbench is silent." : this.commands.mine ? "" : "Take control first.";
    this.set("arm", common, common || "After arming, press Go within 10 s.");
    const unarmed = !mine ? "Arm it first." : view.armed.scenario !== this.scenario() ? `${view.armed.scenario} is armed, not this scenario. Arm again.` : "";
    this.set("go", common || unarmed, common || unarmed || `Plays ${view.armed.scenario}. ${left}`);
    byId("fault-go").classList.toggle("danger", Boolean(mine));
    this.set("nominal", common || (fine ? "Nothing is wrong." : ""), common || (fine ? "Nothing is wrong." : "At once."));
  }

  unheard() {
    byId("faults").classList.add("silent");
    for (const word of Object.keys(WORDS)) this.set(word, UNHEARD, UNHEARD);
  }

  offer(offered) {
    const chosen = this.kind.value;
    this.offered = offered.filter((fault) => fault.name !== "nominal");
    this.kind.replaceChildren(...this.offered.map((fault) => make("option", { value: fault.name, textContent: fault.name })));
    if (this.offered.some((fault) => fault.name === chosen)) {
      this.kind.value = chosen;
      return;
    }
    this.choose();
  }

  // What this kind of fault takes: where, and a number.
  choose() {
    this.describe();
    this.write();
  }

  describe() {
    const fault = this.offered.find((each) => each.name === this.kind.value);
    if (!fault) return;
    const places = fault.anywhere && fault.places.length ? ["", ...fault.places] : fault.places;
    this.place.replaceChildren(...places.map((place) => make("option", { value: place, textContent: place || "everywhere" })));
    byId("fault-place-label").hidden = !places.length;
    const number = fault.number;
    byId("fault-number-label").hidden = !number;
    let limits = "";
    if (number) {
      put("fault-number-name", number.name);
      this.number.value = number.default ?? "";
      const without = number.default === null ? "" : `, ${number.default} if it is left out`;
      limits = ` ${number.name}: ${number.whole ? "a whole number " : ""}from ${number.low} to ${number.high}${without}.`;
    }
    put("fault-meaning", `${fault.usage}: ${fault.meaning}.${limits}`);
  }

  // What was typed: where it is one fault of the list, the list and its meaning follow; else the testbench judges it.
  follow() {
    const [name, ...rest] = this.scenario().split(":");
    if (!this.offered.some((each) => each.name === name)) {
      put("fault-meaning", "Typed: the testbench checks it when it is armed.");
      return;
    }
    this.kind.value = name;
    this.describe();
    const places = [...this.place.options].map((option) => option.value);
    const placed = rest.length > 0 && places.includes(rest[0]);
    if (placed) this.place.value = rest.shift();
    else if (places.includes("")) this.place.value = "";
    if (rest.length) this.number.value = rest.join(":");
  }

  write() {
    const number = byId("fault-number-label").hidden ? "" : this.number.value.trim();
    const place = byId("fault-place-label").hidden ? "" : this.place.value;
    this.text.value = [this.kind.value, place, number].filter(Boolean).join(":");
  }

  scenario() {
    return this.text.value.trim();
  }

  set(word, refusal, text) {
    const button = byId(`fault-${word}`);
    this.refused[word] = refusal;
    const disabled = refusal ? "true" : "false";
    if (button.getAttribute("aria-disabled") !== disabled) button.setAttribute("aria-disabled", disabled);
    put(`why-fault-${word}`, text);
  }

  async press(word) {
    if (this.refused[word]) {
      this.answer(`${WORDS[word]}: ${this.refused[word]}`, false);
      return;
    }
    const scenario = word === "nominal" ? "" : this.scenario();
    this.answer(`${WORDS[word]} …`, null);
    const said = await this.commands.post("/fault", word, { scenario });
    const done = { arm: `${scenario} is armed.`, go: `The testbench plays ${scenario}.`, nominal: "nothing is wrong." }[word];
    this.answer(`${WORDS[word]}: ${said.accepted ? done : said.reason}`, said.accepted);
  }

  answer(text, accepted) {
    const line = byId("fault-answer");
    const name = `answer${accepted === null ? "" : accepted ? " done" : " refused"}`;
    if (line.className !== name) line.className = name;
    put(line, text);
  }
}
