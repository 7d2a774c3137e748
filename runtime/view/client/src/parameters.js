// Sliders for the parameters of a model, by the parts that have them.

import { button, el, icon } from "./dom.js";
import { number, typed, unitText } from "./numbers.js";

const STEPS = 1000;

// The ends of a slider: those of the parameter where they are near its value, else around it.
function ends({ value, low, high }) {
  const near = (limit) => limit != null && (value === 0 ? Math.abs(limit) <= 1e3 : Math.abs(limit) <= 20 * Math.abs(value));
  const reach = value === 0 ? 1 : Math.abs(value);
  let from = near(low) ? low : value - reach * (value > 0 && low !== null && low >= 0 ? 1 : 2);
  let to = near(high) ? high : value + reach * (value === 0 ? 1 : 1.5);
  if (value > 0 && from < 0 && (low === null || low >= 0)) from = low ?? 0;
  if (low != null) from = Math.max(from, low);
  if (high != null) to = Math.min(to, high);
  return [from, to];
}

class Row {
  constructor(parameter, label, send) {
    this.parameter = parameter;
    this.start = parameter.value;
    this.send = send;
    [this.from, this.to] = ends(parameter);
    const { unit, name } = parameter;
    this.slider = el("input", { type: "range", min: 0, max: STEPS, step: 1, "aria-label": name });
    this.field = el("input", { type: "text", inputmode: "decimal", "aria-label": `${name}, value`, spellcheck: "false" });
    this.back = button("undo", "Back to the first value", () => this.give(this.start), { class: "back" });
    this.root = el(
      "div", { class: "parameter", title: name },
      el("span", { class: "label" }, label), this.back,
      el("span", { class: "value" }, this.field, el("small", {}, unitText(unit))),
      this.slider,
    );
    this.slider.addEventListener("input", () => {
      const share = this.slider.value / STEPS;
      this.give(this.from + share * (this.to - this.from), true);
    });
    this.field.addEventListener("change", () => {
      const given = Number(this.field.value.replace(",", ".").replace("−", "-"));
      if (this.field.value.trim() && Number.isFinite(given)) this.give(given * parameter.factor);
      else this.show(this.value);
    });
    this.field.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.field.blur();
      event.stopPropagation();
    });
    this.show(parameter.value);
  }

  give(value, sliding = false) {
    const { low, high, factor } = this.parameter;
    // Round numbers while sliding; the limits hold.
    if (sliding) {
      const grain = 10 ** Math.floor(Math.log10((this.to - this.from) / factor / 200)) * factor;
      value = Number((Math.round(value / grain) * grain).toPrecision(12));
    }
    if (low != null) value = Math.max(low, value);
    if (high != null) value = Math.min(high, value);
    this.show(value, sliding);
    this.send(this.parameter.name, value);
  }

  show(value, sliding = false) {
    this.value = value;
    if (document.activeElement !== this.field) this.field.value = typed(value / this.parameter.factor, 6);
    if (!sliding) {
      if (value < this.from) this.from = value;
      if (value > this.to) this.to = value;
      const share = this.to > this.from ? (value - this.from) / (this.to - this.from) : 0;
      this.slider.value = Math.round(STEPS * share);
    }
    const changed = Math.abs(value - this.start) > 1e-9 * Math.max(Math.abs(value), Math.abs(this.start));
    this.root.classList.toggle("changed", changed);
    this.slider.style.setProperty("--share", `${this.slider.value / (STEPS / 100)}%`);
  }
}

export class Parameters {
  constructor(holder, description, send) {
    this.description = description;
    this.list = description.parameters;
    this.rows = new Map();
    this.values = this.list.map((p) => p.value);
    this.pending = new Map();
    this.sendNow = send;
    this.search = el("input", { type: "search", placeholder: "Search parameters", "aria-label": "Search parameters", spellcheck: "false" });
    this.search.addEventListener("input", () => this.filter(this.search.value));
    this.search.addEventListener("keydown", (event) => event.stopPropagation());
    this.groups = el("div", { class: "groups" });
    holder.append(el("label", { class: "search" }, icon("search"), this.search), this.groups);
    this.opened = new Set([""]);
    this.filter("");
  }

  send(name, value) {
    // At most one message for each frame and parameter.
    if (!this.pending.size) {
      requestAnimationFrame(() => {
        for (const [key, last] of this.pending) this.sendNow(key, last);
        this.pending.clear();
      });
    }
    this.pending.set(name, value);
  }

  row(index, label) {
    const parameter = this.list[index];
    if (!this.rows.has(index)) {
      this.rows.set(index, new Row(parameter, label, (name, value) => this.send(name, value)));
      this.rows.get(index).show(this.values[index]);
    }
    return this.rows.get(index).root;
  }

  // Parts whose names or parameters contain all words; without words all but entries of matrices.
  filter(text) {
    const words = text.toLowerCase().split(/\s+/).filter(Boolean);
    const parts = new Map();
    this.list.forEach((parameter, index) => {
      const name = parameter.name.toLowerCase();
      if (words.length ? !words.every((word) => name.includes(word)) : /\[\d+,\d+\]$/.test(name)) return;
      const at = parameter.name.lastIndexOf(".");
      const part = at < 0 ? "" : parameter.name.slice(0, at);
      if (!parts.has(part)) parts.set(part, []);
      parts.get(part).push(index);
    });
    const few = this.list.length <= 12 || words.length > 0;
    this.groups.replaceChildren(...[...parts].map(([part, indices]) => this.group(part, indices, few)));
    if (!parts.size) {
      this.groups.append(el("p", { class: "none" }, words.length ? "No parameter has that name." : "The scene has no parameters that can change while it runs."));
    }
    if (!words.length && this.description.folded.length) {
      const names = this.description.folded.map(([name, value]) => `${name} = ${number(value)}`).join("\n");
      this.groups.append(el("p", { class: "note", title: names }, `${this.description.folded.length} parameters are compiled in as zeros or ones; \`keep NAME;\` in the scene makes one adjustable.`));
    }
  }

  group(part, indices, few) {
    const title = part || this.description.model || "scene";
    const body = el("div", { class: "rows" });
    const fill = () => {
      if (!body.childElementCount) {
        body.append(...indices.map((k) => this.row(k, this.list[k].name.slice(part ? part.length + 1 : 0))));
      }
    };
    const root = el("details", {}, el("summary", {}, icon("chevron"), el("span", {}, title), el("small", {}, indices.length)), body);
    root.addEventListener("toggle", () => {
      if (root.open) {
        fill();
        this.opened.add(part);
      } else this.opened.delete(part);
    });
    if (few || this.opened.has(part)) root.open = true;
    return root;
  }

  // Shows the parameters of a part.
  pick(part) {
    this.search.value = part ? `${part}.` : "";
    this.filter(this.search.value);
  }

  take(values) {
    this.values = values.map((value) => value ?? NaN);
    for (const [index, row] of this.rows) {
      if (!this.pending.has(this.list[index].name) && Math.abs(row.value - this.values[index]) > 0) {
        if (document.activeElement !== row.slider) row.show(this.values[index]);
      }
    }
  }
}
