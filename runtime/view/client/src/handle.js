// The pad of an input device beside the scene: its position seen from above, and its height. A hand
// that the page may take is dragged here too.

import { button, el } from "./dom.js";
import { fixed } from "./numbers.js";
import { reader } from "./objects.js";
import { Tilt } from "./tilt.js";

const SIZE = 104;
const MIDDLE = SIZE / 2;
const svg = (tag, attributes, parent) => {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  parent?.append(node);
  return node;
};

export class Handle {
  // `shape` shows the position in a row, `hand` is what the page may take: one of them may be absent.
  constructor(holder, { shape, hand, leave }) {
    this.read = shape ? reader(shape.values.position) : null;
    this.hand = hand;
    this.reach = hand?.device.reach ?? 0.02; // m, grows with the motion
    const name = hand?.device.name ?? "handle";
    const drawing = svg("svg", { width: SIZE + 26, height: SIZE, role: "img", "aria-label": `Position of ${name}` });
    const line = { stroke: "var(--faint)", "stroke-width": 1, fill: "none" };
    const raised = { ...line, fill: "var(--raised)" };
    const flat = svg("g", { class: "flat" }, drawing);
    if (hand) this.steerByKeys(drawing, name);
    svg("circle", { cx: MIDDLE, cy: MIDDLE, r: MIDDLE - 2, ...raised }, flat);
    svg("circle", { cx: MIDDLE, cy: MIDDLE, r: (MIDDLE - 2) / 2, ...line, "stroke-dasharray": "2 3" }, flat);
    svg("path", { d: `M${MIDDLE} 6V${SIZE - 6}M6 ${MIDDLE}H${SIZE - 6}`, ...line }, flat);
    const high = svg("g", { class: "high" }, drawing);
    svg("rect", { x: SIZE + 6, y: 0, width: 20, height: SIZE, fill: "transparent" }, high);
    svg("rect", { x: SIZE + 12, y: 2, width: 8, height: SIZE - 4, rx: 4, ...raised }, high);
    svg("path", { d: `M${SIZE + 8} ${MIDDLE}h16`, ...line }, high);
    this.spoke = svg("path", { stroke: "var(--accent)", "stroke-width": 2, fill: "none" }, flat);
    this.dot = svg("circle", { r: 7, fill: "var(--accent)" }, flat);
    this.bar = svg("rect", { x: SIZE + 10, width: 12, height: 6, rx: 3, fill: "var(--accent)" }, high);
    this.text = el("small", { class: "where" });
    this.root = el("div", { class: "glass handle" }, hand ? this.head(name, leave) : null, drawing, this.text);
    if (hand) {
      this.root.classList.add("free");
      this.drag(flat, (dx, dy, from) => [from[0] - dy, from[1] - dx, from[2]]);
      this.drag(high, (dx, dy, from) => [from[0], from[1], from[2] - dy]);
      this.root.append(this.pressed());
    }
    holder.append(this.root);
  }

  head(name, leave) {
    const { hand } = this;
    this.by = el("small");
    this.pin = button("pin", "Stays where it is let go", () => {
      hand.stays = !hand.stays;
      this.pin.setAttribute("aria-pressed", hand.stays);
    });
    this.pin.setAttribute("aria-pressed", false);
    this.back = button("undo", `Give ${name} back to ${hand.device.driver}`, () => leave(hand));
    return el("div", { class: "row" }, el("b", {}, name), this.by, this.back, Tilt.isOffered ? this.tilted() : null, this.pin);
  }

  // Begins and ends to move the hand by the tilt of the screen.
  tilted() {
    const key = button("tilt", "Tilt the screen to move it", () => this.tilt.toggle(), { "aria-pressed": false });
    this.tilt = new Tilt(this.hand, () => key.setAttribute("aria-pressed", this.tilt.on));
    return key;
  }

