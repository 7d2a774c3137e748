// Plots of what the scene observes: against time, or against each other.

import uPlot from "uplot";
import { el } from "./dom.js";
import { commonExponent, number, onAxis, scaledUnit, timeUnit, unitText } from "./numbers.js";

// Okabe and Ito's colours, which colour-blind readers can tell apart; in two lightnesses.
const COLOURS = {
  light: ["#0072b2", "#d55e00", "#009e73", "#b8578f", "#b88000", "#3c9fd6", "#333333"],
  dark: ["#56b4e9", "#f08a3c", "#2fc79a", "#e39bc4", "#f0c050", "#8ecbf2", "#d0d6dc"],
};
const POINTS = 900;

class Plot {
  constructor(panel, description, store, seek) {
    this.store = store;
    this.panel = panel;
    this.quantities = panel.quantities.map((k) => description.observed[k]);
    this.across = panel.across == null ? null : description.observed[panel.across];
    this.units = [...new Set(this.quantities.map((q) => q.unit))];
    this.largest = this.quantities.map(() => 0); // sizes shown so far
    this.seek = seek;
    this.legend = el("div", { class: "legend" });
    this.chart = el("div", { class: "chart" });
    const names = this.quantities.map((q) => bare(q.name)).join(", ");
    const title = this.across ? `${names} against ${bare(this.across.name)}` : names;
    this.chart.setAttribute("role", "img");
    this.chart.setAttribute("aria-label", `Plot of ${title}`);
    this.root = el("section", { class: "plot", "aria-label": title }, this.legend, this.chart);
  }

