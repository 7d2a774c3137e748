// The run of a page that contains its model: in a worker, or on the page's own thread where the browser
// starts no worker for a file.

import workerText from "engine:worker";
import { serve } from "./engine.js";
import { Run } from "./run.js";
import { Source } from "./source.js";
import { compileModule } from "./wasm.js";

const PATIENCE = 3000; // ms after which a worker that does not obey a reset is replaced

export class ModelSource extends Source {
  constructor(on, held) {
    super(on);
    const { module, ...content } = JSON.parse(held.textContent);
    this.content = content;
    this.packed = module;
    this.given = new Map(content.given);
    this.epoch = 0;
    this.speed = content.speed;
    this.hasGraph = Boolean(content.graph);
  }

  start() {
    this.on.scene({ description: this.content.description, live: true, meshes: this.content.meshes });
    this.load();
  }

  // Starts the model in a new worker, in the place of the one before.
  load() {
    clearTimeout(this.waiting);
    this.end?.();
    const taken = (kind, content) => this.take(kind, content);
    let worker = null;
    try {
      const address = URL.createObjectURL(new Blob([workerText], { type: "text/javascript" }));
      worker = new Worker(address);
      setTimeout(() => URL.revokeObjectURL(address), PATIENCE);
    } catch {
      worker = null;
    }
    if (worker) {
      let answered = false;
      worker.onmessage = ({ data: { kind, content } }) => {
        answered = true;
        taken(kind, content);
      };
      worker.onerror = (event) => {
        event.preventDefault();
        if (answered) return taken("fault", { messages: [{ code: "", text: event.message, help: "" }], stopped: true, time: 0 });
        worker.terminate();
        this.here(taken);
      };
      this.post = (command) => worker.postMessage(command);
      this.end = () => worker.terminate();
      this.greet();
    } else this.here(taken);
  }

  // Runs the model on this thread, a slice of it in each frame.
  here(taken) {
    this.post = serve(taken);
    this.end = () => this.post({ type: "close" });
    this.greet();
  }

  greet() {
    this.post({ type: "load", content: this.content, packed: this.packed, given: [...this.given], epoch: this.epoch });
    if (this.watched) this.post({ type: "watch", value: true });
    if (this.speed !== this.content.speed) this.post({ type: "speed", value: this.speed });
  }

  take(kind, content) {
    if (kind === "broken") return (this.broken = true);
    if (kind === "state") {
      if (content.epoch >= this.epoch) clearTimeout(this.waiting);
      this.epoch = Math.max(this.epoch, content.epoch);
    }
    this.on[kind]?.(content);
  }

  send(type, content = {}) {
    if (type === "graph") return this.on.graph(this.content.graph.description);
    if (type === "watch") this.watched = content.value;
    if (type === "set") this.remember(content);
    if (type === "speed") this.speed = content.value;
    if (type === "reset") {
      this.epoch++;
      if (this.broken) {
        this.broken = false;
        return this.load();
      }
      clearTimeout(this.waiting);
      this.waiting = setTimeout(() => this.load(), PATIENCE);
    }
    this.post?.({ type, ...content });
  }

  // Values that a new worker has to know.
  remember({ name, value }) {
    const k = this.content.description.parameters.findIndex((p) => p.name === name);
    const { low, high } = this.content.description.parameters[k] ?? {};
    if (k >= 0 && value >= (low ?? -Infinity) && value <= (high ?? Infinity)) this.given.set(k, value);
  }

  // For scripts that drive the page: the rows at times of a run of its own from the start, in double precision,
  // each an array of the columns of the description; and the seconds that it took.
  async simulate(times) {
    const run = await Run.of(await compileModule(this.packed), this.content);
    run.reset();
    const rows = [];
    const begun = performance.now();
    for (const time of times) {
      const { fault } = run.advance([time]);
      if (fault) throw fault;
      rows.push([...run.values64()]);
    }
    return { rows, seconds: (performance.now() - begun) / 1000, bytes: run.c.memory.buffer.byteLength };
  }
}
