"""A container that executes one state for each item of something."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from . import log
from .container import Container
from .exceptions import InvalidConstructionError
from .state import State
from .user_data import UserData


class Iterator(Container):
    """Executes its state again and again, with the item in its data."""

    def __init__(
        self,
        outcomes: Iterable[str],
        input_keys: Iterable[str],
        output_keys: Iterable[str],
        it: Iterable[Any] | Callable[[], Iterable[Any]] = (),
        it_label: str = "it_data",
        exhausted_outcome: str = "exhausted",
    ) -> None:
        super().__init__(outcomes, input_keys, output_keys)
        self._items = it
        self._items_label = it_label
        self._exhausted_outcome = exhausted_outcome
        self.register_outcomes([exhausted_outcome])
        self._loop_outcomes: list[str] = []
        self._break_outcomes: list[str] | None = None
        self._final_outcome_map: dict[str, str] = {}

    @staticmethod
    def set_contained_state(
        label: str,
        state: State,
        loop_outcomes: Iterable[str] = (),
        break_outcomes: Iterable[str] | None = None,
        final_outcome_map: Mapping[str, str] | None = None,
    ) -> None:
        """Set the state of the iterator that is open."""
        self = Iterator._currently_opened_container()
        self._forbid(bool(self._states), "an iterator has one state")
        self._hold(label, state, None)
        self._loop_outcomes = list(loop_outcomes)
        self._break_outcomes = None if break_outcomes is None else list(break_outcomes)
        self._final_outcome_map = dict(final_outcome_map or {})

    @classmethod
    def set_iteritems(cls, it: Iterable[Any], it_label: str) -> None:
        """Set what the iterator that is open goes through."""
        self = cls._currently_opened_container()
        self._items, self._items_label = it, it_label

    def get_initial_states(self) -> list[str]:
        """Return the label of the state."""
        return list(self._states)

    def get_active_states(self) -> list[str]:
        """Return the label of the state."""
        return list(self._states)

    def execute(self, parent_ud: Any = None) -> str:
        """Execute the state for each item; return the outcome."""
        data = UserData() if parent_ud is None else parent_ud
        if not self._states:
            raise InvalidConstructionError("an iterator needs a state")
        self._begin(data)
        (label,) = self._states
        state = self._states[label]
        outcome = self._exhausted_outcome
        self.call_start_cbs()
        for item in self._items() if callable(self._items) else self._items:
            self.userdata[self._items_label] = item
            if self.preempt_requested():
                state.request_preempt()
            execute_state = self._execute_state(label)
            breaks = execute_state in (self._break_outcomes or ()) or (
                self._break_outcomes is None and execute_state not in self._loop_outcomes
            )
            if breaks or log.is_shutdown():
                outcome = execute_state
                break
            self.call_transition_cbs()
        outcome = self._final_outcome_map.get(outcome, outcome)
        if self.preempt_requested():
            self.service_preempt()
        self.call_termination_cbs([label], outcome)
        self._finish(data)
        return outcome
