"""A container that executes one state after the other, as their outcomes lead."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from . import log
from .container import Container
from .exceptions import InvalidTransitionError
from .state import CBState, State
from .user_data import UserData


class StateMachine(Container):
    """A finite state machine, whose own outcomes end it."""

    def __init__(
        self,
        outcomes: Iterable[str],
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
    ) -> None:
        super().__init__(outcomes, input_keys, output_keys)
        self._transitions: dict[str, dict[str, str | None]] = {}
        self._initial_state_label: str | None = None
        self._current_label: str | None = None
        self._waits_for_next: list[tuple[str, list[str]]] = []

    @classmethod
    def add(
        cls,
        label: str,
        state: Any,
        transitions: Mapping[str, str | None] | None = None,
        remapping: Mapping[str, str] | None = None,
    ) -> Any:
        """Add a state to the machine that is open; an outcome without a transition is its own."""
        self = cls._currently_opened_container()
        if not isinstance(state, State) and callable(state):
            state = CBState(state)
        self._hold(label, state, remapping)
        given = dict(transitions or {})
        unknown = [name for name in given if name not in state.get_registered_outcomes()]
        if unknown:
            del self._states[label]
            raise InvalidTransitionError(
                f"a transition of '{label}' is for '{unknown[0]}', which is none of its outcomes: "
                f"{list(state.get_registered_outcomes())}"
            )
        self._transitions[label] = {
            outcome: given.get(outcome, outcome) for outcome in state.get_registered_outcomes()
        }
        for earlier, outcomes in self._waits_for_next:
            self._transitions[earlier].update(dict.fromkeys(outcomes, label))
        self._waits_for_next = []
        if self._initial_state_label is None:
            self._initial_state_label = label
        return state

    @classmethod
    def add_auto(
        cls,
        label: str,
        state: Any,
        connector_outcomes: Iterable[str],
        transitions: Mapping[str, str | None] | None = None,
        remapping: Mapping[str, str] | None = None,
    ) -> Any:
        """Add a state some outcomes of which lead to whichever is added next."""
        self = cls._currently_opened_container()
        state = cls.add(label, state, transitions, remapping)
        self._waits_for_next = [(label, list(connector_outcomes))]
        return state

    def check_consistency(self) -> None:
        """Raise InvalidTransitionError where a transition leads nowhere, or without a state."""
        if self._initial_state_label is None:
            raise InvalidTransitionError("the state machine has no states")
        if self._initial_state_label not in self._states:
            raise InvalidTransitionError(
                f"the state machine has no state '{self._initial_state_label}' to begin with"
            )
        known = {*self._states, *self.get_registered_outcomes(), None}
        for label, row in self._transitions.items():
            for outcome, target in row.items():
                if target not in known:
                    raise InvalidTransitionError(
                        f"the transition '{outcome}' of state '{label}' leads to '{target}', which "
                        "is neither a state nor an outcome; "
                        f"states: {list(self._states)}, outcomes: "
                        f"{list(self.get_registered_outcomes())}"
                    )

    def set_initial_state(
        self, initial_states: list[str], userdata: UserData | None = None
    ) -> None:
        """Begin with another state, and with other data."""
        if len(initial_states) > 1:
            log.logwarn("a state machine begins with one state: the first is taken")
        if initial_states:
            self._initial_state_label = initial_states[0]
        if userdata is not None:
            self.userdata.update(userdata)

    def get_initial_states(self) -> list[str]:
        """Return the label of the first state."""
        return [] if self._initial_state_label is None else [self._initial_state_label]

    def get_active_states(self) -> list[str]:
        """Return the label of the state that is executed."""
        return [] if self._current_label is None else [self._current_label]

    def get_internal_edges(self) -> list[tuple[str, str, str]]:
        """Return outcome, label and what follows, for each transition."""
        return [
            (outcome, label, str(target))
            for label, row in self._transitions.items()
            for outcome, target in row.items()
        ]

    def execute(self, parent_ud: Any = None) -> str:
        """Execute states until an outcome of the machine is reached; return it."""
        data = UserData() if parent_ud is None else parent_ud
        self.check_consistency()
        self._begin(data)
        self._current_label = self._initial_state_label
        log.loginfo(
            f"state machine starts in '{self._current_label}' with userdata {self.userdata.keys()}"
        )
        self.call_start_cbs()
        try:
            outcome = self._run()
        finally:
            self._is_running = False
            self._current_label = None
        self._finish(data)
        return outcome

    def request_preempt(self) -> None:
        """Ask the machine, and the state that is executed, to end."""
        super().request_preempt()
        if self._current_label is not None:
            self._states[self._current_label].request_preempt()

    def _run(self) -> str:
        while True:
            label = self._current_label
            assert label is not None
            if self.preempt_requested() and not self._states[label].preempt_requested():
                self._states[label].request_preempt()
            outcome = self._execute_state(label)
            target = self._transitions[label].get(outcome, outcome)
            if target in self._states:
                if log.is_shutdown():
                    return "preempted"
                log.loginfo(f"state machine goes from '{label}' by '{outcome}' to '{target}'")
                self._current_label = target
                self.call_transition_cbs()
                continue
            if target is None:
                raise InvalidTransitionError(
                    f"outcome '{outcome}' of state '{label}' leads nowhere"
                )
            if target not in self.get_registered_outcomes():
                raise InvalidTransitionError(
                    f"outcome '{outcome}' of state '{label}' leads to '{target}', which is neither "
                    "a state nor an outcome of the state machine"
                )
            log.loginfo(f"state machine ends in '{label}' by '{outcome}' with '{target}'")
            self.call_termination_cbs([label], target)
            if self.preempt_requested():
                self.service_preempt()
            return target
