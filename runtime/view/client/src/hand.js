// The pose that the page gives a device, by the mouse, a finger, the keys, a gamepad or the tilt of the screen.

const RETURN = 0.05; // s: time constant with which a handle that is let go springs back
const DEAD = 0.12; // of a stick, around its middle
const OPEN = 0.025; // m: of a gripper, at the end of a trigger
const BUTTONS = 8;

export class Hand {
  // `device` is one of the description, `axes` those of its position that move something, and `began` is
  // called when the hand is taken.
  constructor(device, axes, source, began) {
    this.device = device;
    this.source = source;
    this.began = began;
    this.axes = axes ?? [0, 1, 2];
    this.position = [0, 0, 0];
    this.buttons = new Array(BUTTONS).fill(0);
    this.gripper = 0;
    this.by = null; // what holds it: "pointer", "gamepad", "keyboard" or "tilt"
    this.tilt = null; // the motion sensor, where the page has one
    this.stays = false; // where it is let go
    this.taken = false;
    this.sent = "";
  }

  // Takes the hand at a position, m, in the axes of the device: `seen`, that which is shown.
  grab(seen, by = "pointer", press = true) {
    if (!this.taken) this.position = this.within(seen ?? this.position);
    this.by = by;
    this.taken = true;
    if (press) this.buttons[0] = 1;
    this.began(this);
  }

  move(position) {
    this.position = this.within(position);
  }

  release() {
    this.by = null;
    this.buttons[0] = 0;
  }

  letGo() {
    this.tilt?.stop();
    if (!this.taken || this.stays) return;
    this.release();
    this.position = [0, 0, 0];
    this.tick(0);
  }

  press(button, on) {
    if (!this.taken) this.grab(this.position, null, false);
    this.buttons[button] = on ? 1 : 0;
  }

  // The scene's driver has the device again.
  lose() {
    this.tilt?.stop();
    Object.assign(this, { taken: false, by: null, position: [0, 0, 0], gripper: 0, sent: "" });
    this.buttons.fill(0);
  }

  // Inside the reach, on the axes that the model reads: a circle and a height.
  within([x, y, z]) {
    const { reach } = this.device;
    const [a, b, c] = [x, y, z].map((value, k) => (this.axes.includes(k) && Number.isFinite(value) ? value : 0));
    const out = Math.hypot(a, b) / reach;
    const flat = out > 1 ? 1 / out : 1;
    return [a * flat, b * flat, Math.max(-reach, Math.min(reach, c))];
  }

  // Goes on by `past` seconds, and sends the pose if it has changed: once for each frame at most.
  tick(past) {
    if (this.by === null || this.by === "gamepad") this.readGamepad();
    if (!this.taken) return;
    if (this.by === null && !this.stays) {
      const part = Math.exp(-past / RETURN);
      this.position = this.position.map((x) => (Math.abs(x) < 2e-5 ? 0 : x * part));
    }
    const pose = { device: this.device.name, position: this.position, gripper: this.gripper, buttons: this.buttons };
    const text = JSON.stringify(pose);
    if (text === this.sent) return;
    this.sent = text;
    this.source.send("hand", pose);
  }

  readGamepad() {
    const pad = gamepads().find((p) => p?.connected && p.axes.length >= 2);
    if (!pad) {
      if (this.by === "gamepad") this.release();
      return;
    }
    const stick = (k) => {
      const value = pad.axes[k] ?? 0;
      return Math.abs(value) < DEAD ? 0 : (Math.sign(value) * (Math.abs(value) - DEAD)) / (1 - DEAD);
    };
    const pressed = pad.buttons.slice(0, BUTTONS).map((b) => (b.pressed ? 1 : 0));
    const position = [-stick(1), -stick(0), -stick(3)].map((x) => x * this.device.reach);
    const active = position.some(Boolean) || pressed.some(Boolean);
    if (this.by !== "gamepad") {
      if (!active) return;
      this.grab(null, "gamepad", false);
    }
    this.move(position);
    pressed.forEach((on, k) => (this.buttons[k] = on));
    this.gripper = OPEN * (pad.buttons[7]?.value ?? 0);
  }
}

// The gamepads of the browser; none in a frame that may not use them, where the call throws.
function gamepads() {
  try {
    return [...(navigator.getGamepads?.() ?? [])];
  } catch {
    return [];
  }
}
