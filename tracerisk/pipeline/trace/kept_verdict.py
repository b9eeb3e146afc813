"""The verdict of a run as the lock keeps it, and what a reader makes of it later."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from tracerisk.adder.lock.lock import ControllerLock
from tracerisk.adder.sources.line_map import line_maps
from tracerisk.common.text.plain_data import MismatchError, plain_data, read_plain
from tracerisk.common.verdict import Verdict

_VERDICT = "verdict"
_REFUSED = "refused"
_INPUTS = "inputs"
_WHOLE_S = 1  # decimals of the times that are kept: more would change with every change


def verdict_summary(verdict: Verdict | None) -> dict[str, Any]:
    """Return what the lock keeps of a verdict; nothing where none is known."""
    if verdict is None:
        return {}
    reasons = tuple(
        replace(item, time_s=None if item.time_s is None else round(item.time_s, _WHOLE_S))
        for item in verdict.reasons
    )
    data = plain_data(replace(verdict, reasons=reasons))
    for reason in data["reasons"]:
        for key in ("by", "called_from"):
            if reason[key] is None:
                del reason[key]
    return {_VERDICT: data}


def bare_lines(sources: Mapping[str, bytes], shown: Mapping[str, str]) -> Callable[[str, int], int]:
    """Return what gives the line that a line of a source has without its risk blocks.

    `shown` is how messages call each source.
    """
    return line_maps(sources, {}, shown)


def block_lines(
    sources: Mapping[str, bytes], shown: Mapping[str, str]
) -> Callable[[str, int], int]:
    """Return what gives the line of a source, with its blocks, for one that the lock keeps."""
    return line_maps(dict.fromkeys(sources, b""), sources, shown)


def kept_verdict(entry: ControllerLock | None) -> Verdict | None:
    """Return the verdict that a lock keeps of a controller; `None` where it is unknown.

    It is unknown to a lock of an earlier tracerisk, and to one that was edited by hand.
    """
    if entry is None or not isinstance(entry.trace.get(_VERDICT), Mapping):
        return None
    return verdict_of_data(entry.trace[_VERDICT])


def with_refused(
    entry: ControllerLock, verdict: Verdict | None, inputs: Mapping[str, Any]
) -> ControllerLock:
    """Return an entry that also holds a later run that went wrong, whose blocks were not written.

    `inputs` are what that run depended on, as plain JSON values.
    """
    refused = {**verdict_summary(verdict), _INPUTS: dict(inputs)}
    return replace(entry, trace={**entry.trace, _REFUSED: refused})


def refused_run(entry: ControllerLock | None) -> tuple[Verdict, Mapping[str, Any]] | None:
    """Return the verdict and inputs of a later run that went wrong; `None` where there is none."""
    refused = None if entry is None else entry.trace.get(_REFUSED)
    if not isinstance(refused, Mapping) or not isinstance(refused.get(_INPUTS), Mapping):
        return None
    verdict = verdict_of_data(refused.get(_VERDICT))
    return None if verdict is None else (verdict, refused[_INPUTS])


def verdict_of_data(data: Any) -> Verdict | None:
    """Return the verdict that plain JSON values state; `None` where they state none."""
    try:
        return read_plain(Verdict, data)
    except MismatchError:
        return None
