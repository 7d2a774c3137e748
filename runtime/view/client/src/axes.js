// The directions of the axes of the scene in a corner of the view, and the cell of the grid on the ground.

import * as THREE from "three";
import { el } from "./dom.js";
import { number, scaledUnit } from "./numbers.js";

const SIZE = 72;
const LENGTH = 24;
const NAMES = ["x", "y", "z"];

export class Axes {
  constructor(holder, stage) {
    this.stage = stage;
    this.at = new THREE.Quaternion(0, 0, 0, 0);
    const space = "http://www.w3.org/2000/svg";
    this.drawing = document.createElementNS(space, "svg");
    for (const [name, value] of [["width", SIZE], ["height", SIZE], ["viewBox", `${-SIZE / 2} ${-SIZE / 2} ${SIZE} ${SIZE}`]]) this.drawing.setAttribute(name, value);
    this.arms = NAMES.map((name) => {
      const group = document.createElementNS(space, "g");
      const [line, text] = ["line", "text"].map((tag) => document.createElementNS(space, tag));
      group.setAttribute("class", name);
      text.textContent = name;
      group.append(line, text);
      this.drawing.append(group);
      return { group, line, text };
    });
    this.cell = el("small");
    holder.append(el("div", { class: "axes", "aria-hidden": "true" }, this.drawing, this.cell));
  }

  update() {
    const { camera, cell } = this.stage;
    if (cell !== this.shown) {
      this.shown = cell;
      const exponent = cell >= 1000 ? 3 : cell >= 1 ? 0 : -3;
      this.cell.textContent = cell ? `grid ${number(cell / 10 ** exponent, 3)} ${scaledUnit("m", exponent)}` : "";
    }
    if (this.at.equals(camera.quaternion)) return;
    this.at.copy(camera.quaternion);
    const inverse = camera.quaternion.clone().invert();
    const ends = NAMES.map((_, k) => new THREE.Vector3().setComponent(k, 1).applyQuaternion(inverse));
    ends.forEach(({ x, y }, k) => {
      const { line, text } = this.arms[k];
      line.setAttribute("x2", LENGTH * x);
      line.setAttribute("y2", -LENGTH * y);
      text.setAttribute("x", (LENGTH + 8) * x);
      text.setAttribute("y", -(LENGTH + 8) * y + 4);
    });
    // The one that points to the eye lies over the others.
    [0, 1, 2].sort((a, b) => ends[a].z - ends[b].z).forEach((k) => this.drawing.append(this.arms[k].group));
  }
}
