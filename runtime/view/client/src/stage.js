// The 3D view: sky, light, ground or sea, camera, and the parts of the model.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { RoomEnvironment } from "three/examples/jsm/environments/RoomEnvironment.js";
import { reader } from "./objects.js";
import { part } from "./parts.js";
import { Sea } from "./sea.js";

const SUN = new THREE.Vector3(0.48, -0.62, 0.62).normalize();
const THEMES = {
  light: {
    zenith: "#4e8fd6", horizon: "#dfeaf3", ground: "#d5dde3", lines: "#7f8f9d",
    deep: "#0c3c5e", shallow: "#2f7f9e", glint: "#fff4dc", sun: 2.6, sky: 0.85, exposure: 0.95,
  },
  dark: {
    zenith: "#0a1220", horizon: "#46607a", ground: "#1a222c", lines: "#52657a",
    deep: "#0a2436", shallow: "#1d5a76", glint: "#cfe2ff", sun: 1.9, sky: 0.5, exposure: 1.0,
  },
};
export const PRESETS = {
  overview: [0.82, -1.1, 0.31],
  front: [1, -0.0001, 0.12],
  side: [0.0001, -1, 0.12],
  above: [0.0001, -0.02, 1],
};

const HULL = 0.24; // of the way from a machine to the ends of its hull that an overview shows
const MARGIN = 0.84; // of the picture that parts take at most

// The distance from a centre at which the corners of a box are in the picture.
function distanceTo(box, centre, direction, camera) {
  const high = MARGIN * Math.tan((camera.fov * Math.PI) / 360);
  const right = new THREE.Vector3(0, 0, 1).cross(direction).normalize();
  const up = new THREE.Vector3().crossVectors(direction, right);
  const corner = new THREE.Vector3();
  let distance = 0;
  for (let k = 0; k < 8; k++) {
    corner.set(...["x", "y", "z"].map((axis, bit) => (k & (1 << bit) ? box.max : box.min)[axis])).sub(centre);
    const across = Math.max(Math.abs(corner.dot(up)), Math.abs(corner.dot(right)) / camera.aspect);
    distance = Math.max(distance, across / high + corner.dot(direction));
  }
  return distance;
}

const skyVertex = `varying vec3 d; void main() { d = position; gl_Position = projectionMatrix * mat4(mat3(viewMatrix)) * vec4(position, 1.0); gl_Position.z = gl_Position.w * 0.99999; }`;
const skyFragment = `uniform vec3 zenith, horizon, sun, glow; varying vec3 d;
void main() { vec3 n = normalize(d); float h = max(n.z, 0.0);
  vec3 c = mix(horizon, zenith, pow(h, 0.55));
  c += glow * (0.10 * pow(max(dot(n, sun), 0.0), 12.0) + 0.25 * pow(max(dot(n, sun), 0.0), 300.0));
  gl_FragColor = vec4(c, 1.0);
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}`;
const gridVertex = `varying vec3 p; void main() { vec4 w = modelMatrix * vec4(position, 1.0); p = w.xyz; gl_Position = projectionMatrix * viewMatrix * w; }`;
const gridFragment = `uniform vec3 lines, ground, horizon; uniform float cell, reach; varying vec3 p; uniform vec2 centre;
float net(float c) { vec2 q = p.xy / c; vec2 f = abs(fract(q - 0.5) - 0.5) / max(fwidth(q), vec2(1e-6)); return 1.0 - min(min(f.x, f.y), 1.0); }
void main() { float r = length(p.xy - centre) / reach; float fade = exp(-2.5 * r * r);
  vec3 c = mix(ground, lines, max(0.28 * net(cell), 0.5 * net(5.0 * cell)) * fade);
  c = mix(horizon, c, exp(-0.6 * r * r));
  gl_FragColor = vec4(c, 1.0);
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}`;

// A metal shows what is around it: without that it would be black.
function dull(surfaces) {
  for (const surface of [surfaces ?? []].flat()) surface.metalness = Math.min(surface.metalness ?? 0, 0.15);
}

// Faces of two parts that lie in one plane would be drawn in stripes of both: those of the later part go before.
// The offsets stay within some millimetres, so a few parts in turn share them.
function setApart(surfaces, k) {
  for (const surface of [surfaces ?? []].flat()) Object.assign(surface, { polygonOffset: true, polygonOffsetUnits: -4 * (k % 6) });
}

