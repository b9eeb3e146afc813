"""What a gripper does, by whichever interface its fingers are moved."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar


class Gripper(ABC):
    """Opens and closes fingers between two positions of each."""

    _moves_each: ClassVar[bool] = True
    """Whether every joint must have positions of its own."""
    _opened: list[float]
    _closed: list[float]
    _ends: list[tuple[float, float]]
    joint_names: Any
    joint_state: Any

    @abstractmethod
    def _go(self, positions: Sequence[float]) -> None: ...

    def __call__(self) -> None:
        """Toggle the gripper."""
        self.toggle()

    def toggle(self) -> None:
        """Close what is open, and open what is closed."""
        if self.is_open:
            self.close(skip_if_noop=False)
        else:
            self.open(skip_if_noop=False)

    def open(self, skip_if_noop: bool = False) -> None:
        """Open the gripper."""
        if not (skip_if_noop and self.is_open):
            self._go(self._opened)

    def close(self, skip_if_noop: bool = False) -> None:
        """Close the gripper."""
        if not (skip_if_noop and self.is_closed):
            self._go(self._closed)

    @property
    def is_open(self) -> bool:
        """Whether all fingers are within a tenth of the way of where they are open.

        So they are before joint states came.
        """
        state = self.joint_state
        if state is None:
            return True
        at = dict(zip(state.name, state.position, strict=True))
        return all(
            abs(at[name] - opened) <= 0.1 * abs(opened - closed)
            for name, (opened, closed) in zip(self.joint_names, self._ends, strict=self._moves_each)
        )

    @property
    def is_closed(self) -> bool:
        """Whether a finger is not where it is open."""
        return not self.is_open
