// The grip at the place that a device steers, such as a crane's tip: dragged with the mouse or a finger. The
// force on the hand is an arrow, the commanded place a dashed ring. Sizes are in pixels.

import * as THREE from "three";
import { el } from "./dom.js";
import { number } from "./numbers.js";
import { reader } from "./objects.js";

const LEVER = 96; // from the place to the grip at the end of its reach
const ARROW = 92; // the largest force so far
const [KNOB, RING] = [26, 34]; // diameters
const NEAR = { mouse: 20, touch: 38 };
const Z = new THREE.Vector3(0, 0, 1);
const COLOURS = { grip: "#1f83e6", force: "#e4572e", aim: "#ffffff" };

const above = { depthTest: false, depthWrite: false, toneMapped: false, transparent: true };

function sprite(draw) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 128;
  draw(canvas.getContext("2d"));
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  return new THREE.Sprite(new THREE.SpriteMaterial({ map, ...above }));
}

function knob(pen) {
  pen.shadowColor = "#0008";
  pen.shadowBlur = 14;
  pen.fillStyle = "#fff";
  pen.beginPath();
  pen.arc(64, 64, 50, 0, 7);
  pen.fill();
  pen.shadowBlur = 0;
  pen.fillStyle = COLOURS.grip;
  pen.beginPath();
  pen.arc(64, 64, 40, 0, 7);
  pen.fill();
  // Four small heads of arrows: it can be dragged.
  pen.fillStyle = "#fff";
  for (let k = 0; k < 4; k++) {
    pen.save();
    pen.translate(64, 64);
    pen.rotate((k * Math.PI) / 2);
    pen.beginPath();
    pen.moveTo(0, -30);
    pen.lineTo(9, -17);
    pen.lineTo(-9, -17);
    pen.fill();
    pen.restore();
  }
}

function ring(pen) {
  for (const [colour, width] of [["#0b1b2bb0", 11], [COLOURS.aim, 6]]) {
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.setLineDash([22, 14.65]);
    pen.beginPath();
    pen.arc(64, 64, 56, 0, 7);
    pen.stroke();
  }
}

function rod(colour, opacity = 1) {
  const shaft = new THREE.CylinderGeometry(1, 1, 1, 12).rotateX(Math.PI / 2).translate(0, 0, 0.5);
  return new THREE.Mesh(shaft, new THREE.MeshBasicMaterial({ color: colour, opacity, ...above }));
}

const ahead = new THREE.Vector3();

// Lays a rod from one point to another, `thick` wide; hidden where they are together.
const between = new THREE.Vector3();
function lay(node, from, to, thick) {
  between.subVectors(to, from);
  const length = between.length();
  node.visible = Number.isFinite(length) && length > 1e-9;
  if (!node.visible) return;
  node.position.copy(from);
  node.quaternion.setFromUnitVectors(Z, between.divideScalar(length));
  node.scale.set(thick / 2, thick / 2, length);
}

export class Grip {
  // `hand` is null where the page may not take the device, as in a recorded run.
  constructor(stage, holder, shape, hand) {
    this.stage = stage;
    this.hand = hand;
    const { values } = shape;
    [this.r, this.A, this.read] = [values.r, values.A, values.position].map(reader);
    this.force = values.force ? reader(values.force) : null;
    this.aim = values.aim ? reader(values.aim) : null;
    this.strongest = 0;
    this.object = new THREE.Group();
    this.object.renderOrder = 10;
    this.tether = rod(COLOURS.grip);
    this.behind = rod(COLOURS.aim, 0.8);
    this.shaft = rod(COLOURS.force);
    this.head = new THREE.Mesh(
      new THREE.ConeGeometry(1, 1, 20).rotateX(Math.PI / 2).translate(0, 0, 0.5),
      new THREE.MeshBasicMaterial({ color: COLOURS.force, ...above }),
    );
    this.ring = sprite(ring);
    this.knob = sprite(knob);
    this.object.add(this.behind, this.ring, this.tether, this.shaft, this.head, this.knob);
    this.object.children.forEach((node, k) => (node.renderOrder = 10 + k));
    stage.scene.add(this.object);
    this.label = el("div", { class: "glass force", hidden: true, title: "Force on the hand" });
    holder.append(this.label);
    this.place = new THREE.Vector3();
    this.axes = new THREE.Matrix3();
    if (hand) this.listen(holder);
  }

  // World length of a pixel at a point.
  pixel(point) {
    const { camera, size } = this.stage;
    const depth = between.copy(point).sub(camera.position).dot(camera.getWorldDirection(ahead));
    return (2 * Math.tan((camera.fov * Math.PI) / 360) * Math.max(depth, 1e-6)) / (size?.height ?? 1);
  }

