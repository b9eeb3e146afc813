"""What `git diff` shows of an annotated source: its text, and below it the model of its blocks."""

from __future__ import annotations

from collections.abc import Iterator

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.values import component_fields
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.model import blocks_of
from tracerisk.prm.hybrid.from_blocks import MAX_QUANTITY, build_model, function_state
from tracerisk.prm.hybrid.solve import solve_figures, top_event


def textconv(source: bytes, file: str) -> bytes:
    """Return a source with the model of its blocks below it; the source alone without blocks.

    The lines of the source stay where they are, so that the places in a diff are right.
    The text depends on the bytes alone, for git gives versions under names of its own; what
    cannot be read is reported in it, for git takes no failure.
    """
    lines = list(_model(source, file))
    if not lines:
        return source
    end = b"" if source.endswith(b"\n") or not source else b"\n"
    return source + end + "".join(f"{line}\n" for line in ["", *lines]).encode()


def _model(source: bytes, file: str) -> Iterator[str]:
    try:
        blocks = [block for _, block in blocks_of({file: source})]
    except TraceRiskError as error:
        if b"RiskAnnotation" in source:
            line = error.location.line if error.location is not None else None
            where = "" if line is None else f"line {line}: "
            yield f"risk model: {where}{_nameless(error, file)}"
        return
    if not blocks:
        return
    yield f"risk model: {_mission(blocks, file)}"
    for block in sorted(blocks, key=lambda risk_block: risk_block.call_sequence.value):
        yield from _function(block)


def _nameless(error: TraceRiskError, file: str) -> str:
    return error.message.replace(f"{file}:", "line ").replace(file, "this file")


def _mission(blocks: list[RiskBlock], file: str) -> str:
    try:
        mission = solve_figures(build_model(blocks, name="")).mission
    except TraceRiskError as error:
        # A `next` may lead into another file of the controller.
        return f"no mission of these blocks alone: {_nameless(error, file)}"
    cycle = mission.cycle_failure_probability
    per_cycle = "" if cycle is None else f", per cycle {cycle:.4g}"
    return f"mission failure {mission.failure_probability:.4g}{per_cycle}"


def _function(block: RiskBlock) -> Iterator[str]:
    following = "" if block.next is None else f", next {block.next.text}"
    yield f"  {block.name}: {_top(block)}{following}"
    for entry in block.components:
        if entry.omitted:
            yield f"    {entry.name}: left out by hand"
            continue
        fields = ", ".join(
            f"{kind.key} {value.text}{' (pinned)' if value.pinned else ''}"
            for kind, value in component_fields(entry)
        )
        yield f"    {entry.name}: {fields}"


def _top(block: RiskBlock) -> str:
    counted = [entry for entry in block.components if not entry.omitted]
    if any(entry.quantity.value > MAX_QUANTITY for entry in counted):
        return "no figure"
    top = top_event(function_state(block, block.components, ())).p
    return f"{top:.4g} a visit"
