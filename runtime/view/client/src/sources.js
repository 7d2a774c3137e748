// The source of this page's run: in the page itself, else the server.

import { ModelSource } from "./model.js";
import { ReplaySource } from "./replay.js";
import { SocketSource } from "./socket.js";

export function openSource(on) {
  const held = (kind) => document.getElementById(kind);
  if (held("model")) return new ModelSource(on, held("model"));
  return held("replay") ? new ReplaySource(on, held("replay")) : new SocketSource(on);
}
