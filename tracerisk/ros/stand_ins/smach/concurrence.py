"""A container that executes all its states at the same time, each in a thread."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from . import log
from .container import Container
from .exceptions import InvalidConstructionError, InvalidUserCodeError
from .state import CBState, State
from .user_data import UserData


class Concurrence(Container):
    """Ends when all its states have; a map of their outcomes, or a callback, gives its own."""

    def __init__(
        self,
        outcomes: Iterable[str],
        default_outcome: str,
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        outcome_map: Mapping[str, Mapping[str, str]] | None = None,
        outcome_cb: Callable[[dict[str, str]], str | None] | None = None,
        child_termination_cb: Callable[[dict[str, str | None]], bool] | None = None,
    ) -> None:
        outcomes = list(outcomes)
        super().__init__(outcomes, input_keys, output_keys)
        if not (default_outcome or outcome_map or outcome_cb):
            raise InvalidConstructionError("a concurrence needs a default outcome")
        self._forbid(
            default_outcome not in outcomes,
            f"default outcome '{default_outcome}' is no outcome of the container",
        )
        self._default_outcome = default_outcome
        self._outcome_map = {key: dict(value) for key, value in (outcome_map or {}).items()}
        self.register_outcomes(self._outcome_map)
        self._outcome_cb = outcome_cb
        self._child_termination_cb = child_termination_cb
        self._child_outcomes: dict[str, str | None] = {}
        self._errors: list[BaseException] = []

    @staticmethod
    def add(label: str, state: Any, remapping: Mapping[str, str] | None = None) -> Any:
        """Add a state to the container that is open."""
        self = Concurrence._currently_opened_container()
        if not isinstance(state, State) and callable(state):
            state = CBState(state)
        self._hold(label, state, remapping)
        return state

    def get_initial_states(self) -> list[str]:
        """Return the labels of all states."""
        return list(self._states)

    def get_active_states(self) -> list[str]:
        """Return the labels of the states that still are executed."""
        return [label for label, outcome in self._child_outcomes.items() if outcome is None]

    def get_internal_edges(self) -> list[tuple[str, str, str]]:
        """Return outcome, label and own outcome, for each that the map names."""
        return [
            (outcome, label, own)
            for own, row in self._outcome_map.items()
            for label, outcome in row.items()
        ]

    def request_preempt(self) -> None:
        """Ask the container and all its states to end."""
        super().request_preempt()
        for state in self._states.values():
            state.request_preempt()

    def execute(self, parent_ud: Any = None) -> str:
        """Execute all states; return the outcome of all."""
        data = UserData() if parent_ud is None else parent_ud
        self._begin(data)
        self._errors = []
        self._child_outcomes = dict.fromkeys(self._states)
        log.loginfo(f"concurrence starts with userdata {self.userdata.keys()}")
        self.call_start_cbs()
        threads = [
            threading.Thread(target=self._execute_child, args=(label,), name=f"concurrence:{label}")
            for label in self._states
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        if self._errors:
            self._is_running = False
            raise InvalidUserCodeError("a concurrent state raised") from self._errors[0]
        outcome = self._outcome()
        for state in self._states.values():
            state.recall_preempt()
        if self.preempt_requested():
            self.service_preempt()
        log.loginfo(f"concurrence ends with {self._child_outcomes}")
        self.call_termination_cbs(list(self._states), outcome)
        self._finish(data)
        return outcome

    def _execute_child(self, label: str) -> None:
        try:
            self._child_outcomes[label] = self._execute_state(label)
        except Exception as error:  # noqa: BLE001 - raised where all have ended
            self._errors.append(error)
        ends = self._errors or (
            self._child_termination_cb is not None
            and self._child_termination_cb(dict(self._child_outcomes))
        )
        if ends:
            for other in self.get_active_states():
                if other != label:
                    self._states[other].request_preempt()

    def _outcome(self) -> str:
        outcomes = {label: str(outcome) for label, outcome in self._child_outcomes.items()}
        if self._outcome_cb is not None:
            chosen = self._outcome_cb(outcomes)
            if chosen:
                return chosen
        for own, row in self._outcome_map.items():
            if all(outcomes.get(label) == wanted for label, wanted in row.items()):
                return own
        return self._default_outcome
