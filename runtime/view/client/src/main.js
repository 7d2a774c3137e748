// The page of `bgc view`: a live run or a recorded one.

import uplotStyle from "uplot/dist/uPlot.min.css";
import { Axes } from "./axes.js";
import { Devices } from "./devices.js";
import { button, el, icon } from "./dom.js";
import { GraphView, Slots, sourceBlock } from "./graph.js";
import { helpOf, listenToKeys } from "./keys.js";
import { cameBack, comeBack, remember, remembered } from "./memory.js";
import { Modes } from "./modes.js";
import { Parameters } from "./parameters.js";
import { Playback, replaySpeed } from "./playback.js";
import { Plots } from "./plots.js";
import { Saving } from "./saving.js";
import { timeUnit } from "./numbers.js";
import { openSource } from "./sources.js";
import { Stage } from "./stage.js";
import { Store, TIMES } from "./store.js";
import { Tabs } from "./tabs.js";
import style from "./style.css";

const PLOTTING = 70; // ms between two drawings of the plots
const SPREAD = 140; // ms over whose frames the drawing of all plots in view is spread
const SURVEYED = 12; // rows of a recorded run by which the camera is placed
const STILL = matchMedia("(prefers-reduced-motion: reduce)").matches;

document.head.append(el("style", {}, uplotStyle + style));

const LOST = {
  text: "The connection to bgc view is lost; the page keeps what it has and connects again by itself.",
  help: "If the command has ended, start it again and open the address that it prints.",
};

const LOOP_ENDED = {
  text: "The loop has ended; the page keeps what it has.",
  help: "Start bgc haptic again and open the address that it prints.",
};

class Page extends Playback {
  constructor() {
    super();
    this.theme = remembered("theme") ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
    document.documentElement.dataset.theme = this.theme;
    this.frames = 0;
    this.plotted = 0;
    this.source = openSource({
      scene: (content) => this.scene(content),
      rows: (content) => this.rows(content),
      state: (content) => this.state(content),
      values: ({ values }) => this.parameters?.take(values),
      fault: (content) => this.fault(content),
      graph: (graph) => this.takeGraph(graph),
      powers: ({ epoch, values }) => epoch === this.epoch && this.graph?.powers(values),
      lost: (lost) => this.lost(lost),
    });
    this.source.start();
  }

  // --- what comes from the server -----------------------------------------------------------

  scene({ description, model, live, meshes, rows, count }) {
    const identity = JSON.stringify([description, model]);
    if (this.description) {
      // A page that has connected again keeps its view; another model has another page.
      if (this.identity !== identity) {
        return comeBack({ view: this.viewed, tab: this.tabs?.chosen });
      }
      this.askedGraph = false;
      if (this.graph?.shown) this.source.send("watch", { value: true });
      return;
    }
    this.identity = identity;
    this.description = description;
    this.live = live;
    this.meshes = meshes;
    this.store = new Store(description.width);
    this.row = new Float32Array(description.width);
    this.unit = timeUnit(description.duration || 1);
    document.title = `${description.scene} – bgc`;
    this.build();
    if (!live) {
      this.time = 0;
      this.player.speed = replaySpeed(description.duration);
      if (rows) this.rows({ whole: true, epoch: 0, count, rows });
      this.player.playing = false;
      if (count) this.stage?.survey(this.spread(SURVEYED));
      this.modes?.choose(0);
      if (STILL) this.player.playing = false;
      if (description.message) this.banner([{ code: "", text: description.message, help: "" }], "warn");
    }
    this.setTheme(this.theme);
    this.buttons();
    const { view, tab } = live ? cameBack() : {};
    if (view === "graph" && this.graph) this.look(view);
    if (tab) this.tabs?.open(tab);
    // A hidden page draws nothing, so it would hold a device where the hand was.
    document.addEventListener("visibilitychange", () => document.hidden && this.devices.letGo());
    requestAnimationFrame((now) => this.loop(now));
  }

  rows({ whole, epoch, count, rows }) {
    if (!this.store) return;
    if (whole || epoch !== this.epoch) {
      if (epoch !== this.epoch) this.hideBanner();
      this.store.clear();
      this.epoch = epoch;
      this.scrubbed = null;
    }
    this.store.append(rows, count);
    if (!this.live && this.time == null) this.time = this.store.first;
  }

  // Some rows of a recorded run, spread over its time.
  spread(count) {
    return Array.from({ length: count }, (_, k) => {
      const row = new Float32Array(this.row.length);
      this.store.sample(this.store.first + (k / (count - 1)) * (this.store.last - this.store.first), row);
      return row;
    });
  }

