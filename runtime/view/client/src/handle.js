// The grip of an input device: its position beside the scene, seen from above, with its height.

import { el, number } from "./dom.js";
import { reader } from "./parts.js";

const SIZE = 104;
const svg = (tag, attributes, parent) => {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  parent.append(node);
  return node;
};

export class Handle {
  constructor(holder, shape) {
    this.read = reader(shape.values.position);
    this.reach = 0.02; // m, grows with the motion
    const middle = SIZE / 2;
    const drawing = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    drawing.setAttribute("width", SIZE + 26);
    drawing.setAttribute("height", SIZE);
    const line = { stroke: "var(--faint)", "stroke-width": 1, fill: "none" };
    svg("circle", { cx: middle, cy: middle, r: middle - 2, ...line, fill: "var(--raised)" }, drawing);
    svg("circle", { cx: middle, cy: middle, r: (middle - 2) / 2, ...line, "stroke-dasharray": "2 3" }, drawing);
    svg("path", { d: `M${middle} 6V${SIZE - 6}M6 ${middle}H${SIZE - 6}`, ...line }, drawing);
    svg("rect", { x: SIZE + 12, y: 2, width: 8, height: SIZE - 4, rx: 4, ...line, fill: "var(--raised)" }, drawing);
    svg("path", { d: `M${SIZE + 8} ${middle}h16`, ...line }, drawing);
    this.spoke = svg("path", { stroke: "var(--accent)", "stroke-width": 2, fill: "none" }, drawing);
    this.dot = svg("circle", { r: 7, fill: "var(--accent)" }, drawing);
    this.bar = svg("rect", { x: SIZE + 10, width: 12, height: 6, rx: 3, fill: "var(--accent)" }, drawing);
    this.text = el("small");
    this.root = el("div", { class: "glass handle" }, drawing, this.text);
    holder.append(this.root);
  }

  update(row) {
    const [x, y, z] = this.read(row);
    const size = Math.max(Math.hypot(x, y), Math.abs(z));
    while (Number.isFinite(size) && size > this.reach) this.reach *= 1.25;
    const middle = SIZE / 2;
    const scale = (middle - 10) / this.reach;
    // x points up in the drawing and y to the left, as seen from above behind the handle.
    const [px, py] = [middle - y * scale, middle - x * scale];
    this.dot.setAttribute("cx", px);
    this.dot.setAttribute("cy", py);
    this.spoke.setAttribute("d", `M${middle} ${middle}L${px} ${py}`);
    this.bar.setAttribute("y", middle - 3 - z * scale);
    this.text.textContent = `handle ${[x, y, z].map((v) => number(1000 * v, 2)).join(" ")} mm`;
  }
}
