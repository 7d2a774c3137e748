// The bond graph: layouts by depth, the power of each bond as its width and colour, and what a click shows.

import { button, el, icon } from "./dom.js";
import { number, unitText, watts } from "./numbers.js";

const [THIN, THICK] = [1.1, 8.5];
const DECADES = 4; // of power, from the thinnest to the widest
const LEAST = 1e-9; // W: less is taken for rounding errors of a model at rest
const BARB = 11;
const STROKE = 8; // half the length of a causal stroke
const svg = (tag, attributes = {}, parent = null) => {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) if (value != null) node.setAttribute(name, value);
  parent?.append(node);
  return node;
};

const key = (path) => path.replace(/\[\d+\]$/, "");

export class GraphView {
  // `on` has the functions `part(path)`, with null for none, and `ask()`, which requests the graph.
  constructor(holder, on) {
    this.on = on;
    this.values = null; // e1 f1 e2 f2 ..
    this.largest = 0;
    this.waiting = el("p", { class: "waiting", role: "status" }, el("i", { class: "spin" }), "The bond graph is being compiled");
    this.drawing = svg("svg", { class: "graph", role: "group", "aria-label": "Bond graph" });
    this.depths = el("div", { class: "depths", role: "group", "aria-label": "Depth" });
    this.tools = el("div", { class: "glass cameras" }, this.depths, button("fit", "Whole graph (1)", () => this.fit()));
    this.legend = el("div", { class: "glass legend-power" });
    this.card = el("div", { class: "glass card", hidden: true });
    this.root = el("div", { class: "graph-view", hidden: true }, this.drawing, this.waiting, this.tools, this.legend, this.card);
    holder.append(this.root);
    this.listen();
    this.tools.hidden = this.legend.hidden = true;
  }

  get shown() {
    return !this.root.hidden;
  }

  show(on) {
    this.root.hidden = !on;
    if (on && !this.graph) this.on.ask();
    if (on && this.graph && !this.box) this.choose(this.layout ?? 0);
  }

  fail() {
    this.waiting.replaceChildren("The bond graph could not be compiled");
  }

  // --- the layout -------------------------------------------------------------------------------

  take(graph) {
    this.graph = graph;
    this.waiting.hidden = true;
    this.tools.hidden = this.legend.hidden = false;
    this.depths.replaceChildren(
      ...graph.layouts.map(({ depth }, k) =>
        el("button", { type: "button", title: depth ? `Open parts to level ${depth}` : "Open all parts", onclick: () => this.choose(k) }, depth ? String(depth) : "all")),
    );
    // The deepest layout that is still readable at a glance.
    const readable = graph.layouts.findLastIndex((layout) => layout.nodes.length <= 45);
    this.choose(Math.max(0, readable));
  }

  choose(k) {
    this.layout = k;
    [...this.depths.children].forEach((b, i) => b.setAttribute("aria-pressed", i === k));
    this.draw(this.graph.layouts[k]);
    if (this.shown) this.fit();
    this.select(null);
    this.update();
  }

  draw({ nodes, edges, signals, clusters }) {
    this.world = svg("g");
    this.drawing.replaceChildren(this.world);
    for (const { box, label, path } of clusters) {
      const [x, y, width, height] = box;
      const cluster = svg("g", { class: "cluster" }, this.world);
      svg("rect", { x, y, width, height, rx: 8 }, cluster);
      svg("text", { x: x + 8, y: y + 13 }, cluster).textContent = label;
      cluster.addEventListener("click", () => this.pick(path));
    }
    for (const [tail, head] of signals) {
      const [a, b] = [nodes[tail].at, nodes[head].at];
      const bend = 0.5 * (b[0] - a[0]);
      svg("path", { class: "signal", d: `M${a}C${a[0] + bend} ${a[1]} ${b[0] - bend} ${b[1]} ${b}` }, this.world);
    }
    this.edges = edges.filter((edge) => edge.curve?.length >= 8).map((edge) => this.drawEdge(edge));
    this.nodes = nodes.map((node) => this.drawNode(node));
  }

  drawNode(node) {
    const [[x, y], [width, height]] = [node.at, node.size];
    const root = svg("g", { class: `node${node.part ? " part" : ""}`, tabindex: 0, role: "button" }, this.world);
    svg("rect", { x: x - width / 2, y: y - height / 2, width, height, rx: node.part ? 7 : 4 }, root);
    const text = (content, dy, kind) => (svg("text", { x, y: y + dy, class: kind }, root).textContent = content);
    if (node.part) text(node.name, 4.5, "name");
    else {
      if (node.kind) text(node.kind, -1, "kind");
      text(node.name, node.kind ? 11 : 3, "name");
    }
    svg("title", {}, root).textContent = node.path;
    root.addEventListener("click", () => this.pick(node.path));
    root.addEventListener("keydown", (event) => event.key === "Enter" && this.pick(node.path));
    return { node, root };
  }