  state(state) {
    if (state.playing && !this.player.playing) this.hideBanner();
    if (this.hint && (state.playing || this.store.count > 1)) this.hint.hidden = true;
    this.waitFor(state.busy ?? "");
    const reset = state.epoch !== this.player.epoch;
    this.player = state;
    this.devices?.state(state, reset);
    this.buttons();
  }

  fault({ messages, stopped, time }) {
    const isTold = messages.some((m) => /\bt = /.test(m.text)); // when it was
    const at = stopped && !isTold ? ` (${this.timeText(time)})` : "";
    this.banner(messages.map((m, k) => (k ? m : { ...m, text: m.text + at })), stopped ? "bad" : "warn");
  }

  lost(lost) {
    if (lost === Boolean(this.disconnected)) return;
    this.disconnected = lost;
    document.body.classList.toggle("lost", lost);
    if (!this.badge) return;
    if (!lost) this.hideBanner();
    else if (!this.player.loop || !this.player.ended) this.banner([LOST], "warn");
    else if (this.bannerBox.hidden) this.banner([LOOP_ENDED], "warn"); // else it says why
    this.buttons();
  }

  // --- the page -----------------------------------------------------------------------------

  build() {
    const { description } = this;
    const plain = !description.shapes.some((s) => s.kind !== "handle");
    document.body.classList.toggle("plain", plain);
    document.body.classList.toggle("realtime", Boolean(description.realtime));
    this.badge = el("span", { class: "badge" }, el("i"), el("span"));
    this.saving = new Saving(this);
    this.themeButton = button("moon", "Dark or light (T)", () => this.setTheme(this.theme === "dark" ? "light" : "dark"));
    const head = el(
      "header", {},
      el("span", { class: "mark" }, "bgc"),
      el("h1", {}, description.scene),
      el("span", { class: "of" }, [description.model, description.file].filter(Boolean).join(" · ")),
      el("span", { class: "space" }),
      this.views = el("div", { class: "views", role: "group", "aria-label": "View" }),
      this.badge,
      plain ? null : button("camera", "Save a picture (P)", () => this.saving.picture()),
      plain ? null : this.saving.videoButton,
      button("save", "Save a replay as one HTML file", () => this.saving.replay()),
      this.themeButton,
      button("panel", "Side panel (B)", () => this.toggleSide()),
      button("help", "Keys (?)", () => this.help.showModal()),
    );
    this.bannerBox = el("div", { class: "banner", hidden: true, role: "alert" });
    const plots = el("div", { class: "plots" });
    this.main = el("main", {}, this.bannerBox);
    this.chosen = el("div", { class: "chosen", hidden: true });
    const parametersTab = el("div", { class: "tab" }, this.chosen);
    this.side = el("aside", { "aria-label": "Side panel" });
    const isOwnClock = this.live && !description.realtime;
    const hasGraph = isOwnClock && this.source.hasGraph;
    const tabs = this.live ? [["Parameters", parametersTab]] : [];
    document.body.classList.toggle("swinging", Boolean(description.modes));
    if (plain) {
      Object.assign(plots, { tabIndex: 0 }).setAttribute("role", "region");
      plots.setAttribute("aria-label", "Plots");
      this.main.append(plots);
    } else if (description.modes) {
      const modesTab = el("div", { class: "tab" });
      tabs.push(["Modes", modesTab]);
      this.modes = new Modes(modesTab, description, ({ first }) => {
        this.time = first;
        this.player.playing = true;
        this.buttons();
      });
    } else {
      plots.classList.add("tab");
      tabs.unshift(["Plots", plots]);
    }
    if (this.live && this.source.hasSlots) {
      const slotsTab = el("div", { class: "tab" });
      tabs.push(["Slots", slotsTab, () => this.askGraph()]);
      this.slots = new Slots(slotsTab, (slot, part) => this.source.send("use", { slot, part }));
    }
    if (hasGraph) {
      this.graph = new GraphView(this.main, { part: (path) => this.choosePart(path), ask: () => this.askGraph() });
    }
    this.side.append(...tabs.map(([, body]) => body));
    if (tabs.length > 1 || description.modes) this.side.prepend((this.tabs = new Tabs(tabs)).root);
    this.side.hidden = plain && !description.parameters.length && !hasGraph;
    document.body.classList.toggle("hidden-side", this.side.hidden);
    this.help = helpOf({ scene: !plain, graph: hasGraph, clock: !description.realtime });
    document.body.append(el("div", { id: "app" }, head, this.main, this.side, this.transport()), this.help);
    this.plots = new Plots(plots, description, this.store, (time) => this.seek(time));
    if (description.realtime) parametersTab.append(el("p", { class: "note" }, "In real time a value holds from the next reset (R): the force falls to zero, the model starts again, and the force rises."));
    if (this.live && description.parameters.length) {
      this.parameters = new Parameters(parametersTab, description, (name, value) => this.source.send("set", { name, value }));
    } else {
      parametersTab.append(el("p", { class: "none" }, this.live ? "The scene has no parameters that can change while it runs." : "A recorded run has no parameters to change."));
    }
    this.buildViews(plain);
    if (!plain) this.buildStage();
    if (isOwnClock && !plain) this.main.append(this.hint = el("div", { class: "glass hint" }, description.devices?.some((d) => d.free) ? "Drag the grip, or press Space" : "Press Space to start"));
    this.devices = new Devices({ ...this, began: () => this.goOn() });
    listenToKeys(this);
  }

