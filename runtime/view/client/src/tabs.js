// Tabs: one of several bodies is shown. The arrow keys move between them.

import { el } from "./dom.js";

export class Tabs {
  // `list` has [text, body, opened]; `opened`, which may be absent, is called when a user opens the tab.
  constructor(list) {
    this.list = list;
    this.buttons = list.map(([text, body], k) => {
      Object.assign(body, { id: `panel-${k}`, tabIndex: 0 });
      body.setAttribute("role", "tabpanel");
      body.setAttribute("aria-labelledby", `tab-${k}`);
      return el("button", { type: "button", role: "tab", id: `tab-${k}`, "aria-controls": body.id, onclick: () => this.open(k) }, text);
    });
    this.root = el("div", { class: "tabs", role: "tablist", "aria-label": "Side panel" }, ...this.buttons);
    this.root.addEventListener("keydown", (event) => this.onKey(event));
    this.choose(0);
  }

  // The place of the tab of this name; -1 where there is none.
  find(name) {
    return this.list.findIndex(([text]) => text === name);
  }

  open(k) {
    this.choose(k);
    this.list[k]?.[2]?.();
  }

  choose(chosen) {
    if (!this.list[chosen]) return;
    this.chosen = chosen;
    this.list.forEach(([, body], k) => {
      body.hidden = k !== chosen;
      this.buttons[k].setAttribute("aria-selected", String(k === chosen));
      this.buttons[k].tabIndex = k === chosen ? 0 : -1;
    });
    dispatchEvent(new Event("resize"));
  }

  onKey(event) {
    const last = this.list.length - 1;
    const next = { ArrowLeft: this.chosen - 1, ArrowRight: this.chosen + 1, Home: 0, End: last }[event.key];
    if (next === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    this.open((next + last + 1) % (last + 1));
    this.buttons[this.chosen].focus();
  }
}
