"""The edit of `pyproject.toml` that accepts a reason of a run's verdict, in words of the user."""

from __future__ import annotations

import json
from pathlib import Path

from tracerisk.acceptances import ACCEPTABLE
from tracerisk.config import loads_toml
from tracerisk.trace import Reason, Verdict

SETTINGS = "pyproject.toml"


def reason_of(verdict: Verdict | None, message: str, function: str) -> Reason | None:
    """Return the reason of a verdict that a finding tells of, if it may be accepted."""
    for each in () if verdict is None else verdict.open_reasons:
        if each.code in ACCEPTABLE and each.function == function and message.startswith(each.words):
            return each
    return None


def accepting(text: str, code: str, function: str, thing: str, words: str) -> str | None:
    """Return what is to stand behind the settings so that a reason is accepted.

    `None` where their `accept` is written in a way that nothing can be put behind.
    """
    given = {"code": code, "function": function, "object": thing, "words": words}
    # A JSON string is a basic string of TOML.
    lines = [
        f"{key} = {json.dumps(value)}" for key, value in given.items() if value or key == "words"
    ]
    gap = "" if not text or text.endswith("\n\n") else "\n" if text.endswith("\n") else "\n\n"
    added = gap + "\n".join(["[[tool.tracerisk.accept]]", *lines]) + "\n"
    try:
        loads_toml((text + added).replace("\r\n", "\n"))
    except ValueError:
        return None
    return added


def settings_of(root: Path) -> Path:
    """Return the settings of a controller's root."""
    return root.resolve() / SETTINGS
