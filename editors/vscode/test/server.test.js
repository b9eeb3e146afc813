// The server, driven by the protocol of the client that the extension uses.
"use strict";

const assert = require("node:assert");
const { spawn } = require("node:child_process");
const fs = require("node:fs");
const os = require("node:os");
const path = require("node:path");
const test = require("node:test");
const { pathToFileURL } = require("node:url");
const rpc = require("vscode-languageserver-protocol/node");

const SOURCE = `def pick(arm):
    # | RiskAnnotation
    # | @Function {
    # |   name = pick
    # |   callSequence = 1
    # |   next = done 1
    # | }
    # | @Component {
    # |   name = gripper
    # |   probability = 1e-07
    # |   quantity = 1
    # |   redundancy = false
    # | }
    arm.go()
`;

async function withServer(run) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "tracerisk-"));
  const server = spawn(process.env.TRACERISK ?? "tracerisk", ["lsp"], { cwd: folder });
  const connection = rpc.createProtocolConnection(
    new rpc.StreamMessageReader(server.stdout),
    new rpc.StreamMessageWriter(server.stdin)
  );
  const ended = new Promise((resolve) => server.once("exit", resolve));
  connection.listen();
  try {
    const started = await connection.sendRequest(rpc.InitializeRequest.type, {
      processId: process.pid,
      rootUri: pathToFileURL(folder).href,
      capabilities: {},
      initializationOptions: { asksForReasons: true },
    });
    await connection.sendNotification(rpc.InitializedNotification.type, {});
    await run(connection, folder, started);
    await connection.sendRequest(rpc.ShutdownRequest.type);
    await connection.sendNotification(rpc.ExitNotification.type);
    assert.strictEqual(await ended, 0);
  } finally {
    connection.dispose();
    server.kill();
    fs.rmSync(folder, { recursive: true });
  }
}

test("figures, findings, folding and fixes come over the protocol", async () => {
  await withServer(async (connection, folder, started) => {
    const file = path.join(folder, "cell.py");
    fs.writeFileSync(file, SOURCE);
    const uri = pathToFileURL(file).href;
    const published = new Promise((resolve) =>
      connection.onNotification(rpc.PublishDiagnosticsNotification.type, resolve)
    );
    await connection.sendNotification(rpc.DidOpenTextDocumentNotification.type, {
      textDocument: { uri, languageId: "python", version: 1, text: SOURCE },
    });
    const { diagnostics } = await published;
    assert.deepStrictEqual(diagnostics.map((each) => each.code), ["unknown"]);
    const textDocument = { uri };
    const hover = await connection.sendRequest(rpc.HoverRequest.type, {
      textDocument,
      position: { line: 0, character: 5 },
    });
    assert.match(hover.contents.value, /\*\*pick\*\*: 100 %/);
    const lenses = await connection.sendRequest(rpc.CodeLensRequest.type, { textDocument });
    assert.ok(lenses.some((each) => each.command.title.startsWith("100 %")));
    const folds = await connection.sendRequest(rpc.FoldingRangeRequest.type, { textDocument });
    assert.deepStrictEqual(
      folds.map((each) => [each.startLine, each.endLine]),
      [[1, 12], [2, 6], [7, 12]]
    );
    const actions = await connection.sendRequest(rpc.CodeActionRequest.type, {
      textDocument,
      range: { start: { line: 9, character: 0 }, end: { line: 9, character: 0 } },
      context: { diagnostics: [] },
    });
    const asked = actions.map((each) => each.command.command);
    assert.deepStrictEqual(asked, ["tracerisk.pinWithReason"]);
    const extension = fs.readFileSync(path.join(__dirname, "../src/extension.js"), "utf8");
    for (const name of asked) assert.ok(extension.includes(`register("${name}"`));
    const offered = started.capabilities.executeCommandProvider.commands;
    for (const name of ["tracerisk.refresh", "tracerisk.pin", "tracerisk.accept"]) {
      assert.ok(offered.includes(name));
      assert.ok(extension.includes(`ask("${name}"`));
    }
    const edit = new Promise((resolve) =>
      connection.onRequest(rpc.ApplyWorkspaceEditRequest.type, (params) => {
        resolve(params.edit.changes[uri]);
        return { applied: true };
      })
    );
    const done = await connection.sendRequest(rpc.ExecuteCommandRequest.type, {
      command: "tracerisk.pin",
      arguments: [uri, 9, "measured"],
    });
    assert.strictEqual(done, true);
    assert.strictEqual((await edit)[0].newText, "    # |   probability := 1e-07 ! measured");
  });
});
