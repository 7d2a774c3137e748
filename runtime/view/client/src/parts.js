// Shapes of a model as objects of three.js. Each has `update(row)`, and is redrawn from its columns.

import * as THREE from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import { along, DEFAULT, differs, ends, line, material, mesh, place, reader, replace, Z } from "./objects.js";
import { Rope } from "./rope.js";
import { box, capsule, cylinder, hull } from "./solids.js";

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
    }).catch((problem) => stage.lost(shape.file, problem.message));
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
    if (shape.mesh != null) return new FromFile(shape, stage, meshes(shape.mesh));
    stage.lost(shape.file, "it does not lie beside the model");
    return null;
  }
  if (shape.kind === "rope") return new Rope(shape);
  if (shape.kind === "ram") return new Ram(shape);
  if (shape.kind === "arrow") return new Arrow(shape, stage);
  if (shape.values.from && SOLIDS[shape.kind]) return new Between(shape);
  return SOLIDS[shape.kind] ? new Solid(shape) : null;
}
