// A recorded run in the page itself, and the page that holds one.

import { Source } from "./source.js";

export class ReplaySource extends Source {
  constructor(on, held) {
    super(on);
    this.held = held;
  }

  async start() {
    this.on.scene(await readReplay(JSON.parse(this.held.textContent)));
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
