"""What `solve` needs of a model file of whatever format, and what it makes of it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from tracerisk.errors import InputError, one_of

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Protocol

    from tracerisk.prm.questions.uncertainty import Uncertainty
else:
    Protocol = object

Render = Callable[..., str]


@dataclass(frozen=True, slots=True)
class Solved:
    """A solved model file."""

    figures: Mapping[str, float]
    """The figures, by name."""
    data: dict[str, Any]
    """All results, as `--json` prints them."""
    shown: tuple[tuple[Render, tuple[Any, ...]], ...]
    """The functions that render the results as text, each with its arguments."""
    notes: tuple[str, ...] = ()
    """Remarks on the model, for the user."""
    risks: tuple[str, ...] | None = None
    """The figures that a limit applies to; `None` where only the user can decide."""
    broken: tuple[str, ...] = ()
    """The limits of the model's own that do not hold."""


class Solvable(Protocol):
    """A model file of some format, as `solve` needs it."""

    @property
    def name(self) -> str:
        """What the model is called."""

    def with_values(self, values: Mapping[str, float]) -> Solvable:
        """Return the model with figures set; raise InputError for an unknown name."""

    def value_of(self, name: str) -> float:
        """Return the figure that the model has now."""

    def solve(self, figure: str | None, *, importance: bool) -> Solved:
        """Solve the model, or the part of it that one figure needs."""

    def spread(self, figure: str | None, samples: int, seed: int) -> Uncertainty:
        """Return the uncertainty of a figure."""

    def at(self, mission_time_h: float) -> Solvable:
        """Return the model with another mission time."""


def chosen(figures: Collection[str], figure: str | None, model: str) -> tuple[str, ...]:
    """Return the figures that are asked for: all, or the one; InputError for an unknown one."""
    if figure is None:
        return tuple(figures)
    if figure not in figures:
        raise InputError(f"--figure {figure}: no figure of '{model}'; {one_of(figures, figure)}")
    return (figure,)


def no_mission_time(name: str) -> InputError:
    """Return the error for a model whose figures depend on a mission time that is not given."""
    return InputError(
        f"figures of '{name}' depend on the mission time; give --mission-time H, in hours"
    )
