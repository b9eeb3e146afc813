"""Lifecycle nodes: their transitions, and the services by which others ask for them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from lifecycle_msgs.msg import State as StateMsg
from lifecycle_msgs.msg import Transition as TransitionMsg
from lifecycle_msgs.msg import TransitionDescription, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState

from tracerisk.ros.graph.failures import callback_failed

from .._rclpy_pybind11 import RCLError
from ..callback_groups import CallbackGroup
from ..node import Node
from ..qos import QoSProfile
from ._state_machine import GRAPH, STATES, StateMachine, Transition
from .managed_entity import ManagedEntity, TransitionCallbackReturn
from .publisher import LifecyclePublisher

_SUCCESS = TransitionCallbackReturn.SUCCESS
_CALLBACKS = {
    "configuring": "on_configure",
    "cleaningup": "on_cleanup",
    "shuttingdown": "on_shutdown",
    "activating": "on_activate",
    "deactivating": "on_deactivate",
    "errorprocessing": "on_error",
}
_SHUTDOWNS = {
    "unconfigured": TransitionMsg.TRANSITION_UNCONFIGURED_SHUTDOWN,
    "inactive": TransitionMsg.TRANSITION_INACTIVE_SHUTDOWN,
    "active": TransitionMsg.TRANSITION_ACTIVE_SHUTDOWN,
}


class LifecycleState(NamedTuple):
    """A state of a lifecycle node."""

    label: str
    """The name of the state."""
    state_id: int
    """The number of the state in lifecycle_msgs."""


class LifecycleNodeMixin(ManagedEntity):
    """What makes a `Node` a lifecycle node; `Node.__init__` comes first.

    Raises:
        RuntimeError: the class is not derived from Node.
        TypeError: `enable_communication_interface` is no bool.
    """

    def __init__(
        self,
        *,
        enable_communication_interface: bool = True,
        callback_group: CallbackGroup | None = None,
    ) -> None:
        if not isinstance(self, Node):
            raise RuntimeError(
                "LifecycleNodeMixin uses Node fields so Node needs to be in the inheritance tree."
            )
        if not isinstance(enable_communication_interface, bool):
            raise TypeError("enable_communication_interface must be a bool")
        # A list: the order in which entities are notified must be the same in every run.
        self._managed_entities: list[ManagedEntity] = []
        self._state_machine = StateMachine()
        self._transition_events: Any = None
        if not enable_communication_interface:
            return
        self._transition_events = Node.create_publisher(
            self, TransitionEvent, "~/transition_event", QoSProfile(depth=10)
        )
        for srv_type, name, callback in (
            (ChangeState, "change_state", self._on_change_state),
            (GetState, "get_state", self._on_get_state),
            (GetAvailableStates, "get_available_states", self._on_get_available_states),
            (GetAvailableTransitions, "get_available_transitions", self._on_get_transitions),
            (GetAvailableTransitions, "get_transition_graph", self._on_get_graph),
        ):
            made = self.create_service(
                srv_type, f"~/{name}", callback, callback_group=callback_group
            )
            setattr(self._state_machine, f"service_{name}", made)

    def trigger_configure(self) -> TransitionCallbackReturn:
        """Go from unconfigured to inactive."""
        return self._change_state(TransitionMsg.TRANSITION_CONFIGURE)

    def trigger_cleanup(self) -> TransitionCallbackReturn:
        """Go from inactive to unconfigured."""
        return self._change_state(TransitionMsg.TRANSITION_CLEANUP)

    def trigger_shutdown(self) -> TransitionCallbackReturn:
        """Go to finalized.

        Raises:
            RCLError: the node is finalized, or within a transition.
        """
        number = _SHUTDOWNS.get(self._state_machine.label)
        if number is None:
            raise RCLError("Shutdown transtion not possible")
        return self._change_state(number)

    def trigger_activate(self) -> TransitionCallbackReturn:
        """Go from inactive to active."""
        return self._change_state(TransitionMsg.TRANSITION_ACTIVATE)

    def trigger_deactivate(self) -> TransitionCallbackReturn:
        """Go from active to inactive."""
        return self._change_state(TransitionMsg.TRANSITION_DEACTIVATE)

    def add_managed_entity(self, entity: ManagedEntity) -> None:
        """Notify an entity of transitions too.

        Raises:
            TypeError: it is none.
        """
        if not isinstance(entity, ManagedEntity):
            raise TypeError("Expected a rclpy.lifecycle.ManagedEntity instance.")
        if entity not in self._managed_entities:
            self._managed_entities.append(entity)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Ask the managed entities; the first that does not agree decides."""
        return self._ask_entities("on_configure", state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Ask the managed entities; the first that does not agree decides."""
        return self._ask_entities("on_cleanup", state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Ask the managed entities; the first that does not agree decides."""
        return self._ask_entities("on_shutdown", state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Ask the managed entities; the first that does not agree decides."""
        return self._ask_entities("on_activate", state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Ask the managed entities; the first that does not agree decides."""
        return self._ask_entities("on_deactivate", state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Ask the managed entities; the first that does not agree decides."""
        return self._ask_entities("on_error", state)

    def create_lifecycle_publisher(
        self, msg_type: Any, topic: str, qos_profile: QoSProfile | int, **kwargs: Any
    ) -> LifecyclePublisher:
        """Make a publisher that sends only while the node is active; see `create_publisher`."""
        assert isinstance(self, Node)
        if kwargs.pop("publisher_class", None):
            raise TypeError(
                "create_publisher() got an unexpected keyword argument 'publisher_class'"
            )
        made = Node.create_publisher(
            self, msg_type, topic, qos_profile, publisher_class=LifecyclePublisher, **kwargs
        )
        assert isinstance(made, LifecyclePublisher)
        self.add_managed_entity(made)
        return made

    def destroy_lifecycle_publisher(self, publisher: LifecyclePublisher) -> bool:
        """Destroy such a publisher; False where it is none of the node's."""
        assert isinstance(self, Node)
        if publisher in self._managed_entities:
            self._managed_entities.remove(publisher)
        return self.destroy_publisher(publisher)

    # How

    def _ask_entities(self, name: str, state: LifecycleState) -> TransitionCallbackReturn:
        for entity in list(self._managed_entities):
            answer = getattr(entity, name)(state)
            if not isinstance(answer, TransitionCallbackReturn):
                raise TypeError(
                    f"{name}() return value of class {type(entity)} should be "
                    "`TransitionCallbackReturn`.\n"
                    f"Instance of the class that caused the failure: {entity}"
                )
            if answer is not _SUCCESS:
                return answer
        return _SUCCESS

    def _change_state(self, number: int) -> TransitionCallbackReturn:
        transition = self._state_machine.by_id(number)
        before = LifecycleState(self._state_machine.label, self._state_machine.state)
        self._enter(transition)
        answer = self._call_back(before)
        self._enter(self._state_machine.by_label(answer.to_label()))
        if answer is TransitionCallbackReturn.ERROR:
            recovered = self._call_back(before)
            self._enter(self._state_machine.by_label(recovered.to_label()))
        return answer

    def _enter(self, transition: Transition) -> None:
        self._state_machine.state = transition.goal
        if self._transition_events is not None:
            self._transition_events.publish(
                TransitionEvent(
                    start_state=_state(transition.start), goal_state=_state(transition.goal)
                )
            )

    def _call_back(self, before: LifecycleState) -> TransitionCallbackReturn:
        callback: Callable[[LifecycleState], Any]
        callback = getattr(self, _CALLBACKS[self._state_machine.label])
        try:
            answer = callback(before)
        except Exception as error:  # noqa: BLE001  # the real library turns each into ERROR
            assert isinstance(self, Node)
            callback_failed(f"the callback {callback.__name__}", error)
            self.get_logger().error(f"{callback.__name__} raised {type(error).__name__}: {error}")
            return TransitionCallbackReturn.ERROR
        if isinstance(answer, TransitionCallbackReturn):
            return answer
        raise AttributeError(f"'{type(answer).__name__}' object has no attribute 'to_label'")

    def _on_change_state(self, request: Any, response: Any) -> Any:
        number = request.transition.id
        if request.transition.label:
            try:
                number = self._state_machine.by_label(request.transition.label).id
            except RCLError:
                response.success = False
                return response
        response.success = self._change_state(number) is _SUCCESS
        return response

    def _on_get_state(self, request: Any, response: Any) -> Any:
        response.current_state = _state(self._state_machine.state)
        return response

    def _on_get_available_states(self, request: Any, response: Any) -> Any:
        response.available_states = [_state(number) for number in STATES]
        return response

    def _on_get_transitions(self, request: Any, response: Any) -> Any:
        response.available_transitions = [_description(t) for t in self._state_machine.available]
        return response

    def _on_get_graph(self, request: Any, response: Any) -> Any:
        response.available_transitions = [_description(transition) for transition in GRAPH]
        return response


class LifecycleNode(LifecycleNodeMixin, Node):
    """A node with a life cycle; the keywords are those of `Node`."""

    def __init__(
        self, node_name: str, *, enable_communication_interface: bool = True, **kwargs: Any
    ) -> None:
        Node.__init__(self, node_name, **kwargs)
        LifecycleNodeMixin.__init__(
            self, enable_communication_interface=enable_communication_interface
        )


def _state(number: int) -> Any:
    return StateMsg(id=number, label=STATES[number])


def _description(transition: Transition) -> Any:
    description = TransitionDescription(
        start_state=_state(transition.start), goal_state=_state(transition.goal)
    )
    description.transition.id, description.transition.label = transition.id, transition.label
    return description
