// Bundles the page into one script. Usage: node bundle.mjs OUTFILE
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";
import esbuild from "esbuild";

const here = path.dirname(fileURLToPath(import.meta.url));
const target = process.argv[2] ?? path.join(here, "..", "static", "view.js");

// The licences of what the bundle contains travel with it.
const require = createRequire(import.meta.url);
const notices = [];
for (const name of ["three", "uplot"]) {
  let folder = path.dirname(require.resolve(name));
  while (path.basename(folder) !== name) folder = path.dirname(folder);
  const licence = await readFile(path.join(folder, "LICENSE"), "utf8");
  notices.push(`${name}\n\n${licence.trim()}`);
}

const common = { bundle: true, minify: true, format: "iife", target: "es2022", charset: "utf8", logLevel: "warning" };

// `engine:worker` is the text of the script of a worker, bundled by itself.
const worker = {
  name: "worker",
  setup(build) {
    build.onResolve({ filter: /^engine:worker$/ }, ({ path: name }) => ({ path: name, namespace: "engine" }));
    build.onLoad({ filter: /.*/, namespace: "engine" }, async () => {
      const entryPoints = [path.join(here, "src", "worker.js")];
      const { outputFiles } = await esbuild.build({ ...common, entryPoints, write: false });
      return { contents: outputFiles[0].text, loader: "text" };
    });
  },
};

await esbuild.build({
  ...common,
  entryPoints: [path.join(here, "src", "main.js")],
  outfile: target,
  plugins: [worker],
  loader: { ".css": "text" },
  legalComments: "none",
  footer: { js: `/*! This script contains:\n\n${notices.join("\n\n")}\n*/` },
});
