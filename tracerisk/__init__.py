"""Redo the risk assessment of a robot arm at every commit of its ROS controller.

The names below are the public Python API; each is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module

from tracerisk.version import __version__ as __version__

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from tracerisk.api import assess as assess
    from tracerisk.api import check as check
    from tracerisk.api import overrides as overrides
    from tracerisk.api import refresh as refresh
    from tracerisk.api import write_blocks as write_blocks
    from tracerisk.pipeline import annotate as annotate
    from tracerisk.pipeline import build as build
    from tracerisk.pipeline import load_controller as load_controller
    from tracerisk.pipeline import load_hardware as load_hardware
    from tracerisk.pipeline import load_settings as load_settings
    from tracerisk.pipeline import solve as solve
    from tracerisk.pipeline import strip as strip
    from tracerisk.pipeline import trace_controller as trace_controller
    from tracerisk.pipeline.review.review import diff as diff

__all__ = [
    "annotate",
    "assess",
    "build",
    "check",
    "diff",
    "load_controller",
    "load_hardware",
    "load_settings",
    "overrides",
    "refresh",
    "solve",
    "strip",
    "trace_controller",
    "write_blocks",
]

_HOMES = {
    "diff": "tracerisk.pipeline.review.review",
    **dict.fromkeys(("assess", "check", "overrides", "refresh", "write_blocks"), "tracerisk.api"),
}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'tracerisk' has no attribute '{name}'")
    return getattr(import_module(_HOMES.get(name, "tracerisk.pipeline")), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