  build(theme, tick) {
    this.uplot?.destroy();
    const style = getComputedStyle(document.documentElement);
    const text = style.getPropertyValue("--soft").trim();
    const grid = { stroke: style.getPropertyValue("--rule").trim(), width: 1 };
    const font = "11px system-ui, sans-serif";
    const colours = COLOURS[theme];
    this.tick = tick;
    this.fillLegend(colours);
    const axis = (extra) => ({
      stroke: text, font, grid, ticks: { ...grid, size: 4 }, gap: 4,
      values: (_, splits) => tickTexts(splits),
      ...extra,
    });
    // The first unit is that of the left axis, all others share the right one.
    const sides = [this.units.slice(0, 1), this.units.slice(1)].filter((of) => of.length);
    const side = (of, k) => axis({
      scale: `y${k}`, side: k ? 1 : 3, size: roomFor, space: 20, grid: k ? { show: false } : grid,
      label: (u) => of.map((unit) => scaledUnit(unit, exponentOf(u.scales[`y${k}`]))).join(", "), labelSize: 16, labelFont: font, labelGap: 0,
    });
    const scales = { x: { time: false, range: () => this.range } };
    sides.forEach((_, k) => (scales[`y${k}`] = { range: padded }));
    const scaleOf = (q) => this.scaleOf(q);
    const options = {
      width: Math.max(80, this.chart.clientWidth),
      height: Math.max(60, this.chart.clientHeight),
      padding: [6, sides.length > 1 ? 0 : 18, 0, 0],
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { show: false }, y: false },
      scales,
      axes: [axis({ size: 26, space: 60, values: (_, splits) => tickTexts(splits, 0).map((text, k) => (k === splits.length - 1 ? `${text} ${tick.unit}` : text)) }), ...sides.map(side)],
      series: [{}],
      hooks: {
        draw: [(u) => this.cursor(u, style.getPropertyValue("--accent").trim()), (u) => this.scaleLegend(u)],
      },
    };
    if (this.across) {
      options.mode = 2;
      options.cursor = { show: false };
      scales.x = { time: false, range: padded };
      options.axes[0] = axis({ size: 24, space: 60, label: (u) => {
        const unit = scaledUnit(this.across.unit, exponentOf(u.scales.x));
        return `${bare(this.across.name)}${unit && ` [${unit}]`}`;
      }, labelSize: 14, labelFont: font, labelGap: 0 });
      options.series = [null, ...this.quantities.map((q, k) => ({
        stroke: colours[k % colours.length],
        paths: (u, i) => this.path(u, i, colours[k % colours.length]),
        facets: [{ scale: "x", auto: true }, { scale: scaleOf(q), auto: true }],
      }))];
    } else {
      for (const [k, q] of this.quantities.entries()) {
        options.series.push({ scale: scaleOf(q), stroke: colours[k % colours.length], width: 1.6, pxAlign: 0, points: { show: false } });
      }
      // The errors: for each curve that has some, one below and one above it that bound a band.
      options.bands = [];
      for (const [k, q] of this.quantities.entries()) {
        if (q.error == null) continue;
        const edge = { scale: scaleOf(q), stroke: "transparent", width: 0, pxAlign: 0, points: { show: false } };
        const below = options.series.push({ ...edge }, { ...edge }) - 2;
        options.bands.push({ series: [below + 1, below], fill: `${colours[k % colours.length]}40` });
      }
    }
    this.range = [0, 1];
    this.uplot = new uPlot(options, this.empty(), this.chart);
    this.version = null;
    if (!this.across) {
      this.uplot.over.addEventListener("click", (event) => {
        const rect = this.uplot.over.getBoundingClientRect();
        this.seek(this.uplot.posToVal(event.clientX - rect.left, "x") * this.tick.factor);
      });
    }
  }

  // The names, and the present values; a prefix that all names have, and a unit, stand once.
  fillLegend(colours) {
    const names = this.quantities.map((q) => bare(q.name));
    const [head, rest] = commonHead(names);
    const sameUnit = this.units.length === 1;
    this.values = this.quantities.map(() => el("b", {}));
    this.errors = this.quantities.map(errorText);
    this.unitTexts = [];
    this.exponents = {};
    const entries = this.quantities.map((q, k) => {
      const mark = el("i", { style: `background:${colours[k % colours.length]}` });
      return el("span", { class: "entry", title: q.name }, mark, el("span", { class: "name" }, rest[k]),
        el("span", { class: "value" }, this.values[k], this.errors[k], sameUnit && head ? null : this.unitOf(q)));
    });
    const title = head && el("span", { class: "head", title: head }, head, sameUnit ? this.unitOf(this.quantities[0]) : null);
    this.legend.replaceChildren(...[title, ...entries].filter(Boolean));
  }

  scaleOf(q) {
    return `y${Math.min(1, Math.max(0, this.units.indexOf(q.unit)))}`;
  }

  unitOf(q) {
    const text = el("small", {}, ` ${unitText(q.unit)}`);
    this.unitTexts.push([q, text]);
    return text;
  }

  // Values in the legend have the power of ten of their axis.
  scaleLegend(u) {
    const exponents = Object.fromEntries(this.quantities.map((q) => [this.scaleOf(q), exponentOf(u.scales[this.scaleOf(q)])]));
    if (JSON.stringify(exponents) === JSON.stringify(this.exponents)) return;
    this.exponents = exponents;
    for (const [q, text] of this.unitTexts) text.textContent = ` ${scaledUnit(q.unit, exponents[this.scaleOf(q)])}`;
    this.showValues();
  }

  showValues(row = this.row) {
    this.row = row;
    this.quantities.forEach((q, k) => {
      const scale = this.scaleOf(q);
      const unit = 10 ** (this.exponents[scale] ?? 0);
      const { min, max } = this.uplot?.scales[scale] ?? {};
      const value = row?.[q.column] / q.factor;
      this.largest[k] = Math.max(this.largest[k], Math.abs(value) || 0);
      const text = onAxis(value / unit, this.largest[k] / unit, min / unit, max / unit);
      if (this.values[k].textContent !== text) this.values[k].textContent = text;
      if (q.error != null && row) this.errors[k].textContent = ` ± ${number(row[q.error] / q.factor / unit, 1)}`;
    });
  }

  empty() {
    if (this.across) return [null, ...this.quantities.map(() => [[0], [0]])];
    const bands = this.quantities.filter((q) => q.error != null);
    return [[0], ...[...this.quantities, ...bands, ...bands].map(() => [null])];
  }

  // A curve through points in the order of time.
  path(u, i, colour) {
    const [xs, ys] = u.data[i];
    const { ctx } = u;
    const scale = u.series[i].facets[1].scale;
    ctx.save();
    ctx.beginPath();
    ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    ctx.clip();
    ctx.beginPath();
    ctx.strokeStyle = colour;
    ctx.lineWidth = 1.6 * devicePixelRatio;
    ctx.lineJoin = "round";
    let drawn = false;
    for (let k = 0; k < xs.length; k++) {
      if (xs[k] == null || ys[k] == null) {
        drawn = false;
        continue;
      }
      const [x, y] = [u.valToPos(xs[k], "x", true), u.valToPos(ys[k], scale, true)];
      if (drawn) ctx.lineTo(x, y);
      else ctx.moveTo(x, y);
      drawn = true;
    }
    ctx.stroke();
    ctx.restore();
    return null;
  }

  // The present time as a line, or as a point of each curve.
  cursor(u, accent) {
    if (this.now == null) return;
    const { ctx, bbox } = u;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = accent;
    if (this.across) {
      const [x, ...ys] = this.at ?? [];
      ys.forEach((y, k) => {
        if (x == null || y == null) return;
        ctx.beginPath();
        const scale = u.series[k + 1].facets[1].scale;
        ctx.arc(u.valToPos(x, "x", true), u.valToPos(y, scale, true), 4 * devicePixelRatio, 0, 7);
        ctx.fill();
      });
    } else {
      const x = u.valToPos(this.now / this.tick.factor, "x", true);
      if (x >= bbox.left && x <= bbox.left + bbox.width) {
        ctx.globalAlpha = 0.75;
        ctx.lineWidth = devicePixelRatio;
        ctx.beginPath();
        ctx.moveTo(x, bbox.top);
        ctx.lineTo(x, bbox.top + bbox.height);
        ctx.stroke();
      }
    }
    ctx.restore();
  }

  // Shows rows of a span of time, and the values of a row at the present. Where the rows are those drawn
  // before, only the mark of the present moves.
  update(span, row, now) {
    if (!this.uplot) return;
    this.showValues(row);
    const version = [this.store.version, this.store.count, ...span].join();
    if (version === this.version && now === this.now) return;
    this.now = now;
    this.at = this.across && [this.across, ...this.quantities].map((q) => row[q.column] / q.factor);
    if (version === this.version) return this.uplot.redraw(false, false);
    this.version = version;
    const [first, last] = [this.store.find(span[0]), this.store.find(span[1])];
    if (!this.store.count) return this.uplot.setData(this.empty());
    const all = this.across ? [...this.quantities, this.across] : this.quantities;
    const [times, ...series] = this.store.series(
      first, last, all.map((q) => q.column), all.map((q) => q.factor), POINTS,
    );
    this.range = span.map((t) => t / this.tick.factor);
    if (this.across) {
      const xs = series.pop();
      this.uplot.setData([null, ...series.map((ys) => [xs, ys])]);
    } else {
      const bands = this.quantities.filter((q) => q.error != null)
        .flatMap((q) => this.store.band(first, last, q.column, q.error, q.factor, POINTS));
      this.uplot.setData([times.map((t) => t / this.tick.factor), ...series, ...bands]);
    }
  }

  resize() {
    if (!this.uplot) return;
    const [width, height] = [this.chart.clientWidth, this.chart.clientHeight];
    if (width && height && (width !== this.uplot.width || height !== this.uplot.height)) {
      this.uplot.setSize({ width, height });
    }
  }
}

