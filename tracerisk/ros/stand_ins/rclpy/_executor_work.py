"""How an executor finds work: tasks first, then the entities of its nodes, in rclpy's order."""

from __future__ import annotations

from collections import deque
from typing import Any

from tracerisk.ros.controller.thread import WaitKind

from ._run import Run
from .context import Context
from .task import Future, Task


class WorkFinding:
    """What finds the work of an executor, and waits for it; a part of `Executor`."""

    _run: Run
    _context: Context
    _nodes: list[Any]
    _tasks: list[Task]
    _batch: deque[Any]
    _has_looked_at_tasks: bool
    _is_shutdown: bool
    _n_waiting: int
    _n_working: int

    def _from_batch(self) -> Task | None:
        while self._batch:
            work = self._batch.popleft()
            if isinstance(work, Task):
                if work.is_ready:
                    return work
            elif self._can_run(work):
                return self._task_of(work)
        return None

    def _ready(self) -> list[Any]:
        """Return tasks that go on, else entities that have work, in the order of rclpy.

        After tasks entities come first: tasks that others have made wait for their next turn.
        """
        ready: list[Any] = []
        if not self._has_looked_at_tasks:
            ready = self._ready_tasks()
        if not ready:
            ready = self._ready_entities()
        elif not self._has_looked_at_tasks:
            self._has_looked_at_tasks = True
            return ready
        self._has_looked_at_tasks = False
        return ready or self._ready_tasks()

    def _ready_tasks(self) -> list[Any]:
        """Return the tasks that go on, the newest first."""
        self._tasks = [task for task in self._tasks if not task._done and not task._cancelled]
        return [task for task in reversed(self._tasks) if self._goes_on_with(task)]

    def _ready_entities(self) -> list[Any]:
        ready_entities: list[Any] = []
        for node in self._nodes:
            ready_entities.extend(
                waitable for waitable in node._waitables if self._can_run(waitable)
            )
        for node in self._nodes:
            ready_entities.extend(entity for entity in node._entities() if self._can_run(entity))
        return ready_entities

    def _goes_on_with(self, task: Task) -> bool:
        # A coroutine of a node that has left is not resumed.
        return task.is_ready and (task._node is None or task._node in self._nodes)

    def _can_run(self, entity: Any) -> bool:
        return (
            not entity._is_taken
            and not entity._is_destroyed
            and entity._is_ready()
            and entity.callback_group.can_execute(entity)
        )

    def _has_work(self) -> bool:
        if any(self._goes_on_with(task) for task in self._tasks):
            return True
        return any(
            self._can_run(entity)
            for node in self._nodes
            for entity in (*node._waitables, *node._entities())
        )

    def _wait(self, timeout_ns: int | None, future: Future | None) -> bool:
        """Wait until there is work; False after the timeout."""
        scheduler = self._run.scheduler
        kind, reason = _what_is_waited_for(future)
        due = [
            entity._due_ns
            for node in self._nodes
            for entity in node._timers
            if entity._due_ns is not None
            and not entity._is_taken
            and entity.callback_group.can_execute(entity)
        ]
        alarm = scheduler.call_at(min(due), _nothing) if due else None
        # A node, a timer or a task that is made meanwhile has to be looked at.
        known = self._work_known()
        self._n_waiting += 1
        try:
            return scheduler.wait_until(
                lambda: (
                    self._is_shutdown
                    or not self._context.is_valid
                    or (future is not None and future.is_over)
                    or self._work_known() != known
                    or self._has_work()
                ),
                timeout_ns=timeout_ns,
                reason=reason,
                kind=kind,
            )
        finally:
            self._n_waiting -= 1
            if alarm is not None:
                alarm.cancel()

    def _work_known(self) -> tuple[Any, ...]:
        return (
            len(self._tasks),
            *(
                timer._due_ns
                for node in self._nodes
                for timer in node._timers
                if timer.callback_group.can_execute(timer)
            ),
        )

    def _task_of(self, entity: Any) -> Task:
        entity._is_taken = True
        tracer = self._run.tracer
        stack = None if tracer is None else tracer.root(entity._root_kind)
        task = Task(self._handle, (entity,), executor=self, stack=stack)
        task._entity, task._node = entity, entity._node
        self._tasks.append(task)
        return task

    async def _handle(self, entity: Any) -> None:
        group = entity.callback_group
        if self._is_shutdown or entity._is_destroyed or not group.beginning_execution(entity):
            entity._is_taken = False
            return
        self._n_working += 1
        try:
            call = entity._take(self)
            entity._is_taken = False
            if call is not None:
                await call()
        finally:
            self._n_working -= 1
            group.ending_execution(entity)


def _what_is_waited_for(future: Future | None) -> tuple[WaitKind, str]:
    if future is None:
        return "idle", "callbacks"
    awaited = future._awaited
    return ("blocked", "a future") if awaited is None else ("unmet", awaited)


def _nothing() -> None:
    """Mark a timer as due; the executor that waits sees it."""
