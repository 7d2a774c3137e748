// A run of a WebAssembly module: what live.py does for a shared object. runtime/c/web/web.c has the functions
// that are called. It uses nothing of the page, so that it can live in a worker.

import { instantiate } from "./wasm.js";

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