  // The scene, and the bond graph where the source has it.
  buildViews(plain) {
    if (!this.graph) return;
    const names = [[plain ? "Plots" : "Scene", "scene"], ["Bond graph", "graph"]];
    this.views.replaceChildren(...names.map(([text, name]) => el("button", { type: "button", title: `${text} (G)`, onclick: () => this.look(name) }, text)));
    this.look("scene");
  }

  look(name) {
    this.viewed = name;
    [...this.views.children].forEach((b, k) => b.setAttribute("aria-pressed", (k === 1) === (name === "graph")));
    document.body.classList.toggle("graph-shown", name === "graph");
    this.graph.show(name === "graph");
    this.source.send("watch", { value: name === "graph" });
  }

  // The graph and the slots are compiled when they are first needed.
  askGraph() {
    if (this.askedGraph || !this.source.hasGraph || !this.live) return;
    this.askedGraph = true;
    this.source.send("graph");
  }

  // Shows what is being compiled beside the run. What was given up for something else is asked again.
  waitFor(busy) {
    this.slots?.wait(busy === "model");
    if (busy === "" && this.player.busy && this.askedGraph && this.graph && !this.graph.graph) {
      this.askedGraph = false;
      if (this.player.busy === "model") this.askGraph();
      else this.graph.fail();
    }
  }

  takeGraph(graph) {
    this.graph?.take(graph);
    this.slots?.take(graph.slots);
    if (this.marked != null) this.showSource(this.marked);
  }

  // Shows the parameters of a part or an element, and where it is declared.
  choosePart(path) {
    this.marked = path;
    this.stage?.mark(path);
    this.parameters?.pick(path);
    this.showSource(path);
    if (path != null) this.tabs?.choose(this.tabs.find("Parameters"));
  }

  showSource(path) {
    const found = path != null && this.graph?.graph ? this.graph.source(path) : null;
    this.chosen.hidden = !found;
    if (found) this.chosen.replaceChildren(el("b", {}, path || this.description.model), el("small", {}, ` ${found.what ?? ""}`), sourceBlock(found.line) ?? "");
    if (path != null && this.graph) this.askGraph();
  }

