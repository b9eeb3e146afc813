"""Drafts with what the repository itself writes in the place of a value of a type."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from tracerisk.pipeline.launch.program import program_of
from tracerisk.pipeline.scenarios.entries import Entries, merged, names_own_joints
from tracerisk.pipeline.scenarios.written_values import WrittenValues
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.ros.drafts.draft import Draft
from tracerisk.ros.drafts.drafted_topic import sent_in_turn

_PUBLISHERS = ("joint_state_publisher_gui", "joint_state_publisher", "joint_state_slider")
_CONTENT = {"topic": "message", "call": "request", "goal": "goal"}


class WrittenDrafts:
    """Puts the values that a controller's repository writes into drafts; notes their places."""

    def __init__(self, controller: Controller) -> None:
        self._top = controller.project.top
        script, root = controller.path.resolve(), controller.root.resolve()
        self._written = WrittenValues(self._top, program_of(script, root, controller.workspace))
        self._read: dict[str, str] = {}

    @property
    def arguments(self) -> tuple[tuple[tuple[str, ...], str], ...]:
        """The command lines with which the controller is started, each with its place."""
        return self._written.arguments

    def of(self, draft: Draft) -> Draft:
        """Return the draft with the value that the repository writes, if it does."""
        need = replace(draft.need, name=draft.key) if draft.need.kind == "parameter" else draft.need
        is_one_of_several = draft.key.endswith("]")
        written = None if is_one_of_several else self._written.of(need)
        if written is None:
            return self._as_published(draft)
        value = written.value
        if draft.need.kind == "frame":
            value = {**value, "frame": draft.need.name}
        elif draft.need.kind != "parameter":
            content = _CONTENT[draft.need.kind]
            if not names_own_joints(draft, value):
                return self._as_published(draft)
            if not written.is_whole:
                # The frame of a computed pose is not that of the one which stands in for it.
                value = {key: item for key, item in value.items() if key != "header"}
                if not value or content not in draft.value:
                    return self._as_published(draft)
                value = merged(draft.value[content], value)
            is_stream = "rate" in draft.value and "messages" not in draft.value
            in_turn = [item for item in written.in_turn if names_own_joints(draft, item)]
            if len(in_turn) > 1 and not is_stream:
                value = sent_in_turn(draft.value, in_turn)
            else:
                value = {**draft.value, content: value}
                value.pop("messages", None)
            if "messages" not in value and "messages" in draft.value:
                for key in ("rate", "count", "at"):
                    value.pop(key, None)
        words = f"as in {written.place}"
        self._read[words] = written.place
        return replace(draft, value=value, words=words)

    def _as_published(self, draft: Draft) -> Draft:
        if draft.need.kind != "topic" or draft.need.type_name != "sensor_msgs/JointState":
            return draft
        place = self._written.started_with(draft.need.name, _PUBLISHERS)
        if place is None:
            return draft
        words = f"{draft.words}; as {place} would"
        self._read[words] = place.rpartition(" in ")[2]
        return replace(draft, words=words)

    def read_for(self, entries: Entries) -> tuple[Path, ...]:
        """Return the files of the repository in which values of these entries are written."""
        reported = [draft.words for draft in entries.drafts.values()]
        places = [self._read[words] for words in reported if words in self._read]
        if entries.arguments is not None:
            written = {f"as in {place}": place for _, place in self._written.arguments}
            places += [
                written[remark] for remark in (entries.arguments.remark,) if remark in written
            ]
        return tuple(dict.fromkeys(self._top / place.rpartition(":")[0] for place in places))
