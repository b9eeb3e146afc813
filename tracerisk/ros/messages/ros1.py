"""ROS 1 message, service and action classes, made from the texts of their definitions.

The definitions come from three places, the first that knows a name wins: folders of the
controller's own workspace, those of an installed ROS, and the archive that is shipped, with those
of Noetic.
A class is made when it is first asked for, with the classes of its fields.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from hashlib import md5
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from tracerisk.errors import InputError, Location, one_of
from tracerisk.ros.messages.interface_texts import (
    Definition,
    InterfaceStore,
    InterfaceText,
    interface_parts,
    parsed,
)
from tracerisk.ros.messages.ros1_base import (
    PRIMITIVES,
    DeserializationError,
    Field,
    Message,
    MessageException,
    SerializationError,
)

if TYPE_CHECKING:
    from rosbags.interfaces.typing import FieldDesc

__all__ = [
    "DeserializationError",
    "Field",
    "Interfaces",
    "Message",
    "MessageException",
    "SerializationError",
    "Service",
]

_PLACEHOLDER = "structure_needs_at_least_one_member"
_CONSTANT = re.compile(r"^[ \t]*(\w+)[ \t]+(\w+)[ \t]*=(.*)$", re.MULTILINE)
_TIMES = {"builtin_interfaces/msg/Time": "time", "builtin_interfaces/msg/Duration": "duration"}
# Of an action X, ROS 1 makes seven messages; the first three are the parts of its text.
_ACTION_PARTS = ("Goal", "Result", "Feedback")
_ACTION_WRAPPERS = {
    "ActionGoal": "Header header\nactionlib_msgs/GoalID goal_id\n{name}Goal goal\n",
    "ActionResult": "Header header\nactionlib_msgs/GoalStatus status\n{name}Result result\n",
    "ActionFeedback": "Header header\nactionlib_msgs/GoalStatus status\n{name}Feedback feedback\n",
    "Action": "{name}ActionGoal action_goal\n{name}ActionResult action_result\n"
    "{name}ActionFeedback action_feedback\n",
}


class Service:
    """A ROS 1 service: the classes of its request and its response."""

    _type: str
    _md5sum: str
    _request_class: type[Message]
    _response_class: type[Message]


class _OfDefinition:
    """A class attribute that is computed from the message's name when it is read."""

    def __init__(self, compute: Callable[[str], str]) -> None:
        self._compute = compute

    def __get__(self, instance: Message | None, owner: type[Message]) -> str:
        return self._compute(owner._type)


