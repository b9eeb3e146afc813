"""What holds states: opened by `with`, so that states can be added, and run as a state itself."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from . import log
from .exceptions import InvalidConstructionError, InvalidStateError, InvalidUserCodeError
from .state import State
from .user_data import Remapper, UserData

_OPEN: list[Container] = []


class Container(State):
    """A state that is made of states."""

    def __init__(
        self,
        outcomes: Iterable[str] = (),
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        io_keys: Iterable[str] = (),
    ) -> None:
        super().__init__(outcomes, input_keys, output_keys, io_keys)
        self.userdata = UserData()
        self._states: dict[str, State] = {}
        self._remappings: dict[str, dict[str, str]] = {}
        self._callbacks: dict[str, list[tuple[Callable[..., Any], list[Any]]]] = {
            "start": [],
            "transition": [],
            "termination": [],
        }
        self._is_running = False

    # Being put together

    def open(self) -> None:
        """Open the container, so that the class's `add` adds states to it."""
        _OPEN.append(self)

    def close(self) -> None:
        """End that; what was put together is checked."""
        if not _OPEN or _OPEN[-1] is not self:
            raise InvalidStateError("this container is not the one that is open")
        _OPEN.pop()

    def is_opened(self) -> bool:
        """Return whether states can be added."""
        return any(container is self for container in _OPEN)

    @property
    def opened(self) -> bool:
        """Whether states can be added."""
        return self.is_opened()

    def __enter__(self) -> Any:
        self.open()
        return self

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        if kind is not None:
            while _OPEN and _OPEN.pop() is not self:
                pass
            return
        self.close()
        self.check_consistency()

    @classmethod
    def _currently_opened_container(cls) -> Any:
        if not _OPEN:
            raise InvalidStateError(
                "no container is open to add a state to: write `with container:` around it"
            )
        opened_container = _OPEN[-1]
        if not isinstance(opened_container, cls):
            raise InvalidStateError(
                f"the open container is a {type(opened_container).__name__}, and no {cls.__name__}"
            )
        return opened_container

    def _hold(self, label: str, state: Any, remapping: Mapping[str, str] | None) -> None:
        if label in self._states:
            raise InvalidStateError(
                f"the container has a state '{label}' already; give each a label of its own"
            )
        if not isinstance(state, State):
            raise InvalidStateError(
                f"what is added as '{label}' is a {type(state).__name__}, and no smach.State"
            )
        self._states[label] = state
        self._remappings[label] = dict(remapping or {})

    def check_consistency(self) -> None:
        """Raise InvalidTransitionError where the container cannot work."""

    def __getitem__(self, key: str) -> State:
        return self._states[key]

    def get_children(self) -> dict[str, State]:
        """Return the states by label."""
        return self._states

    # Running

    def is_running(self) -> bool:
        """Return whether it is being executed."""
        return self._is_running

    def get_active_states(self) -> list[str]:
        """Return the labels of the states that are executed."""
        return []

    def get_initial_states(self) -> list[str]:
        """Return the labels of the states that are executed first."""
        return []

    def get_internal_edges(self) -> list[tuple[str, str, str]]:
        """Return outcome, label and what follows, for each transition."""
        return []

    def set_initial_state(
        self, initial_states: list[str], userdata: UserData | None = None
    ) -> None:
        """Begin elsewhere."""
        raise NotImplementedError

    def register_start_cb(self, start_cb: Callable[..., Any], cb_args: Iterable[Any] = ()) -> None:
        """Call back when it starts: with the data, the first states and `cb_args`."""
        self._callbacks["start"].append((start_cb, list(cb_args)))

    def register_transition_cb(
        self, transition_cb: Callable[..., Any], cb_args: Iterable[Any] = ()
    ) -> None:
        """Call back at each transition: with the data, the active states and `cb_args`."""
        self._callbacks["transition"].append((transition_cb, list(cb_args)))

    def register_termination_cb(
        self, termination_cb: Callable[..., Any], cb_args: Iterable[Any] = ()
    ) -> None:
        """Call back when it ends: with the data, the last states, the outcome and `cb_args`."""
        self._callbacks["termination"].append((termination_cb, list(cb_args)))

    def call_start_cbs(self) -> None:
        """Call who wants to know of the start."""
        self._call("start", self.get_initial_states())

    def call_transition_cbs(self) -> None:
        """Call who wants to know of a transition."""
        self._call("transition", self.get_active_states())

    def call_termination_cbs(self, terminal_states: list[str], outcome: str) -> None:
        """Call who wants to know of the end."""
        self._call("termination", terminal_states, outcome)

    def _call(self, kind: str, *data: Any) -> None:
        for callback, args in self._callbacks[kind]:
            try:
                callback(self.userdata, *data, *args)
            except Exception as error:
                log.logerr(f"a {kind} callback raised {error}")
                raise InvalidUserCodeError(f"a {kind} callback raised {error}") from error

    def _execute_state(self, label: str) -> str:
        """Execute one state; return its outcome."""
        state = self._states[label]
        data = Remapper(
            self.userdata,
            state.get_registered_input_keys(),
            state.get_registered_output_keys(),
            self._remappings[label],
        )
        try:
            outcome = state.execute(data)
        except InvalidUserCodeError:
            log.logerr(f"state '{label}' did not come to an outcome")
            raise
        except Exception as error:
            raised = traceback.format_exc()
            raise InvalidUserCodeError(f"state '{label}' raised: {raised}") from error
        if outcome not in state.get_registered_outcomes():
            raise InvalidUserCodeError(
                f"state '{label}' ({type(state).__name__}) returned '{outcome}', which is none of "
                f"its outcomes: {list(state.get_registered_outcomes())}"
            )
        return str(outcome)

    def _begin(self, parent_ud: Any) -> None:
        self._is_running = True
        for key in self.get_registered_input_keys():
            if key in parent_ud:
                self.userdata[key] = parent_ud[key]

    def _finish(self, parent_ud: Any) -> None:
        self._is_running = False
        for key in self.get_registered_output_keys():
            if key in self.userdata:
                parent_ud[key] = self.userdata[key]

    def _forbid(self, condition: bool, message: str) -> None:
        if condition:
            raise InvalidConstructionError(message)
