// The model of this page: a WebAssembly module, its run, and the player that keeps it in pace with the clock.
// It uses nothing of the page, so that it can live in a worker. `Run` and `Player` do here for the module what
// live.py and player.py do for a shared object; runtime/c/web/web.c has the functions that are called.

import { Meter } from "./meter.js";
import { compileModule, instantiate } from "./wasm.js";

const FRAME = 1 / 60; // s of the clock between two frames
const SPEEDS = [1e-6, 100];
const MOST_ROWS = 16; // in a frame
const LATE = 0.1; // s behind the clock after which the lost time is given up
const SHARE = 0.8; // of a frame that computing may take before the chunks become shorter
const SLOWEST_FRAME = 1 / 15; // s of computing in a frame of a run that cannot keep up
const OK = 0;
const BAD_PARAMETER = 7;
const POINTER = "pointer";

export class Fault extends Error {
  constructor(...messages) {
    super(messages.map((m) => m.text).join("; "));
    this.messages = messages;
  }
}

// A number as `%g` prints it, nearly.
const short = (value) => String(Number(value.toPrecision(6)));

export class Run {
  // `content` is the data of the page: runtime/web/content.py.
  static async of(module, content) {
    return new Run(await instantiate(module), content);
  }

  constructor(exports, content) {
    this.c = exports;
    this.content = content;
    this.width = content.description.width;
    this.index = new Map(content.description.parameters.map((p, k) => [p.name, k]));
    this.given = new Map(content.given);
    this.held = [];
    this.time = 0;
    this.begun = false;
    this.room = this.c.allocate(8 * (this.width + 32)); // a time, 22 numbers, then a row
    this.row = this.room + 8 * 24;
  }

  // Starts from the initial state, and returns its row.
  reset() {
    const { c, content } = this;
    this.begun = true;
    this.held = [];
    this.time = 0;
    const method = this.text(content.method);
    this.numbers(content.options);
    const status = c.begin(method, this.room);
    c.release(method);
    if (status !== OK) throw this.explained(status);
    for (const [k, value] of this.given) c.set(k, value);
    content.devices.forEach((device, k) => this.open(k, device));
    this.require(this.started());
    const [row] = this.advance([0]);
    return row;
  }

  started() {
    const { c } = this;
    const { start } = this.content;
    if (!start) return c.start(0, 0, 0, 0);
    const [state, index, value] = [start.state, start.varied, start.values].map((list) => c.allocate(8 * list.length));
    new Float64Array(c.memory.buffer, state, start.state.length).set(start.state);
    new Int32Array(c.memory.buffer, index, start.varied.length).set(start.varied);
    new Float64Array(c.memory.buffer, value, start.values.length).set(start.values);
    const status = c.start(state, start.varied.length, index, value);
    [state, index, value].forEach((at) => c.release(at));
    return status;
  }

  // Whether the start was searched for with other values than the present ones.
  get startsElsewhere() {
    const before = new Map(this.content.given);
    const changed = ([k, value]) => value !== (before.get(k) ?? this.content.values[k]);
    return Boolean(this.content.start) && [...this.given].some(changed);
  }

  // Integrates to times, and returns their rows. After a failure `fault` of the list has the reason; the rows
  // before it are returned. Stops between two rows after `budget`, s of the clock.
  advance(times, budget = Infinity) {
    const rows = [];
    const begun = performance.now();
    for (const time of times) {
      this.numbers([time]);
      const status = this.c.run(this.room, 1, this.row);
      if (this.c.done() === 1) {
        this.time = time;
        rows.push(this.packed(time));
      }
      if (status !== OK) {
        this.time = Math.max(this.time, this.c.now());
        rows.fault = this.explained(status);
        break;
      }
      if (performance.now() - begun > 1000 * budget) break;
    }
    return rows;
  }

  // A row for the page: float32, the time as a sum of two numbers.
  packed(time) {
    const row = new Float32Array(2 + this.width);
    row[0] = time;
    row[1] = time - row[0];
    row.set(new Float64Array(this.c.memory.buffer, this.row, this.width), 2);
    return row;
  }

  // The values of the last row in double precision.
  values64() {
    return Float64Array.from(new Float64Array(this.c.memory.buffer, this.row, this.width));
  }

