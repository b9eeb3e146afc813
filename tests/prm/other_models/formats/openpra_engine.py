"""What the OpenPRA engine refuses of a request, said again in our own words.

From `targets/scram-node/src/ScramNodeModel.cpp`, `src/element.cc`, `src/event.cc`, `src/model.h`,
`src/fault_tree.cc` and `src/ccf_group.cc` of `packages/engine/scram` in openpra-monorepo as of
2026-01-09 (commit 3dc010e4).
"""

import json
import os
import subprocess
from collections import Counter

import pytest

from tests.prm.other_models.formats.models import solved_tops
from tracerisk.prm.other_models.formats.openpra import loads_openpra

ENGINE = os.environ.get("TRACERISK_OPENPRA_ENGINE", "")
"""Where the engine's module for Node.js is: `scram-node.node`, built from openpra-monorepo."""
needs_engine = pytest.mark.skipif(
    not ENGINE, reason="TRACERISK_OPENPRA_ENGINE names no scram-node.node"
)
SOLVE = """
const engine = require(process.argv[1]);
const models = JSON.parse(require("fs").readFileSync(0));
const settings = {bdd: true, probability: true};
const results = models.map(model => engine.QuantifyModel(settings, model).results);
console.log(JSON.stringify(results));
"""
"""A program of Node.js by which the engine solves models: from standard input, to its output."""


def engine_figures(request):
    """Return what the engine itself computes: by the names of fault trees, and of ends."""
    model = request["model"]
    # The engine's results of fault trees have no names, so each tree is a model by itself.
    trees = [{"name": "one", "faultTrees": [tree]} for tree in model["faultTrees"]]
    whole = [model] if model.get("eventTrees") else []
    solved = subprocess.run(
        ["node", "-e", SOLVE, ENGINE],
        input=json.dumps([*trees, *whole]),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert solved.returncode == 0, solved.stderr
    results = json.loads(solved.stdout)
    tops = {
        tree["name"]: result["sumOfProducts"][0]["probability"]
        for tree, result in zip(model["faultTrees"], results, strict=False)
    }
    ends = {
        sequence["name"]: sequence["value"]
        for result in results[len(trees) :]
        for initiating in result["initiatingEvents"]
        for sequence in initiating["sequences"]
    }
    return tops, ends


def check_by_engine(example, *sources):
    """Convert the sources of a mission; compare the engine's figures of it with ours."""
    assert example.run("convert", *sources, "-o", "openpra.json").code == 0
    text = example.read("openpra.json").decode()
    tops, _ = engine_figures(json.loads(text))
    ours = solved_tops(loads_openpra(text, "openpra.json"), 1.0)
    assert tops
    assert sorted(tops.values()) == pytest.approx(sorted(ours.values()), rel=1e-12)


def violations(request):
    """Return a line for each thing for which the engine would refuse a request or miss its sense."""
    model = request["model"]
    trees = model.get("faultTrees", [])
    found = [*_names(model, trees)]
    for tree in trees:
        found += _tree(tree)
    if model.get("ccfGroups"):
        found.append("a common cause group takes no member once it has its figure")
    figures = {}
    for tree in trees:
        for event in tree.get("basicEvents", ()):
            if figures.setdefault(event["name"], event["p"]) != event["p"]:
                found.append(f"only the first figure of {event['name']!r} counts")
    for tree in model.get("eventTrees", []):
        found += _event_tree(tree, {item["name"] for item in trees})
    return found


def _names(model, trees):
    """Every gate, event and house event is an element of the model, each with a name of its own."""
    ids = [tree["name"] for tree in trees]
    ids += {event["name"]: None for tree in trees for event in tree.get("basicEvents", ())}
    ids += [house["name"] for tree in trees for house in tree.get("houseEvents", ())]
    for tree in trees:
        ids += [f"{tree['name']}_g{n}" for n in range(1, _operations(tree["top"]) + 1)]
    names = [*ids, model.get("name", "model")]
    yield from _twice("gate, event or house event", ids)
    kinds = {"initiating event": [], "sequence": [], "event tree": []}
    for tree in model.get("eventTrees", []):
        kinds["event tree"].append(tree["name"])
        kinds["initiating event"].append(tree["initiatingEvent"]["name"])
        # A sequence is called as it ends.
        kinds["sequence"] += [sequence["endState"] for sequence in tree["sequences"]]
        functions = [item["name"] for item in tree.get("functionalEvents", ())]
        yield from _twice("functional event", functions)
        names += functions
    for kind, own in kinds.items():
        yield from _twice(kind, own)
        names += own
    for name in names:
        if not name or "." in name:
            yield f"the element name {name!r} is malformed"


def _twice(kind, names):
    return [
        f"{count} times the {kind} {name!r}" for name, count in Counter(names).items() if count > 1
    ]


def _operations(part):
    if "op" not in part:
        return 0
    below = part["args"] if "args" in part else [part["arg"]]
    return 1 + sum(map(_operations, below))


def _tree(tree):
    where = f"fault tree {tree['name']!r}"
    if "basicEvents" not in tree:
        return [f"{where} is passed over without its basicEvents"]
    known = [event["name"] for event in tree["basicEvents"]]
    known += [house["name"] for house in tree.get("houseEvents", ())]
    found = _twice(f"event of {where}", known)
    if "op" not in tree["top"]:
        found.append(f"{where}: its top is no operation")
    waiting = [tree["top"]]
    while waiting:
        part = waiting.pop()
        if "event" in part:
            if part["event"] not in known:
                found.append(f"{where}: unknown event {part['event']!r}")
            continue
        found += [f"{where}: {text}" for text in _gate(part)]
        waiting += part["args"] if "args" in part else [part["arg"]]
    return found


def _gate(part):
    operation = part["op"]
    if operation == "not":
        return [] if isinstance(part.get("arg"), dict) else ["not.arg must be present"]
    if operation not in ("and", "or", "xor", "nand", "nor", "atleast"):
        return [f"the operation {operation!r} is not supported"]
    count = len(part["args"])
    events = [argument["event"] for argument in part["args"] if "event" in argument]
    found = _twice("argument", events)
    if operation in ("nand", "nor") and count < 2:
        found.append(f"{operation} of {count}")
    if operation == "xor" and count != 2:
        found.append(f"xor of {count}")
    if operation == "atleast" and not 2 <= part["k"] < count:
        found.append(f"at least {part['k']} of {count}")
    if count == 0:
        found.append(f"{operation} of nothing")
    return found


def _event_tree(tree, trees):
    where = f"event tree {tree['name']!r}"
    found = []
    ways = []
    for sequence in tree["sequences"]:
        states = {}
        for state in sequence["functionalStates"]:
            gate = state.get("refGate", {}).get("name", state["name"])
            if gate not in trees:
                found.append(f"{where}: unknown gate {gate!r}")
            states[state["name"]] = state["state"]
        ways.append(tuple(sorted(states.items())))
    return found + _twice(f"way through {where}", ways)