  // A bond: its line, the half arrow at its head, and a causal stroke at each end that has one.
  drawEdge(edge) {
    const root = svg("g", { class: "bond", tabindex: 0, role: "button" }, this.world);
    const points = [];
    for (let k = 0; k < edge.curve.length; k += 2) points.push([edge.curve[k], edge.curve[k + 1]]);
    const path = points.map((p, k) => (k === 0 ? `M${p}` : k === 1 ? `C${p}` : ` ${p}`)).join("");
    svg("path", { class: "target", d: path }, root);
    const line = svg("path", { class: "line", d: path }, root);
    const [tip, before] = [points.at(-1), points.at(-2)];
    const [end, after] = [points[0], points[1]];
    const unit = (a, b) => {
      const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
      const size = Math.hypot(dx, dy) || 1;
      return [dx / size, dy / size];
    };
    const [u, v] = [unit(before, tip), unit(after, end)];
    // The barb lies on the left of the arrow's way, as it is usual in bond graphs.
    const barb = [tip[0] - BARB * (0.9 * u[0] - 0.5 * u[1]), tip[1] - BARB * (0.9 * u[1] + 0.5 * u[0])];
    svg("path", { class: "barb", d: `M${tip}L${barb}` }, root);
    const strokes = edge.bonds.map((b) => this.graph.bonds[b].stroke);
    for (const [at, side, w] of [["head", tip, u], ["tail", end, v]]) {
      if (!strokes.includes(at)) continue;
      const [x, y] = side;
      svg("path", { class: "stroke", d: `M${x - STROKE * w[1]} ${y + STROKE * w[0]}L${x + STROKE * w[1]} ${y - STROKE * w[0]}` }, root);
    }
    if (edge.bonds.length > 1) {
      const middle = points[Math.floor(points.length / 2)];
      svg("text", { class: "width", x: middle[0], y: middle[1] - 5 }, root).textContent = edge.bonds.length;
    }
    const title = svg("title", {}, root);
    title.textContent = this.nameOf(edge);
    const pick = () => this.select(this.edges.find((e) => e.edge === edge));
    root.addEventListener("click", pick);
    root.addEventListener("keydown", (event) => event.key === "Enter" && pick());
    return { edge, root, line };
  }

  nameOf(edge) {
    const { name } = this.graph.bonds[edge.bonds[0]];
    return edge.bonds.length > 1 ? name.replace(/ \[\d+\]$/, "") : name;
  }

  // --- power ------------------------------------------------------------------------------------

  powers(values) {
    this.values = values;
    if (this.shown && this.graph) this.update();
  }

  power(edge) {
    let sum = 0;
    for (const b of edge.bonds) if (this.graph.bonds[b].power) sum += this.values[2 * b] * this.values[2 * b + 1];
    return sum;
  }

  update() {
    if (!this.values || !this.edges) return;
    const powers = this.edges.map(({ edge }) => this.power(edge));
    const now = Math.max(LEAST, ...powers.map((p) => (Number.isFinite(p) ? Math.abs(p) : 0)));
    // The scale falls slowly, so that widths can be compared over some seconds.
    this.largest = Math.max(now, 0.985 * this.largest);
    // On a drawing that is far away bonds are wider, so that their power is still seen.
    const wide = Math.min(2.4, Math.max(1, 0.8 / (this.box?.scale ?? 1)));
    this.edges.forEach((drawn, k) => {
      const power = powers[k];
      const size = Math.abs(power);
      const share = size > 0 ? Math.max(0, 1 + Math.log10(size / this.largest) / DECADES) : 0;
      const way = !Number.isFinite(power) ? "unknown" : share === 0 ? "still" : power > 0 ? "along" : "against";
      drawn.root.dataset.way = way;
      drawn.line.style.strokeWidth = wide * (THIN + (THICK - THIN) * share);
      drawn.root.style.setProperty("--strength", `${Math.round(35 + 65 * share)}%`);
    });
    this.legend.replaceChildren(
      el("i", { class: "along" }), "along the half arrow", el("i", { class: "against" }), "against it",
      el("b", {}, this.largest > LEAST ? `widest ${watts(this.largest)}` : "no power now"),
    );
    if (this.selected) this.fill();
  }

