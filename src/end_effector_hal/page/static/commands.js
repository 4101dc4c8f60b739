// Buttons. Each is forbidden or not as the HAL says, in its words; a page commands only with the control.
import { byId, make, put } from "/static/dom.js";

const LABELS = { grip: "Grip", drop: "Drop", resume: "Resume", cancel: "Cancel", stop: "Stop", lock: "Lock", arm: "Arm unlock", unlock: "Unlock", reset: "Reset faults" };
const STYLES = { drop: "danger", resume: "plain", cancel: "cancel", stop: "cancel", lock: "plain", arm: "plain", unlock: "plain", reset: "plain" };
const ASKS = { drop: ["Drop what is held?", "All outputs of the grip are released now, in the declared order. A suspended part will fall."] };
const ALWAYS = { cancel: "No emergency stop.", stop: "Not a safety function." };
const GOALS = ["grip", "drop", "lock", "unlock"];
const csrf = document.querySelector("meta[name=csrf]").content;

export class Commands {
  constructor(page, drawn) {
    this.page = page;
    this.buttons = {};
    this.refused = {};
    const before = byId("part")?.value;
    this.part = drawn.parts.length ? choice(drawn.parts, before) : null;
    const made = drawn.buttons.map((word) => this.make(word));
    // together, for on a phone they stay at the lower edge
    const atHand = make("div", { className: "at-hand" }, ...made.filter((_, index) => ALWAYS[drawn.buttons[index]]));
    const place = drawn.buttons.findIndex((word) => ALWAYS[word]);
    byId("buttons").replaceChildren(...made.slice(0, place), atHand, ...made.filter((each, index) => index >= place && !ALWAYS[drawn.buttons[index]]));
    this.cards = drawn.cards;
    this.drives = drawn.cards.map((card) => this.makeDrive(card));
    this.lease = drawn.lease_s;
    const toggle = byId("maintenance");
    toggle.onclick = () => {
      const on = document.body.classList.toggle("maintenance");
      toggle.setAttribute("aria-pressed", on);
    };
    this.take = byId("control-take");
    this.take.onclick = () => this.control(this.mine ? "release" : "take");
    clearInterval(Commands.renewal);
    Commands.renewal = setInterval(() => { if (this.mine && !this.deaf) this.control("renew"); }, 3000);
  }

  make(word) {
    const why = make("span", { className: "why", id: `why-${word}` });
    // not `disabled`: a forbidden button can be reached with the keyboard, and says why
    const button = make("button", { type: "button", className: STYLES[word] || "", id: `command-${word}`, textContent: LABELS[word] });
    button.setAttribute("aria-describedby", why.id);
    button.addEventListener("click", () => this.press(word));
    this.buttons[word] = { button, why };
    const chosen = word === "grip" && this.part ? [make("label", { className: "part" }, "Part ", this.part)] : [];
    return make("div", { className: "command" }, button, ...chosen, why);
  }

  // In maintenance (IL-12) each card has a button of its own.
  makeDrive(card) {
    const why = make("span", { className: "why", id: `why-drive-${card.name}` });
    const button = make("button", { type: "button", className: "small", id: `drive-${card.name}` });
    button.setAttribute("aria-describedby", why.id);
    const drive = { button, why, word: "activate", refusal: "" };
    button.addEventListener("click", () => this.drive(card, drive));
    byId(`card-${card.name}`).append(make("div", { className: "drive" }, button, why));
    return drive;
  }

  showDrives(view) {
    const { left_s: left, refused } = view.maintenance;
    this.drives.forEach((drive, index) => {
      const on = Boolean(view.cards && view.cards[index].output);
      drive.word = on ? "deactivate" : "activate";
      drive.refusal = refused[drive.word] || (this.mine ? "" : "Take control first.");
      put(drive.button, on ? "Deactivate" : "Activate");
      drive.button.setAttribute("aria-disabled", drive.refusal ? "true" : "false");
      put(drive.why, drive.refusal || (on && left !== null ? `Deactivated in ${left.toFixed(0)} s, unless something is driven.` : `For ${this.lease} s at most.`));
    });
  }

