"""A state machine whose states follow each other in the order in which they were added."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from .state_machine import StateMachine


class Sequence(StateMachine):
    """Leads by `connector_outcome` from each state to the next; by the last one's out of it."""

    def __init__(
        self,
        outcomes: Iterable[str],
        connector_outcome: str,
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
    ) -> None:
        super().__init__(outcomes, input_keys, output_keys)
        self._connector_outcome = connector_outcome

    @classmethod
    def add(
        cls,
        label: str,
        state: Any,
        transitions: Mapping[str, str | None] | None = None,
        remapping: Mapping[str, str] | None = None,
    ) -> Any:
        """Add a state behind the last one."""
        self = cls._currently_opened_container()
        state = super().add(label, state, transitions, remapping)
        connects = self._connector_outcome in state.get_registered_outcomes()
        if connects and self._connector_outcome not in (transitions or {}):
            self._waits_for_next = [(label, [self._connector_outcome])]
        return state