  // --- what a click shows -----------------------------------------------------------------------

  pick(path) {
    this.select(null);
    this.nodes.forEach(({ node, root }) => root.classList.toggle("marked", node.path === path));
    this.on.part(path);
  }

  // Where a part or an element is declared, and as what; of a component of a part that of the part.
  source(path) {
    const { parts, elements } = this.graph;
    if (path === "" || parts[path]) return { what: parts[path]?.model, line: parts[path]?.line };
    const found = elements[key(path)];
    return found ? { what: found.kind, line: found.line } : null;
  }

  select(drawn) {
    this.selected?.root.classList.remove("marked");
    this.selected = drawn ?? null;
    this.selected?.root.classList.add("marked");
    this.card.hidden = !drawn;
    if (drawn) {
      this.nodes.forEach(({ root }) => root.classList.remove("marked"));
      this.card.classList.toggle("aside", this.isLeft(drawn.line));
      this.fillHead();
      this.fill();
    }
  }

  // Whether a bond lies where the card stands by default.
  isLeft(line) {
    const [bond, whole] = [line, this.root].map((node) => node.getBoundingClientRect());
    return bond.left + bond.width / 2 < whole.left + whole.width / 2;
  }

  fillHead() {
    const { edge } = this.selected;
    const first = this.graph.bonds[edge.bonds[0]];
    const reasons = [...new Set(edge.bonds.map((b) => `${this.graph.bonds[b].stroke}|${this.graph.bonds[b].rule}|${this.graph.bonds[b].reason}`))];
    this.numbers = edge.bonds.map((b) => {
      const cells = [0, 1, 2].map(() => el("td"));
      const stroke = this.graph.bonds[b].stroke === "head" ? "⊣" : "⊢";
      const row = el("tr", {}, el("th", { title: `Causal stroke at the ${this.graph.bonds[b].stroke}` }, edge.bonds.length > 1 ? `${this.graph.bonds[b].name.match(/\[(\d+)\]$/)?.[1] ?? ""} ${stroke}` : stroke), ...cells);
      return { b, cells, row };
    });
    this.total = el("b");
    const [effort, flow] = first.units;
    const same = edge.bonds.every((b) => this.graph.bonds[b].units.join() === first.units.join());
    const unit = (text) => (same && text ? el("small", {}, ` ${unitText(text)}`) : null);
    const content = [
      el("div", { class: "row" }, el("b", { class: "title" }, this.nameOf(edge)), button("close", "Close", () => this.select(null))),
      el("div", { class: "scroll" },
        el("table", {}, el("thead", {}, el("tr", {}, el("td"), el("th", {}, "effort", unit(effort)), el("th", {}, "flow", unit(flow)), el("th", {}, "power", el("small", {}, " W")))),
          el("tbody", {}, ...this.numbers.map(({ row }) => row))),
      ),
      el("p", {}, "Power along the half arrow ", this.total),
      ...reasons.slice(0, 4).map((text) => {
        const [stroke, rule, reason] = text.split("|");
        return el("p", { class: "reason" }, el("b", {}, `Stroke at the ${stroke}, ${rule}: `), reason.replaceAll("`", ""), ".");
      }),
      reasons.length > 4 ? el("p", { class: "reason" }, `and ${reasons.length - 4} more`) : null,
      sourceBlock(first.line),
    ];
    this.card.replaceChildren(...content.filter(Boolean));
  }

  fill() {
    if (!this.values || !this.numbers) return;
    for (const { b, cells } of this.numbers) {
      const [e, f] = [this.values[2 * b], this.values[2 * b + 1]];
      [e, f, this.graph.bonds[b].power ? e * f : NaN].forEach((x, k) => (cells[k].textContent = number(x, 4)));
    }
    this.total.textContent = watts(this.power(this.selected.edge));
  }

  // --- moving about -----------------------------------------------------------------------------

  fit() {
    const { nodes, clusters } = this.graph.layouts[this.layout];
    const xs = [];
    const ys = [];
    for (const { at, size } of nodes) xs.push(at[0] - size[0] / 2, at[0] + size[0] / 2) && ys.push(at[1] - size[1] / 2, at[1] + size[1] / 2);
    for (const { box } of clusters) xs.push(box[0], box[0] + box[2]) && ys.push(box[1], box[1] + box[3]);
    const [left, top] = [Math.min(...xs), Math.min(...ys)];
    const [width, height] = [Math.max(...xs) - left, Math.max(...ys) - top];
    const { clientWidth, clientHeight } = this.root;
    if (!clientWidth) return;
    const scale = Math.min(1.6, clientWidth / (width + 60), clientHeight / (height + 130));
    this.box = { x: left + width / 2 - clientWidth / 2 / scale, y: top + height / 2 - (clientHeight + 20) / 2 / scale, scale };
    this.place();
  }

