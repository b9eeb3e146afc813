"""How long the language server takes to answer, on a controller of a thousand lines and more.

    python benchmarks/editor_times.py [--functions N] [--repeat N]

A controller of N functions (28: some 1,000 lines with their risk blocks) is run on the twin once;
a client of pygls then speaks with `tracerisk lsp` over standard input and output, as an editor
does. Each figure is the wall time from what the client sends to what it gets, median and greatest.

    start        from the start of the process to the answer to `initialize`
    open         from the first sight of the file to its diagnostics
    hover        over a function, of a text that the server knows
    hover (new)  the same at once after a change of the code, or of a value in a block
    diagnostics  from such a change to what is found
    lens, folding, completion, fixes   of a text that the server knows

Asked of it: hover in less than 50 ms, diagnostics in less than 300 ms.
"""

from __future__ import annotations

import argparse
import asyncio
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Awaitable
from functools import partial
from pathlib import Path
from typing import Any

import quick
from lsprotocol import types as lsp
from pygls.lsp.client import LanguageClient

HEAD = '''\
"""A long controller."""

import sys

import moveit_commander
import rospy

'''
STEP = '''
def step_{number}(arm):
    """Go to pose {number}."""
    offset = {number} * 0.01
    notes = []
    notes.append("one")
    notes.append("two")
    notes.append("three")
    arm.set_joint_value_target([0.0, -0.5 + offset, 0.0, -2.0, 0.0, 1.6, 0.8])
    arm.go(wait=True)

'''
TAIL = """
def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("long")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
{calls}


if __name__ == "__main__":
    main()
"""


def write(folder: Path, functions: int) -> Path:
    """Write a controller of so many functions, and run it."""
    path = folder / "long.py"
    steps = "".join(STEP.format(number=number) for number in range(functions))
    calls = "\n".join(f"    step_{number}(arm)" for number in range(functions))
    path.write_text(HEAD + steps + TAIL.format(calls=calls), encoding="utf-8")
    subprocess.run(
        [sys.executable, "-m", "tracerisk", "run", "-q", path.name], cwd=folder, check=True
    )
    return path


async def timed(answer: Awaitable[Any]) -> float:
    """Wait for an answer, and return how long that took [ms]."""
    began = time.perf_counter()
    await answer
    return 1e3 * (time.perf_counter() - began)


async def measure(path: Path, repeat: int) -> dict[str, list[float]]:
    """Return the times of each request [ms]."""
    values: dict[str, list[float]] = {}

    def put(name: str, value: float) -> None:
        values.setdefault(name, []).append(value)

    client = LanguageClient("times", "1")
    published: asyncio.Queue[lsp.PublishDiagnosticsParams] = asyncio.Queue()
    client.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)(partial(published.put_nowait))
    began = time.perf_counter()
    await client.start_io(sys.executable, "-m", "tracerisk", "lsp")
    await client.initialize_async(lsp.InitializeParams(capabilities=lsp.ClientCapabilities()))
    put("start", 1e3 * (time.perf_counter() - began))
    client.initialized(lsp.InitializedParams())

    uri, text = path.as_uri(), path.read_text("utf-8")
    this = lsp.TextDocumentIdentifier(uri)

    async def changed(version: int, new: str) -> None:
        client.text_document_did_change(
            lsp.DidChangeTextDocumentParams(
                lsp.VersionedTextDocumentIdentifier(version, uri),
                [lsp.TextDocumentContentChangeWholeDocument(new)],
            )
        )
        await known(version)

    async def known(version: int) -> None:
        while (await published.get()).version != version:
            pass

    item = lsp.TextDocumentItem(uri, "python", 1, text)
    began = time.perf_counter()
    client.text_document_did_open(lsp.DidOpenTextDocumentParams(item))
    await known(1)
    put("open", 1e3 * (time.perf_counter() - began))

    lines = text.split("\n")
    line = next(number for number, word in enumerate(lines) if word.startswith("def step_9("))
    value = next(n for n in range(line, len(lines)) if "quantity = " in lines[n])
    place = lsp.Position(line, 6)
    there = lsp.Range(lsp.Position(value, 0), lsp.Position(value, 9))
    context = lsp.CodeActionContext([])
    for number in range(repeat):
        hover = client.text_document_hover_async(lsp.HoverParams(this, place))
        put("hover", await timed(hover))
        put("lens", await timed(client.text_document_code_lens_async(lsp.CodeLensParams(this))))
        put(
            "folding",
            await timed(client.text_document_folding_range_async(lsp.FoldingRangeParams(this))),
        )
        inside = lsp.CompletionParams(this, lsp.Position(value, len(lines[value])))
        put("completion", await timed(client.text_document_completion_async(inside)))
        fixes = lsp.CodeActionParams(this, there, context)
        put("fixes", await timed(client.text_document_code_action_async(fixes)))
        for kind, old, new in (
            ("code", '"one"', f'"one {number}"'),
            ("block", "probability = ", f"probability = {number + 1}"),
        ):
            version = 2 + 2 * number + (kind == "block")
            changing = asyncio.create_task(timed(changed(version, text.replace(old, new, 1))))
            await asyncio.sleep(0)
            hover = client.text_document_hover_async(lsp.HoverParams(this, place))
            put(f"hover (new {kind})", await timed(hover))
            put(f"diagnostics ({kind})", await changing)
    await client.shutdown_async(None)
    client.exit(None)
    await client.stop()
    return values


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--functions", type=int, default=28)
    parser.add_argument("--repeat", type=int, default=20)
    options = quick.parsed(parser, functions=lambda: 10, repeat=lambda: 1)
    with tempfile.TemporaryDirectory() as name:
        path = write(Path(name), options.functions)
        count = len(path.read_text("utf-8").splitlines())
        values = asyncio.run(measure(path, options.repeat))
    print(f"{count} lines, {options.functions} functions with risk blocks")
    print(f"{'':<20}{'median ms':>12}{'most ms':>12}")
    for text, times in values.items():
        print(f"{text:<20}{statistics.median(times):>12.1f}{max(times):>12.1f}")


if __name__ == "__main__":
    main()