  // The first buttons of the device, held as long as they are pressed.
  pressed() {
    const { hand } = this;
    const hidden = !hand.device.reads.includes("buttons");
    return el("div", { class: "row buttons", hidden }, ...[0, 1, 2, 3].map((k) => {
      const key = el("button", { type: "button", title: `Button ${k + 1} of ${hand.device.name}` }, String(k + 1));
      key.addEventListener("pointerdown", (event) => {
        key.setPointerCapture(event.pointerId);
        hand.press(k, true);
      });
      for (const end of ["pointerup", "pointercancel"]) key.addEventListener(end, () => hand.press(k, false));
      return key;
    }));
  }

  // The arrow keys move the hand ahead, back and aside, Page Up and Page Down its height, Home to the middle.
  steerByKeys(drawing, name) {
    const { hand } = this;
    const ways = { ArrowUp: [1, 0, 0], ArrowDown: [-1, 0, 0], ArrowLeft: [0, 1, 0], ArrowRight: [0, -1, 0], PageUp: [0, 0, 1], PageDown: [0, 0, -1], Home: [0, 0, 0] };
    drawing.setAttribute("tabindex", 0);
    drawing.setAttribute("role", "application");
    drawing.setAttribute("aria-label", `${name}: the arrow keys, Page Up and Page Down move it, Home centres it`);
    drawing.addEventListener("keydown", (event) => {
      const way = ways[event.key];
      if (!way) return;
      event.preventDefault();
      event.stopPropagation();
      if (hand.by !== "keyboard") hand.grab(this.seen, "keyboard");
      const step = hand.device.reach / 20;
      hand.move(event.key === "Home" ? way : hand.position.map((x, k) => x + step * way[k]));
    });
    drawing.addEventListener("keyup", (event) => ways[event.key] && hand.release());
    drawing.addEventListener("blur", () => hand.by === "keyboard" && hand.release());
  }

  drag(node, moved) {
    let start = null;
    node.addEventListener("pointerdown", (event) => {
      node.setPointerCapture(event.pointerId);
      this.hand.grab(this.seen);
      start = { x: event.clientX, y: event.clientY, from: [...this.hand.position] };
      event.preventDefault();
    });
    node.addEventListener("pointermove", (event) => {
      if (!start) return;
      const scale = this.reach / (MIDDLE - 10);
      this.hand.move(moved((event.clientX - start.x) * scale, (event.clientY - start.y) * scale, start.from));
    });
    for (const end of ["pointerup", "pointercancel"]) {
      node.addEventListener(end, () => {
        if (start) this.hand.release();
        start = null;
      });
    }
  }

  // Shows the position of a row; that which is given by the page itself is shown at once.
  update(row) {
    if (this.read) this.seen = [...this.read(row)];
    const { hand } = this;
    const [x, y, z] = (hand?.taken ? hand.position : this.seen) ?? [0, 0, 0];
    const size = Math.max(Math.hypot(x, y), Math.abs(z));
    while (Number.isFinite(size) && size > 1.001 * this.reach) this.reach *= 1.25;
    const scale = (MIDDLE - 10) / this.reach;
    // x points up in the drawing and y to the left, as seen from above behind the handle.
    const [px, py] = [MIDDLE - y * scale, MIDDLE - x * scale];
    this.dot.setAttribute("cx", px);
    this.dot.setAttribute("cy", py);
    this.spoke.setAttribute("d", `M${MIDDLE} ${MIDDLE}L${px} ${py}`);
    this.bar.setAttribute("y", MIDDLE - 3 - z * scale);
    this.text.textContent = `${[x, y, z].map((v) => fixed(1000 * v, this.reach < 1 ? 1 : 0)).join("  ")} mm`;
    if (!hand) return;
    const fed = ["pointer", "gamepad"].includes(hand.device.driver);
    this.by.textContent = this.tilt?.problem ? this.tilt.problem : hand.taken ? hand.by ?? "on the page" : fed ? "drag it" : hand.device.driver;
    this.back.hidden = !hand.taken || fed;
    this.root.classList.toggle("taken", hand.taken);
  }
}