  buildStage() {
    const { description } = this;
    try {
      const quality = new URLSearchParams(location.search).get("quality");
      this.stage = new Stage(this.main, description, (k) => this.meshAddress(k), quality, (file, why) => this.lostMesh(file, why));
    } catch (problem) {
      this.main.append(el("p", { class: "none" }, `This browser cannot draw in 3D (${problem.message}). Plots and controls work.`));
      return;
    }
    const views = [["Overview", "overview"], ["Front", "front"], ["Side", "side"], ["Above", "above"]];
    this.main.append(
      el("div", { class: "glass cameras" },
        ...views.map(([text, name], k) => el("button", { type: "button", title: `${text} (${k + 1})`, onclick: () => this.stage.look(name) }, text))),
    );
    this.tip = el("div", { class: "glass tip", hidden: true });
    this.main.append(this.tip);
    this.axes = new Axes(this.main, this.stage);
    const { canvas } = this.stage;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${description.scene} in 3D; the arrow keys turn the view`);
    canvas.addEventListener("pointermove", (event) => this.hover(event));
    canvas.addEventListener("pointerleave", () => (this.tip.hidden = true));
    let down = null;
    canvas.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4) this.mark(event);
    });
  }

  // The address of a file of a mesh: in this page, or on the server.
  meshAddress(k) {
    return this.meshes?.[k] ?? `mesh/${k}${location.search}`;
  }

  // Says that a mesh is not drawn.
  lostMesh(file, why) {
    (this.lostMeshes ??= []).push({ code: "", text: `The mesh ${file} is not drawn: ${why}.`, help: "" });
    this.banner(this.lostMeshes, "warn");
  }

  // Goes on from the present where the run stands still.
  goOn() {
    this.scrubbed = null;
    if (!this.player.playing && this.player.ready) this.source.send("play");
  }

  // --- what the user does -------------------------------------------------------------------

  hover(event) {
    const shape = event.buttons || this.devices.isGripped ? null : this.stage.pick(event.clientX, event.clientY);
    this.tip.hidden = !shape;
    if (!shape) return;
    const place = this.main.getBoundingClientRect();
    this.tip.textContent = shape.part || shape.name;
    this.tip.style.left = `${Math.min(event.clientX - place.left, place.width - 180)}px`;
    this.tip.style.top = `${event.clientY - place.top}px`;
  }

  // A click on a part marks it and shows its parameters; another one beside it ends that.
  mark(event) {
    const shape = this.stage.pick(event.clientX, event.clientY);
    this.choosePart(shape && shape.part !== this.marked ? shape.part : null);
  }

  followMarked() {
    if (this.marked != null) this.stage.followPart(this.marked);
  }

  toggleSide() {
    document.body.classList.toggle("hidden-side");
  }

  setTheme(name) {
    this.theme = name;
    remember("theme", name);
    document.documentElement.dataset.theme = name;
    this.themeButton.replaceChildren(icon(name === "dark" ? "sun" : "moon"));
    this.stage?.theme(name);
    this.plots.theme(name);
    this.plotted = 0;
  }

  // --- messages -----------------------------------------------------------------------------

  banner(messages, kind) {
    this.bannerBox.className = `banner ${kind}`;
    this.bannerBox.replaceChildren(
      el("div", {}, ...messages.flatMap((m) => [
        el("p", {}, m.code ? el("b", {}, `${m.code} `) : null, m.text),
        m.excerpt ? el("pre", {}, m.excerpt) : null,
        m.help ? el("p", {}, m.help) : null,
      ].filter(Boolean))),
      button("close", "Close", () => this.hideBanner()),
    );
    this.bannerBox.hidden = false;
  }

  hideBanner() {
    if (this.bannerBox) this.bannerBox.hidden = true;
  }

  // --- drawing ------------------------------------------------------------------------------

  loop(now) {
    requestAnimationFrame((next) => this.loop(next));
    const frame = now - (this.before ?? now); // ms
    const past = Math.min(0.1, frame / 1000);
    // Where frames are slow, plots of one frame each would show times that are seconds apart.
    const share = frame / SPREAD;
    this.before = now;
    this.advance(past);
    const time = this.shownTime();
    this.devices.tick(past);
    if (this.store.sample(time, this.row)) {
      this.stage?.show(this.row, time);
      this.devices.update(this.row);
    }
    if (!this.graph?.shown || this.saving.video) {
      this.stage?.draw();
      this.axes?.update();
    }
    this.watch(now);
    if (now - this.plotted > PLOTTING) {
      this.plotted = now;
      this.drawPlots(time, share);
    } else this.plots.next(share);
    this.frames++;
  }

  drawPlots(time, share) {
    const last = Math.max(this.store.last, 0);
    const length = this.live ? this.description.duration ?? 10 : last;
    const end = this.live ? Math.max(1.02 * last, length / 6) : last || 1;
    this.showTime(time, last, end);
    const first = this.live && end > 120 * this.unit.factor && end > 2 * length ? Math.max(0, end - Math.max(length, 60)) : this.live ? 0 : this.store.first;
    this.plots.update([first, end], this.row, time, share);
  }

  // Eases the drawing where frames take longer than 45 ms for a second.
  watch(now) {
    if (!this.stage || document.hidden) return;
    this.late ??= { since: now, frames: 0 };
    this.late.frames++;
    if (now - this.late.since < 1000 || this.late.frames < 3) return;
    const mean = (now - this.late.since) / this.late.frames;
    if (mean > 45 && this.frames > 3) this.stage.ease();
    this.late = { since: now, frames: 0 };
  }

}

const view = new Page();
// For scripts that drive the page.
window.bgcView = view;
view.TIMES = TIMES;
