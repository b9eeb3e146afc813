"""How an execution ended."""

from __future__ import annotations

from typing import Any

from tracerisk.ros.moveit.trajectory_execution import ErrorCode

__all__ = ["ExecutionStatus"]

_STATUS_OF = {ErrorCode.SUCCESS: "SUCCEEDED", ErrorCode.PREEMPTED: "PREEMPTED"}


class ExecutionStatus:
    """The status of an execution; true where it succeeded."""

    _status: str

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        raise TypeError("moveit.core.controller_manager.ExecutionStatus: No constructor defined!")

    @classmethod
    def _of(cls, status: str) -> ExecutionStatus:
        made = cls.__new__(cls)
        made._status = status
        return made

    @classmethod
    def _of_code(cls, code: ErrorCode) -> ExecutionStatus:
        return cls._of(_STATUS_OF.get(code, "ABORTED"))

    @property
    def status(self) -> str:
        """UNKNOWN, RUNNING, SUCCEEDED, PREEMPTED, TIMED_OUT, ABORTED or FAILED."""
        return self._status

    def __bool__(self) -> bool:
        return self._status == "SUCCEEDED"
