"""A state that waits for a message for which a condition fails."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from typing import Any

import rospy
import smach


class MonitorState(smach.State):  # type: ignore[misc]
    """`invalid` once the condition fails, `valid` after `max_checks` messages, `preempted`."""

    def __init__(
        self,
        topic: str,
        msg_type: Any,
        cond_cb: Callable[..., bool],
        max_checks: int = -1,
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
    ) -> None:
        super().__init__(("valid", "invalid", "preempted"), input_keys, output_keys)
        self.register_input_keys(getattr(cond_cb, "_smach_input_keys", ()))
        self.register_output_keys(getattr(cond_cb, "_smach_output_keys", ()))
        self._topic, self._msg_type = topic, msg_type
        self._cond_cb, self._max_checks = cond_cb, max_checks
        self._is_over = threading.Event()

    def execute(self, ud: Any) -> str:
        """Look at messages; return what they show."""
        if self.preempt_requested():
            self.service_preempt()
            return "preempted"
        checks = 0
        outcome = "preempted"
        self._is_over.clear()

        def check(message: Any) -> None:
            nonlocal checks, outcome
            if self._is_over.is_set():
                return
            checks += 1
            if not self._cond_cb(ud, message):
                outcome = "invalid"
            elif checks == self._max_checks:
                outcome = "valid"
            else:
                return
            self._is_over.set()

        subscriber = rospy.Subscriber(self._topic, self._msg_type, check)
        self._is_over.wait()
        subscriber.unregister()
        if self.preempt_requested():
            self.service_preempt()
        return outcome

    def request_preempt(self) -> None:
        """Ask the state to end."""
        super().request_preempt()
        self._is_over.set()
