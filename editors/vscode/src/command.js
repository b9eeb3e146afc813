// Which program the language server is.
"use strict";

const fs = require("node:fs");
const path = require("node:path");

/**
 * The program and its arguments: what the settings give, else the `tracerisk` beside the selected
 * Python (or in its folder, where that is an environment), else the one on the path.
 */
function commandOf(given, python, exists = fs.existsSync) {
  if (Array.isArray(given) && given.length > 0) return [...given.map(String), "lsp"];
  const beside =
    typeof python === "string" && python !== ""
      ? [path.join(path.dirname(python), "tracerisk"), path.join(python, "bin", "tracerisk")]
      : [];
  return [beside.find((each) => exists(each)) ?? "tracerisk", "lsp"];
}

module.exports = { commandOf };
