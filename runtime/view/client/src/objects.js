// What the objects of all shapes share: their quantities, surfaces, places and ends.

import * as THREE from "three";

export const DEFAULT = "#7d93a8";
export const Z = new THREE.Vector3(0, 0, 1);
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

export function mesh(geometry, surface) {
  const object = new THREE.Mesh(geometry, surface);
  object.castShadow = object.receiveShadow = true;
  return object;
}

// Places an object by a position and a rotation matrix, row by row.
export function place(object, r, A) {
  object.matrixAutoUpdate = false;
  object.matrix.set(
    A[0], A[1], A[2], r[0],
    A[3], A[4], A[5], r[1],
    A[6], A[7], A[8], r[2],
    0, 0, 0, 1,
  );
  object.matrixWorldNeedsUpdate = true;
}

export function differs(a, b) {
  return !b || a.some((x, k) => Math.abs(x - b[k]) > 1e-5 * Math.max(Math.abs(x), 1e-6));
}

export function replace(object, geometry) {
  if (!geometry) return;
  object.geometry.dispose();
  object.geometry = geometry;
}

// The ends of the shape that `line` was called for last, and the way from one to the other; it returns the length.
export const ends = [new THREE.Vector3(), new THREE.Vector3()];
export const along = new THREE.Vector3();
export function line(row, read) {
  ends.forEach((end, k) => end.fromArray(read[k](row)));
  along.subVectors(ends[1], ends[0]);
  return along.length();
}
