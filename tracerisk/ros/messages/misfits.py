"""What becomes of values that do not fit their fields: an error, or the end of the process.

The classes of Humble assert at the assignment. Those of Jazzy take anything, and the C code
asserts when the message is sent: no `except` of the program sees that.
"""

from __future__ import annotations

from typing import Any, NoReturn

from tracerisk.ros.controller.frames import caller_beyond, is_of_tracerisk
from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.messages.ros2_fields import FLOAT_LIMITS, Field2

_OWN_FILES = ("messages/misfits.py", "messages/ros2_base.py", "messages/ros2_fields.py")
_FIELD = "field-of-wrong-type"
_NUMBERS = "whole-numbers-as-floats"
_KEYWORD = "unknown-keyword-of-message"


class Misfits:
    """By the rules of a distribution, what becomes of what does not fit."""

    def __init__(self, rules: DistroRules) -> None:
        self._rules = rules

    def are_taken(self, field: Field2) -> bool:
        """Return whether the field takes a value that does not fit; note that a rule decided it."""
        if is_of_tracerisk(caller_beyond(_OWN_FILES)):
            # Our own code has no such values but in whole numbers, which arrays convert.
            return True
        is_array = field.arrangement != "scalar" and field.base in FLOAT_LIMITS
        rule = _NUMBERS if is_array else _FIELD
        self._rules.decided(rule, asking_place())
        if is_array:
            return self._rules.value(rule) == "converted"
        return self._rules.value(rule) == "abort when sent"

    @property
    def knows_check_fields(self) -> bool:
        """Whether constructors have the keyword `check_fields`, which asks for checks."""
        return self._rules.value(_FIELD) == "abort when sent"

    def keywords_are_ignored(self) -> bool:
        """Return whether keywords that are no fields are ignored, and note that a rule decided."""
        self._rules.decided(_KEYWORD, asking_place())
        return self._rules.value(_KEYWORD) == "ignored"


def abort_sending(owner: str, field: Field2, value: Any, assertion: str) -> NoReturn:
    """End the process as a failed assertion in C does, where a message is sent."""
    current().scheduler.abort(
        f"the process aborted when it sent {owner}: field '{field.name}' is a "
        f"{type(value).__name__} and must be {field.type_text}; in the C code of the message "
        f"`{assertion}` fails, which no `except` catches",
        asking_place(),
    )
