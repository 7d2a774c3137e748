// The model of a page, in a worker or on the page's own thread: a run of its module, and the player.

import { Player } from "./player.js";
import { Run } from "./run.js";
import { compileModule } from "./wasm.js";

// Serves a page: `post(kind, content)` gets the events, and the returned function takes commands.
// The first command is `load` with the page's content and its module.
export function serve(post) {
  let player = null;
  const early = [];
  const load = async ({ content, packed, given, epoch }) => {
    try {
      const run = await Run.of(await compileModule(packed), content);
      for (const [k, value] of given) run.given.set(k, value);
      player = new Player(run, content, post, epoch);
      player.start();
      for (const command of early.splice(0)) player.command(command);
    } catch (problem) {
      const text = `this browser cannot run the model: ${problem.message}`;
      const help = "use a present version of Chrome, Edge, Firefox or Safari";
      post("fault", { messages: [{ code: "", text, help }], stopped: true, time: 0 });
    }
  };
  return (command) => {
    if (command.type === "load") load(command);
    else if (command.type === "close") player?.close();
    else if (player) player.command(command);
    else early.push(command);
  };
}
