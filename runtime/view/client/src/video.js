// A video of the canvas, as the browser encodes it: WebM, or MP4 where it has no WebM.

const TYPES = ["video/webm;codecs=vp9", "video/webm", "video/mp4"];
const BITS = 8e6; // a second

export class Video {
  static get type() {
    return TYPES.find((type) => globalThis.MediaRecorder?.isTypeSupported(type));
  }

  // `done` gets the video and the ending of its file.
  // `failed` gets the reason where the browser cannot go on; what was recorded until then is kept.
  constructor(canvas, done, failed) {
    const type = Video.type;
    const parts = [];
    this.began = performance.now();
    this.stream = canvas.captureStream(60);
    this.recorder = new MediaRecorder(this.stream, { mimeType: type, videoBitsPerSecond: BITS });
    this.recorder.ondataavailable = ({ data }) => data.size && parts.push(data);
    this.recorder.onerror = ({ error }) => failed(error);
    this.recorder.onstop = () => {
      this.stream.getTracks().forEach((track) => track.stop());
      const plain = type.split(";")[0];
      done(new Blob(parts, { type: plain }), plain.split("/")[1]);
    };
    this.recorder.start(1000); // in parts of a second, so that little is lost
  }

  get seconds() {
    return (performance.now() - this.began) / 1000;
  }

  stop() {
    if (this.recorder.state !== "inactive") this.recorder.stop();
  }
}
