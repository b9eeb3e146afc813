"""How an execution ended."""

from __future__ import annotations

from tracerisk.ros.moveit.trajectory_execution import ErrorCode

from .._library import HandedOut

__all__ = ["ExecutionStatus"]

_STATUS_OF = {
    ErrorCode.SUCCESS: "SUCCEEDED",
    ErrorCode.PREEMPTED: "PREEMPTED",
    ErrorCode.TIMED_OUT: "TIMED_OUT",
}


class ExecutionStatus(HandedOut):
    """The status of an execution; true where it succeeded."""

    _status: str

    @classmethod
    def _of_code(cls, code: ErrorCode) -> ExecutionStatus:
        return cls._of(_status=_STATUS_OF.get(code, "ABORTED"))

    @property
    def status(self) -> str:
        """UNKNOWN, RUNNING, SUCCEEDED, PREEMPTED, TIMED_OUT, ABORTED or FAILED."""
        return self._status

    def __bool__(self) -> bool:
        return self._status == "SUCCEEDED"
