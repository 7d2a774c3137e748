// The list of modes: choosing one swings the shapes in it.

import { el } from "./dom.js";
import { number } from "./numbers.js";

export class Modes {
  constructor(parent, description, chosen) {
    this.list = description.modes;
    this.chosen = chosen;
    this.rows = this.list.map((mode, k) =>
      el(
        "button", { type: "button", class: "mode", title: mode.states.join(", "), onclick: () => this.choose(k) },
        el("b", {}, mode.frequency > 0 ? `${number(mode.frequency, 4)} Hz` : "no oscillation"),
        el("span", {}, mode.frequency > 0 ? `damping ${number(mode.damping, 3)}` : timeConstant(mode)),
        el("small", {}, mode.states[0] ?? ""),
      ),
    );
    const still = description.still;
    parent.append(
      el("div", { class: "modes" }, ...this.rows),
      el("p", { class: "none" }, `Displacements are scaled, and damping is not shown.${still ? ` ${still} more mode${still > 1 ? "s are" : " is"} constant or without a moving shape.` : ""}`),
    );
  }

  get mode() {
    return this.list[this.at];
  }

  choose(k) {
    if (!this.list[k]) return;
    this.at = k;
    this.rows.forEach((row, i) => row.setAttribute("aria-pressed", i === k));
    this.chosen(this.list[k]);
  }
}

function timeConstant({ constant }) {
  if (constant == null) return "constant";
  return constant < 0 ? `grows in ${number(-constant, 3)} s` : `decays in ${number(constant, 3)} s`;
}
