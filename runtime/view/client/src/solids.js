// The geometries of solids, each along its own axes around its middle.

import * as THREE from "three";
import { RoundedBoxGeometry } from "three/examples/jsm/geometries/RoundedBoxGeometry.js";

export function box(length, width, height) {
  const radius = 0.045 * Math.min(length, width, height);
  return new RoundedBoxGeometry(length, width, height, 3, radius);
}

export function cylinder(radius, length) {
  const bevel = Math.min(0.08 * radius, 0.2 * length);
  const [r, h] = [radius, length / 2];
  const smooth = new THREE.CylinderGeometry(r, r, 2 * (h - bevel), 40, 1, true);
  const caps = [h, -h].map((y) => {
    const cap = new THREE.CylinderGeometry(y > 0 ? r - bevel : r, y > 0 ? r : r - bevel, bevel, 40, 1);
    return cap.translate(0, y > 0 ? h - bevel / 2 : -h + bevel / 2, 0);
  });
  return merged([smooth, ...caps]).rotateX(Math.PI / 2);
}

function merged(list) {
  const attributes = { position: [], normal: [] };
  const index = [];
  let base = 0;
  for (const geometry of list) {
    for (const name of Object.keys(attributes)) attributes[name].push(...geometry.attributes[name].array);
    for (const k of geometry.index.array) index.push(base + k);
    base += geometry.attributes.position.count;
    geometry.dispose();
  }
  const whole = new THREE.BufferGeometry();
  for (const [name, list] of Object.entries(attributes)) {
    whole.setAttribute(name, new THREE.Float32BufferAttribute(list, 3));
  }
  whole.setIndex(index);
  return whole;
}

export function capsule(radius, length) {
  return new THREE.CapsuleGeometry(radius, length, 10, 28).rotateX(Math.PI / 2);
}

// Shares of the hull's height, breadth and length; the bulwark rises over some of its first stations.
const BULWARK = { height: 0.1, thickness: 0.02, begins: 0.12, rise: 4 };

// A ship's hull: bow along x, its deck at the top, a transom stern, and a bulwark around the deck that is open
// astern. The deck is a group of its own.
export function hull(length, breadth, height) {
  const [stations, ribs] = [48, 14];
  const [top, keel] = [height / 2, -height / 2];
  const points = [];
  for (let i = 0; i <= stations; i++) {
    const s = i / stations;
    const bow = Math.max(0, (s - 0.62) / 0.38);
    const stern = Math.max(0, (0.22 - s) / 0.22);
    const deck = (breadth / 2) * Math.sqrt(Math.max(0, 1 - bow ** 2.6)) * (1 - 0.08 * stern ** 2);
    const water = (breadth / 2) * Math.max(0, 1 - bow ** 1.35) * (1 - 0.10 * stern ** 2);
    const bottom = keel + height * (0.42 * stern ** 1.8 + 0.22 * bow ** 4);
    const rake = 0.035 * length * bow ** 2;
    const boxy = 6 - 4.2 * bow - 2 * stern;
    for (let j = 0; j <= ribs; j++) {
      const angle = (j / ribs) * (Math.PI / 2);
      const up = 1 - Math.cos(angle) ** (2 / boxy);
      const out = Math.sin(angle) ** (2 / boxy);
      const half = out * (water + (deck - water) * up ** 2);
      points.push([-length / 2 + s * 0.965 * length + rake * up, half, bottom + (top - bottom) * up]);
    }
  }
  const positions = [];
  const index = [];
  const side = (sign) => {
    const base = positions.length / 3;
    for (const [x, y, z] of points) positions.push(x, sign * y, z);
    for (let i = 0; i < stations; i++) {
      for (let j = 0; j < ribs; j++) {
        const a = base + i * (ribs + 1) + j;
        const [b, c, d] = [a + 1, a + ribs + 1, a + ribs + 2];
        if (sign > 0) index.push(a, b, c, b, d, c);
        else index.push(a, c, b, b, c, d);
      }
    }
  };
  side(1);
  side(-1);
  // The transom: the first station, closed across the centre line.
  const transom = positions.length / 3;
  for (let j = 0; j <= ribs; j++) {
    const [x, y, z] = points[j];
    positions.push(x, y, z, x, -y, z);
  }
  for (let j = 0; j < ribs; j++) {
    const a = transom + 2 * j;
    index.push(a, a + 1, a + 2, a + 1, a + 3, a + 2);
  }
  // The bulwark: its outer face, its rail and its inner face, from side to side by way of the bow.
  const edge = points
    .filter((_, k) => k % (ribs + 1) === ribs)
    .slice(Math.round(BULWARK.begins * stations))
    .map(([x, y], k) => ({ x, y, rail: top + BULWARK.height * height * Math.min(1, k / BULWARK.rise) }));
  const round = [...edge.map((p) => ({ ...p, side: 1 })), ...edge.map((p) => ({ ...p, side: -1 })).reverse()];
  const inward = (y) => Math.max(0, y - BULWARK.thickness * breadth);
  const faces = [
    ({ y, rail }) => [[y, top], [y, rail]],
    ({ y, rail }) => [[y, rail], [inward(y), rail]],
    ({ y, rail }) => [[inward(y), rail], [inward(y), top]],
  ];
  for (const face of faces) {
    const base = positions.length / 3;
    for (const p of round) for (const [y, z] of face(p)) positions.push(p.x, p.side * y, z);
    for (let i = 0; i + 1 < round.length; i++) {
      const a = base + 2 * i;
      index.push(a, a + 1, a + 2, a + 1, a + 3, a + 2);
    }
  }
  const shell = index.length;
  // The deck.
  const deck = positions.length / 3;
  for (let i = 0; i <= stations; i++) {
    const [x, y] = points[i * (ribs + 1) + ribs];
    positions.push(x, 0.985 * y, top, x, -0.985 * y, top);
  }
  for (let i = 0; i < stations; i++) {
    const a = deck + 2 * i;
    index.push(a, a + 1, a + 2, a + 1, a + 3, a + 2);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
  geometry.setIndex(index);
  geometry.addGroup(0, shell, 0);
  geometry.addGroup(shell, index.length - shell, 1);
  geometry.computeVertexNormals();
  return geometry;
}