  place() {
    const { x, y, scale } = this.box;
    const { clientWidth, clientHeight } = this.root;
    this.drawing.setAttribute("viewBox", `${x} ${y} ${clientWidth / scale} ${clientHeight / scale}`);
  }

  zoom(factor, clientX, clientY) {
    const place = this.root.getBoundingClientRect();
    const { box } = this;
    const scale = Math.max(0.05, Math.min(6, box.scale * factor));
    box.x += (clientX - place.left) * (1 / box.scale - 1 / scale);
    box.y += (clientY - place.top) * (1 / box.scale - 1 / scale);
    box.scale = scale;
    this.place();
  }

  listen() {
    const fingers = new Map();
    this.drawing.addEventListener("wheel", (event) => {
      event.preventDefault();
      if (this.box) this.zoom(Math.exp(-0.0016 * event.deltaY), event.clientX, event.clientY);
    }, { passive: false });
    this.drawing.addEventListener("pointerdown", (event) => fingers.set(event.pointerId, [event.clientX, event.clientY]));
    this.drawing.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before || !this.box) return;
      const now = [event.clientX, event.clientY];
      const others = [...fingers].filter(([id]) => id !== event.pointerId).map(([, p]) => p);
      if (others.length) {
        const distance = (p) => Math.hypot(p[0] - others[0][0], p[1] - others[0][1]) || 1;
        this.zoom(distance(now) / distance(before), (now[0] + others[0][0]) / 2, (now[1] + others[0][1]) / 2);
      } else {
        this.box.x -= (now[0] - before[0]) / this.box.scale;
        this.box.y -= (now[1] - before[1]) / this.box.scale;
        this.place();
      }
      fingers.set(event.pointerId, now);
    });
    for (const end of ["pointerup", "pointercancel", "pointerleave"]) {
      this.drawing.addEventListener(end, (event) => fingers.delete(event.pointerId));
    }
    new ResizeObserver(() => this.box && this.shown && this.fit()).observe(this.root);
  }
}

export function sourceBlock(line) {
  if (!line) return null;
  return el("div", { class: "source" }, el("small", {}, `${line.file}, line ${line.number}`), el("code", {}, line.text));
}

// The slots that other parts fit too: a choice is compiled beside the run, and exchanged for it.
export class Slots {
  constructor(holder, use) {
    this.root = holder;
    this.use = use;
    this.busy = el("p", { class: "waiting", hidden: true, role: "status" }, el("i", { class: "spin" }), "Compiling; the run goes on meanwhile");
    this.rows = el("div", { class: "slots" });
    this.none = el("p", { class: "none" }, "Reading the slots of the scene");
    holder.append(this.busy, this.none, this.rows);
  }

  take(slots) {
    this.none.hidden = slots.length > 0;
    this.none.textContent = "No slot of the scene has another part that fits.";
    const top = slots.filter(({ slot }) => !slot.includes("."));
    const inner = slots.filter(({ slot }) => slot.includes("."));
    const list = (some) => some.map((slot) => this.row(slot));
    this.rows.replaceChildren(...list(top));
    if (inner.length) {
      this.rows.append(el("details", { open: !top.length }, el("summary", {}, icon("chevron"), el("span", {}, "Inside parts"), el("small", {}, inner.length)), el("div", { class: "rows" }, ...list(inner))));
    }
  }

  row({ slot, interface: kind, filled, others }) {
    const choice = el("select", { "aria-label": slot, onchange: () => this.use(slot, choice.value) },
      el("option", { value: filled, selected: true }, filled), ...others.map((name) => el("option", { value: name }, name)));
    return el("label", { class: "slot", title: `${slot} : ${kind}` }, el("span", {}, slot), el("small", {}, kind), choice);
  }

  // Of a choice that was not exchanged, the part that is in the slot is shown again.
  wait(on) {
    const ended = !this.busy.hidden && !on;
    this.busy.hidden = !on;
    for (const choice of this.root.querySelectorAll("select")) {
      choice.disabled = on;
      if (ended) choice.selectedIndex = 0;
    }
  }
}
