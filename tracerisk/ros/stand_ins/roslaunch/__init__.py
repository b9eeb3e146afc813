"""Stand-in for roslaunch: the substitutions of launch files in a program's own texts."""

from __future__ import annotations

from typing import Any

from . import substitution_args

__all__ = ["substitution_args"]


def __getattr__(name: str) -> Any:
    """Raise AttributeError: a run starts what its launch file names, and nothing more."""
    raise AttributeError(
        f"roslaunch.{name} is not served: a program starts no nodes here; name the launch file "
        "that starts them with --launch"
    )
