// The connection to `bgc view`, or the recorded run in the page itself.

const NEW_ROWS = 1;
const HEADER = 24;

export class Link {
  // `on` has functions for scene, rows, state, values, fault and lost.
  constructor(on) {
    this.on = on;
    this.wait = 300;
    this.socket = null;
  }

  start() {
    const held = document.getElementById("replay");
    if (held) readReplay(JSON.parse(held.textContent)).then(this.on.scene);
    else this.open();
  }

  open() {
    const address = `ws://${location.host}/ws${location.search}`;
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = (event) => this.take(event.data);
    this.socket.onclose = () => {
      this.on.lost(true);
      setTimeout(() => this.open(), this.wait);
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
    this.on.rows({
      whole: kind !== NEW_ROWS,
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

async function readReplay({ description, rows, data, meshes }) {
  const packed = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const columns = new Float32Array(await new Response(stream).arrayBuffer());
  const width = rows ? columns.length / rows : 0;
  const table = new Float32Array(columns.length);
  for (let column = 0; column < width; column++) {
    for (let row = 0; row < rows; row++) table[row * width + column] = columns[column * rows + row];
  }
  return { description, live: false, meshes, rows: table, count: rows };
}

// The page of a replay as text: this page's own script and the rows that it has.
export async function replayPage(description, store, meshes) {
  const { width, count, data } = store;
  const columns = new Float32Array(width * count);
  for (let row = 0; row < count; row++) {
    for (let column = 0; column < width; column++) {
      columns[column * count + row] = data[row * width + column];
    }
  }
  const stream = new Blob([columns]).stream().pipeThrough(new CompressionStream("deflate"));
  const packed = new Uint8Array(await new Response(stream).arrayBuffer());
  let text = "";
  for (let at = 0; at < packed.length; at += 32768) {
    text += String.fromCharCode(...packed.subarray(at, at + 32768));
  }
  const recorded = { ...description, parameters: [], folded: [], duration: store.last };
  const content = { description: recorded, rows: count, data: btoa(text), meshes };
  const replay = JSON.stringify(content).replaceAll("<", "\\u003c");
  const script = [...document.scripts].find((s) => s.type !== "application/json").textContent;
  return (
    `<!doctype html><html lang="en"><head><meta charset="utf-8">` +
    `<meta name="viewport" content="width=device-width, initial-scale=1">` +
    `<title>${document.title}</title>${document.querySelector("link[rel=icon]").outerHTML}</head><body>` +
    `<script type="application/json" id="replay">${replay}</script>` +
    `<script>${script}</script></body></html>`
  );
}
