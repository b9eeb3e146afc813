"""The menu of a marker."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from visualization_msgs.msg import InteractiveMarkerFeedback, MenuEntry

__all__ = ["EntryContext", "MenuHandler"]

_CHECKED = {1: "[x] ", 2: "[ ] "}


@dataclass
class EntryContext:
    """An entry of a menu."""

    title: str
    """What it shows."""
    command: str
    """What a viewer does by itself."""
    command_type: int
    """How a viewer does that."""
    feedback_cb: Callable[[Any], object] | None
    """The function that is called when it is chosen."""
    parent: int
    """The number of the entry above it, 0 for none."""
    sub_entries: list[int] = field(default_factory=list)
    """The numbers of the entries below it."""
    visible: bool = True
    """Whether it is shown."""
    check_state: int = 0
    """`NO_CHECKBOX`, `CHECKED` or `UNCHECKED`."""


class MenuHandler:
    """Makes a menu, and gives it to markers."""

    NO_CHECKBOX = 0
    CHECKED = 1
    UNCHECKED = 2

    def __init__(self) -> None:
        self.entry_contexts_: dict[int, EntryContext] = {}
        self.managed_markers_: set[str] = set()
        self.current_handle_ = 1

    def insert(
        self,
        title: str,
        parent: int | None = None,
        command_type: int = MenuEntry.FEEDBACK,
        command: str = "",
        callback: Callable[[Any], object] | None = None,
    ) -> int | None:
        """Add an entry, and return its number; None where there is no such parent."""
        if parent is not None and parent not in self.entry_contexts_:
            return None
        handle = self.current_handle_
        self.current_handle_ += 1
        self.entry_contexts_[handle] = EntryContext(
            title, command, command_type, callback, parent or 0
        )
        if parent is not None:
            self.entry_contexts_[parent].sub_entries.append(handle)
        return handle

    def setVisible(self, handle: int, visible: bool) -> bool:
        """Show or hide an entry; return whether there is one."""
        if handle not in self.entry_contexts_:
            return False
        self.entry_contexts_[handle].visible = visible
        return True

    def setCheckState(self, handle: int, check_state: int) -> bool:
        """Set the box of an entry; return whether there is one."""
        if handle not in self.entry_contexts_:
            return False
        self.entry_contexts_[handle].check_state = check_state
        return True

    def getCheckState(self, handle: int) -> int | None:
        """Return the state of an entry's box; None where there is no such entry."""
        entry = self.entry_contexts_.get(handle)
        return None if entry is None else entry.check_state

    def getTitle(self, handle: int) -> str | None:
        """Return what an entry shows; None where there is none."""
        entry = self.entry_contexts_.get(handle)
        return None if entry is None else entry.title

    def apply(self, server: Any, marker_name: str) -> bool:
        """Give a marker the menu; return whether there is one of that name."""
        marker = server.get(marker_name)
        if marker is None:
            self.managed_markers_.discard(marker_name)
            return False
        marker.menu_entries = [
            self._message(handle, entry)
            for handle, entry in self.entry_contexts_.items()
            if self._is_shown(entry)
        ]
        server.insert(marker)
        server.setCallback(marker_name, self.processFeedback, InteractiveMarkerFeedback.MENU_SELECT)
        self.managed_markers_.add(marker_name)
        return True

    def reApply(self, server: Any) -> bool:
        """Give the menu again to all markers that have it; return whether all are there."""
        applied = [self.apply(server, name) for name in sorted(self.managed_markers_)]
        return all(applied)

    def processFeedback(self, feedback: Any) -> None:
        """Call the function of the entry that was chosen."""
        entry = self.entry_contexts_.get(feedback.menu_entry_id)
        if entry is not None and entry.feedback_cb is not None:
            entry.feedback_cb(feedback)

    def _is_shown(self, entry: EntryContext) -> bool:
        above = self.entry_contexts_.get(entry.parent)
        return entry.visible and (above is None or self._is_shown(above))

    def _message(self, handle: int, entry: EntryContext) -> Any:
        message = MenuEntry()
        message.id, message.parent_id = handle, entry.parent
        message.title = f"{_CHECKED.get(entry.check_state, '')}{entry.title}"
        message.command, message.command_type = entry.command, entry.command_type
        return message
