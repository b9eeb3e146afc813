"""A state that asks a function again and again until it says yes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import rospy
import smach


class ConditionState(smach.State):  # type: ignore[misc]
    """`true` once the condition holds, `false` when it has not for long, `preempted`."""

    def __init__(
        self,
        cond_cb: Callable[..., bool],
        input_keys: Iterable[str] = (),
        poll_rate: Any = None,
        timeout: Any = None,
        max_checks: int = 1,
    ) -> None:
        super().__init__(("true", "false", "preempted"), input_keys)
        self.register_input_keys(getattr(cond_cb, "_smach_input_keys", ()))
        self._cond_cb = cond_cb
        self._poll_rate = poll_rate or rospy.Duration(0.05)
        self._timeout, self._max_checks = timeout, max_checks

    def execute(self, ud: Any) -> str:
        """Ask; return the answer."""
        began, checks = rospy.Time.now(), 0
        while self._max_checks == -1 or checks < self._max_checks:
            if self._timeout and rospy.Time.now() - began > self._timeout:
                break
            if self.preempt_requested():
                self.service_preempt()
                return "preempted"
            if self._cond_cb(ud):
                return "true"
            checks += 1
            rospy.sleep(self._poll_rate)
        return "false"
