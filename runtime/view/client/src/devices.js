// The devices of a scene on the page: a pad for each, and a grip in the scene where its handle has a
// place there.

import { el } from "./dom.js";
import { Grip } from "./grip.js";
import { Hand } from "./hand.js";
import { Handle } from "./handle.js";

export class Devices {
  // `began` is called when a hand is taken. Recorded runs have no hands; their handles are shown.
  constructor({ description, live, source, main, stage, began }) {
    const handles = description.shapes.filter((shape) => shape.kind === "handle");
    const free = live ? (description.devices ?? []).filter((d) => d.free && d.reads.includes("position")) : [];
    const shapeOf = (device) => handles.find((shape) => shape.device === device.name);
    this.hands = free.map((device) => new Hand(device, shapeOf(device)?.axes, source, began));
    const pairs = handles.map((shape) => [shape, this.hands.find((h) => h.device.name === shape.device)]);
    for (const hand of this.hands) if (!pairs.some(([, h]) => h === hand)) pairs.push([null, hand]);
    const leave = (hand) => {
      source.send("leave", { device: hand.device.name });
      hand.lose();
    };
    const holder = el("div", { class: "hands" });
    this.pads = pairs.map(([shape, hand]) => new Handle(holder, { shape, hand, leave }));
    if (pairs.length) main.append(holder);
    const placed = stage ? pairs.filter(([shape]) => shape?.values.r) : [];
    this.grips = placed.map(([shape, hand]) => new Grip(stage, main, shape, hand));
  }

  // Whether the mouse is at a grip, or drags it.
  get isGripped() {
    return this.grips.some((grip) => grip.hot || grip.hand?.by);
  }

  // Takes a state of the player: a reset, or somebody else, has given a device back to the scene.
  state({ held = [] }, isReset) {
    for (const hand of this.hands) {
      const mine = held.includes(hand.device.name);
      if (isReset || (hand.held && !mine)) hand.lose();
      hand.held = mine;
    }
  }

  // Lets go of what is held and not pinned, at once.
  letGo() {
    for (const hand of this.hands) hand.letGo();
  }

  tick(past) {
    for (const hand of this.hands) hand.tick(past);
  }

  update(row) {
    for (const pad of this.pads) pad.update(row);
    for (const grip of this.grips) grip.update(row);
  }
}
