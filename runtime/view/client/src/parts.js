// Shapes of a model as objects of three.js. Each has `update(row)`, and is redrawn from its columns.

import * as THREE from "three";
import { RoundedBoxGeometry } from "three/examples/jsm/geometries/RoundedBoxGeometry.js";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";

const DEFAULT = "#7d93a8";
const Z = new THREE.Vector3(0, 0, 1);
const METALS = new Set(["#6b7b8c", "#b8bec4"]);

// A quantity of a shape as a function of a row: a flat list of numbers.
export function reader(value) {
  if (!value) return () => [];
  if (value.numbers) return () => value.numbers;
  const list = new Float64Array(value.columns.length);
  return (row) => {
    for (let k = 0; k < list.length; k++) list[k] = row[value.columns[k]];
    return list;
  };
}

export function material(colour, extra = {}) {
  const metal = METALS.has(colour);
  return new THREE.MeshStandardMaterial({
    color: new THREE.Color(colour || DEFAULT),
    metalness: metal ? 0.65 : 0.1,
    roughness: metal ? 0.38 : 0.52,
    ...extra,
  });
}

function mesh(geometry, surface) {
  const object = new THREE.Mesh(geometry, surface);
  object.castShadow = object.receiveShadow = true;
  return object;
}

// Places an object by a position and a rotation matrix, row by row.
function place(object, r, A) {
  object.matrixAutoUpdate = false;
  object.matrix.set(
    A[0], A[1], A[2], r[0],
    A[3], A[4], A[5], r[1],
    A[6], A[7], A[8], r[2],
    0, 0, 0, 1,
  );
  object.matrixWorldNeedsUpdate = true;
}

function differs(a, b) {
  return !b || a.some((x, k) => Math.abs(x - b[k]) > 1e-5 * Math.max(Math.abs(x), 1e-6));
}

// A part whose geometry depends on sizes, made again when these change.
class Sized {
  constructor(shape, names, make) {
    this.read = names.map((name) => reader(shape.values[name]));
    this.make = make;
    this.sizes = null;
  }

  geometry(row) {
    const sizes = this.read.map((read) => read(row)[0]);
    if (!differs(sizes, this.sizes) || !sizes.every((s) => Number.isFinite(s) && s > 0)) return null;
    this.sizes = sizes;
    return this.make(...sizes);
  }
}

function box(length, width, height) {
  const radius = 0.045 * Math.min(length, width, height);
  return new RoundedBoxGeometry(length, width, height, 3, radius);
}