export class Stage {
  // `quality` is "low" for machines without a graphics card, "high" for pictures, else null: then the
  // drawing becomes coarser where it is slow. `lost(file, why)` is called for a mesh that is not drawn.
  constructor(holder, description, meshes, quality, lost) {
    this.holder = holder;
    this.lost = lost;
    this.fine = quality === "high";
    const low = quality === "low";
    this.unit = 1; // a length that suits the scene: the radius of its bounds
    this.largest = 0;
    this.renderer = new THREE.WebGLRenderer({ antialias: !low, powerPreference: "high-performance" });
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.renderer.shadowMap.enabled = !low;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.canvas = this.renderer.domElement;
    holder.prepend(this.canvas);
    this.scene = new THREE.Scene();
    if (!low) {
      const maker = new THREE.PMREMGenerator(this.renderer);
      this.scene.environment = maker.fromScene(new RoomEnvironment(), 0.04).texture;
      this.scene.environmentRotation.x = Math.PI / 2; // z is up
      maker.dispose();
    }
    this.camera = new THREE.PerspectiveCamera(38, 1, 0.1, 10_000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.controls.dampingFactor = 0.12;
    this.controls.maxPolarAngle = 0.53 * Math.PI;
    this.controls.addEventListener("start", () => (this.touched = true));
    this.lights();
    this.taken = [new THREE.Box3(), new THREE.Box3()]; // by a recorded run: by all parts, by the machine
    this.parts = description.shapes
      .map((shape) => ({ shape, drawn: part(shape, this, meshes) }))
      .filter(({ drawn }) => drawn);
    for (const [k, { shape, drawn }] of this.parts.entries()) {
      drawn.object.traverse((node) => {
        node.userData.shape = shape;
        setApart(node.material, k);
        if (low) dull(node.material);
      });
      this.scene.add(drawn.object);
    }
    // A scene has one sea: that with waves goes before a calm one.
    const seas = description.shapes.filter((shape) => shape.kind === "sea");
    const sea = seas.find((shape) => shape.values.waves) ?? seas[0];
    if (sea) {
      this.sea = new Sea(reader(sea.values.waves), low);
      this.sea.uniforms.sun.value.copy(SUN);
      this.scene.add(this.sea.object);
    } else {
      this.floor();
    }
    this.pointer = new THREE.Raycaster();
    this.slow = 0;
    if (low) this.ease(4);
    new ResizeObserver(() => this.resize()).observe(holder);
    this.resize();
  }

  lights() {
    this.hemisphere = new THREE.HemisphereLight(0xffffff, 0x445566, 0.6);
    this.sun = new THREE.DirectionalLight(0xfff3e0, 2.5);
    this.sun.castShadow = this.renderer.shadowMap.enabled;
    this.sun.shadow.mapSize.setScalar(this.fine ? 4096 : 2048);
    this.sun.shadow.bias = -0.0004;
    this.scene.add(this.hemisphere, this.sun, this.sun.target);
    const uniforms = { zenith: {}, horizon: {}, glow: {}, sun: { value: SUN } };
    for (const name of ["zenith", "horizon", "glow"]) uniforms[name].value = new THREE.Color();
    this.sky = new THREE.Mesh(
      new THREE.SphereGeometry(1, 32, 24),
      new THREE.ShaderMaterial({
        uniforms, vertexShader: skyVertex, fragmentShader: skyFragment,
        side: THREE.BackSide, depthWrite: false,
      }),
    );
    this.sky.frustumCulled = false;
    this.sky.renderOrder = -1;
    this.scene.add(this.sky);
  }

  floor() {
    const uniforms = { cell: { value: 1 }, reach: { value: 30 }, centre: { value: new THREE.Vector2() } };
    for (const name of ["lines", "ground", "horizon"]) uniforms[name] = { value: new THREE.Color() };
    this.ground = new THREE.Mesh(
      new THREE.PlaneGeometry(1, 1),
      new THREE.ShaderMaterial({ uniforms, vertexShader: gridVertex, fragmentShader: gridFragment }),
    );
    this.shade = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), new THREE.ShadowMaterial({ opacity: 0.3 }));
    this.shade.receiveShadow = true;
    this.scene.add(this.ground, this.shade);
  }

  theme(name) {
    const t = THEMES[name];
    const colour = (target, text) => target.value.set(text);
    colour(this.sky.material.uniforms.zenith, t.zenith);
    colour(this.sky.material.uniforms.horizon, t.horizon);
    colour(this.sky.material.uniforms.glow, t.glint);
    this.hemisphere.color.set(t.horizon);
    this.hemisphere.intensity = (this.scene.environment ? 1 : 2.4) * t.sky;
    this.sun.intensity = t.sun;
    this.scene.environmentIntensity = 0.7 * t.sky;
    this.renderer.toneMappingExposure = t.exposure;
    if (this.sea) {
      for (const key of ["deep", "shallow", "horizon", "zenith", "glint"]) {
        colour(this.sea.uniforms[key], t[key]);
      }
    } else {
      for (const key of ["lines", "ground", "horizon"]) colour(this.ground.material.uniforms[key], t[key]);
    }
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (!width || !height) return;
    this.size = { width, height }; // reading it each frame would lay out the page each time
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, [2, 2, 1, 0.75][this.slow] ?? 0.5));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.touched && this.bounds) this.look(this.preset ?? "overview");
    if (this.row) this.draw(); // a canvas of another size is empty until it is drawn
  }

  // Takes a row of the model's columns at a time.
  show(row, time) {
    this.time = time;
    for (const { drawn } of this.parts) drawn.update(row, this.camera);
    this.row = row;
    if (!this.bounds && this.parts.length) {
      this.measure();
      this.look("overview");
    }
  }

  refit() {
    this.bounds = null;
  }

  // Measures the space that a recorded run takes by some of its rows, so that no part leaves the picture.
  survey(rows) {
    for (const row of rows) {
      this.show(row, 0);
      this.scene.updateMatrixWorld(true);
      for (const machine of [false, true]) this.taken[Number(machine)].union(this.box(machine));
    }
    this.look("overview");
  }

  // The box around the present parts; without the parts that have a hull, if there is a machine beside them.
  box(machine = false) {
    const hulls = new Set(machine ? this.parts.filter(({ shape }) => shape.kind === "hull").map(({ shape }) => shape.part) : []);
    const box = new THREE.Box3();
    for (const { shape, drawn } of this.parts) {
      if (shape.kind !== "arrow" && !hulls.has(shape.part)) box.expandByObject(drawn.object);
    }
    return box;
  }

  measure() {
    this.scene.updateMatrixWorld(true);
    const bounds = this.box().union(this.taken[0]);
    if (bounds.isEmpty()) return;
    this.bounds = bounds;
    const sphere = bounds.getBoundingSphere(new THREE.Sphere());
    this.unit = Math.max(sphere.radius, 1e-3);
    this.camera.near = 0.01 * this.unit;
    this.camera.far = Math.max(300 * this.unit, this.sea ? 9000 : 0);
    this.controls.minDistance = 0.1 * this.unit;
    this.controls.maxDistance = 20 * this.unit;
    const { shadow } = this.sun;
    const reach = 1.35 * this.unit;
    Object.assign(shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.1 * reach, far: 6 * reach });
    // Two texels: enough against stripes on surfaces that the sun grazes.
    shadow.normalBias = (4 * reach) / shadow.mapSize.x;
    shadow.camera.updateProjectionMatrix();
    if (this.ground) {
      const low = Math.min(0, bounds.min.z);
      this.cell = 10 ** Math.floor(Math.log10(0.35 * this.unit));
      this.ground.scale.set(120 * this.unit, 120 * this.unit, 1);
      this.shade.scale.copy(this.ground.scale);
      this.ground.position.set(sphere.center.x, sphere.center.y, low - 0.002 * this.unit);
      this.shade.position.copy(this.ground.position).setZ(low - 0.001 * this.unit);
      const { uniforms } = this.ground.material;
      uniforms.cell.value = this.cell;
      uniforms.reach.value = 9 * this.unit;
      uniforms.centre.value.set(sphere.center.x, sphere.center.y);
    }
  }

  // The box that an overview shows: all parts, but of a hull under a smaller machine only what is near.
  framed() {
    const machine = this.box(true).union(this.taken[1]);
    if (machine.isEmpty() || machine.equals(this.bounds)) return this.bounds;
    machine.min.lerp(this.bounds.min, HULL);
    machine.max.lerp(this.bounds.max, HULL);
    return machine;
  }

  // Looks at the whole model from a preset direction.
  look(name) {
    if (!this.bounds) return;
    this.preset = name;
    this.follow = null;
    this.measure();
    const box = this.framed();
    const direction = new THREE.Vector3(...PRESETS[name]).normalize();
    // A ship is seen from astern, over the deck where cranes stand.
    const afloat = this.parts.some(({ shape }) => shape.kind === "hull");
    if (name === "overview" && afloat) direction.x *= -1;
    const centre = box.getCenter(new THREE.Vector3());
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(direction, distanceTo(box, centre, direction, this.camera));
    this.controls.update();
  }

  // Turns the camera around what it shows, by angles, and moves it nearer or farther.
  turn(around, up, distance = 1) {
    this.touched = true;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const radius = offset.length() * distance;
    const azimuth = Math.atan2(offset.y, offset.x) + around;
    const lowest = Math.PI / 2 - this.controls.maxPolarAngle;
    const elevation = Math.min(1.56, Math.max(lowest, Math.asin(offset.z / offset.length()) + up));
    offset.set(Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation));
    this.camera.position.copy(this.controls.target).addScaledVector(offset, radius);
    this.controls.update();
  }

  // Keeps the camera with a part, or stops doing so.
  followPart(path) {
    const found = this.parts.find(({ shape }) => shape.part === path);
    this.follow = found && this.follow !== found ? found : null;
    this.anchor = null;
    return this.follow !== null;
  }

  arrowScale(size) {
    this.largest = Math.max(this.largest, Number.isFinite(size) ? size : 0);
    return this.largest > 0 ? (0.13 * this.unit) / this.largest : 0;
  }

  // The part under a point of the window, as its shape; null where there is none.
  pick(x, y) {
    const place = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(
      (2 * (x - place.left)) / place.width - 1,
      1 - (2 * (y - place.top)) / place.height,
    );
    this.pointer.setFromCamera(at, this.camera);
    const objects = this.parts.filter(({ drawn }) => drawn.object.visible).map(({ drawn }) => drawn.object);
    const [hit] = this.pointer.intersectObjects(objects, true);
    return hit ? hit.object.userData.shape : null;
  }

  mark(path) {
    for (const { shape, drawn } of this.parts) {
      drawn.object.traverse((node) => {
        for (const surface of [node.material].flat()) {
          surface?.emissive?.set(path && shape.part === path ? "#1f5fa8" : "#000000");
        }
      });
    }
  }

  draw() {
    if (this.follow) {
      const at = new THREE.Box3().setFromObject(this.follow.drawn.object).getCenter(new THREE.Vector3());
      if (this.anchor) {
        const moved = at.clone().sub(this.anchor);
        this.controls.target.add(moved);
        this.camera.position.add(moved);
      } else this.controls.target.copy(at);
      this.anchor = at;
    }
    this.controls.update();
    if (this.sea && this.row) this.sea.update(this.row, this.time, this.controls.target);
    if (this.bounds) {
      const middle = this.bounds.getCenter(new THREE.Vector3());
      this.sun.target.position.copy(middle);
      this.sun.position.copy(middle).addScaledVector(SUN, 3 * this.unit);
    }
    this.renderer.render(this.scene, this.camera);
  }

  // Draws less finely on a machine that cannot keep up: fewer pixels, no shadows, a smoother sea.
  ease(steps = 1) {
    if (this.slow >= 4 || this.fine) return;
    this.slow = Math.min(4, this.slow + steps);
    if (this.sea) this.sea.uniforms.detail.value = 0;
    if (this.slow >= 2) {
      this.renderer.shadowMap.enabled = false;
      this.sun.castShadow = false;
      this.scene.traverse((node) => [node.material].flat().forEach((m) => m && (m.needsUpdate = true)));
    }
    this.resize();
  }

  picture() {
    this.draw();
    return new Promise((done, failed) => {
      this.canvas.toBlob((blob) => (blob ? done(blob) : failed(new Error("the browser has no memory for it"))), "image/png");
    });
  }
}
