"""What users build on: verbs, options, settings, codes, public names and the keys of the JSON.

`data/public_surface.json` holds what stands today. What is taken away or renamed there breaks
somebody's script: keep the older name, or say so in CHANGELOG.md. After a change that is meant:
`python tests/test_public_surface.py > tests/data/public_surface.json`.
"""

import argparse
import ast
import dataclasses
import importlib
import json
import sys
from pathlib import Path
from typing import Any

SURFACE = Path(__file__).parent / "data" / "public_surface.json"
PACKAGE = Path(__file__).parents[1] / "tracerisk"


def surface() -> dict[str, Any]:
    import tracerisk
    from tracerisk import errors, prm
    from tracerisk.cli.verbs import VERBS
    from tracerisk.config import Settings

    return {
        "verbs": {verb: options_of(verb) for verb in VERBS},
        "exit codes": {each.name: int(each) for each in errors.ExitCode},
        "error codes": sorted(codes_of(errors.TraceRiskError)),
        "settings": sorted(field.name for field in dataclasses.fields(Settings)),
        "tracerisk": sorted(tracerisk.__all__),
        "tracerisk.prm": sorted(prm.__all__),
        "json": json_keys(),
    }


def options_of(verb: str) -> list[str]:
    parser = argparse.ArgumentParser()
    from tracerisk.cli.verbs import module_of

    importlib.import_module(module_of(verb)).add_options(parser)
    found = []
    for action in parser._actions:
        found += action.option_strings or [str(action.metavar or action.dest)]
    return sorted(found)


def codes_of(kind: type) -> set[str]:
    for room in ("adder.lock.lock", "api", "pipeline.history.file_lock", "common.text.bounded"):
        importlib.import_module(f"tracerisk.{room}")
    found = {vars(kind)["code"]} if isinstance(vars(kind).get("code"), str) else set()
    return found.union(*(codes_of(each) for each in kind.__subclasses__()))


def json_keys() -> dict[str, list[str]]:
    """The keys that each verb gives to what prints its JSON."""
    found: dict[str, set[str]] = {}
    for path in sorted((PACKAGE / "cli").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Call)
                and getattr(node.func, "id", "") == "print_json"
                and isinstance(node.args[0], ast.Constant)
            ):
                keys = {each.arg for each in node.keywords if each.arg is not None}
                found.setdefault(node.args[0].value, set()).update(keys)
    return {verb: sorted(keys) for verb, keys in sorted(found.items())}


def test_nothing_that_users_build_on_is_gone():
    kept = json.loads(SURFACE.read_text(encoding="utf-8"))
    assert surface() == kept, "see the head of this file"


if __name__ == "__main__":
    sys.stdout.write(json.dumps(surface(), indent=1, sort_keys=True) + "\n")
