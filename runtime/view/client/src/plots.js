// Plots of what the scene observes: against time, or against each other.

import uPlot from "uplot";
import { el, number, timeUnit } from "./dom.js";

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
    this.seek = seek;
    this.legend = el("div", { class: "legend" });
    this.chart = el("div", { class: "chart" });
    this.root = el("section", { class: "plot" }, this.legend, this.chart);
    this.values = [];
  }

  build(theme, tick) {
    this.uplot?.destroy();
    const style = getComputedStyle(document.documentElement);
    const text = style.getPropertyValue("--soft").trim();
    const grid = { stroke: style.getPropertyValue("--rule").trim(), width: 1 };
    const font = "11px system-ui, sans-serif";
    const colours = COLOURS[theme];
    this.tick = tick;
    this.legend.replaceChildren(
      ...this.quantities.map((q, k) => {
        const value = el("b", {});
        this.values[k] = value;
        const mark = el("i", { style: `background:${colours[k % colours.length]}` });
        const name = q.name.replace(/ \[[^\]]*\]$/, "");
        return el("span", { class: "entry", title: q.name }, mark, el("span", { class: "name" }, name), value, el("small", {}, q.unit));
      }),
    );
    const axis = (extra) => ({
      stroke: text, font, grid, ticks: { ...grid, size: 4 }, gap: 4,
      values: (_, splits) => splits.map((v) => (v == null ? "" : number(Number(v.toPrecision(8)), 6))),
      ...extra,
    });
    const side = (unit, k) => axis({ scale: `y${k}`, side: k ? 1 : 3, size: 52, grid: k ? { show: false } : grid, label: unit || undefined, labelSize: unit ? 16 : 0, labelFont: font, labelGap: 0 });
    const units = this.units.slice(0, 2);
    const scales = { x: { time: false, range: () => this.range } };
    units.forEach((_, k) => (scales[`y${k}`] = { range: padded }));
    const scaleOf = (q) => `y${Math.min(1, Math.max(0, units.indexOf(q.unit)))}`;
    const options = {
      width: Math.max(80, this.chart.clientWidth),
      height: Math.max(60, this.chart.clientHeight),
      padding: [6, units.length > 1 ? 0 : 18, 0, 0],
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { show: false }, y: false },
      scales,
      axes: [axis({ size: 26, space: 60, values: (_, splits) => splits.map((v, k) => `${number(Number(v.toPrecision(8)), 6)}${k === splits.length - 1 ? ` ${tick.unit}` : ""}`) }), ...units.map(side)],
      series: [{}],
      hooks: { draw: [(u) => this.cursor(u, style.getPropertyValue("--accent").trim())] },
    };
    if (this.across) {
      options.mode = 2;
      options.cursor = { show: false };
      scales.x = { time: false, range: padded };
      options.axes[0] = axis({ size: 24, space: 60, label: `${this.across.name} ${this.across.unit && `[${this.across.unit}]`}`, labelSize: 14, labelFont: font, labelGap: 0 });
      options.series = [null, ...this.quantities.map((q, k) => ({
        stroke: colours[k % colours.length],
        paths: (u, i) => this.path(u, i, colours[k % colours.length]),
        facets: [{ scale: "x", auto: true }, { scale: scaleOf(q), auto: true }],
      }))];
    } else {
      for (const [k, q] of this.quantities.entries()) {
        options.series.push({ scale: scaleOf(q), stroke: colours[k % colours.length], width: 1.6, pxAlign: 0, points: { show: false } });
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

  empty() {
    return this.across ? [null, ...this.quantities.map(() => [[0], [0]])] : [[0], ...this.quantities.map(() => [null])];
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

  // Shows rows of a span of time, and the values of a row at the present.
  update(span, row, now, stamp) {
    if (!this.uplot) return;
    this.quantities.forEach((q, k) => {
      const text = number(row[q.column] / q.factor, 4);
      if (this.values[k].textContent !== text) this.values[k].textContent = text;
    });
    if (stamp === this.version) return;
    this.version = stamp;
    this.now = now;
    this.at = this.across && [this.across, ...this.quantities].map((q) => row[q.column] / q.factor);
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
      this.uplot.setData([times.map((t) => t / this.tick.factor), ...series]);
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
    this.list = description.panels.map((panel) => new Plot(panel, description, store, seek));
    if (!this.list.length) holder.append(el("p", { class: "none" }, "The scene observes nothing."));
    holder.append(...this.list.map((plot) => plot.root));
    new ResizeObserver(() => this.list.forEach((plot) => plot.resize())).observe(holder);
  }

  theme(name) {
    const tick = timeUnit(this.description.duration || 1);
    for (const plot of this.list) plot.build(name, tick);
  }

  update(span, row, now, stamp) {
    const { top, bottom } = this.holder.getBoundingClientRect();
    for (const plot of this.list) {
      const place = plot.root.getBoundingClientRect();
      if (place.bottom > top && place.top < bottom) plot.update(span, row, now, stamp);
    }
  }
}
