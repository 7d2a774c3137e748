// What the page saves as files: a picture, a video, and the run so far as one HTML file.

import { button, download } from "./dom.js";
import { replayPage } from "./replay.js";
import { Video } from "./video.js";

const [RECORD, END] = ["Record a video (V)", "End the video and save it (V)"];

export class Saving {
  // Of the page it needs `stage`, `store`, `description`, `meshAddress` and `banner`.
  constructor(page) {
    this.page = page;
    this.video = null;
    this.videoButton = Video.type ? button("record", RECORD, () => this.toggleVideo()) : null;
  }

  name(ending) {
    return `${this.page.description.scene}.${ending}`;
  }

  picture() {
    const { stage } = this.page;
    if (stage) this.keep("picture", async () => download(this.name("png"), await stage.picture()));
  }

  // Records what the scene shows until it is called again.
  toggleVideo() {
    const { stage } = this.page;
    if (!stage || !Video.type) return;
    if (this.video) return this.video.stop();
    const done = (blob, ending) => {
      this.show(null);
      download(this.name(ending), blob);
    };
    this.keep("video", () => this.show(new Video(stage.canvas, done, (problem) => this.fail("video", problem))));
  }

  show(video) {
    this.video = video;
    this.videoButton.classList.toggle("on", Boolean(video));
    this.videoButton.title = video ? END : RECORD;
    this.videoButton.setAttribute("aria-label", this.videoButton.title);
  }

  replay() {
    return this.keep("replay", async () => {
      const { description, store } = this.page;
      const meshes = [];
      for (const { mesh } of description.shapes) if (mesh != null) meshes[mesh] ??= await this.meshData(mesh);
      const text = await replayPage(description, store, meshes);
      download(this.name("html"), new Blob([text], { type: "text/html" }));
    });
  }

  async meshData(k) {
    const blob = await (await fetch(this.page.meshAddress(k))).blob();
    return new Promise((done) => {
      const read = new FileReader();
      read.onload = () => done(read.result);
      read.readAsDataURL(blob);
    });
  }

  // Does what saves a file, and says why it failed: for lack of memory, or of room on the disk.
  async keep(what, work) {
    try {
      await work();
    } catch (problem) {
      this.fail(what, problem);
    }
  }

  fail(what, problem) {
    this.page.banner([{ text: `The ${what} could not be saved: ${problem?.message ?? "the browser gives no reason"}.` }], "warn");
  }
}
