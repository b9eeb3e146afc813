"""The states of a lifecycle node and what leads from one to the next.

Source: ros2/rcl `rcl_lifecycle/src/default_state_machine.c`; numbers of lifecycle_msgs `State.msg`
and `Transition.msg`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from .._rclpy_pybind11 import RCLError, TransitionCallbackReturnType

STATES: Final[dict[int, str]] = {
    0: "unknown",
    1: "unconfigured",
    2: "inactive",
    3: "active",
    4: "finalized",
    10: "configuring",
    11: "cleaningup",
    12: "shuttingdown",
    13: "activating",
    14: "deactivating",
    15: "errorprocessing",
}
_UNCONFIGURED, _INACTIVE, _ACTIVE, _FINALIZED = 1, 2, 3, 4
_CONFIGURING, _CLEANING_UP, _SHUTTING_DOWN = 10, 11, 12
_ACTIVATING, _DEACTIVATING, _ERROR_PROCESSING = 13, 14, 15


@dataclass(frozen=True, slots=True)
class Transition:
    """A transition between two states."""

    id: int
    """The number of the transition in lifecycle_msgs."""
    label: str
    """The name of the transition."""
    start: int
    """The number of the state before it."""
    goal: int
    """The number of the state after it."""


_ASKED_FOR = (
    Transition(1, "configure", _UNCONFIGURED, _CONFIGURING),
    Transition(2, "cleanup", _INACTIVE, _CLEANING_UP),
    Transition(3, "activate", _INACTIVE, _ACTIVATING),
    Transition(4, "deactivate", _ACTIVE, _DEACTIVATING),
    Transition(5, "shutdown", _UNCONFIGURED, _SHUTTING_DOWN),
    Transition(6, "shutdown", _INACTIVE, _SHUTTING_DOWN),
    Transition(7, "shutdown", _ACTIVE, _SHUTTING_DOWN),
)
# The first number, the state in which the callback runs, and where its three answers lead.
_ANSWERS = (
    (10, _CONFIGURING, (_INACTIVE, _UNCONFIGURED, _ERROR_PROCESSING)),
    (20, _CLEANING_UP, (_UNCONFIGURED, _INACTIVE, _ERROR_PROCESSING)),
    (30, _ACTIVATING, (_ACTIVE, _INACTIVE, _ERROR_PROCESSING)),
    (40, _DEACTIVATING, (_INACTIVE, _ACTIVE, _ERROR_PROCESSING)),
    (50, _SHUTTING_DOWN, (_FINALIZED, _FINALIZED, _ERROR_PROCESSING)),
    (60, _ERROR_PROCESSING, (_UNCONFIGURED, _FINALIZED, _FINALIZED)),
)
GRAPH: Final[tuple[Transition, ...]] = (
    *_ASKED_FOR,
    *(
        Transition(first + offset, answer.to_label(), state, goals[offset])
        for first, state, goals in _ANSWERS
        for offset, answer in enumerate(TransitionCallbackReturnType)
    ),
)


class StateMachine:
    """The state of one node, and the services by which others change it, where it has them."""

    def __init__(self) -> None:
        self.state = _UNCONFIGURED
        self.service_change_state: Any = None
        self.service_get_state: Any = None
        self.service_get_available_states: Any = None
        self.service_get_available_transitions: Any = None
        self.service_get_transition_graph: Any = None

    @property
    def current_state(self) -> tuple[int, str]:
        """The state's number and name."""
        return self.state, self.label

    @property
    def label(self) -> str:
        """The state's name."""
        return STATES[self.state]

    @property
    def available(self) -> tuple[Transition, ...]:
        """What can happen in this state."""
        return tuple(transition for transition in GRAPH if transition.start == self.state)

    def by_label(self, label: str) -> Transition:
        """Return the transition of a label that can happen now.

        Raises:
            RCLError: there is none.
        """
        return self._available_by("label", label, f"'{label}'")

    def by_id(self, number: int) -> Transition:
        """Return the transition of a number that can happen now.

        Raises:
            RCLError: there is none.
        """
        return self._available_by("id", number, str(number))

    def _available_by(self, field: str, value: Any, text: str) -> Transition:
        for transition in self.available:
            if getattr(transition, field) == value:
                return transition
        raise RCLError(
            f"Failed to trigger lifecycle state machine transition: transition {text} is not "
            f"registered in state '{self.label}'"
        )
