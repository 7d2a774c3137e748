// The keys of the page, and the dialog that lists them.

import { el } from "./dom.js";

const KEYS = [
  ["Space", "Start, pause"], [".", "One step"], ["R", "Reset"], ["←  →", "Scrub; with Shift ten times as far"], ["End", "Back to the present"],
  ["−  +", "Slower, faster"], ["1  2  3  4", "Overview, front, side, above"], ["F", "Follow the marked part"], ["P", "Save a picture"], ["V", "Record a video, and save it"],
  ["G", "Scene or bond graph"], ["T", "Dark or light"], ["B", "Show or hide the side panel"], ["?", "This list"],
];

export function helpOf() {
  const row = ([keys, what]) =>
    el("tr", {}, el("td", {}, ...keys.split("  ").flatMap((key) => [el("kbd", {}, key), " "])), el("td", {}, what));
  const dialog = el("dialog", { onclick: () => dialog.close() }, el("h2", {}, "Keys"), el("table", {}, ...KEYS.map(row)));
  return dialog;
}

export function onKey(page, event) {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input[type=text], input[type=search], select, dialog")) return;
  const far = ((event.shiftKey ? 10 : 1) * (page.store.last - page.store.first)) / 100;
  const actions = {
    " ": () => page.togglePlay(), ".": () => page.step(), r: () => page.reset(),
    ArrowLeft: () => page.seek(page.shownTime() - far), ArrowRight: () => page.seek(page.shownTime() + far), End: () => page.seek(Infinity),
    "-": () => page.faster(-1), "+": () => page.faster(1), "=": () => page.faster(1),
    1: () => (page.graph?.shown ? page.graph.fit() : page.stage?.look("overview")), 2: () => page.stage?.look("front"), 3: () => page.stage?.look("side"), 4: () => page.stage?.look("above"),
    f: () => page.followMarked(), p: () => page.picture(), v: () => page.toggleVideo(), t: () => page.setTheme(page.theme === "dark" ? "light" : "dark"),
    g: () => page.graph && page.look(page.viewed === "graph" ? "scene" : "graph"),
    b: () => page.toggleSide(), "?": () => page.help.showModal(),
  };
  const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  event.preventDefault();
  action();
}