  // The state at the present time, and the inputs: views that hold until the next call of the module.
  state() {
    const at = this.c.state_at(this.time);
    return new Float64Array(this.c.memory.buffer, at, this.c.states());
  }

  input() {
    return new Float64Array(this.c.memory.buffer, this.c.input(), this.c.inputs());
  }

  values() {
    if (!this.begun) return this.content.values;
    return this.content.description.parameters.map((_, k) => this.c.get(k));
  }

  // Gives a parameter a value, now and after each reset. The state stays. Throws a Fault where the value
  // is out of range, or the run cannot go on with it.
  set(name, value) {
    const { c } = this;
    const k = this.index.get(name);
    if (k === undefined) return;
    const { low, high, factor } = this.content.description.parameters[k];
    if (!(value >= (low ?? -Infinity) && value <= (high ?? Infinity))) {
      throw new Fault(filled(this.content.faults.range[k], { value: short(value / factor) }));
    }
    if (this.begun) {
      const status = c.change(k, value, this.time);
      if (status !== OK) {
        const [{ text }] = this.explained(status).messages;
        c.take_back();
        throw new Fault(filled(this.content.faults.refused, { name, reason: text }));
      }
    }
    this.given.set(k, value);
  }

  // --- devices ------------------------------------------------------------------------------

  open(k, { name, driver, options, file, text }) {
    const { c } = this;
    const texts = [driver, options, file ?? "", text ?? ""].map((each) => this.text(each));
    c.give(texts[2], texts[3]);
    const status = c.open(k, texts[0], texts[1]);
    texts.forEach((at) => c.release(at));
    if (status !== OK) {
      const reason = this.string(c.message());
      throw new Fault(filled(this.content.faults.device, { name, driver, reason }));
    }
  }

  // Gives a device the pose of the page's hand, which has it until it leaves it, or the next reset.
  hand({ device: name, position, orientation = [1, 0, 0, 0], gripper = 0, buttons = [] }) {
    const { devices } = this.content;
    const k = devices.findIndex((device) => device.name === name);
    if (k < 0) return;
    if (!this.held.includes(name)) {
      if (devices[k].driver !== POINTER) this.open(k, { name, driver: POINTER, options: "" });
      this.held = [...this.held, name].sort();
    }
    const pressed = Array.from({ length: 8 }, (_, b) => buttons[b] ?? 0);
    this.numbers([...position, ...orientation, gripper, ...pressed]);
    this.c.hand(k, this.room);
  }

  leave(name) {
    const { devices } = this.content;
    const k = devices.findIndex((device) => device.name === name);
    if (!this.held.includes(name)) return;
    this.held = this.held.filter((each) => each !== name);
    this.open(k, devices[k]);
  }

  // --- memory -------------------------------------------------------------------------------

  numbers(list) {
    new Float64Array(this.c.memory.buffer, this.room, list.length).set(list);
  }

  text(content) {
    const bytes = new TextEncoder().encode(content);
    const at = this.c.allocate(bytes.length);
    new Uint8Array(this.c.memory.buffer, at, bytes.length).set(bytes);
    return at;
  }

  string(at) {
    const memory = new Uint8Array(this.c.memory.buffer);
    return new TextDecoder().decode(memory.slice(at, memory.indexOf(0, at)));
  }

  // --- faults -------------------------------------------------------------------------------

  require(status) {
    if (status !== OK) throw this.explained(status);
  }

  explained(status) {
    const { c, content } = this;
    const known = content.faults.by_status[status];
    if (!known) return new Fault({ code: "", text: `the model failed with status ${status}`, help: "" });
    const k = known.names < 0 ? -1 : c.failed(known.names);
    const reason = known.reasons ? this.string(c.reason()) : "";
    const range = status === BAD_PARAMETER ? content.faults.range[k] : null;
    const message =
      range ?? (reason ? known.reasons[k] : null) ?? known.items[k] ?? (k >= 0 ? known.named : null) ?? known.any ?? known.items[0];
    return new Fault(
      filled(message, {
        time: c.now().toPrecision(9).replace(/\.?0+$/, ""),
        failed_time: short(c.failed_time()),
        state: content.states[k] ?? "",
        value: range ? short(c.get(k) / content.description.parameters[k].factor) : "",
        reason,
      }),
    );
  }
}