// The name of a quantity without the unit that a user has asked for.
const bare = (name) => name.replace(/ \[[^\]]*\]$/, "");

// Where the error of a quantity stands: it is null where it is unknown, and absent where no plot would show it.
const errorText = ({ error }) =>
  error === undefined ? null : el("small", { title: error === null ? "its error is unknown" : "estimated error" }, " ± ?");

// What names have in common at their start, a vector or a part, and the rest of each.
export function commonHead(names) {
  if (names.length < 2) return ["", names];
  const of = (name) => name.match(/^(.*?)(\[[\d, ]+\])$/);
  const found = names.map(of);
  if (found.every((m) => m && m[1] === found[0]?.[1])) return [found[0][1], found.map((m) => m[2].slice(1, -1))];
  const at = names[0].lastIndexOf(".") + 1;
  const head = names[0].slice(0, at);
  if (at && names.every((name) => name.startsWith(head) && !name.slice(at).includes("."))) return [head.slice(0, -1), names.map((name) => name.slice(at))];
  return ["", names];
}

// The width of an axis: that of its longest label, and at least that which most plots need, so that plots are
// in line with each other. `labels` are null at the first call.
const roomFor = (_, labels) => Math.max(48, 12 + 6.4 * Math.max(0, ...(labels ?? []).map((text) => text.length)));

