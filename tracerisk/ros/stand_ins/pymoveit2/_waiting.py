"""The use of a node: asking, and waiting for what its callbacks bring, whoever runs them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rclpy
from rclpy._run import run

from tracerisk.ros.controller.thread import Meaning


class OnNode:
    """Asks services by a node, waits for what they answer, and warns by its logger."""

    _node: Any
    _callback_group: Any

    def _client(self, kind: Any, name: str) -> Any:
        return self._node.create_client(kind, name, callback_group=self._callback_group)

    def _is_ready(self, client: Any, timeout_sec: float | None = 3.0) -> bool:
        if client.wait_for_service(timeout_sec=timeout_sec):
            return True
        self._warn(f"Service '{client.srv_name}' is not yet available.")
        return False

    def _wait(self, future: Any) -> Any:
        wait_until(self._node, lambda: future._done, future._awaited or "a future")
        return future.result()

    def _warn(self, message: str) -> None:
        self._node.get_logger().warning(message)


def wait_until(node: Any, is_over: Callable[[], bool], reason: str) -> None:
    """Wait until `is_over` holds; `reason` says what the wait is for.

    While another thread spins the node's executor, that runs the callbacks, as in the releases up
    to 4.0; later ones always spin the node here, which takes it from its executor for good.
    Where no other thread spins the node, this one does.
    """
    scheduler = run().scheduler
    thread = scheduler.current
    while not is_over():
        executor = node.executor
        if not _is_spun(node, executor, thread):
            rclpy.spin_once(node, timeout_sec=1.0)
            continue
        scheduler.wait_until(
            lambda executor=executor: is_over() or not _is_spun(node, executor, thread),
            reason=reason,
            kind=lambda: Meaning("unmet", node._meaning_of_wait().why),
        )


def _is_spun(node: Any, executor: Any, thread: Any) -> bool:
    return executor is not None and node in executor._nodes and executor._is_spun_beside(thread)
