"""ROS 2 message, service and action classes, made from the texts of their definitions.

The definitions come from three places, the first that knows a name wins: folders of the
controller's own workspace, those of an installed ROS, and the archive that is shipped, with those
of Humble and of Jazzy.
A class is made when it is first asked for, with the classes of its fields.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from tracerisk.config import RosDistro
from tracerisk.errors import InputError, Location, one_of
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.messages.fields import snake_case
from tracerisk.ros.messages.interface_texts import (
    Definition,
    InterfaceStore,
    InterfaceText,
    interface_parts,
    parsed,
)
from tracerisk.ros.messages.misfits import Misfits
from tracerisk.ros.messages.ros2_base import Action2, Message2, Service2, copy_message
from tracerisk.ros.messages.ros2_fields import Field2, accessor

if TYPE_CHECKING:
    from rosbags.interfaces.typing import FieldDesc

__all__ = ["Action2", "Interfaces2", "Message2", "Service2", "copy_message", "snake_case"]

_PLACEHOLDER = "structure_needs_at_least_one_member"
_PARTS = {"srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}
# Of a name that the distribution of the run lacks, the definition of the other one is taken.
_DISTROS: dict[str, tuple[RosDistro, ...]] = {
    "humble": ("humble", "jazzy"),
    "jazzy": ("jazzy", "humble"),
}
# A field with a default: `float64 w 1`, `string<=9 name "arm"`, `int8[] steps [1, 2]`.
_DEFAULT = re.compile(r"\s*([\w/]+(?:<=\d+)?(?:\[[<=\d]*\])?)\s+(\w+)\s+([^=\s#].*?)\s*(?:#.*)?")


class Interfaces2(InterfaceStore):
    """The message packages of ROS 2 that are known, and the classes made of them so far.

    `rules` say which distribution's definitions count, and what becomes of values that do not fit.
    Without them, the definitions are those of Jazzy, and Humble's checks refuse such values.
    """

    kinds = ("msg", "srv", "action")

    def __init__(
        self,
        workspace: Mapping[str, Path] | None = None,
        more: Iterable[InterfaceText] = (),
        rules: DistroRules | None = None,
        installed: Mapping[str, Path] | None = None,
        on_used: Callable[[Path], None] = lambda _: None,
    ) -> None:
        distros = _DISTROS["jazzy" if rules is None else rules.name]
        super().__init__(workspace, more, installed, on_used, distros)
        self._misfits = Misfits(DistroRules("humble") if rules is None else rules)
        self._defaults: dict[str, dict[str, Any]] = {}

    def message_names(self, package: str) -> tuple[str, ...]:
        """Return the names of a package's messages, sorted."""
        return tuple(sorted(self._files(package, "msg")))

    def action_names(self, package: str) -> tuple[str, ...]:
        """Return the names of a package's actions, sorted."""
        return tuple(sorted(self._files(package, "action")))

    def names(self, package: str, kind: str) -> tuple[str, ...]:
        """Return the names that `from package.kind import ...` can take, sorted."""
        return {
            "msg": self.message_names,
            "srv": self.service_names,
            "action": self.action_names,
        }[kind](package)

    def modules(self, package: str, kind: str) -> tuple[str, ...]:
        """Return the modules below `package.kind`, as rosidl generates them: `_pose_stamped`."""
        return tuple(f"_{snake_case(name)}" for name in self.names(package, kind))

    def module_names(self, package: str, kind: str) -> tuple[str, ...]:
        """Return all names that a module of `package.kind` can give, parts included."""
        names = self.names(package, kind)
        parts = [f"{name}_{part}" for name in names for part in _PARTS.get(kind, ())]
        return (*names, *parts)

    def star_names(self, package: str, kind: str) -> tuple[str, ...]:
        """Return the modules that `from package.kind import *` brings besides classes: none."""
        del package, kind
        return ()

    def interface(self, package: str, kind: str, name: str) -> Any:
        """Return the class `name` of `package.kind`: a message, service, action, or its part.

        Raises:
            InputError: none is known, or its text is malformed.
        """
        full = f"{package}/{name}"
        if kind == "msg":
            return self.message(full)
        whole, _, part = name.partition("_")
        make = self.service if kind == "srv" else self.action
        made: Any = make(f"{package}/{whole}")
        return getattr(made, part) if part else made

    def message(self, name: str) -> type[Message2]:
        """Return the class of the message `package/Name`.

        Raises:
            InputError: no such message is known, or its text is malformed.
        """
        if name not in self._classes:
            package, short = name.split("/")
            self._define_message(package, short)
            self._classes[name] = self._make(package, "msg", short, short)
        made: type[Message2] = self._classes[name]
        return made

    def service(self, name: str) -> type[Service2]:
        """Return the class of the service `package/Name`.

        Raises:
            InputError: no such service is known, or its text is malformed.
        """
        if name not in self._services:
            self._services[name] = self._composite(name, "srv", Service2)
        made: type[Service2] = self._services[name]
        return made

    def action(self, name: str) -> type[Action2]:
        """Return the class of the action `package/Name`.

        Raises:
            InputError: no such action is known, or its text is malformed.
        """
        if name not in self._actions:
            self._actions[name] = self._composite(name, "action", Action2)
        made: type[Action2] = self._actions[name]
        return made

    def _composite(self, name: str, kind: str, base: type[Any]) -> Any:
        package, short = name.split("/")
        words = "service" if kind == "srv" else "action"
        self._check_package(package)
        files = self._files(package, kind)
        if short not in files:
            raise InputError(f"{package} has no {words} '{short}'; {one_of(sorted(files), short)}")
        path = files[short]
        body: dict[str, Any] = {
            "__module__": f"{package}.{kind}._{snake_case(short)}",
            "__doc__": f"The {words} {name}.",
            "_ros_type": name,
        }
        parts = _PARTS[kind]
        for part, text in zip(
            parts, interface_parts(self._text_of(path), len(parts), path), strict=True
        ):
            key = f"{short}_{part}"
            self._parse(package, kind, key, text, path)
            body[part] = self._make(package, kind, key, short)
        if kind == "srv":
            body["Event"] = _MadeLater(partial(self._event, package, short, body))
        if kind == "action":
            body["Impl"] = self._wrappers(package, short, body)
        return type(short, (base,), body)

    def _event(self, package: str, short: str, parts: Mapping[str, Any]) -> type[Message2]:
        """Make what reports a call of a service: at most one request, at most one response."""
        info = Field2(
            "info",
            "service_msgs/ServiceEventInfo",
            message=self.message("service_msgs/ServiceEventInfo"),
        )
        request_fields = (
            Field2(name.lower(), f"{package}/{short}_{name}", "sequence", 1, None, parts[name])
            for name in ("Request", "Response")
        )
        return _message_class(
            package, "srv", f"{short}_Event", short, (info, *request_fields), {}, self._misfits
        )

    def _wrappers(self, package: str, short: str, parts: Mapping[str, Any]) -> type:
        """Make what an action sends: its parts with the goal's id, status or time."""
        id_field = Field2(
            "goal_id",
            "unique_identifier_msgs/UUID",
            message=self.message("unique_identifier_msgs/UUID"),
        )
        stamp = Field2(
            "stamp", "builtin_interfaces/Time", message=self.message("builtin_interfaces/Time")
        )

        def nested(name: str, part: str) -> Field2:
            return Field2(name, f"{package}/{short}_{part}", message=parts[part])

        def made(suffix: str, *fields: Field2) -> type[Message2]:
            return _message_class(
                package, "action", f"{short}_{suffix}", short, fields, {}, self._misfits
            )

        send = {
            "_ros_type": f"{package}/{short}_SendGoal",
            "Request": made("SendGoal_Request", id_field, nested("goal", "Goal")),
            "Response": made("SendGoal_Response", Field2("accepted", "bool"), stamp),
        }
        get = {
            "_ros_type": f"{package}/{short}_GetResult",
            "Request": made("GetResult_Request", id_field),
            "Response": made(
                "GetResult_Response", Field2("status", "int8"), nested("result", "Result")
            ),
        }
        body = {
            "__doc__": f"What the action {package}/{short} sends.",
            "SendGoalService": type(f"{short}_SendGoal", (Service2,), send),
            "GetResultService": type(f"{short}_GetResult", (Service2,), get),
            "FeedbackMessage": made("FeedbackMessage", id_field, nested("feedback", "Feedback")),
            "CancelGoalService": self.service("action_msgs/CancelGoal"),
            "GoalStatusMessage": self.message("action_msgs/GoalStatusArray"),
        }
        return type("Impl", (), body)

    def _make(self, package: str, kind: str, short: str, of: str) -> type[Message2]:
        key = f"{package}/{kind}/{short}"
        constants, described = self._definitions[key]
        defaults = self._defaults.get(key, {})
        fields = tuple(
            self._field(f"{package}/{short}", name, description, defaults.get(name))
            for name, description in described
            if name != _PLACEHOLDER
        )
        values = {
            name: bytes([cast("int", value)]) if base == "byte" else value
            for name, base, value in constants
        }
        return _message_class(package, kind, short, of, fields, values, self._misfits)

    def _field(self, owner: str, name: str, description: FieldDesc, default: Any) -> Field2:
        from rosbags.interfaces import Nodetype

        # A tuple of tuples, (ARRAY, ((NAME, "geometry_msgs/msg/Pose"), 4)); its static type is
        # a union that no comparison narrows.
        kind, detail = cast("tuple[Nodetype, Any]", description)
        arranged = kind in (Nodetype.ARRAY, Nodetype.SEQUENCE)
        (inner_kind, inner), size = detail if arranged else ((kind, detail), 0)
        nested, longest = None, None
        if inner_kind == Nodetype.BASE:
            base, longest = inner[0], inner[1] or None
        else:
            base = inner.replace("/msg/", "/")
            try:
                nested = self.message(base)
            except InputError as error:
                raise InputError(f"field '{name}' of {owner}: {error.message}") from error
        arrangement: Any = "scalar"
        if arranged:
            arrangement = "array" if kind == Nodetype.ARRAY else "sequence"
        is_guessed = owner.partition("/")[0] in self.from_use
        made = Field2(name, base, arrangement, size or None, longest, nested, is_guessed=is_guessed)
        if default is None:
            return made
        fitting = _fitting(made, default)
        return Field2(name, base, arrangement, size or None, longest, nested, fitting)

    def _define_message(self, package: str, short: str) -> None:
        self._check_package(package)
        path = self._files(package, "msg").get(short)
        if path is None:
            names = self.message_names(package)
            raise InputError(f"{package} has no message '{short}'; {one_of(names, short)}")
        self._parse(package, "msg", short, self._text_of(path), path)

    def _check_package(self, package: str) -> None:
        if package not in self.packages:
            raise InputError(f"no message package '{package}'; {one_of(self.packages)}")

    def _parse(self, package: str, kind: str, short: str, text: str, path: Definition) -> None:
        from rosbags.typesys import TypesysError

        # Names of the same package stand without it; the parser takes them for messages.
        as_message = f"{package}/msg/{short}"
        plain = re.sub(r"(?m)^(\s*)wstring\b", r"\1string", text)
        key = f"{package}/{kind}/{short}"
        try:
            self._definitions[key] = parsed(plain, as_message)
        except TypesysError as error:
            message = str(error).splitlines()[-1]
            raise InputError(f"not a message definition: {message}", Location(str(path))) from error
        self._defaults[key] = _defaults(plain, path)


