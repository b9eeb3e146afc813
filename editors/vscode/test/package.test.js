// What the manifest says is what the extension does.
"use strict";

const assert = require("node:assert");
const fs = require("node:fs");
const path = require("node:path");
const test = require("node:test");
const oniguruma = require("vscode-oniguruma");
const textmate = require("vscode-textmate");

const ROOT = path.join(__dirname, "..");
const manifest = JSON.parse(fs.readFileSync(path.join(ROOT, "package.json"), "utf8"));
const source = fs.readFileSync(path.join(ROOT, "src/extension.js"), "utf8");

test("each command of the palette is registered", () => {
  const registered = [...source.matchAll(/register\("([\w.]+)"/g)].map((found) => found[1]);
  for (const { command } of manifest.contributes.commands) assert.ok(registered.includes(command));
});

test("the bundle needs nothing but the editor", () => {
  const bundle = fs.readFileSync(path.join(ROOT, manifest.main), "utf8");
  const needed = new Set([...bundle.matchAll(/\brequire\("([^"]+)"\)/g)].map((found) => found[1]));
  const builtin = new Set(require("node:module").builtinModules);
  const others = [...needed].filter((name) => !builtin.has(name.replace(/^node:/, "")));
  assert.deepStrictEqual(others, ["vscode"]);
});

async function scopesOf(text) {
  const wasm = fs.readFileSync(require.resolve("vscode-oniguruma/release/onig.wasm"));
  await oniguruma.loadWASM(wasm.buffer.slice(wasm.byteOffset, wasm.byteOffset + wasm.length));
  const host = {
    scopeName: "source.host",
    patterns: [{ begin: "#", end: "$", name: "comment.line" }],
  };
  const injected = JSON.parse(
    fs.readFileSync(path.join(ROOT, "syntaxes/block.tmLanguage.json"), "utf8")
  );
  const registry = new textmate.Registry({
    onigLib: Promise.resolve({
      createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
      createOnigString: (each) => new oniguruma.OnigString(each),
    }),
    loadGrammar: async (name) => (name === host.scopeName ? host : injected),
    getInjections: () => [injected.scopeName],
  });
  const grammar = await registry.loadGrammar(host.scopeName);
  let state = textmate.INITIAL;
  const found = {};
  for (const line of text.split("\n")) {
    const { tokens, ruleStack } = grammar.tokenizeLine(line, state);
    state = ruleStack;
    for (const { startIndex, endIndex, scopes } of tokens) {
      found[line.slice(startIndex, endIndex).trim()] = scopes.at(-1);
    }
  }
  return found;
}

test("the parts of a block are coloured apart", async () => {
  const found = await scopesOf(
    [
      "# | RiskAnnotation LGqLSD-LlScqh",
      "# | @Component := omit {",
      "# |   probability := 2.6e-09 ! computed 1e-9; why",
      "# |   next = act 1/2",
      "# plain words with name = x",
    ].join("\n")
  );
  assert.strictEqual(found.RiskAnnotation, "keyword.other.tracerisk");
  assert.strictEqual(found["LGqLSD-LlScqh"], "constant.other.digest.tracerisk");
  assert.strictEqual(found["@Component"], "storage.type.tracerisk");
  assert.strictEqual(found.probability, "variable.other.property.tracerisk");
  assert.strictEqual(found["2.6e-09"], "constant.numeric.tracerisk");
  assert.strictEqual(found["! computed 1e-9; why"], "string.unquoted.reason.tracerisk");
  assert.strictEqual(found["# plain words with name = x"] ?? "comment.line", "comment.line");
});

test("the parts of a compact block are coloured apart", async () => {
  const found = await scopesOf(
    [
      "# | RiskAnnotation LGqLSD-LlScqh",
      "# | act 1 -> done 1",
      "# | motor  := 2.6e-09  7  ! computed 1e-9; why",
      "# plain words with 7 of them",
    ].join("\n")
  );
  assert.strictEqual(found.act, "variable.other.property.tracerisk");
  assert.strictEqual(found["1 -> done 1"], "constant.numeric.tracerisk");
  assert.strictEqual(found.motor, "variable.other.property.tracerisk");
  assert.strictEqual(found[":="], "keyword.operator.by-hand.tracerisk");
  assert.strictEqual(found["2.6e-09  7"], "constant.numeric.tracerisk");
  assert.strictEqual(found["! computed 1e-9; why"], "string.unquoted.reason.tracerisk");
  assert.strictEqual(found["# plain words with 7 of them"] ?? "comment.line", "comment.line");
});
