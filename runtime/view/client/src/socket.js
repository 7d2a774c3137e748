// The run of `bgc view`, over a websocket; runtime/view/protocol.py describes the messages.

import { Source } from "./source.js";
import { TIMES } from "./store.js";

const [NEW_ROWS, ALL_ROWS, POWERS] = [1, 2, 3];
const HEADER = 24;

export class SocketSource extends Source {
  constructor(on) {
    super(on);
    this.hasGraph = this.hasSlots = true;
    this.wait = 300;
    this.socket = null;
  }

  start() {
    const address = `ws://${location.host}/ws${location.search}`;
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = (event) => this.take(event.data);
    this.socket.onclose = () => {
      this.on.lost(true);
      setTimeout(() => this.start(), this.wait);
      this.wait = Math.min(3000, 1.5 * this.wait);
    };
  }

  take(data) {
    if (typeof data !== "string") return this.takeRows(data);
    const { type, ...content } = JSON.parse(data);
    if (type === "scene") {
      this.wait = 300;
      this.on.lost(false);
    }
    this.on[type]?.(content);
  }

  takeRows(data) {
    const head = new DataView(data);
    const [kind, epoch, count] = [0, 4, 8].map((at) => head.getUint32(at, true));
    if (kind === POWERS) return this.on.powers({ epoch, values: new Float32Array(data, HEADER).subarray(TIMES) });
    this.on.rows({
      whole: kind === ALL_ROWS,
      epoch,
      count,
      rows: new Float32Array(data, HEADER),
    });
  }

  send(type, content = {}) {
    if (this.socket?.readyState === WebSocket.OPEN) {
      this.socket.send(JSON.stringify({ type, ...content }));
    }
  }
}
