"use strict";

const assert = require("node:assert");
const test = require("node:test");
const { commandOf } = require("../src/command");

test("the settings go before all", () => {
  const found = commandOf(["/opt/tracerisk", "-v"], "/venv/bin/python", () => true);
  assert.deepStrictEqual(found, ["/opt/tracerisk", "-v", "lsp"]);
});

test("the program beside the selected Python goes before the path", () => {
  const exists = (file) => file === "/venv/bin/tracerisk";
  assert.deepStrictEqual(commandOf([], "/venv/bin/python", exists), ["/venv/bin/tracerisk", "lsp"]);
  assert.deepStrictEqual(commandOf([], "/venv", exists), ["/venv/bin/tracerisk", "lsp"]);
});

test("without any it is the one on the path", () => {
  for (const python of [undefined, "", "/usr/bin/python3"]) {
    assert.deepStrictEqual(commandOf(undefined, python, () => false), ["tracerisk", "lsp"]);
  }
});
