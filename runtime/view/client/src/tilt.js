// A tablet or a phone that is tilted moves a hand: its motion sensor, from the posture at which it was begun.

import { Euler, MathUtils, Quaternion, Vector3 } from "three";

const FULL = Math.PI / 6; // rad: the end of the reach
const DEAD = Math.PI / 90; // rad, around the posture of the beginning
const PATIENCE = 1000; // ms until the first event

export class Tilt {
  // `changed` is called when the sensor is begun, ended or refused; `problem` then has the reason.
  constructor(hand, changed) {
    this.hand = hand;
    this.changed = changed;
    this.on = false;
    this.problem = "";
    this.read = (event) => this.take(event);
    hand.tilt = this;
  }

  // Whether to offer it: to those who hold the screen in their hands.
  static get isOffered() {
    return "DeviceOrientationEvent" in window && matchMedia("(any-pointer: coarse)").matches;
  }

  async toggle() {
    if (this.on) return this.stop();
    this.begin();
    // Some browsers ask the user, and do so only in answer to a click.
    const asked = DeviceOrientationEvent.requestPermission;
    if (asked && (await asked.call(DeviceOrientationEvent).catch(() => "denied")) !== "granted") return this.stop("not allowed");
    if (!this.on) return;
    addEventListener("deviceorientation", this.read);
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => this.stop("no sensor"), PATIENCE);
  }

  begin() {
    this.on = true;
    this.problem = "";
    this.start = null;
    this.changed();
  }

  stop(problem = "") {
    if (!this.on) return;
    removeEventListener("deviceorientation", this.read);
    clearTimeout(this.waiting);
    this.on = false;
    this.problem = problem;
    if (this.hand.by === "tilt") this.hand.release();
    this.changed();
  }

  take({ alpha, beta, gamma }) {
    if (![alpha, beta, gamma].every(Number.isFinite)) return; // a machine without the sensor says so once
    clearTimeout(this.waiting);
    const { hand } = this;
    const now = new Quaternion().setFromEuler(new Euler(...[beta, gamma, alpha].map(MathUtils.degToRad), "ZXY"));
    this.start ??= now.clone();
    if (hand.by !== null && hand.by !== "tilt") return; // a finger on the pad comes first
    const position = places(this.start, now).map((x) => x * hand.device.reach);
    if (hand.by === null) {
      if (!position.some(Boolean)) return;
      hand.grab(null, "tilt", false);
    }
    hand.move(position);
  }
}

// The place of the hand, from -1 to 1: tilted away it is ahead, to the left it is left, and turned clockwise it is up.
function places(start, now) {
  const turned = start.clone().invert().multiply(now);
  const sine = Math.hypot(turned.x, turned.y, turned.z);
  const angle = 2 * Math.atan2(sine, Math.abs(turned.w));
  const vector = new Vector3(turned.x, turned.y, turned.z).multiplyScalar(sine > 0 ? (Math.sign(turned.w || 1) * angle) / sine : 0);
  // From the axes of the device to those of the screen, which may be turned.
  vector.applyAxisAngle(new Vector3(0, 0, 1), MathUtils.degToRad(screen.orientation?.angle ?? 0));
  return [-vector.x, -vector.y, -vector.z].map((x) => Math.sign(x) * MathUtils.clamp((Math.abs(x) - DEAD) / (FULL - DEAD), 0, 1));
}
