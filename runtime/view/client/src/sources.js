// The source of this page's run: in the page itself, else the server.

import { ReplaySource } from "./replay.js";
import { SocketSource } from "./socket.js";

export function openSource(on) {
  const held = document.getElementById("replay");
  return held ? new ReplaySource(on, held) : new SocketSource(on);
}
