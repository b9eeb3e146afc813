// Starts `tracerisk lsp`, and asks for the words that its quick fixes need.
"use strict";

const vscode = require("vscode");
const { LanguageClient, TransportKind } = require("vscode-languageclient/node");
const { commandOf } = require("./command");

const SELECTOR = [
  { scheme: "file", language: "python" },
  { scheme: "file", language: "c" },
  { scheme: "file", language: "cpp" },
  { scheme: "file", language: "yaml" },
];

let client;

async function activate(context) {
  const register = (name, run) =>
    context.subscriptions.push(vscode.commands.registerCommand(name, run));
  register("tracerisk.restart", restart);
  register("tracerisk.refreshActive", refreshActive);
  register("tracerisk.pinActive", pinActive);
  register("tracerisk.pinWithReason", pinWithReason);
  register("tracerisk.acceptWithReason", acceptWithReason);
  context.subscriptions.push(
    vscode.workspace.onDidChangeConfiguration((change) => {
      if (change.affectsConfiguration("tracerisk.command")) return restart();
      return undefined;
    })
  );
  await start();
}

async function deactivate() {
  await client?.stop();
}

async function start() {
  const given = vscode.workspace.getConfiguration("tracerisk").get("command");
  const [command, ...args] = commandOf(given, await selectedPython());
  client = new LanguageClient(
    "tracerisk",
    "tracerisk",
    { command, args, transport: TransportKind.stdio },
    {
      documentSelector: SELECTOR,
      initializationOptions: { asksForReasons: true },
      outputChannelName: "tracerisk",
    }
  );
  try {
    await client.start();
  } catch (error) {
    client = undefined;
    const told = `tracerisk: \`${command} lsp\` does not start (${error.message ?? error}); `;
    vscode.window.showErrorMessage(
      `${told}install it with: pip install 'tracerisk[lsp,sim]', or set tracerisk.command`
    );
  }
}

async function restart() {
  await client?.stop();
  await start();
}

/** The Python that is selected in this window, by the extension that knows. */
async function selectedPython() {
  const python = vscode.extensions.getExtension("ms-python.python");
  if (python === undefined) return undefined;
  try {
    const found = await python.activate();
    return found?.environments?.getActiveEnvironmentPath?.()?.path;
  } catch {
    return undefined;
  }
}

async function refreshActive() {
  const editor = vscode.window.activeTextEditor;
  if (editor === undefined) return;
  await editor.document.save();
  await ask("tracerisk.refresh", editor.document.uri.toString());
}

async function pinActive() {
  const editor = vscode.window.activeTextEditor;
  if (editor === undefined) return;
  await pinWithReason(editor.document.uri.toString(), editor.selection.active.line);
}

async function pinWithReason(uri, line) {
  const reason = await words("Why is this value set by hand?");
  if (reason !== undefined) await ask("tracerisk.pin", uri, line, reason);
}

async function acceptWithReason(uri, code, ofFunction, thing) {
  const reason = await words(`Why is ${code} accepted?`);
  if (reason !== undefined) await ask("tracerisk.accept", uri, code, ofFunction, thing, reason);
}

function words(prompt) {
  return vscode.window.showInputBox({
    prompt,
    ignoreFocusOut: true,
    validateInput: (text) => (text.trim() === "" ? "say why" : undefined),
  });
}

async function ask(command, ...args) {
  await client?.sendRequest("workspace/executeCommand", { command, arguments: args });
}

module.exports = { activate, deactivate };
