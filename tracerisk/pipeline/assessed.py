"""What a run of a controller came to, from its trace to its risk."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.config import Settings
    from tracerisk.pipeline.annotate import Annotated
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.prm.hybrid.assessment import Assessment
    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.trace import Trace


@dataclass(frozen=True, slots=True)
class Assessed:
    """What a run of a controller came to, from its trace to its risk."""

    controller: Controller
    """The controller that ran."""
    settings: Settings
    """The settings of the run."""
    hardware: Hardware
    """The description of the components and their failure figures."""
    trace: Trace
    """The trace of the run."""
    annotated: Annotated
    """The blocks, and the sources with them; not yet written."""
    sources: Mapping[str, bytes]
    """Each source with its blocks, by its path."""
    model: HybridModel
    """The model built from the blocks in `sources`."""
    assessment: Assessment
    """The solution of `model`: the mission's risk."""
