// The bond graph of a .bg file beside its text, drawn again when a file is saved.
"use strict";

const { ViewColumn, window } = require("vscode");

class Graphs {
  // `ask` sends a request `bgc/graph` to the language server.
  constructor(ask) {
    this.ask = ask;
    this.panels = new Map(); // by the address of the document
  }

  async show(document) {
    if (document?.languageId !== "bg") {
      return window.showInformationMessage("bgc: open a .bg file to see its bond graph.");
    }
    const uri = document.uri.toString();
    const open = this.panels.get(uri);
    if (open) return open.panel.reveal(undefined, true);
    const title = `${document.uri.path.split("/").pop()}: bond graph`;
    const beside = { viewColumn: ViewColumn.Beside, preserveFocus: true };
    const panel = window.createWebviewPanel("bgc.graph", title, beside, { enableScripts: true });
    const shown = { panel, scene: null, depth: null };
    this.panels.set(uri, shown);
    panel.onDidDispose(() => this.panels.delete(uri));
    panel.webview.onDidReceiveMessage(({ scene, depth }) => {
      Object.assign(shown, { scene, depth });
      return this.draw(uri);
    });
    panel.webview.html = page(nonce());
    return this.draw(uri);
  }

  refresh() {
    return Promise.all([...this.panels.keys()].map((uri) => this.draw(uri)));
  }

  async draw(uri) {
    const shown = this.panels.get(uri);
    if (!shown) return;
    let found;
    try {
      found = await this.ask({ uri, scene: shown.scene, depth: shown.depth });
    } catch (problem) {
      found = { message: problem.message };
    }
    found ??= { message: "the language server is not running" };
    if (this.panels.has(uri)) await shown.panel.webview.postMessage(found);
  }

  dispose() {
    for (const { panel } of this.panels.values()) panel.dispose();
  }
}

function nonce() {
  return require("node:crypto").randomBytes(16).toString("base64");
}

// The picture keeps its place and size when it is drawn again; an error leaves the last one.
function page(key) {
  return `<!doctype html><html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; script-src 'nonce-${key}'">
<style>
  body { margin: 0; padding: 0; height: 100vh; display: flex; flex-direction: column; }
  nav { display: flex; gap: 8px; padding: 6px 10px; align-items: center; }
  select { color: var(--vscode-dropdown-foreground); background: var(--vscode-dropdown-background); border: 1px solid var(--vscode-dropdown-border); }
  #why { color: var(--vscode-errorForeground); }
  #picture { flex: 1; overflow: auto; background: white; }
</style></head><body>
<nav><select id="scene" aria-label="Scene"></select><select id="depth" aria-label="Depth"></select><span id="why" role="alert"></span></nav>
<div id="picture"></div>
<script nonce="${key}">
  const api = acquireVsCodeApi();
  const [scene, depth, why, picture] = ["scene", "depth", "why", "picture"].map((id) => document.getElementById(id));
  const option = (value, text, chosen) => Object.assign(document.createElement("option"), { value, textContent: text, selected: chosen });
  const ask = () => api.postMessage({ scene: scene.value || null, depth: Number(depth.value) < 0 ? 99 : Number(depth.value) });
  scene.onchange = depth.onchange = ask;
  addEventListener("message", ({ data: found }) => {
    why.textContent = found.message ?? "";
    if (!found.svg) return;
    const parsed = new DOMParser().parseFromString(found.svg, "image/svg+xml").documentElement;
    picture.replaceChildren(document.importNode(parsed, true));
    scene.replaceChildren(...found.scenes.map((name) => option(name, name, name === found.scene)));
    scene.hidden = found.scenes.length < 2;
    const levels = [...Array(found.depths).keys()].map((k) => option(k, k ? k + " level" + (k > 1 ? "s" : "") : "outermost parts", k === found.depth));
    depth.replaceChildren(option(-1, "all elements", found.depth < 0 || found.depth >= found.depths), ...levels);
    depth.hidden = !found.depths;
  });
</script></body></html>`;
}

module.exports = { Graphs };
