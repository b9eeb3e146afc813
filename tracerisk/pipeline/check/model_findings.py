"""Whether the blocks of a controller make a model that can be solved, with a risk within limits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.blocks.values import has_pins
from tracerisk.adder.lock.kept import as_computed
from tracerisk.adder.lock.lock import ControllerLock
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import BlockError, Location, ModelError
from tracerisk.pipeline.check.finding import CheckFinding
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.prm.hybrid.from_blocks import build_model
from tracerisk.prm.hybrid.solve import solve_figures


def model_findings(
    controller: Controller,
    entry: ControllerLock,
    placed: Mapping[FunctionRef, RiskBlock],
    limits: Mapping[str, float],
) -> Iterable[CheckFinding]:
    """Yield why the blocks make no model that can be solved, or one above one of the limits.

    What a refresh kept counts as computed.
    """
    names = model_names(placed)
    blocks = [
        replace(as_computed(block, entry, ref.file, ref.name), name=QualifiedName(names[ref]))
        for ref, block in placed.items()
    ]
    place = Location(str(controller.path), 1)
    try:
        figures = solve_figures(build_model(blocks, name=controller.path.name))
    except (BlockError, ModelError) as error:
        yield CheckFinding("unsolvable", error.message, error.location or place)
        return
    mission = figures.mission
    for ref, block in placed.items():
        has_figures = any(not component.omitted for component in block.components)
        if has_figures and has_pins(block) and figures.expected_visits[names[ref]] == 0.0:
            message = (
                f"what is set by hand in the block of {ref.name} counts nothing: no `next` leads "
                "to it; remove it, or write it where that is done now"
            )
            yield CheckFinding("moved", message, block.location or place, ref.name)
    for name, limit in limits.items():
        is_whole = name == "max_failure_probability"
        risk = mission.failure_probability if is_whole else mission.undetected_or_all
        if risk > limit:
            words = "fails" if is_whole else "fails undetected"
            yield CheckFinding(
                "over_threshold",
                f"the mission {words} with probability {risk:.4g}, above the {name} of {limit:g}",
                place,
            )
