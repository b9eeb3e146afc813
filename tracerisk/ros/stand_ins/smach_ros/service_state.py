"""A state that calls a service."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import rospy
import smach

from .slots import Slots


class ServiceState(smach.State):  # type: ignore[misc]
    """`succeeded` with an answer, `aborted` without one, `preempted` where it was asked to end."""

    def __init__(
        self,
        service_name: str,
        service_spec: Any,
        request: Any = None,
        request_key: str | None = None,
        request_slots: Iterable[str] = (),
        request_cb: Callable[..., Any] | None = None,
        request_cb_args: Sequence[Any] = (),
        request_cb_kwargs: dict[str, Any] | None = None,
        response_key: str | None = None,
        response_slots: Iterable[str] = (),
        response_cb: Callable[..., Any] | None = None,
        response_cb_args: Sequence[Any] = (),
        response_cb_kwargs: dict[str, Any] | None = None,
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        outcomes: Iterable[str] = (),
    ) -> None:
        super().__init__(("succeeded", "aborted", "preempted", *outcomes), input_keys, output_keys)
        self._name, self._spec = service_name, service_spec
        self._request = Slots(
            request, request_key, request_slots, request_cb, request_cb_args, request_cb_kwargs
        )
        self._response = Slots(
            None, response_key, response_slots, response_cb, response_cb_args, response_cb_kwargs
        )
        self.register_input_keys(self._request.keys)
        self.register_output_keys(self._response.keys)
        self.register_outcomes(self._response.outcomes)

    def execute(self, ud: Any) -> str:
        """Call the service; return how it went."""
        if self.preempt_requested():
            self.service_preempt()
            return "preempted"
        rospy.wait_for_service(self._name)
        request = self._request.filled(ud, self._spec._request_class)
        try:
            answer = rospy.ServiceProxy(self._name, self._spec)(request)
        except rospy.ServiceException as error:
            smach.logerr(f"service {self._name} failed: {error}")
            return "aborted"
        return self._response.keep(ud, answer) or "succeeded"
