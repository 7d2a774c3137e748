// The time that the page shows, and how it moves: the player of a live run or a recorded one, and the bar below.
//
// The page extends it; it needs `source`, `store`, `live`, `unit`, `modes`, `description` and `badge` of the page.

import { button, el, icon } from "./dom.js";
import { number } from "./numbers.js";

const SPEEDS = [1e-6, 1e-5, 1e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];

export class Playback {
  constructor() {
    this.player = { playing: false, speed: 1, actual: 0, ended: false, ready: true };
    this.scrubbed = null; // a time in the past that is shown, in a live run
  }

  transport() {
    this.playButton = button("play", "Start (Space)", () => this.togglePlay(), { class: "primary" });
    this.stepButton = button("step", "One step (.)", () => this.step());
    this.resetButton = button("reset", "Reset (R)", () => this.reset());
    this.speeds = el("select", { title: "Speed (− +)", "aria-label": "Speed", onchange: () => this.setSpeed(Number(this.speeds.value)) },
      ...SPEEDS.map((s) => el("option", { value: s }, speedText(s))));
    this.line = el("input", { type: "range", class: "line", min: 0, max: 1, step: "any", "aria-label": "Time" });
    this.line.addEventListener("input", () => this.seek(Number(this.line.value)));
    this.clock = el("b");
    this.end = el("small");
    this.nowButton = el("button", { type: "button", class: "now wide", title: "Back to the present (End)", onclick: () => this.seek(Infinity) }, "live");
    return el("footer", {}, this.playButton, this.stepButton, this.resetButton, this.speeds, this.line,
      this.live ? this.nowButton : null, el("span", { class: "time" }, this.clock, this.end));
  }

  buttons() {
    if (!this.playButton) return;
    const { playing, ended, speed, actual } = this.player;
    const title = playing ? "Pause (Space)" : ended ? "Go on beyond the end of the scene (Space)" : "Start (Space)";
    if (this.shown !== playing) this.playButton.replaceChildren(icon(playing ? "pause" : "play"));
    this.shown = playing;
    this.playButton.title = title;
    this.playButton.setAttribute("aria-label", title);
    if (document.activeElement !== this.speeds) {
      const nearest = SPEEDS.reduce((a, b) => (Math.abs(Math.log(b / speed)) < Math.abs(Math.log(a / speed)) ? b : a));
      this.speeds.value = nearest;
    }
    const lagging = playing && actual > 0 && actual < 0.93 * speed;
    const { loop } = this.player; // in real time
    const text = loop && (!this.disconnected || ended) ? loop.words : this.disconnected ? "reconnecting" : this.modes ? "mode shapes" : !this.live ? "recorded run" : lagging ? `live, at ${speedText(actual)}` : ended ? "end of the scene" : playing ? "live" : "paused";
    this.badge.className = `badge ${this.disconnected ? "lost" : this.live && playing ? "live" : ""}`;
    this.badge.title = lagging ? "The model is slower than the clock on this machine" : this.disconnected ? "The connection is lost, or the command has ended" : loop?.lines.join("\n") ?? "";
    this.badge.lastChild.textContent = text;
  }

  togglePlay() {
    if (this.live) {
      this.scrubbed = null;
      return this.source.send(this.player.playing ? "pause" : "play");
    }
    if (!this.player.playing && this.time >= this.store.last) this.time = this.store.first;
    this.player.playing = !this.player.playing;
    this.buttons();
  }

  step() {
    if (this.live) {
      this.scrubbed = null;
      return this.source.send("step");
    }
    this.player.playing = false;
    const row = Math.min(this.store.count - 1, this.store.find(this.time) + 1);
    this.time = this.store.time(row);
    this.buttons();
  }

  reset() {
    if (this.live) return this.source.send("reset");
    this.time = this.store.first;
    this.player.playing = false;
    this.buttons();
  }

  setSpeed(value) {
    if (this.live) this.source.send("speed", { value });
    this.player.speed = value;
    this.speeds.blur();
    this.buttons();
  }

  faster(by) {
    const at = SPEEDS.findIndex((s) => s >= this.player.speed * 0.999);
    this.setSpeed(SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, at + by))]);
  }

  seek(time) {
    const inside = Math.min(this.store.last, Math.max(this.store.first, time));
    if (this.live) {
      this.scrubbed = inside >= this.store.last && !this.player.playing ? null : time === Infinity ? null : inside;
      if (this.scrubbed !== null && this.player.playing) this.source.send("pause");
    } else this.time = inside;
  }

  shownTime() {
    if (!this.live) return this.time ?? 0;
    return this.scrubbed ?? this.store.last;
  }

  // Moves the time of a recorded run, or of a mode that swings on, by so many seconds of the clock.
  advance(past) {
    if (this.live || !this.player.playing) return;
    this.time = Math.min(this.store.last, this.time + past * this.player.speed);
    if (this.modes) {
      const { first, last } = this.modes.mode;
      if (this.time > last) this.time = first + ((this.time - first) % (last - first));
    } else if (this.time >= this.store.last) {
      this.player.playing = false;
      this.buttons();
    }
  }

  // The bar at a time of a run that has reached `last`, drawn up to `end`.
  showTime(time, last, end) {
    this.line.max = this.live ? Math.max(last, 1e-12) : end;
    if (document.activeElement !== this.line || this.player.playing) this.line.value = time;
    this.line.style.setProperty("--share", `${(100 * time) / (Number(this.line.max) || 1)}%`);
    this.clock.textContent = this.timeText(time).split(" ")[0];
    this.end.textContent = ` ${this.unit.unit}${this.live ? "" : ` of ${number(end / this.unit.factor, 4)}`}`;
    this.nowButton.classList.toggle("on", this.scrubbed === null);
  }

  timeText(time) {
    const digits = this.unit.factor === 1 && (this.description.duration ?? 100) >= 1 ? 2 : 3;
    return `${(time / this.unit.factor).toFixed(digits)} ${this.unit.unit}`;
  }
}

function speedText(speed) {
  return speed >= 0.1 ? `${number(speed, 2)}×` : `1/${number(1 / speed, 2)}×`;
}

// A replay of 2 s to 10 min plays in real time; others take about 10 s.
export function replaySpeed(duration) {
  if (!duration || (duration >= 2 && duration <= 600)) return 1;
  return SPEEDS.reduce((a, b) => (b <= (duration / 10) * 1.0001 ? b : a));
}
