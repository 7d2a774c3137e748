// The worker in which the model of a page runs.

import { serve } from "./engine.js";

const take = serve((kind, content) => {
  self.postMessage({ kind, content }, content.rows ? [content.rows.buffer] : []);
});
self.onmessage = ({ data }) => take(data);
