// Starts `bgc lsp` for .bg files, and again when its command is changed in the settings.
"use strict";

const { commands, window, workspace } = require("vscode");
const { Graphs } = require("./graph.js");
const { LanguageClient, TransportKind } = require("vscode-languageclient/node");

const HELP =
  'bgc: the language server could not be started. Install it (pip install "bgc-lang[lsp]"), ' +
  "or set bgc.command to its path.";

let client;

async function start() {
  const command = workspace.getConfiguration("bgc").get("command", "bgc");
  const server = { command, args: ["lsp"], transport: TransportKind.stdio };
  client = new LanguageClient("bgc", "bgc", server, {
    documentSelector: [{ language: "bg" }],
    synchronize: { fileEvents: workspace.createFileSystemWatcher("**/*.bg") },
  });
  try {
    await client.start();
  } catch {
    client = undefined;
    window.showErrorMessage(HELP);
  }
}

async function stop() {
  const running = client;
  client = undefined;
  await running?.stop();
}

async function restart() {
  await stop();
  await start();
}

exports.activate = async (context) => {
  const graphs = new Graphs((question) => client?.sendRequest("bgc/graph", question));
  context.subscriptions.push(
    commands.registerCommand("bgc.restart", restart),
    commands.registerCommand("bgc.showGraph", () => graphs.show(window.activeTextEditor?.document)),
    workspace.onDidSaveTextDocument(() => graphs.refresh()),
    graphs,
    workspace.onDidChangeConfiguration((change) => {
      if (change.affectsConfiguration("bgc.command")) return restart();
    }),
  );
  await start();
};

exports.deactivate = stop;