  update(row) {
    const r = this.r(row);
    this.object.visible = [...r].every(Number.isFinite);
    if (!this.object.visible) {
      this.label.hidden = true;
      return;
    }
    this.place.fromArray(r);
    this.axes.set(...this.A(row));
    const px = this.pixel(this.place);
    this.px = px;
    this.seen = [...this.read(row)];
    const position = this.hand?.taken ? this.hand.position : this.seen;
    const reach = this.hand?.device.reach ?? Math.max(0.06, ...position.map(Math.abs));
    this.metre = (LEVER * px) / reach; // world metres for each metre of the hand
    const at = this.world(position, this.metre);
    this.knob.position.copy(at);
    this.knob.scale.setScalar((this.hot || this.hand?.by ? 1.2 : 1) * KNOB * px);
    lay(this.tether, this.place, at, 3 * px);
    this.showAim(row, px);
    this.showForce(row, at, px);
  }

  // A vector in the axes of the device as a point from the place, or from another one, times a scale.
  world(vector, scale, from = this.place) {
    return new THREE.Vector3(...vector).applyMatrix3(this.axes).multiplyScalar(scale).add(from);
  }

  showAim(row, px) {
    this.ring.visible = Boolean(this.aim);
    this.behind.visible = false;
    if (!this.aim) return;
    const at = this.world(this.aim(row), 1);
    this.ring.position.copy(at);
    this.ring.scale.setScalar(RING * px);
    if (at.distanceTo(this.place) > 6 * px) lay(this.behind, this.place, at, 2 * px);
  }

  // The force on the hand begins at the grip: forces of the machine, which may have arrows too, begin at its place.
  showForce(row, grip, px) {
    const force = this.force ? [...this.force(row)] : [0, 0, 0];
    const size = Math.hypot(...force);
    if (Number.isFinite(size)) this.strongest = Math.max(this.strongest, size);
    const length = size > 1e-3 * this.strongest ? (ARROW * px * size) / this.strongest : 0;
    this.size = size;
    this.shaft.visible = this.head.visible = length > 6 * px;
    this.label.hidden = !this.shaft.visible;
    if (!this.shaft.visible) return;
    const end = this.world(force, length / size, grip);
    const head = Math.min(0.5 * length, 15 * px);
    const neck = end.clone().lerp(grip, head / length);
    lay(this.shaft, grip, neck, 5 * px);
    this.head.position.copy(neck);
    this.head.quaternion.copy(this.shaft.quaternion);
    this.head.scale.set(7 * px, 7 * px, head);
    const { x, y } = this.onScreen(end);
    const at = `translate(${Math.round(x + 10)}px, ${Math.round(y - 10)}px)`;
    const text = `${number(size, 3)} N`;
    if (at !== this.label.style.transform) this.label.style.transform = at;
    if (text !== this.label.textContent) this.label.textContent = text;
  }

  onScreen(point) {
    const { size, camera } = this.stage;
    const p = point.clone().project(camera);
    return { x: ((p.x + 1) / 2) * size.width, y: ((1 - p.y) / 2) * size.height };
  }

  // --- dragging -------------------------------------------------------------------------------

  isNear(event) {
    if (!this.object.visible || !this.stage.row) return false;
    const box = this.stage.canvas.getBoundingClientRect();
    const { x, y } = this.onScreen(this.knob.position);
    const near = NEAR[event.pointerType] ?? NEAR.mouse;
    return Math.hypot(event.clientX - box.left - x, event.clientY - box.top - y) < near;
  }

  // Listens before the camera does: what is dragged here does not turn it.
  listen(holder) {
    const { canvas } = this.stage;
    let from = null;
    const stop = (event) => {
      event.preventDefault();
      event.stopPropagation();
    };
    holder.addEventListener("pointerdown", (event) => {
      if (event.target !== canvas || event.button !== 0 || !this.isNear(event)) return;
      stop(event);
      canvas.setPointerCapture(event.pointerId);
      this.hand.grab(this.seen);
      from = { id: event.pointerId, x: event.clientX, y: event.clientY, position: [...this.hand.position] };
    }, true);
    holder.addEventListener("pointermove", (event) => {
      if (from?.id === event.pointerId) {
        stop(event);
        this.hand.move(this.dragged(from, event));
      } else if (!event.buttons) {
        this.hot = event.target === canvas && this.isNear(event);
        canvas.style.cursor = this.hot ? "grab" : "";
      }
    }, true);
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      holder.addEventListener(end, (event) => {
        if (from?.id !== event.pointerId) return;
        if (end !== "lostpointercapture") stop(event);
        from = null;
        this.hand.release();
      }, true);
    }
  }

  // The position of the hand after a drag on the screen: along it, or with Shift over the ground.
  dragged(from, event) {
    const { camera } = this.stage;
    const [right, up, back] = [0, 1, 2].map((k) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, k));
    if (event.shiftKey) {
      up.copy(back.negate().setZ(0).lengthSq() > 1e-6 ? back.normalize() : up);
      right.setZ(0).normalize();
    }
    const moved = right.multiplyScalar(event.clientX - from.x).addScaledVector(up, from.y - event.clientY);
    const inverse = this.axes.clone().transpose();
    const by = moved.multiplyScalar(this.px / this.metre).applyMatrix3(inverse);
    return from.position.map((x, k) => x + by.getComponent(k));
  }
}
