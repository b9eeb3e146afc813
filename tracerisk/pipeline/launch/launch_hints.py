"""What a launch file says in a controller's name: texts by which its robot is known."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from tracerisk.pipeline.launch_files.records import LaunchParameter, LaunchSetup
from tracerisk.pipeline.workspace.controller import Controller


def with_parameters(
    controller: Controller, setup: LaunchSetup | None, given: Sequence[LaunchParameter] = ()
) -> Controller:
    """Return a controller whose source has its own parameters as assignments too.

    Those that its arguments have `given` replace those of the setup. For those who look for names
    of joints, groups and robots in it; it is not the one that runs.
    """
    launched = () if setup is None else setup.own
    values = {parameter.name: parameter.value for parameter in (*launched, *given)}
    if not values:
        return controller
    lines = [line for name, value in values.items() for line in _lines(name, value)]
    return replace(controller, source=b"\n".join([controller.source, *lines, b""]))


def _lines(name: str, value: Any) -> Iterator[bytes]:
    texts = list(value) if isinstance(value, list | tuple) else [value]
    if texts and all(isinstance(text, str) for text in texts):
        plain = "".join(char if char.isascii() and char.isalnum() else "_" for char in name)
        written = ascii(texts) if isinstance(value, list | tuple) else ascii(value)
        yield f"p_{plain} = {written}".encode()
