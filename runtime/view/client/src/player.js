// The player that keeps a run in the page in pace with the clock: what player.py does on the server.
// It uses nothing of the page, so that it can live in a worker.

import { Meter } from "./meter.js";
import { Fault } from "./run.js";

const FRAME = 1 / 60; // s of the clock between two frames
const SPEEDS = [1e-6, 100];
const MOST_ROWS = 16; // in a frame
const LATE = 0.1; // s behind the clock after which the lost time is given up
const SHARE = 0.8; // of a frame that computing may take before the chunks become shorter
const SLOWEST_FRAME = 1 / 15; // s of computing in a frame of a run that cannot keep up

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
