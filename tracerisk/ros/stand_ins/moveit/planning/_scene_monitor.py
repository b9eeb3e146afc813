"""The monitor that keeps the planning scene up to date, and its lock."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

from tracerisk.ros.controller.thread import ControllerThread
from tracerisk.ros.messages.dialect import nanoseconds
from tracerisk.ros.time.clock import EPOCH_NS

from .._library import HandedOut, library
from ..core.planning_scene import PlanningScene
from ..core.robot_model import RobotModel
from ..core.robot_state import RobotState

_LOCK = "the lock of the planning scene"


class PlanningSceneMonitor(HandedOut):
    """Keeps the scene that is planned in: the robot as it stands, the objects as declared."""

    @classmethod
    def _of_run(cls) -> PlanningSceneMonitor:
        made = cls._of(
            _library=library(),
            _scene=PlanningScene(RobotModel._of_run())._monitored(),
            _lock=_SceneLock(library().scheduler),
            _followed_ns=-1,
            _follows=True,
        )
        made._scene.current_state._refresh = made._follow
        return made

    _library: Any
    _scene: PlanningScene
    _lock: _SceneLock
    _followed_ns: int
    _follows: bool

    @property
    def name(self) -> str:
        """The monitor's name."""
        return "planning_scene_monitor"

    # The scene

    def read_only(self) -> LockedPlanningSceneContextManagerRO:
        """Return a context manager that gives the scene, with others who read it."""
        return LockedPlanningSceneContextManagerRO._of(_monitor=self)

    def read_write(self) -> LockedPlanningSceneContextManagerRW:
        """Return a context manager that gives the scene to nobody else meanwhile.

        As in the real library planning within the block raises a RuntimeError: it needs the lock.
        Within a block of `read_only` it waits for ever.
        """
        return LockedPlanningSceneContextManagerRW._of(_monitor=self)

    def process_collision_object(self, collision_object_msg: Any, color_msg: Any = None) -> bool:
        """Apply a CollisionObject: add, append, move or remove; with an ObjectColor."""
        server = self._library.server

        def change() -> bool:
            if color_msg is not None:
                server.scene.colors[color_msg.id] = color_msg
            return bool(server.changes.apply(collision_object_msg))

        return self._write(change)

    def process_attached_collision_object(self, attached_collision_object_msg: Any) -> bool:
        """Apply an AttachedCollisionObject: attach or detach."""
        changes = self._library.server.changes
        return self._write(lambda: bool(changes.apply_attached(attached_collision_object_msg)))

    def new_planning_scene_message(self, scene: Any) -> bool:
        """Apply a PlanningScene message, whole or a difference."""
        changes = self._library.server.changes
        return self._write(lambda: bool(changes.apply_scene(scene)))

    def clear_octomap(self) -> None:
        """Forget the octomap; there is none."""

    def update_frame_transforms(self) -> None:
        """Look up the frames outside the robot; waits for the lock."""
        self._write(lambda: True)

    # The monitor

    def start_scene_monitor(self, scene_topic: str = "planning_scene") -> None:
        """Follow the scenes that are published; the twin's scene always does."""

    def stop_scene_monitor(self) -> None:
        """Follow published scenes no longer; the twin's scene has one keeper, and goes on."""

    def start_state_monitor(
        self,
        joint_states_topic: str = "joint_states",
        attached_objects_topic: str = "attached_collision_object",
    ) -> None:
        """Make the scene's state follow the robot."""
        self._follows = True

    def stop_state_monitor(self) -> None:
        """Keep the scene's state as it is."""
        self._follows = False

    def request_planning_scene_state(self, service_name: str = "get_planning_scene") -> bool:
        """Ask a service for the scene; the monitor's is that scene already."""
        return True

    def wait_for_current_robot_state(self, t: Any = None, wait_time: float = 1.0) -> bool:
        """Wait until the robot's state is of a time, at most `wait_time` [s]; return whether it is.

        Without a time, of the present.
        """
        scheduler = self._library.scheduler
        if t is None:
            scheduler.touch()
            return True
        wanted_ns = nanoseconds(t) - EPOCH_NS
        left_ns = wanted_ns - scheduler.now_ns
        if left_ns > 0:
            scheduler.sleep(min(left_ns, round(wait_time * 1e9)))
        return bool(scheduler.now_ns >= wanted_ns)

    # How

    def _state(self) -> RobotState:
        """Return the robot's present state, a copy."""
        made = copy.copy(self._scene.current_state)
        made._take(self._library.server.positions())
        return made

    def _follow(self) -> None:
        """Update the scene's state from the robot if time has passed and nobody holds the lock.

        A program may keep the state beyond the block that gave it: it is the monitor's own.
        """
        if self._follows and not self._lock.is_held:
            self._library.scheduler.touch()
            if self._library.scheduler.now_ns != self._followed_ns:
                self._look()

    def _look(self) -> None:
        if self._follows:
            positions = self._library.server.positions()
            self._followed_ns = self._library.scheduler.now_ns
            self._scene.current_state._take(positions)

    def _write(self, change: Callable[[], bool]) -> bool:
        self._lock.acquire(alone=True)
        try:
            return change()
        finally:
            self._lock.release(alone=True)

    def _enter(self, *, alone: bool) -> PlanningScene:
        self._lock.acquire(alone=alone)
        self._look()
        return self._scene


class _SceneLock:
    """A lock for one writer or several readers, as `std::shared_mutex` is on Linux.

    A writer who asks for it again gets an error, a reader who would write waits for ever.
    """

    def __init__(self, scheduler: Any) -> None:
        self._scheduler = scheduler
        self._readers: list[ControllerThread | None] = []
        self._writer: ControllerThread | None = None
        self._is_written = False

    @property
    def is_held(self) -> bool:
        """Whether anybody reads or writes."""
        return self._is_written or bool(self._readers)

    @property
    def holder(self) -> ControllerThread | None:
        """A thread that holds the lock, for the report of a deadlock."""
        return self._writer or next(iter(self._readers), None)

    def acquire(self, *, alone: bool) -> None:
        """Wait for the lock and take it.

        Raises:
            RuntimeError: the thread writes already.
        """

        def is_free() -> bool:
            return not self._is_written and not (alone and self._readers)

        thread = self._scheduler.current
        if self._is_written and thread is self._writer:
            raise RuntimeError(
                f"Resource deadlock avoided: the thread holds {_LOCK} already; leave the block of "
                "read_write() first"
            )
        holds = thread in self._readers
        reason = (
            f"{_LOCK}, which it holds itself (leave the `with` block first)" if holds else _LOCK
        )
        self._scheduler.wait_until(is_free, reason=reason, on=self)
        if alone:
            self._is_written, self._writer = True, thread
        else:
            self._readers.append(thread)

    def release(self, *, alone: bool) -> None:
        """Leave the lock."""
        if alone:
            self._is_written, self._writer = False, None
        elif self._scheduler.current in self._readers:
            self._readers.remove(self._scheduler.current)
        else:
            del self._readers[:1]


class _Locked(HandedOut):
    """The scene, locked within the block."""

    _alone = False
    _monitor: PlanningSceneMonitor

    def __enter__(self) -> PlanningScene:
        return self._monitor._enter(alone=self._alone)

    def __exit__(self, *error: object) -> None:
        self._monitor._lock.release(alone=self._alone)


class LockedPlanningSceneContextManagerRO(_Locked):
    """Gives the scene for reading."""


class LockedPlanningSceneContextManagerRW(_Locked):
    """Gives the scene for reading and writing."""

    _alone = True
