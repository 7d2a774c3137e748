// The surface of the sea: the scene's own wave components, summed on the graphics card.

import * as THREE from "three";

const MOST = 64; // components
const RINGS = 150; // of the grid, a third of it where a machine is slow
const SPOKES = 200;
const FAR = 4000; // m

const vertex = /* glsl */ `
uniform int count;
uniform vec4 waves[${MOST}]; // amplitude, wave number, direction, phase - frequency * time
uniform vec2 centre;
uniform float spacing;
varying vec3 place;
varying vec2 slope;
varying float steepness;
void main() {
  vec2 p = position.xy + centre;
  float r = length(position.xy);
  float z = 0.0;
  slope = vec2(0.0);
  float cell = max(0.25, r * spacing);
  for (int i = 0; i < ${MOST}; i++) {
    if (i >= count) break;
    vec4 w = waves[i];
    // A component that the grid cannot resolve at this distance is faded out.
    float seen = 1.0 - smoothstep(0.4, 1.2, w.y * cell);
    vec2 k = w.y * vec2(cos(w.z), sin(w.z));
    float angle = w.w - dot(k, p);
    z += seen * w.x * cos(angle);
    slope += w.x * sin(angle) * k * (1.0 - smoothstep(0.8, 2.4, w.y * cell));
  }
  place = vec3(p, z);
  gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
}`;

const fragment = /* glsl */ `
uniform vec3 sun, deep, shallow, horizon, zenith, glint;
uniform float time, haze, detail;
varying vec3 place;
varying vec2 slope;
vec2 ripple(vec2 p, float scale, float speed) {
  vec2 s = vec2(0.0);
  for (int i = 0; i < 5; i++) {
    float a = 0.7 + 1.9 * float(i);
    vec2 d = vec2(cos(a), sin(a));
    float k = scale * (1.0 + 0.37 * float(i));
    s += d * sin(dot(d, p) * k + time * speed * sqrt(k) + 2.1 * float(i)) ;
  }
  return s;
}
void main() {
  vec3 towards = cameraPosition - place;
  float distance = length(towards);
  vec3 v = towards / distance;
  float near = exp(-distance / 90.0);
  vec2 fine = vec2(0.0);
  if (detail > 0.5) {
    fine = 0.035 * near * ripple(place.xy, 1.3, 2.6)
      + 0.02 * exp(-distance / 35.0) * ripple(place.yx, 4.1, 2.2)
      + 0.022 * exp(-distance / 160.0) * ripple(place.xy + 7.0, 0.31, 2.4);
  }
  vec3 n = normalize(vec3(-slope - fine, 1.0));
  float facing = max(dot(n, v), 0.0);
  float fresnel = 0.02 + 0.98 * pow(1.0 - facing, 5.0);
  // Waves hide each other where they are seen along the surface: a rough sea is no mirror there.
  fresnel = min(fresnel, 0.62);
  vec3 r = reflect(-v, n);
  vec3 sky = mix(horizon, zenith, pow(clamp(r.z, 0.0, 1.0), 0.55));
  float lit = 0.5 + 0.5 * dot(n, sun);
  vec3 body = mix(deep, shallow, clamp(0.25 + 0.10 * place.z + 0.5 * (lit - 0.7), 0.0, 1.0));
  vec3 colour = mix(body, sky, fresnel);
  float spark = pow(max(dot(r, sun), 0.0), 220.0) * 1.4 + pow(max(dot(r, sun), 0.0), 24.0) * 0.10;
  colour += glint * spark;
  colour = mix(colour, horizon, 1.0 - exp(-pow(distance * haze, 1.6)));
  gl_FragColor = vec4(colour, 1.0);
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}`;

function grid(rings, spokes) {
  const points = [0, 0, 0];
  const growth = Math.pow(FAR / 1.5, 1 / (rings - 1));
  for (let ring = 0; ring < rings; ring++) {
    const radius = 1.5 * Math.pow(growth, ring);
    for (let spoke = 0; spoke < spokes; spoke++) {
      const angle = (2 * Math.PI * (spoke + 0.5 * (ring % 2))) / spokes;
      points.push(radius * Math.cos(angle), radius * Math.sin(angle), 0);
    }
  }
  const index = [];
  const at = (ring, spoke) => 1 + ring * spokes + (spoke % spokes);
  for (let spoke = 0; spoke < spokes; spoke++) index.push(0, at(0, spoke), at(0, spoke + 1));
  for (let ring = 0; ring + 1 < rings; ring++) {
    for (let spoke = 0; spoke < spokes; spoke++) {
      const [a, b] = [at(ring, spoke), at(ring, spoke + 1)];
      const [c, d] = [at(ring + 1, spoke), at(ring + 1, spoke + 1)];
      index.push(a, c, b, b, c, d);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  geometry.setIndex(index);
  return geometry;
}

export class Sea {
  // `waves(row)` gives rows [amplitude, angular frequency, direction, phase] as a flat list.
  constructor(waves, coarse = false) {
    this.waves = waves;
    const [rings, spokes] = coarse ? [RINGS / 3, SPOKES / 3] : [RINGS, SPOKES];
    const vector = () => ({ value: new THREE.Color() });
    this.uniforms = {
      count: { value: 0 },
      waves: { value: Array.from({ length: MOST }, () => new THREE.Vector4()) },
      centre: { value: new THREE.Vector2() },
      spacing: { value: (2 * Math.PI) / spokes },
      sun: { value: new THREE.Vector3(0, 0, 1) },
      time: { value: 0 },
      haze: { value: 1 / 900 },
      detail: { value: 1 },
      deep: vector(),
      shallow: vector(),
      horizon: vector(),
      zenith: vector(),
      glint: vector(),
    };
    const material = new THREE.ShaderMaterial({
      uniforms: this.uniforms,
      vertexShader: vertex,
      fragmentShader: fragment,
    });
    this.object = new THREE.Mesh(grid(Math.round(rings), Math.round(spokes)), material);
    this.object.frustumCulled = false;
  }

  update(row, time, target) {
    const rows = this.waves(row);
    const count = Math.min(MOST, Math.floor(rows.length / 4));
    this.uniforms.count.value = count;
    for (let i = 0; i < count; i++) {
      const [amplitude, frequency, direction, phase] = rows.slice(4 * i, 4 * i + 4);
      const turned = (frequency * time + phase) % (2 * Math.PI);
      this.uniforms.waves.value[i].set(amplitude, frequency ** 2 / 9.80665, direction, turned);
    }
    this.uniforms.time.value = time % 10_000;
    this.uniforms.centre.value.set(target.x, target.y);
  }
}
