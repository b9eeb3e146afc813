"""What the lock keeps of a run: a digest of what it depended on, and a summary of its trace."""

from __future__ import annotations

import hashlib
import io
import tokenize
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tracerisk.adder.model_names import model_names
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location, SourceError
from tracerisk.pipeline.controller import Controller
from tracerisk.pipeline.robot_choice import robot_digests
from tracerisk.trace import Trace


def fingerprint(controller: Controller, trace: Trace, settings: Settings) -> str:
    """Return a digest of what the trace depends on.

    Sources without comments and blank lines, the robot with its model's files, the scene, what the
    files of the scenario, of launch and of parameters hold, and those settings that change a run;
    not the hardware data, from which values follow without a run.
    """
    from tracerisk import __version__

    parts = [
        __version__,
        trace.robot,
        trace.scene,
        f"{settings.duration_s!r}",
        f"{settings.seed!r}",
        f"{settings.mission_cycles!r}",
        ",".join(settings.states),
        ",".join(settings.helpers),
        *robot_digests(controller, settings),
        *(_digest(file) for file in (settings.scenario, *settings.params) if file is not None),
        f"{settings.launch is not False!r}",
        *(f"{file} {_digest_if_there(controller.path_of(file))}" for file in trace.inputs),
    ]
    for file in (controller.file, *sorted(set(trace.files) - {controller.file})):
        parts += [file, *_code_tokens(controller.source_of(file), file)]
    return hashlib.sha256("\x00".join(parts).encode()).hexdigest()


def _digest_if_there(path: Path) -> str:
    """Return a digest of a file that was found and may be gone: then a run finds another."""
    return _digest(str(path)) if path.is_file() else "gone"


def _digest(file: str) -> str:
    try:
        return hashlib.sha256(Path(file).read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", Location(file)) from error


def trace_summary(trace: Trace) -> dict[str, Any]:
    """Return what the lock keeps of a trace: the exposures of each function's elements [s]."""
    functions: dict[str, Any] = {}
    names = model_names([function.ref for function in trace.functions])
    for function in trace.functions:
        visits = [visit for visit in trace.visits if visit.function == function.ref]
        elements: dict[str, Any] = {}
        for element in trace.elements:
            found = [e for v in visits if (e := v.exposures.get(element.name)) is not None]
            if any(exposure.active_s for exposure in found):
                elements[element.name] = {
                    "moving_s": _rounded(sum(e.moving_s for e in found)),
                    "holding_s": _rounded(sum(e.holding_s for e in found)),
                    "grasping_s": _rounded(sum(e.grasping_s for e in found)),
                }
        known = [visit.duration_s for visit in visits if visit.duration_s is not None]
        functions[names[function.ref]] = {
            "visits": len(visits),
            "duration_s": _rounded(sum(known)),
            "elements": elements,
        }
    return {
        "robot": trace.robot,
        "scene": trace.scene,
        "end": trace.end.cause,
        "functions": functions,
    }


def _rounded(seconds: float) -> float:
    return round(seconds, 3)


def _code_tokens(source: bytes, file: str) -> Sequence[str]:
    left_out = {tokenize.COMMENT, tokenize.NL}
    try:
        return [
            f"{token.type}:{token.string}"
            for token in tokenize.tokenize(io.BytesIO(source).readline)
            if token.type not in left_out
        ]
    except (tokenize.TokenError, SyntaxError) as error:
        raise SourceError(f"is not Python 3: {error}", Location(file)) from error
