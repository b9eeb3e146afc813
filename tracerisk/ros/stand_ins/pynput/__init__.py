"""Stand-in for pynput: listeners that hear what is typed in the run."""

from __future__ import annotations

from . import keyboard, mouse

__all__ = ["keyboard", "mouse"]
