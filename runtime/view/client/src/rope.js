// A rope as a tube along its curve.

import * as THREE from "three";
import { ends, line, material, mesh, reader, Z } from "./objects.js";

const SEGMENTS = 28;
const AROUND = 8;

// A rope: straight where it is taut, a catenary where its own length exceeds the distance.
export class Rope {
  constructor(shape) {
    this.ends = [reader(shape.values.from), reader(shape.values.to)];
    this.radius = reader(shape.values.radius);
    this.own = shape.values.paid ? reader(shape.values.paid) : null;
    const geometry = new THREE.BufferGeometry();
    const count = (SEGMENTS + 1) * (AROUND + 1);
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    const index = [];
    for (let i = 0; i < SEGMENTS; i++) {
      for (let j = 0; j < AROUND; j++) {
        const a = i * (AROUND + 1) + j;
        index.push(a, a + 1, a + AROUND + 1, a + 1, a + AROUND + 2, a + AROUND + 1);
      }
    }
    geometry.setIndex(index);
    this.object = mesh(geometry, material(shape.colour || "#2b3036", { roughness: 0.8 }));
    this.object.frustumCulled = false;
    this.points = Array.from({ length: SEGMENTS + 1 }, () => new THREE.Vector3());
  }

  update(row, camera) {
    const distance = line(row, this.ends);
    this.object.visible = Number.isFinite(distance);
    if (!this.object.visible) return;
    const own = this.own ? this.own(row)[0] : 0;
    if (own > distance * (1 + 1e-6)) catenary(this.points, ends[0], ends[1], own);
    else this.points.forEach((p, i) => p.lerpVectors(ends[0], ends[1], i / SEGMENTS));
    this.tube(this.radius(row)[0], camera);
  }

  tube(radius, camera) {
    const { position, normal } = this.object.geometry.attributes;
    const [tangent, side, up] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    this.points.forEach((point, i) => {
      tangent.subVectors(this.points[Math.min(i + 1, SEGMENTS)], this.points[Math.max(i - 1, 0)]);
      if (tangent.lengthSq() === 0) tangent.copy(Z);
      side.set(1, 0, 0).cross(tangent);
      if (side.lengthSq() < 1e-6 * tangent.lengthSq()) side.set(0, 1, 0).cross(tangent);
      side.normalize();
      up.crossVectors(tangent.normalize(), side);
      // At least about a pixel and a half wide, so that a rope is never lost from sight.
      const seen = Math.max(radius, 0.0011 * camera.position.distanceTo(point));
      for (let j = 0; j <= AROUND; j++) {
        const angle = (2 * Math.PI * j) / AROUND;
        const [c, s] = [Math.cos(angle), Math.sin(angle)];
        const k = i * (AROUND + 1) + j;
        const n = [0, 1, 2].map((a) => c * side.getComponent(a) + s * up.getComponent(a));
        normal.setXYZ(k, ...n);
        position.setXYZ(k, point.x + seen * n[0], point.y + seen * n[1], point.z + seen * n[2]);
      }
    });
    position.needsUpdate = normal.needsUpdate = true;
    // Those are of the curve before; they are computed when asked for.
    this.object.geometry.boundingBox = this.object.geometry.boundingSphere = null;
  }
}

// Points of the catenary of a given length between two points; z is up.
function catenary(points, from, to, length) {
  const flat = new THREE.Vector2(to.x - from.x, to.y - from.y);
  const [span, rise] = [flat.length(), to.z - from.z];
  const n = points.length - 1;
  if (span < 1e-3 * length) {
    // Nearly vertical: down to the lowest point, and up again.
    const down = (length - rise) / 2;
    points.forEach((p, i) => {
      const s = (i / n) * length;
      const z = s < down ? -s : s - 2 * down;
      p.set(from.x + (flat.x * i) / n, from.y + (flat.y * i) / n, from.z + z);
    });
    return;
  }
  // sqrt(L^2 - rise^2) = 2 a sinh(span / (2 a)), by bisection in u = span / (2 a).
  const ratio = Math.sqrt(Math.max(length ** 2 - rise ** 2, 0)) / span;
  let [low, high] = [1e-6, 1];
  while (Math.sinh(high) / high < ratio && high < 500) high *= 2;
  for (let k = 0; k < 60; k++) {
    const middle = (low + high) / 2;
    if (Math.sinh(middle) / middle < ratio) low = middle;
    else high = middle;
  }
  const a = span / (low + high);
  const lowest = span / 2 - a * Math.atanh(Math.max(-1 + 1e-12, Math.min(1 - 1e-12, rise / length)));
  points.forEach((p, i) => {
    const x = (i / n) * span;
    const z = a * (Math.cosh((x - lowest) / a) - Math.cosh(lowest / a));
    p.set(from.x + (flat.x * i) / n, from.y + (flat.y * i) / n, from.z + z);
  });
}