function filled({ code, text, help }, values) {
  const put = (whole) => whole.replace(/⟦(\w+)⟧/g, (_, name) => values[name] ?? "");
  return { code, text: put(text), help: put(help) };
}

export class Player {
  // `publish(kind, content)` gets what a source of the page calls: rows, state, values, fault.
  constructor(run, content, publish, epoch = 0) {
    const { duration } = content.description;
    this.run = run;
    this.publish = publish;
    this.every = content.every || Infinity;
    this.speed = content.speed;
    this.pauseAt = this.duration = duration || Infinity;
    this.playing = this.ended = this.ready = false;
    this.epoch = epoch;
    this.actual = 0;
    this.ratio = Infinity; // simulated seconds for each second of computing, smoothed
    this.timer = null;
    this.isWatched = false;
    this.meter = null;
  }

  get state() {
    const { playing, speed, actual, ended, epoch, ready } = this;
    return { playing, speed, actual, ended, epoch, ready, held: this.run.held };
  }

  // Takes the initial state.
  start() {
    this.guard(() => this.restart());
    this.publish("state", this.state);
  }

  command({ type, ...content }) {
    const obey = this[`on_${type}`];
    if (!obey) return;
    const before = JSON.stringify(this.state);
    this.guard(() => obey.call(this, content));
    if (type !== "hand") this.measure(true);
    if (type !== "hand" || JSON.stringify(this.state) !== before) this.publish("state", this.state);
    this.schedule();
  }

  close() {
    clearTimeout(this.timer);
    this.playing = false;
  }

  // --- the clock ----------------------------------------------------------------------------

  schedule() {
    if (!this.playing || this.timer !== null) return;
    this.due ??= performance.now() / 1000;
    this.measured ??= { at: this.due, time: this.run.time };
    const wait = Math.max(0, 1000 * (this.due - performance.now() / 1000));
    this.timer = setTimeout(() => this.tick(), wait);
  }

  tick() {
    this.timer = null;
    if (!this.playing) return this.stopClock();
    const now = performance.now() / 1000;
    this.due = now - this.due < LATE ? this.due + FRAME : now + FRAME;
    this.guard(() => this.advance());
    this.measure();
    const end = performance.now() / 1000;
    if (end - this.measured.at > 0.5) {
      this.actual = (this.run.time - this.measured.time) / (end - this.measured.at);
      this.measured = { at: end, time: this.run.time };
      this.publish("state", this.state);
    }
    if (this.playing) this.schedule();
    else this.stopClock();
  }

  stopClock() {
    this.due = this.measured = undefined;
  }

  // Computes the next frame: less simulated time where the model is slower than the clock.
  advance(wanted = null) {
    let step = wanted ?? this.speed * FRAME;
    if (wanted === null && this.ratio * FRAME * SHARE < step) step = Math.min(step, this.ratio * SLOWEST_FRAME);
    const before = this.run.time;
    const end = Math.min(before + step, this.pauseAt);
    const count = Math.min(MOST_ROWS, Math.max(1, Math.ceil((end - before) / this.every - 1e-9)));
    const times = Array.from({ length: count }, (_, k) => (k + 1 < count ? before + ((end - before) * (k + 1)) / count : end));
    const begun = performance.now() / 1000;
    const rows = this.run.advance(times, SLOWEST_FRAME);
    const spent = performance.now() / 1000 - begun;
    const gone = this.run.time - before;
    if (gone > 0) {
      const ratio = gone / Math.max(spent, 1e-6);
      this.ratio = Number.isFinite(this.ratio) ? 0.8 * this.ratio + 0.2 * ratio : ratio;
    }
    this.emit(rows);
    if (rows.fault) {
      this.playing = false;
      this.fail(rows.fault.messages, true);
      this.publish("state", this.state);
    } else if (this.run.time >= this.pauseAt) {
      this.playing = false;
      this.ended = true;
      this.publish("state", this.state);
    }
  }

