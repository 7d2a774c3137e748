// The keys of the page, and the dialog that lists them.

import { el } from "./dom.js";

// Keys, what they do, and what the page needs for them.
const KEYS = [
  ["Space", "Start, pause", "clock"], [".", "One step", "clock"], ["R", "Reset"],
  ["←  →", "Scrub; with Shift ten times as far"], ["End", "Back to the present"], ["−  +", "Slower, faster", "clock"],
  ["1  2  3  4", "Overview, front, side, above", "scene"], ["F", "Follow the marked part", "scene"],
  ["Tab  ←  ↑  →  ↓  −  +", "With the scene in focus: turn the view, farther, nearer", "scene"],
  ["P", "Save a picture", "scene"], ["V", "Record a video, and save it", "scene"],
  ["G", "Scene or bond graph", "graph"], ["T", "Dark or light"], ["B", "Show or hide the side panel"], ["?", "This list"],
];

// The dialog with the keys of a page that `has` a `scene`, a `graph`, and a `clock` of its own, or lacks them.
export function helpOf(has) {
  const row = ([keys, what]) =>
    el("tr", {}, el("td", {}, ...keys.split("  ").flatMap((key) => [el("kbd", {}, key), " "])), el("td", {}, what));
  const dialog = el("dialog", { "aria-labelledby": "keys", onclick: () => dialog.close() }, el("h2", { id: "keys" }, "Keys"), el("table", {}, ...KEYS.filter(([, , needs]) => !needs || has[needs]).map(row)));
  return dialog;
}

// Keys that an element with the focus takes itself.
const TYPING = "input[type=text], input[type=search], select, dialog";
const PRESSED = "button, summary, [role=button]";
const SLIDING = "input[type=range]:not(.line), [role=slider]";
const SLIDES = /^(Arrow|Page|Home|End)/;

export function listenToKeys(page) {
  addEventListener("keydown", (event) => onKey(page, event));
  // A button that was clicked gives the focus back, so that Space starts and pauses.
  addEventListener("click", (event) => event.detail > 0 && event.target.closest?.(PRESSED)?.blur());
}

function onKey(page, event) {
  const { key, target } = event;
  if (event.ctrlKey || event.metaKey || event.altKey || target.closest(TYPING)) return;
  if ((key === " " || key === "Enter") && target.closest(PRESSED)) return;
  if (SLIDES.test(key) && target.closest(SLIDING)) return;
  const action = (target === page.stage?.canvas ? turning(page.stage)[key] : null) ?? actions(page, event.shiftKey)[key.length === 1 ? key.toLowerCase() : key];
  if (!action) return;
  event.preventDefault();
  action();
}

const TURN = Math.PI / 36;

function turning(stage) {
  return {
    ArrowLeft: () => stage.turn(-TURN, 0), ArrowRight: () => stage.turn(TURN, 0), ArrowUp: () => stage.turn(0, TURN), ArrowDown: () => stage.turn(0, -TURN),
    "+": () => stage.turn(0, 0, 0.9), "=": () => stage.turn(0, 0, 0.9), "-": () => stage.turn(0, 0, 1 / 0.9),
  };
}

function actions(page, isFar) {
  const far = ((isFar ? 10 : 1) * (page.store.last - page.store.first)) / 100;
  return {
    " ": () => page.togglePlay(), ".": () => page.step(), r: () => page.reset(),
    ArrowLeft: () => page.seek(page.shownTime() - far), ArrowRight: () => page.seek(page.shownTime() + far), End: () => page.seek(Infinity),
    "-": () => page.faster(-1), "+": () => page.faster(1), "=": () => page.faster(1),
    1: () => (page.graph?.shown ? page.graph.fit() : page.stage?.look("overview")), 2: () => page.stage?.look("front"), 3: () => page.stage?.look("side"), 4: () => page.stage?.look("above"),
    f: () => page.followMarked(), p: () => page.saving.picture(), v: () => page.saving.toggleVideo(), t: () => page.setTheme(page.theme === "dark" ? "light" : "dark"),
    g: () => page.graph && page.look(page.viewed === "graph" ? "scene" : "graph"),
    b: () => page.toggleSide(), "?": () => page.help.showModal(),
  };
}