def _message_class(
    package: str,
    kind: str,
    short: str,
    of: str,
    fields: tuple[Field2, ...],
    constants: Mapping[str, Any],
    misfits: Misfits,
) -> type[Message2]:
    body: dict[str, Any] = {
        "__module__": f"{package}.{kind}._{snake_case(of)}",
        "__doc__": f"The message {package}/{short}.",
        "__slots__": [f"_{field.name}" for field in fields],
        "_ros_type": f"{package}/{short}",
        "_ros_fields": fields,
        "_misfits": misfits,
        "_fields_and_field_types": {field.name: field.type_text for field in fields},
        "SLOT_TYPES": tuple(field.type_text for field in fields),
    }
    body |= constants
    body |= {field.name: accessor(field, misfits) for field in fields}
    return type(short, (Message2,), body)


def _defaults(text: str, path: Definition) -> dict[str, Any]:
    defaults = {}
    for number, line in enumerate(text.splitlines(), 1):
        match = _DEFAULT.fullmatch(line)
        if match is None:
            continue
        kind, name, value = match.groups()
        if kind.partition("<")[0] == "string" and value[0] not in "\"'":
            defaults[name] = value
            continue
        try:
            defaults[name] = ast.literal_eval(_WithBools().visit(ast.parse(value, mode="eval")))
        except (ValueError, SyntaxError) as error:
            message = f"'{value}' is no default that a field can have"
            raise InputError(message, Location(str(path), number)) from error
    return defaults


class _MadeLater:
    """A class of a service that is made when it is first asked for: few programs do."""

    def __init__(self, make: Callable[[], type[Message2]]) -> None:
        self._make = make

    def __get__(self, instance: Any, owner: Any) -> type[Message2]:
        made = self._make()
        owner.Event = made
        return made


class _WithBools(ast.NodeTransformer):
    """Turns the words `true` and `false` of a definition into the values of Python."""

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Return what a word stands for."""
        known = {"true": True, "false": False}.get(node.id.lower())
        return node if known is None else ast.Constant(known)


def _fitting(field: Field2, value: Any) -> Any:
    if field.base in ("float32", "float64"):
        return [float(item) for item in value] if isinstance(value, list) else float(value)
    if field.base == "bool":
        return [bool(item) for item in value] if isinstance(value, list) else bool(value)
    if field.base == "byte":
        return [bytes([item]) for item in value] if isinstance(value, list) else bytes([value])
    return value
