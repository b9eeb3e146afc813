"""The server of markers: it shows them on topics, and hears on another what is done with them."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerFeedback,
    InteractiveMarkerInit,
    InteractiveMarkerPose,
    InteractiveMarkerUpdate,
)

from tracerisk.ros.messages.dialect import is_ros2

from ._ends import Ends, Ends1, Ends2

__all__ = [
    "InteractiveMarker",
    "InteractiveMarkerFeedback",
    "InteractiveMarkerInit",
    "InteractiveMarkerPose",
    "InteractiveMarkerServer",
    "InteractiveMarkerUpdate",
    "MarkerContext",
    "UpdateContext",
]

Callback = Callable[[Any], object]
_DEFAULT = 255


@dataclass
class MarkerContext:
    """A marker that is shown."""

    int_marker: Any
    """The marker, an InteractiveMarker."""
    default_feedback_cb: Callback | None = None
    """The function that is called with feedback for which there is no other."""
    feedback_cbs: dict[int, Callback] = field(default_factory=dict)
    """The function for each kind of feedback."""


@dataclass
class UpdateContext:
    """A change of a marker that is not shown yet."""

    FULL_UPDATE = 0
    POSE_UPDATE = 1
    ERASE = 2

    update_type: int
    """What changes: all of the marker, its pose, or that it is there at all."""
    int_marker: Any = None
    """The marker as it will be, an InteractiveMarker; `None` where it is erased."""
    default_feedback_cb: Callback | None = None
    """The function that is called with feedback for which there is no other."""
    feedback_cbs: dict[int, Callback] = field(default_factory=dict)
    """The function for each kind of feedback."""


class InteractiveMarkerServer:
    """Shows markers below a name, and calls functions with what is done with them.

    In ROS 1 it is made of the name, in ROS 2 of the node and the name.
    """

    DEFAULT_FEEDBACK_CB = _DEFAULT

    def __init__(self, *given: Any, **named: Any) -> None:
        self.marker_contexts: dict[str, MarkerContext] = {}
        self.pending_updates: dict[str, UpdateContext] = {}
        self.seq_num = 0
        make = Ends2 if is_ros2(InteractiveMarker) else Ends1
        self._ends: Ends = make(self.processFeedback, self._shown, *given, **named)
        self.publishInit()

    def __len__(self) -> int:
        return len(self.marker_contexts)

    def shutdown(self) -> None:
        """Take all markers away."""
        self.clear()
        self.applyChanges()

    def empty(self) -> bool:
        """Return whether no marker is shown."""
        return not self.marker_contexts

    def size(self) -> int:
        """Return how many markers are shown."""
        return len(self.marker_contexts)

    def insert(
        self,
        marker: Any,
        feedback_callback: Any = -1,
        feedback_type: int = _DEFAULT,
        *,
        feedback_cb: Any = -1,
    ) -> None:
        """Show a marker from the next `applyChanges` on, with a function for its feedback.

        ROS 1 calls that `feedback_cb`.
        """
        feedback_callback = feedback_cb if feedback_callback == -1 else feedback_callback
        shown = self.marker_contexts.get(marker.name)
        update = self.pending_updates.get(marker.name)
        if update is None or update.update_type == UpdateContext.ERASE:
            known = {} if shown is None else dict(shown.feedback_cbs)
            default = None if shown is None else shown.default_feedback_cb
            update = UpdateContext(UpdateContext.FULL_UPDATE, None, default, known)
        update.update_type = UpdateContext.FULL_UPDATE
        update.int_marker = copy.deepcopy(marker)
        self.pending_updates[marker.name] = update
        if feedback_callback not in (-1, None):
            self.setCallback(marker.name, feedback_callback, feedback_type)

    def setPose(self, name: str, pose: Any, header: Any = None) -> bool:
        """Move a marker at the next `applyChanges`; return whether there is one of that name."""
        update, shown = self.pending_updates.get(name), self.marker_contexts.get(name)
        if update is None:
            if shown is None:
                return False
            update = UpdateContext(
                UpdateContext.POSE_UPDATE,
                copy.deepcopy(shown.int_marker),
                shown.default_feedback_cb,
                dict(shown.feedback_cbs),
            )
            self.pending_updates[name] = update
        elif update.update_type == UpdateContext.ERASE:
            return False
        update.int_marker.pose = copy.deepcopy(pose)
        if header is not None and header.frame_id:
            update.int_marker.header = copy.deepcopy(header)
        return True

    def erase(self, name: str) -> bool:
        """Take a marker away at the next `applyChanges`; return whether there is one."""
        if name in self.marker_contexts:
            self.pending_updates[name] = UpdateContext(UpdateContext.ERASE)
            return True
        return self.pending_updates.pop(name, None) is not None

    def clear(self) -> None:
        """Take all markers away at the next `applyChanges`."""
        self.pending_updates = {}
        for name in list(self.marker_contexts):
            self.erase(name)

    def setCallback(
        self,
        name: str,
        feedback_callback: Callback | None = None,
        feedback_type: int = _DEFAULT,
        *,
        feedback_cb: Callback | None = None,
    ) -> bool:
        """Set the function for a kind of feedback of a marker, or for all others; None takes it.

        ROS 1 calls it `feedback_cb`.
        """
        feedback_callback = feedback_callback or feedback_cb
        contexts = (self.marker_contexts.get(name), self.pending_updates.get(name))
        known = [context for context in contexts if context is not None]
        for context in known:
            if feedback_type == _DEFAULT:
                context.default_feedback_cb = feedback_callback
            elif feedback_callback is None:
                context.feedback_cbs.pop(feedback_type, None)
            else:
                context.feedback_cbs[feedback_type] = feedback_callback
        return bool(known)

    def get(self, name: str) -> Any:
        """Return a marker as it will be after `applyChanges`; None where there is none."""
        update = self.pending_updates.get(name)
        if update is not None:
            return copy.deepcopy(update.int_marker)
        shown = self.marker_contexts.get(name)
        return None if shown is None else copy.deepcopy(shown.int_marker)

    def applyChanges(self) -> None:
        """Show what was changed since the last time."""
        if not self.pending_updates:
            return
        message = InteractiveMarkerUpdate()
        message.type = InteractiveMarkerUpdate.UPDATE
        for name, update in self.pending_updates.items():
            if update.update_type == UpdateContext.ERASE:
                self.marker_contexts.pop(name, None)
                message.erases.append(name)
                continue
            is_pose = update.update_type == UpdateContext.POSE_UPDATE
            if is_pose and name in self.marker_contexts:
                marker = update.int_marker
                pose = InteractiveMarkerPose(header=marker.header, pose=marker.pose, name=name)
                message.poses.append(pose)
            else:
                message.markers.append(update.int_marker)
            self.marker_contexts[name] = MarkerContext(
                update.int_marker, update.default_feedback_cb, update.feedback_cbs
            )
        self.pending_updates = {}
        self.seq_num += 1
        message.seq_num = self.seq_num
        message.server_id = self._ends.name
        self._ends.update(message)
        self.publishInit()

    def publishInit(self) -> None:
        """Send all markers to new viewers."""
        message = InteractiveMarkerInit()
        message.seq_num = self.seq_num
        message.server_id = self._ends.name
        message.markers.extend(self._shown())
        self._ends.init(message)

    def processFeedback(self, feedback: Any) -> None:
        """Move a marker as a user did, and call the function for it."""
        context = self.marker_contexts.get(feedback.marker_name)
        if context is None:
            return
        if feedback.event_type == InteractiveMarkerFeedback.POSE_UPDATE:
            self.setPose(feedback.marker_name, feedback.pose, feedback.header)
        call = context.feedback_cbs.get(feedback.event_type, context.default_feedback_cb)
        if call is not None:
            call(feedback)

    def _shown(self) -> list[Any]:
        return [context.int_marker for context in self.marker_contexts.values()]