  async drive(card, drive) {
    const what = `${drive.word === "activate" ? "Activate" : "Deactivate"} ${card.label}`;
    if (drive.refusal) {
      this.answer(`${what}: ${drive.refusal}`, false);
      return;
    }
    this.answer(`${what} …`, null);
    const said = await this.post("/command", drive.word, { name: card.name });
    this.answer(`${what}: ${said.accepted ? said.reason || "the output is written; its card shows what its sensor says." : said.reason}`, said.accepted);
  }

  show(view) {
    const control = view.control;
    this.deaf = false;
    this.lastAt = view.state?.last?.at ?? null;
    if (this.before !== undefined && this.lastAt !== null && this.lastAt !== this.before) {
      this.answer("", null);  // what has become of it stands above, among the states
      this.before = undefined;
    }
    this.mine = control.holder === this.page;
    const who = byId("control-who");
    who.classList.toggle("mine", this.mine);
    put(who, this.mine ? "This page has the control." : control.holder ? `${control.name} has the control.` : "No page is in control.");
    put(this.take, this.mine ? "Release control" : "Take control");
    this.take.disabled = !this.mine && Boolean(control.holder);
    const refusals = this.part ? { ...view.buttons, grip: view.parts[this.part.value] } : view.buttons;
    for (const [word, refusal] of Object.entries(refusals)) {
      const why = refusal || (this.mine || ALWAYS[word] ? "" : "Take control first.");
      this.set(word, why, ALWAYS[word] ? `${ALWAYS[word]} ${view[word]}` : why);
    }
    this.showDrives(view);
  }

  // Nothing comes: what needs no look at the tool can still be sent, and the control ends by itself.
  unheard() {
    const unheard = "This page is not live.";
    this.deaf = true;
    for (const word of Object.keys(this.buttons)) this.set(word, ALWAYS[word] ? "" : unheard, ALWAYS[word] ? `${ALWAYS[word]} ${unheard} It is sent all the same.` : unheard);
    for (const drive of this.drives) {
      drive.refusal = unheard;
      drive.button.setAttribute("aria-disabled", "true");
      put(drive.why, unheard);
    }
  }

  set(word, refusal, text) {
    const { button, why } = this.buttons[word];
    this.refused[word] = refusal;
    const disabled = refusal ? "true" : "false";
    if (button.getAttribute("aria-disabled") !== disabled) button.setAttribute("aria-disabled", disabled);
    put(why, text);
  }

  async press(word) {
    if (this.refused[word]) {
      this.answer(`${LABELS[word]}: ${this.refused[word]}`, false);
      return;
    }
    if (ASKS[word] && !(await confirmed(...ASKS[word]))) return;
    const name = word === "grip" && this.part ? this.part.value : "";
    const what = `${LABELS[word]} ${name}`.trim();
    this.answer(`${what} …`, null);
    const before = this.lastAt;
    const said = await this.post("/command", word, { name });
    const begun = said.accepted && GOALS.includes(word);  // its outcome comes later
    this.answer(`${what}: ${said.accepted ? said.reason || "accepted." : said.reason}`, begun ? null : said.accepted);
    this.before = begun ? before : undefined;
  }

  async control(word) {
    const said = await this.post("/control", word);
    if (!said.accepted && said.reason) this.answer(said.reason, false);
  }

  async post(path, word, more = {}) {
    try {
      const answer = await fetch(path, {
        method: "POST",
        headers: { "content-type": "application/json", "x-eehal-csrf": csrf },
        body: JSON.stringify({ page: this.page, word, ...more }),
      });
      return answer.ok ? await answer.json() : { accepted: false, reason: (await answer.text()).trim() };
    } catch {
      return { accepted: false, reason: "Lost connection to `eehal page`: it is unknown whether the command was executed. Check the state first." };
    }
  }

  answer(text, accepted) {
    const line = byId("answer");
    line.className = `answer${accepted === null ? "" : accepted ? " done" : " refused"}`;
    line.textContent = text;
  }
}

// The parts that can be gripped; the default one is the first.
function choice(parts, before) {
  const options = parts.map(({ name, summary }) => make("option", { value: name, textContent: summary ? `${name}: ${summary}` : name }));
  const list = make("select", { id: "part" }, ...options);
  if (parts.some(({ name }) => name === before)) list.value = before;
  return list;
}

function confirmed(title, text) {
  const dialog = byId("confirm");
  put("confirm-title", title);
  put("confirm-text", text);
  dialog.returnValue = "no";
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => resolve(dialog.returnValue === "yes"), { once: true });
  });
}