class Interfaces(InterfaceStore):
    """The message packages of ROS 1 that are known, and the classes made of them so far."""

    kinds = ("msg", "srv")

    def __init__(
        self,
        workspace: Mapping[str, Path] | None = None,
        more: Iterable[InterfaceText] = (),
        installed: Mapping[str, Path] | None = None,
        on_used: Callable[[Path], None] = lambda _: None,
    ) -> None:
        super().__init__(workspace, more, installed, on_used)
        self._service_parts: set[str] = set()
        self._in_making: list[str] = []
        self._star_names: dict[tuple[str, str], tuple[str, ...]] = {}

    def message_names(self, package: str) -> tuple[str, ...]:
        """Return the names of a package's messages, those of its actions included, sorted."""
        names = set(self._files(package, "msg"))
        for name in self._files(package, "action"):
            names.update(name + part for part in (*_ACTION_PARTS, *_ACTION_WRAPPERS))
        return tuple(sorted(names))

    def star_names(self, package: str, kind: str) -> tuple[str, ...]:
        """Return the modules that `from package.kind import *` brings besides classes, sorted.

        The modules that genpy generates import what they need, and have no `__all__`: programs
        use those names, knowingly or not.
        """
        key = package, kind
        if key not in self._star_names:
            classes = [self.interface(*key, name) for name in self.module_names(*key)]
            fields = (field for class_ in classes for field in getattr(class_, "_fields", ()))
            packages = {field.base.split("/")[0] for field in fields if field.message is not None}
            self._star_names[key] = tuple(sorted({*packages, "codecs", "genpy", "struct", "sys"}))
        return self._star_names[key]

    def modules(self, package: str, kind: str) -> tuple[str, ...]:
        """Return the modules below `package.kind`, as genpy generates them: `_PoseStamped`."""
        names = self.message_names if kind == "msg" else self.service_names
        return tuple(f"_{name}" for name in names(package))

    def module_names(self, package: str, kind: str) -> tuple[str, ...]:
        """Return all names that `package.kind` gives, requests and responses included."""
        if kind == "msg":
            return self.message_names(package)
        services = self.service_names(package)
        return tuple(name + part for name in services for part in ("", "Request", "Response"))

    def interface(self, package: str, kind: str, name: str) -> Any:
        """Return the class `name` of `package.kind`.

        Raises:
            InputError: none is known, or its text is malformed.
        """
        if kind == "srv" and name in self._files(package, "srv"):
            return self.service(f"{package}/{name}")
        return self.message(f"{package}/{name}")

    def message(self, name: str) -> type[Message]:
        """Return the class of `package/Name`.

        Raises:
            InputError: no such message is known, or its text is malformed.
        """
        if name not in self._classes:
            self._classes[name] = self._make(name)
        made: type[Message] = self._classes[name]
        return made

    def service(self, name: str) -> type[Service]:
        """Return the class of the service `package/Name`.

        Raises:
            InputError: no such service is known, or its text is malformed.
        """
        if name not in self._services:
            package, short = name.split("/")
            self._define_service(package, short)
            request, response = self.message(f"{name}Request"), self.message(f"{name}Response")
            body = {
                "__module__": f"{package}.srv._{short}",
                "__doc__": f"The service {name}.",
                "_type": name,
                "_request_class": request,
                "_response_class": response,
                "_md5sum": self._md5(request._type, response._type),
            }
            self._services[name] = type(short, (Service,), body)
        made: type[Service] = self._services[name]
        return made

    def _make(self, name: str) -> type[Message]:
        package, _, short = name.partition("/")
        if not package.isidentifier() or not short.isidentifier():
            raise InputError(f"'{name}' is not a message type; write PACKAGE/NAME")
        if name in self._in_making:
            raise InputError(f"{name} contains itself, by way of {', '.join(self._in_making)}")
        self._in_making.append(name)
        try:
            return self._made(name, package, short)
        finally:
            self._in_making.pop()

    def _made(self, name: str, package: str, short: str) -> type[Message]:
        constants, described = self._definition(package, short)
        fields = tuple(
            self._field(name, field_name, description)
            for field_name, description in described
            if field_name != _PLACEHOLDER
        )
        named = [*(constant for constant, _, _ in constants), *(field.name for field in fields)]
        twice = sorted({item for item in named if named.count(item) > 1})
        if twice:
            raise InputError(f"{name} has two of the name {', '.join(twice)}; rename one")
        folder = "srv" if name in self._service_parts else "msg"
        body: dict[str, Any] = {
            "__module__": f"{package}.{folder}._{short}",
            "__doc__": f"The message {name}.",
            "__slots__": [field.name for field in fields],
            "_type": name,
            "_slot_types": [field.type_text for field in fields],
            "_fields": fields,
            "_has_header": any(field.base == "std_msgs/Header" for field in fields[:1]),
            "_full_text": _OfDefinition(self._full_text),
            "_md5sum": _OfDefinition(self._md5),
        }
        return type(short, (Message,), body | {constant: value for constant, _, value in constants})

    def _field(self, owner: str, name: str, description: FieldDesc) -> Field:
        from rosbags.interfaces import Nodetype

        # A tuple of tuples, (ARRAY, ((NAME, "geometry_msgs/msg/Pose"), 4)); its static type is
        # a union that no comparison narrows.
        kind, detail = cast("tuple[Nodetype, Any]", description)
        is_array = kind in (Nodetype.ARRAY, Nodetype.SEQUENCE)
        (inner_kind, inner), size = detail if is_array else ((kind, detail), 0)
        base = inner[0] if inner_kind == Nodetype.BASE else _short_reference(inner)
        nested = None
        if base not in PRIMITIVES:
            try:
                nested = self.message(base)
            except InputError as error:
                raise InputError(f"field '{name}' of {owner}: {error.message}") from error
        return Field(name, base, is_array, size if kind == Nodetype.ARRAY else None, nested)

    def _definition(self, package: str, short: str) -> Any:
        """Return (constants, fields) of a message, parsing the file that holds it once."""
        key = f"{package}/msg/{short}"
        if key not in self._definitions and not self._define(package, short):
            if package not in self.packages:
                raise InputError(f"no message package '{package}'; {one_of(self.packages)}")
            names = self.message_names(package)
            raise InputError(f"{package} has no message '{short}'; {one_of(names, short)}")
        return self._definitions[key]

    def _define(self, package: str, short: str) -> bool:
        path = self._files(package, "msg").get(short)
        if path is not None:
            self._parse(package, short, self._text_of(path), path)
            return True
        for suffix in (*_ACTION_PARTS, *_ACTION_WRAPPERS):
            name = short.removesuffix(suffix)
            path = self._files(package, "action").get(name) if name != short else None
            if path is not None:
                self._define_action(package, path)
                return True
        for suffix in ("Request", "Response"):
            name = short.removesuffix(suffix)
            if name != short and name in self._files(package, "srv"):
                self._define_service(package, name)
                return True
        return False

    def _define_action(self, package: str, path: Definition) -> None:
        name, parts = path.stem, interface_parts(self._text_of(path), 3, path)
        for part, text in zip(_ACTION_PARTS, parts, strict=True):
            self._parse(package, name + part, text, path)
        for wrapper, text in _ACTION_WRAPPERS.items():
            self._parse(package, name + wrapper, text.format(name=name), path)

    def _define_service(self, package: str, name: str) -> None:
        path = self._files(package, "srv").get(name)
        if path is None:
            names = self.service_names(package)
            raise InputError(f"{package} has no service '{name}'; {one_of(names, name)}")
        request, response = interface_parts(self._text_of(path), 2, path)
        self._parse(package, f"{name}Request", request, path)
        self._parse(package, f"{name}Response", response, path)
        self._service_parts |= {f"{package}/{name}Request", f"{package}/{name}Response"}

    def _parse(self, package: str, short: str, text: str, path: Definition) -> None:
        from rosbags.typesys import TypesysError

        name = f"{package}/msg/{short}"
        written = [(key, value.strip()) for _, key, value in _CONSTANT.findall(text)]
        try:
            constants, fields = parsed(_plain_constants(text), name)
            own = [
                (key, kind, said if kind == "string" else value)
                for (key, said), (_, kind, value) in zip(written, constants, strict=True)
            ]
            self._definitions.update({name: (own, fields)})
        except TypesysError as error:
            line = str(error).splitlines()[-1]
            raise InputError(f"not a message definition: {line}", Location(str(path))) from error

    def _full_text(self, name: str) -> str:
        from rosbags.typesys.store import Typestore

        store = Typestore()
        store.fielddefs = self._definitions
        return store.generate_msgdef(name.replace("/", "/msg/"))[0]

    def _md5_text(self, name: str) -> str:
        """Return what ROS 1 hashes: constants, then fields, nested types as their own hash."""
        constants, _ = self._definition(*name.split("/"))
        lines = [f"{kind} {constant}={value}" for constant, kind, value in constants]
        for field in self.message(name)._fields:
            nested = field.message is not None
            lines.append(f"{self._md5(field.base) if nested else field.type_text} {field.name}")
        return "\n".join(lines)

    def _md5(self, *names: str) -> str:
        text = "".join(self._md5_text(name) for name in names)
        return md5(text.encode(), usedforsecurity=False).hexdigest()


def _short_reference(name: str) -> str:
    return _TIMES.get(name, name.replace("/msg/", "/"))


def _plain_constants(text: str) -> str:
    """Return a definition whose constants rosbags takes: it refuses small letters in their names.

    All that follows the sign of a constant of text is that text: quotes, `#` and nothing as well.
    """
    number = count()

    def plain(match: re.Match[str]) -> str:
        kind, _, value = match.groups()
        return f"{kind} C{next(number)}={'text' if kind == 'string' else value}"

    return _CONSTANT.sub(plain, text)
