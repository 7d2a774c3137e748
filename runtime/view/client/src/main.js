// The page of `bgc view`: a live run or a recorded one.

import uplotStyle from "uplot/dist/uPlot.min.css";
import { Devices } from "./devices.js";
import { button, download, el, icon, timeUnit } from "./dom.js";
import { GraphView, Slots, sourceBlock } from "./graph.js";
import { helpOf, onKey } from "./keys.js";
import { cameBack, comeBack, remember, remembered } from "./memory.js";
import { Modes } from "./modes.js";
import { Parameters } from "./parameters.js";
import { Playback, replaySpeed } from "./playback.js";
import { Plots } from "./plots.js";
import { replayPage } from "./replay.js";
import { openSource } from "./sources.js";
import { Stage } from "./stage.js";
import { Store, TIMES } from "./store.js";
import { Video } from "./video.js";
import style from "./style.css";

const PLOTTING = 70; // ms between two drawings of the plots

document.head.append(el("style", {}, uplotStyle + style));

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

  scene({ description, live, meshes, rows, count }) {
    if (this.description) {
      // A page that has connected again keeps its view; another model has another page.
      if (JSON.stringify(this.description) !== JSON.stringify(description)) {
        return comeBack({ view: this.viewed, tab: this.tab });
      }
      this.askedGraph = false;
      if (this.graph?.shown) this.source.send("watch", { value: true });
      return;
    }
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
      this.modes?.choose(0);
      if (description.message) this.banner([{ code: "", text: description.message, help: "" }], "warn");
    }
    this.setTheme(this.theme);
    this.buttons();
    const { view, tab } = live ? cameBack() : {};
    if (view === "graph" && this.graph) this.look(view);
    if (tab) this.chooseTab?.(tab, true);
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

  state(state) {
    if (state.playing && !this.player.playing) this.hideBanner();
    this.waitFor(state.busy ?? "");
    const reset = state.epoch !== this.player.epoch;
    this.player = state;
    this.devices?.state(state, reset);
    this.buttons();
  }

  fault({ messages, stopped, time }) {
    const at = stopped ? ` (${this.timeText(time)})` : "";
    this.banner(messages.map((m, k) => (k ? m : { ...m, text: m.text + at })), stopped ? "bad" : "warn");
  }

  lost(lost) {
    this.disconnected = lost;
    document.body.classList.toggle("lost", lost);
    if (!this.badge) return;
    this.buttons();
  }

  // --- the page -----------------------------------------------------------------------------

  build() {
    const { description } = this;
    const plain = !description.shapes.some((s) => s.kind !== "handle");
    document.body.classList.toggle("plain", plain);
    this.badge = el("span", { class: "badge" }, el("i"), el("span"));
    this.themeButton = button("moon", "Dark or light (T)", () => this.setTheme(this.theme === "dark" ? "light" : "dark"));
    const head = el(
      "header", {},
      el("span", { class: "mark" }, "bgc"),
      el("span", { class: "title" }, description.scene),
      el("span", { class: "of" }, [description.model, description.file].filter(Boolean).join(" · ")),
      el("span", { class: "space" }),
      this.views = el("div", { class: "views", role: "group", "aria-label": "View" }),
      this.badge,
      plain ? null : button("camera", "Save a picture (P)", () => this.picture()),
      plain || !Video.type ? null : (this.videoButton = button("record", "Record a video (V)", () => this.toggleVideo())),
      button("save", "Save a replay as one HTML file", () => this.saveReplay()),
      this.themeButton,
      button("panel", "Side panel (B)", () => this.toggleSide()),
      button("help", "Keys (?)", () => this.help.showModal()),
    );
    this.bannerBox = el("div", { class: "banner", hidden: true, role: "alert" });
    const plots = el("div", { class: "plots" });
    this.main = el("main", {}, this.bannerBox);
    this.chosen = el("div", { class: "chosen", hidden: true });
    const parametersTab = el("div", { class: "tab" }, this.chosen);
    this.side = el("aside");
    const hasGraph = this.live && this.source.hasGraph;
    const tabs = description.modes ? [] : [["Parameters", parametersTab]];
    document.body.classList.toggle("swinging", Boolean(description.modes));
    if (plain) this.main.append(plots);
    else if (description.modes) {
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
    if (hasGraph) {
      const slotsTab = el("div", { class: "tab" });
      tabs.push(["Slots", slotsTab, () => this.askGraph()]);
      this.slots = new Slots(slotsTab, (slot, part) => this.source.send("use", { slot, part }));
      this.graph = new GraphView(this.main, { part: (path) => this.choosePart(path), ask: () => this.askGraph() });
    }
    this.side.append(...(tabs.length > 1 ? [this.tabs(tabs)] : []), ...tabs.map(([, body]) => body));
    this.side.hidden = plain && !description.parameters.length && !hasGraph;
    document.body.classList.toggle("hidden-side", this.side.hidden);
    this.help = helpOf();
    document.body.append(el("div", { id: "app" }, head, this.main, this.side, this.transport()), this.help);
    this.plots = new Plots(plots, description, this.store, (time) => this.seek(time));
    if (this.live && description.parameters.length) {
      this.parameters = new Parameters(parametersTab, description, (name, value) => this.source.send("set", { name, value }));
    } else {
      parametersTab.append(el("p", { class: "none" }, this.live ? "The scene has no parameters that can change while it runs." : "A recorded run has no parameters to change."));
    }
    this.buildViews(plain);
    if (!plain) this.buildStage();
    this.devices = new Devices({ ...this, began: () => this.goOn() });
    addEventListener("keydown", (event) => onKey(this, event));
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
    if (path != null && this.parametersIndex != null) this.chooseTab(this.parametersIndex);
  }

  showSource(path) {
    const found = path != null && this.graph?.graph ? this.graph.source(path) : null;
    this.chosen.hidden = !found;
    if (found) this.chosen.replaceChildren(el("b", {}, path || this.description.model), el("small", {}, ` ${found.what ?? ""}`), sourceBlock(found.line) ?? "");
    if (path != null) this.askGraph();
  }

  buildStage() {
    const { description } = this;
    const address = (k) => this.meshes?.[k] ?? `mesh/${k}${location.search}`;
    try {
      const quality = new URLSearchParams(location.search).get("quality");
      this.stage = new Stage(this.main, description, address, quality);
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
    const { canvas } = this.stage;
    canvas.addEventListener("pointermove", (event) => this.hover(event));
    canvas.addEventListener("pointerleave", () => (this.tip.hidden = true));
    let down = null;
    canvas.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4) this.mark(event);
    });
  }

  // Goes on from the present where the run stands still.
  goOn() {
    this.scrubbed = null;
    if (!this.player.playing && this.player.ready) this.source.send("play");
  }

  tabs(list) {
    this.parametersIndex = list.findIndex(([text]) => text === "Parameters");
    const buttons = list.map(([text, body, opened], k) => {
      body.hidden = k > 0;
      return el("button", { type: "button", role: "tab", "aria-selected": String(k === 0), onclick: () => (choose(k), opened?.()) }, text);
    });
    const choose = (chosen, isBack = false) => {
      if (!list[chosen]) return;
      this.tab = chosen;
      if (isBack) list[chosen][2]?.();
      list.forEach(([, body], k) => {
        body.hidden = k !== chosen;
        buttons[k].setAttribute("aria-selected", k === chosen);
      });
      dispatchEvent(new Event("resize"));
    };
    this.chooseTab = choose;
    return el("div", { class: "tabs", role: "tablist" }, ...buttons);
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
    this.stamp = null;
  }

  async picture() {
    if (this.stage) download(`${this.description.scene}.png`, await this.stage.picture());
  }

  // Records what the scene shows until it is called again.
  toggleVideo() {
    if (!this.stage || !Video.type) return;
    if (this.video) return this.video.stop();
    this.video = new Video(this.stage.canvas, (blob, ending) => {
      this.video = null;
      this.videoButton.classList.remove("on");
      this.videoButton.title = "Record a video (V)";
      download(`${this.description.scene}.${ending}`, blob);
    });
    this.videoButton.classList.add("on");
    this.videoButton.title = "End the video and save it (V)";
  }

  async saveReplay() {
    const meshes = [];
    for (const shape of this.description.shapes) {
      if (shape.mesh != null) meshes[shape.mesh] ??= await this.meshData(shape.mesh);
    }
    const text = await replayPage(this.description, this.store, meshes);
    download(`${this.description.scene}.html`, new Blob([text], { type: "text/html" }));
  }

  async meshData(k) {
    const blob = await (await fetch(this.meshes?.[k] ?? `mesh/${k}${location.search}`)).blob();
    return new Promise((done) => {
      const read = new FileReader();
      read.onload = () => done(read.result);
      read.readAsDataURL(blob);
    });
  }

  // --- messages -----------------------------------------------------------------------------

  banner(messages, kind) {
    this.bannerBox.className = `banner ${kind}`;
    this.bannerBox.replaceChildren(
      el("div", {}, ...messages.flatMap((m) => [el("p", {}, m.code ? el("b", {}, `${m.code} `) : null, m.text), m.help ? el("p", {}, m.help) : null].filter(Boolean))),
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
    const past = Math.min(0.1, (now - (this.before ?? now)) / 1000);
    this.before = now;
    this.advance(past);
    const time = this.shownTime();
    this.devices.tick(past);
    if (this.store.sample(time, this.row)) {
      this.stage?.show(this.row, time);
      this.devices.update(this.row);
    }
    if (!this.graph?.shown || this.video) this.stage?.draw();
    this.watch(now);
    if (now - this.plotted > PLOTTING) {
      this.plotted = now;
      this.drawPlots(time);
    }
    this.frames++;
  }

  drawPlots(time) {
    const last = Math.max(this.store.last, 0);
    const length = this.live ? this.description.duration ?? 10 : last;
    const end = this.live ? Math.max(1.02 * last, length / 6) : last || 1;
    this.showTime(time, last, end);
    const first = this.live && end > 120 * this.unit.factor && end > 2 * length ? Math.max(0, end - Math.max(length, 60)) : this.live ? 0 : this.store.first;
    const stamp = [this.store.version, this.store.count, time, first, end].join();
    this.plots.update([first, end], this.row, time, stamp);
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
