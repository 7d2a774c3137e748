// Efforts and flows of all bonds of a page that runs its model: a second module, in which all bonds are observed,
// takes the states, inputs and parameters of the run. runtime/c/web/meter.c has the functions that are called.

import { compileModule, instantiate } from "./wasm.js";

const OK = 0;
const ROUND = 1 / 15; // s of the clock between two readings

export class Meter {
  // `graph` is that of the page's content: runtime/web/page_export.py.
  static async of(graph) {
    return new Meter(await instantiate(await compileModule(graph.module)), graph);
  }

  constructor(exports, graph) {
    this.c = exports;
    this.graph = graph;
    if (this.c.begin() !== OK) throw new Error("no memory");
    this.row = this.c.allocate(8 * this.c.width());
    this.read = -Infinity; // when it was read last, s
  }

  // Whether it is time for another reading.
  isDue(now) {
    return now - this.read >= ROUND;
  }

  // The row of e1 f1 e2 f2 .. of a run, with its time before it: float32; NaN where it cannot be evaluated.
  measure(run, now) {
    const { c, graph } = this;
    this.read = now;
    graph.parameters.forEach((mine, k) => mine >= 0 && c.set(mine, run.c.get(k)));
    let status = c.reset(run.time);
    if (status === OK) {
      const [state, input] = [run.state(), run.input()];
      const mine = (at, length) => new Float64Array(c.memory.buffer, at, length);
      const states = mine(c.state(), graph.states.length);
      graph.states.forEach((from, k) => from >= 0 && (states[k] = state[from]));
      const inputs = mine(c.input(), 1 + Math.max(-1, ...graph.inputs.map(([k]) => k)));
      for (const [k, from] of graph.inputs) inputs[k] = input[from];
      status = c.read(this.row);
    }
    const row = new Float64Array(c.memory.buffer, this.row, c.width());
    return Float32Array.from(graph.columns, (column) => (status === OK ? row[column] : NaN));
  }
}