const exponentOf = ({ min, max }) => commonExponent(Math.max(Math.abs(min ?? 0), Math.abs(max ?? 0)));

// The labels of ticks, without the power of ten that they have in common: the unit of the axis has it.
function tickTexts(splits, exponent = exponentOf({ min: splits[0], max: splits.at(-1) })) {
  return splits.map((v) => (v == null ? "" : number(Number((v / 10 ** exponent).toPrecision(8)), 6)));
}

// A range with a little room; a constant has the same room above and below.
function padded(_, low, high) {
  if (low == null || high == null) return [0, 1];
  const size = Math.max(Math.abs(low), Math.abs(high));
  let width = high - low;
  if (!(width > 1e-9 * size)) width = size ? 0.2 * size : 2;
  const room = high - low > 1e-9 * size ? 0.07 * width : width / 2;
  return [low - room, high + room];
}

export class Plots {
  constructor(holder, description, store, seek) {
    this.holder = holder;
    this.description = description;
    this.waiting = [];
    this.seen = 0;
    this.list = description.panels.map((panel) => new Plot(panel, description, store, seek));
    if (!this.list.length) holder.append(el("p", { class: "none" }, "The scene observes nothing."));
    holder.append(...this.list.map((plot) => plot.root));
    new ResizeObserver(() => this.list.forEach((plot) => plot.resize())).observe(holder);
  }

  theme(name) {
    const tick = timeUnit(this.description.duration || 1);
    for (const plot of this.list) plot.build(name, tick);
  }

  // Takes what the plots in view are to show: a share of them now, the others in the next frames.
  update(span, row, now, share) {
    const { top, bottom } = this.holder.getBoundingClientRect();
    const isSeen = ({ root }) => {
      const place = root.getBoundingClientRect();
      return place.bottom > top && place.top < bottom;
    };
    const seen = this.list.filter(isSeen);
    this.seen = seen.length;
    const kept = Float32Array.from(row);
    // Those that have waited since the last call come first.
    const waiting = this.waiting.map(([plot]) => plot).filter((plot) => seen.includes(plot));
    const order = [...waiting, ...seen.filter((plot) => !waiting.includes(plot))];
    this.waiting = order.map((plot) => [plot, () => plot.update(span, kept, now)]);
    this.next(share);
  }

  // Draws a share of the plots in view, at least one of those that wait.
  next(share) {
    const count = Math.max(1, Math.ceil(share * this.seen));
    for (const [, draw] of this.waiting.splice(0, count)) draw();
  }
}