function cylinder(radius, length) {
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

function capsule(radius, length) {
  return new THREE.CapsuleGeometry(radius, length, 10, 28).rotateX(Math.PI / 2);
}

// Shares of the hull's height, breadth and length; the bulwark rises over some of its first stations.
const BULWARK = { height: 0.1, thickness: 0.02, begins: 0.12, rise: 4 };

// A ship's hull: bow along x, its deck at the top, a transom stern, and a bulwark around the deck that is open
// astern. The deck is a group of its own.
function hull(length, breadth, height) {
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

const SOLIDS = {
  box: [["length", "width", "height"], box],
  cylinder: [["radius", "length"], cylinder],
  capsule: [["radius", "length"], capsule],
  sphere: [["radius"], (radius) => new THREE.SphereGeometry(radius, 48, 32)],
  hull: [["length", "width", "height"], hull],
};

class Solid {
  constructor(shape) {
    this.sized = new Sized(shape, ...SOLIDS[shape.kind]);
    const surface = material(shape.colour);
    const deck = new THREE.Color(shape.colour || DEFAULT).lerp(new THREE.Color("#8d9a94"), 0.8);
    const surfaces = [surface, material(`#${deck.getHexString()}`, { roughness: 0.85 })];
    this.object = mesh(new THREE.BufferGeometry(), shape.kind === "hull" ? surfaces : surface);
    [this.r, this.A] = [reader(shape.values.r), reader(shape.values.A)];
  }

  update(row) {
    replace(this.object, this.sized.geometry(row));
    place(this.object, this.r(row), this.A(row));
  }
}

function replace(object, geometry) {
  if (!geometry) return;
  object.geometry.dispose();
  object.geometry = geometry;
}

// Along a line from `from` to `to`: the middle, and the rotation that turns z into it.
const ends = [new THREE.Vector3(), new THREE.Vector3()];
const along = new THREE.Vector3();
function line(row, read) {
  ends.forEach((end, k) => end.fromArray(read[k](row)));
  along.subVectors(ends[1], ends[0]);
  return along.length();
}

class Between {
  constructor(shape) {
    this.capsule = shape.kind === "capsule";
    this.ends = [reader(shape.values.from), reader(shape.values.to)];
    this.radius = reader(shape.values.radius);
    this.sizes = null;
    this.object = mesh(new THREE.BufferGeometry(), material(shape.colour));
  }

  update(row) {
    const length = line(row, this.ends);
    const sizes = [this.radius(row)[0], length];
    this.object.visible = length > 0 && sizes[0] > 0;
    if (!this.object.visible) return;
    if (differs(sizes, this.sizes)) {
      this.sizes = sizes;
      replace(this.object, this.capsule ? capsule(...sizes) : cylinder(...sizes));
    }
    this.object.position.addVectors(ends[0], ends[1]).multiplyScalar(0.5);
    this.object.quaternion.setFromUnitVectors(Z, along.normalize());
  }
}

// A hydraulic cylinder: its barrel at `from`, its rod up to `to`.
class Ram {
  constructor(shape) {
    this.ends = [reader(shape.values.from), reader(shape.values.to)];
    this.sized = new Sized(shape, ["radius", "barrel"], (radius, barrel) => [radius, barrel]);
    const eye = (radius) => new THREE.SphereGeometry(radius, 24, 16);
    this.make = (radius, length) => {
      this.object.clear();
      this.barrel = mesh(cylinder(radius, length).translate(0, 0, length / 2), material(shape.colour || "#3a4652"));
      const gland = mesh(cylinder(1.12 * radius, 0.5 * radius).translate(0, 0, length), material("#6b7b8c"));
      this.rod = mesh(
        new THREE.CylinderGeometry(0.55 * radius, 0.55 * radius, 1, 32).rotateX(Math.PI / 2).translate(0, 0, 0.5),
        material("#d8dde2", { metalness: 0.85, roughness: 0.18 }),
      );
      this.foot = mesh(eye(0.95 * radius), material("#6b7b8c"));
      this.head = mesh(eye(0.8 * radius), material("#6b7b8c"));
      this.object.add(this.barrel, gland, this.rod, this.foot, this.head);
    };
    this.object = new THREE.Group();
  }

  update(row) {
    const sizes = this.sized.geometry(row);
    if (sizes) this.make(...sizes);
    const length = line(row, this.ends);
    this.object.visible = length > 0 && Boolean(this.rod);
    if (!this.object.visible) return;
    this.object.position.copy(ends[0]);
    this.object.quaternion.setFromUnitVectors(Z, along.normalize());
    this.rod.scale.z = length;
    this.head.position.z = length;
  }
}

const SEGMENTS = 28;
const AROUND = 8;

// A rope: straight where it is taut, a catenary where its own length exceeds the distance.
class Rope {
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
export function catenary(points, from, to, length) {
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

// Vectors at a frame. Those without a scale of their own share one, by the largest seen so far.
class Arrow {
  constructor(shape, stage) {
    this.stage = stage;
    [this.r, this.A] = [reader(shape.values.r), reader(shape.values.A)];
    this.vector = reader(shape.values.vector);
    this.scale = shape.values.scale ? reader(shape.values.scale) : null;
    const surface = material(shape.colour || "#d43d3d", { roughness: 0.4 });
    this.shaft = mesh(new THREE.CylinderGeometry(1, 1, 1, 20).rotateX(Math.PI / 2).translate(0, 0, 0.5), surface);
    this.head = mesh(new THREE.ConeGeometry(1, 1, 24).rotateX(Math.PI / 2).translate(0, 0, 0.5), surface);
    this.object = new THREE.Group();
    this.object.add(this.shaft, this.head);
  }

  update(row) {
    const [v, A, r] = [this.vector(row), this.A(row), this.r(row)];
    const world = along.set(
      A[0] * v[0] + A[1] * v[1] + A[2] * v[2],
      A[3] * v[0] + A[4] * v[1] + A[5] * v[2],
      A[6] * v[0] + A[7] * v[1] + A[8] * v[2],
    );
    const size = world.length();
    const scale = this.scale ? this.scale(row)[0] : this.stage.arrowScale(size);
    const length = size * scale;
    const unit = this.stage.unit;
    this.object.visible = Number.isFinite(length) && length > 0.004 * unit;
    if (!this.object.visible) return;
    const thick = 0.0045 * unit;
    const head = Math.min(0.45 * length, 7 * thick);
    this.object.position.set(r[0], r[1], r[2]);
    this.object.quaternion.setFromUnitVectors(Z, world.divideScalar(size));
    this.shaft.scale.set(thick, thick, length - head);
    this.head.scale.set(2.6 * thick, 2.6 * thick, head);
    this.head.position.z = length - head;
  }
}

class FromFile {
  constructor(shape, stage, address) {
    [this.r, this.A] = [reader(shape.values.r), reader(shape.values.A)];
    this.scale = reader(shape.values.scale);
    this.object = new THREE.Group();
    this.load(shape, address).then((loaded) => {
      this.inner = loaded;
      this.object.add(loaded);
      stage.refit();
    });
  }

  async load(shape, address) {
    const data = await (await fetch(address)).arrayBuffer();
    const ending = shape.file.split(".").pop().toLowerCase();
    const surface = material(shape.colour);
    if (ending === "stl") return mesh(new STLLoader().parse(data), surface);
    const scene =
      ending === "obj"
        ? new OBJLoader().parse(new TextDecoder().decode(data))
        : (await new GLTFLoader().parseAsync(data, "")).scene;
    scene.traverse((node) => {
      if (!node.isMesh) return;
      node.castShadow = node.receiveShadow = true;
      if (shape.colour || ending === "obj") node.material = surface;
    });
    return scene;
  }

  update(row) {
    place(this.object, this.r(row), this.A(row));
    if (this.inner) this.inner.scale.setScalar(this.scale(row)[0]);
  }
}

// The object of a shape; null for one that is not drawn in the scene (`sea`, `handle`, a lost file).
export function part(shape, stage, meshes) {
  if (shape.kind === "mesh") {
    return shape.mesh == null ? null : new FromFile(shape, stage, meshes(shape.mesh));
  }
  if (shape.kind === "rope") return new Rope(shape);
  if (shape.kind === "ram") return new Ram(shape);
  if (shape.kind === "arrow") return new Arrow(shape, stage);
  if (shape.values.from && SOLIDS[shape.kind]) return new Between(shape);
  return SOLIDS[shape.kind] ? new Solid(shape) : null;
}