  emit(rows) {
    if (!rows.length) return;
    const width = rows[0].length;
    const all = new Float32Array(rows.length * width);
    rows.forEach((row, k) => all.set(row, k * width));
    this.publish("rows", { whole: false, epoch: this.epoch, count: rows.length, rows: all });
  }

  // --- commands -----------------------------------------------------------------------------

  on_play() {
    if (this.ended) this.pauseAt = Infinity; // on beyond the end of the scene
    this.ended = false;
    this.playing = this.ready;
  }

  on_pause() {
    this.playing = false;
    this.actual = 0;
  }

  on_step() {
    this.on_pause();
    if (this.ready) this.advance(Math.min(this.every, this.speed * FRAME));
  }

  on_speed({ value }) {
    this.speed = Math.min(Math.max(value, SPEEDS[0]), SPEEDS[1]);
  }

  on_reset() {
    this.epoch++;
    this.restart();
  }

  on_set({ name, value }) {
    this.steer(() => this.run.set(name, value));
    this.publish("values", { values: this.run.values() });
  }

  // Begins or ends the readings of the bonds; their module is made when they are first wanted.
  on_watch({ value }) {
    this.isWatched = value && Boolean(this.run.content.graph);
    if (!this.isWatched || this.meter !== null) return;
    this.meter = undefined; // on its way
    Meter.of(this.run.content.graph).then(
      (meter) => {
        this.meter = meter;
        this.measure(true);
      },
      (problem) => {
        const text = `this browser cannot measure the bonds: ${problem.message}`;
        this.fail([{ code: "", text, help: "" }], false);
      },
    );
  }

  // Publishes efforts and flows where they are watched, some times a second or at once.
  measure(atOnce = false) {
    const now = performance.now() / 1000;
    if (!this.isWatched || !this.meter || !this.ready || !(atOnce || this.meter.isDue(now))) return;
    this.guard(() => this.publish("powers", { epoch: this.epoch, values: this.meter.measure(this.run, now) }));
  }

  on_hand(pose) {
    if (this.ready) this.steer(() => this.run.hand(pose));
  }

  on_leave({ device }) {
    if (this.ready) this.steer(() => this.run.leave(device));
  }

  restart() {
    this.ended = false;
    this.actual = 0;
    this.pauseAt = this.duration;
    const row = this.run.reset();
    this.ready = true;
    this.emit([row]);
    this.publish("values", { values: this.run.values() });
    if (this.run.startsElsewhere) {
      const text = "the run starts from the state that is at rest with the values of this file, not with those set since";
      this.fail([{ code: "", text, help: "" }], false);
    }
  }

  // --- faults -------------------------------------------------------------------------------

  steer(work) {
    try {
      work();
    } catch (problem) {
      if (!(problem instanceof Fault)) throw problem;
      this.fail(problem.messages, false);
    }
  }

  // Does work; a fault stops the run and is shown, and the page goes on.
  guard(work) {
    try {
      work();
    } catch (problem) {
      this.playing = this.ready = false;
      const text = `the model cannot run in this browser: ${problem.message}`;
      this.fail(problem.messages ?? [{ code: "", text, help: "reset the run" }], true);
      if (!problem.messages) this.publish("broken", {}); // the memory of the module may be damaged
    }
  }

  fail(messages, stopped) {
    this.publish("fault", { messages, stopped, time: this.run.time });
  }
}

// Serves a page: `post(kind, content)` gets the events, and the returned function takes commands.
// The first command is `load` with the page's content and its module.
export function serve(post) {
  let player = null;
  const early = [];
  const load = async ({ content, packed, given, epoch }) => {
    try {
      const run = await Run.of(await compileModule(packed), content);
      for (const [k, value] of given) run.given.set(k, value);
      player = new Player(run, content, post, epoch);
      player.start();
      for (const command of early.splice(0)) player.command(command);
    } catch (problem) {
      const text = `this browser cannot run the model: ${problem.message}`;
      const help = "use a present version of Chrome, Edge, Firefox or Safari";
      post("fault", { messages: [{ code: "", text, help }], stopped: true, time: 0 });
    }
  };
  return (command) => {
    if (command.type === "load") load(command);
    else if (command.type === "close") player?.close();
    else if (player) player.command(command);
    else early.push(command);
  };
}
